"""Laws of axle loads, springs and states."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from cardan.core.units import deg, kNm, mm, rpm
from cardan.model.application import Application, InstalledLine, VehicleState
from cardan.model.layout import Layout, layout_from_slopes
from cardan.model.parts import CentreBearing, Line, Shaft
from cardan.model.vehicle import (
    AuxiliaryAxle,
    Axle,
    Engine,
    Gearbox,
    Linkage,
    LoadState,
    Spring,
    Suspension,
    Tyre,
    Vehicle,
)
from cardan.physics.vehicle.axle_loads import (
    axle_loads_at_wheel_slip,
    driveline_axle_loads,
    load_of_each_axle,
    static_axle_loads,
)
from cardan.physics.vehicle.state_demand import line_state_demand, resolve_line_references
from cardan.physics.vehicle.suspension import (
    axle_path,
    spring_deflection,
    spring_load,
    spring_rate,
    spring_table_rates,
)
from cardan.physics.vehicle.torque import gear_table

drives = st.sampled_from(["4x2", "4x4", "6x2", "6x4", "6x6", "8x2", "8x4", "8x8"])
frictions = st.floats(0.05, 1.0)
shares = st.floats(0, 1)


@st.composite
def loaded(draw):
    """A vehicle, its load state."""
    drive, wheelbase = draw(drives), draw(st.floats(3, 7))
    tag = AuxiliaryAxle(behind_front=wheelbase + 1.3, load=draw(st.floats(1e3, 2e4)))
    vehicle = Vehicle(
        drive=drive,
        wheelbase=wheelbase,
        grade=draw(st.floats(-0.15, 0.15)),
        auxiliary=(tag,) if drive in ("6x2", "8x2") and draw(st.booleans()) else (),
    )
    load = LoadState(
        name="gvw",
        mass=draw(st.floats(8e3, 4e4)),
        cg_behind_front=wheelbase * draw(st.floats(0.45, 0.7)),
        cg_height=draw(st.floats(0.6, 1.6)),
    )
    return vehicle, load


@settings(max_examples=60)
@given(drawn=loaded(), front=shares, rear=shares, friction=st.floats(-1, 1))
def test_axle_loads_sum_to_weight(drawn, front, rear, friction):
    """To rounding: sums of up to five numbers, so a few units in the last place."""
    vehicle, load = drawn
    still = static_axle_loads(vehicle, load, grade=vehicle.grade)
    weight = load.mass * 9.80665 * np.cos(vehicle.grade)
    slipping = axle_loads_at_wheel_slip(
        still,
        friction=friction,
        cg_height=load.cg_height,
        wheelbase=vehicle.wheelbase,
        front_share=front,
        rear_share=rear,
    )
    for loads in (still, slipping):
        assert loads.total == pytest.approx(weight, rel=1e-14)
        assert load_of_each_axle(loads, vehicle).sum() == pytest.approx(weight, rel=1e-14)


@settings(max_examples=60)
@given(drawn=loaded(), front=shares, rear=shares, friction=st.floats(-1, 1))
def test_load_transfer_at_slip_limit_satisfies_force_balance(drawn, front, rear, friction):
    """N' = N + F h/L with F = mu (sf Nf' + sr Nr'): the closed form solves its equation."""
    vehicle, load = drawn
    h, length = load.cg_height, vehicle.wheelbase
    still = static_axle_loads(vehicle, load)
    found = axle_loads_at_wheel_slip(
        still,
        friction=friction,
        cg_height=h,
        wheelbase=length,
        front_share=front,
        rear_share=rear,
    )
    assume(found.front > 0)
    assume(found.rear > 0)
    force = friction * (front * found.front + rear * found.rear)
    assert found.rear == pytest.approx(still.rear + force * h / length, rel=1e-12)


@given(drawn=loaded(), friction=frictions, more=st.floats(0.01, 0.5))
def test_more_grip_increases_load_on_driven_rear_wheels(drawn, friction, more):
    vehicle, load = drawn
    level = replace(vehicle, grade=0.0)
    one, two = (driveline_axle_loads(level, load, friction=f) for f in (friction, friction + more))
    assert two.traction * (1 + 1e-12) >= one.traction >= one.rest * (1 - 1e-12)


@st.composite
def springs(draw):
    n = draw(st.integers(2, 6))
    steps = st.lists(st.floats(0.01, 0.1), min_size=n - 1, max_size=n - 1)
    rates = draw(st.lists(st.floats(2e4, 5e5), min_size=n - 1, max_size=n - 1))
    widths = np.array(draw(steps))
    deflection, load = (np.concatenate([[0], np.cumsum(v)]) for v in (widths, widths * rates))
    return Spring(load=tuple(load), deflection=tuple(deflection))


@given(spring=springs(), one=st.floats(-0.2, 0.8), more=st.floats(1e-4, 0.1))
def test_larger_load_increases_spring_deflection(spring, one, more):
    assert spring_load(spring, one + more) > spring_load(spring, one)
    assert spring_deflection(spring, spring_load(spring, one)) == pytest.approx(one, abs=1e-12)
    rates = spring_table_rates(spring)
    rate = spring_rate(spring, one)
    assert rates.min() * (1 - 1e-9) <= rate <= rates.max() * (1 + 1e-9)


@given(angle=st.floats(-0.4, 0.4), travel=st.floats(-0.15, 0.15), rate=st.floats(-1, 1))
def test_reversed_link_motion_is_inverse(angle, travel, rate):
    """Back from where the axle went: the same way, the other sign."""
    there = axle_path(Linkage(radius=0.7, angle=angle, pitch_rate=rate), travel)
    new = np.arcsin(np.sin(angle) - travel / 0.7)
    back = axle_path(Linkage(radius=0.7, angle=float(new), pitch_rate=rate), -travel)
    np.testing.assert_allclose(there, np.negative(back), atol=1e-15)


@given(
    ratios=st.lists(st.floats(0.6, 16), min_size=1, max_size=12),
    efficiency=st.floats(0.7, 1),
    share=st.floats(0.2, 1),
    speed=st.floats(0.5, 2),
)
def test_output_power_is_input_power_less_losses(ratios, efficiency, share, speed):
    engine = Engine(speed=(100.0, 150.0, 250.0), torque=(800.0, 1000.0, 700.0))
    gearbox = Gearbox(ratios=tuple(ratios), efficiency=efficiency)
    table = gear_table(engine, gearbox, torque_ratio=share, speed_ratio=speed)
    power = np.asarray(engine.speed) * engine.torque
    np.testing.assert_allclose(
        table.torque * table.speed, efficiency * share * speed * power * np.ones((len(ratios), 1)),
        rtol=1e-13,
    )  # fmt: skip


KINDS = (
    "full rebound", "rebound", "curb", "empty", "gvw", "overload", "jounce",
    "windup", "windup brake",
)  # fmt: skip
LINE = Line(
    shafts=(
        Shaft(length=1.3, centre_bearing=CentreBearing(from_rear_joint=140 * mm)),
        Shaft(length=1.1, centre_bearing=CentreBearing(from_rear_joint=90 * mm)),
        Shaft(length=1.6),
    )
)
LAYOUT = layout_from_slopes(
    side=np.radians([3, 1.5, 2, 6, 3]), top=np.radians([0, 0.5, -0.8, 0.3, 0]),
    lengths=[1.3, 1.1, 1.6],
)  # fmt: skip
COLLECTOR = Application(
    title="A 6x2",
    lines=(
        InstalledLine(line=LINE, layout=LAYOUT, axle=Axle(ratio=4.3, pinion_joint=(-0.4, 0.0))),
    ),
    states=tuple(VehicleState(name=kind, kind=kind) for kind in KINDS),
    limits=(),
    profile="none",
    vehicle=Vehicle(
        drive="6x2",
        wheelbase=5.2,
        driven_share=0.6,
        loads=(
            LoadState(name="curb", mass=7500, cg_behind_front=2.0, cg_height=0.9),
            LoadState(name="empty", mass=11000, cg_behind_front=2.8, cg_height=1.2),
            LoadState(name="gvw", mass=23000, cg_behind_front=3.8, cg_height=1.6),
        ),
    ),
    engine=Engine(speed=(1000 * rpm, 2300 * rpm), torque=(950, 800), brake_torque=200),
    gearbox=Gearbox(ratios=(9.2, 1.0), efficiency=0.95),
    tyre=Tyre(static_radius=0.49),
    suspension=Suspension(
        spring=Spring(load=(0, 11562, 26233, 60000), deflection=(0, 0.096, 0.185, 0.35)),
        unsprung_mass=900,
        linkage=Linkage(radius=0.65, angle=5 * deg, pitch_rate=0.3),
        windup_stiffness=15 * kNm / deg,
    ),
)
PER_STATE = (
    "torque", "engine_torque", "slip_torque", "coast_torque", "low_gear_torque",
    "wheel_slip_torque", "speed", "travel", "pitch", "spline_travel", "axle_load",
    "driven_load", "suspension_frequency",
)  # fmt: skip


@settings(max_examples=20)
@given(order=st.permutations(range(len(KINDS))))
def test_order_of_states_does_not_change_results(order):
    one = line_state_demand(resolve_line_references(COLLECTOR, COLLECTOR.lines[0]))
    shuffled = replace(COLLECTOR, states=tuple(COLLECTOR.states[k] for k in order))
    two = line_state_demand(resolve_line_references(shuffled, COLLECTOR.lines[0]))
    np.testing.assert_array_equal(one.layout.points[list(order)], two.layout.points)
    np.testing.assert_array_equal(one.layout.directions[list(order)], two.layout.directions)
    for name in PER_STATE:
        np.testing.assert_array_equal(getattr(one, name)[list(order)], getattr(two, name), name)


def test_mirrored_vehicle_has_equal_demand():
    installed = COLLECTOR.lines[0]
    mirror = np.array([1.0, -1.0, 1.0])
    image = Layout(points=LAYOUT.points * mirror, directions=LAYOUT.directions * mirror)
    one, two = (
        line_state_demand(resolve_line_references(COLLECTOR, i))
        for i in (installed, replace(installed, layout=image))
    )
    np.testing.assert_allclose(one.layout.points * mirror, two.layout.points, atol=1e-15)
    for name in PER_STATE:
        np.testing.assert_allclose(getattr(one, name), getattr(two, name), atol=1e-14)


def test_axle_travel_increases_from_rebound_to_bump():
    found = line_state_demand(resolve_line_references(COLLECTOR, COLLECTOR.lines[0]))
    assert np.all(np.diff(found.travel[:7]) > 0)


@settings(max_examples=20)
@given(shift=st.tuples(st.floats(-1, 1), st.floats(-1, 1), st.floats(-1, 1)))
def test_choice_of_origin_does_not_change_results(shift):
    installed = COLLECTOR.lines[0]
    elsewhere = Layout(points=LAYOUT.points + shift, directions=LAYOUT.directions)
    one, two = (
        line_state_demand(resolve_line_references(COLLECTOR, i))
        for i in (installed, replace(installed, layout=elsewhere))
    )
    np.testing.assert_allclose(one.layout.points + shift, two.layout.points, atol=1e-14)
    np.testing.assert_allclose(one.spline_travel, two.spline_travel, atol=1e-14)
