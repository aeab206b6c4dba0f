"""One Hooke joint: position, speed, acceleration, torque, and how its cross moves.

Books start the turn at either of two places: with the driving pin axis in the plane of the
two shafts, or normal to it. Mixing them up swaps cos²θ for sin²θ, so every function of θ
says where it starts by `pin`, the angle of the pin axis from the plane at θ = 0:

    IN_PLANE   Seherr-Thoss, Omar's notes, and the default here
    NORMAL     exercise E2, Souza (after Wagner)

Massless, rigid, no clearance.
"""

from collections.abc import Callable
from math import pi
from typing import Any

from cardan.core.arrays import ArrayLike, FloatArray, array_library_and_floats
from cardan.core.lazy_dataclass import dataclass
from cardan.core.units import Radian

PIN_IN_PLANE: Radian = 0.0
"""θ = 0 where the driving pin axis lies in the plane of the two shafts."""

PIN_NORMAL_TO_PLANE: Radian = pi / 2
"""θ = 0 where the driving pin axis is normal to the plane of the two shafts."""

BISECTION_STEPS = 60
"""Halvings of the range of joint angles; what is left of it is below 2e-18 rad."""


def angle_lead(theta: ArrayLike, *, beta: ArrayLike, pin: Radian = PIN_IN_PLANE) -> FloatArray:
    r"""Output angle less input angle of one Hooke joint.

    $$\varphi - \theta = \sum_{n \ge 1} \frac{r^n}{n} \sin 2n\theta
      = \arctan\frac{(1 - \cos\beta)\sin\theta\cos\theta}{\cos\beta\cos^2\theta + \sin^2\theta},
      \quad r = \tan^2\frac{\beta}{2}, \quad \tan\varphi = \frac{\tan\theta}{\cos\beta}$$

    Parameters
    ----------
    theta : (...) rad
        Input angle; any number of turns.
    beta : (...) rad
        Joint angle, \|β\| < π/2; broadcasts against `theta`.
    pin : rad
        Where the pin axis stands at θ = 0: `PIN_IN_PLANE` (the equation's) or
        `PIN_NORMAL_TO_PLANE`.

    Returns
    -------
    (...) rad
        Continuous for ever, zero at every quarter of a turn from the plane.

    Raises
    ------
    ValueError
        If a joint angle reaches π/2, where the joint locks.

    Notes
    -----
    Source: Seherr-Thoss et al. (2006), ch. 1.

    Examples
    --------
    >>> import numpy as np
    >>> np.degrees(angle_lead(np.radians([45, 405]), beta=np.radians(30))).round(4)
    array([4.1066, 4.1066])
    """
    xp, beta, theta = _unlocked(beta, theta)
    sin, cos = xp.sin(theta + pin), xp.cos(theta + pin)
    flat = xp.cos(beta)
    return xp.atan2(2 * xp.sin(beta / 2) ** 2 * sin * cos, flat * cos**2 + sin**2)


def output_angle(theta: ArrayLike, *, beta: ArrayLike, pin: Radian = PIN_IN_PLANE) -> FloatArray:
    """Output angle (...) rad: input plus `angle_lead`, from where the output is at θ = 0."""
    _, theta = array_library_and_floats(theta, like=beta)
    return theta + angle_lead(theta, beta=beta, pin=pin)


def speed_ratio(theta: ArrayLike, *, beta: ArrayLike, pin: Radian = PIN_IN_PLANE) -> FloatArray:
    r"""Output speed over input speed of one Hooke joint.

    $$\frac{\omega_2}{\omega_1} = \frac{\cos\beta}{1 - \sin^2\beta\,\cos^2\theta}$$

    Parameters
    ----------
    theta, beta : (...) rad
        Input angle and joint angle; they broadcast.
    pin : rad
        `PIN_IN_PLANE` (the equation's) or `PIN_NORMAL_TO_PLANE` (sin² in place of cos²).

    Returns
    -------
    (...) 1
        Swings between cos β and 1/cos β twice a turn; its mean over a turn is 1.

    Raises
    ------
    ValueError
        If a joint angle reaches π/2, where the joint locks.

    Notes
    -----
    Source: Seherr-Thoss et al. (2006), ch. 1; normal: PME 2540, exercise E2, and Souza
    (2014), eq. 7.

    Examples
    --------
    >>> import numpy as np
    >>> speed_ratio(np.radians([0, 90]), beta=np.radians(60)).round(3)
    array([2. , 0.5])
    """
    xp, beta, theta = _unlocked(beta, theta)
    return xp.cos(beta) / (1 - (xp.sin(beta) * xp.cos(theta + pin)) ** 2)


def output_acceleration(
    theta: ArrayLike,
    *,
    beta: ArrayLike,
    speed: ArrayLike,
    input_acceleration: ArrayLike = 0.0,
    pin: Radian = PIN_IN_PLANE,
) -> FloatArray:
    r"""Angular acceleration of the driven shaft.

    $$\alpha_2 = -\omega_1^2\,\frac{\cos\beta\sin^2\beta\sin 2\theta}
      {(1 - \sin^2\beta\cos^2\theta)^2} + \frac{\omega_2}{\omega_1}\,\alpha_1$$

    Parameters
    ----------
    theta, beta : (...) rad
        Input angle and joint angle.
    speed : (...) rad/s
        Input speed ω₁.
    input_acceleration : (...) rad/s²
        Input acceleration α₁.
    pin : rad
        `PIN_IN_PLANE` (the equation's) or `PIN_NORMAL_TO_PLANE`.

    Returns
    -------
    (...) rad/s²

    Raises
    ------
    ValueError
        If a joint angle reaches π/2, where the joint locks.

    Notes
    -----
    Source: ITIS Omar, eq. 4; normal: Souza (2014), eq. 8. The second term is the chain rule.
    """
    xp, beta, theta, speed, gain = _unlocked(beta, theta, speed, input_acceleration)
    sin, cos = xp.sin(theta + pin), xp.cos(theta + pin)
    slope = 1 - (xp.sin(beta) * cos) ** 2
    swing = -2 * xp.cos(beta) * xp.sin(beta) ** 2 * sin * cos / slope**2
    return speed**2 * swing + xp.cos(beta) / slope * gain


def speed_range(beta: ArrayLike) -> tuple[FloatArray, FloatArray]:
    """Smallest and largest speed ratio, cos β and 1/cos β."""
    xp, beta = _unlocked(beta)
    return xp.cos(beta), 1 / xp.cos(beta)


def irregularity(beta: ArrayLike) -> FloatArray:
    """Swing of the speed ratio, I = 1/cos β - cos β = sin β tan β. Source: ITIS Omar."""
    xp, beta = _unlocked(beta)
    return xp.sin(beta) * xp.tan(beta)


def angle_for_irregularity(swing: ArrayLike) -> FloatArray:
    """Joint angle (...) rad whose `irregularity` is `swing`.

    With c = cos β, c² + I c = 1; and then tan² β = I/c, which is exact for small I too.
    """
    xp, swing = array_library_and_floats(swing)
    cos = 2 / (swing + xp.sqrt(swing**2 + 4))
    return xp.atan(xp.sqrt(swing / cos))


def angle_lead_amplitude(beta: ArrayLike) -> FloatArray:
    """Largest lead (...) rad, the torsional amplitude: sin(max lead) = tan²(β/2)."""
    xp, beta = _unlocked(beta)
    return xp.asin(xp.tan(beta / 2) ** 2)


def equal_speed_angles(beta: ArrayLike, *, pin: Radian = PIN_IN_PLANE) -> FloatArray:
    """Input angles (..., 4) rad at which both shafts run equally fast; the lead peaks there.

    tan θ = ±√cos β with the pin in the plane, ±1/√cos β with it normal. Rising, in [0, 2π).
    Source: ITIS Omar, eq. 3; Souza (2014), eq. 9.
    """
    xp, beta = _unlocked(beta)
    return _quadruple(xp, xp.atan(xp.sqrt(xp.cos(beta))), pin)


def max_acceleration(beta: ArrayLike) -> FloatArray:
    """Largest acceleration of the driven shaft over ω₁², (...) 1, at constant input speed.

    At cos 2θ = sin²β (2 - cos² 2θ) / (2 - sin²β), the quadratic solved exactly.
    `MAX_ACCELERATION_FORMULAS` has the approximations to it. Source: ITIS Omar, eq. 4 and 5.
    """
    return _acceleration_at(beta, _peak_cos)


def angle_for_max_acceleration(acceleration: ArrayLike) -> FloatArray:
    """Joint angle (...) rad whose `max_acceleration` is `acceleration` over ω₁², (...) 1.

    `max_acceleration` rises with the angle from 0 without bound, so bisection finds its inverse
    to rounding. `equivalent_angle.angle_for_acceleration` is the approximation ω² β².
    """
    xp, wanted = array_library_and_floats(acceleration)
    low, high = 0 * wanted, 0 * wanted + pi / 2 * (1 - 1e-12)
    for _ in range(BISECTION_STEPS):
        middle = (low + high) / 2
        less = max_acceleration(middle) < wanted
        low, high = xp.where(less, middle, low), xp.where(less, high, middle)
    return low


def max_acceleration_angles(beta: ArrayLike, *, pin: Radian = PIN_IN_PLANE) -> FloatArray:
    """Input angles (..., 4) rad of the largest |acceleration|; rising, in [0, 2π)."""
    xp, beta = _unlocked(beta)
    return _quadruple(xp, xp.acos(_peak_cos(xp, beta)) / 2, pin)


def _peak_cos(xp: Any, beta: Any) -> Any:
    """Cosine of 2θ at the largest acceleration: s² c² + (2 - s²) c - 2 s² = 0, s = sin β."""
    s2 = xp.sin(beta) ** 2
    return 4 * s2 / (2 - s2 + xp.sqrt((2 - s2) ** 2 + 8 * s2**2))


def _omar_cos(xp: Any, beta: Any) -> Any:
    """Cosine of 2θ by ITIS Omar, eq. 6, which drops its square; no angle from 54.7 deg on."""
    s2 = xp.sin(beta) ** 2
    return 2 * s2 / (2 - s2)


def _no_cos(_: Any, beta: Any) -> Any:
    """Cosine of 2θ = 0: the peak taken at 45 deg."""
    return 0 * beta


def _acceleration_at(beta: ArrayLike, cos_2theta: Callable[[Any, Any], Any]) -> FloatArray:
    """|Acceleration| over ω₁² where cos 2θ, pin in plane, is that of a function of β.

    nan where no angle has that cosine.
    """
    xp, beta = _unlocked(beta)
    s2, c = xp.sin(beta) ** 2, cos_2theta(xp, beta)
    c = xp.where(c <= 1, c, xp.nan)
    return xp.cos(beta) * s2 * xp.sqrt(1 - c**2) / (1 - s2 * (1 + c) / 2) ** 2


def _small(beta: ArrayLike) -> FloatArray:
    """β²: the acceleration of a small angle."""
    _, beta = array_library_and_floats(beta)
    return beta**2


MAX_ACCELERATION_FORMULAS: dict[str, Callable[[ArrayLike], FloatArray]] = {
    "exact": max_acceleration,
    "omar_eq6": lambda beta: _acceleration_at(beta, _omar_cos),
    "at_45_deg": lambda beta: _acceleration_at(beta, _no_cos),
    "small_angle": _small,
}
"""Largest acceleration over ω₁² by name: exact, and as the field approximates it.

`omar_eq6` and `at_45_deg` (ITIS Omar) evaluate the exact curve next to its peak, so they
never exceed it; `small_angle` is AE-7's ω² β².
"""


@dataclass(frozen=True, slots=True, kw_only=True)
class CrossMotion:
    """How a cross moves in its two yokes: what its needle bearings do. All (...).

    Attributes
    ----------
    driving_angle, driven_angle : rad
        Angle of the cross in the driving yoke, about the driving pin axis a, and in the
        driven yoke, about the driven pin axis b. Both swing between -β and β once a turn.
        The first is exercise E2's γ, the angle of b over the plane normal to the driving
        shaft.
    driving_rate, driven_rate : rad/s
        Their rates: E2's ω_r2 and ω_r1. The cross turns with ω_r2 a + ω₁ d₁ = ω_r1 b + ω₂ d₂.
    """

    driving_angle: FloatArray
    driven_angle: FloatArray
    driving_rate: FloatArray
    driven_rate: FloatArray


def cross_motion(
    theta: ArrayLike, *, beta: ArrayLike, speed: ArrayLike, pin: Radian = PIN_IN_PLANE
) -> CrossMotion:
    """Motion of the cross in its yokes.

    With θ from the pin normal to the plane, tan γ = tan β cos θ, ω_r2 = -ω₂ sin β sin θ and
    ω_r1 = ω₂ sin β cos θ / cos γ.

    Parameters
    ----------
    theta, beta : (...) rad
        Input angle and joint angle.
    speed : (...) rad/s
        Input speed.
    pin : rad
        `PIN_IN_PLANE` or `PIN_NORMAL_TO_PLANE` (the equation's).

    Raises
    ------
    ValueError
        If a joint angle reaches π/2, where the joint locks.

    Notes
    -----
    a, b = (d₂ x a)/|d₂ x a| and the rates are right-handed about the members pointing from
    input to output. Source: PME 2540, exercise E2.
    """
    xp, beta, theta, speed = _unlocked(beta, theta, speed)
    theta = theta + (pin - PIN_NORMAL_TO_PLANE)
    sin, cos = xp.sin(beta) * xp.sin(theta), xp.sin(beta) * xp.cos(theta)
    driven = speed * speed_ratio(theta, beta=beta, pin=PIN_NORMAL_TO_PLANE)
    return CrossMotion(
        driving_angle=xp.atan(xp.tan(beta) * xp.cos(theta)),
        driven_angle=xp.asin(sin),
        driving_rate=-driven * sin,
        driven_rate=driven * cos * xp.sqrt(1 + (cos / xp.cos(beta)) ** 2),
    )


def _quadruple(xp: Any, first: Any, pin: Radian) -> Any:
    """Return the four angles of a turn (..., 4) that mirror `first`, counted from `pin`."""
    angles = xp.stack([first, pi - first, pi + first, 2 * pi - first], axis=-1)
    return xp.sort((angles - pin) % (2 * pi), axis=-1)


def _unlocked(beta: ArrayLike, *more: ArrayLike) -> tuple[Any, *tuple[FloatArray, ...]]:
    """Return the array library and the arguments, the joint angle held below π/2."""
    xp, *arrays = array_library_and_floats(beta, *more)
    if not bool(xp.all(xp.abs(arrays[0]) < pi / 2)):
        msg = "a joint angle must stay below 90 deg, where the joint locks"
        raise ValueError(msg)
    return xp, *arrays
