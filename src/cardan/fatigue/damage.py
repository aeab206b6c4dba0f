"""From counted cycles to damage, life and how sure of it one may be."""

import math
from dataclasses import dataclass

import numpy as np

from cardan.base.arrays import FloatArray
from cardan.base.units import hour
from cardan.fatigue.correction import Correction, uncorrected
from cardan.fatigue.rainflow import Cycles
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
