"""What a kind of fault declares: its code, its repair, and the detector that finds it.

A kind has a module of its own, which declares a `FAULT_SOURCE`; `registry` lists the modules.
Detector, conditioning, rules, reports and options take all else from there.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Protocol, TypeAlias

from cardan.core.arrays import FloatArray
from cardan.physics.signals.faults.intervals import FaultIntervals


@dataclass(frozen=True)
class SignalBlock:
    """A piece of a channel, with some samples of its neighbours on both sides.

    Attributes
    ----------
    recorded, filled : (n + 2 reach,)
        As it was recorded, nan where samples are missing; and with holes bridged.
    reach, start : samples
        Of the neighbours on each side; and place of the piece in the recording.
    """

    recorded: FloatArray
    filled: FloatArray
    reach: int = 0
    start: int = 0

    @property
    def size(self) -> int:
        """Samples of the piece itself."""
        return self.recorded.size - 2 * self.reach

    @property
    def samples(self) -> FloatArray:
        """The piece itself, nan where samples are missing."""
        return self.recorded[self.reach : self.reach + self.size]

    @property
    def filled_samples(self) -> FloatArray:
        """The piece itself with holes bridged."""
        return self.filled[self.reach : self.reach + self.size]

    @property
    def ahead(self) -> FloatArray:
        """The piece with holes bridged, and the samples that follow."""
        return self.filled[self.reach :]


@dataclass(frozen=True, kw_only=True)
class ChannelStatistics:
    """Levels and swings of a whole channel, which detectors judge by.

    Attributes
    ----------
    alive
        Whether it takes more values than one.
    deviation, typical_swing
        Standard deviation, and how far it usually swings, in the channel's unit.
    levels, swings : (spans,)
        Median of each span, and median distance from it.
    span : samples
        Length of a span.
    """

    alive: bool
    deviation: float
    typical_swing: float
    levels: FloatArray
    swings: FloatArray
    span: int


class WholeChannelFault(Protocol):
    """A fault that is everywhere in a channel."""

    @property
    def size(self) -> float:
        """How large it is, in the channel's unit."""
        ...

    @property
    def details(self) -> Mapping[str, object]:
        """Values that a finding of it has in addition to its size."""
        ...

    def removed_from(self, x: FloatArray, start: int, /) -> FloatArray:
        """Return samples (n,) from `start` on without it."""
        ...


DetectedFaults: TypeAlias = Mapping[str, FaultIntervals | WholeChannelFault]
"""Faults of one channel, by the code of their kind."""


class ChannelFaultDetector(Protocol):
    """Finds faults in one channel, as its pieces pass."""

    def update(self, block: SignalBlock, /) -> None:
        """Take the next piece."""
        ...

    def result(self, of: ChannelStatistics, /) -> DetectedFaults:
        """Return the faults that the pieces showed."""
        ...


class ComparisonFaultDetector(Protocol):
    """Finds faults of one kind by holding channels against each other."""

    def update(self, x: FloatArray, /) -> None:
        """Take the next samples (channels, n), holes bridged."""
        ...

    def result(self) -> list[FaultIntervals]:
        """Return the places in each channel."""
        ...


Correction: TypeAlias = Callable[[FloatArray, int, FaultIntervals], FloatArray]
"""Returns samples (n,) from a place on with the faults at some intervals taken off."""


@dataclass(frozen=True, kw_only=True)
class FaultKind:
    """A kind of fault, and what can be done about it.

    Attributes
    ----------
    code
        In options, rules and JSON.
    maskable
        Whether a hole can be made of it.
    correction
        Takes it off and leaves what was measured; None: nothing does.
    correctable
        Whether it can be taken off, by its `correction` or as a whole-channel fault.
    of_any_channel
        Whether it is no value in any channel; all else is of a gauge, that swings about a zero.
    impossible
        Whether no stress can be so, if all was said as it is.
    explained_by
        Kinds that leave the same trace: a place that one of them is at, or half its length next to
        it, is that one's.
    """

    code: str
    maskable: bool = False
    correction: Correction | None = None
    correctable: bool = False
    of_any_channel: bool = False
    impossible: bool = False
    explained_by: tuple[str, ...] = ()


@dataclass(frozen=True, kw_only=True)
class FaultSource:
    """Kinds of fault that one module declares, with what finds them.

    Attributes
    ----------
    kinds
        Of fault, in the order in which they are listed.
    detector
        Made with the sample rate, for each channel; None: found elsewhere.
    comparison
        Made with the sample rate and the count of channels, for all of them; of the first kind.
    roughly_sized
        Kinds whose places the detector finds to the sample, but whose sizes any other finding of
        the same change measures better.
    """

    kinds: tuple[FaultKind, ...]
    detector: Callable[[float], ChannelFaultDetector] | None = None
    comparison: Callable[[float, int], ComparisonFaultDetector] | None = None
    roughly_sized: tuple[str, ...] = ()
