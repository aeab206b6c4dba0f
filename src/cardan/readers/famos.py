"""imc FAMOS files (.raw, .dat): the values and the step of each channel, by imctermite.

The library holds a file whole and reads behind the end of one that was cut off. So the keys of a
file are walked through first, and the library runs in a child process with limits, which writes
the samples into a temporary file that is then read a stretch at a time.

Source: imc, Gemeinsame Komponenten, "Das imc FAMOS-Dateiformat": keys CD, Cb and CS.
"""

import os
import re
import shutil
import tempfile
import weakref
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from importlib.util import find_spec
from pathlib import Path

import numpy as np

from cardan.core.arrays import FloatArray
from cardan.core.errors import InvalidFileError
from cardan.core.subprocess_call import ChildProcessCrashedError, call_in_subprocess
from cardan.physics.signals.recording import SAMPLES_PER_BLOCK, Channel
from cardan.readers.base import (
    RecordingFileColumns,
    RecordingFormat,
    as_one_file,
    check_sample_count,
    missing_rows_error,
    unreadable_recording_error,
)
from cardan.readers.time_units import seconds_per_time_unit

MAX_LIBRARY_BYTES, MAX_LIBRARY_SECONDS = 4e9, 600.0
"""Memory and processor time that the library may take of a file."""
MAX_KEYS, MAX_KEY_BYTES_READ = 1_000_000, 1 << 12
_KEY = re.compile(rb"\s*\|([A-Za-z]{2}),\s*(\d{1,3}),\s*(\d{1,15}),")
_MAX_KEY_HEAD_BYTES = 64


@dataclass(frozen=True)
class _Stored:
    """A channel as the child process wrote it."""

    name: str
    unit: str
    samples: int
    step: float
    start: float
    """On the clock of the file, in units of the step."""
    step_unit: str
    at: int
    """Byte of its first sample in the temporary file."""


def open_famos(path: Path, _group: str = "") -> RecordingFileColumns:
    """Open an imc FAMOS file."""
    if find_spec("imctermite") is None:
        raise ModuleNotFoundError(name="imctermite3")
    _check_keys(path)
    folder = tempfile.mkdtemp(prefix="cardan-")
    copy = Path(folder, "samples")
    said: list[str] = []
    try:
        stored, left = call_in_subprocess(
            convert, path, copy, tell=said.append, memory=MAX_LIBRARY_BYTES,
            seconds=MAX_LIBRARY_SECONDS,
        )  # fmt: skip
        wrong = next((line for line in said if line.startswith("WARNING")), "")
        if wrong:
            raise unreadable_recording_error(path, f"it is damaged: {wrong}")
        if not stored:
            raise unreadable_recording_error(
                path, "no series of numbers in it", hint=f"it has {', '.join(left) or 'none'}"
            )
        alike: dict[tuple[int, float, float, str], list[_Stored]] = {}
        for one in stored:
            alike.setdefault((one.samples, one.step, one.start, one.step_unit), []).append(one)
        earliest = min(one.start for one in stored)
        found = as_one_file(_table(path, copy, own, earliest) for own in alike.values())
    except ChildProcessCrashedError as error:
        shutil.rmtree(folder, ignore_errors=True)
        raise unreadable_recording_error(
            path, f"imctermite ended without a result: {error}",
            hint="export it as MDF4, TDMS, CSV in imc FAMOS",
        ) from error  # fmt: skip
    except BaseException:
        shutil.rmtree(folder, ignore_errors=True)
        raise
    weakref.finalize(found.read_rows, shutil.rmtree, folder, ignore_errors=True)
    note = f"not numbers over time, left out: {', '.join(left)}"
    return replace(found, notes=(*found.notes, note)) if left else found


def _table(path: Path, copy: Path, own: Sequence[_Stored], earliest: float) -> RecordingFileColumns:
    """Return channels of one length, step and start as a table."""
    first = own[0]
    second = seconds_per_time_unit(first.step_unit)
    if second is not None and not first.step > 0:
        raise unreadable_recording_error(
            path, f"the step of {first.name} must be above 0", value=f"{first.step:g}"
        )

    def rows(places: tuple[int, ...]) -> Iterator[FloatArray]:
        with copy.open("rb") as file:
            for begun in range(0, first.samples, SAMPLES_PER_BLOCK):
                count = min(SAMPLES_PER_BLOCK, first.samples - begun)
                piece = np.empty((len(places), count))
                for row, k in zip(piece, places, strict=True):
                    file.seek(own[k].at + 8 * begun)
                    row[:] = np.fromfile(file, np.float64, count)
                yield piece

    return RecordingFileColumns(
        columns=tuple(Channel(one.name, one.unit) for one in own), read_rows=rows,
        samples=first.samples, no_time="" if second is not None else first.step_unit,
        rate=None if second is None else 1 / (first.step * second),
        start=(first.start - earliest) * (second or 1.0),
    )  # fmt: skip


def convert(
    path: Path, copy: Path, _tell: Callable[[str], None]
) -> tuple[list[_Stored], list[str]]:
    """Write the samples of a file's channels, and return where they are and what is left out.

    It runs in a child process, where the library may do what it likes.
    """
    from imctermite import ImcTermite  # pyright: ignore[reportMissingImports]

    stored: list[_Stored] = []
    left: list[str] = []
    try:
        file = ImcTermite(os.fsencode(path))
        channels = file.get_channels_metadata()
        with copy.open("wb") as out:
            for channel in channels:
                if channel.kind != "numeric" or channel.dimension != 1:
                    left.append(channel.name)
                    continue
                check_sample_count(path, channel.sample_count)
                at = out.tell()
                for piece in file.iter_channel_numpy(
                    channel.uuid, include_x=False, chunk_rows=SAMPLES_PER_BLOCK
                ):
                    out.write(np.asarray(piece["y"], np.float64).tobytes())
                written = (out.tell() - at) // 8
                if written != channel.sample_count:
                    raise missing_rows_error(path, channel.sample_count, written)
                stored.append(
                    _Stored(
                        channel.name, channel.y_unit.strip('" '), written, channel.x_step_width,
                        channel.x_offset + channel.absolute_trigger_time,
                        channel.x_unit.strip('" '), at,
                    )
                )  # fmt: skip
    except InvalidFileError:
        raise
    except Exception as error:  # whatever the library raises of a broken file
        raise unreadable_recording_error(path, f"imctermite cannot read it: {error}") from error
    return stored, left


def _check_keys(path: Path) -> None:
    """Refuse a file whose keys claim what is not there, or whose channels begin elsewhere.

    Raises
    ------
    InvalidFileError
        With the key, and the bytes that it claims and that are there.
    """
    size = path.stat().st_size
    blocks: dict[int, int] = {}
    buffers: list[list[int]] = []
    starts: set[str] = set()
    with path.open("rb") as file:
        at = keys = 0
        while True:
            file.seek(at)
            head = file.read(_MAX_KEY_HEAD_BYTES)
            if not head.strip(b"\r\n\t \0"):
                break
            match = _KEY.match(head)
            keys += 1
            if match is None or keys > MAX_KEYS:
                raise unreadable_recording_error(
                    path, "it is damaged: no key of FAMOS where one is due",
                    value=f"byte {at} of {size}",
                )  # fmt: skip
            name, length = match[1].decode(), int(match[3])
            begin = at + match.end()
            at = begin + length + 1
            if at > size:
                raise unreadable_recording_error(
                    path, "the file is cut short, or its header claims what is not there",
                    value=f"key {name} claims {length} bytes, {max(size - begin, 0)} are there",
                )  # fmt: skip
            file.seek(begin)
            body = file.read(min(length, MAX_KEY_BYTES_READ))
            fields = body.split(b",")
            if name == "CS":
                blocks[_whole(fields, 0)] = length - len(fields[0]) - 1
            elif name == "Cb":
                buffers += _buffers(fields)
            elif name == "CD" and len(fields) > 7:
                starts.add(fields[7].decode("latin-1").strip())
    for block, offset, filled in buffers:
        if min(offset, filled) < 0 or offset + filled > blocks.get(block, 0):
            raise unreadable_recording_error(
                path, "the file is cut short, or its header claims what is not there",
                value=f"a buffer of {filled} bytes at {offset} in {blocks.get(block, 0)} bytes of "
                "samples",
            )  # fmt: skip
    if len(starts) > 1:
        raise unreadable_recording_error(
            path, "its channels begin at several x0, which imctermite does not read",
            value=", ".join(sorted(starts)[:6]), hint="export it as MDF4, TDMS, CSV in imc FAMOS",
        )  # fmt: skip


def _buffers(fields: Sequence[bytes]) -> list[list[int]]:
    """Return block, offset and filled bytes of each buffer of a key Cb."""
    count = min(max(_whole(fields, 0), 0), len(fields) // 10)
    places = range(2, 2 + 10 * count, 10)
    return [[_whole(fields, first + k) for k in (1, 2, 5)] for first in places]


def _whole(fields: Sequence[bytes], k: int) -> int:
    """Return a field as a whole number; -1 if it is none."""
    text = fields[k].strip() if k < len(fields) else b""
    return int(text) if re.fullmatch(rb"\d{1,15}", text) else -1


FORMAT = RecordingFormat(
    name="imc FAMOS", extensions=(".raw",), open_columns=open_famos, extra="famos",
    recognises=lambda head: head.startswith(b"|CF,"),
)  # fmt: skip
