"""A YAML text as a tree that knows where everything stands.

libyaml gives the events; what they mean is decided here, after YAML 1.2. A word is a text
unless it plainly is a number, true or false: `no` is not false, 1:30 not ninety, and what
other readers of YAML take in different ways (010, 2,7, 1 800) is never taken at all.
"""

import codecs
import re
import unicodedata
from collections.abc import Mapping as Mapped
from dataclasses import field
from pathlib import Path
from stat import S_ISREG
from typing import Any, TypeAlias

from cardan.core.errors import FileIssue, InvalidFileError
from cardan.core.lazy_dataclass import dataclass
from cardan.core.units import UNITS
from cardan.schema import quantity_parser as byhand

MAX_FILE_CHARACTERS = 2_000_000
"""Characters in a file: a truck needs some thousands, a linkage table from CAD many more."""
MAX_NESTING_DEPTH = 32
"""Tables within tables within lists."""
MAX_NUMBER_CHARACTERS = 60
"""Characters of a number; what is longer is a text, and not searched for mistakes."""
MAX_ENTRIES_AFTER_ALIAS_EXPANSION = 200_000
"""Entries of a file once its references (*name) are written out."""


@dataclass(slots=True, eq=False)
class Scalar:
    """A single value, as it was written; `line` and `column` count from 1."""

    text: str
    line: int
    column: int
    quoted: bool = False

    @property
    def value(self) -> bool | int | float | str | None:
        """What the text means."""
        if self.quoted:
            return self.text
        if self.text in _WORDS:
            return _WORDS[self.text]
        if len(self.text) > MAX_NUMBER_CHARACTERS or _ZERO_AHEAD.match(self.text):
            return self.text
        if not _NUMBER.fullmatch(self.text):
            return self.text
        return int(self.text) if self.text.lstrip("+-").isdigit() else float(self.text)

    @property
    def shortened_text(self) -> str:
        """The value as an error shows it."""
        shown = to_one_line(repr(self.text) if self.quoted else (self.text or "nothing"))
        return shown if len(shown) <= 40 else f"{shown[:37]}..."


@dataclass(slots=True, eq=False)
class ScalarReplacedByVariant(Scalar):
    """A number in place of the one written: a single one, or the variants of a study."""

    number: Any = 0.0

    @property
    def value(self) -> Any:
        """The number, or an array of them."""
        return self.number


@dataclass(slots=True, eq=False)
class Sequence:
    """A list."""

    line: int
    column: int
    items: "list[Node]" = field(default_factory=list["Node"])

    @property
    def value(self) -> list[Any]:
        """What the list means, as plain Python."""
        return [item.value for item in self.items]

    @property
    def shortened_text(self) -> str:
        """The list as an error shows it."""
        return "an empty list" if not self.items else f"a list of {len(self.items)}"


@dataclass(slots=True, eq=False)
class Mapping:
    """A table: each key with its own place, and its value."""

    line: int
    column: int
    entries: "dict[str, tuple[Scalar, Node]]" = field(
        default_factory=dict[str, "tuple[Scalar, Node]"]
    )

    @property
    def value(self) -> dict[str, Any]:
        """What the table means, as plain Python."""
        return {key: node.value for key, (_, node) in self.entries.items()}

    @property
    def shortened_text(self) -> str:
        """The table as an error shows it."""
        return "a table" if self.entries else "an empty table"


Node: TypeAlias = Scalar | Sequence | Mapping

_WORDS: dict[str, bool | None] = {
    "": None, "~": None, "null": None, "Null": None, "NULL": None,
    "true": True, "True": True, "TRUE": True, "false": False, "False": False, "FALSE": False,
}  # fmt: skip
_NUMBER = re.compile(r"[-+]?(\d+(\.\d*)?|\.\d+)([eE][-+]?\d+)?", re.ASCII)
_ZERO_AHEAD = re.compile(r"[-+]?0\d", re.ASCII)

ANGLE_UNITS = ("deg", "rad")
"""Units of keys that angles in degrees, minutes and seconds are read under."""

_TRAPS = (
    (r"([-+]?)0+(\d+(?:\.\d*)?)",
     r"some readers take a leading 0 as octal: write \1\2"),
    (r"[-+]?\d{1,3}(,\d{3})+",
     "thousands or decimals? write a point before decimals and nothing between thousands"),
    (r"([-+]?\d+),(\d+)",
     r"write a decimal point: \1.\2"),
    ("[-+]?\\d{1,3}([ \u00a0\u2009\u202f'_]\\d{3})+([.,]\\d*)?",
     "write the digits without anything between them"),
    (r"[-+]?\d[\d_]*(\.[\d_]*)?",
     "write the digits without anything between them"),
    (r"[-+]?\d+(:\d+(\.\d*)?)+",
     "some readers take a colon as minutes: write one decimal number"),
    (r"(?i)[-+]?\.?(inf(inity)?|nan)",
     "it must be finite"),
    (r"0[xXoObB]\w+",
     "write it in decimal digits"),
    ("[\u2212\u2013\u2014](\\d+(?:\\.\\d*)?)",
     r"the minus sign is a dash: write -\1"),
)  # fmt: skip


def to_one_line(text: str) -> str:
    """Return a text as a line of an error can hold it: nothing that moves a cursor."""
    return text if text.isprintable() else "".join(c if c.isprintable() else " " for c in text)


def parse_number(
    scalar: Scalar, unit: str = "", units: Mapped[str, float] | None = None
) -> tuple[float | None, str]:
    """Return the number a scalar is, or None with a hint on how to write one.

    Parameters
    ----------
    scalar
        The text.
    unit
        The unit its key names; where that is one of angles, degrees and minutes are read too.
    units
        SI value of each unit of that dimension, for hints: they never change what was meant.
    """
    value = scalar.value
    if isinstance(scalar, ScalarReplacedByVariant):
        return scalar.number, ""
    if isinstance(value, (int, float)) and not isinstance(value, bool):
        return float(value), ""
    text = scalar.text.strip()
    if len(text) > MAX_NUMBER_CHARACTERS:
        return None, ""
    if scalar.quoted and _NUMBER.fullmatch(text):
        return None, f"a text in quotes is no number: write {text}"
    if unit in ANGLE_UNITS and (angle := byhand.parse_marked_angle(text)) is not None:
        return angle * UNITS["deg"] / UNITS[unit], ""
    for trap, hint in _TRAPS:
        if found := re.fullmatch(trap, text, re.ASCII):
            return None, found.expand(hint)
    return None, byhand.decimal_number_hint(text, unit=unit, units=units)


def parse_yaml(text: str, file: str) -> tuple[Node, list[FileIssue]]:
    """Return the tree of a YAML text, with what is wrong but does not stop the reading.

    Raises
    ------
    InvalidFileError
        If the text is no YAML, or not what this program reads of it.
    """
    from yaml import YAMLError
    from yaml.cyaml import CParser  # type: ignore[attr-defined]  # its stubs forget it

    if len(text) > MAX_FILE_CHARACTERS:
        raise InvalidFileError(file, (_too_long(str(len(text))),))
    reject_hidden_characters(text, file)
    try:
        return _TreeBuilder(CParser(text)).grow()
    except YAMLError as error:
        raise InvalidFileError(file, (_explained(error, text),)) from None
    except _ParseError as refused:
        raise InvalidFileError(file, (refused.problem,)) from None


class _ParseError(Exception):
    def __init__(self, mark: Any, message: str, hint: str = "", key: str = "") -> None:
        self.problem = _at(mark, message, hint, key)


class _TOP:
    line = column = 0


def _at(mark: Any, message: str, hint: str = "", key: str = "") -> FileIssue:
    message = to_one_line(message)  # a tag may hold anything
    return FileIssue(
        message=message, hint=hint, key=key, line=mark.line + 1, column=mark.column + 1
    )


@dataclass(slots=True)
class _OpenNode:
    """A list or table whose end has not come yet."""

    node: Sequence | Mapping
    anchor: str | None
    flow: bool
    key: Scalar | None = None
    size: int = 1
    last: Any = None
    whole: bool = False
    """Where the item before ended, and whether it was a bare whole number."""
    tight: Any = None
    loose: bool = False
    """Whether two whole numbers had just a comma between them, and other items more."""


class _TreeBuilder:
    """Grows the tree from libyaml's events; no recursion, whatever the file says."""

    def __init__(self, parser: Any) -> None:
        self.events = iter(parser.get_event, None)
        self.problems: list[FileIssue] = []
        self.open: list[_OpenNode] = []
        self.known: dict[str, tuple[Node, int]] = {}
        self.root: Node | None = None
        self.size = 0

    def grow(self) -> tuple[Node, list[FileIssue]]:
        for event in self.events:
            # The event's class by its name: importing yaml.events costs more than this.
            handle = getattr(self, f"_{type(event).__name__}", None)
            if handle:
                handle(event)
        if self.root is None:
            raise _ParseError(_TOP, "the file is empty", "`cardan new` writes one to start from")
        return self.root, self.problems

    def _DocumentStartEvent(self, event: Any) -> None:  # noqa: N802  libyaml's name
        if self.root is not None:
            raise _ParseError(
                event.start_mark, "a second document starts here", "one file holds one"
            )

    def _ScalarEvent(self, event: Any) -> None:  # noqa: N802
        mark, plain = event.start_mark, not event.style
        if found := _hidden(event.value, _HIDDEN_WRITTEN):
            raise _ParseError(mark, f"{_called(found[0])} is in this text", _REMOVE)
        scalar = Scalar(event.value, mark.line + 1, mark.column + 1, not plain)
        self._untagged(event)
        if self.open and self.open[-1].flow and isinstance(self.open[-1].node, Sequence):
            self._watch_commas(self.open[-1], scalar, event)
        self._place(scalar, event)
        if event.anchor:
            self.known[event.anchor] = scalar, 1

    def _AliasEvent(self, event: Any) -> None:  # noqa: N802
        if event.anchor not in self.known:
            # Known once closed, so that nothing can hold itself.
            message = f"*{event.anchor} stands for nothing above it"
            raise _ParseError(event.start_mark, message, f"name it first with &{event.anchor}")
        node, size = self.known[event.anchor]
        self._place(node, event, size)

    def _SequenceStartEvent(self, event: Any) -> None:  # noqa: N802
        self._start(Sequence(event.start_mark.line + 1, event.start_mark.column + 1), event)

    def _MappingStartEvent(self, event: Any) -> None:  # noqa: N802
        self._start(Mapping(event.start_mark.line + 1, event.start_mark.column + 1), event)

    def _start(self, node: Sequence | Mapping, event: Any) -> None:
        self._untagged(event)
        if len(self.open) == MAX_NESTING_DEPTH:
            raise _ParseError(event.start_mark, _TOO_DEEP)
        self._place(node, event)
        self.open.append(_OpenNode(node, event.anchor, bool(event.flow_style)))

    def _SequenceEndEvent(self, _: Any) -> None:  # noqa: N802
        done = self._end()
        if done.tight and done.loose:
            self.problems.append(
                _at(
                    done.tight,
                    "some commas of this list stand without a space: is one a decimal comma?",
                    "write a point before decimals and a space after every comma",
                )
            )

    def _MappingEndEvent(self, _: Any) -> None:  # noqa: N802
        self._end()

    def _end(self) -> _OpenNode:
        done = self.open.pop()
        if done.anchor:
            self.known[done.anchor] = done.node, done.size
        if self.open:
            self.open[-1].size += done.size - 1
        return done

    def _place(self, node: Node, event: Any, size: int = 1) -> None:
        """Put a node where it belongs: root, list item, key or value."""
        self.size += size
        if self.size > MAX_ENTRIES_AFTER_ALIAS_EXPANSION:
            message = (
                "with its references written out the file has over "
                f"{MAX_ENTRIES_AFTER_ALIAS_EXPANSION} entries"
            )
            raise _ParseError(event.start_mark, message)
        if not self.open:
            self.root = node
            return
        here = self.open[-1]
        here.size += size
        if isinstance(here.node, Sequence):
            here.node.items.append(node)
        elif here.key is None:
            here.key = self._key(node, event)
        else:
            key, here.key = here.key, None
            if before := here.node.entries.get(key.text):
                self.problems.append(
                    FileIssue(
                        message=f"given twice, first in line {before[0].line}",
                        hint="keep one",
                        key=to_one_line(key.text),
                        line=key.line,
                        column=key.column,
                    )
                )
            else:
                here.node.entries[key.text] = key, node

    def _key(self, node: Node, event: Any) -> Scalar:
        mark = event.start_mark
        if not isinstance(node, Scalar):
            raise _ParseError(mark, "a key must be a word", "is this list or table a value?")
        if node.text == "" and not node.quoted:
            raise _ParseError(mark, "a key is missing before the colon")
        if node.text == "<<":
            hint = "write the keys out, or refer to a whole table with *name"
            raise _ParseError(mark, "merging tables with << is not part of YAML 1.2", hint)
        return node

    def _untagged(self, event: Any) -> None:
        if event.tag is not None:
            raise _ParseError(event.start_mark, f"tags like {event.tag} are not used", "remove it")

    @staticmethod
    def _watch_commas(here: _OpenNode, scalar: Scalar, event: Any) -> None:
        """Notice `[2,7, 3,5]`, which YAML reads as four numbers."""
        start, before = event.start_mark, here.last
        if before and before.line == start.line:
            if start.column - before.column > 1:
                here.loose = True
            elif here.whole and not scalar.quoted and scalar.text.isdigit():
                here.tight = here.tight or before
        here.last = event.end_mark
        here.whole = not scalar.quoted and scalar.text.lstrip("+-").isdigit()


# What ends a line for libyaml and for no editor, what is no character at all, what turns the
# order of the characters around it, and what is invisible: Unicode's Default_Ignorable_Code_Point
# and the marks of annotations. Without them two names that look alike are one.
_HIDDEN = (
    "\x00-\x08\x0b\x0c\x0e-\x1f\x7f-\x9f\u2028\u2029\ud800-\udfff\ufdd0-\ufdef"
    "\xad\u034f\u061c\u115f\u1160\u17b4\u17b5\u180b-\u180f\u200b-\u200f\u202a-\u202e"
    "\u2060-\u206f\u3164\ufe00-\ufe0f\ufeff\uffa0\ufff9-\ufffb\ufff0-\ufff8"
    "\U0001bca0-\U0001bca3\U0001d173-\U0001d17a\U000e0000-\U000e0fff"
    + "".join(chr(plane << 16 | last) for plane in range(17) for last in (0xFFFE, 0xFFFF))
)
_JOINED = "(?<![\u2190-\u2bff\U0001f000-\U0001faff\ufe0f])[\u200d\ufe0f]"
"""A joiner or a selector that follows no symbol; behind one it makes a picture of several."""
_CONTROL = f"(?![\u200d\ufe0f])[{_HIDDEN}]|{_JOINED}"
_HIDDEN_WRITTEN = f"(?![\u200d\ufe0f])[{_HIDDEN}\r]|{_JOINED}"
"""In a text as it is meant: a carriage return, too, hides what stands before it."""
_ANY_OF_THEM = re.compile(f"[{_HIDDEN}\r]")
"""A class alone is found quickly: most texts have none."""
_REMOVE = "it can make a text look like another: remove it"


def _hidden(text: str, kinds: str) -> "re.Match[str] | None":
    return re.search(kinds, text) if _ANY_OF_THEM.search(text) else None


def reject_hidden_characters(text: str, file: str) -> None:
    """Refuse a text with invisible characters, or that change how others are seen.

    Raises
    ------
    InvalidFileError
        With the line and column of the first one.
    """
    if found := _hidden(text, _CONTROL):
        raise InvalidFileError(file, (_control_character(text, found.start()),))


def replace_hidden_characters(text: str) -> str:
    """Return a text from outside with a space for every invisible character."""
    return to_one_line(re.sub(_HIDDEN_WRITTEN, " ", text)).strip()


def _called(character: str) -> str:
    """Return what a character is called: right-to-left override (U+202E)."""
    kinds = {"Cc": "a control character", "Cn": "a code of no character", "Cs": "half a character"}
    kind = kinds.get(unicodedata.category(character), "")
    return f"{kind or unicodedata.name(character).lower()} (U+{ord(character):04X})"


def _control_character(text: str, place: int) -> FileIssue:
    line = text.count("\n", 0, place) + 1
    seen = unicodedata.category(text[place]) in ("Cf", "Mn", "Lo")
    return FileIssue(
        message=f"{_called(text[place])} stands here",
        hint=_REMOVE if seen else "is this a text file? save it as UTF-8",
        line=line,
        column=place - (text.rfind("\n", 0, place) + 1) + 1,
    )


_TOO_DEEP = f"lists and tables may be nested {MAX_NESTING_DEPTH} deep"

_EXPLAINED = (
    # libyaml of PyYAML 6.0.4 has a limit of its own, which a list meets before its first event.
    ("maximum nesting depth", _TOO_DEEP, ""),
    ("tab character", "a tab indents this line", "YAML indents with spaces"),
    ("mapping values are not allowed",
     "a second colon makes no sense here",
     "is the line above indented like this one, with a space after its colon? "
     "put a text that holds ': ' in quotes"),
    ("expected ',' or ']'", "a list is not closed, or a comma is missing", "check [ and ]"),
    ("expected ',' or '}'", "a table is not closed, or a comma is missing", "check { and }"),
    ("could not find expected ':'", "a key without its colon",
     "write `key: value`, with a space after the colon"),
    ("unexpected ':'", "a value is missing after this colon, or a space", "write `key: value`"),
    ("did not find expected key", "this line does not fit the lines above it",
     "indent keys of one table alike, and close quotes and brackets"),
    ("expected '-' indicator", "this line does not fit the list above it",
     "start every item with `- `, or indent its keys alike"),
    ("block sequence entries are not allowed", "a list cannot start here",
     "put `- ` on a line of its own below the key"),
    ("found unexpected end of stream", "a quote is opened and never closed", "check quotes"),
    ("expected node content", "a value is missing", "check the commas and brackets before it"),
    ("cannot start any token", "this character cannot start a value", "put the text in quotes"),
    ("did not find expected <document start>", "something follows the end of the file's table",
     "indent keys of one table alike"),
)  # fmt: skip


def _explained(error: Any, text: str) -> FileIssue:
    """Say in a user's words what libyaml could not read."""
    said, mark = str(getattr(error, "problem", None) or error), getattr(error, "problem_mark", None)
    if mark is None:
        return FileIssue(message=f"this is no YAML: {said.splitlines()[0]}")
    lines = text.splitlines()
    opened = getattr(error, "context_mark", None)
    if opened is not None and ("expected ':'" in said or "end of stream" in said):
        mark = opened  # libyaml looked for the end as far as it could
    shown = lines[mark.line].strip() if mark.line < len(lines) else ""
    if "cannot start any token" in said and lines[mark.line][mark.column : mark.column + 1] == "\t":
        said = "tab character"
    known = ((message, hint) for part, message, hint in _EXPLAINED if part in said)
    message, hint = next(known, (f"this is no YAML: {said}", ""))
    if opened is not None and "not closed" in message:
        message += f", opened in line {opened.line + 1}"
    return FileIssue(
        message=message,
        hint=hint,
        value=shown if len(shown) <= 60 else f"{shown[:57]}...",
        line=mark.line + 1,
        column=mark.column + 1,
    )


def read_text(path: Path) -> str:
    """Return the text of a file.

    Raises
    ------
    InvalidFileError
        If it cannot be read, is no UTF-8 text, or far too long to be meant.
    """
    data = _read_bytes(path)
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        before = data[: error.start]
        problem = FileIssue(
            message=f"byte {data[error.start]:#04x} is no UTF-8",
            hint="save the file with the encoding UTF-8",
            line=before.count(b"\n") + 1,
            column=len(before) - before.rfind(b"\n"),
        )
    raise InvalidFileError(str(path), (problem,))


def read_table_text(path: Path) -> str:
    """Return the text of a table: UTF-8, or UTF-16 with its byte order mark.

    UTF-16 is what Excel writes as "Unicode text".

    Raises
    ------
    InvalidFileError
        If it cannot be read, is text of neither encoding, or far too long to be meant.
    """
    data = _read_bytes(path)
    if not data.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)):
        return read_text(path)
    try:
        return data.decode("utf-16")
    except UnicodeDecodeError:
        problem = FileIssue(
            message="its UTF-16 text is cut off or damaged",
            hint="save the file again, with the encoding UTF-8 or UTF-16",
        )
    raise InvalidFileError(str(path), (problem,))


def _read_bytes(path: Path) -> bytes:
    """Return the bytes of a file that is not far too long to be meant."""
    try:
        status = path.stat()
        if not S_ISREG(status.st_mode):
            raise InvalidFileError(str(path), (FileIssue(message="this is no file"),))
        if status.st_size > 4 * MAX_FILE_CHARACTERS:
            raise InvalidFileError(str(path), (_too_long(f"{status.st_size / 1e6:.0f} MB"),))
        return path.read_bytes()
    except (OSError, ValueError) as error:  # a ValueError: no file can have such a name
        said = getattr(error, "strerror", None) or error
        problem = FileIssue(message=f"cannot be read: {said}", hint=_neighbour(path))
    raise InvalidFileError(str(path), (problem,))


def _too_long(size: str) -> FileIssue:
    message = f"a file may have up to {MAX_FILE_CHARACTERS} characters, this has {size}"
    return FileIssue(message=message, hint="is it a recording?")


def _neighbour(path: Path) -> str:
    """Return advice on a file that is not there."""
    from difflib import get_close_matches

    try:
        beside = [p.name for p in path.parent.iterdir() if p.is_file()]
    except (OSError, ValueError):
        return f"there is no folder {path.parent}"
    stems = {Path(name).stem: name for name in beside}  # endings are alike of what is not
    close = get_close_matches(path.stem, stems, n=1, cutoff=0.5)
    return f"did you mean {path.with_name(stems[close[0]])}?" if close else ""
