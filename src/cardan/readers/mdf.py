"""MDF4 recordings, read a stretch at a time."""

import gc
import shutil
import sys
import weakref
from collections.abc import Callable, Iterator
from contextlib import redirect_stdout
from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryFile
from typing import Any

import numpy as np
import numpy.typing as npt

from cardan.core.arrays import FloatArray
from cardan.physics.signals.recording import SAMPLES_PER_BLOCK, Channel, rechunk_to_block_size
from cardan.readers.base import (
    RecordingFileColumns,
    RecordingFormat,
    as_one_file,
    check_sample_count,
    missing_rows_error,
    no_frames_note,
    unreadable_recording_error,
)
from cardan.readers.can_database import EXTENDED_BIT, read_can_databases
from cardan.readers.can_frames import FrameBlock
from cardan.readers.can_log import NO_DATABASE, decode_frames
from cardan.readers.mdf_validation import check_mdf_blocks


def open_mdf(path: Path, group: str = "", dbc: tuple[Path, ...] = ()) -> RecordingFileColumns:
    """Open an MDF4 recording: the channels of every group, each by its own time.

    Groups of CAN frames are decoded by databases.
    """
    from asammdf import MDF  # pyright: ignore[reportMissingTypeStubs, reportMissingImports]

    file, why = _try_to_open(lambda at: _open_mdf_unmapped(MDF, at), path)
    if file is None:
        raise unreadable_recording_error(path, f"MDF cannot open it: {why}")
    sizes = [g.channel_group.cycles_nr for g in file.groups]
    names = {
        k: getattr(g.channel_group, "acq_name", "") or f"group {k + 1}"
        for k, g in enumerate(file.groups)
    }
    chosen = [k for k, n in enumerate(sizes) if n > 1 and group in ("", names[k])]
    frames = [k for k in chosen if _is_of_frames(file.groups[k])]
    if group and not chosen:
        raise unreadable_recording_error(
            path, f"no group {group!r}", hint=f"it has {', '.join(names.values())}"
        )
    if not chosen:
        raise unreadable_recording_error(path, "it holds no samples")
    if not dbc and len(frames) == len(chosen):
        raise unreadable_recording_error(path, NO_DATABASE)
    check_sample_count(path, max(sizes[k] for k in chosen), len(chosen))
    # A read of one record may read them all, and take twice the file of memory.
    file.configure(read_fragment_size=MDF_INSPECTION_READ_BLOCK_BYTES)
    own = [k for k in chosen if k not in frames]
    tables = [_mdf_group_table(path, file, k, sizes[k], names[k]) for k in own]
    file.configure(read_fragment_size=MDF_READ_BLOCK_BYTES)
    notes: list[str] = []
    if frames and dbc:

        def blocks(_tell: Callable[[str], None]) -> Iterator[FrameBlock]:
            for k in frames:
                yield from _mdf_frames(path, file, k)

        tables += decode_frames(path, blocks, read_can_databases(dbc))
    elif frames:
        notes += [f"{names[k]}: left out, {NO_DATABASE}" for k in frames]
    if dbc and not frames:
        notes.append(no_frames_note(dbc))
    single = [names[k] for k, n in enumerate(sizes) if n == 1 and not group]
    if single:
        notes.append(f"{', '.join(single)}: left out, it holds one row")
    found = as_one_file(tables)
    return replace(found, notes=(*found.notes, *notes))


def _is_of_frames(group: Any) -> bool:
    """Whether a group is a log of frames of a bus."""
    return any(c.name.split(".")[0] in _BUS_FRAME_CHANNELS for c in group.channels)


_BUS_FRAME_CHANNELS = (
    "CAN_DataFrame", "CAN_RemoteFrame", "CAN_ErrorFrame", "LIN_Frame", "FLX_Frame", "ETH_Frame",
)  # fmt: skip
"""Channels of frames of a bus: ASAM MDF 4.2, bus logging. Those of CAN data are decoded."""


def _mdf_frames(path: Path, file: Any, group: int) -> Iterator[FrameBlock]:
    """Yield the CAN frames of a group; none of those of another bus, of errors and of requests."""
    found = file.groups[group]
    places = {c.name: k for k, c in enumerate(found.channels)}
    parts = [f"CAN_DataFrame.{part}" for part in ("ID", "DataBytes")]
    if any(name not in places for name in parts):
        return

    def column(name: str, records: Any) -> npt.NDArray[Any]:
        own, _ = file.get(
            group=group, index=places[f"CAN_DataFrame.{name}"], data=records, samples_only=True,
            ignore_invalidation_bits=True,
        )  # fmt: skip
        return own

    def has(name: str) -> bool:
        return f"CAN_DataFrame.{name}" in places

    for records in _records(file, found, path):
        try:
            time = np.asarray(file.get_master(group, data=records), float)
            name = column("ID", records).astype(np.int64)
            data = column("DataBytes", records)
            if data.dtype.kind in "SV":
                data = np.ascontiguousarray(data).view(np.uint8)
            data = data.astype(np.uint8, copy=False).reshape(len(name), -1)
            extended = column("IDE", records) > 0 if has("IDE") else name & EXTENDED_BIT > 0
            full = np.full(len(name), data.shape[1])
            length = column("DataLength", records).astype(np.int64) if has("DataLength") else full
            bus = column("BusChannel", records).astype(np.int64) if has("BusChannel") else 0 * full
        except Exception as error:  # whatever asammdf raises of values that do not fit
            raise unreadable_recording_error(path, f"it is damaged: {error}") from error
        extended = extended | (name & EXTENDED_BIT > 0)
        identifier = name & 0x1FFFFFFF | np.where(extended, EXTENDED_BIT, 0)
        yield FrameBlock(time, bus, identifier, np.minimum(length, data.shape[1]), data)


def _open_mdf_unmapped(reader: Callable[..., Any], path: Path) -> Any:
    """Return an MDF4 that is read a stretch at a time.

    By its path it is mapped, and each page that was touched counts as the process' memory as long
    as it is not needed elsewhere: all of the file in the end. One that was not finished is written
    anew as it is opened, which takes its path.
    """
    stream = path.open("rb")
    try:
        check_mdf_blocks(stream)
        stream.seek(0)
        if stream.read(8) != b"MDF     ":
            stream.close()
            return _open_unfinished_mdf(reader, path)
        stream.seek(0)
        file = reader(stream)
    except BaseException:
        stream.close()
        raise
    weakref.finalize(file, stream.close)
    return file


def _open_unfinished_mdf(reader: Callable[..., Any], path: Path) -> Any:
    """Return an MDF4 that is finished in a copy without a name, which is deleted with its reader.

    By its path asammdf 8.8 makes one in the temporary folder and leaves it there unless closed.
    """
    copy = TemporaryFile()  # noqa: SIM115  it lasts as long as what reads it
    try:
        with path.open("rb") as stream:
            shutil.copyfileobj(stream, copy)
        copy.seek(0)
        file = reader(copy)
    except BaseException:
        copy.close()
        raise
    weakref.finalize(file, copy.close)
    return file


def _try_to_open(reader: Callable[[Path], Any], path: Path) -> tuple[Any, str]:
    """Return what a reader opens, or why it cannot.

    What asammdf has half made of a file that was cut off complains when it is deleted: users are
    not to see that.
    """

    def silent(_: object) -> None: ...

    hook, sys.unraisablehook = sys.unraisablehook, silent
    try:
        try:
            return reader(path), ""
        except Exception as error:  # noqa: BLE001  whatever it raises of a broken file
            why = str(error)
        gc.collect()
        return None, why
    finally:
        sys.unraisablehook = hook


MDF_READ_BLOCK_BYTES, MDF_INSPECTION_READ_BLOCK_BYTES = 1 << 21, 1 << 12
"""Bytes of an MDF4's records read at once: it is walked once, not from its beginning again; and
when its channels are looked at for what they are."""


_MASTERS_THAT_ARE_NO_TIME = {2: "angle", 3: "distance", 4: "index"}
"""What a group's samples are counted by, by `cn_sync_type` of its master: ASAM MDF 4.2, 5.16."""
_VIRTUAL_CHANNEL_TYPES = (3, 6)
"""Kinds of channels that are counted and not stored."""


def _mdf_group_table(
    path: Path, file: Any, group: int, samples: int, name: str
) -> RecordingFileColumns:
    """Return the channels of numbers of an MDF4 group as a table, its time among them."""
    found = file.groups[group]
    master = file.masters_db.get(group, None)
    kind = 0 if master is None else getattr(found.channels[master], "sync_type", 0)
    no_time = _MASTERS_THAT_ARE_NO_TIME.get(kind, "")
    clock: int | None = None
    columns: list[Channel] = []
    kept: list[int] = []
    words: list[str] = []
    arrays: list[str] = []
    for k, (channel, parts) in enumerate(
        zip(found.channels, found.channel_dependencies, strict=True)
    ):
        # Of an array's elements asammdf makes channels, some of them behind their record's end.
        if parts is not None:
            arrays += [channel.name] if parts else []
            continue
        _check_channel_within_record(channel, found.channel_group, path)
        sample = _next_record(iter(file.iter_get(group=group, index=k)), path)
        if sample is None:
            raise missing_rows_error(path, samples, 0)
        if sample.samples.dtype.kind in "fiu" and sample.samples.ndim == 1:
            kept.append(k)
            clock = len(columns) if k == master and not no_time else clock
            columns.append(
                Channel(channel.name, "s" if k == master and not no_time else str(sample.unit))
            )
        else:
            words.append(channel.name)
    notes: tuple[str, ...] = ()
    if words:
        note = f"not numbers, left out: {', '.join(words)}"
        notes = (note,)
    if arrays:
        note = f"more than one number a sample, left out: {', '.join(arrays)}"
        notes = (*notes, note)

    def values(k: int, records: Any) -> FloatArray:
        """Return a channel of some records, what is not valid missing (n,)."""
        if kept[k] == master:
            return np.asarray(file.get_master(group, data=records), dtype=float)
        own, invalid = file.get(
            group=group, index=kept[k], data=records, samples_only=True,
            ignore_invalidation_bits=True,
        )  # fmt: skip
        x = np.asarray(own, dtype=float)
        return x if invalid is None else np.where(invalid, np.nan, x)

    def rows(places: tuple[int, ...]) -> Iterator[FloatArray]:
        each = (np.stack([values(k, r) for k in places]) for r in _records(file, found, path))
        read = 0
        for piece in rechunk_to_block_size(each, size=SAMPLES_PER_BLOCK):
            read += piece.shape[1]
            yield piece
        if read != samples:
            raise missing_rows_error(path, samples, read)

    return RecordingFileColumns(
        columns=tuple(columns), read_rows=rows, samples=samples, group=name,
        notes=notes, clock=clock, no_time=no_time,
    )  # fmt: skip


def _records(file: Any, group: Any, path: Path) -> Iterator[Any]:
    """Yield an MDF's records a stretch at a time: read, and unpacked, once for all channels.

    As `iter_get` does for each of them.
    """
    each = file._mdf._load_data(group)
    while (records := _next_record(each, path)) is not None:
        yield records


def _next_record(each: Iterator[Any], path: Path) -> Any:
    """Return what comes next of an MDF; None at its end.

    If the caller takes ten seconds for some stretches, asammdf prints how fast it was.
    """
    try:
        with redirect_stdout(None):
            return next(each, None)
    except Exception as error:  # whatever those raise who unpack it
        raise unreadable_recording_error(path, f"it is damaged: {error}") from error


def _check_channel_within_record(channel: Any, group: Any, path: Path) -> None:
    """Refuse a channel whose bytes are not those of its record: asammdf reads whatever is there."""
    if not hasattr(channel, "byte_offset"):  # of MDF 3
        return
    end = channel.byte_offset + (channel.bit_offset + channel.bit_count + 7) // 8
    if end > group.samples_byte_nr and channel.channel_type not in _VIRTUAL_CHANNEL_TYPES:
        raise unreadable_recording_error(
            path, f"it is damaged: {channel.name} lies behind the end of its record",
            value=f"byte {end} of {group.samples_byte_nr}",
        )  # fmt: skip


FORMAT = RecordingFormat(
    name="MDF4", extensions=(".mf4", ".mdf"), open_columns=open_mdf, extra="mdf", has_groups=True,
    takes_dbc=True,
    recognises=lambda head: head.startswith((b"MDF     ", b"UnFinMF ")),
)  # fmt: skip
