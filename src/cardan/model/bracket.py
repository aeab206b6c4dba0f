"""The bracket a centre bearing hangs in: its shape, gauges on it, loads it must carry.

The bracket's frame is the vehicle's (x rearward, y to the right, z up) with its origin at
the bearing's centre.
"""

from collections.abc import Mapping
from dataclasses import field
from typing import Literal, TypeAlias

from cardan.core.arrays import FloatArray
from cardan.core.errors import DesignError
from cardan.core.lazy_dataclass import dataclass
from cardan.core.provenance import SOURCE_ASSUMED, Source
from cardan.core.units import Kilogram, Metre, MPa, Pascal, deg, mm
from cardan.model.bracket_compliance import DEFAULT_BRACKET_LOSS_FACTOR
from cardan.model.material import STEEL, Material, MetalKind

Vector3: TypeAlias = tuple[float, float, float]

FatigueZone: TypeAlias = Literal["sheet", "cut edge", "weld toe", "bolt border"]
"""Where on a bracket a crack may start: each has an S-N curve, and a stress, of its own."""
FATIGUE_ZONES: tuple[FatigueZone, ...] = ("sheet", "cut edge", "weld toe", "bolt border")

FlangeBoundaryCondition: TypeAlias = Literal["sliding", "clamped"]
"""How the frame holds a flange: its washers alone, free to slide; or its whole plane."""


_EQUAL = 1e-9
"""Share by which lengths may differ and be equal: 2.2 times 11 is a little more than 24.2."""


def _above_zero(part: str, **lengths: Metre) -> None:
    """Refuse lengths that are not above zero; the comparison refuses nan too."""
    for name, value in lengths.items():
        if not value > 0:
            msg = f"{name} of {part} must be above 0, got {value / mm:g} mm"
            raise DesignError(msg)


def _at_most(
    part: str, name: str, value: Metre, room: Metre, why: str, *, times: float = 1.0
) -> None:
    """Refuse a length of which so many times do not fit, with what there is room for, and why."""
    if not times * value <= room * (1 + _EQUAL):
        # What is reported must fit as it stands, so it is cut, not rounded.
        fits = (max(room / times, 0.0) / mm * 100 + 1e-6) // 1 / 100
        msg = (
            f"{name} of {part} is {value / mm:g} mm, but may be {fits:g} mm, by {why}: lower it, "
            "or make room"
        )
        if not fits:
            msg = f"{name} of {part} is {value / mm:g} mm, but has no room, by {why}: make some"
        raise DesignError(msg)


@dataclass(frozen=True, slots=True, kw_only=True)
class UShape:
    """A sheet bent to a U: the bearing lies in its round, two flanges bolt up to the frame.

    `width` runs along the shaft, `height` from the bearing's centre up to the mounting
    plane, `flange` outwards from the leg. Each flange has two bolts, `bolt_pitch` apart.
    `gusset` is the thickness of a rib under each flange (0: none), `gusset_height` how far
    it reaches down the leg, `fillet` the throat of its weld.
    """

    seat_diameter: Metre
    width: Metre
    thickness: Metre
    height: Metre
    flange: Metre
    bend_radius: Metre
    bolt_diameter: Metre
    bolt_pitch: Metre
    gusset: Metre = 0.0
    gusset_height: Metre = 0.0
    fillet: Metre = 3 * mm

    def __post_init__(self) -> None:
        part = "a U bracket"
        _above_zero(
            part, seat_diameter=self.seat_diameter, width=self.width, thickness=self.thickness,
            height=self.height, flange=self.flange, bend_radius=self.bend_radius,
            bolt_diameter=self.bolt_diameter, bolt_pitch=self.bolt_pitch, fillet=self.fillet,
        )  # fmt: skip
        t, r = self.thickness, self.bend_radius
        _at_most(part, "bend_radius", r, self.height - t, "its height above the bearing")
        # A bolt bears on a ring of twice its diameter.
        room = self.width - 2.2 * self.bolt_diameter
        _at_most(part, "bolt_pitch", self.bolt_pitch, room, "the washers on its width")
        _at_most(part, "bolt_diameter", self.bolt_diameter, self.flange - r,
                 "the flange beyond the bend, for a washer", times=2.2)  # fmt: skip
        _at_most(part, "bolt_diameter", self.bolt_diameter, self.bolt_pitch,
                 "the pitch, for two washers", times=2.2)  # fmt: skip
        if self.gusset:
            _above_zero(part, gusset=self.gusset, gusset_height=self.gusset_height)
            weld = self.gusset + 2 * self.fillet
            room = self.bolt_pitch - 2.2 * self.bolt_diameter
            _at_most(part, "gusset with its weld", weld, room, "the washers either side of it")
            room = self.height - t - self.fillet
            _at_most(part, "gusset_height", self.gusset_height, room, "the leg above the seat")
            room = self.gusset_height - r
            _at_most(part, "fillet", self.fillet, room, "the gusset below the bend", times=3)
            room = 0.85 * self.flange - r
            _at_most(part, "fillet", self.fillet, room, "the gusset beyond the bend", times=3)

    @property
    def bolt_positions(self) -> tuple[Vector3, ...]:
        """Centres of the bolt holes on the mounting plane."""
        r = self.seat_diameter / 2 + self.thickness
        y = r + (self.bend_radius + self.flange) / 2
        x = self.bolt_pitch / 2
        return tuple((i * x, j * y, self.height) for j in (-1, 1) for i in (-1, 1))


@dataclass(frozen=True, slots=True, kw_only=True)
class LShape:
    """A plate bolted up to the frame and a wall hanging from it, bored for the bearing.

    `height` runs from the bearing's centre up to the mounting plane; the plate reaches
    `depth` rearward from the wall's front face; `width` of the plate and `wall_width` of
    the wall run across the vehicle; the wall ends `rim` below the bore. `fillet` is the
    radius in the root. Four bolts, `bolt_edge` from the plate's sides and rear. Two gussets
    of thickness `gusset` (0: none) brace the wall, reaching `gusset_height` down it.
    """

    seat_diameter: Metre
    width: Metre
    wall_width: Metre
    depth: Metre
    thickness: Metre
    height: Metre
    rim: Metre
    fillet: Metre
    bolt_diameter: Metre
    bolt_edge: Metre
    gusset: Metre = 0.0
    gusset_height: Metre = 0.0

    def __post_init__(self) -> None:
        part = "an L bracket"
        _above_zero(
            part, seat_diameter=self.seat_diameter, width=self.width, wall_width=self.wall_width,
            depth=self.depth, thickness=self.thickness, height=self.height, rim=self.rim,
            fillet=self.fillet, bolt_diameter=self.bolt_diameter, bolt_edge=self.bolt_edge,
        )  # fmt: skip
        t = self.thickness
        _at_most(part, "wall_width", self.wall_width, self.width, "the plate")
        _at_most(part, "seat_diameter", self.seat_diameter, self.wall_width, "the wall")
        _at_most(part, "seat_diameter", self.seat_diameter, self.height - t - self.fillet,
                 "the wall below the root's fillet, above the centre", times=0.5)  # fmt: skip
        _at_most(part, "bolt_diameter", self.bolt_diameter, self.bolt_edge,
                 "the edge, for a washer", times=1.1)  # fmt: skip
        washer = 2.2 * self.bolt_diameter
        _at_most(part, "bolt_edge", self.bolt_edge, self.depth - t - self.fillet - 1.5 * washer,
                 "the plate's depth, for two rows of washers")  # fmt: skip
        _at_most(part, "bolt_edge", self.bolt_edge, (self.width - washer) / 2,
                 "the plate's width, for two washers")  # fmt: skip
        if self.gusset:
            _above_zero(part, gusset=self.gusset, gusset_height=self.gusset_height)
            room = self.gusset_face_offset - self.seat_diameter / 2
            _at_most(part, "gusset", self.gusset, room, "the room between the bore and the bolts")
            room = self.height - t
            _at_most(part, "gusset_height", self.gusset_height, room, "the wall above the bearing")
            room = self.gusset_height - t / 2
            _at_most(part, "fillet", self.fillet, room, "the gusset's end below the plate")

    @property
    def gusset_face_offset(self) -> Metre:
        """Outer face of each gusset, from the middle: clear of the bolts' washers."""
        clear = self.width / 2 - self.bolt_edge - 1.1 * self.bolt_diameter
        return min(self.wall_width / 2, clear)

    @property
    def bolt_positions(self) -> tuple[Vector3, ...]:
        """Centres of the bolt holes on the mounting plane."""
        y = self.width / 2 - self.bolt_edge
        front = self.thickness / 2 + self.fillet + 1.1 * self.bolt_diameter
        rear = self.depth - self.thickness / 2 - self.bolt_edge
        return tuple((x, j * y, self.height) for j in (-1, 1) for x in (front, rear))


@dataclass(frozen=True, slots=True, kw_only=True)
class FaceSelector:
    """Faces of a STEP file: all that carry a name, or the one a point lies on."""

    name: str = ""
    near: Vector3 | None = None

    def __post_init__(self) -> None:
        if bool(self.name) == (self.near is not None):
            msg = "a face is picked either by its name or by a point on it"
            raise DesignError(msg)


@dataclass(frozen=True, slots=True, kw_only=True)
class StepFileShape:
    """A bracket from a STEP file, its axes along the vehicle's.

    `centre` is where the bearing's centre lies in the file's coordinates (SI), `seat` and
    `bolts` are the faces the bearing sits on and the frame holds; each pick among the bolts
    is one bolt. `thickness` is that of its walls where stress matters: it sets the mesh.
    """

    path: str
    centre: Vector3
    seat: tuple[FaceSelector, ...]
    bolts: tuple[FaceSelector, ...]
    thickness: Metre
    solid: str = ""
    """Which solid of the file, where it has several."""
    welded: tuple[FaceSelector, ...] = ()
    """Faces that are welded to the frame: held every way, their edges are weld toes."""

    def __post_init__(self) -> None:
        _above_zero("a STEP bracket", thickness=self.thickness)
        if not self.seat or not (self.bolts or self.welded):
            msg = (
                "a STEP bracket needs at least one face for its seat and one for its bolts, or one "
                "that is welded"
            )
            raise DesignError(msg)


Shape: TypeAlias = UShape | LShape | StepFileShape


@dataclass(frozen=True, slots=True, kw_only=True)
class BracketStrainGauge:
    """A strain gauge: where its grid's middle is, which way it measures, how long it is.

    `point` is in the bracket's frame and is drawn to the nearest surface; `direction` is
    laid into that surface. It may be glued as far `off` to any side, and so far `askew` (rad):
    assumed, by hand to lines that are scratched on.
    """

    name: str
    point: Vector3
    direction: Vector3
    length: Metre = 3 * mm
    off: Metre = 1 * mm
    askew: float = 2 * deg

    def __post_init__(self) -> None:
        _above_zero(f"gauge {self.name}", length=self.length)
        if not sum(d * d for d in self.direction) > 0:
            msg = f"gauge {self.name} needs a direction that is not zero"
            raise DesignError(msg)


@dataclass(frozen=True, slots=True, kw_only=True)
class BracketLoadCase:
    """A load at the bearing's centre, by hand, along the vehicle's axes.

    `acceleration` is that of the frame: standing still under gravity is (0, 0, +g). It acts
    on the bracket's own mass and on the mass the bearing carries. On top of a state none
    upwards leaves the state's gravity as it is.
    """

    name: str
    force: Vector3 = (0.0, 0.0, 0.0)
    moment: Vector3 = (0.0, 0.0, 0.0)
    acceleration: Vector3 = (0.0, 0.0, 0.0)
    state: str = ""
    """The state whose driveline loads it comes on top of; none where it comes alone."""


@dataclass(frozen=True, kw_only=True, eq=False)
class BracketRecording:
    """What was measured on a bracket: the force on its bearing, or what its gauges read.

    Attributes
    ----------
    rate : Hz
    force : (t, 3) N
        Along the vehicle's axes; None where it follows from the gauges.
    strain : (t, g)
        Of the bracket's gauges; None where the force is known.
    read
        Whether its forces are known by the bracket's gauges alone, however they were read back.
    """

    name: str
    rate: float
    force: FloatArray | None = None
    strain: FloatArray | None = None
    read: bool = False


MeanStressMethod: TypeAlias = Literal["goodman", "ratio", "none"]
"""How a mean stress counts: by Goodman, by the ratio R of IIW's f(R), or not at all."""
MEAN_STRESS_METHODS: tuple[MeanStressMethod, ...] = ("goodman", "ratio", "none")


@dataclass(frozen=True, slots=True, kw_only=True)
class FatigueCurve:
    """S-N curve of a bracket: amplitude and cycles at the knee, k of N ~ S^-k.

    The amplitude is that at zero mean, or of codes that know no mean stress at any.
    """

    amplitude: Pascal
    cycles: float
    slope: float
    mean: MeanStressMethod = "goodman"
    name: str = ""
    metal: MetalKind | None = None
    """Of what, where a code says so."""
    source: Source = SOURCE_ASSUMED

    def __post_init__(self) -> None:
        if not (self.amplitude > 0 and self.cycles > 0 and self.slope >= 1):
            msg = (
                "the S-N curve of a bracket needs amplitude and cycles above 0 and a slope of "
                f"at least 1, got {self.amplitude / MPa:g} MPa, {self.cycles:g}, {self.slope:g}"
            )
            raise DesignError(msg)


@dataclass(frozen=True, slots=True, kw_only=True)
class Bolts:
    """What tightens a bracket: each bolt's force, N, and friction between flange and frame."""

    preload: float
    friction: float = 0.15

    def __post_init__(self) -> None:
        if not (self.preload > 0 and 0 < self.friction < 2):
            msg = (
                "bolts need a preload above 0 and a friction above 0 and below 2, got "
                f"{self.preload:g} N, {self.friction:g}"
            )
            raise DesignError(msg)


def default_bolt_preload(hole: Metre) -> float:
    """Return the force (N) that tightens a bolt of class 8.8 in a hole: 27.3 kN for an M10 in 11.

    470 MPa on its stress area, 0.58 d², its thread a tenth smaller than its hole. Source: VDI 2230
    part 1 (2015), table A1 at a friction of 0.12, quoted, unverified.
    """
    return 470e6 * 0.58 * (hole / 1.1) ** 2


@dataclass(frozen=True, slots=True, kw_only=True)
class OptimisationSpace:
    """Sizes to choose from, and the life in s over the duty cycle that is wanted.

    `sizes` are those of the shape by name, each a list in m.
    """

    life: float
    sizes: Mapping[str, tuple[Metre, ...]]


@dataclass(frozen=True, slots=True, kw_only=True)
class Bracket:
    """A bracket to be assessed: shape, material, what it carries, what it has to bear.

    `carried_mass` rides on the bearing; `rubber` is the stiffness between it and the seat
    along x, y, z (N/m), None for a rigid one. `bearing` counts the line's centre bearings
    from 1. `reinforced` is the same bracket with another shape, shown next to it.
    """

    shape: Shape
    material: Material = STEEL
    line: str = "main"
    bearing: int = 1
    carried_mass: Kilogram = 0.0
    rubber: Vector3 | None = None
    loss: float = DEFAULT_BRACKET_LOSS_FACTOR
    """Share of its energy that it loses in a radian."""
    loss_assumed: bool = True
    """Whether it is not given."""
    gauges: tuple[BracketStrainGauge, ...] = ()
    cases: tuple[BracketLoadCase, ...] = ()
    recordings: tuple[BracketRecording, ...] = ()
    reinforced: Shape | None = None
    element: Metre | None = None
    """Largest edge of an element; by default the shape's thickness."""
    order: int = 2
    """Degree of the displacements in an element."""
    fatigue: FatigueCurve | None = None
    """What its sheet bears; without one no damage is counted."""
    details: Mapping[FatigueZone, FatigueCurve] = field(
        default_factory=dict[FatigueZone, FatigueCurve]
    )
    """What its cut edges, weld toes and bolt borders bear, where the file says it."""
    search: OptimisationSpace | None = None
    """What `--optimise` may choose."""
    bolts: Bolts | None = None
    """Its flange is in contact with the frame; None where the two ways to be held are all."""

    def __post_init__(self) -> None:
        if not self.carried_mass >= 0:
            msg = f"carried_mass of a bracket must be 0 or more, got {self.carried_mass:g} kg"
            raise DesignError(msg)
        if self.rubber is not None and not min(self.rubber) > 0:
            msg = f"the rubber of a bracket needs stiffness above 0 each way, got {self.rubber}"
            raise DesignError(msg)
        if not 0 < self.loss < 1:
            msg = f"loss_factor of a bracket must be above 0 and below 1, got {self.loss:g}"
            raise DesignError(msg)
        if self.order not in (2, 3, 4):
            msg = (
                f"order of a bracket's elements must be 2 to 4, got {self.order}: elements of "
                "order 1 are too stiff where a sheet bends, and show too little stress"
            )
            raise DesignError(msg)
        if self.element is not None:
            _above_zero("a bracket", element=self.element)
        if self.bolts and any(
            isinstance(s, StepFileShape) and not s.bolts for s in (self.shape, self.reinforced)
        ):
            msg = (
                "bolts of a bracket that is only welded: give its step file bolts, or leave them "
                "out"
            )
            raise DesignError(msg)
        names = [g.name for g in self.gauges]
        if len(set(names)) < len(names):
            msg = f"the gauges of a bracket need different names, got {', '.join(names)}"
            raise DesignError(msg)
