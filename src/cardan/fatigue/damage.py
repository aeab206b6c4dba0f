"""From counted cycles to damage, life and how sure of it one may be."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np

from cardan.base.arrays import FloatArray
from cardan.base.units import hour
from cardan.fatigue.correction import Correction, uncorrected
from cardan.fatigue.rainflow import (
    Cycles,
    ResidueRule,
    four_point,
    join,
    rainflow,
    repeating,
    without_small,
)
from cardan.fatigue.strength import SNCurve


def miner(cycles: Cycles, *, curve: SNCurve, correction: Correction = uncorrected) -> float:
    """Palmgren-Miner damage Σ n/N of some cycles; 1 is failure.

    Which Miner is the curve's choice: `curve.original()`, `.elementary()`, `.modified()`.
    Source: Palmgren, Z. VDI 68 (1924); Miner, J. Appl. Mech. 12 (1945).
    """
    # Not a dot product: BLAS would start threads for it, one set in each of ours.
    return float(damages(cycles, curve=curve, correction=correction).sum())


def damages(cycles: Cycles, *, curve: SNCurve, correction: Correction = uncorrected) -> FloatArray:
    """Damage n/N of each of some cycles, (n,)."""
    return cycles.count * curve.damage(correction(cycles.amplitude, cycles.mean))


def harmless(
    damage: float, *, crest: float, samples: int, curve: SNCurve,
    correction: Correction = uncorrected,
) -> float:  # fmt: skip
    """Range (Pa) of cycles that do no such damage, as many as fit into some samples.

    Parameters
    ----------
    damage
        That is not reached.
    crest : Pa
        Farthest from nought that the stress gets; the range is sought from 2e-4 of it on.
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


LEAVES, AT_FIRST = 1e-5, 0.05
"""Share of a damage that small cycles may have which are left out of it, and the range below which
they are at first, over that of the stress."""


def nearly(
    stress: FloatArray, *, rule: ResidueRule, curve: SNCurve, correction: Correction = uncorrected
) -> float:
    """Damage of a stress (n,), but for cycles so small that all of them do a share `LEAVES` of it.

    Most of a rough stress' cycles do nothing, and cost as much to count as the others.
    """
    low, high = (float(reach(stress, initial=0.0)) for reach in (np.fmin.reduce, np.fmax.reduce))
    gate = AT_FIRST * (high - low)
    while True:
        turns = without_small(stress, gate=gate)
        closed, left = four_point(turns)
        damage = miner(join([closed, rule(left)]), curve=curve, correction=correction)
        may = harmless(
            LEAVES * damage, crest=max(-low, high), samples=stress.size, curve=curve,
            correction=correction,
        )  # fmt: skip
        if gate <= may or turns is stress:
            return damage
        gate = may


@dataclass(frozen=True, slots=True, kw_only=True)
class InTurn:
    """Stretches that follow each other or themselves, again and again.

    Attributes
    ----------
    residues : (k,) Pa each
        Reversals that each stretch left open.
    times
        How often each is driven.
    order
        Which stretches follow each other, and how often they do.
    rule
        By which each was counted by itself.
    """

    residues: tuple[FloatArray, ...]
    times: tuple[float, ...]
    order: tuple[tuple[tuple[int, ...], float], ...]
    rule: ResidueRule

    def stress(self, which: tuple[int, ...]) -> FloatArray:
        """Return what stretches left open, one after the other."""
        return np.concatenate([self.residues[k] for k in which])

    @property
    def cycles(self) -> Cycles:
        """What is closed beyond each stretch by itself.

        Counts are below zero of what each had counted and something else has become of.
        """
        each = zip(self.residues, self.times, strict=True)
        return join([
            *(rainflow(self.stress(which), rule=repeating).repeated(n) for which, n in self.order),
            *(rainflow(left, rule=self.rule).repeated(-n) for left, n in each),
        ])  # fmt: skip


def in_turn(
    residues: Sequence[FloatArray], *, times: Sequence[float], curve: SNCurve,
    correction: Correction = uncorrected, rule: ResidueRule = repeating,
) -> InTurn:  # fmt: skip
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
        return miner(legs, curve=curve, correction=correction)

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
    return InTurn(residues=tuple(residues), times=tuple(times), order=tuple(order), rule=rule)


@dataclass(frozen=True, slots=True, kw_only=True)
class Life:
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


def damage_exponent(
    cycles: Cycles, *, curve: SNCurve, correction: Correction = uncorrected, step: float = 1e-3
) -> float:
    """Relative change of damage per relative change of stress: d ln D / d ln S.

    A gauge that reads 1 % high overstates damage by this many per cent. Between the two
    slopes of the curve, by how the damage is spread over it.
    """
    low = miner(cycles.scaled(1 - step), curve=curve, correction=correction)
    high = miner(cycles.scaled(1 + step), curve=curve, correction=correction)
    if not (low > 0 and math.isfinite(high)):
        return math.nan
    return math.log(high / low) / math.log((1 + step) / (1 - step))


def repeats_at(
    cycles: Cycles,
    *,
    curve: SNCurve,
    failures: tuple[float, ...] = (0.1, 0.5, 0.9),
    gauge_error: float = 0.0,
    correction: Correction = uncorrected,
) -> dict[float, float]:
    """Repeats until each share of parts has failed, S-N scatter and gauge error together.

    `gauge_error` is the relative standard deviation of the stress scale. The scatters of
    strength and scale, both lognormal, add as squares (in log10).
    """
    gauge = math.log10(math.e) * math.sqrt(math.log1p(gauge_error**2))
    total = math.hypot(curve.scatter, gauge)
    spread = SNCurve(
        amplitude=curve.amplitude, cycles=curve.cycles, slope=curve.slope, beyond=curve.beyond,
        scatter=total, failure=curve.failure, ceiling=curve.ceiling,
    )  # fmt: skip
    lives: dict[float, float] = {}
    for failure in failures:
        damage = miner(cycles, curve=spread.at(failure), correction=correction)
        lives[failure] = 1 / damage if damage > 0 else math.inf
    return lives


def equivalent_range(cycles: Cycles, *, slope: float) -> float:
    """Constant range that does the damage of the counted ones in as many cycles, N ~ S^-k."""
    if not cycles.count.sum() > 0:
        return 0.0
    return float(np.average(cycles.range**slope, weights=cycles.count) ** (1 / slope))
