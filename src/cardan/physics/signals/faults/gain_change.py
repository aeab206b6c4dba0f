"""Changes of a gauge's gain, by what it is held against: another gauge.

Two channels that feel the same forces keep their ratio in each band of frequencies, as long as
no amplifier is changed. What shakes them may change, and with it the ratio in the bands that it
appears in; but only a gain changes it in all of them at once, and by the same factor.
"""

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from cardan.core.arrays import ArrayLike, BoolArray, FloatArray, IntArray
from cardan.physics.signals.faults.fault_kind import FaultKind, FaultSource
from cardan.physics.signals.faults.intervals import FaultIntervals, fault_intervals

FAULT_GAIN = "gain"

SPAN_S = 2.0
"""Length of a span in which channels are held against each other."""
FIRST_BAND_START_SPECTRUM_LINE, BAND_EDGE_RATIO = 16, 2 ** (1 / 3)
"""Line of a span's spectrum that the first band begins at, and how much wider the next one is:
narrower than a bracket's modes lie apart, so that two gauges go together in each."""
MIN_BAND_COHERENCE = 0.4
"""Coherence from which two channels feel the same forces in a band."""
SEARCH_WINDOW_SETTINGS = (12, 5, 0.15), (36, 10, 0.1)
"""Spans to either side that are held against each other, the fewest that say something, and the
least change of the logarithm of a ratio: where nothing steps it may creep, or step by less."""
MAX_SAME_CHANGE_DISTANCE_SPANS = 4
"""Spans within which two changes are one."""
MIN_AGREEING_BANDS, MIN_BANDS_SPANNED_BY_AGREEING_BANDS, MIN_AGREEING_BAND_SHARE = 5, 7, 0.8
"""Fewest bands that have to agree, how far apart the outermost of them lie at least, and their
share of all that say something."""
MEDIAN_ERROR_TO_MEDIAN_DEVIATION_FACTOR, MIN_BAND_ERROR_LN = 1.86, 0.007
"""Error of the median of one sample in median deviations, of normal noise: 1.48 of them are one
standard one, and a median is 1.25 times worse than a mean; and the least error of a band."""
(
    MAX_BAND_DEVIATION_TO_GAIN_CHANGE_RATIO,
    MAX_BAND_DEVIATION_STANDARD_ERRORS,
    MIN_BAND_CHANGE_STANDARD_ERRORS,
) = 0.25, 1.5, 2.0
"""How far a band may differ from the others, in changes and besides in errors of its own; and how
many errors a change has in a band that says something."""
MIN_SHARE_OF_SPANS_WITH_STEADY_BANDS = 0.9
"""Share of the spans in which what all bands do together is less than the change: where another
force acts now and then, they go up and down together as well."""
MIN_COMMON_CHANGE_STANDARD_ERRORS = 5.0
"""Errors that a change has by what all bands do together: there are many places to choose from."""
MIN_PRODUCT_OF_MEAN_SIGNS_BESIDE_CHANGE = 0.25
"""Product of the mean signs on both sides beyond which a band says which way round a channel is."""
MIN_FORCES_CHANGE_LN, MIN_FORCES_TO_GAIN_CHANGE_RATIO = float(np.log(2.5)), 1.5
"""Step of both channels' levels, as a logarithm, from which it is the forces that changed; and how
many times the change of the ratio: half of that, a gain moves it by itself."""
SPANS_PER_BLOCK = 16
"""Spans whose spectra are held at once."""
SEARCH_STEPS_PER_WINDOW, SEARCH_WINDOWS_PER_BLOCK = 6, 128
"""How often a change is looked for within what it is compared with, and how many times at once."""


class GainChangeDetector:
    """Compares channels, span by span: `update` with each piece, then call `result`."""

    def __init__(self, rate: float, count: int) -> None:
        self.size, self.count = max(round(SPAN_S * rate), 1), count
        self.tail = np.empty((count, 0), np.float32)
        bands = int(3 * np.log2(max(self.size // 2 / FIRST_BAND_START_SPECTRUM_LINE, 1)))
        self.edges = np.round(
            FIRST_BAND_START_SPECTRUM_LINE * BAND_EDGE_RATIO ** np.arange(bands + 1)
        ).astype(np.intp)
        self.window = np.hanning(self.size).astype(np.float32)
        self.pairs = np.tril_indices(count)
        self.met: list[npt.NDArray[np.float32]] = []

    def update(self, x: FloatArray) -> None:
        """Take samples (channels, n) without holes."""
        if self.count < 2 or len(self.edges) <= MIN_AGREEING_BANDS:
            return
        whole = np.concatenate([self.tail, x], axis=-1, dtype=np.float32)
        full = whole.shape[-1] // self.size * self.size
        self.tail = whole[:, full:].copy()
        if not full:
            return
        rows = np.moveaxis(whole[:, :full].reshape(self.count, -1, self.size), 0, 1)
        self.met += [
            self._powers(rows[k : k + SPANS_PER_BLOCK])
            for k in range(0, len(rows), SPANS_PER_BLOCK)
        ]

    def _powers(self, rows: npt.NDArray[np.float32]) -> npt.NDArray[np.float32]:
        """Return what each two channels have in common in spans (m, channels, n): (m, b, pairs)."""
        from scipy.fft import rfft

        lines = rfft((rows - rows.mean(-1, keepdims=True)) * self.window)[..., : self.edges[-1]]
        parts = lines.view(np.float32)  # real and imaginary, side by side
        powers: list[npt.NDArray[np.float32]] = []
        for k in range(len(self.edges) - 1):
            band = parts[..., 2 * self.edges[k] : 2 * self.edges[k + 1]]
            powers.append((band @ np.swapaxes(band, -1, -2))[:, *self.pairs])
        return np.stack(powers, 1)

    def result(self) -> list[FaultIntervals]:
        """Return where the gain of each channel changes, and by what factor.

        Of two that change against each other which one changed is unknown: either may have.
        """
        told: list[list[tuple[int, float]]] = [[] for _ in range(self.count)]
        if not self.met:
            return [fault_intervals(()) for _ in told]
        at = {(int(i), int(j)): k for k, (i, j) in enumerate(zip(*self.pairs, strict=True))}
        for i, j in at:
            if i == j:
                continue
            # Of a day of many gauges all at once would be as much again.
            own, other, both = (
                np.concatenate([met[..., at[p]] for met in self.met], dtype=float)
                for p in ((i, i), (j, j), (i, j))
            )
            for k, factor in gain_changes(own, other, both):
                told[i].append((k, factor))
                told[j].append((k, 1 / factor))
        return [self._places(one) for one in _keep_most_contradicted(told)]

    def _places(self, told: Sequence[tuple[int, float]]) -> FaultIntervals:
        once: list[tuple[int, float]] = []
        for k, factor in sorted(told):
            if not once or k - once[-1][0] > MAX_SAME_CHANGE_DISTANCE_SPANS:
                once.append((k, factor))
        at = [k * self.size for k, _ in once]
        return fault_intervals([(k, k + 1) for k in at], [factor for _, factor in once])


def _keep_most_contradicted(told: list[list[tuple[int, float]]]) -> list[list[tuple[int, float]]]:
    """Keep of each channel the changes that no other shows against more channels."""

    def heard(one: list[tuple[int, float]], at: int) -> int:
        return sum(abs(k - at) <= MAX_SAME_CHANGE_DISTANCE_SPANS for k, _ in one)

    return [
        [c for c in one if heard(one, c[0]) >= max(heard(other, c[0]) for other in told)]
        for one in told
    ]


def gain_changes(own: FloatArray, other: FloatArray, both: FloatArray) -> list[tuple[int, float]]:
    """Return the spans before which a ratio changes in all bands, and by what factor.

    Powers of two channels in spans and bands (m, b), and what they have in common.
    """
    if own.shape[-1] < MIN_AGREEING_BANDS:
        return []
    with np.errstate(divide="ignore", invalid="ignore"):
        known = both**2 > MIN_BAND_COHERENCE * own * other
        ratio = np.where(known, np.log(own / other) / 2, np.nan)
        loudness = np.where(known, np.log(own * other) / 4, np.nan)
    sign = np.where(known, np.sign(both), np.nan)
    for about, fewest, least in SEARCH_WINDOW_SETTINGS:
        found = [
            (k, factor)
            for k, factor in _gain_changes_in_window(ratio, sign, about, fewest, least)
            if not _forces_change(loudness, k, about=about, factor=factor)
        ]
        if found:
            return found
    return []


def _forces_change(loudness: FloatArray, k: int, *, about: int, factor: float) -> bool:
    """Return whether both channels' levels (m, b) ln step at a span by more than their ratio.

    An engine at idle shakes two gauges by another ratio than a road, in all bands perhaps.
    """
    before, after = loudness[max(k - about, 0) : k], loudness[k : k + about]
    step, count = _nanmedian((_nanmedian(after.T)[0] - _nanmedian(before.T)[0])[None])
    least = max(MIN_FORCES_CHANGE_LN, MIN_FORCES_TO_GAIN_CHANGE_RATIO * abs(np.log(abs(factor))))
    return bool(count[0] and abs(step[0]) > least)


def _gain_changes_in_window(
    ratio: FloatArray, sign: FloatArray, about: int, fewest: int, least: float
) -> list[tuple[int, float]]:
    """Return the same of the logarithm of a ratio and its sign (m, b), in one look at it."""
    if len(ratio) < 2 * fewest:
        return []
    by, clear = _change_at_spans(
        _sliding_windows(ratio, about), _sliding_windows(sign, about), fewest=fewest, least=least
    )
    kept: list[tuple[int, float]] = []
    for place in np.argsort(-clear, kind="stable"):
        k, factor = int(place) * (about // SEARCH_STEPS_PER_WINDOW), float(by[place])
        if factor != 1 and all(
            abs(k - one) >= (about if (factor > 1) == (other > 1) else fewest)
            for one, other in kept
        ):
            kept.append((k, factor))
    return sorted(kept)


def _sliding_windows(x: FloatArray, about: int) -> FloatArray:
    """Return windows of spans (m, b), as many as are looked at, (k, b, about).

    What lies behind a span is `SEARCH_STEPS_PER_WINDOW` windows behind what lies before it.
    """
    pad = np.full((about, x.shape[-1]), np.nan)
    every = np.lib.stride_tricks.sliding_window_view(np.vstack([pad, x, pad]), about, axis=0)
    return every[:: about // SEARCH_STEPS_PER_WINDOW]


def _change_at_spans(
    ratios: FloatArray, signs: FloatArray, *, fewest: int, least: float
) -> tuple[FloatArray, FloatArray]:
    """Return by what a gain changes at spans (k,), 1 where none does, and how clearly.

    Windows (k + OFTEN, b, spans) of logarithms of the ratio, and of which way round the two are.
    """
    parts = [
        slice(k, k + SEARCH_WINDOWS_PER_BLOCK)
        for k in range(0, len(ratios), SEARCH_WINDOWS_PER_BLOCK)
    ]
    each = [(*_median_and_error(ratios[p]), _nanmean(ratios[p]), _nanmean(signs[p])) for p in parts]
    middle, count, doubt, mean, way = map(np.concatenate, zip(*each, strict=True))
    heard = (count[:-SEARCH_STEPS_PER_WINDOW] >= fewest) & (
        count[SEARCH_STEPS_PER_WINDOW:] >= fewest
    )
    change = np.where(
        heard, middle[SEARCH_STEPS_PER_WINDOW:] - middle[:-SEARCH_STEPS_PER_WINDOW], 0.0
    )
    error = np.where(
        heard, np.hypot(doubt[:-SEARCH_STEPS_PER_WINDOW], doubt[SEARCH_STEPS_PER_WINDOW:]), np.inf
    )
    common = _weighted_median(change, 1 / error)
    size = np.abs(common)[:, None]
    says = heard & (error < size / MIN_BAND_CHANGE_STANDARD_ERRORS)
    same = says & (
        np.abs(change - common[:, None])
        <= MAX_BAND_DEVIATION_TO_GAIN_CHANGE_RATIO * size
        + MAX_BAND_DEVIATION_STANDARD_ERRORS * error
    )
    larger = _enough_bands_agree(same, says) & (size[:, 0] > least)
    at = np.flatnonzero(larger)
    for k in (
        at[k : k + SEARCH_WINDOWS_PER_BLOCK] for k in range(0, at.size, SEARCH_WINDOWS_PER_BLOCK)
    ):
        rest = [ratios[i] - middle[i][..., None] for i in (k, k + SEARCH_STEPS_PER_WINDOW)]
        larger[k] = _exceeds_common_variation(np.concatenate(rest, -1), says[k], size[k])
    over = np.where(heard, way[:-SEARCH_STEPS_PER_WINDOW] * way[SEARCH_STEPS_PER_WINDOW:], 0.0)
    inverted = _enough_bands_agree(
        over < -MIN_PRODUCT_OF_MEAN_SIGNS_BESIDE_CHANGE,
        np.abs(over) > MIN_PRODUCT_OF_MEAN_SIGNS_BESIDE_CHANGE,
    )
    # The medians are as far apart some spans before and behind: the means are most where it is.
    apart, flip = (
        np.where(
            heard, np.abs(x[SEARCH_STEPS_PER_WINDOW:] - x[:-SEARCH_STEPS_PER_WINDOW]), 0.0
        ).sum(-1)
        / np.maximum(heard.sum(-1), 1)
        for x in (mean, way)
    )
    factor = np.where(larger, np.exp(common), 1.0) * np.where(inverted, -1.0, 1.0)
    return factor, apart + 10 * inverted * flip


def _exceeds_common_variation(rest: FloatArray, says: BoolArray, size: FloatArray) -> BoolArray:
    """Return whether a change (k, 1) is more than what all bands (k, b, spans) do together."""
    rest = np.where(says[..., None], rest, np.nan)
    together = np.abs(_nanmedian(np.moveaxis(rest, 1, 2))[0])
    off, count = _nanmedian(together)
    steady = (together >= size).sum(-1) <= (1 - MIN_SHARE_OF_SPANS_WITH_STEADY_BANDS) * count
    return steady & (
        size[:, 0]
        > MIN_COMMON_CHANGE_STANDARD_ERRORS
        * 2
        * MEDIAN_ERROR_TO_MEDIAN_DEVIATION_FACTOR
        * off
        / np.sqrt(np.maximum(count, 1))
    )


def _enough_bands_agree(some: BoolArray, of: BoolArray) -> BoolArray:
    """Return where of bands (k, b) enough are so, far enough from each other (k,)."""
    first, last = np.argmax(some, -1), some.shape[-1] - 1 - np.argmax(some[:, ::-1], -1)
    count = some.sum(-1)
    return (
        (count >= MIN_AGREEING_BANDS)
        & (count >= MIN_AGREEING_BAND_SHARE * of.sum(-1))
        & (last - first >= MIN_BANDS_SPANNED_BY_AGREEING_BANDS - 1)
    )


def _median_and_error(x: FloatArray) -> tuple[FloatArray, IntArray, FloatArray]:
    """Return the median along the last axis, how many it is of, and its standard error."""
    middle, count = _nanmedian(x)
    spread, _ = _nanmedian(np.abs(x - middle[..., None]))
    return (
        middle,
        count,
        np.hypot(
            MEDIAN_ERROR_TO_MEDIAN_DEVIATION_FACTOR * spread / np.sqrt(np.maximum(count, 1)),
            MIN_BAND_ERROR_LN,
        ),
    )


def _weighted_median(x: FloatArray, weight: FloatArray) -> FloatArray:
    """Return what half of the weight of x (k, b) is below, (k,)."""
    order = np.argsort(x, axis=-1)
    below = np.cumsum(np.take_along_axis(weight, order, -1), -1)
    at = np.argmax(below >= below[:, -1:] / 2, -1)
    return np.take_along_axis(x, np.take_along_axis(order, at[:, None], -1), -1)[:, 0]


def _nanmean(x: FloatArray) -> FloatArray:
    """Return the mean along the last axis without what is unknown (nan), nan of nothing."""
    known = ~np.isnan(x)
    total = np.where(known, x, 0.0).sum(-1)
    return np.where(known.any(-1), total / np.maximum(known.sum(-1), 1), np.nan)


def _nanmedian(x: FloatArray) -> tuple[FloatArray, IntArray]:
    """Return the median along the last axis without what is unknown, and how many it is of."""
    count = x.shape[-1] - np.isnan(x).sum(-1)
    order = np.sort(x, axis=-1)
    low, high = (
        np.take_along_axis(order, np.maximum(k, 0)[..., None], -1)[..., 0]
        for k in ((count - 1) // 2, np.minimum(count // 2, x.shape[-1] - 1))
    )
    return np.where(count > 0, (low + high) / 2, np.nan), count


def cumulative_factor_of_gain_changes(gains: FaultIntervals, samples: ArrayLike) -> FloatArray:
    """Return what changes of the gain have multiplied up to at samples (n,)."""
    total = np.append(1.0, np.cumprod(gains.sizes))
    return total[np.searchsorted(gains.runs[:, 0], np.asarray(samples), side="right")]


def without_gain_changes(x: FloatArray, start: int, gains: FaultIntervals) -> FloatArray:
    """Return samples (n,) from `start` on with changes of the gain taken back."""
    return x / cumulative_factor_of_gain_changes(gains, np.arange(start, start + x.size))


KIND = FaultKind(code=FAULT_GAIN, correction=without_gain_changes, correctable=True)
FAULT_SOURCE = FaultSource(kinds=(KIND,), comparison=GainChangeDetector)
