"""A place in a file while it is read: its node, its key, its unit, and what is wrong there."""

from collections.abc import Callable, Iterable
from collections.abc import Mapping as Mapped
from dataclasses import field
from pathlib import Path
from typing import (
    Any,
    NoReturn,
    TypeAlias,
    TypeVar,
)

import numpy as np

from cardan.core.arrays import ArrayLike
from cardan.core.errors import FileIssue, SourceLocation
from cardan.core.lazy_dataclass import dataclass
from cardan.schema.yaml_tree import (
    Node,
    Scalar,
    ScalarReplacedByVariant,
    parse_number,
    to_one_line,
)

T = TypeVar("T")

MAX_ISSUES = 100
"""Problems in a file before reading it further is useless."""


class TooManyIssuesError(Exception):
    """So much is wrong that the rest need not be read."""


class InvalidValueError(Exception):
    """Something read so far is wrong and noted: what was to be made of it cannot be."""


FileChangeStamp: TypeAlias = tuple[int, int, int]
"""When a file was last changed, its length, and which it is: another where the file is."""


def file_stamp(path: Path) -> FileChangeStamp:
    """Return what distinguishes a file from what it was before, without reading it."""
    try:
        status = path.stat()
    except (OSError, ValueError):
        return 0, -1, 0
    return status.st_mtime_ns, status.st_size, status.st_ino


@dataclass(frozen=True)
class ReferencedFile:
    """A file that another names: at which key, under what name, and as it was before it was read.

    `name` is None where it is not named by this text, but by a file that it names.
    """

    address: str
    name: str | None
    path: Path
    stamp: FileChangeStamp

    @property
    def is_unchanged(self) -> bool:
        """Return whether the file is still what it was."""
        return file_stamp(self.path) == self.stamp

    def is_named_at(self, at: str) -> bool:
        """Return whether it is named at an address, or in a list there."""
        return at == self.address or at.startswith(f"{self.address}[")


@dataclass
class TableReadContext:
    """What comes up while a file is read, and where the names in it are looked up.

    `changes` are numbers in place of the file's, by address; `numbers` is what was read at
    each address where variants may stand, `fixed_numbers` where only one number may.
    """

    catalogue: Any = None
    folder: Path | None = None
    allow_outside: bool = False
    """Whether files named in this one may lie outside its folder."""
    problems: list[FileIssue] = field(default_factory=list[FileIssue])
    warnings: list[FileIssue] = field(default_factory=list[FileIssue])
    changes: Mapped[str, ArrayLike] = field(default_factory=dict[str, ArrayLike])
    numbers: dict[str, ArrayLike] = field(default_factory=dict[str, ArrayLike])
    fixed_numbers: dict[str, ArrayLike] = field(default_factory=dict[str, ArrayLike])
    locations: dict[str, SourceLocation] = field(default_factory=dict[str, SourceLocation])
    """Where everything that was read stands, by its key."""
    referenced_files: list[ReferencedFile] = field(default_factory=list[ReferencedFile])
    """Files that this one names."""


@dataclass
class NodeReader:
    """A place in the file: a node, the key that leads to it and the unit that key names.

    `fixed` says that what stands here is no part of the design: it has no variants.
    """

    node: Node
    address: str
    context: TableReadContext
    unit: str = ""
    fixed: bool = False

    def child(self, node: Node, name: str, unit: str | None = None) -> "NodeReader":
        """Return the place of an entry of this table."""
        at = f"{self.address}.{name}" if self.address else name
        return NodeReader(node, at, self.context, self.unit if unit is None else unit, self.fixed)

    def item(self, node: Node, place: int) -> "NodeReader":
        """Return the place of an item of this list; places count from 1."""
        return NodeReader(node, f"{self.address}[{place}]", self.context, self.unit, self.fixed)

    def number(self, units: Mapped[str, float] | None = None) -> tuple[float | None, str]:
        """Return the number that stands here, or None with a hint on how to write one.

        `units` are those of its dimension, SI, for the hint.

        Kept under its address, and changed where a change requires that: then it may be
        an array of variants, (V, 1).
        """
        if not isinstance(self.node, Scalar):
            return None, ""
        if self.address in self.context.changes:
            to: Any = self.context.changes[self.address]
            spread = f"{np.min(to):g}" if np.ndim(to) == 0 else f"{np.min(to):g} ... {np.max(to):g}"
            self.node = ScalarReplacedByVariant(spread, self.node.line, self.node.column, number=to)
            if self.fixed and np.ndim(to):
                self.reject("is no part of the design: give it one number")
        value, hint = parse_number(self.node, self.unit, units)
        if value is not None:
            (self.context.fixed_numbers if self.fixed else self.context.numbers)[self.address] = (
                value
            )
        return value, hint

    def referenced_path(self, name: str) -> Path:
        """Return the path of a file named in this one, which must lie in its folder."""
        folder = self.context.folder
        if folder is None:
            self.reject("a text by itself has no files next to it", got=name)
        path = folder / name
        try:
            inside = path.resolve().is_relative_to(folder.resolve())
        except (OSError, RuntimeError, ValueError):  # links in a circle; no name of a file
            self.reject("no file can be found under this name", got=name)
        if not (inside or self.context.allow_outside):
            message = f"lies outside the folder of this file, {folder.resolve()}"
            self.reject(message, "put it next to this file, or use --allow-outside", got=name)
        self.context.referenced_files.append(
            ReferencedFile(self.address, name, path, file_stamp(path))
        )
        return path

    def record_location(self, written: Node | None = None) -> None:
        """Keep where this stands: a number where it is, a list or a table at its key."""
        node = self.node if written is None or isinstance(self.node, Scalar) else written
        self.context.locations[self.address] = SourceLocation(
            key=self.address, line=node.line, column=node.column
        )

    @property
    def position(self) -> tuple[int, int]:
        """Its line and column."""
        return self.node.line, self.node.column

    def add_issue(self, message: str, hint: str = "", *, got: str = "") -> None:
        """Note what is wrong here, and go on."""
        self.context.problems.append(self._problem(message, hint, got))
        if len(self.context.problems) >= MAX_ISSUES:
            raise TooManyIssuesError

    def reject(self, message: str, hint: str = "", *, got: str = "") -> NoReturn:
        """Note what is wrong here, and give up what was to be read."""
        self.add_issue(message, hint, got=got)
        raise InvalidValueError

    def warn(self, message: str, hint: str = "") -> None:
        """Note what looks wrong here but can be read."""
        self.context.warnings.append(self._problem(message, hint, ""))

    def _problem(self, message: str, hint: str, got: str) -> FileIssue:
        message, key, value, hint = map(to_one_line, (message, self.address, got, hint))
        line, column = self.node.line, self.node.column
        return FileIssue(message=message, key=key, value=value, hint=hint, line=line, column=column)


def nearest_name_hint(name: str, names: Iterable[str]) -> str:
    """Return advice on an unknown name: the nearest known one, or all there are."""
    return nearest_name(name, names)[1]


def nearest_name(name: str, names: Iterable[str]) -> tuple[str, str]:
    """Return the known name nearest to one, or "", and advice on it."""
    from difflib import get_close_matches  # needed in bad files alone

    folded = {n.casefold(): n for n in names}
    if close := get_close_matches(name.casefold(), list(folded), n=1, cutoff=0.6):
        found = folded[close[0]]
        return found, f"did you mean {found}?"
    known = list(folded.values())
    more = f" and {len(known) - 20} more" if len(known) > 20 else ""
    return "", f"there are: {', '.join(known[:20])}{more}" if known else "there are none"


def collect_errors(tries: Iterable[Callable[[], T]]) -> list[T]:
    """Return the results of all tries; if one is spoilt, only after the last was made."""
    results: list[T] = []
    spoilt = False
    for attempt in tries:
        try:
            results.append(attempt())
        except InvalidValueError:
            spoilt = True
    if spoilt:
        raise InvalidValueError
    return results
