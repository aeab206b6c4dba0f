"""Rubber is softer hot and stiffer cold: a verdict that turns on the way says so."""

from dataclasses import replace

import numpy as np
import pytest

from cardan.application import reader
from cardan.approval.approval import approve_driveline
from cardan.approval.assumed_inputs import checks_with_assumed_ranges
from cardan.checks.rubber_stiffness import (
    results_with_rubber_stiffness,
    rows_moved_with_modes,
    with_rubber_stiffness,
)
from cardan.core.errors import InvalidFileError
from cardan.core.verdict import AssumedRange
from cardan.physics.loads.rubber_mount import MountedLine
from cardan.render.i18n import Translator
from cardan.render.phrases import check_location

TRUCK = """
title: A 4x2 truck
speed_rpm: 2500
vehicle:
  drive: 4x2
  wheelbase_mm: 4800
  loads:
    gvw: {front_axle_kg: 5000, rear_axle_kg: 9500, cg_height_mm: 1300}
engine: {speed_rpm: [1000, 1600, 2500], torque_Nm: [850, 900, 700], brake_torque_Nm: 250}
gearbox: {ratios: [8.0, 4.0, 2.4, 1.5, 1.0], efficiency: 0.95}
tyre: {static_radius_mm: 480, friction: 0.8}
prime_mover: diesel
driveline:
  points_mm: [[0, 0, 0], [1200, 0, -40], [2700, 0, -140]]
  gearbox_slope: {side_deg: 3}
  pinion_slope: {side_deg: 3}
  axle: {ratio: 5.0, efficiency: 0.96}
  shafts:
    - {tube: 120x4, centre_bearing: {from_rear_joint_mm: 140, vertical_stiffness_N_mm: VERTICAL,
       lateral_stiffness_N_mm: LATERAL, loss_factor: 0.1RANGE}}
    - {tube: 120x4, spline: {mean_radius_mm: 30, friction: 0.11}}
obstacles: [{name: beam, start_mm: [1300, -300, -200], end_mm: [1300, 300, -200], radius_mm: 20}]
states: [gvw]
limits: heavy-truck
"""


def approved(*, share: float = 1.0, more: str = ""):
    text = TRUCK.replace("VERTICAL", f"{200 * share:g}").replace("LATERAL", f"{120 * share:g}")
    return approve_driveline(reader.loads(text.replace("RANGE", more), warn=False))


def compression(found):
    return next(c for c in found.checks if c.quantity == "spline_compression_utilisation")


def test_hot_rubber_turns_compression_that_passes_at_rest():
    """METHOD 20 by hand: Pk = k (lc/L1)²/(1/L1 + 1/L2), lateral; thrust T μ/rm whatever k."""
    worst = compression(approved())
    first, last = np.hypot(1.2, 0.04), np.hypot(1.5, 0.1)
    critical = 120e3 * ((first - 0.14) / first) ** 2 / (1 / first + 1 / last)
    at_rest = 900 * 8 * 0.95 * 0.11 / 0.030 / critical
    assert worst.value == pytest.approx(at_rest, rel=0.01)  # tubes give a little too
    assert worst.within == pytest.approx((at_rest, at_rest / 0.7), rel=0.01)
    assert (worst.grade, worst.worst_possible_grade) == ("pass", "warn")
    text = check_location(worst, Translator("en"))
    assert (
        "with centre_bearing.stiffness_range 0.7 to 2 (assumed), by that it may be beyond "
        "recommended" in text
    )


def test_range_that_a_file_gives_is_no_assumption():
    worst = compression(approved(more=", stiffness_range: [0.75, 1.2]"))
    assert worst.assumed == (
        AssumedRange("centre_bearing.stiffness_range", 0.75, 1.2, is_given=True),
    )
    assert "(assumed)" not in check_location(worst, Translator("en"))
    still = approved(more=", stiffness_range: [1, 1]")
    assert all(c.within is None for c in still.checks)


def test_temperature_adds_nothing_where_a_check_fails_anyway():
    """No worse verdict is left; what would come of it is the next question."""
    (r,) = approved().line_responses
    worst = compression(approved())
    failed = replace(worst, value=1.0, within=None, assumed=())
    alone = replace(worst, within=None, assumed=())
    assert checks_with_assumed_ranges([r], [alone]) == (worst,)
    assert checks_with_assumed_ranges([r], [alone, failed]) == (alone, failed)


def test_forces_of_hot_and_cold_rubber_are_those_of_files_that_say_so():
    (r,) = approved().line_responses
    ends, more = [np.array([[0.7], [2.0]])], {"centre_bearing_travel", "clearance_on_rubber"}
    found = results_with_rubber_stiffness(r, ends, quantities=more)
    for k, share in enumerate((0.7, 2.0)):
        (own,) = approved(share=share).line_responses
        loads = own.mount_loads
        for name in ("static", "dynamic", "peak"):
            assert found[f"centre_bearing_{name}"][k] == pytest.approx(
                loads.bearing_force(name), rel=0.03
            )
        assert found["centre_bearing_travel"][k] == pytest.approx(
            loads.worst_bearing_travel.results.peak, rel=0.05
        )
        left = -loads.worst_obstacle_clearance.results.reach
        assert found["clearance_on_rubber"][k] == pytest.approx(left, abs=0.5e-3)


@pytest.mark.parametrize(
    ("wrong", "said"),
    [
        (", stiffness_range: [1.2, 2]", "must reach from 1 or less, hot, to 1 or more, cold"),
        (", stiffness_range: [0.7]", "stiffness_range"),
    ],
)
def test_range_that_leaves_out_the_stiffness_given_is_rejected(wrong, said):
    with pytest.raises(InvalidFileError, match=said):
        approved(more=wrong)


def test_rigid_bearing_has_no_range():
    text = TRUCK.replace("vertical_stiffness_N_mm: VERTICAL,", "stiffness_range: [0.7, 2]}}")
    text = text.replace("       lateral_stiffness_N_mm: LATERAL, loss_factor: 0.1RANGE}}\n", "")
    with pytest.raises(InvalidFileError, match="what is rigid has no range"):
        reader.loads(text)


def test_worst_speed_moves_with_the_mode_that_order_2_meets(monkeypatch):
    """Of modes at 1, 2 and 6 times the speed that at twice: stiffer rubber takes it 5 % up."""
    (r,) = approved().line_responses
    other, worst = with_rubber_stiffness(r, [2.0]), r.mount_loads.worst_bearing_forces["dynamic"]
    own, speed = r.mounts.mounted_line, float(worst.speed[0, 0])

    def modes(line, torque):
        factors = [1.0, 2.0, 6.0] if line is own else [1.1, 2.1, 6.0]
        return np.broadcast_to(speed * np.array(factors), (*np.shape(torque), 3))

    assert other.mounts.mounted_line is not own
    monkeypatch.setattr(MountedLine, "natural_frequencies", modes)
    _, speeds = rows_moved_with_modes(r, other, worst)
    assert sorted(set(speeds[:, 0, 0].round(6))) == pytest.approx([speed, 1.05 * speed], rel=1e-6)
