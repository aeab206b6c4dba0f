"""WAV recordings, mapped and not loaded: integer or float samples, RF64 above 4 GB.

Integer samples are shares of full scale, -1 to 1: a WAV file knows no unit.
"""

import struct
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from cardan.core.arrays import FloatArray
from cardan.physics.signals.recording import SAMPLES_PER_BLOCK, Channel
from cardan.readers.base import (
    RecordingFileColumns,
    RecordingFormat,
    unreadable_recording_error,
)

MAX_CHANNELS = 1024
"""Channels of a WAV file; no logger writes as many."""

_SAMPLE_TYPES = {
    (1, 8): "u1",
    (1, 16): "<i2",
    (1, 24): "u1",
    (1, 32): "<i4",
    (3, 32): "<f4",
    (3, 64): "<f8",
}


def open_wav(path: Path, _group: str = "") -> RecordingFileColumns:
    """Open a WAV recording."""
    size = path.stat().st_size
    with path.open("rb") as file:
        top = file.read(12)
        if len(top) < 12 or top[:4] not in (b"RIFF", b"RF64") or top[8:] != b"WAVE":
            raise unreadable_recording_error(path, "it is not a WAV file", value=repr(top[:4]))
        code = channels = rate = pace = frame_said = bits = 0
        large = 0
        while True:
            head = file.read(8)
            if len(head) < 8:
                raise unreadable_recording_error(path, "it ends before its data begin")
            name, length = struct.unpack("<4sI", head)
            if name == b"data":
                break
            body = file.read(min(length, 40))
            file.seek(length + length % 2 - len(body), 1)
            if name == b"ds64" and len(body) >= 16:
                large = struct.unpack("<Q", body[8:16])[0]
            if name == b"fmt " and len(body) >= 16:
                code, channels, rate, pace, frame_said, bits = struct.unpack("<HHIIHH", body[:16])
                if code == 0xFFFE and len(body) >= 26:
                    code = struct.unpack("<H", body[24:26])[0]
        start = file.tell()
        said = large if length == 0xFFFFFFFF else length
        file.seek(start + said + said % 2)
        behind = file.read(8)
    if (code, bits) not in _SAMPLE_TYPES:
        raise unreadable_recording_error(
            path, "unknown kind of samples", value=f"format {code}, {bits} bits"
        )
    if not channels:
        raise unreadable_recording_error(path, "it has no channels")
    if channels > MAX_CHANNELS:
        raise unreadable_recording_error(
            path, f"it claims more than {MAX_CHANNELS} channels", value=str(channels)
        )
    frame = channels * bits // 8
    if frame_said != frame:
        raise unreadable_recording_error(
            path, "its block alignment is not that of its channels",
            value=f"{frame_said} bytes for {channels} channels of {bits} bits",
            hint=f"{frame} bytes are expected; write it anew with the program that made it",
        )  # fmt: skip
    # Zero is of a header that was never completed: samples go on to the end.
    there = min(said or size, size - start)
    parts = [(start, there // frame), *_later_data(path, start + said + said % 2, frame)]
    samples = sum(n for _, n in parts)
    notes: list[str] = []
    if len(parts) > 1:
        notes.append(f"{len(parts)} parts of data, read as if one followed the other at once")
    if there < said:
        notes.append(f"the file is cut short: {there} of {said} bytes of samples are there")
    elif said < there:
        notes.append("its header says nothing of how long it is: read to the end of the file")
    elif behind and not _is_chunk_header(behind, size - start - said):
        left = size - start - there
        notes.append(f"{left} bytes behind the {said} that its header claims are not read")
    if pace != rate * frame:
        notes.append(f"its header says {rate} Hz and, by bytes a second, {pace / frame:.6g} Hz")

    def rows(places: tuple[int, ...]) -> Iterator[FloatArray]:
        # Read, not mapped: pages of a map count as memory of the reading process, all of a long
        # file.
        with path.open("rb") as file:
            for at, first, many in (
                (at, first, n) for at, n in parts for first in range(0, n, SAMPLES_PER_BLOCK)
            ):
                file.seek(at + first * frame)
                count = min(SAMPLES_PER_BLOCK, many - first) * frame
                raw = np.fromfile(file, np.uint8, count)
                if raw.size < count:
                    raise unreadable_recording_error(path, "it was cut short while it was read")
                yield _decode_samples(raw.reshape(-1, frame), code, bits)[:, list(places)].T

    return RecordingFileColumns(
        columns=tuple(Channel(f"channel {k + 1}") for k in range(channels)),
        read_rows=rows, rate=float(rate), samples=samples, notes=tuple(notes),
    )  # fmt: skip


def _later_data(path: Path, at: int, frame: int) -> list[tuple[int, int]]:
    """Return where further parts of data begin behind a place of a file, and their frames."""
    size = path.stat().st_size
    found: list[tuple[int, int]] = []
    with path.open("rb") as file:
        while at + 8 <= size:
            file.seek(at)
            head = file.read(8)
            if not _is_chunk_header(head, size - at):
                break
            name, length = struct.unpack("<4sI", head)
            if name == b"data" and length >= frame:
                found.append((at + 8, length // frame))
            at += 8 + length + length % 2
    return found


def _is_chunk_header(head: bytes, left: int) -> bool:
    """Return whether eight bytes open another part of a file of which so much is left."""
    if len(head) < 8:
        return True
    name, length = struct.unpack("<4sI", head)
    return all(32 <= c < 127 for c in name) and length <= left - 8


def _decode_samples(raw: np.ndarray, code: int, bits: int) -> FloatArray:
    """Return samples (n, channels) of raw bytes (n, frame)."""
    if bits == 24:
        wide = np.zeros((*raw.shape[:1], raw.shape[1] // 3, 4), np.uint8)
        wide[..., 1:] = raw.reshape(raw.shape[0], -1, 3)
        return wide.reshape(raw.shape[0], -1).view("<i4") / 2.0**31
    x = raw.view(_SAMPLE_TYPES[code, bits]).astype(float)
    if code == 3:
        return x
    return (x - 128) / 128 if bits == 8 else x / 2.0 ** (bits - 1)


FORMAT = RecordingFormat(
    name="WAV", extensions=(".wav",), open_columns=open_wav,
    recognises=lambda head: head[:4] in (b"RIFF", b"RF64") and head[8:12] == b"WAVE",
)  # fmt: skip
