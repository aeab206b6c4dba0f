"""Small matrices of many cases, against LAPACK and NumPy one by one."""

import numpy as np
import pytest

from cardan.base.small import (
    FEW,
    LARGE,
    beside,
    leading,
    packed,
    product,
    solve,
    stretch,
    stretches,
    trailing,
    wide,
)

random = np.random.default_rng(3)


def some(*shape: int) -> np.ndarray:
    return random.normal(size=shape) + 1j * random.normal(size=shape)


MANY = 3 * FEW


@pytest.mark.parametrize("count", [FEW, MANY])
@pytest.mark.parametrize(("N", "columns"), [(1, 1), (2, 3), (4, 5), (10, 6)])
def test_solutions_are_those_of_lapack(N, columns, count):
    """To rounding, 1e-16, times what matrices of these sizes magnify it by: under 1e5."""
    a, b = some(count, N, N), some(count, N, columns)
    found = trailing(solve(leading(a, of=2), leading(b, of=2)), of=2)
    right = np.linalg.solve(a, b)
    assert np.abs(found - right).max() < 1e-9 * np.abs(right).max()
    np.testing.assert_allclose(a @ found, b, atol=1e-11 * np.abs(found).max())


def test_one_matrix_serves_many_sides_and_one_side_many_matrices():
    a, b = leading(some(6, 3, 3), of=2), some(3, 2)
    for k, found in enumerate(np.moveaxis(solve(a, wide(b, 1, of=2)), -1, 0)):
        np.testing.assert_allclose(found, np.linalg.solve(a[..., k], b), rtol=1e-10)
    several = solve(wide(a[..., 0], 1, of=2), np.stack([b, 2 * b], axis=-1))
    np.testing.assert_allclose(several[..., 1], 2 * several[..., 0], rtol=1e-12)


def test_what_needs_its_rows_exchanged_is_left_to_lapack():
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


@pytest.mark.parametrize(("count", "N"), [(7, 4), (MANY, 4), (MANY, LARGE)])
def test_products_and_columns(count, N):
    a, b, v = some(count, 3, N), some(count, N, 2), some(count, N)
    first = product(leading(a, of=2), leading(b, of=2))
    np.testing.assert_allclose(trailing(first, of=2), a @ b, rtol=1e-12, atol=1e-12)
    onto = product(leading(a, of=2), leading(v, of=1))
    np.testing.assert_allclose(
        trailing(onto, of=1), (a @ v[..., None])[..., 0], rtol=1e-12, atol=1e-12
    )
    both = beside(leading(b, of=2), leading(v, of=1))
    assert both.shape == (N, 3, count)
    np.testing.assert_array_equal(trailing(both, of=2)[..., 2], v)


def test_one_case_needs_no_axis():
    a, b, v = some(3, 3), some(3, 2), some(3)
    np.testing.assert_allclose(product(a, v), a @ v, rtol=1e-12)
    np.testing.assert_allclose(product(a, b), a @ b, rtol=1e-12)
    np.testing.assert_allclose(solve(a, b), np.linalg.solve(a, b), rtol=1e-9)


def test_stretches_hold_every_case_once():
    cases = (30, 100, 7)
    seen = np.zeros(cases)
    sizes = [stretch(seen, of).size for of in stretches(cases)]
    for of in stretches(cases):
        stretch(seen, of)[...] += 1
    assert (seen == 1).all()
    assert max(sizes) <= 1500 < sum(sizes)
    shared = np.zeros((1, 7))
    assert all(stretch(shared, of) is shared for of in stretches(cases))
    assert list(stretches((9,))) == [slice(None)]


def test_points_are_packed_once_each():
    """Those that are not there, and those that come again, cost nothing."""
    one = random.integers(0, 3, size=(12, 5, 4)).astype(float)
    other = random.integers(0, 2, size=one.shape).astype(float)
    there = random.uniform(size=one.shape) < np.array([0.0, 0.2, 0.6, 1.0])
    (first, second), counts, place = packed(there, one, other)
    for v in range(5):
        for s in range(4):
            here = [(one[p, v, s], other[p, v, s]) for p in range(12) if there[p, v, s]]
            kept = list(dict.fromkeys(here))
            assert list(zip(first[:, v, s], second[:, v, s], strict=True))[: len(kept)] == kept
            at = [int(place[p, v, s]) for p in range(12) if there[p, v, s]]
            assert at == [kept.index(h) for h in here]
            assert len(kept) <= counts[s]
    assert counts[0] == 0 < counts[1] < counts[2] <= counts[3] <= 6
