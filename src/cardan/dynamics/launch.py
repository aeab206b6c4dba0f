r"""A vehicle from rest: its clutch or converter, its joints, its tyres, in time.

The line of `branched` with its rotations counted from where it stands. Its springs and its
mean damping are linear; what is not stands beside them: the joints (exactly, their angles
following the axle as it winds up), and springs that hold only so much. Such a spring of
stiffness k carries k e, and

$$\dot e = \dot d - e / \tau, \quad |k e| \le T_{max}(t)$$

where d is its twist: a clutch (grips up to what its ramp allows, else slips), a tyre
(relaxes as it rolls, slides at μ N), a road (rolling resistance and slope hold a vehicle that
stands, and brake one that moves). A play carries nothing until it is crossed.

Steps by Newmark's method with a little damping of what is too fast for them, and Newton's in
each: stiff springs cost nothing. Derived; held against an adaptive integration in the tests.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from cardan.base.arrays import FloatArray, single_threaded
from cardan.base.errors import NotConverged
from cardan.dynamics.branched import Branched, Modes, damped

GAMMA = 0.505
"""Of Newmark's method: above a half, so that what steps cannot follow dies away."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Holding:
    """Springs of a line that hold only so much, H of them; B cases lead.

    Attributes
    ----------
    springs : (H,)
        Their places among the line's springs.
    most : callable
        Gives the largest torque (B, H) N m at a time, s.
    relaxation : (H,) m
        Way that the vehicle rolls while a spring forgets; inf for one that does not.
    """

    springs: tuple[int, ...]
    most: Callable[[float], FloatArray]
    relaxation: FloatArray


@dataclass(frozen=True, kw_only=True, eq=False)
class Travel:
    """What a launch did: B cases, N instants.

    Attributes
    ----------
    time : (N,) s
    torque : (B, N, S) N m
        Of every spring.
    rotation, rate : (B, N, n) rad, rad/s
        Of every freedom.
    """

    time: FloatArray
    torque: FloatArray
    rotation: FloatArray
    rate: FloatArray


def modal_damping(line: Branched, found: Modes) -> FloatArray:
    """Return a damping matrix (..., n, n) N m s/rad that damps each mode as its parts do.

    C = M Φ diag(2 ζ w) Φᵀ M: what hysteresis comes to in time, mode by mode.
    """
    _, zeta = damped(line, found)
    E = line.straight
    weighed = (E.T @ line.mass @ E) @ found.shape
    lost = 2 * zeta * found.frequency
    return np.einsum("...im,...m,...jm->...ij", weighed, lost, weighed, optimize=True)


@single_threaded()
def launch(
    line: Branched,
    damping: FloatArray,
    *,
    leads: Callable[[FloatArray], np.ndarray],
    follows: int,
    holding: Holding,
    rolls: tuple[int, float],
    driving: Callable[[float, FloatArray], FloatArray],
    rate: FloatArray,
    play: tuple[int, float] | None = None,
    duration: float,
    step: float = 1e-3,
) -> Travel:
    """Integrate a start from rest.

    Parameters
    ----------
    line
        B cases, (B, ...).
    damping : (n, n) N m s/rad
        Of the motion about the mean one: `modal_damping`.
    leads
        Takes how far the freedom `follows` has turned, (B,) rad, and gives each joint's
        tan²(β/2) e^{2i·place}, (B, J).
    follows
        The freedom that the joints' angles follow: the axle's housing.
    holding
        Springs that hold only so much.
    rolls
        The vehicle's freedom, and its radius, m.
    driving
        Torques (B, n) N m on the freedoms, from the time in s and their rates (B, n).
    rate : (B, n) rad/s
        At the beginning.
    play
        A spring, and the angle that it turns through freely, rad.
    duration, step : s

    Raises
    ------
    NotConverged
        If a step does not settle.
    """
    n, E = line.size, line.straight
    B = rate.shape[0]
    h, gamma = step, GAMMA
    beta = (gamma + 0.5) ** 2 / 4
    count = round(duration / h)
    held = list(holding.springs)
    free = [
        k for k in range(line.springs.shape[0]) if k not in held and (play is None or k != play[0])
    ]
    k_all = np.broadcast_to(line.stiffness, (B, line.stiffness.shape[-1]))
    Y, Mz = line.springs, np.broadcast_to(line.mass, (B, *line.mass.shape[-2:]))
    K = np.einsum("bs,si,sj->bij", k_all[:, free], Y[free], Y[free], optimize=True)
    Yh, kh = Y[held], k_all[:, held]
    Mq, Kq = E.T @ Mz @ E, E.T @ K @ E
    inner = Mq / (beta * h * h) + gamma / (beta * h) * damping + Kq
    Yq = Yh @ E
    joints = line.joints
    q, v, a = np.zeros((B, n)), rate.astype(float).copy(), np.zeros((B, n))
    e = np.zeros((B, len(held)))
    d_old = np.zeros((B, len(held)))
    out_q, out_v = np.empty((B, count + 1, n)), np.empty((B, count + 1, n))
    out_T = np.zeros((B, count + 1, Y.shape[0]))
    out_q[:, 0], out_v[:, 0] = q, v
    y_play = Y[play[0]] if play else None
    start = _leads(leads(q[:, follows]), q[:, joints])[0]
    for i in range(1, count + 1):
        t = i * h
        most = holding.most(t)
        force = driving(t, v)
        x = q + h * v + h * h * (0.5 - beta) * a
        u = v + h * (1 - gamma) * a
        q = q + h * v + 0.5 * h * h * a  # a first guess
        for attempt in range(80):
            a = (q - x) / (beta * h * h)
            v = u + gamma * h * a
            delta, slope, bend = _leads(leads(q[:, follows]), q[:, joints])
            z = np.concatenate([q, q[:, joints] + delta - start], axis=-1)
            zdd = np.concatenate([a, slope * a[:, joints] + bend * v[:, joints] ** 2], axis=-1)
            pulled = np.einsum("bij,bj->bi", Mz, zdd) + np.einsum("bij,bj->bi", K, z)
            d = z @ Yh.T
            way = np.abs(v[:, rolls[0]])[:, None] * rolls[1] * h
            forgets = 1 / (1 + way / holding.relaxation)
            tried = (e + d - d_old) * forgets
            bound = most / kh
            now = np.clip(tried, -bound, bound)
            T_held = kh * now
            pulled += T_held @ Yh
            # Newton's own tangent first. Where a spring goes on sticking and slipping in turn,
            # as if all stuck: slower, and it comes to rest.
            gives = (np.abs(tried) <= bound) | (attempt > 6)
            tangent = inner + np.einsum("bs,si,sj->bij", np.where(gives, kh * forgets, 0.0), Yq, Yq)
            if y_play is not None:
                gap = z @ y_play
                over = gap - np.clip(gap, -play[1] / 2, play[1] / 2)  # type: ignore[index]
                kp = k_all[:, play[0]]  # type: ignore[index]
                pulled += (kp * over)[:, None] * y_play
                yq = y_play @ E
                tangent = tangent + (kp * ((over != 0) | (attempt > 6)))[:, None, None] * np.outer(
                    yq, yq
                )
            left = pulled[:, :n] + v @ damping.T - force
            for c, j in enumerate(joints.tolist()):
                left[:, j] += slope[:, c] * pulled[:, n + c]
            change = np.linalg.solve(tangent, left[..., None])[..., 0]
            q = q - change
            if np.abs(change).max() < 1e-10:
                break
        else:
            if not np.abs(change).max() < 1e-7:
                msg = f"the launch does not settle at {t:.3f} s: try a shorter step"
                raise NotConverged(msg)
        a = (q - x) / (beta * h * h)
        v = u + gamma * h * a
        e, d_old = now, d
        out_q[:, i], out_v[:, i] = q, v
        out_T[:, i] = k_all * (z @ Y.T)
        out_T[:, i, held] = T_held
        if play is not None:
            out_T[:, i, play[0]] = kp * over
    return Travel(time=h * np.arange(count + 1), torque=out_T, rotation=out_q, rate=out_v)


def _leads(P: np.ndarray, turned: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return φ - u, φ' and φ'' of joints with P = tan²(β/2) e^{2i·place}, driven through `turned`.

    φ - u = -arg(1 - X), φ' = (1 - |X|²) / |1 - X|², X = P e^{2iu}.
    """
    X = P * np.exp(2j * turned)
    below = np.abs(1 - X) ** 2
    slope = (1 - np.abs(X) ** 2) / below
    return -np.angle(1 - X), slope, -slope * 4 * X.imag / below


def order_amplitude(signal: FloatArray, turned: FloatArray, order: int) -> FloatArray:
    """Amplitude of an order of a turn in a signal, at each instant: (..., N), 0-to-peak.

    Over the window that the order needs for one period, round each instant; nan where the
    signal is shorter than that on either side.
    """
    steps = np.diff(turned, axis=-1)
    wave = signal * np.exp(-1j * order * turned)
    between = (wave[..., 1:] + wave[..., :-1]) / 2 * steps
    summed = np.concatenate([np.zeros_like(between[..., :1]), np.cumsum(between, axis=-1)], axis=-1)
    half = np.pi / order
    out = np.full(signal.shape, np.nan)
    for index in np.ndindex(signal.shape[:-1]):
        u, s = turned[index], summed[index]
        inside = (u - half >= u[0]) & (u + half <= u[-1])
        at = u[inside]
        total = np.interp(at + half, u, s.real) - np.interp(at - half, u, s.real)
        other = np.interp(at + half, u, s.imag) - np.interp(at - half, u, s.imag)
        out[(*index, inside)] = np.hypot(total, other) / half
    return out
