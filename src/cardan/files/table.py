"""Tables of a file, declared once: what each key may hold and what the table becomes.

A table is a class whose annotations say how its entries are read:

    class TubeTable(Table):
        \"""A round tube.\"""

        outer: Size = key("outside diameter")
        wall: Size = key("wall thickness")

        def build(self) -> Tube:
            return Tube(outer=self.outer, wall=self.wall)

`Size` is a float measured in mm, m or inches, so the file's key is `outer_mm`, `outer_m` or
`outer_in`, one of them; inside it is SI. From the same declaration come the reader, its
errors with line, column and advice, and the JSON Schema that editors use. An annotation
`Annotated[Tube, TubeTable]` is a nested table that has become a tube by the time the outer
table is built, so every part is tried on its own and a file's errors are found all at once.

Annotations understood: float, int, str, bool, Literal, tuple, dict, Table classes, unions
told apart by how YAML writes them, None for a key that may be left out, and Annotated with
a `Rule` or table.
"""

import types
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path
from typing import (
    Annotated,
    Any,
    ClassVar,
    Literal,
    TypeVar,
    Union,
    cast,
    dataclass_transform,
    get_args,
    get_origin,
)

from cardan.base.errors import DesignError, Problem
from cardan.base.units import UNITS
from cardan.files.document import Mapping, Node, Scalar, Sequence, number

T = TypeVar("T")
Schema = dict[str, Any]

LARGE = 1e12
"""No number of a driveline is larger, in any unit; sums and products stay finite."""


class Spoilt(Exception):  # noqa: N818  not an error of its own
    """Something read so far is wrong and noted: what was to be made of it cannot be."""


@dataclass
class Reading:
    """What has come up while a file was read, and where its parts' names are looked up."""

    catalogue: Any = None
    folder: Path | None = None
    problems: list[Problem] = field(default_factory=list[Problem])
    warnings: list[Problem] = field(default_factory=list[Problem])

    def refuse(self, node: Node, at: str, message: str, hint: str = "", *, got: str = "") -> Spoilt:
        """Note a problem; raise what this returns where nothing sensible can follow."""
        self.problems.append(_problem(node, at, message, hint, got))
        return Spoilt()

    def warn(self, node: Node, at: str, message: str, hint: str = "", *, got: str = "") -> None:
        """Note what looks wrong but can be read."""
        self.warnings.append(_problem(node, at, message, hint, got))


def _problem(node: Node, at: str, message: str, hint: str, got: str) -> Problem:
    return Problem(
        message=message, hint=hint, key=at, value=got, line=node.line, column=node.column
    )


def nearest(name: str, names: "list[str] | tuple[str, ...]") -> str:
    """Return advice on a name nobody knows: the nearest known one, or all there are."""
    from difflib import get_close_matches  # needed in bad files alone

    folded = {n.casefold(): n for n in reversed(names)}
    if close := get_close_matches(name.casefold(), list(folded), n=1, cutoff=0.6):
        return f"did you mean {folded[close[0]]}?"
    if not names:
        return "there are none"
    shown = ", ".join(names[:20])
    return f"there are: {shown}" + (f" and {len(names) - 20} more" if len(names) > 20 else "")


# --------------------------------------------------------------------------- rules


class Rule:
    """How one kind of entry is read, and how a schema and an error name it."""

    one: str = "a value"
    many: str = "values"
    takes: type[Node] | tuple[type[Node], ...] = Scalar
    units: dict[str, float] = {}  # noqa: RUF012  SI values of the units a key may end in
    usual: tuple[float, float] | None = None
    """Magnitudes (SI) nobody wonders at; outside them a unit may be wrong."""

    def read(self, node: Node, at: str, reading: Reading, unit: str) -> Any:
        """Return what a node means, or note what is wrong and raise `Spoilt`."""
        raise NotImplementedError

    def schema(self, defs: Schema, unit: str) -> Schema:
        """Return the JSON Schema of what is read; `defs` collects the tables in it."""
        raise NotImplementedError

    def refused(self, node: Node, at: str, reading: Reading, hint: str = "") -> Spoilt:
        """Note that a node is not what this rule reads."""
        if isinstance(node, Scalar) and node.value is None:
            return reading.refuse(node, at, f"has no value; it must be {self.one}", hint)
        return reading.refuse(node, at, f"must be {self.one}", hint, got=node.brief)


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
        self.above, self.least, self.below, self.most = above, least, below, most
        self.usual = usual
        self.one, self.many = f"a number{self._range('')}", f"numbers{self._range('')}"

    def _range(self, unit: str) -> str:
        """Say the bounds, in a unit."""
        worth = self.units.get(unit, 1.0)
        low = self.least if self.above is None else self.above
        high = self.most if self.below is None else self.below
        if not self.units.get(unit) and self.units and {low, high} - {None, 0.0}:
            return ""  # bounds other than 0 cannot be said without the unit
        words = [
            ""
            if low is None
            else f"{'above' if self.above is not None else 'from'} {low / worth:g}",
            ""
            if high is None
            else f"{'below' if self.below is not None else 'up to'} {high / worth:g}",
        ]
        if low is not None and high is None and self.least is not None:
            words = [f"of {low / worth:g} or more"]
        return "".join(f" {w}" for w in [" and ".join(w for w in words if w)] if w)

    def read(self, node: Node, at: str, reading: Reading, unit: str) -> float:
        if not isinstance(node, Scalar):
            raise self.refused(node, at, reading)
        value, hint = number(node)
        if value is None:
            raise self.refused(node, at, reading, hint)
        if not abs(value) < LARGE:
            raise reading.refuse(node, at, f"must be within ±{LARGE:g}", got=node.brief)
        si = value * self.units.get(unit, 1.0)
        fits = (
            (self.above is None or si > self.above)
            and (self.least is None or si >= self.least)
            and (self.below is None or si < self.below)
            and (self.most is None or si <= self.most)
        )
        if not fits:
            name = f" {unit}" if unit else ""
            message = f"must be a number{self._range(unit)}{name}"
            raise reading.refuse(node, at, message, got=node.brief)
        return si

    def schema(self, defs: Schema, unit: str) -> Schema:
        worth = self.units.get(unit, 1.0)
        bounds = {
            "exclusiveMinimum": self.above, "minimum": self.least,
            "exclusiveMaximum": self.below, "maximum": self.most,
        }  # fmt: skip
        return {"type": "number"} | {
            k: float(f"{b / worth:.12g}") for k, b in bounds.items() if b is not None
        }


class Whole(Rule):
    """A whole number from `least` on."""

    def __init__(self, least: int = 1) -> None:
        self.least = least
        self.one, self.many = f"a whole number from {least}", f"whole numbers from {least}"

    def read(self, node: Node, at: str, reading: Reading, unit: str) -> int:
        value = node.value if isinstance(node, Scalar) else None
        if not isinstance(value, int) or isinstance(value, bool) or not value >= self.least:
            hint = number(node)[1] if isinstance(node, Scalar) else ""
            raise self.refused(node, at, reading, hint)
        return value

    def schema(self, defs: Schema, unit: str) -> Schema:
        return {"type": "integer", "minimum": self.least}


class Text(Rule):
    """A text; a number will do, as it was written: joints are called 1810."""

    one, many = "a text", "texts"

    def read(self, node: Node, at: str, reading: Reading, unit: str) -> str:
        value = node.value if isinstance(node, Scalar) else None
        if not isinstance(node, Scalar) or value is None or not node.text.strip():
            raise self.refused(node, at, reading)
        if isinstance(value, bool):
            raise self.refused(node, at, reading, "put it in quotes if it is a name")
        return node.text

    def schema(self, defs: Schema, unit: str) -> Schema:
        return {"type": ["string", "number"]}


class Choice(Rule):
    """One of some names."""

    def __init__(self, *names: str) -> None:
        self.names = names
        self.one = self.many = f"one of {', '.join(names)}"

    def read(self, node: Node, at: str, reading: Reading, unit: str) -> str:
        if not isinstance(node, Scalar):
            raise self.refused(node, at, reading)
        if node.text not in self.names:
            near = nearest(node.text, self.names)
            raise self.refused(node, at, reading, near if near.startswith("did") else "")
        return node.text

    def schema(self, defs: Schema, unit: str) -> Schema:
        return {"enum": list(self.names)}


class Flag(Rule):
    """True or false, in these words."""

    one, many = "true or false", "true or false"

    def read(self, node: Node, at: str, reading: Reading, unit: str) -> bool:
        value = node.value
        if not isinstance(value, bool):
            said = node.text.casefold() if isinstance(node, Scalar) else ""
            meant = {"yes": "true", "on": "true", "no": "false", "off": "false"}.get(said)
            raise self.refused(node, at, reading, f"write {meant}" if meant else "")
        return value

    def schema(self, defs: Schema, unit: str) -> Schema:
        return {"type": "boolean"}


class ListOf(Rule):
    """A list; of a fixed length where `names` says what each item is."""

    takes = Sequence

    def __init__(self, item: Rule, *names: str, least: int = 0) -> None:
        self.item, self.names, self.least = item, names, least
        self.units, self.usual = item.units, item.usual
        count = f"{len(names)} {item.many}, [{', '.join(names)}]" if names else item.many
        self.one, self.many = f"a list of {count}", f"lists of {count}"

    def read(self, node: Node, at: str, reading: Reading, unit: str) -> tuple[Any, ...]:
        if not isinstance(node, Sequence):
            raise self.refused(node, at, reading)
        if self.names and len(node.items) != len(self.names):
            raise self.refused(node, at, reading)
        if len(node.items) < self.least:
            raise self.refused(node, at, reading, f"give at least {self.least}")
        return tuple(
            _all(
                lambda n=item, k=k: self.item.read(n, f"{at}[{k}]", reading, unit)
                for k, item in enumerate(node.items, 1)
            )
        )

    def schema(self, defs: Schema, unit: str) -> Schema:
        size: Schema = {"minItems": self.least} if self.least else {}
        if self.names:
            size = {"minItems": len(self.names), "maxItems": len(self.names)}
        return {"type": "array", "items": self.item.schema(defs, unit), **size}


class MapOf(Rule):
    """A table whose keys are names the user chooses."""

    takes = Mapping

    def __init__(self, key: Rule, item: Rule) -> None:
        self.key, self.item = key, item
        self.units = item.units
        self.one = f"a table from {key.one} to {item.one}"
        self.many = f"tables from {key.one} to {item.one}"

    def read(self, node: Node, at: str, reading: Reading, unit: str) -> dict[Any, Any]:
        if not isinstance(node, Mapping):
            raise self.refused(node, at, reading)

        def entry(name: Scalar, value: Node) -> tuple[Any, Any]:
            key, read = _all(
                (
                    lambda: self.key.read(name, f"{at}.{name.text}", reading, ""),
                    lambda: self.item.read(value, f"{at}.{name.text}", reading, unit),
                )
            )
            return key, read

        return dict(_all(lambda k=k, v=v: entry(k, v) for k, v in node.entries.values()))

    def schema(self, defs: Schema, unit: str) -> Schema:
        return {"type": "object", "additionalProperties": self.item.schema(defs, unit)} | (
            {"propertyNames": {"pattern": "^[0-9]+$"}} if isinstance(self.key, Whole) else {}
        )


class OneOf(Rule):
    """Several rules, told apart by how YAML writes what they read."""

    def __init__(self, *rules: Rule) -> None:
        self.rules = rules
        self.units = next((r.units for r in rules if r.units), {})
        self.usual = next((r.usual for r in rules if r.usual), None)
        self.takes = tuple(
            t for r in rules for t in (r.takes if isinstance(r.takes, tuple) else (r.takes,))
        )
        self.one, self.many = (" or ".join(getattr(r, n) for r in rules) for n in ("one", "many"))

    def read(self, node: Node, at: str, reading: Reading, unit: str) -> Any:
        for rule in self.rules:
            if isinstance(node, rule.takes) and not (
                isinstance(node, Scalar) and node.value is None
            ):
                return rule.read(node, at, reading, unit)
        hint = number(node)[1] if isinstance(node, Scalar) else ""
        raise self.refused(node, at, reading, hint)

    def schema(self, defs: Schema, unit: str) -> Schema:
        return {"anyOf": [r.schema(defs, unit) for r in self.rules]}


def _all(tries: "Iterator[Callable[[], T]] | tuple[Callable[[], T], ...]") -> list[T]:
    """Return the results of all tries; if any is spoilt, only after the last was made."""
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


# --------------------------------------------------------------------------- tables

_REQUIRED: Any = object()


@dataclass(slots=True)
class _Key:
    says: str
    default: Any


def key(says: str, *, default: Any = _REQUIRED) -> Any:
    """Declare a key of a table: what it is, and what stands for it where it is left out."""
    return _Key(says, default)


@dataclass(slots=True)
class Entry:
    """One entry of a table: its rule, and the keys it goes by with their units."""

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
        return _or(list(self.keys))


def _or(words: list[str]) -> str:
    return " or ".join([", ".join(words[:-1]), words[-1]] if len(words) > 1 else words)


@dataclass(slots=True)
class _Here:
    """Where a table stands in the file."""

    node: Mapping
    at: str
    reading: Reading
    used: dict[str, tuple[Scalar, Node]]


@dataclass_transform(kw_only_default=True, frozen_default=True, field_specifiers=(key,))
class Table:
    """A table of the file. Unknown keys are refused; its entries are never changed."""

    one_of: ClassVar[tuple[tuple[str, ...], ...]] = ()
    """Entries of which a table needs exactly one."""
    at_most_one_of: ClassVar[tuple[tuple[str, ...], ...]] = ()
    _here: _Here

    def build(self) -> Any:
        """Return what the table describes; by default itself, for an outer table to use."""
        return self

    # -- for `build`: what fits the declarations can still make no sense

    def refuse(self, name: str, message: str, hint: str = "", *, got: str = "") -> Spoilt:
        """Note a problem at an entry, or at the whole table; raise the result to stop."""
        return self._here.reading.refuse(*self._place(name), message, hint, got=got)

    def refuse_item(
        self, name: str, place: int, message: str, hint: str = "", *, got: str = ""
    ) -> Spoilt:
        """Note a problem at an item (counted from 0) of an entry that is a list."""
        _, node = self._here.used[name]
        item = node.items[place] if isinstance(node, Sequence) else node
        at = f"{_joined(self._here.at, name)}[{place + 1}]"
        return self._here.reading.refuse(item, at, message, hint, got=got)

    def warn(self, name: str, message: str, hint: str = "", *, got: str = "") -> None:
        """Note what looks wrong at an entry, or at the whole table."""
        self._here.reading.warn(*self._place(name), message, hint, got=got)

    def has(self, name: str) -> bool:
        """Whether the file gives an entry."""
        return name in self._here.used

    def attempt(self, make: Callable[[], T]) -> T:
        """Return what `make` returns; a `DesignError` in it becomes a problem of the table."""
        try:
            return make()
        except DesignError as error:
            message = str(error)
            named = [n for n in self.entries() if message.startswith(f"{n} ") and self.has(n)]
            raise self.refuse(named[0] if named else "", message) from None

    def _place(self, name: str) -> tuple[Node, str]:
        here = self._here
        if name not in here.used:
            return here.node, here.at
        written, node = here.used[name]
        at = _joined(here.at, written.text)
        return (node, at) if isinstance(node, Scalar) else (written, at)

    # -- from the declarations

    @classmethod
    @cache
    def entries(cls) -> dict[str, Entry]:
        """Return the declared entries by name."""
        found: dict[str, Entry] = {}
        for owner in reversed(cls.__mro__):
            for name, annotation in _annotations(owner).items():
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
    def read(cls, node: Node, at: str, reading: Reading) -> Any:
        """Return what a node of the file describes; note everything wrong with it."""
        if not isinstance(node, Mapping):
            raise TableRule(cls).refused(node, at, reading)
        used: dict[str, tuple[Scalar, Node]] = {}
        values: dict[str, Any] = {}
        guessed: set[str] = set()
        spoilt = False
        for written, child in node.entries.values():
            entry, unit = cls.keys().get(written.text, (None, ""))
            path = _joined(at, written.text)
            if entry is None:
                spoilt = True
                guessed |= _unknown(cls, written, child, path, reading)
            elif entry.name in used:
                spoilt = True
                before = used[entry.name][0].text
                reading.refuse(written, path, f"{before} gives this already", "keep one of them")
            else:
                used[entry.name] = written, child
                try:
                    values[entry.name] = entry.rule.read(child, path, reading, unit)
                except Spoilt:
                    spoilt = True
                else:
                    _doubt(entry, unit, values[entry.name], child, path, reading)
        spoilt |= cls._lacking(node, at, reading, set(used), guessed)
        if spoilt:
            raise Spoilt
        table = cls.__new__(cls)
        for entry in cls.entries().values():
            table.__dict__[entry.name] = values.get(entry.name, entry.default)
        table.__dict__["_here"] = _Here(node, at, reading, used)
        before = len(reading.problems)
        made = table.attempt(table.build)
        if len(reading.problems) > before:
            raise Spoilt
        return made

    @classmethod
    def _lacking(
        cls, node: Node, at: str, reading: Reading, used: set[str], guessed: set[str]
    ) -> bool:
        """Note which keys are missing, and which exclude each other."""
        count, entries = len(reading.problems), cls.entries()
        for entry in entries.values():
            if entry.required and entry.name not in used | guessed:
                reading.refuse(node, at, f"{entry.told} is missing", f"it is {entry.says}")
        for names in cls.one_of + cls.at_most_one_of:
            given = [n for n in names if n in used]
            told = _or([" or ".join(entries[n].keys) for n in names])
            if len(given) > 1:
                clash = " and ".join(_keys_in(node, entries[n]) for n in given)
                reading.refuse(node, at, f"{clash} exclude each other", "keep one of them")
            elif not given and names in cls.one_of and not guessed & set(names):
                reading.refuse(node, at, f"needs {told}")
        return len(reading.problems) > count

    @classmethod
    def schema(cls, defs: Schema) -> Schema:
        """Return a reference to this table's JSON Schema, which goes to `defs`."""
        name = cls.__name__.removesuffix("Table")
        if name not in defs:
            defs[name] = {}  # now, so that a table may hold itself
            defs[name] = {
                "type": "object",
                "description": (cls.__doc__ or "").split("\n\n")[0].replace("\n    ", " "),
                "additionalProperties": False,
                "properties": {
                    k: {"description": _described(e, u), **e.rule.schema(defs, u)}
                    for k, (e, u) in cls.keys().items()
                },
                **_demands(cls),
            }
        return {"$ref": f"#/$defs/{name}"}


def _joined(at: str, name: str) -> str:
    return f"{at}.{name}" if at else name


def _keys_in(node: Node, entry: Entry) -> str:
    """The key an entry was given by."""
    given = node.entries if isinstance(node, Mapping) else {}
    return next(k for k in entry.keys if k in given)


def _described(entry: Entry, unit: str) -> str:
    default = entry.default
    said = "" if default is None or entry.required or unit else f" (default {_shown(default)})"
    return f"{entry.says}{f', {unit}' if unit else ''}{said}"


def _shown(default: Any) -> str:
    return f"{default:g}" if isinstance(default, float) else str(default)


def _demands(cls: type[Table]) -> Schema:
    """What a schema says of keys that are needed or exclude each other."""
    entries = cls.entries()

    def given(*names: str) -> list[Schema]:
        return [{"required": [k]} for n in names for k in entries[n].keys]

    needed = [k for e in entries.values() if e.required and len(e.keys) == 1 for k in e.keys]
    groups: list[Schema] = [
        {"oneOf": given(e.name)} for e in entries.values() if e.required and len(e.keys) > 1
    ]
    groups += [{"oneOf": given(*names)} for names in cls.one_of]
    once = [(e.name,) for e in entries.values() if not e.required and len(e.keys) > 1]
    grouped = {n for names in (*cls.one_of, *cls.at_most_one_of) for n in names}
    for names in (*cls.at_most_one_of, *(o for o in once if o[0] not in grouped)):
        groups.append({"oneOf": [*given(*names), {"not": {"anyOf": given(*names)}}]})
    return ({"required": needed} if needed else {}) | ({"allOf": groups} if groups else {})


class TableRule(Rule):
    """A table, and what it becomes."""

    takes = Mapping

    def __init__(self, table: type[Table]) -> None:
        self.table = table

    @property
    def one(self) -> str:  # pyright: ignore[reportIncompatibleVariableOverride]
        keys = [next(iter(e.keys)) for e in self.table.entries().values()]
        return f"a table with {', '.join(keys[:6])}{', ...' if len(keys) > 6 else ''}"

    @property
    def many(self) -> str:  # pyright: ignore[reportIncompatibleVariableOverride]
        return "tables" + self.one.removeprefix("a table")

    def read(self, node: Node, at: str, reading: Reading, unit: str) -> Any:
        return self.table.read(node, at, reading)

    def schema(self, defs: Schema, unit: str) -> Schema:
        return self.table.schema(defs)


def _annotations(owner: type) -> dict[str, Any]:
    return (
        cast("dict[str, Any]", getattr(owner, "__annotations__", {})) if owner is not object else {}
    )


@cache
def rule_of(annotation: Any) -> Rule:
    """Return the rule an annotation stands for."""
    origin, args = get_origin(annotation), get_args(annotation)
    if origin is Annotated:
        for said in args[1:]:
            if isinstance(said, Rule):
                return said
            if isinstance(said, type) and issubclass(said, Table):
                return TableRule(said)
        return rule_of(args[0])
    if origin in (Union, types.UnionType):
        rules = [rule_of(a) for a in args if a is not type(None)]
        return rules[0] if len(rules) == 1 else OneOf(*rules)
    if origin is Literal:
        return Choice(*args)
    if origin is tuple and args[-1] is Ellipsis:
        return ListOf(rule_of(args[0]))
    if origin is dict:
        return MapOf(rule_of(args[0]), rule_of(args[1]))
    if isinstance(annotation, type) and issubclass(annotation, Table):
        return TableRule(annotation)
    return {float: Number, int: Whole, str: Text, bool: Flag}[annotation]()


# --------------------------------------------------------------------------- advice


def _unknown(
    cls: type[Table], written: Scalar, child: Node, path: str, reading: Reading
) -> set[str]:
    """Note a key nobody knows, with what may be meant; return the entry it may stand for."""
    name = written.text
    hint, meant = _advice(cls, name, child)
    reading.refuse(written, path, "unknown key", hint)
    return {meant} if meant else set()


def _advice(cls: type[Table], name: str, child: Node) -> tuple[str, str]:
    keys, entries = cls.keys(), cls.entries()
    empty = isinstance(child, Scalar) and child.value is None
    if ":" in name and (found := name.split(":", 1)[0]) in keys:
        return "put a space after the colon", keys[found][0].name
    if empty and name.isdigit():
        return "is this a decimal comma? write a point", ""
    if name in entries:
        return f"the key names its unit: write {entries[name].told}", name
    if same := [k for k in keys if k.casefold() == name.casefold()]:
        return f"write {same[0]}", keys[same[0]][0].name
    stems = [e for e in entries.values() if len(e.keys) > 1 and name.startswith(f"{e.name}_")]
    if stems:
        return f"its unit must be one of these: write {stems[0].told}", stems[0].name
    for entry in entries.values():
        for inner in _tables_in(entry.rule):
            if name in inner.keys():  # noqa: SIM118  a method, not a dict
                return f"it belongs in {next(iter(entry.keys))}", ""
    near = nearest(name, list(keys))
    if near.startswith("did"):
        return near, keys[near[len("did you mean ") : -1]][0].name
    return near, ""


def _tables_in(rule: Rule) -> list[type[Table]]:
    """The tables that an entry may hold directly."""
    if isinstance(rule, TableRule):
        return [rule.table]
    if isinstance(rule, OneOf):
        return [t for r in rule.rules for t in _tables_in(r)]
    return _tables_in(rule.item) if isinstance(rule, (ListOf, MapOf)) else []


def _numbers_in(value: Any) -> list[float]:
    if isinstance(value, float):
        return [value]
    return [x for v in value for x in _numbers_in(v)] if isinstance(value, tuple) else []


def _doubt(entry: Entry, unit: str, value: Any, node: Node, path: str, reading: Reading) -> None:
    """Warn where a number would be an everyday one in another unit.

    Of a list the largest number counts: small ones beside it are what they are.
    """
    if not entry.rule.usual or not (numbers := _numbers_in(value)):
        return
    size = max(map(abs, numbers))
    low, high = entry.rule.usual
    if size == 0 or low <= size <= high:
        return
    worth = entry.rule.units
    written = size / worth[unit]
    fitting = [u for u in worth if low <= written * worth[u] <= high]
    odd = f"{written:g} {unit} is unusually {'small' if size < low else 'large'}"
    hint = f"did you mean {entry.name}_{fitting[0]}?" if fitting else "check the unit"
    reading.warn(node, path, odd, hint)
