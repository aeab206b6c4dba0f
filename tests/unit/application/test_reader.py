"""Application files: what a good one becomes, and what a wrong one is told."""

# ruff: noqa: E501  messages stand here as they are printed

import re
from dataclasses import replace

import numpy as np
import pytest

from cardan.application.overrides import change
from cardan.application.reader import loads, read
from cardan.application.templates import template_text
from cardan.core.errors import InvalidFileError
from cardan.core.provenance import Source
from cardan.core.units import deg, g, inch, kg, kNm, lb, lbft, mm, rpm
from cardan.model.application import PermittedAdjustment, VehicleState
from cardan.model.parts import Flange
from cardan.model.vehicle import Linkage, Spring
from cardan.schema.node_reader import MAX_ISSUES

SMALL = """\
title: Two-piece driveline
speed_rpm: 2500
torque_Nm: 8000
driveline:
  slopes:                         # of every member, gearbox first, pinion last; down to the rear is positive
    side_deg: [3.0, 1.0, 4.5, 2.0]
    top_deg:  [0.0, 0.0, 0.0, 0.0]     # optional; to the right going rearward is positive
  shafts:                         # gearbox to axle
    - {length_mm: 1200, tube: {outer_mm: 101.6, wall_mm: 3.2}, centre_bearing: {from_rear_joint_mm: 140}}
    - {length_mm: 1500, tube: {outer_mm: 101.6, wall_mm: 3.2}, phase_deg: 0}
"""
TRUCK = template_text("truck")
SLOPES = """\
  slopes:                         # of every member, gearbox first, pinion last; down to the rear is positive
    side_deg: [3.0, 1.0, 4.5, 2.0]
    top_deg:  [0.0, 0.0, 0.0, 0.0]     # optional; to the right going rearward is positive
"""


def changed(old, new, text=SMALL):
    assert text.count(old) >= 1, f"the text has no {old}"
    return text.replace(old, new, 1)


def small(old="", new=""):
    return loads(changed(old, new))


def refused(text, **given):
    with pytest.raises(InvalidFileError) as error:
        loads(text, name="f.yaml", **given)
    return str(error.value).splitlines()


def test_the_smallest_file_is_read_as_the_design_prints_it():
    application = loads(SMALL)
    (installed,) = application.lines
    first, last = installed.line.shafts
    assert application.title == "Two-piece driveline"
    assert application.speed == 2500 * rpm
    assert application.torque == 8000
    assert installed.line.name == "main"
    assert installed.line.lengths == (1.2, 1.5)
    assert first.tube.outer == pytest.approx(0.1016)
    assert first.tube.wall == pytest.approx(0.0032)
    assert first.tube.material.name == "E355-N"  # none is given
    assert first.tube.material.source.how_read == "assumed"
    assert first.centre_bearing.from_rear_joint == pytest.approx(0.14)
    assert first.centre_bearing.stiffness is None
    assert (first.phase, last.phase, last.centre_bearing) == (0, 0, None)
    assert installed.layout.side / deg == pytest.approx([3.0, 1.0, 4.5, 2.0])
    assert installed.layout.top == pytest.approx(np.zeros(4))
    assert installed.layout.lengths == pytest.approx([1.2, 1.5])
    assert application.states == (VehicleState(name="as given"),)
    assert application.profile == "heavy-truck"
    assert application.limits
    assert application.warnings == ()


def test_a_text_and_its_file_are_one_application(tmp_path):
    file = tmp_path / "small.yaml"
    file.write_text(SMALL, encoding="utf-8")
    from_file, from_text = read(file), loads(SMALL)
    assert np.array_equal(from_file.lines[0].layout.points, from_text.lines[0].layout.points)
    assert replace(from_file, lines=()) == replace(from_text, lines=())


def test_the_truck_is_read_in_si():
    truck = loads(TRUCK)
    (installed,) = truck.lines
    first, last = installed.line.shafts
    assert truck.vehicle.drive == "6x2"
    assert truck.vehicle.driven_share == 0.6
    curb, _, gvw = truck.vehicle.loads
    assert (curb.name, gvw.name) == ("curb", "gvw")
    assert curb.front_load == pytest.approx(4100 * kg * g)
    assert (gvw.mass, gvw.cg_behind_front) == (23000, pytest.approx(3.548))
    assert truck.engine.speed[0] == pytest.approx(1000 * rpm)
    assert truck.engine.torque == (850, 950, 950, 850, 700)
    assert truck.engine.brake_torque == 350
    assert truck.gearbox.ratios[0] == 9.2
    assert (truck.gearbox.reverse_ratio, truck.gearbox.retarder_torque) == (8.6, None)
    assert installed.axle.ratio == 4.88
    assert installed.axle.pinion_joint == pytest.approx((-0.42, 0.02))
    assert truck.tyre.static_radius == pytest.approx(0.48)
    assert truck.suspension.spring.load == (0, 20000, 46000, 75000)
    assert truck.suspension.spring.deflection == pytest.approx((0, 0.07, 0.15, 0.22))
    assert truck.suspension.linkage.radius == pytest.approx(0.57)
    assert truck.suspension.linkage.pitch_rate == pytest.approx(0.002 * deg / mm)
    assert truck.suspension.windup_stiffness == pytest.approx(16e3 / deg)
    assert installed.layout.points[1] == pytest.approx([1.24, 0, -0.06])
    assert installed.layout.side[[0, -1]] / deg == pytest.approx([4.0, 2.4])
    assert first.length == pytest.approx(np.hypot(1.24, 0.06))
    assert [j.name for j in installed.line.joints] == ["2045"] * 3
    assert first.tube.outer == pytest.approx(5 * inch)
    assert first.centre_bearing.stiffness == pytest.approx((200e3, 120e3))
    assert first.centre_bearing.axial_stiffness == pytest.approx(60e3)
    assert first.centre_bearing.loss_factor == 0.18
    assert first.yoke_mass == (9, 11)
    assert first.balance_grade == 40
    assert last.spline.plunge == pytest.approx(0.06)
    assert [s.name for s in truck.states][-2:] == ["windup", "wheels in a dip"]
    assert truck.states[-1].travel == pytest.approx(-0.03)
    assert truck.obstacles[0].end == pytest.approx((2.1, 0.5, -0.35))
    assert truck.duty[0].share == pytest.approx(0.3)
    assert truck.prime_mover_factor == 1.25
    assert (truck.include_gravity, truck.include_unbalance) == (True, True)
    assert truck.profile == "heavy-truck, with overrides"
    (clearance,) = [limit for limit in truck.limits if limit.quantity == "clearance"]
    assert (clearance.normal, clearance.sense) == (pytest.approx(0.03), ">=")
    assert clearance.source == Source("our own practice")


# --- units --------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("key", "value", "si"),
    [
        ("speed_rpm: 2500", lambda a: a.speed, 2500 * rpm),
        ("speed_rad_s: 250", lambda a: a.speed, 250),
    ],
)
def test_speed_in_its_units(key, value, si):
    assert value(small("speed_rpm: 2500", key)) == pytest.approx(si)


@pytest.mark.parametrize(
    ("key", "si"),
    [("torque_Nm: 8000", 8000), ("torque_kNm: 8", 8 * kNm), ("torque_lbft: 5900", 5900 * lbft)],
)
def test_torque_in_its_units(key, si):
    assert small("torque_Nm: 8000", key).torque == pytest.approx(si)


@pytest.mark.parametrize(
    ("key", "si"),
    [
        ("front_axle_kg: 5000, rear_axle_kg: 9000", 5000 * g),
        ("front_axle_t: 5, rear_axle_t: 9", 5000 * g),
        ("front_axle_lb: 11000, rear_axle_kN: 90", 11000 * lb * g),
        ("front_axle_N: 50000, rear_axle_kN: 90", 50000),
        ("front_axle_lbf: 11000, rear_axle_kN: 90", 11000 * lb * g),
    ],
)
def test_axle_loads_as_mass_or_force(key, si):
    text = f"{SMALL}vehicle: {{drive: 4x2, wheelbase_mm: 4800, loads: {{gvw: {{{key}}}}}}}\n"
    assert loads(text).vehicle.loads[0].front_load == pytest.approx(si)


def test_grade_as_percent_or_angle():
    vehicle = "vehicle: {{drive: 4x2, wheelbase_mm: 4800, {}}}\n".format
    percent = loads(SMALL + vehicle("grade_percent: 10")).vehicle.grade
    assert percent == pytest.approx(np.arctan(0.1))
    assert loads(SMALL + vehicle("grade_deg: 5")).vehicle.grade == pytest.approx(5 * deg)


# --- geometry -----------------------------------------------------------------------------


def with_geometry(text):
    return loads(changed(SLOPES, text))


def test_joint_angles_are_changes_of_slope():
    layout = with_geometry("  joint_angles: {side_deg: [-2, 3.5, -2.5], top_deg: [1, 0, -1]}\n")
    assert layout.lines[0].layout.side / deg == pytest.approx([0, -2, 1.5, -1], abs=1e-12)
    assert layout.lines[0].layout.top / deg == pytest.approx([0, 1, 1, 0], abs=1e-12)


def test_joint_angles_may_start_from_the_gearbox_slope():
    text = "  joint_angles: {side_deg: [-2, 3.5, -2.5]}\n  gearbox_slope: {side_deg: 3}\n"
    assert with_geometry(text).lines[0].layout.side / deg == pytest.approx([3, 1, 4.5, 2])


def test_points_give_lengths_that_are_left_out():
    text = changed(
        SLOPES,
        "  points_mm: [[0, 0, 0], [1200, 5, -90], [2650, 0, -200]]\n"
        "  gearbox_slope: {side_deg: 3}\n  pinion_slope: {side_deg: 2, top_deg: 0.5}\n",
    )
    text = text.replace("length_mm: 1200, ", "").replace("length_mm: 1500, ", "")
    (installed,) = loads(text).lines
    assert installed.line.lengths == pytest.approx(
        (np.sqrt(1.2**2 + 0.005**2 + 0.09**2), np.sqrt(1.45**2 + 0.005**2 + 0.11**2))
    )
    assert installed.layout.side[-1] / deg == pytest.approx(2)
    assert installed.layout.top[-1] / deg == pytest.approx(0.5)


@pytest.mark.parametrize(
    ("geometry", "message"),
    [
        ("", "f.yaml:5:3: driveline: needs slopes, joint_angles or points_mm"),
        ("  slopes: {}\n", "f.yaml:5:11: driveline.slopes: needs side_deg or top_deg"),
        ("  slopes: {side_deg: [1, 2, 3]}\n", "f.yaml:5:12: driveline.slopes.side_deg: must hold "
         "4 values, for gearbox, shaft 1, shaft 2, pinion (got 3 values)"),
        ("  joint_angles: {top_deg: [1, 2, 3, 4]}\n", "f.yaml:5:18: driveline.joint_angles.top_deg:"
         " must hold 3 values, for joint 1, joint 2, joint 3 (got 4 values)"),
        ("  joint_angles: {side_deg: [50, 40, 3]}\n", "f.yaml:5:3: driveline.joint_angles: the "
         "angles add up to a member sloping 93.0 deg; slopes stay below 80 deg"),
        ("  slopes: {side_deg: [50, -50, 0, 0]}\n", "f.yaml:5:3: driveline.slopes: joint 1 would "
         "bend by 100 deg; a joint bends by less than 75 deg"),
        ("  slopes: {side_deg: [1, 2, 3, 4]}\n  points_mm: [[0, 0, 0]]\n", "f.yaml:6:3: driveline."
         "points_mm: slopes and points_mm exclude each other; keep one of them"),
        ("  slopes: {side_deg: [1, 2, 3, 4]}\n  pinion_slope: {side_deg: 3}\n", "f.yaml:6:3: "
         "driveline.pinion_slope: goes with points only; the slopes hold it already"),
        ("  joint_angles: {side_deg: [1, 2, 3]}\n  pinion_slope: {side_deg: 3}\n", "f.yaml:6:3: "
         "driveline.pinion_slope: goes with points only; the joint angles give it"),
        ("  points_mm: [[0, 0, 0], [1200, 0, 0]]\n", "f.yaml:5:3: driveline.points_mm: must hold 3 "
         "joint centres, one more than shafts (got 2 points)"),
        ("  points_mm: [[0, 0, 0], [1200, 0, 0], [2700, 0, 0]]\n", "f.yaml:5:3: driveline.points_mm"
         ": points need a gearbox_slope too; gearbox_slope: {side_deg: 3.0, top_deg: 0.0}"),
        ("  points_mm: [[0, 0, 0], [1200, 0, 0], [900, 0, 0]]\n", "f.yaml:5:40: driveline."
         "points_mm[3]: x must rise from joint 2 to joint 3: it runs along the line (got a rise of "
         "-300 mm)"),
        ("  points_mm: [[0, 0, 0], [1200, 0], [900, 0, 0]]\n", "f.yaml:5:26: driveline.points_mm[2]"
         ": must be a list of 3 numbers, [x, y, z] (got a list of 2)"),
        ("  points_mm: [[0, 0, 0], [1210, 0, 0], [2710, 0, 0]]\n  gearbox_slope: {side_deg: 3}\n"
         "  pinion_slope: {}\n", "f.yaml:5:3: driveline.points_mm: put joints 1 and 2 1210.0 mm "
         "apart, but shaft 1 is 1200 mm long; correct the points or the length"),
    ],
)  # fmt: skip
def test_a_line_that_cannot_run_like_this(geometry, message):
    assert message in refused(changed(SLOPES, geometry))


# --- states -------------------------------------------------------------------------------


def states(text, base=SMALL):
    return loads(f"{base}states:\n{text}").states


def test_a_state_overrides_the_geometry_and_keeps_the_first_joint():
    base = changed("  gearbox_slope: {side_deg: 4.0", "  gearbox_slope: {side_deg: 4.0", TRUCK)
    base = base.replace(
        "[[0, 0, 0], [1240, 0, -60], [2750, 0, -165]]",
        "[[100, 0, 50], [1340, 0, -10], [2850, 0, -115]]",
    )
    base = base.replace(
        "  - full rebound ", "  - {name: bent, slopes: {side_deg: [4, 3, 5, 2]}}\n  - full rebound "
    )
    application = loads(base)
    layout = application.states[0].layouts["main"]
    assert application.states[0].kind is None
    assert layout.points[0] == pytest.approx([0.1, 0, 0.05])
    assert layout.side / deg == pytest.approx([4, 3, 5, 2])
    assert layout.lengths == pytest.approx(application.lines[0].line.lengths)


def test_a_state_may_slide_the_last_shaft():
    (state,) = states("  - {name: a, slopes: {side_deg: [1, 2, 3, 4]}, last_length_mm: 1520}\n")
    assert state.layouts["main"].lengths == pytest.approx([1.2, 1.52])


def test_points_of_a_state_take_the_flanges_of_the_driveline():
    (state,) = states("  - {name: a, points_mm: [[0, 0, 0], [1199, 0, -50], [2700, 0, -150]]}\n")
    layout, reference = state.layouts["main"], loads(SMALL).lines[0].layout
    assert layout.directions[[0, -1]] == pytest.approx(reference.directions[[0, -1]])
    assert layout.lengths[-1] == pytest.approx(np.hypot(1.501, 0.1))


def test_joint_angles_of_a_state_start_from_the_gearbox():
    (state,) = states("  - {name: a, joint_angles: {side_deg: [-2, 3, -1]}}\n")
    assert state.layouts["main"].side / deg == pytest.approx([3, 1, 4, 3])


def test_the_name_of_a_state_says_how_the_axle_moves_unless_something_else_does():
    geometry = "slopes: {side_deg: [1, 2, 3, 4]}"
    found = states(
        f"  - gvw\n  - {{name: empty, {geometry}}}\n  - {{name: jounce, travel_mm: 60}}\n"
        "  - {name: hot, kind: gvw, torque_Nm: 5000, speed_rpm: 900}\n"
    )
    assert [(s.name, s.kind) for s in found] == [
        ("gvw", "gvw"), ("empty", None), ("jounce", None), ("hot", "gvw"),
    ]  # fmt: skip
    assert (found[-1].torque, found[-1].speed) == (5000, pytest.approx(900 * rpm))


def test_a_state_with_its_own_geometry_has_the_load_of_its_name():
    base = changed("  - empty\n", "  - {name: empty, slopes: {side_deg: [4, 2, 6, 2]}}\n", TRUCK)
    (state,) = [s for s in loads(base).states if s.name == "empty"]
    assert state.load == "empty"


@pytest.mark.parametrize(
    ("state", "message"),
    [
        ("jounce", "f.yaml:12:5: states[1]: state jounce moves the rear axle of line main: how "
         "far?; give a suspension, or the state its own slopes or travel_mm"),
        ("windup", "f.yaml:12:5: states[1]: state windup winds up the rear axle of line main: how "
         "stiff is it?; give its suspension a windup_stiffness_kNm_deg, or the state a pitch_deg"),
        ("Gvw", "f.yaml:12:5: states[1]: must be one of full rebound, rebound, curb, empty, gvw, "
         "overload, jounce, windup, windup brake (got Gvw); did you mean gvw?"),
        ("{slopes: {side_deg: [1, 2, 3, 4]}}", "f.yaml:12:5: states[1]: name is missing: what "
         "reports call it"),
        ("{name: a, load: gvw}", "f.yaml:12:21: states[1].load: the vehicle has no such load state "
         "(got gvw); there are none"),
        ("{name: a, last_length_mm: 1500}", "f.yaml:12:5: states[1]: needs slopes, joint_angles or "
         "points_mm"),
        ("{name: a, slopes: {side_deg: [1, 2]}}", "f.yaml:12:24: states[1].slopes.side_deg: must "
         "hold 4 values, for gearbox, shaft 1, shaft 2, pinion (got 2 values)"),
        ("{name: a, points_mm: [[0, 0, 0], [1250, 0, 0], [2700, 0, 0]]}", "f.yaml:12:15: "
         "states[1].points_mm: put joints 1 and 2 1250.0 mm apart, but shaft 1 is 1200 mm long; "
         "correct the points or the length"),
        ("{name: a, drivelines: {front: {slopes: {side_deg: [1]}}}}", "f.yaml:12:15: states[1]."
         "drivelines: no driveline of this name (got front); there are: main"),
    ],
)  # fmt: skip
def test_a_state_that_cannot_be(state, message):
    assert refused(f"{SMALL}states:\n  - {state}\n") == [message]


def test_states_have_names_of_their_own():
    (message,) = refused(f"{SMALL}states: [gvw, {{name: gvw, travel_mm: 3}}]\n")
    assert message.endswith("states[2]: this name is above already (got gvw); give it another")


# --- several lines ------------------------------------------------------------------------

SEVERAL = """\
title: 6x4
torque_Nm: 9000
speed_rpm: 2400
axle: {ratio: 4.1, efficiency: 0.96}
drivelines:
  main:
    slopes: {side_deg: [3, 1, 4, 2]}
    shafts:
      - {length_mm: 1200, centre_bearing: {from_rear_joint_mm: 140}}
      - {length_mm: 1500}
  inter-axle:
    slopes: {side_deg: [2, 3.5, 2]}
    shafts: [{length_mm: 700}]
    joints: SPL100
    axle: {ratio: 4.1, pinion: {ahead_mm: 400, below_mm: 30}}
    torque_share: 0.5
    output_joint: {behind_mm: 350, above_mm: 120}
    load_share: 0.5
states:
  - {name: bent, drivelines: {inter-axle: {slopes: {side_deg: [2, 5, 3]}}}}
obstacles:
  - {name: crossmember, start_mm: [300, -400, 80], end_mm: [300, 400, 80], diameter_mm: 60, line: inter-axle}
"""


def test_several_lines_each_have_their_own():
    application = loads(SEVERAL)
    main, between = application.lines
    assert [i.line.name for i in application.lines] == ["main", "inter-axle"]
    assert (main.axle.ratio, main.axle.efficiency) == (4.1, 0.96)
    assert between.axle.pinion_joint == pytest.approx((-0.4, -0.03))
    assert between.output_joint == pytest.approx((0.35, 0.12))
    assert (main.torque_share, between.torque_share) == (1, 0.5)
    assert [j.name for j in between.line.joints] == ["SPL100", "SPL100"]
    assert list(application.states[0].layouts) == ["inter-axle"]
    (obstacle,) = application.obstacles
    assert (obstacle.line, obstacle.radius) == ("inter-axle", pytest.approx(0.03))


def test_geometry_of_several_lines_says_whose_it_is():
    text = changed(
        "drivelines: {inter-axle: {slopes: {side_deg: [2, 5, 3]}}}",
        "slopes: {side_deg: [2, 5, 3]}",
        SEVERAL,
    )
    (message,) = refused(text)
    assert message.endswith("states[1].slopes: give the geometry of each line in drivelines")


def test_what_may_move_is_said_in_each_of_several_lines():
    (message,) = refused(f"{SEVERAL}adjust: {{shim_deg: [-1, 1]}}\n")
    assert message == "f.yaml:23:1: adjust: give this inside each of the drivelines"
    text = changed("    load_share: 0.5\n", "    adjust: {shim_deg: [-1, 1]}\n", SEVERAL)
    (adjustable,) = loads(text).adjustables
    assert (adjustable.line, adjustable.adjustment_key) == ("inter-axle", "shim")


def test_one_line_or_several():
    assert refused("title: a\ntorque_Nm: 10\n")[0] == "f.yaml:1:1: needs driveline or drivelines"
    both = f"{SEVERAL}driveline: {{}}\n"
    assert (
        "f.yaml:23:1: driveline: drivelines and driveline exclude each other; keep one of them"
        in (refused(both))
    )
    assert refused("title: a\ndrivelines: {}\n") == [
        "f.yaml:2:1: drivelines: needs at least one line"
    ]


# --- parts --------------------------------------------------------------------------------


def shaft(keys):
    return (
        loads(changed("{length_mm: 1500, ", f"{{{keys}, length_mm: 1500, ")).lines[0].line.shafts[1]
    )


def test_yokes_weigh_alike_unless_said():
    assert shaft("yoke_mass_kg: 9").yoke_mass == (9, 9)
    assert shaft("yoke_mass_lb: [10, 20]").yoke_mass == pytest.approx((10 * lb, 20 * lb))


@pytest.mark.parametrize(("written", "grade"), [("G40", 40), ("40", 40), ("G6.3", 6.3)])
def test_balance_grades_are_written_as_in_the_standard(written, grade):
    assert shaft(f"balance_grade: {written}").balance_grade == grade


def test_joints_come_from_the_catalogue_or_in_place():
    joints = "  joints: [1810, {peak_kNm: 12, n_beta_max_deg_min: 18000}, SPL140]\n  shafts:"
    first, middle, last = small("  shafts:", joints).lines[0].line.joints
    assert (first.name, last.name) == ("1810", "SPL140")
    assert middle.peak_torque == 12e3
    # In the catalogues deg/min are rpm times degrees: at 2000 rpm it may bend by 9 deg.
    assert middle.speed_angle_max == pytest.approx(2000 * rpm * 9 * deg)


def test_stiffness_is_one_number_or_two():
    bearing = "centre_bearing: {{from_rear_joint_mm: 140, {}}}".format
    one = small(bearing("x")[:-4] + "}", bearing("stiffness_N_mm: 300"))
    assert one.lines[0].line.shafts[0].centre_bearing.stiffness == (300e3, 300e3)
    two = small(
        bearing("x")[:-4] + "}", bearing("vertical_stiffness_N_mm: 200, lateral_stiffness_kN_m: 90")
    )
    assert two.lines[0].line.shafts[0].centre_bearing.stiffness == pytest.approx((200e3, 90e3))


def test_what_nobody_says_of_the_rubber_along_the_shaft_is_not_known():
    bearing = small("x", "x").lines[0].line.shafts[0].centre_bearing
    assert (bearing.axial_stiffness, bearing.loss_factor) == (None, None)


def test_a_retarder_holds_at_the_gearbox_output():
    text = TRUCK.replace("  efficiency: 0.95 ", "  retarder_torque_kNm: 1.5\n  efficiency: 0.95 ")
    assert loads(text).gearbox.retarder_torque == 1500


def suspension(spring="load_N: [0, 1000], deflection_mm: [0, 100]", more=""):
    return loads(f"{SMALL}suspension: {{spring: {{{spring}}}{more}}}\n").suspension


def test_a_spring_is_a_table_or_rates():
    table = Spring(load=(0, 12060, 31280), deflection=(0, 0.1, 0.2))
    rates = suspension("rates_N_mm: [120.6, 192.2], contact_mm: 100").spring
    assert rates.load == pytest.approx(table.load)
    assert rates.deflection == pytest.approx(table.deflection)
    one = suspension("rates_N_mm: [150]").spring
    assert np.diff(one.load) / np.diff(one.deflection) == pytest.approx([150e3, 150e3])
    # Where its table ends the axle meets metal, unless the file says where: jounce.
    assert one.deflection == pytest.approx((0, 0.1, 0.2))


def test_a_linkage_is_a_link_or_a_table():
    leaf = suspension(more=", linkage: {front_half_length_mm: 800, angle_deg: 4}").linkage
    assert leaf == Linkage(radius=0.75 * (800 * mm), angle=4 * deg)
    table = suspension(
        more=", linkage: {travel_mm: [-50, 0, 50], dx_mm: [3, 0, 2], pitch_deg: [-1, 0, 1]}"
    ).linkage
    assert table.travel == pytest.approx((-0.05, 0, 0.05))
    assert table.pitch == pytest.approx((-deg, 0, deg))


def test_one_number_is_an_engine_and_a_gearbox():
    text = f"{SMALL}engine: {{speed_rpm: 2000, torque_Nm: 900}}\ngearbox: {{ratios: 1}}\n"
    application = loads(text)
    assert application.engine.speed == (pytest.approx(2000 * rpm),)
    assert application.gearbox.ratios == (1,)


def test_what_rounding_leaves_of_a_life_is_shared_out():
    """Three times 33.3 % are three thirds: nobody rests for the tenth of a per cent.

    They were refused once: 0.999 is 1.0000000000000009e-3 short of 1.
    """
    point = "{share_percent: 33.3, torque_Nm: 900, speed_rpm: 900}"
    points = loads(f"{SMALL}duty: [{point}, {point}, {point}]\n").duty
    assert [p.share for p in points] == pytest.approx([1 / 3] * 3, rel=1e-12)


def test_what_may_move_and_how_far():
    adjust = "adjust: {bearing_height_mm: {1: [-20, 30]}, shim_deg: [-3, 3], " \
             "phase_deg: [0, 90], hold: [phase 2]}\n"  # fmt: skip
    found = loads(SMALL + adjust).adjustables
    assert [(a.adjustment_key, a.part, a.hold) for a in found] == [
        ("bearing_height", 1, False), ("shim", 1, False), ("phase", 1, False), ("phase", 2, True),
    ]  # fmt: skip
    assert (found[0].low, found[0].high) == pytest.approx((-0.02, 0.03))
    assert found[1] == PermittedAdjustment(
        adjustment_key="shim", part=1, low=-3 * deg, high=3 * deg, step=0.5 * deg
    )


# --- wrong files: every kind, the full message ---------------------------------------------

SHAFT = "f.yaml:9:19: driveline.shafts[1].length_mm: "
NUMBER = f"{SHAFT}must be a number above 0"
RANGE = f"{SHAFT}must be a number of at least 5 and at most 50000 mm"


@pytest.mark.parametrize(
    ("old", "new", "messages"),
    [
        ("length_mm: 1200", "length_mm: twelve", [f"{NUMBER} (got twelve)"]),
        ("length_mm: 1200", "length_mm: true", [f"{NUMBER} (got true)"]),
        ("length_mm: 1200", "length_mm: yes", [f"{NUMBER} (got yes)"]),
        ("length_mm: 1200", "length_mm: [1200]", [f"{NUMBER} (got a list of 1)"]),
        ("length_mm: 1200", "length_mm: null",
         [f"{SHAFT}has no value; it must be a number above 0"]),
        ("length_mm: 1200", "length_mm: '1200'",
         [f"{NUMBER} (got '1200'); a text in quotes is no number: write 1200"]),
        ("length_mm: 1200", "length_mm: 1200 mm",
         [f"{NUMBER} (got 1200 mm); the unit stands in the key: write 1200"]),
        ("length_mm: 1200", "length_mm: -1200", [f"{RANGE} (got -1200)"]),
        ("length_mm: 1200", "length_mm: 0", [f"{RANGE} (got 0)"]),
        ("length_mm: 1200", "length_mm: nan", [f"{NUMBER} (got nan); it must be finite"]),
        ("length_mm: 1200", "length_mm: 1e999", [f"{RANGE} (got 1e999)"]),
        ("length_mm: 1200", "length: 1200", ["f.yaml:9:8: driveline.shafts[1].length: unknown key; "
         "the key names its unit: write length_mm, length_m or length_in"]),
        ("length_mm: 1200", "length_cm: 120", ["f.yaml:9:8: driveline.shafts[1].length_cm: unknown "
         "key; not in this unit: convert the number and write length_mm, length_m or length_in"]),
        ("length_mm: 1200", "lenght_mm: 1200", ["f.yaml:9:8: driveline.shafts[1].lenght_mm: unknown "
         "key; did you mean length_mm?"]),
        ("length_mm: 1200", "LENGTH_MM: 1200", ["f.yaml:9:8: driveline.shafts[1].LENGTH_MM: unknown "
         "key; write length_mm"]),
        ("length_mm: 1200", "length_mm: 1200, length_in: 47", ["f.yaml:9:25: driveline.shafts[1]."
         "length_in: length_mm gives this already; keep one of them"]),
        ("length_mm: 1200", "length_mm: 1200, wall_mm: 3", ["f.yaml:9:25: driveline.shafts[1]."
         "wall_mm: unknown key; it belongs in tube"]),
        ("{length_mm: 1200", "{length_mm:1200", ["f.yaml:9:8: driveline.shafts[1].length_mm:1200: "
         "unknown key; put a space after the colon"]),
        ("length_mm: 1200", "length_mm: 1200,5", ["f.yaml:9:24: driveline.shafts[1].5: unknown key; "
         "numbers take a point before decimals and nothing between thousands"]),
        ("length_mm: 1200, ", "", ["f.yaml:9:7: driveline.shafts[1]: length_mm is missing: joint "
         "centre to joint centre"]),
        ("title: Two-piece driveline\n", "", ["f.yaml:1:1: title is missing: what reports call it"]),
        ("title: Two-piece driveline", "title: true", ["f.yaml:1:8: title: must be a text (got "
         "true); put it in quotes if it is a name"]),
        ("title: Two-piece driveline", "title: [a]",
         ["f.yaml:1:8: title: must be a text (got a list of 1)"]),
        ("wall_mm: 3.2", "wall_mm: 60", [
            "f.yaml:9:58: driveline.shafts[1].tube.wall_mm: wall of a tube must be above 0 and at "
            "most half its outside diameter, 50.8 mm, got 60 mm",
            "f.yaml:9:58: driveline.shafts[1].tube.wall_mm: 60 mm is unusually large; check the "
            "unit; 0.8 to 25 is usual"]),
        ("outer_mm: 101.6", "outr_mm: 101.6", ["f.yaml:9:32: driveline.shafts[1].tube.outr_mm: "
         "unknown key; did you mean outer_mm?"]),
        ("outer_mm: 101.6, ", "", ["f.yaml:9:31: driveline.shafts[1].tube: outer_mm, outer_m or "
         "outer_in is missing: outside diameter"]),
        ("tube: {outer_mm: 101.6, wall_mm: 3.2}", "tube: 4x0.12", ["f.yaml:9:31: driveline."
         "shafts[1].tube: the outside diameter of a tube must be within 15 to 400 mm, got 4 mm; "
         "write the unit behind the sizes, mm or in"]),
        ("tube: {outer_mm: 101.6, wall_mm: 3.2}", "tube: [1]", ["f.yaml:9:31: driveline.shafts[1]."
         "tube: must be a tube of a catalogue or a table with name, outer_mm, wall_mm, material, "
         "layup, source, ... (got a list of 1)"]),
        (", centre_bearing: {from_rear_joint_mm: 140}", "", ["f.yaml:9:7: driveline.shafts[1]: "
         "shaft 1 of 2 needs a centre bearing; give centre_bearing: {from_rear_joint_mm: ...}"]),
        ("length_mm: 1200", "length_mm: 130", ["f.yaml:9:7: driveline.shafts[1]: "
         "a centre bearing must sit on its shaft: from_rear_joint must be below its length 130 mm, "
         "got 140 mm"]),
        ("from_rear_joint_mm: 140", "from_rear_joint_mm: 140, vertical_stiffness_N_mm: 300",
         ["f.yaml:9:80: driveline.shafts[1].centre_bearing: lateral_stiffness_N_mm is missing: "
          "give both"]),
        ("from_rear_joint_mm: 140", "from_rear_joint_mm: 140, loss_factor: 1",
         ["f.yaml:9:119: driveline.shafts[1].centre_bearing.loss_factor: must be a number above 0 "
          "and below 1 (got 1)"]),
        ("phase_deg: 0", "centre_bearing: {from_rear_joint_mm: 140}", ["f.yaml:10:64: driveline."
         "shafts[2].centre_bearing: the last shaft hangs on no bearing; it runs between two joints; "
         "add the shaft behind it, or remove this"]),
        ("phase_deg: 0", "balance_grade: Q4", ["f.yaml:10:79: driveline.shafts[2].balance_grade: "
         "must be a balance grade like G40 (got Q4)"]),
        ("phase_deg: 0", "phase_deg: 400", ["f.yaml:10:75: driveline.shafts[2].phase_deg: must be a "
         "number of at least -360 and at most 360 deg (got 400)"]),
        ("[3.0, 1.0, 4.5, 2.0]", "[3.0, 1.0, 95, 2.0]", ["f.yaml:6:26: driveline.slopes."
         "side_deg[3]: must be a number above -80 and below 80 deg (got 95)"]),
        ("[3.0, 1.0, 4.5, 2.0]", "3.0", ["f.yaml:6:15: driveline.slopes.side_deg: must be a list of "
         "numbers (got 3.0)"]),
        ("  shafts:", "  joints: [1810]\n  shafts:", ["f.yaml:8:3: driveline.joints: must hold 3 "
         "joints, one more than shafts (got 1 joints)"]),
        ("  shafts:", "  joints: spicer 1810\n  shafts:", ["f.yaml:8:11: driveline.joints: no "
         "catalogue has a joint spicer 1810; did you mean 1810?"]),
    ],
)  # fmt: skip
def test_a_wrong_file_is_told_what_is_wrong(old, new, messages):
    assert refused(changed(old, new)) == messages


@pytest.mark.parametrize(
    ("line", "messages"),
    [
        ("- a", ["f.yaml:11:1: this line does not fit the lines above it (got - a); indent keys of "
         "one table alike, and close quotes and brackets"]),
        ("engine: {speed_rpm: [1000, 900], torque_Nm: [800, 900]}", ["f.yaml:11:28: engine."
         "speed_rpm[2]: must be above the value before it: these rise"]),
        ("engine: {speed_rpm: [1000, 1900], torque_Nm: 800}", ["f.yaml:11:46: engine.torque_Nm: "
         "must hold 2 values, one for each speed (got 1 values)"]),
        ("engine: {torque_Nm: 800}", ["f.yaml:11:9: engine: speed_rpm or speed_rad_s is missing: "
         "speed, or speeds that rise"]),
        ("gearbox: {ratios: [1, 5]}", ["f.yaml:11:11: gearbox.ratios: must fall from the lowest gear "
         "to the highest"]),
        ("gearbox: {ratios: []}", ["f.yaml:11:19: gearbox.ratios: must be a list of numbers of "
         "at least 0.02 and below 100 (got an empty list); give at least 1"]),
        ("gearbox: {ratios: 5, efficiency: 95}", ["f.yaml:11:34: gearbox.efficiency: must be a "
         "number of at least 0.1 and at most 1 (got 95)"]),
        ("vehicle: {drive: 6x3, wheelbase_m: 4.8}", ["f.yaml:11:18: vehicle.drive: must be one of "
         "4x2, 4x4, 6x2, 6x4, 6x6, 8x2, 8x4, 8x8 (got 6x3); did you mean 6x6?"]),
        ("vehicle: {drive: 6x4, wheelbase_m: 4.8, front_driven: no}", ["f.yaml:11:55: vehicle."
         "front_driven: must be true or false (got no); write false"]),
        ("vehicle: {drive: 4x2, wheelbase_m: 4.8, front_axles: 1.5}", ["f.yaml:11:54: vehicle."
         "front_axles: must be a whole number from 1 to 3 (got 1.5)"]),
        ("vehicle: {drive: 4x2, wheelbase_m: 4.8, loads: {gvw: {mass_t: 9}}}", ["f.yaml:11:54: "
         "vehicle.loads.gvw: give mass_kg with cg_behind_front_mm, or two of mass_kg, "
         "front_axle_kg and rear_axle_kg without it"]),
        ("vehicle: {drive: 4x2, wheelbase_m: 4.8, grade_percent: 3, grade_deg: 2}", ["f.yaml:11:59: "
         "vehicle.grade_deg: grade_percent and grade_deg exclude each other; keep one of them"]),
        ("vehicle: {drive: 4x2, wheelbase_m: 4.8, front_driven: true}", ["f.yaml:5:3: driveline: "
         "a 4x2 drives no rear axle for a line to turn"]),
        ("vehicle: {drive: 4x2, wheelbase_m: 4.8, driven_share: 0.6}", ["f.yaml:11:55: vehicle."
         "driven_share: driven_share of a 4x2 whose rear group has 1 of 1 axles driven must be 1, "
         "got 0.6"]),
        ("suspension: {spring: {rates_N_mm: [90]}, springs_per_axle: true}", ["f.yaml:11:60: "
         "suspension.springs_per_axle: must be a whole number from 1 to 16 (got true)"]),
        ("suspension: {spring: {load_N: [0, 5000], deflection_mm: [0]}}", ["f.yaml:11:42: suspension."
         "spring.deflection_mm: must hold 2 values, one for each load (got 1 values)"]),
        ("suspension: {spring: {load_N: [0, 5000], deflection_mm: [90, 80]}}", ["f.yaml:11:62: "
         "suspension.spring.deflection_mm[2]: must be above the value before it: these rise"]),
        ("suspension: {spring: {load_N: [0, 5000]}}", ["f.yaml:11:22: suspension.spring: deflection_mm "
         "is missing: load_N needs it"]),
        ("suspension: {spring: {rates_N_mm: [90, 100]}}", ["f.yaml:11:23: suspension.spring."
         "rates_N_mm: contact_mm says where the second rate starts: two rates need it, one does "
         "not"]),
        ("suspension: {spring: {rates_N_mm: [90]}, linkage: {radius_mm: 900, travel_mm: [1, 2]}}",
         ["f.yaml:11:68: suspension.linkage.travel_mm: radius_mm and travel_mm exclude each other; "
          "keep one of them"]),
        ("suspension: {spring: {rates_N_mm: [90]}, linkage: {travel_mm: [1, 2], dx_mm: [1]}}",
         ["f.yaml:11:71: suspension.linkage.dx_mm: must hold 2 values, one for each travel (got 1 "
          "values)"]),
        ("suspension: {spring: {rates_N_mm: [90]}, reference: windup}", ["f.yaml:11:53: suspension."
         "reference: must be one of full rebound, rebound, curb, empty, gvw, overload, jounce (got "
         "windup)"]),
        ("obstacles: [{name: tank, start_mm: [0, 0, 0], line: front}]", ["f.yaml:11:53: obstacles[1]"
         ".line: no driveline of this name (got front); there are: main"]),
        ("obstacles: [{name: tank, start_mm: [0, 0, 0], radius_mm: 9, diameter_mm: 9}]",
         ["f.yaml:11:61: obstacles[1].diameter_mm: radius_mm and diameter_mm exclude each other; "
          "keep one of them"]),
        ("duty: [{share_percent: 30, torque_Nm: 900, speed_rpm: 100}]", ["f.yaml:11:1: duty: the "
         "shares must make 100 % (got 30 %)"]),
        ("prime_mover: gas", ["f.yaml:11:14: prime_mover: must be one of diesel, petrol, electric "
         "(got gas)"]),
        ("shock_factor: 0.5", ["f.yaml:11:15: shock_factor: must be a number of at least 1 and at "
         "most 10 (got 0.5)"]),
        ("include: [gravitty]", ["f.yaml:11:11: include[1]: must be one of gravity, unbalance (got "
         "gravitty); did you mean gravity?"]),
        ("adjust: {bearing_height_mm: {2: [-1, 2]}}", ["f.yaml:11:10: adjust.bearing_height_mm: "
         "line main has no centre bearing 2; its last is centre bearing 1"]),
        ("adjust: {bearing_height_mm: {one: [-1, 2]}}", ["f.yaml:11:30: adjust.bearing_height_mm."
         "one: must be a whole number from 1 to 12 (got one)"]),
        ("adjust: {shim_deg: [1, 2]}", ["f.yaml:11:10: adjust.shim_deg: must reach from 0 or less "
         "to 0 or more: ranges count from where the part is (got [1, 2])"]),
        ("adjust: {shim_deg: [-1, 2], hold: [shims]}", ["f.yaml:11:36: adjust.hold[1]: nothing of "
         "this name has a range (got shims); did you mean shim?"]),
        ("limits: heavy", ["f.yaml:11:9: limits: heavy: there is no limit profile of this name; did "
         "you mean heavy-truck? A file of your own ends in .yaml"]),
        ("limits: ours.yaml", ["f.yaml:11:9: limits: a text by itself has no files next to it (got "
         "ours.yaml)"]),
        ("catalogues: ours.csv", ["f.yaml:11:13: catalogues: a text by itself has no files next to it "
         "(got ours.csv)"]),
        ("colour: red", ["f.yaml:11:1: colour: unknown key; there are: title, driveline, drivelines, "
         "torque_Nm, torque_kNm, torque_lbft, coast_torque_Nm, coast_torque_kNm, coast_torque_lbft, "
         "speed_rpm, speed_rad_s, vehicle, engine, gearbox, axle, tyre, suspension, states, "
         "obstacles, limits and 17 more"]),
    ],
)  # fmt: skip
def test_a_wrong_line_is_told_what_is_wrong(line, messages):
    assert refused(f"{SMALL}{line}\n") == messages


def test_all_that_is_wrong_is_said_at_once_in_the_order_of_the_file():
    text = SMALL.replace("speed_rpm: 2500", "speed_rpm: 2,5")
    text = text.replace("wall_mm: 3.2}, centre", "wall_mm: 60}, centre")  # no tube
    text = text.replace("phase_deg: 0", "phase_deg: zero")
    text += "torque_Nm: 3\nlimits: havy-truck\ngearbox: {ratios: [1, 2]}\n"
    places = [m.split(": ")[0] for m in refused(text)]
    keys = [m.split(": ")[1] for m in refused(text)]
    assert places == [
        f"f.yaml:{p}" for p in ("2:12", "9:58", "9:58", "10:75", "11:1", "12:9", "13:11")
    ]
    assert keys == [
        "speed_rpm",
        *["driveline.shafts[1].tube.wall_mm"] * 2,
        "driveline.shafts[2].phase_deg",
        "torque_Nm",
        "limits",
        "gearbox.ratios",
    ]


def test_a_file_with_everything_wrong_is_not_read_for_ever():
    wrong = "".join(f"key {k}: 1\n" for k in range(1000))
    assert len(refused(SMALL + wrong)) == MAX_ISSUES


def test_an_error_is_one_line_whatever_the_file_holds():
    (message,) = refused(SMALL + '"a\\n\\tb": 1\n')
    assert message.startswith("f.yaml:11:1: a  b: unknown key;")
    (message,) = refused(changed("length_mm: 1200", "length_mm: 12\n        00"))
    assert message.startswith(f"{NUMBER} (got 12 00)")


def test_a_file_that_is_no_table():
    assert refused("- a\n- b\n") == [
        "f.yaml:1:1: must be a table with title, driveline, drivelines, torque_Nm, coast_torque_Nm, "
        "speed_rpm, ... (got a list of 2)"
    ]


# --- what looks wrong but can be read -------------------------------------------------------


@pytest.mark.parametrize(
    ("old", "new", "warning"),
    [
        ("speed_rpm: 2500", "speed_rpm: 8", "f.yaml:2:12: speed_rpm: 8 rpm is unusually small; is "
         "it in Hz? then write 480 rpm"),
        ("torque_Nm: 8000", "torque_Nm: 8", "f.yaml:3:12: torque_Nm: 8 Nm is unusually small; did "
         "you mean torque_kNm?"),
        ("wall_mm: 3.2", "wall_mm: 0.126", "f.yaml:9:58: driveline.shafts[1].tube.wall_mm: 0.126 mm "
         "is unusually small; did you mean wall_in?"),
        ("length_mm: 1500", "length_mm: 59", "f.yaml:10:19: driveline.shafts[2].length_mm: 59 mm "
         "is unusually small; did you mean length_in?"),
        ("[3.0, 1.0, 4.5, 2.0]", "[0.05, 0.02, 0.08, 0.03]", "f.yaml:6:15: driveline.slopes."
         "side_deg: 0.08 deg is unusually small; did you mean side_rad?"),
        ("phase_deg: 0", "phase_deg: 1.5708", "f.yaml:10:75: driveline.shafts[2].phase_deg: 1.5708 "
         "deg looks like 90 deg in radians; did you mean phase_rad?"),
        ("  shafts:", "  joints: {angle_max_deg: 0.14}\n  shafts:", "f.yaml:8:27: driveline.joints."
         "angle_max_deg: 0.14 deg is unusually small; did you mean angle_max_rad?"),
        ("torque_Nm: 8000\n", "", "f.yaml:1:1: no torque is given: loads, strength and life cannot "
         "be checked; give torque_Nm, or an engine and a gearbox"),
        ("speed_rpm: 2500\n", "", "f.yaml:1:1: no speed is given: accelerations and critical speeds "
         "cannot be checked; give speed_rpm, or an engine and a gearbox"),
    ],
)  # fmt: skip
def test_an_odd_number_asks_for_its_unit(old, new, warning):
    application = loads(changed(old, new), name="f.yaml")
    told = [w.format_with_location("f.yaml") for w in application.warnings]
    assert warning in told
    # A wall so thin, or an angle so small, is no part's either.
    assert len(told) == 1 or re.search("shear in a tube|angle over that of its kind", told[0])


def test_small_numbers_beside_an_everyday_one_are_what_they_are():
    assert small("[3.0, 1.0, 4.5, 2.0]", "[0.05, 0.0, 0.3, 0.02]").warnings == ()


# --- files beside the application -----------------------------------------------------------

OURS = """\
name,outer_mm,wall_mm,material,source
our tube,90,3,our steel,drawing 4711
"""
STEELS = """\
name,youngs_modulus_GPa,density_kg_m3,yield_MPa,source
our steel,205,7800,500,mill sheet 12
"""


def beside(folder, **files):
    for name, text in files.items():
        (folder / name.replace("_", ".")).write_text(text, encoding="utf-8")
    return folder


def test_parts_of_the_users_own_come_from_files_beside(tmp_path):
    beside(tmp_path, ours_csv=OURS, steels_csv=STEELS)
    text = changed("tube: {outer_mm: 101.6, wall_mm: 3.2}", "tube: our tube")
    application = loads(f"{text}catalogues: [ours.csv, steels.csv]\n", folder=tmp_path)
    tube = application.lines[0].line.shafts[0].tube
    assert (tube.outer, tube.material.yield_strength) == (pytest.approx(0.09), 500e6)
    assert tube.material.source == Source("mill sheet 12")


def test_a_wrong_catalogue_is_told_where_it_is_named(tmp_path):
    beside(tmp_path, ours_csv=OURS.replace("90,3", "90,60").replace("source", "sauce"))
    text = changed("tube: {outer_mm: 101.6, wall_mm: 3.2}", "tube: our tube")
    file = tmp_path / "ours.csv"
    assert refused(f"{text}catalogues: ours.csv\n", folder=tmp_path) == [
        f"f.yaml:11:13: catalogues: {file}:1:5: sauce: unknown column; did you mean source?",
        f"f.yaml:11:13: catalogues: {file}:2:4: our tube.material: no catalogue has a material "
        "our steel; did you mean steel?",
    ]


def test_limits_come_from_a_file_beside(tmp_path):
    profile = "profile: ours\nlimits:\n  - {quantity: joint_angle, maximum: 7, source: us}\n"
    beside(tmp_path, ours_yaml=profile)
    application = loads(f"{SMALL}limits: ours.yaml\n", folder=tmp_path)
    assert application.profile == "ours"
    assert [limit.maximum for limit in application.limits] == [pytest.approx(7 * deg)]
    text = f"{SMALL}limits: {{profile: ours.yaml, overrides: [{{quantity: joint_angle, maximum: 9, " \
           "source: us}]}\n"  # fmt: skip
    replaced = loads(text, folder=tmp_path)
    assert [limit.maximum for limit in replaced.limits] == [pytest.approx(9 * deg)]


def test_limits_in_place_need_no_profile():
    text = f"{SMALL}limits:\n  - {{quantity: clearance, maximum: 20, source: us}}\n"
    (limit,) = loads(text).limits
    assert (limit.maximum, limit.sense) == (pytest.approx(0.02), ">=")


def test_a_wrong_profile_is_told_where_it_is_named(tmp_path):
    beside(tmp_path, ours_yaml="profile: ours\nlimits:\n  - {quantity: joint_angel, maximum: 7}\n")
    assert refused(f"{SMALL}limits: ours.yaml\n", folder=tmp_path) == [
        f"f.yaml:11:9: limits: {tmp_path / 'ours.yaml'}:3:5: limits[1]: source is missing: who says so"
    ]


FLANGES = """\
title: Flanges
torque_Nm: 3000
speed_rpm: 2000
driveline:
  slopes: {side_deg: [3, 1, 4.5, 2]}
  gearbox_flange: {stiffness_N_mm: 4000, mass_kg: 15}
  pinion_flange: {vertical_stiffness_N_mm: 2500, lateral_stiffness_N_mm: 6000, loss_factor: 0.03}
  shafts:
    - {length_mm: 1200, tube: 120x4, centre_bearing: {from_rear_joint_mm: 140, stiffness_N_mm: 200}}
    - {length_mm: 1500, tube: 120x4}
"""


def test_flanges_that_give():
    application = loads(FLANGES)
    line = application.lines[0].line
    assert line.gearbox_flange == Flange(stiffness=(4e6, 4e6), mass=15.0)
    assert line.pinion_flange == Flange(stiffness=(2.5e6, 6e6), loss_factor=0.03)
    assert line.rigid_body_mode_count == 6
    assert application.warnings == ()


@pytest.mark.parametrize(
    ("old", "new", "told"),
    [
        ("{stiffness_N_mm: 4000, mass_kg: 15}", "{mass_kg: 15}",
         "give stiffness_N_mm: without it a flange is rigid"),
        ("lateral_stiffness_N_mm: 6000, ", "",
         "lateral_stiffness_N_mm is missing: give both"),
        ("mass_kg: 15", "mass_kg: -15", "mass_kg"),
        ("loss_factor: 0.03", "loss_factor: 3", "loss_factor"),
    ],
)  # fmt: skip
def test_flanges_that_cannot_be(old, new, told):
    with pytest.raises(InvalidFileError, match=told):
        loads(FLANGES.replace(old, new))


def test_a_bracket_gives_beside_rubber_alone():
    """Of a rigid bearing its modes were wrong: 0 Hz."""
    bracket = "bracket: {stiffness_N_mm: [9000, 1400, 5200]}"
    loads(FLANGES.replace(", stiffness_N_mm: 200", f", stiffness_N_mm: 200, {bracket}"))
    with pytest.raises(InvalidFileError, match="the bearing has no stiffness"):
        loads(FLANGES.replace(", stiffness_N_mm: 200", f", {bracket}"))


def test_numbers_of_a_flange_vary():
    loss = np.array([0.01, 0.1])
    found = change(loads(FLANGES), {"driveline.pinion_flange.loss_factor": loss})
    assert np.ravel(found.lines[0].line.pinion_flange.loss_factor).tolist() == loss.tolist()


def test_a_flange_under_rigid_bearings_is_wondered_at():
    application = loads(FLANGES.replace(", stiffness_N_mm: 200", ""))
    assert any("no centre bearing of the line gives" in str(w) for w in application.warnings)
    soft = loads(FLANGES.replace("N_mm: 4000", "N_mm: 20"))
    assert any("flange's stiffness over" in str(w) for w in soft.warnings)


@pytest.mark.parametrize("slope", ["grade_percent: -5", "grade_deg: -3"])
def test_a_start_downhill_is_refused(slope):
    """It was taken and counted as level."""
    launch = "launch: {gear: 1, ramp_s: 0.5, SLOPE}\n"
    loads(FLANGES + launch.replace("SLOPE", slope.replace("-", "")))
    with pytest.raises(
        InvalidFileError, match=f"launch.{slope.partition(':')[0]}: a start downhill"
    ):
        loads(FLANGES + launch.replace("SLOPE", slope))
