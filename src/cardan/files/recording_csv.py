"""CSV recordings of any dialect: delimiter, decimal sign, header and units are found out.

Found out, not guessed: a head that can be read in two ways is refused.
"""

import csv
import re
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from cardan.base.arrays import FloatArray
from cardan.fatigue.recording import Channel
from cardan.files.recordings import Table, bad

MISSING = ("", "nan", "NaN", "NAN", "-nan", "NA", "N/A", "n/a", "null", "NULL", "-", "--")
_NUMBER = {
    ".": re.compile(r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?"),
    ",": re.compile(r"[+-]?(\d+,?\d*|,\d+)([eE][+-]?\d+)?"),
}
_DELIMITERS = (";", "\t", ",", "|", " ")
_UNIT = re.compile(r"^(.*?)\s*(?:\[(.*)\]|\((.*)\)|\s/\s*(\S+))$")
_HEAD = 1 << 16


@dataclass(frozen=True)
class Dialect:
    """How the text of a table is to be read."""

    delimiter: str
    decimal: str
    columns: tuple[Channel, ...]
    first: int
    """Lines before the first row of numbers."""
    encoding: str


def _fields(line: str, delimiter: str) -> list[str]:
    if delimiter == " ":
        return line.split()
    return [f.strip() for f in next(csv.reader([line], delimiter=delimiter), [])]


def _numeric(fields: list[str], decimal: str) -> bool:
    number = _NUMBER[decimal]
    said = [f for f in fields if f not in MISSING]
    return bool(said) and all(number.fullmatch(f) for f in said)


def _first_row(lines: list[str], delimiter: str, decimal: str) -> tuple[int, int] | None:
    """First line from which all are numbers, and their count; None if there is none."""
    first, width = None, 0
    for k, line in enumerate(lines):
        if not line.strip():
            continue
        fields = _fields(line, delimiter)
        if not _numeric(fields, decimal):
            first = None
        elif first is None or len(fields) != width:
            # A last line cut short belongs to the rows before it.
            if first is not None and k == len(lines) - 1:
                continue
            first, width = k, len(fields)
    return None if first is None else (first, width)


def dialect(path: Path) -> Dialect:
    """Find out how a table is written from its first 64 kB.

    Raises
    ------
    BadFile
        If no rows of numbers are found, or they can be read in more than one way.
    """
    with path.open("rb") as file:
        head = file.read(_HEAD)
    if b"\x00" in head and not head.startswith((b"\xff\xfe", b"\xfe\xff")):
        raise bad(path, "it is not text", hint="is the ending of its name right?")
    encoding = "utf-16" if head.startswith((b"\xff\xfe", b"\xfe\xff")) else "utf-8"
    text = head.decode(encoding, errors="replace")
    if "\ufffd" in text[:-1]:  # the very last letter may have been cut in two by us
        encoding, text = "latin-1", head.decode("latin-1")
    lines = text.removeprefix("\ufeff").splitlines()
    if len(head) == _HEAD:
        lines = lines[:-1]  # cut by us, not by the writer
    found: list[tuple[int, Dialect]] = []
    for delimiter in _DELIMITERS:
        for decimal in ".,":
            start = None if delimiter == decimal else _first_row(lines, delimiter, decimal)
            if start is None:
                continue
            first, width = start
            columns, named = _header(lines[:first], delimiter, width)
            # Names rarely hold commas; a line of names that does was meant to be cut there.
            sure = 0 if not named else 1 if any("," in c.name for c in columns) else 2
            found.append((sure, Dialect(delimiter, decimal, columns, first, encoding)))
    if not found:
        raise bad(
            path, "no rows of numbers found in its first lines",
            value=repr(lines[min(len(lines) - 1, 2)][:60]) if lines else "",
        )  # fmt: skip
    surest = max(sure for sure, _ in found)
    # More rows of numbers beat fewer; whole numbers leave the decimal sign open: a point.
    earliest = min(d.first for sure, d in found if sure == surest)
    best = [d for sure, d in found if sure == surest and d.first == earliest]
    if len({len(d.columns) for d in best}) > 1:
        ways = ", ".join(f"{len(d.columns)} columns by {d.delimiter!r}" for d in best)
        raise bad(
            path, "its rows can be read in more than one way", value=ways, hint="add a header"
        )
    chosen = best[0]
    for k, line in enumerate(lines[: chosen.first]):
        fields = _fields(line, chosen.delimiter)
        if len(fields) == len(chosen.columns) and _numeric(fields, chosen.decimal):
            wrong = lines[chosen.first - 1]
            raise bad(
                path, f"numbers begin at line {k + 1} and then a row is not numbers",
                line=chosen.first, value=repr(wrong[:60]),
            )  # fmt: skip
    return chosen


def _header(before: list[str], delimiter: str, width: int) -> tuple[tuple[Channel, ...], bool]:
    """Names and units from the lines above the numbers, and whether they were found."""
    rows = [_fields(line.lstrip("#% "), delimiter) for line in before if line.strip()]
    rows = [r for r in rows[-2:] if len(r) == width]
    if not rows:
        return tuple(Channel(f"column {k + 1}") for k in range(width)), False
    names, units = rows[0], rows[1] if len(rows) == 2 else [""] * width
    channels: list[Channel] = []
    for name, unit in zip(names, units, strict=True):
        match = _UNIT.match(name)
        if match and not unit:
            name, unit = match[1], next(g for g in match.groups()[1:] if g is not None)
        channels.append(Channel(name.strip(), unit.strip().strip("[]()")))
    return tuple(channels), True


def table(path: Path) -> Table:
    """Open a CSV recording."""
    form = dialect(path)
    kept = tuple(k for k, c in enumerate(form.columns) if c.name)  # a delimiter ends the row
    named = form.columns[0].name != "column 1"
    notes = () if named else ("the columns have no names in the file",)

    def rows(places: tuple[int, ...]) -> Iterator[FloatArray]:
        wanted = [kept[k] for k in places]
        return _spaced(path, form, wanted) if form.delimiter == " " else _arrow(path, form, wanted)

    return Table(columns=tuple(form.columns[k] for k in kept), rows=rows, notes=notes)


def _arrow(path: Path, form: Dialect, wanted: list[int]) -> Iterator[FloatArray]:
    import pyarrow as pa  # pyright: ignore[reportMissingTypeStubs]
    from pyarrow import csv as pacsv  # pyright: ignore[reportMissingTypeStubs]

    names = [f"c{k}" for k in range(len(form.columns))]
    short: list[str] = []

    def cut_short(row: Any) -> str:
        short.append(row.text)
        return "skip"

    try:
        reader: Any = pacsv.open_csv(
            path,
            read_options=pacsv.ReadOptions(
                skip_rows=form.first, column_names=names, block_size=1 << 23,
                encoding={"utf-8": "utf8"}.get(form.encoding, form.encoding),
            ),
            parse_options=pacsv.ParseOptions(
                delimiter=form.delimiter, invalid_row_handler=cut_short
            ),
            convert_options=pacsv.ConvertOptions(
                column_types=dict.fromkeys(names, pa.float64()), decimal_point=form.decimal,
                null_values=list(MISSING), include_columns=[names[k] for k in wanted],
            ),
        )  # fmt: skip
        for batch in reader:
            if short and not _ends_with(path, short[0], form.encoding):
                break
            yield np.stack([c.to_numpy(zero_copy_only=False) for c in batch.columns])
    except pa.ArrowInvalid as error:
        said = str(error).replace("CSV conversion error to double: ", "")
        raise bad(
            path, f"a value is not a number: {said}",
            hint=f"by its first lines the decimal sign is {form.decimal!r}",
        ) from error  # fmt: skip
    if short and not _ends_with(path, short[0], form.encoding):
        raise bad(
            path, f"a row does not have its {len(form.columns)} columns", value=repr(short[0][:60]),
            hint="repair or remove it; only a last row cut short is passed over",
        )  # fmt: skip


def _ends_with(path: Path, row: str, encoding: str) -> bool:
    """Whether a row is the last of its file."""
    tail = row.encode(encoding if encoding != "utf-16" else "utf-16-le")
    with path.open("rb") as file:
        file.seek(max(path.stat().st_size - len(tail) - 4, 0))
        return file.read().rstrip(b"\r\n\x00").endswith(tail.rstrip(b"\x00"))


def _spaced(path: Path, form: Dialect, wanted: list[int]) -> Iterator[FloatArray]:
    """Columns set apart by any number of spaces."""
    width = len(form.columns)
    with path.open(encoding=form.encoding) as file:
        for _ in range(form.first):
            next(file)
        row = form.first
        while lines := file.readlines(1 << 22):
            text = "".join(lines)
            fields = (text.replace(",", ".") if form.decimal == "," else text).split()
            if len(fields) != width * sum(1 for line in lines if line.strip()):
                k, line = next(
                    (k, s) for k, s in enumerate(lines) if len(s.split()) not in (0, width)
                )
                last = k == len(lines) - 1 and not file.readline()
                if not last:
                    raise bad(
                        path, f"a row does not have its {width} columns", line=row + k + 1,
                        value=repr(line[:60]),
                    )  # fmt: skip
                fields = fields[: -len(line.split())]
            try:
                numbers = np.array(["nan" if f in MISSING else f for f in fields], dtype=float)
            except ValueError as error:
                raise bad(path, f"a value is not a number: {error}", line=row + 1) from error
            row += len(lines)
            yield numbers.reshape(-1, width).T[wanted]
