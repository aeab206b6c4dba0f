"""What may be moved goes where its words say: up, to the right, nose up, turned right-handed.

By the frame of METHOD: x rearward, y to the right, z up; slopes down to the rear positive.
"""

from math import cos, radians, sin
from pathlib import Path

import numpy as np
import pytest
import yaml

from cardan import files
from cardan.base.units import deg, mm
from cardan.demand.states import demand, resolve
from cardan.files.change import change
from cardan.model.application import Adjustable
from cardan.model.movable import movable
from cardan.quantity.response import respond
from cardan.report.language import EN
from cardan.report.wording import moves_that_help
from cardan.study.approval import assess
from cardan.study.fix import fix
from cardan.study.moves import Move, adjustables, corrected, tried
from cardan.study.sensitivity import sensitivities
from cardan.study.sweep import Bench, variants_of

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
    application = files.loads(CHAIN)
    return respond(application, demand(resolve(application, application.lines[0])))


def moved(line, what, part, amount):
    """The line with one thing moved, and where its joints have gone."""
    one = Adjustable(what=what, part=part, low=-1.0, high=1.0)
    found = tried(line, (one,), np.array([[amount]]))
    return found, (found.layout.points - line.layout.points)[0, 0]


@pytest.mark.parametrize("bearing", [1, 2])
@pytest.mark.parametrize(("what", "axis"), [("bearing_height", 2), ("bearing_side", 1)])
def test_a_bearing_moves_up_or_to_the_right_and_its_own_joint_with_it(line, what, axis, bearing):
    """The joint behind bearing k is joint k + 1; those ahead of the bearing stay."""
    _, gone = moved(line, what, bearing, 10 * mm)
    assert np.all(gone[:bearing] == 0)
    way = gone[bearing]
    assert way[axis] > 10 * mm  # it sits behind the bearing, on a shaft that tips
    assert abs(way[3 - axis]) < 1 * mm


def test_a_shim_lifts_the_pinions_nose(line):
    """What faces forward and rises slopes down to the rear."""
    found, _ = moved(line, "shim", 1, 1 * deg)
    assert found.layout.side[0, 0, -1] - line.layout.side[0, -1] == pytest.approx(1 * deg)


@pytest.mark.parametrize("shaft", [1, 2, 3])
def test_a_turned_yoke_is_the_phase_the_file_would_give(line, shaft):
    address = f"driveline.shafts[{shaft}].phase_deg"
    installed = (0.0, 15.0, 90.0)[shaft - 1]
    written = change(line.application, {address: installed + 30})
    by_file = respond(written, demand(resolve(written, written.lines[0])))
    found, gone = moved(line, "phase", shaft, 30 * deg)
    assert not gone.any()
    assert found.phases[0, 0] == pytest.approx(by_file.phases)
    angle = found.excitation.torsional.angle[0, 0]
    assert angle == pytest.approx(by_file.excitation.torsional.angle[0], rel=1e-12)
    assert abs(angle - line.excitation.torsional.angle[0]) > 1e-5


def test_a_cost_is_the_share_of_the_way_on_its_own_side():
    """5 mm down of 10, and of 20 up; a turned yoke counts half, whichever way."""
    height = Adjustable(what="bearing_height", part=1, low=-10 * mm, high=20 * mm)
    assert Move(adjustable=height, amount=-5 * mm).cost == pytest.approx(0.5)
    assert Move(adjustable=height, amount=5 * mm).cost == pytest.approx(0.25)
    yoke = Adjustable(what="phase", part=1, low=0.0, high=90 * deg)
    assert Move(adjustable=yoke, amount=-90 * deg).cost == 0.5


def test_yokes_turn_to_aligned_and_crossed_wherever_they_are():
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
    turned = {round(m.amount / deg, 6) for p in fix(files.loads(text)) for m in p.moves}
    assert turned == {-90}


def test_what_helps_is_told_the_way_it_helps():
    """A nose that is 1.5 deg too high: down a degree wins, up a degree loses."""
    text = """
title: One shaft
speed_rpm: 2500
driveline: {slopes: {side_deg: [4.0, 2.0, 5.5]}, shafts: [{length_mm: 1200, tube: 100x3}]}
adjust: {shim_deg: [-4, 4]}
limits: [{quantity: joint_angle, normal: 3, source: us}]
"""
    (one,) = sensitivities(assess(files.loads(text)))
    (said,) = moves_that_help(one, EN)
    assert said == "pinion nose down 1 deg gives 2.500"


def test_what_helps_is_told_of_a_warning_too():
    """Back is down and forth is up, by the step that is told; the gain is in margin."""
    tight = CHAIN.replace("limits: protractor", "limits: [{quantity: joint_angle, normal: 2, "
                          "unit: deg, source: us}]")  # fmt: skip
    approval = assess(files.loads(tight))
    assert approval.verdict == "warn"
    found = sensitivities(approval)
    assert found
    (response,) = approval.responses
    for one in found:
        for effect in one.effects:
            both = {}
            for way, amount in (("back", effect.low), ("forth", effect.high)):
                there = tried(response, (effect.adjustable,), np.array([[amount]]))
                k = int(one.check.part.number) - 1
                both[way] = there.angles[0, 0, k]
            assert (effect.back, effect.forth) == pytest.approx((both["back"], both["forth"]))
            best = max(1 - both[way] / (2 * deg) for way in both)
            assert one.gain(effect) == pytest.approx(best - one.check.margin)


@pytest.mark.parametrize(("shafts", "choices"), [(3, 8), (4, 5), (7, 8)])
def test_choices_of_phases_do_not_double_without_end(shafts, choices):
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
    fix(files.loads(text), hold=stepless, tell=lambda *at: told.append(at))
    assert told == [(k, choices) for k in range(choices)]


def test_without_adjust_a_workshop_moves_what_the_docs_say(line):
    """docs/fix.md: bearings by 30 mm, the axle by 3 deg; packing of 5 mm, wedges of 0.5 deg."""
    free = movable([line.line])
    for name in ("bearing_height_mm[1]", "bearing_height_mm[2]"):
        a = free[name]
        assert (a.low, a.high, a.step) == pytest.approx((-30 * mm, 30 * mm, 5 * mm))
    a = free["shim_deg"]
    assert (a.low, a.high, a.step) == pytest.approx((-3 * deg, 3 * deg, 0.5 * deg))


TANDEM = Path(__file__).parents[2] / "examples/tandem-6x4.yaml"


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
    return files.loads(yaml.safe_dump(table, sort_keys=False))


@pytest.mark.parametrize("turn", [1.0, -1.5])
def test_a_shim_of_the_forward_axle_turns_the_line_that_leaves_it(turn):
    """The through-shaft turns with the axle, and joint 1 swings about its wheels."""
    tandem = files.read(TANDEM)
    main, between = assess(tandem).responses
    shim = next(a for a in adjustables(main) if a.what == "shim")
    by_hand = assess(shimmed_by_hand(turn)).responses
    told = [
        assess(corrected(main, (shim,), np.array([turn * deg]))).responses,
        [tried(r, (shim,), np.array([turn * deg])) for r in (main, between)],
        [tried(r, (shim,), np.array([[0.0], [turn * deg]])) for r in (main, between)],
    ]
    for responses in told:
        for one, true in zip(responses, by_hand, strict=True):
            angles = np.broadcast_to(one.angles, (2, *true.angles.shape))[1]
            np.testing.assert_allclose(angles, true.angles, atol=1e-9)
    assert np.abs(by_hand[1].angles - between.angles).max() > 0.8 * abs(turn) * deg


def test_what_a_shim_spoils_of_the_line_that_leaves_its_axle_is_told():
    """Nose up 1 deg takes 190 N off the bearing, and of the inter-axle joint's angle too much."""
    found = sensitivities(assess(files.read(TANDEM)), line="main")
    told = " ".join(said for one in found for said in moves_that_help(one, EN))
    assert "pinion nose up 1 deg gives 2226, but then fail: inter-axle: Smallest joint" in told


def test_a_study_of_the_forward_axles_shim_asks_both_lines():
    bench = Bench.of(files.read(TANDEM), variants_of({"main.shim_deg": {"grid": [0, 1, 2]}}))
    least = next(
        k for k, (line, limit) in enumerate(bench.limits)
        if (line, limit.quantity) == ("inter-axle", "joint_angle_min")
    )  # fmt: skip
    told = bench.ask(np.array([[0.0], [1.0]])).values[least]
    true = [
        min(
            c.value for c in assess(shimmed_by_hand(turn)).checks
            if (c.line, c.quantity) == ("inter-axle", "joint_angle_min")
        )
        for turn in (0.0, 1.0)
    ]  # fmt: skip
    np.testing.assert_allclose(told, true, rtol=1e-6)
