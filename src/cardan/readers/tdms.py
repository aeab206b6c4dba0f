"""TDMS recordings: npTDMS finds what is in a file and where it lies, and it is read from there.

npTDMS takes memory for as many samples as a segment claims, and reads all of an interleaved one
anew for each piece of each channel. Of a data acquisition card a channel's samples are what one
or more scalers cut out of the rows of a buffer. Source: NI, TDMS file format internal structure
(2024).
"""

import logging
import re
import struct
from array import array
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, BinaryIO, TypeAlias

import numpy as np

from cardan.core.arrays import FloatArray
from cardan.physics.signals.recording import SAMPLES_PER_BLOCK, Channel, rechunk_to_block_size
from cardan.readers.base import (
    RecordingFileColumns,
    RecordingFormat,
    as_one_file,
    check_sample_count,
    number_of_attribute,
    unreadable_recording_error,
)
from cardan.readers.time_units import seconds_per_time_unit

MAX_READ_BYTES = 1 << 24
"""Bytes of the file that are read at once."""
_DAMAGED_FILE_ERRORS = (
    ValueError, TypeError, OSError, EOFError, OverflowError, MemoryError, LookupError,
    RecursionError, struct.error,
)  # fmt: skip
"""What is raised of a file that says what is not there."""
_INTERLEAVED_FLAG, _BIG_ENDIAN_FLAG = 1 << 5, 1 << 6
"""Flags of a segment: a row of all channels follows the next; numbers begin with the high byte."""


@dataclass
class _SampleRuns:
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


class _CachedReader:
    """Rows of a file, the last kept: channels that are interleaved need the same."""

    def __init__(self, stream: BinaryIO) -> None:
        self.stream, self.asked, self.held = stream, (0, 0), b""

    def between(self, first: int, last: int) -> bytes:
        """Return the bytes from one place to another."""
        if (first, last) != self.asked:
            self.stream.seek(first)
            self.asked, self.held = (first, last), self.stream.read(last - first)
        return self.held


def open_tdms(path: Path, group: str = "") -> RecordingFileColumns:
    """Open a TDMS recording: the waveform channels of one group."""
    from nptdms import TdmsFile  # pyright: ignore[reportMissingTypeStubs]
    from nptdms.log import log_manager  # pyright: ignore[reportMissingTypeStubs]

    log_manager.set_level(logging.ERROR)  # what it warns of is said in notes
    try:
        # Of the file itself: an index that lies next to it may be another file's.
        with path.open("rb") as stream:
            file: Any = TdmsFile.read_metadata(stream)
        groups = {g.name: g for g in file.groups() if any(len(c) for c in g.channels())}
        segments: list[Any] = file._reader._segments
        notes = _missing_sample_notes(path, segments)
        runs = _locate_samples(segments)
    except _DAMAGED_FILE_ERRORS as error:
        raise unreadable_recording_error(path, f"TDMS cannot open it: {error}") from error
    if not groups:
        raise unreadable_recording_error(path, "it holds no samples")
    if group and group not in groups:
        raise unreadable_recording_error(
            path, f"no group {group!r}", hint=f"it has {', '.join(groups)}"
        )
    chosen = [groups[group]] if group else list(groups.values())
    items = [c for g in chosen for c in g.channels() if len(c)]
    items = [c for c in items if c.dtype is not None and c.dtype.kind in "fiuM"]
    if not any(c.dtype.kind != "M" for c in items):
        raise unreadable_recording_error(path, "no channel of numbers in it")
    check_sample_count(path, max(len(c) for c in items), len(items))
    axes = [_waveform_axis(path, c, groups[c.group_name], file) for c in items]
    notes += _restarted_notes(path, segments)
    dated = [a.instant for a in axes if a.instant is not None]
    undated = [c.name for c, a in zip(items, axes, strict=True) if a.step and a.instant is None]
    if dated and undated:
        note = f"{', '.join(undated)}: no start is stated, taken as begun with the others"
        notes += (note,)
    alike: dict[tuple[str, int, _WaveformAxis], list[Any]] = {}
    several = len({(len(c), a) for c, a in zip(items, axes, strict=True)}) > 1
    for c, a in zip(items, axes, strict=True):
        alike.setdefault((c.group_name if several else "", len(c), a), []).append(c)
    tables = [
        _waveform_table(path, own, runs, key[2], min(dated, default=0))
        for key, own in alike.items()
    ]
    found = as_one_file(tables)
    return replace(found, notes=(*found.notes, *notes))


@dataclass(frozen=True)
class _WaveformAxis:
    """When the samples of a waveform channel were taken, as its properties say.

    Attributes
    ----------
    step : s
        From each sample to the next; None where it does not say.
    offset : s
        Of the first sample from its instant.
    instant : ns
        When it began, since 1904; None where it does not say.
    no_time
        What it is counted by, where that is not time.
    """

    step: float | None
    offset: float
    instant: int | None
    no_time: str


def _waveform_axis(path: Path, channel: Any, group: Any, file: Any) -> _WaveformAxis:
    """Return the axis of a channel by its properties, its group's or the file's.

    Source: NI, TDMS waveform properties: `wf_increment`, `wf_start_time`, `wf_start_offset`,
    `wf_xunit_string`, `wf_xname`.
    """

    def said(name: str) -> Any:
        of = (channel.properties, group.properties, file.properties)
        return next((p[name] for p in of if name in p and p[name] not in (None, "")), None)

    def number(name: str) -> float | None:
        value = said(name)
        if value is None:
            return None
        value = str(value).replace(",", ".") if isinstance(value, str) else value
        found = number_of_attribute(path, f"{channel.name}: {name}", value)
        if not np.isfinite(found):
            raise unreadable_recording_error(
                path, f"its {channel.name}: {name} is not a number", value=str(value)
            )
        return found

    unit, name = str(said("wf_xunit_string") or ""), str(said("wf_xname") or "")
    second = seconds_per_time_unit(unit)
    no_time = f"{name or 'its axis'} in {unit}" if second is None else ""
    if not unit and name.strip().lower() in _AXES_THAT_ARE_NO_TIME:
        no_time = name
    step, second = number("wf_increment"), second or 1.0
    if step is not None and not no_time and step < 0:
        raise unreadable_recording_error(
            path, f"{channel.name}: its wf_increment is below 0", value=f"{step:g}"
        )
    return _WaveformAxis(
        step * second if step else None, (number("wf_start_offset") or 0.0) * second,
        _nanoseconds(said("wf_start_time")), no_time,
    )  # fmt: skip


_AXES_THAT_ARE_NO_TIME = ("frequency", "frequenz", "angle", "winkel", "distance", "weg", "order")
_EPOCH = np.datetime64("1904-01-01T00:00:00", "ns")
"""From which TDMS counts. Source: NI, TDMS file format internal structure (2024)."""


def _nanoseconds(value: Any) -> int | None:
    """Return an instant in ns since 1904; None if it is none."""
    try:
        return None if value is None else int((np.datetime64(value, "ns") - _EPOCH).astype(int))
    except ValueError:
        return None


def _restarted_notes(path: Path, segments: list[Any]) -> tuple[str, ...]:
    """Return a note of channels whose start is stated anew by a later segment.

    Raises
    ------
    InvalidFileError
        If a later segment states another step.
    """
    from nptdms.reader import TdmsReader  # pyright: ignore[reportMissingTypeStubs]

    stated: list[bytes] = []
    with path.open("rb") as stream:
        for s in segments if len(segments) > 1 else []:
            if s.toc_mask & _METADATA_FLAG:
                stream.seek(s.position)
                stated += _WAVEFORM_PROPERTY.findall(stream.read(s.data_position - s.position))
        if len(set(stated)) < 2:
            return ()
        changed: dict[str, tuple[Any, Any]] = {}
        restarted: dict[str, None] = {}

        class ByChannel(TdmsReader):
            """Notices what a later segment states otherwise than an earlier one."""

            def _update_object_properties(self, segment_object_properties: Any) -> None:
                for of, properties in (segment_object_properties or {}).items():
                    before = self.object_metadata[of].properties
                    for name, value in properties:
                        if name in before and before[name] != value:
                            if name == "wf_increment":
                                changed.setdefault(of, (before[name], value))
                            elif name.startswith("wf_start"):
                                restarted[of] = None
                super()._update_object_properties(segment_object_properties)

        stream.seek(0)
        ByChannel(stream).read_metadata(require_segment_indexes=False)
    for of, (was, now) in changed.items():
        raise unreadable_recording_error(
            path, f"{of} changes its step between segments", value=f"{was:g}, then {now:g}",
            hint="save it as one channel for each step",
        )  # fmt: skip
    note = f"{', '.join(restarted)}: begun anew in a later segment, read as if it followed at once"
    return (note,) if restarted else ()


_METADATA_FLAG = 1 << 1
_WAVEFORM_PROPERTY = re.compile(rb"wf_(?:increment|start_time|start_offset)....(?:.{8})", re.DOTALL)
"""What states the axis of a waveform in the head of a segment: name, type, first bytes of it."""


def _missing_sample_notes(path: Path, segments: list[Any]) -> tuple[str, ...]:
    """Say how many samples are claimed that are not there.

    Raises
    ------
    InvalidFileError
        If a chunk in which a row follows the next claims more than a file may.
    """
    lost = 0
    for s in segments:
        left: dict[str, int] | None = s.final_chunk_lengths_override
        if left is None:
            continue
        claimed = [o for o in s.ordered_objects if o.has_data]
        lost += sum(o.number_values - left.get(o.path, 0) for o in claimed)
        if s.toc_mask & _INTERLEAVED_FLAG or s._have_daqmx_objects():
            check_sample_count(path, max(o.number_values for o in claimed), len(claimed))
    note = f"the file is cut short: {lost} samples that it claims are not there"
    return (note,) if lost or (segments and segments[-1].segment_incomplete) else ()


_RunsByChannel: TypeAlias = dict[tuple[str, int], _SampleRuns]
"""Of each channel by its path, and by which of its scalers, `PLAIN` without one."""
ID_OF_UNSCALED_CHANNEL = -1
_RAW_STAMP = np.dtype("V16")


def _locate_samples(segments: list[Any]) -> _RunsByChannel:
    """Return where the samples of each channel lie."""
    found: _RunsByChannel = {}
    for s in segments:
        own = [o for o in s.ordered_objects if o.has_data]
        (_add_daqmx_segment if s._have_daqmx_objects() else _add_plain_segment)(found, s, own)
    return found


def _runs_of_channel(
    found: _RunsByChannel,
    path: str,
    scaler: int,
    kind: Any,
    made: Callable[[Any], Any] = np.asarray,
) -> _SampleRuns:
    """Return a channel's runs so far.

    Raises
    ------
    ValueError
        If its numbers were of another kind before.
    """
    known = found.setdefault((path, scaler), _SampleRuns(np.dtype(kind), made))
    if known.kind != np.dtype(kind):
        msg = f"{path} changes the kind of its numbers from {known.kind} to {np.dtype(kind)}"
        raise ValueError(msg)
    return known


def _add_plain_segment(found: _RunsByChannel, s: Any, own: list[Any]) -> None:
    """Enter a segment whose channels lie one after another, or row by row."""
    from nptdms.types import TimeStamp  # pyright: ignore[reportMissingTypeStubs]

    chunk = sum(o.data_size for o in own)
    left: dict[str, int] | None = s.final_chunk_lengths_override
    whole = s.num_chunks - (left is not None)
    last = s.data_position + whole * chunk
    # Of one channel only text has no size; and of text nothing lies in rows.
    sized = all(o.data_type.size is not None for o in own)
    rows = bool(s.toc_mask & _INTERLEAVED_FLAG) and sized
    width = sum(o.data_type.size for o in own) if rows else 0
    before = gone = 0
    for o in own:
        size, n = o.data_type.size or 0, o.number_values
        ends = 0 if left is None else left.get(o.path, 0)
        big, inside = int(bool(s.toc_mask & _BIG_ENDIAN_FLAG)), before if rows else 0
        place = {"step": width or size, "inside": inside, "big": big}
        kind = _RAW_STAMP if o.data_type is TimeStamp else o.data_type.nptype
        runs = _runs_of_channel(found, o.path, ID_OF_UNSCALED_CHANNEL, kind)
        if rows or o.data_size == chunk:  # chunks that follow each other are one
            runs.add(s.data_position, size=1, chunks=1, count=whole * n + ends, **place)
        else:
            first = s.data_position + before
            runs.add(first, size=chunk, chunks=whole, count=n, **place)
            if ends:
                runs.add(last + gone, size=1, chunks=1, count=ends, **place)
        before += size if rows else o.data_size
        gone += o.data_size if ends == n else size * ends


def _add_daqmx_segment(found: _RunsByChannel, s: Any, own: list[Any]) -> None:
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
            kind, name = scaler.data_type.nptype, scaler.scale_id if raw else ID_OF_UNSCALED_CHANNEL
            runs = _runs_of_channel(found, o.path, name, kind, scaler.postprocess_data)
            place = {
                "step": width,
                "inside": inside,
                "big": int(bool(s.toc_mask & _BIG_ENDIAN_FLAG)),
            }
            first = s.data_position + begun[scaler.raw_buffer_index]
            if len(buffers) == 1 and n == rows:
                runs.add(first, size=1, chunks=1, count=whole * n + ends, **place)
            else:
                runs.add(first, size=chunk, chunks=whole, count=n, **place)
                if ends:
                    runs.add(first + whole * chunk, size=1, chunks=1, count=ends, **place)


def _read_samples(rows: _CachedReader, runs: _SampleRuns, begun: Any, first: int, n: int) -> Any:
    """Return n samples of a channel from one on, as they are written."""
    pieces: list[Any] = []
    k = int(np.searchsorted(begun, first, side="right")) - 1
    while n > 0:
        skip = first - int(begun[k])
        m = min(n, runs.count[k] - skip)
        at, step = runs.at[k] + skip * runs.step[k], runs.step[k]
        data = rows.between(at, at + m * step)
        own = runs.kind.newbyteorder(">" if runs.big[k] else "<")
        x = np.ndarray((m,), own, data, runs.inside[k], (step,))
        pieces.append(_stamps(x, runs.big[k]) if own == _RAW_STAMP else x)
        first, n, k = first + m, n - m, k + 1
    return runs.made(np.concatenate(pieces))


def _waveform_table(
    path: Path, items: list[Any], found: _RunsByChannel, axis: _WaveformAxis, earliest: int
) -> RecordingFileColumns:
    """Return TDMS channels of one length and axis as a table; `earliest` ns is the file's 0."""
    samples = len(items[0])
    instants = [k for k, c in enumerate(items) if c.dtype.kind == "M"]
    first_stamp = 0
    start = 0.0 if axis.instant is None else (axis.instant - earliest) * 1e-9
    if instants:
        first_stamp = _first_stamp(path, found[items[instants[0]].path, ID_OF_UNSCALED_CHANNEL])
        start = (first_stamp - earliest) * 1e-9 if earliest else 0.0

    def pieces(places: tuple[int, ...]) -> Iterator[FloatArray]:
        own = [
            (items[k], {name: r for (of, name), r in found.items() if of == items[k].path})
            for k in places
        ]
        runs = [r for _, each in own for r in each.values()]
        begun = {id(r): np.concatenate([[0], np.cumsum(r.count)])[:-1] for r in runs}
        many = max(min(SAMPLES_PER_BLOCK, MAX_READ_BYTES // max(max(r.step) for r in runs)), 1)
        with path.open("rb") as stream:
            rows = _CachedReader(stream)
            for first in range(0, samples, many):
                n = min(many, samples - first)
                raw = [
                    {
                        name: _read_samples(rows, r, begun[id(r)], first, n)
                        for name, r in each.items()
                    }
                    for _, each in own
                ]
                yield np.stack(
                    [
                        (x[ID_OF_UNSCALED_CHANNEL] - first_stamp) * 1e-9
                        if c.dtype.kind == "M"
                        else _apply_scales(c, x)
                        for (c, _), x in zip(own, raw, strict=True)
                    ]
                )

    def rows(places: tuple[int, ...]) -> Iterator[FloatArray]:
        try:
            yield from rechunk_to_block_size(pieces(places), size=SAMPLES_PER_BLOCK)
        except _DAMAGED_FILE_ERRORS as error:
            raise unreadable_recording_error(path, f"it is damaged: {error}") from error

    return RecordingFileColumns(
        columns=tuple(
            Channel(c.name, "s" if k in instants else str(c.properties.get("unit_string", "")))
            for k, c in enumerate(items)
        ),
        read_rows=rows, rate=1 / axis.step if axis.step else None, samples=samples,
        group=items[0].group_name, start=start + axis.offset, no_time=axis.no_time,
        clock=instants[0] if len(instants) == 1 else None,
    )  # fmt: skip


def _first_stamp(path: Path, runs: _SampleRuns) -> int:
    """Return the first instant of a channel of them, ns since 1904."""
    begun = np.concatenate([[0], np.cumsum(runs.count)])[:-1]
    with path.open("rb") as stream:
        return int(_read_samples(_CachedReader(stream), runs, begun, 0, 1)[0])


_STAMP_LITTLE = np.dtype([("fraction", "<u8"), ("seconds", "<i8")])
_STAMP_BIG = np.dtype([("seconds", ">i8"), ("fraction", ">u8")])
"""An instant: seconds since 1904 and shares of 2^-64 of one."""


def _stamps(raw: Any, big: int) -> Any:
    """Return instants (n,) as they are written in ns since 1904."""
    x = np.frombuffer(raw.tobytes(), _STAMP_BIG if big else _STAMP_LITTLE)
    return x["seconds"].astype(np.int64) * 10**9 + np.rint(x["fraction"] * (1e9 / 2**64)).astype(
        np.int64
    )


def _apply_scales(channel: Any, raw: dict[int, Any]) -> FloatArray:
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
    chunk = (
        kind.channel_data(raw[ID_OF_UNSCALED_CHANNEL])
        if ID_OF_UNSCALED_CHANNEL in raw
        else kind.scaler_data(raw)
    )
    try:
        return np.asarray(channel._scale_data(chunk), float)
    except Exception as error:  # what it has no name for it raises as just that
        raise ValueError(str(error)) from error


FORMAT = RecordingFormat(
    name="TDMS", extensions=(".tdms",), open_columns=open_tdms, has_groups=True,
    recognises=lambda head: head.startswith(b"TDSm"),
)  # fmt: skip
