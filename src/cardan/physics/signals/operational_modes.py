r"""Modes that gauges feel between the orders: from the road's shaking, without knowing the road.

What turns with shaft and engine is masked where it stands in each window's spectrum, window by
window; the rest is shaken by road and vehicle, whose spectra are smooth, and by what answers
them: the modes. About a peak the logarithm of each gauge's density is

$$\ln S_k = l_{wk} + b_k x + c_k x^2 + \ln\frac{(1 + v_k(1 - r^2))^2 + (2 ζ v_k r)^2 + (w_k r)^2}
{(1 - r^2)^2 + (2 ζ r)^2}, \quad r = f / f_0,\ x = \ln r$$

with one level l for each window, so that a blow or a bad mile weighs no more than its second,
what the gauge feels without the mode (v, w: in step with it and not), and f₀, ζ the same at all
gauges; S is met as Hann's window smears it. Logarithms of single lines scatter alike whatever
the level, so least squares is all it takes. Intervals are of 90 %, by drawing blocks of windows.

A mode is reported if it is more than chance, narrower than the band and wider than a line, where
slow and fast windows have it at one frequency (an order that is not given moves), and a wider
band does not move it. What is reported is a mode that the gauges feel: whether of the bracket, of
what hangs in it, or of what it is bolted to, no gauge shows.
Sources: Brincker & Ventura, Introduction to Operational Modal Analysis (2015), ch. 8-10;
Wahba, J. Am. Stat. Assoc. 75 (1980) (the logarithm of a periodogram); Künsch, Ann. Stat. 17
(1989) (blocks); Ewins, Modal Testing (2000), ch. 4.
"""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from cardan.core.arrays import BoolArray, ComplexArray, FloatArray
from cardan.physics.signals.conditioning import interpolate_gaps
from cardan.physics.signals.order_tracking import ShaftRotation
from cardan.physics.signals.recording import rechunk_to_block_size
from cardan.physics.signals.shaft_angle import ShaftAngle

WINDOW_S = 2.0
"""Of a window; neighbours overlap by half."""

MIN_FREQUENCY_HZ, MAX_FREQUENCY_HZ = 10.0, 250.0
"""Hz between which the spectra are kept; at most up to `MAX_FREQUENCY_TO_SAMPLE_RATE`."""

MAX_FREQUENCY_TO_SAMPLE_RATE = 0.36
"""Of the sample rate: above, a logger's filter makes the spectrum."""

MAX_WHEEL_HOP_FREQUENCY_HZ = 16.0
"""Hz below which wheels hop and bodies ride, assumed: what stands out there is not reported."""

MASKED_SHAFT_ORDER_LIST = (1.0, 2.0, 3.0, 4.0, 6.0, 8.0)
"""Of the shaft, masked: unbalance, joints and what rattles."""

ORDER_MASK_HALF_WIDTH_LINES = 4.0
"""Lines to either side of an order that are masked as well: Hann's window lets no more through."""

MAX_WINDOW_GAP_SHARE = 0.1
"""Share of a window that may be missing."""

MAX_WINDOWS = 1200
"""Windows that are kept of a long recording, in blocks spread over it."""

BOOTSTRAP_BLOCK_WINDOWS = 5
"""Adjacent windows that err together."""

BOOTSTRAP_DRAWS = 60
"""Of blocks, for an interval."""

MIN_WINDOWS_PER_LINE = 24
"""Windows from which a line is known."""

LOG_PERIODOGRAM_VARIANCE = np.pi**2 / 6
"""Variance of the logarithm of a line of noise."""

CORRELATED_SPECTRAL_LINE_COUNT = 2.0
"""Lines that err as one: overlapping windows, and Hann's neighbours."""

MIN_PEAK_PROMINENCE_LN, MAX_PEAKS = 0.25, 6
"""Logarithms that a peak rises above what is about it to be looked at, and how many are."""

MAX_LN_POWER_BELOW_LOUD_WINDOWS = 2.5
"""Logarithms of power below the loud windows at which a window is left out: where little shakes
a gauge, its noise has another spectrum."""

MIN_MODE_MISFIT_REDUCTION_VARIANCES = 30.0
"""Misfit, in variances, that a mode has to take away: a bump of chance takes some 15."""

FIT_BAND_NARROWING_FACTOR = 1.35
"""Share of a band, compared with its whole: what a mode moves by between them is doubt."""

FIT_BAND_HALF_WIDTH_IN_DAMPING_RATIOS = 5.0
"""Damping ratios to either side of a peak that are looked at: two and a half half-power widths."""

DAMPING_RATIO_LIMITS = 0.003, 0.15
"""Damping ratios between which a mode is one, and no line and no slope."""

MIN_MODE_HALF_POWER_WIDTH_SPECTRAL_LINES = 0.4
"""Half-power width of a mode, in lines, below which it cannot be distinguished from a tone."""

MIN_TONE_PHASE_COHERENCE_ACROSS_WINDOWS = 0.5
"""How far a line's phase goes on evenly from window to window that do not overlap, from which
a tone stands there: a pump, a compressor, the mains. It is masked like an order."""

MAX_LOG_SPECTRUM_VARIANCE_TO_NOISE_RATIO = 1.2
"""Scatter of the logarithms, over that of noise, from which the spectrum changes its shape with
time: then something moves through it that is not given."""

MAX_SLOW_FAST_DIFFERENCE = 3.5, 0.01
"""Standard deviations, and share, by which slow and fast windows may differ in frequency."""

MAX_RELATIVE_CONFIDENCE_HALF_WIDTHS = 0.03, 0.6
"""Half of the widest interval that is reported, relative, of frequency and damping."""

MIN_RELATIVE_CONFIDENCE_HALF_WIDTHS = 0.01, 0.3
"""Half of the narrowest, relative: what the model leaves out, measured on recordings whose truth
is known (`tests/verify/test_background.py`)."""

DAMPING_LOWER_BOUND_LOG_MARGIN = 0.65
"""As much of a damping ratio's low end: a mode that several shake, one more now and the other then,
looks broader than it is."""


@dataclass(frozen=True)
class OrderFreeSpectra:
    """Spectra of gauges window by window, the lines of orders and holes masked.

    Attributes
    ----------
    frequency : (F,) Hz
        Of the lines.
    lines : (S, G, F) complex
        Of each window at each gauge, in the root of its unit² a hertz.
    known : (S, G, F)
        Which of them no order stands near.
    speed : (S,) turns/s
        Of the shaft, in the mean of each window.
    """

    frequency: FloatArray
    lines: ComplexArray
    known: BoolArray
    speed: FloatArray

    @property
    def line_spacing(self) -> float:
        """Hz from line to line."""
        return float(self.frequency[1] - self.frequency[0])


@dataclass(frozen=True, kw_only=True)
class OperationalMode:
    """A mode that gauges feel.

    Attributes
    ----------
    frequency : low, found, high; Hz
        With the 90 % interval.
    damping : low, found, high; 1
        Damping ratio.
    felt_by_gauge : (G,)
        Which gauges feel it.
    shape : (G,)
        What each feels of it, the largest 1, with its sign.
    """

    frequency: tuple[float, float, float]
    damping: tuple[float, float, float]
    felt_by_gauge: tuple[bool, ...]
    shape: tuple[float, ...]


def order_free_spectra(
    pieces: Iterable[FloatArray], *, rate: float, seconds: float, angle: ShaftAngle,
    engine: ShaftRotation | None = None, engine_orders: Sequence[float] = (),
) -> OrderFreeSpectra:  # fmt: skip
    """Return the spectra of gauges (G, n) that come in pieces, nan where missing.

    Parameters
    ----------
    rate : Hz
        Of the samples.
    seconds : s
        How long the recording is.
    angle
        Of the shaft; where it is lost nothing is known.
    engine, engine_orders
        The engine's rotation, where it was measured, and its orders.
    """
    size = 2 * round(WINDOW_S * rate / 2)
    every = rate / size
    first, last = (
        int(np.ceil(f / every))
        for f in (MIN_FREQUENCY_HZ, min(MAX_FREQUENCY_HZ, MAX_FREQUENCY_TO_SAMPLE_RATE * rate))
    )
    frequency: FloatArray = every * np.arange(first, last, dtype=float)
    hann = 0.5 - 0.5 * np.cos(2 * np.pi * np.arange(size) / size)
    scale = np.sqrt(2 / (rate * (hann**2).sum()))
    whole = max(int(2 * seconds / WINDOW_S) - 1, 0)
    # A block of so many, then a gap: neighbours are drawn together.
    gap = max(int(np.ceil(whole / MAX_WINDOWS)), 1)
    lines: list[ComplexArray] = []
    known: list[BoolArray] = []
    speed: list[float] = []
    place, half = 0, np.empty((0, 0))
    for piece in rechunk_to_block_size(pieces, size=size // 2):
        joined, start = np.concatenate([half, piece], axis=-1) if half.size else piece, place - 1
        half, place = piece, place + 1
        if joined.shape[-1] < size or start // BOOTSTRAP_BLOCK_WINDOWS % gap:
            continue
        middle = (start + 1) * size / 2 / rate
        time = middle + WINDOW_S * np.linspace(-0.5, 0.5, 21)
        lost = angle.is_lost(time).any()
        turning: list[tuple[FloatArray, Sequence[float]]] = [
            (angle.rotation.speed(time), MASKED_SHAFT_ORDER_LIST)
        ]
        if engine is not None:
            turning.append((engine.speed(time), engine_orders))
        free = _between_orders(frequency, turning, aside=ORDER_MASK_HALF_WIDTH_LINES * every) & (
            not lost
        )
        whole_ones = np.isnan(joined).mean(-1) <= MAX_WINDOW_GAP_SHARE
        x = interpolate_gaps(joined)
        spread = np.fft.rfft((x - x.mean(-1, keepdims=True)) * hann, axis=-1)[:, first:last] * scale
        # A gauge that stands still, clipped or frozen, is as deaf as one that is missing.
        heard = whole_ones & (np.abs(spread) > 0).all(-1)
        lines.append(spread)
        known.append(heard[:, None] & free)
        speed.append(float(angle.rotation.speed(time).mean()))
    shape = (len(lines), *(lines[0].shape if lines else (0, frequency.size)))
    spectra = np.array(lines, complex).reshape(shape)
    free = np.array(known, bool).reshape(shape)
    return OrderFreeSpectra(frequency, spectra, free & ~_tone_lines(spectra, free), np.array(speed))


def _tone_lines(lines: ComplexArray, known: BoolArray) -> BoolArray:
    """Return in which lines (G, F) a tone of fixed frequency stands, and those next to them.

    Its phase goes on evenly from a window to the next but one, which do not overlap.
    """
    from scipy.ndimage import maximum_filter1d

    both = known[2:] & known[:-2]
    on = np.where(both, lines[2:] * lines[:-2].conj(), 0.0)
    on = on / np.where(np.abs(on) > 0, np.abs(on), 1.0)
    count = both.sum(0)
    even = (np.abs(on.sum(0)) > MIN_TONE_PHASE_COHERENCE_ACROSS_WINDOWS * np.maximum(count, 1)) & (
        count >= MIN_WINDOWS_PER_LINE
    )
    return (
        maximum_filter1d(even.astype(np.uint8), 2 * int(ORDER_MASK_HALF_WIDTH_LINES) + 1, axis=-1)
        > 0
    )


def _between_orders(
    frequency: FloatArray, turning: Iterable[tuple[FloatArray, Sequence[float]]], *, aside: float
) -> BoolArray:
    """Return which lines (F,) no order of what turns at speeds (n,) turns/s comes near."""
    free = np.ones(frequency.size, bool)
    for speed, orders in turning:
        low, high = float(speed.min()), float(speed.max())
        for k in orders:
            free &= (frequency < k * low - aside) | (frequency > k * high + aside)
    return free


# --------------------------------------------------------------------------- the fit


_LINE_OFFSETS = np.arange(-1.75, 1.76, 0.25)
_IS_UNIT_OFFSET = np.abs(_LINE_OFFSETS) == 1
_HANN_MAIN_LOBE = (
    np.where(
        _IS_UNIT_OFFSET,
        0.5,
        np.sinc(_LINE_OFFSETS) / np.where(_IS_UNIT_OFFSET, 1, 1 - _LINE_OFFSETS**2),
    )
    ** 2
)
_HANN_LINE_WEIGHTS = _HANN_MAIN_LOBE / _HANN_MAIN_LOBE.sum()
"""What a line sees of the power at shares of a line next to it: Hann's window, (cells,)."""

_PRIOR_PRECISIONS = 1 / np.array([3.0, 1.5, 1.5, 1.0]) ** 2
"""Of b, c, v, w, assumed: what the spectrum does not determine stays near zero."""

_DIFFERENCE_STEP = 1e-5


@dataclass(frozen=True)
class _MisfitTerms:
    """All that levels g (G, F) are held against: each gauge's misfit is g Q g - 2 q g + c.

    Each window's own level has been taken out of it.
    """

    Q: FloatArray
    q: FloatArray
    c: FloatArray

    def misfit(self, g: FloatArray) -> FloatArray:
        """In logarithms squared, (G,)."""
        return ((self.Q @ g[..., None])[..., 0] * g - 2 * self.q * g).sum(-1) + self.c


@dataclass(frozen=True)
class _ModeFit:
    """Where least squares ended: logarithms of frequency and damping, what each gauge has."""

    poles: FloatArray  # (poles, 2)
    own: FloatArray  # (2 + 2 poles, G)
    misfit: FloatArray  # (G,)


@dataclass(frozen=True)
class _PeakBand:
    """The spectra of some gauges about a peak.

    Logarithms (S, G, F), which of them are known, and frequencies (F, cells) Hz that a line sees.
    """

    level: FloatArray
    known: BoolArray
    seen: FloatArray

    @property
    def middle(self) -> float:
        """Hz."""
        return float(np.sqrt(self.seen[0].mean() * self.seen[-1].mean()))

    @property
    def size(self) -> int:
        """Gauges."""
        return self.level.shape[1]

    def only(self, gauges: BoolArray) -> "_PeakBand":
        """Return the band of some gauges (G,)."""
        return replace(self, level=self.level[:, gauges], known=self.known[:, gauges])

    def said(self, weight: FloatArray) -> _MisfitTerms:
        """Sum windows up, weighed (S,)."""
        w = weight[:, None, None] * self.known
        count = np.maximum(self.known.sum(-1, keepdims=True), 1)
        level = (self.level - self.level.sum(-1, keepdims=True) / count) * self.known
        shared = np.moveaxis(w / count, 1, 0).swapaxes(-1, -2) @ np.moveaxis(self.known, 1, 0)
        Q = np.eye(w.shape[-1]) * w.sum(0)[:, None] - shared
        return _MisfitTerms(Q, (w * level).sum(0), (w * level**2).sum((0, 2)))

    def model(self, poles: FloatArray, own: FloatArray) -> FloatArray:
        """Return logarithms of densities (G, F)."""
        x = np.log(self.seen / self.middle)
        b, c = own[:2, :, None, None]
        felt = np.exp(b * x + c * x * x)
        for (f, d), (v, w) in zip(
            poles, own[2:, :, None, None].reshape(-1, 2, *b.shape), strict=True
        ):
            r = self.seen / np.exp(f)
            u, both = 1 - r * r, (2 * np.exp(d) * r) ** 2
            felt = felt * ((1 + v * u) ** 2 + both * v * v + (w * r) ** 2) / (u * u + both)
        return np.log(felt @ _HANN_LINE_WEIGHTS)

    def slopes(self, poles: FloatArray, own: FloatArray, g: FloatArray) -> FloatArray:
        """Return the model's derivatives (G, F, numbers): a gauge's own numbers move it alone."""
        J = np.zeros((*g.shape, poles.size + own.size))
        for k, e in enumerate(_DIFFERENCE_STEP * np.eye(poles.size)):
            J[..., k] = (self.model(poles + e.reshape(-1, 2), own) - g) / _DIFFERENCE_STEP
        for k, e in enumerate(_DIFFERENCE_STEP * np.eye(len(own))):
            moved = (self.model(poles, own + e[:, None]) - g) / _DIFFERENCE_STEP
            for i, row in enumerate(moved):
                J[i, :, poles.size + k * self.size + i] = row
        return J

    def least(
        self, said: _MisfitTerms, poles: FloatArray, own: FloatArray, *, steps: int = 30
    ) -> _ModeFit:
        """Return where the misfit is least: Levenberg and Marquardt."""
        m = poles.size
        weak = np.concatenate([_PRIOR_PRECISIONS[:2], *[_PRIOR_PRECISIONS[2:]] * len(poles)])
        prior = (
            LOG_PERIODOGRAM_VARIANCE
            * CORRELATED_SPECTRAL_LINE_COUNT
            * np.concatenate([np.zeros(m), np.repeat(weak, self.size)])
        )

        def parts(x: FloatArray) -> tuple[FloatArray, FloatArray]:
            return x[:m].reshape(-1, 2), x[m:].reshape(-1, self.size)

        def priced(misfit: FloatArray, x: FloatArray) -> float:
            return float(misfit.sum() + (prior * x * x).sum())

        x = np.concatenate([poles.ravel(), own.ravel()])
        g = self.model(poles, own)
        misfit, damp = said.misfit(g), 1e-2
        least = priced(misfit, x)
        for _ in range(steps):
            J = self.slopes(*parts(x), g)
            QJ = said.Q @ J
            H = np.einsum("gfp,gfr->pr", J, QJ, optimize=True) + np.diag(prior)
            slope = (J * said.q[..., None] - QJ * g[..., None]).sum((0, 1)) - prior * x
            for _ in range(8):
                step = np.linalg.solve(H + damp * np.diag(np.diag(H) + 1e-9), slope)
                there = x + np.clip(step, -0.5, 0.5)
                new = self.model(*parts(there))
                left = said.misfit(new)
                if (size := priced(left, there)) < least:
                    break
                damp *= 8
            else:
                break
            gone, x, g, misfit, least, damp = least - size, there, new, left, size, damp / 8
            if gone < 1e-4:
                break
        return _ModeFit(*parts(x), misfit)

    def fitted(
        self, said: _MisfitTerms, pole: FloatArray, beside: _ModeFit | None = None
    ) -> _ModeFit:
        """Fit from one pole, or from one more next to others: by signs of what goes with it."""
        poles, own = (
            (np.empty((0, 2)), np.zeros((2, self.size)))
            if beside is None
            else (beside.poles, beside.own)
        )
        size = 0.3 if beside is None else 1.0
        found = [
            self.least(
                said, np.vstack([poles, pole]),
                np.vstack([own, np.full(self.size, v), np.full(self.size, 0.2)]),
            )
            for v in (size, -size)
        ]  # fmt: skip
        return min(found, key=lambda f: float(f.misfit.sum()))

    def beside(self, said: _MisfitTerms, one: _ModeFit, half: float) -> _ModeFit:
        """Return two poles where they explain more than one, within `half` of a band."""
        f, d = one.poles[0]
        two = [self.fitted(said, np.array([f + away * half, d - 0.5]), one) for away in (-0.4, 0.4)]
        best = min(two, key=lambda found: float(found.misfit.sum()))
        gain = float((one.misfit - best.misfit).sum())
        return (
            best
            if gain
            > MIN_MODE_MISFIT_REDUCTION_VARIANCES
            * LOG_PERIODOGRAM_VARIANCE
            * CORRELATED_SPECTRAL_LINE_COUNT
            else one
        )

    def smooth(self, said: _MisfitTerms) -> FloatArray:
        """Return the misfit (G,) of a spectrum without a mode, a parabola of ln f."""
        x = np.log(self.seen / self.seen.mean()) @ _HANN_LINE_WEIGHTS
        J = np.stack([x, x * x], axis=-1)
        H = J.T @ said.Q @ J + LOG_PERIODOGRAM_VARIANCE * CORRELATED_SPECTRAL_LINE_COUNT * np.diag(
            _PRIOR_PRECISIONS[:2]
        )
        right = said.q @ J
        return said.c - (right * np.linalg.solve(H, right[..., None])[..., 0]).sum(-1)


# --------------------------------------------------------------------------- reported modes


def identify_operational_modes(of: OrderFreeSpectra) -> tuple[OperationalMode, ...]:
    """Return the modes that a background shows, the lowest first."""
    told: list[OperationalMode] = []
    for peak in spectral_peaks(of):
        near = _modes_at_peak(of, peak)
        told += [m for m in near if not any(_is_same_mode(m, one) for one in told)]
    return tuple(sorted(told, key=lambda one: one.frequency[1]))


def _is_same_mode(a: OperationalMode, b: OperationalMode) -> bool:
    return a.frequency[0] <= b.frequency[2] and b.frequency[0] <= a.frequency[2]


def spectral_peaks(of: OrderFreeSpectra) -> FloatArray:
    """Return frequencies Hz at which a gauge's spectrum stands out, the clearest first."""
    from scipy.ndimage import gaussian_filter1d
    from scipy.signal import find_peaks

    found: list[tuple[float, float]] = []
    for lines, known in zip(np.moveaxis(of.lines, 1, 0), np.moveaxis(of.known, 1, 0), strict=True):
        seen = known.sum(0) >= MIN_WINDOWS_PER_LINE
        if np.count_nonzero(seen) < MIN_WINDOWS_PER_LINE:
            continue
        f, mean = (
            of.frequency[seen],
            _mean_log_power(_log_power(lines, known)[:, seen], known[:, seen]),
        )
        # Even in the logarithm of frequency, as modes are.
        even = np.arange(np.log(f[0]), np.log(f[-1]), 0.01)
        level = np.interp(even, np.log(f), mean)
        for width in (2.0, 5.0):
            at, how = find_peaks(gaussian_filter1d(level, width), prominence=MIN_PEAK_PROMINENCE_LN)
            found += zip(how["prominences"].tolist(), np.exp(even[at]).tolist(), strict=True)
    kept: list[float] = []
    for _, f in sorted(found, reverse=True):
        if all(abs(np.log(f / g)) > 0.05 for g in kept):
            kept.append(f)
    return np.array(kept[:MAX_PEAKS])


def _log_power(lines: ComplexArray, known: BoolArray) -> FloatArray:
    """Return the logarithms of lines' powers, 0 where unknown."""
    return np.log(np.where(known, lines.real**2 + lines.imag**2, 1.0))


def _mean_log_power(level: FloatArray, known: BoolArray) -> FloatArray:
    """Return the mean logarithm (F,) over windows (S, F), each freed of its own level."""
    mean = np.zeros(level.shape[-1])
    for _ in range(6):
        own = ((level - mean) * known).sum(-1) / np.maximum(known.sum(-1), 1)
        mean = ((level - own[:, None]) * known).sum(0) / np.maximum(known.sum(0), 1)
    return mean


def _peak_band(of: OrderFreeSpectra, peak: float, half: float) -> _PeakBand | None:
    """Return the spectra about a peak, `half` of it to either side; None where little is known."""
    every = of.line_spacing
    near = np.abs(np.log(of.frequency / peak)) <= max(half, 12 * every / peak)
    lines, known = of.lines[..., near], of.known[..., near]
    # A window of which next to nothing is known shows no level.
    known = known & (known.sum(-1, keepdims=True) >= 0.3 * np.count_nonzero(near))
    level = _log_power(lines, known)
    known = known & _excited_windows(level, known)[..., None]
    f = of.frequency[near]
    often = f[(known.sum(0) >= MIN_WINDOWS_PER_LINE).any(0)]
    # Below, at and above it: what an order hides all the time has no top.
    if not all((np.abs(often / peak - r) < 0.04 + 2 * every / peak).any() for r in (0.9, 1, 1.1)):
        return None
    return _PeakBand(np.where(known, level, 0.0), known, f[:, None] + every * _LINE_OFFSETS)


def _excited_windows(level: FloatArray, known: BoolArray) -> BoolArray:
    """Return in which windows (S, G) gauges are shaken, by logarithms (S, G, F), else 0."""
    count = known.sum(-1)
    own = level.sum(-1) / np.maximum(count, 1)
    columns = zip(own.T, count.T, strict=True)
    top = [np.quantile(x[n > 0], 0.9) if n.any() else 0.0 for x, n in columns]
    return own > np.array(top) - MAX_LN_POWER_BELOW_LOUD_WINDOWS


def _initial_mode(of: OrderFreeSpectra, peak: float) -> tuple[BoolArray, FloatArray, float] | None:
    """Return which gauges (G,) feel a mode at a peak, its pole and the half width of its band."""
    one, pole, half = np.ones(of.speed.size), np.log([peak, 0.03]), 0.3
    felt = np.ones(of.lines.shape[1], bool)
    for _ in range(2):
        band = _peak_band(of, float(np.exp(pole[0])), half)
        if band is None or not (felt := _gauges_with_mode(band, pole)).any():
            return None
        band = band.only(felt)
        pole = band.fitted(band.said(one), pole).poles[0]
        half = float(np.clip(FIT_BAND_HALF_WIDTH_IN_DAMPING_RATIOS * np.exp(pole[1]), 0.12, 0.4))
        if abs(pole[0] - np.log(peak)) > 0.2:
            return None
    return felt, pole, half


def _modes_at_peak(of: OrderFreeSpectra, peak: float) -> Iterator[OperationalMode]:
    """Yield the mode of a peak, and a neighbour that it has to be distinguished from, if any."""
    if (settled := _initial_mode(of, peak)) is None:
        return
    felt, pole, half = settled
    middle = float(np.exp(pole[0]))
    wide, narrow = (_peak_band(of, middle, h) for h in (half, half / FIT_BAND_NARROWING_FACTOR))
    if wide is None or narrow is None:
        return
    wide, narrow, one = wide.only(felt), narrow.only(felt), np.ones(of.speed.size)
    said = wide.said(one)
    found = wide.beside(said, wide.fitted(said, pole), half)
    if (
        found.misfit.sum()
        > MAX_LOG_SPECTRUM_VARIANCE_TO_NOISE_RATIO
        * LOG_PERIODOGRAM_VARIANCE
        * np.count_nonzero(wide.known)
    ):
        return
    good = _is_plausible_mode(of, found) & (np.abs(found.poles[:, 0] - pole[0]) < 0.6 * half)
    if not good.any():
        return
    moved = narrow.least(narrow.said(one), found.poles, found.own).poles - found.poles
    spread, count = _bootstrap_deviations(wide, found, of.speed.size)
    fast = (of.speed > np.median(of.speed)).astype(float)
    slow, quick = (
        wide.least(wide.said(w), found.poles, found.own, steps=8).poles[:, 0]
        for w in (1.0 - fast, fast)
    )
    # Of half the windows each: twice the variance, and twice again of their difference.
    apart = np.abs(quick - slow)
    good &= (apart < 2 * MAX_SLOW_FAST_DIFFERENCE[0] * spread[:, 0]) | (
        apart < MAX_SLOW_FAST_DIFFERENCE[1]
    )
    doubt = np.sqrt(
        (_student_factor(count) * spread) ** 2
        + moved**2
        + np.square(MIN_RELATIVE_CONFIDENCE_HALF_WIDTHS)
    )
    good &= (doubt < MAX_RELATIVE_CONFIDENCE_HALF_WIDTHS).all(-1)
    for k in np.flatnonzero(good):
        (f, d), (df, dd) = found.poles[k], doubt[k]
        low, middle, high = np.exp([f - df, f, f + df]).tolist()
        damping = np.exp(
            [d - float(np.hypot(dd, DAMPING_LOWER_BOUND_LOG_MARGIN)), d, d + dd]
        ).tolist()
        yield OperationalMode(
            frequency=(low, middle, high), damping=(damping[0], damping[1], damping[2]),
            felt_by_gauge=tuple(felt.tolist()), shape=_mode_shape(of, middle),
        )  # fmt: skip


def _student_factor(count: int) -> float:
    """Return standard deviations to either side of a 90 % interval from so many blocks."""
    from scipy.stats import t

    return float(t.ppf(0.95, max(count - 1, 2)))


def _gauges_with_mode(band: _PeakBand, pole: FloatArray) -> BoolArray:
    """Return which gauges (G,) feel a mode there, each fitted alone, at one frequency."""
    one = np.ones(band.level.shape[0])
    worth, at = np.zeros(band.size), np.zeros(band.size)
    for k in range(band.size):
        alone = band.only(np.arange(band.size) == k)
        said = alone.said(one)
        found = alone.fitted(said, pole)
        at[k], damping = found.poles[0]
        if damping < np.log(DAMPING_RATIO_LIMITS[1]):
            worth[k] = (alone.smooth(said) - found.misfit)[0] / (
                LOG_PERIODOGRAM_VARIANCE * CORRELATED_SPECTRAL_LINE_COUNT
            )
    return (worth > MIN_MODE_MISFIT_REDUCTION_VARIANCES) & (
        np.abs(at - at[np.argmax(worth)]) < 0.04
    )


def _is_plausible_mode(of: OrderFreeSpectra, found: _ModeFit) -> BoolArray:
    """Return which poles (P,) are modes by what they are: no tone, no slope, no wheel's."""
    f, d = np.exp(found.poles.T)
    return (
        (d > DAMPING_RATIO_LIMITS[0])
        & (d < DAMPING_RATIO_LIMITS[1])
        & (f > MAX_WHEEL_HOP_FREQUENCY_HZ)
        & (2 * d * f > MIN_MODE_HALF_POWER_WIDTH_SPECTRAL_LINES * of.line_spacing)
    )


def _bootstrap_deviations(band: _PeakBand, found: _ModeFit, windows: int) -> tuple[FloatArray, int]:
    """Return standard deviations of the poles (P, 2) by drawing blocks of windows, and these."""
    rng = np.random.default_rng(0)
    block = np.arange(windows) // BOOTSTRAP_BLOCK_WINDOWS
    count = int(block[-1]) + 1
    drawn: list[FloatArray] = []
    for _ in range(BOOTSTRAP_DRAWS):
        weight = np.bincount(rng.integers(0, count, count), minlength=count)[block].astype(float)
        drawn.append(band.least(band.said(weight), found.poles, found.own, steps=5).poles)
    return np.std(drawn, axis=0), count


def _mode_shape(of: OrderFreeSpectra, frequency: float) -> tuple[float, ...]:
    """Return what gauges (G,) feel of a mode: what swings together there, the largest 1."""
    at = np.abs(of.frequency - frequency) <= 2 * of.line_spacing
    known = of.known[..., at].all(1)
    z = np.moveaxis(of.lines[..., at], 1, -1)[known]
    if not len(z):
        return (1.0,) * of.lines.shape[1]
    # A loud window counts no more than a quiet one.
    z = z / np.maximum(np.linalg.norm(z, axis=-1, keepdims=True), 1e-300)
    _, vectors = np.linalg.eigh(z.T @ z.conj())
    first = vectors[:, -1]
    first = (first / first[np.argmax(np.abs(first))]).real
    return tuple(first.tolist())
