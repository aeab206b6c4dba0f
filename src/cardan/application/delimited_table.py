"""Tables as spreadsheets copy and save them: cells, the decimal sign and units of length."""

import csv
import re
from collections.abc import Mapping

from cardan.application.paste_import import interpretations_of_ambiguous_number
from cardan.core.errors import FileIssue, InvalidFileError
from cardan.core.units import Metre, ft, inch, m, mm

LENGTH_UNITS: Mapping[str, Metre] = {"mm": mm, "cm": 10 * mm, "m": m, "in": inch, "ft": ft}
"""Units of length that a heading may name, in lower case, m."""

_NAMED_SIGN = re.compile(r"sep=([\t;,|])", re.IGNORECASE)


def divided_rows(text: str, source: str) -> list[tuple[int, list[str]]]:
    """Return the cells of each row that has any, by the sign that divides the first, with its line.

    Tabs divide where there is one, else semicolons, else commas; none divides within quotes. A
    line `sep=;` before them names the sign, as Excel writes and reads it.

    Raises
    ------
    InvalidFileError
        If the quotes of a row do not match; `source` is the table's name.
    """
    lines = text.splitlines(keepends=True)
    at = next((k for k, one in enumerate(lines) if one.strip()), 0)
    first = lines[at] if lines else ""
    if named := _NAMED_SIGN.fullmatch(first.rstrip("\r\n")):
        sign = named[1]
        lines[at] = "\n"
    else:
        bare = "".join(first.split('"')[::2])
        sign = next((s for s in ("\t", ";") if s in bare), ",")
    rows = csv.reader(lines, delimiter=sign, skipinitialspace=sign != "\t", strict=True)
    found: list[tuple[int, list[str]]] = []
    line = 1
    try:
        for cells in rows:
            stripped = [" ".join(c.split()) for c in cells]
            if any(stripped):
                found.append((line, stripped))
            line = rows.line_num + 1
    except csv.Error:
        issue = FileIssue(message="the quotes of this row do not match", line=line)
        raise InvalidFileError(source, (issue,)) from None
    return found


def has_more_cells(cells: list[str], heading: list[str]) -> bool:
    """Return whether a row has a cell where its heading names no column; empty ones are none."""
    return any(cells[len(heading) :])


def decimal_sign(numbers: list[str]) -> str:
    """Return the decimal sign of a table: the one that some number can have as nothing else."""
    for number in numbers:
        last = max(number.rfind("."), number.rfind(","))
        if last < 0:
            continue
        sign, other = number[last], "," if number[last] == "." else "."
        alone = number.count(sign) == 1
        if alone and not interpretations_of_ambiguous_number(number, decimal=other):
            return sign
    # No number decides: one that may be either is then refused, whichever sign is taken.
    return "," if any("." in n for n in numbers) else "."
