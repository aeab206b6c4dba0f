"""What was written twice: the same numbers to the last digit, a second and more of them.

No road and no test bench does a thing twice to the last digit; a buffer that was stored twice
does. Some samples are chosen by their own digits, so that the same ones are chosen of a copy; what
follows them is told by a fingerprint, and where those of many agree at one distance, it is a copy.
"""

import numpy as np
import numpy.typing as npt

from cardan.base.arrays import FloatArray, IntArray

EACH = 64
"""Samples of which one is chosen."""
LENGTH = 16
"""Samples of a fingerprint."""
SECONDS, FEWEST, MOST = 0.5, 4, 0.5
"""Shortest distance of a copy, and fewest chosen samples in it; and of all, the share from which
whoever made the recording repeats, as a test bench in coarse steps."""
PARTS = 8
"""Of all fingerprints, by their first bits: those of one are held against each other at once."""
_MIX = np.uint64(0x9E3779B97F4A7C15)


class Twice:
    """Remembers a channel by its digits: `add` each piece, then ask `found`."""

    def __init__(self, rate: float) -> None:
        self.rate = rate
        self.starts: list[int] = []
        self.met: list[npt.NDArray[np.uint32]] = []

    def add(self, ahead: FloatArray, *, start: int, size: int) -> None:
        """Take samples from `start` on: `size` of them, and some that follow."""
        bits = np.add(ahead, 0.0, dtype=float).view(np.uint64)  # no minus nought
        size = min(size, ahead.size - LENGTH)
        if size <= 0:
            return
        mixed = bits[1 : size + 1] << np.uint64(7)
        mixed ^= bits[:size]
        mixed *= _MIX
        chosen = np.flatnonzero(mixed < np.uint64(2**64 // EACH))
        near = bits[chosen[:, None] + np.arange(LENGTH)]
        chosen = chosen[(near[:, 1:] != near[:, :-1]).sum(-1) >= LENGTH // 2]
        told = np.zeros(chosen.size, np.uint64)
        for k in range(LENGTH):
            told = (told ^ bits[chosen + k]) * _MIX
            told ^= told >> np.uint64(29)
        # Eight bytes each, of a day two million: half a fingerprint tells as much, where four that
        # follow each other have to agree.
        self.starts.append(start)
        self.met.append(np.stack([chosen, told >> np.uint64(32)]).astype(np.uint32))

    def found(self) -> IntArray:
        """Return the runs (k, 2) of samples that were there before."""
        none = np.empty((0, 2), np.intp)
        pairs = [self._pairs(part) for part in range(PARTS)]
        first, again = (np.concatenate(ends) for ends in zip(*pairs, strict=True))
        chosen = sum(met.shape[1] for met in self.met)
        if not FEWEST <= again.size <= MOST * chosen:
            return none
        lag = again - first
        order = np.lexsort((again, lag))
        lag, again = lag[order], again[order]
        # Of one copy: at one distance, and close to each other.
        fresh = (np.diff(lag, prepend=-1) != 0) | (np.diff(again, prepend=-1) > 16 * EACH)
        begin = np.flatnonzero(fresh)
        last = np.append(begin[1:] - 1, again.size - 1)
        long = (last - begin + 1 >= FEWEST) & (lag[begin] >= SECONDS * self.rate)
        return np.stack([again[begin[long]], again[last[long]] + LENGTH], -1)

    def _pairs(self, part: int) -> tuple[IntArray, IntArray]:
        """Return samples (k,) and where what follows them comes again, of a part of all."""
        places, prints = [np.empty(0, np.intp)], [np.empty(0, np.uint32)]
        for start, (chosen, fingerprint) in zip(self.starts, self.met, strict=True):
            own = fingerprint // np.uint32(2**32 // PARTS) == part
            places.append(start + chosen[own].astype(np.intp))
            prints.append(fingerprint[own])
        at, told = np.concatenate(places), np.concatenate(prints)
        order = np.argsort(told, kind="stable")
        at, told = at[order], told[order]
        same = told[1:] == told[:-1]
        return at[:-1][same], at[1:][same]
