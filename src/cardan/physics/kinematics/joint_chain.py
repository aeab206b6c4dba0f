"""A chain of joints, exactly: any number, any layout, any yoke phase.

A member's direction is one complex number, its slope, and the bend at a joint is the slope
behind it less the slope before it, on the sphere:

    S = (dy - i dz)/(1 + dx),    D = (S' - S)/(1 + S̄ S') = tan(β/2) e^{iφ}

with φ the position of the joint's plane. Across a member a pin axis is a complex number
too, w, and tan φ₂ = tan θ / cos β makes of the driving pin, up to its length,

    w' = w - D̄² w̄

Whatever a chain of such steps does to w = e^{iθ}, it is A e^{iθ} + B e^{-iθ}: every member
turns as if one single joint drove it. E = -conj(B/A), its phasor, says of how large an angle,
tan²(β/2) = |E|, and where in the turn. Joint by joint phasors add up, this time as in the
hyperbolic plane,

    E' = (E + s D²)/(1 + Ē s D²)

with s from the yoke phases. At small angles both denominators are 1, and what is left is
AE-7's sum of squares of the changes in slope. A joint of constant velocity adds nothing, and
carries the driving member's axes across by the shortest turn: the next joint meets its yoke
a quarter turn earlier than behind a cross. With x = E e^{2iθ} a member has over a turn

    lead -arg(1 - x),    speed Re (1 + x)/(1 - x),    acceleration -4 Im x/(1 - x)²

so there is nothing to unwrap, to integrate or to differentiate.
Source: derived from first principles; confirmed with an independent multibody engine.
"""

from collections.abc import Sequence
from functools import cache, cached_property
from typing import Any

import numpy as np

from cardan.core.arrays import (
    ArrayLike,
    ComplexArray,
    FloatArray,
    array_library_and_floats,
    array_namespace,
    first_axis_last,
)
from cardan.core.errors import DesignError
from cardan.core.lazy_dataclass import dataclass

SAMPLES_PER_TURN = 64
"""Angles in a turn: orders up to 32, exact to rounding for joint angles up to 40 degrees."""

_X, _Y_IZ = np.array([1.0, 0, 0]), np.array([0, 1, -1j])


def cross_product(a: Any, b: Any) -> Any:
    """Return the cross product over the last axis; quicker than NumPy's own for this."""
    xp = array_namespace(a, b)
    ax, ay, az = a[..., 0], a[..., 1], a[..., 2]
    bx, by, bz = b[..., 0], b[..., 1], b[..., 2]
    return first_axis_last(xp.stack([ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx]))


def dot_product(a: Any, b: Any) -> Any:
    """Return the scalar product over the last axis; quicker than NumPy's own for this."""
    return a[..., 0] * b[..., 0] + a[..., 1] * b[..., 1] + a[..., 2] * b[..., 2]


def joint_angles(directions: ArrayLike) -> FloatArray:
    """Return the true joint angles (..., n) rad between neighbouring members (..., n+1, 3).

    Exact and well conditioned at every angle: atan2(|u x v|, u . v).
    """
    xp, d = array_library_and_floats(directions)
    u, v = d[..., :-1, :], d[..., 1:, :]
    normal = cross_product(u, v)
    return xp.atan2(xp.sqrt(dot_product(normal, normal)), dot_product(u, v))


@dataclass(frozen=True)
class ChainRotation:
    """One turn of a chain: what every member does, and each pin axis.

    Leading axes are cases, then comes the joint (or the member behind it), then the angle.
    Stored is what the layout decides; the motion at N equally spaced angles follows from it.

    Attributes
    ----------
    directions : (..., n+1, 3) 1
        Unit vectors of the members.
    phasors : (..., n) 1, complex
        E of each member: it turns as one joint of angle β would drive it, tan²(β/2) = |E|.
    initial_pins : (..., n) 1, complex
        Where the driving pin axis of each joint stands at θ = 0, but for the lead.
    samples
        The number N of angles.
    crosses : (n,)
        1 where a joint is a cross, 0 where it keeps the speed.
    """

    directions: FloatArray
    phasors: ComplexArray
    initial_pins: ComplexArray
    samples: int
    crosses: tuple[float, ...]

    @cached_property
    def theta(self) -> FloatArray:
        """Rotation of the gearbox yoke, (N,) rad, zero where its pin axis is horizontal."""
        return array_namespace(self.phasors).asarray(_around(self.samples)[0])

    @cached_property
    def _circle(self) -> ComplexArray:
        """Return e^{iθ}, (N,)."""
        return array_namespace(self.phasors).asarray(_around(self.samples)[1])

    @cached_property
    def waves(self) -> ComplexArray:
        """Return x = E e^{2iθ} of each member, (..., n, N)."""
        return self.phasors[..., None] * self._circle**2

    @cached_property
    def _gain(self) -> ComplexArray:
        """Return 1/(1 - x), (..., n, N)."""
        return 1 / (1 - self.waves)

    @cached_property
    def lead(self) -> FloatArray:
        """Rotation of each member less that of the gearbox, (..., n, N) rad; mean zero."""
        xp = array_namespace(self.phasors)
        return xp.atan2(xp.imag(self._gain), xp.real(self._gain))

    @cached_property
    def speed(self) -> FloatArray:
        """Speed of each member over the gearbox's, (..., n, N)."""
        return 2 * array_namespace(self.phasors).real(self._gain) - 1

    @cached_property
    def acceleration(self) -> FloatArray:
        """Acceleration of each member over ω² of the gearbox turning uniformly, (..., n, N)."""
        return -4 * array_namespace(self.phasors).imag(self.waves * self._gain**2)

    @cached_property
    def coast_acceleration(self) -> FloatArray:
        """Acceleration of each member over ω² of the pinion turning uniformly, (..., n, N).

        At the same angles of the gearbox.
        """
        w, a = self.speed, self.acceleration
        last, gain = w[..., -1:, :], a[..., -1:, :]
        return (a * last - w * gain) / last**3

    @cached_property
    def pins(self) -> ComplexArray:
        """Driving pin axis of each joint across its driving member, (..., n, N) complex."""
        xp = array_namespace(self.phasors)
        leads = self._gain[..., :-1, :] / xp.abs(self._gain[..., :-1, :])
        leads = xp.concat([xp.ones_like(self._gain[..., :1, :]), leads], axis=-2)
        return self.initial_pins[..., None] * self._circle * leads

    @cached_property
    def frames(self) -> ComplexArray:
        """Frame of the complex numbers across each driving member, (..., n, 3) complex.

        u - iv of its two axes: y - iz as the shortest way from x to the member carries it.
        """
        xp, d = array_library_and_floats(self.directions[..., :-1, :])
        return xp.asarray(_Y_IZ) - _slopes(d)[..., None] * (xp.asarray(_X) + d)

    @cached_property
    def driving_pins(self) -> FloatArray:
        """Unit vectors along the driving pin axis of each joint, (..., n, N, 3)."""
        return array_namespace(self.phasors).real(self.pins[..., None] * self.frames[..., None, :])


def rotate_chain(
    directions: ArrayLike,
    *,
    phases: ArrayLike,
    crosses: Sequence[float] = (),
    samples: int = SAMPLES_PER_TURN,
) -> ChainRotation:
    """Turn a chain once, exactly.

    Parameters
    ----------
    directions : (..., n+1, 3) 1
        Unit vectors of the members, gearbox first, pinion last. The gearbox must not point
        straight up or down.
    phases : (..., n-1) rad
        Yoke phase of each shaft: from the driven pin axis at its front to the driving pin
        axis at its rear, right-handed about the shaft. At a joint of constant velocity
        only the sum of the phases on its two sides counts.
    crosses : (n,)
        1 for a cross, 0 for a joint of constant velocity (Rzeppa, tripod, double cardan with
        a true ball); crosses all, if left out.
    samples
        Number N of equally spaced input angles. What is computed from the samples may fold
        orders above N/2 down: 32 is exact to rounding at truck angles, the default up to
        40 degrees.

    Raises
    ------
    DesignError
        If a joint angle reaches a right angle, where the joint locks.
    """
    xp, d, phases = array_library_and_floats(directions, phases)
    slopes = _slopes(d)
    before, after = slopes[..., :-1], slopes[..., 1:]
    apart = 1 + xp.conj(before) * after
    bends = (after - before) / apart
    if not bool(xp.all(xp.abs(bends) < 1)):
        raise DesignError(_locked(d))
    # On to the next driving pin: the carried frames twist, then a quarter turn, the phase.
    kinds = tuple(crosses) or (1.0,) * bends.shape[-1]
    ahead = (1j * xp.conj(apart) / apart)[..., :-1] * xp.exp(
        1j * yoke_phases_as_if_all_crosses(phases, kinds)
    )
    level = xp.conj(1 + slopes[..., 0] ** 2)
    setting = level / xp.abs(level) * xp.ones(phases.shape[:-1], dtype=level.dtype)
    phasor = 0 * setting
    phasors, settings = [], []
    for k in range(bends.shape[-1]):
        step = kinds[k] * (bends[..., k] * setting) ** 2
        turned = 1 + phasor * xp.conj(step)
        phasor = (phasor + step) / xp.conj(turned)
        settings.append(setting)
        phasors.append(phasor)
        if k < ahead.shape[-1]:
            setting = setting * ahead[..., k] * turned / xp.abs(turned)
    return ChainRotation(
        directions=d,
        phasors=first_axis_last(xp.stack(phasors)),
        initial_pins=first_axis_last(xp.stack(settings)),
        samples=samples,
        crosses=kinds,
    )


def yoke_phases_as_if_all_crosses(phases: Any, crosses: Sequence[float]) -> Any:
    """Return the yoke phases (..., n-1) rad that shafts would have behind crosses.

    Behind a joint of constant velocity the yokes stand a quarter turn on: so formulas for
    crosses alone, with its own angle left out, serve a line with such joints.
    """
    if all(crosses):
        return phases
    xp, phases = array_library_and_floats(phases)
    return phases - xp.asarray([(1 - c) * np.pi / 2 for c in crosses[:-1]])


def order_amplitudes(values: ArrayLike, *, highest: int = 4, axis: int = -1) -> ComplexArray:
    """Complex amplitudes of orders 0 to `highest` of samples over one turn.

    values = Re sum_k c_k e^{ikθ}: |c_k| is the 0-to-peak amplitude, c_0 the mean. The
    orders replace the angles on `axis`.
    """
    values = np.moveaxis(np.asarray(values, dtype=float), axis, -1)
    found = np.fft.rfft(values, axis=-1)[..., : highest + 1] / values.shape[-1]
    found[..., 1:] *= 2
    return np.moveaxis(found, -1, axis)


@cache
def _around(samples: int) -> tuple[FloatArray, ComplexArray]:
    """Return equally spaced angles θ of one turn, (samples,) rad, and e^{iθ}."""
    theta = 2 * np.pi / samples * np.arange(samples, dtype=np.float64)
    theta.flags.writeable = False  # every turn shares it
    return theta, np.exp(1j * theta)


def _slopes(directions: Any) -> Any:
    """Return the complex slopes (...) of members (..., 3): half of top + i side, if small."""
    d = directions
    return (d[..., 1] - 1j * d[..., 2]) / (1 + d[..., 0])


def _locked(directions: Any) -> str:
    """Return what to say of a chain in which a joint locks."""
    angles = np.degrees(np.asarray(joint_angles(directions)))
    k = int(np.unravel_index(np.argmax(angles), angles.shape)[-1]) + 1
    return f"joint {k} locks: its angle must stay below 90 deg, got {angles.max():.4g} deg"
