"""CSV recordings of any dialect: delimiter, decimal sign, header and units are found out.

Found out, not guessed: a head that can be read in two ways is refused.
"""

import codecs
import csv
import re
from collections.abc import Iterator
from dataclasses import dataclass, replace
from datetime import date
from itertools import islice
from pathlib import Path
from typing import Any, TextIO

import numpy as np

from cardan.core.arrays import FloatArray
from cardan.core.errors import InvalidFileError
from cardan.physics.signals.recording import Channel
from cardan.readers.base import RecordingFileColumns, RecordingFormat, unreadable_recording_error
from cardan.readers.time_column import MidnightRollover

MISSING_VALUE_TEXTS = (
    "", "nan", "NaN", "NAN", "-nan", "NA", "N/A", "n/a", "#N/A", "null", "NULL", "None", "-", "--",
    "---", "----",
)  # fmt: skip
_NUMBER = {
    ".": re.compile(r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?"),
    ",": re.compile(r"[+-]?(\d+,?\d*|,\d+)([eE][+-]?\d+)?"),
}
_THOUSANDS_SIGNS = "'\N{RIGHT SINGLE QUOTATION MARK} \N{NO-BREAK SPACE}\N{NARROW NO-BREAK SPACE}"
_GROUPED_NUMBER = {
    point: re.compile(
        rf"[+-]?[1-9]\d{{0,2}}(?:[{other}{_THOUSANDS_SIGNS}]\d{{3}})+(?:[{point}]\d*)?"
    )
    for point, other in (".,", ",.")
}
"""A number whose thousands are set apart."""
_DELIMITERS = (";", "\t", ",", "|", " ")
_NAME_WITH_UNIT = re.compile(r"^(.*?)\s*(?:\[(.*)\]|\((.*)\)|\s/\s*(\S+))$")
_HEAD_BYTES = 1 << 16


@dataclass(frozen=True)
class CsvDialect:
    """How the text of a table is to be read."""

    delimiter: str
    decimal: str
    columns: tuple[Channel, ...]
    header_lines: int
    """Lines before the first row of numbers."""
    encoding: str
    text_columns: tuple[int, ...] = ()
    """Columns that hold no numbers."""
    time_column: int | None = None
    """The one of them that holds dates or times of day."""
    shows_decimal_sign: bool = True
    """Whether a number showed the decimal sign: else `1,234` may be either."""
    has_thousands_signs: bool = False
    """Whether some have their thousands set apart."""


def split_row(line: str, delimiter: str) -> list[str]:
    """Return the fields of a row, without the spaces around them."""
    if delimiter == " ":
        return line.split()
    rows = csv.reader([line], delimiter=delimiter, skipinitialspace=delimiter != "\t")
    return [f.strip() for f in next(rows, [])]


def is_number(field: str, decimal: str, *, grouped: bool = False) -> bool:
    """Whether a field is a number or says that there is none."""
    how = (_NUMBER, _GROUPED_NUMBER) if grouped else (_NUMBER,)
    return field in MISSING_VALUE_TEXTS or any(of[decimal].fullmatch(field) for of in how)


def _is_number_row(fields: list[str], decimal: str, *, grouped: bool = False) -> bool:
    said = [f for f in fields if f not in MISSING_VALUE_TEXTS]
    return bool(said) and all(is_number(f, decimal, grouped=grouped) for f in said)


def _first_row(
    lines: list[str], delimiter: str, decimal: str, *, grouped: bool
) -> tuple[int, int] | None:
    """First line from which all are numbers, and their count; None if there is none."""
    told = [(k, line) for k, line in enumerate(lines) if line.strip()]
    # What the last line is not, no row is the first of: most ways to read end here.
    if not told or not _is_number_row(split_row(told[-1][1], delimiter), decimal, grouped=grouped):
        return None
    first, width = None, 0
    for k, line in told:
        fields = split_row(line, delimiter)
        if not _is_number_row(fields, decimal, grouped=grouped):
            first = None
        elif first is None or len(fields) != width:
            # A last line cut short belongs to the rows before it.
            if first is not None and k == len(lines) - 1:
                continue
            first, width = k, len(fields)
    return None if first is None else (first, width)


_TIME_OF_DAY = re.compile(
    r"(?:(\d{4})[-/.](\d\d)[-/.](\d\d)[T ]|(\d\d)[-/.](\d\d)[-/.](\d{4})[T ])?"
    r"(?:(\d+) days? )?(\d\d?):(\d\d):(\d\d(?:[.,]\d+)?)(?:Z|[+-]\d\d:?\d\d)?"
)
"""A time of day, and perhaps the date before it, year first or day first, or days gone by."""


def _first_mixed_row(
    lines: list[str], delimiter: str, decimal: str, *, grouped: bool
) -> tuple[int, tuple[int, ...], int | None] | None:
    """First line of rows in which some columns are never numbers, those, and a clock of them.

    Only where names stand above: without, a row of words may be anything.
    """
    rows = [(k, split_row(line, delimiter)) for k, line in enumerate(lines) if line.strip()]
    if len(rows) < 3:
        return None
    width = len(rows[-2][1])
    last = [f for _, f in rows[-50:] if len(f) == width][:-1]
    if width < 2 or len(last) < 1:
        return None

    def numeric(field: str) -> bool:
        return is_number(field, decimal, grouped=grouped)

    texts = tuple(c for c in range(width) if not all(numeric(f[c]) for f in last))
    said = [
        c
        for c in range(width)
        if c not in texts and any(f[c] not in MISSING_VALUE_TEXTS for f in last)
    ]
    if not texts or not said:
        return None
    first: int | None = None
    for k, fields in reversed(rows):
        whole = len(fields) == width and all(numeric(fields[c]) for c in said)
        if not whole and not (k == rows[-1][0] and first is None):
            break
        first = k if whole else first
    clocks = [
        c
        for c in texts
        if all(_TIME_OF_DAY.fullmatch(f[c]) or f[c] in MISSING_VALUE_TEXTS for f in last)
    ]
    clock = clocks[0] if len(clocks) == 1 else None
    if first is None or first == rows[0][0]:
        return None
    return first, texts, clock


def _seconds_of_time(stamp: str) -> float:
    """Seconds of a time of day, from the first day of its era; nan where there is none."""
    match = _TIME_OF_DAY.fullmatch(stamp.strip())
    if match is None:
        return float("nan")
    year, month, day, day2, month2, year2, gone, hours, minutes, seconds = match.groups()
    days = int(gone or 0)
    if year or year2:
        days = date(int(year or year2), int(month or month2), int(day or day2)).toordinal()
    return days * 86400.0 + int(hours) * 3600 + int(minutes) * 60 + float(seconds.replace(",", "."))


def first_lines(path: Path) -> tuple[list[str], str]:
    """Return the whole lines of the first 64 kB of a text, and how its bytes are letters.

    Raises
    ------
    InvalidFileError
        If they are no text, or of one line that does not end.
    """
    with path.open("rb") as file:
        head = file.read(_HEAD_BYTES)
    encoding = _encoding(path, head)
    text = head.decode(encoding, errors="replace")
    if "\ufffd" in text[:-1]:  # the very last letter may have been cut in two by us
        encoding, text = "latin-1", head.decode("latin-1")
    lines = text.removeprefix("\ufeff").splitlines()
    if len(head) == _HEAD_BYTES and len(lines) < 2:
        raise unreadable_recording_error(
            path, f"its first line does not end within {_HEAD_BYTES >> 10} kB"
        )
    # What is cut by us, not by the writer, is no line.
    return (lines[:-1] if len(head) == _HEAD_BYTES else lines), encoding


def detect_dialect(path: Path) -> CsvDialect:
    """Find out how a table is written from its first 64 kB.

    Raises
    ------
    InvalidFileError
        If no rows of numbers are found, or they can be read in more than one way.
    """
    lines, encoding = first_lines(path)
    # Thousands set apart only where nothing is read without: `1,234` is a decimal comma's, too.
    found = list(_numeric_dialects(lines, encoding)) or list(
        _numeric_dialects(lines, encoding, grouped=True)
    )
    if not found:
        plain, found = (list(_mixed_dialects(lines, encoding, grouped=g)) for g in (False, True))
        if max((sure for sure, _ in found), default=0) <= max((s for s, _ in plain), default=0):
            found = plain
    if not found:
        raise unreadable_recording_error(
            path, "no rows of numbers found in its first lines",
            value=repr(lines[min(len(lines) - 1, 2)][:60]) if lines else "",
        )  # fmt: skip
    surest = max(sure for sure, _ in found)
    # More rows of numbers beat fewer; whole numbers leave the decimal sign open: a point.
    earliest = min(d.header_lines for sure, d in found if sure == surest)
    best = [d for sure, d in found if sure == surest and d.header_lines == earliest]
    if len({len(d.columns) for d in best}) > 1:
        ways = ", ".join(f"{len(d.columns)} columns by {d.delimiter!r}" for d in best)
        raise unreadable_recording_error(
            path, "its rows can be read in more than one way", value=ways, hint="add a header"
        )
    if best[0].has_thousands_signs and len({d.decimal for d in best}) > 1:
        raise unreadable_recording_error(
            path, "nothing says which sign sets its thousands apart, and which its decimals",
            hint="write it without thousands' signs",
        )  # fmt: skip
    chosen = best[0]
    if chosen.text_columns:
        return chosen
    for k, line in enumerate(lines[: chosen.header_lines]):
        fields = split_row(line, chosen.delimiter)
        if len(fields) == len(chosen.columns) and _is_number_row(fields, chosen.decimal):
            # What stands above the rows may hold as many numbers: the first row that is none, or
            # not as many, is where they end.
            at, wrong, cells = next(
                (n, row, cut)
                for n, row in enumerate(lines[k + 1 :], k + 2)
                if row.strip()
                and (
                    len(cut := split_row(row, chosen.delimiter)) != len(fields)
                    or not _is_number_row(cut, chosen.decimal)
                )
            )
            named = enumerate(cells, 1)
            cell = next((c for c in named if not is_number(c[1], chosen.decimal)), None)
            raise unreadable_recording_error(
                path, f"numbers begin at line {k + 1} and then a row is not numbers",
                line=at,
                value=f"{cell[1]!r} in column {cell[0]}" if cell else repr(wrong[:60]),
                hint=_allowed_values_hint(chosen),
            )  # fmt: skip
    fields = [split_row(line, chosen.delimiter) for line in lines[chosen.header_lines :]]
    if len(chosen.columns) > 1 and not any(row[0] for row in fields if row):
        # LabVIEW leaves the place of a time that it does not write.
        return replace(chosen, text_columns=(0,))
    return chosen


def _allowed_values_hint(form: CsvDialect) -> str:
    return (
        f"allowed are numbers with the decimal sign {form.decimal!r}, by its first lines, and for "
        "no value nothing, nan, NA, n/a, null, - or --"
    )


NUL_BYTES_MESSAGE = "NUL bytes, as a write that was cut off leaves them"


def _encoding(path: Path, head: bytes) -> str:
    """Return how the bytes of a text are letters, by the first of them."""
    if head.startswith((codecs.BOM_UTF32_LE, codecs.BOM_UTF32_BE)):
        raise unreadable_recording_error(
            path, "its letters are UTF-32", hint="write it as UTF-8 or UTF-16"
        )
    if head.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)):
        return "utf-16"
    if b"\x00" not in head:
        return "utf-8"
    even, odd = (half.count(0) / max(len(half), 1) for half in (head[::2], head[1::2]))
    if max(even, odd) > 0.9 and min(even, odd) < 0.1:
        return "utf-16-le" if odd > even else "utf-16-be"
    before = head[: head.index(0)]
    if len(before) > 1 and all(letter > 31 or letter in b"\t\r\n" for letter in before):
        raise unreadable_recording_error(
            path, NUL_BYTES_MESSAGE, line=before.count(b"\n") + 1, hint="repair or remove them"
        )
    raise unreadable_recording_error(
        path, "it is not text", hint="is the ending of its name right?"
    )


def _shows_decimal_sign(lines: list[str], delimiter: str, decimal: str) -> bool:
    """Whether a number of some rows shows its decimal sign."""
    return any(
        decimal in f and is_number(f, decimal) for s in lines for f in split_row(s, delimiter)
    )


def _delimiter_is_decimal_sign(delimiter: str, decimal: str, lines: list[str]) -> bool:
    """Whether a delimiter cannot be distinguished from a decimal sign: quoted numbers can."""
    return delimiter == decimal and not any(f'"{decimal}"' in line for line in lines)


def _numeric_dialects(
    lines: list[str], encoding: str, *, grouped: bool = False
) -> Iterator[tuple[int, CsvDialect]]:
    """Yield the ways to read rows of numbers, and how sure each is."""
    for delimiter in _DELIMITERS:
        for decimal in ".,":
            if _delimiter_is_decimal_sign(delimiter, decimal, lines) or (
                grouped and delimiter == " "
            ):
                continue
            start = _first_row(lines, delimiter, decimal, grouped=grouped)
            if start is None:
                continue
            first, width = start
            columns, named = header_channels(lines[:first], delimiter, width)
            # Names rarely hold commas; a line of names that does was meant to be cut there.
            sure = 0 if not named else 1 if any("," in c.name for c in columns) else 2
            yield (
                sure,
                CsvDialect(
                    delimiter,
                    decimal,
                    columns,
                    first,
                    encoding,
                    shows_decimal_sign=_shows_decimal_sign(lines[first:], delimiter, decimal),
                    has_thousands_signs=grouped,
                ),
            )


def _mixed_dialects(
    lines: list[str], encoding: str, *, grouped: bool
) -> Iterator[tuple[int, CsvDialect]]:
    """Yield the ways to read rows of which some columns are words or times."""
    for delimiter in (";", "\t", ",", "|"):
        for decimal in ".,":
            if _delimiter_is_decimal_sign(delimiter, decimal, lines):
                continue
            found = _first_mixed_row(lines, delimiter, decimal, grouped=grouped)
            if found is None:
                continue
            first, texts, clock = found
            width = len(split_row(lines[first], delimiter))
            columns, named = header_channels(lines[:first], delimiter, width)
            if named:
                sure = width - len(texts)
                yield (
                    sure,
                    CsvDialect(
                        delimiter,
                        decimal,
                        columns,
                        first,
                        encoding,
                        texts,
                        clock,
                        shows_decimal_sign=_shows_decimal_sign(lines[first:], delimiter, decimal),
                        has_thousands_signs=grouped,
                    ),
                )


_KNOWN_UNITS = {
    "", "-", "1", "s", "ms", "us", "µs", "min", "h", "hz", "khz", "rpm", "1/min", "u/min", "min-1",
    "1/s", "rad/s", "deg/s", "mpa", "n/mm2", "n/mm²", "kpa", "pa", "bar", "ksi", "um/m", "µm/m",
    "μm/m", "ue", "µε", "με", "ustrain", "microstrain", "m/m", "mm/m", "%", "nm", "n.m", "n·m",
    "knm", "kn.m", "kn·m", "n", "kn", "v", "mv", "mv/v", "v/v", "ma", "a", "g", "m/s2", "m/s²",
    "km/h", "kph", "mph", "m/s", "km", "m", "mm", "um", "µm", "deg", "°", "rad", "degc", "°c",
    "c", "k", "bool", "count",
}  # fmt: skip


class _LabelledRow(list[str]):
    """Fields of a row above the numbers that began with what they are: `SIGNAL`, `VERT_UNITS`."""


def _like_units(row: list[str], width: int) -> float:
    """Return the share of units among the fields of a row."""
    said = [f.strip().strip("[]()").lower() for f in row]
    return sum(f in _KNOWN_UNITS for f in said) / width if any(said) else 0.0


def _without_label_or_comment(row: list[str], rows: list[list[str]], width: int) -> list[str]:
    """Return a row above the numbers without the one field that it has more than these.

    The first, where rows of labels stand there, of which one holds units; or else the last, as
    LabVIEW's `Comment`.
    """
    if len(row) != width + 1 or width < 2:
        return row
    alike = [r for r in rows if len(r) == width + 1]
    if any(_like_units(r[1:], width) >= 0.5 for r in alike) and all(r[0] for r in alike):
        return _LabelledRow(row[1:])
    return row[:-1]


def header_channels(
    before: list[str], delimiter: str, width: int
) -> tuple[tuple[Channel, ...], bool]:
    """Names and units from the lines above the numbers, and whether they were found.

    Names stand first, below a title perhaps; which of the lines below holds units is seen by
    what it says, others (descriptions, channel numbers, dates) are ignored.
    """
    rows = [split_row(line.lstrip("#% "), delimiter) for line in before if line.strip()]
    rows = [_without_label_or_comment(row, rows, width) for row in rows]
    # A word alone (`DATA`) may stand between the names and the rows.
    while rows and len(rows[-1]) == 1 < width and any(len(r) == width for r in rows[:-1]):
        rows.pop()
    own: list[list[str]] = []
    for row in reversed(rows):
        if len(row) != width:
            break
        own.insert(0, row)
    if not own:
        own = [r for r in rows[-2:] if len(r) == width]
    if not own:
        return tuple(Channel(f"column {k + 1}") for k in range(width)), False
    labelled = [r for r in own if isinstance(r, _LabelledRow)]
    if labelled:
        own = [*(r for r in labelled if not _like_units(r, width)), *labelled, *own]
        units_first = [r for r in labelled if _like_units(r, width) >= 0.5]
        own = [own[0], *units_first[:1]]

    # A title over the first column names none of the others.
    while len(own) > 1 and 2 * sum(map(bool, own[0])) <= min(width, sum(map(bool, own[1]))):
        own.pop(0)

    names, units = own[0], [""] * width
    below = max(own[1:], key=lambda row: _like_units(row, width), default=None)
    if below is not None and (_like_units(below, width) >= 0.5 or len(own) == 2):
        units = below
    channels: list[Channel] = []
    for name, unit in zip(names, units, strict=True):
        match = _NAME_WITH_UNIT.match(name)
        if match and not unit:
            name, unit = match[1], next(g for g in match.groups()[1:] if g is not None)
        channels.append(Channel(name.strip(), unit.strip().strip("[]()")))
    return tuple(channels), True


def open_csv(path: Path, _group: str = "") -> RecordingFileColumns:
    """Open a CSV recording."""
    form = detect_dialect(path)
    # A delimiter ends the row; words have no samples.
    left = [k for k in form.text_columns if k != form.time_column]
    named = any(c.name != f"column {k + 1}" for k, c in enumerate(form.columns))
    # A first column without a name is an index, as pandas writes it.
    if not form.columns[0].name and 0 not in left and len(form.columns) > 1:
        form = replace(form, columns=(Channel("column 1"), *form.columns[1:]))
    kept = tuple(k for k, c in enumerate(form.columns) if c.name and k not in left)
    note = "the columns have no names in the file"
    notes = () if named else (note,)
    if left:
        note = f"not numbers, left out: {', '.join(form.columns[k].name for k in left)}"
        notes = (*notes, note)
    columns = list(form.columns)
    clock = None if form.time_column is None else kept.index(form.time_column)
    if form.time_column is not None:
        columns[form.time_column] = replace(columns[form.time_column], unit="s")

    def rows(places: tuple[int, ...]) -> Iterator[FloatArray]:
        return read_rows(path, form, [kept[k] for k in places])

    return RecordingFileColumns(
        columns=tuple(columns[k] for k in kept), read_rows=rows, notes=notes, clock=clock
    )


def read_rows(path: Path, form: CsvDialect, wanted: list[int]) -> Iterator[FloatArray]:
    """Yield some columns (k, n) of the rows of a table."""
    if form.delimiter == " ":
        return _read_space_separated(path, form, wanted)
    return _read_fast_then_careful(path, form, wanted)


def _read_fast_then_careful(
    path: Path, form: CsvDialect, wanted: list[int]
) -> Iterator[FloatArray]:
    """Yield the rows of a file: fast, and where that does not go on, with care."""
    given = 0
    if not form.has_thousands_signs:
        try:
            for part in _read_with_arrow(path, form, wanted):
                yield part
                given += 1
        except InvalidFileError:
            pass
        else:
            return
    yield from islice(_read_with_arrow(path, form, wanted, careful=True), given, None)


def _read_with_arrow(
    path: Path, form: CsvDialect, wanted: list[int], *, careful: bool = False
) -> Iterator[FloatArray]:
    """Yield the rows of a file.

    With care a last row cut short is passed over, thousands may be set apart, and what is no
    number is reported by its place. That is called from a thread of Arrow's: one that still ran as
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
                skip_rows=form.header_lines, column_names=names,
                # By threads of its own some forty pieces are under way, and what these keep made
                # a day take up to 80 MB more. A row has to lie within a piece.
                use_threads=False, block_size=4 * _HEAD_BYTES,
                encoding={"utf-8": "utf8"}.get(form.encoding, form.encoding),
            ),
            parse_options=pacsv.ParseOptions(
                delimiter=form.delimiter,
                invalid_row_handler=cut_short if careful else None,
            ),
            convert_options=pacsv.ConvertOptions(
                column_types={
                    n: pa.string() if careful or k in form.text_columns else pa.float64()
                    for k, n in enumerate(names)
                }, decimal_point=form.decimal,
                null_values=list(MISSING_VALUE_TEXTS), include_columns=[names[k] for k in wanted],
                strings_can_be_null=True,
            ),
        )  # fmt: skip
        row, days = 0, MidnightRollover()
        for batch in reader:
            if short and not _ends_with(path, short[0], form.encoding):
                break
            yield np.stack(
                [
                    days.add_days(np.array([_seconds_of_time(str(v)) for v in c.to_pylist()]))
                    if k in form.text_columns
                    else _numbers(path, form, c, k, row)
                    for k, c in zip(wanted, batch.columns, strict=True)
                ]
            )
            row += batch.num_rows
    except pa.ArrowInvalid as error:
        raise unreadable_recording_error(path, str(error)) from error
    if short and not _ends_with(path, short[0], form.encoding):
        raise unreadable_recording_error(
            path, f"a row does not have its {len(form.columns)} columns", value=repr(short[0][:60]),
            hint="repair or remove it; only a last row cut short is passed over",
        )  # fmt: skip


def _numbers(path: Path, form: CsvDialect, column: Any, k: int, row: int) -> FloatArray:
    """Return a column as numbers (n,), if it is not that yet; refuse what is none by its place."""
    import pyarrow as pa  # pyright: ignore[reportMissingTypeStubs]
    from pyarrow import compute  # pyright: ignore[reportMissingTypeStubs]

    pc: Any = compute
    if pa.types.is_floating(column.type):
        x = column.to_numpy(zero_copy_only=False)
        if np.isinf(x).any():
            raise unreadable_recording_error(path, "a value is infinite")  # where, with care
        return x
    text = pc.utf8_trim_whitespace(column)
    # What is set apart once, and by what may be a decimal sign, is a thousand only where the first
    # lines show another one.
    apart = pc.match_substring_regex(text, f"^(?:{_GROUPED_NUMBER[form.decimal].pattern})$")
    if not form.shows_decimal_sign:
        apart = pc.and_(apart, pc.match_substring_regex(text, f"[{_THOUSANDS_SIGNS}]|[.,].*[.,]"))
    other = "," if form.decimal == "." else "."
    whole = pc.replace_substring_regex(text, pattern=f"[{other}{_THOUSANDS_SIGNS}]", replacement="")
    text = pc.if_else(apart, whole, text)
    good = pc.match_substring_regex(text, f"^(?:{_NUMBER[form.decimal].pattern})$")
    wrong = np.flatnonzero(~pc.fill_null(good, fill_value=True).to_numpy(zero_copy_only=False))
    if wrong.size:
        at = int(wrong[0])
        line = _line_of_row(path, form, row + at)
        raise _not_a_number_error(path, form, form.columns[k].name, line, column[at].as_py())
    return pc.cast(pc.replace_substring(text, ",", "."), pa.float64()).to_numpy(
        zero_copy_only=False
    )


def _not_a_number_error(
    path: Path, form: CsvDialect, column: str, line: int, cell: str
) -> InvalidFileError:
    if "\x00" in cell:
        return unreadable_recording_error(
            path, NUL_BYTES_MESSAGE, line=line, hint="repair or remove them"
        )
    if _GROUPED_NUMBER[form.decimal].fullmatch(cell):
        return unreadable_recording_error(
            path, f"column {column!r} holds a number that may be read in two ways", line=line,
            value=repr(cell), hint="write thousands without a sign: none shows which is decimal",
        )  # fmt: skip
    return unreadable_recording_error(
        path, f"column {column!r} holds no number", line=line, value=repr(cell[:60]),
        hint=_allowed_values_hint(form),
    )  # fmt: skip


def _line_of_row(path: Path, form: CsvDialect, row: int) -> int:
    """Return the line, from 1, that a row of numbers stands in: empty lines are none."""
    with path.open(encoding=form.encoding, errors="replace") as file:
        lines = (
            n for n, line in enumerate(file, 1) if n > form.header_lines and line.strip("\r\n")
        )
        return next(islice(lines, row, None), 0)


def _ends_with(path: Path, row: str, encoding: str) -> bool:
    """Whether a row is the last of its file."""
    tail = row.encode(encoding if encoding != "utf-16" else "utf-16-le")
    with path.open("rb") as file:
        file.seek(max(path.stat().st_size - len(tail) - 4, 0))
        return file.read().rstrip(b"\r\n\x00").endswith(tail.rstrip(b"\x00"))


MAX_LINE_CHARACTERS = 1 << 22
"""Letters of the longest line."""


def _next_lines(path: Path, file: TextIO) -> list[str]:
    """Return the next lines, some megabytes of them, and refuse one without an end."""
    lines: list[str] = []
    taken = 0
    while taken < MAX_LINE_CHARACTERS and (line := file.readline(MAX_LINE_CHARACTERS)):
        if len(line) == MAX_LINE_CHARACTERS:
            raise unreadable_recording_error(
                path, f"a line does not end within {MAX_LINE_CHARACTERS >> 20} MB"
            )
        lines.append(line)
        taken += len(line)
    return lines


def _read_space_separated(path: Path, form: CsvDialect, wanted: list[int]) -> Iterator[FloatArray]:
    """Columns set apart by any number of spaces."""
    width = len(form.columns)
    with path.open(encoding=form.encoding) as file:
        for _ in range(form.header_lines):
            next(file)
        row = form.header_lines
        while lines := _next_lines(path, file):
            text = "".join(lines)
            fields = (text.replace(",", ".") if form.decimal == "," else text).split()
            if len(fields) != width * sum(1 for line in lines if line.strip()):
                k, line = next(
                    (k, s) for k, s in enumerate(lines) if len(s.split()) not in (0, width)
                )
                last = k == len(lines) - 1 and not file.readline()
                if not last:
                    raise unreadable_recording_error(
                        path, f"a row does not have its {width} columns", line=row + k + 1,
                        value=repr(line[:60]),
                    )  # fmt: skip
                fields = fields[: -len(line.split())]
            numbers = _to_numbers(fields)
            if numbers is None:
                raise _first_bad_cell_error(path, form, lines, row)
            row += len(lines)
            yield numbers.reshape(-1, width).T[wanted]


def _to_numbers(fields: list[str]) -> FloatArray | None:
    """Return fields as numbers (n,); None where one is none."""
    try:
        x = np.array(["nan" if f in MISSING_VALUE_TEXTS else f for f in fields], dtype=float)
    except ValueError:
        return None
    return None if np.isinf(x).any() else x


def _first_bad_cell_error(
    path: Path, form: CsvDialect, lines: list[str], row: int
) -> InvalidFileError:
    """Return the error of the first field of some lines, `row` lines into a file, that is none."""
    cells = (
        (n, name.name, field)
        for n, line in enumerate(lines, row + 1)
        for name, field in zip(form.columns, line.split(), strict=False)
        if not is_number(field, form.decimal)
    )
    n, name, field = next(cells)
    return _not_a_number_error(path, form, name, n, field)


FORMAT = RecordingFormat(
    name="CSV", extensions=(".csv", ".txt", ".tsv", ".asc", ".dat"), open_columns=open_csv
)
