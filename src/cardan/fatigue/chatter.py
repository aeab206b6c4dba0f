"""White noise for some tenths of a second: a contact that chatters, a wire that is torn off.

Whatever hits a structure, it answers at its own frequencies, or is over at once. A contact that
comes and goes writes all frequencies alike for as long as it does. So blocks of some samples are
met that are as flat in frequency as noise is, as even in time, and far louder than blocks usually
are up there; an anti-alias filter takes the uppermost frequencies of both.
"""

import numpy as np

from cardan.base.arrays import FloatArray, IntArray

SIZE = 32
"""Samples of a block."""
LINES = slice(3, 11)
"""Of its spectrum, that are looked at: from 0.09 to 0.31 of the sample rate."""
FLAT = 0.35
"""Geometric over arithmetic mean of their powers, from which they are flat; of white noise 0.5 to
0.6 in the mean, of a mode's ring 0.05."""
SAME = 0.75
"""Flatness of their mean over a burst, over that of noise: of noise 0.9 to 1.2, of a mode that
rings on a rough road, of which some blocks are flat by chance, 0.3 to 0.6."""
EVEN = 4.5
"""Fourth moment over the square of the second up to which a block is even; of noise 3, of a single
blow 10 and more."""
LOUD, REACHES = 36.0, 0.05
"""Times their median power up there, and share of the whole range in rms, that blocks have."""
OCTAVE = 4
"""Bins of the histogram of powers, an octave."""
ROUND = np.arange(-4096, 4096)
MOST, FALLS = 1 << 14, 12.0
"""Blocks that are held until those are let go that will not do, and how far the median power of all
may yet fall: who is white for minutes is seldom louder than usual."""


class Chatter:
    """Meets a channel block by block: `add` each piece, then ask `found`."""

    def __init__(self) -> None:
        self.usual = np.zeros(ROUND.size, np.intp)
        self.starts: list[IntArray] = []
        self.powers: list[FloatArray] = []
        self.lines: list[FloatArray] = []
        self.held, self.most = 0, MOST
        self.low, self.high = np.inf, -np.inf

    def add(self, ahead: FloatArray, *, start: int, size: int) -> None:
        """Take samples from `start` on, without holes: `size` of them, and some that follow."""
        piece = ahead[:size]
        self.low, self.high = min(self.low, piece.min()), max(self.high, piece.max())
        first = -start % SIZE  # blocks lie where they lie, however the pieces are cut
        count = max((size - first + SIZE - 1) // SIZE, 0)
        count = min(count, (ahead.size - first) // SIZE)
        if count <= 0:
            return
        rows = ahead[first : first + count * SIZE].reshape(-1, SIZE)
        step = np.diff(rows, axis=-1)
        power = np.square(step).mean(-1)
        moved = power > 0
        octave = np.round(OCTAVE * np.log2(power[moved])).astype(np.intp)
        self.usual += np.bincount(np.clip(octave - ROUND[0], 0, ROUND.size - 1), None, ROUND.size)
        # Half the power of white noise is what it differs by from sample to sample.
        loud = np.flatnonzero(power > 2 * (REACHES * (self.high - self.low)) ** 2)
        rows, step = rows[loud], step[loud]
        lines = np.abs(np.fft.rfft(rows * np.hanning(SIZE), axis=-1))[:, LINES] ** 2
        flat = _flatness(lines) > FLAT
        even = (step**4).mean(-1) < EVEN * power[loud] ** 2
        kept = loud[flat & even]
        self.lines.append(lines[flat & even])
        self.starts.append(start + first + kept * SIZE)
        self.powers.append(power[kept])
        self.held += kept.size
        if self.held > self.most:
            self._thin()

    def _thin(self) -> None:
        """Let go of blocks that are hardly louder than all: of a white channel they are a file."""
        powers = np.concatenate(self.powers)
        loud = powers > LOUD / FALLS * self._typical()
        self.powers = [powers[loud]]
        self.starts = [np.concatenate(self.starts)[loud]]
        self.lines = [np.concatenate(self.lines)[loud]]
        self.held = self.powers[0].size
        self.most = max(MOST, 2 * self.held)

    def _typical(self) -> float:
        """Return the median power of all blocks that moved."""
        met = np.cumsum(self.usual)
        return float(2.0 ** (ROUND[np.searchsorted(met, met[-1] / 2)] / OCTAVE))

    def found(self) -> IntArray:
        """Return the runs (k, 2) of samples that are white, with what they began and ended in."""
        starts = np.concatenate([np.empty(0, np.intp), *self.starts])
        powers = np.concatenate([np.empty(0), *self.powers])
        if not starts.size or not self.usual.any():
            return np.empty((0, 2), np.intp)
        least = max(LOUD * self._typical(), 2 * (REACHES * (self.high - self.low)) ** 2)
        enough = powers > least
        starts, lines = starts[enough], np.concatenate(self.lines)[enough]
        if not starts.size:
            return np.empty((0, 2), np.intp)
        fresh = np.diff(starts, prepend=-4 * SIZE) > 3 * SIZE
        last = starts[np.append(np.flatnonzero(fresh)[1:] - 1, starts.size - 1)] + SIZE
        runs = np.stack([np.maximum(starts[fresh] - SIZE, 0), last + SIZE], -1)
        # Once is chance: a contact chatters for two blocks at least, and all together are white.
        at = np.flatnonzero(fresh)
        white = _flatness(np.add.reduceat(lines, at)) > SAME * _usual(
            np.diff(at, append=starts.size)
        )
        return runs[white & (runs[:, 1] - runs[:, 0] >= 4 * SIZE)]


def _flatness(lines: FloatArray) -> FloatArray:
    """Return the geometric over the arithmetic mean of powers (..., lines)."""
    return np.exp(np.log(np.maximum(lines, 1e-300)).mean(-1)) / np.maximum(lines.mean(-1), 1e-300)


def _usual(count: IntArray) -> FloatArray:
    """Return the flatness that the mean of so many (k,) spectra of white noise has."""
    from scipy.special import digamma

    return np.exp(digamma(count)) / count
