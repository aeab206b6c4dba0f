"""Wheels shimmy above a road speed; play in the column's joints lets them begin sooner."""

import matplotlib.pyplot as plt
import numpy as np

from cardan.dynamics.shimmy import Steering, shimmy

steering = Steering()
speeds = np.linspace(2, 50, 200)
(onset,) = steering.onset()
figure, (rates, motion) = plt.subplots(2, 1, figsize=(7, 7))
rates.plot(3.6 * speeds, steering.growth(speeds))
rates.axhline(0, color="0.5", lw=0.8)
rates.set(xlabel="road speed, km/h", ylabel="growth, 1/s")
ends = {}
for play in (0.0, 0.02):
    time, state = shimmy(Steering(play=play), speed=0.95 * onset, duration=8.0, kick=1e-3)
    motion.plot(time, np.degrees(state[:, 0]), lw=0.6, label=f"play ± {play:g} rad")
    ends[play] = np.abs(state[time > 7, 0]).max()
motion.set(xlabel="time, s", ylabel="left wheel, deg")
motion.legend()
plt.show()

assert 17 < onset < 19  # 65 km/h
assert ends[0.02] > 2 * ends[0.0]
