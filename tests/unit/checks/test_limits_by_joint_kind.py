"""A limit is asked of the kind of joint that it was written for, and of no other."""

import numpy as np
import pytest

from cardan.application import reader
from cardan.approval.approval import approve_driveline
from cardan.approval.driveline_study import evaluate_limits, missing_inputs_of
from cardan.checks.quantities.registry import LINE_QUANTITIES

KINDS = ("cross", "double cardan", "rzeppa", "tripod", "flexible disc")

LINE = """
title: One joint of each kind
speed_rpm: 2000
torque_Nm: 500
duty: regional
driveline:
  points_mm: [[0, 0, 0], [900, 0, -40], [1800, 0, -150], [2800, 0, -180], [3600, 0, -220]]
  gearbox_slope: {side_deg: 5}
  pinion_slope: {side_deg: 4}
  joints:
    - {kind: cross}
    - {kind: double cardan}
    - {kind: rzeppa}
    - {kind: tripod}
    - {kind: flexible disc}
  shafts:
    - {tube: 120x4, centre_bearing: {from_rear_joint_mm: 140}}
    - {tube: 120x4, centre_bearing: {from_rear_joint_mm: 140}}
    - {tube: 120x4, centre_bearing: {from_rear_joint_mm: 140}}
    - {tube: 120x4}
limits:
  profile: heavy-truck
  overrides:
"""
CARRIES = "peak_Nm: 9000, reversing_Nm: 4000, bearing_Td_Nm: 2000, angle_max_deg: 30"
RATED = f"{CARRIES}, n_beta_max_deg_min: 20000, speed_max_rpm: 4000"
ROLLS = "rated_life_h: 5000, rated_speed_rpm: 100"
CROSS = "cross_width_mm: 120, cup_length_mm: 25, cup_diameter_mm: 48"
BALL = "centre_distance_mm: 80, ball_from_rear_mm: 40"
SIZES = {
    "cross": f"{CARRIES}, {CROSS}",
    "double cardan": f"{RATED}, {CROSS}, {BALL}",
    "rzeppa": f"{RATED}, {ROLLS}, pitch_circle_mm: 60",
    "tripod": f"{RATED}, {ROLLS}, pitch_circle_mm: 60, plunge_mm: 25",
    "flexible disc": f"{RATED}".replace("bearing_Td_Nm: 2000, ", ""),
}

JOINT_QUANTITIES = (
    "joint_angle", "joint_angle_min", "compound_angle", "odd_joint_angle", "angle_for_speed",
    "n_beta", "joint_speed", "joint_torque_utilisation", "joint_fatigue_utilisation",
    "joint_life", "joint_swing", "joint_orbit", "journal_force", "cup_pressure", "couple_ahead",
    "couple_behind", "joint_force", "joint_position", "side_angle", "top_angle",
)  # fmt: skip
EVERY = frozenset(KINDS)
CROSSES = frozenset({"cross", "double cardan"})
BEARINGS = EVERY - {"flexible disc"}

ASKED = {
    # A profile's limits of these are those of crosses: others have their own ratings.
    "joint_angle": {"cross"}, "compound_angle": {"cross"},
    "n_beta": {"cross"}, "joint_speed": {"cross"},
    # Needles must roll, and a cross speeds up and slows down its shaft.
    "joint_angle_min": {"cross"}, "odd_joint_angle": {"cross"}, "angle_for_speed": {"cross"},
    # Ratings of the joint's own, whatever its kind.
    "joint_torque_utilisation": EVERY, "joint_fatigue_utilisation": EVERY,
    "joint_life": BEARINGS,
    # Parts that only some have.
    "journal_force": CROSSES, "cup_pressure": CROSSES,
    "joint_swing": {"double cardan"}, "joint_orbit": {"tripod"},
    # Where it lies and what it carries.
    "couple_ahead": EVERY, "couple_behind": EVERY, "joint_force": EVERY,
    "joint_position": EVERY, "side_angle": EVERY, "top_angle": EVERY,
}  # fmt: skip
"""Which kinds of joint a limit of a profile is asked of, where all ratings are given."""

OWN_RATING = {
    "joint_angle": "angle_max_deg of the joint",
    "compound_angle": "angle_max_deg of the joint",
    "n_beta": "n_beta_max_deg_min of the joint",
    "joint_speed": "speed_max_rpm of the joint",
}


@pytest.fixture(scope="module")
def responses():
    """One line with nothing known of its joints, and one with all ratings."""
    limits = "".join(
        f"    - {{quantity: {key}, normal: 1, source: Here}}\n" for key in JOINT_QUANTITIES
    )
    bare = LINE + limits
    full = bare
    for kind, rated in SIZES.items():
        full = full.replace(f"{{kind: {kind}}}", f"{{kind: {kind}, {rated}}}")
    return tuple(approve_driveline(reader.loads(t)).line_responses[0] for t in (bare, full))


def asked_kinds(r, key, *, answered):
    """Return kinds that the profile's own limit of a quantity asks, with or without an answer."""
    found = {}
    for q in evaluate_limits(r, quantities={key}):
        if str(q.limit.source) != "Here":
            continue
        for k, part in enumerate(q.parts):
            if part.kind == "joint" and q.asks[0, k] and np.isfinite(q.values[0, k]) == answered:
                found[KINDS[part.number - 1]] = (q, k)
    return found


def test_every_joint_quantity_of_line_is_listed_here(responses):
    joints = {
        key for key, q in LINE_QUANTITIES.items()
        if any(part.kind == "joint" for part in q.parts_of(responses[1]))
    }  # fmt: skip
    assert joints - set(JOINT_QUANTITIES) == {"joint_dynamic"}  # asked by other parts of the line


@pytest.mark.parametrize("key", JOINT_QUANTITIES)
def test_profile_limit_is_asked_of_its_kinds_of_joint(key, responses):
    _, rated = responses
    assert set(asked_kinds(rated, key, answered=True)) == set(ASKED[key])
    assert not asked_kinds(rated, key, answered=False)


@pytest.mark.parametrize("key", OWN_RATING)
def test_joint_without_own_rating_is_not_answered_by_limit_of_cross(key, responses):
    bare, _ = responses
    silent = asked_kinds(bare, key, answered=False)
    assert set(silent) == EVERY - {"cross"}
    for q, k in silent.values():
        assert OWN_RATING[key] in list(missing_inputs_of(bare, q, 0, k))


def test_half_critical_band_looks_at_angles_of_crosses_alone():
    text = LINE.replace("  overrides:\n", "  overrides: []\n")
    straight = text.replace("{side_deg: 5}", "{side_deg: 2.6}")
    for kind, asks in (("cross", True), ("rzeppa", False)):
        r = approve_driveline(
            reader.loads(straight.replace("kind: double cardan", f"kind: {kind}"))
        ).line_responses[0]
        assert r.joint_angles[0, 1] > np.radians(3)
        assert r.joint_angles[0, 0] < np.radians(3)
        (band,) = evaluate_limits(r, quantities={"half_critical_band"})
        assert band.asks.any() == asks


JEEP = """
title: Double cardan at the transfer case
speed_rpm: 2800
torque_Nm: 900
driveline:
  slopes: {side_deg: [4.5, 18.25, 17.0]}
  joints: [{kind: double cardan}, {}]
  shafts: [{}]
limits: PROFILE
"""


@pytest.mark.parametrize(
    "profile", ["protractor", "heavy-truck", "j3311", "meritor", "spicer", "van", "medium-truck"]
)
def test_largest_angle_of_cross_is_not_asked_of_unrated_double_cardan(profile):
    found = approve_driveline(reader.loads(JEEP.replace("PROFILE", profile)))
    assert found.verdict == "incomplete"
    asked = [c for c in found.checks if c.part.number == 1 and "angle" in c.quantity]
    assert not asked
    (missed,) = {
        u.missing_inputs for u in found.coverage.unevaluated
        if u.part.number == 1 and u.quantity in ("joint_angle", "compound_angle")
    }  # fmt: skip
    assert missed == ("angle_max_deg of the joint",)


def test_rated_double_cardan_is_held_to_its_rating():
    text = JEEP.replace("{kind: double cardan}", "{kind: double cardan, angle_max_deg: 13}")
    found = approve_driveline(reader.loads(text.replace("PROFILE", "protractor")))
    (check,) = (c for c in found.checks if c.quantity == "joint_angle" and c.part.number == 1)
    assert check.grade == "fail"
    assert check.limit.maximum == pytest.approx(np.radians(13))


def test_each_cross_of_double_cardan_bends_half_its_angle(responses):
    """F = T / (a cos(β/2)), with a = 120 - 25 mm; of the cross ahead of it the whole angle."""
    _, rated = responses
    force = LINE_QUANTITIES["journal_force"].values(rated)[0, :2]
    expected = 500 / 0.095 / np.cos(rated.joint_angles[0, :2] * [1, 0.5])
    assert force == pytest.approx(expected, rel=0.01)  # the first makes the second swing by 0.2 %


def test_profile_without_angle_limit_says_that_nothing_asks_the_angle():
    found = approve_driveline(reader.loads(JEEP.replace("PROFILE", "elbe")))
    assert any("angle of joint 1 of line main is not evaluated" in n for n in found.notes)
