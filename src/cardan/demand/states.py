"""What the vehicle asks of one line in every state: `demand`.

Every line is seen in its own frame, x along the flow of torque. An axle moves in the
vehicle's frame; for a line that runs forward to a front axle, fore-aft motion and pitch
change sign on the way.

All of it is array code: the states are the last leading axis, the variants of a study,
whose numbers come as (V, 1), the one before it.
"""

from collections.abc import Iterable
from dataclasses import dataclass, fields, replace
from functools import partial

import numpy as np

from cardan.base.arrays import ArrayLike, BoolArray, FloatArray, stacked
from cardan.base.errors import DesignError, about
from cardan.demand.axles import LineLoads, driven_axles, line_loads
from cardan.demand.line import Loading, ResolvedLine, height, resolve
from cardan.demand.motion import Ride, moved
from cardan.demand.suspension import (
    AT_LIMIT,
    axle_path,
    carried,
    deflection,
    natural_frequency,
    windup,
)
from cardan.demand.torque import (
    Gears,
    brake_torque,
    governing_torque,
    low_gear_torque,
    slip_torque,
    wheel_slip_torque,
)
from cardan.model.application import Installed, State
from cardan.model.layout import Layout
from cardan.model.vehicle import Linkage

__all__ = ["Demand", "ResolvedLine", "demand", "moved", "resolve"]


@dataclass(frozen=True, kw_only=True, eq=False)
class Demand:
    """What one line has to bear, (variants ..., states). What nothing given can tell is nan.

    Attributes
    ----------
    installed
        The line this is about.
    states
        Names of the S states.
    layout : (..., S, n, 3) m
        Where the line runs.
    given : (..., S, n, 3) m
        The layouts before the suspension moved them: the reference, or a state's own.
    ride : shift (..., S, 3) m, pitch (..., S) rad, arm (..., 3) m
        How the suspension moves the axle; `corrected` repeats it beside other changes.
    torque : (..., S) N m
        For the loads: the smaller of engine and slip torque, or as the application says.
        Negative where the line holds back: in brake wind-up it carries the coast torque.
    engine_torque, slip_torque : (..., S) N m
        Of the lowest gear; at which the wheels behind this line slip.
    coast_torque : (..., S) N m
        Size of the torque with which engine brake or retarder hold back, at most wheel slip.
    low_gear_torque, wheel_slip_torque : (..., S) N m
        Engine and slip torque by J3311 (its efficiencies; the state's load as capacity).
    speed : (..., S) rad/s
        Top speed of the line.
    travel, pitch : (..., S) m, rad
        Rise of the axle and of the pinion's nose from the reference layout.
    spline_travel : (..., S) m
        Length of the last shaft less its length in the reference layout.
    axle_load, driven_load : (..., S) N
        Of the state's load: at rest, on the axle this line's pinion is part of; at the slip
        limit, on all wheels behind the line.
    suspension_frequency : (..., S) Hz
        nan in states that are no equilibrium: rebound and jounce.
    gears
        Torque and speed of the line gear by gear; None without an engine.
    """

    installed: Installed
    states: tuple[str, ...]
    layout: Layout
    given: Layout
    ride: Ride
    torque: FloatArray
    engine_torque: FloatArray
    slip_torque: FloatArray
    coast_torque: FloatArray
    low_gear_torque: FloatArray
    wheel_slip_torque: FloatArray
    speed: FloatArray
    travel: FloatArray
    pitch: FloatArray
    spline_travel: FloatArray
    axle_load: FloatArray
    driven_load: FloatArray
    suspension_frequency: FloatArray
    gears: Gears | None

    def corrected(self, *, bearing_shift: ArrayLike = 0.0, shim: ArrayLike = 0.0) -> Layout:
        """Return the layout in every state with bearings moved and the pinion shimmed.

        Parameters
        ----------
        bearing_shift : (..., n-2, 3) m
            Of each centre bearing; of the axes before, the last is that of the states:
            V variants alike in every state are (V, 1, n-2, 3).
        shim : (...) rad
            Turn of the axle on its springs, the pinion's nose rising; (V, 1) for variants.

        Returns
        -------
        Layout
            (..., S, n, 3).
        """
        return _ridden(
            self.given, self.installed, self.ride, bearing_shift=bearing_shift, shim=shim
        )


def demand(line: ResolvedLine) -> Demand:
    """Return what the vehicle asks of a line in each of its states.

    Raises
    ------
    DesignError
        If a state cannot be told from what is given: the message says what is missing.

    Notes
    -----
    Static loads on level ground place the axle; wind-up turns it where it is then. Source:
    Souza (2014), sections 2.3 and 2.4.
    """
    each = _each_loading(line)
    loads = _of_states(each[loading.key] for loading in line.loadings)
    torques = _torques(line, loads)
    travel = _travel(line, {key: found.axle for key, found in each.items()})
    ride = _ride(line, travel, torque=torques["torque"], braked=loads.braked)
    given, installed = _given(line), line.installed
    layout = _ridden(given, installed, ride)
    _bending(line, layout)
    asked = torques | {
        "speed": _speed(line),
        "travel": np.where(line.free, travel, _rise(given) - _rise(installed.layout)),
        "pitch": layout.side[..., -1] - installed.layout.side[..., -1],
        "spline_travel": layout.lengths[..., -1] - installed.layout.lengths[..., -1],
        "axle_load": loads.axle,
        "driven_load": loads.traction,
        "suspension_frequency": _frequency(line, loads),
    }
    cases = np.broadcast_shapes(layout.points.shape[:-2], *(v.shape for v in asked.values()))
    return Demand(
        installed=installed,
        states=tuple(s.name for s in line.states),
        layout=Layout(
            points=np.broadcast_to(layout.points, (*cases, *layout.points.shape[-2:])),
            directions=np.broadcast_to(layout.directions, (*cases, *layout.directions.shape[-2:])),
        ),
        given=given,
        ride=ride,
        gears=line.gears,
        **{name: np.broadcast_to(value, cases) for name, value in asked.items()},
    )


def _by_state(values: Iterable[ArrayLike | None]) -> FloatArray:
    """Return numbers of the states one by one, (..., 1) each, as (..., S); None is nan."""
    columns = [np.atleast_1d(np.asarray(v, dtype=float)) for v in values]
    return np.concatenate(np.broadcast_arrays(*columns), axis=-1)


def _bending(line: ResolvedLine, layout: Layout) -> None:
    """Refuse a state of a layout (..., S) in which a joint reaches a right angle and locks."""
    d = layout.directions
    cosines = (d[..., :-1, :] * d[..., 1:, :]).sum(axis=-1)
    for *_, s, k in np.argwhere(~(cosines > 0)):
        angle = np.degrees(np.arccos(np.clip(cosines[..., s, k].min(), -1, 1)))
        msg = (
            f"joint {k + 1} of line {line.line.name} locks in state "
            f"{line.states[s].name}: its angle must stay below 90 deg, got {angle:.4g} deg"
        )
        raise DesignError(msg, about=f"states[{s + 1}]")


def _first(*values: ArrayLike | None) -> ArrayLike | None:
    """Return the first value that is given."""
    return next((v for v in values if v is not None), None)


# --------------------------------------------------------------------------- loads


def _each_loading(line: ResolvedLine) -> dict[tuple[str, float], LineLoads]:
    """Return the loads that a line feels under each loading of the vehicle, by its key."""
    every = {loading.key: loading for loading in (*line.loadings, line.reference_loading)}
    return {key: _line_loads(line, loading) for key, loading in every.items()}


def _line_loads(line: ResolvedLine, loading: Loading) -> LineLoads:
    """Return the loads that a line feels under a loading, (...) N; nan where none is given."""
    if line.vehicle is None or loading.load is None:
        return LineLoads(**dict.fromkeys((f.name for f in fields(LineLoads)), np.asarray(np.nan)))
    with about(f"drivelines.{line.line.name}"):
        return line_loads(
            line.vehicle,
            loading.load,
            drives=line.installed.drives,
            load_share=line.installed.load_share,
            friction=line.tyre.friction if line.tyre else 0.0,
            times=loading.times,
        )


def _of_states(each: Iterable[LineLoads]) -> LineLoads:
    """Return the loads of the states one by one as loads (..., S) of all of them."""
    loads = list(each)
    return LineLoads(
        **{f.name: _by_state(getattr(o, f.name) for o in loads) for f in fields(LineLoads)}
    )


# --------------------------------------------------------------------------- torque and speed


def _torques(line: ResolvedLine, loads: LineLoads) -> dict[str, FloatArray]:
    """Return the torques of `Demand`, by name: as given, or the smaller of engine and slip."""
    engine, held, low_gear = _engine_torques(line)
    slip = slip_back = wheel_slip = np.asarray(np.nan)
    axle, tyre = line.axle, line.tyre
    if axle and tyre:
        grip = partial(
            slip_torque, friction=tyre.friction, radius=tyre.static_radius, ratio=axle.ratio
        )
        slip = grip(loads.traction, efficiency=axle.efficiency)
        slip_back = grip(loads.coast, efficiency=1 / axle.efficiency)
        rolling = tyre.static_radius if tyre.dynamic_radius is None else tyre.dynamic_radius
        wheel_slip = wheel_slip_torque(loads.rest, radius=rolling, ratio=axle.ratio)
    own = line.share * _by_state(s.torque for s in line.states)
    given = line.share * _by_state(_first(s.torque, line.torque) for s in line.states)
    drive = np.where(np.isnan(given), governing_torque(engine, slip), given)
    # Nobody knows what holds back until a brake is given, not even that the tyres slip.
    back = np.where(np.isnan(held), held, governing_torque(held, slip_back))
    given_back = line.share * np.asarray(_first(line.coast_torque), dtype=float)
    coast = np.where(np.isnan(given_back), back, given_back)
    # From 0, so that no torque at all is not a negative zero.
    coasting = 0.0 - np.where(np.isnan(own), coast, own)
    return {
        "torque": np.where(line.winds("windup brake"), coasting, drive),
        "engine_torque": engine,
        "slip_torque": slip,
        "coast_torque": coast,
        "low_gear_torque": low_gear,
        "wheel_slip_torque": wheel_slip,
    }


def _engine_torques(line: ResolvedLine) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return the line's engine torque, brake torque, and low gear torque by J3311, (...) N m."""
    engine, gearbox = line.engine, line.gearbox
    if engine is None or line.gears is None:
        return np.asarray(np.nan), np.asarray(np.nan), np.asarray(np.nan)
    low = np.asarray(gearbox.transfer_ratio)
    by_j3311 = low_gear_torque(
        stacked(engine.torque).max(-1),
        ratio=stacked(gearbox.ratios).max(-1),
        efficiency=np.where(np.asarray(gearbox.converter_ratio) == 1, 0.85, 0.80),
        stall_ratio=gearbox.converter_ratio,
        transfer_ratio=low,
        transfer_efficiency=np.where(low == 1, 1.0, 0.95),
    )
    strongest, _ = line.gears.strongest
    return strongest, line.share * brake_torque(engine, gearbox), line.share * by_j3311


def _speed(line: ResolvedLine) -> FloatArray:
    """Top speed of the line in each state, (..., S) rad/s.

    The torque that winds an axle up is that of the lowest gear, and so is the speed.
    """
    ratio = np.asarray(line.installed.speed_ratio, dtype=float)
    if line.gears is None:
        return ratio * _by_state(_first(s.speed, line.speed) for s in line.states)
    # A top speed is none of the gear that winds the axle up.
    wound = line.winds("windup")
    given = ratio * _by_state(
        _first(s.speed, None if low else line.speed)
        for s, low in zip(line.states, wound, strict=True)
    )
    _, low = line.gears.strongest
    return np.where(np.isnan(given), np.where(wound, low, line.gears.top_speed), given)


# --------------------------------------------------------------------------- places


def _travel(line: ResolvedLine, axle_loads: dict[tuple[str, float], FloatArray]) -> FloatArray:
    """Rise of the axle from the reference layout in each state, (..., S) m; 0 where held."""
    at_rest = height(line.reference, line.reference_loading)

    def rise(state: State, loading: Loading, *, free: bool) -> ArrayLike:
        if not free or state.kind is None or state.travel is not None:
            return state.travel if free and state.travel is not None else 0.0
        if height(state, loading) == at_rest:
            return 0.0
        if line.suspension is None:
            msg = (
                f"state {state.name} cannot place the {line.installed.drives} axle of line "
                f"{line.line.name}: give that axle a suspension, or the state a travel"
            )
            raise DesignError(msg)
        start = axle_loads[line.reference_loading.key]
        reference = deflection(line.suspension, line.suspension.reference, axle_load=start)
        load = axle_loads[loading.key]
        return deflection(line.suspension, state.kind, axle_load=load) - reference

    risen: list[ArrayLike] = []
    for k, (s, loading) in enumerate(zip(line.states, line.loadings, strict=True)):
        with about(f"states[{k + 1}]"):
            risen.append(rise(s, loading, free=bool(line.free[k])))
    return _by_state(risen)


def _ride(
    line: ResolvedLine, travel: FloatArray, *, torque: FloatArray, braked: FloatArray
) -> Ride:
    """Ride of the axle in the line's frame, (..., S); none in states that are not free."""
    free, states = line.free, line.states
    own = f"drivelines.{line.line.name}." if line.installed.suspension else ""
    with about(f"{own}suspension"):
        dx, pitch = axle_path(line.suspension.linkage if line.suspension else Linkage(), travel)
    turned = _by_state(s.pitch if f else 0.0 for s, f in zip(states, free, strict=True))
    asks = free & np.array([s.pitch is None for s in states])
    wound = _windup(line, torque=torque, braked=braked, asks=asks)
    pitch = np.where(asks, pitch + wound, turned)
    ahead = -1.0 if line.installed.drives == "front" else 1.0
    x, z = line.axle.pinion_joint if line.axle else (0.0, 0.0)
    return Ride(
        shift=stacked((ahead * dx, 0.0, travel)), pitch=ahead * pitch, arm=stacked((x, 0.0, z))
    )


def _windup(
    line: ResolvedLine, *, torque: FloatArray, braked: FloatArray, asks: BoolArray
) -> FloatArray:
    """Wind-up of the axle, (..., S) rad about the vehicle's y, in wind-up states that ask.

    The line's torque splits between the axles it drives. Brakes and coasting together
    hold no more than the tyres do.
    """
    driven, braking = (line.winds(kind) & asks for kind in ("windup", "windup brake"))
    if not (driven | braking).any():
        return np.zeros(asks.shape)
    suspension, axle, tyre, vehicle = line.suspension, line.axle, line.tyre, line.vehicle
    behind = 1.0
    if vehicle:
        # How many axles stand behind the line; how they share their load is no matter of it.
        axles = driven_axles(vehicle, drives=line.installed.drives)
        behind = np.maximum(np.round(line.installed.load_share * axles), 1.0)
    ratio, efficiency = (axle.ratio / behind, axle.efficiency) if axle else (np.nan, 1.0)
    brakes = np.asarray(suspension.brake_torque if suspension else 0.0)
    held = np.where(brakes > 0, brakes + np.nan_to_num(-torque * ratio / efficiency), np.nan)
    grip = tyre.friction * tyre.static_radius * braked if tyre else np.nan
    on_axle = np.where(driven, torque * ratio * efficiency, -np.fmin(held, grip))
    stiffness = suspension.windup_stiffness if suspension else None
    unknown = np.isnan(on_axle) if stiffness is not None else np.ones(on_axle.shape, dtype=bool)
    for k in np.flatnonzero(driven | braking):
        if unknown[..., k].any():
            msg = (
                f"state {line.states[k].name} of line {line.line.name} needs a windup_stiffness, "
                "the axle's ratio and a torque (traction) or brake_torque (brake); or a pitch"
            )
            raise DesignError(msg, about=f"states[{k + 1}]")
    assert stiffness is not None  # else all was unknown
    return np.where(driven | braking, windup(on_axle, stiffness=stiffness), 0.0)


def _frequency(line: ResolvedLine, loads: LineLoads) -> FloatArray:
    """Natural frequency on the springs in each state, (..., S) Hz; nan where there is none."""
    if line.suspension is None:
        return np.full(len(line.states), np.nan)
    rests = np.array([s.kind is not None and s.kind not in AT_LIMIT for s in line.states])
    load = carried(line.suspension, loads.axle)
    return natural_frequency(line.suspension.spring, np.where(rests & (load > 0), load, np.nan))


def _given(line: ResolvedLine) -> Layout:
    """Layouts (..., S, n, 3) before anything moves: a state's own, or the reference."""
    layouts = [o or line.installed.layout for o in line.own]

    def side_by_side(vectors: list[FloatArray]) -> FloatArray:
        each = [v if v.ndim > 2 else v[None] for v in vectors]
        return np.concatenate(np.broadcast_arrays(*each), axis=-3)

    return Layout(
        points=side_by_side([o.points for o in layouts]),
        directions=side_by_side([o.directions for o in layouts]),
    )


def _rise(layout: Layout) -> FloatArray:
    """Height of the last joint above the first, (...) m."""
    return layout.points[..., -1, 2] - layout.points[..., 0, 2]


def _ridden(
    given: Layout,
    installed: Installed,
    ride: Ride,
    *,
    bearing_shift: ArrayLike = 0.0,
    shim: ArrayLike = 0.0,
) -> Layout:
    """Layout with its axle ridden and, where joint 1 leaves an axle, that one likewise."""
    first = installed.output_joint
    return moved(
        given,
        installed.line,
        bearing_shift=bearing_shift,
        last_shift=ride.shift,
        pinion_pitch=np.asarray(ride.pitch) + np.asarray(shim),
        pinion_arm=ride.arm,
        first=None if first is None else replace(ride, arm=stacked((first[0], 0.0, first[1]))),
    )
