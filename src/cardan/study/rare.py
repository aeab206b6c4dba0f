"""How often a limit fails that hardly ever does: where it fails most likely, and dice about that.

A limit that one truck in a million fails is met by no study of ten thousand. The nearest
point at which it fails, in standard deviations of what scatters, tells how often by the
first-order method; how the surface of failure bends there, by the second. A limit is the worst of
many parts and states, and turning either way an angle grows: it has several ways to fail. Variants
drawn about all of them and weighted back tell without any shape of it.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from cardan.base.arrays import FloatArray
from cardan.base.errors import NotConverged
from cardan.base.verdict import EQUAL, Limit
from cardan.fatigue.reliability import Estimate, Form, Normal, Sorm, monte_carlo, sorm, ways
from cardan.study.draw import Drawing
from cardan.study.sweep import CHUNK, Bench

DRAWS = 1024
"""Variants about the most likely failures."""

NEAR = 1.0
"""Failure that lies nearer, in standard deviations, is met often enough by plain dice."""

BEND = 0.05
"""Standard deviations over which the surface's bend is taken: limits are exact to far less of it,
but for where their worst point changes."""

SAFE = 1.0
"""Margin of what cannot exist: that of a limit of which nothing is used."""

FAR = 6.0
"""Failure that lies farther away, in standard deviations, is told by its distance alone."""


@dataclass(frozen=True, kw_only=True)
class Rare:
    """How often a limit fails.

    Attributes
    ----------
    line, limit
        Which.
    ways
        Each way to fail, the nearest first: its distance, and what each input has to do with
        it; empty where none was found.
    second_order
        How the surface bends at the nearest, and how often by that; None where it closes about
        the nominal, as at an edge between two ways to fail, or was not asked.
    sampled
        How often, by variants drawn about all of them; None where it was not asked.
    inputs : (names,)
        What varies, where it fails most likely.
    lost
        How many of those asked on the way cannot exist: they fail no limit.
    """

    line: str
    limit: Limit
    ways: tuple[Form, ...]
    second_order: Sorm | None = None
    sampled: Estimate | None = None
    inputs: FloatArray
    lost: int = 0

    @property
    def first_order(self) -> Form | None:
        """The nearest failure; None where none was found."""
        return self.ways[0] if self.ways else None

    @property
    def far(self) -> bool:
        """Whether no failure is near enough to count."""
        return not self.ways or self.ways[0].beta >= FAR

    @property
    def failure(self) -> float:
        """Share of variants that fail; nan where nobody knows."""
        if self.sampled:
            return self.sampled.failure
        best = self.second_order or self.first_order
        if best is None or self.ways[0].met:
            return float("nan")
        return best.failure + sum(f.failure for f in self.ways[1:])


def rare(bench: Bench, k: int, *, draws: int = DRAWS, seed: int = 1) -> Rare:
    """Return how often a limit of a bench fails, the k-th, from 0.

    Only its own quantity is asked. What is chosen, not drawn, stays in the middle of its range.

    Notes
    -----
    FORM after Hasofer & Lind (1974); SORM after Breitung (1984), as `fatigue.reliability` has
    it; importance sampling about every way to fail that was found (`ways`).

    Raises
    ------
    ValueError
        If nothing scatters.
    """
    if not tolerances(bench.drawing).count:
        msg = "rare: needs tolerances: what is chosen fails by choice"
        raise ValueError(msg)
    line, limit = bench.limits[k]
    narrow = replace(bench, quantities=(limit.quantity,))
    which = narrow.limits.index((line, limit))
    scatter = tolerances(bench.drawing)

    lost = 0

    def left(u: FloatArray) -> FloatArray:
        """Return the margin to failure (V,) of standard normal numbers (V, tolerances).

        What cannot exist fails no limit, as in the counts of a study.
        """
        nonlocal lost
        inputs = scatter.at_normal(np.atleast_2d(u))
        found: list[FloatArray] = []
        for first in range(0, len(inputs), CHUNK):
            answers = narrow.ask(inputs[first : first + CHUNK])
            margin = answers.left[which] + EQUAL  # equality passes
            found.append(np.where(answers.refused, SAFE, margin))
            lost += int(answers.refused.sum())
        return np.concatenate(found)

    variables = [Normal(mean=0.0, deviation=1.0)] * scatter.count
    every = ways(left, variables, far=FAR, tolerance=1e-3)
    if not every:
        return Rare(line=line, limit=limit, ways=(), inputs=scatter.centre, lost=lost)
    nearest = every[0]
    found = Rare(
        line=line, limit=limit, ways=every, inputs=scatter.at_normal(nearest.u[None])[0], lost=lost
    )
    if abs(nearest.beta) >= FAR:
        return found
    around = every if nearest.beta > NEAR else ()
    found = replace(
        found,
        second_order=None if nearest.met else _bent(left, variables, nearest),
        sampled=monte_carlo(left, variables, samples=draws, seed=seed, around=around)
        if draws
        else None,
    )
    return replace(found, lost=lost)


def _bent(
    left: Callable[[FloatArray], FloatArray], variables: Sequence[Normal], nearest: Form
) -> Sorm | None:
    """Return the second-order answer; None where the surface has no bend that tells."""
    try:
        return sorm(left, variables, around=nearest, h=BEND)
    except NotConverged:
        return None


@dataclass(frozen=True, kw_only=True)
class Scatter:
    """The tolerances of a drawing alone, by independent standard normal numbers."""

    drawing: Drawing

    @property
    def count(self) -> int:
        """How many there are."""
        return sum(f.tolerance for f in self.drawing.factors)

    @property
    def centre(self) -> FloatArray:
        """The inputs with nothing off."""
        return self.at_normal(np.zeros((1, self.count)))[0]

    def at_normal(self, u: FloatArray) -> FloatArray:
        """Return the inputs (V, names) of standard normal numbers (V, tolerances)."""
        from scipy.special import ndtr

        drawn = replace(
            self.drawing, factors=(*self.drawing.factors, *self.drawing.grids), grids=()
        )
        unit = np.full((len(u), len(drawn.factors)), 0.5)
        own = [k for k, f in enumerate(drawn.factors) if f.tolerance]
        unit[:, own] = np.clip(ndtr(u), 1e-300, 1 - 2.0**-53)
        return drawn.of(unit)


def tolerances(drawing: Drawing) -> Scatter:
    """Return what scatters of a drawing."""
    return Scatter(drawing=drawing)
