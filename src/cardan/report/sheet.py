"""A sheet: the numbers of a line as rows over its states, before any medium shapes them.

Terminal, pages and workbook all print these rows, so they cannot disagree about what a
number is called, which unit it has or in which order it comes. What is shown, and where,
stands with each quantity's declaration.
"""

from collections.abc import Iterator
from typing import get_args

import numpy as np

from cardan.base.arrays import FloatArray
from cardan.base.frozen import dataclass
from cardan.base.part import LINE, Part
from cardan.quantity.declared import BY_PART, Quantity
from cardan.quantity.declared import Section as Heading
from cardan.quantity.quantities import ANSWERED, QUANTITIES
from cardan.quantity.response import Response
from cardan.report.language import Language

MET_BY_OTHERS = {"joint_angle": ("joint_angle", "joint_angle_min", "odd_joint_angle")}
"""Rows that limits on other quantities ask about too."""


@dataclass(frozen=True, kw_only=True)
class Row:
    """One number for each state, in the unit its quantity is shown in.

    `part` says of what, `method` by which approximation; an exact value has none. nan is
    what could not be computed.
    """

    quantity: str
    values: FloatArray
    part: Part = LINE
    method: str = ""

    @property
    def unit(self) -> str:
        """Unit of the values as people write it."""
        return QUANTITIES[self.quantity].unit_name

    @property
    def asked(self) -> tuple[str, ...]:
        """The quantities whose limits ask about this row."""
        return MET_BY_OTHERS.get(self.quantity, (self.quantity,))

    def label(self, say: Language) -> str:
        """Return the row's name with its part or, in brackets, its approximation."""
        if self.method:
            return f"  ({say(METHODS.get(self.method, self.method))})"
        if self.part.kind == "clearance":
            return say.list(say.name(self.quantity), str(self.part.other))
        part = "" if self.part == LINE or (self.part.kind == "shaft" and self.alone) else self.part
        return say.list(say.name(self.quantity), say.part(part) if part else "")

    @property
    def alone(self) -> bool:
        """Whether only one part of a line has this, so that it need not be said."""
        return self.quantity in ("spline_travel", "spline_travel_margin", "spline_force")


@dataclass(frozen=True, kw_only=True)
class Section:
    """Rows that belong together."""

    title: str
    rows: tuple[Row, ...]


METHODS = {
    "quasi_static": "without thrust and inertia",
    "rigid": "rigid bearing, at its own torque", "ae7": "AE-7",
    "in_plane": "all joints in one plane", "spicer_sine": "ω² sin²",
    "spicer_rpm": "3.3403e-6 N²θ²", "small_angle": "small angle",
}  # fmt: skip
"""How the approximations are called in print, by their names in the JSON contract."""


def sections(response: Response) -> tuple[Section, ...]:
    """Return everything a line does, state by state, without what nothing is known of."""
    kept = (
        Section(title=title, rows=tuple(_told(list(_rows(response, title)))))
        for title in get_args(Heading)
    )
    return tuple(s for s in kept if s.rows)


def _told(rows: list[Row]) -> Iterator[Row]:
    """Yield what something is known of: an approximation stands under its quantity's own row."""
    for row in rows:
        beside = (r for r in rows if r.method and (r.quantity, r.part) == (row.quantity, row.part))
        if not _unknown(row) or (not row.method and not all(_unknown(r) for r in beside)):
            yield row


def line_title(response: Response, say: Language) -> str:
    """Return the heading of a line: its name, its shafts and joints."""
    shafts = len(response.line.shafts)
    return say(
        "Line {line}: {shafts}, {joints}", line=response.line.name,
        shafts=say.count("{count} shaft", "{count} shafts", shafts),
        joints=say.count("{count} joint", "{count} joints", shafts + 1),
    )  # fmt: skip


def _unknown(row: Row) -> bool:
    nought = QUANTITIES[row.quantity].quiet and not row.values.any()
    return bool(nought or np.isnan(row.values).all())


def _rows(r: Response, title: str) -> Iterator[Row]:
    """Yield the rows of a section, by quantity or all of one part before the next."""
    rows = [row for q in ANSWERED.values() if q.section == title for row in _of(q, r)]
    if title in BY_PART:
        order = list(dict.fromkeys(row.part for row in rows))
        rows.sort(key=lambda row: order.index(row.part))
    yield from rows


def _of(q: Quantity, r: Response) -> Iterator[Row]:
    """Yield the rows of a quantity, each followed by its approximations."""
    assert q.parts is not None
    exact = q.values(r) / q.factor
    others = {name: of(r) / q.factor for name, of in q.methods.items()}
    for part, places in _groups(q.parts(r)).items():
        values = exact[:, places].min(axis=-1)
        yield Row(quantity=q.key, values=values, part=part)
        for name, by_method in others.items():
            yield Row(quantity=q.key, values=by_method[:, places[0]], part=part, method=name)


def _groups(parts: tuple[Part, ...]) -> dict[Part, list[int]]:
    """Return the places of each part to show: of an obstacle, the nearest shaft is enough."""
    found: dict[Part, list[int]] = {}
    for k, part in enumerate(parts):
        found.setdefault(shown_as(part), []).append(k)
    return found


def shown_as(part: Part) -> Part:
    """Return the part whose row shows a part: an obstacle's, for the shafts that clear it."""
    return Part("clearance", 0, part.other) if part.kind == "clearance" else part
