"""The parametric workbook: AE-7, torque, bearing loads, critical speed and life as formulas.

For whoever has no Python: an angle, a length, a torque or a speed changed in the sheet of
inputs or of states changes every result. What needs the exact chain stands beside it as
values, marked so. Columns of states are the same in every sheet, so a formula reads down
its own column.
"""

import re
from collections.abc import Sequence
from dataclasses import dataclass
from datetime import datetime
from io import BytesIO
from itertools import product
from math import isnan
from typing import Any, TypeAlias
from zipfile import ZIP_DEFLATED, ZipFile

import numpy as np

from cardan.base.arrays import FloatArray
from cardan.base.formula import Cells, phasors, symbols, written
from cardan.base.part import LINE, Occasion, Part
from cardan.base.units import GPa, MPa, deg, mm, rpm
from cardan.base.verdict import Limit
from cardan.kinematics.equivalent import (
    Excitation,
    ae7_angle,
    ae7_shaking,
    ae7_sign,
    ae7_step,
    pythagorean_angle,
)
from cardan.loads import loads
from cardan.loads.approximate import bearing_force, end_force, left_over
from cardan.model.application import Application
from cardan.model.laminate import CompositeTube
from cardan.quantity.declared import LOAD, SPEED, TORQUE
from cardan.quantity.quantities import QUANTITIES
from cardan.quantity.response import Response
from cardan.quantity.strength import near_half
from cardan.report import front
from cardan.report.book import (
    EITHER_WAY,
    EMPTY,
    ENDLESS,
    FIRST,
    FRICTION,
    NOT_COMPUTED,
    NOT_NEGATIVE,
    PHASE,
    POSITIVE,
    SHARE,
    SLOPE,
    SWITCH,
    UNKNOWN,
    Allowed,
    Book,
    Cell,
    Sheet,
    column,
)
from cardan.report.extra import needed
from cardan.report.judged import Held, Judged, Live, verdict
from cardan.report.language import Language
from cardan.report.sheet import sections
from cardan.report.wording import STUDY_TITLES, cited
from cardan.shaft.life import life_rating, wear
from cardan.study.approval import Approval
from cardan.study.driveline import Asked, asked, needs_of
from cardan.study.finding import DRIVELINE, Finding

UNDATED = datetime(2000, 1, 1)
"""What a workbook says it was made on: when it really was is not what it is about."""


def workbook(of: Approval, *, say: Language) -> bytes:
    """Return the workbook of an application, all its lines, as an .xlsx file.

    Raises
    ------
    MissingExtra
        If XlsxWriter is not installed.
    """
    xlsxwriter = needed("xlsxwriter")
    raw = BytesIO()
    file = xlsxwriter.Workbook(raw, {"in_memory": True})
    file.set_properties({"created": UNDATED})  # the same application, the same bytes
    book = Book(file, say)
    tags = dict(zip((r.line.name for r in of.responses), _tags(of), strict=True))
    opening = front.open_front(book)
    inputs = book.sheet(say("Inputs"))
    top = _general(inputs, of.application)
    for r in of.responses:
        _line_inputs(inputs, r, tag=tags[r.line.name])
    judged: list[Judged] = []
    for r in of.responses:
        end = f" {r.line.name}" if len(tags) > 1 else ""
        line = _Line(book, r, tag=tags[r.line.name], end=end)
        judged.append(line.write())
    judged += [
        _study(book, finding, say, several=len(tags) > 1)
        for finding in of.findings
        if finding.study != DRIVELINE and (finding.checks or finding.unanswered)
    ]
    verdict(inputs, top, judged, name="verdict")
    front.fill(opening, of, judged)
    book.originals()
    book.file.close()
    return _computed_anew(raw.getvalue())


def _tags(of: Approval) -> list[str]:
    """Return what begins the names of each line's cells; nothing where there is one line."""
    if len(of.responses) < 2:
        return ["" for _ in of.responses]
    tags: list[str] = []
    for r in of.responses:
        tag = re.sub(r"\W", "_", r.line.name) + "_"
        tag = tag if tag[0].isalpha() or tag[0] == "_" else f"_{tag}"
        taken = {t.casefold() for t in tags}
        tags.append(f"{tag}{len(tags) + 1}_" if tag.casefold() in taken else tag)
    return tags


def _computed_anew(data: bytes) -> bytes:
    """Return a workbook without what stands for results that nobody has computed yet.

    A spreadsheet may believe the results in a file; one that is missing it computes.
    """
    out = BytesIO()
    with ZipFile(BytesIO(data)) as old, ZipFile(out, "w", ZIP_DEFLATED) as new:
        for item in old.infolist():
            content = old.read(item)
            if item.filename.startswith("xl/worksheets/sheet"):
                content = content.replace(f"</f><v>{NOT_COMPUTED}</v>".encode(), b"</f>")
                content = content.replace(b"</f><v></v>", b"</f>")
            item.date_time = (UNDATED.year, UNDATED.month, UNDATED.day, 0, 0, 0)
            new.writestr(item, content)
    return out.getvalue()


def _general(sheet: Sheet, a: Application) -> int:
    """Write what all lines share; return the row, from 0, that is kept for the verdict."""
    say, book = sheet.book.say, sheet.book
    sheet.sheet.set_column(0, 0, 46)
    sheet.sheet.set_column(1, 3, 11)
    sheet.sheet.set_column(FIRST, FIRST + 12, 11)
    sheet.title(
        a.title,
        (
            say("Driveline workbook: change what is coloured, and every result follows."),
            say(
                "Limits: {profile}. Positive slopes run down and to the right going rearward.",
                profile=a.profile,
            ),
        ),
    )
    top = sheet.row
    sheet.row += 1

    def put(
        label: str, unit: str, cells: Sequence[Cell], name: str, allow: Allowed = POSITIVE
    ) -> None:
        sheet.put(label, unit, cells, style=book.input, name=name, allow=allow)

    engine, gearbox, tyre = a.engine, a.gearbox, a.tyre
    sheet.section(say("Engine and gearbox"))
    turns, pulls = engine.full_load if engine else ((), ())
    put(say("engine speed"), "rpm", [float(v) / rpm for v in turns] or [None], "engine_speeds")
    put(say("engine torque"), "N·m", [float(v) for v in pulls] or [None], "engine_torques")
    put(say("gear ratios"), "", list(gearbox.ratios) if gearbox else [1.0], "gear_ratios")
    put(
        say("gearbox efficiency"),
        "",
        [gearbox.efficiency if gearbox else 1.0],
        "gearbox_efficiency",
        SHARE,
    )
    put(
        say("converter torque ratio"),
        "",
        [gearbox.converter_ratio if gearbox else 1.0],
        "converter_ratio",
    )
    put(
        say("transfer case, low range"),
        "",
        [gearbox.transfer_ratio if gearbox else 1.0],
        "transfer_ratio",
    )
    sheet.section(say("Application"))
    put(
        say("torque at the gearbox output, where given"),
        "N·m",
        [a.torque],
        "torque_given",
        NOT_NEGATIVE,
    )
    put(
        say("speed of the gearbox output, where given"),
        "rpm",
        [None if a.speed is None else a.speed / rpm],
        "speed_given",
    )
    put(say("shock factor"), "", [a.shock_factor], "shock_factor")
    put(say("prime mover factor"), "", [a.prime_mover_factor], "prime_mover_factor")
    put(say("tyre, friction"), "", [tyre.friction if tyre else None], "tyre_friction", FRICTION)
    put(
        say("tyre, static radius"), "mm", [tyre.static_radius / mm if tyre else None], "tyre_radius"
    )
    if a.duty or a.duty_cycle:
        sheet.section(say("Duty cycle"))
        _duty(sheet, a)
    return top


def _duty(sheet: Sheet, a: Application) -> None:
    """Write the duty cycle.

    Points are of the gearbox output. Those of a named cycle are shares of what a line carries
    at most and of its top speed, which the line's own calculation says.
    """
    say, book, cycle = sheet.book.say, sheet.book, a.duty_cycle

    def put(label: str, unit: str, cells: Sequence[Cell], name: str) -> None:
        sheet.put(label, unit, cells, style=book.input, name=name, allow=NOT_NEGATIVE)

    shares = [100 * p.share for p in (cycle.points if cycle else a.duty)]
    put(say("share of the life"), "%", shares, "duty_shares")
    if cycle:
        torques = [100 * p.torque_share for p in cycle.points]
        speeds = [100 * p.speed_share for p in cycle.points]
        put(say("share of the line's largest torque"), "%", torques, "duty_torques")
        put(say("share of the line's top speed"), "%", speeds, "duty_speeds")
    else:
        torques, speeds = [p.torque for p in a.duty], [p.speed / rpm for p in a.duty]
        put(say("torque at the gearbox output"), "N·m", torques, "duty_torques")
        put(say("speed of the gearbox output"), "rpm", speeds, "duty_speeds")
    angles = [None if p.angle is None else p.angle / deg for p in a.duty]
    put(say("joint angle, where given"), "deg", angles or [None] * len(shares), "duty_angles")


def _line_inputs(sheet: Sheet, r: Response, *, tag: str) -> None:
    """Write what belongs to one line but not to a state of it."""
    say, book, line, installed = sheet.book.say, sheet.book, r.line, r.demand.installed
    axle, share = installed.axle, r.demand.standing.line.share

    def put(
        label: str, unit: str, cells: Sequence[Cell], name: str, allow: Allowed = POSITIVE
    ) -> None:
        sheet.put(label, unit, cells, style=book.input, name=tag + name, allow=allow)

    sheet.section(say("Line {line}", line=line.name))
    put(say("share of the torque"), "", [share], "torque_share", NOT_NEGATIVE)
    put(say("line speed over gearbox speed"), "", [installed.speed_ratio], "speed_ratio")
    put(say("axle ratio"), "", [axle.ratio if axle else None], "axle_ratio")
    put(say("axle efficiency"), "", [axle.efficiency if axle else None], "axle_efficiency", SHARE)
    joints = [say.part(Part("joint", k)) for k in range(1, line.joint_count + 1)]
    sheet.section(say("Joints"), ["", "", "", "", *joints])
    ratings = [life_rating(size) if size else None for size in r.sizes]
    put(say("bearing rating Td"), "N·m", ratings, "joint_ratings")
    shafts = [say.part(Part("shaft", k)) for k in range(1, line.joint_count)]
    sheet.section(say("Shafts"), ["", "", "", "", *shafts])
    tubes = [s.tube for s in line.shafts]
    put(
        say("tube, outside diameter"),
        "mm",
        [t.outer / mm if t else None for t in tubes],
        "tube_outer",
    )
    put(say("tube, wall"), "mm", [t.wall / mm if t else None for t in tubes], "tube_wall")
    put(
        say("Young's modulus"),
        "GPa",
        [t.material.youngs_modulus / GPa if t else None for t in tubes],
        "tube_modulus",
    )
    put(say("density"), "kg/m³", [t.material.density if t else None for t in tubes], "tube_density")
    strengths = [t.material.yield_strength if t else None for t in tubes]
    put(
        say("yield strength"),
        "MPa",
        [None if s is None else s / MPa for s in strengths],
        "tube_yield",
    )
    put(say("yoke phase"), "deg", [s.phase / deg for s in line.shafts], "yoke_phases", PHASE)
    put(say("polar inertia"), "kg·m²", [s.polar_inertia for s in line.shafts], "polar_inertias")
    ahead = [
        s.centre_bearing.from_rear_joint / mm if s.centre_bearing else None for s in line.shafts
    ]
    put(say("centre bearing ahead of the rear joint"), "mm", ahead, "bearing_offsets", NOT_NEGATIVE)


@dataclass
class _Result:
    """A row of results: its quantity, its part, and the row of the calculation it shows."""

    quantity: str
    part: Part
    row: int
    values: FloatArray


_Complex: TypeAlias = tuple[str, str]
"""Where a complex number stands: its real and its imaginary part."""


class _Line:
    """The sheets of one line: its states, the calculation, the results."""

    def __init__(self, book: Book, response: Response, *, tag: str, end: str) -> None:
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

    def write(self) -> Judged:
        """Write all three; return the rows of limits."""
        self._states()
        self._calculation()
        return self._results()

    def _heads(self) -> list[str]:
        return [self.say.state(s) for s in self.r.demand.states]

    # States

    def _given(
        self, label: str, unit: str, values: Sequence[Cell], name: str, allow: Allowed
    ) -> int:
        return self.states.put(
            label, unit, values, style=self.book.input, name=self.tag + name, allow=allow
        )

    def _torque_given(self, state: int) -> Cell:
        """Return what a state says of the torque at the gearbox output.

        In brake wind-up the line carries the coast torque, which is an input here: brake and
        tyres would have to be weighed against each other for it.
        """
        given, d = self.r.application.states[state], self.r.demand
        if given.kind == "windup brake":
            torque = float(d.torque[state] / d.standing.line.share)
            return UNKNOWN if isnan(torque) else torque
        if given.torque is None:
            return '=IF(ISNUMBER(torque_given),torque_given,"")'
        return given.torque

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
            say("gearbox"),
            *(say.part(Part("shaft", k)) for k in range(1, self.n)),
            say("pinion"),
        ]
        side, top = r.layout.side / deg, r.layout.top / deg
        self.side = [
            self._given(m, "deg", side[:, k].tolist(), f"side_{k}", SLOPE)
            for k, m in enumerate(members)
        ]
        sheet.section(say("top slopes of the members"), heads)
        self.top = [
            self._given(m, "deg", top[:, k].tolist(), f"top_{k}", SLOPE)
            for k, m in enumerate(members)
        ]
        sheet.section(say("length"), heads)
        lengths = r.layout.lengths / mm
        self.lengths = [
            self._given(members[k + 1], "mm", lengths[:, k].tolist(), f"length_{k + 1}", POSITIVE)
            for k in range(self.n - 1)
        ]
        sheet.section(say("Demand"), heads)
        own = r.application.states
        torques = [self._torque_given(k) for k in range(len(own))]
        # The torque that winds an axle up is that of the lowest gear, and so is the speed.
        low = (
            'IF(COUNT(engine_speeds)=0,"",'
            "MAX(engine_speeds)/(MAX(gear_ratios)*MAX(1,transfer_ratio)))"
        )
        speeds: list[Cell] = [
            f"=IF(ISNUMBER(speed_given),speed_given,{low if s.kind == 'windup' else EMPTY})"
            if s.speed is None
            else s.speed / rpm
            for s in own
        ]
        self.torque_given = self._given(
            say("torque at the gearbox output, where given"),
            "N·m",
            torques,
            "state_torques",
            EITHER_WAY,
        )
        self.speed_given = self._given(
            say("speed of the gearbox output, where given"), "rpm", speeds, "state_speeds", POSITIVE
        )
        self.driven = self._given(
            say("load on the driven wheels at slip"),
            "N",
            r.demand.driven_load.tolist(),
            "driven_loads",
            NOT_NEGATIVE,
        )
        lasting = r.lasting.tolist()
        self.lasting = self._given(
            say("counts for the life (1 or 0)"), "", [float(x) for x in lasting], "lasting", SWITCH
        )
        self._under_duty()
        self.weight: list[list[int]] = []
        if r.gravity:
            sheet.section(say("Weight on the centre bearings (values of cardan)"), heads)
            still = loads(r.layout, r.turn, r.line, torque=0.0, gravity=r.gravity)
            force = still.bearing_forces.static
            for k in range(self.n - 2):
                part = say.part(Part("centre bearing", k + 1))
                self.weight.append(
                    [
                        self._given(
                            f"{part}, {axis}",
                            "N",
                            force[:, k, c].tolist(),
                            f"weight_{k + 1}_{axis}",
                            {"validate": "decimal", "criteria": "<", "value": 1e9},
                        )
                        for c, axis in enumerate("xyz")
                    ]
                )
        sheet.sheet.freeze_panes(0, FIRST)

    def _under_duty(self) -> None:
        """Write what the torque of each point of the duty cycle adds to joint angles, if any."""
        r, say = self.r, self.say
        lasting = np.flatnonzero(r.lasting & ~np.isnan(r.life).all(axis=-1)).tolist()
        self.moved = False
        if not lasting:
            return
        more = np.moveaxis(r.duty_angles - r.angles, 0, -1) / deg  # (S, n, points)
        self.moved = bool(np.abs(more[lasting]).max() > 1e-9)
        if not self.moved:
            return
        self.states.section(
            say("Joint angles added by the torques of the duty cycle (values of cardan)"),
            ["", "", "", "", *(say("point {k}", k=p + 1) for p in range(more.shape[-1]))],
        )
        for k, s in product(range(self.n), lasting):
            label = say.list(say.part(Part("joint", k + 1)), say.state(r.demand.states[s]))
            self._given(label, "deg", more[s, k].tolist(), f"duty_more_{k + 1}_{s + 1}", EITHER_WAY)

    # Calculation. A formula is written once: § stands for the letter of a state's column, and ¶
    # for its number.

    def _row(
        self,
        label: str,
        unit: str,
        formula: str,
        *,
        note: str = "",
        source: str = "",
        values: FloatArray | None = None,
        style: Any = None,
    ) -> str:
        """Write a row of formulas, one for each state; return the reference to it."""
        row = self.sheet.put(
            label,
            unit,
            [
                f'=IFERROR({formula.replace("§", c).replace("¶", str(s))},"")'
                for s, c in enumerate(self.columns, 1)
            ],
            style=style or self.book.formula,
            texts=(note, source),
            values=values,
        )
        return f"§{row}"

    def _result(
        self, quantity: str, formula: str, values: FloatArray, *, part: Part = LINE, note: Any = ""
    ) -> str:
        """Write a row that results and limits ask about; `values` are cardan's own, SI."""
        q, say = QUANTITIES[quantity], self.say
        shown = np.asarray(values, dtype=float) / q.factor
        reference = self._row(
            _label(quantity, part, say),
            q.unit_name,
            formula,
            note=str(note) or say.given(q.stated),
            source=cited(q.source, say),
            values=shown,
            style=self.book.result,
        )
        self.found.append(_Result(quantity, part, int(reference[1:]), shown))
        return reference

    def _followed(
        self, quantity: str, values: FloatArray, *, part: Part = LINE, **where: Cells
    ) -> str:
        """Write a row by the formula of its quantity, of the cells that hold its symbols."""
        formula = QUANTITIES[quantity].formula.cells(**where)
        return self._result(quantity, formula, values, part=part)

    def _of_state(self, row: int) -> str:
        """Return the reference to a row of the sheet of states."""
        return f"'{self.states.name}'!§{row}"

    def _of_part(self, name: str, k: int) -> str:
        """Return the reference to the k-th of the cells of a name, from 1."""
        return f"INDEX({self.tag}{name},1,{k})"

    def _calculation(self) -> None:
        """Write the method from top to bottom."""
        say, sheet = self.say, self.sheet
        about = say(
            "AE-7's method and closed forms, state by state. Complex numbers stand in two rows: "
            "along position 0 (re) and 90 deg (im)."
        )
        sheet.title(say("Calculation of line {line}", line=self.r.line.name), (about,))
        self._demand()
        self._angles()
        self._excitation()
        self._bearings()
        self._speed()
        self._life()
        sheet.sheet.freeze_panes(0, FIRST)

    def _section(self, text: str) -> None:
        say = self.say
        heads = ["", say("unit"), say("equation"), say("source"), *self._heads()]
        self.sheet.section(text, heads)

    def _demand(self) -> None:
        """Torque: engine against slip; speed."""
        tag, d = self.tag, self.r.demand
        self._section(self.say("Demand"))
        through = QUANTITIES["engine_torque"].formula.cells(
            Tm="MAX(engine_torques)", i="MAX(gear_ratios)*MAX(1,transfer_ratio)",
            η="gearbox_efficiency", k="converter_ratio", s=f"{tag}torque_share",
        )  # fmt: skip
        engine = self.engine = self._result(
            "engine_torque", f'IF(COUNT(engine_torques)=0,"",{through})', d.engine_torque
        )
        load = self._of_state(self.driven)
        known = f"AND(ISNUMBER({load}),ISNUMBER({tag}axle_ratio),ISNUMBER(tyre_friction))"
        grip = QUANTITIES["slip_torque"].formula.cells(
            μ="tyre_friction", N=load, re="tyre_radius/1000", iD=f"{tag}axle_ratio",
            ηD=f"{tag}axle_efficiency",
        )  # fmt: skip
        slip = self._result("slip_torque", f'IF({known},{grip},"")', d.slip_torque)
        given = self._of_state(self.torque_given)
        self.torque = self._result(
            "torque",
            f"IF(ISNUMBER({given}),{given}*{tag}torque_share,"
            f'IF(OR({given}="{UNKNOWN}",COUNT({engine},{slip})=0),"",MIN({engine},{slip})))',
            d.torque,
        )
        given = self._of_state(self.speed_given)
        top = (
            'IF(COUNT(engine_speeds)=0,"",'
            "MAX(engine_speeds)/(MIN(gear_ratios)*MIN(1,transfer_ratio)))"
        )
        self.speed = self._result(
            "speed", f"IF(ISNUMBER({given}),{given},{top})*{tag}speed_ratio", d.speed
        )
        self.omega = self._row("ω", "rad/s", f"{self.speed}*PI()/30")

    def _angles(self) -> None:
        """View angles, true angles and positions of the joints."""
        r, each = self.r, range(self.n)
        self._section(self.say("Joints"))
        self.bv: list[str] = []
        self.bh: list[str] = []
        self.beta: list[str] = []
        places: list[str] = []
        for k in each:
            part = Part("joint", k + 1)
            s1, s2, t1, t2 = (
                self._of_state(rows[j]) for rows in (self.side, self.top) for j in (k, k + 1)
            )
            v = self._result("side_angle", f"{s2}-{s1}", r.side_angles[:, k], part=part)
            h = self._result("top_angle", f"{t2}-{t1}", r.top_angles[:, k], part=part)
            # The members run along (1, a, b) and (1, e, f).
            a, e = (f"TAN(RADIANS({t}))" for t in (t1, t2))
            b, f = (f"(-TAN(RADIANS({s})))" for s in (s1, s2))
            sine = f"SQRT(({a}*{f}-{b}*{e})^2+({b}-{f})^2+({e}-{a})^2)"
            beta = f"DEGREES(ATAN2(1+{a}*{e}+{b}*{f},{sine}))"
            self.beta.append(self._result("joint_angle", beta, r.angles[:, k], part=part))
            position = f"IF(AND({v}=0,{h}=0),0,MOD(DEGREES(ATAN2({h},{v})),360))"
            places.append(self._result("joint_position", position, r.positions[:, k], part=part))
            self.bv.append(v)
            self.bh.append(h)
        for k, left in zip(r.pairs, np.moveaxis(r.pair_differences, -1, 0), strict=True):
            part, phase = Part("shaft", k + 1), self._of_part("yoke_phases", k + 1)
            (front, at), (rear, behind) = (
                (self.beta[j], f"RADIANS(2*{places[j]})") for j in (k, k + 1)
            )
            behind = f"({behind}+2*RADIANS({phase}))"
            re_, im_ = (f"({front}^2*{f}({at})-{rear}^2*{f}({behind}))" for f in ("COS", "SIN"))
            rest = f"IF({front}+{rear}=0,0,SQRT({re_}^2+{im_}^2)/({front}+{rear}))"
            self._result("end_angle_difference", rest, left, part=part)
        for k in r.lone:
            part = Part("joint", k + 1)
            self._result("odd_joint_angle", self.beta[k], r.angles[:, k], part=part)
        self.largest = self._row(
            self.say("largest joint angle"), "deg", f"MAX({','.join(self.beta)})"
        )
        # The same angles, as other limits ask about them.
        compound = np.hypot(r.side_angles, r.top_angles)
        turned = r.demand.speed[:, None] * r.angles
        for k, (beta, v, h) in enumerate(zip(self.beta, self.bv, self.bh, strict=True)):
            part = Part("joint", k + 1)
            self._followed("compound_angle", compound[:, k], part=part, βv=v, βh=h)
            self._followed("n_beta", turned[:, k], part=part, n=self.speed, β=beta)
            if not r.line.crosses[k]:
                continue
            self._result("joint_angle_min", beta, r.angles[:, k], part=part)
            self._followed(
                "angle_for_speed", turned[:, k] ** 2, part=part, ω=self.omega, β=f"RADIANS({beta})"
            )

    def _excitation(self) -> None:
        """AE-7's phasors: sₖ Dₖ², their sums, and what follows from them."""
        say, r = self.say, self.r
        ae7, plane = r.approximations["ae7"], r.approximations["in_plane"]
        crosses = r.line.crosses
        self._section(say("Excitation") + " (AE-7)")
        (h, v, phase), (sign, before) = symbols("βh", "βv", "ε"), phasors("s", "P")
        on, step = ae7_sign(sign, phase=phase), before + ae7_step(sign, side=v, top=h)
        level = before + ae7_step(sign, side=0, top=pythagorean_angle(v, h))
        self.signs: list[_Complex] = [("1", "0")]
        found: list[_Complex] = [("0", "0")]
        flat: list[_Complex] = [("0", "0")]
        for k in range(self.n):
            if k:
                part = say.part(Part("joint", k + 1))
                # Behind a joint of constant velocity yokes stand a quarter turn on.
                back = "" if crosses[k - 1] else "-90"
                turned = f"RADIANS({self._of_part('yoke_phases', k)}{back})"
                pair = on.pair(s=self.signs[-1], ε=turned)
                self.signs.append(self._complex(f"s, {part}", "", pair, note=on))
            bend = {"βh": f"RADIANS({self.bh[k]})", "βv": f"RADIANS({self.bv[k]})"}
            if not crosses[k]:
                bend = {"βh": "0", "βv": "0"}
            for made, name, of, note in (
                (found, "P", step, step),
                (flat, "Q", level, say("as if all joints lay in one plane")),
            ):
                pair = of.pair(s=self.signs[k], P=made[-1], **bend)
                made.append(self._complex(f"{name}{k + 1}", "rad²", pair, note=note))
        self._moduli(found[-1], flat[-1], ae7, plane)
        # Over the shafts: P in drive, P less the pinion's in coast.
        names = [f"P{k}" for k in range(1, self.n + 1)]
        *shafts, pinion = phasors(*names)
        inertia = symbols(*(f"J{k}" for k in range(1, self.n)))
        where: dict[str, Cells] = dict(zip(names, found[1:], strict=True))
        where |= {str(J): self._of_part("polar_inertias", k) for k, J in enumerate(inertia, 1)}
        released, (omega,) = [p - pinion for p in shafts], symbols("ω")
        for quantity, heavy, of, values in (
            ("inertia_drive_acceleration", False, shafts, ae7.drive.acceleration),
            ("inertia_coast_acceleration", False, released, ae7.coast.acceleration),
            ("inertia_drive_torque", True, shafts, ae7.drive_torque),
            ("inertia_coast_torque", True, released, ae7.coast_torque),
        ):
            if values is None:
                continue
            weighed = [J * p for J, p in zip(inertia, of, strict=True)] if heavy else of
            shaking = ae7_shaking(weighed, speed=omega)
            self._result(quantity, shaking.cells(ω=self.omega, **where), values, note=shaking)

    def _moduli(
        self, phasor: "_Complex", flat: "_Complex", ae7: Excitation, plane: Excitation
    ) -> None:
        """Write what the pinion's phasor says."""
        (omega,), (P,) = symbols("ω"), phasors("P")
        angle, shaking = ae7_angle(P), ae7_shaking([P], speed=omega)
        self._result(
            "equivalent_angle", f"DEGREES({angle.cells(P=phasor)})", ae7.torsional.angle, note=angle
        )
        self._result(
            "torsional_acceleration",
            shaking.cells(ω=self.omega, P=phasor),
            ae7.torsional.acceleration,
            note=shaking,
        )
        self._row(
            self.say("Torsional acceleration, all joints in one plane"),
            "rad/s²",
            shaking.cells(ω=self.omega, P=flat),
            note="ω² |Q|",
            values=plane.torsional.acceleration,
        )

    def _complex(self, label: str, unit: str, of: "_Complex", *, note: Any = "") -> "_Complex":
        """Write a complex number as two rows; return the references to them."""
        return (
            self._row(f"{label} re", unit, of[0], note=str(note)),
            self._row(f"{label} im", unit, of[1]),
        )

    def _bearings(self) -> None:
        """Centre-bearing forces at small angles, from the last shaft forward."""
        if self.n < 3:
            return
        say, r = self.say, self.r
        self._section(say("Centre bearings") + f" ({say('small angle')})")
        couples = [self._couples(k) for k in range(1, self.n)]
        joint = couples[-1]
        (couple, beyond), (length, overhang) = phasors("C", "F"), symbols("L", "e")
        held = bearing_force(couple, beyond=beyond, length=length, overhang=overhang)
        static, dynamic = r.small_angle_bearings
        for k in range(self.n - 2, 0, -1):
            at = {"L": self._of_state(self.lengths[k - 1]),
                  "e": self._of_part("bearing_offsets", k)}  # fmt: skip
            pairs = list(zip((say("mean"), say("order 2")), couples[k - 1], joint, strict=True))
            force = [
                self._complex(f"B{k} {name}", "N", held.pair(C=C, F=F, **at), note=held)
                for name, C, F in pairs
            ]
            joint = [
                self._complex(f"F{k} {name}", "N", (beyond + couple).pair(F=F, C=B))
                for (name, _, F), B in zip(pairs, force, strict=True)
            ]
            mean, swing = force
            size = abs(couple).cells(C=mean)
            if self.weight:
                wx, wy, wz = (self._of_state(w) for w in self.weight[k - 1])
                size = f"SQRT({wx}^2+({mean[0]}+{wy})^2+({mean[1]}+{wz})^2)"
            part = Part("centre bearing", k)
            still = np.linalg.norm(static[:, k - 1], axis=-1)
            self._result("centre_bearing_static", size, still, part=part)
            swung, moving = abs(couple).cells(C=swing), dynamic[:, k - 1]
            self._result("centre_bearing_dynamic", swung, moving, part=part)

    def _couples(self, k: int) -> "list[_Complex]":
        """Write the mean and the turning couple of shaft k as a force at its ends."""
        say, (front, rear, s1, s2) = self.say, phasors("Δ1", "Δ2", "s1", "s2")
        torque, length = symbols("T", "L")
        where: dict[str, Cells] = {
            "T": self.torque, "L": f"{self._of_state(self.lengths[k - 1])}/1000",
            # Only crosses swing.
            **{f"s{j}": self.signs[i] if self.r.line.crosses[i] else ("0", "0")
               for j, i in ((1, k - 1), (2, k))},
        }  # fmt: skip
        for name, j in (("Δ1", k - 1), ("Δ2", k)):
            where[name] = f"RADIANS({self.bh[j]})", f"-RADIANS({self.bv[j]})"
        label = f"{say('couple')} {say.part(Part('shaft', k))}"
        left = left_over(front, rear, signs=(s1, s2))
        forces = [end_force(one, torque=torque, length=length) for one in left]
        return [
            self._complex(f"{label}, {name}", "N", force.pair(**where), note=force)
            for name, force in zip((say("mean"), say("order 2")), forces, strict=True)
        ]

    def _speed(self) -> None:
        """Critical speed and shear of each tube."""
        r = self.r
        self._section(self.say("Speed and strength"))
        for k, shaft in enumerate(r.line.shafts, 1):
            if shaft.tube is None or isinstance(shaft.tube, CompositeTube):
                continue  # what plies do no formula of cells follows
            part, length = Part("shaft", k), self._of_state(self.lengths[k - 1])
            outer, wall, modulus, density, strength = (
                self._of_part(f"tube_{w}", k)
                for w in ("outer", "wall", "modulus", "density", "yield")
            )
            section = {"D": f"{outer}/1000", "d": f"({outer}-2*{wall})/1000"}
            alone = r.critical_speeds[:, k - 1]
            critical = self._followed(
                "critical_speed", alone, part=part,
                L=f"{length}/1000", E=f"{modulus}*10^9", ρ=density, **section,
            )  # fmt: skip
            share = self._followed(
                "critical_speed_ratio", r.demand.speed / alone, part=part, n=self.speed, nc=critical
            )
            if np.array_equal(near_half(r)[:, k - 1], r.demand.speed / alone, equal_nan=True):
                self._result("half_critical_band", share, r.demand.speed / alone, part=part)
            if shaft.tube.material.yield_strength:
                self._followed(
                    "tube_shear_utilisation", r.tube_shear_utilisation[:, k - 1], part=part,
                    T=self.torque, K="shock_factor", Re=f"{strength}*10^6", **section,
                )  # fmt: skip

    def _life(self) -> None:
        """Life of the needle bearings over the duty cycle; there is none without one."""
        r = self.r
        if np.isnan(r.life).all():
            return
        self._section(self.say.name("joint_life"))
        torque, speed, part_of = self._duty_of_line()
        of = written(wear, "T", speed="n", angle="β", rated_torque="Td", prime_mover_factor="K1")
        given = "ISNUMBER(duty_angles)"
        for k in range(self.n):
            if np.isnan(r.life[:, k]).all() or not r.line.crosses[k]:
                continue
            beta = f"({self.beta[k]}+{self.tag}duty_more_{k + 1}_¶)" if self.moved else self.beta[k]
            each = of.cells(
                T=f"{torque}*duty_torques{part_of}", n=f"{speed}*duty_speeds{part_of}",
                β=f"{given}*duty_angles+(1-{given})*{beta}", K1="prime_mover_factor",
                Td=self._of_part("joint_ratings", k + 1),
            )  # fmt: skip
            part = Part("joint", k + 1)
            worn = self._row(
                self.say.list(self.say("wear"), self.say.part(part)), "1/h",
                f"SUMPRODUCT(duty_shares/100,{each})", note=str(of),
            )  # fmt: skip
            lasting = self._of_state(self.lasting)
            hours = f"IF({worn}=0,{ENDLESS:.0E},1/{worn})"
            self._result(
                "joint_life",
                f'IF(AND({lasting}=1,ISNUMBER({worn})),{hours},"")',
                r.life[:, k],
                part=part,
            )

    def _duty_of_line(self) -> tuple[str, str, str]:
        """Return what the line makes of the duty cycle's torques and speeds, and their unit.

        A cycle of the gearbox output gives the line its share. A named one is of the largest
        torque and the top speed that the line has in any state that lasts.
        """
        line = self.r.demand.standing.line
        # A locked differential leaves a line all the torque at times, but not for its life.
        usual = "" if line.share == line.usual_share else f"*{line.usual_share / line.share:.15g}"
        if self.r.application.duty_cycle is None:
            return f"{self.tag}torque_share{usual}", f"{self.tag}speed_ratio", ""
        say, lasting = self.say, self._of_state(self.lasting)
        most = f"MIN(ABS({self.torque}),ABS({self.engine}){usual})" if usual else None
        found = (
            self._row(label, unit, f'IF({lasting}=1,ABS({of}),"")')
            for label, unit, of in (
                (say("torque, where it counts for the life"), "N·m", most or self.torque),
                (say("speed, where it counts for the life"), "rpm", self.speed),
            )
        )
        ends = self.columns[0], self.columns[-1]
        places = (":".join(row.replace("§", f"${c}$") for c in ends) for row in found)
        torque, speed = (f"IF(COUNT({place})=0,NA(),MAX({place}))" for place in places)
        return torque, speed, "/100"

    # Results

    def _results(self) -> Judged:
        """Write each limit with its values, then other results, then the exact chain's."""
        say, sheet, r = self.say, self.results, self.r
        sheet.title(
            say("Results of line {line}", line=r.line.name),
            (
                say("Live: they follow inputs and states. Limits may be changed."),
                say("As computed: what cardan found; stale once an input is changed."),
            ),
        )
        top = sheet.row
        sheet.row += 1
        judged = Judged(sheet, self._heads())
        # What is sought over operating points the formulas have at the state's own alone.
        followed = [one for one in self.found if not QUANTITIES[one.quantity].sought]
        found = {(one.quantity, one.part): one for one in followed}
        held: list[tuple[Asked, int, _Result | None]] = []
        for question in asked(r):
            for k, part in enumerate(question.parts):
                one = found.get((question.limit.quantity, part))
                if question.may[:, k].any():
                    held.append((question, k, one))
                if one is not None and _worse_elsewhere(question, k):
                    held.append((question, k, None))
        for title, live in ((say("Checks, live"), True), (say("Checks, as computed"), False)):
            rows = [h for h in held if (h[2] is not None) == live]
            if rows:
                judged.section(title)
            for question, k, one in rows:
                judged.row(self._held(question, k, one))
        judged.close(top, f"{self.tag}verdict" if self.tag else "")
        checked = {(q.limit.quantity, q.parts[k]) for q, k, _ in held}
        sheet.section(say("Other results"), ["", say("unit"), "", "", *self._heads()])
        for one in self.found:
            beside = (one.quantity, one.part) not in checked or one not in followed
            if beside and one.quantity not in _ONLY_FOR_LIMITS:
                self._shown(one)
        sheet.section(
            say("Exact results of cardan: values, they do not follow the inputs"),
            ["", say("unit"), "", "", *self._heads()],
        )
        for section in sections(r):
            for row in section.rows:
                if not row.method:
                    sheet.put(
                        row.label(say),
                        row.unit,
                        row.values.tolist(),
                        style=self.book.exact,
                        texts=(say("value"), ""),
                    )
        sheet.sheet.freeze_panes(0, 1)
        return judged

    def _cells(self, one: _Result) -> tuple[str, ...]:
        """Return cells that show a row of the calculation."""
        return tuple(f"='{self.sheet.name}'!{c}{one.row}" for c in self.columns)

    def _shown(self, one: _Result) -> None:
        """Write a row that shows a row of the calculation, and how that approximates."""
        label, name = _label(one.quantity, one.part, self.say), cell_name(one.quantity, one.part)
        if QUANTITIES[one.quantity].sought:
            method = _BY_METHOD[one.quantity]
            label = f"{label} ({self.say(method)})"
            name = f"{name}_{method.replace(' ', '_')}"
        self.results.put(
            label, QUANTITIES[one.quantity].unit_name, self._cells(one),
            style=self.book.result, values=one.values, name=self.tag + name,
        )  # fmt: skip

    def _held(self, question: Asked, k: int, one: _Result | None) -> Held:
        """Return the row of one part that a limit asks about."""
        limit, part = question.limit, question.parts[k]
        values = (question.values if one is None else question.own)[:, k]
        missing = question.asks[:, k] & np.isnan(values)
        lacks = [needs_of(self.r, question, int(s), k) for s in np.flatnonzero(missing)]
        named = part.kind != "clearance"
        label, name = _label(limit.quantity, part, self.say), cell_name(limit.quantity, part)
        if one is None and _worse_elsewhere(question, k):
            label = self.say("{what}, at the worst operating point", what=label)
            name = f"{name}_worst"
        return Held(
            label=label,
            limit=limit,
            values=values,
            may=question.may[:, k],
            missing=missing,
            needs=tuple(dict.fromkeys(n for needs in lacks for n in needs)),
            name=self.tag + name if named else "",
            live=self._live(one) if one else None,
        )

    def _live(self, one: _Result) -> Live:
        """Return the formulas of a row of the calculation, as limits ask about it."""
        here = f"'{self.sheet.name}'!"
        still = self.r.gravity == 0 and self.r.unbalance is None
        idle = {id(SPEED): self.speed, id(TORQUE): self.torque} | (
            {id(LOAD): self.torque} if still else {}
        )
        needs = (idle.get(id(need)) for need in QUANTITIES[one.quantity].needs)
        return Live(
            cells=self._cells(one),
            values=one.values,
            angle=here + self.largest,
            idle=tuple(here + n for n in needs if n),
            method=_BY_METHOD.get(one.quantity, ""),
        )


def _worse_elsewhere(question: Asked, k: int) -> bool:
    """Whether a part is worse at another operating point than at a state's own."""
    sought = QUANTITIES[question.limit.quantity].sought
    return not sought and not np.array_equal(
        question.values[:, k], question.own[:, k], equal_nan=True
    )


def _study(book: Book, of: Finding[Any], say: Language, *, several: bool) -> Judged:
    """Write the limits of a study beside the driveline's: all as computed."""
    title = say(STUDY_TITLES[of.study])
    sheet = book.sheet(title)
    sheet.sheet.set_column(0, 0, 60)
    sheet.sheet.set_column(1, 3, 12)
    when = list(dict.fromkeys(c.when for c in of.checks))
    sheet.title(title, (say("As computed: what cardan found; stale once an input is changed."),))
    top = sheet.row
    sheet.row += 1
    judged = Judged(sheet, [say.occasion(w) for w in when] or [""])
    judged.section(say("Checks, as computed"))
    rows: dict[tuple[Limit, str, Part], dict[Occasion, float]] = {}
    for c in of.checks:
        rows.setdefault((c.limit, c.line, c.part), {})[c.when] = c.value
    every = np.ones(judged.count, dtype=bool)
    for (limit, line, part), values in rows.items():
        label = say.list(line if several else "", _label(limit.quantity, part, say))
        across = np.array([values.get(w, np.nan) for w in when])
        judged.row(Held(label=label, limit=limit, values=across, may=every, missing=~every))
    for u in of.unanswered:
        label = say.list(u.line if several else "", _label(u.quantity, u.part, say))
        nothing, first = np.full(judged.count, np.nan), np.arange(judged.count) == 0
        judged.row(Held(label=label, limit=u.limit, values=nothing, may=every, missing=first,
                        needs=u.needs))  # fmt: skip
    judged.close(top, "")
    sheet.sheet.freeze_panes(0, 1)
    return judged


_BY_METHOD = {
    **dict.fromkeys(
        (
            "equivalent_angle", "torsional_acceleration", "inertia_drive_acceleration",
            "inertia_coast_acceleration", "inertia_drive_torque", "inertia_coast_torque",
        ),
        "AE-7",
    ),
    **dict.fromkeys(("centre_bearing_static", "centre_bearing_dynamic"), "small angle"),
}  # fmt: skip
"""Quantities that the workbook's formulas only approximate, and how."""

_ONLY_FOR_LIMITS = (
    "joint_angle_min",
    "compound_angle",
    "angle_for_speed",
    "half_critical_band",
)
"""Quantities that say the same as another; shown where a limit asks about them."""


def _label(quantity: str, part: Part, say: Language) -> str:
    """Return what a row of results is called."""
    return say.list(say.name(quantity), "" if part == LINE else say.part(part))


def cell_name(quantity: str, part: Part) -> str:
    """Return the name of a row of results; tests and macros find it by this."""
    said = "" if part == LINE else str(part).removeprefix("centre ")
    return f"{quantity}_{said}".replace(" ", "_").rstrip("_")
