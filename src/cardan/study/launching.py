"""Start a vehicle from rest, and tell what makes the peak: its ramp, its joints, its engine."""

from dataclasses import dataclass, replace
from math import pi

import numpy as np

from cardan.base.arrays import ComplexArray, FloatArray
from cardan.base.errors import DesignError, NotConverged
from cardan.base.part import Part
from cardan.base.units import g
from cardan.demand.states import Demand, demand_under
from cardan.dynamics.branched import Branched, carried, modes
from cardan.dynamics.launch import Holding, Travel, launch, order_amplitude, part_damping
from cardan.dynamics.torsion import pins
from cardan.model.application import Application
from cardan.model.turning import Launch
from cardan.quantity import points
from cardan.quantity.response import respond
from cardan.study.powertrain import Drivetrain, Powertrain

CASES = ("all", "joints straight", "no firing", "joints straight, no firing", "tyres that stick")
"""What is started beside the vehicle itself, to tell each cause's share."""

ROLLING = 0.008
"""Rolling resistance over weight: assumed."""

COUPLING = 0.85
"""Speed ratio of a converter from which on it multiplies no torque: Project Chrono, FMTV."""

RIGID_ROWS = 40
"""Instants of a launch at which bearings without rubber are asked."""

LONGEST = 8.0
"""s: of a launch, however soft the vehicle."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Started:
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
    travel
        The motion, of `CASES`.
    peak, lowest : (S,) N m
        Largest torque of each spring, and the lowest after half of that was first there.
    order_2 : (S, N) N m
        Amplitude at each instant, by what the joints alone add.
    locked : s
        When the clutch stopped slipping; nan where it did not, or there is none.
    slid
        Whether the tyres did.
    acceleration : rad/s²
        Largest of the main line's pinion, by what joints and engine add.
    bearing_time, bearing_force : (P,) s, (P, bearings) N
        Peak force on each centre bearing of the main line along the ramp, as it would be if
        each instant lasted.
    bearing_passed : (P, bearings) N
        The force as the line passes through; nan where nobody knows its rubber.
    """

    launch: Launch
    state: str
    torque: float
    springs: tuple[tuple[str, Part], ...]
    travel: Travel
    peak: FloatArray
    lowest: FloatArray
    order_2: FloatArray
    locked: float
    slid: bool
    acceleration: float
    bearing_time: FloatArray
    bearing_force: FloatArray
    bearing_passed: FloatArray

    @property
    def shares(self) -> dict[str, float]:
        """Peak at the main line's first shaft over T i, and what each cause adds to it."""
        first = self.first
        each = dict(
            zip(CASES, np.abs(self.travel.torque[..., first]).max(-1) / self.torque, strict=True)
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
    def first(self) -> int:
        """Place of the main line's first shaft."""
        return next(k for k, (_, part) in enumerate(self.springs) if part == Part("shaft", 1))


AHEAD = frozenset({"engine", "flywheel", "clutch disc", "gearbox input"})
"""What turns ahead of the gears."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Losses:
    """What gears lose, as the main line feels it while the engine drives.

    A gearbox of efficiency η passes on η of the torque, of the clutch's as of what the engine's
    inertia takes: so all ahead of it counts η times. An axle's passes on η of what it gets, so
    all behind it counts 1/η times. Where the file has not all lines of a vehicle, what
    there is has its share of engine and vehicle.

    Attributes
    ----------
    ahead, vehicle : 1
        What engine and vehicle count.
    rotors, springs : (R,) 1, (S,) 1
        What each part counts.
    """

    ahead: float
    vehicle: float
    rotors: FloatArray
    springs: FloatArray

    @classmethod
    def of(cls, parts: Drivetrain, powertrain: Powertrain) -> "Losses":
        """Return those of a vehicle."""
        gearbox = parts.application.gearbox
        starting = [r for r in parts.lines if r.installed.output_joint is None]
        share = sum(r.share * float(r.installed.speed_ratio) for r in starting)
        axles = {r.line.name: r.axle.efficiency if r.axle else 1.0 for r in parts.lines}
        ahead = share * (gearbox.efficiency if gearbox else 1.0)
        vehicle = share / float(np.mean(list(axles.values())))
        # By the part furthest behind; the vehicle, whose lines may differ, by itself alone.
        counts = np.array([
            ahead if part.kind in AHEAD
            else 1 / axles[line] if part.kind in {"axle housing", "wheels"}
            else vehicle if part.kind == "vehicle" else 1.0
            for line, part in powertrain.freedoms
        ])  # fmt: skip
        rank = np.array([
            1 if part.kind in AHEAD else 3 if part.kind in {"axle housing", "wheels"}
            else 0 if part.kind == "vehicle" else 2
            for _, part in powertrain.freedoms
        ])  # fmt: skip
        joints = powertrain.line.joints
        counts, rank = (np.append(v, v[joints]) for v in (counts, rank))
        rotors, springs = (
            counts[np.where(turns != 0, rank, -1).argmax(-1)]
            for turns in (powertrain.line.rotors, powertrain.line.springs)
        )
        return cls(ahead=ahead, vehicle=vehicle, rotors=rotors, springs=springs)

    def on(self, line: Branched) -> Branched:
        """Return a line with what its gears lose."""
        return replace(
            line,
            inertia=line.inertia * self.rotors,
            stiffness=line.stiffness * self.springs,
            damping=line.damping * self.springs,
        )


def default_launches(application: Application) -> tuple[Launch, ...]:
    """Return the launches of a file; where it has none a smooth one and a dropped clutch.

    Two: half a second up to the engine's largest torque; a twentieth of a second up to
    1.8 times that, which is what clutches hold.
    """
    return application.launches or (Launch(), Launch(ramp=0.05, capacity=1.8))


def held_speed(parts: Drivetrain, wanted: Launch) -> float:
    """Return the speed the engine is held at, rad/s: where full load starts, if nobody says."""
    engine = parts.application.engine
    assert engine is not None  # nothing is launched without one
    if wanted.engine_speed is not None:
        return wanted.engine_speed
    return max(float(engine.speed[0]), parts.idle)


def start(
    parts: Drivetrain, asked: tuple[Demand, ...], wanted: Launch, *, step: float = 1e-3
) -> Started:
    """Start the vehicle from rest.

    Raises
    ------
    DesignError
        If there is no engine to start it, or no such gear or load.
    NotConverged
        If its clutch cannot hold it on its grade, or the motion cannot be followed.
    """
    application = parts.application
    engine = application.engine
    if engine is None or wanted.gear not in parts.gears:
        msg = "a launch needs an engine, and a gear that the gearbox has"
        raise DesignError(msg, about="launch")
    gear, state = parts.gears.index(wanted.gear), _state(parts, asked[0], wanted)
    converter = parts.starts_by == "converter"
    powertrain = parts.slipping if converter else parts.closed
    losses = Losses.of(parts, powertrain)
    straight = line = losses.on(powertrain.line.case([gear], [state]))
    i, r = float(parts.ratios[gear]), parts.radius
    full = float(engine.peak)
    clutch_torque = wanted.clutch_torque if wanted.clutch_torque is not None else full
    capacity = wanted.capacity * clutch_torque
    if application.clutch is not None and application.clutch.capacity is not None:
        capacity = min(capacity, application.clutch.capacity)
    turning = held_speed(parts, wanted)
    B, n = len(CASES), line.size
    joints_count = np.array(
        [name != "joints straight" and "straight" not in name for name in CASES]
    )
    fires = np.array(["no firing" not in name for name in CASES])
    sticks = np.array([name == "tyres that stick" for name in CASES])

    mass = float(parts.mass[state])
    weight = mass * g * r
    slope = np.cos(wanted.grade) * ROLLING + max(np.sin(wanted.grade), 0.0)
    resists = losses.vehicle * weight * slope
    stuck = replace(line, relaxation=np.full(line.relaxation.shape, np.inf)).case(0)
    found = modes(stuck)
    stall = application.gearbox.converter_ratio if application.gearbox else 1.0
    gain = losses.ahead * i
    gives = min(capacity, clutch_torque) * stall * gain * powertrain.share
    takes = resists / r * powertrain.road_ratio * powertrain.share
    if gives <= takes:
        msg = (
            f"the vehicle does not start: the clutch brings {gives:.0f} N·m to the line, "
            f"the road takes {takes:.0f} N·m"
        )
        raise NotConverged(msg)
    line, springs, road = _on_road(powertrain, line, 50 * float(line.stiffness.max() / i**2))
    lost = np.append(losses.springs, losses.vehicle)
    tyres = [k for k, (_, p) in enumerate(springs) if p.kind == "tyres"]
    grip = lost[tyres] * _grips(parts, asked, state)
    slips = parts.starts_by == "clutch"
    disc = springs.index(("", Part("clutch disc"))) if slips else None
    held = (*([] if disc is None else [disc]), *tyres, road)
    damping = part_damping(stuck, found, slide=held[:-1])

    least = 1e-6  # of the ramp at its very beginning
    bounds = np.full((B, len(held)), resists)
    bounds[:, -1 - len(tyres) : -1] = np.where(sticks[:, None], np.inf, grip)

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
            ratio = np.clip(v[:, input_at] * i / turning, 0.0, COUPLING) / COUPLING
            out[:, input_at] = clutch_torque * ramp * (stall - (stall - 1) * ratio) * gain
            return out
        given = min(capacity * ramp, clutch_torque)
        wave = firing * given / full * np.sin(order * turning * t)
        out[:, 0] = (given + np.where(fires, wave, 0.0)) * gain
        return out

    first = float(found.frequency[1])
    duration = min(wanted.ramp + max(1.2, 3.5 * 2 * pi / first), LONGEST)
    target = clutch_torque * stall * gain * powertrain.share
    bent = _bent(parts, asked, powertrain, straight, state, target)
    rate = np.zeros((B, n))
    if slips:
        rate[:, 0] = turning / i
    lengths = {"tyres": float(powertrain.slip_length[state])}
    travel = launch(
        line.case(0),
        damping,
        leads=lambda turned: joints_count[:, None] * bent(turned),
        follows=powertrain.freedoms.index((asked[0].installed.line.name, Part("axle housing"))),
        holding=Holding(
            springs=held, most=most,
            relaxation=np.array([lengths.get(springs[k][1].kind, np.inf) for k in held]),
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


def _play(wanted: Launch, springs: tuple[tuple[str, Part], ...]) -> tuple[int, float] | None:
    """Return the spring that has play, and how much."""
    if wanted.play <= 0:
        return None
    return next(k for k, (_, p) in enumerate(springs) if p.kind == "pinion"), wanted.play


def _state(parts: Drivetrain, asked: Demand, wanted: Launch) -> int:
    """Return the place of the state in which the launch is made: the load's own, else gvw."""
    load = wanted.load or "gvw"
    line = asked.standing.line
    fit = [k for k, loading in enumerate(line.loadings) if loading.name == load]
    riding = [k for k in fit if line.states[k].counts_as in {load, "given"}]
    del parts
    return (riding or fit or [len(line.states) - 1])[0]


def _on_road(
    powertrain: Powertrain, line: Branched, stiffness: float
) -> tuple[Branched, tuple[tuple[str, Part], ...], int]:
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


def _grips(parts: Drivetrain, asked: tuple[Demand, ...], state: int) -> FloatArray:
    """Torque at the wheels of each line at which they slide, (lines,) N m."""
    tyre = parts.application.tyre
    r = parts.radius if tyre is None else tyre.static_radius
    found: list[float] = []
    for d in asked:
        load = float(np.broadcast_to(d.driven_load, (len(parts.states),))[state])
        if parts.sense < 0:  # load moves off the axle that pushes
            left = d.standing.slip_reverse / d.slip_torque
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
    parts: Drivetrain,
    asked: tuple[Demand, ...],
    powertrain: Powertrain,
    line: Branched,
    state: int,
    target: float,
):
    """Return the joints' leads by how far the housing has turned: a parabola through three.

    In tan(β/2) e^{i·place}, which goes with the slopes, so that nothing kinks. In reverse all
    turns are counted the way they go, and so are the places of the forks.
    """
    found = modes(line)
    force = powertrain.balanced(np.array([target]), found.shape[..., 0])
    twist, _ = carried(line, found, force)
    housing = powertrain.freedoms.index((asked[0].installed.line.name, Part("axle housing")))
    turned = float(twist[0, housing])
    shares = np.array([0.0, 0.5, 1.0])
    leads: list[ComplexArray] = []
    for d in asked:
        own = d.standing.line
        if own.line.name in parts.left_out:
            continue
        T = parts.sense * target * own.usual_share / asked[0].standing.line.usual_share * shares
        under = demand_under(d, torque=np.repeat(T[:, None], len(parts.states), axis=1), speed=0.0)
        beta, place = pins(under.layout.directions[:, state], own.line.phases, own.line.crosses)
        leads.append(np.tan(beta / 2) * np.exp(1j * parts.sense * place))
    at = np.concatenate(leads, axis=-1)  # (3, J)
    a = at[0]
    c = 2 * (at[2] - 2 * at[1] + at[0])
    b = at[2] - at[0] - c

    def bent(housing: FloatArray) -> ComplexArray:
        s = np.clip(housing / turned if turned else 0.0 * housing, -1.0, 2.0)[:, None]
        return (a + b * s + c * s * s) ** 2

    return bent


def _told(
    parts: Drivetrain,
    main: Demand,
    wanted: Launch,
    state: int,
    travel: Travel,
    springs: tuple[tuple[str, Part], ...],
    powertrain: Powertrain,
    target: float,
    grip: FloatArray,
    tyres: list[int],
    disc: int | None,
) -> Started:
    """Return what a motion comes to."""
    names = dict(zip(CASES, range(len(CASES)), strict=True))
    every = travel.torque[names["all"]]
    peak = np.abs(every).max(0)
    lowest = np.empty(len(springs))
    for k in range(len(springs)):
        there = int(np.argmax(np.abs(every[:, k]) >= peak[k] / 2))
        lowest[k] = every[there:, k].min()
    added = travel.torque[names["no firing"]] - travel.torque[names["joints straight, no firing"]]
    first_joint = powertrain.freedoms.index((main.installed.line.name, Part("joint", 1)))
    turned = travel.rotation[names["no firing"], :, first_joint]
    turned = np.maximum.accumulate(turned)
    order_2 = order_amplitude(added.T, np.broadcast_to(turned, added.T.shape), 2)
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
    when, force, passed = _bearings(parts, main, state, travel, springs, first_joint)
    return Started(
        launch=wanted, state=parts.states[state], torque=target, springs=springs, travel=travel,
        peak=peak, lowest=lowest, order_2=order_2, locked=locked, slid=slid,
        acceleration=acceleration, bearing_time=when, bearing_force=force,
        bearing_passed=passed,
    )  # fmt: skip


def _bearings(
    parts: Drivetrain,
    main: Demand,
    state: int,
    travel: Travel,
    springs: tuple[tuple[str, Part], ...],
    first_joint: int,
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return the force on each centre bearing along a launch, (P,) s, (P, bearings) N twice.

    What the line on its rubber would carry at each instant's torque and speed, its axle wound
    up by that torque, and what it carries as it passes; nan where nobody knows the rubber, and
    bearings are taken as rigid. In reverse all of it the other way.
    """
    shaft = springs.index((main.installed.line.name, Part("shaft", 1)))
    sense, T = parts.sense, travel.torque[1, :, shaft]
    speed = np.maximum(travel.rate[1, :, first_joint], 1e-3)
    bearings = max(0, main.installed.line.joint_count - 2)
    if not bearings:
        none = np.zeros((len(T), 0))
        return travel.time, none, none
    drive = points.Driven(
        time=travel.time,
        turned=sense * travel.rotation[1, :, first_joint],
        torque=sense * T,
        speed=sense * speed,
    )
    response = respond(parts.application, main)
    found = points.driven(response, drive, state=state)
    if found is not None:
        return travel.time, *found
    rows = np.linspace(1, len(T) - 1, RIGID_ROWS).astype(int)
    pushed, turns = (
        np.repeat(v[rows, None], len(parts.states), axis=1)
        for v in (sense * np.maximum(T, 1), speed)
    )
    under = demand_under(main, torque=pushed, speed=turns)
    force = np.asarray(points.run(response, under, under.layout).peak)[:, state]
    rigid = [np.interp(travel.time, travel.time[rows], force[:, b]) for b in range(bearings)]
    return travel.time, np.stack(rigid, axis=-1), np.full((len(T), bearings), np.nan)
