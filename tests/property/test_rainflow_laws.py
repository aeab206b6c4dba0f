"""Laws of counting: cuts, repeats, mirrors and crossings change nothing they should not."""

import itertools

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from cardan.physics.fatigue import rainflow_kernels as kernel
from cardan.physics.fatigue.rainflow import (
    FromToMatrix,
    concatenate_cycles,
    discarded,
    four_point,
    four_point_of_many_signals,
    half_cycles,
    omit_small_cycles,
    rainflow,
    rainflow_of_cause_coalitions,
    range_pairs,
    repeating,
)
from cardan.physics.fatigue.rainflow_kernels import (
    extract_closed_cycles_without_numba,
    fastest_kernel,
    omit_small_reversals_into,
)

whole = arrays(np.float64, st.integers(0, 60), elements=st.integers(-8, 8).map(float))
pieces = st.lists(whole, min_size=1, max_size=6)
modest = settings(max_examples=150)


def in_pieces(parts):
    closed, residue = [], np.empty(0)
    for part in parts:
        cycles, residue = four_point(part, residue=residue)
        closed.append(cycles)
    return concatenate_cycles(closed), residue


def table(cycles):
    """Cycles as a sorted table of (low, high, count)."""
    low = np.minimum(cycles.start, cycles.end)
    rows, place = np.unique(np.stack([low, cycles.top], -1), axis=0, return_inverse=True)
    return rows.tolist(), np.bincount(place.ravel(), cycles.count).tolist()


@pytest.mark.slow
@modest
@given(parts=pieces)
def test_pieces_count_as_whole_signal(parts):
    cycles, residue = in_pieces(parts)
    once, left = four_point(np.concatenate(parts))
    assert table(cycles) == table(once)
    assert residue.tolist() == left.tolist()


@pytest.mark.slow
@modest
@given(parts=pieces)
def test_separately_counted_pieces_join_by_residues(parts):
    apart = [four_point(part) for part in parts]
    between, residue = in_pieces([left for _, left in apart])
    once, left = four_point(np.concatenate(parts))
    assert table(concatenate_cycles([*(c for c, _ in apart), between])) == table(once)
    assert residue.tolist() == left.tolist()


@modest
@given(x=whole)
def test_compiled_and_plain_loops_agree(x):
    fast, left = four_point(x, kernel=fastest_kernel())
    slow, rest = four_point(x, kernel=extract_closed_cycles_without_numba)
    assert fast.start.tolist() == slow.start.tolist()
    assert fast.end.tolist() == slow.end.tolist()
    assert left.tolist() == rest.tolist()


def astm(points):
    """Count as ASTM E1049 section 5.4.4 words it, reversal by reversal."""
    turns = [p for i, p in enumerate(points) if i == 0 or p != points[i - 1]]
    turns = [
        p
        for i, p in enumerate(turns)
        if i in (0, len(turns) - 1) or (p - turns[i - 1]) * (turns[i + 1] - p) < 0
    ]
    stack, out = [], []
    for point in turns:
        stack.append(point)
        while len(stack) >= 3 and abs(stack[-1] - stack[-2]) >= abs(stack[-2] - stack[-3]):
            if len(stack) == 3:
                out.append((stack[0], stack[1], 0.5))
                stack.pop(0)
            else:
                out.append((stack[-3], stack[-2], 1.0))
                del stack[-3:-1]
    return out + [(a, b, 0.5) for a, b in itertools.pairwise(stack)]


@pytest.mark.slow
@modest
@given(x=whole)
def test_four_point_counting_with_half_cycles_matches_standard(x):
    from cardan.physics.fatigue.rainflow import Cycles

    rows = np.array(astm(x.tolist())).reshape(-1, 3)
    assert table(rainflow(x)) == table(Cycles(*rows.T))


@modest
@given(x=whole)
def test_repeated_history_closes_equal_cycles_in_each_repeat(x):
    per_repeat = table(rainflow(x, rule=repeating))
    two, three = four_point(np.tile(x, 2))[0], four_point(np.tile(x, 3))[0]
    later = three.count.sum() - two.count.sum()
    assert later == sum(per_repeat[1])


@modest
@given(x=whole)
def test_inverted_signal_gives_equal_ranges(x):
    up, down = rainflow(x), rainflow(-x)
    assert sorted(up.range) == sorted(down.range)


@modest
@given(x=whole)
def test_missing_samples_are_skipped(x):
    holes = np.insert(x, np.arange(x.size), np.nan)
    assert table(rainflow(holes)) == table(rainflow(x))


@pytest.mark.slow
@modest
@given(parts=pieces)
def test_rainflow_matrix_is_independent_of_cuts(parts):
    closed, _ = four_point(np.concatenate(parts))
    in_one = FromToMatrix.empty(bins=8, width=0.25).with_cycles(closed)
    grown = FromToMatrix.empty(bins=8, width=0.25)
    residue = np.empty(0)
    for part in parts:
        cycles, residue = four_point(part, residue=residue)
        grown = grown.with_cycles(cycles)
    assert grown.width == in_one.width
    assert (grown.counts == in_one.counts).all()
    assert grown.counts.sum() == closed.count.sum()


def test_rainflow_matrix_keeps_cycles_within_bin():
    x = np.random.default_rng(1).normal(size=5000)
    cycles = rainflow(x)
    matrix = FromToMatrix.empty().with_cycles(cycles)
    assert matrix.cycles().count.sum() == cycles.count.sum()
    binned = np.average(matrix.cycles().range, weights=matrix.cycles().count)
    assert abs(binned - np.average(cycles.range, weights=cycles.count)) < matrix.width / 2


def test_range_pairs_cumulate_cycles_from_above():
    cycles = rainflow(np.random.default_rng(2).normal(size=3000))
    edges = np.linspace(0, 12, 13)
    counted, _ = np.histogram(cycles.range, edges, weights=cycles.count)
    pairs = range_pairs(cycles, ranges=edges)
    np.testing.assert_allclose(counted, -np.diff(pairs))
    assert pairs[0] == cycles.count.sum()
    standard = rainflow([-2, 1, -3, 5, -1, 3, -4, 4, -2])
    assert range_pairs(standard, ranges=[4, 9, 9.5]).tolist() == [3.5, 0.5, 0]


def test_discarded_residue_omits_largest_cycle():
    x = np.random.default_rng(3).normal(size=3000)
    assert rainflow(x, rule=discarded).range.max() < np.ptp(x)
    assert rainflow(x, rule=half_cycles).range.max() == np.ptp(x)
    assert rainflow(x, rule=repeating).range.max() == np.ptp(x)


@pytest.mark.parametrize("bad", [[[1.0, 2.0]], [0.0, np.inf, 0.0], [1, np.inf, 0, np.inf, 0, 9]])
def test_invalid_counting_input_is_rejected(bad):
    with pytest.raises(ValueError, match="must be"):
        rainflow(bad)


@modest
@given(st.lists(st.floats(-100, 100, width=16), min_size=1, max_size=60), st.floats(0.1, 60))
def test_gate_omits_only_small_cycles(values, gate):
    """All cycles of a range above the gate close as if nothing had been left out."""
    x = np.array(values)
    some, every = rainflow(gated_plain(x, gate)), rainflow(x)

    def large(cycles):
        keep = cycles.range > gate
        pairs = np.stack([cycles.top[keep], cycles.range[keep], cycles.count[keep]], -1)
        return pairs[np.lexsort(pairs.T)]

    np.testing.assert_allclose(large(some), large(every))
    np.testing.assert_array_equal(omit_small_cycles(x, gate=gate), gated_plain(x, gate))


def gated_plain(x, gate):
    out = np.empty(x.size + 2)
    return out[: omit_small_reversals_into(x, gate, out)].copy()


@pytest.fixture(params=["compiled", "plain"])
def loops(request, monkeypatch):
    if request.param == "plain":
        monkeypatch.setattr(kernel, "_compiled", lambda _: None)


@pytest.mark.slow
@pytest.mark.usefixtures("loops")
@pytest.mark.parametrize("seed", range(5))
def test_every_subset_of_parts_is_counted_as_its_sum(seed):
    """Two stretches one after the other, the parts of each added by NumPy; whole numbers: exact."""
    rng = np.random.default_rng(seed)
    k = int(rng.integers(1, 6))  # 5 of them are two goes of sixteen
    stretches = [rng.integers(-9, 10, (k, int(rng.integers(1, 80)))).astype(float) for _ in "ab"]
    open_now = [np.empty(0)] * (1 << k)
    closed = {c: [] for c in range(1 << k)}
    for parts in stretches:
        before = list(open_now)
        for choices, rows in rainflow_of_cause_coalitions(parts, gate=0.0, residues=before):
            for n, (choice, left) in enumerate(zip(choices, rows.residues, strict=True)):
                open_now[choice] = left
                mine = rows.row == n
                closed[choice].append(
                    type(rows.cycles)(*(v[mine] for v in vars(rows.cycles).values()))
                )
    whole = np.concatenate(stretches, axis=-1)
    for choice in range(1 << k):
        bits = choice >> np.arange(k) & 1
        cycles, left = four_point(bits @ whole)
        assert table(concatenate_cycles(closed[choice])) == table(cycles), choice
        assert open_now[choice].tolist() == left.tolist()


@pytest.mark.slow
@pytest.mark.usefixtures("loops")
@modest
@given(rows=pieces, residues=pieces)
def test_batched_rows_are_counted_as_single_rows(rows, residues):
    n = min(len(rows), len(residues))
    before = [four_point(r)[1] for r in residues[:n]]
    found = four_point_of_many_signals(rows[:n], residues=before)
    for k, (x, residue) in enumerate(zip(rows[:n], before, strict=True)):
        cycles, left = four_point(x, residue=residue)
        assert found.residues[k].tolist() == left.tolist()
        assert found.cycles.start[found.row == k].tolist() == cycles.start.tolist()
        assert found.cycles.end[found.row == k].tolist() == cycles.end.tolist()
