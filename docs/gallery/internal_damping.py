"""Damping that turns with the shaft is good below its critical speed and bad above it."""

import matplotlib.pyplot as plt
import numpy as np

from cardan.physics.dynamics.internal_damping import (
    hysteretic_whirl_growth,
    viscous_threshold,
    viscous_whirl_exponents,
)

speeds = np.linspace(0, 4, 401)
figure, axes = plt.subplots(figsize=(7, 4))
for internal in (0.02, 0.05, 0.1):
    forward = viscous_whirl_exponents(
        speed=speeds, mass=1.0, stiffness=1.0, external=0.1, internal=internal
    )[:, 0]
    axes.plot(speeds, forward.real, label=f"viscous, $c_i$ = {internal:g}")
axes.plot(
    speeds,
    hysteretic_whirl_growth(speed=speeds, mass=1.0, stiffness=1.0, external=0.05, loss_factor=0.1)[
        :, 0
    ],
    "k",
    label="hysteretic, η = 0.1, $c_e$ = 0.05",
)
axes.axhline(0, color="0.5", lw=0.8)
axes.set(xlabel="speed over critical speed", ylabel="growth of forward whirl over frequency")
axes.legend()
plt.show()

edge = viscous_threshold(frequency=1.0, external=0.1, internal=0.05)
assert edge == 3.0
at_edge = viscous_whirl_exponents(speed=edge, mass=1.0, stiffness=1.0, external=0.1, internal=0.05)
assert abs(at_edge[0].real) < 1e-15
