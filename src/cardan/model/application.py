"""An application: lines in a vehicle, the states to check, what is in the way, the limits."""

from collections.abc import Mapping
from dataclasses import field
from pathlib import Path
from typing import TYPE_CHECKING, get_args

from cardan.core.arrays import ArrayLike
from cardan.core.errors import (
    DesignError,
    FileIssue,
    SourceLocation,
    values_of_first_violating_case,
)
from cardan.core.lazy_dataclass import dataclass
from cardan.core.provenance import Source
from cardan.core.units import Metre, NewtonMetre, Radian, RadianPerSecond
from cardan.core.verdict import Limit
from cardan.model.layout import Layout
from cardan.model.parts import Line
from cardan.model.powertrain import (
    Clutch,
    DualMassFlywheel,
    InterAxleDifferential,
    Launch,
    TorqueConverter,
    WheelRotors,
)
from cardan.model.variants import VariantStudy
from cardan.model.vehicle import (
    Axle,
    DrivenAxles,
    Engine,
    Gearbox,
    Suspension,
    SuspensionState,
    TorqueFlowDirection,
    Tyre,
    Vehicle,
)

if TYPE_CHECKING:  # few applications have one
    from cardan.model.bracket import Bracket

STATE_KIND_WITH_GIVEN_GEOMETRY = "given"
"""The kind of a state whose geometry is given: nothing else says what it is like."""

STATE_KIND_GROUPS: dict[str, frozenset[str]] = {
    "riding": frozenset({"curb", "empty", "gvw", "overload", STATE_KIND_WITH_GIVEN_GEOMETRY}),
    "stops": frozenset({"full rebound", "rebound", "jounce"}),
    "wound up": frozenset({"windup", "windup brake"}),
}
"""Kinds of state that go together: the axle under its load, at the end of its travel, turned."""
STATE_KINDS_AT_LOADED_RIDE_HEIGHT = STATE_KIND_GROUPS["riding"]
STATE_KINDS = (*get_args(SuspensionState), STATE_KIND_WITH_GIVEN_GEOMETRY)

EXPECTED_STATE_KINDS: dict[str, frozenset[str]] = {
    "full rebound": frozenset({"full rebound", "rebound"}),
    "empty": frozenset({"empty", "curb"}),
    **{kind: frozenset({kind}) for kind in ("gvw", "overload", "jounce", "windup", "windup brake")},
}
"""Kinds of state in which an axle on springs is to be checked, and what serves as each."""


@dataclass(frozen=True, slots=True, kw_only=True)
class VehicleState:
    """One state to check every line in.

    `kind` says how the suspension places the axle; None leaves the geometry as given.
    `travel` places the axle by hand instead (rise from the reference state), `pitch` turns
    it (from the reference state, positive as the pinion's nose rises, whichever way it
    faces). What is given here replaces what the vehicle would require: `layouts` by line name,
    torque and speed (of the gearbox output, from which each line has its share).
    """

    name: str
    kind: SuspensionState | None = None
    load: str | None = None
    """Name of the load state whose axle loads count; by default that of `kind`."""
    travel: Metre | None = None
    pitch: Radian | None = None
    articulation: Metre = 0.0
    """Of a tandem: what its forward axle rises over the mean of both, and the other falls."""
    torque: NewtonMetre | None = None
    speed: RadianPerSecond | None = None
    layouts: dict[str, Layout] | None = None
    bearing_offsets: Mapping[str, Mapping[int, tuple[Metre, Metre]]] = field(
        default_factory=dict[str, Mapping[int, tuple[Metre, Metre]]]
    )
    """How far the frame has moved centre bearings sideways and up, between gearbox and axle, by
    line and number from 1: as it sags and twists."""

    @property
    def limit_state_kind(self) -> str:
        """The kind of state that limits know it as: its kind, or what its name says."""
        return self.kind or (
            self.name if self.name in STATE_KINDS else STATE_KIND_WITH_GIVEN_GEOMETRY
        )


@dataclass(frozen=True, slots=True, kw_only=True)
class Obstacle:
    """Something the line must clear: a capsule from `start` to `end` with a radius.

    Coordinates (x, y, z) are those of the driveline's points. `on_axle` obstacles move
    with the axle the line drives; others stay on the frame, or follow
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
class DutyPointInSharesOfMaximum:
    """A share of a life, at shares of a line's largest torque and of its top speed."""

    share: float
    torque_share: float
    speed_share: float


@dataclass(frozen=True, slots=True, kw_only=True)
class DutyCycle:
    """How vehicles of a kind spend their life, whatever their torque and speed."""

    name: str
    description: str
    """A sentence on what such a vehicle does."""
    source: Source
    points: tuple[DutyPointInSharesOfMaximum, ...]


def duty_cycle_points(
    cycle: DutyCycle, *, torque: NewtonMetre, speed: RadianPerSecond
) -> tuple[DutyPoint, ...]:
    """Return what a duty cycle requires of one vehicle.

    Parameters
    ----------
    cycle
        Shares of time, of torque and of speed.
    torque : N m
        Largest torque at the gearbox output: the smaller of what the lowest gear gives and
        the tyres hold, at gvw.
    speed : rad/s
        Top speed of the gearbox output.
    """
    return tuple(
        DutyPoint(share=p.share, torque=p.torque_share * torque, speed=p.speed_share * speed)
        for p in cycle.points
    )


@dataclass(frozen=True, slots=True, kw_only=True)
class PermittedAdjustment:
    """Something `fix` may move, and how far: value range around what is installed.

    `adjustment_key` is a key of `cardan.model.adjustments.ADJUSTMENTS`. `part` counts from 1
    (bearing or shaft). `hold` keeps it where it is.
    """

    adjustment_key: str
    part: int
    low: float
    high: float
    line: str = "main"
    hold: bool = False
    step: float = 0.0
    """In which a workshop sets it; 0: any."""


@dataclass(frozen=True, slots=True, kw_only=True)
class InstalledLine:
    """A line as installed: its parts, its layout in the reference state, its axle.

    The layout runs with the flow of torque: x points along it, z up, y to the right of it.
    So a line that runs forward, to a front axle or from an engine behind its axle, lies in
    the vehicle's frame turned half round about z, and every line has its gearbox end first
    and its pinion facing back at it.
    """

    line: Line
    layout: Layout
    axle: Axle | None = None
    torque_ratio: float = 1.0
    """Torque of this line over its share of the gearbox output's: a transfer case's gears."""
    torque_share: float = 1.0
    """What differentials leave it of that; so much of the vehicle's push is of its wheels."""
    speed_ratio: float = 1.0
    drives: DrivenAxles = "rear"
    """Which axles turn behind this line; its pinion sits on one of them, or, where it
    drives all, on a transfer case held by the frame."""
    runs: TorqueFlowDirection | None = None
    """Which way torque flows in the vehicle; None: forward to a front axle, else rearward."""
    load_share: float = 1.0
    """Share of their load that is on wheels behind this line: 0.5 between two axles."""
    output_joint: tuple[Metre, Metre] | None = None
    """Joint 1 from the centre of the wheels of the axle it rides on, (x, z), where it
    leaves an axle (an inter-axle shaft); None where the frame holds it."""
    suspension: Suspension | None = None
    """What moves this line's axle, if not the application's; a front axle needs its own."""

    def __post_init__(self) -> None:
        if self.layout.points.shape[-2] != self.line.joint_count:
            msg = (
                f"line {self.line.name} has {self.line.joint_count} joints, its layout "
                f"{self.layout.points.shape[-2]}"
            )
            raise DesignError(msg)
        share = self.load_share
        if wrong := values_of_first_violating_case((share > 0) & (share <= 1), share):
            msg = (
                f"load_share of line {self.line.name} must be above 0 and at most 1, got "
                f"{wrong[0]:g}"
            )
            raise DesignError(msg)

    @property
    def forward(self) -> bool:
        """Whether torque flows forward: then the axle's pinion faces rearward."""
        return (self.runs or ("forward" if self.drives == "front" else "rearward")) == "forward"

    def starts_at_axle_of(self, other: "InstalledLine") -> bool:
        """Whether this line starts at the axle that another ends at."""
        ends = other.output_joint is None and other.drives == self.drives
        return self.output_joint is not None and ends


@dataclass(frozen=True, slots=True, kw_only=True)
class GearboxAndAxleRotors:
    """What turns with the lines at both ends, and damps them; None where unknown.

    Attributes
    ----------
    axle_inertia, axle_stiffness : kg m², N m/rad
        Of what turns behind the pinion, reflected to it, and of the spring in between.
    gearbox_inertia, gearbox_stiffness : kg m², N m/rad
        Of what turns with the gearbox flange, and of the spring to the uniformly turning
        engine; without them the flange itself turns uniformly.
    damping_ratio : 1
        Of the first torsional mode.
    rubber_loss : 1
        Loss factor of the centre bearings' rubber.
    """

    axle_inertia: float | None = None
    axle_stiffness: float | None = None
    gearbox_inertia: float | None = None
    gearbox_stiffness: float | None = None
    damping_ratio: float | None = None
    rubber_loss: float | None = None


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class ApplicationSourceText:
    """The text an application was read from, so that it can be read again with other numbers.

    Attributes
    ----------
    text, name, folder
        The text, what errors call it, and where the files that it names lie.
    allow_outside
        Whether those may lie outside that folder.
    changes
        Numbers that stand in place of the text's own, by address, in the text's units.
    numbers
        Every number of the design by its address, in the text's units, as read.
    fixed_numbers
        The numbers in addition to the design, of limits and ranges, which have no variants in
        arrays.
    referenced_files
        The files that the text names, and that were read with it.
    application
        What was read: where a part has been replaced since, the text says something else.
    """

    text: str
    name: str
    folder: Path | None = None
    allow_outside: bool = False
    changes: Mapping[str, ArrayLike] = field(default_factory=dict[str, ArrayLike])
    numbers: Mapping[str, ArrayLike] = field(default_factory=dict[str, ArrayLike])
    fixed_numbers: Mapping[str, ArrayLike] = field(default_factory=dict[str, ArrayLike])
    referenced_files: tuple[Path, ...] = ()
    application: "Application | None" = None


@dataclass(frozen=True, slots=True, kw_only=True)
class ReportIdentification:
    """What an approval sheet says of whom and what it is for; "" where it is not given.

    Attributes
    ----------
    customer, company
        For whom the report is made, and who makes it.
    vehicle, drawing, revision
        The vehicle, the drawing of its driveline, and the revision of that.
    author, checker, approver
        Names for the signatures.
    """

    customer: str = ""
    company: str = ""
    vehicle: str = ""
    drawing: str = ""
    revision: str = ""
    author: str = ""
    checker: str = ""
    approver: str = ""


@dataclass(frozen=True, slots=True, kw_only=True)
class Application:
    """An application: vehicle, lines, states and limits of one approval, in SI."""

    title: str
    lines: tuple[InstalledLine, ...]
    states: tuple[VehicleState, ...]
    limits: tuple[Limit, ...]
    profile: str
    stroke_states: tuple[VehicleState, ...] = ()
    """States that the suspension goes through, where `states` are some of these alone."""
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
    duty_cycle: DutyCycle | None = None
    """A cycle named in place of `duty`; `duty_cycle_points` makes points of it."""
    adjustables: tuple[PermittedAdjustment, ...] = ()
    bracket: "Bracket | None" = None
    torsion: GearboxAndAxleRotors | None = None
    clutch: Clutch | None = None
    dual_mass_flywheel: DualMassFlywheel | None = None
    converter: TorqueConverter | None = None
    inter_axle: InterAxleDifferential | None = None
    wheels: WheelRotors | None = None
    launches: tuple[Launch, ...] = ()
    variants: VariantStudy | None = None
    """What a study of the application's variants computes."""
    report: ReportIdentification = ReportIdentification()
    """What its reports say of customer, drawing and signatures."""
    placeholders: tuple[str, ...] = ()
    """Keys whose values are not the vehicle's yet: no study evaluates it."""
    electric: bool = False
    """Whether a motor drives: nothing fires, and it turns from standstill on."""
    prime_mover_factor: float = 1.25
    shock_factor: float = 1.0
    include_gravity: bool = False
    include_unbalance: bool = False
    warnings: tuple[FileIssue, ...] = ()
    """What looked wrong while the file was read, though it could be."""
    written: ApplicationSourceText | None = field(default=None, compare=False, repr=False)
    """The text it was read from; None where it was made otherwise."""
    source_locations: Mapping[str, SourceLocation] = field(
        default_factory=dict[str, SourceLocation], compare=False, repr=False
    )
    """Where everything stands in the file, by the key its errors print:
    `driveline.shafts[2].tube.wall_mm`."""

    def __repr__(self) -> str:
        lines, states = (f"{name}={len(of)}" for name, of in
                         (("lines", self.lines), ("states", self.states)))  # fmt: skip
        return f"Application({self.title!r}, {lines}, {states}, profile={self.profile!r})"

    def is_given(self, key: str) -> bool:
        """Return whether its file gives a key, `tyre.friction`; so is what was made otherwise."""
        return self.written is None or key in self.source_locations

    @property
    def has_rotor_data(self) -> bool:
        """Whether it says what turns and springs around its lines, or how it starts from rest."""
        parts = (
            self.torsion, self.clutch, self.dual_mass_flywheel, self.converter, self.inter_axle,
            self.wheels,
        )  # fmt: skip
        return bool(self.launches) or any(part is not None for part in parts)


def missing_state_kinds(application: Application) -> tuple[str, ...]:
    """Return the kinds of state that the limits apply to, and that the application lacks.

    Nothing of a machine or a bare line: no axle of these rides on springs.
    """
    if application.vehicle is None and application.suspension is None:
        return ()
    given = {state.limit_state_kind for state in application.states}
    kinds = [limit.states for limit in application.limits]
    asked = frozenset(STATE_KINDS) if None in kinds else frozenset().union(*filter(None, kinds))
    return tuple(
        kind for kind, alike in EXPECTED_STATE_KINDS.items() if kind in asked and not alike & given
    )


def require_no_placeholders(application: Application) -> None:
    """Refuse an application of which some values are not the vehicle's yet.

    Raises
    ------
    DesignError
        With the keys that hold placeholders.
    """
    if application.placeholders:
        keys = ", ".join(application.placeholders)
        msg = f"these keys still hold placeholders: {keys}; enter the vehicle's values first"
        raise DesignError(msg)
