"""A step of what a gauge answers to the joints' torque: its gain may have changed, or the line.

The order fitted by torque and speed leaves a gain for each block of seconds, about one
(`synchronous_fit.gain_variation_over_time`). Geometry rides with the springs, so it wanders by some
per cent; an amplifier that is set otherwise moves it at once, and it stays.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from cardan.core.arrays import ComplexArray, FloatArray

MIN_BLOCKS_TO_EITHER_SIDE = 4
"""Blocks before and after a step, at least."""
MIN_STEP_LN = math.log(1.2)
"""Step of the logarithm of the gain; of 20 whole recordings none reached a quarter of it."""
MIN_STEP_STANDARD_ERRORS = 3.0
"""Step in standard errors of the two medians."""
MIN_BLOCK_DEVIATION_LN = 1e-3
"""Scatter of the blocks, at least."""


@dataclass(frozen=True)
class ResponseStep:
    """From when on, s, a response is how many times as large."""

    time: float
    factor: float


def response_step(middle: FloatArray, gain: ComplexArray) -> ResponseStep | None:
    """Return the clearest step of gains (blocks,) about one; None where there is none.

    Parameters
    ----------
    middle : (blocks,) s
        Of each block.
    gain : (blocks,) 1
        Of the order there over that of the whole.
    """
    level = np.log(np.maximum(np.abs(gain), 1e-3))
    splits = range(MIN_BLOCKS_TO_EITHER_SIDE, level.size - MIN_BLOCKS_TO_EITHER_SIDE + 1)
    if not splits:
        return None

    def rest(k: int) -> FloatArray:
        parts = (level[:k], level[k:])
        return np.abs(np.concatenate([part - np.median(part) for part in parts]))

    k = min(splits, key=lambda k: float(rest(k).sum()))
    step = float(np.median(level[k:]) - np.median(level[:k]))
    scatter = max(1.48 * float(np.median(rest(k))), MIN_BLOCK_DEVIATION_LN)
    error = scatter * math.sqrt(1 / k + 1 / (level.size - k))
    if abs(step) < max(MIN_STEP_LN, MIN_STEP_STANDARD_ERRORS * error):
        return None
    return ResponseStep(float(middle[k - 1] + middle[k]) / 2, math.exp(step))


def damage_ratios_of_gain_step(
    stress: FloatArray, at: int, factor: float, *, damage: Callable[[FloatArray], float]
) -> tuple[float, float]:
    """Return the least and the most damage, over that recorded, if a gain stepped at a sample.

    The part behind it may be the one that is wrong, or the one before.
    """
    whole = damage(stress)
    if not whole > 0:
        return 1.0, 1.0
    later, earlier = stress.copy(), stress.copy()
    later[at:] /= factor
    earlier[:at] *= factor
    each = [damage(x) / whole for x in (stress, later, earlier)]
    return min(each), max(each)
