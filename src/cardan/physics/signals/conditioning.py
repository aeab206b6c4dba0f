"""Says what a channel is like, and conditions it reversibly: by rule, and nothing unasked.

What is suspicious is found and kept by place (`fault`); only what a rule masks becomes a
hole. Filters are symmetric, so they shift nothing in time, and every operation reaches a
known number of samples, so a long recording is worked on in overlapping pieces with the
same result as whole (`overlapping_pieces`).
"""

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial

import numpy as np

from cardan.core.arrays import FloatArray, IntArray
from cardan.core.errors import DesignError
from cardan.core.finding import Finding
from cardan.physics.signals.faults.clipped_peaks import reconstruct_clipped_peaks
from cardan.physics.signals.faults.detector import ComparisonDetector, FaultDetector
from cardan.physics.signals.faults.fault_kind import (
    ChannelStatistics,
    SignalBlock,
    WholeChannelFault,
)
from cardan.physics.signals.faults.intervals import NO_FAULTS, FaultIntervals, samples_in_runs
from cardan.physics.signals.faults.registry import CORRECTABLE_FAULTS, FAULTS_OF_ANY_CHANNEL
from cardan.physics.signals.faults.waveform import (
    FAULT_CLIP,
    FAULT_FREEZE,
    FAULT_MISSING_SAMPLES,
    FAULT_SPIKE,
    detector_overlap_samples,
)
from cardan.physics.signals.faults.whole_channel import FAULT_DRIFT
from cardan.physics.signals.faults.zero_step import (
    FAULT_ZERO_SHIFT,
    cumulative_offset_of_zero_steps,
)
from cardan.physics.signals.recording import as_float_samples


def overlapping_pieces(
    pieces: Iterable[FloatArray], *, reach: int, mirrored: bool = False
) -> Iterator[FloatArray]:
    """Yield each piece (..., n) with `reach` samples of its neighbours on both sides.

    The two ends of the recording are continued level, or mirrored as far as the first and
    the last piece go. What comes out is (..., n + 2 reach): an operation that looks no farther
    than `reach`, cut back by it, is exact.
    """
    before: FloatArray | None = None
    held: FloatArray | None = None

    def beyond(body: FloatArray) -> FloatArray:
        """Return samples before the first one, walking away from it."""
        if not mirrored:
            return np.repeat(body[..., :1], reach, axis=-1)
        seen = body[..., 1 : reach + 1] if body.shape[-1] > 1 else body
        more = reach - seen.shape[-1]
        return np.concatenate([seen, np.repeat(seen[..., -1:], more, axis=-1)], axis=-1)

    def ready(body: FloatArray, after: FloatArray) -> FloatArray:
        assert before is not None
        return np.concatenate([before, body, after], axis=-1)

    for piece in pieces:
        if not piece.shape[-1]:
            continue
        if held is None:
            held = piece
            continue
        if held.shape[-1] < reach or piece.shape[-1] < reach:
            # Too short to lend a whole margin: wait for more.
            held = np.concatenate([held, piece], axis=-1)
            continue
        before = beyond(held)[..., ::-1] if before is None else before
        yield ready(held, piece[..., :reach])
        before = held[..., held.shape[-1] - reach :].copy()  # a view would hold all of it
        held = piece
    if held is not None:
        before = beyond(held)[..., ::-1] if before is None else before
        yield ready(held, beyond(held[..., ::-1]))


def interpolate_gaps(x: FloatArray) -> FloatArray:
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
class ZeroPhaseFilter:
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

    def apply(self, padded: FloatArray) -> FloatArray:
        """Filter samples (..., n + 2 reach); returns (..., n), nan where nan came in."""
        from scipy.signal import oaconvolve

        missing = np.isnan(padded[..., self.reach : padded.shape[-1] - self.reach])
        taps = self.taps.reshape((1,) * (padded.ndim - 1) + (-1,))
        out = oaconvolve(interpolate_gaps(padded), taps, mode="valid", axes=-1)
        return np.where(missing, np.nan, out) if missing.any() else out

    def __call__(self, pieces: Iterable[FloatArray]) -> Iterator[FloatArray]:
        """Filter a signal in pieces; the cuts do not matter."""
        return map(self.apply, overlapping_pieces(pieces, reach=self.reach))


def low_pass(cutoff: float, *, rate: float, width: float | None = None) -> ZeroPhaseFilter:
    """Filter that keeps what is slower than `cutoff` Hz.

    Passes within 0.1 ‰ below `cutoff - width/2`, stops by 80 dB above `cutoff + width/2`; a
    width of a quarter of the cutoff unless given. Windowed ideal filter; source: Kaiser,
    Proc. IEEE Int. Symp. Circuits and Systems (1974).
    """
    check_cutoff(cutoff, rate=rate)
    width = cutoff / 4 if width is None else width
    # Kaiser: β for 80 dB, and the length that gives the width.
    reach = int(np.ceil((80 - 7.95) / 14.36 * rate / width / 2))
    n = np.arange(-reach, reach + 1)
    taps = np.sinc(2 * cutoff / rate * n) * np.kaiser(n.size, 0.1102 * (80 - 8.7))
    return ZeroPhaseFilter(taps / taps.sum())


def check_cutoff(cutoff: float, *, rate: float) -> None:
    """Refuse a cutoff, Hz, that samples at a rate do not have."""
    if not 0 < cutoff < rate / 2:
        msg = f"a filter's cutoff must lie within (0, {rate / 2:g}) Hz, got {cutoff:g} Hz"
        raise DesignError(msg)


@dataclass(frozen=True, kw_only=True)
class ChannelReport:
    """What the survey of one channel found.

    Attributes
    ----------
    samples, missing
        Samples in all, and how many of them are nan.
    low, high, mean, deviation
        Over the samples there, in the channel's unit.
    typical_swing
        How far it usually swings: the median over the spans of what half of a span stays within.
    faults
        Where it looks wrong, by kind.
    crest_loss
        What its higher crests lose between samples, relative: by parabolas through them.
    levels : (spans,)
        Median of each span, which shows zero and drift.
    span : samples
        Length of a span.
    whole_channel_faults
        Of the channel as a whole, by kind.
    bend_share
        Share of the samples, where it moves, at which it does not go straight on: 1 of what was
        measured at each, a twentieth where one in twenty was and lines go between.
    """

    samples: int
    missing: int
    low: float
    high: float
    mean: float
    deviation: float
    typical_swing: float
    faults: Mapping[str, FaultIntervals] = field(repr=False)
    crest_loss: float
    levels: FloatArray
    span: int
    whole_channel_faults: Mapping[str, WholeChannelFault] = field(
        default_factory=dict[str, WholeChannelFault], repr=False
    )
    bend_share: float = 1.0

    def faults_of(self, kind: str) -> FaultIntervals:
        """Return where one kind of fault is."""
        return self.faults.get(kind, NO_FAULTS)

    def whole_channel_size(self, kind: str) -> float:
        """Return how large a fault of the whole channel is; 0 without."""
        return self.whole_channel_faults[kind].size if kind in self.whole_channel_faults else 0.0

    @property
    def spikes(self) -> int:
        """Samples that are spikes."""
        return self.faults_of(FAULT_SPIKE).sample_count

    @property
    def clipped(self) -> int:
        """Samples of crests cut off."""
        return self.faults_of(FAULT_CLIP).sample_count

    @property
    def longest_hole(self) -> int:
        """Samples of the longest run of missing ones."""
        return _longest_run_samples(self.faults_of(FAULT_MISSING_SAMPLES))

    @property
    def longest_flat(self) -> int:
        """Samples of the longest freeze."""
        return _longest_run_samples(self.faults_of(FAULT_FREEZE))

    @property
    def dead(self) -> bool:
        """Whether the channel says nothing: no samples, or one value throughout."""
        return self.samples == self.missing or self.low == self.high

    @property
    def zero_offsets(self) -> FloatArray:
        """What steps of the zero have added up to in the middle of each span, (spans,)."""
        middle = (np.arange(self.levels.size) + 0.5) * self.span
        return cumulative_offset_of_zero_steps(self.faults_of(FAULT_ZERO_SHIFT), middle)

    @property
    def drift(self) -> float:
        """Change of level from the first tenth of the spans to the last tenth, steps apart."""
        levels = self.levels - self.zero_offsets
        known = levels[~np.isnan(levels)]
        if not known.size:
            return 0.0
        tenth = max(known.size // 10, 1)
        return float(np.median(known[-tenth:]) - np.median(known[:tenth]))

    @property
    def drifts(self) -> bool:
        """Whether it creeps by more than it swings: a load is high now and then, and no creep."""
        if self.dead or not abs(self.drift) > max(self.deviation, 1e-300):
            return False
        levels = (self.levels - self.zero_offsets)[~np.isnan(self.levels)]
        place = np.arange(levels.size) - (levels.size - 1) / 2
        along = float(place @ (levels - levels.mean()))
        return along**2 > MIN_DRIFT_VARIANCE_SHARE * float(place @ place) * levels.size * float(
            levels.var()
        )

    def without_gauge_faults(self) -> "ChannelReport":
        """Return it without what only a gauge can show: a speed stands, creeps and jumps."""
        here = {kind: where for kind, where in self.faults.items() if kind in FAULTS_OF_ANY_CHANNEL}
        return replace(self, faults=here, levels=self.levels[:0], whole_channel_faults={})

    def findings(self, *, rate: float, unit: str = "") -> list[Finding]:
        """Return what a user should know; empty if all is well.

        `unit` is the channel's, "" if not given.
        """
        if self.dead:
            return [FINDING_DEAD]
        found: list[Finding] = []
        if self.missing:
            found.append(
                Finding(FAULT_MISSING_SAMPLES).with_values(
                    missing=self.missing, samples=self.samples, longest=self.longest_hole / rate
                )
            )
        found += [
            Finding(kind).with_values(
                samples=where.sample_count, places=where.count, first=where.runs[0, 0] / rate
            )
            for kind, where in self.faults.items()
            if kind != FAULT_MISSING_SAMPLES
        ]
        if self.drifts:
            found.append(Finding(FAULT_DRIFT).with_values(drift=self.drift, unit=unit))
        found += [
            Finding(kind).with_values(size=fault.size, unit=unit, **fault.details)
            for kind, fault in self.whole_channel_faults.items()
            if kind in CORRECTABLE_FAULTS
        ]
        return found


FINDING_DEAD = Finding("dead")


def _longest_run_samples(where: FaultIntervals) -> int:
    return int((where.runs[:, 1] - where.runs[:, 0]).max(initial=0))


def row_medians(rows: FloatArray) -> FloatArray:
    """Return the median (k,) of each row (k, n), nan left out of account; nan where all is.

    As NumPy's, which sorts out both middle values at once and so takes eight times as long.
    """
    if (missing := np.isnan(rows)).any():
        found = np.full(len(rows), np.nan)
        some = ~missing.all(-1)
        found[some] = np.nanmedian(rows[some], axis=-1)
        return found
    half = rows.shape[-1] // 2
    parted = np.partition(rows, half, axis=-1)
    upper = parted[:, half]
    return upper if rows.shape[-1] % 2 else (parted[:, :half].max(-1) + upper) / 2


MIN_DRIFT_VARIANCE_SHARE = 0.5
"""Share of what its levels vary by that goes with the time, from which a channel creeps."""
MAX_SAMPLE_MAGNITUDE = 1e30
"""Size from which a sample is no number of a sensor: its powers are no numbers of a computer."""


INTERPOLATION_CHECK_SAMPLES = 4096
"""Samples of a piece by which interpolated samples are detected."""


class _ChannelSurvey:
    """One channel's findings as its pieces pass."""

    def __init__(self, span: int, rate: float, name: str) -> None:
        self.span, self.rate, self.name, self.reach = (
            span,
            rate,
            name,
            detector_overlap_samples(rate),
        )
        self.detector = FaultDetector(rate)
        self.samples = self.missing = 0
        self.low, self.high = np.inf, -np.inf
        self.total = self.squares = self.shift = 0.0
        self.levels: list[FloatArray] = []
        self.swings: list[FloatArray] = []
        self.tail: FloatArray = np.empty(0)
        self.crests, self.losses = 0.0, 0.0
        self.moving = self.bent = 0

    def update(self, padded: FloatArray) -> None:
        x = padded[self.reach : padded.size - self.reach]
        missing = np.isnan(x)
        known = x[~missing] if missing.any() else x
        # Not before it: that is a mirror's, or of a piece that was looked at.
        ahead = padded[self.reach :]
        if np.fmax(np.fmax.reduce(ahead), -np.fmin.reduce(ahead)) >= MAX_SAMPLE_MAGNITUDE:
            where = int(np.argmax(np.abs(ahead) >= MAX_SAMPLE_MAGNITUDE))
            place = self.samples + where
            msg = (
                f"samples must be finite or missing (nan), got {ahead[where]:g} at sample "
                f"{place + 1}, {place / self.rate:.6g} s"
            )
            raise DesignError(f"{self.name}: {msg}" if self.name else msg)
        filled = interpolate_gaps(padded)
        self.detector.update(SignalBlock(padded, filled, self.reach, self.samples))
        self.samples += x.size
        self.missing += x.size - known.size
        self._levels(x)
        if not known.size:
            return
        if self.samples - self.missing == known.size:
            self.shift = float(known[0])
        centred = known - self.shift
        self.total += float(centred.sum())
        self.squares += float(np.square(centred).sum())
        self.low, self.high = min(self.low, float(known.min())), max(self.high, float(known.max()))
        self._update_bends(x[:INTERPOLATION_CHECK_SAMPLES])
        self._update_crest_loss(filled[self.reach - 1 : filled.size - self.reach + 1])

    def _update_crest_loss(self, x: FloatArray) -> None:
        """Enter what crests lose between samples, the fifth power of their height their weight."""
        before, at, behind = x[:-2], x[1:-1], x[2:]
        crest = np.flatnonzero((at - before) * (at - behind) > 0)
        height = np.abs(at[crest] - row_medians(x[None])[0])
        tall = height > 0.5 * height.max(initial=0.0)
        height, crest = height[tall], crest[tall]
        y, a, b = at[crest], before[crest], behind[crest]
        lost = (a - b) ** 2 / (8 * np.abs(2 * y - a - b))
        self.crests += float((height**5).sum())
        self.losses += float((height**4 * lost).sum())

    def _update_bends(self, x: FloatArray) -> None:
        """Enter how often samples (n,) go straight on while they move, but for rounding."""
        step = np.diff(x)
        rounding = 1e-6 * float(np.fmax.reduce(np.abs(step), initial=0.0))
        moves = (np.abs(step) > 10 * rounding)[1:]
        self.moving += int(np.count_nonzero(moves))
        self.bent += int(np.count_nonzero(moves & (np.abs(np.diff(step)) > rounding)))

    def _levels(self, x: FloatArray, *, last: bool = False) -> None:
        whole = np.concatenate([self.tail, x])
        full = whole.size if last else whole.size // self.span * self.span
        if full:
            rows = whole[:full].reshape(-1, full if last else self.span)
            level = row_medians(rows)
            swing = row_medians(np.abs(rows - level[:, None]))
            if not last:
                self.levels.append(level)
            self.swings.append(swing)
        self.tail = whole[full:]

    def result(self, *, compared: Mapping[str, FaultIntervals]) -> ChannelReport:
        """Return what was found, with what a comparison with other channels says."""
        known = self.samples - self.missing
        mean = self.total / known if known else np.nan
        variance = self.squares / known - mean**2 if known else np.nan
        deviation = float(np.sqrt(max(variance, 0.0)))
        if not self.swings:  # shorter than a span
            self._levels(np.empty(0), last=True)
        swings = np.concatenate(self.swings or [np.empty(0)])
        moving = swings[swings > 0]
        typical = float(np.median(moving)) if moving.size else 0.0
        levels = np.concatenate(self.levels or [np.empty(0)])
        faults = self.detector.result(
            ChannelStatistics(
                alive=self.high > self.low, deviation=deviation, typical_swing=typical,
                levels=levels, swings=swings, span=self.span,
            ),
            compared=compared,
        )  # fmt: skip
        return ChannelReport(
            samples=self.samples,
            missing=self.missing,
            low=self.low,
            high=self.high,
            mean=mean + self.shift,
            deviation=deviation,
            typical_swing=typical,
            faults=faults.intervals,
            crest_loss=self.losses / self.crests if self.crests > 0 else 0.0,
            levels=levels,
            span=self.span,
            whole_channel_faults=faults.whole_channel,
            bend_share=self.bent / self.moving if self.moving else 1.0,
        )


def survey_channel_signals(
    pieces: Iterable[FloatArray], *, rate: float, span: float = 10.0, names: Sequence[str] = ()
) -> list[ChannelReport]:
    """Look through a recording once and say what each channel is like.

    Parameters
    ----------
    pieces : (channels, n)
        The recording, nan where samples are missing.
    rate : Hz
        Of its samples.
    span : s
        Of the medians that show zero and drift.
    names
        Of the channels, for messages.
    """
    found: list[_ChannelSurvey] = []
    comparison: ComparisonDetector | None = None
    reach = detector_overlap_samples(rate)
    for padded in overlapping_pieces(map(as_float_samples, pieces), reach=reach, mirrored=True):
        if comparison is None:
            called = names or [""] * len(padded)
            found = [_ChannelSurvey(max(round(span * rate), 1), rate, name) for name in called]
            comparison = ComparisonDetector(rate, len(padded))
        for channel, x in zip(found, padded, strict=True):
            channel.update(x)
        comparison.update(interpolate_gaps(padded[:, reach : padded.shape[-1] - reach]))
    if comparison is None:
        return []
    compared = comparison.result()
    del comparison
    # Of a day's channel the findings are twenty megabytes: each is released once it is reported.
    return [found.pop(0).result(compared=of) for of in compared]


@dataclass(frozen=True, kw_only=True)
class Conditioning:
    """What is done to a channel; nothing, unless said.

    Attributes
    ----------
    masked : (k, 2) samples
        Runs made holes of, apart and in order.
    crowned
        Clipped crests put back by parabolas: for an estimate, never for a verdict.
    corrections
        Take faults off samples (n,) from a place on, one after the other.
    baseline : (spans,)
        Taken off, a level for the middle of each span, straight between; none where empty.
    span : samples
        Of the baseline.
    """

    masked: IntArray = field(default_factory=lambda: NO_FAULTS.runs)
    crowned: FaultIntervals = NO_FAULTS
    corrections: tuple[Callable[[FloatArray, int], FloatArray], ...] = ()
    baseline: FloatArray = field(default_factory=lambda: np.empty(0))
    span: int = 1

    def __call__(self, x: FloatArray, start: int) -> FloatArray:
        """Return samples (n,) from `start` on, treated; the same ones where there is nothing."""
        if self.crowned.count:
            x = reconstruct_clipped_peaks(x, self.crowned, start)
        hidden = samples_in_runs(self.masked, start, x.size) if len(self.masked) else None
        if hidden is not None and hidden.any():
            x = np.where(hidden, np.nan, x)
        for correct in self.corrections:
            x = correct(x, start)
        if self.baseline.any():
            middle = (np.arange(self.baseline.size) + 0.5) * self.span
            x = x - np.interp(np.arange(start, start + x.size), middle, self.baseline)
        return x


def condition_pieces(
    pieces: Iterable[FloatArray], *, how: Sequence[Sequence[Conditioning]]
) -> Iterator[Iterator[FloatArray]]:
    """Yield each piece of a recording treated in some ways, one after the other, (channels, n).

    `how` holds a treatment for each channel in each way; holes stay holes.
    """
    start = 0
    for piece in pieces:
        yield map(partial(_condition_piece, piece, start), how)
        start += piece.shape[-1]


def _condition_piece(piece: FloatArray, start: int, way: Sequence[Conditioning]) -> FloatArray:
    """Return a piece (channels, n) that begins at a sample, treated in one way."""
    return np.stack([treat(x, start) for treat, x in zip(way, piece, strict=True)])


UPSAMPLING_FACTOR = 8
"""Samples made of one where crests fall between samples."""


def upsample(
    pieces: Iterable[FloatArray], *, times: int = UPSAMPLING_FACTOR
) -> Iterator[FloatArray]:
    """Yield a signal (..., n) with `times` as many samples: its crests between samples.

    The band-limited signal through the samples; what is faster than 0.4 of their rate is
    damped, what is faster than half of it was never in them. Source: Shannon, Proc. IRE 37
    (1949), with the window of `low_pass`.
    """
    taps = low_pass(0.45, rate=times, width=0.1).taps * times
    about = -(-(taps.size // 2) // times)
    for padded in overlapping_pieces(pieces, reach=about):
        from scipy.signal import upfirdn  # fifty megabytes: not of nothing

        n = padded.shape[-1] - 2 * about
        missing = np.isnan(padded[..., about : about + n])
        out = upfirdn(taps, interpolate_gaps(padded), up=times, axis=-1)
        first = about * times + taps.size // 2
        out = out[..., first : first + n * times]
        if missing.any():
            out = np.where(np.repeat(missing, times, axis=-1), np.nan, out)
        yield out


def no_baseline(health: ChannelReport) -> FloatArray:
    """Baseline that takes nothing off."""
    return np.zeros_like(health.levels)


def baseline_at_start(health: ChannelReport) -> FloatArray:
    """Baseline at the level of the first span: the vehicle stood unloaded there."""
    known = health.levels[~np.isnan(health.levels)]
    return np.full_like(health.levels, known[0] if known.size else 0.0)


def baseline_at_median(health: ChannelReport) -> FloatArray:
    """Baseline at the median of all spans: the mean stress is unknown and taken as zero."""
    known = health.levels[~np.isnan(health.levels)]
    return np.full_like(health.levels, float(np.median(known)) if known.size else 0.0)


def running_median_baseline(health: ChannelReport, *, spans: int = 61) -> FloatArray:
    """Baseline of the running median over `spans` spans: ten minutes, if a span is ten seconds.

    Takes off what creeps, and any load held that long with it; holes take their neighbours'.
    """
    levels = interpolate_gaps(health.levels)
    half = min(spans, max(levels.size - 1, 0)) // 2
    padded = np.pad(levels, half, mode="edge")
    window = np.lib.stride_tricks.sliding_window_view(padded, 2 * half + 1)
    return np.median(window, axis=-1)
