"""A centre bearing without a stiffness is rigid: it carries what statics tells."""

import json
from types import SimpleNamespace

import numpy as np
import pytest
from click.testing import CliRunner

from cardan.application import reader, templates
from cardan.approval.approval import approve_driveline
from cardan.checks import drive_forces
from cardan.cli import cli

MACHINE = templates.template_text("industrial")
BEARING = "from_rear_joint_mm: 160"
FORCES = ("centre_bearing_static", "centre_bearing_dynamic", "centre_bearing_peak")


def forces(text: str) -> dict[tuple[str, str], float]:
    found = approve_driveline(reader.loads(text, warn=False))
    return {(c.quantity, c.state): c.value for c in found.checks if c.quantity in FORCES}


def test_machine_on_plummer_blocks_gets_a_verdict():
    """It was incomplete: the stiffness of a rigid plummer block was required."""
    found = approve_driveline(reader.loads(MACHINE))
    assert found.verdict == "warn"  # the needles live 6855 h, 10,000 are normal
    assert not found.coverage.missing_required
    assert {c.quantity for c in found.checks} >= set(FORCES)
    assert any("evaluated as rigid" in note for note in found.notes)


def test_rigid_bearing_is_the_limit_of_a_stiff_one():
    """At 1e5 N/mm tubes give 2 N of the means, and damp the dynamic force: 59 for 70 N."""
    rigid = forces(MACHINE)
    stiff = forces(MACHINE.replace(BEARING, f"{BEARING}, stiffness_N_mm: 1e5"))
    for key, value in rigid.items():
        assert value == pytest.approx(stiff[key], rel=0.05 if "dynamic" not in key[0] else 0.2)


def test_dynamic_force_of_a_rigid_bearing_is_that_of_statics():
    """Small angles, METHOD 7: T/2 |(s1 D1* - s2 D2*)/L1 - (s2 D2* - s3 D3*)/L2|, L1 to bearing."""
    found = approve_driveline(reader.loads(MACHINE))
    (dynamic,) = (
        c.value
        for c in found.checks
        if (c.quantity, c.state) == ("centre_bearing_dynamic", "roll down")
    )
    d1, d2, d3 = np.radians([1.0136, 1.9918, -3.0054]) * 1j  # all in side view
    s1, s2, s3 = 1, -1, 1  # an aligned shaft flips the sign of the next joint
    length, last, lever = 1.3002, 1.6022, 1.3002 - 0.16
    front = (s1 * np.conj(d1) - s2 * np.conj(d2)) / length
    rear = (s2 * np.conj(d2) - s3 * np.conj(d3)) / last
    at_joint = 4200 / 2 * abs(front - rear)
    assert dynamic == pytest.approx(at_joint * length / lever, rel=2e-3)


@pytest.mark.slow
def test_overloaded_rigid_bearing_fails_and_stands_in_the_table(tmp_path):
    text = MACHINE.replace("torque_Nm: 4200  ", "torque_Nm: 42000 ")
    assert text != MACHINE
    file = tmp_path / "machine.yaml"
    file.write_text(text, encoding="utf-8")
    result = CliRunner().invoke(cli, ["check", str(file), "--json"], catch_exceptions=False)
    document = json.loads(result.stdout)
    assert (document["verdict"], result.exit_code) == ("fail", 1)
    (peak,) = (
        c
        for c in document["checks"]
        if (c["quantity"], c["state"]) == ("centre_bearing_peak", "roll down")
    )
    assert (peak["verdict"], peak["limit"]) == ("fail", 5000)
    table = CliRunner().invoke(cli, ["check", str(file)], catch_exceptions=False).stdout
    assert "X centre bearing 1, peak force" in table


def test_nothing_swings_on_rigid_bearings():
    """No rubber, no growth to limit: neither a check nor a missing answer."""
    found = approve_driveline(reader.loads(MACHINE))
    about = {"swing_growth", "resonance_distance", "centre_bearing_travel", "clearance_on_rubber"}
    asked = {c.quantity for c in found.checks} | {u.quantity for u in found.coverage.unevaluated}
    assert not about & asked


def test_rigid_bearings_coast_where_torque_is_against_the_sense_of_rotation(monkeypatch):
    """Ahead and astern: the axle is moved as overrun moves it, by the size of the speed."""
    seen = {}

    def moved(demand, **given):
        seen.update(given)
        return demand

    monkeypatch.setattr(drive_forces, "demand_with_axle_moved_by_torque", moved)
    mounts = SimpleNamespace(
        is_rigid=True, bearing_forces_at=lambda *_: SimpleNamespace(peak=np.zeros((4, 2, 1))),
        inputs=SimpleNamespace(
            demand=SimpleNamespace(states=("a", "b")), layout_for=lambda under: under
        ),
    )  # fmt: skip
    one = np.ones(4)
    drive = drive_forces.TorqueSpeedTimeHistory(
        time=one, input_angle=one, torque=np.array([5.0, -5.0, -5.0, 5.0]),
        speed=np.array([10.0, 10.0, -10.0, -10.0]),
    )  # fmt: skip
    drive_forces.bearing_forces_over_time_history(mounts, drive, state=0)
    assert seen["coasts"][:, 1].tolist() == [False, True, False, True]
    assert seen["sense"][:, 0].tolist() == [1, 1, -1, -1]
    assert seen["speed"].tolist() == np.full((4, 2), 10.0).tolist()
