"""An application: lines in a vehicle, the states to check, what is in the way, the limits."""

from dataclasses import dataclass
from typing import Literal, TypeAlias

from cardan.base.errors import DesignError
from cardan.base.units import Metre, NewtonMetre, Radian, RadianPerSecond
from cardan.base.verdict import Limit
from cardan.model.layout import Layout
from cardan.model.parts import Line
from cardan.model.vehicle import Axle, Engine, Gearbox, Suspension, Tyre, Vehicle

SuspensionState: TypeAlias = Literal[
    "full rebound", "rebound", "curb", "empty", "gvw", "overload", "jounce",
    "windup", "windup brake",
]  # fmt: skip


@dataclass(frozen=True, slots=True, kw_only=True)
class State:
    """One state to check every line in.

    `kind` says how the suspension places the axle; None leaves the geometry as given.
    `travel` places the axle by hand instead (rise from the reference state). What is given
    here replaces what the vehicle would ask: `layouts` by line name, torque, speed.
    """

    name: str
    kind: SuspensionState | None = None
    load: str | None = None
    """Name of the load state whose axle loads count; by default that of `kind`."""
    travel: Metre | None = None
    pitch: Radian | None = None
    torque: NewtonMetre | None = None
    speed: RadianPerSecond | None = None
    layouts: dict[str, Layout] | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class Obstacle:
    """Something the line must clear: a capsule from `start` to `end` with a radius.

    Coordinates (x, y, z) are those of the driveline's points. `on_axle` obstacles move
    with the axle the line drives; others stay on the frame, or follow `moves_with` of
    `travel_share` times its travel (an auxiliary axle's beam).
    """

    name: str
    start: tuple[Metre, Metre, Metre]
    end: tuple[Metre, Metre, Metre]
    radius: Metre = 0.0
    travel_share: float = 0.0
    line: str = "main"


@dataclass(frozen=True, slots=True, kw_only=True)
class DutyPoint:
    """A share of the life spent at a torque, speed and (where given) joint angle."""

    share: float
    torque: NewtonMetre
    speed: RadianPerSecond
    angle: Radian | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class Adjustable:
    """Something `fix` may move, and how far: value range around what is installed.

    `what` is one of bearing height (z), bearing side (y), shim (axle pinion pitch), phase.
    `part` counts from 1 (bearing or shaft). `hold` keeps it where it is.
    """

    what: Literal["bearing_height", "bearing_side", "shim", "phase"]
    part: int
    low: float
    high: float
    line: str = "main"
    hold: bool = False


@dataclass(frozen=True, slots=True, kw_only=True)
class Installed:
    """A line as installed: its parts, its layout in the reference state, its axle."""

    line: Line
    layout: Layout
    axle: Axle | None = None
    torque_ratio: float = 1.0
    """Torque of this line over that of the gearbox output (inter-axle shares and the like)."""
    speed_ratio: float = 1.0

    def __post_init__(self) -> None:
        if self.layout.points.shape[-2] != self.line.joint_count:
            msg = (
                f"line {self.line.name} has {self.line.joint_count} joints, its layout "
                f"{self.layout.points.shape[-2]}"
            )
            raise DesignError(msg)


@dataclass(frozen=True, slots=True, kw_only=True)
class Application:
    """Everything one approval is about."""

    title: str
    lines: tuple[Installed, ...]
    states: tuple[State, ...]
    limits: tuple[Limit, ...]
    profile: str
    torque: NewtonMetre | None = None
    coast_torque: NewtonMetre | None = None
    speed: RadianPerSecond | None = None
    vehicle: Vehicle | None = None
    engine: Engine | None = None
    gearbox: Gearbox | None = None
    tyre: Tyre | None = None
    suspension: Suspension | None = None
    obstacles: tuple[Obstacle, ...] = ()
    duty: tuple[DutyPoint, ...] = ()
    adjustables: tuple[Adjustable, ...] = ()
    prime_mover_factor: float = 1.25
    shock_factor: float = 1.0
    include_gravity: bool = False
    include_unbalance: bool = False
