"""A shaft's bending modes flutter under little torque, unless its material is damped.

Above: fastest growth over torque at a slow speed. Without damping in the material the bending
modes flutter first; a little of it leaves only the motion on the bearing, as of a rigid shaft.
Below: over speed, without torque. That damping turns with the shaft, and beyond the critical
speed of bending it feeds what it calmed.
"""

import matplotlib.pyplot as plt
import numpy as np

from cardan.physics.dynamics.lateral import flexible_shaft_system, natural_frequencies
from cardan.physics.dynamics.stability_chart import find_zeros

SHAFT = {
    "length": 2.0, "mass_per_length": 0.35, "bearing": 0.5, "bearing_damping": 0.03,
    "rotary_inertia": 0.01, "functions": 5,
}  # fmt: skip


def fastest(**changes):
    """Growth of the fastest mode of a shaft."""
    return flexible_shaft_system(**(SHAFT | changes)).rotating_frame_exponents().real.max(-1)


def over_torque(torque, damping, stiffness=3.0):
    """Growth at a slow speed."""
    return fastest(speed=0.5, torque=torque, bending_stiffness=stiffness, internal_damping=damping)


def over_speed(speed, damping):
    """Growth without torque."""
    return fastest(speed=speed, torque=0.0, bending_stiffness=3.0, internal_damping=damping)


torques, speeds = np.linspace(0, 0.6, 100), np.linspace(0.5, 25, 150)
figure, (loaded, turning) = plt.subplots(2, 1, figsize=(7, 7))
for damping in (0.0, 0.02):
    loaded.plot(torques, over_torque(torques, damping), label=f"material damping {damping:g} s")
loaded.plot(torques, over_torque(torques, 0.0, stiffness=1e5), "k--", label="rigid")
loaded.set(xlabel="torque, N m", ylabel="growth, 1/s", ylim=(-0.1, 0.3))
for damping in (0.0, 0.02, 0.1):
    turning.plot(speeds, over_speed(speeds, damping), label=f"material damping {damping:g} s")
bending = natural_frequencies(
    flexible_shaft_system(speed=1.0, torque=0.0, bending_stiffness=3.0, **SHAFT)
)
turning.axvline(bending[1], color="0.8", zorder=0)
turning.set(xlabel="speed, rad/s", ylabel="growth, 1/s", ylim=(-0.1, 0.5))
for axes in (loaded, turning):
    axes.axhline(0, color="0.5", lw=0.8)
    axes.legend()
plt.show()

plain, damped = (
    find_zeros(lambda T, c=c: over_torque(T, c), between=(0.005, 0.6), start=60)[0]
    for c in (0.0, 0.02)
)
assert plain < 0.2 * damped
limit = find_zeros(lambda W: over_speed(W, 0.1), between=(1.0, 25.0), start=60)[0]
assert limit > bending[1]  # a bearing with damping lifts it above the critical speed
