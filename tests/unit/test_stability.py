"""`cardan stability`: gears against resonances and zones, in the words of `check`."""

import json
import re
from dataclasses import replace
from xml.etree import ElementTree as ET

import numpy as np
import pytest
from click.testing import CliRunner

from cardan import files
from cardan.base.errors import BadFile
from cardan.base.part import Occasion, Part
from cardan.base.units import rpm
from cardan.cli import cli
from cardan.dynamics.torsion import mode_shapes, natural_frequencies, of_line
from cardan.model.application import Surroundings
from cardan.report.language import EN
from cardan.report.stability import campbell, worst_of_parts
from cardan.study.approval import approve
from cardan.study.stability import stability
from cardan.study.studies import VibrationStudy


@pytest.fixture(scope="module")
def truck(tmp_path_factory):
    file = tmp_path_factory.mktemp("truck") / "truck.yaml"
    file.write_text(files.starter("truck"), encoding="utf-8")
    return file


def test_frequencies_follow_from_the_parts(truck):
    """Two shafts and the axle between a uniform gearbox and free: springs by hand."""
    application = files.read(truck)
    (line,) = stability(application, surroundings=Surroundings(axle_inertia=2.0)).lines
    first, second = line.line.shafts
    k1, k2 = (
        s.tube.material.shear_modulus * 2 * s.tube.second_moment / s.length for s in (first, second)
    )
    J1 = (first.polar_inertia + second.polar_inertia) / 2
    J2 = second.polar_inertia / 2 + 2.0
    # Two by two: w^2 of J1 q1'' + (k1 + k2) q1 - k2 q2, J2 q2'' + k2 (q2 - q1).
    trace, product = (k1 + k2) / J1 + k2 / J2, k1 * k2 / (J1 * J2)
    low = (trace - np.sqrt(trace**2 - 4 * product)) / 2
    assert line.frequencies[0] == pytest.approx(np.sqrt(low), rel=1e-9)
    assert np.prod(line.frequencies**2) == pytest.approx(product, rel=1e-9)


@pytest.mark.parametrize("ratio", [0.02, 0.11])
def test_the_first_mode_is_damped_as_asked(truck, ratio):
    """Its motion alone is q'' + 2 ζ w q' + w² q = 0: the mass-normalised shape says C to ζ."""
    (installed,) = files.read(truck).lines
    made = of_line(
        installed.line, installed.layout.directions, axle_inertia=2.0, damping_ratio=ratio
    )
    _, C, _ = made.mean_matrices
    shape, w = mode_shapes(made)[:, 0], natural_frequencies(made)[0]
    assert shape @ C @ shape == pytest.approx(2 * ratio * w, rel=1e-9)


def test_a_gear_that_runs_through_a_resonance_warns(truck):
    found = approve(files.read(truck), (VibrationStudy(),))
    (line,) = found.of("vibration").lines
    order2 = line.frequencies[0] / 2
    for check in found.checks:
        if check.quantity != "torsional_resonance" or check.part != Part("mode", 1, 2):
            continue
        low, high = line.ranges[line.gears.index(check.when)]
        near = low / 1.1 < order2 < high / 0.9
        assert (check.grade == "warn") == near
    assert found.verdict == "warn"


def test_the_forced_torque_peaks_at_the_resonance(truck):
    (line,) = stability(files.read(truck)).lines
    for state in range(len(line.states)):
        peak = line.speeds[line.amplitudes[state, 0].argmax()]
        assert peak == pytest.approx(line.frequencies[0] / 2, rel=0.03)


def test_order_4_is_far_below_order_2(truck):
    """By about tan²(β/2), the ratio of a joint's own orders, times a resonance."""
    (line,) = stability(files.read(truck)).lines
    low, high = line.amplitudes[:, 1].max(-1), line.amplitudes[:, 0].max(-1)
    assert np.all(low < 0.05 * high)


def test_damping_is_what_keeps_zones_closed(truck):
    """Without it a line that runs in its zone grows, and the verdict fails."""
    application = files.read(truck)
    damped = stability(application)
    loose = stability(application, surroundings=Surroundings(damping_ratio=1e-5))
    rates = [max(z.growth.max() for z in s.lines[0].zones) for s in (damped, loose)]
    assert rates[0] < 0
    assert rates[0] < rates[1]
    slow = replace(
        application, engine=None, gearbox=None, speed=float(damped.lines[0].frequencies[0])
    )
    loose_study = VibrationStudy(Surroundings(damping_ratio=1e-5))
    assert approve(slow, (loose_study,)).verdict == "fail"
    assert approve(slow, (VibrationStudy(),)).verdict != "fail"


HUNG = """
title: A shaft on rubber
speed_rpm: 1000
torque_Nm: 20
driveline:
  slopes: {side_deg: [1, 1, 1, 1]}
  shafts:
    - {length_mm: 1200, tube: 120x6, yoke_mass_kg: [5, 7],
       centre_bearing: {from_rear_joint_mm: 300, stiffness_N_mm: 20}}
    - {length_mm: 1500, tube: 120x6}
"""


def test_a_hung_shaft_swings_about_its_joint_like_a_rod():
    """On soft rubber, hardly any torque: w² = k / (m L/3 + M) and decay η w / 2, L to the bearing.

    The rod bends a little and turns: 3 %.
    """
    application = files.loads(HUNG)
    (line,) = stability(application, surroundings=Surroundings(rubber_loss=0.1)).lines
    tube = line.line.shafts[0].tube
    swing = np.sqrt(20e3 / (tube.mass_per_length * 0.9 / 3 + 7))
    assert line.lateral[0, 0] == pytest.approx(-0.1 * swing / 2, rel=0.03)


def one_hung(text):
    """One line on rubber with a loss factor of 0.1, its shaft's tube, and the shaft's swing."""
    (line,) = stability(files.loads(text), surroundings=Surroundings(rubber_loss=0.1)).lines
    shaft = line.line.shafts[0]
    length = shaft.length - shaft.centre_bearing.from_rear_joint
    swung = shaft.tube.mass_per_length * length / 3 + shaft.yoke_mass[1]
    return line, shaft.tube, length, swung


def uneven(vertical, lateral, speed=1000, torque=20):
    """The hung shaft with another stiffness up and down than from side to side, N/mm."""
    both = f"vertical_stiffness_N_mm: {vertical}, lateral_stiffness_N_mm: {lateral}"
    text = HUNG.replace("stiffness_N_mm: 20", both).replace("torque_Nm: 20", f"torque_Nm: {torque}")
    return text.replace("speed_rpm: 1000", f"speed_rpm: {speed}")


@pytest.mark.parametrize("vertical", [4, 36])
def test_rubber_damps_by_its_mean_stiffness_whichever_way_is_the_stiffer(vertical):
    """Its damper is one for both ways: with hardly any torque they decay alike, at η w / 2."""
    line, _, _, swung = one_hung(uneven(vertical, 40 - vertical))
    assert line.lateral[0, 0] == pytest.approx(-0.05 * np.sqrt(20e3 / swung), rel=0.01)


@pytest.mark.parametrize("way", [26, 14])
def test_torque_shakes_a_hung_shaft_where_it_swings_once_a_turn(way):
    """The joint acts twice a turn: the zone of each way lies where the shaft turns at its swing.

    Half way up to the next one, 4 % beside it, nothing of that is left.
    """
    swung = one_hung(HUNG)[-1]
    own = np.sqrt(way * 1e3 / swung) / rpm
    at, *beside = (
        one_hung(uneven(26, 14, speed=f * own, torque=2000))[0].lateral[0, 0]
        for f in (1, 0.96, 1.04)
    )
    assert at > max(beside) + 0.4


def test_a_short_wide_shaft_swings_slower_by_what_it_takes_to_turn_it():
    """Rotary inertia m r²/2 to the length adds a twelfth to what swings: 0.04 % are left."""
    text = (
        HUNG.replace("1200, tube: 120x6", "700, tube: {outer_mm: 200, wall_mm: 2}")
        .replace("[5, 7]", "[5, 0.5]")
        .replace("from_rear_joint_mm: 300", "from_rear_joint_mm: 350")
        .replace("speed_rpm: 1000", "speed_rpm: 60")
        .replace("torque_Nm: 20", "torque_Nm: 2")
    )
    line, tube, length, rod = one_hung(text)
    turned = tube.mass_per_length * (0.1**2 + 0.098**2) / 4 / length
    assert turned > 0.08 * rod
    decay = 0.05 * np.sqrt(20e3 / rod) * rod / (rod + turned)
    assert line.lateral[0, 0] == pytest.approx(-decay, rel=1e-3)


TWO_GEARS = """
title: Two gears
engine: {speed_rpm: [1000, 3100], torque_Nm: [1000, 1000]}
gearbox: {ratios: [8, 1]}
driveline:
  slopes: {side_deg: [0, 9, 1, 6]}
  shafts:
    - {length_mm: 1200, tube: 120x6, centre_bearing: {from_rear_joint_mm: 140}}
    - {length_mm: 1500, tube: 120x6}
"""


def test_a_zone_that_one_gear_reaches_grows_under_the_torque_of_that_gear():
    """First gear's eightfold torque is none of the top gear's business."""
    rates = []
    for text in (
        TWO_GEARS,
        TWO_GEARS.replace("[8, 1]", "[1]"),
        TWO_GEARS.replace("1000]}", "8000]}"),
    ):
        around = Surroundings(damping_ratio=0.005)
        (line,) = stability(files.loads(text), surroundings=around).lines
        zone = line.zones[0]
        assert line.ranges[-1, 0] < zone.speed < line.ranges[-1, 1]
        rates.append(zone.growth[0])
    assert rates[0] == pytest.approx(rates[1], rel=1e-9)
    assert abs(rates[2] / rates[1] - 1) > 1e-3  # torque does count there


def test_a_line_without_gears_is_asked_at_its_top_speed():
    """The fastest of its states, not the slowest."""
    states = "states: [{name: slow, speed_rpm: 500}, {name: fast, speed_rpm: 1500}]\n"
    (line,) = stability(files.loads(HUNG.replace("speed_rpm: 1000\n", "") + states)).lines
    assert line.ranges / rpm == pytest.approx(np.array([[1500, 1500]]))


def test_an_engine_beyond_what_the_tyres_hold_shakes_no_harder(truck):
    """On ice the wheels slip in first gear, whatever the engine gives."""
    application = files.read(truck)
    ice = replace(application, tyre=replace(application.tyre, friction=0.05))
    engine = replace(ice.engine, torque=tuple(3 * t for t in ice.engine.torque))
    (weak,), (strong,) = (stability(a).lines for a in (ice, replace(ice, engine=engine)))
    first = weak.gears.index(Occasion("gear", "1"))
    assert first == 0
    assert strong.amplitudes == pytest.approx(weak.amplitudes, rel=1e-9)


def test_command_writes_contract_and_chart(truck, tmp_path):
    chart = tmp_path / "chart.svg"
    run = CliRunner().invoke(cli, ["stability", str(truck), "--json", "--chart", str(chart)])
    assert run.exit_code == 0
    document = json.loads(run.stdout)
    assert document["verdict"] == "warn"
    assert document["assumed"]["axle_inertia_kgm2"] == 2.0
    line = document["lines"][0]
    assert [g["name"] for g in line["gears"]][:2] == ["gear 1", "gear 2"]
    assert line["gears"][-1]["speed_rpm"][1] == pytest.approx(2500)
    assert {c["quantity"] for c in document["checks"]} == {
        "torsional_resonance", "torsional_growth", "lateral_growth"
    }  # fmt: skip
    drawn = "".join(ET.parse(chart).getroot().itertext())
    assert f"mode 1, {line['torsional_frequencies_Hz'][0]:.1f} Hz" in drawn
    assert "order 4" in drawn


def test_resonances_are_drawn_where_orders_meet_frequencies(truck):
    """Every circle lies on a slanted line, to the rounding of a pixel's hundredth."""
    (line,) = stability(files.read(truck)).lines
    root = ET.fromstring(campbell(line, EN).svg)
    drawn = [e for e in root.iter() if e.tag.endswith("path")]
    ends = [[float(x) for x in re.findall(r"[-0-9.]+", e.attrib["d"])] for e in drawn]
    slanted = [p for p in ends if len(p) == 4 and p[0] != p[2] and p[1] != p[3]]
    assert len(slanted) == 2
    rings = [e for e in root.iter() if e.tag.endswith("circle") and e.attrib["fill"] == "none"]
    top = 1.1 * line.ranges.max()
    assert len(rings) == sum(w / o < top for w in line.frequencies for o in (2, 4))
    assert rings
    for ring in rings:
        x, y = float(ring.attrib["cx"]), float(ring.attrib["cy"])
        off = [abs(y - (b + (x - a) / (c - a) * (d - b))) for a, b, c, d in slanted]
        assert min(off) < 0.1


def test_the_worst_gear_speaks_for_each_part(truck):
    """Without --all a resonance has one row, and no gear is nearer to it than that one."""
    checks = approve(files.read(truck), (VibrationStudy(),)).checks
    shown = {(c.quantity, c.part): c for c in worst_of_parts(checks)}
    assert set(shown) == {(c.quantity, c.part) for c in checks}
    assert len(shown) < len(checks)
    for c in checks:
        assert shown[c.quantity, c.part].margin <= c.margin
    printed = CliRunner().invoke(cli, ["stability", str(truck)]).stdout.splitlines()
    mode = [x for x in printed if "Speed over torsional resonance" in x and "mode 1, order 2" in x]
    assert [x[:4] for x in mode] == ["warn"]


def test_command_prints_what_it_assumes(truck):
    run = CliRunner().invoke(cli, ["stability", str(truck), "--axle-inertia", "3"])
    assert run.exit_code == 0
    assert "axle 3.000 kg m²" in run.stdout
    assert "Speed over torsional resonance" in run.stdout


@pytest.mark.parametrize(("most", "code"), [(1000, 0), (-1000, 1)])
def test_the_exit_code_is_the_verdict_on_what_vibrates(tmp_path, most, code):
    limit = f"{{quantity: torsional_growth, maximum: {most}, source: us}}"
    file = tmp_path / "small.yaml"
    text = files.starter("small").replace("limits: protractor", f"limits: [{limit}]")
    file.write_text(text, encoding="utf-8")
    run = CliRunner().invoke(cli, ["stability", str(file)])
    assert run.exit_code == code
    assert run.stdout.splitlines()[0].startswith(f"Two-piece driveline: {('PASS', 'FAIL')[code]}")


def test_half_a_gearbox_is_refused(truck):
    run = CliRunner().invoke(cli, ["stability", str(truck), "--gearbox-inertia", "1"])
    assert run.exit_code == 2
    assert "both the gearbox inertia and its stiffness" in run.stderr


def test_a_small_file_is_enough(tmp_path):
    file = tmp_path / "small.yaml"
    file.write_text(files.starter("small"), encoding="utf-8")
    (line,) = stability(files.read(file)).lines
    assert line.gears == (Occasion("speed", "top speed"),)
    assert line.ranges[0, 0] / rpm == pytest.approx(2500)


TORSION = """
torsion:
  axle_inertia_kgm2: 3
  axle_stiffness_Nm_deg: 900
  gearbox_inertia_kgm2: 0.3
  gearbox_stiffness_Nm_rad: 90000
"""


def test_the_file_says_what_turns_at_both_ends(truck, tmp_path):
    """Its units, what it leaves out, and the options that go before it."""
    application = files.loads(truck.read_text("utf-8") + TORSION)
    found = stability(application)
    around = found.surroundings
    assert around.axle_stiffness == pytest.approx(900 * 180 / np.pi)
    assert (around.gearbox_inertia, around.gearbox_stiffness) == (0.3, 90000)
    assert found.given == {
        "axle_inertia", "axle_stiffness", "gearbox_inertia", "gearbox_stiffness"
    }  # fmt: skip
    assert around.damping_ratio == 0.02
    # Flange, joint between the shafts, pinion, axle.
    assert found.lines[0].frequencies.shape == (4,)
    file = tmp_path / "given.yaml"
    file.write_text(truck.read_text("utf-8") + TORSION, encoding="utf-8")
    run = CliRunner().invoke(cli, ["stability", str(file), "--axle-inertia", "4", "--json"])
    said = json.loads(run.stdout)
    assert said["given"]["axle_inertia_kgm2"] == 4
    assert said["given"]["gearbox_inertia_kgm2"] == 0.3
    assert said["assumed"] == {"damping_ratio": 0.02, "rubber_loss": 0.1}
    run = CliRunner().invoke(cli, ["stability", str(file)])
    assert "Given: gearbox 0.3000 kg m² on 90000 N m/rad; axle 3.000 kg m²" in run.stdout
    assert "Assumed: damping ratio 0.02000" in run.stdout


@pytest.mark.parametrize(
    ("torsion", "problem"),
    [
        ("{gearbox_inertia_kgm2: 1}", "both the gearbox inertia and its stiffness"),
        ("{axle_inertia_kgm2: 0}", "at least 1e-09"),
        ("{damping_ratio: 1}", "of at least 1e-05 and below 1"),
        ("{axle_stifness_Nm_deg: 1}", "axle_stiffness_Nm_deg"),
    ],
)
def test_wrong_surroundings_are_refused_where_they_stand(truck, torsion, problem):
    with pytest.raises(BadFile, match=problem):
        files.loads(truck.read_text("utf-8") + f"torsion: {torsion}\n")
