"""Joints of other kinds in the application file, and what a check makes of them."""

import numpy as np
import pytest

import cardan
from cardan.core.errors import InvalidFileError
from cardan.core.units import deg, hour, mm, rpm
from cardan.physics.kinematics.constant_velocity import (
    double_cardan_irregularity,
    tripod_orbit_radius,
)

TEXT = """\
title: Front line
speed_rpm: 2500
torque_Nm: 900
limits: van
duty: regional
driveline:
  slopes: {side_deg: [3.0, 1.0, 4.5, 2.0], top_deg: [0.0, 1.5, -0.8, 0.6]}
  joints:
    - {name: ours, kind: double cardan, peak_Nm: 2500, bearing_Td_Nm: 500, centre_distance_mm: 80,
       ball_from_rear_mm: 40, angle_max_deg: 25}
    - 1330
    - {name: theirs, kind: tripod, peak_Nm: 3000, bearing_Td_Nm: 400, rated_life_h: 3000,
       rated_speed_rpm: 500, rated_angle_deg: 4, pitch_circle_mm: 60, plunge_mm: 25,
       angle_max_deg: 20}
  shafts:
    - {length_mm: 1200, tube: 3.500x0.083in, centre_bearing: {from_rear_joint_mm: 140}}
    - {length_mm: 1500, tube: 3.500x0.083in}
"""


@pytest.fixture
def read(tmp_path):
    def of(text):
        file = tmp_path / "line.yaml"
        file.write_text(text, encoding="utf-8")
        return cardan.read(file)

    return of


def test_joint_kinds_and_ratings_are_read_from_file(read):
    of = read(TEXT).lines[0].line
    assert of.joint_kinds == ("double cardan", "cross", "tripod")
    assert of.is_cross == (0.0, 1.0, 0.0)
    tripod = of.joints[2]
    assert (tripod.pitch_radius, tripod.plunge) == pytest.approx((30 * mm, 25 * mm))
    assert tripod.rated_life == pytest.approx(3000 * hour)
    assert tripod.rated_speed == pytest.approx(500 * rpm)


def test_check_uses_joint_kinds(read):
    """One cross alone at 4.186 deg: the pinion turns as it does, and nothing pairs with it."""
    found = cardan.check(read(TEXT))
    (r,) = found.line_responses
    beta = r.joint_angles[0]
    assert r.kinematics.excitation.torsional.angle[0] == pytest.approx(beta[1], rel=1e-12)
    assert r.kinematics.approximate_excitations["ae7"].torsional.angle[0] == pytest.approx(
        beta[1], rel=1e-3
    )
    asked = {(c.quantity, c.part.number): c for c in found.checks}
    # Each own angle cap; needles that must roll, and accelerations of their own, only of the cross.
    assert asked["joint_angle", 1].limit.maximum == pytest.approx(25 * deg)
    assert asked["joint_angle", 3].limit.maximum == pytest.approx(20 * deg)
    # A cap of its own takes the place of the profile's, which is one of crosses.
    for number, own in ((1, 25.0), (3, 20.0)):
        caps = {
            (c.limit.normal, round(c.limit.maximum / deg, 9))
            for c in found.checks if (c.quantity, c.part.number) == ("joint_angle", number)
        }  # fmt: skip
        assert caps == {(None, own)}
    for quantity in ("joint_angle_min", "angle_for_speed"):
        assert {n for q, n in asked if q == quantity} == {2}
    assert not any(q == "end_angle_difference" for q, _ in asked)
    assert r.kinematics.unpaired_joints == (1,)
    assert r.kinematics.double_cardan_speed_fluctuation[0, 0] == pytest.approx(
        float(double_cardan_irregularity(beta[0], length=80 * mm, ball=40 * mm))
    )
    assert r.kinematics.tripod_orbit_radius[0, 2] == pytest.approx(
        float(tripod_orbit_radius(beta[2], radius=30 * mm))
    )
    assert np.isnan(r.kinematics.tripod_orbit_radius[0, :2]).all()
    # A tripod that plunges takes the place of a spline.
    assert asked["spline_travel_margin", 2].value == pytest.approx(25 * mm)
    assert np.isfinite(r.strength.needle_bearing_life[0, [0, 2]]).all()
    assert np.isnan(
        r.strength.needle_bearing_life[0, 1]
    )  # 1330 has no life rating in the catalogue


def test_line_of_cross_joints_pairs_joints(read):
    of = cardan.check(
        read(
            TEXT.replace("kind: double cardan", "kind: cross").replace(
                "centre_distance_mm: 80,\n       ball_from_rear_mm: 40, ", ""
            )
        )
    ).line_responses[0]
    assert of.kinematics.paired_shafts == (0,)
    assert of.kinematics.unpaired_joints == ()


@pytest.mark.parametrize(
    ("old", "new", "says"),
    [
        ("kind: tripod", "kind: tripode", "joints[3].kind: must be"),
        ("kind: tripod", "kind: cross",
         "joints[3].rated_life_h: belongs to a rzeppa or a tripod, not to a cross"),
        ("kind: double cardan", "kind: rzeppa",
         "centre_distance_mm: belongs to a double cardan, not to a rzeppa"),
        ("ball_from_rear_mm: 40", "ball_from_rear_mm: 90",
         "must be less than the distance of the crosses"),
    ],
)  # fmt: skip
def test_invalid_joint_kind_combination_is_rejected(read, old, new, says):
    with pytest.raises(InvalidFileError) as found:
        read(TEXT.replace(old, new))
    assert says in str(found.value)
