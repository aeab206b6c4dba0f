"""A gauge's stress judged otherwise than by its S-N curve: by strain, by a crack, by odds."""

import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Protocol

import numpy as np

from cardan.core.arrays import FloatArray
from cardan.core.errors import ConvergenceError
from cardan.core.units import MPa, Pascal, hour
from cardan.physics.fatigue import crack_growth as crack
from cardan.physics.fatigue.damage import LifeEstimate, RepeatedSequence, miner_damage
from cardan.physics.fatigue.rainflow import Cycles, ResidueRule, half_cycles, repeating
from cardan.physics.fatigue.reliability import (
    FormResult,
    Lognormal,
    ProbabilityEstimate,
    SormResult,
    first_order_reliability,
    monte_carlo,
    second_order_reliability,
)
from cardan.physics.fatigue.strain_life import CyclicMaterial, HysteresisLoops, NotchStrainTracker
from cardan.physics.signals.assessment import AssessmentSettings


class GaugeCycleCount(Protocol):
    """A gauge of a recording or of a mix: its cycles, and what they came to."""

    @property
    def cycles(self) -> Cycles:
        """Closed cycles, and the residue by its rule."""
        ...

    @property
    def life(self) -> LifeEstimate:
        """Damage and what follows from it."""
        ...


@dataclass(frozen=True)
class SequencedCycles:
    """A gauge of a mix whose parts are driven in turn: its cycles then, and what they come to."""

    cycles: Cycles
    life: LifeEstimate
    sequence: RepeatedSequence


IMPORTANCE_SAMPLE_COUNT = 2000
"""Parts drawn about the likeliest failure."""

FAILURE_SURFACE_CURVATURE_STEP_SD = 0.2
"""Standard deviations over which the surface of failure bends: at a knee of the curve every cycle
makes a kink, and one kink is no bend."""


@dataclass(frozen=True, kw_only=True)
class StrainLifeSettings:
    """How a place is judged by its local strain.

    Attributes
    ----------
    material
        Its cyclic and strain-life curves.
    mean_stress_law
        What the mean stress of a loop does, one of `MEAN_STRESS_LAWS`.
    notch_factor
        K_t from the gauge to the place; None where the gauge felt the place's own strain.
    """

    material: CyclicMaterial
    mean_stress_law: str = "swt"
    notch_factor: float | None = None


@dataclass(frozen=True, kw_only=True)
class CrackGrowthSettings:
    """How a crack is judged: lengths in m, growth C ΔK^m, m a cycle and MPa√m, above a threshold.

    `geometry_factor` is Y of K = Y S √(πa).
    """

    initial_size: float
    final_size: float
    C: float
    m: float
    threshold: float = 0.0
    geometry_factor: float = 1.12


@dataclass(frozen=True, kw_only=True)
class FailureProbability:
    """How often parts fail within some hours of service.

    Attributes
    ----------
    service_hours
        Of service.
    first_order, second_order
        By the nearest failure, and by how its surface bends there; None where there is none.
    sampled
        By parts drawn about it.
    """

    service_hours: float
    first_order: FormResult | None
    second_order: SormResult | None
    sampled: ProbabilityEstimate | None

    @property
    def shares(self) -> dict[str, float]:
        """What scatters, by its share of the doubt (β²)."""
        names = ("strength", "damage at failure", "stress scale")
        return (
            {}
            if self.first_order is None
            else dict(zip(names, self.first_order.importance, strict=True))
        )


@dataclass(frozen=True, kw_only=True)
class AlternativeLives:
    """Lives of one gauge by other methods; None where not requested.

    Attributes
    ----------
    strain_damage, strain_amplitude
        Of the recording or mix by strain-life, and the largest local strain amplitude.
    crack_passages
        Passages of the recording or mix that grow the crack; infinite where it stops.
    duration : s
        Time with valid data, of one passage.
    sequenced
        The same of a mix with its parts driven in turn; None where that says nothing else.
    """

    gauge: str
    duration: float
    damage_at_failure: float
    strain_damage: float | None = None
    strain_amplitude: float = math.nan
    crack_passages: float | None = None
    failure_probability: FailureProbability | None = None
    sequenced: "AlternativeLives | None" = None

    @property
    def strain_hours(self) -> float:
        """Hours until a crack is there, by strain-life."""
        if self.strain_damage is None or math.isnan(self.strain_damage):
            return math.nan
        if not self.strain_damage > 0:
            return math.inf
        return self.damage_at_failure / self.strain_damage * self.duration / hour

    @property
    def crack_hours(self) -> float:
        """Hours in which the crack grows."""
        return (
            math.nan if self.crack_passages is None else self.crack_passages * self.duration / hour
        )


def strain_life_damage(
    pieces: Callable[[], Iterable[FloatArray]],
    largest: Sequence[Pascal],
    of: StrainLifeSettings,
    *,
    rule: ResidueRule,
) -> list[tuple[float, float]]:
    """Return damage and largest local strain amplitude of each gauge of a stress (gauges, n) Pa.

    `pieces` yields it from the beginning at each call; `largest` is how far each goes from zero.
    What no loop closes counts by the rule: as half loops, not at all, or where the route is driven
    again and again what its second passage closes, whose memory is the first's.
    """
    followers = [
        NotchStrainTracker(of.material, largest=size, notch=of.notch_factor) for size in largest
    ]
    damage, strain = np.zeros(len(largest)), np.zeros(len(largest))

    def take(k: int, loops: HysteresisLoops) -> None:
        damage[k] += loops.damage(of.material, law=of.mean_stress_law)
        strain[k] = max(strain[k], float(loops.amplitude.max(initial=0.0)))

    if rule is repeating:
        for piece in pieces():
            for k, follower in enumerate(followers):
                follower.update(piece[k])
    for piece in pieces():
        for k, follower in enumerate(followers):
            take(k, follower.update(piece[k]))
    for k, follower in enumerate(followers if rule is not repeating else ()):
        take(k, follower.remaining_loops(legs=rule is half_cycles))
    return [(float(d), float(s)) for d, s in zip(damage, strain, strict=True)]


def sequence_strain_life_damage(
    of: StrainLifeSettings, order: RepeatedSequence
) -> tuple[float, float]:
    """Return the damage that an order does beyond its parts by themselves, and the largest strain.

    By local strain, of what the parts left open; loops that closed within one stay as they were.
    """
    largest = max((float(np.abs(left).max(initial=0.0)) for left in order.residues), default=0.0)
    if not largest > 0:
        return 0.0, 0.0

    def damage(stress: FloatArray, rule: ResidueRule) -> tuple[float, float]:
        (found,) = strain_life_damage(lambda: [stress[None]], [largest], of, rule=rule)
        return found

    whole = [(damage(order.joined_residues(which), repeating), n) for which, n in order.succession]
    alone = [
        (damage(left, order.residue_rule), n)
        for left, n in zip(order.residues, order.repeats, strict=True)
    ]
    more = sum(d * n for (d, _), n in whole) - sum(d * n for (d, _), n in alone)
    return more, max(strain for (_, strain), _ in whole)


def alternative_lives_of_recording_mix(
    one: GaugeCycleCount,
    parts: Sequence[tuple[AlternativeLives, float]],
    plan: AssessmentSettings,
    *,
    gauge: str,
    turned: SequencedCycles | None,
    strained: StrainLifeSettings | None,
    crack: CrackGrowthSettings | None,
    hours: float | None,
    miner_scatter: float,
) -> AlternativeLives:
    """Return the other answers of a gauge in a mix of recordings, each driven so many times.

    Damage by strain adds up, each recording beginning with a memory of nothing. A crack grows by
    the cycles of all in one, and odds are of those: what has to hold is the mix, and neither is
    a mean of what each recording would come to by itself. The same is computed for the mix driven
    in turn, where that is given.
    """

    def judged(of: GaugeCycleCount, damage: float | None, strain: float) -> AlternativeLives:
        return AlternativeLives(
            gauge=gauge, duration=of.life.duration, damage_at_failure=plan.allowed,
            strain_damage=damage, strain_amplitude=strain,
            crack_passages=None if crack is None else crack_growth_passes_to_failure(of, crack),
            failure_probability=None if hours is None else failure_probability(
                of, plan, hours=hours, miner_scatter=miner_scatter
            ),
        )  # fmt: skip

    damage, strain = None, max((p.strain_amplitude for p, _ in parts), default=math.nan)
    if strained is not None:
        damage = sum(p.strain_damage * n for p, n in parts if p.strain_damage is not None)
    told = judged(one, damage, strain)
    if turned is None:
        return told
    if strained is not None and damage is not None:
        more, largest = sequence_strain_life_damage(strained, turned.sequence)
        damage, strain = damage + more, max(strain, largest)
    return replace(told, sequenced=judged(turned, damage, strain))


def crack_growth_passes_to_failure(one: GaugeCycleCount, of: CrackGrowthSettings) -> float:
    """Return passages of a recording that grow a crack at a gauge; infinite where it stops."""
    law = partial(crack.paris, C=of.C * MPa**-of.m, m=of.m, threshold=of.threshold * MPa)
    return crack.sequences_between_crack_lengths(
        start=of.initial_size, end=of.final_size, cycles=one.cycles, law=law,
        shape=partial(crack.constant_geometry_factor, Y=of.geometry_factor),
    )  # fmt: skip


def failure_probability(
    one: GaugeCycleCount,
    plan: AssessmentSettings,
    *,
    hours: float,
    miner_scatter: float,
    seed: int = 1,
) -> FailureProbability:
    """Return how often parts fail at a gauge within some hours of service.

    g = ln(Δ D₀) - ln D(B σ, A): strength A and stress scale B about the plan's, and damage at
    failure Δ about its allowed one D₀ with a coefficient of variation, all lognormal. Sources:
    Wirsching, J. Struct. Eng. 110 (1984); `fatigue.reliability`.
    """
    curve, correction, passages = plan.curve, plan.correction, hours * hour / one.life.duration
    binned = miner_damage(one.cycles, curve=curve, correction=correction)
    exact = one.life.damage / binned if binned > 0 else 1.0

    def limit(x: FloatArray) -> FloatArray:
        each = [
            miner_damage(
                one.cycles.scaled(float(b)), curve=curve.scaled(float(a)), correction=correction
            )
            for a, b in zip(x[..., 0].ravel(), x[..., 2].ravel(), strict=True)
        ]
        done = passages * exact * np.reshape(each, x.shape[:-1])
        with np.errstate(divide="ignore"):
            return np.log(plan.allowed * x[..., 1]) - np.log(done)

    deviation = curve.scatter * math.log(10)
    variables = (
        Lognormal(median=1.0, cov=math.sqrt(math.expm1(deviation**2))),
        Lognormal(median=1.0, cov=miner_scatter),
        Lognormal(median=1.0, cov=plan.gauge_error),
    )
    try:
        first = first_order_reliability(limit, variables, tolerance=1e-6)
    except ConvergenceError:
        return FailureProbability(
            service_hours=hours, first_order=None, second_order=None, sampled=None
        )
    try:
        second = second_order_reliability(
            limit, variables, around=first, h=FAILURE_SURFACE_CURVATURE_STEP_SD
        )
    except ConvergenceError:
        second = None
    # About a failure likelier than not, few draws would inform about the parts that hold.
    about = first if first.beta > 0 else ()
    sampled = monte_carlo(
        limit, variables, samples=IMPORTANCE_SAMPLE_COUNT, seed=seed, around=about
    )
    return FailureProbability(
        service_hours=hours, first_order=first, second_order=second, sampled=sampled
    )
