"""What the joints did to a gauge, as evidence: identified by phase and torque, with its doubt.

A bracket answers whoever shakes it, so a large amplitude at twice the shaft's speed accuses
nobody. Two things tell the joints from a road that shakes the same mode: their force is
locked to the shaft's angle θ, and it goes with its torque T. So the stress is explained by

    j = Re Σ h * u,    u = T e^{2iθ}, Ω² e^{2iθ}, T e^{4iθ}, T e^{6iθ}

in one linear fit over the whole recording, h the bracket's response: static, and up to two
modes that remember. What decides is F, the energy of that fit over what the same fit takes
from the rest at phantoms a few resolution cells away, where nothing is locked. The answer is
the share of damage removed, 1 - D(without j)/D, with an interval.
Source: derived from first principles; Ljung, System Identification (1999), ch. 4 and 9.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cache, cached_property

import numpy as np

from cardan.base.arrays import BoolArray, ComplexArray, FloatArray, IntArray
from cardan.base.said import Said, said
from cardan.fatigue.angle import Angle
from cardan.fatigue.conditioning import bridged
from cardan.fatigue.kernel import remembered
from cardan.fatigue.orders import Rotation

GUILTY, INNOCENT, CANNOT_TELL = "guilty", "innocent", "cannot tell"

ACQUITTED = 0.25
"""Share of the damage up to which they are innocent, at most."""
CONVICTED = 0.35
"""From which they are guilty, at least, if half of it is theirs most likely."""
FOUND = 15.0
"""F from which something is locked: without joints the search over ratios reached 14."""
CLEAR = 60.0
"""F from which the interval is that of the draws alone."""
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
BLOCK = 6.0
"""Seconds over which the response may wander: geometry rides with the springs."""
POLE = 0.04
"""Share of the fit's energy that a mode has to add."""
PHANTOMS = (4.5, 6.5, 9.0, 12.0, 15.5, 19.5, 24.0, 29.0)
"""Distances of the phantoms, resolution cells to either side."""
FORETOLD = 9.0
"""Seconds of a stretch that is foretold from its neighbours."""
DRAWS = 24
"""Of the interval."""
RIDES = 0.2
"""Seconds that hold what a vehicle's ride puts beside an order, 1 to 2.5 Hz off."""
ALOOF = (7.0, 11.0)
"""Hz beside the order where none of that is."""
STANDS_OUT = 0.15
"""Share of the damage by which what is beside the order exceeds what is farther off."""
COMES = 0.55
"""Share of the energy about order 2 from which it comes with the order: innocent lines had 0.33."""
WHOLLY = 0.85
"""Of that share, from which all of it comes with the order: innocent lines had 0.78."""
FOLLOWS = 0.95
"""Of that share, from which what is there follows the shaft, locked or not: no road reached it."""
NO_SQUARE = 1.25
"""Of what goes with the speed's square, that goes with a torque and is no unbalance."""
STRONG = 0.5
"""Of the largest torque, from which it is strong."""
SUDDEN = 0.15
"""Share of the time up to which a strong torque is a matter of seconds."""
BLOW = 1.8
"""Of what half seconds within ten usually reach, from which one holds a blow."""
FOUR_CYLINDERS = 2.0
"""Order of an engine that in direct gear turns as the joints do."""
LOUD = 2.0
"""Of its mean power, that order 2 must have where blows come for these to be its own."""
FEWEST_BLOWS = 4
"""From which they are more than chance."""
TOGETHER = 0.5
"""Correlation from which crests go with order 2: of innocent lines they had 0.31."""
IDLE = 8.0
"""Turns a second below which no engine turns with the shaft: 480 rpm, where it would stall."""
LEFT = 0.85
"""Of that, below which it has let go of the shaft, and takes hold of it elsewhere next time."""
FEWEST_SPELLS = 1.5
"""Of equal weight above idle, that tell anything of what they have in common."""
BESIDES = 5.0
"""Hz from order 2 within which another order takes part in what stands about it."""
FAR = 9.0
"""Hz from order 2 at which half a second does not show it any more."""
SLOWEST = 2.0
"""Frequency below which nothing is told from the load, Hz."""

UNTRUSTED = said("the speed gives no angle to trust: all that is near order 2 may be theirs")
UNLOADED = said("no torque tells when the joints pull: all that is near order 2 may be theirs")
FAINT = said("little is locked to the shaft: the interval is wider by a tenth")
SLIPPING = said("what is locked does not explain the large cycles: the angle may slip")
RATTLING = said("order 6 is locked too, as of rattling contact: they may have done more")
ALIKE = said("an engine order runs with order 2: phase and torque are the same, either did it")
UNHEARD = said(
    "no engine speed and no engine orders are given: an engine of four cylinders in direct gear "
    "does the same as the joints"
)

DOUBLED = said("what goes with the torque turns at twice the speed given: is it the shaft's own?")
HALVED = said("what goes with the torque turns at half the speed given: is it the shaft's own?")
BESIDE = said("more stands close beside order 2 than farther off: angles that ride may hide them")
PASSING = said(
    "what stands about order 2 comes and goes with it, though nothing is locked: angles that ride "
    "may hide them"
)

BRIEF = said(
    "what does the damage comes with a torque of a few seconds: too short to tell whose it is"
)

KNOCKING = said(
    "blows come where order 2 is loud, as of a stop that it reaches: they may be theirs"
)

DOUBTS = (
    UNTRUSTED,
    UNLOADED,
    FAINT,
    SLIPPING,
    RATTLING,
    ALIKE,
    UNHEARD,
    DOUBLED,
    HALVED,
    BESIDE,
    PASSING,
    BRIEF,
    KNOCKING,
)
"""What may widen an interval."""

Damage = Callable[[FloatArray], float]


@dataclass(frozen=True, kw_only=True)
class Evidence:
    """What the joints are answerable for at one gauge.

    Attributes
    ----------
    removed
        Share of the damage that goes with the joints' stress, 1.
    interval
        Low and high of 90 %.
    strength
        F, energy of the fit over that at phantoms; how surely something is locked.
    modes
        Frequency Hz and damping of the bracket's modes that the joints shake.
    ratio, lag : 1 and s
        What the stress says of the speed's scale, and how late it comes.
    doubts
        What widened the interval, a sentence each.
    """

    removed: float
    interval: tuple[float, float]
    strength: float
    modes: tuple[tuple[float, float], ...] = ()
    ratio: float = 1.0
    lag: float = 0.0
    doubts: tuple[Said, ...] = ()

    @property
    def finding(self) -> str:
        """Return "guilty", "innocent" or "cannot tell"."""
        low, high = self.interval
        if low >= CONVICTED and self.removed >= 0.5:
            return GUILTY
        return INNOCENT if high <= ACQUITTED else CANNOT_TELL


@dataclass(frozen=True)
class Identified:
    """The joints' part of a stress, and the evidence for it.

    Attributes
    ----------
    evidence
        What they are answerable for.
    stress : (n,) Pa
        Theirs; nought where nothing locked was found.
    order2 : (n,) Pa
        0-to-peak amplitude of their order 2, as fitted, found or not.
    """

    evidence: Evidence
    stress: FloatArray
    order2: FloatArray


def together(parts: Sequence[Evidence], weights: Sequence[float]) -> Evidence:
    """Return the evidence of stretches as one, each by its share of the damage.

    Ends of intervals are added as they are: what one stretch does not know, the next may not
    either.
    """
    w = np.asarray(weights, float)
    w = w / w.sum() if w.sum() > 0 else np.full(w.size, 1 / max(w.size, 1))
    if len(parts) == 1:
        return parts[0]
    chief = parts[int(np.argmax(w))]
    low, high = (float(w @ [p.interval[k] for p in parts]) for k in (0, 1))
    return replace(
        chief, removed=float(w @ [p.removed for p in parts]), interval=(low, high),
        strength=max(p.strength for p in parts),
        doubts=tuple(dict.fromkeys(d for p in parts for d in p.doubts)),
    )  # fmt: skip


# --------------------------------------------------------------------------- speed


@dataclass(frozen=True)
class _Aligned:
    """One ratio and lag of a rotation, the energy it explains, and the response (bands,) so."""

    ratio: float
    lag: float
    energy: float
    frequency: FloatArray
    response: ComplexArray
    weight: FloatArray
    zeros: FloatArray
    """Turns by which each stretch of the angle goes on from another zero."""


def _aligned(
    y: FloatArray, torque: FloatArray, angle: Angle, rate: float, start: float
) -> list[_Aligned]:
    """Ratios and lags by the energy that T e^{2iθ} explains, the best first, four at most.

    The response is one number in each band of twice the speed, and in each stretch between
    losses of the angle turned by one phase. For each lag all ratios are
    met at once: as a function of the angle, a wrong ratio is a frequency.
    """
    from scipy.fft import fft, next_fast_len

    # Turned back by the shaft, an order stands nearly still: some samples a second say as much.
    every = max(int(rate / MET), 1)
    m = y.size // every
    if m < 100:
        return []
    y, torque = y[: m * every], torque[: m * every]
    back = np.exp(-4j * np.pi * angle.rotation.at(start + np.arange(y.size) / rate))
    moved = (y * torque * back).reshape(m, every).mean(-1)
    square = (torque**2).reshape(m, every).mean(-1)
    step = every / rate
    lags = np.arange(-angle.lag, angle.lag + 1e-9, 0.05 if angle.lag < 0.5 else 0.06)
    shifts = np.unique(np.rint(lags / step).astype(np.int64))
    # The shaft as of the latest lag on to the earliest: a lag is a place in that.
    most, least = max(int(shifts[-1]), 0), min(int(shifts[0]), 0)
    time = start + ((every - 1) / 2 / rate) + (np.arange(m + most - least) - most) * step
    turns, f2 = angle.rotation.at(time), 2 * angle.rotation.speed(time)
    band, bins = (f2 / BAND).astype(np.int64), ((turns - turns[0]) / TURNS).astype(np.int64)
    bands, count = int(band.max()) + 1, int(bins.max()) + 1
    # Each stretch of the angle has bands of its own, which have one phase in common.
    stretch = angle.stretches(np.asarray(time, float))
    many = len(angle.lost) + 1
    band, bands = stretch * bands + band, bands * many
    cell, fast = band * count + bins, f2 > SLOWEST
    prompt = turns[most : most + m]
    size = next_fast_len(3 * count)
    # Two cycles a turn, off by the ratio: OFF is 2 TURNS OFF cycles a bin, in both directions.
    off = np.fft.fftfreq(size) / (2 * TURNS)
    near = np.flatnonzero(np.abs(off) <= OFF)
    place = np.arange(count) + 0.5
    share = np.unique(np.arange(SHARES) * count // SHARES)
    amid = (share + np.append(share[1:], count)) // 2
    found: list[_Aligned] = []
    for shift in shifts:
        own = slice(most - shift, most - shift + m)
        used = np.flatnonzero(fast[own])
        if used.size < 100:
            continue
        lag = float(shift * step)
        here = cell[own][used]
        z = moved[used] * np.exp(4j * np.pi * (prompt[used] - turns[own][used]))
        grid = np.bincount(here, z.real, bands * count) + 1j * np.bincount(
            here, z.imag, bands * count
        )
        slot = band[own][used]
        weight = np.asarray(np.bincount(slot, square[used], bands), float)
        busy = weight > 1e-3 * weight.sum()
        grid, weight = grid.reshape(bands, count)[busy], weight[busy]
        heard = np.bincount(slot, minlength=bands)[busy]
        middle = np.bincount(slot, f2[own][used], bands)[busy] / heard
        which = np.divmod(np.flatnonzero(busy), bands // many)
        # What turns within a bin is averaged: at the ends of the search it loses this much.
        energy = np.zeros(near.size)
        for row, often in zip(grid, weight, strict=True):
            energy += np.abs(fft(row.astype(np.complex64), size)[near]) ** 2 / often
        energy /= np.sinc(2 * TURNS * off[near]) ** 2
        for peak in near[_peaks(energy)[:4]]:
            # Between the lines of the spectrum: a sixth of one is a radian at the ends, and in
            # each of `SHARES` of the whole it is none.
            beside = np.linspace(-0.5, 0.5, 21) / size / (2 * TURNS)
            near_line = np.exp(-4j * np.pi * TURNS * off[peak] * place)
            summed = np.add.reduceat(grid * near_line, share, axis=-1)
            lines: ComplexArray = summed @ np.exp(
                -4j * np.pi * TURNS * np.outer(place[amid], beside)
            )
            fine = off[peak] + beside
            lines /= np.sinc(2 * TURNS * fine)
            sharp = ((np.abs(lines) ** 2) / weight[:, None]).sum(0)
            k = int(np.argmax(sharp))
            zeros, line, power, held = _one_response(lines[:, k], weight, middle, which, many)
            found.append(
                _Aligned(
                    1 + float(fine[k]), lag, float((np.abs(line) ** 2 / power).sum()),
                    held, line / power, power, zeros,
                )
            )  # fmt: skip
    found.sort(key=lambda one: -one.energy)
    kept: list[_Aligned] = []
    made = float(turns[-1] - turns[0])
    cell = 3 / max(2 * made, 1.0)
    for one in found:
        if all(abs(one.ratio - k.ratio) > cell for k in kept):
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


def _punctual(option: _Aligned, *, most: float) -> _Aligned:
    """Return the option with a lag by which its response is most like one mode's.

    Over a band of some hertz a lag is a phase, so bands alone hardly know it; over all of
    them it is a phase that runs on with frequency, which no oscillator's does.
    """
    f, h, w = option.frequency, option.response, np.sqrt(option.weight)
    if f.size < 5:
        return option
    lags = np.arange(-0.06, 0.0601, 0.003)
    lags = lags[np.abs(option.lag + lags) <= most + 1e-9]
    modes = np.geomspace(max(f.min() * 0.7, 3.0), f.max() * 1.3, 36)
    best = (-np.inf, 0.0)
    for late in lags[np.argsort(np.abs(lags))]:
        turned = h * np.exp(2j * np.pi * f * late) * w
        for damping in (0.015, 0.05, 0.15):
            r = f / modes[:, None]
            rows = (
                np.stack(
                    [np.ones_like(r), (f / 80) ** 2 + 0 * r, 1 / (1 - r**2 + 2j * damping * r)], -1
                )
                * w[:, None]
            )
            gram = np.conj(rows.swapaxes(-1, -2)) @ rows
            gram = gram + 1e-6 * np.trace(gram, axis1=-2, axis2=-1)[:, None, None] * np.eye(3)
            right = np.conj(rows.swapaxes(-1, -2)) @ turned
            c = np.linalg.solve(gram, right[..., None])[..., 0]
            energy = float((np.conj(c) * right).real.sum(-1).max())
            # The nearest lag, unless another explains more than chance would.
            if energy > best[0] * 1.002 or best[0] < 0:
                best = (energy, float(late))
    return replace(option, lag=option.lag + best[1])


def _peaks(x: FloatArray) -> IntArray:
    """Places of the local maxima of x on a circle cut open, the highest first."""
    left, right = np.append(-np.inf, x[:-1]), np.append(x[1:], -np.inf)
    at = np.flatnonzero((x >= left) & (x > right))
    return at[np.argsort(-x[at])]


# --------------------------------------------------------------------------- response


@dataclass(frozen=True)
class _Scene:
    """What turns with a shaft (n,): its turns, turns/s and torque, at a rate Hz."""

    turns: FloatArray
    speed: FloatArray
    torque: FloatArray
    rate: float
    stretch: IntArray
    """Of the angle, (n,): each has a zero of its own."""

    def inputs(self, order: int) -> list[ComplexArray]:
        """Return forces locked to an order: by torque, and the second by speed squared too."""
        wave = np.asarray(np.exp(2j * np.pi * order * self.turns), np.complex128)
        by_torque = [self.torque * wave]
        return [*by_torque, (self.speed / 40) ** 2 * wave] if order == 2 else by_torque


def _levelled(x: np.ndarray, rate: float) -> np.ndarray:
    """Take the running mean of a second off, as linear in x as it is: (n,)."""
    half = max(round(0.5 * rate), 1)
    total = np.cumsum(np.concatenate([[0], np.pad(x, (half, half), mode="edge")]))
    return x - (total[2 * half + 1 :] - total[: -2 * half - 1]) / (2 * half + 1)


def _through(u: ComplexArray, pole: tuple[float, float], rate: float) -> ComplexArray:
    """Response of one mode (Hz, damping) to a turning force (n,), scaled to about one."""
    from scipy.signal import lfilter

    w = 2 * np.pi * pole[0]
    p = np.exp(w * (-pole[1] + 1j * np.sqrt(1 - pole[1] ** 2)) / rate)
    return lfilter([1 - abs(p)], [1, -p], u)


def _columns(scene: _Scene, order: int, poles: Sequence[tuple[float, float]]) -> ComplexArray:
    """Each force of an order, plain and through each mode, (columns, n)."""
    forces = scene.inputs(order)
    made = [*forces, *(_through(u, pole, scene.rate) for pole in poles for u in forces)]
    return np.stack([_levelled(u, scene.rate) for u in made])


def _real(columns: ComplexArray) -> FloatArray:
    return np.concatenate([columns.real, -columns.imag])


def _solve(
    columns: ComplexArray, y: FloatArray, *, ridge: float = 1e-9
) -> tuple[ComplexArray, float]:
    """Coefficients of y ≈ Re Σ c X by least squares, and the energy explained."""
    rows = _real(columns)
    gram, right = rows @ rows.T, rows @ y
    scale = np.sqrt(np.maximum(np.diag(gram), 1e-300))
    gram = gram / np.outer(scale, scale) + ridge * np.eye(scale.size)
    c = np.linalg.solve(gram, right / scale) / scale
    m = len(columns)
    return c[:m] + 1j * c[m:], float(c @ right)


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
        turned = x[: self.back.size] * self.back
        return 2 * turned.reshape(-1, self.every).mean(-1)

    def columns(self, poles: Sequence[tuple[float, float]], *, shift: float = 0.0) -> ComplexArray:
        """Each force, plain and through each mode (columns, m), all of it `shift` Hz beside."""
        time = np.arange(self.speed.size) / self.rate
        beside = np.exp(2j * np.pi * shift * time)
        turning = self.turning.by(beside, shift)
        back = np.conj(self.turn)
        each = [self.loads * beside, *(turning.through(p) * back for p in poles)]
        return np.concatenate(each).astype(np.complex128)

    @cached_property
    def turning(self) -> "_Turning":
        """The same forces as they turn."""
        return _Turning(
            self.rate, self.loads * self.turn, self.speed, np.exp(-1j * self.speed / self.rate)
        )


@dataclass(frozen=True)
class _Turning:
    """Forces (forces, m) that turn at speeds (m,) rad/s, at a rate Hz, and their steps back."""

    rate: float
    forces: ComplexArray
    speed: FloatArray
    step_back: ComplexArray

    def by(self, beside: ComplexArray, shift: float) -> "_Turning":
        """Return them turned `beside` by as many Hz as the shift."""
        faster = 2 * np.pi * shift
        return replace(
            self, forces=self.forces * beside, speed=self.speed + faster,
            step_back=self.step_back * np.exp(-1j * faster / self.rate),
        )  # fmt: skip

    def through(self, pole: tuple[float, float]) -> ComplexArray:
        """Response (forces, m) of one mode (Hz, damping), scaled to about one."""
        w = 2 * np.pi * pole[0]
        p = w * (-pole[1] + 1j * np.sqrt(1 - pole[1] ** 2))
        stays = np.exp(p / self.rate)
        # A steady force is followed exactly.
        gain = (w * pole[1]) * (stays * self.step_back - 1) / (p - 1j * self.speed)
        return remembered(self.forces * gain, stays)


SLOW = 50.0
"""Samples a second at which an order is searched for modes: they remember tenths of one."""


def _slow(scene: _Scene, order: int) -> _Slow:
    """Return an order of a scene as its shaft sees it."""
    every = max(int(scene.rate / SLOW), 1)
    m = scene.turns.size // every
    middle = slice(every // 2, m * every, every)
    angle = 2 * np.pi * order * scene.turns[: m * every]
    loads = [scene.torque, (scene.speed / 40) ** 2] if order == 2 else [scene.torque]
    return _Slow(
        every, scene.rate / every, np.exp(-1j * angle), np.exp(1j * angle[middle]),
        2 * np.pi * order * scene.speed[middle], np.stack(loads)[:, middle],
    )  # fmt: skip


def _fitted(
    columns: ComplexArray, z: ComplexArray, *, ridge: float = 1e-9
) -> tuple[ComplexArray, float]:
    """Coefficients of z ≈ Σ c X by least squares, and the energy explained."""
    return _explained(np.conj(columns) @ columns.T, np.conj(columns) @ z, ridge=ridge)


def _explained(
    gram: ComplexArray, right: ComplexArray, *, ridge: float
) -> tuple[ComplexArray, float]:
    """Solve normal equations: coefficients, and the energy explained."""
    scale = np.sqrt(np.maximum(np.diag(gram).real, 1e-300))
    gram = gram / np.outer(scale, scale) + ridge * np.eye(scale.size)
    c = np.linalg.solve(gram, right / scale) / scale
    return c, float((np.conj(c) @ right).real)


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
    base = slow.columns(())
    for _ in range(most):
        q, _ = np.linalg.qr(base.T)
        left = z - q @ (np.conj(q.T) @ z)
        whole = float((np.abs(z) ** 2).sum() - (np.abs(left) ** 2).sum())
        # What is known already and what is left, as they turn.
        known = np.conj(np.concatenate([q.T, left[None]]) * slow.turn).T

        @cache
        def gain(pole: tuple[float, float], known: ComplexArray = known) -> float:
            """Energy that the order through one more mode explains of what is left."""
            rows = slow.turning.through(pole)
            met = rows @ known
            theirs, right = met[:, :-1], np.conj(met[:, -1])
            gram = np.conj(rows @ np.conj(rows.T) - theirs @ np.conj(theirs.T))
            return _explained(gram, right, ridge=1e-6)[1]

        best, f, d = max((gain(pole), *pole) for pole in _likely(slow, left, within))
        log_step, damp_step, steps = 0.03, 0.5, 0
        while steps < 6:
            options = [
                (
                    float(np.clip(f * np.exp(a * log_step), *within)),
                    float(np.clip(d * np.exp(b * damp_step), 0.008, 0.3)),
                )
                for a, b in ((1, 0), (-1, 0), (0, 1), (0, -1))
            ]
            better = max((gain(o), *o) for o in options)
            if better[0] > best:
                best, f, d = better
            else:
                log_step, damp_step, steps = log_step / 2, damp_step / 2, steps + 1
        if best < POLE * (whole + best):
            break
        poles = (*poles, (float(f), float(d)))
        base = slow.columns(poles)
    return poles


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
    for damping in (0.012, 0.04, 0.12):
        r = middle / modes[:, None]
        rows = np.stack([np.ones_like(r), 1 / (1 - r**2 + 2j * damping * r)], -1) * w[:, None]
        gram = np.conj(rows.swapaxes(-1, -2)) @ rows
        gram = gram + 1e-6 * np.trace(gram, axis1=-2, axis2=-1)[:, None, None] * np.eye(2)
        right = np.conj(rows.swapaxes(-1, -2)) @ (h * w)
        c = np.linalg.solve(gram, right[..., None])[..., 0]
        energy = (np.conj(c) * right).real.sum(-1)
        found += [(float(e), float(m), damping) for e, m in zip(energy, modes, strict=True)]
    best = sorted(found, reverse=True)[:8]
    return [(m, d) for _, m, d in best] + [(float(m), 0.03) for m in modes[2::5]]


@dataclass(frozen=True)
class _Line:
    """One order as fitted: its wave (n,), F, and what it might have been."""

    order: int
    wave: ComplexArray
    columns: ComplexArray
    noise: ComplexArray
    strength: float
    poles: tuple[tuple[float, float], ...]


def _line(scene: _Scene, y: FloatArray, order: int, *, most: int) -> _Line:
    """Fit one order to y, and the same fit to the rest of y at phantoms."""
    f = order * scene.speed
    driven = f[f > SLOWEST]
    top = min(float(np.quantile(driven, 0.995)) * 1.25, 0.45 * scene.rate) if driven.size else 20.0
    low = max(float(np.quantile(driven, 0.02)) * 0.6, 3.0) if driven.size else 3.0
    slow = _slow(scene, order)
    poles = _searched(slow, slow.met(y), most=most, within=(low, max(top, 1.5 * low)))
    columns = _columns(scene, order, poles)
    c, _ = _solve(columns, y)
    fit = (c @ columns).real
    # Once more with the blows cut down, so that none of them is taken for a response.
    y = fit + _limited(y - fit, scene.rate)
    c, _ = _solve(columns, y)
    rest = slow.met(y - (c @ columns).real)
    stretch = scene.stretch[: rest.size * slow.every : slow.every]
    # What stretches of the angle do to a line's width, they do to a phantom's.
    seconds = y.size / scene.rate / (int(scene.stretch.max()) + 1)
    own = slow.columns(poles)
    # What one of these columns is of those: they are scaled, and not followed, alike.
    scale = np.array(
        [_fitted(own[k : k + 1], slow.met(x.real))[0][0] for k, x in enumerate(columns)]
    )
    taken: list[float] = []
    noise: list[ComplexArray] = []
    for k in (*PHANTOMS, *(-p for p in PHANTOMS)):
        error, floor = _freely(slow.columns(poles, shift=k / seconds), rest, stretch)
        taken.append(floor * slow.every / 2)
        noise.append(error / scale)
    strength = max(_foretold(columns, y, scene.rate), 0.0) / max(float(np.mean(taken)), 1e-30)
    return _Line(order, c @ columns, columns, np.stack(noise), strength, poles)


def _limited(x: FloatArray, rate: float) -> FloatArray:
    """Clip blows (n,): at five times the rms of the louder seconds, their 90 % quantile."""
    second = max(min(round(rate), x.size), 1)
    rows = x[: x.size // second * second].reshape(-1, second)
    loud = 5 * float(np.quantile(np.sqrt((rows**2).mean(-1)), 0.9))
    return np.clip(x, -loud, loud)


def _foretold(columns: ComplexArray, y: FloatArray, rate: float) -> float:
    """Energy that a fit to every other stretch of some seconds explains of the rest.

    What is locked goes on; a ring that happened to be in phase does not come again.
    """
    half = np.arange(y.size) // max(round(FORETOLD * rate), 1) % 2 == 0
    total = 0.0
    for one in (half, ~half):
        c, _ = _solve(columns[:, one], y[one], ridge=3e-3)
        other = (c @ columns[:, ~one]).real
        total += float((2 * y[~one] - other) @ other)
    return total


def _wandering(
    line: _Line, y: FloatArray, rate: float
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
        np.abs(blocks(rest * np.conj(z * np.exp(2j * np.pi * k / BLOCK * time))) / power) ** 2
        for k in (-3.5, -2.5, -1.5, 1.5, 2.5, 3.5)
    ]
    noise: FloatArray = np.mean(ghosts, axis=0) + 1e-12
    weight = power / power.sum()
    spread = max(float((weight * (np.abs(off) ** 2 - noise)).sum()), 0.0)
    shrink: FloatArray = spread / (spread + noise)
    middle = (np.arange(count) + 0.5) * n / rate
    gain = np.asarray(1 + off * shrink, np.complex128)
    return np.asarray(middle, float), gain, np.asarray(np.sqrt(shrink * noise), float)


# --------------------------------------------------------------------------- the question


def identified(
    stress: FloatArray,
    *,
    rate: float,
    angle: Angle,
    torque: FloatArray | None,
    damage: Damage,
    engine: Rotation | None = None,
    engine_orders: Sequence[float] = (),
    start: float = 0.0,
    seed: int = 0,
) -> Identified:
    """Ask what the joints did to a stress (n,).

    Parameters
    ----------
    stress : (n,) Pa
        Of the gauge, nan where it is not known.
    rate : Hz
        Of its samples.
    angle
        Of the shaft.
    torque : (n,) N m
        At the shaft; None where nobody measured it.
    damage
        Of a stress (n,).
    engine, engine_orders
        Who else may turn twice a shaft turn: of an engine nobody heard, if its order 2 may be.
    start : s
        Of the first sample, in the time of the rotations.
    seed
        Of the draws.
    """
    filled = bridged(stress)
    every = max(int(rate // 400), 1)
    x, load = _thinned(filled, every), None
    fine = rate / every
    since = np.arange(x.size) / fine
    time = start + since
    if torque is not None:
        load = bridged(torque)[every // 2 :: every][: x.size]
        load = np.pad(load, (0, x.size - load.size), mode="edge")
    if load is None or not np.abs(load).max() > 0:
        load = np.where(angle.rotation.speed(time) > 0.5, 1.0, 0.0)
    load = load / max(float(np.sqrt(np.mean(load**2))), 1e-300)
    angle = angle.within(start, start + x.size / fine)
    y = _levelled(x, fine)
    # What swings with the torque itself is load, whoever turns.
    pull = _levelled(load, fine)
    swinging = pull * float(pull @ y) / max(float(pull @ pull), 1e-300) if torque is not None else 0
    whole = damage(stress)
    options = _aligned(_limited(y, fine), load, angle, fine, start) if whole > 0 else []
    if not options:
        nothing = Evidence(removed=0.0, interval=(0.0, 0.0), strength=0.0)
        return Identified(nothing, np.zeros_like(filled), np.zeros_like(filled))

    def scene(option: _Aligned, of: Angle = angle) -> _Scene:
        shifted = time - option.lag
        stretch = of.stretches(shifted)
        return _Scene(
            option.ratio * of.rotation.at(shifted) + option.zeros[stretch],
            option.ratio * of.rotation.speed(shifted), load, fine, stretch,
        )  # fmt: skip

    def removed(wave: FloatArray) -> float:
        return 1 - damage(stress - _back(wave, every, filled.size)) / whole

    losing = angle.losing(time)

    def besides(wave: FloatArray) -> FloatArray:
        """Return a wave, and all that is near order 2 where the angle is lost."""
        return np.where(losing, _near(x, best, fine, span=RIDES), wave)

    def spread(wave: ComplexArray) -> FloatArray:
        """Amplitude (n,) of a thinned wave at all samples."""
        return np.interp(np.arange(filled.size), np.arange(x.size) * every, np.abs(wave))

    first = _punctual(options[0], most=angle.lag)
    best = scene(first)
    line = _line(best, y, 2, most=2)
    alike = _alike(best, engine, engine_orders, time)
    doubts: list[Said] = []

    def elsewhere(high: float) -> float:
        """Return what may be theirs if the speed is another's, at half or twice the shaft's."""
        for times, doubt in ((2.0, DOUBLED), (0.5, HALVED)):
            scaled = replace(angle.rotation, turns=times * angle.rotation.turns)
            asked = replace(angle, rotation=scaled)
            others = _aligned(_limited(y, fine), load, asked, fine, start)
            if others and others[0].energy > first.energy:
                theirs = _punctual(others[0], most=angle.lag)
                other = _line(scene(theirs, asked), y, 2, most=2)
                # What turns once a turn with the speed's square is unbalance.
                by_torque, by_speed = (_solve(other.columns[k::2], y)[1] for k in (0, 1))
                share = removed(other.wave.real) + 0.05
                clearly = by_speed if torque is None else NO_SQUARE * by_speed
                if other.strength >= FOUND and by_torque > clearly and share > high:
                    high = share
                    doubts.append(doubt)
        return high

    thin = damage(x)

    def among(wave: FloatArray) -> float:
        """Share removed among the thinned samples: how waves differ shows there as well."""
        return 1 - damage(x - wave) / thin if thin > 0 else removed(wave)

    def beside(known: FloatArray, where: FloatArray | float = 1.0) -> tuple[float, float]:
        """Return what goes with all that is close to order 2, and how much less farther off."""
        rest = x - known
        close, *off = (
            among(known + where * _near(rest, best, fine, span=RIDES, beside=b))
            for b in (0.0, *ALOOF, *(-k for k in ALOOF))
        )
        return close, close - max(off)

    def following() -> tuple[float, float] | None:
        """Share, at least and likely, of what follows order 2 where no engine may; None of others.

        It needs no angle: only what turns with the shaft goes through all frequencies with it.
        So does any order of an engine that nobody heard, in some gear.
        """
        if engine is None:
            where = ~_above_idle(best)
        else:
            # Whatever of an engine comes into the band that is looked at, a second off it too.
            may = _running(best, engine, engine_orders, time, within=BESIDES)
            where = ~(_softly(may, fine) > 0)
        if not _coming(x, best, fine, where=where) > FOLLOWS:
            return None
        close, more = beside(np.zeros_like(x), np.where(where, 1.0, 0.0))
        return (more, close) if more > 0 else None

    def sudden(rest: FloatArray, high: float) -> float:
        """Return what may be theirs if it comes with a torque that lasts for seconds only."""
        strong = _strong(load, fine)
        if 0 < strong.mean() < SUDDEN:
            share = removed(np.where(strong, _levelled(rest, fine) - swinging, 0.0) + (x - rest))
            if share > ACQUITTED:
                high = max(high, share + 0.05)
                doubts.append(BRIEF)
        return high

    def passing(rest: FloatArray, high: float) -> float:
        """Return what may be theirs if it comes and goes with order 2 and is not locked to it."""
        if (coming := _coming(rest, best, fine)) > COMES:
            high = max(high, removed(_near(x, best, fine, span=RIDES / 2)) + 0.05)
            if coming > WHOLLY:  # nobody knows what that knocks loose elsewhere
                high = max(high, ACQUITTED + 0.05)
            doubts.append(PASSING)
        return high

    if line.strength < FOUND:
        reach = [removed(line.wave.real)]
        for option in options[1:]:
            other = scene(option)
            c, _ = _solve(columns := _columns(other, 2, ()), y)
            reach.append(removed((c @ columns).real))
        high = 1.3 * max(*reach, 0.0) + 0.03
        if not angle.trusted or torque is None:
            # Who knows no torque does not know where the joints' force turns its sign.
            spans = [removed(_near(x, best, fine, span=span)) for span in (0.5, RIDES)]
            high = max(high, *spans) + 0.05
            doubts.append(UNTRUSTED if not angle.trusted else UNLOADED)
        else:
            close, more = beside(np.zeros_like(x))
            if more > STANDS_OUT:
                high = max(high, close + 0.05)
                doubts.append(BESIDE)
        if losing.any():
            high = max(high, removed(besides(line.wave.real)) + 0.05)
        high = elsewhere(high)
        high = sudden(x, high)
        if angle.trusted and high <= ACQUITTED:
            high = passing(x, high)
        high = float(min(high, 1.0))
        low, likely = 0.0, max(reach[0], 0.0)
        if there := following():
            low, likely = there[0], max(likely, there[1])
            doubts = [*doubts, PASSING]
        middle = float(np.clip(likely, 0.0, high))
        found = Evidence(
            removed=middle, interval=(min(low, high) - 0.01, high), strength=line.strength,
            ratio=first.ratio, lag=first.lag, doubts=tuple(dict.fromkeys(doubts)),
        )  # fmt: skip
        return Identified(found, np.zeros_like(filled), spread(line.wave))
    lines = [line]
    left = y - line.wave.real
    for order in (4, 6):
        more = _line(best, left, order, most=1 if order == 4 else 0)
        if more.strength >= FOUND:
            lines.append(more)
            left = left - more.wave.real
    rng = np.random.default_rng(seed)
    # With the other orders out of the way each is fitted once more, wandering.
    waves: list[tuple[_Line, FloatArray, ComplexArray, FloatArray]] = []
    for one in lines:
        own = left + one.wave.real
        waves.append((one, *_wandering(one, own, fine)))

    def wave(*, draw: bool = False) -> FloatArray:
        total = np.zeros(x.size)
        for one, middle, gain, sigma in waves:
            z = one.wave
            if draw:
                k = one.noise.shape[0]
                mix = (rng.normal(size=k) + 1j * rng.normal(size=k)) / np.sqrt(2 * k)
                z = z + (mix @ one.noise) @ one.columns
                gain = gain + sigma * (
                    rng.normal(size=gain.size) + 1j * rng.normal(size=gain.size)
                ) / np.sqrt(2)
            slow = np.interp(since, middle, gain.real) + 1j * np.interp(since, middle, gain.imag)
            total += (slow * z).real
        return total

    mean = wave()
    middle = removed(mean)
    # How far draws lie from it shows among the thinned samples as well as among all.
    own = among(mean)
    drawn = middle - own + np.array([among(wave(draw=True)) for _ in range(DRAWS)])
    low, high = np.quantile(drawn, [0.05, 0.95])
    # What the model leaves out of a bracket: most where half of the damage is at stake.
    margin = 0.03 + 0.1 * max(middle * (1 - middle), 0.0)
    low, high = min(low, middle) - margin, max(high, middle) + margin
    # What it leaves close to the order, over what it leaves elsewhere, may be theirs as well.
    close, more = beside(mean)
    if more > 0:
        high += min(more, max(close - own, 0.0))
        if more > STANDS_OUT:
            doubts.append(BESIDE)
    if torque is None:
        high = max(high, close)
        doubts.append(UNLOADED)
    if line.strength < CLEAR:
        low, high = low - 0.1, high + 0.1
        if middle > 0.3:  # an angle that slips loses some of what is theirs
            high = max(high, removed(_near(x, best, fine)) + 0.05)
        doubts.append(FAINT)
    if middle < 0:  # theirs taken off does more damage: the angle slips where it matters
        high = max(high, removed(_near(x, best, fine)), 0.05)
        doubts.append(SLIPPING)
    if losing.any():
        high = max(high, removed(besides(mean)))
    if any(one.order == 6 for one in lines):
        high = 1.0 if high > 0.3 else high + 0.3
        doubts.append(RATTLING)
    if not angle.trusted:
        # Something is theirs, and what that knocks loose elsewhere no lost angle can follow.
        high = max(high, removed(_near(x, best, fine)), ACQUITTED + 0.05)
        low = min(low, 0.5 * middle)
        doubts.append(UNTRUSTED)
    if alike is not None:
        own = left + lines[0].wave.real
        # Of an engine that was heard all that runs with it is taken for its own.
        heard = np.where(alike, 0.0, 1.0)
        share = _softly(_surely(alike, lines[0].wave, own) if engine is None else heard, fine)
        sure = removed(mean * share) - margin
        if engine is not None and share.mean() < 0.5:
            sure = min(sure, 0.0)
        if sure < low:
            low = sure
            doubts.append(UNHEARD if engine is None else ALIKE)
    if low < CONVICTED and (there := following()):
        low = max(low, min(there[0], middle))
    high = sudden(x - mean, high)
    if high <= ACQUITTED:
        high = elsewhere(high)
        if angle.trusted and high <= ACQUITTED:
            high = passing(x - mean, high)
    knocks = _knocking(x - mean, line.wave, fine)
    if knocks.any():
        high = max(high, removed(np.where(knocks, y, mean)) + 0.05)
        doubts.append(KNOCKING)
    low, high = (float(v) for v in np.clip([low, high], -1.0, 1.0))
    found = Evidence(
        removed=float(np.clip(middle, low, high)), interval=(low, high),
        strength=line.strength, modes=line.poles, ratio=first.ratio, lag=first.lag,
        doubts=tuple(doubts),
    )  # fmt: skip
    one, middles, gain, _ = waves[0]
    slow = np.interp(since, middles, gain.real) + 1j * np.interp(since, middles, gain.imag)
    return Identified(found, _back(mean, every, filled.size), spread(slow * one.wave))


def _knocking(rest: FloatArray, wave: ComplexArray, rate: float) -> BoolArray:
    """Return the half seconds (n,) of blows, if they come where a wave is loud; else none.

    A stop that the bracket reaches when order 2 swings it knocks of everything that swings
    then, and no line explains a knock; a pothole does not wait for order 2. Where it knocks all
    the time no half second stands out, but all crests rise and fall with the wave.
    """
    from scipy.ndimage import median_filter

    n = max(round(0.5 * rate), 1)
    m = rest.size // n
    found = np.zeros(rest.size, bool)
    if m < 2 * FEWEST_BLOWS:
        return found
    crest = np.abs(_levelled(rest, rate)[: m * n]).reshape(m, n).max(-1)
    loud = (np.abs(wave[: m * n]) ** 2).reshape(m, n).mean(-1)
    blow = crest > BLOW * median_filter(crest, size=41)
    if np.count_nonzero(blow) >= FEWEST_BLOWS and loud[blow].mean() > LOUD * loud.mean():
        found[: m * n] = np.repeat(blow, n)
    high, wide = crest - crest.mean(), loud - loud.mean()
    if high @ wide > TOGETHER * np.sqrt((high @ high) * (wide @ wide)):
        found[: m * n] |= np.repeat(loud > LOUD * loud.mean(), n)
    return found


def _strong(load: FloatArray, rate: float) -> BoolArray:
    """Return when a torque (n,) is near its largest, with half a second to either side."""
    from scipy.ndimage import maximum_filter1d

    size = maximum_filter1d(np.abs(load), max(round(rate), 1), mode="nearest")
    return size > STRONG * size.max()


def _alike(
    scene: _Scene, engine: Rotation | None, orders: Sequence[float], time: FloatArray
) -> BoolArray | None:
    """Return where an engine order may run with order 2 (n,); None where hardly any does.

    An engine that nobody heard may do so above its idle speed, if it has four cylinders.
    """
    if engine is None:
        return _above_idle(scene) if FOUR_CYLINDERS in orders else None
    close = _running(scene, engine, orders, time, within=0.5)
    turning = scene.speed > SLOWEST / 2
    return close if turning.any() and np.mean(close[turning]) >= 0.2 else None


def _running(
    scene: _Scene, engine: Rotation, orders: Sequence[float], time: FloatArray, *, within: float
) -> BoolArray:
    """Return where an order of an engine that was heard runs within some Hz of order 2 (n,)."""
    fe = engine.speed(time)
    f2 = 2 * scene.speed
    # Its channel lags: while the speed changes, what runs as one looks some per cent apart.
    near = np.maximum(within, 0.03 * f2)
    beside = np.any([np.abs(k * fe - f2) < near for k in orders], axis=0)
    return (scene.speed > SLOWEST / 2) & beside


def _above_idle(scene: _Scene) -> BoolArray:
    """Return where an engine may turn with the shaft (n,): from idle up, until it lets go."""
    says = np.where(scene.speed > IDLE, 1, np.where(scene.speed < LEFT * IDLE, -1, 0))
    last = np.maximum.accumulate(np.where(says != 0, np.arange(says.size), 0))
    return says[last] > 0


def _softly(share: FloatArray | BoolArray, rate: float) -> FloatArray:
    """Return a share (n,) that goes over a second from one value to the next."""
    half = max(round(0.5 * rate), 1)
    total = np.cumsum(np.concatenate([[0], np.pad(share, (half, half), mode="edge")]))
    return (total[2 * half + 1 :] - total[: -2 * half - 1]) / (2 * half + 1)


def _surely(may: BoolArray, wave: ComplexArray, y: FloatArray) -> FloatArray:
    """Share (n,) of an order's wave that is no engine's, though one `may` (n,) do the same.

    Where it does it is locked to the shaft as the joints are; but whenever it has let go it
    takes hold of it at another angle. So what all spells have in common is the shaft's own, as
    far as they tell.
    """
    from scipy.special import stdtrit

    spell = np.cumsum(np.diff(may, prepend=False) & may)[may]
    if not spell.size:
        return np.ones(may.size)
    z = wave[may]
    locked = 2 * y[may] * np.conj(z)
    weight, real, imag = (
        np.bincount(spell, v)[1:] for v in (np.abs(z) ** 2, locked.real, locked.imag)
    )
    heard = weight > 0
    w = weight[heard] / max(float(weight.sum()), 1e-300)
    gain = (real + 1j * imag)[heard] / weight[heard]
    mean = complex(w @ gain)
    many = 1 / max(float(w @ w), 1e-300)
    if many < FEWEST_SPELLS or not abs(mean) > 0:
        return np.where(may, 0.0, 1.0)
    # Along the mean lies half of the scatter of a complex number.
    scatter = float(w**2 @ np.abs(gain - mean) ** 2) * many / (many - 1) / 2
    doubt = float(stdtrit(2 * (many - 1), 0.95)) * np.sqrt(scatter) / abs(mean)
    return np.where(may, max(1.0 - doubt, 0.0), 1.0)


def _near(
    x: FloatArray, scene: _Scene, rate: float, *, span: float = 0.5, beside: float = 0.0
) -> FloatArray:
    """Return all (n,) that a span of some seconds holds near order 2: within 0.5/span Hz.

    Of it, or of what is so many Hz `beside` it.
    """
    wave = np.exp(2j * np.pi * (2 * scene.turns + beside / rate * np.arange(x.size)))
    half = max(round(span / 2 * rate), 1)
    z = np.pad(_levelled(x, rate) * np.conj(wave), (half, half), mode="edge")
    total = np.cumsum(np.concatenate([[0], z]))
    mean = (total[2 * half + 1 :] - total[: -2 * half - 1]) / (2 * half + 1)
    return 2 * (mean * wave).real


def _coming(x: FloatArray, scene: _Scene, rate: float, *, where: BoolArray | None = None) -> float:
    """Share of the energy within 3 Hz of order 2 that is not there at other times.

    A road shakes a mode wherever the order is: what half-second periods show at a frequency is
    then how loud the road is, by how the bracket answers there. Both are taken from where the
    order is `FAR` off, and periods in which nobody heard how loud the road was are left
    out; nan where that tells nothing, at steady speed.
    """
    n = max(2 * round(0.25 * rate), 8)
    if x.size < 8 * n:
        return float("nan")
    rows = np.lib.stride_tricks.sliding_window_view(x, n)[:: n // 2]
    level = (rows - rows.mean(-1, keepdims=True)) * np.hanning(n)
    order = 2 * scene.speed[n // 2 :: n // 2][: len(rows)]
    frequency = np.fft.rfftfreq(n, 1 / rate)
    use = (frequency > SLOWEST + 2) & (frequency < min(order.max() + 2 * FAR, 0.45 * rate))
    power = np.abs(np.fft.rfft(level)[:, use]) ** 2
    off = np.abs(frequency[use] - order[:, None])
    far = off > FAR
    heard = far.sum(0) > 8
    far &= heard
    if not far.any() or not power[far].any():
        return float("nan")
    power = power / power[far].max()
    loud = np.ones(len(rows))
    answer: FloatArray = np.zeros(int(np.count_nonzero(use)))
    for _ in range(3):
        answer = (power / loud[:, None] * far).sum(0) / np.maximum(far.sum(0), 1)
        over = np.divide(power, answer, out=np.zeros_like(power), where=far & (answer > 0))
        loud = over.sum(1) / np.maximum(far.sum(1), 1)
        loud = np.maximum(loud, 1e-6 * loud.max())
    told = (far.sum(1) > 1) & (order > SLOWEST + 2)
    if where is not None:
        told &= where[n // 2 :: n // 2][: len(rows)]
    near = (off < 3) & heard & told[:, None]
    there = float(power[near].sum())
    return 1 - float((loud[:, None] * answer)[near].sum()) / there if there > 0 else float("nan")


def _thinned(x: FloatArray, every: int) -> FloatArray:
    """Every so manyth sample (n / every,) of what half of them can hold."""
    if every == 1:
        return x
    from scipy.signal import resample_poly

    return resample_poly(x, 1, every, padtype="line")


def _back(wave: FloatArray, every: int, n: int) -> FloatArray:
    """Return a thinned wave at all samples (n,)."""
    if every == 1:
        return wave
    from scipy.signal import resample_poly

    out = resample_poly(wave, every, 1)[:n]
    return np.pad(out, (0, n - out.size))
