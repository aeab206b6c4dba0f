"""What a reader should know: where an application contradicts itself, what is assumed."""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace

import numpy as np

from cardan.application.driveline_relations import VEHICLE_PROFILES
from cardan.approval.driveline_study import EvaluatedLimit, evaluate_limits
from cardan.approval.limit_conflicts import conflicting_limits
from cardan.checks.line_response import LineResponse, deflected_line
from cardan.checks.quantities.registry import QUANTITIES
from cardan.core.arrays import BoolArray, FloatArray
from cardan.core.errors import DesignError
from cardan.core.labels import Part
from cardan.core.message import TranslatableMessage, translatable_message
from cardan.core.units import mm, rpm
from cardan.core.verdict import CHECK_GRADES, GRADE_TEXTS, MARGIN_TOLERANCE, CheckGrade
from cardan.model.application import Application
from cardan.model.vehicle import Linkage, Spring
from cardan.physics.loads.rubber_mount import (
    DEFAULT_LOSS_FACTOR,
    DEFAULT_STOP_TRAVEL_M,
    LOSS_FACTOR_RANGE,
)
from cardan.physics.vehicle.resolved_line import LineWithResolvedReferences
from cardan.physics.vehicle.suspension import (
    is_beyond_suspension_stops,
    spring_load,
    spring_table_rates,
)

MAX_SPRING_RATE_DEVIATION = 0.005
"""Share by which stated rates may miss the loads of their table before it is worth a word."""

MAX_LINEAR_RUBBER_TRAVEL_M = 10 * mm
"""Deflection of a centre bearing's rubber without stiffening, at most: engineering judgement."""

STRENGTH_QUANTITIES = frozenset({"joint_torque_utilisation", "tube_shear_utilisation"})
"""What a wrong torque makes pass first."""

CRITICAL_SPEED_QUANTITIES = frozenset({"critical_speed_ratio", "half_critical_band"})
"""What a wrong length makes pass first: critical speed falls with its square."""

ANGLE_QUANTITIES = frozenset({
    "joint_angle", "joint_angle_min", "end_angle_difference", "odd_joint_angle",
    "torsional_acceleration", "inertia_drive_acceleration", "inertia_coast_acceleration",
    "inertia_drive_torque", "inertia_coast_torque", "irregularity", "angle_for_speed", "n_beta",
})  # fmt: skip
"""What follows from where the joints are, and from speed, alone."""


def approval_notes(
    application: Application, responses: Sequence[LineResponse]
) -> Iterator[TranslatableMessage]:
    """Yield what a reader of an approval should know, in sentences without their ends."""
    yield from _placeholders(application)
    yield from conflicting_limits([r for r in responses if r.layout.points.ndim == 3])
    yield from _unasked_joints(responses)
    yield from _mismatches(application)
    yield from _missing_obstacles(application)
    yield from _unconfirmed_demand(application)
    yield from _reached_speeds(responses)
    yield from _rigid_bearings(responses)
    yield from _assumed_losses(responses)
    yield from _beyond_stops(responses)
    yield from _giving_rubber(responses)
    yield from _set_down(responses)
    yield from _lifted_axles(responses)
    yield from _not_driven(responses)
    yield from _left_out(responses)
    yield from _uneven_ahead(responses)


def _placeholders(application: Application) -> Iterator[TranslatableMessage]:
    """Yield which values are not the vehicle's yet, for which nothing is evaluated."""
    if application.placeholders:
        yield translatable_message(
            "nothing is evaluated while these keys hold placeholders: {names}",
            names=", ".join(application.placeholders),
        )


def _figures(value: float) -> str:
    """Return a number of four figures."""
    return np.format_float_positional(float(f"{value:.4g}"), trim="-")


def _mm(length: float, digits: int = 3) -> str:
    return f"{length / mm:.{digits}g}"


# --------------------------------------------------------------------------- joints


def _unasked_joints(responses: Iterable[LineResponse]) -> Iterator[TranslatableMessage]:
    """Yield joints other than crosses whose angle no limit applies to: nothing rates them."""
    for r in responses:
        if {m.quantity for m in r.application.limits} & {"joint_angle", "compound_angle"}:
            continue  # then each misses its rating, and is listed so
        angle = QUANTITIES["joint_angle"]
        unrated = angle.needs_own_rating(r) & ~angle.has_own_rating(r)
        for k in np.flatnonzero(unrated).tolist():
            yield translatable_message(
                "angle of {part} of line {line} is not evaluated (input missing: angle_max_deg)",
                part=Part("joint", k + 1),
                line=r.line.name,
            )


# --------------------------------------------------------------------------- springs


def _mismatches(application: Application) -> Iterator[TranslatableMessage]:
    """Yield the springs of an application that contradict themselves, each once."""
    suspensions = (application.suspension, *(i.suspension for i in application.lines))
    for s in {id(s): s for s in suspensions if s is not None}.values():
        yield from _mismatch(s.spring)


def _mismatch(spring: Spring) -> Iterator[TranslatableMessage]:
    """Yield how far a drawing's stated rates are from the loads of its own table, if they are.

    Where fewer rates are stated than the table has slopes, a second one starts where the
    table's first slope ends.
    """
    stated, rates = spring.stated_rates, spring_table_rates(spring)
    if not stated:
        return
    at = np.asarray(spring.deflection, dtype=float)
    starts = at[: len(stated)]
    slope = np.asarray(stated, dtype=float)[: len(starts)]
    ends = np.append(starts[1:], np.inf)
    reach = np.clip(at[:, None], starts, ends) - starts
    carried = float(spring.load[0]) + reach @ slope
    table = spring_load(spring, at)
    apart = np.divide(carried, table, out=np.ones_like(table), where=table > 0) - 1
    worst = int(np.argmax(np.abs(apart)))
    if abs(apart[worst]) > MAX_SPRING_RATE_DEVIATION:
        yield translatable_message(
            "a spring's stated {stated} N/mm are {apart} off the load of its own table at "
            "{deflection} mm, which rises by {table} N/mm and counts",
            stated=tuple(_figures(rate * mm) for rate in stated),
            apart=f"{100 * apart[worst]:+.1f} %",
            deflection=_mm(float(at[worst]), 4),
            table=tuple(_figures(rate * mm) for rate in rates.tolist()),
        )


# --------------------------------------------------------------------------- speed


def _reached_speeds(responses: Iterable[LineResponse]) -> Iterator[TranslatableMessage]:
    """Yield the lines that engine and gears turn faster than the file says."""
    for r in responses:
        if r.layout.points.ndim > 3:
            continue
        faster = r.inputs.reached_speed > r.demand.speed * (1 + MARGIN_TOLERANCE)
        if faster.any() and r.strength.line_modes is not None:
            yield translatable_message(
                "critical speeds of line {line} are evaluated at {reached} rpm, which the engine "
                "reaches in its highest gear; the file gives {given} rpm, and accelerations are of "
                "that: {factor} times as large at the speed reached",
                line=r.line.name,
                reached=_figures(float(r.inputs.reached_speed[faster].max()) / rpm),
                given=_figures(float(r.demand.speed[faster].max()) / rpm),
                factor=f"{float((r.inputs.reached_speed / r.demand.speed)[faster].max()) ** 2:.2g}",
            )


# --------------------------------------------------------------------------- rubber


def _rigid_bearings(responses: Iterable[LineResponse]) -> Iterator[TranslatableMessage]:
    """Yield the lines whose centre bearings are evaluated as rigid, none of them on rubber."""
    for r in responses:
        if r.line.centre_bearings and r.mounts.is_rigid and r.line.has_lengths:
            yield translatable_message(
                "the centre bearings of line {line} have no stiffness and are evaluated as rigid; "
                "on rubber their dynamic force is several times as large where order 2 meets a "
                "mode: stiffness_N_mm would say",
                line=r.line.name,
            )


def _assumed_losses(responses: Iterable[LineResponse]) -> Iterator[TranslatableMessage]:
    """Yield, line by line, what rests on a loss factor that is not given.

    It is the largest dynamic force on a bearing, and what other factors make of it there.
    """
    for r in responses:
        given = all(
            b.stiffness is None or b.loss_factor is not None for b in r.line.centre_bearings
        )
        if (
            given
            or r.mounts.mounted_line is None
            or "dynamic" not in r.mount_loads.worst_bearing_forces
            or r.layout.points.ndim > 3
        ):
            continue
        every, is_bound = QUANTITIES["centre_bearing_dynamic"].values_and_bounds(r)
        if np.isnan(every).all():  # of a line of unknown speed, or that swings
            continue
        # Where rubber meets its stop, or a spline sticks, another crest counts.
        at_stop = r.mount_loads.is_solved_at_stop | is_bound
        force = np.where(at_stop | r.mount_loads.is_stuck("dynamic"), np.nan, every)
        if at_stop.any() and not np.fmax.reduce(force, None) >= np.nanmax(every):
            yield translatable_message(
                "the rubber's loss factor {factor} is assumed, and forces of line {line} at its "
                "stop depend on it: give loss_factor",
                factor=f"{DEFAULT_LOSS_FACTOR:g}",
                line=r.line.name,
            )
            continue
        if np.isnan(force).all():
            continue
        s, k = np.unravel_index(int(np.nanargmax(force)), force.shape)
        more, less = (
            r.mount_loads.forces_with_other_loss_factors(np.array(LOSS_FACTOR_RANGE)[:, None])
            .dynamic[:, s, k]
            .tolist()
        )
        yield translatable_message(
            "the rubber's loss factor {factor} is assumed: centre bearing {bearing} of line {line} "
            "carries {force} N in {state}, with {low} it would be {more} N, with {high} {less} N",
            factor=f"{DEFAULT_LOSS_FACTOR:g}",
            bearing=int(k) + 1,
            line=r.line.name,
            force=_figures(force[s, k]),
            state=r.demand.states[s],
            low=f"{LOSS_FACTOR_RANGE[0]:g}",
            more=_figures(more),
            high=f"{LOSS_FACTOR_RANGE[1]:g}",
            less=_figures(less),
        )


def _beyond_stops(responses: Iterable[LineResponse]) -> Iterator[TranslatableMessage]:
    """Yield the centre bearings that would go on where their rubber ends."""
    for r, moves in _travels(responses):
        for k, stop in enumerate(
            np.broadcast_to(r.mount_loads.mount_stop_travel, moves.shape[-1:]).tolist()
        ):
            beyond = moves[:, k] > stop * (1 + MARGIN_TOLERANCE)
            if not beyond.any():
                continue
            given = {
                "bearing": k + 1,
                "line": r.line.name,
                "states": _where(r, beyond),
                "moves": _mm(np.nanmax(moves[:, k])),
                "stop": _mm(stop),
            }
            if (beyond & ~r.mount_loads.is_solved_at_stop[:, 0]).any():
                yield translatable_message(
                    "centre bearing {bearing} of line {line} goes beyond its stop in {states}: up "
                    "to {moves} mm, where its rubber has {stop}; forces there are lower bounds (≥)",
                    **given,
                )
            else:
                yield translatable_message(
                    "centre bearing {bearing} of line {line} meets its stop in {states}: linear "
                    "rubber would move by up to {moves} mm, and has {stop}; beyond that it is "
                    "taken as {ratio} times as stiff, peak force {peak} N",
                    **given,
                    **_stiffer_beyond_stop(r, beyond, k),
                )


def _stiffer_beyond_stop(r: LineResponse, states: BoolArray, bearing: int) -> dict[str, str]:
    """Return how stiff a bearing is taken beyond its stop, and its largest peak force there."""
    solved = r.mount_loads.stop_response
    assert solved is not None  # of states in which it is
    peaks = solved.forces["peak"][:, states, bearing]
    peaks = peaks[:, np.nanargmax(peaks[-1])]
    known = ~np.isnan(peaks)
    return {
        "ratio": _from_to([f"{ratio:g}" for ratio in solved.ratios[known, bearing]]),
        "peak": _from_to([_figures(force) for force in sorted(peaks[known])]),
    }


def _from_to(ends: list[str]) -> str:
    """Return a range, or the one value of both ends."""
    return "–".join(dict.fromkeys(ends))


def _giving_rubber(responses: Iterable[LineResponse]) -> Iterator[TranslatableMessage]:
    """Yield, line by line, how far rubber deflects where that is much, and its stop is unknown."""
    for r, moves in _travels(responses):
        told = np.where(np.isnan(r.mount_loads.mount_stop_travel), moves, np.nan)
        if not np.nanmax(told, initial=0.0) > MAX_LINEAR_RUBBER_TRAVEL_M:
            continue
        s, k = np.unravel_index(int(np.nanargmax(told)), told.shape)
        assert r.mount_loads.worst_bearing_travel is not None  # or nothing moves
        given = {
            "bearing": int(k) + 1,
            "line": r.line.name,
            "moves": _mm(told[s, k]),
            "state": r.demand.states[s],
            "steady": _mm(r.mount_loads.worst_bearing_travel.results.static[s, k]),
            "stop": _mm(DEFAULT_STOP_TRAVEL_M),
        }
        solved = np.broadcast_to(r.mount_loads.is_solved_at_stop[:, 0], told.shape[:1])
        if solved[s]:
            yield translatable_message(
                "rubber is taken as linear up to its stop: centre bearing {bearing} of line {line} "
                "would move by up to {moves} mm in {state}, {steady} mm of it steadily; beyond "
                "{stop} mm, an assumed stop, it is taken as {ratio} times as stiff, peak force "
                "{peak} N: give travel_mm and stop_stiffness_ratio",
                **given,
                **_stiffer_beyond_stop(r, np.arange(len(told)) == s, int(k)),
            )
        else:
            yield translatable_message(
                "rubber is taken as linear and without a stop: centre bearing {bearing} of line "
                "{line} moves by up to {moves} mm in {state}, {steady} mm of it steadily; beyond "
                "{stop} mm, an assumed stop, forces are lower bounds (≥): give travel_mm",
                **given,
            )


def _set_down(responses: Iterable[LineResponse]) -> Iterator[TranslatableMessage]:
    """Yield what limits of angles and unevenness would say of a line under torque, if otherwise.

    Of each limit on a line, where that leaves least.
    """
    for r in responses:
        if r.layout.points.ndim > 3:
            continue
        try:
            both = [
                [*evaluate_limits(of, quantities=ANGLE_QUANTITIES)] for of in (r, deflected_line(r))
            ]
        except DesignError:  # as it hangs it does not, or this line would not be reached
            yield translatable_message(
                "with the bearings where torque moves them on their rubber a joint of line {line} "
                "locks: the rubber is too soft for it, or too far from its joint",
                line=r.line.name,
            )
            continue
        for hung, given, at, grade in _regraded(*both):
            quantity = QUANTITIES[hung.limit.quantity]
            yield translatable_message(
                "with the shafts twisted by torque and the bearings where it moves them on their "
                "rubber, {quantity}, {part} of line {line}, would be {given} for {hung} {unit} in "
                "{state}: {grade}",
                quantity=quantity.name,
                part=hung.parts[at[1]],
                line=r.line.name,
                state=r.demand.states[at[0]],
                grade=GRADE_TEXTS[grade],
                given=_figures(given.values[at] / quantity.si_factor),
                hung=_figures(hung.values[at] / quantity.si_factor),
                unit=quantity.unit_symbol,
            )


def _regraded(
    told: Iterable[EvaluatedLimit], otherwise: Iterable[EvaluatedLimit]
) -> Iterator[tuple[EvaluatedLimit, EvaluatedLimit, tuple[int, int], CheckGrade]]:
    """Yield what limits would say otherwise: both answers, and where that leaves least, and so."""
    for one, other in zip(told, otherwise, strict=True):
        (before, _), (after, left) = (each.grades_and_margins() for each in (one, other))
        turned = (before != after) & ~np.isnan(one.values) & ~np.isnan(other.values)
        if turned.any():
            least = int(np.where(turned, left, np.inf).argmin())
            state, part = (int(k) for k in np.unravel_index(least, left.shape))
            yield one, other, (state, part), CHECK_GRADES[after[state, part]]


def _travels(responses: Iterable[LineResponse]) -> Iterator[tuple[LineResponse, FloatArray]]:
    """Yield lines on rubber, and how far each bearing goes across its own, (S, n-2) m."""
    for r in responses:
        if (
            r.mounts.mounted_line is None
            or r.mount_loads.worst_bearing_travel is None
            or r.layout.points.ndim > 3
        ):
            continue
        # Of a line of unknown speed, or that swings, no force has an answer.
        known = np.isfinite(QUANTITIES["centre_bearing_travel"].values(r)).any(-1, keepdims=True)
        if known.any():
            yield r, np.where(known, r.mount_loads.worst_bearing_travel.results.peak, np.nan)


def _where(r: LineResponse, there: BoolArray) -> tuple[str, ...]:
    """Return the states in which something is so, (S,)."""
    return tuple(s for s, so in zip(r.demand.states, there.tolist(), strict=True) if so)


# --------------------------------------------------------------------------- how it is driven


def _lifted_axles(responses: Iterable[LineResponse]) -> Iterator[TranslatableMessage]:
    """Yield in which states a front axle lifts, once for all lines with the same limit."""
    seen = set[tuple[str, ...]]()
    for r in responses:
        if r.demand.static_state.line.vehicle is None:
            continue
        rest, slip = (np.asarray(load)[..., 0] for load in r.axle_loads)
        states = _where(r, (rest > 0) & (slip <= 0))
        if states and states not in seen:
            seen.add(states)
            yield translatable_message(
                "the front axle would lift before the driven wheels slip in {states}: the slip "
                "torque is what the whole weight on them holds",
                states=states,
            )


def _not_driven(responses: Iterable[LineResponse]) -> Iterator[TranslatableMessage]:
    """Yield the ways in which a vehicle is driven by its engine, and some line is not evaluated."""
    of = [
        r.demand for r in responses
        if (line := r.demand.static_state.line).engine is not None and line.vehicle is not None
        and line.torque is None
    ]  # fmt: skip
    if any(np.isnan(d.coast_torque).all() for d in of):
        yield translatable_message(
            "overrun is not evaluated, and the alternating joint torque starts from 0 (input "
            "missing: brake_torque of the engine, retarder_torque of the gearbox or coast_torque)"
        )
    if any(d.static_state.line.reverse_gears is None for d in of):
        yield translatable_message(
            "reverse is not evaluated (input missing: reverse_ratio of the gearbox)"
        )
    springs = [
        s for d in of if (s := d.static_state.line.suspension) and s.windup_stiffness is not None
    ]
    if any(np.all(s.brake_torque == 0) for s in springs):
        yield translatable_message(
            "braking is not evaluated (input missing: brake_torque of the suspension, which winds "
            "the axle up)"
        )


def _missing_obstacles(application: Application) -> Iterator[TranslatableMessage]:
    """Yield that a vehicle has clearance as a criterion, and nothing that its shafts must clear."""
    limited = any(limit.quantity == "clearance" for limit in application.limits)
    if application.vehicle is not None and limited and not application.obstacles:
        yield translatable_message("clearance is not evaluated (input missing: obstacles)")


def _unconfirmed_demand(application: Application) -> Iterator[TranslatableMessage]:
    """Yield torques, speeds and lengths on which strength and speed limits rest unconfirmed.

    With an engine and gearbox, its power and a wheelbase they are compared
    (`cardan.application.plausibility`).
    """
    limited = {limit.quantity for limit in application.limits}
    given = {"torque_Nm": application.torque, "speed_rpm": application.speed}
    alone = [key for key, value in given.items() if value]
    if application.engine is None and alone and limited & STRENGTH_QUANTITIES:
        yield translatable_message(
            "nothing in the file confirms {keys}: check value and unit; engine and gearbox would",
            keys=", ".join(alone),
        )
    engine = application.engine
    if engine and engine.power is None and limited & STRENGTH_QUANTITIES:
        yield translatable_message(
            "nothing in the file confirms engine.torque_Nm: check its unit; engine.power_kW would"
        )
    road = application.profile.partition(",")[0] in VEHICLE_PROFILES
    typed = any(i.line.has_lengths for i in application.lines)
    if road and typed and application.vehicle is None and limited & CRITICAL_SPEED_QUANTITIES:
        yield translatable_message(
            "nothing in the file confirms the lengths of the shafts: check them; "
            "vehicle.wheelbase_mm would"
        )


def _left_out(responses: Iterable[LineResponse]) -> Iterator[TranslatableMessage]:
    """Yield, line by line, what torque would do and cannot be computed."""
    for r in responses:
        if np.isnan(r.demand.torque).all() or r.layout.points.ndim > 3:
            continue
        yield from _of_shafts(r)
        yield from _of_the_axle(r)


def _uneven_ahead(responses: Sequence[LineResponse]) -> Iterator[TranslatableMessage]:
    """Yield what turns a line between axles unevenly: the pinion of the axle that it leaves."""
    uneven = QUANTITIES["torsional_acceleration"]
    for r in responses:
        own = r.demand.installed
        if own.output_joint is None or r.layout.points.ndim > 3:
            continue
        values = [
            np.nan_to_num(uneven.values(o)).max(axis=-1)
            for o in responses
            if own.starts_at_axle_of(o.demand.installed)
        ]
        swings = np.max([np.zeros(len(r.demand.states)), *values], axis=0)
        if swings.any():
            s = int(swings.argmax())
            yield translatable_message(
                "line {line} is computed with uniform speed of the axle that it leaves; its "
                "pinion fluctuates by {acceleration} rad/s² in {state}, and the through-shaft "
                "passes that on",
                line=r.line.name,
                acceleration=_figures(float(swings[s])),
                state=r.demand.states[s],
            )
        # How the yokes of both lines stand to each other is as the through-shaft was put in.
        own = [*evaluate_limits(r, quantities={"torsional_acceleration"})]
        both = [replace(one, values=one.values + swings[:, None]) for one in own]
        for alone, together, at, grade in _regraded(own, both):
            yield translatable_message(
                "where both swing alike the pinion of line {line} has {both} rad/s² for {alone} in "
                "{state}: {grade}",
                line=r.line.name,
                both=_figures(together.values[at]),
                alone=_figures(alone.values[at]),
                state=r.demand.states[at[0]],
                grade=GRADE_TEXTS[grade],
            )


def _of_shafts(r: LineResponse) -> Iterator[TranslatableMessage]:
    """Yield what a file leaves out of shafts that hang in bearings, and what that makes."""
    name, (*ahead, last) = r.line.name, r.line.shafts
    if not r.line.centre_bearings:
        return
    plunges = any(size is not None and size.plunge is not None for size in r.joint_sizes[-2:])
    if last.spline is None and not plunges:
        yield translatable_message(
            "nothing slides in the last shaft of line {line}: its spline would say what thrust the"
            " centre bearings carry",
            line=name,
        )
    if last.spline is not None and last.spline.mean_radius is None:
        yield translatable_message(
            "the spline of line {line} is taken to slide freely: mean_radius_mm would say its "
            "thrust",
            line=name,
        )
    if any(shaft.spline for shaft in ahead):
        yield translatable_message(
            "a spline ahead of the last shaft of line {line} counts by its mass alone: thrust and "
            "stroke are those of the last",
            line=name,
        )
    light = all(np.all(np.equal(shaft.yoke_mass, 0)) for shaft in r.line.shafts)
    if r.mounts.mounted_line is not None and light:
        yield translatable_message(
            "the yokes of line {line} weigh nothing: yoke_mass_kg would say what shakes with its "
            "tubes",
            line=name,
        )


def _of_the_axle(r: LineResponse) -> Iterator[TranslatableMessage]:
    """Yield what a file leaves out of an axle that torque moves, and what that makes."""
    name, of, line = r.line.name, r.demand.static_state, r.demand.static_state.line
    springs, axle = line.suspension, line.axle
    if line.installed.drives == "all" or (springs is None and axle is None and not line.vehicle):
        return
    if springs is None or axle is None:
        yield translatable_message(
            "torque does not move the axle of line {line}: {missing} would say how far",
            line=name,
            missing="suspension" if springs is None else "axle",
        )
        return
    laid = np.array([own is not None for own in line.own_layouts])
    if laid.any() and (springs.squats or springs.windup_stiffness is not None):
        yield translatable_message(
            "line {line} runs in {states} as these say, whatever its torque: it does not move the "
            "axle there",
            line=name,
            states=_where(r, laid),
        )
    if not line.placed_by_suspension.any():
        return
    if springs.windup_stiffness is None:
        yield translatable_message(
            "torque does not wind up the axle of line {line}: windup_stiffness would say how far",
            line=name,
        )
    if np.all(springs.unsprung_mass == 0):
        yield translatable_message(
            "the springs of line {line} carry all of the axle's load: unsprung_mass_kg would say "
            "what they do not",
            line=name,
        )
    if springs.linkage == Linkage():
        yield translatable_message(
            "the axle of line {line} rises straight up: linkage would say what guides it",
            line=name,
        )
    if np.all(np.equal(axle.pinion_joint, 0)):
        yield translatable_message(
            "the last joint of line {line} is taken at the wheel's centre: the axle's pinion would"
            " say where it is",
            line=name,
        )
    if of.squats.any() and springs.jounce_deflection is None and not springs.spring.ends:
        yield translatable_message(
            "nothing stops the axle of line {line} as it rises: jounce_deflection_mm would say "
            "where its bump stop is",
            line=name,
        )
    past = (
        line.placed_by_suspension
        & line.between_stops
        & is_beyond_suspension_stops(springs, of.spring_deflection)
    )
    if past.any():
        yield translatable_message(
            "the axle of line {line} stands beyond its strap or bump stop in {states}, which "
            "should not let it",
            line=name,
            states=_where(r, past),
        )
    unknown = (
        line.placed_by_suspension
        & line.between_stops
        & ~(of.squats & np.isfinite(of.loads.transfer_per_force))
    )
    if springs.squats and unknown.any():
        yield translatable_message(
            "the axle of line {line} is not moved on its springs by what its tyres pull in "
            "{states}: {missing} would say how far",
            line=name,
            states=_where(r, unknown),
            missing=_unknown_load(line, unknown),
        )


def _unknown_load(line: LineWithResolvedReferences, states: BoolArray) -> str:
    """Return the key that a file lacks if it is unknown what load moves with the tyres' pull."""
    if line.tyre is None:
        return "tyre"
    if line.vehicle is None:
        return "vehicle"
    bare = [
        own.name
        for own, so in zip(line.load_states, states.tolist(), strict=True)
        if so and not own.load_state
    ]
    return f"vehicle.loads.{bare[0]}" if bare else "cg_height_mm"
