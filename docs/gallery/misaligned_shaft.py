"""A joint at an angle feeds the flutter of a slow shaft: the torque that starts it falls.

A rigid shaft on a bearing a tenth stiffer across the plane of the shafts, driven by a torque
that follows it. The forced motion is found first, with the curvature of the shaft's path and
the spin that the joint couples to every tilt; small motions are linear about it.
"""

import matplotlib.pyplot as plt
import numpy as np

from cardan.physics.dynamics.floquet import growth_rate
from cardan.physics.dynamics.lateral import misaligned_shaft_system
from cardan.physics.dynamics.stability_chart import find_zeros


def rate(speed, torque, angle, polar):
    """Growth of the shaft at a joint angle in degrees."""
    system, _ = misaligned_shaft_system(
        speed=speed, torque=torque, beta=np.radians(angle), transverse_inertia=1.0,
        polar_inertia=polar, stiffness=(1.0, 1.1), damping=0.05,
    )  # fmt: skip
    return growth_rate(system)


angles = np.linspace(0, 20, 21)
cases = ((0.5, 0.2, 0.1), (0.5, 0.16, 0.1), (0.7, 0.05, 0.001))
figure, (rates, onset) = plt.subplots(1, 2, figsize=(9, 4), layout="tight")
for speed, torque, polar in cases:
    label = f"speed {speed:g}, torque {torque:g}, polar {polar:g}"
    rates.plot(angles, rate(speed, torque, angles, polar), label=label)
rates.axhline(0, color="0.5", lw=0.8)
rates.set(xlabel="joint angle, deg", ylabel="growth")
rates.legend(fontsize="small")

coarse = np.arange(0, 26, 5)
starts = {}
for speed in (0.5, 1.8):
    starts[speed] = np.array([
        find_zeros(lambda T, a=a, s=speed: rate(s, T, a, 0.1), between=(0.02, 0.2), start=18)[0]
        for a in coarse
    ])  # fmt: skip
    onset.plot(coarse, starts[speed], "o-", label=f"speed {speed:g}")
onset.set(xlabel="joint angle, deg", ylabel="torque that starts flutter", ylim=(0, None))
onset.legend()
plt.show()

# Rates of another program, by an engine with halved steps to 1e-5.
assert abs(rate(0.5, 0.2, 10, 0.1) - 0.02193952) < 1e-8
assert abs(rate(0.5, 0.2, 0, 0.1) - 0.01769170) < 1e-8
assert abs(rate(0.7, 0.05, 25, 0.001) + 0.02486859) < 1e-8
assert np.all(np.diff(starts[0.5]) < 0)
