"""A bracket of a file: shape, what it carries, gauges on it, loads given by hand."""

from dataclasses import replace
from math import prod
from typing import Annotated, Any, TypeAlias, get_args

import numpy as np

from cardan.base.units import deg, g, mm
from cardan.border.measure import (
    FORCES,
    STIFFNESSES,
    STRONGEST,
    TORQUES,
    Angle,
    Cycles,
    Diameter,
    Distance,
    FrameLoss,
    Hours,
    Mass,
    Point,
    Size,
    Strength,
    Wall,
)  # fmt: skip
from cardan.border.table import (
    ListOf,
    Number,
    Table,
    TableRule,
    Whole,
    key,
    nearest,
)  # fmt: skip
from cardan.fatigue.detail import sheet_amplitude
from cardan.files.catalogue import ADetail, AMaterial
from cardan.files.metals import borne, key_of
from cardan.model.application import Installed
from cardan.model.bracket import (
    ZONES,
    Bolts,
    Bracket,
    BracketCase,
    BracketRecording,
    FatigueCurve,
    Gauge,
    LShape,
    Pick,
    Search,
    Shape,
    StepShape,
    UShape,
    Zone,
    usual_preload,
)  # fmt: skip
from cardan.model.material import STEEL, Material
from cardan.model.seat import LOSS

AXES = ("x", "y", "z")

Force: TypeAlias = Annotated[
    tuple[float, float, float], ListOf(Number(*FORCES, least=-1e9, most=1e9), *AXES)
]
Moment: TypeAlias = Annotated[
    tuple[float, float, float],
    ListOf(Number(*TORQUES, least=-STRONGEST, most=STRONGEST), *AXES),
]
Acceleration: TypeAlias = Annotated[
    tuple[float, float, float],
    ListOf(Number(worth={"g": g, "m_s2": 1.0}, least=-1e5, most=1e5), *AXES),
]
Rubber: TypeAlias = Annotated[
    tuple[float, float, float], ListOf(Number(*STIFFNESSES, least=1, most=1e12), *AXES)
]
Clamp: TypeAlias = Annotated[float, Number(*FORCES, least=1, most=1e7)]
Roughness: TypeAlias = Annotated[float, Number(worth={"um": 1e-6}, least=0, most=1e-3)]
FORCE_CHANNELS = ("x_N", "y_N", "z_N")
MICROSTRAIN = ("um/m", "µm/m", "μm/m", "ue", "uE", "µε", "με", "ustrain", "microstrain")
_SHORTEST = 4
_MOST = 400
DETAILED: tuple[Zone, ...] = tuple(zone for zone in ZONES if zone != "sheet")
"""Zones that bear what a detail does."""
OF_STATES = (
    "static", "order 2", "combined", "peak", "worst point",
    *(f"widest swing, {zone}" for zone in ZONES),
)  # fmt: skip
"""The load cases that states have of themselves."""
LEAST_ORDER = 2
"""Of elements that a verdict can stand on."""
Way: TypeAlias = Annotated[tuple[float, float, float], ListOf(Number(), *AXES)]


class UShapeTable(Table):
    """A sheet bent to a U, its flanges bolted up to the frame, the bearing in its round."""

    seat_diameter: Diameter = key("inside the round, where the bearing sits")
    width: Size = key("of the sheet, along the shaft")
    thickness: Wall = key("of the sheet")
    height: Size = key("from the bearing's centre up to the mounting plane")
    flange: Size = key("how far each flange reaches outwards from the leg")
    bend_radius: Size = key("inside radius of the bends")
    bolt_diameter: Size = key("of the bolt holes")
    bolt_pitch: Size = key("between the two bolts of a flange, along the shaft")
    gusset: Distance = key("thickness of a rib under each flange; 0 is none", default=0.0)
    gusset_height: Distance = key("how far the ribs reach down the legs", default=0.0)
    fillet: Size = key("radius of the ribs' welds", default=3 * mm)

    def build(self) -> UShape:
        """Return the shape in SI."""
        return UShape(**_given(self))


class LShapeTable(Table):
    """A plate bolted up to the frame and a wall hanging from it, bored for the bearing."""

    seat_diameter: Diameter = key("of the bore")
    width: Size = key("of the plate, across the vehicle")
    wall_width: Size = key("of the wall, across the vehicle")
    depth: Size = key("of the plate, rearward from the wall's front face")
    thickness: Wall = key("of plate and wall")
    height: Size = key("from the bearing's centre up to the mounting plane")
    rim: Size = key("of the wall below the bore")
    fillet: Size = key("radius in the root between plate and wall")
    bolt_diameter: Size = key("of the bolt holes")
    bolt_edge: Size = key("from the bolts to the sides and rear edge of the plate")
    gusset: Distance = key("thickness of two braces; 0 is none", default=0.0)
    gusset_height: Distance = key("how far they reach down the wall", default=0.0)

    def build(self) -> LShape:
        """Return the shape in SI."""
        return LShape(**_given(self))


def _given(table: Table) -> dict[str, Any]:
    """Return the entries of a table as the keywords of its part."""
    return {name: getattr(table, name) for name in table.entries()}


class PickTable(Table):
    """Faces of a STEP file."""

    one_of = (("name", "near"),)

    name: str | None = key("that they carry in the file", default=None)
    near: Point | None = key("a point on the face, in the file's coordinates", default=None)

    def build(self) -> Pick:
        """Return the pick."""
        return Pick(name=self.name or "", near=self.near)


Picks: TypeAlias = Annotated[tuple[Pick, ...], ListOf(TableRule(PickTable), most=100)]


class StepTable(Table):
    """A shape from a STEP file, its axes along the vehicle's."""

    file: str = key("the STEP file, beside this one")
    centre: Point = key("the bearing's centre, in the file's coordinates")
    seat: Picks = key("faces the bearing sits on")
    bolts: Picks = key("faces the frame holds, one a bolt", default=())
    welded: Picks = key(
        "faces that are welded to the frame, which holds them every way", default=()
    )
    thickness: Wall = key("of its walls where stress matters")
    solid: str | None = key("which solid of the file, where it has several", default=None)

    def build(self) -> StepShape:
        """Return the shape in SI."""
        path = self.at("file").beside(self.file)
        if not path.is_file():
            self.at("file").refuse("no such file", f"looked for {path}", got=self.file)
        return self.attempt(lambda: StepShape(
            path=str(path), centre=self.centre, seat=self.seat, bolts=self.bolts,
            welded=self.welded, thickness=self.thickness, solid=self.solid or "",
        ))  # fmt: skip


class ReinforcedTable(Table):
    """What is different in the reinforced bracket; the rest is as in the shape above."""

    width: Size | None = key("of the sheet or plate", default=None)
    wall_width: Size | None = key("of an L's wall", default=None)
    thickness: Wall | None = key("of sheet or plate and wall", default=None)
    flange: Size | None = key("of a U", default=None)
    depth: Size | None = key("of an L's plate", default=None)
    rim: Size | None = key("of an L below the bore", default=None)
    bend_radius: Size | None = key("of a U", default=None)
    fillet: Size | None = key("of a U's welds or an L's root", default=None)
    gusset: Distance | None = key("thickness of the ribs or braces", default=None)
    gusset_height: Distance | None = key("how far they reach down", default=None)
    step: Annotated[StepShape, StepTable] | None = key("another STEP file", default=None)

    def shape(self, before: Shape) -> Shape:
        """Return the shape with what is different."""
        if self.step is not None:
            return self.step
        changed = {n: v for n, v in _given(self).items() if v is not None}
        if not changed:
            self.at().refuse("says nothing that is different")
        for name in changed:
            if not hasattr(before, name):
                self.at(name).refuse(f"the shape above has no {name}")
        return self.attempt(lambda: replace(before, **changed))


class GaugeTable(Table):
    """A strain gauge on the bracket."""

    name: str = key("what reports call it: S1")
    point: Point = key("middle of its grid, from the bearing's centre; the nearest surface counts")
    direction: Way = key("along which it measures; it is laid into the surface")
    length: Size = key("of its grid", default=3 * mm)
    off: Distance = key("it may be glued, to any side; assumed if left out", default=1 * mm)
    askew: Angle = key("it may be glued; assumed if left out", default=2 * deg)

    def build(self) -> Gauge:
        """Return the gauge in SI."""
        return Gauge(
            name=self.name, point=self.point, direction=self.direction, length=self.length,
            off=self.off, askew=self.askew,
        )  # fmt: skip


class CaseTable(Table):
    """A load given by hand, along the vehicle's axes: rearward, to the right, up."""

    name: str = key("what reports call it")
    force: Force = key("on the bearing", default=(0.0, 0.0, 0.0))
    moment: Moment = key("about the bearing's centre", default=(0.0, 0.0, 0.0))
    acceleration: Acceleration = key(
        "of the frame, felt by bracket and carried mass; standing still is [0, 0, 1] g, which a "
        "state keeps where the last is 0",
        default=(0.0, 0.0, 0.0),
    )
    state: str | None = key(
        "the state whose driveline loads it comes on top of, where the bearing carries most",
        default=None,
    )

    def build(self) -> BracketCase:
        """Return the case in SI."""
        if not any((*self.force, *self.moment, *self.acceleration)):
            self.at().refuse("loads nothing", "give force_N, moment_Nm or acceleration_g")
        return BracketCase(
            name=self.name, force=self.force, moment=self.moment, acceleration=self.acceleration,
            state=self.state or "",
        )  # fmt: skip


class RecordingTable(Table):
    """What was measured: forces on the bearing, or strains of the bracket's gauges."""

    name: str = key("what reports call it")
    file: str = key(
        "a recording beside this file: channels x_N, y_N, z_N, as `cardan life --load-history` "
        "writes them, or one named after each gauge"
    )
    from_gauges: bool = key(
        "whether its forces were read from the bracket's gauges, as `cardan life` reads them",
        default=False,
    )

    def recording(self, gauges: tuple[Gauge, ...]) -> BracketRecording:
        """Return the recording in SI."""
        from cardan.files.recordings import open_recording

        path = self.at("file").beside(self.file)
        if not path.is_file():
            self.at("file").refuse("no such file", f"looked for {path}", got=self.file)
        found = open_recording(path)
        names = [c.name for c in found.channels]
        forces = [n for n in FORCE_CHANNELS if n in names]
        wanted = FORCE_CHANNELS if forces else tuple(g.name for g in gauges)
        missing = [n for n in wanted if n not in names]
        if missing or not wanted:
            self.at("file").refuse(
                f"has no channel {', '.join(missing) or 'of a force'}; it has {', '.join(names)}",
                "forces are x_N, y_N, z_N; strains are named after the bracket's gauges",
                got=self.file,
            )  # fmt: skip
        values = found.whole(wanted).T
        if len(values) < _SHORTEST:
            self.at("file").refuse("holds fewer than 4 samples", got=self.file)
        holes = int((~np.isfinite(values)).any(axis=1).sum())
        if holes:
            self.at("file").refuse(
                f"has {holes} samples that are no numbers", "mend it first: cardan life",
                got=self.file,
            )  # fmt: skip
        known, told = (
            (("N",), "forces are in N") if forces else (MICROSTRAIN, "strains are in um/m")
        )
        for name in wanted:
            unit = found.channel(name).unit
            if unit not in ("", *known):
                self.at("file").refuse(f"channel {name} is in {unit}; {told}", got=self.file)
        if forces:
            if self.from_gauges and len(gauges) < len(FORCE_CHANNELS):
                self.at("from_gauges").refuse(
                    "needs the gauges they were read from, 3 at least; the bracket has "
                    f"{len(gauges)}"
                )
            return BracketRecording(
                name=self.name, rate=found.rate, force=values, read=self.from_gauges
            )
        return BracketRecording(name=self.name, rate=found.rate, strain=values * 1e-6, read=True)


Recordings: TypeAlias = Annotated[
    tuple[RecordingTable, ...], ListOf(TableRule(RecordingTable), most=20)
]


class FatigueTable(Table):
    """What the bracket bears in fatigue, zone by zone; beyond each knee 2k - 1 holds."""

    one_of = (("amplitude", "roughness"),)

    amplitude: Strength | None = key(
        "of the sheet, fully reversed, at the knee of its S-N curve", default=None
    )
    cycles: Cycles = key("cycles to failure there", default=1e6)
    slope: Annotated[float, Number(least=1, most=100)] = key(
        "k of N ~ S^-k above the knee", default=5.0
    )
    roughness: Roughness | None = key(
        "Rz of the sheet's skin, 200 um as rolled: its amplitude then by the FKM guideline",
        default=None,
    )
    cut_edge: ADetail | None = key(
        "what cut edges bear, a detail of a catalogue; left out, the cautious one of its metal",
        default=None,
    )
    weld_toe: ADetail | None = key("what the toes of welds bear; left out as above", default=None)
    bolt_border: ADetail | None = key(
        "what the borders of bolts bear; left out as above", default=None
    )

    def sheet(self, material: Material) -> FatigueCurve:
        """Return the sheet's curve in SI."""
        amplitude = self.amplitude
        if self.roughness is not None:
            of = borne(material.metal)
            if of is None:
                self.at("roughness").refuse(
                    f"is of metals that the FKM guideline covers, and {material.name} is "
                    f"{material.metal}",
                    "give amplitude_MPa, or say the material's metal",
                )
            if material.ultimate_strength is None:
                self.at("roughness").refuse(
                    f"needs the ultimate strength of the material, and {material.name} states none",
                    "give it, or amplitude_MPa",
                )
            amplitude = sheet_amplitude(
                material.ultimate_strength, roughness=self.roughness, of=of.endurance
            )
        assert amplitude is not None  # one of the two is given
        return FatigueCurve(amplitude=amplitude, cycles=self.cycles, slope=self.slope)

    def details(self, material: Material) -> dict[Zone, FatigueCurve]:
        """Return the curves of the zones that the file gives one for."""
        given: dict[Zone, FatigueCurve] = {}
        for zone in DETAILED:
            curve: FatigueCurve | None = getattr(self, key_of(zone))
            if curve is None:
                continue
            if curve.metal and curve.metal != material.metal.removeprefix("cast "):
                self.at(key_of(zone)).refuse(
                    f"{curve.name} is of {curve.metal}, and {material.name} is {material.metal}",
                    "give its class in place, by range_MPa and slope",
                )
            given[zone] = curve
        return given


SIZE, WALL, DISTANCE = (get_args(kind)[1] for kind in (Size, Wall, Distance))
Walls: TypeAlias = Annotated[tuple[float, ...], ListOf(WALL, least=1, most=20)]
Sizes: TypeAlias = Annotated[tuple[float, ...], ListOf(SIZE, least=1, most=20)]
Distances: TypeAlias = Annotated[tuple[float, ...], ListOf(DISTANCE, least=1, most=20)]


class BoltsTable(Table):
    """What tightens the bracket: its flange is then in contact with the frame, with friction."""

    preload: Clamp | None = key(
        "of each bolt; default that of class 8.8 by the hole's size, 27 kN for an M10", default=None
    )
    friction: Annotated[float, Number(least=0.01, most=1)] = key(
        "between flange and frame, assumed if left out", default=0.15
    )

    def bolts(self, shape: Shape) -> Bolts:
        """Return the bolts in SI."""
        preload = self.preload
        if preload is None:
            if isinstance(shape, StepShape):
                self.at().refuse("needs the preload of a STEP file's bolts", "preload_kN: 27")
            preload = usual_preload(shape.bolt_diameter)
        return Bolts(preload=preload, friction=self.friction)


class OptimiseTable(Table):
    """Sizes that `cardan bracket --optimise` may choose from, for the lightest that lives."""

    life: Hours = key("to live at least, over the duty cycle")
    thickness: Walls | None = key("of sheet, or of plate and wall", default=None)
    width: Sizes | None = key("of the sheet or plate", default=None)
    flange: Sizes | None = key("of a U", default=None)
    bend_radius: Sizes | None = key("of a U", default=None)
    gusset: Distances | None = key("thickness of the ribs or braces; 0 is none", default=None)
    gusset_height: Distances | None = key("how far they reach down", default=None)
    wall_width: Sizes | None = key("of an L's wall", default=None)
    depth: Sizes | None = key("of an L's plate", default=None)
    rim: Sizes | None = key("of an L below the bore", default=None)
    fillet: Sizes | None = key("of a U's welds or an L's root", default=None)

    def search(self, shape: Shape) -> Search:
        """Return what may be chosen of a shape, in SI."""
        sizes = {n: tuple(v) for n, v in _given(self).items() if v is not None and n != "life"}
        if not sizes:
            self.at().refuse("gives nothing to choose from", "thickness_mm: [4, 5, 6, 8]")
        for name in sizes:
            if isinstance(shape, StepShape) or not hasattr(shape, name):
                self.at(name).refuse(f"the shape above has no {name} that can be chosen")
        count = prod(len(v) for v in sizes.values())
        if count > _MOST:
            self.at().refuse(f"makes {count} sets of sizes, more than {_MOST}", "give fewer")
        return Search(life=self.life, sizes=sizes)


class BracketTable(Table):
    """The bracket a centre bearing hangs in. Its origin is the bearing's centre."""

    fixed = True  # its shape is meshed, one at a time
    one_of = (("u_shape", "l_shape", "step"),)

    u_shape: Annotated[UShape, UShapeTable] | None = key("a bent sheet", default=None)
    l_shape: Annotated[LShape, LShapeTable] | None = key("a plate and a wall", default=None)
    step: Annotated[StepShape, StepTable] | None = key("a STEP file", default=None)
    material: AMaterial = key("a material of a catalogue, or its properties", default=STEEL)
    line: str | None = key("the driveline it belongs to; by default the first", default=None)
    bearing: Annotated[int, Whole(12)] = key("which centre bearing, from the front", default=1)
    carried_mass: Mass = key("bearing and share of the shafts that ride on it", default=0.0)
    rubber: Rubber | None = key(
        "stiffness between bearing and seat along x, y, z; rigid if left out", default=None
    )
    loss_factor: FrameLoss | None = key(
        f"of the bracket; {LOSS:g} assumed if left out", default=None
    )
    gauges: Annotated[tuple[Gauge, ...], ListOf(TableRule(GaugeTable), most=100)] = key(
        "strain gauges on it", default=()
    )
    cases: Annotated[tuple[BracketCase, ...], ListOf(TableRule(CaseTable), most=100)] = key(
        "loads given by hand", default=()
    )
    recordings: Annotated[
        tuple[RecordingTable, ...], ListOf(TableRule(RecordingTable), most=20)
    ] = key("what was measured on it", default=())
    fatigue: FatigueTable | None = key("S-N curves, for damage and life", default=None)
    reinforced: ReinforcedTable | None = key("a variant shown beside it", default=None)
    bolts: BoltsTable | None = key(
        "contact between flange and frame; without it the two ways it may be held", default=None
    )
    optimise: OptimiseTable | None = key("sizes to choose the lightest from", default=None)
    element: Size | None = key("largest edge of an element; default the thickness", default=None)
    order: Annotated[int, Whole(4, told=LEAST_ORDER)] = key(
        "degree of the displacements, 2 to 4; 1 is read as 2", default=2
    )

    def bracket(self, lines: tuple[Installed, ...], states: tuple[str, ...]) -> Bracket:
        """Return the bracket in SI."""
        own = [f"{state}: {what}" for state in states for what in OF_STATES]
        self.differ("gauges", [part.name for part in self.gauges])
        for k, part in enumerate(self.cases, 1):
            if part.name in own:
                self.at("cases", k).note(
                    "a load case of that state has this name", "give it another", got=part.name
                )
        by_hand = [part.name for part in self.cases]
        self.differ("cases", by_hand)
        self.differ("recordings", [part.name for part in self.recordings], beside=own + by_hand)
        for k, case in enumerate(self.cases, 1):
            if case.state and case.state not in states:
                hint = nearest(case.state, list(states))
                self.at("cases", k).refuse("no state of this name", hint, got=case.state)
        known = {installed.line.name: installed.line for installed in lines}
        line = self.line or next(iter(known))
        if line not in known:
            hint = nearest(line, list(known))
            self.at("line").refuse("no driveline of this name", hint, got=line)
        count = known[line].joint_count - 2
        if self.bearing > count:
            message = f"line {line} has {count} centre bearing{'s' * (count != 1)}"
            self.at("bearing").refuse(message, got=str(self.bearing))
        shape = next(s for s in (self.u_shape, self.l_shape, self.step) if s is not None)
        if self.order < LEAST_ORDER:  # a file may say it that was written when it was taken
            self.at("order").warn(
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
                loss=LOSS if self.loss_factor is None else self.loss_factor,
                loss_assumed=self.loss_factor is None,
                gauges=self.gauges,
                cases=self.cases,
                recordings=tuple(r.recording(self.gauges) for r in self.recordings),
                reinforced=self.reinforced.shape(shape) if self.reinforced else None,
                element=self.element,
                order=max(self.order, LEAST_ORDER),
                fatigue=self.fatigue.sheet(self.material) if self.fatigue else None,
                details=self.fatigue.details(self.material) if self.fatigue else {},
                bolts=self.bolts.bolts(shape) if self.bolts else None,
                search=self.optimise.search(shape) if self.optimise else None,
            )
        )
