"""A sheet: the numbers of a line as rows over its states, before any medium shapes them.

Terminal, pages and workbook all print these rows, so they cannot disagree about what a
number is called, which unit it has or in which order it comes. What is shown, and where,
stands with each quantity's declaration.
"""

from collections.abc import Iterator
from typing import get_args

import numpy as np

from cardan.checks.line_response import LineResponse
from cardan.checks.quantities.declaration import SECTIONS_GROUPED_BY_PART, Quantity
from cardan.checks.quantities.declaration import ReportTableSection as Heading
from cardan.checks.quantities.registry import LINE_QUANTITIES, QUANTITIES
from cardan.core.arrays import BoolArray, FloatArray
from cardan.core.labels import WHOLE_LINE, Part
from cardan.core.lazy_dataclass import dataclass
from cardan.render.i18n import Translator

LIMIT_QUANTITIES_BY_ROW = {"joint_angle": ("joint_angle", "joint_angle_min", "odd_joint_angle")}
"""Rows that limits on other quantities use too."""


@dataclass(frozen=True, kw_only=True)
class StateTableRow:
    """One number for each state, in the unit its quantity is shown in.

    `part` says of what, `method` by which approximation; an exact value has none. nan is
    what could not be computed. `bounds` says which values are lower bounds.
    """

    quantity: str
    values: FloatArray
    bounds: BoolArray
    part: Part = WHOLE_LINE
    method: str = ""

    @property
    def unit(self) -> str:
        """Unit of the values as people write it."""
        return QUANTITIES[self.quantity].unit_symbol

    @property
    def limit_quantities(self) -> tuple[str, ...]:
        """The quantities whose limits use this row."""
        return LIMIT_QUANTITIES_BY_ROW.get(self.quantity, (self.quantity,))

    def value_texts(self, say: Translator) -> tuple[str, ...]:
        """Return its values as tables print them, lower bounds with their mark."""
        each = zip(self.values.tolist(), self.bounds.tolist(), strict=True)
        return tuple(("≥ " if bound else "") + say.number(v) for v, bound in each)

    def label(self, say: Translator) -> str:
        """Return the row's name with its part or, in brackets, its approximation."""
        if self.method:
            return f"  ({say(APPROXIMATION_METHOD_TITLES.get(self.method, self.method))})"
        if self.part.kind == "clearance":
            return say.join(say.name(self.quantity), str(self.part.other))
        part = (
            ""
            if self.part == WHOLE_LINE or (self.part.kind == "shaft" and self.is_single_part)
            else self.part
        )
        return say.join(say.name(self.quantity), say.part(part) if part else "")

    @property
    def is_single_part(self) -> bool:
        """Whether only one part of a line has this, so that it need not be said."""
        return self.quantity in ("spline_travel", "spline_travel_margin", "spline_force")


@dataclass(frozen=True, kw_only=True)
class LineStateTableSection:
    """Rows that belong together."""

    title: str
    rows: tuple[StateTableRow, ...]


APPROXIMATION_METHOD_TITLES = {
    "quasi_static": "without thrust and inertia",
    "rigid": "rigid bearing, at its own torque", "ae7": "AE-7",
    "in_plane": "all joints in one plane", "spicer_sine": "ω² sin²",
    "spicer_rpm": "3.3403e-6 N²θ²", "small_angle": "small angle",
}  # fmt: skip
"""How the approximations are called in print, by their names in the JSON contract."""


def state_table_sections(response: LineResponse) -> tuple[LineStateTableSection, ...]:
    """Return everything a line does, state by state, without what nothing is known of."""
    kept = (
        LineStateTableSection(
            title=title, rows=tuple(_known_rows(list(_section_rows(response, title))))
        )
        for title in get_args(Heading)
    )
    return tuple(s for s in kept if s.rows)


def _known_rows(rows: list[StateTableRow]) -> Iterator[StateTableRow]:
    """Yield what something is known of: an approximation stands under its quantity's own row."""
    for row in rows:
        beside = (r for r in rows if r.method and (r.quantity, r.part) == (row.quantity, row.part))
        if not _unknown(row) or (not row.method and not all(_unknown(r) for r in beside)):
            yield row


def driveline_title(response: LineResponse, say: Translator) -> str:
    """Return the heading of a line: its name, its shafts and joints."""
    shafts = len(response.line.shafts)
    return say(
        "Line {line}: {shafts}, {joints}", line=response.line.name,
        shafts=say.count("{count} shaft", "{count} shafts", shafts),
        joints=say.count("{count} joint", "{count} joints", shafts + 1),
    )  # fmt: skip


def _unknown(row: StateTableRow) -> bool:
    nought = QUANTITIES[row.quantity].hidden_if_zero and not row.values.any()
    return bool(nought or np.isnan(row.values).all())


def _section_rows(r: LineResponse, title: str) -> Iterator[StateTableRow]:
    """Yield the rows of a section, by quantity or all of one part before the next."""
    rows = [
        row for q in LINE_QUANTITIES.values() if q.section == title for row in _quantity_rows(q, r)
    ]
    if title in SECTIONS_GROUPED_BY_PART:
        order = list(dict.fromkeys(row.part for row in rows))
        rows.sort(key=lambda row: order.index(row.part))
    yield from rows


def _quantity_rows(q: Quantity, r: LineResponse) -> Iterator[StateTableRow]:
    """Yield the rows of a quantity, each followed by its approximations."""
    assert q.parts is not None
    exact, bounds = q.values_and_bounds(r)
    exact = exact / q.si_factor
    others = {name: of(r) / q.si_factor for name, of in q.approximations.items()}
    for part, places in _indices_by_displayed_part(q.parts(r)).items():
        yield StateTableRow(
            quantity=q.key,
            values=exact[:, places].min(axis=-1),
            bounds=np.asarray(bounds[:, places].any(axis=-1)),
            part=part,
        )
        for name, by_method in others.items():
            values = by_method[:, places[0]]
            none = np.zeros(len(values), dtype=bool)
            yield StateTableRow(quantity=q.key, values=values, bounds=none, part=part, method=name)


def _indices_by_displayed_part(parts: tuple[Part, ...]) -> dict[Part, list[int]]:
    """Return the places of each part to show: of an obstacle, the nearest shaft is enough."""
    found: dict[Part, list[int]] = {}
    for k, part in enumerate(parts):
        found.setdefault(part_whose_row_is_shown(part), []).append(k)
    return found


def part_whose_row_is_shown(part: Part) -> Part:
    """Return the part whose row shows a part: an obstacle's, for the shafts that clear it."""
    return Part("clearance", 0, part.other) if part.kind == "clearance" else part
