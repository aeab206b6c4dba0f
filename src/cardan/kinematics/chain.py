"""A chain of joints, exactly: any number, any layout, any yoke phase.

Across a member a pin axis is the complex number e^{iθ}, with θ counted from the plane of
the joint's two shafts. The joint turns it into

    e^{iφ} = (cos β cos θ + i sin θ) / |cos β cos θ + i sin θ|,    tan φ = tan θ / cos β

and on the way to the next joint it turns by a quarter (from driven pin to plane normal),
by the yoke phase of the shaft and by the twist between the two joint planes, all fixed.
A whole turn so costs no trigonometry beyond its starting angles, and nothing is unwrapped.
Source: derived from first principles; confirmed with independent multibody engines.
"""

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from cardan.base.arrays import ArrayLike, ComplexArray, FloatArray, namespace
from cardan.base.errors import DesignError

SAMPLES = 64
"""Angles in a turn: orders up to 32, exact to rounding for joint angles up to 40 degrees."""

_UP = (0.0, 0.0, 1.0)


def cross(a: Any, b: Any) -> Any:
    """Return the cross product over the last axis; quicker than NumPy's own for this."""
    xp = namespace(a, b)
    ax, ay, az = a[..., 0], a[..., 1], a[..., 2]
    bx, by, bz = b[..., 0], b[..., 1], b[..., 2]
    return xp.stack([ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx], axis=-1)


def dot(a: Any, b: Any) -> Any:
    """Return the scalar product over the last axis."""
    return (a * b).sum(-1)


def joint_angles(directions: ArrayLike) -> FloatArray:
    """Return the true joint angles (..., n) rad between neighbouring members (..., n+1, 3).

    Exact and well conditioned at every angle: atan2(|u x v|, u . v).
    """
    d = np.asarray(directions, dtype=float)
    u, v = d[..., :-1, :], d[..., 1:, :]
    return np.arctan2(np.linalg.norm(cross(u, v), axis=-1), dot(u, v))


@dataclass(frozen=True)
class Planes:
    """The joint planes of a chain, which do not turn: all its layout has to say.

    Attributes
    ----------
    cos : (..., n) 1
        cos β of each joint.
    normal, front : (..., n, 3) 1
        Normal of each joint's plane, and the direction in that plane square to the
        driving member: (front, normal, driving member) is right-handed.
    start : (...) 1, complex
        Turns a pin axis counted from the horizontal into one counted from joint 1's plane.
    twist : (..., n-1) 1, complex
        Turns e^{iφ} of one joint into e^{iθ} of the next, yoke phase included.
    """

    cos: FloatArray
    normal: FloatArray
    front: FloatArray
    start: ComplexArray
    twist: ComplexArray


def planes(directions: ArrayLike, *, phases: ArrayLike) -> Planes:
    """Joint planes of members (..., n+1, 3) whose shafts have yoke phases (..., n-1) rad.

    Raises
    ------
    DesignError
        If a joint angle reaches a right angle, where the joint locks.
    """
    d = np.asarray(directions, dtype=float)
    u, v = d[..., :-1, :], d[..., 1:, :]
    cos = dot(u, v)
    if not np.all(cos > 0):
        angles = np.degrees(joint_angles(d))
        k = int(np.unravel_index(np.argmax(angles), angles.shape)[-1]) + 1
        msg = f"joint {k} locks: its angle must stay below 90 deg, got {angles.max():.4g} deg"
        raise DesignError(msg)
    normal = cross(u, v)
    size = np.linalg.norm(normal, axis=-1, keepdims=True)
    # A straight joint has no plane of its own; any plane through its shafts serves.
    spare = cross(u, np.where(np.abs(u[..., 2:]) < 0.9, _UP, (0.0, 1.0, 0.0)))
    straight = size < 1e-14
    normal = np.where(straight, spare, normal)
    normal = normal / np.where(straight, np.linalg.norm(spare, axis=-1, keepdims=True), size)
    front = cross(normal, u)
    # e^{iθ} of a pin axis a is a.front + i a.normal; the reference is the horizontal.
    level = cross(np.asarray(_UP), d[..., 0, :])
    level = level / np.linalg.norm(level, axis=-1, keepdims=True)
    start = dot(level, front[..., 0, :]) + 1j * dot(level, normal[..., 0, :])
    before, after, along = normal[..., :-1, :], normal[..., 1:, :], d[..., 1:-1, :]
    turned = dot(before, after) + 1j * dot(cross(before, after), along)
    twist = 1j * np.exp(1j * np.asarray(phases, dtype=float)) * turned.conj()
    return Planes(cos=cos, normal=normal, front=front, start=start, twist=twist)


@dataclass(frozen=True)
class Turn:
    """One turn of a chain: what every member does at equally spaced input angles.

    Leading axes are cases, then comes the joint (or the member behind it), then the angle.

    Attributes
    ----------
    theta : (N,) rad
        Rotation of the gearbox yoke about member 0, zero where its pin axis is horizontal
        and points to the vehicle's right.
    pin : (..., n, N) 1, complex
        e^{iθ} of the driving pin axis at each joint, from that joint's own plane.
    lead : (..., n, N) rad
        Rotation of member k less that of the gearbox, since each joint's mean position.
    speed, acceleration : (..., n, N) 1
        Speed and acceleration of member k at constant input speed, over w and over w².
    """

    planes: Planes
    theta: FloatArray
    pin: ComplexArray
    lead: FloatArray
    speed: FloatArray
    acceleration: FloatArray

    @cached_property
    def driving_pins(self) -> FloatArray:
        """Unit vectors along the driving pin axis of each joint, (..., n, N, 3)."""
        front, normal = self.planes.front[..., None, :], self.planes.normal[..., None, :]
        return self.pin.real[..., None] * front + self.pin.imag[..., None] * normal

    @cached_property
    def coast_acceleration(self) -> FloatArray:
        """Acceleration of each member over the pinion's w², the pinion turning uniformly."""
        w, a = self.speed, self.acceleration
        last, gain = w[..., -1:, :], a[..., -1:, :]
        return (a * last - w * gain) / last**3


def turn(directions: ArrayLike, *, phases: ArrayLike, samples: int = SAMPLES) -> Turn:
    """Turn a chain once, exactly.

    Parameters
    ----------
    directions : (..., n+1, 3) 1
        Unit vectors of the members, gearbox first, pinion last.
    phases : (..., n-1) rad
        Yoke phase of each shaft: from the driven pin axis at its front to the driving pin
        axis at its rear, right-handed about the shaft.
    samples
        Number N of equally spaced input angles. Orders above N/2 fold down: 32 is exact to
        rounding at truck angles, the default up to 40 degrees.

    Returns
    -------
    Turn
        Smooth and periodic, so its mean and orders are spectrally accurate (`orders`).
    """
    return turn_planes(planes(directions, phases=phases), samples=samples)


def turn_planes(geometry: Planes, *, samples: int = SAMPLES) -> Turn:
    """Turn a chain whose joint planes are known."""
    xp = namespace(geometry.cos)
    theta = 2 * np.pi * xp.arange(samples) / samples
    entering = geometry.start[..., None] * xp.exp(1j * theta)
    lead, speed, gain = 1.0 + 0j, 1.0, 0.0
    pins, leads, speeds, accelerations = [], [], [], []
    for k in range(geometry.cos.shape[-1]):
        cos_beta = geometry.cos[..., k, None]
        cos, sin = entering.real, entering.imag
        size2 = (cos_beta * cos) ** 2 + sin**2
        leaving = (cos_beta * cos + 1j * sin) / xp.sqrt(size2)
        # d(ln ratio)/dθ = -sin²β sin 2θ / (1 - sin²β cos²θ), and dθ runs at `speed`.
        gain = gain - 2 * (1 - cos_beta**2) * sin * cos / size2 * speed
        speed = speed * cos_beta / size2
        lead = lead * leaving * entering.conj()
        pins.append(entering)
        leads.append(xp.atan2(lead.imag, lead.real) if hasattr(xp, "atan2") else xp.angle(lead))
        speeds.append(speed)
        accelerations.append(speed * gain)
        if k < geometry.twist.shape[-1]:
            entering = leaving * geometry.twist[..., k, None]
    return Turn(
        planes=geometry,
        theta=theta,
        pin=xp.stack(pins, axis=-2),
        lead=xp.stack(leads, axis=-2),
        speed=xp.stack(speeds, axis=-2),
        acceleration=xp.stack(accelerations, axis=-2),
    )


def orders(values: ArrayLike, *, highest: int = 4, axis: int = -1) -> ComplexArray:
    """Complex amplitudes of orders 0 to `highest` of samples over one turn.

    values = Re sum_k c_k e^{ikθ}: |c_k| is the 0-to-peak amplitude, c_0 the mean. The
    orders replace the angles on `axis`.
    """
    values = np.moveaxis(np.asarray(values, dtype=float), axis, -1)
    found = np.fft.rfft(values, axis=-1)[..., : highest + 1] / values.shape[-1]
    found[..., 1:] *= 2
    return np.moveaxis(found, -1, axis)


def peak(values: ArrayLike, *, axis: int = -1) -> FloatArray:
    """Return the largest absolute value over a turn, between the samples too.

    The samples' trigonometric interpolation is followed uphill from the best sample by
    Newton's method, so the answer is that of a turn without steps.
    """
    values = np.moveaxis(np.asarray(values, dtype=float), axis, -1)
    n = values.shape[-1]
    best = np.argmax(np.abs(values), axis=-1)
    spectrum = np.fft.rfft(values, axis=-1) / n
    spectrum[..., 1 : (n + 1) // 2] *= 2
    k = np.arange(spectrum.shape[-1])
    theta = 2 * np.pi * best / n
    step = np.pi / n
    for _ in range(4):
        wave = spectrum * np.exp(1j * k * theta[..., None])
        slope = (1j * k * wave).real.sum(-1)
        bend = (-(k**2) * wave).real.sum(-1)
        newton = -slope / np.where(bend == 0, 1.0, bend)
        theta = theta + np.clip(np.where(bend == 0, 0.0, newton), -step, step)
    top = np.abs((spectrum * np.exp(1j * k * theta[..., None])).real.sum(-1))
    return np.maximum(top, np.abs(values).max(-1))
