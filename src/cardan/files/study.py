"""A study in an application's file, or in one beside it: what varies, what scatters, what is asked.

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

from cardan.base.errors import BadFile
from cardan.border.document import Mapping, parse, text_of
from cardan.border.table import (
    Choice,
    Enough,
    Here,
    ListOf,
    MapOf,
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
)  # fmt: skip
from cardan.model.application import Application
from cardan.model.movable import first, meant, movable
from cardan.model.variants import MOST, Ask, Goal, Spread, Variants, crossed
from cardan.quantity.quantities import ANSWERED

VARYING, LEVELS, WORST = 200, 200, 1000
"""Names that vary, places of a grid, and worst variants that are kept, at most."""

BRED = 1_000_000
"""Variants that are bred, at most."""

_ANY = Number()
_SHARE = Number(above=0, below=1)


class ToleranceTable(Table):
    """How a number scatters about what it is meant to be, in the unit of its key."""

    fixed = True
    one_of = (("normal", "uniform"),)

    normal: Annotated[float, Number(above=0)] | None = key(
        "standard deviation about the number as it is", default=None
    )
    uniform: Annotated[float, Number(above=0)] | None = key(
        "half width about the number as it is", default=None
    )

    def build(self) -> Spread:
        """Return the spread."""
        if self.normal is not None:
            return Spread(kind="normal", values=(self.normal,))
        assert self.uniform is not None  # one of them is there
        return Spread(kind="uniform", values=(self.uniform,))


class SpreadTable(ToleranceTable):
    """How a number varies, in the unit of its key; [lowest, highest] is a range of it."""

    one_of = (("choice", "grid", "normal", "uniform"),)

    choice: Annotated[tuple[float, ...], ListOf(_ANY, least=1, most=LEVELS)] | None = key(
        "one of these, by chance", default=None
    )
    grid: Annotated[tuple[float, ...], ListOf(_ANY, "lowest", "highest", "how many")] | None = key(
        "places at equal steps, crossed with every other grid", default=None
    )

    def build(self) -> Spread:
        """Return the spread."""
        if self.choice is not None:
            return Spread(kind="choice", values=self.choice)
        if self.grid is not None:
            low, high, count = self.grid
            if not low < high or not 2 <= count <= LEVELS or count != int(count):
                got = f"[{low:g}, {high:g}, {count:g}]"
                self.at("grid").refuse(
                    f"must be [lowest, highest, how many], of 2 to {LEVELS}", got=got
                )
            return Spread(kind="grid", values=tuple(np.linspace(low, high, int(count)).tolist()))
        return super().build()


class RangeRule(ListOf):
    """A range of a number."""

    def __init__(self) -> None:
        super().__init__(_ANY, "lowest", "highest")

    def read(self, here: Here) -> Spread:
        """Return it."""
        low, high = super().read(here)
        if not low < high:
            here.refuse("must rise", "put the lowest first", got=f"[{low:g}, {high:g}]")
        return Spread(kind="range", values=(low, high))


class CorrelatedTable(Table):
    """Tolerances that go together: made on one fixture, or measured from one face."""

    fixed = True

    between: Annotated[tuple[str, ...], ListOf(Text(), "one", "other")] = key("their names")
    correlation: Annotated[float, Number(above=-1, below=1)] = key("from -1 to 1")

    def build(self) -> tuple[str, str, float]:
        """Return the pair."""
        one, other = self.between
        if one == other and "[*]" not in one:
            self.at("between").refuse("names the same number twice", got=one)
        return one, other, self.correlation


class AskTable(Table):
    """What is asked of all variants, beside how many come to each verdict."""

    fixed = True

    yield_: bool = key("the share that may be built, with its interval", default=True)
    confidence: Annotated[float, _SHARE] = key("of the interval", default=0.95)
    quantiles: Annotated[tuple[float, ...], ListOf(_SHARE, most=20)] = key(
        "of each limit's value and margin", default=()
    )
    worst: Annotated[int, Whole(WORST)] = key("how many of the worst are told", default=3)
    sobol: bool = key("which input the variance comes from", default=False)
    pareto: Annotated[
        tuple[Goal, ...], ListOf(Choice("margin", "cost", "mass"), least=2, most=3)
    ] = key("what is weighed against each other", default=())
    search: Annotated[int, Whole(BRED)] = key(
        "variants bred for pareto from the best, beside those drawn", default=0
    )
    maps: Annotated[
        tuple[tuple[str, str], ...], ListOf(ListOf(Text(), "across", "up"), most=10)
    ] = key("the yield over two of the names", default=())
    limits: Annotated[tuple[str, ...], ListOf(Choice(*ANSWERED), least=1)] = key(
        "quantities whose limits count; all by default, and fewer are faster", default=()
    )
    rare: bool = key("how often limits fail that hardly ever do", default=False)
    foretold: Annotated[int, Whole(MOST)] = key(
        "variants foretold from those asked: the yield to a narrower interval", default=0
    )
    rows: Literal["float32", "float64"] | None = key(
        "keep each variant, in this precision", default=None
    )

    def build(self) -> Ask:
        """Return what is asked."""
        if self.search and not self.pareto:
            self.at("search").refuse("needs pareto", "say there what is weighed")
        for k, goal in enumerate(self.pareto):
            if goal in self.pareto[:k]:
                # Against itself nothing is weighed.
                self.at("pareto", k + 1).refuse("is weighed already", "name each once", got=goal)
        return Ask(
            yield_=self.yield_, confidence=self.confidence, quantiles=tuple(sorted(self.quantiles)),
            worst=self.worst, sobol=self.sobol, pareto=self.pareto, maps=self.maps, rows=self.rows,
            limits=self.limits, rare=self.rare, search=self.search, foretold=self.foretold,
        )  # fmt: skip


_VARY = MapOf(Text(), OneOf(RangeRule(), TableRule(SpreadTable)), most=VARYING)
_TOLERANCES = MapOf(Text(), TableRule(ToleranceTable), most=VARYING)


class StudyTable(Table):
    """A study of variants: numbers by their addresses, moves by their keys in `adjust`."""

    fixed = True

    vary: Annotated[dict[str, Spread], _VARY] = key("what is chosen", default={})
    tolerances: Annotated[dict[str, Spread], _TOLERANCES] = key(
        "what scatters about what is chosen", default={}
    )
    correlated: Annotated[
        tuple[tuple[str, str, float], ...],
        ListOf(TableRule(CorrelatedTable), most=VARYING),
    ] = key("tolerances that go together", default=())
    ask: Annotated[Ask, AskTable] = key("beside the verdicts", default=Ask())

    def variants(self, known: Iterable[str]) -> Variants:
        """Return the study; refuse names that none of the known ones goes by."""
        every = list(known)
        if not (self.vary or self.tolerances):
            self.at().refuse("needs vary or tolerances")
        named = set[str]()
        for entry in ("vary", "tolerances"):
            whose: dict[str, str] = {}
            for name in getattr(self, entry):
                found = meant(name, every)
                named |= {name, *found}
                if twice := next((one for one in found if one in whose), ""):
                    both = f"{twice} goes by {whose[twice]} too"
                    self._named(entry, name).note(both, "name each number once")
                whose.update((one, name) for one in found)
                if not found:
                    hint = nearest(name.replace("*", "1"), every)
                    self._named(entry, name).note("no number has this address", hint)
        gone = {} if self.ask.sobol else self.vary  # whose pairs take places by chance
        try:
            crossed(s for n, s in gone.items() for _ in meant(n, every) if s.kind == "grid")
        except ValueError as error:
            self.at("vary").note(str(error), "give fewer places, or a range")
        scatter = [n for t in self.tolerances for n in meant(t, every)]
        tied = set[frozenset[str]]()
        for k, (*pair, _) in enumerate(self.correlated, 1):
            for name in pair:
                if not any(name in (t, *meant(t, every)) for t in self.tolerances):
                    hint = nearest(name, self.tolerances)
                    self.at("correlated", k).note("there is no such tolerance", hint, got=name)
            now = {frozenset(p) for p in product(*(meant(n, scatter) for n in pair))}
            if twice := next((p for p in now & tied if len(p) > 1), None):
                both = " and ".join(sorted(twice))
                self.at("correlated", k).note(f"{both} have a correlation already", "keep one")
            tied |= now
        if self.ask.search and self.tolerances:
            self.at("ask").note("search: breeds what vary chooses", "ask it without tolerances")
        if self.ask.rare and not self.tolerances:
            self.at("ask").note("rare: needs tolerances", "say there what scatters, and how far")
        drawn = self.tolerances and not self.ask.sobol
        if self.ask.foretold and (not drawn or any(s.kind == "grid" for s in self.vary.values())):
            self.at("ask").note(
                "foretold: needs tolerances, drawn by dice", "ask it without sobol and grids"
            )
        for pair in self.ask.maps:
            for name in pair:
                if name not in named:
                    self.at("ask").note("maps: this does not vary", nearest(name, named), got=name)
            # Of several parts a map shows the first.
            firsts = [first(name, every) for name in pair if meant(name, every)]
            if len(firsts) > len(set(firsts)):
                self.at("ask").note(
                    "maps: both axes are the same number", "name two", got=", ".join(pair)
                )
        return Variants(
            vary=self.vary, tolerances=self.tolerances, correlated=self.correlated, ask=self.ask,
            places={name: self._named("vary", name).place for name in self.vary}
            | {name: self.at(name).place for name in ("ask", "correlated")},
        )  # fmt: skip

    def _named(self, entry: str, name: str) -> Here:
        """Return the place of a name in an entry."""
        here, used = self._place
        written, node = used[entry]
        assert isinstance(node, Mapping)
        at = next(k for k, _ in node.entries.values() if k.text.strip() == name)
        return here.inside(node, written.text).inside(at, name)


def schema() -> dict[str, Any]:
    """Return the JSON Schema (draft 2020-12) of a study in a file beside the application's."""
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


def known(application: Application) -> list[str]:
    """Return every name that may vary: addresses of numbers, and what can be moved."""
    written = application.written
    numbers = () if written is None else (*written.numbers, *written.single)
    return [*of_numbers(numbers), *movable(i.line for i in application.lines)]


def of_numbers(addresses: Iterable[str]) -> list[str]:
    """Return the addresses without those of a study, which varies others but not itself."""
    return [at for at in addresses if not at.startswith("study.")]


def read(path: Path, application: Application) -> Variants:
    """Return the study of a file beside the application's.

    Raises
    ------
    BadFile
        With everything wrong in it, by line and column.
    """
    root, problems = parse(text_of(path), str(path))
    reading = Reading(folder=path.parent, problems=problems)
    here = Here(root, "", reading)
    found: Any = None
    if isinstance(root, Mapping) and list(root.entries) == ["study"]:
        here = here.inside(root.entries["study"][1], "study")
    try:
        found = StudyTable.read(here).variants(known(application))
    except (Spoilt, Enough):
        raise BadFile(str(path), tuple(problems)) from None
    if problems:
        raise BadFile(str(path), tuple(problems))
    return replace(found, file=str(path))
