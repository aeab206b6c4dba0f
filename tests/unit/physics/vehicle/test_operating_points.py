"""Operating points: what torque, speed and geometry a line has together, by hand."""

from dataclasses import replace

import numpy as np
import pytest
from repository import ROOT

from cardan.application import reader, templates
from cardan.core.errors import DesignError
from cardan.core.units import deg, g, kNm, rpm
from cardan.model.application import VehicleState
from cardan.model.vehicle import Engine, Gearbox
from cardan.physics.vehicle.operating_points import (
    TorqueCurves,
    demand_at_operating_points,
    torque_curves,
)
from cardan.physics.vehicle.state_demand import line_state_demand, resolve_line_references
from cardan.physics.vehicle.suspension import axle_path
from cardan.physics.vehicle.torque import (
    largest_torque_from_standstill,
    retarding_torques,
    reverse_gear_table,
)

TEXT = (ROOT / "tests" / "truck.yaml").read_text(encoding="utf-8")
TRUCK = reader.loads(
    TEXT.replace("  transfer_ratio: 1.0\n", "  reverse_ratio: 6.6\n  retarder_torque_Nm: 1000\n")
    .replace("  reference: gvw\n", "  reference: gvw\n  brake_torque_Nm: 2000\n")
    .replace("  - windup\n", "  - windup\n  - windup brake\n")
)
HELD = replace(TRUCK, suspension=replace(TRUCK.suspension, squats=False))
"""Its axle wound up by torque alone."""
LADEN = 23000 * g * 3.548 / (4.8 - 0.8 * 0.6 * 1.5) * 0.6  # N, on driven wheels about to slip
BACK = 23000 * g * 3.548 / (4.8 + 0.8 * 0.6 * 1.5) * 0.6  # as they hold back, or push astern
GRIP = 0.8 * 0.48 / 4.88  # N m on the line per N, before losses
STIFF = 16 * kNm / deg


def asked(application=TRUCK, line=0):
    return line_state_demand(resolve_line_references(application, application.lines[line]))


def curve(found, direction, gear):
    return list(zip(found.directions, found.gears, strict=True)).index((direction, gear))


def torque(of, direction, gear, speed, state="gvw"):
    """Torque on one curve in one state, N m."""
    found, d = torque_curves(of), of.states.index(state)
    return found.torque_at(np.full(found.max_speed.shape, speed)[None])[
        0, curve(found, direction, gear), d
    ]


def at(of, direction, gear, speed):
    """The demand at one point in all states."""
    found = torque_curves(of)
    speeds = np.full((1, len(of.states)), speed)
    return demand_at_operating_points(
        of, found, curve=[curve(found, direction, gear)], speed=speeds
    )


# --------------------------------------------------------------------------- envelopes


def test_slipping_clutch_gives_largest_torque_from_standstill():
    """Two peaks: it falls from the first to where the second holds, and then from that."""
    speed, held = largest_torque_from_standstill(
        np.array([100.0, 200.0, 300.0, 400.0, 500.0]), np.array([80.0, 100.0, 60.0, 90.0, 50.0])
    )
    for n, expected in {0: 100, 150: 100, 200: 100, 220: 92, 225: 90, 300: 90, 400: 90,
                        450: 70, 500: 50}.items():  # fmt: skip
        assert np.interp(n, speed, held) == pytest.approx(expected, rel=1e-14), n
    assert (np.diff(speed) >= 0).all()
    assert (np.diff(held) <= 0).all()


def test_drive_torque_matches_hand_calculation():
    of = asked()
    peak = 950 * 9.2 * 0.95
    slip = LADEN * GRIP / 0.96
    assert peak < slip
    for n in (0, 50, 100, 1600 / 9.2):
        assert torque(of, "drive", "1", n * rpm) == pytest.approx(peak, rel=1e-13)
    half = (850 + 950) / 2 * 9.2 * 0.95  # half way from 1600 to 2200
    assert torque(of, "drive", "1", 1900 / 9.2 * rpm) == pytest.approx(half, rel=1e-13)
    assert torque(of, "drive", "6", 2500 * rpm) == pytest.approx(700 * 0.95, rel=1e-13)
    assert np.isnan(torque(of, "drive", "1", 2501 / 9.2 * rpm))
    assert np.isnan(torque(of, "drive", "1", -1.0))


def test_drive_torque_is_limited_by_tyre_slip():
    """Empty, 6500 kg on the bogie and what moves there under its own force; friction 0.9.

    In second gear that is between what 2200 and 2500 rpm give, so the curve bends there alone.
    """
    of = asked(replace(TRUCK, tyre=replace(TRUCK.tyre, friction=0.9)))
    load = 0.6 * 6500 * g / (1 - 0.9 * 0.6 * 1.1 / 4.8)  # N = s (R + mu N h/L)
    slip = 0.9 * load * 0.48 / (4.88 * 0.96)
    full = np.array([850, 700]) * 5.3 * 0.95
    assert full[1] < slip < full[0]
    assert torque(of, "drive", "2", 0, "empty") == pytest.approx(slip, rel=1e-12)
    meets = 2200 + 300 * (full[0] - slip) / (full[0] - full[1])
    found = torque_curves(of)
    corners = found.corner_speeds[:, curve(found, "drive", "2"), of.states.index("empty")]
    expected = np.array([0, meets, 2500]) / 5.3 * rpm
    np.testing.assert_allclose(corners[~np.isnan(corners)], expected, rtol=1e-12)


def test_inter_axle_line_carries_its_torque_share():
    of = [asked(reader.read(ROOT / "examples" / "tandem-6x4.yaml"), line=k) for k in (0, 1)]
    share = of[1].static_state.line.max_torque_share
    assert share == 0.5
    for direction in ("drive", "coast"):
        main, between = (torque(o, direction, "5", 1.0) for o in of)
        assert between == pytest.approx(share * main, rel=1e-13)


def test_overrun_torque_includes_engine_brake_and_retarder():
    of = asked()
    for gear, ratio in (("1", 9.2), ("4", 2.0)):
        held = 350 * ratio / 0.95 + 1000
        for n in (0, 50, 2500 / 9.2):
            assert torque(of, "coast", gear, n * rpm) == pytest.approx(-held, rel=1e-13)
    assert of.coast_torque[2] == pytest.approx(350 * 9.2 / 0.95 + 1000, rel=1e-13)
    strong = asked(replace(TRUCK, engine=replace(TRUCK.engine, brake_torque=1500)))
    expected = -BACK * GRIP * 0.96
    assert torque(strong, "coast", "1", 1.0) == pytest.approx(expected, rel=1e-12)


def test_reverse_gear_torque_is_negative():
    of = asked()
    assert torque(of, "reverse", "R", 0) == pytest.approx(-950 * 6.6 * 0.95, rel=1e-13)
    end = 2500 / 6.6 * rpm
    assert torque(of, "reverse", "R", end) == pytest.approx(-700 * 6.6 * 0.95, rel=1e-13)
    assert np.isnan(torque(of, "reverse", "R", 1.001 * end))
    # Pushed astern the rear axle is the lighter one, and power runs to the wheels.
    strong = asked(replace(TRUCK, engine=replace(TRUCK.engine, torque=(2000.0,) * 5)))
    assert torque(strong, "reverse", "R", 0) == pytest.approx(-BACK * GRIP / 0.96, rel=1e-12)
    assert "reverse" not in torque_curves(asked(reader.loads(TEXT))).directions


def test_low_range_has_own_gears_and_reverse():
    engine = Engine(speed=(100.0, 200.0), torque=(900.0, 800.0), brake_torque=300.0)
    gearbox = Gearbox(ratios=(4.0, 1.0), efficiency=0.9, transfer_ratio=2.0, reverse_ratio=3.0,
                      retarder_torque=50.0)  # fmt: skip
    reverse = reverse_gear_table(engine, gearbox, torque_ratio=0.5, speed_ratio=1.25)
    assert reverse.names == ("R", "low R")
    np.testing.assert_allclose(
        reverse.peak_torque, [0.5 * 900 * r * 0.9 for r in (3, 6)], rtol=1e-14
    )
    np.testing.assert_allclose(reverse.speed[:, -1], [1.25 * 200 / r for r in (3, 6)], rtol=1e-14)
    held = [300 * r / 0.9 + 50 * low for low, r in ((1, 4), (1, 1), (2, 8), (2, 2))]
    np.testing.assert_allclose(retarding_torques(engine, gearbox), held, rtol=1e-14)
    found = torque_curves(asked(replace(TRUCK, engine=engine, gearbox=gearbox)))
    assert [g for d, g in zip(found.directions, found.gears, strict=True) if d != "brake"] == [
        "1", "2", "low 1", "low 2", "1", "2", "low 1", "low 2", "R", "low R",
    ]  # fmt: skip


def test_retarder_alone_gives_overrun_torque_in_every_gear():
    alone = replace(TRUCK, engine=replace(TRUCK.engine, brake_torque=None))
    assert torque(asked(alone), "coast", "6", 2500 * rpm) == -1000
    nobody = replace(alone, gearbox=replace(TRUCK.gearbox, retarder_torque=None))
    assert "coast" not in torque_curves(asked(nobody)).directions


def test_braking_points_use_strongest_overrun_torque():
    of = asked()
    held = 350 * 9.2 / 0.95 + 1000
    first = 2500 * rpm / 9.2
    assert torque(of, "brake", "1", first) == pytest.approx(-held, rel=1e-13)
    # No engine of 2500 rpm turns faster in first gear; sixth reaches that, and holds less.
    assert np.isnan(torque(of, "brake", "1", 1.001 * first))
    assert torque(of, "brake", "6", 2500 * rpm) == pytest.approx(-(350 / 0.95 + 1000), rel=1e-13)
    assert np.isnan(torque(of, "brake", "6", 2501 * rpm))
    plain = asked(reader.loads(TEXT))
    assert "brake" not in torque_curves(plain).directions  # nobody gives a brake torque
    silent = replace(TRUCK, engine=replace(TRUCK.engine, brake_torque=None),
                     gearbox=replace(TRUCK.gearbox, retarder_torque=None),
                     states=TRUCK.states[:3])  # fmt: skip
    assert torque(asked(silent), "brake", "", 1.0) == 0


# --------------------------------------------------------------------------- states


def test_torque_given_by_state_is_used():
    states = (
        VehicleState(name="slow", kind="gvw", speed=600 * rpm),
        VehicleState(name="strong", kind="gvw", torque=12e3, speed=200 * rpm),
        VehicleState(name="gvw", kind="gvw"),
        VehicleState(name="windup", kind="windup"),
        VehicleState(name="windup brake", kind="windup brake"),
    )
    of = asked(replace(TRUCK, states=states, speed=2000 * rpm))
    found = torque_curves(of)
    ends = {
        (d, g): e / rpm
        for d, g, e in zip(found.directions, found.gears, found.max_speed, strict=True)
    }
    nan, first = np.nan, 2500 / 9.2
    for key, end in {
        ("drive", "1"): (first, nan, first, first, nan),
        ("drive", "6"): (600, nan, 2000, 2500, nan),
        ("drive", ""): (nan, 200, nan, nan, nan),
        ("coast", "6"): (600, 200, 2000, nan, nan),
        ("reverse", "R"): (2500 / 6.6, 200, 2500 / 6.6, nan, nan),
        ("brake", "6"): (600, 200, 2000, nan, 2000),
        ("brake", "1"): (first, 200, first, nan, first),
    }.items():
        np.testing.assert_allclose(ends[key], end, rtol=1e-13, err_msg=str(key))
    assert torque(of, "drive", "", 100 * rpm, "strong") == 12e3  # it is the tyres' no matter


def test_speed_given_by_state_of_hanging_axle_is_used():
    of = asked(reader.read(ROOT / "examples" / "refuse-collector-6x2.yaml"))
    found, s = torque_curves(of), of.states.index("full rebound")
    assert np.nanmax(found.max_speed[:, s]) == pytest.approx(600 * rpm, rel=1e-14)
    assert np.nanmax(found.corner_speeds[:, :, s]) == pytest.approx(600 * rpm, rel=1e-14)


def test_torque_given_by_application_replaces_gears():
    of = asked(replace(TRUCK, torque=5e3, coast_torque=700.0))
    found = torque_curves(of)
    names = set(zip(found.directions, found.gears, strict=True))
    assert names == {("drive", ""), ("coast", ""), ("reverse", "R"), ("brake", "")}
    assert torque(of, "drive", "", 2500 * rpm) == 5e3
    assert torque(of, "coast", "", 2500 * rpm) == -700


def test_torque_and_speed_without_engine_are_drive_curve():
    small = reader.loads(templates.template_text("small"))
    of = asked(small)
    found = torque_curves(of)
    assert (found.gears, found.directions) == (("",), ("drive",))
    np.testing.assert_allclose(found.corner_speeds[:, 0, 0] / rpm, [0, 2500], rtol=1e-14)
    assert torque(of, "drive", "", 1000 * rpm, of.states[0]) == 8000
    back = asked(replace(small, coast_torque=900.0))
    assert torque(back, "coast", "", 2500 * rpm, back.states[0]) == -900
    still = torque_curves(asked(replace(small, speed=None)))
    np.testing.assert_array_equal(still.corner_speeds, [[[0]]])  # nobody knows how fast
    nothing = torque_curves(asked(replace(small, torque=None)))
    assert nothing.gears == ()
    assert nothing.corner_speeds.shape[1:] == (0, 1)


# --------------------------------------------------------------------------- geometry


def test_axle_windup_follows_torque_of_operating_point():
    """16 kN m/deg: 8303 N m of first gear turn it by 2.43 deg, coast and reverse back."""
    of = asked(HELD)
    k, free = of.states.index("gvw"), at(of, "drive", "1", 0)
    pitch = 950 * 9.2 * 0.95 * 4.88 * 0.96 / STIFF
    assert pitch / deg == pytest.approx(2.431, abs=5e-4)
    assert free.pitch[0, k] == pytest.approx(pitch, rel=1e-12)
    assert free.layout.points[0, k, -1, 2] > of.layout.points[k, -1, 2]  # the nose rises
    back = (350 * 9.2 / 0.95 + 1000) * 4.88 / 0.96 / STIFF  # the wheels turn the line
    assert at(of, "coast", "1", 0).pitch[0, k] == pytest.approx(-back, rel=1e-12)
    astern = 950 * 6.6 * 0.95 * 4.88 * 0.96 / STIFF
    assert at(of, "reverse", "R", 0).pitch[0, k] == pytest.approx(-astern, rel=1e-12)
    held = 2000 + (350 * 9.2 / 0.95 + 1000) * 4.88 / 0.96
    assert at(of, "brake", "1", 0).pitch[0, k] == pytest.approx(-held / STIFF, rel=1e-12)
    strong = asked(replace(HELD, suspension=replace(HELD.suspension, brake_torque=9e3)))
    braked = 0.6 * 23000 * g * (3.548 - 0.8 * 1.5) / 4.8  # every wheel at its limit
    expected = -0.8 * 0.48 * braked / STIFF
    assert at(strong, "brake", "1", 0).pitch[0, k] == pytest.approx(expected, rel=1e-12)


def test_springs_place_axle_and_torque_pitches_it():
    of = asked()
    k, found = of.states.index("jounce"), at(of, "drive", "1", 0)
    up = found.pitch[0, k] - of.pitch[k]
    assert up == pytest.approx(950 * 9.2 * 0.95 * 4.88 * 0.96 / STIFF, rel=1e-12)
    squats = of.static_state.squats
    np.testing.assert_array_equal(found.travel[0, ~squats], of.travel[~squats])
    line = of.static_state.line
    driven = (
        squats & ~line.in_suspension_state("windup") & ~line.in_suspension_state("windup brake")
    )
    # Laden it squats; empty its link lifts it more than load transfer sets it down.
    lies = of.states.index("gvw"), of.states.index("empty")
    assert driven[list(lies)].all()
    assert found.travel[0, lies[0]] > of.travel[lies[0]] + 0.01
    assert found.travel[0, lies[1]] < of.travel[lies[1]]
    given = of.states.index("parked on a kerb")  # the file says its pitch
    assert found.pitch[0, given] == of.pitch[given]


def test_front_axle_windup_has_opposite_sign():
    of = asked(reader.read(ROOT / "tests" / "verify" / "by_hand_front.yaml"), line=2)
    line = of.static_state.line
    assert line.installed.drives == "front"
    found, axle = at(of, "drive", "1", 0), line.axle
    up = found.pitch[0] - of.pitch
    expected = -found.torque[0] * axle.ratio * axle.efficiency / line.suspension.windup_stiffness
    free = (
        ~line.in_suspension_state("windup")
        & ~line.in_suspension_state("windup brake")
        & of.static_state.winds_up
    )
    # Load goes to the rear: it rises, and its link pitches it.
    assert (found.travel[0] < of.travel)[free & of.static_state.squats].any()
    paths = [axle_path(line.suspension.linkage, t)[1] for t in (found.travel[0], of.travel)]
    expected += paths[0] - paths[1]
    assert free.any()
    np.testing.assert_allclose(up[free], expected[free], rtol=1e-9)


@pytest.mark.parametrize(
    ("state", "direction", "gear"), [("windup", "drive", "1"), ("windup brake", "brake", "1")]
)
def test_windup_state_is_one_of_its_operating_points(state, direction, gear):
    """To the last bit: there is one path to both."""
    of = asked()
    k, found = of.states.index(state), at(of, direction, gear, 0)
    assert found.torque[0, k] == of.torque[k]
    np.testing.assert_array_equal(found.layout.points[0, k], of.layout.points[k])
    np.testing.assert_array_equal(found.layout.directions[0, k], of.layout.directions[k])
    assert found.spline_travel[0, k] == of.spline_travel[k]


def test_missing_operating_point_keeps_layout_of_state():
    of = asked()
    found = at(of, "drive", "1", 1000.0)
    assert np.isnan([found.torque, found.speed]).all()
    np.testing.assert_array_equal(found.layout.points[0], of.layout.points)


def test_axle_of_unknown_stiffness_keeps_position_of_state():
    soft = replace(
        TRUCK,
        suspension=replace(HELD.suspension, windup_stiffness=None),
        states=tuple(s for s in TRUCK.states if "windup" not in s.name),
    )
    of = asked(soft)
    found = at(of, "drive", "1", 0)
    np.testing.assert_array_equal(found.layout.points[0], of.layout.points)
    assert (found.torque > 0)[:, 1:].all()  # fully rebound it hangs, and holds none


def test_locked_joint_is_rejected_with_its_operating_point():
    limp = replace(TRUCK.suspension, windup_stiffness=0.2 * kNm / deg)
    of = asked(replace(TRUCK, suspension=limp, states=(VehicleState(name="gvw", kind="gvw"),)))
    with pytest.raises(
        DesignError,
        match=r"joint 3 of line main locks in state gvw, drive in gear 1 with 8303 N m: "
        r"its angle must stay below 90 deg, got",
    ) as error:
        at(of, "drive", "1", 0)
    assert error.value.about == "states[1]"
    at(of, "drive", "6", 0)  # its torque turns the axle less


def test_packed_points_hold_existing_operating_points_only():
    of = asked()
    found = torque_curves(of)
    curve_, speed = found.points_at(found.corner_speeds)
    assert speed.shape == (curve_.size, len(of.states))
    assert not np.isnan(speed).all(axis=1).any()
    assert np.sum(~np.isnan(speed)) == np.sum(~np.isnan(found.corner_speeds))
    at_all = demand_at_operating_points(of, found, curve=curve_, speed=speed)
    np.testing.assert_array_equal(np.isnan(at_all.torque), np.isnan(speed))
    each = [found.directions[c] for c in curve_]
    sizes = {"drive": 1, "coast": -1, "reverse": -1, "brake": -1}
    with np.errstate(invalid="ignore"):
        assert all(not (np.sign(t) == -sizes[d]).any()
                   for d, t in zip(each, at_all.torque, strict=True))  # fmt: skip


def test_torque_curve_may_jump_at_one_speed():
    one = np.ones((1, 1))
    found = TorqueCurves(
        gears=("1",),
        directions=("drive",),
        speed=np.array([[[0.0, 10.0, 10.0, 20.0]]]),
        torque=np.array([[[100.0, 90.0, 60.0, 50.0]]]),
        torque_limit=95 * one,
        max_speed=20 * one,
    )
    asked = np.array([0.0, 5.0, 7.0, 10.0, 15.0, 20.0, 21.0, -1.0])
    told = found.torque_at(asked[:, None, None])[:, 0, 0]
    np.testing.assert_allclose(told, [95, 95, 93, 60, 55, 50, np.nan, np.nan], rtol=1e-14)


def test_given_overspeed_is_evaluated_beyond_gear_range():
    """Downhill: the brake holds in the fastest gear, or nothing does; backing has no hills."""
    top = float(TRUCK.engine.speed[-1]) / min(TRUCK.gearbox.ratios)
    said = 1.2 * top
    of = asked(replace(TRUCK, speed=said, states=(VehicleState(name="gvw", kind="gvw"),)))
    found = torque_curves(of)
    fast = {
        (d, g): float(end) / top
        for d, g, end in zip(found.directions, found.gears, found.max_speed[:, 0], strict=True)
    }
    last = f"{len(TRUCK.gearbox.ratios)}"
    beyond = {k: end for k, end in fast.items() if end > 1}
    assert set(beyond) == {
        ("drive", ""), ("coast", last), *({("brake", last)} & fast.keys())
    }  # fmt: skip
    assert list(beyond.values()) == pytest.approx([1.2] * len(beyond))
    assert fast["drive", last] == pytest.approx(1.0)
    slow = asked(replace(TRUCK, speed=None, states=(VehicleState(name="gvw", kind="gvw"),)))
    assert ("drive", "") not in set(
        zip(torque_curves(slow).directions, torque_curves(slow).gears, strict=True)
    )
    held = torque(slow, "coast", last, top, "gvw")
    assert torque(of, "coast", last, said, "gvw") == pytest.approx(held)
    assert torque(of, "drive", last, top, "gvw") == torque(slow, "drive", last, top, "gvw") > 0
    assert torque(of, "drive", "", said, "gvw") == 0.0


def test_governor_limits_speed_of_line():
    """As a curve carried on to nothing there, in every number."""
    top = 1.15 * float(TRUCK.engine.speed[-1])
    engine = replace(TRUCK.engine, governed=top)
    carried = replace(
        TRUCK.engine, speed=(*TRUCK.engine.speed, top), torque=(*TRUCK.engine.torque, 0.0)
    )
    one, other = (asked(replace(TRUCK, speed=None, engine=e)) for e in (engine, carried))
    k = one.states.index("gvw")
    assert one.speed[k] == pytest.approx(top / min(TRUCK.gearbox.ratios))
    np.testing.assert_array_equal(one.speed, other.speed)
    for a, b in (
        (torque_curves(one).speed, torque_curves(other).speed),
        (torque_curves(one).torque, torque_curves(other).torque),
    ):
        np.testing.assert_allclose(a, b)
