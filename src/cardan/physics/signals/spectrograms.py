"""Pictures of a recording as arrays: power over time, amplitude over speed and order."""

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from cardan.core.arrays import FloatArray
from cardan.physics.signals.conditioning import interpolate_gaps
from cardan.physics.signals.order_cuts import OrderWindows, hann_weights, iterate_window_samples
from cardan.physics.signals.order_tracking import ShaftRotation
from cardan.physics.signals.recording import rechunk_to_block_size

MAX_FREQUENCY_ROWS, MAX_TIME_COLUMNS = 160, 240
"""Frequencies and times of a spectrogram, at most: what a page can show."""

SPEED_BAND_REV_PER_S = 50 / 60
"""Width of the speeds that an order map takes as one, turns/s."""


@dataclass(frozen=True)
class Spectrogram:
    """Power of a signal.

    Attributes
    ----------
    time : (m + 1,) s
        Edges.
    frequency : (n + 1,) Hz
        Edges.
    density : (n, m) unit²/Hz
        Mean of each cell; nan where nothing was recorded.
    """

    time: FloatArray
    frequency: FloatArray
    density: FloatArray


@dataclass(frozen=True)
class OrderMap:
    """Amplitude of a signal over its shaft's speed and order.

    Attributes
    ----------
    speed : (m + 1,) turns/s
        Edges.
    order : (n + 1,) 1
        Edges.
    amplitude : (n, m)
        Rms over the windows of a speed of the 0-to-peak amplitude; nan where there are none.
    """

    speed: FloatArray
    order: FloatArray
    amplitude: FloatArray


def spectrograms(
    pieces: Iterable[FloatArray], *, rate: float, seconds: float, top: float | None = None
) -> list[Spectrogram]:
    """Return the spectrogram of each channel that comes in pieces (channels, n).

    Blocks of two seconds at least, Hann's window, those of a column averaged; up to `top` Hz.
    """
    highest = min(top or rate / 2, rate / 2)
    size = max(round(2 * rate), 16)
    block = seconds / MAX_TIME_COLUMNS if seconds > 2 * MAX_TIME_COLUMNS else size / rate
    columns = max(int(np.ceil(seconds / block)), 1)
    window = 0.5 - 0.5 * np.cos(2 * np.pi * np.arange(size) / size)
    frequency = np.arange(size // 2 + 1) * rate / size
    rows = min(MAX_FREQUENCY_ROWS, int(np.count_nonzero(frequency < highest)))
    edge = np.linspace(0, highest, rows + 1)
    row = np.minimum(np.searchsorted(edge, frequency, side="right") - 1, rows - 1)
    inside = frequency < highest
    each = np.maximum(np.bincount(row[inside], minlength=rows), 1)
    total = count = None
    for k, piece in enumerate(rechunk_to_block_size(pieces, size=size)):
        if total is None or count is None:
            total, count = (
                np.zeros((piece.shape[0], rows, columns)),
                np.zeros((piece.shape[0], columns)),
            )
        if piece.shape[-1] < size:
            break
        known = np.isnan(piece).mean(-1) < 0.2
        x = interpolate_gaps(piece)
        x = x - x.mean(-1, keepdims=True)
        power = 2 * np.abs(np.fft.rfft(x * window)) ** 2 / (rate * (window**2).sum())
        at = min(int(k * size / rate / block), columns - 1)
        for c in np.flatnonzero(known):
            total[c, :, at] += np.bincount(row[inside], power[c, inside], rows) / each
            count[c, at] += 1
    if total is None or count is None:
        return []
    with np.errstate(invalid="ignore"):
        mean = total / np.where(count > 0, count, np.nan)[:, None]
    time = np.minimum(block * np.arange(columns + 1), seconds)
    return [Spectrogram(time, edge, m) for m in mean]


def order_maps(
    pieces: Iterable[FloatArray],
    *,
    rate: float,
    rotation: ShaftRotation,
    at: OrderWindows,
    top: float = 8.0,
) -> list[OrderMap]:
    """Return the order map of each channel (channels, n), met at equal angles window by window."""
    if not at.time.size:
        return []
    turns = 8
    order = np.arange(0.0, top + 0.5 / turns, 1 / turns)
    speeds = at.speed
    edges = SPEED_BAND_REV_PER_S * np.arange(
        np.floor(speeds.min() / SPEED_BAND_REV_PER_S),
        np.floor(speeds.max() / SPEED_BAND_REV_PER_S) + 2,
    )
    total: FloatArray | None = None
    count = np.zeros(edges.size - 1)
    for k, span, time in iterate_window_samples(pieces, rate, at):
        if total is None:
            total = np.zeros((span.shape[0], order.size, edges.size - 1))
        if np.isnan(span).mean() > 0.2:
            continue
        angle = rotation.at(time)
        weight = hann_weights(angle, at, k)
        x = interpolate_gaps(span)
        x = x - (x @ weight)[:, None]
        # What is faster than half the samples of a turn is beyond the map, not folded onto it.
        held = order < 0.45 * rate / speeds[k]
        waves = weight * np.exp(-2j * np.pi * np.multiply.outer(order[held], angle))
        place = min(int((speeds[k] - edges[0]) / SPEED_BAND_REV_PER_S), count.size - 1)
        total[:, held, place] += np.abs(2 * x @ waves.T) ** 2
        count[place] += 1
    if total is None:
        return []
    with np.errstate(invalid="ignore"):
        mean = np.sqrt(total / np.where(count > 0, count, np.nan))
    half = 0.5 / turns
    return [OrderMap(edges, np.append(order - half, order[-1] + half), m) for m in mean]
