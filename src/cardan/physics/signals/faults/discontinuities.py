"""Discontinuities: a signal that is torn from one sample to the next, its zero or its gain."""

import numpy as np

from cardan.core.arrays import FloatArray, IntArray
from cardan.physics.signals.faults.intervals import FaultIntervals
from cardan.physics.signals.faults.jumps import may_stand_out, standing_out

MAX_DISCONTINUITY_NEIGHBOUR_ERROR_RATIO, MIN_DISCONTINUITY_TO_LOCAL_MEDIAN_RATIO = 0.25, 10.0
"""The same of a jump between two samples; and how many times the median about it."""


MIN_DISCONTINUITY_MOVE_RATIO = 2.0
"""Times what x moves in the sample before and in the one behind."""


GAIN_CHECK_SPANS_PER_SIDE, MIN_GAIN_CHANGE_LN, MAX_JUMP_TO_SWING_GAIN_MISMATCH_LN = 3, 0.1, 0.5
"""Spans next to a tear that show whether the gain changed there; the logarithm of the least change,
and how far from it the swing's may be."""

MAX_REVERSAL_FACTOR_ERROR_LN = 0.3
"""Logarithm by which the gain that a tear shows may be off: where the signal bends, lines through
two samples on either side are off by 7 % in the middle, and by 30 % in a tenth of all cases."""


def find_discontinuities(x: FloatArray) -> tuple[IntArray, FloatArray, FloatArray]:
    """Return where x is torn: runs (k, 2) of one sample each, how far it jumps to it, and where to.

    Lines through two samples on either side do not meet half way, and do so at the places before
    and behind but for that jump. Whatever bends and swings about it, a structure that was hit goes
    on to move; a wire that was touched, a bit that stands still or a code that ran over does not.
    """
    step = np.diff(x)
    apart = np.zeros_like(x)
    apart[1:-2] = step[1:-1] - (step[:-2] + step[2:]) / 2
    size, near = np.abs(apart), np.abs(step)
    may = np.logical_and(
        *may_stand_out(size, gap=2, least=MIN_DISCONTINUITY_TO_LOCAL_MEDIAN_RATIO, share=0.5)
    )
    # What was hit goes on about as fast.
    may[1:-2] &= size[1:-2] > MIN_DISCONTINUITY_MOVE_RATIO * np.maximum(near[:-2], near[2:])
    at = np.flatnonzero(may)
    half = apart[at] / 2
    beside = np.maximum(np.abs(apart[at - 1] + half), np.abs(apart[at + 1] + half))
    at = at[beside < MAX_DISCONTINUITY_NEIGHBOUR_ERROR_RATIO * size[at]]
    at = at[size[at] > 2 * np.maximum(size[at - 3], size[at + 3])]
    for way in (-1, 1):
        at = standing_out(
            size, at, way, gap=2, least=MIN_DISCONTINUITY_TO_LOCAL_MEDIAN_RATIO, share=0.5
        )
    return np.stack([at + 1, at + 2], -1), apart[at], 1.5 * x[at + 1] - x[at + 2] / 2


def gain_factors(
    torn: FaultIntervals, behind: FloatArray, *, levels: FloatArray, swings: FloatArray, span: int
) -> FloatArray:
    """Return by what a gain changed at tears (k,), 1 where only the zero stepped.

    `behind` (k,) is where each leads to. Level and swing of some spans on both sides, as far as
    the next tear, have to say the same, and better than of a step.
    """
    factors = np.ones(torn.count)
    ends = np.concatenate([[0], torn.runs[:, 0], [levels.size * span]])
    for k, (jump, to) in enumerate(zip(torn.sizes.tolist(), behind.tolist(), strict=True)):
        first, at, last = ends[k : k + 3].tolist()
        before = slice(max(-(-first // span), at // span - GAIN_CHECK_SPANS_PER_SIDE), at // span)
        after = slice(-(-at // span), min(last // span, -(-at // span) + GAIN_CHECK_SPANS_PER_SIDE))
        told = [np.nanmedian(x[s]) for x in (levels, swings) for s in (before, after) if x[s].size]
        if len(told) < 4 or not min(told[2:]) > 0 or to in (0.0, jump):
            continue
        level, new, swing, wide = told
        by = to / (to - jump)
        if abs(new - by * level) > abs(new - level - jump) + swing:
            continue  # the level knows of a step
        grown, off = abs(np.log(wide / swing)), abs(np.log(wide / swing / abs(by)))
        larger = by > 0 and abs(np.log(by)) > MIN_GAIN_CHANGE_LN and off < grown / 2
        turned = by < 0 and abs(new - by * level) < abs(new - level - jump)
        if off < MAX_JUMP_TO_SWING_GAIN_MISMATCH_LN and (larger or turned):
            # Two wires that were swapped turn a gauge over and change nothing else.
            swapped = by < 0 and abs(np.log(-by)) < MAX_REVERSAL_FACTOR_ERROR_LN
            factors[k] = -1.0 if swapped else by
    return factors
