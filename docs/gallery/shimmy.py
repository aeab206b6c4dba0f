"""Play in the column's joint keeps wheels in shimmy at a speed where a tight column is calm.

Tight, the wheels shimmy from 62 km/h on, and from 49 if the column's joint stands at 30 deg with
its pin in plane. At 54 km/h half a degree of play either way is enough: within the play nothing
holds the gear, so small motions grow until hand wheel and column catch them.
"""

import matplotlib.pyplot as plt
import numpy as np

from cardan.core.units import deg
from cardan.physics.dynamics.steering_shimmy import Steering, simulate_shimmy

SPEED = 15.0
steering = Steering()
angled = Steering(beta=30 * deg)
speeds = np.linspace(2, 30, 200)
figure, (rates, motion) = plt.subplots(2, 1, figsize=(7, 7), layout="tight")
for of, name in (
    (steering, "tight"), (angled, "tight, joint at 30°, pin in plane"),
    (Steering(column_stiffness=0.0), "loose: within the play"),
):  # fmt: skip
    rates.plot(3.6 * speeds, of.growth_rate(speeds), label=name)
rates.axhline(0, color="0.5", lw=0.8)
rates.axvline(3.6 * SPEED, color="0.5", ls="--", lw=0.8)
rates.set(xlabel="road speed, km/h", ylabel="growth, 1/s", ylim=(-1, 4))
rates.legend()
runs = {}
for play in (0.0, 0.5):
    runs[play] = simulate_shimmy(
        Steering(play=play * deg), speed=SPEED, duration=40.0, kick=1e-3, samples=4001
    )
    label = f"play ± {play:g}° at the column"
    motion.plot(runs[play].time, runs[play].state[:, 0] / deg, lw=0.7, label=label)
motion.set(xlabel="time, s", ylabel="left wheel, deg", title="54 km/h, after a kick of 1 mrad")
motion.legend()
plt.show()

# Another program's growth, onsets and sustained swing: 0.0676 deg after 120 s, touching at
# 0.2351 rad/s; after 40 s it is still a twentieth above.
assert abs(steering.growth_rate(SPEED) + 0.0595) < 5e-5
assert abs(steering.onset_speeds()[0] - 17.354) < 5e-4
assert abs(angled.onset_speeds()[0] - 13.728) < 5e-4
assert 1 < runs[0.5].swing_amplitude(3.0) / deg / 0.0676 < 1.06
assert abs(runs[0.5].impact_speeds[-1] / 0.2351 - 1) < 0.08
assert abs(runs[0.5].frequency(10.0) - 1.53) < 0.02
assert runs[0.0].swing_amplitude(3.0) < 0.2 * runs[0.5].swing_amplitude(3.0)
