"""Rainflow matrices are histograms of the exact cycles, however the signal was cut and merged."""

import numpy as np
import pytest

from cardan.physics.fatigue.damage import miner_damage
from cardan.physics.fatigue.rainflow import FromToMatrix, four_point, half_cycles, rainflow
from cardan.physics.fatigue.rainflow_matrix import (
    RainflowTable,
    RangeMeanMatrix,
    from_to_table,
    merge_tables,
)
from cardan.physics.fatigue.sn_curve import SNCurve

RNG = np.random.default_rng(5)


def tables(samples, pieces=7):
    """Return both matrices of a signal that comes in pieces."""
    residue, from_to, range_mean = np.empty(0), FromToMatrix.empty(), RangeMeanMatrix.empty()
    for piece in np.array_split(samples, pieces):
        closed, residue = four_point(piece, residue=residue)
        from_to, range_mean = from_to.with_cycles(closed), range_mean.with_cycles(closed)
    left = half_cycles(residue)
    return from_to_table(from_to.with_cycles(left)), range_mean.with_cycles(left).nonempty_bins()


def check_histogram(table, along, across, weights):
    edges = [table.width * np.arange(k.min(), k.max() + 2) for k in (table.row, table.column)]
    expected, *_ = np.histogram2d(along, across, bins=edges, weights=weights)
    found = np.zeros_like(expected)
    found[table.row - table.row.min(), table.column - table.column.min()] = table.count
    np.testing.assert_allclose(found, expected)
    assert table.total == pytest.approx(weights.sum())


def growing_walk(n=20_000):
    """A signal whose range grows, so that bins are doubled on the way; never on an edge."""
    return np.cumsum(RNG.standard_normal(n)) * np.linspace(0.01, 1, n) - 3.1


def test_matrices_are_histograms_of_exact_cycles():
    x = growing_walk()
    cycles = rainflow(x)
    from_to, range_mean = tables(x)
    check_histogram(from_to, cycles.start, cycles.end, cycles.count)
    check_histogram(range_mean, cycles.range, cycles.mean, cycles.count)


def test_merged_matrices_are_those_of_both_signals():
    """Bins of two widths, and one of the two driven three times."""
    small, large = growing_walk(4000), 20 * growing_walk(3000)
    for one, other in zip(tables(small), tables(large), strict=True):
        assert other.width > one.width
        both = merge_tables([(one, 1.0), (other, 3.0)])
        cycles = [rainflow(small), rainflow(large)]
        weights = np.concatenate([cycles[0].count, 3 * cycles[1].count])
        axes = ("start", "end") if one.kind == "from-to" else ("range", "mean")
        along, across = (np.concatenate([getattr(c, a) for c in cycles]) for a in axes)
        check_histogram(both, along, across, weights)
        again = other.merged(one, times=1 / 3)
        np.testing.assert_allclose(3 * again.count, both.count)


def test_damage_of_bin_middles_is_that_of_the_cycles():
    x = 3e6 * growing_walk()
    curve = SNCurve(amplitude=30e6, cycles=2e6, slope=5)
    exact = miner_damage(rainflow(x), curve=curve)
    for table in tables(x):
        assert miner_damage(table.cycles(), curve=curve) == pytest.approx(exact, rel=0.02)


def test_matrices_of_different_axes_are_not_merged():
    one, other = tables(growing_walk(500))
    with pytest.raises(ValueError, match="from-to and a range-mean"):
        one.merged(other)
    empty = RainflowTable(
        kind="from-to", width=2.0**-20, row=np.empty(0, int), column=np.empty(0, int),
        count=np.empty(0),
    )  # fmt: skip
    assert one.merged(empty).total == empty.merged(one).total == one.total
