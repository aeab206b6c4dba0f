"""Which ratio and lag of a speed a stress goes with, and the forces of a shaft that turns so."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import chain

import numpy as np

from cardan.core.arrays import ComplexArray, FloatArray, IntArray
from cardan.physics.signals.order_kernels import (
    bin_sums,
    first_order_filter,
    running_mean,
    unit_phasor_of_turns,
)
from cardan.physics.signals.shaft_angle import ShaftAngle

MAX_RELATIVE_SPEED_SCALE_ERROR_SEARCHED = 0.05
"""Largest error of a speed's scale that is looked for, relative."""


SEARCH_SAMPLE_RATE_HZ = 100.0
"""Samples a second at which it is looked for."""


SEARCH_SEGMENT_COUNT = 64
"""Of the recording, in each of which what is between two lines of its spectrum stands still."""


TURNS_PER_RATIO_SEARCH_BIN = 2.0
"""Turns that are taken together where ratios are looked for: 5 % off turns by 0.2 of a cycle."""


CONSTANT_RESPONSE_BAND_WIDTH_HZ = 2.5
"""Width in frequency over which a response is taken as one, Hz."""


RELATIVE_BAND_WIDTH_FOR_LAG_SEARCH = 0.03
"""Width of bands that distinguish a lag from a mode, of their frequency."""


MIN_RESIDUAL_BAND_CORRELATION = 0.3
"""Correlation from band to band of what one mode leaves, from which a second one is sought."""


MIN_LAG_UNCERTAINTY_S = 0.0075
"""What bands and sampling leave of a lag, s, however surely it is read."""


MIN_ORDER_FREQUENCY_HZ = 2.0
"""Frequency below which the load determines nothing, Hz."""


@dataclass(frozen=True)
class SpeedAlignment:
    """One ratio and lag of a rotation, the energy it explains, and the response (bands,) so."""

    ratio: float
    lag: float
    energy: float
    frequency: FloatArray
    response: ComplexArray
    weight: FloatArray
    stretch_offsets: FloatArray
    """Turns by which each stretch of the angle goes on from another zero."""
    lag_interval: tuple[float, float] = (-np.inf, np.inf)
    """Between which the lag lies, nine times in ten."""


@dataclass(frozen=True)
class SpeedAlignmentSearch:
    """A stress whose order 2 is looked for, and the angle that it is looked for by.

    Attributes
    ----------
    stress, torque : (n,)
        The stress, and what the force goes with.
    rate : Hz
        Of both, `start` s when they begin.
    """

    stress: FloatArray
    torque: FloatArray
    angle: ShaftAngle
    rate: float
    start: float

    @property
    def decimation(self) -> int:
        """Samples taken together: turned back by the shaft, an order stands nearly still."""
        return max(int(self.rate / SEARCH_SAMPLE_RATE_HZ), 1)

    @property
    def block_count(self) -> int:
        """How many are left."""
        return self.stress.size // self.decimation

    @cached_property
    def stress_times_torque(self) -> FloatArray:
        """Stress times torque, of as many as are taken together (m, every)."""
        n = self.block_count * self.decimation
        return (self.stress[:n] * self.torque[:n]).reshape(self.block_count, self.decimation)

    @cached_property
    def mean_square_torque(self) -> FloatArray:
        """Mean square of the torque (m,)."""
        n = self.block_count * self.decimation
        return (self.torque[:n] ** 2).reshape(self.block_count, self.decimation).mean(-1)

    @cached_property
    def turns(self) -> FloatArray:
        """Turns made (m every,)."""
        n = self.block_count * self.decimation
        return self.angle.rotation.at(self.start + np.arange(n) / self.rate)

    @cached_property
    def lag_steps(self) -> IntArray:
        """Lags that are looked at, in steps of as many samples as are taken together."""
        lag = self.angle.lag
        lags = np.arange(-lag, lag + 1e-9, 0.05 if lag < 0.5 else 0.06)
        return np.unique(np.rint(lags * self.rate / self.decimation).astype(np.int64))

    @cached_property
    def times_turns_speeds(self) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Times, turns and turns/s from the latest lag on to the earliest: a lag is a place."""
        step = self.decimation / self.rate
        most, least = max(int(self.lag_steps[-1]), 0), min(int(self.lag_steps[0]), 0)
        place = np.arange(self.block_count + most - least, dtype=float) - most
        time: FloatArray = self.start + (self.decimation - 1) / 2 / self.rate + place * step
        return time, self.angle.rotation.at(time), self.angle.rotation.speed(time)


def align_speed(
    search: SpeedAlignmentSearch, *, times: float = 1.0, over: float = 0.0
) -> list[SpeedAlignment]:
    """Ratios and lags by the energy that T e^{2iθ} explains, the best first, four at most.

    The response is one number in each band of twice the speed, and in each stretch between
    losses of the angle turned by one phase. For each lag all ratios are
    met at once: as a function of the angle, a wrong ratio is a frequency.

    The angle is taken `times` as far. None are returned where at every fourth lag none explains
    half as much as what it should be `over`: of the energy of a band three lags leave six tenths.
    """
    from scipy.fft import fft, next_fast_len

    m, square, shifts = search.block_count, search.mean_square_torque, search.lag_steps
    if m < 100:
        return []
    back = unit_phasor_of_turns(-2 * times * search.turns).reshape(m, -1)
    moved = np.einsum("ij,ij->i", search.stress_times_torque, back) / search.decimation
    step = search.decimation / search.rate
    most = max(int(shifts[-1]), 0)
    time, turns, f2 = search.times_turns_speeds
    turns, f2 = times * turns, 2 * times * f2
    band, bins = (
        (f2 / CONSTANT_RESPONSE_BAND_WIDTH_HZ).astype(np.int64),
        ((turns - turns[0]) / TURNS_PER_RATIO_SEARCH_BIN).astype(np.int64),
    )
    bands, count = int(band.max()) + 1, int(bins.max()) + 1
    # Each stretch of the angle has bands of its own, which have one phase in common.
    stretch = search.angle.stretch_index(time)
    many = len(search.angle.lost_intervals) + 1
    band, bands = stretch * bands + band, bands * many
    fast = f2 > MIN_ORDER_FREQUENCY_HZ
    ahead = unit_phasor_of_turns(-2 * turns)
    moved = moved * np.conj(ahead[most : most + m])
    size = next_fast_len(3 * count)
    # Two cycles a turn, off by the ratio: OFF is 2 TURNS OFF cycles a bin, in both directions.
    off = np.fft.fftfreq(size) / (2 * TURNS_PER_RATIO_SEARCH_BIN)
    near = np.flatnonzero(np.abs(off) <= MAX_RELATIVE_SPEED_SCALE_ERROR_SEARCHED)
    blurred = np.sinc(2 * TURNS_PER_RATIO_SEARCH_BIN * off[near]) ** 2
    # Between the lines of the spectrum: a sixth of one is a radian at the ends, and in each of
    # `SEARCH_SEGMENT_COUNT` parts it is none.
    beside = np.linspace(-0.5, 0.5, 21) / size / (2 * TURNS_PER_RATIO_SEARCH_BIN)
    share = np.unique(np.arange(SEARCH_SEGMENT_COUNT) * count // SEARCH_SEGMENT_COUNT)
    each = -(-count // share.size)
    # A row of bins for each share, as long as the longest: where each bin stands among them.
    row = np.searchsorted(share, np.arange(count), "right") - 1
    stands = row * each + np.arange(count) - share[row]
    place = share[:, None] + np.arange(each) + 0.5
    amid = (share + np.append(share[1:], count)) // 2 + 0.5
    turned = np.exp(-4j * np.pi * TURNS_PER_RATIO_SEARCH_BIN * np.outer(amid, beside))
    cell = stands[bins]

    def at(shift: int) -> tuple[FloatArray, list[SpeedAlignment]]:
        """Return the energy by ratio at a lag, and the best there."""
        own = slice(most - shift, most - shift + m)
        if np.count_nonzero(fast[own]) < 100:
            return np.zeros(1), []
        weight = np.bincount(band[own], np.where(fast[own], square, 0.0), bands)
        busy = weight > 1e-3 * weight.sum()
        row_of = np.where(busy, np.cumsum(busy) - 1, -1)
        rows = np.where(fast[own], row_of[band[own]], -1)
        many_rows = int(np.count_nonzero(busy))
        grid, (weight, speeds, heard) = bin_sums(
            np.where(rows < 0, -1, rows * place.size + cell[own]), rows, moved, ahead[own],
            square, f2[own], cells=many_rows * place.size, slots=many_rows,
        )  # fmt: skip
        grid, middle = grid.reshape(many_rows, -1), speeds / heard
        which = np.divmod(np.flatnonzero(busy), bands // many)
        # What turns within a bin is averaged: at the ends of the search it loses this much.
        spectra = fft(grid.astype(np.complex64).take(stands, axis=1), size)[:, near]
        energy = (1 / weight) @ (spectra.real**2 + spectra.imag**2)
        energy /= blurred
        peaks = off[near[local_maxima(energy)[:4]]]
        near_line = unit_phasor_of_turns(-2 * TURNS_PER_RATIO_SEARCH_BIN * place[..., None] * peaks)
        summed = grid.reshape(-1, *place.shape).swapaxes(0, 1) @ near_line
        best: list[SpeedAlignment] = []
        for peak, met in zip(peaks, summed.T, strict=True):
            lines: ComplexArray = met @ turned
            fine = peak + beside
            lines /= np.sinc(2 * TURNS_PER_RATIO_SEARCH_BIN * fine)
            sharp = ((np.abs(lines) ** 2) / weight[:, None]).sum(0)
            k = int(np.argmax(sharp))
            zeros, line, power, held = _combine_stretches(lines[:, k], weight, middle, which, many)
            explained = float((np.abs(line) ** 2 / power).sum())
            ratio = 1 + float(fine[k])
            best.append(
                SpeedAlignment(ratio, shift * step, explained, held, line / power, power, zeros)
            )
        return energy, best

    # Every fourth lag from the middle one on shows whether the others are worth it.
    coarse = np.arange(shifts.size) % 4 == shifts.size // 2 % 4
    first = [at(int(shift)) for shift in shifts[coarse]]
    if over and not any(energy.max() >= over / 2 for energy, _ in first):
        return []
    others = (at(int(shift)) for shift in shifts[~coarse])
    found = [one for _, best in (*first, *others) for one in best]
    found.sort(key=lambda one: -one.energy)
    kept: list[SpeedAlignment] = []
    made = float(turns[-1] - turns[0])
    apart = 3 / max(2 * made, 1.0)
    for one in found:
        if all(abs(one.ratio - k.ratio) > apart for k in kept):
            kept.append(one)
    return kept[:4]


def _combine_stretches(
    lines: ComplexArray, weight: FloatArray, middle: FloatArray,
    which: tuple[IntArray, IntArray], stretches: int,
) -> tuple[FloatArray, ComplexArray, FloatArray, FloatArray]:  # fmt: skip
    """Turn the stretches of an angle so that their responses, band by band, are most alike.

    Returns the turns of each stretch, and by bands the lines, their weights and frequencies.
    """
    stretch, band = which
    if stretches == 1:
        return np.zeros(1), lines, weight, middle
    kinds, band = np.unique(band, return_inverse=True)

    def by_band(x: np.ndarray) -> np.ndarray:
        out = np.zeros(kinds.size, x.dtype)
        np.add.at(out, band, x)
        return out

    power = by_band(weight)
    strong = np.zeros(stretches)
    np.add.at(strong, stretch, np.abs(lines) ** 2 / weight)
    turned = np.zeros(stretches)
    # From the strongest on: each next one is turned to those that stand already.
    standing = np.zeros(stretches, bool)
    for k in (*np.argsort(-strong), *np.argsort(-strong), *np.argsort(-strong)):
        held = standing[stretch] & (stretch != k)
        mine = stretch == k
        known = by_band(np.where(held, lines * np.exp(-1j * turned[stretch]), 0))
        turned[k] = np.angle((np.conj(known / power)[band] * lines)[mine].sum())
        standing[k] = True
    line = by_band(lines * np.exp(-1j * turned[stretch]))
    return turned / (4 * np.pi), line, power, by_band(middle * weight) / power


def explained_energy(rows: np.ndarray, z: ComplexArray) -> FloatArray:
    """Energy (..., k) of each z (n, k) that each choice of rows (..., columns, n) explains."""
    back = np.conj(rows)
    gram = back @ rows.swapaxes(-1, -2)
    size = np.trace(gram, axis1=-2, axis2=-1)[..., None, None]
    right = back @ z
    c = np.linalg.solve(gram + 1e-6 * size * np.eye(rows.shape[-2]), right)
    return (np.conj(c) * right).real.sum(-2)


def local_maxima(x: FloatArray) -> IntArray:
    """Places of the local maxima of x on a circle cut open, the highest first."""
    left, right = np.append(-np.inf, x[:-1]), np.append(x[1:], -np.inf)
    at = np.flatnonzero((x >= left) & (x > right))
    return at[np.argsort(-x[at])]


@dataclass(frozen=True)
class SampledShaftMotion:
    """What turns with a shaft (n,): its turns, turns/s and torque, at a rate Hz."""

    turns: FloatArray
    speed: FloatArray
    torque: FloatArray
    rate: float
    stretch: IntArray
    """Of the angle, (n,): each has a zero of its own."""

    def forces(self, order: int) -> list[ComplexArray]:
        """Return forces locked to an order: by torque, and the second by speed squared too."""
        turning = unit_phasor_of_turns(order * self.turns)
        by_torque = [self.torque * turning]
        return [*by_torque, (self.speed / 40) ** 2 * turning] if order == 2 else by_torque

    def columns(self, order: int, poles: Sequence[tuple[float, float]] = ()) -> ComplexArray:
        """Each force of an order, plain and through each mode, (columns, n)."""
        forces = self.forces(order)
        through = (mode_response(u, pole, self.rate) for pole in poles for u in forces)
        out = np.empty((len(forces) * (1 + len(poles)), self.turns.size), complex)
        for row, u in zip(out, chain(forces, through), strict=True):
            row[:] = remove_running_mean(u, self.rate)
        return out


def estimate_lag(
    option: SpeedAlignment, scene: SampledShaftMotion, y: FloatArray, *, most: float
) -> SpeedAlignment:
    """Return the option with the lag by which its response is most like one mode's, and how surely.

    Over a band of some hertz a lag is a phase, so bands alone hardly know it; over all of
    them it is a phase that runs on with frequency, which no oscillator's does. Below a mode or
    over a few hertz the two look alike: then the interval is wide, and of what it holds no lag
    at all is taken for likeliest. `scene` is what turns so, y (n,) the stress.
    """
    f, h, w = _response_in_fine_bands(scene, y)
    if f.size < 5:
        return replace(option, lag_interval=(-most, most))
    # A mode passed slowly is late by itself, and has put the option far from where it is.
    first, last = sorted((0.0, round(option.lag, 4)))
    lags = np.round(np.arange(first - 0.1, last + 0.1001, 0.005), 6)
    lags = lags[np.abs(lags) <= most + 1e-9]
    turned = (h * w)[:, None] * np.exp(2j * np.pi * np.outer(f, lags - option.lag))
    modes = np.geomspace(max(f.min() * 0.7, 3.0), f.max() * 1.3, 42)
    one = _mode_responses(f, modes, (0.012, 0.025, 0.05, 0.1, 0.2))
    plain = np.stack([np.ones_like(f), (f / 80) ** 2]) * np.ones((len(one), 1, 1))
    rows = np.concatenate([plain, one[:, None]], 1) * w
    energy, left, alike = _unexplained_energy(rows, turned)
    if alike > MIN_RESIDUAL_BAND_CORRELATION:
        # Another next to it: of some lags' best one, and fewer to choose from.
        other = _mode_responses(f, modes[::3], (0.02, 0.06, 0.15))
        best = np.unique(np.append(energy[:, ::8].argmax(0), energy[:, left.argmin()].argmax()))
        pairs = np.concatenate(
            [np.repeat(rows[best], len(other), 0), np.tile(other * w, (len(best), 1))[:, None]], 1
        )
        _, left, alike = _unexplained_energy(pairs, turned)
    # Of two numbers a band, three responses, a mode and a lag: what chance leaves, 9 times in 10.
    # What goes on from band to band is other modes', and many bands then say what one does.
    free = max((2 * f.size - 9) * (1 - alike) / (1 + alike), 1.0)
    chance = 1 + 2.7 * (1 + 4 / free) / free
    likely = left <= chance * left.min()
    low, high = (float(lags[likely][end]) for end in (0, -1))
    # Beyond the range searched nothing is known.
    low = -most if likely[0] else max(low - MIN_LAG_UNCERTAINTY_S, -most)
    high = most if likely[-1] else min(high + MIN_LAG_UNCERTAINTY_S, most)
    best = 0.0 if low <= 0 <= high else float(lags[left.argmin()])
    return replace(option, lag=best, lag_interval=(low, high))


def _unexplained_energy(rows: np.ndarray, z: ComplexArray) -> tuple[FloatArray, FloatArray, float]:
    """Energies (choices, k) of each z (n, k) that choices of rows (choices, m, n) explain.

    With what the best leaves of each (k,), and how far what is least goes on from band to band.
    """
    energy = explained_energy(rows, z)
    left = np.maximum((np.abs(z) ** 2).sum(0) - energy.max(0), 0.0)
    k = int(left.argmin())
    own = rows[int(energy[:, k].argmax())]
    rest = z[:, k] - np.linalg.lstsq(own.T, z[:, k], rcond=None)[0] @ own
    size = max(float(np.vdot(rest, rest).real), 1e-300)
    return energy, left, max(float(np.vdot(rest[:-1], rest[1:]).real) / size, 0.0)


def _mode_responses(f: FloatArray, modes: FloatArray, dampings: Sequence[float]) -> ComplexArray:
    """Response (modes dampings, n) of each mode at frequencies f (n,), both Hz."""
    r, damping = f / modes[:, None], np.array(dampings)[:, None, None]
    return (1 / (1 - r**2 + 2j * damping * r)).reshape(-1, f.size)


def _response_in_fine_bands(
    scene: SampledShaftMotion, y: FloatArray
) -> tuple[FloatArray, ComplexArray, FloatArray]:
    """Return frequencies Hz of bands, an order's response in each, and the weight of that.

    As narrow as a lightly damped mode is wide: over a wider one its phase has no mean.
    """
    f = 2 * scene.speed
    driven = f > MIN_ORDER_FREQUENCY_HZ
    band = (np.log(f[driven] / MIN_ORDER_FREQUENCY_HZ) / RELATIVE_BAND_WIDTH_FOR_LAG_SEARCH).astype(
        np.int64
    )
    met = (y * scene.torque * unit_phasor_of_turns(-2 * scene.turns))[driven]
    power = np.bincount(band, scene.torque[driven] ** 2)
    busy = power > 1e-3 * power.sum()
    line = (np.bincount(band, met.real) + 1j * np.bincount(band, met.imag))[busy]
    middle = np.bincount(band, f[driven])[busy] / np.bincount(band)[busy]
    return middle, line / power[busy], np.sqrt(power[busy])


def remove_running_mean(x: np.ndarray, rate: float) -> np.ndarray:
    """Take the running mean of a second off, as linear in x as it is: (n,)."""
    half = max(round(0.5 * rate), 1)
    mean = running_mean(x, half)
    return np.subtract(x, mean, out=mean)


def mode_response(u: ComplexArray, pole: tuple[float, float], rate: float) -> ComplexArray:
    """Response of one mode (Hz, damping) to a turning force (n,), scaled to about one."""
    w = 2 * np.pi * pole[0]
    p = np.exp(w * (-pole[1] + 1j * np.sqrt(1 - pole[1] ** 2)) / rate)
    return first_order_filter((1 - abs(p)) * u[None], p)[0]
