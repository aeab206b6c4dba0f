"""Writes a recording as CSV, Parquet or RPC III, in chunks of bounded size.

All channels stand on one clock, as `cardan life` reads them: the time of the file, the channels of
slower clocks straight between their samples, and no value where a channel has none.
"""

import csv
import io
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from cardan.core.arrays import FloatArray
from cardan.core.errors import DesignError
from cardan.physics.signals.recording import SAMPLES_PER_BLOCK, Channel, Recording
from cardan.readers.csv import header_channels
from cardan.readers.rpc_writer import rpc_chunks
from cardan.readers.time_column import is_time_column, says_time

TIME = Channel("time", "s")
"""The clock of a table."""
CSV_VALUES_PER_CHUNK, PARQUET_VALUES_PER_CHUNK = 1 << 18, 1 << 22
"""Values that are written at once, some 30 MB: as text each takes a hundred bytes."""
MIN_ROWS_PER_CHUNK = 256
"""Rows that are written at once, however many channels there are."""


def recording_writer(path: Path) -> Callable[[Recording], Iterator[bytes]]:
    """Return what yields the file of a recording, by the ending of a file's name.

    It raises DesignError if the format does not hold the recording: RPC III no missing sample,
    and no more than 128 channels.

    Raises
    ------
    DesignError
        If no format that is written has this ending.
    """
    known = CHUNKS_BY_SUFFIX.get(path.suffix.lower())
    if known is None:
        msg = f"{path.name}: a recording is written as {', '.join(CHUNKS_BY_SUFFIX)}"
        raise DesignError(msg)
    return known


def with_channels(recording: Recording, names: tuple[str, ...]) -> Recording:
    """Return a recording of some of its channels, in the order of the names.

    Raises
    ------
    DesignError
        If it lacks one, or one is named twice.
    """
    for name in names:
        if names.count(name) > 1:
            msg = f"channel {name!r} is named twice"
            raise DesignError(msg)
    places = tuple(recording.index_of(name) for name in names)

    def read(wanted: tuple[int, ...]) -> Iterable[FloatArray]:
        return recording.read(tuple(places[k] for k in wanted))

    channels = tuple(recording.channels[k] for k in places)
    return replace(recording, channels=channels, sampling=(), read=read)


def _tables(recording: Recording, values: int) -> Iterator[FloatArray]:
    """Yield pieces (1 + k, n) of time and channels, of so many values.

    Raises
    ------
    DesignError
        If a channel would be taken for the time, or a value is infinite.
    """
    for channel in recording.channels:
        if is_time_column(channel) or says_time(channel):
            msg = f"{channel.name!r} would be taken for the time of the table: leave it out"
            raise DesignError(msg)
    done = 0
    rows = min(max(values // (1 + len(recording.channels)), MIN_ROWS_PER_CHUNK), SAMPLES_PER_BLOCK)
    for piece in recording.pieces(size=rows):
        if np.isinf(piece).any():
            name = recording.names[int(np.argmax(np.isinf(piece).any(axis=1)))]
            msg = f"{recording.name}: {name} has an infinite value"
            raise DesignError(msg)
        # Added at the end, so that the error of a late time is that of one sum.
        time = recording.clock_start + (done + np.arange(piece.shape[1])) / recording.rate
        yield np.vstack([time, piece])
        done += piece.shape[1]


def csv_chunks(recording: Recording) -> Iterator[bytes]:
    """Yield a recording as CSV: names and units above, numbers to their last digit, empty fields.

    Raises
    ------
    DesignError
        If a name or a unit would not be read back.
    """
    yield _csv_header((TIME, *recording.channels)).encode()
    for table in _tables(recording, CSV_VALUES_PER_CHUNK):
        rows = (",".join(["" if v != v else repr(v) for v in row]) for row in table.T.tolist())
        yield ("\n".join(rows) + "\n").encode()


def _csv_header(channels: tuple[Channel, ...]) -> str:
    """Return the lines above the numbers; units in a line of their own if a name looks like one."""
    names = [c.name for c in channels]
    in_names = [f"{c.name} [{c.unit}]" if c.unit else c.name for c in channels]
    for rows in ([in_names], [names, [c.unit or "-" for c in channels]]):
        text = io.StringIO()
        csv.writer(text, lineterminator="\n").writerows(rows)
        found, _ = header_channels(text.getvalue().splitlines(), ",", len(channels))
        if [(c.name, c.unit if c.unit != "-" else "") for c in found] == [
            (c.name, c.unit) for c in channels
        ]:
            return text.getvalue()
    named = ", ".join(in_names)
    msg = f"these names and units cannot stand above a CSV: {named}; write .parquet"
    raise DesignError(msg)


class _Sink(io.RawIOBase):
    """What Arrow writes into, kept until it is taken."""

    def __init__(self) -> None:
        self.held: list[bytes] = []
        self.length = 0

    def writable(self) -> bool:
        return True

    def write(self, data: Any) -> int:
        self.held.append(bytes(data))
        self.length += len(self.held[-1])
        return len(self.held[-1])

    def tell(self) -> int:
        return self.length

    def take(self) -> bytes:
        """Return what was written since it was taken last."""
        data = b"".join(self.held)
        self.held.clear()
        return data


def parquet_chunks(recording: Recording) -> Iterator[bytes]:
    """Yield a recording as Parquet: a column a channel, its unit in the field's metadata."""
    import pyarrow as pa  # pyright: ignore[reportMissingTypeStubs]
    import pyarrow.parquet as pq  # pyright: ignore[reportMissingTypeStubs]

    schema: Any = pa.schema(
        [
            pa.field(c.name, pa.float64(), metadata={"unit": c.unit} if c.unit else None)
            for c in (TIME, *recording.channels)
        ],
        metadata={"note": "; ".join(recording.notes)} if recording.notes else None,
    )
    sink = _Sink()
    # Every value is another: a dictionary of them is no gain.
    writer: Any = pq.ParquetWriter(sink, schema, use_dictionary=False, compression="zstd")
    for table in _tables(recording, PARQUET_VALUES_PER_CHUNK):
        columns = [pa.array(row, from_pandas=True) for row in table]
        writer.write_table(pa.table(columns, schema=schema))
        yield sink.take()
    writer.close()
    yield sink.take()


CHUNKS_BY_SUFFIX: Mapping[str, Callable[[Recording], Iterator[bytes]]] = {
    ".parquet": parquet_chunks,
    ".csv": csv_chunks,
    ".rsp": partial(rpc_chunks, time_type="RESPONSE"),
    ".rpc": partial(rpc_chunks, time_type="RESPONSE"),
    ".tim": partial(rpc_chunks, time_type="RESPONSE"),
    ".drv": rpc_chunks,
}
"""What writes each ending."""
