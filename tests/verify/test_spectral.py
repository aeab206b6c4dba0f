"""Spectral fatigue against Bendat's closed form, FLife and rainflow of simulated signals."""

import math

import numpy as np
import pytest

from cardan.core.units import MPa
from cardan.physics.fatigue.damage import miner_damage
from cardan.physics.fatigue.rainflow import rainflow
from cardan.physics.fatigue.sn_curve import SNCurve
from cardan.physics.fatigue.spectral import (
    Spectrum,
    dirlik,
    periodograms,
    rayleigh,
    tovo_benasciutti,
    welch_spectrum,
)

RATE, SIGMA = 1000.0, 30 * MPa


def bimodal(first=20.0, second=120.0, share=0.6):
    f = np.linspace(0, RATE / 2, 2001)
    shape = share * np.exp(-(((f - first) / 5) ** 2))
    shape += (1 - share) * np.exp(-(((f - second) / 10) ** 2))
    return Spectrum(f, shape * SIGMA**2 / np.trapezoid(shape, f))


def simulated(spectrum, seconds=2000, seed=1):
    """A Gaussian signal of that spectrum: random phases and Rayleigh amplitudes."""
    n = int(seconds * RATE)
    f = np.fft.rfftfreq(n, 1 / RATE)
    rng = np.random.default_rng(seed)
    density = np.interp(f, spectrum.frequency, spectrum.density)
    noise = rng.normal(size=f.size) + 1j * rng.normal(size=f.size)
    return np.fft.irfft(noise * np.sqrt(density * RATE * n / 4), n)


@pytest.mark.parametrize("m", [3, 4.5, 6])
def test_narrow_band_moment_matches_bendat(m):
    """E[S^m] = (2√2 σ)^m Γ(1 + m/2) for ranges S, at one cycle per zero crossing."""
    s = bimodal()
    mix = rayleigh(s)
    crossings = math.sqrt(s.moment(2) / s.moment(0))
    assert mix.rate.sum() == pytest.approx(crossings, rel=1e-12)
    expected = (2 * math.sqrt(2) * math.sqrt(s.moment(0))) ** m * math.gamma(1 + m / 2)
    assert 2**m * mix.moment(m) / crossings == pytest.approx(expected, rel=1e-12)


def test_dirlik_constants_of_flat_spectrum_match_hand_values():
    """m0, m1, m2, m4 = 1, 1/2, 1/3, 1/5: D1 0.11564, D2 0.35239, D3 0.53198, Q 0.1446, R 0.5676."""
    f = np.linspace(0, 1, 20_001)
    mix = dirlik(Spectrum(f, np.ones_like(f)))
    peaks = math.sqrt(3 / 5)
    np.testing.assert_allclose(mix.rate / peaks, [0.11564, 0.35239, 0.53198], atol=2e-5)
    scales = [0.1446, 0.5676 * math.sqrt(2), math.sqrt(2)]
    np.testing.assert_allclose(mix.scale, scales, atol=1e-4)
    assert mix.shape.tolist() == [1, 2, 2]


@pytest.mark.oracle
@pytest.mark.filterwarnings("ignore")
@pytest.mark.parametrize("k", [3.0, 5.0, 8.0])
def test_spectral_methods_match_flife(k):
    """FLife integrates Dirlik's density numerically: 1e-3; the other two are closed: 1e-6."""
    import FLife

    s = bimodal()
    data = FLife.SpectralData(input={"PSD": s.density / MPa**2, "f": s.frequency})
    curve = SNCurve.single_slope(capacity=1e24 * MPa**k, slope=k)
    theirs = {
        "narrow": FLife.Narrowband(data).get_life(C=1e24, k=k),
        "dirlik": FLife.Dirlik(data).get_life(C=1e24, k=k),
        "tb": FLife.TovoBenasciutti(data).get_life(C=1e24, k=k, method="method 2"),
    }
    ours = {"narrow": rayleigh, "dirlik": dirlik, "tb": tovo_benasciutti}
    for name, method in ours.items():
        rel = 1e-3 if name == "dirlik" else 1e-6
        assert 1 / method(s).damage_rate(curve) == pytest.approx(theirs[name], rel=rel), name


@pytest.mark.parametrize("k", [3.0, 5.0])
def test_spectral_methods_match_rainflow_of_signal(k):
    """Dirlik and Tovo-Benasciutti claim about 10 % on bimodal spectra; narrow band overstates."""
    s = bimodal()
    x = simulated(s)
    curve = SNCurve.single_slope(capacity=1e24 * MPa**k, slope=k)
    counted = miner_damage(rainflow(x), curve=curve) / (x.size / RATE)
    assert dirlik(s).damage_rate(curve) == pytest.approx(counted, rel=0.1)
    assert tovo_benasciutti(s).damage_rate(curve) == pytest.approx(counted, rel=0.1)
    assert rayleigh(s).damage_rate(curve) > 1.1 * counted


def test_damage_of_bilinear_sn_curve_matches_quadrature():
    """The closed form by incomplete gammas, against brute quadrature of the density."""
    s = bimodal()
    curve = SNCurve(amplitude=50 * MPa, cycles=1e6, slope=5, slope_beyond_knee=9)
    amplitude = np.linspace(0, 12 * SIGMA, 400_001)
    for method in (rayleigh, dirlik, tovo_benasciutti):
        mix = method(s)
        density = -np.diff(mix.exceedances(amplitude))
        middle = (amplitude[1:] + amplitude[:-1]) / 2
        assert mix.damage_rate(curve) == pytest.approx(density @ curve.damage(middle), rel=1e-5)


def test_welch_spectrum_matches_scipy():
    from scipy import signal

    x = np.random.default_rng(0).normal(size=40_000)
    f, density = signal.welch(x, RATE, nperseg=1024)
    ours = welch_spectrum(np.array_split(x, 37), rate=RATE, segment=1024)
    np.testing.assert_allclose(ours.frequency, f)
    np.testing.assert_allclose(ours.density, density, rtol=1e-9)


def test_spectrum_preserves_variance_and_skips_gaps():
    x = simulated(bimodal(), seconds=200)
    s = welch_spectrum([x], rate=RATE, segment=2000)
    assert s.moment(0) == pytest.approx(np.var(x), rel=0.02)
    x[70_000:71_000] = np.nan
    assert np.isfinite(welch_spectrum([x], rate=RATE, segment=2000).density).all()
    with pytest.raises(ValueError, match="shorter segment"):
        welch_spectrum([x[:1000]], rate=RATE, segment=2000)


def test_spectrogram_locates_frequency_in_time():
    t = np.arange(20_000) / RATE
    x = np.where(t < 10, np.sin(2 * np.pi * 50 * t), np.sin(2 * np.pi * 200 * t))
    f, power = periodograms(x, rate=RATE, segment=1000)
    assert f[power[0].argmax()] == 50
    assert f[power[-1].argmax()] == 200
