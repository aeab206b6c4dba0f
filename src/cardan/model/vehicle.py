"""The vehicle around a line: engine, gearbox, axle, tyre, suspension, load states. All SI."""

import itertools
from dataclasses import field
from typing import Any, Literal, TypeAlias, get_args

import numpy as np

from cardan.core.errors import DesignError, require_positive, values_of_first_violating_case
from cardan.core.lazy_dataclass import dataclass
from cardan.core.units import Kilogram, Metre, Newton, NewtonMetre, Radian, RadianPerSecond
from cardan.model.powertrain import AxleRotors, GearboxRotors

DriveConfiguration: TypeAlias = Literal["4x2", "4x4", "6x2", "6x4", "6x6", "8x2", "8x4", "8x8"]
DrivenAxles: TypeAlias = Literal["rear", "front", "all"]
"""Which axles a line turns."""
TorqueFlowDirection: TypeAlias = Literal["rearward", "forward"]
"""Which way torque flows along a line, in the vehicle."""

StaticSuspensionState: TypeAlias = Literal[
    "full rebound", "rebound", "curb", "empty", "gvw", "overload", "jounce"
]
"""How springs place an axle that no torque winds up."""
SuspensionState: TypeAlias = Literal[StaticSuspensionState, "windup", "windup brake"]


def _rising(part: str, **columns: tuple[float, ...]) -> None:
    """Refuse columns of a table that do not rise; a nan does not rise either."""
    for name, values in columns.items():
        if not all(np.all(b > a) for a, b in itertools.pairwise(values)):
            msg = f"the {name} of {part} must rise"
            raise DesignError(msg)


@dataclass(frozen=True, slots=True, kw_only=True)
class Engine:
    """Full-load torque over speed, as points joined by straight lines."""

    speed: tuple[RadianPerSecond, ...]
    torque: tuple[NewtonMetre, ...]
    brake_torque: NewtonMetre | None = None
    """Engine brake or retarder torque at the crankshaft, for overrun; None where not known."""
    inertia: float | None = None
    """With flywheel and clutch cover, kg m²."""
    displacement: float | None = None
    """m³."""
    cylinders: int | None = None
    idle: RadianPerSecond | None = None
    governed: RadianPerSecond | None = None
    """Where the governor leaves nothing; None is the last speed of the curve."""
    firing_torque: NewtonMetre | None = None
    """0-to-peak of the firing order at full load."""
    power: float | None = None
    """Rated power, W: what the curve is held against."""

    def __post_init__(self) -> None:
        if len(self.speed) != len(self.torque) or not self.speed:
            msg = "an engine needs as many torques as speeds, and at least one of each"
            raise DesignError(msg)
        _rising("an engine curve", speeds=self.speed)

    @property
    def full_load(self) -> tuple[tuple[RadianPerSecond, ...], tuple[NewtonMetre, ...]]:
        """Speeds and torques up to governed speed, rad/s and N m.

        Beyond its last point the curve falls straight to nothing there; of points beyond
        governed speed nothing is left.
        """
        top = self.governed
        if top is None:
            return self.speed, self.torque
        droops = np.greater(top, self.speed[-1])
        ends = np.where(droops, top, self.speed[-1]), np.where(droops, 0.0, self.torque[-1])
        points = (*zip(self.speed, self.torque, strict=True), ends)
        speed: list[Any] = [np.minimum(self.speed[0], top)]
        torque: list[Any] = [self.torque[0]]
        for (before, start), (there, end) in itertools.pairwise(points):
            wide = np.where(there > before, there - before, 1.0)
            cut = start + np.clip((top - before) / wide, 0.0, 1.0) * (end - start)
            torque.append(np.where(np.less(before, top), cut, torque[-1]))
            speed.append(np.minimum(there, top))
        return tuple(speed), tuple(torque)

    @property
    def peak_torque(self) -> NewtonMetre:
        """Largest torque that governed speed leaves, N m."""
        return np.max(np.stack(np.broadcast_arrays(*self.full_load[1])), axis=0)


@dataclass(frozen=True, slots=True, kw_only=True)
class Gearbox:
    """Gear ratios, lowest gear (largest ratio) first, with what else multiplies torque."""

    ratios: tuple[float, ...]
    efficiency: float = 1.0
    converter_ratio: float = 1.0
    """Stall torque ratio of a converter; 1 without one."""
    transfer_ratio: float = 1.0
    """Low range of a transfer case; 1 without one."""
    reverse_ratio: float | None = None
    """Engine speed over output speed in reverse; None where unknown, or nothing reverses."""
    retarder_torque: NewtonMetre | None = None
    """Torque of a retarder at the gearbox output, for overrun; None where not known."""
    rotors: GearboxRotors = field(default_factory=GearboxRotors)

    def __post_init__(self) -> None:
        if not self.ratios:
            msg = "a gearbox needs at least one ratio"
            raise DesignError(msg)
        require_positive("a gearbox", **{f"ratio {k}": r for k, r in enumerate(self.ratios, 1)})
        require_positive(
            "a gearbox",
            efficiency=self.efficiency,
            converter_ratio=self.converter_ratio,
            transfer_ratio=self.transfer_ratio,
            reverse_ratio=self.reverse_ratio,
        )
        held = self.retarder_torque
        if held is not None and (wrong := values_of_first_violating_case(held >= 0, held)):
            msg = f"retarder_torque of a gearbox must be 0 or more, got {wrong[0]:g}"
            raise DesignError(msg)


@dataclass(frozen=True, slots=True, kw_only=True)
class Axle:
    """The driven axle of a line.

    `pinion_joint` is the joint centre from the wheel centre, (x, z), where x runs with the
    flow of torque, as in the line's layout (a pinion facing the gearbox sits at negative
    x, on a rear axle and on a front axle alike) and z up.
    """

    ratio: float
    efficiency: float = 1.0
    pinion_joint: tuple[Metre, Metre] = (0.0, 0.0)
    rotors: AxleRotors = field(default_factory=AxleRotors)

    def __post_init__(self) -> None:
        require_positive("an axle", ratio=self.ratio, efficiency=self.efficiency)


@dataclass(frozen=True, slots=True, kw_only=True)
class Tyre:
    """Tyre and ground."""

    static_radius: Metre
    friction: float = 0.8
    dynamic_radius: Metre | None = None
    longitudinal_stiffness: float | None = None
    """Of one tyre, N/m."""
    slip_stiffness: Newton | None = None
    """Of one tyre, force over slip, N."""

    def __post_init__(self) -> None:
        require_positive("a tyre", static_radius=self.static_radius, friction=self.friction)


@dataclass(frozen=True, slots=True, kw_only=True)
class LoadState:
    """How the vehicle is loaded: mass and centre of gravity, or the axle loads themselves.

    `rear_load` is that of the whole rear group (a single axle or a bogie), `front_load`
    that of all front axles; a vehicle's auxiliary axles carry their own load in addition.
    With a mass one of the two is enough. Without `cg_height` nothing is transferred under
    traction.
    """

    name: str
    mass: Kilogram | None = None
    cg_behind_front: Metre | None = None
    cg_height: Metre | None = None
    front_load: Newton | None = None
    rear_load: Newton | None = None
    auxiliary_lifted: bool = False
    """Whether the vehicle's auxiliary axles are off the ground."""

    def __post_init__(self) -> None:
        known = [v is not None for v in (self.mass, self.front_load, self.rear_load)]
        by_loads, by_mass = sum(known) == 2, known == [True, False, False]
        if by_mass == (self.cg_behind_front is None) or not (by_loads or by_mass):
            msg = (
                f"load state {self.name} needs mass and cg_behind_front, or two of mass, "
                "front_load and rear_load without cg_behind_front"
            )
            raise DesignError(msg)
        require_positive(f"load state {self.name}", mass=self.mass, cg_height=self.cg_height)


@dataclass(frozen=True, slots=True, kw_only=True)
class AuxiliaryAxle:
    """An undriven axle on air: it carries the same load whatever the other axles do.

    `behind_front` is its distance from where the wheelbase starts. An auxiliary axle that
    shares a bogie's load mechanically is no such axle: `Vehicle.driven_share` says its part.
    """

    behind_front: Metre
    load: Newton


@dataclass(frozen=True, slots=True, kw_only=True)
class Vehicle:
    """Drive configuration and load states.

    `wheelbase` runs from the front axle (or the middle of two) to the rear axle (or the
    bogie's load point). `grade` is the slope's angle, up positive. `drive` counts points on
    the ground and driven points, two to an axle.
    """

    drive: DriveConfiguration
    wheelbase: Metre
    driven_share: float | None = None
    """Share of the rear group's load on its driven axles; None: all its axles alike."""
    grade: Radian = 0.0
    loads: tuple[LoadState, ...] = ()
    front_axles: int | None = None
    """None: two on an 8x, else one."""
    front_driven: bool | None = None
    """None: only where every axle is driven (4x4, 6x6, 8x8)."""
    auxiliary: tuple[AuxiliaryAxle, ...] = ()

    def __post_init__(self) -> None:
        require_positive("a vehicle", wheelbase=self.wheelbase)
        share = self.driven_share
        if share is not None and (
            wrong := values_of_first_violating_case((share >= 0) & (share <= 1), share)
        ):
            msg = f"driven_share of a vehicle must be within 0 and 1, got {wrong[0]:g}"
            raise DesignError(msg)
        if self.rear_group < 1:
            msg = f"a {self.drive} with {len(self.auxiliary)} auxiliary axles has no rear axle left"
            raise DesignError(msg)
        fixed = {0: 0.0, self.rear_group: 1.0}.get(self.driven_rear)
        if share is None or fixed is None:
            return
        if wrong := values_of_first_violating_case(share == fixed, share):
            msg = (
                f"driven_share of a {self.drive} whose rear group has {self.driven_rear} of "
                f"{self.rear_group} axles driven must be {fixed:g}, got {wrong[0]:g}"
            )
            raise DesignError(msg)

    @property
    def axle_count(self) -> int:
        """Number of axles."""
        return int(self.drive[0]) // 2

    @property
    def driven_count(self) -> int:
        """Number of driven axles."""
        return int(self.drive[2]) // 2

    @property
    def front_group(self) -> int:
        """Number of front axles."""
        if self.front_axles is not None:
            return self.front_axles
        return 2 if self.axle_count == 4 else 1

    @property
    def rear_group(self) -> int:
        """Number of axles in the rear group, auxiliary axles on air apart."""
        return self.axle_count - self.front_group - len(self.auxiliary)

    @property
    def driven_front(self) -> int:
        """Number of driven front axles: all of them or none."""
        driven = self.front_driven
        all_wheel = self.driven_count == self.axle_count
        return self.front_group if (all_wheel if driven is None else driven) else 0

    @property
    def driven_rear(self) -> int:
        """Number of driven axles in the rear group."""
        return min(max(self.driven_count - self.driven_front, 0), self.rear_group)

    @property
    def rear_share(self) -> float:
        """Share of the rear group's load on its driven axles."""
        if self.driven_share is not None:
            return self.driven_share
        return self.driven_rear / self.rear_group


@dataclass(frozen=True, slots=True, kw_only=True)
class Spring:
    """A spring as a table of load over deflection, joined by straight lines.

    Beyond its ends it goes on with its outer slopes. The stated rates, if any, are only
    compared: the table is the truth. It `ends` where it is metal to metal; one that stands for
    rates does not.
    """

    load: tuple[Newton, ...]
    deflection: tuple[Metre, ...]
    stated_rates: tuple[float, ...] = ()
    ends: bool = True

    def __post_init__(self) -> None:
        if len(self.load) != len(self.deflection) or len(self.load) < 2:
            msg = "a spring needs as many loads as deflections, and at least two of each"
            raise DesignError(msg)
        _rising("a spring", loads=self.load, deflections=self.deflection)


@dataclass(frozen=True, slots=True, kw_only=True)
class Linkage:
    """How the axle moves fore and aft and pitches as it rises.

    A leaf spring is an equivalent link of `radius` (about three quarters of the front half
    length) from its pivot ahead of the axle, at `angle` above the horizontal in the
    reference state (pivot above axle positive), with `pitch_rate` rad per metre of rise.
    A table from CAD replaces it: travel (up positive) against dx (rearward), pitch. Pitch
    is positive as the pinion's nose rises, whichever way it faces: as a shim's.
    """

    radius: Metre | None = None
    angle: Radian = 0.0
    pitch_rate: float = 0.0
    travel: tuple[Metre, ...] = ()
    dx: tuple[Metre, ...] = ()
    pitch: tuple[Radian, ...] = ()

    def __post_init__(self) -> None:
        require_positive("a linkage", radius=self.radius)
        columns = [c for c in (self.dx, self.pitch) if c]
        if any(len(c) != len(self.travel) for c in columns) or (columns and len(self.travel) < 2):
            msg = "a linkage table needs as many dx and pitch as travel, and at least two"
            raise DesignError(msg)
        _rising("a linkage", travel=self.travel)


@dataclass(frozen=True, slots=True, kw_only=True)
class Suspension:
    """What moves the axle: springs, linkage, wind-up.

    `reference` names the state in which the driveline's geometry is given. Stiffness in
    wind-up is N m/rad. Deflections of full rebound and bump replace what follows from the
    spring, where check strap or bump stop act first. `unsprung_mass` is that of one axle
    with its wheels.
    """

    spring: Spring
    springs_per_axle: int = 2
    unsprung_mass: Kilogram = 0.0
    linkage: Linkage = field(default_factory=Linkage)
    windup_stiffness: float | None = None
    windup_loss_factor: float | None = None
    brake_torque: NewtonMetre = 0.0
    """Brake torque on the axle housing; 0 takes what the tyres can hold."""
    reference: StaticSuspensionState = "gvw"
    full_rebound_deflection: Metre | None = None
    jounce_deflection: Metre | None = None
    squats: bool = True
    """Whether what the tyres pull moves the axle on its springs."""
    axle_to_frame: Metre | None = None
    """From the centre of the axle up to the frame, in the reference state."""

    def __post_init__(self) -> None:
        require_positive(
            "a suspension",
            springs_per_axle=self.springs_per_axle, windup_stiffness=self.windup_stiffness,
        )  # fmt: skip
        if wrong := values_of_first_violating_case(self.unsprung_mass >= 0, self.unsprung_mass):
            msg = f"unsprung_mass of a suspension must be 0 or more, got {wrong[0]:g}"
            raise DesignError(msg)
        if self.reference not in get_args(StaticSuspensionState):
            fit = ", ".join(get_args(StaticSuspensionState))
            msg = f"reference of a suspension must be one of {fit}: {self.reference}"
            raise DesignError(msg)
