"""Numbers as people type and copy them: with a decimal comma, a unit, spaces between thousands."""

import re

from cardan.core.errors import FileIssue, InvalidFileError

_GROUPED = re.compile(r"(?<=\d)[\s'\u00a0\u202f](?=\d{3}(?!\d))")
_NUMBER = re.compile(r"[-+\u2212]?(?:\d+(?:[.,]\d*)?|[.,]\d+)(?:[eE][-+]?\d{1,2})?")
_CELLS = re.compile(r"\t|;|\|")
_UNIT = re.compile(r"[\[(]\s*(mm|cm|m|in|ft)\s*[\])]", re.IGNORECASE)
_AXIS = re.compile(r"([xyz])(?:[\W_].*)?")

_EITHER = re.compile(r"[-+\u2212]?[1-9]\d{0,2}[.,]\d{3}")

POINTS_FILE_NAME = "points"

MAX_PASTED_ROWS = 60
"""Rows of a pasted table: a line has 12 joints at most, and a sheet some more lines."""


def parse_number_of_unknown_locale(said: str) -> float | None:
    """Return the number that was typed; None where it is none.

    A comma is a decimal sign where it stands alone: 3,5 is 3.5. With both signs the last one
    is: 1.234,5 and 1,234.5 are the same. 1,234 is 1.234: no thousand is guessed.

    >>> [parse_number_of_unknown_locale(n) for n in ("3,5", "1 234.5", "1.234,5", "-0,2°", "some")]
    [3.5, 1234.5, 1234.5, -0.2, None]
    """
    bare = _GROUPED.sub("", said.strip().removesuffix("°").strip())
    dot, comma = bare.rfind("."), bare.rfind(",")
    if dot >= 0 and comma >= 0:
        bare = bare.replace("," if comma < dot else ".", "")
    if bare.count(",") + bare.count(".") > 1 or not _NUMBER.fullmatch(bare):
        return None
    return float(bare.replace(",", ".").replace("\u2212", "-"))


def interpretations_of_ambiguous_number(said: str, *, decimal: str) -> tuple[str, str] | None:
    """Return both readings of a number with the sign that is not the decimal; None if it has one.

    Who writes 3,5 sets thousands apart with a point, and may have typed a point for a comma; who
    writes 3.5 the other way round.

    >>> interpretations_of_ambiguous_number("8.000", decimal=",")
    ('8,000', '8000')
    >>> interpretations_of_ambiguous_number("8.000", decimal=".")
    """
    bare = said.strip().removesuffix("°").strip()
    other = "." if decimal == "," else ","
    if other not in bare or not _EITHER.fullmatch(bare):
        return None
    return bare.replace(other, decimal), bare.replace(other, "")


def parse_localised_number(said: str, *, decimal: str) -> float:
    """Return the number that stands in a field, in a language that writes `decimal`.

    Raises
    ------
    ValueError
        If there is none, or may be another: both readings are named, and none is chosen.
    """
    if either := interpretations_of_ambiguous_number(said, decimal=decimal):
        msg = "decimals or thousands? write {} or {}".format(*either)
        raise ValueError(msg)
    value = parse_number_of_unknown_locale(said)
    if value is None:
        msg = "is no number"
        raise ValueError(msg)
    return value


def parse_hardpoints(pasted: str, *, unit: str = "") -> tuple[tuple[float, float, float], ...]:
    """Return the rows of a table of points as a spreadsheet copies it, x, y and z of each.

    Rows without a number are headings. Where one names x, y and z, they are its columns; else
    they are the last three, and a name may stand before them. A cell that is empty in one row
    alone is a number that is missing: nothing moves up into its place. A heading that says
    another unit than `unit`, where one was chosen, is not passed over.

    Raises
    ------
    InvalidFileError
        With every row that is neither, by its line and column.
    """
    rows = pasted.splitlines()[: 10 * MAX_PASTED_ROWS]
    table = _columns([_cells(row) for row in rows])
    found: list[tuple[float, float, float]] = []
    problems: list[FileIssue] = []
    at = (-3, -2, -1)
    for line, (row, cells) in enumerate(zip(rows, table, strict=True), 1):
        said = " ".join(row.split())[:40]
        if not _numbered(cells):
            named = _UNIT.search(row)
            if unit and named and named[1].lower() != unit:
                message = f"the heading says {named[1]}, and {unit} was chosen"
                raise InvalidFileError(
                    POINTS_FILE_NAME,
                    (FileIssue(message=message, key=f"row {line}", value=said, line=line),),
                )
            axes = {axis: k for k, c in enumerate(cells) if (axis := _axis(c))}
            if axes and (len(axes) != 3 or sum(map(bool, map(_axis, cells))) != 3):
                message = "a heading names x, y and z, each once"
                problem = FileIssue(message=message, key=f"row {line}", value=said, line=line)
                raise InvalidFileError(POINTS_FILE_NAME, (problem,))
            if axes:
                at = (axes["x"], axes["y"], axes["z"])
            continue
        three = [cells[k] for k in at] if len(cells) >= 3 else ["", "", ""]
        bad = next((c for c in three if parse_number_of_unknown_locale(c) is None), None)
        if bad is not None:
            problems.append(
                FileIssue(
                    message="a row needs x, y and z as its last three cells", key=f"row {line}",
                    value=bad or said, line=line, column=max(row.find(bad), 0) + 1,
                )
            )  # fmt: skip
            continue
        x, y, z = (v for c in three if (v := parse_number_of_unknown_locale(c)) is not None)
        found.append((x, y, z))
    if not problems and not 2 <= len(found) <= MAX_PASTED_ROWS:
        message = "give a row of x, y and z for each joint, gearbox first"
        problems.append(
            FileIssue(message=message, key=POINTS_FILE_NAME, value=f"{len(found)} rows")
        )
    if problems:
        raise InvalidFileError(POINTS_FILE_NAME, tuple(problems))
    return tuple(found)


def _axis(cell: str) -> str | None:
    """Return the axis that a cell of a heading names: x [mm] is x."""
    found = _AXIS.fullmatch(cell.lower())
    return found[1] if found else None


def _numbered(cells: list[str]) -> bool:
    return any(parse_number_of_unknown_locale(c) is not None for c in cells)


def _cells(row: str) -> tuple[list[str], bool]:
    """Return the cells of a row, and whether signs divide them: empty ones count then."""
    if _CELLS.search(row):
        return [c.strip() for c in _CELLS.split(row)], True
    cells = row.split()
    named = [c for c in cells if _axis(c)]
    return (named if named and not _numbered(cells) else cells), False


def _columns(rows: list[tuple[list[str], bool]]) -> list[list[str]]:
    """Return the rows in common columns, without those that no row of numbers fills."""
    width = max((len(cells) for cells, _ in rows), default=0)
    whole = [
        cells + [""] * (width - len(cells)) if divided else [""] * (width - len(cells)) + cells
        for cells, divided in rows
    ]
    filled = [k for k in range(width) if any(cells[k] for cells in whole if _numbered(cells))]
    return [[cells[k] for k in filled] for cells in whole]
