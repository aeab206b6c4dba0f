"""What a line is resolved to: looked up once, each thing where it belongs."""

from dataclasses import replace

import numpy as np
import pytest
from repository import ROOT

from cardan.application import reader
from cardan.checks.line_response import compute_line_response
from cardan.core.errors import DesignError
from cardan.model.application import DutyPoint, VehicleState
from cardan.model.layout import Layout
from cardan.physics.vehicle.resolved_line import axle_height_grouping_key
from cardan.physics.vehicle.state_demand import line_state_demand, resolve_line_references

TRUCK = reader.read(ROOT / "tests" / "truck.yaml")
TANDEM = reader.read(ROOT / "examples" / "tandem-6x4.yaml")


def test_resolved_line_holds_parts_of_vehicle():
    line = resolve_line_references(TRUCK, TRUCK.lines[0])
    assert line.suspension is TRUCK.suspension
    assert line.axle is TRUCK.lines[0].axle
    assert line.line is TRUCK.lines[0].line
    assert (line.vehicle, line.engine, line.tyre) == (TRUCK.vehicle, TRUCK.engine, TRUCK.tyre)
    assert line.gears is not None
    np.testing.assert_allclose(line.gears.ratios, TRUCK.gearbox.ratios)
    assert [o.name for o in line.obstacles] == ["beam of the auxiliary axle"]


def test_each_line_has_own_torque_share_and_obstacles():
    main, inter = (resolve_line_references(TANDEM, installed) for installed in TANDEM.lines)
    assert inter.max_torque_share == TANDEM.lines[1].torque_share
    np.testing.assert_allclose(
        inter.gears.torque, inter.max_torque_share * main.gears.torque, rtol=1e-14
    )
    beam = replace(TRUCK.obstacles[0], line="inter-axle")
    with_beam = replace(TANDEM, obstacles=(beam,))
    assert [len(resolve_line_references(with_beam, i).obstacles) for i in TANDEM.lines] == [0, 1]


def test_line_takes_its_share_of_gearbox_torque():
    """A third of what a gear of 1.5 makes of the gearbox's torque, of the duty cycle's too."""
    (installed,) = TRUCK.lines
    shared = replace(installed, torque_ratio=1.5, torque_share=1 / 3, speed_ratio=0.8)
    whole, half = (resolve_line_references(TRUCK, i) for i in (installed, shared))
    assert half.max_torque_share == pytest.approx(0.5)
    np.testing.assert_allclose(half.gears.torque, 0.5 * whole.gears.torque, rtol=1e-14)
    duty = (DutyPoint(share=1.0, torque=1000.0, speed=100.0),)
    response = compute_line_response(replace(TRUCK, duty=duty), line_state_demand(half))
    assert response.inputs.duty_points == (DutyPoint(share=1.0, torque=500.0, speed=80.0),)


def test_springs_of_application_belong_to_rear_axle():
    installed = TRUCK.lines[0]
    assert resolve_line_references(TRUCK, replace(installed, drives="front")).suspension is None
    own = replace(TRUCK.suspension, unsprung_mass=300.0)
    assert (
        resolve_line_references(
            TRUCK, replace(installed, drives="front", suspension=own)
        ).suspension
        is own
    )


def test_loading_of_each_state_is_resolved():
    line = resolve_line_references(TRUCK, TRUCK.lines[0])
    assert [(of.name, of.load_factor) for of in line.load_states] == [
        ("empty", 1.0), ("empty", 1.0), ("gvw", 1.0), ("gvw", 1.1), ("gvw", 1.0), ("gvw", 1.0),
        ("gvw", 1.0),
    ]  # fmt: skip
    assert line.reference_state.kind == "gvw"
    # On a stop the load does not matter; in wind-up the axle is as high as its load has it.
    heights = [
        axle_height_grouping_key(s, of) for s, of in zip(line.states, line.load_states, strict=True)
    ]
    assert heights[0] == "full rebound"
    assert (
        heights[5]
        == heights[2]
        == axle_height_grouping_key(line.reference_state, line.reference_load_state)
    )


def test_layout_given_by_state_fixes_axle():
    layout = TRUCK.lines[0].layout
    states = (
        VehicleState(name="gvw", kind="gvw"),
        VehicleState(name="as seen", layouts={"main": layout}),
    )
    line = resolve_line_references(replace(TRUCK, states=states), TRUCK.lines[0])
    assert line.own_layouts == (None, layout)
    assert line.placed_by_suspension.tolist() == [True, False]
    other = Layout(points=layout.points[:-1], directions=layout.directions[:-1])
    wrong = VehicleState(name="short", layouts={"main": other})
    with pytest.raises(DesignError, match="3 joints in every state"):
        resolve_line_references(replace(TRUCK, states=(wrong,)), TRUCK.lines[0])


def test_mass_variants_precede_states_in_array_axes():
    """A laden truck of 21, 23 and 25 t: only what its weight reaches differs."""
    mass = np.array([21e3, 23e3, 25e3])[:, None]
    loads = tuple(replace(w, mass=mass) if w.name == "gvw" else w for w in TRUCK.vehicle.loads)
    heavy = replace(TRUCK, vehicle=replace(TRUCK.vehicle, loads=loads))
    found, alone = (
        line_state_demand(resolve_line_references(a, a.lines[0])) for a in (heavy, TRUCK)
    )
    states = len(TRUCK.states)
    assert found.torque.shape == found.travel.shape == (3, states)
    assert found.layout.points.shape == (3, states, 3, 3)
    np.testing.assert_allclose(found.axle_load[1], alone.axle_load, rtol=1e-14)
    np.testing.assert_allclose(found.layout.points[1], alone.layout.points, atol=1e-14)
    gvw, empty = found.states.index("gvw"), found.states.index("empty")
    assert np.ptp(found.axle_load[:, gvw]) > 0
    assert np.ptp(found.axle_load[:, empty]) == 0
    # The geometry is given laden, so a heavier load lowers the empty truck's axle against it.
    assert np.ptp(found.travel[:, gvw]) == 0
    assert np.all(np.diff(found.travel[:, empty]) < 0)


def test_invalid_variant_of_part_is_rejected_with_value():
    tube = TRUCK.lines[0].line.shafts[0].tube
    with pytest.raises(DesignError, match="got 80 mm"):
        replace(tube, wall=np.array([[3e-3], [80e-3]]))
    with pytest.raises(DesignError, match="got nan"):
        replace(TRUCK.tyre, friction=np.array([[0.8], [np.nan]]))
