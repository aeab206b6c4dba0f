"""Variables of a MATLAB file of level 5 (save -v6, -v7), found without reading their numbers.

A file is a header of 128 bytes, then elements: type, length, data. A matrix is an element of
elements: flags, dimensions, name, numbers (column after column) or the parts of a struct or cell.
A compressed variable (-v7) is unpacked into a temporary file without a name, a piece at a time.

Source: MathWorks, MAT-File Format, "Level 5 MAT-File Format".
"""

import math
import struct
import weakref
import zlib
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryFile
from typing import Any

import numpy as np

from cardan.core.arrays import FloatArray
from cardan.readers.base import unreadable_recording_error
from cardan.readers.matlab_variables import MAX_DEPTH, MAX_TEXT_LETTERS, MAX_VARIABLES, Variable

HEADER_BYTES = 128
MAX_UNPACKED_BYTES_PER_FILE_BYTE = 100
"""Bytes that a byte of a file may unpack to: a recording's unpack to some ten."""
MAX_UNPACKED_BYTES_WITHOUT_CHECK = 1 << 26
UNPACK_PIECE_BYTES = 1 << 20
_COMPRESSED, _MATRIX = 15, 14
_NUMBER_TYPES = {
    1: "i1", 2: "u1", 3: "i2", 4: "u2", 5: "i4", 6: "u4", 7: "f4", 9: "f8", 12: "i8", 13: "u8",
    16: "u1", 17: "u2", 18: "u4",
}  # fmt: skip
"""Kinds of elements: numbers, and letters of UTF-8, UTF-16 and UTF-32."""
_LETTER_CODES = {1: "latin-1", 2: "latin-1", 16: "utf-8"}
_CLASSES = {
    1: "cell", 2: "struct", 3: "object", 4: "char", 5: "sparse", 6: "double", 7: "single",
    8: "int8", 9: "uint8", 10: "int16", 11: "uint16", 12: "int32", 13: "uint32", 14: "int64",
    15: "uint64", 16: "function", 17: "object",
}  # fmt: skip
_VERSIONS = (b"\x00\x01IM", b"\x01\x00MI")
_OPAQUE, _COMPLEX = 17, 0x08


@dataclass(frozen=True)
class _Element:
    """An element: its kind, where its data begin and where they and their filling end."""

    kind: int
    start: int
    size: int
    end: int


@dataclass(frozen=True)
class _Bytes:
    """Bytes of a file, or of a variable unpacked from it."""

    path: Path
    file: Any
    order: str
    size: int

    def read(self, at: int, count: int) -> bytes:
        """Return some bytes, all of them."""
        self.file.seek(at)
        found = self.file.read(count)
        if len(found) < count:
            raise unreadable_recording_error(
                self.path, "it is damaged: an element ends behind its end",
                value=f"byte {at + count} of {self.size}",
            )  # fmt: skip
        return found

    def element(self, at: int, last: int) -> _Element:
        """Return the element that begins at a byte and ends before another."""
        head = self.read(at, 8)
        kind, size = struct.unpack(f"{self.order}2I", head)
        if kind >> 16:  # of up to four bytes, which stand in its head
            kind, size, start, end = kind & 0xFFFF, kind >> 16, at + 4, at + 8
            size = min(size, 4)
        else:
            start = at + 8
            end = start + size + (0 if kind == _COMPRESSED else -size % 8)
        # The last one of a file may lack its filling.
        if start + size > last:
            raise unreadable_recording_error(
                self.path, "it is cut short, or an element claims what is not there",
                value=f"{size} bytes at byte {start} of {last}",
            )  # fmt: skip
        return _Element(kind, start, size, min(end, last))

    def elements(self, start: int, end: int) -> Iterator[_Element]:
        """Yield the elements between two bytes."""
        while end - start >= 8:
            found = self.element(start, end)
            yield found
            start = found.end


def open_v5(path: Path) -> list[Variable]:
    """Return the variables of a MATLAB file of level 5, and of their structs and cells.

    Raises
    ------
    InvalidFileError
        If an element ends behind its end, unpacks to far more than a recording does, or is none.
    """
    file = path.open("rb")
    try:
        size = path.stat().st_size
        order = ">" if _head(path, file)[126:128] == b"MI" else "<"
        whole = _Bytes(path, file, order, size)
        found: list[Variable] = []
        allowed = max(MAX_UNPACKED_BYTES_WITHOUT_CHECK, MAX_UNPACKED_BYTES_PER_FILE_BYTE * size)
        for element in whole.elements(HEADER_BYTES, size):
            if element.kind == _COMPRESSED:
                part = _unpacked(whole, element, allowed)
                allowed -= part.size
                inner = part.element(0, part.size) if part.size >= 8 else None
            else:
                part, inner = whole, element
            if inner is not None and inner.kind == _MATRIX:
                found += _variables(part, inner, found)
    except BaseException:
        file.close()
        raise
    if found:
        weakref.finalize(whole, file.close)
    return found


def is_v5(head: bytes) -> bool:
    """Whether a file is of level 5, by its version and byte order; its text may be anything."""
    return head.startswith(b"MATLAB 5.0") or head[124:128] in _VERSIONS


def _head(path: Path, file: Any) -> bytes:
    head = file.read(HEADER_BYTES)
    if not is_v5(head):
        raise unreadable_recording_error(
            path, "it is not a MATLAB file of level 5 or 7.3",
            hint="save it anew in MATLAB: save('NAME.mat', '-v7')",
        )  # fmt: skip
    if head[124:128] not in _VERSIONS:
        raise unreadable_recording_error(
            path, "its header is cut short, or damaged",
            value=f"{len(head)} of {HEADER_BYTES} bytes",
        )  # fmt: skip
    return head


def _unpacked(whole: _Bytes, element: _Element, allowed: int) -> _Bytes:
    """Return a compressed variable, unpacked into a file without a name."""
    copy = TemporaryFile()  # noqa: SIM115  it lasts as long as what reads it
    size = 0
    try:
        unpack = zlib.decompressobj()
        for at in range(element.start, element.start + element.size, UNPACK_PIECE_BYTES):
            count = min(UNPACK_PIECE_BYTES, element.start + element.size - at)
            packed = whole.read(at, count)
            while packed and not unpack.eof:
                piece = unpack.decompress(packed, UNPACK_PIECE_BYTES)
                packed = unpack.unconsumed_tail
                size += len(piece)
                if size > allowed:
                    raise unreadable_recording_error(
                        whole.path, "it unpacks to more than a recording does",
                        value=f"over {allowed} bytes of {whole.size}",
                        hint="a file of one value throughout is no recording",
                    )  # fmt: skip
                copy.write(piece)
        if not unpack.eof:
            raise unreadable_recording_error(
                whole.path, "it is damaged: a compressed variable has no end"
            )
    except zlib.error as error:
        copy.close()
        raise unreadable_recording_error(whole.path, f"it is damaged: {error}") from error
    except BaseException:
        copy.close()
        raise
    part = _Bytes(whole.path, copy, whole.order, size)
    weakref.finalize(part, copy.close)
    return part


def _variables(
    part: _Bytes, matrix: _Element, known: list[Variable], name: str | None = None, depth: int = 0
) -> list[Variable]:
    """Return the variable that a matrix is, or those of its parts."""
    if matrix.size == 0:
        return []
    inner = part.elements(matrix.start, matrix.start + matrix.size)
    flags, dims, own = next(inner, None), next(inner, None), next(inner, None)
    if flags is None or flags.size < 1:
        raise _damaged(part, matrix)
    word = struct.unpack(f"{part.order}I", part.read(flags.start, 4))[0]
    kind = _CLASSES.get(word & 0xFF, "unknown")
    if word & 0xFF == _OPAQUE and dims is not None:  # a timetable, say: only MATLAB knows it
        kind = next((_text(part, e) for e in inner), kind)
        return [Variable(name or _text(part, dims), (), kind)]
    if name is None:
        name = "" if own is None else _text(part, own)
    if not name:  # where MATLAB keeps what its functions and objects are made of
        return []
    if kind == "object" or dims is None or own is None:
        return [Variable(name, (), kind)]
    size = part.read(dims.start, min(dims.size, 4 * 32))
    shape = tuple(int(n) for n in np.frombuffer(size[: len(size) // 4 * 4], f"{part.order}i4"))
    if any(n < 0 for n in shape):
        raise _damaged(part, matrix)
    if kind in ("struct", "cell"):
        if depth >= MAX_DEPTH:
            return [Variable(name, shape, kind)]
        return _parts(part, inner, known, name=name, shape=shape, kind=kind, depth=depth)
    data = next(inner, None)
    if data is None:
        return [Variable(name, shape, kind)]
    if kind == "char":
        return [Variable(name, shape, kind, texts=(_letters(part, data, shape),))]
    if kind in ("sparse", "function", "unknown") or word >> 8 & _COMPLEX:
        return [Variable(name, shape, "complex" if word >> 8 & _COMPLEX else kind)]
    return [Variable(name, shape, kind, read=_numbers(part, data, name, shape))]


def _parts(
    part: _Bytes, inner: Iterator[_Element], known: list[Variable], *, name: str,
    shape: tuple[int, ...], kind: str, depth: int,
) -> list[Variable]:  # fmt: skip
    """Return the variables in a struct or cell; a cell of texts is one."""
    count = math.prod(shape)
    fields = [""]
    if kind == "struct":
        width, names = next(inner, None), next(inner, None)
        if width is None or names is None or width.size < 4:
            return []
        letters = struct.unpack(f"{part.order}i", part.read(width.start, 4))[0]
        raw = part.read(names.start, min(names.size, 1 << 16))
        if not 1 <= letters <= 1 << 10:
            return []
        cut = [raw[k : k + letters] for k in range(0, len(raw), letters)]
        fields = [f.split(b"\0")[0].decode("latin-1") for f in cut]
    found: list[Variable] = []
    for k in range(count):
        for field in fields:
            element = next(inner, None)
            if element is None or element.kind != _MATRIX:
                return found
            if len(known) + len(found) > MAX_VARIABLES:
                raise unreadable_recording_error(
                    part.path, "it holds too many variables", value=f"over {MAX_VARIABLES}"
                )
            place = f"({k + 1})" if count > 1 else ""
            own = f"{name}{place}.{field}" if kind == "struct" else f"{name}{{{k + 1}}}"
            found += _variables(part, element, [*known, *found], own, depth + 1)
    if kind == "cell" and found and all(v.kind == "char" for v in found):
        return [Variable(name, shape, kind, texts=tuple(v.texts[0] for v in found))]
    return found


def _text(part: _Bytes, element: _Element) -> str:
    raw = part.read(element.start, min(element.size, MAX_TEXT_LETTERS))
    return raw.decode("latin-1").strip("\0")


def _letters(part: _Bytes, data: _Element, shape: tuple[int, ...]) -> str:
    """Return the first row of an array of letters."""
    kind = np.dtype(part.order + _NUMBER_TYPES.get(data.kind, "u1"))
    raw = part.read(data.start, min(data.size, MAX_TEXT_LETTERS * kind.itemsize))
    if kind.itemsize == 1:
        text = raw.decode(_LETTER_CODES.get(data.kind, "utf-8"), "replace")
    else:
        numbers = np.frombuffer(raw[: len(raw) // kind.itemsize * kind.itemsize], kind)
        text = "".join(chr(n) if n < 0x110000 else "?" for n in numbers.tolist())
    rows = shape[0] if shape and shape[0] > 1 else 1  # column after column
    return text[::rows].strip("\0 ")


def _numbers(part: _Bytes, data: _Element, name: str, shape: tuple[int, ...]) -> Any:
    """Return what reads the numbers of an array, column after column."""
    kind = _NUMBER_TYPES.get(data.kind, "")
    if not kind:
        raise unreadable_recording_error(
            part.path, f"it is damaged: {name} is of no kind that is known", value=str(data.kind)
        )
    dtype = np.dtype(part.order + kind)
    count = math.prod(shape)
    if data.size < count * dtype.itemsize:
        raise unreadable_recording_error(
            part.path, f"{name} claims more numbers than are stored",
            value=f"{count} numbers in {data.size} bytes",
        )  # fmt: skip

    def read(first: int, many: int) -> FloatArray:
        raw = part.read(data.start + first * dtype.itemsize, many * dtype.itemsize)
        return np.frombuffer(raw, dtype).astype(float)

    return read


def _damaged(part: _Bytes, matrix: _Element) -> Exception:
    return unreadable_recording_error(
        part.path, "it is damaged: a variable is none", value=f"byte {matrix.start}"
    )
