"""What a reader should know: where an application contradicts itself, what is assumed."""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace

import numpy as np

from cardan.base.arrays import BoolArray, FloatArray
from cardan.base.errors import DesignError
from cardan.base.said import Said, said
from cardan.base.units import mm
from cardan.base.verdict import EQUAL, GRADES
from cardan.demand.line import ResolvedLine
from cardan.demand.suspension import beyond_stops, spring_load, table_rates
from cardan.loads.rubber import LOSS
from cardan.model.application import Application
from cardan.model.vehicle import Linkage, Spring
from cardan.quantity import points
from cardan.quantity.quantities import QUANTITIES
from cardan.quantity.response import Response
from cardan.study.driveline import Asked, asked

MISMATCH = 0.005
"""Share by which stated rates may miss the loads of their table before it is worth a word."""

LINEAR = 10 * mm
"""How far the rubber of a centre bearing may be taken to go without stiffening: house practice."""

OF_ANGLES = frozenset({
    "joint_angle", "joint_angle_min", "end_angle_difference", "odd_joint_angle",
    "torsional_acceleration", "inertia_drive_acceleration", "inertia_coast_acceleration",
    "inertia_drive_torque", "inertia_coast_torque", "irregularity", "angle_for_speed", "n_beta",
})  # fmt: skip
"""What follows from where the joints are, and from speed, alone."""

OTHERWISE = (LOSS / 2, 2 * LOSS)
"""Loss factors between which rubber mounts lie."""


def noted(application: Application, responses: Sequence[Response]) -> Iterator[Said]:
    """Yield what a reader of an approval should know, in sentences without their ends."""
    yield from _mismatches(application)
    yield from _assumed_losses(responses)
    yield from _beyond_stops(responses)
    yield from _giving_rubber(responses)
    yield from _set_down(responses)
    yield from _lifted_axles(responses)
    yield from _not_driven(responses)
    yield from _left_out(responses)
    yield from _uneven_ahead(responses)


def _figures(value: float) -> str:
    """Return a number of four figures."""
    return np.format_float_positional(float(f"{value:.4g}"), trim="-")


def _mm(length: float, digits: int = 3) -> str:
    return f"{length / mm:.{digits}g}"


# --------------------------------------------------------------------------- springs


def _mismatches(application: Application) -> Iterator[Said]:
    """Yield the springs of an application that contradict themselves, each once."""
    suspensions = (application.suspension, *(i.suspension for i in application.lines))
    for s in {id(s): s for s in suspensions if s is not None}.values():
        yield from _mismatch(s.spring)


def _mismatch(spring: Spring) -> Iterator[Said]:
    """Yield how far a drawing's stated rates are from the loads of its own table, if they are.

    Where fewer rates are stated than the table has slopes, a second one starts where the
    table's first slope ends.
    """
    stated, rates = spring.stated_rates, table_rates(spring)
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
    if abs(apart[worst]) > MISMATCH:
        yield said(
            "a spring's stated {stated} N/mm are {apart} off the load of its own table at "
            "{deflection} mm, which rises by {table} N/mm and counts",
            stated=tuple(_figures(rate * mm) for rate in stated),
            apart=f"{100 * apart[worst]:+.1f} %",
            deflection=_mm(float(at[worst]), 4),
            table=tuple(_figures(rate * mm) for rate in rates.tolist()),
        )


# --------------------------------------------------------------------------- rubber


def _assumed_losses(responses: Iterable[Response]) -> Iterator[Said]:
    """Yield, line by line, what rests on a loss factor that nobody gave.

    It is the largest dynamic force on a bearing, and what other factors make of it there.
    """
    for r in responses:
        given = all(
            b.stiffness is None or b.loss_factor is not None for b in r.line.centre_bearings
        )
        if given or r.held is None or "dynamic" not in r.worst or r.layout.points.ndim > 3:
            continue
        force = QUANTITIES["centre_bearing_dynamic"].values(r)
        if np.isnan(force).all():  # of a line whose speed nobody knows, or that swings
            continue
        s, k = np.unravel_index(int(np.nanargmax(force)), force.shape)
        more, less = points.otherwise(r, np.array(OTHERWISE)[:, None]).dynamic[:, s, k].tolist()
        yield said(
            "the rubber's loss factor {factor} is assumed: centre bearing {bearing} of line {line} "
            "carries {force} N in {state}, with {low} it would be {more} N, with {high} {less} N",
            factor=f"{LOSS:g}",
            bearing=int(k) + 1,
            line=r.line.name,
            force=_figures(force[s, k]),
            state=r.demand.states[s],
            low=f"{OTHERWISE[0]:g}",
            more=_figures(more),
            high=f"{OTHERWISE[1]:g}",
            less=_figures(less),
        )


def _beyond_stops(responses: Iterable[Response]) -> Iterator[Said]:
    """Yield the centre bearings that would go on where their rubber ends."""
    for r, moves in _travels(responses):
        for k, stop in enumerate(np.broadcast_to(r.stops, moves.shape[-1:]).tolist()):
            beyond = moves[:, k] > stop * (1 + EQUAL)
            if beyond.any():
                yield said(
                    "centre bearing {bearing} of line {line} goes beyond its stop in {states}: up "
                    "to {moves} mm, where its rubber has {stop}; forces on rubber there are those "
                    "of rubber that goes on",
                    bearing=k + 1,
                    line=r.line.name,
                    states=_where(r, beyond),
                    moves=_mm(np.nanmax(moves[:, k])),
                    stop=_mm(stop),
                )


def _giving_rubber(responses: Iterable[Response]) -> Iterator[Said]:
    """Yield, line by line, how far rubber gives where that is much, and nobody knows its stop."""
    for r, moves in _travels(responses):
        told = np.where(np.isnan(r.stops), moves, np.nan)
        if not np.nanmax(told, initial=0.0) > LINEAR:
            continue
        s, k = np.unravel_index(int(np.nanargmax(told)), told.shape)
        assert r.worst_travel is not None  # or nothing moves
        yield said(
            "rubber is taken as linear and without a stop: centre bearing {bearing} of line "
            "{line} moves by up to {moves} mm in {state}, {steady} mm of it steadily",
            bearing=int(k) + 1,
            line=r.line.name,
            moves=_mm(told[s, k]),
            state=r.demand.states[s],
            steady=_mm(r.worst_travel.running.static[s, k]),
        )


def _set_down(responses: Iterable[Response]) -> Iterator[Said]:
    """Yield what limits of angles and unevenness would say of a line under torque, if otherwise.

    Of each limit on a line, where that leaves least.
    """
    for r in responses:
        if r.layout.points.ndim > 3:
            continue
        try:
            both = [[*asked(of, quantities=OF_ANGLES)] for of in (r, points.settled(r))]
        except DesignError:  # as it hangs it does not, or nobody had come here
            yield said(
                "with the bearings where torque moves them on their rubber a joint of line {line} "
                "locks: the rubber is too soft for it, or too far from its joint",
                line=r.line.name,
            )
            continue
        for hung, given, at, grade in _regraded(*both):
            quantity = QUANTITIES[hung.limit.quantity]
            yield said(
                "with the shafts twisted by torque and the bearings where it moves them on their "
                "rubber, {quantity}, {part} of line {line}, would be {given} for {hung} {unit} in "
                "{state}: {grade}",
                quantity=quantity.name,
                part=hung.parts[at[1]],
                line=r.line.name,
                state=r.demand.states[at[0]],
                grade=grade,
                given=_figures(given.values[at] / quantity.factor),
                hung=_figures(hung.values[at] / quantity.factor),
                unit=quantity.unit_name,
            )


def _regraded(
    told: Iterable[Asked], otherwise: Iterable[Asked]
) -> Iterator[tuple[Asked, Asked, tuple[int, int], str]]:
    """Yield what limits would say otherwise: both answers, and where that leaves least, and so."""
    for one, other in zip(told, otherwise, strict=True):
        (before, _), (after, left) = (one.limit.judged(each.values) for each in (one, other))
        turned = (before != after) & ~np.isnan(one.values) & ~np.isnan(other.values)
        if turned.any():
            least = int(np.where(turned, left, np.inf).argmin())
            state, part = (int(k) for k in np.unravel_index(least, left.shape))
            yield one, other, (state, part), GRADES[after[state, part]]


def _travels(responses: Iterable[Response]) -> Iterator[tuple[Response, FloatArray]]:
    """Yield lines on rubber, and how far each bearing goes across its own, (S, n-2) m."""
    for r in responses:
        if r.held is None or r.worst_travel is None or r.layout.points.ndim > 3:
            continue
        # Of a line whose speed nobody knows, or that swings, no force has an answer.
        known = np.isfinite(QUANTITIES["centre_bearing_peak"].values(r))
        if known.any():
            yield r, np.where(known, r.worst_travel.running.peak, np.nan)


def _where(r: Response, there: BoolArray) -> tuple[str, ...]:
    """Return the states in which something is so, (S,)."""
    return tuple(s for s, so in zip(r.demand.states, there.tolist(), strict=True) if so)


# --------------------------------------------------------------------------- how it is driven


def _lifted_axles(responses: Iterable[Response]) -> Iterator[Said]:
    """Yield in which states a front axle lifts, once for all lines that ask the same."""
    seen = set[tuple[str, ...]]()
    for r in responses:
        if r.demand.standing.line.vehicle is None:
            continue
        rest, slip = (np.asarray(load)[..., 0] for load in r.axle_loads)
        states = _where(r, (rest > 0) & (slip <= 0))
        if states and states not in seen:
            seen.add(states)
            yield said(
                "the front axle would lift before the driven wheels slip in {states}: the slip "
                "torque is what the whole weight on them holds",
                states=states,
            )


def _not_driven(responses: Iterable[Response]) -> Iterator[Said]:
    """Yield the ways in which a vehicle is driven by its engine, and some line is not asked."""
    of = [
        r.demand for r in responses
        if (line := r.demand.standing.line).engine is not None and line.vehicle is not None
        and line.torque is None
    ]  # fmt: skip
    if any(np.isnan(d.coast_torque).all() for d in of):
        yield said(
            "coasting is not asked, and the swing of a joint's torque starts from 0: brake_torque "
            "of the engine, retarder_torque of the gearbox or coast_torque would say what holds "
            "back"
        )
    if any(d.standing.line.reverse is None for d in of):
        yield said("backing is not asked: reverse_ratio of the gearbox would say its torque")
    springs = [
        s for d in of if (s := d.standing.line.suspension) and s.windup_stiffness is not None
    ]
    if any(np.all(s.brake_torque == 0) for s in springs):
        yield said(
            "braking is not asked: brake_torque of the suspension would say how it turns the axle"
        )


def _left_out(responses: Iterable[Response]) -> Iterator[Said]:
    """Yield, line by line, what torque would do that nobody can tell of it."""
    for r in responses:
        if np.isnan(r.demand.torque).all() or r.layout.points.ndim > 3:
            continue
        yield from _of_shafts(r)
        yield from _of_the_axle(r)


def _uneven_ahead(responses: Sequence[Response]) -> Iterator[Said]:
    """Yield what turns a line between axles unevenly: the pinion of the axle that it leaves."""
    uneven = QUANTITIES["torsional_acceleration"]
    for r in responses:
        own = r.demand.installed
        if own.output_joint is None or r.layout.points.ndim > 3:
            continue
        values = [
            np.nan_to_num(uneven.values(o)).max(axis=-1)
            for o in responses
            if own.leaves(o.demand.installed)
        ]
        swings = np.max([np.zeros(len(r.demand.states)), *values], axis=0)
        if swings.any():
            s = int(swings.argmax())
            yield said(
                "line {line} is told as if the axle that it leaves turned evenly: its pinion "
                "swings by {acceleration} rad/s² in {state}, and the through-shaft passes that on",
                line=r.line.name,
                acceleration=_figures(float(swings[s])),
                state=r.demand.states[s],
            )
        # How the yokes of both lines stand to each other is as the through-shaft was put in.
        own = [*asked(r, quantities={"torsional_acceleration"})]
        both = [replace(one, values=one.values + swings[:, None]) for one in own]
        for alone, together, at, grade in _regraded(own, both):
            yield said(
                "where both swing alike the pinion of line {line} has {both} rad/s² for {alone} in "
                "{state}: {grade}",
                line=r.line.name,
                both=_figures(together.values[at]),
                alone=_figures(alone.values[at]),
                state=r.demand.states[at[0]],
                grade=grade,
            )


def _of_shafts(r: Response) -> Iterator[Said]:
    """Yield what a file leaves out of shafts that hang in bearings, and what that makes."""
    name, (*ahead, last) = r.line.name, r.line.shafts
    if not r.line.centre_bearings:
        return
    plunges = any(size is not None and size.plunge is not None for size in r.sizes[-2:])
    if last.spline is None and not plunges:
        yield said(
            "nothing slides in the last shaft of line {line}: its spline would say what thrust the"
            " centre bearings carry",
            line=name,
        )
    if last.spline is not None and last.spline.mean_radius is None:
        yield said(
            "the spline of line {line} is taken to slide freely: mean_radius_mm would say its "
            "thrust",
            line=name,
        )
    if any(shaft.spline for shaft in ahead):
        yield said(
            "a spline ahead of the last shaft of line {line} counts by its mass alone: thrust and "
            "stroke are those of the last",
            line=name,
        )
    light = all(np.all(np.equal(shaft.yoke_mass, 0)) for shaft in r.line.shafts)
    if r.held is not None and light:
        yield said(
            "the yokes of line {line} weigh nothing: yoke_mass_kg would say what shakes with its "
            "tubes",
            line=name,
        )


def _of_the_axle(r: Response) -> Iterator[Said]:
    """Yield what a file leaves out of an axle that torque moves, and what that makes."""
    name, of, line = r.line.name, r.demand.standing, r.demand.standing.line
    springs, axle = line.suspension, line.axle
    if line.installed.drives == "all" or (springs is None and axle is None and not line.vehicle):
        return
    if springs is None or axle is None:
        yield said(
            "torque does not move the axle of line {line}: {missing} would say how far",
            line=name,
            missing="suspension" if springs is None else "axle",
        )
        return
    laid = np.array([own is not None for own in line.own])
    if laid.any() and (springs.squats or springs.windup_stiffness is not None):
        yield said(
            "line {line} runs in {states} as these say, whatever its torque: it does not move the "
            "axle there",
            line=name,
            states=_where(r, laid),
        )
    if not line.free.any():
        return
    if springs.windup_stiffness is None:
        yield said(
            "torque does not wind up the axle of line {line}: windup_stiffness would say how far",
            line=name,
        )
    if np.all(springs.unsprung_mass == 0):
        yield said(
            "the springs of line {line} carry all of the axle's load: unsprung_mass_kg would say "
            "what they do not",
            line=name,
        )
    if springs.linkage == Linkage():
        yield said(
            "the axle of line {line} rises straight up: linkage would say what guides it",
            line=name,
        )
    if np.all(np.equal(axle.pinion_joint, 0)):
        yield said(
            "the last joint of line {line} is taken at the wheel's centre: the axle's pinion would"
            " say where it is",
            line=name,
        )
    if of.squats.any() and springs.jounce_deflection is None and not springs.spring.ends:
        yield said(
            "nothing stops the axle of line {line} as it rises: jounce_deflection_mm would say "
            "where its bump stop is",
            line=name,
        )
    past = line.free & line.rests & beyond_stops(springs, of.stands)
    if past.any():
        yield said(
            "the axle of line {line} stands beyond its strap or bump stop in {states}, which "
            "should not let it",
            line=name,
            states=_where(r, past),
        )
    unknown = line.free & line.rests & ~(of.squats & np.isfinite(of.loads.lever))
    if springs.squats and unknown.any():
        yield said(
            "the axle of line {line} is not moved on its springs by what its tyres pull in "
            "{states}: {missing} would say how far",
            line=name,
            states=_where(r, unknown),
            missing=_unknown_load(line, unknown),
        )


def _unknown_load(line: ResolvedLine, states: BoolArray) -> str:
    """Return the key that a file lacks where nobody knows what load moves with the tyres' pull."""
    if line.tyre is None:
        return "tyre"
    if line.vehicle is None:
        return "vehicle"
    bare = [
        own.name
        for own, so in zip(line.loadings, states.tolist(), strict=True)
        if so and not own.load
    ]
    return f"vehicle.loads.{bare[0]}" if bare else "cg_height_mm"
