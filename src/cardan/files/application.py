"""The application file: `read` it into parts, with everything wrong in it said at once."""

from collections.abc import Iterable, Iterator
from contextlib import suppress
from dataclasses import replace
from functools import lru_cache
from pathlib import Path
from typing import Annotated, Any, Literal, TypeAlias, get_args

import numpy as np

from cardan.base.errors import BadFile, Problem, failing
from cardan.border.document import Mapping, Node, Scalar, Sequence, parse, text_of
from cardan.border.measure import (  # fmt: skip
    Angle,
    BesidePoint,
    Percent,
    Pitch,
    PositiveInertia,
    Size,
    Speed,
    TopSpeed,
    Torque,
    TorsionStiffness,
    Travel,
)
from cardan.border.table import (
    Beside,
    Choice,
    Enough,
    Here,
    Later,
    ListOf,
    MapOf,
    Number,
    OneOf,
    Reading,
    Spoilt,
    Table,
    TableRule,
    Text,
    key,
    nearest,
)  # fmt: skip
from cardan.demand.axles import driven_axles
from cardan.demand.torque import DIRECT
from cardan.files.catalogue import Catalogue, Sheet
from cardan.files.cycle import CycleName
from cardan.files.geometry import StateGeometryTable
from cardan.files.limit import DEFAULT, Limits, LimitTable, Profile, limits
from cardan.files.limit import names as profiles
from cardan.files.line import AdjustTable, LineTable
from cardan.files.plausible import doubts
from cardan.files.vehicle import (
    AnAxle,
    ASuspension,
    EngineTable,
    GearboxTable,
    TyreTable,
    VehicleTable,
)  # fmt: skip
from cardan.model.application import (
    Adjustable,
    Application,
    DutyCycle,
    DutyPoint,
    Installed,
    Obstacle,
    State,
    Surroundings,
    Written,
)  # fmt: skip
from cardan.model.layout import Layout
from cardan.model.movable import movable
from cardan.model.turning import Launch
from cardan.model.variants import Variants
from cardan.model.vehicle import Engine, Gearbox, SuspensionState, Tyre, Vehicle

CATALOGUES = 20
"""Of one application: one for each kind of part would do."""

CHECKS = 50_000
"""Answers of one file: a tandem with all states and some obstacles has 500."""

LINES = 8
"""Of one vehicle: an 8x8 has seven."""

PRIME_MOVERS = {"diesel": 1.25, "petrol": 1.2, "electric": 1.0}
"""Prime mover factors of a joint's life. Source: Dana GWB catalogue, K1."""


def read(
    path: str | Path, *, allow_outside: bool = False, beside: list[Beside] | None = None
) -> Application:
    """Return the application a file describes, in SI.

    Profiles, catalogues and STEP files that it names must lie in its own folder, unless
    `allow_outside`: a file from somebody else is not to look around on this machine. `beside`
    is given each that is looked up.

    Raises
    ------
    BadFile
        With everything wrong in it: line, column, key, value, what is allowed and advice.
        What looks wrong but can be read is in `Application.warnings`.
    """
    path = Path(path)
    return loads(
        text_of(path), name=str(path), folder=path.parent, allow_outside=allow_outside,
        beside=beside,
    )  # fmt: skip


def loads(
    text: str,
    *,
    name: str = "application",
    folder: Path | None = None,
    allow_outside: bool = False,
    warn: bool = True,
    beside: list[Beside] | None = None,
) -> Application:
    """Return the application a text describes; `read` is the same for a file.

    `name` is what errors call the text. Profiles and catalogues of the user's own are files
    in `folder`; a text without one stands alone. Without `warn` nobody asks whether what can
    be read looks wrong. `beside` is given each file that is looked up, whatever comes of it.
    """
    written = Written(text=text, name=name, folder=folder, allow_outside=allow_outside)
    return understood(written, warn=warn, beside=beside)


def understood(
    written: Written, *, warn: bool = True, beside: list[Beside] | None = None
) -> Application:
    """Return the application of a text with its changes made."""
    name = written.name
    root, wrong = _parsed(written.text, name)
    problems = list(wrong)
    reading = Reading(
        problems=problems,
        folder=written.folder,
        changes=written.changes,
        allow_outside=written.allow_outside,
        beside=[] if beside is None else beside,
    )
    try:
        reading.catalogue = Catalogue(tuple(_sheets(root, reading)))
        application: Application | None = ApplicationTable.read(Here(root, "", reading))
    except (Spoilt, Enough):
        application = None
    known = {*reading.numbers, *reading.fixed}
    if application is not None:
        problems += [_unknown(at, known) for at in written.changes if at not in known]
    if application is None or problems:
        # What only looks wrong may be why the rest is: say it too.
        raise BadFile(name, (*problems, *reading.warnings))
    read = replace(
        written,
        numbers=reading.numbers,
        single=reading.fixed,
        beside=tuple(b.path for b in reading.beside),
        application=application,
    )
    spread = any(np.ndim(to) for to in written.changes.values())
    told = _warnings(application, reading) if warn and not spread else ()
    return replace(application, written=read, warnings=told)


@lru_cache(4)
def _parsed(text: str, name: str) -> tuple[Node, tuple[Problem, ...]]:
    """Return the tree of a text, which nobody changes; it may be read again with other numbers."""
    root, problems = parse(text, name)
    return root, tuple(problems)


def catalogue_of(application: Application) -> Catalogue:
    """Return the catalogues an application takes its parts from, its own before those shipped."""
    written = application.written
    if written is None:
        return Catalogue()
    root, problems = parse(written.text, written.name)
    reading = Reading(problems=problems, folder=written.folder, allow_outside=written.allow_outside)
    return Catalogue(tuple(_sheets(root, reading)))


def _warnings(application: Application, reading: Reading) -> tuple[Problem, ...]:
    """Return what looks wrong, by itself or beside other numbers, in the file's order."""
    odd = {w.key for w in reading.warnings}  # by itself: enough said
    beside = (w for w in doubts(application) if w.key not in odd)
    every = dict.fromkeys((*reading.warnings, *beside))  # a line may be tried more than once
    return tuple(sorted(every, key=lambda p: (p.line, p.column)))


def _unknown(address: str, known: Iterable[str]) -> Problem:
    """Return what is wrong with a change to a number that the text does not hold."""
    return Problem(message="no number has this address", key=address, hint=nearest(address, known))


# --------------------------------------------------------------------------- files beside


def _note(error: BadFile, here: Here) -> None:
    """Note the problems of another file where this one names it."""
    for problem in error.problems:
        here.note(problem.located(error.file))


def _sheets(root: Node, reading: Reading) -> Iterator[Sheet]:
    """Read the user's own catalogues, which the names in the file may come from."""
    if not isinstance(root, Mapping) or "catalogues" not in root.entries:
        return
    node = root.entries["catalogues"][1]
    items = node.items if isinstance(node, Sequence) else [node]
    places = [Here(item, "catalogues", reading) for item in items[:CATALOGUES]]
    sheets: list[tuple[Sheet, Here]] = []
    for here in places:
        if isinstance(here.node, Scalar) and isinstance(here.node.value, str):
            try:
                path = here.beside(here.node.text)
                sheets.append((Sheet(text_of(path), str(path)), here))
            except BadFile as error:
                _note(error, here)
            except Spoilt:
                continue
    catalogue = Catalogue(tuple(sheet for sheet, _ in sheets))
    for k, (sheet, here) in enumerate(sheets):
        own = Reading(catalogue)
        with suppress(Enough):
            sheet.check(own, [s for s, _ in sheets[:k]])
        _note(BadFile(sheet.file, tuple(own.problems)), here)
    yield from catalogue.own


class ProfileName(Text):
    """A profile that comes with this package, or the file of one beside the application."""

    one, many = "a limit profile", "limit profiles"

    def read(self, here: Here) -> Profile:
        """Return its name and limits."""
        name = self.text(here)
        beside = name.endswith((".yaml", ".yml"))
        try:
            return limits(str(here.beside(name)) if beside else name)
        except BadFile as error:
            _note(error, here)
            raise Spoilt from None

    def schema(self, defs: dict[str, Any], unit: str) -> dict[str, Any]:
        """Return a shipped profile, which editors offer, or the file of one's own."""
        return {"anyOf": [{"enum": list(profiles())}, super().schema(defs, unit)]}


class InlineLimits(ListOf):
    """Limits given in place."""

    def __init__(self) -> None:
        super().__init__(TableRule(LimitTable), most=500)

    def read(self, here: Here) -> Profile:
        """Return them, named as they are."""
        return "limits of the application", super().read(here)


AProfile: TypeAlias = Annotated[Profile, ProfileName()]


class OverridesTable(Table):
    """A profile with some of its limits replaced."""

    profile: AProfile = key("the profile to start from")
    overrides: Limits = key("limits that replace those of the same quantity")

    def build(self) -> Profile:
        """Return the profile's name and its limits as replaced."""
        name, start = self.profile
        replaced = {limit.quantity for limit in self.overrides}
        kept = tuple(limit for limit in start if limit.quantity not in replaced)
        return f"{name}, with overrides", kept + self.overrides


# --------------------------------------------------------------------------- tables


class KindName(Choice):
    """A suspension state, by its name alone."""

    def __init__(self) -> None:
        super().__init__(*get_args(SuspensionState))

    def read(self, here: Here) -> State:
        """Return the state."""
        name = super().read(here)
        return State(name=name, kind=name)


class StateTable(StateGeometryTable):
    """A state to check: where the suspension places the axle, or a geometry of its own."""

    name: str = key("what reports call it")
    kind: SuspensionState | None = key("how the suspension places the axle", default=None)
    load: str | None = key("the vehicle's load state that counts", default=None)
    travel: Travel | None = key("rise of the axle from the reference state", default=None)
    pitch: Pitch | None = key("turn of the axle, pinion nose up positive", default=None)
    articulation: Travel | None = key(
        "of a tandem: its forward axle up and the other down by this", default=None
    )
    torque: Torque | None = key("at the gearbox output", default=None)
    speed: Speed | None = key("of the gearbox output", default=None)
    drivelines: Annotated[
        dict[str, StateGeometryTable], MapOf(Text(), TableRule(StateGeometryTable), most=LINES)
    ] = key("geometry of each of several", default={})

    def state(self, lines: tuple[Installed, ...], vehicle: Vehicle | None) -> State:
        """Return the state of an application's lines, in SI."""
        layouts = dict(self._layouts({installed.line.name: installed for installed in lines}))
        kind = self.kind
        if kind is None and self.name in get_args(SuspensionState):
            placed = layouts or self.travel is not None
            kind = None if placed else self.name  # its name says how, unless something else does
        loads = [load.name for load in vehicle.loads] if vehicle else []
        if self.load is not None and self.load not in loads:
            hint = nearest(self.load, loads)
            self.at("load").refuse("the vehicle has no such load state", hint, got=self.load)
        if self.articulation is not None and not any(i.output_joint for i in lines):
            hint = "give the line between the axles an output_joint"
            self.at("articulation").refuse("no line runs from axle to axle", hint)
        load = self.load
        if load is None and kind is None and self.name in loads:
            load = self.name
        return State(
            name=self.name,
            kind=kind,  # type: ignore[arg-type]  # one of its names
            load=load,
            travel=self.travel,
            pitch=self.pitch,
            articulation=0.0 if self.articulation is None else self.articulation,
            torque=self.torque,
            speed=self.speed,
            layouts=layouts or None,
        )

    def _layouts(self, lines: dict[str, Installed]) -> Iterator[tuple[str, Layout]]:
        given: dict[str, StateGeometryTable] = dict(self.drivelines)
        own = ("slopes", "joint_angles", "points", "gearbox_slope", "pinion_slope", "last_length")
        if any(self.has(name) for name in own):
            if len(lines) > 1 or given:
                first = next(name for name in own if self.has(name))
                self.at(first).refuse("give the geometry of each line in drivelines")
            given = {next(iter(lines)): self}
        for name, table in given.items():
            if name not in lines:
                hint = nearest(name, list(lines))
                self.at("drivelines").refuse("no driveline of this name", hint, got=name)
            if not table.gives_geometry:
                table.at().refuse("needs slopes, joint_angles or points_mm")
            line = lines[name]
            yield name, table.state_layout(line.line.lengths, line.layout)


class ObstacleTable(Table):
    """Something a line must clear: a round bar between two points, or a ball."""

    at_most_one_of = (("radius", "diameter"),)

    name: str = key("what reports call it")
    start: BesidePoint = key("one end of its axis, in the frame of the line's points")
    end: BesidePoint | None = key("the other end; a ball has none", default=None)
    radius: Size | None = key("around the axis", default=None)
    diameter: Size | None = key("around the axis", default=None)
    travel_share: Annotated[float, Number(least=-2, most=2)] = key(
        "how much of the axle's rise it makes: 0 on the frame, 1 on the axle", default=0.0
    )
    line: str | None = key("the driveline it is in the way of", default=None)

    def obstacle(self, lines: tuple[Installed, ...]) -> Obstacle:
        """Return the obstacle in SI."""
        known = [installed.line.name for installed in lines]
        line = self.line or known[0]
        if line not in known:
            self.at("line").refuse("no driveline of this name", nearest(line, known), got=line)
        radius = 0.0 if self.diameter is None else self.diameter / 2
        return Obstacle(
            name=self.name,
            start=self.start,
            end=self.end or self.start,
            radius=radius if self.radius is None else self.radius,
            travel_share=self.travel_share,
            line=line,
        )


class DutyTable(Table):
    """A share of the life."""

    share: Percent = key("of the time; all shares make 100")
    torque: Torque = key("at the gearbox output")
    speed: Speed = key("of the gearbox output")
    angle: Angle | None = key("joint angle, in place of the computed one", default=None)

    def build(self) -> DutyPoint:
        """Return the share in SI."""
        return DutyPoint(share=self.share, torque=self.torque, speed=self.speed, angle=self.angle)


class TorsionTable(Table):
    """What turns with the lines at both ends; `cardan stability` assumes what is not given."""

    axle_inertia: PositiveInertia | None = key(
        "of what turns behind the pinion, reflected to it", default=None
    )
    axle_stiffness: TorsionStiffness | None = key(
        "of the spring between pinion and that; rigid without", default=None
    )
    gearbox_inertia: PositiveInertia | None = key(
        "of what turns with the gearbox flange, which turns uniformly without", default=None
    )
    gearbox_stiffness: TorsionStiffness | None = key(
        "of the spring from the flange to the uniformly turning engine", default=None
    )
    damping_ratio: Annotated[float, Number(least=1e-5, below=1, usual=(2e-3, 0.3))] | None = key(
        "of the first torsional mode", default=None
    )

    def build(self) -> Surroundings:
        """Return it in SI."""
        if (self.gearbox_inertia is None) != (self.gearbox_stiffness is None):
            self.at().refuse("give both the gearbox inertia and its stiffness, or neither")
        return Surroundings(
            axle_inertia=self.axle_inertia,
            axle_stiffness=self.axle_stiffness,
            gearbox_inertia=self.gearbox_inertia,
            gearbox_stiffness=self.gearbox_stiffness,
            damping_ratio=self.damping_ratio,
        )


_LAUNCH = Later("cardan.files.torsion", "LaunchTable")
_STATES = ListOf(OneOf(KindName(), TableRule(StateTable)), most=200)
_OBSTACLES = ListOf(TableRule(ObstacleTable), most=200)
_DUTY = OneOf(ListOf(TableRule(DutyTable), most=1000), CycleName())
_CATALOGUES = OneOf(Text(), ListOf(Text(), most=CATALOGUES))
_LIMITS = OneOf(ProfileName(), TableRule(OverridesTable), InlineLimits())


class ApplicationTable(Table):
    """A driveline application: lines in a vehicle, the states to check, the limits."""

    one_of = (("driveline", "drivelines"),)

    title: Annotated[str, Text(300)] = key("what reports call it")
    driveline: LineTable | None = key("the line, gearbox to axle", default=None)
    drivelines: Annotated[dict[str, LineTable], MapOf(Text(), TableRule(LineTable), most=LINES)] = (
        key("several lines by name: main, inter-axle", default={})
    )
    torque: Torque | None = key("at the gearbox output, in place of engine and tyres", default=None)
    coast_torque: Torque | None = key("the same, holding back", default=None)
    speed: TopSpeed | None = key("top speed of the gearbox output", default=None)
    vehicle: Annotated[Vehicle, VehicleTable] | None = key("drive and loads", default=None)
    engine: Annotated[Engine, EngineTable] | None = key("its torque", default=None)
    gearbox: Annotated[Gearbox, GearboxTable] | None = key("its ratios", default=None)
    axle: AnAxle | None = key("of every line that has none of its own", default=None)
    tyre: Annotated[Tyre, TyreTable] | None = key("of the driven wheels", default=None)
    suspension: ASuspension | None = key("of the rear axles", default=None)
    states: Annotated[tuple[State | StateTable, ...], _STATES] = key(
        "suspension states by name, or tables of your own", default=()
    )
    obstacles: Annotated[tuple[ObstacleTable, ...], _OBSTACLES] = key(
        "what a line must clear", default=()
    )
    limits: Annotated[Profile, _LIMITS] | None = key(
        "a profile, a file of one, a profile with overrides, or limits", default=None
    )
    duty: Annotated[tuple[DutyPoint, ...] | DutyCycle, _DUTY] = key(
        "how the life is spent: shares, or the name of a cycle", default=()
    )
    adjust: AdjustTable | None = key("what `cardan fix` may move", default=None)
    bracket: Annotated[Any, Later("cardan.files.bracket", "BracketTable")] | None = key(
        "what a centre bearing hangs in", default=None
    )
    torsion: Annotated[Surroundings, TorsionTable] | None = key(
        "what turns with the lines at both ends", default=None
    )
    clutch: Annotated[Any, Later("cardan.files.torsion", "ClutchTable")] | None = key(
        "between engine and gearbox", default=None
    )
    dual_mass_flywheel: (
        Annotated[Any, Later("cardan.files.torsion", "DualMassFlywheelTable")] | None
    ) = key("ahead of the clutch", default=None)
    converter: Annotated[Any, Later("cardan.files.torsion", "ConverterTable")] | None = key(
        "in place of the clutch", default=None
    )
    inter_axle: Annotated[Any, Later("cardan.files.torsion", "InterAxleTable")] | None = key(
        "the differential of a tandem", default=None
    )
    wheels: Annotated[Any, Later("cardan.files.torsion", "WheelsTable")] | None = key(
        "with their tyres", default=None
    )
    launch: Annotated[Any, OneOf(_LAUNCH, ListOf(_LAUNCH, most=20))] | None = key(
        "starts from rest, one or several", default=None
    )
    study: Annotated[Any, Later("cardan.files.study", "StudyTable")] | None = key(
        "what varies, what scatters, and what is asked of all variants", default=None
    )
    prime_mover: Literal["diesel", "petrol", "electric"] = key("engine", default="diesel")
    shock_factor: Annotated[float, Number(least=1, most=10)] = key(
        "on the torque the joints are sized for: 1.2 smooth to 6 extreme", default=1.0
    )
    include: Annotated[tuple[str, ...], ListOf(Choice("gravity", "unbalance"), most=2)] = key(
        "what is added to the centre bearings' loads", default=()
    )
    catalogues: Annotated[str | tuple[str, ...], OneOf(Text(), ListOf(Text(), most=CATALOGUES))] = (
        key("CSV files of your own parts", default=())
    )

    def build(self) -> Application:
        """Return the application in SI."""
        tables = self.drivelines or ({"main": self.driveline} if self.driveline else {})
        if not tables:
            self.at("drivelines").refuse("needs at least one line")
        lines = tuple(table.installed(name, axle=self.axle) for name, table in tables.items())
        if self.vehicle is not None:
            self._find_driven(self.vehicle, list(tables.values()))
        states = self._states(lines)
        self._say_what_is_missing(states)
        name, held = self.limits or limits(DEFAULT)
        self.differ("obstacles", [o.name for o in self.obstacles])
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
            electric=self.prime_mover == "electric",
            prime_mover_factor=PRIME_MOVERS[self.prime_mover],
            shock_factor=self.shock_factor,
            include_gravity="gravity" in self.include,
            include_unbalance="unbalance" in self.include,
            origins=self.at().reading.places,
        )

    def _variants(self, lines: tuple[Installed, ...]) -> Variants | None:
        """Return the study, whose names must be those of numbers that stand in the file."""
        if self.study is None:
            return None
        from cardan.files.study import of_numbers

        reading = self.at().reading
        numbers = of_numbers((*reading.numbers, *reading.fixed))
        return self.study.variants((*numbers, *movable(i.line for i in lines)))

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
            self.at("converter").refuse(message, got=f"{stall:g}")
        return replace(gearbox or DIRECT, converter_ratio=stall)

    def _torsion(self) -> Surroundings | None:
        """Return what the first plan's table says, refused beside parts of their own."""
        if self.torsion is not None:
            for name in ("clutch", "dual_mass_flywheel", "converter", "inter_axle", "wheels"):
                if self.has(name):
                    message = f"stands in place of the table {name}, not beside it: give the parts"
                    self.at("torsion").refuse(message)
        if self.clutch is not None and self.converter is not None:
            self.at("converter").refuse("stands in place of a clutch, not beside it")
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
            at = self.at("launch", k) if isinstance(given, tuple) else self.at("launch")
            if launch.gear not in names:
                at.refuse(
                    f"has no gear {launch.gear}",
                    f"there are 1 to {gears}, and R" if astern
                    else f"there are 1 to {gears}; R needs gearbox.reverse_ratio",
                )  # fmt: skip
            if launch.load is not None and launch.load not in loads:
                at.refuse(f"the vehicle has no load state {launch.load}",
                          nearest(launch.load, loads))  # fmt: skip
        return found

    @staticmethod
    def _find_driven(vehicle: Vehicle, tables: list[LineTable]) -> None:
        """Refuse a line to axles that the vehicle does not drive."""
        for table in tables:
            if not driven_axles(vehicle, drives=table.drives):
                message = f"a {vehicle.drive} drives no {table.drives} axle for a line to turn"
                table.at("drives").refuse(message)

    def _states(self, lines: tuple[Installed, ...]) -> tuple[State, ...]:
        states: list[State] = []
        for k, entry in enumerate(self.states, 1):
            state = entry if isinstance(entry, State) else entry.state(lines, self.vehicle)
            self._placed(k, state, lines)
            states.append(state)
        self.differ("states", [s.name for s in states])
        return tuple(states) or (State(name="as given"),)

    def _placed(self, k: int, state: State, lines: tuple[Installed, ...]) -> None:
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
                    self.at("states", k).note(message, hint)
            elif suspension is None and state.travel is None and moves:
                message = f"state {state.name} moves the {where}: how far?"
                hint = "give a suspension, or the state its own slopes or travel_mm"
                self.at("states", k).note(message, hint)

    def _say_what_is_missing(self, states: tuple[State, ...]) -> None:
        for name, still, unchecked in (
            ("torque", "nothing pulls", "loads, strength and life"),
            ("speed", "nothing turns", "accelerations and critical speeds"),
        ):
            given = getattr(self, name)
            if given is not None and np.all(given == 0):
                self.at(name).warn(f"{still}: {unchecked} cannot be checked")
        if self.engine is None and self.torque is None and any(s.torque is None for s in states):
            message = "no torque is given: loads, strength and life cannot be checked"
            self.at().warn(message, "give torque_Nm, or an engine and a gearbox")
        if self.engine is None and self.speed is None and any(s.speed is None for s in states):
            message = "no speed is given: accelerations and critical speeds cannot be checked"
            self.at().warn(message, "give speed_rpm, or an engine and a gearbox")

    def _hold_the_amount(self, lines: tuple[Installed, ...], states: tuple[State, ...]) -> None:
        """Refuse an application of which nobody could read the answer, nor wait for it."""
        shafts = sum(len(installed.line.shafts) for installed in lines)
        checks = len(states) * shafts * max(len(self.obstacles), 10)
        if checks > CHECKS:
            message = (
                f"{len(states)} states of {shafts} shafts and {len(self.obstacles)} obstacles are "
                f"some {checks} checks; up to {CHECKS} can be asked of one file"
            )
            self.at("states").refuse(message, "split it into several files")

    def _duty(self, points: tuple[DutyPoint, ...]) -> tuple[DutyPoint, ...]:
        total = sum(point.share for point in points)
        if points and (wrong := failing(abs(total - 1) <= 1e-3 + 1e-9, total)):
            self.at("duty").refuse("the shares must make 100 %", got=f"{100 * wrong[0]:g} %")
        # What rounding leaves of 100 % is shared out: more than all of a life is no life.
        return tuple(replace(point, share=point.share / total) for point in points)

    def _adjustables(
        self, lines: tuple[Installed, ...], tables: list[LineTable]
    ) -> Iterator[Adjustable]:
        if self.adjust is not None and (len(tables) > 1 or tables[0].adjust):
            self.at("adjust").refuse("give this inside each of the drivelines")
        for installed, table in zip(lines, tables, strict=True):
            if adjust := table.adjust or self.adjust:
                yield from adjust.adjustables(installed.line)
