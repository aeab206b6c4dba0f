"""Time axes of recordings: which column is the clock, its unit, its rate and its gaps."""

import re
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from cardan.core.arrays import FloatArray
from cardan.core.errors import InvalidFileError
from cardan.physics.signals.recording import Channel
from cardan.readers.base import RecordingFileColumns, check_sample_rate, unreadable_recording_error
from cardan.readers.time_units import (
    SECONDS_PER_TIME_UNIT,
    reference_instant,
    seconds_per_count_of_instants,
    seconds_per_time_unit,
)

_PLAIN_CLOCK_NAME = re.compile(
    r"(time|timestamps?|zeit|tempo|temps|t)(?:[\s_]*[\[(]?([^\W\d_]+)[\])]?)?", re.IGNORECASE
)
"""A clock, and the unit its name ends in: `Time_ms`. A `T` by itself is no clock."""
_TIME_WORDS = frozenset(
    (
        "time", "times", "timestamp", "timestamps", "zeit", "zeitstempel", "tempo", "temps", "t",
        "epoch", "elapsed", "clock",
    )
)  # fmt: skip
"""Words by which a name says time; the values decide."""
_NAME_WORD = re.compile(r"[A-ZÀ-Þ]?[a-zß-ÿµμ]+|[A-ZÀ-Þ]+(?![a-zß-ÿ])")
_LABVIEW_CLOCK_NAME = "X_Value"
"""LabVIEW's name of the time of its tables."""

MIN_PLAUSIBLE_STEP_IN_CLOCK_UNITS = 0.02
"""Step of a clock labelled ms, us or ns, in that unit, below which it rather counts seconds: a
logger that samples that fast writes a finer unit. Engineering judgement, assumed; the user may give
it."""
MIN_ROWS_FOR_RATE = 3
MIN_ROWS_OF_RATE_CHANGE = 200
"""Rows on either side of a change of the rate: fewer are jitter."""
MAX_RATE_CHANGE = 0.01
MAX_HOLE_S = 3600.0
MAX_PRINTED_CLOCK_STEP_SAMPLES = 0.3
"""Samples that the last printed digit of a clock may be worth: above it they are counted."""

MAX_COLUMNS_LISTED = 12
"""Columns that an error lists."""
DAY_S = 86400.0


class MidnightRollover:
    """Carries times of day on past midnight, as pieces pass; what has a date goes on as it is."""

    def __init__(self) -> None:
        self.last, self.midnights = np.nan, 0

    def add_days(self, time: FloatArray) -> FloatArray:
        """Return times (n,) s with the days before them."""
        step = np.diff(time, prepend=self.last)
        # No clock goes back by half a day.
        midnights = self.midnights + np.cumsum((step < -DAY_S / 2) & (time < DAY_S))
        if time.size:
            self.last, self.midnights = float(time[-1]), int(midnights[-1])
        return time + DAY_S * midnights


@dataclass(frozen=True, kw_only=True)
class TimeAxis:
    """When the samples of a table were taken.

    Attributes
    ----------
    rate : Hz
        Samples a second.
    start : s
        Of its first sample on the clock of the file.
    clock
        The column that says when; None where they are evenly spaced.
    second
        Seconds of a count of the clock.
    reference : s
        The instant since which it counts.
    resolution : s
        What the last digit of its stamps is worth, where that is much of a sample; else 0.
    uneven
        Whether its clock rises, but not evenly: a log of what changed.
    notes
        What is to be said of it.
    """

    rate: float
    start: float = 0.0
    clock: int | None = None
    second: float = 1.0
    reference: float = 0.0
    resolution: float = 0.0
    uneven: bool = False
    notes: tuple[str, ...] = ()

    def seconds(self, count: FloatArray) -> FloatArray:
        """Return the times of counts of the clock, s on the clock of the file."""
        return count * self.second + self.reference


def table_time_axis(path: Path, table: RecordingFileColumns, time: str | None = None) -> TimeAxis:
    """Return the time axis of a table by its clock, or else by the rate that the file states.

    Raises
    ------
    InvalidFileError
        If nothing says how fast it was sampled, or two statements contradict each other.
    """
    if table.no_time and time is None:
        raise unreadable_recording_error(
            path, f"the axis of its samples is no time: {table.no_time}",
            value=table.group, hint="give the rate (--rate HZ)",
        )  # fmt: skip
    table, time = with_time_unit(path, table, time)
    clock = find_time_column(path, table, time)
    if clock is None:
        if table.rate is None:
            own = ", ".join(c.name for c in table.columns[:MAX_COLUMNS_LISTED])
            raise unreadable_recording_error(
                path, "nothing says how fast it was sampled",
                hint=f"give the rate (--rate HZ) or the time column (--time COLUMN); it has {own}",
            )  # fmt: skip
        check_sample_rate(path, table.rate)
        return TimeAxis(rate=table.rate, start=table.start)
    axis = _clock_axis(path, table, clock)
    if table.rate is not None and abs(table.rate / axis.rate - 1) > MAX_RATE_CHANGE:
        raise unreadable_recording_error(
            path, "its clock and the rate that it states contradict each other",
            value=f"{axis.rate:g} Hz by {table.columns[clock].name!r}, stated {table.rate:g} Hz",
            hint="give the rate (--rate HZ), or the clock and its unit (--time COLUMN:UNIT)",
        )  # fmt: skip
    return axis


def uneven_time_axis(path: Path, table: RecordingFileColumns) -> TimeAxis | None:
    """Return the axis of a log that is written as something changes; None if it is no such log."""
    clock = find_time_column(path, table, None)
    unit = "" if clock is None else _time_unit(table.columns[clock])
    second = seconds_per_time_unit(unit)
    if clock is None or second is None or table.no_time:
        return None
    count = first_values(table, clock)
    if count.size < MIN_ROWS_FOR_RATE or not (np.diff(count) > 0).all():
        return None
    reference = reference_instant(unit) + table.start
    return TimeAxis(
        rate=(count.size - 1) / float((count[-1] - count[0]) * second), clock=clock, second=second,
        start=float(count[0]) * second + reference, reference=reference, uneven=True,
    )  # fmt: skip


MAX_SAMPLES_PER_FRAME = 20
"""Samples of an even clock for each frame of a bus: of more of them most would be holes."""


def even_frames_axis(path: Path, table: RecordingFileColumns) -> TimeAxis | None:
    """Return the axis of frames if all of them came as evenly as samples have to; else None."""
    clock = find_time_column(path, table, None)
    if clock is None:
        return None
    try:
        axis = table_time_axis(path, table)
        even = fill_time_gaps(path, table.read_rows((clock,)), axis)
        samples = sum(piece.shape[1] for piece in even)
    except InvalidFileError:
        return None
    return axis if samples <= MAX_SAMPLES_PER_FRAME * (table.samples or 0) else None


def with_time_unit(
    path: Path, table: RecordingFileColumns, time: str | None
) -> tuple[RecordingFileColumns, str | None]:
    """Return a table whose clock has the unit that was said, and the clock's name without it."""
    names = [c.name for c in table.columns]
    name, colon, unit = (time or "").rpartition(":")
    if time is None or time in names or not colon or name not in names:
        return table, time
    if seconds_per_time_unit(unit) is None or not unit:
        raise _unknown_unit_error(path, name, unit)
    columns = tuple(
        Channel(c.name, unit, unit_declared=True) if c.name == name else c for c in table.columns
    )
    return replace(table, columns=columns), name


def _unknown_unit_error(path: Path, name: str, unit: str) -> InvalidFileError:
    return unreadable_recording_error(
        path, f"unknown unit of time column {name!r}", value=repr(unit),
        hint=f"known are {', '.join(u for u in SECONDS_PER_TIME_UNIT if u)}",
    )  # fmt: skip


def find_time_column(path: Path, table: RecordingFileColumns, time: str | None) -> int | None:
    """Place of the time column, if there is one.

    The one that was named; else one with nothing but time in its name; else that of the container;
    else one whose name says time among other words and whose values rise evenly.

    Raises
    ------
    InvalidFileError
        If none has the name that was given, or two run at different rates.
    """
    if table.frames:
        return table.clock
    names = [c.name for c in table.columns]
    if time is not None:
        if time not in names:
            raise unreadable_recording_error(
                path, f"no time column {time!r}", hint=f"it has {', '.join(names)}"
            )
        return names.index(time)
    found = [k for k, c in enumerate(table.columns) if is_time_column(c)]
    plain = [k for k in found if len(names[k].strip()) > 1]
    found = plain or found  # a column t next to one called time is something else
    if len(found) == 1:
        return found[0]
    if not found and table.clock is not None:
        return table.clock
    found = found or [k for k, c in enumerate(table.columns) if says_time(c)]
    rates = {k: rate for k in found if (rate := _even_rate(path, table, k)) is not None}
    if len(rates) > 1 and max(rates.values()) > (1 + MAX_RATE_CHANGE) * min(rates.values()):
        raise unreadable_recording_error(
            path, "it has several clocks of different rates",
            value=", ".join(f"{names[k]} {rate:.6g} Hz" for k, rate in rates.items()),
            hint="name one (--time COLUMN)",
        )  # fmt: skip
    return next(iter(rates), None)


def is_time_column(column: Channel) -> bool:
    """Whether a column is a clock by its name alone."""
    name = column.name.strip()
    match = _PLAIN_CLOCK_NAME.fullmatch(name)
    if match is None or name == "T" or seconds_per_time_unit(match[2] or "") is None:
        return False
    # A temperature `t` in degrees is none; of `time` in an unknown unit that is said.
    return len(name) > 1 or seconds_per_time_unit(column.unit) is not None


def says_time(column: Channel) -> bool:
    """Whether a column's name says time, among other words, and its unit nothing else."""
    if seconds_per_time_unit(column.unit) is None:
        return False
    name = column.name.strip()
    words = [w if w == "T" else w.lower() for w in _NAME_WORD.findall(name)]
    return name.lower() == _LABVIEW_CLOCK_NAME.lower() or not _TIME_WORDS.isdisjoint(words)


def _even_rate(path: Path, table: RecordingFileColumns, clock: int) -> float | None:
    """Return the rate of a column whose first values rise evenly, Hz; None if they do not."""
    try:
        return _clock_axis(path, table, clock).rate
    except InvalidFileError:
        return None


def _time_unit(column: Channel) -> str:
    """Return the unit of a time column: that of the file, or the last word of its name."""
    if column.unit.strip():
        return column.unit.strip()
    apart = re.split(r"[\s_\[\]()./:-]+", column.name.strip().rstrip("])"))
    last = apart[-1] if len(apart) > 1 else ""
    return last if last != "d" and seconds_per_time_unit(last) is not None else ""


def _clock_axis(path: Path, table: RecordingFileColumns, clock: int) -> TimeAxis:
    """Return the time axis that a column of a table is."""
    column, unit = table.columns[clock], _time_unit(table.columns[clock])
    second = seconds_per_time_unit(unit)
    if second is None:
        raise _unknown_unit_error(path, column.name, unit)
    count = first_values(table, clock)
    notes: tuple[str, ...] = ()
    first = float(count[0]) if count.size else 0.0
    if not unit and (by_size := seconds_per_count_of_instants(first)) not in (None, 1.0):
        assert by_size is not None
        second = by_size
        note = f"{column.name} counts {second:g} s since 1970, by its size"
        notes = (note,)
    # Of an instant a float keeps a quarter of a microsecond: its steps are taken before.
    rate, resolution = _rate_of_times(path, (count - first) * second)
    if (
        unit and second < 1 and 1 / rate < MIN_PLAUSIBLE_STEP_IN_CLOCK_UNITS * second
        and not column.unit_declared and table.clock != clock
    ):  # fmt: skip
        raise unreadable_recording_error(
            path, f"its clock {column.name!r} would be too fast for one in {unit}",
            value=f"{rate:g} Hz, and {rate * second:g} Hz in seconds",
            hint=f"give its unit: --time '{column.name}:s' or '{column.name}:{unit}'",
        )  # fmt: skip
    check_sample_rate(path, rate)
    if resolution:
        note = (
            f"its clock shows steps of {resolution:g} s: read as even at {rate:g} Hz, each sample "
            f"within {resolution / 2:g} s"
        )
        notes = (*notes, note)
    reference = reference_instant(unit) + table.start
    return TimeAxis(
        rate=rate, start=first * second + reference, clock=clock, second=second,
        reference=reference, resolution=resolution, notes=notes,
    )  # fmt: skip


def first_values(table: RecordingFileColumns, column: int) -> FloatArray:
    """Return the first values of a column (n,)."""
    first = next(iter(table.read_rows((column,))), np.empty((1, 0)))
    return first[0, : 1 << 16].astype(float)


def is_evenly_clocked(table: RecordingFileColumns, axis: TimeAxis) -> bool:
    """Whether the first rows of a table lie on the samples of its time axis."""
    if axis.clock is None or axis.resolution:
        return True
    step = np.diff(first_values(table, axis.clock)) * axis.second * axis.rate
    return bool(((step > 0.6) & (np.abs(step - np.rint(step)) < 0.4)).all())


def split_by_presence(
    path: Path, table: RecordingFileColumns, time: str | None
) -> list[RecordingFileColumns]:
    """Return the columns of a table that are there in the same rows, each such set as a table.

    One table where there is no clock, or no two sets of columns take turns.
    """
    table, time = with_time_unit(path, table, time)
    try:
        clock = find_time_column(path, table, time)
    except InvalidFileError:
        clock = None
    if clock is None:
        named = [k for k, c in enumerate(table.columns) if is_time_column(c) or says_time(c)]
        clock = named[0] if len(named) == 1 else None
    if clock is None or len(table.columns) < 3:
        return [table]
    places = tuple(range(len(table.columns)))
    first = next(iter(table.read_rows(places)), np.empty((len(places), 0)))
    there = ~np.isnan(first)
    sets: dict[bytes, list[int]] = {}
    for k in places:
        if k != clock and there[k].any():
            sets.setdefault(there[k].tobytes(), []).append(k)
    if len(sets) < 2 or any(there[own[0]].all() for own in sets.values()):
        return [table]
    return [_rows_with(table, clock, tuple(own)) for own in sets.values()]


def _rows_with(
    table: RecordingFileColumns, clock: int, own: tuple[int, ...]
) -> RecordingFileColumns:
    """Return a clock and columns of a table, without the rows in which these are empty."""
    kept = (clock, *own)

    def rows(places: tuple[int, ...]) -> Iterator[FloatArray]:
        for piece in table.read_rows(kept):
            full = ~np.isnan(piece[1:]).all(axis=0)
            yield piece[list(places)][:, full]

    columns = tuple(table.columns[k] for k in kept)
    return replace(
        table, columns=columns, read_rows=rows, samples=None, notes=(),
        clock=0 if table.clock == clock else None, group=", ".join(c.name for c in columns[1:]),
    )  # fmt: skip


def rate_conflict_notes(
    path: Path, table: RecordingFileColumns, clock: int, rate: float
) -> tuple[str, ...]:
    """Return what a time column says against a rate that was given."""
    try:
        own = _clock_axis(path, table, clock).rate
    except InvalidFileError:
        return ()  # that is why it was given
    if abs(rate / own - 1) < 0.01:
        return ()
    note = f"taken at {rate:g} Hz, as was said: by its time column it is {own:g} Hz"
    return (note,)


def _stamp_resolution(t: FloatArray) -> float:
    """Return what the last digit of times (n,) from 0 is worth, s; 0 if it is nothing."""
    for digits in range(7):
        steps = t * 10.0**digits
        if np.abs(steps - np.rint(steps)).max() < 1e-3:
            return 10.0**-digits
    return 0.0


def _rate_of_times(path: Path, t: FloatArray) -> tuple[float, float]:
    """Return the sample rate of times (n,) from 0, Hz, and the resolution of coarse ones, s."""
    step = np.diff(t)
    if step.size < MIN_ROWS_FOR_RATE - 1 or not np.isfinite(step).all():
        raise unreadable_recording_error(
            path, "its time column is too short or has holes",
            value=f"{t.size} rows, {np.count_nonzero(~np.isfinite(t))} of them without time",
            hint="give the rate",
        )  # fmt: skip
    if (step >= 0).all() and (coarse := _coarse_rate(t)) is not None:
        return coarse
    typical = float(np.median(step))
    if not typical > 0:
        raise unreadable_recording_error(
            path, "its time column stands still or runs backwards", hint="give the rate"
        )
    even = np.abs(step - typical) < 0.4 * typical
    if 2 * np.count_nonzero(even) < step.size:
        raise unreadable_recording_error(
            path, "its time is not even from the beginning",
            value=f"steps of {step.min():g} to {step.max():g} s, half of them under {typical:g} s",
            hint="resample it, or give the rate to read rows as evenly spaced",
        )  # fmt: skip
    # Printed times are rounded; their mean over a long stretch is not.
    return _whole_rate(1 / float(step[even].mean()), 1e-5), 0.0


def nominal_rate(step: float) -> float:
    """Return the rate of frames of a usual step, s: the whole number that it is within 1 %."""
    return _whole_rate(1 / step, 0.01)


def _whole_rate(rate: float, tolerance: float) -> float:
    """Return the whole number that a rate is within a relative tolerance, or the rate."""
    whole = round(rate)
    return float(whole) if whole and abs(rate / whole - 1) < tolerance else rate


def _coarse_rate(t: FloatArray) -> tuple[float, float] | None:
    """Return the rate of even times that are printed with few digits, and what the last is worth.

    None if their digits suffice, or they are not even within the last one.
    """
    resolution = _stamp_resolution(t)
    many = t.size
    while resolution and many >= 32:
        k = np.arange(many)
        # A fit through all is better known than the two ends.
        slope = float(np.polyfit(k, t[:many], 1)[0])
        off = float(np.ptp(t[:many] - k * slope))
        if slope > 0 and off <= 1.1 * resolution + 1e-9:
            if off < MAX_PRINTED_CLOCK_STEP_SAMPLES * slope:
                return None
            return _whole_rate(1 / slope, resolution / (many * slope)), resolution
        many //= 2
    return None


def fill_time_gaps(path: Path, rows: Iterable[FloatArray], axis: TimeAxis) -> Iterator[FloatArray]:
    """Yield rows without their time, holes filled with nan; refuse time that is not even."""
    place = _place_coarse_stamps if axis.resolution else _place_stamps
    for piece, whole in place(path, rows, axis):
        hole = int(whole.sum()) - whole.size
        if hole > MAX_HOLE_S * axis.rate:
            raise unreadable_recording_error(
                path, f"a hole of {hole / axis.rate:.6g} s in time", hint="split the recording"
            )
        if hole:
            at = np.cumsum(whole).astype(np.int64) - 1
            filled = np.full((piece.shape[0] - 1, int(at[-1]) + 1), np.nan)
            filled[:, at] = piece[1:]
            yield filled
        else:
            yield piece[1:]


def _place_stamps(
    path: Path, rows: Iterable[FloatArray], axis: TimeAxis
) -> Iterator[tuple[FloatArray, FloatArray]]:
    """Yield pieces (1 + k, n) and the sample steps (n,) from each row to the next."""
    last, row, rate = np.nan, 0, axis.rate
    origin = np.nan
    for piece in rows:
        if not row and piece.shape[1]:
            origin = float(piece[0, 0])
            last = -1 / rate
        t = (piece[0] - origin) * axis.second
        steps = np.diff(np.concatenate([[last], t])) * rate
        whole = np.rint(steps)
        wrong = ~((whole >= 1) & (np.abs(steps - whole) < 0.4))
        _check_constant_rate(path, steps, whole, rate=rate, row=row)
        if wrong.any():
            k = int(np.argmax(wrong))
            raise unreadable_recording_error(
                path, f"time is not even at row {row + k + 1}",
                value=f"{piece[0, k] * axis.second:.9g} s, {steps[k]:.3g} sample steps after the "
                "row before",
                hint="resample it, or give the rate to read rows as evenly spaced",
            )  # fmt: skip
        if t.size:
            last, row = float(t[-1]), row + t.size
        yield piece, whole


def _check_constant_rate(
    path: Path, steps: FloatArray, whole: FloatArray, *, rate: float, row: int
) -> None:
    """Refuse steps (n,), in samples, that go on at another rate from some row on."""
    if not np.isfinite(steps).all() or steps.size < MIN_ROWS_OF_RATE_CHANGE:
        return
    slow = whole.size > 20 and np.mean(whole > 1) > 0.2
    # Where holes are few, they say nothing of the rate.
    pace = np.minimum(steps, 20.0) if slow else np.where(whole == 1, steps, 1.0)
    k = int(np.argmax(np.abs(np.cumsum(pace - pace.mean())))) + 1
    around = [p for p in (pace[:k], pace[k:]) if p.size >= MIN_ROWS_OF_RATE_CHANGE] or [pace]
    before, after = (
        (float(np.median(p)) if slow else float(p.mean())) for p in (around[0], around[-1])
    )
    if len(around) < 2:
        before = 1.0
    if abs(after / before - 1) <= MAX_RATE_CHANGE:
        return
    at = row + (k if len(around) == 2 else 0) + 1
    raise unreadable_recording_error(
        path, f"its clock changes its rate at row {at}",
        value=f"{rate / before:.6g} Hz before, {rate / after:.6g} Hz from there on",
        hint="split or resample it",
    )  # fmt: skip


def _place_coarse_stamps(
    path: Path, rows: Iterable[FloatArray], axis: TimeAxis
) -> Iterator[tuple[FloatArray, FloatArray]]:
    """Yield the same of stamps whose last digit is much of a sample: they are counted.

    A sample lies within a digit of where it is counted to; farther on there is a hole.
    """
    digit = axis.resolution * axis.rate
    origin, expected, row = np.nan, 0.0, 0
    for piece in rows:
        if not row and piece.shape[1]:
            origin = float(piece[0, 0])
        n = piece.shape[1]
        at = (piece[0] - origin) * axis.second * axis.rate
        whole = np.ones(n)
        k = 0
        while k < n:
            off = at[k:] - (expected + np.arange(n - k))
            wrong = ~(np.abs(off) <= digit + 0.5)
            if not wrong.any():
                # A rate that is known to a millionth drifts by a sample in a million.
                expected += n - k + (float(off.mean()) if n - k > 1000 else 0.0)
                break
            m = int(np.argmax(wrong))
            hole = round(float(np.median(off[m : m + 20])))
            if not hole >= 1:
                raise unreadable_recording_error(
                    path, f"time is not even at row {row + k + m + 1}",
                    value=f"{piece[0, k + m] * axis.second:.9g} s, {off[m]:.3g} sample steps off",
                    hint="resample it, or give the rate to read rows as evenly spaced",
                )  # fmt: skip
            whole[k + m] += hole
            expected, k = expected + m + hole, k + m
            if m == 0 and whole[k] > 1 and np.abs(at[k] - expected) > digit + 0.5:
                raise unreadable_recording_error(
                    path, f"time is not even at row {row + k + 1}",
                    hint="resample it, or give the rate to read rows as evenly spaced",
                )  # fmt: skip
        if n > 20 and np.mean(whole > 1) > 0.2:
            raise unreadable_recording_error(
                path, f"time is not even at row {row + int(np.argmax(whole > 1)) + 1}",
                value=f"{np.count_nonzero(whole > 1)} of {n} rows lie behind a hole",
                hint="resample it, or give the rate to read rows as evenly spaced",
            )  # fmt: skip
        row += n
        yield piece, whole
