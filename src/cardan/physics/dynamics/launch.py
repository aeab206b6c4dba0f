r"""A vehicle from rest: its clutch or converter, its joints, its tyres, in time.

The line of `torsional_network` with its rotations counted from where it stands. Its springs and its
mean damping are linear; the rest is separate: the joints (exactly, their angles
following the axle as it winds up), and springs that hold only so much. Such a spring of
stiffness k carries k e, and

$$\dot e = \dot d - e / \tau, \quad |k e| \le T_{max}(t)$$

where d is its twist: a clutch (grips up to what its ramp allows, else slips), a tyre
(relaxes as it rolls, slides at μ N), a road (rolling resistance and slope hold a vehicle that
stands, and brake one that moves). A play carries nothing until it is crossed.

From one change of what slips, sticks and touches to the next the line is linear but for its
joints, y' = A y + g, and moves by e^{Ah}: exactly, however stiff its springs. What joints,
engine and rolling add, g, runs straight within a step. A step in which something changes is
halved until the change lies at its end, to a 256th of a step. Derived; held against an adaptive
integration with events in the tests.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import numpy as np

from cardan.core.arrays import BoolArray, ComplexArray, FloatArray, IntArray, single_threaded_blas
from cardan.core.errors import ConvergenceError
from cardan.physics.dynamics.torsional_network import TorsionalModes, TorsionalNetwork, damped_modes

MAX_STEP_HALVINGS = 8
"""How often a step is halved, at most, to meet a change."""

SMALLEST_SUBSTEPS_PER_TIME_STEP = 2**MAX_STEP_HALVINGS
"""Units of a step."""


@dataclass(frozen=True, kw_only=True, eq=False)
class FrictionElements:
    """Springs of a line that hold only so much, H of them; B cases lead.

    Attributes
    ----------
    springs : (H,)
        Their places among the line's springs.
    max_torque : callable
        Gives the largest torque (B, H) N m at a time, s.
    relaxation_length : (H,) m
        Way that the vehicle rolls while a spring forgets; inf for one that does not.
    """

    springs: tuple[int, ...]
    max_torque: Callable[[float], FloatArray]
    relaxation_length: FloatArray


@dataclass(frozen=True, kw_only=True, eq=False)
class LaunchHistory:
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


def spring_parallel_damping_matrix(
    line: TorsionalNetwork, found: TorsionalModes, *, slide: Sequence[int]
) -> FloatArray:
    """Return a damping matrix (n, n) N m s/rad of dampers in parallel with the springs of one case.

    As strong as to damp each mode as nearly as its parts do; none at springs that `slide`,
    whose torque is what they hold and no more.
    """
    from scipy.optimize import nnls

    _, zeta = damped_modes(line, found)
    turns = line.springs @ line.straight_transform
    own = [k for k in range(len(turns)) if k not in slide]
    lost = 2 * zeta[1:] * found.frequency[1:]
    share = (turns[own] @ found.shape[:, 1:]).T ** 2
    # A ramp shakes a mode the less the faster it is.
    weight = found.frequency[1] / found.frequency[1:] / np.where(lost > 0, lost, np.inf)
    dampers = nnls(share * weight[:, None], lost * weight)[0]
    return (turns[own].T * dampers) @ turns[own]


@single_threaded_blas()
def integrate_launch(
    line: TorsionalNetwork,
    damping: FloatArray,
    *,
    leads: Callable[[FloatArray], ComplexArray],
    follows: int,
    holding: FrictionElements,
    rolls: tuple[int, float],
    driving: Callable[[float, FloatArray], FloatArray],
    rate: FloatArray,
    play: tuple[int, float] | None = None,
    duration: float,
    step: float = 1e-3,
) -> LaunchHistory:
    """Integrate a start from rest, in B cases.

    Parameters
    ----------
    line
        One case: what differs from case to case are the callables.
    damping : (n, n) N m s/rad
        On rates: `spring_parallel_damping_matrix`.
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
    ConvergenceError
        If the motion runs away.
    """
    # Two instants to a step: half way through one the motion is known as well.
    (B, n), H, count = rate.shape, len(holding.springs), 2 * round(duration / step / 2)
    made = _LaunchSystem(
        line, damping, leads=leads, follows=follows, holding=holding, rolls=rolls, driving=driving,
        play=play, cases=B, unit=2 * step / SMALLEST_SUBSTEPS_PER_TIME_STEP,
    )  # fmt: skip
    y = np.concatenate([np.zeros((B, n)), rate, np.zeros((B, H))], axis=1)
    how = _ContactState(np.zeros((B, H), dtype=int), np.zeros(B, dtype=int))
    now = made.look(0.0, y, how)
    states = np.empty((B, count + 1, 2 * n + H))
    torque = np.empty((B, count + 1, len(line.springs)))
    states[:, 0], torque[:, 0] = y, made.torques(y, now.added, how)
    for i in range(0, count, 2):
        at = 0
        while at < SMALLEST_SUBSTEPS_PER_TIME_STEP:
            part = at & -at if at else SMALLEST_SUBSTEPS_PER_TIME_STEP
            while True:
                time = (
                    (i + 2 * at / SMALLEST_SUBSTEPS_PER_TIME_STEP) * step,
                    (i + 2 * (at + part) / SMALLEST_SUBSTEPS_PER_TIME_STEP) * step,
                )
                half, end, after = made.moved(time, y, now, how, part)
                changed = made.changed(end, after, how)
                between = (now.most + after.most) / 2
                if part == 1 or (changed is how and not made.over(half, between, how).any()):
                    break
                part //= 2
            if part == SMALLEST_SUBSTEPS_PER_TIME_STEP:
                states[:, i + 1] = half
                torque[:, i + 1] = made.torques(half, (now.added + after.added) / 2, how)
            at, y, now = at + part, end, after
            if at == SMALLEST_SUBSTEPS_PER_TIME_STEP // 2:
                states[:, i + 1], torque[:, i + 1] = y, made.torques(y, now.added, how)
            if changed is not how:
                how, now = changed, made.look(time[1], y, changed)
        states[:, i + 2], torque[:, i + 2] = y, made.torques(y, now.added, how)
    if not np.isfinite(states[:, -1]).all():
        msg = "the launch runs away: try a shorter step"
        raise ConvergenceError(msg)
    return LaunchHistory(
        time=np.arange(count + 1, dtype=np.float64) * step,
        torque=torque,
        rotation=states[..., :n],
        rate=states[..., n : 2 * n],
    )


@dataclass(frozen=True, slots=True, eq=False)
class _ContactState:
    """What slips (B, H), -1, 0 or 1 by its sense, and which flank of the play touches (B,)."""

    slips: IntArray
    touches: IntArray
    moves: dict[int, FloatArray] = field(default_factory=dict[int, FloatArray])
    """What takes (y, g, g') by a step of 2^k units, (B, m, m + 2 (n + H)): made when needed."""


@dataclass(frozen=True, slots=True, eq=False)
class _StateObservation:
    """A state looked at.

    `left_out` (B, n + H) is what the linear line leaves out, `added` (B, S) N m what leads and
    play add to torques, `most` (B, H) N m what springs hold, `gap` (B,) rad the play's turning.
    """

    left_out: FloatArray
    added: FloatArray
    most: FloatArray
    gap: FloatArray


class _LaunchSystem:
    """The line as states y = (q, q', e), m = 2 n + H of them, moving by y' = A y + g."""

    def __init__(
        self,
        line: TorsionalNetwork,
        damping: FloatArray,
        *,
        leads: Callable[[FloatArray], ComplexArray],
        follows: int,
        holding: FrictionElements,
        rolls: tuple[int, float],
        driving: Callable[[float, FloatArray], FloatArray],
        play: tuple[int, float] | None,
        cases: int,
        unit: float,
    ) -> None:
        self.line, self.leads, self.follows = line, leads, follows
        self.holding, self.rolls, self.driving, self.unit = holding, rolls, driving, unit
        n, E, held = line.size, line.straight_transform, list(holding.springs)
        self.loose, self.play = play or (-1, 0.0)
        self.stiffness = line.stiffness.copy()
        self.stiffness[[*held, *([self.loose] if play else [])]] = 0.0
        K = (line.springs.T * self.stiffness) @ line.springs
        self.twist, self.turned = line.springs @ E, line.mass_matrix @ E
        self.firm, self.held = line.stiffness[held], self.twist[held]
        self.hard = float(line.stiffness[self.loose]) if play else 0.0
        self.struck, self.strikes = self.twist[self.loose], line.springs[self.loose]
        self.straight = E.T @ self.turned
        inverse = np.linalg.inv(self.straight)
        force = -np.hstack([E.T @ K @ E, damping, self.held.T * self.firm])
        self.fast, self.by_play = inverse @ force, -self.hard * inverse @ self.struck
        behind = np.hstack([(K @ E)[n:], np.zeros((len(line.joints), n + len(held)))])
        self.rows = np.vstack([force, self.fast, behind])
        self.beside = np.hstack([K[:, n:], line.mass_matrix[:, n:]])
        self.added = line.springs[:, n:] * line.stiffness[:, None]
        self.added[held] = 0.0
        self.begun = _leads(leads(np.zeros(cases)), np.zeros((cases, len(line.joints))))[0]
        self.tables: dict[bytes, list[FloatArray]] = {}

    def look(self, t: float, y: FloatArray, how: _ContactState) -> _StateObservation:
        """Return what a state holds in addition to the linear line."""
        line, joints, n = self.line, self.line.joints, self.line.size
        q, v, e = y[:, :n], y[:, n : 2 * n], y[:, 2 * n :]
        delta, slope, bend = _leads(self.leads(q[:, self.follows]), q[:, joints])
        extra, more = delta - self.begun, slope - 1
        known = y @ self.rows.T
        force, fast, behind = known[:, :n], known[:, n : 2 * n], known[:, 2 * n :]
        beside = np.hstack([extra, bend * v[:, joints] ** 2]) @ self.beside.T
        added, gap = extra @ self.added.T, np.zeros(len(y))
        if self.play:
            turned = q @ self.struck
            gap = turned + extra @ self.strikes[n:]
            touch = np.abs(how.touches)
            carries = self.hard * touch * (gap - how.touches * (self.play / 2))
            beside += carries[:, None] * self.strikes
            fast = fast + (touch * turned)[:, None] * self.by_play
            added[:, self.loose] = carries - self.hard * touch * turned
        # In addition to the common rotation, E, each joint turns more than straight.
        across = more[..., None] * self.turned[n:]
        mass = np.repeat(self.straight[None], len(y), axis=0)
        mass[:, joints] += across
        mass[:, :, joints] += np.swapaxes(across, -1, -2)
        mass[:, joints[:, None], joints] += (
            more[:, :, None] * more[:, None] * line.mass_matrix[n:, n:]
        )
        push = self.driving(t, v) + force - beside[:, :n]
        push[:, joints] -= slope * beside[:, n:] + more * behind
        out = np.empty((len(y), n + len(self.firm)))
        out[:, :n] = np.linalg.solve(mass, push[..., None])[..., 0] - fast
        rolled = np.abs(v[:, self.rolls[0], None]) * self.rolls[1]
        out[:, n:] = -rolled / self.holding.relaxation_length * e
        return _StateObservation(out, added, np.minimum(self.holding.max_torque(t), 1e15), gap)

    def torques(self, y: FloatArray, added: FloatArray, how: _ContactState) -> FloatArray:
        """Torque of every spring, (B, S) N m, with what leads and play add to the straight line."""
        n = self.line.size
        found = (y[:, :n] @ self.twist.T) * self.stiffness + added
        found[:, list(self.holding.springs)] = y[:, 2 * n :] * self.firm
        if self.play:
            found[:, self.loose] += self.hard * np.abs(how.touches) * (y[:, :n] @ self.struck)
        return found

    def moved(
        self,
        time: tuple[float, float],
        y: FloatArray,
        now: _StateObservation,
        how: _ContactState,
        part: int,
    ) -> tuple[FloatArray, FloatArray, _StateObservation]:
        """Return the state half way through a step of so many units, at its end, and its look."""
        n, m, h = self.line.size, y.shape[1], time[1] - time[0]
        w = now.left_out.shape[1]
        k = part.bit_length() - 1
        Z = self._propagators(how, k)
        most = np.minimum(self.holding.max_torque(time[1]), 1e15)
        slips = how.slips != 0
        # What slips carries what its bound is, at the end and in between.
        slides = how.slips * (most - now.most) / (h * self.firm)
        begins = now.left_out.copy()
        begins[:, n:] = np.where(slips, slides, begins[:, n:])
        x = np.concatenate([y, begins, np.zeros((len(y), w))], axis=1)[..., None]
        after = self.look(time[1], (Z @ x)[..., 0], how)
        x[:, m + w :, 0] = (after.left_out - begins) / h
        x[:, m + w + n :, 0][slips] = 0.0
        y = (Z @ x)[..., 0]
        y[:, 2 * n :] = np.where(slips, how.slips * most / self.firm, y[:, 2 * n :])
        return (self._propagators(how, k - 1) @ x)[..., 0] if k else y, y, after

    def over(self, y: FloatArray, most: FloatArray, how: _ContactState) -> BoolArray:
        """Return which springs that stick carry more than they can hold, (B, H)."""
        torque = np.abs(y[:, 2 * self.line.size :]) * self.firm
        return (how.slips == 0) & (torque > most * (1 + 1e-9))

    def changed(self, y: FloatArray, seen: _StateObservation, how: _ContactState) -> _ContactState:
        """Return what slips and touches in a state: the same, if nothing has changed."""
        n = self.line.size
        rates, over = y[:, n : 2 * n] @ self.held.T, self.over(y, seen.most, how)
        goes_on = np.where(rates * how.slips >= 0, how.slips, 0)
        slips = np.where(over, np.sign(y[:, 2 * n :]), goes_on).astype(int)
        touches = how.touches
        if self.play:
            touches = np.where(np.abs(seen.gap) > self.play / 2, np.sign(seen.gap), 0).astype(int)
        if (slips == how.slips).all() and (touches == how.touches).all():
            return how
        return _ContactState(slips, touches)

    def _propagators(self, how: _ContactState, halved: int) -> FloatArray:
        if halved not in how.moves:
            changes = np.column_stack([how.slips, how.touches]) != 0
            how.moves[halved] = np.stack([self._table(row)[halved] for row in changes])
        return how.moves[halved]

    def _table(self, changes: BoolArray) -> list[FloatArray]:
        """Return e^{Ah} with its two integrals over g, for steps of 1, 2, 4 ... units.

        `changes` (H + 1,) says which springs slip, and whether the play touches.
        """
        from scipy.linalg import expm

        key, slips = changes.tobytes(), changes[:-1]
        if key not in self.tables:
            n, H = self.line.size, len(slips)
            m, w = 2 * n + H, n + H
            A = np.zeros((m + 2 * w, m + 2 * w))
            A[:n, n : 2 * n] = np.eye(n)
            A[n : 2 * n, :m] = self.fast
            if changes[-1]:
                A[n : 2 * n, :n] += np.outer(self.by_play, self.struck)
            A[2 * n : m, n : 2 * n] = self.held * ~slips[:, None]
            A[n:m, m : m + w] = np.eye(w)
            A[m : m + w, m + w :] = np.eye(w)
            found = [expm(A * self.unit)]
            for _ in range(MAX_STEP_HALVINGS):
                found.append(found[-1] @ found[-1])
            self.tables[key] = [Z[:m] for Z in found]
        return self.tables[key]


def _leads(P: ComplexArray, turned: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return φ - u, φ' and φ'' of joints with P = tan²(β/2) e^{2i·place}, driven through `turned`.

    φ - u = -arg(1 - X), φ' = (1 - |X|²) / |1 - X|², X = P e^{2iu}.
    """
    X = P * np.exp(2j * turned)
    below = np.abs(1 - X) ** 2
    slope = (1 - np.abs(X) ** 2) / below
    return -np.angle(1 - X), slope, -slope * 4 * np.imag(X) / below


def instantaneous_order_amplitude(signal: FloatArray, turned: FloatArray, order: int) -> FloatArray:
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
