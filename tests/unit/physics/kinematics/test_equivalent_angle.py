"""A line as one joint, against a turn sampled finely and against itself turned around."""

from dataclasses import fields

import numpy as np
import pytest

from cardan.core.units import deg, rpm
from cardan.model.layout import direction_from_slopes, unit_vector
from cardan.physics.kinematics import equivalent_angle as equivalent
from cardan.physics.kinematics.equivalent_angle import (
    EXCITATION_APPROXIMATIONS,
    ae7_excitation,
    excitation_approximations,
    excitation_of_rotating_chain,
)
from cardan.physics.kinematics.joint_chain import order_amplitudes, rotate_chain

RNG = np.random.default_rng(7)
SPEED = 2400 * rpm


def line(joints, spread, cases=20):
    way = np.array([1.0, 0, 0]) + spread * RNG.uniform(-1, 1, (cases, joints + 1, 3))
    return unit_vector(way), RNG.uniform(-np.pi, np.pi, (cases, joints - 1))


def turned_around(directions, phases):
    """The same line seen from the axle, which points rearward again after half a turn of it."""
    return (directions * [1, 1, -1])[..., ::-1, :], phases[..., ::-1]


@pytest.mark.parametrize(("joints", "spread"), [(1, 0.3), (2, 0.1), (3, 0.2), (4, 0.4)])
def test_peak_excitation_matches_finely_sampled_turn(joints, spread):
    """2048 samples a turn miss a peak by at most (order x half a step)²/2, some 1e-5."""
    d, phases = line(joints, spread)
    J = RNG.uniform(0.01, 0.3, (len(d), joints - 1))
    found = excitation_of_rotating_chain(rotate_chain(d, phases=phases), speed=SPEED, inertias=J)
    fine = rotate_chain(d, phases=phases, samples=2048)
    shafts, coasting = fine.acceleration[:, :-1], fine.coast_acceleration[:, :-1]
    for value, values in (
        (found.torsional.acceleration, fine.acceleration[:, -1]),
        (found.drive.acceleration, shafts.sum(1)),
        (found.coast.acceleration, coasting.sum(1)),
        (found.drive_torque, (J[..., None] * shafts).sum(1)),
        (found.coast_torque, (J[..., None] * coasting).sum(1)),
    ):
        sampled = SPEED**2 * abs(values).max(-1)
        assert np.all(sampled <= value * (1 + 1e-12))
        assert value == pytest.approx(sampled, rel=2e-4)
    swing = np.ptp(fine.speed[:, -1], axis=-1)
    assert np.all(swing <= found.irregularity * (1 + 1e-12))
    assert found.irregularity == pytest.approx(swing, rel=2e-4)


def test_equivalent_angle_has_same_2nd_order_amplitude():
    d, phases = line(3, 0.1)
    found = excitation_of_rotating_chain(rotate_chain(d, phases=phases), speed=1.0)
    lead = rotate_chain(d, phases=phases).lead
    for angle, member in (
        (found.torsional.angle, lead[:, -1]),
        (found.drive.angle, lead[:, :-1].sum(1)),
    ):
        assert angle == pytest.approx(
            2 * np.arctan(np.sqrt(abs(order_amplitudes(member)[:, 2]))), rel=1e-12
        )


@pytest.mark.parametrize("joints", [2, 3, 4])
def test_overrun_equals_drive_of_reversed_line(joints):
    d, phases = line(joints, 0.3)
    J = RNG.uniform(0.01, 0.3, (len(d), joints - 1))
    here = excitation_of_rotating_chain(rotate_chain(d, phases=phases), speed=SPEED, inertias=J)
    d, phases = turned_around(d, phases)
    there = excitation_of_rotating_chain(
        rotate_chain(d, phases=phases), speed=SPEED, inertias=J[:, ::-1]
    )
    assert here.coast.angle == pytest.approx(there.drive.angle, rel=1e-12)
    assert here.coast.acceleration == pytest.approx(there.drive.acceleration, rel=1e-10)
    assert here.coast_torque == pytest.approx(there.drive_torque, rel=1e-10)
    assert here.torsional.acceleration == pytest.approx(there.torsional.acceleration, rel=1e-10)


def test_exact_line_converges_to_ae7_for_small_angles():
    """The phasors leave out terms β² times their own size, so a tenth leaves a hundredth.

    This is what settles the sign of exp(2iε): the wrong one is off by all of it.
    """
    phases = np.array([0.4, -1.1, 2.0])
    side, top = np.array([3, -2, 2.5, 1]) * deg, np.array([1, 2, -1.5, 0.5]) * deg
    misses = []
    for scale in (0.1, 0.01):
        slopes = [scale * np.insert(np.cumsum(view), 0, 0) for view in (side, top)]
        d = direction_from_slopes(side=slopes[0], top=slopes[1])
        exact = excitation_of_rotating_chain(
            rotate_chain(d, phases=phases), speed=1.0, inertias=[1, 2, 3]
        )
        near = ae7_excitation(
            scale * side, scale * top, phases=phases, speed=1.0, inertias=[1, 2, 3]
        )
        misses.append(
            [
                near.torsional.acceleration / exact.torsional.acceleration - 1,
                near.drive.acceleration / exact.drive.acceleration - 1,
                near.coast.acceleration / exact.coast.acceleration - 1,
                near.drive_torque / exact.drive_torque - 1,
                near.coast_torque / exact.coast_torque - 1,
            ]
        )
    misses = np.abs(misses)
    assert misses[0].max() < 5e-5
    assert misses[0] / misses[1] == pytest.approx(np.full(5, 100), rel=0.05)
    wrong = ae7_excitation(side, top, phases=-phases, speed=1.0)
    assert abs(wrong.torsional.angle / exact.torsional.angle / 100 - 1) > 0.05


def test_ae7_weights_joints_by_adjacent_shaft_count():
    """Four joints, all aligned and in one plane: (n-k) in drive, (k-1) in coast."""
    b = np.array([3.0, 1, 2, 5]) * deg
    found = ae7_excitation(b, 0 * b, phases=[0, 0, 0], speed=10.0)
    signed = b**2 * [1, -1, 1, -1]
    assert found.torsional.acceleration == pytest.approx(100 * abs(signed.sum()), rel=1e-13)
    assert found.drive.acceleration == pytest.approx(100 * abs(signed @ [3, 2, 1, 0]), rel=1e-13)
    assert found.coast.acceleration == pytest.approx(100 * abs(signed @ [0, 1, 2, 3]), rel=1e-13)
    assert found.drive_torque is None
    torque = ae7_excitation(b, 0 * b, phases=[0, 0, 0], speed=10.0, inertias=[2, 2, 2]).drive_torque
    assert torque == pytest.approx(2 * found.drive.acceleration, rel=1e-13)


def test_in_plane_formula_equals_ae7_for_coplanar_line():
    b = np.array([2.0, 4, 1]) * deg
    for phases in ([0, 0], [np.pi / 2, 0], [0.2, 0.7]):
        one = ae7_excitation(0.6 * b, 0.8 * b, phases=phases, speed=1.0)
        other = equivalent.in_plane_excitation(0.6 * b, 0.8 * b, phases=phases, speed=1.0)
        assert one.torsional.angle == pytest.approx(other.torsional.angle, rel=1e-13)
    skew = equivalent.in_plane_excitation(b, [0, 4 * deg, 0], phases=[0, 0], speed=1.0)
    assert abs(skew.torsional.angle / one.torsional.angle - 1) > 0.05  # and else it is not


def test_every_approximation_has_name_and_same_fields():
    side, top = RNG.uniform(-0.1, 0.1, (2, 6, 3))
    named = excitation_approximations(side, top, phases=[0, 0.3], speed=SPEED, inertias=[0.1, 0.2])
    assert (
        list(named)
        == list(EXCITATION_APPROXIMATIONS)
        == ["ae7", "in_plane", "spicer_sine", "spicer_rpm"]
    )
    for result in named.values():
        for field in fields(result):
            value = getattr(result, field.name)
            assert getattr(value, "angle", value).shape == (6,)
    angle, w2 = named["ae7"].drive.angle, SPEED**2
    assert named["ae7"].drive.acceleration == pytest.approx(w2 * angle**2, rel=1e-13)
    sine = w2 * np.sin(angle) ** 2
    assert named["spicer_sine"].drive.acceleration == pytest.approx(sine, rel=1e-13)
    printed = 3.3403e-6 * 2400**2 * np.degrees(angle) ** 2
    assert named["spicer_rpm"].drive.acceleration == pytest.approx(printed, rel=1e-13)


def test_single_joint_has_no_inertia_acceleration():
    found = ae7_excitation([3 * deg], [4 * deg], phases=[], speed=100.0)
    assert found.torsional.angle == pytest.approx(5 * deg, rel=1e-14)
    assert found.drive.acceleration == found.coast.acceleration == 0


def test_angular_position_covers_four_quadrants():
    angle = np.array([0, 45, 90, 135, 180, 225, 270, 315]) * deg
    side, top = 0.01 * np.sin(angle).round(15), 0.01 * np.cos(angle).round(15)
    assert equivalent.joint_plane_angle(side, top) == pytest.approx(angle, abs=1e-12)
    assert equivalent.joint_plane_quadrant(side, top).tolist() == [1, 1, 2, 2, 3, 3, 4, 4]
    assert equivalent.joint_plane_angle(-1e-30, 1.0) == 0.0  # not a full turn
    assert equivalent.joint_plane_angle(-1e-3, 1.0) < 2 * np.pi


def test_true_angle_formulas_match_exact_angle():
    side, top = 3 * deg, 4 * deg
    assert equivalent.TRUE_ANGLE_FORMULAS["pythagoras"](side, top) == pytest.approx(
        5 * deg, rel=1e-14
    )
    d = direction_from_slopes(side=[0, side], top=[0, top])
    exact = np.arccos(d[0] @ d[1])
    assert equivalent.TRUE_ANGLE_FORMULAS["elbe"](side, top) == pytest.approx(exact, rel=1e-12)


def test_angle_for_acceleration_is_invertible():
    angle = equivalent.angle_for_acceleration(1000.0, speed=SPEED)
    assert (SPEED * angle) ** 2 == pytest.approx(1000.0, rel=1e-14)


@pytest.mark.slow
def test_batch_peaks_equal_single_line_peaks():
    """Nearly straight and much bent ones, more than a block holds, in any order.

    Peaks of the first come of three terms and a parabola, of the others by following them from
    eight places. Samples miss a peak by at most (half a step)²/2 of its bend, some 1e-9 here.
    """
    straight, bent = line(4, 0.06, cases=1200), line(4, 0.4, cases=1200)
    mixed = RNG.permutation(2400)
    d, phases = (np.concatenate(v)[mixed] for v in zip(straight, bent, strict=True))
    J = RNG.uniform(0.01, 0.3, (2400, 3))
    together = excitation_of_rotating_chain(rotate_chain(d, phases=phases), speed=SPEED, inertias=J)
    for k in range(0, 2400, 97):
        alone = rotate_chain(d[k], phases=phases[k])
        z = np.exp(2j * np.pi * np.arange(2**17) / 2**17)
        x = alone.phasors[:-1, None] * z
        swing = np.abs((J[k, :, None] * (-4 * (x / (1 - x) ** 2).imag)).sum(0)).max()
        assert together.drive_torque[k] == pytest.approx(SPEED**2 * swing, rel=2e-9)
        single = excitation_of_rotating_chain(alone, speed=SPEED, inertias=J[k])
        assert together.drive_torque[k] == pytest.approx(single.drive_torque, rel=1e-12)
        assert together.coast.acceleration[k] == pytest.approx(single.coast.acceleration, rel=1e-12)


@pytest.mark.parametrize("spread", [0.02, 0.1])
def test_torque_peaks_match_parabolic_interpolation(spread):
    """Of 2¹⁴ samples the parabola over the highest three misses the peak by some 1e-14 of it."""
    d, phases = line(4, spread, cases=40)
    J = RNG.uniform(0.01, 0.3, (len(d), 3))
    turned = rotate_chain(d, phases=phases)
    found = excitation_of_rotating_chain(turned, speed=SPEED, inertias=J).drive_torque
    for k, phasors in enumerate(turned.phasors[:, :-1]):
        x = phasors[:, None] * np.exp(2j * np.pi * np.arange(2**14) / 2**14)
        swing = np.abs((J[k, :, None] * (-4 * (x / (1 - x) ** 2).imag)).sum(0))
        top = swing.argmax()
        before, peak, after = (swing[(top + s) % len(swing)] for s in (-1, 0, 1))
        crest = peak + (after - before) ** 2 / (8 * (2 * peak - before - after))
        assert found[k] == pytest.approx(SPEED**2 * crest, rel=2e-12)


def test_joint_angle_near_90_degrees_has_finite_peak():
    """A shaft behind one joint of 89.9 deg: the shafts' sum is what that joint makes alone."""
    beta = np.radians(89.9)
    way = unit_vector(
        np.array([[1.0, 0, 0], [np.cos(beta), np.sin(beta), 0], [np.cos(beta), np.sin(beta), 0]])
    )
    found = excitation_of_rotating_chain(rotate_chain(way, phases=[0.0]), speed=1.0)
    assert found.drive.acceleration == pytest.approx(found.torsional.acceleration, rel=1e-6)
