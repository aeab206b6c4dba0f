"""Sheet of the calculation of a line: AE-7, torque, bearing loads, critical speed, life."""

from dataclasses import dataclass
from typing import Any, TypeAlias

import numpy as np

from cardan.checks.quantities.registry import QUANTITIES
from cardan.checks.quantities.strength import (
    distance_from_half_critical,
    half_critical_speed_ratio,
)
from cardan.core.arrays import FloatArray
from cardan.core.labels import WHOLE_LINE, Part
from cardan.core.symbolic import CellReference, complex_symbols, symbols, trace_expression
from cardan.core.units import deg, mm, rpm
from cardan.documents.workbook_states import (
    GEOMETRY_OF_OTHER_TORQUE,
    LineSheet,
    StatesSheet,
)
from cardan.model.laminate import CompositeTube
from cardan.physics.kinematics.equivalent_angle import (
    KinematicExcitation,
    ae7_acceleration,
    ae7_equivalent_angle,
    ae7_phasor_term,
    ae7_sign_of_next_joint,
    true_angle_by_pythagoras,
)
from cardan.physics.loads.small_angle import (
    bearing_force,
    residual_angles,
    shaft_end_force_of_couple,
)
from cardan.physics.strength.bearing_life import cross_joint_life_consumption_rate
from cardan.physics.strength.critical_speed import HALF_CRITICAL_SPEED_RATIO_RANGE
from cardan.render.i18n import Translator
from cardan.render.phrases import citation
from cardan.render.xlsx import (
    FIRST_STATE_COLUMN,
    INFINITY_CELL_VALUE,
    UNKNOWN_NUMBER_CELL_TEXT,
    WorkbookWriter,
)


@dataclass
class ResultRow:
    """A row of results: its quantity, its part, and the row of the calculation it shows."""

    quantity: str
    part: Part
    row: int
    values: FloatArray
    approximation: str = ""
    """How the formula approximates `cardan`; "" where it is as exact."""

    @property
    def follows_geometry(self) -> bool:
        """Whether it changes with slopes and lengths."""
        at_gearbox = self.quantity == "joint_torque_utilisation" and self.part.number == 1
        return not at_gearbox and self.quantity not in _QUANTITIES_WITHOUT_GEOMETRY


_QUANTITIES_WITHOUT_GEOMETRY = (
    "engine_torque",
    "slip_torque",
    "torque",
    "speed",
    "tube_shear_utilisation",
)
"""Quantities that slopes and lengths do not change."""

_APPROXIMATION_BY_QUANTITY = {
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

_Complex: TypeAlias = tuple[str, str]
"""Where a complex number stands: its real and its imaginary part."""


class CalculationSheet(LineSheet):
    """The method from top to bottom: a formula is written once for all states.

    § stands for the letter of a state's column, and ¶ for its number.
    """

    def __init__(self, book: WorkbookWriter, states: StatesSheet, *, title: str) -> None:
        super().__init__(book, states.r, title=title, tag=states.tag, note_width=34)
        self.states = states
        self.found: list[ResultRow] = []
        self.moved_states: tuple[int, ...] = ()
        self.other_torque = ""

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
        row = self.sheet.write_row(
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
        self,
        quantity: str,
        formula: str,
        values: FloatArray,
        *,
        part: Part = WHOLE_LINE,
        note: Any = "",
        approximation: str = "",
    ) -> str:
        """Write a row that results and limits use; `values` are cardan's own, SI."""
        q, say = QUANTITIES[quantity], self.say
        shown = np.asarray(values, dtype=float) / q.si_factor
        reference = self._row(
            result_label(quantity, part, say),
            q.unit_symbol,
            formula,
            note=str(note) or say.translate_if_known(q.equation_text),
            source=citation(q.source, say),
            values=shown,
            style=self.book.result,
        )
        method = approximation or _APPROXIMATION_BY_QUANTITY.get(quantity, "")
        self.found.append(ResultRow(quantity, part, int(reference[1:]), shown, method))
        return reference

    def _followed(
        self, quantity: str, values: FloatArray, *, part: Part = WHOLE_LINE, **where: CellReference
    ) -> str:
        """Write a row by the formula of its quantity, of the cells that hold its symbols."""
        formula = QUANTITIES[quantity].formula.to_spreadsheet(**where)
        return self._result(quantity, formula, values, part=part)

    def _of_part(self, name: str, k: int) -> str:
        """Return the reference to the k-th of the cells of a name, from 1."""
        return f"INDEX({self.tag}{name},1,{k})"

    def write(self) -> None:
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
        sheet.sheet.freeze_panes(0, FIRST_STATE_COLUMN)

    def _section(self, text: str) -> None:
        say = self.say
        heads = ["", say("unit"), say("equation"), say("source"), *self.heads]
        self.sheet.section(text, heads)

    def _demand(self) -> None:
        """Torque: engine against slip; speed."""
        tag, d = self.tag, self.r.demand
        self._section(self.say("Demand"))
        through = QUANTITIES["engine_torque"].formula.to_spreadsheet(
            Tm="MAX(engine_torques)", i="MAX(gear_ratios)*MAX(1,transfer_ratio)",
            η="gearbox_efficiency", k="converter_ratio", s=f"{tag}torque_share",
        )  # fmt: skip
        engine = self.engine = self._result(
            "engine_torque", f'IF(COUNT(engine_torques)=0,"",{through})', d.engine_torque
        )
        load = self.states.cell(self.states.driven)
        known = f"AND(ISNUMBER({load}),ISNUMBER({tag}axle_ratio),ISNUMBER(tyre_friction))"
        grip = QUANTITIES["slip_torque"].formula.to_spreadsheet(
            μ="tyre_friction", N=load, re="tyre_radius/1000", iD=f"{tag}axle_ratio",
            ηD=f"{tag}axle_efficiency",
        )  # fmt: skip
        slip = self._result("slip_torque", f'IF({known},{grip},"")', d.slip_torque)
        given = self.states.cell(self.states.torque_given)
        self.torque = self._result(
            "torque",
            f"IF(ISNUMBER({given}),{given}*{tag}torque_share,"
            f'IF(OR({given}="{UNKNOWN_NUMBER_CELL_TEXT}",COUNT({engine},{slip})=0),"",MIN({engine},{slip})))',
            d.torque,
        )
        given = self.states.cell(self.states.speed_given)
        top = (
            'IF(COUNT(engine_speeds)=0,"",'
            "MAX(engine_speeds)/(MIN(gear_ratios)*MIN(1,transfer_ratio)))"
        )
        self.speed = self._result(
            "speed", f"IF(ISNUMBER({given}),{given},{top})*{tag}speed_ratio", d.speed
        )
        follows = ",".join(str(int(one)) for one in self.r.inputs.follows_engine)
        self.reached_speed = self._row(
            self.say("speed that engine and highest gear reach"),
            "rpm",
            f"IF(AND(CHOOSE(¶,{follows})=1,COUNT(engine_speeds)>0),"
            f"MAX({self.speed},{top}*{tag}speed_ratio),{self.speed})",
            values=self.r.inputs.reached_speed / rpm,
        )
        self.omega = self._row("ω", "rad/s", f"{self.speed}*PI()/30")
        self._geometry_of_other_torque()

    def _geometry_of_other_torque(self) -> None:
        """Write in which wind-up states the axle no longer stands as their torque pitches it.

        There slopes and lengths are those of the torque, axle and tyre as written, until
        another slope of the pinion is typed in.
        """
        r, tag = self.r, self.tag
        moved = r.demand.static_state.moved_by_own_torque & ~np.isnan(r.demand.torque)
        self.moved_states = tuple(np.flatnonzero(moved).tolist())
        if not self.moved_states:
            return
        axle, tyre = r.demand.installed.axle, r.application.tyre
        constants = (
            [(f"{tag}axle_ratio", axle.ratio), (f"{tag}axle_efficiency", axle.efficiency)]
            if axle
            else []
        )
        if tyre:
            constants += [
                ("tyre_friction", tyre.friction),
                ("tyre_radius", tyre.static_radius / mm),
            ]
        pinion = self.states.cell(self.states.side[-1])
        cells: list[str] = []
        for s, letter in enumerate(self.columns):
            given = [(self.torque.replace("§", letter), float(r.demand.torque[s])), *constants]
            changed = ",".join(_differs(cell, value) for cell, value in given)
            typed = _differs(pinion.replace("§", letter), float(r.layout.side[s, -1] / deg))
            other = f"=IFERROR(IF(AND(OR({changed}),NOT({typed})),1,0),1)"
            cells.append(other if s in self.moved_states else "=0")
        row = self.sheet.write_row(
            self.say("slopes are those of another torque (1): type the pinion's"), "", cells,
            style=self.book.formula, values=np.zeros(len(cells)),
            name=f"{tag}{GEOMETRY_OF_OTHER_TORQUE}",
        )  # fmt: skip
        self.other_torque = f"'{self.sheet.name}'!§{row}"

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
                self.states.cell(rows[j])
                for rows in (self.states.side, self.states.top)
                for j in (k, k + 1)
            )
            v = self._result("side_angle", f"{s2}-{s1}", r.kinematics.side_angles[:, k], part=part)
            h = self._result("top_angle", f"{t2}-{t1}", r.kinematics.top_angles[:, k], part=part)
            # The members run along (1, a, b) and (1, e, f).
            a, e = (f"TAN(RADIANS({t}))" for t in (t1, t2))
            b, f = (f"(-TAN(RADIANS({s})))" for s in (s1, s2))
            sine = f"SQRT(({a}*{f}-{b}*{e})^2+({b}-{f})^2+({e}-{a})^2)"
            beta = f"DEGREES(ATAN2(1+{a}*{e}+{b}*{f},{sine}))"
            self.beta.append(self._result("joint_angle", beta, r.joint_angles[:, k], part=part))
            position = f"IF(AND({v}=0,{h}=0),0,MOD(DEGREES(ATAN2({h},{v})),360))"
            places.append(
                self._result(
                    "joint_position", position, r.kinematics.joint_plane_positions[:, k], part=part
                )
            )
            self.bv.append(v)
            self.bh.append(h)
        for k, left in zip(
            r.kinematics.paired_shafts,
            np.moveaxis(r.kinematics.pair_angle_differences, -1, 0),
            strict=True,
        ):
            part, phase = Part("shaft", k + 1), self._of_part("yoke_phases", k + 1)
            (front, at), (rear, behind) = (
                (self.beta[j], f"RADIANS(2*{places[j]})") for j in (k, k + 1)
            )
            behind = f"({behind}+2*RADIANS({phase}))"
            re_, im_ = (f"({front}^2*{f}({at})-{rear}^2*{f}({behind}))" for f in ("COS", "SIN"))
            rest = f"IF({front}+{rear}=0,0,SQRT({re_}^2+{im_}^2)/({front}+{rear}))"
            self._result("end_angle_difference", rest, left, part=part)
        for k in r.kinematics.unpaired_joints:
            part = Part("joint", k + 1)
            self._result("odd_joint_angle", self.beta[k], r.joint_angles[:, k], part=part)
        crosses = [b for b, is_cross in zip(self.beta, r.line.is_cross, strict=True) if is_cross]
        self.largest = self._row(
            self.say("largest angle of a cross"), "deg", f"MAX({','.join(crosses or ['0'])})"
        )
        # The same angles, as other limits use them.
        compound = np.hypot(r.kinematics.side_angles, r.kinematics.top_angles)
        turned = r.demand.speed[:, None] * r.joint_angles
        for k, (beta, v, h) in enumerate(zip(self.beta, self.bv, self.bh, strict=True)):
            part = Part("joint", k + 1)
            self._followed("compound_angle", compound[:, k], part=part, βv=v, βh=h)
            self._followed("n_beta", turned[:, k], part=part, n=self.speed, β=beta)
            if not r.line.is_cross[k]:
                continue
            self._result("joint_angle_min", beta, r.joint_angles[:, k], part=part)
            self._followed(
                "angle_for_speed", turned[:, k] ** 2, part=part, ω=self.omega, β=f"RADIANS({beta})"
            )

    def _excitation(self) -> None:
        """AE-7's phasors: sₖ Dₖ², their sums, and what follows from them."""
        say, r = self.say, self.r
        ae7, plane = (
            r.kinematics.approximate_excitations["ae7"],
            r.kinematics.approximate_excitations["in_plane"],
        )
        crosses = r.line.is_cross
        self._section(say("Excitation") + " (AE-7)")
        (h, v, phase), (sign, before) = symbols("βh", "βv", "ε"), complex_symbols("s", "P")
        on, step = (
            ae7_sign_of_next_joint(sign, phase=phase),
            before + ae7_phasor_term(sign, side=v, top=h),
        )
        level = before + ae7_phasor_term(sign, side=0, top=true_angle_by_pythagoras(v, h))
        self.signs: list[_Complex] = [("1", "0")]
        found: list[_Complex] = [("0", "0")]
        self.phasors = found
        flat: list[_Complex] = [("0", "0")]
        for k in range(self.n):
            if k:
                part = say.part(Part("joint", k + 1))
                # Behind a joint of constant velocity yokes stand a quarter turn on.
                back = "" if crosses[k - 1] else "-90"
                turned = f"RADIANS({self._of_part('yoke_phases', k)}{back})"
                pair = on.to_spreadsheet_pair(s=self.signs[-1], ε=turned)
                self.signs.append(self._complex(f"s, {part}", "", pair, note=on))
            bend = {"βh": f"RADIANS({self.bh[k]})", "βv": f"RADIANS({self.bv[k]})"}
            if not crosses[k]:
                bend = {"βh": "0", "βv": "0"}
            for made, name, of, note in (
                (found, "P", step, step),
                (flat, "Q", level, say("as if all joints lay in one plane")),
            ):
                pair = of.to_spreadsheet_pair(s=self.signs[k], P=made[-1], **bend)
                made.append(self._complex(f"{name}{k + 1}", "rad²", pair, note=note))
        self._moduli(found[-1], flat[-1], ae7, plane)
        # Over the shafts: P in drive, P less the pinion's in overrun.
        names = [f"P{k}" for k in range(1, self.n + 1)]
        *shafts, pinion = complex_symbols(*names)
        inertia = symbols(*(f"J{k}" for k in range(1, self.n)))
        where: dict[str, CellReference] = dict(zip(names, found[1:], strict=True))
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
            shaking = ae7_acceleration(weighed, speed=omega)
            self._result(
                quantity, shaking.to_spreadsheet(ω=self.omega, **where), values, note=shaking
            )

    def _moduli(
        self,
        phasor: "_Complex",
        flat: "_Complex",
        ae7: KinematicExcitation,
        plane: KinematicExcitation,
    ) -> None:
        """Write what the pinion's phasor says."""
        (omega,), (P,) = symbols("ω"), complex_symbols("P")
        angle, shaking = ae7_equivalent_angle(P), ae7_acceleration([P], speed=omega)
        self._result(
            "equivalent_angle",
            f"DEGREES({angle.to_spreadsheet(P=phasor)})",
            ae7.torsional.angle,
            note=angle,
        )
        self._result(
            "torsional_acceleration",
            shaking.to_spreadsheet(ω=self.omega, P=phasor),
            ae7.torsional.acceleration,
            note=shaking,
        )
        self._row(
            self.say("Torsional acceleration, all joints in one plane"),
            "rad/s²",
            shaking.to_spreadsheet(ω=self.omega, P=flat),
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
        (couple, beyond), (length, overhang) = complex_symbols("C", "F"), symbols("L", "e")
        held = bearing_force(couple, beyond=beyond, length=length, overhang=overhang)
        static, dynamic = r.rigid_loads.small_angle_bearing_forces
        for k in range(self.n - 2, 0, -1):
            at = {"L": self.states.cell(self.states.lengths[k - 1]),
                  "e": self._of_part("bearing_offsets", k)}  # fmt: skip
            pairs = list(zip((say("mean"), say("order 2")), couples[k - 1], joint, strict=True))
            force = [
                self._complex(
                    f"B{k} {name}", "N", held.to_spreadsheet_pair(C=C, F=F, **at), note=held
                )
                for name, C, F in pairs
            ]
            joint = [
                self._complex(f"F{k} {name}", "N", (beyond + couple).to_spreadsheet_pair(F=F, C=B))
                for (name, _, F), B in zip(pairs, force, strict=True)
            ]
            mean, swing = force
            size = abs(couple).to_spreadsheet(C=mean)
            if self.states.weight:
                wx, wy, wz = (self.states.cell(w) for w in self.states.weight[k - 1])
                size = f"SQRT({wx}^2+({mean[0]}+{wy})^2+({mean[1]}+{wz})^2)"
            part = Part("centre bearing", k)
            still = np.linalg.norm(static[:, k - 1], axis=-1)
            self._result("centre_bearing_static", size, still, part=part)
            swung, moving = abs(couple).to_spreadsheet(C=swing), dynamic[:, k - 1]
            self._result("centre_bearing_dynamic", swung, moving, part=part)

    def _couples(self, k: int) -> "list[_Complex]":
        """Write the mean and the turning couple of shaft k as a force at its ends."""
        say, (front, rear, s1, s2) = self.say, complex_symbols("Δ1", "Δ2", "s1", "s2")
        torque, length = symbols("T", "L")
        where: dict[str, CellReference] = {
            "T": self.torque, "L": f"{self.states.cell(self.states.lengths[k - 1])}/1000",
            # Only crosses swing.
            **{f"s{j}": self.signs[i] if self.r.line.is_cross[i] else ("0", "0")
               for j, i in ((1, k - 1), (2, k))},
        }  # fmt: skip
        for name, j in (("Δ1", k - 1), ("Δ2", k)):
            where[name] = f"RADIANS({self.bh[j]})", f"-RADIANS({self.bv[j]})"
        label = f"{say('couple')} {say.part(Part('shaft', k))}"
        left = residual_angles(front, rear, signs=(s1, s2))
        forces = [shaft_end_force_of_couple(one, torque=torque, length=length) for one in left]
        return [
            self._complex(f"{label}, {name}", "N", force.to_spreadsheet_pair(**where), note=force)
            for name, force in zip((say("mean"), say("order 2")), forces, strict=True)
        ]

    def _speed(self) -> None:
        """Critical speed and shear of each tube."""
        r, (low, high) = self.r, HALF_CRITICAL_SPEED_RATIO_RANGE
        self._section(self.say("Speed and strength"))
        for k, shaft in enumerate(r.line.shafts, 1):
            if shaft.tube is None or isinstance(shaft.tube, CompositeTube):
                continue  # what plies do no formula of cells follows
            part, length = Part("shaft", k), self.states.cell(self.states.lengths[k - 1])
            outer, wall, modulus, density, strength = (
                self._of_part(f"tube_{w}", k)
                for w in ("outer", "wall", "modulus", "density", "yield")
            )
            section = {"D": f"{outer}/1000", "d": f"({outer}-2*{wall})/1000"}
            alone = r.strength.critical_speeds[:, k - 1]
            critical = self._followed(
                "critical_speed", alone, part=part,
                L=f"{length}/1000", E=f"{modulus}*10^9", ρ=density, **section,
            )  # fmt: skip
            ratio = r.inputs.reached_speed / alone
            share = self._followed(
                "critical_speed_ratio", ratio, part=part, n=self.reached_speed, nc=critical
            )
            own = r.demand.speed / alone
            nearest = np.where(
                distance_from_half_critical(ratio) < distance_from_half_critical(own), ratio, own
            )
            if np.array_equal(half_critical_speed_ratio(r)[:, k - 1], nearest, equal_nan=True):
                off, off_own = (
                    f"MAX(({low}-{v})/{low},({v}-{high})/{high})"
                    for v in (share, f"{self.speed}/{critical}")
                )
                self._result(
                    "half_critical_band",
                    f"IF({off}<{off_own},{share},{self.speed}/{critical})",
                    nearest, part=part,
                )  # fmt: skip
            if shaft.tube.material.yield_strength:
                self._followed(
                    "tube_shear_utilisation", r.strength.tube_shear_utilisation[:, k - 1],
                    part=part,
                    T=self.torque, K="shock_factor", Re=f"{strength}*10^6", **section,
                )  # fmt: skip
        self._joint_torques()

    def _joint_torques(self) -> None:
        """Largest torque round a turn at each joint over its elastic limit.

        What it turns through ahead of it makes the torque uneven: ahead of the second joint by
        the angle of the first, further back by AE-7's phasor, a quarter of which is the
        amplitude that `LineStrength.sizing_torque` has of the exact chain.
        """
        r, known = self.r, np.isfinite(self.r.inputs.rating("peak_torque"))
        braked = ",".join(str(int(kind == "windup brake")) for kind in r.inputs.state_kinds)
        torque, engine = f"ABS({self.torque})", self.engine
        largest = (
            f"shock_factor*IF(AND(ISNUMBER({engine}),CHOOSE(¶,{braked})=0),"
            f"MAX({engine},IF(ISNUMBER({self.torque}),{torque},0)),{torque})"
        )
        for k in np.flatnonzero(known).tolist():
            exact, uneven = k < 2, "1"
            if k == 1 and r.line.is_cross[0]:
                uneven = f"COS(RADIANS({self.beta[0]}))"
            elif not exact:
                re_, im_ = self.phasors[k]
                size = f"SQRT({re_}^2+{im_}^2)/4"
                uneven = f"((1-{size})/(1+{size}))"
            self._result(
                "joint_torque_utilisation",
                f"{largest}/({self._of_part('joint_peak_torques', k + 1)}*{uneven})",
                r.strength.joint_torque_utilisation[:, k],
                part=Part("joint", k + 1),
                approximation="" if exact else "AE-7",
            )

    def _life(self) -> None:
        """Life of the needle bearings over the duty cycle; there is none without one."""
        r = self.r
        if np.isnan(r.strength.needle_bearing_life).all():
            return
        self._section(self.say.name("joint_life"))
        torque, speed, part_of = self._duty_of_line()
        of = trace_expression(
            cross_joint_life_consumption_rate,
            "T",
            speed="n",
            angle="β",
            rated_torque="Td",
            prime_mover_factor="K1",
        )
        given = "ISNUMBER(duty_angles)"
        for k in range(self.n):
            if np.isnan(r.strength.needle_bearing_life[:, k]).all() or not r.line.is_cross[k]:
                continue
            beta = (
                f"({self.beta[k]}+{self.tag}duty_more_{k + 1}_¶)"
                if self.states.moved
                else self.beta[k]
            )
            each = of.to_spreadsheet(
                T=f"{torque}*duty_torques{part_of}", n=f"{speed}*duty_speeds{part_of}",
                β=f"{given}*duty_angles+(1-{given})*{beta}", K1="prime_mover_factor",
                Td=self._of_part("joint_ratings", k + 1),
            )  # fmt: skip
            part = Part("joint", k + 1)
            worn = self._row(
                self.say.join(self.say("wear"), self.say.part(part)), "1/h",
                f"SUMPRODUCT(duty_shares/100,{each})", note=str(of),
            )  # fmt: skip
            lasting = self.states.cell(self.states.lasting)
            hours = f"IF({worn}=0,{INFINITY_CELL_VALUE:.0E},1/{worn})"
            self._result(
                "joint_life",
                f'IF(AND({lasting}=1,ISNUMBER({worn})),{hours},"")',
                r.strength.needle_bearing_life[:, k],
                part=part,
            )

    def _duty_of_line(self) -> tuple[str, str, str]:
        """Return what the line makes of the duty cycle's torques and speeds, and their unit.

        A cycle of the gearbox output gives the line its share. A named one is of the largest
        torque and the top speed that the line has in any state that lasts.
        """
        line = self.r.demand.static_state.line
        # A locked differential leaves a line all the torque at times, but not for its life.
        usual = (
            ""
            if line.max_torque_share == line.nominal_torque_share
            else f"*{line.nominal_torque_share / line.max_torque_share:.15g}"
        )
        if self.r.application.duty_cycle is None:
            return f"{self.tag}torque_share{usual}", f"{self.tag}speed_ratio", ""
        say, lasting = self.say, self.states.cell(self.states.lasting)
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


def _differs(cell: str, value: float) -> str:
    """Return the formula for whether a cell is no longer what it was written as."""
    return f"ABS({cell}-{value:.15g})>1E-9*{max(abs(value), 1):.15g}"


def result_label(quantity: str, part: Part, say: Translator) -> str:
    """Return what a row of results is called."""
    return say.join(say.name(quantity), "" if part == WHOLE_LINE else say.part(part))


def cell_name(quantity: str, part: Part) -> str:
    """Return the name of a row of results; tests and macros find it by this."""
    said = "" if part == WHOLE_LINE else str(part).removeprefix("centre ")
    return f"{quantity}_{said}".replace(" ", "_").rstrip("_")
