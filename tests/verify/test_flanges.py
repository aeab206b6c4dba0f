"""Flanges that give, under the first joint and the last: rods on springs, beams, limits, work.

The rods are those of anybody's first course: a straight line of uniform rods, each hinged to
the next, with its mass matrix m/6 [[2, 1], [1, 2]] in the motion of its ends. The beams are
those of `cardan.physics.strength.beams`. An engine has them too (`test_rubber_engine.py`).
"""

from dataclasses import replace

import numpy as np
import pytest
from test_rubber import BENT, RUBBER, THREE, TWO, laid, of

from cardan.model.parts import Flange
from cardan.physics.kinematics.joint_chain import rotate_chain
from cardan.physics.loads.centre_bearing import bearing_forces, joint_forces
from cardan.physics.loads.half_turn_fourier import semi_major_axis
from cardan.physics.loads.mounted_line_model import mounted_line
from cardan.physics.strength.beams import assemble_beams, beam_model
from cardan.physics.strength.critical_speed import bearing_resonance_speed, synchronous_whirl_modes

TAIL = Flange(stiffness=(0.9e6, 0.5e6), loss_factor=0.06, mass=18.0)
AXLE = Flange(stiffness=(1.2e6, 2.0e6), loss_factor=0.04, mass=40.0)
SOFT = replace(THREE, gearbox_flange=TAIL, pinion_flange=AXLE)
STRAIGHT = {"side": [0.0] * 5, "top": [0.0] * 5}


def both(line, where, **asked):
    """What bearings carry, and what joints do."""
    held, cut = (mounted_line(where, line, stiffness=RUBBER, cut=c) for c in (False, True))
    bearings = bearing_forces(where, line, line.phases, held=held, **asked)
    asked.pop("slip", None)  # thrust is no part of what a joint is given here
    return bearings, joint_forces(where, line, line.phases, held=held, cut=cut, **asked)


def firm(k: float):
    return replace(
        THREE, gearbox_flange=Flange(stiffness=(k, k)), pinion_flange=Flange(stiffness=(k, k))
    )


@pytest.mark.parametrize("speed", [20.0, 45.0, 90.0])
def test_rigid_flanges_equal_no_flanges(speed):
    where = laid(THREE, **BENT)
    asked = {"torque": 3e3, "speed": speed, "gravity": 9.81, "slip": 400.0, "balanced_at": 200.0}
    rigid, stiff, soft = (both(line, where, **asked) for line in (THREE, firm(1e15), SOFT))
    for none, much, some in zip(rigid, stiff, soft, strict=True):
        for name in ("waves", "mean", "order1"):
            a, b, c = (getattr(of_, name) for of_ in (none, much, some))
            assert np.abs(a - b).max() < 1e-9 * np.abs(a).max()
            assert np.abs(a - c).max() > 1e-5 * np.abs(a).max()


def test_quasi_static_loads_match_statics():
    """As many supports as joints: how they give changes no force of a line that stands still."""
    where, torque = laid(THREE, **BENT), 1e-9
    bearings, joints = both(SOFT, where, torque=torque, speed=0.0)
    still = of(THREE, where, torque=torque)
    for found, carried in ((bearings, still.bearing_forces), (joints, still.joint_forces)):
        size = np.abs(carried.order(2)).max()
        assert np.abs(found.waves[..., 0, :] - carried.order(2)).max() < 1e-12 * size
        assert np.abs(found.mean - carried.static).max() < 1e-12 * size


def test_spring_force_is_joint_force_plus_inertia_of_mass():
    where, torque, speed = laid(THREE, **BENT), 3e3, 61.0
    held, cut = (mounted_line(where, SOFT, stiffness=RUBBER, cut=c) for c in (False, True))
    joints = joint_forces(
        where, SOFT, SOFT.phases, torque=torque, speed=speed, held=held, cut=cut
    ).waves[:, 0]
    moments = of(THREE, where, torque=torque).joint_moments
    swing = held.order2_coupling(
        rotate_chain(
            where.directions, phases=SOFT.phases_under_torque(SOFT.phases, torque), samples=16
        )
    )
    _, second, _ = held.harmonic_balance(
        [held.forces_from_joint_moments(moments.order(k)) for k in (0, 2, 4)],
        swing,
        speed=speed,
        torque=torque,
    )
    moved = second.coordinates[-4:].reshape(2, 2)
    W = 2 * speed
    for k, (flange, end) in enumerate(((TAIL, 0), (AXLE, -1))):
        d = where.directions[end]
        level = np.cross([0, 0, 1.0], d) / np.linalg.norm(np.cross([0, 0, 1.0], d))
        across = np.stack([np.cross(d, level), level])
        spring = np.array(flange.stiffness) * (1 + 1j * flange.loss_factor) - W**2 * flange.mass
        pushed = across @ joints[end] * (-1 if end == 0 else 1)
        assert pushed == pytest.approx(spring * moved[k], rel=1e-9)


def test_straight_rods_on_springs_match_closed_form():
    """Ends up and down: M of rods, K of three springs; the bearing sits on joint 2."""
    line = replace(TWO, gearbox_flange=TAIL, pinion_flange=AXLE)
    where = laid(line, side=[0.0] * 4, top=[0.0] * 4)
    held = mounted_line(where, line, stiffness=RUBBER, sines=0)
    rod = np.array([[2, 1], [1, 2]]) / 6
    M = np.diag([TAIL.mass, 0, AXLE.mass])
    M[:2, :2] += 20 * rod
    M[1:, 1:] += 25 * rod
    for way in (0, 1):
        K = np.diag([TAIL.stiffness[way], RUBBER[way], AXLE.stiffness[way]])
        eta = np.diag([TAIL.loss_factor, 0.1, AXLE.loss_factor])
        for W in (30.0, 90.0, 240.0):
            # A couple C on each shaft: C / L at its ends.
            couples = np.array([70.0, -40.0])
            f = np.array([[-1 / 1.2, 0], [1 / 1.2, -1 / 1.5], [0, 1 / 1.5]]) @ couples
            x = np.linalg.solve(K * (1 + 1j * eta) - W**2 * M, f)
            # Ours: joint 2 against joint 1, then the flanges, up and level.
            push = np.zeros(6)
            push[[way, 2 + way, 4 + way]] = f[1], f[0] + f[1], f[2]
            found = held.response(push, frequency=W)
            y1, y2, y3 = found.coordinates[[2 + way, way, 4 + way]]
            # Rods of 1 mm have no inertia about a diameter to speak of.
            assert np.array([y1, y1 + y2, y3]) == pytest.approx(x, rel=1e-6)
            carried = np.abs(RUBBER[way] * (1 + 0.1j) * x[1])
            assert np.linalg.norm(found.bearing_forces) == pytest.approx(carried, rel=1e-6)


def test_modes_match_beam_model():
    beams = beam_model(SOFT)
    beams = type(beams)(
        **{name: getattr(beams, name) for name in beams.__slots__}
        | {"bearing_stiffness": np.array([RUBBER[:2]] * 2)}
    )
    inverse = np.linalg.eigvalsh(assemble_beams(beams, 8).flexibility)[:, -6:]
    expected = np.sort((inverse**-0.5).ravel())[:8]
    modes = mounted_line(laid(SOFT, **STRAIGHT), SOFT, stiffness=RUBBER).modes()
    assert modes.frequency[:8] == pytest.approx(expected, rel=4e-3)
    assert modes.mode_names()[4:8] == ["flange"] * 4
    assert (modes.damping_ratio[4:8] < 0.05).all()


def test_whirl_analysis_includes_flanges():
    """A tail as soft as rubber bounces on it; a firm one is none."""
    lines = [replace(THREE, gearbox_flange=f) for f in (
        Flange(), Flange(stiffness=(1e15, 1e15)), Flange(stiffness=(2e5, 2e5), mass=60.0),
    )]  # fmt: skip
    none, stiff, soft = (synchronous_whirl_modes(beam_model(line)) for line in lines)
    assert stiff.frequency[:6] == pytest.approx(none.frequency[:6], rel=1e-9)
    # The mass alone on its spring, and what of the first shaft rides there.
    assert bearing_resonance_speed(soft) < np.sqrt(2e5 / 60.0) < bearing_resonance_speed(none)


def test_dissipated_power_equals_power_of_moments():
    where = laid(SOFT, **BENT)
    on = mounted_line(where, SOFT, stiffness=RUBBER)
    push = on.forces_from_joint_moments(of(SOFT, where).joint_moments.order(2))
    speeds = np.array([30.0, 45.0, 80.0])
    found = on.response(push, frequency=2 * speeds, speed=speeds, torque=5e3)
    fed = np.imag((np.conj(found.coordinates) * push).sum(-1))
    across = on.bearing @ found.coordinates[..., None, :, None]
    lost = 0.1 * (np.array(RUBBER) * np.abs(across[..., 0]) ** 2).sum((-2, -1))
    ends = np.abs(found.coordinates[:, -4:]) ** 2
    lost += ends @ np.array([f.loss_factor * k for f in (TAIL, AXLE) for k in f.stiffness])
    assert fed == pytest.approx(lost, rel=1e-9)


def test_joint_forces_increase_at_resonance():
    """Through a mode, a joint beside a bearing carries what the shaft's swing asks of it."""
    where = laid(THREE, **BENT)
    speeds = np.linspace(20.0, 60.0, 81)
    bearings, joints = both(THREE, where, torque=np.full(81, 3e3), speed=speeds)
    rigid = semi_major_axis(of(THREE, where, torque=3e3).joint_forces.order(2))
    assert (joints.order_amplitudes[..., 0].max(0) > [1.5, 4, 10, 5] * rigid).all()
    assert abs(joints.dynamic[:, 1].argmax() - bearings.dynamic[:, 0].argmax()) <= 8


def test_moving_axle_carries_and_rotates_last_tube():
    """A rod of 25 kg bent off the pinion: all of it along itself, a third across."""
    line = replace(TWO, pinion_flange=AXLE)
    where = laid(line, side=[0.0, 0.0, 12.0, 0.0], top=[0.0] * 4)
    M = mounted_line(where, line, stiffness=RUBBER, sines=0).mass[-2:, -2:]
    tilt = np.sin(np.radians(12))
    up = AXLE.mass + 25 * (tilt**2 + (1 - tilt**2) / 3)
    assert M[0, 0] == pytest.approx(up, rel=1e-6)
    assert M[1, 1] == pytest.approx(AXLE.mass + 25 / 3, rel=1e-6)
