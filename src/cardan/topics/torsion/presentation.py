"""Show how a vehicle vibrates: terminal, JSON, and the charts of its speeds, modes and starts."""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from math import pi
from typing import Any, TypeAlias

import numpy as np

from cardan.approval.approval import Approval
from cardan.approval.study import VIBRATION_STUDY_NAME
from cardan.checks.quantities.declaration import UNIT_SYMBOLS
from cardan.checks.quantities.registry import QUANTITIES
from cardan.core.arrays import FloatArray
from cardan.core.labels import EvaluationCondition, Part
from cardan.core.provenance import provenance_text
from cardan.core.units import UNITS, rpm
from cardan.core.verdict import CHECK_GRADES, Check
from cardan.render.check_texts import lower_bound_explanation
from cardan.render.i18n import ENGLISH, Translator
from cardan.render.phrases import value_and_bound
from cardan.render.terminal import (
    BOLD_CODE,
    GRADE_MARKS,
    RESET_CODE,
    VERDICT_COLOUR_CODES,
    grade_mark_lines,
    summary_lines,
)
from cardan.render.text_layout import DEFAULT_WIDTH_COLUMNS, fold_lines, table_lines
from cardan.topics.torsion.powertrain_model import DegreeOfFreedom
from cardan.topics.torsion.study import DEFAULT_RUBBER_LOSS_FACTOR
from cardan.topics.torsion.vibration_checks import (
    condition_of_launch,
    gears_with_clutch_closed_or_slipping,
)
from cardan.topics.torsion.vibration_result import (
    EXCITED_ORDERS,
    ModeSensitivity,
    PowertrainVibration,
    VibrationResult,
    any_known,
    heaviest_driving_state_index,
)


def text_lines(
    of: Approval, *, say: Translator = ENGLISH, width: int = DEFAULT_WIDTH_COLUMNS
) -> Iterator[str]:
    """Yield the verdict, each check and the vehicle's numbers, gear by gear."""
    found: VibrationResult = of.answer_of(VIBRATION_STUDY_NAME)
    doubts = (say("Not evaluated: {what}.", what=doubt) for doubt in found.doubts)
    limits = say("limits: {profile}", profile=of.application.profile)
    yield from fold_lines(
        [*summary_lines(of, say), limits, *assumption_lines(found, say), *doubts], width
    )
    yield ""
    rows = sorted(of.checks, key=lambda c: (-CHECK_GRADES.index(c.grade), c.quantity, c.margin))
    head = "", *map(say, ("quantity", "part", "where it is worst", "value", "limit"))
    shown = [_row(c, say) for c in rows]
    yield from table_lines(head, shown, width)
    yield from grade_mark_lines(rows, say, width)
    yield from fold_lines(lower_bound_explanation((row[4] for row in shown), say), width)
    for caption, head, lines, _ in result_tables(found, say):
        yield ""
        yield from (f"{BOLD_CODE}{line}{RESET_CODE}" for line in fold_lines([caption], width))
        yield from (f"  {line}" for line in table_lines(head, lines, width - 2))


def _row(c: Check, say: Translator) -> tuple[str, ...]:
    """Return a check as a row of the screen."""
    q, (value, bound) = QUANTITIES[c.quantity], value_and_bound(c, say)
    sense = say("outside") if c.limit.band else c.limit.sense
    return (
        f"{VERDICT_COLOUR_CODES[c.grade]}{GRADE_MARKS[c.grade]}{RESET_CODE}",
        say.name(c.quantity),
        say.part(c.part),
        say.occasion(c.when),
        value,
        f"{sense} {bound} {q.unit_symbol}".rstrip(),
    )


TableContent: TypeAlias = tuple[str, tuple[str, ...], tuple[tuple[str, ...], ...], int]
"""Caption, head, rows, and how many of its first columns are words."""


def result_tables(of: VibrationResult, say: Translator) -> Iterator[TableContent]:
    """Yield the vehicle's numbers as tables that every medium shows alike."""
    yield _modes(of, say)
    yield _amplitudes(of, say)
    if of.zones:
        yield _zones(of, say)
    if of.launches:
        yield _launches(of, say)
    yield _assumed(of, say)


def _modes(of: VibrationResult, say: Translator) -> TableContent:
    """Modes of each gear with where order 2 meets them, in the heaviest state."""
    rows: list[tuple[str, ...]] = []
    s = heaviest_driving_state_index(of)
    for driven, clutch in ((of.closed, say("closed")), (of.slipping, say("slipping"))):
        for g, gear in enumerate(of.gears):
            low, high = (driven.ranges[g, s] / rpm).tolist()
            if not np.isfinite(low):
                continue
            found = [
                f"{say.number(float(w) / (2 * pi))} ({say.number(float(w) / 2 / rpm)})"
                for w in driven.frequencies[g, s, :4]
            ]
            rows.append(
                (say.occasion(gear), clutch, f"{say.number(low)}-{say.number(high)}", *found)
            )
    count = max((len(r) for r in rows), default=3) - 3
    head = (say("gear"), say("clutch"), say("speeds [rpm]"),
            *(say("mode {mode}", mode=k) for k in range(1, count + 1)))  # fmt: skip
    caption = say("Torsional modes of the whole vehicle in Hz, and where order 2 meets them in rpm")
    return caption, head, tuple(rows), 2


def _amplitudes(of: VibrationResult, say: Translator) -> TableContent:
    """Largest vibratory torque of each gear, its place, speed and state."""
    rows: list[tuple[str, ...]] = []
    for driven, g, when in gears_with_clutch_closed_or_slipping(of):
        names, lines = driven.powertrain.springs, driveline_spring_indices(driven)
        for o, order in enumerate(EXCITED_ORDERS):
            values = driven.torque[g, :, o][:, lines]
            s, k = np.unravel_index(int(np.nanargmax(values)), values.shape)
            spring = lines[int(k)]
            rows.append(
                (
                    say.occasion(when), str(order), say.number(float(values[s, k])),
                    _spring(names[spring], of, say), say.state(of.states[int(s)]),
                    say.number(float(driven.speed[g, s, o, spring]) / rpm),
                    say.number(float(driven.mean_torque[g, s, spring])),
                )
            )  # fmt: skip
        if of.drivetrain.firing_torque and driven is of.closed:
            spring = lines[int(of.firing_torque[g, lines].argmax())]
            rows.append(
                (say.occasion(when), say("firing"), say.number(float(of.firing_torque[g, spring])),
                 _spring(names[spring], of, say), "", "", "")
            )  # fmt: skip
    head = (say("gear"), say("order"), say("torque, 0-to-peak [N·m]"), say("part"), say("state"),
            say("at [rpm]"), say("mean [N·m]"))  # fmt: skip
    return (
        say("Largest vibratory torque of the lines at full load"),
        head,
        tuple(rows),
        1,
    )


def _zones(of: VibrationResult, say: Translator) -> TableContent:
    """Each zone where it is nearest to opening."""
    rows: list[tuple[str, ...]] = []
    for z in of.zones:
        if not np.isfinite(z.growth).any():
            continue
        g, s = np.unravel_index(int(np.nanargmax(z.growth)), z.growth.shape)
        opens = np.nanmin(z.opening_angle_factor)
        rows.append(
            (
                say.part(z.part),
                say.occasion(of.gears[int(g)]),
                say.number(float(z.speed[g, s]) / rpm),
                say.number(float(z.nearest_speed[g, s]) / rpm),
                say.number(float(z.growth[g, s])),
                say.number(float(opens)),
                say.number(float(np.nanmax(z.opening_damping_factor))),
            )
        )
    head = (say("zone"), say("gear"), say("middle [rpm]"), say("nearest speed [rpm]"),
            say("growth [1/s]"), say("opens at angles ×"), say("opens at damping ×"))  # fmt: skip
    return say("Parametric zones, each by its own multiplier"), head, tuple(rows), 2


def _launches(of: VibrationResult, say: Translator) -> TableContent:
    """Each start from rest: its peak, what makes it, and what follows."""
    rows: list[tuple[str, ...]] = []
    for started in of.launches:
        shares, k = started.shares, started.first_shaft
        rows.append(
            (
                say.occasion(condition_of_launch(started.launch)),
                say.number(started.torque),
                say.number(float(started.peak_torque[k])),
                _with_range(started.lowest_torque[k], started.lowest_range[:, k], say),
                say.number(shares["ramp"]),
                say.margin_percent(shares["joints"]),
                say.margin_percent(shares["firing"]),
                say.number(shares["if tyres could not slide"]),
                say("yes") if started.tyres_slid else say("no"),
                _largest(started.order2_amplitude[k], say),
                _largest(started.bearing_transient_force, say),
                _largest(started.bearing_force, say),
            )
        )
    head = (
        say("launch"),
        say("T i [N·m]"),
        say("peak [N·m]"),
        say("lowest [N·m]"),
        say("ramp's peak over T i"),
        say("joints add"),
        say("firing adds"),
        say("over T i if tyres stick"),
        say("tyres slide"),
        say("order 2 [N·m]"),
        say("bearing force [N]"),
        say("if each instant lasted [N]"),
    )
    return say("Starts from rest: the first shaft of the main line"), head, tuple(rows), 1


def _with_range(value: float, ends: FloatArray, say: Translator) -> str:
    """Return a number and, where assumed inputs move it by more than a hundredth, its range."""
    low, high = (say.compact_number(float(end), 3) for end in ends)
    alone = say.number(float(value))
    if np.ptp(ends) <= 0.01 * np.abs(ends).max():
        return alone
    return f"{alone} ({say('{low} to {high}', low=low, high=high)})"


def _largest(values: Any, say: Translator) -> str:
    return say.number(float(np.nanmax(values))) if any_known(values) else ""


def _assumed(of: VibrationResult, say: Translator) -> TableContent:
    """Values that are not given: each with its range, and the modes that move with it."""
    moved = {s.assumption.quantity: s for s in of.shifts}
    rows: list[tuple[str, ...]] = []
    seen: set[str] = set()
    for a in of.drivetrain.assumed:
        if a.quantity in seen:
            continue
        seen.add(a.quantity)
        unit = UNITS[a.typical.unit]
        name = UNIT_SYMBOLS.get(a.typical.unit, a.typical.unit)
        rows.append(
            (
                a.quantity,
                f"{say.number(a.typical.value / unit)} {name}".strip(),
                f"{say.number(a.typical.low / unit)}-{say.number(a.typical.high / unit)}",
                _moved(moved.get(a.quantity), of, say),
                say.source(provenance_text(a.typical.how_read)),
            )
        )
    head = (say("value"), say("assumed"), say("range"), say("modes that move by 2 % or more"),
            say("how read"))  # fmt: skip
    caption = say("Assumed (not given): typical of a {vehicle}",
                  vehicle=say(of.drivetrain.vehicle_class))  # fmt: skip
    return caption, head, tuple(rows), 5


def _moved(shift: ModeSensitivity | None, of: VibrationResult, say: Translator) -> str:
    """Say which modes an assumption moves over its range."""
    if shift is None:
        return "-"
    base = of.closed.frequencies[of.drivetrain.gears.index(shift.gear), -1]
    said = [
        say("mode {mode}: {low}-{high} Hz", mode=k, low=say.number(low / (2 * pi)),
            high=say.number(high / (2 * pi)))
        for k, (low, high) in enumerate(np.sort(shift.frequencies, axis=0).T.tolist(), 1)
        if max(abs(low / base[k - 1] - 1), abs(high / base[k - 1] - 1)) > 0.02
    ]  # fmt: skip
    where = say.occasion(EvaluationCondition("gear", shift.gear)) + ", " if shift.gear else ""
    return where + "; ".join(said)


def driveline_spring_indices(of: PowertrainVibration) -> list[int]:
    """Return the places of the springs that are shafts or pinions of a line."""
    return [k for k, (_, p) in enumerate(of.powertrain.springs) if p.kind in {"shaft", "pinion"}]


def _spring(name: DegreeOfFreedom, of: VibrationResult, say: Translator) -> str:
    line, part = name
    return say.part(part) + (f", {line}" if line and len(of.lines) > 1 else "")


@dataclass(frozen=True, kw_only=True)
class ResonanceMargin:
    """How far the ranges of speed stay from a resonance or zone, as shares of its speed.

    `speed` is in rad/s, of each gear; `shares` (gears,) are 0 where a gear runs through it.
    """

    part: Part
    speed: tuple[float, ...]
    shares: tuple[float, ...]
    grades: tuple[str, ...]


def resonance_margins(of: VibrationResult, checks: Iterable[Check]) -> Iterator[ResonanceMargin]:
    """Yield the distance of each resonance from every range of speed."""
    mine = [c for c in checks if c.quantity == "torsional_resonance"]
    graded = {(c.part, c.when): c for c in mine}
    w = of.closed.frequencies[:, heaviest_driving_state_index(of)]
    for part in dict.fromkeys(c.part for c in mine):
        order, mode = part.other, part.number
        assert isinstance(order, int) and isinstance(mode, int)  # noqa: PT018
        each = [graded.get((part, gear)) for gear in of.gears]
        yield ResonanceMargin(
            part=part, speed=tuple((w[:, mode - 1] / order).tolist()),
            shares=tuple(np.nan if c is None else c.value - 1 for c in each),
            grades=tuple("" if c is None else c.grade for c in each),
        )  # fmt: skip


def assumption_lines(of: VibrationResult, say: Translator) -> Iterator[str]:
    """Yield what the answer stands on: what was given in place of parts, what is assumed."""
    around = of.surroundings
    said = {
        "gearbox_inertia": "gearbox {value} kg m²",
        "gearbox_stiffness": "gearbox on {value} N m/rad",
        "axle_inertia": "axle {value} kg m²",
        "axle_stiffness": "axle on {value} N m/rad",
        "damping_ratio": "damping ratio {value}",
        "rubber_loss": "loss factor of the rubber {value}",
    }  # fmt: skip
    given = [say(text, value=say.number(getattr(around, name)))
             for name, text in said.items() if name in of.given]  # fmt: skip
    if given:
        yield say("Given in place of parts: {values}.", values="; ".join(given))
    names = list(dict.fromkeys(a.quantity for a in of.drivetrain.assumed))
    most = [s.assumption.quantity for s in _most(of.shifts, of)][:3]
    if names:
        yield say(
            "Assumed: {count} values of a {vehicle}; the modes lean most on {names}.",
            count=len(names), vehicle=say(of.drivetrain.vehicle_class),
            names=say.join(*most) or "-",
        )  # fmt: skip
    if "rubber_loss" not in of.given:
        yield say(
            "Assumed: {values}.",
            values=say(said["rubber_loss"], value=say.number(DEFAULT_RUBBER_LOSS_FACTOR)),
        )


def _most(shifts: Sequence[ModeSensitivity], of: VibrationResult) -> list[ModeSensitivity]:
    """Return the assumptions by how far they move the lowest two modes."""

    def far(shift: ModeSensitivity) -> float:
        base = of.closed.frequencies[of.drivetrain.gears.index(shift.gear), -1, :2]
        return float(np.abs(shift.frequencies[:, :2] / base - 1).max())

    return sorted(shifts, key=far, reverse=True)
