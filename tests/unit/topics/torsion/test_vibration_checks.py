"""Each limit of a vibration study applies to the numbers of its own line, joint and rating."""

from types import SimpleNamespace

import numpy as np
import pytest

from cardan.core.labels import EvaluationCondition, Part
from cardan.topics.torsion import vibration_checks

SIZE = SimpleNamespace(reversing_torque=100.0, peak_torque=1000.0)
SPRINGS = [(name, part) for name in ("main", "inter-axle") for part in (
    Part("shaft", 1), Part("pinion"))]  # fmt: skip


@pytest.fixture
def study():
    """Two lines of two joints, two gears and three states; every number another one."""
    of_springs = np.arange(2 * 3 * 4, dtype=float).reshape(2, 3, 4) + 1
    driven = SimpleNamespace(
        ranges=np.ones((2, 3, 2)), powertrain=SimpleNamespace(springs=SPRINGS),
        worst_vibratory_torque=of_springs, peak_torque=-1000 * of_springs[::-1],
        vibratory_ratio=of_springs / 50,
        acceleration=np.arange(2 * 3 * 2, dtype=float).reshape(2, 3, 2),
    )  # fmt: skip
    slipping = SimpleNamespace(**{**vars(driven), "ranges": np.full((2, 3, 2), np.nan)})
    return SimpleNamespace(
        closed=driven, slipping=slipping,
        gears=[EvaluationCondition("gear", name) for name in ("1", "2")],
        lines=[
            SimpleNamespace(line=SimpleNamespace(name=name, joint_count=2, joints=(SIZE, SIZE)))
            for name in ("main", "inter-axle")
        ],
    )  # fmt: skip


def test_acceleration_is_that_of_each_lines_own_pinion(study):
    found = [(r.line, r.when.name, r.value) for r in vibration_checks._accelerations(study)]
    expected = [("main", "1", 4.0), ("main", "2", 10.0), ("inter-axle", "1", 5.0)]
    assert found == [*expected, ("inter-axle", "2", 11.0)]


def test_vibratory_torque_is_over_the_fatigue_rating_and_peak_torque_over_the_peak_one(study):
    """Largest of the states, at the spring behind each joint of each line."""
    rated = vibration_checks._rated(study, rating="reversing_torque")
    values = {(r.line, r.part.number, r.when.name): r.value for r in rated}
    assert len(values) == 8
    assert values["main", 1, "1"] == pytest.approx(0.09)
    assert values["main", 2, "2"] == pytest.approx(0.22)
    assert values["inter-axle", 2, "1"] == pytest.approx(0.12)
    peak = {
        (r.line, r.part.number, r.when.name): r.value
        for r in vibration_checks._rated(study, rating="peak_torque")
    }
    assert peak["main", 1, "2"] == pytest.approx(-1.0)
    assert peak["inter-axle", 2, "1"] == pytest.approx(-16.0)


def test_reversal_is_the_largest_of_a_lines_own_springs(study):
    found = {(r.line, r.when.name): r.value for r in vibration_checks._reversals(study)}
    assert found["main", "1"] == pytest.approx(10 / 50)
    assert found["inter-axle", "2"] == pytest.approx(24 / 50)


def started(capacity: float):
    """A launch in first gear with other torques in each spring."""
    peak = np.array([100.0, 200.0, 300.0, 400.0])
    return SimpleNamespace(
        launch=SimpleNamespace(capacity=capacity, gear="1", ramp=0.25),
        springs=SPRINGS, peak_torque=peak, peak_range=np.stack([0.9 * peak, 1.2 * peak]),
        lowest_torque=-0.5 * peak, reversal_range=np.stack([0.4 + 0 * peak, 0.6 + 0 * peak]),
        assumed=(),
    )  # fmt: skip


def test_peak_of_a_launch_is_of_the_spring_behind_each_joint(study):
    study.launches, study.application = [started(0.9)], SimpleNamespace(launches=())
    rows = list(vibration_checks._launch_peaks(study))
    assert [r.value for r in rows] == pytest.approx([0.1, 0.2, 0.3, 0.4])
    assert rows[1].within == pytest.approx((0.18, 0.24))
    reversals = list(vibration_checks._launch_reversals(study))
    assert [r.value for r in reversals] == pytest.approx([0.5, 0.5])


@pytest.mark.parametrize(("capacity", "requested", "held"), [
    (1.0, False, True), (1.5, False, False), (1.5, True, True),
])  # fmt: skip
def test_clutch_that_is_dropped_is_held_to_limits_if_the_file_requests_it(
    study, capacity, requested, held
):
    study.launches = [started(capacity)]
    study.application = SimpleNamespace(launches=("dropped",) if requested else ())
    assert bool(list(vibration_checks._launch_peaks(study))) == held
