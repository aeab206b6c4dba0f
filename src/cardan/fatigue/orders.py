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

from cardan.base.arrays import ArrayLike, BoolArray, ComplexArray, FloatArray
from cardan.base.errors import DesignError
from cardan.fatigue.conditioning import bridged, low_pass, overlapping
from cardan.fatigue.kernel import farther, on_circle
from cardan.fatigue.recording import cut
from cardan.fatigue.spectral import periodograms

DERIVED = 1 << 17
"""Times of a rotation that are derived at once."""


@dataclass(frozen=True)
class Rotation:
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
        # Of a day's drive only what is asked is derived, and an hour at once.
        count = max(min(self.time.size // DERIVED, t.size), 1)
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

    def within(self, first: float, last: float) -> "Rotation":
        """Return it between two times, s, and a few of its own beyond: a part, not a copy."""
        k, end = np.searchsorted(self.time, (first, last))
        k = max(min(int(k), self.time.size) - 4, 0)
        return Rotation(self.time[k : int(end) + 4], self.turns[k : int(end) + 4])

    def geared(self, ratio: float) -> "Rotation":
        """Return the rotation of what turns `ratio` times as fast: a wheel, an engine."""
        return Rotation(self.time, ratio * self.turns)


def wave(turns: FloatArray) -> ComplexArray:
    r"""Return $e^{2\pi i n}$: where what began at 1 stands after so many turns.

    Parameters
    ----------
    turns : (...) 1
        Turns n, whole ones included: as near as rounding of them allows.
    """
    return on_circle(turns)


def rotation_from_speed(
    speed: Iterable[FloatArray], *, rate: float, unit: float = 1.0, step: float = 0.02
) -> Rotation:
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
    for piece in cut(speed, size=n * 4096):
        x = np.maximum(bridged(piece[0]), 0) * unit
        if x.size % n:
            x = np.concatenate([x, np.full(n - x.size % n, x[-1])])
        means.append(x.reshape(-1, n).mean(-1))
    turns = np.concatenate([[0.0], np.cumsum(np.concatenate(means)) * n / rate])
    return Rotation((np.arange(turns.size, dtype=float) * n - 0.5) / rate, turns)


def rotation_from_pulses(
    pulses: Iterable[FloatArray], *, rate: float, per_turn: int = 1, level: float | None = None
) -> Rotation:
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
        x = bridged(piece[0])
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
    time = _evened(time)
    # Before the first and after the last pulse it goes on as fast as between the nearest two.
    first, final = 2 * time[0] - time[1], 2 * time[-1] - time[-2]
    time = np.concatenate([[first], time, [final]])
    return Rotation(time, np.arange(time.size) / per_turn)


ABOUT = 9
"""Pulses that a cubic goes through: a shaft's speed changes little in as many turns."""

EVEN = 0.15
"""Change of interval between pulses, relative, up to which they come evenly."""


def _evened(time: FloatArray) -> FloatArray:
    """Return pulses (n,) s on a cubic through their neighbours, where they come evenly.

    Source: Savitzky & Golay, Anal. Chem. 36 (1964).
    """
    from scipy.ndimage import minimum_filter1d
    from scipy.signal import savgol_filter

    if time.size < ABOUT:
        return time
    interval = np.diff(time)
    steady = np.abs(np.diff(interval)) < EVEN * np.minimum(interval[1:], interval[:-1])
    # A pulse is put right where all about it, one beyond the cubic's ends too, come evenly.
    even = minimum_filter1d(np.pad(steady, 1), ABOUT, mode="constant", cval=0) > 0
    return np.where(even, savgol_filter(time, ABOUT, 3), time)


def estimated_rotation(
    signal: FloatArray | Iterable[FloatArray], *, rate: float,
    orders: Sequence[float] = (2.0, 1.0, 4.0), slowest: float = 5.0, fastest: float = 60.0,
    window: float = 1.0, jerk: float = 2.0,
) -> Rotation:  # fmt: skip
    """Estimate the shaft's rotation from the signal itself, where there is no tacho.

    In a spectrogram of `window` s the speed is the path along which the power at `orders`
    is largest, changing by at most `jerk` turns/s from frame to frame (dynamic programming).
    It is told to some tenths of a turn a second: enough for a spectrum, and no phase.

    Parameters
    ----------
    signal : (n,) or pieces of it (1, n)
        A channel in which the orders stand out. Of a long one some bytes a sample are held,
        thinned to what the orders need, and one byte for each speed and half second.
    rate : Hz
        Of its samples.
    orders
        Expected in it, the strongest first: that tells a speed from its double.
    slowest, fastest : turns/s
        Range searched. A standing shaft is not recognised.
    """
    every = max(int(rate / (2.2 * max(orders) * fastest)), 1)
    pieces = [signal[None]] if isinstance(signal, np.ndarray) else signal
    thin, rate = _thinned(pieces, every=every, rate=rate), rate / every
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
    for score in _scores(thin, rate=rate, n=n, orders=orders, speeds=speeds):
        came, left = farther(best, reach=reach, slope=slope)
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
    return Rotation(time, turns)


def _thinned(
    pieces: Iterable[FloatArray], *, every: int, rate: float
) -> FloatArray | npt.NDArray[np.float32]:
    """Every so manyth sample (n / every,) of a signal in pieces (1, n), freed of what is faster."""
    if every == 1:
        kept = [bridged(piece[0]) for piece in pieces]
        return np.concatenate(kept or [np.empty(0)])
    slow = low_pass(0.45 * rate / every, rate=rate)
    start, found = 0, list[npt.NDArray[np.float32]]()
    for piece in slow(pieces):
        x = bridged(piece[0])
        found.append(x[-start % every :: every].astype(np.float32))
        start += x.size
    return np.concatenate(found or [np.empty(0, np.float32)])


def _scores(
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
        # Of 25 a median is the thirteenth: NumPy's own asks for more, and takes six times as long.
        level = np.maximum(level - np.partition(around, 12, axis=-1)[..., 12], 0)
        score: FloatArray = np.zeros((len(level), speeds.size))
        for rank, k in enumerate(orders):
            place = np.minimum(k * speeds / frequency[1], frequency.size - 1.0)
            low = np.minimum(place.astype(np.intp), frequency.size - 2)
            share = np.where(k * speeds > frequency[-1], 0.0, 1 / (rank + 1))
            low_share = (1 - (place - low)) * share
            score += level[:, low] * low_share + level[:, low + 1] * (share - low_share)
        yield from score


def order_spectrum(
    signal: FloatArray, *, rotation: Rotation, rate: float, turns: int = 64, top: float = 10.0
) -> tuple[FloatArray, FloatArray]:
    """Amplitude over order: the signal met at equal angles instead of equal times.

    Parameters
    ----------
    signal : (n,)
        The channel.
    rotation
        Of the shaft whose orders are asked for.
    rate : Hz
        Of the samples.
    turns
        Per block; resolution is 1/turns. Blocks are averaged by power.
    top
        Highest order; the shaft must turn slower than rate/2/top.

    Returns
    -------
    order, amplitude : (m,)
        Up to `top`. 0-to-peak; of a steady order exact to the window's 0.1 % at whole orders.
    """
    from scipy.signal import resample_poly

    per_turn = int(4 * top)
    time = np.arange(signal.size) / rate
    made = rotation.at(time)
    rising = np.concatenate([[True], np.diff(made) > 0])
    clock, angle = time[rising], made[rising]
    first = np.ceil(made[0])
    blocks = int((np.floor(made[-1]) - first) / turns)
    if blocks < 1:
        msg = f"the shaft makes fewer than {turns} turns; ask for fewer"
        raise ValueError(msg)
    # Four times finer first: straight lines then lose a per mille of the fastest order.
    fine = resample_poly(bridged(signal), 4, 1)
    fine_time = np.arange(fine.size) / (4 * rate)
    keep = int(turns * top) + 1
    power = np.zeros(keep)
    for k in range(blocks):
        start = first + k * turns
        span = np.interp([start, start + turns], angle, clock)
        # As many samples a turn as the block's slowest turn needs to hold all that was recorded:
        # fewer would fold a tone of fixed frequency onto an order.
        edges = np.interp(start + np.arange(turns + 1), angle, clock)
        slowest = max(1 / float(np.diff(edges).max()), 0.1 / float(np.diff(span)[0]))
        each = max(int(np.ceil(1.2 * rate / slowest)), per_turn)
        size = turns * each
        x = np.interp(np.interp(start + np.arange(size) / each, angle, clock), fine_time, fine)
        window = 0.5 - 0.5 * np.cos(2 * np.pi * np.arange(size) / size)
        lines = np.fft.rfft((x - x.mean()) * window)[:keep]
        power += (2 * np.abs(lines) / window.sum()) ** 2
    return np.arange(keep) / turns, np.sqrt(power / blocks)


@dataclass(frozen=True)
class Tone:
    """A sinusoid locked to a rotation: `order` times as fast."""

    rotation: Rotation
    order: float

    def frequency(self, time: ArrayLike) -> FloatArray:
        """Frequency (...) Hz at each time (...) s."""
        return self.order * self.rotation.speed(time)


@dataclass(frozen=True)
class Split:
    """A stretch of a signal, taken apart.

    Attributes
    ----------
    start : samples
        Where the stretch begins.
    signal : (channels, n)
        What was taken apart, holes bridged.
    slow : (channels, n)
        Its moving mean.
    tones : (channels, tones, n)
        Each tone; signal less slow less all tones is the rest.
    amplitude : (channels, tones, m) complex
        Of each tone at the middles of its spans, counted from its rotation's zero.
    time, frequency : (m,) s and (tones, m) Hz
        Of those middles.
    padded_rest, padded_event : (channels, n + 2 margin or more)
        The rest with `margin` samples before it and at least as many behind, zero outside
        the recording, and how far each sample belongs to an event, 0 to 1.
    """

    start: int
    signal: FloatArray
    slow: "Sums"
    tones: "Sums"
    amplitude: ComplexArray
    time: FloatArray
    frequency: FloatArray
    padded_rest: FloatArray
    padded_event: FloatArray
    margin: int

    @property
    def rest(self) -> FloatArray:
        """Signal less slow mean less tones, (channels, n)."""
        return self.signal - self.slow - self.tones.sum(1, dtype=float)


def _basis(n: int) -> FloatArray:
    """Four cubic B-splines over one span of n samples, (4, n)."""
    u = (np.arange(n) + 0.5) / n
    return np.stack(
        [(1 - u) ** 3, 3 * u**3 - 6 * u**2 + 4, 3 * (u + u**2 - u**3) + 1, u**3]
    ) / 6  # fmt: skip


@cache
def _pairs(n: int) -> "tuple[Sums, Sums]":
    """Products of each two splines over a span, (16, 7) of powers (7, n): of degree six."""
    powers = np.asarray(np.polynomial.legendre.legvander(np.linspace(-1, 1, n), 6).T, float)
    basis = _basis(n)
    both = (basis[:, None] * basis).reshape(16, n) @ np.linalg.pinv(powers)
    return powers.astype(Sum), both.astype(Sum)


Sum = np.float32
Sums: TypeAlias = npt.NDArray[np.float32]
"""What tones are met in: of sums over a span seven digits say more than any noise leaves of one."""

RIDGE, STEADY = 1e-4, 1e-2
"""Price of an amplitude's size and of its changes, against samples that say otherwise."""

BLAS_ALONE = 1 << 18
"""Size of a matrix product up to which OpenBLAS does not start threads."""

EVENT_WEIGHT = 0.01
"""Weight of an event's samples beside others, when tones are looked for."""

MARGIN = 8
"""Spans beyond a stretch that are solved with it: what is farther changes it below 1e-3."""


@dataclass(frozen=True, kw_only=True)
class Splitter:
    """Takes a signal apart into tones, slow mean and rest, stretch by stretch.

    Attributes
    ----------
    tones
        To find; those locked to one another in one fixed ratio of 1 cannot be told apart.
    rate : Hz
        Of the samples.
    span : s
        Between knots of the amplitudes: tones that differ by less than about 1/span Hz run
        together, and random vibration within that band counts as tone.
    slowest : Hz
        A tone below this is let go: it is no longer told from the slow mean.
    stretch
        Spans solved together.
    event_factor
        What stands out of the rest by this many times the rms of its louder seconds (their
        90 % quantile) is an event; infinite for none.
    event_width : s
        Kept on both sides of where the rest stands out.
    """

    tones: tuple[Tone, ...]
    rate: float
    span: float = 0.5
    slowest: float = 4.0
    stretch: int = 48
    event_factor: float = 5.0
    event_width: float = 0.4

    @property
    def samples(self) -> int:
        """Samples in a span."""
        return max(round(self.span * self.rate), 8)

    def split(self, pieces: Iterable[FloatArray]) -> Iterator[Split]:
        """Take a signal (channels, n) in pieces apart; the cuts do not matter."""
        n, reach = self.samples, MARGIN * self.samples
        size = self.stretch * n
        start, normal = 0, _Normal.none(1 + 2 * len(self.tones), n)
        for padded in overlapping(cut(_numbered(pieces), size=size), reach=reach):
            body = padded.shape[1] - 2 * reach
            split, normal = self._solve(padded[1:], padded[0], start, body, normal)
            yield split
            start += body

    def _solve(
        self, x: FloatArray, number: FloatArray, start: int, body: int, before: "_Normal"
    ) -> "tuple[Split, _Normal]":
        """Take a stretch apart, knowing what turned where the one `before` met it."""
        n, reach = self.samples, MARGIN * self.samples
        x = bridged(x)
        # Whole spans: the last stretch is filled up with samples that count for nothing.
        fill = -x.shape[1] % n
        x = np.pad(x, ((0, 0), (0, fill)), mode="edge")
        place = start - reach + np.arange(x.shape[1])
        inside = (place >= number[0]) & (place <= number[-1])
        time = place / self.rate
        spans = x.shape[1] // n
        weight = inside.astype(Sum).reshape(spans, n)
        normal = self._normal(start - reach, weight, before)
        fitted, coefficients = _fit(x, normal)
        event = np.zeros_like(x)
        if np.isfinite(self.event_factor):
            event = self._events(x - fitted.sum(1, dtype=float), inside)
            if event.any():
                # Again with the events nearly silent, so that a blow is not spread into tones.
                quiet = np.where(event.max(0) < 0.5, Sum(1), Sum(EVENT_WEIGHT)).reshape(spans, n)
                fitted, coefficients = _fit(x, normal.weighed(weight * quiet))
                event = self._events(x - fitted.sum(1, dtype=float), inside)
        rest = np.where(inside, x - fitted.sum(1, dtype=float), 0.0)
        middle = time.reshape(spans, n)[:, n // 2]
        keep = slice(reach, reach + body)
        held = (middle >= time[reach]) & (middle < time[reach] + body / self.rate)
        at_middle = np.einsum("a,cpja->cpj", _basis(1)[:, 0], coefficients)
        amplitude = at_middle[:, 1::2] - 1j * at_middle[:, 2::2]
        frequency = np.stack([t.frequency(middle) for t in self.tones]) if self.tones else (
            np.empty((0, spans))
        )  # fmt: skip
        amplitude = np.where(frequency >= self.slowest, amplitude, 0)
        split = Split(
            start=start, signal=x[:, keep], slow=fitted[:, 0, keep], tones=fitted[:, 1:, keep],
            amplitude=amplitude[..., held], time=middle[held], frequency=frequency[:, held],
            padded_rest=rest, padded_event=event, margin=reach,
        )  # fmt: skip
        return split, normal

    def _normal(self, first: int, weight: "Sums", before: "_Normal") -> "_Normal":
        """Return what turns in spans (spans, n) from a sample on, their samples weighed."""
        met = before.since(first)
        known = len(met.weight)
        met = met.weighed(weight[:known])
        rows = self._rows(first + known * self.samples, len(weight) - known)
        return _Normal(
            first, np.concatenate([met.rows, rows]), weight,
            np.concatenate([met.gram, _gram(rows, weight[known:])]),
        )  # fmt: skip

    def _rows(self, first: int, spans: int) -> "Sums":
        """One for the slow mean, cosine and sine for each tone, (spans, 1 + 2 tones, n)."""
        time = (first + np.arange(spans * self.samples)) / self.rate
        rows = np.ones((spans, 1 + 2 * len(self.tones), self.samples), Sum)
        met = {id(t.rotation): t.rotation for t in self.tones}
        known = {name: (of.at(time), of.speed(time)) for name, of in met.items()}
        for k, tone in enumerate(self.tones):
            made, speed = known[id(tone.rotation)]
            turning = wave(tone.order * made)
            # Let a tone in smoothly over a quarter above the slowest frequency.
            risen = (tone.order * speed / self.slowest - 1) * 4
            if (risen < 1).any():
                gate = np.clip(risen, 0, 1)
                turning *= gate * gate * (3 - 2 * gate)
            turning = turning.reshape(spans, -1)
            rows[:, 2 * k + 1], rows[:, 2 * k + 2] = turning.real, turning.imag
        return rows

    def _events(self, rest: FloatArray, inside: BoolArray) -> FloatArray:
        """Weight (channels, n) of the event windows in a rest, 0 to 1 with soft edges."""
        # The louder seconds set the scale, so that driving off is no event beside standing.
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
class _Normal:
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
    rows: Sums
    weight: Sums
    gram: Sums

    @classmethod
    def none(cls, p: int, n: int) -> "_Normal":
        """Return that of no spans."""
        return cls(
            0, np.empty((0, p, n), Sum), np.empty((0, n), Sum), np.empty((0, 4 * p, 4 * p), Sum)
        )  # fmt: skip

    def since(self, first: int) -> "_Normal":
        """Return those from a sample on."""
        k = (first - self.first) // self.rows.shape[-1]
        return _Normal(first, self.rows[k:], self.weight[k:], self.gram[k:])

    def weighed(self, weight: Sums) -> "_Normal":
        """Return them otherwise weighed: only spans in which that is so are summed again."""
        other = (weight != self.weight).any(-1)
        gram = self.gram.copy()
        gram[other] = _gram(self.rows[other], weight[other])
        return replace(self, weight=weight, gram=gram)


def _gram(rows: Sums, weight: Sums) -> Sums:
    """Return what `_Normal.gram` is, of rows (spans, p, n) with weights (spans, n)."""
    spans, p, n = rows.shape
    weighted = rows * weight[:, None]
    # What two splines make is alike in all spans, and what two rows make either way round.
    powers, both = _pairs(n)
    low = [_products(weighted[:, k : k + 1] * rows[:, : k + 1], powers) for k in range(p)]
    one, other = np.tril_indices(p)
    pairs = (np.concatenate(low, axis=1) @ both.T).reshape(spans, one.size, 4, 4).swapaxes(0, 1)
    gram = np.empty((spans, 4, p, 4, p), Sum)
    gram[:, :, other, :, one] = pairs
    gram[:, :, one, :, other] = pairs
    return gram.reshape(spans, 4 * p, 4 * p)


def _fit(x: FloatArray, normal: _Normal) -> tuple[Sums, FloatArray]:
    """Parts (channels, 1 + tones, n) of x, and spline coefficients (c, p, spans, 4)."""
    from scipy.linalg import solveh_banded

    rows, gram = normal.rows, normal.gram
    spans, p, n = rows.shape
    channels = x.shape[0]
    basis = _basis(n).astype(Sum)
    target = (x.astype(Sum).reshape(channels, spans, n) * normal.weight)[:, :, None]
    right = np.stack([_products(rows * each, basis) for each in target], axis=-1)
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
    ridge = np.full(size, RIDGE * n)
    ridge[::p] = 0.0
    banded[0] += ridge + 1e-9 * n
    banded[0, :-p] += STEADY * n
    banded[0, p:] += STEADY * n
    banded[p, :-p] -= STEADY * n
    c = solveh_banded(banded, total, lower=True, check_finite=False)
    c = c.reshape(spans + 3, p, channels)
    local = np.stack([c[k : k + spans].T for k in range(4)], axis=-1)  # (ch, p, spans, 4)
    each = local.astype(Sum) @ basis
    each *= rows.swapaxes(0, 1)
    each = each.reshape(channels, p, -1)
    parts = np.concatenate([each[:, :1], each[:, 1::2] + each[:, 2::2]], axis=1)
    return parts, local


def _products(a: Sums, b: Sums) -> Sums:
    """Return Σ a b over samples of each two rows of (spans, i, n) and (j, n), (spans, i, j).

    In slices too small for BLAS to start threads on: on a busy machine they cost thirty times
    the work.
    """
    n = b.shape[-1]
    flat, size = a.reshape(-1, n), max(BLAS_ALONE // b.size, 1)
    parts = [flat[k : k + size] @ b.T for k in range(0, max(len(flat), 1), size)]
    return np.concatenate(parts).reshape(*a.shape[:-1], len(b))


def _numbered(pieces: Iterable[FloatArray]) -> Iterator[FloatArray]:
    """Put the place of each sample in front of the channels: padding repeats it."""
    start = 0
    for piece in pieces:
        n = piece.shape[1]
        yield np.concatenate([np.arange(start, start + n, dtype=float)[None], piece])
        start += n
