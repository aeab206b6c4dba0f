"""A file of records that is only appended to: what was written whole is found again.

A record has its length and the SHA-256 of its content, so one that was cut short by a power cut,
or changed since, differs from a whole one, and the next is found behind it.
"""

import json
import mmap
import struct
import zlib
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from hashlib import sha256
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np

_MAGIC = b"\x93cardan\n"
_HEAD = struct.Struct("<8sQ32s")
"""What each record begins with: eight bytes, the length of its content, its SHA-256."""


@dataclass(frozen=True, kw_only=True)
class LogEntry:
    """Where a record stands, with its head and content, and what it says of itself."""

    offset: int
    length: int
    about: Mapping[str, Any]


def log_record(about: Mapping[str, Any], arrays: Mapping[str, Any]) -> bytes:
    """Return a record: what it says of itself, as JSON, and arrays by name, compressed."""
    each = {name: np.asarray(v) for name, v in arrays.items()}
    told = {
        **about, "arrays": [[name, v.dtype.str, list(v.shape)] for name, v in each.items()],
    }  # fmt: skip
    body = zlib.compress(b"".join(v.tobytes() for v in each.values()), level=1)
    content = json.dumps(told).encode() + b"\n" + body
    return _HEAD.pack(_MAGIC, len(content), sha256(content).digest()) + content


def arrays_of_record(record: bytes) -> dict[str, Any]:
    """Return the arrays of a record that is whole."""
    head, _, body = record[_HEAD.size :].partition(b"\n")
    data, found, at = zlib.decompress(body), dict[str, Any](), 0
    for name, kind, shape in json.loads(head)["arrays"]:
        one = np.frombuffer(data, dtype=kind, count=int(np.prod(shape)), offset=at)
        found[name] = one.reshape(shape).copy()
        at += one.nbytes
    return found


def record_of(file: BinaryIO, entry: LogEntry) -> bytes | None:
    """Return a record; None where another stands now, or none."""
    file.seek(entry.offset)
    found = file.read(entry.length)
    now = _entry_at(found, 0)
    same = now is not None and all(now.about.get(k) == v for k, v in entry.about.items())
    return found if same else None


def log_entries(path: Path) -> Iterator[LogEntry | None]:
    """Yield the records of a file in their order, None for each stretch that is none.

    Nothing if there is no such file.
    """
    if not path.exists() or not (size := path.stat().st_size):
        return
    with path.open("rb") as file, mmap.mmap(file.fileno(), 0, access=mmap.ACCESS_READ) as whole:
        at = 0
        while 0 <= at < size:
            found = _entry_at(whole, at)
            yield found
            at = whole.find(_MAGIC, at + 1) if found is None else at + found.length


def _entry_at(whole: mmap.mmap | bytes, at: int) -> LogEntry | None:
    """Return the record that begins at a place; None if no whole one does."""
    if at + _HEAD.size > len(whole):
        return None
    magic, length, digest = _HEAD.unpack_from(whole, at)
    begin = at + _HEAD.size
    if magic != _MAGIC or begin + length > len(whole):
        return None
    content = whole[begin : begin + length]
    if sha256(content).digest() != digest:
        return None
    told = json.loads(content.partition(b"\n")[0])
    return LogEntry(offset=at, length=_HEAD.size + length, about=told)
