"""A bracket of a file: shape, what it carries, gauges on it, loads given by hand."""

from dataclasses import replace
from math import prod
from typing import Annotated, Any, TypeAlias, get_args

import numpy as np

from cardan.application.catalogue import DetailClassOrCatalogueName, MaterialOrCatalogueName
from cardan.core.units import deg, g, mm
from cardan.model.application import InstalledLine
from cardan.model.bracket import (
    FATIGUE_ZONES,
    Bolts,
    Bracket,
    BracketLoadCase,
    BracketRecording,
    BracketStrainGauge,
    FaceSelector,
    FatigueCurve,
    FatigueZone,
    LShape,
    OptimisationSpace,
    Shape,
    StepFileShape,
    UShape,
    default_bolt_preload,
)  # fmt: skip
from cardan.model.bracket_compliance import DEFAULT_BRACKET_LOSS_FACTOR
from cardan.model.material import STEEL, Material
from cardan.physics.fatigue.detail_classes import sheet_knee_amplitude
from cardan.schema.field_types import IntegerField, ListField, NumberField
from cardan.schema.fields import (
    FORCE_KEY_UNITS,
    MAX_TORQUE_NM,
    STIFFNESS_KEY_UNITS,
    TORQUE_KEY_UNITS,
    Angle,
    CycleCount,
    Diameter,
    Distance,
    LifeHours,
    Mass,
    MaterialStrength,
    PartDimension,
    PointCoordinates,
    SteelStructureLossFactor,
    WallThickness,
)  # fmt: skip
from cardan.schema.node_reader import nearest_name_hint
from cardan.schema.tables import Table, TableField, table_key_field
from cardan.topics.bracket.metal_fatigue_data import fatigue_data_of_metal, zone_curve_key

AXIS_NAMES = ("x", "y", "z")

Force: TypeAlias = Annotated[
    tuple[float, float, float],
    ListField(NumberField(*FORCE_KEY_UNITS, least=-1e9, most=1e9), *AXIS_NAMES),
]
Moment: TypeAlias = Annotated[
    tuple[float, float, float],
    ListField(
        NumberField(*TORQUE_KEY_UNITS, least=-MAX_TORQUE_NM, most=MAX_TORQUE_NM), *AXIS_NAMES
    ),
]
Acceleration: TypeAlias = Annotated[
    tuple[float, float, float],
    ListField(NumberField(worth={"g": g, "m_s2": 1.0}, least=-1e5, most=1e5), *AXIS_NAMES),
]
MountStiffness: TypeAlias = Annotated[
    tuple[float, float, float],
    ListField(NumberField(*STIFFNESS_KEY_UNITS, least=1, most=1e12), *AXIS_NAMES),
]
BoltPreload: TypeAlias = Annotated[float, NumberField(*FORCE_KEY_UNITS, least=1, most=1e7)]
Roughness: TypeAlias = Annotated[float, NumberField(worth={"um": 1e-6}, least=0, most=1e-3)]
FORCE_CHANNEL_NAMES = ("x_N", "y_N", "z_N")
MICROSTRAIN_UNITS = ("um/m", "µm/m", "μm/m", "ue", "uE", "µε", "με", "ustrain", "microstrain")
_SHORTEST = 4
_MOST = 400
ZONES_WITH_FATIGUE_DETAIL: tuple[FatigueZone, ...] = tuple(
    zone for zone in FATIGUE_ZONES if zone != "sheet"
)
"""Zones that bear what a detail does."""
VEHICLE_STATE_LOAD_CASE_NAMES = (
    "static", "order 2", "combined", "peak", "worst point",
    *(f"widest swing, {zone}" for zone in FATIGUE_ZONES),
)  # fmt: skip
"""The load cases that states have of themselves."""
MIN_FINITE_ELEMENT_DEGREE = 2
"""Of elements that a verdict can stand on."""
DirectionVector: TypeAlias = Annotated[
    tuple[float, float, float], ListField(NumberField(), *AXIS_NAMES)
]


class UShapeTable(Table):
    """A sheet bent to a U, its flanges bolted up to the frame, the bearing in its round."""

    seat_diameter: Diameter = table_key_field("inside the round, where the bearing sits")
    width: PartDimension = table_key_field("of the sheet, along the shaft")
    thickness: WallThickness = table_key_field("of the sheet")
    height: PartDimension = table_key_field("from the bearing's centre up to the mounting plane")
    flange: PartDimension = table_key_field("how far each flange reaches outwards from the leg")
    bend_radius: PartDimension = table_key_field("inside radius of the bends")
    bolt_diameter: PartDimension = table_key_field("of the bolt holes")
    bolt_pitch: PartDimension = table_key_field(
        "between the two bolts of a flange, along the shaft"
    )
    gusset: Distance = table_key_field(
        "thickness of a rib under each flange; 0 is none", default=0.0
    )
    gusset_height: Distance = table_key_field("how far the ribs reach down the legs", default=0.0)
    fillet: PartDimension = table_key_field("radius of the ribs' welds", default=3 * mm)

    def build(self) -> UShape:
        """Return the shape in SI."""
        return UShape(**_given(self))


class LShapeTable(Table):
    """A plate bolted up to the frame and a wall hanging from it, bored for the bearing."""

    seat_diameter: Diameter = table_key_field("of the bore")
    width: PartDimension = table_key_field("of the plate, across the vehicle")
    wall_width: PartDimension = table_key_field("of the wall, across the vehicle")
    depth: PartDimension = table_key_field("of the plate, rearward from the wall's front face")
    thickness: WallThickness = table_key_field("of plate and wall")
    height: PartDimension = table_key_field("from the bearing's centre up to the mounting plane")
    rim: PartDimension = table_key_field("of the wall below the bore")
    fillet: PartDimension = table_key_field("radius in the root between plate and wall")
    bolt_diameter: PartDimension = table_key_field("of the bolt holes")
    bolt_edge: PartDimension = table_key_field(
        "from the bolts to the sides and rear edge of the plate"
    )
    gusset: Distance = table_key_field("thickness of two braces; 0 is none", default=0.0)
    gusset_height: Distance = table_key_field("how far they reach down the wall", default=0.0)

    def build(self) -> LShape:
        """Return the shape in SI."""
        return LShape(**_given(self))


def _given(table: Table) -> dict[str, Any]:
    """Return the entries of a table as the keywords of its part."""
    return {name: getattr(table, name) for name in table.entries()}


class StepFaceSelectionTable(Table):
    """Faces of a STEP file."""

    one_of = (("name", "near"),)

    name: str | None = table_key_field("that they carry in the file", default=None)
    near: PointCoordinates | None = table_key_field(
        "a point on the face, in the file's coordinates", default=None
    )

    def build(self) -> FaceSelector:
        """Return the pick."""
        return FaceSelector(name=self.name or "", near=self.near)


FaceSelectors: TypeAlias = Annotated[
    tuple[FaceSelector, ...], ListField(TableField(StepFaceSelectionTable), most=100)
]


class StepFileTable(Table):
    """A shape from a STEP file, its axes along the vehicle's."""

    file: str = table_key_field("the STEP file, next to this one")
    centre: PointCoordinates = table_key_field("the bearing's centre, in the file's coordinates")
    seat: FaceSelectors = table_key_field("faces the bearing sits on")
    bolts: FaceSelectors = table_key_field("faces the frame holds, one a bolt", default=())
    welded: FaceSelectors = table_key_field(
        "faces that are welded to the frame, which holds them every way", default=()
    )
    thickness: WallThickness = table_key_field("of its walls where stress matters")
    solid: str | None = table_key_field(
        "which solid of the file, where it has several", default=None
    )

    def build(self) -> StepFileShape:
        """Return the shape in SI."""
        path = self.reader_of("file").referenced_path(self.file)
        if not path.is_file():
            self.reader_of("file").reject("no such file", f"looked for {path}", got=self.file)
        return self.attempt(lambda: StepFileShape(
            path=str(path), centre=self.centre, seat=self.seat, bolts=self.bolts,
            welded=self.welded, thickness=self.thickness, solid=self.solid or "",
        ))  # fmt: skip


class ReinforcedBracketTable(Table):
    """What is different in the reinforced bracket; the rest is as in the shape above."""

    width: PartDimension | None = table_key_field("of the sheet or plate", default=None)
    wall_width: PartDimension | None = table_key_field("of an L's wall", default=None)
    thickness: WallThickness | None = table_key_field("of sheet or plate and wall", default=None)
    flange: PartDimension | None = table_key_field("of a U", default=None)
    depth: PartDimension | None = table_key_field("of an L's plate", default=None)
    rim: PartDimension | None = table_key_field("of an L below the bore", default=None)
    bend_radius: PartDimension | None = table_key_field("of a U", default=None)
    fillet: PartDimension | None = table_key_field("of a U's welds or an L's root", default=None)
    gusset: Distance | None = table_key_field("thickness of the ribs or braces", default=None)
    gusset_height: Distance | None = table_key_field("how far they reach down", default=None)
    step: Annotated[StepFileShape, StepFileTable] | None = table_key_field(
        "another STEP file", default=None
    )

    def shape(self, before: Shape) -> Shape:
        """Return the shape with what is different."""
        if self.step is not None:
            return self.step
        changed = {n: v for n, v in _given(self).items() if v is not None}
        if not changed:
            self.reader_of().reject("says nothing that is different")
        for name in changed:
            if not hasattr(before, name):
                self.reader_of(name).reject(f"the shape above has no {name}")
        return self.attempt(lambda: replace(before, **changed))


class GaugeTable(Table):
    """A strain gauge on the bracket."""

    name: str = table_key_field("what reports call it: S1")
    point: PointCoordinates = table_key_field(
        "middle of its grid, from the bearing's centre; the nearest surface counts"
    )
    direction: DirectionVector = table_key_field(
        "along which it measures; it is laid into the surface"
    )
    length: PartDimension = table_key_field("of its grid", default=3 * mm)
    off: Distance = table_key_field(
        "it may be glued, to any side; assumed if left out", default=1 * mm
    )
    askew: Angle = table_key_field("it may be glued; assumed if left out", default=2 * deg)

    def build(self) -> BracketStrainGauge:
        """Return the gauge in SI."""
        return BracketStrainGauge(
            name=self.name, point=self.point, direction=self.direction, length=self.length,
            off=self.off, askew=self.askew,
        )  # fmt: skip


class LoadCaseTable(Table):
    """A load given by hand, along the vehicle's axes: rearward, to the right, up."""

    name: str = table_key_field("what reports call it")
    force: Force = table_key_field("on the bearing", default=(0.0, 0.0, 0.0))
    moment: Moment = table_key_field("about the bearing's centre", default=(0.0, 0.0, 0.0))
    acceleration: Acceleration = table_key_field(
        "of the frame, felt by bracket and carried mass; standing still is [0, 0, 1] g, which a "
        "state keeps where the last is 0",
        default=(0.0, 0.0, 0.0),
    )
    state: str | None = table_key_field(
        "the state whose driveline loads it comes on top of, where the bearing carries most",
        default=None,
    )

    def build(self) -> BracketLoadCase:
        """Return the case in SI."""
        if not any((*self.force, *self.moment, *self.acceleration)):
            self.reader_of().reject("loads nothing", "give force_N, moment_Nm or acceleration_g")
        return BracketLoadCase(
            name=self.name, force=self.force, moment=self.moment, acceleration=self.acceleration,
            state=self.state or "",
        )  # fmt: skip


class RecordingTable(Table):
    """What was measured: forces on the bearing, or strains of the bracket's gauges."""

    name: str = table_key_field("what reports call it")
    file: str = table_key_field(
        "a recording next to this file: channels x_N, y_N, z_N, as `cardan life --load-history` "
        "writes them, or one named after each gauge"
    )
    from_gauges: bool = table_key_field(
        "whether its forces were read from the bracket's gauges, as `cardan life` reads them",
        default=False,
    )

    def recording(self, gauges: tuple[BracketStrainGauge, ...]) -> BracketRecording:
        """Return the recording in SI."""
        from cardan.readers.dispatch import open_recording

        path = self.reader_of("file").referenced_path(self.file)
        if not path.is_file():
            self.reader_of("file").reject("no such file", f"looked for {path}", got=self.file)
        found = open_recording(path)
        names = [c.name for c in found.channels]
        forces = [n for n in FORCE_CHANNEL_NAMES if n in names]
        wanted = FORCE_CHANNEL_NAMES if forces else tuple(g.name for g in gauges)
        missing = [n for n in wanted if n not in names]
        if missing or not wanted:
            self.reader_of("file").reject(
                f"has no channel {', '.join(missing) or 'of a force'}; it has {', '.join(names)}",
                "forces are x_N, y_N, z_N; strains are named after the bracket's gauges",
                got=self.file,
            )  # fmt: skip
        values = found.read_all(wanted).T
        if len(values) < _SHORTEST:
            self.reader_of("file").reject("holds fewer than 4 samples", got=self.file)
        holes = int((~np.isfinite(values)).any(axis=1).sum())
        if holes:
            self.reader_of("file").reject(
                f"has {holes} samples that are no numbers", "correct it first: cardan life",
                got=self.file,
            )  # fmt: skip
        known, told = (
            (("N",), "forces are in N") if forces else (MICROSTRAIN_UNITS, "strains are in um/m")
        )
        for name in wanted:
            unit = found.channel(name).unit
            if unit not in ("", *known):
                self.reader_of("file").reject(f"channel {name} is in {unit}; {told}", got=self.file)
        if forces:
            if self.from_gauges and len(gauges) < len(FORCE_CHANNEL_NAMES):
                self.reader_of("from_gauges").reject(
                    "needs the gauges they were read from, 3 at least; the bracket has "
                    f"{len(gauges)}"
                )
            return BracketRecording(
                name=self.name, rate=found.rate, force=values, read=self.from_gauges
            )
        return BracketRecording(name=self.name, rate=found.rate, strain=values * 1e-6, read=True)


Recordings: TypeAlias = Annotated[
    tuple[RecordingTable, ...], ListField(TableField(RecordingTable), most=20)
]


class FatigueTable(Table):
    """What the bracket bears in fatigue, zone by zone; beyond each knee 2k - 1 holds."""

    one_of = (("amplitude", "roughness"),)

    amplitude: MaterialStrength | None = table_key_field(
        "of the sheet, fully reversed, at the knee of its S-N curve", default=None
    )
    cycles: CycleCount = table_key_field("cycles to failure there", default=1e6)
    slope: Annotated[float, NumberField(least=1, most=100)] = table_key_field(
        "k of N ~ S^-k above the knee", default=5.0
    )
    roughness: Roughness | None = table_key_field(
        "Rz of the sheet's skin, 200 um as rolled: its amplitude then by the FKM guideline",
        default=None,
    )
    cut_edge: DetailClassOrCatalogueName | None = table_key_field(
        "what cut edges bear, a detail of a catalogue; left out, the cautious one of its metal",
        default=None,
    )
    weld_toe: DetailClassOrCatalogueName | None = table_key_field(
        "what the toes of welds bear; left out as above", default=None
    )
    bolt_border: DetailClassOrCatalogueName | None = table_key_field(
        "what the borders of bolts bear; left out as above", default=None
    )

    def sheet(self, material: Material) -> FatigueCurve:
        """Return the sheet's curve in SI."""
        amplitude = self.amplitude
        if self.roughness is not None:
            of = fatigue_data_of_metal(material.metal)
            if of is None:
                self.reader_of("roughness").reject(
                    f"is of metals that the FKM guideline covers, and {material.name} is "
                    f"{material.metal}",
                    "give amplitude_MPa, or say the material's metal",
                )
            if material.ultimate_strength is None:
                self.reader_of("roughness").reject(
                    f"needs the ultimate strength of the material, and {material.name} states none",
                    "give it, or amplitude_MPa",
                )
            amplitude = sheet_knee_amplitude(
                material.ultimate_strength, roughness=self.roughness, of=of.metal
            )
        assert amplitude is not None  # one of the two is given
        return FatigueCurve(amplitude=amplitude, cycles=self.cycles, slope=self.slope)

    def details(self, material: Material) -> dict[FatigueZone, FatigueCurve]:
        """Return the curves of the zones that the file gives one for."""
        given: dict[FatigueZone, FatigueCurve] = {}
        for zone in ZONES_WITH_FATIGUE_DETAIL:
            curve: FatigueCurve | None = getattr(self, zone_curve_key(zone))
            if curve is None:
                continue
            if curve.metal and curve.metal != material.metal.removeprefix("cast "):
                self.reader_of(zone_curve_key(zone)).reject(
                    f"{curve.name} is of {curve.metal}, and {material.name} is {material.metal}",
                    "give its class in place, by range_MPa and slope",
                )
            given[zone] = curve
        return given


BRACKET_DIMENSION_FIELD, WALL_THICKNESS_FIELD, DISTANCE_FIELD = (
    get_args(kind)[1] for kind in (PartDimension, WallThickness, Distance)
)
WallThicknesses: TypeAlias = Annotated[
    tuple[float, ...], ListField(WALL_THICKNESS_FIELD, least=1, most=20)
]
CandidateDimensions: TypeAlias = Annotated[
    tuple[float, ...], ListField(BRACKET_DIMENSION_FIELD, least=1, most=20)
]
DistanceList: TypeAlias = Annotated[tuple[float, ...], ListField(DISTANCE_FIELD, least=1, most=20)]


class BoltsTable(Table):
    """What tightens the bracket: its flange is then in contact with the frame, with friction."""

    preload: BoltPreload | None = table_key_field(
        "of each bolt; default that of class 8.8 by the hole's size, 27 kN for an M10", default=None
    )
    friction: Annotated[float, NumberField(least=0.01, most=1)] = table_key_field(
        "between flange and frame, assumed if left out", default=0.15
    )

    def bolts(self, shape: Shape) -> Bolts:
        """Return the bolts in SI."""
        preload = self.preload
        if preload is None:
            if isinstance(shape, StepFileShape):
                self.reader_of().reject(
                    "needs the preload of a STEP file's bolts", "preload_kN: 27"
                )
            preload = default_bolt_preload(shape.bolt_diameter)
        return Bolts(preload=preload, friction=self.friction)


class OptimiseTable(Table):
    """Sizes that `cardan bracket --optimise` may choose from, for the lightest that lives."""

    life: LifeHours = table_key_field("to live at least, over the duty cycle")
    thickness: WallThicknesses | None = table_key_field(
        "of sheet, or of plate and wall", default=None
    )
    width: CandidateDimensions | None = table_key_field("of the sheet or plate", default=None)
    flange: CandidateDimensions | None = table_key_field("of a U", default=None)
    bend_radius: CandidateDimensions | None = table_key_field("of a U", default=None)
    gusset: DistanceList | None = table_key_field(
        "thickness of the ribs or braces; 0 is none", default=None
    )
    gusset_height: DistanceList | None = table_key_field("how far they reach down", default=None)
    wall_width: CandidateDimensions | None = table_key_field("of an L's wall", default=None)
    depth: CandidateDimensions | None = table_key_field("of an L's plate", default=None)
    rim: CandidateDimensions | None = table_key_field("of an L below the bore", default=None)
    fillet: CandidateDimensions | None = table_key_field(
        "of a U's welds or an L's root", default=None
    )

    def search(self, shape: Shape) -> OptimisationSpace:
        """Return what may be chosen of a shape, in SI."""
        sizes = {n: tuple(v) for n, v in _given(self).items() if v is not None and n != "life"}
        if not sizes:
            self.reader_of().reject("gives nothing to choose from", "thickness_mm: [4, 5, 6, 8]")
        for name in sizes:
            if isinstance(shape, StepFileShape) or not hasattr(shape, name):
                self.reader_of(name).reject(f"the shape above has no {name} that can be chosen")
        count = prod(len(v) for v in sizes.values())
        if count > _MOST:
            self.reader_of().reject(f"makes {count} sets of sizes, more than {_MOST}", "give fewer")
        return OptimisationSpace(life=self.life, sizes=sizes)


class BracketTable(Table):
    """The bracket a centre bearing hangs in. Its origin is the bearing's centre."""

    fixed = True  # its shape is meshed, one at a time
    one_of = (("u_shape", "l_shape", "step"),)

    u_shape: Annotated[UShape, UShapeTable] | None = table_key_field("a bent sheet", default=None)
    l_shape: Annotated[LShape, LShapeTable] | None = table_key_field(
        "a plate and a wall", default=None
    )
    step: Annotated[StepFileShape, StepFileTable] | None = table_key_field(
        "a STEP file", default=None
    )
    material: MaterialOrCatalogueName = table_key_field(
        "a material of a catalogue, or its properties", default=STEEL
    )
    line: str | None = table_key_field(
        "the driveline it belongs to; by default the first", default=None
    )
    bearing: Annotated[int, IntegerField(12)] = table_key_field(
        "which centre bearing, from the front", default=1
    )
    carried_mass: Mass = table_key_field(
        "bearing and share of the shafts that ride on it", default=0.0
    )
    rubber: MountStiffness | None = table_key_field(
        "stiffness between bearing and seat along x, y, z; rigid if left out", default=None
    )
    loss_factor: SteelStructureLossFactor | None = table_key_field(
        f"of the bracket; {DEFAULT_BRACKET_LOSS_FACTOR:g} assumed if left out", default=None
    )
    gauges: Annotated[
        tuple[BracketStrainGauge, ...], ListField(TableField(GaugeTable), most=100)
    ] = table_key_field("strain gauges on it", default=())
    cases: Annotated[
        tuple[BracketLoadCase, ...], ListField(TableField(LoadCaseTable), most=100)
    ] = table_key_field("loads given by hand", default=())
    recordings: Annotated[
        tuple[RecordingTable, ...], ListField(TableField(RecordingTable), most=20)
    ] = table_key_field("what was measured on it", default=())
    fatigue: FatigueTable | None = table_key_field("S-N curves, for damage and life", default=None)
    reinforced: ReinforcedBracketTable | None = table_key_field(
        "a variant shown beside it", default=None
    )
    bolts: BoltsTable | None = table_key_field(
        "contact between flange and frame; without it the two ways it may be held", default=None
    )
    optimise: OptimiseTable | None = table_key_field(
        "sizes to choose the lightest from", default=None
    )
    element: PartDimension | None = table_key_field(
        "largest edge of an element; default the thickness", default=None
    )
    order: Annotated[int, IntegerField(4, told=MIN_FINITE_ELEMENT_DEGREE)] = table_key_field(
        "degree of the displacements, 2 to 4; 1 is read as 2", default=2
    )

    def bracket(self, lines: tuple[InstalledLine, ...], states: tuple[str, ...]) -> Bracket:
        """Return the bracket in SI."""
        own = [f"{state}: {what}" for state in states for what in VEHICLE_STATE_LOAD_CASE_NAMES]
        self.require_different_names("gauges", [part.name for part in self.gauges])
        for k, part in enumerate(self.cases, 1):
            if part.name in own:
                self.reader_of("cases", k).add_issue(
                    "a load case of that state has this name", "give it another", got=part.name
                )
        by_hand = [part.name for part in self.cases]
        self.require_different_names("cases", by_hand)
        self.require_different_names(
            "recordings", [part.name for part in self.recordings], beside=own + by_hand
        )
        for k, case in enumerate(self.cases, 1):
            if case.state and case.state not in states:
                hint = nearest_name_hint(case.state, list(states))
                self.reader_of("cases", k).reject("no state of this name", hint, got=case.state)
        known = {installed.line.name: installed.line for installed in lines}
        line = self.line or next(iter(known))
        if line not in known:
            hint = nearest_name_hint(line, list(known))
            self.reader_of("line").reject("no driveline of this name", hint, got=line)
        count = known[line].joint_count - 2
        if self.bearing > count:
            message = f"line {line} has {count} centre bearing{'s' * (count != 1)}"
            self.reader_of("bearing").reject(message, got=str(self.bearing))
        shape = next(s for s in (self.u_shape, self.l_shape, self.step) if s is not None)
        if (
            self.order < MIN_FINITE_ELEMENT_DEGREE
        ):  # a file may say it that was written when it was taken
            self.reader_of("order").warn(
                "order 1 is read as 2: its elements are too stiff where a sheet bends"
            )
        return self.attempt(
            lambda: Bracket(
                shape=shape,
                material=self.material,
                line=line,
                bearing=self.bearing,
                carried_mass=self.carried_mass,
                rubber=self.rubber,
                loss=DEFAULT_BRACKET_LOSS_FACTOR if self.loss_factor is None else self.loss_factor,
                loss_assumed=self.loss_factor is None,
                gauges=self.gauges,
                cases=self.cases,
                recordings=tuple(r.recording(self.gauges) for r in self.recordings),
                reinforced=self.reinforced.shape(shape) if self.reinforced else None,
                element=self.element,
                order=max(self.order, MIN_FINITE_ELEMENT_DEGREE),
                fatigue=self.fatigue.sheet(self.material) if self.fatigue else None,
                details=self.fatigue.details(self.material) if self.fatigue else {},
                bolts=self.bolts.bolts(shape) if self.bolts else None,
                search=self.optimise.search(shape) if self.optimise else None,
            )
        )
