"""Sheet of the states of a line: geometry, torque and speed, which may be changed by hand."""

from collections.abc import Sequence
from itertools import product
from math import isnan

import numpy as np

from cardan.checks.line_response import LineResponse
from cardan.core.labels import Part
from cardan.core.units import deg, mm, rpm
from cardan.physics.loads.statics import joint_loads
from cardan.render.xlsx import (
    ALLOW_ANY_SIGN,
    ALLOW_NON_NEGATIVE,
    ALLOW_POSITIVE,
    ALLOW_SLOPE_DEG,
    ALLOW_ZERO_TO_ONE,
    EXCEL_EMPTY_TEXT_FORMULA,
    FIRST_STATE_COLUMN,
    UNKNOWN_NUMBER_CELL_TEXT,
    CellValidation,
    CellValue,
    WorkbookWriter,
    column_letters,
)

GEOMETRY_OF_OTHER_TORQUE = "geometry_of_other_torque"
"""Name of the cells that are 1 where slopes are no longer those of a state's torque."""


class LineSheet:
    """A sheet of one line: its states stand in the same columns of each."""

    def __init__(
        self,
        book: WorkbookWriter,
        response: LineResponse,
        *,
        title: str,
        tag: str,
        note_width: int = 12,
    ) -> None:
        self.book, self.r, self.tag, self.say = book, response, tag, book.say
        self.n = response.line.joint_count
        self.sheet = book.add_sheet(title)
        self.heads = [self.say.state(s) for s in response.demand.states]
        self.columns = [column_letters(FIRST_STATE_COLUMN + s) for s in range(len(self.heads))]
        for first, last, width in (
            (0, 0, 46),
            (1, 1, 9),
            (2, 3, note_width),
            (FIRST_STATE_COLUMN, FIRST_STATE_COLUMN + len(self.heads), 13),
        ):
            self.sheet.sheet.set_column(first, last, width)


class StatesSheet(LineSheet):
    """Geometry, torque and speed of every state, and the rows that they stand in."""

    def _given(
        self, label: str, unit: str, values: Sequence[CellValue], name: str, allow: CellValidation
    ) -> int:
        return self.sheet.write_row(
            label, unit, values, style=self.book.input, name=self.tag + name, allow=allow
        )

    def _torque_given(self, state: int) -> CellValue:
        """Return what a state says of the torque at the gearbox output.

        In brake wind-up the line carries the overrun torque, which is an input here: brake and
        tyres would have to be weighed against each other for it.
        """
        given, d = self.r.application.states[state], self.r.demand
        if given.kind == "windup brake":
            torque = float(d.torque[state] / d.static_state.line.max_torque_share)
            return UNKNOWN_NUMBER_CELL_TEXT if isnan(torque) else torque
        if given.torque is None:
            return '=IF(ISNUMBER(torque_given),torque_given,"")'
        return given.torque

    def write(self) -> None:
        """Write geometry, torque and speed of every state."""
        r, say, sheet = self.r, self.say, self.sheet
        wound = say(
            "In wind-up slopes are those of the torque as exported: they do not follow another "
            "torque. Type the pinion's slope for it, or results there are stale."
        )
        sheet.title(
            say("States of line {line}", line=r.line.name),
            (
                say("Geometry as the suspension places it: values that may be changed by hand."),
                *([wound] if r.demand.static_state.moved_by_own_torque.any() else []),
            ),
        )
        heads = ["", "", "", "", *self.heads]
        sheet.section(say("side slopes of the members"), heads)
        members = [
            say("gearbox"),
            *(say.part(Part("shaft", k)) for k in range(1, self.n)),
            say("pinion"),
        ]
        side, top = r.layout.side / deg, r.layout.top / deg
        self.side = [
            self._given(m, "deg", side[:, k].tolist(), f"side_{k}", ALLOW_SLOPE_DEG)
            for k, m in enumerate(members)
        ]
        sheet.section(say("top slopes of the members"), heads)
        self.top = [
            self._given(m, "deg", top[:, k].tolist(), f"top_{k}", ALLOW_SLOPE_DEG)
            for k, m in enumerate(members)
        ]
        if r.demand.static_state.moved_by_own_torque.any():
            self._marks_of_other_torque()
        sheet.section(say("length"), heads)
        lengths = r.layout.lengths / mm
        self.lengths = [
            self._given(
                members[k + 1], "mm", lengths[:, k].tolist(), f"length_{k + 1}", ALLOW_POSITIVE
            )
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
        speeds: list[CellValue] = [
            "=IF(ISNUMBER(speed_given),speed_given,"
            f"{low if s.kind == 'windup' else EXCEL_EMPTY_TEXT_FORMULA})"
            if s.speed is None
            else s.speed / rpm
            for s in own
        ]
        self.torque_given = self._given(
            say("torque at the gearbox output, where given"),
            "N·m",
            torques,
            "state_torques",
            ALLOW_ANY_SIGN,
        )
        self.speed_given = self._given(
            say("speed of the gearbox output, where given"),
            "rpm",
            speeds,
            "state_speeds",
            ALLOW_POSITIVE,
        )
        self.driven = self._given(
            say("load on the driven wheels at slip"),
            "N",
            r.demand.driven_load.tolist(),
            "driven_loads",
            ALLOW_NON_NEGATIVE,
        )
        lasting = r.inputs.sustained_states.tolist()
        self.lasting = self._given(
            say("counts for the life (1 or 0)"),
            "",
            [float(x) for x in lasting],
            "lasting",
            ALLOW_ZERO_TO_ONE,
        )
        self._under_duty()
        self.weight: list[list[int]] = []
        if r.inputs.gravity or r.line.joint_bending_stiffnesses is not None:
            sheet.section(say("Weight on the centre bearings (values of cardan)"), heads)
            still = joint_loads(
                r.layout,
                r.inputs.chain_rotation,
                r.line,
                torque=0.0,
                gravity=r.inputs.gravity,
                elastic=True,
            )
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
        sheet.sheet.freeze_panes(0, FIRST_STATE_COLUMN)

    def _marks_of_other_torque(self) -> None:
        """Write in which states slopes and lengths are no longer those of the torque."""
        name, word = f"{self.tag}{GEOMETRY_OF_OTHER_TORQUE}", self.say("stale")
        cells = [f'=IF(INDEX({name},1,{s + 1})=1,"{word}","")' for s in range(len(self.columns))]
        self.sheet.write_row(
            self.say("geometry in wind-up, once the torque is changed"), "", cells,
            style=self.book.verdict, values=np.full(len(cells), np.nan),
        )  # fmt: skip

    def _under_duty(self) -> None:
        """Write what the torque of each point of the duty cycle adds to joint angles, if any."""
        r, say = self.r, self.say
        lasting = np.flatnonzero(
            r.inputs.sustained_states & ~np.isnan(r.strength.needle_bearing_life).all(axis=-1)
        ).tolist()
        self.moved = False
        if not lasting:
            return
        more = np.moveaxis(r.strength.duty_angles - r.joint_angles, 0, -1) / deg  # (S, n, points)
        self.moved = bool(np.abs(more[lasting]).max() > 1e-9)
        if not self.moved:
            return
        self.sheet.section(
            say("Joint angles added by the torques of the duty cycle (values of cardan)"),
            ["", "", "", "", *(say("point {k}", k=p + 1) for p in range(more.shape[-1]))],
        )
        for k, s in product(range(self.n), lasting):
            label = say.join(say.part(Part("joint", k + 1)), say.state(r.demand.states[s]))
            self._given(
                label, "deg", more[s, k].tolist(), f"duty_more_{k + 1}_{s + 1}", ALLOW_ANY_SIGN
            )

    def cell(self, row: int) -> str:
        """Return the reference to a row of this sheet."""
        return f"'{self.sheet.name}'!§{row}"
