"""Squat: what the tyres pull moves an axle on its springs; held against the least of its energy.

The oracle minimises the potential of springs, load and tyre force over the axle's rise (scipy),
where the program iterates a balance of forces.
"""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.optimize import minimize_scalar

from cardan import files
from cardan.base.units import deg, g, mm
from cardan.demand.states import demand, demand_under, resolve
from cardan.demand.suspension import axle_path, spring_load
from cardan.quantity.response import respond

EXAMPLES = Path(__file__).parents[2] / "examples"
TRUCK = files.read(EXAMPLES / "medium-truck-4x2.yaml")
MU, RADIUS, HEIGHT, BASE = 0.8, 0.405, 1.35, 3.69
REAR, ALL = 7700 * g, 12000 * g


def asked(application=TRUCK):
    return demand(resolve(application, application.lines[0]))


def rise(suspension, load, force, moved):
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
            spring - (suspension.springs_per_axle * own + moved) * z + force * (dx - RADIUS * pitch)
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
def test_every_way_of_pulling_is_where_no_work_is_left(torque, coasts, brakes):
    """Drive, coast, reverse and brakes; load moves by F h/L of what all tyres pull."""
    of = asked()
    k = of.states.index("gvw")
    found = demand_under(
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


def test_it_stops_where_travel_ends():
    low = replace(TRUCK.suspension, jounce_deflection=190 * mm)
    of = asked(replace(TRUCK, suspension=low))
    k, j = (of.states.index(name) for name in ("gvw", "jounce"))
    found = demand_under(of, torque=np.full((1, len(of.states)), 5410.0), speed=0.0)
    assert found.travel[0, k] == pytest.approx(of.travel[j], abs=1e-12)
    assert found.travel[0, j] == of.travel[j]


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
def test_where_nobody_knows_or_asks_it_stays(held):
    of = asked(replace(TRUCK, **held))
    found = demand_under(of, torque=np.full((1, len(of.states)), 3000.0), speed=0.0)
    np.testing.assert_array_equal(found.travel[0], of.travel)


def test_a_file_may_leave_it_out():
    text = (EXAMPLES / "medium-truck-4x2.yaml").read_text("utf-8")
    at = "  windup_stiffness_kNm_deg:"
    of = asked(files.loads(text.replace(at, "  squat: false\n" + at, 1)))
    assert not of.standing.squats.any()
    wound = of.states.index("windup")
    assert of.travel[wound] == 0.0
    assert of.pitch[wound] / deg == pytest.approx(5410.25 * 3.91 * 0.95 / 12e3, rel=1e-9)


def test_a_states_force_depends_on_no_other_state():
    """Unbalance is that of shafts balanced for the line's top speed, whatever is listed."""
    alone = replace(TRUCK, states=tuple(s for s in TRUCK.states if s.name == "windup"))
    among, by_itself = (respond(a, asked(a)) for a in (TRUCK, alone))
    k = among.demand.states.index("windup")
    force = among.bearing_force("peak")[k], by_itself.bearing_force("peak")[0]
    assert force[0] == pytest.approx(force[1], rel=1e-6)
