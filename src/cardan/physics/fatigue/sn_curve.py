"""What a material bears: S-N curves, and the factors between a specimen and a part."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from statistics import NormalDist
from typing import Self

import numpy as np

from cardan.core.arrays import ArrayLike, FloatArray
from cardan.core.errors import DesignError
from cardan.core.units import Metre, MPa, Pascal, mm


@dataclass(frozen=True, slots=True, kw_only=True)
class SNCurve:
    """Stress amplitude against cycles to failure: two straight lines in logs, with scatter.

    Attributes
    ----------
    amplitude : Pa
        Fully reversed amplitude at the knee.
    cycles : 1
        Cycles at the knee.
    slope : 1
        k of N ~ S^-k above the knee.
    slope_beyond_knee : 1
        k below the knee. Infinite: smaller cycles do no harm (original Miner); `slope`:
        the line goes on (elementary); 2k - 1: Haibach's modified rule.
    scatter : 1
        Standard deviation of log10 amplitude at one life.
    failure : 1
        Share of parts that fail at or before the line.
    ceiling : Pa
        Amplitude at which one cycle breaks the part.
    """

    amplitude: Pascal
    cycles: float
    slope: float
    slope_beyond_knee: float = math.inf
    scatter: float = 0.0
    failure: float = 0.5
    ceiling: Pascal = math.inf

    def __post_init__(self) -> None:
        for name in ("amplitude", "cycles", "slope", "ceiling"):
            if not getattr(self, name) > 0:
                msg = f"{name} of an S-N curve must be above 0, got {getattr(self, name):g}"
                raise DesignError(msg)
        if not self.slope_beyond_knee >= self.slope:
            msg = (
                f"slope beyond the knee must be at least {self.slope:g}, got "
                f"{self.slope_beyond_knee:g}"
            )
            raise DesignError(msg)
        if not (self.scatter >= 0 and 0 < self.failure < 1):
            msg = f"scatter must not be negative and failure lie within (0, 1), got {self}"
            raise DesignError(msg)

    @classmethod
    def basquin(cls, *, coefficient: Pascal, exponent: float, knee: float = 1e6) -> Self:
        """Return the line σa = σf' (2N)^b through to its knee, and on with the same slope."""
        k = -1 / exponent
        return cls(
            amplitude=coefficient * (2 * knee) ** exponent,
            cycles=knee,
            slope=k,
            slope_beyond_knee=k,
        )

    @classmethod
    def single_slope(cls, *, capacity: float, slope: float) -> Self:
        """Return the single line N S^m = A, with A in cycles times Pa^m."""
        return cls(
            amplitude=capacity ** (1 / slope), cycles=1.0, slope=slope, slope_beyond_knee=slope
        )

    def original(self) -> Self:
        """Return the curve with an endurance limit: Miner as he wrote it."""
        return replace(self, slope_beyond_knee=math.inf)

    def elementary(self) -> Self:
        """Return the curve without a knee: the safest Miner sum."""
        return replace(self, slope_beyond_knee=self.slope)

    def modified(self) -> Self:
        """Return the curve with 2k - 1 beyond the knee: Haibach, LBF TM 50/70 (1970)."""
        return replace(self, slope_beyond_knee=2 * self.slope - 1)

    def scaled(self, factor: float) -> Self:
        """Return the curve of a part that bears `factor` times the stress."""
        return replace(self, amplitude=factor * self.amplitude)

    def at_failure_share(self, failure: float) -> Self:
        """Return the curve at which this share of parts has failed (lognormal scatter)."""
        z = NormalDist().inv_cdf(failure) - NormalDist().inv_cdf(self.failure)
        return replace(self.scaled(10 ** (z * self.scatter)), failure=failure)

    def damage(self, amplitude: ArrayLike) -> FloatArray:
        """Damage 1/N of one cycle of each amplitude (...) Pa at zero mean, (...) 1."""
        s = np.asarray(amplitude, dtype=float) / self.amplitude
        with np.errstate(divide="ignore"):
            # A power by logarithms, twice as fast; no stress, and an infinite slope, give 0.
            done = (
                np.exp(np.log(s) * np.where(s >= 1, self.slope, self.slope_beyond_knee))
                / self.cycles
            )
        if not math.isfinite(self.ceiling):
            return done
        return np.where(s * self.amplitude >= self.ceiling, np.maximum(done, 1.0), done)

    def life(self, amplitude: ArrayLike) -> FloatArray:
        """Cycles to failure at each amplitude (...) Pa, (...) 1; infinite where harmless."""
        with np.errstate(divide="ignore"):
            return 1 / self.damage(amplitude)


SURFACE_FINISH_FACTORS: Mapping[str, tuple[float, float]] = {
    "ground": (1.58, -0.085),
    "machined": (4.51, -0.265),
    "hot-rolled": (57.7, -0.718),
    "as-forged": (272.0, -0.995),
}
"""Surface: factor and exponent of the strength in MPa. Shigley, 9th ed., table 6-2."""


def surface_factor(finish: str, *, ultimate: Pascal) -> float:
    """Marin's ka = a Rm^b (at most 1). Source: Shigley, 9th ed., eq. 6-19."""
    if finish not in SURFACE_FINISH_FACTORS:
        msg = f"surface must be one of {', '.join(SURFACE_FINISH_FACTORS)}, got {finish!r}"
        raise ValueError(msg)
    factor, exponent = SURFACE_FINISH_FACTORS[finish]
    return min(factor * (ultimate / MPa) ** exponent, 1.0)


def size_factor(diameter: Metre) -> float:
    """Marin's kb of a turning round bar; 2.79-254 mm. Source: Shigley, 9th ed., eq. 6-20."""
    d = diameter / mm
    if not 2.79 <= d <= 254:
        msg = f"size factor is known for 2.79 to 254 mm, got {d:g} mm"
        raise ValueError(msg)
    return (d / 7.62) ** -0.107 if d <= 51 else 1.51 * d**-0.157


def equivalent_diameter(*, width: Metre, height: Metre) -> Metre:
    """Round bar with as much highly stressed area as a bent rectangle: 0.808 √(hb).

    Source: Shigley, 9th ed., eq. 6-25.
    """
    return 0.808 * math.sqrt(width * height)


LOAD_TYPE_FACTORS: Mapping[str, float] = {"bending": 1.0, "axial": 0.85, "torsion": 0.59}
"""Marin's kc. Source: Shigley, 9th ed., eq. 6-26."""


def temperature_factor(celsius: float) -> float:
    """Marin's kd, 21 to 540 °C. Source: Shigley, 9th ed., eq. 6-27."""
    f = 32 + 1.8 * celsius
    if not 70 <= f <= 1000:
        msg = f"temperature factor is known for 21 to 538 °C, got {celsius:g} °C"
        raise ValueError(msg)
    return 0.975 + 0.432e-3 * f - 0.115e-5 * f**2 + 0.104e-8 * f**3 - 0.595e-12 * f**4


def reliability_factor(failure: float) -> float:
    """Marin's ke = 1 + 0.08 z: strength with 8 % scatter. Source: Shigley, eq. 6-29."""
    return 1 + 0.08 * NormalDist().inv_cdf(failure)


def notch_factor(*, concentration: float, sensitivity: float) -> float:
    """Fatigue notch factor Kf = 1 + q (Kt - 1). Source: Shigley, 9th ed., eq. 6-32."""
    return 1 + sensitivity * (concentration - 1)


def neuber_sensitivity(*, radius: Metre, ultimate: Pascal) -> float:
    """Notch sensitivity q = 1 / (1 + √a/√r) of steel, strength 340 to 1700 MPa.

    Source: Neuber; √a by Shigley, 9th ed., eq. 6-35a (bending and axial; kpsi, √in).
    """
    s = ultimate / 6.894757e6
    root = 0.246 - 3.08e-3 * s + 1.51e-5 * s**2 - 2.67e-8 * s**3
    return 1 / (1 + root / math.sqrt(radius / 25.4e-3))


def endurance_limit(
    ultimate: Pascal, *factors: float, limit: Pascal = 700 * MPa, notch: float = 1.0
) -> Pascal:
    """Endurance limit of a steel part: ka kb kc kd ke ... Se' / Kf (Marin).

    Se' is half the tensile strength, up to `limit`. Source: Marin, Mechanical Behavior of
    Engineering Materials (1962); Shigley, 9th ed., eq. 6-8 and 6-18.
    """
    return math.prod(factors) * min(0.5 * ultimate, limit) / notch


def steel_sn_curve(
    ultimate: Pascal, *, endurance: Pascal, knee: float = 1e6, scatter: float = 0.0
) -> SNCurve:
    """S-N curve of a steel part through f Rm at 1000 cycles and its limit at the knee.

    f is 0.9, Shigley's figure 6-18 below 480 MPa and on the unsafe side by up to a sixth at 1400
    MPa; cycles at or above the tensile strength break the part at once.
    """
    if not 0 < endurance < 0.9 * ultimate:
        msg = f"endurance limit must lie within (0, {0.9 * ultimate:g}) Pa, got {endurance:g} Pa"
        raise DesignError(msg)
    slope = math.log(knee / 1e3) / math.log(0.9 * ultimate / endurance)
    return SNCurve(amplitude=endurance, cycles=knee, slope=slope, scatter=scatter, ceiling=ultimate)
