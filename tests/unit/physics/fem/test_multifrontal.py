"""Factors front by front: against LAPACK on the whole matrix, and Kőnig's theorem."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.sparse import block_diag, bsr_array, csr_array, diags_array, eye_array, kron
from scipy.sparse.csgraph import maximum_bipartite_matching

from cardan.core.errors import ConvergenceError
from cardan.physics.fem.multifrontal import _between, multifrontal_cholesky


def blocks(pattern, rng, *, firm: float = 1.0) -> bsr_array:
    """A stiffness of 3 x 3 blocks where a graph has its edges; positive if it is firm."""
    pattern = csr_array(pattern + pattern.T + eye_array(pattern.shape[0]))
    half = bsr_array(
        (rng.normal(size=(pattern.nnz, 3, 3)), pattern.indices, pattern.indptr),
        shape=tuple(3 * n for n in pattern.shape),
    )
    both = half + half.T
    sums = np.abs(both).sum(axis=1) + 1
    return bsr_array(both + firm * diags_array(sums), blocksize=(3, 3))


def grid(n: int, m: int):
    line = [eye_array(k, k=1) for k in (n, m)]
    return kron(line[0], eye_array(m)) + kron(eye_array(n), line[1])


def scattered(count: int, edges: int, rng):
    ends = rng.integers(0, count, (2, edges))
    return csr_array((np.ones(edges), (ends[0], ends[1])), shape=(count, count))


@pytest.mark.slow
@settings(max_examples=25)
@given(
    count=st.integers(1, 260), per=st.floats(0, 3), held=st.floats(0, 0.7), seed=st.integers(0, 999)
)
def test_what_is_solved_is_solved(count, per, held, seed):
    """Whatever hangs together with what, in one piece or many, and whatever of it is held."""
    rng = np.random.default_rng(seed)
    stiffness = blocks(scattered(count, int(per * count), rng), rng)
    free = rng.random(3 * count) >= held
    loads = rng.normal(size=(4, 3 * count)) * free
    found = multifrontal_cholesky(stiffness, free).solve(loads)
    whole = stiffness.toarray()[np.ix_(free, free)]
    expected = np.zeros_like(loads)
    if free.any():
        expected[:, free] = np.linalg.solve(whole, loads[:, free].T).T
    assert found == pytest.approx(expected, rel=1e-9, abs=1e-9 * max(np.abs(expected).max(), 1e-9))


@pytest.mark.slow
def test_a_sheet_of_two_pieces_is_solved_by_few_numbers():
    """Of a square of n functions a side factors row by row have n³ blocks."""
    rng = np.random.default_rng(1)
    n = 90
    stiffness = blocks(block_diag([grid(n, n), grid(n, n)]), rng)
    free = np.ones(stiffness.shape[0], dtype=bool)
    made = multifrontal_cholesky(stiffness, free)
    numbers = sum(f.pivot.size / 2 + f.below.size for f in made.fronts)
    assert numbers < 0.65 * 2 * 9 * n**3
    assert sorted(made.order) == [*range(len(free))]
    loads = rng.normal(size=(7, len(free)))
    assert made.solve(loads) @ stiffness == pytest.approx(loads, abs=1e-11 * np.abs(loads).max())


def test_what_is_not_held_is_refused():
    rng = np.random.default_rng(2)
    stiffness = blocks(grid(12, 12), rng, firm=0.0)
    with pytest.raises(ConvergenceError, match="is every direction held"):
        multifrontal_cholesky(stiffness, np.ones(stiffness.shape[0], dtype=bool))


@pytest.mark.slow
@given(count=st.integers(2, 60), per=st.floats(0, 4), seed=st.integers(0, 999))
def test_the_fewest_keep_two_halves_apart(count, per, seed):
    """As many as the largest match of nodes across has pairs: fewer cannot touch all of it."""
    rng = np.random.default_rng(seed)
    graph = scattered(count, int(per * count), rng)
    graph = csr_array(graph + graph.T)
    one = rng.random(count) < 0.5
    between = _between(graph, one)
    left = graph[np.flatnonzero(one & ~between)][:, np.flatnonzero(~one & ~between)]
    assert left.nnz == 0
    across = graph[np.flatnonzero(one)][:, np.flatnonzero(~one)]
    pairs = np.count_nonzero(maximum_bipartite_matching(across, perm_type="column") >= 0)
    assert between.sum() == pairs
