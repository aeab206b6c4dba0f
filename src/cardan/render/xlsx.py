"""A workbook being written: its formats, its sheets, the names of its cells.

It remembers every input as it was written, so that the workbook itself can show whether what
`cardan` computed from them still holds.
"""

import re
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, TypeAlias

import numpy as np

from cardan.core.arrays import FloatArray
from cardan.core.verdict import Verdict
from cardan.render.i18n import Translator

FIRST_STATE_COLUMN = 4
"""Number of the first state's column: E."""

EXCEL_EMPTY_TEXT_FORMULA = '""'
"""No number, in a formula."""

CellValue: TypeAlias = float | str | None
"""A value, a formula (it begins with =), or nothing."""

CellValidation: TypeAlias = dict[str, Any]
"""What a cell may hold, as XlsxWriter takes it."""

NOT_COMPUTED_PLACEHOLDER = -1e-300
"""Stands for a result that is not computed yet, until the file is written."""

CHANGED_INPUT_COUNT_CELL_NAME = "changed_inputs"
"""Name of the cell that counts the inputs that are not what they were written as."""

CHANGED_LIMIT_COUNT_CELL_NAME = "changed_limits"
"""Name of the cell that counts the bounds of limits that are not what they were written as."""

INFINITY_CELL_VALUE = 1e99
"""In place of an infinite value, which no cell can hold."""

NUMBER_FORMAT = f'[>={INFINITY_CELL_VALUE:.0e}]"∞";0.000'
"""How a number is shown that may be infinite."""

SHORT_NUMBER_FORMAT = f'[>={INFINITY_CELL_VALUE:.0e}]"∞";[>=100]0.0;0.000'
"""How a number that may be infinite is shown where it stands among texts."""

UNKNOWN_NUMBER_CELL_TEXT = "?"
"""In place of an unknown number that nothing may replace."""

ALLOW_POSITIVE: CellValidation = {"validate": "decimal", "criteria": ">", "value": 0}
ALLOW_NON_NEGATIVE: CellValidation = {"validate": "decimal", "criteria": ">=", "value": 0}
ALLOW_ANY_SIGN: CellValidation = {"validate": "decimal", "criteria": ">=", "value": -1e12}
ALLOW_SHARE: CellValidation = {
    "validate": "decimal",
    "criteria": "between",
    "minimum": 0.01,
    "maximum": 1,
}
ALLOW_SLOPE_DEG: CellValidation = {
    "validate": "decimal",
    "criteria": "between",
    "minimum": -60,
    "maximum": 60,
}
ALLOW_PHASE_DEG: CellValidation = {
    "validate": "decimal",
    "criteria": "between",
    "minimum": -180,
    "maximum": 180,
}
ALLOW_ZERO_TO_ONE: CellValidation = {
    "validate": "decimal",
    "criteria": "between",
    "minimum": 0,
    "maximum": 1,
}
ALLOW_FRICTION_COEFFICIENT: CellValidation = {
    "validate": "decimal",
    "criteria": "between",
    "minimum": 0,
    "maximum": 2,
}


@dataclass(frozen=True)
class _OriginalInput:
    """Cells that may be changed, as they were written."""

    label: str
    cell_range: str
    cells: tuple[CellValue, ...]


class WorkbookWriter:
    """A workbook being written, its formats, its inputs and the names of its cells."""

    def __init__(self, file: Any, say: Translator) -> None:
        self.file, self.say = file, say
        self.names: set[str] = set()
        self.sheets: set[str] = set()
        self.inputs: list[_OriginalInput] = []
        self.bounds: list[_OriginalInput] = []
        base = {"font_name": "Calibri", "font_size": 10, "valign": "top"}

        def style(**more: object) -> Any:
            return file.add_format({**base, **more})

        self.plain = style()
        self.wrapped = style(font_color="#55606D", font_size=9)
        self.title = style(bold=True, font_size=14)
        self.head = style(bold=True, bottom=1, text_wrap=True)
        self.section = style(bold=True, bg_color="#E3EAF1")
        self.heads = style(bold=True, bg_color="#E3EAF1", align="right", text_wrap=True)
        self.input = style(
            bg_color="#FFF8DC",
            font_color="#0000AA",
            border=1,
            border_color="#D5C98F",
            num_format="0.######",
        )
        self.formula = style(num_format="0.0000")
        self.result = style(num_format=NUMBER_FORMAT, bold=True)
        self.exact = style(num_format="0.000", italic=True, font_color="#55606D")
        self.known = style(num_format=NUMBER_FORMAT, italic=True, font_color="#55606D")
        self.count = style(num_format="0", align="left")
        self.short = style(num_format=SHORT_NUMBER_FORMAT, align="left")
        self.verdict = style(bold=True, align="center")
        self.margin = style(num_format="0.0%", align="left")
        self.graded: dict[Verdict, Any] = {
            "fail": file.add_format({"bg_color": "#F6C9C4", "font_color": "#8E1B12"}),
            "warn": file.add_format({"bg_color": "#FBE7B2", "font_color": "#6B4A00"}),
            "incomplete": file.add_format({"bg_color": "#E6D5F0", "font_color": "#5B2A77"}),
            "pass": file.add_format({"bg_color": "#D3F0DA", "font_color": "#13602A"}),
        }
        self.stale_mark = style(bold=True, font_color="#8E1B12")
        self.stale = file.add_format({"bg_color": "#E8EAED", "font_color": "#55606D"})

    def add_sheet(self, name: str) -> "SheetWriter":
        """Return a new sheet."""
        name = self._free_sheet_name(re.sub(r"[\[\]:*?/\\']", " ", name))
        sheet = self.file.add_worksheet(name)
        sheet.set_landscape()
        sheet.set_paper(9)  # A4
        sheet.fit_to_pages(1, 0)
        sheet.hide_gridlines(2)
        return SheetWriter(self, sheet, name)

    def _free_sheet_name(self, name: str) -> str:
        """Return a name that no sheet has yet, as long as a sheet's may be."""
        free, count = name[:31], 1
        while free.casefold() in self.sheets:
            count += 1
            end = f" {count}"
            free = name[: 31 - len(end)] + end
        self.sheets.add(free.casefold())
        return free

    def define_cell_name(self, name: str, place: str) -> None:
        """Give cells a name, unless others have it: a second limit has a second row."""
        if name.casefold() not in self.names:
            self.names.add(name.casefold())
            self.file.define_name(name, f"={place}")

    def remember_original_bounds(
        self, label: str, cell_range: str, cells: tuple[CellValue, ...]
    ) -> None:
        """Remember the bounds of a limit as they are written."""
        self.bounds.append(_OriginalInput(label, cell_range, cells))

    def write_original_inputs(self) -> None:
        """Write every input as it was once more, next to how many of its cells have changed.

        Cells are compared one by one, so no change can hide behind another. A formula that
        stands in an input stands here too: its own inputs are compared by themselves.
        """
        say = self.say
        sheet = self.add_sheet(say("As written"))
        sheet.sheet.set_column(0, 0, 60)
        sheet.sheet.set_column(1, FIRST_STATE_COLUMN + 12, 11)
        about = say("What cardan computed from these inputs holds while none is changed.")
        sheet.title(say("Inputs as they were written"), (about,))
        for title, counted, name, originals in (
            (say("Inputs"), say("inputs changed"), CHANGED_INPUT_COUNT_CELL_NAME, self.inputs),
            (say("Limits"), say("limits changed"), CHANGED_LIMIT_COUNT_CELL_NAME, self.bounds),
        ):
            total = sheet.row
            sheet.section(title, ["", say("changed"), "", "", say("as written")])
            first = sheet.row + 1
            for one in originals:
                _write_original(sheet, one)
            sheet.sheet.write_string(total, 0, counted, self.plain)
            sheet.sheet.write_formula(
                total, 1, f"=SUM(B{first}:B{max(first, sheet.row)})", self.plain, 0
            )
            self.define_cell_name(name, f"'{sheet.name}'!$B${total + 1}")
            sheet.row += 1
        sheet.sheet.freeze_panes(0, 1)


class SheetWriter:
    """A sheet being written from top to bottom."""

    def __init__(self, book: WorkbookWriter, sheet: Any, name: str) -> None:
        self.book, self.sheet, self.name, self.row = book, sheet, name, 0

    def title(self, text: str, notes: Sequence[str] = ()) -> None:
        """Write the sheet's title and what to know about it."""
        self.sheet.write_string(self.row, 0, text, self.book.title)
        for note in notes:
            self.row += 1
            self.sheet.write_string(self.row, 0, note, self.book.wrapped)
        self.row += 2

    def section(self, text: str, heads: Sequence[str] = ()) -> None:
        """Write a heading over the rows that follow."""
        self.row += 1
        width = max(FIRST_STATE_COLUMN + 1, len(heads))
        for k in range(width):
            said = text if k == 0 else heads[k] if k < len(heads) else ""
            style = self.book.heads if k >= FIRST_STATE_COLUMN else self.book.section
            self.sheet.write_string(self.row, k, said, style)
        self.row += 1

    def write_stale_mark(self, column: int) -> None:
        """Write what says, once an input is changed, that values are of the inputs as exported."""
        said = self.book.say("stale: computed for the inputs as exported")
        self.sheet.write_formula(
            self.row, column, f'=IF({CHANGED_INPUT_COUNT_CELL_NAME}>0,"{said}","")',
            self.book.stale_mark, "",
        )  # fmt: skip

    def grey_once_stale(self, row: int, column: int, last_row: int, last_column: int) -> None:
        """Show cells as stale once an input is changed."""
        if last_row >= row:
            self.sheet.conditional_format(
                row, column, last_row, last_column,
                {
                    "type": "formula",
                    "criteria": f"={CHANGED_INPUT_COUNT_CELL_NAME}>0",
                    "format": self.book.stale,
                },
            )  # fmt: skip

    def write_row(
        self,
        label: str,
        unit: str,
        cells: Sequence[CellValue],
        *,
        style: Any,
        texts: tuple[str, str] = ("", ""),
        values: FloatArray | None = None,
        name: str = "",
        allow: CellValidation | None = None,
        first: int = FIRST_STATE_COLUMN,
    ) -> int:
        """Write a row of cells with label, unit and two texts; return its number from 1.

        `values` are what formulas give for the inputs written, `name` names the cells, and
        `allow` says what may be typed into them.
        """
        row, sheet = self.row, self.sheet
        for k, text in enumerate((label, unit, *texts)):
            if text:
                sheet.write_string(row, k, text, self.book.plain if k < 2 else self.book.wrapped)
        for k, cell in enumerate(cells):
            if isinstance(cell, str) and cell.startswith("="):
                sheet.write_formula(row, first + k, cell, style, _cached_result(values, k))
            elif isinstance(cell, str):
                sheet.write_string(row, first + k, cell, style)
            elif cell is None or not np.isfinite(cell):
                sheet.write_blank(row, first + k, None, style)
            else:
                sheet.write_number(row, first + k, float(cell), style)
        last = first + max(len(cells), 1) - 1
        start, end = (f"${column_letters(k)}${row + 1}" for k in (first, last))
        if allow:
            place = f"'{self.name}'!{start}:{end}"
            self.book.inputs.append(_OriginalInput(f"{self.name}: {label}", place, tuple(cells)))
            sheet.data_validation(
                row,
                first,
                row,
                last,
                {
                    "ignore_blank": True,
                    "error_title": "cardan",
                    **allow,
                    "error_message": f"{label[:120]}: {_allowed_text(allow)}",
                },
            )
        if name:
            here = start if start == end else f"{start}:{end}"
            self.book.define_cell_name(name, f"'{self.name}'!{here}")
        self.row += 1
        return row + 1


def _write_original(sheet: SheetWriter, one: _OriginalInput) -> None:
    """Write cells as they were written, and how many of them are no longer so."""
    row = sheet.row + 1
    end = column_letters(FIRST_STATE_COLUMN + len(one.cells) - 1)
    here = f"{column_letters(FIRST_STATE_COLUMN)}{row}:{end}{row}"
    number = f"ISNUMBER({one.cell_range})<>ISNUMBER({here})"
    changed = f"=SUMPRODUCT(--((({one.cell_range}<>{here})+({number}))>0))"
    sheet.write_row(one.label, "", one.cells, style=sheet.book.exact)
    sheet.sheet.write_formula(row - 1, 1, changed, sheet.book.plain, 0)


def _cached_result(values: FloatArray | None, k: int) -> float | str:
    """Return the result that a formula's cell shows before anything is computed anew."""
    if values is None:
        return NOT_COMPUTED_PLACEHOLDER
    if np.isposinf(values[k]):
        return INFINITY_CELL_VALUE
    return float(values[k]) if np.isfinite(values[k]) else ""


def _allowed_text(check: CellValidation) -> str:
    """Return what a cell may hold, in signs."""
    if "minimum" in check:
        return f"{check['minimum']} … {check['maximum']}"
    return f"{check['criteria']} {check['value']}"


def column_letters(number: int) -> str:
    """Return the letters of a column, 0 is A."""
    letters = ""
    number += 1
    while number:
        number, rest = divmod(number - 1, 26)
        letters = chr(65 + rest) + letters
    return letters
