"""A channel that was turned over wherever it crossed zero: somebody wrote its absolute value.

It bounces off zero as no stress does: at the bottom a stress turns round, and what crossed zero
goes straight on, upside down. So there are many lowest points that are sharp.
"""

import numpy as np

from cardan.base.arrays import FloatArray, IntArray

FEWEST = 20
"""Bounces from which it is no chance."""
SHARP = 2.8
"""How many times as far four samples off a lowest point stand off it as two do: of a corner 2, of a
bend 4."""
MOSTLY = 0.6
"""Share of the lowest points that is sharp."""


class Folded:
    """Meets a channel's lowest points: `add` each piece, then ask `found`."""

    def __init__(self) -> None:
        self.low = np.inf
        self.at: list[IntArray] = []
        self.sharp = self.points = 0

    def add(self, padded: FloatArray, *, reach: int, start: int) -> None:
        """Take a piece with `reach` neighbours on both sides, 4 at least, without holes."""
        x = padded[reach : padded.size - reach]
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
        sharp = far < SHARP * near
        self.sharp, self.points = self.sharp + int(sharp.sum()), self.points + sharp.size
        bottom = bottom[sharp]
        # Behind the lowest point where it came faster than it goes.
        late = before[bottom] > behind[bottom]
        self.at.append(bottom + late + start)

    def found(self) -> IntArray:
        """Return the samples (k,) from which on it is upside down, and back again."""
        if not self.at or self.low < 0 or self.sharp < max(FEWEST, MOSTLY * self.points):
            return np.empty(0, np.intp)
        return np.concatenate(self.at)
