"""Torsional vibration of a line of joints, integrated in time from its equations.

Written out anew from the head of `cardan.physics.dynamics.torsional_line`: inertias, springs and
joints one by one, for motions that the package finds by collocation.
"""

import numpy as np

from cardan.physics.dynamics.torsional_line import output_angle_derivatives


def ahead_of_first_spring(line, turned, speed):
    """Return angle and rate there at an angle of the input."""
    phi, gain, *_ = output_angle_derivatives(turned, beta=line.front)
    return phi + line.front_twist, gain * speed


def rates(line, turned, speed, q, v):
    """Return q' and v' (..., n) by the input's angle."""
    n = q.shape[-1]
    beta, twist, damping, driven = (
        np.broadcast_to(x, n) for x in (line.beta, line.twist, line.damping, line.driven)
    )
    u, du = ahead_of_first_spring(line, turned, speed)
    torque, joints = [], []
    for k in range(n):
        joints.append(output_angle_derivatives(q[..., k], beta=beta[k]))
        torque.append(line.stiffness[k] * (u - q[..., k]) + damping[k] * (du - v[..., k]))
        phi, gain, *_ = joints[k]
        u, du = phi + twist[k], gain * v[..., k]
    torque.append(line.torque)
    a = [
        (torque[k] - gain * torque[k + 1] - driven[k] * gain * bend * v[..., k] ** 2)
        / (line.driving[k] + driven[k] * gain**2)
        for k, (_, gain, bend, _) in enumerate(joints)
    ]
    return v / speed[..., None], np.stack(a, axis=-1) / speed[..., None]


def integrated_motion(line, speed, *, turns, start=0.0, start_rate=0.0, steps_per_turn=256):
    """Return rotations less the input's, rad, and rates, rad/s, (..., steps, n).

    By Runge-Kutta steps of fourth order, from rigid rotation and `start`, `start_rate` (..., n)
    in excess of it.
    """
    speed = np.asarray(speed, float)
    n, h = len(line.stiffness), 2 * np.pi / steps_per_turn
    q, v = (
        np.broadcast_to(x, speed.shape)
        for x in ahead_of_first_spring(line, np.zeros(speed.shape), speed)
    )
    rigid = [(q, v)]
    for k in range(n - 1):
        phi, gain, *_ = output_angle_derivatives(q, beta=np.broadcast_to(line.beta, n)[k])
        q, v = phi + np.broadcast_to(line.twist, n)[k], gain * v
        rigid.append((q, v))
    q, v = (np.stack(part, axis=-1) for part in zip(*rigid, strict=True))
    state = np.stack(np.broadcast_arrays(q + np.asarray(start), v + np.asarray(start_rate)))
    found = [state]
    for t in h * np.arange(round(turns * steps_per_turn)):
        k1 = np.stack(rates(line, t, speed, *state))
        k2 = np.stack(rates(line, t + h / 2, speed, *(state + h / 2 * k1)))
        k3 = np.stack(rates(line, t + h / 2, speed, *(state + h / 2 * k2)))
        k4 = np.stack(rates(line, t + h, speed, *(state + h * k3)))
        state = state + h / 6 * (k1 + 2 * k2 + 2 * k3 + k4)
        found.append(state)
    rotation, rate = np.stack(found, axis=-2)
    return rotation - h * np.arange(len(found))[:, None], rate
