r"""Running up and running down through a resonance: how high it gets, or whether it sticks.

`swept_response` is exact for an oscillator under an excitation whose frequency rises or
falls steadily; `limited_power_run_up` lets the motor decide the speed, and `run_up_outcomes`
says from every starting angle whether it gets through. Sources: Lewis, Trans. ASME
54 (1932) 253-261; Mazzei, passage through resonance in a universal joint driveline (2011);
capture is Sommerfeld's effect (1902). Numbers of the models are compared, the papers'
figures were not at hand.
"""

from dataclasses import dataclass
from math import atan2, cos, sin, tan
from typing import Literal, TypeAlias

import numpy as np

from cardan.core.arrays import ArrayLike, ComplexArray, FloatArray
from cardan.core.errors import ConvergenceError


def swept_response(
    time: ArrayLike, *, rate: ArrayLike, damping_ratio: ArrayLike = 0.0, start: ArrayLike = 0.0
) -> ComplexArray:
    r"""Response of x'' + 2 ζ x' + x = exp(i (start t + rate t²/2)), settled at the start; exact.

    Parameters
    ----------
    time : (...) 1
        Time times the natural frequency. Parameters broadcast against it.
    rate : (...) 1
        Rate of the excitation's frequency over the natural frequency squared; negative in
        run-down, not 0.
    damping_ratio : (...) 1
        ζ, below 1.
    start : (...) 1
        Frequency at time 0, over the natural frequency.

    Returns
    -------
    (...) complex
        Its real part answers cos, its imaginary part sin; at time 0 it is the steady
        vibration at the starting frequency, from standstill the static deflection 1. Its
        absolute value is the envelope.

    Notes
    -----
    Duhamel's integral in closed form, with the Faddeeva function (Lewis 1932).
    """
    from scipy.special import wofz

    t, mu, zeta, w0 = np.broadcast_arrays(
        *(np.asarray(v, dtype=float) for v in (time, rate, damping_ratio, start))
    )
    pole = -zeta + 1j * np.sqrt(1 - zeta**2)

    def convolved(p: ComplexArray) -> ComplexArray:
        """∫ exp(p (t - s)) exp(i (w0 s + mu s²/2)) ds over 0..t."""
        # The exponent is -(c s + b)² + b² + p t with c² = -i mu/2: a difference of two
        # error functions, each written as a w(z) that cannot overflow.
        c = np.sqrt(-0.5j * mu + 0j)
        b = (p - 1j * w0) / (2 * c)
        ends = ((0.0, p * t), (t, 1j * (w0 * t + mu * t**2 / 2)))
        values = []
        for s, grown in ends:
            z = c * s + b
            # exp(b² + p t) erfc(z) = exp(grown) w(i z); for Re z < 0 use erfc(z) = 2 - erfc(-z).
            mirrored = z.real < 0
            values.append(
                np.exp(grown) * wofz(1j * np.where(mirrored, -z, z)) * np.where(mirrored, -1, 1)
            )
            values.append(np.where(mirrored, 2.0, 0.0))
        whole = values[1] - values[3]
        swing = np.where(whole != 0, np.exp(np.where(whole != 0, b**2 + p * t, 0)) * whole, 0)
        return np.sqrt(np.pi) / (2 * c) * (values[0] - values[2] + swing)

    forced = (convolved(pole) - convolved(pole.conj())) / (2j * pole.imag)
    steady = 1 / (1 - w0**2 + 2j * zeta * w0)
    own = [(1j * w0 - root) * np.exp(other * t) for root, other in
           ((pole.conj(), pole), (pole, pole.conj()))]  # fmt: skip
    return forced + steady * (own[0] - own[1]) / (2j * pole.imag)


@dataclass(frozen=True, slots=True, kw_only=True)
class ResonancePassage:
    """The largest amplitude of a passage through resonance, and when.

    `peak` is over the static deflection, of the envelope; `frequency` is the excitation's
    at that time, over the natural frequency; `dwell` is how long the envelope stays above
    half the peak until the sweep ends, in time times the natural frequency.
    """

    peak: FloatArray
    frequency: FloatArray
    dwell: FloatArray


def resonance_passage(
    *, rate: ArrayLike, damping_ratio: ArrayLike = 0.0, start: float = 0.0
) -> ResonancePassage:
    """Peak and dwell (...) of a steady sweep from a starting frequency over the resonance.

    Parameters
    ----------
    rate : (...) 1
        Size of the sweep rate, as for `swept_response`; broadcasts against `damping_ratio`.
    start : 1
        Frequency to start from, over the natural one. Below 1 the sweep rises to 2, above
        1 it runs down to standstill.
    """
    mu, zeta = np.broadcast_arrays(np.asarray(rate, float), np.asarray(damping_ratio, float))
    span = 2.0 - start if start < 1 else -start
    end = abs(span) / mu
    slope = np.sign(span) * mu[..., None]

    def envelope(t: FloatArray) -> FloatArray:
        return np.abs(swept_response(t, rate=slope, damping_ratio=zeta[..., None], start=start))

    # The envelope beats no faster than half the natural frequency: eight points a radian.
    share = np.linspace(0, 1, max(4000, int(8 * float(np.max(end)))))
    t = end[..., None] * share
    size = envelope(t)
    when = np.take_along_axis(t, size.argmax(-1)[..., None], -1)
    reach = t[..., 1:2]
    for _ in range(10):
        fine = np.clip(when + reach * np.linspace(-1, 1, 17), 0, end[..., None])
        best = envelope(fine).argmax(-1)[..., None]
        when, reach = np.take_along_axis(fine, best, -1), reach / 8
    peak = envelope(when)[..., 0]
    return ResonancePassage(
        peak=peak,
        frequency=start + slope[..., 0] * when[..., 0],
        dwell=(size > peak[..., None] / 2).mean(-1) * end,
    )


# ----- a motor of limited power -----------------------------------------------------------


@dataclass(frozen=True, slots=True, kw_only=True)
class MotorDrivenShaft:
    """A motor, a joint and a flywheel on a shaft: the smallest line that can be captured.

    Attributes
    ----------
    power : W
        Of the motor, constant; its torque is limited to `stall_torque` near standstill.
    stall_torque : N m
        Largest torque of the motor.
    motor, wheel : kg m²
        Inertia ahead of the joint and at the end of the shaft behind it.
    stiffness, damping : N m/rad, N m s/rad
        Of the shaft between joint and wheel.
    drag : N m s/rad
        Viscous load on the wheel.
    beta : rad
        Joint angle.
    """

    power: float
    stall_torque: float
    motor: float
    wheel: float
    stiffness: float
    damping: float
    drag: float
    beta: float

    @property
    def frequency(self) -> float:
        """First torsional frequency of motor against wheel, rad/s; half of it is the trap."""
        return float(np.sqrt(self.stiffness * (1 / self.motor + 1 / self.wheel)))

    @property
    def top_speed(self) -> float:
        """Speed at which drag takes all the power: √(P / drag), rad/s."""
        return float(np.sqrt(self.power / self.drag))


@dataclass(frozen=True, slots=True, kw_only=True)
class RunUpHistory:
    """A run-up in time: instants s, speed of motor and wheel rad/s, shaft torque N m.

    `mean_speed` is the mean of the motor's speed over the last tenth.
    """

    time: FloatArray
    motor_speed: FloatArray
    wheel_speed: FloatArray
    torque: FloatArray

    @property
    def mean_speed(self) -> float:
        """Speed the line has come to, rad/s."""
        return float(self.motor_speed[-self.time.size // 10 :].mean())


def limited_power_run_up(
    line: MotorDrivenShaft,
    *,
    duration: float,
    start_speed: float = 1.0,
    start_angle: float = 0.0,
    samples: int = 4000,
) -> RunUpHistory:
    """Integrate a run-up on limited power for `duration` s from `start_speed` rad/s.

    At half the torsional frequency the joint pumps the motor's power into vibration:
    with too little of it the speed sticks there (Sommerfeld's effect). With more it may
    stick at the frequency itself, where the joint shakes it up parametrically; whether it
    does depends on the `start_angle` rad of the driving yoke, so use `run_up_outcomes`.
    """
    from scipy.integrate import solve_ivp

    from cardan.physics.dynamics.torsional_line import output_angle_derivatives

    r = tan(line.beta / 2) ** 2

    def rate(_: float, state: FloatArray) -> list[float]:
        # As `output_angle_derivatives`, with the plain numbers that are ten times as fast one by
        # one.
        theta, psi, w1, w2 = state.tolist()
        along, across = r * cos(2 * theta), r * sin(2 * theta)
        phi = theta + atan2(across, 1 - along)
        gain = (1 - r**2) / (1 - 2 * along + r**2)
        torque = line.stiffness * (phi - psi) + line.damping * (gain * w1 - w2)
        motor = min(line.stall_torque, line.power / max(w1, 1e-9))
        return [
            w1, w2, (motor - gain * torque) / line.motor, (torque - line.drag * w2) / line.wheel
        ]  # fmt: skip

    times = np.linspace(0, duration, samples)
    done = solve_ivp(
        rate, (0, duration), [start_angle, _untwisted(line, start_angle), start_speed, start_speed],
        method="DOP853",
        t_eval=times, rtol=1e-8, atol=1e-9,
    )  # fmt: skip
    theta, psi, w1, w2 = done.y
    phi, gain, *_ = output_angle_derivatives(theta, beta=line.beta)
    return RunUpHistory(
        time=times, motor_speed=w1, wheel_speed=w2,
        torque=line.stiffness * (phi - psi) + line.damping * (gain * w1 - w2),
    )  # fmt: skip


def _untwisted(line: MotorDrivenShaft, angle: float) -> float:
    """Return where the wheel stands when the shaft carries nothing."""
    from cardan.physics.dynamics.torsional_line import output_angle_derivatives

    return float(output_angle_derivatives(angle, beta=line.beta)[0])


RunUpOutcome: TypeAlias = Literal["caught at half", "caught", "through"]
"""What becomes of a run-up: stuck at half the torsional frequency, at it, or at its top speed."""

STEPS_PER_BLOCK = 64
"""Steps of one length, a period and a half of what is fastest: the speed hardly changes."""

CAPTURE_TOLERANCE_SHARE_OF_FREQUENCY = 0.04
"""A mean speed is at a frequency within this share: what is caught swings about it."""


@dataclass(frozen=True, slots=True, kw_only=True)
class RunUpOutcomes:
    """What becomes of run-ups from equally spaced positions of the driving yoke.

    Attributes
    ----------
    angle : (phases,) rad
        Where the driving yoke started, over the half turn after which the joint repeats.
    mean_speed : (phases,) rad/s
        Of the motor, over the last tenth of the time; where all are well through before,
        when they are.
    outcomes : (phases,)
    """

    angle: FloatArray
    mean_speed: FloatArray
    outcomes: tuple[RunUpOutcome, ...]

    @property
    def worst(self) -> RunUpOutcome:
        """The worst of them: caught at half, then caught."""
        order: tuple[RunUpOutcome, ...] = ("caught at half", "caught", "through")
        return min(self.outcomes, key=order.index)

    def count(self, fate: RunUpOutcome) -> int:
        """How many of the starting angles end so."""
        return self.outcomes.count(fate)

    def __str__(self) -> str:
        """Return the verdict as people say it: caught, 7 of 8."""
        return f"{self.worst}, {self.count(self.worst)} of {len(self.outcomes)}"


def run_up_outcomes(
    line: MotorDrivenShaft, *, duration: float = 40.0, phases: int = 8, start_speed: float = 1.0
) -> RunUpOutcomes:
    """Run a line up from every starting angle, and say whether it gets through.

    Parameters
    ----------
    line
        One line, single values.
    duration : s
        Long enough to come to its top speed: a few times J ω²/2 over the power.
    phases
        Starting angles over half a turn.
    start_speed : rad/s

    Notes
    -----
    Steps of the classical Runge-Kutta method, forty to a period of the joint at the speed
    reached or of the torsional mode, whichever is shorter; all angles together.
    """
    angle = np.pi * np.arange(phases) / phases
    cosine = np.cos(line.beta)
    less = 1 - cosine

    def rate(state: FloatArray) -> FloatArray:
        theta, psi, w1, w2 = state
        s, c = np.sin(theta), np.cos(theta)
        below = 1 - (1 - cosine**2) * c * c
        phi = theta + np.arctan(s * c * less / (cosine * c * c + s * s))
        gain = cosine / below
        torque = line.stiffness * (phi - psi) + line.damping * (gain * w1 - w2)
        motor = np.minimum(line.stall_torque, line.power / np.maximum(w1, 1e-9))
        return np.stack([
            w1, w2, (motor - gain * torque) / line.motor, (torque - line.drag * w2) / line.wheel
        ])  # fmt: skip

    begun = np.array([_untwisted(line, float(a)) for a in angle])
    state = np.stack([angle, begun, np.full(phases, start_speed), np.full(phases, start_speed)])
    then, late = state, 0.9 * duration
    for begins, ends in ((0.0, late), (late, duration)):
        time, then = begins, state
        while time < ends:
            if state[2].min() > (1 + 4 * CAPTURE_TOLERANCE_SHARE_OF_FREQUENCY) * line.frequency:
                return RunUpOutcomes(
                    angle=angle, mean_speed=state[2], outcomes=("through",) * phases
                )
            fastest = max(2 * float(state[2].max()), line.frequency)
            left = int(np.ceil((ends - time) * 40 * fastest / (2 * np.pi)))
            h, steps = (ends - time) / left, min(left, STEPS_PER_BLOCK)
            for _ in range(steps):
                k1 = rate(state)
                k2 = rate(state + h / 2 * k1)
                k3 = rate(state + h / 2 * k2)
                k4 = rate(state + h * k3)
                state = state + h / 6 * (k1 + 2 * (k2 + k3) + k4)
            time = ends if steps == left else time + steps * h
    mean = (state[0] - then[0]) / (duration - late)
    return RunUpOutcomes(
        angle=angle, mean_speed=mean, outcomes=tuple(_fate(line, float(v)) for v in mean)
    )


def _fate(line: MotorDrivenShaft, mean: float) -> RunUpOutcome:
    """Return what a mean speed at the end says."""
    if mean > min(
        (1 - CAPTURE_TOLERANCE_SHARE_OF_FREQUENCY) * line.top_speed,
        (1 + CAPTURE_TOLERANCE_SHARE_OF_FREQUENCY) * line.frequency,
    ):
        return "through"
    if abs(mean / (line.frequency / 2) - 1) < CAPTURE_TOLERANCE_SHARE_OF_FREQUENCY:
        return "caught at half"
    if abs(mean / line.frequency - 1) < CAPTURE_TOLERANCE_SHARE_OF_FREQUENCY:
        return "caught"
    msg = (
        f"the line runs at {mean:.4g} rad/s at the end, still below its torsional frequency of "
        f"{line.frequency:.4g} rad/s but not at half of it: give it a longer duration"
    )
    raise ConvergenceError(msg)
