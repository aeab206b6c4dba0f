"""Parquet recordings, read a stretch at a time."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from cardan.core.arrays import FloatArray
from cardan.physics.signals.recording import SAMPLES_PER_BLOCK, Channel
from cardan.readers.base import (
    RecordingFileColumns,
    RecordingFormat,
    attribute_text,
    check_sample_count,
    max_page_bytes,
    missing_rows_error,
    oversized_data_error,
    rate_from_attributes,
    unreadable_recording_error,
)
from cardan.readers.parquet_validation import page_sizes
from cardan.readers.time_column import MidnightRollover


def open_parquet(path: Path, _group: str = "") -> RecordingFileColumns:
    """Open a Parquet recording: one column a channel, unit in its field's metadata."""
    import pyarrow as pa  # pyright: ignore[reportMissingTypeStubs]
    import pyarrow.parquet as pq  # pyright: ignore[reportMissingTypeStubs]

    try:
        # Without these two a whole file or row group is held back.
        file: Any = pq.ParquetFile(path, pre_buffer=False, buffer_size=1 << 20)
    except (pa.ArrowException, OSError) as error:
        raise unreadable_recording_error(
            path, f"Parquet cannot open it: {error}", hint="was it written to its end?"
        ) from error
    if not file.metadata.num_rows:
        raise unreadable_recording_error(
            path, "it holds no rows", value=f"{file.metadata.num_columns} columns of 0 rows"
        )
    check_sample_count(path, file.metadata.num_rows, file.metadata.num_columns)
    schema = file.schema_arrow
    clocks = [f for f in schema if _is_time_type(f.type)]
    kinds = (pa.types.is_floating, pa.types.is_integer, pa.types.is_decimal)
    numbers = [f for f in schema if any(kind(f.type) for kind in kinds)]
    fields = [f for f in schema if f in numbers or f in clocks]
    _check_page_sizes(path, file.metadata, {f.name for f in fields})
    left = [f.name for f in schema if f not in fields]
    note = f"not numbers, left out: {', '.join(left)}"
    notes = (note,) if left else ()
    if b"note" in (schema.metadata or {}):
        notes = (attribute_text(schema.metadata[b"note"]), *notes)

    def rows(places: tuple[int, ...]) -> Iterator[FloatArray]:
        names = [fields[k].name for k in places]
        begun: dict[str, _TimeColumn] = {f.name: _TimeColumn(f.type) for f in clocks}
        claimed, read = file.metadata.num_rows, 0
        try:
            for batch in file.iter_batches(batch_size=SAMPLES_PER_BLOCK, columns=names):
                read += len(batch)
                columns = [
                    begun[n].seconds(batch.column(n))
                    if n in begun
                    else _to_number_column(batch.column(n)).to_numpy(zero_copy_only=False)
                    for n in names
                ]
                kind = np.result_type(np.float32, *columns)
                yield np.stack([c.astype(kind, copy=False) for c in columns])
        except (pa.ArrowException, OSError) as error:
            raise unreadable_recording_error(path, f"it is damaged: {error}") from error
        if read != claimed:
            raise missing_rows_error(path, claimed, read)

    def channel(f: Any) -> Channel:
        if f in clocks:
            return Channel(f.name, "s")
        return Channel(f.name, attribute_text((f.metadata or {}).get(b"unit", b"")))

    return RecordingFileColumns(
        columns=tuple(channel(f) for f in fields),
        read_rows=rows,
        rate=rate_from_attributes(path, schema.metadata or {}),
        samples=file.metadata.num_rows,
        notes=notes,
        clock=fields.index(clocks[0]) if len(clocks) == 1 else None,
    )


def _to_number_column(column: Any) -> Any:
    """Return a column of numbers as NumPy knows them: decimals as floats."""
    import pyarrow as pa  # pyright: ignore[reportMissingTypeStubs]

    return column.cast(pa.float64()) if pa.types.is_decimal(column.type) else column


def _check_page_sizes(path: Path, of: Any, names: set[str]) -> None:
    """Refuse a Parquet file of which a page claims more bytes than its samples take.

    Raises
    ------
    InvalidFileError
        Before a sample is read: memory is taken for a page on its word.
    """
    with path.open("rb") as file:
        for g in range(of.num_row_groups):
            group = of.row_group(g)
            columns = (group.column(k) for k in range(group.num_columns))
            for column in columns:
                name = column.path_in_schema
                try:
                    most = max(page_sizes(file, column), default=0) if name in names else 0
                except ValueError as error:
                    raise unreadable_recording_error(path, f"it is damaged: {error}") from error
                if most > max_page_bytes(group.num_rows):
                    raise oversized_data_error(path, name, most, group.num_rows)


def _is_time_type(kind: Any) -> bool:
    """Whether values of an Arrow type are instants, times of day or times that have passed."""
    import pyarrow as pa  # pyright: ignore[reportMissingTypeStubs]

    return pa.types.is_timestamp(kind) or pa.types.is_duration(kind) or pa.types.is_time(kind)


class _TimeColumn:
    """Seconds of a clock in Arrow's types, as pieces pass: an instant has one in every zone."""

    def __init__(self, kind: Any) -> None:
        import pyarrow as pa  # pyright: ignore[reportMissingTypeStubs]

        self.unit = {"s": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9}[kind.unit]
        self.wide, self.days = (
            f"int{kind.bit_width}",
            MidnightRollover() if pa.types.is_time(kind) else None,
        )
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
        return time if self.days is None else self.days.add_days(time)


FORMAT = RecordingFormat(
    name="Parquet", extensions=(".parquet", ".pq"), open_columns=open_parquet,
    recognises=lambda head: head.startswith(b"PAR1"),
)  # fmt: skip
