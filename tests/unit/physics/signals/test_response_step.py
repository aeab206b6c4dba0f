"""Order 2 per torque that steps: a doubt with the damage that a changed gain would make."""

import numpy as np
import pytest
from scipy.stats import norm

from cardan.core.units import MPa
from cardan.physics.fatigue.damage import damage_with_omission
from cardan.physics.fatigue.rainflow import half_cycles
from cardan.physics.fatigue.sn_curve import SNCurve
from cardan.physics.signals.attribution_result import (
    DOUBT_RESPONSE_STEP,
    JointAttribution,
    combine_attributions,
)
from cardan.physics.signals.joint_attribution import separate_joint_caused_stress
from cardan.physics.signals.order_tracking import rotation_from_speed
from cardan.physics.signals.response_step import damage_ratios_of_gain_step, response_step
from cardan.physics.signals.shaft_angle import ShaftAngle
from cardan.physics.signals.synthetic import GaugeStressPerCause, synthetic_recording

CURVE = SNCurve(amplitude=80 * MPa, cycles=2e6, slope=5).modified()
MIDDLE = np.arange(16) * 6.0 + 3


def damage(stress):
    return damage_with_omission(stress, rule=half_cycles, curve=CURVE)


def test_step_of_gains_is_found_and_wandering_is_none():
    rng = np.random.default_rng(0)
    wander = 1 + 0.05 * rng.normal(size=16)
    assert response_step(MIDDLE, wander.astype(complex)) is None
    step = response_step(MIDDLE, wander * np.repeat([0.8, 1.2], [10, 6]).astype(complex))
    assert step is not None
    assert step.time == 60
    assert step.factor == pytest.approx(1.5, rel=0.1)
    assert response_step(MIDDLE[:7], np.repeat([0.5, 1.5], [4, 3]).astype(complex)) is None


def test_step_within_three_standard_errors_of_the_medians_is_none():
    """Normal blocks that scatter by s about either part: s √(1/8 + 1/8) is the error of a step."""
    sides = norm.ppf((np.array([3, 6, 1, 4, 7, 0, 5, 2]) + 0.5) / 8)
    for scatter, is_found in ((0.16, True), (0.25, False)):  # three errors are 0.3 at 0.2
        level = np.repeat([-0.15, 0.15], 8) + scatter * np.tile(sides, 2)
        assert (response_step(MIDDLE, np.exp(level).astype(complex)) is not None) == is_found


def test_damage_of_a_gain_that_stepped_is_of_either_part():
    x = np.tile([0.0, 100e6, -100e6], 2000)
    shown = x * np.repeat([1.0, 2.0], x.size // 2)
    low, high = damage_ratios_of_gain_step(shown, x.size // 2, 2.0, damage=damage)
    assert low == pytest.approx(damage(x) / damage(shown), rel=1e-3)
    assert high == pytest.approx(damage(2 * x) / damage(shown), rel=1e-3)


@pytest.fixture(scope="module")
def drive():
    return synthetic_recording(
        seconds=90, rate=400, seed=6,
        gains={"S1": GaugeStressPerCause(joints=40 * MPa, events=25 * MPa, road=4 * MPa)},
    ).recording  # fmt: skip


@pytest.mark.parametrize("factor", [1.0, 0.55, 1.7])
def test_gain_that_changes_midway_is_doubted_with_what_the_damage_may_be(drive, factor):
    stress, speed, torque = drive.read_all(["S1", "shaft_speed", "torque"])
    shown = stress * MPa
    shown[shown.size // 2 :] *= factor
    angle = ShaftAngle(rotation_from_speed([speed[None]], rate=drive.rate, unit=1 / 60))
    found = separate_joint_caused_stress(
        shown, rate=drive.rate, angle=angle, torque=torque, damage=damage
    ).attribution
    steps = [dict(d.values) for d in found.doubts if d.code == DOUBT_RESPONSE_STEP.code]
    assert len(steps) == (factor != 1)
    for step in steps:
        assert step["factor"] == pytest.approx(factor, rel=0.15)
        assert step["time"] == pytest.approx(45, abs=16)  # to some blocks of 6 s
        true = damage(stress * MPa) / damage(shown)
        assert 0.8 * step["low"] <= true <= 1.25 * step["high"]


def test_long_recording_names_one_step():
    one, other = (
        JointAttribution(
            damage_share=0.5, interval=(0.4, 0.6), f_statistic=99.0,
            doubts=(DOUBT_RESPONSE_STEP.with_values(time=t),),
        )
        for t in (40.0, 400.0)
    )  # fmt: skip
    assert combine_attributions([one, other], [1.0, 1.0]).doubts == one.doubts
