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
from pathlib import Path
from typing import Annotated, Any, Literal, TypeAlias

import numpy as np

from cardan.base.errors import BadFile, DesignError, Problem
from cardan.base.source import ASSUMED, HOW_READ, Source
from cardan.base.units import deg
from cardan.border.document import Mapping, Node, Scalar, refuse_hidden
from cardan.border.measure import (
    ANGLES,
    Angle,
    Cycles,
    Density,
    Diameter,
    Factor,
    Hours,
    Mass,
    PlyThickness,
    PositiveSpeed,
    Rating,
    Size,
    SpeedAngle,
    SplineTravel,
    Stiff,
    Strength,
    Wall,
)  # fmt: skip
from cardan.border.table import (
    PROSE,
    Choice,
    Here,
    ListOf,
    Number,
    OneOf,
    Reading,
    Spoilt,
    Table,
    TableRule,
    Text,
    Whole,
    key,
    nearest,
)
from cardan.fatigue.detail import at_knee
from cardan.files.how_read import HowRead, with_reading
from cardan.model.bracket import MEANS, FatigueCurve
from cardan.model.laminate import CompositeTube, Layer, Ply, metal
from cardan.model.material import METALS, STEEL, Material
from cardan.model.parts import JointSize, Tube

PLIES = 400
"""Of one tube: 50 mm of wall, and a limit far above what is wound keeps a mistake short."""

Kind: TypeAlias = Literal["joint", "tube", "material", "ply", "detail"]


class Named(Text):
    """The name of a part in a catalogue."""

    def __init__(self, kind: Kind) -> None:
        super().__init__()
        self.kind: Kind = kind
        many = "plies" if kind == "ply" else f"{kind}s"
        self.one, self.many = f"a {kind} of a catalogue", f"{many} of a catalogue"

    def read(self, here: Here) -> Any:
        """Return the part itself."""
        name = self.text(here)
        try:
            return here.reading.catalogue.find(name, self.kind, here)
        except DesignError as error:
            message, _, hint = str(error).partition("; ")
            here.refuse(message, hint)

    def schema(self, defs: dict[str, Any], unit: str) -> dict[str, Any]:
        """Return a name of the shipped catalogue, which editors offer, or any of one's own."""
        return {"anyOf": [{"enum": list(shipped(self.kind).rows)}, super().schema(defs, unit)]}


def _source(said: str | None, read: HowRead | None) -> Source:
    return with_reading(ASSUMED if said is None else Source(said), read)


Prose: TypeAlias = Annotated[str, Text(PROSE)]

READ_AS = f"{', '.join(HOW_READ)}; values that differ behind a semicolon"


class MaterialTable(Table):
    """An isotropic material."""

    name: str = key("what files call it", default="in place")
    youngs_modulus: Stiff = key("Young's modulus")
    poisson: Annotated[float, Number(least=0, below=0.5)] = key("Poisson's ratio", default=0.3)
    density: Density = key("density")
    yield_: Strength | None = key("yield strength", default=None)
    ultimate: Strength | None = key("ultimate strength", default=None)
    fatigue_shear: Strength | None = key("fatigue limit in alternating shear", default=None)
    metal: Annotated[str, Choice(*METALS)] | None = key(
        "what metal it is; left out, steel if its modulus is 180 GPa or more, else other",
        default=None,
    )
    welded_yield: Strength | None = key(
        "yield strength beside a weld, where its heat lowers it, as of aluminium", default=None
    )
    source: Prose | None = key("where the numbers come from", default=None)
    how_read: HowRead | None = key(f"how: {READ_AS}", default=None)
    note: Prose | None = key("how far to trust them", default=None)

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

    name: str = key("what files call it", default="in place")
    along: Stiff = key("Young's modulus along the fibres")
    across: Stiff = key("Young's modulus across them")
    shear: Stiff = key("shear modulus in its plane")
    poisson: Annotated[float, Number(least=0, below=2)] = key(
        "Poisson's ratio: across, for a pull along", default=0.3
    )
    tension_along: Strength = key("strength along the fibres in tension")
    compression_along: Strength = key("the same in compression")
    tension_across: Strength = key("strength across them in tension")
    compression_across: Strength = key("the same in compression")
    shear_strength: Strength = key("strength in shear in its plane")
    thickness: PlyThickness = key("of one ply")
    density: Density = key("density")
    source: Prose | None = key("where the numbers come from", default=None)
    how_read: HowRead | None = key(f"how: {READ_AS}", default=None)
    note: Prose | None = key("how far to trust them", default=None)

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


_ANGLE = Number(*ANGLES, least=-90 * deg, most=90 * deg)


class LayerTable(Table):
    """Plies of one kind as they are wound, or one layer of a metal."""

    one_of = (("ply", "material"),)
    at_most_one_of = (("material", "angle"), ("material", "times"))

    ply: Annotated[Ply, OneOf(Named("ply"), TableRule(PlyTable))] | None = key(
        "a ply of a catalogue, or its properties", default=None
    )
    material: Annotated[Material, OneOf(Named("material"), TableRule(MaterialTable))] | None = key(
        "a metal of a catalogue, or its properties: a hybrid's tube inside", default=None
    )
    angle: (
        Annotated[float, _ANGLE] | Annotated[tuple[float, ...], ListOf(_ANGLE, least=1, most=PLIES)]
    ) = key("of the fibres to the axis, or of each ply in turn: [45, -45]", default=0.0)
    times: Annotated[int, Whole(PLIES)] = key("how often they follow each other", default=1)
    thickness: PlyThickness | None = key(
        "of one ply, in place of its own; of a metal", default=None
    )

    def build(self) -> tuple[Layer, ...]:
        """Return the layers in SI, inside first."""
        if self.material is not None:
            if self.thickness is None:
                self.at().refuse("thickness_mm of a layer of metal is missing")
            thick, material = self.thickness, self.material
            return (Layer(ply=self.attempt(lambda: metal(material, thickness=thick))),)
        assert self.ply is not None  # one of the two is there
        ply = self.ply if self.thickness is None else replace(self.ply, thickness=self.thickness)
        angles = self.angle if isinstance(self.angle, tuple) else (self.angle,)
        return tuple(Layer(ply=ply, angle=a) for a in angles) * self.times


class TubeTable(Table):
    """A round tube: its section, or the plies it is wound of."""

    one_of = (("wall", "layup"),)
    at_most_one_of = (("material", "layup"),)

    name: str | None = key("what files call it", default=None)
    outer: Diameter = key("outside diameter")
    wall: Wall | None = key("wall thickness", default=None)
    material: Annotated[Material, OneOf(Named("material"), TableRule(MaterialTable))] = key(
        "a material of a catalogue, or its properties", default=STEEL
    )
    layup: (
        Annotated[tuple[tuple[Layer, ...], ...], ListOf(TableRule(LayerTable), least=1, most=PLIES)]
        | None
    ) = key("plies from the inside out, in place of a wall of one material", default=None)
    source: Prose | None = key("where the numbers come from", default=None)
    how_read: HowRead | None = key(f"how: {READ_AS}", default=None)
    note: Prose | None = key("how far to trust them", default=None)

    def build(self) -> Tube | CompositeTube:
        """Return the tube in SI."""
        source = _source(self.source, self.how_read)
        if self.layup is not None:
            layers = tuple(layer for group in self.layup for layer in group)
            if len(layers) > PLIES:
                self.at("layup").refuse(
                    f"a tube may have up to {PLIES} plies", got=f"{len(layers)}"
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
    "plunge": ("rzeppa", "tripod"),
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

    name: str = key("what files call it", default="in place")
    series: str | None = key("series", default=None)
    maker: str | None = key("maker", default=None)
    peak: Rating | None = key("functional (elastic) limit torque", default=None)
    reversing: Rating | None = key("fatigue limit under alternating torque", default=None)
    pulsating: Rating | None = key("fatigue limit under pulsating torque", default=None)
    bearing_Td: Rating | None = key(  # noqa: N815  the symbols catalogues print
        "torque the needles carry for 5000 h at 100 rpm and 3 deg; of a rzeppa or tripod for its "
        "rated life",
        default=None,
    )
    bearing_Lc: Factor | None = key(  # noqa: N815
        "GWB's bearing capacity factor, kN m based", default=None
    )
    kind: Literal["cross", "double cardan", "rzeppa", "tripod"] = key(
        "a cross, or what keeps the speed", default="cross"
    )
    rated_life: Hours | None = key(
        "of a rzeppa or tripod under its bearing_Td, at rated_speed and rated_angle", default=None
    )
    rated_speed: PositiveSpeed | None = key("at which that life is rated", default=None)
    rated_angle: Angle | None = key(
        "at which that life is rated; straight if left out", default=None
    )
    pitch_circle: Size | None = key("diameter through the balls or rollers", default=None)
    plunge: SplineTravel | None = key("how far it slides, either way", default=None)
    centre_distance: Size | None = key("between the crosses of a double cardan", default=None)
    ball_from_rear: Size | None = key("from its centring ball to the rear cross", default=None)
    nominal: Rating | None = key(
        "nominal or reference torque: to compare catalogues by, no limit of anything", default=None
    )
    industrial: Rating | None = key("Spicer's T-Ind, no limit either", default=None)
    angle_max: Angle | None = key("largest joint angle", default=None)
    n_beta_max: SpeedAngle | None = key("largest speed times joint angle, rpm deg", default=None)
    speed_max: PositiveSpeed | None = key("largest speed", default=None)
    cross_width: Size | None = key("width over the cross's bearings", default=None)
    cup_diameter: Size | None = key("outside diameter of a bearing cup", default=None)
    cup_length: Size | None = key("of a bearing cup, in its yoke", default=None)
    needle_circle: Size | None = key("pitch circle diameter of the needles", default=None)
    swing_diameter: Size | None = key("of the circle the yokes turn in", default=None)
    tube_outer: Size | None = key("outside diameter of the tube it is made for", default=None)
    mass: Mass | None = key("mass of the cross with its bearings", default=None)
    source: Prose | None = key("where the numbers come from", default=None)
    how_read: HowRead | None = key(f"how: {READ_AS}", default=None)
    note: Prose | None = key("how far to trust them", default=None)

    def build(self) -> JointSize:
        """Return the joint in SI."""
        for name, kinds in _OF_KINDS.items():
            if getattr(self, name) is not None and self.kind not in kinds:
                of = " or ".join(f"a {kind}" for kind in kinds)
                self.at(name).refuse(f"belongs to {of}, not to a {self.kind}")
        length, ball = self.centre_distance, self.ball_from_rear
        if length is not None and ball is not None and not np.all(ball < length):
            self.at("ball_from_rear").refuse("must be less than the distance of the crosses")
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


class DetailTable(Table):
    """What a cut edge, a weld or a bolted hole bears: a class of a code."""

    name: str = key("what files call it", default="in place")
    range_: Strength = key("stress range at two million cycles: the class")
    cycles: Cycles = key("cycles at the knee", default=1e7)
    slope: Annotated[float, Number(least=1, most=100)] = key("m of N ~ range^-m", default=3.0)
    mean: Annotated[str, Choice(*MEANS)] = key(
        "how a mean stress counts: none; ratio, by IIW's f(R); goodman", default="none"
    )
    metal: Annotated[str, Choice(*METALS)] | None = key(
        "of what metal, where a code says so", default=None
    )
    source: Prose | None = key("where the numbers come from", default=None)
    how_read: HowRead | None = key(f"how: {READ_AS}", default=None)
    note: Prose | None = key("how far to trust them", default=None)

    def build(self) -> FatigueCurve:
        """Return the curve in SI."""
        knee = at_knee(self.range_, cycles=self.cycles, slope=self.slope)
        return FatigueCurve(
            amplitude=knee, cycles=self.cycles, slope=self.slope, mean=self.mean,  # type: ignore[arg-type]
            name=self.name, metal=self.metal,  # type: ignore[arg-type]
            source=_source(self.source, self.how_read),
        )  # fmt: skip


ADetail: TypeAlias = Annotated[FatigueCurve, OneOf(Named("detail"), TableRule(DetailTable))]
AMaterial: TypeAlias = Annotated[Material, OneOf(Named("material"), TableRule(MaterialTable))]
ATube: TypeAlias = Annotated[Tube | CompositeTube, OneOf(Named("tube"), TableRule(TubeTable))]
A_JOINT = OneOf(Named("joint"), TableRule(JointTable))

TABLES: dict[Kind, type[Table]] = {
    "joint": JointTable, "tube": TubeTable, "material": MaterialTable, "ply": PlyTable,
    "detail": DetailTable,
}  # fmt: skip


ROWS = 5000
"""Of a catalogue: the largest printed one has some hundred joints."""


class Sheet:
    """One CSV file: its rows as tables that know their line and column."""

    def __init__(self, text: str, file: str) -> None:
        self.file = file
        text = text.removeprefix("\ufeff")
        refuse_hidden(text, file)
        comma = ";" if ";" in text.partition("\n")[0] else ","  # spreadsheets write both
        rows = csv.reader(io.StringIO(text, newline=""), delimiter=comma)
        try:
            self.header = [c.strip() or f"column {k}" for k, c in enumerate(next(rows, []), 1)]
            self._rows = [(rows.line_num, row) for row in rows if any(c.strip() for c in row)]
        except csv.Error as error:
            problem = Problem(message=f"this is no CSV: {error}", line=rows.line_num, column=1)
            raise BadFile(file, (problem,)) from None

    @cached_property
    def kind(self) -> Kind:
        """What it lists, by its columns."""

        def known(kind: Kind) -> int:
            return sum(column in TABLES[kind].keys() for column in self.header)  # noqa: SIM118

        return max(TABLES, key=known)

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
            if cell.strip() and name in TABLES[self.kind].keys():  # noqa: SIM118
                entries[name] = Scalar(name, line, k), Scalar(cell.strip(), line, k)
        return Mapping(line, 1, entries)

    def part(self, name: str, here: Here) -> Any:
        """Return the part of a name in this sheet, as if its row stood in the file.

        So its numbers have addresses there, and can be changed. What is wrong or looks
        wrong in the sheet itself is said where the sheet is named.
        """
        row = self._table(*self.rows[name])
        for written, node in row.entries.values():
            written.line = node.line = here.node.line
            written.column = node.column = here.node.column
        reading = here.reading
        noted, warned = len(reading.problems), len(reading.warnings)
        try:
            return TABLES[self.kind].read(replace(here, node=row))
        finally:
            del reading.warnings[warned:]
            if not any(at.startswith(f"{here.at}.") for at in reading.changes):
                del reading.problems[noted:]

    def check(self, reading: Reading, above: Sequence["Sheet"] = ()) -> None:
        """Note whatever is wrong in the sheet, also beside those read before it."""
        if "name" not in self.header:
            message = "the first line must name the columns, and one of them is name"
            Here(Mapping(1, 1), "", reading).note(message)
            return
        for k, column in enumerate(self.header):
            here = Here(Mapping(1, k + 1), column, reading)
            if column not in TABLES[self.kind].keys():  # noqa: SIM118
                here.note("unknown column", nearest(column, TABLES[self.kind].keys()))
            elif column in self.header[:k]:
                here.note("this column stands here twice")
        lines: dict[str, int] = {}
        for line, cells in self._rows:
            row = self._table(line, cells)
            if any(c.strip() for c in cells[len(self.header) :]):
                message = f"this row has {len(cells)} cells, the header {len(self.header)}"
                hint = "write a decimal point, and put text with a comma in quotes"
                Here(row, "", reading).note(message, hint)
            if len(lines) >= ROWS:
                Here(row, "", reading).note(f"a catalogue may have up to {ROWS} rows")
                return
            if "name" not in row.entries:
                Here(row, "", reading).note("this row has no name")
                continue
            name = cells[self.header.index("name")].strip()
            if name in lines:
                Here(row, name, reading).note(f"this name is in line {lines[name]} already")
            same = (s for s in above if s.kind == self.kind and name in s.rows)
            if other := next(same, None):
                Here(row, name, reading).note(f"this name is in {Path(other.file).name} too")
            lines.setdefault(name, line)
            try:
                TABLES[self.kind].read(Here(row, name, reading))
            except Spoilt:
                continue


class Catalogue:
    """Parts by name: from sheets of the user's own, then from those shipped."""

    def __init__(self, own: Sequence[Sheet] = ()) -> None:
        self.own = own

    def sheets(self, kind: Kind) -> Iterator[Sheet]:
        """Yield the sheets that list a kind of part, the user's own first."""
        yield from (s for s in self.own if s.kind == kind)
        yield shipped(kind)

    def names(self, kind: Kind) -> list[str]:
        """Return every name of a kind of part, the user's own first."""
        return list(dict.fromkeys(name for sheet in self.sheets(kind) for name in sheet.rows))

    def every(self, kind: Kind) -> Iterator[Any]:
        """Yield every part of a kind, the user's own first."""
        own = dict.fromkeys(n for s in self.own if s.kind == kind for n in s.rows)
        yield from (self.find(name, kind) for name in own)
        yield from (part for name, part in _parts(kind).items() if name not in own)

    def find(self, name: str, kind: Kind, here: Here | None = None) -> Any:
        """Return the part of that name, for a place in a file where it stands.

        Case, spaces and zeros behind a point do not matter: `3.5x0.12in` is `3.500x0.120in`.

        Raises
        ------
        DesignError
            If no catalogue has it; the message names what comes nearest.
        """
        here = here or Here(Scalar(name, 0, 0), name, Reading(self))
        for sheet in self.sheets(kind):
            if name in sheet.rows:
                return sheet.part(name, here)
        for sheet in self.sheets(kind):
            for known in sheet.rows:
                if _loose(known) == _loose(name):
                    return sheet.part(known, here)
        names = self.names(kind)
        bare = _loose(name)
        inside = [n for n in names if _loose(n) in bare or bare in _loose(n)]
        inside.sort(key=lambda n: abs(len(_loose(n)) - len(bare)))
        advice = f"did you mean {' or '.join(inside[:3])}?" if inside else nearest(name, names)
        msg = f"no catalogue has a {kind} {name}; {advice}"
        raise DesignError(msg)


def _loose(name: str) -> str:
    """Return a name without what people vary in it."""
    bare = re.sub(r"^(tube|joint|material|ply|detail)\b|[\s_]", "", name.casefold())
    return re.sub(r"\d+\.\d+", lambda found: f"{float(found[0]):g}", bare)


@cache
def shipped(kind: Kind) -> Sheet:
    """Return the sheet of a kind of part that comes with this package."""
    name = "plies" if kind == "ply" else f"{kind}s"
    path = Path(__file__).with_name("catalogues") / f"{name}.csv"
    return Sheet(path.read_text(encoding="utf-8"), path.name)


@cache
def _parts(kind: Kind) -> dict[str, Any]:
    """Return the shipped parts of a kind by their names."""
    return {name: find(name, kind) for name in shipped(kind).rows}


def find(name: str, kind: Kind) -> Any:
    """Return a shipped part: `find("3.5x0.12in", "tube")`."""
    return Catalogue().find(name, kind)
