"""Whether the blocks of an MDF4 file hang together, and what they claim, from their heads alone.

A reader follows links as they stand, and takes memory for a block on its word: a list that leads
back to itself never ends, and two megabytes of zeros, packed, require gigabytes. ASAM MDF 4.2,
chapter 5: each block begins with its name, its length and its links. In MDF 3.3 names are of two
letters, links half as long, and nothing is packed.
"""

import struct
import zlib
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import BinaryIO

from cardan.readers.base import MAX_PAGE_BYTES_WITHOUT_CHECK

OWNED_LINK_INDICES_BY_MDF_BLOCK = {
    b"##HD": (0, 1, 3, 4), b"##DG": (0, 1, 2), b"##CG": (0, 1, 4), b"##CN": (0, 1, 5),
    b"HD": (0,), b"DG": (0, 1), b"CG": (0, 1), b"CN": (0,),
    b"##CA": (0,), b"##SR": (0, 1), b"##HL": (0,), b"##FH": (0,), b"##AT": (0,), b"##EV": (0,),
}  # fmt: skip
"""Links of a block to those that are its own: each has one owner. Of a list all are."""
MDF_LIST_BLOCK_IDS = (b"##DL", b"##LD")
DATA_BLOCKS = (b"##DT", b"##DV", b"##DI", b"##SD", b"##RD")
"""What grows as it is recorded: its length is unknown if the file was not finished."""
MDF_SHAREABLE_BLOCK_IDS = (b"##CG", b"##AT", b"##EV", b"##CN")
"""What a channel may point at for its values though it is another's."""
MDF_COMPRESSED_BLOCK_ID = b"##DZ"
MAX_RECORD_BYTES = 1 << 20
"""Bytes of a record that are too many for any: a thousand channels take eight thousand."""
MAX_DEFLATE_RATIO = 1032
"""Bytes that Deflate makes of one at most."""

_BLOCK_HEADER, _MDF3_BLOCK_HEADER, _FIRST_BLOCK_OFFSET, _CHANNEL_DATA_LINK = (
    struct.Struct("<4s4xQQ"),
    "2sH",
    64,
    5,
)
_BODY_BYTES, _UNPACK_BYTES = 64, 1 << 20
_COMPRESSED_HEADER, _CHANNEL_GROUP_BODY = struct.Struct("<2xBxIQQ"), struct.Struct("<QQHH4xII")


@dataclass(frozen=True)
class MdfBlock:
    """A block of a file: its name, place and length, its links and what is behind them."""

    name: bytes
    offset: int
    size: int
    links: tuple[int, ...]
    body: bytes


def check_mdf_blocks(file: BinaryIO) -> None:
    """Walk the blocks of an MDF file.

    Raises
    ------
    ValueError
        If they lead in a circle or out of the file, or claim more bytes than there can be.
    """
    whole = file.seek(0, 2)
    file.seek(0)
    first = file.read(_FIRST_BLOCK_OFFSET).ljust(_FIRST_BLOCK_OFFSET, b"\0")
    finished, old = first[:3] == b"MDF", first[8:9] < b"4"
    order = ">" if old and first[24:26] != b"\0\0" else "<"

    def block(at: int) -> MdfBlock:
        found = _read_mdf3_block(file, at, order) if old else _read_block(file, at)
        cut = at + found.size > whole and (finished or found.name not in DATA_BLOCKS)
        if not found.name or cut:
            msg = f"a block of it is damaged or cut off, at {at} of {whole} bytes"
            raise ValueError(msg)
        return found

    for one in _owned_blocks(block):
        if one.name == MDF_COMPRESSED_BLOCK_ID:
            _check_unpacked_size(file, one)
        if one.name == b"##CG":
            cycles, record = _claimed_records(one)
            if record > MAX_RECORD_BYTES:
                msg = f"a record of it claims {record} bytes"
                raise ValueError(msg)
            if cycles * record > MAX_DEFLATE_RATIO * whole:
                msg = f"it claims {cycles:.4g} records of {record} bytes in a file of {whole}"
                raise ValueError(msg)

    if finished and not old:
        _check_record_counts(block)


def _check_record_counts(block: Callable[[int], MdfBlock]) -> None:
    """Refuse a group that claims fewer records than its data hold: the others would be dropped."""
    at = block(_FIRST_BLOCK_OFFSET).links[:1]
    while at and at[0]:
        group = block(at[0])
        at = group.links[:1]
        first, data = group.links[1:3]
        channels = block(first) if first and data and group.body[:1] == b"\0" else None
        if channels is None or channels.name != b"##CG" or channels.links[0]:
            continue
        cycles, record = _claimed_records(channels)
        stored = _stored_bytes(block, data) if record else None
        if stored is not None and stored >= (cycles + 1) * record:
            msg = (
                f"a group claims {cycles} records of {record} bytes, and its data hold "
                f"{stored // record}"
            )
            raise ValueError(msg)


def _stored_bytes(block: Callable[[int], MdfBlock], at: int) -> int | None:
    """Return how many bytes of records the data of a group hold; None of another layout."""
    size, ahead = 0, [at]
    while ahead:
        one = block(ahead.pop())
        if one.name == b"##DT":
            size += one.size - _BLOCK_HEADER.size - 8 * len(one.links)
        elif one.name == MDF_COMPRESSED_BLOCK_ID:
            size += _COMPRESSED_HEADER.unpack(one.body[: _COMPRESSED_HEADER.size])[2]
        elif one.name in (b"##HL", b"##DL"):
            ahead += [link for link in one.links if link]
        else:
            return None
    return size


def _owned_blocks(block: Callable[[int], MdfBlock]) -> Iterator[MdfBlock]:
    """Yield each block that another owns, and refuse one that two do."""
    met: set[int] = set()
    ahead = [(_FIRST_BLOCK_OFFSET, False)]
    while ahead:
        at, data = ahead.pop()
        one = block(at)
        if data and one.name in MDF_SHAREABLE_BLOCK_IDS:
            continue
        if at in met:
            msg = f"its blocks lead in a circle: {one.name.decode('ascii', 'replace')} at {at}"
            raise ValueError(msg)
        met.add(at)
        yield one
        own = (
            range(len(one.links))
            if one.name in MDF_LIST_BLOCK_IDS
            else OWNED_LINK_INDICES_BY_MDF_BLOCK.get(one.name, ())
        )
        ahead += [
            (one.links[k], one.name == b"##CN" and k == _CHANNEL_DATA_LINK)
            for k in own
            if k < len(one.links) and one.links[k]
        ]


def _read_block(file: BinaryIO, at: int) -> MdfBlock:
    """Return the block at a place; without a name where there is none."""
    file.seek(at)
    head = file.read(_BLOCK_HEADER.size)
    name, size, links = (
        _BLOCK_HEADER.unpack(head) if len(head) == _BLOCK_HEADER.size else (b"", 0, 0)
    )
    linked = file.read(8 * links) if name[:2] == b"##" and 8 * links < max(size, 8) else b""
    if name[:2] != b"##" or len(linked) < 8 * links:
        return MdfBlock(b"", at, 0, (), b"")
    return MdfBlock(name, at, size, struct.unpack(f"<{links}Q", linked), file.read(_BODY_BYTES))


def _read_mdf3_block(file: BinaryIO, at: int, order: str) -> MdfBlock:
    """Return the same of MDF 3."""
    file.seek(at)
    head = file.read(20)
    if len(head) < 20:
        return MdfBlock(b"", at, 0, (), b"")
    name, size, *links = struct.unpack(f"{order}{_MDF3_BLOCK_HEADER}4I", head)
    return MdfBlock(
        name if name in OWNED_LINK_INDICES_BY_MDF_BLOCK else b"", at, size, tuple(links), b""
    )


def _claimed_records(block: MdfBlock) -> tuple[int, int]:
    """Return how many records a channel group claims, and the bytes of each."""
    if len(block.body) < _CHANNEL_GROUP_BODY.size:
        return 0, 0
    _, cycles, flags, _, data, invalid = _CHANNEL_GROUP_BODY.unpack(
        block.body[: _CHANNEL_GROUP_BODY.size]
    )
    return cycles, 0 if flags & 1 else data + invalid  # of texts: their bytes, in two halves


def _check_unpacked_size(file: BinaryIO, block: MdfBlock) -> None:
    """Refuse a packed block that makes more bytes than it says, or than any should."""
    kind, _, made, packed = _COMPRESSED_HEADER.unpack(
        block.body[: _COMPRESSED_HEADER.size].ljust(_COMPRESSED_HEADER.size, b"\0")
    )
    if made > MAX_PAGE_BYTES_WITHOUT_CHECK or packed > block.size:
        msg = f"a packed block of it claims {made} bytes at once"
        raise ValueError(msg)
    makes = _UNPACKED_SIZE_READERS.get(
        kind // 2
    )  # odd ones are the same of rows that were turned to columns
    if makes is None:
        return
    # What it says it makes is no bound: only its packer's own heads, or unpacking it, show it.
    file.seek(block.offset + _BLOCK_HEADER.size + _COMPRESSED_HEADER.size)
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
    for piece in (
        _pieces(file, size) if MAX_DEFLATE_RATIO * size > MAX_PAGE_BYTES_WITHOUT_CHECK else ()
    ):
        left = piece
        while left and not reader.eof:
            found += len(reader.decompress(left, _UNPACK_BYTES))
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
        if MAX_DEFLATE_RATIO * size <= MAX_PAGE_BYTES_WITHOUT_CHECK:
            return
        left = piece
        while not reader.eof:
            found += len(reader.decompress(left, _UNPACK_BYTES))
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
        if magic >> 4 == _ZSTD_SKIPPABLE_MAGIC:
            file.seek(int.from_bytes(bytes([flags]) + file.read(3), "little"), 1)
            continue
        if magic != _ZSTD_MAGIC:
            return  # unpacking reports it
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


_ZSTD_MAGIC, _ZSTD_SKIPPABLE_MAGIC = 0xFD2FB528, 0x184D2A5
_UNPACKED_SIZE_READERS = {0: _deflate, 1: _zstd, 2: _lz4}
"""How many bytes a packed block makes, by its kind: ASAM MDF 4.3, `dz_zip_type`."""
