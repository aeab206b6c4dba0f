"""Scalable drawings as text: elements, and the few shapes that figures are made of."""

from collections.abc import Iterable
from html import escape
from math import isfinite
from typing import Any, TypeAlias

import numpy as np

from cardan.core.arrays import ArrayLike
from cardan.core.lazy_dataclass import dataclass

AttributeValue: TypeAlias = str | float | None

TEXT_COLOUR, SECONDARY_COLOUR, GRID_COLOUR = "#1d2733", "#6b7785", "#dde2e8"
"""Colours of what is said, of what stands behind it, of the lines that help to read it."""

SERIES_COLOURS = ("#0072b2", "#d55e00", "#008060", "#a4407e", "#8a6d00", "#3f7fbf", "#5b5b5b")
"""Colours of series, apart for the colour-blind too (after Okabe and Ito), dark on white."""

SERIES_DASHES = ("", "7 3", "2 3", "8 3 2 3", "4 2", "10 4", "1 2", "12 3 2 3 2 3")
"""Dashes of series, apart without any colour."""

VERDICT_COLOURS = {"pass": "#1a7f37", "warn": "#9a6700", "fail": "#b42318"}
"""Colours of verdicts; each reads on white."""


HALO: dict[str, Any] = {
    "stroke": "#ffffff", "stroke_width": 3.0, "paint_order": "stroke",
}  # fmt: skip
"""What lets a label be read over lines."""


@dataclass(frozen=True, kw_only=True)
class Figure:
    """A drawing with its text alternative for screen readers."""

    title: str
    svg: str
    alt: str
    note: str = ""


def svg_element(name: str, *children: str, **attributes: AttributeValue) -> str:
    """Return an element; underscores in names of attributes stand for hyphens."""
    said = "".join(
        f' {key.rstrip("_").replace("_", "-")}="{_attribute_text(value)}"'
        for key, value in attributes.items()
        if value is not None
    )
    return f"<{name}{said}>{''.join(children)}</{name}>" if children else f"<{name}{said}/>"


def svg_document(width: float, height: float, *children: str, alt: str) -> str:
    """Return a whole drawing of a size in pixels, which scales to where it is shown."""
    return svg_element(
        "svg",
        *children,
        xmlns="http://www.w3.org/2000/svg",
        viewBox=f"0 0 {_attribute_text(width)} {_attribute_text(height)}",
        width=width,
        height=height,
        role="img",
        aria_label=alt,
        font_size=12,
        fill=TEXT_COLOUR,
    )


def text(
    x: float, y: float, said: str, *, anchor: str = "start", **attributes: AttributeValue
) -> str:
    """Return a line of text."""
    return svg_element("text", escape(said), x=x, y=y, text_anchor=anchor, **attributes)


def line(x1: float, y1: float, x2: float, y2: float, **attributes: AttributeValue) -> str:
    """Return a straight line."""
    return svg_element("line", x1=x1, y1=y1, x2=x2, y2=y2, **{"stroke": TEXT_COLOUR, **attributes})


def path(x: ArrayLike, y: ArrayLike, *, close: bool = False, **attributes: AttributeValue) -> str:
    """Return a line through points, broken where one is not a number."""
    steps: list[str] = []
    begin = True
    for a, b in zip(np.ravel(x), np.ravel(y), strict=True):
        if not (isfinite(a) and isfinite(b)):
            begin = True
            continue
        steps.append(
            f"{'M' if begin else 'L'}{_attribute_text(float(a))} {_attribute_text(float(b))}"
        )
        begin = False
    d = "".join(steps) + ("Z" if close and steps else "")
    return svg_element(
        "path", d=d or "M0 0", **{"fill": "none", "stroke": TEXT_COLOUR, **attributes}
    )


def circle(x: float, y: float, r: float, **attributes: AttributeValue) -> str:
    """Return a circle."""
    return svg_element("circle", cx=x, cy=y, r=r, **attributes)


def rect(x: float, y: float, width: float, height: float, **attributes: AttributeValue) -> str:
    """Return a rectangle, whichever way its sizes point."""
    x, width = min(x, x + width), abs(width)
    y, height = min(y, y + height), abs(height)
    return svg_element("rect", x=x, y=y, width=width, height=height, **attributes)


def arrow(
    x1: float, y1: float, x2: float, y2: float, *, size: float = 8, **attributes: AttributeValue
) -> str:
    """Return an arrow from the first point to the second; a line where it has no room."""
    length = float(np.hypot(x2 - x1, y2 - y1))
    colour = attributes.get("stroke", TEXT_COLOUR)
    if length < 1e-6:
        return circle(x1, y1, 2, fill=colour)
    size = min(size, 0.8 * length)
    ux, uy = (x2 - x1) / length, (y2 - y1) / length
    bx, by = x2 - size * ux, y2 - size * uy
    w = 0.38 * size
    head = path(
        [x2, bx - w * uy, bx + w * uy], [y2, by + w * ux, by - w * ux],
        close=True, fill=colour, stroke="none",
    )  # fmt: skip
    return line(x1, y1, bx, by, **attributes) + head


def group(children: Iterable[str], **attributes: AttributeValue) -> str:
    """Return elements that share attributes."""
    return svg_element("g", *children, **attributes)


def _attribute_text(value: AttributeValue) -> str:
    """Return an attribute's value, numbers to a hundredth of a pixel."""
    if isinstance(value, str):
        return escape(value, quote=True)
    return f"{value:.2f}".rstrip("0").rstrip(".")
