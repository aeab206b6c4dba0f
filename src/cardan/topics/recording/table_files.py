"""Tables of results as CSV and Parquet, and rainflow matrices read back from them."""

import csv
import io
import math
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from cardan.core.errors import DesignError, FileIssue, InvalidFileError, MissingDependencyError
from cardan.core.units import MPa
from cardan.physics.fatigue.rainflow_matrix import RainflowKind, RainflowTable, merge_tables
from cardan.topics.recording.rainflow_matrices import (
    BIN_COLUMNS,
    DATA_COLUMN,
    DATA_GRADES,
    Columns,
    RainflowMatrices,
    worst_grade,
)

MAX_EDGE_ERROR = 1e-6
"""Error of an edge, in bins, by which it is still that of a bin."""


def check_table_suffix(path: Path) -> None:
    """Refuse a table whose ending is none that is written.

    Raises
    ------
    DesignError
        With the endings that are.
    """
    if path.suffix.lower() not in _WRITERS:
        msg = f"a table ends in .csv or .parquet, got {path.name!r}"
        raise DesignError(msg)


def table_bytes(columns: Columns, path: Path) -> bytes:
    """Return a table as the file of a name has it, `.csv` or `.parquet`."""
    check_table_suffix(path)
    return _WRITERS[path.suffix.lower()](columns)


def _csv(columns: Columns) -> bytes:
    text = io.StringIO()
    rows = csv.writer(text, lineterminator="\n")
    rows.writerow(columns)
    rows.writerows(zip(*columns.values(), strict=True))
    return text.getvalue().encode()


def _parquet(columns: Columns) -> bytes:
    pa, pq = _arrow()
    sink = io.BytesIO()
    kinds = {n: pa.string() if n in _TEXTS else pa.float64() for n in columns}
    fields = [pa.array(column, kinds[n]) for n, column in columns.items()]
    pq.write_table(pa.table(fields, names=list(columns)), sink)
    return sink.getvalue()


_TEXTS = ("recording", "gauge", DATA_COLUMN)
_WRITERS: Mapping[str, Callable[[Columns], bytes]] = {".csv": _csv, ".parquet": _parquet}


def _arrow() -> tuple[Any, Any]:
    try:
        import pyarrow as pa  # pyright: ignore[reportMissingTypeStubs]
        import pyarrow.parquet as pq  # pyright: ignore[reportMissingTypeStubs]
    except ImportError as error:
        msg = f"this needs {error.name}; pip install 'cardan[fatigue,recordings]'"
        raise MissingDependencyError(msg) from error
    return pa, pq


def read_rainflow_matrices(path: Path) -> RainflowMatrices:
    """Read the matrices of a file that `--from-to` or `--range-mean` wrote.

    Raises
    ------
    InvalidFileError
        If it is no such file, or a bin or a count cannot be: with the row.
    """
    check_table_suffix(path)
    try:
        rows = _csv_rows(path) if path.suffix.lower() == ".csv" else _parquet_rows(path)
    except (OSError, UnicodeDecodeError, csv.Error, ValueError) as error:  # Arrow's are ValueErrors
        raise _refusal(path, f"it cannot be read: {error}") from error
    names = rows[0].keys() if rows else ()
    kinds: list[RainflowKind] = [
        kind for kind, edges in BIN_COLUMNS.items() if {*edges, "gauge", "count"} <= {*names}
    ]
    if not kinds:
        known = " or ".join(f"{kind} ({', '.join(e)})" for kind, e in BIN_COLUMNS.items())
        raise _refusal(path, f"it holds no rainflow matrix: {known}, with gauge and count")
    bins: dict[str, list[tuple[float, int, int, float, str]]] = {}
    for line, row in enumerate(rows, 2):
        bins.setdefault(str(row["gauge"]), []).append(_bin(path, line, row, kinds[0]))
    return RainflowMatrices(
        kind=kinds[0],
        tables={gauge: _table(kinds[0], own) for gauge, own in bins.items()},
        grades={g: worst_grade(b[4] for b in own) for g, own in bins.items()},
    )


def _csv_rows(path: Path) -> list[dict[str, Any]]:
    with path.open(encoding="utf-8-sig", newline="") as file:
        return list(csv.DictReader(file))


def _parquet_rows(path: Path) -> list[dict[str, Any]]:
    return _arrow()[1].read_table(path).to_pylist()


def _bin(
    path: Path, line: int, row: Mapping[str, Any], kind: RainflowKind
) -> tuple[float, int, int, float, str]:
    """Return width, numbers along both axes, count and grade of a row."""
    names = BIN_COLUMNS[kind]
    try:
        edges = [float(row[n]) * MPa for n in names]
        count = float(row["count"])
    except (TypeError, ValueError) as error:
        raise _refusal(path, f"edges and count must be numbers: {error}", line) from error
    if not (all(map(math.isfinite, edges)) and 0 < count < math.inf):
        raise _refusal(path, "edges must be finite, and the count finite and above 0", line)
    width = edges[1] - edges[0]
    exponent = round(math.log2(width)) if width > 0 else 0
    exact = 2.0**exponent
    numbers = [edge / exact for edge in edges]
    off = max(abs(n - round(n)) for n in numbers)
    along, across = (round(numbers[k + 1]) - round(numbers[k]) for k in (0, 2))
    if off > MAX_EDGE_ERROR or (along, across) != (1, 1):
        said = ", ".join(f"{n} {row[n]}" for n in names)
        raise _refusal(
            path, f"these are no edges of a bin: {said}", line,
            "both axes have bins of one width, a power of two in Pa, with an edge at 0",
        )  # fmt: skip
    if kind == "range-mean" and numbers[0] < 0:
        raise _refusal(path, f"a range must be 0 or above, got {row[names[0]]} MPa", line)
    data = row.get(DATA_COLUMN) or DATA_GRADES[0]
    if data not in DATA_GRADES:
        raise _refusal(path, f"{DATA_COLUMN} must be {', '.join(DATA_GRADES)}, got {data!r}", line)
    return exact, round(numbers[0]), round(numbers[2]), count, data


def _table(kind: RainflowKind, bins: list[tuple[float, int, int, float, str]]) -> RainflowTable:
    """Return bins as a matrix; those of several widths in the widest."""
    parts: list[tuple[RainflowTable, float]] = []
    for width in sorted({b[0] for b in bins}):
        own = [b for b in bins if b[0] == width]
        row, column = (np.array([b[k] for b in own], np.int64) for k in (1, 2))
        count = np.array([b[3] for b in own])
        parts.append(
            (RainflowTable(kind=kind, width=width, row=row, column=column, count=count), 1.0)
        )
    return merge_tables(parts)


def _refusal(path: Path, message: str, line: int = 0, hint: str = "") -> InvalidFileError:
    return InvalidFileError(str(path), (FileIssue(message=message, line=line, hint=hint),))
