"""How large the pages of a Parquet file claim to be, read from their headers alone.

A reader takes as much memory for a page as its header says, before it has seen one sample: 190 kB
of a file may require gigabytes. Apache Parquet format 2.11, `PageHeader`, in Thrift's compact
protocol.
"""

from collections.abc import Iterator
from typing import Any, BinaryIO

NO_HEADER_MESSAGE = "a page of it has no header"

_HEADER_WINDOW_BYTES = (1 << 9, 1 << 16)
"""Bytes in which a header ends: with statistics it may be longer than most are."""
_MAX_HEADER_DEPTH = 4
"""Structures inside each other that a header has at most."""
_PAGE_SIZE_FIELD, _COMPRESSED_SIZE_FIELD = 2, 3
"""Numbers of the fields of a header: bytes of its page, and as they are compressed."""


def page_sizes(file: BinaryIO, column: Any) -> Iterator[int]:
    """Yield how many bytes each page of a column of a row group claims to take.

    `column` is what PyArrow has of it.

    Raises
    ------
    ValueError
        If a header is none.
    """
    at, first = column.data_page_offset, column.dictionary_page_offset
    if column.has_dictionary_page and first is not None and 0 < first < at:
        at = first
    end = at + column.total_compressed_size
    while at < end:
        fields, length = _read_header(file, at)
        size, stored = fields.get(_PAGE_SIZE_FIELD, -1), fields.get(_COMPRESSED_SIZE_FIELD, -1)
        if size < 0 or stored < 0:
            raise ValueError(NO_HEADER_MESSAGE)
        yield size
        at += length + stored


def _read_header(file: BinaryIO, at: int) -> tuple[dict[int, int], int]:
    """Return the numbers of the header at a place, and its length."""
    for window in _HEADER_WINDOW_BYTES:
        file.seek(at)
        data = file.read(window)
        try:
            return _read_struct(data, 0, _MAX_HEADER_DEPTH)
        except IndexError:  # it ends farther on, or nowhere
            continue
    raise ValueError(NO_HEADER_MESSAGE)


def _read_struct(data: bytes, at: int, deep: int) -> tuple[dict[int, int], int]:
    """Return the whole numbers of a structure by field, and where it ends."""
    if deep == 0:
        raise ValueError(NO_HEADER_MESSAGE)
    found: dict[int, int] = {}
    field = 0
    while byte := data[at]:
        at += 1
        if byte >> 4:
            field += byte >> 4
        else:
            field, at = _read_signed_integer(data, at)
        found[field], at = _read_value(data, at, byte & 15, deep)
    return found, at + 1


def _read_value(data: bytes, at: int, kind: int, deep: int) -> tuple[int, int]:
    """Return a field's value, 0 where it is no whole number, and where it ends."""
    match kind:
        case 1 | 2:  # true, false
            return 2 - kind, at
        case 3:
            return data[at], at + 1
        case 4 | 5 | 6:
            return _read_signed_integer(data, at)
        case 7:
            return 0, at + 8
        case 8:
            size, at = _read_varint(data, at)
            return 0, at + size
        case 12:
            return 0, _read_struct(data, at, deep - 1)[1]
        case _:
            raise ValueError(NO_HEADER_MESSAGE)


def _read_signed_integer(data: bytes, at: int) -> tuple[int, int]:
    """Return a whole number of either sign."""
    value, at = _read_varint(data, at)
    return (value >> 1) ^ -(value & 1), at


def _read_varint(data: bytes, at: int) -> tuple[int, int]:
    value = shift = 0
    while shift < 70:
        byte = data[at]
        at += 1
        value |= (byte & 127) << shift
        shift += 7
        if byte < 128:
            return value, at
    raise ValueError(NO_HEADER_MESSAGE)
