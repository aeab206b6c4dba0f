"""Files that hold much more than their size."""

import struct

import numpy as np
import pytest


def thrift(number):
    """Return a whole number as Thrift's compact protocol writes it."""
    left, found = number << 1, b""
    while left > 127:
        found += bytes([left & 127 | 128])
        left >>= 7
    return found + bytes([left])


def dictionary_bomb(honest, bomb, *, values):
    """Write a recording, and another whose dictionary holds so many zeros, in the same bytes."""
    pa = pytest.importorskip("pyarrow")
    pq = pytest.importorskip("pyarrow.parquet")
    x = np.random.default_rng(1).normal(size=20_000)
    table = pa.table({"S1": x}).replace_schema_metadata({"rate_Hz": "500"})
    pq.write_table(table, honest, compression="zstd", use_dictionary=["S1"],
                   dictionary_pagesize_limit=1 << 24)  # fmt: skip
    column = pq.ParquetFile(honest).metadata.row_group(0).column(0)
    first, last = column.dictionary_page_offset, column.data_page_offset
    zeros = pa.Codec("zstd").compress(bytes(1 << 23)).to_pybytes() * (values >> 20)

    def head(size):  # a dictionary page: bytes, bytes compressed, values, plain
        told = b"\x15".join(map(thrift, (2, 8 * values, size)))
        return b"\x15" + told + b"\x4c\x15" + thrift(values) + b"\x15\x00\x00\x00"

    size = last - first - len(head(last - first))
    spare = size - len(zeros) - 8  # a frame that Zstandard skips fills the room
    skipped = struct.pack("<II", 0x184D2A50, spare) + bytes(spare)
    data = bytearray(honest.read_bytes())
    data[first:last] = head(size) + zeros + skipped
    bomb.write_bytes(data)
    assert bomb.stat().st_size == honest.stat().st_size < 200_000
