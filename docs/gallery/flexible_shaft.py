"""A softer shaft flutters sooner, and internal damping ends its calm above a critical speed."""

import matplotlib.pyplot as plt
import numpy as np

from cardan.dynamics.damping import viscous_threshold
from cardan.dynamics.lateral import flexible_shaft, natural_frequencies

SHAFT = {
    "length": 1.5, "mass_per_length": 10.0, "bearing": 4e5, "bearing_damping": 300.0,
    "rotary_inertia": 0.02, "follower": 0.0,
}  # fmt: skip

speeds = np.linspace(20, 900, 300)
figure, axes = plt.subplots(figsize=(7, 4))
for stiffness in (1e5, 3e5, 1e6):
    rates = [
        flexible_shaft(
            speed=speeds, torque=1000.0, bending_stiffness=stiffness, internal_damping=damping,
            **SHAFT,
        ).rotating_exponents().real.max(-1)
        for damping in (1e-5, 1e-4)
    ]  # fmt: skip
    (drawn,) = axes.plot(speeds, rates[0], label=f"E I = {stiffness:.0e} N m²")
    axes.plot(speeds, rates[1], "--", color=drawn.get_color())
axes.axhline(0, color="k", lw=0.8)
axes.set(xlabel="speed, rad/s", ylabel="growth, 1/s", ylim=(-20, 20))
axes.legend(title="dashed: ten times the internal damping")
plt.show()

# Without torque the low mode obeys Vatta & Vigliani: stable up to w (1 + c_e / c_i).
assert viscous_threshold(frequency=100.0, external=2.0, internal=1.0) == 300.0
stiff, soft = (
    natural_frequencies(
        flexible_shaft(speed=1.0, torque=0.0, bending_stiffness=EI, **SHAFT)
    )[0] for EI in (1e6, 1e5)
)  # fmt: skip
assert soft < stiff
