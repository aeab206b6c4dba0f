r"""Play in a joint: pins that leave one side of their bushes and strike the other.

A joint with play is in one of two states: in contact, on the drive or the overrun side, or
in free flight. In contact the pin sinks δ into its bush and

$$F = K\delta^n\left(1 + a\,\dot\delta/v_0\right),$$

with v₀ the speed it arrived at and a the damping of a contact law, here functions of the
coefficient of restitution e, by their authors' names.
Sources: Lu et al. on universal joints with clearance; contact laws as reviewed by Machado,
Moreira, Flores & Lankarani, Mech. Mach. Theory 53 (2012) 99-121. The model is Lu's in its
two states and Hertz contact; its figures were not at hand and are not compared.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, TypeAlias

import numpy as np

from cardan.core.arrays import FloatArray
from cardan.core.errors import ConvergenceError, DesignError
from cardan.physics.dynamics.torsional_line import output_angle_derivatives

ContactDampingLaw: TypeAlias = Callable[[float], float]
"""A contact law: the damping a of a coefficient of restitution e in (0, 1]."""


def hunt_crossley_damping_factor(e: float) -> float:
    """Return 3 (1 - e) / 2: Hunt & Crossley (1975), for e near 1."""
    return 1.5 * (1 - e)


def lankarani_nikravesh_damping_factor(e: float) -> float:
    """Return 3 (1 - e²) / 4: Lankarani & Nikravesh (1990), for e near 1."""
    return 0.75 * (1 - e**2)


def herbert_mcwhannell_damping_factor(e: float) -> float:
    """Return 6 (1 - e) / ((2e - 1)² + 3): Herbert & McWhannell (1977)."""
    return 6 * (1 - e) / ((2 * e - 1) ** 2 + 3)


def lee_wang_damping_factor(e: float) -> float:
    """Return 3 (1 - e) / 4: Lee & Wang (1983)."""
    return 0.75 * (1 - e)


def flores_damping_factor(e: float) -> float:
    """Return 8 (1 - e) / (5 e): Flores et al. (2011), for the whole range of e."""
    return 1.6 * (1 - e) / e


def hu_guo_damping_factor(e: float) -> float:
    """Return 3 (1 - e) / (2 e): Hu & Guo (2015), for the whole range of e."""
    return 1.5 * (1 - e) / e


def effective_restitution(law: ContactDampingLaw, restitution: float) -> float:
    """Speed of leaving over speed of arriving that a law really gives in a free impact.

    Exact, whatever mass, stiffness and exponent: along an impact the energy equation
    separates, and u/a - ln(1 + a u)/a² is the same at both ends (u = speed over v₀).
    """
    a = law(restitution)
    if a == 0:
        return 1.0
    from scipy.optimize import brentq

    # The contact never pulls, so it leaves below v0 / a: with e = (1 - exp(-s)) / a the
    # two ends meet where s - 1 + exp(-s) = a - ln(1 + a).
    wanted = a - np.log1p(a)
    s = brentq(lambda s: s + np.expm1(-s) - wanted, 0.0, 1.0 + a, xtol=1e-15)
    return float(-np.expm1(-s) / a)


@dataclass(frozen=True, slots=True, kw_only=True)
class JointWithBacklash:
    """A joint with play, turned uniformly, that drives an inertia against a load.

    Attributes
    ----------
    beta : rad
        Joint angle.
    play : rad
        Half the play: how far the driven side turns from the middle to contact.
    radius : m
        From the joint's centre to the contact; two arms carry.
    stiffness, exponent : N/m^n, 1
        K and n of the contact (by Hertz K = 4/3 E* √R, n = 1.5).
    restitution : 1
        e in (0, 1].
    inertia : kg m²
        Of what is driven.
    load, drag : N m, N m s/rad
        Constant and viscous load on it.
    law
        The contact law.
    """

    beta: float
    play: float
    radius: float
    stiffness: float
    inertia: float
    load: float = 0.0
    drag: float = 0.0
    exponent: float = 1.5
    restitution: float = 0.8
    law: ContactDampingLaw = flores_damping_factor

    def __post_init__(self) -> None:
        if not (self.play >= 0 and self.inertia > 0 and 0 < self.restitution <= 1):
            msg = (
                "a loose joint needs play of 0 or more, an inertia above 0 and a restitution "
                f"in (0, 1], got {self.play:g}, {self.inertia:g}, {self.restitution:g}"
            )
            raise DesignError(msg)

    def rattle_speed(self) -> float:
        """Speed, rad/s, above which the contact opens once a half turn: J max|φ''| Ω² = T."""
        _, _, second, _ = output_angle_derivatives(np.linspace(0, np.pi, 20001), beta=self.beta)
        return float(np.sqrt(self.load / (self.inertia * np.abs(second).max())))


@dataclass(frozen=True, slots=True, kw_only=True)
class RattleHistory:
    """A motion with play, in time.

    Attributes
    ----------
    time : (samples,) s
    gap : (samples,) rad
        Driving less driven rotation; beyond ± play the pins are in contact.
    speed : (samples,) rad/s
        Of the driven side.
    impact_speeds : (impacts,) rad/s
        Closing speed of every contact that began.
    """

    time: FloatArray
    gap: FloatArray
    speed: FloatArray
    impact_speeds: FloatArray


def _event(side: int, play: float, direction: int) -> Callable[..., float]:
    """Return an event of `solve_ivp`: the gap passes the play on a side, closing or opening."""

    def event(_t: float, y: FloatArray, *_: object) -> float:
        return side * float(y[0]) - play

    event.terminal, event.direction = True, direction  # type: ignore[attr-defined]
    return event


def simulate_rattle(
    joint: JointWithBacklash,
    *,
    speed: float,
    duration: float,
    gap: float | None = None,
    gap_rate: float = 0.0,
    samples: int = 2000,
    most: int = 20000,
) -> RattleHistory:
    """Follow a loose joint from contact to flight to contact, each state with its own equation.

    Parameters
    ----------
    joint
        The joint, its load and its contact law.
    speed : rad/s
        Ω of the driving side; 0 for a free impact.
    duration : s
        How long.
    gap, gap_rate : rad, rad/s
        At time 0, driving less driven; by default resting on the drive side.
    samples
        Equal instants to return.
    most
        Changes of state after which it gives up.

    Raises
    ------
    ConvergenceError
        If there are more changes of state: chattering contacts, or too long a duration.
    """
    from scipy.integrate import solve_ivp

    integrate: Callable[..., Any] = solve_ivp  # its stubs know no events with attributes
    R, K, n = joint.radius, joint.stiffness, joint.exponent
    a = joint.law(joint.restitution)

    def torque_of(sunk: float) -> float:
        return 2 * R * K * sunk**n

    def driving(t: float) -> tuple[float, float]:
        _, first, second, _ = output_angle_derivatives(speed * t, beta=joint.beta)
        return float(first) * speed, float(second) * speed**2

    def contact(state: FloatArray, side: int, arrived: float) -> float:
        """Torque on the driven side, in the sense of drive."""
        sunk = R * (side * state[0] - joint.play)
        if side == 0 or sunk <= 0:
            return 0.0
        damped = 1.0 + (a * R * side * state[1] / arrived if arrived > 0 else 0.0)
        return side * torque_of(sunk) * max(damped, 0.0)

    def rate(t: float, state: FloatArray, side: int, arrived: float) -> list[float]:
        w, acceleration = driving(t)
        driven = w - state[1]
        pushed = contact(state, side, arrived) - joint.load - joint.drag * driven
        return [state[1], acceleration - pushed / joint.inertia]

    resting = joint.play + (max(joint.load, 0.0) / torque_of(1.0)) ** (1 / n) / R
    begin = resting if gap is None else gap
    t, state = 0.0, np.array([begin, gap_rate])
    side = int(np.sign(begin)) if abs(begin) > joint.play else 0
    arrived = 0.0
    impacts: list[float] = []
    pieces: list[tuple[float, float, Any]] = []
    for _ in range(most):
        if side:
            events = [_event(side, joint.play, -1)]
        else:
            events = [_event(way, joint.play, 1) for way in (1, -1)]
        done = integrate(
            rate, (t, duration), state, args=(side, arrived), events=events, method="DOP853",
            rtol=1e-9, atol=[1e-13, 1e-10], dense_output=True,
            max_step=np.inf if speed == 0 else np.pi / speed / 16,
        )  # fmt: skip
        pieces.append((t, done.t[-1], done.sol))
        t, state = float(done.t[-1]), done.y[:, -1].copy()
        if done.status == 0:
            break
        if side:
            side, state[0] = 0, side * joint.play
        else:
            side = 1 if done.t_events[0].size else -1
            state[0] = side * joint.play
            arrived = R * abs(float(state[1]))
            impacts.append(abs(float(state[1])))
        if joint.play == 0 and not side:  # no room to fly: the other flank takes over
            side = int(np.sign(state[1])) or 1
            arrived = R * abs(float(state[1]))
    else:
        msg = f"more than {most} changes of state before {duration:g} s: the contacts chatter"
        raise ConvergenceError(msg)
    times = np.linspace(0, duration, samples)
    values = np.empty((2, samples))
    for begin, end, solution in pieces:
        inside = (times >= begin) & (times <= end)
        if inside.any():
            values[:, inside] = solution(times[inside])
    w = output_angle_derivatives(speed * times, beta=joint.beta)[1] * speed
    return RattleHistory(
        time=times, gap=values[0], speed=w - values[1], impact_speeds=np.array(impacts, dtype=float)
    )
