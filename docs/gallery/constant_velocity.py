"""A double cardan is as even as it is well centred; a Persian joint is even at 135 degrees."""

import matplotlib.pyplot as plt
import numpy as np

from cardan.core.units import mm
from cardan.physics.kinematics.constant_velocity import (
    irregularity_by_centring_distances,
    rotate_persian_joint,
)
from cardan.physics.kinematics.hooke_joint import irregularity

angles = np.radians(np.linspace(1, 40, 100))
figure, axes = plt.subplots(figsize=(7, 4))
axes.semilogy(np.degrees(angles), irregularity(angles), "k", label="single joint")
for error in (0.2, 1.0, 3.0):
    swing = irregularity_by_centring_distances(angles, front=40 * mm + error * mm, rear=40 * mm)
    axes.semilogy(np.degrees(angles), swing, label=f"double, {error:g} mm off in 40")
axes.set(xlabel="shaft angle, deg", ylabel="speed swing over mean speed")
axes.legend()
plt.show()

single, double = (
    irregularity(0.3),
    irregularity_by_centring_distances(0.3, front=41 * mm, rear=40 * mm),
)
assert double < single / 10
assert np.ptp(rotate_persian_joint(np.radians(135)).speed[-1]) < 1e-12
