"""What a whole vehicle asks of its lines, state by state."""

from dataclasses import replace

import numpy as np
import pytest

from cardan.checks.line_response import compute_line_response
from cardan.core.errors import DesignError
from cardan.core.provenance import Source
from cardan.core.units import deg, g, inch, kNm, lbft, mm, rpm
from cardan.core.verdict import Limit
from cardan.model.application import Application, DutyPoint, InstalledLine, VehicleState
from cardan.model.layout import layout_from_slopes
from cardan.model.parts import CentreBearing, Line, Shaft
from cardan.model.powertrain import InterAxleDifferential
from cardan.model.vehicle import (
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
from cardan.physics.vehicle.state_demand import (
    layout_after_axle_motion,
    line_state_demand,
    resolve_line_references,
)
from cardan.physics.vehicle.suspension import spring_deflection

KINDS = (
    "full rebound", "rebound", "curb", "empty", "gvw", "overload", "jounce",
    "windup", "windup brake",
)  # fmt: skip
SPRING = Spring(
    load=(0, 11562, 12749, 26233, 43345), deflection=tuple(np.array([0, 96, 105, 185, 273]) * mm)
)
BEARING = CentreBearing(from_rear_joint=150 * mm)
MAIN = InstalledLine(
    line=Line(shafts=(Shaft(length=1.2, centre_bearing=BEARING), Shaft(length=1.5))),
    layout=layout_from_slopes(side=np.radians([3, 1, 4.5, 2]), top=np.zeros(4), lengths=[1.2, 1.5]),
    axle=Axle(ratio=5.0, efficiency=0.96, pinion_joint=(-450 * mm, 20 * mm)),
)
TRUCK = Application(
    title="A 4x2 truck",
    lines=(MAIN,),
    states=tuple(VehicleState(name=kind, kind=kind) for kind in KINDS),
    limits=(Limit(quantity="joint_angle", source=Source("Here"), maximum=1.0),),
    profile="none",
    vehicle=Vehicle(
        drive="4x2",
        wheelbase=4.8,
        loads=(
            LoadState(name="curb", mass=5600, cg_behind_front=1.6, cg_height=0.9),
            LoadState(name="empty", mass=7000, cg_behind_front=2.2, cg_height=1.1),
            LoadState(name="gvw", front_load=50e3, rear_load=58e3, cg_height=1.4),
        ),
    ),
    engine=Engine(
        speed=(1000 * rpm, 1600 * rpm, 2500 * rpm), torque=(850, 900, 700), brake_torque=250
    ),
    gearbox=Gearbox(ratios=(8.0, 4.0, 1.0), efficiency=0.95),
    tyre=Tyre(static_radius=480 * mm, friction=0.8),
    suspension=Suspension(
        spring=SPRING,
        unsprung_mass=700,
        linkage=Linkage(radius=0.6, angle=10 * deg),
        windup_stiffness=12 * kNm / deg,
    ),
)


def asked(application=TRUCK, installed=None):
    return line_state_demand(
        resolve_line_references(application, installed or application.lines[0])
    )


def with_states(*states, **changes):
    return replace(TRUCK, states=states, **changes)


def test_every_state_has_axle_travel():
    found = asked()
    k = {name: i for i, name in enumerate(found.states)}
    assert found.states == KINDS
    # By hand: load on the rear axle, less 700 kg, on two springs, through the table.
    rear = {"curb": 5600 * g * 1.6 / 4.8, "empty": 7000 * g * 2.2 / 4.8, "gvw": 58e3}
    rear["overload"] = 1.1 * rear["gvw"]
    heights = {
        kind: float(spring_deflection(SPRING, (load - 700 * g) / 2)) for kind, load in rear.items()
    }
    heights |= {"rebound": -inch, "jounce": 273 * mm, "windup": heights["gvw"]}
    held = asked(replace(TRUCK, suspension=replace(TRUCK.suspension, squats=False)))
    for kind, height in heights.items():
        assert held.travel[k[kind]] == pytest.approx(height - heights["gvw"], abs=1e-12), kind
    # Pulling it squats, braked it rises.
    assert found.travel[k["windup brake"]] < 0 < found.travel[k["windup"]]
    np.testing.assert_array_equal(found.travel[:7], held.travel[:7])
    # Where travel ends the springs say what tyres bear: at the end of the table, an inch off it.
    rear |= {"jounce": 2 * 43345 + 700 * g, "rebound": 700 * g - 2 * 11562 / 96 * inch / mm}
    for kind, load in rear.items():
        assert found.axle_load[k[kind]] == pytest.approx(load, rel=1e-12)
    assert found.travel[k["full rebound"]] < found.travel[k["rebound"]]
    np.testing.assert_array_equal(np.isnan(found.suspension_frequency)[:7],
                                  [True, True, False, False, False, False, True])  # fmt: skip


def test_reference_state_equals_given_layout():
    found = asked()
    k = found.states.index("gvw")
    np.testing.assert_allclose(found.layout.points[k], MAIN.layout.points, atol=1e-15)
    np.testing.assert_allclose(found.layout.directions[k], MAIN.layout.directions, atol=1e-15)
    assert found.spline_travel[k] == pytest.approx(0, abs=1e-15)
    assert found.pitch[k] == pytest.approx(0, abs=1e-15)


def test_changed_reference_shifts_all_states_equally():
    other = replace(TRUCK, suspension=replace(TRUCK.suspension, reference="empty"))
    one, two = asked(), asked(other)
    still = [k for k, kind in enumerate(KINDS) if "windup" not in kind]
    apart = one.travel - two.travel
    np.testing.assert_allclose(apart[still], apart[3], atol=1e-14)
    assert two.travel[3] == 0


def test_last_joint_moves_with_axle():
    found = asked()
    k = found.states.index("jounce")
    rise = found.travel[k]
    sine = np.sin(10 * deg) - rise / 0.6
    back = 0.6 * (np.sqrt(1 - sine**2) - np.cos(10 * deg))
    new, old = found.layout.points[k, -1], MAIN.layout.points[-1]
    np.testing.assert_allclose(new - old, [back, 0, rise], rtol=1e-12, atol=1e-15)
    length = np.linalg.norm(new - MAIN.layout.points[1])
    assert found.spline_travel[k] == pytest.approx(length - 1.5, abs=1e-14)


def test_torques_and_speed_match_hand_calculation():
    found = asked()
    k = found.states.index("gvw")
    assert found.engine_torque == pytest.approx(900 * 8 * 0.95, rel=1e-14)
    load = 58e3 / (1 - 0.8 * 1.4 / 4.8)  # rear drive on the level: W lf/(L - mu h)
    assert found.driven_load[k] == pytest.approx(load, rel=1e-14)
    assert found.slip_torque[k] == pytest.approx(0.8 * load * 0.48 / (5 * 0.96), rel=1e-14)
    assert found.torque[k] == found.slip_torque[k] > found.torque[found.states.index("curb")]
    top = np.where([name == "windup" for name in found.states], 2500 / 8, 2500)
    assert found.speed == pytest.approx(top * rpm, rel=1e-14)  # wound up in the lowest gear
    assert found.coast_torque[k] == pytest.approx(250 * 8 / 0.95, rel=1e-14)
    # J3311: manual gearbox 0.85, friction 0.71 and axle 0.95, axle at rest.
    assert found.low_gear_torque == pytest.approx(900 * 8 * 0.85, rel=1e-14)
    assert found.wheel_slip_torque[k] == pytest.approx(0.71 * 58e3 * 0.48 / (0.95 * 5), rel=1e-14)


def test_weak_engine_limits_torque():
    weak = replace(TRUCK, engine=replace(TRUCK.engine, torque=(150, 200, 150)))
    found = asked(weak)
    drives = [kind not in ("windup brake", "full rebound", "rebound") for kind in KINDS]
    np.testing.assert_allclose(found.torque[drives], 200 * 8 * 0.95, rtol=1e-14)


def test_given_overload_state_replaces_default():
    heavy = LoadState(name="overload", front_load=52e3, rear_load=70e3)
    vehicle = replace(TRUCK.vehicle, loads=(*TRUCK.vehicle.loads, heavy))
    found = asked(replace(TRUCK, vehicle=vehicle))
    assert found.axle_load[KINDS.index("overload")] == 70e3


def test_line_behind_transfer_case_turns_at_its_own_speed():
    quick = replace(MAIN, speed_ratio=1.2)
    assert asked(installed=quick).speed == pytest.approx(1.2 * asked().speed, rel=1e-14)
    given = replace(TRUCK, speed=100.0)
    found = asked(given, quick)
    # A top speed is none of the lowest gear, which winds the axle up.
    wound = np.array([s.kind == "windup" for s in given.states])
    assert found.speed[~wound] == pytest.approx(120.0, rel=1e-14)
    assert found.speed[wound] == pytest.approx(1.2 * asked().speed[wound], rel=1e-14)


def test_top_speed_excludes_windup_gear():
    """Full torque is there in first gear alone, 8 times slower than the engine; else 100 rad/s."""
    found = asked(replace(TRUCK, speed=100.0))
    first = max(TRUCK.engine.speed) / 8
    wanted = [first if kind == "windup" else 100.0 for kind in KINDS]
    assert found.speed == pytest.approx(wanted, rel=1e-14)
    given = VehicleState(name="w", kind="windup", speed=20.0)
    assert asked(with_states(given, speed=100.0)).speed == [20.0]


def test_j3311_factors_for_converter_transfer_case_and_rolling_radius():
    application = replace(
        TRUCK,
        gearbox=Gearbox(ratios=(4.0, 1.0), converter_ratio=1.9, transfer_ratio=2.2),
        tyre=Tyre(static_radius=480 * mm, dynamic_radius=500 * mm),
    )
    found = asked(application)
    assert found.low_gear_torque == pytest.approx(900 * 4 * 0.80 * 1.9 * 2.2 * 0.95, rel=1e-14)
    assert found.wheel_slip_torque[4] == pytest.approx(0.71 * 58e3 * 0.5 / (0.95 * 5), rel=1e-14)


def test_reference_state_needs_no_axle_load():
    """The geometry as measured, and only springs beside it: nothing to compute there."""
    found = asked(with_states(VehicleState(name="gvw", kind="gvw"), vehicle=None))
    assert found.travel == [0.0]


def test_overrun_torque_is_limited_by_tyre_slip():
    """Ten times the retarder: the wheels slip first, their load less by what it moves."""
    strong = replace(TRUCK, engine=replace(TRUCK.engine, brake_torque=2500))
    found = asked(strong)
    load = 58e3 / (1 + 0.8 * 1.4 / 4.8)
    expected = 0.8 * load * 0.48 * 0.96 / 5
    assert found.coast_torque[found.states.index("gvw")] == pytest.approx(expected, rel=1e-14)


def test_braking_windup_uses_overrun_torque():
    """It carried the drive torque, 6840 for -2105 N m here: the brakes wind, the gas is off."""
    found = asked()
    k = KINDS.index("windup brake")
    assert found.torque[k] == -found.coast_torque[k] == pytest.approx(-250 * 8 / 0.95, rel=1e-14)
    own = VehicleState(name="retarder", kind="windup brake", torque=900.0)
    assert asked(with_states(own)).torque == [-900.0]
    assert asked(with_states(own, torque=5e3, coast_torque=1e3)).torque == [-900.0]
    back = VehicleState(name="b", kind="windup brake")
    assert asked(with_states(back, torque=5e3, coast_torque=1e3)).torque == [-1e3]


def test_overrun_torque_is_unknown_without_engine():
    found = asked(replace(TRUCK, engine=None))
    assert np.isnan(found.coast_torque).all()
    np.testing.assert_array_equal(found.torque[:-1], found.slip_torque[:-1])
    assert np.isnan(found.torque[-1])  # of brake wind-up: the tyres alone hold nothing back
    silent = asked(replace(TRUCK, engine=replace(TRUCK.engine, brake_torque=None)))
    assert np.isnan([*silent.coast_torque, silent.torque[-1]]).all()
    assert np.isfinite(silent.torque[:-1]).all()
    given = asked(replace(TRUCK, engine=None, coast_torque=1500.0))
    np.testing.assert_array_equal(given.coast_torque, 1500.0)


def test_windup_angle_is_wheel_torque_over_stiffness():
    found = asked()
    k = found.states.index("windup")
    on_axle = found.torque[k] * 5 * 0.96
    pitch = on_axle / (12 * kNm / deg)
    assert pitch / deg == pytest.approx(2.42, abs=0.01)
    assert found.pitch[k] == pytest.approx(pitch, rel=1e-12)
    assert found.layout.points[k, -1, 2] > MAIN.layout.points[-1, 2]  # the nose rises


def test_braking_windup_has_opposite_sign():
    """Nothing said: as far as the tyres hold; said: with the engine's share on top."""
    k = KINDS.index("windup brake")
    w = 108e3
    braked = 58e3 - 0.8 * w * 1.4 / 4.8  # every wheel at the limit
    assert asked().pitch[k] == pytest.approx(-0.8 * braked * 0.48 / (12 * kNm / deg), rel=1e-12)
    said = replace(TRUCK, suspension=replace(TRUCK.suspension, brake_torque=3e3))
    engine = 250 * 8 / 0.95 * 5 / 0.96  # at the wheels: the axle's losses help to hold
    assert engine + 3e3 < 0.8 * braked * 0.48 * 2
    expected = -min(3e3 + engine, 0.8 * braked * 0.48) / (12 * kNm / deg)
    assert asked(said).pitch[k] == pytest.approx(expected, rel=1e-12)


def test_values_given_by_state_are_used():
    found = asked(
        with_states(
            VehicleState(name="by hand", travel=40 * mm, pitch=2 * deg, torque=5e3, speed=100.0),
            VehicleState(name="as given"),
            VehicleState(name="empty loads", load="empty"),
        )
    )
    assert found.travel == pytest.approx([40 * mm, 0, 0])
    assert found.pitch == pytest.approx([2 * deg, 0, 0], abs=1e-15)
    assert found.torque[0] == 5e3
    assert found.speed[0] == 100.0
    assert found.axle_load[1] == 58e3
    assert found.axle_load[2] == pytest.approx(7000 * g * 2.2 / 4.8, rel=1e-14)
    assert np.isnan(found.suspension_frequency).all()  # nobody says that these are at rest


def test_layout_given_by_state_is_used():
    own = layout_from_slopes(side=np.radians([3, 1, 8, 5]), top=np.zeros(4), lengths=[1.2, 1.52])
    found = asked(with_states(VehicleState(name="measured", kind="windup", layouts={"main": own})))
    np.testing.assert_allclose(found.layout.points[0], own.points, atol=1e-15)
    np.testing.assert_allclose(found.layout.directions[0], own.directions, atol=1e-15)
    assert found.spline_travel[0] == pytest.approx(20 * mm, rel=1e-12)
    assert found.pitch[0] == pytest.approx(3 * deg, rel=1e-12)
    rise = own.points[-1, 2] - MAIN.layout.points[-1, 2]
    assert found.travel[0] == pytest.approx(rise, rel=1e-12)


def test_smallest_application_needs_no_vehicle():
    small = Application(
        title="A protractor under the truck",
        lines=(replace(MAIN, axle=None),),
        states=(VehicleState(name="as measured"),),
        limits=(),
        profile="none",
        torque=8000.0,
        speed=2500 * rpm,
    )
    found = asked(small)
    assert found.torque == [8000.0]
    assert found.speed == [2500 * rpm]
    np.testing.assert_allclose(found.layout.points[0], MAIN.layout.points, atol=1e-15)
    for unknown in (found.engine_torque, found.slip_torque, found.coast_torque, found.axle_load):
        assert np.isnan(unknown).all()
    assert found.gears is None


def test_inter_axle_line_moves_with_both_axles():
    """A 6x4: half the torque, one axle's load, both ends going with their axles."""
    between = InstalledLine(
        line=Line(name="inter-axle", shafts=(Shaft(length=0.7),)),
        layout=layout_from_slopes(side=np.radians([2, 5, 2]), top=np.zeros(3), lengths=[0.7]),
        axle=MAIN.axle,
        torque_ratio=0.5,
        load_share=0.5,
        output_joint=(350 * mm, 60 * mm),
    )
    heavy = LoadState(name="gvw", front_load=60e3, rear_load=116e3, cg_height=1.4)
    tandem = replace(
        TRUCK,
        states=tuple(VehicleState(name=kind, kind=kind) for kind in ("gvw", "jounce", "windup")),
        vehicle=Vehicle(drive="6x4", wheelbase=4.8, loads=(heavy,)),
    )
    main, found = asked(tandem, MAIN), asked(tandem, between)
    assert main.axle_load[[0, 2]] == pytest.approx(58e3, rel=1e-14)
    np.testing.assert_allclose(found.axle_load, main.axle_load, rtol=1e-14)
    np.testing.assert_allclose(found.slip_torque, 0.5 * main.slip_torque, rtol=1e-14)
    np.testing.assert_allclose(found.engine_torque, 0.5 * main.engine_torque, rtol=1e-14)
    # Each axle takes half of the main line's torque: both wind up alike.
    np.testing.assert_allclose(found.pitch, main.pitch, rtol=1e-12, atol=1e-15)
    # Jounce lifts both ends and the line as a whole.
    lift = found.layout.points[1] - between.layout.points
    np.testing.assert_allclose(lift[0], lift[1], atol=1e-15)
    np.testing.assert_allclose(found.layout.directions[1], between.layout.directions, atol=1e-15)
    # In wind-up the front axle's output, behind its wheels, sinks; the gear tilts with it.
    assert found.layout.points[2, 0, 2] < found.travel[2]
    assert found.layout.side[2, 0] == pytest.approx(2 * deg + found.pitch[2], rel=1e-12)


def test_locked_differential_may_pass_full_torque_to_rear_axle():
    """With the axle ahead on ice: what the engine gives, up to what its own wheels hold."""
    between = replace(MAIN, torque_ratio=0.5, load_share=0.5, output_joint=(0.35, 0.1))
    vehicle = replace(TRUCK.vehicle, drive="6x4")
    states = tuple(VehicleState(name=kind, kind=kind) for kind in ("empty", "gvw"))
    engine = Engine(speed=(150.0, 220.0), torque=(330.0, 300.0))
    application = with_states(*states, vehicle=vehicle, lines=(MAIN, between), engine=engine)
    ahead, half = asked(application), asked(application, between)
    locked = replace(application, inter_axle=InterAxleDifferential(locked=True))
    whole = asked(locked, between)
    np.testing.assert_allclose(whole.engine_torque, 2 * half.engine_torque, rtol=1e-14)
    np.testing.assert_array_equal(whole.slip_torque, half.slip_torque)
    wanted = np.minimum(ahead.engine_torque, half.slip_torque)
    np.testing.assert_allclose(whole.torque, wanted, rtol=1e-14)
    assert (whole.torque > half.torque).any()
    np.testing.assert_array_equal(
        asked(locked).torque, ahead.torque
    )  # the main line has all as it is
    for line in (half, whole):
        assert line.static_state.line.nominal_torque_share == 0.5
        duty = replace(locked, duty=(DutyPoint(share=1.0, torque=1000.0, speed=100.0),))
        assert (
            compute_line_response(duty, line).inputs.duty_points[0].torque == 500.0
        )  # its life is not on ice
    open_ = replace(application, inter_axle=InterAxleDifferential(locked=False))
    np.testing.assert_array_equal(asked(open_, between).torque, half.torque)


def front_line(**changes):
    return InstalledLine(
        line=Line(name="front", shafts=(Shaft(length=1.1),)),
        layout=layout_from_slopes(side=np.radians([4, 9, 4]), top=np.zeros(3), lengths=[1.1]),
        axle=Axle(ratio=5.0, efficiency=0.96, pinion_joint=(-400 * mm, 0.0)),
        torque_ratio=0.5,
        drives="front",
        **changes,
    )


def test_front_axle_line_reverses_direction_of_motion():
    """The line runs forward: its frame is the vehicle's turned half round about z.

    Rising, the axle goes rearward by the same link, so against the flow; in traction the
    housing turns about the vehicle's +y, and a pinion that faces rearward sinks.
    """
    application = with_states(
        *(VehicleState(name=kind, kind=kind) for kind in ("gvw", "jounce", "windup")),
        vehicle=replace(TRUCK.vehicle, drive="4x4"),
    )
    line = front_line(suspension=TRUCK.suspension)
    found = asked(application, line)
    assert found.axle_load[[0, 2]] == pytest.approx(50e3, rel=1e-14)
    rear = asked(application)
    assert found.travel[2] < 0 < rear.travel[2]  # load goes from the one to the other
    rise = found.travel[1]
    sine = np.sin(10 * deg) - rise / 0.6
    back = 0.6 * (np.sqrt(1 - sine**2) - np.cos(10 * deg))
    np.testing.assert_allclose(
        found.layout.points[1, -1] - line.layout.points[-1], [-back, 0, rise], atol=1e-14
    )
    assert rear.pitch[2] > 0 > found.pitch[2]
    assert found.layout.points[2, -1, 2] < line.layout.points[-1, 2]
    # At the rear's limit all wheels slip; the front holds most where it pulls alone.
    lever = 0.8 * 1.4 / 4.8
    assert rear.driven_load[0] == pytest.approx(58e3 + lever * 108e3, rel=1e-14)
    assert found.driven_load[0] == pytest.approx(50e3 / (1 + lever), rel=1e-14)


def test_pinion_nose_rise_has_same_sense_for_any_orientation():
    """A pitch that is given, by a state or by the linkage, is in the sense of a shim."""
    linkage = Linkage(travel=(-0.2, 0.2), pitch=(-2 * deg, 2 * deg))
    application = with_states(
        VehicleState(name="gvw", kind="gvw"),
        VehicleState(name="turned", travel=0.0, pitch=1 * deg),
        VehicleState(name="up", travel=0.1),
        vehicle=replace(TRUCK.vehicle, drive="4x4"),
    )
    line = front_line(suspension=replace(TRUCK.suspension, linkage=linkage))
    found = asked(application, line)
    np.testing.assert_allclose(found.pitch, [0, 1 * deg, 1 * deg], atol=1e-12)
    shimmed = found.corrected_layout(shim=1 * deg)
    np.testing.assert_allclose(found.layout.points[1], shimmed.points[0], atol=1e-14)
    # Its joint is the nose, 400 mm on the gearbox's side of the wheels: the joint rises with it.
    assert found.layout.points[1, -1, 2] - line.layout.points[-1, 2] == pytest.approx(
        0.4 * np.sin(1 * deg), rel=1e-9
    )


def test_windup_of_rear_axle_with_forward_line_is_reversed():
    """The line runs forward to a rear axle: what moves that moves it as a front axle's."""
    states = tuple(VehicleState(name=kind, kind=kind) for kind in ("gvw", "jounce", "windup"))
    rearward = asked(with_states(*states), MAIN)
    forward = asked(with_states(*states), replace(MAIN, runs="forward"))
    went = forward.layout.points[1, -1] - MAIN.layout.points[-1]
    np.testing.assert_allclose(
        went, (rearward.layout.points[1, -1] - MAIN.layout.points[-1]) * (-1, 1, 1), atol=1e-14
    )
    np.testing.assert_allclose(forward.pitch[2], -rearward.pitch[2], rtol=1e-12)
    assert rearward.pitch[2] > 0.01
    np.testing.assert_array_equal(forward.slip_torque, rearward.slip_torque)


def test_line_to_transfer_case_does_not_move():
    line = replace(MAIN, axle=None, drives="all")
    found = asked(with_states(*TRUCK.states, vehicle=replace(TRUCK.vehicle, drive="4x4")), line)
    for points in found.layout.points:
        np.testing.assert_allclose(points, MAIN.layout.points, atol=1e-15)
    assert not found.travel.any()


def test_corrections_of_all_states_are_batched():
    found = asked()
    states, variants = len(KINDS), 5
    shift = np.zeros((variants, 1, 1, 3))
    shift[:, 0, 0, 2] = np.linspace(-20, 20, variants) * mm
    shim = np.linspace(-1, 1, variants)[:, None] * deg
    layouts = found.corrected_layout(bearing_shift=shift, shim=shim)
    assert layouts.points.shape == (variants, states, 3, 3)
    np.testing.assert_allclose(layouts.points[2], found.layout.points, atol=1e-15)
    np.testing.assert_allclose(layouts.side[..., -1], found.layout.side[:, -1] + shim, atol=1e-14)
    # The same by hand for one variant and state.
    k = KINDS.index("jounce")
    alone = layout_after_axle_motion(
        MAIN.layout,
        MAIN.line,
        bearing_shift=shift[0, 0],
        last_shift=found.axle_motion.shift[k],
        pinion_pitch=found.axle_motion.pitch[k] + shim[0, 0],
        pinion_arm=(-450 * mm, 0, 20 * mm),
    )
    np.testing.assert_allclose(layouts.points[0, k], alone.points, atol=1e-15)


def test_j3311_example_is_reproduced():
    """Net 1567.5 lb-ft in a low gear of 10.96 through a manual gearbox: 14,603 lb-ft."""
    example = replace(
        TRUCK,
        engine=Engine(speed=(1200 * rpm,), torque=(1567.5 * lbft,)),
        gearbox=Gearbox(ratios=(10.96, 1.0), efficiency=0.97),
    )
    assert asked(example).low_gear_torque[0] / lbft == pytest.approx(14603, abs=0.5)


@pytest.mark.parametrize(
    ("application", "installed", "message"),
    [
        (replace(TRUCK, states=()), MAIN, "has no state"),
        (replace(TRUCK, suspension=None), MAIN, "state full rebound cannot place the rear axle"),
        (replace(TRUCK, vehicle=None), MAIN, "needs the axle's load"),
        (
            with_states(VehicleState(name="x", load="half")),
            MAIN,
            "no load state half; there are: curb",
        ),
        (
            with_states(
                VehicleState(name="jounce", kind="jounce"),
                vehicle=replace(TRUCK.vehicle, drive="4x4"),
            ),
            front_line(),
            "state jounce cannot place the front axle of line front",
        ),
        (
            with_states(
                VehicleState(name="windup", kind="windup"),
                suspension=replace(TRUCK.suspension, windup_stiffness=None),
            ),
            MAIN,
            "needs a windup_stiffness",
        ),
        (
            with_states(VehicleState(name="w", kind="windup brake"), tyre=None),
            MAIN,
            "state w of line main needs",
        ),
        (
            with_states(VehicleState(name="w", kind="windup"), engine=None, tyre=None),
            MAIN,
            "state w of line main needs",
        ),
        (
            with_states(
                VehicleState(
                    name="x",
                    layouts={"main": layout_from_slopes(side=[0] * 3, top=[0] * 3, lengths=[1.0])},
                )
            ),
            MAIN,
            "3 joints in every state",
        ),
    ],
)
def test_missing_input_is_named(application, installed, message):
    with pytest.raises(DesignError, match=message):
        line_state_demand(resolve_line_references(application, installed))


def test_zero_load_share_is_rejected():
    with pytest.raises(DesignError, match="load_share"):
        replace(MAIN, load_share=0.0)
