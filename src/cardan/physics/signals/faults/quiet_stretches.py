"""Stretches in which a channel stops moving at once: frozen, but for its converter's noise.

A freeze that an amplifier adds noise to, or that a logger bridges by straight lines, keeps no
value. It shows by its ends: a part that comes to rest rings down over several blocks, a channel
that fails is loud in one block and silent in the next but one. A louder stretch is none unless it
is white noise about one level, as no part moves, between blocks that are as loud as usual.
"""

from dataclasses import dataclass

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
it that a stretch does not exceed, and that the blocks next to it do."""
MIN_LOUD_TO_QUIET_RATIO = 10.0
"""Times the stretch's own deviation that the blocks next to it have at least."""
MAX_NOISE_SHARE, MIN_LOUD_SHARE_BESIDE_NOISE, MIN_LOUD_TO_NOISE_RATIO = 0.25, 0.4, 4.0
"""The same three of a stretch that is white noise about one level."""
MIN_NOISE_S = 5.0
"""Shortest of these: while gears are shifted on a smooth road a gauge feels nothing for seconds."""
MIN_WHITENESS, MAX_LEVEL_STANDARD_ERRORS = 0.7, 4.0
"""Mean square of the differences between samples over twice their variance, 1 of white noise and
0.1 of what swings ten samples long; and how far the blocks' means stray, in standard errors."""
END_BLOCKS, MAX_END_TO_NOISE_RATIO = 4, 1.5
"""Blocks inside each end of it, and times its own deviation that their median is at most."""
NEIGHBOUR_BLOCKS, TRANSITION_BLOCKS = 6, 1
"""Blocks next to a stretch whose median is loud, which no single blow's is; and those between."""


@dataclass(frozen=True)
class _QuietBounds:
    """How long and quiet a stretch is, and how loud the blocks next to it are."""

    min_length_s: float
    max_share: float
    min_loud_share: float
    min_ratio: float


_SILENT_STRETCH = _QuietBounds(
    MIN_QUIET_S, MAX_QUIET_SHARE, MIN_LOUD_SHARE, MIN_LOUD_TO_QUIET_RATIO
)
_NOISE_ONLY_STRETCH = _QuietBounds(
    MIN_NOISE_S, MAX_NOISE_SHARE, MIN_LOUD_SHARE_BESIDE_NOISE, MIN_LOUD_TO_NOISE_RATIO
)


class QuietStretches:
    """Finds such stretches of one channel, as its pieces pass."""

    def __init__(self, rate: float) -> None:
        self.size = max(round(BLOCK_S * rate), MIN_BLOCK_SAMPLES)
        self.rate = rate
        self.tail: FloatArray = np.empty(0)
        self.blocks: list[npt.NDArray[np.float32]] = []
        place = np.arange(self.size) - (self.size - 1) / 2
        self.line = place / np.sqrt(place @ place)
        self.shift = np.nan

    def update(self, x: FloatArray) -> None:
        """Take the next samples (n,), nan where they are missing."""
        whole = np.concatenate([self.tail, x])
        full = whole.size // self.size * self.size
        rows = whole[:full].reshape(-1, self.size)
        level = rows.mean(-1, keepdims=True)
        rows = rows - level
        squares = np.einsum("ij,ij->i", rows, rows) - (rows @ self.line) ** 2
        deviation = np.sqrt(np.maximum(squares, 0.0) / self.size)
        step = np.diff(rows, axis=-1)
        moves = np.einsum("ij,ij->i", step, step) / (2 * (self.size - 1))
        if np.isnan(self.shift) and not np.isnan(level).all():
            self.shift = float(np.nanmean(level))
        blocks = np.stack([deviation, level[:, 0] - self.shift, np.sqrt(moves)])
        self.blocks.append(blocks.astype(np.float32))
        self.tail = whole[full:].copy()

    def result(self) -> FaultIntervals:
        """Return the stretches, and how far the channel deviates from lines next to them."""
        blocks = np.concatenate([np.empty((3, 0), np.float32), *self.blocks], -1).astype(float)
        deviation = blocks[0]
        known = deviation[deviation > 0]
        if not known.size:
            return fault_intervals([])
        usual = float(np.quantile(known, LOUD_QUANTILE))
        found = self._stretches(deviation, usual, _SILENT_STRETCH)
        for run, size in self._stretches(deviation, usual, _NOISE_ONLY_STRETCH):
            apart = all(run[1] <= a or b <= run[0] for (a, b), _ in found)
            if apart and self._is_noise(blocks[:, slice(*run)]):
                found.append((run, size))
        runs = [(first * self.size, last * self.size) for (first, last), _ in found]
        return fault_intervals(runs, [size for _, size in found])

    def _is_noise(self, blocks: FloatArray) -> bool:
        """Return whether blocks (3, m), their deviation, level and moves, are noise at a level."""
        deviation, level, moves = blocks
        still, inside = float(np.median(deviation)), deviation[TRANSITION_BLOCKS:]
        # A part that rings down is louder at the ends of its rest.
        ends = inside[:END_BLOCKS], inside[:-TRANSITION_BLOCKS][-END_BLOCKS:]
        if max(float(np.median(end)) for end in ends) > MAX_END_TO_NOISE_RATIO * still:
            return False
        # Two degrees of freedom go with the line through a block.
        variance = still**2 * self.size / (self.size - 2)
        astray = 1.48 * float(np.median(np.abs(level - np.median(level))))
        white = float(np.median(moves) ** 2) > MIN_WHITENESS * variance
        return white and astray < MAX_LEVEL_STANDARD_ERRORS * (variance / self.size) ** 0.5

    def _stretches(
        self, deviation: FloatArray, usual: float, bounds: _QuietBounds
    ) -> list[tuple[tuple[int, int], float]]:
        """Return runs of quiet blocks between loud ones, and how loud these are."""
        # What is missing is neither quiet nor loud.
        quiet = np.nan_to_num(deviation, nan=np.inf) <= bounds.max_share * usual
        edge = np.flatnonzero(np.diff(np.concatenate([[False], quiet, [False]])))
        found: list[tuple[tuple[int, int], float]] = []
        for first, last in zip(edge[::2].tolist(), edge[1::2].tolist(), strict=True):
            if last - first < max(bounds.min_length_s * self.rate / self.size, MIN_QUIET_BLOCKS):
                continue
            before = deviation[: max(first - TRANSITION_BLOCKS, 0)][-NEIGHBOUR_BLOCKS:]
            behind = deviation[last + TRANSITION_BLOCKS :][:NEIGHBOUR_BLOCKS]
            beside = [float(np.median(b)) for b in (before, behind) if b.size == NEIGHBOUR_BLOCKS]
            # A parked vehicle may be started at once: a recording's first stretch says nothing.
            still = float(np.median(deviation[first:last]))
            loud = max(bounds.min_loud_share * usual, bounds.min_ratio * still)
            if first > TRANSITION_BLOCKS and beside and min(beside) >= loud:
                found.append(((first, last), min(beside)))
        return found
