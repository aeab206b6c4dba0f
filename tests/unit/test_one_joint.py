"""One joint by itself, as books work it out, and as its own curves come to it."""

import json

import numpy as np
import pytest
from click.testing import CliRunner

from cardan.base.errors import DesignError
from cardan.base.units import UNITS, deg, mm, rpm
from cardan.border import byhand
from cardan.cli import cli
from cardan.kinematics.joint import NORMAL
from cardan.report import one_joint
from cardan.report.language import CODES, Language
from cardan.report.screen import bare
from cardan.study.one_joint import OneJoint


def run(*arguments: str):
    return CliRunner().invoke(cli, ["joint", *arguments])


def test_the_joint_of_the_dissertations_figures():
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
@pytest.mark.parametrize("pin", [0.0, NORMAL])
def test_what_is_said_to_be_largest_is_the_largest_of_the_curves(angle, pin):
    joint = OneJoint(angle=angle * deg, speed=100.0, torque=1000.0, across=80 * mm, pin=pin)
    c = joint.round(np.linspace(0, 2 * np.pi, 72_001))
    assert c.torque is not None
    assert c.couples is not None
    pairs = [
        (joint.lead, c.lead), (joint.speeds[1], c.speed), (joint.acceleration, c.acceleration),
        (joint.cross_rates[0], c.cross.driving_rate), (joint.cross_rates[1], c.cross.driven_rate),
        (joint.torques[1], c.torque), (joint.couples[0], c.couples[0]),
        (joint.couples[1], c.couples[1]),
    ]  # fmt: skip
    for said, curve in pairs:  # a grid of 0.005 deg misses a peak by its curvature, 4e-9 of it
        assert np.abs(curve).max() == pytest.approx(said, rel=1e-7)
    for at, curve in ((joint.lead_at, "lead"), (joint.acceleration_at, "acceleration")):
        there = np.abs(getattr(joint.round(at), curve))
        assert there == pytest.approx(np.abs(getattr(c, curve)).max(), rel=1e-7)


def test_secondary_couples_close_the_balance_of_the_joint():
    """Torques and couples of both shafts are one moment: T² + couple² is the same on each."""
    joint = OneJoint(angle=25 * deg, speed=100.0, torque=1000.0)
    c = joint.round(np.linspace(0, np.pi, 37))
    assert c.torque is not None
    assert c.couples is not None
    first, second = c.couples
    assert 1000.0**2 + first**2 == pytest.approx(c.torque**2 + second**2, rel=1e-12)


def test_a_joint_that_cannot_be_is_refused():
    for arguments in (("--angle", "90", "--speed", "1"), ("--angle", "3", "--speed", "0")):
        result = run(*arguments)
        assert result.exit_code == 2
    with pytest.raises(DesignError, match="below 90 deg"):
        OneJoint(angle=2.0, speed=1.0)


@pytest.mark.parametrize("angle", ["54.7deg", "54.8deg", "60deg", "89deg"])
def test_where_an_approximation_has_no_answer_the_joint_still_has_one(angle):
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


@pytest.mark.parametrize("code", CODES)
def test_a_joint_is_told_in_every_language_and_fits(code):
    say = Language(code)
    joint = OneJoint(angle=4.5 * deg, speed=3600 * rpm, torque=1000.0, across=80 * mm)
    lines = bare(one_joint.terminal(joint, say)).splitlines()
    assert max(map(len, lines)) <= 80
    assert not any("-0" in line.replace("-0.", "").split() for line in lines)
    assert len(one_joint.story(joint, say).chapters) == 2


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("3°30'", 3.5), ("4deg30min", 4.5), ("-4 deg 30 min", -4.5), ("4°30′36″", 4.51),
        ("4.5deg", None), ("4°75'", None), ("4.5", None), ("30'", None),
    ],
)  # fmt: skip
def test_degrees_and_minutes(text, value):
    assert byhand.degrees(text) == (None if value is None else pytest.approx(value, rel=1e-12))


@pytest.mark.parametrize(
    ("text", "value"),
    [("55 1/4", 55.25), ("55-1/4", 55.25), ("1/8", 0.125), ("-3½", -3.5), ("55.25", None),
     ("1/0", None)],
)  # fmt: skip
def test_fractions(text, value):
    assert byhand.fraction(text) == value


@pytest.mark.parametrize(
    ("text", "units", "value"),
    [
        ("4.5deg", ("deg", "rad"), 4.5 * deg), ("4.5", ("deg", "rad"), 4.5 * deg),
        ("4°30'", ("deg", "rad"), 4.5 * deg), ("0.1 rad", ("deg", "rad"), 0.1),
        ("377rad/s", ("rpm", "rad_s"), 377.0), ("1 kN·m", ("Nm", "kNm"), 1000.0),
        ("3 1/8 in", ("mm", "in"), 3.125 * 25.4 * mm),
    ],
)  # fmt: skip
def test_a_measure_of_an_option(text, units, value):
    assert byhand.measure(text, {u: UNITS[u] for u in units}) == pytest.approx(value, rel=1e-12)


@pytest.mark.parametrize(
    ("text", "advice"),
    [("4,5deg", "write 4.5deg"), ("4cm", "must be in deg or rad"), ("", "like 4.5deg"),
     ("steep", "like 4.5deg")],
)  # fmt: skip
def test_a_measure_that_is_none_says_what_to_write(text, advice):
    with pytest.raises(DesignError, match=advice):
        byhand.measure(text, {u: UNITS[u] for u in ("deg", "rad")})
