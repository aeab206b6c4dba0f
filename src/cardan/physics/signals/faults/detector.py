"""What in a channel looks wrong, by kind and place. Nothing is taken out here.

A blow of a pothole and a bad contact look alike to a filter that removes both. So what is
suspicious is only found and listed, and the user, who measured, says what it was: `masked` makes a
hole of it, which is unknown and not zero, and what is kept is exactly what was recorded.

| kind | what it is |
|---|---|
| hole | missing samples |
| sentinel | a number that loggers write for "no value", far outside all others |
| spike | up to three samples that jump off and back, quiet on both sides |
| dropout | the same, longer and level; or a contact lost for some seconds between two steps |
| clip | crests cut off at one level |
| freeze | one value for longer than the channel ever keeps one |
| zero-step | the signal is torn: it steps from one sample to the next, and goes on as before |
| gain | from some place on it answers so many times as much, or the other way round |
| response | it stops answering, wholly or above a frequency, while another gauge goes on |
| noise | white for some tenths of a second, as a contact that chatters: no structure answers so |
| repeat | what was written before, to the last digit: a buffer that was stored twice |
| drift | the level creeps by more than the channel swings |
| hum | a tone of the mains, 50 or 60 Hz, that neither speed nor load moves |
| unit | a stress that no metal bears, or less than a gauge's noise: numbers of another unit |
| rate | samples too seldom for what moves a driveline, or at a rate no gauge has |
| strength | crests beyond the tensile strength that was said |
| bit | half of all values never come: a bit of the converter stands still |
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from cardan.core.arrays import FloatArray
from cardan.physics.signals.faults.fault_kind import (
    ChannelStatistics,
    SignalBlock,
    WholeChannelFault,
)
from cardan.physics.signals.faults.intervals import (
    NO_FAULTS,
    FaultIntervals,
    merge_runs,
    overlaps,
    with_sizes_of,
)
from cardan.physics.signals.faults.registry import FAULT_KINDS, FAULT_SOURCES, FAULTS_BY_CODE

MAX_SAME_CHANGE_DISTANCE_S = 8.0
"""Time within which two findings are of one change: as far as gauges held against each other
leave it open."""


@dataclass(frozen=True)
class ChannelFaults:
    """Faults of one channel, by kind: those with places, and those of the whole channel."""

    intervals: Mapping[str, FaultIntervals]
    whole_channel: Mapping[str, WholeChannelFault]


class FaultDetector:
    """Finds one channel's faults of every registered kind, as its pieces pass."""

    def __init__(self, rate: float) -> None:
        self.same_change = round(MAX_SAME_CHANGE_DISTANCE_S * rate)
        sources = [
            (of.detector(rate), of.roughly_sized) for of in FAULT_SOURCES if of.detector is not None
        ]
        self.detectors = [one for one, _ in sources]
        self.roughly_sized = [kinds for _, kinds in sources]

    def update(self, block: SignalBlock) -> None:
        """Take the next piece."""
        for one in self.detectors:
            one.update(block)

    def result(
        self, of: ChannelStatistics, *, compared: Mapping[str, FaultIntervals]
    ) -> ChannelFaults:
        """Return the faults found; of a kind without any, what a comparison with others says."""
        intervals, whole = dict(compared), dict[str, WholeChannelFault]()
        for one, rough in zip(self.detectors, self.roughly_sized, strict=True):
            for kind, fault in one.result(of).items():
                if not isinstance(fault, FaultIntervals):
                    whole[kind] = fault
                elif fault.count and not _is_sized_by_comparison(
                    compared.get(kind, NO_FAULTS), fault
                ):
                    better = intervals.get(kind, NO_FAULTS) if kind in rough else NO_FAULTS
                    intervals[kind] = with_sizes_of(fault, better, within=self.same_change)
        intervals = {k: _unexplained(where, k, intervals) for k, where in intervals.items()}
        kinds = [k for k in FAULT_KINDS if of.alive and k in intervals and intervals[k].count]
        return ChannelFaults({k: intervals[k] for k in kinds}, whole)


def _is_sized_by_comparison(compared: FaultIntervals, fault: FaultIntervals) -> bool:
    """Return whether a comparison sized what this channel alone shows without a size."""
    return bool(compared.count and np.isnan(fault.sizes).all())


def _unexplained(
    where: FaultIntervals, kind: str, found: Mapping[str, FaultIntervals]
) -> FaultIntervals:
    """Return the places of a kind that no other kind found there explains."""
    others = merge_runs(found[k].runs for k in FAULTS_BY_CODE[kind].explained_by if k in found)
    if not len(others):
        return where
    half = (where.runs[:, 1] - where.runs[:, 0]) // 2
    about = np.stack([where.runs[:, 0] - half, where.runs[:, 1] + half], -1)
    return where.select(~overlaps(about, others))


class ComparisonDetector:
    """Finds the faults that show where channels are held against each other."""

    def __init__(self, rate: float, count: int) -> None:
        self.count = count
        self.detectors = [
            (of.kinds[0].code, of.comparison(rate, count))
            for of in FAULT_SOURCES
            if of.comparison is not None
        ]

    def update(self, x: FloatArray) -> None:
        """Take the next samples (channels, n), holes bridged."""
        for _, one in self.detectors:
            one.update(x)

    def result(self) -> list[dict[str, FaultIntervals]]:
        """Return the faults of each channel, by kind."""
        found = [dict[str, FaultIntervals]() for _ in range(self.count)]
        for kind, one in self.detectors:
            for channel, where in zip(found, one.result(), strict=True):
                channel[kind] = where
        return found
