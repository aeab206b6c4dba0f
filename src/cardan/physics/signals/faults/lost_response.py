"""Stretches in which a gauge stops answering, wholly or above a frequency, while another goes on.

A vehicle that stops, rolls or comes to a smooth road changes what all gauges feel. A gauge that
freezes, or an amplifier whose low-pass filter is switched on, loses octaves by itself: its level
steps down in each of them, and that of a gauge that feels the same does not.
"""

import numpy as np
import numpy.typing as npt

from cardan.core.arrays import BoolArray, FloatArray
from cardan.physics.signals.faults.fault_kind import FaultKind, FaultSource
from cardan.physics.signals.faults.gain_change import FAULT_GAIN
from cardan.physics.signals.faults.intervals import FaultIntervals, fault_intervals
from cardan.physics.signals.faults.waveform import (
    FAULT_DROPOUT,
    FAULT_FREEZE,
    FAULT_MISSING_SAMPLES,
)

FAULT_RESPONSE = "response"

SPAN_S = 1.0
"""Time over which levels are taken."""
LOWEST_BAND_HZ, HIGHEST_BAND_SHARE_OF_RATE = 2.0, 0.4
"""Frequency that the first octave begins at, and share of the sample rate that the last ends at."""
ADJACENT_BANDS = 3
"""Octaves side by side that are lost at least: a force of one shaft, which only one gauge feels,
fills no three of them."""
MIN_COHERENCE, MIN_COHERENT_BANDS = 0.1, 2
"""Coherence over the whole recording from which two gauges feel the same in an octave; and octaves
in which they do, from which the highest ones are compared whatever is in them: there lies the noise
of an amplifier, which no vehicle moves and a filter behind it does."""
MIN_LEVEL_LOSS_LN = float(np.log(3))
"""Logarithm of how many times less of it there is."""
MAX_SHARE_OF_OTHER_STEP = 1 / 3
"""Share of the step, as a logarithm, by which the other gauge's level steps down at most."""
USUAL_QUANTILE = 0.25
"""Quantile of the difference between two gauges' levels that is usual: more is lost elsewhere."""
SMOOTHED_SPANS, MIN_LOST_SPANS = 5, 5
"""Spans whose median is taken, and the fewest that are lost: gears are shifted within less."""
STEP_SPANS, MIN_COMPARED_SPANS_OUTSIDE_LOSS, TRANSITION_SPANS = 5, 3, 1
"""Spans to either side of an end whose levels are compared, the fewest outside, and those
between."""
SPANS_PER_BLOCK = 16
"""Spans whose spectra are held at once."""


class LostResponseDetector:
    """Compares the levels of channels in octaves, span by span."""

    def __init__(self, rate: float, count: int) -> None:
        self.size, self.count = max(round(SPAN_S * rate), 1), count
        octaves = np.log2(max(HIGHEST_BAND_SHARE_OF_RATE * rate / LOWEST_BAND_HZ, 1.0))
        edges = LOWEST_BAND_HZ * 2.0 ** np.arange(np.floor(octaves + 0.5) + 1)
        edges[-1] = HIGHEST_BAND_SHARE_OF_RATE * rate
        self.edges = np.unique(np.round(edges * self.size / rate).astype(np.intp))
        self.window = np.hanning(self.size).astype(np.float32)
        self.tail = np.empty((count, 0), np.float32)
        self.powers: list[npt.NDArray[np.float32]] = []
        self.common = np.zeros((max(len(self.edges) - 1, 0), count, count), complex)

    def update(self, x: FloatArray) -> None:
        """Take samples (channels, n) without holes."""
        if self.count < 2 or len(self.edges) <= ADJACENT_BANDS:
            return
        whole = np.concatenate([self.tail, x], axis=-1, dtype=np.float32)
        full = whole.shape[-1] // self.size * self.size
        self.tail = whole[:, full:].copy()
        rows = np.moveaxis(whole[:, :full].reshape(self.count, -1, self.size), 0, 1)
        for k in range(0, len(rows), SPANS_PER_BLOCK):
            self._add_spans(rows[k : k + SPANS_PER_BLOCK])

    def _add_spans(self, rows: npt.NDArray[np.float32]) -> None:
        """Enter the powers of spans (m, channels, n) in each octave, and what is in common."""
        from scipy.fft import rfft

        lines = rfft((rows - rows.mean(-1, keepdims=True)) * self.window)
        bands = [lines[..., a:b] for a, b in zip(self.edges[:-1], self.edges[1:], strict=True)]
        self.powers.append(np.stack([np.square(np.abs(z)).sum(-1) for z in bands], -1))
        for total, z in zip(self.common, bands, strict=True):
            side_by_side = np.moveaxis(z, 1, 0).reshape(self.count, -1)
            total += side_by_side @ side_by_side.conj().T

    def result(self) -> list[FaultIntervals]:
        """Return where each channel lost its response, and how many times less of it there is."""
        if not self.powers:
            return [fault_intervals(()) for _ in range(self.count)]
        with np.errstate(divide="ignore", invalid="ignore"):
            levels = np.log(np.concatenate(self.powers, dtype=float)) / 2
            own = np.einsum("bii->bi", self.common).real
            coherence = np.abs(self.common) ** 2 / (own[:, :, None] * own[:, None, :])
        same = np.nan_to_num(coherence) > MIN_COHERENCE
        return [self._lost_by(k, levels, same) for k in range(self.count)]

    def _lost_by(self, k: int, levels: FloatArray, same: BoolArray) -> FaultIntervals:
        """Return where a channel is lost against at least half of those that feel the same."""
        partners = [
            j for j in range(self.count) if j != k and comparable_bands(same[:, k, j]).any()
        ]
        votes = np.zeros(len(levels))
        losses = np.zeros(len(levels))
        for j in partners:
            comparable = comparable_bands(same[:, k, j])
            for first, last, loss in lost_stretches(levels[:, k], levels[:, j], comparable):
                votes[first:last] += 1
                losses[first:last] = np.maximum(losses[first:last], loss)
        lost = (votes > 0) & (votes >= len(partners) / 2)
        runs = _runs(lost)
        sizes = [float(np.exp(losses[first:last].max())) for first, last in runs]
        return fault_intervals([(a * self.size, b * self.size) for a, b in runs], sizes)


def comparable_bands(same: BoolArray) -> BoolArray:
    """Return which bands, each the first of `ADJACENT_BANDS`, two gauges are compared in.

    `same` (bands,) are those in which they feel the same.
    """
    comparable = _adjacent(same[None])[0].copy()
    comparable[-1] |= np.count_nonzero(same) >= MIN_COHERENT_BANDS
    return comparable


def lost_stretches(
    own: FloatArray, other: FloatArray, comparable: BoolArray
) -> list[tuple[int, int, float]]:
    """Return spans, first and one behind the last, in which a channel is lost, and by how much.

    Parameters
    ----------
    own, other : (spans, bands) ln
        Levels of the channel, and of another one.
    comparable
        First bands of those in which the two are compared (`comparable_bands`).
    """
    with np.errstate(invalid="ignore"):
        less = other - own
    known = np.isfinite(less).all(-1)
    if np.count_nonzero(known) < 2 * STEP_SPANS:
        return []
    smooth = _running_median(np.where(np.isfinite(less), less, 0.0))
    usual = np.quantile(smooth[known], USUAL_QUANTILE, axis=0)
    lost = _adjacent(smooth - usual > MIN_LEVEL_LOSS_LN) & comparable
    found: list[tuple[int, int, float]] = []
    for first, last in _runs(np.asarray(lost.any(axis=-1))):
        if last - first < MIN_LOST_SPANS:
            continue
        lowest = int(np.argmax(lost[first:last].mean(0)))
        bands = slice(lowest, lowest + ADJACENT_BANDS)
        if any(
            _steps_alone(own[:, bands], other[:, bands], outside, inside)
            for outside, inside in _ends(first, last, len(own))
        ):
            loss = (smooth - usual)[first:last, bands]
            found.append((first, last, float(np.median(loss))))
    return found


def _ends(first: int, last: int, count: int) -> list[tuple[slice, slice]]:
    """Return the spans outside and inside each end that is within the recording."""
    inner = min(STEP_SPANS, last - first - TRANSITION_SPANS)
    ends = [
        (
            slice(max(first - TRANSITION_SPANS - STEP_SPANS, 0), max(first - TRANSITION_SPANS, 0)),
            slice(first + TRANSITION_SPANS, first + TRANSITION_SPANS + inner),
        ),
        (
            slice(last + TRANSITION_SPANS, min(last + TRANSITION_SPANS + STEP_SPANS, count)),
            slice(last - TRANSITION_SPANS - inner, last - TRANSITION_SPANS),
        ),
    ]
    return [
        (out, into) for out, into in ends if out.stop - out.start >= MIN_COMPARED_SPANS_OUTSIDE_LOSS
    ]


def _steps_alone(own: FloatArray, other: FloatArray, outside: slice, inside: slice) -> bool:
    """Return whether own levels (spans, bands) step down at an end, and the other's do not."""
    step, beside = (
        np.median(x[outside], axis=0) - np.median(x[inside], axis=0) for x in (own, other)
    )
    return bool(
        (step > MIN_LEVEL_LOSS_LN).all() and (beside < MAX_SHARE_OF_OTHER_STEP * step).all()
    )


def _adjacent(x: BoolArray) -> BoolArray:
    """Return of flags (spans, bands) where they are set in so many bands side by side."""
    windows = np.lib.stride_tricks.sliding_window_view(x, ADJACENT_BANDS, axis=-1)
    return np.asarray(windows.all(axis=-1))


def _running_median(x: FloatArray) -> FloatArray:
    """Return the median of spans (m, bands) over `SMOOTHED_SPANS`, fewer at the ends."""
    half = SMOOTHED_SPANS // 2
    padded = np.pad(x, ((half, half), (0, 0)), mode="edge")
    every = np.lib.stride_tricks.sliding_window_view(padded, SMOOTHED_SPANS, axis=0)
    return np.median(every, axis=-1)


def _runs(flags: BoolArray) -> list[tuple[int, int]]:
    """Return where flags (n,) are set: first, and one behind the last."""
    edge = np.flatnonzero(np.diff(np.concatenate([[False], flags, [False]])))
    return list(zip(edge[::2].tolist(), edge[1::2].tolist(), strict=True))


KIND = FaultKind(
    code=FAULT_RESPONSE,
    maskable=True,
    explained_by=(FAULT_MISSING_SAMPLES, FAULT_FREEZE, FAULT_DROPOUT, FAULT_GAIN),
)
FAULT_SOURCE = FaultSource(kinds=(KIND,), comparison=LostResponseDetector)
