"""Torque twists a shaft's yokes against each other: T L / G J by the textbook's formula."""

from dataclasses import replace

import numpy as np
import pytest
from click.testing import CliRunner

from cardan.application import reader
from cardan.checks.line_response import compute_line_response
from cardan.cli import cli
from cardan.model.layout import direction_from_slopes, layout_from_points
from cardan.model.material import STEEL
from cardan.model.parts import CentreBearing, Line, Shaft, Tube
from cardan.physics.kinematics.joint_chain import rotate_chain
from cardan.physics.loads.statics import joint_loads
from cardan.physics.vehicle.state_demand import line_state_demand, resolve_line_references

PROTRACTOR = """\
title: By hand
speed_rpm: 2500
torque_Nm: 8000
driveline:
  slopes: {side_deg: [3, 1, 4.5, 2]}
  shafts:
    - length_mm: 1200
      tube: {outer_mm: 101.6, wall_mm: 3.2}
      centre_bearing: {from_rear_joint_mm: 140}
    - {length_mm: 1500, tube: {outer_mm: 101.6, wall_mm: 3.2}}
"""
LIMITS = """\
profile: ours
title: Unevenness alone
limits:
  - {quantity: torsional_acceleration, unit: rad/s², maximum: 43, source: House, how_read: assumed}
"""
TWIST = 8000 * 1.2 / (206e9 / 2.6 * np.pi / 32 * (0.1016**4 - 0.0952**4))
"""rad, of 1.2 m of 101.6 x 3.2 mm steel under 8000 N m: 2.90 deg."""


def line(**more) -> Line:
    tube = Tube(outer=0.1016, wall=0.0032, material=STEEL)
    bearing = CentreBearing(from_rear_joint=0.14)
    return Line(
        shafts=(
            Shaft(length=1.2, tube=tube, phase=0.2, centre_bearing=bearing, **more),
            Shaft(length=1.5, phase=-0.1),
        )
    )


def test_rear_yoke_lags_front_yoke_by_torsional_windup():
    """2.90 deg; 2 m of a shaft of which 1.2 m are tube twist as much, and no tube not at all."""
    assert np.degrees(TWIST) == pytest.approx(2.90, abs=0.005)
    under = line().phases_under_torque((0.2, -0.1), 8000.0)
    assert under == pytest.approx([0.2 - TWIST, -0.1], rel=1e-12)
    assert line().phases_under_torque((0.2, -0.1), -8000.0)[0] == pytest.approx(
        0.2 + TWIST, rel=1e-12
    )
    longer = line().shafts[0]
    assert replace(longer, length=2.0, tube_length=1.2).torsional_flexibility == pytest.approx(
        TWIST / 8000, rel=1e-12
    )
    assert replace(longer, length=float("nan")).torsional_flexibility == 0


def test_bearing_force_of_state_includes_shaft_twist():
    """The file's numbers are those of `loads` with the yokes turned by hand."""
    application = reader.loads(PROTRACTOR)
    r = compute_line_response(
        application, line_state_demand(resolve_line_references(application, application.lines[0]))
    )
    d = direction_from_slopes(side=np.radians([3, 1, 4.5, 2.0]), top=np.zeros(4))
    steps = np.array([[1.2], [1.5]]) * d[1:-1]
    points = np.concatenate([np.zeros((1, 3)), np.cumsum(steps, axis=0)])
    laid = layout_from_points(points, gearbox=d[0], pinion=d[-1])

    def dynamic(*phases: float) -> float:
        turned = rotate_chain(laid.directions, phases=np.array(phases), samples=16)
        return joint_loads(laid, turned, r.line, torque=8000.0).bearing_forces.dynamic[0]

    right = dynamic(-TWIST, -1.25 * TWIST)
    assert r.rigid_loads.joint_loads.bearing_forces.dynamic[0, 0] == pytest.approx(right, rel=1e-9)
    assert abs(right / dynamic(0.0, 0.0) - 1) > 0.003
    drawn = rotate_chain(laid.directions, phases=np.zeros(2), samples=16)
    assert r.inputs.chain_rotation.phasors[0] == pytest.approx(drawn.phasors, rel=1e-9)


def test_acceleration_depending_on_windup_is_noted(tmp_path):
    """Without rubber as well: 41.9 rad/s² as the yokes are welded, 44.1 under torque.

    ω² |β₁² - β₂² e^(-2i T₁) + β₃² e^(-2i (T₁ + T₂))|, the angles 2, -3.5 and 2.5 deg.
    """
    b1, b2, b3 = np.radians([2, 3.5, 2.5]) ** 2
    E = b1 - b2 * np.exp(-2j * TWIST) + b3 * np.exp(-2j * 2.25 * TWIST)
    assert (2500 * np.pi / 30) ** 2 * abs(E) == pytest.approx(44.06, rel=0.01)
    (tmp_path / "by_hand.yaml").write_text(PROTRACTOR, encoding="utf-8")
    (tmp_path / "ours.yaml").write_text(LIMITS, encoding="utf-8")
    asked = ["check", str(tmp_path / "by_hand.yaml"), "--limits", str(tmp_path / "ours.yaml")]
    done = CliRunner().invoke(cli, [*asked, "--sources"])
    told = " ".join(done.output.split())
    assert done.exit_code == 0, told
    assert "Torsional acceleration" in told
    assert "would be 44.06 for 41.86 rad/s² in as given: exceeded" in told
