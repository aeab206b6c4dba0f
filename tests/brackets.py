"""A line of two shafts and the bracket that carries it, as files: what a bracket's tests add to."""

LINE = """title: Two-piece line
speed_rpm: 2500
torque_Nm: 8000
driveline:
  slopes: {side_deg: [3.0, 1.0, 4.5, 2.0], top_deg: [0.0, 1.5, -0.8, 0.6]}
  shafts:
    - {length_mm: 1200, tube: 120x4, centre_bearing: {from_rear_joint_mm: 140}}
    - {length_mm: 1500, tube: 120x4}
"""
BRACKET = """bracket:
  u_shape: {seat_diameter_mm: 100, width_mm: 70, thickness_mm: 6, height_mm: 90, flange_mm: 55,
            bend_radius_mm: 10, bolt_diameter_mm: 11, bolt_pitch_mm: 40}
"""
"""Each file goes on with the bracket's keys, two spaces in."""
