"""What the frame holds of a line that an engine has placed, by virtual power.

At any speed the mechanism allows, the forces on it have no power together. The engine's
own Jacobians say how fast each held point moves; nothing else enters.
"""

from typing import Any

import numpy as np


def held(
    mechanism: Any, overhangs: Any, *, torque: float = 1.0, spent: Any = 0.0, floating: bool = False
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return forces (n-2, 3) on the bearings, force and moment (3,) on the pinion.

    Bearings sit `overhangs` (n-2,) m ahead of the rear joints and hold across their shafts;
    the pinion is held altogether; the gearbox carries its torque and no more. What the
    masses take, over each speed of the mechanism, is `spent` (2n+2,).
    """
    d, points = mechanism.directions, mechanism.points
    n = len(points)
    lengths = np.linalg.norm(np.diff(points, axis=0), axis=-1)
    planes = [across(x) for x in d[1 : n - 1]]
    speeds, slides = [], []
    for k, (plane, overhang) in enumerate(zip(planes, overhangs, strict=True), 1):
        place = [0.0, 0.0, lengths[k - 1] - overhang]
        speeds.append(plane @ mechanism.jacobian(mechanism.bodies[k], place)[3:])
        slides.append(plane @ d[0])
    pinion = mechanism.jacobian(mechanism.bodies[n])
    speeds += [pinion[3:], pinion[:3]]
    slides += [d[0], np.zeros(3)]
    power = np.concatenate(speeds).T
    gearbox, spline = (
        mechanism.plant.GetJointByName(name).velocity_start() for name in ("gearbox", "slide")
    )
    if floating:
        # The spline is stuck; the whole line may move along the flange instead.
        power[spline] = np.concatenate(slides)
    given = np.zeros(len(power))
    given[gearbox] = torque
    forces = np.linalg.solve(power, given - spent)
    bearings = [forces[2 * k : 2 * k + 2] @ plane for k, plane in enumerate(planes)]
    return np.array(bearings).reshape(-1, 3), forces[-6:-3], forces[-3:]


def masses_take(mechanism: Any, theta: float) -> np.ndarray:
    """Return what the masses of a line take while its gearbox turns uniformly at 1 rad/s."""
    from pydrake.multibody.tree import MultibodyForces

    mechanism.motion(theta)
    bias = np.array([mechanism._bias(body) for body in mechanism.bodies[1:]])
    accelerations, _ = mechanism._solve(-bias, 0.0)
    none = MultibodyForces(mechanism.plant)
    return mechanism.plant.CalcInverseDynamics(mechanism.context, accelerations, none)


def across(direction: np.ndarray) -> np.ndarray:
    """Return two unit vectors square to a direction and each other, (2, 3)."""
    y = np.cross([0.3, -0.5, 0.8], direction)
    y /= np.linalg.norm(y)
    return np.stack([y, np.cross(direction, y)])
