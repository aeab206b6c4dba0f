"""Files of VECTO, the European Commission's simulation tool: parts in JSON, tables in its CSV.

Files are read by content: each version of the tool has its own header, and the keys stay.
"""

import codecs
import json
import re
from collections.abc import Container, Iterable, Mapping
from math import isfinite, isinf
from pathlib import Path
from typing import Any, NamedTuple, NoReturn

import numpy as np

from cardan.core.arrays import FloatArray
from cardan.core.errors import FileIssue, InvalidFileError
from cardan.core.lazy_dataclass import dataclass
from cardan.core.units import kW, rpm
from cardan.physics.signals.channel_units import (
    RADIANS_PER_TURN,
    ROTATION_SPEED_UNITS,
    TORQUE_UNITS,
    VEHICLE_SPEED_UNITS,
    usual_unit,
)
from cardan.schema.yaml_tree import read_text, to_one_line

MAX_TABLE_CHARACTERS = 200_000_000
"""A year of driving at one row a second has a tenth of this."""

_NO_FILE = ("", "<NOFILE>")
_UNIT = re.compile(r"\s*[\[<(]([^\])>]*).*")


@dataclass(frozen=True, slots=True, kw_only=True)
class JobValue:
    """A value of a job, with the file and the key that it came from."""

    value: Any
    source: str

    def __str__(self) -> str:
        return self.source


@dataclass(frozen=True, kw_only=True)
class VectoPart:
    """The body of one JSON file of a job; keys are found whatever their case."""

    path: Path
    text: str
    body: Mapping[str, Any]

    def refuse(
        self, key: str, message: str, *, got: object = "", hint: str = "", nth: int = 0
    ) -> NoReturn:
        """Reject a value, with its line: that of the nth such key of the file."""
        places = [
            m.start() for m in re.finditer(f'(?i)"{re.escape(key.split(".")[-1])}"', self.text)
        ]
        line = self.text.count("\n", 0, places[nth]) + 1 if nth < len(places) else 0
        issue = FileIssue(
            message=message, key=key, value=to_one_line(str(got))[:60], hint=hint, line=line
        )
        raise InvalidFileError(str(self.path), (issue,))

    def get(self, key: str, table: Mapping[str, Any] | None = None) -> Any:
        """Return what stands at a key; None if the file lacks it or leaves it empty."""
        for name, value in (self.body if table is None else table).items():
            if name.casefold() == key.casefold():
                return None if value in ("", "NaN") else value
        return None

    def number(
        self, key: str, table: Mapping[str, Any] | None = None, *, label: str = "", nth: int = 0
    ) -> JobValue | None:
        """Return a number above 0; None if the file lacks it or leaves it at 0.

        Raises
        ------
        InvalidFileError
            If something else stands there.
        """
        given, label = self.get(key, table), label or key
        if given is None:
            return None
        try:
            value = float("nan") if isinstance(given, bool) else float(given)
        except (TypeError, ValueError):
            value = float("nan")
        if not isfinite(value) or value < 0:
            self.refuse(label, "must be a number, 0 or above", got=given, nth=nth)
        return JobValue(value=value, source=self.source(label)) if value else None

    def source(self, key: str) -> str:
        """Return where a key stands: `MT_6.vgbx: Gears[1].Ratio`."""
        return f"{self.path.name}: {key}"

    def tables(self, key: str, table: Mapping[str, Any] | None = None) -> list[Mapping[str, Any]]:
        """Return the tables of a list; an empty one where the file lacks it.

        Raises
        ------
        InvalidFileError
            If something else stands there.
        """
        given = self.get(key, table)
        if given is None:
            return []
        if not isinstance(given, list) or not all(isinstance(one, dict) for one in given):
            self.refuse(key, "must be a list of tables", got=given)
        return given

    def table(self, key: str) -> Mapping[str, Any]:
        """Return a table; an empty one where the file lacks it."""
        given = self.get(key)
        return given if isinstance(given, dict) else {}

    def file(self, key: str, table: Mapping[str, Any] | None = None) -> Path | None:
        """Return the path of a file that a key names, next to this one; None if it names none.

        The file need not exist. Names are those of a system that ignores case.
        """
        given = self.get(key, table)
        if not isinstance(given, str) or given.strip() in _NO_FILE:
            return None
        path = self.path.parent / given.replace("\\", "/")
        if not path.exists() and path.parent.is_dir():
            wanted = path.name.casefold()
            path = next((p for p in path.parent.iterdir() if p.name.casefold() == wanted), path)
        return path

    def required_file(self, key: str) -> Path:
        """Return the path of a file that a key must name.

        Raises
        ------
        InvalidFileError
            If the key is missing, or the file is.
        """
        path = self.file(key)
        if path is None:
            there = ", ".join(sorted(self.body)) or "none"
            self.refuse(key, "names no file", hint=f"the keys of this file: {there}")
        if not path.is_file():
            self.refuse(key, "names a file that does not exist", got=path)
        return path


def read_part(path: Path) -> VectoPart:
    """Return the body of a JSON file of VECTO.

    Raises
    ------
    InvalidFileError
        If it cannot be read, or is no JSON table.
    """
    text = read_text(path)
    try:
        found = json.loads(text)
    except json.JSONDecodeError as error:
        xml = "save the job as JSON: VECTO's XML is not read" if text.lstrip()[:1] == "<" else ""
        issue = FileIssue(
            message=f"is not a JSON file: {error.msg}",
            hint=xml,
            line=error.lineno,
            column=error.colno,
        )
        raise InvalidFileError(str(path), (issue,)) from None
    except RecursionError:
        issue = FileIssue(message="is not a JSON file of VECTO: too many nested tables")
        raise InvalidFileError(str(path), (issue,)) from None
    body = found.get("Body", found) if isinstance(found, dict) else None
    if not isinstance(body, dict):
        issue = FileIssue(message="is not a JSON file of VECTO: the key Body is missing")
        raise InvalidFileError(str(path), (issue,))
    return VectoPart(path=path, text=text, body=body)


class ColumnUnit(NamedTuple):
    """SI value of VECTO's own unit of a column, and of each unit that its heading may name."""

    usual: float
    allowed: Mapping[str, float]


_TURNING_UNITS = {unit: RADIANS_PER_TURN * turns for unit, turns in ROTATION_SPEED_UNITS.items()}
ROTATION_SPEED = ColumnUnit(rpm, _TURNING_UNITS)
TORQUE = ColumnUnit(1.0, TORQUE_UNITS)
POWER = ColumnUnit(kW, {"W": 1.0, "kW": kW, "MW": 1e6})
ROAD_SPEED = ColumnUnit(VEHICLE_SPEED_UNITS["km/h"], VEHICLE_SPEED_UNITS)
TIME = ColumnUnit(1.0, {"s": 1.0, "ms": 1e-3, "min": 60.0, "h": 3600.0})
RATIO = ColumnUnit(1.0, {"1": 1.0, "%": 1e-2})


@dataclass(frozen=True, kw_only=True)
class VectoTable:
    """A table of VECTO: `values` (rows, columns), nan in empty cells; units are in `headings`.

    `heading_line` is the line of the headings, 0 without them.
    """

    path: Path
    headings: tuple[str, ...]
    heading_line: int
    values: FloatArray

    def find_in_si(self, *names: str, unit: ColumnUnit) -> FloatArray | None:
        """Return a column by its names in SI, (rows,); None if no heading has one of them.

        Raises
        ------
        InvalidFileError
            If its heading names a unit that the column cannot have.
        """
        at = self._place(names)
        return None if at is None else self._in_si(at, names[0], unit)

    def column_in_si(self, *names: str, place: int, unit: ColumnUnit) -> FloatArray:
        """Return a column in SI by its names, or by its place if no heading has one of them.

        Raises
        ------
        InvalidFileError
            If there is no such column, a cell of it is empty, or its heading names a unit that the
            column cannot have.
        """
        at = self._place(names)
        if at is None and place < self.values.shape[1]:
            at = place
        if at is None or np.isnan(self.values[:, at]).any():
            raise self.missing(names)
        return self._in_si(at, names[0], unit)

    def _place(self, names: Iterable[str]) -> int | None:
        bare = [bare_heading(h) for h in self.headings]
        return next((bare.index(n.casefold()) for n in names if n.casefold() in bare), None)

    def _in_si(self, at: int, name: str, unit: ColumnUnit) -> FloatArray:
        """Return a column, (rows,), times its unit; `name` stands in the error."""
        found = _UNIT.search(self.headings[at]) if self.headings else None
        said = found[1].strip() if found else ""
        usual = usual_unit(said)
        factor = unit.allowed.get(usual) if usual else unit.usual
        if factor is None:
            issue = FileIssue(
                message="the heading names a unit that this column cannot have",
                key=name, value=to_one_line(said)[:40], hint=f"one of {', '.join(unit.allowed)}",
                line=self.heading_line,
            )  # fmt: skip
            raise InvalidFileError(str(self.path), (issue,))
        return self.values[:, at] * factor

    def missing(self, names: Iterable[str]) -> InvalidFileError:
        """Return the error about a column that is not there or has empty cells."""
        issue = FileIssue(
            message=f"needs a column {' or '.join(names)} with a number in each row",
            hint=f"its columns: {', '.join(self.headings) or 'without headings'}",
        )
        return InvalidFileError(str(self.path), (issue,))


def read_table(path: Path, *, only: Container[str] | None = None) -> VectoTable:
    """Return a table of VECTO: comma-separated, # before comments, one heading or none.

    Parameters
    ----------
    only
        Columns to read, by their headings in lower case without units; others are nan and may hold
        any text. None reads all.

    Raises
    ------
    InvalidFileError
        If it cannot be read, or a cell is no number, with its line.
    """
    text = _read_long_text(path)
    headings: tuple[str, ...] = ()
    heading_line = 0
    rows: list[list[float]] = []
    passed_over: list[int] = []
    for line, said in enumerate(text.splitlines(), 1):
        bare = said.split("#")[0].strip()
        if not bare:
            continue
        cells = [c.strip() for c in bare.split("," if "," in bare or ";" not in bare else ";")]
        if headings and len(cells) == len(headings):
            for k in passed_over:
                cells[k] = ""
        values = [_number(c) for c in cells]
        if not rows and not headings and any(v is None for v in values):
            headings, heading_line = tuple(cells), line
            passed_over = [
                k
                for k, h in enumerate(headings)
                if only is not None and bare_heading(h) not in only
            ]
            continue
        width = len(headings) or (len(rows[0]) if rows else len(cells))
        if len(cells) != width or any(v is None for v in values):
            bad = next((c for c, v in zip(cells, values, strict=True) if v is None), "")
            issue = FileIssue(
                message=f"a row needs {width} numbers",
                value=to_one_line(bad)[:40] or f"{len(cells)} cells",
                line=line,
            )
            raise InvalidFileError(str(path), (issue,))
        rows.append([v for v in values if v is not None])
    if not rows:
        raise InvalidFileError(str(path), (FileIssue(message="holds no row of numbers"),))
    return VectoTable(
        path=path, headings=headings, heading_line=heading_line, values=np.array(rows)
    )


def bare_heading(heading: str) -> str:
    """Return a heading in lower case, without its unit: `time [s]` is time."""
    return _UNIT.sub("", heading).strip().casefold()


def _read_long_text(path: Path) -> str:
    """Return the text of a table, which may be longer than an application is."""
    try:
        if path.is_file() and path.stat().st_size > MAX_TABLE_CHARACTERS:
            raise InvalidFileError(str(path), (FileIssue(message="is longer than 200 MB"),))
        data = path.read_bytes()
    except OSError as error:
        issue = FileIssue(message=f"cannot be read: {error.strerror or error}")
        raise InvalidFileError(str(path), (issue,)) from None
    marked = data.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE))
    return data.decode("utf-16" if marked else "utf-8-sig", errors="replace")


def _number(cell: str) -> float | None:
    """Return the number of a cell, nan of an empty one; None where it holds something else."""
    if not cell:
        return float("nan")
    try:
        value = float(cell)
    except ValueError:
        return None
    return None if isinf(value) else value
