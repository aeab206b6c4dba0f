"""A truck's line between gearbox and axle: resonances, what the joints excite, and what grows.

At the forced orbit, computed without linearising, orders 2 and 4 of the torque in the shafts
rise where their multiples meet a natural frequency.
"""

import matplotlib.pyplot as plt
import numpy as np

from cardan.core.units import rpm
from cardan.model.layout import direction_from_slopes
from cardan.model.parts import CentreBearing, Line, Shaft, Tube
from cardan.physics.dynamics.floquet import evaluate_in_chunks, growth_rate
from cardan.physics.dynamics.torsional_line import (
    linearised_about_periodic_motion,
    natural_frequencies,
    periodic_motion,
    torsional_line_model,
)

tube = Tube(outer=0.127, wall=0.0034)
truck = Line(
    shafts=(
        Shaft(length=1.24, tube=tube, yoke_inertia=0.05, centre_bearing=CentreBearing()),
        Shaft(length=1.51, tube=tube, yoke_inertia=0.05),
    )
)
slopes = direction_from_slopes(side=np.radians([4.0, 2.8, 4.0, 2.4]), top=np.zeros(4))
line = torsional_line_model(
    truck, slopes, gearbox_inertia=1.2, gearbox_stiffness=9e3, axle_inertia=3.0,
    axle_stiffness=25e3, damping_ratio=0.03, torque=1500.0,
)  # fmt: skip
w = natural_frequencies(line)
speeds = np.linspace(300, 2600, 160) * rpm
motion = periodic_motion(line, speeds)

figure, (campbell, torque) = plt.subplots(2, 1, figsize=(7, 7), sharex=True)
for order in (2, 4):
    campbell.plot(speeds / rpm, order * speeds / (2 * np.pi), "k--", lw=0.8)
    end = min(2500, 94 / order * 60)
    campbell.text(end, order * end / 60, f"order {order}", ha="right", va="bottom", rotation=30)
    torque.semilogy(speeds / rpm, np.abs(motion.order(order)[:, 1]), label=f"order {order}")
for k, frequency in enumerate(w[:2], 1):
    hertz = frequency / (2 * np.pi)
    campbell.axhline(hertz)
    campbell.text(2590, hertz + 1, f"mode {k}, {hertz:.1f} Hz", ha="right", color="tab:blue")
    for order in (2, 4):
        met = 60 * hertz / order
        if speeds[0] / rpm < met < speeds[-1] / rpm:
            campbell.plot(met, hertz, "o", color="tab:red", ms=4)
            torque.axvline(met, color="0.85", zorder=0)
            torque.text(met, 0.98, f" {order} x mode {k}", rotation=90, va="top", fontsize="small",
                        transform=torque.get_xaxis_transform())  # fmt: skip
campbell.set(ylabel="frequency, Hz", ylim=(0, 100))
torque.set(xlabel="speed, rpm", ylabel="torque amplitude in shaft 1, N m")
torque.legend()
plt.show()

top = speeds[np.abs(motion.order(2)[:, 1]).argmax()]
assert abs(2 * top / w[:2] - 1).min() < 0.03  # order 2 peaks where it meets a frequency
rates = evaluate_in_chunks(
    lambda speed: growth_rate(linearised_about_periodic_motion(line, speed)), speeds, chunk=8
)
assert np.all(rates < 0)  # and nothing grows by itself
