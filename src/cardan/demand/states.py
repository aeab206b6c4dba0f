"""What the vehicle asks of one line in every state: `demand`, and `demand_under` other torques.

Every line is seen in its own frame, x along the flow of torque. An axle moves fore and aft,
and is wound up, in the vehicle's frame; for a line that runs forward, to a front axle, both
change sign on the way. Pitch that is given is of the pinion's nose, and so the line's own.

All of it is array code: the states are the last leading axis, the variants of a study,
whose numbers come as (V, 1), the one before it.
"""

from collections.abc import Callable, Iterable, Iterator
from dataclasses import fields, replace
from functools import partial

import numpy as np

from cardan.base.arrays import ArrayLike, BoolArray, FloatArray, apart, stacked
from cardan.base.errors import DesignError, about
from cardan.base.frozen import dataclass
from cardan.base.units import Metre, g
from cardan.demand.axles import LineLoads, axle_by_axle, axle_loads, driven_axles, line_loads
from cardan.demand.line import Loading, ResolvedLine, height, resolve
from cardan.demand.motion import Ride, moved
from cardan.demand.suspension import (
    AT_LIMIT,
    axle_path,
    carried,
    deflection,
    natural_frequency,
    squat,
    tyre_load,
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
from cardan.model.vehicle import Linkage, SuspensionState

__all__ = [
    "Demand",
    "ResolvedLine",
    "Standing",
    "demand",
    "demand_ridden",
    "demand_under",
    "each_axle_load",
    "moved",
    "on_axle_under",
    "resolve",
    "ride_under",
    "said_speed",
]


@dataclass(frozen=True, kw_only=True, eq=False)
class Standing:
    """A line in its states before any torque moves its axle: what all its points share.

    Attributes
    ----------
    line
        The line.
    loads : (..., S) N
        What it feels of the vehicle's weight.
    ride : shift (..., S, 3) m, pitch (..., S) rad, arm (..., 3) m
        Where the springs have the axle.
    stands : (..., S) m
        Deflection of its springs; nan where nobody knows it.
    yields : (S,)
        Where torque winds it up: the suspension places it, and nobody gives its pitch.
    squats : (S,)
        Where what the tyres pull moves it on its springs: these carry its load.
    slip, slip_back, slip_reverse : (..., S) N m
        Torques at which the wheels slip as the line drives them, holds them back, and drives
        them in reverse; nan where nobody knows.
    """

    line: ResolvedLine
    loads: LineLoads
    ride: Ride
    stands: FloatArray
    yields: BoolArray
    squats: BoolArray
    slip: FloatArray
    slip_back: FloatArray
    slip_reverse: FloatArray

    def under(
        self, torque: FloatArray, *, coasts: ArrayLike = False, brakes: ArrayLike = False
    ) -> Ride:
        """Return the ride under torques of the line (..., S) N m, as `demand_under` has it.

        Where nobody knows what one does the axle stays.
        """
        on_axle = _on_axle(
            self.line, torque, braked=self.loads.braked, coasts=coasts, brakes=brakes
        )
        travel = np.asarray(self.ride.shift)[..., 2]
        if self.squats.any():
            travel = self._squatting(on_axle, brakes=brakes)
        return self.at(on_axle, travel)

    def at(self, on_axle: FloatArray, travel: FloatArray) -> Ride:
        """Return the ride with torques on the axle's housing (..., S) N m, risen to (..., S) m."""
        ride = self.ride
        if self.squats.any():
            assert self.line.suspension is not None
            dx, pitch = axle_path(self.line.suspension.linkage, travel)
            moved = stacked((self.line.ahead * dx, 0.0, travel))
            ride = replace(
                ride,
                shift=np.where(self.squats[..., None], moved, ride.shift),
                pitch=np.where(self.squats & self.yields, pitch, ride.pitch),
            )
        wound = np.asarray(ride.pitch) + self.line.ahead * np.asarray(_pitch(self.line, on_axle))
        stays = ~self.yields | np.isnan(wound)
        return replace(ride, pitch=np.where(stays, ride.pitch, wound))

    def _squatting(self, on_axle: FloatArray, *, brakes: ArrayLike) -> FloatArray:
        """Return how high the axle is (..., S) m as springs hold what the tyres pull."""
        line, loads = self.line, self.loads
        assert line.suspension is not None
        assert line.tyre is not None  # or it squats nowhere
        pulls = on_axle / line.tyre.static_radius
        driven = np.clip(
            loads.lever * pulls * _axles_behind(line) / line.push_share,
            np.minimum(loads.drawn, loads.drawn_back),
            np.maximum(loads.drawn, loads.drawn_back),
        )
        with np.errstate(divide="ignore", invalid="ignore"):
            braked = -pulls / (line.tyre.friction * loads.braked) * loads.drawn_braked
        moved = np.where(brakes, braked, driven) + loads.slope
        known = self.squats & np.isfinite(moved)
        pulled = np.where(known, on_axle, 0.0)
        rest = np.asarray(self.ride.shift)[..., 2]
        risen = squat(
            line.suspension,
            rest,
            axle_load=np.where(self.squats, loads.axle, line.suspension.unsprung_mass * g),
            drawn=np.where(known, moved, 0.0),
            force=pulled / line.tyre.static_radius,
            torque=pulled,
            ahead=line.ahead,
            stands=self.stands,
        )
        return rest + np.where(known, risen, 0.0)


@dataclass(frozen=True, kw_only=True, eq=False)
class Demand:
    """What one line has to bear, (variants ..., states). What nothing given can tell is nan.

    `demand_under` torques of its own the points come before all other axes, so that numbers
    of the line, which come as (V, 1), stand beside both.

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
        Top speed of the line, its size.
    sense : (..., S) 1
        Which way that is: -1 where the line turns backwards.
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
    standing
        Where it stands before torque winds its axle up.
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
    sense: FloatArray
    travel: FloatArray
    pitch: FloatArray
    spline_travel: FloatArray
    axle_load: FloatArray
    driven_load: FloatArray
    suspension_frequency: FloatArray
    gears: Gears | None
    standing: Standing

    @property
    def turning(self) -> FloatArray:
        """The speed with its sign, (..., S) rad/s."""
        return self.sense * self.speed

    def corrected(
        self,
        *,
        bearing_shift: ArrayLike = 0.0,
        shim: ArrayLike = 0.0,
        shim_ahead: ArrayLike = 0.0,
    ) -> Layout:
        """Return the layout in every state with bearings moved and the pinion shimmed.

        Parameters
        ----------
        bearing_shift : (..., n-2, 3) m
            Of each centre bearing; of the axes before, the last is that of the states:
            V variants alike in every state are (V, 1, n-2, 3).
        shim : (...) rad
            Turn of the axle on its springs, the pinion's nose rising; (V, 1) for variants.
        shim_ahead : (...) rad
            The same of the axle that the line leaves, if it leaves one.

        Returns
        -------
        Layout
            (..., S, n, 3).
        """
        return _ridden(
            self.given, self.installed, self.ride, bearing_shift=bearing_shift, shim=shim,
            shim_ahead=shim_ahead,
        )  # fmt: skip


def demand(line: ResolvedLine) -> Demand:
    """Return what the vehicle asks of a line in each of its states.

    Raises
    ------
    DesignError
        If a state cannot be told from what is given: the message says what is missing.

    Notes
    -----
    Static loads on level ground place the axle; wind-up turns it where it is then. Where travel
    ends the spring says what the tyres carry, and so what they hold. Source: Souza (2014),
    sections 2.3 and 2.4; the loads where travel ends are derived.
    """
    each = _each_loading(line)
    axle_loads = {key: found.axle for key, found in each.items()}
    travel = _travel(line, axle_loads)
    loads = _at_limits(line, _of_states(each[loading.key] for loading in line.loadings))
    torques = _torques(line, loads)
    stands = _stands(line, travel, reference=axle_loads[line.reference_loading.key])
    standing = _standing(line, travel, loads, stands=stands)
    ride = _own_windup(standing, torques["torque"])
    given, installed = _given(line), line.installed
    asked = torques | {
        "speed": _speed(line),
        "sense": np.ones(()),
        "travel": np.where(
            line.free, np.asarray(ride.shift)[..., 2], _rise(given) - _rise(installed.layout)
        ),
        "axle_load": loads.axle,
        "driven_load": loads.traction,
        "suspension_frequency": _frequency(line, loads),
    }
    return _demand(standing, given, ride, asked)


def demand_under(
    asked: Demand,
    *,
    torque: ArrayLike,
    speed: ArrayLike,
    sense: ArrayLike = 1.0,
    coasts: ArrayLike = False,
    brakes: ArrayLike = False,
    named: Callable[[tuple[int, ...]], str] = str,
) -> Demand:
    """Return what a line has to bear at P points, its axle moved by each point's torque.

    Parameters
    ----------
    asked
        The line in its states.
    torque, speed : (P, ..., S) N m, rad/s
        Of the points; where a torque is nan there is no point, and the layout is the state's.
    sense : (P, ..., S) 1
        -1 where the line turns backwards: the speed is a size.
    coasts, brakes : (P, ..., S)
        Where the wheels turn the line, and where brakes hold the axle as well.
    named
        Names the point of an index (P, ..., S), for errors.

    Returns
    -------
    Demand
        (P, ..., S). Loads and slip torques are those of the states.

    Raises
    ------
    DesignError
        If a joint reaches a right angle at a point: it has no answer, and to leave the point
        out would approve what nobody looked at.

    Notes
    -----
    The axle pitches by its torque over `windup_stiffness`, in any state in which the
    suspension places it and nobody gives its pitch; without a stiffness it stays. Where
    springs hold it, it squats by what its tyres pull (`cardan.demand.suspension.squat`).
    """
    T = np.asarray(torque, dtype=float)
    return demand_ridden(
        asked,
        ride_under(asked, T, coasts=coasts, brakes=brakes),
        torque=T,
        speed=np.where(np.isnan(T), np.nan, speed),
        sense=sense,
        named=named,
    )


def ride_under(
    asked: Demand, torque: FloatArray, *, coasts: ArrayLike = False, brakes: ArrayLike = False
) -> Ride:
    """Return how the axle rides under torques of its own (P, ..., S), as `demand_under`."""
    found = asked.standing.under(torque, coasts=coasts, brakes=brakes)
    none, own = np.isnan(torque), asked.ride
    return replace(
        found,
        pitch=np.where(none, own.pitch, found.pitch),
        shift=np.where(none[..., None], own.shift, found.shift)
        if asked.standing.squats.any() else own.shift,
    )  # fmt: skip


def on_axle_under(
    asked: Demand, torque: FloatArray, *, coasts: ArrayLike = False, brakes: ArrayLike = False
) -> FloatArray:
    """Return the torque on the axle's housing, (P, ..., S) N m; nan where nobody knows it."""
    of = asked.standing
    return _on_axle(of.line, torque, braked=of.loads.braked, coasts=coasts, brakes=brakes)


def demand_ridden(
    asked: Demand,
    ride: Ride,
    *,
    torque: FloatArray,
    speed: FloatArray,
    sense: ArrayLike = 1.0,
    named: Callable[[tuple[int, ...]], str] = str,
) -> Demand:
    """Return the demand of a torque and a speed with the axle ridden somewhere, (P, ..., S).

    See `demand_under`, which knows where a torque has it.
    """
    same = (
        "engine_torque", "slip_torque", "coast_torque", "low_gear_torque", "wheel_slip_torque",
        "axle_load", "driven_load", "suspension_frequency",
    )  # fmt: skip
    numbers = {name: getattr(asked, name) for name in same}
    numbers |= {"torque": torque, "speed": speed, "sense": np.asarray(sense, dtype=float)}
    risen = np.asarray(ride.shift)[..., 2] - np.asarray(asked.ride.shift)[..., 2]
    numbers["travel"] = asked.travel + risen
    return _demand(asked.standing, asked.given, ride, numbers, named=named)


def _demand(
    standing: Standing,
    given: Layout,
    ride: Ride,
    asked: dict[str, FloatArray],
    *,
    named: Callable[[tuple[int, ...]], str] | None = None,
) -> Demand:
    """Return what a line has to bear where its axle rides: some numbers, and what follows."""
    line, installed = standing.line, standing.line.installed
    layout = _ridden(given, installed, ride)
    _bending(line, layout, named)
    asked = asked | {
        "pitch": layout.side[..., -1] - installed.layout.side[..., -1],
        "spline_travel": layout.lengths[..., -1] - installed.layout.lengths[..., -1],
    }
    cases = np.broadcast_shapes(layout.points.shape[:-2], *(v.shape for v in asked.values()))
    return Demand(
        installed=installed,
        standing=standing,
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


def _bending(
    line: ResolvedLine, layout: Layout, named: Callable[[tuple[int, ...]], str] | None
) -> None:
    """Refuse a layout (..., S) in which a joint reaches a right angle and locks."""
    d = layout.directions
    cosines = (d[..., :-1, :] * d[..., 1:, :]).sum(axis=-1)
    for *case, s, k in np.argwhere(~(cosines > 0)).tolist():
        worst = cosines[..., s, k].min() if named is None else cosines[(*case, s, k)]
        angle = np.degrees(np.arccos(np.clip(worst, -1, 1)))
        where = "" if named is None else f", {named((*case, s))}"
        msg = (
            f"joint {k + 1} of line {line.line.name} locks in state "
            f"{line.states[s].name}{where}: its angle must stay below 90 deg, got {angle:.4g} deg"
        )
        raise DesignError(msg, about=f"states[{s + 1}]")


def _first(*values: ArrayLike | None) -> ArrayLike | None:
    """Return the first value that is given."""
    return next((v for v in values if v is not None), None)


# --------------------------------------------------------------------------- loads


def each_axle_load(line: ResolvedLine) -> tuple[FloatArray, FloatArray]:
    """Return the load of every axle of the vehicle in each state, at rest and at slip.

    Returns
    -------
    (..., S, axles) N twice
        In the order of `cardan.demand.axles.each_axle`; nan where a state's load is not given,
        no axles at all without a vehicle.
    """
    vehicle = line.vehicle
    if vehicle is None:
        none = np.zeros((len(line.states), 0))
        return none, none
    friction = line.tyre.friction if line.tyre else 0.0
    unknown = np.full((1, vehicle.axle_count), np.nan)
    found = [
        (unknown, unknown)
        if loading.load is None
        else axle_by_axle(vehicle, loading.load, friction=friction, times=loading.times)
        for loading in line.loadings
    ]
    return _side_by_side(rest for rest, _ in found), _side_by_side(slip for _, slip in found)


def _side_by_side(each: Iterable[FloatArray]) -> FloatArray:
    """Return loads of the states one by one, (..., 1, A) or (A,), as (..., S, A).

    A state without an axle that others let down has nan for it.
    """
    rows = [row if row.ndim > 1 else row[None] for row in each]
    most = max(row.shape[-1] for row in rows)
    rows = [
        np.concatenate([row, np.full((*row.shape[:-1], most - row.shape[-1]), np.nan)], axis=-1)
        for row in rows
    ]
    return np.concatenate(np.broadcast_arrays(*rows), axis=-2)


def _each_loading(line: ResolvedLine) -> dict[tuple[str, float], LineLoads]:
    """Return the loads that a line feels under each loading of the vehicle, by its key."""
    every = {loading.key: loading for loading in (*line.loadings, line.reference_loading)}
    return {key: _line_loads(line, loading) for key, loading in every.items()}


def _line_loads(line: ResolvedLine, loading: Loading) -> LineLoads:
    """Return the loads that a line feels under a loading, (...) N; nan where none is given."""
    if line.vehicle is None or loading.load is None:
        return LineLoads(**dict.fromkeys((f.name for f in fields(LineLoads)), np.asarray(np.nan)))
    with about(f"vehicle.loads.{loading.load.name}"):
        axle_loads(line.vehicle, loading.load)  # refuses what cannot stand
    with about(f"drivelines.{line.line.name}"):
        return line_loads(
            line.vehicle,
            loading.load,
            drives=line.installed.drives,
            load_share=line.installed.load_share,
            push_share=line.push_share,
            friction=line.tyre.friction if line.tyre else 0.0,
            times=loading.times,
        )


def _of_states(each: Iterable[LineLoads]) -> LineLoads:
    """Return the loads of the states one by one as loads (..., S) of all of them."""
    loads = list(each)
    return LineLoads(
        **{f.name: _by_state(getattr(o, f.name) for o in loads) for f in fields(LineLoads)}
    )


def _at_limits(line: ResolvedLine, loads: LineLoads) -> LineLoads:
    """Return the loads (..., S), in states where travel ends those that the springs carry there.

    Whatever brought the axle there, traction too, is in them. What a bump stop bears beside the
    spring nobody knows. A load that a state names is what it has.
    """
    suspension, vehicle = line.suspension, line.vehicle
    if suspension is None or vehicle is None:
        return loads
    kinds: list[SuspensionState | None] = [
        s.kind if free and s.kind in AT_LIMIT and s.load is None and s.travel is None else None
        for s, free in zip(line.states, line.free, strict=True)
    ]
    if not any(kinds):
        return loads
    drives, part = line.installed.drives, line.installed.load_share
    behind = np.asarray(part) * driven_axles(vehicle, drives=drives)
    borne = _by_state(np.nan if k is None else tyre_load(suspension, k) for k in kinds)
    held = np.array([k is not None for k in kinds])
    changed = {name: np.where(held, borne, getattr(loads, name)) for name in ("axle", "braked")}
    changed |= {
        name: np.where(held, behind * borne, getattr(loads, name)) for name in ("traction", "coast")
    }
    return replace(loads, **changed)


# --------------------------------------------------------------------------- torque and speed


def _torques(line: ResolvedLine, loads: LineLoads) -> dict[str, FloatArray]:
    """Return the torques of `Demand`, by name: as given, or the smaller of engine and slip."""
    engine, held, low_gear = _engine_torques(line)
    slip, slip_back, _ = _slips(line, loads)
    wheel_slip = np.asarray(np.nan)
    axle, tyre = line.axle, line.tyre
    if axle and tyre:
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


def _slips(line: ResolvedLine, loads: LineLoads) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return the line's torque at which its wheels slip: in drive, coast and reverse, (...) N m.

    Driven in reverse the wheels push as they do in coast, and load moves off the rear axle
    alike; but power runs to them as in drive.
    """
    axle, tyre = line.axle, line.tyre
    if not (axle and tyre):
        unknown = np.asarray(np.nan)
        return unknown, unknown, unknown
    grip = partial(slip_torque, friction=tyre.friction, radius=tyre.static_radius, ratio=axle.ratio)
    return (
        grip(loads.traction, efficiency=axle.efficiency),
        grip(loads.coast, efficiency=1 / axle.efficiency),
        grip(loads.coast, efficiency=axle.efficiency),
    )


def _engine_torques(line: ResolvedLine) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return the line's engine torque, brake torque, and low gear torque by J3311, (...) N m."""
    engine, gearbox = line.engine, line.gearbox
    if engine is None or line.gears is None:
        held = np.asarray(_first(gearbox.retarder_torque), dtype=float)
        return np.asarray(np.nan), line.share * held, np.asarray(np.nan)
    low = np.asarray(gearbox.transfer_ratio)
    by_j3311 = low_gear_torque(
        engine.peak,
        ratio=stacked(gearbox.ratios).max(-1),
        efficiency=np.where(np.asarray(gearbox.converter_ratio) == 1, 0.85, 0.80),
        stall_ratio=gearbox.converter_ratio,
        transfer_ratio=low,
        transfer_efficiency=np.where(low == 1, 1.0, 0.95),
    )
    strongest, _ = line.gears.strongest
    return strongest, line.share * brake_torque(engine, gearbox), line.share * by_j3311


def said_speed(line: ResolvedLine) -> FloatArray:
    """Speed of the line that state or application give, (..., S) rad/s; nan where neither does.

    A top speed is none of the gear that winds the axle up.
    """
    wound = line.winds("windup") & (line.gears is not None)
    return np.asarray(line.installed.speed_ratio, dtype=float) * _by_state(
        _first(s.speed, None if low else line.speed)
        for s, low in zip(line.states, wound, strict=True)
    )


def _speed(line: ResolvedLine) -> FloatArray:
    """Top speed of the line in each state, (..., S) rad/s.

    The torque that winds an axle up is that of the lowest gear, and so is the speed.
    """
    given = said_speed(line)
    if line.gears is None:
        return given
    _, low = line.gears.strongest
    top = np.where(line.winds("windup"), low, line.gears.top_speed)
    return np.where(np.isnan(given), top, given)


# --------------------------------------------------------------------------- places


def _travel(line: ResolvedLine, axle_loads: dict[tuple[str, float], FloatArray]) -> FloatArray:
    """Rise of the axle from the reference layout in each state, (..., S) m; 0 where held."""
    at_rest = height(line.reference, line.reference_loading)
    placed = [
        free and s.kind is not None and s.travel is None and height(s, loading) != at_rest
        for s, loading, free in zip(line.states, line.loadings, line.free, strict=True)
    ]
    start: FloatArray | None = None
    if any(placed) and (springs := line.suspension) is not None:
        with about(f"{_of_suspension(line)}.reference"):
            load = axle_loads[line.reference_loading.key]
            start = deflection(springs, springs.reference, axle_load=load)

    def rise(state: State, loading: Loading) -> ArrayLike:
        if line.suspension is None or start is None:
            msg = (
                f"state {state.name} cannot place the {line.installed.drives} axle of line "
                f"{line.line.name}: give that axle a suspension, or the state a travel"
            )
            raise DesignError(msg)
        assert state.kind is not None  # or nothing places it
        return deflection(line.suspension, state.kind, axle_load=axle_loads[loading.key]) - start

    risen: list[ArrayLike] = []
    for k, (s, loading) in enumerate(zip(line.states, line.loadings, strict=True)):
        with about(f"states[{k + 1}]"):
            said = s.travel if line.free[k] and s.travel is not None else 0.0
            risen.append(rise(s, loading) if placed[k] else said)
    # A tandem's forward axle is behind its main line, the other behind that from axle to axle;
    # where torque flows forward the hindmost is the first.
    sign = 1.0 if line.installed.output_joint is None else -1.0
    rocked = (sign * a if line.installed.drives == "rear" else 0.0 for a in _rocked(line))
    return _by_state(risen) + _by_state(rocked)


def _of_suspension(line: ResolvedLine) -> str:
    """Return where a file has a line's suspension: its own, or the vehicle's."""
    own = f"drivelines.{line.line.name}." if line.installed.suspension else ""
    return f"{own}suspension"


def _stands(line: ResolvedLine, travel: FloatArray, *, reference: FloatArray) -> FloatArray:
    """Deflection of the axle's springs that has risen to (..., S) m, whatever its load.

    nan where nobody knows it in the reference state, by the load there, N.
    """
    suspension = line.suspension
    if suspension is None or (suspension.reference not in AT_LIMIT and np.isnan(reference).any()):
        return np.full_like(travel, np.nan)
    return travel + deflection(suspension, suspension.reference, axle_load=reference)


def _rocked(line: ResolvedLine) -> Iterator[Metre]:
    """Yield how far a tandem's first axle rises over the mean of both, state by state."""
    first = line.ahead if line.installed.drives == "rear" else 1.0
    for state, free in zip(line.states, line.free, strict=True):
        yield first * state.articulation if free else 0.0


def _standing(
    line: ResolvedLine, travel: FloatArray, loads: LineLoads, *, stands: FloatArray
) -> Standing:
    """Return the line with its axle where springs and linkage have it, (..., S)."""
    free, states = line.free, line.states
    with about(_of_suspension(line)):
        dx, pitch = axle_path(line.suspension.linkage if line.suspension else Linkage(), travel)
    turned = _by_state(s.pitch if f else 0.0 for s, f in zip(states, free, strict=True))
    yields = free & np.array([s.pitch is None for s in states])
    x, z = line.axle.pinion_joint if line.axle else (0.0, 0.0)
    slip, slip_back, slip_reverse = _slips(line, loads)
    moves = line.tyre is not None and line.suspension is not None and line.suspension.squats
    return Standing(
        line=line,
        loads=loads,
        ride=Ride(
            shift=stacked((line.ahead * dx, 0.0, travel)),
            pitch=np.where(yields, pitch, turned),  # the pinion's nose up, whichever way it faces
            arm=stacked((x, 0.0, z)),
            lead=_by_state(2 * a for a in _rocked(line)),
        ),
        stands=stands,
        yields=yields,
        squats=free & line.rests & moves,
        slip=slip,
        slip_back=slip_back,
        slip_reverse=slip_reverse,
    )


def _own_windup(standing: Standing, torque: FloatArray) -> Ride:
    """Return the ride of a line in its states, its axle moved by torque in those of wind-up.

    Raises
    ------
    DesignError
        If one of these does not say enough to know it.
    """
    line = standing.line
    driven, braking = (line.winds(k) for k in ("windup", "windup brake"))
    winds = (driven | braking) & (standing.yields | standing.squats)
    if not winds.any():
        return standing.ride
    on_axle = _on_axle(line, torque, braked=standing.loads.braked, brakes=~driven)
    pitch = _pitch(line, on_axle)
    for k in np.flatnonzero(winds & standing.yields):
        if np.isnan(pitch[..., k]).any():
            msg = (
                f"state {line.states[k].name} of line {line.line.name} needs a windup_stiffness, "
                "the axle's ratio and a torque (traction) or brake_torque (brake); or a pitch"
            )
            raise DesignError(msg, about=f"states[{k + 1}]")
    found, own = standing.under(torque, brakes=~driven), standing.ride
    return replace(
        own,
        pitch=np.where(winds, found.pitch, own.pitch),
        shift=np.where(winds[..., None], found.shift, own.shift),
    )


def _on_axle(
    line: ResolvedLine,
    torque: FloatArray,
    *,
    braked: FloatArray,
    coasts: ArrayLike = False,
    brakes: ArrayLike = False,
) -> FloatArray:
    """Torque on the axle's housing, (...) N m, where a line carries some, (...) N m.

    The line's torque splits between the axles it drives. Brakes and coasting together hold
    no more than the tyres do.
    """
    suspension, axle, tyre = line.suspension, line.axle, line.tyre
    ratio, efficiency = (axle.ratio / _axles_behind(line), axle.efficiency) if axle else (np.nan, 1)
    turned = torque * ratio / efficiency  # by the wheels, which turn the line
    by_brakes = np.asarray(suspension.brake_torque if suspension else 0.0)
    held = np.where(by_brakes > 0, by_brakes + np.nan_to_num(-turned), np.nan)
    grip = tyre.friction * tyre.static_radius * braked if tyre else np.nan
    driven = np.where(coasts, turned, torque * ratio * efficiency)
    return np.where(brakes, -np.fmin(held, grip), driven)


def _axles_behind(line: ResolvedLine) -> FloatArray:
    """How many axles stand behind a line; how they share their load is no matter of it."""
    if line.vehicle is None:
        return np.ones(())
    axles = driven_axles(line.vehicle, drives=line.installed.drives)
    return np.maximum(np.round(line.installed.load_share * axles), 1.0)


def _pitch(line: ResolvedLine, on_axle: FloatArray) -> FloatArray:
    """Wind-up of the axle under torques on its housing, (...) rad; nan without a stiffness."""
    stiffness = line.suspension.windup_stiffness if line.suspension else None
    if stiffness is None:
        return np.full(on_axle.shape, np.nan)
    return windup(on_axle, stiffness=stiffness)


def _frequency(line: ResolvedLine, loads: LineLoads) -> FloatArray:
    """Natural frequency on the springs in each state, (..., S) Hz; nan where there is none.

    Nor has a state of no kind one, which says nothing of how it is loaded.
    """
    if line.suspension is None:
        return np.full(len(line.states), np.nan)
    load = carried(line.suspension, loads.axle)
    rests = line.rests & np.array([s.kind is not None for s in line.states])
    return natural_frequency(line.suspension.spring, np.where(rests & (load > 0), load, np.nan))


def _given(line: ResolvedLine) -> Layout:
    """Layouts (..., S, n, 3) before anything moves: a state's own, or the reference."""
    layouts = [o or line.installed.layout for o in line.own]

    def side_by_side(vectors: list[FloatArray]) -> FloatArray:
        each = [v if v.ndim > 2 else v[None] for v in vectors]
        return np.concatenate(np.broadcast_arrays(*each), axis=-3)

    return Layout(
        points=apart(side_by_side([o.points for o in layouts]), of=2),
        directions=apart(side_by_side([o.directions for o in layouts]), of=2),
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
    shim_ahead: ArrayLike = 0.0,
) -> Layout:
    """Layout with its axle ridden and, where joint 1 leaves an axle, that one likewise."""
    first: Ride | None = None
    if (joint := installed.output_joint) is not None:
        first = ride.ahead(stacked((joint[0], 0.0, joint[1])))
        first = replace(first, pitch=np.asarray(first.pitch) + np.asarray(shim_ahead))
    return moved(
        given,
        installed.line,
        bearing_shift=bearing_shift,
        last_shift=ride.shift,
        pinion_pitch=np.asarray(ride.pitch) + np.asarray(shim),
        pinion_arm=ride.arm,
        first=first,
    )
