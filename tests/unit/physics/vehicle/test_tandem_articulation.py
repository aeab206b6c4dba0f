"""Each axle of a tandem rides on its own links, at its own travel."""

from math import cos, radians, sin, sqrt

import numpy as np
import pytest

from cardan.application import reader
from cardan.core.units import mm
from cardan.physics.vehicle.state_demand import line_state_demand, resolve_line_references

TANDEM = """
title: A 6x4 tandem
speed_rpm: 2100
vehicle:
  drive: 6x4
  wheelbase_mm: 5200
  loads:
    gvw: {front_axle_kg: 7400, rear_axle_kg: 20600, cg_height_mm: 1750}
engine: {speed_rpm: [900, 2100], torque_Nm: [1700, 1500]}
gearbox: {ratios: [11.3, 1.0], efficiency: 0.93}
tyre: {static_radius_mm: 500, friction: 0.7}
suspension:
  spring: {rates_N_mm: [420, 610], contact_mm: 70}
  unsprung_mass_kg: 1150
  linkage: {LINK}
  windup_stiffness_kNm_deg: 34
  reference: gvw
drivelines:
  main:
    points_mm: [[0, 0, 0], [1010, 0, -52], [2290, 25, -158]]
    gearbox_slope: {side_deg: 4.4}
    pinion_slope: {side_deg: 3.5}
    axle: {ratio: 4.9, pinion: {ahead_mm: 540, above_mm: 180}}OWN
    shafts:
      - {tube: 120x6, centre_bearing: {from_rear_joint_mm: 155}}
      - {tube: 120x6, spline: {plunge_mm: 60, draw_mm: 50}}
  inter-axle:
    points_mm: [[0, 0, 0], [600, -10, -62]]
    gearbox_slope: {side_deg: 3.5}
    pinion_slope: {side_deg: 3.1}
    output_joint: {behind_mm: 340, above_mm: 110}
    torque_share: 0.5
    load_share: 0.5
    axle: {ratio: 4.9, pinion: {ahead_mm: 400, above_mm: 55}}
    shafts: [{tube: 120x4, spline: {plunge_mm: 45, draw_mm: 45}}]
states:
  - gvw
  - {name: up, kind: gvw, articulation_mm: 40}
  - {name: down, kind: gvw, articulation_mm: -40}
limits: heavy-truck
"""
LINK = "radius_mm: 640, angle_deg: 2"


def inter_axle_demand(link=LINK, own=""):
    text = TANDEM.replace("LINK", link).replace("OWN", own)
    application = reader.loads(text)
    return line_state_demand(resolve_line_references(application, application.lines[1]))


def joint_on_axle(joint, arm, travel, *, angle, pitch_rate=0.0, radius=640.0):
    """Return where a joint (x, z) mm goes with its axle, worked out on paper."""
    sine = sin(radians(angle)) - travel / radius
    ahead = radius * (sqrt(1 - sine**2) - cos(radians(angle)))
    turn = radians(pitch_rate * travel / 1000)
    x, z = arm
    return (
        joint[0] + ahead + x * cos(turn) + z * sin(turn) - x,
        joint[1] + travel + z * cos(turn) - x * sin(turn) - z,
    )


def test_articulation_moves_inter_axle_spline_by_each_axles_own_link():
    """By hand: links of 640 mm at 2 deg move the axles 2.80 mm apart on their way."""
    travel = inter_axle_demand().spline_travel / mm
    assert travel == pytest.approx([0, 10.65, -0.13], abs=0.006)


OWN = """
    suspension:
      spring: {rates_N_mm: [420, 610], contact_mm: 70}
      unsprung_mass_kg: 1150
      linkage: {radius_mm: 640, angle_deg: 12, pitch_rate_deg_mm: 0.03}
      reference: gvw"""
"""Of the forward axle alone, on steeper links."""


@pytest.mark.parametrize(("own", "angle"), [("", 2), (OWN, 12)])
def test_each_tandem_axle_pitches_by_its_own_travel_on_its_own_link(own, angle):
    """The pinion and the output joint ahead of it against arcs and turns on paper."""
    rate = 30.0  # deg per metre of rise
    found = inter_axle_demand(f"{LINK}, pitch_rate_deg_mm: {rate / 1000:g}", own).layout.points / mm
    for k, lift in ((1, 40.0), (2, -40.0)):
        first = joint_on_axle((0, 0), (340, 110), lift, angle=angle, pitch_rate=rate)
        last = joint_on_axle((600, -62), (-400, 55), -lift, angle=2, pitch_rate=rate)
        np.testing.assert_allclose(found[k, 0, [0, 2]], first, atol=1e-9)
        np.testing.assert_allclose(found[k, -1, [0, 2]], last, atol=1e-9)
