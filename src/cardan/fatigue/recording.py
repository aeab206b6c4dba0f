"""A recording: channels sampled evenly in time, met a piece at a time."""

import difflib
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, replace

import numpy as np

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
    """

    name: str
    channels: tuple[Channel, ...]
    rate: float
    read: Callable[[tuple[int, ...]], Iterable[FloatArray]]
    samples: int | None = None
    notes: tuple[str, ...] = ()

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
    """Return arrays (k, n) as a recording."""
    names = list(names)
    channels = tuple(map(Channel, names, units if units is not None else [""] * len(names)))
    return Recording(
        name=name, channels=channels, rate=rate, samples=data.shape[-1], notes=notes,
        read=lambda places: [data[list(places)]],
    )  # fmt: skip


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
            for start in range(0, full, size):
                yield whole[..., start : start + size]
            # A view would hold all of it.
            held, count = [whole[..., full:].copy()], count - full
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
    return replace(recording, name=name or recording.name, read=read, samples=samples)


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


def alongside(own: Recording, other: Recording, *, late: float = 0.0) -> Recording:
    """Return a recording with the channels of another, straight between their samples.

    `late` is how much later than this one the other began, s. The other is held in memory.

    Raises
    ------
    DesignError
        If both have a channel of one name.
    """
    for name in other.names:
        if name in own.names:
            msg = f"{own.name} and {other.name} both have a channel {name!r}"
            raise DesignError(msg)
    whole = other.whole()
    time = late + np.arange(whole.shape[-1]) / other.rate
    count = len(own.channels)

    def read(places: tuple[int, ...]) -> Iterator[FloatArray]:
        mine = tuple(k for k in places if k < count) or (0,)
        done = 0
        for piece in own.read(mine):
            t = (done + np.arange(piece.shape[-1])) / own.rate
            done += piece.shape[-1]
            yield np.stack(
                [
                    piece[mine.index(k)]
                    if k < count
                    else np.interp(t, time, whole[k - count], left=np.nan, right=np.nan)
                    for k in places
                ]
            )

    note = f"with {other.name} ({other.rate:g} Hz), {late:g} s later, straight between its samples"
    return replace(
        own, channels=(*own.channels, *other.channels), read=read,
        notes=(*own.notes, *other.notes, note),
    )  # fmt: skip
