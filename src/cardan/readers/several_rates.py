"""Tables of a file, each with a time axis of its own, as one recording.

Tables of the fastest rate keep their samples and lie where their file says that they begin, to the
nearest sample; slower ones are laid straight between those. Outside its own time a channel is
unknown, and a note says so.
"""

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path

import numpy as np

from cardan.core.arrays import FloatArray
from cardan.physics.signals.recording import (
    SAMPLES_PER_BLOCK,
    Channel,
    ChannelSampling,
    Recording,
    rechunk_to_block_size,
)
from cardan.readers.base import (
    RecordingFileColumns,
    check_sample_count,
    check_sample_rate,
    unreadable_recording_error,
)
from cardan.readers.time_column import TimeAxis, fill_time_gaps, is_time_column, nominal_rate

MAX_TIME_STEPS_WITHOUT_VALUE = 5
"""Usual steps of a slower channel without a value from which there is none: so many times a message
of a bus may fail to come before a listener gives it up. Engineering judgement, assumed."""
MAX_SLOWER_CHANNEL_SAMPLES_IN_MEMORY = 1 << 26
"""Samples of slower channels that are held in memory, in addition to the fastest."""
MAX_RELATIVE_RATE_DIFFERENCE = 1e-9
"""Of two tables whose samples are of one rate."""


@dataclass(frozen=True)
class TimedTable:
    """A table of a file, and when its samples were taken."""

    table: RecordingFileColumns
    axis: TimeAxis

    @property
    def places(self) -> tuple[int, ...]:
        """Places of its channels: the clock is none."""
        return tuple(k for k in range(len(self.table.columns)) if k != self.axis.clock)

    @property
    def channels(self) -> tuple[Channel, ...]:
        """Its channels."""
        uneven = self.axis.uneven
        own = (self.table.columns[k] for k in self.places)
        return tuple(replace(c, uneven=c.uneven or uneven) for c in own)

    @property
    def length(self) -> float:
        """Seconds from its first sample to behind its last, where its samples are counted."""
        return (self.table.samples or 0) / self.axis.rate

    @property
    def label(self) -> str:
        """Its group, or else its channels."""
        return self.table.group or ", ".join(c.name for c in self.channels)

    def read_even(self, path: Path, wanted: tuple[int, ...]) -> Iterator[FloatArray]:
        """Yield its channels (k, n), evenly spaced from its first sample on."""
        columns = tuple(self.places[k] for k in wanted)
        if self.axis.clock is None:
            yield from self.table.read_rows(columns)
        else:
            rows = self.table.read_rows((self.axis.clock, *columns))
            yield from fill_time_gaps(path, rows, self.axis)


def with_group_prefix(table: RecordingFileColumns, taken: Iterable[str]) -> RecordingFileColumns:
    """Return a table joined to others with its group before the names that they have as well."""
    known = set(taken)
    columns = tuple(
        replace(c, name=f"{table.group}/{c.name}")
        if c.name in known and not is_time_column(c)
        else c
        for c in table.columns
    )
    return replace(table, columns=columns)


def even_log(path: Path, timed: TimedTable) -> TimedTable:
    """Return a table of uneven rows on a clock of their usual step, from its first row on.

    Raises
    ------
    InvalidFileError
        If there are more of them than can be held.
    """
    _check_held_size(path, [timed])
    laid = _LaidTable.of(path, timed, timed.axis.start)
    rate = nominal_rate(laid.step)
    samples = int(np.floor(laid.last * rate + 1e-9)) + 1
    check_sample_rate(path, rate)
    check_sample_count(path, samples)

    def rows(places: tuple[int, ...]) -> Iterator[FloatArray]:
        series = [laid.series[k]() for k in places]
        for first in range(0, samples, SAMPLES_PER_BLOCK):
            time = np.arange(first, min(first + SAMPLES_PER_BLOCK, samples)) / rate
            yield np.stack([one.at(time) for one in series])

    notes = (
        *timed.table.notes, f"{laid.names}: frames came unevenly, laid on a clock of {rate:g} Hz",
        *laid.notes,
    )  # fmt: skip
    table = replace(
        timed.table, columns=timed.channels, read_rows=rows, samples=samples, clock=None,
        rate=rate, start=timed.axis.start, notes=notes, frames=False, held=(),
    )  # fmt: skip
    return TimedTable(table, TimeAxis(rate=rate, start=timed.axis.start))


def align_tables(path: Path, tables: Sequence[TimedTable]) -> Recording:
    """Return tables as one recording at the rate of the fastest, from its first sample on.

    Raises
    ------
    InvalidFileError
        If a slower one runs backwards or is too long to be held, or two channels have one name.
    """
    even_tables = [t for t in tables if not t.axis.uneven]
    main = max(even_tables, key=lambda t: (t.axis.rate, t.table.samples or 0))
    near, far = _overlapping(main, tables)
    rate = main.axis.rate
    same_rate = (
        t
        for t in near
        if not t.axis.uneven and abs(t.axis.rate / rate - 1) <= MAX_RELATIVE_RATE_DIFFERENCE
    )
    peers = [main, *(t for t in same_rate if t is not main)]
    slower = [t for t in near if not any(t is p for p in peers)]
    start = min(p.axis.start for p in peers)
    _check_held_size(path, slower)
    even = _EvenTables(path, peers, start)
    laid = [_LaidTable.of(path, t, start) for t in slower]
    channels = tuple(c for t in (*peers, *slower) for c in t.channels)
    _check_unique_names(path, channels)
    count = sum(len(p.places) for p in peers)
    values = [series for one in laid for series in one.series]

    def read(wanted: tuple[int, ...]) -> Iterator[FloatArray]:
        mine = tuple(k for k in wanted if k < count) or (0,)
        series = {k: values[k - count]() for k in wanted if k >= count}
        begun = 0
        for piece in even.read(mine):
            time = (begun + np.arange(piece.shape[1])) / rate
            rows = [piece[mine.index(k)] if k < count else series[k].at(time) for k in wanted]
            begun += piece.shape[1]
            yield np.stack(rows)

    notes = [note for t in (*peers, *slower) for note in (*t.table.notes, *t.axis.notes)]
    interpolated = [(one, t) for one, t in zip(laid, slower, strict=True) if one.interpolated]
    if interpolated:
        said = "; ".join(
            f"{', '.join(one.interpolated)} ({t.axis.rate:.6g} Hz)" for one, t in interpolated
        )
        notes.append(f"laid on one clock of {rate:g} Hz, straight between samples: {said}")
    notes += [note for one in laid for note in one.notes]
    notes += _outside_notes(even, peers, laid)
    notes += [
        f"{t.label}: left out, it was recorded at another time, {t.axis.start - start:.6g} s from "
        "the beginning; name the group to read it"
        for t in far
    ]
    return Recording(
        name=path.name, channels=channels, rate=rate,
        read=read if len(tables) > 1 else (lambda wanted: main.read_even(path, wanted)),
        samples=even.samples, notes=tuple(dict.fromkeys(notes)), clock_start=start,
        sampling=(*even.sampling(rate), *(s for one in laid for s in one.sampling)),
    )  # fmt: skip


def _check_held_size(path: Path, slower: Sequence[TimedTable]) -> None:
    """Refuse more samples of slower channels than are held in memory."""
    held = ((1 if t.table.frames else len(t.table.columns), t.table.samples or 0) for t in slower)
    samples = sum(columns * samples for columns, samples in held)
    if samples > MAX_SLOWER_CHANNEL_SAMPLES_IN_MEMORY:
        raise unreadable_recording_error(
            path, "its slower channels are too long to be held together with the fastest",
            hint="name the group of one rate",
        )  # fmt: skip


def _overlapping(
    main: TimedTable, tables: Sequence[TimedTable]
) -> tuple[list[TimedTable], list[TimedTable]]:
    """Return the tables that were recorded while the main one was, and those that were not."""
    near: list[TimedTable] = []
    far: list[TimedTable] = []
    begun, ended = main.axis.start, main.axis.start + main.length
    for t in tables:
        # Holes make a table longer than its samples: by how much is unknown.
        known = t.axis.clock is None and main.axis.clock is None and main.table.samples
        after = t.axis.start >= ended + (0 if known else max(main.length, 3600.0))
        before = t.axis.start + t.length <= begun - (0 if known else max(t.length, 3600.0))
        (far if t is not main and (after or before) else near).append(t)
    return near, far


class _EvenTables:
    """Tables of one rate side by side: each begins where it begins, to the nearest sample."""

    def __init__(self, path: Path, tables: Sequence[TimedTable], start: float) -> None:
        self.path, self.tables = path, tables
        rate = tables[0].axis.rate
        self.begun = [round((t.axis.start - start) * rate) for t in tables]
        self.ended: list[int | None] = [
            first + t.table.samples
            if t.axis.clock is None and t.table.samples is not None
            else None
            for first, t in zip(self.begun, tables, strict=True)
        ]
        for k, t in enumerate(tables):
            if self.ended[k] is None and len(tables) > 1:
                pieces = (p.shape[1] for p in t.read_even(path, (0,)))
                self.ended[k] = self.begun[k] + sum(pieces)
        ends = [e for e in self.ended if e is not None]
        self.samples = max(ends) if len(ends) == len(tables) else None

    def sampling(self, rate: float) -> Iterator[ChannelSampling]:
        """Yield how each channel was sampled: at the rate of the recording."""
        for t, first, last in zip(self.tables, self.begun, self.ended, strict=True):
            end = None if last is None or last == self.samples else last / rate
            for _ in t.channels:
                yield ChannelSampling(rate=rate, first=first / rate, last=end)

    def read(self, wanted: tuple[int, ...]) -> Iterator[FloatArray]:
        """Yield channels (k, n), counted through all tables."""
        if len(self.tables) == 1:
            yield from self.tables[0].read_even(self.path, wanted)
            return
        assert self.samples is not None
        streams: list[tuple[list[int], Iterator[FloatArray]]] = []
        before = 0
        for k, t in enumerate(self.tables):
            own = [n for n, w in enumerate(wanted) if before <= w < before + len(t.places)]
            if own:
                of = tuple(wanted[n] - before for n in own)
                pieces = rechunk_to_block_size(self._whole(k, of), size=SAMPLES_PER_BLOCK)
                streams.append((own, pieces))
            before += len(t.places)
        for first in range(0, self.samples, SAMPLES_PER_BLOCK):
            piece = np.empty((len(wanted), min(SAMPLES_PER_BLOCK, self.samples - first)))
            for own, pieces in streams:
                piece[own] = next(pieces)
            yield piece

    def _whole(self, k: int, wanted: tuple[int, ...]) -> Iterator[FloatArray]:
        """Yield channels of a table, unknown before it begins and behind its end."""
        assert self.samples is not None
        yield from _unknown(len(wanted), self.begun[k])
        there = self.begun[k]
        for piece in self.tables[k].read_even(self.path, wanted):
            there += piece.shape[1]
            yield piece
        yield from _unknown(len(wanted), self.samples - there)


def _unknown(channels: int, samples: int) -> Iterator[FloatArray]:
    """Yield pieces (channels, n) of unknown samples."""
    for first in range(0, samples, SAMPLES_PER_BLOCK):
        yield np.full((channels, min(SAMPLES_PER_BLOCK, samples - first)), np.nan)


@dataclass(frozen=True)
class _Series:
    """Values (n,) at times (n,) s from the first sample: between them straight, or held."""

    time: FloatArray
    values: FloatArray
    held: bool

    def at(self, time: FloatArray) -> FloatArray:
        """Return values at times (m,), nan outside."""
        if not self.held:
            return np.interp(time, self.time, self.values, left=np.nan, right=np.nan)
        place = np.searchsorted(self.time, time, side="right") - 1
        inside = (place >= 0) & (time <= self.time[-1])
        return np.where(inside, self.values[np.maximum(place, 0)], np.nan)


@dataclass(frozen=True)
class _LaidTable:
    """Channels of a slower table, from when to when they are known, s, and what is to be said.

    Of frames, of which there may be hundreds of channels, only those that are read are held.
    """

    names: str
    interpolated: tuple[str, ...]
    series: tuple[Callable[[], _Series], ...]
    first: float
    last: float
    step: float
    sampling: tuple[ChannelSampling, ...]
    notes: tuple[str, ...]

    @staticmethod
    def of(path: Path, timed: TimedTable, start: float) -> "_LaidTable":
        """Return a table's channels as they lie behind a start, s."""
        table, axis = timed.table, timed.axis
        integer = np.ones(len(table.columns), bool)
        low = np.full(len(table.columns), np.inf)
        high = -low
        pieces: list[FloatArray] = []
        for piece in table.read_rows(tuple(range(len(table.columns)))):
            integer &= (np.isnan(piece) | (piece == np.rint(piece))).all(axis=1)
            low = np.fmin(low, np.fmin.reduce(piece, axis=1, initial=np.inf))
            high = np.fmax(high, np.fmax.reduce(piece, axis=1, initial=-np.inf))
            pieces.append(piece[[axis.clock or 0]] if table.frames else piece)
        whole = np.concatenate(pieces, axis=-1).astype(float)
        if axis.clock is None:
            time = axis.start - start + np.arange(whole.shape[1]) / axis.rate
        else:
            time = axis.seconds(whole[0 if table.frames else axis.clock]) - start
        step = np.diff(time)
        if not (step > 0).all():
            raise unreadable_recording_error(
                path, f"the time of group {table.group!r} stands still or runs backwards",
                hint="name the group to read (--group)",
            )  # fmt: skip
        usual = float(np.median(step))
        # Written as it changes: what it was last, it is until the next.
        uneven = np.mean(np.abs(step - usual) > 0.4 * usual) > 0.2
        notes: list[str] = []
        names = ", ".join(c.name for c in timed.channels)
        first, last = float(time[0]), float(time[-1])
        after = np.flatnonzero(step > MAX_TIME_STEPS_WITHOUT_VALUE * usual) + 1
        if uneven:
            after = after[:0]
        # The middle of a hole is unknown, so nothing goes straight across it.
        begun, holes = time[after - 1], time[after] - time[after - 1]
        amid = (time[after - 1] + time[after]) / 2
        inside = time > -usual / 2

        def sampling(k: int) -> ChannelSampling:
            counted = not (uneven or table.frames)
            return ChannelSampling(
                rate=axis.rate, first=first, last=last + usual,
                known=int(np.count_nonzero(~np.isnan(whole[k]) & inside)) if counted else None,
                low=float(low[k]), high=float(high[k]),
            )  # fmt: skip

        sampled = tuple(map(sampling, timed.places))
        time = np.insert(time, after, amid)

        def series(k: int, *, held: bool) -> _Series:
            own = whole[k] if not table.frames else np.concatenate(
                [piece[0] for piece in table.read_rows((k,))]
            )  # fmt: skip
            return _Series(time, np.insert(own, after, np.nan), held)

        held = [k in table.held or bool(uneven and integer[k]) for k in timed.places]
        if any(held):
            states = ", ".join(
                c.name for c, holds in zip(timed.channels, held, strict=True) if holds
            )
            notes.append(f"{states}: written as it changes, each value holds until the next")
        if after.size:
            notes.append(
                f"{names}: no value for {holes.sum():.6g} s, longest hole {holes.max():.6g} s, "
                f"the first at {begun[0]:.6g} s"
            )
        each = (partial(series, k, held=h) for k, h in zip(timed.places, held, strict=True))
        between = tuple(c.name for c, h in zip(timed.channels, held, strict=True) if not h)
        return _LaidTable(
            names, between, tuple(each), first, last, max(usual, 0.0), sampled, tuple(notes)
        )


def _outside_notes(
    even: _EvenTables, peers: Sequence[TimedTable], laid: Sequence[_LaidTable]
) -> Iterator[str]:
    """Yield what begins or ends elsewhere than the recording does."""
    rate = peers[0].axis.rate
    # Holes make it longer, and it is not read yet.
    whole = peers[0].length if even.samples is None else even.samples / rate
    ends = [
        (
            ", ".join(c.name for c in t.channels),
            first / rate,
            whole if last is None else last / rate,
            1 / rate,
        )
        for t, first, last in zip(peers, even.begun, even.ended, strict=True)
    ]
    ends += [(one.names, one.first, one.last + one.step, one.step) for one in laid]
    for names, first, last, step in ends:
        if names and (first > 1.5 * step or last < whole - 1.5 * step):
            yield (
                f"{names}: known from {max(first, 0):.6g} to {min(last, whole):.6g} s, unknown "
                "outside"
            )


def _check_unique_names(path: Path, channels: Sequence[Channel]) -> None:
    names = [c.name for c in channels]
    for name in names:
        if names.count(name) > 1:
            raise unreadable_recording_error(
                path, "two channels have one name", value=repr(name), hint="name the group"
            )
