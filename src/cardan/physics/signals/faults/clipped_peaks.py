"""Crests that were cut off at a level: found, measured and put back as parabolas."""

import numpy as np

from cardan.core.arrays import FloatArray, IntArray
from cardan.physics.signals.faults.intervals import FaultIntervals, overlaps

MIN_CLIPPED_SAMPLES = 4
"""Samples in a row at one level that make a crest look cut off."""


MIN_SHORT_CLIP_ENTRY_RESOLUTION_STEPS = 4.5
"""Steps of the channel into a level of three samples that make it one cut off.

A parabola's middle stands above them by a third of what they stand above the next.
"""


MIN_SINGLE_CLIP_ENTRY_STEPS = 50.0
"""Of such steps, from which a single one is no chance: what came so fast does not rest at once."""


MAX_KEPT_CRESTS, MIN_CRESTS_BELOW_CLIP_LEVEL = 256, 8
"""Highest crests of a channel that are kept, and the fewest below a level that say how likely it
is by chance."""


MIN_CLIP_IMPROBABILITY_LOG10 = 4.0
"""Powers of ten against the highest crests being alike by chance from which they were cut off."""


MAX_SHARE_OF_BLOCKS_ABOVE_CLIP_LEVEL = 0.1
"""Share of blocks that may reach beyond a level that crests are cut off at."""


def reconstruct_clipped_peaks(x: FloatArray, clips: FaultIntervals, start: int) -> FloatArray:
    """Return samples (n,) from `start` on with clipped crests put back, as parabolas."""
    low = np.searchsorted(clips.runs[:, 1], start, "right")
    high = np.searchsorted(clips.runs[:, 0], start + x.size)
    out = x.copy()
    for (first, last), size in zip(clips.runs[low:high], clips.sizes[low:high], strict=True):
        place = np.arange(max(first, start), min(last, start + x.size))
        u = (place - first + 1) / (last - first + 1)
        out[place - start] += 4 * size * u * (1 - u)
    return out


def extremes_of_runs(
    x: FloatArray, first: IntArray, last: IntArray
) -> tuple[FloatArray, FloatArray]:
    """Return the highest and lowest (k,) of runs of samples, none of them at the end of x."""
    ends = np.stack([first, last], -1).ravel()
    return np.maximum.reduceat(x, ends)[::2], np.minimum.reduceat(x, ends)[::2]


def clipped_heights(x: FloatArray, first: IntArray, last: IntArray) -> FloatArray:
    """Return what stands on top (k,) of level crests of x: a parabola through their flanks.

    Noise breaks a crest that was cut off into several; those close together are one.
    """
    if not first.size:
        return np.empty(0)
    near = first[1:] - last[:-1] <= np.maximum(last[:-1] - first[:-1], MIN_CLIPPED_SAMPLES)
    near &= x[first[1:]] == x[first[:-1]]
    group = np.concatenate([[0], np.cumsum(~near)])
    begin = first[np.searchsorted(group, np.arange(group[-1] + 1))]
    end = last[np.searchsorted(group, np.arange(group[-1] + 1), "right") - 1]
    # Each part carries the crest's whole height: together they are one.
    return clipped_heights_by_flank(x, begin, end).mean(axis=-1)[group]


def clipped_heights_by_flank(x: FloatArray, first: IntArray, last: IntArray) -> FloatArray:
    """Return the same of whole crests by each flank, (k, 2), met some samples off the crest."""
    width = last - first
    away = _flank_distance(width)
    level = x[first]
    left = (level - x[np.maximum(first - away, 0)]) / away
    right = (level - x[np.minimum(last - 1 + away, x.size - 1)]) / away
    slopes = np.stack([left, right], -1)
    slopes = np.where((left + right < 0)[:, None], 0.0, slopes)
    return slopes * (width[:, None] + 1) / 4


def _flank_distance(width: IntArray) -> IntArray:
    """Return how many samples off crests of some widths their flanks are met."""
    return np.clip(width // 8, 2, 32)


def parabola_height_ratio(width: IntArray, side: IntArray) -> FloatArray:
    """Return `clipped_heights_by_flank` over the middle's range (k,) of uncut parabolas.

    Of few samples a middle ranges over fewer yet: of five, three, and it is nine.
    """
    middle = (width - 1) / 2 - side
    return (width - 1 + _flank_distance(width)) * (width + 1) / (4 * middle**2)


class PeakTracker:
    """The highest crests of any width, of which fast ones that were cut off are alike to the step.

    Columns: level, first and last sample, drop to the nearer neighbour, crown.
    """

    def __init__(self) -> None:
        self.rows: FloatArray = np.empty((0, 5))

    def update(
        self, x: FloatArray, begin: IntArray, end: IntArray, *, reach: int, start: int, size: int
    ) -> None:
        """Enter the crests that begin within a piece, level or not: what is level is known (k,)."""
        bar = self.rows[:, 0].min() if len(self.rows) >= MAX_KEPT_CRESTS else -np.inf
        least = max(reach, 3)
        mine = x[least : reach + size]
        first = np.flatnonzero((mine >= bar) & (mine > x[least - 1 : reach + size - 1])) + least
        last = first + 1
        _, here, level = np.intersect1d(first, begin, assume_unique=True, return_indices=True)
        last[here] = end[level]
        first, last = first[last < x.size - 3], last[last < x.size - 3]
        first, last = first[x[last - 1] > x[last]], last[x[last - 1] > x[last]]
        if first.size > MAX_KEPT_CRESTS:
            high = x[first] >= np.partition(x[first], -MAX_KEPT_CRESTS)[-MAX_KEPT_CRESTS]
            first, last = first[high], last[high]
        drop = np.minimum(x[first] - x[first - 1], x[last - 1] - x[last])
        crown = clipped_heights_by_flank(x, first, last).mean(axis=-1)
        columns = (x[first], first + start, last + start, drop, crown)
        fresh = np.stack([np.asarray(c, float) for c in columns], -1)
        rows = np.concatenate([self.rows, fresh])
        self.rows = rows[np.argsort(-rows[:, 0], kind="stable")[:MAX_KEPT_CRESTS]]

    def clipped_peaks(self, step: float, taken: IntArray) -> FloatArray:
        """Return (k, 3) first, last and crown of the highest, where chance makes none so alike.

        By chance a crest falls on the highest one's step as often as crests lie as close below
        it, or as they are alike there, as of slow data in coarse steps or of a test that repeats;
        and a sample next to it as often as the drop next to it has steps.
        """
        none: FloatArray = np.empty((0, 3))
        order = np.argsort(self.rows[:, 1], kind="stable")
        spoiled = np.empty(len(order), bool)
        spoiled[order] = overlaps(self.rows[order, 1:3].astype(np.intp), taken)
        rows = self.rows[~spoiled]
        if not (len(rows) and step < np.inf):
            return none
        step = max(step, float(np.spacing(np.abs(rows[:, [0, 3]]).max())))
        alike = rows[0, 0] - rows[:, 0] <= step / 2
        top, below = (
            rows[alike],
            rows[~alike][: max(MIN_CRESTS_BELOW_CLIP_LEVEL, 4 * np.count_nonzero(alike))],
        )
        width = top[:, 2] - top[:, 1]
        if len(below) < MIN_CRESTS_BELOW_CLIP_LEVEL or width.max() >= MIN_CLIPPED_SAMPLES:
            return none
        gaps = -np.diff(below[:, 0])
        often = max(len(below) * step / (top[0, 0] - below[-1, 0]), float(np.mean(gaps < step / 2)))
        beside = np.maximum(top[:, 3] / step, 1.0)
        against = (len(top) - 1) * -np.log10(min(often, 1.0))
        against += float(((width - 1) * np.log10(beside)).sum())
        return (
            top[:, [1, 2, 4]] if len(top) > 1 and against >= MIN_CLIP_IMPROBABILITY_LOG10 else none
        )


class ClippedPeaks:
    """Level crests of the highest few levels; what is low is entered upside down."""

    LEVELS = 3

    def __init__(self) -> None:
        self.rows: FloatArray = np.empty((0, 5))

    def update(self, level: FloatArray, *columns: FloatArray | IntArray) -> None:
        """Enter levels (k,), first and last samples, steps into the level, crowns."""
        fresh = np.stack([np.asarray(c, float) for c in (level, *columns)], -1)
        self.rows = np.concatenate([self.rows, fresh])
        if len(self.rows):
            known = np.unique(self.rows[:, 0])
            self.rows = self.rows[self.rows[:, 0] >= known[-self.LEVELS :][0]]

    def clipped_level(
        self, step: float, taken: IntArray, *, end: float, reached: FloatArray
    ) -> tuple[float, FloatArray]:
        """Return the level that crests are cut off at, and (k, 3) first, last and crown of each.

        A crest of slow data in coarse steps is level too; it is reached by one step. A single
        one below the channel's `end` stood still by chance, and what many blocks reach beyond
        (m,) cuts nothing off.
        """
        rows = self.rows[~overlaps(self.rows[:, 1:3].astype(np.intp), taken)]
        for level in np.unique(rows[:, 0])[::-1]:
            there = rows[rows[:, 0] == level]
            width, entry = there[:, 2] - there[:, 1], there[:, 3]
            long = width >= MIN_CLIPPED_SAMPLES
            cut = np.count_nonzero(long) > 1 or (level >= end and bool(long.any()))
            cut &= bool(long.any() and np.median(entry[long]) > 1.5 * step)
            steps = entry[width == 3] / step
            alone = bool((steps > MIN_SINGLE_CLIP_ENTRY_STEPS).any())
            cut |= level >= end and (
                np.count_nonzero(steps > MIN_SHORT_CLIP_ENTRY_RESOLUTION_STEPS) > 1 or alone
            )
            if cut and bool(np.mean(reached > level) < MAX_SHARE_OF_BLOCKS_ABOVE_CLIP_LEVEL):
                return float(level), there[:, [1, 2, 4]]
        return np.nan, np.empty((0, 3))
