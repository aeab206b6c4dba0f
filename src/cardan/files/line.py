"""A line of a file: shafts, joints, axle, and what a correction may move."""

from collections.abc import Iterator
from dataclasses import replace
from math import isclose, nan, pi
from typing import Annotated, Any, Literal, TypeAlias

import numpy as np

from cardan.base.errors import DesignError
from cardan.base.units import deg, mm
from cardan.border import measure
from cardan.border.document import Scalar
from cardan.border.measure import (
    BearingPlace,
    Distance,
    FrameLoss,
    Inertia,
    LineRatio,
    LossFactor,
    Mass,
    RubberTravel,
    ShaftLength,
    Share,
    Size,
    SplineFriction,
    SplineTravel,
    Stiffness,
    ToothRadius,
    TubeLength,
    Turn,
)  # fmt: skip
from cardan.border.table import (
    Here,
    ListOf,
    MapOf,
    Number,
    OneOf,
    Rule,
    Schema,
    Spoilt,
    Table,
    TableRule,
    Whole,
    each,
    key,
    nearest,
)  # fmt: skip
from cardan.files.catalogue import A_JOINT, ATube
from cardan.files.geometry import GeometryTable
from cardan.files.vehicle import AnAxle, APlace, ASuspension
from cardan.model.application import Adjustable, Installed
from cardan.model.layout import Layout
from cardan.model.movable import MOVABLES, Movable
from cardan.model.parts import RIGID_FLANGE, CentreBearing, Flange, JointSize, Line, Shaft, Spline
from cardan.model.seat import LOSS
from cardan.model.vehicle import Axle, Drives, Runs

SHAFTS = 12
"""Of one line: trucks have up to five, and a limit far above keeps a mistake short."""


_ONE_STIFFNESS = (("stiffness", "vertical_stiffness"), ("stiffness", "lateral_stiffness"))


def _pair(table: "CentreBearingTable | FlangeTable") -> tuple[float, float] | None:
    """Return vertical and lateral stiffness, N/m, alike or told apart; None where it is rigid."""
    if table.stiffness is not None:
        return table.stiffness, table.stiffness
    vertical, lateral = table.vertical_stiffness, table.lateral_stiffness
    if (vertical is None) != (lateral is None):
        missing = "lateral" if lateral is None else "vertical"
        table.at().refuse(f"{missing}_stiffness_N_mm is missing beside the other one")
    return None if vertical is None or lateral is None else (vertical, lateral)


class FlangeTable(Table):
    """What holds the first or the last joint, if it gives: transmission tail, or axle."""

    at_most_one_of = _ONE_STIFFNESS

    stiffness: Stiffness | None = key("at the joint centre, across the flange", default=None)
    vertical_stiffness: Stiffness | None = key("the same, up and down", default=None)
    lateral_stiffness: Stiffness | None = key("the same, side to side", default=None)
    loss_factor: LossFactor | None = key(
        "of that spring, the tangent of its loss angle; none if left out", default=None
    )
    mass: Mass = key("what moves with the joint centre", default=0.0)

    def build(self) -> Flange:
        """Return it in SI."""
        pair = _pair(self)
        if pair is None:
            self.at().refuse("give stiffness_N_mm: without it a flange is rigid")
        loss = 0.0 if self.loss_factor is None else self.loss_factor
        return Flange(stiffness=pair, loss_factor=loss, mass=self.mass)


_AXES = ListOf(
    Number(*measure.STIFFNESSES, least=1, most=1e12, usual=(1e5, 1e9)), "along", "across", "up"
)


class SeatTable(Table):
    """The bracket a centre bearing hangs in, as far as the line feels it."""

    fixed = True  # what `cardan bracket` found of one

    stiffness: Annotated[tuple[float, float, float], _AXES] = key(
        "where the bearing sits, along the shaft, across and up"
    )
    loss_factor: FrameLoss = key("of the bracket, assumed if left out", default=LOSS)


class CentreBearingTable(Table):
    """The bearing a shaft hangs on near its rear joint."""

    at_most_one_of = _ONE_STIFFNESS

    from_rear_joint: BearingPlace = key("how far ahead of the rear joint centre it sits")
    stiffness: Stiffness | None = key(
        "of rubber and bracket across the shaft; rigid if left out", default=None
    )
    vertical_stiffness: Stiffness | None = key("the same, up and down", default=None)
    lateral_stiffness: Stiffness | None = key("the same, side to side", default=None)
    axial_stiffness: Stiffness | None = key(
        "of the rubber along the shaft; slides freely if left out", default=None
    )
    loss_factor: LossFactor | None = key(
        "of the rubber, the tangent of its loss angle; not known if left out", default=None
    )
    travel: RubberTravel | None = key(
        "how far its rubber goes across the shaft, from where the line hangs, to its stop; not "
        "known if left out",
        default=None,
    )
    bracket: Annotated[SeatTable, TableRule(SeatTable)] | None = key(
        "what it hangs in; then the stiffness is the rubber's alone", default=None
    )

    def build(self) -> CentreBearing:
        """Return the bearing in SI."""
        pair = _pair(self)
        if self.bracket and pair is None:
            self.at("bracket").refuse(
                "a bracket gives beside rubber that gives: the bearing has no stiffness",
                "give stiffness_N_mm of the rubber; of a bearing without, give the bracket's",
            )
        if self.travel is not None and pair is None:
            self.at("travel").refuse(
                "what gives has a travel: the bearing has no stiffness, and is rigid",
                "give stiffness_N_mm of the rubber, or leave its travel out",
            )
        return CentreBearing(
            from_rear_joint=self.from_rear_joint,
            stiffness=pair,
            axial_stiffness=self.axial_stiffness,
            loss_factor=self.loss_factor,
            bracket_stiffness=self.bracket and self.bracket.stiffness,
            bracket_loss=self.bracket.loss_factor if self.bracket else LOSS,
            travel=self.travel,
        )


class SplineTable(Table):
    """The sliding spline, from its place in the reference state."""

    plunge: SplineTravel | None = key("travel left in shortening", default=None)
    draw: SplineTravel | None = key("travel left in lengthening", default=None)
    mean_radius: ToothRadius | None = key("mean radius of the teeth", default=None)
    friction: SplineFriction = key("0.08 coated, 0.11 greased steel", default=0.11)
    mass: Mass = key("what it adds to the tube's mass", default=0.0)
    from_front_joint: Distance = key("how far behind the front joint that mass sits", default=0.0)

    def build(self) -> Spline:
        """Return the spline in SI."""
        return Spline(
            plunge=self.plunge,
            draw=self.draw,
            mean_radius=self.mean_radius,
            friction=self.friction,
            mass=self.mass,
            from_front_joint=self.from_front_joint,
        )


class BalanceGrade(Rule):
    """A balance quality grade: G40, or 40."""

    one, many = "a balance grade like G40", "balance grades"
    everyday = (2.5, 100.0)
    """Of shafts: ISO 21940-11 has G16 and G40 for them."""

    json: Schema = {  # noqa: RUF012  read only
        "anyOf": [
            {"type": "number", "exclusiveMinimum": 0, "maximum": 4000},
            {"type": "string", "pattern": "^G[0-9]+([.][0-9]*)?$"},
        ]
    }

    def read(self, here: Here) -> float:
        """Return the grade as the standard prints it, mm/s."""
        node = here.node
        if isinstance(node, Scalar):
            here.node = Scalar(node.text.removeprefix("G"), node.line, node.column)
        bare = here.number()[0]
        if bare is None or not np.all((bare > 0) & (bare <= 4000)):
            here.node = node
            self.refuse(here)
        low, high = self.everyday
        if not np.all((bare >= low) & (bare <= high)):
            here.warn(
                f"G{float(np.max(bare)):g} is no usual grade", f"G{low:g} to G{high:g} is usual"
            )
        return bare


_ENDS = ListOf(
    Number(*measure.MASSES, least=0, most=measure.HEAVIEST, usual=(0.01, 500)), "front", "rear"
)


_YOKES = ListOf(Number("kgm2", least=0, most=1e7, usual=(1e-5, 50)), "front", "rear")


class ShaftTable(Table):
    """One shaft, from joint centre to joint centre."""

    length: ShaftLength | None = key("joint centre to joint centre", default=None)
    tube: ATube | None = key("a tube of a catalogue, or its sizes", default=None)
    phase: Turn = key("yoke phase: 0 aligned, 90 crossed; right-handed, rearward", default=0.0)
    centre_bearing: Annotated[CentreBearing, CentreBearingTable] | None = key(
        "what the shaft hangs on; every shaft but the last needs one", default=None
    )
    spline: Annotated[Spline, SplineTable] | None = key("the sliding spline", default=None)
    yoke_mass: Mass | Annotated[tuple[float, float], _ENDS] = key(
        "beyond the tube, at each end or [front, rear]", default=0.0
    )
    yoke_inertia: Inertia | Annotated[tuple[float, float], _YOKES] = key(
        "of both yokes together, or [front, rear], about the axis", default=0.0
    )
    tube_length: TubeLength | None = key(
        "of the tube between its yokes; all the shaft's if left out", default=None
    )
    polar_inertia: Inertia | None = key(
        "of the whole shaft, in place of tube and yokes", default=None
    )
    balance_grade: Annotated[float, BalanceGrade()] | None = key(
        "ISO 21940-11: G16, G40", default=None
    )

    def build(self) -> "ShaftTable":
        """Return this table, its parts tried: the line knows the lengths points give."""
        written = self.phase / deg
        if np.ndim(written) == 0 and any(
            isclose(abs(written), k * pi / 4, rel_tol=1e-3) for k in (1, 2, 3, 4)
        ):
            odd = f"{written:g} deg looks like {written / deg:.0f} deg in radians"
            self.at("phase").warn(odd, "did you mean phase_rad?")
        if self.length is not None:
            length = self.length
            self.attempt(lambda: self.shaft(length))
        return self

    def shaft(self, length: float) -> Shaft:
        """Return the shaft of a length, in SI; refuse what cannot be, as its part does."""
        mass, yokes = self.yoke_mass, self.yoke_inertia
        return Shaft(
            length=length,
            tube=self.tube,
            phase=self.phase,
            centre_bearing=self.centre_bearing,
            spline=self.spline,
            yoke_mass=mass if isinstance(mass, tuple) else (mass, mass),
            yoke_inertia=sum(yokes) if isinstance(yokes, tuple) else yokes,
            yoke_inertias=yokes if isinstance(yokes, tuple) else None,
            tube_length=self.tube_length,
            polar_inertia_given=self.polar_inertia,
            balance_grade=self.balance_grade,
        )


_RANGES = {
    "length": ListOf(
        Number(*measure.LENGTHS, least=-2, most=2, usual=(0.5 * mm, 0.5)), "lowest", "highest"
    ),
    "angle": ListOf(
        Number(*measure.ANGLES, least=-360 * deg, most=360 * deg, usual=(0.1 * deg, 180 * deg)),
        "lowest", "highest",
    ),
    "share": ListOf(Number("percent", least=-0.9, most=10, usual=(0.01, 2)), "lowest", "highest"),
}  # fmt: skip
_STEPS = {
    "length": Number(*measure.LENGTHS, above=0, most=1, usual=(0.2 * mm, 0.2)),
    "angle": Number(*measure.ANGLES, above=0, most=90 * deg, usual=(0.02 * deg, 90 * deg)),
    "share": Number("percent", above=0, most=1),
}
Range: TypeAlias = tuple[float, float]
Ranges: TypeAlias = Range | dict[int, Range]
"""One range for all parts, or a range for each part that may move."""


class StepsTable(Table):
    """The steps in which a workshop sets things: shims, packing plates, pitches of holes."""

    fixed = True


class AdjustTable(Table):
    """What `cardan fix` may move, and how far from where it is: [lowest, highest].

    A range alone is for every bearing or shaft; {1: [-20, 30]} is for the first alone.
    """

    fixed = True

    hold: tuple[str, ...] = key(
        "what stays for now, though it has a range: shim, bearing_height 1", default=()
    )
    steps: StepsTable | None = key("in which a workshop sets things", default=None)

    def adjustables(self, line: Line) -> tuple[Adjustable, ...]:
        """Return what may move of a line."""
        found = tuple(self._found(line))
        held = {f"{a.what} {a.part}" for a in found} | {a.what for a in found}
        for k, name in enumerate(self.hold, 1):
            if name not in held:
                hint = nearest(name, sorted(held))
                self.at("hold", k).note("nothing of this name has a range", hint, got=name)
        return found

    def _found(self, line: Line) -> Iterator[Adjustable]:
        for movable in MOVABLES.values():
            given: Ranges | None = getattr(self, movable.key)
            every = range(1, movable.count(line) + 1)
            ranges = given if isinstance(given, dict) else dict.fromkeys(every, given)
            if given is not None and not every:
                self.at(movable.key).note(f"line {line.name} has nothing of this kind to move")
            for part, moves in ranges.items():
                if moves is not None:
                    yield from self._one(movable, part, moves, line)

    def _one(self, movable: Movable, part: int, moves: Range, line: Line) -> Iterator[Adjustable]:
        (low, high), what, count = moves, movable.key, movable.count(line)
        if part > count:
            self.at(what).note(
                f"line {line.name} has no {movable.of} {part}", f"its last is {movable.of} {count}"
            )
        elif not low <= 0 <= high or low == high:
            worth = movable.worth
            self.at(what).note(
                "must reach from 0 or less to 0 or more: ranges count from where the part is",
                got=f"[{low / worth:g}, {high / worth:g}]",
            )
        else:
            held = bool({what, f"{what} {part}"} & set(self.hold))
            step: float = getattr(self.steps, what, None) or movable.resolution
            yield Adjustable(
                what=what, part=part, low=low, high=high, line=line.name, hold=held, step=step
            )


# What may move is declared once, in the model: each kind is an entry of the table.
for _movable in MOVABLES.values():
    _range = _RANGES[_movable.measure]
    _ranges = (
        _range if _movable.of in ("axle", "line") else OneOf(_range, MapOf(Whole(SHAFTS), _range))
    )
    AdjustTable.__annotations__[_movable.key] = Annotated[Any, _ranges]
    setattr(AdjustTable, _movable.key, key(_movable.says, default=None))
    StepsTable.__annotations__[_movable.key] = Annotated[Any, _STEPS[_movable.measure]]
    setattr(StepsTable, _movable.key, key(f"of {_movable.says}", default=None))


class LineTable(GeometryTable):
    """A driveline: n shafts between n + 1 joints, gearbox first, axle last."""

    one_of = (("slopes", "joint_angles", "points"),)
    at_most_one_of = ()

    shafts: Annotated[
        tuple[ShaftTable, ...], ListOf(TableRule(ShaftTable), least=1, most=SHAFTS)
    ] = key("gearbox to axle")
    joints: (
        Annotated[
            JointSize | tuple[JointSize, ...],
            OneOf(*A_JOINT.rules, ListOf(A_JOINT, most=SHAFTS + 1)),
        ]
        | None
    ) = key("one joint for all, or a list from gearbox to axle", default=None)
    axle: AnAxle | None = key("the axle this line drives", default=None)
    adjust: AdjustTable | None = key("what `cardan fix` may move", default=None)
    suspension: ASuspension | None = key(
        "what moves this line's axle, if not the vehicle's rear suspension", default=None
    )
    drives: Drives = key("which axles turn behind this line", default="rear")
    runs: Runs | None = key(
        "which way its torque flows; forward to a front axle, else rearward, if not said",
        default=None,
    )
    load_share: Share = key("share of their load on wheels behind this line", default=1.0)
    torque_share: Share = key("share of the gearbox output's torque", default=1.0)
    torque_ratio: LineRatio = key("torque over that share: a transfer case's gears", default=1.0)
    speed_ratio: LineRatio = key("speed over that of the gearbox output", default=1.0)
    output_joint: APlace | None = key(
        "joint 1 from the wheel centre, where the line leaves an axle", default=None
    )
    axial_freedom: Literal["last_shaft", "gearbox_flange"] = key(
        "what takes up length: the last shaft's spline, or a floating flange", default="last_shaft"
    )
    gearbox_bearing_spacing: Size | None = key("between the output's bearings", default=None)
    gearbox_bearing_overhang: Size | None = key("joint 1 from the nearer of them", default=None)
    pinion_bearing_spacing: Size | None = key("between the pinion's bearings", default=None)
    pinion_bearing_overhang: Size | None = key("last joint from the nearer of them", default=None)
    gearbox_flange: Annotated[Flange, FlangeTable] | None = key(
        "how the transmission's tail gives under joint 1; rigid if left out", default=None
    )
    pinion_flange: Annotated[Flange, FlangeTable] | None = key(
        "how the axle gives under the last joint; rigid if left out", default=None
    )

    def build(self) -> "LineTable":
        """Return this table: its name and the vehicle's axle come from outside."""
        self.installed("main", axle=None)
        return self

    def installed(self, name: str, *, axle: Axle | None) -> Installed:
        """Return the line as installed, in SI; `axle` is the vehicle's, if it has none."""
        checked: list[Any] = each((self._complete, self._laid_out, self._sizes, self._held))
        layout: Layout = checked[1]
        lengths = np.moveaxis(layout.lengths, -1, 0)
        shafts = each(lambda k=k: self._shaft(k, lengths[k]) for k in range(len(lengths)))
        line = self.attempt(
            lambda: Line(
                name=name,
                shafts=tuple(shafts),
                joints=checked[2],
                axial_freedom=self.axial_freedom,
                gearbox_bearing_spacing=self.gearbox_bearing_spacing,
                gearbox_bearing_overhang=self.gearbox_bearing_overhang,
                pinion_bearing_spacing=self.pinion_bearing_spacing,
                pinion_bearing_overhang=self.pinion_bearing_overhang,
                gearbox_flange=self.gearbox_flange or RIGID_FLANGE,
                pinion_flange=self.pinion_flange or RIGID_FLANGE,
            )
        )
        return self.attempt(
            lambda: Installed(
                line=line,
                layout=layout,
                axle=self.axle or axle,
                torque_ratio=self.torque_ratio,
                torque_share=self.torque_share,
                speed_ratio=self.speed_ratio,
                drives=self.drives,
                runs=self.runs,
                load_share=self.load_share,
                output_joint=self.output_joint,
                suspension=self.suspension,
            )
        )

    def _shaft(self, k: int, between: float) -> Shaft:
        """Return shaft k from 0; where nobody gives its length the points do, m."""
        table = self.shafts[k]
        if self._bare:
            shaft = table.shaft(nan)
            hangs = k < len(self.shafts) - 1 and shaft.centre_bearing is None
            return replace(shaft, centre_bearing=CentreBearing()) if hangs else shaft
        long = between if table.length is None else table.length
        if table.tube_length is not None and np.any(table.tube_length > 1.001 * np.asarray(long)):
            table.at("tube_length").warn(
                f"the tube is longer than its shaft, which is {np.max(long) / mm:g} mm",
                "between its yokes it is shorter: left out, all of the shaft twists",
            )
        if table.length is not None:
            return table.shaft(table.length)
        try:
            return table.shaft(between)
        except DesignError as error:
            message = f"between joints {k + 1} and {k + 2}: {error}"
            self.at("points", k + 2).refuse(message, f"see shaft {k + 1}")

    def _held(self) -> None:
        """Wonder at a flange that gives under a line whose bearings do not."""
        given = [s.centre_bearing.stiffness for s in self.shafts if s.centre_bearing]
        for name in ("gearbox_flange", "pinion_flange"):
            if self.has(name) and not any(given):
                self.at(name).warn(
                    "only critical speeds feel it: no centre bearing of the line gives",
                    "give stiffness_N_mm of a centre bearing",
                )

    @property
    def _bare(self) -> bool:
        """Whether nobody gives a length: slopes alone tell how the line turns."""
        return self.points is None and all(s.length is None for s in self.shafts)

    def _laid_out(self) -> Layout:
        lengths = [nan if self._bare else s.length for s in self.shafts]
        if self.points is None and any(length is None for length in lengths):
            raise Spoilt  # noted elsewhere
        return self.layout(lengths)

    def _complete(self) -> None:
        """Refuse shafts without a length, hanging on nothing, or a last one that hangs.

        Where none has a length, a protractor went under the vehicle and nothing else is told.
        """
        *hung, last = self.shafts
        for shaft in self.shafts if not self._bare else ():
            if shaft.length is None and self.points is None:
                shaft.at().note("length_mm is missing: joint centre to joint centre")
        for k, shaft in enumerate(hung if not self._bare else (), 1):
            if shaft.centre_bearing is None:
                hint = "give centre_bearing: {from_rear_joint_mm: ...}"
                message = f"shaft {k} of {len(self.shafts)} needs a centre bearing"
                shaft.at().note(message, hint)
        if last.centre_bearing is not None:
            hint = "it runs between two joints; add the shaft behind it, or remove this"
            last.at("centre_bearing").note("the last shaft hangs on no bearing", hint)
        if last.centre_bearing or not (self._bare or all(s.centre_bearing for s in hung)):
            raise Spoilt

    def _sizes(self) -> tuple[JointSize | None, ...]:
        """Return the size of every joint."""
        count = len(self.shafts) + 1
        if self.joints is None:
            return ()
        if isinstance(self.joints, JointSize):
            return (self.joints,) * count
        if len(self.joints) != count:
            message = f"must hold {count} joints, one more than shafts"
            self.at("joints").refuse(message, got=f"{len(self.joints)} joints")
        return self.joints
