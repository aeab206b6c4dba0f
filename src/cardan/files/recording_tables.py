"""Parquet, HDF5 and MDF4 recordings, read a stretch at a time."""

import gc
import sys
import weakref
from collections.abc import Callable, Iterator
from contextlib import redirect_stdout
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from cardan.base.arrays import FloatArray
from cardan.base.errors import BadFile
from cardan.fatigue.recording import SIZE, Channel, cut
from cardan.files.recording_blocks import checked
from cardan.files.recording_pages import pages, room
from cardan.files.recordings import Days, Table, bad, budget, joined

_RATES = ("rate_Hz", "rate", "sample_rate", "sampling_rate", "samplerate", "fs")
KEPT = 1 << 20
"""Bytes of a channel that HDF5 keeps unpacked: in the last of them the next piece begins."""
_UNITS = ("unit", "units", "Unit", "unit_string")


def _text(value: Any) -> str:
    if isinstance(value, np.ndarray) and value.size:  # many write a list of one
        value = value.flat[0]
    return value.decode("utf-8", "replace") if isinstance(value, bytes) else str(value)


def _said(path: Path, attributes: Any) -> float | None:
    """Sample rate by the attributes of a file, if they say."""
    for name in _RATES:
        for key in (name, name.encode()):
            if key in attributes:
                try:
                    return float(_text(attributes[key]))
                except ValueError as error:
                    value = _text(attributes[key])
                    raise bad(path, f"its {name} is not a number", value=value) from error
    return None


def parquet(path: Path) -> Table:
    """Open a Parquet recording: one column a channel, unit in its field's metadata."""
    import pyarrow as pa  # pyright: ignore[reportMissingTypeStubs]
    import pyarrow.parquet as pq  # pyright: ignore[reportMissingTypeStubs]

    try:
        # Without these two a whole file or row group is held back.
        file: Any = pq.ParquetFile(path, pre_buffer=False, buffer_size=1 << 20)
    except (pa.ArrowInvalid, OSError) as error:
        raise bad(
            path, f"Parquet cannot open it: {error}", hint="was it written to its end?"
        ) from error
    budget(path, file.metadata.num_rows, file.metadata.num_columns)
    schema = file.schema_arrow
    clocks = [f for f in schema if _ticks(f.type)]
    kinds = (pa.types.is_floating, pa.types.is_integer, pa.types.is_decimal)
    numbers = [f for f in schema if any(kind(f.type) for kind in kinds)]
    fields = [f for f in schema if f in numbers or f in clocks]
    _paged(path, file.metadata, {f.name for f in fields})
    left = [f.name for f in schema if f not in fields]
    note = f"not numbers, left out: {', '.join(left)}"
    notes = (note,) if left else ()
    if b"note" in (schema.metadata or {}):
        notes = (_text(schema.metadata[b"note"]), *notes)

    def rows(places: tuple[int, ...]) -> Iterator[FloatArray]:
        names = [fields[k].name for k in places]
        begun: dict[str, _Clock] = {f.name: _Clock(f.type) for f in clocks}
        claimed, read = file.metadata.num_rows, 0
        try:
            for batch in file.iter_batches(batch_size=SIZE, columns=names):
                read += len(batch)
                columns = [
                    begun[n].seconds(batch.column(n))
                    if n in begun
                    else _number(batch.column(n)).to_numpy(zero_copy_only=False)
                    for n in names
                ]
                kind = np.result_type(np.float32, *columns)
                yield np.stack([c.astype(kind, copy=False) for c in columns])
        except (pa.ArrowInvalid, OSError) as error:
            raise bad(path, f"it is damaged: {error}") from error
        if read != claimed:
            raise _lacking(path, claimed, read)

    def channel(f: Any) -> Channel:
        if f in clocks:  # the only one is the clock, whatever its name
            alone = len(clocks) == 1 and "time" not in schema.names
            return Channel("time" if alone else f.name, "s")
        return Channel(f.name, _text((f.metadata or {}).get(b"unit", b"")))

    return Table(
        columns=tuple(channel(f) for f in fields),
        rows=rows, rate=_said(path, schema.metadata or {}), samples=file.metadata.num_rows,
        notes=notes,
    )  # fmt: skip


def _number(column: Any) -> Any:
    """Return a column of numbers as NumPy knows them: decimals as floats."""
    import pyarrow as pa  # pyright: ignore[reportMissingTypeStubs]

    return column.cast(pa.float64()) if pa.types.is_decimal(column.type) else column


def _paged(path: Path, of: Any, names: set[str]) -> None:
    """Refuse a Parquet file of which a page claims more bytes than its samples take.

    Raises
    ------
    BadFile
        Before a sample is read: memory is taken for a page on its word.
    """
    with path.open("rb") as file:
        for g in range(of.num_row_groups):
            group = of.row_group(g)
            columns = (group.column(k) for k in range(group.num_columns))
            for column in columns:
                name = column.path_in_schema
                try:
                    most = max(pages(file, column), default=0) if name in names else 0
                except ValueError as error:
                    raise bad(path, f"it is damaged: {error}") from error
                if most > room(group.num_rows):
                    raise _swollen(path, name, most, group.num_rows)


def _lacking(path: Path, claimed: int, read: int) -> BadFile:
    return bad(path, f"it is damaged: of {claimed} rows it holds {read}")


def _swollen(path: Path, name: str, size: int, samples: int) -> BadFile:
    return bad(
        path, f"{name} claims more bytes than its samples take",
        value=f"{size} bytes at once for {samples} samples",
        hint="write it anew with the program that made it",
    )  # fmt: skip


def _ticks(kind: Any) -> bool:
    """Whether values of an Arrow type are instants, times of day or times that have passed."""
    import pyarrow as pa  # pyright: ignore[reportMissingTypeStubs]

    return pa.types.is_timestamp(kind) or pa.types.is_duration(kind) or pa.types.is_time(kind)


class _Clock:
    """Seconds of a clock in Arrow's types, as pieces pass: an instant has one in every zone."""

    def __init__(self, kind: Any) -> None:
        import pyarrow as pa  # pyright: ignore[reportMissingTypeStubs]

        self.unit = {"s": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9}[kind.unit]
        self.wide, self.days = f"int{kind.bit_width}", Days() if pa.types.is_time(kind) else None
        self.first: int | None = None

    def seconds(self, column: Any) -> FloatArray:
        """Return seconds (n,) since the first that is written; nan where none is."""
        ticks = column.cast(self.wide)
        whole = ticks.fill_null(0).to_numpy(zero_copy_only=False).astype(np.int64)
        known = ~column.is_null().to_numpy(zero_copy_only=False)
        # Of nanoseconds since 1970 a float keeps a quarter of a microsecond.
        if self.first is None and known.any():
            self.first = int(whole[known][0])
        time = np.where(known, (whole - (self.first or 0)) * self.unit, np.nan)
        return time if self.days is None else self.days.on(time)


def hdf5(path: Path, *, group: str = "") -> Table:
    """Open an HDF5 recording: one-dimensional datasets of one group and one length."""
    import h5py  # pyright: ignore[reportMissingTypeStubs]

    try:
        # HDF5 2 keeps eight megabytes of each channel: what is read on and on is met once.
        file: Any = h5py.File(path, "r", rdcc_nbytes=KEPT)
    except OSError as error:
        raise bad(
            path, f"HDF5 cannot open it: {error}", hint="was it written to its end?"
        ) from error
    sets: dict[str, Any] = {}
    wide: list[str] = []

    def visit(name: str, item: Any) -> None:
        if isinstance(item, h5py.Dataset) and item.dtype.kind in "fiu":
            if item.ndim == 1:
                sets[f"{group}/{name}" if group else name] = item
            elif item.ndim:
                wide.append(name)

    home = _inside(path, file, group) if group else file
    home.visititems(visit)  # follows no link out of the file
    note = f"more than one number a sample, left out: {', '.join(wide)}"
    notes = (note,) if wide else ()
    if not sets:
        raise bad(path, "no one-dimensional datasets of numbers in it", hint="; ".join(notes))
    for name, item in sets.items():
        if item.external or item.is_virtual:
            raise bad(path, f"{name} keeps its samples in another file, which is not opened")
        chunk = (item.chunks or (0,))[0] * item.dtype.itemsize
        if chunk > room(item.shape[0]):
            raise _swollen(path, name, chunk, item.shape[0])
        if item.shape[0] > 64 and item.shape[0] > 2000 * item.id.get_storage_size():
            raise bad(
                path, f"{name} claims more samples than are stored",
                value=f"{item.shape[0]:.4g} samples in {item.id.get_storage_size()} bytes",
                hint="was it written to its end?",
            )  # fmt: skip
    # Those of one length and one rate are of one clock, whatever group they are in.
    alike: dict[tuple[int, float | None, str], dict[str, Any]] = {}
    for name, item in sets.items():
        rate = next((r for at in (item, item.parent, file) if (r := _said(path, at.attrs))), None)
        parent = name.rpartition("/")[0] if len({i.shape[0] for i in sets.values()}) > 1 else ""
        alike.setdefault((item.shape[0], rate, parent), {})[name] = item
    found = joined(path, [_datasets(path, sets=own, rate=key[1]) for key, own in alike.items()])
    return replace(found, notes=(*found.notes, *notes))


def _inside(path: Path, file: Any, group: str) -> Any:
    """Return a group of an HDF5 file, reached by no link that leads out of it."""
    import h5py  # pyright: ignore[reportMissingTypeStubs]

    home = file
    for part in filter(None, group.split("/")):
        link = home.get(part, getlink=True) if part in home or part in list(home) else None
        if isinstance(link, h5py.ExternalLink):
            raise bad(path, f"group {group!r} is in another file, which is not opened")
        if link is None or not isinstance(home[part], h5py.Group):
            raise bad(path, f"no group {group!r}", hint=f"it has {', '.join(file)}")
        home = home[part]
    return home


def _unpacked(item: Any, first: int, numbers: dict[str, float]) -> FloatArray:
    """Return a stretch of a dataset from a sample on, as such numbers say it is packed.

    Source: CF Metadata Conventions 1.11, sections 2.5.1 (missing data) and 8.1 (packed data).
    """
    stored = item[first : first + SIZE]
    x = stored.astype(float)
    for name in ("_FillValue", "missing_value"):
        if name in numbers:
            x[x == numbers[name]] = np.nan
    return x * numbers.get("scale_factor", 1.0) + numbers.get("add_offset", 0.0)


def _packed(path: Path, item: Any) -> dict[str, float]:
    """Return the numbers by which a dataset says how it is packed, written as texts or not.

    Raises
    ------
    BadFile
        Of a factor or an offset that is none: without it every sample would be another.
    """
    found: dict[str, float] = {}
    for name in ("scale_factor", "add_offset", "_FillValue", "missing_value"):
        if name in item.attrs and np.size(item.attrs[name]):
            text = _text(item.attrs[name])
            try:
                found[name] = float(text)
            except ValueError:
                if name in ("scale_factor", "add_offset"):
                    raise bad(path, f"its {name} is not a number", value=text) from None
    return found


def _datasets(path: Path, *, sets: dict[str, Any], rate: float | None) -> Table:
    """Return HDF5 datasets of one length as a table."""
    items = list(sets.values())
    samples = int(items[0].shape[0])
    packed = [_packed(path, item) for item in items]

    def rows(places: tuple[int, ...]) -> Iterator[FloatArray]:
        try:
            for first in range(0, samples, SIZE):
                piece = np.empty((len(places), min(SIZE, samples - first)))
                for row, k in zip(piece, places, strict=True):
                    row[:] = _unpacked(items[k], first, packed[k])
                yield piece
        except OSError as error:
            raise bad(path, f"it is damaged: {error}") from error

    def unit(item: Any) -> str:
        return next((_text(item.attrs[u]) for u in _UNITS if u in item.attrs), "")

    names = [n.rsplit("/", 1)[-1] for n in sets]
    names = names if len(set(names)) == len(names) else list(sets)
    return Table(
        columns=tuple(Channel(n, unit(i)) for n, i in zip(names, items, strict=True)),
        rows=rows, rate=rate, samples=samples, group=next(iter(sets)).rpartition("/")[0],
    )  # fmt: skip


def mdf(path: Path, *, group: str = "") -> Table:
    """Open an MDF4 recording: the channels of every group, each by its own time."""
    from asammdf import MDF  # pyright: ignore[reportMissingTypeStubs, reportMissingImports]

    file, why = _opened(lambda at: _unmapped(MDF, at), path)
    if file is None:
        raise bad(path, f"MDF cannot open it: {why}")
    sizes = [g.channel_group.cycles_nr for g in file.groups]
    names = {
        k: getattr(g.channel_group, "acq_name", "") or f"group {k + 1}"
        for k, g in enumerate(file.groups)
    }
    chosen = [k for k, n in enumerate(sizes) if n > 1 and group in ("", names[k])]
    if group and not chosen:
        raise bad(path, f"no group {group!r}", hint=f"it has {', '.join(names.values())}")
    if not chosen:
        raise bad(path, "it holds no samples")
    budget(path, max(sizes[k] for k in chosen), len(chosen))
    # What is asked of one record may read them all, and take twice the file of memory.
    file.configure(read_fragment_size=GLANCE)
    tables = [_channels(path, file, k, sizes[k], names[k]) for k in chosen]
    file.configure(read_fragment_size=AT_ONCE)
    return joined(path, tables)


def _unmapped(reader: Callable[[Any], Any], path: Path) -> Any:
    """Return an MDF4 that is read a stretch at a time.

    By its path it is mapped, and each page that was touched counts as the process' memory as long
    as nobody else asks for it: all of the file in the end. One that was not finished is written
    anew as it is opened, which takes its path.
    """
    stream = path.open("rb")
    try:
        checked(stream)
        stream.seek(0)
        if stream.read(8) != b"MDF     ":
            stream.close()
            return reader(path)
        stream.seek(0)
        file = reader(stream)
    except BaseException:
        stream.close()
        raise
    weakref.finalize(file, stream.close)
    return file


def _opened(reader: Callable[[Path], Any], path: Path) -> tuple[Any, str]:
    """Return what a reader opens, or why it cannot.

    What asammdf has half made of a file that was cut off complains when it goes: nobody is to
    hear that.
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


AT_ONCE, GLANCE = 1 << 21, 1 << 12
"""Bytes of an MDF4's records read at once: it is walked once, not from its beginning again; and
when its channels are looked at for what they are."""


_VIRTUAL = (3, 6)
"""Kinds of channels that are counted and not stored."""


def _channels(path: Path, file: Any, group: int, samples: int, name: str) -> Table:
    """Return the channels of numbers of an MDF4 group as a table, its time among them."""
    found = file.groups[group]
    master = file.masters_db.get(group, None)
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
        _within(channel, found.channel_group, path)
        sample = _next(iter(file.iter_get(group=group, index=k)), path)
        if sample is None:
            raise _lacking(path, samples, 0)
        if sample.samples.dtype.kind in "fiu" and sample.samples.ndim == 1:
            kept.append(k)
            time = k == master
            columns.append(
                Channel("time" if time else channel.name, "s" if time else str(sample.unit))
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
        for piece in cut(each, size=SIZE):
            read += piece.shape[1]
            yield piece
        if read != samples:
            raise _lacking(path, samples, read)

    return Table(
        columns=tuple(columns), rows=rows, samples=samples, group=name,
        notes=notes,
    )  # fmt: skip


def _records(file: Any, group: Any, path: Path) -> Iterator[Any]:
    """Yield an MDF's records a stretch at a time: read, and unpacked, once for all channels.

    As `iter_get` does for each of them.
    """
    each = file._mdf._load_data(group)
    while (records := _next(each, path)) is not None:
        yield records


def _next(each: Iterator[Any], path: Path) -> Any:
    """Return what comes next of an MDF; None at its end.

    Where whoever asks takes ten seconds for some stretches, asammdf prints how fast it was.
    """
    try:
        with redirect_stdout(None):
            return next(each, None)
    except Exception as error:  # whatever those raise who unpack it
        raise bad(path, f"it is damaged: {error}") from error


def _within(channel: Any, group: Any, path: Path) -> None:
    """Refuse a channel whose bytes are not those of its record: asammdf reads whatever is there."""
    if not hasattr(channel, "byte_offset"):  # of MDF 3
        return
    end = channel.byte_offset + (channel.bit_offset + channel.bit_count + 7) // 8
    if end > group.samples_byte_nr and channel.channel_type not in _VIRTUAL:
        raise bad(
            path, f"it is damaged: {channel.name} lies behind the end of its record",
            value=f"byte {end} of {group.samples_byte_nr}",
        )  # fmt: skip
