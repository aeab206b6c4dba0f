"""TDMS recordings: npTDMS tells what is in a file and where it lies, and it is read from there.

npTDMS takes memory for as many samples as a segment claims, and reads all of an interleaved one
anew for each piece of each channel. Of a data acquisition card a channel's samples are what one
or more scalers cut out of the rows of a buffer. Source: NI, TDMS file format internal structure
(2024).
"""

import logging
import struct
from array import array
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, BinaryIO, TypeAlias

import numpy as np

from cardan.base.arrays import FloatArray
from cardan.fatigue.recording import SIZE, Channel, cut
from cardan.files.recordings import Table, bad, budget, joined

AT_ONCE = 1 << 24
"""Bytes of the file that are read at once."""
_DAMAGE = (
    ValueError, TypeError, OSError, EOFError, OverflowError, MemoryError, LookupError,
    RecursionError, struct.error,
)  # fmt: skip
"""What is raised of a file that says what is not there."""
_INTERLEAVED, _BIG = 1 << 5, 1 << 6
"""Flags of a segment: a row of all channels follows the next; numbers begin with the high byte."""


@dataclass
class _Runs:
    """Samples of a channel as they lie in the file, a run for each stretch of them.

    Attributes
    ----------
    at, step, count
        Where a run's first row begins, bytes from each row to the next, and rows.
    inside
        Bytes of a row before the channel's own.
    big
        Whether its numbers begin with the high byte.
    kind
        Of its numbers.
    made
        What is made of them: of a digital line its bit.
    """

    kind: np.dtype[Any]
    made: Callable[[Any], Any] = np.asarray
    at: "array[int]" = field(default_factory=lambda: array("q"))
    step: "array[int]" = field(default_factory=lambda: array("q"))
    count: "array[int]" = field(default_factory=lambda: array("q"))
    inside: "array[int]" = field(default_factory=lambda: array("q"))
    big: "array[int]" = field(default_factory=lambda: array("b"))

    def add(
        self, first: int, *, size: int, chunks: int, step: int, count: int, inside: int, big: int
    ) -> None:
        """Add a run for each of the chunks, which lie `size` bytes from each other."""
        self.at.extend(range(first, first + chunks * size, max(size, 1)))
        for own, value in (
            (self.step, step), (self.count, count), (self.inside, inside), (self.big, big)
        ):  # fmt: skip
            own.extend([value] * chunks)


class _Rows:
    """Rows of a file, the last kept: channels that are interleaved ask for the same."""

    def __init__(self, stream: BinaryIO) -> None:
        self.stream, self.asked, self.held = stream, (0, 0), b""

    def between(self, first: int, last: int) -> bytes:
        """Return the bytes from one place to another."""
        if (first, last) != self.asked:
            self.stream.seek(first)
            self.asked, self.held = (first, last), self.stream.read(last - first)
        return self.held


def tdms(path: Path, *, group: str = "") -> Table:
    """Open a TDMS recording: the waveform channels of one group."""
    from nptdms import TdmsFile  # pyright: ignore[reportMissingTypeStubs]
    from nptdms.log import log_manager  # pyright: ignore[reportMissingTypeStubs]

    log_manager.set_level(logging.ERROR)  # what it warns of is said in notes
    try:
        # Of the file itself: an index that lies beside it may be another's.
        with path.open("rb") as stream:
            file: Any = TdmsFile.read_metadata(stream)
        groups = {g.name: g for g in file.groups() if any(len(c) for c in g.channels())}
        segments: list[Any] = file._reader._segments
        notes = _short(path, segments)
        runs = _runs(segments)
    except _DAMAGE as error:
        raise bad(path, f"TDMS cannot open it: {error}") from error
    if not groups:
        raise bad(path, "it holds no samples")
    if group and group not in groups:
        raise bad(path, f"no group {group!r}", hint=f"it has {', '.join(groups)}")
    chosen = [groups[group]] if group else list(groups.values())
    items = [c for g in chosen for c in g.channels() if len(c)]
    items = [c for c in items if c.dtype is not None and c.dtype.kind in "fiu"]
    if not items:
        raise bad(path, "no channel of numbers in it")
    budget(path, max(len(c) for c in items), len(items))
    alike: dict[tuple[str, int, Any], list[Any]] = {}
    several = len({(len(c), c.properties.get("wf_increment")) for c in items}) > 1
    for c in items:
        key = (c.group_name if several else "", len(c), c.properties.get("wf_increment"))
        alike.setdefault(key, []).append(c)
    table = joined(path, [_waveforms(path, own, runs) for own in alike.values()])
    return replace(table, notes=(*table.notes, *notes))


def _short(path: Path, segments: list[Any]) -> tuple[str, ...]:
    """Say how many samples are claimed that are not there.

    Raises
    ------
    BadFile
        If a chunk in which a row follows the next claims more than a file may.
    """
    lost = 0
    for s in segments:
        left: dict[str, int] | None = s.final_chunk_lengths_override
        if left is None:
            continue
        claimed = [o for o in s.ordered_objects if o.has_data]
        lost += sum(o.number_values - left.get(o.path, 0) for o in claimed)
        if s.toc_mask & _INTERLEAVED or s._have_daqmx_objects():
            budget(path, max(o.number_values for o in claimed), len(claimed))
    note = f"the file is cut short: {lost} samples that it claims are not there"
    return (note,) if lost or (segments and segments[-1].segment_incomplete) else ()


_Found: TypeAlias = dict[tuple[str, int], _Runs]
"""Of each channel by its path, and by which of its scalers, `PLAIN` without one."""
PLAIN = -1


def _runs(segments: list[Any]) -> _Found:
    """Return where the samples of each channel lie."""
    found: _Found = {}
    for s in segments:
        own = [o for o in s.ordered_objects if o.has_data]
        (_carded if s._have_daqmx_objects() else _plain)(found, s, own)
    return found


def _of(
    found: _Found, path: str, scaler: int, kind: Any, made: Callable[[Any], Any] = np.asarray
) -> _Runs:
    """Return a channel's runs so far.

    Raises
    ------
    ValueError
        If its numbers were of another kind before.
    """
    known = found.setdefault((path, scaler), _Runs(np.dtype(kind), made))
    if known.kind != np.dtype(kind):
        msg = f"{path} changes the kind of its numbers from {known.kind} to {np.dtype(kind)}"
        raise ValueError(msg)
    return known


def _plain(found: _Found, s: Any, own: list[Any]) -> None:
    """Enter a segment whose channels lie one after another, or row by row."""
    chunk = sum(o.data_size for o in own)
    left: dict[str, int] | None = s.final_chunk_lengths_override
    whole = s.num_chunks - (left is not None)
    last = s.data_position + whole * chunk
    # Of one channel only text has no size; and of text nothing lies in rows.
    sized = all(o.data_type.size is not None for o in own)
    rows = bool(s.toc_mask & _INTERLEAVED) and sized
    width = sum(o.data_type.size for o in own) if rows else 0
    before = gone = 0
    for o in own:
        size, n = o.data_type.size or 0, o.number_values
        ends = 0 if left is None else left.get(o.path, 0)
        big, inside = int(bool(s.toc_mask & _BIG)), before if rows else 0
        place = {"step": width or size, "inside": inside, "big": big}
        runs = _of(found, o.path, PLAIN, o.data_type.nptype)
        if rows or o.data_size == chunk:  # chunks that follow each other are one
            runs.add(s.data_position, size=1, chunks=1, count=whole * n + ends, **place)
        else:
            first = s.data_position + before
            runs.add(first, size=chunk, chunks=whole, count=n, **place)
            if ends:
                runs.add(last + gone, size=1, chunks=1, count=ends, **place)
        before += size if rows else o.data_size
        gone += o.data_size if ends == n else size * ends


def _carded(found: _Found, s: Any, own: list[Any]) -> None:
    """Enter a segment of data acquisition cards: the rows of each one's buffer, then the next's.

    Raises
    ------
    ValueError
        If channels of no card are among them, or one lies beyond its row.
    """
    from nptdms.daqmx import (  # pyright: ignore[reportMissingTypeStubs]
        DaqmxSegmentObject,
        get_buffer_dimensions,
    )
    from nptdms.types import DaqMxRawData  # pyright: ignore[reportMissingTypeStubs]

    if not all(isinstance(o, DaqmxSegmentObject) for o in own):
        msg = "channels of a card and others lie in one segment"
        raise ValueError(msg)
    buffers: list[tuple[int, int]] = get_buffer_dimensions(own)
    begun = np.cumsum([0, *(n * width for n, width in buffers)]).tolist()
    chunk = begun[-1]
    left: dict[str, int] | None = s.final_chunk_lengths_override
    whole = s.num_chunks - (left is not None)
    for o in own:
        n, ends = o.number_values, 0 if left is None else left.get(o.path, 0)
        for scaler in o.daqmx_metadata.scalers:
            rows, width = buffers[scaler.raw_buffer_index]
            size, inside = scaler.data_type.size, scaler.byte_offset()
            if inside + size > width:
                msg = f"{o.path} lies at {inside} in rows of {width} bytes"
                raise ValueError(msg)
            raw = o.data_type is DaqMxRawData
            kind, name = scaler.data_type.nptype, scaler.scale_id if raw else PLAIN
            runs = _of(found, o.path, name, kind, scaler.postprocess_data)
            place = {"step": width, "inside": inside, "big": int(bool(s.toc_mask & _BIG))}
            first = s.data_position + begun[scaler.raw_buffer_index]
            if len(buffers) == 1 and n == rows:
                runs.add(first, size=1, chunks=1, count=whole * n + ends, **place)
            else:
                runs.add(first, size=chunk, chunks=whole, count=n, **place)
                if ends:
                    runs.add(first + whole * chunk, size=1, chunks=1, count=ends, **place)


def _taken(rows: _Rows, runs: _Runs, begun: Any, first: int, n: int) -> Any:
    """Return n samples of a channel from one on, as they are written."""
    pieces: list[Any] = []
    k = int(np.searchsorted(begun, first, side="right")) - 1
    while n > 0:
        skip = first - int(begun[k])
        m = min(n, runs.count[k] - skip)
        at, step = runs.at[k] + skip * runs.step[k], runs.step[k]
        data = rows.between(at, at + m * step)
        own = runs.kind.newbyteorder(">" if runs.big[k] else "<")
        pieces.append(np.ndarray((m,), own, data, runs.inside[k], (step,)))
        first, n, k = first + m, n - m, k + 1
    return runs.made(np.concatenate(pieces))


def _waveforms(path: Path, items: list[Any], found: _Found) -> Table:
    """Return TDMS channels of one length and step as a table."""
    samples, properties = len(items[0]), items[0].properties
    step = properties.get("wf_increment")

    def pieces(places: tuple[int, ...]) -> Iterator[FloatArray]:
        own = [
            (items[k], {name: r for (of, name), r in found.items() if of == items[k].path})
            for k in places
        ]
        runs = [r for _, each in own for r in each.values()]
        begun = {id(r): np.concatenate([[0], np.cumsum(r.count)])[:-1] for r in runs}
        many = max(min(SIZE, AT_ONCE // max(max(r.step) for r in runs)), 1)
        with path.open("rb") as stream:
            rows = _Rows(stream)
            for first in range(0, samples, many):
                n = min(many, samples - first)
                raw = [
                    {name: _taken(rows, r, begun[id(r)], first, n) for name, r in each.items()}
                    for _, each in own
                ]
                yield np.stack([_scaled(c, x) for (c, _), x in zip(own, raw, strict=True)])

    def rows(places: tuple[int, ...]) -> Iterator[FloatArray]:
        try:
            yield from cut(pieces(places), size=SIZE)
        except _DAMAGE as error:
            raise bad(path, f"it is damaged: {error}") from error

    return Table(
        columns=tuple(Channel(c.name, str(c.properties.get("unit_string", ""))) for c in items),
        rows=rows, rate=1 / step if step else None, samples=samples, group=items[0].group_name,
        start=float(properties.get("wf_start_offset", 0.0) or 0.0),
    )  # fmt: skip


def _scaled(channel: Any, raw: dict[int, Any]) -> FloatArray:
    """Return what a channel's scales make of what is written, by scalers.

    Raises
    ------
    ValueError
        If they make nothing of it.
    """
    from nptdms.base_segment import (  # pyright: ignore[reportMissingTypeStubs]
        RawChannelDataChunk,
    )

    kind = RawChannelDataChunk
    chunk = kind.channel_data(raw[PLAIN]) if PLAIN in raw else kind.scaler_data(raw)
    try:
        return np.asarray(channel._scale_data(chunk), float)
    except Exception as error:  # what it has no name for it raises as just that
        raise ValueError(str(error)) from error
