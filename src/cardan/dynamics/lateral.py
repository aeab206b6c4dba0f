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
from cardan.base.errors import DesignError
from cardan.dynamics.periodic import Periodic, eigenvalues, response
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
) -> tuple[Periodic, "FloatArray"]:
    """Return the rigid shaft at a nominal joint angle: its small motions, and what shakes it.

    Small motions are about the shaft held at the angle, with the joint's full moment and
    its derivative there, and the shaft's uneven rotation: it speeds and slows the shaft's
    own inertia and its gyroscopic moment.

    Parameters
    ----------
    speed, torque : (...) rad/s, N m
        Ω of the driving shaft and T of the load, both constant.
    beta : (...) rad
        Nominal joint angle; x of the motion lies in the plane of the two shafts.
    transverse_inertia, polar_inertia, damping, follower
        As for `rigid_shaft`.
    stiffness : two of (...) N m/rad
        Of the bearing about the joint, for motion in the plane of the shafts and square to it.

    Returns
    -------
    system : Periodic
        For (x, y), inclinations in rad.
    force : (..., 33, 2) N m
        The joint's bending moment at equal instants of half a turn, for `response`.
    """
    speed, T, beta, It, Ia, kx, ky, c, sigma = np.broadcast_arrays(
        *(np.asarray(v, dtype=float) for v in (
            speed, torque, beta, transverse_inertia, polar_inertia, *stiffness, damping, follower
        ))
    )  # fmt: skip
    each = [v[..., None] for v in (speed, T, beta, Ia, sigma)]

    def moment(phase: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return force, its derivative and the shaft's own speed, at phases of half a turn."""
        w, torque, b, polar, load = each
        turned = np.pi * phase
        cos_b, sin_b = np.cos(b), np.sin(b)
        # Frame of the driven shaft: x and y square to it, z along it. Driving shaft d0 and
        # driving pin a (in the plane of the shafts at phase 0), seen from there.
        d0 = np.stack(np.broadcast_arrays(-sin_b, 0.0, cos_b), axis=-1)
        a = np.stack(
            np.broadcast_arrays(cos_b * np.cos(turned), np.sin(turned), sin_b * np.cos(turned)), -1
        )
        d = np.array([0.0, 0.0, 1.0])
        N = d - a * a[..., 2:]
        _, ratio, bend, _ = transmitted(turned, beta=b)
        # The joint carries the load and what speeds the shaft up; its moment lies along N.
        carried = torque + polar * bend * w**2
        size = (carried / N[..., 2])[..., None]
        along = load[..., None] * d + (1 - load[..., None]) * d0 / d0[..., 2:]
        M = size * N - torque[..., None] * along
        # N = P d with P = 1 - a a', and size = carried / (d' P d).
        P = np.eye(3) - a[..., :, None] * a[..., None, :]
        J = (
            size[..., None] * P
            - 2 * (size / N[..., 2:])[..., None] * N[..., :, None] * N[..., None, :]
            - (torque * load)[..., None, None] * np.eye(3)
        )
        # Moment square to the shaft; tilting the shaft tilts what counts as square.
        across = J[..., :2, :2] - M[..., 2, None, None] * np.eye(2)
        return M[..., :2], across, ratio * w

    # A moment (mx, my) turns the shaft's tip by -i: d x d'' = m gives (x, y)'' ~ (my, -mx).
    turn = np.array([[0.0, 1.0], [-1.0, 0.0]])
    one = np.eye(2)
    k = np.stack([kx, ky], axis=-1)[..., None, :, None] * one

    def matrices(phase: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        _, across, own = moment(phase)
        M = It[..., None, None, None] * one
        C = c[..., None, None, None] * one + (each[3] * own)[..., None, None] * turn
        return M, C, k - turn @ across

    instants = np.arange(33) / 33
    force = np.einsum("ij,...j->...i", turn, moment(instants)[0])
    return Periodic(period=np.pi / speed, matrices=matrices), force


def misaligned_motion(**shaft: ArrayLike) -> FloatArray:
    """Return the inclinations (..., 33, 2) rad a misaligned shaft is shaken to.

    Takes what `misaligned_shaft` takes.
    """
    return response(*misaligned_shaft(**shaft))  # type: ignore[arg-type]
