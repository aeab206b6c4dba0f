"""Least squares that have many places that fit better than all about them: the best of them.

A line of several centre bearings is such a case: another stiffness of another bearing explains
nearly as much, far from the truth and as sure of itself. The search begins where of many places
one fits best, and from where it ends it goes on with one or two numbers elsewhere, for as long as
that is better: a local search that is started anew from its own best.
Source: Moré, The Levenberg-Marquardt algorithm: implementation and theory (1978), in MINPACK;
Lourenço, Martin & Stützle, Iterated local search, Handbook of Metaheuristics (2003).
"""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from itertools import combinations, product
from typing import TypeAlias, TypeVar

import numpy as np

from cardan.core.arrays import FloatArray, IntArray

ResidualFunction: TypeAlias = Callable[[FloatArray], FloatArray]
"""What is left over (m,) at a place (p,), in standard deviations."""

SEARCH_GRID_LEVELS = (0.0, -0.5, 0.5, -1.0, 1.0)
"""Share of the way to its farthest at which a number is looked for that may be far off."""

GRID_START_COUNT = 12
"""Places of the grid from which the search begins."""

MAX_RESTARTS = 4
"""How often it goes on elsewhere."""

MIN_RESTART_MISFIT_GAIN_VARIANCES = 1.0
"""Variances by which it has to be better there to go on."""

MIN_RESTART_PARAMETER_DISTANCE = 0.14
"""How far from where it was found a number has to be to be elsewhere."""

SAME_MINIMUM_PARAMETER_DISTANCE = 0.05
"""How near one another the numbers that may be far off are at places that are one."""


@dataclass(frozen=True)
class LeastSquaresResult:
    """Where least squares ended: the place (p,), what is left there (m,), its slopes (m, p)."""

    x: FloatArray
    residuals: FloatArray
    jacobian: FloatArray

    @property
    def misfit(self) -> float:
        """In variances, all of it."""
        return sum_of_squares(self.residuals)


M = TypeVar("M", bound=LeastSquaresResult)


def sum_of_squares(left: FloatArray) -> float:
    """Return the sum of the squares of what is left over (m,)."""
    return float(left @ left)


def levenberg_marquardt(
    rows: ResidualFunction, start: FloatArray, *, steps: int = 12, gain: float = 1e-4
) -> LeastSquaresResult:
    """Return where least squares end, from a place (p,), by MINPACK's Levenberg-Marquardt.

    They end where a step takes less than a share `gain` of the misfit away, or after so many steps.
    """
    from scipy.optimize import least_squares

    last = start, rows(start)

    def residuals(x: FloatArray) -> FloatArray:
        nonlocal last
        if not np.array_equal(x, last[0]):
            last = x.copy(), rows(x)
        return last[1]

    found = least_squares(
        residuals, start, jac=lambda x: _slopes(rows, x, residuals(x)), method="lm",
        x_scale="jac", ftol=gain, xtol=1e-8, gtol=1e-12, max_nfev=steps,
    )  # fmt: skip
    return LeastSquaresResult(found.x, found.fun, np.asarray(found.jac, dtype=float))


def multistart(rows: ResidualFunction, *, far: FloatArray) -> list[LeastSquaresResult]:
    """Return the places that were found, apart from one another, the best first.

    Parameters
    ----------
    rows
        Function of the residuals; it is called some thousand times.
    far : (p,)
        How far from zero, the likeliest place, each number may be to either side; zero for
        those that any search finds.
    """
    wide = np.flatnonzero(far)
    moves = _moves(wide.size)
    ways = np.concatenate([np.where(np.isnan(moves), level, moves) for level in SEARCH_GRID_LEVELS])
    grid = _placed(far, wide, far[wide] * np.unique(ways, axis=0))
    rough = [sum_of_squares(rows(x)) for x in grid]
    # Zero is likely before anything is known.
    begun = [np.zeros(far.size), *grid[np.argsort(rough)[:GRID_START_COUNT]]]
    found = distinct_minima([levenberg_marquardt(rows, x) for x in begun], wide)
    for _ in range(MAX_RESTARTS):
        best = found[0]
        places = np.where(np.isnan(moves), best.x[wide], far[wide] * moves)
        places = places[_elsewhere(rows, best.x, wide, places)]
        # What else was found along with them is of the place that is left.
        begun = _placed(far, wide, places)
        found = distinct_minima([*found, *(levenberg_marquardt(rows, x) for x in begun)], wide)
        if found[0].misfit > best.misfit - MIN_RESTART_MISFIT_GAIN_VARIANCES:
            break
    return found


def distinct_minima(found: Iterable[M], wide: Sequence[int] | IntArray) -> list[M]:
    """Return the minima that are none of the better ones, the best first."""
    kept: list[M] = []
    for one in sorted(found, key=lambda one: one.misfit):
        if all(
            np.abs((one.x - k.x)[wide]).max(initial=0.0) > SAME_MINIMUM_PARAMETER_DISTANCE
            for k in kept
        ):
            kept.append(one)
    return kept


def _placed(like: FloatArray, at: IntArray, values: FloatArray) -> FloatArray:
    """Return places (n, p), zero but at some numbers."""
    found = np.zeros((len(values), like.size))
    found[:, at] = values
    return found


def _elsewhere(
    rows: ResidualFunction, x: FloatArray, at: IntArray, places: FloatArray
) -> list[int]:
    """Return which places (n, wide) fit best with each number elsewhere than at x, to each side."""
    options = np.tile(x, (len(places), 1))
    options[:, at] = places
    rough = np.array([sum_of_squares(rows(o)) for o in options])
    aside = places - x[at]
    sides = np.concatenate(
        [aside > MIN_RESTART_PARAMETER_DISTANCE, aside < -MIN_RESTART_PARAMETER_DISTANCE], axis=-1
    ).T
    return sorted({int(np.argmin(np.where(side, rough, np.inf))) for side in sides if side.any()})


def _moves(count: int) -> FloatArray:
    """Return shares of the way for one or two of so many numbers, nan of the rest, (n, count).

    Two of more than six would be thousands.
    """
    found: list[FloatArray] = []
    for few in (1, 2) if count <= 6 else (1,):
        for places in combinations(range(count), few):
            for levels in product(SEARCH_GRID_LEVELS, repeat=few):
                one = np.full(count, np.nan)
                one[list(places)] = levels
                found.append(one)
    return np.array(found).reshape(len(found), count)


def _slopes(rows: ResidualFunction, x: FloatArray, at: FloatArray) -> FloatArray:
    h = 1e-4
    return np.stack([(rows(x + h * e) - at) / h for e in np.eye(x.size)], axis=-1)
