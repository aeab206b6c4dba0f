"""From strain to stress: single gauges and rosettes, in plane stress."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import TypeAlias

import numpy as np

from cardan.core.arrays import ArrayLike, FloatArray
from cardan.core.finding import Finding
from cardan.core.units import GPa, Pascal, Radian, deg

RECTANGULAR_ROSETTE_ANGLES = (0.0, 45 * deg, 90 * deg)
DELTA_ROSETTE_ANGLES = (0.0, 60 * deg, 120 * deg)
"""Angles of the grids of a rosette, from its own x axis."""

MIN_NORMAL_STRESS_SUM_TO_LARGEST_STRESS_FOR_SIGN = 0.3
"""Of the largest part of a stress, below which its sum of normal stresses is no sign."""
MAX_PLAUSIBLE_MISES_PA = 2 * GPa
"""Von Mises' stress that no metal of a driveline bears: -9999 um/m is more."""

StressMeasureFunction: TypeAlias = Callable[["PlaneStress"], FloatArray]
"""One number for a plane stress: `signed_mises`, `largest`, or a plane's normal stress."""


@dataclass(frozen=True)
class PlaneStress:
    """Stress at a free surface, in the rosette's axes.

    Attributes
    ----------
    x, y, xy : (...) Pa
        Normal stresses and shear stress.
    """

    x: FloatArray
    y: FloatArray
    xy: FloatArray

    @property
    def principal(self) -> FloatArray:
        """Principal stresses (..., 2) Pa, the algebraically larger first."""
        middle, radius = (self.x + self.y) / 2, np.hypot((self.x - self.y) / 2, self.xy)
        return np.stack([middle + radius, middle - radius], axis=-1)

    @property
    def direction(self) -> FloatArray:
        """Angle (...) rad of the larger principal stress from the x axis, (-π/2, π/2]."""
        return np.arctan2(2 * self.xy, self.x - self.y) / 2

    @property
    def mises(self) -> FloatArray:
        """Von Mises stress (...) Pa."""
        return np.sqrt(self.x**2 - self.x * self.y + self.y**2 + 3 * self.xy**2)

    @property
    def biaxiality(self) -> FloatArray:
        """Smaller over larger principal stress by magnitude (...) 1; 0 uniaxial, -1 shear."""
        p = self.principal
        high, low = p[..., 0], p[..., 1]
        swap = np.abs(low) > np.abs(high)
        large, small = np.where(swap, low, high), np.where(swap, high, low)
        return np.divide(small, large, out=np.zeros_like(large), where=large != 0)

    def normal(self, angle: Radian) -> FloatArray:
        """Stress (...) Pa across the plane whose normal stands at this angle from x."""
        c, s = np.cos(angle), np.sin(angle)
        return self.x * c**2 + self.y * s**2 + 2 * self.xy * s * c


def plane_stress_of_rosette(
    strains: ArrayLike,
    *,
    angles: tuple[Radian, ...] = RECTANGULAR_ROSETTE_ANGLES,
    modulus: Pascal = 206 * GPa,
    poisson: float = 0.3,
) -> PlaneStress:
    """Plane stress under a rosette of three or more grids.

    ε(α) = εx cos²α + εy sin²α + γ sin α cos α, solved for the three, by least squares where
    there are more grids, then Hooke's law.

    Parameters
    ----------
    strains : (grids, ...) 1
        One row per grid.
    angles : rad
        Of the grids: `RECTANGULAR_ROSETTE_ANGLES`, `DELTA_ROSETTE_ANGLES` or others.
    modulus : Pa
        Young's modulus.
    poisson : 1
        Poisson's ratio.

    Raises
    ------
    ValueError
        If the angles do not separate the three strains.
    """
    e = np.asarray(strains, dtype=float)
    c, s = np.cos(angles), np.sin(angles)
    design = np.stack([c**2, s**2, s * c], axis=-1)
    if e.shape[0] != len(angles) or np.linalg.matrix_rank(design, tol=1e-6) < 3:
        msg = f"a rosette needs three or more different angles, one per row; got {angles}"
        raise ValueError(msg)
    ex, ey, g = np.einsum("ij,j...->i...", np.linalg.pinv(design), e)
    plane = modulus / (1 - poisson**2)
    return PlaneStress(
        x=plane * (ex + poisson * ey),
        y=plane * (ey + poisson * ex),
        xy=modulus / (2 * (1 + poisson)) * g,
    )


def signed_mises(stress: PlaneStress, *, along: FloatArray | None = None) -> FloatArray:
    """Von Mises stress with the sign of the larger principal stress, (...) Pa.

    Good where direction and biaxiality hardly move; else count on planes. Shear has no larger one,
    and what little is added to it would turn the sign: then that of the stress `along` (3,) the
    way it mostly swings, `dominant_stress_direction`.
    """
    a, b, c = (1.0, 1.0, 0.0) if along is None else along
    return np.where(a * stress.x + b * stress.y + c * stress.xy < 0, -1.0, 1.0) * stress.mises


def dominant_stress_direction(stress: PlaneStress) -> FloatArray:
    """Which way a stress (n,) mostly swings: (3,) times its x, y and xy that is, with its sign.

    The first principal component about zero, as long as von Mises' stress is, without what a
    logger wrote for no value, and the loudest thousandth as loud as the rest. Tension is positive,
    and of shear the way it mostly stands.
    """
    parts = np.stack([stress.x, stress.y, stress.xy])[:, stress.mises < MAX_PLAUSIBLE_MISES_PA]
    # Rows of u = R σ with |u| von Mises' stress.
    root = np.array([[1.0, -0.5, 0.0], [0.0, np.sqrt(0.75), 0.0], [0.0, 0.0, np.sqrt(3.0)]])
    u = root @ parts
    size = np.sqrt((u**2).sum(0))
    if not size.any():
        return np.array([1.0, 1.0, 0.0])
    u = u * np.minimum(1.0, np.quantile(size, 0.999) / np.maximum(size, 1e-300))
    way = np.linalg.eigh(u @ u.T)[1][:, -1] @ root
    tension = float(way[0] + way[1])
    sheared = abs(tension) < MIN_NORMAL_STRESS_SUM_TO_LARGEST_STRESS_FOR_SIGN * float(
        np.abs(way).max()
    )
    return -way if (float((way @ parts).mean()) if sheared else tension) < 0 else way


def abs_max_principal(stress: PlaneStress) -> FloatArray:
    """Principal stress of larger magnitude, with its sign, (...) Pa."""
    p = stress.principal
    return np.where(np.abs(p[..., 1]) > np.abs(p[..., 0]), p[..., 1], p[..., 0])


@dataclass(frozen=True, kw_only=True)
class StrainGauge:
    """A place on the part: the channels that give its stress, and how.

    Attributes
    ----------
    name
        As users know it.
    channels
        Names of the channels, one or one per grid of a rosette.
    stress
        Turns pieces of those channels (k, n) into stress (n,) Pa.
    plane_stress
        Turns them into the plane stress, of which `stress` is one measure; None of single gauges.
    dominant_direction
        Which way that mostly swings, as `signed_mises` takes it.
    doubts
        Whether its channels are what they are taken for.
    assumed_unit
        The unit that nothing but a word on the command line says; "" where the recording does.
    alternative_unit
        The unit it may be in as well, and how many times as large its stress is then.
    """

    name: str
    channels: tuple[str, ...]
    stress: Callable[[FloatArray], FloatArray]
    plane_stress: Callable[[FloatArray], PlaneStress] | None = None
    dominant_direction: FloatArray | None = None
    doubts: tuple[Finding, ...] = ()
    assumed_unit: str = ""
    alternative_unit: tuple[str, float] | None = None


def _scaled(piece: FloatArray, *, factor: float) -> FloatArray:
    return piece[0] * factor


def single_gauge(name: str, channel: str, *, factor: float) -> StrainGauge:
    """Return a gauge whose channel times `factor` is the stress in Pa.

    For strain it is Young's modulus times the unit: 206e9 * 1e-6 Pa per µm/m.
    """
    return StrainGauge(name=name, channels=(channel,), stress=partial(_scaled, factor=factor))


def rosette_gauge(
    name: str,
    channels: tuple[str, ...],
    *,
    unit: float | FloatArray = 1e-6,
    angles: tuple[Radian, ...] = RECTANGULAR_ROSETTE_ANGLES,
    modulus: Pascal = 206 * GPa,
    poisson: float = 0.3,
    measure: StressMeasureFunction | None = None,
    along: FloatArray | None = None,
) -> StrainGauge:
    """Return a rosette whose stress is one measure of its plane stress.

    `unit` is that of the strains, one for all grids or (grids, 1). Without a measure it is
    von Mises' stress, with the sign of what is `along` the way it swings.
    """
    of = measure or partial(signed_mises, along=along)

    def plane(piece: FloatArray) -> PlaneStress:
        return plane_stress_of_rosette(
            piece * unit, angles=angles, modulus=modulus, poisson=poisson
        )

    def stress(piece: FloatArray) -> FloatArray:
        return of(plane(piece))

    return StrainGauge(
        name=name, channels=channels, stress=stress, plane_stress=plane, dominant_direction=along
    )
