"""A workbook's front: the verdict, what decides, the line in the state that does, charts."""

from collections.abc import Sequence
from io import BytesIO

import numpy as np

from cardan.base.errors import NotInstalled
from cardan.base.verdict import Check
from cardan.quantity.quantities import QUANTITIES
from cardan.quantity.response import Response
from cardan.report.book import Book, Sheet, column
from cardan.report.drawing import drawable, in_state, state_to_show
from cardan.report.judged import Judged, verdict
from cardan.report.wording import held, place, sense, tally, worst_of_each
from cardan.study.approval import Approval

CHARTED = (
    ("torsional_acceleration", "inertia_drive_acceleration", "inertia_coast_acceleration"),
    ("centre_bearing_static", "centre_bearing_dynamic", "centre_bearing_peak"),
    ("joint_angle",),
)
"""Quantities that stand in a chart together, state by state."""

DECIDING = 3

WIDTHS = (46, 50, 14, 16, 12, 12)
"""Of the front's columns, in characters."""


def open_front(book: Book) -> Sheet:
    """Return the first sheet of a workbook, to be filled when its others are there."""
    sheet = book.sheet(book.say("Front"))
    for k, wide in enumerate(WIDTHS):
        sheet.sheet.set_column(k, k, wide)
    sheet.sheet.set_column(len(WIDTHS), len(WIDTHS) + 12, 12)
    return sheet


def fill(sheet: Sheet, of: Approval, judged: Sequence[Judged]) -> None:
    """Write the verdict, live, what decides as computed, the line drawn, and charts."""
    say, book, several = sheet.book.say, sheet.book, len(of.responses) > 1
    sheet.title(of.application.title)
    verdict(sheet, sheet.row, judged, name="")
    sheet.row += 1
    margin, told = of.smallest_margin, tally(of.checks, say, of.coverage.unanswered)
    facts = [
        (say("as computed"), f"{say(of.verdict).upper()} ({told})"),
        (say("Coverage"), say("{answered} of {asked} questions answered",
                              answered=of.coverage.answered, asked=of.coverage.asked)),
        (say("smallest margin"), "-" if margin is None else say.percent(margin)),
        (say("Limits"), of.application.profile),
    ]  # fmt: skip
    for name, said in facts:
        sheet.sheet.write_string(sheet.row, 0, name, book.plain)
        sheet.sheet.write_string(sheet.row, 1, said, book.plain)
        sheet.row += 1
    rows = worst_of_each(of.checks)[:DECIDING]
    _words(sheet, (say("What decides"), say("where it is worst"), say("value"), say("bound"),
                   say("unit"), say("margin")), bold=True)  # fmt: skip
    for c in rows:
        q, (value, bound) = QUANTITIES[c.quantity], held(c, say)
        row = sheet.row
        _words(sheet, (
            say.name(q.key), place(c, say, several=several), value,
            f"{sense(c, say)} {bound}", q.unit_name,
            say.percent(c.margin),
        ))  # fmt: skip
        sheet.sheet.write_string(row, 0, say.name(q.key), book.graded[c.grade])
    sheet.row += 1
    named = {c.line for c in rows}
    shown = next((r for r in of.responses if r.line.name in named), None)
    shown = shown or next(iter(of.responses), None)
    if shown is not None and drawable(shown):
        _drawn(sheet, shown, *state_to_show(shown, rows))
    for r in of.responses:
        _charts(sheet, r, several=several)


def _words(sheet: Sheet, cells: Sequence[str], *, bold: bool = False) -> None:
    """Write a row of texts."""
    style = sheet.book.section if bold else sheet.book.plain
    for k, cell in enumerate(cells):
        sheet.sheet.write_string(sheet.row, k, cell, style)
    sheet.row += 1


def _drawn(sheet: Sheet, r: Response, s: int, at: Check | None) -> None:
    """Put the drawing of a line in a state, or at a check there, if it can be drawn."""
    from cardan.report.pdf import pixels

    figure = in_state(r, sheet.book.say, s, at)
    sheet.sheet.write_string(sheet.row, 0, figure.title, sheet.book.head)
    try:
        png = pixels(figure)
    except NotInstalled as missing:
        sheet.sheet.write_string(sheet.row + 1, 0, str(missing), sheet.book.wrapped)
        sheet.row += 3
        return
    width, height = (int.from_bytes(png[at : at + 4], "big") for at in (16, 20))
    scale = 940 / width
    options = {
        "image_data": BytesIO(png), "x_scale": scale, "y_scale": scale, "description": figure.alt,
        "object_position": 2,
    }  # fmt: skip
    sheet.sheet.insert_image(sheet.row + 1, 0, "line.png", options)
    # Excel's rows are 20 pixels high, and a picture's pixels 96 to the inch of its own 144.
    sheet.row += 3 + int(height * scale / 20)


def _charts(sheet: Sheet, r: Response, *, several: bool) -> None:
    """Write what charts are of, as computed, and the charts beside each other."""
    say, book = sheet.book.say, sheet.book
    states = [say.state(s) for s in r.demand.states]
    charts = []
    for keys in CHARTED:
        rows = []
        for key in keys:
            q = QUANTITIES[key]
            values = np.asarray(q.values(r)) / q.factor
            most = [float(np.nanmax(np.abs(v))) if np.isfinite(v).any() else np.nan for v in values]
            if np.isfinite(most).any():
                rows.append((q, most))
        if rows:
            charts.append(rows)
    if not charts:
        return
    title = say("as computed, largest of its parts")
    _words(
        sheet, (f"{r.line.name}: {title}" if several else title, say("unit"), *states), bold=True
    )
    head, placed = sheet.row, []
    for rows in charts:
        start = sheet.row
        for q, most in rows:
            sheet.sheet.write_string(sheet.row, 0, say.name(q.key), book.plain)
            sheet.sheet.write_string(sheet.row, 1, q.unit_name, book.plain)
            for k, value in enumerate(most):
                if np.isfinite(value):
                    sheet.sheet.write_number(sheet.row, 2 + k, value, book.known)
            sheet.row += 1
        placed.append((start, sheet.row, rows[0][0].unit_name))
    sheet.row += 1
    last = column(1 + len(states))
    where = f"'{sheet.name}'!"
    for k, (start, end, unit) in enumerate(placed):
        chart = book.file.add_chart({"type": "column"})
        for row in range(start, end):
            chart.add_series({
                "name": f"={where}$A${row + 1}",
                "categories": f"={where}$C${head}:${last}${head}",
                "values": f"={where}$C${row + 1}:${last}${row + 1}",
            })  # fmt: skip
        chart.set_y_axis({"name": unit, "major_gridlines": {"visible": True}})
        chart.set_legend({"position": "bottom"})
        chart.set_size({"width": 560, "height": 300})
        sheet.sheet.insert_chart(sheet.row + 16 * (k // 2), 0 if k % 2 == 0 else 2, chart,
                                 {"x_offset": 5})  # fmt: skip
    sheet.row += 16 * ((len(placed) + 1) // 2)
