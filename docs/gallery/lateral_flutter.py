"""Torque makes a driven shaft flutter on its bearing; unequal bearings can calm it.

Mazzei's rigid shaft: a torque that follows the shaft feeds the whirl one way round, one that
stays along the driving shaft the other, both from about four times the damping ratio times
the stiffness. Where the speed meets the natural frequency the joint's own twice-a-turn term
adds a zone, if the torque follows. Slow shafts are calmed by bearings stiffer one way than
the other; fast ones are kept whirling by their gyroscopic moment.
"""

import matplotlib.pyplot as plt
import numpy as np

from cardan.physics.dynamics.floquet import evaluate_in_chunks, growth_rate
from cardan.physics.dynamics.lateral import rigid_shaft_system

SHAFT = {"transverse_inertia": 1.0, "polar_inertia": 0.1, "stiffness": 1.0, "damping": 0.05}


def rate(speed, torque, follower, difference):
    """Growth of a shaft."""
    return growth_rate(
        rigid_shaft_system(
            speed=speed, torque=torque, follower=follower, stiffness_difference=difference, **SHAFT
        ).periodic_system
    )


LEVELS = [0, 0.02, 0.05, 0.1, 0.2]
speeds, torques = np.linspace(0.1, 3, 75), np.linspace(0, 0.5, 41)
x, y = np.meshgrid(speeds, torques)
figure, axes = plt.subplots(1, 3, figsize=(10, 3.4), sharey=True)
cases = (("follows the shaft", 1, 0), ("stays along the input", 0, 0), ("unequal bearings", 1, 0.2))
for ax, (name, follower, difference) in zip(axes, cases, strict=True):
    found = evaluate_in_chunks(lambda s, t, f=follower, d=difference: rate(s, t, f, d), x, y)
    filled = ax.contourf(x, y, found, levels=LEVELS, cmap="Oranges", extend="max")
    assert found.max() > LEVELS[-1] or name != "follows the shaft"  # the worst has a colour too
    ax.set(title=name, xlabel="speed, 1")
figure.colorbar(filled, ax=axes, label="growth", shrink=0.9)
axes[0].set_ylabel("torque, 1")
plt.show()

assert abs(rate(0.5, 0.2, 1, 0) - 0.02404822) < 5e-9
assert abs(rate(2.0, 0.2, 0, 0) - 0.02716749) < 5e-9
assert rate(0.2, 0.3, 1, 0.2) < 0 < rate(0.2, 0.3, 1, 0)
