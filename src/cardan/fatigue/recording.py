"""A recording: channels sampled evenly in time, met a piece at a time."""

import difflib
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import numpy.typing as npt

from cardan.base.arrays import FloatArray
from cardan.base.errors import DesignError

SIZE = 1 << 18
"""Samples a channel in one piece: two megabytes, long against any filter or knot."""


@dataclass(frozen=True, slots=True)
class Channel:
    """One signal: its name and the unit it is written in (empty if nobody says).

    `settled` where whoever measured has said the unit, whatever its name says.
    """

    name: str
    unit: str = ""
    settled: bool = False


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
    begins : s
        Where its first sample lies on the clock of its file: a stretch of it begins later.
    """

    name: str
    channels: tuple[Channel, ...]
    rate: float
    read: Callable[[tuple[int, ...]], Iterable[FloatArray]]
    samples: int | None = None
    notes: tuple[str, ...] = ()
    begins: float = 0.0

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the channels."""
        return tuple(c.name for c in self.channels)

    def place(self, name: str) -> int:
        """Return where a channel stands.

        Raises
        ------
        DesignError
            If there is none of that name.
        """
        if name in self.names:
            return self.names.index(name)
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
        return self.channels[self.place(name)]

    def pieces(
        self, names: Iterable[str] | None = None, *, size: int = SIZE
    ) -> Iterator[FloatArray]:
        """Yield pieces (k, size) of the named channels; the last may be shorter."""
        places = tuple(self.place(n) for n in (self.names if names is None else names))
        return cut(self.read(places), size=size)

    def whole(self, names: Iterable[str] | None = None) -> FloatArray:
        """Return the named channels at once, (k, samples): for short recordings."""
        return np.concatenate(list(self.pieces(names)) or [np.empty((0, 0))], axis=-1)


def in_memory(
    data: FloatArray, *, rate: float, names: Iterable[str], units: Iterable[str] | None = None,
    name: str = "recording", notes: tuple[str, ...] = (),
) -> Recording:  # fmt: skip
    """Return arrays (k, n) as a recording; whole numbers, as a converter's codes, as numbers."""
    names, data = list(names), floating(data)
    channels = tuple(map(Channel, names, units if units is not None else [""] * len(names)))
    return Recording(
        name=name, channels=channels, rate=rate, samples=data.shape[-1], notes=notes,
        read=lambda places: [data[list(places)]],
    )  # fmt: skip


def floating(data: npt.NDArray[Any]) -> FloatArray:
    """Return an array (k, n) as it is, or one of whole numbers as numbers that may be nan."""
    return data if data.dtype.kind == "f" else data.astype(float)


def cut(pieces: Iterable[FloatArray], *, size: int) -> Iterator[FloatArray]:
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


def between(recording: Recording, first: float, last: float, *, name: str = "") -> Recording:
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
        begins=recording.begins + start / recording.rate,
    )  # fmt: skip


def holed(recording: Recording, name: str, runs: FloatArray) -> Recording:
    """Return a recording with one channel missing from when to when, (k, 2) s."""
    place = recording.place(name)
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


def quicker(recording: Recording, rate: float) -> Recording:
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
    return replace(recording, rate=rate, read=read, samples=samples)


def alongside(own: Recording, other: Recording, *, late: float = 0.0) -> Recording:
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
    whole = other.whole()
    time = late + np.arange(whole.shape[-1]) / other.rate
    count = len(own.channels)
    slower = own if own.rate < other.rate else other
    mine = quicker(own, other.rate) if slower is own else own

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
        mine, channels=(*own.channels, *other.channels), read=read,
        notes=(*own.notes, *other.notes, note),
    )  # fmt: skip
