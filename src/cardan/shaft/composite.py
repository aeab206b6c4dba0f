r"""A composite tube as a shaft: laminate theory, failure of each ply, buckling, whirl, layup.

Plies are thin and the tube's radius large against its wall, so each ply is in plane stress
and the laminate stays a membrane: the tube's curvature keeps it from bending.

$$A = \sum_k \bar Q_k t_k,\qquad \varepsilon = A^{-1} N,\qquad N_{xy} = \frac{T}{2\pi r^2}$$

Sources: Jones, Mechanics of Composite Materials (1999); Khoshravan & Paykani, Design of a
composite drive shaft and its coupling, J. Appl. Res. Technol. 10 (2012) 826-834. Compared:
the steel tube of the paper's sizing and hand-worked laminates; its figures are not.
"""

from collections.abc import Iterable
from dataclasses import dataclass
from itertools import product
from math import pi

import numpy as np

from cardan.base.arrays import ArrayLike, FloatArray
from cardan.base.errors import DesignError
from cardan.base.source import Source
from cardan.base.units import GPa, Metre, MPa, NewtonMetre, Pascal


@dataclass(frozen=True, slots=True, kw_only=True)
class Ply:
    """A unidirectional ply. Strengths are positive, compression too.

    Attributes
    ----------
    along, across, shear : Pa
        E₁, E₂ and G₁₂.
    poisson : 1
        ν₁₂.
    tension_along, compression_along, tension_across, compression_across, shear_strength : Pa
        X_t, X_c, Y_t, Y_c and S.
    thickness : m
        Of one ply.
    density : kg/m³
    """

    name: str
    along: Pascal
    across: Pascal
    shear: Pascal
    poisson: float
    tension_along: Pascal
    compression_along: Pascal
    tension_across: Pascal
    compression_across: Pascal
    shear_strength: Pascal
    thickness: Metre
    density: float
    source: Source

    @property
    def stiffness(self) -> FloatArray:
        """Reduced stiffness Q (3, 3) Pa in the ply's own axes."""
        other = self.poisson * self.across / self.along
        free = 1 - self.poisson * other
        return np.array([
            [self.along / free, self.poisson * self.across / free, 0.0],
            [self.poisson * self.across / free, self.across / free, 0.0],
            [0.0, 0.0, self.shear],
        ])  # fmt: skip


CARBON_EPOXY = Ply(
    name="carbon/epoxy T300/5208", along=181 * GPa, across=10.3 * GPa, shear=7.17 * GPa,
    poisson=0.28, tension_along=1500 * MPa, compression_along=1500 * MPa, tension_across=40 * MPa,
    compression_across=246 * MPa, shear_strength=68 * MPa, thickness=0.125e-3, density=1600.0,
    source=Source("Tsai & Hahn, Introduction to Composite Materials, 1980", "tables 1.7 and 7.1"),
)  # fmt: skip
GLASS_EPOXY = Ply(
    name="E-glass/epoxy Scotchply 1002", along=38.6 * GPa, across=8.27 * GPa, shear=4.14 * GPa,
    poisson=0.26, tension_along=1062 * MPa, compression_along=610 * MPa, tension_across=31 * MPa,
    compression_across=118 * MPa, shear_strength=72 * MPa, thickness=0.125e-3, density=1800.0,
    source=Source("Tsai & Hahn, Introduction to Composite Materials, 1980", "tables 1.7 and 7.1"),
)  # fmt: skip


def strain_turn(angle: ArrayLike) -> FloatArray:
    """Matrix (..., 3, 3) from strains (εx, εy, γxy) to those of fibres at `angle` (...) rad."""
    angle = np.asarray(angle, dtype=float)
    c, s = np.cos(angle), np.sin(angle)
    rows = [
        [c * c, s * s, c * s],
        [s * s, c * c, -c * s],
        [-2 * c * s, 2 * c * s, c * c - s * s],
    ]
    return np.stack([np.stack(row, axis=-1) for row in rows], axis=-2)


@dataclass(frozen=True, slots=True, kw_only=True)
class CompositeTube:
    """A wound tube.

    Attributes
    ----------
    outer : m
        Outside diameter.
    ply
        Its material.
    angles : rad
        Of the fibres to the axis, inside ply first.
    """

    outer: Metre
    ply: Ply
    angles: tuple[float, ...]

    def __post_init__(self) -> None:
        if not self.angles:
            msg = "a composite tube needs at least one ply"
            raise DesignError(msg)
        if not 2 * self.wall < self.outer / 2:
            msg = f"{len(self.angles)} plies leave no thin-walled tube of {self.outer:g} m"
            raise DesignError(msg)

    @property
    def wall(self) -> Metre:
        """Thickness of all plies."""
        return len(self.angles) * self.ply.thickness

    @property
    def radius(self) -> Metre:
        """Radius of the middle of the wall."""
        return (self.outer - self.wall) / 2

    @property
    def mass_per_length(self) -> float:
        """Mass per length, kg/m."""
        return 2 * pi * self.radius * self.wall * self.ply.density

    @property
    def membrane(self) -> FloatArray:
        """A (3, 3) N/m: forces per width of membrane strains."""
        turned = strain_turn(np.array(self.angles))
        each = np.swapaxes(turned, -1, -2) @ self.ply.stiffness @ turned
        return each.sum(0) * self.ply.thickness

    @property
    def moduli(self) -> tuple[Pascal, Pascal, Pascal]:
        """Axial, hoop and shear modulus of the wall: 1 / (t a₁₁), 1 / (t a₂₂), 1 / (t a₆₆)."""
        a = np.linalg.inv(self.membrane)
        return tuple(float(1 / (self.wall * a[k, k])) for k in range(3))  # type: ignore[return-value]

    @property
    def torsional_stiffness(self) -> float:
        """G J, N m²: torque over twist per length."""
        return self.moduli[2] * 2 * pi * self.radius**3 * self.wall

    def ply_stresses(self, torque: ArrayLike) -> FloatArray:
        """Stresses (..., plies, 3) Pa along and across the fibres and in shear, under (...) N m."""
        T = np.asarray(torque, dtype=float)
        N = T[..., None] / (2 * pi * self.radius**2) * np.array([0.0, 0.0, 1.0])
        strain = N @ np.linalg.inv(self.membrane).T
        turned = self.ply.stiffness @ strain_turn(np.array(self.angles))
        return np.einsum("kij,...j->...ki", turned, strain)

    def buckling_torque(self) -> NewtonMetre:
        """Torque that buckles the wall: 0.272 · 2π r² t (E_x E_h³)^¼ (t / r)^1.5.

        For a long tube with held ends. Source: Simitses, Instability of orthotropic
        cylindrical shells (1967), as Khoshravan & Paykani (2012) use it; within some 20 %
        of shell theory for balanced layups, optimistic for thin ones with defects.
        """
        axial, hoop, _ = self.moduli
        r, t = self.radius, self.wall
        return 2 * pi * r**2 * t * 0.272 * (axial * hoop**3) ** 0.25 * (t / r) ** 1.5

    def critical_speed(self, length: ArrayLike) -> FloatArray:
        """First bending critical speed (...) rad/s between joint centres (...) m apart.

        π²/L² √(E_x r² / 2ρ): a thin tube pinned at its ends, without shear deformation.
        """
        axial = self.moduli[0]
        L = np.asarray(length, dtype=float)
        return pi**2 / L**2 * np.sqrt(axial * self.radius**2 / (2 * self.ply.density))


def tsai_hill(stress: FloatArray, ply: Ply) -> FloatArray:
    """Tsai-Hill index (...) of stresses (..., 3) Pa: 1 is failure; goes with stress squared."""
    s1, s2, s6 = np.moveaxis(stress, -1, 0)
    X = np.where(s1 >= 0, ply.tension_along, ply.compression_along)
    Y = np.where(s2 >= 0, ply.tension_across, ply.compression_across)
    return (s1 / X) ** 2 - s1 * s2 / X**2 + (s2 / Y) ** 2 + (s6 / ply.shear_strength) ** 2


def tsai_wu(stress: FloatArray, ply: Ply) -> FloatArray:
    """Tsai-Wu index (...) of stresses (..., 3) Pa: 1 is failure. F₁₂ = -½ √(F₁₁ F₂₂)."""
    s1, s2, s6 = np.moveaxis(stress, -1, 0)
    F1, F2, F11, F22, F66, F12 = _tsai_wu(ply)
    return F1 * s1 + F2 * s2 + F11 * s1**2 + F22 * s2**2 + F66 * s6**2 + 2 * F12 * s1 * s2


def _tsai_wu(ply: Ply) -> tuple[float, float, float, float, float, float]:
    Xt, Xc, Yt, Yc = (
        ply.tension_along, ply.compression_along, ply.tension_across, ply.compression_across
    )  # fmt: skip
    F11, F22 = 1 / (Xt * Xc), 1 / (Yt * Yc)
    return (
        1 / Xt - 1 / Xc, 1 / Yt - 1 / Yc, F11, F22, 1 / ply.shear_strength**2,
        -0.5 * (F11 * F22) ** 0.5,
    )  # fmt: skip


def strength_ratio(stress: FloatArray, ply: Ply) -> FloatArray:
    """Factor (...) by which stresses (..., 3) may grow until Tsai-Wu says failure."""
    s1, s2, s6 = np.moveaxis(stress, -1, 0)
    F1, F2, F11, F22, F66, F12 = _tsai_wu(ply)
    a = F11 * s1**2 + F22 * s2**2 + F66 * s6**2 + 2 * F12 * s1 * s2
    b = F1 * s1 + F2 * s2
    with np.errstate(divide="ignore"):
        return np.where(a > 0, 2 / (b + np.sqrt(b**2 + 4 * a)), np.inf)


def steel_wall(
    torque: ArrayLike, *, outer_radius: ArrayLike, yield_strength: ArrayLike
) -> FloatArray:
    """Wall (...) m a steel tube needs: τ = T / (2π r² t) at the middle radius, √3 τ = R_e.

    Parameters
    ----------
    torque, outer_radius, yield_strength : (...) N m, m, Pa

    Raises
    ------
    DesignError
        If no thin wall of that radius carries the torque.
    """
    T, R, Re = (np.asarray(v, float) for v in (torque, outer_radius, yield_strength))
    wanted = T * np.sqrt(3) / (2 * pi * Re)
    # t (R - t/2)² rises up to t = 2R/3; beyond half the radius the tube is not thin.
    if np.any(wanted > R / 2 * (0.75 * R) ** 2):
        msg = f"no thin steel tube of radius {np.max(R):g} m carries {np.max(T):g} N m"
        raise DesignError(msg)
    t = wanted / R**2
    for _ in range(60):
        middle = R - t / 2
        t = t - (t * middle**2 - wanted) / (middle**2 - t * middle)
    return t


@dataclass(frozen=True, slots=True, kw_only=True)
class Layup:
    """A tube that meets its demands, and by how much: each share is demand over capacity."""

    tube: CompositeTube
    strength_share: float
    buckling_share: float
    speed_share: float

    @property
    def mass_per_length(self) -> float:
        """Mass per length, kg/m."""
        return self.tube.mass_per_length


def judged(
    tube: CompositeTube, *, torque: NewtonMetre, speed: float, length: Metre, speed_limit: float
) -> Layup:
    """Return how much of a tube's capacity a torque N m and a speed rad/s use over `length` m.

    Torque counts both ways. `speed_limit` is the share of the critical speed that may be
    used (0.75 by the manuals); strength and buckling are held as they come, so put the
    safety factor into the torque.
    """
    stress = tube.ply_stresses(np.array([torque, -torque]))
    return Layup(
        tube=tube,
        strength_share=float(1 / strength_ratio(stress, tube.ply).min()),
        buckling_share=torque / tube.buckling_torque(),
        speed_share=speed / (speed_limit * float(tube.critical_speed(length))),
    )


def lightest(
    *,
    torque: NewtonMetre,
    speed: float,
    length: Metre,
    outer: Metre,
    ply: Ply = CARBON_EPOXY,
    angles: Iterable[float] = (0.0, pi / 12, pi / 6, pi / 4, pi / 2),
    most: int = 40,
    speed_limit: float = 0.75,
) -> Layup:
    """Search for the lightest layup that carries a torque below a share of whirl.

    Balanced pairs (+angle, -angle) of each of `angles` (0 and 90 deg pair with themselves)
    are counted in every combination, lightest first; order in the wall does not change
    membrane stresses. Arguments as for `judged`; `most` is the largest number of plies.

    Raises
    ------
    DesignError
        If no layup does: a larger diameter, a shorter shaft or another ply is needed.
    """
    choices = tuple(angles)
    turned = strain_turn(np.array([a for choice in choices for a in (choice, -choice)]))
    turned = turned.reshape(len(choices), 2, 3, 3)
    pair = (np.swapaxes(turned, -1, -2) @ ply.stiffness @ turned).sum(1) * ply.thickness
    for pairs in range(1, most // 2 + 1):
        counts = np.array([c for c in product(range(pairs + 1), repeat=len(choices) - 1)
                           if sum(c) <= pairs])  # fmt: skip
        counts = np.concatenate([counts, pairs - counts.sum(-1, keepdims=True)], axis=-1)
        wall = 2 * pairs * ply.thickness
        r = (outer - wall) / 2
        if not 2 * wall < outer / 2:
            break
        A = np.einsum("nk,kij->nij", counts, pair)
        with np.errstate(all="ignore"):
            # A single fibre direction leaves the wall without some stiffness, not singular.
            a = np.linalg.inv(A)
        axial, hoop = 1 / (wall * a[:, 0, 0]), 1 / (wall * a[:, 1, 1])
        strain = a[:, :, 2] * torque / (2 * pi * r**2)
        stress = np.einsum("kpij,nj->nkpi", ply.stiffness @ turned, strain)
        both = np.minimum(strength_ratio(stress, ply), strength_ratio(-stress, ply))
        weakest = np.where(counts[:, :, None] > 0, both, np.inf).min((1, 2))
        buckles = 2 * pi * r**2 * wall * 0.272 * (axial * hoop**3) ** 0.25 * (wall / r) ** 1.5
        whirls = pi**2 / length**2 * np.sqrt(axial * r**2 / (2 * ply.density))
        used = np.max([1 / weakest, torque / buckles, speed / (speed_limit * whirls)], axis=0)
        best = int(np.nanargmin(used))
        if used[best] <= 1:
            plies = [sign * choice for choice, count in zip(choices, counts[best], strict=True)
                     for _ in range(count) for sign in (1, -1)]  # fmt: skip
            tube = CompositeTube(outer=outer, ply=ply, angles=tuple(plies))
            return judged(tube, torque=torque, speed=speed, length=length, speed_limit=speed_limit)
    msg = (
        f"no layup of up to {most} plies of {ply.name}, {outer:g} m outside, carries "
        f"{torque:g} N m at {speed:g} rad/s over {length:g} m; try a larger diameter"
    )
    raise DesignError(msg)
