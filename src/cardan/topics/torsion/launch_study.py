"""Start a vehicle from rest, and find what makes the peak: its ramp, its joints, its engine."""

from dataclasses import dataclass, replace
from math import pi

import numpy as np

from cardan.application.typical_values import TypicalValue, typical_value
from cardan.checks.drive_forces import TorqueSpeedTimeHistory, bearing_forces_over_time_history
from cardan.checks.line_response import compute_line_response
from cardan.core.arrays import ComplexArray, FloatArray
from cardan.core.errors import ConvergenceError, DesignError
from cardan.core.labels import Part
from cardan.core.units import g
from cardan.core.verdict import AssumedRange
from cardan.model.application import Application
from cardan.model.powertrain import Launch
from cardan.physics.dynamics.launch import (
    FrictionElements,
    LaunchHistory,
    instantaneous_order_amplitude,
    integrate_launch,
    spring_parallel_damping_matrix,
)
from cardan.physics.dynamics.torsional_line import joint_angles_and_pin_angles
from cardan.physics.dynamics.torsional_network import (
    TorsionalNetwork,
    static_response,
    torsional_modes,
)
from cardan.physics.vehicle.state_demand import LineStateDemand, demand_with_axle_moved_by_torque
from cardan.topics.torsion.powertrain_model import PowertrainModel, VehicleTorsionModel

LAUNCH_CASES = (
    "all",
    "joints straight",
    "no firing",
    "joints straight, no firing",
    "tyres that stick",
    "less grip, more rolling resistance",
    "more grip, less rolling resistance",
)
"""Variants started in addition to the vehicle itself: for each cause's share, and for what
is known only roughly, both of which pull a launch's lowest torque the same way."""

CASES_OF_ASSUMED_RANGES = LAUNCH_CASES[-2:]

ROLLING_RESISTANCE_COEFFICIENT = 0.008
"""Rolling resistance over weight: assumed."""

ROLLING_RESISTANCE_RANGE = (0.006, 0.010)
"""Coefficients of truck tyres on a hard road: assumed."""

GRIP_RANGE = (0.95, 1.05)
"""What tyres hold over what the file says they hold, where it gives friction: assumed. Neither an
axle's load nor the friction of the day is known closer, and 1.3 % can turn a launch."""

CONVERTER_COUPLING_SPEED_RATIO = 0.85
"""Speed ratio of a converter from which on it multiplies no torque: Project Chrono, FMTV."""

RIGID_BEARING_FORCE_TIME_POINTS = 40
"""Instants of a launch at which bearings without rubber are evaluated."""

MAX_LAUNCH_DURATION_S = 8.0
"""s: of a launch, however soft the vehicle."""


@dataclass(frozen=True, kw_only=True, eq=False)
class LaunchResult:
    """What a launch did to the main line and its neighbours.

    Attributes
    ----------
    launch, state
        Which, and in which state of load.
    torque : N m
        What the clutch carries at the end of its ramp, at the main line: T i with what the
        gears lose, the line's torque of that gear.
    springs : S
        Line and part of each spring.
    history
        The motion, of `LAUNCH_CASES`.
    peak_torque, lowest_torque : (S,) N m
        Largest torque of each spring, and the lowest after half of that was first there.
    peak_range, lowest_range : (2, S) N m
        Between what these lie while grip and rolling resistance are in their ranges.
    reversal_range : (2, S) 1
        The same of the lowest torque, backwards, over the peak of the same launch.
    assumed
        Those ranges.
    order2_amplitude : (S, N) N m
        Amplitude at each instant, by what the joints alone add.
    lockup_time : s
        When the clutch stopped slipping; nan where it did not, or there is none.
    tyres_slid
        Whether the tyres did.
    acceleration : rad/s²
        Largest of the main line's pinion, by what joints and engine add.
    bearing_time, bearing_force : (P,) s, (P, bearings) N
        Peak force on each centre bearing of the main line along the ramp, as it would be if
        each instant lasted.
    bearing_transient_force : (P, bearings) N
        The force as the line passes through; nan if its rubber is unknown.
    least_force_at_stop : (bearings,) N
        What each carries at least with its rubber at its stop; inf of rigid ones.
    """

    launch: Launch
    state: str
    torque: float
    springs: tuple[tuple[str, Part], ...]
    history: LaunchHistory
    peak_torque: FloatArray
    lowest_torque: FloatArray
    peak_range: FloatArray
    lowest_range: FloatArray
    reversal_range: FloatArray
    assumed: tuple[AssumedRange, ...]
    order2_amplitude: FloatArray
    lockup_time: float
    tyres_slid: bool
    acceleration: float
    bearing_time: FloatArray
    bearing_force: FloatArray
    bearing_transient_force: FloatArray
    least_force_at_stop: FloatArray

    @property
    def shares(self) -> dict[str, float]:
        """Peak at the main line's first shaft over T i, and what each cause adds to it."""
        first = self.first_shaft
        each = dict(
            zip(
                LAUNCH_CASES,
                np.abs(self.history.torque[..., first]).max(-1) / self.torque,
                strict=True,
            )
        )
        ramp = float(each["joints straight, no firing"])
        return {
            "ramp": ramp,
            "joints": float(each["no firing"]) - ramp,
            "firing": float(each["all"] - each["no firing"]),
            "all": float(each["all"]),
            "if tyres could not slide": float(each["tyres that stick"]),
        }

    @property
    def first_shaft(self) -> int:
        """Place of the main line's first shaft."""
        return next(k for k, (_, part) in enumerate(self.springs) if part == Part("shaft", 1))


PART_KINDS_AHEAD_OF_GEARS = frozenset({"engine", "flywheel", "clutch disc", "gearbox input"})
"""What turns ahead of the gears."""


@dataclass(frozen=True, kw_only=True, eq=False)
class GearLosses:
    """What gears lose, as the main line feels it while the engine drives.

    A gearbox of efficiency η passes on η of the torque, of the clutch's as of what the engine's
    inertia takes: so all ahead of it counts η times. An axle's passes on η of what it gets, so
    all behind it counts 1/η times. Where the file has not all lines of a vehicle, what
    there is has its share of engine and vehicle.

    Attributes
    ----------
    engine_factor, vehicle_factor : 1
        What engine and vehicle count.
    rotor_factors, spring_factors : (R,) 1, (S,) 1
        What each part counts.
    """

    engine_factor: float
    vehicle_factor: float
    rotor_factors: FloatArray
    spring_factors: FloatArray

    @classmethod
    def from_powertrain(
        cls, parts: VehicleTorsionModel, powertrain: PowertrainModel
    ) -> "GearLosses":
        """Return those of a vehicle."""
        gearbox = parts.application.gearbox
        starting = [r for r in parts.lines if r.installed.output_joint is None]
        share = sum(r.max_torque_share * float(r.installed.speed_ratio) for r in starting)
        axles = {r.line.name: r.axle.efficiency if r.axle else 1.0 for r in parts.lines}
        ahead = share * (gearbox.efficiency if gearbox else 1.0)
        vehicle = share / float(np.mean(list(axles.values())))
        # By the part furthest behind; the vehicle, whose lines may differ, by itself alone.
        counts = np.array([
            ahead if part.kind in PART_KINDS_AHEAD_OF_GEARS
            else 1 / axles[line] if part.kind in {"axle housing", "wheels"}
            else vehicle if part.kind == "vehicle" else 1.0
            for line, part in powertrain.freedoms
        ])  # fmt: skip
        rank = np.array(
            [
                1
                if part.kind in PART_KINDS_AHEAD_OF_GEARS
                else 3
                if part.kind in {"axle housing", "wheels"}
                else 0
                if part.kind == "vehicle"
                else 2
                for _, part in powertrain.freedoms
            ]
        )
        joints = powertrain.line.joints
        counts, rank = (np.append(v, v[joints]) for v in (counts, rank))
        rotors, springs = (
            counts[np.where(turns != 0, rank, -1).argmax(-1)]
            for turns in (powertrain.line.rotors, powertrain.line.springs)
        )
        return cls(
            engine_factor=ahead,
            vehicle_factor=vehicle,
            rotor_factors=rotors,
            spring_factors=springs,
        )

    def apply_to(self, line: TorsionalNetwork) -> TorsionalNetwork:
        """Return a line with what its gears lose."""
        return replace(
            line,
            inertia=line.inertia * self.rotor_factors,
            stiffness=line.stiffness * self.spring_factors,
            damping=line.damping * self.spring_factors,
        )


def default_launches(application: Application) -> tuple[Launch, ...]:
    """Return the launches of a file; where it has none a smooth one and a dropped clutch.

    Two: half a second up to the engine's largest torque; a twentieth of a second up to
    1.8 times that, which is what clutches hold.
    """
    return application.launches or (Launch(), Launch(ramp=0.05, capacity=1.8))


def launch_engine_speed(parts: VehicleTorsionModel, wanted: Launch) -> float:
    """Return the speed the engine is held at, rad/s: where full load starts, if not given."""
    engine = parts.application.engine
    assert engine is not None  # nothing is launched without one
    if wanted.engine_speed is not None:
        return wanted.engine_speed
    return max(float(engine.speed[0]), parts.idle)


def simulate_launch(
    parts: VehicleTorsionModel,
    asked: tuple[LineStateDemand, ...],
    wanted: Launch,
    *,
    step: float = 1e-3,
) -> LaunchResult:
    """Start the vehicle from rest.

    Raises
    ------
    DesignError
        If there is no engine to start it, or no such gear or load.
    ConvergenceError
        If its clutch cannot hold it on its grade, or the motion cannot be followed.
    """
    application = parts.application
    engine = application.engine
    if engine is None or wanted.gear not in parts.gears:
        msg = "a launch needs an engine, and a gear that the gearbox has"
        raise DesignError(msg, about="launch")
    gear, state = parts.gears.index(wanted.gear), _state(parts, asked[0], wanted)
    converter = parts.starting_device == "converter"
    powertrain = parts.slipping if converter else parts.closed
    losses = GearLosses.from_powertrain(parts, powertrain)
    straight = line = losses.apply_to(powertrain.line.select_case([gear], [state]))
    i, r = float(parts.ratios[gear]), parts.radius
    full = float(engine.peak_torque)
    clutch_torque = wanted.clutch_torque if wanted.clutch_torque is not None else full
    capacity = wanted.capacity * clutch_torque
    if application.clutch is not None and application.clutch.capacity is not None:
        capacity = min(capacity, application.clutch.capacity)
    turning = launch_engine_speed(parts, wanted)
    B, n = len(LAUNCH_CASES), line.size
    joints_count = np.array(
        [name != "joints straight" and "straight" not in name for name in LAUNCH_CASES]
    )
    fires = np.array(["no firing" not in name for name in LAUNCH_CASES])
    sticks = np.array([name == "tyres that stick" for name in LAUNCH_CASES])

    mass = float(parts.mass[state])
    weight = mass * g * r
    rolls = np.full(B, ROLLING_RESISTANCE_COEFFICIENT)
    rolls[-2:] = ROLLING_RESISTANCE_RANGE[::-1]
    slope = np.cos(wanted.grade) * rolls + max(np.sin(wanted.grade), 0.0)
    resists = losses.vehicle_factor * weight * slope
    stuck = replace(line, relaxation=np.full(line.relaxation.shape, np.inf)).select_case(0)
    found = torsional_modes(stuck)
    stall = application.gearbox.converter_ratio if application.gearbox else 1.0
    gain = losses.engine_factor * i
    gives = min(capacity, clutch_torque) * stall * gain * powertrain.torque_share
    takes = resists[0] / r * powertrain.road_ratio * powertrain.torque_share
    if gives <= takes:
        msg = (
            f"the vehicle does not start: the clutch brings {gives:.0f} N·m to the line, "
            f"the road takes {takes:.0f} N·m"
        )
        raise ConvergenceError(msg)
    line, springs, road = _on_road(powertrain, line, 50 * float(line.stiffness.max() / i**2))
    lost = np.append(losses.spring_factors, losses.vehicle_factor)
    tyres = [k for k, (_, p) in enumerate(springs) if p.kind == "tyres"]
    grip = lost[tyres] * _grips(parts, asked, state)
    slips = parts.starting_device == "clutch"
    disc = springs.index(("", Part("clutch disc"))) if slips else None
    held = (*([] if disc is None else [disc]), *tyres, road)
    damping = spring_parallel_damping_matrix(stuck, found, slide=held[:-1])

    least = 1e-6  # of the ramp at its very beginning
    bounds = np.repeat(resists[:, None], len(held), axis=1)
    holds = np.ones(B)
    holds[-2:] = _grip_range(parts)
    bounds[:, -1 - len(tyres) : -1] = np.where(sticks[:, None], np.inf, grip * holds[:, None])

    def most(t: float) -> FloatArray:
        if disc is not None:
            bounds[:, 0] = capacity * gain * max(min(t / wanted.ramp, 1.0), least)
        return bounds.copy()

    firing, order = parts.firing_torque, parts.cylinders / 2
    input_at = powertrain.freedoms.index(("", Part("gearbox input")))

    def driving(t: float, v: FloatArray) -> FloatArray:
        out = np.zeros((B, n))
        ramp = min(t / wanted.ramp, 1.0)
        if converter:
            ratio = (
                np.clip(v[:, input_at] * i / turning, 0.0, CONVERTER_COUPLING_SPEED_RATIO)
                / CONVERTER_COUPLING_SPEED_RATIO
            )
            out[:, input_at] = clutch_torque * ramp * (stall - (stall - 1) * ratio) * gain
            return out
        given = min(capacity * ramp, clutch_torque)
        wave = firing * given / full * np.sin(order * turning * t)
        out[:, 0] = (given + np.where(fires, wave, 0.0)) * gain
        return out

    first = float(found.frequency[1])
    duration = min(wanted.ramp + max(1.2, 3.5 * 2 * pi / first), MAX_LAUNCH_DURATION_S)
    target = clutch_torque * stall * gain * powertrain.torque_share
    bent = _bent(parts, asked, powertrain, straight, state, target)
    rate = np.zeros((B, n))
    if slips:
        rate[:, 0] = turning / i
    lengths = {"tyres": float(powertrain.slip_length[state])}
    travel = integrate_launch(
        line.select_case(0),
        damping,
        leads=lambda turned: joints_count[:, None] * bent(turned),
        follows=powertrain.freedoms.index((asked[0].installed.line.name, Part("axle housing"))),
        holding=FrictionElements(
            springs=held, max_torque=most,
            relaxation_length=np.array([lengths.get(springs[k][1].kind, np.inf) for k in held]),
        ),
        rolls=(powertrain.vehicle, r),
        driving=driving,
        rate=rate,
        play=_play(wanted, springs),
        duration=duration,
        step=step,
    )  # fmt: skip
    # What stands in the tables is what each spring carries, not as the main line feels it.
    travel = replace(travel, torque=travel.torque / lost)
    return _told(
        parts, asked[0], wanted, state, travel, springs, powertrain, target,
        grip / lost[tyres], tyres, disc,
    )  # fmt: skip


def _grip_range(parts: VehicleTorsionModel) -> tuple[float, float]:
    """Return what tyres hold at least and at most over what they are taken to hold."""
    typical = _typical_friction(parts)
    if typical is None:
        return GRIP_RANGE
    return typical.low / typical.value, typical.high / typical.value


def _typical_friction(parts: VehicleTorsionModel) -> TypicalValue | None:
    """Return the friction of tyres that stands in for what the file leaves out."""
    given = parts.application.is_given("tyre.friction")
    return None if given else typical_value("tyre.friction", parts.vehicle_class)


def _assumed_ranges(parts: VehicleTorsionModel) -> tuple[AssumedRange, ...]:
    """Return the ranges of what a launch depends on and is known only roughly."""
    typical = _typical_friction(parts)
    friction = (
        AssumedRange("tyre.friction", *_times(parts.friction, GRIP_RANGE))
        if typical is None
        else AssumedRange("tyre.friction", typical.low, typical.high)
    )
    return friction, AssumedRange("rolling resistance", *ROLLING_RESISTANCE_RANGE)


def _times(value: float, ends: tuple[float, float]) -> tuple[float, float]:
    return value * ends[0], value * ends[1]


def _play(wanted: Launch, springs: tuple[tuple[str, Part], ...]) -> tuple[int, float] | None:
    """Return the spring that has play, and how much."""
    if wanted.play <= 0:
        return None
    return next(k for k, (_, p) in enumerate(springs) if p.kind == "pinion"), wanted.play


def _state(parts: VehicleTorsionModel, asked: LineStateDemand, wanted: Launch) -> int:
    """Return the place of the state in which the launch is made: the load's own, else gvw."""
    load = wanted.load or "gvw"
    line = asked.static_state.line
    fit = [k for k, loading in enumerate(line.load_states) if loading.name == load]
    riding = [k for k in fit if line.states[k].limit_state_kind in {load, "given"}]
    del parts
    return (riding or fit or [len(line.states) - 1])[0]


def _on_road(
    powertrain: PowertrainModel, line: TorsionalNetwork, stiffness: float
) -> tuple[TorsionalNetwork, tuple[tuple[str, Part], ...], int]:
    """Return the line with the road as one more spring, between the vehicle and what stands."""
    row = np.zeros((1, line.springs.shape[1]))
    row[0, powertrain.vehicle] = 1.0

    def beside(values: FloatArray, value: float) -> FloatArray:
        lead = line.stiffness.shape[:-1]
        values = np.broadcast_to(values, (*lead, values.shape[-1]))
        return np.concatenate([values, np.full((*lead, 1), value)], axis=-1)

    road = replace(
        line,
        springs=np.concatenate([line.springs, row]),
        stiffness=beside(line.stiffness, stiffness),
        damping=beside(line.damping, 0.0),
        loss=beside(line.loss, 0.0),
        relaxation=beside(line.relaxation, np.inf),
    )
    return road, (*powertrain.springs, ("", Part("vehicle"))), line.springs.shape[0]


def _grips(
    parts: VehicleTorsionModel, asked: tuple[LineStateDemand, ...], state: int
) -> FloatArray:
    """Torque at the wheels of each line at which they slide, (lines,) N m."""
    tyre = parts.application.tyre
    r = parts.radius if tyre is None else tyre.static_radius
    found: list[float] = []
    for d in asked:
        load = float(np.broadcast_to(d.driven_load, (len(parts.states),))[state])
        if parts.rotation_sign < 0:  # load moves off the axle that pushes
            left = d.static_state.slip_torque_reverse / d.slip_torque
            load *= float(np.broadcast_to(left, (len(parts.states),))[state])
        if not np.isfinite(load):
            load = float(parts.mass[state]) * g * 0.6 / len(asked)
        # A line ahead of another drives its own axle only.
        behind = [e for e in asked if e is not d and e.installed.output_joint is not None]
        if d is asked[0] and behind:
            load *= 1 - sum(e.installed.load_share for e in behind)
        found.append(parts.friction * load * r)
    return np.array(found)


def _bent(
    parts: VehicleTorsionModel,
    asked: tuple[LineStateDemand, ...],
    powertrain: PowertrainModel,
    line: TorsionalNetwork,
    state: int,
    target: float,
):
    """Return the joints' leads by how far the housing has turned: a parabola through three.

    In tan(β/2) e^{i·place}, which goes with the slopes, so that nothing kinks. In reverse all
    turns are counted the way they go, and so are the places of the forks.
    """
    found = torsional_modes(line)
    force = powertrain.balanced_torques(np.array([target]), found.shape[..., 0])
    twist, _ = static_response(line, found, force)
    housing = powertrain.freedoms.index((asked[0].installed.line.name, Part("axle housing")))
    turned = float(twist[0, housing])
    shares = np.array([0.0, 0.5, 1.0])
    leads: list[ComplexArray] = []
    for d in asked:
        own = d.static_state.line
        if own.line.name in parts.excluded_lines:
            continue
        T = (
            parts.rotation_sign
            * target
            * own.nominal_torque_share
            / asked[0].static_state.line.nominal_torque_share
            * shares
        )
        under = demand_with_axle_moved_by_torque(
            d, torque=np.repeat(T[:, None], len(parts.states), axis=1), speed=0.0
        )
        beta, place = joint_angles_and_pin_angles(
            under.layout.directions[:, state], own.line.phases, own.line.is_cross
        )
        leads.append(np.tan(beta / 2) * np.exp(1j * parts.rotation_sign * place))
    at = np.concatenate(leads, axis=-1)  # (3, J)
    a = at[0]
    c = 2 * (at[2] - 2 * at[1] + at[0])
    b = at[2] - at[0] - c

    def bent(housing: FloatArray) -> ComplexArray:
        s = np.clip(housing / turned if turned else 0.0 * housing, -1.0, 2.0)[:, None]
        return (a + b * s + c * s * s) ** 2

    return bent


def _told(
    parts: VehicleTorsionModel,
    main: LineStateDemand,
    wanted: Launch,
    state: int,
    travel: LaunchHistory,
    springs: tuple[tuple[str, Part], ...],
    powertrain: PowertrainModel,
    target: float,
    grip: FloatArray,
    tyres: list[int],
    disc: int | None,
) -> LaunchResult:
    """Return what a motion comes to."""
    names = dict(zip(LAUNCH_CASES, range(len(LAUNCH_CASES)), strict=True))
    every = travel.torque[names["all"]]
    peaks, lowests = _peaks_and_lowests(travel.torque)
    peak, lowest = peaks[names["all"]], lowests[names["all"]]
    open_cases = [names["all"], *(names[case] for case in CASES_OF_ASSUMED_RANGES)]
    back = -lowests[open_cases] / peaks[open_cases]
    added = travel.torque[names["no firing"]] - travel.torque[names["joints straight, no firing"]]
    first_joint = powertrain.freedoms.index((main.installed.line.name, Part("joint", 1)))
    turned = travel.rotation[names["no firing"], :, first_joint]
    turned = np.maximum.accumulate(turned)
    order_2 = instantaneous_order_amplitude(added.T, np.broadcast_to(turned, added.T.shape), 2)
    locked = np.nan
    if disc is not None:
        slip = (
            travel.rate[0, :, 0]
            - travel.rate[0, :, powertrain.freedoms.index(("", Part("clutch disc")))]
        )
        open_at = np.flatnonzero(np.abs(slip) > 0.02 * abs(slip[0]))
        last = int(open_at[-1]) if open_at.size else 0
        locked = float(travel.time[last]) if last + 1 < len(travel.time) else np.nan
    slid = any(
        bool((np.abs(every[:, k]) >= limit * (1 - 1e-6)).any())
        for k, limit in zip(tyres, grip, strict=True)
    )
    pinion = powertrain.freedoms.index((main.installed.line.name, Part("pinion")))
    shaken = (
        travel.rate[names["all"], :, pinion]
        - travel.rate[names["joints straight, no firing"], :, pinion]
    )
    acceleration = float(np.abs(np.gradient(shaken, travel.time)).max())
    when, force, passed, at_stop = _bearings(parts, main, state, travel, springs, first_joint)
    return LaunchResult(
        launch=wanted,
        state=parts.states[state],
        torque=target,
        springs=springs,
        history=travel,
        peak_torque=peak,
        lowest_torque=lowest,
        peak_range=_ends(peaks[open_cases]),
        lowest_range=_ends(lowests[open_cases]),
        reversal_range=_ends(back),
        assumed=_assumed_ranges(parts),
        order2_amplitude=order_2,
        lockup_time=locked,
        tyres_slid=slid,
        acceleration=acceleration,
        bearing_time=when,
        bearing_force=force,
        bearing_transient_force=passed,
        least_force_at_stop=at_stop,
    )


def _peaks_and_lowests(torque: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the largest torque of (cases, N, S), and the lowest once half of it was there."""
    size = np.abs(torque)
    peaks = size.max(axis=1)
    there = np.maximum.accumulate(size >= peaks[:, None] / 2, axis=1)
    return peaks, np.where(there, torque, np.inf).min(axis=1)


def _ends(values: FloatArray) -> FloatArray:
    """Return the least and the largest of values (cases, S), (2, S)."""
    return np.stack([values.min(axis=0), values.max(axis=0)])


def _bearings(
    parts: VehicleTorsionModel,
    main: LineStateDemand,
    state: int,
    travel: LaunchHistory,
    springs: tuple[tuple[str, Part], ...],
    first_joint: int,
) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    """Return the force on each centre bearing along a launch, (P,) s, (P, bearings) N twice.

    And what each carries at least with its rubber at its stop, (bearings,) N.


    What the line on its rubber would carry at each instant's torque and speed, its axle wound
    up by that torque, and what it carries as it passes; nan if the rubber is unknown, and
    bearings are taken as rigid. In reverse all of it the other way.
    """
    shaft = springs.index((main.installed.line.name, Part("shaft", 1)))
    sense, T = parts.rotation_sign, travel.torque[1, :, shaft]
    speed = np.maximum(travel.rate[1, :, first_joint], 1e-3)
    bearings = max(0, main.installed.line.joint_count - 2)
    if not bearings:
        none = np.zeros((len(T), 0))
        return travel.time, none, none, none[0]
    drive = TorqueSpeedTimeHistory(
        time=travel.time,
        input_angle=sense * travel.rotation[1, :, first_joint],
        torque=sense * T,
        speed=sense * speed,
    )
    response = compute_line_response(parts.application, main)
    least = response.mount_loads.least_force_at_stop
    at_stop = np.broadcast_to(least, (len(parts.states), bearings))[state]
    found = bearing_forces_over_time_history(response.mounts, drive, state=state)
    if found is not None:
        return travel.time, *found, at_stop
    rows = np.linspace(1, len(T) - 1, RIGID_BEARING_FORCE_TIME_POINTS).astype(int)
    pushed, turns = (
        np.repeat(v[rows, None], len(parts.states), axis=1)
        for v in (sense * np.maximum(T, 1), speed)
    )
    under = demand_with_axle_moved_by_torque(main, torque=pushed, speed=turns)
    force = np.asarray(response.mounts.bearing_forces_at(under, under.layout).peak)[:, state]
    rigid = [np.interp(travel.time, travel.time[rows], force[:, b]) for b in range(bearings)]
    return travel.time, np.stack(rigid, axis=-1), np.full((len(T), bearings), np.nan), at_stop
