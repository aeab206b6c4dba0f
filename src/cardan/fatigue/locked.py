"""What is locked to a shaft in a stress: which ratio and lag of its speed, and what answers it.

The stress is explained by

    j = Re Σ h * u,    u = T e^{2iθ}, Ω² e^{2iθ}, T e^{4iθ}, T e^{6iθ}

in one linear fit over the whole recording, h the bracket's response: static, and up to two
modes that remember. How surely it is locked says F, the energy of that fit over what the same
fit takes from the rest at phantoms a few resolution cells away, where nothing is locked.
Source: derived from first principles; Ljung, System Identification (1999), ch. 4 and 9.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import chain

import numpy as np
import numpy.typing as npt

from cardan.base.arrays import BoolArray, ComplexArray, FloatArray, IntArray
from cardan.fatigue.angle import Angle
from cardan.fatigue.kernel import answered, gathered, remembered, running_mean
from cardan.fatigue.orders import wave

OFF = 0.05
"""Largest error of a speed's scale that is looked for, relative."""
MET = 100.0
"""Samples a second at which it is looked for."""
SHARES = 64
"""Of the recording, in each of which what is between two lines of its spectrum stands still."""
TURNS = 2.0
"""Turns that are taken together where ratios are looked for: 5 % off turns by 0.2 of a cycle."""
BAND = 2.5
"""Width in frequency over which a response is taken as one, Hz."""
NARROW = 0.03
"""Width of bands that tell a lag from a mode, of their frequency."""
ALONE = 0.3
"""Correlation from band to band of what one mode leaves, from which another is sought beside it."""
BLOCK = 6.0
"""Seconds over which the response may wander: geometry rides with the springs."""
RINGS = 0.25
"""Seconds before and after what stands out, that belong to a blow."""
POLE = 0.04
"""Share of the fit's energy that a mode has to add."""
ENOUGH = 1e-4
"""Of that energy, which a better place of a mode would add, below which its own is good enough."""
PHANTOMS = (4.5, 6.5, 9.0, 12.0, 15.5, 19.5, 24.0, 29.0)
"""Distances of the phantoms, resolution cells to either side."""
FORETOLD = 9.0
"""Seconds of a stretch that is foretold from its neighbours."""
LATE = 0.0075
"""What bands and sampling leave of a lag, s, however surely it is read."""
FOUND = 15.0
"""F from which something is locked: without joints the search over ratios reached 14."""
SLOWEST = 2.0
"""Frequency below which nothing is told from the load, Hz."""
PART = 1 << 15
"""Samples of columns that are multiplied at once."""
RIDGE = 1e-9
"""Of a fit's own size, that is put on its diagonal."""
SLOW = 50.0
"""Samples a second at which an order is searched for modes: they remember tenths of one."""

# --------------------------------------------------------------------------- speed


@dataclass(frozen=True)
class Aligned:
    """One ratio and lag of a rotation, the energy it explains, and the response (bands,) so."""

    ratio: float
    lag: float
    energy: float
    frequency: FloatArray
    response: ComplexArray
    weight: FloatArray
    zeros: FloatArray
    """Turns by which each stretch of the angle goes on from another zero."""
    lags: tuple[float, float] = (-np.inf, np.inf)
    """Between which the lag lies, nine times in ten."""


@dataclass(frozen=True)
class Search:
    """A stress whose order 2 is looked for, and the angle that it is looked for by.

    Attributes
    ----------
    y, torque : (n,)
        The stress, and what the force goes with.
    rate : Hz
        Of both, `start` s when they begin.
    """

    y: FloatArray
    torque: FloatArray
    angle: Angle
    rate: float
    start: float

    @property
    def every(self) -> int:
        """Samples taken together: turned back by the shaft, an order stands nearly still."""
        return max(int(self.rate / MET), 1)

    @property
    def size(self) -> int:
        """How many are left."""
        return self.y.size // self.every

    @cached_property
    def pulled(self) -> FloatArray:
        """Stress times torque, of as many as are taken together (m, every)."""
        n = self.size * self.every
        return (self.y[:n] * self.torque[:n]).reshape(self.size, self.every)

    @cached_property
    def square(self) -> FloatArray:
        """Mean square of the torque (m,)."""
        n = self.size * self.every
        return (self.torque[:n] ** 2).reshape(self.size, self.every).mean(-1)

    @cached_property
    def turns(self) -> FloatArray:
        """Turns made (m every,)."""
        n = self.size * self.every
        return self.angle.rotation.at(self.start + np.arange(n) / self.rate)

    @cached_property
    def shifts(self) -> IntArray:
        """Lags that are looked at, in steps of as many samples as are taken together."""
        lag = self.angle.lag
        lags = np.arange(-lag, lag + 1e-9, 0.05 if lag < 0.5 else 0.06)
        return np.unique(np.rint(lags * self.rate / self.every).astype(np.int64))

    @cached_property
    def around(self) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Times, turns and turns/s from the latest lag on to the earliest: a lag is a place."""
        step = self.every / self.rate
        most, least = max(int(self.shifts[-1]), 0), min(int(self.shifts[0]), 0)
        place = np.arange(self.size + most - least, dtype=float) - most
        time: FloatArray = self.start + (self.every - 1) / 2 / self.rate + place * step
        return time, self.angle.rotation.at(time), self.angle.rotation.speed(time)


def aligned(search: Search, *, times: float = 1.0, over: float = 0.0) -> list[Aligned]:
    """Ratios and lags by the energy that T e^{2iθ} explains, the best first, four at most.

    The response is one number in each band of twice the speed, and in each stretch between
    losses of the angle turned by one phase. For each lag all ratios are
    met at once: as a function of the angle, a wrong ratio is a frequency.

    The angle is taken `times` as far. None are returned where at every fourth lag none explains
    half as much as what it should be `over`: of the energy of a band three lags leave six tenths.
    """
    from scipy.fft import fft, next_fast_len

    m, square, shifts = search.size, search.square, search.shifts
    if m < 100:
        return []
    back = wave(-2 * times * search.turns).reshape(m, -1)
    moved = np.einsum("ij,ij->i", search.pulled, back) / search.every
    step = search.every / search.rate
    most = max(int(shifts[-1]), 0)
    time, turns, f2 = search.around
    turns, f2 = times * turns, 2 * times * f2
    band, bins = (f2 / BAND).astype(np.int64), ((turns - turns[0]) / TURNS).astype(np.int64)
    bands, count = int(band.max()) + 1, int(bins.max()) + 1
    # Each stretch of the angle has bands of its own, which have one phase in common.
    stretch = search.angle.stretches(time)
    many = len(search.angle.lost) + 1
    band, bands = stretch * bands + band, bands * many
    fast = f2 > SLOWEST
    ahead = wave(-2 * turns)
    moved = moved * np.conj(ahead[most : most + m])
    size = next_fast_len(3 * count)
    # Two cycles a turn, off by the ratio: OFF is 2 TURNS OFF cycles a bin, in both directions.
    off = np.fft.fftfreq(size) / (2 * TURNS)
    near = np.flatnonzero(np.abs(off) <= OFF)
    blurred = np.sinc(2 * TURNS * off[near]) ** 2
    # Between the lines of the spectrum: a sixth of one is a radian at the ends, and in each of
    # `SHARES` of the whole it is none.
    beside = np.linspace(-0.5, 0.5, 21) / size / (2 * TURNS)
    share = np.unique(np.arange(SHARES) * count // SHARES)
    each = -(-count // share.size)
    # A row of bins for each share, as long as the longest: where each bin stands among them.
    row = np.searchsorted(share, np.arange(count), "right") - 1
    stands = row * each + np.arange(count) - share[row]
    place = share[:, None] + np.arange(each) + 0.5
    amid = (share + np.append(share[1:], count)) // 2 + 0.5
    turned = np.exp(-4j * np.pi * TURNS * np.outer(amid, beside))
    cell = stands[bins]

    def at(shift: int) -> tuple[FloatArray, list[Aligned]]:
        """Return the energy by ratio at a lag, and the best there."""
        own = slice(most - shift, most - shift + m)
        if np.count_nonzero(fast[own]) < 100:
            return np.zeros(1), []
        weight = np.bincount(band[own], np.where(fast[own], square, 0.0), bands)
        busy = weight > 1e-3 * weight.sum()
        row_of = np.where(busy, np.cumsum(busy) - 1, -1)
        rows = np.where(fast[own], row_of[band[own]], -1)
        many_rows = int(np.count_nonzero(busy))
        grid, (weight, speeds, heard) = gathered(
            np.where(rows < 0, -1, rows * place.size + cell[own]), rows, moved, ahead[own],
            square, f2[own], cells=many_rows * place.size, slots=many_rows,
        )  # fmt: skip
        grid, middle = grid.reshape(many_rows, -1), speeds / heard
        which = np.divmod(np.flatnonzero(busy), bands // many)
        # What turns within a bin is averaged: at the ends of the search it loses this much.
        spectra = fft(grid.astype(np.complex64).take(stands, axis=1), size)[:, near]
        energy = (1 / weight) @ (spectra.real**2 + spectra.imag**2)
        energy /= blurred
        peaks = off[near[_peaks(energy)[:4]]]
        near_line = wave(-2 * TURNS * place[..., None] * peaks)
        summed = grid.reshape(-1, *place.shape).swapaxes(0, 1) @ near_line
        best: list[Aligned] = []
        for peak, met in zip(peaks, summed.T, strict=True):
            lines: ComplexArray = met @ turned
            fine = peak + beside
            lines /= np.sinc(2 * TURNS * fine)
            sharp = ((np.abs(lines) ** 2) / weight[:, None]).sum(0)
            k = int(np.argmax(sharp))
            zeros, line, power, held = _one_response(lines[:, k], weight, middle, which, many)
            explained = float((np.abs(line) ** 2 / power).sum())
            ratio = 1 + float(fine[k])
            best.append(Aligned(ratio, shift * step, explained, held, line / power, power, zeros))
        return energy, best

    # Every fourth lag from the middle one on tells whether the others are worth it.
    coarse = np.arange(shifts.size) % 4 == shifts.size // 2 % 4
    first = [at(int(shift)) for shift in shifts[coarse]]
    if over and not any(energy.max() >= over / 2 for energy, _ in first):
        return []
    others = (at(int(shift)) for shift in shifts[~coarse])
    found = [one for _, best in (*first, *others) for one in best]
    found.sort(key=lambda one: -one.energy)
    kept: list[Aligned] = []
    made = float(turns[-1] - turns[0])
    apart = 3 / max(2 * made, 1.0)
    for one in found:
        if all(abs(one.ratio - k.ratio) > apart for k in kept):
            kept.append(one)
    return kept[:4]


def _one_response(
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


def _of_rows(rows: np.ndarray, z: ComplexArray) -> FloatArray:
    """Energy (..., k) of each z (n, k) that each choice of rows (..., columns, n) explains."""
    back = np.conj(rows)
    gram = back @ rows.swapaxes(-1, -2)
    size = np.trace(gram, axis1=-2, axis2=-1)[..., None, None]
    right = back @ z
    c = np.linalg.solve(gram + 1e-6 * size * np.eye(rows.shape[-2]), right)
    return (np.conj(c) * right).real.sum(-2)


def _peaks(x: FloatArray) -> IntArray:
    """Places of the local maxima of x on a circle cut open, the highest first."""
    left, right = np.append(-np.inf, x[:-1]), np.append(x[1:], -np.inf)
    at = np.flatnonzero((x >= left) & (x > right))
    return at[np.argsort(-x[at])]


# --------------------------------------------------------------------------- response


@dataclass(frozen=True)
class Scene:
    """What turns with a shaft (n,): its turns, turns/s and torque, at a rate Hz."""

    turns: FloatArray
    speed: FloatArray
    torque: FloatArray
    rate: float
    stretch: IntArray
    """Of the angle, (n,): each has a zero of its own."""

    def inputs(self, order: int) -> list[ComplexArray]:
        """Return forces locked to an order: by torque, and the second by speed squared too."""
        turning = wave(order * self.turns)
        by_torque = [self.torque * turning]
        return [*by_torque, (self.speed / 40) ** 2 * turning] if order == 2 else by_torque

    def columns(self, order: int, poles: Sequence[tuple[float, float]] = ()) -> ComplexArray:
        """Each force of an order, plain and through each mode, (columns, n)."""
        forces = self.inputs(order)
        through = (_through(u, pole, self.rate) for pole in poles for u in forces)
        out = np.empty((len(forces) * (1 + len(poles)), self.turns.size), complex)
        for row, u in zip(out, chain(forces, through), strict=True):
            row[:] = levelled(u, self.rate)
        return out


def punctual(option: Aligned, scene: Scene, y: FloatArray, *, most: float) -> Aligned:
    """Return the option with the lag by which its response is most like one mode's, and how surely.

    Over a band of some hertz a lag is a phase, so bands alone hardly know it; over all of
    them it is a phase that runs on with frequency, which no oscillator's does. Below a mode or
    over a few hertz the two look alike: then the interval is wide, and of what it holds no lag
    at all is taken for likeliest. `scene` is what turns so, y (n,) the stress.
    """
    f, h, w = _by_fine_bands(scene, y)
    if f.size < 5:
        return replace(option, lags=(-most, most))
    # A mode passed slowly is late by itself, and has put the option far from where it is.
    first, last = sorted((0.0, round(option.lag, 4)))
    lags = np.round(np.arange(first - 0.1, last + 0.1001, 0.005), 6)
    lags = lags[np.abs(lags) <= most + 1e-9]
    turned = (h * w)[:, None] * np.exp(2j * np.pi * np.outer(f, lags - option.lag))
    modes = np.geomspace(max(f.min() * 0.7, 3.0), f.max() * 1.3, 42)
    one = _modes(f, modes, (0.012, 0.025, 0.05, 0.1, 0.2))
    plain = np.stack([np.ones_like(f), (f / 80) ** 2]) * np.ones((len(one), 1, 1))
    rows = np.concatenate([plain, one[:, None]], 1) * w
    energy, left, alike = _left(rows, turned)
    if alike > ALONE:
        # Another beside it: of some lags' best one, and fewer to choose from.
        other = _modes(f, modes[::3], (0.02, 0.06, 0.15))
        best = np.unique(np.append(energy[:, ::8].argmax(0), energy[:, left.argmin()].argmax()))
        pairs = np.concatenate(
            [np.repeat(rows[best], len(other), 0), np.tile(other * w, (len(best), 1))[:, None]], 1
        )
        _, left, alike = _left(pairs, turned)
    # Of two numbers a band, three responses, a mode and a lag: what chance leaves, 9 times in 10.
    # What goes on from band to band is other modes', and many bands then say what one does.
    free = max((2 * f.size - 9) * (1 - alike) / (1 + alike), 1.0)
    chance = 1 + 2.7 * (1 + 4 / free) / free
    likely = left <= chance * left.min()
    low, high = (float(lags[likely][end]) for end in (0, -1))
    # Beyond what was looked at nobody knows.
    low = -most if likely[0] else max(low - LATE, -most)
    high = most if likely[-1] else min(high + LATE, most)
    best = 0.0 if low <= 0 <= high else float(lags[left.argmin()])
    return replace(option, lag=best, lags=(low, high))


def _left(rows: np.ndarray, z: ComplexArray) -> tuple[FloatArray, FloatArray, float]:
    """Energies (choices, k) of each z (n, k) that choices of rows (choices, m, n) explain.

    With what the best leaves of each (k,), and how far what is least goes on from band to band.
    """
    energy = _of_rows(rows, z)
    left = np.maximum((np.abs(z) ** 2).sum(0) - energy.max(0), 0.0)
    k = int(left.argmin())
    own = rows[int(energy[:, k].argmax())]
    rest = z[:, k] - np.linalg.lstsq(own.T, z[:, k], rcond=None)[0] @ own
    size = max(float(np.vdot(rest, rest).real), 1e-300)
    return energy, left, max(float(np.vdot(rest[:-1], rest[1:]).real) / size, 0.0)


def _modes(f: FloatArray, modes: FloatArray, dampings: Sequence[float]) -> ComplexArray:
    """Response (modes dampings, n) of each mode at frequencies f (n,), both Hz."""
    r, damping = f / modes[:, None], np.array(dampings)[:, None, None]
    return (1 / (1 - r**2 + 2j * damping * r)).reshape(-1, f.size)


def _by_fine_bands(scene: Scene, y: FloatArray) -> tuple[FloatArray, ComplexArray, FloatArray]:
    """Return frequencies Hz of bands, an order's response in each, and the weight of that.

    As narrow as a lightly damped mode is wide: over a wider one its phase has no mean.
    """
    f = 2 * scene.speed
    driven = f > SLOWEST
    band = (np.log(f[driven] / SLOWEST) / NARROW).astype(np.int64)
    met = (y * scene.torque * wave(-2 * scene.turns))[driven]
    power = np.bincount(band, scene.torque[driven] ** 2)
    busy = power > 1e-3 * power.sum()
    line = (np.bincount(band, met.real) + 1j * np.bincount(band, met.imag))[busy]
    middle = np.bincount(band, f[driven])[busy] / np.bincount(band)[busy]
    return middle, line / power[busy], np.sqrt(power[busy])


def levelled(x: np.ndarray, rate: float) -> np.ndarray:
    """Take the running mean of a second off, as linear in x as it is: (n,)."""
    half = max(round(0.5 * rate), 1)
    mean = running_mean(x, half)
    return np.subtract(x, mean, out=mean)


def _through(u: ComplexArray, pole: tuple[float, float], rate: float) -> ComplexArray:
    """Response of one mode (Hz, damping) to a turning force (n,), scaled to about one."""
    w = 2 * np.pi * pole[0]
    p = np.exp(w * (-pole[1] + 1j * np.sqrt(1 - pole[1] ** 2)) / rate)
    return remembered((1 - abs(p)) * u[None], p)[0]


def _real(columns: ComplexArray) -> FloatArray:
    return np.concatenate([columns.real, -columns.imag])


def _gram(columns: ComplexArray) -> FloatArray:
    """Products of the `_real` rows of columns (k, n), (2k, 2k): a part of them at a time."""
    parts = (_real(columns[:, k : k + PART]) for k in range(0, columns.shape[1], PART))
    return sum((rows @ rows.T for rows in parts), np.zeros((2 * len(columns),) * 2))


def _met(columns: ComplexArray, y: FloatArray) -> FloatArray:
    """Products of those rows with y (n,), (2k,)."""
    met = columns @ y
    return np.concatenate([met.real, -met.imag])


def solved(
    columns: ComplexArray, y: FloatArray, *, ridge: float = RIDGE
) -> tuple[ComplexArray, float]:
    """Coefficients of y ≈ Re Σ c X by least squares, and the energy explained."""
    rows = _real(columns)
    c, energy = _explained(rows @ rows.T, rows @ y, ridge=ridge)
    return _paired(c), float(energy)


def _paired(c: FloatArray) -> ComplexArray:
    """Coefficients of columns from those of their `_real` rows."""
    m = c.size // 2
    return c[:m] + 1j * c[m:]


@dataclass(frozen=True)
class _Slow:
    """An order as its shaft sees it: what turns with the order stands still.

    A search asks for many modes, and seen so, some samples a second say as much of each as
    hundreds do.

    Attributes
    ----------
    every
        Samples that are taken together.
    rate : Hz
        Of what is left, m times.
    back : (m every,)
        What turns the order back.
    turn : (m,)
        The order at the middles.
    speed : (m,) rad/s
        Of the order there.
    loads : (forces, m)
        Sizes of the forces of that order.
    """

    every: int
    rate: float
    back: ComplexArray
    turn: ComplexArray
    speed: FloatArray
    loads: FloatArray

    def met(self, x: FloatArray) -> ComplexArray:
        """Return x (n,) as Re z e^{ikθ} near the order: z (m,)."""
        rows = x[: self.back.size].reshape(-1, self.every)
        return np.einsum("ij,ij->i", rows, self.back.reshape(rows.shape)) * (2 / self.every)

    def columns(self, poles: Sequence[tuple[float, float]], *, shift: float = 0.0) -> ComplexArray:
        """Each force, plain and through each mode (columns, m), all of it `shift` Hz beside."""
        time = np.arange(self.speed.size) / self.rate
        beside = wave(shift * time)
        turning = self.turning.by(beside, shift)
        back = np.conj(self.turn)
        each = [self.loads * beside, *(turning.through(poles) * back)]
        return np.concatenate(each).astype(np.complex128)

    @cached_property
    def turning(self) -> "_Turning":
        """The same forces as they turn."""
        return _Turning(
            self.rate, self.loads * self.turn, np.asarray(1j * self.speed, np.complex128),
            np.exp(-1j * self.speed / self.rate),
        )  # fmt: skip


@dataclass(frozen=True)
class _Turning:
    """Forces (forces, m) that turn at i speeds (m,) rad/s, at a rate Hz, and their steps back."""

    rate: float
    forces: ComplexArray
    spin: ComplexArray
    step_back: ComplexArray

    def by(self, beside: ComplexArray, shift: float) -> "_Turning":
        """Return them turned `beside` by as many Hz as the shift."""
        faster = 2j * np.pi * shift
        return replace(
            self, forces=self.forces * beside, spin=self.spin + faster,
            step_back=self.step_back * np.exp(-faster / self.rate),
        )  # fmt: skip

    def through(self, poles: Sequence[tuple[float, float]]) -> ComplexArray:
        """Response (poles, forces, m) of modes (Hz, damping), each scaled to about one."""
        hertz, damping = np.array(poles, float).reshape(-1, 2).T
        w = 2 * np.pi * hertz
        p = w * (-damping + 1j * np.sqrt(1 - damping**2))
        return answered(
            self.forces, self.spin, self.step_back, p, np.exp(p / self.rate), w * damping
        )


def _slow(scene: Scene, order: int) -> _Slow:
    """Return an order of a scene as its shaft sees it."""
    every = max(int(scene.rate / SLOW), 1)
    m = scene.turns.size // every
    middle = slice(every // 2, m * every, every)
    turning = wave(order * scene.turns[: m * every])
    loads = [scene.torque, (scene.speed / 40) ** 2] if order == 2 else [scene.torque]
    return _Slow(
        every, scene.rate / every, np.conj(turning), turning[middle],
        2 * np.pi * order * scene.speed[middle], np.stack(loads)[:, middle],
    )  # fmt: skip


def _fitted(
    columns: ComplexArray, z: ComplexArray, *, ridge: float = RIDGE
) -> tuple[ComplexArray, float]:
    """Coefficients of z ≈ Σ c X by least squares, and the energy explained."""
    back = np.conj(columns)
    c, energy = _explained(back @ columns.T, back @ z, ridge=ridge)
    return c, float(energy)


def _explained(
    gram: np.ndarray, right: np.ndarray, *, ridge: float
) -> tuple[np.ndarray, FloatArray]:
    """Solve normal equations (..., k, k): coefficients (..., k), and the energy explained (...)."""
    scale = np.sqrt(np.maximum(np.real(np.diagonal(gram, axis1=-2, axis2=-1)), 1e-300))
    gram = gram / (scale[..., None, :] * scale[..., None])
    gram = gram + ridge * np.eye(scale.shape[-1])
    c = np.linalg.solve(gram, (right / scale)[..., None])[..., 0] / scale
    return c, np.real((np.conj(c) * right).sum(-1))


def by_bands(scene: Scene, y: FloatArray, order: int) -> FloatArray:
    """Energy (forces,) that each force of an order explains alone, its response one in each band.

    Rougher than `order_line`, which knows what a mode remembers, and a twentieth of its work.
    """
    slow = _slow(scene, order)
    z, band = slow.met(y), (slow.speed / (2 * np.pi * BAND)).astype(np.int64)
    energy: list[float] = []
    for u in slow.loads:
        met = np.bincount(band, z.real * u) ** 2 + np.bincount(band, z.imag * u) ** 2
        power = np.bincount(band, u * u)
        energy.append(float((met[power > 0] / power[power > 0]).sum()))
    return np.array(energy)


def _freely(
    columns: ComplexArray, z: ComplexArray, stretch: IntArray
) -> tuple[ComplexArray, float]:
    """Fit as `_fitted`, each stretch (m,) turned by a phase of its own."""
    c, energy = _fitted(columns, z)
    if not stretch.any():
        return c, energy
    for _ in range(4):
        met = np.conj(c @ columns) * z
        along = np.bincount(stretch, met.real) + 1j * np.bincount(stretch, met.imag)
        z = z * np.exp(-1j * np.angle(along))[stretch]
        c, energy = _fitted(columns, z)
    return c, energy


def _searched(
    slow: _Slow, z: ComplexArray, *, most: int, within: tuple[float, float]
) -> tuple[tuple[float, float], ...]:
    """Modes that an order shakes: each added where it explains most, while it explains enough."""
    poles: tuple[tuple[float, float], ...] = ()
    for _ in range(most):
        q, _ = np.linalg.qr(slow.columns(poles).T)
        left = z - q @ (np.conj(q.T) @ z)
        whole = float((np.abs(z) ** 2).sum() - (np.abs(left) ** 2).sum())
        # What is known already and what is left, as they turn.
        known = np.conj(np.stack([*q.T, left]) * slow.turn)

        gains: dict[tuple[float, float], float] = {}

        def best_of(
            modes: Sequence[tuple[float, float]], *, known: ComplexArray = known,
            gains: dict[tuple[float, float], float] = gains,
        ) -> tuple[float, float, float]:  # fmt: skip
            """Energy that the order through one more mode explains of what is left, and which."""
            fresh = [mode for mode in dict.fromkeys(modes) if mode not in gains]
            # Four at a time: what is followed in step is held at once.
            followed = (
                row
                for k in range(0, len(fresh), 4)
                for row in slow.turning.through(fresh[k : k + 4])
            )
            # One by one: of a few long rows BLAS makes copies first.
            products = [
                ([[row @ one for one in known] for row in rows],
                 [[np.vdot(one, row) for one in rows] for row in rows])
                for rows in followed
            ]  # fmt: skip
            if fresh:
                met, own = (np.array(each) for each in zip(*products, strict=True))
                theirs, right = met[..., :-1], np.conj(met[..., -1])
                gram = np.conj(own - theirs @ np.conj(theirs.swapaxes(-1, -2)))
                gains |= zip(fresh, _explained(gram, right, ridge=1e-6)[1].tolist(), strict=True)
            return max((gains[mode], *mode) for mode in modes)

        best, f, d = best_of(_likely(slow, left, within))
        log_step, damp_step, steps = 0.03, 0.5, 0
        while steps < 6:
            up, down, more, less = (
                _moved(f, d, a * log_step, b * damp_step, within)
                for a, b in ((1, 0), (-1, 0), (0, 1), (0, -1))
            )
            better = best_of((up, down, more, less))
            if better[0] > best:
                best, f, d = better
                continue
            # None is better: then parabolas through these say where between them the best is.
            tops = [
                _top(gains[one], best, gains[other]) for one, other in ((up, down), (more, less))
            ]
            (a, _), (b, _) = tops
            best, f, d = best_of(((f, d), _moved(f, d, a * log_step, b * damp_step, within)))
            if sum(gain for _, gain in tops) < ENOUGH * (whole + best):
                break
            log_step, damp_step, steps = log_step / 2, damp_step / 2, steps + 1
        if best < POLE * (whole + best):
            break
        poles = (*poles, (f, d))
    return poles


def _moved(
    f: float, d: float, a: float, b: float, within: tuple[float, float]
) -> tuple[float, float]:
    """Return a mode with a frequency and a damping so much larger, by their logarithms."""
    return float(np.clip(f * np.exp(a), *within)), float(np.clip(d * np.exp(b), 0.008, 0.3))


def _top(up: float, here: float, down: float) -> tuple[float, float]:
    """Where between a step up and one down a parabola is highest, in steps, and how much higher."""
    bent = max(2 * here - up - down, 1e-300)
    return (up - down) / (2 * bent), (up - down) ** 2 / (8 * bent)


def _likely(
    slow: _Slow, left: ComplexArray, within: tuple[float, float]
) -> list[tuple[float, float]]:
    """Modes to begin a search with: those that fit the response band by band, and some others.

    Bands know nothing of what a mode remembers, so they only say where to look.
    """
    f, u = slow.speed / (2 * np.pi), slow.loads[0]
    band = (f / 1.5).astype(np.int64)
    power = np.bincount(band, u**2)
    busy = np.flatnonzero(power > 1e-3 * power.sum())
    h = (np.bincount(band, left.real * u) + 1j * np.bincount(band, left.imag * u))[busy]
    h = h / power[busy]
    middle = (np.bincount(band, f) / np.maximum(np.bincount(band), 1))[busy]
    w = np.sqrt(power[busy])
    modes = np.geomspace(*within, 44)
    found: list[tuple[float, float, float]] = []
    r = middle / modes[:, None]
    for damping in (0.012, 0.04, 0.12):
        rows = np.stack([np.ones_like(r), 1 / (1 - r**2 + 2j * damping * r)], -2) * w
        energy = _of_rows(rows, (h * w)[:, None])[:, 0]
        found += [(float(e), float(m), damping) for e, m in zip(energy, modes, strict=True)]
    best = sorted(found, reverse=True)[:8]
    return [(m, d) for _, m, d in best] + [(float(m), 0.03) for m in modes[2::5]]


@dataclass(frozen=True)
class Line:
    """One order as fitted: its wave (n,), and what was fitted how.

    Attributes
    ----------
    wave : (n,)
        Of the order.
    columns : (columns, n)
        Forces, plain and through each of the `poles`, that make it.
    y : (n,)
        What they were fitted to: in its blows the fit itself.
    slow, stretch : m
        The order as its shaft sees it, and which stretch of the angle each sample is in.
    rate : Hz
        Of n samples.
    """

    order: int
    wave: ComplexArray
    columns: ComplexArray
    poles: tuple[tuple[float, float], ...]
    y: FloatArray
    slow: _Slow
    stretch: IntArray
    rate: float

    @cached_property
    def coarse(self) -> npt.NDArray[np.complex64]:
        """Return the columns to seven digits."""
        return self.columns.astype(np.complex64)

    @cached_property
    def phantoms(self) -> list[tuple[ComplexArray, float]]:
        """Return what the same fit takes from the rest at each phantom: coefficients, energy."""
        rest = self.slow.met(self.y - self.wave.real)
        # What stretches of the angle do to a line's width, they do to a phantom's.
        seconds = self.y.size / self.rate / (int(self.stretch.max()) + 1)
        return [
            _freely(self.slow.columns(self.poles, shift=k / seconds), rest, self.stretch)
            for k in (*PHANTOMS, *(-p for p in PHANTOMS))
        ]

    @cached_property
    def noise(self) -> ComplexArray:
        """Return what the coefficients might have been more (phantoms, columns)."""
        own = self.slow.columns(self.poles)
        # What one of these columns is of those: they are scaled, and not followed, alike.
        scale = np.array(
            [_fitted(one[None], self.slow.met(x.real))[0][0]
             for one, x in zip(own, self.columns, strict=True)]
        )  # fmt: skip
        return np.stack([error / scale for error, _ in self.phantoms])

    @cached_property
    def strength(self) -> float:
        """Return F: the energy that the order foretells over what the phantoms take."""
        taken = [floor * self.slow.every / 2 for _, floor in self.phantoms]
        foretold = max(_foretold(self.columns, self.y, self.rate), 0.0)
        return foretold / max(float(np.mean(taken)), 1e-30)


def order_line(scene: Scene, y: FloatArray, order: int, *, most: int) -> Line:
    """Fit one order to y, through so many modes at most."""
    f = order * scene.speed
    driven = f[f > SLOWEST]
    top = min(float(np.quantile(driven, 0.995)) * 1.25, 0.45 * scene.rate) if driven.size else 20.0
    low = max(float(np.quantile(driven, 0.02)) * 0.6, 3.0) if driven.size else 3.0
    slow = _slow(scene, order)
    within = low, max(top, 1.5 * low)
    poles = _searched(slow, slow.met(y), most=most, within=within)
    columns = scene.columns(order, poles)
    fit = _calm(columns, y, scene.rate)
    if fit.rang(len(poles)):
        # No mode's answer is what it leaves: modes are looked for once more, without the blows.
        still = _calm(scene.columns(order), y, scene.rate, fit.blown)
        fine = np.where(fit.blown, still.wave.real, y)
        poles = _searched(slow, slow.met(fine), most=most, within=within)
        columns = scene.columns(order, poles)
        fit = _calm(columns, y, scene.rate, fit.blown)
    stretch = scene.stretch[: slow.speed.size * slow.every : slow.every]
    return Line(order, fit.wave, columns, poles, fit.y, slow, stretch, scene.rate)


@dataclass(frozen=True)
class _Calm:
    """A fit of columns to a stress that leaves its blows to themselves.

    Attributes
    ----------
    wave : (n,)
        The fit.
    y : (n,)
        The stress, in its blows the fit, and what else stands out of it cut down.
    blown : (n,)
        Where blows are.
    gram, met : (2 columns, 2 columns), (2 columns,)
        Normal equations of the rest.
    """

    wave: ComplexArray
    y: FloatArray
    blown: BoolArray
    gram: FloatArray
    met: FloatArray

    def rang(self, poles: int) -> bool:
        """Return whether a mode of some adds too little where nothing blows: it rang of blows."""
        if not (poles and self.blown.any()):
            return False
        columns = self.met.size // 2
        each = columns // (1 + poles)

        def energy(kept: BoolArray) -> float:
            some = np.flatnonzero(np.tile(kept, 2))
            return float(_explained(self.gram[np.ix_(some, some)], self.met[some], ridge=RIDGE)[1])

        mode = np.arange(columns) // each
        whole = energy(mode >= 0)
        return any(whole - energy(mode != k) < POLE * whole for k in range(1, 1 + poles))


def _calm(
    columns: ComplexArray, y: FloatArray, rate: float, blown: BoolArray | None = None
) -> _Calm:
    """Fit the columns (k, n) to y (n,) but where it is `blown`; unless known, where blows stand."""
    gram, whole = _gram(columns), _met(columns, y)
    wave = _paired(_explained(gram, whole, ridge=RIDGE)[0]) @ columns
    calm, out, rest_of, met = y, np.zeros(y.size, bool), gram, whole
    for _ in range(2):
        rest = y - wave.real
        out = blowing(rest, wave.real, rate) if blown is None else blown
        small, some = limited(rest, rate), columns[:, out]
        # Few samples are cut down or left out: only those are met anew.
        cut = np.flatnonzero(small != rest)
        calm = y.copy()
        calm[cut] = wave.real[cut] + small[cut]
        rest_of = gram - _gram(some)
        met = whole + _met(columns[:, cut], calm[cut] - y[cut]) - _met(some, calm[out])
        wave = _paired(_explained(rest_of, met, ridge=RIDGE)[0]) @ columns
    return _Calm(wave, np.where(out, wave.real, calm), out, rest_of, met)


def blowing(rest: FloatArray, fit: FloatArray, rate: float) -> BoolArray:
    """Return where blows stand (n,), five times over the rms of louder seconds, and ring on.

    Where a fit explains as much of it as it leaves, a mode answers what turns past it.
    """
    from scipy.ndimage import maximum_filter1d

    half = max(round(RINGS * rate), 1)
    out = limited(rest, rate) != rest
    if out.any():
        out = maximum_filter1d(out, 2 * half + 1)
        out &= running_mean(rest**2, half) > running_mean(fit**2, half)
    return out


def limited(x: FloatArray, rate: float) -> FloatArray:
    """Clip blows (n,): at five times the rms of the louder seconds, their 90 % quantile."""
    second = max(min(round(rate), x.size), 1)
    rows = x[: x.size // second * second].reshape(-1, second)
    loud = 5 * float(np.quantile(np.sqrt((rows**2).mean(-1)), 0.9))
    return np.clip(x, -loud, loud)


def _foretold(columns: ComplexArray, y: FloatArray, rate: float) -> float:
    """Energy that a fit to every other stretch of some seconds explains of the rest.

    What is locked goes on; a ring that happened to be in phase does not come again.
    """
    size = max(round(FORETOLD * rate), 1)
    stretches = [slice(k, k + size) for k in range(0, y.size, size)]
    rows = _real(columns)
    halves = [(np.zeros((len(rows), len(rows))), np.zeros(len(rows))) for _ in range(2)]
    for k, here in enumerate(stretches):
        gram, right = halves[k % 2]
        gram += rows[:, here] @ rows[:, here].T
        right += rows[:, here] @ y[here]
    total = 0.0
    for one, (gram, right) in (halves, halves[::-1]):
        c, _ = _explained(*one, ridge=3e-3)
        total += float(c @ (2 * right - gram @ c))
    return total


def wandering(
    line: Line, y: FloatArray, rate: float
) -> tuple[FloatArray, ComplexArray, FloatArray]:
    """Gain of each block about one, (blocks,) with its middle, and its standard deviation."""
    n = max(round(BLOCK * rate), 1)
    count = max(y.size // n, 1)
    z, rest = line.wave[: count * n], (y - line.wave.real)[: count * n]
    time = np.arange(z.size) / rate

    def blocks(x: np.ndarray) -> np.ndarray:
        return x.reshape(count, -1).sum(-1) if x.size == count * n else np.array([x.sum()])

    power = blocks(np.abs(z) ** 2) / 2
    # Where the shaft stands a mode's memory fades to nothing, and says nothing of its gain.
    power = np.maximum(power, 1e-12 * power.max() + 1e-300)
    off = blocks(rest * np.conj(z)) / power
    ghosts = [
        np.abs(blocks(rest * np.conj(z * wave(k / BLOCK * time))) / power) ** 2
        for k in (-3.5, -2.5, -1.5, 1.5, 2.5, 3.5)
    ]
    noise: FloatArray = np.mean(ghosts, axis=0) + 1e-12
    weight = power / power.sum()
    spread = max(float((weight * (np.abs(off) ** 2 - noise)).sum()), 0.0)
    shrink: FloatArray = spread / (spread + noise)
    middle = (np.arange(count) + 0.5) * n / rate
    gain = np.asarray(1 + off * shrink, np.complex128)
    return np.asarray(middle, float), gain, np.asarray(np.sqrt(shrink * noise), float)
