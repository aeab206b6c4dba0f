"""A workbook's front: the verdict, what decides, the line in the state that does, charts.

Verdict, margin and what decides follow inputs and limits. What only `cardan` computes is
marked once an input is changed.
"""

from collections.abc import Mapping, Sequence
from io import BytesIO

import numpy as np

from cardan.approval.approval import Approval
from cardan.checks.line_response import LineResponse
from cardan.checks.quantities.registry import QUANTITIES
from cardan.core.errors import MissingDependencyError
from cardan.core.verdict import Check, Verdict
from cardan.documents.first_screen import criteria_count_text
from cardan.documents.line_drawing import has_known_geometry, side_view_in_state, state_to_draw
from cardan.documents.workbook_criteria import MARGIN_COLUMN, CriteriaSheet
from cardan.documents.workbook_limits import LimitSheet, colour_verdict_cells, write_verdict
from cardan.render.phrases import not_given_sentence, verdict_text
from cardan.render.xlsx import (
    CHANGED_INPUT_COUNT_CELL_NAME,
    CHANGED_LIMIT_COUNT_CELL_NAME,
    SheetWriter,
    WorkbookWriter,
    column_letters,
)

CHART_QUANTITY_GROUPS = (
    ("torsional_acceleration", "inertia_drive_acceleration", "inertia_coast_acceleration"),
    ("centre_bearing_static", "centre_bearing_dynamic", "centre_bearing_peak"),
    ("joint_angle",),
)
"""Quantities that stand in a chart together, state by state."""

MAX_DECIDING_CHECKS = 3

COLUMN_WIDTHS_CHARACTERS = (46, 50, 14, 8, 14, 10, 12, 14)
"""Of the front's columns, in characters."""


def add_empty_summary_sheet(book: WorkbookWriter) -> SheetWriter:
    """Return the first sheet of a workbook, to be filled when its others are there."""
    sheet = book.add_sheet(book.say("Front"))
    for k, wide in enumerate(COLUMN_WIDTHS_CHARACTERS):
        sheet.sheet.set_column(k, k, wide)
    sheet.sheet.set_column(len(COLUMN_WIDTHS_CHARACTERS), len(COLUMN_WIDTHS_CHARACTERS) + 12, 12)
    return sheet


def fill_summary_sheet(
    sheet: SheetWriter,
    of: Approval,
    judged: Sequence[LimitSheet],
    criteria: CriteriaSheet,
    texts: Mapping[Verdict, str],
) -> None:
    """Write the verdict and what decides, live, the line drawn, and charts."""
    say, book, several = sheet.book.say, sheet.book, len(of.line_responses) > 1
    sheet.title(of.application.title)
    write_verdict(sheet, sheet.row, judged, name="", texts=texts)
    sheet.row += 1
    _write_live_facts(sheet, judged, criteria)
    counts = criteria_count_text(of, say)
    facts = [
        (say("as computed"), f"{verdict_text(of, say)} ({counts})"),
        (say("Coverage"), say("{answered} of {asked} checks evaluated",
                              answered=of.coverage.evaluated, asked=of.coverage.total)),
        (say("Limits"), of.application.profile),
        *[(say("States"), told) for told in [not_given_sentence(of, say)] if told],
    ]  # fmt: skip
    for k, (name, said) in enumerate(facts):
        sheet.sheet.write_string(sheet.row, 0, name, book.plain)
        sheet.sheet.write_string(sheet.row, 1, said, book.plain)
        if k < 2:
            sheet.grey_once_stale(sheet.row, 0, sheet.row, 1)
            sheet.write_stale_mark(2)
        sheet.row += 1
    _write_deciding_checks(sheet, criteria)
    rows = criteria.exported_checks
    named = {c.line for c in rows}
    shown = next((r for r in of.line_responses if r.line.name in named), None)
    shown = shown or next(iter(of.line_responses), None)
    if shown is not None and has_known_geometry(shown):
        _insert_drawing(sheet, shown, *state_to_draw(shown, rows))
    for r in of.line_responses:
        _insert_charts(sheet, r, several=several)


def _write_live_facts(
    sheet: SheetWriter, judged: Sequence[LimitSheet], criteria: CriteriaSheet
) -> None:
    """Write the margin of what decides, and how much of the workbook is changed and stale."""
    say, book = sheet.book.say, sheet.book
    margin = criteria.exported_cells[0][-1] if criteria.exported_cells else "-"
    stale = "+".join(
        f'SUMPRODUCT(--({j.verdict_range}="{say("stale")}"))' for j in judged if j.verdict_range
    )
    changed = f"{CHANGED_INPUT_COUNT_CELL_NAME}+{CHANGED_LIMIT_COUNT_CELL_NAME}"
    for label, formula, style, cached in (
        (say("smallest margin"), criteria.formula_of_place(0, MARGIN_COLUMN), book.margin, margin),
        (say("inputs and limits changed"), f"={changed}", book.count, 0),
        (say("checks stale: run cardan again"), f"={stale or 0}", book.count, 0),
    ):
        sheet.sheet.write_string(sheet.row, 0, label, book.plain)
        sheet.sheet.write_formula(sheet.row, 1, formula, style, cached)
        sheet.row += 1


def _write_deciding_checks(sheet: SheetWriter, criteria: CriteriaSheet) -> None:
    """Write the checks that decide, the worst first: as exported, or as the workbook has them."""
    say, book, exported = sheet.book.say, sheet.book, criteria.exported_cells
    heads = (say("What decides"), say("where it is worst"), say("value"), "", say("bound"),
             say("unit"), say("margin"), say("verdict"))  # fmt: skip
    _write_headings(sheet, heads)
    first = sheet.row
    styles = (book.plain, book.plain, book.short, book.plain, book.short, book.plain, book.margin,
              book.verdict)  # fmt: skip
    columns = [MARGIN_COLUMN if letter == "G" else letter for letter in "ABCDEFGH"]
    for place in range(MAX_DECIDING_CHECKS):
        for k, (letter, style) in enumerate(zip(columns, styles, strict=True)):
            cached = exported[place][ord(letter) - ord("A")] if place < len(exported) else ""
            formula = criteria.formula_of_place(place, letter)
            sheet.sheet.write_formula(sheet.row, k, formula, style, cached)
        sheet.row += 1
    last = len(styles) - 1
    colour_verdict_cells(sheet.sheet, book, (first, last, sheet.row - 1, last))
    sheet.row += 1


def _write_headings(sheet: SheetWriter, cells: Sequence[str]) -> None:
    """Write a row of headings."""
    for k, cell in enumerate(cells):
        sheet.sheet.write_string(sheet.row, k, cell, sheet.book.section)
    sheet.row += 1


def _insert_drawing(sheet: SheetWriter, r: LineResponse, s: int, at: Check | None) -> None:
    """Put the drawing of a line in a state, or at a check there, if it can be drawn."""
    from cardan.render.pdf import figure_png

    figure = side_view_in_state(r, sheet.book.say, s, at)
    sheet.sheet.write_string(sheet.row, 0, figure.title, sheet.book.head)
    sheet.write_stale_mark(1)
    sheet.row += 1
    try:
        png = figure_png(figure)
    except MissingDependencyError as missing:
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


def _insert_charts(sheet: SheetWriter, r: LineResponse, *, several: bool) -> None:
    """Write what charts are of, as computed, and the charts next to each other."""
    say, book = sheet.book.say, sheet.book
    states = [say.state(s) for s in r.demand.states]
    charts = []
    for keys in CHART_QUANTITY_GROUPS:
        rows = []
        for key in keys:
            q = QUANTITIES[key]
            values = np.asarray(q.values(r)) / q.si_factor
            most = [float(np.nanmax(np.abs(v))) if np.isfinite(v).any() else np.nan for v in values]
            if np.isfinite(most).any():
                rows.append((q, most))
        if rows:
            charts.append(rows)
    if not charts:
        return
    title = say("as computed, largest of its parts")
    sheet.write_stale_mark(0)
    sheet.row += 1
    _write_headings(sheet, (f"{r.line.name}: {title}" if several else title, say("unit"), *states))
    head, placed = sheet.row, []
    for rows in charts:
        start = sheet.row
        for q, most in rows:
            sheet.sheet.write_string(sheet.row, 0, say.name(q.key), book.plain)
            sheet.sheet.write_string(sheet.row, 1, q.unit_symbol, book.plain)
            for k, value in enumerate(most):
                if np.isfinite(value):
                    sheet.sheet.write_number(sheet.row, 2 + k, value, book.known)
            sheet.row += 1
        placed.append((start, sheet.row, rows[0][0].unit_symbol))
    sheet.grey_once_stale(head, 2, sheet.row - 1, 1 + len(states))
    sheet.row += 1
    last = column_letters(1 + len(states))
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
