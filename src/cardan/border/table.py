"""Tables of a file, declared once: what each key may hold and what the table becomes.

A table is a class whose annotations say how its entries are read:

    class TubeTable(Table):
        outer: Size = key("outside diameter")
        wall: Size = key("wall thickness")

        def build(self) -> Tube:
            return Tube(outer=self.outer, wall=self.wall)

`Size` is a float measured in mm, m or inches, so the file's key is `outer_mm`, `outer_m` or
`outer_in`, one of them; inside it is SI. From the same declaration come the reader, its
errors with line, column and advice, and the JSON Schema that editors use. An annotation
`Annotated[Tube, TubeTable]` is a nested table that has become a tube by the time the outer
table is built, so every part is tried by itself and a file's errors are found all at once.

Annotations understood: float, int, str, bool, Literal, tuple, dict, tables, unions told
apart by how YAML writes them, None for a key that may be left out, and Annotated with a
`Rule` or a table.
"""

import re
import types
from collections.abc import Callable, Iterable
from collections.abc import Mapping as Mapped
from dataclasses import field, replace
from functools import cache, cached_property
from importlib import import_module
from math import pi
from pathlib import Path
from typing import (
    Annotated,
    Any,
    ClassVar,
    Literal,
    NoReturn,
    TypeAlias,
    TypeVar,
    Union,
    cast,
    dataclass_transform,
    get_args,
    get_origin,
)
from unicodedata import normalize

import numpy as np

from cardan.base.arrays import ArrayLike
from cardan.base.errors import DesignError, Place, Problem, failing
from cardan.base.frozen import dataclass
from cardan.base.units import UNITS
from cardan.base.units import g as G  # noqa: N812  as books have it
from cardan.border.document import Changed, Mapping, Node, Scalar, Sequence, number, one_line

T = TypeVar("T")
Schema: TypeAlias = dict[str, Any]

LARGE = 1e12
"""No number of a driveline is larger, in any unit; sums and products stay finite."""

MANY = 100
"""Problems in a file before reading it further helps nobody."""

NAME, PROSE = 200, 2000
"""Characters of a name, which must fit a line of a table; and of a note or a source."""

ITEMS, NAMES = 2000, 100
"""Items of a list, entries of a table of names, where nothing else is said."""


class Enough(Exception):  # noqa: N818  not an error of its own
    """So much is wrong that the rest need not be read."""


class Spoilt(Exception):  # noqa: N818  not an error of its own
    """Something read so far is wrong and noted: what was to be made of it cannot be."""


Stamp: TypeAlias = tuple[int, int, int]
"""When a file was last changed, its length, and which it is: another where the file is."""


def stamp(path: Path) -> Stamp:
    """Return what tells a file from what it was before, without reading it."""
    try:
        status = path.stat()
    except (OSError, ValueError):
        return 0, -1, 0
    return status.st_mtime_ns, status.st_size, status.st_ino


@dataclass(frozen=True)
class Beside:
    """A file that another names: at which key, under what name, and as it was before it was read.

    `name` is None where it is not named by this text, but by a file that it names.
    """

    at: str
    name: str | None
    path: Path
    stamp: Stamp

    @property
    def same(self) -> bool:
        """Return whether the file is still what it was."""
        return stamp(self.path) == self.stamp

    def stands(self, at: str) -> bool:
        """Return whether it is named at an address, or in a list there."""
        return at == self.at or at.startswith(f"{self.at}[")


@dataclass
class Reading:
    """What comes up while a file is read, and where the names in it are looked up.

    `changes` are numbers in place of the file's, by address; `numbers` is what was read at
    each address where variants may stand, `fixed` where only one number may.
    """

    catalogue: Any = None
    folder: Path | None = None
    allow_outside: bool = False
    """Whether files named in this one may lie outside its folder."""
    problems: list[Problem] = field(default_factory=list[Problem])
    warnings: list[Problem] = field(default_factory=list[Problem])
    changes: Mapped[str, ArrayLike] = field(default_factory=dict[str, ArrayLike])
    numbers: dict[str, ArrayLike] = field(default_factory=dict[str, ArrayLike])
    fixed: dict[str, ArrayLike] = field(default_factory=dict[str, ArrayLike])
    places: dict[str, Place] = field(default_factory=dict[str, Place])
    """Where everything that was read stands, by its key."""
    beside: list[Beside] = field(default_factory=list[Beside])
    """Files that this one names."""


@dataclass
class Here:
    """A place in the file: a node, the key that leads to it and the unit that key names.

    `fixed` says that what stands here is no part of the design: it has no variants.
    """

    node: Node
    at: str
    reading: Reading
    unit: str = ""
    fixed: bool = False

    def inside(self, node: Node, name: str, unit: str | None = None) -> "Here":
        """Return the place of an entry of this table."""
        at = f"{self.at}.{name}" if self.at else name
        return Here(node, at, self.reading, self.unit if unit is None else unit, self.fixed)

    def item(self, node: Node, place: int) -> "Here":
        """Return the place of an item of this list; places count from 1."""
        return Here(node, f"{self.at}[{place}]", self.reading, self.unit, self.fixed)

    def number(self) -> tuple[float | None, str]:
        """Return the number that stands here, or None with a hint on how to write one.

        Kept under its address, and changed where a change asks for that: then it may be
        an array of variants, (V, 1).
        """
        if not isinstance(self.node, Scalar):
            return None, ""
        if self.at in self.reading.changes:
            to: Any = self.reading.changes[self.at]
            spread = f"{np.min(to):g}" if np.ndim(to) == 0 else f"{np.min(to):g} ... {np.max(to):g}"
            self.node = Changed(spread, self.node.line, self.node.column, number=to)
            if self.fixed and np.ndim(to):
                self.refuse("is no part of the design: give it one number")
        value, hint = number(self.node)
        if value is not None:
            (self.reading.fixed if self.fixed else self.reading.numbers)[self.at] = value
        return value, hint

    def beside(self, name: str) -> Path:
        """Return the path of a file named in this one, which must lie in its folder."""
        folder = self.reading.folder
        if folder is None:
            self.refuse("a text by itself has no files beside it", got=name)
        path = folder / name
        try:
            inside = path.resolve().is_relative_to(folder.resolve())
        except (OSError, RuntimeError, ValueError):  # links in a circle; no name of a file
            self.refuse("no file can be found under this name", got=name)
        if not (inside or self.reading.allow_outside):
            message = f"lies outside the folder of this file, {folder.resolve()}"
            self.refuse(message, "put it beside this file, or say --allow-outside", got=name)
        self.reading.beside.append(Beside(self.at, name, path, stamp(path)))
        return path

    def keep(self, written: Node | None = None) -> None:
        """Keep where this stands: a number where it is, a list or a table at its key."""
        node = self.node if written is None or isinstance(self.node, Scalar) else written
        self.reading.places[self.at] = Place(key=self.at, line=node.line, column=node.column)

    @property
    def place(self) -> tuple[int, int]:
        """Its line and column."""
        return self.node.line, self.node.column

    def note(self, message: str, hint: str = "", *, got: str = "") -> None:
        """Note what is wrong here, and go on."""
        self.reading.problems.append(self._problem(message, hint, got))
        if len(self.reading.problems) >= MANY:
            raise Enough

    def refuse(self, message: str, hint: str = "", *, got: str = "") -> NoReturn:
        """Note what is wrong here, and give up what was to be read."""
        self.note(message, hint, got=got)
        raise Spoilt

    def warn(self, message: str, hint: str = "") -> None:
        """Note what looks wrong here but can be read."""
        self.reading.warnings.append(self._problem(message, hint, ""))

    def _problem(self, message: str, hint: str, got: str) -> Problem:
        message, key, value, hint = map(one_line, (message, self.at, got, hint))
        line, column = self.node.line, self.node.column
        return Problem(message=message, key=key, value=value, hint=hint, line=line, column=column)


def nearest(name: str, names: Iterable[str]) -> str:
    """Return advice on a name nobody knows: the nearest known one, or all there are."""
    return _meant(name, names)[1]


def _meant(name: str, names: Iterable[str]) -> tuple[str, str]:
    from difflib import get_close_matches  # needed in bad files alone

    folded = {n.casefold(): n for n in names}
    if close := get_close_matches(name.casefold(), list(folded), n=1, cutoff=0.6):
        found = folded[close[0]]
        return found, f"did you mean {found}?"
    known = list(folded.values())
    more = f" and {len(known) - 20} more" if len(known) > 20 else ""
    return "", f"there are: {', '.join(known[:20])}{more}" if known else "there are none"


def each(tries: Iterable[Callable[[], T]]) -> list[T]:
    """Return the results of all tries; if one is spoilt, only after the last was made."""
    results: list[T] = []
    spoilt = False
    for attempt in tries:
        try:
            results.append(attempt())
        except Spoilt:
            spoilt = True
    if spoilt:
        raise Spoilt
    return results


# --- rules: how one entry is read ---------------------------------------------------------


class Rule:
    """How one kind of entry is read, and how errors and the schema describe it."""

    one: str = "a value"
    many: str = "values"
    takes: tuple[type[Node], ...] = (Scalar,)
    units: dict[str, float] = {}  # noqa: RUF012  SI values of the units a key may end in
    usual: tuple[float, float] | None = None
    """Magnitudes (SI) nobody wonders at; outside them a unit may be wrong."""
    json: Schema = {}  # noqa: RUF012  read only

    def read(self, here: Here) -> Any:
        """Return what a node means, or note what is wrong and raise `Spoilt`."""
        raise NotImplementedError

    def schema(self, defs: Schema, unit: str) -> Schema:  # noqa: ARG002  for rules with parts
        """Return the JSON Schema of a node; `defs` collects the tables in it."""
        return self.json

    def refuse(self, here: Here, hint: str = "") -> NoReturn:
        """Note that a node is not what this rule reads, and give it up."""
        if isinstance(here.node, Scalar) and here.node.value is None:
            here.refuse(f"has no value; it must be {self.one}")
        here.refuse(f"must be {self.one}", hint, got=here.node.brief)


_OTHER_UNITS: dict[str, dict[str, float]] = {
    "mm": {"cm": 1e-2, "ft": 0.3048},
    "rpm": {"Hz": 2 * pi, "1/s": 2 * pi},
    "Nm": {"kgf m": G, "N mm": 1e-3},
    "N": {"kgf": G},
    "N_mm": {"kgf/mm": G * 1e3, "N/cm": 100.0},
    "kg": {"g": 1e-3},
    "kg_m3": {"g/cm3": 1e3},
    "MPa": {"Pa": 1.0, "kgf/mm2": G * 1e6},
    "deg_mm": {"deg/m": pi / 180},
}
"""Units that people measure in and no key ends in, by one that keys do end in."""


class Number(Rule):
    """A finite number, in one of some units or in none; bounds are SI."""

    def __init__(
        self,
        *units: str,
        worth: dict[str, float] | None = None,
        above: float | None = None,
        least: float | None = None,
        below: float | None = None,
        most: float | None = None,
        usual: tuple[float, float] | None = None,
    ) -> None:
        self.units = worth or {u: UNITS[u] for u in units}
        self.usual = usual
        self._above, self._least, self._below, self._most = above, least, below, most
        self.one, self.many = f"a number{self._zero}", f"numbers{self._zero}"

    @property
    def _zero(self) -> str:
        """What can be said of the bounds without a unit, which is all where there is none."""
        if not self.units and self._range(1.0):
            return self._range(1.0)
        if self._least == 0:
            return " of 0 or more"
        return " above 0" if max(self._above or 0, self._least or 0) > 0 or self._above == 0 else ""

    def read(self, here: Here) -> float:
        """Return the number in SI."""
        value, hint = here.number()
        if value is None:
            self.refuse(here, hint)
        worth = self.units.get(here.unit, 1.0)
        if not self._within(value * worth):
            message = f"must be a number{self._range(worth)} {here.unit}".rstrip()
            stem = re.sub(rf"(_{here.unit})?(\[\d+\])*$", "", here.at.rpartition(".")[2])
            here.refuse(
                message,
                self.other(float(np.max(np.abs(value))), here.unit, stem),
                got=here.node.brief,
            )
        if failing(abs(value) < LARGE, value):
            here.refuse(f"must be within ±{LARGE:g}", got=here.node.brief)
        return value * worth

    def other(self, written: float, unit: str, stem: str) -> str:
        """Return advice on a number that would be an everyday one in another unit."""
        if self.usual is None or not written:
            return ""
        low, high = self.usual
        own = [u for u, si in self.units.items() if low <= written * si <= high]
        if own:
            return f"did you mean {stem}_{own[0]}?" if unit not in own else ""
        for known, units in _OTHER_UNITS.items():
            for name, si in units.items() if known in self.units else ():
                if low <= written * si <= high:
                    worth = written * si / self.units[unit]
                    return f"is it in {name}? then write {worth:.4g} {unit}"
        inverse = not self.units and low <= 1 / written <= high
        return f"is it the inverse of {1 / written:.4g}?" if inverse else ""

    def _within(self, si: float) -> bool:
        return not (
            (self._above is not None and failing(si > self._above, si))
            or (self._least is not None and failing(si >= self._least, si))
            or (self._below is not None and failing(si < self._below, si))
            or (self._most is not None and failing(si <= self._most, si))
        )

    def _range(self, worth: float) -> str:
        """Return the bounds in words, in a unit worth so much."""
        words = [
            f"{word} {bound / worth:g}"
            for word, bound in (
                ("above", self._above),
                ("at least", self._least),
                ("below", self._below),
                ("at most", self._most),
            )
            if bound is not None
        ]
        of = " of" if self._above is None and self._least is not None else ""
        return f"{of} {' and '.join(words)}" if words else ""

    def schema(self, defs: Schema, unit: str) -> Schema:  # noqa: ARG002  it has no parts
        """Return the schema with the bounds in the key's unit."""
        worth = self.units.get(unit, 1.0)
        bounds = {
            "exclusiveMinimum": self._above,
            "minimum": self._least,
            "exclusiveMaximum": self._below,
            "maximum": self._most,
        }
        return {"type": "number"} | {
            name: float(f"{bound / worth:.12g}")
            for name, bound in bounds.items()
            if bound is not None
        }


class Whole(Rule):
    """A whole number from 1 on, of things there are only so many of.

    From `told` on, people are told; what was once allowed below it is read, for its table to
    warn of.
    """

    def __init__(self, most: int = 1000, *, told: int = 1) -> None:
        self._most = most
        span = f"from {told} to {most}"
        self.one, self.many = f"a whole number {span}", f"whole numbers {span}"
        self.json = {"type": "integer", "minimum": told, "maximum": most}

    def read(self, here: Here) -> int:
        """Return the number."""
        value = here.node.value
        if not isinstance(value, int) or isinstance(value, bool) or not 1 <= value <= self._most:
            self.refuse(here, number(here.node)[1] if isinstance(here.node, Scalar) else "")
        return value


class Text(Rule):
    """A text; a number will do, as it was written: joints are called 1810."""

    one, many = "a text", "texts"

    def __init__(self, most: int = NAME) -> None:
        self._most = most
        self.json = {"type": ["string", "number"], "maxLength": most}

    def read(self, here: Here) -> Any:
        """Return the text."""
        return self.text(here)

    def text(self, here: Here) -> str:
        """Return the text as it was written, on one line."""
        value = here.node.value
        if not isinstance(here.node, Scalar) or value is None or not _seen(here.node.text):
            self.refuse(here)
        if isinstance(value, bool):
            self.refuse(here, "put it in quotes if it is a name")
        text = here.node.text.strip()
        if len(text) > self._most:
            got = f"{len(text)} characters"
            here.refuse(f"may have up to {self._most} characters", "shorten it", got=got)
        return " ".join(text.split()) if "\n" in text or "\t" in text else text


def _seen(text: str) -> bool:
    """Whether a text has anything to read."""
    return any(c.isprintable() and not c.isspace() for c in text)


class Choice(Rule):
    """One of some names."""

    def __init__(self, *names: str) -> None:
        self.names = names
        self.one = self.many = f"one of {', '.join(names)}"
        self.json = {"enum": list(names)}

    def read(self, here: Here) -> Any:
        """Return the name."""
        if not isinstance(here.node, Scalar):
            self.refuse(here)
        if here.node.text not in self.names:
            found, hint = _meant(here.node.text, self.names)
            self.refuse(here, hint if found else "")
        return here.node.text


class Flag(Rule):
    """True or false, in these words."""

    one, many = "true or false", "true or false"
    json: Schema = {"type": "boolean"}  # noqa: RUF012  read only

    def read(self, here: Here) -> bool:
        """Return which of the two."""
        value = here.node.value
        if not isinstance(value, bool):
            said = here.node.text.casefold() if isinstance(here.node, Scalar) else ""
            meant = {"yes": "true", "on": "true", "no": "false", "off": "false"}.get(said)
            self.refuse(here, f"write {meant}" if meant else "")
        return value


class ListOf(Rule):
    """A list; of a fixed length where `names` says what its items are."""

    takes = (Sequence,)

    def __init__(self, of: Rule, *names: str, least: int = 0, most: int = ITEMS) -> None:
        self.of, self.names, self._least, self._most = of, names, least, most
        self.units, self.usual = of.units, of.usual
        count = f"{len(names)} {of.many}, [{', '.join(names)}]" if names else of.many
        self.one, self.many = f"a list of {count}", f"lists of {count}"

    def read(self, here: Here) -> Any:
        """Return what its items mean."""
        if not isinstance(here.node, Sequence):
            self.refuse(here)
        items = here.node.items
        if self.names and len(items) != len(self.names):
            self.refuse(here)
        if len(items) < self._least:
            self.refuse(here, f"give at least {self._least}")
        if len(items) > self._most:
            here.refuse(f"may hold up to {self._most} items", got=f"{len(items)} items")
        places = [here.item(item, k) for k, item in enumerate(items, 1)]
        for place in places:
            place.keep()
        return tuple(each(lambda p=p: self.of.read(p) for p in places))

    def schema(self, defs: Schema, unit: str) -> Schema:
        """Return the schema of the list and its items."""
        size: Schema = {"minItems": self._least} if self._least else {}
        size |= {"maxItems": self._most}
        if self.names:
            size = {"minItems": len(self.names), "maxItems": len(self.names)}
        return {"type": "array", "items": self.of.schema(defs, unit), **size}


class MapOf(Rule):
    """A table whose keys are names the user chooses, or numbers of parts."""

    takes = (Mapping,)

    def __init__(self, key: Rule, of: Rule, *, most: int = NAMES) -> None:
        self.key, self.of, self._most = key, of, most
        self.units, self.usual = of.units, of.usual
        self.one, self.many = f"a table from names to {of.many}", f"tables from names to {of.many}"

    def read(self, here: Here) -> Any:
        """Return what its entries mean, by name."""
        if not isinstance(here.node, Mapping):
            self.refuse(here)

        if len(here.node.entries) > self._most:
            got = f"{len(here.node.entries)} entries"
            here.refuse(f"may hold up to {self._most} entries", got=got)

        def entry(name: Scalar, node: Node) -> tuple[Any, Any]:
            places = here.inside(name, name.text), here.inside(node, name.text)
            places[1].keep(name)
            key, value = each((lambda: self.key.read(places[0]), lambda: self.of.read(places[1])))
            printed = normalize("NFC", key) if isinstance(key, str) else key
            if printed in seen:
                places[0].refuse("this name is given twice: names differ by more than spaces")
            seen.add(printed)
            read[key] = value
            return key, value

        read: dict[Any, Any] = {}
        seen: set[Any] = set()
        each(lambda n=n, v=v: entry(n, v) for n, v in here.node.entries.values())
        return read

    def schema(self, defs: Schema, unit: str) -> Schema:
        """Return the schema of the table and its entries."""
        numbered = {"propertyNames": {"pattern": "^[1-9][0-9]*$"}}
        return {
            "type": "object",
            "additionalProperties": self.of.schema(defs, unit),
            "maxProperties": self._most,
        } | (numbered if isinstance(self.key, Whole) else {})


class OneOf(Rule):
    """Several rules, told apart by how YAML writes what they read."""

    def __init__(self, *rules: Rule) -> None:
        self.rules = rules
        self.units = next((r.units for r in rules if r.units), {})
        self.usual = next((r.usual for r in rules if r.usual), None)
        self.takes = tuple(node for r in rules for node in r.takes)
        self.one = " or ".join(r.one for r in rules)
        self.many = " or ".join(r.many for r in rules)

    def read(self, here: Here) -> Any:
        """Return what the rule for this kind of node returns."""
        fitting = (rule for rule in self.rules if isinstance(here.node, rule.takes))
        rule = next(fitting, None)
        if rule is None:
            self.refuse(here, number(here.node)[1] if isinstance(here.node, Scalar) else "")
        return rule.read(here)

    def schema(self, defs: Schema, unit: str) -> Schema:
        """Return the schema of any of the rules."""
        each = [r.schema(defs, unit) for r in self.rules]
        return {"anyOf": [one for s in each for one in (s["anyOf"] if [*s] == ["anyOf"] else [s])]}


# --- tables: entries by name --------------------------------------------------------------

_REQUIRED: Any = object()


@dataclass
class _Key:
    says: str
    default: Any


def key(says: str, *, default: Any = _REQUIRED) -> Any:
    """Declare a key of a table: what it is, and what stands for it where it is left out."""
    return _Key(says, default)


@dataclass
class Entry:
    """One entry of a table: how it is read, and the keys it goes by with their units."""

    name: str
    rule: Rule
    says: str
    default: Any
    keys: dict[str, str]

    @property
    def required(self) -> bool:
        """Whether a table cannot do without it."""
        return self.default is _REQUIRED

    @property
    def told(self) -> str:
        """The keys, as advice: `length_mm, length_m or length_in`."""
        *others, last = self.keys
        return f"{', '.join(others)} or {last}" if others else last

    def described(self, unit: str) -> str:
        """Return what a schema says of it."""
        said = f"{self.says}, {unit}" if unit else self.says
        plain = isinstance(self.default, (str, float, int)) and not unit
        return f"{said} (default {self.default})" if plain else said


Used: TypeAlias = dict[str, tuple[Scalar, Node]]
"""The entries a table of the file gives: as which key, with which node."""


@dataclass_transform(kw_only_default=True, frozen_default=True, field_specifiers=(key,))
class Table:
    """A table of the file. Unknown keys are refused; what was read is never changed."""

    one_of: ClassVar[tuple[tuple[str, ...], ...]] = ()
    """Entries of which the table needs exactly one."""
    fixed: ClassVar[bool] = False
    """Whether its numbers are no part of the design, as limits and ranges are not."""
    at_most_one_of: ClassVar[tuple[tuple[str, ...], ...]] = ()

    def build(self) -> Any:
        """Return what the table describes; by default itself, for an outer table to use."""
        return self

    # What fits the declarations can still make no sense. For `build`, and whoever uses it:

    def at(self, name: str = "", item: int | None = None) -> Here:
        """Return the place of an entry, of one of its items from 1, or of the whole table."""
        here, used = self._place
        if name not in used:
            return here
        written, node = used[name]
        if item is not None and isinstance(node, Sequence):
            return here.inside(node, written.text).item(node.items[item - 1], item)
        return here.inside(node if isinstance(node, Scalar) else written, written.text)

    def has(self, name: str) -> bool:
        """Whether the file gives an entry."""
        return name in self._place[1]

    def differ(self, name: str, called: Iterable[str], *, beside: Iterable[str] = ()) -> None:
        """Note items of an entry that have the name of one above them; `called` are all.

        Those `beside` them, of another entry, are taken too. Names are one where they are one in
        print: an é may be one character or two.
        """
        seen = {normalize("NFC", one) for one in beside}
        for k, one in enumerate(called, 1):
            printed = normalize("NFC", one)
            if printed in seen:
                self.at(name, k).note("this name is above already", "give it another", got=one)
            seen.add(printed)

    def attempt(self, make: Callable[[], T]) -> T:
        """Return what `make` returns; a `DesignError` becomes a problem of this table.

        It is put at the entry that the error's message starts with, if it does with one.
        """
        try:
            return make()
        except DesignError as error:
            named = (n for n in self.entries() if str(error).startswith(f"{n} "))
            self.at(next(named, "")).refuse(str(error))

    @property
    def _place(self) -> tuple[Here, Used]:
        return self.__dict__["_read_at"]

    # From the declarations:

    @classmethod
    @cache
    def entries(cls) -> dict[str, Entry]:
        """Return the declared entries by name."""
        found: dict[str, Entry] = {}
        for owner in reversed(cls.__mro__[:-1]):
            for name, annotation in owner.__annotations__.items():
                declared = owner.__dict__.get(name)
                if isinstance(declared, _Key):
                    rule = rule_of(annotation)
                    stem = name.rstrip("_")  # yield_ is called yield in a file
                    keys = {f"{stem}_{u}": u for u in rule.units} or {stem: ""}
                    found[name] = Entry(name, rule, declared.says, declared.default, keys)
        return found

    @classmethod
    @cache
    def keys(cls) -> dict[str, tuple[Entry, str]]:
        """Return every key a file may use, with its entry and unit."""
        return {k: (e, u) for e in cls.entries().values() for k, u in e.keys.items()}

    @classmethod
    def read(cls, here: Here) -> Any:
        """Return what a node of the file describes; note everything wrong with it."""
        root = here.node
        if not isinstance(root, Mapping):
            TableRule(cls).refuse(here)
        before, spoilt = len(here.reading.problems), False
        if cls.fixed:
            here = replace(here, fixed=True)
        used: Used = {}
        values: dict[str, Any] = {}
        meant: set[str] = set()
        for written, node in root.entries.values():
            entry, unit = cls.keys().get(written.text, (None, ""))
            if entry is None:
                guess, hint = _advice(cls, written.text, node)
                meant.add(guess)
                here.inside(written, written.text).note("unknown key", hint)
            elif entry.name in used:
                first = used[entry.name][0].text
                message = f"{first} gives this already"
                here.inside(written, written.text).note(message, "keep one of them")
            else:
                used[entry.name] = written, node
                place = here.inside(node, written.text, unit)
                place.keep(written)
                try:
                    values[entry.name] = entry.rule.read(place)
                    _doubt(entry, values[entry.name], place)
                except Spoilt:
                    spoilt = True
        cls._hold_together(here, used, meant)
        if spoilt or len(here.reading.problems) > before:
            raise Spoilt
        table = cls.__new__(cls)
        for entry in cls.entries().values():
            table.__dict__[entry.name] = values.get(entry.name, entry.default)
        table.__dict__["_read_at"] = here, used
        made = table.attempt(table.build)
        if len(here.reading.problems) > before:
            raise Spoilt
        return made

    @classmethod
    def _hold_together(cls, here: Here, used: Used, meant: set[str]) -> None:
        """Note which keys are missing, and which exclude each other."""
        entries = cls.entries()
        for entry in entries.values():
            if entry.required and entry.name not in {*used, *meant}:
                here.note(f"{entry.told} is missing: {entry.says}")
        for names in cls.one_of + cls.at_most_one_of:
            given = sorted((used[n][0] for n in names if n in used), key=_in_order)
            if len(given) > 1:
                message = f"{given[0].text} and {given[1].text} exclude each other"
                here.inside(given[1], given[1].text).note(message, "keep one of them")
            elif not given and names in cls.one_of and not meant & set(names):
                *others, last = (next(iter(entries[n].keys)) for n in names)
                here.note(f"needs {', '.join(others)} or {last}")

    @classmethod
    def schema(cls, defs: Schema) -> Schema:
        """Return a reference to this table's JSON Schema, which goes into `defs`."""
        name = cls.__name__.removesuffix("Table")
        if name not in defs:
            defs[name] = {}  # at once, so that a table may hold itself
            defs[name] = {
                "type": "object",
                "description": " ".join((cls.__doc__ or "").split("\n\n")[0].split()),
                "additionalProperties": False,
                "properties": {
                    k: {"description": e.described(u), **e.rule.schema(defs, u)}
                    for k, (e, u) in cls.keys().items()
                },
                **_demands(cls),
            }
        return {"$ref": f"#/$defs/{name}"}


class TableRule(Rule):
    """A table, and what it becomes."""

    takes = (Mapping,)

    def __init__(self, table: type[Table]) -> None:
        self.table = table
        keys = [next(iter(e.keys)) for e in table.entries().values()]
        self.one = f"a table with {', '.join(keys[:6])}{', ...' if len(keys) > 6 else ''}"
        self.many = f"tables{self.one.removeprefix('a table')}"

    def read(self, here: Here) -> Any:
        """Return what the table becomes."""
        return self.table.read(here)

    def schema(self, defs: Schema, unit: str) -> Schema:  # noqa: ARG002  tables have no unit
        """Return a reference to the table's schema."""
        return self.table.schema(defs)


class Later(Rule):
    """A table that few files have: what it takes is imported when one does."""

    takes = (Mapping,)
    one, many = "a table", "tables"

    def __init__(self, module: str, table: str) -> None:
        self.named = module, table

    @cached_property
    def rule(self) -> TableRule:
        """The rule of the table itself."""
        module, table = self.named
        return TableRule(getattr(import_module(module), table))

    def read(self, here: Here) -> Any:
        """Return what the table becomes."""
        return self.rule.read(here)

    def schema(self, defs: Schema, unit: str) -> Schema:
        """Return a reference to the table's schema."""
        return self.rule.schema(defs, unit)


def _in_order(node: Node) -> tuple[int, int]:
    return node.line, node.column


def _demands(cls: type[Table]) -> Schema:
    """Return what a schema says of keys that are needed or exclude each other."""
    entries = cls.entries()

    def given(*names: str) -> list[Schema]:
        return [{"required": [k]} for n in names for k in entries[n].keys]

    needed = [k for e in entries.values() if e.required and len(e.keys) == 1 for k in e.keys]
    several = [e for e in entries.values() if len(e.keys) > 1]
    exactly = [(e.name,) for e in several if e.required] + list(cls.one_of)
    at_most = [(e.name,) for e in several if not e.required] + list(cls.at_most_one_of)
    groups: list[Schema] = [{"oneOf": given(*names)} for names in exactly]
    groups += [{"oneOf": [*given(*names), {"not": {"anyOf": given(*names)}}]} for names in at_most]
    return ({"required": needed} if needed else {}) | ({"allOf": groups} if groups else {})


@cache
def rule_of(annotation: Any) -> Rule:
    """Return the rule an annotation stands for."""
    origin, args = get_origin(annotation), get_args(annotation)
    if origin is Annotated:
        return next((r for r in map(_as_rule, args[1:]) if r), None) or rule_of(args[0])
    if origin in (Union, types.UnionType):
        rules = [rule_of(a) for a in args if a is not type(None)]
        return rules[0] if len(rules) == 1 else OneOf(*rules)
    if origin is Literal:
        return Choice(*args)
    if origin is tuple and args[-1] is Ellipsis:
        return ListOf(rule_of(args[0]))
    if origin is dict:
        return MapOf(rule_of(args[0]), rule_of(args[1]))
    plain: dict[Any, type[Rule]] = {float: Number, int: Whole, str: Text, bool: Flag}
    return _as_rule(annotation) or plain[annotation]()


def _as_rule(said: Any) -> Rule | None:
    if isinstance(said, type) and issubclass(said, Table):
        return TableRule(said)
    return said if isinstance(said, Rule) else None


# --- advice -------------------------------------------------------------------------------


def _advice(cls: type[Table], name: str, node: Node) -> tuple[str, str]:
    """Return the entry that an unknown key may stand for, and what to try instead."""
    keys, entries = cls.keys(), cls.entries()
    empty = isinstance(node, Scalar) and node.value is None
    ahead = name.partition(":")[0]
    if ahead != name and ahead in keys:
        return keys[ahead][0].name, "put a space after the colon"
    if empty and name.isdigit():
        return "", "numbers take a point before decimals and nothing between thousands"
    if name in entries:
        return name, f"the key names its unit: write {entries[name].told}"
    if same := [k for k in keys if k.casefold() == name.casefold()]:
        return keys[same[0]][0].name, f"write {same[0]}"
    for entry in entries.values():
        if len(entry.keys) > 1 and name.startswith(f"{entry.name}_"):
            return entry.name, f"not in this unit: write {entry.told}"
    for entry in entries.values():
        if any(name in table.keys() for table in _tables_in(entry.rule)):  # noqa: SIM118
            return "", f"it belongs in {next(iter(entry.keys))}"
    found, hint = _meant(name, keys)
    return (keys[found][0].name if found else ""), hint


def _tables_in(rule: Rule) -> list[type[Table]]:
    """Return the tables that an entry may hold directly."""
    if isinstance(rule, Later):
        rule = rule.rule
    if isinstance(rule, TableRule):
        return [rule.table]
    if isinstance(rule, OneOf):
        return [table for r in rule.rules for table in _tables_in(r)]
    return _tables_in(rule.of) if isinstance(rule, (ListOf, MapOf)) else []


def _numbers_in(value: Any) -> list[float]:
    if isinstance(value, float):
        return [value]
    items = cast("tuple[Any, ...]", value) if isinstance(value, tuple) else ()
    if isinstance(value, dict):
        items = tuple(cast("dict[Any, Any]", value).values())
    return [x for item in items for x in _numbers_in(item)]


def _doubt(entry: Entry, value: Any, here: Here) -> None:
    """Warn where a number would be an everyday one in another unit.

    Of a list the largest number counts: small ones beside it are what they are.
    """
    if entry.rule.usual is None:
        return
    size = max(map(abs, _numbers_in(value)), default=0.0)
    low, high = entry.rule.usual
    if size == 0 or low <= size <= high:
        return
    worth = entry.rule.units.get(here.unit, 1.0)
    odd = f"{size / worth:g}{' ' * bool(here.unit)}{here.unit} is unusually"
    number = Number(worth=entry.rule.units, usual=entry.rule.usual)
    other = number.other(size / worth, here.unit, entry.name.rstrip("_"))
    range_ = f"{low / worth:.4g} to {high / worth:.4g} is usual"
    here.warn(f"{odd} {'small' if size < low else 'large'}", other or f"check the unit; {range_}")
