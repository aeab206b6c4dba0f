"""The application file: `read` it into parts, with everything wrong in it said at once."""

from collections.abc import Iterable, Iterator
from contextlib import suppress
from dataclasses import replace
from functools import lru_cache
from pathlib import Path
from typing import Annotated, Any, Literal, TypeAlias, get_args

import numpy as np

from cardan.application.catalogue import Catalogue, CatalogueCsvFile
from cardan.application.driveline_section import AdjustTable, LineTable
from cardan.application.duty_cycles import DutyCycleNameField
from cardan.application.geometry_section import StateGeometryTable
from cardan.application.limit_profiles import (
    DEFAULT_PROFILE_NAME,
    INLINE_LIMITS_NAME,
    OVERRIDDEN_PROFILE_SUFFIX,
    LimitProfile,
    LimitsFromTables,
    LimitTable,
    load_profile,
)
from cardan.application.limit_profiles import profile_names as profiles
from cardan.application.placeholders import checked_placeholders
from cardan.application.plausibility import plausibility_warnings
from cardan.application.report_section import ReportTable
from cardan.application.vehicle_section import (
    AxleFromTable,
    EngineTable,
    GearboxTable,
    SuspensionFromTable,
    TyreTable,
    VehicleTable,
)  # fmt: skip
from cardan.core.errors import FileIssue, InvalidFileError, values_of_first_violating_case
from cardan.model.adjustments import permitted_adjustments_by_name
from cardan.model.application import (
    Application,
    ApplicationSourceText,
    DutyCycle,
    DutyPoint,
    GearboxAndAxleRotors,
    InstalledLine,
    Obstacle,
    PermittedAdjustment,
    ReportIdentification,
    VehicleState,
)  # fmt: skip
from cardan.model.layout import Layout
from cardan.model.powertrain import Launch
from cardan.model.variants import VariantStudy, without_addresses_of_study_section
from cardan.model.vehicle import Engine, Gearbox, SuspensionState, Tyre, Vehicle
from cardan.physics.vehicle.axle_loads import driven_axle_count
from cardan.physics.vehicle.torque import DIRECT_DRIVE
from cardan.schema.field_types import (
    EnumField,
    ListField,
    MappingField,
    NumberField,
    TextField,
    UnionField,
)
from cardan.schema.fields import (  # fmt: skip
    Angle,
    AxleTravel,
    ObstacleCoordinates,
    PartDimension,
    Percent,
    PitchAngle,
    PositiveInertia,
    Speed,
    TopSpeed,
    Torque,
    TorsionStiffness,
)
from cardan.schema.node_reader import (
    InvalidValueError,
    NodeReader,
    ReferencedFile,
    TableReadContext,
    TooManyIssuesError,
    nearest_name_hint,
)
from cardan.schema.tables import LazyTableField, Table, TableField, table_key_field
from cardan.schema.yaml_tree import (
    Mapping,
    Node,
    Scalar,
    Sequence,
    parse_yaml,
    read_table_text,
    read_text,
)

MAX_CATALOGUES = 20
"""Of one application: one for each kind of part would do."""

MAX_CHECKS = 50_000
"""Answers of one file: a tandem with all states and some obstacles has 500."""

MAX_LINES = 8
"""Of one vehicle: an 8x8 has seven."""

PRIME_MOVER_LIFE_FACTORS = {"diesel": 1.25, "petrol": 1.2, "electric": 1.0}
"""Prime mover factors of a joint's life. Source: Dana GWB catalogue, K1."""


def read(
    path: str | Path, *, allow_outside: bool = False, beside: list[ReferencedFile] | None = None
) -> Application:
    """Return the application a file describes, in SI.

    Profiles, catalogues and STEP files that it names must lie in its own folder, unless
    `allow_outside`: a file from outside must not read other files on this machine. `beside`
    is given each that is looked up.

    Raises
    ------
    InvalidFileError
        With everything wrong in it: line, column, key, value, what is allowed and advice.
        What looks wrong but can be read is in `Application.warnings`.
    """
    path = Path(path)
    return loads(
        read_text(path), name=str(path), folder=path.parent, allow_outside=allow_outside,
        beside=beside,
    )  # fmt: skip


def loads(
    text: str,
    *,
    name: str = "application",
    folder: Path | None = None,
    allow_outside: bool = False,
    warn: bool = True,
    beside: list[ReferencedFile] | None = None,
) -> Application:
    """Return the application a text describes; `read` is the same for a file.

    `name` is what errors call the text. Profiles and catalogues of the user's own are files
    in `folder`; a text without one stands alone. Without `warn` it is not checked whether what can
    be read looks wrong. `beside` is given each file that is looked up, whatever comes of it.
    """
    written = ApplicationSourceText(
        text=text, name=name, folder=folder, allow_outside=allow_outside
    )
    return read_source_text(written, warn=warn, beside=beside)


def read_source_text(
    written: ApplicationSourceText, *, warn: bool = True, beside: list[ReferencedFile] | None = None
) -> Application:
    """Return the application of a text with its changes made."""
    name = written.name
    root, wrong = _parsed(written.text, name)
    problems = list(wrong)
    reading = TableReadContext(
        problems=problems,
        folder=written.folder,
        changes=written.changes,
        allow_outside=written.allow_outside,
        referenced_files=[] if beside is None else beside,
    )
    try:
        reading.catalogue = Catalogue(tuple(_sheets(root, reading)))
        application: Application | None = ApplicationTable.read(NodeReader(root, "", reading))
    except (InvalidValueError, TooManyIssuesError):
        application = None
    known = {*reading.numbers, *reading.fixed_numbers}
    if application is not None:
        problems += [_unknown(at, known) for at in written.changes if at not in known]
    if application is None or problems:
        # What only looks wrong may be why the rest is: say it too.
        raise InvalidFileError(name, (*problems, *reading.warnings))
    read = replace(
        written,
        numbers=reading.numbers,
        fixed_numbers=reading.fixed_numbers,
        referenced_files=tuple(b.path for b in reading.referenced_files),
        application=application,
    )
    spread = any(np.ndim(to) for to in written.changes.values())
    told = _warnings(application, reading) if warn and not spread else ()
    return replace(application, written=read, warnings=told)


@lru_cache(4)
def _parsed(text: str, name: str) -> tuple[Node, tuple[FileIssue, ...]]:
    """Return the tree of a text, never changed; it may be read again with other numbers."""
    root, problems = parse_yaml(text, name)
    return root, tuple(problems)


def catalogue_of_application(application: Application) -> Catalogue:
    """Return the catalogues an application takes its parts from, its own before those shipped."""
    written = application.written
    if written is None:
        return Catalogue()
    root, problems = parse_yaml(written.text, written.name)
    reading = TableReadContext(
        problems=problems, folder=written.folder, allow_outside=written.allow_outside
    )
    return Catalogue(tuple(_sheets(root, reading)))


def _warnings(application: Application, reading: TableReadContext) -> tuple[FileIssue, ...]:
    """Return what looks wrong, by itself or next to other numbers, in the file's order."""
    odd = {w.key for w in reading.warnings}  # by itself: enough said
    numbers = {**reading.numbers, **reading.fixed_numbers}
    beside = (w for w in plausibility_warnings(application, numbers) if w.key not in odd)
    every = dict.fromkeys((*reading.warnings, *beside))  # a line may be tried more than once
    return tuple(sorted(every, key=lambda p: (p.line, p.column)))


def _unknown(address: str, known: Iterable[str]) -> FileIssue:
    """Return what is wrong with a change to a number that the text does not hold."""
    return FileIssue(
        message="no number has this address", key=address, hint=nearest_name_hint(address, known)
    )


# --------------------------------------------------------------------------- other files


def _note(error: InvalidFileError, here: NodeReader) -> None:
    """Note the problems of another file where this one names it."""
    for problem in error.problems:
        here.add_issue(problem.format_with_location(error.file))


def _sheets(root: Node, reading: TableReadContext) -> Iterator[CatalogueCsvFile]:
    """Read the user's own catalogues, which the names in the file may come from."""
    if not isinstance(root, Mapping) or "catalogues" not in root.entries:
        return
    node = root.entries["catalogues"][1]
    items = node.items if isinstance(node, Sequence) else [node]
    places = [NodeReader(item, "catalogues", reading) for item in items[:MAX_CATALOGUES]]
    sheets: list[tuple[CatalogueCsvFile, NodeReader]] = []
    for here in places:
        if isinstance(here.node, Scalar) and isinstance(here.node.value, str):
            try:
                path = here.referenced_path(here.node.text)
                sheets.append((CatalogueCsvFile(read_table_text(path), str(path)), here))
            except InvalidFileError as error:
                _note(error, here)
            except InvalidValueError:
                continue
    catalogue = Catalogue(tuple(sheet for sheet, _ in sheets))
    for k, (sheet, here) in enumerate(sheets):
        own = TableReadContext(catalogue)
        with suppress(TooManyIssuesError):
            sheet.check(own, [s for s, _ in sheets[:k]])
        _note(InvalidFileError(sheet.file, tuple(own.problems)), here)
    yield from catalogue.user_sheets


class LimitProfileNameField(TextField):
    """A profile that comes with this package, or the file of one next to the application."""

    singular, plural = "a limit profile", "limit profiles"

    def read(self, here: NodeReader) -> LimitProfile:
        """Return its name and limits."""
        name = self.read_text_value(here)
        beside = name.endswith((".yaml", ".yml"))
        try:
            return load_profile(str(here.referenced_path(name)) if beside else name)
        except InvalidFileError as error:
            _note(error, here)
            raise InvalidValueError from None

    def schema(self, defs: dict[str, Any], unit: str) -> dict[str, Any]:
        """Return a shipped profile, which editors offer, or the file of one's own."""
        return {"anyOf": [{"enum": list(profiles())}, super().schema(defs, unit)]}


class InlineLimitListField(ListField):
    """Limits given in place."""

    def __init__(self) -> None:
        super().__init__(TableField(LimitTable), most=500)

    def read(self, here: NodeReader) -> LimitProfile:
        """Return them, named as they are."""
        return INLINE_LIMITS_NAME, super().read(here)


LimitProfileByName: TypeAlias = Annotated[LimitProfile, LimitProfileNameField()]


class ProfileOverridesTable(Table):
    """A profile with some of its limits replaced."""

    profile: LimitProfileByName = table_key_field("the profile to start from")
    overrides: LimitsFromTables = table_key_field("limits that replace those of the same quantity")

    def build(self) -> LimitProfile:
        """Return the profile's name and its limits as replaced."""
        name, start = self.profile
        replaced = {limit.quantity for limit in self.overrides}
        kept = tuple(limit for limit in start if limit.quantity not in replaced)
        return name + OVERRIDDEN_PROFILE_SUFFIX, kept + self.overrides


# --------------------------------------------------------------------------- tables


class SuspensionStateNameField(EnumField):
    """A suspension state, by its name alone."""

    def __init__(self) -> None:
        super().__init__(*get_args(SuspensionState))

    def read(self, here: NodeReader) -> VehicleState:
        """Return the state."""
        name = super().read(here)
        return VehicleState(name=name, kind=name)


class StateTable(StateGeometryTable):
    """A state to check: where the suspension places the axle, or a geometry of its own."""

    name: str = table_key_field("what reports call it")
    kind: SuspensionState | None = table_key_field(
        "how the suspension places the axle", default=None
    )
    load: str | None = table_key_field("the vehicle's load state that counts", default=None)
    travel: AxleTravel | None = table_key_field(
        "rise of the axle from the reference state", default=None
    )
    pitch: PitchAngle | None = table_key_field(
        "turn of the axle, pinion nose up positive", default=None
    )
    articulation: AxleTravel | None = table_key_field(
        "of a tandem: its forward axle up and the other down by this", default=None
    )
    torque: Torque | None = table_key_field("at the gearbox output", default=None)
    speed: Speed | None = table_key_field("of the gearbox output", default=None)
    drivelines: Annotated[
        dict[str, StateGeometryTable],
        MappingField(TextField(), TableField(StateGeometryTable), most=MAX_LINES),
    ] = table_key_field("geometry of each of several", default={})

    def state(self, lines: tuple[InstalledLine, ...], vehicle: Vehicle | None) -> VehicleState:
        """Return the state of an application's lines, in SI."""
        by_name = {installed.line.name: installed for installed in lines}
        layouts, offsets = dict(self._layouts(by_name)), dict(self._offsets(by_name))
        kind = self.kind
        if kind is None and self.name in get_args(SuspensionState):
            placed = layouts or self.travel is not None
            kind = None if placed else self.name  # its name says how, unless something else does
        loads = [load.name for load in vehicle.loads] if vehicle else []
        if self.load is not None and self.load not in loads:
            hint = nearest_name_hint(self.load, loads)
            self.reader_of("load").reject("the vehicle has no such load state", hint, got=self.load)
        if self.articulation is not None and not any(i.output_joint for i in lines):
            hint = "give the line between the axles an output_joint"
            self.reader_of("articulation").reject("no line runs from axle to axle", hint)
        load = self.load
        if load is None and kind is None and self.name in loads:
            load = self.name
        return VehicleState(
            name=self.name,
            kind=kind,  # type: ignore[arg-type]  # one of its names
            load=load,
            travel=self.travel,
            pitch=self.pitch,
            articulation=0.0 if self.articulation is None else self.articulation,
            torque=self.torque,
            speed=self.speed,
            layouts=layouts or None,
            bearing_offsets=offsets,
        )

    def _layouts(self, lines: dict[str, InstalledLine]) -> Iterator[tuple[str, Layout]]:
        given: dict[str, StateGeometryTable] = dict(self.drivelines)
        own = ("slopes", "joint_angles", "points", "gearbox_slope", "pinion_slope", "last_length")
        if any(self.has(name) for name in own):
            if len(lines) > 1 or given:
                first = next(name for name in own if self.has(name))
                self.reader_of(first).reject("give the geometry of each line in drivelines")
            given = {next(iter(lines)): self}
        for name, table in given.items():
            if name not in lines:
                hint = nearest_name_hint(name, list(lines))
                self.reader_of("drivelines").reject("no driveline of this name", hint, got=name)
            if not table.gives_geometry:
                if table.bearing_offset:
                    continue
                table.reader_of().reject("needs slopes, joint_angles or points_mm")
            line = lines[name]
            yield name, table.state_layout(line.line.lengths, line.layout)

    def _offsets(
        self, lines: dict[str, InstalledLine]
    ) -> Iterator[tuple[str, dict[int, tuple[float, float]]]]:
        """Yield how far the frame moves the bearings of each line."""
        given: dict[str, StateGeometryTable] = dict(self.drivelines)
        if self.bearing_offset:
            if len(lines) > 1:
                self.reader_of("bearing_offset").reject("give that of each line in drivelines")
            given = {next(iter(lines)): self}
        for name, table in given.items():
            if not table.bearing_offset or name not in lines:
                continue
            here = table.reader_of("bearing_offset")
            if table.gives_geometry:
                here.reject("a geometry of its own says where the bearings are")
            count = len(lines[name].line.shafts) - 1
            for number in table.bearing_offset:
                if number > count:
                    here.reject(f"line {name} has no centre bearing {number}", f"it has {count}")
            yield name, table.bearing_offset


class ObstacleTable(Table):
    """Something a line must clear: a round bar between two points, or a ball."""

    at_most_one_of = (("radius", "diameter"),)

    name: str = table_key_field("what reports call it")
    start: ObstacleCoordinates = table_key_field(
        "one end of its axis, in the frame of the line's points"
    )
    end: ObstacleCoordinates | None = table_key_field(
        "the other end; a ball has none", default=None
    )
    radius: PartDimension | None = table_key_field("around the axis", default=None)
    diameter: PartDimension | None = table_key_field("around the axis", default=None)
    travel_share: Annotated[float, NumberField(least=-2, most=2)] = table_key_field(
        "how much of the axle's rise it makes: 0 on the frame, 1 on the axle", default=0.0
    )
    line: str | None = table_key_field("the driveline it is in the way of", default=None)

    def obstacle(self, lines: tuple[InstalledLine, ...]) -> Obstacle:
        """Return the obstacle in SI."""
        known = [installed.line.name for installed in lines]
        line = self.line or known[0]
        if line not in known:
            self.reader_of("line").reject(
                "no driveline of this name", nearest_name_hint(line, known), got=line
            )
        radius = 0.0 if self.diameter is None else self.diameter / 2
        return Obstacle(
            name=self.name,
            start=self.start,
            end=self.end or self.start,
            radius=radius if self.radius is None else self.radius,
            travel_share=self.travel_share,
            line=line,
        )


class DutyPointTable(Table):
    """A share of the life."""

    share: Percent = table_key_field("of the time; all shares make 100")
    torque: Torque = table_key_field("at the gearbox output")
    speed: Speed = table_key_field("of the gearbox output")
    angle: Angle | None = table_key_field("joint angle, in place of the computed one", default=None)

    def build(self) -> DutyPoint:
        """Return the share in SI."""
        return DutyPoint(share=self.share, torque=self.torque, speed=self.speed, angle=self.angle)


class AdjacentRotorsTable(Table):
    """What turns with the lines at both ends; `cardan stability` assumes what is not given."""

    axle_inertia: PositiveInertia | None = table_key_field(
        "of what turns behind the pinion, reflected to it", default=None
    )
    axle_stiffness: TorsionStiffness | None = table_key_field(
        "of the spring between pinion and that; rigid without", default=None
    )
    gearbox_inertia: PositiveInertia | None = table_key_field(
        "of what turns with the gearbox flange, which turns uniformly without", default=None
    )
    gearbox_stiffness: TorsionStiffness | None = table_key_field(
        "of the spring from the flange to the uniformly turning engine", default=None
    )
    damping_ratio: Annotated[float, NumberField(least=1e-5, below=1, usual=(2e-3, 0.3))] | None = (
        table_key_field("of the first torsional mode", default=None)
    )

    def build(self) -> GearboxAndAxleRotors:
        """Return it in SI."""
        if (self.gearbox_inertia is None) != (self.gearbox_stiffness is None):
            self.reader_of().reject("give both the gearbox inertia and its stiffness, or neither")
        return GearboxAndAxleRotors(
            axle_inertia=self.axle_inertia,
            axle_stiffness=self.axle_stiffness,
            gearbox_inertia=self.gearbox_inertia,
            gearbox_stiffness=self.gearbox_stiffness,
            damping_ratio=self.damping_ratio,
        )


_LAUNCH = LazyTableField("cardan.topics.torsion.schema", "LaunchTable")
_STATES = ListField(UnionField(SuspensionStateNameField(), TableField(StateTable)), most=200)
_OBSTACLES = ListField(TableField(ObstacleTable), most=200)
_DUTY = UnionField(ListField(TableField(DutyPointTable), most=1000), DutyCycleNameField())
_CATALOGUES = UnionField(TextField(), ListField(TextField(), most=MAX_CATALOGUES))
_LIMITS = UnionField(
    LimitProfileNameField(), TableField(ProfileOverridesTable), InlineLimitListField()
)


class ApplicationTable(Table):
    """A driveline application: lines in a vehicle, the states to check, the limits."""

    one_of = (("driveline", "drivelines"),)

    title: Annotated[str, TextField(300)] = table_key_field("what reports call it")
    driveline: LineTable | None = table_key_field("the line, gearbox to axle", default=None)
    drivelines: Annotated[
        dict[str, LineTable], MappingField(TextField(), TableField(LineTable), most=MAX_LINES)
    ] = table_key_field("several lines by name: main, inter-axle", default={})
    torque: Torque | None = table_key_field(
        "at the gearbox output, in place of engine and tyres", default=None
    )
    coast_torque: Torque | None = table_key_field("the same, holding back", default=None)
    speed: TopSpeed | None = table_key_field("top speed of the gearbox output", default=None)
    vehicle: Annotated[Vehicle, VehicleTable] | None = table_key_field(
        "drive and loads", default=None
    )
    engine: Annotated[Engine, EngineTable] | None = table_key_field("its torque", default=None)
    gearbox: Annotated[Gearbox, GearboxTable] | None = table_key_field("its ratios", default=None)
    axle: AxleFromTable | None = table_key_field(
        "of every line that has none of its own", default=None
    )
    tyre: Annotated[Tyre, TyreTable] | None = table_key_field("of the driven wheels", default=None)
    suspension: SuspensionFromTable | None = table_key_field("of the rear axles", default=None)
    states: Annotated[tuple[VehicleState | StateTable, ...], _STATES] = table_key_field(
        "suspension states by name, or tables of your own", default=()
    )
    obstacles: Annotated[tuple[ObstacleTable, ...], _OBSTACLES] = table_key_field(
        "what a line must clear", default=()
    )
    limits: Annotated[LimitProfile, _LIMITS] | None = table_key_field(
        "a profile, a file of one, a profile with overrides, or limits", default=None
    )
    duty: Annotated[tuple[DutyPoint, ...] | DutyCycle, _DUTY] = table_key_field(
        "how the life is spent: shares, or the name of a cycle", default=()
    )
    adjust: AdjustTable | None = table_key_field("what `cardan fix` may move", default=None)
    bracket: (
        Annotated[Any, LazyTableField("cardan.topics.bracket.schema", "BracketTable")] | None
    ) = table_key_field("what a centre bearing hangs in", default=None)
    torsion: Annotated[GearboxAndAxleRotors, AdjacentRotorsTable] | None = table_key_field(
        "what turns with the lines at both ends", default=None
    )
    clutch: Annotated[Any, LazyTableField("cardan.topics.torsion.schema", "ClutchTable")] | None = (
        table_key_field("between engine and gearbox", default=None)
    )
    dual_mass_flywheel: (
        Annotated[Any, LazyTableField("cardan.topics.torsion.schema", "DualMassFlywheelTable")]
        | None
    ) = table_key_field("ahead of the clutch", default=None)
    converter: (
        Annotated[Any, LazyTableField("cardan.topics.torsion.schema", "ConverterTable")] | None
    ) = table_key_field("in place of the clutch", default=None)
    inter_axle: (
        Annotated[Any, LazyTableField("cardan.topics.torsion.schema", "InterAxleDifferentialTable")]
        | None
    ) = table_key_field("the differential of a tandem", default=None)
    wheels: Annotated[Any, LazyTableField("cardan.topics.torsion.schema", "WheelsTable")] | None = (
        table_key_field("with their tyres", default=None)
    )
    launch: Annotated[Any, UnionField(_LAUNCH, ListField(_LAUNCH, most=20))] | None = (
        table_key_field("starts from rest, one or several", default=None)
    )
    study: Annotated[Any, LazyTableField("cardan.topics.variants.schema", "StudyTable")] | None = (
        table_key_field(
            "what varies, what scatters, and what is evaluated of all variants", default=None
        )
    )
    prime_mover: Literal["diesel", "petrol", "electric"] = table_key_field(
        "engine", default="diesel"
    )
    shock_factor: Annotated[float, NumberField(least=1, most=10)] = table_key_field(
        "on the torque the joints are sized for: 1.2 smooth to 6 extreme", default=1.0
    )
    include: Annotated[tuple[str, ...], ListField(EnumField("gravity", "unbalance"), most=2)] = (
        table_key_field("what is added to the centre bearings' loads", default=())
    )
    report: Annotated[ReportIdentification, ReportTable] | None = table_key_field(
        "customer, drawing and signatures of its reports", default=None
    )
    placeholders: Annotated[tuple[str, ...], ListField(TextField(), most=100)] = table_key_field(
        "keys whose values are not the vehicle's yet; nothing is evaluated until they are",
        default=(),
    )
    catalogues: Annotated[
        str | tuple[str, ...], UnionField(TextField(), ListField(TextField(), most=MAX_CATALOGUES))
    ] = table_key_field("CSV files of your own parts", default=())

    def build(self) -> Application:
        """Return the application in SI."""
        tables = self.drivelines or ({"main": self.driveline} if self.driveline else {})
        if not tables:
            self.reader_of("drivelines").reject("needs at least one line")
        lines = tuple(table.installed_line(name, axle=self.axle) for name, table in tables.items())
        if self.vehicle is not None:
            self._find_driven(self.vehicle, list(tables.values()))
        states = self._states(lines)
        self._say_what_is_missing(states)
        name, held = self.limits or load_profile(DEFAULT_PROFILE_NAME)
        self.require_different_names("obstacles", [o.name for o in self.obstacles])
        self._hold_the_amount(lines, states)
        return Application(
            title=self.title,
            lines=lines,
            states=states,
            limits=held,
            profile=name,
            torque=self.torque,
            coast_torque=self.coast_torque,
            speed=self.speed,
            vehicle=self.vehicle,
            engine=self.engine,
            gearbox=self._gearbox(),
            tyre=self.tyre,
            suspension=self.suspension,
            obstacles=tuple(o.obstacle(lines) for o in self.obstacles),
            duty=() if isinstance(self.duty, DutyCycle) else self._duty(self.duty),
            duty_cycle=self.duty if isinstance(self.duty, DutyCycle) else None,
            adjustables=tuple(self._adjustables(lines, list(tables.values()))),
            bracket=self.bracket.bracket(lines, tuple(s.name for s in states))
            if self.bracket
            else None,
            torsion=self._torsion(),
            clutch=self.clutch,
            dual_mass_flywheel=self.dual_mass_flywheel,
            converter=self.converter,
            inter_axle=self.inter_axle,
            wheels=self.wheels,
            launches=self._launches(),
            variants=self._variants(lines),
            report=self.report or ReportIdentification(),
            placeholders=checked_placeholders(self.placeholders, self.reader_of("placeholders")),
            electric=self.prime_mover == "electric",
            prime_mover_factor=PRIME_MOVER_LIFE_FACTORS[self.prime_mover],
            shock_factor=self.shock_factor,
            include_gravity="gravity" in self.include,
            include_unbalance="unbalance" in self.include,
            source_locations=self.reader_of().context.locations,
        )

    def _variants(self, lines: tuple[InstalledLine, ...]) -> VariantStudy | None:
        """Return the study, whose names must be those of numbers that stand in the file."""
        if self.study is None:
            return None
        reading = self.reader_of().context
        numbers = without_addresses_of_study_section((*reading.numbers, *reading.fixed_numbers))
        return self.study.variants(
            (*numbers, *permitted_adjustments_by_name(i.line for i in lines))
        )

    def _gearbox(self) -> Gearbox | None:
        """Return the gearbox, with the torque ratio of the converter that stands ahead of it.

        A file may say that with either; one that it says twice must be one.
        """
        gearbox: Gearbox | None = self.gearbox
        stall = 1.0 if self.converter is None else self.converter.stall_torque_ratio
        if stall == 1:
            return gearbox
        known = 1.0 if gearbox is None else gearbox.converter_ratio
        if known not in (1.0, stall):
            message = f"stall_torque_ratio must be the gearbox's converter_ratio, {known:g}"
            self.reader_of("converter").reject(message, got=f"{stall:g}")
        return replace(gearbox or DIRECT_DRIVE, converter_ratio=stall)

    def _torsion(self) -> GearboxAndAxleRotors | None:
        """Return what the first plan's table says, refused together with its own parts."""
        if self.torsion is not None:
            for name in ("clutch", "dual_mass_flywheel", "converter", "inter_axle", "wheels"):
                if self.has(name):
                    message = f"stands in place of the table {name}, not with it: give the parts"
                    self.reader_of("torsion").reject(message)
        if self.clutch is not None and self.converter is not None:
            self.reader_of("converter").reject("stands in place of a clutch, not with it")
        return self.torsion

    def _launches(self) -> tuple[Launch, ...]:
        """Return the starts from rest, in gears and under loads that there are."""
        given: Any = self.launch
        found: tuple[Launch, ...] = given if isinstance(given, tuple) else (given,) * bool(given)
        gears = len(self.gearbox.ratios) if self.gearbox else 1
        astern = self.gearbox is not None and self.gearbox.reverse_ratio is not None
        each = [*map(str, range(1, gears + 1)), *["R"] * astern]
        names = {f"{low}{k}" for low in ("", "low ") for k in each}
        loads = {load.name for load in self.vehicle.loads} if self.vehicle else set[str]()
        for k, launch in enumerate(found, 1):
            at = (
                self.reader_of("launch", k)
                if isinstance(given, tuple)
                else self.reader_of("launch")
            )
            if launch.gear not in names:
                at.reject(
                    f"has no gear {launch.gear}",
                    f"there are 1 to {gears}, and R" if astern
                    else f"there are 1 to {gears}; R needs gearbox.reverse_ratio",
                )  # fmt: skip
            if launch.load is not None and launch.load not in loads:
                at.reject(f"the vehicle has no load state {launch.load}",
                          nearest_name_hint(launch.load, loads))  # fmt: skip
        return found

    @staticmethod
    def _find_driven(vehicle: Vehicle, tables: list[LineTable]) -> None:
        """Refuse a line to axles that the vehicle does not drive."""
        for table in tables:
            if not driven_axle_count(vehicle, drives=table.drives):
                message = f"a {vehicle.drive} drives no {table.drives} axle for a line to turn"
                table.reader_of("drives").reject(message)

    def _states(self, lines: tuple[InstalledLine, ...]) -> tuple[VehicleState, ...]:
        states: list[VehicleState] = []
        for k, entry in enumerate(self.states, 1):
            state = entry if isinstance(entry, VehicleState) else entry.state(lines, self.vehicle)
            self._placed(k, state, lines)
            states.append(state)
        self.require_different_names("states", [s.name for s in states])
        return tuple(states) or (VehicleState(name="as given"),)

    def _placed(self, k: int, state: VehicleState, lines: tuple[InstalledLine, ...]) -> None:
        """Refuse a state in which nothing can say where an axle is."""
        kind = state.kind
        for installed in lines:
            own = state.layouts and installed.line.name in state.layouts
            if kind is None or own or installed.drives == "all":
                continue
            rear = self.suspension if installed.drives == "rear" else None
            suspension = installed.suspension or rear
            where = f"{installed.drives} axle of line {installed.line.name}"
            moves = kind != (suspension.reference if suspension else "gvw")
            if "windup" in kind and state.pitch is None:
                if suspension is None or suspension.windup_stiffness is None:
                    message = f"state {state.name} winds up the {where}: how stiff is it?"
                    hint = (
                        "give its suspension a windup_stiffness_kNm_deg, or the state a pitch_deg"
                    )
                    self.reader_of("states", k).add_issue(message, hint)
            elif suspension is None and state.travel is None and moves:
                message = f"state {state.name} moves the {where}: how far?"
                hint = "give a suspension, or the state its own slopes or travel_mm"
                self.reader_of("states", k).add_issue(message, hint)

    def _say_what_is_missing(self, states: tuple[VehicleState, ...]) -> None:
        for name, still, unchecked in (
            ("torque", "nothing pulls", "loads, strength and life"),
            ("speed", "nothing turns", "accelerations and critical speeds"),
        ):
            given = getattr(self, name)
            if given is not None and np.all(given == 0):
                self.reader_of(name).warn(f"{still}: {unchecked} cannot be checked")
        if self.engine is None and self.torque is None and any(s.torque is None for s in states):
            message = "no torque is given: loads, strength and life cannot be checked"
            self.reader_of().warn(message, "give torque_Nm, or an engine and a gearbox")
        if self.engine is None and self.speed is None and any(s.speed is None for s in states):
            message = "no speed is given: accelerations and critical speeds cannot be checked"
            self.reader_of().warn(message, "give speed_rpm, or an engine and a gearbox")

    def _hold_the_amount(
        self, lines: tuple[InstalledLine, ...], states: tuple[VehicleState, ...]
    ) -> None:
        """Refuse an application too large to compute or to read its results."""
        shafts = sum(len(installed.line.shafts) for installed in lines)
        checks = len(states) * shafts * max(len(self.obstacles), 10)
        if checks > MAX_CHECKS:
            message = (
                f"{len(states)} states of {shafts} shafts and {len(self.obstacles)} obstacles are "
                f"some {checks} checks; one file can have up to {MAX_CHECKS}"
            )
            self.reader_of("states").reject(message, "split it into several files")

    def _duty(self, points: tuple[DutyPoint, ...]) -> tuple[DutyPoint, ...]:
        total = sum(point.share for point in points)
        if points and (
            wrong := values_of_first_violating_case(abs(total - 1) <= 1e-3 + 1e-9, total)
        ):
            self.reader_of("duty").reject("the shares must make 100 %", got=f"{100 * wrong[0]:g} %")
        # What rounding leaves of 100 % is shared out: more than all of a life is no life.
        return tuple(replace(point, share=point.share / total) for point in points)

    def _adjustables(
        self, lines: tuple[InstalledLine, ...], tables: list[LineTable]
    ) -> Iterator[PermittedAdjustment]:
        if self.adjust is not None and (len(tables) > 1 or tables[0].adjust):
            self.reader_of("adjust").reject("give this inside each of the drivelines")
        for installed, table in zip(lines, tables, strict=True):
            if adjust := table.adjust or self.adjust:
                yield from adjust.adjustables(installed.line)
