"""Stretches in which a channel stops moving at once: frozen, but for its converter's noise.

A freeze that an amplifier adds noise to, or that a logger bridges by straight lines, keeps no
value. It shows by its ends: a part that comes to rest rings down over several blocks, a channel
that fails is loud in one block and silent in the next but one.
"""

import numpy as np
import numpy.typing as npt

from cardan.core.arrays import FloatArray
from cardan.physics.signals.faults.intervals import FaultIntervals, fault_intervals

BLOCK_S, MIN_BLOCK_SAMPLES = 0.05, 8
"""Time of a block, and its fewest samples."""
MIN_QUIET_S, MIN_QUIET_BLOCKS = 0.5, 6
"""Shortest stretch that is found."""
LOUD_QUANTILE, MAX_QUIET_SHARE, MIN_LOUD_SHARE = 0.75, 0.03, 0.1
"""Quantile of the blocks' deviations that a stretch and its neighbours are compared with; share of
it that a stretch does not exceed, and that the blocks beside it do."""
MIN_LOUD_TO_QUIET_RATIO = 10.0
"""Times the stretch's own deviation that the blocks beside it have at least."""
NEIGHBOUR_BLOCKS, TRANSITION_BLOCKS = 6, 1
"""Blocks beside a stretch whose median is loud, which no single blow's is; and those between."""


class QuietStretches:
    """Finds such stretches of one channel, as its pieces pass."""

    def __init__(self, rate: float) -> None:
        self.size = max(round(BLOCK_S * rate), MIN_BLOCK_SAMPLES)
        self.least = max(round(MIN_QUIET_S * rate / self.size), MIN_QUIET_BLOCKS)
        self.tail: FloatArray = np.empty(0)
        self.deviations: list[npt.NDArray[np.float32]] = []
        place = np.arange(self.size) - (self.size - 1) / 2
        self.line = place / np.sqrt(place @ place)

    def update(self, x: FloatArray) -> None:
        """Take the next samples (n,), nan where they are missing."""
        whole = np.concatenate([self.tail, x])
        full = whole.size // self.size * self.size
        rows = whole[:full].reshape(-1, self.size)
        rows = rows - rows.mean(-1, keepdims=True)
        squares = np.einsum("ij,ij->i", rows, rows) - (rows @ self.line) ** 2
        deviation = np.sqrt(np.maximum(squares, 0.0) / self.size)
        self.deviations.append(deviation.astype(np.float32))
        self.tail = whole[full:].copy()

    def result(self) -> FaultIntervals:
        """Return the stretches, and how far the channel deviates from lines beside them."""
        deviation = np.concatenate([np.empty(0, np.float32), *self.deviations]).astype(float)
        known = deviation[deviation > 0]
        if not known.size:
            return fault_intervals([])
        usual = float(np.quantile(known, LOUD_QUANTILE))
        # What is missing is neither quiet nor loud.
        quiet = np.nan_to_num(deviation, nan=np.inf) <= MAX_QUIET_SHARE * usual
        edge = np.flatnonzero(np.diff(np.concatenate([[False], quiet, [False]])))
        runs: list[tuple[int, int]] = []
        sizes: list[float] = []
        for first, last in zip(edge[::2].tolist(), edge[1::2].tolist(), strict=True):
            if last - first < self.least:
                continue
            before = deviation[: max(first - TRANSITION_BLOCKS, 0)][-NEIGHBOUR_BLOCKS:]
            behind = deviation[last + TRANSITION_BLOCKS :][:NEIGHBOUR_BLOCKS]
            beside = [float(np.median(b)) for b in (before, behind) if b.size == NEIGHBOUR_BLOCKS]
            # A parked vehicle may be started at once: a recording's first stretch says nothing.
            still = float(np.median(deviation[first:last]))
            loud = max(MIN_LOUD_SHARE * usual, MIN_LOUD_TO_QUIET_RATIO * still)
            if first > TRANSITION_BLOCKS and beside and min(beside) >= loud:
                runs.append((first * self.size, last * self.size))
                sizes.append(min(beside))
        return fault_intervals(runs, sizes)
