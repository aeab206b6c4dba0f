"""Small matrices of many cases, against LAPACK and NumPy one by one."""

import numpy as np
import pytest

from cardan.core.batched_linalg import (
    LAPACK_MAX_CASES,
    MATMUL_MIN_ROWS,
    append_column,
    broadcast_cases,
    cache_blocks,
    matrix_axes_first,
    matrix_axes_last,
    matrix_product,
    move_valid_points_to_front,
    slice_case_block,
    solve,
)

random = np.random.default_rng(3)


def some(*shape: int) -> np.ndarray:
    return random.normal(size=shape) + 1j * random.normal(size=shape)


MANY = 3 * LAPACK_MAX_CASES


@pytest.mark.parametrize("count", [LAPACK_MAX_CASES, MANY])
@pytest.mark.parametrize(("N", "columns"), [(1, 1), (2, 3), (4, 5), (10, 6)])
def test_solve_matches_lapack(N, columns, count):
    """To rounding, 1e-16, times what matrices of these sizes magnify it by: under 1e5."""
    a, b = some(count, N, N), some(count, N, columns)
    found = matrix_axes_last(solve(matrix_axes_first(a, of=2), matrix_axes_first(b, of=2)), of=2)
    right = np.linalg.solve(a, b)
    assert np.abs(found - right).max() < 1e-9 * np.abs(right).max()
    np.testing.assert_allclose(a @ found, b, atol=1e-11 * np.abs(found).max())


def test_solve_broadcasts_matrices_and_right_hand_sides():
    a, b = matrix_axes_first(some(6, 3, 3), of=2), some(3, 2)
    for k, found in enumerate(np.moveaxis(solve(a, broadcast_cases(b, 1, of=2)), -1, 0)):
        np.testing.assert_allclose(found, np.linalg.solve(a[..., k], b), rtol=1e-10)
    several = solve(broadcast_cases(a[..., 0], 1, of=2), np.stack([b, 2 * b], axis=-1))
    np.testing.assert_allclose(several[..., 1], 2 * several[..., 0], rtol=1e-12)


def test_solve_uses_lapack_if_pivoting_is_needed():
    """A zero, and a number of 1e-20, where the first row starts."""
    a = np.array([[[0.0, 1.0], [1e-20, 1.0], [2.0, 1.0]], [[1.0, 0.0], [1.0, 1.0], [1.0, 3.0]]])
    a = np.tile(np.moveaxis(a, 1, -1), MANY)
    b = np.tile(np.stack([np.full((1, 3), 1.0), np.full((1, 3), 2.0)]), MANY)
    found = solve(a, b)
    for k in range(3 * MANY):
        np.testing.assert_allclose(found[..., k], np.linalg.solve(a[..., k], b[..., k]), rtol=1e-12)
    with pytest.raises(np.linalg.LinAlgError):
        solve(np.zeros((2, 2, 3)), b[..., :3])
    with pytest.raises(np.linalg.LinAlgError):
        solve(np.zeros((2, 2, 3 * MANY)), b)


@pytest.mark.parametrize(("count", "N"), [(7, 4), (MANY, 4), (MANY, MATMUL_MIN_ROWS)])
def test_product_and_column_join_match_numpy(count, N):
    a, b, v = some(count, 3, N), some(count, N, 2), some(count, N)
    first = matrix_product(matrix_axes_first(a, of=2), matrix_axes_first(b, of=2))
    np.testing.assert_allclose(matrix_axes_last(first, of=2), a @ b, rtol=1e-12, atol=1e-12)
    onto = matrix_product(matrix_axes_first(a, of=2), matrix_axes_first(v, of=1))
    np.testing.assert_allclose(
        matrix_axes_last(onto, of=1), (a @ v[..., None])[..., 0], rtol=1e-12, atol=1e-12
    )
    both = append_column(matrix_axes_first(b, of=2), matrix_axes_first(v, of=1))
    assert both.shape == (N, 3, count)
    np.testing.assert_array_equal(matrix_axes_last(both, of=2)[..., 2], v)


def test_single_case_needs_no_batch_axis():
    a, b, v = some(3, 3), some(3, 2), some(3)
    np.testing.assert_allclose(matrix_product(a, v), a @ v, rtol=1e-12)
    np.testing.assert_allclose(matrix_product(a, b), a @ b, rtol=1e-12)
    np.testing.assert_allclose(solve(a, b), np.linalg.solve(a, b), rtol=1e-9)


def test_case_blocks_cover_every_case_once():
    cases = (30, 100, 7)
    seen = np.zeros(cases)
    sizes = [slice_case_block(seen, of).size for of in cache_blocks(cases)]
    for of in cache_blocks(cases):
        slice_case_block(seen, of)[...] += 1
    assert (seen == 1).all()
    assert max(sizes) <= 1500 < sum(sizes)
    shared = np.zeros((1, 7))
    assert all(slice_case_block(shared, of) is shared for of in cache_blocks(cases))
    assert list(cache_blocks((9,))) == [slice(None)]


def test_packed_points_are_unique():
    """Those that are not there, and those that come again, cost nothing."""
    one = random.integers(0, 3, size=(12, 5, 4)).astype(float)
    other = random.integers(0, 2, size=one.shape).astype(float)
    there = random.uniform(size=one.shape) < np.array([0.0, 0.2, 0.6, 1.0])
    (first, second), counts, place = move_valid_points_to_front(there, one, other)
    for v in range(5):
        for s in range(4):
            here = [(one[p, v, s], other[p, v, s]) for p in range(12) if there[p, v, s]]
            kept = list(dict.fromkeys(here))
            assert list(zip(first[:, v, s], second[:, v, s], strict=True))[: len(kept)] == kept
            at = [int(place[p, v, s]) for p in range(12) if there[p, v, s]]
            assert at == [kept.index(h) for h in here]
            assert len(kept) <= counts[s]
    assert counts[0] == 0 < counts[1] < counts[2] <= counts[3] <= 6
