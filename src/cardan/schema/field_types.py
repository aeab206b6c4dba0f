"""Fields of a table: how one entry is read, its errors and its JSON Schema."""

import re
from math import pi
from typing import (
    Any,
    NoReturn,
    TypeAlias,
)
from unicodedata import normalize

import numpy as np

from cardan.core.errors import values_of_first_violating_case
from cardan.core.units import UNITS
from cardan.core.units import g as G  # noqa: N812  as books have it
from cardan.schema.node_reader import NodeReader, collect_errors, nearest_name
from cardan.schema.quantity_parser import MARKED_ANGLE_PATTERN
from cardan.schema.yaml_tree import (
    ANGLE_UNITS,
    Mapping,
    Node,
    Scalar,
    Sequence,
    parse_number,
)

JsonSchema: TypeAlias = dict[str, Any]

MAX_NUMBER = 1e12
"""No number of a driveline is larger, in any unit; sums and products stay finite."""

MAX_NAME_CHARACTERS, MAX_PROSE_CHARACTERS = 200, 2000
"""Characters of a name, which must fit a line of a table; and of a note or a source."""

MAX_LIST_ITEMS, MAX_MAPPING_ENTRIES = 2000, 100
"""Items of a list, entries of a table of names, where nothing else is said."""


# --- rules: how one entry is read ---------------------------------------------------------


class Field:
    """How one kind of entry is read, and how errors and the schema describe it."""

    singular: str = "a value"
    plural: str = "values"
    node_types: tuple[type[Node], ...] = (Scalar,)
    units: dict[str, float] = {}  # noqa: RUF012  SI values of the units a key may end in
    usual: tuple[float, float] | None = None
    """Usual magnitudes (SI); outside them a unit may be wrong."""
    json: JsonSchema = {}  # noqa: RUF012  read only

    def read(self, here: NodeReader) -> Any:
        """Return what a node means, or note what is wrong and raise `InvalidValueError`."""
        raise NotImplementedError

    def schema(self, defs: JsonSchema, unit: str) -> JsonSchema:  # noqa: ARG002  for rules with parts
        """Return the JSON Schema of a node; `defs` collects the tables in it."""
        return self.json

    def reject(self, here: NodeReader, hint: str = "") -> NoReturn:
        """Note that a node is not what this rule reads, and give it up."""
        if isinstance(here.node, Scalar) and here.node.value is None:
            here.reject(f"has no value; it must be {self.singular}")
        here.reject(f"must be {self.singular}", hint, got=here.node.shortened_text)


OTHER_UNITS: dict[str, dict[str, float]] = {
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


class NumberField(Field):
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
        self.singular, self.plural = f"a number{self._zero}", f"numbers{self._zero}"

    @property
    def _convertible_units(self) -> dict[str, float]:
        """SI value of all units of its dimension, those that no key ends in too."""
        if not self.units:
            return {"": 1.0, "percent": UNITS["percent"]}
        others = {
            name.replace("/", "_").replace(" ", ""): si
            for known, more in OTHER_UNITS.items() if known in self.units
            for name, si in more.items()
        }  # fmt: skip
        return others | self.units

    @property
    def _zero(self) -> str:
        """What can be said of the bounds without a unit, which is all where there is none."""
        if not self.units and self._range(1.0):
            return self._range(1.0)
        if self._least == 0:
            return " of 0 or more"
        return " above 0" if max(self._above or 0, self._least or 0) > 0 or self._above == 0 else ""

    def read(self, here: NodeReader) -> float:
        """Return the number in SI."""
        value, hint = here.number(self._convertible_units)
        if value is None:
            self.reject(here, hint)
        worth = self.units.get(here.unit, 1.0)
        if not self._within(value * worth):
            message = f"must be a number{self._range(worth)} {here.unit}".rstrip()
            stem = re.sub(rf"(_{here.unit})?(\[\d+\])*$", "", here.address.rpartition(".")[2])
            here.reject(
                message,
                self.other_unit_hint(float(np.max(np.abs(value))), here.unit, stem),
                got=here.node.shortened_text,
            )
        if values_of_first_violating_case(abs(value) < MAX_NUMBER, value):
            here.reject(f"must be within ±{MAX_NUMBER:g}", got=here.node.shortened_text)
        return value * worth

    def other_unit_hint(self, written: float, unit: str, stem: str) -> str:
        """Return advice on a number that would be an everyday one in another unit."""
        if self.usual is None or not written:
            return ""
        low, high = self.usual
        own = [u for u, si in self.units.items() if low <= written * si <= high]
        if own:
            return f"did you mean {stem}_{own[0]}?" if unit not in own else ""
        for known, units in OTHER_UNITS.items():
            for name, si in units.items() if known in self.units else ():
                if low <= written * si <= high:
                    worth = written * si / self.units[unit]
                    return f"is it in {name}? then write {worth:.12g} {unit}"
        inverse = not self.units and low <= 1 / written <= high
        return f"is it the inverse of {1 / written:.4g}?" if inverse else ""

    def _within(self, si: float) -> bool:
        return not (
            (self._above is not None and values_of_first_violating_case(si > self._above, si))
            or (self._least is not None and values_of_first_violating_case(si >= self._least, si))
            or (self._below is not None and values_of_first_violating_case(si < self._below, si))
            or (self._most is not None and values_of_first_violating_case(si <= self._most, si))
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

    def schema(self, defs: JsonSchema, unit: str) -> JsonSchema:  # noqa: ARG002  it has no parts
        """Return the schema with the bounds in the key's unit."""
        worth = self.units.get(unit, 1.0)
        bounds = {
            "exclusiveMinimum": self._above,
            "minimum": self._least,
            "exclusiveMaximum": self._below,
            "maximum": self._most,
        }
        number: JsonSchema = {"type": "number"} | {
            name: float(f"{bound / worth:.12g}")
            for name, bound in bounds.items()
            if bound is not None
        }
        if unit not in ANGLE_UNITS:
            return number
        return {"anyOf": [number, {"type": "string", "pattern": MARKED_ANGLE_PATTERN}]}


class IntegerField(Field):
    """A whole number from 1 on, of things there are only so many of.

    `told` is the least value that messages name; what was once allowed below it is read, for its
    table to warn of.
    """

    def __init__(self, most: int = 1000, *, told: int = 1) -> None:
        self._most = most
        span = f"from {told} to {most}"
        self.singular, self.plural = f"a whole number {span}", f"whole numbers {span}"
        self.json = {"type": "integer", "minimum": told, "maximum": most}

    def read(self, here: NodeReader) -> int:
        """Return the number."""
        value = here.node.value
        if not isinstance(value, int) or isinstance(value, bool) or not 1 <= value <= self._most:
            self.reject(here, parse_number(here.node)[1] if isinstance(here.node, Scalar) else "")
        return value


class TextField(Field):
    """A text; a number will do, as it was written: joints are called 1810."""

    singular, plural = "a text", "texts"

    def __init__(self, most: int = MAX_NAME_CHARACTERS) -> None:
        self._most = most
        self.json = {"type": ["string", "number"], "maxLength": most}

    def read(self, here: NodeReader) -> Any:
        """Return the text."""
        return self.read_text_value(here)

    def read_text_value(self, here: NodeReader) -> str:
        """Return the text as it was written, on one line."""
        value = here.node.value
        if not isinstance(here.node, Scalar) or value is None or not _seen(here.node.text):
            self.reject(here)
        if isinstance(value, bool):
            self.reject(here, "put it in quotes if it is a name")
        text = here.node.text.strip()
        if len(text) > self._most:
            got = f"{len(text)} characters"
            here.reject(f"may have up to {self._most} characters", "shorten it", got=got)
        return " ".join(text.split()) if "\n" in text or "\t" in text else text


def _seen(text: str) -> bool:
    """Whether a text has anything to read."""
    return any(c.isprintable() and not c.isspace() for c in text)


class EnumField(Field):
    """One of some names."""

    def __init__(self, *names: str) -> None:
        self.names = names
        self.singular = self.plural = f"one of {', '.join(names)}"
        self.json = {"enum": list(names)}

    def read(self, here: NodeReader) -> Any:
        """Return the name."""
        if not isinstance(here.node, Scalar):
            self.reject(here)
        if here.node.text not in self.names:
            found, hint = nearest_name(here.node.text, self.names)
            self.reject(here, hint if found else "")
        return here.node.text


class BooleanField(Field):
    """True or false, in these words."""

    singular, plural = "true or false", "true or false"
    json: JsonSchema = {"type": "boolean"}  # noqa: RUF012  read only

    def read(self, here: NodeReader) -> bool:
        """Return which of the two."""
        value = here.node.value
        if not isinstance(value, bool):
            said = here.node.text.casefold() if isinstance(here.node, Scalar) else ""
            meant = {"yes": "true", "on": "true", "no": "false", "off": "false"}.get(said)
            self.reject(here, f"write {meant}" if meant else "")
        return value


class ListField(Field):
    """A list; of a fixed length where `names` says what its items are."""

    node_types = (Sequence,)

    def __init__(self, of: Field, *names: str, least: int = 0, most: int = MAX_LIST_ITEMS) -> None:
        self.item_field, self.names, self._least, self._most = of, names, least, most
        self.units, self.usual = of.units, of.usual
        count = f"{len(names)} {of.plural}, [{', '.join(names)}]" if names else of.plural
        self.singular, self.plural = f"a list of {count}", f"lists of {count}"

    def read(self, here: NodeReader) -> Any:
        """Return what its items mean."""
        if not isinstance(here.node, Sequence):
            self.reject(here)
        items = here.node.items
        if self.names and len(items) != len(self.names):
            self.reject(here)
        if len(items) < self._least:
            self.reject(here, f"give at least {self._least}")
        if len(items) > self._most:
            here.reject(f"may hold up to {self._most} items", got=f"{len(items)} items")
        places = [here.item(item, k) for k, item in enumerate(items, 1)]
        for place in places:
            place.record_location()
        return tuple(collect_errors(lambda p=p: self.item_field.read(p) for p in places))

    def schema(self, defs: JsonSchema, unit: str) -> JsonSchema:
        """Return the schema of the list and its items."""
        size: JsonSchema = {"minItems": self._least} if self._least else {}
        size |= {"maxItems": self._most}
        if self.names:
            size = {"minItems": len(self.names), "maxItems": len(self.names)}
        return {"type": "array", "items": self.item_field.schema(defs, unit), **size}


class MappingField(Field):
    """A table whose keys are names the user chooses, or numbers of parts."""

    node_types = (Mapping,)

    def __init__(self, key: Field, of: Field, *, most: int = MAX_MAPPING_ENTRIES) -> None:
        self.key_field, self.item_field, self._most = key, of, most
        self.units, self.usual = of.units, of.usual
        self.singular, self.plural = (
            f"a table from names to {of.plural}",
            f"tables from names to {of.plural}",
        )

    def read(self, here: NodeReader) -> Any:
        """Return what its entries mean, by name."""
        if not isinstance(here.node, Mapping):
            self.reject(here)

        if len(here.node.entries) > self._most:
            got = f"{len(here.node.entries)} entries"
            here.reject(f"may hold up to {self._most} entries", got=got)

        def entry(name: Scalar, node: Node) -> tuple[Any, Any]:
            places = here.child(name, name.text), here.child(node, name.text)
            places[1].record_location(name)
            key, value = collect_errors(
                (lambda: self.key_field.read(places[0]), lambda: self.item_field.read(places[1]))
            )
            printed = normalize("NFC", key) if isinstance(key, str) else key
            if printed in seen:
                places[0].reject("this name is given twice: names differ by more than spaces")
            seen.add(printed)
            read[key] = value
            return key, value

        read: dict[Any, Any] = {}
        seen: set[Any] = set()
        collect_errors(lambda n=n, v=v: entry(n, v) for n, v in here.node.entries.values())
        return read

    def schema(self, defs: JsonSchema, unit: str) -> JsonSchema:
        """Return the schema of the table and its entries."""
        numbered = {"propertyNames": {"pattern": "^[1-9][0-9]*$"}}
        return {
            "type": "object",
            "additionalProperties": self.item_field.schema(defs, unit),
            "maxProperties": self._most,
        } | (numbered if isinstance(self.key_field, IntegerField) else {})


class UnionField(Field):
    """Several rules, distinguished by how YAML writes what they read."""

    def __init__(self, *rules: Field) -> None:
        self.alternatives = rules
        self.units = next((r.units for r in rules if r.units), {})
        self.usual = next((r.usual for r in rules if r.usual), None)
        self.node_types = tuple(node for r in rules for node in r.node_types)
        self.singular = " or ".join(r.singular for r in rules)
        self.plural = " or ".join(r.plural for r in rules)

    def read(self, here: NodeReader) -> Any:
        """Return what the rule for this kind of node returns."""
        fitting = (rule for rule in self.alternatives if isinstance(here.node, rule.node_types))
        rule = next(fitting, None)
        if rule is None:
            self.reject(here, parse_number(here.node)[1] if isinstance(here.node, Scalar) else "")
        return rule.read(here)

    def schema(self, defs: JsonSchema, unit: str) -> JsonSchema:
        """Return the schema of any of the rules."""
        each = [r.schema(defs, unit) for r in self.alternatives]
        return {"anyOf": [one for s in each for one in (s["anyOf"] if [*s] == ["anyOf"] else [s])]}
