"""Order tracking: which part of a signal turns with the shaft, and how large it is.

A tone is a sinusoid locked to a rotation, A(t) e^{i k θ(t)} with a slowly moving amplitude.
All tones and the slow mean are found together by least squares, their amplitudes cubic
B-splines in time, so tones that cross or come close share the signal fairly. It is the
Vold-Kalman filter of the second kind with splines in place of its smoothness penalty: same
bandwidth at the same cost of resolution, but banded, small, and local enough to stream.
Sources: Vold & Leuridan, SAE 931288 (1993); Tuma, Vold-Kalman order tracking filtration
(2005); de Boor, A Practical Guide to Splines (1978).
"""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cache
from typing import TypeAlias

import numpy as np
import numpy.typing as npt

from cardan.core.arrays import ArrayLike, BoolArray, ComplexArray, FloatArray
from cardan.core.errors import DesignError
from cardan.physics.fatigue.spectral import periodograms
from cardan.physics.signals.conditioning import interpolate_gaps, low_pass, overlapping_pieces
from cardan.physics.signals.order_kernels import best_predecessor_within_reach, unit_phasor_of_turns
from cardan.physics.signals.recording import rechunk_to_block_size

SPEED_SAMPLES_PER_PROCESSING_BLOCK = 1 << 17
"""Times of a rotation that are derived at once."""


@dataclass(frozen=True)
class ShaftRotation:
    """How far something has turned, at some times; straight between them.

    Attributes
    ----------
    time : (n,) s
        From the first sample of the recording.
    turns : (n,) 1
        Turns made; never falling.
    """

    time: FloatArray
    turns: FloatArray

    def __post_init__(self) -> None:
        if self.time.size < 2 or not (self.time[1:] > self.time[:-1]).all():
            msg = "a rotation needs two or more rising times"
            raise DesignError(msg)
        if not (self.turns[1:] >= self.turns[:-1]).all():
            msg = "a rotation must not turn back"
            raise DesignError(msg)

    def at(self, time: ArrayLike) -> FloatArray:
        """Return the turns made (...) at each time (...) s."""
        t = np.asarray(time, float)
        first, last = self.time[0], self.time[-1]
        found = np.interp(t, self.time, self.turns)
        if not t.size or (
            np.fmin.reduce(t, axis=None) >= first and np.fmax.reduce(t, axis=None) <= last
        ):
            return found
        # Beyond its ends it goes on at its last speed.
        before, after = np.minimum(t - first, 0), np.maximum(t - last, 0)
        slow, fast = (
            (self.turns[k + 1] - self.turns[k]) / (self.time[k + 1] - self.time[k]) for k in (0, -2)
        )
        return found + before * slow + after * fast

    def speed(self, time: ArrayLike) -> FloatArray:
        """Return the turns a second (...) at each time (...) s."""
        t = np.asarray(time, float)
        # Of a day's drive only what is needed is derived, and an hour at once.
        count = max(min(self.time.size // SPEED_SAMPLES_PER_PROCESSING_BLOCK, t.size), 1)
        found = np.empty(t.size)
        parts = (np.array_split(x, count) for x in (t.ravel(), found))
        for at, part in zip(*parts, strict=True):
            part[:] = self._speed(at)
        return found.reshape(t.shape)

    def _speed(self, t: FloatArray) -> FloatArray:
        if not t.size:
            return t
        first = int(np.searchsorted(self.time, np.fmin.reduce(t))) - 2
        last = int(np.searchsorted(self.time, np.fmax.reduce(t))) + 2
        near = slice(max(min(first, self.time.size - 3), 0), max(last, 3))
        time = self.time[near]
        return np.interp(t, time, np.gradient(self.turns[near], time))

    def within(self, first: float, last: float) -> "ShaftRotation":
        """Return it between two times, s, and a few of its own beyond: a part, not a copy."""
        k, end = np.searchsorted(self.time, (first, last))
        k = max(min(int(k), self.time.size) - 4, 0)
        return ShaftRotation(self.time[k : int(end) + 4], self.turns[k : int(end) + 4])

    def geared(self, ratio: float) -> "ShaftRotation":
        """Return the rotation of what turns `ratio` times as fast: a wheel, an engine."""
        return ShaftRotation(self.time, ratio * self.turns)


def rotation_from_speed(
    speed: Iterable[FloatArray], *, rate: float, unit: float = 1.0, step: float = 0.02
) -> ShaftRotation:
    """Integrate a speed channel.

    Parameters
    ----------
    speed : pieces (1, n)
        Speed, holes bridged; below zero counts as standing.
    rate : Hz
        Of the samples.
    unit : turns/s
        Of the channel: 1/60 for rpm.
    step : s
        Between the times kept; the mean speed over a step is kept exactly.
    """
    n = max(round(step * rate), 1)
    means: list[FloatArray] = []
    for piece in rechunk_to_block_size(speed, size=n * 4096):
        x = np.maximum(interpolate_gaps(piece[0]), 0) * unit
        if x.size % n:
            x = np.concatenate([x, np.full(n - x.size % n, x[-1])])
        means.append(x.reshape(-1, n).mean(-1))
    turns = np.concatenate([[0.0], np.cumsum(np.concatenate(means)) * n / rate])
    return ShaftRotation((np.arange(turns.size, dtype=float) * n - 0.5) / rate, turns)


def rotation_from_pulses(
    pulses: Iterable[FloatArray], *, rate: float, per_turn: int = 1, level: float | None = None
) -> ShaftRotation:
    """Read a tacho channel: one rising edge through `level` for each pulse.

    The level is the middle between low and high of the first piece unless given, with a
    hysteresis of a fifth of that span about it. Edges are placed between samples, and where
    they come evenly by a cubic through their neighbours: a sample's width is no unsteadiness.

    Raises
    ------
    DesignError
        If there are fewer than two pulses.
    """
    edges: list[FloatArray] = []
    last, high, start, band = np.nan, False, 0, 0.0
    for piece in pulses:
        x = interpolate_gaps(piece[0])
        if np.isnan(last):
            low, top = np.quantile(x, [0.02, 0.98]) if level is None else (x.min(), x.max())
            level = float((low + top) / 2) if level is None else level
            band, last, high = 0.1 * float(top - low), float(x[0]), bool(x[0] > level)
        assert level is not None
        whole = np.concatenate([[last], x])
        state = np.where(whole > level + band, 1, np.where(whole < level - band, -1, 0))
        state[0] = 1 if high else -1
        # In the band the state is what it was: carry the last known one forward.
        known = np.maximum.accumulate(np.where(state != 0, np.arange(state.size), 0))
        state = state[known]
        rising = np.flatnonzero((state[1:] > 0) & (state[:-1] < 0))
        # The edge: where the line through its two samples crosses the upper threshold.
        a, b = whole[rising], whole[rising + 1]
        edges.append(start - 1 + rising + (level + band - a) / (b - a))
        last, high, start = float(x[-1]), bool(state[-1] > 0), start + x.size
    time = np.concatenate(edges or [np.empty(0)]) / rate
    if time.size < 2:
        msg = f"a tacho needs two or more pulses, got {time.size}"
        raise DesignError(msg)
    time = _smooth_pulse_times(time)
    # Before the first and after the last pulse it goes on as fast as between the nearest two.
    first, final = 2 * time[0] - time[1], 2 * time[-1] - time[-2]
    time = np.concatenate([[first], time, [final]])
    return ShaftRotation(time, np.arange(time.size) / per_turn)


PULSES_PER_SMOOTHING_WINDOW = 9
"""Pulses that a cubic goes through: a shaft's speed changes little in as many turns."""

MAX_RELATIVE_PULSE_INTERVAL_CHANGE = 0.15
"""Change of interval between pulses, relative, up to which they come evenly."""


def _smooth_pulse_times(time: FloatArray) -> FloatArray:
    """Return pulses (n,) s on a cubic through their neighbours, where they come evenly.

    Source: Savitzky & Golay, Anal. Chem. 36 (1964).
    """
    from scipy.ndimage import minimum_filter1d
    from scipy.signal import savgol_filter

    if time.size < PULSES_PER_SMOOTHING_WINDOW:
        return time
    interval = np.diff(time)
    steady = np.abs(np.diff(interval)) < MAX_RELATIVE_PULSE_INTERVAL_CHANGE * np.minimum(
        interval[1:], interval[:-1]
    )
    # A pulse is put right where all about it, one beyond the cubic's ends too, come evenly.
    even = (
        minimum_filter1d(np.pad(steady, 1), PULSES_PER_SMOOTHING_WINDOW, mode="constant", cval=0)
        > 0
    )
    return np.where(even, savgol_filter(time, PULSES_PER_SMOOTHING_WINDOW, 3), time)


def estimate_rotation_from_vibration(
    signal: FloatArray | Iterable[FloatArray], *, rate: float,
    orders: Sequence[float] = (2.0, 1.0, 4.0), slowest: float = 5.0, fastest: float = 60.0,
    window: float = 1.0, jerk: float = 2.0,
) -> ShaftRotation:  # fmt: skip
    """Estimate the shaft's rotation from the signal itself, where there is no tacho.

    In a spectrogram of `window` s the speed is the path along which the power at `orders`
    is largest, changing by at most `jerk` turns/s from frame to frame (dynamic programming).
    It is known to some tenths of a turn a second: enough for a spectrum, and no phase.

    Parameters
    ----------
    signal : (n,) or pieces of it (1, n)
        A channel in which the orders stand out. Of a long one some bytes a sample are held,
        thinned to what the orders need, and one byte for each speed and half second.
    rate : Hz
        Of its samples.
    orders
        Expected in it, the strongest first: that distinguishes a speed from its double.
    slowest, fastest : turns/s
        Range searched. A standing shaft is not recognised.
    """
    every = max(int(rate / (2.2 * max(orders) * fastest)), 1)
    pieces = [signal[None]] if isinstance(signal, np.ndarray) else signal
    thin, rate = _decimate(pieces, every=every, rate=rate), rate / every
    n = round(window * rate)
    if thin.size < 1.5 * n:
        msg = f"the signal is too short: at least {1.5 * window:g} s are needed"
        raise DesignError(msg)
    fine = 0.1 / window / max(orders)
    speeds = np.arange(slowest, fastest, fine)
    reach = max(int(jerk / fine), 1)
    slope = 0.5 * len(orders) / reach
    best: FloatArray = np.zeros(speeds.size)
    back: list[npt.NDArray[np.signedinteger]] = []
    short = np.int8 if reach < 128 else np.int16
    here = np.arange(speeds.size)
    for score in _order_scores(thin, rate=rate, n=n, orders=orders, speeds=speeds):
        came, left = best_predecessor_within_reach(best, reach=reach, slope=slope)
        back.append((came - here).astype(short))
        best = score + left
    path = np.empty(len(back), dtype=np.int64)
    path[-1] = int(best.argmax())
    for k in range(len(back) - 1, 0, -1):
        path[k - 1] = path[k] + back[k][path[k]]
    middle = (np.arange(len(back)) * (n // 2) + n / 2) / rate
    time = np.arange(0, thin.size / rate + 0.02, 0.02)
    speed = np.interp(time, middle, speeds[path])
    turns = np.concatenate([[0.0], np.cumsum((speed[1:] + speed[:-1]) / 2 * np.diff(time))])
    return ShaftRotation(time, turns)


def _decimate(
    pieces: Iterable[FloatArray], *, every: int, rate: float
) -> FloatArray | npt.NDArray[np.float32]:
    """Every so manyth sample (n / every,) of a signal in pieces (1, n), freed of what is faster."""
    if every == 1:
        kept = [interpolate_gaps(piece[0]) for piece in pieces]
        return np.concatenate(kept or [np.empty(0)])
    slow = low_pass(0.45 * rate / every, rate=rate)
    start, found = 0, list[npt.NDArray[np.float32]]()
    for piece in slow(pieces):
        x = interpolate_gaps(piece[0])
        found.append(x[-start % every :: every].astype(np.float32))
        start += x.size
    return np.concatenate(found or [np.empty(0, np.float32)])


def _order_scores(
    x: FloatArray | npt.NDArray[np.float32], *, rate: float, n: int, orders: Sequence[float],
    speeds: FloatArray,
) -> Iterator[FloatArray]:  # fmt: skip
    """Yield how much the orders of each speed stand out, frame by half-overlapping frame."""
    step = n // 2
    most = 512
    for first in range(0, x.size - n + 1, most * step):
        some = x[first : first + (most + 1) * step].astype(float)
        frequency, power = periodograms(some, rate=rate, segment=n)
        power = power[:most]
        level = np.log(power + 1e-9 * power.max() + 1e-300)
        # Above the neighbourhood: half a window's median over a tenth of the band flattens roads.
        around = np.lib.stride_tricks.sliding_window_view(
            np.pad(level, ((0, 0), (12, 12)), mode="edge"), 25, axis=-1
        )
        # Of 25 a median is the thirteenth: NumPy's own sorts more, and takes six times as long.
        level = np.maximum(level - np.partition(around, 12, axis=-1)[..., 12], 0)
        score: FloatArray = np.zeros((len(level), speeds.size))
        for rank, k in enumerate(orders):
            place = np.minimum(k * speeds / frequency[1], frequency.size - 1.0)
            low = np.minimum(place.astype(np.intp), frequency.size - 2)
            share = np.where(k * speeds > frequency[-1], 0.0, 1 / (rank + 1))
            low_share = (1 - (place - low)) * share
            score += level[:, low] * low_share + level[:, low + 1] * (share - low_share)
        yield from score


@dataclass(frozen=True)
class OrderComponent:
    """A sinusoid locked to a rotation: `order` times as fast."""

    rotation: ShaftRotation
    order: float

    def frequency(self, time: ArrayLike) -> FloatArray:
        """Frequency (...) Hz at each time (...) s."""
        return self.order * self.rotation.speed(time)


@dataclass(frozen=True)
class OrderDecomposition:
    """A stretch of a signal, taken apart.

    Attributes
    ----------
    start : samples
        Where the stretch begins.
    signal : (channels, n)
        What was taken apart, holes bridged.
    slow_mean : (channels, n)
        Its moving mean.
    components : (channels, tones, n)
        Each tone; signal less slow less all tones is the rest.
    amplitude : (channels, tones, m) complex
        Of each tone at the middles of its spans, counted from its rotation's zero.
    time, frequency : (m,) s and (tones, m) Hz
        Of those middles.
    padded_residual, padded_event : (channels, n + 2 margin or more)
        The rest with `margin` samples before it and at least as many behind, zero outside
        the recording, and how far each sample belongs to an event, 0 to 1.
    """

    start: int
    signal: FloatArray
    slow_mean: "OrderFitArray"
    components: "OrderFitArray"
    amplitude: ComplexArray
    time: FloatArray
    frequency: FloatArray
    padded_residual: FloatArray
    padded_event: FloatArray
    margin: int

    @property
    def residual(self) -> FloatArray:
        """Signal less slow mean less tones, (channels, n)."""
        return self.signal - self.slow_mean - self.components.sum(1, dtype=float)


def _spline_basis(n: int) -> FloatArray:
    """Four cubic B-splines over one span of n samples, (4, n)."""
    u = (np.arange(n) + 0.5) / n
    return np.stack(
        [(1 - u) ** 3, 3 * u**3 - 6 * u**2 + 4, 3 * (u + u**2 - u**3) + 1, u**3]
    ) / 6  # fmt: skip


@cache
def _spline_products(n: int) -> "tuple[OrderFitArray, OrderFitArray]":
    """Products of each two splines over a span, (16, 7) of powers (7, n): of degree six."""
    powers = np.asarray(np.polynomial.legendre.legvander(np.linspace(-1, 1, n), 6).T, float)
    basis = _spline_basis(n)
    both = (basis[:, None] * basis).reshape(16, n) @ np.linalg.pinv(powers)
    return powers.astype(OrderFitDtype), both.astype(OrderFitDtype)


OrderFitDtype = np.float32
OrderFitArray: TypeAlias = npt.NDArray[np.float32]
"""What tones are met in: of sums over a span seven digits say more than any noise leaves of one."""

AMPLITUDE_RIDGE_WEIGHT, AMPLITUDE_CHANGE_PENALTY = 1e-4, 1e-2
"""Price of an amplitude's size and of its changes, against samples that say otherwise."""

MAX_SINGLE_THREAD_MATRIX_ELEMENTS = 1 << 18
"""Size of a matrix product up to which OpenBLAS does not start threads."""

IMPACT_SAMPLE_WEIGHT_IN_ORDER_FIT = 0.01
"""Weight of an event's samples relative to others, when tones are looked for."""

BLOCK_MARGIN_SPLINE_SPANS = 8
"""Spans beyond a stretch that are solved with it: what is farther changes it below 1e-3."""


@dataclass(frozen=True, kw_only=True)
class OrderDecomposer:
    """Takes a signal apart into tones, slow mean and rest, stretch by stretch.

    Attributes
    ----------
    components
        To find; those locked to one another in one fixed ratio of 1 cannot be distinguished.
    rate : Hz
        Of the samples.
    span : s
        Between knots of the amplitudes: tones that differ by less than about 1/span Hz run
        together, and random vibration within that band counts as tone.
    min_frequency : Hz
        A tone below this is dropped: it cannot be distinguished from the slow mean.
    stretch_spans
        Spans solved together.
    event_factor
        What stands out of the rest by this many times the rms of its louder seconds (their
        90 % quantile) is an event; infinite for none.
    event_width : s
        Kept on both sides of where the rest stands out.
    """

    components: tuple[OrderComponent, ...]
    rate: float
    span: float = 0.5
    min_frequency: float = 4.0
    stretch_spans: int = 48
    event_factor: float = 5.0
    event_width: float = 0.4

    @property
    def span_samples(self) -> int:
        """Samples in a span."""
        return max(round(self.span * self.rate), 8)

    def decompose(self, pieces: Iterable[FloatArray]) -> Iterator[OrderDecomposition]:
        """Take a signal (channels, n) in pieces apart; the cuts do not matter."""
        n, reach = self.span_samples, BLOCK_MARGIN_SPLINE_SPANS * self.span_samples
        size = self.stretch_spans * n
        start, normal = 0, _NormalEquations.none(1 + 2 * len(self.components), n)
        for padded in overlapping_pieces(
            rechunk_to_block_size(_with_sample_numbers(pieces), size=size), reach=reach
        ):
            body = padded.shape[1] - 2 * reach
            split, normal = self._solve(padded[1:], padded[0], start, body, normal)
            yield split
            start += body

    def _solve(
        self, x: FloatArray, number: FloatArray, start: int, body: int, before: "_NormalEquations"
    ) -> "tuple[OrderDecomposition, _NormalEquations]":
        """Take a stretch apart, knowing what turned where the one `before` met it."""
        n, reach = self.span_samples, BLOCK_MARGIN_SPLINE_SPANS * self.span_samples
        x = interpolate_gaps(x)
        # Whole spans: the last stretch is filled up with samples that count for nothing.
        fill = -x.shape[1] % n
        x = np.pad(x, ((0, 0), (0, fill)), mode="edge")
        place = start - reach + np.arange(x.shape[1])
        inside = (place >= number[0]) & (place <= number[-1])
        time = place / self.rate
        spans = x.shape[1] // n
        weight = inside.astype(OrderFitDtype).reshape(spans, n)
        normal = self._normal(start - reach, weight, before)
        fitted, coefficients = _fit(x, normal)
        event, left = np.zeros_like(x), x - fitted.sum(1, dtype=float)
        if np.isfinite(self.event_factor):
            event = self._events(left, inside)
            if event.any():
                # Again with the events nearly silent, so that a blow is not spread into tones.
                quiet = np.where(
                    event.max(0) < 0.5,
                    OrderFitDtype(1),
                    OrderFitDtype(IMPACT_SAMPLE_WEIGHT_IN_ORDER_FIT),
                ).reshape(spans, n)
                fitted, coefficients = _fit(x, normal.weighed(weight * quiet))
                left = x - fitted.sum(1, dtype=float)
                event = self._events(left, inside)
        rest = np.where(inside, left, 0.0)
        middle = time.reshape(spans, n)[:, n // 2]
        keep = slice(reach, reach + body)
        held = (middle >= time[reach]) & (middle < time[reach] + body / self.rate)
        at_middle = np.einsum("a,cpja->cpj", _spline_basis(1)[:, 0], coefficients)
        amplitude = at_middle[:, 1::2] - 1j * at_middle[:, 2::2]
        frequency = (
            np.stack([t.frequency(middle) for t in self.components])
            if self.components
            else (np.empty((0, spans)))
        )
        amplitude = np.where(frequency >= self.min_frequency, amplitude, 0)
        split = OrderDecomposition(
            start=start,
            signal=x[:, keep],
            slow_mean=fitted[:, 0, keep],
            components=fitted[:, 1:, keep],
            amplitude=amplitude[..., held],
            time=middle[held],
            frequency=frequency[:, held],
            padded_residual=rest,
            padded_event=event,
            margin=reach,
        )
        return split, normal

    def _normal(
        self, first: int, weight: "OrderFitArray", before: "_NormalEquations"
    ) -> "_NormalEquations":
        """Return what turns in spans (spans, n) from a sample on, their samples weighed."""
        met = before.since(first)
        known = len(met.weight)
        met = met.weighed(weight[:known])
        rows = self._rows(first + known * self.span_samples, len(weight) - known)
        return _NormalEquations(
            first, np.concatenate([met.rows, rows]), weight,
            np.concatenate([met.gram, _gram(rows, weight[known:])]),
        )  # fmt: skip

    def _rows(self, first: int, spans: int) -> "OrderFitArray":
        """One for the slow mean, cosine and sine for each tone, (spans, 1 + 2 tones, n)."""
        time = (first + np.arange(spans * self.span_samples)) / self.rate
        rows = np.ones((spans, 1 + 2 * len(self.components), self.span_samples), OrderFitDtype)
        met = {id(t.rotation): t.rotation for t in self.components}
        known = {name: (of.at(time), of.speed(time)) for name, of in met.items()}
        for k, tone in enumerate(self.components):
            made, speed = known[id(tone.rotation)]
            turning = unit_phasor_of_turns(tone.order * made)
            # Let a tone in smoothly over a quarter above the slowest frequency.
            risen = (tone.order * speed / self.min_frequency - 1) * 4
            if (risen < 1).any():
                gate = np.clip(risen, 0, 1)
                turning *= gate * gate * (3 - 2 * gate)
            turning = turning.reshape(spans, -1)
            rows[:, 2 * k + 1], rows[:, 2 * k + 2] = turning.real, turning.imag
        return rows

    def _events(self, rest: FloatArray, inside: BoolArray) -> FloatArray:
        """Weight (channels, n) of the event windows in a rest, 0 to 1 with soft edges."""
        # The louder seconds set the scale, so that driving off is no event next to standing.
        known, second = rest[:, inside], max(round(self.rate), 1)
        blocks = known[:, : max(known.shape[1] // second, 1) * second]
        blocks = blocks.reshape(rest.shape[0], -1, min(second, blocks.shape[1]))
        typical = np.quantile(np.sqrt((blocks**2).mean(-1)), 0.9, axis=-1)[:, None]
        loud = (np.abs(rest) > self.event_factor * typical) & inside
        if not loud.any():
            return np.zeros_like(rest)
        wide, soft = round(self.event_width * self.rate), max(round(0.02 * self.rate), 1)
        out = np.zeros_like(rest)
        place = np.arange(rest.shape[1])
        for k, row in enumerate(loud):
            at = np.flatnonzero(row)
            if at.size:
                near = np.searchsorted(at, place)
                before = place - at[np.maximum(near - 1, 0)]
                after = at[np.minimum(near, at.size - 1)] - place
                far = np.minimum(np.where(before < 0, wide + soft, before),
                                 np.where(after < 0, wide + soft, after))  # fmt: skip
                edge = np.clip((wide + soft - far) / soft, 0, 1)
                out[k] = edge * edge * (3 - 2 * edge)
        return out


@dataclass(frozen=True)
class _NormalEquations:
    """What turns in some spans, and the matrices by which amplitudes are found.

    Attributes
    ----------
    first : samples
        Where they begin.
    rows : (spans, p, n)
        One for the slow mean, cosine and sine for each tone.
    weight : (spans, n)
        Of the samples.
    gram : (spans, 4 p, 4 p)
        Sums over samples, so weighed, of each two of four splines times p rows.
    """

    first: int
    rows: OrderFitArray
    weight: OrderFitArray
    gram: OrderFitArray

    @classmethod
    def none(cls, p: int, n: int) -> "_NormalEquations":
        """Return that of no spans."""
        return cls(
            0,
            np.empty((0, p, n), OrderFitDtype),
            np.empty((0, n), OrderFitDtype),
            np.empty((0, 4 * p, 4 * p), OrderFitDtype),
        )

    def since(self, first: int) -> "_NormalEquations":
        """Return those from a sample on."""
        k = (first - self.first) // self.rows.shape[-1]
        return _NormalEquations(first, self.rows[k:], self.weight[k:], self.gram[k:])

    def weighed(self, weight: OrderFitArray) -> "_NormalEquations":
        """Return them otherwise weighed: only spans in which that is so are summed again."""
        other = (weight != self.weight).any(-1)
        gram = self.gram.copy()
        gram[other] = _gram(self.rows[other], weight[other])
        return replace(self, weight=weight, gram=gram)


def _gram(rows: OrderFitArray, weight: OrderFitArray) -> OrderFitArray:
    """Return what `_NormalEquations.gram` is, of rows (spans, p, n) with weights (spans, n)."""
    spans, p, n = rows.shape
    weighted = rows * weight[:, None]
    # What two splines make is alike in all spans, and what two rows make either way round.
    powers, both = _spline_products(n)
    low = [_sample_products(weighted[:, k : k + 1] * rows[:, : k + 1], powers) for k in range(p)]
    one, other = np.tril_indices(p)
    pairs = (np.concatenate(low, axis=1) @ both.T).reshape(spans, one.size, 4, 4).swapaxes(0, 1)
    gram = np.empty((spans, 4, p, 4, p), OrderFitDtype)
    gram[:, :, other, :, one] = pairs
    gram[:, :, one, :, other] = pairs
    return gram.reshape(spans, 4 * p, 4 * p)


def _fit(x: FloatArray, normal: _NormalEquations) -> tuple[OrderFitArray, FloatArray]:
    """Parts (channels, 1 + tones, n) of x, and spline coefficients (c, p, spans, 4)."""
    from scipy.linalg import solveh_banded

    rows, gram = normal.rows, normal.gram
    spans, p, n = rows.shape
    channels = x.shape[0]
    basis = _spline_basis(n).astype(OrderFitDtype)
    target = (x.astype(OrderFitDtype).reshape(channels, spans, n) * normal.weight)[:, :, None]
    right = np.stack([_sample_products(rows * each, basis) for each in target], axis=-1)
    right = right.swapaxes(1, 2).reshape(spans, 4 * p, channels)
    size = (spans + 3) * p
    banded: FloatArray = np.zeros((4 * p, size))
    total: FloatArray = np.zeros((size, channels))
    row, column = np.tril_indices(4 * p)
    # Lower form: entry (i, k) of the matrix stands at [i - k, k].
    low: FloatArray = np.zeros((4 * p, spans, 4 * p))
    low[row - column, :, column] = gram[:, row, column].T
    for j in range(4):  # every fourth span has splines of its own
        apart, own = low[:, j::4].reshape(4 * p, -1), right[j::4].reshape(-1, channels)
        banded[:, j * p : j * p + apart.shape[1]] += apart
        total[j * p : j * p + len(own)] += own
    # Where the signal does not decide (holes, events, tones let go or running together)
    # amplitudes go on steadily and stay small: it costs a steady tone half a per mille.
    ridge = np.full(size, AMPLITUDE_RIDGE_WEIGHT * n)
    ridge[::p] = 0.0
    banded[0] += ridge + 1e-9 * n
    banded[0, :-p] += AMPLITUDE_CHANGE_PENALTY * n
    banded[0, p:] += AMPLITUDE_CHANGE_PENALTY * n
    banded[p, :-p] -= AMPLITUDE_CHANGE_PENALTY * n
    c = solveh_banded(banded, total, lower=True, check_finite=False)
    c = c.reshape(spans + 3, p, channels)
    local = np.stack([c[k : k + spans].T for k in range(4)], axis=-1)  # (ch, p, spans, 4)
    each = local.astype(OrderFitDtype) @ basis
    each *= rows.swapaxes(0, 1)
    each = each.reshape(channels, p, -1)
    parts = np.concatenate([each[:, :1], each[:, 1::2] + each[:, 2::2]], axis=1)
    return parts, local


def _sample_products(a: OrderFitArray, b: OrderFitArray) -> OrderFitArray:
    """Return Σ a b over samples of each two rows of (spans, i, n) and (j, n), (spans, i, j).

    In slices too small for BLAS to start threads on: on a busy machine they cost thirty times
    the work.
    """
    n = b.shape[-1]
    flat, size = a.reshape(-1, n), max(MAX_SINGLE_THREAD_MATRIX_ELEMENTS // b.size, 1)
    parts = [flat[k : k + size] @ b.T for k in range(0, max(len(flat), 1), size)]
    return np.concatenate(parts).reshape(*a.shape[:-1], len(b))


def _with_sample_numbers(pieces: Iterable[FloatArray]) -> Iterator[FloatArray]:
    """Put the place of each sample in front of the channels: padding repeats it."""
    start = 0
    for piece in pieces:
        n = piece.shape[1]
        yield np.concatenate([np.arange(start, start + n, dtype=float)[None], piece])
        start += n
