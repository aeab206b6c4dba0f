"""Squat: what the tyres pull moves an axle on its springs; held against the least of its energy.

The oracle minimises the potential of springs, load and tyre force over the axle's rise (scipy),
where the program iterates a balance of forces.
"""

import re
from dataclasses import replace

import numpy as np
import pytest
from repository import EXAMPLES
from scipy.optimize import minimize_scalar

from cardan.application import reader
from cardan.approval.notes import approval_notes
from cardan.checks.drive_forces import TorqueSpeedTimeHistory, bearing_forces_over_time_history
from cardan.checks.line_response import compute_line_response
from cardan.core.errors import DesignError
from cardan.core.units import deg, g, mm
from cardan.model.application import VehicleState
from cardan.physics.loads.centre_bearing import bearing_forces
from cardan.physics.vehicle.state_demand import (
    demand_with_axle_moved_by_torque,
    line_state_demand,
    resolve_line_references,
)
from cardan.physics.vehicle.suspension import axle_path, spring_load, squat_travel

TRUCK = reader.read(EXAMPLES / "medium-truck-4x2.yaml")
MU, RADIUS, HEIGHT, BASE = 0.8, 0.405, 1.35, 3.69
REAR, ALL = 7700 * g, 12000 * g


def asked(application=TRUCK):
    return line_state_demand(resolve_line_references(application, application.lines[0]))


def rise(suspension, load, force, moved, *, radius=RADIUS, ahead=1):
    """Where the potential of an axle is least, (m): springs, what they bear, what tyres pull."""
    own = (load - suspension.unsprung_mass * g) / suspension.springs_per_axle
    table = np.linspace(0, suspension.jounce_deflection or suspension.spring.deflection[-1], 20001)
    start = float(np.interp(own, spring_load(suspension.spring, table), table))
    stored = np.concatenate(
        [[0], np.cumsum(np.diff(table) * spring_load(suspension.spring, table[1:] - table[1] / 2))]
    )

    def potential(z):
        dx, pitch = axle_path(suspension.linkage, z)
        spring = suspension.springs_per_axle * np.interp(start + z, table, stored)
        return (
            spring
            - (suspension.springs_per_axle * own + moved) * z
            + force * (dx - ahead * radius * pitch)
        )

    found = minimize_scalar(
        potential, bounds=(table[0] - start, table[-1] - start), method="bounded",
        options={"xatol": 1e-9},
    )  # fmt: skip
    return float(found.x)


@pytest.mark.parametrize(
    ("torque", "coasts", "brakes"),
    [(5410.25, False, False), (700.0, False, False), (-900.0, True, False),
     (-4845.0, False, False), (-900.0, True, True)],
)  # fmt: skip
def test_squat_minimises_potential_energy_in_every_direction(torque, coasts, brakes):
    """Drive, coast, reverse and brakes; load moves by F h/L of what all tyres pull."""
    of = asked()
    k = of.states.index("gvw")
    found = demand_with_axle_moved_by_torque(
        of, torque=np.full((1, len(of.states)), torque), speed=0.0, coasts=coasts, brakes=brakes
    )
    housing = torque * 3.91 * (1 / 0.95 if coasts else 0.95)
    force = total = housing / RADIUS
    if brakes:
        # Every wheel at the same share of what it holds: the rear's of all.
        rear = REAR - MU * ALL * HEIGHT / BASE
        housing = -min(14000 - housing, MU * RADIUS * rear)
        force = housing / RADIUS
        total = force * ALL / rear
    expected = rise(TRUCK.suspension, REAR, force, total * HEIGHT / BASE)
    assert found.travel[0, k] == pytest.approx(expected, abs=1e-5)
    assert np.sign(expected) == np.sign(torque)


def test_squat_ends_at_travel_stop():
    low = replace(TRUCK.suspension, jounce_deflection=190 * mm)
    of = asked(replace(TRUCK, suspension=low))
    k, j = (of.states.index(name) for name in ("gvw", "jounce"))
    found = demand_with_axle_moved_by_torque(
        of, torque=np.full((1, len(of.states)), 5410.0), speed=0.0
    )
    assert found.travel[0, k] == pytest.approx(of.travel[j], abs=1e-12)
    assert found.travel[0, j] == of.travel[j]


def test_state_placed_by_hand_squats_like_repeated_state():
    """Pitch that is given ends wind-up alone; a height that is given is where it stands at rest."""
    again = [VehicleState(name="there", kind="gvw", travel=0.0),
             VehicleState(name="pitched", kind="gvw", pitch=0.0)]  # fmt: skip
    of = asked(replace(TRUCK, states=(*TRUCK.states, *again)))
    found = demand_with_axle_moved_by_torque(
        of, torque=np.full((1, len(of.states)), 5410.25), speed=0.0
    )
    k, there, pitched = (of.states.index(n) for n in ("gvw", "there", "pitched"))
    assert found.travel[0, k] > 40 * mm
    assert found.travel[0, [there, pitched]] == pytest.approx(found.travel[0, k], rel=1e-12)
    assert found.pitch[0, there] == pytest.approx(found.pitch[0, k], rel=1e-12)
    assert found.pitch[0, pitched] == pytest.approx(0.0, abs=1e-15)


def test_state_without_geometry_squats_like_reference():
    """A file without states too: the reference, here gvw. One laid by hand is told to stay."""
    of = asked(
        replace(
            TRUCK,
            states=(
                VehicleState(name="gvw", kind="gvw"),
                VehicleState(name="as given"),
                VehicleState(name="laden", load="gvw"),
            ),
        )
    )
    found = demand_with_axle_moved_by_torque(of, torque=np.full((1, 3), 5410.25), speed=0.0)
    assert found.travel[0, 0] > 40 * mm
    assert found.travel[0] == pytest.approx(np.full(3, found.travel[0, 0]), rel=1e-12)
    # Light in the same place it has less to carry and stops at the same stop.
    low = replace(TRUCK.suspension, jounce_deflection=190 * mm)
    of = asked(
        replace(TRUCK, suspension=low, states=(*TRUCK.states, VehicleState(name="l", load="empty")))
    )
    found = demand_with_axle_moved_by_torque(
        of, torque=np.full((1, len(of.states)), 5410.25), speed=0.0
    )
    stop = of.travel[of.states.index("jounce")]
    assert 0 < found.travel[0, -1] <= stop
    held = TRUCK.lines[0].layout
    laid = VehicleState(name="measured", layouts={"main": held})
    application = replace(TRUCK, states=(VehicleState(name="gvw", kind="gvw"), laid))
    of = asked(application)
    found = demand_with_axle_moved_by_torque(of, torque=np.full((1, 2), 5410.25), speed=0.0)
    assert found.travel[0, 1] == of.travel[1] == 0.0
    said = [str(n) for n in approval_notes(application, [compute_line_response(application, of)])]
    assert sum("runs in measured as these say, whatever its torque" in n for n in said) == 1


def test_axle_at_stop_in_reference_does_not_squat():
    hung = replace(TRUCK.suspension, reference="full rebound")
    of = asked(replace(TRUCK, suspension=hung, states=(VehicleState(name="as given"),)))
    found = demand_with_axle_moved_by_torque(of, torque=np.full((1, 1), 3000.0), speed=0.0)
    assert found.travel[0, 0] == of.travel[0]


def test_spring_rates_without_stop_give_warning():
    """At 171 mm it stands past the 160 of its two points: squat was nothing, 1287 N for 2165."""
    assert TRUCK.suspension.spring.deflection[-1] == pytest.approx(160 * mm)
    open_ = replace(TRUCK.suspension, jounce_deflection=None)
    riding = tuple(s for s in TRUCK.states if s.kind != "jounce")
    application = replace(TRUCK, suspension=open_, states=riding)
    of, stopped = asked(application), asked(replace(TRUCK, states=riding))
    k = of.states.index("gvw")
    for each in (of, stopped):
        found = demand_with_axle_moved_by_torque(
            each, torque=np.full((1, len(riding)), 5410.25), speed=0.0
        )
        assert found.travel[0, k] == pytest.approx(47.15 * mm, abs=0.01 * mm)
    said = [str(n) for n in approval_notes(application, [compute_line_response(application, of)])]
    assert sum("nothing stops the axle of line main as it rises" in n for n in said) == 1
    with pytest.raises(DesignError, match="state `jounce` needs `jounce_deflection`"):
        asked(replace(TRUCK, suspension=open_))


def test_spring_table_ending_below_load_gives_no_stop():
    """And is wondered at; one that ends above it is metal to metal there."""
    text = (EXAMPLES / "medium-truck-4x2.yaml").read_text("utf-8")
    riding = "states: [gvw]\n"
    text = re.sub(r"(?m)^states:\n(?:  .*\n)+", riding, text)
    text = re.sub(r"  jounce_deflection_mm: .*\n", "", text)
    rates = re.search(r"    rates_N_mm: .*\n    contact_mm: .*\n", text)
    found = {}
    for end in (160, 175, 218.2):
        load = 13200 + 235 * (end - 80)
        table = f"    load_N: [0, 13200, {load}]\n    deflection_mm: [0, 80, {end}]\n"
        of = asked(reader.loads(text.replace(rates[0], table)))
        under = demand_with_axle_moved_by_torque(of, torque=np.full((1, 1), 5410.25), speed=0.0)
        found[end] = float(under.travel[0, 0]) / mm
    assert found[160] == pytest.approx(47.15, abs=0.01)
    assert found[175] == pytest.approx(175 - 170.93, abs=0.1)
    assert found[218.2] == pytest.approx(47.15, abs=0.01)


@pytest.mark.parametrize("kind", ["jounce", "full rebound"])
def test_squat_of_hand_placed_state_ends_at_stops(kind):
    """Two millimetres from the bump stop, and from the strap."""
    of = asked()
    stop, up = of.travel[of.states.index(kind)], 1 if kind == "jounce" else -1
    placed = VehicleState(name="t", kind="gvw", travel=float(stop - up * 2 * mm))
    of = asked(replace(TRUCK, states=(*TRUCK.states, placed)))
    found = demand_with_axle_moved_by_torque(
        of, torque=np.full((1, len(of.states)), up * 5410.25), speed=0.0
    )
    assert found.travel[0, -1] == pytest.approx(stop, abs=1e-12)


def test_axle_without_strap_hangs_on_springs():
    """A heavy axle pulls them further than the inch below free of the state `rebound`."""
    heavy = replace(TRUCK.suspension, full_rebound_deflection=None, unsprung_mass=2000.0)
    found = squat_travel(
        heavy, -0.19, axle_load=REAR, drawn=-2 * REAR, force=0, torque=0, stands=-0.01
    )
    assert float(found) == pytest.approx(0.01 - 2000 * g / 2 / 165e3, abs=1e-12)


def test_squat_on_grade_uses_load_normal_to_road():
    """The transfer, less what the grade's cosine takes off the axle: 38.7 mm for 47.2."""
    steep = replace(TRUCK, vehicle=replace(TRUCK.vehicle, grade=float(np.arctan(0.3))))
    of = asked(steep)
    k = of.states.index("gvw")
    found = demand_with_axle_moved_by_torque(
        of, torque=np.full((1, len(of.states)), 5410.25), speed=0.0
    )
    force = 5410.25 * 3.91 * 0.95 / RADIUS
    moved = force * HEIGHT / BASE - REAR * (1 - np.cos(np.arctan(0.3)))
    assert found.travel[0, k] == pytest.approx(rise(TRUCK.suspension, REAR, force, moved), abs=1e-5)
    assert found.travel[0, k] == pytest.approx(38.7 * mm, abs=0.1 * mm)


def test_both_axles_of_4x4_squat_by_total_traction():
    """The engine's 1637.8 N m, shared 0.6 to 0.4: 17.1 kN push, of which the front slips at none.

    The front holds mu N, which shrinks by what all wheels push: F/s h/L where it pushes s of it.
    So it is with the rear where it holds back.
    """
    pick_up = reader.read(EXAMPLES / "pick-up-4x4.yaml")
    torque, base, height = 400 * 4.31 * 0.95, 3.2, 0.76
    push = torque * 3.91 * 0.96 / 0.36
    for line, share, load, way in zip(
        pick_up.lines, (0.6, 0.4), (1750 * g, 1250 * g), (1, -1), strict=True
    ):
        of = line_state_demand(resolve_line_references(pick_up, line))
        k = of.states.index("windup")
        assert of.torque[k] == pytest.approx(share * torque, rel=1e-12)
        springs = line.suspension or pick_up.suspension
        moved = way * push * height / base
        expected = rise(springs, load, share * push, moved, radius=0.36, ahead=way)
        assert of.travel[k] == pytest.approx(expected, abs=1e-5)
    lever = 0.9 * height / base
    front, rear = (
        0.9 * load / (1 + lever / share) * 0.36 / 3.91
        for load, share in ((1250 * g, 0.4), (1750 * g, 0.6))
    )
    assert of.slip_torque[k] == pytest.approx(front / 0.96, rel=1e-12)
    back = line_state_demand(
        resolve_line_references(pick_up, pick_up.lines[0])
    ).static_state.slip_torque_coast
    assert back[k] == pytest.approx(rear * 0.96, rel=1e-12)


@pytest.mark.parametrize(
    "held",
    [
        {"suspension": replace(TRUCK.suspension, squats=False)},
        {"tyre": None},
        {"vehicle": replace(
            TRUCK.vehicle,
            loads=tuple(replace(load, cg_height=None) for load in TRUCK.vehicle.loads),
        )},
    ],
    ids=["left out", "no tyre", "no height"],
)  # fmt: skip
def test_squat_is_zero_if_data_missing_or_disabled(held):
    of = asked(replace(TRUCK, **held))
    found = demand_with_axle_moved_by_torque(
        of, torque=np.full((1, len(of.states)), 3000.0), speed=0.0
    )
    np.testing.assert_array_equal(found.travel[0], of.travel)
    application = replace(TRUCK, **held)
    unsaid = map(str, approval_notes(application, [compute_line_response(application, of)]))
    told = [n for n in unsaid if "is not moved on its springs" in n]
    assert len(told) == (0 if "suspension" in held else 1)


def test_squat_can_be_disabled_in_file():
    text = (EXAMPLES / "medium-truck-4x2.yaml").read_text("utf-8")
    at = "  windup_stiffness_kNm_deg:"
    of = asked(reader.loads(text.replace(at, "  squat: false\n" + at, 1)))
    assert not of.static_state.squats.any()
    wound = of.states.index("windup")
    assert of.travel[wound] == 0.0
    assert of.pitch[wound] / deg == pytest.approx(5410.25 * 3.91 * 0.95 / 12e3, rel=1e-9)


def test_force_of_state_is_independent_of_other_states():
    """Unbalance is that of shafts balanced for the line's top speed, whatever is listed.

    The ends of the suspension's stroke stay: where they are unknown a spline holds its whole
    slip force.
    """
    kept = {"windup", "full rebound", "jounce"}
    alone = replace(TRUCK, states=tuple(s for s in TRUCK.states if s.name in kept))
    assert len(TRUCK.states) > len(alone.states) == len(kept)
    among, by_itself = (compute_line_response(a, asked(a)) for a in (TRUCK, alone))
    k = among.demand.states.index("windup")
    force = (
        among.mount_loads.bearing_force("peak")[k],
        by_itself.mount_loads.bearing_force("peak")[by_itself.demand.states.index("windup")],
    )
    assert force[0] == pytest.approx(force[1], rel=1e-6)


def test_shafts_are_balanced_for_speed_of_own_line():
    """Half of what turns at the gearbox, behind a transfer case that halves it."""
    (installed,) = TRUCK.lines
    slow = replace(TRUCK, speed=400.0, lines=(replace(installed, speed_ratio=0.5),))
    assert compute_line_response(slow, asked(slow)).inputs.balancing_speed == pytest.approx(200.0)


def test_launch_includes_squat_at_each_instant():
    """Torque that comes and stays: what an operating point there carries, the axle squatting.

    A launch goes through no stroke: the spline's thrust is that of the state's own place.
    """
    r = compute_line_response(TRUCK, asked())
    k, torque, speed = r.demand.states.index("gvw"), 5410.25, 15.0
    there = demand_with_axle_moved_by_torque(
        r.demand, torque=np.full((1, len(r.demand.states)), torque), speed=speed
    )
    stroke = r.mounts.stroke_thrust
    where_it_stands = replace(
        stroke,
        force=stroke.own_force,
        compression=np.broadcast_to(stroke.own_compression[..., None], stroke.compression.shape),
    )
    point = bearing_forces(
        r.layout_for(there), r.line, r.phases, held=r.mounts.mounted_line,
        thrust=where_it_stands.effect(there.torque, r.inputs.spline_force_at(there.torque)),
        **r.mounts.force_inputs(there, inertia=False),
    ).peak[0, k]  # fmt: skip
    time = np.linspace(0, 0.1, 50)
    comes = torque * np.minimum(time / 0.08, 1)
    drive = TorqueSpeedTimeHistory(
        time=time, input_angle=speed * time, torque=comes, speed=0 * time + speed
    )
    steady, _ = bearing_forces_over_time_history(r.mounts, drive, state=k)
    np.testing.assert_allclose(steady[-1], point, rtol=0.01)
    same = TorqueSpeedTimeHistory(
        time=time, input_angle=speed * time, torque=comes[-1:] + 0 * time, speed=drive.speed
    )
    steady, _ = bearing_forces_over_time_history(r.mounts, same, state=k)
    np.testing.assert_allclose(steady[-1], point, rtol=0.01)
    small = TorqueSpeedTimeHistory(
        time=time, input_angle=speed * time, torque=0 * time + 1, speed=0 * time + speed
    )
    weight, _ = bearing_forces_over_time_history(
        r.mounts, small, state=k
    )  # and no thrust of another torque
    assert weight[-1] < 0.2 * point


def test_squat_of_articulated_bogie_ends_at_bump_stop():
    """A kerb takes 40 of the 42.8 mm that are left: first gear took it 38 mm past the stop."""
    tandem = reader.read(EXAMPLES / "tandem-6x4.yaml")
    of = asked(tandem)
    k = of.states.index("bogie crossed")
    stop = of.travel[of.states.index("jounce")]
    found = demand_with_axle_moved_by_torque(
        of, torque=np.full((1, len(of.states)), 14_550.0), speed=0.0
    )
    assert of.travel[k] == pytest.approx(40 * mm)
    assert found.travel[0, k] == pytest.approx(stop, abs=1e-9)
    placed = replace(
        tandem, states=(*tandem.states, VehicleState(name="t", kind="gvw", travel=40 * mm))
    )
    again = asked(placed)
    there = demand_with_axle_moved_by_torque(
        again, torque=np.full((1, len(again.states)), 14_550.0), speed=0.0
    )
    assert there.travel[0, -1] == pytest.approx(found.travel[0, k], abs=1e-9)
