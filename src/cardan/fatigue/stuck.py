"""A bit of a converter that stands still: half of all codes never come.

Whatever a channel measures passes through every band of values; but one in which each second band
is empty, all as wide as each other, was written by a converter of which a bit does not move.
"""

import numpy as np

from cardan.base.arrays import FloatArray

MOST = 1 << 16
"""Samples that are kept: every one, then each second, fourth and so on."""
WIDE, FEWEST = 1 / 64, 2
"""Share of what it spans that a band has at least, and the fewest bands."""
ALIKE = 0.15
"""How far widths and distances may be off, relative: the codes at their edges are not all met."""
SHARP = 0.5
"""Of as many as there are in the mean, the samples beside an empty band in a quarter of its width:
levels that something is switched between thin out."""


class Codes:
    """Keeps some samples of a channel: `add` each piece, then ask `found`."""

    def __init__(self) -> None:
        self.every, self.kept = 1, list[FloatArray]()
        self.count = 0

    def add(self, x: FloatArray, *, start: int) -> None:
        """Take samples (n,) from `start` on, some of them missing (nan)."""
        some = x[-start % self.every :: self.every].copy()  # a view would hold the whole piece
        self.kept.append(some)
        self.count += some.size
        while self.count > MOST:
            # What is kept lies at multiples of `every`: half of these at twice that.
            whole = np.concatenate(self.kept)[::2]
            self.every, self.kept, self.count = 2 * self.every, [whole], whole.size

    def found(self) -> float:
        """Return how much the bit is worth, in the channel's unit; 0 where all move."""
        x = np.concatenate([np.empty(0), *self.kept])
        x = np.sort(x[~np.isnan(x)])
        x = x[int(0.01 * x.size) : x.size - int(0.01 * x.size)]
        if x.size < 1000 or not x[-1] > x[0]:
            return 0.0
        gap = np.diff(x)
        at = np.flatnonzero(gap > WIDE * (x[-1] - x[0]))
        if at.size < FEWEST:
            return 0.0
        width = float(np.median(gap[at]))
        apart = np.diff(x[at])
        even = np.abs(gap[at] - width).max() < ALIKE * width
        even &= np.abs(apart - 2 * width).max() < 2 * ALIKE * width
        low, high = x[at], x[at + 1]
        beside = [
            np.searchsorted(x, e + width / 4) - np.searchsorted(x, e - width / 4)
            for e in (low, high)
        ]
        even &= np.min(beside) > SHARP * x.size * width / 4 / (x[-1] - x[0])
        return width if even else 0.0
