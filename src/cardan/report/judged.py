"""A workbook's limits: each a row of values beside its bounds, with the verdict it comes to.

A row is graded by formulas against bounds that may be changed. What `cardan` computed stands
beside in every row and is what counts while no input of the workbook is changed, so nothing
here can disagree with `cardan check`. Once an input is changed it is stale: then the rows
that formulas follow count by those, the others say that they are stale, and with them the
verdict of the workbook, unless a live row fails already.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from math import copysign, isinf
from typing import Any

import numpy as np

from cardan.base.arrays import BoolArray, FloatArray
from cardan.base.units import deg
from cardan.base.verdict import EQUAL, VERDICTS, Limit, Verdict, worst
from cardan.quantity.quantities import QUANTITIES
from cardan.report.book import CHANGED, ENDLESS, FIRST, Book, Sheet, column
from cardan.report.wording import cited


@dataclass(frozen=True, kw_only=True)
class Live:
    """Formulas that follow the inputs, in the columns of a row of limits.

    `cells` are what the row shows and `values` what they give for the inputs as written, in
    the unit shown; § stands for a column's letter in `angle`, the largest joint angle in
    deg, and in `idle`, which are 0 where nothing is asked. `method` names an approximation:
    where it is "" the formulas are as exact as `cardan`.
    """

    cells: tuple[str, ...]
    values: FloatArray
    angle: str
    idle: tuple[str, ...]
    method: str


@dataclass(frozen=True, kw_only=True)
class Held:
    """One limit and the values of one part that it is held against, SI; nan where none is.

    `may` tells which columns it may ask about, `missing` where it asks and got no number,
    for want of `needs`.
    """

    label: str
    limit: Limit
    values: FloatArray
    may: BoolArray
    missing: BoolArray
    needs: tuple[str, ...] = ()
    name: str = ""
    live: Live | None = None

    @property
    def verdict(self) -> Verdict | None:
        """What it comes to; None where nothing was asked, or only what is not required."""
        found: list[Verdict] = [self.limit.grade(v) for v in self.values[~np.isnan(self.values)]]
        if self.limit.required and self.missing.any():
            found.append("incomplete")
        return worst(found) if found else None


class Judged:
    """The rows of limits of one sheet, and its verdict."""

    def __init__(self, sheet: Sheet, columns: Sequence[str]) -> None:
        self.sheet, self.book, self.say = sheet, sheet.book, sheet.book.say
        self.heads, self.count = columns, max(len(columns), 1)
        self.at = FIRST + self.count
        self.beside = self.at + 2
        self.rows: list[int] = []
        self.found: list[Verdict] = []
        sheet.sheet.set_column(self.at, self.at, 13)
        sheet.sheet.set_column(self.at + 1, self.at + 1, 24)
        sheet.sheet.set_column(self.beside, self.beside + self.count, 12)

    @property
    def place(self) -> str:
        """The cells that hold the rows' verdicts; "" where there are none."""
        if not self.rows:
            return ""
        letter = column(self.at)
        return f"'{self.sheet.name}'!${letter}${min(self.rows)}:${letter}${max(self.rows)}"

    def section(self, text: str) -> None:
        """Write a heading over the rows that follow."""
        say = self.say
        heads = [
            "", say("unit"), say("normal"), say("maximum"), *self.heads, say("verdict"), "",
            *(
                say("{state}, as computed", state=head) if head else say("as computed")
                for head in self.heads
            ),
        ]  # fmt: skip
        self.sheet.section(text, heads)

    def row(self, of: Held) -> None:
        """Write one limit: what it is held against, its bounds, its verdict, what was computed."""
        say, sheet, q = self.say, self.sheet.sheet, QUANTITIES[of.limit.quantity]
        row, live = self.sheet.row + 1, of.live
        letters = [column(self.beside + k) for k in range(self.count)]
        if live:
            cells, style, shown = live.cells, self.book.result, live.values
        else:
            known = ~np.isnan(of.values) | of.missing
            cells = tuple(
                f'=IF({CHANGED}>0,"{say("stale")}",{letter}{row})' if there else ""
                for letter, there in zip(letters, known, strict=True)
            )
            style, shown = self.book.exact, None
        self.sheet.put(of.label, q.unit_name, cells, style=style, values=shown, name=of.name)
        self._bounds(row, of.limit, q.factor)
        for k, (value, missing) in enumerate(zip(of.values, of.missing, strict=True)):
            shown_as = say("no answer") if missing else _finite(float(value) / q.factor)
            here = row - 1, self.beside + k
            if isinstance(shown_as, str):
                sheet.write_string(*here, shown_as, self.book.plain)
            elif not np.isnan(shown_as):
                sheet.write_number(*here, shown_as, self.book.known)
            if not live and not (isinstance(shown_as, float) and np.isnan(shown_as)):
                cell = cells[k]
                sheet.write_formula(row - 1, FIRST + k, cell, self.book.known, shown_as)
        sheet.write_string(row - 1, self.at + 1, self._note(of), self.book.wrapped)
        self._verdict(row, of, q.factor)
        self._colours(row, of, q.factor)

    def _bounds(self, row: int, limit: Limit, factor: float) -> None:
        """Write the cells that hold a limit's bounds."""
        sheet = self.sheet.sheet
        for k, bound in enumerate(limit.band or (limit.normal, limit.maximum), 2):
            if bound is None:
                sheet.write_blank(row - 1, k, None, self.book.input)
            else:
                sheet.write_number(row - 1, k, bound / factor, self.book.input)
        sheet.write_comment(row - 1, 2, cited(limit.source, self.say), {"x_scale": 3})

    def _note(self, of: Held) -> str:
        """Return how a row comes by its values, or what it lacks."""
        say = self.say
        if of.missing.any():
            needs = ", ".join(say.given(n) for n in of.needs)
            return say(
                "no answer: needs {needs}", needs=needs or say("a number nobody could compute")
            )
        if of.live is None:
            return say("as computed")
        if of.live.method:
            return say("{method}; as computed counts", method=say.given(of.live.method))
        return ""

    # Verdicts

    def _verdict(self, row: int, of: Held, factor: float) -> None:
        """Write what a row comes to, as computed and, once inputs are changed, live or stale."""
        first, last = (column(self.beside + k) for k in (0, self.count - 1))
        block = f"${first}{row}:${last}{row}"
        lacking = f'SUMPRODUCT(--({block}="{self.say("no answer")}"))'
        computed = self._graded(row, of.limit, factor, block, (), lacking)
        live = of.live
        if live:
            values = f"${column(FIRST)}{row}:${column(self.at - 1)}{row}"
            asked = tuple(self._asked(of, live))
            none = "*".join((*asked, f"(1-ISNUMBER({values}))"))
            changed = self._graded(row, of.limit, factor, values, asked, f"SUMPRODUCT({none})")
        elif not np.isnan(of.values).all():
            changed = f'"{self.say("stale")}"'
        else:
            changed = computed
        verdict = of.verdict
        if verdict:
            self.found.append(verdict)
        self.rows.append(row)
        self.sheet.sheet.write_formula(
            row - 1, self.at, f"=IF({CHANGED}>0,{changed},{computed})", self.book.verdict,
            self.say(verdict) if verdict else "",
        )  # fmt: skip

    def _asked(self, of: Held, live: Live) -> Iterable[str]:
        """Yield what tells, column by column, whether a live row's limit asks."""
        if not of.may.all():
            yield "{" + ",".join(str(int(m)) for m in of.may) + "}"
        if of.limit.above_angle is not None:
            yield f"({self._across(live.angle)}>{of.limit.above_angle / deg:.12g})"
        for reference in live.idle:
            # Where all is idle every column asks, and nothing answers.
            yield f"({self._across(reference)}<>0)"

    def _across(self, reference: str) -> str:
        """Return the cells of a reference in all columns."""
        sheet, _, cell = reference.rpartition("!")
        first, last = (cell.replace("§", f"${column(FIRST + k)}$") for k in (0, self.count - 1))
        return f"{sheet}!{first}:{last}" if sheet else f"{first}:{last}"

    def _graded(
        self, row: int, limit: Limit, factor: float, values: str, asked: tuple[str, ...],
        lacking: str,
    ) -> str:  # fmt: skip
        """Return the formula that grades values as `Limit.grade` does."""
        say, bounds = self.say, f"$C{row}:$D{row}"
        number = (*asked, f"ISNUMBER({values})")

        def past(which: str) -> str:
            held = "*".join((*number, _past(values, limit, which, factor)))
            return f"IF(ISNUMBER({which}),SUMPRODUCT({held})>0,FALSE)"

        if limit.band:
            within = "*".join((*number, _within(values, limit, row)))
            fails, warns = "FALSE", f"SUMPRODUCT({within})>0"
        else:
            fails, warns = past(f"$D{row}"), past(f"$C{row}")
        count = (
            f"SUMPRODUCT(--{number[0]})" if len(number) == 1 else f"SUMPRODUCT({'*'.join(number)})"
        )
        end = f'IF({count}=0,"",IF({warns},"{say("warn")}","{say("pass")}"))'
        if limit.required:
            end = f'IF({lacking}+({count}=0)*({self._ever(asked)})>0,"{say("incomplete")}",{end})'
        return f'IF(COUNT({bounds})=0,"",IF({fails},"{say("fail")}",{end}))'

    @staticmethod
    def _ever(asked: tuple[str, ...]) -> str:
        """Return whether a live row asks nowhere because all stands idle; 0 if it cannot tell."""
        idle = [a for a in asked if a.endswith("<>0)")]
        return f"SUMPRODUCT({'*'.join((*idle, '1'))})=0" if idle else "0"

    # Colours

    def _colours(self, row: int, of: Held, factor: float) -> None:
        """Colour a row's values by what counts: as computed where the live ones approximate."""
        shown = column(FIRST)
        if of.live and of.live.method:
            self._coloured(row, self.beside, of, factor, f"{CHANGED}=0")
            self._coloured(row, FIRST, of, factor, f"{CHANGED}>0")
        else:
            self._coloured(row, FIRST, of, factor, f"ISNUMBER({shown}{row})")
        sheet = self.sheet.sheet
        sheet.conditional_format(
            row - 1, self.beside, row - 1, self.beside + self.count - 1,
            {"type": "formula", "criteria": f"={CHANGED}>0", "format": self.book.stale},
        )  # fmt: skip

    def _coloured(self, row: int, first: int, of: Held, factor: float, when: str) -> None:
        """Colour cells that hold a row's values, where its limit asks."""
        here, letter = f"{column(first)}{row}", column(self.beside)
        if of.live and of.limit.above_angle is not None:
            cell = of.live.angle.replace("§", column(FIRST))
            asks = f"{cell}>{of.limit.above_angle / deg:.12g}"
        else:
            asks = f'{letter}{row}<>""'
        if of.limit.band:
            bad = "fail" if of.limit.maximum is not None else "warn"
            rules = [(bad, _within(here, of.limit, row))]
        else:
            rules = [
                (grade, f"ISNUMBER({bound}),{_past(here, of.limit, bound, factor)}")
                for grade, bound in (("fail", f"$D{row}"), ("warn", f"$C{row}"))
            ]
        for grade, rule in (*rules, ("pass", "TRUE")):
            self.sheet.sheet.conditional_format(
                row - 1, first, row - 1, first + self.count - 1,
                {
                    "type": "formula",
                    "criteria": f"=AND(ISNUMBER({here}),{when},{asks},{rule})",
                    "format": self.book.graded[grade],
                    "stop_if_true": True,
                },
            )  # fmt: skip

    def close(self, top: int, name: str) -> None:
        """Write the verdict of the sheet into its second column, and colour all verdicts."""
        verdict(self.sheet, top, [self], name=name)
        if self.rows:
            place = min(self.rows) - 1, self.at, max(self.rows) - 1, self.at
            coloured(self.sheet.sheet, self.book, place)


def verdict(sheet: Sheet, row: int, of: Sequence[Judged], *, name: str) -> None:
    """Write the verdict over the rows of some sheets into a row of a sheet, from 0."""
    say, book = sheet.book.say, sheet.book
    places = [j.place for j in of if j.place]

    def any_is(word: str) -> str:
        return "+".join(f'SUMPRODUCT(--({p}="{say(word)}"))' for p in places) + ">0"

    found: list[Verdict] = [v for j in of for v in j.found]
    cached = say(worst(found) if found else "incomplete")
    formula = f'"{say("incomplete")}"'
    if places:
        # Where nothing was asked nothing is approved either.
        formula = f'IF({any_is("pass")},"{say("pass")}",{formula})'
        said: Iterable[Verdict | str] = VERDICTS[1:-1]
        for grade in said:
            formula = f'IF({any_is(grade)},"{say(grade)}",{formula})'
        formula = f'IF({any_is("stale")},"{say("stale: ask cardan again")}",{formula})'
        formula = f'IF({any_is("fail")},"{say("fail")}",{formula})'
    sheet.sheet.write_string(row, 0, say("Verdict"), book.title)
    sheet.sheet.write_formula(row, 1, "=" + formula, book.verdict, cached)
    if name:
        book.define(name, f"'{sheet.name}'!$B${row + 1}")
    coloured(sheet.sheet, book, (row, 1, row, 1))


def coloured(sheet: Any, book: Book, place: tuple[int, int, int, int]) -> None:
    """Colour cells that hold verdicts: first row and column, last row and column, from 0."""
    said: list[tuple[str, Any]] = [
        *((book.say(g), style) for g, style in book.graded.items()),
        (book.say("stale"), book.stale),
        (book.say("stale: ask cardan again"), book.stale),
    ]
    for word, style in said:
        rule = {"type": "cell", "criteria": "==", "value": f'"{word}"', "format": style}
        sheet.conditional_format(*place, rule)


def _past(values: str, limit: Limit, bound: str, factor: float) -> str:
    """Return the formula for values past a bound; what is equal to it is not.

    A share of the bound is let pass, and of one SI unit where the bound is 0. What has a
    direction is held by its size, though the cells show the sign.
    """
    free = f"{EQUAL:.0e}*IF({bound}=0,{1 / factor:.15g},ABS({bound}))"
    signed = QUANTITIES[limit.quantity].signed
    if limit.sense == "<=":
        above = f"({values}>{bound}+{free})"
        return f"({above}+({values}<-{bound}-{free})>0)" if signed else above
    below = f"({values}<{bound}-{free})"
    return f"{below}*({values}>{free}-{bound})" if signed else below


def _within(values: str, limit: Limit, row: int) -> str:
    """Return the formula for values within a band; what is equal to an edge is not."""
    low, high = f"$C{row}*(1+{EQUAL:.0e})", f"$D{row}*(1-{EQUAL:.0e})"
    inside = f"({values}>{low})*({values}<{high})"
    if not QUANTITIES[limit.quantity].signed:
        return inside
    return f"({inside}+({values}<-{low})*({values}>-{high})>0)"


def _finite(value: float) -> float:
    return copysign(ENDLESS, value) if isinf(value) else value
