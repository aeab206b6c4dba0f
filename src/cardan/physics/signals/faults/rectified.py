"""A channel that was turned over wherever it crossed zero: its absolute value was written.

It bounces off zero as no stress does: at the bottom a stress turns round, and what crossed zero
goes straight on, upside down. So there are many lowest points that are sharp.
"""

import numpy as np

from cardan.core.arrays import IntArray
from cardan.physics.signals.faults import gain_change
from cardan.physics.signals.faults.fault_kind import ChannelStatistics, FaultSource, SignalBlock
from cardan.physics.signals.faults.gain_change import FAULT_GAIN
from cardan.physics.signals.faults.intervals import FaultIntervals

MIN_BOUNCES = 20
"""Bounces from which it is no chance."""
MAX_CORNER_HEIGHT_RATIO_4_TO_2_SAMPLES = 2.8
"""How many times as far four samples off a lowest point stand off it as two do: of a corner 2, of a
bend 4."""
MIN_SHARP_SHARE_OF_MINIMA = 0.6
"""Share of the lowest points that is sharp."""


class RectificationDetector:
    """Meets a channel's lowest points, as its pieces pass: some neighbours of each are needed."""

    def __init__(self) -> None:
        self.low = np.inf
        self.at: list[IntArray] = []
        self.sharp = self.points = 0

    def update(self, block: SignalBlock) -> None:
        """Take a piece with 4 neighbours at least on both sides."""
        padded, reach, x = block.filled, block.reach, block.filled_samples
        self.low = min(self.low, float(x.min(initial=np.inf)))
        if self.low < 0:
            self.at = []
            return
        before, behind = padded[reach - 1 : -reach - 1], padded[reach + 1 : padded.size - reach + 1]
        # What crosses zero between two samples stands half a step off it at most.
        bottom = np.flatnonzero((x < before) & (x < behind) & (4 * x <= before + behind))
        near, far = (
            padded[bottom + reach - k] + padded[bottom + reach + k] - 2 * x[bottom] for k in (2, 4)
        )
        sharp = far < MAX_CORNER_HEIGHT_RATIO_4_TO_2_SAMPLES * near
        self.sharp, self.points = self.sharp + int(sharp.sum()), self.points + sharp.size
        bottom = bottom[sharp]
        # Behind the lowest point where it came faster than it goes.
        late = before[bottom] > behind[bottom]
        self.at.append(bottom + late + block.start)

    def result(self, _: ChannelStatistics) -> dict[str, FaultIntervals]:
        """Return where it is upside down from, and back again: a gain of -1 each."""
        at = self._turns()
        if not at.size:
            return {}
        return {FAULT_GAIN: FaultIntervals(np.stack([at, at + 1], -1), np.full(at.size, -1.0))}

    def _turns(self) -> IntArray:
        """Return the samples (k,) from which on it is upside down, and back again."""
        if (
            not self.at
            or self.low < 0
            or self.sharp < max(MIN_BOUNCES, MIN_SHARP_SHARE_OF_MINIMA * self.points)
        ):
            return np.empty(0, np.intp)
        return np.concatenate(self.at)


FAULT_SOURCE = FaultSource(kinds=(gain_change.KIND,), detector=lambda _: RectificationDetector())
