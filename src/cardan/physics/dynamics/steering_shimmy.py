r"""A steering column with universal joints, and the speed at which the wheels shimmy.

Five degrees of freedom: rotation of the left and right wheel about their kingpins, roll of
the axle, the steering gear, and the hand wheel at the other end of the column. The tyres
answer slip with a lag, the relaxation length; the wheels' spin couples kingpin and roll:

    I δ'' + c δ' + k_t (δ - s) + I_p (V/r) φ' + e F = 0            each wheel
    (σ/V) F' + F = C_α (δ + (e δ' + r φ')/V)                       each tyre
    I_φ φ'' + c_φ φ' + k_φ φ - I_p (V/r) (δ_L' + δ_R') + r (F_L + F_R) = 0    axle
    J_s s'' + c_s s' + k_t (2 s - δ_L - δ_R) + k_c (s - h) = 0     gear
    J_h h'' + c_h h' + k_c (h - s) = 0                             hand wheel

The column has a universal joint in it. At column angles, i times those at the kingpins, with
φ the joint's own output and u₀ where its pin stands with the wheels straight ahead,

    g = φ(i h + u₀) - φ(u₀) - i s,    g' = i (φ' h' - s'),    k = k_c / i²

is its twist. Without play its torque is k g: for small motions the column's spring works at
φ'(u₀) h, which an angle changes. With half play g₀ it is 0 in flight, |g| <= g₀, and in contact

    |g| - g₀ = q₀/k + (q₀ / 2 R K)^(2/3) / R,    q = sign(g) q₀ max(0, 1 + a sign(g) g'/v₀)

the column's twist and Hertz's contact of both arms in series, with the damping a of a contact law
(`cardan.physics.dynamics.joint_backlash`) and v₀ the g' at touch. Gear and hand wheel get i q and
-i φ' q.
Sources: tyre and spin terms, Pacejka, Tire and Vehicle Dynamics (2012), ch. 6; clearance in the
column's joint after Lu et al. (2013). The arrangement is ours: the paper's data were not at
hand, and its figures are not compared; another program's integration of these equations is.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from math import atan2, cos, sin, tan
from typing import Any

import numpy as np

from cardan.core.arrays import ArrayLike, ComplexArray, FloatArray
from cardan.core.errors import ConvergenceError, DesignError
from cardan.physics.dynamics.floquet import eigenvalues
from cardan.physics.dynamics.joint_backlash import ContactDampingLaw, flores_damping_factor
from cardan.physics.dynamics.stability_chart import find_zeros
from cardan.physics.dynamics.torsional_line import output_angle_derivatives


@dataclass(frozen=True, slots=True, kw_only=True)
class Steering:
    """Wheels, tyres, axle and column; the values given shimmy at 65 km/h and 7 Hz.

    Attributes
    ----------
    kingpin_inertia, kingpin_damping : kg m², N m s/rad
        I and c of one wheel about its kingpin.
    tie_stiffness : N m/rad
        k_t, of the linkage to one wheel.
    spin_inertia, radius : kg m², m
        I_p of one wheel about its axle, and r.
    trail : m
        e, mechanical and pneumatic.
    cornering, relaxation : N/rad, m
        C_α and σ of one tyre.
    axle_inertia, axle_damping, axle_stiffness : kg m², N m s/rad, N m/rad
        In roll.
    gear_inertia, gear_damping : kg m², N m s/rad
        J_s and c_s, at the kingpin's ratio.
    hand_inertia, hand_damping, column_stiffness : kg m², N m s/rad, N m/rad
        J_h, c_h and k_c, at the kingpin's ratio.
    play : rad
        Half the play in the column's joint, at the column.
    ratio
        i, of column to kingpin.
    beta, pin : rad
        Angle of the column's joint, and u₀: where its driving pin stands with the wheels straight
        ahead, from the plane of its shafts.
    contact_radius, contact_stiffness : m, N/m^1.5
        R from the joint's centre to its contacts, and K of one, by Hertz.
    restitution, law
        e in (0, 1] and the contact law.
    """

    kingpin_inertia: float = 15.0
    kingpin_damping: float = 20.0
    tie_stiffness: float = 30e3
    spin_inertia: float = 14.0
    radius: float = 0.45
    trail: float = 0.03
    cornering: float = 80e3
    relaxation: float = 0.8
    axle_inertia: float = 120.0
    axle_damping: float = 1500.0
    axle_stiffness: float = 300e3
    gear_inertia: float = 5.0
    gear_damping: float = 100.0
    hand_inertia: float = 12.0
    hand_damping: float = 300.0
    column_stiffness: float = 15e3
    play: float = 0.0
    ratio: float = 18.0
    beta: float = 0.0
    pin: float = 0.0
    contact_radius: float = 0.02
    contact_stiffness: float = 2e9
    restitution: float = 0.7
    law: ContactDampingLaw = flores_damping_factor

    def __post_init__(self) -> None:
        if not (self.play >= 0 and 0 < self.restitution <= 1 and self.ratio > 0):
            msg = (
                "a steering needs play of 0 or more, a restitution in (0, 1] and a ratio above 0, "
                f"got {self.play:g}, {self.restitution:g} and {self.ratio:g}"
            )
            raise DesignError(msg)

    def gap(self, z: FloatArray) -> tuple[float, float, float]:
        """Return g rad, g' rad/s and φ' of a state (12,), at the column."""
        # `torsion.output_angle_derivatives` of one number: this is called a million times.
        r = tan(self.beta / 2) ** 2
        turned = self.ratio * float(z[4])
        u, u0 = 2 * (turned + self.pin), 2 * self.pin
        phi = atan2(r * sin(u), 1 - r * cos(u)) - atan2(r * sin(u0), 1 - r * cos(u0))
        gain = (1 - r * r) / (1 - 2 * r * cos(u) + r * r)
        closing = self.ratio * (gain * float(z[9]) - float(z[8]))
        return turned + phi - self.ratio * float(z[3]), closing, gain

    def column_torque(self, gap: float, closing: float, *, side: int, arrived: float) -> float:
        """Return q, N m at the column, in contact on a side: 1 where the hand wheel leads.

        `gap`, `closing` rad, rad/s as `gap` has them; `arrived` rad/s at touch, 0 without damping.
        """
        deep = side * gap - self.play
        if deep <= 0:
            return 0.0
        # deep = both/k p³ + p²/R with p² how far the contact sinks, and both p³ its torque.
        both = 2 * self.contact_radius * self.contact_stiffness
        soft = both * self.ratio**2 / self.column_stiffness
        p = min((deep * self.contact_radius) ** 0.5, (deep / soft) ** (1 / 3))
        for _ in range(50):
            step = (soft * p**3 + p**2 / self.contact_radius - deep) / (
                3 * soft * p**2 + 2 * p / self.contact_radius
            )
            p -= step
            if abs(step) < 1e-15 * p:
                break
        a = self.law(self.restitution)
        damped = 1.0 + (a * side * closing / arrived if arrived > 0 else 0.0)
        return side * both * p**3 * max(damped, 0.0)

    def state_matrix(self, speed: ArrayLike) -> FloatArray:
        """Matrix (..., 12, 12) of z' = A z at a road speed m/s, play closed.

        z: δ_L, δ_R, φ, s, h, their rates, and the two tyre forces.
        """
        V = np.asarray(speed, dtype=float)
        A = np.zeros((*V.shape, 12, 12))
        A[..., range(5), range(5, 10)] = 1.0
        spin = self.spin_inertia * V / self.radius
        for wheel, force in ((0, 10), (1, 11)):
            A[..., 5 + wheel, wheel] = -self.tie_stiffness / self.kingpin_inertia
            A[..., 5 + wheel, 3] = self.tie_stiffness / self.kingpin_inertia
            A[..., 5 + wheel, 5 + wheel] = -self.kingpin_damping / self.kingpin_inertia
            A[..., 5 + wheel, 7] = -spin / self.kingpin_inertia
            A[..., 5 + wheel, force] = -self.trail / self.kingpin_inertia
            A[..., 7, 5 + wheel] = spin / self.axle_inertia
            A[..., 8, wheel] = self.tie_stiffness / self.gear_inertia
            A[..., force, wheel] = self.cornering * V / self.relaxation
            A[..., force, 5 + wheel] = self.cornering * self.trail / self.relaxation
            A[..., force, 7] = self.cornering * self.radius / self.relaxation
            A[..., force, force] = -V / self.relaxation
            A[..., 7, force] = -self.radius / self.axle_inertia
        A[..., 7, 2] = -self.axle_stiffness / self.axle_inertia
        A[..., 7, 7] = -self.axle_damping / self.axle_inertia
        A[..., 8, 3] = -(2 * self.tie_stiffness + self.column_stiffness) / self.gear_inertia
        # Of small motions the joint makes a gear.
        gain = float(output_angle_derivatives(self.pin, beta=self.beta)[1])
        A[..., 8, 4] = gain * self.column_stiffness / self.gear_inertia
        A[..., 8, 8] = -self.gear_damping / self.gear_inertia
        A[..., 9, 4] = -(gain**2) * self.column_stiffness / self.hand_inertia
        A[..., 9, 3] = gain * self.column_stiffness / self.hand_inertia
        A[..., 9, 9] = -self.hand_damping / self.hand_inertia
        return A

    def exponents(self, speed: ArrayLike) -> ComplexArray:
        """Exponents (..., 12) 1/s of small motions, play closed."""
        return eigenvalues(self.state_matrix(speed))

    def growth_rate(self, speed: ArrayLike) -> FloatArray:
        """Fastest growth (...) 1/s at a road speed m/s; above 0 the wheels shimmy."""
        values = self.exponents(speed)
        # The steering as a whole runs free only by its tyres: no rigid motion to exclude.
        return values.real.max(-1)

    def onset_speeds(self, *, between: tuple[float, float] = (1.0, 60.0)) -> FloatArray:
        """Road speeds (crossings,) m/s at which shimmy begins or ends, rising."""
        return find_zeros(self.growth_rate, between=between, start=600)


@dataclass(frozen=True, slots=True, kw_only=True)
class ShimmyHistory:
    """The motion of a steering in time.

    Attributes
    ----------
    time : (samples,) s
    state : (samples, 12)
        As `Steering.rates` orders it.
    impact_speeds, impact_times : (touches,) rad/s, s
        Speed of closing, at the column, of every contact that began, and when.
    """

    time: FloatArray
    state: FloatArray
    impact_speeds: FloatArray
    impact_times: FloatArray

    def swing_amplitude(self, last: float) -> float:
        """Largest angle of the left wheel, rad, in the last so many seconds."""
        return float(np.abs(self.state[self.time > self.time[-1] - last, 0]).max())

    def frequency(self, last: float) -> float:
        """Frequency, Hz, of the left wheel's swings in the last so many seconds: by its zeros."""
        late = self.time > self.time[-1] - last
        t, z = self.time[late], self.state[late, 0]
        up = np.flatnonzero((z[:-1] <= 0) & (z[1:] > 0))
        at = t[up] - z[up] * (t[up + 1] - t[up]) / (z[up + 1] - z[up])
        return float((at.size - 1) / (at[-1] - at[0])) if at.size > 1 else 0.0


def simulate_shimmy(
    steering: Steering,
    *,
    speed: float,
    duration: float,
    kick: float = 0.01,
    samples: int = 4000,
    most: int = 20000,
) -> ShimmyHistory:
    """Integrate the motion after the left wheel is turned by `kick` rad, with play in the column.

    Flight and contact each by their own equation, from one touch to the next.

    Parameters
    ----------
    speed : m/s
    duration : s
    samples
        Equal instants to return.
    most
        Changes of state after which it gives up.

    Raises
    ------
    ConvergenceError
        If there are more changes of state: chattering contacts, or too long a duration.

    Notes
    -----
    The tyres are linear: amplitudes above their onset of sliding (some 5 deg) mean no
    more than "it shimmies".
    """
    from scipy.integrate import solve_ivp

    integrate: Callable[..., Any] = solve_ivp  # its stubs know no events with attributes
    loose = replace(steering, column_stiffness=0.0).state_matrix(speed)

    def rate(_: float, z: FloatArray, side: int, arrived: float) -> FloatArray:
        out = loose @ z
        if side:
            gap, closing, gain = steering.gap(z)
            q = steering.column_torque(gap, closing, side=side, arrived=arrived)
            out[8] += steering.ratio * q / steering.gear_inertia
            out[9] -= steering.ratio * gain * q / steering.hand_inertia
        return out

    def event(side: int, direction: int) -> Callable[..., float]:
        def passed(_: float, z: FloatArray, *_more: object) -> float:
            return side * steering.gap(z)[0] - steering.play

        passed.terminal, passed.direction = True, direction  # type: ignore[attr-defined]
        return passed

    z = np.zeros(12)
    z[0] = kick
    t, side, arrived = 0.0, 0, 0.0
    if steering.play == 0:
        side = 1
    touches: list[tuple[float, float]] = []
    times = np.linspace(0, duration, samples)
    state = np.empty((samples, 12))
    for _ in range(most):
        events = [event(side, -1)] if side else [event(1, 1), event(-1, 1)]
        done = integrate(
            rate, (t, duration), z, args=(side, arrived), events=events, method="DOP853",
            rtol=1e-9, atol=1e-13, dense_output=True,
        )  # fmt: skip
        inside = (times >= t) & (times <= done.t[-1])
        if inside.any():
            state[inside] = done.sol(times[inside]).T
        t, z = float(done.t[-1]), done.y[:, -1].copy()
        if done.status == 0:
            touched = np.array(touches, dtype=float).reshape(-1, 2)
            return ShimmyHistory(
                time=times, state=state, impact_speeds=touched[:, 1], impact_times=touched[:, 0]
            )
        if side and steering.play > 0:
            side = 0
            continue
        # Out of contact without room to fly, the other flank takes over.
        side = -side if side else 1 if done.t_events[0].size else -1
        arrived = abs(steering.gap(z)[1])
        touches.append((t, arrived))
    msg = f"more than {most} changes of state before {duration:g} s: the contacts chatter"
    raise ConvergenceError(msg)
