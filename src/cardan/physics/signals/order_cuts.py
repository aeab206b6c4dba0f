"""Order cuts: amplitude and phase of what turns with a shaft, against its speed.

The signal is met at equal angles: in windows of whole turns, weighed by Hann's window over
the angle, so that whole orders do not see each other. A window has eight turns at least and
lasts half a second at least; neighbours overlap by half. What stands some resolution cells
next to an order is its noise.
Source: Fyfe & Munck, Analysis of computed order tracking, Mech. Syst. Signal Process. 11 (1997).
"""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from cardan.core.arrays import ComplexArray, FloatArray
from cardan.physics.signals.conditioning import interpolate_gaps
from cardan.physics.signals.order_tracking import ShaftRotation

MIN_WINDOW_TURNS, MIN_WINDOW_S = 8, 0.5
"""A window has as many turns at least, and lasts as long at least."""

MIN_SHAFT_SPEED_REV_PER_S = 1.0
"""Turns/s below which a shaft is taken to stand."""

NOISE_OFFSETS_SPECTRAL_BINS = (-4.0, -3.0, 3.0, 4.0)
"""Resolution cells between an order and what is taken for its noise: Hann's window has two."""

MAX_WINDOW_GAP_SHARE = 0.2
"""Share of a window that may be missing."""


@dataclass(frozen=True)
class OrderWindows:
    """Stretches of whole turns, W of them.

    Attributes
    ----------
    start, stop : (W,) s
        Where each begins and ends.
    first, turns : (W,) 1
        Turns made at its start, and in it.
    """

    start: FloatArray
    stop: FloatArray
    first: FloatArray
    turns: FloatArray

    @property
    def time(self) -> FloatArray:
        """Middles, (W,) s."""
        return (self.start + self.stop) / 2

    @property
    def speed(self) -> FloatArray:
        """Mean speed, (W,) turns/s."""
        return self.turns / (self.stop - self.start)


def order_windows(rotation: ShaftRotation, *, until: float) -> OrderWindows:
    """Return windows of whole turns from where a shaft begins to turn, up to `until` s."""
    step = 0.01
    time = np.arange(0.0, until + step, step)
    turns = rotation.at(time)
    moving = np.append(True, np.diff(turns) > MIN_SHAFT_SPEED_REV_PER_S / 4 * step)
    clock, angle = time[moving], turns[moving]
    found: list[tuple[float, float, float, float]] = []
    place = float(angle[0]) if angle.size else 0.0
    while angle.size:
        at = float(np.interp(place, angle, clock))
        speed = float(rotation.speed(at + MIN_WINDOW_S / 2))
        count = max(MIN_WINDOW_TURNS, float(np.ceil(MIN_WINDOW_S * speed)))
        if place + count > angle[-1]:
            break
        end = float(np.interp(place + count, angle, clock))
        if count / (end - at) >= MIN_SHAFT_SPEED_REV_PER_S:
            found.append((at, end, place, count))
        place += count / 2
    rows = np.array(found).reshape(-1, 4).T
    return OrderWindows(*rows)


@dataclass(frozen=True)
class OrderCuts:
    """Amplitude and phase of some orders in some channels, window by window.

    Attributes
    ----------
    orders : K
        Multiples of the shaft's turn.
    windows : W
        Where each was met.
    amplitude : (channels, K, W) complex
        0-to-peak and phase against the shaft's angle θ: the signal is Re a e^{ikθ}. nan where
        too much is missing.
    noise : (channels, K, W)
        Rms size of the spectrum next to the order.
    """

    orders: tuple[float, ...]
    windows: OrderWindows
    amplitude: ComplexArray
    noise: FloatArray


def order_cuts(
    pieces: Iterable[FloatArray], *, rate: float, rotation: ShaftRotation, at: OrderWindows,
    orders: Sequence[float] = (1.0, 2.0, 4.0),
) -> OrderCuts:  # fmt: skip
    """Cut orders out of channels (channels, n) that come in pieces, nan where missing.

    Parameters
    ----------
    pieces
        The signal from its start.
    rate : Hz
        Of its samples.
    rotation
        Of the shaft.
    at
        Windows of it.
    orders
        Wanted; whole ones do not see each other.
    """
    found = [
        _window_amplitudes(span, time, rotation, at, k, orders)
        for k, span, time in iterate_window_samples(pieces, rate, at)
    ]
    channels, wide = (
        found[0].shape if found else (1, len(orders) * (1 + len(NOISE_OFFSETS_SPECTRAL_BINS)))
    )
    # What the recording ends before is missing.
    missing = [np.full((channels, wide), np.nan + 0j)] * (at.time.size - len(found))
    rows = (
        np.stack([*found, *missing], axis=-1) if at.time.size else np.empty((1, wide, 0), complex)
    )
    beside = rows[:, len(orders) :].reshape(
        channels, len(orders), len(NOISE_OFFSETS_SPECTRAL_BINS), -1
    )
    return OrderCuts(
        tuple(orders), at, rows[:, : len(orders)], np.sqrt((np.abs(beside) ** 2).mean(axis=2))
    )


def iterate_window_samples(
    pieces: Iterable[FloatArray], rate: float, at: OrderWindows
) -> Iterator[tuple[int, FloatArray, FloatArray]]:
    """Yield each window's place, its samples (channels, n) and their times, as pieces pass."""
    begins, ends = np.floor(at.start * rate).astype(int), np.ceil(at.stop * rate).astype(int)
    held, start, place = np.empty((0, 0)), 0, 0
    for piece in pieces:
        held = piece if not held.size else np.concatenate([held, piece], axis=-1)
        while place < ends.size and ends[place] <= start + held.shape[-1]:
            first = max(int(begins[place]), start)
            span = held[:, first - start : ends[place] - start]
            yield place, span, (first + np.arange(span.shape[-1])) / rate
            place += 1
        until = int(begins[place]) if place < ends.size else start + held.shape[-1]
        keep = min(max(until - start, 0), held.shape[-1])
        held, start = held[:, keep:], start + keep


def hann_weights(angle: FloatArray, at: OrderWindows, k: int) -> FloatArray:
    """Weigh samples (n,) of a window by Hann's window over the angle (n,), its whole sum 1.

    A second of fast turning weighs as much as its turns.
    """
    share = (angle - at.first[k]) / at.turns[k]
    inside = (share >= 0) & (share <= 1)
    weight = np.where(inside, 1 - np.cos(2 * np.pi * share), 0.0) * np.gradient(angle)
    return weight / weight.sum()


def _window_amplitudes(
    span: FloatArray, time: FloatArray, rotation: ShaftRotation, at: OrderWindows, k: int,
    orders: Sequence[float],
) -> ComplexArray:  # fmt: skip
    """Return orders and the spectrum next to each (channels, K + K) of one window."""
    angle, count = rotation.at(time), float(at.turns[k])
    weight = hann_weights(angle, at, k)
    each = [*orders, *(o + b / count for o in orders for b in NOISE_OFFSETS_SPECTRAL_BINS)]
    level = interpolate_gaps(span)
    level = level - (level @ weight)[:, None]
    waves = weight * np.exp(-2j * np.pi * np.multiply.outer(each, angle))
    missing = np.isnan(span) @ weight > MAX_WINDOW_GAP_SHARE
    return np.where(missing[:, None], np.nan, 2 * level @ waves.T)
