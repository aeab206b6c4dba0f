"""CAN logs as recordings: Vector BLF and ASC, and the frames of MDF4, by a CAN database (DBC).

Each message from each sender is a table with the instants of its frames as its clock. Where those
are even it is read as any table. Where they are not, it is laid on the clock of the others; and
where none is even, the most frequent message is laid on a clock of its usual step. Between frames
values lie straight, those with names and whole numbers that are written as they change hold until
the next, and outside a message's first and last frame they are unknown.
"""

import weakref
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from tempfile import TemporaryFile

import numpy as np

from cardan.core.arrays import FloatArray
from cardan.physics.signals.recording import SAMPLES_PER_BLOCK, Channel, rechunk_to_block_size
from cardan.readers.base import (
    RecordingFileColumns,
    RecordingFormat,
    as_one_file,
    unreadable_recording_error,
)
from cardan.readers.can_database import (
    EXTENDED_BIT,
    J1939_NAMES,
    CanDatabase,
    CanMessage,
    CanSignal,
    read_can_databases,
    without_priority,
)
from cardan.readers.can_frames import FrameBlock, FrameSource, asc_blocks, blf_blocks
from cardan.readers.file_content import is_asc_of_can_frames, is_blf

NO_DATABASE = "a log of CAN frames: give its DBC with --dbc"
_MAX_NAMED = 6


def open_can_log(path: Path, _group: str = "", dbc: tuple[Path, ...] = ()) -> RecordingFileColumns:
    """Open a Vector BLF or ASC log by its CAN databases."""
    if not dbc:
        raise unreadable_recording_error(path, NO_DATABASE)
    with path.open("rb") as file:
        blocks = blf_blocks if is_blf(file.read(4)) else asc_blocks
    tables = decode_frames(path, lambda tell: blocks(path, tell), read_can_databases(dbc))
    return as_one_file(tables)


class _Spool:
    """Decoded values in a temporary file without a name, which goes with its last reader."""

    def __init__(self) -> None:
        self._file = TemporaryFile()  # noqa: SIM115  it lasts as long as what reads it
        weakref.finalize(self, self._file.close)

    def write(self, rows: FloatArray) -> int:
        """Append rows (k, n) and return where they begin."""
        at = self._file.seek(0, 2)
        self._file.write(np.ascontiguousarray(rows).tobytes())
        return at

    def read(self, at: int, count: int) -> FloatArray:
        """Return `count` numbers from a place on."""
        self._file.seek(at)
        return np.frombuffer(self._file.read(8 * count), float)


@dataclass
class _Table:
    """Signals of a message that are sent together, and where their values are."""

    signals: tuple[CanSignal, ...]
    spool: _Spool
    pieces: list[tuple[int, int]] = field(default_factory=list)
    """Place in the spool and number of frames."""
    last: float = -np.inf
    """Instant of its last frame, s."""

    @property
    def samples(self) -> int:
        """Its frames."""
        return sum(n for _, n in self.pieces)

    def append(self, path: Path, time: FloatArray, values: FloatArray, message: CanMessage) -> None:
        """Append values (k, n) at instants (n,) s; of two at one instant the first is kept."""
        step = np.diff(time, prepend=self.last)
        if (step < 0).any() or not np.isfinite(time).all():
            raise unreadable_recording_error(
                path, f"the time of message {message.name} runs backwards",
                value=f"{time[int(np.argmin(step))]:.6f} s after {self.last:.6f} s"
                if step[0] < 0 else f"at {time[int(np.argmin(step))]:.6f} s",
                hint="split the log where it begins anew",
            )  # fmt: skip
        new = step > 0
        rows = np.vstack([time[None, new], values[:, new]])
        if rows.shape[1]:
            self.pieces.append((self.spool.write(rows), rows.shape[1]))
            self.last = float(time[-1])

    def rows(self, places: Sequence[int]) -> Iterator[FloatArray]:
        """Yield rows (k, n) of the clock, 0, and of its signals."""

        def each() -> Iterator[FloatArray]:
            for at, n in self.pieces:
                yield np.stack([self.spool.read(at + 8 * n * k, n) for k in places])

        yield from rechunk_to_block_size(each(), size=SAMPLES_PER_BLOCK)


@dataclass
class _Sender:
    """A message as one bus and one identifier carry it."""

    message: CanMessage
    bus: int
    identifier: int
    tables: tuple[_Table, ...]


def decode_frames(
    path: Path, source: FrameSource, database: CanDatabase
) -> list[RecordingFileColumns]:
    """Return the messages of a log as tables, the most frequent first.

    Raises
    ------
    InvalidFileError
        If none of its frames is in the database, or time runs backwards.
    """
    spool, notes = _Spool(), list[str]()
    senders: dict[tuple[int, int], _Sender | None] = {}
    decoded = total = 0
    for block in source(notes.append):
        total += len(block.time)
        for sender, own in _by_sender(block, senders, database, spool):
            decoded += len(own.time)
            _decode(path, sender, own)
    found = [s for s in senders.values() if s is not None]
    unknown = [_shown(name) for (_, name), s in senders.items() if s is None]
    if not found:
        raise unreadable_recording_error(
            path, f"none of its frames is in {database.name}",
            value=f"{total} frames of {', '.join(unknown[:_MAX_NAMED]) or 'no identifier'}",
            hint="give the DBC of this bus (--dbc)",
        )  # fmt: skip
    notes.append(f"CAN frames by {database.name}: {decoded} of {total} decoded")
    if unknown:
        notes.append(f"CAN identifiers that are not in it: {_listed(unknown)}")
    if any(s.message.j1939 == "assumed" for s in found):
        notes.append(
            "29-bit identifiers are taken for J1939, which the DBC does not say: any source "
            "address; error and not available, beyond a signal's range, are missing values"
        )
    tables = [table for s in found for table in _tables_of(s, found)]
    if not tables:
        raise unreadable_recording_error(path, f"no signal of its frames is in {database.name}")
    tables.sort(key=lambda t: -(t.samples or 0))
    aliases = [
        f"{alias} ({c.name})" for t in tables for c in t.columns for alias in c.aliases
        if alias.partition("@")[0] in J1939_NAMES and alias != c.name
    ]  # fmt: skip
    if aliases:
        notes.append(f"by their names in J1939: {', '.join(aliases)}")
    return [replace(tables[0], notes=tuple(notes)), *tables[1:]]


def _by_sender(
    block: FrameBlock, senders: dict[tuple[int, int], _Sender | None], database: CanDatabase,
    spool: _Spool,
) -> Iterator[tuple[_Sender, FrameBlock]]:  # fmt: skip
    """Yield the frames of a block that are in a database, of one sender at a time."""
    kinds, which = np.unique(block.bus << 32 | block.identifier, return_inverse=True)
    merged: dict[tuple[int, int], list[int]] = {}
    for k, kind in enumerate(kinds.tolist()):
        bus, identifier = kind >> 32, kind & 0xFFFFFFFF
        message = database.message_of(identifier)
        name = identifier if message is None else without_priority(identifier, message)
        merged.setdefault((bus, name), []).append(k)
        if (bus, name) not in senders:
            tables = () if message is None else _empty_tables(message, spool)
            senders[bus, name] = (
                None if message is None else _Sender(message, bus, identifier, tables)
            )
    for key, own in merged.items():
        sender = senders[key]
        if sender is not None:
            at = np.flatnonzero(np.isin(which, own))
            yield sender, FrameBlock(
                block.time[at], block.bus[at], block.identifier[at], block.length[at],
                block.data[at],
            )  # fmt: skip


def _empty_tables(message: CanMessage, spool: _Spool) -> tuple[_Table, ...]:
    """Return a table of each set of signals of a message that are sent together."""
    together: dict[object, list[CanSignal]] = {}
    for signal in message.signals:
        together.setdefault(signal.conditions, []).append(signal)
    return tuple(_Table(tuple(own), spool) for own in together.values())


def _decode(path: Path, sender: _Sender, block: FrameBlock) -> None:
    """Append the values of frames of one sender to its tables."""
    codes = sender.message.j1939
    for table in sender.tables:
        sent = table.signals[0].is_sent(block.data, block.length)
        if sent.any():
            data, length = block.data[sent], block.length[sent]
            values = np.stack([s.values(data, length, codes) for s in table.signals])
            table.append(path, block.time[sent], values, sender.message)


def _tables_of(sender: _Sender, senders: Sequence[_Sender]) -> Iterator[RecordingFileColumns]:
    """Yield the tables of a sender, with its name in them if others send the same message."""
    message = sender.message
    alike = [s for s in senders if s.message is message]
    which: list[str] = []
    if len({s.bus for s in alike}) > 1:
        which.append(f"CAN{sender.bus}")
    if len({s.identifier for s in alike}) > 1:
        which.append(_shown(sender.identifier))
    ending = f"@{'-'.join(which)}" if which else ""
    for table in sender.tables:
        if not table.samples:
            continue
        columns = tuple(
            Channel(s.name + ending, s.unit, aliases=tuple(a + ending for a in s.aliases))
            for s in table.signals
        )
        yield RecordingFileColumns(
            columns=(Channel("time of frame", "s"), *columns), read_rows=table.rows, clock=0,
            samples=table.samples, group=message.name, frames=True,
            held=tuple(k for k, s in enumerate(table.signals, 1) if s.named_values),
        )  # fmt: skip


def _shown(identifier: int) -> str:
    """Return an identifier as CAN tools write it."""
    if identifier & EXTENDED_BIT:
        return f"{identifier & ~EXTENDED_BIT:08X}"
    return f"{identifier:03X}"


def _listed(names: Sequence[str]) -> str:
    """Return names, some of many."""
    rest = len(names) - _MAX_NAMED
    return ", ".join(names[:_MAX_NAMED]) + (f" and {rest} more" if rest > 0 else "")


def _recognises(head: bytes) -> bool:
    return is_blf(head) or is_asc_of_can_frames(head)


FORMAT = RecordingFormat(
    name="Vector BLF, ASC", extensions=(".blf",), open_columns=open_can_log, takes_dbc=True,
    recognises=_recognises,
)  # fmt: skip
