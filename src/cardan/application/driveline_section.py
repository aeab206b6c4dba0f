"""A line of a file: shafts, joints, axle, and what a correction may move."""

from collections.abc import Iterator
from dataclasses import replace
from math import isclose, nan, pi
from typing import Annotated, Any, Literal, TypeAlias

import numpy as np

from cardan.application.catalogue import JOINT_OR_CATALOGUE_NAME_FIELD, TubeOrCatalogueName
from cardan.application.geometry_section import MAX_SHAFTS, GeometryTable
from cardan.application.vehicle_section import (
    AxleFromTable,
    JointPositionFromTable,
    SuspensionFromTable,
)
from cardan.core.errors import DesignError
from cardan.core.units import deg, mm
from cardan.model.adjustments import ADJUSTMENTS, Adjustment
from cardan.model.application import InstalledLine, PermittedAdjustment
from cardan.model.bracket_compliance import DEFAULT_BRACKET_LOSS_FACTOR
from cardan.model.layout import Layout
from cardan.model.parts import RIGID_FLANGE, CentreBearing, Flange, JointSize, Line, Shaft, Spline
from cardan.model.vehicle import Axle, DrivenAxles, TorqueFlowDirection
from cardan.schema import fields as measure
from cardan.schema.field_types import (
    Field,
    IntegerField,
    JsonSchema,
    ListField,
    MappingField,
    NumberField,
    UnionField,
)
from cardan.schema.fields import (
    BearingForceRating,
    BearingMountTravel,
    BearingPosition,
    DampingLossFactor,
    Distance,
    DrivelineRatio,
    Inertia,
    Mass,
    PartDimension,
    PositiveShare,
    ShaftLength,
    SplineFriction,
    SplineTravel,
    SteelStructureLossFactor,
    Stiffness,
    ToothMeanRadius,
    TubeLength,
    YokePhaseAngle,
)  # fmt: skip
from cardan.schema.node_reader import (
    InvalidValueError,
    NodeReader,
    collect_errors,
    nearest_name_hint,
)
from cardan.schema.tables import Table, TableField, table_key_field
from cardan.schema.yaml_tree import Scalar

_ONE_STIFFNESS = (("stiffness", "vertical_stiffness"), ("stiffness", "lateral_stiffness"))


def _pair(table: "CentreBearingTable | FlangeTable") -> tuple[float, float] | None:
    """Return vertical and lateral stiffness, N/m, one value or two; None if it is rigid."""
    if table.stiffness is not None:
        return table.stiffness, table.stiffness
    vertical, lateral = table.vertical_stiffness, table.lateral_stiffness
    if (vertical is None) != (lateral is None):
        missing = "lateral" if lateral is None else "vertical"
        table.reader_of().reject(f"{missing}_stiffness_N_mm is missing: give both")
    return None if vertical is None or lateral is None else (vertical, lateral)


class FlangeTable(Table):
    """What holds the first or the last joint, if it gives: transmission tail, or axle."""

    at_most_one_of = _ONE_STIFFNESS

    stiffness: Stiffness | None = table_key_field(
        "at the joint centre, across the flange", default=None
    )
    vertical_stiffness: Stiffness | None = table_key_field("the same, up and down", default=None)
    lateral_stiffness: Stiffness | None = table_key_field("the same, side to side", default=None)
    loss_factor: DampingLossFactor | None = table_key_field(
        "of that spring, the tangent of its loss angle; none if left out", default=None
    )
    mass: Mass = table_key_field("what moves with the joint centre", default=0.0)

    def build(self) -> Flange:
        """Return it in SI."""
        pair = _pair(self)
        if pair is None:
            self.reader_of().reject("give stiffness_N_mm: without it a flange is rigid")
        loss = 0.0 if self.loss_factor is None else self.loss_factor
        return Flange(stiffness=pair, loss_factor=loss, mass=self.mass)


_AXES = ListField(
    NumberField(*measure.STIFFNESS_KEY_UNITS, least=1, most=1e12, usual=(1e5, 1e9)),
    "along",
    "across",
    "up",
)


class BracketComplianceTable(Table):
    """The bracket a centre bearing hangs in, as far as the line feels it."""

    fixed = True  # what `cardan bracket` found of one

    stiffness: Annotated[tuple[float, float, float], _AXES] = table_key_field(
        "where the bearing sits, along the shaft, across and up"
    )
    loss_factor: SteelStructureLossFactor = table_key_field(
        "of the bracket, assumed if left out", default=DEFAULT_BRACKET_LOSS_FACTOR
    )


_STOP_RATIO = NumberField(least=1, most=200, usual=(3, 50))
_TEMPERATURE = ListField(NumberField(least=0.1, most=20, usual=(0.4, 4)), "hot", "cold")


class CentreBearingTable(Table):
    """The bearing a shaft hangs on near its rear joint."""

    at_most_one_of = _ONE_STIFFNESS

    from_rear_joint: BearingPosition = table_key_field(
        "how far ahead of the rear joint centre it sits"
    )
    stiffness: Stiffness | None = table_key_field(
        "of rubber and bracket across the shaft; rigid if left out", default=None
    )
    vertical_stiffness: Stiffness | None = table_key_field("the same, up and down", default=None)
    lateral_stiffness: Stiffness | None = table_key_field("the same, side to side", default=None)
    axial_stiffness: Stiffness | None = table_key_field(
        "of the rubber along the shaft; slides freely if left out", default=None
    )
    loss_factor: DampingLossFactor | None = table_key_field(
        "of the rubber, the tangent of its loss angle; not known if left out", default=None
    )
    travel: BearingMountTravel | None = table_key_field(
        "how far its rubber goes across the shaft, from where the line hangs, to its stop; not "
        "known if left out",
        default=None,
    )
    stop_stiffness_ratio: Annotated[float, _STOP_RATIO] | None = table_key_field(
        "of the rubber beyond that travel, over its stiffness; 5 to 20, assumed, if left out",
        default=None,
    )
    stiffness_range: Annotated[tuple[float, float], _TEMPERATURE] | None = table_key_field(
        "of the rubber hot and cold, over that stiffness; 0.7 and 2, assumed, if left out",
        default=None,
    )
    bracket: Annotated[BracketComplianceTable, TableField(BracketComplianceTable)] | None = (
        table_key_field("what it hangs in; then the stiffness is the rubber's alone", default=None)
    )

    def build(self) -> CentreBearing:
        """Return the bearing in SI."""
        pair = _pair(self)
        if self.bracket and pair is None:
            self.reader_of("bracket").reject(
                "a bracket deflects in series with rubber: the bearing has no stiffness",
                "give stiffness_N_mm of the rubber; of a bearing without, give the bracket's",
            )
        if self.travel is not None and pair is None:
            self.reader_of("travel").reject(
                "what gives has a travel: the bearing has no stiffness, and is rigid",
                "give stiffness_N_mm of the rubber, or leave its travel out",
            )
        if self.stop_stiffness_ratio is not None and pair is None:
            self.reader_of("stop_stiffness_ratio").reject(
                "what is rigid has no stop: the bearing has no stiffness",
                "give stiffness_N_mm of the rubber, or leave its ratio out",
            )
        if self.stiffness_range is not None:
            if pair is None:
                self.reader_of("stiffness_range").reject(
                    "what is rigid has no range: the bearing has no stiffness",
                    "give stiffness_N_mm of the rubber, or leave its range out",
                )
            hot, cold = self.stiffness_range
            if not hot <= 1 <= cold:
                self.reader_of("stiffness_range").reject(
                    "must reach from 1 or less, hot, to 1 or more, cold", got=f"[{hot:g}, {cold:g}]"
                )
        return CentreBearing(
            from_rear_joint=self.from_rear_joint,
            stiffness=pair,
            axial_stiffness=self.axial_stiffness,
            loss_factor=self.loss_factor,
            bracket_stiffness=self.bracket and self.bracket.stiffness,
            bracket_loss=self.bracket.loss_factor if self.bracket else DEFAULT_BRACKET_LOSS_FACTOR,
            travel=self.travel,
            stop_stiffness_ratio=self.stop_stiffness_ratio,
            stiffness_range=self.stiffness_range,
        )


class SplineTable(Table):
    """The sliding spline, from its place in the reference state."""

    plunge: SplineTravel | None = table_key_field("travel left in shortening", default=None)
    draw: SplineTravel | None = table_key_field("travel left in lengthening", default=None)
    mean_radius: ToothMeanRadius | None = table_key_field("mean radius of the teeth", default=None)
    friction: SplineFriction = table_key_field("0.08 coated, 0.11 greased steel", default=0.11)
    mass: Mass = table_key_field("what it adds to the tube's mass", default=0.0)
    from_front_joint: Distance = table_key_field(
        "how far behind the front joint that mass sits", default=0.0
    )

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


class BalanceGradeField(Field):
    """A balance quality grade: G40, or 40."""

    singular, plural = "a balance grade like G40", "balance grades"
    everyday = (2.5, 100.0)
    """Of shafts: ISO 21940-11 has G16 and G40 for them."""

    json: JsonSchema = {  # noqa: RUF012  read only
        "anyOf": [
            {"type": "number", "exclusiveMinimum": 0, "maximum": 4000},
            {"type": "string", "pattern": "^G[0-9]+([.][0-9]*)?$"},
        ]
    }

    def read(self, here: NodeReader) -> float:
        """Return the grade as the standard prints it, mm/s."""
        node = here.node
        if isinstance(node, Scalar):
            here.node = Scalar(node.text.removeprefix("G"), node.line, node.column)
        bare = here.number()[0]
        if bare is None or not np.all((bare > 0) & (bare <= 4000)):
            here.node = node
            self.reject(here)
        low, high = self.everyday
        if not np.all((bare >= low) & (bare <= high)):
            here.warn(
                f"G{float(np.max(bare)):g} is no usual grade", f"G{low:g} to G{high:g} is usual"
            )
        return bare


_ENDS = ListField(
    NumberField(*measure.MASS_KEY_UNITS, least=0, most=measure.MAX_MASS_KG, usual=(0.01, 500)),
    "front",
    "rear",
)


_YOKES = ListField(NumberField("kgm2", least=0, most=1e7, usual=(1e-5, 50)), "front", "rear")


class ShaftTable(Table):
    """One shaft, from joint centre to joint centre."""

    length: ShaftLength | None = table_key_field("joint centre to joint centre", default=None)
    tube: TubeOrCatalogueName | None = table_key_field(
        "a tube of a catalogue, or its sizes", default=None
    )
    phase: YokePhaseAngle = table_key_field(
        "yoke phase: 0 in phase, 90 out of phase; right-handed, rearward", default=0.0
    )
    centre_bearing: Annotated[CentreBearing, CentreBearingTable] | None = table_key_field(
        "what the shaft hangs on; every shaft but the last needs one", default=None
    )
    spline: Annotated[Spline, SplineTable] | None = table_key_field(
        "the sliding spline", default=None
    )
    yoke_mass: Mass | Annotated[tuple[float, float], _ENDS] = table_key_field(
        "beyond the tube, at each end or [front, rear]", default=0.0
    )
    yoke_inertia: Inertia | Annotated[tuple[float, float], _YOKES] = table_key_field(
        "of both yokes together, or [front, rear], about the axis", default=0.0
    )
    tube_length: TubeLength | None = table_key_field(
        "of the tube between its yokes; all the shaft's if left out", default=None
    )
    polar_inertia: Inertia | None = table_key_field(
        "of the whole shaft, in place of tube and yokes", default=None
    )
    balance_grade: Annotated[float, BalanceGradeField()] | None = table_key_field(
        "ISO 21940-11: G16, G40", default=None
    )

    def build(self) -> "ShaftTable":
        """Return this table, its parts tried: the line knows the lengths points give."""
        written = self.phase / deg
        if np.ndim(written) == 0 and any(
            isclose(abs(written), k * pi / 4, rel_tol=1e-3) for k in (1, 2, 3, 4)
        ):
            odd = f"{written:g} deg looks like {written / deg:.0f} deg in radians"
            self.reader_of("phase").warn(odd, "did you mean phase_rad?")
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
    "length": ListField(
        NumberField(*measure.LENGTH_KEY_UNITS, least=-2, most=2, usual=(0.5 * mm, 0.5)),
        "lowest",
        "highest",
    ),
    "angle": ListField(
        NumberField(
            *measure.ANGLE_KEY_UNITS, least=-360 * deg, most=360 * deg, usual=(0.1 * deg, 180 * deg)
        ),
        "lowest",
        "highest",
    ),
    "share": ListField(
        NumberField("percent", least=-0.9, most=10, usual=(0.01, 2)), "lowest", "highest"
    ),
}
_STEPS = {
    "length": NumberField(*measure.LENGTH_KEY_UNITS, above=0, most=1, usual=(0.2 * mm, 0.2)),
    "angle": NumberField(
        *measure.ANGLE_KEY_UNITS, above=0, most=90 * deg, usual=(0.02 * deg, 90 * deg)
    ),
    "share": NumberField("percent", above=0, most=1),
}
AdjustmentRange: TypeAlias = tuple[float, float]
AdjustmentRangeOrRangesByPart: TypeAlias = AdjustmentRange | dict[int, AdjustmentRange]
"""One range for all parts, or a range for each part that may move."""


class AdjustmentStepsTable(Table):
    """The steps in which a workshop sets things: shims, packing plates, pitches of holes."""

    fixed = True


class AdjustTable(Table):
    """What `cardan fix` may move, and how far from where it is: [lowest, highest].

    A range alone is for every bearing or shaft; {1: [-20, 30]} is for the first alone.
    """

    fixed = True

    hold: tuple[str, ...] = table_key_field(
        "what stays for now, though it has a range: shim, bearing_height 1", default=()
    )
    steps: AdjustmentStepsTable | None = table_key_field(
        "in which a workshop sets things", default=None
    )

    def adjustables(self, line: Line) -> tuple[PermittedAdjustment, ...]:
        """Return what may move of a line."""
        found = tuple(self._found(line))
        held = {f"{a.adjustment_key} {a.part}" for a in found} | {a.adjustment_key for a in found}
        for k, name in enumerate(self.hold, 1):
            if name not in held:
                hint = nearest_name_hint(name, sorted(held))
                self.reader_of("hold", k).add_issue(
                    "nothing of this name has a range", hint, got=name
                )
        return found

    def _found(self, line: Line) -> Iterator[PermittedAdjustment]:
        for movable in ADJUSTMENTS.values():
            given: AdjustmentRangeOrRangesByPart | None = getattr(self, movable.key)
            every = range(1, movable.count(line) + 1)
            ranges = given if isinstance(given, dict) else dict.fromkeys(every, given)
            if given is not None and not every:
                self.reader_of(movable.key).add_issue(
                    f"line {line.name} has nothing of this kind to move"
                )
            for part, moves in ranges.items():
                if moves is not None:
                    yield from self._one(movable, part, moves, line)

    def _one(
        self, movable: Adjustment, part: int, moves: AdjustmentRange, line: Line
    ) -> Iterator[PermittedAdjustment]:
        (low, high), what, count = moves, movable.key, movable.count(line)
        if part > count:
            self.reader_of(what).add_issue(
                f"line {line.name} has no {movable.subject} {part}",
                f"its last is {movable.subject} {count}",
            )
        elif not low <= 0 <= high or low == high:
            worth = movable.unit_value
            self.reader_of(what).add_issue(
                "must reach from 0 or less to 0 or more: ranges count from where the part is",
                got=f"[{low / worth:g}, {high / worth:g}]",
            )
        else:
            held = bool({what, f"{what} {part}"} & set(self.hold))
            step: float = getattr(self.steps, what, None) or movable.resolution
            yield PermittedAdjustment(
                adjustment_key=what,
                part=part,
                low=low,
                high=high,
                line=line.name,
                hold=held,
                step=step,
            )


# What may move is declared once, in the model: each kind is an entry of the table.
for _movable in ADJUSTMENTS.values():
    _range = _RANGES[_movable.dimension]
    _ranges = (
        _range
        if _movable.subject in ("axle", "line")
        else UnionField(_range, MappingField(IntegerField(MAX_SHAFTS), _range))
    )
    AdjustTable.__annotations__[_movable.key] = Annotated[Any, _ranges]
    setattr(AdjustTable, _movable.key, table_key_field(_movable.description, default=None))
    AdjustmentStepsTable.__annotations__[_movable.key] = Annotated[Any, _STEPS[_movable.dimension]]
    setattr(
        AdjustmentStepsTable,
        _movable.key,
        table_key_field(f"of {_movable.description}", default=None),
    )


_BEARINGS = ListField(
    NumberField(*measure.FORCE_KEY_UNITS, least=0.1, most=1e9, usual=(200, 500e3)),
    "farther",
    "nearer",
)


class LineTable(GeometryTable):
    """A driveline: n shafts between n + 1 joints, gearbox first, axle last."""

    one_of = (("slopes", "joint_angles", "points"),)
    at_most_one_of = ()

    shafts: Annotated[
        tuple[ShaftTable, ...], ListField(TableField(ShaftTable), least=1, most=MAX_SHAFTS)
    ] = table_key_field("gearbox to axle")
    joints: (
        Annotated[
            JointSize | tuple[JointSize, ...],
            UnionField(
                *JOINT_OR_CATALOGUE_NAME_FIELD.alternatives,
                ListField(JOINT_OR_CATALOGUE_NAME_FIELD, most=MAX_SHAFTS + 1),
            ),
        ]
        | None
    ) = table_key_field("one joint for all, or a list from gearbox to axle", default=None)
    axle: AxleFromTable | None = table_key_field("the axle this line drives", default=None)
    adjust: AdjustTable | None = table_key_field("what `cardan fix` may move", default=None)
    suspension: SuspensionFromTable | None = table_key_field(
        "what moves this line's axle, if not the vehicle's rear suspension", default=None
    )
    drives: DrivenAxles = table_key_field("which axles turn behind this line", default="rear")
    runs: TorqueFlowDirection | None = table_key_field(
        "which way its torque flows; forward to a front axle, else rearward, if not said",
        default=None,
    )
    load_share: PositiveShare = table_key_field(
        "share of their load on wheels behind this line", default=1.0
    )
    torque_share: PositiveShare = table_key_field(
        "share of the gearbox output's torque", default=1.0
    )
    torque_ratio: DrivelineRatio = table_key_field(
        "torque over that share: a transfer case's gears", default=1.0
    )
    speed_ratio: DrivelineRatio = table_key_field(
        "speed over that of the gearbox output", default=1.0
    )
    output_joint: JointPositionFromTable | None = table_key_field(
        "joint 1 from the wheel centre, where the line leaves an axle", default=None
    )
    axial_freedom: Literal["last_shaft", "gearbox_flange"] = table_key_field(
        "what takes up length: the last shaft's spline, or a floating flange", default="last_shaft"
    )
    gearbox_bearing_spacing: PartDimension | None = table_key_field(
        "between the output's bearings", default=None
    )
    gearbox_bearing_overhang: PartDimension | None = table_key_field(
        "joint 1 from the nearer of them", default=None
    )
    pinion_bearing_spacing: PartDimension | None = table_key_field(
        "between the pinion's bearings", default=None
    )
    pinion_bearing_overhang: PartDimension | None = table_key_field(
        "last joint from the nearer of them", default=None
    )
    gearbox_bearing_rating: (
        BearingForceRating | Annotated[tuple[float, float], _BEARINGS] | None
    ) = table_key_field(
        "radial force that the line may put on each of the output's bearings, or [farther from "
        "the joint, nearer]; without it no limit asks",
        default=None,
    )
    pinion_bearing_rating: BearingForceRating | Annotated[tuple[float, float], _BEARINGS] | None = (
        table_key_field(
            "the same of the pinion's bearings, in addition to the gears' forces", default=None
        )
    )
    gearbox_flange: Annotated[Flange, FlangeTable] | None = table_key_field(
        "how the transmission's tail gives under joint 1; rigid if left out", default=None
    )
    pinion_flange: Annotated[Flange, FlangeTable] | None = table_key_field(
        "how the axle gives under the last joint; rigid if left out", default=None
    )

    def build(self) -> "LineTable":
        """Return this table: its name and the vehicle's axle come from outside."""
        self.installed_line("main", axle=None)
        return self

    def installed_line(self, name: str, *, axle: Axle | None) -> InstalledLine:
        """Return the line as installed, in SI; `axle` is the vehicle's, if it has none."""
        checked: list[Any] = collect_errors(
            (self._complete, self._laid_out, self._sizes, self._held)
        )
        layout: Layout = checked[1]
        lengths = np.moveaxis(layout.lengths, -1, 0)
        shafts = collect_errors(lambda k=k: self._shaft(k, lengths[k]) for k in range(len(lengths)))
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
                gearbox_bearing_rating=_of_both(self.gearbox_bearing_rating),
                pinion_bearing_rating=_of_both(self.pinion_bearing_rating),
                gearbox_flange=self.gearbox_flange or RIGID_FLANGE,
                pinion_flange=self.pinion_flange or RIGID_FLANGE,
            )
        )
        return self.attempt(
            lambda: InstalledLine(
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
        """Return shaft k from 0; without a given length from the points, m."""
        table = self.shafts[k]
        if self._bare:
            shaft = table.shaft(nan)
            hangs = k < len(self.shafts) - 1 and shaft.centre_bearing is None
            return replace(shaft, centre_bearing=CentreBearing()) if hangs else shaft
        long = between if table.length is None else table.length
        if table.tube_length is not None and np.any(table.tube_length > 1.001 * np.asarray(long)):
            table.reader_of("tube_length").warn(
                f"the tube is longer than its shaft, which is {np.max(long) / mm:g} mm",
                "between its yokes it is shorter: left out, all of the shaft twists",
            )
        if table.length is not None:
            return table.shaft(table.length)
        try:
            return table.shaft(between)
        except DesignError as error:
            message = f"between joints {k + 1} and {k + 2}: {error}"
            self.reader_of("points", k + 2).reject(message, f"see shaft {k + 1}")

    def _held(self) -> None:
        """Wonder at a flange that gives under a line whose bearings do not."""
        given = [s.centre_bearing.stiffness for s in self.shafts if s.centre_bearing]
        for name in ("gearbox_flange", "pinion_flange"):
            if self.has(name) and not any(given):
                self.reader_of(name).warn(
                    "only critical speeds feel it: no centre bearing of the line gives",
                    "give stiffness_N_mm of a centre bearing",
                )

    @property
    def _bare(self) -> bool:
        """Whether no length is given: slopes alone define how the line turns."""
        return self.points is None and all(s.length is None for s in self.shafts)

    def _laid_out(self) -> Layout:
        lengths = [nan if self._bare else s.length for s in self.shafts]
        if self.points is None and any(length is None for length in lengths):
            raise InvalidValueError  # noted elsewhere
        return self.layout(lengths)

    def _complete(self) -> None:
        """Refuse shafts without a length, hanging on nothing, or a last one that hangs.

        Where none has a length, a protractor went under the vehicle and nothing else is known.
        """
        *hung, last = self.shafts
        for shaft in self.shafts if not self._bare else ():
            if shaft.length is None and self.points is None:
                shaft.reader_of().add_issue("length_mm is missing: joint centre to joint centre")
        for k, shaft in enumerate(hung if not self._bare else (), 1):
            if shaft.centre_bearing is None:
                hint = "give centre_bearing: {from_rear_joint_mm: ...}"
                message = f"shaft {k} of {len(self.shafts)} needs a centre bearing"
                shaft.reader_of().add_issue(message, hint)
        if last.centre_bearing is not None:
            hint = "it runs between two joints; add the shaft behind it, or remove this"
            last.reader_of("centre_bearing").add_issue("the last shaft hangs on no bearing", hint)
        if last.centre_bearing or not (self._bare or all(s.centre_bearing for s in hung)):
            raise InvalidValueError

    def _sizes(self) -> tuple[JointSize | None, ...]:
        """Return the size of every joint."""
        count = len(self.shafts) + 1
        if self.joints is None:
            return ()
        if isinstance(self.joints, JointSize):
            return (self.joints,) * count
        if len(self.joints) != count:
            message = f"must hold {count} joints, one more than shafts"
            self.reader_of("joints").reject(message, got=f"{len(self.joints)} joints")
        return self.joints


def _of_both(rating: Any) -> tuple[float, float] | None:
    """Return a rating of two bearings, given for both at once or each by itself."""
    return rating if rating is None or isinstance(rating, tuple) else (rating, rating)
