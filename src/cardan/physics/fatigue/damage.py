"""From counted cycles to damage, life and how sure of it one may be."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np

from cardan.core.arrays import FloatArray
from cardan.core.units import hour
from cardan.physics.fatigue.mean_stress import MeanStressCorrection, uncorrected
from cardan.physics.fatigue.rainflow import (
    Cycles,
    ResidueRule,
    concatenate_cycles,
    four_point,
    omit_small_cycles,
    rainflow,
    repeating,
)
from cardan.physics.fatigue.sn_curve import SNCurve


def miner_damage(
    cycles: Cycles, *, curve: SNCurve, correction: MeanStressCorrection = uncorrected
) -> float:
    """Palmgren-Miner damage Σ n/N of some cycles; 1 is failure.

    Which Miner is the curve's choice: `curve.original()`, `.elementary()`, `.modified()`.
    Source: Palmgren, Z. VDI 68 (1924); Miner, J. Appl. Mech. 12 (1945).
    """
    # Not a dot product: BLAS would start threads for it, one set in each of ours.
    return float(cycle_damages(cycles, curve=curve, correction=correction).sum())


def cycle_damages(
    cycles: Cycles, *, curve: SNCurve, correction: MeanStressCorrection = uncorrected
) -> FloatArray:
    """Damage n/N of each of some cycles, (n,)."""
    return cycles.count * curve.damage(correction(cycles.amplitude, cycles.mean))


def omission_level(
    damage: float, *, crest: float, samples: int, curve: SNCurve,
    correction: MeanStressCorrection = uncorrected,
) -> float:  # fmt: skip
    """Range (Pa) of cycles that do no such damage, as many as fit into some samples.

    Parameters
    ----------
    damage
        That is not reached.
    crest : Pa
        Farthest from zero that the stress gets; the range is sought from 2e-4 of it on.
    """
    if not (damage > 0 and crest > 0):
        return 0.0
    size = crest * np.geomspace(1e-4, 1, 81)
    # At the worst of means.
    most = 0.5 * samples * curve.damage(
        np.maximum(correction(size, np.full(size.size, crest)), size)
    )  # fmt: skip
    below = size[most <= damage]
    return 2 * float(below[-1]) if below.size else 0.0


MAX_OMITTED_DAMAGE_SHARE, INITIAL_OMITTED_TO_STRESS_RANGE_RATIO = 1e-5, 0.05
"""Share of a damage that small cycles may have which are left out of it, and the range below which
they are at first, over that of the stress."""


def damage_with_omission(
    stress: FloatArray,
    *,
    rule: ResidueRule,
    curve: SNCurve,
    correction: MeanStressCorrection = uncorrected,
) -> float:
    """Damage of a stress (n,) but for `MAX_OMITTED_DAMAGE_SHARE` of it, done by small cycles.

    Most of a rough stress' cycles do nothing, and cost as much to count as the others.
    """
    low, high = (float(reach(stress, initial=0.0)) for reach in (np.fmin.reduce, np.fmax.reduce))
    gate = INITIAL_OMITTED_TO_STRESS_RANGE_RATIO * (high - low)
    while True:
        turns = omit_small_cycles(stress, gate=gate)
        closed, left = four_point(turns)
        damage = miner_damage(
            concatenate_cycles([closed, rule(left)]), curve=curve, correction=correction
        )
        may = omission_level(
            MAX_OMITTED_DAMAGE_SHARE * damage,
            crest=max(-low, high),
            samples=stress.size,
            curve=curve,
            correction=correction,
        )
        if gate <= may or turns is stress:
            return damage
        gate = may


@dataclass(frozen=True, slots=True, kw_only=True)
class RepeatedSequence:
    """Stretches that follow each other or themselves, again and again.

    Attributes
    ----------
    residues : (k,) Pa each
        Reversals that each stretch left open.
    repeats
        How often each is driven.
    succession
        Which stretches follow each other, and how often they do.
    residue_rule
        By which each was counted by itself.
    """

    residues: tuple[FloatArray, ...]
    repeats: tuple[float, ...]
    succession: tuple[tuple[tuple[int, ...], float], ...]
    residue_rule: ResidueRule

    def joined_residues(self, which: tuple[int, ...]) -> FloatArray:
        """Return what stretches left open, one after the other."""
        return np.concatenate([self.residues[k] for k in which])

    @property
    def additional_cycles(self) -> Cycles:
        """What is closed beyond each stretch by itself.

        Counts are below zero of what each had counted and something else has become of.
        """
        each = zip(self.residues, self.repeats, strict=True)
        return concatenate_cycles(
            [
                *(
                    rainflow(self.joined_residues(which), rule=repeating).repeated(n)
                    for which, n in self.succession
                ),
                *(rainflow(left, rule=self.residue_rule).repeated(-n) for left, n in each),
            ]
        )


def order_blocks_for_high_damage(
    residues: Sequence[FloatArray], *, times: Sequence[float], curve: SNCurve,
    correction: MeanStressCorrection = uncorrected, rule: ResidueRule = repeating,
) -> RepeatedSequence:  # fmt: skip
    """Return stretches in the order in which cycles between them do much damage.

    What closed within a stretch stays closed whatever is driven around it; tops of one that meet
    bottoms of another make cycles that no stretch has, and so does the end of one that meets its
    own beginning. Those two come first that make most of each other, as often as both are driven;
    what is left of a stretch follows itself. It is an order that can be driven, and no bound of
    all.

    Parameters
    ----------
    residues : (k,) Pa each
        Reversals that each stretch left open.
    times
        How often each is driven.
    rule
        By which each was counted; by the default it had followed itself already.
    """

    def damage(*which: int) -> float:
        legs = rainflow(np.concatenate([residues[k] for k in which]), rule=repeating)
        return miner_damage(legs, curve=curve, correction=correction)

    each = range(len(residues))
    alone = [damage(k) for k in each]
    more = {(i, j): damage(i, j) - alone[i] - alone[j] for i, j in combinations(each, 2)}
    left, order = list(times), list[tuple[tuple[int, ...], float]]()
    for (i, j), gain in sorted(more.items(), key=lambda of: -of[1]):
        often = min(left[i], left[j])
        if gain > 0 and often > 0:
            left[i], left[j] = left[i] - often, left[j] - often
            order.append(((i, j), often))
    order += [((k,), n) for k, n in enumerate(left) if n > 0]
    return RepeatedSequence(
        residues=tuple(residues), repeats=tuple(times), succession=tuple(order), residue_rule=rule
    )


@dataclass(frozen=True, slots=True, kw_only=True)
class LifeEstimate:
    """How long a part lasts that takes this damage in this time and way.

    Attributes
    ----------
    damage
        Of one recording.
    duration : s
        Of one recording.
    distance : m
        Driven in it; nan if unknown.
    allowed
        Damage at failure: 1 by Miner, 0.3 to 0.5 in careful practice under service loads.
    """

    damage: float
    duration: float
    distance: float = math.nan
    allowed: float = 1.0

    @property
    def repeats(self) -> float:
        """Passages of the recording until failure; infinite where it does no harm."""
        if math.isnan(self.damage):
            return math.nan
        return self.allowed / self.damage if self.damage > 0 else math.inf

    @property
    def hours(self) -> float:
        """Hours until failure."""
        return self.repeats * self.duration / hour

    @property
    def kilometres(self) -> float:
        """Kilometres until failure."""
        return self.repeats * self.distance / 1e3


def damage_to_stress_exponent(
    cycles: Cycles,
    *,
    curve: SNCurve,
    correction: MeanStressCorrection = uncorrected,
    step: float = 1e-3,
) -> float:
    """Relative change of damage per relative change of stress: d ln D / d ln S.

    A gauge that reads 1 % high overstates damage by this many per cent. Between the two
    slopes of the curve, by how the damage is spread over it.
    """
    low = miner_damage(cycles.scaled(1 - step), curve=curve, correction=correction)
    high = miner_damage(cycles.scaled(1 + step), curve=curve, correction=correction)
    if not (low > 0 and math.isfinite(high)):
        return math.nan
    return math.log(high / low) / math.log((1 + step) / (1 - step))


def repeats_at_failure_probabilities(
    cycles: Cycles,
    *,
    curve: SNCurve,
    failures: tuple[float, ...] = (0.1, 0.5, 0.9),
    gauge_error: float = 0.0,
    correction: MeanStressCorrection = uncorrected,
) -> dict[float, float]:
    """Repeats until each share of parts has failed, S-N scatter and gauge error together.

    `gauge_error` is the relative standard deviation of the stress scale. The scatters of
    strength and scale, both lognormal, add as squares (in log10).
    """
    gauge = math.log10(math.e) * math.sqrt(math.log1p(gauge_error**2))
    total = math.hypot(curve.scatter, gauge)
    spread = SNCurve(
        amplitude=curve.amplitude,
        cycles=curve.cycles,
        slope=curve.slope,
        slope_beyond_knee=curve.slope_beyond_knee,
        scatter=total,
        failure=curve.failure,
        ceiling=curve.ceiling,
    )
    lives: dict[float, float] = {}
    for failure in failures:
        damage = miner_damage(cycles, curve=spread.at_failure_share(failure), correction=correction)
        lives[failure] = 1 / damage if damage > 0 else math.inf
    return lives
