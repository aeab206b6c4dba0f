"""Fast through a resonance is low through it; a weak motor does not get through at all."""

import matplotlib.pyplot as plt
import numpy as np

from cardan.dynamics.runup import Driven, limited_power, passage, swept

figure, (sweep, capture) = plt.subplots(2, 1, figsize=(7, 7))
for rate in (0.0005, 0.002, 0.01):
    time = np.linspace(0, 2 / rate, 4000)
    sweep.plot(rate * time, np.abs(swept(time, rate=rate, damping_ratio=0.01)), label=f"{rate:g}")
sweep.set(xlabel="frequency over natural frequency", ylabel="amplitude over static deflection")
sweep.legend(title="sweep rate")

runs = {}
for power in (120, 400):
    line = Driven(
        power=power, stall_torque=100, motor=0.2, wheel=1.0, stiffness=2000, damping=0.05,
        drag=0.01, beta=np.radians(20),
    )  # fmt: skip
    runs[power] = limited_power(line, duration=40)
    capture.plot(runs[power].time, runs[power].motor_speed, lw=0.6, label=f"{power} W")
capture.axhline(line.frequency / 2, color="k", ls="--", lw=0.8)
capture.set(xlabel="time, s", ylabel="speed, rad/s")
capture.legend()
plt.show()

assert abs(passage(rate=0.001).peak - 46.156) < 5e-4
assert abs(runs[120].mean_speed / (line.frequency / 2) - 1) < 0.02  # caught
assert runs[400].mean_speed > 1.5 * line.frequency / 2  # through
