"""CSV recordings of any dialect: delimiter, decimal sign, header and units are found out.

Found out, not guessed: a head that can be read in two ways is refused.
"""

import codecs
import csv
import re
from collections.abc import Iterator
from dataclasses import dataclass
from datetime import date
from itertools import islice
from pathlib import Path
from typing import Any, TextIO

import numpy as np

from cardan.base.arrays import FloatArray
from cardan.base.errors import BadFile
from cardan.fatigue.recording import Channel
from cardan.files.recordings import Days, Table, bad, ticks

MISSING = (
    "", "nan", "NaN", "NAN", "-nan", "NA", "N/A", "n/a", "#N/A", "null", "NULL", "None", "-", "--",
    "---", "----",
)  # fmt: skip
_NUMBER = {
    ".": re.compile(r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?"),
    ",": re.compile(r"[+-]?(\d+,?\d*|,\d+)([eE][+-]?\d+)?"),
}
_SIGNS = "'\N{RIGHT SINGLE QUOTATION MARK} \N{NO-BREAK SPACE}\N{NARROW NO-BREAK SPACE}"
_GROUPED = {
    point: re.compile(rf"[+-]?[1-9]\d{{0,2}}(?:[{other}{_SIGNS}]\d{{3}})+(?:[{point}]\d*)?")
    for point, other in (".,", ",.")
}
"""A number whose thousands are set apart."""
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
    texts: tuple[int, ...] = ()
    """Columns that hold no numbers."""
    clock: int | None = None
    """The one of them that holds dates or times of day."""
    signed: bool = True
    """Whether a number showed the decimal sign: else `1,234` may be either."""
    grouped: bool = False
    """Whether some have their thousands set apart."""


def _fields(line: str, delimiter: str) -> list[str]:
    if delimiter == " ":
        return line.split()
    return [f.strip() for f in next(csv.reader([line], delimiter=delimiter), [])]


def _is_number(field: str, decimal: str, *, grouped: bool = False) -> bool:
    """Whether a field is a number or says that there is none."""
    how = (_NUMBER, _GROUPED) if grouped else (_NUMBER,)
    return field in MISSING or any(of[decimal].fullmatch(field) for of in how)


def _numeric(fields: list[str], decimal: str, *, grouped: bool = False) -> bool:
    said = [f for f in fields if f not in MISSING]
    return bool(said) and all(_is_number(f, decimal, grouped=grouped) for f in said)


def _first_row(
    lines: list[str], delimiter: str, decimal: str, *, grouped: bool
) -> tuple[int, int] | None:
    """First line from which all are numbers, and their count; None if there is none."""
    told = [(k, line) for k, line in enumerate(lines) if line.strip()]
    # What the last line is not, no row is the first of: most ways to read end here.
    if not told or not _numeric(_fields(told[-1][1], delimiter), decimal, grouped=grouped):
        return None
    first, width = None, 0
    for k, line in told:
        fields = _fields(line, delimiter)
        if not _numeric(fields, decimal, grouped=grouped):
            first = None
        elif first is None or len(fields) != width:
            # A last line cut short belongs to the rows before it.
            if first is not None and k == len(lines) - 1:
                continue
            first, width = k, len(fields)
    return None if first is None else (first, width)


_STAMP = re.compile(
    r"(?:(\d{4})[-/.](\d\d)[-/.](\d\d)[T ]|(\d\d)[-/.](\d\d)[-/.](\d{4})[T ])?"
    r"(\d\d?):(\d\d):(\d\d(?:[.,]\d+)?)(?:Z|[+-]\d\d:?\d\d)?"
)
"""A time of day, and perhaps the date before it: year first, or day first."""


def _mixed_row(
    lines: list[str], delimiter: str, decimal: str, *, grouped: bool
) -> tuple[int, tuple[int, ...], int | None] | None:
    """First line of rows in which some columns are never numbers, those, and a clock of them.

    Only where names stand above: without, a row of words may be anything.
    """
    rows = [(k, _fields(line, delimiter)) for k, line in enumerate(lines) if line.strip()]
    if len(rows) < 3:
        return None
    width = len(rows[-2][1])
    last = [f for _, f in rows[-50:] if len(f) == width][:-1]
    if width < 2 or len(last) < 1:
        return None

    def numeric(field: str) -> bool:
        return _is_number(field, decimal, grouped=grouped)

    texts = tuple(c for c in range(width) if not all(numeric(f[c]) for f in last))
    said = [c for c in range(width) if c not in texts and any(f[c] not in MISSING for f in last)]
    if not texts or not said:
        return None
    first: int | None = None
    for k, fields in reversed(rows):
        whole = len(fields) == width and all(numeric(fields[c]) for c in said)
        if not whole and not (k == rows[-1][0] and first is None):
            break
        first = k if whole else first
    clocks = [c for c in texts if all(_STAMP.fullmatch(f[c]) or f[c] in MISSING for f in last)]
    clock = clocks[0] if len(clocks) == 1 else None
    if first is None or first == rows[0][0]:
        return None
    return first, texts, clock


def _seconds(stamp: str) -> float:
    """Seconds of a time of day, from the first day of its era; nan where there is none."""
    match = _STAMP.fullmatch(stamp.strip())
    if match is None:
        return float("nan")
    year, month, day, day2, month2, year2, hours, minutes, seconds = match.groups()
    days = 0
    if year or year2:
        days = date(int(year or year2), int(month or month2), int(day or day2)).toordinal()
    return days * 86400.0 + int(hours) * 3600 + int(minutes) * 60 + float(seconds.replace(",", "."))


def dialect(path: Path) -> Dialect:
    """Find out how a table is written from its first 64 kB.

    Raises
    ------
    BadFile
        If no rows of numbers are found, or they can be read in more than one way.
    """
    with path.open("rb") as file:
        head = file.read(_HEAD)
    encoding = _encoding(path, head)
    text = head.decode(encoding, errors="replace")
    if "\ufffd" in text[:-1]:  # the very last letter may have been cut in two by us
        encoding, text = "latin-1", head.decode("latin-1")
    lines = text.removeprefix("\ufeff").splitlines()
    if len(head) == _HEAD and len(lines) < 2:
        raise bad(path, f"its first line does not end within {_HEAD >> 10} kB")
    if len(head) == _HEAD:
        lines = lines[:-1]  # cut by us, not by the writer
    # Thousands set apart only where nothing is read without: `1,234` is a decimal comma's, too.
    found = list(_of_numbers(lines, encoding)) or list(_of_numbers(lines, encoding, grouped=True))
    if not found:
        plain, found = (list(_with_texts(lines, encoding, grouped=g)) for g in (False, True))
        if max((sure for sure, _ in found), default=0) <= max((s for s, _ in plain), default=0):
            found = plain
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
    if best[0].grouped and len({d.decimal for d in best}) > 1:
        raise bad(
            path, "nothing says which sign sets its thousands apart, and which its decimals",
            hint="write it without thousands' signs",
        )  # fmt: skip
    chosen = best[0]
    if chosen.texts:
        return chosen
    for k, line in enumerate(lines[: chosen.first]):
        fields = _fields(line, chosen.delimiter)
        if len(fields) == len(chosen.columns) and _numeric(fields, chosen.decimal):
            # What stands above the rows may hold as many numbers: the first row that is none, or
            # not as many, is where they end.
            at, wrong, cells = next(
                (n, row, cut)
                for n, row in enumerate(lines[k + 1 :], k + 2)
                if row.strip()
                and (
                    len(cut := _fields(row, chosen.delimiter)) != len(fields)
                    or not _numeric(cut, chosen.decimal)
                )
            )
            named = enumerate(cells, 1)
            cell = next((c for c in named if not _is_number(c[1], chosen.decimal)), None)
            raise bad(
                path, f"numbers begin at line {k + 1} and then a row is not numbers",
                line=at,
                value=f"{cell[1]!r} in column {cell[0]}" if cell else repr(wrong[:60]),
                hint=_allowed(chosen),
            )  # fmt: skip
    return chosen


def _allowed(form: Dialect) -> str:
    return (
        f"allowed are numbers with the decimal sign {form.decimal!r}, by its first lines, and for "
        "no value nothing, nan, NA, n/a, null, - or --"
    )


NUL = "NUL bytes, as a write that was cut off leaves them"


def _encoding(path: Path, head: bytes) -> str:
    """Return how the bytes of a text are letters, by the first of them."""
    if head.startswith((codecs.BOM_UTF32_LE, codecs.BOM_UTF32_BE)):
        raise bad(path, "its letters are UTF-32", hint="write it as UTF-8 or UTF-16")
    if head.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)):
        return "utf-16"
    if b"\x00" not in head:
        return "utf-8"
    even, odd = (half.count(0) / max(len(half), 1) for half in (head[::2], head[1::2]))
    if max(even, odd) > 0.9 and min(even, odd) < 0.1:
        return "utf-16-le" if odd > even else "utf-16-be"
    before = head[: head.index(0)]
    if len(before) > 1 and all(letter > 31 or letter in b"\t\r\n" for letter in before):
        raise bad(path, NUL, line=before.count(b"\n") + 1, hint="repair or remove them")
    raise bad(path, "it is not text", hint="is the ending of its name right?")


def _shows(lines: list[str], delimiter: str, decimal: str) -> bool:
    """Whether a number of some rows shows its decimal sign."""
    return any(
        decimal in f and _is_number(f, decimal) for s in lines for f in _fields(s, delimiter)
    )


def _mixed_up(delimiter: str, decimal: str, lines: list[str]) -> bool:
    """Whether nothing tells a delimiter from a decimal sign: it does if numbers are in quotes."""
    return delimiter == decimal and not any(f'"{decimal}"' in line for line in lines)


def _of_numbers(
    lines: list[str], encoding: str, *, grouped: bool = False
) -> Iterator[tuple[int, Dialect]]:
    """Yield the ways to read rows of numbers, and how sure each is."""
    for delimiter in _DELIMITERS:
        for decimal in ".,":
            if _mixed_up(delimiter, decimal, lines) or (grouped and delimiter == " "):
                continue
            start = _first_row(lines, delimiter, decimal, grouped=grouped)
            if start is None:
                continue
            first, width = start
            columns, named = _header(lines[:first], delimiter, width)
            # Names rarely hold commas; a line of names that does was meant to be cut there.
            sure = 0 if not named else 1 if any("," in c.name for c in columns) else 2
            yield sure, Dialect(
                delimiter, decimal, columns, first, encoding,
                signed=_shows(lines[first:], delimiter, decimal), grouped=grouped,
            )  # fmt: skip


def _with_texts(lines: list[str], encoding: str, *, grouped: bool) -> Iterator[tuple[int, Dialect]]:
    """Yield the ways to read rows of which some columns are words or times."""
    for delimiter in (";", "\t", ",", "|"):
        for decimal in ".,":
            if _mixed_up(delimiter, decimal, lines):
                continue
            found = _mixed_row(lines, delimiter, decimal, grouped=grouped)
            if found is None:
                continue
            first, texts, clock = found
            width = len(_fields(lines[first], delimiter))
            columns, named = _header(lines[:first], delimiter, width)
            if named:
                sure = width - len(texts)
                yield sure, Dialect(
                    delimiter, decimal, columns, first, encoding, texts, clock,
                    signed=_shows(lines[first:], delimiter, decimal), grouped=grouped,
                )  # fmt: skip


_UNITS = {
    "", "-", "1", "s", "ms", "us", "µs", "min", "h", "hz", "khz", "rpm", "1/min", "u/min", "min-1",
    "1/s", "rad/s", "deg/s", "mpa", "n/mm2", "n/mm²", "kpa", "pa", "bar", "ksi", "um/m", "µm/m",
    "μm/m", "ue", "µε", "με", "ustrain", "microstrain", "m/m", "mm/m", "%", "nm", "n.m", "n·m",
    "knm", "kn.m", "kn·m", "n", "kn", "v", "mv", "mv/v", "v/v", "ma", "a", "g", "m/s2", "m/s²",
    "km/h", "kph", "mph", "m/s", "km", "m", "mm", "um", "µm", "deg", "°", "rad", "degc", "°c",
    "c", "k", "bool", "count",
}  # fmt: skip


def _header(before: list[str], delimiter: str, width: int) -> tuple[tuple[Channel, ...], bool]:
    """Names and units from the lines above the numbers, and whether they were found.

    Names stand first, below a title perhaps; which of the lines below holds units is seen by
    what it says, others (descriptions, channel numbers, dates) are nobody's.
    """
    rows = [_fields(line.lstrip("#% "), delimiter) for line in before if line.strip()]
    own: list[list[str]] = []
    for row in reversed(rows):
        if len(row) != width:
            break
        own.insert(0, row)
    if not own:
        own = [r for r in rows[-2:] if len(r) == width]
    if not own:
        return tuple(Channel(f"column {k + 1}") for k in range(width)), False

    # A title over the first column names none of the others.
    while len(own) > 1 and 2 * sum(map(bool, own[0])) <= min(width, sum(map(bool, own[1]))):
        own.pop(0)

    def like_units(row: list[str]) -> float:
        said = [f.strip().strip("[]()").lower() for f in row]
        return sum(f in _UNITS for f in said) / width if any(said) else 0.0

    names, units = own[0], [""] * width
    below = max(own[1:], key=like_units, default=None)
    if below is not None and (like_units(below) >= 0.5 or len(own) == 2):
        units = below
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
    # A delimiter ends the row; words have no samples.
    left = [k for k in form.texts if k != form.clock]
    kept = tuple(k for k, c in enumerate(form.columns) if c.name and k not in left)
    named = form.columns[0].name != "column 1"
    note = "the columns have no names in the file"
    notes = () if named else (note,)
    if left:
        note = f"not numbers, left out: {', '.join(form.columns[k].name for k in left)}"
        notes = (*notes, note)
    columns = list(form.columns)
    if form.clock is not None:
        # The only one is the clock, whatever its name; beside a time it goes by its own.
        own = columns[form.clock]
        beside = any(ticks(c) for c in columns if c is not own)
        columns[form.clock] = Channel(own.name if beside else "time", "s")

    def rows(places: tuple[int, ...]) -> Iterator[FloatArray]:
        wanted = [kept[k] for k in places]
        return _spaced(path, form, wanted) if form.delimiter == " " else _arrow(path, form, wanted)

    return Table(columns=tuple(columns[k] for k in kept), rows=rows, notes=notes)


def _arrow(path: Path, form: Dialect, wanted: list[int]) -> Iterator[FloatArray]:
    """Yield the rows of a file: fast, and where that does not go on, with care."""
    given = 0
    if not form.grouped:
        try:
            for part in _read(path, form, wanted):
                yield part
                given += 1
        except BadFile:
            pass
        else:
            return
    yield from islice(_read(path, form, wanted, careful=True), given, None)


def _read(
    path: Path, form: Dialect, wanted: list[int], *, careful: bool = False
) -> Iterator[FloatArray]:
    """Yield the rows of a file.

    With care a last row cut short is passed over, thousands may be set apart, and what is no
    number is told by its place. That is called from a thread of Arrow's: one that still ran as
    Python ended took the whole process with it.
    """
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
                skip_rows=form.first, column_names=names,
                # By threads of its own some forty pieces are under way, and what these keep made
                # a day take up to 80 MB more. A row has to lie within a piece.
                use_threads=False, block_size=4 * _HEAD,
                encoding={"utf-8": "utf8"}.get(form.encoding, form.encoding),
            ),
            parse_options=pacsv.ParseOptions(
                delimiter=form.delimiter,
                invalid_row_handler=cut_short if careful else None,
            ),
            convert_options=pacsv.ConvertOptions(
                column_types={
                    n: pa.string() if careful or k in form.texts else pa.float64()
                    for k, n in enumerate(names)
                }, decimal_point=form.decimal,
                null_values=list(MISSING), include_columns=[names[k] for k in wanted],
                strings_can_be_null=True,
            ),
        )  # fmt: skip
        row, days = 0, Days()
        for batch in reader:
            if short and not _ends_with(path, short[0], form.encoding):
                break
            yield np.stack(
                [
                    days.on(np.array([_seconds(str(v)) for v in c.to_pylist()]))
                    if k in form.texts
                    else _numbers(path, form, c, k, row)
                    for k, c in zip(wanted, batch.columns, strict=True)
                ]
            )
            row += batch.num_rows
    except pa.ArrowInvalid as error:
        raise bad(path, str(error)) from error
    if short and not _ends_with(path, short[0], form.encoding):
        raise bad(
            path, f"a row does not have its {len(form.columns)} columns", value=repr(short[0][:60]),
            hint="repair or remove it; only a last row cut short is passed over",
        )  # fmt: skip


def _numbers(path: Path, form: Dialect, column: Any, k: int, row: int) -> FloatArray:
    """Return a column as numbers (n,), if it is not that yet; refuse what is none by its place."""
    import pyarrow as pa  # pyright: ignore[reportMissingTypeStubs]
    from pyarrow import compute  # pyright: ignore[reportMissingTypeStubs]

    pc: Any = compute
    if pa.types.is_floating(column.type):
        x = column.to_numpy(zero_copy_only=False)
        if np.isinf(x).any():
            raise bad(path, "a value is infinite")  # where, with care
        return x
    text = pc.utf8_trim_whitespace(column)
    # What is set apart once, and by what may be a decimal sign, is a thousand only where the first
    # lines show another one.
    apart = pc.match_substring_regex(text, f"^(?:{_GROUPED[form.decimal].pattern})$")
    if not form.signed:
        apart = pc.and_(apart, pc.match_substring_regex(text, f"[{_SIGNS}]|[.,].*[.,]"))
    other = "," if form.decimal == "." else "."
    whole = pc.replace_substring_regex(text, pattern=f"[{other}{_SIGNS}]", replacement="")
    text = pc.if_else(apart, whole, text)
    good = pc.match_substring_regex(text, f"^(?:{_NUMBER[form.decimal].pattern})$")
    wrong = np.flatnonzero(~pc.fill_null(good, fill_value=True).to_numpy(zero_copy_only=False))
    if wrong.size:
        at = int(wrong[0])
        line = _line(path, form, row + at)
        raise _no_number(path, form, form.columns[k].name, line, column[at].as_py())
    return pc.cast(pc.replace_substring(text, ",", "."), pa.float64()).to_numpy(
        zero_copy_only=False
    )


def _no_number(path: Path, form: Dialect, column: str, line: int, cell: str) -> BadFile:
    if "\x00" in cell:
        return bad(path, NUL, line=line, hint="repair or remove them")
    if _GROUPED[form.decimal].fullmatch(cell):
        return bad(
            path, f"column {column!r} holds a number that may be read in two ways", line=line,
            value=repr(cell), hint="write thousands without a sign: none shows which is decimal",
        )  # fmt: skip
    return bad(
        path, f"column {column!r} holds no number", line=line, value=repr(cell[:60]),
        hint=_allowed(form),
    )  # fmt: skip


def _line(path: Path, form: Dialect, row: int) -> int:
    """Return the line, from 1, that a row of numbers stands in: empty lines are none."""
    with path.open(encoding=form.encoding, errors="replace") as file:
        lines = (n for n, line in enumerate(file, 1) if n > form.first and line.strip("\r\n"))
        return next(islice(lines, row, None), 0)


def _ends_with(path: Path, row: str, encoding: str) -> bool:
    """Whether a row is the last of its file."""
    tail = row.encode(encoding if encoding != "utf-16" else "utf-16-le")
    with path.open("rb") as file:
        file.seek(max(path.stat().st_size - len(tail) - 4, 0))
        return file.read().rstrip(b"\r\n\x00").endswith(tail.rstrip(b"\x00"))


LONGEST = 1 << 22
"""Letters of the longest line."""


def _lines(path: Path, file: TextIO) -> list[str]:
    """Return the next lines, some megabytes of them, and refuse one without an end."""
    lines: list[str] = []
    taken = 0
    while taken < LONGEST and (line := file.readline(LONGEST)):
        if len(line) == LONGEST:
            raise bad(path, f"a line does not end within {LONGEST >> 20} MB")
        lines.append(line)
        taken += len(line)
    return lines


def _spaced(path: Path, form: Dialect, wanted: list[int]) -> Iterator[FloatArray]:
    """Columns set apart by any number of spaces."""
    width = len(form.columns)
    with path.open(encoding=form.encoding) as file:
        for _ in range(form.first):
            next(file)
        row = form.first
        while lines := _lines(path, file):
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
            numbers = _spelled(fields)
            if numbers is None:
                raise _unspelled(path, form, lines, row)
            row += len(lines)
            yield numbers.reshape(-1, width).T[wanted]


def _spelled(fields: list[str]) -> FloatArray | None:
    """Return fields as numbers (n,); None where one is none."""
    try:
        x = np.array(["nan" if f in MISSING else f for f in fields], dtype=float)
    except ValueError:
        return None
    return None if np.isinf(x).any() else x


def _unspelled(path: Path, form: Dialect, lines: list[str], row: int) -> BadFile:
    """Return the error of the first field of some lines, `row` lines into a file, that is none."""
    cells = (
        (n, name.name, field)
        for n, line in enumerate(lines, row + 1)
        for name, field in zip(form.columns, line.split(), strict=False)
        if not _is_number(field, form.decimal)
    )
    n, name, field = next(cells)
    return _no_number(path, form, name, n, field)
