"""A workbook's limits: each a row of values next to its bounds, with the verdict it comes to.

A row is graded by formulas against bounds that may be changed. What `cardan` computed stands
next to it in every row and is what counts while no input of the workbook is changed, so nothing
here can disagree with `cardan check`. Once an input is changed it is stale: then the rows
that formulas follow count by those, the others say that they are stale, and with them the
verdict of the workbook, unless a live row fails already. So does a live row in a state whose
geometry is that of another torque. Margins, in columns of their own, follow the same rule.
"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from math import copysign, isinf
from typing import Any

import numpy as np

from cardan.checks.quantities.registry import QUANTITIES
from cardan.core.arrays import BoolArray, FloatArray
from cardan.core.units import deg
from cardan.core.verdict import (
    MARGIN_TOLERANCE,
    VERDICTS,
    Limit,
    Verdict,
    worst_verdict,
)
from cardan.render.phrases import citation, grade_text, verdict_word
from cardan.render.xlsx import (
    CHANGED_INPUT_COUNT_CELL_NAME,
    FIRST_STATE_COLUMN,
    INFINITY_CELL_VALUE,
    NOT_COMPUTED_PLACEHOLDER,
    CellValue,
    SheetWriter,
    WorkbookWriter,
    column_letters,
)

MARGIN_DIGITS = 12
"""Decimals of a margin: of states that are alike the first decides, whatever rounding does."""

DECIDING_COLUMNS = ("column that decides", "smallest margin", "value that decides", "bound")
"""Heads of the columns behind the margins of a row."""


@dataclass(frozen=True, kw_only=True)
class LiveFormulas:
    """Formulas that follow the inputs, in the columns of a row of limits.

    `cell_formulas` are what the row shows and `values` what they give for the inputs as written, in
    the unit shown; § stands for a column's letter in
    `largest_angle_cell`, the largest joint angle in
    deg, and in `zero_if_idle_cells`, which are 0 where no limit applies. `approximation` names
    one: where it is "" the formulas are as exact as `cardan`. A cell holds the word for stale where
    its state is no longer what the formula stands on.
    """

    cell_formulas: tuple[str, ...]
    values: FloatArray
    largest_angle_cell: str
    zero_if_idle_cells: tuple[str, ...]
    approximation: str
    may_be_stale: bool = False


@dataclass(frozen=True, kw_only=True)
class LimitRow:
    """One limit and the values of one part that it is held against, SI; nan where none is.

    `may_apply` is which columns it may apply to, `missing` where it applies and got no number,
    for want of `missing_inputs`.
    """

    label: str
    limit: Limit
    values: FloatArray
    may_apply: BoolArray
    missing: BoolArray
    missing_inputs: tuple[str, ...] = ()
    name: str = ""
    live_formulas: LiveFormulas | None = None
    line: str = ""
    line_in_label: bool = False
    validity_margin: FloatArray | None = None
    """Of each value, as a check has it; None where all hold."""

    @property
    def is_lower_bound(self) -> BoolArray:
        """Which values are lower bounds, and warn at least."""
        if self.validity_margin is None:
            return np.zeros(self.values.shape, dtype=bool)
        return self.validity_margin < -MARGIN_TOLERANCE

    @property
    def verdict(self) -> Verdict | None:
        """What it comes to; None if nothing applies, or only what is not required."""
        found: list[Verdict] = [self.limit.grade(v) for v in self.values[~np.isnan(self.values)]]
        if self.is_lower_bound.any():
            found.append("warn")
        if self.limit.required and self.missing.any():
            found.append("incomplete")
        return worst_verdict(found) if found else None

    @property
    def smallest_margin(self) -> tuple[int, float] | None:
        """Column and size of the smallest margin, as its formulas find them; None if none."""
        q = QUANTITIES[self.limit.quantity]
        fails = self.verdict == "fail"
        if np.isnan(self.values).all():
            return None
        shown = np.array([_cell_number(v) for v in self.values / q.si_factor])
        shown = np.abs(shown) if q.signed else shown
        if self.limit.band:
            low, high = (_cell_number(edge / q.si_factor) for edge in self.limit.band)
            margins = np.maximum((low - shown) / low, (shown - high) / high)
        else:
            first, last = self.limit.normal, self.limit.maximum
            bound = last if first is None or (fails and last is not None) else first
            assert bound is not None  # a limit has a bound
            bound = _cell_number(bound / q.si_factor)
            free = bound - shown if self.limit.sense == "<=" else shown - bound
            margins = free / (abs(bound) or self.limit.margin_scale / q.si_factor)
        if self.validity_margin is not None and not fails:
            margins = np.where(
                self.is_lower_bound, np.minimum(margins, self.validity_margin), margins
            )
        margins = margins.round(MARGIN_DIGITS)
        worst = int(np.nanargmin(margins))
        return worst, float(margins[worst])


@dataclass(frozen=True, kw_only=True)
class WrittenLimit:
    """A row of limits as it stands in its sheet, with the row of the heads over it."""

    sheet: "LimitSheet"
    row: int
    head_row: int
    of: LimitRow

    def cell(self, column: int) -> str:
        """Return the reference to a cell of the row from other sheets."""
        return f"'{self.sheet.sheet.name}'!${column_letters(column)}${self.row}"


class LimitSheet:
    """The rows of limits of one sheet, and its verdict."""

    def __init__(self, sheet: SheetWriter, columns: Sequence[str]) -> None:
        self.sheet, self.book, self.say = sheet, sheet.book, sheet.book.say
        self.heads, self.count = columns, max(len(columns), 1)
        self.at = FIRST_STATE_COLUMN + self.count
        self.beside = self.at + 2
        self.margins = self.beside + self.count
        self.decides = self.margins + self.count
        self.head_row = 0
        self.rows: list[int] = []
        self.written: list[WrittenLimit] = []
        self.found: list[Verdict] = []
        sheet.sheet.set_column(self.at, self.at, 13)
        sheet.sheet.set_column(self.at + 1, self.at + 1, 24)
        sheet.sheet.set_column(self.beside, self.decides + len(DECIDING_COLUMNS), 12)

    @property
    def verdict_range(self) -> str:
        """The cells that hold the rows' verdicts; "" where there are none."""
        if not self.rows:
            return ""
        letter = column_letters(self.at)
        return f"'{self.sheet.name}'!${letter}${min(self.rows)}:${letter}${max(self.rows)}"

    def write_section(self, text: str) -> None:
        """Write a heading over the rows that follow."""
        say = self.say
        heads = [
            "", say("unit"), say("normal"), say("maximum"), *self.heads, say("verdict"), "",
            *(
                say("{state}, as computed", state=head) if head else say("as computed")
                for head in self.heads
            ),
            *(say.join(head, say("margin")) for head in self.heads),
            *map(say, DECIDING_COLUMNS),
        ]  # fmt: skip
        self.sheet.section(text, heads)
        self.head_row = self.sheet.row

    def write_limit_row(self, of: LimitRow) -> None:
        """Write one limit: what it is held against, its bounds, its verdict, what was computed."""
        say, sheet, q = self.say, self.sheet.sheet, QUANTITIES[of.limit.quantity]
        row, live = self.sheet.row + 1, of.live_formulas
        letters = [column_letters(self.beside + k) for k in range(self.count)]
        if live:
            cells, style, shown = live.cell_formulas, self.book.result, live.values
        else:
            known = ~np.isnan(of.values) | of.missing
            cells = tuple(
                f'=IF({CHANGED_INPUT_COUNT_CELL_NAME}>0,"{say("stale")}",{letter}{row})'
                if there
                else ""
                for letter, there in zip(letters, known, strict=True)
            )
            style, shown = self.book.exact, None
        self.sheet.write_row(
            of.label, q.unit_symbol, cells, style=style, values=shown, name=of.name
        )
        self._bounds(row, of.label, of.limit, q.si_factor)
        for k, (value, missing) in enumerate(zip(of.values, of.missing, strict=True)):
            shown_as = (
                say("not evaluated") if missing else _finite_cell_value(float(value) / q.si_factor)
            )
            here = row - 1, self.beside + k
            if isinstance(shown_as, str):
                sheet.write_string(*here, shown_as, self.book.plain)
            elif not np.isnan(shown_as):
                sheet.write_number(*here, shown_as, self.book.known)
            if not live and not (isinstance(shown_as, float) and np.isnan(shown_as)):
                cell = cells[k]
                sheet.write_formula(
                    row - 1, FIRST_STATE_COLUMN + k, cell, self.book.known, shown_as
                )
        sheet.write_string(row - 1, self.at + 1, self._note(of), self.book.wrapped)
        self._verdict(row, of, q.si_factor)
        self._margins(row, of, q.si_factor)
        self._colours(row, of, q.si_factor)
        self.written.append(WrittenLimit(sheet=self, row=row, head_row=self.head_row, of=of))

    def _bounds(self, row: int, label: str, limit: Limit, factor: float) -> None:
        """Write the cells that hold a limit's bounds."""
        sheet = self.sheet.sheet
        cells: list[CellValue] = []
        for k, bound in enumerate(limit.band or (limit.normal, limit.maximum), 2):
            cells.append(None if bound is None else bound / factor)
            if bound is None:
                sheet.write_blank(row - 1, k, None, self.book.input)
            else:
                sheet.write_number(row - 1, k, bound / factor, self.book.input)
        sheet.write_comment(row - 1, 2, citation(limit.source, self.say), {"x_scale": 3})
        self.book.remember_original_bounds(
            f"{self.sheet.name}: {label}", f"'{self.sheet.name}'!$C${row}:$D${row}", tuple(cells)
        )

    def _note(self, of: LimitRow) -> str:
        """Return how a row comes by its values, or what it lacks."""
        say = self.say
        if of.missing.any():
            needs = ", ".join(say.translate_if_known(n) for n in of.missing_inputs)
            return say(
                "not evaluated (input missing: {needs})",
                needs=needs or say("a number that could not be computed"),
            )
        if of.is_lower_bound.any():
            return say("lower bound: rubber beyond its stop")
        if of.live_formulas is None:
            return say("as computed")
        if of.live_formulas.approximation:
            return say(
                "{method}; as computed counts",
                method=say.translate_if_known(of.live_formulas.approximation),
            )
        return ""

    # Verdicts

    def _verdict(self, row: int, of: LimitRow, factor: float) -> None:
        """Write what a row comes to, as computed and, once inputs are changed, live or stale."""
        first, last = (column_letters(self.beside + k) for k in (0, self.count - 1))
        block = f"${first}{row}:${last}{row}"
        lacking = f'SUMPRODUCT(--({block}="{self.say("not evaluated")}"))'
        bounded = bool(of.is_lower_bound.any())
        computed = self._graded(row, of.limit, factor, block, (), lacking, warns=bounded)
        live = of.live_formulas
        if live:
            values = (
                f"${column_letters(FIRST_STATE_COLUMN)}{row}:${column_letters(self.at - 1)}{row}"
            )
            asked = tuple(self._asked(of, live))
            none = "*".join((*asked, f"(1-ISNUMBER({values}))"))
            changed = self._graded(row, of.limit, factor, values, asked, f"SUMPRODUCT({none})")
            if live.may_be_stale:
                word, fails = self.say("stale"), f'"{grade_text("fail", self.say)}"'
                changed = (
                    f'IF(COUNTIF({values},"{word}")>0,'
                    f'IF({changed}={fails},{fails},"{word}"),{changed})'
                )
        elif not np.isnan(of.values).all():
            changed = f'"{self.say("stale")}"'
        else:
            changed = computed
        verdict = of.verdict
        if verdict:
            self.found.append(verdict)
        self.rows.append(row)
        self.sheet.sheet.write_formula(
            row - 1,
            self.at,
            f"=IF({CHANGED_INPUT_COUNT_CELL_NAME}>0,{changed},{computed})",
            self.book.verdict,
            grade_text(verdict, self.say) if verdict else "",
        )

    def _asked(self, of: LimitRow, live: LiveFormulas) -> Iterable[str]:
        """Yield, column by column, whether a live row's limit applies."""
        if not of.may_apply.all():
            yield "{" + ",".join(str(int(m)) for m in of.may_apply) + "}"
        if of.limit.above_angle is not None:
            yield f"({self._across(live.largest_angle_cell)}>{of.limit.above_angle / deg:.12g})"
        for reference in live.zero_if_idle_cells:
            # Where all is idle the limit applies to every column, and nothing is known.
            yield f"({self._across(reference)}<>0)"

    def _across(self, reference: str) -> str:
        """Return the cells of a reference in all columns."""
        sheet, _, cell = reference.rpartition("!")
        first, last = (
            cell.replace("§", f"${column_letters(FIRST_STATE_COLUMN + k)}$")
            for k in (0, self.count - 1)
        )
        return f"{sheet}!{first}:{last}" if sheet else f"{first}:{last}"

    def _graded(
        self, row: int, limit: Limit, factor: float, values: str, asked: tuple[str, ...],
        lacking: str, *, warns: bool = False,
    ) -> str:  # fmt: skip
        """Return the formula that grades values as `Limit.grade` does; it may warn at least."""
        say_grade, bounds = partial(grade_text, say=self.say), f"$C{row}:$D{row}"
        number = (*asked, f"ISNUMBER({values})")

        def past(which: str) -> str:
            held = "*".join((*number, _beyond_bound_formula(values, limit, which, factor)))
            return f"IF(ISNUMBER({which}),SUMPRODUCT({held})>0,FALSE)"

        if limit.band:
            within = "*".join((*number, _within_band_formula(values, limit, row)))
            fails, beyond = "FALSE", f"SUMPRODUCT({within})>0"
        else:
            fails, beyond = past(f"$D{row}"), past(f"$C{row}")
        beyond = "TRUE" if warns else beyond
        count = (
            f"SUMPRODUCT(--{number[0]})" if len(number) == 1 else f"SUMPRODUCT({'*'.join(number)})"
        )
        end = f'IF({count}=0,"",IF({beyond},"{say_grade("warn")}","{say_grade("pass")}"))'
        if limit.required:
            missing = f"{lacking}+({count}=0)*({self._ever(asked)})>0"
            end = f'IF({missing},"{say_grade("incomplete")}",{end})'
        return f'IF(COUNT({bounds})=0,"",IF({fails},"{say_grade("fail")}",{end}))'

    @staticmethod
    def _ever(asked: tuple[str, ...]) -> str:
        """Return whether a live row applies nowhere because all stands idle; 0 if unknown."""
        idle = [a for a in asked if a.endswith("<>0)")]
        return f"SUMPRODUCT({'*'.join((*idle, '1'))})=0" if idle else "0"

    # Margins

    def _margins(self, row: int, of: LimitRow, factor: float) -> None:
        """Write margins column by column as `Check.margin` has them, and the one that decides.

        Of a row that fails the margins are to its maximum, else to its normal bound, of lower
        bounds at most their validity margin.
        """
        place, _, value, bound = (
            f"${column_letters(self.decides + k)}{row}" for k in range(len(DECIDING_COLUMNS))
        )
        first, last = (column_letters(self.margins + k) for k in (0, self.count - 1))
        margins = f"${first}{row}:${last}{row}"
        normal, maximum = f"$C{row}", f"$D{row}"
        held = f"COUNT({normal}:{maximum})={2 if of.limit.band else 1}"
        if of.limit.band:
            edges = f"{value}/{normal}+{value}/{maximum}"
            chosen = f"IF(ISNUMBER({value}),IF({edges}<2,{normal},{maximum}),{normal})"
        else:
            fails = f'${column_letters(self.at)}{row}="{grade_text("fail", self.say)}"'
            chosen = f"IF(ISNUMBER({normal})*NOT({fails}),{normal},{maximum})"
            held = f"COUNT({normal}:{maximum})>0"
        for k in np.flatnonzero(of.may_apply).tolist():
            number = self._counted(row, k, of)
            asks = (f"ISNUMBER({number})", held, *self._asked_if_changed(of, k))
            left = _margin_formula(number, of.limit, row, bound, factor)
            if of.validity_margin is not None and of.is_lower_bound[k]:
                failed = f'${column_letters(self.at)}{row}="{grade_text("fail", self.say)}"'
                left = f"IF({failed},{left},MIN({left},{of.validity_margin[k]:.15g}))"
            left = f"ROUND({left},{MARGIN_DIGITS})"
            self._computed(
                row, self.margins + k, f'IF({"*".join(f"({a})" for a in asks)},{left},"")'
            )
        at = self.decides
        self._computed(row, at, f'IF(COUNT({margins})=0,"",MATCH(MIN({margins}),{margins},0))')
        self._computed(row, at + 1, f'IF(ISNUMBER({place}),INDEX({margins},{place}),"")')
        self._computed(row, at + 2, f'IF(ISNUMBER({place}),{self._counted(row, place, of)},"")')
        self._computed(row, at + 3, f'IF({held},{chosen},"")')

    def _computed(self, row: int, column: int, formula: str) -> None:
        """Write a formula that a spreadsheet computes when it opens the file."""
        style = self.book.margin if column <= self.decides + 1 else self.book.short
        if column == self.decides:
            style = self.book.wrapped
        self.sheet.sheet.write_formula(
            row - 1, column, f"={formula}", style, NOT_COMPUTED_PLACEHOLDER
        )

    def _counted(self, row: int, column: int | str, of: LimitRow) -> str:
        """Return the value that counts in a column, or in that whose number a cell holds."""

        def cell(first: int) -> str:
            if isinstance(column, int):
                return f"${column_letters(first + column)}{row}"
            last = column_letters(first + self.count - 1)
            return f"INDEX(${column_letters(first)}{row}:${last}{row},{column})"

        if of.live_formulas is None:
            return cell(FIRST_STATE_COLUMN)
        shown, computed = cell(FIRST_STATE_COLUMN), cell(self.beside)
        return f"IF({CHANGED_INPUT_COUNT_CELL_NAME}>0,{shown},{computed})"

    def _asked_if_changed(self, of: LimitRow, k: int) -> Iterable[str]:
        """Yield whether a live row applies in a column once inputs are changed."""
        live, letter = of.live_formulas, column_letters(FIRST_STATE_COLUMN + k)
        if live is None:
            return
        unchanged = f"{CHANGED_INPUT_COUNT_CELL_NAME}=0"
        if of.limit.above_angle is not None:
            angle = live.largest_angle_cell.replace("§", letter)
            yield f"({unchanged})+({angle}>{of.limit.above_angle / deg:.12g})>0"
        for reference in live.zero_if_idle_cells:
            yield f"({unchanged})+({reference.replace('§', letter)}<>0)>0"

    # Colours

    def _colours(self, row: int, of: LimitRow, factor: float) -> None:
        """Colour a row's values by what counts: as computed where the live ones approximate."""
        shown = column_letters(FIRST_STATE_COLUMN)
        if of.live_formulas and of.live_formulas.approximation:
            self._coloured(row, self.beside, of, factor, f"{CHANGED_INPUT_COUNT_CELL_NAME}=0")
            self._coloured(
                row, FIRST_STATE_COLUMN, of, factor, f"{CHANGED_INPUT_COUNT_CELL_NAME}>0"
            )
        else:
            self._coloured(row, FIRST_STATE_COLUMN, of, factor, f"ISNUMBER({shown}{row})")
        sheet = self.sheet.sheet
        sheet.conditional_format(
            row - 1,
            self.beside,
            row - 1,
            self.beside + self.count - 1,
            {
                "type": "formula",
                "criteria": f"={CHANGED_INPUT_COUNT_CELL_NAME}>0",
                "format": self.book.stale,
            },
        )

    def _coloured(self, row: int, first: int, of: LimitRow, factor: float, when: str) -> None:
        """Colour cells that hold a row's values, where its limit applies."""
        here, letter = f"{column_letters(first)}{row}", column_letters(self.beside)
        if of.live_formulas and of.limit.above_angle is not None:
            cell = of.live_formulas.largest_angle_cell.replace(
                "§", column_letters(FIRST_STATE_COLUMN)
            )
            asks = f"{cell}>{of.limit.above_angle / deg:.12g}"
        else:
            asks = f'{letter}{row}<>""'
        if of.limit.band:
            bad: Verdict = "fail" if of.limit.maximum is not None else "warn"
            rules: list[tuple[Verdict, str]] = [(bad, _within_band_formula(here, of.limit, row))]
        else:
            bounds: dict[Verdict, str] = {"fail": f"$D{row}", "warn": f"$C{row}"}
            rules = [
                (grade, f"ISNUMBER({bound}),{_beyond_bound_formula(here, of.limit, bound, factor)}")
                for grade, bound in bounds.items()
            ]
        last = first + self.count - 1
        rules.append(("pass", "TRUE"))
        each: list[tuple[Verdict, str, int, int]] = [
            (grade, f"=AND(ISNUMBER({here}),{when},{asks},{rule})", first, last)
            for grade, rule in rules
        ]
        each[-1:-1] = [
            ("warn", f"=ISNUMBER({column_letters(k)}{row})", k, k)
            for k in (first + np.flatnonzero(of.is_lower_bound)).tolist()
        ]
        for grade, criteria, left, right in each:
            self.sheet.sheet.conditional_format(
                row - 1, left, row - 1, right,
                {
                    "type": "formula",
                    "criteria": criteria,
                    "format": self.book.graded[grade],
                    "stop_if_true": True,
                },
            )  # fmt: skip

    def write_sheet_verdict(self, top: int, name: str, texts: Mapping[Verdict, str]) -> None:
        """Write the verdict of the sheet into its second column, and colour all verdicts."""
        write_verdict(self.sheet, top, [self], name=name, texts=texts)
        if self.rows:
            place = min(self.rows) - 1, self.at, max(self.rows) - 1, self.at
            colour_verdict_cells(self.sheet.sheet, self.book, place)


def write_verdict(
    sheet: SheetWriter,
    row: int,
    of: Sequence[LimitSheet],
    *,
    name: str,
    texts: Mapping[Verdict, str],
) -> None:
    """Write the verdict over the rows of some sheets into a row of a sheet, from 0.

    `texts` are the headlines of the verdicts; an approval says there what it is not of.
    """
    say, book = sheet.book.say, sheet.book
    places = [j.verdict_range for j in of if j.verdict_range]

    def any_is(said: str) -> str:
        return "+".join(f'SUMPRODUCT(--({p}="{said}"))' for p in places) + ">0"

    found: list[Verdict] = [v for j in of for v in j.found]
    cached = texts[worst_verdict(found) if found else "incomplete"]
    formula = f'"{texts["incomplete"]}"'
    if places:
        # Where nothing was requested nothing is approved either.
        formula = f'IF({any_is(grade_text("pass", say))},"{texts["pass"]}",{formula})'
        for grade in VERDICTS[1:-1]:
            formula = f'IF({any_is(grade_text(grade, say))},"{texts[grade]}",{formula})'
        formula = f'IF({any_is(say("stale"))},"{say("stale: run cardan again")}",{formula})'
        formula = f'IF({any_is(grade_text("fail", say))},"{texts["fail"]}",{formula})'
    sheet.sheet.write_string(row, 0, say("Verdict"), book.title)
    sheet.sheet.write_formula(row, 1, "=" + formula, book.verdict, cached)
    if name:
        book.define_cell_name(name, f"'{sheet.name}'!$B${row + 1}")
    colour_verdict_cells(sheet.sheet, book, (row, 1, row, 1), texts=texts)


def colour_verdict_cells(
    sheet: Any,
    book: WorkbookWriter,
    place: tuple[int, int, int, int],
    *,
    texts: Mapping[Verdict, str] | None = None,
) -> None:
    """Colour cells that hold grades: first row and column, last row and column, from 0.

    Cells of a verdict hold its headline, from `texts`; an approval that says what it is not of
    stands as a warning does.
    """
    partial = texts is not None and texts["pass"] != verdict_word("pass", book.say)
    said: list[tuple[str, Any]] = [
        *(
            (
                texts[g] if texts else grade_text(g, book.say),
                book.graded["warn"] if partial and g == "pass" else style,
            )
            for g, style in book.graded.items()
        ),
        (book.say("stale"), book.stale),
        (book.say("stale: run cardan again"), book.stale),
    ]
    for word, style in said:
        rule = {"type": "cell", "criteria": "==", "value": f'"{word}"', "format": style}
        sheet.conditional_format(*place, rule)


def _beyond_bound_formula(values: str, limit: Limit, bound: str, factor: float) -> str:
    """Return the formula for values past a bound; what is equal to it is not.

    A share of the bound is let pass, and of one SI unit where the bound is 0. What has a
    direction is held by its size, though the cells show the sign.
    """
    free = f"{MARGIN_TOLERANCE:.0e}*IF({bound}=0,{1 / factor:.15g},ABS({bound}))"
    signed = QUANTITIES[limit.quantity].signed
    if limit.sense == "<=":
        above = f"({values}>{bound}+{free})"
        return f"({above}+({values}<-{bound}-{free})>0)" if signed else above
    below = f"({values}<{bound}-{free})"
    return f"{below}*({values}>{free}-{bound})" if signed else below


def _within_band_formula(values: str, limit: Limit, row: int) -> str:
    """Return the formula for values within a band; what is equal to an edge is not."""
    low, high = f"$C{row}*(1+{MARGIN_TOLERANCE:.0e})", f"$D{row}*(1-{MARGIN_TOLERANCE:.0e})"
    inside = f"({values}>{low})*({values}<{high})"
    if not QUANTITIES[limit.quantity].signed:
        return inside
    return f"({inside}+({values}<-{low})*({values}>-{high})>0)"


def _margin_formula(value: str, limit: Limit, row: int, bound: str, factor: float) -> str:
    """Return the formula for the share of a bound still free, as `Limit.margin` has it."""
    size = f"ABS({value})" if QUANTITIES[limit.quantity].signed else value
    if limit.band:
        return f"MAX(($C{row}-{size})/$C{row},({size}-$D{row})/$D{row})"
    free = f"{bound}-{size}" if limit.sense == "<=" else f"{size}-{bound}"
    return f"({free})/IF({bound}=0,{limit.margin_scale / factor:.15g},ABS({bound}))"


def _cell_number(value: float) -> float:
    """Return a value as a cell of the file holds it: XlsxWriter writes 16 digits."""
    return float(f"{_finite_cell_value(value):.16G}")


def _finite_cell_value(value: float) -> float:
    return copysign(INFINITY_CELL_VALUE, value) if isinf(value) else value
