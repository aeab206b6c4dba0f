"""A carbon tube weighs a third of its steel tube, if its wall is kept from buckling.

Two tubes of the same plies under 5 kN m: with the hoop plies outside the wall buckles at
3.3 kN m, turned inside out at 7.2 kN m. What the plies carry is the same.
"""

import matplotlib.pyplot as plt
import numpy as np

from cardan.core.units import MPa, mm, rpm
from cardan.model.laminate import CARBON_EPOXY, CompositeTube
from cardan.physics.strength.composite_tube import (
    equivalent_steel_wall_thickness,
    lightest_layup,
    min_buckling_torque,
    strength_utilisation,
    timoshenko_critical_speed,
)

wall = equivalent_steel_wall_thickness(5000.0, outer_radius=30 * mm, yield_strength=750 * MPa)
steel = np.pi * wall * (60 * mm - wall) * 7800
demand = {"torque": 5000.0, "speed": 4000 * rpm, "length": 1.2}
outers = np.array([80, 90, 100, 110, 120]) * mm
weights = [lightest_layup(outer=outer, **demand).mass_per_length for outer in outers]

figure, (weight, length, angle) = plt.subplots(1, 3, figsize=(11, 3.8), layout="tight")
weight.plot(outers / mm, weights, "o-", label="carbon/epoxy")
weight.axhline(steel, color="k", ls="--", label="steel, 60 mm")
weight.set(xlabel="outside diameter, mm", ylabel="mass, kg/m", ylim=(0, None))
weight.legend()

plies = np.radians([15, -15, *[45, -45] * 5, *[90, -90] * 3])
outside = CompositeTube.from_ply_angles(CARBON_EPOXY, plies, outer=90 * mm)
lengths = np.linspace(0.3, 2.0, 12)
for tube, name in ((outside.reversed(), "90° inside"), (outside, "90° outside")):
    pinned, clamped = (min_buckling_torque(tube, lengths, ends=e) for e in ("pinned", "clamped"))
    length.fill_between(lengths, pinned / 1e3, clamped / 1e3, alpha=0.6, label=name)
length.axhline(5, color="k", ls="--", lw=0.8, label="required")
length.set(xlabel="length, m", ylabel="buckling torque, kN m", ylim=(0, None))
length.legend(title="pinned to clamped")

fibre = np.radians(np.linspace(0, 90, 31))
tubes = [CompositeTube.from_ply_angles(CARBON_EPOXY, (a, -a) * 8, outer=90 * mm) for a in fibre]
for name, values in (
    ("torsional stiffness", [t.torsional_stiffness for t in tubes]),
    ("strength", [1 / float(strength_utilisation(t, 1.0)) for t in tubes]),
    ("buckling torque", [float(min_buckling_torque(t, 1.2)) for t in tubes]),
    ("critical speed", [float(timoshenko_critical_speed(t, 1.2)) for t in tubes]),
):
    angle.plot(np.degrees(fibre), np.array(values) / max(values), label=name)
angle.set(xlabel="fibre angle, deg", ylabel="share of the best")
angle.legend()
plt.show()

# Steel outside of 60 mm: R⁴ - r⁴ = 2 R T √3 / (π/2 · Re)... as handbooks have it, 16 T D.
inside = (60**4 - 16 * 5e6 * 60 * 3**0.5 / (np.pi * 750)) ** 0.25
assert abs(wall / mm - (60 - inside) / 2) < 1e-9
assert min(weights) < 0.33 * steel
# Another shell model and CalculiX: 3239 to 3390 N m, and 7125 to 7266 the other way round.
assert 3200 < min_buckling_torque(outside, 1.2) < 3400
assert 7100 < min_buckling_torque(outside.reversed(), 1.2) < 7300
assert (
    abs(strength_utilisation(outside, 5e3) / strength_utilisation(outside.reversed(), 5e3) - 1)
    < 0.06
)
