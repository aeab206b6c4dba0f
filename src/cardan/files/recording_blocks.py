"""Whether the blocks of an MDF4 file hang together, and what they claim, from their heads alone.

A reader follows links as they stand, and takes memory for a block on its word: a list that leads
back to itself never ends, and two megabytes of zeros, packed, ask for gigabytes. ASAM MDF 4.2,
chapter 5: each block begins with its name, its length and its links. In MDF 3.3 names are of two
letters, links half as long, and nothing is packed.
"""

import struct
import zlib
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import BinaryIO

from cardan.files.recording_pages import SMALL

OWNS = {
    b"##HD": (0, 1, 3, 4), b"##DG": (0, 1, 2), b"##CG": (0, 1, 4), b"##CN": (0, 1, 5),
    b"HD": (0,), b"DG": (0, 1), b"CG": (0, 1), b"CN": (0,),
    b"##CA": (0,), b"##SR": (0, 1), b"##HL": (0,), b"##FH": (0,), b"##AT": (0,), b"##EV": (0,),
}  # fmt: skip
"""Links of a block to those that are its own: each has one owner. Of a list all are."""
LISTS = (b"##DL", b"##LD")
DATA = (b"##DT", b"##DV", b"##DI", b"##SD", b"##RD")
"""What grows as it is recorded: of a file that was not finished nobody knows how long it is."""
SHARED = (b"##CG", b"##AT", b"##EV", b"##CN")
"""What a channel may point at for its values though it is another's."""
PACKED = b"##DZ"
RECORD = 1 << 20
"""Bytes of a record that are too many for any: a thousand channels take eight thousand."""
EXPANDS = 1032
"""Bytes that Deflate makes of one at most."""

_HEAD, _OLD_HEAD, _HOME, _LINK = struct.Struct("<4s4xQQ"), "2sH", 64, 5
_BODY, _MOST = 64, 1 << 20
_ZIP, _CYCLES = struct.Struct("<2xBxIQQ"), struct.Struct("<QQHH4xII")


@dataclass(frozen=True)
class Block:
    """A block of a file: its name, place and length, its links and what is behind them."""

    name: bytes
    at: int
    size: int
    links: tuple[int, ...]
    body: bytes


def checked(file: BinaryIO) -> None:
    """Walk the blocks of an MDF file.

    Raises
    ------
    ValueError
        If they lead in a circle or out of the file, or claim more bytes than there can be.
    """
    whole = file.seek(0, 2)
    file.seek(0)
    first = file.read(_HOME).ljust(_HOME, b"\0")
    finished, old = first[:3] == b"MDF", first[8:9] < b"4"
    order = ">" if old and first[24:26] != b"\0\0" else "<"

    def block(at: int) -> Block:
        found = _old_block(file, at, order) if old else _block(file, at)
        cut = at + found.size > whole and (finished or found.name not in DATA)
        if not found.name or cut:
            msg = f"a block of it is damaged or cut off, at {at} of {whole} bytes"
            raise ValueError(msg)
        return found

    for one in _owned(block):
        if one.name == PACKED:
            _unpacks(file, one)
        if one.name == b"##CG":
            cycles, record = _claimed(one)
            if record > RECORD:
                msg = f"a record of it claims {record} bytes"
                raise ValueError(msg)
            if cycles * record > EXPANDS * whole:
                msg = f"it claims {cycles:.4g} records of {record} bytes in a file of {whole}"
                raise ValueError(msg)


def _owned(block: Callable[[int], Block]) -> Iterator[Block]:
    """Yield each block that another owns, and refuse one that two do."""
    met: set[int] = set()
    ahead = [(_HOME, False)]
    while ahead:
        at, data = ahead.pop()
        one = block(at)
        if data and one.name in SHARED:
            continue
        if at in met:
            msg = f"its blocks lead in a circle: {one.name.decode('ascii', 'replace')} at {at}"
            raise ValueError(msg)
        met.add(at)
        yield one
        own = range(len(one.links)) if one.name in LISTS else OWNS.get(one.name, ())
        ahead += [
            (one.links[k], one.name == b"##CN" and k == _LINK)
            for k in own
            if k < len(one.links) and one.links[k]
        ]


def _block(file: BinaryIO, at: int) -> Block:
    """Return the block at a place; without a name where there is none."""
    file.seek(at)
    head = file.read(_HEAD.size)
    name, size, links = _HEAD.unpack(head) if len(head) == _HEAD.size else (b"", 0, 0)
    linked = file.read(8 * links) if name[:2] == b"##" and 8 * links < max(size, 8) else b""
    if name[:2] != b"##" or len(linked) < 8 * links:
        return Block(b"", at, 0, (), b"")
    return Block(name, at, size, struct.unpack(f"<{links}Q", linked), file.read(_BODY))


def _old_block(file: BinaryIO, at: int, order: str) -> Block:
    """Return the same of MDF 3."""
    file.seek(at)
    head = file.read(20)
    if len(head) < 20:
        return Block(b"", at, 0, (), b"")
    name, size, *links = struct.unpack(f"{order}{_OLD_HEAD}4I", head)
    return Block(name if name in OWNS else b"", at, size, tuple(links), b"")


def _claimed(block: Block) -> tuple[int, int]:
    """Return how many records a channel group claims, and the bytes of each."""
    if len(block.body) < _CYCLES.size:
        return 0, 0
    _, cycles, flags, _, data, invalid = _CYCLES.unpack(block.body[: _CYCLES.size])
    return cycles, 0 if flags & 1 else data + invalid  # of texts: their bytes, in two halves


def _unpacks(file: BinaryIO, block: Block) -> None:
    """Refuse a packed block that makes more bytes than it says, or than any should."""
    kind, _, made, packed = _ZIP.unpack(block.body[: _ZIP.size].ljust(_ZIP.size, b"\0"))
    if made > SMALL or packed > block.size:
        msg = f"a packed block of it claims {made} bytes at once"
        raise ValueError(msg)
    makes = _MAKES.get(kind // 2)  # odd ones are the same of rows that were turned to columns
    if makes is None:
        return
    # What it says it makes is no bound: only its packer's own heads, or unpacking it, tell.
    file.seek(block.at + _HEAD.size + _ZIP.size)
    if any(found > made for found in makes(file, packed)):
        msg = f"a packed block of it makes more than the {made} bytes that it claims"
        raise ValueError(msg)


def _pieces(file: BinaryIO, size: int) -> Iterator[bytes]:
    """Yield the next bytes of a file, a few at a time."""
    while size > 0 and (piece := file.read(min(size, 1 << 16))):
        size -= len(piece)
        yield piece


def _deflate(file: BinaryIO, size: int) -> Iterator[int]:
    """Yield how many bytes what Deflate has packed makes, as they come; none where it is little."""
    reader, found = zlib.decompressobj(), 0
    for piece in _pieces(file, size) if EXPANDS * size > SMALL else ():
        left = piece
        while left and not reader.eof:
            found += len(reader.decompress(left, _MOST))
            left = reader.unconsumed_tail
            yield found


def _lz4(file: BinaryIO, size: int) -> Iterator[int]:
    """Yield the same of LZ4, and at first what its head says, for which memory is taken."""
    from lz4.frame import (  # pyright: ignore[reportMissingTypeStubs, reportMissingImports]
        LZ4FrameDecompressor,
        get_frame_info,
    )

    reader, found = LZ4FrameDecompressor(), 0
    for piece in _pieces(file, size):
        if not found:
            yield get_frame_info(piece)["content_size"]
        if EXPANDS * size <= SMALL:
            return
        left = piece
        while not reader.eof:
            found += len(reader.decompress(left, _MOST))
            left = b""
            yield found
            if reader.needs_input:
                break


def _zstd(file: BinaryIO, size: int) -> Iterator[int]:
    """Yield how many bytes the frames of Zstandard say they make: no more memory is taken.

    Of a frame that does not say 128 KiB at most are made. RFC 8878, 3.1: a head, then blocks, each
    with its length before it.
    """
    end, found = file.tell() + size, 0
    while file.tell() < end:
        magic, flags = struct.unpack("<IB", file.read(5).ljust(5, b"\0"))
        if magic >> 4 == _SKIPPED:
            file.seek(int.from_bytes(bytes([flags]) + file.read(3), "little"), 1)
            continue
        if magic != _FRAME:
            return  # whoever unpacks it says so
        alone = flags >> 5 & 1
        file.seek((1 - alone) + (0, 1, 2, 4)[flags & 3], 1)
        width = (alone, 2, 4, 8)[flags >> 6]
        found += int.from_bytes(file.read(width), "little") + 256 * (width == 2)
        yield found
        last = False
        while not last and file.tell() < end:
            head = int.from_bytes(file.read(3), "little")
            last = bool(head & 1)
            file.seek(1 if head >> 1 & 3 == 1 else head >> 3, 1)
        file.seek(4 * (flags >> 2 & 1), 1)  # a checksum


_FRAME, _SKIPPED = 0xFD2FB528, 0x184D2A5
_MAKES = {0: _deflate, 1: _zstd, 2: _lz4}
"""How many bytes a packed block makes, by its kind: ASAM MDF 4.3, `dz_zip_type`."""
