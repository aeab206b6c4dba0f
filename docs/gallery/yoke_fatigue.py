"""A yoke that broke by fatigue: Marin's factors give the limit its examiners estimated.

Bayrakceken, Tasgetiren & Yavuz (Engineering Failure Analysis 14, 2007) examined a broken
universal-joint yoke of AISI 5046H steel with 1750 MPa tensile strength and estimated its fatigue
limit, by size, load and surface factors, at 400 to 450 MPa. The section of the ear, 12 by 18 mm,
is assumed here.
"""

import numpy as np

from cardan.core.units import MPa, mm
from cardan.physics.fatigue.damage import miner_damage
from cardan.physics.fatigue.rainflow import rainflow
from cardan.physics.fatigue.sn_curve import (
    LOAD_TYPE_FACTORS,
    endurance_limit,
    equivalent_diameter,
    size_factor,
    steel_sn_curve,
    surface_factor,
)

ULTIMATE = 1750 * MPa
size = size_factor(equivalent_diameter(width=12 * mm, height=18 * mm))
surface = surface_factor("machined", ultimate=ULTIMATE)
limit = endurance_limit(ULTIMATE, surface, size, LOAD_TYPE_FACTORS["bending"])
print(f"surface {surface:.3f}, size {size:.3f}: fatigue limit {limit / MPa:.0f} MPa")

# Torque reversals make this stress at the ear's root; a forged skin left on costs this much.
forged = surface_factor("as-forged", ultimate=ULTIMATE)
raw = endurance_limit(ULTIMATE, forged, size, LOAD_TYPE_FACTORS["bending"])
stress = 380 * MPa * np.sin(np.linspace(0, 200 * np.pi, 20_001))
sound = miner_damage(rainflow(stress), curve=steel_sn_curve(ULTIMATE, endurance=limit))
skin = miner_damage(rainflow(stress), curve=steel_sn_curve(ULTIMATE, endurance=raw))
print(f"380 MPa, a hundred times: damage {sound:.2g} machined, {skin:.2g} with its forged skin")

assert 400 * MPa < limit < 450 * MPa
assert sound == 0
assert skin > 0
