"""A flexible disc (Hardy disc) as a joint: it keeps the speed, twists, and resists its angle."""

from dataclasses import replace

import numpy as np
import pytest

from cardan.application import reader
from cardan.approval.approval import approve_driveline
from cardan.core.errors import InvalidFileError
from cardan.core.units import deg
from cardan.topics.torsion.powertrain_model import vehicle_torsion_model

LINE = """
title: A line with a disc
speed_rpm: 2500
torque_Nm: TORQUE
driveline:
  slopes: {side_deg: [3.0, 1.0, 4.5, 2.0], top_deg: [0.0, 1.5, -0.8, 0.6]}
  joints: [FIRST, SECOND, LAST]
  shafts:
    - {length_mm: 1200, tube: 100x3, centre_bearing: {from_rear_joint_mm: 0RUBBER}}
    - {length_mm: 1500, tube: 100x3SPLINE}
limits: van
"""
DISC = "{kind: flexible disc, angle_max_deg: 5, peak_Nm: 3000, speed_max_rpm: 5000MORE}"
CROSS = "{peak_Nm: 3000}"


def line(*, torque=900, first=CROSS, second=CROSS, last=CROSS, rubber="", spline=", spline: {}"):
    text = LINE.replace("TORQUE", f"{torque}").replace("RUBBER", rubber).replace("SPLINE", spline)
    for place, joint in (("FIRST", first), ("SECOND", second), ("LAST", last)):
        text = text.replace(place, joint)
    return approve_driveline(reader.loads(text, warn=False))


def disc(more=""):
    return DISC.replace("MORE", more)


def forces(found):
    (r,) = found.line_responses
    of = r.rigid_loads.joint_loads.bearing_forces
    return np.linalg.norm(of.static[0, 0]), of.dynamic[0, 0]


def test_disc_turns_and_carries_torque_as_a_constant_velocity_joint():
    """Cross-disc-cross, a kN m without twist: 5.1302 N static, 2.8143 of order 2, 1.65393 deg.

    At a thousandth of it, where tubes do not twist: confirmed by virtual work to 2e-7.
    """
    found = line(torque=1, second=disc())
    assert forces(found) == pytest.approx((5.1302e-3, 2.8143e-3), rel=2e-4)
    (r,) = found.line_responses
    assert np.degrees(r.kinematics.excitation.torsional.angle[0]) == pytest.approx(
        1.65393, rel=1e-5
    )


def test_limits_of_crosses_are_not_asked_of_a_disc():
    found = line(second=disc())
    asked = {(c.quantity, c.part.number): c for c in found.checks}
    assert asked["joint_angle", 2].limit.maximum == pytest.approx(5 * deg)
    assert asked["joint_angle", 2].grade == "pass"
    assert asked["joint_torque_utilisation", 2].value == pytest.approx(900 / 3000, rel=0.01)
    for quantity in ("joint_angle_min", "angle_for_speed", "joint_life"):
        assert (quantity, 2) not in asked
    unrated = line(second="{kind: flexible disc}")
    silent = {u.quantity: u.missing_inputs for u in unrated.coverage.unevaluated
              if u.part.number == 2}  # fmt: skip
    assert silent["joint_angle"] == ("angle_max_deg of the joint",)


@pytest.mark.parametrize("rubber", ["", ", stiffness_N_mm: 150"])
def test_disc_that_resists_its_angle_loads_the_bearing_without_torque(rubber):
    """Statics by hand: 30 N m/deg at the angle of joint 1 turn shaft 1, held 1200 mm behind."""
    first, bend = disc(", bending_stiffness_Nm_deg: 30"), 30 / deg
    found = line(torque=1e-6, first=first, rubber=rubber)
    (r,) = found.line_responses
    by_hand = bend * r.joint_angles[0, 0] / 1.2
    assert np.degrees(r.joint_angles[0, 0]) == pytest.approx(2.5, abs=0.01)
    assert r.mount_loads.bearing_force("static")[0, 0] == pytest.approx(by_hand, rel=1e-6)
    # Shaft 1 lies above the gearbox's line (it slopes less), so it is pushed back down and left.
    force = r.rigid_loads.joint_loads.bearing_forces.static[0, 0]
    assert force[2] < 0 > force[1]
    assert r.rigid_loads.secondary_couples[1][0, 0] == pytest.approx(by_hand * 1.2, rel=1e-6)


def test_disc_twists_the_yokes_behind_it():
    """900 N m turn 100 N m/deg by 9 deg: order 2 is that of yokes welded so much back."""
    soft = line(second=disc(", torsional_stiffness_Nm_deg: 100"))
    (r,) = soft.line_responses
    tubes = sum(s.torsional_flexibility for s in r.line.shafts)
    text = LINE.replace("- {length_mm: 1500,", f"- {{length_mm: 1500, phase_deg: {-9},")
    for place, value in {"TORQUE": "900", "FIRST": CROSS, "SECOND": disc(), "LAST": CROSS,
                         "RUBBER": "", "SPLINE": ", spline: {}"}.items():  # fmt: skip
        text = text.replace(place, value)
    assert forces(soft) == pytest.approx(forces(approve_driveline(reader.loads(text))), rel=1e-9)
    assert 900 * tubes < 3 * deg  # the disc gives most


def test_disc_is_in_series_with_its_shaft_in_torsion():
    """1/k = 1/k_tube + 1/k_disc of the shaft behind it; the last one's with the pinion."""
    text = reader.loads(
        LINE.replace("TORQUE", "900").replace("RUBBER", "").replace("SPLINE", ", spline: {}")
        .replace("FIRST", disc(", torsional_stiffness_Nm_deg: 400")).replace("SECOND", CROSS)
        .replace("LAST", disc(", torsional_stiffness_Nm_deg: 500")), warn=False,
    )  # fmt: skip
    parts = vehicle_torsion_model(text)
    rigid = replace(text.lines[0], line=replace(text.lines[0].line, joints=()))
    without = vehicle_torsion_model(replace(text, lines=(rigid,)))
    k, k0 = (
        dict(zip([str(p) for _, p in m.closed.springs], m.closed.line.stiffness[0, 0], strict=True))
        for m in (parts, without)
    )
    assert k["shaft 1"] == pytest.approx(1 / (1 / k0["shaft 1"] + deg / 400), rel=1e-12)
    assert k["pinion"] == pytest.approx(1 / (1 / k0["pinion"] + deg / 500), rel=1e-12)
    assert k["shaft 2"] == k0["shaft 2"]


SPRUNG = """
title: A van on discs
vehicle: {drive: 4x2, wheelbase_mm: 3500, loads: {empty: {front_axle_kg: 1100, rear_axle_kg: 900},
  gvw: {front_axle_kg: 1300, rear_axle_kg: 2000}}}
suspension:
  spring: {rates_N_mm: [60]}
  springs_per_axle: 2
  unsprung_mass_kg: 150
  jounce_deflection_mm: 220
  linkage: {front_half_length_mm: 700, angle_deg: 4}
  reference: gvw
driveline:
  points_mm: [[0, 0, 0], [1500, 0, -60]]
  gearbox_slope: {side_deg: 3}
  pinion_slope: {side_deg: 2}
  joints: DISC
  shafts: [{tube: 70x2}]
axle: {ratio: 4.1}
tyre: {static_radius_mm: 330}
states: [empty, gvw]
limits: van
"""


def test_axial_limit_of_discs_takes_the_place_of_a_spline():
    """Without a spline two discs of 2 mm share the last shaft's change of length: over 4 mm."""
    found = approve_driveline(
        reader.loads(SPRUNG.replace("DISC", disc(", plunge_mm: 2")), warn=False)
    )
    (r,) = found.line_responses
    change = r.layout.lengths[0, -1] - r.layout.lengths[1, -1]
    own = [c for c in found.checks if c.quantity == "disc_axial_utilisation" and c.state == "empty"]
    assert [c.part.number for c in own] == [1, 2]
    for c in own:
        assert c.value == pytest.approx(abs(change) / 0.004, rel=1e-9)
        assert c.limit.maximum == 1
    assert not any(u.quantity == "spline_travel_margin" for u in found.coverage.unevaluated)
    unknown = approve_driveline(reader.loads(SPRUNG.replace("DISC", disc()), warn=False))
    (needs,) = {u.missing_inputs for u in unknown.coverage.unevaluated
                if u.quantity == "disc_axial_utilisation"}  # fmt: skip
    assert needs == ("plunge_mm of the flexible disc",)


@pytest.mark.parametrize(
    ("joint", "said"),
    [
        ("{kind: cross, torsional_stiffness_Nm_deg: 100}",
         "torsional_stiffness_Nm_deg: belongs to a flexible disc, not to a cross"),
        ("{kind: flexible disc, bearing_Td_Nm: 100}", "not to a flexible disc"),
        ("{kind: hardy disc}", "flexible disc"),
    ],
)  # fmt: skip
def test_keys_of_other_kinds_are_rejected(joint, said):
    with pytest.raises(InvalidFileError, match=said):
        line(second=joint)
