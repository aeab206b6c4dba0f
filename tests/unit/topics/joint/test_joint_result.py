"""Two joints and limits, as the command and `cardan.joint` report them."""

import json
import sys

import numpy as np
import pytest
from click.testing import CliRunner

import cardan
from cardan.cli import cli
from cardan.core.errors import DesignError, MissingDependencyError
from cardan.physics.kinematics.joint_pair import pair_phasor
from cardan.render.i18n import LANGUAGE_CODES, Translator
from cardan.render.pdf import column_head
from cardan.render.text_layout import without_colours
from cardan.topics.joint import result_presentation as presentation
from cardan.topics.joint.joint_pair import JointPair
from cardan.topics.joint.single_joint import SingleJoint

BOTH = {"angle2": "4.5deg", "phase": "90deg"}


def run(*arguments: str):
    return CliRunner().invoke(cli, ["joint", *arguments])


def test_second_joint_out_of_phase_doubles_the_irregularity():
    result = run("--angle", "4.5deg", "--speed", "3600rpm", "--angle2", "4.5deg",
                 "--phase", "90deg", "--json")  # fmt: skip
    assert result.exit_code == 0
    found = json.loads(result.stdout)["pair"]
    cos = np.cos(np.radians(4.5)) ** 2
    assert found["output"]["irregularity"] == pytest.approx(1 / cos - cos, rel=1e-12)
    exact = np.degrees(np.arccos(cos))
    assert found["output"]["equivalent_angle_deg"] == pytest.approx(exact, rel=1e-9)
    assert found["output"]["ae7_equivalent_angle_deg"] == pytest.approx(4.5 * 2**0.5, rel=1e-12)
    assert (found["arrangement"], found["best_phase_deg"]) == ("W", 0)
    assert found["output_at_best_phase"]["irregularity"] == 0
    speed = np.array(found["curves"]["speed_rpm"])
    assert np.ptp(speed) / 3600 == pytest.approx(1 / cos - cos, rel=1e-9)  # 0 and 90 deg are rows


@pytest.mark.parametrize("plane", ["0deg", "180deg", "-180deg"])
def test_w_and_z_arrangement_leave_nothing_in_phase(plane):
    found = cardan.joint("12deg", "1000rpm", angle2="12deg", plane_angle=plane).pair
    assert found.arrangement == ("W" if plane == "0deg" else "Z")
    assert found.output.max_acceleration == 0
    assert found.output.angle == 0


def test_phase_for_given_planes_and_what_remains():
    found = cardan.joint("4deg", "3000rpm", angle2="3deg", plane_angle="40deg")
    assert found.pair.arrangement == ""
    assert found.pair.best_phase == pytest.approx(np.radians(40))
    again = cardan.joint("4deg", "3000rpm", angle2="3deg", plane_angle="40deg", phase="40deg")
    left = again.output.irregularity
    assert found.pair.output_at_best_phase.irregularity == pytest.approx(left, rel=1e-9)
    cos = np.cos(np.radians(4)) / np.cos(np.radians(3))  # the residual joint
    assert left == pytest.approx(1 / cos - cos, rel=1e-9)
    assert left < found.output.irregularity


def test_ae7_counts_phase_and_plane_in_the_same_sense_as_the_exact_pair():
    found = cardan.joint("0.8deg", "3000rpm", angle2="0.6deg", plane_angle="30deg", phase="20deg")
    left = (0.8**4 + 0.6**4 - 2 * 0.8**2 * 0.6**2 * np.cos(np.radians(2 * (20 - 30)))) ** 0.25
    assert np.degrees(found.pair.ae7_equivalent_angle) == pytest.approx(left, rel=1e-9)
    # small angles: AE-7 leaves out terms of β², 1e-4 here
    assert np.degrees(found.output.angle) == pytest.approx(left, rel=2e-4)


def test_largest_angle_for_limits_is_the_smaller_of_both():
    found = cardan.joint(
        speed="3600rpm", acceleration_limit="1000 rad/s²", irregularity_limit="0.5%"
    )
    by_name = {limit.quantity: limit for limit in found.limits}
    cos = (-0.005 + (0.005**2 + 4) ** 0.5) / 2  # 1/c - c = 0.5 %
    assert found.joint.angle == pytest.approx(np.arccos(cos), rel=1e-9)
    speed = 3600 * np.pi / 30
    assert by_name["acceleration"].approximate_angle == pytest.approx(1000**0.5 / speed)
    alone = cardan.joint(speed="3600rpm", acceleration_limit="1000rad/s2")
    theta = np.linspace(0, np.pi, 200_001)
    s2, c = np.sin(alone.joint.angle) ** 2, np.cos(alone.joint.angle)
    driven = speed * c / (1 - s2 * np.cos(theta) ** 2)
    peak = np.abs(np.gradient(driven, theta) * speed).max()
    assert peak == pytest.approx(1000, rel=1e-5)
    assert alone.keeps_limits


def test_output_beyond_limit_gives_exit_code_1():
    limit = ("--acceleration-limit", "1000rad/s2")
    both = ("--angle", "4.5deg", "--speed", "3600rpm", "--angle2", "4.5deg")
    assert run(*both, *limit).exit_code == 0
    beyond = run(*both, "--phase", "90deg", *limit)
    assert beyond.exit_code == 1
    assert "beyond" in beyond.stdout
    shown = next(line for line in beyond.stdout.splitlines() if "yoke phase of 0 ±" in line)
    tolerance = float(shown.split("±")[1].split()[0])
    for deviation, code in ((tolerance - 0.1, 0), (tolerance + 0.1, 1)):
        assert run(*both, "--phase", f"{deviation}deg", *limit).exit_code == code
    none = run("--angle", "9deg", "--speed", "3600rpm", "--angle2", "2deg", *limit)
    assert "No yoke phase keeps the limits" in none.stdout


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        ((), "needs its angle, or a limit"),
        (("--angle2", "4deg", "--irregularity-limit", "1%"), "need both angles"),
        (("--angle", "4deg", "--phase", "9deg"), "need a second joint, angle2"),
        (("--angle", "4deg", "--plane-angle", "9deg"), "need a second joint, angle2"),
        (("--angle", "4deg", "--angle2", "90deg"), "below 90 deg, where it locks; got 90 deg"),
        (
            ("--angle", "4deg", "--angle2", "4deg", "--phase", "400deg"),
            "yoke phase must be from -360 to 360 deg",
        ),
        (("--angle", "4deg", "--acceleration-limit", "0"), "limit of a joint must be above 0"),
        (("--angle", "4deg", "--acceleration-limit", "3g"), "must be in rad/s2 (got 3g)"),
    ],
)
def test_incomplete_or_impossible_arguments_are_rejected(arguments, said):
    result = run("--speed", "1000rpm", *arguments)
    assert result.exit_code == 2
    assert said in result.stderr
    for code in LANGUAGE_CODES[1:]:
        translated = run("--speed", "1000rpm", *arguments, "--lang", code)
        assert translated.exit_code == 2
        assert said not in translated.stderr


@pytest.mark.parametrize("code", LANGUAGE_CODES)
def test_two_joints_fit_terminal_in_every_language(code):
    say = Translator(code)
    found = cardan.joint(
        "4.5deg", "3600rpm", torque="1kNm", across="80mm", acceleration_limit="1000rad/s2",
        irregularity_limit="1%", **BOTH,
    )  # fmt: skip
    shown = without_colours(presentation.text_lines(found, say))
    assert max(map(len, shown.splitlines())) <= 80
    if code != "en":
        for english in ("equivalent angle", "output", "limits", "Second joint", "beyond"):
            assert english not in shown
    report = presentation.joint_report(found, say)
    assert len(report.chapters) == 2
    assert len(presentation.figures(found, say)) == 7


def test_joint_shows_itself_in_few_lines():
    one = cardan.joint("4.5deg", "3600rpm")
    assert repr(one).splitlines() == [
        "Universal joint at 4.5 deg, driven at 3600 rpm",
        "  irregularity 0.6175 %, acceleration ±877.6 rad/s², angle ±5.307 min",
    ]
    two = cardan.joint(4.5, 3600, **BOTH)  # deg and rpm
    assert len(repr(two).splitlines()) == 5
    assert repr(one.table()) == run("--angle", "4.5deg", "--speed", "3600rpm").stdout.rstrip("\n")
    assert two.to_dict()["pair"]["phase_deg"] == pytest.approx(90)


def test_frame_holds_output_and_shaft_between(monkeypatch):
    pytest.importorskip("pandas")
    two = cardan.joint("4.5deg", "3600rpm", **BOTH)
    frame = two.to_frame()
    assert len(frame) == 360
    # 1/c² - c² over 1/c - c is 1/c + c, which is 2 to 1e-5 here.
    ratio = np.ptp(frame["speed_rpm"]) / np.ptp(frame["shaft_speed_rpm"])
    assert ratio == pytest.approx(2, rel=1e-4)
    assert list(cardan.joint(4.5, 3600).to_frame()) == list(frame)[:4]
    monkeypatch.setitem(sys.modules, "pandas", None)
    with pytest.raises(MissingDependencyError, match=r"a frame needs pandas: .*cardan\[frame\]"):
        two.to_frame()


@pytest.mark.slow
def test_plot_draws_output_and_shaft_between(monkeypatch):
    pytest.importorskip("matplotlib").use("Agg")
    from matplotlib import pyplot as plt

    two = cardan.joint("4.5deg", "3600rpm", **BOTH)
    axes = two.plot()
    assert [len(axis.lines) for axis in axes] == [2, 2, 2]
    highest = axes[2].lines[1].get_ydata().max()
    assert highest == pytest.approx(two.output.max_acceleration, rel=1e-4)
    assert [len(axis.lines) for axis in cardan.joint(4.5, 3600).plot()] == [1, 1, 1]
    plt.close("all")
    monkeypatch.setitem(sys.modules, "matplotlib", None)
    with pytest.raises(MissingDependencyError, match="a plot needs matplotlib: install"):
        two.plot()


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        ({"angle": "4.5deg"}, "needs a speed"),
        ({"angle": "steep", "speed": 1000}, "angle: must be a number with its unit, like 4.5deg"),
        ({"angle": 4, "speed": "3Hz"}, "speed: must be in rpm or rad/s"),
    ],
)
def test_argument_in_wrong_unit_is_named(arguments, said):
    with pytest.raises(DesignError, match=said):
        cardan.joint(**arguments)


@pytest.mark.parametrize("code", LANGUAGE_CODES)
def test_no_two_columns_of_a_document_have_the_same_head(code):
    """The heads of the two yokes were cut to the same letters, and lost their unit."""
    say = Translator(code)
    for more in ({}, {"angle2": "6deg"}):
        table = presentation.turn_table(cardan.joint("8deg", "2000rpm", **more), say)
        heads = [column_head(head, number=True) for head in table.head]
        assert len(set(heads)) == len(heads)
        assert all(head.endswith("]") for head in heads)


def test_output_of_two_joints_has_their_phasor_by_angle_and_pin():
    """tan²(β/2) e^{2iα}, α how far its pin is ahead of joint 1's: 4 and 6 deg, odd phase."""
    first = SingleJoint(angle=np.radians(4.0), speed=100.0)
    made = JointPair(first=first, angle2=np.radians(6.0), phase=0.7, plane_angle=0.4)
    ahead = made.output.pin - first.pin
    found = np.tan(made.output.angle / 2) ** 2 * np.exp(2j * ahead)
    expected = pair_phasor(first.angle, made.angle2, phase=0.7, plane_angle=0.4)
    assert found == pytest.approx(complex(expected), rel=1e-12)
