"""A text with some of its values written anew: comments, order and all else stay as they are.

An address is a key as errors print it. A value that stands in the text is replaced where it
stands; a key that its table does not give is put in front of the table's others.
"""

import re
from collections.abc import Iterator, Mapping
from typing import Any

from cardan.core.errors import FileIssue, InvalidFileError
from cardan.schema.yaml_tree import Mapping as TableNode
from cardan.schema.yaml_tree import Node, Scalar, Sequence, parse_yaml

_LINE = re.compile(r"[^\r\n]*(?:\r\n|\r|\n|\Z)")
_PLAIN = re.compile(r"[A-Za-z0-9][A-Za-z0-9 ._/x-]*")
"""Texts that need no quotes wherever they stand."""
_QUOTED = re.compile(r"\"(?:[^\"\\]|\\.)*\"|'(?:[^']|'')*'", re.DOTALL)
_NAMED = re.compile(r"[^\s:#'\"]+[ \t]*:[ \t]+(\*[^\s,\]}]+)")
"""A key with a name in place of its value."""
_ITEM = re.compile(r" *- +")
"""What stands in a line before an item of a list that has a line of its own."""
_AHEAD = re.compile(r"(?: |- )*")
"""What may stand in a line before the first key of a table."""


class RawYaml(str):
    """A value that is written as it is: a table or a list on one line."""

    __slots__ = ()


class YamlEditor:
    """A text that knows where each of its values stands.

    Raises
    ------
    InvalidFileError
        If the text is no YAML.
    """

    def __init__(self, text: str, name: str = "application") -> None:
        self.text, self.name = text, name
        root, _ = parse_yaml(text, name)
        self._starts: list[int] = [m.start() for m in _LINE.finditer(text)]
        self._nodes: dict[str, Node] = {}
        self._shared: set[int] = set()
        seen: set[int] = set()
        for at, node in _walk(root, ""):
            self._nodes[at] = node
            if id(node) in seen:
                self._shared.add(id(node))  # a name stands for it in several places
            seen.add(id(node))

    def __contains__(self, address: str) -> bool:
        """Return whether something stands at an address."""
        return address in self._nodes

    @property
    def addresses(self) -> tuple[str, ...]:
        """Every address at which something stands, tables and lists too."""
        return tuple(self._nodes)

    def scalar_text(self, address: str) -> str | None:
        """Return a single value as it was written; None where there is none."""
        node = self._nodes.get(address)
        return node.text if isinstance(node, Scalar) else None

    def scalar_ends(self) -> Iterator[tuple[str, int, int]]:
        """Yield address and line of each single value, and the column behind it, from 0."""
        for at, node in self._nodes.items():
            if isinstance(node, Scalar):
                yield at, node.line, self._span(node)[1] - self._starts[node.line - 1]

    def line_of_key(self, address: str) -> int | None:
        """Return the line of the key of a table or list, from 1; None where there is none."""
        above, _, key = address.rpartition(".")
        table = self._nodes.get(above)
        if not isinstance(table, TableNode) or key not in table.entries:
            return None
        return table.entries[key][0].line

    def with_changes(self, changes: Mapping[str, float | str | list[Any]]) -> str:
        """Return the text with other values, numbers in the units of their keys.

        Raises
        ------
        InvalidFileError
            If a value cannot be written where it would stand: a name stands there for a value
            given elsewhere, or its table is not in the text. Nothing is written then.
        """
        edits = sorted((self._edit(at, to) for at, to in changes.items()), reverse=True)
        text = self.text
        for start, end, new in edits:
            text = text[:start] + new + text[end:]
        return text

    def _edit(self, at: str, to: float | str | list[Any]) -> tuple[int, int, str]:
        """Return from where to where a change goes, and what it puts there.

        `[+]` at the end of an address is a new item of a list, or some, before its others; the
        list is there from then on. `[-]` takes the item that reads so out of it.
        """
        if at.endswith("[+]"):
            return self._item(at.removesuffix("[+]"), to)
        if at.endswith("[-]"):
            return self._without(at.removesuffix("[-]"), str(to))
        node = self._nodes.get(at)
        if node is None:
            return self._insertion(at, to)
        if id(node) in self._shared:
            if used := self._used(at):
                return *used, format_as_yaml_value(
                    to, ""
                )  # here alone; elsewhere the name stands for it as before
            raise self._refused(at, node, "*names stand for it in other places: change it by hand")
        if not isinstance(node, Scalar):
            raise self._refused(at, node, "is a table or a list: change what stands in it")
        start = self._offset(node)
        if node.quoted:
            found = _QUOTED.match(self.text, start)
            if found is None:
                raise self._refused(at, node, "is written in a way that has to be changed by hand")
            return start, found.end(), format_as_yaml_value(to, "")
        if not self._is(start, node.text) or not node.text:
            raise self._refused(at, node, "is written in a way that has to be changed by hand")
        return start, start + len(node.text), format_as_yaml_value(to, node.text)

    def _used(self, at: str) -> tuple[int, int] | None:
        """Return where a name stands for a value, `key: *name`; None where it is not so."""
        above, _, key = at.rpartition(".")
        table = self._nodes.get(above)
        if (
            not isinstance(table, TableNode)
            or id(table) in self._shared
            or key not in table.entries
        ):
            return None
        found = _NAMED.match(self.text, self._offset(table.entries[key][0]))
        return found.span(1) if found else None

    def _item(self, at: str, to: float | str | list[Any]) -> tuple[int, int, str]:
        """Return the change that puts an item into a list, before the others."""
        node, given = self._nodes.get(at), to if isinstance(to, list) else [to]
        if node is None:
            return self._insertion(at, given)
        if not isinstance(node, Sequence) or id(node) in self._shared:
            problem = FileIssue(message="is no list that an item can be put into", key=at)
            raise InvalidFileError(self.name, (problem,))
        start = self._offset(node)
        items = [format_as_yaml_value(item, "") for item in given]
        if self._is(start, "["):
            after = ", " if node.items else ""
            return start + 1, start + 1, ", ".join(items) + after
        breaks = "\r\n" if "\r\n" in self.text else "\n"
        after = breaks + " " * (node.column - 1)
        return start, start, "".join(f"- {item}{after}" for item in items)

    def _without(self, at: str, said: str) -> tuple[int, int, str]:
        """Return the change that takes an item out of a list; the list stays, if empty."""
        node = self._nodes.get(at)
        items = node.items if isinstance(node, Sequence) and id(node) not in self._shared else ()
        spots = [(item, *self._span(item)) for item in items if isinstance(item, Scalar)]
        k = next((k for k, (item, _, _) in enumerate(spots) if item.text == said), None)
        if node is None or k is None or len(spots) != len(items):
            problem = FileIssue(message=f"has no {said!r} of its own to take out", key=at)
            raise InvalidFileError(self.name, (problem,))
        _, start, end = spots[k]
        first, flow = self._offset(node), self._is(self._offset(node), "[")
        if len(items) == 1:
            return (start, end, "") if flow else (first, end, "[]")
        if flow:
            last = k + 1 == len(items)
            return (spots[k - 1][2], end, "") if last else (start, spots[k + 1][1], "")
        line = self._starts[items[k].line - 1]
        if not _ITEM.fullmatch(self.text, line, start):
            raise self._refused(at, node, "is written in a way that has to be changed by hand")
        found = _LINE.match(self.text, end)
        return line, found.end() if found else end, ""

    def _span(self, of: Scalar) -> tuple[int, int]:
        """Return from where to where a single value stands."""
        start = self._offset(of)
        found = _QUOTED.match(self.text, start) if of.quoted else None
        return start, found.end() if found else start + len(of.text)

    def _insertion(self, at: str, to: float | str | list[Any]) -> tuple[int, int, str]:
        """Return the change that puts a key into its table, before the others."""
        above, _, key = at.rpartition(".")
        table = self._nodes.get(above)
        if not isinstance(table, TableNode) or not table.entries or id(table) in self._shared:
            problem = FileIssue(
                message="does not stand in the file, nor does the table it belongs to", key=at
            )
            raise InvalidFileError(self.name, (problem,))
        said = f"{key}: {format_as_yaml_value(to, '')}"
        start = self._offset(table)
        if self._is(start, "{"):
            return start + 1, start + 1, f"{said}, "
        first = next(iter(table.entries.values()))[0]
        start = self._offset(first)
        if not _AHEAD.fullmatch(self.text, self._starts[first.line - 1], start):
            raise self._refused(at, table, "is written in a way that has to be changed by hand")
        breaks = "\r\n" if "\r\n" in self.text else "\n"
        return start, start, f"{said}{breaks}{' ' * (first.column - 1)}"

    def _offset(self, node: Node) -> int:
        return self._starts[node.line - 1] + node.column - 1

    def _is(self, start: int, said: str) -> bool:
        return self.text.startswith(said, start)

    def _refused(self, at: str, node: Node, message: str) -> InvalidFileError:
        problem = FileIssue(message=message, key=at, line=node.line, column=node.column)
        return InvalidFileError(self.name, (problem,))


def _walk(node: Node, at: str) -> Iterator[tuple[str, Node]]:
    """Yield every node with its address, as errors print it."""
    yield at, node
    if isinstance(node, TableNode):
        for name, (_, inside) in node.entries.items():
            yield from _walk(inside, f"{at}.{name}" if at else name)
    elif isinstance(node, Sequence):
        for k, item in enumerate(node.items, 1):
            yield from _walk(item, f"{at}[{k}]")


def format_as_yaml_value(to: float | str | list[Any], like: str) -> str:
    """Return a value as it is written, a number with as many decimals as stood there."""
    if isinstance(to, list):
        return f"[{', '.join(format_as_yaml_value(t, '') for t in to)}]"
    if isinstance(to, RawYaml):
        return to
    if isinstance(to, str):
        plain = _PLAIN.fullmatch(to) and isinstance(Scalar(to, 1, 1).value, str)
        return to if plain and not to.endswith(" ") else '"' + _escaped(to) + '"'
    short = f"{to + 0.0:.12g}"
    if "e" in short:
        return short
    decimals = len(like.partition(".")[2]) if re.fullmatch(r"[-+]?\d+\.\d+", like) else 0
    return max(short, f"{to + 0.0:.{decimals}f}", key=len)


def _escaped(text: str) -> str:
    return text.replace("\\", "\\\\").replace('"', '\\"')
