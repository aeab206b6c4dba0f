"""Frames of CAN logs, block by block: Vector ASC (text) and Vector BLF.

A block says of each frame when it came, on which bus, its identifier, its length and its data.

Source: Vector, CANoe help, "ASC logging file"; the objects of BLF as Vector's `binlog_objects.h`
has them. Tests hold both against python-can 4.6.1.
"""

import re
import struct
import zlib
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import numpy.typing as npt

from cardan.core.arrays import FloatArray
from cardan.core.errors import InvalidFileError
from cardan.readers.base import unreadable_recording_error
from cardan.readers.can_database import EXTENDED_BIT

FRAMES_PER_BLOCK = 1 << 16
MAX_DATA_BYTES = 64
"""Of a frame of CAN FD."""


@dataclass(frozen=True)
class FrameBlock:
    """Frames one after the other.

    Attributes
    ----------
    time : (n,) s
        On the clock of the log.
    bus : (n,)
        Number of the bus.
    identifier : (n,)
        With `EXTENDED_BIT` where it has 29 bits.
    length : (n,)
        Bytes of data.
    data : (n, bytes)
        Zero behind its length.
    """

    time: FloatArray
    bus: npt.NDArray[np.int64]
    identifier: npt.NDArray[np.int64]
    length: npt.NDArray[np.int64]
    data: npt.NDArray[np.uint8]


_Frame = tuple[float, int, int, bytes]
"""Time, bus, identifier and data."""
FrameSource = Callable[[Callable[[str], None]], Iterator[FrameBlock]]
"""Yields blocks of a log; its argument takes notes on the log."""


def _blocks(frames: Iterator[_Frame]) -> Iterator[FrameBlock]:
    """Yield frames in blocks."""
    held: list[_Frame] = []
    for frame in frames:
        held.append(frame)
        if len(held) == FRAMES_PER_BLOCK:
            yield _block(held)
            held = []
    if held:
        yield _block(held)


def _block(frames: list[_Frame]) -> FrameBlock:
    time, bus, identifier, data = zip(*frames, strict=True)
    length = np.array([len(d) for d in data], np.int64)
    width = int(length.max())
    packed = b"".join(d.ljust(width, b"\0") for d in data)
    return FrameBlock(
        np.array(time, float), np.array(bus, np.int64), np.array(identifier, np.int64), length,
        np.frombuffer(packed, np.uint8).reshape(len(data), width),
    )  # fmt: skip


# ------------------------------------------------------------------------------------------- ASC

MAX_ASC_LINE_BYTES = 1 << 12
_EVENT = re.compile(rb"\s*(\d{1,12}\.\d{1,12})\s+(\S.*)")
_CLASSIC_FRAME = re.compile(
    rb"(\d{1,3})\s+(\w+)\s+(?:Rx|Tx)\s+d\s+([0-9a-f]{1,2})((?:\s+[0-9a-f]{1,3}(?=\s|$))*)",
    re.IGNORECASE,
)
_FD_FRAME = re.compile(
    rb"CANFD\s+(\d{1,3})\s+(?:Rx|Tx)\s+(\w+)\s+(?:[A-Za-z_]\w*\s+)?[01]\s+[01]\s+"
    rb"[0-9a-f]{1,2}\s+(\d{1,2})((?:\s+[0-9a-f]{1,3}(?=\s|$))*)",
    re.IGNORECASE,
)
_IDENTIFIER = re.compile(rb"([0-9a-f]{1,10})(x?)", re.IGNORECASE)


def asc_blocks(path: Path, tell: Callable[[str], None]) -> Iterator[FrameBlock]:
    """Yield the frames of a Vector ASC log.

    Raises
    ------
    InvalidFileError
        If a frame in it is damaged, with its line.
    """
    return _blocks(_asc_frames(path, tell))


def _asc_frames(path: Path, tell: Callable[[str], None]) -> Iterator[_Frame]:
    base, relative, clock, number = 16, False, 0.0, 0
    with path.open("rb") as file:
        while line := file.readline(MAX_ASC_LINE_BYTES):
            number += 1
            if line.lower().lstrip().startswith(b"base "):
                base = 10 if b"dec" in line.lower().split()[1:2] else 16
                relative = b"relative" in line.lower()
                continue
            event = _EVENT.match(line)
            if event is None:
                continue
            # Counted from the event before, whatever that was.
            clock = clock + float(event[1]) if relative else float(event[1])
            classic = _CLASSIC_FRAME.match(event[2])
            found = classic or _FD_FRAME.match(event[2])
            if found is None:
                continue
            if not line.endswith(b"\n"):
                tell("cut short in its last line, which is left out")
                return
            bus, name, length, data = found.groups()
            try:
                yield (
                    clock, int(bus), _asc_identifier(name, base),
                    _asc_data(data, int(length, base if classic else 10), base, fd=not classic),
                )  # fmt: skip
            except ValueError as error:
                raise unreadable_recording_error(
                    path, str(error), line=number, value=line.decode("latin-1").strip()[:80]
                ) from error


def _asc_identifier(text: bytes, base: int) -> int:
    of = _IDENTIFIER.fullmatch(text)
    try:
        number = int(of[1], base) if of else -1
    except ValueError:
        number = -1
    if of is None or not 0 <= number < 1 << (29 if of[2] else 11):
        msg = "the identifier of a frame is no number: log identifiers, not names"
        raise ValueError(msg)
    return number | (EXTENDED_BIT if of[2] else 0)


def _asc_data(text: bytes, length: int, base: int, *, fd: bool) -> bytes:
    if not fd:  # a length code of 9 to 15 is of eight bytes
        length = min(length, 8)
    each = text.split()[:length]
    if len(each) < length or length > MAX_DATA_BYTES:
        msg = f"a frame of {length} bytes has {len(each)}"
        raise ValueError(msg)
    numbers = [int(b, base) for b in each]
    if max(numbers, default=0) > 255:
        msg = "a byte of a frame is above 255"
        raise ValueError(msg)
    return bytes(numbers)


# ------------------------------------------------------------------------------------------- BLF

MAX_BLF_CONTAINER_BYTES = 1 << 26
"""Bytes that a container unpacks to: writers make 128 KiB of them."""
_BLF_FILE = struct.Struct("<4sL8xQQLL")
_OBJECT, _OBJECT_TIME = struct.Struct("<4sHHLL"), struct.Struct("<LHHQ")
_CONTAINER, _CAN, _CAN_FD = (
    struct.Struct("<H6xL4x"),
    struct.Struct("<HBBL8s"),
    struct.Struct("<HBBLLBBB5x64s"),
)
_CAN_FD_64 = struct.Struct("<BBBBLLLLLLLHBBL")
_LOG_CONTAINER, _CAN_TYPES, _CAN_FD_TYPE, _CAN_FD_64_TYPE = 10, (1, 86), 100, 101
_TEN_MICROSECONDS, _REMOTE, _REMOTE_64 = 1, 0x80, 0x10
_MAX_PADDING_BYTES = 8


def blf_blocks(path: Path, tell: Callable[[str], None]) -> Iterator[FrameBlock]:
    """Yield the frames of a Vector BLF log.

    Raises
    ------
    InvalidFileError
        If an object in it is damaged, with the byte at which it lies.
    """
    return _blocks(_blf_frames(path, tell))


def _blf_frames(path: Path, tell: Callable[[str], None]) -> Iterator[_Frame]:
    """Yield the frames of a log's objects, which lie in containers and may span two of them."""
    held = b""
    for piece in _blf_pieces(path, tell):
        held += piece
        at = 0
        while (begin := held.find(b"LOBJ", at, at + _MAX_PADDING_BYTES + 4)) >= 0:
            if len(held) < begin + _OBJECT.size:
                break
            _, header, version, size, kind = _OBJECT.unpack_from(held, begin)
            if not max(header, _OBJECT.size) <= size <= MAX_BLF_CONTAINER_BYTES:
                raise _damaged(path, f"an object of {size} bytes with a head of {header}")
            if begin + size > len(held):
                break
            try:
                frame = _blf_frame(held[begin : begin + size], header, version, kind)
            except struct.error as error:
                raise _damaged(path, f"an object of {size} bytes is too short") from error
            if frame is not None:
                yield frame
            at = begin + size
        else:
            if len(held) - at > _MAX_PADDING_BYTES + 4:
                raise _damaged(path, "no object where one is due")
        held = held[at:]
    if len(held) > _MAX_PADDING_BYTES:
        tell("cut short in its last object, which is left out")


def _damaged(path: Path, what: str) -> InvalidFileError:
    return unreadable_recording_error(path, f"it is damaged: {what}")


def _blf_pieces(path: Path, tell: Callable[[str], None]) -> Iterator[bytes]:
    """Yield the bytes of a log's objects, containers unpacked."""
    whole = path.stat().st_size
    with path.open("rb") as file:
        head = file.read(_BLF_FILE.size)
        if len(head) < _BLF_FILE.size:
            raise _damaged(path, f"its head is cut off at {whole} bytes")
        _, header, stated, *_ = _BLF_FILE.unpack(head)
        if not _BLF_FILE.size <= header <= whole:
            raise _damaged(path, f"its head claims {header} of {whole} bytes")
        if stated > whole:
            tell(f"cut short: it states {stated} bytes, {whole} are there")
        at = header
        while at + _OBJECT.size <= whole:
            file.seek(at)
            base = file.read(_OBJECT.size)
            signature, _, _, size, kind = _OBJECT.unpack(base)
            if signature != b"LOBJ" or not _OBJECT.size <= size <= MAX_BLF_CONTAINER_BYTES:
                raise _damaged(path, f"no object where one is due, at byte {at} of {whole}")
            body = file.read(size - _OBJECT.size)
            if len(body) < size - _OBJECT.size:
                if stated <= whole:
                    tell(f"cut short: of its last {size} bytes {len(body)} are there")
                if kind != _LOG_CONTAINER:
                    return
            yield _unpacked(path, body) if kind == _LOG_CONTAINER else base + body
            at += size + size % 4


def _unpacked(path: Path, body: bytes) -> bytes:
    """Return the objects of a container, of one that was cut off those that are there."""
    if len(body) < _CONTAINER.size:
        return b""
    method, size = _CONTAINER.unpack_from(body)
    packed = body[_CONTAINER.size :]
    if size > MAX_BLF_CONTAINER_BYTES:
        raise _damaged(path, f"a container claims {size} bytes")
    if method == 0:
        return packed
    if method != 2:
        raise _damaged(path, f"a container is packed by an unknown method, {method}")
    try:
        return zlib.decompressobj().decompress(packed, size + 1)[:size]
    except zlib.error as error:
        raise _damaged(path, f"a container cannot be unpacked: {error}") from error


def _blf_frame(of: bytes, header: int, version: int, kind: int) -> _Frame | None:
    """Return the frame of data that an object is; None if it is something else."""
    if kind not in (*_CAN_TYPES, _CAN_FD_TYPE, _CAN_FD_64_TYPE) or version not in (1, 2):
        return None
    flags, _, _, count = _OBJECT_TIME.unpack_from(of, _OBJECT.size)
    time = count / (1e5 if flags == _TEN_MICROSECONDS else 1e9)
    if kind in _CAN_TYPES:
        bus, flags, length, name, data = _CAN.unpack_from(of, header)
        length, remote = min(length, 8), flags & _REMOTE
    elif kind == _CAN_FD_TYPE:
        bus, flags, _, name, _, _, _, length, data = _CAN_FD.unpack_from(of, header)
        remote = flags & _REMOTE
    else:
        bus, _, length, _, name, _, flags, *_, behind, _ = _CAN_FD_64.unpack_from(of, header)
        data = of[header + _CAN_FD_64.size : behind or len(of)].ljust(length, b"\0")
        remote = flags & _REMOTE_64
    identifier = name & 0x1FFFFFFF | (EXTENDED_BIT if name & EXTENDED_BIT else 0)
    return None if remote else (time, bus, identifier, data[: min(length, MAX_DATA_BYTES)])
