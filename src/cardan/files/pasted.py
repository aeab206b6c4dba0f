"""Numbers as people type and copy them: with a decimal comma, a unit, spaces between thousands."""

import re

from cardan.base.errors import BadFile, Problem

_GROUPED = re.compile(r"(?<=\d)[\s'\u00a0\u202f](?=\d{3}(?!\d))")
_NUMBER = re.compile(r"[-+\u2212]?(?:\d+(?:[.,]\d*)?|[.,]\d+)(?:[eE][-+]?\d{1,2})?")
_CELLS = re.compile(r"\t|;|\|")
_WIDE = re.compile(r"\s{1,}")

NAME = "points"

MOST = 60
"""Rows of a pasted table: a line has 12 joints at most, and a sheet some more lines."""


def number(said: str) -> float | None:
    """Return the number that was typed; None where it is none.

    A comma is a decimal sign where it stands alone: 3,5 is 3.5. With both signs the last one
    is: 1.234,5 and 1,234.5 are the same. 1,234 is 1.234: nobody's thousand is guessed.

    >>> number("3,5"), number("1 234.5"), number("1.234,5"), number("-0,2°"), number("about 3")
    (3.5, 1234.5, 1234.5, -0.2, None)
    """
    bare = _GROUPED.sub("", said.strip().removesuffix("°").strip())
    dot, comma = bare.rfind("."), bare.rfind(",")
    if dot >= 0 and comma >= 0:
        bare = bare.replace("," if comma < dot else ".", "")
    if bare.count(",") + bare.count(".") > 1 or not _NUMBER.fullmatch(bare):
        return None
    return float(bare.replace(",", ".").replace("\u2212", "-"))


def hardpoints(pasted: str) -> tuple[tuple[float, float, float], ...]:
    """Return the rows of a table of points as a spreadsheet copies it, x, y and z of each.

    The last three cells of a row are its numbers; a name may stand before them. Rows without
    a number are headings.

    Raises
    ------
    BadFile
        With every row that is neither, by its line and column.
    """
    found: list[tuple[float, float, float]] = []
    problems: list[Problem] = []
    for line, row in enumerate(pasted.splitlines()[: 10 * MOST], 1):
        cells = [c.strip() for c in (_CELLS if _CELLS.search(row) else _WIDE).split(row.strip())]
        cells = [c for c in cells if c]
        values = [number(c) for c in cells]
        known = [v for v in values if v is not None]
        if not known:
            continue
        last = [v for v in values[-3:] if v is not None]
        if len(last) < 3:
            bad = next((c for c, v in zip(cells[-3:], values[-3:], strict=True) if v is None), "")
            problems.append(
                Problem(
                    message="a row needs x, y and z as its last three cells", key=f"row {line}",
                    value=bad or row.strip()[:40], line=line, column=max(row.find(bad), 0) + 1,
                )
            )  # fmt: skip
            continue
        found.append((last[0], last[1], last[2]))
    if not problems and not 2 <= len(found) <= MOST:
        message = "give a row of x, y and z for each joint, gearbox first"
        problems.append(Problem(message=message, key=NAME, value=f"{len(found)} rows"))
    if problems:
        raise BadFile(NAME, tuple(problems))
    return tuple(found)
