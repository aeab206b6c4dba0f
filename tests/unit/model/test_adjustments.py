"""What may be moved goes where its words say: up, to the right, nose up, turned right-handed.

By the frame of METHOD: x rearward, y to the right, z up; slopes down to the rear positive.
"""

from dataclasses import replace
from math import cos, radians, sin

import numpy as np
import pytest
import yaml
from repository import EXAMPLES

from cardan.application import reader
from cardan.application.overrides import change
from cardan.approval.applied_adjustments import (
    AppliedAdjustment,
    allowed_adjustments,
    corrected_application,
    response_with_adjustments,
)
from cardan.approval.approval import approve_driveline
from cardan.checks.line_response import compute_line_response
from cardan.core.units import deg, mm
from cardan.model.adjustments import permitted_adjustments_by_name
from cardan.model.application import PermittedAdjustment
from cardan.physics.vehicle.state_demand import line_state_demand, resolve_line_references
from cardan.render.i18n import ENGLISH
from cardan.topics.design.corrections import find_corrections
from cardan.topics.design.phrases import helpful_adjustment_phrases
from cardan.topics.design.sensitivity import check_sensitivities
from cardan.topics.variants.evaluation import VariantEvaluator, build_variants

CHAIN = """
title: Three shafts
speed_rpm: 2400
torque_Nm: 8000
driveline:
  slopes: {side_deg: [3.0, 1.0, 4.5, 2.0, 3.0], top_deg: [0.0, 1.5, -0.8, 0.6, 0.0]}
  shafts:
    - {length_mm: 1200, tube: 120x4, phase_deg: 0, centre_bearing: {from_rear_joint_mm: 140}}
    - {length_mm: 1100, tube: 120x4, phase_deg: 15, centre_bearing: {from_rear_joint_mm: 140}}
    - {length_mm: 1500, tube: 120x4, phase_deg: 90}
limits: protractor
"""


@pytest.fixture(scope="module")
def line():
    application = reader.loads(CHAIN)
    return compute_line_response(
        application, line_state_demand(resolve_line_references(application, application.lines[0]))
    )


def moved(line, what, part, amount):
    """The line with one thing moved, and where its joints have gone."""
    one = PermittedAdjustment(adjustment_key=what, part=part, low=-1.0, high=1.0)
    found = response_with_adjustments(line, (one,), np.array([[amount]]))
    return found, (found.layout.points - line.layout.points)[0, 0]


@pytest.mark.parametrize("bearing", [1, 2])
@pytest.mark.parametrize(("what", "axis"), [("bearing_height", 2), ("bearing_side", 1)])
def test_bearing_adjustment_moves_bearing_and_its_joint(line, what, axis, bearing):
    """The joint behind bearing k is joint k + 1; those ahead of the bearing stay."""
    _, gone = moved(line, what, bearing, 10 * mm)
    assert np.all(gone[:bearing] == 0)
    way = gone[bearing]
    assert way[axis] > 10 * mm  # it sits behind the bearing, on a shaft that tips
    assert abs(way[3 - axis]) < 1 * mm


def test_positive_shim_raises_pinion_nose(line):
    """What faces forward and rises slopes down to the rear."""
    found, _ = moved(line, "shim", 1, 1 * deg)
    assert found.layout.side[0, 0, -1] - line.layout.side[0, -1] == pytest.approx(1 * deg)


@pytest.mark.parametrize("shaft", [1, 2, 3])
def test_phase_adjustment_equals_phase_in_file(line, shaft):
    address = f"driveline.shafts[{shaft}].phase_deg"
    installed = (0.0, 15.0, 90.0)[shaft - 1]
    written = change(line.application, {address: installed + 30})
    by_file = compute_line_response(
        written, line_state_demand(resolve_line_references(written, written.lines[0]))
    )
    found, gone = moved(line, "phase", shaft, 30 * deg)
    assert not gone.any()
    assert found.phases[0, 0] == pytest.approx(by_file.phases)
    angle = found.kinematics.excitation.torsional.angle[0, 0]
    assert angle == pytest.approx(by_file.kinematics.excitation.torsional.angle[0], rel=1e-12)
    assert abs(angle - line.kinematics.excitation.torsional.angle[0]) > 1e-5


def test_adjustment_cost_is_share_of_range_in_its_direction():
    """5 mm down of 10, and of 20 up; a turned yoke counts half, whichever way."""
    height = PermittedAdjustment(
        adjustment_key="bearing_height", part=1, low=-10 * mm, high=20 * mm
    )
    assert AppliedAdjustment(adjustable=height, amount=-5 * mm).cost == pytest.approx(0.5)
    assert AppliedAdjustment(adjustable=height, amount=5 * mm).cost == pytest.approx(0.25)
    yoke = PermittedAdjustment(adjustment_key="phase", part=1, low=0.0, high=90 * deg)
    assert AppliedAdjustment(adjustable=yoke, amount=-90 * deg).cost == 0.5


def test_phase_range_counts_from_aligned_yokes():
    """A range of phases counts from the aligned yoke: 90 deg installed turns by 0 or by -90."""
    text = """
title: One shaft
speed_rpm: 2500
torque_Nm: 3000
driveline:
  slopes: {side_deg: [4.0, 1.0, 4.0]}
  shafts: [{length_mm: 1200, tube: 100x3, phase_deg: 90}]
limits: protractor
adjust: {phase_deg: {1: [0, 90]}}
"""
    turned = {
        round(m.amount / deg, 6)
        for p in find_corrections(reader.loads(text))
        for m in p.adjustments
    }
    assert turned == {-90}


def test_single_correction_is_given_in_helpful_direction():
    """A nose that is 1.5 deg too high: down a degree wins, up a degree loses."""
    text = """
title: One shaft
speed_rpm: 2500
driveline: {slopes: {side_deg: [4.0, 2.0, 5.5]}, shafts: [{length_mm: 1200, tube: 100x3}]}
adjust: {shim_deg: [-4, 4]}
limits: [{quantity: joint_angle, normal: 3, source: us}]
"""
    (one,) = check_sensitivities(approve_driveline(reader.loads(text)))
    (said,) = helpful_adjustment_phrases(one, ENGLISH)
    assert said == "pinion angle -1° (shim) gives 2.500"


def test_single_corrections_are_given_for_warnings():
    """Back is down and forth is up, by the step that is told; the gain is in margin."""
    tight = CHAIN.replace("limits: protractor", "limits: [{quantity: joint_angle, normal: 2, "
                          "unit: deg, source: us}]")  # fmt: skip
    approval = approve_driveline(reader.loads(tight))
    assert approval.verdict == "warn"
    found = check_sensitivities(approval)
    assert found
    (response,) = approval.line_responses
    for one in found:
        for effect in one.effects:
            both = {}
            for way, amount in (("back", effect.low), ("forth", effect.high)):
                there = response_with_adjustments(
                    response, (effect.adjustable,), np.array([[amount]])
                )
                k = int(one.check.part.number) - 1
                both[way] = there.joint_angles[0, 0, k]
            assert (effect.back, effect.forth) == pytest.approx((both["back"], both["forth"]))
            best = max(1 - both[way] / (2 * deg) for way in both)
            assert one.best_margin_gain(effect) == pytest.approx(best - one.check.margin)


@pytest.mark.slow
@pytest.mark.parametrize(("shafts", "choices"), [(3, 8), (4, 5), (7, 8)])
def test_number_of_phase_choices_is_limited(shafts, choices):
    """Five shafts took a minute: 32 choices of their yokes, each a search of its own."""
    hung = "    - {length_mm: 1100, tube: 120x4, centre_bearing: {from_rear_joint_mm: 140}}\n"
    slopes = ", ".join(["3.0", "1.0"] * 5)[: 5 * (shafts + 2) - 2]
    text = f"""
title: Many shafts
speed_rpm: 2400
torque_Nm: 8000
driveline:
  slopes: {{side_deg: [{slopes}]}}
  shafts:
{hung * (shafts - 1)}    - {{length_mm: 1500, tube: 120x4}}
limits: protractor
"""
    told = []
    stepless = ("bearing_height", "bearing_side", "shim")
    find_corrections(reader.loads(text), hold=stepless, tell=lambda *at: told.append(at))
    assert told == [(k, choices) for k in range(choices)]


def test_default_adjustment_ranges_match_documentation(line):
    """docs/fix.md: bearings by 30 mm, the axle by 3 deg; packing of 5 mm, wedges of 0.5 deg."""
    free = permitted_adjustments_by_name([line.line])
    for name in ("bearing_height_mm[1]", "bearing_height_mm[2]"):
        a = free[name]
        assert (a.low, a.high, a.step) == pytest.approx((-30 * mm, 30 * mm, 5 * mm))
    a = free["shim_deg"]
    assert (a.low, a.high, a.step) == pytest.approx((-3 * deg, 3 * deg, 0.5 * deg))


TANDEM = EXAMPLES / "tandem-6x4.yaml"


def shimmed_by_hand(turn):
    """The tandem's file with its forward axle turned, the pinion's nose up by so many degrees."""
    table = yaml.safe_load(TANDEM.read_text("utf-8"))
    main, between = (table["drivelines"][name] for name in ("main", "inter-axle"))

    def swung(back, up):
        c, s = cos(radians(turn)), sin(radians(turn))
        return back * c + up * s, up * c - back * s

    pinion = main["axle"]["pinion"]
    x, z = -pinion["ahead_mm"], pinion["above_mm"]
    x2, z2 = swung(x, z)
    main["axle"]["pinion"] = {"ahead_mm": -x2, "above_mm": z2}
    end = main["points_mm"][-1]
    main["points_mm"][-1] = [end[0] + x2 - x, end[1], end[2] + z2 - z]
    main["pinion_slope"]["side_deg"] += turn
    x, z = between["output_joint"]["behind_mm"], between["output_joint"]["above_mm"]
    x2, z2 = swung(x, z)
    between["output_joint"] = {"behind_mm": x2, "above_mm": z2}
    between["points_mm"][0] = [x2 - x, 0, z2 - z]
    between["gearbox_slope"]["side_deg"] += turn
    return reader.loads(yaml.safe_dump(table, sort_keys=False))


@pytest.mark.slow
@pytest.mark.parametrize("turn", [1.0, -1.5])
def test_forward_axle_shim_changes_inter_axle_line(turn):
    """The through-shaft turns with the axle, and joint 1 swings about its wheels."""
    tandem = reader.read(TANDEM)
    main, between = approve_driveline(tandem).line_responses
    shim = next(a for a in allowed_adjustments(main) if a.adjustment_key == "shim")
    by_hand = approve_driveline(shimmed_by_hand(turn)).line_responses
    told = [
        approve_driveline(
            corrected_application(main, (shim,), np.array([turn * deg]))
        ).line_responses,
        [response_with_adjustments(r, (shim,), np.array([turn * deg])) for r in (main, between)],
        [
            response_with_adjustments(r, (shim,), np.array([[0.0], [turn * deg]]))
            for r in (main, between)
        ],
    ]
    for responses in told:
        for one, true in zip(responses, by_hand, strict=True):
            angles = np.broadcast_to(one.joint_angles, (2, *true.joint_angles.shape))[1]
            np.testing.assert_allclose(angles, true.joint_angles, atol=1e-9)
    assert np.abs(by_hand[1].joint_angles - between.joint_angles).max() > 0.8 * abs(turn) * deg


@pytest.mark.slow
def test_shim_correction_lists_failures_of_inter_axle_line():
    """Nose down 1 deg takes 310 N off the bearing, and bends an inter-axle joint too far."""
    before = approve_driveline(reader.read(TANDEM))
    static = next(
        one for one in check_sensitivities(before, line="main")
        if one.check.quantity == "centre_bearing_static"
    )  # fmt: skip
    alone = tuple(e for e in static.effects if e.adjustable.adjustment_key == "shim")
    (told,) = helpful_adjustment_phrases(replace(static, effects=alone), ENGLISH)
    after = approve_driveline(shimmed_by_hand(-1.0))
    force = max(
        c.value for c in after.checks if (c.line, c.quantity) == ("main", "centre_bearing_static")
    )
    assert force < static.check.value - 300
    assert (
        f"pinion angle -1° (shim) gives {force:.0f}, but then exceeded: inter-axle: Joint angle"
        in told
    )
    failed, fails = (
        {(c.line, c.quantity) for c in of.checks if c.grade == "fail"} for of in (before, after)
    )
    assert ("inter-axle", "joint_angle") in fails - failed


@pytest.mark.slow
def test_study_of_forward_axle_shim_evaluates_both_lines():
    bench = VariantEvaluator.from_application(
        reader.read(TANDEM), build_variants({"main.shim_deg": {"grid": [0, 1, 2]}})
    )
    least = next(
        k for k, (line, limit) in enumerate(bench.limits)
        if (line, limit.quantity) == ("inter-axle", "joint_angle_min")
    )  # fmt: skip
    told = bench.evaluate(np.array([[0.0], [1.0]])).values[least]
    true = [
        min(
            c.value for c in approve_driveline(shimmed_by_hand(turn)).checks
            if (c.line, c.quantity) == ("inter-axle", "joint_angle_min")
        )
        for turn in (0.0, 1.0)
    ]  # fmt: skip
    np.testing.assert_allclose(told, true, rtol=1e-6)
