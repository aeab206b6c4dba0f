"""The lightest carbon tube for a truck's torque weighs a third of its steel tube."""

import matplotlib.pyplot as plt
import numpy as np

from cardan.base.units import MPa, mm, rpm
from cardan.shaft.composite import CARBON_EPOXY, CompositeTube, lightest, steel_wall

wall = steel_wall(5000.0, outer_radius=30 * mm, yield_strength=750 * MPa)
steel = 2 * np.pi * (30 * mm - wall / 2) * wall * 7800
demand = {"torque": 5000.0, "speed": 4000 * rpm, "length": 1.2}
outers = np.linspace(70, 120, 11) * mm
weights = [lightest(outer=outer, **demand).mass_per_length for outer in outers]

figure, (weight, angle) = plt.subplots(1, 2, figsize=(9, 4))
weight.plot(outers / mm, weights, "o-", label="carbon/epoxy")
weight.axhline(steel, color="k", ls="--", label="steel, 60 mm")
weight.set(xlabel="outside diameter, mm", ylabel="mass, kg/m", ylim=(0, None))
weight.legend()
fibre = np.radians(np.linspace(0, 90, 46))
tubes = [CompositeTube(outer=90 * mm, ply=CARBON_EPOXY, angles=(a, -a) * 8) for a in fibre]
for name, values in (
    ("torsional stiffness", [t.torsional_stiffness for t in tubes]),
    ("buckling torque", [t.buckling_torque() for t in tubes]),
    ("critical speed", [float(t.critical_speed(1.2)) for t in tubes]),
):
    angle.plot(np.degrees(fibre), np.array(values) / max(values), label=name)
angle.set(xlabel="fibre angle, deg", ylabel="share of the best")
angle.legend()
plt.show()

assert round(wall / mm, 3) == 2.200
assert round(steel, 3) == 3.117
assert min(weights) < 0.5 * steel
