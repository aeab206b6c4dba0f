"""Small matrices of many cases, (N, M, ...): rows and columns first, the cases last.

LAPACK takes small matrices one by one. Here each step of the algebra runs over all cases at
once, which lie side by side in memory: several times as fast, as long as they fit the cache
(`cache_blocks`). Few cases are LAPACK's: a step costs what a hundred of its equations do.
"""

from collections.abc import Iterator, Sequence
from math import prod
from typing import Any, TypeAlias

import numpy as np

from cardan.core.arrays import BoolArray, FloatArray, IntArray, broadcastable_axis_indices

CACHE_BLOCK_CASES = 1500
"""Cases at a time: what is at hand of so many stays in a processor's second cache."""

LAPACK_MAX_CASES = 100
"""Cases that LAPACK solves one by one in less time than all of them take step by step."""

MATMUL_MIN_ROWS = 6
"""Rows from which on matrices multiply faster one by one, however many."""

RESIDUAL_TOLERANCE = 1e-9
"""What may be left of an equation, as a share: more is left where no rows were exchanged but had
to be."""


CaseBlockSlices: TypeAlias = slice | tuple[slice, slice]
"""Of the variants of cases (..., V, S), and of the states where some alone are meant."""


def matrix_axes_first(values: Any, *, of: int) -> Any:
    """Return arrays (..., N, M) of matrices, or (..., N) of vectors, with those axes first.

    `of` is how many they are. What broadcast without memory of its own does so still.
    """
    return np.moveaxis(values, range(-of, 0), range(of))


def matrix_axes_last(values: Any, *, of: int) -> Any:
    """Return the reverse of `matrix_axes_first`."""
    return np.moveaxis(values, range(of), range(-of, 0))


def broadcast_cases(values: Any, axes: int, *, of: int) -> Any:
    """Return matrices or vectors, `of` axes of their own, with cases of so many axes."""
    own, cases = values.shape[:of], values.shape[of:]
    return values.reshape(*own, *(1,) * (axes - len(cases)), *cases)


def case_table(parts: Sequence[tuple[Any, int]], cases: tuple[int, ...]) -> Any:
    """Return arrays side by side, of each case in one piece of memory, (C, sum).

    Each of the `parts` comes with how many axes of its own it has before those of the cases.
    """
    widths = [prod(v.shape[:of]) for v, of in parts]
    found = np.empty((*cases, sum(widths)), np.result_type(*(v for v, _ in parts)))
    start = 0
    for (v, of), width in zip(parts, widths, strict=True):
        rows = v.reshape(width, *(1,) * (len(cases) + of - v.ndim), *v.shape[of:])
        found[..., start : start + width] = np.moveaxis(rows, 0, -1)
        start += width
    return found.reshape(prod(cases), found.shape[-1])


def move_valid_points_to_front(
    there: BoolArray, *values: FloatArray
) -> tuple[list[FloatArray], IntArray, IntArray]:
    """Return numbers (P, V, S) of points with those `there` in front, each point once.

    Then how many points each state has at most, (S,), and in which place each is, (P, V, S).
    """
    same = there[:, None] & there
    for v in values:
        same &= v[:, None] == v
    first = same.argmax(axis=0)
    along, *cases = broadcastable_axis_indices(there.shape)
    new = there & (first == along)
    rank = new.cumsum(axis=0) - 1
    counts = rank[-1].max(axis=0) + 1
    here = np.nonzero(new)
    into = rank[here], *here[1:]
    found = [np.zeros((counts.max(), *there.shape[1:])) for _ in values]
    for front, v in zip(found, values, strict=True):
        front[into] = v[here]
    return found, counts, np.maximum(rank[first, *cases], 0)


def cache_blocks(cases: tuple[int, ...]) -> Iterator[slice]:
    """Yield stretches of the last but one axis of cases (..., V, S) that fit the cache."""
    if len(cases) < 2:
        yield slice(None)
        return
    step = max(1, CACHE_BLOCK_CASES * cases[-2] // max(1, int(np.prod(cases))))
    for start in range(0, cases[-2], step):
        yield slice(start, start + step)


def slice_case_block(values: Any, of: CaseBlockSlices) -> Any:
    """Return that stretch of the cases (..., V, S) of arrays; all, where V is 1 and broadcasts.

    Of one case axis alone there is but one stretch; with more, arrays are `wide` as the others.
    A stretch may be of some states too.
    """
    if isinstance(of, tuple):
        variants, states = (
            whole if size == 1 else part
            for size, part, whole in zip(values.shape[-2:], of, (slice(None),) * 2, strict=True)
        )
        return values[..., variants, states]
    if of == slice(None) or values.shape[-2] == 1:
        return values
    return values[..., of, :]


def append_column(a: Any, b: Any) -> Any:
    """Return matrices (N, M, ...) with a column (N, ...) more."""
    cases = np.broadcast_shapes(a.shape[2:], b.shape[1:])
    found = np.empty((len(a), a.shape[1] + 1, *cases), dtype=np.result_type(a, b))
    found[:, :-1], found[:, -1] = a, b
    return found


def matrix_product(a: Any, b: Any) -> Any:
    """Return matrices (N, M, ...) times matrices (M, K, ...), or vectors (M, ...)."""
    cases = np.broadcast_shapes(a.shape[2:], b.shape[2:] if b.ndim == a.ndim else b.shape[1:])
    if len(b) >= MATMUL_MIN_ROWS or prod(cases) <= LAPACK_MAX_CASES:
        vectors = b.ndim < a.ndim
        each = matrix_axes_last(a, of=2) @ matrix_axes_last(b[:, None] if vectors else b, of=2)
        return matrix_axes_first(each, of=2)[:, 0] if vectors else matrix_axes_first(each, of=2)
    found = np.empty((len(a), *b.shape[1 : b.ndim - a.ndim + 2], *cases), np.result_type(a, b))
    more = np.empty(found.shape[1:], found.dtype)
    for k, row in enumerate(a):  # row by row: all of it leaves the cache
        into = found[k, ...]  # an array even of one number
        np.multiply(row[0], b[0], out=into)
        for j in range(1, len(b)):
            np.multiply(row[j], b[j], out=more)
            into += more
    return found


def solve(a: Any, b: Any) -> Any:
    """Return the solutions (N, K, ...) of matrices a (N, N, ...), right-hand sides (N, K, ...).

    By Gauss, without exchanging rows; few cases, and those in which that loses digits, are
    LAPACK's.

    Raises
    ------
    LinAlgError
        If a matrix is singular.
    """
    cases = np.broadcast_shapes(a.shape[2:], b.shape[2:])
    size, columns = len(a), b.shape[1]
    if prod(cases) <= LAPACK_MAX_CASES:
        return matrix_axes_first(
            np.linalg.solve(matrix_axes_last(a, of=2), matrix_axes_last(b, of=2)), of=2
        )
    both = np.empty((size, size + columns, *cases), dtype=np.result_type(a, b))
    left, found = both[:, :size], both[:, size:]
    left[...], found[...] = a, b
    less = np.empty(both.shape[1:], both.dtype)  # what a row loses: one place for all of it
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        for k in range(size):
            left[k, k] = 1 / left[k, k]
            for i in range(k + 1, size):
                share = left[i, k] * left[k, k]
                both[i, k + 1 :] -= np.multiply(share, both[k, k + 1 :], out=less[k + 1 :])
        for k in reversed(range(size)):
            found[k] *= left[k, k]
            for i in range(k):
                found[i] -= np.multiply(left[i, k], found[k], out=less[:columns])
        whole, right = found.sum(axis=1), b.sum(axis=1)
        rest = np.abs(matrix_product(a, whole) - right).max(axis=0)
        lost = ~(rest <= RESIDUAL_TOLERANCE * np.abs(right).max(axis=0))
    if lost.any():
        one_by_one = (
            matrix_axes_last(np.broadcast_to(v, (*v.shape[:2], *cases))[..., lost], of=2)
            for v in (a, b)
        )
        found[..., lost] = matrix_axes_first(np.linalg.solve(*one_by_one), of=2)
    return found
