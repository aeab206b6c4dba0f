"""What a line is resolved to: looked up once, each thing where it belongs."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from cardan import files
from cardan.base.errors import DesignError
from cardan.demand.line import height
from cardan.demand.states import demand, resolve
from cardan.model.application import DutyPoint, State
from cardan.model.layout import Layout
from cardan.quantity.response import respond

ROOT = Path(__file__).parents[2]
TRUCK = files.read(ROOT / "tests" / "truck.yaml")
TANDEM = files.read(ROOT / "examples" / "tandem-6x4.yaml")


def test_the_vehicle_s_parts_are_where_the_line_finds_them():
    line = resolve(TRUCK, TRUCK.lines[0])
    assert line.suspension is TRUCK.suspension
    assert line.axle is TRUCK.lines[0].axle
    assert line.line is TRUCK.lines[0].line
    assert (line.vehicle, line.engine, line.tyre) == (TRUCK.vehicle, TRUCK.engine, TRUCK.tyre)
    assert line.gears is not None
    np.testing.assert_allclose(line.gears.ratios, TRUCK.gearbox.ratios)
    assert [o.name for o in line.obstacles] == ["beam of the auxiliary axle"]


def test_each_line_has_its_own_share_and_obstacles():
    main, inter = (resolve(TANDEM, installed) for installed in TANDEM.lines)
    assert inter.share == TANDEM.lines[1].torque_share
    np.testing.assert_allclose(inter.gears.torque, inter.share * main.gears.torque, rtol=1e-14)
    beam = replace(TRUCK.obstacles[0], line="inter-axle")
    with_beam = replace(TANDEM, obstacles=(beam,))
    assert [len(resolve(with_beam, i).obstacles) for i in TANDEM.lines] == [0, 1]


def test_a_line_takes_its_share_of_what_the_gearbox_gives():
    """A third of what a gear of 1.5 makes of the gearbox's torque, of the duty cycle's too."""
    (installed,) = TRUCK.lines
    shared = replace(installed, torque_ratio=1.5, torque_share=1 / 3, speed_ratio=0.8)
    whole, half = (resolve(TRUCK, i) for i in (installed, shared))
    assert half.share == pytest.approx(0.5)
    np.testing.assert_allclose(half.gears.torque, 0.5 * whole.gears.torque, rtol=1e-14)
    duty = (DutyPoint(share=1.0, torque=1000.0, speed=100.0),)
    response = respond(replace(TRUCK, duty=duty), demand(half))
    assert response.duty == (DutyPoint(share=1.0, torque=500.0, speed=80.0),)


def test_the_application_s_springs_are_those_of_the_rear():
    installed = TRUCK.lines[0]
    assert resolve(TRUCK, replace(installed, drives="front")).suspension is None
    own = replace(TRUCK.suspension, unsprung_mass=300.0)
    assert resolve(TRUCK, replace(installed, drives="front", suspension=own)).suspension is own


def test_what_loads_the_vehicle_in_each_state():
    line = resolve(TRUCK, TRUCK.lines[0])
    assert [(of.name, of.times) for of in line.loadings] == [
        ("empty", 1.0), ("empty", 1.0), ("gvw", 1.0), ("gvw", 1.1), ("gvw", 1.0), ("gvw", 1.0),
        ("gvw", 1.0),
    ]  # fmt: skip
    assert line.reference.kind == "gvw"
    # On a stop the load does not matter; in wind-up the axle is as high as its load has it.
    heights = [height(s, of) for s, of in zip(line.states, line.loadings, strict=True)]
    assert heights[0] == "full rebound"
    assert heights[5] == heights[2] == height(line.reference, line.reference_loading)


def test_a_state_s_own_layout_holds_the_axle():
    layout = TRUCK.lines[0].layout
    states = (State(name="gvw", kind="gvw"), State(name="as seen", layouts={"main": layout}))
    line = resolve(replace(TRUCK, states=states), TRUCK.lines[0])
    assert line.own == (None, layout)
    assert line.free.tolist() == [True, False]
    other = Layout(points=layout.points[:-1], directions=layout.directions[:-1])
    wrong = State(name="short", layouts={"main": other})
    with pytest.raises(DesignError, match="3 joints in every state"):
        resolve(replace(TRUCK, states=(wrong,)), TRUCK.lines[0])


def test_variants_of_a_mass_stand_before_the_states():
    """A laden truck of 21, 23 and 25 t: only what its weight reaches differs."""
    mass = np.array([21e3, 23e3, 25e3])[:, None]
    loads = tuple(replace(w, mass=mass) if w.name == "gvw" else w for w in TRUCK.vehicle.loads)
    heavy = replace(TRUCK, vehicle=replace(TRUCK.vehicle, loads=loads))
    found, alone = (demand(resolve(a, a.lines[0])) for a in (heavy, TRUCK))
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


def test_a_part_refuses_one_bad_variant_and_says_which():
    tube = TRUCK.lines[0].line.shafts[0].tube
    with pytest.raises(DesignError, match="got 80 mm"):
        replace(tube, wall=np.array([[3e-3], [80e-3]]))
    with pytest.raises(DesignError, match="got nan"):
        replace(TRUCK.tyre, friction=np.array([[0.8], [np.nan]]))
