"""Recordings of a bracket under a two-piece line on rubber, made by mechanics of another hand.

Nothing of the program is in here. A cross has two pins at right angles, each square to its
member: that is all that is known of a joint. How far the pinion has turned follows from where
joint 2 is, and virtual work makes of it what the torque does to joint 2:

    Q = -T (∂θ_out/∂c) / (∂θ_out/∂θ_in)

The first shaft swings about joint 1, the second slides in its spline; both are rods with
masses at their ends. Rubber is a spring with a damper beside it, so its loss factor grows with
frequency: it is the one asked for at the mode itself. All of it is stepped through time.
"""

from dataclasses import dataclass

import numpy as np
from adversarial import bracket, colour
from numba import njit

G_MM = 1e-6  # kg m


@dataclass(frozen=True, kw_only=True)
class Truth:
    """What is so, in SI; angles in rad."""

    points: tuple = ((0.0, 0.0, 0.0), (0.85, 0.0, -0.049), (1.97, 0.028, -0.119))
    gearbox_slope: float = np.radians(4.5)
    pinion_slope: float = np.radians(3.6)
    phases: tuple = (0.0, 0.0)
    torsion: tuple = (0.0, 0.0)  # rad/(N m), of each shaft: its rear yoke stays behind
    over: float = 0.13  # m, from the bearing to joint 2
    vertical: float = 172.5e3  # N/m
    lateral: float = 85e3
    loss: float = 0.085
    tube: float = 7.18  # kg/m
    yokes: tuple = (6.0, 8.0, 6.0, 6.0)  # kg, front and rear of each shaft
    spline: tuple = (4.0, 0.18)  # kg, m behind joint 2
    unbalance: float = 0.0  # kg m, at joint 2
    heavy: float = 1.0  # rad
    offset: float = 0.4  # rad, of the tacho's mark behind the yoke's zero
    unit: tuple = (0.0, 9e3, 30e3)  # Pa/N along the vehicle's axes
    gain: float = 1.0
    mode: tuple | None = None  # Hz, damping, of the bracket
    noise: float = 0.3e6  # Pa rms of the road at the gauge


@dataclass(frozen=True)
class Shaken:
    """A recording: MPa, turns, N m, turns/s over time, and the force on the bearing, N."""

    rate: float
    stress: np.ndarray
    turns: np.ndarray
    torque: np.ndarray
    speed: np.ndarray
    force: np.ndarray


@njit(cache=True)
def _cross(a, b):
    return np.array(
        [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
    )


@njit(cache=True)
def _along(a):
    return a / np.sqrt(a @ a)


@njit(cache=True)
def _pinion(angle, joint, d0, last, p1, p3, phases):
    """How far the pinion has turned, from the horizontal, with joint 2 where it is."""
    d1, d2 = _along(joint - p1), _along(p3 - joint)
    up = np.array([0.0, 0.0, 1.0])
    level = _along(_cross(up, d0))
    pin = np.cos(angle) * level + np.sin(angle) * _cross(d0, level)
    pin = _along(_cross(d1, pin))
    pin = np.cos(phases[0]) * pin + np.sin(phases[0]) * _cross(d1, pin)
    pin = _along(_cross(d2, pin))
    pin = np.cos(phases[1]) * pin + np.sin(phases[1]) * _cross(d2, pin)
    pin = _along(_cross(last, pin))
    level = _along(_cross(up, last))
    return np.arctan2(pin @ _cross(last, level), pin @ level)


@njit(cache=True)
def _turned(a, b):
    """a - b, within half a turn."""
    return (a - b + np.pi) % (2 * np.pi) - np.pi


@njit(cache=True)
def _pushed(angle, torque, x, joint, axes, d0, last, p1, p3, phases):
    """Force (2,) on the two ways joint 2 can go, by virtual work."""
    h = 1e-5
    here = joint + axes[0] * x[0] + axes[1] * x[1]
    pace = _turned(
        _pinion(angle + h, here, d0, last, p1, p3, phases),
        _pinion(angle - h, here, d0, last, p1, p3, phases),
    )
    out = np.empty(2)
    for k in range(2):
        swept = _turned(
            _pinion(angle, here + h * axes[k], d0, last, p1, p3, phases),
            _pinion(angle, here - h * axes[k], d0, last, p1, p3, phases),
        )
        out[k] = -torque * swept / pace
    return out


@njit(cache=True)
def _stepped(
    turns, torque, speed, dt, joint, axes, d0, last, p1, p3, phases, soft, M, K, C, U, heavy, once
):
    """Joint 2's way (n, 2) m and speed: Newmark's average acceleration, the push as it stands."""
    n = turns.size
    x, v, a = np.zeros(2), np.zeros(2), np.zeros(2)
    X, V = np.empty((n, 2)), np.empty((n, 2))
    A = np.linalg.inv(M + dt / 2 * C + dt * dt / 4 * K)
    for i in range(n):
        angle = 2 * np.pi * turns[i]
        xp, vp = x + dt * v + dt * dt / 4 * a, v + dt / 2 * a
        twisted = phases - torque[i] * soft
        f = _pushed(angle, torque[i], xp, joint, axes, d0, last, p1, p3, twisted)
        spin = U * (2 * np.pi * speed[i]) ** 2
        f[0] += spin * np.sin(angle + heavy) * once
        f[1] += spin * np.cos(angle + heavy) * once
        a = A @ (f - C @ vp - K @ xp)
        x, v = xp + dt * dt / 4 * a, vp + dt / 2 * a
        X[i], V[i] = x, v
    return X, V


def run_up(seconds, rate, rng, *, low=3.0, high=22.0, most=2600.0):
    """Turns/s and N m of a slow run up and down, the torque coming and going."""
    t = np.arange(int(seconds * rate)) / rate
    speed = low + (high - low) * (0.5 - 0.5 * np.cos(2 * np.pi * t / seconds * 2))
    torque = most * (0.65 + 0.3 * np.sin(2 * np.pi * t / rng.uniform(17, 29) + rng.uniform(0, 6)))
    return t, speed, torque


def shaken(of: Truth, *, seconds=120.0, rate=500.0, inner=4, seed=0, drive=run_up) -> Shaken:
    """Step a line through a drive, `inner` steps a sample."""
    rng = np.random.default_rng(seed)
    fine = rate * inner
    t, speed, torque = drive(seconds, fine, rng)
    turns = np.cumsum(speed) / fine
    p1, p2, p3 = (np.array(p, float) for p in of.points)
    d0 = np.array([np.cos(of.gearbox_slope), 0.0, -np.sin(of.gearbox_slope)])
    last = np.array([np.cos(of.pinion_slope), 0.0, -np.sin(of.pinion_slope)])
    d1, d2 = (p2 - p1) / np.linalg.norm(p2 - p1), (p3 - p2) / np.linalg.norm(p3 - p2)
    level = np.cross([0.0, 0.0, 1.0], d1)
    level /= np.linalg.norm(level)
    axes = np.stack([np.cross(d1, level), level])  # up and sideways, square to shaft 1
    L1, L2 = np.linalg.norm(p2 - p1), np.linalg.norm(p3 - p2)
    # Shaft 1 swings about joint 1; shaft 2 moves across itself, its rear end held.
    first = of.tube * L1 / 3 + of.yokes[1]
    slide, where = of.spline
    second = of.tube * L2 / 3 + of.yokes[2] + slide * (1 - where / L2) ** 2
    across = axes - np.outer(axes @ d2, d2)
    M = first * np.eye(2) + second * across @ across.T
    lever = (L1 - of.over) / L1
    K = lever**2 * np.diag([of.vertical, of.lateral])
    upright = np.sqrt(K.diagonal() / M.diagonal())
    C = of.loss * np.diag(K.diagonal() / upright)
    X, V = _stepped(
        turns, torque, speed, 1 / fine, p2, axes, d0, last, p1, p3, np.array(of.phases),
        np.array(of.torsion), M, K, C, of.unbalance, of.heavy, 1.0,
    )  # fmt: skip
    local = X * K.diagonal() / lever + V * C.diagonal() / lever
    force = local @ axes
    stress = force @ np.array(of.unit) * of.gain
    if of.mode is not None:
        hertz, damping = of.mode
        stress = (
            bracket(stress, [{"hertz": hertz, "damping": damping, "share": 1.0}], fine) - stress
        )
    road = of.noise * colour(rng, t.size, fine, low=0.7, high=60.0, slope=0.7)
    keep = slice(inner - 1, None, inner)
    return Shaken(
        rate, ((stress + road) / 1e6)[keep], turns[keep] + of.offset / (2 * np.pi),
        torque[keep], speed[keep], force[keep],
    )  # fmt: skip


LINE = """
title: A line on rubber, as drawn
speed_rpm: 1400
torque_Nm: 2600
driveline:
  points_mm: [[0, 0, 0], [850, 0, -49], [1970, 28, -119]]
  gearbox_slope: {side_deg: 4.5}
  pinion_slope: {side_deg: 3.6}
  shafts:
    - tube:
        outer_mm: 100
        wall_mm: 3
        material: &rod {density_kg_m3: 7850, youngs_modulus_GPa: 900}  # does not bend
      phase_deg: 0
      # as the supplier's sheet says
      centre_bearing:
        from_rear_joint_mm: 130
        vertical_stiffness_N_mm: 150
        lateral_stiffness_N_mm: 100
        loss_factor: 0.1
      yoke_mass_kg: [6, 8]
      balance_grade: G16
    - tube: {outer_mm: 100, wall_mm: 3, material: *rod}
      phase_deg: 0  # in line
      spline: {mean_radius_mm: 27, friction: 0.08, mass_kg: 4, from_front_joint_mm: 180}
      yoke_mass_kg: [6, 6]
      balance_grade: G16
"""
"""The application file as drawn: its rubber 13 % too soft up and 18 % too firm sideways."""
