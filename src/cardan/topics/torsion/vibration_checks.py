"""Checks of a vibration study: each limit against the value that it applies to."""

from collections.abc import Iterator
from dataclasses import replace
from functools import partial
from typing import NamedTuple

import numpy as np

from cardan.checks.quantities.declaration import NEEDS_MOUNT_STIFFNESS
from cardan.core.labels import WHOLE_LINE, EvaluationCondition, Part
from cardan.core.units import UNITS
from cardan.core.verdict import AssumedRange, Check, Limit, UnevaluatedCheck
from cardan.model.parts import JointSize, Line
from cardan.model.powertrain import Launch
from cardan.topics.torsion.launch_study import (
    LaunchResult,
)
from cardan.topics.torsion.vibration_result import (
    EXCITED_ORDERS,
    PowertrainVibration,
    VibrationResult,
)

# ----- verdicts ------------------------------------------------------------------------------


class LimitValueRow(NamedTuple):
    """What a limit applies to: a line, when, a part of it, and the value.

    Where assumed inputs move it, between what it lies.
    """

    line: str
    when: EvaluationCondition
    part: Part
    value: float
    within: tuple[float, float] | None = None
    assumed: tuple[AssumedRange, ...] = ()
    validity_margin: float = np.inf


SLIPPING_CLUTCH_LABEL = "the clutch slipping"
"""What an occasion says of a gear while its clutch slips."""


def check_limit(of: VibrationResult, limit: Limit) -> tuple[list[Check], list[UnevaluatedCheck]]:
    """Return a limit's checks, and where it got no number."""
    rows = {
        "torsional_resonance": _resonances,
        "torsional_growth": _zones,
        "lateral_growth": _hung,
        "torsional_amplitude_utilisation": partial(_rated, rating="reversing_torque"),
        "torsional_peak_utilisation": partial(_rated, rating="peak_torque"),
        "torsional_reversal": _reversals,
        "torsional_pinion_acceleration": _accelerations,
        "launch_peak_utilisation": _launch_peaks,
        "launch_reversal": _launch_reversals,
        "launch_bearing_force": _launch_bearings,
    }[limit.quantity](of)
    checks: list[Check] = []
    silent_of: list[UnevaluatedCheck] = []
    for row in rows:
        if np.isnan(row.value):
            silent_of.append(
                UnevaluatedCheck(
                    limit=limit,
                    line=row.line,
                    when=row.when,
                    part=row.part,
                    missing_inputs=(_NEEDS[limit.quantity],),
                )
            )
        else:
            check = Check(
                quantity=limit.quantity,
                line=row.line,
                when=row.when,
                part=row.part,
                value=row.value,
                limit=limit,
                within=row.within,
                assumed=row.assumed,
                validity_margin=row.validity_margin,
            )
            # A range that leaves the verdict as it is, is reported with the number.
            turns = check.worst_possible_grade != check.best_possible_grade
            checks.append(check if turns else replace(check, within=None, assumed=()))
    if limit.quantity.startswith("launch_"):
        silent_of += [
            UnevaluatedCheck(
                limit=limit,
                line=of.lines[0].line.name,
                when=condition_of_launch(launch),
                part=WHOLE_LINE,
                missing_inputs=(why,),
            )
            for launch, why in of.failed_launches
            if limit.quantity == "launch_bearing_force" or _is_judged(of, launch)
        ]
    return checks, silent_of


_NEEDS = {
    "torsional_amplitude_utilisation": "a joint size with its reversing torque",
    "torsional_peak_utilisation": "a joint size with its peak torque",
    "launch_peak_utilisation": "a joint size with its peak torque",
    "launch_bearing_force": NEEDS_MOUNT_STIFFNESS.required_input,
}


def _resonances(of: VibrationResult) -> Iterator[LimitValueRow]:
    """Yield for each mode, order and gear the speed nearest to resonance, over that speed.

    The clutch closed, in the state that comes nearest. Modes that no gear comes within a
    quarter of are left out, but for the first.
    """
    w, ranges = of.closed.frequencies, of.closed.ranges
    name = of.lines[0].line.name
    top = np.nanmax(ranges)
    for i in range(w.shape[-1]):
        for order in EXCITED_ORDERS:
            met = w[..., i] / order
            if (i, order) != (0, EXCITED_ORDERS[0]) and met.min() > 1.25 * top:
                continue
            nearest = np.clip(met, ranges[..., 0], ranges[..., 1]) / met
            for g, gear in enumerate(of.gears):
                each = nearest[g][np.isfinite(nearest[g])]
                if each.size:
                    worst = float(each[np.abs(np.log(each)).argmin()])
                    within, assumed = _moved_resonance(of, g, i, order)
                    part = Part("mode", i + 1, order)
                    yield LimitValueRow(name, gear, part, worst, within, assumed)


def _moved_resonance(
    of: VibrationResult, g: int, mode: int, order: int
) -> tuple[tuple[float, float] | None, tuple[AssumedRange, ...]]:
    """Return between what a resonance lies as assumed values move its mode, and those.

    One by one, over the range of each; by as much as in the gear in which it moves most.
    """
    ranges, w = of.closed.ranges[g], of.closed.frequencies[g, :, mode]
    values: list[float] = []
    assumed: list[AssumedRange] = []
    for shift in of.shifts:
        if mode >= shift.frequencies.shape[-1]:
            continue
        # A vehicle without gears has one, which has no name.
        gear = [of_gear.name for of_gear in of.gears].index(shift.gear) if shift.gear else 0
        base = of.closed.frequencies[gear, -1, mode]
        moved = [float(f) for f in shift.frequencies[:, mode] / base]
        if np.abs(np.array(moved) - 1).max() < 1e-3:
            continue
        met = w / order * np.array(moved)[:, None]
        nearest = np.clip(met, ranges[:, 0], ranges[:, 1]) / met
        values += nearest[np.isfinite(nearest)].tolist()
        q, unit = shift.assumption.typical, UNITS[shift.assumption.typical.unit]
        assumed.append(AssumedRange(q.quantity, q.low / unit, q.high / unit, q.unit))
    if not values:
        return None, ()
    return (min(values), max(values)), tuple(assumed)


def _zones(of: VibrationResult) -> Iterator[LimitValueRow]:
    """Yield the growth in each parametric zone and state, in the gear where it is worst."""
    for zone in of.zones:
        for s, state in enumerate(of.states):
            if np.isfinite(zone.growth[:, s]).any():
                rate = float(np.nanmax(zone.growth[:, s]))
                when = EvaluationCondition("state", state)
                yield LimitValueRow(of.lines[0].line.name, when, zone.part, rate)


def _hung(of: VibrationResult) -> Iterator[LimitValueRow]:
    """Yield the lateral growth of each shaft on rubber, in each gear."""
    for line in of.lines:
        for gear, rates in zip(of.gears, line.lateral_growth.tolist(), strict=True):
            for k, rate in enumerate(rates, 1):
                if not np.isnan(rate):
                    yield LimitValueRow(line.line.name, gear, Part("shaft", k), rate)


def _spring_behind(of: PowertrainVibration, line: Line, joint: int) -> int:
    """Return the place of the spring behind a joint of a line: its shaft, or the pinion."""
    part = Part("shaft", joint) if joint < line.joint_count else Part("pinion")
    return of.powertrain.springs.index((line.name, part))


def gears_with_clutch_closed_or_slipping(
    of: VibrationResult,
) -> Iterator[tuple[PowertrainVibration, int, EvaluationCondition]]:
    """Yield each gear with its clutch closed, and slipping where it does."""
    for driven, how in ((of.closed, ""), (of.slipping, SLIPPING_CLUTCH_LABEL)):
        for g, gear in enumerate(of.gears):
            if np.isfinite(driven.ranges[g]).any():
                yield driven, g, replace(gear, what=how)


def _rated(of: VibrationResult, *, rating: str) -> Iterator[LimitValueRow]:
    """Yield vibratory, or largest, torque of each joint over its rating, in each gear."""
    for line in (v.line for v in of.lines):
        sizes: tuple[JointSize | None, ...] = line.joints or (None,) * line.joint_count
        for k, size in enumerate(sizes, 1):
            held = getattr(size, rating, None)
            for driven, g, when in gears_with_clutch_closed_or_slipping(of):
                values = (
                    driven.worst_vibratory_torque
                    if rating == "reversing_torque"
                    else driven.peak_torque
                )
                mine = values[g, :, _spring_behind(driven, line, k)]
                if np.isfinite(mine).any():
                    share = float(np.nanmax(mine)) / held if held else np.nan
                    yield LimitValueRow(line.name, when, Part("joint", k), share)


def _reversals(of: VibrationResult) -> Iterator[LimitValueRow]:
    """Yield the largest vibratory torque of each line over its mean, in each gear."""
    for line in (v.line for v in of.lines):
        for driven, g, when in gears_with_clutch_closed_or_slipping(of):
            joints = range(1, line.joint_count + 1)
            mine = driven.vibratory_ratio[g][:, [_spring_behind(driven, line, k) for k in joints]]
            if np.isfinite(mine).any():
                yield LimitValueRow(line.name, when, WHOLE_LINE, float(np.nanmax(mine)))


def _accelerations(of: VibrationResult) -> Iterator[LimitValueRow]:
    """Yield the largest acceleration of each line's pinion, in each gear."""
    for k, line in enumerate(v.line for v in of.lines):
        for driven, g, when in gears_with_clutch_closed_or_slipping(of):
            mine = driven.acceleration[g, :, k]
            if np.isfinite(mine).any():
                yield LimitValueRow(line.name, when, Part("pinion"), float(np.nanmax(mine)))


def condition_of_launch(of: Launch) -> EvaluationCondition:
    """Return when the numbers of a launch apply."""
    return EvaluationCondition("launch", of.gear, f"{of.ramp:g}")


def _is_judged(of: VibrationResult, launch: Launch) -> bool:
    """Whether a launch's torque has limits: a dropped clutch's if the file requests it."""
    return bool(of.application.launches) or launch.capacity <= 1


def _judged(of: VibrationResult) -> Iterator[LaunchResult]:
    """Yield the launches whose torque is held against limits."""
    yield from (started for started in of.launches if _is_judged(of, started.launch))


def _launch_peaks(of: VibrationResult) -> Iterator[LimitValueRow]:
    """Yield the peak torque of each joint in each launch over its rating."""
    for started in _judged(of):
        for line in (v.line for v in of.lines):
            sizes: tuple[JointSize | None, ...] = line.joints or (None,) * line.joint_count
            for k, size in enumerate(sizes, 1):
                part = Part("shaft", k) if k < line.joint_count else Part("pinion")
                at = started.springs.index((line.name, part))
                held = (size and size.peak_torque) or np.nan
                low, high = (started.peak_range[:, at] / held).tolist()
                yield LimitValueRow(
                    line.name, condition_of_launch(started.launch), Part("joint", k),
                    float(started.peak_torque[at]) / held, (low, high), started.assumed,
                )  # fmt: skip


def _launch_reversals(of: VibrationResult) -> Iterator[LimitValueRow]:
    """Yield how far each line's torque swings back in each launch, over its peak."""
    for started in _judged(of):
        for line in (v.line for v in of.lines):
            at = started.springs.index((line.name, Part("shaft", 1)))
            back = -float(started.lowest_torque[at]) / float(started.peak_torque[at])
            low, high = started.reversal_range[:, at].tolist()
            yield LimitValueRow(
                line.name, condition_of_launch(started.launch), WHOLE_LINE, back,
                (low, high), started.assumed,
            )  # fmt: skip


def _launch_bearings(of: VibrationResult) -> Iterator[LimitValueRow]:
    """Yield the largest force on each centre bearing as a launch passes its resonances.

    Of a dropped clutch too, which every vehicle with a clutch meets: brackets bear what comes.
    """
    for started in of.launches:
        forces = started.bearing_transient_force.max(0)
        # Which way it goes is unknown: rubber is at its stop where its softer way would be.
        beyond = np.where(
            forces > started.least_force_at_stop,
            1 - forces / np.maximum(started.least_force_at_stop, 1.0),
            np.inf,
        )
        for b, (force, margin) in enumerate(zip(forces.tolist(), beyond.tolist(), strict=True), 1):
            yield LimitValueRow(
                of.lines[0].line.name, condition_of_launch(started.launch),
                Part("centre bearing", b), force, validity_margin=margin,
            )  # fmt: skip
