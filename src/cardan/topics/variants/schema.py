"""A study, in an application's file or its own: what varies, what scatters, what is computed.

    study:
      vary:       {"shim_deg": [-2, 2], "phase_deg[2]": {choice: [0, 90]}}
      tolerances: {"bearing_height_mm[*]": {normal: 1.0}, "axle.ratio": {uniform: 0.01}}
      ask:        {quantiles: [0.05, 0.95], sobol: true, maps: [["shim_deg", "axle.ratio"]]}

Numbers go by their addresses, in the units of their keys; what a workshop can move goes by its
key in `adjust`.
"""

from collections.abc import Iterable
from dataclasses import replace
from itertools import product
from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np

from cardan.checks.quantities.registry import LINE_QUANTITIES
from cardan.core.errors import InvalidFileError
from cardan.model.adjustments import (
    first_known_name_matching_pattern,
    known_names_matching_pattern,
    permitted_adjustments_by_name,
)
from cardan.model.application import Application
from cardan.model.variants import (
    MAX_VARIANTS,
    ParetoObjective,
    VariantOutputs,
    VariantStudy,
    VariedNumber,
    grid_point_count,
    without_addresses_of_study_section,
)
from cardan.schema.field_types import (
    EnumField,
    IntegerField,
    ListField,
    MappingField,
    NumberField,
    TextField,
    UnionField,
)
from cardan.schema.node_reader import (
    InvalidValueError,
    NodeReader,
    TableReadContext,
    TooManyIssuesError,
    nearest_name_hint,
)
from cardan.schema.tables import Table, TableField, table_key_field
from cardan.schema.yaml_tree import Mapping, parse_yaml, read_text

MAX_VARYING_NAMES, MAX_GRID_LEVELS, MAX_WORST_VARIANTS = 200, 200, 1000
"""Names that vary, places of a grid, and worst variants that are kept, at most."""

MAX_EVOLVED_VARIANTS = 1_000_000
"""Variants that are bred, at most."""

_ANY = NumberField()
_SHARE = NumberField(above=0, below=1)


class ToleranceTable(Table):
    """How a number scatters about what it is meant to be, in the unit of its key."""

    fixed = True
    one_of = (("normal", "uniform"),)

    normal: Annotated[float, NumberField(above=0)] | None = table_key_field(
        "standard deviation about the number as it is", default=None
    )
    uniform: Annotated[float, NumberField(above=0)] | None = table_key_field(
        "half width about the number as it is", default=None
    )

    def build(self) -> VariedNumber:
        """Return the spread."""
        if self.normal is not None:
            return VariedNumber(kind="normal", values=(self.normal,))
        assert self.uniform is not None  # one of them is there
        return VariedNumber(kind="uniform", values=(self.uniform,))


class SpreadTable(ToleranceTable):
    """How a number varies, in the unit of its key; [lowest, highest] is a range of it."""

    one_of = (("choice", "grid", "normal", "uniform"),)

    choice: Annotated[tuple[float, ...], ListField(_ANY, least=1, most=MAX_GRID_LEVELS)] | None = (
        table_key_field("one of these, by chance", default=None)
    )
    grid: Annotated[tuple[float, ...], ListField(_ANY, "lowest", "highest", "how many")] | None = (
        table_key_field("places at equal steps, crossed with every other grid", default=None)
    )

    def build(self) -> VariedNumber:
        """Return the spread."""
        if self.choice is not None:
            return VariedNumber(kind="choice", values=self.choice)
        if self.grid is not None:
            low, high, count = self.grid
            if not low < high or not 2 <= count <= MAX_GRID_LEVELS or count != int(count):
                got = f"[{low:g}, {high:g}, {count:g}]"
                self.reader_of("grid").reject(
                    f"must be [lowest, highest, how many], of 2 to {MAX_GRID_LEVELS}", got=got
                )
            return VariedNumber(
                kind="grid", values=tuple(np.linspace(low, high, int(count)).tolist())
            )
        return super().build()


class RangeField(ListField):
    """A range of a number."""

    def __init__(self) -> None:
        super().__init__(_ANY, "lowest", "highest")

    def read(self, here: NodeReader) -> VariedNumber:
        """Return it."""
        low, high = super().read(here)
        if not low < high:
            here.reject("must rise", "put the lowest first", got=f"[{low:g}, {high:g}]")
        return VariedNumber(kind="range", values=(low, high))


class CorrelationTable(Table):
    """Tolerances that go together: made on one fixture, or measured from one face."""

    fixed = True

    between: Annotated[tuple[str, ...], ListField(TextField(), "one", "other")] = table_key_field(
        "their names"
    )
    correlation: Annotated[float, NumberField(above=-1, below=1)] = table_key_field("from -1 to 1")

    def build(self) -> tuple[str, str, float]:
        """Return the pair."""
        one, other = self.between
        if one == other and "[*]" not in one:
            self.reader_of("between").reject("names the same number twice", got=one)
        return one, other, self.correlation


class RequestedStatisticsTable(Table):
    """What is computed of all variants, in addition to how many come to each verdict."""

    fixed = True

    yield_: bool = table_key_field("the share that may be built, with its interval", default=True)
    yield_only: bool = table_key_field(
        "nothing else: what fails without rubber is not evaluated on rubber, which is faster",
        default=False,
    )
    confidence: Annotated[float, _SHARE] = table_key_field("of the interval", default=0.95)
    quantiles: Annotated[tuple[float, ...], ListField(_SHARE, most=20)] = table_key_field(
        "of each limit's value and margin", default=()
    )
    worst: Annotated[int, IntegerField(MAX_WORST_VARIANTS)] = table_key_field(
        "how many of the worst are told", default=3
    )
    sobol: bool = table_key_field("which input the variance comes from", default=False)
    pareto: Annotated[
        tuple[ParetoObjective, ...], ListField(EnumField("margin", "cost", "mass"), least=2, most=3)
    ] = table_key_field("what is weighed against each other", default=())
    search: Annotated[int, IntegerField(MAX_EVOLVED_VARIANTS)] = table_key_field(
        "variants bred for pareto from the best, beside those drawn", default=0
    )
    maps: Annotated[
        tuple[tuple[str, str], ...], ListField(ListField(TextField(), "across", "up"), most=10)
    ] = table_key_field("the yield over two of the names", default=())
    limits: Annotated[tuple[str, ...], ListField(EnumField(*LINE_QUANTITIES), least=1)] = (
        table_key_field(
            "quantities whose limits count; all by default, and fewer are faster", default=()
        )
    )
    rare: bool = table_key_field("how often limits fail that hardly ever do", default=False)
    foretold: Annotated[int, IntegerField(MAX_VARIANTS)] = table_key_field(
        "variants foretold from those asked: the yield to a narrower interval", default=0
    )
    rows: Literal["float32", "float64"] | None = table_key_field(
        "keep each variant, in this precision", default=None
    )

    def build(self) -> VariantOutputs:
        """Return what is computed."""
        if self.search and not self.pareto:
            self.reader_of("search").reject("needs pareto", "say there what is weighed")
        asked: dict[str, Any] = {
            "yield_": self.yield_, "quantiles": tuple(sorted(self.quantiles)), "sobol": self.sobol,
            "pareto": self.pareto, "maps": self.maps, "rare": self.rare, "foretold": self.foretold,
            "rows": self.rows,
        }  # fmt: skip
        for k, goal in enumerate(self.pareto):
            if goal in self.pareto[:k]:
                # Against itself nothing is weighed.
                self.reader_of("pareto", k + 1).reject(
                    "is weighed already", "name each once", got=goal
                )
        if self.yield_only and (others := VariantOutputs(**asked).excluded_by_yield_only):
            self.reader_of("yield_only").reject(
                "reports nothing but the yield", f"remove {', '.join(others)}"
            )
        return VariantOutputs(
            **asked, yield_only=self.yield_only, confidence=self.confidence, worst=self.worst,
            limits=self.limits, search=self.search,
        )  # fmt: skip


_VARY = MappingField(
    TextField(), UnionField(RangeField(), TableField(SpreadTable)), most=MAX_VARYING_NAMES
)
_TOLERANCES = MappingField(TextField(), TableField(ToleranceTable), most=MAX_VARYING_NAMES)


class StudyTable(Table):
    """A study of variants: numbers by their addresses, moves by their keys in `adjust`."""

    fixed = True

    vary: Annotated[dict[str, VariedNumber], _VARY] = table_key_field("what is chosen", default={})
    tolerances: Annotated[dict[str, VariedNumber], _TOLERANCES] = table_key_field(
        "what scatters about what is chosen", default={}
    )
    correlated: Annotated[
        tuple[tuple[str, str, float], ...],
        ListField(TableField(CorrelationTable), most=MAX_VARYING_NAMES),
    ] = table_key_field("tolerances that go together", default=())
    ask: Annotated[VariantOutputs, RequestedStatisticsTable] = table_key_field(
        "beside the verdicts", default=VariantOutputs()
    )

    def variants(self, known: Iterable[str]) -> VariantStudy:
        """Return the study; refuse names that none of the known ones goes by."""
        every = list(known)
        if not (self.vary or self.tolerances):
            self.reader_of().reject("needs vary or tolerances")
        named = set[str]()
        for entry in ("vary", "tolerances"):
            whose: dict[str, str] = {}
            for name in getattr(self, entry):
                found = known_names_matching_pattern(name, every)
                named |= {name, *found}
                if twice := next((one for one in found if one in whose), ""):
                    both = f"{twice} goes by {whose[twice]} too"
                    self._named(entry, name).add_issue(both, "name each number once")
                whose.update((one, name) for one in found)
                if not found:
                    hint = nearest_name_hint(name.replace("*", "1"), every)
                    self._named(entry, name).add_issue("no number has this address", hint)
        gone = {} if self.ask.sobol else self.vary  # whose pairs take places by chance
        try:
            grid_point_count(
                s
                for n, s in gone.items()
                for _ in known_names_matching_pattern(n, every)
                if s.kind == "grid"
            )
        except ValueError as error:
            self.reader_of("vary").add_issue(str(error), "give fewer places, or a range")
        scatter = [n for t in self.tolerances for n in known_names_matching_pattern(t, every)]
        tied = set[frozenset[str]]()
        for k, (*pair, _) in enumerate(self.correlated, 1):
            for name in pair:
                if not any(
                    name in (t, *known_names_matching_pattern(t, every)) for t in self.tolerances
                ):
                    hint = nearest_name_hint(name, self.tolerances)
                    self.reader_of("correlated", k).add_issue(
                        "there is no such tolerance", hint, got=name
                    )
            now = {
                frozenset(p)
                for p in product(*(known_names_matching_pattern(n, scatter) for n in pair))
            }
            if twice := next((p for p in now & tied if len(p) > 1), None):
                both = " and ".join(sorted(twice))
                self.reader_of("correlated", k).add_issue(
                    f"{both} have a correlation already", "keep one"
                )
            tied |= now
        if self.ask.search and self.tolerances:
            self.reader_of("ask").add_issue("search: breeds what vary chooses", "remove tolerances")
        if self.ask.rare and not self.tolerances:
            self.reader_of("ask").add_issue(
                "rare: needs tolerances", "say there what scatters, and how far"
            )
        drawn = self.tolerances and not self.ask.sobol
        if self.ask.foretold and (not drawn or any(s.kind == "grid" for s in self.vary.values())):
            self.reader_of("ask").add_issue(
                "`foretold` needs tolerances and Monte Carlo sampling", "remove sobol and grids"
            )
        for pair in self.ask.maps:
            for name in pair:
                if name not in named:
                    self.reader_of("ask").add_issue(
                        "maps: this does not vary", nearest_name_hint(name, named), got=name
                    )
            # Of several parts a map shows the first.
            firsts = [
                first_known_name_matching_pattern(name, every)
                for name in pair
                if known_names_matching_pattern(name, every)
            ]
            if len(firsts) > len(set(firsts)):
                self.reader_of("ask").add_issue(
                    "maps: both axes are the same number", "name two", got=", ".join(pair)
                )
        return VariantStudy(
            vary=self.vary, tolerances=self.tolerances, correlated=self.correlated, ask=self.ask,
            places={name: self._named("vary", name).position for name in self.vary}
            | {name: self.reader_of(name).position for name in ("ask", "correlated")},
        )  # fmt: skip

    def _named(self, entry: str, name: str) -> NodeReader:
        """Return the place of a name in an entry."""
        here, used = self._place
        written, node = used[entry]
        assert isinstance(node, Mapping)
        at = next(k for k, _ in node.entries.values() if k.text.strip() == name)
        return here.child(node, written.text).child(at, name)


def variant_study_json_schema() -> dict[str, Any]:
    """Return the JSON Schema (draft 2020-12) of a study in a file of its own."""
    defs: dict[str, Any] = {}
    study = StudyTable.schema(defs)
    under: dict[str, Any] = {
        "type": "object", "properties": {"study": study}, "required": ["study"],
        "additionalProperties": False,
    }  # fmt: skip
    return {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "title": "cardan study",
        "anyOf": [study, under],
        "$defs": dict(sorted(defs.items())),
    }


def variable_names(application: Application) -> list[str]:
    """Return every name that may vary: addresses of numbers, and what can be moved."""
    written = application.written
    numbers = () if written is None else (*written.numbers, *written.fixed_numbers)
    return [
        *without_addresses_of_study_section(numbers),
        *permitted_adjustments_by_name(i.line for i in application.lines),
    ]


def read_variant_study(path: Path, application: Application) -> VariantStudy:
    """Return the study of a file of its own.

    Raises
    ------
    InvalidFileError
        With everything wrong in it, by line and column.
    """
    root, problems = parse_yaml(read_text(path), str(path))
    reading = TableReadContext(folder=path.parent, problems=problems)
    here = NodeReader(root, "", reading)
    found: Any = None
    if isinstance(root, Mapping) and list(root.entries) == ["study"]:
        here = here.child(root.entries["study"][1], "study")
    try:
        found = StudyTable.read(here).variants(variable_names(application))
    except (InvalidValueError, TooManyIssuesError):
        raise InvalidFileError(str(path), tuple(problems)) from None
    if problems:
        raise InvalidFileError(str(path), tuple(problems))
    return replace(found, file=str(path))
