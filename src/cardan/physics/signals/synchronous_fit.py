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

import numpy as np
import numpy.typing as npt

from cardan.core.arrays import BoolArray, ComplexArray, FloatArray, IntArray
from cardan.physics.signals.order_kernels import (
    modal_response,
    running_mean,
    unit_phasor_of_turns,
)
from cardan.physics.signals.speed_alignment import (
    CONSTANT_RESPONSE_BAND_WIDTH_HZ,
    MIN_ORDER_FREQUENCY_HZ,
    SampledShaftMotion,
    explained_energy,
)

CONSTANT_GAIN_BLOCK_S = 6.0
"""Seconds over which the response may wander: geometry rides with the springs."""
IMPACT_MARGIN_S = 0.25
"""Seconds before and after what stands out, that belong to a blow."""
MIN_MODE_ENERGY_SHARE = 0.04
"""Share of the fit's energy that a mode has to add."""
MIN_MODE_SEARCH_ENERGY_GAIN_SHARE = 1e-4
"""Of that energy, which a better place of a mode would add, below which its own is good enough."""
CONTROL_ORDER_OFFSETS_BINS = (4.5, 6.5, 9.0, 12.0, 15.5, 19.5, 24.0, 29.0)
"""Distances of the phantoms, resolution cells to either side."""
CROSS_PREDICTION_STRETCH_S = 9.0
"""Seconds of a stretch that is predicted from its neighbours."""
MIN_DETECTION_F_STATISTIC = 15.0
"""F from which something is locked: without joints the search over ratios reached 14."""
SAMPLES_PER_MATRIX_PRODUCT_BLOCK = 1 << 15
"""Samples of columns that are multiplied at once."""
RELATIVE_RIDGE_REGULARISATION = 1e-9
"""Of a fit's own size, that is put on its diagonal."""
DEMODULATED_RATE_HZ = 50.0
"""Samples a second at which an order is searched for modes: they remember tenths of one."""

# --------------------------------------------------------------------------- speed


# --------------------------------------------------------------------------- response


def _real_rows(columns: ComplexArray) -> FloatArray:
    return np.concatenate([columns.real, -columns.imag])


def _gram_matrix(columns: ComplexArray) -> FloatArray:
    """Products of the `_real` rows of columns (k, n), (2k, 2k): a part of them at a time."""
    parts = (
        _real_rows(columns[:, k : k + SAMPLES_PER_MATRIX_PRODUCT_BLOCK])
        for k in range(0, columns.shape[1], SAMPLES_PER_MATRIX_PRODUCT_BLOCK)
    )
    return sum((rows @ rows.T for rows in parts), np.zeros((2 * len(columns),) * 2))


def _right_hand_side(columns: ComplexArray, y: FloatArray) -> FloatArray:
    """Products of those rows with y (n,), (2k,)."""
    met = columns @ y
    return np.concatenate([met.real, -met.imag])


def least_squares(
    columns: ComplexArray, y: FloatArray, *, ridge: float = RELATIVE_RIDGE_REGULARISATION
) -> tuple[ComplexArray, float]:
    """Coefficients of y ≈ Re Σ c X by least squares, and the energy explained."""
    rows = _real_rows(columns)
    c, energy = _solve_normal_equations(rows @ rows.T, rows @ y, ridge=ridge)
    return _complex_coefficients(c), float(energy)


def _complex_coefficients(c: FloatArray) -> ComplexArray:
    """Coefficients of columns from those of their `_real` rows."""
    m = c.size // 2
    return c[:m] + 1j * c[m:]


@dataclass(frozen=True)
class _DemodulatedOrder:
    """An order as its shaft sees it: what turns with the order stands still.

    A search evaluates many modes, and seen so, some samples a second say as much of each as
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
        """Each force, plain and through each mode (columns, m), all of it `shift` Hz away."""
        time = np.arange(self.speed.size) / self.rate
        beside = unit_phasor_of_turns(shift * time)
        turning = self.turning.by(beside, shift)
        back = np.conj(self.turn)
        each = [self.loads * beside, *(turning.through(poles) * back)]
        return np.concatenate(each).astype(np.complex128)

    @cached_property
    def turning(self) -> "_RotatingForces":
        """The same forces as they turn."""
        return _RotatingForces(
            self.rate, self.loads * self.turn, np.asarray(1j * self.speed, np.complex128),
            np.exp(-1j * self.speed / self.rate),
        )  # fmt: skip


@dataclass(frozen=True)
class _RotatingForces:
    """Forces (forces, m) that turn at i speeds (m,) rad/s, at a rate Hz, and their steps back."""

    rate: float
    forces: ComplexArray
    spin: ComplexArray
    step_back: ComplexArray

    def by(self, beside: ComplexArray, shift: float) -> "_RotatingForces":
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
        return modal_response(
            self.forces, self.spin, self.step_back, p, np.exp(p / self.rate), w * damping
        )


def _demodulate_order(scene: SampledShaftMotion, order: int) -> _DemodulatedOrder:
    """Return an order of a scene as its shaft sees it."""
    every = max(int(scene.rate / DEMODULATED_RATE_HZ), 1)
    m = scene.turns.size // every
    middle = slice(every // 2, m * every, every)
    turning = unit_phasor_of_turns(order * scene.turns[: m * every])
    loads = [scene.torque, (scene.speed / 40) ** 2] if order == 2 else [scene.torque]
    return _DemodulatedOrder(
        every, scene.rate / every, np.conj(turning), turning[middle],
        2 * np.pi * order * scene.speed[middle], np.stack(loads)[:, middle],
    )  # fmt: skip


def _complex_least_squares(
    columns: ComplexArray, z: ComplexArray, *, ridge: float = RELATIVE_RIDGE_REGULARISATION
) -> tuple[ComplexArray, float]:
    """Coefficients of z ≈ Σ c X by least squares, and the energy explained."""
    back = np.conj(columns)
    c, energy = _solve_normal_equations(back @ columns.T, back @ z, ridge=ridge)
    return c, float(energy)


def _solve_normal_equations(
    gram: np.ndarray, right: np.ndarray, *, ridge: float
) -> tuple[np.ndarray, FloatArray]:
    """Solve normal equations (..., k, k): coefficients (..., k), and the energy explained (...)."""
    scale = np.sqrt(np.maximum(np.real(np.diagonal(gram, axis1=-2, axis2=-1)), 1e-300))
    gram = gram / (scale[..., None, :] * scale[..., None])
    gram = gram + ridge * np.eye(scale.shape[-1])
    c = np.linalg.solve(gram, (right / scale)[..., None])[..., 0] / scale
    return c, np.real((np.conj(c) * right).sum(-1))


def band_energies(scene: SampledShaftMotion, y: FloatArray, order: int) -> FloatArray:
    """Energy (forces,) that each force of an order explains alone, its response one in each band.

    Rougher than `fit_order`, which knows what a mode remembers, and a twentieth of its work.
    """
    slow = _demodulate_order(scene, order)
    z, band = (
        slow.met(y),
        (slow.speed / (2 * np.pi * CONSTANT_RESPONSE_BAND_WIDTH_HZ)).astype(np.int64),
    )
    energy: list[float] = []
    for u in slow.loads:
        met = np.bincount(band, z.real * u) ** 2 + np.bincount(band, z.imag * u) ** 2
        power = np.bincount(band, u * u)
        energy.append(float((met[power > 0] / power[power > 0]).sum()))
    return np.array(energy)


def _fit_with_free_phases(
    columns: ComplexArray, z: ComplexArray, stretch: IntArray
) -> tuple[ComplexArray, float]:
    """Fit as `_complex_least_squares`, each stretch (m,) turned by a phase of its own."""
    c, energy = _complex_least_squares(columns, z)
    if not stretch.any():
        return c, energy
    for _ in range(4):
        met = np.conj(c @ columns) * z
        along = np.bincount(stretch, met.real) + 1j * np.bincount(stretch, met.imag)
        z = z * np.exp(-1j * np.angle(along))[stretch]
        c, energy = _complex_least_squares(columns, z)
    return c, energy


def _find_modes(
    slow: _DemodulatedOrder, z: ComplexArray, *, most: int, within: tuple[float, float]
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
                gains |= zip(
                    fresh, _solve_normal_equations(gram, right, ridge=1e-6)[1].tolist(), strict=True
                )
            return max((gains[mode], *mode) for mode in modes)

        best, f, d = best_of(_initial_modes(slow, left, within))
        log_step, damp_step, steps = 0.03, 0.5, 0
        while steps < 6:
            up, down, more, less = (
                _shift_mode(f, d, a * log_step, b * damp_step, within)
                for a, b in ((1, 0), (-1, 0), (0, 1), (0, -1))
            )
            better = best_of((up, down, more, less))
            if better[0] > best:
                best, f, d = better
                continue
            # None is better: then parabolas through these say where between them the best is.
            tops = [
                _parabola_peak(gains[one], best, gains[other])
                for one, other in ((up, down), (more, less))
            ]
            (a, _), (b, _) = tops
            best, f, d = best_of(((f, d), _shift_mode(f, d, a * log_step, b * damp_step, within)))
            if sum(gain for _, gain in tops) < MIN_MODE_SEARCH_ENERGY_GAIN_SHARE * (whole + best):
                break
            log_step, damp_step, steps = log_step / 2, damp_step / 2, steps + 1
        if best < MIN_MODE_ENERGY_SHARE * (whole + best):
            break
        poles = (*poles, (f, d))
    return poles


def _shift_mode(
    f: float, d: float, a: float, b: float, within: tuple[float, float]
) -> tuple[float, float]:
    """Return a mode with a frequency and a damping so much larger, by their logarithms."""
    return float(np.clip(f * np.exp(a), *within)), float(np.clip(d * np.exp(b), 0.008, 0.3))


def _parabola_peak(up: float, here: float, down: float) -> tuple[float, float]:
    """Where between a step up and one down a parabola is highest, in steps, and how much higher."""
    bent = max(2 * here - up - down, 1e-300)
    return (up - down) / (2 * bent), (up - down) ** 2 / (8 * bent)


def _initial_modes(
    slow: _DemodulatedOrder, left: ComplexArray, within: tuple[float, float]
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
        energy = explained_energy(rows, (h * w)[:, None])[:, 0]
        found += [(float(e), float(m), damping) for e, m in zip(energy, modes, strict=True)]
    best = sorted(found, reverse=True)[:8]
    return [(m, d) for _, m, d in best] + [(float(m), 0.03) for m in modes[2::5]]


@dataclass(frozen=True)
class OrderFit:
    """One order as fitted: its wave (n,), and what was fitted how.

    Attributes
    ----------
    waveform : (n,)
        Of the order.
    columns : (columns, n)
        Forces, plain and through each of the `modes`, that make it.
    fitted_signal : (n,)
        What they were fitted to: in its blows the fit itself.
    demodulated, stretch : m
        The order as its shaft sees it, and which stretch of the angle each sample is in.
    rate : Hz
        Of n samples.
    """

    order: int
    waveform: ComplexArray
    columns: ComplexArray
    modes: tuple[tuple[float, float], ...]
    fitted_signal: FloatArray
    demodulated: _DemodulatedOrder
    stretch: IntArray
    rate: float

    @cached_property
    def columns_float32(self) -> npt.NDArray[np.complex64]:
        """Return the columns to seven digits."""
        return self.columns.astype(np.complex64)

    @cached_property
    def phantom_fits(self) -> list[tuple[ComplexArray, float]]:
        """Return what the same fit takes from the rest at each phantom: coefficients, energy."""
        rest = self.demodulated.met(self.fitted_signal - self.waveform.real)
        # What stretches of the angle do to a line's width, they do to a phantom's.
        seconds = self.fitted_signal.size / self.rate / (int(self.stretch.max()) + 1)
        return [
            _fit_with_free_phases(
                self.demodulated.columns(self.modes, shift=k / seconds), rest, self.stretch
            )
            for k in (*CONTROL_ORDER_OFFSETS_BINS, *(-p for p in CONTROL_ORDER_OFFSETS_BINS))
        ]

    @cached_property
    def noise(self) -> ComplexArray:
        """Return what the coefficients might have been more (phantoms, columns)."""
        own = self.demodulated.columns(self.modes)
        # What one of these columns is of those: they are scaled, and not followed, alike.
        scale = np.array(
            [_complex_least_squares(one[None], self.demodulated.met(x.real))[0][0]
             for one, x in zip(own, self.columns, strict=True)]
        )  # fmt: skip
        return np.stack([error / scale for error, _ in self.phantom_fits])

    @cached_property
    def f_statistic(self) -> float:
        """Return F: the energy that the order predicts over what the phantoms take."""
        taken = [floor * self.demodulated.every / 2 for _, floor in self.phantom_fits]
        foretold = max(_predicted_energy(self.columns, self.fitted_signal, self.rate), 0.0)
        return foretold / max(float(np.mean(taken)), 1e-30)


def fit_order(scene: SampledShaftMotion, y: FloatArray, order: int, *, most: int) -> OrderFit:
    """Fit one order to y, through so many modes at most."""
    f = order * scene.speed
    driven = f[f > MIN_ORDER_FREQUENCY_HZ]
    top = min(float(np.quantile(driven, 0.995)) * 1.25, 0.45 * scene.rate) if driven.size else 20.0
    low = max(float(np.quantile(driven, 0.02)) * 0.6, 3.0) if driven.size else 3.0
    slow = _demodulate_order(scene, order)
    within = low, max(top, 1.5 * low)
    poles = _find_modes(slow, slow.met(y), most=most, within=within)
    columns = scene.columns(order, poles)
    fit = _fit_robustly(columns, y, scene.rate)
    if fit.rang(len(poles)):
        # No mode's answer is what it leaves: modes are looked for once more, without the blows.
        still = _fit_robustly(scene.columns(order), y, scene.rate, fit.blown)
        fine = np.where(fit.blown, still.wave.real, y)
        poles = _find_modes(slow, slow.met(fine), most=most, within=within)
        columns = scene.columns(order, poles)
        fit = _fit_robustly(columns, y, scene.rate, fit.blown)
    stretch = scene.stretch[: slow.speed.size * slow.every : slow.every]
    return OrderFit(order, fit.wave, columns, poles, fit.y, slow, stretch, scene.rate)


@dataclass(frozen=True)
class _RobustFit:
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
            return float(
                _solve_normal_equations(
                    self.gram[np.ix_(some, some)],
                    self.met[some],
                    ridge=RELATIVE_RIDGE_REGULARISATION,
                )[1]
            )

        mode = np.arange(columns) // each
        whole = energy(mode >= 0)
        return any(
            whole - energy(mode != k) < MIN_MODE_ENERGY_SHARE * whole for k in range(1, 1 + poles)
        )


def _fit_robustly(
    columns: ComplexArray, y: FloatArray, rate: float, blown: BoolArray | None = None
) -> _RobustFit:
    """Fit the columns (k, n) to y (n,) but where it is `blown`; unless known, where blows stand."""
    gram, whole = _gram_matrix(columns), _right_hand_side(columns, y)
    wave = (
        _complex_coefficients(
            _solve_normal_equations(gram, whole, ridge=RELATIVE_RIDGE_REGULARISATION)[0]
        )
        @ columns
    )
    calm, out, rest_of, met = y, np.zeros(y.size, bool), gram, whole
    for _ in range(2):
        rest = y - wave.real
        out = impact_mask(rest, wave.real, rate) if blown is None else blown
        small, some = clip_impacts(rest, rate), columns[:, out]
        # Few samples are cut down or left out: only those are met anew.
        cut = np.flatnonzero(small != rest)
        calm = y.copy()
        calm[cut] = wave.real[cut] + small[cut]
        rest_of = gram - _gram_matrix(some)
        met = (
            whole
            + _right_hand_side(columns[:, cut], calm[cut] - y[cut])
            - _right_hand_side(some, calm[out])
        )
        wave = (
            _complex_coefficients(
                _solve_normal_equations(rest_of, met, ridge=RELATIVE_RIDGE_REGULARISATION)[0]
            )
            @ columns
        )
    return _RobustFit(wave, np.where(out, wave.real, calm), out, rest_of, met)


def impact_mask(rest: FloatArray, fit: FloatArray, rate: float) -> BoolArray:
    """Return where blows stand (n,), five times over the rms of louder seconds, and ring on.

    Where a fit explains as much of it as it leaves, a mode answers what turns past it.
    """
    from scipy.ndimage import maximum_filter1d

    half = max(round(IMPACT_MARGIN_S * rate), 1)
    out = clip_impacts(rest, rate) != rest
    if out.any():
        out = maximum_filter1d(out, 2 * half + 1)
        out &= running_mean(rest**2, half) > running_mean(fit**2, half)
    return out


def clip_impacts(x: FloatArray, rate: float) -> FloatArray:
    """Clip blows (n,): at five times the rms of the louder seconds, their 90 % quantile."""
    second = max(min(round(rate), x.size), 1)
    rows = x[: x.size // second * second].reshape(-1, second)
    loud = 5 * float(np.quantile(np.sqrt((rows**2).mean(-1)), 0.9))
    return np.clip(x, -loud, loud)


def _predicted_energy(columns: ComplexArray, y: FloatArray, rate: float) -> float:
    """Energy that a fit to every other stretch of some seconds explains of the rest.

    What is locked goes on; a ring that happened to be in phase does not come again.
    """
    size = max(round(CROSS_PREDICTION_STRETCH_S * rate), 1)
    stretches = [slice(k, k + size) for k in range(0, y.size, size)]
    rows = _real_rows(columns)
    halves = [(np.zeros((len(rows), len(rows))), np.zeros(len(rows))) for _ in range(2)]
    for k, here in enumerate(stretches):
        gram, right = halves[k % 2]
        gram += rows[:, here] @ rows[:, here].T
        right += rows[:, here] @ y[here]
    total = 0.0
    for one, (gram, right) in (halves, halves[::-1]):
        c, _ = _solve_normal_equations(*one, ridge=3e-3)
        total += float(c @ (2 * right - gram @ c))
    return total


def gain_variation_over_time(
    line: OrderFit, y: FloatArray, rate: float
) -> tuple[FloatArray, ComplexArray, FloatArray]:
    """Gain of each block about one, (blocks,) with its middle, and its standard deviation."""
    n = max(round(CONSTANT_GAIN_BLOCK_S * rate), 1)
    count = max(y.size // n, 1)
    z, rest = line.waveform[: count * n], (y - line.waveform.real)[: count * n]
    time = np.arange(z.size) / rate

    def blocks(x: np.ndarray) -> np.ndarray:
        return x.reshape(count, -1).sum(-1) if x.size == count * n else np.array([x.sum()])

    power = blocks(np.abs(z) ** 2) / 2
    # Where the shaft stands a mode's memory fades to nothing, and says nothing of its gain.
    power = np.maximum(power, 1e-12 * power.max() + 1e-300)
    off = blocks(rest * np.conj(z)) / power
    ghosts = [
        np.abs(
            blocks(rest * np.conj(z * unit_phasor_of_turns(k / CONSTANT_GAIN_BLOCK_S * time)))
            / power
        )
        ** 2
        for k in (-3.5, -2.5, -1.5, 1.5, 2.5, 3.5)
    ]
    noise: FloatArray = np.mean(ghosts, axis=0) + 1e-12
    weight = power / power.sum()
    spread = max(float((weight * (np.abs(off) ** 2 - noise)).sum()), 0.0)
    shrink: FloatArray = spread / (spread + noise)
    middle = (np.arange(count) + 0.5) * n / rate
    gain = np.asarray(1 + off * shrink, np.complex128)
    return np.asarray(middle, float), gain, np.asarray(np.sqrt(shrink * noise), float)
