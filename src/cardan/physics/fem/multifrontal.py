"""Cholesky factors front by front, which solve for many right sides at once.

The engine's take one right side after the other, and what that takes is the time to read them.
Here the functions of a mesh are cut in two by as few of them as keep the halves apart, and each
half again. What is eliminated together is a dense matrix, its front, and so is what it leaves to
those that are eliminated later: work for BLAS, of as many columns as there are right sides.
Sources: George, SIAM J. Numer. Anal. 10 (1973) 345, for the order; Duff and Reid, ACM Trans.
Math. Softw. 9 (1983) 302, for fronts.
"""

from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from cardan.core.arrays import BoolArray, FloatArray
from cardan.core.errors import ConvergenceError

_TOGETHER = 64
"""Functions that are cut no more: of 24 to 128 the factors take as long."""


class _Front(NamedTuple):
    """What is eliminated together: unknowns from `first` to `end`, and what it leaves later ones.

    `pivot` (m, m) is its lower triangle, `below` (b, m) the rows of those in `later` (b,).
    """

    first: int
    end: int
    later: npt.NDArray[np.intp]
    pivot: FloatArray
    below: FloatArray


@dataclass(frozen=True)
class MultifrontalFactor:
    """Factors of what is free of a stiffness; see `fronts`.

    Attributes
    ----------
    order : (free unknowns,)
        The unknowns as they are eliminated.
    fronts
        What is eliminated together, first things first.
    """

    order: npt.NDArray[np.intp]
    fronts: tuple[_Front, ...]

    def solve(self, loads: FloatArray) -> FloatArray:
        """Displacements (c, unknowns) under loads (c, unknowns); nil where they are held."""
        from scipy.linalg import solve_triangular

        x = np.ascontiguousarray(loads.T[self.order])
        for first, end, later, pivot, below in self.fronts:
            x[first:end] = solve_triangular(pivot, x[first:end], lower=True, check_finite=False)
            x[later] -= below @ x[first:end]
        for first, end, later, pivot, below in reversed(self.fronts):
            left = x[first:end] - below.T @ x[later]
            x[first:end] = solve_triangular(pivot, left, lower=True, trans=1, check_finite=False)
        found = np.zeros_like(loads)
        found[:, self.order] = x.T
        return found


def multifrontal_cholesky(stiffness: Any, free: BoolArray) -> MultifrontalFactor:
    """Factorise what is free (unknowns,) of a sparse symmetric matrix of square blocks.

    Raises
    ------
    ConvergenceError
        If it is not positive: not every direction is held.
    """
    from scipy.linalg import LinAlgError, cholesky, solve_triangular
    from scipy.sparse import triu

    parts = _dissected(stiffness)
    block = stiffness.blocksize[0]
    by_part = [(block * own[:, None] + np.arange(block)).ravel() for own, _ in parts]
    by_part = [unknowns[free[unknowns]] for unknowns in by_part]
    order = np.concatenate(by_part)
    rows = triu(stiffness.tocsr()[order][:, order], format="csr")
    ends = np.cumsum([len(unknowns) for unknowns in by_part]).tolist()
    starts = [0, *ends[:-1]]
    laters: list[npt.NDArray[np.intp]] = []
    for (_, within), first, end in zip(parts, starts, ends, strict=True):
        known = [rows[first:end].indices, *(laters[part] for part in within)]
        later = np.unique(np.concatenate(known)).astype(np.intp)
        laters.append(later[later >= end])
    sizes = [(end - first) * (end - first + len(later))
             for first, end, later in zip(starts, ends, laters, strict=True)]  # fmt: skip
    # All in one piece: among other blocks that come and go they would leave holes as large.
    factors = np.split(np.empty(sum(sizes)), np.cumsum(sizes[:-1]))
    left: dict[int, FloatArray] = {}  # by each part to those that are eliminated later
    done: list[_Front] = []
    for k, ((_, within), first, end, later) in enumerate(
        zip(parts, starts, ends, laters, strict=True)
    ):
        there = np.concatenate([np.arange(first, end), later])
        front = np.zeros((len(there), len(there)))
        mine = rows[first:end].tocoo()
        front[np.searchsorted(there, mine.col), mine.row] = mine.data
        for part in within:
            at = np.searchsorted(there, laters[part])
            front[np.ix_(at, at)] += left.pop(part)
        m = end - first
        both = factors[k].reshape(m + len(later), m)
        pivot, below = both[:m], both[m:]
        try:
            pivot[:] = cholesky(front[:m, :m], lower=True, check_finite=False)
        except LinAlgError as error:
            msg = f"the stiffness cannot be factorised ({error}): is every direction held?"
            raise ConvergenceError(msg) from error
        below[:] = solve_triangular(pivot, front[m:, :m].T, lower=True, check_finite=False).T
        left[k] = front[m:, m:] - below @ below.T
        done.append(_Front(first, end, later, pivot, below))
    return MultifrontalFactor(order=order, fronts=tuple(done))


def _dissected(stiffness: Any) -> list[tuple[npt.NDArray[np.intp], list[int]]]:
    """Return the functions that are eliminated together, in that order.

    With each the parts that it keeps apart, by their numbers.
    """
    from scipy.sparse import csr_array

    there = np.ones(len(stiffness.indices), dtype=np.int8)
    count = len(stiffness.indptr) - 1
    whole = csr_array((there, stiffness.indices, stiffness.indptr), shape=(count, count))
    parts: list[tuple[npt.NDArray[np.intp], list[int]]] = []

    def cut(graph: Any, functions: npt.NDArray[np.intp]) -> int:
        within: list[int] = []
        if len(functions) > _TOGETHER:
            between, *halves = _halves(graph)
            within = [
                cut(graph[half][:, half], functions[half])
                for half in map(np.flatnonzero, halves) if half.size
            ]  # fmt: skip
            functions = functions[between]
        parts.append((functions, within))
        return len(parts) - 1

    cut(whole, np.arange(count))
    return parts


def _halves(graph: Any) -> tuple[BoolArray, BoolArray, BoolArray]:
    """Return which nodes keep two halves of a graph apart, and the halves: (nodes,) each.

    One half is what is nearest to an end of the graph; where that is all that hangs together
    with it, nothing is between.
    """
    from scipy.sparse.csgraph import breadth_first_order

    near = np.array([0])
    for _ in range(3):  # from anywhere to an end, to the other end, and back
        near = breadth_first_order(graph, near[-1], return_predecessors=False)
    count = graph.shape[0]
    one = np.zeros(count, dtype=bool)
    one[near if len(near) < count else near[: count // 2]] = True
    between = _between(graph, one)
    return between, one & ~between, ~one & ~between


def _between(graph: Any, one: BoolArray) -> BoolArray:
    """Return the fewest nodes (nodes,) at one end at least of each edge from one half to the other.

    Those are the nodes of one half that no path reaches from its nodes without a mate, by edges
    that are no match there and by matches back, and those of the other half that one does.
    Source: Kőnig's theorem.
    """
    from scipy.sparse.csgraph import maximum_bipartite_matching

    here, there = np.flatnonzero(one), np.flatnonzero(~one)
    edges = graph[here][:, there]
    mates, mate = (maximum_bipartite_matching(edges, perm_type=of) for of in ("column", "row"))
    crossing = np.diff(edges.indptr) > 0
    reached, reached_there = crossing & (mates < 0), np.zeros(len(there), dtype=bool)
    new = np.flatnonzero(reached)
    while new.size:
        ahead = np.unique(edges[new].indices)
        ahead = ahead[~reached_there[ahead]]
        reached_there[ahead] = True
        new = mate[ahead]  # each has one: else the match were not the largest
        new = new[~reached[new]]
        reached[new] = True
    found = np.zeros(len(one), dtype=bool)
    found[here[crossing & ~reached]] = True
    found[there[reached_there]] = True
    return found
