"""The whole vehicle in torsion, from an application: its parts, referred; the rest, assumed.

Parts stand in the file at their own speed. Here they become one branched line a gear and a
state, at the speed of the main line's shafts. What a file does not say is a typical value of
the vehicle's class, and goes out with the answer as an `AssumedValue`; no part is left out.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any, Literal, TypeAlias

import numpy as np

from cardan.application.typical_values import TypicalValue, typical_value, vehicle_class_of
from cardan.core.arrays import FloatArray
from cardan.core.errors import DesignError
from cardan.core.labels import Part
from cardan.core.units import g
from cardan.model.application import Application, GearboxAndAxleRotors
from cardan.model.parts import Line, Shaft
from cardan.model.powertrain import AxleRotors
from cardan.model.vehicle import Axle
from cardan.physics.dynamics.torsional_network import TorsionalNetwork
from cardan.physics.vehicle.axle_loads import (
    driveline_axle_loads,
    driven_axle_count,
    static_axle_loads,
)
from cardan.physics.vehicle.resolved_line import LineWithResolvedReferences, resolve_line_references
from cardan.physics.vehicle.torque import DIRECT_DRIVE

LaunchDeviceKind: TypeAlias = Literal["clutch", "converter", "motor"]

CLOSED_CLUTCH_STIFFNESS_RATIO = 50.0
"""Stiffness of a closed clutch's friction over that of its damper: stiff, and not rigid."""

DegreeOfFreedom: TypeAlias = tuple[str, Part]
"""A rotation by the line it is of, "" where it is of none, and the part that turns."""

RotationCombination: TypeAlias = Mapping[Any, float]
"""A sum of rotations: freedoms, or ("behind", the freedom) for what a joint drives."""


@dataclass(frozen=True, slots=True, kw_only=True)
class AssumedValue:
    """A value that is not given: what it is of, and what stands in for it."""

    line: str
    typical: TypicalValue

    @property
    def quantity(self) -> str:
        """What it is, by its key: `clutch.stiffness`."""
        return self.typical.quantity


@dataclass(frozen=True, kw_only=True, eq=False)
class PowertrainModel:
    """One vehicle's line in torsion, in G gears and S states.

    Attributes
    ----------
    line : cases (G, S)
        Engine to road, or from the clutch's disc where that slips.
    freedoms, springs
        What turns, in the order of `line`, and what is twisted.
    joints : J
        Line and number of each joint, in the order of `line.joints`.
    driver : place of the freedom that the mean torque comes from.
    vehicle : place of the freedom that it ends at.
    slip_length : (S,) m
        Relaxation length of the tyres.
    road_ratio : m
        How far the vehicle goes for each radian of the line.
    torque_share : 1
        What the main line carries of the torque that the gearbox gives all lines.
    """

    line: TorsionalNetwork
    freedoms: tuple[DegreeOfFreedom, ...]
    springs: tuple[DegreeOfFreedom, ...]
    joints: tuple[tuple[str, int], ...]
    driver: int
    vehicle: int
    slip_length: FloatArray
    road_ratio: float
    torque_share: float

    def with_rolling_tyres(self, speed: FloatArray) -> TorsionalNetwork:
        """Return the line at a speed (G, S) rad/s of its shafts, its tyres slipping."""
        v = np.maximum(np.asarray(speed, dtype=float) * self.road_ratio, 1e-6)
        of_tyres = np.array([part.kind == "tyres" for _, part in self.springs])
        relaxation = np.where(of_tyres, (self.slip_length / v)[..., None], np.inf)
        return replace(self.line, relaxation=relaxation)

    def balanced_torques(self, torque: FloatArray, rigid: FloatArray) -> FloatArray:
        """Return mean torques on the freedoms (..., n) N m that carry one through the main line.

        `rigid` (..., n) is how they turn together.
        """
        torque = torque / self.torque_share
        force = np.zeros(
            (*np.broadcast_shapes(np.shape(torque), rigid.shape[:-1]), rigid.shape[-1])
        )
        force[..., self.driver] = torque
        ratio = rigid[..., self.vehicle] / rigid[..., self.driver]
        force[..., self.vehicle] = -torque / ratio
        return force


@dataclass
class _Parts:
    """Rotors and springs as they are gathered: each a value and what it turns with."""

    freedoms: list[DegreeOfFreedom] = field(default_factory=list[DegreeOfFreedom])
    joints: list[DegreeOfFreedom] = field(default_factory=list[DegreeOfFreedom])
    rotors: list[tuple[Any, RotationCombination]] = field(default_factory=list[Any])
    springs: list[tuple[DegreeOfFreedom, tuple[Any, Any, Any], RotationCombination]] = field(
        default_factory=list[Any]
    )

    def freedom(self, line: str, part: Part) -> DegreeOfFreedom:
        """Return a freedom, a new one if there is none of this name."""
        named = (line, part)
        if named not in self.freedoms:
            self.freedoms.append(named)
        return named

    def rotor(self, inertia: Any, turns: RotationCombination) -> None:
        """Add what turns with a sum of rotations."""
        self.rotors.append((inertia, turns))

    def spring(
        self,
        name: DegreeOfFreedom,
        stiffness: Any,
        turns: RotationCombination,
        *,
        loss: Any = 0.0,
        damping: Any = 0.0,
    ) -> None:
        """Add what is twisted by a sum of rotations."""
        self.springs.append((name, (stiffness, loss, damping), turns))

    def made(self, cases: tuple[int, ...]) -> TorsionalNetwork:
        """Return the branched line."""
        place: dict[Any, int] = {f: k for k, f in enumerate(self.freedoms)}
        place |= {("behind", j): len(place) + k for k, j in enumerate(self.joints)}

        def rows(all_turns: list[RotationCombination]) -> FloatArray:
            out = np.zeros((len(all_turns), len(place)))
            for row, turns in zip(out, all_turns, strict=True):
                for what, ratio in turns.items():
                    row[place[what]] += ratio
            return out

        def column(values: list[Any]) -> FloatArray:
            return np.stack([np.broadcast_to(np.asarray(v, float), cases) for v in values], -1)

        stiffness, loss, damping = zip(*(v for _, v, _ in self.springs), strict=True)
        return TorsionalNetwork(
            joints=np.array([place[j] for j in self.joints], dtype=int),
            inertia=column([v for v, _ in self.rotors]),
            rotors=rows([t for _, t in self.rotors]),
            stiffness=column(list(stiffness)),
            springs=rows([t for _, _, t in self.springs]),
            damping=column(list(damping)),
            loss=column(list(loss)),
            relaxation=np.full((*cases, len(self.springs)), np.inf),
        )


class _DefaultedValues:
    """What is given, or assumed and noted."""

    def __init__(self, vehicle_class: str, replaced: Mapping[str, float]) -> None:
        self.vehicle_class, self.replaced = vehicle_class, replaced
        self.assumed: dict[tuple[str, str], AssumedValue] = {}

    def of(self, given: Any, quantity: str, *, line: str = "") -> Any:
        """Return what is given, or what a vehicle of the class has."""
        if given is not None:
            return given
        row = typical_value(quantity, self.vehicle_class)
        self.assumed[line, quantity] = AssumedValue(line=line, typical=row)
        return self.replaced.get(quantity, row.value)


@dataclass(frozen=True, kw_only=True, eq=False)
class VehicleTorsionModel:
    """A vehicle in torsion: its clutch closed, and slipping, with what was assumed for it.

    Attributes
    ----------
    gears, ratios : G
        Engine speed over the speed of the main line, its size.
    rotation_sign : 1
        -1 in reverse gears: all turns and is pushed the other way.
    states : S
    lines
        The main one first.
    vehicle_class
        Whose typical values stand in for what is not given.
    excluded_lines
        Lines whose joints do not count: they turn at another speed than the main line.
    firing_torque, cylinders : N m, 1
        Amplitude at full load of the engine, and its cylinders.
    idle : rad/s
        Of the engine; a motor has none.
    starting_device : clutch, converter or motor
        What lets the vehicle start from rest; a motor does with nothing between.
    """

    application: Application
    gears: tuple[str, ...]
    ratios: FloatArray
    rotation_sign: float
    states: tuple[str, ...]
    lines: tuple[LineWithResolvedReferences, ...]
    closed: PowertrainModel
    slipping: PowertrainModel
    assumed: tuple[AssumedValue, ...]
    vehicle_class: str
    excluded_lines: tuple[str, ...]
    firing_torque: float
    cylinders: int
    idle: float
    mass: FloatArray
    radius: float
    friction: float
    starting_device: LaunchDeviceKind


def vehicle_torsion_model(
    application: Application,
    *,
    surroundings: GearboxAndAxleRotors | None = None,
    replaced: Mapping[str, float] | None = None,
    astern: bool = False,
) -> VehicleTorsionModel:
    """Return the whole vehicle in torsion.

    Parameters
    ----------
    application
        Its lines need a tube in every shaft.
    surroundings
        The first plan's table, or options that go before the file: what stands behind the
        pinion and with the gearbox, in place of parts.
    replaced
        Values in place of typical ones, by quantity: how an answer moves with them.
    astern
        In its reverse gears, in place of those ahead. Each has what is given of the first gear.

    Raises
    ------
    DesignError
        If a shaft has no tube, or a part is no part.
    """
    lines = tuple(
        sorted(
            (resolve_line_references(application, i) for i in application.lines), key=_main_first
        )
    )
    mass = _masses(application, lines[0])
    known_mass = np.isfinite(mass)
    vehicle_class = _class(application, mass)
    known = _DefaultedValues(vehicle_class, replaced or {})
    if not known_mass.all():
        mass = np.where(known_mass, mass, known.of(None, "vehicle.mass"))
    made = _Vehicle(
        application, lines, known, surroundings or GearboxAndAxleRotors(), mass, astern=astern
    )
    closed, slipping = made.powertrain(closed=True), made.powertrain(closed=False)
    engine = application.engine
    given_idle = engine.idle if engine else None
    peak = float(engine.peak_torque) if engine else 0.0
    burns = engine is not None and not application.electric
    firing = engine.firing_torque if engine else None
    share = known.of(None, "engine.firing_torque") if burns and firing is None else 0.0
    cylinders = engine.cylinders if engine else None
    return VehicleTorsionModel(
        application=application,
        gears=made.gears,
        ratios=made.ratios,
        rotation_sign=-1.0 if astern else 1.0,
        states=tuple(s.name for s in lines[0].states),
        lines=lines,
        closed=closed,
        slipping=slipping,
        vehicle_class=vehicle_class,
        excluded_lines=tuple(made.left_out),
        firing_torque=firing if firing is not None else share * peak,
        cylinders=round(known.of(cylinders, "engine.cylinders")) if burns else 0,
        idle=known.of(given_idle, "engine.idle") if burns else 0.0,
        mass=mass,
        radius=made.radius,
        friction=made.friction,
        starting_device=made.starts_by,
        assumed=tuple(known.assumed.values()),
    )


def _main_first(line: LineWithResolvedReferences) -> tuple[bool, float, bool]:
    """Order lines, however a file lists them: the main one starts at the gearbox and has most."""
    installed = line.installed
    return (
        installed.output_joint is not None,
        -line.nominal_torque_share,
        installed.drives == "front",
    )


def _masses(application: Application, line: LineWithResolvedReferences) -> FloatArray:
    """Mass of the vehicle in each state, (S,) kg; nan where no load says it."""
    vehicle = application.vehicle
    found: list[float] = []
    for loading in line.load_states:
        if vehicle is None or loading.load_state is None:
            found.append(np.nan)
        elif loading.load_state.mass is not None:
            found.append(float(loading.load_state.mass) * loading.load_factor)
        else:
            found.append(
                float(static_axle_loads(vehicle, loading.load_state).total)
                / g
                * loading.load_factor
            )
    values = np.array(found)
    heaviest = np.nanmax(values) if np.isfinite(values).any() else np.nan
    return np.where(np.isfinite(values), values, heaviest)


def _class(application: Application, mass: FloatArray) -> str:
    """Return the class of the vehicle: by its mass, else by the torque of its line."""
    if np.isfinite(mass).any():
        return vehicle_class_of(float(np.nanmax(mass)))
    torque = application.torque or 0.0
    return vehicle_class_of(2e3 if torque < 2e3 else 12e3 if torque < 9e3 else 26e3)


class _Vehicle:
    """Puts the parts of one vehicle together."""

    def __init__(
        self,
        application: Application,
        lines: tuple[LineWithResolvedReferences, ...],
        known: _DefaultedValues,
        around: GearboxAndAxleRotors,
        mass: FloatArray,
        *,
        astern: bool,
    ) -> None:
        self.app, self.lines, self.known, self.around, self.mass = (
            application, lines, known, around, mass
        )  # fmt: skip
        main = lines[0]
        self.astern, gears = astern, main.reverse_gears if astern else main.gears
        self.gears = gears.names if gears else ("",)
        self.ratios = np.array(gears.ratios) if gears else np.array([1.0])
        tyre = application.tyre
        radius = tyre and (tyre.dynamic_radius or tyre.static_radius)
        self.radius: float = known.of(radius, "tyre.radius")
        self.friction: float = known.of(tyre and tyre.friction, "tyre.friction")
        # What stands in for damping that is not given: a loss factor is twice a damping ratio.
        self.given_loss = None if around.damping_ratio is None else 2 * around.damping_ratio
        self.loss: float = known.of(self.given_loss, "steel.loss")
        pace = main.installed.speed_ratio
        self.left_out = [
            r.line.name for r in lines if abs(r.installed.speed_ratio / pace - 1) > 1e-9
        ]
        stall = (application.gearbox or DIRECT_DRIVE).converter_ratio
        self.starts_by: LaunchDeviceKind = (
            "converter" if application.converter is not None
            else "clutch" if application.clutch is not None
            else "converter" if stall > 1
            else "motor" if application.electric
            else "clutch"
        )  # fmt: skip

    def powertrain(self, *, closed: bool) -> PowertrainModel:
        """Return the vehicle with its clutch closed, or slipping: then the engine is cut off."""
        parts = _Parts()
        self._ahead(parts, closed=closed)
        self._lines(parts)
        vehicle = parts.freedom("", Part("vehicle"))
        parts.rotor(self.mass * self.radius**2 + self._other_wheels(), {vehicle: 1.0})
        axle = self._axle(self.lines[0])
        return PowertrainModel(
            line=parts.made((len(self.gears), len(self.mass))),
            freedoms=tuple(parts.freedoms),
            springs=tuple(name for name, _, _ in parts.springs),
            joints=tuple((line, int(part.number)) for line, part in parts.joints),
            driver=0,
            vehicle=parts.freedoms.index(vehicle),
            slip_length=self._slip_length(),
            road_ratio=self.radius / axle.ratio,
            torque_share=self._output(parts)[self.lines[0].line.name, Part("joint", 1)],
        )

    # ----- engine to gearbox -----

    def _ahead(self, parts: _Parts, *, closed: bool) -> None:
        """Add engine, clutch and gearbox, referred to the main line."""
        app, of = self.app, self.known.of
        i2 = (self.ratios**2)[:, None]
        shaft = parts.freedom("", Part("gearbox input"))
        rotors = (app.gearbox or DIRECT_DRIVE).rotors
        torque = float(app.engine.peak_torque) if app.engine else 0.0
        clutch, flywheel, converter = app.clutch, app.dual_mass_flywheel, app.converter
        turned = 0.0
        pace2 = 1 / self.lines[0].installed.speed_ratio ** 2
        stiffness = self.around.gearbox_stiffness
        given = (stiffness,) if stiffness is not None else rotors.stiffness
        spring = self._by_gear(given, "gearbox.stiffness") * pace2
        if closed:
            parts.freedoms.clear()
            behind = parts.freedom("", Part("engine"))
            engine = self._engine_inertia()
            if self.starts_by == "converter":
                engine = engine + of(converter and converter.pump_inertia, "converter.pump_inertia")
            parts.rotor(engine * i2, {behind: 1.0})
            if flywheel is not None:
                half = parts.freedom("", Part("flywheel"))
                parts.rotor(flywheel.secondary_inertia * i2, {half: 1.0})
                damping = flywheel.damping
                loss = of(self.given_loss, "clutch.loss") if damping is None else 0.0
                parts.spring(("", Part("flywheel")), flywheel.stiffness * i2,
                             {behind: 1.0, half: -1.0}, loss=loss,
                             damping=(damping or 0.0) * i2)  # fmt: skip
                behind = half
            parts.freedom(*shaft)
        else:
            behind = None
        if self.starts_by == "motor":
            if behind is not None:  # its shaft is the gearbox's
                parts.spring(
                    ("", Part("engine")),
                    CLOSED_CLUTCH_STIFFNESS_RATIO * spring,
                    {behind: 1.0, shaft: -1.0},
                )
        elif self.starts_by == "converter":
            lockup = of(converter and converter.lockup_stiffness, "clutch.stiffness")
            turned = of(converter and converter.turbine_inertia, "converter.turbine_inertia")
            if behind is not None:
                parts.spring(("", Part("clutch")), lockup * i2, {behind: 1.0, shaft: -1.0},
                             loss=of(self.given_loss, "clutch.loss"))  # fmt: skip
        else:
            k = of(clutch and clutch.stiffness_at(torque), "clutch.stiffness")
            damping = clutch and clutch.damping
            held = clutch and clutch.hysteresis
            loss = 0.0 if damping is not None else self._clutch_loss(held, torque)
            disc = ("", Part("clutch disc"))
            if behind is not None:
                parts.freedoms.insert(parts.freedoms.index(shaft), disc)
                parts.spring(
                    disc, CLOSED_CLUTCH_STIFFNESS_RATIO * k * i2, {behind: 1.0, disc: -1.0}
                )
            else:
                parts.freedoms.insert(0, disc)
            parts.rotor(of(clutch and clutch.disc_inertia, "clutch.disc_inertia") * i2, {disc: 1.0})
            parts.spring(("", Part("clutch")), k * i2, {disc: 1.0, shaft: -1.0}, loss=loss,
                         damping=(damping or 0.0) * i2)  # fmt: skip
        inertia = of(rotors.input_inertia, "gearbox.input_inertia") + turned
        parts.rotor(inertia * i2, {shaft: 1.0})
        output = self._output(parts)
        parts.spring(("", Part("gearbox")), spring,
                     {shaft: 1.0} | {f: -v for f, v in output.items()}, loss=self.loss)  # fmt: skip
        inertia = self.around.gearbox_inertia
        given = (inertia,) if inertia is not None else rotors.output_inertia
        parts.rotor(self._by_gear(given, "gearbox.output_inertia") * pace2, output)

    def _clutch_loss(self, hysteresis: float | None, torque: float) -> float:
        """Loss factor of a clutch's damper: its hysteresis where the torque just reverses.

        A loop as high as 2 H and as long as the swing: η = 2 H / (π T). Larger swings lose less
        of what they have, smaller ones more.
        """
        if hysteresis is None or torque <= 0:
            return self.known.of(self.given_loss, "clutch.loss")
        return 2 * hysteresis / (np.pi * torque)

    def _engine_inertia(self) -> float:
        engine, of = self.app.engine, self.known.of
        if engine is not None and engine.inertia is not None:
            return engine.inertia
        litres = None if engine is None else engine.displacement
        if litres is None and engine is not None:
            litres = max(engine.torque) / of(None, "engine.torque_per_litre") * 1e-3
        litres = of(litres, "engine.displacement")
        base = of(None, "engine.inertia_base")
        return base + of(None, "engine.inertia_per_litre") * litres / 1e-3

    def _by_gear(self, given: tuple[float, ...], quantity: str) -> FloatArray:
        """Return a value of each gear, (G, 1): one for all, or one for each of the gearbox's."""
        if not given:
            return np.full((len(self.gears), 1), self.known.of(None, quantity))
        each = given[:1] if self.astern else given
        return np.resize(np.array(each), len(self.gears))[:, None]

    def _output(self, parts: _Parts) -> dict[DegreeOfFreedom, float]:
        """Return what the gearbox's output turns with: the lines that start there.

        A transfer case shares its torque between them by a differential, and turns by the
        same shares of their turning.
        """
        starting = [r for r in self.lines if r.installed.output_joint is None]
        pace = self.lines[0].installed.speed_ratio
        shares = np.array([r.max_torque_share * r.installed.speed_ratio for r in starting])
        shares = shares / shares.sum()
        return {
            parts.freedom(r.line.name, Part("joint", 1)): share * pace / r.installed.speed_ratio
            for r, share in zip(starting, shares.tolist(), strict=True)
        }

    # ----- gearbox to road -----

    def _lines(self, parts: _Parts) -> None:
        for k, line in enumerate(self.lines):
            after = self.lines[k + 1] if k + 1 < len(self.lines) else None
            tandem = after is not None and after.installed.output_joint is not None
            self._shafts(parts, line)
            self._driven(parts, line, behind=after if tandem else None)

    @property
    def _locked(self) -> bool:
        return self.app.inter_axle is not None and self.app.inter_axle.locked

    def _start(self, parts: _Parts, line: LineWithResolvedReferences) -> DegreeOfFreedom:
        """Return what joint 1 of a line is driven by."""
        k = self.lines.index(line)
        if line.installed.output_joint is not None and k > 0 and self._locked:
            return parts.freedom(self.lines[k - 1].line.name, Part("pinion"))
        return parts.freedom(line.line.name, Part("joint", 1))

    def _shafts(self, parts: _Parts, line: LineWithResolvedReferences) -> None:
        """Add the shafts of a line, each between two joints."""
        name, of = line.line.name, self.known.of
        count = line.line.joint_count
        ends = [self._start(parts, line)]
        ends += [parts.freedom(name, Part("joint", k)) for k in range(2, count + 1)]
        counts = name not in self.left_out

        def behind(k: int) -> Any:
            return ("behind", ends[k]) if counts else ends[k]

        if counts:
            parts.joints.extend(ends)
        for k, shaft in enumerate(line.line.shafts):
            stiffness, tube = _tube(shaft, k + 1, name)
            stiffness = spring_and_disc_stiffness(stiffness, _disc(line.line, k))
            yokes = _yokes(shaft, tube)
            if yokes is None:
                one = of(None, "shaft.yoke_inertia", line=name)
                yokes = (one, one)
            parts.spring((name, Part("shaft", k + 1)), stiffness,
                         {behind(k): 1.0, ends[k + 1]: -1.0}, loss=self.loss)  # fmt: skip
            parts.rotor(yokes[0] + tube / 2, {behind(k): 1.0})
            parts.rotor(yokes[1] + tube / 2, {ends[k + 1]: 1.0})

    def _driven(
        self,
        parts: _Parts,
        line: LineWithResolvedReferences,
        *,
        behind: LineWithResolvedReferences | None,
    ) -> None:
        """Add the axle of a line, its wheels and tyres."""
        name, of = line.line.name, self.known.of
        axle, count = self._axle(line), self._axles(line)
        rotors = axle.rotors
        last: Any = (name, Part("joint", line.line.joint_count))
        if last in parts.joints:
            last = ("behind", last)
        pinion = parts.freedom(name, Part("pinion"))
        housing = parts.freedom(name, Part("axle housing"))
        wheels = parts.freedom(name, Part("wheels"))
        vehicle = ("", Part("vehicle"))
        parts.rotor(of(rotors.flange_inertia, "axle.flange_inertia", line=name), {last: 1.0})
        cage: dict[Any, float] = {pinion: 1.0}
        if behind is not None:
            given = self.app.inter_axle
            split = (
                given.torque_split
                if given
                else behind.nominal_torque_share / line.nominal_torque_share
            )
            if not self._locked:
                cage = {pinion: 1 - split, self._start(parts, behind): split}
            through = given and given.through_inertia
            parts.rotor(of(through, "inter_axle.through_inertia"),
                        {self._start(parts, behind): 1.0})  # fmt: skip
            turned = given and given.cage_inertia
            parts.rotor(of(turned, "inter_axle.cage_inertia"), cage)
        stiffness = of(rotors.pinion_stiffness, "axle.pinion_stiffness", line=name)
        stiffness = spring_and_disc_stiffness(
            stiffness, _disc(line.line, line.line.joint_count - 1)
        )
        parts.spring((name, Part("pinion")), stiffness,
                     {last: 1.0} | {f: -v for f, v in cage.items()}, loss=self.loss)  # fmt: skip
        parts.rotor(of(rotors.pinion_inertia, "axle.pinion_inertia", line=name), {pinion: 1.0})
        i, hub = axle.ratio, rotors.hub_ratio
        ring = {pinion: hub / i, housing: 1.0}
        parts.rotor(count * of(rotors.ring_inertia, "axle.ring_inertia", line=name), ring)
        inertia = of(rotors.housing_inertia, "axle.housing_inertia", line=name)
        parts.rotor(count * inertia, {housing: 1.0})
        suspension = line.suspension
        stiff = of(suspension and suspension.windup_stiffness, "suspension.windup_stiffness",
                   line=name)  # fmt: skip
        loss = suspension and suspension.windup_loss_factor
        loss = of(self.given_loss if loss is None else loss, "suspension.windup_loss", line=name)
        # A housing that pitches twists the line backwards.
        parts.spring((name, Part("wind-up")), count * stiff, {housing: -1.0}, loss=loss)
        half = rotors.half_shaft_stiffness
        if self.around.axle_stiffness is not None:
            half = self.around.axle_stiffness * i**2
        if half is None:
            each = of(None, "axle.half_shafts", line=name)
            half = replace(rotors, half_shafts=(each, each)).half_shaft_stiffness
        assert half is not None
        parts.spring((name, Part("half shafts")), count * half,
                     {pinion: hub / i, housing: hub, wheels: -hub}, loss=self.loss)  # fmt: skip
        parts.rotor(count * self._wheel_inertia(line, i), {wheels: 1.0})
        tyre = self.app.tyre
        each = of(tyre and tyre.longitudinal_stiffness, "tyre.longitudinal_stiffness")
        stiff = count * self._per_axle(line) * each * self.radius**2
        main = self.lines[0]
        alike = (i / self._axle(main).ratio) * (
            main.installed.speed_ratio / line.installed.speed_ratio
        )
        parts.spring((name, Part("tyres")), stiff, {wheels: 1.0, vehicle: -1.0 / alike})

    def _axle(self, line: LineWithResolvedReferences) -> Axle:
        if line.axle is not None:
            return line.axle
        return Axle(
            ratio=self.known.of(None, "axle.ratio", line=line.line.name), rotors=AxleRotors()
        )

    def _axles(self, line: LineWithResolvedReferences) -> int:
        """Return how many axles stand behind a line and behind no other."""
        vehicle = self.app.vehicle
        if vehicle is None:
            return 1
        all_of = driven_axle_count(vehicle, drives=line.installed.drives)
        others = sum(
            r is not line and r.installed.drives == line.installed.drives for r in self.lines
        )
        return max(all_of - others, 1)

    def _per_axle(self, line: LineWithResolvedReferences) -> int:
        """Return how many wheels a driven axle has: a front axle two."""
        if line.installed.drives == "front":
            return 2
        wheels = self.app.wheels
        return round(self.known.of(wheels and wheels.per_axle, "wheels.per_axle"))

    def _wheel_inertia(self, line: LineWithResolvedReferences, ratio: float) -> float:
        """Inertia of the wheels of one axle with its hubs, kg m²."""
        of, wheels = self.known.of, self.app.wheels
        if self.around.axle_inertia is not None:
            return self.around.axle_inertia * ratio**2
        hub = of(wheels and wheels.hub_inertia, "wheels.hub_inertia")
        each = of(wheels and wheels.inertia, "wheels.inertia")
        return self._per_axle(line) * each + 2 * hub

    def _other_wheels(self) -> float:
        """Inertia of the wheels that no line drives, kg m²."""
        vehicle, wheels, of = self.app.vehicle, self.app.wheels, self.known.of
        each = of(wheels and wheels.inertia, "wheels.inertia")
        if vehicle is None:
            return 2 * each
        per_axle = of(wheels and wheels.per_axle, "wheels.per_axle")
        rear = vehicle.rear_group - vehicle.driven_rear + len(vehicle.auxiliary)
        return each * (2 * (vehicle.front_group - vehicle.driven_front) + per_axle * rear)

    def _slip_length(self) -> FloatArray:
        """Relaxation length of the driven tyres in each state, (S,) m: slip over spring."""
        tyre, of, line = self.app.tyre, self.known.of, self.lines[0]
        stiff = of(tyre and tyre.longitudinal_stiffness, "tyre.longitudinal_stiffness")
        if tyre is not None and tyre.slip_stiffness is not None:
            return np.full(len(self.mass), tyre.slip_stiffness / stiff)
        over = of(None, "tyre.slip_over_load")
        loads: list[float] = []
        for loading, mass in zip(line.load_states, self.mass.tolist(), strict=True):
            load = np.nan
            if self.app.vehicle is not None and loading.load_state is not None:
                rest = driveline_axle_loads(
                    self.app.vehicle, loading.load_state, drives=line.installed.drives,
                    load_share=line.installed.load_share, friction=self.friction,
                    times=loading.load_factor,
                ).rest  # fmt: skip
                axles = max(
                    driven_axle_count(self.app.vehicle, drives=line.installed.drives)
                    * line.installed.load_share, 1.0,
                )  # fmt: skip
                load = float(rest) / axles
            loads.append(load if np.isfinite(load) else mass * g * 0.4)
        return over * np.array(loads) / self._per_axle(line) / stiff


def _tube(shaft: Shaft, number: int, line: str) -> tuple[float, float]:
    """Torsional stiffness and inertia of a shaft's tube between its yokes, N m/rad, kg m²."""
    if shaft.tube is None:
        msg = f"shaft {number} of line {line} needs a tube for its torsional stiffness"
        raise DesignError(msg, about=f"drivelines.{line}.shafts[{number}]")
    length = shaft.tube_length or shaft.length
    return 1 / shaft.torsional_flexibility, shaft.tube.polar_inertia_per_length * length


def _disc(line: Line, joint: int) -> float | None:
    """Torsional stiffness of a flexible disc at a joint, from 0, N m/rad; None if there is none."""
    size = line.joints[joint] if line.joints else None
    return size and size.torsional_stiffness


def spring_and_disc_stiffness(stiffness: Any, disc: float | None) -> Any:
    """Return the stiffness of a spring and a flexible disc ahead of it, N m/rad."""
    return stiffness if disc is None else 1 / (1 / stiffness + 1 / disc)


def _yokes(shaft: Shaft, tube: float) -> tuple[float, float] | None:
    """Inertia of a shaft's front and rear yoke, kg m²; None where unknown."""
    if shaft.yoke_inertias is not None:
        return shaft.yoke_inertias
    together = shaft.yoke_inertia
    if shaft.polar_inertia_given is not None:
        together = max(shaft.polar_inertia_given - tube, 0.0)
    return (together / 2, together / 2) if together > 0 else None
