"""HDF5 recordings, read a stretch at a time."""

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from cardan.core.arrays import FloatArray
from cardan.physics.signals.recording import SAMPLES_PER_BLOCK, Channel
from cardan.readers.base import (
    RecordingFileColumns,
    RecordingFormat,
    as_one_file,
    attribute_text,
    max_page_bytes,
    oversized_data_error,
    rate_from_attributes,
    unreadable_recording_error,
)
from cardan.readers.time_units import instant, seconds_per_count_of_instants

HDF5_CACHE_BYTES = 1 << 20
"""Bytes of a channel that HDF5 keeps unpacked: in the last of them the next piece begins."""
_UNIT_ATTRIBUTES = ("unit", "units", "Unit", "Units", "unit_string")


def open_hdf5(path: Path, group: str = "") -> RecordingFileColumns:
    """Open an HDF5 recording: one-dimensional datasets of one group and one length."""
    try:
        return _open_groups(path, open_hdf5_file(path), group)
    except (OSError, RuntimeError, KeyError, TypeError, ValueError) as error:
        # Of damaged parts h5py raises any of them.
        raise unreadable_recording_error(path, f"it is damaged: {error}") from error


def _open_groups(path: Path, file: Any, group: str) -> RecordingFileColumns:
    """Return the datasets of a file, or of a group in it, as tables of one clock each."""
    import h5py  # pyright: ignore[reportMissingTypeStubs]

    sets: dict[str, Any] = {}
    single: dict[str, Any] = {}
    wide: list[str] = []

    def visit(name: str, item: Any) -> None:
        if not isinstance(item, h5py.Dataset) or item.dtype.kind not in "fiu":
            return
        if attribute_text(item.attrs.get("MATLAB_class", "")) in ("char", "cell"):
            return  # MATLAB keeps letters as numbers
        name = f"{group}/{name}" if group else name
        long = [n for n in item.shape if n > 1]
        if len(long) == 1:  # MATLAB keeps a series as (1, n), and others as (n, 1)
            sets[name] = item
        elif not long and item.size:
            single[name] = item
        elif long:
            wide.append(name)

    home = _group_inside_file(path, file, group) if group else file
    home.visititems(visit)  # follows no link out of the file
    note = f"more than one number a sample, left out: {', '.join(wide)}"
    notes = (note,) if wide else ()
    if not sets:
        raise unreadable_recording_error(
            path, "no one-dimensional datasets of numbers in it", hint="; ".join(notes)
        )
    for name, item in sets.items():
        check_dataset(path, name, item)
    # Those of one length, rate and start are of one clock, whatever group they are in.
    alike: dict[tuple[int, float | None, float | None, str], dict[str, Any]] = {}
    for name, item in sets.items():
        places = [item.attrs, item.parent.attrs, _single_values(single, item.parent), file.attrs]
        rate = next((r for at in places if (r := rate_from_attributes(path, at))), None)
        start = next((s for at in places if (s := _start(path, at)) is not None), None)
        parent = name.rpartition("/")[0] if len({i.size for i in sets.values()}) > 1 else ""
        alike.setdefault((item.size, rate, start, parent), {})[name] = item
    starts = [key[2] for key in alike if key[2] is not None]
    earliest = min(starts, default=0.0) if len(starts) == len(alike) else 0.0
    found = as_one_file(
        _dataset_table(path, sets=own, rate=rate, start=0.0 if start is None else start - earliest)
        for (_, rate, start, _), own in alike.items()
    )
    return replace(found, notes=(*found.notes, *notes))


def open_hdf5_file(path: Path) -> Any:
    """Return an HDF5 file, opened for reading."""
    import h5py  # pyright: ignore[reportMissingTypeStubs]

    try:
        # HDF5 2 keeps eight megabytes of each channel: what is read on and on is met once.
        return h5py.File(path, "r", rdcc_nbytes=HDF5_CACHE_BYTES)
    except OSError as error:
        raise unreadable_recording_error(
            path, f"HDF5 cannot open it: {error}", hint="was it written to its end?"
        ) from error


def check_dataset(path: Path, name: str, item: Any) -> None:
    """Refuse a dataset that lies in another file, or claims more than is stored.

    Raises
    ------
    InvalidFileError
        Before anything of it is read.
    """
    if item.external or item.is_virtual:
        raise unreadable_recording_error(
            path, f"{name} keeps its samples in another file, which is not opened"
        )
    chunk = math.prod(item.chunks or (0,)) * item.dtype.itemsize
    if chunk > max_page_bytes(item.size):
        raise oversized_data_error(path, name, chunk, item.size)
    if item.size > 64 and item.size > 2000 * item.id.get_storage_size():
        raise unreadable_recording_error(
            path, f"{name} claims more samples than are stored",
            value=f"{item.size:.4g} samples in {item.id.get_storage_size()} bytes",
            hint="was it written to its end?",
        )  # fmt: skip


def _single_values(single: dict[str, Any], group: Any) -> dict[str, Any]:
    """Return the datasets of one number in a group, as MATLAB keeps a rate, by their names."""
    own = group.name.strip("/")
    return {
        name.rpartition("/")[2]: item[()]
        for name, item in single.items()
        if name.rpartition("/")[0].strip("/") == own
    }


_START_ATTRIBUTES = ("start_time", "start", "t0", "wf_start_time", "time_start")


def _start(path: Path, attributes: Any) -> float | None:
    """Return when samples begin, s, as attributes say, a number or an instant; None if not."""
    for name in _START_ATTRIBUTES:
        if name in attributes:
            text = attribute_text(attributes[name])
            try:
                found = float(text)
            except ValueError:
                at = instant(text)
                if at is None:
                    raise unreadable_recording_error(
                        path, f"its {name} is neither a number nor an instant", value=text
                    ) from None
                found = at
            return found * (seconds_per_count_of_instants(found) or 1.0)
    return None


def _group_inside_file(path: Path, file: Any, group: str) -> Any:
    """Return a group of an HDF5 file, reached by no link that leads out of it."""
    import h5py  # pyright: ignore[reportMissingTypeStubs]

    home = file
    for part in filter(None, group.split("/")):
        link = home.get(part, getlink=True) if part in home or part in list(home) else None
        if isinstance(link, h5py.ExternalLink):
            raise unreadable_recording_error(
                path, f"group {group!r} is in another file, which is not opened"
            )
        if link is None or not isinstance(home[part], h5py.Group):
            raise unreadable_recording_error(
                path, f"no group {group!r}", hint=f"it has {', '.join(file)}"
            )
        home = home[part]
    return home


@dataclass(frozen=True)
class _Packing:
    """How the numbers of a dataset are packed.

    Source: CF Metadata Conventions 1.11, sections 2.5.1 (missing data, valid range) and 8.1 (packed
    data); NUG, `_Unsigned`.
    """

    unsigned: bool = False
    factor: float = 1.0
    offset: float = 0.0
    missing: tuple[float, ...] = ()
    low: float = -math.inf
    high: float = math.inf

    def unpack(self, stored: Any) -> FloatArray:
        """Return what stored numbers (n,) are, nan where one is missing."""
        if self.unsigned and stored.dtype.kind == "i":
            stored = stored.view(stored.dtype.str.replace("i", "u"))
        x = stored.astype(float)
        for value in self.missing:
            x[x == value] = np.nan
        if self.low > -math.inf or self.high < math.inf:
            x[(x < self.low) | (x > self.high)] = np.nan
        return x * self.factor + self.offset


def _packing(path: Path, item: Any) -> _Packing:
    """Return how a dataset says that it is packed, in numbers written as texts or not.

    Raises
    ------
    InvalidFileError
        Of a factor or an offset that is none: without it every sample would be another.
    """
    unsigned = attribute_text(item.attrs.get("_Unsigned", "")).lower() == "true"
    wrap = 2.0 ** (8 * item.dtype.itemsize) if unsigned and item.dtype.kind == "i" else 0.0

    def numbers(name: str, *, needed: bool = False) -> list[float]:
        found: list[float] = []
        stated = item.attrs.get(name, ())
        for value in np.asarray(stated).ravel() if np.size(stated) else ():
            text = attribute_text(value)
            try:
                number = float(text)
            except ValueError:
                if needed:
                    raise unreadable_recording_error(
                        path, f"its {name} is not a number", value=text
                    ) from None
                continue
            found.append(number + wrap if number < 0 else number)
        return found

    wrap, stored_wrap = 0.0, wrap
    factor, offset = numbers("scale_factor", needed=True), numbers("add_offset", needed=True)
    wrap = stored_wrap
    whole = numbers("valid_range")
    low = numbers("valid_min") or whole[:1] or [-math.inf]
    high = numbers("valid_max") or whole[1:2] or [math.inf]
    return _Packing(
        unsigned, (factor or [1.0])[0], (offset or [0.0])[0],
        (*numbers("_FillValue"), *numbers("missing_value")), low[0], high[0],
    )  # fmt: skip


def _dataset_table(
    path: Path, *, sets: dict[str, Any], rate: float | None, start: float
) -> RecordingFileColumns:
    """Return HDF5 datasets of one length as a table."""
    items = list(sets.values())
    samples = int(items[0].size)
    packed = [_packing(path, item) for item in items]

    def rows(places: tuple[int, ...]) -> Iterator[FloatArray]:
        try:
            for first in range(0, samples, SAMPLES_PER_BLOCK):
                piece = np.empty((len(places), min(SAMPLES_PER_BLOCK, samples - first)))
                for row, k in zip(piece, places, strict=True):
                    row[:] = packed[k].unpack(_stretch(items[k], first))
                yield piece
        except (OSError, RuntimeError) as error:
            raise unreadable_recording_error(path, f"it is damaged: {error}") from error

    def unit(item: Any) -> str:
        return next(
            (attribute_text(item.attrs[u]) for u in _UNIT_ATTRIBUTES if u in item.attrs), ""
        )

    names = [n.rsplit("/", 1)[-1] for n in sets]
    names = names if len(set(names)) == len(names) else list(sets)
    return RecordingFileColumns(
        columns=tuple(Channel(n, unit(i)) for n, i in zip(names, items, strict=True)),
        read_rows=rows, rate=rate, samples=samples, start=start,
        group=next(iter(sets)).rpartition("/")[0],
    )  # fmt: skip


def _stretch(item: Any, first: int) -> Any:
    """Return the next samples of a dataset (n,) of which one axis alone is longer than 1."""
    along = max(range(item.ndim), key=lambda k: item.shape[k])
    place = tuple(
        slice(first, first + SAMPLES_PER_BLOCK) if k == along else 0 for k in range(item.ndim)
    )
    return item[place]


def _is_hdf5(head: bytes) -> bool:
    """Whether a file is HDF5: its signature stands at 0, 512, 1024 or the next power of two."""
    return any(head[at : at + 8] == b"\x89HDF\r\n\x1a\n" for at in (0, 512, 1024, 2048, 4096))


FORMAT = RecordingFormat(
    name="HDF5", extensions=(".h5", ".hdf5", ".hdf", ".nc"), open_columns=open_hdf5,
    has_groups=True, recognises=_is_hdf5,
)  # fmt: skip
