"""What the vehicle asks of one line in every state: `demand`.

Every line is seen in its own frame, x along the flow of torque. An axle moves in the
vehicle's frame; for a line that runs forward to a front axle, fore-aft motion and pitch
change sign on the way.
"""

from dataclasses import dataclass, replace
from functools import partial
from math import isnan, nan

import numpy as np

from cardan.base.arrays import ArrayLike, BoolArray, FloatArray
from cardan.base.errors import DesignError, about
from cardan.demand.axles import LineLoads, driven_axles, line_loads
from cardan.demand.motion import Ride, moved
from cardan.demand.suspension import (
    AT_LIMIT,
    OVERLOAD,
    axle_path,
    carried,
    deflection,
    natural_frequency,
    windup,
)
from cardan.demand.torque import (
    DIRECT,
    Gears,
    brake_torque,
    gears,
    governing_torque,
    low_gear_torque,
    slip_torque,
    wheel_slip_torque,
)
from cardan.model.application import Application, Installed, State
from cardan.model.layout import Layout
from cardan.model.vehicle import Linkage, Suspension, SuspensionState

__all__ = ["Demand", "demand", "moved"]


# A hanging axle counts as empty: it hangs for a moment, in a vehicle that still drives.
_LOADED_AS: dict[SuspensionState, str] = {
    "full rebound": "empty", "rebound": "empty", "curb": "curb", "empty": "empty",
    "gvw": "gvw", "overload": "gvw", "jounce": "gvw", "windup": "gvw", "windup brake": "gvw",
}  # fmt: skip

_UNKNOWN = LineLoads(
    axle=np.asarray(nan),
    rest=np.asarray(nan),
    traction=np.asarray(nan),
    coast=np.asarray(nan),
    braked=np.asarray(nan),
)


@dataclass(frozen=True, kw_only=True)
class Demand:
    """What one line has to bear, states first. What nothing given can tell is nan.

    Attributes
    ----------
    installed
        The line this is about.
    states
        Names of the S states.
    layout : (S, n, 3) m
        Where the line runs.
    given : (S, n, 3) m
        The layouts before the suspension moved them: the reference, or a state's own.
    ride : shift (S, 3) m, pitch (S,) rad, arm (3,) m
        How the suspension moves the axle; `corrected` repeats it beside other changes.
    torque : (S,) N m
        For the loads: the smaller of engine and slip torque, or as the application says.
    engine_torque, slip_torque : (S,) N m
        Of the lowest gear; at which the wheels behind this line slip.
    coast_torque : (S,) N m
        Size of the torque with which engine brake or retarder hold back, at most wheel slip.
    low_gear_torque, wheel_slip_torque : (S,) N m
        Engine and slip torque by J3311 (its efficiencies; the state's load as capacity).
    speed : (S,) rad/s
        Top speed of the line.
    travel, pitch : (S,) m, rad
        Rise of the axle and of the pinion's nose from the reference layout.
    spline_travel : (S,) m
        Length of the last shaft less its length in the reference layout.
    axle_load, driven_load : (S,) N
        Of the state's load: at rest, on the axle this line's pinion is part of; at the slip
        limit, on all wheels behind the line.
    suspension_frequency : (S,) Hz
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


def demand(application: Application, installed: Installed) -> Demand:
    """Return what the vehicle asks of one line in each of the application's states.

    Parameters
    ----------
    application
        Its vehicle, engine, suspension and the like say what is asked, unless the
        application or the state gives torque, speed or geometry itself.
    installed
        One of its lines.

    Raises
    ------
    DesignError
        If a state cannot be told from what is given: the message says what is missing.

    Notes
    -----
    Static loads on level ground place the axle; wind-up turns it where it is then. Source:
    Souza (2014), sections 2.3 and 2.4.
    """
    states = application.states
    if not states:
        msg = f"application {application.title} has no state to check"
        raise DesignError(msg, about="states")
    loads = _loads(application, installed)
    torques = _torques(application, installed, loads)
    own = [(s.layouts or {}).get(installed.line.name) for s in states]
    # A state's own layout is the truth about it, and a transfer case is held by the frame.
    free = np.array([o is None and installed.drives != "all" for o in own])
    travel, ride = _rides(application, installed, loads, torques, free=free)
    given = _given(installed, own)
    layout = _ridden(given, installed, ride)
    _bending(application, installed, layout)
    return Demand(
        installed=installed,
        states=tuple(s.name for s in states),
        layout=layout,
        given=given,
        ride=ride,
        torque=torques.torque,
        engine_torque=torques.engine,
        slip_torque=torques.slip,
        coast_torque=torques.coast,
        low_gear_torque=torques.low_gear,
        wheel_slip_torque=torques.wheel_slip,
        speed=_speed(application, installed),
        travel=np.where(free, travel, _rise(given) - _rise(installed.layout)),
        pitch=layout.side[..., -1] - installed.layout.side[-1],
        spline_travel=layout.lengths[..., -1] - installed.layout.lengths[-1],
        axle_load=loads.axle,
        driven_load=loads.traction,
        suspension_frequency=_frequency(application, installed, loads),
        gears=_gears(application, installed),
    )


def _bending(application: Application, installed: Installed, layout: Layout) -> None:
    """Refuse a state (of S in a layout) in which a joint reaches a right angle and locks."""
    d = layout.directions
    cosines = (d[..., :-1, :] * d[..., 1:, :]).sum(axis=-1)
    for s, k in np.argwhere(~(cosines > 0)):
        angle = np.degrees(np.arccos(np.clip(cosines[s, k], -1, 1)))
        msg = (
            f"joint {k + 1} of line {installed.line.name} locks in state "
            f"{application.states[s].name}: its angle must stay below 90 deg, got {angle:.4g} deg"
        )
        raise DesignError(msg, about=f"states[{s + 1}]")


def _suspension(application: Application, installed: Installed) -> Suspension | None:
    """Return what moves the line's axle; the application's springs are those of the rear."""
    if installed.suspension or installed.drives != "rear":
        return installed.suspension
    return application.suspension


def _share(installed: Installed) -> float:
    """Torque of the line over that of the gearbox output."""
    return installed.torque_ratio * (installed.axle.torque_share if installed.axle else 1.0)


def _gears(application: Application, installed: Installed) -> Gears | None:
    """Torque and speed of the line gear by gear."""
    if application.engine is None:
        return None
    return gears(
        application.engine,
        application.gearbox or DIRECT,
        torque_ratio=_share(installed),
        speed_ratio=installed.speed_ratio,
    )


def _first(*values: float | None) -> float:
    """Return the first value that is given; nan if none is."""
    return next((v for v in values if v is not None), np.nan)


def _speed(application: Application, installed: Installed) -> FloatArray:
    """Top speed of the line in each state, (S,) rad/s.

    The torque that winds an axle up is that of the lowest gear, and so is the speed.
    """
    table = _gears(application, installed)
    top = low = None
    if table is not None:
        top = table.speed.max() / installed.speed_ratio
        low = table.speed[np.argmax(table.peak)].max() / installed.speed_ratio
    given = [
        _first(s.speed, application.speed, low if s.kind == "windup" else top)
        for s in application.states
    ]
    return installed.speed_ratio * np.array(given)


def _load_name(application: Application, state: State) -> tuple[str, float]:
    """Name of the load state that counts in a state, and how many times over."""
    names = [load.name for load in application.vehicle.loads] if application.vehicle else []
    if state.load is not None and state.load not in names:
        msg = f"state {state.name} has no load state {state.load}; there are: {', '.join(names)}"
        raise DesignError(msg)
    kind = state.kind or "gvw"
    name = state.load or (kind if kind in names else _LOADED_AS[kind])
    return name, OVERLOAD if kind == "overload" and name != "overload" else 1.0


def _line_loads(application: Application, installed: Installed, state: State) -> LineLoads:
    """Return the loads that count for a line in a state; nan where none are given."""
    vehicle, tyre = application.vehicle, application.tyre
    name, times = _load_name(application, state)
    load = next((w for w in vehicle.loads if w.name == name), None) if vehicle else None
    if vehicle is None or load is None:
        return _UNKNOWN
    with about(f"drivelines.{installed.line.name}"):
        return line_loads(
            vehicle,
            load,
            drives=installed.drives,
            load_share=installed.load_share,
            friction=tyre.friction if tyre else 0.0,
            times=times,
        )


def _loads(application: Application, installed: Installed) -> LineLoads:
    """Return the loads that count for a line in each state, (S,) N."""
    each = [_line_loads(application, installed, s) for s in application.states]
    return LineLoads(
        axle=np.array([o.axle for o in each]),
        rest=np.array([o.rest for o in each]),
        traction=np.array([o.traction for o in each]),
        coast=np.array([o.coast for o in each]),
        braked=np.array([o.braked for o in each]),
    )


@dataclass(frozen=True, kw_only=True)
class _Torques:
    """Torques of a line in each state, (S,) N m, as in `Demand`."""

    torque: FloatArray
    engine: FloatArray
    slip: FloatArray
    coast: FloatArray
    low_gear: FloatArray
    wheel_slip: FloatArray


def _torques(application: Application, installed: Installed, loads: LineLoads) -> _Torques:
    """Torques of a line in each state: what is given, or the smaller of engine and slip."""
    every, share = np.ones(len(application.states)), _share(installed)
    engine = held = low_gear = slip = slip_back = wheel_slip = np.nan * every
    if application.engine:
        gearbox = application.gearbox or DIRECT
        engine = gears(application.engine, gearbox).peak.max() * share * every
        held = brake_torque(application.engine, gearbox) * share * every
        low_gear = low_gear_torque(
            max(application.engine.torque),
            ratio=max(gearbox.ratios),
            efficiency=0.85 if gearbox.converter_ratio == 1 else 0.80,
            stall_ratio=gearbox.converter_ratio,
            transfer_ratio=gearbox.transfer_ratio,
            transfer_efficiency=1.0 if gearbox.transfer_ratio == 1 else 0.95,
        ) * (share * every)
    axle, tyre = installed.axle, application.tyre
    if axle and tyre:
        grip = partial(
            slip_torque, friction=tyre.friction, radius=tyre.static_radius, ratio=axle.ratio
        )
        slip = grip(loads.traction, efficiency=axle.efficiency)
        slip_back = grip(loads.coast, efficiency=1 / axle.efficiency)
        rolling = tyre.dynamic_radius or tyre.static_radius
        wheel_slip = wheel_slip_torque(loads.rest, radius=rolling, ratio=axle.ratio)
    given = share * np.array([_first(s.torque, application.torque) for s in application.states])
    given_back = share * _first(application.coast_torque) * every
    # Nobody knows what holds back until a brake is given, not even that the tyres slip.
    back = np.where(np.isnan(held), held, governing_torque(held, slip_back))
    return _Torques(
        torque=np.where(np.isnan(given), governing_torque(engine, slip), given),
        engine=engine,
        slip=slip,
        coast=np.where(np.isnan(given_back), back, given_back),
        low_gear=low_gear,
        wheel_slip=wheel_slip,
    )


def _frequency(application: Application, installed: Installed, loads: LineLoads) -> FloatArray:
    """Natural frequency on the springs in each state, (S,) Hz; nan where there is none."""
    suspension = _suspension(application, installed)
    if suspension is None:
        return np.full(len(application.states), np.nan)
    rests = np.array([s.kind is not None and s.kind not in AT_LIMIT for s in application.states])
    load = carried(suspension, loads.axle)
    return natural_frequency(suspension.spring, np.where(rests & (load > 0), load, np.nan))


def _height(application: Application, state: State) -> object:
    """Return what places the axle in a state: states alike in it are equally high."""
    return state.kind if state.kind in AT_LIMIT else _load_name(application, state)


def _travel(application: Application, installed: Installed, state: State) -> float:
    """Rise of the axle from the reference layout in a state, m."""
    if state.travel is not None or state.kind is None:
        return state.travel or 0.0
    suspension = _suspension(application, installed)
    kind = suspension.reference if suspension else "gvw"
    reference = State(name="reference", kind=kind)
    if _height(application, state) == _height(application, reference):
        return 0.0
    if suspension is None:
        msg = (
            f"state {state.name} cannot place the {installed.drives} axle of line "
            f"{installed.line.name}: give that axle a suspension, or the state a travel"
        )
        raise DesignError(msg)
    load, reference_load = (
        float(_line_loads(application, installed, s).axle) for s in (state, reference)
    )
    return deflection(suspension, state.kind, axle_load=load) - deflection(
        suspension, kind, axle_load=reference_load
    )


def _windup(
    application: Application,
    installed: Installed,
    state: State,
    *,
    torque: float,
    coast: float,
    braked: float,
) -> float:
    """Wind-up of the line's axle in a state, rad about the vehicle's y.

    The line's torque splits between the axles it drives. Brakes and coasting together
    hold no more than the tyres do.
    """
    if state.kind not in ("windup", "windup brake"):
        return 0.0
    suspension, axle = _suspension(application, installed), installed.axle
    vehicle, tyre = application.vehicle, application.tyre
    behind = driven_axles(vehicle, drives=installed.drives) * installed.load_share if vehicle else 1
    ratio, efficiency = (axle.ratio / behind, axle.efficiency) if axle else (nan, 1.0)
    if state.kind == "windup":
        on_axle = torque * ratio * efficiency
    else:
        brakes = suspension.brake_torque if suspension else 0.0
        held = brakes + np.nan_to_num(coast * ratio / efficiency) if brakes else nan
        grip = tyre.friction * tyre.static_radius * braked if tyre else nan
        on_axle = -float(np.fmin(held, grip))
    if suspension is None or suspension.windup_stiffness is None or isnan(on_axle):
        msg = (
            f"state {state.name} of line {installed.line.name} needs a windup_stiffness, the "
            "axle's ratio and a torque (traction) or brake_torque (brake); or a pitch"
        )
        raise DesignError(msg)
    return float(windup(on_axle, stiffness=suspension.windup_stiffness))


def _rides(
    application: Application,
    installed: Installed,
    loads: LineLoads,
    torques: _Torques,
    *,
    free: BoolArray,
) -> tuple[FloatArray, Ride]:
    """Rise of the axle (S,) m, and its ride in the line's frame; none in states not `free`."""
    travel, turned, wound = np.zeros((3, len(application.states)))
    for k in np.flatnonzero(free):
        state = application.states[k]
        with about(f"states[{k + 1}]"):
            travel[k], turned[k] = _travel(application, installed, state), _first(state.pitch)
            if state.pitch is None:
                wound[k] = _windup(
                    application,
                    installed,
                    state,
                    torque=torques.torque[k],
                    coast=torques.coast[k],
                    braked=loads.braked[k],
                )
    suspension = _suspension(application, installed)
    own = f"drivelines.{installed.line.name}." if installed.suspension else ""
    with about(f"{own}suspension"):
        dx, pitch = axle_path(suspension.linkage if suspension else Linkage(), travel)
    pitch = np.where(np.isnan(turned), pitch + wound, turned)
    ahead = -1.0 if installed.drives == "front" else 1.0
    x, z = installed.axle.pinion_joint if installed.axle else (0.0, 0.0)
    shift = np.stack([ahead * dx, np.zeros_like(dx), travel], axis=-1)
    return travel, Ride(shift=shift, pitch=ahead * pitch, arm=(x, 0.0, z))


def _given(installed: Installed, own: list[Layout | None]) -> Layout:
    """Layouts (S, n, 3) before anything moves: a state's own, or the reference."""
    layouts = [o or installed.layout for o in own]
    shapes = {o.points.shape for o in layouts}
    if shapes != {installed.layout.points.shape}:
        msg = (
            f"line {installed.line.name} has {installed.line.joint_count} joints in every "
            "state; a state gives it another number"
        )
        raise DesignError(msg)
    return Layout(
        points=np.stack([o.points for o in layouts]),
        directions=np.stack([o.directions for o in layouts]),
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
        first=None if first is None else replace(ride, arm=(first[0], 0.0, first[1])),
    )
