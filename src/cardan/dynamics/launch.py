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

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from cardan.base.arrays import ComplexArray, FloatArray, single_threaded
from cardan.base.errors import NotConverged
from cardan.dynamics.branched import Branched, Modes, damped

TRIES = 80
"""Rounds of Newton's method in a step, at most."""

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


def part_damping(line: Branched, found: Modes, *, slide: Sequence[int]) -> FloatArray:
    """Return a damping matrix (n, n) N m s/rad of dampers beside the springs of one case.

    As strong as to damp each mode as nearly as its parts do; none beside springs that `slide`,
    whose torque is what they hold and no more.
    """
    from scipy.optimize import nnls

    _, zeta = damped(line, found)
    turns = line.springs @ line.straight
    own = [k for k in range(len(turns)) if k not in slide]
    lost = 2 * zeta[1:] * found.frequency[1:]
    share = (turns[own] @ found.shape[:, 1:]).T ** 2
    # A ramp shakes a mode the less the faster it is.
    weight = found.frequency[1] / found.frequency[1:] / np.where(lost > 0, lost, np.inf)
    dampers = nnls(share * weight[:, None], lost * weight)[0]
    return (turns[own].T * dampers) @ turns[own]


@single_threaded()
def launch(
    line: Branched,
    damping: FloatArray,
    *,
    leads: Callable[[FloatArray], ComplexArray],
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
        On rates: `part_damping`.
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
    B, S = rate.shape[0], line.springs.shape[0]
    h, gamma = step, GAMMA
    beta = (gamma + 0.5) ** 2 / 4
    count = round(duration / h)
    settled = 1e-3 * h * h  # rad: what is left of an acceleration is 4e-3 rad/s²
    held = list(holding.springs)
    loose = play[0] if play else -1
    stiffness = np.broadcast_to(line.stiffness, (B, S))
    mass = np.broadcast_to(line.mass, (B, *line.mass.shape[-2:]))
    Y = line.springs
    linear = [k for k in range(S) if k not in held and k != loose]
    K = np.einsum("bs,si,sj->bij", stiffness[:, linear], Y[linear], Y[linear], optimize=True)
    inner = E.T @ (mass / (beta * h * h) + K) @ E + gamma / (beta * h) * damping
    Yh, kh, Yq = Y[held], stiffness[:, held], Y[held] @ E
    joints = line.joints
    nothing = np.zeros((B, len(held)))
    begun = _leads(leads(np.zeros(B)), np.zeros((B, len(joints))))[0]

    def tried(q: FloatArray, v: FloatArray, a: FloatArray, at: "_Step", *, stuck: bool) -> "_Step":
        """Return what a guess leaves over of the equations, and the tangent there."""
        delta, slope, bend = _leads(leads(q[:, follows]), q[:, joints])
        z = np.concatenate([q, q[:, joints] + delta - begun], axis=-1)
        turning = np.concatenate([a, slope * a[:, joints] + bend * v[:, joints] ** 2], axis=-1)
        pulled = (mass @ turning[..., None] + K @ z[..., None])[..., 0]
        torque = stiffness * (z @ Y.T)
        twist = z @ Yh.T
        way = np.abs(v[:, rolls[0]])[:, None] * rolls[1] * h
        forgets = 1 / (1 + way / holding.relaxation)
        elastic = (at.elastic + twist - at.twist) * forgets
        bound = at.most / kh
        now = np.clip(elastic, -bound, bound)
        torque[:, held] = kh * now
        pulled += torque[:, held] @ Yh
        gives = (np.abs(elastic) <= bound) | stuck
        tangent = inner + (Yq.T * np.where(gives, kh * forgets, 0.0)[:, None]) @ Yq
        if play:
            gap = z @ Y[loose]
            over = gap - np.clip(gap, -play[1] / 2, play[1] / 2)
            torque[:, loose] = stiffness[:, loose] * over
            pulled += torque[:, loose, None] * Y[loose]
            row, gives = Y[loose] @ E, (over != 0) | stuck
            tangent += (stiffness[:, loose] * gives)[:, None, None] * np.outer(row, row)
        left = pulled[:, :n] + v @ damping.T
        for c, j in enumerate(joints.tolist()):
            left[:, j] += slope[:, c] * pulled[:, n + c]
        return _Step(left, tangent, torque, elastic=now, twist=twist, most=at.most)

    q, v = np.zeros((B, n)), rate.astype(float)
    a = np.linalg.solve(E.T @ mass @ E, (driving(0.0, v) - v @ damping.T)[..., None])[..., 0]
    now = _Step(q, inner, np.zeros((B, S)), elastic=nothing, twist=nothing, most=nothing)
    rotation, rates, torque = (np.zeros((B, count + 1, w)) for w in (n, n, S))
    rates[:, 0] = v
    for i in range(1, count + 1):
        t = i * h
        force, begins = driving(t, v), replace(now, most=holding.most(t))
        x = q + h * v + h * h * (0.5 - beta) * a
        u = v + h * (1 - gamma) * a
        q = q + h * v + 0.5 * h * h * a  # a first guess
        for attempt in range(TRIES):
            a = (q - x) / (beta * h * h)
            v = u + gamma * h * a
            # Newton's own tangent first. Where a spring goes on sticking and slipping in turn,
            # as if all stuck: slower, and it comes to rest.
            now = tried(q, v, a, begins, stuck=attempt > 6)
            change = np.linalg.solve(now.tangent, (now.left - force)[..., None])[..., 0]
            q = q - change
            if np.abs(change).max() < (settled if attempt < TRIES // 2 else 100 * settled):
                break
        else:
            msg = f"the launch does not settle at {t:.3f} s: try a shorter step"
            raise NotConverged(msg)
        a = (q - x) / (beta * h * h)
        v = u + gamma * h * a
        rotation[:, i], rates[:, i], torque[:, i] = q, v, now.torque
    return Travel(
        time=np.arange(count + 1, dtype=np.float64) * h,
        torque=torque,
        rotation=rotation,
        rate=rates,
    )


@dataclass(frozen=True, slots=True)
class _Step:
    """A step as far as it has come: what is left over, its tangent, torques, what is held."""

    left: FloatArray
    tangent: FloatArray
    torque: FloatArray
    elastic: FloatArray
    twist: FloatArray
    most: FloatArray


def _leads(P: ComplexArray, turned: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return φ - u, φ' and φ'' of joints with P = tan²(β/2) e^{2i·place}, driven through `turned`.

    φ - u = -arg(1 - X), φ' = (1 - |X|²) / |1 - X|², X = P e^{2iu}.
    """
    X = P * np.exp(2j * turned)
    below = np.abs(1 - X) ** 2
    slope = (1 - np.abs(X) ** 2) / below
    return -np.angle(1 - X), slope, -slope * 4 * np.imag(X) / below


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
