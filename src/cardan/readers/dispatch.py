"""Opens recordings of any registered format, in pieces.

A new format is a module of this package with a `FORMAT`, and its name in `FORMAT_MODULES`.

A recording is never guessed at. A value that is not a number, a row cut short, time that
runs backwards: an error names the file, the place and what to do. A hole in time becomes
missing samples, which the survey of the recording reports.
"""

import math
from collections.abc import Iterable, Sequence
from dataclasses import replace
from functools import cache
from importlib import import_module
from pathlib import Path

from cardan.core.arrays import FloatArray
from cardan.core.errors import InvalidFileError
from cardan.physics.signals.channel_units import usual_unit
from cardan.physics.signals.recording import Channel, Recording
from cardan.readers.base import (
    RecordingFileColumns,
    RecordingFormat,
    check_sample_rate,
    no_frames_note,
    unreadable_recording_error,
)
from cardan.readers.file_content import HEAD_BYTES, check_known_format, is_text
from cardan.readers.several_rates import TimedTable, align_tables, even_log, with_group_prefix
from cardan.readers.time_column import (
    MIN_ROWS_FOR_RATE,
    TimeAxis,
    even_frames_axis,
    find_time_column,
    is_evenly_clocked,
    is_time_column,
    rate_conflict_notes,
    split_by_presence,
    table_time_axis,
    uneven_time_axis,
    with_time_unit,
)
from cardan.schema.yaml_tree import replace_hidden_characters

FORMAT_MODULES = (
    "csv", "lvm", "parquet", "matlab", "hdf5", "tdms", "mdf", "wav", "rpc", "uff", "famos",
    "can_log",
)  # fmt: skip
"""Modules of this package, each with the `FORMAT` that it reads."""


@cache
def formats_by_extension() -> dict[str, RecordingFormat]:
    """Return the format of each file extension, in lower case and with its dot."""
    modules = (import_module(f"{__package__}.{name}") for name in FORMAT_MODULES)
    formats: list[RecordingFormat] = [module.FORMAT for module in modules]
    return {extension: one for one in formats for extension in one.extensions}


def open_recording(
    path: Path, *, rate: float | None = None, time: str | None = None, group: str = "",
    dbc: Path | Iterable[Path] | None = None,
) -> Recording:  # fmt: skip
    """Open a recording by what is in it; the ending of its name counts where that says nothing.

    Parameters
    ----------
    path
        CSV and LabVIEW text, Parquet, HDF5, TDMS, MDF4, WAV, RPC III, MATLAB, UFF, imc FAMOS or
        Vector BLF and ASC, whatever its ending.
    rate : Hz
        Takes the place of the file's own rate or time column, which is then not looked at.
    time
        Name of the time column, `NAME:UNIT` where its unit is not the file's or its name's;
        found by its name (time, t, Zeit, tempo) otherwise.
    group
        Of HDF5, TDMS, MDF4 or MATLAB to read, where there is more than one; no other file has any.
    dbc
        CAN database that decodes the frames of MDF4, BLF or ASC, or several of one bus.

    Raises
    ------
    InvalidFileError
        If it cannot be read as meant: every message says what to try.
    """
    databases = () if dbc is None else (dbc,) if isinstance(dbc, Path) else tuple(dbc)
    if not path.is_file():
        raise unreadable_recording_error(path, "no such file")
    if path.stat().st_size == 0:
        raise unreadable_recording_error(path, "the file is empty")
    own_format = format_of(path)
    if group and not own_format.has_groups:
        formats = formats_by_extension()
        *names, last = dict.fromkeys(f.name for f in formats.values() if f.has_groups)
        raise unreadable_recording_error(
            path, f"no group {group!r}",
            hint=f"only files of {', '.join(names)} and {last} have groups",
        )  # fmt: skip
    try:
        first = own_format.open_columns(path, group, *([databases] if own_format.takes_dbc else []))
    except ImportError as error:
        raise unreadable_recording_error(
            path, f"reading it needs {error.name}",
            hint=f"pip install 'cardan[{own_format.extra}]'",
        ) from error  # fmt: skip
    tables = [_printable(t) for t in (first, *first.other_tables)]
    taken: set[str] = set()
    for k, table in enumerate(tables):
        _check_unique_names(path, table)
        tables[k] = with_group_prefix(table, taken)
        taken |= {c.name for c in tables[k].columns}
    if databases and not own_format.takes_dbc:
        tables[0] = _with_notes(tables[0], no_frames_note(databases))
    if rate is not None:
        check_sample_rate(path, rate)
        if any(t.frames for t in tables):
            raise unreadable_recording_error(
                path, "its CAN frames have a clock of their own: leave the rate (--rate HZ) out"
            )
        return align_tables(path, _at_given_rate(path, tables, rate, time))
    return align_tables(path, _timed_tables(path, tables, time))


def format_of(path: Path) -> RecordingFormat:
    """Return the format of a file by its first bytes, or else by the ending of its name.

    Raises
    ------
    InvalidFileError
        If it is of a system that is not read, or of none that is known.
    """
    with path.open("rb") as file:
        head = file.read(HEAD_BYTES)
    formats = formats_by_extension()
    for one in formats.values():
        if one.recognises(head):
            return one
    check_known_format(path, head)
    if is_text(head):
        return formats[".csv"]
    by_ending = formats.get(path.suffix.lower())
    if by_ending is not None:
        return by_ending
    known = ", ".join(sorted(formats))
    raise unreadable_recording_error(
        path, f"no reader for {path.suffix!r} files", hint=f"known are {known}"
    )


def _at_given_rate(
    path: Path, tables: Sequence[RecordingFileColumns], rate: float, time: str | None
) -> list[TimedTable]:
    """Return tables of which the longest is taken at a rate, and others by their own time."""
    main = max(tables, key=lambda t: t.samples or 0)
    found: list[TimedTable] = []
    for table in tables:
        if table is not main and table.samples != main.samples:
            try:
                found.append(TimedTable(table, table_time_axis(path, table)))
            except InvalidFileError:
                note = f"{_label(table)}: left out, nothing says when it was recorded"
                found[-1:] = [_with_note(t, note) for t in found[-1:]]
            continue
        own, name = with_time_unit(path, table, time)
        clock = find_time_column(path, own, name)
        notes = () if clock is None else rate_conflict_notes(path, own, clock, rate)
        axis = TimeAxis(rate=rate, start=0.0, notes=notes)
        if clock is not None:  # which is then not looked at, and no channel
            own = _without_column(own, clock)
        found.append(TimedTable(own, axis))
    return [t for t in found if t.channels] or _no_channels(path, tables)


def _timed_tables(
    path: Path, tables: Sequence[RecordingFileColumns], time: str | None
) -> list[TimedTable]:
    """Return the tables of which it is known when their samples were taken.

    Raises
    ------
    InvalidFileError
        If it is of none, or not of the longest.
    """
    found: list[TimedTable] = []
    unknown: list[tuple[RecordingFileColumns, InvalidFileError]] = []
    logs: list[tuple[TimedTable, InvalidFileError]] = []
    bare = (time or "").rpartition(":")[0] or time
    named = [t for t in tables if {time, bare} & {c.name for c in t.columns}]
    if time is not None and not named:
        find_time_column(path, tables[0], time)
    for table in tables:
        own_time = time if any(table is t for t in named) else None
        if table.frames:
            continue
        try:
            found += _by_presence(path, table, own_time)
        except InvalidFileError as error:
            log = uneven_time_axis(path, table) if len(tables) > 1 else None
            if log is None:
                unknown.append((table, error))
            else:
                logs.append((TimedTable(table, log), error))
    if logs and not found:
        raise logs[0][1]
    found += [log for log, _ in logs]
    found = _with_frames(path, found, [t for t in tables if t.frames])
    longest = max((t.table.samples or 0 for t in found), default=0)
    for table, error in unknown:
        # What was not requested, a log of events or a spectrum, does not decide over the file.
        if not found or (not table.no_time and (table.samples or 0) > longest):
            if len(tables) == 1 or table.no_time or table.rate is not None or _has_clock(table):
                raise error
            raise unreadable_recording_error(
                path, "its channels have more than one length",
                value=", ".join(
                    f"{t.group}/{t.columns[0].name} {t.samples}".lstrip("/") for t in tables[:6]
                ),
                hint="give each group its rate or a time column, or name the group of one rate",
            ) from error  # fmt: skip
        reason = error.problems[0].message
        found[0] = _with_note(found[0], f"{_label(table)}: left out, {reason}")
    return [t for t in found if t.channels] or _no_channels(path, tables)


def _with_frames(
    path: Path, found: Sequence[TimedTable], frames: Sequence[RecordingFileColumns]
) -> list[TimedTable]:
    """Return tables with those of frames, which are laid on their clock.

    Where there is no other, the most frequent message gives it.
    """
    fastest = max((t.axis.rate for t in found), default=math.inf)
    even: list[TimedTable] = []
    uneven: list[TimedTable] = []
    few: list[str] = []
    for table in frames:
        log = uneven_time_axis(path, table)
        axis = even_frames_axis(path, table)
        if axis is not None and axis.rate <= fastest:
            even.append(TimedTable(table, axis))
        elif log is not None:
            uneven.append(TimedTable(table, log))
        else:
            few += [_label(table)] * (_label(table) not in few)
    main = max((*even, *uneven), key=lambda t: t.axis.rate, default=None)
    if not found and main is not None and main.axis.uneven:
        even = [even_log(path, main), *even]
        uneven = [t for t in uneven if t is not main]
    whole = [*found, *even, *uneven]
    if few and whole:
        note = f"{', '.join(few)}: left out, fewer than {MIN_ROWS_FOR_RATE} frames"
        whole[0] = _with_note(whole[0], note)
    if frames and not whole:
        raise unreadable_recording_error(
            path, f"no message of it has {MIN_ROWS_FOR_RATE} frames or more", value=", ".join(few)
        )
    return whole


def _by_presence(path: Path, table: RecordingFileColumns, time: str | None) -> list[TimedTable]:
    """Return a table with its time axis; as several where its rows are those of several clocks.

    Where tables of different rates were joined by their times, each row holds the channels of one.
    """
    axis_error: InvalidFileError | None = None
    try:
        own, _ = with_time_unit(path, table, time)
        axis = table_time_axis(path, table, time)
        if axis.clock is None or is_evenly_clocked(own, axis):
            return [TimedTable(own, axis)]
    except InvalidFileError as error:
        axis_error, axis = error, None
    parts = split_by_presence(path, table, time)
    if len(parts) < 2:
        if axis_error is not None:
            raise axis_error
        assert axis is not None
        return [TimedTable(with_time_unit(path, table, time)[0], axis)]
    return [TimedTable(t, table_time_axis(path, t, time)) for t in parts]


def _has_clock(table: RecordingFileColumns) -> bool:
    return table.clock is not None or any(is_time_column(c) for c in table.columns)


def _with_note(timed: TimedTable, note: str) -> TimedTable:
    return replace(timed, table=_with_notes(timed.table, note))


def _with_notes(table: RecordingFileColumns, *notes: str) -> RecordingFileColumns:
    return replace(table, notes=(*table.notes, *notes))


def _label(table: RecordingFileColumns) -> str:
    return table.group or ", ".join(c.name for c in table.columns[:6])


def _without_column(table: RecordingFileColumns, left: int) -> RecordingFileColumns:
    """Return a table without one of its columns."""
    kept = tuple(k for k in range(len(table.columns)) if k != left)

    def rows(places: tuple[int, ...]) -> Iterable[FloatArray]:
        return table.read_rows(tuple(kept[k] for k in places))

    columns = tuple(table.columns[k] for k in kept)
    return replace(table, clock=None, columns=columns, read_rows=rows)


def _no_channels(path: Path, tables: Sequence[RecordingFileColumns]) -> list[TimedTable]:
    notes = "; ".join(note for t in tables for note in t.notes)
    raise unreadable_recording_error(path, "it holds no channel but time", hint=notes)


def _printable(table: RecordingFileColumns) -> RecordingFileColumns:
    """Return a table without invisible characters: names of a logger may hold anything."""
    columns = tuple(
        Channel(
            replace_hidden_characters(c.name),
            usual_unit(replace_hidden_characters(c.unit).strip()),
            aliases=c.aliases,
        )
        for c in table.columns
    )
    return replace(
        table, columns=columns, group=replace_hidden_characters(table.group),
        notes=tuple(map(replace_hidden_characters, table.notes)),
    )  # fmt: skip


def _check_unique_names(path: Path, table: RecordingFileColumns) -> None:
    names = [c.name for c in table.columns]
    for name in names:
        if names.count(name) > 1:
            raise unreadable_recording_error(path, "two channels have one name", value=repr(name))
