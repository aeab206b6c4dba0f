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

import numpy as np

from cardan.base.arrays import ArrayLike, ComplexArray, FloatArray
from cardan.base.errors import DesignError, NotConverged
from cardan.dynamics.periodic import Periodic, differentiation, eigenvalues, operator
from cardan.dynamics.torsion import transmitted


def _real(matrix: ComplexArray, *, mirrored: bool = False) -> FloatArray:
    """Matrix that does to (x, y) what a complex one does to z (to its conjugate if mirrored)."""
    a, b = matrix.real, matrix.imag
    sign = -1.0 if mirrored else 1.0
    top = np.concatenate([a, -sign * b], axis=-1)
    return np.concatenate([top, np.concatenate([b, sign * a], axis=-1)], axis=-2)


@dataclass(frozen=True, slots=True, kw_only=True)
class Whirl:
    """M z'' + C z' + K z + N z* + S e^{2iΩt} z* = 0, complex; cases on leading axes.

    Attributes
    ----------
    speed : (...) rad/s
        Ω, above 0.
    mass, damping, stiffness : (..., m, m) complex
        M, C and K of z.
    unequal : (..., m, m) complex
        N: bearings stiffer one way than the other.
    stirred : (..., m, m) complex
        S: the joint, turning with the shaft.
    """

    speed: FloatArray
    mass: ComplexArray
    damping: ComplexArray
    stiffness: ComplexArray
    unequal: ComplexArray
    stirred: ComplexArray

    @property
    def system(self) -> Periodic:
        """The same for x and y, real and periodic in half a turn: z = x + i y."""
        M, C, K = (
            _real(part)[..., None, :, :] for part in (self.mass, self.damping, self.stiffness)
        )
        N = _real(self.unequal, mirrored=True)[..., None, :, :]

        def matrices(phase: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
            turning = np.exp(2j * np.pi * phase)[:, None, None]
            S = _real(self.stirred[..., None, :, :] * turning, mirrored=True)
            return M, C, K + N + S

        return Periodic(period=np.pi / self.speed, matrices=matrices)

    def rotating_exponents(self) -> ComplexArray:
        """Exponents (..., 4m) 1/s of z e^{-iΩt}, exact: equal bearings only.

        Seen from the turning shaft nothing is periodic, so stability is a plain
        eigenvalue problem of z e^{-iΩt} and its conjugate.

        Raises
        ------
        DesignError
            If the bearings are unequal; use `growth(whirl.system)`.
        """
        if np.any(self.unequal):
            msg = "the rotating frame needs bearings equal all round; use growth(whirl.system)"
            raise DesignError(msg)
        iw = 1j * self.speed[..., None, None]
        M, C, K, S = np.broadcast_arrays(
            self.mass,
            self.damping + 2 * iw * self.mass,
            self.stiffness + iw * self.damping + iw**2 * self.mass,
            self.stirred,
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


def rigid_shaft(
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
) -> Whirl:
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
    return Whirl(
        speed=speed,
        mass=_single(It),
        damping=_single(c + ci - 1j * Ia * speed),
        stiffness=_single(k - 1j * speed * ci + 0.5j * T * (1 - 2 * sigma)),
        unequal=_single(dk),
        stirred=_single(-0.5j * T),
    )


def flexible_shaft(
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
) -> Whirl:
    """Return a flexible driven shaft between its joint and a compliant bearing, by Galerkin.

    The virtual work of the torque is that of the rigid shaft at the joint and the load
    end, and -iT ∫ v'* w'' along the bent shaft, which cannot be had from a potential.

    Parameters
    ----------
    speed, torque : (...) rad/s, N m
        As for `rigid_shaft`.
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
        As for `rigid_shaft`.
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
    return Whirl(
        speed=values[0],
        mass=(rhoA * L * inner(w, w) + rhoI / L * slope + m * tip).astype(complex),
        damping=c * tip + ci * bent - 2j * W * rhoI / L * slope,
        stiffness=bent + k * tip - 1j * W * ci * bent + working,
        unequal=(dk * tip).astype(complex),
        stirred=-0.5j * T * at_joint,
    )


def natural_frequencies(whirl: Whirl) -> FloatArray:
    """Undamped frequencies (..., m) rad/s at standstill: what a tap test finds."""
    K = whirl.stiffness.real
    values = np.linalg.eigvals(np.linalg.solve(whirl.mass.real, K))
    return np.sort(np.sqrt(np.maximum(values.real, 0.0)), axis=-1)


def misaligned_shaft(
    *,
    speed: ArrayLike,
    torque: ArrayLike,
    beta: ArrayLike,
    transverse_inertia: ArrayLike,
    polar_inertia: ArrayLike,
    stiffness: tuple[ArrayLike, ArrayLike],
    damping: ArrayLike = 0.0,
    follower: ArrayLike = 1.0,
) -> tuple[Periodic, FloatArray]:
    """Return the rigid shaft at a nominal joint angle: small motions, and what they are about.

    The joint bends the shaft aside and shakes it twice a turn. That forced motion is found
    first, with the joint's full moment, and small motions are linear about it.

    Parameters
    ----------
    speed, torque : (...) rad/s, N m
        Ω of the driving shaft and T of the load, both constant.
    beta : (...) rad
        Nominal joint angle; x of the motion lies in the plane of the two shafts.
    transverse_inertia, polar_inertia, damping, follower
        As for `rigid_shaft`. The polar inertia is sped and slowed by the joint; how that
        answers to small motions is left out, of order I_a tan²β / I_t.
    stiffness : two of (...) N m/rad
        Of the bearing about the joint, for motion in the plane of the shafts and square to it.

    Returns
    -------
    system : Periodic
        For (x, y), inclinations in rad.
    motion : (..., 33, 2) rad
        The forced inclinations from the nominal axis, at equal instants of half a turn.

    Raises
    ------
    NotConverged
        If no forced motion is found: torque or angle bend the shaft too far.
    """
    speed, T, beta, It, Ia, kx, ky, c, sigma = np.broadcast_arrays(
        *(np.asarray(v, dtype=float) for v in (
            speed, torque, beta, transverse_inertia, polar_inertia, *stiffness, damping, follower
        ))
    )  # fmt: skip
    w, load, b, polar, follows = (v[..., None] for v in (speed, T, beta, Ia, sigma))
    d0 = np.stack([-np.sin(b), np.zeros_like(b), np.cos(b)], axis=-1)
    # A moment (mx, my) turns the shaft's tip by -i: d x d'' = m gives (x, y)'' ~ (my, -mx).
    turn = np.array([[0.0, 1.0], [-1.0, 0.0]])
    one = np.eye(2)

    def moment(phase: FloatArray, q: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return moments (..., s, 2) square to the nominal axis and their derivatives by q."""
        turned = np.pi * phase
        cos, sin = np.cos(turned), np.sin(turned)
        a = np.stack(np.broadcast_arrays(np.cos(b) * cos, sin, np.sin(b) * cos), axis=-1)
        upright = np.sqrt(1 - (q**2).sum(-1, keepdims=True))
        d = np.concatenate([q, upright], axis=-1)
        # The joint carries the load and what speeds the shaft up; its moment lies along
        # N = P d with P = 1 - a a'.
        carried = load + polar * transmitted(turned, beta=b)[2] * w**2
        N = d - a * (a * d).sum(-1, keepdims=True)
        along = (d * N).sum(-1, keepdims=True)
        size = carried[..., None] / along
        fixed = (1 - follows)[..., None] * d0 / np.cos(b)[..., None]
        M = size * N - load[..., None] * (follows[..., None] * d + fixed)
        P = np.eye(3) - a[..., :, None] * a[..., None, :]
        J = (
            size[..., None] * P
            - 2 * (size / along)[..., None] * N[..., :, None] * N[..., None, :]
            - (load * follows)[..., None, None] * np.eye(3)
        )
        tilt = np.concatenate(
            [np.broadcast_to(one, (*q.shape, 2)), (-q / upright)[..., None, :]], axis=-2
        )
        return M[..., :2], (J @ tilt)[..., :2, :]

    def held(phase: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return M, C and K of all but the joint's moment and the load's."""
        _, ratio, bend, _ = transmitted(np.pi * phase, beta=b)
        k = np.stack([kx, ky], axis=-1)[..., None, :, None] * one
        spun = (polar * ratio * w)[..., None, None] * turn
        sped = (polar * bend * w**2)[..., None, None] * turn
        M = np.broadcast_to(It[..., None, None, None] * one, spun.shape)
        return M, c[..., None, None, None] * one + spun, k + sped

    samples = 33
    phase, period = np.arange(samples) / samples, np.pi / speed
    D = differentiation(samples)
    T1, T2 = period[..., None, None], period[..., None, None] ** 2
    M, C, K = held(phase)
    q, largest = np.zeros((*speed.shape, samples, 2)), np.array(np.inf)
    for _ in range(40):
        push, slope = moment(phase, q)
        left = M @ (D @ (D @ q) / T2)[..., None] + C @ (D @ q / T1)[..., None] + K @ q[..., None]
        left = left[..., 0] - push @ turn.T
        full = operator(M, C, K - turn @ slope, period, samples)
        step = np.linalg.solve(full, left.reshape(*speed.shape, -1, 1)).reshape(q.shape)
        largest = np.abs(step).max((-1, -2), keepdims=True)
        q = q - step * np.minimum(1.0, 0.2 / np.maximum(largest, 1e-300))
        if np.all(largest < 1e-12) or not np.all(np.abs(q) < 0.7):
            break
    if not np.all(np.abs(q) < 0.7) or not np.all(largest < 1e-12):
        msg = "no forced motion of the misaligned shaft found; is its bearing stiff enough?"
        raise NotConverged(msg)
    spectrum = np.fft.rfft(q, axis=-2) / samples
    order = np.arange(samples // 2 + 1)
    weight = np.where(order == 0, 1.0, 2.0)

    def matrices(phase: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        wave = weight * np.exp(2j * np.pi * phase[:, None] * order)
        _, slope = moment(phase, np.real(wave @ spectrum))
        M, C, K = held(phase)
        return M, C, K - turn @ slope

    return Periodic(period=period, matrices=matrices), q
