"""Jumps of a signal: off and back, single samples, and from one level to another."""

from collections.abc import Mapping

import numpy as np

from cardan.core.arrays import BoolArray, FloatArray, IntArray
from cardan.physics.signals.faults.intervals import merge_runs, overlaps

MAX_STEP_SAMPLES, MAX_STEP_S = 4, 0.005
"""Samples, and time, in which a level becomes another behind a filter: a load takes longer."""


JUMP_NEIGHBOURHOOD_SAMPLES = 32
"""Samples before a jump, or behind, that say how the channel moves there."""


MIN_JUMP_TO_90_PERCENT_QUANTILE_RATIO = 5.0
"""Times their 90 % quantile that a jump stands out by; noise alone reaches some three."""


MIN_SPIKE_PREDICTION_ERROR_RATIO = 10.0
"""The same of a sample that its neighbours do not predict."""


MAX_SPIKE_NEIGHBOUR_ERROR_RATIO = 0.1
"""Of how far a sample is off, how much its neighbours may be off otherwise than by it."""


def lagged_differences(x: FloatArray, lag: int) -> tuple[FloatArray, FloatArray, BoolArray]:
    """Return how x moves within so many samples, the size of it, and where it `may_stand_out`."""
    d = x[lag:] - x[:-lag]
    size = np.abs(d)
    return d, size, may_stand_out(size, gap=lag)


def find_jumps(
    x: FloatArray, d: FloatArray, size: FloatArray, loud: BoolArray, *, longest: int
) -> tuple[IntArray, FloatArray]:
    """Return runs (k, 2) of samples that jump off and back, level between and quiet on both sides.

    Of x and its `_moves` by a sample. A ring is not quiet behind, a blow is not level: neither is
    one.
    """
    none = np.empty((0, 2), np.intp), np.empty(0)
    off, back = map(np.flatnonzero, loud)
    off = off[size[off] > 5 * np.maximum(size[off - 1], size[off - 2])]
    back = back[size[back] > 5 * np.maximum(size[back + 1], size[back + 2])]
    off, back = standing_out(size, off, -1), standing_out(size, back, 1)
    if not (off.size and back.size):
        return none
    near = np.searchsorted(back, off, "right")
    there = near < back.size
    off, back = off[there], back[near[there]]
    width = back - off
    low, high = np.minimum(size[off], size[back]), np.maximum(size[off], size[back])
    fits = (width <= longest) & (d[off] * d[back] < 0) & (low >= 0.6 * high)
    fits &= np.abs(x[off] - x[back + 1]) <= 0.5 * low
    off, back, low = off[fits], back[fits], low[fits]
    flat = np.array(
        [np.ptp(x[a + 1 : b + 1]) <= 0.25 * s for a, b, s in zip(off, back, low, strict=True)], bool
    )
    if not flat.any():
        return none
    off, back, low = off[flat], back[flat], low[flat]
    return np.stack([off + 1, back + 1], -1), low * np.sign(d[off])


def find_single_spikes(x: FloatArray) -> tuple[IntArray, FloatArray]:
    """Return single samples, runs (k, 2), that a cubic through their neighbours does not predict.

    Within a ring steps are large, but each sample is predicted by those next to it. One that is off
    by itself spoils the prediction of these as well, by two thirds and with the other sign; a
    blow, however short, has flanks.
    """
    off = np.zeros_like(x)
    off[2:-2] = x[2:-2] - (4 * (x[1:-3] + x[3:-1]) - x[:-4] - x[4:]) / 6
    size = np.abs(off)
    at = np.flatnonzero(may_stand_out(size, gap=2, least=MIN_SPIKE_PREDICTION_ERROR_RATIO).all(0))
    beside = np.maximum(
        np.abs(off[at - 1] + 2 / 3 * off[at]), np.abs(off[at + 1] + 2 / 3 * off[at])
    )
    at = at[beside < MAX_SPIKE_NEIGHBOUR_ERROR_RATIO * size[at]]
    for way in (-1, 1):
        at = standing_out(size, at, way, gap=2, least=MIN_SPIKE_PREDICTION_ERROR_RATIO)
    return np.stack([at, at + 1], -1), off[at]


def find_level_steps(
    moves: Mapping[int, tuple[FloatArray, FloatArray, BoolArray]],
) -> tuple[IntArray, FloatArray]:
    """Return runs (k, 2) in which the level becomes another, calm on both sides, by how much.

    Within so many samples: at once, or in the few that a filter makes of it.
    """
    found = [_find_level_steps_at_lag(*of, lag) for lag, of in moves.items()]
    runs, sizes = (np.concatenate(part) for part in zip(*found, strict=True))
    first = ~overlaps(runs, merge_runs([found[0][0]])) | (np.arange(len(runs)) < len(found[0][0]))
    order = np.argsort(runs[first, 0], kind="stable")
    return runs[first][order], sizes[first][order]


def _find_level_steps_at_lag(
    d: FloatArray, size: FloatArray, loud: BoolArray, lag: int
) -> tuple[IntArray, FloatArray]:
    """Return the same of those that take so many samples."""
    calm = 5 if lag == 1 else 3  # a filter overshoots
    at = np.flatnonzero(loud.all(0))
    at = at[size[at] > calm * np.maximum(size[at - lag], size[at + lag])]
    for k in range(1, lag):  # the middle of the way
        at = at[size[at] >= np.maximum(size[at - k], size[at + k])]
    at = standing_out(size, standing_out(size, at, -1, gap=lag), 1, gap=lag)
    return np.stack([at + 1, at + 1 + lag], -1), d[at]


def may_stand_out(
    size: FloatArray,
    *,
    gap: int = 1,
    least: float = MIN_JUMP_TO_90_PERCENT_QUANTILE_RATIO,
    share: float = 0.9,
) -> BoolArray:
    """Return which jumps may be `standing_out`, (2, n): before them, and behind. No others are."""
    loud = np.zeros((2, size.size), bool)
    if size.size <= 2 * JUMP_NEIGHBOURHOOD_SAMPLES + 8 * gap:
        return loud
    # In as many sets as steps are usual or larger: what is largest in each is the least of these
    # at least, and so is what is usual.
    low, count = size, JUMP_NEIGHBOURHOOD_SAMPLES - int(share * JUMP_NEIGHBOURHOOD_SAMPLES)
    for k in (1, 2, 4, 8, 16):
        low = (np.maximum if 2 * k * count <= JUMP_NEIGHBOURHOOD_SAMPLES else np.minimum)(
            low[:-k], low[k:]
        )
    low *= least
    first = gap + JUMP_NEIGHBOURHOOD_SAMPLES
    jumps = size[first:-first]
    np.greater(jumps, low[: jumps.size], out=loud[0, first:-first])
    np.greater(jumps, low[-jumps.size :], out=loud[1, first:-first])
    return loud


def standing_out(
    size: FloatArray,
    at: IntArray,
    way: int,
    *,
    gap: int = 1,
    least: float = MIN_JUMP_TO_90_PERCENT_QUANTILE_RATIO,
    share: float = 0.9,
) -> IntArray:
    """Those jumps that stand out of a share of the steps before them (way -1) or behind (1)."""
    if not at.size:
        return at
    first = at + 1 + gap if way > 0 else at - gap - JUMP_NEIGHBOURHOOD_SAMPLES
    near = size[first[:, None] + np.arange(JUMP_NEIGHBOURHOOD_SAMPLES)]
    usual = np.partition(near, int(share * JUMP_NEIGHBOURHOOD_SAMPLES), axis=-1)[
        :, int(share * JUMP_NEIGHBOURHOOD_SAMPLES)
    ]
    return at[size[at] > least * usual]
