"""Opens recordings: CSV of any dialect, Parquet, HDF5, TDMS, MDF4 and WAV, in pieces.

A recording is never guessed at. A value that is not a number, a row cut short, time that
runs backwards: an error names the file, the place and what to do. A hole in time becomes
missing samples, which the survey of the recording reports.
"""

import re
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from cardan.base.arrays import FloatArray
from cardan.base.errors import BadFile, Problem
from cardan.border.document import visible
from cardan.fatigue.recording import Channel, Recording

TIME_UNITS = {
    "": 1.0, "s": 1.0, "sec": 1.0, "ms": 1e-3, "us": 1e-6, "µs": 1e-6, "μs": 1e-6, "ns": 1e-9,
    "min": 60.0, "h": 3600.0,
}  # fmt: skip
_TIME = re.compile(
    r"(time|timestamp|zeit|tempo|temps|t)(?:[\s_]*[\[(]?(\w+)[\])]?)?", re.IGNORECASE
)
"""A clock, and the unit its name ends in: `Time_ms`. A `T` by itself is no clock."""


def bad(path: Path, message: str, *, hint: str = "", line: int = 0, value: str = "") -> BadFile:
    """Return the error of a recording that cannot be read as meant."""
    return BadFile(str(path), (Problem(message=message, hint=hint, line=line, value=value),))


DAY = 86400.0


class Days:
    """Carries times of day on past midnight, as pieces pass; what has a date goes on as it is."""

    def __init__(self) -> None:
        self.last, self.midnights = np.nan, 0

    def on(self, time: FloatArray) -> FloatArray:
        """Return times (n,) s with the days before them."""
        step = np.diff(time, prepend=self.last)
        # Nobody's clock goes back by half a day.
        midnights = self.midnights + np.cumsum((step < -DAY / 2) & (time < DAY))
        if time.size:
            self.last, self.midnights = float(time[-1]), int(midnights[-1])
        return time + DAY * midnights


@dataclass(frozen=True, kw_only=True)
class Table:
    """What a reader found: columns of equal length, time perhaps among them.

    `rows` takes places of columns and yields pieces (k, n). `rate` is what the file itself
    says, if it does, and `start` when its first sample was taken, s. `group` names it among
    those `beside` it, which have other rates.
    """

    columns: tuple[Channel, ...]
    rows: Callable[[tuple[int, ...]], Iterable[FloatArray]]
    rate: float | None = None
    samples: int | None = None
    notes: tuple[str, ...] = ()
    start: float = 0.0
    group: str = ""
    beside: tuple["Table", ...] = ()


LIVELY = 50
"""Samples a byte of a file that it may hold at most: a real one holds less than one."""
LOST = 5
"""Usual steps of a slower channel without a value from which there is none: so many times a message
of a bus may fail to come before who listens gives it up. House practice, assumed."""
BESIDE = 1 << 26
"""Samples of slower channels that are held in memory, beside the fastest."""


def budget(path: Path, samples: int, channels: int = 1) -> None:
    """Refuse a file that claims more samples than its bytes can hold.

    Raises
    ------
    BadFile
        Before anything of it is read.
    """
    size = path.stat().st_size
    if samples > LIVELY * size:
        raise bad(
            path, "it claims more samples than it can hold",
            value=f"{samples:.4g} samples of {channels} channels in {size} bytes",
            hint="a file of one value throughout is no recording",
        )  # fmt: skip


def joined(path: Path, tables: Iterable[Table]) -> Table:
    """Return tables of several rates as one: the fastest, with the others beside it.

    Raises
    ------
    BadFile
        If nothing says how fast one of them is.
    """
    found = list(tables)
    if len(found) == 1:
        return found[0]
    rates: list[float] = []
    for one in found:
        clock = _clock(path, one, None)
        if one.rate is None and clock is None:
            raise bad(
                path, "its channels have more than one length",
                value=", ".join(
                    f"{t.group}/{t.columns[0].name} {t.samples}".lstrip("/") for t in found[:6]
                ),
                hint="give each group its rate or a time column, or name the group of one rate",
            )  # fmt: skip
        rates.append(one.rate or _rate(path, one, clock or 0))
    fastest = max(range(len(found)), key=lambda k: (rates[k], found[k].samples or 0))
    others = tuple(
        replace(t, rate=r)
        for k, (t, r) in enumerate(zip(found, rates, strict=True))
        if k != fastest
    )
    if sum((t.samples or 0) * len(t.columns) for t in others) > BESIDE:
        raise bad(
            path, "its slower channels are too long to be held beside the fastest",
            hint="name the group of one rate",
        )  # fmt: skip
    return replace(found[fastest], beside=others)


def open_recording(
    path: Path, *, rate: float | None = None, time: str | None = None, group: str = ""
) -> Recording:
    """Open a recording by the ending of its name.

    Parameters
    ----------
    path
        `.csv .txt .tsv .asc .dat`, `.parquet`, `.h5 .hdf5`, `.tdms`, `.mf4 .mdf`, `.wav`.
    rate : Hz
        Takes the place of the file's own rate or time column, which is then not looked at.
    time
        Name of the time column, `NAME:UNIT` where its unit is not the file's or its name's;
        found by its name (time, t, Zeit, tempo) otherwise.
    group
        Of HDF5, TDMS or MDF4 to read, where there is more than one; no other file has any.

    Raises
    ------
    BadFile
        If it cannot be read as meant: every message says what to try.
    """
    if not path.is_file():
        raise bad(path, "no such file")
    reader = _READERS.get(path.suffix.lower())
    if reader is None:
        known = ", ".join(sorted(_READERS))
        raise bad(path, f"no reader for {path.suffix!r} files", hint=f"known are {known}")
    if group and reader not in (_hdf5, _tdms, _mdf):
        raise bad(path, f"no group {group!r}", hint="only files of HDF5, TDMS and MDF4 have groups")
    if path.stat().st_size == 0:
        raise bad(path, "the file is empty")
    try:
        table = reader(path, group)
    except ImportError as error:
        extra = "mdf" if path.suffix.lower() in (".mf4", ".mdf") else "recordings"
        raise bad(
            path, f"reading it needs {error.name}", hint=f"pip install 'cardan[{extra}]'"
        ) from error
    table = _seen(table)
    table = replace(table, beside=tuple(_apart(t, table) for t in map(_seen, table.beside)))
    _unique(path, table)
    table, time = _timed(path, table, time)
    clock = _clock(path, table, time)
    places = tuple(k for k in range(len(table.columns)) if k != clock)
    channels = tuple(table.columns[k] for k in places)
    if not channels:
        raise bad(path, "it holds no channel beside time", hint="; ".join(table.notes))
    if rate is None and table.rate is None and clock is None:
        raise bad(
            path, "nothing says how fast it was sampled",
            hint="give the rate (--rate HZ), or the name of the time column (--time COLUMN)",
        )  # fmt: skip
    by_clock = rate is None and clock is not None
    if by_clock:
        assert clock is not None
        rate = _rate(path, table, clock)
    elif rate is not None and clock is not None:
        table = replace(table, notes=(*table.notes, *_against(path, table, clock, rate)))

    def read(wanted: tuple[int, ...]) -> Iterable[FloatArray]:
        columns = tuple(places[k] for k in wanted)
        if not by_clock:
            return table.rows(columns)
        assert clock is not None
        assert rate is not None
        second = _second(path, table.columns[clock])
        return _evenly(path, table.rows((clock, *columns)), rate=rate, second=second)

    final = rate or table.rate
    assert final is not None
    if not 0 < final < np.inf:
        raise bad(path, "the sample rate must be above 0", value=f"{final:g} Hz")
    start = table.start
    if by_clock and table.beside:
        assert clock is not None
        first = next(iter(table.rows((clock,))))[0, 0]
        start = float(first) * _second(path, table.columns[clock])
    own = Recording(
        name=path.name, channels=channels, rate=final, read=read,
        samples=table.samples, notes=table.notes,
    )  # fmt: skip
    return _beside(path, own, table.beside, start) if table.beside else own


def _seen(table: Table) -> Table:
    """Return a table without what nobody sees: names of a logger may hold anything."""
    columns = tuple(Channel(visible(c.name), visible(c.unit)) for c in table.columns)
    return replace(table, columns=columns, notes=tuple(map(visible, table.notes)))


def _apart(table: Table, first: Table) -> Table:
    """Return a table beside another with its group before the names that both have."""
    taken = {c.name for c in first.columns}
    columns = tuple(
        Channel(f"{table.group}/{c.name}", c.unit) if c.name in taken and not ticks(c) else c
        for c in table.columns
    )
    return replace(table, columns=columns)


def _beside(path: Path, own: Recording, others: Sequence[Table], start: float) -> Recording:
    """Lay slower channels on the clock of the fastest, straight between their samples."""
    channels = list(own.channels)
    laid: list[tuple[FloatArray, FloatArray]] = []
    said: list[str] = []
    lost: list[str] = []
    for table in others:
        clock = _clock(path, table, None)
        assert table.rate is not None
        whole = np.concatenate(list(table.rows(tuple(range(len(table.columns))))), axis=-1)
        if clock is None:
            time = table.start + np.arange(whole.shape[1]) / table.rate
        else:
            time = whole[clock] * _second(path, table.columns[clock])
        if not (np.diff(time) > 0).all():
            raise bad(path, f"the time of group {table.group!r} stands still or runs backwards")
        # Half way through a hole nobody knows, so nothing goes straight across it.
        after = np.flatnonzero(np.diff(time) > LOST * np.median(np.diff(time))) + 1
        begun, holes = time[after - 1] - start, time[after] - time[after - 1]
        amid = (time[after - 1] + time[after]) / 2
        time, whole = np.insert(time, after, amid), np.insert(whole, after, np.nan, axis=1)
        names: list[str] = []
        for k, column in enumerate(table.columns):
            if k != clock:
                channels.append(column)
                names.append(column.name)
                laid.append((time - start, whole[k]))
        if names:
            said.append(f"{', '.join(names)} ({table.rate:.6g} Hz)")
        if after.size:
            note = (
                f"{', '.join(names)}: no value for {holes.sum():.6g} s, longest hole "
                f"{holes.max():.6g} s, the first at {begun[0]:.6g} s"
            )
            lost.append(note)
    count = len(own.channels)

    def read(wanted: tuple[int, ...]) -> Iterator[FloatArray]:
        mine = tuple(k for k in wanted if k < count) or (0,)
        begun = 0
        for piece in own.read(mine):
            time = (begun + np.arange(piece.shape[1])) / own.rate
            rows = [
                piece[mine.index(k)]
                if k < count
                else np.interp(time, *laid[k - count], left=np.nan, right=np.nan)
                for k in wanted
            ]
            begun += piece.shape[1]
            yield np.stack(rows)

    beside = (note for table in others for note in table.notes)
    note = f"laid on one clock of {own.rate:g} Hz, straight between samples: {'; '.join(said)}"
    found = replace(
        own, channels=tuple(channels), read=read, notes=(*own.notes, *beside, note, *lost)
    )
    for name in found.names:
        if found.names.count(name) > 1:
            raise bad(path, "two channels have one name", value=repr(name), hint="name the group")
    return found


def _unique(path: Path, table: Table) -> None:
    names = [c.name for c in table.columns]
    for name in names:
        if names.count(name) > 1:
            raise bad(path, "two channels have one name", value=repr(name))


def _timed(path: Path, table: Table, time: str | None) -> tuple[Table, str | None]:
    """Return a table whose clock has the unit that was said, and the clock's name without it."""
    names = [c.name for c in table.columns]
    name, colon, unit = (time or "").rpartition(":")
    if time is None or time in names or not colon or name not in names:
        return table, time
    if unit not in TIME_UNITS:
        raise bad(
            path, f"unknown unit of time column {name!r}", value=repr(unit),
            hint=f"known are {', '.join(u for u in TIME_UNITS if u)}",
        )  # fmt: skip
    columns = tuple(replace(c, unit=unit) if c.name == name else c for c in table.columns)
    return replace(table, columns=columns), name


def _clock(path: Path, table: Table, time: str | None) -> int | None:
    """Place of the time column, if there is one."""
    names = [c.name for c in table.columns]
    if time is not None:
        if time not in names:
            raise bad(path, f"no time column {time!r}", hint=f"it has {', '.join(names)}")
        return names.index(time)
    found = [k for k, c in enumerate(table.columns) if ticks(c)]
    plain = [k for k in found if len(names[k].strip()) > 1]
    found = plain or found  # a column t beside one called time is something else
    return found[0] if len(found) == 1 else None


def ticks(column: Channel) -> bool:
    """Whether a column is a clock by its name."""
    name = column.name.strip()
    match = _TIME.fullmatch(name)
    return match is not None and name != "T" and (match[2] or "") in TIME_UNITS


def _clock_unit(column: Channel) -> str:
    """Return the unit of a time column: that of the file, or of its name; "" without."""
    match = _TIME.fullmatch(column.name.strip())
    return column.unit.strip() or ((match and match[2]) or "")


def _second(path: Path, column: Channel) -> float:
    """Seconds in one unit of the time column: that of the file, or of its name."""
    unit = _clock_unit(column)
    if unit not in TIME_UNITS:
        raise bad(
            path, f"unknown unit of time column {column.name!r}", value=repr(unit),
            hint=f"known are {', '.join(u for u in TIME_UNITS if u)}",
        )  # fmt: skip
    return TIME_UNITS[unit]


def _against(path: Path, table: Table, clock: int, rate: float) -> tuple[str, ...]:
    """Return what a time column says against a rate that was given."""
    try:
        own = _rate(path, table, clock)
    except BadFile:
        return ()  # that is why it was given
    if abs(rate / own - 1) < 0.01:
        return ()
    note = f"taken at {rate:g} Hz, as was said: by its time column it is {own:g} Hz"
    return (note,)


def _rate(path: Path, table: Table, clock: int) -> float:
    """Sample rate from the first rows of the time column."""
    first = next(iter(table.rows((clock,))), np.empty((1, 0)))
    t = first[0, : 1 << 16] * _second(path, table.columns[clock])
    step = np.diff(t)
    if step.size < 2 or not np.isfinite(step).all():
        raise bad(path, "its time column is too short or has holes", hint="give the rate")
    typical = float(np.median(step))
    if not typical > 0:
        raise bad(path, "its time column stands still or runs backwards", hint="give the rate")
    even = np.abs(step - typical) < 0.4 * typical
    # Printed times are rounded; their mean over a long stretch is not.
    rate = 1 / float(step[even].mean())
    whole = round(rate)
    return float(whole) if whole and abs(rate / whole - 1) < 1e-5 else rate


def _evenly(
    path: Path, rows: Iterable[FloatArray], *, rate: float, second: float
) -> Iterator[FloatArray]:
    """Yield rows without their time, holes filled with nan; refuse time that is not even."""
    last, row = np.nan, 0
    for piece in rows:
        t = piece[0] * second
        if not row and t.size:
            last = float(t[0]) - 1 / rate
        steps = np.diff(np.concatenate([[last], t])) * rate
        whole = np.rint(steps)
        wrong = ~((whole >= 1) & (np.abs(steps - whole) < 0.4))
        if whole.size > 20 and np.mean(whole > 1) > 0.2:
            k = int(np.argmax(whole > 1))
            raise bad(
                path, f"its clock changes its rate near row {row + k + 1}",
                value=f"steps of {np.median(whole[whole > 1]):g} samples of the rate it began with",
                hint="split or resample it",
            )  # fmt: skip
        even = whole == 1
        if np.count_nonzero(even) > 20 and abs(float(steps[even].mean()) - 1) > 0.01:
            raise bad(
                path, f"its clock runs at another rate from about row {row + 1}",
                value=f"{rate / float(steps[even].mean()):.6g} Hz, and {rate:.6g} Hz at first",
                hint="split or resample it",
            )  # fmt: skip
        if wrong.any():
            k = int(np.argmax(wrong))
            raise bad(
                path, f"time is not even at row {row + k + 1}",
                value=f"{t[k]:.9g} s, {steps[k]:.3g} sample steps after the row before",
                hint="resample it, or give the rate to read rows as evenly spaced",
            )  # fmt: skip
        if t.size:
            last, row = float(t[-1]), row + t.size
        hole = whole.sum() - whole.size
        if hole > 3600 * rate:
            raise bad(path, f"a hole of {hole / rate:.6g} s in time", hint="split the recording")
        if hole:
            place = np.cumsum(whole).astype(np.int64) - 1
            filled = np.full((piece.shape[0] - 1, int(place[-1]) + 1), np.nan)
            filled[:, place] = piece[1:]
            yield filled
        else:
            yield piece[1:]


def _csv(path: Path, _group: str) -> Table:
    from cardan.files.recording_csv import table

    return table(path)


def _parquet(path: Path, _group: str) -> Table:
    from cardan.files.recording_tables import parquet

    return parquet(path)


def _hdf5(path: Path, group: str) -> Table:
    from cardan.files.recording_tables import hdf5

    return hdf5(path, group=group)


def _tdms(path: Path, group: str) -> Table:
    from cardan.files.recording_tdms import tdms

    return tdms(path, group=group)


def _mdf(path: Path, group: str) -> Table:
    from cardan.files.recording_tables import mdf

    return mdf(path, group=group)


def _wav(path: Path, _group: str) -> Table:
    from cardan.files.recording_wav import table

    return table(path)


_READERS: dict[str, Callable[[Path, str], Table]] = {
    ".csv": _csv, ".txt": _csv, ".tsv": _csv, ".asc": _csv, ".dat": _csv,
    ".parquet": _parquet, ".pq": _parquet,
    ".h5": _hdf5, ".hdf5": _hdf5,
    ".tdms": _tdms, ".mf4": _mdf, ".mdf": _mdf, ".wav": _wav,
}  # fmt: skip

ENDINGS = tuple(_READERS)
"""How a recording's name ends, by what reads it."""
