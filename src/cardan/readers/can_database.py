"""CAN databases (DBC): messages, signals and how their bits become values; J1939.

Of J1939 a message is known by its parameter group number (PGN), from any address, and signals by
their suspect parameter number (SPN) as well as by their names in the database.

Source: Vector, "DBC File Format Documentation", 1.0; SAE J1939-21 (identifier) and J1939-71
(ranges of transmitted values; places of the parameters in `J1939_PARAMETERS`).
"""

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Literal

import numpy as np
import numpy.typing as npt

from cardan.core.arrays import FloatArray
from cardan.readers.base import unreadable_recording_error

EXTENDED_BIT = 1 << 31
"""Of an identifier in a database or a log: it has 29 bits."""
_PRIORITY_BITS = 7 << 26
_MAX_DATABASE_BYTES = 1 << 26
_INDEPENDENT_SIGNALS_ID = 0xC0000000
"""Identifier of the message that holds signals of no message."""

J1939_PARAMETERS: Mapping[int, tuple[str, int, int, int]] = {
    84: ("WheelBasedVehicleSpeed", 65265, 8, 16),
    161: ("TransmissionInputShaftSpeed", 61442, 40, 16),
    190: ("EngineSpeed", 61444, 24, 16),
    191: ("TransmissionOutputShaftSpeed", 61442, 8, 16),
    512: ("DriversDemandEnginePercentTorque", 61444, 8, 8),
    513: ("ActualEnginePercentTorque", 61444, 16, 8),
    523: ("TransmissionCurrentGear", 61445, 24, 8),
    524: ("TransmissionSelectedGear", 61445, 0, 8),
    526: ("TransmissionActualGearRatio", 61445, 8, 16),
}
"""What a driveline is judged by: name, PGN, first bit and length of each SPN."""
J1939_NAMES = frozenset(of[0] for of in J1939_PARAMETERS.values())
_SPN_BY_PLACE: Mapping[tuple[int, int, int], int] = {
    (pgn, start, length): spn for spn, (_, pgn, start, length) in J1939_PARAMETERS.items()
}

_MISSING_VALUE_NAME = re.compile(
    r"(?!no[\W_])(\w+[\W_]+)?(not[\W_]*(available.*|valid)|n/?a|sna|error|invalid)"
    r"([\W_]+(indicator|value|data|signal))?",
    re.IGNORECASE,
)
"""Names that a database gives to raw values that are no measurement."""

UIntArray = npt.NDArray[np.uint64]


@dataclass(frozen=True, kw_only=True)
class CanSignal:
    """A signal: its bits in a message, and how they become a value.

    Attributes
    ----------
    start
        Its first bit: of the least significant one where little-endian, else of the most
        significant one, counted from the top of the first byte.
    conditions
        Signals that say which of several is sent, and their raw values at which it is this one.
    named_values
        Raw values with a name: of states, not of a quantity.
    missing_values
        Those of them whose names say that there is no value.
    aliases
        Other names: by J1939, `EngineSpeed` and `SPN190`, and the short one of a long name.
    """

    name: str
    unit: str
    start: int
    length: int
    big_endian: bool
    signed: bool
    factor: float
    offset: float
    minimum: float
    maximum: float
    is_float: bool = False
    conditions: tuple[tuple["CanSignal", tuple[tuple[int, int], ...]], ...] = ()
    named_values: bool = False
    missing_values: tuple[int, ...] = ()
    aliases: tuple[str, ...] = ()

    @property
    def end_byte(self) -> int:
        """Bytes of a frame that hold it whole."""
        return (self.start + self.length + 7) // 8

    def raw_values(self, data: npt.NDArray[np.uint8]) -> UIntArray:
        """Return its bits in frames (n, bytes) as unsigned numbers (n,); 0 behind their end."""
        first, last = self.start // 8, self.end_byte
        own = data[:, first:last]
        if own.shape[1] < last - first:
            own = np.pad(own, ((0, 0), (0, last - first - own.shape[1])))
        bits = np.unpackbits(own, axis=1, bitorder="big" if self.big_endian else "little")
        at = self.start - 8 * first
        weights = np.uint64(1) << np.arange(self.length, dtype=np.uint64)
        return bits[:, at : at + self.length] @ (weights[::-1] if self.big_endian else weights)

    def is_sent(
        self, data: npt.NDArray[np.uint8], length: npt.NDArray[np.integer]
    ) -> npt.NDArray[np.bool_]:
        """Return in which of frames (n, bytes) the multiplexors say that it is sent (n,)."""
        sent = np.ones(len(data), bool)
        for multiplexor, ranges in self.conditions:
            raw = multiplexor.raw_values(data)
            sent &= length >= multiplexor.end_byte
            sent &= np.any([(raw >= low) & (raw <= high) for low, high in ranges], axis=0)
        return sent

    def values(
        self, data: npt.NDArray[np.uint8], length: npt.NDArray[np.integer], j1939: "J1939Codes"
    ) -> FloatArray:
        """Return its values in frames (n, bytes) of lengths (n,) bytes; missing ones are nan."""
        raw = self.raw_values(data)
        if self.is_float:
            kind = np.float32 if self.length == 32 else np.float64
            number = raw.astype(f"u{self.length // 8}").view(kind).astype(float)
        elif self.signed:
            unused = np.uint64(64 - self.length)
            number = ((raw << unused).view(np.int64) >> unused.astype(np.int64)).astype(float)
        else:
            number = raw.astype(float)
        with np.errstate(over="ignore", invalid="ignore"):
            found = number * self.factor + self.offset
        missing = (length < self.end_byte) | np.isin(raw, np.array(self.missing_values, np.uint64))
        if j1939 != "none" and not (self.signed or self.is_float):
            missing |= self._j1939_missing(raw, found, stated=j1939 == "stated")
        return np.where(missing, np.nan, found)

    def _j1939_missing(
        self, raw: UIntArray, found: FloatArray, *, stated: bool
    ) -> npt.NDArray[np.bool_]:
        """Return which raw values (n,) are codes: error, not available, and reserved ones.

        Of 8 bits and more the top eight decide, FE and FF, and what is reserved, FB to FD, where
        it lies beyond the declared range; of fewer bits the highest value but one, and the highest.
        """
        beyond = (found > self.maximum) | (self.minimum >= self.maximum)
        if self.length >= 8:
            top = raw >> np.uint64(self.length - 8)
            code, reserved = top >= 0xFE, (top >= 0xFB) & beyond
        elif self.length > 1:
            code, reserved = raw >= (1 << self.length) - 2, np.zeros(len(raw), bool)
        else:
            return np.zeros(len(raw), bool)
        return (code | reserved) & (beyond | stated)


J1939Codes = Literal["stated", "assumed", "none"]
"""Whether raw values of a message may be codes of J1939: the database says that it is of J1939;
the DBC does not state its protocol, and a code must lie beyond the signal's range; it is not.
"""


@dataclass(frozen=True, kw_only=True)
class CanMessage:
    """A message: its identifier, its signals, and whether it is of J1939."""

    name: str
    identifier: int
    signals: tuple[CanSignal, ...]
    j1939: J1939Codes

    @property
    def pgn(self) -> int:
        """Its parameter group number."""
        return parameter_group(self.identifier)


def parameter_group(identifier: int) -> int:
    """Return the parameter group number of a 29-bit identifier: SAE J1939-21."""
    to_one_address = (identifier >> 16) & 0xFF < 240
    return (identifier >> 8) & (0x3FF00 if to_one_address else 0x3FFFF)


@dataclass(frozen=True)
class CanDatabase:
    """The messages of a database, by identifier."""

    name: str
    messages: Mapping[int, CanMessage]

    def message_of(self, identifier: int) -> CanMessage | None:
        """Return the message of a frame's identifier, of J1939 from any source address.

        None if there is none, or several of one PGN of which none is from this address.
        """
        exact = self.messages.get(identifier)
        if exact is not None or not identifier & EXTENDED_BIT:
            return exact
        alike = self._by_group.get(parameter_group(identifier), [])
        same = [m for m in alike if not (m.identifier ^ identifier) & ~_PRIORITY_BITS]
        found = same or alike
        return found[0] if len(found) == 1 else None

    @cached_property
    def _by_group(self) -> dict[int, list[CanMessage]]:
        """Its messages of J1939, by parameter group number."""
        found: dict[int, list[CanMessage]] = {}
        for message in self.messages.values():
            if message.j1939 != "none":
                found.setdefault(message.pgn, []).append(message)
        return found


def without_priority(identifier: int, message: CanMessage) -> int:
    """Return what distinguishes the frames of a message: its identifier, of J1939 less priority."""
    return identifier if message.j1939 == "none" else identifier & ~_PRIORITY_BITS


_NUMBER = r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?"
_MESSAGE = re.compile(r"BO_\s+(\d{1,10})\s+(\w+)\s*:\s*\d+")
_SIGNAL = re.compile(
    r"SG_\s+(?P<name>\w+)\s*(?P<multiplexed>m\d{1,9}M?|M)?\s*:\s*(?P<start>\d{1,5})\|"
    r"(?P<length>\d{1,5})@(?P<order>[01])(?P<sign>[+-])\s*"
    rf"\(\s*(?P<factor>{_NUMBER})\s*,\s*(?P<offset>{_NUMBER})\s*\)\s*"
    r'\[(?P<minimum>[^|\]]*)\|(?P<maximum>[^|\]]*)\]\s*"(?P<unit>[^"]*)"'
)
_COMMENT = re.compile(r'^\s*CM_\s[^"\n]*"(?:\\.|[^"\\])*"\s*;', re.MULTILINE | re.DOTALL)
_FLOAT = re.compile(r"^SIG_VALTYPE_\s+(\d+)\s+(\w+)\s*:?\s*([12])\s*;", re.MULTILINE)
_EXTENDED_MULTIPLEX = re.compile(r"^SG_MUL_VAL_\s+(\d+)\s+(\w+)\s+(\w+)\s+([^;]*);", re.MULTILINE)
_RANGE = re.compile(r"(\d{1,19})\s*-\s*(\d{1,19})")
_VALUES = re.compile(r'^VAL_\s+(\d+)\s+(\w+)((?:\s+-?\d+\s+"[^"]*")*)\s*;', re.MULTILINE)
_VALUE = re.compile(r'(-?\d{1,19})\s+"([^"]*)"')
_ATTRIBUTE = re.compile(
    r'^BA_\s+"(\w+)"\s+(?:BO_\s+(\d+)\s+|SG_\s+(\d+)\s+(\w+)\s+)?("[^"\n]*"|[^\s;]+)\s*;',
    re.MULTILINE,
)
_DEFAULT = re.compile(r'^BA_DEF_DEF_\s+"(\w+)"\s+("[^"\n]*"|[^\s;]+)\s*;', re.MULTILINE)
_FRAME_FORMATS = re.compile(r'^BA_DEF_\s+BO_\s+"VFrameFormat"\s+ENUM\s+([^;]*);', re.MULTILINE)
_USUAL_FRAME_FORMATS = ("StandardCAN", "ExtendedCAN", "reserved", "J1939PG")


class _Attributes:
    """Attributes of a database: of itself, of its messages and of its signals."""

    def __init__(self, text: str) -> None:
        self.own = {name: value.strip('"') for name, value in _DEFAULT.findall(text)}
        self.messages: dict[tuple[str, int], str] = {}
        self.signals: dict[tuple[str, int, str], str] = {}
        for name, message, of, signal, value in _ATTRIBUTE.findall(text):
            bare = value.strip('"')
            if message:
                self.messages[name, int(message)] = bare
            elif of:
                self.signals[name, int(of), signal] = bare
            else:
                self.own[name] = bare
        formats = _FRAME_FORMATS.search(text)
        self._formats = re.findall(r'"([^"]*)"', formats[1]) if formats else _USUAL_FRAME_FORMATS

    def j1939(self, message: int, signals: list[str]) -> J1939Codes:
        """Return whether a message is of J1939, as the database says it or leaves it open."""
        if not message & EXTENDED_BIT:
            return "none"
        kind = self.messages.get(("VFrameFormat", message))
        if kind is not None:
            return "stated" if self._is_j1939_format(kind) else "none"
        named = any(("SPN", message, s) in self.signals for s in signals)
        usual = self._is_j1939_format(self.own.get("VFrameFormat", ""))
        if named or usual or "J1939" in self.own.get("ProtocolType", "").upper():
            return "stated"
        return "assumed"

    def _is_j1939_format(self, kind: str) -> bool:
        known = kind.isdigit() and int(kind) < len(self._formats)
        return "J1939" in (self._formats[int(kind)] if known else kind).upper()


def read_can_database(path: Path) -> CanDatabase:
    """Read a DBC file.

    Raises
    ------
    InvalidFileError
        If it is none, with the line of a signal that cannot be read.
    """
    if not path.is_file():
        raise unreadable_recording_error(path, "no such file")
    if path.stat().st_size > _MAX_DATABASE_BYTES:
        raise unreadable_recording_error(path, "it is too large for a CAN database (DBC)")
    data = path.read_bytes()
    try:
        text = data.decode("utf-8-sig")
    except UnicodeDecodeError:
        text = data.decode("cp1252", "replace")
    # Comments may hold anything, over many lines, of which the numbers stay.
    text = _COMMENT.sub(lambda at: "\n" * at[0].count("\n"), text)
    written = dict(_messages(path, text))
    if not written:
        raise unreadable_recording_error(
            path,
            "it is no CAN database (DBC): no signal in it",
            hint="a DBC has lines BO_ and SG_",
        )
    attributes = _Attributes(text)
    told = _SignalStatements(text, attributes)
    messages = {
        identifier: _message(path, name, identifier, signals, told, attributes)
        for identifier, (name, signals) in written.items()
    }
    return CanDatabase(path.name, messages)


def read_can_databases(paths: Sequence[Path]) -> CanDatabase:
    """Read DBC files as one database.

    Raises
    ------
    InvalidFileError
        If one is none, or two describe the same message differently.
    """
    if len(paths) == 1:
        return read_can_database(paths[0])
    messages: dict[int, CanMessage] = {}
    source: dict[int, str] = {}
    for path in paths:
        for identifier, message in read_can_database(path).messages.items():
            if messages.setdefault(identifier, message) != message:
                bits, shown = divmod(identifier, EXTENDED_BIT)
                raise unreadable_recording_error(
                    path, f"it describes a message in another way than {source[identifier]}",
                    value=f"{message.name}, {shown:0{8 if bits else 3}X}",
                    hint="give the databases of one bus (--dbc)",
                )  # fmt: skip
            source.setdefault(identifier, path.name)
    return CanDatabase(", ".join(path.name for path in paths), messages)


_Written = dict[str, tuple[CanSignal, str]]
"""Signals of a message by name, with what they say of multiplexing."""


def _messages(path: Path, text: str) -> Iterator[tuple[int, tuple[str, _Written]]]:
    """Yield the messages of a database as their own lines have them."""
    identifier, own = _INDEPENDENT_SIGNALS_ID, ("", _Written())
    for number, line in enumerate(text.splitlines(), 1):
        words = line.strip()
        if words.startswith("BO_ ") and (of := _MESSAGE.match(words)):
            if own[1] and identifier != _INDEPENDENT_SIGNALS_ID:
                yield identifier, own
            identifier, own = int(of[1]), (of[2], _Written())
        elif words.startswith("SG_ ") and identifier != _INDEPENDENT_SIGNALS_ID:
            found = _SIGNAL.match(words)
            if found is None or int(found["length"]) == 0:
                raise unreadable_recording_error(
                    path, "a signal that cannot be read", line=number, value=words[:80]
                )
            if int(found["length"]) <= MAX_SIGNAL_BITS:
                again = sum(name.partition("#")[0] == found["name"] for name in own[1])
                name = f"{found['name']}#{again + 1}" if again else found["name"]
                own[1][name] = _signal(found, name), found["multiplexed"] or ""
    if own[1] and identifier != _INDEPENDENT_SIGNALS_ID:
        yield identifier, own


MAX_SIGNAL_BITS = 64
"""Of a number: longer ones are texts."""


def _signal(of: re.Match[str], name: str) -> CanSignal:
    """Return a signal of its line."""
    start, big_endian = int(of["start"]), of["order"] == "0"
    if big_endian:  # bits of a byte are counted from its lowest one
        start = start // 8 * 8 + 7 - start % 8
    return CanSignal(
        name=name, unit=of["unit"], start=start, length=int(of["length"]),
        big_endian=big_endian, signed=of["sign"] == "-", factor=float(of["factor"]),
        offset=float(of["offset"]), minimum=_bound(of["minimum"]), maximum=_bound(of["maximum"]),
    )  # fmt: skip


def _bound(text: str) -> float:
    """Return a bound of a signal's range; 0 if it is no number: both 0 are no range."""
    return float(text) if re.fullmatch(_NUMBER, text.strip()) else 0.0


class _SignalStatements:
    """What a database says of signals behind its messages, by identifier and name."""

    def __init__(self, text: str, attributes: _Attributes) -> None:
        self.attributes = attributes
        self.floats = {(int(m), s): kind for m, s, kind in _FLOAT.findall(text)}
        self.values = {(int(m), s): _VALUE.findall(each) for m, s, each in _VALUES.findall(text)}
        self.multiplex = {
            (int(m), s): (by, tuple((int(a), int(b)) for a, b in _RANGE.findall(ranges)))
            for m, s, by, ranges in _EXTENDED_MULTIPLEX.findall(text)
        }

    def of(self, message: int, signal: CanSignal) -> CanSignal:
        """Return a signal with its further statements: floating-point, names of values, SPN."""
        key = message, signal.name
        kind = self.floats.get(key, "")
        named = self.values.get(key, [])
        # A raw value of -1 is that of all its bits.
        missing = tuple(
            int(value) % (1 << signal.length)
            for value, name in named
            if _MISSING_VALUE_NAME.fullmatch(name.strip()) and not kind
        )
        long_name = self.attributes.signals.get(("SystemSignalLongSymbol", *key))
        return replace(
            signal, name=long_name or signal.name, named_values=bool(named),
            missing_values=missing, is_float=signal.length == {"1": 32, "2": 64}.get(kind),
        )  # fmt: skip

    def aliases(self, message: int, written: str, signal: CanSignal) -> tuple[str, ...]:
        """Return the names by J1939 of a signal: by its SPN, or else by its place in the PGN."""
        given = self.attributes.signals.get(("SPN", message, written), "")
        place = (parameter_group(message), signal.start, signal.length)
        spn = int(given) if given.isdigit() else 0
        spn = spn or (0 if signal.big_endian else _SPN_BY_PLACE.get(place, 0))
        names = (J1939_PARAMETERS[spn][0],) if spn in J1939_PARAMETERS else ()
        return (*names, f"SPN{spn}") if spn else ()


def _message(
    path: Path, name: str, identifier: int, written: _Written, told: _SignalStatements,
    attributes: _Attributes,
) -> CanMessage:  # fmt: skip
    """Return a message with what the database says of it and its signals."""
    j1939 = attributes.j1939(identifier, [*written])
    plain = {own: told.of(identifier, signal) for own, (signal, _) in written.items()}
    sole = [own for own, (_, by) in written.items() if by == "M"]

    def conditions(own: str, seen: tuple[str, ...] = ()) -> Iterator[
        tuple[CanSignal, tuple[tuple[int, int], ...]]
    ]:  # fmt: skip
        by, ranges = told.multiplex.get((identifier, own), ("", ()))
        code = re.match(r"m(\d+)", written[own][1])
        if not by and code is not None:
            by, ranges = (sole[0] if len(sole) == 1 else ""), ((int(code[1]), int(code[1])),)
        if not by and code is None:
            return
        if by not in written or by in (*seen, own) or not ranges:
            raise unreadable_recording_error(
                path, f"no signal says when {own} of {name} is sent: its multiplexor is missing"
            )
        yield plain[by], ranges
        yield from conditions(by, (*seen, own))

    signals = tuple(
        replace(
            signal, conditions=tuple(conditions(own)),
            aliases=(
                *(() if j1939 == "none" else told.aliases(identifier, own, signal)),
                *(() if signal.name == own else (own,)),
            ),
        )
        for own, signal in plain.items()
    )  # fmt: skip
    return CanMessage(name=name, identifier=identifier, signals=signals, j1939=j1939)
