"""What a file says, entry by entry, as the tables that read it declare it."""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np

from cardan.application.reader import ApplicationTable
from cardan.model.application import Application
from cardan.schema.field_types import Field, ListField, MappingField, UnionField
from cardan.schema.tables import LazyTableField, TableField
from cardan.schema.yaml_tree import Mapping, Node, Scalar, Sequence, parse_yaml


@dataclass(frozen=True, slots=True, kw_only=True)
class EnteredValue:
    """One entry of a file: a value, or a list of them.

    Attributes
    ----------
    address
        Its address, as errors print it.
    path
        The same without the numbers of items and without units: `driveline.shafts.tube.wall`.
        A * stands for a name that the user chose; each of several drivelines is a driveline.
    line
        Which of several drivelines it is of; "" elsewhere.
    values
        Each value by its own address, as it was written; a number that was changed as changed.
    """

    address: str
    path: str
    line: str
    values: tuple[tuple[str, str], ...]


def entered_values(application: Application) -> tuple[EnteredValue, ...]:
    """Return all that an application's file says, in its order; nothing where it has no file.

    Numbers of a catalogue's part stand in no file: of those only what was changed is listed.
    """
    written = application.written
    if written is None:
        return ()
    to = {at: _told(number) for at, number in written.changes.items()}
    found: list[EnteredValue] = []
    for one in _entries(written.text, written.name):
        values = tuple((at, to.pop(at, said)) for at, said in one.values)
        found.append(one if values == one.values else replace(one, values=values))
    beyond = (EnteredValue(address=at, path=at, line="", values=((at, v),)) for at, v in to.items())
    return (*found, *beyond)


def _told(number: object) -> str:
    """Return a number as a file says it; of variants the least and the most."""
    each = np.asarray(number, dtype=float)
    return " … ".join(f"{v:.12g}" for v in dict.fromkeys((float(each.min()), float(each.max()))))


@lru_cache(8)
def _entries(text: str, name: str) -> tuple[EnteredValue, ...]:
    root, _ = parse_yaml(text, name)
    top = EnteredValue(address="", path="", line="", values=())
    return tuple(_within(root, TableField(ApplicationTable), top))


def _within(node: Node, rule: Field, of: EnteredValue) -> Iterator[EnteredValue]:
    """Yield the entries of a node, which a rule reads."""
    if isinstance(rule, UnionField):
        rule = next(r for r in rule.alternatives if isinstance(node, r.node_types))
    if isinstance(rule, LazyTableField):
        rule = rule.table_field
    if isinstance(node, Mapping) and isinstance(rule, TableField):
        keys = rule.table.keys()
        for key, value in node.entries.values():
            entry, _ = keys[key.text]
            path = _joined(of.path, "driveline" if entry.name == "drivelines" else entry.name)
            one = replace(of, address=_joined(of.address, key.text), path=path)
            yield from _within(value, entry.field, one)
    elif isinstance(node, Mapping) and isinstance(rule, MappingField):
        for key, value in node.entries.values():
            one = replace(of, address=_joined(of.address, key.text), path=f"{of.path}.*")
            if of.address == "drivelines":
                one = replace(one, path=of.path, line=key.text)
            yield from _within(value, rule.item_field, one)
    elif isinstance(node, Sequence) and isinstance(rule, ListField) and _of_tables(node):
        for k, item in enumerate(node.items, 1):
            yield from _within(item, rule.item_field, replace(of, address=f"{of.address}[{k}]"))
    else:
        yield replace(of, values=tuple(_values(node, of.address)))


def _joined(above: str, key: str) -> str:
    return f"{above}.{key}" if above else key


def _of_tables(node: Sequence) -> bool:
    return any(isinstance(item, Mapping) for item in node.items)


def _values(node: Node, at: str) -> Iterator[tuple[str, str]]:
    """Yield the values of a value, or of a list of them, by their addresses."""
    if isinstance(node, Scalar):
        yield at, node.text
    elif isinstance(node, Sequence):
        for k, item in enumerate(node.items, 1):
            yield from _values(item, f"{at}[{k}]")
    else:
        for key, value in node.entries.values():
            yield from _values(value, _joined(at, key.text))
