"""Text laid out for a width: what is too long goes on in the next line, and is never cut.

Colours take no room. The caller gives the width of the screen; without one it is
`DEFAULT_WIDTH_COLUMNS`.
"""

import re
from collections.abc import Iterable, Iterator, Sequence
from itertools import zip_longest
from textwrap import wrap

DEFAULT_WIDTH_COLUMNS = 80
"""Columns of a screen of unknown width."""

NO_BREAK_SPACE = "\u00a0"
"""A space at which no line ends."""

_UNIT_PATTERN = r"(?:%|Hz|N|N·m|MPa|deg|h|kN|kg|km|mm|rad/s²?|rpm|s)(?![\w/·²])"
_NO_BREAK_POSITIONS = re.compile(rf"(?<!,) (?=\d)|(?<=\d) (?={_UNIT_PATTERN})")
"""Where no line ends: ahead of a number that no comma precedes, and between it and its unit."""

_COLOUR_CODE = re.compile(r"\x1b\[[0-9;]*m")


def without_colours(lines: Iterable[str]) -> str:
    """Return lines as one text without colours, for output other than a terminal."""
    return _COLOUR_CODE.sub("", "\n".join(lines))


def display_width(text: str) -> int:
    """Return how many columns a text takes."""
    return len(_COLOUR_CODE.sub("", text))


def fold_lines(lines: Iterable[str], width: int = DEFAULT_WIDTH_COLUMNS) -> Iterator[str]:
    """Yield lines, the long ones broken between words and going on a little further in."""
    for line in lines:
        if display_width(line) <= width:
            yield line
            continue
        indent = len(line) - len(line.lstrip())
        first, further = " " * indent, " " * min(indent + 4, width // 2)
        taken = first
        for word in re.split(" +", _with_no_break_spaces(line.strip())):
            glue = "" if not taken.strip() else " "
            if taken.strip() and display_width(taken) + len(glue) + display_width(word) > width:
                yield taken.replace(NO_BREAK_SPACE, " ")
                taken, glue = further, ""
            taken += glue + word
        yield taken.replace(NO_BREAK_SPACE, " ")


def wrap_text(text: str, room: int) -> list[str]:
    """Return the lines of a text in a room; a number stays with what it counts and its unit."""
    return [
        line.replace(NO_BREAK_SPACE, " ") for line in wrap(_with_no_break_spaces(text), room)
    ] or [""]


def _with_no_break_spaces(text: str) -> str:
    """Return a text in which a number stays with what it counts, and with its unit."""
    return _NO_BREAK_POSITIONS.sub(NO_BREAK_SPACE, text)


def text_with_right_column(left: str, right: str, room: int) -> Iterator[str]:
    """Yield lines of a text in a width, with another one next to the first of them."""
    first, *others = wrap_text(left, room - 1)
    yield f"{first:<{room}}{right}"
    yield from others


def table_lines(
    head: Sequence[str],
    rows: Sequence[Sequence[str]],
    width: int = DEFAULT_WIDTH_COLUMNS,
    *,
    right: Sequence[int] = (),
) -> Iterator[str]:
    """Yield the lines of a table: its head, then its rows; some columns flush `right`.

    What is wider than the screen goes on in further lines of its cell. Where words themselves
    are too long for that, each row stands below its name, or the table lies on its side.
    """
    every = [head, *rows]
    words = (
        [w for row in every for w in _with_no_break_spaces(row[k]).split(" ")]
        for k in range(len(head))
    )
    least = [max(map(display_width, some), default=0) for some in words]
    if sum(least) <= _available_width(least, width):
        wide = _fitted_widths(
            [max(display_width(row[k]) for row in every) for k in range(len(head))], least, width
        )
        for row in every:
            yield from _row_lines(row, wide, right)
    elif sum(least[1:]) <= _available_width(least[1:], width - 4):
        rest = [row[1:] for row in every]
        wide = _fitted_widths(
            [max(map(display_width, c)) for c in zip(*rest, strict=True)], least[1:], width - 4
        )
        for row, others in zip(every, rest, strict=True):
            yield from wrap_text(row[0], width)
            lines = _row_lines(others, wide, [k - 1 for k in right])
            yield from (f"    {line}" for line in lines)
    else:
        yield from _transposed_lines(head, rows, width)


def _available_width(columns: Sequence[int], width: int) -> int:
    """Return how much of a width the columns have, two spaces between them."""
    return width - 2 * (len(columns) - 1)


def _fitted_widths(wide: list[int], least: Sequence[int], width: int) -> list[int]:
    """Return widths of columns that fit a screen: the widest give way first."""
    while sum(wide) > _available_width(wide, width):
        k = max(range(len(wide)), key=lambda k: (wide[k] > least[k], wide[k]))
        wide[k] -= 1
    return wide


def _row_lines(row: Sequence[str], wide: Sequence[int], right: Sequence[int] = ()) -> Iterator[str]:
    """Yield the lines of a row whose columns are so wide."""
    cells = [
        [c] if display_width(c) <= w else wrap_text(c, w) for c, w in zip(row, wide, strict=True)
    ]
    for line in zip_longest(*cells, fillvalue=""):
        each = zip(line, wide, strict=True)
        padded = (
            " " * (w - display_width(cell)) + cell
            if k in right
            else cell + " " * (w - display_width(cell))
            for k, (cell, w) in enumerate(each)
        )
        yield "  ".join(padded).rstrip()


def _transposed_lines(
    head: Sequence[str], rows: Sequence[Sequence[str]], width: int
) -> Iterator[str]:
    """Yield a table with its heads down and its rows across, as many at a time as have room."""
    first = min(max(map(display_width, head)), width // 3)
    wide = max((display_width(cell) for row in rows for cell in row), default=0)
    wide = min(wide, width - first - 2)
    many = max((width - first) // (wide + 2), 1)
    for start in range(0, len(rows), many):
        if start:
            yield ""
        some = rows[start : start + many]
        for line in zip(head, *some, strict=True):
            yield from _row_lines(line, [first, *(wide for _ in some)])


def column_heading_lines(names: Sequence[str], wide: int) -> list[str]:
    """Return lines of names over columns, each as wide; long names stand in several lines."""
    each = [wrap_text(name, wide - 1) for name in names]
    high = max(map(len, each), default=1)
    return [
        "".join(f"{([''] * (high - len(one)) + one)[k]:>{wide}}" for one in each)
        for k in range(high)
    ]
