"""Universal files (.uff, .unv): time histories of datasets 58, as text and binary (58b).

Each dataset stands between two lines of -1, its number first, and 58 is one channel: eleven lines,
then its values. Those evenly spaced and alike in start, step and length are one table; others
carry their own abscissa. Every other dataset, and every spectrum, is left out with a note.

Source: SDRC, Universal Dataset Number 58, "Function at Nodal DOF"; UC-SDRL, "Binary 58 Universal
File Format".
"""

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from cardan.core.arrays import FloatArray
from cardan.core.errors import InvalidFileError
from cardan.physics.signals.recording import SAMPLES_PER_BLOCK, Channel, rechunk_to_block_size
from cardan.readers.base import (
    RecordingFileColumns,
    RecordingFormat,
    as_one_file,
    check_sample_count,
    missing_rows_error,
    rate_of_printed_step,
    unreadable_recording_error,
)
from cardan.readers.time_units import seconds_per_time_unit

HEADER_LINES, MAX_LINE_BYTES = 11, 1 << 10
MAX_DATASETS = 10_000
TEXT_BYTES_READ_AT_ONCE = 1 << 21
STEP_DIGITS = 6
"""Digits that E13.5 prints of a step."""
_CLOSING_LINE = re.compile(rb"\n[ \t]*-1[ \t]*\r?\n")
_WIDTHS = {(2, True): (13,) * 6, (4, True): (20,) * 4,
           (2, False): (13,) * 6, (4, False): (13, 20, 13, 20)}  # fmt: skip
"""Columns of a row of text, by ordinate type and whether the abscissa is even."""
_LAYOUTS = {
    (2, True): ("f4",), (4, True): ("f8",), (2, False): ("f4f4",), (4, False): ("f4f8", "f8f8"),
}  # fmt: skip
"""Layouts of binary values; of an abscissa the format says single, pyuff 2.5 writes double."""
_FUNCTIONS = {
    2: "auto spectrum", 3: "cross spectrum", 4: "frequency response", 6: "coherence",
    9: "power spectral density", 12: "spectrum",
}  # fmt: skip
_TIME, _UNKNOWN = 17, (0, 1)
_ABSCISSAE = {18: "frequency", 19: "rpm", 20: "order", 8: "displacement"}
_DIRECTIONS = {1: "+X", -1: "-X", 2: "+Y", -2: "-Y", 3: "+Z", -3: "-Z",
               4: "+RX", -4: "-RX", 5: "+RY", -5: "-RY", 6: "+RZ", -6: "-RZ"}  # fmt: skip


@dataclass(frozen=True)
class _Function:
    """A dataset 58: its channel, its axis, and where its values are."""

    number: int
    name: str
    place: str
    """Node and direction."""
    unit: str
    kind: int
    ordinate: int
    samples: int
    even: bool
    first: float
    step: float
    axis: int
    axis_unit: str
    start: int
    """Byte of its values."""
    end: int
    dtype: np.dtype[Any] | None = None
    """Of a value, or of a pair of abscissa and value; None of text."""

    @property
    def is_real(self) -> bool:
        return self.ordinate in (2, 4)


def open_uff(path: Path, _group: str = "") -> RecordingFileColumns:
    """Open a universal file."""
    functions, others = _datasets(path)
    real = [f for f in functions if f.is_real and f.kind in (0, 1)]
    notes = _notes(functions, real, others)
    if not real:
        raise unreadable_recording_error(
            path, "no time history (dataset 58) in it", hint="; ".join(notes)
        )
    check_sample_count(path, max(f.samples for f in real), len(real))
    names = _names(real)
    alike: dict[Any, list[tuple[str, _Function]]] = {}
    for name, f in zip(names, real, strict=True):
        key = (f.samples, f.first, f.step, f.axis, f.axis_unit) if f.even else f.number
        alike.setdefault(key, []).append((name, f))
    found = as_one_file(_table(path, own) for own in alike.values())
    return replace(found, notes=(*found.notes, *notes))


def _notes(
    functions: Sequence[_Function], real: Sequence[_Function], others: Sequence[str]
) -> list[str]:
    """Return what is to be said of datasets that are left out."""
    left = [_FUNCTIONS.get(f.kind, f"function {f.kind}") for f in functions if f not in real]
    notes: list[str] = []
    if left:
        kinds = ", ".join(f"{left.count(kind)} {kind}" for kind in dict.fromkeys(left))
        note = f"no time histories, left out: {kinds}"
        notes.append(note)
    if others and not functions:
        note = f"it has datasets {', '.join(dict.fromkeys(others))}"
        notes.append(note)
    return notes


def _names(functions: Sequence[_Function]) -> list[str]:
    """Return what channels are called: by their first line; by node, and number, if two are."""
    names = [f.name or f.place or f"dataset {f.number}" for f in functions]
    for more in ("place", "number"):
        names = [
            f"{n} {getattr(f, more)}" if names.count(n) > 1 else n
            for n, f in zip(names, functions, strict=True)
        ]
    return names


def _datasets(path: Path) -> tuple[list[_Function], list[str]]:
    """Return the functions of a file, and the numbers of its other datasets."""
    functions: list[_Function] = []
    others: list[str] = []
    with path.open("rb") as file:
        while _begins(path, file):
            kind = _line(path, file) or b""
            number = len(functions) + len(others) + 1
            if number > MAX_DATASETS:
                raise unreadable_recording_error(
                    path, "it holds too many datasets", value=f"over {MAX_DATASETS}"
                )
            if kind[:6].strip() == b"58":
                found = _function(path, file, kind, number)
                functions.append(found)
                file.seek(found.end)
            else:
                others.append(kind.strip()[:6].decode("latin-1"))
                file.seek(_start_of_closing_line(path, file, number))
            if not _begins(path, file):
                raise _no_end_error(path, number)
    return functions, others


def _begins(path: Path, file: Any) -> bool:
    """Whether a line of -1 comes next, behind empty ones; at the end of the file there is none."""
    line = _line(path, file)
    while line and not line.strip():
        line = _line(path, file)
    if line and line.strip() != b"-1":
        raise unreadable_recording_error(
            path, "it is damaged: a dataset does not begin and end with -1",
            value=repr(line[:60].decode("latin-1").strip()),
        )  # fmt: skip
    return bool(line)


def _line(path: Path, file: Any) -> bytes:
    """Return the next line; empty at the end of the file."""
    line = file.readline(MAX_LINE_BYTES)
    if len(line) == MAX_LINE_BYTES:
        raise unreadable_recording_error(
            path, "it is damaged: a line of a dataset has no end", value=f"byte {file.tell()}"
        )
    return line


def _no_end_error(path: Path, number: int) -> InvalidFileError:
    return unreadable_recording_error(
        path, "the file is cut short: a dataset has no end",
        value=f"dataset {number}, at {path.stat().st_size} bytes",
    )  # fmt: skip


def _start_of_closing_line(path: Path, file: Any, number: int) -> int:
    """Return the byte at which the line that closes a dataset of text begins."""
    at = file.tell() - 1
    file.seek(at)
    held = b""
    while True:
        more = file.read(TEXT_BYTES_READ_AT_ONCE)
        held += more or b"\n"  # the last line of a file may have no end
        found = _CLOSING_LINE.search(held)
        if found is not None:
            return at + found.start() + 1
        if not more:
            raise _no_end_error(path, number)
        at += max(len(held) - MAX_LINE_BYTES, 0)
        held = held[-MAX_LINE_BYTES:]


def _function(path: Path, file: Any, kind: bytes, number: int) -> _Function:
    """Return a dataset 58, whose eleven lines come next."""
    lines = [_line(path, file) for _ in range(HEADER_LINES)]
    if not all(lines):
        raise _no_end_error(path, number)
    text = [line.decode("latin-1").rstrip("\r\n") for line in lines]
    field = partial(_field, path, number)
    ordinate, samples = int(field(text[6], 0, 10)), int(field(text[6], 10, 20))
    if samples < 1 or ordinate not in (2, 4, 5, 6):
        raise unreadable_recording_error(
            path, f"dataset {number} states values that cannot be true",
            value=f"type {ordinate}, {samples} values",
        )  # fmt: skip
    node, direction = int(field(text[5], 41, 51)), int(field(text[5], 51, 55))
    found = _Function(
        number=number, name=_label(text[0]), unit=_label(text[8][47:67]),
        place=f"{node or ''}{_DIRECTIONS.get(direction, '')}", kind=int(field(text[5], 0, 5)),
        ordinate=ordinate, samples=samples, even=field(text[6], 20, 30) == 1,
        first=field(text[6], 30, 43), step=field(text[6], 43, 56),
        axis=int(field(text[7], 0, 10)), axis_unit=_label(text[7][47:67]), start=file.tell(), end=0,
    )  # fmt: skip
    if kind[6:7].lower() == b"b":
        return _with_binary_values(path, file, kind.decode("latin-1"), found)
    return replace(found, end=_start_of_closing_line(path, file, number))


def _field(path: Path, number: int, line: str, first: int, last: int) -> float:
    """Return a number in some columns of a line; what is blank is 0, as in FORTRAN."""
    text = line[first:last].strip()
    try:
        found = float(_with_exponent(text)) if text else 0.0
    except ValueError:
        found = np.nan
    if not np.isfinite(found):
        raise unreadable_recording_error(
            path, f"dataset {number} is damaged: a field of its head is no number",
            value=repr(text), hint="its columns are not those of dataset 58",
        )  # fmt: skip
    return found


def _with_exponent(text: str) -> str:
    """Return a number of FORTRAN, 1.5D+02 or 1.5-100, as others write it."""
    return re.sub(r"(?<=[\d.])([+-]\d+)$", r"E\1", text.upper().replace("D", "E"))


def _label(text: str) -> str:
    """Return a label, "" where it is NONE; columns are counted in bytes, letters may be UTF-8."""
    raw = text.encode("latin-1")
    label = raw.decode("utf-8").strip() if _is_utf_8(raw) else text.strip()
    return "" if label.upper() == "NONE" else label


def _is_utf_8(raw: bytes) -> bool:
    try:
        raw.decode("utf-8")
    except UnicodeDecodeError:
        return False
    return True


def _with_binary_values(path: Path, file: Any, kind: str, found: _Function) -> _Function:
    """Return a function whose values are binary, by the layout behind which its end stands."""
    order, form = kind[7:13].strip(), kind[13:19].strip()
    if order not in ("1", "2") or form != "2":
        raise unreadable_recording_error(
            path, f"dataset {found.number} is in a binary form that is not read",
            value=f"byte order {order}, floating point {form}",
            hint="read are 1 or 2, and 2 (IEEE 754)",
        )  # fmt: skip
    sign = "<" if order == "1" else ">"
    if found.is_real:
        layouts = _LAYOUTS[found.ordinate, found.even]
    else:  # which is left out: two numbers a value, behind the abscissa if that is stored
        part = "f4" if found.ordinate == 5 else "f8"
        layouts = (part * 2,) if found.even else ("f4" + part * 2, part * 3)
    for layout in layouts:
        parts = re.findall("..", layout)
        dtype = np.dtype([(f"v{k}", sign + part) for k, part in enumerate(parts)])
        end = found.start + found.samples * dtype.itemsize
        file.seek(end)
        if file.read(80).lstrip(b"\r\n").split(b"\n")[0].strip() == b"-1":
            return replace(found, end=end, dtype=dtype)
    stated, size = _field(path, found.number, kind, 31, 43), path.stat().st_size
    raise unreadable_recording_error(
        path, "the file is cut short, or its header claims what is not there",
        value=f"dataset {found.number}: {found.samples} values, {stated:.0f} bytes stated, "
        f"{size - found.start} to the end of the file",
    )  # fmt: skip


def _second(path: Path, f: _Function) -> float:
    """Return how many seconds the abscissa of a function counts in.

    Raises
    ------
    InvalidFileError
        If its unit is unknown.
    """
    second = seconds_per_time_unit(f.axis_unit)
    if second is None:
        raise unreadable_recording_error(
            path, f"unknown unit of the time of {f.name or f.place}", value=repr(f.axis_unit)
        )
    return second


def _no_time(f: _Function) -> str:
    """Return what the samples of a function are counted by, where that is no time."""
    says_time = seconds_per_time_unit(f.axis_unit) is not None and (f.axis_unit or f.kind == 1)
    if f.axis == _TIME or (f.axis in _UNKNOWN and says_time):
        return ""
    return f.axis_unit or _ABSCISSAE.get(f.axis, f"abscissa of type {f.axis}")


def _table(path: Path, own: Sequence[tuple[str, _Function]]) -> RecordingFileColumns:
    """Return functions of one abscissa as a table; an uneven one has its abscissa as clock."""
    columns = tuple(Channel(name, f.unit) for name, f in own)
    first = own[0][1]
    no_time = _no_time(first)
    second = 1.0 if no_time else _second(path, first)
    if not first.even:
        abscissa = Channel(no_time or "time", first.axis_unit or ("" if no_time else "s"))
        return RecordingFileColumns(
            columns=(abscissa, *columns), clock=None if no_time else 0, no_time=no_time,
            samples=first.samples, read_rows=lambda places: _values(path, first, places),
        )  # fmt: skip
    if not first.step > 0:
        raise unreadable_recording_error(
            path, f"the step of {own[0][0]} must be above 0", value=f"{first.step:g}"
        )

    def rows(places: tuple[int, ...]) -> Iterator[FloatArray]:
        streams = [
            rechunk_to_block_size(_values(path, own[k][1], (0,)), size=SAMPLES_PER_BLOCK)
            for k in places
        ]
        for pieces in zip(*streams, strict=True):
            yield np.concatenate(pieces)

    return RecordingFileColumns(
        columns=columns, read_rows=rows, samples=first.samples, no_time=no_time,
        rate=None if no_time else rate_of_printed_step(first.step, STEP_DIGITS) / second,
        start=first.first * second,
    )  # fmt: skip


def _values(path: Path, f: _Function, places: tuple[int, ...]) -> Iterator[FloatArray]:
    """Yield what a function holds (k, n): its values; of an uneven one its abscissa first."""
    width, read = (1 if f.even else 2), 0
    for piece in _text_values(path, f) if f.dtype is None else _binary_values(path, f):
        rows = piece.reshape(-1, width).T
        read += rows.shape[1]
        if read > f.samples:
            raise unreadable_recording_error(
                path, f"dataset {f.number} holds more values than it states", value=str(f.samples)
            )
        yield rows[list(places)]
    if read < f.samples:
        raise missing_rows_error(path, f.samples, read)


def _binary_values(path: Path, f: _Function) -> Iterator[FloatArray]:
    assert f.dtype is not None
    with path.open("rb") as file:
        file.seek(f.start)
        for first in range(0, f.samples, SAMPLES_PER_BLOCK):
            stored = np.fromfile(file, f.dtype, min(SAMPLES_PER_BLOCK, f.samples - first))
            names = f.dtype.names or ()
            yield np.stack([stored[name].astype(float) for name in names], axis=-1).ravel()


def _text_values(path: Path, f: _Function) -> Iterator[FloatArray]:
    """Yield the numbers of a dataset of text, as they come: of an uneven one pairs."""
    held = np.empty(0)
    with path.open("rb") as file:
        file.seek(f.start)
        while (left := f.end - file.tell()) > 0:
            text = file.read(min(TEXT_BYTES_READ_AT_ONCE, left))
            if not text.endswith(b"\n"):
                text += _line(path, file)
            found = np.concatenate([held, _numbers(path, f, text)])
            whole = len(found) - len(found) % (1 if f.even else 2)
            yield found[:whole]
            held = found[whole:]
    if held.size:
        raise missing_rows_error(path, f.samples, f.samples - 1)


def _numbers(path: Path, f: _Function, text: bytes) -> FloatArray:
    """Return the numbers of some lines (n,): by their columns where they touch each other."""
    try:
        return np.array(text.split(), dtype=float)
    except ValueError:
        pass
    found: list[float] = []
    for line in text.decode("latin-1").splitlines():
        at = 0
        for width in _WIDTHS[f.ordinate, f.even]:
            field = line[at : at + width].strip()
            at += width
            if field:
                try:
                    found.append(float(_with_exponent(field)))
                except ValueError as error:
                    raise unreadable_recording_error(
                        path, f"dataset {f.number} holds no number where one is due",
                        value=repr(line[:60].strip()),
                    ) from error  # fmt: skip
    return np.array(found)


def _is_uff(head: bytes) -> bool:
    """Whether a file is a universal file: -1 in six columns, then the number of a dataset.

    A table of one column may begin with the same two numbers, but not in six columns.
    """
    return _BEGINNING.match(head) is not None


_BEGINNING = re.compile(
    rb"(?:[ \t]*\r?\n)*(?:    -1[ ]*\r?\n[ ]{0,5}\d{1,5}(?:b|\s)|[ ]*-1[ ]*\r?\n[ ]*58b?\s)"
)
"""How a file begins; some programs leave the spaces out before 58."""

FORMAT = RecordingFormat(
    name="UFF", extensions=(".uff", ".unv"), open_columns=open_uff, recognises=_is_uff
)
