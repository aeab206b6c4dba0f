r"""Torsional vibration of a line of joints: resonance, parametric zones, nonlinear motion.

Coordinates are the rotations q_i of the driving yokes. Joint i turns q_i into φ_i(q_i)
exactly, the spring ahead of it carries T_i, and each yoke carries inertia:

$$(A_i + B_i\varphi_i'^2)\,\ddot q_i + B_i\varphi_i'\varphi_i''\,\dot q_i^2
  + \varphi_i' T_{i+1} - T_i = 0,\quad
  T_i = k_i\,(u_i - q_i) + c_i\,(\dot u_i - \dot q_i),\quad
  u_{i+1} = \varphi_i(q_i) + t_i$$

u_1 turns uniformly (through a joint of its own if there is one); T_{n+1} is the load. A
joint of zero angle is a plain inertia. One degree of freedom with the inertia behind its
joint is Porter's (1961) and Chang's (2000) Hill equation; two are Asokanthan & Hwang's
(1996) and Bulut & Parlar's (2011). Compared here: their equations and the zones these
have, found two ways and confirmed by a multibody engine; the papers' figures were not at
hand and are not compared.
"""

from collections.abc import Callable
from dataclasses import dataclass
from itertools import combinations, pairwise
from typing import Any, Literal, TypeAlias

import numpy as np

from cardan.core.arrays import ArrayLike, ComplexArray, FloatArray, single_threaded_blas
from cardan.core.errors import ConvergenceError, DesignError
from cardan.model.parts import Line
from cardan.physics.dynamics.floquet import (
    PeriodicSystem,
    collocation_operator,
    differentiation_matrix,
    floquet_multipliers,
    growth_rate,
)
from cardan.physics.dynamics.stability_chart import find_zeros
from cardan.physics.kinematics.joint_chain import (
    cross_product,
    dot_product,
    joint_angles,
    rotate_chain,
)

SAMPLES_PER_HALF_TURN = 33
"""Instants in half a turn of a forced motion: orders up to 32 of a turn."""


def output_angle_derivatives(
    theta: ArrayLike, *, beta: ArrayLike
) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    """Return φ and its first three derivatives by θ, pin in plane at θ = 0; (...) rad each."""
    theta = np.asarray(theta, dtype=float)
    r = np.tan(np.asarray(beta, dtype=float) / 2) ** 2
    sin, cos = np.sin(2 * theta), np.cos(2 * theta)
    phi = theta + np.arctan2(r * sin, 1 - r * cos)
    below = 1 - 2 * r * cos + r**2
    first = (1 - r**2) / below
    second = -first * 4 * r * sin / below
    third = first * (2 * (4 * r * sin) ** 2 / below**2 - 8 * r * cos / below)
    return phi, first, second, third


@dataclass(frozen=True, slots=True, kw_only=True)
class TorsionalLine:
    """Springs, inertias and joints in a row; cases on leading axes, joints last.

    Attributes
    ----------
    beta : (..., n) rad
        Joint angles; 0 for a plain inertia.
    stiffness, damping : (..., n) N m/rad, N m s/rad
        Of the spring ahead of each joint.
    driving, driven : (..., n) kg m²
        Inertia that turns with the driving and with the driven yoke of each joint.
    twist : (..., n) rad
        From the driven angle of each joint to the driving angle of the next one's pin.
    front : (...) rad
        Angle of a joint ahead of the first spring; its driving yoke turns uniformly.
    front_twist : (...) rad
        As `twist`, of that joint.
    torque : (...) N m
        Load at the end, positive as in drive.
    """

    beta: FloatArray
    stiffness: FloatArray
    driving: FloatArray
    driven: FloatArray
    damping: FloatArray | float = 0.0
    twist: FloatArray | float = 0.0
    front: FloatArray | float = 0.0
    front_twist: FloatArray | float = 0.0
    torque: FloatArray | float = 0.0

    def __post_init__(self) -> None:
        if not np.all(np.asarray(self.driving) + np.asarray(self.driven) > 0):
            msg = "every joint of a torsional line needs an inertia above 0 on one side"
            raise DesignError(msg)
        if not (np.all(np.abs(self.beta) < np.pi / 2) and np.all(np.abs(self.front) < np.pi / 2)):
            msg = "every joint angle of a torsional line must stay below 90 deg"
            raise DesignError(msg)

    @property
    def size(self) -> int:
        """Number of coordinates."""
        return np.shape(self.beta)[-1]

    @property
    def mean_matrices(self) -> tuple[FloatArray, FloatArray, FloatArray]:
        """M, C and K (..., n, n) with all joints straight."""
        return _matrices(
            self,
            gain=np.ones(np.shape(self.beta)),
            mass=np.asarray(self.driving) + np.asarray(self.driven),
        )


def torsional_line_model(
    line: Line,
    directions: ArrayLike,
    *,
    axle_inertia: ArrayLike,
    axle_stiffness: ArrayLike | None = None,
    gearbox_inertia: ArrayLike | None = None,
    gearbox_stiffness: ArrayLike | None = None,
    damping_ratio: float = 0.02,
    torque: ArrayLike = 0.0,
) -> TorsionalLine:
    """Return the torsional model of a line of shafts with tubes.

    Parameters
    ----------
    line
        Every shaft needs a tube: G J / L is its stiffness; half its inertia turns with
        each of its joints.
    directions : (..., n+1, 3) 1
        Unit vectors of the members.
    axle_inertia : (...) kg m²
        What turns behind the last joint, reflected to the pinion.
    axle_stiffness : (...) N m/rad
        Between pinion and axle inertia (pinion shaft, half shafts, reflected); rigid if None.
    gearbox_inertia, gearbox_stiffness : (...) kg m², N m/rad
        Of what turns with the gearbox flange, and the spring from there to the uniformly
        turning engine. Without them the flange itself turns uniformly.
    damping_ratio
        Of the first mode; the springs' damping is in proportion to their stiffness.
    torque : (...) N m
        Load at the pinion.

    Raises
    ------
    DesignError
        If a shaft has no tube, or only one of the two gearbox values is given.
    """
    beta, twist = _placed(np.asarray(directions, dtype=float), line.phases, line.is_cross)
    springs, halves = [], []
    for k, shaft in enumerate(line.shafts, 1):
        if shaft.tube is None or shaft.polar_inertia is None:
            msg = f"shaft {k} of line {line.name} needs a tube for its torsional stiffness"
            raise DesignError(msg, about=f"drivelines.{line.name}.shafts[{k}]")
        tube = shaft.tube
        springs.append(tube.material.shear_modulus * 2 * tube.second_moment / shaft.length)
        halves.append(shaft.polar_inertia / 2)
    if (gearbox_inertia is None) != (gearbox_stiffness is None):
        msg = "give both the gearbox inertia and its stiffness, or neither"
        raise DesignError(msg, about="torsion")

    def column(value: ArrayLike) -> FloatArray:
        return np.broadcast_to(np.asarray(value, dtype=float), beta.shape[:-1])[..., None]

    def row(*values: ArrayLike) -> FloatArray:
        return np.concatenate([column(v) for v in values], axis=-1)

    rigid = axle_stiffness is None
    driving = [0.0 if gearbox_inertia is None else gearbox_inertia, *halves]
    driven = [*halves, axle_inertia if rigid else 0.0]
    if not rigid:
        beta, twist = (np.concatenate([a, column(0.0)], axis=-1) for a in (beta, twist))
        springs, driving = [*springs, axle_stiffness], [*driving, axle_inertia]
        driven = [*driven, 0.0]
    fields = {"driving": row(*driving), "driven": row(*driven), "beta": beta, "twist": twist}
    front, front_twist = 0.0, 0.0
    if gearbox_stiffness is None:
        front, front_twist = beta[..., 0], twist[..., 0]
        fields = {name: value[..., 1:] for name, value in fields.items()}
    else:
        springs = [gearbox_stiffness, *springs]
    made = TorsionalLine(
        stiffness=row(*springs), front=front, front_twist=front_twist,
        torque=np.asarray(torque, dtype=float), **fields,
    )  # fmt: skip
    first = natural_frequencies(made)[..., :1]
    return TorsionalLine(
        stiffness=made.stiffness, front=front, front_twist=front_twist, torque=made.torque,
        damping=2 * damping_ratio / first * made.stiffness, **fields,
    )  # fmt: skip


def _placed(
    directions: FloatArray, phases: ArrayLike, crosses: tuple[float, ...]
) -> tuple[FloatArray, FloatArray]:
    """Angles (..., n) rad of a chain's joints, and the twist from each one's pin to the next's.

    A pin is counted from its joint's own plane. The last twist, to no joint, is 0. A joint of
    constant velocity turns like one without an angle.
    """
    theta = _pin_angles(directions, phases, crosses)
    beta = joint_angles(directions) * np.array(crosses)
    driven = output_angle_derivatives(theta, beta=beta)[0]
    twist = np.concatenate([theta[..., 1:] - driven[..., :-1], 0 * theta[..., :1]], axis=-1)
    return beta, twist


def _pin_angles(
    directions: FloatArray, phases: ArrayLike, crosses: tuple[float, ...]
) -> FloatArray:
    """Angle (..., n) rad of each driving pin from its joint's plane at the start of a turn."""
    before, after = directions[..., :-1, :], directions[..., 1:, :]
    turned = rotate_chain(directions, phases=phases, crosses=crosses, samples=4)
    driving = turned.driving_pins[..., 0, :]
    normal = cross_product(before, after)
    return np.arctan2(
        dot_product(driving, normal), dot_product(driving, cross_product(normal, before))
    )


def joint_angles_and_pin_angles(
    directions: ArrayLike, phases: ArrayLike, crosses: tuple[float, ...]
) -> tuple[FloatArray, FloatArray]:
    """Angles of a chain's joints and places of their driving pins, (..., n) rad each.

    The angle of a joint of constant velocity, 0 in `crosses`, is 0: it turns like a straight one.

    A place is the pin's angle from its joint's own plane where every shaft has turned with the
    first one from 0, without the leads of the joints ahead.
    """
    directions = np.asarray(directions, dtype=float)
    beta, twist = _placed(directions, phases, crosses)
    first = _pin_angles(directions, phases, crosses)[..., :1]
    ahead = np.concatenate([np.zeros_like(first), twist[..., :-1]], axis=-1)
    return beta, first + np.cumsum(ahead, axis=-1)


# ----- without the joints' unevenness -----------------------------------------------------


def natural_frequencies(line: TorsionalLine) -> FloatArray:
    """Natural frequencies (..., n) rad/s, rising, with all joints straight."""
    M, _, K = line.mean_matrices
    root = 1 / np.sqrt(np.diagonal(M, axis1=-2, axis2=-1))
    squares, _ = np.linalg.eigh(root[..., :, None] * K * root[..., None, :])
    return np.sqrt(np.maximum(squares, 0.0))


def _matrices(
    line: TorsionalLine,
    *,
    gain: FloatArray,
    mass: FloatArray,
    slope: ArrayLike = 0.0,
    rate: ArrayLike = 0.0,
    own_damping: ArrayLike = 0.0,
    own_stiffness: ArrayLike = 0.0,
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Assemble M, C and K (..., n, n) of small motions about a motion.

    `gain` and `slope` are φ' and φ'' of each joint, `rate` its speed; the `own` terms go
    on the diagonals.
    """
    gain, slope, rate, mass = np.broadcast_arrays(gain, slope, rate, mass)
    k, c = np.broadcast_arrays(line.stiffness, line.damping)
    k, c = np.broadcast_to(k, gain.shape), np.broadcast_to(c, gain.shape)
    n = gain.shape[-1]
    ahead, behind = np.arange(n - 1), np.arange(1, n)
    i = np.arange(n)
    M, C, K = (np.zeros((*gain.shape, n)) for _ in range(3))
    M[..., i, i] = mass
    C[..., i, i] = c + own_damping
    K[..., i, i] = k + own_stiffness
    g, s, w = gain[..., :-1], slope[..., :-1], rate[..., :-1]
    k, c = k[..., 1:], c[..., 1:]
    pull = k * g + c * s * w  # torque of the next spring per rotation of this yoke
    C[..., ahead, ahead] += c * g**2
    K[..., ahead, ahead] += g * pull
    C[..., ahead, behind] = C[..., behind, ahead] = -c * g
    K[..., ahead, behind] = -k * g
    K[..., behind, ahead] = -pull
    return M, C, K


def _at_instants(line: TorsionalLine) -> TorsionalLine:
    """Return the line with an axis for instants between its cases and its joints."""

    def joints(value: FloatArray | float) -> Any:
        return value if np.ndim(value) == 0 else np.asarray(value)[..., None, :]

    def alone(value: FloatArray | float) -> Any:
        return value if np.ndim(value) == 0 else np.asarray(value)[..., None]

    return TorsionalLine(
        beta=joints(line.beta), stiffness=joints(line.stiffness), damping=joints(line.damping),
        driving=joints(line.driving), driven=joints(line.driven), twist=joints(line.twist),
        front=alone(line.front), front_twist=alone(line.front_twist), torque=alone(line.torque),
    )  # fmt: skip


def _input(
    line: TorsionalLine, turned: FloatArray, speed: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Angle, speed and acceleration ahead of the first spring."""
    phi, first, second, _ = output_angle_derivatives(turned, beta=line.front)
    return phi + line.front_twist, first * speed, second * speed**2


def _rigid(
    line: TorsionalLine, turned: FloatArray, speed: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Rotation, speed and acceleration of every driving yoke, springs rigid."""
    q, v, a = _input(line, turned, speed)
    out = [(q, v, a)]
    beta = np.broadcast_to(line.beta, np.broadcast_shapes(np.shape(line.beta), (1,)))
    twist = np.broadcast_to(line.twist, beta.shape)
    for k in range(line.size - 1):
        phi, first, second, _ = output_angle_derivatives(q, beta=beta[..., k])
        q, v, a = phi + twist[..., k], first * v, first * a + second * v**2
        out.append((q, v, a))
    return tuple(np.stack(np.broadcast_arrays(*part), axis=-1) for part in zip(*out, strict=True))  # type: ignore[return-value]


def _half_turn(speed: ArrayLike) -> FloatArray:
    """Period of everything at constant input speed."""
    speed = np.asarray(speed, dtype=float)
    if not np.all(speed > 0):
        msg = f"speed must be above 0, got {speed.min():g} rad/s"
        raise ValueError(msg)
    return np.pi / speed


def linearised_about_rigid_rotation(line: TorsionalLine, speed: ArrayLike) -> PeriodicSystem:
    """Return small motions about uniform rotation of every yoke, as the papers linearise.

    The line turns like one rigid body; the springs then carry the torque that the joints'
    unevenness implies, and the torques that would enforce the motion count as forcing.
    First-order zones are right. Those of second order need not exist, and in a line with
    a stiff shaft the implied torque is fiction: see `linearised_about_periodic_motion`.

    Parameters
    ----------
    line
        The line, cases on leading axes.
    speed : (...) rad/s
        Input speed, above 0; broadcasts against the cases.
    """
    period = _half_turn(speed)
    each = _at_instants(line)
    w = np.asarray(speed, dtype=float)[..., None]
    twist = np.broadcast_to(each.twist, np.shape(each.beta))
    placed = np.cumsum(np.concatenate([0 * twist[..., :1], twist[..., :-1]], axis=-1), axis=-1)

    def parts(phase: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        turned = np.pi * phase
        q = turned[:, None] + placed + np.asarray(each.front_twist)[..., None]
        v = np.broadcast_to(w[..., None], np.broadcast_shapes(q.shape, (*w.shape, 1)))
        T, (first, second, third) = _torques(each, q, v, _input(each, turned, w)[:2])
        T[..., :-1] += np.asarray(each.torque)[..., None]
        return _matrices(
            each, gain=first, slope=second, rate=v,
            mass=each.driving + each.driven * first**2,
            own_damping=2 * each.driven * first * second * v,
            own_stiffness=each.driven * first * third * v**2 + second * T[..., 1:],
        )  # fmt: skip

    return PeriodicSystem(period=period, matrices=parts)


@dataclass(frozen=True, slots=True, kw_only=True)
class PeriodicMotion:
    """The periodic motion a line has at constant input speed, without approximation.

    Attributes
    ----------
    speed : (...) rad/s
    rotation, rate, acceleration : (..., samples, n) rad, rad/s, rad/s²
        Of the driving yokes, at equal instants of half a turn.
    torque : (..., samples, n+1) N m
        In every spring, and the load behind the last joint.
    """

    line: TorsionalLine
    speed: FloatArray
    rotation: FloatArray
    rate: FloatArray
    acceleration: FloatArray
    torque: FloatArray

    def order(self, number: int) -> ComplexArray:
        """Complex torque amplitude (..., n+1) N m of an even order of a turn."""
        if number % 2 or number < 2:
            msg = f"joints at constant speed have orders 2, 4, ... of a turn, not {number}"
            raise ValueError(msg)
        spectrum = np.fft.rfft(self.torque, axis=-2) * 2 / self.torque.shape[-2]
        return spectrum[..., number // 2, :]


def _torques(
    line: TorsionalLine,
    q: FloatArray,
    v: FloatArray,
    ahead: tuple[FloatArray, FloatArray],
) -> tuple[FloatArray, tuple[FloatArray, FloatArray, FloatArray]]:
    """Torque in every spring and the load, (..., n+1), with φ', φ'' and φ''' of the joints."""
    u, du = (np.asarray(part)[..., None] for part in ahead)
    q, v = np.broadcast_arrays(q, v, u, du)[:2]
    phi, first, second, third = output_angle_derivatives(q, beta=line.beta)
    u = np.concatenate([np.broadcast_to(u, q[..., :1].shape), (phi + line.twist)[..., :-1]], -1)
    du = np.concatenate([np.broadcast_to(du, q[..., :1].shape), (first * v)[..., :-1]], -1)
    springs = line.stiffness * (u - q) + np.asarray(line.damping) * (du - v)
    load = np.broadcast_to(line.torque, q.shape[:-1])[..., None]
    return np.concatenate([springs, load], axis=-1), (first, second, third)


def _tangent(
    line: TorsionalLine,
    q: FloatArray,
    v: FloatArray,
    a: FloatArray,
    ahead: tuple[FloatArray, FloatArray],
) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    """Return what is left over of the equations (..., n), and their M, C and K at a motion."""
    T, (first, second, third) = _torques(line, q, v, ahead)
    B = np.asarray(line.driven)
    mass = line.driving + B * first**2
    left = mass * a + B * first * second * v**2 + first * T[..., 1:] - T[..., :-1]
    M, C, K = _matrices(
        line, gain=first, slope=second, rate=v, mass=mass,
        own_damping=2 * B * first * second * v,
        own_stiffness=2 * B * first * second * a
        + B * (second**2 + first * third) * v**2
        + second * T[..., 1:],
    )  # fmt: skip
    return left, M, C, K


@single_threaded_blas()
def periodic_motion(
    line: TorsionalLine, speed: ArrayLike, *, samples: int = SAMPLES_PER_HALF_TURN
) -> PeriodicMotion:
    """Find the periodic motion at constant input speed: harmonic balance and Newton's method.

    Parameters
    ----------
    line
        The line, cases on leading axes.
    speed : (...) rad/s
        Input speed, above 0; broadcasts against the cases.
    samples
        Instants in half a turn, odd. The motion is exact up to order samples - 1 of a turn.

    Raises
    ------
    ConvergenceError
        If Newton's method settles in no case in 60 steps: an undamped line in resonance, or
        one whose motion is far from the rigid one. Where others settle, the motion of one
        that does not is nan.
    """
    period = _half_turn(speed)
    each = _at_instants(line)
    w = np.asarray(speed, dtype=float)[..., None]
    turned = np.pi * np.arange(samples) / samples
    q0, _, _ = _rigid(each, turned, w)
    ahead = _input(each, turned, w)[:2]
    cases = np.broadcast_shapes(q0.shape[:-2], period.shape)
    steady = np.broadcast_to(turned[:, None], q0.shape)
    x = np.broadcast_to(q0 - steady, (*cases, *q0.shape[-2:])).copy()
    D = differentiation_matrix(samples)
    T = period[..., None, None]
    n, largest = x.shape[-1], np.array(np.inf)
    for _ in range(60):
        q = steady + x
        v = w[..., None] + D @ x / T
        a = D @ (D @ x) / T**2
        left, M, C, K = _tangent(each, q, v, a, ahead)
        full = collocation_operator(M, C, K, period, samples)
        step = np.linalg.solve(full, left.reshape(*left.shape[:-2], samples * n, 1))
        step = step.reshape(x.shape)
        largest = np.abs(step).max((-1, -2), keepdims=True)
        x -= step * np.minimum(1.0, 0.5 / np.maximum(largest, 1e-300))
        if np.all(largest < 1e-11):
            break
    x = np.where(largest < 1e-11, x, np.nan)
    if np.isnan(x).all():
        msg = "no periodic motion found in 60 steps; add damping or move away from resonance"
        raise ConvergenceError(msg)
    q, v, a = steady + x, w[..., None] + D @ x / T, D @ (D @ x) / T**2
    return PeriodicMotion(
        line=line, speed=np.asarray(speed, dtype=float), rotation=q, rate=v, acceleration=a,
        torque=_torques(each, q, v, ahead)[0],
    )  # fmt: skip


def linearised_about_periodic_motion(
    line: TorsionalLine, speed: ArrayLike, *, samples: int = SAMPLES_PER_HALF_TURN
) -> PeriodicSystem:
    """Return small motions about the line's own `periodic_motion`: exact.

    Parameters are those of `periodic_motion`.
    """
    found = periodic_motion(line, speed, samples=samples)
    each = _at_instants(line)
    w = np.asarray(speed, dtype=float)[..., None]
    turned = np.pi * np.arange(samples) / samples
    spectra = [
        np.fft.rfft(part, axis=-2) / samples
        for part in (found.rotation - turned[:, None], found.rate, found.acceleration)
    ]
    k = np.arange(samples // 2 + 1)
    weight = np.where(k == 0, 1.0, 2.0)

    def parts(phase: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        wave = weight * np.exp(2j * np.pi * phase[:, None] * k)
        x, v, a = (np.real(wave @ spectrum) for spectrum in spectra)
        now = np.pi * phase
        _, M, C, K = _tangent(each, x + now[:, None], v, a, _input(each, now, w)[:2])
        return M, C, K

    return PeriodicSystem(period=_half_turn(speed), matrices=parts)


# ----- parametric zones -------------------------------------------------------------------


ZoneKind: TypeAlias = Literal["principal", "sum", "difference"]

Linearisation: TypeAlias = Callable[[TorsionalLine, FloatArray], PeriodicSystem]
"""What a line is linearised about: `linearised_about_rigid_rotation` and its like."""


@dataclass(frozen=True, slots=True, kw_only=True)
class InstabilityZone:
    """A range of speeds in which a line shakes itself up, without forcing.

    `modes` count from 1: a principal zone names one mode twice. `order` N says that 2 N
    times the speed meets them. `low` and `high` are shaft speeds, rad/s; both nan where
    damping has closed the zone. `max_growth_rate` is the largest growth in it, 1/s.
    """

    kind: ZoneKind
    modes: tuple[int, int]
    centre: float
    low: float
    high: float
    max_growth_rate: float
    order: int = 1

    @property
    def is_open(self) -> bool:
        """Whether there is such a zone at all."""
        return bool(self.low < self.high)


def instability_zones(
    line: TorsionalLine,
    *,
    about: Linearisation = linearised_about_rigid_rotation,
    window: float | None = None,
    samples: int = 160,
    orders: int = 1,
) -> tuple[InstabilityZone, ...]:
    """Zones where twice the speed, or N times that, meets 2 w_i, w_i + w_j or w_i - w_j.

    Parameters
    ----------
    line
        One line, no leading axes.
    about
        What to linearise about: `linearised_about_rigid_rotation` or
        `linearised_about_periodic_motion`.
    window
        How far from its centre a zone is looked for, as a share of the speed. By default
        three times the first-order width of the widest: farther out lie other zones.
    samples
        Speeds tried in the window; a zone narrower than a step between them is missed.
    orders
        Largest N.

    Returns
    -------
    tuple of InstabilityZone
        Of each order principal zones first, then the combinations of each pair; closed ones
        included.

    Notes
    -----
    What stands in a window belongs to it only if none of the zones of its own sort, up to one
    order more, lies nearer: the multipliers of a principal zone are real, those of a
    combination are not. So no zone of second order is taken for a difference, which is
    stable to first order.
    """
    w = natural_frequencies(line)
    n = w.size
    every: list[tuple[ZoneKind, int, int, int, float]] = []
    for order in range(1, orders + 2):
        every.extend(("principal", i, i, order, w[i] / order) for i in range(n))
        for i, j in combinations(range(n), 2):
            every.append(("sum", i, j, order, (w[i] + w[j]) / 2 / order))
            every.append(("difference", i, j, order, (w[j] - w[i]) / 2 / order))
    uneven = np.tan(np.append(np.ravel(line.beta), line.front) / 2) ** 2
    window = min(0.3, 1e-3 + 3 * float(uneven.sum())) if window is None else window
    found: list[InstabilityZone] = []
    for kind, i, j, order, centre in every:
        if not centre > 1e-6 * w[-1] or order > orders:
            continue
        rivals = np.array([c for k, *_, c in every if (k == "principal") == (kind == "principal")])
        # Undamped rates outside a zone are rounding: hold them against a small share of w.
        floor = 1e-6 * centre

        def margin(speed: FloatArray, floor: float = floor) -> FloatArray:
            return growth_rate(about(line, speed), tolerance=1e-12) - floor

        span = (centre * (1 - window), centre * (1 + window))
        grid = np.linspace(*span, samples + 1)
        rate = margin(grid)
        ends = find_zeros(margin, between=span, start=samples)
        pairs = [(a, b) for a, b in pairwise(ends)
                 if margin(np.array([(a + b) / 2]))[0] > 0
                 and _real(about(line, np.array([(a + b) / 2]))) == (kind == "principal")
                 and np.abs(rivals - (a + b) / 2).min() == abs(centre - (a + b) / 2)]  # fmt: skip
        low, high = min(pairs, key=lambda p: abs(sum(p) / 2 - centre), default=(np.nan, np.nan))
        inside = (grid >= low) & (grid <= high)
        top = float(rate[inside].max()) if inside.any() else 0.0
        found.append(
            InstabilityZone(kind=kind, modes=(i + 1, j + 1), centre=float(centre), low=float(low),
                 high=float(high), max_growth_rate=top, order=order)
        )  # fmt: skip
    return tuple(found)


def _real(system: PeriodicSystem) -> bool:
    """Return whether the largest multiplier of one case is real."""
    rho = floquet_multipliers(system, tolerance=1e-12).ravel()
    largest = rho[np.abs(rho).argmax()]
    return abs(largest.imag) < 1e-6 * abs(largest)
