"""The hinge of an offshore tower: S-N curves say it fails sooner than cracks do.

A tower stands on the sea bed on a universal joint, which every wave shears. Zaheer & Islam
(Fatigue Fract. Eng. Mater. Struct. 33, 2010) assessed such a joint by S-N curve and by fracture
mechanics with FORM and Monte Carlo, and found the S-N curve markedly the more pessimistic. The
same comparison is made here for wave-loaded histories; the sea states, the stress per metre of
wave and the scatters below are assumed, of the size usual offshore.
"""

import math

import numpy as np

from cardan.core.units import MPa, hour, mm
from cardan.physics.fatigue.crack_growth import paris_cycles
from cardan.physics.fatigue.rainflow import rainflow
from cardan.physics.fatigue.reliability import (
    Lognormal,
    first_order_reliability,
    monte_carlo,
    sn_limit_state,
)
from cardan.physics.fatigue.spectral import Spectrum, tovo_benasciutti

# Significant height m, zero-crossing period s, share of time.
SEAS = ((1.0, 5.0, 0.35), (2.0, 6.0, 0.30), (3.5, 7.5, 0.20), (5.0, 8.5, 0.10),
        (7.0, 10.0, 0.04), (10.0, 12.0, 0.01))  # fmt: skip
STRESS_PER_METRE = 5.0 * MPa
YEARS, SLOPE = 20, 3.0


def sea(height: float, period: float) -> Spectrum:
    """Stress in one sea state, by Pierson and Moskowitz (ISSC form), stress following waves."""
    f = np.linspace(0.01, 0.6, 1200)
    b = 1 / (math.pi * (f * period) ** 4)
    return Spectrum(f, STRESS_PER_METRE**2 * height**2 / 4 * b / f * np.exp(-b))


def history(spectrum: Spectrum, seconds: float, seed: int):
    """A stress history of that spectrum, two samples a second."""
    n = int(2 * seconds)
    f = np.fft.rfftfreq(n, 0.5)
    rng = np.random.default_rng(seed)
    noise = rng.normal(size=f.size) + 1j * rng.normal(size=f.size)
    density = np.interp(f, spectrum.frequency, spectrum.density, left=0, right=0)
    return np.fft.irfft(noise * np.sqrt(density * n / 2), n)


# The spectral method is held against rainflow of a wave-loaded history, in every sea.
for height, period, _ in SEAS:
    cycles = rainflow(history(sea(height, period), 40 * hour, seed=1))
    counted = float(cycles.count @ cycles.range**SLOPE) / (40 * hour)
    spectral = 2**SLOPE * tovo_benasciutti(sea(height, period)).moment(SLOPE)
    print(f"Hs {height:4.1f} m: spectral over rainflow {spectral / counted:.2f}")
    assert abs(spectral / counted - 1) < 0.1

rate = sum(share * 2**SLOPE * tovo_benasciutti(sea(h, t)).moment(SLOPE) for h, t, share in SEAS)
load = rate * YEARS * 365.25 * 24 * hour  # N E[S³] of a life, Pa³
print(f"N E[S^3] in {YEARS} years: {load / MPa**3:.3g} MPa^3")

# S-N: strength A, damage at failure, error of the stress scale.
error = Lognormal(median=1.0, cov=0.2)
strength = (Lognormal(median=1.1e12 * MPa**3, cov=0.5), Lognormal(median=1.0, cov=0.3), error)
by_curve = first_order_reliability(sn_limit_state(slope=SLOPE, load=load), strength)


def crack(x):
    """Cycles of unit range a crack bears, times their damage, against the life's."""
    start, C, scale = x[..., 0], x[..., 1], x[..., 2]
    borne = paris_cycles(start=start, end=40 * mm, stress=scale, C=C, m=SLOPE, Y=1.0)
    return np.log(borne) - math.log(load)


# Cracks: first length, Paris constant (m per cycle, Pa√m; of the size of BS 7910), the same error.
flaw = (
    Lognormal(median=0.15 * mm, cov=0.5),
    Lognormal(median=3.98e-13 * 1e-3 / (MPa * math.sqrt(1e-3)) ** 3, cov=0.5),
    error,
)
by_crack = first_order_reliability(crack, flaw)
sampled = monte_carlo(crack, flaw, samples=100_000, seed=3, around=by_crack)
for name, answer in (("S-N curve", by_curve), ("crack growth", by_crack)):
    shares = ", ".join(f"{s:.0%}" for s in answer.importance)
    print(
        f"{name}: beta {answer.beta:.2f}, failure {answer.failure_probability:.2e}; importance "
        f"{shares}"
    )
print(f"crack growth by sampling: {sampled.failure_probability:.2e} ± {sampled.standard_error:.1e}")

assert by_curve.beta < by_crack.beta
assert abs(sampled.failure_probability / by_crack.failure_probability - 1) < 0.1
assert by_curve.importance[2] == max(by_curve.importance)  # the stress scale counts three times
