r"""Tubes wound of plies, or of plies on a metal tube: what they are, and how stiff.

Plies are thin, so each is in plane stress. A tube under torque, tension and bending
stretches, breathes and twists as a whole; at the radius R of a ply, with r that of the
middle of the wall, its strains are

$$\varepsilon_x,\qquad \frac{r}{R}\,\varepsilon_\theta,\qquad \frac{R}{r}\,\gamma$$

and what the plies' stresses do at them is integrated through the wall, each at its own
place. What the order of the plies does besides, B and D, decides whether the wall buckles
(`cardan.physics.strength.composite_tube`). Sources: Jones, Mechanics of Composite Materials (1999),
ch. 2 and 4; the tube's strains derived.
"""

from dataclasses import replace
from functools import cached_property
from math import pi, sqrt
from typing import Any

import numpy as np

from cardan.core.arrays import ArrayLike, FloatArray, stack_on_last_axis
from cardan.core.errors import DesignError, require_positive, values_of_first_violating_case
from cardan.core.lazy_dataclass import dataclass
from cardan.core.provenance import SOURCE_ASSUMED, Source
from cardan.core.units import GPa, Metre, MPa, Pascal, Radian, deg, mm
from cardan.model.material import Material

_GAUSS = np.array([-1.0, 0.0, 1.0]) * sqrt(0.6), np.array([5.0, 8.0, 5.0]) / 18
"""Places in a ply from -1 to 1 and their weights: exact for powers of z up to the fifth."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Ply:
    """A unidirectional ply, or a metal as a layer. Strengths are positive, compression too.

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
    source: Source = SOURCE_ASSUMED

    def __post_init__(self) -> None:
        require_positive(
            f"ply {self.name}", along=self.along, across=self.across, shear=self.shear,
            tension_along=self.tension_along, compression_along=self.compression_along,
            tension_across=self.tension_across, compression_across=self.compression_across,
            shear_strength=self.shear_strength, thickness=self.thickness, density=self.density,
        )  # fmt: skip
        most = np.sqrt(self.along / self.across)
        if wrong := values_of_first_violating_case(np.abs(self.poisson) < most, most, self.poisson):
            msg = (
                f"Poisson's ratio of ply {self.name} must be below √(E₁/E₂) = {wrong[0]:.3g} "
                f"in size, or it gives energy away; got {wrong[1]:g}"
            )
            raise DesignError(msg)

    @property
    def stiffness(self) -> FloatArray:
        """Reduced stiffness Q (..., 3, 3) Pa in the ply's own axes."""
        other = self.poisson * self.across / self.along
        free = 1 - self.poisson * other
        both = self.poisson * self.across / free
        zero = 0 * both
        return stack_on_last_axis(
            [
                stack_on_last_axis([self.along / free, both, zero]),
                stack_on_last_axis([both, self.across / free, zero]),
                stack_on_last_axis([zero, zero, self.shear]),
            ]
        )  # fmt: skip  symmetric, so rows may stand as columns


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


def metal_ply(material: Material, *, thickness: Metre) -> Ply:
    """Return a metal as a layer of a hybrid tube: alike all round, failing where it yields.

    Its shear strength is R_e/√3, so that Tsai and Wu's criterion is von Mises's.

    Raises
    ------
    DesignError
        If the material has no yield strength: it is unknown what it carries.
    """
    Re = material.yield_strength
    if Re is None:
        msg = f"a layer of {material.name} needs a material with its yield strength"
        raise DesignError(msg)
    return Ply(
        name=material.name, along=material.youngs_modulus, across=material.youngs_modulus,
        shear=material.shear_modulus, poisson=material.poisson, tension_along=Re,
        compression_along=Re, tension_across=Re, compression_across=Re,
        shear_strength=Re / sqrt(3), thickness=thickness, density=material.density,
        source=material.source,
    )  # fmt: skip


def strain_rotation(angle: ArrayLike) -> FloatArray:
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
class OrientedPly:
    """One ply in its place; `angle` is of its fibres to the tube's axis, right-handed."""

    ply: Ply
    angle: Radian = 0.0


@dataclass(frozen=True, kw_only=True)
class CompositeTube:
    """A tube wound of plies, or of plies on metal.

    It has what a `Tube` has, so that whirl, torsion and loads need not know which it is.
    Numbers of its plies may be arrays (...): variants.

    Attributes
    ----------
    outer : m
        Outside diameter.
    layers
        Inside ply first.
    source
        Who says that it is wound so.
    """

    outer: Metre
    layers: tuple[OrientedPly, ...]
    source: Source = SOURCE_ASSUMED

    def __post_init__(self) -> None:
        if not self.layers:
            msg = "a composite tube needs at least one ply"
            raise DesignError(msg)
        require_positive("a composite tube", outer=self.outer)
        most = self.outer / 8
        if wrong := values_of_first_violating_case(self.wall <= most, most, self.wall, self.outer):
            msg = (
                f"the wall of a composite tube of {wrong[2] / mm:g} mm must be at most an eighth "
                f"of that, {wrong[0] / mm:g} mm: its plies are in plane stress; "
                f"{len(self.layers)} plies make {wrong[1] / mm:g} mm"
            )
            raise DesignError(msg)

    @classmethod
    def from_ply_angles(cls, ply: Ply, angles: Any, *, outer: Metre) -> "CompositeTube":
        """Return a tube of one kind of ply at `angles` rad, inside first."""
        return cls(outer=outer, layers=tuple(OrientedPly(ply=ply, angle=a) for a in angles))

    def reversed(self) -> "CompositeTube":
        """Return the tube with its plies in the opposite order, outside first."""
        return replace(self, layers=self.layers[::-1])

    @property
    def plies(self) -> tuple[Ply, ...]:
        """The material of each layer, inside first."""
        return tuple(layer.ply for layer in self.layers)

    @property
    def angles(self) -> tuple[Radian, ...]:
        """The fibres' angle in each layer, inside first."""
        return tuple(layer.angle for layer in self.layers)

    @cached_property
    def thicknesses(self) -> FloatArray:
        """Thickness (..., plies) m of each layer, inside first."""
        return stack_on_last_axis(ply.thickness for ply in self.plies)

    @property
    def wall(self) -> Any:
        """Thickness of all plies, (...) m."""
        wall = self.thicknesses.sum(-1)
        return wall if np.ndim(wall) else float(wall)

    @property
    def inner(self) -> Any:
        """Inside diameter, (...) m."""
        return self.outer - 2 * self.wall

    @property
    def radius(self) -> Any:
        """Radius of the middle of the wall, (...) m."""
        return (self.outer - self.wall) / 2

    @cached_property
    def stiffnesses(self) -> FloatArray:
        """Stiffness (..., plies, 3, 3) Pa of each ply in the tube's axes: along, hoop, shear."""
        turned = strain_rotation(stack_on_last_axis(self.angles))
        own = np.stack(np.broadcast_arrays(*(ply.stiffness for ply in self.plies)), axis=-3)
        return np.swapaxes(turned, -1, -2) @ own @ turned

    @cached_property
    def ply_boundaries(self) -> FloatArray:
        """Inside and outside of each ply from the middle of the wall, (..., plies, 2) m."""
        outside = np.cumsum(self.thicknesses, axis=-1) - np.asarray(self.wall)[..., None] / 2
        return np.stack([outside - self.thicknesses, outside], axis=-1)

    def integration_points(self) -> tuple[FloatArray, FloatArray]:
        """Places z (..., plies, 3) m in the wall, from its middle, and their weights, m."""
        places, weights = _GAUSS
        inside, outside = self.ply_boundaries[..., 0], self.ply_boundaries[..., 1]
        half = (outside - inside)[..., None] / 2
        return inside[..., None] + half * (1 + places), 2 * half * weights

    @property
    def abd_matrix(self) -> FloatArray:
        """[[A, B], [B, D]] (..., 6, 6): forces and moments per width of strains and bends."""
        z, weight = self.integration_points()
        powers = z[..., None] ** np.arange(3) * weight[..., None]
        A, B, D = np.einsum("...kgp,...kij->p...ij", powers, self.stiffnesses)
        return np.concatenate(
            [np.concatenate([A, B], axis=-1), np.concatenate([B, D], axis=-1)], axis=-2
        )

    @property
    def membrane_stiffness(self) -> FloatArray:
        """A (..., 3, 3) N/m: forces per width of membrane strains."""
        return self.abd_matrix[..., :3, :3]

    def _uniform(self, powers: tuple[float, float, float]) -> FloatArray:
        """Stiffness (..., 3, 3) N/m of the whole wall where strains go with powers of R/r."""
        z, weight = self.integration_points()
        share = 1 + z / np.asarray(self.radius)[..., None, None]
        field = stack_on_last_axis(share**p for p in powers)
        one = np.einsum("...kg,...kgi,...kij,...kgj->...ij", weight * share, field,
                        self.stiffnesses, field)  # fmt: skip
        return np.asarray(one, dtype=float)

    @cached_property
    def wall_stiffness(self) -> FloatArray:
        """Forces per width of (εx, εθ, γ) at the middle of the wall, (..., 3, 3) N/m.

        Each ply at its own radius: the hoop strain of a tube that breathes falls with it,
        the shear of one that twists grows.
        """
        return self._uniform((0.0, -1.0, 1.0))

    @property
    def moduli(self) -> tuple[Any, Any, Any]:
        """Axial, hoop and shear modulus (...) Pa of the wall: 1/(t a₁₁), 1/(t a₂₂), 1/(t a₆₆)."""
        a = np.linalg.inv(self.membrane_stiffness)
        axial, hoop, shear = (1 / (self.wall * a[..., k, k]) for k in range(3))
        return axial, hoop, shear

    @property
    def torsional_stiffness(self) -> Any:
        """G J, (...) N m²: torque over twist per length, free to lengthen and breathe."""
        return 2 * pi * self.radius**3 / np.linalg.inv(self.wall_stiffness)[..., 2, 2]

    @property
    def bending_stiffness(self) -> Any:
        """E I, (...) N m²: every strain of a bent tube grows with the radius."""
        return pi * self.radius**3 / np.linalg.inv(self._uniform((1.0, 1.0, 1.0)))[..., 0, 0]

    @property
    def shear_stiffness(self) -> Any:
        """κ G A, (...) N, with κ = 1/2: the energy of the shear flow V sin θ / (π r)."""
        return self.moduli[2] * pi * self.radius * self.wall

    @property
    def area(self) -> Any:
        """Area of the section, (...) m²."""
        return 2 * pi * self.radius * self.wall

    @property
    def second_moment(self) -> Any:
        """Second moment of the section in bending, (...) m⁴, whatever it is made of."""
        return pi / 64 * (self.outer**4 - self.inner**4)

    def _of_mass(self, power: int) -> Any:
        """∫ ρ R^power dA, each ply at its own radius."""
        z, weight = self.integration_points()
        R = np.asarray(self.radius)[..., None, None] + z
        rho = stack_on_last_axis(ply.density for ply in self.plies)[..., None]
        return 2 * pi * (rho * R ** (power + 1) * weight).sum((-1, -2))

    @property
    def mass_per_length(self) -> Any:
        """Mass per length, (...) kg/m."""
        return self._of_mass(0)

    @property
    def polar_inertia_per_length(self) -> Any:
        """Mass moment of inertia about the axis per length, (...) kg m."""
        return self._of_mass(2)

    @property
    def name(self) -> str:
        """Its kinds of ply, as tables name them."""
        return " + ".join(dict.fromkeys(ply.name for ply in self.plies))

    @property
    def layup(self) -> str:
        """Angles of the plies from the inside out, as drawings have them: 15/-15/(45/-45)5."""
        names = [
            f"{layer.ply.name} {np.ravel(layer.ply.thickness)[0] / mm:g} mm"
            if layer.ply.along is layer.ply.across
            else f"{np.ravel(layer.angle)[0] / deg:.4g}"
            for layer in self.layers
        ]
        said: list[str] = []
        at = 0
        while at < len(names):
            runs = [(size, _repeats(names, at, size)) for size in (1, 2, 3, 4)]
            size, times = max(runs, key=lambda run: (run[1] - 1) * run[0])
            one = "/".join(names[at : at + size])
            said.append(one if times == 1 else f"({one}){times}")
            at += size * times
        return "/".join(said)

    @property
    def material(self) -> Material:
        """What one material of the same section would have to be, in bending and in torsion.

        E = E I / I and ν so that G = G J / 2 I; no strength, which belongs to the plies. Not
        for anything that ν itself goes into.
        """
        E = self.bending_stiffness / self.second_moment
        G = self.torsional_stiffness / (2 * self.second_moment)
        return Material(
            name=self.name, youngs_modulus=E, poisson=E / (2 * G) - 1,
            density=self.mass_per_length / self.area, source=self.plies[-1].source,
        )  # fmt: skip


def _repeats(names: list[str], at: int, size: int) -> int:
    """Return how often the `size` names from a place on stand there one after the other."""
    one, times = names[at : at + size], 1
    while names[at + times * size : at + (times + 1) * size] == one:
        times += 1
    return times
