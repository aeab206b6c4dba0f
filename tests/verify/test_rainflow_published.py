"""Rainflow counting against ASTM E1049-85 (2017), section 5.4.4, figure 6, and three packages."""

import numpy as np
import pytest

from cardan.physics.fatigue.rainflow import four_point, rainflow, repeating

HISTORY = [-2, 1, -3, 5, -1, 3, -4, 4, -2]
TABLE = {3: 0.5, 4: 1.5, 6: 0.5, 8: 1.0, 9: 0.5}  # range: cycles


@pytest.mark.parametrize(("size", "cycles"), TABLE.items())
def test_counts_match_astm_e1049(size, cycles):
    counted = rainflow(HISTORY)
    assert counted.count[counted.range == size].sum() == cycles  # whole numbers: exact
    assert counted.count.sum() == sum(TABLE.values())


def test_repeating_history_matches_astm_e1049():
    """Section 5.4.5: begun at its peak the history runs 5 -1 3 -4 4 -2 1 -3 and back to 5.

    By hand that closes -1..3 (4), -2..1 (3), 4..-3 (7) and 5..-4 (9), each once.
    """
    counted = rainflow(HISTORY, rule=repeating)
    assert sorted(counted.range) == [3, 4, 7, 9]
    assert set(counted.count) == {1}


def noise():
    rng = np.random.default_rng(7)
    return np.convolve(rng.normal(size=20_000), np.ones(5) / 5, "same")


def histogram(ranges, counts):
    unique, place = np.unique(np.round(ranges, 9), return_inverse=True)
    return unique, np.bincount(place, counts)


@pytest.mark.oracle
def test_counts_match_rainflow_package():
    import rainflow as oracle

    x = noise()
    found = [(r, c) for r, _, c, _, _ in oracle.extract_cycles(x)]
    ours = rainflow(x)
    for one, other in zip(
        histogram(*np.transpose(found)), histogram(ours.range, ours.count), strict=True
    ):
        np.testing.assert_allclose(one, other, rtol=0, atol=2e-9)  # rounding of `histogram`


@pytest.mark.oracle
def test_counts_match_pylife():
    from pylife.stress.rainflow import FourPointDetector, FullRecorder

    x = noise()
    recorder = FullRecorder()
    FourPointDetector(recorder=recorder).process(x).flush()
    cycles, _ = four_point(x)
    theirs = np.sort(np.abs(np.asarray(recorder.values_to) - np.asarray(recorder.values_from)))
    np.testing.assert_allclose(theirs, np.sort(cycles.range), rtol=1e-12)
