"""Fast through a resonance is low through it; a motor of limited power may stick there.

From every position of the driving yoke: 120 W stays at half the torsional frequency, where
the joint pumps the motor's power into vibration; 400 W passes that and is caught at the
frequency itself, from seven starting angles of eight; 1500 W gets through.
"""

import matplotlib.pyplot as plt
import numpy as np

from cardan.physics.dynamics.run_up import (
    MotorDrivenShaft,
    limited_power_run_up,
    resonance_passage,
    run_up_outcomes,
    swept_response,
)

figure, (sweep, capture) = plt.subplots(2, 1, figsize=(7, 7), layout="tight")
for rate in (0.0005, 0.002, 0.01):
    time = np.linspace(0, 2 / rate, 4000)
    sweep.plot(
        rate * time, np.abs(swept_response(time, rate=rate, damping_ratio=0.01)), label=f"{rate:g}"
    )
sweep.set(xlabel="frequency over natural frequency", ylabel="amplitude over static deflection")
sweep.legend(title="sweep rate")


def line(power):
    """A motor, a joint of 20 deg, a shaft and a wheel."""
    return MotorDrivenShaft(
        power=power, stall_torque=100, motor=0.2, wheel=1.0, stiffness=2000, damping=0.05,
        drag=0.01, beta=np.radians(20),
    )  # fmt: skip


found = {power: run_up_outcomes(line(power)) for power in (120, 400, 1500)}
for power, colour in ((120, "tab:blue"), (400, "tab:orange"), (1500, "tab:green")):
    # One that ends as most do, and one that does not where there is one.
    ends = found[power].outcomes
    for fate in dict.fromkeys(ends):
        angle = found[power].angle[ends.index(fate)]
        run = limited_power_run_up(line(power), duration=30, start_angle=float(angle))
        label = f"{power} W, {np.degrees(angle):.1f}°: {fate}"
        style = ":" if fate != found[power].worst else "-"
        capture.plot(run.time, run.motor_speed, style, lw=0.7, color=colour, label=label)
frequency = line(120).frequency
for level, name in ((frequency / 2, "half"), (frequency, "torsional frequency")):
    capture.axhline(level, color="k", ls="--", lw=0.8)
    capture.text(0.1, level + 2, name, fontsize="small")
capture.set(xlabel="time, s", ylabel="speed, rad/s", ylim=(0, 180), xlim=(0, 30))
capture.legend(fontsize="small", loc="lower right")
plt.show()

assert abs(resonance_passage(rate=0.001).peak - 46.156) < 5e-4
assert str(found[120]) == "caught at half, 8 of 8"
assert str(found[400]) == "caught, 7 of 8"
assert str(found[1500]) == "through, 8 of 8"
assert abs(np.median(found[400].mean_speed) - 109.0) < 0.3  # another program's mean
