r"""A composite tube as a shaft: failure of each ply, buckling of the wall, whirl, layup.

The laminate itself is `cardan.model.laminate`. Under torque the wall buckles as a shell,

$$K(n)\,q = T\,G(n)\,q,\qquad u, v, w = \left(U, V, W\right)(x)\,e^{i n \theta}$$

in n waves round, by Ritz's method: with the length between the ends, with how they are held,
with each ply where it lies in the wall (whose order can double the torque or halve it) and in
either sense of the torque. Kirchhoff's normals in the tube's own geometry, without Donnell's
approximation: a shaft buckles in two waves, where that is half as much again too high.
Sources: Flügge, Stresses in Shells (1973), ch. 8; Jones, Mechanics of Composite Materials
(1999); Khoshravan & Paykani, J. Appl. Res. Technol. 10 (2012) 826-834, whose steel tube is
compared; its other figures are not.
"""

from collections.abc import Iterable
from functools import cache, lru_cache
from itertools import product
from math import pi
from typing import Any, Literal, TypeAlias

import numpy as np

from cardan.core.arrays import (
    ArrayLike,
    ComplexArray,
    FloatArray,
    array_library_and_floats,
    single_threaded_blas,
    stack_on_last_axis,
)
from cardan.core.errors import ConvergenceError, DesignError
from cardan.core.lazy_dataclass import dataclass
from cardan.core.units import Metre, NewtonMetre, mm
from cardan.model.laminate import (
    CARBON_EPOXY,
    GLASS_EPOXY,
    CompositeTube,
    OrientedPly,
    Ply,
    metal_ply,
    strain_rotation,
)
from cardan.model.parts import Tube

TubeEndCondition: TypeAlias = Literal["pinned", "clamped"]
"""Pinned: the end keeps its circle, but leans and warps freely. Clamped: it does neither."""

_FUNCTIONS = (12, 18, 27, 40, 60)
"""Functions of x for each displacement, one after the other until the torque settles."""

_SETTLED = 1e-3
_MOST_WAVES = 24

# ----- strength ---------------------------------------------------------------------------


def ply_stresses(tube: CompositeTube, torque: ArrayLike) -> FloatArray:
    """Stresses (..., plies, 2, 3) Pa at the inside and outside of each ply, under (...) N m.

    Along and across the fibres, and in shear. The tube is free to lengthen and to breathe.
    """
    T = np.asarray(torque, dtype=float)[..., None]
    r = np.asarray(tube.radius)[..., None]
    strain = T / (2 * pi * r**2) * np.linalg.inv(tube.wall_stiffness)[..., :, 2]
    share = 1 + tube.ply_boundaries / r[..., None]
    field = stack_on_last_axis([1 + 0 * share, 1 / share, share])
    turned = strain_rotation(stack_on_last_axis(tube.angles))
    own = np.stack(np.broadcast_arrays(*(ply.stiffness for ply in tube.plies)), axis=-3) @ turned
    return np.einsum("...kij,...kej,...j->...kei", own, field, strain)


def _strengths(ply: Ply) -> tuple[FloatArray, ...]:
    return tuple(np.asarray(v, float) for v in (
        ply.tension_along, ply.compression_along, ply.tension_across, ply.compression_across,
        ply.shear_strength,
    ))  # fmt: skip


def maximum_stress_index(stress: FloatArray, ply: Ply) -> FloatArray:
    """Largest share (...) of its own strength that any of the stresses (..., 3) Pa uses."""
    Xt, Xc, Yt, Yc, S = _strengths(ply)
    s1, s2, s6 = np.moveaxis(stress, -1, 0)
    along = np.abs(s1) / np.where(s1 >= 0, Xt, Xc)
    across = np.abs(s2) / np.where(s2 >= 0, Yt, Yc)
    return np.maximum(np.maximum(along, across), np.abs(s6) / S)


def tsai_hill_index(stress: FloatArray, ply: Ply) -> FloatArray:
    """Tsai-Hill index (...) of stresses (..., 3) Pa: 1 is failure; goes with stress squared."""
    Xt, Xc, Yt, Yc, S = _strengths(ply)
    s1, s2, s6 = np.moveaxis(stress, -1, 0)
    X, Y = np.where(s1 >= 0, Xt, Xc), np.where(s2 >= 0, Yt, Yc)
    return (s1 / X) ** 2 - s1 * s2 / X**2 + (s2 / Y) ** 2 + (s6 / S) ** 2


def tsai_wu_index(stress: FloatArray, ply: Ply) -> FloatArray:
    """Tsai-Wu index (...) of stresses (..., 3) Pa: 1 is failure. F₁₂ = -½ √(F₁₁ F₂₂)."""
    linear, square = _tsai_wu(stress, ply)
    return linear + square


def _tsai_wu(stress: FloatArray, ply: Ply) -> tuple[FloatArray, FloatArray]:
    """Return what of the index goes with the stresses, and what with their squares."""
    Xt, Xc, Yt, Yc, S = _strengths(ply)
    s1, s2, s6 = np.moveaxis(stress, -1, 0)
    F11, F22 = 1 / (Xt * Xc), 1 / (Yt * Yc)
    linear = (1 / Xt - 1 / Xc) * s1 + (1 / Yt - 1 / Yc) * s2
    return linear, F11 * s1**2 + F22 * s2**2 + (s6 / S) ** 2 - np.sqrt(F11 * F22) * s1 * s2


def strength_ratio(stress: FloatArray, ply: Ply) -> FloatArray:
    """Factor (...) by which stresses (..., 3) may grow until Tsai-Wu says failure."""
    b, a = _tsai_wu(stress, ply)
    with np.errstate(divide="ignore"):
        return np.where(a > 0, 2 / (b + np.sqrt(b**2 + 4 * a)), np.inf)


def strength_utilisation(tube: CompositeTube, torque: ArrayLike) -> FloatArray:
    """Share (...) of its strength that a torque (...) N m uses, in whichever sense is worse.

    At the worst place of the worst ply, by the stricter of Tsai-Wu and maximum stress: first
    ply failure. Stresses left from curing are not in it.
    """
    T = np.abs(np.asarray(torque, dtype=float))
    shares: list[FloatArray] = []
    strengths = [s.shape for ply in tube.plies for s in _strengths(ply)]
    for sense in (1.0, -1.0):
        stress = ply_stresses(tube, sense * T)
        cases = np.broadcast_shapes(stress.shape[:-3], *strengths)
        stress = np.broadcast_to(stress, (*cases, *stress.shape[-3:]))
        for k, ply in enumerate(tube.plies):
            of = np.moveaxis(stress[..., k, :, :], -2, 0)
            shares.append((1 / strength_ratio(of, ply)).max(0))
            shares.append(maximum_stress_index(of, ply).max(0))
    return np.max(np.stack(np.broadcast_arrays(*shares)), axis=0)


# ----- buckling ---------------------------------------------------------------------------


@cache
def _basis(functions: int, ends: TubeEndCondition) -> tuple[FloatArray, FloatArray]:
    """Return u, u', v, v', w, w', w'' (7, 3, functions, points) on [-1, 1], and the weights.

    Legendre polynomials, times what makes them vanish where the end holds them. The second
    axis says whose displacement they are; those of another are 0.
    """
    legendre = np.polynomial.legendre
    x, weight = legendre.leggauss(functions + 4)
    P = np.stack([legendre.legval(x, np.eye(functions)[j]) for j in range(functions)])
    # Derivatives of P by its differential equation: (1 - x²) P'' = 2 x P' - j (j+1) P.
    j = np.arange(functions)[:, None]
    before = np.concatenate([np.zeros_like(P[:1]), P[:-1]])
    held = 1 - x**2
    dP = j * (before - x * P) / held
    ddP = (2 * x * dP - j * (j + 1) * P) / held
    once = held * P, held * dP - 2 * x * P, held * ddP - 4 * x * dP - 2 * P
    # The same again: (1 - x²)² P.
    twice = (
        held * once[0],
        held * once[1] - 2 * x * once[0],
        held * once[2] - 4 * x * once[1] - 2 * once[0],
    )
    u, v, w = (P, dP, ddP), once, once
    if ends == "clamped":
        u, w = once, twice
    field = np.zeros((7, 3, functions, x.size))
    for place, (owner, of) in enumerate(
        ((0, u[0]), (0, u[1]), (1, v[0]), (1, v[1]), (2, w[0]), (2, w[1]), (2, w[2]))
    ):
        field[place, owner] = of
    return field.reshape(7, 3 * functions, x.size), weight


def _wall(z: FloatArray, weight: FloatArray, Q: FloatArray, r: float, waves: int) -> ComplexArray:
    """Return the wall's energy as a form (7, 7) of u, u', v, v', w, w', w'' in n waves.

    Normals stay straight and square to the wall: u(z) = u - z w', v(z) = v R/r - z w,θ/r.
    """
    R, n = r + z.ravel(), 1j * waves
    at = z.ravel()
    strain = np.zeros((at.size, 3, 7), dtype=complex)
    strain[:, 0, 1], strain[:, 0, 6] = 1.0, -at
    strain[:, 1, 2], strain[:, 1, 4] = n / r, (1 - n**2 * at / r) / R
    strain[:, 2, 0], strain[:, 2, 3] = n / R, R / r
    strain[:, 2, 5] = -n * at * (1 / r + 1 / R)
    stiff = np.repeat(Q, z.shape[-1], axis=0) * (weight.ravel() * R / r)[:, None, None]
    return np.einsum("gai,gab,gbj->ij", strain.conj(), stiff, strain, optimize=True)


def _turning(r: float, waves: int) -> ComplexArray:
    """Return the work (7, 7) of a unit shear flow on the wall's turning and stretching.

    Green's strain in full, u,x u,θ + v,x (v,θ + w) + w,x (w,θ - v), over r.
    """
    n = 1j * waves
    rows = np.zeros((3, 2, 7), dtype=complex)
    rows[0, 0, 1], rows[0, 1, 0] = 1.0, n / r
    rows[1, 0, 3], rows[1, 1, 2], rows[1, 1, 4] = 1.0, n / r, 1 / r
    rows[2, 0, 5], rows[2, 1, 4], rows[2, 1, 2] = 1.0, n / r, -1 / r
    half = np.einsum("ki,kj->ij", rows[:, 0].conj(), rows[:, 1])
    return half + half.conj().T


def _buckling(
    z: FloatArray, weight: FloatArray, Q: FloatArray, r: float, length: float, *,
    waves: int, functions: int, ends: TubeEndCondition,
) -> tuple[float, float]:  # fmt: skip
    """Return the lowest buckling torques in n waves, forward and backward, N m."""
    from scipy.linalg import eigh

    field, share = _basis(functions, ends)
    # d/dx is 2/L d/ds on [-1, 1].
    scaled = field * (2 / length) ** np.array([0, 1, 0, 1, 0, 1, 2])[:, None, None]
    flat = scaled.transpose(1, 0, 2).reshape(scaled.shape[1], -1)

    def ritz(form: ComplexArray) -> ComplexArray:
        other = np.einsum("ab,bip->iap", form, scaled * (share * length / 2))
        return flat @ other.reshape(flat.shape).T

    stiff = ritz(_wall(z, weight, Q, r, waves))
    turned = ritz(_turning(r, waves)) / (2 * pi * r**2)
    size = 1 / np.sqrt(stiff.diagonal().real)
    K, G = (size[:, None] * (part + part.conj().T) * size / 2 for part in (stiff, turned))
    inverse = eigh(-G, K, eigvals_only=True)
    return float(1 / inverse[-1]), float(-1 / inverse[0])


@lru_cache(maxsize=1024)
@single_threaded_blas()
def _case(
    through: bytes, plies: bytes, r: float, length: float, ends: TubeEndCondition
) -> tuple[float, float]:
    """Return the least torques over all numbers of waves, forward and backward, N m.

    Of places and weights, and of stiffnesses, as their bytes: the same tube is computed
    again at every state, point and page, and takes 50 ms.
    """
    z, weight = np.frombuffer(through).reshape(2, -1, 3)
    Q = np.frombuffer(plies).reshape(-1, 3, 3)

    def settled(waves: int, least: FloatArray) -> FloatArray:
        last = np.array([np.inf, np.inf])
        for functions in _FUNCTIONS:
            found = np.array(_buckling(z, weight, Q, r, length, waves=waves, functions=functions,
                                       ends=ends))  # fmt: skip
            moved = np.abs(last / found - 1)
            # Far above the least it need not settle: it will not get down there any more.
            if np.all((moved < _SETTLED) | (found > least * (1 + 10 * moved))):
                return found
            last = found
        msg = (
            f"the buckling torque of a tube {length / r:.0f} radii long has not settled with "
            f"{_FUNCTIONS[-1]} functions: give the length between its yokes"
        )
        raise ConvergenceError(msg)

    # Two waves for most shafts; one is a bar's column, many are those of short wide tubes.
    least = settled(2, np.array([np.inf, np.inf]))
    least, rising = np.minimum(least, settled(1, least)), 0
    for waves in range(3, _MOST_WAVES):
        found = settled(waves, least)
        # Over the waves the torque falls to one least value and rises from there.
        rising = rising + 1 if np.all(found > least) else 0
        least = np.minimum(least, found)
        if rising == 2:
            break
    return float(least[0]), float(least[1])


def buckling_torques(
    tube: Tube | CompositeTube, length: ArrayLike, *, ends: TubeEndCondition = "pinned"
) -> FloatArray:
    """Torques (..., 2) N m that buckle a tube's wall: forward and backward.

    Parameters
    ----------
    tube
        Of plies, in their order, or of one metal. It is round, of one thickness and without
        a flaw: thin real ones buckle below this, by their dents.
    length : (...) m
        Between what keeps the ends round: the yokes.
    ends
        Pinned, the safe side; or clamped.

    Returns
    -------
    (..., 2) N m
        First the torque in the sense of a right-hand screw along the axis, by which angles of
        plies count too: it stretches fibres at +45 deg. Plies at +45 outside and -45 inside
        hold one sense better than the other.

    Raises
    ------
    ConvergenceError
        If the tube is longer than some hundred radii.

    Notes
    -----
    The shell stays elastic up to there, and its stress before buckling is uniform. Compared
    with another shell model, by sines and the laminate's A, B and D, to 0.7 %, and with a
    brick a ply in CalculiX (the tests `test_composite`).
    """
    if isinstance(tube, Tube):
        ply = metal_ply(_with_yield(tube.material), thickness=tube.wall)
        tube = CompositeTube(outer=tube.outer, layers=(OrientedPly(ply=ply),))
    z, weight = tube.integration_points()
    Q, r = tube.stiffnesses, np.asarray(tube.radius)
    L = np.asarray(length, dtype=float)
    cases = np.broadcast_shapes(z.shape[:-2], Q.shape[:-3], r.shape, L.shape)
    flat = [
        np.broadcast_to(part, (*cases, *part.shape[part.ndim - own :])).reshape(
            -1, *part.shape[part.ndim - own :]
        )
        for part, own in ((z, 2), (weight, 2), (Q, 3), (r, 0), (L, 0))
    ]
    found = [
        _case(np.stack([a, b]).tobytes(), c.tobytes(), float(d), float(e), ends)
        for a, b, c, d, e in zip(*flat, strict=True)
    ]
    return np.array(found).reshape(*cases, 2)


def _with_yield(material: Any) -> Any:
    """Return a material that may be a layer: what it yields at does not matter here."""
    from dataclasses import replace

    return replace(material, yield_strength=material.yield_strength or material.youngs_modulus)


def min_buckling_torque(
    tube: Tube | CompositeTube, length: ArrayLike, *, ends: TubeEndCondition = "pinned"
) -> FloatArray:
    """Torque (...) N m that buckles a tube's wall in the sense it holds less well."""
    return buckling_torques(tube, length, ends=ends).min(-1)


# ----- whirl ------------------------------------------------------------------------------


def timoshenko_critical_speed(tube: Tube | CompositeTube, length: ArrayLike) -> FloatArray:
    r"""First bending critical speed (...) rad/s between joint centres (...) m apart, with shear.

    A Timoshenko beam pinned at both ends, whirling once a turn: with k = π/L, the mass m and
    the polar inertia 2 ρI per length the lowest ω of

    $$(\kappa G A\,k^2 - m\omega^2)(E I\,k^2 + \kappa G A + \rho I \omega^2) = (\kappa G A\,k)^2$$

    Gyroscopic moments stiffen forward whirl by as much as rotary inertia would soften a
    vibration. Shear makes carbon tubes 5 to 25 % slower than `π²/L² √(EI/m)`.
    """
    L = np.asarray(length, dtype=float)
    k2 = (pi / L) ** 2
    EI, S, m = tube.bending_stiffness, tube.shear_stiffness, tube.mass_per_length
    J = tube.polar_inertia_per_length / 2
    # -m J w⁴ + b w² + EI S k⁴ = 0 in w², less what cancels.
    b = S * k2 * J - m * (EI * k2 + S)
    return np.sqrt((b + np.sqrt(b**2 + 4 * m * J * EI * S * k2**2)) / (2 * m * J))


# ----- sizing -----------------------------------------------------------------------------


def equivalent_steel_wall_thickness(
    torque: ArrayLike,
    *,
    outer_radius: ArrayLike,
    yield_strength: ArrayLike,
    at: Literal["outside", "middle"] = "outside",
) -> FloatArray:
    """Wall (...) m a steel tube needs to carry a torque: √3 τ = R_e.

    Parameters
    ----------
    torque, outer_radius, yield_strength : (...) N m, m, Pa
    at
        Where τ is taken: outside, where it is largest, τ = 16 T D / (π (D⁴ - d⁴)); or in the
        middle of the wall, τ = T / (2π r² t), as papers size thin tubes, some percent too
        thin.

    Raises
    ------
    DesignError
        If no wall of that radius carries the torque.
    """
    _, T, R, Re = array_library_and_floats(torque, outer_radius, yield_strength)
    wanted = T * np.sqrt(3) / (2 * pi * Re)
    if at == "outside":
        inside = R**4 - 4 * R * wanted
        if np.any(inside < 0):
            raise DesignError(_too_much(R, T, "no steel bar or tube"))
        return R - inside**0.25
    # t (R - t/2)² rises up to t = 2R/3; beyond half the radius the tube is not thin.
    if np.any(wanted > R / 2 * (0.75 * R) ** 2):
        raise DesignError(_too_much(R, T, "no thin steel tube"))
    t = wanted / R**2
    for _ in range(60):
        middle = R - t / 2
        t = t - (t * middle**2 - wanted) / (middle**2 - t * middle)
    return t


def _too_much(R: FloatArray, T: FloatArray, what: str) -> str:
    return f"{what} of radius {np.max(R) / mm:g} mm carries {np.max(T):g} N m"


@dataclass(frozen=True, slots=True, kw_only=True)
class LayupResult:
    """A tube that meets its demands, and by how much: each share is demand over capacity."""

    tube: CompositeTube
    strength_utilisation: float
    buckling_utilisation: float
    speed_utilisation: float

    @property
    def mass_per_length(self) -> float:
        """Mass per length, kg/m."""
        return self.tube.mass_per_length

    @property
    def max_utilisation(self) -> float:
        """The share that decides."""
        return max(self.strength_utilisation, self.buckling_utilisation, self.speed_utilisation)


def assess_layup(
    tube: CompositeTube,
    *,
    torque: NewtonMetre,
    speed: float,
    length: Metre,
    speed_limit: float,
    ends: TubeEndCondition = "pinned",
) -> LayupResult:
    """Return how much of a tube's capacity a torque N m and a speed rad/s use over `length` m.

    Torque counts both ways. `speed_limit` is the share of the critical speed that may be
    used (0.75 by the manuals); strength and buckling are held as they come, so put the
    safety factor into the torque.
    """
    return LayupResult(
        tube=tube,
        strength_utilisation=float(strength_utilisation(tube, torque)),
        buckling_utilisation=float(torque / min_buckling_torque(tube, length, ends=ends)),
        speed_utilisation=float(speed / (speed_limit * timoshenko_critical_speed(tube, length))),
    )


def lightest_layup(
    *,
    torque: NewtonMetre,
    speed: float,
    length: Metre,
    outer: Metre,
    ply: Ply = CARBON_EPOXY,
    angles: Iterable[float] = (0.0, pi / 12, pi / 6, pi / 4, pi / 2),
    most: int = 40,
    speed_limit: float = 0.75,
    ends: TubeEndCondition = "pinned",
) -> LayupResult:
    """Search for the lightest layup that carries a torque below a share of whirl.

    Balanced pairs (+angle, -angle) of each of `angles` (0 and 90 deg pair with themselves)
    are counted in every combination, fewest plies first; each is stacked with the angles
    rising outwards and falling. Arguments as for `judged`; `most` is the largest number of
    plies. Of the first number that holds the layup with the largest margin is returned.

    Raises
    ------
    DesignError
        If no layup does: a larger diameter, a shorter shaft or another ply is needed.
    """
    choices = sorted(angles)
    demand: dict[str, Any] = {"torque": torque, "speed": speed, "length": length}
    demand |= {"speed_limit": speed_limit, "ends": ends}
    for pairs in range(1, most // 2 + 1):
        if 2 * pairs * ply.thickness > outer / 8:
            break
        best: LayupResult | None = None
        for counts in _hopeful(choices, pairs, ply=ply, outer=outer, **demand):
            stack = [sign * a for a, count in zip(choices, counts, strict=True)
                     for _ in range(count) for sign in (1, -1)]  # fmt: skip
            tube = CompositeTube.from_ply_angles(ply, stack, outer=outer)
            for ordered in (tube, tube.reversed()):
                share = 1.0 if best is None else best.max_utilisation
                if _buckles(ordered, share, **demand):
                    continue
                found = assess_layup(ordered, **demand)
                if found.max_utilisation <= share:
                    best = found
        if best is not None:
            return best
    msg = (
        f"no layup of up to {most} plies of {ply.name}, {outer / mm:g} mm outside, carries "
        f"{torque:g} N m at {speed:g} rad/s over {length:g} m; try a larger diameter"
    )
    raise DesignError(msg)


def _hopeful(
    choices: list[float], pairs: int, *, ply: Ply, outer: float, torque: float, speed: float,
    length: float, speed_limit: float, ends: TubeEndCondition,
) -> list[list[int]]:  # fmt: skip
    """Return the counts of pairs that hold by a thin wall's stress and a slender shaft's whirl.

    Whatever the order. Both are out by less than a tenth: what fails them by that fails.
    """
    del ends
    turned = strain_rotation(np.array([a for choice in choices for a in (choice, -choice)]))
    turned = turned.reshape(len(choices), 2, 3, 3)
    pair = (np.swapaxes(turned, -1, -2) @ ply.stiffness @ turned).sum(1) * ply.thickness
    every = product(range(pairs + 1), repeat=len(choices))
    counts = np.array([c for c in every if sum(c) == pairs])
    wall = 2 * pairs * ply.thickness
    r = (outer - wall) / 2
    a = np.linalg.inv(np.einsum("nk,kij->nij", counts, pair))
    strain = a[:, :, 2] * torque / (2 * pi * r**2)
    stress = np.einsum("kpij,nj->nkpi", ply.stiffness @ turned, strain)
    both = np.minimum(strength_ratio(stress, ply), strength_ratio(-stress, ply))
    weakest = np.where(counts[:, :, None] > 0, both, np.inf).min((1, 2))
    whirls = pi**2 / length**2 * np.sqrt(r**2 / (2 * ply.density * wall * a[:, 0, 0]))
    hope = (weakest > 0.9) & (speed_limit * whirls > 0.9 * speed)
    return counts[hope].tolist()


def _buckles(
    tube: CompositeTube,
    share: float,
    *,
    torque: float,
    length: float,
    ends: TubeEndCondition,
    **_: Any,
) -> bool:
    """Return whether two waves round already buckle a tube above a share of its torque.

    With few functions Ritz's torque is too high: what buckles there buckles.
    """
    z, weight = tube.integration_points()
    least = min(
        _buckling(z, weight, tube.stiffnesses, float(tube.radius), length, waves=2,
                  functions=_FUNCTIONS[0], ends=ends)
    )  # fmt: skip
    return torque > share * least


__all__ = [
    "CARBON_EPOXY",
    "GLASS_EPOXY",
    "CompositeTube",
    "LayupResult",
    "OrientedPly",
    "Ply",
    "TubeEndCondition",
    "assess_layup",
    "buckling_torques",
    "equivalent_steel_wall_thickness",
    "lightest_layup",
    "maximum_stress_index",
    "metal_ply",
    "min_buckling_torque",
    "ply_stresses",
    "strain_rotation",
    "strength_ratio",
    "strength_utilisation",
    "timoshenko_critical_speed",
    "tsai_hill_index",
    "tsai_wu_index",
]  # fmt: skip
