"""Fatigue from a spectrum: what rainflow would count on a Gaussian signal.

Every method here describes the amplitudes of the cycles as a mixture of Weibull laws
(shape 1 exponential, 2 Rayleigh), so damage has a closed form on any two-slope S-N curve.
Good for stationary Gaussian stress; events and run-ups are neither, which is why the same
signal is counted by rainflow as well.
"""

import math
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from cardan.core.arrays import ArrayLike, FloatArray
from cardan.physics.fatigue.sn_curve import SNCurve


@dataclass(frozen=True)
class Spectrum:
    """A one-sided power spectral density.

    Attributes
    ----------
    frequency : (n,) Hz
        From 0 to half the sample rate.
    density : (n,) unit²/Hz
        Its integral is the variance of the signal.
    """

    frequency: FloatArray
    density: FloatArray

    def moment(self, order: float) -> float:
        """Spectral moment ∫ fⁿ G df; order 0 is the variance."""
        return float(np.trapezoid(self.frequency**order * self.density, self.frequency))


def periodograms(x: ArrayLike, *, rate: float, segment: int) -> tuple[FloatArray, FloatArray]:
    """Densities of half-overlapping Hann segments, mean removed.

    Returns frequency (segment/2 + 1,) Hz and densities (segments, segment/2 + 1), a
    spectrogram whose mean over segments is Welch's estimate. Segments with missing samples
    are left out. Source: Welch, IEEE Trans. Audio Electroacoust. 15 (1967).
    """
    x = np.asarray(x, dtype=float)
    frequency = _frequencies(segment, rate)
    if x.size < segment:
        return frequency, np.empty((0, frequency.size))
    frames = np.lib.stride_tricks.sliding_window_view(x, segment)[:: segment // 2]
    frames = frames[~np.isnan(frames).any(-1)]
    window = 0.5 - 0.5 * np.cos(2 * np.pi * np.arange(segment) / segment)
    frames = (frames - frames.mean(-1, keepdims=True)) * window
    lines = np.fft.rfft(frames, axis=-1)
    power = (lines.real**2 + lines.imag**2) / (rate * (window**2).sum())
    power[:, 1 : (segment + 1) // 2] *= 2  # the negative frequencies
    return frequency, power


def _frequencies(segment: int, rate: float) -> FloatArray:
    return np.arange(segment // 2 + 1, dtype=float) * (rate / segment)


class WelchEstimator:
    """Welch's estimate, block by block: `update` with each, then read `spectrum`."""

    def __init__(self, rate: float, segment: int) -> None:
        self.rate, self.segment, self.count = rate, segment, 0
        self.total: FloatArray = np.zeros(segment // 2 + 1)
        self.tail = np.empty(0)

    def update(self, x: ArrayLike) -> None:
        """Take samples (n,), nan where they are missing."""
        x = np.concatenate([self.tail, np.asarray(x, dtype=float)])
        power = periodograms(x, rate=self.rate, segment=self.segment)[1]
        self.total, self.count = self.total + power.sum(0), self.count + len(power)
        hop = self.segment // 2
        # A view would hold all of it.
        self.tail = x[max((x.size - self.segment) // hop + 1, 0) * hop :].copy()

    def spectrum(self) -> Spectrum | None:
        """Return it, or None of what had no whole segment without gaps."""
        if not self.count:
            return None
        return Spectrum(_frequencies(self.segment, self.rate), self.total / self.count)


def welch_spectrum(pieces: Iterable[ArrayLike], *, rate: float, segment: int = 4096) -> Spectrum:
    """Welch's power spectral density of a signal in pieces; the cuts do not matter.

    Raises
    ------
    ValueError
        If no whole segment without gaps was found.
    """
    welch = WelchEstimator(rate, segment)
    for piece in pieces:
        welch.update(piece)
    found = welch.spectrum()
    if found is None:
        msg = f"no {segment} samples in a row without gaps; take a shorter segment"
        raise ValueError(msg)
    return found


@dataclass(frozen=True)
class AmplitudeDistribution:
    """Cycles per second over amplitude: a mixture of Weibull laws.

    Attributes
    ----------
    rate : (n,) 1/s
        Cycles a second of each part; negative where an approximation subtracts.
    scale : (n,) Pa
        Weibull scale.
    shape : (n,) 1
        Weibull shape.
    """

    rate: FloatArray
    scale: FloatArray
    shape: FloatArray

    def moment(self, order: float) -> float:
        """Σ rate E[Sa^order], amplitudes to a power a second."""
        from scipy.special import gamma

        return float((self.rate * self.scale**order * gamma(1 + order / self.shape)).sum())

    def exceedances(self, amplitude: ArrayLike) -> FloatArray:
        """Cycles a second (...) above each amplitude (...) Pa."""
        s = np.asarray(amplitude, dtype=float)[..., None]
        return (self.rate * np.exp(-((s / self.scale) ** self.shape))).sum(-1)

    def damage_rate(self, curve: SNCurve) -> float:
        """Miner damage a second, mean stress left out, in closed form.

        Incomplete gamma functions carry the two slopes. A curve's ceiling is not met: a
        Gaussian signal has no largest cycle.
        """
        from scipy.special import gamma, gammainc, gammaincc

        knee = (curve.amplitude / self.scale) ** self.shape
        relative = self.scale / curve.amplitude
        total: FloatArray = np.zeros_like(self.rate)
        for slope, share in ((curve.slope, gammaincc), (curve.slope_beyond_knee, gammainc)):
            if math.isfinite(slope):
                order = 1 + slope / self.shape
                total = total + relative**slope * gamma(order) * share(order, knee)
        return float((self.rate * total).sum() / curve.cycles)


def rayleigh(spectrum: Spectrum) -> AmplitudeDistribution:
    """Narrow band: one Rayleigh cycle for each upward zero crossing.

    On the safe side for a stationary Gaussian stress, and only for one: a route with blows,
    launches and standing is neither, and its damage may be a hundred times as large.
    E[S^m] = (2√2 σ)^m Γ(1 + m/2) for ranges S. Source: Bendat (1964); Miles (1954).
    """
    m0, m2 = spectrum.moment(0), spectrum.moment(2)
    return _weibull_mixture((math.sqrt(m2 / m0), math.sqrt(2 * m0), 2.0))


def dirlik(spectrum: Spectrum) -> AmplitudeDistribution:
    """Dirlik's fit to simulated broad-band rainflow counts.

    Source: Dirlik, Application of computers in fatigue analysis, PhD, Warwick 1985.
    """
    m0, m1, m2, m4 = (spectrum.moment(n) for n in (0, 1, 2, 4))
    peaks, sigma = math.sqrt(m4 / m2), math.sqrt(m0)
    g = m2 / math.sqrt(m0 * m4)
    x = m1 / m0 * math.sqrt(m2 / m4)
    d1 = 2 * (x - g**2) / (1 + g**2)
    r = (g - x - d1**2) / (1 - g - d1 + d1**2)
    d2 = (1 - g - d1 + d1**2) / (1 - r)
    d3 = 1 - d1 - d2
    q = 1.25 * (g - d3 - d2 * r) / d1
    return _weibull_mixture(
        (peaks * d1, sigma * q, 1.0),
        (peaks * d2, math.sqrt(2) * sigma * r, 2.0),
        (peaks * d3, math.sqrt(2) * sigma, 2.0),
    )


def tovo_benasciutti(spectrum: Spectrum) -> AmplitudeDistribution:
    """Rainflow between its two bounds: level-crossing and range counting, weighted by b.

    Source: Benasciutti & Tovo, Int. J. Fatigue 27 (2005), with b by their second formula.
    """
    m0, m1, m2, m4 = (spectrum.moment(n) for n in (0, 1, 2, 4))
    crossings, peaks = math.sqrt(m2 / m0), math.sqrt(m4 / m2)
    a1, a2 = m1 / math.sqrt(m0 * m2), m2 / math.sqrt(m0 * m4)
    b = (a1 - a2) * (1.112 * (1 + a1 * a2 - (a1 + a2)) * math.exp(2.11 * a2) + (a1 - a2))
    b = b / (a2 - 1) ** 2 if a2 < 1 - 1e-9 else 1.0
    scale = math.sqrt(2 * m0)
    return _weibull_mixture((b * crossings, scale, 2.0), ((1 - b) * peaks, a2 * scale, 2.0))


def _weibull_mixture(*parts: tuple[float, float, float]) -> AmplitudeDistribution:
    rate, scale, shape = np.array(parts).T
    return AmplitudeDistribution(rate, scale, shape)
