"""One joint by itself, as books work it out, and as its own curves come to it."""

import json

import numpy as np
import pytest
from click.testing import CliRunner

from cardan.cli import cli
from cardan.core.errors import DesignError
from cardan.core.units import UNITS, deg, mm, rpm
from cardan.physics.kinematics.hooke_joint import PIN_NORMAL_TO_PLANE
from cardan.render.i18n import LANGUAGE_CODES, Translator
from cardan.render.text_layout import without_colours
from cardan.schema import quantity_parser as byhand
from cardan.topics.joint import result_presentation as presentation
from cardan.topics.joint.joint_result import JointResult
from cardan.topics.joint.single_joint import SingleJoint


def run(*arguments: str):
    return CliRunner().invoke(cli, ["joint", *arguments])


def test_single_joint_matches_souza_2014_figures():
    """Souza (2014), figures 26 to 28: 4 deg 30 min at 3600 rpm."""
    result = run("--angle", "4deg30min", "--speed", "3600rpm", "--json")
    found = json.loads(result.stdout)
    assert found["position"]["largest_min"] == pytest.approx(5.307, abs=5e-4)
    assert found["speed"]["least_rpm"] == pytest.approx(3588.9, abs=0.05)
    assert found["speed"]["largest_rpm"] == pytest.approx(3611.1, abs=0.05)
    assert found["acceleration"]["largest_rad_s2"] == pytest.approx(877.6, abs=0.05)
    shown = run("--angle", "4.5deg", "--speed", "3600rpm").stdout
    for said in ("±5.307", "3588.9", "3611.1", "±877.6"):
        assert said in shown


@pytest.mark.parametrize("angle", [0.5, 4.5, 20, 44])
@pytest.mark.parametrize("pin", [0.0, PIN_NORMAL_TO_PLANE])
def test_reported_maxima_match_curves_over_one_turn(angle, pin):
    joint = SingleJoint(angle=angle * deg, speed=100.0, torque=1000.0, across=80 * mm, pin=pin)
    c = joint.curves_over_turn(np.linspace(0, 2 * np.pi, 72_001))
    assert c.driven_torque is not None
    assert c.secondary_couples is not None
    pairs = [
        (joint.max_lead_angle, c.lead_angle),
        (joint.driven_speed_range[1], c.driven_speed),
        (joint.max_acceleration, c.driven_acceleration),
        (joint.max_cross_rates[0], c.cross_motion.driving_rate),
        (joint.max_cross_rates[1], c.cross_motion.driven_rate),
        (joint.driven_torque_range[1], c.driven_torque),
        (joint.max_secondary_couples[0], c.secondary_couples[0]),
        (joint.max_secondary_couples[1], c.secondary_couples[1]),
    ]
    for said, curve in pairs:  # a grid of 0.005 deg misses a peak by its curvature, 4e-9 of it
        assert np.abs(curve).max() == pytest.approx(said, rel=1e-7)
    for at, curve in (
        (joint.max_lead_input_angles, "lead_angle"),
        (joint.max_acceleration_input_angles, "driven_acceleration"),
    ):
        there = np.abs(getattr(joint.curves_over_turn(at), curve))
        assert there == pytest.approx(np.abs(getattr(c, curve)).max(), rel=1e-7)


def test_torque_and_secondary_couple_have_equal_resultant_on_both_shafts():
    """Torques and couples of both shafts are one moment: T² + couple² is the same on each."""
    joint = SingleJoint(angle=25 * deg, speed=100.0, torque=1000.0)
    c = joint.curves_over_turn(np.linspace(0, np.pi, 37))
    assert c.driven_torque is not None
    assert c.secondary_couples is not None
    first, second = c.secondary_couples
    assert 1000.0**2 + first**2 == pytest.approx(c.driven_torque**2 + second**2, rel=1e-12)


def test_joint_angle_of_90_deg_and_zero_speed_are_rejected():
    for arguments in (("--angle", "90", "--speed", "1"), ("--angle", "3", "--speed", "0")):
        result = run(*arguments)
        assert result.exit_code == 2
    with pytest.raises(DesignError, match="below 90 deg"):
        SingleJoint(angle=2.0, speed=1.0)


@pytest.mark.parametrize("angle", ["54.7deg", "54.8deg", "60deg", "89deg"])
def test_max_acceleration_is_exact_beyond_range_of_approximation(angle):
    """Omar's eq. 6 asks for a cosine above 1 from sin² β = 2/3 on, 54.74 deg."""
    done = CliRunner().invoke(cli, ["joint", "--angle", angle, "--speed", "1000rpm", "--json"])
    assert done.exit_code == 0
    found = json.loads(done.stdout)["acceleration"]
    theta = np.linspace(0, np.pi, 200_001)
    beta, w = float(angle[:-3]) * deg, 1000 * np.pi / 30
    speed = np.cos(beta) / (1 - np.sin(beta) ** 2 * np.cos(theta) ** 2) * w
    curve = np.abs(np.gradient(speed, theta) * w).max()
    assert found["largest_rad_s2"] == pytest.approx(curve, rel=1e-4)
    omar = found["approximations_rad_s2"].pop("omar_eq6")
    assert (omar is None) == (angle != "54.7deg")
    assert omar is None or 0 < omar < found["largest_rad_s2"]
    assert all(found["approximations_rad_s2"].values())
    printed = CliRunner().invoke(cli, ["joint", "--angle", angle, "--speed", "1000rpm"])
    assert printed.exit_code == 0
    assert ("none" in printed.stdout) == (omar is None)


@pytest.mark.parametrize("code", LANGUAGE_CODES)
def test_single_joint_report_fits_terminal_in_every_language(code):
    say = Translator(code)
    joint = JointResult(
        joint=SingleJoint(angle=4.5 * deg, speed=3600 * rpm, torque=1000.0, across=80 * mm)
    )
    lines = without_colours(presentation.text_lines(joint, say)).splitlines()
    assert max(map(len, lines)) <= 80
    assert not any("-0" in line.replace("-0.", "").split() for line in lines)
    assert len(presentation.joint_report(joint, say).chapters) == 2


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("3°30'", 3.5), ("4deg30min", 4.5), ("-4 deg 30 min", -4.5), ("4°30′36″", 4.51),
        ("4.5deg", None), ("4°75'", None), ("4.5", None), ("30'", 0.5),
        ("-36'", -0.6), ("1°02'", 1 + 2 / 60), ("1° 2' 30\"", 1 + 2.5 / 60), ("0°36’", 0.6),
        ("−0°36′", -0.6), ("–1º02´30″", -1 - 2.5 / 60), ("+7'30''", 0.125), ("90'", 1.5),
        ("1°2'75\"", None), ("1'30", None), ("1°02", None), ("'", None), ("", None), ("-", None),
    ],
)  # fmt: skip
def test_angle_in_degrees_and_minutes_is_parsed(text, value):
    assert byhand.parse_degrees(text) == (
        None if value is None else pytest.approx(value, rel=1e-12)
    )


@pytest.mark.parametrize(
    ("text", "value"),
    [("55 1/4", 55.25), ("55-1/4", 55.25), ("1/8", 0.125), ("-3½", -3.5), ("55.25", None),
     ("1/0", None)],
)  # fmt: skip
def test_fraction_is_parsed(text, value):
    assert byhand.parse_fraction(text) == value


@pytest.mark.parametrize(
    ("text", "units", "value"),
    [
        ("4.5deg", ("deg", "rad"), 4.5 * deg), ("4.5", ("deg", "rad"), 4.5 * deg),
        ("4°30'", ("deg", "rad"), 4.5 * deg), ("-36'", ("deg", "rad"), -0.6 * deg),
        ("4°", ("deg", "rad"), 4 * deg), ("0.1 rad", ("deg", "rad"), 0.1),
        ("377rad/s", ("rpm", "rad_s"), 377.0), ("1 kN·m", ("Nm", "kNm"), 1000.0),
        ("3 1/8 in", ("mm", "in"), 3.125 * 25.4 * mm),
    ],
)  # fmt: skip
def test_option_value_with_unit_is_parsed(text, units, value):
    assert byhand.parse_quantity(text, {u: UNITS[u] for u in units}) == pytest.approx(
        value, rel=1e-12
    )


@pytest.mark.parametrize(
    ("text", "advice"),
    [("4,5deg", "write 4.5deg"), ("4cm", "must be in deg or rad"), ("", "like 4.5deg"),
     ("steep", "like 4.5deg")],
)  # fmt: skip
def test_invalid_option_value_error_shows_expected_format(text, advice):
    with pytest.raises(DesignError, match=advice):
        byhand.parse_quantity(text, {u: UNITS[u] for u in ("deg", "rad")})
