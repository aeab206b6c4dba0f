"""What a file says, entry by entry, as the tables that read it declare it."""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np

from cardan.border.document import Mapping, Node, Scalar, Sequence, parse
from cardan.border.table import Later, ListOf, MapOf, OneOf, Rule, TableRule
from cardan.files.application import ApplicationTable
from cardan.model.application import Application


@dataclass(frozen=True, slots=True, kw_only=True)
class Entered:
    """One entry of a file: a value, or a list of them.

    Attributes
    ----------
    at
        Its address, as errors print it.
    path
        The same without the numbers of items and without units: `driveline.shafts.tube.wall`.
        A * stands for a name that the user chose; each of several drivelines is a driveline.
    line
        Which of several drivelines it is of; "" elsewhere.
    values
        Each value by its own address, as it was written; a number that was changed as changed.
    """

    at: str
    path: str
    line: str
    values: tuple[tuple[str, str], ...]


def entered(application: Application) -> tuple[Entered, ...]:
    """Return all that an application's file says, in its order; nothing where it has no file.

    Numbers of a catalogue's part stand in no file: of those only what was changed is told.
    """
    written = application.written
    if written is None:
        return ()
    to = {at: _told(number) for at, number in written.changes.items()}
    found: list[Entered] = []
    for one in _entries(written.text, written.name):
        values = tuple((at, to.pop(at, said)) for at, said in one.values)
        found.append(one if values == one.values else replace(one, values=values))
    beyond = (Entered(at=at, path=at, line="", values=((at, v),)) for at, v in to.items())
    return (*found, *beyond)


def _told(number: object) -> str:
    """Return a number as a file says it; of variants the least and the most."""
    each = np.asarray(number, dtype=float)
    return " … ".join(f"{v:.12g}" for v in dict.fromkeys((float(each.min()), float(each.max()))))


@lru_cache(8)
def _entries(text: str, name: str) -> tuple[Entered, ...]:
    root, _ = parse(text, name)
    top = Entered(at="", path="", line="", values=())
    return tuple(_within(root, TableRule(ApplicationTable), top))


def _within(node: Node, rule: Rule, of: Entered) -> Iterator[Entered]:
    """Yield the entries of a node, which a rule reads."""
    if isinstance(rule, OneOf):
        rule = next(r for r in rule.rules if isinstance(node, r.takes))
    if isinstance(rule, Later):
        rule = rule.rule
    if isinstance(node, Mapping) and isinstance(rule, TableRule):
        keys = rule.table.keys()
        for key, value in node.entries.values():
            entry, _ = keys[key.text]
            path = _joined(of.path, "driveline" if entry.name == "drivelines" else entry.name)
            one = replace(of, at=_joined(of.at, key.text), path=path)
            yield from _within(value, entry.rule, one)
    elif isinstance(node, Mapping) and isinstance(rule, MapOf):
        for key, value in node.entries.values():
            one = replace(of, at=_joined(of.at, key.text), path=f"{of.path}.*")
            if of.at == "drivelines":
                one = replace(one, path=of.path, line=key.text)
            yield from _within(value, rule.of, one)
    elif isinstance(node, Sequence) and isinstance(rule, ListOf) and _of_tables(node):
        for k, item in enumerate(node.items, 1):
            yield from _within(item, rule.of, replace(of, at=f"{of.at}[{k}]"))
    else:
        yield replace(of, values=tuple(_values(node, of.at)))


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
