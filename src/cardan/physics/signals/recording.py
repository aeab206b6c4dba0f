"""A recording: channels sampled evenly in time, met a piece at a time."""

import difflib
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import numpy.typing as npt

from cardan.core.arrays import FloatArray
from cardan.core.errors import DesignError

SAMPLES_PER_BLOCK = 1 << 18
"""Samples a channel in one piece: two megabytes, long against any filter or knot."""


@dataclass(frozen=True, slots=True)
class Channel:
    """One signal: its name and the unit it is written in (empty if not given).

    Attributes
    ----------
    unit_declared
        The file states the unit, whatever the channel's name is.
    aliases
        Other names that it is found by.
    uneven
        Its samples were taken at uneven instants, and what is read is laid between them.
    """

    name: str
    unit: str = ""
    unit_declared: bool = False
    aliases: tuple[str, ...] = ()
    uneven: bool = False


@dataclass(frozen=True, kw_only=True)
class ChannelSampling:
    """How the file sampled a channel, before it was laid on the clock of its recording.

    Attributes
    ----------
    rate : Hz
        Samples a second; the mean of a log that is written as something changes.
    first, last : s
        Where its first sample lies behind the recording's, and where the step behind its last one
        ends; `last` is None at the end of the recording.
    known
        Samples with a value, where they are no samples of the recording; None where they are, or
        were not taken evenly.
    low, high
        Of these samples; nan where they are those of the recording.
    """

    rate: float
    first: float = 0.0
    last: float | None = None
    known: int | None = None
    low: float = float("nan")
    high: float = float("nan")


@dataclass(frozen=True, kw_only=True)
class Recording:
    """Channels of one rate, of any length, read in pieces and never held whole.

    Attributes
    ----------
    name
        Where it comes from, for messages.
    channels
        What it holds, in order.
    rate : Hz
        Samples a second of every channel.
    read
        Takes places in `channels`, gives pieces (k, n) of those channels, n as it comes.
        Missing samples are nan. Each call starts from the beginning.
    samples
        Per channel, where known without reading.
    notes
        What the reader wants said: rows left out, units not given.
    start_time : s
        Where its first sample lies in the recording of its file: a stretch of it begins later.
    clock_start : s
        What the clock of its file shows at the first sample of the whole recording.
    sampling
        Of each channel as its file has it; empty where the recording is no longer the file's.
    """

    name: str
    channels: tuple[Channel, ...]
    rate: float
    read: Callable[[tuple[int, ...]], Iterable[FloatArray]]
    samples: int | None = None
    notes: tuple[str, ...] = ()
    start_time: float = 0.0
    clock_start: float = 0.0
    sampling: tuple[ChannelSampling, ...] = ()

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the channels."""
        return tuple(c.name for c in self.channels)

    def index_of(self, name: str) -> int:
        """Return where a channel stands.

        Raises
        ------
        DesignError
            If there is none of that name.
        """
        if name in self.names:
            return self.names.index(name)
        also = [k for k, c in enumerate(self.channels) if name in c.aliases]
        if len(also) == 1:
            return also[0]
        bare, _, unit = name.rpartition(":")
        if bare in self.names:
            msg = f"{bare}:{unit}: {unit!r} is no unit of stress, strain, speed or torque"
            raise DesignError(msg)
        near = difflib.get_close_matches(name, self.names, n=1)
        hint = f"did you mean {near[0]!r}?" if near else f"it has {', '.join(self.names)}"
        msg = f"{self.name} has no channel {name!r}; {hint}"
        raise DesignError(msg)

    def channel(self, name: str) -> Channel:
        """Return a channel by its name."""
        return self.channels[self.index_of(name)]

    def pieces(
        self, names: Iterable[str] | None = None, *, size: int = SAMPLES_PER_BLOCK
    ) -> Iterator[FloatArray]:
        """Yield pieces (k, size) of the named channels; the last may be shorter."""
        places = tuple(self.index_of(n) for n in (self.names if names is None else names))
        return rechunk_to_block_size(self.read(places), size=size)

    def read_all(self, names: Iterable[str] | None = None) -> FloatArray:
        """Return the named channels at once, (k, samples): for short recordings."""
        return np.concatenate(list(self.pieces(names)) or [np.empty((0, 0))], axis=-1)


def recording_from_arrays(
    data: FloatArray, *, rate: float, names: Iterable[str], units: Iterable[str] | None = None,
    name: str = "recording", notes: tuple[str, ...] = (),
) -> Recording:  # fmt: skip
    """Return arrays (k, n) as a recording; whole numbers, as a converter's codes, as numbers."""
    names, data = list(names), as_float_samples(data)
    channels = tuple(map(Channel, names, units if units is not None else [""] * len(names)))
    return Recording(
        name=name, channels=channels, rate=rate, samples=data.shape[-1], notes=notes,
        read=lambda places: [data[list(places)]],
    )  # fmt: skip


def as_float_samples(data: npt.NDArray[Any]) -> FloatArray:
    """Return an array (k, n) as it is, or one of whole numbers as numbers that may be nan."""
    return data if data.dtype.kind == "f" else data.astype(float)


def rechunk_to_block_size(pieces: Iterable[FloatArray], *, size: int) -> Iterator[FloatArray]:
    """Yield the same samples (k, n) in pieces of one size; the last may be shorter."""
    held: list[FloatArray] = []
    count = 0
    for piece in pieces:
        held.append(piece)
        count += piece.shape[-1]
        if count >= size:
            whole = np.concatenate(held, axis=-1) if len(held) > 1 else held[0]
            full = count - count % size
            # A view would hold all of it, and the pieces it was made of be there twice.
            held, count = [whole[..., full:].copy()], count - full
            for start in range(0, full, size):
                yield whole[..., start : start + size]
            del whole
    if count:
        yield np.concatenate(held, axis=-1)


def time_slice(recording: Recording, first: float, last: float, *, name: str = "") -> Recording:
    """Return a stretch of a recording, from `first` to `last` s.

    Raises
    ------
    DesignError
        If there is nothing of it between.
    """
    start, stop = round(first * recording.rate), round(min(last, 1e12) * recording.rate)
    there = recording.samples
    place = f"between {first:g} and {last:g} s" if last < 1e12 else f"behind {first:g} s"
    nothing = f"{recording.name} has nothing {place}"
    if stop <= start or (there is not None and start >= there):
        raise DesignError(nothing)

    def read(places: tuple[int, ...]) -> Iterator[FloatArray]:
        done = 0
        for piece in recording.read(places):
            n = piece.shape[-1]
            if done + n > start:
                yield piece[:, max(start - done, 0) : stop - done]
            done += n
            if done >= stop:
                return
        if done <= start:
            msg = f"{nothing}: it ends at {done / recording.rate:g} s"
            raise DesignError(msg)

    samples = None if there is None else min(stop, there) - start
    return replace(
        recording, name=name or recording.name, read=read, samples=samples,
        start_time=recording.start_time + start / recording.rate, sampling=(),
    )  # fmt: skip


def with_gaps_in_channel(recording: Recording, name: str, runs: FloatArray) -> Recording:
    """Return a recording with one channel missing from when to when, (k, 2) s."""
    place = recording.index_of(name)
    first, last = np.rint(runs * recording.rate).astype(np.int64).T

    def read(places: tuple[int, ...]) -> Iterator[FloatArray]:
        done = 0
        for piece in recording.read(places):
            at = done + np.arange(piece.shape[-1])
            done += piece.shape[-1]
            inside = np.searchsorted(first, at, "right") > np.searchsorted(last, at, "right")
            if inside.any() and place in places:
                hidden = inside & (np.array(places) == place)[:, None]
                yield np.where(hidden, np.nan, piece)
            else:
                yield piece

    return replace(recording, read=read)


def resample(recording: Recording, rate: float) -> Recording:
    """Return a recording at a higher rate, Hz, straight between its samples."""
    ratio = recording.rate / rate

    def read(places: tuple[int, ...]) -> Iterator[FloatArray]:
        first = given = 0
        held = np.empty((len(places), 0))
        for piece in recording.read(places):
            held = np.concatenate([held, piece], axis=-1)
            known = first + np.arange(held.shape[-1])
            at = np.arange(given, int(np.floor(known[-1] / ratio + 1e-9)) + 1) * ratio
            yield np.stack([np.interp(at, known, x) for x in held])
            first, given, held = int(known[-1]), given + at.size, held[:, -1:].copy()

    n = recording.samples
    samples = None if not n else int(np.floor((n - 1) / ratio + 1e-9)) + 1
    return replace(recording, rate=rate, read=read, samples=samples, sampling=())


def merge_recordings(own: Recording, other: Recording, *, late: float = 0.0) -> Recording:
    """Return a recording with the channels of another, at the higher rate of the two.

    The slower one's are laid straight between their samples. `late` is how much later than this
    one the other began, s. The other is held in memory.

    Raises
    ------
    DesignError
        If both have a channel of one name, or they were never under way together.
    """
    for name in other.names:
        if name in own.names:
            msg = f"{own.name} and {other.name} both have a channel {name!r}"
            raise DesignError(msg)
    whole = other.read_all()
    time = late + np.arange(whole.shape[-1]) / other.rate
    count = len(own.channels)
    slower = own if own.rate < other.rate else other
    mine = resample(own, other.rate) if slower is own else own

    def apart(seconds: float) -> None:
        if not time.size or time[-1] < 0 or time[0] >= seconds:
            msg = f"{other.name}, {late:g} s later, and {own.name} have no time in common"
            raise DesignError(msg)

    apart(np.inf if mine.samples is None else mine.samples / mine.rate)

    def read(places: tuple[int, ...]) -> Iterator[FloatArray]:
        wanted = tuple(k for k in places if k < count) or (0,)
        done = 0
        for piece in mine.read(wanted):
            t = (done + np.arange(piece.shape[-1])) / mine.rate
            done += piece.shape[-1]
            yield np.stack(
                [
                    piece[wanted.index(k)]
                    if k < count
                    else np.interp(t, time, whole[k - count], left=np.nan, right=np.nan)
                    for k in places
                ]
            )
        apart(done / mine.rate)

    note = (
        f"with {other.name} ({other.rate:g} Hz), {late:g} s later, straight between the samples of "
        f"{slower.name}"
    )
    return replace(
        mine, channels=(*own.channels, *other.channels), read=read, sampling=(),
        notes=(*own.notes, *other.notes, note),
    )  # fmt: skip
