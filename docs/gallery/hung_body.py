"""A slender body hung from a joint moves outward when spun; a flat one never does."""

import matplotlib.pyplot as plt
import numpy as np

from cardan.physics.dynamics.suspended_body import BodySuspendedFromJoint

speeds = np.linspace(0, 12, 400)
figure, axes = plt.subplots(figsize=(7, 4))
for name, polar in (("slender", 0.5), ("nearly round", 1.5), ("flat", 3.0)):
    body = BodySuspendedFromJoint(
        driving_inertia=2.0, driven_inertia=1.6, polar_inertia=polar, weight_moment=20.0,
        friction=0.05,
    )  # fmt: skip
    axes.plot(speeds, body.exponents(speeds).real.max(-1), label=name)
axes.axhline(0, color="0.5", lw=0.8)
axes.set(xlabel="speed, rad/s", ylabel="growth, 1/s", ylim=(-0.1, 1))
axes.legend()
plt.show()

slender = BodySuspendedFromJoint(
    driving_inertia=2.0, driven_inertia=1.6, polar_inertia=0.5, weight_moment=20.0, friction=0.05
)
limit = float(slender.speed_limit())
assert abs(limit - (20 / 1.5) ** 0.5) < 1e-12
assert slender.exponents(0.999 * limit).real.max() < 0 < slender.exponents(1.001 * limit).real.max()
