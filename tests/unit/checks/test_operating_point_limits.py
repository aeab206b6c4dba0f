"""What limits ask at operating points: where, at which side, in a batch as one by one."""

from dataclasses import replace

import numpy as np
import pytest
from repository import EXAMPLES

from cardan.application import limit_profiles, reader
from cardan.approval.applied_adjustments import all_adjustments, response_with_adjustments
from cardan.approval.driveline_study import line_checks
from cardan.checks.line_response import compute_line_response
from cardan.core.units import deg, g, mm, rpm
from cardan.core.verdict import Limit
from cardan.physics.vehicle.resolved_line import resolve_line_references
from cardan.physics.vehicle.state_demand import demand_with_axle_moved_by_torque, line_state_demand


def limit(quantity: str, **given) -> Limit:
    return Limit(
        quantity=quantity, source=limit_profiles.load_profile("heavy-truck")[1][0].source, **given
    )


def answered(application, *limits: Limit):
    asked = replace(application, limits=limits)
    (installed,) = asked.lines
    response = compute_line_response(
        asked, line_state_demand(resolve_line_references(asked, installed))
    )
    mine = [c for c in line_checks(response) if c.limit in limits]
    return response, {(c.when.name, c.part.number): c for c in mine}


@pytest.fixture(scope="module")
def truck():
    return reader.read(EXAMPLES / "medium-truck-4x2.yaml")


def test_an_axle_wound_up_backwards_bends_its_joint_further(truck):
    """Medium truck, full rebound: the last joint goes from 8.75 to 9.22 deg.

    In coast, as in reverse, the line carries what the tyres hold there, of two springs of
    3300 N and 650 kg; the pinion turns by the wheels' torque over the springs' stiffness.
    """
    response, found = answered(truck, limit("joint_angle", maximum=10 * deg))
    check = found["full rebound", 3]
    assert response.joint_angles[0, 2] / deg == pytest.approx(8.754, abs=1e-3)
    assert check.value / deg == pytest.approx(9.216, abs=1e-3)
    assert check.point is not None
    assert check.point.direction == "coast"
    assert check.point.speed == 0.0
    # By hand, from the file's numbers: axle 3.91 with 0.95, springs of 12 kN m/deg, the
    # pinion's joint 380 mm ahead of the axle and 25 mm above it.
    held = 0.8 * 0.405 * (2 * 20 * 165 + 650 * g)
    turned = -check.point.torque * 3.91 / 0.95  # by the wheels, which turn the line
    assert turned == pytest.approx(held, rel=1e-9)
    nose = held / 12e3 * deg  # down

    def turned(x: float, z: float, down: float) -> np.ndarray:
        cos, sin = np.cos(down), np.sin(down)
        return np.array([cos * x - sin * z, 0.0, sin * x + cos * z])

    arm = -0.38, 0.025
    before = -float(response.demand.pitch[0])
    joints, pinion = response.layout.points[0], response.layout.directions[0, -1]
    moved = joints[2] + turned(*arm, before + nose) - turned(*arm, before)
    shaft = (moved - joints[1]) / np.linalg.norm(moved - joints[1])
    down = turned(pinion[0], pinion[2], nose)
    assert check.value == pytest.approx(np.arccos(shaft @ down), abs=1e-4 * deg)


def test_a_limit_of_the_states_own_asks_nowhere_else(truck):
    response, found = answered(truck, limit("joint_angle", maximum=10 * deg, points="own"))
    for s, state in enumerate(response.demand.states):
        for k in range(3):
            check = found[state, k + 1]
            assert check.point is None
            assert check.value == pytest.approx(response.joint_angles[s, k], rel=1e-12)


def test_an_upper_limit_asks_for_the_largest_and_a_lower_one_for_the_smallest(truck):
    response, most = answered(truck, limit("joint_angle", maximum=10 * deg))
    _, least = answered(truck, limit("joint_angle", maximum=0.5 * deg, sense=">="))
    spread = response.operating_envelope
    assert spread is not None
    angles = np.concatenate([spread.response.joint_angles[:, 0], response.joint_angles[None]])
    for s, state in enumerate(response.demand.states):
        assert most[state, 3].value == pytest.approx(np.nanmax(angles[:, s, 2]), rel=1e-12)
        assert least[state, 3].value == pytest.approx(np.nanmin(angles[:, s, 2]), rel=1e-12)
    assert any(most[s, 3].value > 1.02 * least[s, 3].value for s in response.demand.states)


def test_what_no_point_makes_worse_stays_where_it_was(truck):
    """The gearbox's joint does not feel the axle: no point is named for it."""
    response, found = answered(truck, limit("joint_angle", maximum=10 * deg))
    for s, state in enumerate(response.demand.states):
        assert found[state, 1].point is None
        assert found[state, 1].value == pytest.approx(response.joint_angles[s, 0], rel=1e-12)


def test_room_shrinks_as_an_axle_winds_up():
    """Refuse collector, jounce: 11.2 mm to the beam as it stands, 3.8 pulling away in reverse."""
    truck = reader.read(EXAMPLES / "refuse-collector-6x2.yaml")
    response, found = answered(truck, limit("clearance", maximum=15 * mm, sense=">="))
    check = found["jounce", 3]
    s = response.demand.states.index("jounce")
    assert response.clearances.obstacle_clearances[s, 2, 0] / mm == pytest.approx(11.161, abs=1e-3)
    assert check.value / mm == pytest.approx(3.845, abs=1e-3)
    assert check.point is not None
    assert check.point.direction == "reverse"


def test_speed_and_angle_are_those_of_one_point(truck):
    """Largest angle and highest speed never meet: (ω β)² is asked where both are real."""
    response, found = answered(truck, limit("angle_for_speed", maximum=1.0))
    for s, state in enumerate(response.demand.states):
        check = found[state, 3]
        if check.point is None:
            continue
        of = {"torque": np.full(7, check.point.torque), "speed": np.full(7, check.point.speed)}
        coasts = check.point.direction == "coast"
        brakes = check.point.direction == "brake"
        at = demand_with_axle_moved_by_torque(response.demand, **of, coasts=coasts, brakes=brakes)
        bent = response.with_inputs(demand=at, layout=response.layout_for(at)).joint_angles[s, 2]
        assert check.value == pytest.approx((check.point.speed * bent) ** 2, rel=1e-9)
        assert check.point.speed <= 2250 * rpm * (1 + 1e-12)


def test_points_that_no_variant_changes_are_asked_once(truck):
    """Moved bearings bend the line otherwise at the same torques and speeds, each of them once."""
    (line,) = truck.lines
    r = compute_line_response(truck, line_state_demand(resolve_line_references(truck, line)))
    (height,) = (
        a for a in all_adjustments(r) if (a.adjustment_key, a.part) == ("bearing_height", 1)
    )
    moved = response_with_adjustments(r, (height,), np.array([[0.0], [0.004], [-0.004]]))
    found, alone = moved.operating_envelope, r.operating_envelope
    assert found.points.speed.shape == alone.points.speed.shape
    assert found.points.speed.shape[1] == 1
    points = len(found.points.speed)
    assert found.response.joint_angles.shape == (points, 3, *r.joint_angles.shape)
    before = np.broadcast_to(alone.response.joint_angles, (points, 1, *r.joint_angles.shape))
    np.testing.assert_allclose(found.response.joint_angles[:, :1], before, atol=1e-12)
    assert (
        np.abs(found.response.joint_angles[:, 1] - found.response.joint_angles[:, 2]).max() > 1e-3
    )
    for state in range(len(r.demand.states)):
        of = zip(
            found.points.curve_index[:, 0, state], found.points.speed[:, 0, state], strict=True
        )
        there = [p for p in of if not np.isnan(p[1])]
        assert len(set(there)) == len(there)
