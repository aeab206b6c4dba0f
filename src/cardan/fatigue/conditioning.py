"""Says what a channel is like, and conditions it reversibly: by rule, and nothing unasked.

What is suspicious is found and kept by place (`fault`); only what a rule masks becomes a
hole. Filters are symmetric, so they shift nothing in time, and every operation reaches a
known number of samples, so a long recording is worked on in overlapping pieces with the
same result as whole (`overlapping`).
"""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial

import numpy as np

from cardan.base.arrays import ArrayLike, FloatArray, IntArray
from cardan.base.errors import DesignError
from cardan.base.said import Said, said
from cardan.fatigue.chatter import Chatter
from cardan.fatigue.fault import (
    ANYWHERE,
    CLIP,
    DROPOUT,
    FREEZE,
    GAIN,
    HOLE,
    NOISE,
    NOWHERE,
    REPEAT,
    SENTINEL,
    SPIKE,
    ZERO_STEP,
    Finder,
    Places,
    crowned,
    places,
    reach,
    union,
    within,
)
from cardan.fatigue.folded import Folded
from cardan.fatigue.gain import Ratios
from cardan.fatigue.hum import Hum, Listener
from cardan.fatigue.recording import floating
from cardan.fatigue.stuck import Codes
from cardan.fatigue.twice import Twice


def overlapping(
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
    hold_cutoff(cutoff, rate=rate)
    width = cutoff / 4 if width is None else width
    # Kaiser: β for 80 dB, and the length that gives the width.
    reach = int(np.ceil((80 - 7.95) / 14.36 * rate / width / 2))
    n = np.arange(-reach, reach + 1)
    taps = np.sinc(2 * cutoff / rate * n) * np.kaiser(n.size, 0.1102 * (80 - 8.7))
    return Filter(taps / taps.sum())


def hold_cutoff(cutoff: float, *, rate: float) -> None:
    """Refuse a cutoff, Hz, that samples at a rate do not have."""
    if not 0 < cutoff < rate / 2:
        msg = f"a filter's cutoff must lie within (0, {rate / 2:g}) Hz, got {cutoff:g} Hz"
        raise DesignError(msg)


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


@dataclass(frozen=True, kw_only=True)
class Health:
    """What the survey of one channel found.

    Attributes
    ----------
    samples, missing
        Samples in all, and how many of them are nan.
    low, high, mean, deviation
        Over the samples there, in the channel's unit.
    typical
        How far it usually swings: the median over the spans of what half of a span stays within.
    faults
        Where it looks wrong, by kind.
    short
        What its higher crests lose between samples, relative: by parabolas through them.
    levels : (spans,)
        Median of each span, which shows zero and drift.
    span : samples
        Length of a span.
    hum
        Of the mains; None without.
    bends
        Share of the samples, where it moves, at which it does not go straight on: 1 of what was
        measured at each, a twentieth where one in twenty was and lines go between.
    stuck
        What a bit of the converter is worth that stands still; 0 where all move.
    """

    samples: int
    missing: int
    low: float
    high: float
    mean: float
    deviation: float
    typical: float
    faults: Mapping[str, Places] = field(repr=False)
    short: float
    levels: FloatArray
    span: int
    hum: Hum | None = None
    bends: float = 1.0
    stuck: float = 0.0

    def at(self, kind: str) -> Places:
        """Return where one kind of fault is."""
        return self.faults.get(kind, NOWHERE)

    @property
    def spikes(self) -> int:
        """Samples that are spikes."""
        return self.at(SPIKE).samples

    @property
    def clipped(self) -> int:
        """Samples of crests cut off."""
        return self.at(CLIP).samples

    @property
    def longest_hole(self) -> int:
        """Samples of the longest run of missing ones."""
        return _longest(self.at(HOLE))

    @property
    def longest_flat(self) -> int:
        """Samples of the longest freeze."""
        return _longest(self.at(FREEZE))

    @property
    def dead(self) -> bool:
        """Whether the channel says nothing: no samples, or one value throughout."""
        return self.samples == self.missing or self.low == self.high

    @property
    def stepped(self) -> FloatArray:
        """What steps of the zero have added up to in the middle of each span, (spans,)."""
        middle = (np.arange(self.levels.size) + 0.5) * self.span
        return shifts(self.at(ZERO_STEP), middle)

    @property
    def drift(self) -> float:
        """Change of level from the first tenth of the spans to the last tenth, steps apart."""
        levels = self.levels - self.stepped
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
        levels = (self.levels - self.stepped)[~np.isnan(self.levels)]
        place = np.arange(levels.size) - (levels.size - 1) / 2
        along = float(place @ (levels - levels.mean()))
        return along**2 > CREEPS * float(place @ place) * levels.size * float(levels.var())

    def of_no_gauge(self) -> "Health":
        """Return it without what only a gauge can show: a speed stands, creeps and jumps."""
        here = {kind: where for kind, where in self.faults.items() if kind in ANYWHERE}
        return replace(self, faults=here, levels=self.levels[:0], hum=None, stuck=0.0)

    def findings(self, *, rate: float, unit: str = "") -> list[Said]:
        """Return what a user should know, a sentence each; empty if all is well.

        `unit` is the channel's, "" where nobody says.
        """
        if self.dead:
            return [said(DEAD)]
        found: list[Said] = []
        if self.missing:
            found.append(
                said(
                    MISSING, samples=self.missing,
                    share=f"{100 * self.missing / self.samples:.2f} %",
                    hole=f"{self.longest_hole / rate:.3g}",
                )
            )  # fmt: skip
        for kind, where in self.faults.items():
            if kind == HOLE:
                continue
            first = f"{where.runs[0, 0] / rate:.6g}"
            found.append(
                said(SUSPECTED[kind], samples=where.samples, places=where.count, first=first)
            )
        if self.drifts:
            found.append(said(DRIFTS, drift=f"{self.drift:.4g} {unit}".rstrip()))
        if self.hum is not None:
            found.append(
                said(
                    HUMS,
                    frequency=", ".join(f"{f:g}" for f in self.hum.frequencies),
                    size=f"{self.hum.amplitude:.3g} {unit}".rstrip(),
                )
            )
        return found


DEAD = "dead: it never changes"
MISSING = "samples missing: {samples} ({share}), longest hole {hole} s"
DRIFTS = "drifts by {drift} from beginning to end"
HUMS = "a steady tone of {frequency} Hz, amplitude {size}, as the mains hum"
SUSPECTED = {
    "sentinel": "samples with a logger's number for no value: {samples}, in {places} places, the "
    "first at {first} s",
    "spike": "samples like spikes: {samples}, in {places} places, the first at {first} s",
    "dropout": "samples like dropouts: {samples}, in {places} places, the first at {first} s",
    "clip": "samples that look clipped: {samples}, in {places} places, the first at {first} s",
    "freeze": "samples standing still: {samples}, in {places} places, the first at {first} s",
    "zero-step": "steps of the zero: {places}, the first at {first} s",
    "gain": "changes of the gain: {places}, the first at {first} s",
    "noise": "samples of white noise, as of a contact that chatters: {samples}, in {places} "
    "places, the first at {first} s",
    "repeat": "samples that were there before, to the last digit: {samples}, in {places} places, "
    "the first at {first} s",
}
"""What is said of a channel, by the kind of fault."""


def _longest(where: Places) -> int:
    return int((where.runs[:, 1] - where.runs[:, 0]).max(initial=0))


def medians(rows: FloatArray) -> FloatArray:
    """Return the median (k,) of each row (k, n), nan left out of account; nan where all is.

    As NumPy's, which asks for both middle values at once and so takes eight times as long.
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


CREEPS = 0.5
"""Share of what its levels vary by that goes with the time, from which a channel creeps."""
BEYOND = 1e30
"""Size from which a sample is no number of a sensor: its powers are no numbers of a computer."""


GLANCE = 4096
"""Samples of a piece by which it is told whether lines were laid between others."""


class _Survey:
    """One channel's findings as its pieces pass."""

    def __init__(self, span: int, rate: float, name: str) -> None:
        self.span, self.rate, self.name, self.reach = span, rate, name, reach(rate)
        self.finder, self.listener = Finder(rate), Listener(rate)
        self.chatter, self.twice, self.folded = Chatter(), Twice(rate), Folded()
        self.codes = Codes()
        self.samples = self.missing = 0
        self.low, self.high = np.inf, -np.inf
        self.total = self.squares = self.shift = 0.0
        self.levels: list[FloatArray] = []
        self.swings: list[FloatArray] = []
        self.tail: FloatArray = np.empty(0)
        self.crests, self.losses = 0.0, 0.0
        self.moving = self.bent = 0

    def add(self, padded: FloatArray) -> None:
        x = padded[self.reach : padded.size - self.reach]
        missing = np.isnan(x)
        known = x[~missing] if missing.any() else x
        # Not before it: that is a mirror's, or of a piece that was looked at.
        ahead = padded[self.reach :]
        if np.fmax(np.fmax.reduce(ahead), -np.fmin.reduce(ahead)) >= BEYOND:
            where = int(np.argmax(np.abs(ahead) >= BEYOND))
            place = self.samples + where
            msg = (
                f"samples must be finite or missing (nan), got {ahead[where]:g} at sample "
                f"{place + 1}, {place / self.rate:.6g} s"
            )
            raise DesignError(f"{self.name}: {msg}" if self.name else msg)
        filled = bridged(padded)
        for book in (self.chatter, self.twice):
            book.add(filled[self.reach :], start=self.samples, size=x.size)
        self.codes.add(x, start=self.samples)
        self.folded.add(filled, reach=self.reach, start=self.samples)
        self.samples += x.size
        self.missing += x.size - known.size
        self.finder.add(padded, filled)
        self.listener.add(filled[self.reach : padded.size - self.reach])
        self._levels(x)
        if not known.size:
            return
        if self.samples - self.missing == known.size:
            self.shift = float(known[0])
        centred = known - self.shift
        self.total += float(centred.sum())
        self.squares += float(np.square(centred).sum())
        self.low, self.high = min(self.low, float(known.min())), max(self.high, float(known.max()))
        self._bends(x[:GLANCE])
        self._short(filled[self.reach - 1 : filled.size - self.reach + 1])

    def _short(self, x: FloatArray) -> None:
        """Enter what crests lose between samples, the fifth power of their height their weight."""
        before, at, behind = x[:-2], x[1:-1], x[2:]
        crest = np.flatnonzero((at - before) * (at - behind) > 0)
        height = np.abs(at[crest] - medians(x[None])[0])
        tall = height > 0.5 * height.max(initial=0.0)
        height, crest = height[tall], crest[tall]
        y, a, b = at[crest], before[crest], behind[crest]
        lost = (a - b) ** 2 / (8 * np.abs(2 * y - a - b))
        self.crests += float((height**5).sum())
        self.losses += float((height**4 * lost).sum())

    def _bends(self, x: FloatArray) -> None:
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
            level = medians(rows)
            swing = medians(np.abs(rows - level[:, None]))
            if not last:
                self.levels.append(level)
            self.swings.append(swing)
        self.tail = whole[full:]

    def health(self, *, gains: Places = NOWHERE) -> Health:
        """Return what was found, with what other channels say of its gain."""
        known = self.samples - self.missing
        mean = self.total / known if known else np.nan
        variance = self.squares / known - mean**2 if known else np.nan
        deviation = float(np.sqrt(max(variance, 0.0)))
        if not self.swings:  # shorter than a span
            self._levels(np.empty(0), last=True)
        swings = np.concatenate(self.swings or [np.empty(0)])
        moving = swings[swings > 0]
        typical = float(np.median(moving)) if moving.size else 0.0
        alive = self.high > self.low
        faults = dict(self.finder.found(typical=typical)) if alive else {}
        levels = np.concatenate(self.levels or [np.empty(0)])
        jumps = union(faults[k].runs for k in (SPIKE, DROPOUT, SENTINEL) if k in faults)
        steps, changed = self.finder.stepped(
            levels, swings=swings, span=self.span, typical=typical,
            jumps=Places(jumps, np.zeros(len(jumps))),
        )  # fmt: skip
        turned = self.folded.found()
        if turned.size:
            changed = Places(np.stack([turned, turned + 1], -1), np.full(turned.size, -1.0))
        others = {
            ZERO_STEP: steps, GAIN: changed if changed.count else gains,
            NOISE: places(self.chatter.found()), REPEAT: places(self.twice.found()),
        }  # fmt: skip
        faults |= {kind: where for kind, where in others.items() if alive and where.count}
        return Health(
            samples=self.samples, missing=self.missing,
            low=self.low, high=self.high, mean=mean + self.shift,
            deviation=deviation, typical=typical,
            faults=faults,
            short=self.losses / self.crests if self.crests > 0 else 0.0,
            levels=levels, span=self.span, hum=self.listener.found(deviation=deviation),
            bends=self.bent / self.moving if self.moving else 1.0, stuck=self.codes.found(),
        )  # fmt: skip


def survey(
    pieces: Iterable[FloatArray], *, rate: float, span: float = 10.0, names: Sequence[str] = ()
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
    names
        Of the channels, for messages.
    """
    found: list[_Survey] = []
    ratios: Ratios | None = None
    for padded in overlapping(map(floating, pieces), reach=reach(rate), mirrored=True):
        if ratios is None:
            called = names or [""] * len(padded)
            found = [_Survey(max(round(span * rate), 1), rate, name) for name in called]
            ratios = Ratios(rate, len(padded))
        for channel, x in zip(found, padded, strict=True):
            channel.add(x)
        ratios.add(bridged(padded[:, reach(rate) : padded.shape[-1] - reach(rate)]))
    if ratios is None:
        return []
    gains = ratios.found()
    del ratios
    # Of a day's channel what was met is twenty megabytes: each is let go as it is told.
    return [found.pop(0).health(gains=of) for of in gains]


def shifts(steps: Places, samples: ArrayLike) -> FloatArray:
    """Return what steps of the zero have added up to at samples (n,)."""
    total = np.append(0.0, np.cumsum(steps.sizes))
    return total[np.searchsorted(steps.runs[:, 0], np.asarray(samples), side="right")]


def gained(gains: Places, samples: ArrayLike) -> FloatArray:
    """Return what changes of the gain have multiplied up to at samples (n,)."""
    total = np.append(1.0, np.cumprod(gains.sizes))
    return total[np.searchsorted(gains.runs[:, 0], np.asarray(samples), side="right")]


@dataclass(frozen=True, kw_only=True)
class Treatment:
    """What is done to a channel; nothing, unless said.

    Attributes
    ----------
    masked : (k, 2) samples
        Runs made holes of, apart and in order.
    crowned
        Clipped crests put back by parabolas: for an estimate, never for a verdict.
    steps
        Steps of the zero that are taken off.
    gains
        Changes of the gain that are taken back: from each on, by the factor that is its size.
    hum
        Of the mains, taken off; None: left.
    baseline : (spans,)
        Taken off, a level for the middle of each span, straight between; none where empty.
    span : samples
        Of the baseline.
    """

    masked: IntArray = field(default_factory=lambda: NOWHERE.runs)
    crowned: Places = NOWHERE
    steps: Places = NOWHERE
    gains: Places = NOWHERE
    hum: Hum | None = None
    baseline: FloatArray = field(default_factory=lambda: np.empty(0))
    span: int = 1

    def __call__(self, x: FloatArray, start: int) -> FloatArray:
        """Return samples (n,) from `start` on, treated; the same ones where there is nothing."""
        if self.crowned.count:
            x = crowned(x, self.crowned, start)
        hidden = within(self.masked, start, x.size) if len(self.masked) else None
        if hidden is not None and hidden.any():
            x = np.where(hidden, np.nan, x)
        if self.steps.count:
            x = x - shifts(self.steps, np.arange(start, start + x.size))
        if self.gains.count:
            x = x / gained(self.gains, np.arange(start, start + x.size))
        if self.hum is not None:
            x = x - self.hum.at(start, x.size)
        if self.baseline.any():
            middle = (np.arange(self.baseline.size) + 0.5) * self.span
            x = x - np.interp(np.arange(start, start + x.size), middle, self.baseline)
        return x


def treated(
    pieces: Iterable[FloatArray], *, how: Sequence[Sequence[Treatment]]
) -> Iterator[Iterator[FloatArray]]:
    """Yield each piece of a recording treated in some ways, one after the other, (channels, n).

    `how` holds a treatment for each channel in each way; holes stay holes.
    """
    start = 0
    for piece in pieces:
        yield map(partial(_treated, piece, start), how)
        start += piece.shape[-1]


def _treated(piece: FloatArray, start: int, way: Sequence[Treatment]) -> FloatArray:
    """Return a piece (channels, n) that begins at a sample, treated in one way."""
    return np.stack([treat(x, start) for treat, x in zip(way, piece, strict=True)])


BETWEEN = 8
"""Samples made of one where crests fall between samples."""


def finer(pieces: Iterable[FloatArray], *, times: int = BETWEEN) -> Iterator[FloatArray]:
    """Yield a signal (..., n) with `times` as many samples: its crests between samples.

    The band-limited signal through the samples; what is faster than 0.4 of their rate is
    damped, what is faster than half of it was never in them. Source: Shannon, Proc. IRE 37
    (1949), with the window of `low_pass`.
    """
    taps = low_pass(0.45, rate=times, width=0.1).taps * times
    about = -(-(taps.size // 2) // times)
    for padded in overlapping(pieces, reach=about):
        from scipy.signal import upfirdn  # fifty megabytes: not of nothing

        n = padded.shape[-1] - 2 * about
        missing = np.isnan(padded[..., about : about + n])
        out = upfirdn(taps, bridged(padded), up=times, axis=-1)
        first = about * times + taps.size // 2
        out = out[..., first : first + n * times]
        if missing.any():
            out = np.where(np.repeat(missing, times, axis=-1), np.nan, out)
        yield out


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
