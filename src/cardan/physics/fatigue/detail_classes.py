"""How a cut edge or a weld bears: by classes of codes, which count ranges and stress ratios."""

from dataclasses import dataclass

import numpy as np

from cardan.core.arrays import ArrayLike, FloatArray
from cardan.core.units import MPa, Pascal


def fat_class_knee_amplitude(stress_range: Pascal, *, cycles: float, slope: float) -> Pascal:
    """Amplitude at the knee of a curve whose class is a range at two million cycles.

    Source: Hobbacher, IIW Recommendations for Fatigue Design of Welded Joints and
    Components (2016), section 3.2: N = C / range^m.
    """
    return stress_range / 2 * (2e6 / cycles) ** (1 / slope)


def stress_ratio_corrected_amplitude(amplitude: ArrayLike, mean: ArrayLike) -> FloatArray:
    """Amplitude (...) Pa of the same damage at R = 0.5, for edges without residual stress.

    f(R) = 1.6 below R = -1, 1.2 - 0.4 R to R = 0.5, 1 above. Source: Hobbacher, IIW
    Recommendations (2016), section 3.5.1, case I; quoted, unverified.
    """
    a, m = np.asarray(amplitude, dtype=float), np.asarray(mean, dtype=float)
    top = m + a
    with np.errstate(divide="ignore", invalid="ignore"):
        R = np.where(top > 0, (m - a) / top, -np.inf)
    return a / np.clip(1.2 - 0.4 * R, 1.0, 1.6)


@dataclass(frozen=True, slots=True, kw_only=True)
class MetalFatigueData:
    """Constants of the FKM guideline for one kind of metal; the defaults are those of steel.

    Attributes
    ----------
    fatigue_strength_factor
        f of the amplitude f Rm, fully reversed in tension and compression, of a polished bar.
    roughness_constants : 1, Pa
        a and Rm,N,min, by which a rough skin lowers it.
    mean_stress_constants : 1 / Pa, 1
        a and b of the mean-stress sensitivity M = a Rm + b.

    Notes
    -----
    Source: FKM guideline, Analytical Strength Assessment, 6th ed., sections 2.2.1 (f), 2.3.1.4
    (roughness), 2.4.2 (M). How each was read stands in the catalogue's `metals.csv`.
    """

    fatigue_strength_factor: float = 0.45
    roughness_constants: tuple[float, Pascal] = (0.22, 400 * MPa)
    mean_stress_constants: tuple[float, float] = (0.35e-3 / MPa, -0.1)

    def mean_stress_sensitivity(self, ultimate: Pascal) -> float:
        """M, the slope of the Haigh line between R = -1 and 0."""
        a, b = self.mean_stress_constants
        return max(a * ultimate + b, 0.0)


STEEL_FATIGUE_DATA = MetalFatigueData()


def roughness_factor(
    roughness: float, *, ultimate: Pascal, of: MetalFatigueData = STEEL_FATIGUE_DATA
) -> float:
    """K_R = 1 - a lg(Rz/um) lg(2 Rm / Rm,N,min); 1 for what is polished.

    Source: FKM guideline, Analytical Strength Assessment, 6th ed., section 2.3.1.4. Rz 200 um
    stands for a rolled, forged or cast skin.
    """
    a, least = of.roughness_constants
    if not roughness > 1e-6:
        return 1.0
    return float(min(1.0, 1 - a * np.log10(roughness / 1e-6) * np.log10(2 * ultimate / least)))


def sheet_knee_amplitude(
    ultimate: Pascal, *, roughness: float, of: MetalFatigueData = STEEL_FATIGUE_DATA
) -> Pascal:
    """Amplitude at a million cycles, fully reversed: f Rm K_R; of steel f is 0.45.

    Source: FKM guideline, 6th ed., section 2.2.1; slope 5 and knee 1e6 belong to it.
    """
    return (
        of.fatigue_strength_factor
        * ultimate
        * roughness_factor(roughness, ultimate=ultimate, of=of)
    )
