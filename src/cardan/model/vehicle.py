"""The vehicle around a line: engine, gearbox, axle, tyre, suspension, load states. All SI."""

import itertools
from dataclasses import dataclass, field
from typing import Literal, TypeAlias

from cardan.base.errors import DesignError
from cardan.base.units import Kilogram, Metre, Newton, NewtonMetre, Radian, RadianPerSecond

Drive: TypeAlias = Literal["4x2", "4x4", "6x2", "6x4", "6x6", "8x2", "8x4", "8x8"]


@dataclass(frozen=True, slots=True, kw_only=True)
class Engine:
    """Full-load torque over speed, as points joined by straight lines."""

    speed: tuple[RadianPerSecond, ...]
    torque: tuple[NewtonMetre, ...]
    brake_torque: NewtonMetre = 0.0
    """Engine brake or retarder torque at the crankshaft; coast."""

    def __post_init__(self) -> None:
        if len(self.speed) != len(self.torque) or not self.speed:
            msg = "an engine needs as many torques as speeds, and at least one of each"
            raise DesignError(msg)
        if any(b <= a for a, b in zip(self.speed, self.speed[1:], strict=False)):
            msg = "the speeds of an engine curve must rise"
            raise DesignError(msg)


@dataclass(frozen=True, slots=True, kw_only=True)
class Gearbox:
    """Gear ratios, lowest gear (largest ratio) first, with what else multiplies torque."""

    ratios: tuple[float, ...]
    efficiency: float = 1.0
    converter_ratio: float = 1.0
    """Stall torque ratio of a converter; 1 without one."""
    transfer_ratio: float = 1.0
    """Low range of a transfer case; 1 without one."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Axle:
    """The driven axle of a line.

    `pinion_joint` is the joint centre from the wheel centre, (x, z), where x is rearward
    (a pinion pointing forward sits at negative x) and z up.
    """

    ratio: float
    efficiency: float = 1.0
    pinion_joint: tuple[Metre, Metre] = (0.0, 0.0)
    torque_share: float = 1.0
    """Share of the vehicle's torque that this line carries."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Tyre:
    """Tyre and ground."""

    static_radius: Metre
    friction: float = 0.8
    dynamic_radius: Metre | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class LoadState:
    """How the vehicle is loaded: mass and centre of gravity, or the axle loads themselves.

    `rear_load` is that of the whole rear group (a single axle or a bogie).
    """

    name: str
    mass: Kilogram | None = None
    cg_behind_front: Metre | None = None
    cg_height: Metre | None = None
    front_load: Newton | None = None
    rear_load: Newton | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class Vehicle:
    """Drive configuration and load states.

    `wheelbase` runs from the front axle (or the middle of two) to the rear axle (or the
    bogie's load point). `driven_share` is the share of the rear group's load on its driven
    axles. `grade` is the slope's angle, up positive.
    """

    drive: Drive
    wheelbase: Metre
    driven_share: float = 1.0
    grade: Radian = 0.0
    loads: tuple[LoadState, ...] = ()


@dataclass(frozen=True, slots=True, kw_only=True)
class Spring:
    """A spring as a table of load over deflection, joined by straight lines.

    Beyond its ends it goes on with its outer slopes. The stated rates, if any, are only
    compared: the table is the truth.
    """

    load: tuple[Newton, ...]
    deflection: tuple[Metre, ...]
    stated_rates: tuple[float, ...] = ()

    def __post_init__(self) -> None:
        if len(self.load) != len(self.deflection) or len(self.load) < 2:
            msg = "a spring needs as many loads as deflections, and at least two of each"
            raise DesignError(msg)
        for what, values in (("loads", self.load), ("deflections", self.deflection)):
            if any(not b > a for a, b in itertools.pairwise(values)):
                msg = f"the {what} of a spring must rise"
                raise DesignError(msg)


@dataclass(frozen=True, slots=True, kw_only=True)
class Linkage:
    """How the axle moves fore and aft and pitches as it rises.

    A leaf spring is an equivalent link of `radius` (about three quarters of the front half
    length) from its pivot ahead of the axle, at `angle` above the horizontal in the
    reference state (pivot above axle positive), with `pitch_rate` rad per metre of rise.
    A table from CAD replaces it: travel (up positive) against dx (rearward), pitch.
    """

    radius: Metre | None = None
    angle: Radian = 0.0
    pitch_rate: float = 0.0
    travel: tuple[Metre, ...] = ()
    dx: tuple[Metre, ...] = ()
    pitch: tuple[Radian, ...] = ()


@dataclass(frozen=True, slots=True, kw_only=True)
class Suspension:
    """What moves the axle: springs, linkage, wind-up.

    `reference` names the state in which the driveline's geometry is given. Stiffness in
    wind-up is N m/rad. Deflections of full rebound and jounce replace what follows from the
    spring, where check strap or bump stop act first.
    """

    spring: Spring
    springs_per_axle: int = 2
    unsprung_mass: Kilogram = 0.0
    linkage: Linkage = field(default_factory=Linkage)
    windup_stiffness: float | None = None
    brake_torque: NewtonMetre = 0.0
    """Brake torque on the axle housing; coast wind-up."""
    reference: str = "gvw"
    full_rebound_deflection: Metre | None = None
    jounce_deflection: Metre | None = None
