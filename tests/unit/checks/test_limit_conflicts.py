"""Two makers whose requirements leave no room between them are both named."""

import pytest

from cardan.application import reader
from cardan.approval.approval import approve_driveline

LINE = """
title: A line of three joints
speed_rpm: 500
torque_Nm: 900
driveline:
  slopes: {side_deg: [4.5, 4.0, 8, 3]}
  joints: [{}, {}, JOINT]
  shafts: [{}, {}]
limits:
  profile: protractor
  overrides:
    - LIMIT
"""


def conflicts(limit, joint="{}"):
    text = LINE.replace("LIMIT", limit).replace("JOINT", joint)
    found = approve_driveline(reader.loads(text))
    return [note for note in found.notes if "leave no room between them" in note]


def test_odd_joint_of_at_least_and_at_most_half_degree_names_both_makers():
    (note,) = conflicts("{quantity: odd_joint_angle, maximum: 0.5, source: Maker B}")
    assert "joint 1" in note
    assert "Smallest joint angle at least 0.5 deg (normal 1: Dana" in note
    assert "at most 0.5 deg (Maker B)" in note


def test_wider_limit_leaves_room():
    """1.5 deg of the joint alone, 1 deg of needles that roll: room for both."""
    assert not conflicts("{quantity: odd_joint_angle, normal: 1.5, source: Maker B}")


@pytest.mark.parametrize(
    ("limit", "bounds"),
    [
        ("{quantity: joint_angle, maximum: 0.8, source: B}", ("1 deg", "0.8 deg (B)")),
        ("{quantity: odd_joint_angle, normal: 0.7, source: B}", ("1 deg", "0.7 deg (B)")),
        ("{quantity: odd_joint_angle, normal: 0.2, maximum: 0.4, source: B}",
         ("0.5 deg", "0.4 deg (B)")),
    ],
)  # fmt: skip
def test_gravest_pair_of_bounds_is_named(limit, bounds):
    """Two maxima decide before a maximum and what is normal, and those before two normal ones."""
    (note,) = conflicts(limit)
    assert all(bound in note for bound in bounds)


def test_limit_of_one_quantity_from_both_sides_is_compared():
    limit = "{quantity: torsional_acceleration, maximum: 300, source: A}\n    - "
    limit += "{quantity: torsional_acceleration, sense: '>=', maximum: 400, source: B}"
    (note,) = conflicts(limit)
    assert "at least 400 rad/s² (B)" in note
    assert "at most 300 rad/s² (A)" in note


def test_rating_of_joint_against_profile_is_compared():
    """Half a degree of needles that roll against a joint that may bend 0.4 deg."""
    (note,) = conflicts("{quantity: n_beta, normal: 1e5, source: A}", "{angle_max_deg: 0.4}")
    assert "joint 3" in note
