"""What a file is by its first bytes: formats that are not read are reported by name."""

import struct
from collections.abc import Callable
from pathlib import Path

from cardan.readers.base import unreadable_recording_error

HEAD_BYTES = 1 << 13
"""Bytes of a file by which it is recognised."""


_UTF_16_MARKS = (b"\xff\xfe", b"\xfe\xff")


def is_text(head: bytes) -> bool:
    """Whether the first bytes of a file may be those of a table of text, of UTF-16 too."""
    if head.startswith(_UTF_16_MARKS):
        head = head.replace(b"\0", b"")
    return bool(head) and not any(b < 9 for b in head) and b"\n" in head


def is_labview_text(head: bytes) -> bool:
    """Whether a file is a LabVIEW Measurement File (.lvm)."""
    return head.removeprefix(b"\xef\xbb\xbf").startswith(b"LabVIEW Measurement")


def is_asc_of_can_frames(head: bytes) -> bool:
    """Whether a file is a Vector ASC log: a date, the base of its numbers, then frames."""
    lines = [line.strip() for line in head.lower().splitlines()[:10]]
    said = [line for line in lines if line and not line.startswith(b"//")]
    return any(line.startswith((b"base hex", b"base dec")) for line in said[:2])


def is_blf(head: bytes) -> bool:
    """Whether a file is a Vector BLF log."""
    return head.startswith(b"LOGG")


def _is_catman(head: bytes, size: int) -> bool:
    """Whether a file is catman's: its version, 5009 to 5020, and where its data begin.

    Source: public files of catman Easy of 2022 (APReader 1.2, MIT): 5012, then an offset.
    """
    if len(head) < 6:
        return False
    version, data = struct.unpack("<hi", head[:6])
    return 5009 <= version <= 5020 and 6 < data < size


def _is_ncode_dac(head: bytes, size: int) -> bool:
    """Whether a file is an nCode DAC: records of 512 bytes, its values' count and rate first.

    Source: MSC Fatigue, DAC file format description: elements 1 and 2 of the header, 4-byte reals.
    """
    if size % 512 or size < 1024:
        return False
    for order in "<>":
        count, rate = struct.unpack(f"{order}2f", head[:8])
        if (
            count >= 1 and count == int(count) and 1e-3 <= rate <= 1e7
            and 4 * count <= size - 512 <= 4 * count + (64 << 10)
        ):  # fmt: skip
            return True
    return False


def _starts_with(*magic: bytes) -> Callable[[bytes, int], bool]:
    return lambda head, _size: head.startswith(magic)


def _holds(*words: bytes) -> Callable[[bytes, int], bool]:
    return lambda head, _size: any(word in head[:2048] for word in words)


_Export = tuple[str, str, str]
"""What a file is, the formats that are read and its program saves, and the program."""
_NCODE = "nCode GlyphWorks"
_FOREIGN_BY_CONTENT: tuple[tuple[Callable[[bytes, int], bool], _Export], ...] = (
    (_holds(b"<usi:tdm"), ("DIAdem TDM", "TDMS", "DIAdem")),
    (_holds(b"http://www.somat.com/SIE", b"<sie "), ("Somat SIE", "MDF4, CSV", _NCODE)),
    (_is_catman, ("catman BIN", "MDF4, TDMS, CSV", "catman")),
    (_starts_with(b"\x1aE\xdf\xa3"), ("enDAQ IDE", "CSV", "enDAQ Lab")),
    (_starts_with(b"PK\x03\x04"), ("ZIP, XLSX", "CSV", "its program")),
    (_starts_with(b"\x1f\x8b", b"\x28\xb5\x2f\xfd"), ("GZIP, ZSTD", "CSV", "its program")),
    (_is_ncode_dac, ("nCode DAC", "MDF4, CSV", _NCODE)),
)
_DEWESOFT = ("DEWESoft", "MDF4, HDF5, CSV", "DEWESoft")
_FOREIGN_BY_ENDING: dict[str, _Export] = {
    ".s3t": ("nCode S3T", "MDF4, CSV", _NCODE),
    ".dac": ("nCode DAC", "MDF4, CSV", _NCODE),
    ".sie": ("Somat SIE", "MDF4, CSV", _NCODE),
    ".tdx": ("DIAdem TDX", "TDMS", "DIAdem"),
    ".ldsf": ("Simcenter Testlab LDSF", "MDF4, CSV", "Simcenter Testlab"),
    **dict.fromkeys((".dxd", ".dxz", ".d7d", ".d7z"), _DEWESOFT),
}
"""Systems whose formats are not published, so that only the ending identifies them."""


def check_known_format(path: Path, head: bytes) -> None:
    """Refuse a file of a system that is not read: what it is, and which export of it is read.

    Raises
    ------
    InvalidFileError
        If it is one.
    """
    size = path.stat().st_size
    found = next((export for test, export in _FOREIGN_BY_CONTENT if test(head, size)), None)
    found = found or (None if is_text(head) else _FOREIGN_BY_ENDING.get(path.suffix.lower()))
    if found is not None:
        what, formats, program = found
        raise unreadable_recording_error(
            path, f"it is a file of {what}, which is not read",
            hint=f"export it as {formats} in {program}",
        )  # fmt: skip
