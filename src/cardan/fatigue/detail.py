"""How a cut edge or a weld bears: by classes of codes, which count ranges and stress ratios."""

import numpy as np

from cardan.base.arrays import ArrayLike, FloatArray
from cardan.base.units import Pascal


def at_knee(stress_range: Pascal, *, cycles: float, slope: float) -> Pascal:
    """Amplitude at the knee of a curve whose class is a range at two million cycles.

    Source: Hobbacher, IIW Recommendations for Fatigue Design of Welded Joints and
    Components (2016), section 3.2: N = C / range^m.
    """
    return stress_range / 2 * (2e6 / cycles) ** (1 / slope)


def ratio_bonus(amplitude: ArrayLike, mean: ArrayLike) -> FloatArray:
    """Amplitude (...) Pa of the same damage at R = 0.5, for edges without residual stress.

    f(R) = 1.6 below R = -1, 1.2 - 0.4 R to R = 0.5, 1 above. Source: Hobbacher, IIW
    Recommendations (2016), section 3.5.1, case I; quoted from memory, not re-read.
    """
    a, m = np.asarray(amplitude, dtype=float), np.asarray(mean, dtype=float)
    top = m + a
    with np.errstate(divide="ignore", invalid="ignore"):
        R = np.where(top > 0, (m - a) / top, -np.inf)
    return a / np.clip(1.2 - 0.4 * R, 1.0, 1.6)


def roughness_factor(roughness: float, *, ultimate: Pascal) -> float:
    """K_R = 1 - 0.22 lg(Rz/um) lg(2 Rm / 400 MPa) of steel; 1 for what is polished.

    Source: FKM guideline, Analytical Strength Assessment, 6th ed., section 2.3.1.4; quoted from
    memory, not re-read. Rz 200 um stands for a rolled, forged or cast skin.
    """
    if not roughness > 1e-6:
        return 1.0
    return float(min(1.0, 1 - 0.22 * np.log10(roughness / 1e-6) * np.log10(2 * ultimate / 400e6)))


def sheet_amplitude(ultimate: Pascal, *, roughness: float) -> Pascal:
    """Amplitude of steel at a million cycles, fully reversed: 0.45 Rm K_R.

    Source: FKM guideline, 6th ed., section 2.2.1: f = 0.45 for steel in tension and
    compression; slope 5 and knee 1e6 belong to it. Quoted from memory, not re-read.
    """
    return 0.45 * ultimate * roughness_factor(roughness, ultimate=ultimate)
