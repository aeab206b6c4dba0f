"""Places of a fault in a channel: runs of samples, and how large each is."""

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from cardan.core.arrays import BoolArray, FloatArray, IntArray


@dataclass(frozen=True)
class FaultIntervals:
    """Where a channel shows one kind of fault.

    Attributes
    ----------
    runs : (k, 2) samples
        First, and one behind the last; in order, none overlapping.
    sizes : (k,)
        How far each stands off what is about it, in the channel's unit: a jump's height, for a
        clip what a parabola through its flanks puts on top, signed; for a freeze how far the
        channel moves within a tenth of a second of its ends, 0 where it comes to rest by itself.
    """

    runs: IntArray
    sizes: FloatArray

    @property
    def count(self) -> int:
        """How many there are."""
        return len(self.runs)

    def select(self, kept: BoolArray) -> "FaultIntervals":
        """Return some of them."""
        return FaultIntervals(self.runs[kept], self.sizes[kept])

    @property
    def sample_count(self) -> int:
        """How many samples they are together."""
        return int((self.runs[:, 1] - self.runs[:, 0]).sum())


NO_FAULTS = FaultIntervals(np.empty((0, 2), np.intp), np.empty(0))


def fault_intervals(runs: Iterable[tuple[int, int]], sizes: Iterable[float] = ()) -> FaultIntervals:
    """Return places of runs of samples, in order; sizes are unknown (nan) unless given."""
    rows = np.array(list(runs), np.intp).reshape(-1, 2)
    heights = np.array(list(sizes), float)
    if heights.size != len(rows):
        heights = np.full(len(rows), np.nan)
    order = np.argsort(rows[:, 0], kind="stable")
    return FaultIntervals(rows[order], heights[order])


def with_sizes_of(places: FaultIntervals, other: FaultIntervals, *, within: int) -> FaultIntervals:
    """Return places with the sizes that another finding gives those it has as well.

    Of the same sign, and so many samples away at most; where either finds several so close
    together, which is which is unknown, and the sizes stay.
    """
    near = np.abs(places.runs[:, :1] - other.runs[:, 0]) <= within
    alone = np.abs(places.runs[:, :1] - places.runs[:, 0]) <= within
    sizes = places.sizes.copy()
    for k in np.flatnonzero((near.sum(-1) == 1) & (alone.sum(-1) == 1)):
        size = other.sizes[near[k]][0]
        sizes[k] = size if size * sizes[k] > 0 else sizes[k]
    return FaultIntervals(places.runs, sizes)


def merge_runs(parts: Iterable[IntArray]) -> IntArray:
    """Return runs (k, 2) that cover what any of some runs cover, in order and apart."""
    rows = np.concatenate([np.empty((0, 2), np.intp), *parts])
    if not len(rows):
        return rows
    rows = rows[np.argsort(rows[:, 0], kind="stable")]
    reach = np.maximum.accumulate(rows[:, 1])
    fresh = np.append(True, rows[1:, 0] > reach[:-1])
    last = np.append(np.flatnonzero(fresh)[1:] - 1, len(rows) - 1)
    return np.stack([rows[fresh, 0], reach[last]], -1)


def samples_in_runs(runs: IntArray, start: int, n: int) -> BoolArray:
    """Return which of the samples `start` to `start + n` lie in runs (k, 2) that are apart."""
    low, high = np.searchsorted(runs[:, 1], start, "right"), np.searchsorted(runs[:, 0], start + n)
    step = np.zeros(n + 1, np.int8)
    for first, last in runs[low:high]:
        step[max(first - start, 0)] += 1
        step[min(last - start, n)] -= 1
    return np.cumsum(step[:-1]) > 0


def overlaps(rows: IntArray, others: IntArray) -> BoolArray:
    """Which runs (k, 2) share a sample with others (m, 2), apart and in order."""
    if not len(others):
        return np.zeros(len(rows), bool)
    near = np.searchsorted(others[:, 1], rows[:, 0], "right")
    return (near < len(others)) & (others[np.minimum(near, len(others) - 1), 0] < rows[:, 1])
