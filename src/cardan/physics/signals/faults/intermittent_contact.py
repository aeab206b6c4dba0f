"""White noise for some tenths of a second: a contact that chatters, a wire that is torn off.

Whatever hits a structure, it answers at its own frequencies, or is over at once. A contact that
comes and goes writes all frequencies alike for as long as it does. So blocks of some samples are
met that are as flat in frequency as noise is, as even in time, and far louder than blocks usually
are up there; an anti-alias filter takes the uppermost frequencies of both.
"""

import numpy as np

from cardan.core.arrays import FloatArray, IntArray
from cardan.physics.signals.faults.fault_kind import (
    ChannelStatistics,
    FaultKind,
    FaultSource,
    SignalBlock,
)
from cardan.physics.signals.faults.intervals import FaultIntervals, fault_intervals

FAULT_NOISE = "noise"

BLOCK_SAMPLES = 32
"""Samples of a block."""
SPECTRUM_LINES = slice(3, 11)
"""Of its spectrum, that are looked at: from 0.09 to 0.31 of the sample rate."""
MIN_BLOCK_FLATNESS = 0.35
"""Geometric over arithmetic mean of their powers, from which they are flat; of white noise 0.5 to
0.6 in the mean, of a mode's ring 0.05."""
MIN_BURST_FLATNESS_RATIO = 0.75
"""Flatness of their mean over a burst, over that of noise: of noise 0.9 to 1.2, of a mode that
rings on a rough road, of which some blocks are flat by chance, 0.3 to 0.6."""
MAX_BLOCK_KURTOSIS = 4.5
"""Fourth moment over the square of the second up to which a block is even; of noise 3, of a single
blow 10 and more."""
MIN_BLOCK_TO_MEDIAN_POWER_RATIO, MIN_RMS_TO_RANGE_RATIO = 36.0, 0.05
"""Times their median power up there, and share of the whole range in rms, that blocks have."""
HISTOGRAM_BINS_PER_OCTAVE = 4
"""Bins of the histogram of powers, an octave."""
POWER_HISTOGRAM_BIN_INDICES = np.arange(-4096, 4096)
MAX_HELD_CANDIDATE_BLOCKS, MAX_LATER_MEDIAN_POWER_DROP_FACTOR = 1 << 14, 12.0
"""Blocks that are held until those are let go that will not do, and how far the median power of all
may yet fall: a channel white for minutes is seldom louder than usual."""


class IntermittentContactDetector:
    """Meets a channel block by block, as its pieces pass."""

    def __init__(self) -> None:
        self.usual = np.zeros(POWER_HISTOGRAM_BIN_INDICES.size, np.intp)
        self.starts: list[IntArray] = []
        self.powers: list[FloatArray] = []
        self.lines: list[FloatArray] = []
        self.held, self.most = 0, MAX_HELD_CANDIDATE_BLOCKS
        self.low, self.high = np.inf, -np.inf

    def update(self, block: SignalBlock) -> None:
        """Take a piece, and of the samples that follow what its last block needs."""
        ahead, start, size = block.ahead, block.start, block.size
        piece = ahead[:size]
        self.low, self.high = min(self.low, piece.min()), max(self.high, piece.max())
        first = -start % BLOCK_SAMPLES  # blocks lie where they lie, however the pieces are cut
        count = max((size - first + BLOCK_SAMPLES - 1) // BLOCK_SAMPLES, 0)
        count = min(count, (ahead.size - first) // BLOCK_SAMPLES)
        if count <= 0:
            return
        rows = ahead[first : first + count * BLOCK_SAMPLES].reshape(-1, BLOCK_SAMPLES)
        step = np.diff(rows, axis=-1)
        power = np.square(step).mean(-1)
        moved = power > 0
        octave = np.round(HISTOGRAM_BINS_PER_OCTAVE * np.log2(power[moved])).astype(np.intp)
        self.usual += np.bincount(
            np.clip(
                octave - POWER_HISTOGRAM_BIN_INDICES[0], 0, POWER_HISTOGRAM_BIN_INDICES.size - 1
            ),
            None,
            POWER_HISTOGRAM_BIN_INDICES.size,
        )
        # Half the power of white noise is what it differs by from sample to sample.
        loud = np.flatnonzero(power > 2 * (MIN_RMS_TO_RANGE_RATIO * (self.high - self.low)) ** 2)
        rows, step = rows[loud], step[loud]
        lines = (
            np.abs(np.fft.rfft(rows * np.hanning(BLOCK_SAMPLES), axis=-1))[:, SPECTRUM_LINES] ** 2
        )
        flat = _flatness(lines) > MIN_BLOCK_FLATNESS
        even = (step**4).mean(-1) < MAX_BLOCK_KURTOSIS * power[loud] ** 2
        kept = loud[flat & even]
        self.lines.append(lines[flat & even])
        self.starts.append(start + first + kept * BLOCK_SAMPLES)
        self.powers.append(power[kept])
        self.held += kept.size
        if self.held > self.most:
            self._thin()

    def _thin(self) -> None:
        """Let go of blocks that are hardly louder than all: of a white channel they are a file."""
        powers = np.concatenate(self.powers)
        loud = (
            powers
            > MIN_BLOCK_TO_MEDIAN_POWER_RATIO / MAX_LATER_MEDIAN_POWER_DROP_FACTOR * self._typical()
        )
        self.powers = [powers[loud]]
        self.starts = [np.concatenate(self.starts)[loud]]
        self.lines = [np.concatenate(self.lines)[loud]]
        self.held = self.powers[0].size
        self.most = max(MAX_HELD_CANDIDATE_BLOCKS, 2 * self.held)

    def _typical(self) -> float:
        """Return the median power of all blocks that moved."""
        met = np.cumsum(self.usual)
        return float(
            2.0
            ** (
                POWER_HISTOGRAM_BIN_INDICES[np.searchsorted(met, met[-1] / 2)]
                / HISTOGRAM_BINS_PER_OCTAVE
            )
        )

    def result(self, _: ChannelStatistics) -> dict[str, FaultIntervals]:
        """Return the bursts of white noise."""
        return {FAULT_NOISE: fault_intervals(self._white_runs())}

    def _white_runs(self) -> IntArray:
        """Return the runs (k, 2) of samples that are white, with what they began and ended in."""
        starts = np.concatenate([np.empty(0, np.intp), *self.starts])
        powers = np.concatenate([np.empty(0), *self.powers])
        if not starts.size or not self.usual.any():
            return np.empty((0, 2), np.intp)
        least = max(
            MIN_BLOCK_TO_MEDIAN_POWER_RATIO * self._typical(),
            2 * (MIN_RMS_TO_RANGE_RATIO * (self.high - self.low)) ** 2,
        )
        enough = powers > least
        starts, lines = starts[enough], np.concatenate(self.lines)[enough]
        if not starts.size:
            return np.empty((0, 2), np.intp)
        fresh = np.diff(starts, prepend=-4 * BLOCK_SAMPLES) > 3 * BLOCK_SAMPLES
        last = starts[np.append(np.flatnonzero(fresh)[1:] - 1, starts.size - 1)] + BLOCK_SAMPLES
        runs = np.stack([np.maximum(starts[fresh] - BLOCK_SAMPLES, 0), last + BLOCK_SAMPLES], -1)
        # Once is chance: a contact chatters for two blocks at least, and all together are white.
        at = np.flatnonzero(fresh)
        white = _flatness(
            np.add.reduceat(lines, at)
        ) > MIN_BURST_FLATNESS_RATIO * _white_noise_flatness(np.diff(at, append=starts.size))
        return runs[white & (runs[:, 1] - runs[:, 0] >= 4 * BLOCK_SAMPLES)]


def _flatness(lines: FloatArray) -> FloatArray:
    """Return the geometric over the arithmetic mean of powers (..., lines)."""
    return np.exp(np.log(np.maximum(lines, 1e-300)).mean(-1)) / np.maximum(lines.mean(-1), 1e-300)


def _white_noise_flatness(count: IntArray) -> FloatArray:
    """Return the flatness that the mean of so many (k,) spectra of white noise has."""
    from scipy.special import digamma

    return np.exp(digamma(count)) / count


FAULT_SOURCE = FaultSource(
    kinds=(FaultKind(code=FAULT_NOISE, maskable=True),),
    detector=lambda _: IntermittentContactDetector(),
)
