"""Mean-stress corrections: the fully reversed amplitude that does the same damage.

Each takes amplitude and mean of a cycle, (...) Pa, and returns an equivalent amplitude at
zero mean. Their constants go by name; bind them with `functools.partial`:

    partial(goodman, ultimate=700 * MPa)
"""

from collections.abc import Callable
from typing import TypeAlias

import numpy as np

from cardan.core.arrays import ArrayLike, FloatArray
from cardan.core.units import Pascal
from cardan.physics.fatigue.detail_classes import STEEL_FATIGUE_DATA

MeanStressCorrection: TypeAlias = Callable[[FloatArray, FloatArray], FloatArray]


def uncorrected(amplitude: ArrayLike, _mean: ArrayLike) -> FloatArray:
    """Return the amplitude as it is: the mean is taken to do no harm."""
    return np.asarray(amplitude, dtype=float)


def _tensile_mean_ratio(mean: ArrayLike, ultimate: Pascal) -> FloatArray:
    """Share of the strength a tensile mean uses; a compressive one earns nothing."""
    return np.minimum(np.maximum(np.asarray(mean, dtype=float), 0) / ultimate, 1.0)


def _divide_by_strength_left(amplitude: ArrayLike, left: FloatArray) -> FloatArray:
    """Amplitude over the strength left; infinite where none is."""
    a = np.asarray(amplitude, dtype=float)
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.where(a == 0, 0.0, a / left)


def goodman(amplitude: ArrayLike, mean: ArrayLike, *, ultimate: Pascal) -> FloatArray:
    """σa / (1 - σm/Rm): straight line to the tensile strength; compression counts as zero.

    Source: Goodman, Mechanics Applied to Engineering, 1899.
    """
    return _divide_by_strength_left(amplitude, 1 - _tensile_mean_ratio(mean, ultimate))


def gerber(amplitude: ArrayLike, mean: ArrayLike, *, ultimate: Pascal) -> FloatArray:
    """σa / (1 - (σm/Rm)²): parabola to the tensile strength; compression counts as zero.

    Source: Gerber, Z. Bayer. Archit. Ing. Ver. 6 (1874).
    """
    return _divide_by_strength_left(amplitude, 1 - _tensile_mean_ratio(mean, ultimate) ** 2)


def walker(amplitude: ArrayLike, mean: ArrayLike, *, exponent: float) -> FloatArray:
    """σmax^(1-γ) σa^γ: nothing where the cycle stays in compression.

    γ is about 0.65 for steels and 0.45 for aluminium; 1 ignores the mean.
    Source: Walker, ASTM STP 462 (1970); Dowling et al., FFEMS 32 (2009).
    """
    a = np.asarray(amplitude, dtype=float)
    top = np.maximum(a + np.asarray(mean, dtype=float), 0)
    return top ** (1 - exponent) * a**exponent


def swt(amplitude: ArrayLike, mean: ArrayLike) -> FloatArray:
    """√(σmax σa): Walker's with γ = 1/2. Source: Smith, Watson & Topper, J. Mater. 5 (1970)."""
    return walker(amplitude, mean, exponent=0.5)


def fkm(amplitude: ArrayLike, mean: ArrayLike, *, sensitivity: float) -> FloatArray:
    """Broken line through R = ∞, 0 and 1/2 of the FKM guideline.

    Parameters
    ----------
    amplitude, mean : (...) Pa
        Of each cycle.
    sensitivity
        M, the slope of the Haigh line between R = -1 and 0 (`mean_sensitivity`). A third of
        it holds up to R = 1/2, none beyond and none in pure compression.

    Returns
    -------
    (...) Pa
        Amplitude at R = -1; continuous over all four fields.

    Notes
    -----
    Source: FKM guideline, Analytical Strength Assessment, 6th ed., section 2.4.2.
    """
    a, m = np.asarray(amplitude, dtype=float), np.asarray(mean, dtype=float)
    M = sensitivity
    # Beyond R = 1/2 (mean three amplitudes) and R = ∞ (minus one) the line lies level.
    m = np.clip(m, -a, 3 * a)
    return np.where(m <= a, a + M * m, (1 + M) * (a + M / 3 * m) / (1 + M / 3))


def steel_mean_stress_sensitivity(ultimate: Pascal) -> float:
    """Mean-stress sensitivity M of steel: 0.35e-3 Rm/MPa - 0.1. Source: FKM guideline."""
    return STEEL_FATIGUE_DATA.mean_stress_sensitivity(ultimate)
