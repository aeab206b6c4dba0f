"""Least squares that have many places that fit better than all about them: the best of them.

A line of several centre bearings is such a case: another stiffness of another bearing explains
nearly as much, far from the truth and as sure of itself. The search begins where of many places
one fits best, and from where it ends it goes on with one or two numbers elsewhere, for as long as
that is better: a local search that is started anew from its own best.
Source: Levenberg and Marquardt's method as in Nocedal & Wright, Numerical Optimization (2006),
ch. 10; Lourenço, Martin & Stützle, Iterated local search, Handbook of Metaheuristics (2003).
"""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from itertools import combinations, product
from typing import TypeAlias, TypeVar

import numpy as np

from cardan.base.arrays import FloatArray, IntArray

Rows: TypeAlias = Callable[[FloatArray], FloatArray]
"""What is left over (m,) at a place (p,), in standard deviations."""

LEVELS = (0.0, -0.5, 0.5, -1.0, 1.0)
"""Share of the way to its farthest at which a number is looked for that may be far off."""

BEGUN = 12
"""Places of the grid from which the search begins."""

ROUNDS = 4
"""How often it goes on elsewhere."""

BETTER = 1.0
"""Variances by which it has to be better there to go on."""

ASIDE = 0.14
"""How far from where it was found a number has to be to be elsewhere."""

SAME = 0.05
"""How near one another the numbers that may be far off are at places that are one."""


@dataclass(frozen=True)
class Minimum:
    """Where least squares ended: the place (p,), what is left there (m,), its slopes (m, p)."""

    x: FloatArray
    left: FloatArray
    slope: FloatArray

    @property
    def misfit(self) -> float:
        """In variances, all of it."""
        return squares(self.left)


M = TypeVar("M", bound=Minimum)


def squares(left: FloatArray) -> float:
    """Return the sum of the squares of what is left over (m,)."""
    return float(left @ left)


def least(rows: Rows, start: FloatArray, *, steps: int = 12, gain: float = 1e-4) -> Minimum:
    """Least squares by Levenberg and Marquardt, from a place (p,).

    They end where a step takes less than a share `gain` of the misfit away.
    """
    x, left = start.copy(), rows(start)
    damp = 1e-3
    slope = _slopes(rows, x, left)
    for _ in range(steps):
        gram, right = slope.T @ slope, -slope.T @ left
        scale = np.diag(gram) + 1e-12 * np.trace(gram)
        for _ in range(6):
            step = np.linalg.solve(gram + damp * np.diag(scale), right)
            step = np.clip(step, -0.5, 0.5)
            tried = rows(x + step)
            if tried @ tried < left @ left:
                break
            damp *= 6
        else:
            break
        gone = 1 - (tried @ tried) / (left @ left)
        x, left, damp = x + step, tried, damp / 5
        slope = _slopes(rows, x, left)
        if gone < gain:
            break
    return Minimum(x, left, slope)


def searched(rows: Rows, *, far: FloatArray) -> list[Minimum]:
    """Return the places that were found, apart from one another, the best first.

    Parameters
    ----------
    rows
        What is left over; it is asked some thousand times.
    far : (p,)
        How far from nought, the likeliest place, each number may be to either side; nought of
        those that any search finds.
    """
    wide = np.flatnonzero(far)
    moves = _moves(wide.size)
    ways = np.concatenate([np.where(np.isnan(moves), level, moves) for level in LEVELS])
    grid = _placed(far, wide, far[wide] * np.unique(ways, axis=0))
    rough = [squares(rows(x)) for x in grid]
    # Nought is likely before anything is known.
    begun = [np.zeros(far.size), *grid[np.argsort(rough)[:BEGUN]]]
    found = apart([least(rows, x) for x in begun], wide)
    for _ in range(ROUNDS):
        best = found[0]
        places = np.where(np.isnan(moves), best.x[wide], far[wide] * moves)
        places = places[_elsewhere(rows, best.x, wide, places)]
        # What else was found along with them is of the place that is left.
        begun = _placed(far, wide, places)
        found = apart([*found, *(least(rows, x) for x in begun)], wide)
        if found[0].misfit > best.misfit - BETTER:
            break
    return found


def apart(found: Iterable[M], wide: Sequence[int] | IntArray) -> list[M]:
    """Return the minima that are none of the better ones, the best first."""
    kept: list[M] = []
    for one in sorted(found, key=lambda one: one.misfit):
        if all(np.abs((one.x - k.x)[wide]).max(initial=0.0) > SAME for k in kept):
            kept.append(one)
    return kept


def _placed(like: FloatArray, at: IntArray, values: FloatArray) -> FloatArray:
    """Return places (n, p), nought but at some numbers."""
    found = np.zeros((len(values), like.size))
    found[:, at] = values
    return found


def _elsewhere(rows: Rows, x: FloatArray, at: IntArray, places: FloatArray) -> list[int]:
    """Return which places (n, wide) fit best with each number elsewhere than at x, to each side."""
    options = np.tile(x, (len(places), 1))
    options[:, at] = places
    rough = np.array([squares(rows(o)) for o in options])
    aside = places - x[at]
    sides = np.concatenate([aside > ASIDE, aside < -ASIDE], axis=-1).T
    return sorted({int(np.argmin(np.where(side, rough, np.inf))) for side in sides if side.any()})


def _moves(count: int) -> FloatArray:
    """Return shares of the way for one or two of so many numbers, nan of the rest, (n, count).

    Two of more than six would be thousands.
    """
    found: list[FloatArray] = []
    for few in (1, 2) if count <= 6 else (1,):
        for places in combinations(range(count), few):
            for levels in product(LEVELS, repeat=few):
                one = np.full(count, np.nan)
                one[list(places)] = levels
                found.append(one)
    return np.array(found).reshape(len(found), count)


def _slopes(rows: Rows, x: FloatArray, at: FloatArray) -> FloatArray:
    h = 1e-4
    return np.stack([(rows(x + h * e) - at) / h for e in np.eye(x.size)], axis=-1)
