r"""Torsion of a whole vehicle: rotors, springs and joints that branch, as small matrices.

Every rotation is referred to the propeller shaft's own speed and counted from uniform turning.
The freedoms are q. A joint driven by freedom q_j turns what is behind it by φ(u), u = q_j and
the place of its pin, so all there is to turn is

$$z = (q_1 \dots q_n,\; q_j + \delta(u_j) \dots),\quad
  \delta(u) = \sum_k \tfrac{r^k}{k} \sin 2ku,\quad r = \tan^2 \tfrac{\beta}{2}$$

Rotors and springs are constants in z, whatever they branch to: a spring's twist is y·z, with a
ratio for each rotation it hangs on (an axle's, a differential's). Its torque is k y·z, and
motion follows from F'ᵀ (M z̈ + C ż + K z - f) = 0, F' = ∂z/∂q: exact, and linear but for δ.

A spring may have a loss factor (hysteresis), a damper in parallel, and relax in τ: a tyre is its
longitudinal stiffness in series with the damper that its slip is, σ/V apart.

Derived; the modes are confirmed by a torsion package (`make oracle`), the forced motion by
exact integration.
"""

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from cardan.core.arrays import ArrayLike, ComplexArray, FloatArray, IntArray, single_threaded_blas
from cardan.core.errors import ConvergenceError, DesignError
from cardan.physics.dynamics.torsional_line import output_angle_derivatives

SAMPLES_PER_HALF_TURN = 16
"""Instants in half a turn of a forced motion: orders up to 14 of a turn."""


@dataclass(frozen=True, kw_only=True, eq=False)
class TorsionalNetwork:
    """Rotors on springs, with n freedoms, J joints, R rotors and S springs.

    Cases (gears, states) stand on leading axes of the values.

    Attributes
    ----------
    joints : (J,)
        The freedom that drives each joint.
    inertia : (..., R) kg m²
    rotors : (R, n + J) 1
        What each rotor turns with.
    stiffness, damping, loss, relaxation : (..., S) N m/rad, N m s/rad, 1, s
        Of each spring; an infinite relaxation is none.
    springs : (S, n + J) 1
        What each spring is twisted by: +1 on the side of the engine, so drive is positive.
    """

    joints: IntArray
    inertia: FloatArray
    rotors: FloatArray
    stiffness: FloatArray
    springs: FloatArray
    damping: FloatArray
    loss: FloatArray
    relaxation: FloatArray

    def __post_init__(self) -> None:
        if not (np.all(self.inertia > 0) and np.all(self.stiffness > 0)):
            msg = "every rotor and every spring of a branched line must be above 0"
            raise DesignError(msg)

    @property
    def size(self) -> int:
        """Number of freedoms."""
        return self.rotors.shape[1] - len(self.joints)

    @cached_property
    def straight_transform(self) -> FloatArray:
        """What all rotations are with the joints straight, (n + J, n)."""
        n = self.size
        return np.vstack([np.eye(n), np.eye(n)[self.joints]])

    @cached_property
    def mass_matrix(self) -> FloatArray:
        """M of all rotations, (..., n + J, n + J) kg m²."""
        return _gathered(self.inertia, self.rotors)

    def complex_spring_stiffness(self, frequency: ArrayLike) -> ComplexArray:
        """Complex stiffness of each spring at a frequency (...) rad/s, (..., S) N m/rad.

        At standstill that of springs that relax is their own: what creeps away is no motion
        about the mean.
        """
        W = np.asarray(frequency, dtype=complex)[..., None]
        lag = W * np.where(np.isfinite(self.relaxation), self.relaxation, 0.0)
        held = np.where(np.isfinite(self.relaxation) & (W != 0), 1j * lag / (1 + 1j * lag), 1.0)
        hysteresis = 1j * self.loss * np.sign(np.real(W))
        return self.stiffness * (held + hysteresis) + 1j * W * self.damping

    def dynamic_stiffness(self, frequency: ArrayLike) -> ComplexArray:
        """K(W) - W² M of all rotations at a frequency (...) rad/s, (..., n + J, n + J)."""
        W = np.asarray(frequency, dtype=complex)
        return (
            _gathered(self.complex_spring_stiffness(W), self.springs)
            - W[..., None, None] ** 2 * self.mass_matrix
        )

    def select_case(self, *index: Any) -> "TorsionalNetwork":
        """Return the line in some of its cases only."""
        lead = np.broadcast_shapes(
            *(getattr(self, f).shape[:-1] for f in ("inertia", *_OF_SPRINGS))
        )

        def picked(values: FloatArray) -> FloatArray:
            return np.broadcast_to(values, (*lead, values.shape[-1]))[index]

        return replace(
            self, inertia=picked(self.inertia),
            **{f: picked(getattr(self, f)) for f in _OF_SPRINGS},
        )  # fmt: skip


_OF_SPRINGS = ("stiffness", "damping", "loss", "relaxation")


def _gathered(values: Any, turns: FloatArray) -> Any:
    """Sum of v y yᵀ over parts, (..., m, m)."""
    return np.einsum("...s,si,sj->...ij", values, turns, turns, optimize=True)


# ----- without the joints' unevenness -------------------------------------------------------


@dataclass(frozen=True, kw_only=True, eq=False)
class TorsionalModes:
    """Frequencies (..., n) rad/s, rising, and shapes (..., n, n), freedoms first, of unit mass.

    The first turns as one, at no frequency.
    """

    frequency: FloatArray
    shape: FloatArray


def torsional_modes(line: TorsionalNetwork) -> TorsionalModes:
    """Return the modes of a line with its joints straight and its tyres stuck to the road.

    Stiff springs lose nothing of the soft ones: the lowest come from flexibility, by what is
    left when rotors are scaled to unit mass.
    """
    E = line.straight_transform
    M, K = np.broadcast_arrays(
        E.T @ line.mass_matrix @ E, E.T @ _gathered(line.stiffness, line.springs) @ E
    )
    lower = np.linalg.cholesky(M)
    scaled = np.linalg.solve(lower, np.swapaxes(np.linalg.solve(lower, K), -1, -2))
    vectors = np.linalg.eigh((scaled + np.swapaxes(scaled, -1, -2)) / 2)[1]
    shape = np.linalg.solve(np.swapaxes(lower, -1, -2), vectors)
    # The stiffest spring leaves its rounding in every mode: their own quotient corrects it.
    twist = np.einsum("si,...im->...sm", line.springs @ E, shape)
    frequency = np.sqrt(np.einsum("...s,...sm->...m", line.stiffness, twist**2))
    frequency[..., 0] = 0.0
    return TorsionalModes(frequency=frequency, shape=np.asarray(shape, dtype=float))


def damped_modes(line: TorsionalNetwork, found: TorsionalModes) -> tuple[FloatArray, FloatArray]:
    """Frequencies and damping ratios (..., n) of modes with what their parts lose.

    Inverse iteration on (K(λ) + λ² M) x = 0 from each undamped mode, with the losses brought
    in by four steps so that no mode slips to its neighbour. λ = -ζ w + i w √(1 - ζ²).
    """
    E = line.straight_transform
    M = (E.T @ line.mass_matrix @ E)[..., None, :, :]
    w = np.maximum(found.frequency, 1e-9)
    lam = 1j * w
    x = np.swapaxes(found.shape, -1, -2).astype(complex)
    turns = line.springs @ E
    # Of the stiffness there is, so that a mode found to the last digit can still be divided by.
    stiff = np.einsum("...s,si,si->...", line.stiffness, turns, turns)
    least = 1e-13 * stiff[..., None, None, None]
    for share in (0.25, 0.5, 0.75, *(1.0,) * 6):
        tau = np.where(np.isfinite(line.relaxation), line.relaxation, 0.0)[..., None, :]
        relaxes = np.isfinite(line.relaxation)[..., None, :]
        for _ in range(2):
            lag = lam[..., None] * tau
            held = np.where(relaxes, lag / np.where(relaxes, 1 + lag, 1.0), 1.0)
            held = 1 + share * (held - 1)
            k = line.stiffness[..., None, :] * (held + 1j * share * line.loss[..., None, :])
            k = k + share * lam[..., None] * line.damping[..., None, :]
            K = np.einsum("...s,si,sj->...ij", k, turns, turns, optimize=True)
            pushed = (M @ x[..., None])[..., 0]
            numerator = (x * (K @ x[..., None])[..., 0]).sum(-1)
            lam = np.sqrt(-numerator / (x * pushed).sum(-1))
            lam = np.where(lam.imag < 0, -lam, lam)
            Z = K + lam[..., None, None] ** 2 * M + least * np.eye(line.size)
            x = np.linalg.solve(Z, pushed[..., None])[..., 0]
            x = x / np.linalg.norm(x, axis=-1, keepdims=True)
    size = np.abs(lam)
    ratio = np.where(found.frequency > 1e-6, -lam.real / np.where(size > 0, size, 1.0), 0.0)
    return np.where(found.frequency > 1e-6, size, 0.0), ratio


def static_response(
    line: TorsionalNetwork, found: TorsionalModes, force: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Twist of freedoms (..., n) rad and torque of springs (..., S) N m under steady torques.

    `force` (..., n) N m acts on the freedoms and is in balance: it turns nothing faster.
    """
    w, shape = found.frequency, found.shape
    flexible = np.where(w > 0, 1 / np.where(w > 0, w, 1.0) ** 2, 0.0)
    pushed = np.einsum("...im,...i->...m", shape, force)
    twist = np.einsum("...im,...m->...i", shape, flexible * pushed)
    torque = line.stiffness * np.einsum(
        "si,...i->...s", line.springs @ line.straight_transform, twist
    )
    return twist, torque


# ----- forced by the joints ------------------------------------------------------------------


@dataclass(frozen=True, kw_only=True, eq=False)
class TorsionalOperatingPoint:
    """How a line turns: cases lead.

    Attributes
    ----------
    beta, pin_angle : (..., J) rad
        Angle of each joint, and the angle of its driving pin from the joint's own plane when
        the line is not twisted and its input has turned by 0.
    mean_torque : (..., n) N m
        Mean torques on the freedoms, in balance.
    speed : (...) rad/s
        Of the propeller shaft.
    """

    beta: FloatArray
    pin_angle: FloatArray
    mean_torque: FloatArray
    speed: FloatArray


@dataclass(frozen=True, kw_only=True, eq=False)
class ForcedTorsion:
    """A periodic motion at constant speed: complex amplitudes by order of a turn, 0, 2, 4, ...

    Attributes
    ----------
    torque : (..., orders, S) N m
        Of every spring; order 0 is the mean.
    rotation : (..., orders, n) rad
        Of every freedom.
    """

    torque: ComplexArray
    rotation: ComplexArray

    def order(self, number: int) -> ComplexArray:
        """Return the torque of every spring at an even order, (..., S) N m."""
        return self.torque[..., number // 2, :]


@single_threaded_blas()
def forced_torsional_response(
    line: TorsionalNetwork,
    turning: TorsionalOperatingPoint,
    *,
    found: TorsionalModes | None = None,
    tolerance: float = 1e-9,
    rounds: int = 30,
    strict: bool = True,
    samples: int = SAMPLES_PER_HALF_TURN,
) -> ForcedTorsion:
    """Return the motion that the joints force, without approximation in their angles.

    The torques of one motion, taken at instants of half a turn, move the line with its joints
    straight at each order by itself; the motion that comes of it gives them anew. The first
    round is first order: the lead of each joint as a displacement in series, and the
    mean torque times its slope as a torque on what is ahead.

    Raises
    ------
    ConvergenceError
        If no motion settles: within a parametric zone that damping leaves open. Where that is
        not `strict` such cases are nan.
    """
    known = torsional_modes(line) if found is None else found
    n, E, N = line.size, line.straight_transform, samples
    speed = np.asarray(turning.speed, dtype=float)
    count = N // 2
    orders = 2 * np.arange(count)
    sided = np.where(orders == 0, 1.0, 2.0)[:, None] / N
    Z = np.stack([line.dynamic_stiffness(m * speed) for m in orders], axis=-3)
    straight = E.T @ Z @ E
    inverse = np.linalg.inv(straight[..., 1:, :, :])
    twist, _ = static_response(line, known, turning.mean_torque)
    half = np.pi * np.arange(N) / N
    cases = np.broadcast_shapes(twist.shape[:-1], Z.shape[:-3])
    moved = np.zeros((*cases, count, n), dtype=complex)
    moved[..., 0, :] = twist
    first_joint = line.joints[:1]
    settled = np.zeros(cases, dtype=bool)
    first = np.full(cases, np.nan)
    spectrum = np.zeros((*cases, count, line.springs.shape[1]), dtype=complex)
    for _ in range(rounds):
        x = _in_time(moved, N)
        held = x - np.real(
            moved[..., :1, first_joint]
        )  # the input's own pin is where it is said to be
        u = held[..., line.joints] + turning.pin_angle[..., None, :] + half[:, None]
        phi, slope, _, _ = output_angle_derivatives(u, beta=turning.beta[..., None, :])
        z = np.concatenate([x, x[..., line.joints] + phi - u], axis=-1)
        spectrum = sided * np.fft.rfft(z, axis=-2)[..., :count, :]
        pulled = np.einsum("...kij,...kj->...ki", Z, spectrum)
        torque = _in_time(pulled, N)
        left = torque[..., :n].copy()
        for k, j in enumerate(line.joints.tolist()):
            left[..., j] += slope[..., k] * torque[..., n + k]
        rest = sided * np.fft.rfft(left, axis=-2)[..., :count, :]
        steady = turning.mean_torque - np.real(rest[..., 0, :])
        step = np.zeros_like(moved)
        step[..., 0, :] = static_response(line, known, steady)[0]
        step[..., 1:, :] = -np.einsum("...kij,...kj->...ki", inverse, rest[..., 1:, :])
        moved += step
        largest = np.abs(step).max((-1, -2))
        first = np.where(np.isnan(first), np.maximum(largest, 1e-12), first)
        settled = largest <= tolerance * first
        # What runs away is out of the count, and must not spoil the others' arithmetic.
        moved[~(largest < 1e6 * first)] = np.nan
        if np.all(settled | np.isnan(largest)):
            break
    if not settled.all() and strict:
        msg = f"no steady motion in {rounds} rounds: near a zone that shakes itself up"
        raise ConvergenceError(msg)
    moved[~settled] = np.nan
    rates = np.stack([line.complex_spring_stiffness(m * speed) for m in orders], axis=-2)
    torques = rates * np.einsum("si,...ki->...ks", line.springs, spectrum)
    torques[~settled] = np.nan
    return ForcedTorsion(torque=torques, rotation=moved)


def _in_time(spectrum: ComplexArray, samples: int) -> FloatArray:
    """Return what amplitudes by even order come to at equal instants of half a turn."""
    k = np.arange(spectrum.shape[-2])
    wave = np.exp(2j * np.pi * np.outer(np.arange(samples), k) / samples)
    return np.real(wave @ spectrum)


def first_order_torques(
    line: TorsionalNetwork,
    turning: TorsionalOperatingPoint,
    *,
    pins: FloatArray,
    torque: FloatArray,
    order: ArrayLike = 2,
) -> ComplexArray:
    """One order of every spring's torque, by the leads of the joints alone, (..., S) N m.

    Order 2 to first order in tan²(β/2), 4 without what order 2 makes of itself. `pins`
    (..., J) rad are the places of the pins with the line twisted, `torque` (..., J) N m what
    each joint carries. Costs one solution, where `forced_torsional_response` takes some rounds.
    """
    n, E = line.size, line.straight_transform
    m = np.asarray(order, dtype=float)
    W = m * turning.speed
    Z = line.dynamic_stiffness(W)
    k = (m / 2)[..., None]
    lead = np.tan(turning.beta / 2) ** (2 * k) / k * np.exp(2j * k * pins) / 1j
    pushed = np.einsum("...ij,...j->...i", Z[..., n:], lead)  # by each joint's displacement
    force = pushed[..., :n].copy()
    slope = 1j * m[..., None] * lead
    for c, j in enumerate(line.joints.tolist()):
        force[..., j] += pushed[..., n + c] + slope[..., c] * torque[..., c]
    x = np.linalg.solve(E.T @ Z @ E, -force[..., None])[..., 0]
    z = np.einsum("ij,...j->...i", E, x)
    z[..., n:] += lead
    return line.complex_spring_stiffness(W) * np.einsum("si,...i->...s", line.springs, z)


def spring_torque_response(
    line: TorsionalNetwork, frequency: ArrayLike, force: FloatArray
) -> ComplexArray:
    """Torque of every spring under torques (..., n) N m on the freedoms at a frequency."""
    E = line.straight_transform
    Z = E.T @ line.dynamic_stiffness(frequency) @ E
    x = np.linalg.solve(Z, force[..., None].astype(complex))[..., 0]
    return line.complex_spring_stiffness(frequency) * np.einsum(
        "si,...i->...s", line.springs @ E, x
    )


# ----- parametric zones ----------------------------------------------------------------------


def modal_coupling_by_joint_order_2(
    line: TorsionalNetwork,
    found: TorsionalModes,
    turning: TorsionalOperatingPoint,
    *,
    pins: FloatArray,
    torque: FloatArray,
) -> ComplexArray:
    """Return what order 2 of the joints does from one mode to another, (..., n, n) rad²/s².

    H_ij of mode i by mode j, where twice the speed is near w_i + w_j: mode-normalised, to
    first order in tan²(β/2), about the motion that the line has (its mean torque included).
    """
    E, n = line.straight_transform, line.size
    w, shape = found.frequency, found.shape
    speed = np.asarray(turning.speed, dtype=float)[..., None, None]
    r = (np.tan(turning.beta / 2) ** 2 * np.exp(2j * pins))[..., :, None]  # δ' of each joint
    driving = shape[..., line.joints, :]  # (..., J, n): what drives each joint, in each mode
    all_of = np.einsum("ij,...jm->...im", E, shape)
    K = _gathered(line.stiffness, line.springs)
    by_k = np.einsum("...ji,...jm->...im", K[..., :, n:], all_of)  # torque behind each joint
    by_m = np.einsum("...ji,...jm->...im", line.mass_matrix[..., :, n:], all_of)
    w_j = w[..., None, :]
    behind = by_k - w_j**2 * by_m  # of mode j, at its own frequency
    ahead = np.einsum("...ki,...kj->...ij", driving, r * behind)
    # The displacement δ' y pushes with K - (2Ω - w_j)² M: its frequency is 2Ω - w_j.
    pushed = (2 * speed - w_j) ** 2
    series_k = np.einsum("...ki,...kj->...ij", by_k, r * driving)
    series_m = np.einsum("...ki,...kj->...ij", by_m, r * driving)
    # Mean torque times δ''.
    return (
        ahead
        + series_k
        - pushed * series_m
        + np.einsum("...ki,...kj->...ij", driving, 2j * r * torque[..., :, None] * driving)
    )


def zone_growth_rate(
    H: ComplexArray,
    *,
    modes: tuple[ArrayLike, ArrayLike],
    frequency: tuple[ArrayLike, ArrayLike],
    decay: tuple[ArrayLike, ArrayLike],
    speed: ArrayLike,
) -> tuple[FloatArray, FloatArray]:
    """Growth of a zone by its own multiplier, 1/s, and how wide damping leaves it.

    λ = -(d_i + d_j)/2 + Re √( ((d_i - d_j)/2 + i s/2)² + H_ij H_ji*/(4 w_i w_j) ),
    s = 2 Ω - w_i - w_j: averaging to first order in tan²(β/2).

    Parameters
    ----------
    H : (..., n, n) rad²/s²
        `modal_coupling_by_joint_order_2`.
    modes, frequency, decay : pairs of (...)
        Places of both modes, their w rad/s and d = ζ w 1/s.
    speed : (...) rad/s

    Returns
    -------
    (...) 1/s
        Above 0 the zone's own motion grows at this speed.
    (...) 1
        |H| / √(4 w_i w_j d_i d_j): above 1 the zone is open at its middle. Damping that many
        times as large closes it, and so do joint angles smaller by its root.

    Notes
    -----
    Source: averaging, as Asokanthan & Hwang (1996) have it for two freedoms.
    """
    i, j = (np.asarray(k) for k in modes)
    wi, wj = (np.asarray(w, dtype=float) for w in frequency)
    di, dj = (np.asarray(d, dtype=float) for d in decay)
    Hij = _entry(H, i, j)
    Hji = _entry(H, j, i)
    both = Hij * np.conj(Hji) / (4 * wi * wj)
    s = 2 * np.asarray(speed, dtype=float) - wi - wj
    root = np.sqrt(((di - dj) / 2 + 0.5j * s) ** 2 + both)
    growth = -(di + dj) / 2 + np.abs(np.real(root))
    product = np.maximum(di * dj, 1e-300)
    return growth, np.sqrt(np.maximum(np.real(both), 0.0) / product)


def _entry(H: ComplexArray, i: Any, j: Any) -> ComplexArray:
    flat = H.reshape(*H.shape[:-2], -1)
    place = np.broadcast_to(i * H.shape[-1] + j, flat.shape[:-1])[..., None]
    return np.take_along_axis(flat, place, axis=-1)[..., 0]
