"""The parametric workbook: AE-7, torque, bearing loads, critical speed and life as formulas.

For whoever has no Python: an angle, a length, a torque or a speed changed in the sheet of
inputs or of states changes every result. What needs the exact chain stands beside it as
values, marked so. Columns of states are the same in every sheet, so a formula reads down
its own column.
"""

import re
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from io import BytesIO
from typing import Any, TypeAlias
from zipfile import ZIP_DEFLATED, ZipFile

import numpy as np

from cardan.base.arrays import FloatArray
from cardan.base.quantities import QUANTITIES
from cardan.base.units import GPa, MPa, deg, mm, rpm
from cardan.base.verdict import Limit
from cardan.loads import loads
from cardan.model.application import Application
from cardan.report.extra import needed
from cardan.report.language import Language
from cardan.report.sheet import sections
from cardan.shaft.life import life_rating
from cardan.study.assess import Assessment, asked
from cardan.study.response import Response

FIRST = 4
"""Number of the first state's column: E."""

Cell: TypeAlias = float | str | None
"""A value, a formula (it begins with =), or nothing."""

Check: TypeAlias = dict[str, Any]
"""What a cell may hold, as XlsxWriter takes it."""

POSITIVE: Check = {"validate": "decimal", "criteria": ">", "value": 0}
NOT_NEGATIVE: Check = {"validate": "decimal", "criteria": ">=", "value": 0}
SHARE: Check = {"validate": "decimal", "criteria": "between", "minimum": 0.01, "maximum": 1}
SLOPE: Check = {"validate": "decimal", "criteria": "between", "minimum": -60, "maximum": 60}
PHASE: Check = {"validate": "decimal", "criteria": "between", "minimum": -180, "maximum": 180}
FRICTION: Check = {"validate": "decimal", "criteria": "between", "minimum": 0, "maximum": 2}


def workbook(of: Assessment, *, say: Language) -> bytes:
    """Return the workbook of an application, all its lines, as an .xlsx file.

    Raises
    ------
    MissingExtra
        If XlsxWriter is not installed.
    """
    xlsxwriter = needed("xlsxwriter")
    raw = BytesIO()
    book = _Book(xlsxwriter.Workbook(raw, {"in_memory": True}), say)
    several = len(of.responses) > 1
    inputs = book.sheet(say("Inputs"))
    _general(inputs, of.application)
    for r in of.responses:
        _line_inputs(inputs, r, tag=_tag(r, several=several))
    for r in of.responses:
        end = f" {r.line.name}" if several else ""
        line = _Line(book, r, tag=_tag(r, several=several), end=end)
        line.write()
    book.file.close()
    return _unknown_writer(raw.getvalue())


def _tag(r: Response, *, several: bool) -> str:
    """Return what begins the names of a line's cells."""
    return re.sub(r"\W", "_", r.line.name) + "_" if several else ""


def _unknown_writer(data: bytes) -> bytes:
    """Return a workbook that does not claim to be computed by a spreadsheet.

    LibreOffice believes the results in a file that names Excel as its writer and computes
    all others anew.
    """
    out = BytesIO()
    with ZipFile(BytesIO(data)) as old, ZipFile(out, "w", ZIP_DEFLATED) as new:
        for item in old.infolist():
            content = old.read(item)
            if item.filename == "docProps/app.xml":
                content = content.replace(b"Microsoft Excel", b"cardan")
            new.writestr(item, content)
    return out.getvalue()


class _Book:
    """A workbook being written, its formats and the names of its cells."""

    def __init__(self, file: Any, say: Language) -> None:
        self.file, self.say = file, say
        base = {"font_name": "Calibri", "font_size": 10, "valign": "top"}

        def style(**more: object) -> Any:
            return file.add_format({**base, **more})

        self.plain = style()
        self.wrapped = style(font_color="#55606D", font_size=9)
        self.title = style(bold=True, font_size=14)
        self.head = style(bold=True, bottom=1, text_wrap=True)
        self.section = style(bold=True, bg_color="#E3EAF1")
        self.input = style(bg_color="#FFF8DC", font_color="#0000AA", border=1, border_color="#D5C98F")
        self.formula = style(num_format="0.0000")
        self.result = style(num_format="0.000", bold=True)
        self.exact = style(num_format="0.000", italic=True, font_color="#55606D")
        self.verdict = style(bold=True, align="center")
        self.graded = {
            "fail": file.add_format({"bg_color": "#F6C9C4", "font_color": "#8E1B12"}),
            "warn": file.add_format({"bg_color": "#FBE7B2", "font_color": "#6B4A00"}),
            "pass": file.add_format({"bg_color": "#D3F0DA", "font_color": "#13602A"}),
        }

    def sheet(self, name: str) -> "_Sheet":
        """Return a new sheet."""
        name = re.sub(r"[\[\]:*?/\\]", " ", name)[:31]
        sheet = self.file.add_worksheet(name)
        sheet.set_landscape()
        sheet.set_paper(9)  # A4
        sheet.fit_to_pages(1, 0)
        sheet.hide_gridlines(2)
        return _Sheet(self, sheet, name)


class _Sheet:
    """A sheet being written from top to bottom."""

    def __init__(self, book: _Book, sheet: Any, name: str) -> None:
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
        width = max(FIRST + 1, len(heads))
        for k in range(width):
            said = text if k == 0 else heads[k] if k < len(heads) else ""
            self.sheet.write_string(self.row, k, said, self.book.section)
        self.row += 1

    def put(
        self,
        label: str,
        unit: str,
        cells: Sequence[Cell],
        *,
        style: Any,
        texts: tuple[str, str] = ("", ""),
        values: FloatArray | None = None,
        name: str = "",
        allow: Check | None = None,
        first: int = FIRST,
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
                known = 0 if values is None or not np.isfinite(values[k]) else float(values[k])
                sheet.write_formula(row, first + k, cell, style, known)
            elif isinstance(cell, str):
                sheet.write_string(row, first + k, cell, style)
            elif cell is None or not np.isfinite(cell):
                sheet.write_blank(row, first + k, None, style)
            else:
                sheet.write_number(row, first + k, float(cell), style)
        last = first + max(len(cells), 1) - 1
        if allow:
            sheet.data_validation(row, first, row, last, {
                "ignore_blank": True, "error_title": "cardan", **allow,
                "error_message": f"{label[:120]}: {allow['criteria']} "
                f"{allow.get('value', '')}{allow.get('minimum', '')} {allow.get('maximum', '')}",
            })  # fmt: skip
        if name:
            start, end = (f"${column(k)}${row + 1}" for k in (first, last))
            place = start if start == end else f"{start}:{end}"
            self.book.file.define_name(name, f"='{self.name}'!{place}")
        self.row += 1
        return row + 1


def column(number: int) -> str:
    """Return the letters of a column, 0 is A."""
    letters = ""
    number += 1
    while number:
        number, rest = divmod(number - 1, 26)
        letters = chr(65 + rest) + letters
    return letters


def _general(sheet: _Sheet, a: Application) -> None:
    """Write what all lines share."""
    say, book = sheet.book.say, sheet.book
    sheet.sheet.set_column(0, 0, 46)
    sheet.sheet.set_column(1, 3, 11)
    sheet.sheet.set_column(FIRST, FIRST + 12, 11)
    sheet.title(
        a.title,
        (
            say("Driveline workbook: change what is coloured, and every result follows."),
            say("Limits: {profile}. Positive slopes run down and to the right going rearward.",
                profile=a.profile),
        ),
    )  # fmt: skip

    def put(label: str, unit: str, cells: Sequence[Cell], name: str, allow: Check = POSITIVE) -> None:
        sheet.put(label, unit, cells, style=book.input, name=name, allow=allow)

    engine, gearbox, tyre = a.engine, a.gearbox, a.tyre
    sheet.section(say("Engine and gearbox"))
    put(say("engine speed"), "rpm", [v / rpm for v in engine.speed] if engine else [None], "engine_speeds")
    put(say("engine torque"), "N·m", list(engine.torque) if engine else [None], "engine_torques")
    put(say("gear ratios"), "", list(gearbox.ratios) if gearbox else [1.0], "gear_ratios")
    put(say("gearbox efficiency"), "", [gearbox.efficiency if gearbox else 1.0], "gearbox_efficiency", SHARE)
    put(say("converter torque ratio"), "", [gearbox.converter_ratio if gearbox else 1.0], "converter_ratio")
    put(say("transfer case, low range"), "", [gearbox.transfer_ratio if gearbox else 1.0], "transfer_ratio")
    sheet.section(say("Application"))
    put(say("torque at the gearbox output, where given"), "N·m", [a.torque], "torque_given", NOT_NEGATIVE)
    put(say("speed of the gearbox output, where given"), "rpm",
        [None if a.speed is None else a.speed / rpm], "speed_given")  # fmt: skip
    put(say("shock factor"), "", [a.shock_factor], "shock_factor")
    put(say("prime mover factor"), "", [a.prime_mover_factor], "prime_mover_factor")
    put(say("tyre, friction"), "", [tyre.friction if tyre else None], "tyre_friction", FRICTION)
    put(say("tyre, static radius"), "mm", [tyre.static_radius / mm if tyre else None], "tyre_radius")
    if a.duty:
        sheet.section(say("Duty cycle"))
        put(say("share of the life"), "%", [100 * p.share for p in a.duty], "duty_shares", NOT_NEGATIVE)
        put(say("shaft torque"), "N·m", [p.torque for p in a.duty], "duty_torques", NOT_NEGATIVE)
        put(say("shaft speed"), "rpm", [p.speed / rpm for p in a.duty], "duty_speeds", NOT_NEGATIVE)
        put(say("joint angle, where given"), "deg",
            [None if p.angle is None else p.angle / deg for p in a.duty], "duty_angles", NOT_NEGATIVE)  # fmt: skip
        up = sheet.row
        work = [
            f"={column(k)}{up - 3}/100*{column(k)}{up - 1}*ABS({column(k)}{up - 2})^(10/3)"
            for k in range(FIRST, FIRST + len(a.duty))
        ]
        sheet.put(say("wear without angle"), "", work, style=book.formula, name="duty_work",
                  texts=("p n T^(10/3)", ""))  # fmt: skip


def _line_inputs(sheet: _Sheet, r: Response, *, tag: str) -> None:
    """Write what belongs to one line but not to a state of it."""
    say, book, line, installed = sheet.book.say, sheet.book, r.line, r.demand.installed
    axle = installed.axle
    share = installed.torque_ratio * (axle.torque_share if axle else 1.0)

    def put(label: str, unit: str, cells: Sequence[Cell], name: str, allow: Check = POSITIVE) -> None:
        sheet.put(label, unit, cells, style=book.input, name=tag + name, allow=allow)

    sheet.section(say("Line {line}", line=line.name))
    put(say("share of the torque"), "", [share], "torque_share", NOT_NEGATIVE)
    put(say("line speed over gearbox speed"), "", [installed.speed_ratio], "speed_ratio")
    put(say("axle ratio"), "", [axle.ratio if axle else None], "axle_ratio")
    put(say("axle efficiency"), "", [axle.efficiency if axle else None], "axle_efficiency", SHARE)
    joints = [say.part(f"joint {k}") for k in range(1, line.joint_count + 1)]
    sheet.section(say("Joints"), ["", "", "", "", *joints])
    ratings = [life_rating(size) if size else None for size in r.sizes]
    put(say("bearing rating Td"), "N·m", ratings, "joint_ratings")
    shafts = [say.part(f"shaft {k}") for k in range(1, line.joint_count)]
    sheet.section(say("Shafts"), ["", "", "", "", *shafts])
    tubes = [s.tube for s in line.shafts]
    put(say("tube, outside diameter"), "mm", [t.outer / mm if t else None for t in tubes], "tube_outer")
    put(say("tube, wall"), "mm", [t.wall / mm if t else None for t in tubes], "tube_wall")
    put(say("Young's modulus"), "GPa", [t.material.youngs_modulus / GPa if t else None for t in tubes], "tube_modulus")
    put(say("density"), "kg/m³", [t.material.density if t else None for t in tubes], "tube_density")
    strengths = [t.material.yield_strength if t else None for t in tubes]
    put(say("yield strength"), "MPa", [None if s is None else s / MPa for s in strengths], "tube_yield")
    put(say("yoke phase"), "deg", [s.phase / deg for s in line.shafts], "yoke_phases", PHASE)
    put(say("polar inertia"), "kg·m²", [s.polar_inertia for s in line.shafts], "polar_inertias")
    ahead = [s.centre_bearing.from_rear_joint / mm if s.centre_bearing else None for s in line.shafts]
    put(say("centre bearing ahead of the rear joint"), "mm", ahead, "bearing_offsets", NOT_NEGATIVE)


@dataclass
class _Result:
    """A row of results: its quantity, its part, and the row of the calculation it shows."""

    quantity: str
    part: str
    row: int


class _Line:
    """The sheets of one line: its states, the calculation, the results."""

    def __init__(self, book: _Book, response: Response, *, tag: str, end: str) -> None:
        self.book, self.r, self.tag = book, response, tag
        say = self.say = book.say
        self.n = response.line.joint_count
        self.count = len(response.demand.states)
        self.columns = [column(FIRST + s) for s in range(self.count)]
        self.states = book.sheet(say("States") + end)
        self.sheet = book.sheet(say("Calculation") + end)
        self.results = book.sheet(say("Results") + end)
        self.found: list[_Result] = []
        for one in (self.states, self.sheet, self.results):
            one.sheet.set_column(0, 0, 46)
            one.sheet.set_column(1, 1, 9)
            one.sheet.set_column(2, 3, 12 if one is not self.sheet else 34)
            one.sheet.set_column(FIRST, FIRST + self.count, 13)

    def write(self) -> None:
        """Write all three."""
        self._states()
        self._calculation()
        self._results()

    def _heads(self) -> list[str]:
        return [self.say.given(s) for s in self.r.demand.states]

    # States

    def _given(self, label: str, unit: str, values: Sequence[Cell], name: str, allow: Check) -> int:
        return self.states.put(
            label, unit, values, style=self.book.input, name=self.tag + name, allow=allow
        )

    def _states(self) -> None:
        """Write geometry, torque and speed of every state."""
        r, say, sheet = self.r, self.say, self.states
        sheet.title(
            say("States of line {line}", line=r.line.name),
            (say("Geometry as the suspension places it: values that may be changed by hand."),),
        )
        heads = ["", "", "", "", *self._heads()]
        sheet.section(say("side slopes of the members"), heads)
        members = [
            say("gearbox"), *(say.part(f"shaft {k}") for k in range(1, self.n)), say("pinion"),
        ]  # fmt: skip
        side, top = r.layout.side / deg, r.layout.top / deg
        self.side = [
            self._given(m, "deg", side[:, k].tolist(), f"side_{k}", SLOPE) for k, m in enumerate(members)
        ]
        sheet.section(say("top slopes of the members"), heads)
        self.top = [
            self._given(m, "deg", top[:, k].tolist(), f"top_{k}", SLOPE) for k, m in enumerate(members)
        ]
        sheet.section(say("length"), heads)
        lengths = r.layout.lengths / mm
        self.lengths = [
            self._given(members[k + 1], "mm", lengths[:, k].tolist(), f"length_{k + 1}", POSITIVE)
            for k in range(self.n - 1)
        ]
        sheet.section(say("Demand"), heads)
        own = r.application.states
        torques: list[Cell] = [
            '=IF(ISNUMBER(torque_given),torque_given,"")' if s.torque is None else s.torque for s in own
        ]
        speeds: list[Cell] = [
            '=IF(ISNUMBER(speed_given),speed_given,"")' if s.speed is None else s.speed / rpm for s in own
        ]
        self.torque_given = self._given(
            say("torque at the gearbox output, where given"), "N·m", torques, "state_torques", NOT_NEGATIVE
        )
        self.speed_given = self._given(
            say("speed of the gearbox output, where given"), "rpm", speeds, "state_speeds", POSITIVE
        )
        self.driven = self._given(
            say("load on the driven wheels at slip"), "N", r.demand.driven_load.tolist(), "driven_loads",
            NOT_NEGATIVE,
        )  # fmt: skip
        self.weight: list[list[int]] = []
        if r.gravity:
            sheet.section(say("Weight on the centre bearings (values of cardan)"), heads)
            still = loads(r.layout, r.turn, r.line, torque=0.0, gravity=r.gravity)
            force = still.bearing_forces.static
            for k in range(self.n - 2):
                part = say.part(f"bearing {k + 1}")
                self.weight.append(
                    [
                        self._given(f"{part}, {axis}", "N", force[:, k, c].tolist(), f"weight_{k + 1}_{axis}",
                                    {"validate": "decimal", "criteria": "<", "value": 1e9})
                        for c, axis in enumerate("xyz")
                    ]
                )  # fmt: skip
        sheet.sheet.freeze_panes(0, FIRST)

    # Calculation

    def _row(
        self,
        label: str,
        unit: str,
        formula: Callable[[str], str],
        *,
        quantity: str = "",
        part: str = "",
        note: str = "",
        values: FloatArray | None = None,
    ) -> int:
        """Write a row of formulas, one for each state's column; return its number.

        A row of a `quantity` is a result: it says where its equation comes from.
        """
        q = QUANTITIES.get(quantity)
        row = self.sheet.put(
            label or (self.say.list(self.say.name(quantity), self.say.part(part)) if q else ""),
            unit or (q.unit_name if q else ""),
            ["=" + formula(c) for c in self.columns],
            style=self.book.result if q else self.book.formula,
            texts=(note or (self.say.given(q.equation) if q else ""), str(q.source) if q else ""),
            values=None if values is None or q is None else np.asarray(values, dtype=float) / q.factor,
        )
        if q:
            self.found.append(_Result(quantity, part, row))
        return row

    def _of_state(self, row: int) -> Callable[[str], str]:
        """Return the reference to a row of the sheet of states."""
        return lambda c: f"'{self.states.name}'!{c}{row}"

    def _of_part(self, name: str, k: int) -> str:
        """Return the reference to the k-th of the cells of a name, from 1."""
        return f"INDEX({self.tag}{name},1,{k})"

    def _calculation(self) -> None:
        say, sheet = self.say, self.sheet
        sheet.title(
            say("Calculation of line {line}", line=self.r.line.name),
            (say("AE-7's method and closed forms, state by state. Complex numbers stand in two "
                 "rows: along position 0 (re) and 90 deg (im)."),),
        )  # fmt: skip
        self._demand()
        self._angles()
        self._excitation()
        self._bearings()
        self._speed()
        self._life()
        sheet.sheet.freeze_panes(0, FIRST)

    def _section(self, text: str) -> None:
        say = self.say
        self.sheet.section(text, ["", say("unit"), say("equation"), say("source"), *self._heads()])

    def _demand(self) -> None:
        """Torque: engine against slip; speed."""
        say, tag, d = self.say, self.tag, self.r.demand
        self._section(say("Demand"))
        engine = self._row(
            "", "", lambda _: (
                'IF(COUNT(engine_torques)=0,"",MAX(engine_torques)*MAX(gear_ratios)*MAX(1,transfer_ratio)'
                f"*gearbox_efficiency*converter_ratio*{tag}torque_share)"),
            quantity="engine_torque", values=d.engine_torque,
        )  # fmt: skip
        load = self._of_state(self.driven)
        slip = self._row(
            "", "", lambda c: (
                f"IF(AND(ISNUMBER({load(c)}),ISNUMBER({tag}axle_ratio),ISNUMBER(tyre_friction)),"
                f'tyre_friction*{load(c)}*tyre_radius/1000/({tag}axle_ratio*{tag}axle_efficiency),"")'),
            quantity="slip_torque", values=d.slip_torque,
        )  # fmt: skip
        given = self._of_state(self.torque_given)
        self.torque = self._row(
            "", "", lambda c: (
                f"IF(ISNUMBER({given(c)}),{given(c)}*{tag}torque_share,MIN({c}{engine},{c}{slip}))"),
            quantity="torque", values=d.torque,
        )  # fmt: skip
        asked_speed = self._of_state(self.speed_given)
        self.speed = self._row(
            "", "", lambda c: (
                f"IF(ISNUMBER({asked_speed(c)}),{asked_speed(c)},"
                f"MAX(engine_speeds)/(MIN(gear_ratios)*MIN(1,transfer_ratio)))*{tag}speed_ratio"),
            quantity="speed", values=d.speed,
        )  # fmt: skip
        self.omega = self._row("ω", "rad/s", lambda c: f"{c}{self.speed}*PI()/30")

    def _angles(self) -> None:
        """View angles, true angles and positions of the joints; signs from the yoke phases."""
        say, r = self.say, self.r
        self._section(say("Joints"))
        self.bv: list[int] = []
        self.bh: list[int] = []
        self.beta: list[int] = []
        for k in range(1, self.n + 1):
            part = f"joint {k}"
            s1, s2, t1, t2 = (
                self._of_state(rows[j]) for rows in (self.side, self.top) for j in (k - 1, k)
            )
            self.bv.append(self._row("", "", lambda c, a=s1, b=s2: f"{b(c)}-{a(c)}", quantity="side_angle",
                                     part=part, values=r.side_angles[:, k - 1]))  # fmt: skip
            self.bh.append(self._row("", "", lambda c, a=t1, b=t2: f"{b(c)}-{a(c)}", quantity="top_angle",
                                     part=part, values=r.top_angles[:, k - 1]))  # fmt: skip
            a, b, e, f = (
                lambda c, x=x, m=m: f"({m}TAN(RADIANS({x(c)})))"
                for x, m in ((t1, ""), (s1, "-"), (t2, ""), (s2, "-"))
            )
            self.beta.append(
                self._row(
                    "", "",
                    lambda c, a=a, b=b, e=e, f=f: (
                        f"DEGREES(ATAN2(1+{a(c)}*{e(c)}+{b(c)}*{f(c)},"
                        f"SQRT(({a(c)}*{f(c)}-{b(c)}*{e(c)})^2+({b(c)}-{f(c)})^2+({e(c)}-{a(c)})^2)))"),
                    quantity="joint_angle", part=part, values=r.angles[:, k - 1],
                )
            )  # fmt: skip
            v, h = self.bv[-1], self.bh[-1]
            self._row(
                "", "", lambda c, v=v, h=h: (
                    f"IF(AND({c}{v}=0,{c}{h}=0),0,MOD(DEGREES(ATAN2({c}{h},{c}{v})),360))"),
                quantity="joint_position", part=part, values=r.positions[:, k - 1],
            )  # fmt: skip
        first, last = self.beta[0], self.beta[-1]
        self._row("", "", lambda c: f"ABS({c}{first}-{c}{last})", quantity="end_angle_difference",
                  values=np.abs(r.angles[:, 0] - r.angles[:, -1]))  # fmt: skip
        cells = lambda c: ",".join(f"{c}{row}" for row in self.beta)  # noqa: E731
        self.largest = self._row(say("largest joint angle"), "deg", lambda c: f"MAX({cells(c)})")
        # The same angles, as other limits ask about them.
        for k, (row, v, h) in enumerate(zip(self.beta, self.bv, self.bh, strict=True), 1):
            part = f"joint {k}"
            self._row("", "", lambda c, x=row: f"{c}{x}", quantity="joint_angle_min", part=part,
                      values=r.angles[:, k - 1])  # fmt: skip
            self._row("", "", lambda c, v=v, h=h: f"SQRT({c}{v}^2+{c}{h}^2)", quantity="compound_angle", part=part)
            self._row("", "", lambda c, x=row: f"({c}{self.omega}*RADIANS({c}{x}))^2",
                      quantity="angle_for_speed", part=part)  # fmt: skip
            self._row("", "", lambda c, x=row: f"{c}{self.speed}*{c}{x}", quantity="n_beta", part=part)

    def _excitation(self) -> None:
        """AE-7's phasors: s_k D_k², their sums, and what follows from them."""
        say, r = self.say, self.r
        ae7, plane = r.approximations["ae7"], r.approximations["in_plane"]
        self._section(say("Excitation") + " (AE-7)")
        self.sigma: list[int] = []
        re_p: list[int] = []
        im_p: list[int] = []
        re_q: list[int] = []
        im_q: list[int] = []
        for k in range(1, self.n + 1):
            part = say.part(f"joint {k}")
            before = self.sigma[-1] if self.sigma else 0
            phase = self._of_part("yoke_phases", k - 1)
            self.sigma.append(
                self._row(f"arg s, {part}", "rad",
                          lambda c, b=before, p=phase: f"{c}{b}+PI()+2*RADIANS({p})" if b else "0",
                          note="s₁ = 1; sₖ₊₁ = −sₖ e^(2iφ)")
            )  # fmt: skip
            g, v, h = self.sigma[-1], self.bv[k - 1], self.bh[k - 1]
            dr = lambda c, v=v, h=h: f"(RADIANS({c}{h})^2-RADIANS({c}{v})^2)"  # noqa: E731
            di = lambda c, v=v, h=h: f"(2*RADIANS({c}{h})*RADIANS({c}{v}))"  # noqa: E731
            plus = lambda rows, c: f"{c}{rows[-1]}+" if rows else ""  # noqa: E731
            re_p.append(self._row(
                f"P{k} re", "rad²",
                lambda c, a=dr, b=di, g=g, p=tuple(re_p): f"{plus(p, c)}{a(c)}*COS({c}{g})-{b(c)}*SIN({c}{g})",
                note="Pₖ = Pₖ₋₁ + sₖ Dₖ²,  D = βh + i βv"))  # fmt: skip
            im_p.append(self._row(
                f"P{k} im", "rad²",
                lambda c, a=dr, b=di, g=g, p=tuple(im_p): f"{plus(p, c)}{a(c)}*SIN({c}{g})+{b(c)}*COS({c}{g})"))  # fmt: skip
            size = lambda c, v=v, h=h: f"(RADIANS({c}{h})^2+RADIANS({c}{v})^2)"  # noqa: E731
            re_q.append(self._row(
                f"Q{k} re", "rad²",
                lambda c, a=size, g=g, p=tuple(re_q): f"{plus(p, c)}-{a(c)}*COS({c}{g})",
                note=say("as if all joints lay in one plane")))  # fmt: skip
            im_q.append(self._row(
                f"Q{k} im", "rad²",
                lambda c, a=size, g=g, p=tuple(im_q): f"{plus(p, c)}-{a(c)}*SIN({c}{g})"))  # fmt: skip
        last = self.n - 1

        def sums(rows: list[int], weights: Sequence[str] = (), *, less: bool = False) -> Callable[[str], str]:
            """Return the sum over the shafts of P, less the pinion's where asked."""
            def formula(c: str) -> str:
                end = f"-{c}{rows[last]}" if less else ""
                each = [f"({c}{rows[j]}{end})" for j in range(last)]
                return "+".join(f"{w}*{e}" for w, e in zip(weights, each, strict=True)) if weights else "+".join(each)

            return formula

        size = self._row("|P|", "rad²", lambda c: f"SQRT({c}{re_p[last]}^2+{c}{im_p[last]}^2)")
        flat = self._row("|Q|", "rad²", lambda c: f"SQRT({c}{re_q[last]}^2+{c}{im_q[last]}^2)")
        self._row("", "", lambda c: f"DEGREES(SQRT({c}{size}))", quantity="equivalent_angle",
                  note="√|P|", values=ae7.torsional.angle)  # fmt: skip
        self._row("", "", lambda c: f"{c}{self.omega}^2*{c}{size}", quantity="torsional_acceleration",
                  note="ω² |P|", values=ae7.torsional.acceleration)  # fmt: skip
        self._row(say("Torsional acceleration, all joints in one plane"), "rad/s²",
                  lambda c: f"{c}{self.omega}^2*{c}{flat}", note="ω² |Q|",
                  values=plane.torsional.acceleration)  # fmt: skip
        for quantity, less, values in (
            ("inertia_drive_acceleration", False, ae7.drive.acceleration),
            ("inertia_coast_acceleration", True, ae7.coast.acceleration),
        ):
            re_, im_ = sums(re_p, less=less), sums(im_p, less=less)
            self._row("", "", lambda c, a=re_, b=im_: f"{c}{self.omega}^2*SQRT(({a(c)})^2+({b(c)})^2)",
                      quantity=quantity, values=values,
                      note="ω² |Σ (Pⱼ − Pₙ)|" if less else "ω² |Σ Pⱼ|")  # fmt: skip
        if ae7.drive_torque is None or ae7.coast_torque is None:
            return
        weights = [self._of_part("polar_inertias", j) for j in range(1, self.n)]
        for quantity, less, values in (
            ("inertia_drive_torque", False, ae7.drive_torque),
            ("inertia_coast_torque", True, ae7.coast_torque),
        ):
            re_, im_ = sums(re_p, weights, less=less), sums(im_p, weights, less=less)
            self._row("", "", lambda c, a=re_, b=im_: f"{c}{self.omega}^2*SQRT(({a(c)})^2+({b(c)})^2)",
                      quantity=quantity, values=values,
                      note="ω² |Σ Jⱼ (Pⱼ − Pₙ)|" if less else "ω² |Σ Jⱼ Pⱼ|")  # fmt: skip

    def _bearings(self) -> None:
        """Centre-bearing forces at small angles, from the last shaft forward."""
        if self.n < 3:
            return
        say, r = self.say, self.r
        self._section(say("Centre bearings") + f" ({say('small angle')})")
        # Couple of each shaft, i T/(2 L) times mean and swing: four rows, re and im of each.
        couples: list[list[int]] = []
        for k in range(1, self.n):
            v, h, g = self.bv, self.bh, self.sigma
            length = self._of_state(self.lengths[k - 1])
            front = lambda c, x=length: f"{c}{self.torque}/(2*{x(c)}/1000)"  # noqa: E731
            mr = lambda c, k=k: f"(RADIANS({c}{h[k - 1]})+RADIANS({c}{h[k]}))"  # noqa: E731
            mi = lambda c, k=k: f"(-RADIANS({c}{v[k - 1]})-RADIANS({c}{v[k]}))"  # noqa: E731

            def turned(c: str, j: int, *, re_: bool) -> str:
                """Return re or im of s conj(Δ) of joint j."""
                a, b, s = f"RADIANS({c}{h[j]})", f"RADIANS({c}{v[j]})", f"{c}{g[j]}"
                return f"({a}*COS({s})-{b}*SIN({s}))" if re_ else f"({a}*SIN({s})+{b}*COS({s}))"

            wr = lambda c, k=k: f"({turned(c, k - 1, re_=True)}-{turned(c, k, re_=True)})"  # noqa: E731
            wi = lambda c, k=k: f"({turned(c, k - 1, re_=False)}-{turned(c, k, re_=False)})"  # noqa: E731
            name = say.part(f"shaft {k}")
            couples.append([
                self._row(f"{say('couple')} {name}, {what}", "N", lambda c, f=front, m=m, s=s: f"{s}{f(c)}*{m(c)}",
                          note=note)
                for what, m, s, note in (
                    (say("mean") + " re", mi, "-", "i T (Δₖ + Δₖ₊₁) / (2 Lₖ),  Δ = βh − i βv"),
                    (say("mean") + " im", mr, "", ""),
                    (say("order 2") + " re", wi, "-", "i T (sₖ Δₖ* − sₖ₊₁ Δₖ₊₁*) / (2 Lₖ)"),
                    (say("order 2") + " im", wr, "", ""),
                )
            ])  # fmt: skip
        joint = couples[-1]
        static, dynamic = r.small_angle_bearings
        for k in range(self.n - 2, 0, -1):
            length = self._of_state(self.lengths[k - 1])
            offset = self._of_part("bearing_offsets", k)
            force = [
                self._row(f"B{k} {what}", "N",
                          lambda c, a=a, b=b, x=length, o=offset: f"{x(c)}/({x(c)}-{o})*({c}{a}-{c}{b})",
                          note="B = L/(L − e) (couple − force behind)")
                for what, a, b in zip(
                    (say("mean") + " re", say("mean") + " im", say("order 2") + " re", say("order 2") + " im"),
                    couples[k - 1], joint, strict=True)
            ]  # fmt: skip
            joint = [
                self._row(f"F{k} {what}", "N", lambda c, a=a, b=b: f"{c}{a}+{c}{b}")
                for what, a, b in zip(("mean re", "mean im", "order 2 re", "order 2 im"), joint, force, strict=True)
            ]
            part = f"bearing {k}"
            weight = [self._of_state(w) for w in self.weight[k - 1]] if self.weight else None

            def size(c: str, f: list[int] = force, w: Any = weight) -> str:
                if w is None:
                    return f"SQRT({c}{f[0]}^2+{c}{f[1]}^2)"
                return f"SQRT({w[0](c)}^2+({c}{f[0]}+{w[1](c)})^2+({c}{f[1]}+{w[2](c)})^2)"

            self._row("", "", size, quantity="centre_bearing_static", part=part,
                      values=np.linalg.norm(static[:, k - 1], axis=-1))  # fmt: skip
            self._row("", "", lambda c, f=force: f"SQRT({c}{f[2]}^2+{c}{f[3]}^2)",
                      quantity="centre_bearing_dynamic", part=part, values=dynamic[:, k - 1])  # fmt: skip

    def _speed(self) -> None:
        """Critical speed and shear of each tube."""
        r = self.r
        self._section(self.say("Speed and strength"))
        for k, shaft in enumerate(r.line.shafts, 1):
            if not shaft.tube:
                continue
            part = f"shaft {k}"
            length = self._of_state(self.lengths[k - 1])
            outer, wall, modulus, density, strength = (
                self._of_part(f"tube_{w}", k) for w in ("outer", "wall", "modulus", "density", "yield")
            )
            inner = f"({outer}-2*{wall})"
            critical = self._row(
                "", "", lambda c, x=length, o=outer, i=inner, e=modulus, d=density: (
                    f"30*PI()/({x(c)}/1000)^2*SQRT({e}*10^9*(({o}/1000)^2+({i}/1000)^2)/(16*{d}))"),
                quantity="critical_speed", part=part, values=r.critical_speeds[:, k - 1],
            )  # fmt: skip
            for quantity in ("critical_speed_ratio", "half_critical_band"):
                self._row("", "", lambda c, x=critical: f"{c}{self.speed}/{c}{x}", quantity=quantity, part=part,
                          values=r.demand.speed / r.critical_speeds[:, k - 1])  # fmt: skip
            if shaft.tube.material.yield_strength:
                self._row(
                    "", "", lambda c, o=outer, i=inner, y=strength: (
                        f"16*ABS({c}{self.torque})*shock_factor*({o}/1000)"
                        f"/(PI()*(({o}/1000)^4-({i}/1000)^4))/({y}*10^6/SQRT(3))"),
                    quantity="tube_shear_utilisation", part=part, values=r.tube_shear_utilisation[:, k - 1],
                )  # fmt: skip

    def _life(self) -> None:
        """Life of the needle bearings, over the duty cycle where there is one."""
        r = self.r
        if np.isnan(r.life).all():
            return
        self._section(self.say.name("joint_life"))
        for k in range(1, self.n + 1):
            if np.isnan(r.life[:, k - 1]).all():
                continue
            rating, beta = self._of_part("joint_ratings", k), self.beta[k - 1]
            floor = lambda c, b=beta: f"MAX(3,{c}{b})"  # noqa: E731
            if r.application.duty:
                wear = lambda c, f=floor: (  # noqa: E731
                    "(SUMPRODUCT(duty_work,--(ISNUMBER(duty_angles)),(duty_angles>3)*(duty_angles-3)+3)"
                    f"+SUMPRODUCT(duty_work,--NOT(ISNUMBER(duty_angles)))*{f(c)})"
                )
            else:
                wear = lambda c, f=floor: f"({c}{self.speed}*ABS({c}{self.torque})^(10/3)*{f(c)})"  # noqa: E731
            self._row("", "", lambda c, t=rating, w=wear: f"1.5*10^6*{t}^(10/3)/(prime_mover_factor*{w(c)})",
                      quantity="joint_life", part=f"joint {k}", values=r.life[:, k - 1])  # fmt: skip

    # Results

    def _results(self) -> None:
        """Write each result against its limit, then what only the exact chain gives."""
        say, sheet, r = self.say, self.results, self.r
        sheet.title(
            say("Results of line {line}", line=r.line.name),
            (say("Live: they follow inputs and states. Limits may be changed."),),
        )
        end = FIRST + self.count
        top = sheet.row
        sheet.row += 1
        heads = ["", say("unit"), say("normal"), say("maximum"), *self._heads(), say("verdict")]
        sheet.section(say("Checks"), heads)
        limits = _limits(r)
        rows = [row for one in self.found for limit in limits.get((one.quantity, one.part), ())
                for row in (self._checked(one, limit),)]  # fmt: skip
        place = f"${column(end)}${rows[0]}:${column(end)}${rows[-1]}" if rows else f"{column(end)}1"
        said = {g: say(g) for g in ("fail", "warn", "pass")}
        sheet.sheet.write_string(top, 0, say("Verdict"), self.book.title)
        verdict = (
            f'=IF(COUNTIF({place},"{said["fail"]}")>0,"{said["fail"]}",'
            f'IF(COUNTIF({place},"{said["warn"]}")>0,"{said["warn"]}","{said["pass"]}"))'
        )
        sheet.sheet.write_formula(top, 1, verdict, self.book.verdict, "")
        self.book.file.define_name(f"{self.tag}verdict", f"='{sheet.name}'!$B${top + 1}")
        self._colour(top, 1, top, 1)
        if rows:
            self._colour(rows[0] - 1, end, rows[-1] - 1, end)
        checked = {(one.quantity, one.part) for one in self.found if (one.quantity, one.part) in limits}
        sheet.section(say("Other results"), ["", say("unit"), "", "", *self._heads()])
        for one in self.found:
            if (one.quantity, one.part) not in checked and one.quantity not in _ONLY_FOR_LIMITS:
                self._shown(one, ("", ""))
        sheet.section(
            say("Exact results of cardan: values, they do not follow the inputs"),
            ["", say("unit"), "", "", *self._heads()],
        )
        for section in sections(r):
            for row in section.rows:
                if not row.method:
                    sheet.put(row.label(say), row.unit, row.values.tolist(), style=self.book.exact,
                              texts=(say("value"), ""))  # fmt: skip
        sheet.sheet.freeze_panes(0, 1)

    def _shown(self, one: _Result, texts: tuple[str, str]) -> int:
        """Write a row that shows a row of the calculation."""
        q = QUANTITIES[one.quantity]
        label = self.say.list(q.named(self.say.code), self.say.part(one.part))
        name = f"{self.tag}{one.quantity}_{one.part}".replace(" ", "_").rstrip("_")
        cells = [f"='{self.sheet.name}'!{c}{one.row}" for c in self.columns]
        return self.results.put(label, q.unit_name, cells, style=self.book.result, texts=texts, name=name)

    def _checked(self, one: _Result, limit: Limit) -> int:
        """Write a result with its limit as editable cells, its colours and its verdict."""
        say, sheet, book = self.say, self.results, self.book
        factor = QUANTITIES[one.quantity].factor
        row = self._shown(one, ("", ""))
        low, high = limit.band or (limit.normal, limit.maximum)
        for k, bound in ((2, low), (3, high)):
            if bound is None:
                sheet.sheet.write_blank(row - 1, k, None, book.input)
            else:
                sheet.sheet.write_number(row - 1, k, bound / factor, book.input)
        sheet.sheet.write_comment(row - 1, 2, str(limit.source), {"x_scale": 3})
        first, last = self.columns[0], self.columns[-1]
        normal, maximum, here = f"$C{row}", f"$D{row}", f"{first}{row}"
        values = f"${first}{row}:${last}{row}"
        if limit.band:
            above = (limit.above_angle or 0.0) / deg
            angle = f"'{self.sheet.name}'!{first}${self.largest}"
            angles = f"'{self.sheet.name}'!${first}{self.largest}:${last}{self.largest}"
            inside = f"AND({here}>{normal},{here}<{maximum},{angle}>{above:.12g})"
            colours = (("warn", inside), ("pass", f"NOT({inside})"))
            bad = f"SUMPRODUCT(({values}>{normal})*({values}<{maximum})*({angles}>{above:.12g}))>0"
            verdict = f'=IF({bad},"{say("warn")}","{say("pass")}")'
        else:
            sign, worst = (">", "MAX") if limit.sense == "<=" else ("<", "MIN")
            past = f"AND(ISNUMBER({maximum}),{{0}}{sign}{maximum})"
            near = f"AND(ISNUMBER({normal}),{{0}}{sign}{normal})"
            colours = (("fail", past.format(here)), ("warn", near.format(here)), ("pass", f"ISNUMBER({here})"))
            at = f"{worst}({values})"
            verdict = (
                f'=IF(COUNT({values})=0,"",IF({past.format(at)},"{say("fail")}",'
                f'IF({near.format(at)},"{say("warn")}","{say("pass")}")))'
            )
        for grade, rule in colours:
            sheet.sheet.conditional_format(
                row - 1, FIRST, row - 1, FIRST + self.count - 1,
                {"type": "formula", "criteria": f"={rule}", "format": book.graded[grade],
                 "stop_if_true": True},
            )  # fmt: skip
        sheet.sheet.write_formula(row - 1, FIRST + self.count, verdict, book.verdict, "")
        return row

    def _colour(self, top: int, left: int, bottom: int, right: int) -> None:
        """Colour cells that hold verdicts."""
        for grade, style in self.book.graded.items():
            self.results.sheet.conditional_format(top, left, bottom, right, {
                "type": "cell", "criteria": "==", "value": f'"{self.say(grade)}"', "format": style,
            })  # fmt: skip


_ONLY_FOR_LIMITS = (
    "joint_angle_min", "compound_angle", "angle_for_speed", "half_critical_band",
)  # fmt: skip
"""Quantities that say the same as another; shown where a limit asks about them."""


def _limits(r: Response) -> dict[tuple[str, str], list[Limit]]:
    """Return the limits that ask about each quantity and part of a line."""
    found: dict[tuple[str, str], list[Limit]] = {}
    for question in asked(r):
        for k, part in enumerate(question.parts):
            if np.isfinite(question.values[..., k]).any() or question.limit.above_angle is not None:
                name = "" if part == "line" else part.replace("centre bearing", "bearing")
                key = (question.limit.quantity, name)
                found.setdefault(key, []).append(question.limit)
    return found


def named_cells(r: Response) -> Iterator[str]:
    """Yield the names of a line's rows of results; tests and macros find them by these."""
    for quantity, part in _limits(r):
        yield f"{quantity}_{part}".replace(" ", "_").rstrip("_")
