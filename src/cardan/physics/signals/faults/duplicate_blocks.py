"""What was written twice: the same numbers to the last digit, a second and more of them.

No road and no test bench does a thing twice to the last digit; a buffer that was stored twice
does. Some samples are chosen by their own digits, so that the same ones are chosen of a copy; what
follows them has a fingerprint, and where those of many agree at one distance, it is a copy.
"""

import numpy as np
import numpy.typing as npt

from cardan.core.arrays import IntArray
from cardan.physics.signals.faults.fault_kind import (
    ChannelStatistics,
    FaultKind,
    FaultSource,
    SignalBlock,
)
from cardan.physics.signals.faults.intervals import FaultIntervals, fault_intervals

FAULT_REPEAT = "repeat"

FINGERPRINT_STRIDE = 64
"""Samples of which one is chosen."""
FINGERPRINT_SAMPLES = 16
"""Samples of a fingerprint."""
MIN_COPY_DISTANCE_S, MIN_MATCHING_FINGERPRINTS, MAX_MATCHING_SHARE_OF_FINGERPRINTS = 0.5, 4, 0.5
"""Shortest distance of a copy, and fewest chosen samples in it; and of all, the share from which
the whole recording is taken to repeat, as a test bench in coarse steps."""
HASH_PARTITIONS = 8
"""Of all fingerprints, by their first bits: those of one are held against each other at once."""
_HASH_MULTIPLIER = np.uint64(0x9E3779B97F4A7C15)


class DuplicateBlockDetector:
    """Remembers a channel by its digits, as its pieces pass."""

    def __init__(self, rate: float) -> None:
        self.rate = rate
        self.starts: list[int] = []
        self.met: list[npt.NDArray[np.uint32]] = []

    def update(self, block: SignalBlock) -> None:
        """Take a piece, and of the samples that follow what its fingerprints need."""
        ahead, start, size = block.ahead, block.start, block.size
        bits = np.add(ahead, 0.0, dtype=float).view(np.uint64)  # no minus zero
        size = min(size, ahead.size - FINGERPRINT_SAMPLES)
        if size <= 0:
            return
        mixed = bits[1 : size + 1] << np.uint64(7)
        mixed ^= bits[:size]
        mixed *= _HASH_MULTIPLIER
        chosen = np.flatnonzero(mixed < np.uint64(2**64 // FINGERPRINT_STRIDE))
        near = bits[chosen[:, None] + np.arange(FINGERPRINT_SAMPLES)]
        chosen = chosen[(near[:, 1:] != near[:, :-1]).sum(-1) >= FINGERPRINT_SAMPLES // 2]
        told = np.zeros(chosen.size, np.uint64)
        for k in range(FINGERPRINT_SAMPLES):
            told = (told ^ bits[chosen + k]) * _HASH_MULTIPLIER
            told ^= told >> np.uint64(29)
        # Eight bytes each, of a day two million: half a fingerprint suffices, where four that
        # follow each other have to agree.
        self.starts.append(start)
        self.met.append(np.stack([chosen, told >> np.uint64(32)]).astype(np.uint32))

    def result(self, _: ChannelStatistics) -> dict[str, FaultIntervals]:
        """Return what was there before."""
        return {FAULT_REPEAT: fault_intervals(self._repeated_runs())}

    def _repeated_runs(self) -> IntArray:
        """Return the runs (k, 2) of samples that were there before."""
        none = np.empty((0, 2), np.intp)
        pairs = [self._pairs(part) for part in range(HASH_PARTITIONS)]
        first, again = (np.concatenate(ends) for ends in zip(*pairs, strict=True))
        chosen = sum(met.shape[1] for met in self.met)
        if (
            not MIN_MATCHING_FINGERPRINTS
            <= again.size
            <= MAX_MATCHING_SHARE_OF_FINGERPRINTS * chosen
        ):
            return none
        lag = again - first
        order = np.lexsort((again, lag))
        lag, again = lag[order], again[order]
        # Of one copy: at one distance, and close to each other.
        fresh = (np.diff(lag, prepend=-1) != 0) | (
            np.diff(again, prepend=-1) > 16 * FINGERPRINT_STRIDE
        )
        begin = np.flatnonzero(fresh)
        last = np.append(begin[1:] - 1, again.size - 1)
        long = (last - begin + 1 >= MIN_MATCHING_FINGERPRINTS) & (
            lag[begin] >= MIN_COPY_DISTANCE_S * self.rate
        )
        return np.stack([again[begin[long]], again[last[long]] + FINGERPRINT_SAMPLES], -1)

    def _pairs(self, part: int) -> tuple[IntArray, IntArray]:
        """Return samples (k,) and where what follows them comes again, of a part of all."""
        places, prints = [np.empty(0, np.intp)], [np.empty(0, np.uint32)]
        for start, (chosen, fingerprint) in zip(self.starts, self.met, strict=True):
            own = fingerprint // np.uint32(2**32 // HASH_PARTITIONS) == part
            places.append(start + chosen[own].astype(np.intp))
            prints.append(fingerprint[own])
        at, told = np.concatenate(places), np.concatenate(prints)
        order = np.argsort(told, kind="stable")
        at, told = at[order], told[order]
        same = told[1:] == told[:-1]
        return at[:-1][same], at[1:][same]


FAULT_SOURCE = FaultSource(
    kinds=(FaultKind(code=FAULT_REPEAT, maskable=True),), detector=DuplicateBlockDetector
)
