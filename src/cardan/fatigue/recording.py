"""A recording: channels sampled evenly in time, met a piece at a time."""

import difflib
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass

import numpy as np

from cardan.base.arrays import FloatArray
from cardan.base.errors import DesignError

SIZE = 1 << 18
"""Samples a channel in one piece: two megabytes, long against any filter or knot."""


@dataclass(frozen=True, slots=True)
class Channel:
    """One signal: its name and the unit it is written in (empty if nobody says)."""

    name: str
    unit: str = ""


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
            held, count = [whole[..., full:]], count - full
    if count:
        yield np.concatenate(held, axis=-1)
