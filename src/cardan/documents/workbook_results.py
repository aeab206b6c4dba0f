"""Sheet of the results of a line: its limits with their values, and what else is known."""

from collections.abc import Mapping, Sequence

import numpy as np

from cardan.approval.driveline_study import EvaluatedLimit, evaluate_limits, missing_inputs_of
from cardan.checks.quantities.declaration import (
    NEEDS_SPEED,
    NEEDS_TORQUE,
    NEEDS_TORQUE_WEIGHT_OR_UNBALANCE,
)
from cardan.checks.quantities.registry import QUANTITIES
from cardan.core.arrays import BoolArray
from cardan.core.verdict import Verdict
from cardan.documents.workbook_calculation import (
    CalculationSheet,
    ResultRow,
    cell_name,
    result_label,
)
from cardan.documents.workbook_limits import LimitRow, LimitSheet, LiveFormulas
from cardan.documents.workbook_states import LineSheet
from cardan.render.state_table import state_table_sections
from cardan.render.xlsx import FIRST_STATE_COLUMN, WorkbookWriter


class ResultsSheet(LineSheet):
    """Limits with their values, then other results, then those of the exact chain."""

    def __init__(self, book: WorkbookWriter, calculation: CalculationSheet, *, title: str) -> None:
        super().__init__(book, calculation.r, title=title, tag=calculation.tag)
        self.calculation = calculation

    def write(self, texts: Mapping[Verdict, str]) -> LimitSheet:
        """Write each limit with its values, then other results, then the exact chain's."""
        say, sheet, r = self.say, self.sheet, self.r
        sheet.title(
            say("Results of line {line}", line=r.line.name),
            (
                say("Live: they follow inputs and states. Limits may be changed."),
                say("As computed: what cardan found; stale once an input is changed."),
                *(
                    [
                        say(
                            "In wind-up slopes are those of the torque as exported: they do not "
                            "follow another torque."
                        )
                    ]
                    if self.calculation.r.demand.static_state.moved_by_own_torque.any()
                    else []
                ),
            ),
        )
        top = sheet.row
        sheet.row += 1
        judged = LimitSheet(sheet, self.heads)
        # What is sought over operating points the formulas have at the state's own alone.
        followed = [
            one for one in self.calculation.found if not QUANTITIES[one.quantity].find_worst_points
        ]
        found = {(one.quantity, one.part): one for one in followed}
        held: list[tuple[EvaluatedLimit, int, ResultRow | None]] = []
        for question in evaluate_limits(r):
            for k, part in enumerate(question.parts):
                one = found.get((question.limit.quantity, part))
                if question.lacks_rating[k]:  # its value stands there, but answers nothing
                    one = None
                if question.may_apply[:, k].any():
                    held.append((question, k, one))
                if one is not None and _worse_elsewhere(question, k):
                    held.append((question, k, None))
        for title, live in ((say("Checks, live"), True), (say("Checks, as computed"), False)):
            rows = [h for h in held if (h[2] is not None) == live]
            if rows:
                judged.write_section(title)
            for question, k, one in rows:
                judged.write_limit_row(self._held(question, k, one))
        judged.write_sheet_verdict(top, f"{self.tag}verdict" if self.tag else "", texts)
        checked = {(q.limit.quantity, q.parts[k]) for q, k, _ in held}
        sheet.section(say("Other results"), ["", say("unit"), "", "", *self.heads])
        for one in self.calculation.found:
            beside = (one.quantity, one.part) not in checked or one not in followed
            if beside and one.quantity not in _ONLY_FOR_LIMITS:
                self._shown(one)
        sheet.section(
            say("Exact results of cardan: values, they do not follow the inputs"),
            ["", say("unit"), "", "", *self.heads],
        )
        first = sheet.row
        sheet.write_stale_mark(0)
        sheet.row += 1
        for section in state_table_sections(r):
            for row in section.rows:
                if not row.method:
                    sheet.write_row(
                        row.label(say),
                        row.unit,
                        row.values.tolist(),
                        style=self.book.exact,
                        texts=(say("value"), _bounded_states_text(row.bounds, self.heads)),
                    )
        end = FIRST_STATE_COLUMN + len(self.heads) - 1
        sheet.grey_once_stale(first, FIRST_STATE_COLUMN, sheet.row - 1, end)
        sheet.sheet.freeze_panes(0, 1)
        return judged

    def _cells(self, one: ResultRow) -> tuple[str, ...]:
        """Return cells that show a row of the calculation.

        Where a state's geometry is that of another torque they say that they are stale.
        """
        calculation, cells = self.calculation, list[str]()
        for s, letter in enumerate(calculation.columns):
            cell = f"'{calculation.sheet.name}'!{letter}{one.row}"
            if one.follows_geometry and s in calculation.moved_states:
                other = calculation.other_torque.replace("§", letter)
                cell = f'IF({other}=1,"{self.say("stale")}",{cell})'
            cells.append(f"={cell}")
        return tuple(cells)

    def _shown(self, one: ResultRow) -> None:
        """Write a row that shows a row of the calculation, and how that approximates."""
        label, name = (
            result_label(one.quantity, one.part, self.say),
            cell_name(one.quantity, one.part),
        )
        if QUANTITIES[one.quantity].find_worst_points:
            label = f"{label} ({self.say(one.approximation)})"
            name = f"{name}_{one.approximation.replace(' ', '_')}"
        self.sheet.write_row(
            label, QUANTITIES[one.quantity].unit_symbol, self._cells(one),
            style=self.book.result, values=one.values, name=self.tag + name,
        )  # fmt: skip

    def _held(self, question: EvaluatedLimit, k: int, one: ResultRow | None) -> LimitRow:
        """Return the row of one part that a limit applies to."""
        limit, part = question.limit, question.parts[k]
        values = (question.values if one is None else question.own_point_values)[:, k]
        missing = question.asks[:, k] & np.isnan(values)
        lacks = [missing_inputs_of(self.r, question, int(s), k) for s in np.flatnonzero(missing)]
        named = part.kind != "clearance"
        label, name = result_label(limit.quantity, part, self.say), cell_name(limit.quantity, part)
        if one is None and _worse_elsewhere(question, k):
            label = self.say("{what}, at the worst operating point", what=label)
            name = f"{name}_worst"
        return LimitRow(
            label=label,
            limit=limit,
            values=values,
            may_apply=question.may_apply[:, k],
            missing=missing,
            validity_margin=None if one else question.validity_margin[:, k],
            missing_inputs=tuple(dict.fromkeys(n for needs in lacks for n in needs)),
            name=self.tag + name if named else "",
            live_formulas=self._live(one) if one else None,
            line=self.r.line.name,
        )

    def _live(self, one: ResultRow) -> LiveFormulas:
        """Return the formulas of a row of the calculation, as limits use it."""
        here = f"'{self.calculation.sheet.name}'!"
        still = self.r.inputs.gravity == 0 and self.r.rigid_loads.unbalance_forces is None
        idle = {
            id(NEEDS_SPEED): self.calculation.speed,
            id(NEEDS_TORQUE): self.calculation.torque,
        } | ({id(NEEDS_TORQUE_WEIGHT_OR_UNBALANCE): self.calculation.torque} if still else {})
        needs = (idle.get(id(need)) for need in QUANTITIES[one.quantity].requirements)
        return LiveFormulas(
            cell_formulas=self._cells(one),
            values=one.values,
            largest_angle_cell=here + self.calculation.largest,
            zero_if_idle_cells=tuple(here + n for n in needs if n),
            approximation=one.approximation,
            may_be_stale=one.follows_geometry and bool(self.calculation.moved_states),
        )


def _bounded_states_text(bounds: BoolArray, states: Sequence[str]) -> str:
    """Return in which states a row's value is a lower bound."""
    named = [state for state, bound in zip(states, bounds.tolist(), strict=True) if bound]
    return f"≥: {', '.join(named)}" if named else ""


def _worse_elsewhere(question: EvaluatedLimit, k: int) -> bool:
    """Whether a part is worse at another operating point than at a state's own."""
    sought = QUANTITIES[question.limit.quantity].find_worst_points
    return not sought and not np.array_equal(
        question.values[:, k], question.own_point_values[:, k], equal_nan=True
    )


_ONLY_FOR_LIMITS = (
    "joint_angle_min",
    "compound_angle",
    "angle_for_speed",
    "half_critical_band",
)
"""Quantities that say the same as another; shown where a limit applies to them."""
