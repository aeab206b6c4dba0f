"""Parquet, HDF5, TDMS and MDF4 recordings, read a stretch at a time."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from cardan.base.arrays import FloatArray
from cardan.fatigue.recording import SIZE, Channel
from cardan.files.recordings import Table, bad

_RATES = ("rate_Hz", "rate", "sample_rate", "sampling_rate", "samplerate", "fs")
_UNITS = ("unit", "units", "Unit", "unit_string")


def _text(value: Any) -> str:
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
    schema = file.schema_arrow
    fields = [f for f in schema if pa.types.is_floating(f.type) or pa.types.is_integer(f.type)]
    left = [f.name for f in schema if f not in fields]
    notes = (f"not numbers, left out: {', '.join(left)}",) if left else ()
    if b"note" in (schema.metadata or {}):
        notes = (_text(schema.metadata[b"note"]), *notes)

    def rows(places: tuple[int, ...]) -> Iterator[FloatArray]:
        names = [fields[k].name for k in places]
        try:
            for batch in file.iter_batches(batch_size=SIZE, columns=names):
                columns = [batch.column(n).to_numpy(zero_copy_only=False) for n in names]
                kind = np.result_type(np.float32, *columns)
                yield np.stack([c.astype(kind, copy=False) for c in columns])
        except (pa.ArrowInvalid, OSError) as error:
            raise bad(path, f"it is damaged: {error}") from error

    return Table(
        columns=tuple(
            Channel(f.name, _text((f.metadata or {}).get(b"unit", b""))) for f in fields
        ),
        rows=rows, rate=_said(path, schema.metadata or {}), samples=file.metadata.num_rows,
        notes=notes,
    )  # fmt: skip


def hdf5(path: Path, *, group: str = "") -> Table:
    """Open an HDF5 recording: one-dimensional datasets of one group and one length."""
    import h5py  # pyright: ignore[reportMissingTypeStubs]

    try:
        file: Any = h5py.File(path, "r")
    except OSError as error:
        raise bad(
            path, f"HDF5 cannot open it: {error}", hint="was it written to its end?"
        ) from error
    sets: dict[str, Any] = {}

    def visit(name: str, item: Any) -> None:
        if isinstance(item, h5py.Dataset) and item.ndim == 1 and item.dtype.kind in "fiu":
            sets[name] = item

    if group and group not in file:
        raise bad(path, f"no group {group!r}", hint=f"it has {', '.join(file)}")
    home: Any = file[group] if group else file
    home.visititems(visit)
    if not sets:
        raise bad(path, "no one-dimensional datasets of numbers in it")
    lengths = {item.shape[0] for item in sets.values()}
    if len(lengths) > 1:
        raise bad(
            path, "its datasets have more than one length",
            value=", ".join(f"{n} {i.shape[0]}" for n, i in list(sets.items())[:6]),
            hint="name the group that holds one rate",
        )  # fmt: skip
    samples, items = lengths.pop(), list(sets.values())
    rate = _said(path, home.attrs) or _said(path, file.attrs)
    rate = rate or next((r for i in items if (r := _said(path, i.attrs))), None)

    def rows(places: tuple[int, ...]) -> Iterator[FloatArray]:
        try:
            for first in range(0, samples, SIZE):
                yield np.stack([items[k][first : first + SIZE].astype(float) for k in places])
        except OSError as error:
            raise bad(path, f"it is damaged: {error}") from error

    def unit(item: Any) -> str:
        return next((_text(item.attrs[u]) for u in _UNITS if u in item.attrs), "")

    names = [n.rsplit("/", 1)[-1] for n in sets]
    names = names if len(set(names)) == len(names) else list(sets)
    return Table(
        columns=tuple(Channel(n, unit(i)) for n, i in zip(names, items, strict=True)),
        rows=rows, rate=rate, samples=samples,
    )  # fmt: skip


def tdms(path: Path, *, group: str = "") -> Table:
    """Open a TDMS recording: the waveform channels of one group."""
    from nptdms import TdmsFile  # pyright: ignore[reportMissingTypeStubs]

    try:
        file: Any = TdmsFile.read_metadata(path)
    except (ValueError, OSError, EOFError) as error:
        raise bad(path, f"TDMS cannot open it: {error}") from error
    groups = {g.name: g for g in file.groups() if any(len(c) for c in g.channels())}
    if not groups:
        raise bad(path, "it holds no samples")
    if group and group not in groups:
        raise bad(path, f"no group {group!r}", hint=f"it has {', '.join(groups)}")
    if not group and len(groups) > 1:
        raise bad(path, "it has more than one group", value=", ".join(groups), hint="name one")
    items = [c for c in groups[group or next(iter(groups))].channels() if len(c)]
    items = [c for c in items if c.dtype is not None and c.dtype.kind in "fiu"]
    lengths = {len(c) for c in items}
    steps = {c.properties.get("wf_increment") for c in items}
    if len(lengths) > 1 or len(steps) > 1:
        raise bad(path, "its channels differ in length or rate", hint="name the group of one rate")
    samples, step = lengths.pop(), steps.pop()

    def rows(places: tuple[int, ...]) -> Iterator[FloatArray]:
        with TdmsFile.open(path) as file:
            home = [file[items[k].group_name][items[k].name] for k in places]
            for first in range(0, samples, SIZE):
                n = min(SIZE, samples - first)
                yield np.stack([np.asarray(c.read_data(first, n), float) for c in home])

    return Table(
        columns=tuple(Channel(c.name, str(c.properties.get("unit_string", ""))) for c in items),
        rows=rows, rate=1 / step if step else None, samples=samples,
    )  # fmt: skip


def mdf(path: Path) -> Table:
    """Open an MDF4 recording: the channels that share the longest group's time."""
    from asammdf import MDF  # pyright: ignore[reportMissingTypeStubs, reportMissingImports]

    try:
        file: Any = MDF(path)
    except Exception as error:
        raise bad(path, f"MDF cannot open it: {error}") from error
    sizes = [g.channel_group.cycles_nr for g in file.groups]
    if not sizes or not max(sizes):
        raise bad(path, "it holds no samples")
    best = int(np.argmax(sizes))
    found = file.groups[best].channels
    names = [c.name for c in found]
    master = file.masters_db.get(best, None)
    units: list[str] = []
    kept: list[int] = []
    for k in range(len(names)):
        sample = file.get(group=best, index=k, record_offset=0, record_count=1)
        if sample.samples.dtype.kind in "fiu" and sample.samples.ndim == 1:
            kept.append(k)
            units.append("s" if k == master else str(sample.unit))
    columns = tuple(
        Channel("time" if k == master else names[k], u) for k, u in zip(kept, units, strict=True)
    )

    def rows(places: tuple[int, ...]) -> Iterator[FloatArray]:
        for first in range(0, sizes[best], SIZE):
            parts: list[FloatArray] = []
            for k in places:
                piece = file.get(group=best, index=kept[k], record_offset=first, record_count=SIZE)
                values = piece.timestamps if kept[k] == master else piece.samples
                parts.append(np.asarray(values, dtype=float))
            yield np.stack(parts)

    return Table(columns=columns, rows=rows, samples=sizes[best])
