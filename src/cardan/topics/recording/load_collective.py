"""Load collective of a gauge against its S-N curve: cumulative cycles, and the stress reserve."""

from dataclasses import dataclass

import numpy as np

from cardan.core.arrays import ArrayLike, FloatArray
from cardan.physics.fatigue.damage import LifeEstimate, miner_damage
from cardan.physics.fatigue.mean_stress import MeanStressCorrection
from cardan.physics.fatigue.rainflow import Cycles, range_pairs
from cardan.physics.fatigue.sn_curve import SNCurve
from cardan.physics.signals.assessment import AssessmentSettings

COLLECTIVE_LEVELS = 160
"""Amplitudes at which the cumulative cycles are computed."""
LOWEST_LEVEL_SHARE = 0.02
"""Lowest of these amplitudes over the largest."""
RESERVE_RANGE = 1e-3, 1e3
"""Factors on stress between which a reserve is sought."""


@dataclass(frozen=True, kw_only=True)
class LoadCollective:
    """Cumulative cycles of one passage of a recording or a mix.

    Attributes
    ----------
    amplitude : (n,) Pa
        At zero mean stress, with the same damage as the cycle had at its mean; rising.
    cycles : (n,) 1
        Cycles of at least that amplitude.
    """

    amplitude: FloatArray
    cycles: FloatArray


def load_collective(cycles: Cycles, correction: MeanStressCorrection) -> LoadCollective | None:
    """Return the load collective of some cycles; None where none has an amplitude."""
    equivalent = np.asarray(correction(cycles.amplitude, cycles.mean), float)
    largest = float(equivalent.max(initial=0.0))
    if not 0 < largest < np.inf:
        return None
    levels = np.geomspace(LOWEST_LEVEL_SHARE * largest, largest, COLLECTIVE_LEVELS)
    levels[-1] = largest
    reversed_cycles = Cycles(-equivalent, equivalent, cycles.count)
    return LoadCollective(amplitude=levels, cycles=range_pairs(reversed_cycles, ranges=2 * levels))


def curve_amplitude(curve: SNCurve, cycles: ArrayLike) -> FloatArray:
    """Return the amplitude (...) Pa at which an S-N curve bears some cycles (...)."""
    ratio = curve.cycles / np.asarray(cycles, float)
    slope = np.where(ratio >= 1, curve.slope, curve.slope_beyond_knee)
    return np.minimum(curve.amplitude * ratio ** (1 / slope), curve.ceiling)


def stress_reserve(
    cycles: Cycles, life: LifeEstimate, plan: AssessmentSettings, *, seconds: float
) -> float:
    """Return the factor on all stresses at which damage at failure is reached after some time.

    Above 1 there is a reserve. By bisection, because damage rises with the stress; infinite where
    no factor in `RESERVE_RANGE` reaches it.
    """
    counted = miner_damage(cycles, curve=plan.curve, correction=plan.correction)
    if not (counted > 0 and life.damage > 0 and seconds > 0):
        return float("inf")
    # The bins' rounding cancels: damage by bins over the exact one is the same for all factors.
    wanted = plan.allowed * life.duration / seconds * counted / life.damage
    low, high = (float(np.log(end)) for end in RESERVE_RANGE)
    for _ in range(50):
        middle = (low + high) / 2
        scaled = cycles.scaled(float(np.exp(middle)))
        if miner_damage(scaled, curve=plan.curve, correction=plan.correction) < wanted:
            low = middle
        else:
            high = middle
    found = float(np.exp(low))
    return found if found < 0.999 * RESERVE_RANGE[1] else float("inf")
