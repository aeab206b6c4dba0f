"""An application of two slender shafts: a mass on one spring."""

import numpy as np

UP, LEVEL, LOSS = 200.0, 120.0, 0.1  # N/mm, and the share of it that the rubber loses


def rods(speed: float, *, plane: str, more: str = "", torque: float = 1.0) -> str:
    """Two rods of 20 and 25 kg that bend in one plane: their crosses push square to it.

    A tube of next to no mass, and a third of the rod's at the joint where the bearing is: a mass
    of 15 kg on one spring.
    """
    light = "{name: light, youngs_modulus_GPa: 2000, density_kg_m3: 50}"
    own = 50 * np.pi * 0.4999 * 0.0001  # kg/m of the tube, and kg m of it about a diameter
    about = own * 0.25**2 / 2
    thin = f"tube: {{outer_mm: 500, wall_mm: 0.1, material: {light}}}"
    front, rear = (20 - 1.2 * own) / 3 - about / 1.2, (25 - 1.5 * own) / 3 - about / 1.5
    bent, flat = "[3, 1, 4.5, 2]", "[0, 0, 0, 0]"
    side, top = (bent, flat) if plane == "level" else (flat, bent)
    return f"""
title: Two slender shafts
torque_Nm: {torque}
speed_rpm: 2400
driveline:
  slopes: {{side_deg: {side}, top_deg: {top}}}
  shafts:
    - length_mm: 1200
      {thin}
      yoke_mass_kg: [0, {front}]
      polar_inertia_kgm2: 1e-7
      centre_bearing:
        from_rear_joint_mm: 0
        vertical_stiffness_N_mm: {UP}
        lateral_stiffness_N_mm: {LEVEL}
        loss_factor: {LOSS}
        {more}
    - length_mm: 1500
      {thin}
      yoke_mass_kg: [{rear}, 0]
      polar_inertia_kgm2: 1e-7
states: [{{name: here, speed_rpm: {speed}}}]
limits: protractor
"""
