"""Thrust of the spline on a line that gives: METHOD section 20's line, and one that bends anew.

The refuse collector's line: straight, and with the kinks it has loaded (`gvw`). METHOD's figures
are a multibody engine's with exact joints. Here the matrices are those where the line lies: what
that leaves out is asked of Newton's method on the bent line.
"""

import numpy as np
import pytest
from repository import EXAMPLES
from scipy.linalg import eigh
from scipy.optimize import fsolve

from cardan.application import reader
from cardan.checks.line_response import compute_line_response
from cardan.model.layout import Layout, layout_from_points
from cardan.physics.loads.centre_bearing import loads_of_turning_line
from cardan.physics.loads.mounted_line_model import mounted_line
from cardan.physics.loads.spline_thrust import compressed_line, stroke_compression
from cardan.physics.loads.statics import bearing_forces_of_weight_and_thrust
from cardan.physics.vehicle.state_demand import (
    demand_at_axle_motion,
    line_state_demand,
    resolve_line_references,
)
from cardan.physics.vehicle.static_state import housing_torque

STIFFNESS = [200e3, 120e3, 0.0]
TORQUE, RADIUS = 7339.32, 0.032
APPLICATION = reader.read(EXAMPLES / "refuse-collector-6x2.yaml")
DEMAND = line_state_demand(resolve_line_references(APPLICATION, APPLICATION.lines[0]))
RESPONSE = compute_line_response(APPLICATION, DEMAND)
LINE, GVW = RESPONSE.line, RESPONSE.layout[2]
STRAIGHT = layout_from_points(
    np.cumsum([[0, 0, 0], [1.0006, 0, 0], [1.0023, 0, 0], [1.3513, 0, 0]], axis=0),
    gearbox=[1, 0, 0],
    pinion=[1, 0, 0],
)


def compressed(layout, torque=0.0, sines=0):
    """Return how a line can move, and as it is compressed; with its moments where it has torque."""
    held = mounted_line(layout, LINE, stiffness=STIFFNESS, sines=sines)
    T = np.broadcast_to(float(torque), layout.points.shape[:-2])
    _, carried = loads_of_turning_line(layout, LINE, RESPONSE.phases, torque=T, speed=0 * T)
    push = held.forces_from_joint_moments(carried.joint_moments.order(0)).real
    along = held.spline_gradient(layout.directions[..., -2, :])
    return held, compressed_line(held, forces=push, spline=along, torque=T)


def carried_forces(held, of, P):
    return np.linalg.norm(held.motion(of.coordinates(P)).bearing_forces.real, axis=-1)


def test_critical_compression_of_straight_line_matches_method():
    """Printed to four digits: 25.40 kN lateral, 42.33 vertical."""
    held, of = compressed(STRAIGHT)
    assert of.critical == pytest.approx(25.40e3, abs=5)
    vertical = eigh(held.stiffness_under_torque(0.0), held.geometric, eigvals_only=True)[1]
    assert vertical == pytest.approx(42.33e3, abs=5)


@pytest.mark.parametrize(
    ("P", "forces", "frequencies", "within"),
    [
        (0.0, (0.0, 0.0), (8.001, 9.367, 10.333, 12.086), 1e-3),
        (9.175e3, (567.3, 641.3), (6.498, 8.865, 9.251, 11.675), 1e-3),
        (18.35e3, (1851.5, 1969.7), (4.322, 7.925, 8.439, 11.321), 3e-3),
        (-18.35e3, (578.2, 730.0), (9.509, 11.104, 11.744, 13.299), 1e-3),
    ],
)
def test_forces_and_modes_under_thrust_match_engine(P, forces, frequencies, within):
    """METHOD's table; where 0.72 of the critical compression bends the line, to 0.3 %."""
    held, of = compressed(GVW)
    assert carried_forces(held, of, P) == pytest.approx(np.array(forces), rel=within, abs=0.1)
    K = held.stiffness_under_torque(0.0) - P * held.geometric
    found = np.sqrt(eigh(K, held.mass, eigvals_only=True)) / (2 * np.pi)
    assert found == pytest.approx(np.array(frequencies), rel=max(within, 2e-4))


def bent_equilibrium(P):
    """Return the forces on the bearings of a line that is bent anew, without torque, N.

    Exact lengths: the two joints' offsets are unknown, hung shafts keep their lengths, and what
    the spline shortens by does the work of P.
    """
    points, L = GVW.points, GVW.lengths
    steps = np.diff(points, axis=0)[:2]
    across = [np.linalg.svd(step[None])[2][1:] for step in steps]
    held = mounted_line(GVW, LINE, stiffness=STIFFNESS, sines=0)
    frames = held.bearing_frame

    def joints(x):
        at, hung = [points[0]], []
        for k in range(2):
            offset = x[2 * k : 2 * k + 2] @ across[k]
            along = steps[k] / L[k]
            d = along * np.sqrt(1 - offset @ offset / L[k] ** 2) + offset / L[k]
            hung.append(at[-1] + (L[k] - 0.15) * d)
            at.append(at[-1] + L[k] * d)
        return at, hung

    start = joints(np.zeros(4))[1]

    def gone(x):
        return np.array([h - s for h, s in zip(joints(x)[1], start, strict=True)])

    def energy(x):
        u = np.einsum("bij,bj->bi", frames, gone(x))
        at, _ = joints(x)
        return (u**2 @ np.array(STIFFNESS)).sum() / 2 - P * np.linalg.norm(points[3] - at[2])

    def slope(x, h=1e-6):
        return [(energy(x + h * e) - energy(x - h * e)) / (2 * h) for e in np.eye(4)]

    x = fsolve(slope, np.zeros(4), xtol=1e-8)
    u = np.einsum("bij,bj->bi", frames, gone(x))
    return np.linalg.norm(u * np.array(STIFFNESS), axis=-1)


@pytest.mark.parametrize(("P", "engine"), [(9.175e3, (567.3, 641.3)), (18.35e3, (1851.5, 1969.7))])
def test_line_bent_anew_confirms_engine_and_bounds_linear_matrices(P, engine):
    exact = bent_equilibrium(P)
    assert exact == pytest.approx(np.array(engine), abs=0.3)
    held, of = compressed(GVW)
    assert carried_forces(held, of, P) == pytest.approx(exact, rel=4e-3)


def at_travels(travels, torque=TORQUE):
    """Return where the line runs with its axle at travels from `gvw`, m, under a torque."""
    standing, S = DEMAND.static_state, len(DEMAND.states)
    T = np.full(S, torque)
    on_axle = housing_torque(
        standing.line, T, braked=standing.loads.braked, coasts=False, brakes=False
    )
    each = []
    for z in travels:
        ride = standing.axle_motion_at(on_axle, np.full(S, z))
        there = demand_at_axle_motion(DEMAND, ride, torque=T, speed=0 * T)
        each.append(there.layout[2])
    return Layout(
        points=np.stack([o.points for o in each]), directions=np.stack([o.directions for o in each])
    )


LOADED = 0.035
"""m: how far the loaded axle rises under full torque in first gear, where its springs stop it."""


def over_stroke(lowest, friction, *, rest=None):
    """Return the largest force on bearing 2 and the compressions over a stroke, N."""
    laid = at_travels(np.linspace(lowest, LOADED, 41))
    held, of = compressed(laid, TORQUE)
    length = laid.lengths[..., -1]
    found = stroke_compression(
        of,
        length=length,
        rest_length=length[-1:] if rest is None else np.array([rest]),
        slip=TORQUE * friction / RADIUS,
    )
    weight, pulled = bearing_forces_of_weight_and_thrust(laid, LINE, gravity=9.80665)
    _, carried = loads_of_turning_line(
        laid, LINE, RESPONSE.phases, torque=np.full(41, TORQUE), speed=np.zeros(41)
    )
    push = held.forces_from_joint_moments(carried.joint_moments.order(0)).real
    along = held.spline_gradient(laid.directions[..., -2, :])

    def force(P):
        moved = held.motion(of.coordinates(P)).bearing_forces
        statics = held.static_bearing_forces((push + P[:, None] * along).astype(complex))
        each = carried.bearing_forces.order(0) + moved - statics
        return np.linalg.norm(each.real + weight - P[:, None, None] * pulled, axis=-1)[:, 1]

    return force(found.pushed).max(), found, force(found.drawn)


@pytest.mark.parametrize(
    ("lowest", "friction", "force", "within"),
    [
        (LOADED - 0.040, 0.08, 1580, 0.005),
        (LOADED - 0.040, 0.11, 1580, 0.005),
        (LOADED - 0.080, 0.08, 2343, 0.01),
        (LOADED - 0.145, 0.08, 2795, 0.005),
        (LOADED - 0.145, 0.11, 4903, 0.005),
    ],
)
def test_force_over_stroke_matches_method(lowest, friction, force, within):
    """METHOD's collector; its 2795 and 4903 N are where the axle is 145 mm below the loaded one."""
    found, _, _ = over_stroke(lowest, friction)
    assert found == pytest.approx(force, rel=within)


def test_stroke_of_40_mm_reaches_12_kn_and_never_slides():
    """12.2 kN for 0.84 mm of shortening, whatever the friction."""
    _, found, _ = over_stroke(LOADED - 0.040, 0.08)
    assert found.pushed.max() == pytest.approx(12.2e3, rel=0.01)
    assert found.shortening == pytest.approx(0.84e-3, rel=0.01)


@pytest.mark.parametrize(("friction", "force"), [(0.08, 921), (0.11, 1268)])
def test_launch_draws_spline_out(friction, force):
    """From rest the launch draws it out by 1.27 mm: it slides, and holds its slip force."""
    rest = GVW.lengths[-1]
    assert at_travels([LOADED]).lengths[0, -1] - rest == pytest.approx(1.27e-3, rel=0.01)
    _, found, forces = over_stroke(LOADED - 1e-6, friction, rest=rest)
    assert found.drawn[-1] == pytest.approx(-TORQUE * friction / RADIUS)
    assert forces[-1] == pytest.approx(force, rel=0.015)


def test_shortening_that_a_dead_load_needs_matches_method():
    """0.86 mm for 9.2 kN, 2.90 for 18.35 kN; 15 kN/mm at first, 2.6 at the end."""
    _, of = compressed(at_travels([LOADED]), TORQUE)
    for P, needed in ((9.175e3, 0.86e-3), (18.35e3, 2.90e-3)):
        assert of.lengthening(P) - of.lengthening(0.0) == pytest.approx(needed, rel=0.01)
    assert of.spline_stiffness(0.0) == pytest.approx(15e6, rel=0.02)
    assert of.spline_stiffness(18.35e3) == pytest.approx(2.6e6, rel=0.02)


def test_held_spline_keeps_its_length_below_critical_compression():
    """The found compression has the length that was asked, whatever it is, and never buckles."""
    _, of = compressed(at_travels([LOADED]), TORQUE)
    for asked in np.linspace(-1e-3, 30e-3, 32):
        P = of.compression_at_lengthening(asked, least=-1e6, most=of.critical * (1 - 1e-9))
        assert of.critical > P
        assert of.lengthening(P) == pytest.approx(asked, abs=1e-9)


def test_friction_limits_compression_both_ways():
    _, of = compressed(at_travels([LOADED]), TORQUE)
    far = np.array([-1.0, 1.0])
    found = of.compression_at_lengthening(far, least=-5e3, most=5e3)
    assert found == pytest.approx([-5e3, 5e3])


def test_batch_of_layouts_equals_single_ones():
    laid = at_travels([-0.1, 0.0, LOADED])
    _, batch = compressed(laid, TORQUE)
    for k in range(3):
        _, one = compressed(laid[k], TORQUE)
        assert batch.critical[k] == pytest.approx(one.critical)
        assert batch.lengthening(1e4)[k] == pytest.approx(one.lengthening(1e4))
