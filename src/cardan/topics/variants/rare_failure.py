"""How often a limit fails that hardly ever does: importance sampling about its most likely failure.

A limit that one truck in a million fails is met by no study of ten thousand. The nearest
point at which it fails, in standard deviations of what scatters, gives how often by the
first-order method; how the surface of failure bends there, by the second. A limit is the worst of
many parts and states, and turning either way an angle grows: it has several ways to fail. Variants
drawn about all of them and weighted back need no shape of it.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from cardan.application.variant_sampling import VARIANTS_PER_CHUNK, SamplingPlan
from cardan.core.arrays import FloatArray
from cardan.core.errors import ConvergenceError
from cardan.core.verdict import MARGIN_TOLERANCE, Limit
from cardan.physics.fatigue.reliability import (
    FormResult,
    Normal,
    ProbabilityEstimate,
    SormResult,
    find_failure_mode_design_points,
    monte_carlo,
    second_order_reliability,
)
from cardan.topics.variants.evaluation import VariantEvaluator

IMPORTANCE_SAMPLE_COUNT = 1024
"""Variants about the most likely failures."""

MIN_FAILURE_DISTANCE_SD = 1.0
"""Failure that lies nearer, in standard deviations, is met often enough by plain Monte Carlo."""

LIMIT_SURFACE_CURVATURE_STEP_SD = 0.05
"""Standard deviations over which the surface's bend is taken: limits are exact to far less of it,
but for where their worst point changes."""

MARGIN_OF_INFEASIBLE_VARIANT = 1.0
"""Margin of what cannot exist: that of a limit of which nothing is used."""

MAX_FAILURE_DISTANCE_SD = 6.0
"""Failure that lies farther away, in standard deviations, is estimated from its distance alone."""


@dataclass(frozen=True, kw_only=True)
class RareFailureEstimate:
    """How often a limit fails.

    Attributes
    ----------
    line, limit
        Which.
    failure_modes
        Each way to fail, the nearest first: its distance, and what each input has to do with
        it; empty where none was found.
    second_order
        How the surface bends at the nearest, and how often by that; None where it closes about
        the nominal, as at an edge between two ways to fail, or was not requested.
    sampled
        How often, by variants drawn about all of them; None if not requested.
    inputs : (names,)
        What varies, where it fails most likely.
    infeasible_count
        How many of those evaluated on the way cannot exist: they fail no limit.
    """

    line: str
    limit: Limit
    failure_modes: tuple[FormResult, ...]
    second_order: SormResult | None = None
    sampled: ProbabilityEstimate | None = None
    inputs: FloatArray
    infeasible_count: int = 0

    @property
    def first_order(self) -> FormResult | None:
        """The nearest failure; None where none was found."""
        return self.failure_modes[0] if self.failure_modes else None

    @property
    def is_negligible(self) -> bool:
        """Whether no failure is near enough to count."""
        return not self.failure_modes or self.failure_modes[0].beta >= MAX_FAILURE_DISTANCE_SD

    @property
    def failure_probability(self) -> float:
        """Share of variants that fail; nan where unknown."""
        if self.sampled:
            return self.sampled.failure_probability
        best = self.second_order or self.first_order
        if best is None or self.failure_modes[0].sampled:
            return float("nan")
        return best.failure_probability + sum(f.failure_probability for f in self.failure_modes[1:])


def estimate_rare_failure(
    bench: VariantEvaluator, k: int, *, draws: int = IMPORTANCE_SAMPLE_COUNT, seed: int = 1
) -> RareFailureEstimate:
    """Return how often a limit of a bench fails, the k-th, from 0.

    Only its own quantity is evaluated. What is chosen, not drawn, stays in the middle of its range.

    Notes
    -----
    FORM after Hasofer & Lind (1974); SORM after Breitung (1984), as `fatigue.reliability` has
    it; importance sampling about every way to fail that was found (`ways`).

    Raises
    ------
    ValueError
        If nothing scatters.
    """
    if not tolerance_distribution(bench.sampling_plan).count:
        msg = "rare: needs tolerances: what is chosen fails by choice"
        raise ValueError(msg)
    line, limit = bench.limits[k]
    narrow = replace(bench, quantities=(limit.quantity,))
    which = narrow.limits.index((line, limit))
    scatter = tolerance_distribution(bench.sampling_plan)

    lost = 0

    def left(u: FloatArray) -> FloatArray:
        """Return the margin to failure (V,) of standard normal numbers (V, tolerances).

        What cannot exist fails no limit, as in the counts of a study.
        """
        nonlocal lost
        inputs = scatter.at_normal(np.atleast_2d(u))
        found: list[FloatArray] = []
        for first in range(0, len(inputs), VARIANTS_PER_CHUNK):
            answers = narrow.evaluate(inputs[first : first + VARIANTS_PER_CHUNK])
            margin = answers.left[which] + MARGIN_TOLERANCE  # equality passes
            found.append(np.where(answers.infeasible, MARGIN_OF_INFEASIBLE_VARIANT, margin))
            lost += int(answers.infeasible.sum())
        return np.concatenate(found)

    variables = [Normal(mean=0.0, deviation=1.0)] * scatter.count
    every = find_failure_mode_design_points(
        left, variables, far=MAX_FAILURE_DISTANCE_SD, tolerance=1e-3
    )
    if not every:
        return RareFailureEstimate(
            line=line, limit=limit, failure_modes=(), inputs=scatter.centre, infeasible_count=lost
        )
    nearest = every[0]
    found = RareFailureEstimate(
        line=line,
        limit=limit,
        failure_modes=every,
        inputs=scatter.at_normal(nearest.u[None])[0],
        infeasible_count=lost,
    )
    if abs(nearest.beta) >= MAX_FAILURE_DISTANCE_SD:
        return found
    around = every if nearest.beta > MIN_FAILURE_DISTANCE_SD else ()
    found = replace(
        found,
        second_order=None if nearest.sampled else _bent(left, variables, nearest),
        sampled=monte_carlo(left, variables, samples=draws, seed=seed, around=around)
        if draws
        else None,
    )
    return replace(found, infeasible_count=lost)


def _bent(
    left: Callable[[FloatArray], FloatArray], variables: Sequence[Normal], nearest: FormResult
) -> SormResult | None:
    """Return the second-order result; None if the surface has no usable bend."""
    try:
        return second_order_reliability(
            left, variables, around=nearest, h=LIMIT_SURFACE_CURVATURE_STEP_SD
        )
    except ConvergenceError:
        return None


@dataclass(frozen=True, kw_only=True)
class ToleranceDistribution:
    """The tolerances of a drawing alone, by independent standard normal numbers."""

    sampling_plan: SamplingPlan

    @property
    def count(self) -> int:
        """How many there are."""
        return sum(f.tolerance for f in self.sampling_plan.factors)

    @property
    def centre(self) -> FloatArray:
        """The inputs with nothing off."""
        return self.at_normal(np.zeros((1, self.count)))[0]

    def at_normal(self, u: FloatArray) -> FloatArray:
        """Return the inputs (V, names) of standard normal numbers (V, tolerances)."""
        from scipy.special import ndtr

        drawn = replace(
            self.sampling_plan,
            factors=(*self.sampling_plan.factors, *self.sampling_plan.grids),
            grids=(),
        )
        unit = np.full((len(u), len(drawn.factors)), 0.5)
        own = [k for k, f in enumerate(drawn.factors) if f.tolerance]
        unit[:, own] = np.clip(ndtr(u), 1e-300, 1 - 2.0**-53)
        return drawn.inputs_at(unit)


def tolerance_distribution(drawing: SamplingPlan) -> ToleranceDistribution:
    """Return what scatters of a drawing."""
    return ToleranceDistribution(sampling_plan=drawing)
