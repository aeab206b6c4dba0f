"""A joint with play rattles from the speed at which inertia beats the load."""

import matplotlib.pyplot as plt
import numpy as np

from cardan.physics.dynamics.joint_backlash import (
    JointWithBacklash,
    effective_restitution,
    flores_damping_factor,
    herbert_mcwhannell_damping_factor,
    hu_guo_damping_factor,
    hunt_crossley_damping_factor,
    lankarani_nikravesh_damping_factor,
    lee_wang_damping_factor,
    simulate_rattle,
)

joint = JointWithBacklash(
    beta=np.radians(15), play=1e-3, radius=0.04, stiffness=1e11, inertia=0.05, load=50.0,
    drag=0.01, restitution=0.6,
)  # fmt: skip
edge = joint.rattle_speed()
figure, (gap, laws) = plt.subplots(2, 1, figsize=(7, 7))
runs = {share: simulate_rattle(joint, speed=share * edge, duration=0.1) for share in (0.9, 1.2)}
for share, run in runs.items():
    gap.plot(run.time, 1e3 * run.gap, label=f"{share:g} of the rattle speed")
gap.axhspan(-1, 1, color="0.9")
gap.set(xlabel="time, s", ylabel="driving less driven rotation, mrad")
gap.legend()
e = np.linspace(0.05, 0.99, 60)
for law in (
    hunt_crossley_damping_factor,
    lankarani_nikravesh_damping_factor,
    herbert_mcwhannell_damping_factor,
    lee_wang_damping_factor,
    flores_damping_factor,
    hu_guo_damping_factor,
):
    laws.plot(e, [effective_restitution(law, x) for x in e], label=law.__name__.replace("_", " "))
laws.plot([0, 1], [0, 1], "k:", lw=0.8)
laws.set(xlabel="restitution given to the law", ylabel="restitution obtained")
laws.legend()
plt.show()

assert runs[0.9].impact_speeds.size == 0
assert runs[1.2].impact_speeds.size > 3
assert (
    abs(effective_restitution(flores_damping_factor, 0.5) - 0.5)
    < 0.04
    < abs(effective_restitution(hunt_crossley_damping_factor, 0.5) - 0.5)
)
