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

Annotations understood: float, int, str, bool, Literal, tuple, dict, tables, unions
distinguished by how YAML writes them, None for a key that may be left out, and Annotated with a
`Field` or a table.
"""

import types
from collections.abc import Callable, Iterable
from dataclasses import replace
from functools import cache, cached_property
from importlib import import_module
from typing import (
    Annotated,
    Any,
    ClassVar,
    Literal,
    TypeAlias,
    Union,
    cast,
    dataclass_transform,
    get_args,
    get_origin,
)
from unicodedata import normalize

from cardan.core.errors import DesignError
from cardan.core.lazy_dataclass import dataclass
from cardan.core.units import UNITS
from cardan.schema.field_types import (
    OTHER_UNITS,
    BooleanField,
    EnumField,
    Field,
    IntegerField,
    JsonSchema,
    ListField,
    MappingField,
    NumberField,
    TextField,
    UnionField,
)
from cardan.schema.node_reader import InvalidValueError, NodeReader, T, nearest_name
from cardan.schema.yaml_tree import (
    Mapping,
    Node,
    Scalar,
    Sequence,
)

# --- tables: entries by name --------------------------------------------------------------

_REQUIRED: Any = object()


@dataclass
class _Key:
    says: str
    default: Any


def table_key_field(says: str, *, default: Any = _REQUIRED) -> Any:
    """Declare a key of a table: what it is, and what stands for it where it is left out."""
    return _Key(says, default)


@dataclass
class FieldSpec:
    """One entry of a table: how it is read, and the keys it goes by with their units."""

    name: str
    field: Field
    description: str
    default: Any
    keys: dict[str, str]

    @property
    def required(self) -> bool:
        """Whether a table cannot do without it."""
        return self.default is _REQUIRED

    @property
    def key_choices(self) -> str:
        """The keys, as advice: `length_mm, length_m or length_in`."""
        *others, last = self.keys
        return f"{', '.join(others)} or {last}" if others else last

    def schema_description(self, unit: str) -> str:
        """Return what a schema says of it."""
        said = f"{self.description}, {unit}" if unit else self.description
        plain = isinstance(self.default, (str, float, int)) and not unit
        return f"{said} (default {self.default})" if plain else said


StatedTableEntries: TypeAlias = dict[str, tuple[Scalar, Node]]
"""The entries a table of the file gives: as which key, with which node."""


@dataclass_transform(kw_only_default=True, frozen_default=True, field_specifiers=(table_key_field,))
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

    # What fits the declarations can still make no sense. For `build`, and its callers:

    def reader_of(self, name: str = "", item: int | None = None) -> NodeReader:
        """Return the place of an entry, of one of its items from 1, or of the whole table."""
        here, used = self._place
        if name not in used:
            return here
        written, node = used[name]
        if item is not None and isinstance(node, Sequence):
            return here.child(node, written.text).item(node.items[item - 1], item)
        return here.child(node if isinstance(node, Scalar) else written, written.text)

    def has(self, name: str) -> bool:
        """Whether the file gives an entry."""
        return name in self._place[1]

    def require_different_names(
        self, name: str, called: Iterable[str], *, beside: Iterable[str] = ()
    ) -> None:
        """Note items of an entry that have the name of one above them; `called` are all.

        Those `beside` them, of another entry, are taken too. Names are one where they are one in
        print: an é may be one character or two.
        """
        seen = {normalize("NFC", one) for one in beside}
        for k, one in enumerate(called, 1):
            printed = normalize("NFC", one)
            if printed in seen:
                self.reader_of(name, k).add_issue(
                    "this name is above already", "give it another", got=one
                )
            seen.add(printed)

    def attempt(self, make: Callable[[], T]) -> T:
        """Return what `make` returns; a `DesignError` becomes a problem of this table.

        It is put at the entry that the error's message starts with, if it does with one.
        """
        try:
            return make()
        except DesignError as error:
            named = (n for n in self.entries() if str(error).startswith(f"{n} "))
            self.reader_of(next(named, "")).reject(str(error))

    @property
    def _place(self) -> tuple[NodeReader, StatedTableEntries]:
        return self.__dict__["_read_at"]

    # From the declarations:

    @classmethod
    @cache
    def entries(cls) -> dict[str, FieldSpec]:
        """Return the declared entries by name."""
        found: dict[str, FieldSpec] = {}
        for owner in reversed(cls.__mro__[:-1]):
            for name, annotation in owner.__annotations__.items():
                declared = owner.__dict__.get(name)
                if isinstance(declared, _Key):
                    rule = field_of_annotation(annotation)
                    stem = name.rstrip("_")  # yield_ is called yield in a file
                    keys = {f"{stem}_{u}": u for u in rule.units} or {stem: ""}
                    found[name] = FieldSpec(name, rule, declared.says, declared.default, keys)
        return found

    @classmethod
    @cache
    def keys(cls) -> dict[str, tuple[FieldSpec, str]]:
        """Return every key a file may use, with its entry and unit."""
        return {k: (e, u) for e in cls.entries().values() for k, u in e.keys.items()}

    @classmethod
    def read(cls, here: NodeReader) -> Any:
        """Return what a node of the file describes; note everything wrong with it."""
        root = here.node
        if not isinstance(root, Mapping):
            TableField(cls).reject(here)
        before, spoilt = len(here.context.problems), False
        if cls.fixed:
            here = replace(here, fixed=True)
        used: StatedTableEntries = {}
        values: dict[str, Any] = {}
        meant: set[str] = set()
        for written, node in root.entries.values():
            entry, unit = cls.keys().get(written.text, (None, ""))
            if entry is None:
                guess, hint = _advice(cls, written.text, node)
                meant.add(guess)
                here.child(written, written.text).add_issue("unknown key", hint)
            elif entry.name in used:
                first = used[entry.name][0].text
                message = f"{first} gives this already"
                here.child(written, written.text).add_issue(message, "keep one of them")
            else:
                used[entry.name] = written, node
                place = here.child(node, written.text, unit)
                place.record_location(written)
                try:
                    values[entry.name] = entry.field.read(place)
                    _doubt(entry, values[entry.name], place)
                except InvalidValueError:
                    spoilt = True
        cls._hold_together(here, used, meant)
        if spoilt or len(here.context.problems) > before:
            raise InvalidValueError
        table = cls.__new__(cls)
        for entry in cls.entries().values():
            table.__dict__[entry.name] = values.get(entry.name, entry.default)
        table.__dict__["_read_at"] = here, used
        made = table.attempt(table.build)
        if len(here.context.problems) > before:
            raise InvalidValueError
        return made

    @classmethod
    def _hold_together(cls, here: NodeReader, used: StatedTableEntries, meant: set[str]) -> None:
        """Note which keys are missing, and which exclude each other."""
        entries = cls.entries()
        for entry in entries.values():
            if entry.required and entry.name not in {*used, *meant}:
                here.add_issue(f"{entry.key_choices} is missing: {entry.description}")
        for names in cls.one_of + cls.at_most_one_of:
            given = sorted((used[n][0] for n in names if n in used), key=_in_order)
            if len(given) > 1:
                message = f"{given[0].text} and {given[1].text} exclude each other"
                here.child(given[1], given[1].text).add_issue(message, "keep one of them")
            elif not given and names in cls.one_of and not meant & set(names):
                *others, last = (next(iter(entries[n].keys)) for n in names)
                here.add_issue(f"needs {', '.join(others)} or {last}")

    @classmethod
    def schema(cls, defs: JsonSchema) -> JsonSchema:
        """Return a reference to this table's JSON Schema, which goes into `defs`."""
        name = cls.__name__.removesuffix("Table")
        if name not in defs:
            defs[name] = {}  # at once, so that a table may hold itself
            defs[name] = {
                "type": "object",
                "description": " ".join((cls.__doc__ or "").split("\n\n")[0].split()),
                "additionalProperties": False,
                "properties": {
                    k: {"description": e.schema_description(u), **e.field.schema(defs, u)}
                    for k, (e, u) in cls.keys().items()
                },
                **_demands(cls),
            }
        return {"$ref": f"#/$defs/{name}"}


class TableField(Field):
    """A table, and what it becomes."""

    node_types = (Mapping,)

    def __init__(self, table: type[Table]) -> None:
        self.table = table
        keys = [next(iter(e.keys)) for e in table.entries().values()]
        self.singular = f"a table with {', '.join(keys[:6])}{', ...' if len(keys) > 6 else ''}"
        self.plural = f"tables{self.singular.removeprefix('a table')}"

    def read(self, here: NodeReader) -> Any:
        """Return what the table becomes."""
        return self.table.read(here)

    def schema(self, defs: JsonSchema, unit: str) -> JsonSchema:  # noqa: ARG002  tables have no unit
        """Return a reference to the table's schema."""
        return self.table.schema(defs)


class LazyTableField(Field):
    """A table that few files have: what it takes is imported when one does."""

    node_types = (Mapping,)
    singular, plural = "a table", "tables"

    def __init__(self, module: str, table: str) -> None:
        self.table_path = module, table

    @cached_property
    def table_field(self) -> TableField:
        """The rule of the table itself."""
        module, table = self.table_path
        return TableField(getattr(import_module(module), table))

    def read(self, here: NodeReader) -> Any:
        """Return what the table becomes."""
        return self.table_field.read(here)

    def schema(self, defs: JsonSchema, unit: str) -> JsonSchema:
        """Return a reference to the table's schema."""
        return self.table_field.schema(defs, unit)


def _in_order(node: Node) -> tuple[int, int]:
    return node.line, node.column


def _demands(cls: type[Table]) -> JsonSchema:
    """Return what a schema says of keys that are needed or exclude each other."""
    entries = cls.entries()

    def given(*names: str) -> list[JsonSchema]:
        return [{"required": [k]} for n in names for k in entries[n].keys]

    needed = [k for e in entries.values() if e.required and len(e.keys) == 1 for k in e.keys]
    several = [e for e in entries.values() if len(e.keys) > 1]
    exactly = [(e.name,) for e in several if e.required] + list(cls.one_of)
    at_most = [(e.name,) for e in several if not e.required] + list(cls.at_most_one_of)
    groups: list[JsonSchema] = [{"oneOf": given(*names)} for names in exactly]
    groups += [{"oneOf": [*given(*names), {"not": {"anyOf": given(*names)}}]} for names in at_most]
    return ({"required": needed} if needed else {}) | ({"allOf": groups} if groups else {})


@cache
def field_of_annotation(annotation: Any) -> Field:
    """Return the rule an annotation stands for."""
    origin, args = get_origin(annotation), get_args(annotation)
    if origin is Annotated:
        return next((r for r in map(_as_rule, args[1:]) if r), None) or field_of_annotation(args[0])
    if origin in (Union, types.UnionType):
        rules = [field_of_annotation(a) for a in args if a is not type(None)]
        return rules[0] if len(rules) == 1 else UnionField(*rules)
    if origin is Literal:
        return EnumField(*args)
    if origin is tuple and args[-1] is Ellipsis:
        return ListField(field_of_annotation(args[0]))
    if origin is dict:
        return MappingField(field_of_annotation(args[0]), field_of_annotation(args[1]))
    plain: dict[Any, type[Field]] = {
        float: NumberField,
        int: IntegerField,
        str: TextField,
        bool: BooleanField,
    }
    return _as_rule(annotation) or plain[annotation]()


def _as_rule(said: Any) -> Field | None:
    if isinstance(said, type) and issubclass(said, Table):
        return TableField(said)
    return said if isinstance(said, Field) else None


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
        return name, f"the key names its unit: write {entries[name].key_choices}"
    if same := [k for k in keys if k.casefold() == name.casefold()]:
        return keys[same[0]][0].name, f"write {same[0]}"
    written = _unit_at_end(name)
    for entry in entries.values():
        unit_only = written and name == f"{entry.name}_{written}" and entry.field.units
        if unit_only or (len(entry.keys) > 1 and name.startswith(f"{entry.name}_")):
            return (
                entry.name,
                f"not in this unit: convert the number and write {entry.key_choices}",
            )
    for entry in entries.values():
        if any(name in table.keys() for table in _tables_in(entry.field)):  # noqa: SIM118
            return "", f"it belongs in {next(iter(entry.keys))}"
    found, hint = nearest_name(name, keys)
    if not found:
        return "", hint
    entry, unit = keys[found]
    return entry.name, f"{hint} its number is in {unit}" if written not in ("", unit) else hint


def _unit_at_end(name: str) -> str:
    """Return the unit that a key ends in, "" for none: the longest, of `_kN_m` not `_m`."""
    others = (other for units in OTHER_UNITS.values() for other in units)
    known = (unit for unit in (*UNITS, *others) if name.endswith(f"_{unit}"))
    return max(known, key=len, default="")


def _tables_in(rule: Field) -> list[type[Table]]:
    """Return the tables that an entry may hold directly."""
    if isinstance(rule, LazyTableField):
        rule = rule.table_field
    if isinstance(rule, TableField):
        return [rule.table]
    if isinstance(rule, UnionField):
        return [table for r in rule.alternatives for table in _tables_in(r)]
    return _tables_in(rule.item_field) if isinstance(rule, (ListField, MappingField)) else []


def _numbers_in(value: Any) -> list[float]:
    if isinstance(value, float):
        return [value]
    items = cast("tuple[Any, ...]", value) if isinstance(value, tuple) else ()
    if isinstance(value, dict):
        items = tuple(cast("dict[Any, Any]", value).values())
    return [x for item in items for x in _numbers_in(item)]


def _doubt(entry: FieldSpec, value: Any, here: NodeReader) -> None:
    """Warn where a number would be an everyday one in another unit.

    Of a list the largest number counts: small ones next to it are what they are.
    """
    if entry.field.usual is None:
        return
    size = max(map(abs, _numbers_in(value)), default=0.0)
    low, high = entry.field.usual
    if size == 0 or low <= size <= high:
        return
    worth = entry.field.units.get(here.unit, 1.0)
    odd = f"{size / worth:g}{' ' * bool(here.unit)}{here.unit} is unusually"
    number = NumberField(worth=entry.field.units, usual=entry.field.usual)
    other = number.other_unit_hint(size / worth, here.unit, entry.name.rstrip("_"))
    range_ = f"{low / worth:.4g} to {high / worth:.4g} is usual"
    here.warn(f"{odd} {'small' if size < low else 'large'}", other or f"check the unit; {range_}")
