"""RPC III time histories (.rsp, .tim, .rpc, .drv) of MTS, read some groups at a time.

A header of records of 128 bytes (key 32, value 96) in blocks of 512, then groups: of each group all
points of channel 1, then of channel 2, and so on. A group holds one or several frames; the last
group is filled up. A sample is its 16-bit number times `SCALE.CHAN_n`; `INT_FULL_SCALE` says what
the largest number is, and scales nothing. Numbers of floating point are stored as they are.

Source: MTS, RPC File Formats, "Time History Files": "Value used to multiply the binary 16-bit
converter value" (10 V/32752 = 3.053249E-04). A file of nCode agrees, whose header states the
channels' largest values: 232.291 with SCALE 7.088956E-03 and 32767 in it, and no `INT_FULL_SCALE`
(SignalExample.rsp of RPC3.js, MIT). So do rpc3-file 1.0.0rc6 and FEDEM; rpc-reader 0.9 multiplies
by INT_FULL_SCALE/32768 besides.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from cardan.core.arrays import FloatArray
from cardan.physics.signals.recording import SAMPLES_PER_BLOCK, Channel
from cardan.readers.base import (
    RecordingFileColumns,
    RecordingFormat,
    number_of_attribute,
    rate_of_printed_step,
    unreadable_recording_error,
)

HEADER_BLOCK_BYTES, RECORD_BYTES, KEY_BYTES = 512, 128, 32
MAX_HEADER_BLOCKS = 4096
"""Blocks of a header. The format allows 256; some programs write more."""
MAX_CHANNELS = 1024
"""Channels of a file. The format allows 128; some programs write more."""
MAX_POINTS_PER_GROUP = 1 << 31
"""Points of a channel in a group. The format allows 16384; a file may be one group."""
MAX_GROUP_BYTES_READ_AT_ONCE = 1 << 22
"""Bytes of groups that are read at once; of a longer group a channel is read at a time."""
MAX_FILLING_POINTS = 1 << 14
"""Points at the end of a file that are looked at for the filling of its last group: the longest
group of the format."""
STEP_DIGITS = 7
"""Digits that E8.6 prints of a step."""

_BYTE_ORDERS = {"BINARY": "<", "BINARY_IEEE_LITTLE_END": "<", "BINARY_IEEE_BIG_END": ">"}
_SAMPLE_TYPES = {"SHORT_INTEGER": "i2", "FLOATING_POINT": "f4", "DOUBLE_PRECISION": "f8"}
"""Kinds of samples; DOUBLE_PRECISION is none of the format's, FEDEM writes it."""


@dataclass(frozen=True)
class _Layout:
    """Where samples of each channel are in a file, and what they are worth."""

    start: int
    """Byte of the first group."""
    channels: int
    points: int
    """Of each channel in a group."""
    groups: int
    samples: int
    """Of each channel in the file."""
    dtype: np.dtype[np.generic]
    scale: FloatArray
    """Of each channel, (channels,)."""

    @property
    def group_bytes(self) -> int:
        return self.channels * self.points * self.dtype.itemsize


def open_rpc(path: Path, _group: str = "") -> RecordingFileColumns:
    """Open an RPC III time history."""
    header = _read_header(path)
    if (kind := header.get("FILE_TYPE", "TIME_HISTORY").upper()) != "TIME_HISTORY":
        raise unreadable_recording_error(path, "it holds no time history", value=kind)
    if header.get("HALF_FRAMES", "0").strip() not in ("", "0"):
        raise unreadable_recording_error(
            path, "half a frame without data stands at its beginning and at its end",
            hint="write it anew without half frames (HALF_FRAMES 0)",
        )  # fmt: skip
    step = _number(path, header, "DELTA_T")
    if not 0 < step < np.inf:
        raise unreadable_recording_error(
            path, "its DELTA_T must be above 0", value=header["DELTA_T"]
        )
    layout, notes = _layout(path, header)
    filling, note = _filling(path, header, layout)
    samples = layout.samples - filling
    columns = tuple(
        Channel(
            header.get(f"DESC.CHAN_{k}", "").strip('" ') or f"channel {k}",
            header.get(f"UNITS.CHAN_{k}", "").strip('" '),
        )
        for k in range(1, layout.channels + 1)
    )

    def rows(places: tuple[int, ...]) -> Iterator[FloatArray]:
        return _read_samples(path, layout, places, 0, samples)

    rate = rate_of_printed_step(step, STEP_DIGITS)
    return RecordingFileColumns(
        columns=columns, read_rows=rows, rate=rate, samples=samples, notes=(*notes, *note)
    )


def _read_header(path: Path) -> dict[str, str]:
    """Return the keys of a header and what they say."""
    with path.open("rb") as file:
        first = file.read(HEADER_BLOCK_BYTES)
        if len(first) < HEADER_BLOCK_BYTES:
            raise unreadable_recording_error(
                path, "its header is cut short",
                value=f"{len(first)} of {HEADER_BLOCK_BYTES} bytes",
            )  # fmt: skip
        head = dict(_records(first, 3))
        order = head.get("FORMAT", "").upper()
        if order not in _BYTE_ORDERS:
            raise unreadable_recording_error(
                path, "its FORMAT is not read", value=repr(order),
                hint=f"read are {', '.join(_BYTE_ORDERS)}",
            )  # fmt: skip
        blocks = _whole(path, head, "NUM_HEADER_BLOCKS", 1, MAX_HEADER_BLOCKS)
        records = _whole(path, head, "NUM_PARAMS", 3, blocks * HEADER_BLOCK_BYTES // RECORD_BYTES)
        rest = file.read((blocks - 1) * HEADER_BLOCK_BYTES)
    if len(rest) < (blocks - 1) * HEADER_BLOCK_BYTES:
        raise unreadable_recording_error(
            path, "its header is cut short",
            value=f"{len(first) + len(rest)} of {blocks * HEADER_BLOCK_BYTES} bytes",
        )  # fmt: skip
    return dict(_records(first + rest, records))


def _records(header: bytes, count: int) -> Iterator[tuple[str, str]]:
    """Yield the keys of a header and their values: each ends at its first NUL."""
    for k in range(count):
        record = header[k * RECORD_BYTES : (k + 1) * RECORD_BYTES]
        key, value = (
            part.split(b"\0")[0].decode("cp1252", "replace").strip()
            for part in (record[:KEY_BYTES], record[KEY_BYTES:])
        )
        if key:
            yield key.upper(), value


def _number(path: Path, header: Mapping[str, str], key: str) -> float:
    if key not in header:
        raise unreadable_recording_error(path, f"its header has no {key}")
    return number_of_attribute(path, key, header[key])


def _whole(path: Path, header: Mapping[str, str], key: str, least: int, most: int) -> int:
    number = _number(path, header, key)
    if not (least <= number <= most and number == int(number)):
        raise unreadable_recording_error(
            path, f"its {key} cannot be true", value=header[key],
            hint=f"{least} to {most} are possible",
        )  # fmt: skip
    return int(number)


def _layout(path: Path, header: Mapping[str, str]) -> tuple[_Layout, list[str]]:
    """Return where the samples of a file are, held against its size, and what is to be noted."""
    notes: list[str] = []
    start = HEADER_BLOCK_BYTES * _whole(path, header, "NUM_HEADER_BLOCKS", 1, MAX_HEADER_BLOCKS)
    channels = _whole(path, header, "CHANNELS", 1, MAX_CHANNELS)
    frame = _whole(path, header, "PTS_PER_FRAME", 1, MAX_POINTS_PER_GROUP)
    points = _whole(path, header, "PTS_PER_GROUP", frame, MAX_POINTS_PER_GROUP)
    frames = _whole(path, header, "FRAMES", 1, 1 << 53)
    if points % frame:
        raise unreadable_recording_error(
            path, "a group of it is no whole number of frames",
            value=f"PTS_PER_GROUP {points}, PTS_PER_FRAME {frame}",
        )  # fmt: skip
    kind = header.get("DATA_TYPE", "SHORT_INTEGER").upper()
    if kind not in _SAMPLE_TYPES:
        raise unreadable_recording_error(
            path, "its DATA_TYPE is not read", value=repr(kind),
            hint=f"read are {', '.join(_SAMPLE_TYPES)}",
        )  # fmt: skip
    dtype = np.dtype(_BYTE_ORDERS[header["FORMAT"].upper()] + _SAMPLE_TYPES[kind])
    scale = np.ones(channels)
    for k in range(1, channels + 1):
        key = f"SCALE.CHAN_{k}"
        if kind == "SHORT_INTEGER":
            scale[k - 1] = _number(path, header, key)
            if not (np.isfinite(scale[k - 1]) and scale[k - 1]):
                raise unreadable_recording_error(
                    path, f"its {key} cannot be true", value=header[key]
                )
        elif key in header and _number(path, header, key) != 1:
            note = f"its {key} is not applied: its samples are of floating point"
            notes.append(note)
    layout = _Layout(
        start, channels, points, -(-frames * frame // points), frames * frame, dtype, scale
    )
    there, claimed = path.stat().st_size - start, layout.groups * layout.group_bytes
    sizes = f"{there} of {claimed} bytes of samples are there"
    if there < claimed:
        whole = there // layout.group_bytes
        raise unreadable_recording_error(
            path, "the file is cut short, or its header claims what is not there",
            value=f"{sizes}: {whole} of {layout.groups} groups",
        )  # fmt: skip
    if there - claimed >= layout.group_bytes:
        raise unreadable_recording_error(
            path, "it holds more groups of samples than its header says",
            value=f"{there // layout.group_bytes} and {layout.groups}",
            hint="its FRAMES, CHANNELS, PTS_PER_GROUP and DATA_TYPE cannot all be true",
        )  # fmt: skip
    if there - claimed >= HEADER_BLOCK_BYTES:
        note = f"{there - claimed} bytes behind the {claimed} that its header claims are not read"
        notes.append(note)
    return layout, notes


def _filling(path: Path, header: Mapping[str, str], layout: _Layout) -> tuple[int, tuple[str, ...]]:
    """Return how many of the last samples only fill the last group, and what is to be noted.

    `SAMPLES` says so where a program wrote it. Otherwise the filling is what stands still at the
    end in all channels at once for less than a group: zeros, as the format has it, or the last
    value repeated. Of a repeated value the first stays.
    """
    if "SAMPLES" in header:
        return layout.samples - _whole(path, header, "SAMPLES", 1, layout.samples), ()
    last = min(layout.points, MAX_FILLING_POINTS, layout.samples)
    every = tuple(range(layout.channels))
    pieces = _read_samples(path, layout, every, layout.samples - last, layout.samples)
    tail = np.concatenate(list(pieces), axis=1)
    moving = np.flatnonzero(np.any(tail != tail[:, -1:], axis=0))
    if not moving.size:  # it stands still for a group: no filling is as long
        return 0, ()
    run = last - 1 - int(moving[-1])
    filling = run if not tail[:, -1].any() else run - 1
    if filling < 1:
        return 0, ()
    note = f"its last {filling} samples stand still in all channels and are left out as filling"
    return filling, (note,)


def _read_samples(
    path: Path, layout: _Layout, places: tuple[int, ...], first: int, last: int
) -> Iterator[FloatArray]:
    """Yield channels (k, n) from one sample to before another."""
    at_once = MAX_GROUP_BYTES_READ_AT_ONCE // layout.group_bytes
    scale = layout.scale[list(places), None]
    with path.open("rb") as file:

        def numbers(at: int, count: int) -> np.ndarray:
            file.seek(layout.start + at * layout.dtype.itemsize)
            found = np.fromfile(file, layout.dtype, count)
            if found.size < count:
                raise unreadable_recording_error(path, "it was cut short while it was read")
            return found

        while first < last:
            group, within = divmod(first, layout.points)
            at = group * layout.channels * layout.points
            if at_once:
                count = min(at_once, layout.groups - group)
                raw = numbers(at, count * layout.channels * layout.points)
                raw = raw.reshape(count, layout.channels, layout.points)[:, list(places)]
                stored = np.moveaxis(raw, 1, 0).reshape(len(places), -1)[:, within:]
            else:
                count = min(SAMPLES_PER_BLOCK, layout.points - within)
                channels = (numbers(at + k * layout.points + within, count) for k in places)
                stored = np.stack(list(channels))
            yield stored[:, : last - first].astype(float) * scale
            first += stored.shape[1]


def _is_rpc(head: bytes) -> bool:
    """Whether a file is RPC III: FORMAT is the first key of its header, padded to 32 bytes."""
    second = head[RECORD_BYTES : RECORD_BYTES + KEY_BYTES].upper()
    return head[:6].upper() == b"FORMAT" and (
        head[6:7] == b"\0" or second.startswith(b"NUM_HEADER_BLOCKS")
    )


FORMAT = RecordingFormat(
    name="RPC III", extensions=(".rsp", ".tim", ".rpc", ".drv"), open_columns=open_rpc,
    recognises=_is_rpc,
)  # fmt: skip
