"""A verdict that an assumed input turns within its range says so, with what moves it."""

import numpy as np
import pytest

from cardan.application import reader
from cardan.approval.approval import approve_driveline
from cardan.core.labels import EvaluationCondition, Part
from cardan.core.provenance import Source
from cardan.core.verdict import AssumedRange, Check, Limit
from cardan.render.i18n import Translator
from cardan.render.json_contract import check_json
from cardan.render.phrases import check_location

TRUCK = """
title: A 4x2 truck
speed_rpm: 2500
vehicle:
  drive: 4x2
  wheelbase_mm: 4800
  loads:
    gvw: {front_axle_kg: 5000, rear_axle_kg: 5500, cg_height_mm: 1300}
engine: {speed_rpm: [1000, 1600, 2500], torque_Nm: [850, 900, 700], brake_torque_Nm: 250}
gearbox: {ratios: [8.0, 4.0, 1.0], efficiency: 0.95}
tyre: {static_radius_mm: 480TYRE}
PRIME
driveline:
  points_mm: [[0, 0, 0], [1200, 0, -40], [2700, 0, -140]]
  gearbox_slope: {side_deg: 3}
  pinion_slope: {side_deg: 3}
  joints: {bearing_Td_Nm: 1500, peak_Nm: 12000}
  axle: {ratio: 5.0, efficiency: 0.96}
  shafts:
    - {tube: 120x4, centre_bearing: {from_rear_joint_mm: 140, vertical_stiffness_N_mm: 200,
       lateral_stiffness_N_mm: 120LOSS}}
    - {tube: 120x4}
duty: [{share_percent: 100, torque_Nm: 600, speed_rpm: 1500}]
states: [gvw]
limits: {profile: heavy-truck, overrides: [LIMIT]}
"""
GIVEN = {"TYRE": ", friction: 0.8", "PRIME": "prime_mover: diesel", "LOSS": ", loss_factor: 0.1"}


def approved(limit, **given):
    text = TRUCK
    for name, value in (GIVEN | given).items():
        text = text.replace(name, value)
    return approve_driveline(reader.loads(text.replace("LIMIT", limit)))


def checks(found, quantity):
    return [c for c in found.checks if c.quantity == quantity]


def limit(quantity, bound, unit="", sense=""):
    return f"{{quantity: {quantity}, maximum: {bound}{unit}{sense}, source: Here}}"


def test_friction_left_out_turns_verdict_between_its_ends():
    """Where tyres hold the torque down, its ends are those of two files that give friction."""
    quantity = "tube_shear_utilisation"
    (loose, mid, firm) = (
        max(
            c.value
            for c in checks(approved(limit(quantity, 9), TYRE=f", friction: {mu}"), quantity)
        )
        for mu in (0.6667, 0.8, 0.96)
    )
    assert loose < mid < firm
    bound = (mid + firm) / 2
    worst = max(checks(approved(limit(quantity, bound), TYRE=""), quantity), key=lambda c: c.value)
    assert (worst.grade, worst.worst_possible_grade) == ("pass", "fail")
    assert worst.within == pytest.approx((loose, firm), rel=1e-9)
    assert worst.assumed == (AssumedRange("tyre.friction", 0.6667, 0.96),)
    text = check_location(worst, Translator("en"))
    assert "with tyre.friction 0.667 to 0.96 (assumed), by that it may be exceeded" in text
    document = check_json(worst)
    assert document["may_be"] == "fail"
    assert document["assumed"] == [
        {"input": "tyre.friction", "low": 0.6667, "high": 0.96, "unit": ""}
    ]


def test_friction_given_by_file_has_no_range():
    quantity = "tube_shear_utilisation"
    mid = max(c.value for c in checks(approved(limit(quantity, 9)), quantity))
    found = approved(limit(quantity, 1.05 * mid))
    assert all(c.within is None for c in found.checks)


def test_verdict_that_holds_over_whole_range_says_nothing():
    found = approved(limit("tube_shear_utilisation", 9), TYRE="")
    assert all(c.within is None for c in checks(found, "tube_shear_utilisation"))


def test_life_with_unknown_prime_mover_lies_between_its_factors():
    """Lh is inverse to K1: 1 of a motor, 1.25 of a diesel, which stands in."""
    quantity, low = "joint_life", ", unit: h, sense: '>='"
    hours = min(c.value for c in checks(approved(limit(quantity, 1, low)), quantity)) / 3600
    bound = 1.1 * hours
    worst = min(
        checks(approved(limit(quantity, bound, low), PRIME=""), quantity), key=lambda c: c.value
    )
    assert worst.grade == "fail"
    assert worst.best_possible_grade == "pass"
    assert np.array(worst.within) / 3600 == pytest.approx([hours, 1.25 * hours], rel=1e-9)
    assert "by that it may be met" in check_location(worst, Translator("en"))


def test_loss_factor_of_rubber_turns_force_near_resonance():
    """Half the loss, more force: the worst of a file that says 0.05, at the same point or worse."""
    quantity = "centre_bearing_dynamic"
    each = {
        loss: max(
            c.value for c in checks(approved(limit(quantity, 1e5), LOSS=f", loss_factor: {loss}"),
                                    quantity)
        )
        for loss in (0.05, 0.1, 0.2)
    }  # fmt: skip
    found = checks(approved(limit(quantity, (each[0.1] + each[0.05]) / 2), LOSS=""), quantity)
    worst = max(found, key=lambda c: c.value)
    assert worst.value == pytest.approx(each[0.1], rel=1e-9)
    assert worst.worst_possible_grade == "fail"
    assert worst.within[1] == pytest.approx(each[0.05], rel=0.03)
    assert worst.within[1] <= each[0.05] * (1 + 1e-9)
    assert worst.within[0] == pytest.approx(each[0.2], rel=0.1)


def test_interval_that_crosses_a_band_may_warn_though_its_ends_pass():
    check = Check(
        quantity="torsional_resonance", line="main", when=EvaluationCondition("gear", "1"),
        part=Part("mode", 1, 2), value=0.8, within=(0.8, 1.3),
        limit=Limit(quantity="torsional_resonance", source=Source("Here"), band=(0.9, 1.1)),
    )  # fmt: skip
    assert (check.grade, check.worst_possible_grade) == ("pass", "warn")
