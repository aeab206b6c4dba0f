"""Catalogues: joints, tubes and materials by name, from data files with a source per row.

A catalogue is a CSV file whose header holds the keys that a part given in place would have
in an application file, so both are read by the same tables. A user's own catalogues come
first, then the ones this package brings along. An empty cell is "not known".
"""

import csv
import io
import re
from collections.abc import Iterator, Sequence
from dataclasses import replace
from functools import cache, cached_property
from math import isclose
from pathlib import Path
from typing import Annotated, Any, Literal, TypeAlias

import numpy as np

from cardan.application.part_names import joint_size_hint, tube_of_sizes, tube_size_hint
from cardan.application.provenance_code import ProvenanceCode, with_provenance_code
from cardan.core.errors import DesignError, FileIssue, InvalidFileError
from cardan.core.provenance import PROVENANCE_CODES, SOURCE_ASSUMED, Source
from cardan.core.units import deg
from cardan.model.bracket import MEAN_STRESS_METHODS, FatigueCurve
from cardan.model.laminate import CompositeTube, OrientedPly, Ply, metal_ply
from cardan.model.material import ASSUMED_TUBE_STEEL, METAL_KINDS, Material
from cardan.model.parts import JointSize, Tube
from cardan.physics.fatigue.detail_classes import fat_class_knee_amplitude
from cardan.schema.field_types import (
    MAX_PROSE_CHARACTERS,
    EnumField,
    IntegerField,
    ListField,
    NumberField,
    TextField,
    UnionField,
)
from cardan.schema.fields import (
    ANGLE_KEY_UNITS,
    Angle,
    CycleCount,
    Density,
    Diameter,
    ElasticModulus,
    LifeHours,
    Mass,
    MaterialStrength,
    PartDimension,
    PlyThickness,
    PositiveFactor,
    PositiveSpeed,
    SpeedAngleProduct,
    SplineTravel,
    TorqueRating,
    TorsionStiffness,
    WallThickness,
)  # fmt: skip
from cardan.schema.node_reader import (
    InvalidValueError,
    NodeReader,
    TableReadContext,
    nearest_name_hint,
)
from cardan.schema.tables import Table, TableField, table_key_field
from cardan.schema.yaml_tree import Mapping, Node, Scalar, reject_hidden_characters

MAX_PLIES = 400
"""Of one tube: 50 mm of wall, and a limit far above what is wound keeps a mistake short."""

CataloguePartKind: TypeAlias = Literal["joint", "tube", "material", "ply", "detail"]


class CatalogueReference(TextField):
    """The name of a part in a catalogue."""

    def __init__(self, kind: CataloguePartKind) -> None:
        super().__init__()
        self.kind: CataloguePartKind = kind
        many = "plies" if kind == "ply" else f"{kind}s"
        self.singular, self.plural = f"a {kind} of a catalogue", f"{many} of a catalogue"

    def read(self, here: NodeReader) -> Any:
        """Return the part itself."""
        name = self.read_text_value(here)
        try:
            return here.context.catalogue.find(name, self.kind, here)
        except DesignError as error:
            message, _, hint = str(error).partition("; ")
            here.reject(message, hint)

    def schema(self, defs: dict[str, Any], unit: str) -> dict[str, Any]:
        """Return a name of the shipped catalogue, which editors offer, or any of one's own."""
        return {
            "anyOf": [
                {"enum": list(read_shipped_catalogue(self.kind).rows)},
                super().schema(defs, unit),
            ]
        }


def _source(said: str | None, read: ProvenanceCode | None) -> Source:
    return with_provenance_code(SOURCE_ASSUMED if said is None else Source(said), read)


LengthLimitedProse: TypeAlias = Annotated[str, TextField(MAX_PROSE_CHARACTERS)]

PROVENANCE_CODES_HELP = f"{', '.join(PROVENANCE_CODES)}; values that differ behind a semicolon"


class MaterialTable(Table):
    """An isotropic material."""

    name: str = table_key_field("what files call it", default="in place")
    youngs_modulus: ElasticModulus = table_key_field("Young's modulus")
    poisson: Annotated[float, NumberField(least=0, below=0.5)] = table_key_field(
        "Poisson's ratio", default=0.3
    )
    density: Density = table_key_field("density")
    yield_: MaterialStrength | None = table_key_field("yield strength", default=None)
    ultimate: MaterialStrength | None = table_key_field("ultimate strength", default=None)
    fatigue_shear: MaterialStrength | None = table_key_field(
        "fatigue limit in alternating shear", default=None
    )
    metal: Annotated[str, EnumField(*METAL_KINDS)] | None = table_key_field(
        "what metal it is; left out, steel if its modulus is 180 GPa or more, else other",
        default=None,
    )
    welded_yield: MaterialStrength | None = table_key_field(
        "yield strength beside a weld, where its heat lowers it, as of aluminium", default=None
    )
    source: LengthLimitedProse | None = table_key_field("where the numbers come from", default=None)
    how_read: ProvenanceCode | None = table_key_field(f"how: {PROVENANCE_CODES_HELP}", default=None)
    note: LengthLimitedProse | None = table_key_field("how far to trust them", default=None)

    def build(self) -> Material:
        """Return the material in SI."""
        return Material(
            name=self.name,
            youngs_modulus=self.youngs_modulus,
            poisson=self.poisson,
            density=self.density,
            yield_strength=self.yield_,
            ultimate_strength=self.ultimate,
            fatigue_shear=self.fatigue_shear,
            kind=self.metal,  # type: ignore[arg-type]
            welded_yield=self.welded_yield,
            source=_source(self.source, self.how_read),
        )


class PlyTable(Table):
    """A ply of parallel fibres, or of a weave: along its first fibres and across them."""

    name: str = table_key_field("what files call it", default="in place")
    along: ElasticModulus = table_key_field("Young's modulus along the fibres")
    across: ElasticModulus = table_key_field("Young's modulus across them")
    shear: ElasticModulus = table_key_field("shear modulus in its plane")
    poisson: Annotated[float, NumberField(least=0, below=2)] = table_key_field(
        "Poisson's ratio: across, for a pull along", default=0.3
    )
    tension_along: MaterialStrength = table_key_field("strength along the fibres in tension")
    compression_along: MaterialStrength = table_key_field("the same in compression")
    tension_across: MaterialStrength = table_key_field("strength across them in tension")
    compression_across: MaterialStrength = table_key_field("the same in compression")
    shear_strength: MaterialStrength = table_key_field("strength in shear in its plane")
    thickness: PlyThickness = table_key_field("of one ply")
    density: Density = table_key_field("density")
    source: LengthLimitedProse | None = table_key_field("where the numbers come from", default=None)
    how_read: ProvenanceCode | None = table_key_field(f"how: {PROVENANCE_CODES_HELP}", default=None)
    note: LengthLimitedProse | None = table_key_field("how far to trust them", default=None)

    def build(self) -> Ply:
        """Return the ply in SI."""
        return Ply(
            name=self.name,
            along=self.along,
            across=self.across,
            shear=self.shear,
            poisson=self.poisson,
            tension_along=self.tension_along,
            compression_along=self.compression_along,
            tension_across=self.tension_across,
            compression_across=self.compression_across,
            shear_strength=self.shear_strength,
            thickness=self.thickness,
            density=self.density,
            source=_source(self.source, self.how_read),
        )


_ANGLE = NumberField(*ANGLE_KEY_UNITS, least=-90 * deg, most=90 * deg)


class LayerTable(Table):
    """Plies of one kind as they are wound, or one layer of a metal."""

    one_of = (("ply", "material"),)
    at_most_one_of = (("material", "angle"), ("material", "times"))

    ply: Annotated[Ply, UnionField(CatalogueReference("ply"), TableField(PlyTable))] | None = (
        table_key_field("a ply of a catalogue, or its properties", default=None)
    )
    material: (
        Annotated[Material, UnionField(CatalogueReference("material"), TableField(MaterialTable))]
        | None
    ) = table_key_field(
        "a metal of a catalogue, or its properties: a hybrid's tube inside", default=None
    )
    angle: (
        Annotated[float, _ANGLE]
        | Annotated[tuple[float, ...], ListField(_ANGLE, least=1, most=MAX_PLIES)]
    ) = table_key_field("of the fibres to the axis, or of each ply in turn: [45, -45]", default=0.0)
    times: Annotated[int, IntegerField(MAX_PLIES)] = table_key_field(
        "how often they follow each other", default=1
    )
    thickness: PlyThickness | None = table_key_field(
        "of one ply, in place of its own; of a metal", default=None
    )

    def build(self) -> tuple[OrientedPly, ...]:
        """Return the layers in SI, inside first."""
        if self.material is not None:
            if self.thickness is None:
                self.reader_of().reject("thickness_mm of a layer of metal is missing")
            thick, material = self.thickness, self.material
            return (OrientedPly(ply=self.attempt(lambda: metal_ply(material, thickness=thick))),)
        assert self.ply is not None  # one of the two is there
        ply = self.ply if self.thickness is None else replace(self.ply, thickness=self.thickness)
        angles = self.angle if isinstance(self.angle, tuple) else (self.angle,)
        return tuple(OrientedPly(ply=ply, angle=a) for a in angles) * self.times


class TubeTable(Table):
    """A round tube: its section, or the plies it is wound of."""

    one_of = (("wall", "layup"),)
    at_most_one_of = (("material", "layup"),)

    name: str | None = table_key_field("what files call it", default=None)
    outer: Diameter = table_key_field("outside diameter")
    wall: WallThickness | None = table_key_field("wall thickness", default=None)
    material: Annotated[
        Material, UnionField(CatalogueReference("material"), TableField(MaterialTable))
    ] = table_key_field(
        "a material of a catalogue, or its properties; E355-N, assumed, if left out",
        default=ASSUMED_TUBE_STEEL,
    )
    layup: (
        Annotated[
            tuple[tuple[OrientedPly, ...], ...],
            ListField(TableField(LayerTable), least=1, most=MAX_PLIES),
        ]
        | None
    ) = table_key_field(
        "plies from the inside out, in place of a wall of one material", default=None
    )
    source: LengthLimitedProse | None = table_key_field("where the numbers come from", default=None)
    how_read: ProvenanceCode | None = table_key_field(f"how: {PROVENANCE_CODES_HELP}", default=None)
    note: LengthLimitedProse | None = table_key_field("how far to trust them", default=None)

    def build(self) -> Tube | CompositeTube:
        """Return the tube in SI."""
        source = _source(self.source, self.how_read)
        if self.layup is not None:
            layers = tuple(layer for group in self.layup for layer in group)
            if len(layers) > MAX_PLIES:
                self.reader_of("layup").reject(
                    f"a tube may have up to {MAX_PLIES} plies", got=f"{len(layers)}"
                )
            return CompositeTube(outer=self.outer, layers=layers, source=source)
        assert self.wall is not None  # one of the two is there
        return Tube(
            outer=self.outer, wall=self.wall, material=self.material,
            name=self.name or "", source=source,
        )  # fmt: skip


_OF_KINDS = {
    "rated_life": ("rzeppa", "tripod"),
    "rated_speed": ("rzeppa", "tripod"),
    "rated_angle": ("rzeppa", "tripod"),
    "pitch_circle": ("rzeppa", "tripod"),
    "plunge": ("rzeppa", "tripod", "flexible disc"),
    "torsional_stiffness": ("flexible disc",),
    "bending_stiffness": ("flexible disc",),
    "bearing_Td": ("cross", "double cardan", "rzeppa", "tripod"),
    "centre_distance": ("double cardan",),
    "ball_from_rear": ("double cardan",),
    "bearing_Lc": ("cross", "double cardan"),
    "cross_width": ("cross", "double cardan"),
    "cup_diameter": ("cross", "double cardan"),
    "cup_length": ("cross", "double cardan"),
    "needle_circle": ("cross", "double cardan"),
}
"""Which kinds of joint a key belongs to, of those that not all have."""


def _called(maker: str | None, series: str | None) -> str:
    """Return maker and series in one; what ends the one and begins the other is said once.

    >>> _called("Dana GWB", "GWB 2000 Compact")
    'Dana GWB 2000 Compact'
    """
    first, then = (maker or "").split(), series or ""
    k = next((k for k in range(len(first)) if then.startswith(" ".join(first[k:]))), len(first))
    return " ".join([*first[:k], *([then] if then else [])])


class JointTable(Table):
    """A joint as catalogues rate it; leave out what is not published."""

    name: str = table_key_field("what files call it", default="in place")
    series: str | None = table_key_field("series", default=None)
    maker: str | None = table_key_field("maker", default=None)
    peak: TorqueRating | None = table_key_field("functional (elastic) limit torque", default=None)
    reversing: TorqueRating | None = table_key_field(
        "fatigue limit under alternating torque", default=None
    )
    pulsating: TorqueRating | None = table_key_field(
        "fatigue limit under pulsating torque", default=None
    )
    bearing_Td: TorqueRating | None = table_key_field(  # noqa: N815  the symbols catalogues print
        "torque the needles carry for 5000 h at 100 rpm and 3 deg; of a rzeppa or tripod for its "
        "rated life",
        default=None,
    )
    bearing_Lc: PositiveFactor | None = table_key_field(  # noqa: N815
        "GWB's bearing capacity factor, kN m based", default=None
    )
    kind: Literal["cross", "double cardan", "rzeppa", "tripod", "flexible disc"] = table_key_field(
        "a cross, or what keeps the speed", default="cross"
    )
    rated_life: LifeHours | None = table_key_field(
        "of a rzeppa or tripod under its bearing_Td, at rated_speed and rated_angle", default=None
    )
    rated_speed: PositiveSpeed | None = table_key_field("at which that life is rated", default=None)
    rated_angle: Angle | None = table_key_field(
        "at which that life is rated; straight if left out", default=None
    )
    pitch_circle: PartDimension | None = table_key_field(
        "diameter through the balls or rollers", default=None
    )
    plunge: SplineTravel | None = table_key_field(
        "how far it slides, either way; of a flexible disc, how far it may give along the line",
        default=None,
    )
    torsional_stiffness: TorsionStiffness | None = table_key_field(
        "of a flexible disc, about the line; stiff if left out", default=None
    )
    bending_stiffness: TorsionStiffness | None = table_key_field(
        "of a flexible disc, moment over its angle; none if left out", default=None
    )
    centre_distance: PartDimension | None = table_key_field(
        "between the crosses of a double cardan", default=None
    )
    ball_from_rear: PartDimension | None = table_key_field(
        "from its centring ball to the rear cross", default=None
    )
    nominal: TorqueRating | None = table_key_field(
        "nominal or reference torque: to compare catalogues by, no limit of anything", default=None
    )
    industrial: TorqueRating | None = table_key_field(
        "Spicer's T-Ind, no limit either", default=None
    )
    angle_max: Angle | None = table_key_field("largest joint angle", default=None)
    n_beta_max: SpeedAngleProduct | None = table_key_field(
        "largest speed times joint angle, rpm deg", default=None
    )
    speed_max: PositiveSpeed | None = table_key_field("largest speed", default=None)
    cross_width: PartDimension | None = table_key_field(
        "width over the cross's bearings", default=None
    )
    cup_diameter: PartDimension | None = table_key_field(
        "outside diameter of a bearing cup", default=None
    )
    cup_length: PartDimension | None = table_key_field(
        "of a bearing cup, in its yoke", default=None
    )
    needle_circle: PartDimension | None = table_key_field(
        "pitch circle diameter of the needles", default=None
    )
    swing_diameter: PartDimension | None = table_key_field(
        "of the circle the yokes turn in", default=None
    )
    tube_outer: PartDimension | None = table_key_field(
        "outside diameter of the tube it is made for", default=None
    )
    mass: Mass | None = table_key_field("mass of the cross with its bearings", default=None)
    source: LengthLimitedProse | None = table_key_field("where the numbers come from", default=None)
    how_read: ProvenanceCode | None = table_key_field(f"how: {PROVENANCE_CODES_HELP}", default=None)
    note: LengthLimitedProse | None = table_key_field("how far to trust them", default=None)

    def build(self) -> JointSize:
        """Return the joint in SI."""
        for name, kinds in _OF_KINDS.items():
            if getattr(self, name) is not None and self.kind not in kinds:
                of = " or ".join(f"a {kind}" for kind in kinds)
                self.reader_of(name).reject(f"belongs to {of}, not to a {self.kind}")
        length, ball = self.centre_distance, self.ball_from_rear
        if length is not None and ball is not None and not np.all(ball < length):
            self.reader_of("ball_from_rear").reject("must be less than the distance of the crosses")
        return JointSize(
            name=self.name,
            kind=self.kind,
            rated_life=self.rated_life,
            rated_speed=self.rated_speed,
            rated_angle=self.rated_angle,
            pitch_radius=None if self.pitch_circle is None else self.pitch_circle / 2,
            centre_distance=length,
            ball_from_rear=ball,
            plunge=self.plunge,
            torsional_stiffness=self.torsional_stiffness,
            bending_stiffness=self.bending_stiffness,
            series=_called(self.maker, self.series),
            peak_torque=self.peak,
            reversing_torque=self.reversing,
            pulsating_torque=self.pulsating,
            bearing_torque=self.bearing_Td,
            bearing_factor=self.bearing_Lc,
            angle_max=self.angle_max,
            speed_angle_max=self.n_beta_max,
            speed_max=self.speed_max,
            cross_width=self.cross_width,
            cup_diameter=self.cup_diameter,
            cup_length=self.cup_length,
            needle_circle=self.needle_circle,
            swing_diameter=self.swing_diameter,
            mass=self.mass,
            source=_source(self.source, self.how_read),
            note=self.note or "",
        )


class DetailClassTable(Table):
    """What a cut edge, a weld or a bolted hole bears: a class of a code."""

    name: str = table_key_field("what files call it", default="in place")
    range_: MaterialStrength = table_key_field("stress range at two million cycles: the class")
    cycles: CycleCount = table_key_field("cycles at the knee", default=1e7)
    slope: Annotated[float, NumberField(least=1, most=100)] = table_key_field(
        "m of N ~ range^-m", default=3.0
    )
    mean: Annotated[str, EnumField(*MEAN_STRESS_METHODS)] = table_key_field(
        "how a mean stress counts: none; ratio, by IIW's f(R); goodman", default="none"
    )
    metal: Annotated[str, EnumField(*METAL_KINDS)] | None = table_key_field(
        "of what metal, where a code says so", default=None
    )
    source: LengthLimitedProse | None = table_key_field("where the numbers come from", default=None)
    how_read: ProvenanceCode | None = table_key_field(f"how: {PROVENANCE_CODES_HELP}", default=None)
    note: LengthLimitedProse | None = table_key_field("how far to trust them", default=None)

    def build(self) -> FatigueCurve:
        """Return the curve in SI."""
        knee = fat_class_knee_amplitude(self.range_, cycles=self.cycles, slope=self.slope)
        return FatigueCurve(
            amplitude=knee, cycles=self.cycles, slope=self.slope, mean=self.mean,  # type: ignore[arg-type]
            name=self.name, metal=self.metal,  # type: ignore[arg-type]
            source=_source(self.source, self.how_read),
        )  # fmt: skip


DetailClassOrCatalogueName: TypeAlias = Annotated[
    FatigueCurve, UnionField(CatalogueReference("detail"), TableField(DetailClassTable))
]
MaterialOrCatalogueName: TypeAlias = Annotated[
    Material, UnionField(CatalogueReference("material"), TableField(MaterialTable))
]
TubeOrCatalogueName: TypeAlias = Annotated[
    Tube | CompositeTube, UnionField(CatalogueReference("tube"), TableField(TubeTable))
]
JOINT_OR_CATALOGUE_NAME_FIELD = UnionField(CatalogueReference("joint"), TableField(JointTable))

TABLE_CLASS_BY_PART_KIND: dict[CataloguePartKind, type[Table]] = {
    "joint": JointTable, "tube": TubeTable, "material": MaterialTable, "ply": PlyTable,
    "detail": DetailClassTable,
}  # fmt: skip


MAX_CATALOGUE_ROWS = 5000
"""Of a catalogue: the largest printed one has some hundred joints."""


class CatalogueCsvFile:
    """One CSV file: its rows as tables that know their line and column."""

    def __init__(self, text: str, file: str) -> None:
        self.file = file
        text = text.removeprefix("\ufeff")
        reject_hidden_characters(text, file)
        comma = ";" if ";" in text.partition("\n")[0] else ","  # spreadsheets write both
        rows = csv.reader(io.StringIO(text, newline=""), delimiter=comma)
        try:
            self.header = [c.strip() or f"column {k}" for k, c in enumerate(next(rows, []), 1)]
            self._rows = [(rows.line_num, row) for row in rows if any(c.strip() for c in row)]
        except csv.Error as error:
            problem = FileIssue(message=f"this is no CSV: {error}", line=rows.line_num, column=1)
            raise InvalidFileError(file, (problem,)) from None

    @cached_property
    def kind(self) -> CataloguePartKind:
        """What it lists, by its columns."""

        def known(kind: CataloguePartKind) -> int:
            return sum(column in TABLE_CLASS_BY_PART_KIND[kind].keys() for column in self.header)  # noqa: SIM118

        return max(TABLE_CLASS_BY_PART_KIND, key=known)

    @cached_property
    def rows(self) -> dict[str, tuple[int, list[str]]]:
        """Line and cells by name."""
        if "name" not in self.header:
            return {}
        column = self.header.index("name")
        named = ((row[column].strip(), (n, row)) for n, row in self._rows if len(row) > column)
        return {name: row for name, row in named if name}

    def _table(self, line: int, cells: list[str]) -> Mapping:
        """Return a row as a table of the cells that are filled; columns count from 1."""
        entries: dict[str, tuple[Scalar, Node]] = {}
        for k, (name, cell) in enumerate(zip(self.header, cells, strict=False), 1):
            if cell.strip() and name in TABLE_CLASS_BY_PART_KIND[self.kind].keys():  # noqa: SIM118
                entries[name] = Scalar(name, line, k), Scalar(cell.strip(), line, k)
        return Mapping(line, 1, entries)

    def part(self, name: str, here: NodeReader) -> Any:
        """Return the part of a name in this sheet, as if its row stood in the file.

        So its numbers have addresses there, and can be changed. What is wrong or looks
        wrong in the sheet itself is said where the sheet is named.
        """
        row = self._table(*self.rows[name])
        for written, node in row.entries.values():
            written.line = node.line = here.node.line
            written.column = node.column = here.node.column
        reading = here.context
        noted, warned = len(reading.problems), len(reading.warnings)
        try:
            return TABLE_CLASS_BY_PART_KIND[self.kind].read(replace(here, node=row))
        finally:
            del reading.warnings[warned:]
            if not any(at.startswith(f"{here.address}.") for at in reading.changes):
                del reading.problems[noted:]

    def check(self, reading: TableReadContext, above: Sequence["CatalogueCsvFile"] = ()) -> None:
        """Note whatever is wrong in the sheet, also next to those read before it."""
        if "name" not in self.header:
            message = "the first line must name the columns, and one of them is name"
            NodeReader(Mapping(1, 1), "", reading).add_issue(message)
            return
        for k, column in enumerate(self.header):
            here = NodeReader(Mapping(1, k + 1), column, reading)
            if column not in TABLE_CLASS_BY_PART_KIND[self.kind].keys():  # noqa: SIM118
                here.add_issue(
                    "unknown column",
                    nearest_name_hint(column, TABLE_CLASS_BY_PART_KIND[self.kind].keys()),
                )
            elif column in self.header[:k]:
                here.add_issue("this column stands here twice")
        lines: dict[str, int] = {}
        for line, cells in self._rows:
            row = self._table(line, cells)
            if any(c.strip() for c in cells[len(self.header) :]):
                message = f"this row has {len(cells)} cells, the header {len(self.header)}"
                hint = "write a decimal point, and put text with a comma in quotes"
                NodeReader(row, "", reading).add_issue(message, hint)
            if len(lines) >= MAX_CATALOGUE_ROWS:
                NodeReader(row, "", reading).add_issue(
                    f"a catalogue may have up to {MAX_CATALOGUE_ROWS} rows"
                )
                return
            if "name" not in row.entries:
                NodeReader(row, "", reading).add_issue("this row has no name")
                continue
            name = cells[self.header.index("name")].strip()
            if name in lines:
                NodeReader(row, name, reading).add_issue(
                    f"this name is in line {lines[name]} already"
                )
            same = (s for s in above if s.kind == self.kind and name in s.rows)
            if other := next(same, None):
                NodeReader(row, name, reading).add_issue(
                    f"this name is in {Path(other.file).name} too"
                )
            lines.setdefault(name, line)
            try:
                TABLE_CLASS_BY_PART_KIND[self.kind].read(NodeReader(row, name, reading))
            except InvalidValueError:
                continue


class Catalogue:
    """Parts by name: from sheets of the user's own, then from those shipped."""

    def __init__(self, own: Sequence[CatalogueCsvFile] = ()) -> None:
        self.user_sheets = own

    def sheets(self, kind: CataloguePartKind) -> Iterator[CatalogueCsvFile]:
        """Yield the sheets that list a kind of part, the user's own first."""
        yield from (s for s in self.user_sheets if s.kind == kind)
        yield read_shipped_catalogue(kind)

    def names(self, kind: CataloguePartKind) -> list[str]:
        """Return every name of a kind of part, the user's own first."""
        return list(dict.fromkeys(name for sheet in self.sheets(kind) for name in sheet.rows))

    def parts(self, kind: CataloguePartKind) -> Iterator[Any]:
        """Yield every part of a kind, the user's own first."""
        own = dict.fromkeys(n for s in self.user_sheets if s.kind == kind for n in s.rows)
        yield from (self.find(name, kind) for name in own)
        yield from (part for name, part in _parts(kind).items() if name not in own)

    def find(self, name: str, kind: CataloguePartKind, here: NodeReader | None = None) -> Any:
        """Return the part of that name, for a place in a file where it stands.

        Case, spaces and zeros behind a point do not matter: `3.5x0.12in` is `3.500x0.120in`. A
        tube that no catalogue has may be given by its sizes: `100x4`, `100 x 4`, `4x0.125in`.

        Raises
        ------
        DesignError
            If no catalogue has it; the message names what comes nearest, of tubes and joints in
            size.
        """
        here = here or NodeReader(Scalar(name, 0, 0), name, TableReadContext(self))
        for sheet in self.sheets(kind):
            if name in sheet.rows:
                return sheet.part(name, here)
        for sheet in self.sheets(kind):
            for known in sheet.rows:
                if _loose(known) == _loose(name):
                    return sheet.part(known, here)
        if kind == "tube" and (tube := tube_of_sizes(name)) is not None:
            return self._tube_of_same_sizes(tube) or tube
        msg = f"no catalogue has a {kind} {name}; {self._hint(name, kind)}"
        raise DesignError(msg)

    def _tube_of_same_sizes(self, of: Tube) -> Tube | CompositeTube | None:
        """Return the catalogue's tube of the same sizes, whose material is known; None if none."""
        return next(
            (
                tube
                for tube in self.parts("tube")
                if isclose(tube.outer, of.outer, rel_tol=1e-6)
                and isinstance(tube, Tube)
                and isclose(tube.wall, of.wall, rel_tol=1e-6)
            ),
            None,
        )

    def _hint(self, name: str, kind: CataloguePartKind) -> str:
        """Return advice on a name that no catalogue has."""
        if kind == "tube":
            return tube_size_hint(name, {t.name: t for t in self.parts(kind) if _has_wall(t)})
        names = self.names(kind)
        bare = _loose(name)
        inside = [n for n in names if _loose(n) in bare or bare in _loose(n)]
        if kind == "joint":  # 710 stands in 1710, and is no size near it
            inside = [n for n in inside if _numbers(n) & _numbers(name)]
        inside.sort(key=lambda n: abs(len(_loose(n)) - len(bare)))
        if inside:
            return f"did you mean {' or '.join(inside[:3])}?"
        if kind != "joint":
            return nearest_name_hint(name, names)
        near = joint_size_hint(name, {j.name: j.peak_torque for j in self.parts(kind)})
        return near or nearest_name_hint("", names)


def _has_wall(tube: Tube | CompositeTube) -> bool:
    """Return whether a tube is of one material, and so has the wall that its size names."""
    return isinstance(tube, Tube)


def _numbers(name: str) -> set[str]:
    """Return the numbers in a name."""
    return set(re.findall(r"\d+(?:\.\d+)?", _loose(name)))


def _loose(name: str) -> str:
    """Return a name without what people vary in it."""
    bare = re.sub(r"^(tube|joint|material|ply|detail)\b|[\s_]", "", name.casefold())
    return re.sub(r"\d+\.\d+", lambda found: f"{float(found[0]):g}", bare)


@cache
def read_shipped_catalogue(kind: CataloguePartKind) -> CatalogueCsvFile:
    """Return the sheet of a kind of part that comes with this package."""
    name = "plies" if kind == "ply" else f"{kind}s"
    path = Path(__file__).with_name("catalogues") / f"{name}.csv"
    return CatalogueCsvFile(path.read_text(encoding="utf-8"), path.name)


@cache
def _parts(kind: CataloguePartKind) -> dict[str, Any]:
    """Return the shipped parts of a kind by their names."""
    return {name: find_shipped_part(name, kind) for name in read_shipped_catalogue(kind).rows}


def find_shipped_part(name: str, kind: CataloguePartKind) -> Any:
    """Return a shipped part: `find("3.5x0.12in", "tube")`."""
    return Catalogue().find(name, kind)
