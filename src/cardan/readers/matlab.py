"""MATLAB files (.mat) of level 5 and 7.3: vectors, matrices and structs of them.

Series of one length and one struct are a table. Its clock is a vector whose name says time; else
its rate is a single number of a usual name (`Fs`, `SampleRate`, `dt`). A matrix of texts next to it
(`names`, `units`) names its columns. Structs as Simulink writes them (`time`, `signals(k).values`,
`signals(k).label`) are read as such.
"""

import math
import re
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from cardan.core.arrays import FloatArray
from cardan.physics.signals.recording import SAMPLES_PER_BLOCK, Channel
from cardan.readers.base import (
    RecordingFileColumns,
    RecordingFormat,
    as_one_file,
    check_sample_count,
    unreadable_recording_error,
)
from cardan.readers.matlab_hdf5 import open_v73
from cardan.readers.matlab_v5 import is_v5, open_v5
from cardan.readers.matlab_variables import Variable
from cardan.readers.time_column import DAY_S, is_time_column, says_time
from cardan.readers.time_units import seconds_per_count_of_instants

MAX_COLUMNS = 1024
"""Columns of a matrix that are channels."""
NUMBERS_READ_AT_ONCE = 1 << 20
"""Numbers of a matrix of which every so many are a channel's."""
_RATE_NAMES = (
    "fs", "ratehz", "rate", "samplerate", "samplingrate", "samplefrequency", "samplingfrequency",
    "fsample",
)  # fmt: skip
_STEP_NAMES = ("dt", "ts", "deltat", "timestep", "sampletime", "sampleinterval", "stepsize")
_START_NAMES = ("t0", "starttime", "timestart", "tstart")
_MIN_DATENUM, _MAX_DATENUM = 7e5, 8e5
"""MATLAB's count of days, of the years 1916 to 2190: as seconds it were the ninth day of a run."""
_DATA_NAMES = ("values", "value", "data", "y")
_NAME_TEXTS = ("names", "name", "labels", "label", "channels", "channelnames", "varnames",
               "variablenames", "headers", "header", "colheaders", "title")  # fmt: skip
_UNIT_TEXTS = ("units", "unit", "yunit", "yunits", "channelunits")
MAX_VARIABLES_LISTED = 12


@dataclass(frozen=True)
class _Series:
    """A series of numbers of a variable: a vector, or one column of a matrix."""

    name: str
    unit: str
    struct: str
    """The variable of the file that it is part of; "" of none."""
    samples: int
    rate: float | None
    start: float | None
    read: Callable[[int, int], FloatArray]


def open_matlab(path: Path, group: str = "") -> RecordingFileColumns:
    """Open a MATLAB file; a group is one of its structs."""
    with path.open("rb") as file:
        is_level_5 = not _is_v73(file.read(1024))
    every = open_v5(path) if is_level_5 else open_v73(path)
    variables = [v for v in every if not group or v.name.startswith((f"{group}.", f"{group}("))]
    if group and not variables:
        raise unreadable_recording_error(
            path, f"no group {group!r}", hint=f"it has {_listed(every)}"
        )
    beside = _Beside(variables)
    series = [s for v in variables for s in _series_of(v, variables, beside)]
    if not series:
        raise unreadable_recording_error(
            path, "no series of numbers in it", hint=f"it has {_listed(every) or 'no variable'}"
        )
    check_sample_count(path, max(s.samples for s in series), len(series))
    several = len({s.samples for s in series}) > 1
    alike: dict[tuple[int, str, float | None, float | None], list[_Series]] = {}
    for one in series:
        key = (one.samples, one.struct if several else "", one.rate, one.start)
        alike.setdefault(key, []).append(one)
    starts = [key[3] for key in alike if key[3] is not None]
    earliest = min(starts) if len(starts) == len(alike) else None
    found = as_one_file(_table(own, earliest) for own in alike.values())
    notes: list[str] = []
    words = [v for v in variables if v.read is None and not v.texts]
    if words:
        note = f"not numbers, left out: {_listed(words)}"
        notes.append(note)
    wide = [v for v in variables if v.read is not None and _is_wide(v)]
    if wide:
        note = f"more than one number a sample, left out: {_listed(wide)}"
        notes.append(note)
    return replace(found, notes=(*found.notes, *notes))


def _listed(variables: Sequence[Variable]) -> str:
    said = ", ".join(v.describe() for v in variables[:MAX_VARIABLES_LISTED])
    left = len(variables) - MAX_VARIABLES_LISTED
    return f"{said} and {left} more" if left > 0 else said


def _plain(name: str) -> str:
    """Return a name in small letters without signs between its words."""
    return re.sub(r"[\W_]", "", name.lower())


def _parent_and_field(name: str) -> tuple[str, str]:
    parent, _, field = name.rpartition(".")
    return parent, field


class _Beside:
    """Single numbers and texts of a file, by the struct that they are in and their plain names."""

    def __init__(self, variables: Iterable[Variable]) -> None:
        self.numbers: dict[str, dict[str, float]] = {}
        self.texts: dict[str, dict[str, tuple[str, ...]]] = {}
        for v in variables:
            parent, field = _parent_and_field(v.name)
            if v.texts:
                self.texts.setdefault(parent, {})[_plain(field)] = v.texts
            elif v.read is not None and math.prod(v.shape) == 1:
                self.numbers.setdefault(parent, {})[_plain(field)] = float(v.read(0, 1)[0])

    def text(self, parent: str, names: Iterable[str], count: int = 1) -> tuple[str, ...]:
        """Return the texts of the first of some names in a struct, if they are so many."""
        there = self.texts.get(parent, {})
        found = next((there[n] for n in names if n in there), ())
        return found if len(found) == count else ()

    def _number(self, name: str, words: Sequence[str]) -> float | None:
        """Return the first of some numbers next to a variable, or to a struct that it is in."""
        parent = name
        while parent:
            parent = _parent_and_field(parent)[0]
            there = self.numbers.get(parent, {})
            for word in words:
                if word in there:
                    return there[word]
        return None

    def rate(self, name: str) -> float | None:
        """Return the rate of a variable, Hz, by a rate or a step next to it."""
        rate, step = self._number(name, _RATE_NAMES), self._number(name, _STEP_NAMES)
        return 1 / step if rate is None and step else rate

    def start(self, name: str) -> float | None:
        """Return when a variable begins, s, by a number of seconds, or of days as MATLAB counts."""
        start = self._number(name, _START_NAMES)
        if start is None or not np.isfinite(start):
            return None
        days = _MIN_DATENUM <= start <= _MAX_DATENUM
        return start * (DAY_S if days else seconds_per_count_of_instants(start) or 1.0)


def _is_wide(v: Variable) -> bool:
    """Whether an array is neither a vector nor a matrix of columns."""
    long = [n for n in v.shape if n > 1]
    return len(long) > 2 or (len(long) == 2 and min(long) > MAX_COLUMNS)


def _series_of(v: Variable, variables: Sequence[Variable], beside: _Beside) -> Iterator[_Series]:
    """Yield the series of a variable: a vector is one, of a matrix each column."""
    if v.read is None or math.prod(v.shape) < 2 or _is_wide(v):
        return
    long = [n for n in v.shape if n > 1]
    parent, field = _parent_and_field(v.name)
    root = re.split(r"[.({]", v.name)[0] if parent else ""
    rate, start = beside.rate(v.name), beside.start(v.name)
    if len(long) == 1:
        yield _Series(*_name_and_unit(v.name, beside), root, long[0], rate, start, v.read)
        return
    rows, columns = long
    # As long as a vector next to it; else the longer way.
    lengths = {
        n for o in variables if _parent_and_field(o.name)[0] == parent
        for n in o.shape if o.read is not None and math.prod(o.shape) == n > 1
    }  # fmt: skip
    by_columns = rows in lengths or (columns not in lengths and rows >= columns)
    samples, count = (rows, columns) if by_columns else (columns, rows)
    names = beside.text(parent, _NAME_TEXTS, count) or tuple(
        f"{field}({k + 1})" for k in range(count)
    )
    units = beside.text(parent, _UNIT_TEXTS, count) or ("",) * count
    for k in range(count):
        column = _column(v.read, k, samples, count, along=by_columns)
        yield _Series(names[k], units[k], root, samples, rate, start, column)


def _column(
    read: Callable[[int, int], FloatArray], k: int, samples: int, count: int, *, along: bool
) -> Callable[[int, int], FloatArray]:
    """Return what reads column k of a matrix, or its row k where samples lie across."""

    def column(first: int, many: int) -> FloatArray:
        return read(k * samples + first, many)

    def row(first: int, many: int) -> FloatArray:
        found = np.empty(many)
        at_once = max(NUMBERS_READ_AT_ONCE // count, 1)
        for at in range(0, many, at_once):
            n = min(at_once, many - at)
            found[at : at + n] = read((first + at) * count, n * count)[k::count]
        return found

    return column if along else row


def _name_and_unit(name: str, beside: _Beside) -> tuple[str, str]:
    """Return what a vector is called and its unit, by the texts next to it."""
    parent, field = _parent_and_field(name)
    unit = (
        beside.text(f"{parent}.units" if parent else "units", (_plain(field),))
        or beside.text(f"{parent}.unit" if parent else "unit", (_plain(field),))
        or beside.text(parent, [f"{_plain(field)}{u}" for u in ("unit", "units")])
    )
    if parent and _plain(field) in _DATA_NAMES:
        label = beside.text(parent, _NAME_TEXTS)
        unit = unit or beside.text(parent, _UNIT_TEXTS)
        return (label[0] if label and label[0] else name), unit[0] if unit else ""
    return name, unit[0] if unit else ""


def _table(own: Sequence[_Series], earliest: float | None) -> RecordingFileColumns:
    """Return series of one length, rate and start as a table."""
    samples, start = own[0].samples, own[0].start
    short = [s.name.rpartition(".")[2] for s in own]
    names = short if len(set(short)) == len(short) else [s.name for s in own]

    def rows(places: tuple[int, ...]) -> Iterator[FloatArray]:
        for first in range(0, samples, SAMPLES_PER_BLOCK):
            many = min(SAMPLES_PER_BLOCK, samples - first)
            yield np.stack([own[k].read(first, many) for k in places])

    columns = [Channel(n, s.unit) for n, s in zip(names, own, strict=True)]
    notes: tuple[str, ...] = ()
    for k, column in enumerate(columns):
        says = not column.unit and (is_time_column(column) or says_time(column))
        if says and _MIN_DATENUM <= own[k].read(0, 1)[0] <= _MAX_DATENUM:
            columns[k] = replace(column, unit="d")
            note = f"{column.name} counts days as MATLAB does (datenum), by its size"
            notes = (note,)
    return RecordingFileColumns(
        columns=tuple(columns), notes=notes,
        read_rows=rows, rate=own[0].rate, samples=samples, group=own[0].struct,
        start=0.0 if start is None or earliest is None else start - earliest,
    )  # fmt: skip


def _is_v73(head: bytes) -> bool:
    return head.startswith(b"MATLAB 7.") and head[512:520] == b"\x89HDF\r\n\x1a\n"


FORMAT = RecordingFormat(
    name="MATLAB", extensions=(".mat",), open_columns=open_matlab, has_groups=True,
    recognises=lambda head: is_v5(head) or _is_v73(head),
)  # fmt: skip
