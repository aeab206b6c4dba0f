"""Finds what is wrong with a channel, and mends what can be mended without moving it.

Everything mended is counted and said. Filters are symmetric, so they shift nothing in
time, and every operation reaches a known number of samples, so a long recording is worked
on in overlapping pieces with the same result as whole (`overlapping`).
"""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from cardan.base.arrays import FloatArray
from cardan.base.errors import DesignError

CLIPPED_RUN = 4
"""Samples in a row at the very top or bottom of a channel that look cut off."""


def overlapping(pieces: Iterable[FloatArray], *, reach: int) -> Iterator[FloatArray]:
    """Yield each piece (..., n) with `reach` samples of its neighbours on both sides.

    The two ends of the recording are continued level. What comes out is (..., n + 2 reach):
    an operation that looks no farther than `reach`, cut back by it, is exact.
    """
    before: FloatArray | None = None
    held: FloatArray | None = None

    def ready(body: FloatArray, after: FloatArray) -> FloatArray:
        assert before is not None
        return np.concatenate([before, body, after], axis=-1)

    for piece in pieces:
        if not piece.shape[-1]:
            continue
        if held is None:
            before = np.repeat(piece[..., :1], reach, axis=-1)
            held = piece
            continue
        if held.shape[-1] < reach or piece.shape[-1] < reach:
            # Too short to lend a whole margin: wait for more.
            held = np.concatenate([held, piece], axis=-1)
            continue
        assert before is not None
        yield ready(held, piece[..., :reach])
        before = np.concatenate([before, held], axis=-1)[..., held.shape[-1] :]
        held = piece
    if held is not None:
        yield ready(held, np.repeat(held[..., -1:], reach, axis=-1))


def bridged(x: FloatArray) -> FloatArray:
    """Return x (..., n) with holes (nan) bridged by straight lines, level at the ends."""
    missing = np.isnan(x)
    if not missing.any():
        return x
    out = x.copy().reshape(-1, x.shape[-1])
    place = np.arange(x.shape[-1])
    for row, hole in zip(out, missing.reshape(out.shape), strict=True):
        row[hole] = np.interp(place[hole], place[~hole], row[~hole]) if (~hole).any() else 0.0
    return out.reshape(x.shape)


@dataclass(frozen=True)
class Filter:
    """A symmetric filter: no phase, a reach known in samples.

    Attributes
    ----------
    taps : (2 reach + 1,) 1
        Impulse response.
    """

    taps: FloatArray

    @property
    def reach(self) -> int:
        """Samples it looks to either side."""
        return self.taps.size // 2

    def centred(self, padded: FloatArray) -> FloatArray:
        """Filter samples (..., n + 2 reach); returns (..., n), nan where nan came in."""
        from scipy.signal import oaconvolve

        missing = np.isnan(padded[..., self.reach : padded.shape[-1] - self.reach])
        taps = self.taps.reshape((1,) * (padded.ndim - 1) + (-1,))
        out = oaconvolve(bridged(padded), taps, mode="valid", axes=-1)
        return np.where(missing, np.nan, out) if missing.any() else out

    def __call__(self, pieces: Iterable[FloatArray]) -> Iterator[FloatArray]:
        """Filter a signal in pieces; the cuts do not matter."""
        return map(self.centred, overlapping(pieces, reach=self.reach))


def low_pass(cutoff: float, *, rate: float, width: float | None = None) -> Filter:
    """Filter that keeps what is slower than `cutoff` Hz.

    Passes within 0.1 ‰ below `cutoff - width/2`, stops by 80 dB above `cutoff + width/2`; a
    width of a quarter of the cutoff unless given. Windowed ideal filter; source: Kaiser,
    Proc. IEEE Int. Symp. Circuits and Systems (1974).
    """
    width = cutoff / 4 if width is None else width
    if not 0 < cutoff < rate / 2:
        msg = f"a filter's cutoff must lie within (0, {rate / 2:g}) Hz, got {cutoff:g} Hz"
        raise DesignError(msg)
    # Kaiser: β for 80 dB, and the length that gives the width.
    reach = int(np.ceil((80 - 7.95) / 14.36 * rate / width / 2))
    n = np.arange(-reach, reach + 1)
    taps = np.sinc(2 * cutoff / rate * n) * np.kaiser(n.size, 0.1102 * (80 - 8.7))
    return Filter(taps / taps.sum())


def high_pass(cutoff: float, *, rate: float, width: float | None = None) -> Filter:
    """Filter that keeps what is faster than `cutoff` Hz: all less the low pass."""
    taps = -low_pass(cutoff, rate=rate, width=width).taps
    taps[taps.size // 2] += 1
    return Filter(taps)


def band_pass(low: float, high: float, *, rate: float) -> Filter:
    """Filter that keeps what lies between two frequencies, Hz."""
    if not low < high:
        msg = f"a band must rise, got {low:g} to {high:g} Hz"
        raise ValueError(msg)
    wide, narrow = low_pass(high, rate=rate).taps, low_pass(low, rate=rate).taps
    taps = -narrow
    start = narrow.size // 2 - wide.size // 2
    taps[start : start + wide.size] += wide
    return Filter(taps)


SPIKE_REACH = 3
"""Samples to either side that decide whether one is a spike; also a spike's longest width."""


def _standing_out(around: FloatArray) -> FloatArray:
    """Distance (n,) of the middle of seven samples (n, 7) from their median.

    Zero unless it is more than twice what the tightest four of the seven span: no
    band-limited signal comes and goes so fast.
    """
    ranked = np.sort(around, axis=-1)
    off = np.abs(around[:, SPIKE_REACH] - ranked[:, SPIKE_REACH])
    quiet = (ranked[:, 3:] - ranked[:, :-3]).min(-1)
    return np.where(off > 2 * quiet, off, 0.0)


def spikes(padded: FloatArray, *, limit: FloatArray | float) -> tuple[Any, FloatArray]:
    """Spikes of one to three samples in (n + 6,): their places (k,) and how far they stand out.

    A spike rises and falls again within three samples, stands farther than `limit` from the
    median of the seven about it, and farther than twice what the quietest four span.
    """
    x = bridged(padded)
    middle, reach = x[SPIKE_REACH:-SPIKE_REACH], 2 * SPIKE_REACH
    left, right = middle - x[:-reach], middle - x[reach:]
    # Outside a spike both third neighbours lie well off on one side: few samples pass.
    sharp = (left * right > 0) & (np.minimum(np.abs(left), np.abs(right)) > limit / 2)
    place = np.flatnonzero(sharp & ~np.isnan(padded[SPIKE_REACH:-SPIKE_REACH]))
    off = _standing_out(np.lib.stride_tricks.sliding_window_view(x, reach + 1)[place])
    return place[off > limit], off[off > limit]


def _roughness(padded: FloatArray) -> float:
    """Typical distance of a sample from the median of the seven about it."""
    around = np.lib.stride_tricks.sliding_window_view(bridged(padded), 2 * SPIKE_REACH + 1)[::16]
    off = np.abs(around[:, SPIKE_REACH] - np.median(around, axis=-1))
    return max(1.4826 * float(np.median(off)), float(off.mean()))


@dataclass(frozen=True, kw_only=True)
class Health:
    """What the survey of one channel found.

    Attributes
    ----------
    samples, missing
        Samples in all, and how many of them are nan.
    longest_hole : samples
        Longest run of missing samples.
    low, high, mean, deviation
        Over the samples there, in the channel's unit.
    clipped
        Samples in runs of at least four at the channel's very top or bottom.
    longest_flat : samples
        Longest run of one value.
    spikes
        Samples that `spikes` finds at `spike_limit`.
    spike_limit
        Distance from the neighbours' median that makes a spike.
    levels : (spans,)
        Median of each span, which shows zero and drift.
    span : samples
        Length of a span.
    """

    samples: int
    missing: int
    longest_hole: int
    low: float
    high: float
    mean: float
    deviation: float
    clipped: int
    longest_flat: int
    spikes: int
    spike_limit: float
    levels: FloatArray
    span: int

    @property
    def dead(self) -> bool:
        """Whether the channel says nothing: no samples, or one value throughout."""
        return self.samples == self.missing or self.low == self.high

    @property
    def drift(self) -> float:
        """Change of level from the first tenth of the spans to the last tenth."""
        known = self.levels[~np.isnan(self.levels)]
        if not known.size:
            return 0.0
        tenth = max(known.size // 10, 1)
        return float(np.median(known[-tenth:]) - np.median(known[:tenth]))

    def findings(self, *, rate: float) -> list[str]:
        """Return what a user should know, a sentence each; empty if all is well."""
        said: list[str] = []
        if self.dead:
            said.append("dead: it never changes")
            return said
        if self.missing:
            said.append(
                f"{self.missing} samples missing ({self.missing / self.samples:.2%}), "
                f"longest hole {self.longest_hole / rate:.3g} s"
            )
        if self.clipped:
            said.append(f"{self.clipped} samples look clipped at {self.low:.6g} or {self.high:.6g}")
        if self.longest_flat > max(rate, 10):
            said.append(f"stands still for {self.longest_flat / rate:.3g} s")
        if self.spikes:
            said.append(f"{self.spikes} samples are spikes")
        if abs(self.drift) > max(self.deviation, 1e-300):
            said.append(f"drifts by {self.drift:.4g} from beginning to end")
        return said


def _runs(flags: Any) -> Any:
    """Lengths of the runs of True."""
    edge = np.flatnonzero(np.diff(np.concatenate([[False], flags, [False]]).astype(np.int8)))
    return edge[1::2] - edge[::2]


class _Run:
    """Runs of True through pieces, those over the cuts whole."""

    def __init__(self) -> None:
        self.longest = self.open = self.long_total = 0

    def add(self, flags: Any, *, at_least: int = 1) -> None:
        if flags.all():
            self.open += flags.size
            self.longest = max(self.longest, self.open)
            return
        first = int(np.argmin(flags))
        last = int(np.argmin(flags[::-1]))
        closed = [self.open + first, *_runs(flags[first : flags.size - last])]
        self.long_total += sum(int(r) for r in closed if r >= at_least)
        self.open = last
        self.longest = max(self.longest, self.open, *map(int, closed))

    def total(self, at_least: int) -> int:
        return self.long_total + (self.open if self.open >= at_least else 0)


class _Survey:
    """One channel's findings as its pieces pass."""

    def __init__(self, span: int, factor: float) -> None:
        self.span, self.factor = span, factor
        self.samples = self.missing = 0
        self.low, self.high = np.inf, -np.inf
        self.total = self.squares = self.shift = 0.0
        self.hole, self.flat = _Run(), _Run()
        self.top, self.bottom = _Run(), _Run()
        self.levels: list[FloatArray] = []
        self.tail: FloatArray = np.empty(0)
        self.last = np.nan
        self.rough = 0.0
        self.offs: list[FloatArray] = []

    def add(self, padded: FloatArray) -> None:
        x = padded[SPIKE_REACH:-SPIKE_REACH]
        known = x[~np.isnan(x)]
        self.samples += x.size
        self.missing += x.size - known.size
        self.hole.add(np.isnan(x))
        self.flat.add(np.diff(np.concatenate([[self.last], x])) == 0)
        self.last = float(x[-1])
        self._levels(x)
        if not known.size:
            return
        if not np.isfinite(known).all():
            msg = "samples must be finite or missing (nan), got infinity"
            raise DesignError(msg)
        if self.samples - self.missing == known.size:
            self.shift = float(known[0])
        centred = known - self.shift
        self.total += float(centred.sum())
        self.squares += float(np.square(centred).sum())
        low, high = float(known.min()), float(known.max())
        if low < self.low:
            self.low, self.bottom = low, _Run()
        if high > self.high:
            self.high, self.top = high, _Run()
        self.bottom.add(x == self.low, at_least=CLIPPED_RUN)
        self.top.add(x == self.high, at_least=CLIPPED_RUN)
        # The roughest piece sets the limit: what passes now and not then is sorted out last.
        self.rough = max(self.rough, _roughness(padded))
        if self.rough > 0:
            self.offs.append(spikes(padded, limit=self.factor * self.rough)[1])

    def _levels(self, x: FloatArray) -> None:
        whole = np.concatenate([self.tail, x])
        full = whole.size // self.span * self.span
        if full:
            rows = whole[:full].reshape(-1, self.span)
            some = ~np.isnan(rows).all(-1)
            level = np.full(len(rows), np.nan)
            level[some] = np.nanmedian(rows[some], axis=-1)
            self.levels.append(level)
        self.tail = whole[full:]

    def health(self) -> Health:
        known = self.samples - self.missing
        mean = self.total / known if known else np.nan
        variance = self.squares / known - mean**2 if known else np.nan
        alive = self.high > self.low
        limit = self.factor * self.rough if self.rough > 0 else np.inf
        return Health(
            samples=self.samples, missing=self.missing, longest_hole=self.hole.longest,
            low=self.low, high=self.high, mean=mean + self.shift,
            deviation=float(np.sqrt(max(variance, 0.0))),
            clipped=self.top.total(CLIPPED_RUN) + self.bottom.total(CLIPPED_RUN) if alive else 0,
            longest_flat=self.flat.longest + 1 if self.flat.longest else 0,
            spikes=int((np.concatenate([np.empty(0), *self.offs]) > limit).sum()),
            spike_limit=limit,
            levels=np.concatenate(self.levels or [np.empty(0)]), span=self.span,
        )  # fmt: skip


def survey(
    pieces: Iterable[FloatArray], *, rate: float, span: float = 10.0, spike_factor: float = 15.0
) -> list[Health]:
    """Look through a recording once and say what each channel is like.

    Parameters
    ----------
    pieces : (channels, n)
        The recording, nan where samples are missing.
    rate : Hz
        Of its samples.
    span : s
        Of the medians that show zero and drift.
    spike_factor
        How many typical distances from the neighbours' median make a spike, the distance
        being that of the roughest piece.
    """
    found: list[_Survey] = []
    for padded in overlapping(pieces, reach=SPIKE_REACH):
        if not found:
            found = [_Survey(max(round(span * rate), 1), spike_factor) for _ in padded]
        for channel, x in zip(found, padded, strict=True):
            channel.add(x)
    return [channel.health() for channel in found]


def mended(
    pieces: Iterable[FloatArray], *, healths: list[Health], baseline: list[FloatArray] | None = None
) -> Iterator[FloatArray]:
    """Yield the recording with spikes bridged and each channel's baseline taken off.

    `baseline` holds a level for the middle of each of a channel's spans, between which it
    runs straight; holes stay holes.
    """
    start = 0
    for padded in overlapping(pieces, reach=SPIKE_REACH):
        x = padded[:, SPIKE_REACH:-SPIKE_REACH]
        for k, health in enumerate(healths):
            place, _ = spikes(padded[k], limit=health.spike_limit)
            if place.size:
                x = x.copy()
                patched = padded[k].copy()
                patched[SPIKE_REACH + place] = np.nan
                x[k, place] = bridged(patched)[SPIKE_REACH + place]
        if baseline is not None:
            place = np.arange(start, start + x.shape[1])
            x = x - np.stack(
                [
                    np.interp(place, (np.arange(b.size) + 0.5) * h.span, b) if b.size else 0 * place
                    for b, h in zip(baseline, healths, strict=True)
                ]
            )
        start += x.shape[1]
        yield x


def no_zero(health: Health) -> FloatArray:
    """Baseline that takes nothing off."""
    return np.zeros_like(health.levels)


def zero_at_start(health: Health) -> FloatArray:
    """Baseline at the level of the first span: the vehicle stood unloaded there."""
    known = health.levels[~np.isnan(health.levels)]
    return np.full_like(health.levels, known[0] if known.size else 0.0)


def zero_at_median(health: Health) -> FloatArray:
    """Baseline at the median of all spans: the mean stress is unknown and taken as zero."""
    known = health.levels[~np.isnan(health.levels)]
    return np.full_like(health.levels, float(np.median(known)) if known.size else 0.0)


def slow_drift(health: Health, *, spans: int = 61) -> FloatArray:
    """Baseline of the running median over `spans` spans: ten minutes, if a span is ten seconds.

    Takes off what creeps, and any load held that long with it; holes take their neighbours'.
    """
    levels = bridged(health.levels)
    half = min(spans, max(levels.size - 1, 0)) // 2
    padded = np.pad(levels, half, mode="edge")
    window = np.lib.stride_tricks.sliding_window_view(padded, 2 * half + 1)
    return np.median(window, axis=-1)
