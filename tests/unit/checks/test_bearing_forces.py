"""What centre bearings carry on rubber, from an application file to what is printed of it."""

import json
import re
from collections.abc import Iterable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner
from repository import EXAMPLES

from cardan.application import overrides, reader
from cardan.approval.approval import approve_driveline
from cardan.checks.line_response import compute_line_response
from cardan.cli import cli
from cardan.core.units import rpm
from cardan.physics.vehicle.state_demand import line_state_demand, resolve_line_references

SPEEDS = {100: 21.2516, 426.6: 207.225, 500: 105.955, 551.3: 204.108}
"""rpm and N: order 2 on a bearing, by EXUDYN with moving geometry (METHOD section 15)."""


def tube(mass: float, length: float) -> str:
    """A tube of a mass, kg, as a file can say it: stiff, thin, nearly slender; length in m."""
    wall = 50 - (50**2 - mass / length / 7850e-6 / np.pi) ** 0.5
    stiff = "{name: stiff, youngs_modulus_GPa: 1000, density_kg_m3: 7850}"
    return f"tube: {{outer_mm: 100, wall_mm: {wall}, material: {stiff}}}"


def line(speeds: Iterable[float], first: str, last: str, *, torque: float = 1000) -> str:
    """METHOD 15's line of two shafts, made of these keys, in a state at each speed rpm."""
    states = "\n".join(f'  - {{name: "{n}", speed_rpm: {n}}}' for n in speeds)
    return f"""
title: Two slender shafts
torque_Nm: {torque}
speed_rpm: 2400
driveline:
  slopes: {{side_deg: [3, 1, 4.5, 2], top_deg: [0, 1.5, -0.8, 0.6]}}
  shafts:
    - length_mm: 1200
      {first}
      centre_bearing:
        from_rear_joint_mm: 0
        vertical_stiffness_N_mm: 200
        lateral_stiffness_N_mm: 120
        loss_factor: 0.1
    - length_mm: 1500
      {last}
states:
{states}
limits: protractor
"""


def two_shafts() -> str:
    """The two shafts of 20 and 25 kg."""
    return line(SPEEDS, tube(20, 1.2), tube(25, 1.5))


CLOSED = {
    100: 21.239, 300: 39.127, 426.6: 207.10, 500: 105.89, 551.3: 203.99, 800: 18.265, 2400: 1.1272,
}  # fmt: skip
"""rpm and N: order 2 on the bearing for 1000 N m as torque goes to zero (METHOD section 15)."""
MOVING = {
    100: 21.2516, 426.6: 207.225, 500: 105.955, 551.3: 204.108, 800: 18.2756, 2400: 1.12789,
}  # fmt: skip
"""The same at 1000 N m, the geometry moving, by EXUDYN (METHOD section 15)."""


def rods(torque: float, speeds: dict[float, float]) -> str:
    """The two shafts as rods: a tube of next to no mass, and a third of the rod's at its end."""
    light = "{name: light, youngs_modulus_GPa: 2000, density_kg_m3: 50}"
    own = 50 * np.pi * 0.4999 * 0.0001  # kg/m of the tube, and kg m of it about a diameter
    about = own * 0.25**2 / 2
    thin = f"tube: {{outer_mm: 500, wall_mm: 0.1, material: {light}}}"
    front, rear = (20 - 1.2 * own) / 3 - about / 1.2, (25 - 1.5 * own) / 3 - about / 1.5
    still = "polar_inertia_kgm2: 1e-7"
    first, last = (
        f"{thin}\n      yoke_mass_kg: [{a}, {b}]\n      {still}" for a, b in ((0, front), (rear, 0))
    )
    return line(speeds, first, last, torque=torque)


@pytest.mark.parametrize(("torque", "forces"), [(1, CLOSED), (1000, MOVING)])
def test_check_reproduces_closed_form_bearing_force(tmp_path, torque, forces):
    """From the file to the JSON: `at_speed` of each of its speeds, within the last digit."""
    states = {s["name"]: s for s in told(tmp_path, rods(torque, forces))["states"]}
    for speed, force in forces.items():
        found = states[str(speed)]["centre_bearings"][0]["on_rubber"]["at_speed"]["order2_N"]
        # The stiffest tube a file may have bends a little: 1e-4 N at 2400 rpm.
        assert found * 1000 / torque == pytest.approx(force, rel=5e-5, abs=2e-4)


def told(tmp_path: Path, text: str, *options: str) -> dict:
    file, out = tmp_path / "line.yaml", tmp_path / "line.json"
    file.write_text(text, encoding="utf-8")
    done = CliRunner().invoke(cli, ["check", str(file), "--json", str(out), "-q", *options])
    assert done.exit_code in (0, 1), done.output
    return json.loads(out.read_text(encoding="utf-8"))


def test_bearing_force_of_line_with_tubes_matches_reference(tmp_path):
    """Tubes of 100 mm bend and turn about their diameter too: 3 %, and more above resonance."""
    states = {s["name"]: s["centre_bearings"][0] for s in told(tmp_path, two_shafts())["states"]}
    for speed, force in SPEEDS.items():
        found = states[str(speed)]
        assert found["on_rubber"]["at_speed"]["order2_N"] == pytest.approx(force, rel=0.03)
        assert found["dynamic_N"] == pytest.approx(20.0935, abs=1e-3)  # a rigid support's
    modes = states["500"]["on_rubber"]["modes"]
    assert [m["shape"] for m in modes[:2]] == ["lateral", "bounce"]
    expected = pytest.approx([427.25, 551.90], rel=3e-3)
    assert [m["speed_of_order_2_rpm"] for m in modes[:2]] == expected
    assert modes[0]["damping"] == pytest.approx(0.05, rel=0.01)


def test_worst_point_without_engine_is_at_resonance(tmp_path):
    states = {s["name"]: s["centre_bearings"][0] for s in told(tmp_path, two_shafts())["states"]}
    worst = states["551.3"]["on_rubber"]["worst"]
    assert worst["speed_rpm"] == pytest.approx(427.2, rel=5e-3)
    assert worst["direction"] == "drive"
    assert worst["torque_Nm"] == pytest.approx(1000)
    below = states["100"]["on_rubber"]["worst"]
    assert below["speed_rpm"] == pytest.approx(100)  # a state's own speed holds


def test_check_names_mode_in_resonance_at_worst_speed(tmp_path):
    """METHOD 15: order 2 meets the lateral mode at 427.25 rpm; nothing is met at 100 rpm."""
    limits = "limits: [{quantity: centre_bearing_dynamic, maximum: 150, source: ours}]\n"
    checks = told(tmp_path, two_shafts().replace("limits: protractor\n", limits))["checks"]
    met = {c["state"]: c.get("mode") for c in checks}
    assert met["100"] is None
    assert (met["551.3"]["shape"], met["551.3"]["order"]) == ("lateral", 2)
    assert met["551.3"]["frequency_Hz"] == pytest.approx(2 * 427.25 / 60, rel=3e-3)
    done = CliRunner().invoke(cli, ["check", str(tmp_path / "line.yaml"), "--all"])
    assert "1000 N·m, order 2 in resonance with the lateral mode, 14.2 Hz" in " ".join(
        done.stdout.split()
    )


def test_dynamic_clearance_is_evaluated_at_resonance(tmp_path):
    """METHOD 15: of 207.1 N in the lateral mode 202.8 are lateral, over 120 N/mm 1.690 mm."""
    text = rods(1000, {426.6: 0}) + "include: [gravity]\n"
    near = "obstacles: [{name: ball, start_mm: [1200, 400, -21], radius_mm: 20}]\n"
    found = told(tmp_path, text + near)
    assert ["nothing slides" in note for note in found["notes"]] == [True]
    (left,) = (s["clearances_on_rubber_mm"]["ball"] for s in found["states"])
    (free,) = (s["clearances_mm"]["ball"] for s in found["states"])
    # And 5.1 N of the torque's, and none of the weight's: that hung there before.
    assert free - left == pytest.approx(1.690 + 5.1 / 120 / 2, abs=0.03)
    # Ten times the torque: 17 mm, which no rubber gives, is told.
    (note,) = (n for n in told(tmp_path, rods(10000, {426.6: 0}))["notes"] if "move by" in n)
    assert 15 < float(re.search(r"up to (\S+) mm", note)[1]) < 25


@pytest.mark.slow
@pytest.mark.parametrize(
    ("key", "says"), [("brake_torque_Nm: 250", "overrun is not evaluated"),
                      ("reverse_ratio: 6.0", "reverse is not evaluated")]
)  # fmt: skip
def test_direction_without_input_data_is_reported_in_note(tmp_path, key, says):
    """A truck whose engine brake nobody knows passed without a word about coasting."""
    text = (EXAMPLES / "medium-truck-4x2.yaml").read_text(encoding="utf-8")
    assert not any(n.startswith(says) for n in told(tmp_path, text)["notes"])
    assert any(n.startswith(says) for n in told(tmp_path, text.replace(key, ""))["notes"])


@pytest.mark.slow
@pytest.mark.parametrize(("speed", "off"), [(500, 0.0940), (380, 0.1106), (600, 0.0872)])
def test_duty_resonance_distance_matches_closed_form(tmp_path, speed, off):
    """METHOD 15: order 2 meets the modes at 427.25 and 551.90 rpm; tubes move them by 0.3 %."""
    duty = f"duty: [{{share_percent: 100, torque_Nm: 1000, speed_rpm: {speed}}}]\n"
    text = two_shafts().replace("limits: protractor\n", duty)
    rows = [r for r in told(tmp_path, text)["checks"] if r["quantity"] == "resonance_distance"]
    assert rows
    for row in rows:
        assert row["value"] == pytest.approx(off, abs=3e-3)
        assert row["verdict"] == "warn"


@pytest.mark.parametrize(("include", "off"), [("", 1.0), ("include: [unbalance]\n", 0.0)])
def test_order_1_resonance_is_evaluated_if_unbalance_is_included(tmp_path, include, off):
    """At the mode's own 1103.8 rpm (METHOD 15: order 2 meets it at half of that)."""
    duty = "duty: [{share_percent: 100, torque_Nm: 1000, speed_rpm: 1103.8}]\n"
    text = two_shafts().replace("limits: protractor\n", duty + include)
    rows = [r for r in told(tmp_path, text)["checks"] if r["quantity"] == "resonance_distance"]
    assert rows
    for row in rows:
        assert row["value"] == pytest.approx(off, abs=6e-3)


@pytest.mark.parametrize(
    ("top", "driven", "half"), [(2300, 1750, 1750), (1600, 1750, 1600), (2300, 500, 2300)]
)
def test_half_critical_band_is_evaluated_at_sustained_speeds(tmp_path, top, driven, half):
    """Faster alone clears nothing: at 2300 rpm a shaft of 3675 was told 0.63, at home at 0.48."""
    line = f"""\
title: a long shaft
speed_rpm: {top}
torque_Nm: 500
driveline:
  slopes: {{side_deg: [4, 0, 4]}}
  joints: "2035"
  shafts: [{{length_mm: 1900, tube: {{outer_mm: 80, wall_mm: 3, material: E355-N}}, phase_deg: 0}}]
limits: [{{quantity: half_critical_band, band: [0.42, 0.58], above_angle: 3, source: ours}}]
duty: [{{share_percent: 100, torque_Nm: 400, speed_rpm: {driven}}}]
states: [{{name: laden}}, {{name: hung, kind: full rebound, travel_mm: 0}}]
"""
    # Of a pinned tube, METHOD 8: 30 pi/L^2 sqrt(E (D^2 + d^2)/(16 rho)).
    critical = 30 * np.pi / 1.9**2 * np.sqrt(210e9 * (0.08**2 + 0.074**2) / 16 / 7850)
    checks = {c["state"]: c for c in told(tmp_path, line)["checks"] if c["part"] == "shaft 1"}
    check = checks["laden"]
    assert check["value"] == pytest.approx(half / critical, rel=1e-3)
    assert check["verdict"] == ("warn" if 0.42 < half / critical < 0.58 else "pass")
    # Nobody drives a round with the axle hanging.
    assert checks["hung"]["value"] == pytest.approx(top / critical, rel=1e-3)


@pytest.fixture(scope="module")
def truck():
    return approve_driveline(reader.read(EXAMPLES / "medium-truck-4x2.yaml"))


def test_bearing_limit_is_checked_at_resonance_in_strongest_gear(truck):
    checks = [c for c in truck.checks if c.quantity == "centre_bearing_dynamic"]
    worst = min(checks, key=lambda c: c.margin)
    assert worst.grade == "fail"
    assert worst.point is not None
    assert (worst.point.gear, worst.point.direction) == ("R", "reverse")
    (response,) = truck.line_responses
    jounce = response.demand.states.index("jounce")
    linear = response.mount_loads.worst_bearing_forces["dynamic"]
    assert linear.speed[jounce, 0] / rpm == pytest.approx(276, abs=1)
    assert 276 < worst.point.speed / rpm < 360  # at its stop rubber is stiffer, its crest faster
    found = next(c for c in checks if c.when.name == "jounce")
    assert response.rigid_loads.joint_loads.bearing_forces.dynamic[jounce, 0] == pytest.approx(
        226.7, abs=0.1
    )
    assert found.value > 8 * 226.7


def of_losses(approval):
    """What notes say of a loss factor that is assumed."""
    return [dict(n.values) for n in approval.note_messages if "loss factor" in n.text]


def test_force_with_assumed_loss_factor_has_note_with_range():
    """Of rubber that stays within its stop: beyond it another crest counts."""
    text = (EXAMPLES / "medium-truck-4x2.yaml").read_text(encoding="utf-8")
    free = text.replace("centre_bearing: {", "centre_bearing: {travel_mm: 200, ")
    truck = approve_driveline(reader.loads(free))
    (note,) = of_losses(truck)
    assert (note["bearing"], note["state"], note["factor"]) == (1, "jounce", "0.1")
    assert (note["low"], note["high"]) == ("0.05", "0.2")
    less, force, more = (float(note[key]) for key in ("more", "force", "less"))
    assert less > 1.8 * force > 3 * more
    given = truck.application
    (installed,) = given.lines
    shafts = tuple(
        s if s.centre_bearing is None
        else replace(s, centre_bearing=replace(s.centre_bearing, loss_factor=0.05))
        for s in installed.line.shafts
    )  # fmt: skip
    line = replace(installed, line=replace(installed.line, shafts=shafts))
    again = approve_driveline(replace(given, lines=(line,)))
    assert of_losses(again) == []
    worst = (
        again.line_responses[0].mount_loads.worst_bearing_forces["dynamic"].results.dynamic.max()
    )
    assert worst == pytest.approx(less, rel=0.012)  # at its own crest, hardly elsewhere


def test_loss_factor_note_is_absent_if_speed_is_unknown(truck):
    """The force of a line that stands still is none that the rubber's damping could change."""
    given = truck.application
    states = tuple(replace(s, speed=None) for s in given.states)
    still = replace(given, speed=None, states=states, engine=None, gearbox=None, torque=3000.0)
    found = approve_driveline(still)
    assert "dynamic" in found.line_responses[0].mount_loads.worst_bearing_forces
    assert of_losses(found) == []


def test_dynamic_bearing_force_on_rubber_needs_tubes(truck):
    """A rigid support would carry 300 N where the rubber is shaken with 3144."""
    given = truck.application
    (installed,) = given.lines
    shafts = tuple(replace(s, tube=None, polar_inertia_given=0.05) for s in installed.line.shafts)
    line = replace(installed, line=replace(installed.line, shafts=shafts))
    found = approve_driveline(replace(given, lines=(line,)))
    (response,) = found.line_responses
    assert response.mounts.mounted_line is None
    about = {"centre_bearing_dynamic", "centre_bearing_peak"}
    assert not about & {c.quantity for c in found.checks}
    missing = [u for u in found.coverage.unevaluated if u.quantity in about]
    assert {u.quantity for u in missing} == about
    assert all(u.missing_inputs[0] == "the tube of each shaft" for u in missing)
    assert response.rigid_loads.joint_loads.bearing_forces.dynamic.max() < 400
    assert of_losses(found) == []


def test_dynamic_bearing_force_without_speed_is_not_evaluated(tmp_path):
    """It was told as at standstill, where order 2 meets no mode: 20 N of 207, a pass."""
    text = two_shafts().replace("limits: protractor", "limits: heavy-truck")
    head, _ = text.split("states:")
    still = head.replace("speed_rpm: 2400\n", "include: [unbalance]\n") + "limits: heavy-truck\n"
    found = told(tmp_path, still)
    shaken = {"centre_bearing_dynamic", "centre_bearing_peak", "swing_growth"}
    assert not shaken & {c["quantity"] for c in found["checks"]}
    needs = {tuple(u["needs"]) for u in found["coverage"]["unanswered"] if u["quantity"] in shaken}
    assert needs == {("speed_rpm, or engine and gearbox",)}
    # What the torque makes of a line at rest is known all the same.
    assert "centre_bearing_static" in {c["quantity"] for c in found["checks"]}
    rigid = told(tmp_path, re.sub(r" *(vertical|lateral)_stiffness.*\n", "", still))
    assert rigid["states"][0]["centre_bearings"][0]["dynamic_N"] > 0  # by the torque alone


SWINGS = two_shafts().replace("torque_Nm: 1000", "torque_Nm: 6000").replace("0.1\n", "0.01\n")


def test_unstable_line_fails_and_has_no_steady_state_force(tmp_path):
    """Where order 1 meets a mode, 2 Ω = ω1 + ω1: a tenth of usual loss, six times the torque."""
    found = told(tmp_path, SWINGS.replace("limits: protractor", "limits: heavy-truck"))
    rows = {r["when"]["name"]: r for r in found["checks"] if r["quantity"] == "swing_growth"}
    assert rows["551.3"]["verdict"] == "pass"  # no driven point is that fast
    fast = SWINGS.replace(
        '  - {name: "551.3", speed_rpm: 551.3}', '  - {name: "fast", speed_rpm: 1500}'
    )
    found = told(tmp_path, fast.replace("limits: protractor", "limits: heavy-truck"))
    (row,) = (
        r for r in found["checks"]
        if r["quantity"] == "swing_growth" and r["when"]["name"] == "fast"
    )  # fmt: skip
    assert row["verdict"] == "fail"
    assert row["value"] > 0
    assert row["point"]["speed_rpm"] == pytest.approx(2 * 427.25, rel=0.01)
    silent = {
        u["quantity"]: u for u in found["coverage"]["unanswered"] if u["when"]["name"] == "fast"
    }
    forces = {f"centre_bearing_{of}" for of in ("static", "dynamic", "peak")}
    assert forces <= set(silent)
    assert silent["centre_bearing_dynamic"]["required"]
    told_of = {
        r["when"]["name"] for r in found["checks"] if r["quantity"] == "centre_bearing_dynamic"
    }
    assert told_of == {"100", "426.6", "500"}


@pytest.mark.slow
def test_static_force_search_extends_beyond_resonance_flanks():
    """Other rubber and phases under the collector: 7 % below a crest the mean is largest.

    Within 1 % of a dense sweep, where 5 % were missed.
    """
    text = (EXAMPLES / "refuse-collector-6x2.yaml").read_text("utf-8")
    was = "vertical_stiffness_N_mm: 200, lateral_stiffness_N_mm: 120"
    for up, level, loss in ((300, 300, 0.05), (500, 80, 0.1)):
        told = f"vertical_stiffness_N_mm: {up}, lateral_stiffness_N_mm: {level}"
        text = text.replace(was, f"{told}, loss_factor: {loss}", 1)
    turned = {
        "driveline.pinion_slope.side_deg": 3.41,
        "driveline.shafts[1].phase_deg": 3.0,
        "driveline.shafts[3].phase_deg": 90.0,
    }
    given = overrides.change(reader.loads(text), turned)
    r = compute_line_response(
        given, line_state_demand(resolve_line_references(given, given.lines[0]))
    )
    dense = r.mounts.forces_over_speed(np.linspace(0, 450, 400) * rpm).results.static
    worst = np.nanmax(dense, axis=(0, 1))
    assert (r.mount_loads.bearing_force("static") > 0.99 * worst).all()
