r"""Lateral motion of a shaft that a universal joint drives: flutter and parametric zones.

The driven shaft hangs on its joint and on a compliant bearing. Its lateral motion is the
complex z = x + i y; the joint's moment acts square to the cross, so it turns with the shaft
and couples z with its conjugate twice a turn:

$$M\ddot z + C\dot z + K z + N\bar z + S e^{2i\Omega t}\bar z = f(t)$$

Torque T about the driving shaft puts the moment T [d - a (a·d)]/(d₀·d) on the driven one.
Sources: Mazzei, Argento & Scott, J. Sound Vib. 222 (1999) 19-47 (rigid shaft); Mazzei &
Scott, J. Sound Vib. 268 (2003) (flexible); internal damping as Vatta & Vigliani, Mech.
Mach. Theory 43 (2008). Compared here: the models, against growth rates of an independent
program and of a multibody engine. The papers' figures were not at hand and are not compared.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np

from cardan.core.arrays import ArrayLike, ComplexArray, FloatArray
from cardan.core.errors import ConvergenceError, DesignError
from cardan.physics.dynamics.floquet import (
    PeriodicSystem,
    collocation_operator,
    differentiation_matrix,
    eigenvalues,
)
from cardan.physics.kinematics.joint_chain import cross_product, dot_product


def _real(matrix: ComplexArray, *, mirrored: bool = False) -> FloatArray:
    """Matrix that does to (x, y) what a complex one does to z (to its conjugate if mirrored)."""
    a, b = matrix.real, matrix.imag
    sign = -1.0 if mirrored else 1.0
    top = np.concatenate([a, -sign * b], axis=-1)
    return np.concatenate([top, np.concatenate([b, sign * a], axis=-1)], axis=-2)


@dataclass(frozen=True, slots=True, kw_only=True)
class LateralSystem:
    """M z'' + C z' + K z + N z* + S e^{2iΩt} z* = 0, complex; cases on leading axes.

    Attributes
    ----------
    speed : (...) rad/s
        Ω, above 0.
    mass, damping, stiffness : (..., m, m) complex
        M, C and K of z.
    stiffness_asymmetry : (..., m, m) complex
        N: bearings stiffer one way than the other.
    rotating_stiffness : (..., m, m) complex
        S: the joint, turning with the shaft.
    """

    speed: FloatArray
    mass: ComplexArray
    damping: ComplexArray
    stiffness: ComplexArray
    stiffness_asymmetry: ComplexArray
    rotating_stiffness: ComplexArray

    @property
    def periodic_system(self) -> PeriodicSystem:
        """The same for x and y, real and periodic in half a turn: z = x + i y."""
        M, C, K = (
            _real(part)[..., None, :, :] for part in (self.mass, self.damping, self.stiffness)
        )
        N = _real(self.stiffness_asymmetry, mirrored=True)[..., None, :, :]

        def matrices(phase: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
            turning = np.exp(2j * np.pi * phase)[:, None, None]
            S = _real(self.rotating_stiffness[..., None, :, :] * turning, mirrored=True)
            return M, C, K + N + S

        return PeriodicSystem(period=np.pi / self.speed, matrices=matrices)

    def rotating_frame_exponents(self) -> ComplexArray:
        """Exponents (..., 4m) 1/s of z e^{-iΩt}, exact: equal bearings only.

        Seen from the turning shaft nothing is periodic, so stability is a plain
        eigenvalue problem of z e^{-iΩt} and its conjugate.

        Raises
        ------
        DesignError
            If the bearings are unequal; use `growth(whirl.system)`.
        """
        if np.any(self.stiffness_asymmetry):
            msg = "the rotating frame needs bearings equal all round; use growth(whirl.system)"
            raise DesignError(msg)
        iw = 1j * self.speed[..., None, None]
        M, C, K, S = np.broadcast_arrays(
            self.mass,
            self.damping + 2 * iw * self.mass,
            self.stiffness + iw * self.damping + iw**2 * self.mass,
            self.rotating_stiffness,
        )
        m = M.shape[-1]
        none = np.zeros_like(M)

        def pair(own: ComplexArray, other: ComplexArray) -> ComplexArray:
            return np.block([[own, other], [other.conj(), own.conj()]])

        inverse = np.linalg.inv(pair(M, none))
        A = np.zeros((*M.shape[:-2], 4 * m, 4 * m), dtype=complex)
        A[..., : 2 * m, 2 * m :] = np.eye(2 * m)
        A[..., 2 * m :, : 2 * m] = -inverse @ pair(K, S)
        A[..., 2 * m :, 2 * m :] = -inverse @ pair(C, none)
        return eigenvalues(A)


def _single(value: ArrayLike) -> ComplexArray:
    """Return scalars (...) as complex matrices (..., 1, 1)."""
    return np.asarray(value, dtype=complex)[..., None, None]


def rigid_shaft_system(
    *,
    speed: ArrayLike,
    torque: ArrayLike,
    transverse_inertia: ArrayLike,
    polar_inertia: ArrayLike,
    stiffness: ArrayLike,
    damping: ArrayLike = 0.0,
    stiffness_difference: ArrayLike = 0.0,
    internal_damping: ArrayLike = 0.0,
    follower: ArrayLike = 1.0,
) -> LateralSystem:
    r"""Return Mazzei's rigid shaft, driven by a joint in line with its driving shaft.

    $$I_t\ddot z + (c - i I_a\Omega)\dot z + k z
      + \tfrac{i T}{2}\left[(1-2\sigma) z - e^{2i\Omega t}\bar z\right] = 0$$

    Parameters
    ----------
    speed, torque : (...) rad/s, N m
        Ω, above 0, and T.
    transverse_inertia, polar_inertia : (...) kg m²
        I_t about the joint centre, I_a about the shaft's axis.
    stiffness, damping : (...) N m/rad, N m s/rad
        k and c of the bearing about the joint centre, mean of the two directions.
    stiffness_difference : (...) N m/rad
        (k_x - k_y) / 2 of a bearing stiffer in x than in y.
    internal_damping : (...) N m s/rad
        Of what turns with the shaft.
    follower : (...) 1
        σ: 1 where the load torque follows the shaft's axis, 0 where it stays along the
        driving shaft.

    Notes
    -----
    z is the shaft's inclination. Undamped flutter is of first order in T: a follower
    torque beyond about 4 ζ k makes the shaft flutter at any speed clear of the zones.
    """
    speed, T, It, Ia, k, c, dk, ci, sigma = np.broadcast_arrays(
        *(np.asarray(v, dtype=float) for v in (
            speed, torque, transverse_inertia, polar_inertia, stiffness, damping,
            stiffness_difference, internal_damping, follower,
        ))
    )  # fmt: skip
    return LateralSystem(
        speed=speed,
        mass=_single(It),
        damping=_single(c + ci - 1j * Ia * speed),
        stiffness=_single(k - 1j * speed * ci + 0.5j * T * (1 - 2 * sigma)),
        stiffness_asymmetry=_single(dk),
        rotating_stiffness=_single(-0.5j * T),
    )


def flexible_shaft_system(
    *,
    speed: ArrayLike,
    torque: ArrayLike,
    length: ArrayLike,
    bending_stiffness: ArrayLike,
    mass_per_length: ArrayLike,
    bearing: ArrayLike,
    bearing_damping: ArrayLike = 0.0,
    bearing_difference: ArrayLike = 0.0,
    rotary_inertia: ArrayLike = 0.0,
    end_mass: ArrayLike = 0.0,
    internal_damping: ArrayLike = 0.0,
    follower: ArrayLike = 1.0,
    functions: int = 6,
) -> LateralSystem:
    """Return a flexible driven shaft between its joint and a compliant bearing, by Galerkin.

    The virtual work of the torque is that of the rigid shaft at the joint and the load
    end, and -iT ∫ v'* w'' along the bent shaft, which cannot be had from a potential.

    Parameters
    ----------
    speed, torque : (...) rad/s, N m
        As for `rigid_shaft_system`.
    length : (...) m
        From joint to bearing, where the load is too.
    bending_stiffness, mass_per_length : (...) N m², kg/m
        E I and rho A.
    bearing, bearing_damping, bearing_difference : (...) N/m, N s/m, N/m
        Mean stiffness and damping of the bearing, and half its x less its y stiffness.
    rotary_inertia : (...) kg m
        rho I per length; twice it is polar (a Rayleigh beam with gyroscopic moments).
    end_mass : (...) kg
        On the bearing.
    internal_damping : (...) s
        Of the material: E I (1 + internal_damping d/dt), turning with the shaft.
    follower : (...) 1
        As for `rigid_shaft_system`.
    functions
        Legendre polynomials times the distance from the joint. The first alone is the rigid
        shaft; six give the growth of its lowest mode to ten digits.

    Notes
    -----
    The torque also works on the bending modes, with nothing but `internal_damping` and the
    bearing to hold them: without any, growth rates of ever higher modes appear with more
    functions, and only those of the low modes mean anything.
    """
    given = (speed, torque, length, bending_stiffness, mass_per_length, bearing, bearing_damping,
             bearing_difference, rotary_inertia, end_mass, internal_damping, follower)  # fmt: skip
    values = np.broadcast_arrays(*(np.asarray(v, dtype=float) for v in given))
    (W, T, L, EI, rhoA, k, c, dk, rhoI, m, ci, sigma) = (v[..., None, None] for v in values)
    legendre = np.polynomial.legendre
    x, weight = legendre.leggauss(functions + 3)
    weight = weight / 2

    def sampled(x: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return w, L w' and L² w'' of every function at x of [-1, 1]."""
        P, dP, ddP = (
            np.stack([legendre.Legendre.basis(j).deriv(d)(x) if d else legendre.Legendre.basis(j)(x)
                      for j in range(functions)])
            for d in range(3)
        )  # fmt: skip
        u = (x + 1) / 2
        return u * P, P + 2 * u * dP, 4 * dP + 4 * u * ddP

    def inner(a: FloatArray, b: FloatArray) -> FloatArray:
        return (a * weight) @ b.T

    w, dw, ddw = sampled(x)
    start, end = (sampled(np.array([side])) for side in (-1.0, 1.0))
    slope = inner(dw, dw)
    bent = EI / L**3 * inner(ddw, ddw)
    tip = end[0] @ end[0].T
    at_joint, at_end = start[1] @ start[1].T / L**2, end[1] @ end[1].T / L**2
    working = 1j * T * ((1 - sigma) * at_end - at_joint / 2 - inner(dw, ddw) / L**2)
    return LateralSystem(
        speed=values[0],
        mass=(rhoA * L * inner(w, w) + rhoI / L * slope + m * tip).astype(complex),
        damping=c * tip + ci * bent - 2j * W * rhoI / L * slope,
        stiffness=bent + k * tip - 1j * W * ci * bent + working,
        stiffness_asymmetry=(dk * tip).astype(complex),
        rotating_stiffness=-0.5j * T * at_joint,
    )


def natural_frequencies(whirl: LateralSystem) -> FloatArray:
    """Undamped frequencies (..., m) rad/s at standstill: what a tap test finds."""
    K = whirl.stiffness.real
    values = np.linalg.eigvals(np.linalg.solve(whirl.mass.real, K))
    return np.sort(np.sqrt(np.maximum(values.real, 0.0)), axis=-1)


def misaligned_shaft_system(
    *,
    speed: ArrayLike,
    torque: ArrayLike,
    beta: ArrayLike,
    transverse_inertia: ArrayLike,
    polar_inertia: ArrayLike,
    stiffness: tuple[ArrayLike, ArrayLike],
    damping: ArrayLike = 0.0,
    follower: ArrayLike = 1.0,
) -> tuple[PeriodicSystem, FloatArray]:
    r"""Return the rigid shaft at a nominal joint angle: small motions, and what they are about.

    The joint bends the shaft aside and shakes it twice a turn. That forced motion is found
    first, exactly, and small motions are linear about it. With the shaft's direction d, its
    spin s about it, the cross's normal N = d - a (a·d) and the moment m of the load,

    $$I_t\,\ddot d \cdot \partial_i d + I_a s\,\dot d \cdot (d \times \partial_i d)
      = \left[(I_a \dot s - m \cdot d) \frac{N}{N \cdot d} + m\right] \cdot
        (d \times \partial_i d) - c\,\dot q_i - k_i q_i$$

    and the joint sets the spin, N·(s d + d × d') = N·d₀ Ω, so that it answers to every tilt.

    Parameters
    ----------
    speed, torque : (...) rad/s, N m
        Ω of the driving shaft and T of the load, both constant.
    beta : (...) rad
        Nominal joint angle; x of the motion lies in the plane of the two shafts.
    transverse_inertia, polar_inertia, damping, follower
        As for `rigid_shaft_system`. A load that stays along the driving shaft is T / cos β there.
    stiffness : two of (...) N m/rad
        Of the bearing about the joint, for motion in the plane of the shafts and square to it.

    Returns
    -------
    system : PeriodicSystem
        For (x, y), inclinations in rad.
    motion : (..., 33, 2) rad
        The forced inclinations from the nominal axis, at equal instants of half a turn; nan
        in cases where none is found.

    Raises
    ------
    ConvergenceError
        If no forced motion is found in any case: torque or angle bend the shaft too far.

    Notes
    -----
    By Lagrange in the two coordinates x and y, with z = √(1 - x² - y²): no small angles.
    Its derivatives are taken by complex steps (Squire & Trapp 1998), exact to rounding.
    """
    values = (speed, torque, beta, transverse_inertia, polar_inertia, *stiffness, damping, follower)
    shaft = _Misaligned(*np.broadcast_arrays(*(np.asarray(v, dtype=float) for v in values)))
    samples = 33
    phase, period = np.arange(samples) / samples, np.pi / shaft.speed
    D = differentiation_matrix(samples)
    D1, D2 = D / period[..., None, None], D @ D / period[..., None, None] ** 2
    q, largest = np.zeros((*shaft.speed.shape, samples, 2)), np.array(np.inf)
    lost = np.zeros((*shaft.speed.shape, 1, 1), dtype=bool)
    for _ in range(40):
        at = (q, D1 @ q, D2 @ q)
        full = collocation_operator(*shaft.tangent(phase, *at), period, samples)
        left = shaft.unbalanced(phase, *at).reshape(*shaft.speed.shape, -1, 1)
        step = np.linalg.solve(full, left).reshape(q.shape)
        largest = np.abs(step).max((-1, -2), keepdims=True)
        q = q - step * np.minimum(1.0, 0.2 / np.maximum(largest, 1e-300))
        # A case that leaves for a right angle has no solution; the others go on without it.
        lost |= np.abs(q).max((-1, -2), keepdims=True) >= 0.7
        q = np.where(lost, 0.0, q)
        if np.all((largest < 1e-12) | lost):
            break
    lost |= largest >= 1e-12
    if lost.all():
        msg = "no forced motion of the misaligned shaft found; is its bearing stiff enough?"
        raise ConvergenceError(msg)
    spectrum = np.fft.rfft(q, axis=-2) / samples
    order = np.arange(samples // 2 + 1)
    weight = np.where(order == 0, 1.0, 2.0)
    rate = 2j * np.pi * order / period[..., None]

    def matrices(phase: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        wave = weight * np.exp(2j * np.pi * phase[:, None] * order)
        motion = (np.real(wave @ (rate[..., None] ** k * spectrum)) for k in range(3))
        M, C, K = shaft.tangent(phase, *motion)
        return M, C, np.where(lost[..., None], np.nan, K)

    return PeriodicSystem(period=period, matrices=matrices), np.where(lost, np.nan, q)


@dataclass(frozen=True, slots=True)
class _Misaligned:
    """The rigid shaft at a nominal joint angle, each value (...), of `misaligned_shaft_system`."""

    speed: FloatArray
    torque: FloatArray
    beta: FloatArray
    transverse: FloatArray
    polar: FloatArray
    stiff: FloatArray
    stiff_across: FloatArray
    damping: FloatArray
    follower: FloatArray

    def unbalanced(self, phase: FloatArray, q: Any, v: Any, w: Any) -> Any:
        """Return what is left of the equation of motion at instants (..., s, 2), N m.

        At phases (s,) of half a turn, of inclinations q, their rates v and w; complex ones
        give complex ones, by the same analytic expressions.
        """
        W, T, b, It, Ia, kx, ky, c, sigma = (
            np.asarray(getattr(self, name))[..., None] for name in self.__slots__
        )
        cos, sin = np.cos(np.pi * phase), np.sin(np.pi * phase)

        def vector(*parts: Any) -> Any:
            return np.stack(np.broadcast_arrays(*parts), axis=-1)

        d0 = vector(-np.sin(b), 0.0, np.cos(b))
        a = vector(np.cos(b) * cos, sin, np.sin(b) * cos)
        turning = W[..., None] * vector(-np.cos(b) * sin, cos, -np.sin(b) * sin)
        z = np.sqrt(1 - (q * q).sum(-1))
        dz = -(q * v).sum(-1) / z
        ddz = -((v * v).sum(-1) + (q * w).sum(-1) + dz * dz) / z
        d, rate, bend = (
            np.concatenate([part, last[..., None]], axis=-1)
            for part, last in ((q, z), (v, dz), (w, ddz))
        )
        N = d - a * dot_product(a, d)[..., None]
        dN = rate - turning * dot_product(a, d)[..., None]
        dN = dN - a * (dot_product(turning, d) + dot_product(a, rate))[..., None]
        # N·(s d + d x d') = N·d0 W, and the same once more after time.
        free = d0 * W[..., None] - cross_product(d, rate)
        along = dot_product(N, d)
        spin = dot_product(N, free) / along
        sped = (
            dot_product(dN, free)
            - dot_product(N, cross_product(d, bend))
            - spin * (dot_product(dN, d) + dot_product(N, rate))
        ) / along
        load = -T[..., None] * (sigma[..., None] * d + ((1 - sigma) / np.cos(b))[..., None] * d0)
        moment = ((Ia * sped - dot_product(load, d)) / along)[..., None] * N + load
        moment = It[..., None] * cross_product(d, bend) + (Ia * spin)[..., None] * rate - moment
        held = vector(kx, ky) * q + c[..., None] * v
        # d x ∂d/∂x and d x ∂d/∂y, with ∂z/∂x = -x/z.
        x, y = q[..., 0], q[..., 1]
        tilts = (
            vector(-x * y / z, z + x * x / z, -y),
            vector(-z - y * y / z, x * y / z, x),
        )
        return np.stack([dot_product(moment, tilt) for tilt in tilts], axis=-1) + held

    def tangent(
        self, phase: FloatArray, q: FloatArray, v: FloatArray, w: FloatArray
    ) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return M, C and K (..., s, 2, 2) of small motions about a motion."""
        step, motion = 1e-30, (w, v, q)
        found: list[FloatArray] = []
        for k in range(3):
            columns: list[FloatArray] = []
            for unit in 1j * step * np.eye(2):
                w1, v1, q1 = (m + (unit if j == k else 0.0) for j, m in enumerate(motion))
                columns.append(np.imag(self.unbalanced(phase, q1, v1, w1)) / step)
            found.append(np.stack(columns, axis=-1))
        return found[0], found[1], found[2]
