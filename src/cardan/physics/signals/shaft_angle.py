"""The angle of a shaft from channels that were never meant to give one.

A phase is only as good as the angle behind it, and a speed on a bus comes late, in steps,
with holes, and off by the tyre size typed in. What can be known of it is corrected
here: holes and sudden zeros are unknown and not standing still; of a staircase the values at
its steps count; and where an engine's speed runs along, gear by gear a fixed ratio apart, it
turns the shaft through holes, and finer than a staircase does. Where neither is known, the angle
is lost: it goes on afterwards from an unknown zero. What is left, one ratio, one lag
and these zeros, are estimated from the stress itself (`synchronous_fit`).
"""

from dataclasses import dataclass, field, replace
from functools import lru_cache

import numpy as np

from cardan.core.arrays import ArrayLike, BoolArray, FloatArray, IntArray
from cardan.core.errors import DesignError
from cardan.physics.signals.faults.intervals import merge_runs
from cardan.physics.signals.order_tracking import ShaftRotation

MIN_STAIRCASE_CHANNEL_UPDATE_INTERVAL_S = 0.06
"""Seconds between new values from which a channel is a staircase."""
MAX_SPEED_UPDATE_INTERVAL_FOR_ANGLE_S = 0.25
"""Seconds between new values that leave the angle between them open."""
MIN_KNOWN_ANGLE_TIME_SHARE = 0.7
"""Share of the time under way in which the angle must be known."""
MIN_MEAN_TIME_BETWEEN_ANGLE_LOSSES_S = 6.0
"""Seconds that it must be known for, from one loss to the next, in the mean of that time."""
MIN_SPEED_GAP_LOSING_ANGLE_S = 0.15
"""Seconds without a speed in which an angle is lost."""
MIN_STUCK_SPEED_S = 5.0
"""Seconds of one and the same speed, while the engine's changes by `MIN_ENGINE_SPEED_CHANGE`, that
was not driven.
"""
MIN_ENGINE_SPEED_CHANGE = 0.1
"""Share by which an engine's speed changes that in gear takes the shaft's along."""
MAX_ENGINE_BRIDGED_GAP_S = 20.0
"""Seconds without a speed through which the engine turns the shaft: gears change meanwhile."""
MAX_SPEED_GAP_S = 1.0
"""Seconds without a speed after which the speed is unknown."""
MIN_NEIGHBOUR_SPEED_TO_ERROR_CODE_RATIO = 0.8
"""Share of the first number that is no speed from which a real one may have come to it."""
MAX_SHAFT_SPEED_RAMP_FULL_SCALES_PER_S = 0.45
"""Full scales a second at which no shaft under a vehicle gains speed: 3700 rpm a second."""
MAX_ROTATION_TIME_POINTS = 2_500_000
"""Times of a rotation: seven hours at a hundred a second, and a longer drive is met less often."""
MIN_STEADY_SPEED_READING_COUNT, MAX_SPEED_CHANGE_DURATION_S, MAX_READING_INTERVAL_FOR_COUNTING_S = (
    3,
    1.0,
    4.0,
)
"""Readings, all alike, from which a speed is steady and not a step of a staircase; seconds in which
it comes to its next speed at most, and seconds between readings at most as they are counted."""
MIN_REGULAR_UPDATE_SHARE, MIN_DISTINCT_SHARE_OF_MEASURED_READINGS = 0.8, 1 / 3
"""Share of values that came by a clock from which all did, and of different ones among those read
now and then: fewer were set."""
TIME_POINTS_PER_BLOCK = 1 << 17
"""Times at which a speed is looked up at once."""
ANGLE_LOOKUP_MARGIN_S = 10.0
"""Seconds around a stretch, and its lag, for which the angle is computed with it."""
SPEED_SMOOTHING_WINDOW_S, MAX_READING_INTERVAL_SHOWING_RIPPLE_S = 0.35, 0.02
"""Seconds in which a shaft's speed is a cubic, and between readings that show a turn's wobble."""
MIN_MOVING_SPEED_REV_PER_S = 0.5
"""Turns/s from which a shaft is under way, either way round."""
MAX_STOPPING_DROP_REV_PER_S = 2.0
"""Turns/s from which no shaft falls to zero within a sample."""


@dataclass(frozen=True)
class ShaftAngle:
    """How far a shaft has turned, and how far that can be trusted.

    Attributes
    ----------
    rotation
        Turns over time.
    lag : s
        How late it may be, to either side.
    trusted
        Whether a phase of twice this angle means anything.
    lost_intervals : (k, 2) s
        From when to when the angle is unknown: afterwards its zero is another.
    """

    rotation: ShaftRotation
    lag: float = 0.15
    trusted: bool = True
    lost_intervals: FloatArray = field(default_factory=lambda: np.empty((0, 2)))
    measured: bool = True
    """Whether it was measured: a speed taken from the stress itself excludes no cause."""
    unknown_speed_share: float = 0.0
    """Share of the time under way for which nothing says how fast it turned."""
    known_time_span: tuple[float, float] = (-np.inf, np.inf)
    """From when to when it is recorded, s: before and after, the next known speed is held."""
    speed_gaps: FloatArray = field(default_factory=lambda: np.empty((0, 2)))
    """Between these, (k, 2) s from when to when nothing says it for more than a moment, and a line
    goes straight across."""
    negative_speed_intervals: FloatArray = field(default_factory=lambda: np.empty((0, 2)))
    """From when to when, (k, 2) s, its speed is negative for more than a moment."""
    negative_speed_counts: bool = True
    """Whether that counts by its size; it says nothing otherwise."""

    def is_negative(self, time: FloatArray) -> BoolArray:
        """Return whether its speed is negative at times (n,) s, for more than a moment."""
        begun, over = self.negative_speed_intervals.T
        return np.searchsorted(begun, time, "right") > np.searchsorted(over, time)

    def is_beyond_ends(self, time: FloatArray) -> BoolArray:
        """Return whether times (n,) s lie before a speed is known, or after."""
        first, last = self.known_time_span
        return (time < first) | (time > last)

    def is_unknown(self, time: FloatArray) -> BoolArray:
        """Return whether nothing says at times (n,) s how fast it turned."""
        begun, over = self.speed_gaps.T
        amid = np.searchsorted(begun, time, "right") > np.searchsorted(over, time)
        return self.is_beyond_ends(time) | amid

    def stretch_index(self, time: FloatArray) -> IntArray:
        """Return which stretch of one zero times (n,) s lie in, from 0 on."""
        return np.searchsorted(self.lost_intervals.mean(-1), time)

    def within(self, first: float, last: float) -> "ShaftAngle":
        """Return the angle between two times, s, and with what it loses there.

        Of a day's drive the rest is held once: a stretch is computed at many ratios.
        """
        near = (self.lost_intervals[:, 1] > first) & (self.lost_intervals[:, 0] < last)
        beside = self.lag + ANGLE_LOOKUP_MARGIN_S
        rotation = self.rotation.within(first - beside, last + beside)
        return replace(self, rotation=rotation, lost_intervals=self.lost_intervals[near])

    def is_lost(self, time: FloatArray) -> BoolArray:
        """Return whether it is lost at times (n,) s."""
        before = np.searchsorted(self.lost_intervals[:, 0], time, "right")
        after = np.searchsorted(self.lost_intervals[:, 1], time, "right")
        return before > after


@dataclass(frozen=True)
class SpeedReadings:
    """What a channel of speed says at the times when it says something new."""

    time: FloatArray
    value: FloatArray
    known: BoolArray
    period: float

    def at(self, time: FloatArray) -> FloatArray:
        """Return the speed (n,) at times (n,) s a step apart, straight between readings.

        Of readings that come faster it is the mean about each, or their noise adds up to an angle.
        """
        step = float(time[1] - time[0]) if time.size > 1 else 0.0
        if self.period >= step:
            return np.interp(time, self.time, self.value)
        turned, found = _cumulative_turns(self.time, self.value), np.empty(time.size)
        for first in range(
            0, time.size, TIME_POINTS_PER_BLOCK
        ):  # a day's are a hundred thousand at a time
            some = time[first : first + TIME_POINTS_PER_BLOCK + 1]
            edges = some - step / 2
            if first + TIME_POINTS_PER_BLOCK >= time.size:
                edges = np.append(edges, some[-1] + step / 2)
            edges = np.clip(edges, self.time[0], self.time[-1])
            before = np.clip(np.searchsorted(self.time, edges) - 1, 0, self.time.size - 2)
            there = (self.value[before] + np.interp(edges, self.time, self.value)) / 2
            gone = turned[before] + there * (edges - self.time[before])
            span = np.diff(edges)
            beyond = np.interp(some[: span.size], self.time, self.value)
            mean = np.divide(np.diff(gone), span, out=beyond, where=span > 0)
            found[first : first + TIME_POINTS_PER_BLOCK] = mean
        return found


def _cumulative_turns(time: FloatArray, speed: FloatArray) -> FloatArray:
    """Return the turns (n,) made by times (n,) s at speeds (n,), straight between them."""
    turns = np.zeros(time.size)
    each = turns[1:]
    np.add(speed[1:], speed[:-1], out=each)
    each /= 2
    each *= np.diff(time)
    return np.cumsum(turns, out=turns)


def speed_readings(speed: FloatArray, *, rate: float) -> SpeedReadings:
    """Read a channel of speed (n,) turns/s, nan where it says nothing.

    Raises
    ------
    DesignError
        If it never says a speed.
    """
    x = np.array(speed, float)
    x[x < 0] = 0.0
    still = np.flatnonzero(x == 0)
    if still.size:
        # A fall to zero from a speed is a lost value; one that runs out has stopped.
        first = still[np.append(True, np.diff(still) > 1)]
        last = np.append(still[np.flatnonzero(np.diff(still) > 1)], still[-1])
        for a, b in zip(first, last, strict=True):
            before = x[a - 1] if a else 0.0
            after = x[b + 1] if b + 1 < x.size else 0.0
            if (
                np.nan_to_num(before) > MAX_STOPPING_DROP_REV_PER_S
                or np.nan_to_num(after) > MAX_STOPPING_DROP_REV_PER_S
            ):
                x[a : b + 1] = np.nan
    known = ~np.isnan(x)
    if np.count_nonzero(known) < 2:
        msg = "a channel of speed needs two or more positive values"
        raise DesignError(msg)
    value = x[known]
    del x  # of a day's drive each of these is 20 MB
    fresh = np.append(True, value[1:] != value[:-1])
    period = _update_period_samples(value, fresh) / rate
    place = np.flatnonzero(known)
    if period < MIN_STAIRCASE_CHANNEL_UPDATE_INTERVAL_S:
        return SpeedReadings(place / rate, value, known, period)
    gap = np.diff(np.append(place, known.size))
    keep = fresh | np.append(fresh[1:], True) & (gap > 1) | (value == 0)
    # A stretch of many readings is steady speed, held until the last before the next.
    start = np.append(np.flatnonzero(fresh), value.size)
    if _is_setpoint(value[start[:-1]], np.diff(start) / rate, period):
        steady, moment = (
            np.diff(start) > MIN_STEADY_SPEED_READING_COUNT * MAX_SPEED_CHANGE_DURATION_S * rate,
            1,
        )
    else:
        steady = (
            np.diff(start)
            > MIN_STEADY_SPEED_READING_COUNT
            * min(period, MAX_READING_INTERVAL_FOR_COUNTING_S)
            * rate
        )
        moment = max(round(min(period, MAX_SPEED_CHANGE_DURATION_S) * rate), 1)
    keep[np.maximum(start[1:][steady] - moment, 0)] = True
    return SpeedReadings(place[keep] / rate, value[keep], known, period)


def _is_setpoint(value: FloatArray, long: FloatArray, period: float) -> bool:
    """Return whether values (n,) that last so long (n,) s each were set, and none is a reading.

    What is read now and then comes by a clock, and seldom the same twice; what was set on a stand
    stays for as long as wanted, or comes again. Joined straight it had an engine that ran
    at 1500 or 3000 rpm in seven gears between.
    """
    if period <= MAX_SPEED_CHANGE_DURATION_S or value.size < 3:
        return False
    by_clock = np.mean(np.abs(long[1:-1] - period) < 0.1 * period) > MIN_REGULAR_UPDATE_SHARE
    return (
        not by_clock or np.unique(value).size < MIN_DISTINCT_SHARE_OF_MEASURED_READINGS * value.size
    )


def _update_period_samples(value: FloatArray, fresh: BoolArray) -> float:
    """Return how many samples usually pass from one value (n,) that is `fresh` to the next.

    A speed that is steady for a while says nothing new, and is no staircase.
    """
    moving = value > 0.5
    steps = np.diff(np.flatnonzero(fresh & moving))
    return float(np.median(steps) if steps.size else np.count_nonzero(moving))


@dataclass(frozen=True)
class UnsignedSpeed:
    """A channel of speed (n,) turns/s by its size where it is negative for long.

    Attributes
    ----------
    speed
        What counts: the size of what was driven backwards, nan where it is no speed.
    runs : (k, 2)
        Samples from and to which it is negative.
    reverses : bool
        Whether it goes forwards too: an angle is lost where the shaft turns round.
    size_counts
        Whether its size counts: of one number throughout, next to positive speeds, it
        is unknown whether it stands for none.
    """

    speed: FloatArray
    runs: IntArray
    reverses: bool
    size_counts: bool


def unsigned_speed(speed: FloatArray, *, rate: float) -> UnsignedSpeed:
    """Return a channel of speed (n,) turns/s by its size, and where it is negative for long."""
    back = speed < -MIN_MOVING_SPEED_REV_PER_S
    least = MAX_SPEED_GAP_S * rate
    if np.count_nonzero(back) < least:
        return UnsignedSpeed(speed, np.empty((0, 2), np.intp), reverses=False, size_counts=True)
    runs = _true_runs(speed < 0, least=1)
    told = np.append(0, np.cumsum(back))
    runs = runs[told[runs[:, 1]] - told[runs[:, 0]] >= least]
    forwards = bool(np.count_nonzero(speed > MIN_MOVING_SPEED_REV_PER_S) >= least)
    ends = [(float(np.min(speed[a:b])), float(np.max(speed[a:b]))) for a, b in runs.tolist()]
    sized = not forwards or len({value for pair in ends for value in pair}) != 1
    size = np.array(speed, float)
    for a, b in runs.tolist():
        size[a:b] = -size[a:b] if sized else np.nan
    return UnsignedSpeed(size, runs, reverses=forwards and bool(len(runs)), size_counts=sized)


@dataclass(frozen=True)
class BusScaling:
    """Numbers of a bus: one every `step`, and from `first` to `last` none of them a value."""

    first: float
    last: float
    step: float


J1939_SHAFT_SPEED_SCALING = BusScaling(0xFB00 * 0.125, 0xFFFF * 0.125, 0.125)
"""Engine and shaft speeds of SAE J1939-71 (SPN 190, 191), rpm: 0xFE.. is an error, 0xFF.. nothing.

What lies from 0xFB00 is no value of any parameter: J1939-71, section 5.1.4, table 1.
"""
J1939_VEHICLE_SPEED_SCALING = BusScaling(0xFB00 / 256, 0xFFFF / 256, 1 / 256)
"""Speeds of the vehicle there (SPN 84), km/h."""


LOGGER_ROUNDING_DECIMALS = 1, 2
"""Decimals to which loggers round a number of a bus."""


def bus_error_runs(x: FloatArray, *, rate: float, of: BusScaling) -> IntArray:
    """Return runs (k, 2) of samples where a bus wrote that it had no value, with ways in and out.

    A shaft that turns as fast gets there through the speeds below; what comes out of a speed far
    below within moments, on a number of the bus, never turned. Laid on a faster clock such a run
    has flanks, straight lines between two readings: they are no speeds either.

    Parameters
    ----------
    x : (n,)
        A channel of speed in the unit of its scale; nan where nothing was written.
    rate : Hz
        Of its samples.
    of
        The bus' numbers.
    """
    # A hundredth of a step is more than float32 leaves of them; some loggers round them first.
    # Of a day's drive only the few that lie so high are looked at.
    high = np.flatnonzero((x >= of.first) & (x <= of.last + of.step))
    near = np.rint(x[high] / of.step)[..., None] + np.array([-1, 0, 1])
    known = np.stack(
        [near * of.step, *(np.round(near * of.step, d) for d in LOGGER_ROUNDING_DECIMALS)]
    )
    written = np.zeros(x.size, bool)
    written[high] = (np.abs(x[high, None] - known) < 0.01 * of.step).any((0, 2))
    edge = np.flatnonzero(
        np.diff(np.concatenate([[False], x >= of.first, [False]]).astype(np.int8))
    )
    rise = MAX_SHAFT_SPEED_RAMP_FULL_SCALES_PER_S * of.last / rate
    found: list[tuple[int, int]] = []
    for a, b in zip(edge[::2].tolist(), edge[1::2].tolist(), strict=True):
        if not written[a:b].any():
            continue
        first, last = a, b
        while first > 0 and x[first] - x[first - 1] > rise:
            first -= 1
        while last < x.size and x[last - 1] - x[last] > rise:
            last += 1
        # The feet of its flanks are readings.
        foot, other = min(first, a - 1), max(last - 1, b)
        beside = [x[k] for k in (foot, other) if 0 <= k < x.size and not np.isnan(x[k])]
        if all(v < MIN_NEIGHBOUR_SPEED_TO_ERROR_CODE_RATIO * of.first for v in beside):
            found.append((foot + 1, other))
    return merge_runs([np.array([run], np.intp) for run in found])


TORQUE_RESOLUTIONS_PER_BIT = (
    *(10.0**n * k for n in range(-4, 2) for k in (1, 2, 5)),
    *(2.0**-n for n in range(1, 11)),
)
"""What a bit of a bus' torque may be worth, in the unit it is written in."""
TORQUE_NOT_AVAILABLE_CODE_RANGES = (1, 0xFE00, 0xFFFF), (1, 0x7FFE, 0x7FFF), (-1, 0x7FFF, 0x8000)
"""Which way they lie, the first and the last of a bus' numbers for no torque: of two unsigned
bytes as J1939 has them, and the ends of two signed ones."""
MIN_ERROR_CODE_TO_USUAL_TORQUE_RATIO = 3.0
"""Of what a torque seldom passes, from which a bus' number for no value is none of its own."""


def torque_error_runs(x: FloatArray, *, rate: float) -> IntArray:
    """Return runs (k, 2) of samples where a bus wrote that it had no torque, flanks included.

    The worth of a bit is whatever the bus's author defined, so the number alone shows nothing: it
    is one of no value (`bus_error_runs`) for some worth of a bit, held, and far beyond all other
    torque.

    Parameters
    ----------
    x : (n,)
        A channel of torque, in the unit of its file; nan where nothing was written.
    rate : Hz
        Of its samples.
    """
    for way, code, last in TORQUE_NOT_AVAILABLE_CODE_RANGES:
        out = way * x
        top = float(np.nanmax(out, initial=0.0))
        for bit in TORQUE_RESOLUTIONS_PER_BIT:
            of = BusScaling((code - 0.01) * bit, last * bit, bit)
            if not of.first <= top <= of.last + 0.01 * bit:
                continue
            runs = bus_error_runs(out, rate=rate, of=of)
            runs = runs[[_is_held_value(out[a:b], of) for a, b in runs]]
            others = np.ones(x.size, bool)
            for a, b in runs:
                others[a:b] = False
            usual = np.abs(x[others & ~np.isnan(x)])
            if (
                len(runs)
                and usual.size
                and of.first > MIN_ERROR_CODE_TO_USUAL_TORQUE_RATIO * np.quantile(usual, 0.99)
            ):
                return runs
    return np.empty((0, 2), np.intp)


def _is_held_value(x: FloatArray, of: BusScaling) -> bool:
    """Return whether a run stands on one number, and its flanks are what a clock laid: straight.

    What was cut off at the end of its range comes and goes in a curve.
    """
    there = np.flatnonzero(x >= of.first)
    # Where a line begins and ends lies between two samples.
    flanks = [np.diff(x[1 : there[0]]), np.diff(x[there[-1] + 1 : -1])]
    straight = all(np.ptp(d) < 0.05 * np.abs(d).max() for d in flanks if d.size)
    return straight and bool(np.ptp(x[there]) < 0.01 * of.step)


def shaft_angle(
    speed: FloatArray, *, rate: float, engine: FloatArray | None = None, step: float = 0.01
) -> ShaftAngle:
    """Turn a shaft by its channel of speed (n,) turns/s, and by the engine's where there is one.

    Parameters
    ----------
    speed, engine : (n,) turns/s
        nan where nothing was written.
    rate : Hz
        Of both.
    step : s
        Between the times of the rotation.
    """
    way = unsigned_speed(speed, rate=rate)
    speed = way.speed
    own = speed_readings(speed, rate=rate)
    step = max(step, speed.size / rate / MAX_ROTATION_TIME_POINTS)
    time = _time_grid(speed.size / rate + step, step)
    turning = own.at(time)
    stair = own.period >= MIN_STAIRCASE_CHANNEL_UPDATE_INTERVAL_S
    known = own.known if engine is None else own.known & ~_stuck_speed(speed, engine, rate=rate)
    dark = np.empty(time.size, bool)
    for first in range(0, time.size, TIME_POINTS_PER_BLOCK):
        place = (time[first : first + TIME_POINTS_PER_BLOCK] * rate).astype(np.intp)
        dark[first : first + TIME_POINTS_PER_BLOCK] = ~known[np.minimum(place, known.size - 1)]
    lost = dark | (own.period >= MAX_SPEED_UPDATE_INTERVAL_FOR_ANGLE_S)
    motor = None
    if engine is not None and (stair or dark.any()):
        try:
            motor = speed_readings(unsigned_speed(engine, rate=rate).speed, rate=rate)
        except DesignError:
            motor = None
    geared_by = (
        motor is not None
        and motor.period < MIN_STAIRCASE_CHANNEL_UPDATE_INTERVAL_S
        and np.mean(~motor.known) < 0.005
    )
    if motor is not None and geared_by:
        if stair and (late := _staircase_lag(own, motor, time)):
            turning = own.at(time + late)
        geared, engaged = _speed_from_engine(turning, motor.at(time), told=~dark)
        for a, b in _true_runs(dark, least=1):
            engaged[a:b] &= (b - a) * step <= MAX_ENGINE_BRIDGED_GAP_S
        turning = np.where(engaged & (dark | stair), geared, turning)
        lost = (dark | stair) & ~engaged
        del geared
    unsaid = lost & dark
    if way.reverses:  # what turns round has another zero afterwards
        for a, b in way.runs / rate:
            lost[np.searchsorted(time, a) : np.searchsorted(time, b)] = True
    often = own.period < MAX_READING_INTERVAL_SHOWING_RIPPLE_S
    del own, motor  # of a day's drive they are 80 MB
    if often:
        turning = _smooth_speed(turning, step)
    moving = turning > 1
    told = np.flatnonzero(~unsaid)
    ends = (-np.inf, np.inf)
    if told.size:  # less than a moment is how a clock was laid, or its first message
        first, last = float(time[told[0]]), float(time[told[-1]])
        over = speed.size / rate
        ends = (
            first if first > MAX_SPEED_GAP_S else -np.inf,
            last if last < over - MAX_SPEED_GAP_S else np.inf,
        )

    def without(what: BoolArray, least: float) -> tuple[FloatArray, float]:
        """Return runs of a state, s, that take some time, and how long they are together."""
        runs = np.asarray(
            _true_runs(what & moving, least=max(round(least / step), 1)) * step, float
        )
        return runs, float((runs[:, 1] - runs[:, 0]).sum())

    runs, gone = without(lost, MIN_SPEED_GAP_LOSING_ANGLE_S)
    _, black = without(unsaid, MAX_SPEED_GAP_S)
    holes = np.asarray(
        _true_runs(unsaid, least=max(round(MAX_SPEED_GAP_S / step), 1)) * step, float
    )
    holes = holes[(holes[:, 0] > ends[0]) & (holes[:, 1] < min(ends[1], time[-1]))]
    holes = holes[holes[:, 0] > 0]
    whole = max(float(np.count_nonzero(moving)) * step, step)
    kept = (whole - gone) / (len(runs) + 1)
    trusted = not len(runs) or (
        gone < (1 - MIN_KNOWN_ANGLE_TIME_SHARE) * whole
        and kept > min(MIN_MEAN_TIME_BETWEEN_ANGLE_LOSSES_S, 0.3 * whole)
    )
    return ShaftAngle(
        _integrated_rotation(time, turning),
        lag=1.0 if stair and not geared_by else 0.15,
        trusted=trusted,
        lost_intervals=runs if trusted else runs[:0],
        unknown_speed_share=black / whole,
        known_time_span=ends,
        speed_gaps=holes,
        negative_speed_intervals=way.runs / rate,
        negative_speed_counts=way.size_counts,
    )


def _smooth_speed(speed: FloatArray, step: float) -> FloatArray:
    """Return a speed (n,) without what comes once a turn, as of an eccentric tone wheel.

    That is none of the shaft's, and a mode at one of its orders would make much of it: with it
    order 4 had explained an engine's third, a false attribution. A cubic over a third of a second
    keeps what a vehicle does. Source: Savitzky & Golay, Anal. Chem. 36 (1964).
    """
    from scipy.signal import savgol_filter

    size = 2 * round(SPEED_SMOOTHING_WINDOW_S / 2 / step) + 1
    if not 5 <= size <= speed.size:
        return speed
    return np.where(speed > 0, np.maximum(savgol_filter(speed, size, 3), 0.0), 0.0)


@lru_cache(maxsize=1)
def _time_grid(until: float, step: float) -> FloatArray:
    """Return times (n,) s up to one: shaft and engine of a day's drive share them."""
    time = np.arange(0.0, until, step)
    time.flags.writeable = False
    return time


def _stuck_speed(speed: FloatArray, engine: FloatArray, *, rate: float) -> BoolArray:
    """Return where a speed (n,) stands at one value for long while the engine's does not."""
    edge = np.concatenate([[0], np.flatnonzero(np.diff(speed) != 0) + 1, [speed.size]])
    found = np.zeros(speed.size, bool)
    for k in np.flatnonzero(np.diff(edge) >= MIN_STUCK_SPEED_S * rate).tolist():
        a, b = int(edge[k]), int(edge[k + 1])
        told = engine[a:b][~np.isnan(engine[a:b])]
        if speed[a] > 0 and told.size:
            low, high = np.quantile(told, (0.05, 0.95))
            found[a:b] = high > (1 + MIN_ENGINE_SPEED_CHANGE) * max(low, 0.0)
    return found


def _true_runs(of: BoolArray, *, least: int) -> IntArray:
    """Return runs (k, 2) of what is so for some samples; what parts two by less is none."""
    edge = np.flatnonzero(np.diff(np.concatenate([[False], of, [False]]).astype(np.int8)))
    runs = edge.reshape(-1, 2)
    apart = runs[1:, 0] - runs[:-1, 1] >= least
    first = runs[:, 0][np.append(True, apart)[: len(runs)]]
    last = runs[:, 1][np.append(apart, True)[: len(runs)]]
    long = last - first >= least
    return np.stack([first[long], last[long]], -1)


def _integrated_rotation(time: FloatArray, speed: FloatArray) -> ShaftRotation:
    return ShaftRotation(time, _cumulative_turns(time, speed))


def _log_speed_ratio(speed: FloatArray, engine: FloatArray) -> FloatArray:
    """Logarithm (n,) of shaft over engine; nan where either stands."""
    moving = (speed > 0.5) & (engine > 3.0)
    ratio = np.full(speed.size, np.nan)
    np.divide(speed, engine, out=ratio, where=moving)
    return np.log(ratio, out=ratio, where=moving)


def _running_median(x: FloatArray, half: int) -> FloatArray:
    """Return the running median (n,) over 2 half + 1 values, nan left out of account."""
    from scipy.ndimage import median_filter

    filled = np.where(np.isnan(x), 9.0, x)
    return median_filter(filled, size=2 * half + 1, mode="nearest")


def _staircase_lag(own: SpeedReadings, motor: SpeedReadings, time: FloatArray) -> float:
    """How late, s, a staircase comes: with the right lag it keeps to the gears' ratios."""
    best, least = 0.0, np.inf
    engine = motor.at(time)
    for late in np.arange(-0.5, 1.51, 0.05):
        r = _log_speed_ratio(own.at(time + late), engine)
        level = _running_median(r, 100)
        centres = _find_log_gear_ratios(level[~np.isnan(r) & (np.abs(r - level) < 0.02)])
        if not centres.size:
            continue
        off = np.abs(r - _nearest(r, centres))
        rough = float(np.nanmean(np.minimum(off, 0.1)))
        if rough < least:
            best, least = float(late), rough
    return best


def _nearest(x: FloatArray, centres: FloatArray) -> FloatArray:
    """Return the nearest of some centres to each value (n,)."""
    rising = np.sort(centres)
    place = np.searchsorted((rising[1:] + rising[:-1]) / 2, x).astype(np.int16)  # gears are few
    return rising[place]


def _speed_from_engine(
    speed: FloatArray, engine: FloatArray, *, told: BoolArray | bool = True
) -> tuple[FloatArray, BoolArray]:
    """Shaft speed by the engine's and the gear (n,), and where a gear is in.

    Gears are those in which it was driven where the shaft's own speed is `told`: what stands
    in for it elsewhere makes one of every steady engine.
    """
    r = _log_speed_ratio(speed, engine)
    level = _running_median(r, 100)
    centres = _find_log_gear_ratios(level[_is_close(r, level, 0.02) & told])
    if not centres.size:
        return speed, np.zeros(speed.size, bool)
    near = _nearest(level, centres)
    # Where the median itself sits between two gears, neither is in.
    engaged = _is_close(level, near, 0.08) & _is_close(r, near, 0.1)
    geared = np.exp(near, out=near)
    geared *= engine
    return geared, engaged


def _is_close(x: FloatArray, other: FloatArray, within: float) -> BoolArray:
    """Return where two (n,) are that close, nowhere where one is nan; of a day some at a time."""
    found = np.empty(x.size, bool)
    for first in range(0, x.size, TIME_POINTS_PER_BLOCK):
        some = slice(first, first + TIME_POINTS_PER_BLOCK)
        found[some] = np.abs(x[some] - other[some]) < within
    return found


def estimate_gear_ratios(
    shaft: ShaftRotation, engine: ShaftRotation, time: ArrayLike
) -> FloatArray:
    """Return the engine's turns a shaft turn in the gear at times (n,) s, nan in none."""
    time = np.asarray(time, float)
    until = float(time[-1]) + 0.05 if time.size else 0.0
    fine = np.arange(0.0, until, max(0.01, until / MAX_ROTATION_TIME_POINTS))
    if fine.size < 2:
        return np.full(time.size, np.nan)
    own, motor = shaft.speed(fine), engine.speed(fine)
    asked = np.searchsorted(fine, time).clip(0, fine.size - 1)
    del fine  # of seven hours each of these is 20 MB
    geared, engaged = _speed_from_engine(own, motor)
    geared, engaged = geared[asked], engaged[asked]
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.where(engaged & (geared > 0), motor[asked] / geared, np.nan)


def _find_log_gear_ratios(calm: FloatArray) -> FloatArray:
    """Return the ratios, as logarithms, that a line keeps to: where most of the time is."""
    step, least = 0.01, 200
    if calm.size < least:
        return np.empty(0)
    edges = np.arange(calm.min() - step, calm.max() + 2 * step, step)
    count, _ = np.histogram(calm, edges)
    count = np.convolve(count, np.ones(3), "same")
    centres: list[float] = []
    for k in np.argsort(-count):
        middle = edges[k] + step / 2
        if count[k] < least:
            break
        # Gears stand apart by a tenth and more.
        if all(abs(middle - c) > 0.08 for c in centres):
            about = calm[_is_close(calm, np.broadcast_to(middle, calm.shape), 1.5 * step)]
            centres.append(float(np.median(about, overwrite_input=True)))
    return np.array(centres)
