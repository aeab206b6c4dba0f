"""LabVIEW Measurement Files (.lvm): their heads say how the rows are written and timed.

A head of the file, then one or several segments: a head of channels, names, and rows. `Delta_X` is
a channel's step, `X0` where it begins after its `Date` and `Time`. With `X_Columns Multi` each
channel has times of its own. Segments of one step are one recording; what lies between them is
missing.

Source: NI, Specification for the LabVIEW measurement file (.lvm), version 2.0.
"""

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from cardan.core.arrays import FloatArray
from cardan.physics.signals.recording import SAMPLES_PER_BLOCK, Channel, rechunk_to_block_size
from cardan.readers.base import (
    RecordingFileColumns,
    RecordingFormat,
    as_one_file,
    rate_of_printed_step,
    unreadable_recording_error,
)
from cardan.readers.csv import CsvDialect, first_lines, is_number, read_rows, split_row
from cardan.readers.file_content import is_labview_text
from cardan.readers.time_column import MAX_HOLE_S
from cardan.readers.time_units import instant

_END = "***End_of_Header***"
SCAN_BYTES, ROWS_AT_ONCE = 1 << 20, 1 << 14
MAX_HEAD_LINES, MAX_LINE_LETTERS = 64, 1 << 16
MIN_STEP_DIGITS = 3
"""Digits that a step is printed with at least: zeros behind them are not written."""
MAX_TIME_FROM_RECORDING_START_S = 1e6
"""Times above it count from a date, and not from the beginning: s."""


@dataclass(frozen=True)
class _Segment:
    """What the head of a segment says of its channels."""

    names: tuple[str, ...]
    units: tuple[str, ...]
    steps: tuple[float | None, ...]
    """`Delta_X`, s, None where it states none: that of the roundest rate which prints so."""
    offsets: tuple[float, ...]
    """`X0`, s."""
    begun: tuple[float, ...]
    """`Date` and `Time`, s on one clock; 0 where not all channels have them."""
    samples: tuple[int | None, ...]

    @property
    def start(self) -> float:
        """When its first channel begins, s."""
        return self.begun[self.filled[0]] + self.offsets[self.filled[0]]

    @property
    def filled(self) -> tuple[int, ...]:
        """Places of the channels that have samples."""
        places = range(len(self.names))
        return tuple(k for k in places if self.samples[k] != 0) or tuple(places)


def open_lvm(path: Path, _group: str = "") -> RecordingFileColumns:
    """Open a LabVIEW Measurement File."""
    lines, encoding = first_lines(path)
    ends = [k for k, line in enumerate(lines) if line.startswith(_END)]
    if len(ends) < 2 or len(lines) < ends[1] + 3:
        raise unreadable_recording_error(path, "its heads of LabVIEW do not end")
    delimiter, decimal, times = _file_head(lines[: ends[0]])
    several_times = times == "multi"
    first_row = ends[1] + 2
    form = CsvDialect(delimiter, decimal, (), first_row, encoding)
    segment = _segment(path, lines[ends[0] + 1 : first_row], form, several_times=several_times)
    rows = [split_row(line, delimiter) for line in lines[first_row:] if line.strip()]
    width, count = max(map(len, rows[:-1] or rows), default=0), len(segment.names)
    if width < (2 * count if several_times else count):
        raise unreadable_recording_error(
            path, "its rows have fewer fields than its heads have channels",
            value=f"{width} for {count} channels",
        )  # fmt: skip
    form = replace(form, columns=tuple(Channel(f"column {k + 1}") for k in range(width)))
    segments, newlines = _scan(path)
    if segments > 1:
        if several_times:
            raise unreadable_recording_error(
                path, "its segments have times for each channel",
                hint="save it in LabVIEW with one time column, or as TDMS",
            )  # fmt: skip
        return _table_of_segments(path, form, segment)
    there = len(rows) if len(lines) >= newlines else newlines - first_row
    notes: list[str] = []
    stated = max(n or 0 for n in segment.samples)
    if there < stated - 1:
        note = f"the file is cut short: {there} of {stated} samples are there"
        notes.append(note)
    empty = [segment.names[k] for k in range(count) if k not in segment.filled]
    if empty:
        note = f"no samples, left out: {', '.join(empty)}"
        notes.append(note)
    if several_times:
        found = as_one_file(
            _table_of_own_times(path, form, segment, k, first=rows[0], samples=max(there, 1))
            for k in segment.filled
        )
        return replace(found, notes=tuple(notes))
    timed = width > count and any(row[0] for row in rows)
    return _table_of_one_step(path, form, segment, timed=timed, notes=tuple(notes))


def _file_head(lines: Sequence[str]) -> tuple[str, str, str]:
    """Return delimiter, decimal sign and how many columns of time there are."""
    signs = {"comma": ",", "semicolon": ";"}
    for delimiter in ("\t", ",", ";"):
        rows = [split_row(line, delimiter) for line in lines]
        said = {row[0]: row[1] for row in rows if len(row) > 1}
        if signs.get(said.get("Separator", "Tab").lower(), "\t") == delimiter:
            break
    decimal = said.get("Decimal_Separator", ".")
    return delimiter, decimal if decimal in (".", ",") else ".", said.get("X_Columns", "").lower()


def _segment(
    path: Path, lines: Sequence[str], form: CsvDialect, *, several_times: bool = False
) -> _Segment:
    """Return what a segment says: the lines of its head, then that of its names."""
    cells = (split_row(line, form.delimiter) for line in lines[:-1])
    head = {row[0]: row[1:] for row in cells if row and row[0]}
    count = int(_numbers(path, "Channels", head.get("Channels", [])[:1], form.decimal)[0] or 0)
    fields = split_row(lines[-1], form.delimiter)
    names = fields[1 : 2 * count : 2] if several_times else fields[1 : count + 1]
    if not 1 <= count <= len(names):
        raise unreadable_recording_error(
            path, "it has more columns than names", value=f"{count} and {len(names)}"
        )
    axis = next((f for f in head.get("X_Dimension", ()) if f), "Time")
    if axis.lower() != "time":
        raise unreadable_recording_error(
            path, f"the axis of its samples is no time: {axis}", hint="give the rate (--rate HZ)"
        )

    def of_each(key: str) -> tuple[str, ...]:
        # Of a channel with times of its own two fields are written, the second empty.
        said = head.get(key, [])[:: 2 if several_times else 1]
        return (*said, *[""] * count)[:count]

    def numbers(key: str) -> list[float | None]:
        return _numbers(path, key, of_each(key), form.decimal)

    begun = [
        instant(f"{day.replace('/', '-')} {time.replace(',', '.')}") if day and time else None
        for day, time in zip(of_each("Date"), of_each("Time"), strict=True)
    ]
    return _Segment(
        names=tuple(names), units=of_each("Y_Unit_Label"),
        steps=tuple(map(_step, numbers("Delta_X"), of_each("Delta_X"))),
        offsets=tuple(x or 0.0 for x in numbers("X0")),
        begun=tuple(0.0 if b is None or None in begun else b for b in begun),
        samples=tuple(None if n is None else int(n) for n in numbers("Samples")),
    )  # fmt: skip


def _numbers(path: Path, key: str, fields: Sequence[str], decimal: str) -> list[float | None]:
    """Return what a key of a head says of each channel; None where it says nothing."""
    fields = fields or [""]
    if not all(is_number(f, decimal) for f in fields):
        raise unreadable_recording_error(
            path, f"its {key} is not a number", value=", ".join(fields[:6])
        )
    return [float(f.replace(",", ".")) if f else None for f in fields]


def _step(step: float | None, text: str) -> float | None:
    """Return a step, s, as the one of the roundest rate that prints so: 0.000977 of 1024 Hz."""
    if not step or not step > 0:
        return None
    digits = re.sub(r"[eE].*|[^0-9]", "", text).lstrip("0")
    return 1 / rate_of_printed_step(step, max(len(digits), MIN_STEP_DIGITS))


def _scan(path: Path) -> tuple[int, int]:
    """Return how many segments a file has, and how many lines."""
    mark, heads, newlines, held = _END.encode(), 0, 0, b""
    with path.open("rb") as file:
        while piece := file.read(SCAN_BYTES):
            newlines += piece.count(b"\n")
            heads += (held + piece).count(mark)
            held = piece[-len(mark) + 1 :]
    return heads - 1, newlines


def _one_step(path: Path, segment: _Segment) -> float | None:
    """Return the one step of the channels of a segment, s; None if none is stated."""
    alike = {(segment.steps[k], segment.offsets[k], segment.begun[k]) for k in segment.filled}
    if len(alike) > 1:
        raise unreadable_recording_error(
            path, "its channels have more than one step or start",
            value=f"Delta_X {', '.join(map(str, segment.steps[:6]))}, X0 "
            f"{', '.join(map(str, segment.offsets[:6]))}",
            hint="save it in LabVIEW with times for each channel, or as TDMS",
        )  # fmt: skip
    return segment.steps[segment.filled[0]]


def _table_of_one_step(
    path: Path, form: CsvDialect, segment: _Segment, *, timed: bool, notes: tuple[str, ...]
) -> RecordingFileColumns:
    """Return the channels of a segment as a table, behind its column of times if it has one."""
    step = _one_step(path, segment)
    before = len(form.columns) > len(segment.names)
    columns = tuple(Channel(segment.names[k], segment.units[k]) for k in segment.filled)
    places = tuple(before + k for k in segment.filled)
    if timed:
        columns, places = (Channel("X_Value", "s"), *columns), (0, *places)
    return RecordingFileColumns(
        columns=columns, notes=notes, rate=1 / step if step else None, clock=0 if timed else None,
        read_rows=lambda wanted: read_rows(path, form, [places[k] for k in wanted]),
    )  # fmt: skip


def _table_of_own_times(
    path: Path, form: CsvDialect, segment: _Segment, k: int, *, first: Sequence[str], samples: int
) -> RecordingFileColumns:
    """Return a channel and its own times as a table; rows behind its end have neither."""
    stated = first[2 * k].replace(",", ".")
    absolute = (
        is_number(stated, ".")
        and bool(stated)
        and abs(float(stated)) > MAX_TIME_FROM_RECORDING_START_S
    )
    step = segment.steps[k]

    def rows(places: tuple[int, ...]) -> Iterator[FloatArray]:
        for piece in read_rows(path, form, [2 * k, 2 * k + 1]):
            yield piece[:, ~np.isnan(piece[0])][list(places)]

    return RecordingFileColumns(
        columns=(Channel("time", "s"), Channel(segment.names[k], segment.units[k])), clock=0,
        read_rows=rows, rate=1 / step if step else None, samples=samples,
        start=0.0 if absolute else segment.begun[k] - min(segment.begun),
    )  # fmt: skip


def _table_of_segments(path: Path, form: CsvDialect, first: _Segment) -> RecordingFileColumns:
    """Return segments of one step as a table; what lies between them is missing."""
    step = _one_step(path, first)
    if step is None:
        raise unreadable_recording_error(
            path, "its segments state no step", hint="give the rate (--rate HZ)"
        )
    before = len(form.columns) > len(first.names)

    def rows(places: tuple[int, ...]) -> Iterator[FloatArray]:
        wanted = [before + first.filled[k] for k in places]
        pieces = _segment_pieces(path, form, first, step, wanted)
        return rechunk_to_block_size(pieces, size=SAMPLES_PER_BLOCK)

    return RecordingFileColumns(
        columns=tuple(Channel(first.names[k], first.units[k]) for k in first.filled),
        read_rows=rows, rate=1 / step,
    )  # fmt: skip


def _segment_pieces(
    path: Path, form: CsvDialect, first: _Segment, step: float, wanted: list[int]
) -> Iterator[FloatArray]:
    """Yield the rows of segments (k, n), one after the other, and nan for the time between them."""
    samples = 0
    for lines, head in _stretches(path, form):
        if head is not None:
            if (head.names, _one_step(path, head)) != (first.names, step):
                raise unreadable_recording_error(
                    path, "its segments have other channels or steps than the first",
                    value=f"{', '.join(head.names[:6])}, Delta_X {head.steps[0]}",
                    hint="split the file",
                )  # fmt: skip
            hole = round((head.start - first.start) / step) - samples
            if not 0 <= hole * step <= MAX_HOLE_S:
                raise unreadable_recording_error(
                    path, "its segments do not follow one another in time",
                    value=f"one begins {hole * step:.6g} s after the end of the one before",
                    hint="split the file",
                )  # fmt: skip
            if hole:
                yield np.full((len(wanted), hole), np.nan)
            samples += hole
        values = np.array([_row_values(path, form, line, wanted) for line in lines]).T
        if lines:
            yield values
            samples += values.shape[1]


def _stretches(path: Path, form: CsvDialect) -> Iterator[tuple[list[str], _Segment | None]]:
    """Yield rows of a file, some of them at a time, with the segment if they are its first."""
    with path.open(encoding=form.encoding, errors="replace") as file:
        for _ in range(form.header_lines):
            file.readline(MAX_LINE_LETTERS)
        rows: list[str] = []
        head: _Segment | None = None
        while line := file.readline(MAX_LINE_LETTERS):
            if line.startswith(("Channels", "Notes")):
                yield rows, head
                rows, lines = [], [line]
                while not line.startswith(_END) and len(lines) < MAX_HEAD_LINES and line:
                    line = file.readline(MAX_LINE_LETTERS)
                    lines.append(line)
                if not line.startswith(_END):
                    raise unreadable_recording_error(path, "its heads of LabVIEW do not end")
                head = _segment(path, [*lines[:-1], file.readline(MAX_LINE_LETTERS)], form)
            elif line.strip():
                rows.append(line)
                if len(rows) == ROWS_AT_ONCE:
                    yield rows, head
                    rows, head = [], None
        yield rows, head


def _row_values(path: Path, form: CsvDialect, line: str, wanted: Sequence[int]) -> list[float]:
    """Return some fields of a row; what is empty is missing."""
    fields = line.rstrip("\r\n").split(form.delimiter)
    try:
        return [
            float(fields[k].replace(form.decimal, ".")) if fields[k].strip() else np.nan
            for k in wanted
        ]
    except (ValueError, IndexError) as error:
        raise unreadable_recording_error(
            path, "a row of a segment does not hold its numbers", value=repr(line[:60].strip())
        ) from error


FORMAT = RecordingFormat(
    name="LabVIEW text", extensions=(".lvm",), open_columns=open_lvm, recognises=is_labview_text
)
