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

from cardan.base.errors import BadFile, DesignError, Problem
from cardan.base.source import Source
from cardan.border.document import Mapping, Node, Scalar, refuse_hidden
from cardan.border.measure import (
    Angle,
    Cycles,
    Density,
    Diameter,
    Factor,
    Mass,
    PositiveSpeed,
    Rating,
    Size,
    SpeedAngle,
    Stiff,
    Strength,
    Wall,
)  # fmt: skip
from cardan.border.table import (
    PROSE,
    Choice,
    Here,
    Number,
    OneOf,
    Reading,
    Spoilt,
    Table,
    TableRule,
    Text,
    key,
    nearest,
)
from cardan.fatigue.detail import at_knee
from cardan.model.bracket import MEANS, FatigueCurve
from cardan.model.parts import ASSUMED, STEEL, JointSize, Material, Tube

Kind: TypeAlias = Literal["joint", "tube", "material", "detail"]


class Named(Text):
    """The name of a part in a catalogue."""

    def __init__(self, kind: Kind) -> None:
        super().__init__()
        self.kind: Kind = kind
        self.one, self.many = f"a {kind} of a catalogue", f"{kind}s of a catalogue"

    def read(self, here: Here) -> Any:
        """Return the part itself."""
        name = self.text(here)
        try:
            return here.reading.catalogue.find(name, self.kind, here)
        except DesignError as error:
            message, _, hint = str(error).partition("; ")
            here.refuse(message, hint)


def _source(said: str | None) -> Source:
    return ASSUMED if said is None else Source(said)


Prose: TypeAlias = Annotated[str, Text(PROSE)]


class MaterialTable(Table):
    """An isotropic material."""

    name: str = key("what files call it", default="in place")
    youngs_modulus: Stiff = key("Young's modulus")
    poisson: Annotated[float, Number(least=0, below=0.5)] = key("Poisson's ratio", default=0.3)
    density: Density = key("density")
    yield_: Strength | None = key("yield strength", default=None)
    ultimate: Strength | None = key("ultimate strength", default=None)
    fatigue_shear: Strength | None = key("fatigue limit in alternating shear", default=None)
    source: Prose | None = key("where the numbers come from", default=None)
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
            source=_source(self.source),
        )


class TubeTable(Table):
    """A round tube's section."""

    name: str | None = key("what files call it", default=None)
    outer: Diameter = key("outside diameter")
    wall: Wall = key("wall thickness")
    material: Annotated[Material, OneOf(Named("material"), TableRule(MaterialTable))] = key(
        "a material of a catalogue, or its properties", default=STEEL
    )
    source: Prose | None = key("where the numbers come from", default=None)
    note: Prose | None = key("how far to trust them", default=None)

    def build(self) -> Tube:
        """Return the tube in SI."""
        return Tube(outer=self.outer, wall=self.wall, material=self.material)


class JointTable(Table):
    """A universal joint as catalogues rate it; leave out what is not published."""

    name: str = key("what files call it", default="in place")
    series: str | None = key("series", default=None)
    maker: str | None = key("maker", default=None)
    peak: Rating | None = key("functional (elastic) limit torque", default=None)
    reversing: Rating | None = key("fatigue limit under alternating torque", default=None)
    pulsating: Rating | None = key("fatigue limit under pulsating torque", default=None)
    bearing_Td: Rating | None = key(  # noqa: N815  the symbols catalogues print
        "torque the needles carry for 5000 h at 100 rpm and 3 deg", default=None
    )
    bearing_Lc: Factor | None = key(  # noqa: N815
        "GWB's bearing capacity factor, kN m based", default=None
    )
    angle_max: Angle | None = key("largest joint angle", default=None)
    n_beta_max: SpeedAngle | None = key("largest speed times joint angle, rpm deg", default=None)
    speed_max: PositiveSpeed | None = key("largest speed", default=None)
    cross_width: Size | None = key("width over the cross's bearings", default=None)
    cup_diameter: Size | None = key("outside diameter of a bearing cup", default=None)
    needle_circle: Size | None = key("pitch circle diameter of the needles", default=None)
    mass: Mass | None = key("mass of the cross with its bearings", default=None)
    source: Prose | None = key("where the numbers come from", default=None)
    note: Prose | None = key("how far to trust them", default=None)

    def build(self) -> JointSize:
        """Return the joint in SI."""
        return JointSize(
            name=self.name,
            series=" ".join(filter(None, (self.maker, self.series))),
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
            needle_circle=self.needle_circle,
            mass=self.mass,
            source=_source(self.source),
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
    source: Prose | None = key("where the numbers come from", default=None)
    note: Prose | None = key("how far to trust them", default=None)

    def build(self) -> FatigueCurve:
        """Return the curve in SI."""
        knee = at_knee(self.range_, cycles=self.cycles, slope=self.slope)
        return FatigueCurve(
            amplitude=knee, cycles=self.cycles, slope=self.slope, mean=self.mean,  # type: ignore[arg-type]
            name=self.name, source=_source(self.source),
        )  # fmt: skip


ADetail: TypeAlias = Annotated[FatigueCurve, OneOf(Named("detail"), TableRule(DetailTable))]
AMaterial: TypeAlias = Annotated[Material, OneOf(Named("material"), TableRule(MaterialTable))]
ATube: TypeAlias = Annotated[Tube, OneOf(Named("tube"), TableRule(TubeTable))]
A_JOINT = OneOf(Named("joint"), TableRule(JointTable))

TABLES: dict[Kind, type[Table]] = {
    "joint": JointTable, "tube": TubeTable, "material": MaterialTable,
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
            self._header = [c.strip() or f"column {k}" for k, c in enumerate(next(rows, []), 1)]
            self._rows = [(rows.line_num, row) for row in rows if any(c.strip() for c in row)]
        except csv.Error as error:
            problem = Problem(message=f"this is no CSV: {error}", line=rows.line_num, column=1)
            raise BadFile(file, (problem,)) from None

    @cached_property
    def kind(self) -> Kind:
        """What it lists, by its columns."""

        def known(kind: Kind) -> int:
            return sum(column in TABLES[kind].keys() for column in self._header)  # noqa: SIM118

        return max(TABLES, key=known)

    @cached_property
    def rows(self) -> dict[str, tuple[int, list[str]]]:
        """Line and cells by name."""
        if "name" not in self._header:
            return {}
        column = self._header.index("name")
        named = ((row[column].strip(), (n, row)) for n, row in self._rows if len(row) > column)
        return {name: row for name, row in named if name}

    def _table(self, line: int, cells: list[str]) -> Mapping:
        """Return a row as a table of the cells that are filled; columns count from 1."""
        entries: dict[str, tuple[Scalar, Node]] = {}
        for k, (name, cell) in enumerate(zip(self._header, cells, strict=False), 1):
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
        if "name" not in self._header:
            message = "the first line must name the columns, and one of them is name"
            Here(Mapping(1, 1), "", reading).note(message)
            return
        for k, column in enumerate(self._header):
            here = Here(Mapping(1, k + 1), column, reading)
            if column not in TABLES[self.kind].keys():  # noqa: SIM118
                here.note("unknown column", nearest(column, TABLES[self.kind].keys()))
            elif column in self._header[:k]:
                here.note("this column stands here twice")
        lines: dict[str, int] = {}
        for line, cells in self._rows:
            row = self._table(line, cells)
            if any(c.strip() for c in cells[len(self._header) :]):
                message = f"this row has {len(cells)} cells, the header {len(self._header)}"
                hint = "write a decimal point, and put text with a comma in quotes"
                Here(row, "", reading).note(message, hint)
            if len(lines) >= ROWS:
                Here(row, "", reading).note(f"a catalogue may have up to {ROWS} rows")
                return
            if "name" not in row.entries:
                Here(row, "", reading).note("this row has no name")
                continue
            name = cells[self._header.index("name")].strip()
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

    def _sheets(self, kind: Kind) -> Iterator[Sheet]:
        yield from (s for s in self.own if s.kind == kind)
        yield shipped(kind)

    def names(self, kind: Kind) -> list[str]:
        """Return every name of a kind of part, the user's own first."""
        return [name for sheet in self._sheets(kind) for name in sheet.rows]

    def find(self, name: str, kind: Kind, here: Here | None = None) -> Any:
        """Return the part of that name, for a place in a file where it stands.

        Case, spaces and zeros behind a point do not matter: `3.5x0.12in` is `3.500x0.120in`.

        Raises
        ------
        DesignError
            If no catalogue has it; the message names what comes nearest.
        """
        here = here or Here(Scalar(name, 0, 0), name, Reading(self))
        for sheet in self._sheets(kind):
            if name in sheet.rows:
                return sheet.part(name, here)
        for sheet in self._sheets(kind):
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
    bare = re.sub(r"^(tube|joint|material|detail)\b|[\s_]", "", name.casefold())
    return re.sub(r"\d+\.\d+", lambda found: f"{float(found[0]):g}", bare)


@cache
def shipped(kind: Kind) -> Sheet:
    """Return the sheet of a kind of part that comes with this package."""
    path = Path(__file__).with_name("catalogues") / f"{kind}s.csv"
    return Sheet(path.read_text(encoding="utf-8"), path.name)


def find(name: str, kind: Kind) -> Any:
    """Return a shipped part: `find("3.5x0.12in", "tube")`."""
    return Catalogue().find(name, kind)
