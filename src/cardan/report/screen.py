"""Text laid out for a width: what is too long goes on in the next line, and is never cut.

Colours take no room. Who prints says how wide the screen is; where nobody does it is `WIDTH`.
"""

import re
from collections.abc import Iterable, Iterator, Sequence
from itertools import zip_longest
from textwrap import wrap

WIDTH = 80
"""Columns of a screen that nobody told the width of."""

GLUE = "\u00a0"
"""A space at which no line ends."""

_UNIT = r"(?:%|Hz|N|N·m|MPa|deg|h|kN|kg|km|mm|rad/s²?|rpm|s)(?![\w/·²])"
_TIED = re.compile(rf"(?<!\d,) (?=\d)|(?<=\d) (?={_UNIT})")
"""Where no line ends: ahead of a number, but in a row of them, and between it and its unit."""

_COLOUR = re.compile(r"\x1b\[[0-9;]*m")


def bare(lines: Iterable[str]) -> str:
    """Return lines as one text without colours, for where nobody prints to a terminal."""
    return _COLOUR.sub("", "\n".join(lines))


def long(text: str) -> int:
    """Return how many columns a text takes."""
    return len(_COLOUR.sub("", text))


def folded(lines: Iterable[str], width: int = WIDTH) -> Iterator[str]:
    """Yield lines, the long ones broken between words and going on a little further in."""
    for line in lines:
        if long(line) <= width:
            yield line
            continue
        indent = len(line) - len(line.lstrip())
        first, further = " " * indent, " " * min(indent + 4, width // 2)
        taken = first
        for word in re.split(" +", _bound(line.strip())):
            glue = "" if not taken.strip() else " "
            if taken.strip() and long(taken) + len(glue) + long(word) > width:
                yield taken.replace(GLUE, " ")
                taken, glue = further, ""
            taken += glue + word
        yield taken.replace(GLUE, " ")


def wrapped(text: str, room: int) -> list[str]:
    """Return the lines of a text in a room; a number stays with what it counts and its unit."""
    return [line.replace(GLUE, " ") for line in wrap(_bound(text), room)] or [""]


def _bound(text: str) -> str:
    """Return a text in which a number stays with what it counts, and with its unit."""
    return _TIED.sub(GLUE, text)


def beside(left: str, right: str, room: int) -> Iterator[str]:
    """Yield lines of a text in a room, with another one beside the first of them."""
    first, *others = wrapped(left, room - 1)
    yield f"{first:<{room}}{right}"
    yield from others


def table(
    head: Sequence[str],
    rows: Sequence[Sequence[str]],
    width: int = WIDTH,
    *,
    right: Sequence[int] = (),
) -> Iterator[str]:
    """Yield the lines of a table: its head, then its rows; some columns flush `right`.

    What is wider than the screen goes on in further lines of its cell. Where words themselves
    are too long for that, each row stands below its name, or the table lies on its side.
    """
    every = [head, *rows]
    words = ([w for row in every for w in _bound(row[k]).split(" ")] for k in range(len(head)))
    least = [max(map(long, some), default=0) for some in words]
    if sum(least) <= _room(least, width):
        wide = _fitted([max(long(row[k]) for row in every) for k in range(len(head))], least, width)
        for row in every:
            yield from _cells(row, wide, right)
    elif sum(least[1:]) <= _room(least[1:], width - 4):
        rest = [row[1:] for row in every]
        wide = _fitted([max(map(long, c)) for c in zip(*rest, strict=True)], least[1:], width - 4)
        for row, others in zip(every, rest, strict=True):
            yield from wrapped(row[0], width)
            lines = _cells(others, wide, [k - 1 for k in right])
            yield from (f"    {line}" for line in lines)
    else:
        yield from _on_its_side(head, rows, width)


def _room(columns: Sequence[int], width: int) -> int:
    """Return how much of a width the columns have, two spaces between them."""
    return width - 2 * (len(columns) - 1)


def _fitted(wide: list[int], least: Sequence[int], width: int) -> list[int]:
    """Return widths of columns that fit a screen: the widest give way first."""
    while sum(wide) > _room(wide, width):
        k = max(range(len(wide)), key=lambda k: (wide[k] > least[k], wide[k]))
        wide[k] -= 1
    return wide


def _cells(row: Sequence[str], wide: Sequence[int], right: Sequence[int] = ()) -> Iterator[str]:
    """Yield the lines of a row whose columns are so wide."""
    cells = [[c] if long(c) <= w else wrapped(c, w) for c, w in zip(row, wide, strict=True)]
    for line in zip_longest(*cells, fillvalue=""):
        each = zip(line, wide, strict=True)
        padded = (
            " " * (w - long(cell)) + cell if k in right else cell + " " * (w - long(cell))
            for k, (cell, w) in enumerate(each)
        )
        yield "  ".join(padded).rstrip()


def _on_its_side(head: Sequence[str], rows: Sequence[Sequence[str]], width: int) -> Iterator[str]:
    """Yield a table with its heads down and its rows across, as many at a time as have room."""
    first = min(max(map(long, head)), width // 3)
    wide = max((long(cell) for row in rows for cell in row), default=0)
    wide = min(wide, width - first - 2)
    many = max((width - first) // (wide + 2), 1)
    for start in range(0, len(rows), many):
        if start:
            yield ""
        some = rows[start : start + many]
        for line in zip(head, *some, strict=True):
            yield from _cells(line, [first, *(wide for _ in some)])


def headings(names: Sequence[str], wide: int) -> list[str]:
    """Return lines of names over columns, each as wide; long names stand in several lines."""
    each = [wrapped(name, wide - 1) for name in names]
    high = max(map(len, each), default=1)
    return [
        "".join(f"{([''] * (high - len(one)) + one)[k]:>{wide}}" for one in each)
        for k in range(high)
    ]
