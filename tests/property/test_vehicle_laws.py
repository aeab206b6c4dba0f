"""Laws of a whole application: mirrors, power, order of states, ways to give geometry."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cardan.approval.approval import approve_driveline
from cardan.checks.line_response import LineResponse, compute_line_response
from cardan.core.provenance import Source
from cardan.core.units import deg, rpm
from cardan.core.verdict import Limit
from cardan.model.application import Application, InstalledLine, VehicleState
from cardan.model.layout import (
    Layout,
    layout_from_joint_angles,
    layout_from_points,
    layout_from_slopes,
)
from cardan.model.parts import CentreBearing, Line, Shaft, Tube
from cardan.physics.vehicle.state_demand import line_state_demand, resolve_line_references

TUBE = Tube(outer=0.1, wall=0.003)
LIMITS = (
    Limit(quantity="torsional_acceleration", normal=300.0, maximum=500.0, source=Source("house")),
    Limit(quantity="centre_bearing_peak", maximum=2000.0, source=Source("house")),
)
slopes = st.lists(st.floats(-6, 6), min_size=4, max_size=4).map(lambda s: np.array(s) * deg)
phases = st.lists(st.floats(-90, 90), min_size=2, max_size=2).map(lambda p: np.array(p) * deg)


def application(
    layout: Layout, turned: np.ndarray, *, torque: float = 1000.0, tube: float | None = None
) -> Application:
    """An application; torque twists so many m of each `tube`, or all of it."""
    first, second = layout.lengths
    line = Line(
        shafts=(
            Shaft(
                length=first,
                tube=TUBE,
                tube_length=tube,
                phase=turned[0],
                centre_bearing=CentreBearing(from_rear_joint=0.15),
            ),
            Shaft(length=second, tube=TUBE, tube_length=tube, phase=turned[1]),
        )
    )
    return Application(
        title="any",
        lines=(InstalledLine(line=line, layout=layout),),
        states=(VehicleState(name="as given"),),
        limits=LIMITS,
        profile="house",
        torque=torque,
        speed=2500 * rpm,
    )


def response(layout: Layout, turned: np.ndarray, *, torque: float = 1000.0) -> LineResponse:
    one = application(layout, turned, torque=torque)
    return compute_line_response(one, line_state_demand(resolve_line_references(one, one.lines[0])))


@given(side=slopes, top=slopes, turned=phases)
@settings(max_examples=30)
def test_mirrored_vehicle_has_mirrored_loads(side, top, turned):
    """Left for right turns yoke phases and torque about; forces change side with the vehicle."""
    layout = layout_from_slopes(side=side, top=top, lengths=[1.2, 1.5])
    mirror = np.array([1.0, -1.0, 1.0])
    mirrored = Layout(points=layout.points * mirror, directions=layout.directions * mirror)
    one, other = response(layout, turned), response(mirrored, -turned, torque=-1000.0)
    assert other.joint_angles == pytest.approx(one.joint_angles, abs=1e-12)
    assert other.kinematics.excitation.torsional.acceleration == pytest.approx(
        one.kinematics.excitation.torsional.acceleration, rel=1e-9, abs=1e-9
    )
    static = one.rigid_loads.joint_loads.bearing_forces.static
    assert other.rigid_loads.joint_loads.bearing_forces.static == pytest.approx(
        static * mirror, abs=1e-9
    )
    assert other.rigid_loads.joint_loads.bearing_forces.dynamic == pytest.approx(
        one.rigid_loads.joint_loads.bearing_forces.dynamic, abs=1e-9
    )


@given(side=slopes, top=slopes, turned=phases)
@settings(max_examples=30)
def test_three_geometry_inputs_give_equal_results(side, top, turned):
    """Slopes, joint angles behind a level gearbox, and points."""
    side, top = side - side[0], top - top[0]
    layouts = [
        layout_from_slopes(side=side, top=top, lengths=[1.2, 1.5]),
        layout_from_joint_angles(side=np.diff(side), top=np.diff(top), lengths=[1.2, 1.5]),
    ]
    first = layouts[0]
    layouts.append(
        layout_from_points(first.points, gearbox=first.directions[0], pinion=first.directions[-1])
    )
    peaks = [response(layout, turned).rigid_loads.rigid_bearing_peaks for layout in layouts]
    assert peaks[1] == pytest.approx(peaks[0], rel=1e-9, abs=1e-9)
    assert peaks[2] == pytest.approx(peaks[0], rel=1e-9, abs=1e-9)


@given(side=slopes, top=slopes, turned=phases)
@settings(max_examples=30)
def test_power_is_equal_behind_every_joint_at_every_angle(side, top, turned):
    """Torque times speed is the same behind every joint at every angle: nothing is lost."""
    found = response(layout_from_slopes(side=side, top=top, lengths=[1.2, 1.5]), turned)
    torques = found.rigid_loads.joint_loads.torques.values(16)[0, 1:, :, 0]
    assert torques * found.inputs.twisted_chain_rotation.speed[0] == pytest.approx(
        np.full((3, 16), 1000.0), rel=1e-12
    )


@given(torque=st.floats(-2e4, 2e4), side=slopes, top=slopes)
@settings(max_examples=20)
def test_loads_are_proportional_to_torque(torque, side, top):
    """Of shafts that it does not twist."""
    layout = layout_from_slopes(side=side, top=top, lengths=[1.2, 1.5])
    one = application(layout, np.zeros(2), tube=1e-12)
    many = replace(one, torque=torque)
    unit = (
        compute_line_response(
            one, line_state_demand(resolve_line_references(one, one.lines[0]))
        ).rigid_loads.joint_loads.bearing_forces.static
        / 1000
    )
    found = compute_line_response(
        many, line_state_demand(resolve_line_references(many, many.lines[0]))
    ).rigid_loads.joint_loads.bearing_forces.static
    assert found == pytest.approx(torque * unit, rel=1e-9, abs=1e-9)


@given(factor=st.floats(1.01, 3))
@settings(max_examples=10)
def test_excitation_grows_with_square_of_speed(factor):
    layout = layout_from_slopes(
        side=np.array([3, 1, 4.5, 2]) * deg, top=np.zeros(4), lengths=[1.2, 1.5]
    )
    slow = application(layout, np.zeros(2))
    fast = replace(slow, speed=factor * 2500 * rpm)
    values = [
        next(c.value for c in approve_driveline(a).checks if c.quantity == "torsional_acceleration")
        for a in (slow, fast)
    ]
    assert values[1] == pytest.approx(factor**2 * values[0], rel=1e-9)
