"""A bit of a converter that stands still: half of all codes never come.

Whatever a channel measures passes through every band of values; but one in which each second band
is empty, all as wide as each other, was written by a converter of which a bit does not move.
"""

from dataclasses import dataclass

import numpy as np

from cardan.core.arrays import FloatArray
from cardan.physics.signals.faults.fault_kind import (
    ChannelStatistics,
    DetectedFaults,
    FaultKind,
    FaultSource,
    SignalBlock,
)

FAULT_BIT = "bit"

MAX_KEPT_SAMPLES = 1 << 16
"""Samples that are kept: every one, then each second, fourth and so on."""
MIN_EMPTY_BAND_WIDTH_SHARE_OF_RANGE, MIN_EMPTY_BANDS = 1 / 64, 2
"""Share of what it spans that a band has at least, and the fewest bands."""
MAX_BAND_WIDTH_DEVIATION_SHARE = 0.15
"""How far widths and distances may be off, relative: the codes at their edges are not all met."""
MIN_BAND_EDGE_TO_MEAN_DENSITY_RATIO = 0.5
"""Of as many as there are in the mean, the samples next to an empty band in a quarter of its width:
levels that something is switched between thin out."""


@dataclass(frozen=True)
class StuckBit:
    """A bit that stands still, and how much it is worth in the channel's unit."""

    size: float

    @property
    def details(self) -> dict[str, object]:
        """No value in addition to its size."""
        return {}

    def removed_from(self, x: FloatArray, _: int) -> FloatArray:
        """Return the samples as they are: what the bit hid is unknown."""
        return x


class StuckBitDetector:
    """Keeps some samples of a channel, as its pieces pass."""

    def __init__(self) -> None:
        self.every, self.kept = 1, list[FloatArray]()
        self.count = 0

    def update(self, block: SignalBlock) -> None:
        """Take a piece."""
        # A view would hold the whole piece.
        some = block.samples[-block.start % self.every :: self.every].copy()
        self.kept.append(some)
        self.count += some.size
        while self.count > MAX_KEPT_SAMPLES:
            # What is kept lies at multiples of `every`: half of these at twice that.
            whole = np.concatenate(self.kept)[::2]
            self.every, self.kept, self.count = 2 * self.every, [whole], whole.size

    def result(self, _: ChannelStatistics) -> DetectedFaults:
        """Return the bit that stands still, if one does."""
        size = self._bit_value()
        return {FAULT_BIT: StuckBit(size)} if size else {}

    def _bit_value(self) -> float:
        """Return how much the bit is worth, in the channel's unit; 0 where all move."""
        x = np.concatenate([np.empty(0), *self.kept])
        x = np.sort(x[~np.isnan(x)])
        x = x[int(0.01 * x.size) : x.size - int(0.01 * x.size)]
        if x.size < 1000 or not x[-1] > x[0]:
            return 0.0
        gap = np.diff(x)
        at = np.flatnonzero(gap > MIN_EMPTY_BAND_WIDTH_SHARE_OF_RANGE * (x[-1] - x[0]))
        if at.size < MIN_EMPTY_BANDS:
            return 0.0
        width = float(np.median(gap[at]))
        apart = np.diff(x[at])
        even = np.abs(gap[at] - width).max() < MAX_BAND_WIDTH_DEVIATION_SHARE * width
        even &= np.abs(apart - 2 * width).max() < 2 * MAX_BAND_WIDTH_DEVIATION_SHARE * width
        low, high = x[at], x[at + 1]
        beside = [
            np.searchsorted(x, e + width / 4) - np.searchsorted(x, e - width / 4)
            for e in (low, high)
        ]
        even &= np.min(beside) > MIN_BAND_EDGE_TO_MEAN_DENSITY_RATIO * x.size * width / 4 / (
            x[-1] - x[0]
        )
        return width if even else 0.0


FAULT_SOURCE = FaultSource(
    kinds=(FaultKind(code=FAULT_BIT, impossible=True),), detector=lambda _: StuckBitDetector()
)
