"""Sheet of all criteria of a workbook: each row of limits where it is worst, and its rank.

The front's table of what decides reads this sheet, so that it follows inputs and limits. Rows
of one limit on one line stand together: only the worst of them has a rank, as in reports.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from cardan.approval.approval import Approval
from cardan.checks.quantities.registry import QUANTITIES
from cardan.core.verdict import MARGIN_TOLERANCE, Check, CheckGrade, Limit
from cardan.documents.workbook_limits import LimitSheet, WrittenLimit, colour_verdict_cells
from cardan.render.i18n import Translator
from cardan.render.phrases import (
    check_location,
    grade_text,
    limit_sense_symbol,
    worst_check_per_limit,
)
from cardan.render.xlsx import (
    CHANGED_INPUT_COUNT_CELL_NAME,
    CHANGED_LIMIT_COUNT_CELL_NAME,
    INFINITY_CELL_VALUE,
    NOT_COMPUTED_PLACEHOLDER,
    SheetWriter,
    WorkbookWriter,
)

COLUMNS = ("criterion", "where it is worst", "value", "", "bound", "unit", "margin", "verdict",
           "basis", "order", "rank", "margin, in words")  # fmt: skip
"""Heads of the sheet; the front shows the first eight."""

MARGIN_COLUMN = "L"
"""Where the margin stands as the front shows it: in words where it is more than its limit."""

COLUMN_WIDTHS_CHARACTERS = (52, 44, 12, 8, 12, 10, 12, 14, 14, 12, 12, 14)

_GRADE_ORDER: dict[CheckGrade, int] = {"fail": -30_000, "warn": -20_000, "pass": -10_000}
"""Of a grade; the margin, cut at 1000 limits, is added to it."""

_AS_EXPORTED = f"{CHANGED_INPUT_COUNT_CELL_NAME}+{CHANGED_LIMIT_COUNT_CELL_NAME}=0"


@dataclass(frozen=True, kw_only=True)
class CriteriaSheet:
    """Where the criteria stand: the rows of checks as exported, and those that follow."""

    name: str
    exported_rows: tuple[int, ...]
    exported_cells: tuple[tuple[str | float, ...], ...]
    exported_checks: tuple[Check, ...]
    first: int
    last: int

    def formula_of_place(self, place: int, column: str) -> str:
        """Return the formula for what stands at a place of the ranking, from 0.

        As exported it is what `cardan` found, with its whole occasion.
        """
        live = f"INDEX({self._rows(column)},MATCH({self._rank(place)},{self._rows('K')},0))"
        then = f'IFERROR({live},"")'
        if place < len(self.exported_rows):
            now = f"'{self.name}'!${column}${self.exported_rows[place]}"
        else:
            now = '""'
        # An empty cell is no number where a text belongs.
        text = "" if column in ("C", "E", MARGIN_COLUMN) else '&""'
        return f"=IF({_AS_EXPORTED},{now},{then}){text}"

    def _rank(self, place: int) -> str:
        return f"SMALL({self._rows('K')},{place + 1})"

    def _rows(self, column: str) -> str:
        return f"'{self.name}'!${column}${self.first}:${column}${self.last}"


def write_criteria_sheet(
    book: WorkbookWriter, of: Approval, judged: Sequence[LimitSheet], *, places: int
) -> CriteriaSheet:
    """Write every row of limits where it is worst, and the first `places` as exported."""
    say, several = book.say, len(of.line_responses) > 1
    sheet = book.add_sheet(say("Criteria"))
    for k, wide in enumerate(COLUMN_WIDTHS_CHARACTERS):
        sheet.sheet.set_column(k, k, wide)
    sheet.title(
        say("Criteria, each where it is worst"),
        (
            say("They follow inputs and limits; what only cardan computes is stale once an input "
                "is changed, and has no rank."),
            say("The order is by verdict, then by margin."),
        ),
    )  # fmt: skip
    heads = [say(head) if head else "" for head in COLUMNS]
    sheet.section(say("What decides, as computed"), ["", *heads[1:8]])
    exported = worst_check_per_limit(of.checks)[:places]
    rows = tuple(sheet.row + 1 + k for k in range(len(exported)))
    cells = tuple(_write_exported(sheet, check, several=several) for check in exported)
    sheet.section(heads[0], ["", *heads[1:]])
    first = sheet.row + 1
    groups: dict[tuple[str, Limit], list[WrittenLimit]] = {}
    for written in (w for j in judged for w in j.written):
        groups.setdefault((written.of.line, written.of.limit), []).append(written)
    for group in groups.values():
        orders = f"$J${sheet.row + 1}:$J${sheet.row + len(group)}"
        for written in group:
            _write_following(sheet, written, orders, several=several)
    last = max(sheet.row, first)
    place = first - 1, 7, last - 1, 7
    colour_verdict_cells(sheet.sheet, book, place)
    sheet.sheet.freeze_panes(0, 1)
    return CriteriaSheet(
        name=sheet.name, exported_rows=rows, exported_cells=cells,
        exported_checks=tuple(exported), first=first, last=last,
    )  # fmt: skip


def _write_exported(sheet: SheetWriter, check: Check, *, several: bool) -> tuple[str | float, ...]:
    """Write a check as `cardan` found it; return its cells."""
    say, book, q = sheet.book.say, sheet.book, QUANTITIES[check.quantity]
    value, bound, margin = (
        min(max(number, -INFINITY_CELL_VALUE), INFINITY_CELL_VALUE)
        for number in (check.value / q.si_factor, check.bound / q.si_factor, check.margin)
    )
    cells = (
        say.name(q.key), check_location(check, say, several=several), value,
        limit_sense_symbol(check, say), bound, q.unit_symbol, margin, grade_text(check.grade, say),
        "", "", "", margin_in_words(margin, say),
    )  # fmt: skip
    for column, cell in enumerate(cells):
        style = book.margin if column in (6, 11) else book.short
        if isinstance(cell, str):
            sheet.sheet.write_string(sheet.row, column, cell, book.plain)
        else:
            sheet.sheet.write_number(sheet.row, column, cell, style)
    sheet.row += 1
    return cells


def _write_following(
    sheet: SheetWriter, written: WrittenLimit, orders: str, *, several: bool
) -> None:
    """Write where a row of limits is worst, as its sheet has it, and its rank in its group."""
    say, book, of, judged = sheet.book.say, sheet.book, written.of, written.sheet
    worst, verdict = of.smallest_margin, of.verdict
    row, q = sheet.row + 1, QUANTITIES[of.limit.quantity]
    place, margin, value, bound = (written.cell(judged.decides + k) for k in range(4))
    heads = (
        f"'{judged.sheet.name}'!$E${written.head_row}"
        f":{_column_of(written.cell(judged.at - 1))}${written.head_row}"
    )
    label = of.label if of.line_in_label else say.join(of.line if several else "", of.label)
    sense = say("outside") if of.limit.band else {"<=": "≤", ">=": "≥"}[of.limit.sense]
    sheet.sheet.write_string(row - 1, 0, label, book.plain)
    sheet.sheet.write_string(row - 1, 3, sense, book.plain)
    sheet.sheet.write_string(row - 1, 5, q.unit_symbol, book.plain)
    computed = say("not evaluated" if np.isnan(of.values).all() else "as computed")
    changed = say("live" if of.live_formulas else "stale" if worst is not None else "not evaluated")
    warns = "TRUE" if of.limit.band else f"ISNUMBER({written.cell(2)})"
    fail, warn, good = (_GRADE_ORDER[g] for g in ("fail", "warn", "pass"))
    grade = (
        f'IF($H{row}="{grade_text("fail", say)}",{fail},'
        f'IF(OR($H{row}="{grade_text("warn", say)}",AND({warns},$G{row}<-{MARGIN_TOLERANCE:.0e})),'
        f"{warn},{good}))"
    )
    at = "" if worst is None else judged.heads[worst[0]]
    in_words = "" if worst is None else margin_in_words(worst[1], say)
    unknown = NOT_COMPUTED_PLACEHOLDER
    order = f"{grade}+MAX(-1000,MIN(1000,$G{row}))+ROW()*1E-9"
    formulas = (
        (1, f'IF(ISNUMBER({place}),INDEX({heads},1,{place})&"","")', book.plain, at),
        (2, value, book.short, unknown),
        (4, bound, book.short, unknown),
        (6, margin, book.margin, unknown),
        (7, written.cell(judged.at), book.verdict, grade_text(verdict, say) if verdict else ""),
        (8, f'IF({CHANGED_INPUT_COUNT_CELL_NAME}>0,"{changed}","{computed}")', book.plain,
         computed),
        (9, f'IF(ISNUMBER($G{row}),{order},"")', book.wrapped, unknown),
        (11, f'IF(ISNUMBER($G{row}),IF($G{row}>1,"{say("ample")}",'
             f'IF($G{row}<-1,"{say("far beyond")}",$G{row})),"")', book.margin, in_words),
        (10, f'IF(ISNUMBER($J{row}),IF($J{row}=MIN({orders}),$J{row},""),"")', book.wrapped,
         unknown),
    )  # fmt: skip
    for column, formula, style, cached in formulas:
        sheet.sheet.write_formula(row - 1, column, f"={formula}", style, cached)
    sheet.row += 1


def margin_in_words(margin: float, say: Translator) -> str | float:
    """Return a margin, or the words for it where it is more than its whole limit."""
    return say("ample") if margin > 1 else say("far beyond") if margin < -1 else margin


def _column_of(cell: str) -> str:
    """Return the letters of a cell's column, with their sign."""
    return cell.rpartition("!")[2].rpartition("$")[0]
