"""Thrust that the sliding spline reaches over the suspension's stroke, and what it does there.

The axle goes through the places that the states of an application give it, and between them, under
the torque of the state that is evaluated or what the tyres hold there at most. Where no state says
how far it rebounds and where it meets its stop, the stroke is unknown: then the spline holds its
whole slip force as a dead load would.
"""

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cardan.checks.line_inputs import LineInputs
from cardan.core.arrays import ArrayLike, BoolArray, FloatArray
from cardan.core.lazy_dataclass import dataclass
from cardan.model.layout import vector_length
from cardan.physics.loads.centre_bearing import ThrustEffect
from cardan.physics.loads.mean_line_loads import mean_line_loads
from cardan.physics.loads.rubber_mount import MountedLine
from cardan.physics.loads.screening import ScreenedThrust, held_share
from cardan.physics.loads.spline_thrust import (
    LARGEST_SHARE_OF_CRITICAL,
    CompressedLine,
    compressed_line,
    stroke_compression,
)
from cardan.physics.vehicle.axle_motion import AxleMotion
from cardan.physics.vehicle.operating_points import TorqueCurves
from cardan.physics.vehicle.state_demand import (
    axle_motion_under_torque,
    demand_at_axle_motion,
)

_REBOUND_STATES, _JOUNCE_STATES = {"full rebound", "rebound"}, {"jounce"}
_WOUND_STATES = {"windup", "windup brake"}

_SHARES = np.array([0.0, 1 / 3, 2 / 3])
"""Of the way from a state's place to the next one, where thrust is evaluated.

With 24 in place of 3 the largest mean force of five examples is 0 to 8 % larger.
"""


def is_stroke_known(inputs: LineInputs) -> bool:
    """Whether the states say both ends of the suspension's stroke."""
    kinds = set(inputs.state_kinds)
    return bool(kinds & _REBOUND_STATES) and bool(kinds & _JOUNCE_STATES)


@dataclass(frozen=True, kw_only=True, eq=False)
class StrokeThrust:
    """The thrust of a line's spline over the stroke, (..., S) states, and what it does.

    The first axis has the largest torque ahead and the largest one astern, or in overrun; the
    second has the spline pushed in and drawn out.

    Attributes
    ----------
    force : (2, 2, ..., S, n-2, 3) N
        What is added to the mean force on each bearing without thrust where the line lies, at
        the place of the stroke where the sum is largest.
    compression : (2, 2, ..., S, n-2) N
        In the spline there.
    own_force : (2, 2, ..., S, n-2, 3) N
        The same where the state itself has the axle.
    own_compression : (2, 2, ..., S) N
        In the spline there.
    moved : (2, 2, ..., S, N) m
        What that moves there, of the coordinates of `held`.
    held
        The line on its slowest modes.
    critical : (..., S) N
        Smallest critical compression under torque over the stroke.
    utilisation : (..., S) 1
        Compression reached over the critical one, at worst over the stroke.
    is_evaluated : (..., S)
        False where the slip force passes the critical compression and no stroke limits it.
    dead_load : (..., S, n-2) N
        Mean force with the whole slip force as a dead load where the line lies, in equilibrium:
        an upper estimate; nan where there is none.
    dead_load_shortening, shortening : (..., S) m
        How far the spline has to be pushed in for that, nan where there is no such equilibrium;
        and how far the suspension does between the places of the states.
    """

    force: FloatArray
    compression: FloatArray
    own_force: FloatArray
    own_compression: FloatArray
    moved: FloatArray
    held: MountedLine
    critical: FloatArray
    utilisation: FloatArray
    is_evaluated: BoolArray
    dead_load: FloatArray
    dead_load_shortening: FloatArray
    shortening: FloatArray

    def in_states(self, states: Sequence[int]) -> "StrokeThrust":
        """Return the same in some of its states, by their indices."""
        on_axis = {
            -1: (
                "own_compression", "critical", "utilisation", "is_evaluated",
                "dead_load_shortening", "shortening",
            ),
            -2: ("compression", "moved", "dead_load"),
            -3: ("force", "own_force"),
        }  # fmt: skip
        each = {
            name: getattr(self, name).take(states, axis=axis)
            for axis, names in on_axis.items()
            for name in names
        }
        return replace(self, held=self.held.select_states(states), **each)

    @cached_property
    def _shaft_ends(self) -> FloatArray:
        """How far thrust moves the shafts' ends where the line lies, (2, 2, ..., n-1, 2, 3) m."""
        return self.held.shaft_end_motion(self.moved[..., None, :].astype(complex))[
            ..., 0, :, :, :
        ].real

    def effect(self, torque: ArrayLike, slip: ArrayLike) -> ThrustEffect:
        """Return what thrust does at points (P, ..., S) with a torque N m and a slip force N.

        A smaller slip force than what the stroke reaches under the largest torque does less: in
        proportion at most, because a compression does more the larger it is.
        """
        T = np.asarray(torque, dtype=float)
        slip = np.nan_to_num(np.asarray(slip, dtype=float))

        def here(values: FloatArray, own: int) -> FloatArray:
            ahead = (T >= 0).reshape(*T.shape, *(1,) * own)
            both = [np.where(ahead, one, other) for one, other in zip(*values, strict=True)]
            return np.stack(both)

        P, own = here(self.compression, 1), here(self.own_compression, 0)
        share = held_share(slip[..., None], P)
        return ThrustEffect(
            force=here(self.force, 2) * share[..., None],
            thrust=-P * share,
            shaft_ends=here(self._shaft_ends, 3) * held_share(slip, own)[..., None, None, None],
        )

    def screened(self, *state: int) -> ScreenedThrust:
        """Return the same for the screening model, cases last.

        Of one `state` of one variant where the state has the axle: a launch goes through no stroke.
        """
        added, compression = self.force, self.compression
        if state:
            added = self.own_force
            compression = np.broadcast_to(self.own_compression[..., None], compression.shape)
        force = (self.held.bearing_frame @ added[..., None])[..., 0]
        force = force.reshape(*force.shape[:-2], -1)

        def last(values: FloatArray, own: int) -> FloatArray:
            cases = values.ndim - 2 - own
            if state:
                values = values[:, :, *state]
                cases = 0
            return np.moveaxis(values, range(2, 2 + cases), range(-cases, 0)) if cases else values

        return ScreenedThrust(
            force=last(force, 1),
            compression=last(compression, 1),
            own_compression=last(self.own_compression, 0),
            moved=last(self.moved, 1),
        )


def stroke_thrust(
    inputs: LineInputs, held: MountedLine | None, curves: TorqueCurves
) -> StrokeThrust | None:
    """Return the thrust of a line's spline over the stroke of its suspension.

    `held` is the line on its slowest modes. None of a line that is not on rubber, or whose
    spline radius is unknown.
    """
    spline = inputs.line.shafts[-1].spline
    if held is None or spline is None or spline.mean_radius is None or inputs.line.joint_count < 3:
        return None
    torque, coasts, brakes = _largest_torques(inputs, curves)
    states = torque.shape[-1]
    cases = torque.shape[1:-1]
    rows = 2 * states + 1

    def by_state(values: Any) -> Any:
        """Return what each state has at all places, (rows, ..., S'); nothing at rest."""
        each = np.moveaxis(values, -1, 1).reshape(2 * states, *cases, 1)
        each = np.concatenate([each, np.zeros_like(each[:1])])
        return np.broadcast_to(each, (*each.shape[:-1], states))

    between = _places_between(inputs, cases)
    own_place = np.concatenate([np.eye(states, dtype=bool)] * 2 + [np.zeros((1, states), bool)])
    own_place = own_place.reshape(rows, *(1,) * len(cases), states)
    full = by_state(torque)
    share = _SHARES.reshape(-1, *(1,) * full.ndim)
    T = np.copysign(np.fmin(np.abs(full), between.held_torque(share)), full)
    T[0] = np.where(own_place, full, T[0])
    ride = axle_motion_under_torque(
        inputs.demand, T[0], coasts=by_state(coasts), brakes=by_state(brakes)
    )
    asked = demand_at_axle_motion(
        inputs.demand, between.motion(ride, share), torque=T, speed=np.zeros(T.shape)
    )
    laid = inputs.layout_for(asked)
    loads = mean_line_loads(
        held, laid, inputs.line, inputs.phases, torque=T, gravity=inputs.gravity
    )
    of = compressed_line(held, forces=loads.push, spline=loads.spline_gradient, torque=T)
    lead = of.is_stable.shape
    slip = np.broadcast_to(inputs.spline_force_at(T), lead)

    every = _MeanBearingForces(
        line=of,
        without_motion=loads.fixed_bearing_forces,
        by_compression=loads.by_compression,
        by_modes=held.bearing_forces_of_shapes(of.shapes),
    )

    def apart(values: Any) -> Any:
        """Return rows (K, 2 S, ..., S', *) as torques, states and places, (2, S, K S', ..., *)."""
        values = np.broadcast_to(values, (*lead, *values.shape[len(lead) :]))[:, :-1]
        values = values.reshape(len(values), 2, states, *values.shape[2:])
        values = np.moveaxis(values, (0, len(lead)), (2, 3))
        return values.reshape(2, states, -1, *values.shape[4:])

    def own(values: Any, axes: int = 0) -> Any:
        """Return what stands at the states' own places, (2, ..., S, *), of so many own axes."""
        values = np.broadcast_to(values, (*lead, *values.shape[values.ndim - axes :]))[0, :-1]
        values = values.reshape(2, states, *values.shape[1:])
        values = np.moveaxis(values, 2 + len(cases), 2)[:, np.arange(states), np.arange(states)]
        return np.moveaxis(values, 1, 1 + len(cases))

    known = is_stroke_known(inputs)
    reached = _reached_places(inputs, stroke=known)
    critical = of.critical
    most = np.minimum(slip, LARGEST_SHARE_OF_CRITICAL * critical)

    def reached_by_row(reached: BoolArray) -> BoolArray:
        """Return the places (K, rows, ..., S') that the stroke of each row's state has."""
        each = np.concatenate([reached, reached, reached[:1] | True])
        each = each.reshape(rows, *(1,) * len(cases), states)
        there = each & between.exist
        return np.stack([np.broadcast_to(each, there.shape), *[there] * (len(share) - 1)])

    length = np.broadcast_to(laid.lengths[..., -1], lead)
    if known:
        found = stroke_compression(
            of,
            length=length,
            rest_length=length[:, -1:] + 0 * length,
            slip=slip,
            reached=reached_by_row(reached),
            place_axes=(0, -1),
        )
        pushed, drawn = found.pushed, found.drawn
        shortening = np.broadcast_to(found.shortening, lead)
    else:
        pushed, drawn = most, -slip
        places = reached_by_row(_reached_places(inputs, stroke=True))
        at_rest = length + of.lengthening(0.0)
        longest = np.where(places, at_rest, -np.inf).max((0, -1), keepdims=True)
        span = longest - np.where(places, at_rest, np.inf).min((0, -1), keepdims=True)
        shortening = np.broadcast_to(span, lead)
    in_place = every.at(own)
    own_line, own_compressions = in_place.line, [own(P) for P in (pushed, drawn)]
    at_own = in_place.under(np.zeros(own_compressions[0].shape))
    allowed = apart(reached_by_row(reached))[..., None]
    forces, compressions = [], []
    for P in (pushed, drawn):
        each = apart(every.under(P))
        size = np.where(allowed, vector_length(each), -1.0)
        worst = size.argmax(axis=2)[:, :, None]
        added = np.take_along_axis(each, worst[..., None], axis=2)[:, :, 0]
        forces.append(np.moveaxis(added, 1, 1 + len(cases)) - at_own)
        along = np.broadcast_to(apart(P)[..., None], size.shape)
        compressions.append(
            np.moveaxis(np.take_along_axis(along, worst, axis=2)[:, :, 0], 1, 1 + len(cases))
        )
    unmoved = own_line.coordinates(np.zeros(at_own.shape[:-2]))
    limit = apart(critical)
    taken = apart(pushed if known else slip) / np.where(limit > 0, limit, np.nan)
    taken = np.where(allowed[..., 0], taken, -np.inf).max(axis=2)
    stable = (apart(of.is_stable) | ~allowed[..., 0]).all(axis=2)
    holds, at_most = own((slip < critical) & of.is_stable), own(most)
    dead = np.where(holds[..., None], vector_length(in_place.under(at_most)), np.nan)
    needed = own_line.lengthening(at_most) - own_line.lengthening(0.0)
    return StrokeThrust(
        force=np.stack(forces, axis=1),
        compression=np.stack(compressions, axis=1),
        own_force=np.stack([in_place.under(P) - at_own for P in own_compressions], axis=1),
        own_compression=np.stack(own_compressions, axis=1),
        moved=np.stack([own_line.coordinates(P) - unmoved for P in own_compressions], axis=1),
        held=held,
        critical=np.moveaxis(
            np.where(allowed[..., 0], limit, np.inf).min(axis=(0, 2)), 0, len(cases)
        ),
        utilisation=np.moveaxis(taken.max(axis=0), 0, len(cases)),
        is_evaluated=np.moveaxis(np.asarray(stable.all(axis=0)), 0, len(cases))
        & (known | holds.all(axis=0)),
        dead_load=np.where(holds.all(axis=0)[..., None], dead.max(axis=0), np.nan),
        dead_load_shortening=np.where(holds.all(axis=0), needed.max(axis=0), np.nan),
        shortening=own(shortening).max(axis=0),
    )


@dataclass(frozen=True, kw_only=True, eq=False)
class _MeanBearingForces:
    """Mean forces on the bearings at places of the stroke, for any compression of the spline.

    Attributes
    ----------
    line
        How the compression bends the line.
    without_motion, by_compression : (..., n-2, 3) N, 1
        Where nothing moves, and what each N of compression adds.
    by_modes : (..., n-2, 3, N) N/m
        What the motion of each of the line's modes adds.
    """

    line: CompressedLine
    without_motion: FloatArray
    by_compression: FloatArray
    by_modes: FloatArray

    def under(self, compression: FloatArray) -> FloatArray:
        """Return the forces under a compression (...) N, (..., n-2, 3) N."""
        moved = self.line.modal_motion(compression)[..., None, :, None]
        fixed = self.without_motion + compression[..., None, None] * self.by_compression
        return fixed + (self.by_modes @ moved)[..., 0]

    def at(self, places: Callable[[Any, int], Any]) -> "_MeanBearingForces":
        """Return the same at some places, which a function takes from arrays of so many axes."""
        line = self.line
        return _MeanBearingForces(
            line=CompressedLine(
                shapes=places(line.shapes, 2),
                softening=places(line.softening, 1),
                load=places(line.load, 1),
                spline=places(line.spline, 1),
                is_stable=places(line.is_stable, 0),
            ),
            without_motion=places(self.without_motion, 2),
            by_compression=places(self.by_compression, 2),
            by_modes=places(self.by_modes, 3),
        )


def _reached_places(inputs: LineInputs, *, stroke: bool) -> BoolArray:
    """Return which states' places (S, S') each state's stroke has, its own among them.

    An axle that another torque winds up stands nowhere else.
    """
    free = np.array([kind not in _WOUND_STATES for kind in inputs.state_kinds])
    return np.eye(len(free), dtype=bool) | (stroke & free)


@dataclass(frozen=True, kw_only=True, eq=False)
class _PlacesBetween:
    """Places of an axle from that of each state to the next one with more load on its tyres.

    Attributes
    ----------
    following : (..., S)
        Index of the state there.
    exist : (..., S)
        Whether there are places between, of both states of free springs.
    slip, following_slip : (..., S) N m
        What the tyres hold at both ends; inf where unknown.
    curvature : shift (..., 1, 3), pitch (..., 1)
        Half the second derivative of an axle's motion by its rise, 1/m, rad/m^2.
    """

    following: NDArray[np.intp]
    exist: BoolArray
    slip: FloatArray
    following_slip: FloatArray
    curvature: tuple[FloatArray, FloatArray]

    def held_torque(self, share: FloatArray) -> FloatArray:
        """Return what the tyres hold at shares of the way, (K, ..., S) N m."""
        known = np.isfinite(self.following_slip)
        way = np.where(known, self.following_slip, 0.0) - np.where(known, self.slip, 0.0)
        return self.slip + share * way

    def motion(self, at_states: AxleMotion, share: FloatArray) -> AxleMotion:
        """Return how the axle has moved there, (K, ..., S), from its motion at the states."""
        lead = np.shape(at_states.pitch)
        index = np.broadcast_to(self.following, lead)

        def ends(values: ArrayLike, own: int) -> tuple[FloatArray, FloatArray]:
            here = np.broadcast_to(np.asarray(values, dtype=float), (*lead, *(3,) * own))
            at = index.reshape(*index.shape, *(1,) * own)
            return here, np.take_along_axis(here, at, axis=-1 - own)

        def blend(values: ArrayLike, own: int, bow: FloatArray | float = 0.0) -> FloatArray:
            here, there = ends(values, own)
            rise, end = ends(at_states.shift, 1)
            span = (end - rise)[..., 2].reshape(*lead, *(1,) * own)
            s = share.reshape(*share.shape, *(1,) * own)
            return here + s * (there - here) - s * (1 - s) * span**2 * bow

        shift, pitch = self.curvature
        return replace(
            at_states,
            shift=blend(at_states.shift, 1, shift),
            pitch=blend(at_states.pitch, 0, pitch),
            lead_shift=blend(at_states.lead_shift, 1),
            lead_pitch=blend(at_states.lead_pitch, 0),
        )


def _places_between(inputs: LineInputs, cases: tuple[int, ...]) -> _PlacesBetween:
    """Return the places between those of the states.

    An axle that hangs carries little, and its tyres hold no more torque than that allows; most
    is done where they just hold it all.
    """
    demand, states = inputs.demand, len(inputs.state_kinds)
    lead = (*cases, states)
    free = np.array([kind not in _WOUND_STATES for kind in inputs.state_kinds])
    here = np.broadcast_to(np.abs(demand.slip_torque), lead)
    here = np.where(np.isnan(here), np.inf, here)
    more = (here[..., None, :] > here[..., None]) & free & np.isfinite(here[..., None, :])
    others = np.where(more, here[..., None, :], np.inf)
    following = np.where(more.any(-1), others.argmin(-1), np.arange(states))
    there = np.take_along_axis(here, following, axis=-1)
    shift = np.broadcast_to(np.asarray(demand.axle_motion.shift, dtype=float), (*lead, 3))
    pitch = np.broadcast_to(np.asarray(demand.axle_motion.pitch, dtype=float), lead)
    bow = np.zeros((*cases, 1, 4))
    if free.sum() > 2:  # two places say nothing of a curve
        rise = shift[..., free, 2]
        rise = rise - rise.mean(-1, keepdims=True)
        powers = np.stack([np.ones_like(rise), rise, rise**2], axis=-1)
        moved = np.concatenate([shift[..., free, :], pitch[..., free, None]], axis=-1)
        bow = (np.linalg.pinv(powers) @ moved)[..., 2:, :]
    return _PlacesBetween(
        following=following,
        exist=more.any(-1) & free,
        slip=here,
        following_slip=there,
        curvature=(bow[..., :3], bow[..., 3]),
    )


def _largest_torques(
    inputs: LineInputs, curves: TorqueCurves
) -> tuple[FloatArray, BoolArray, BoolArray]:
    """Return the largest torque of a line ahead and astern, (2, ..., S) N m, 0 where none.

    In addition to the torque of the state itself; and where the line is then in overrun, and
    braked.
    """
    own = np.nan_to_num(inputs.demand.torque)
    each = [own[None]]
    ways = ["", *curves.directions]
    if len(ways) > 1:
        start = curves.torque[..., 0]
        held = np.copysign(np.minimum(np.abs(start), curves.torque_limit), start)
        held = np.where(np.isnan(curves.max_speed), 0.0, np.nan_to_num(held))
        each = [np.broadcast_to(own, held.shape[1:])[None], held]
    torque = np.concatenate(each)
    which = [(sign * torque).argmax(axis=0) for sign in (1.0, -1.0)]
    found = np.stack([np.take_along_axis(torque, k[None], axis=0)[0] for k in which])
    found = np.stack([np.maximum(found[0], 0.0), np.minimum(found[1], 0.0)])
    coasts, brakes = (
        np.stack([np.array([w == way for w in ways])[k] for k in which])
        for way in ("coast", "brake")
    )
    return found, coasts, brakes
