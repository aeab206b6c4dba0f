"""Text laid out for a width: what is too long goes on in the next line, and is never cut.

Colours take no room. Who prints says how wide the screen is; where nobody does it is `WIDTH`.
"""

import re
from collections.abc import Iterable, Iterator, Sequence
from textwrap import wrap

WIDTH = 80
"""Columns of a screen that nobody told the width of."""

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
        for word in re.split(r"\s+(?!\d)", line.strip()):
            glue = "" if not taken.strip() else " "
            if taken.strip() and long(taken) + len(glue) + long(word) > width:
                yield taken
                taken, glue = further, ""
            taken += glue + word
        yield taken


def wrapped(text: str, room: int) -> list[str]:
    """Return the lines of a text in a room; a number stays with what it counts."""
    bound = re.sub(r" (?=\d)", "\u00a0", text)
    return [line.replace("\u00a0", " ") for line in wrap(bound, room)] or [""]


def beside(left: str, right: str, room: int) -> Iterator[str]:
    """Yield lines of a text in a room, with another one beside the first of them."""
    first, *others = wrapped(left, room - 1)
    yield f"{first:<{room}}{right}"
    yield from others


def headings(names: Sequence[str], wide: int) -> list[str]:
    """Return lines of names over columns, each as wide; long names stand in several lines."""
    each = [wrapped(name, wide - 1) for name in names]
    high = max(map(len, each), default=1)
    return [
        "".join(f"{([''] * (high - len(one)) + one)[k]:>{wide}}" for one in each)
        for k in range(high)
    ]
