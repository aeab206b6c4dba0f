"""Two joints against their pin axes in space, and against the tangent relation applied twice."""

import numpy as np
import pytest

from cardan.physics.kinematics import hooke_joint
from cardan.physics.kinematics import joint_pair as pair

THETA = np.linspace(0, 2 * np.pi, 3601)[:-1]


def turned(vector, axis, angle):
    """Rodrigues' rotation of vectors (n, 3) about a unit axis by angles (n,)."""
    c, s = np.cos(angle)[:, None], np.sin(angle)[:, None]
    return vector * c + np.cross(axis, vector) * s + axis * (vector @ axis)[:, None] * (1 - c)


def output_angle_in_space(beta, beta2, phase, plane):
    """Output angle (n,) of two joints from cross products of their pin axes, unwrapped.

    A cross holds the driven pin normal to the driving pin and to the driven shaft. Nothing of the
    code under test is used.
    """
    d1 = np.array([1.0, 0, 0])
    d2 = np.array([np.cos(beta), np.sin(beta), 0])
    ahead, side = np.array([-np.sin(beta), np.cos(beta), 0]), np.array([0, 0, 1.0])
    d3 = np.cos(beta2) * d2 + np.sin(beta2) * (np.cos(plane) * ahead + np.sin(plane) * side)
    pin = turned(np.tile([0.0, 1, 0], (len(THETA), 1)), d1, THETA)  # in plane at 0
    driven = np.cross(d2, pin)
    driven /= np.linalg.norm(driven, axis=1)[:, None]
    second = turned(driven, d2, np.full(len(THETA), phase))
    last = np.cross(d3, second)
    last /= np.linalg.norm(last, axis=1)[:, None]
    u = last[0]
    found = np.unwrap(np.arctan2(last @ np.cross(d3, u), last @ u))
    return found - (found - THETA).mean()


CASES = [(4.5, 4.5, 90, 0), (30, 20, 35, 0), (25, 40, -70, 120), (12, 12, 10, 180), (8, 3, 0, 60)]


@pytest.mark.parametrize("case", CASES)
def test_output_of_two_joints_matches_pin_axes_in_space(case):
    beta, beta2, phase, plane = np.radians(case)
    phasor = pair.pair_phasor(beta, beta2, phase=phase, plane_angle=plane)
    angle = pair.equivalent_angle_of_phasor(phasor)
    pin = float(np.angle(phasor)) / 2
    space = output_angle_in_space(beta, beta2, phase, plane)
    lead = hooke_joint.angle_lead(THETA, beta=angle, pin=pin)
    assert lead == pytest.approx(space - THETA, abs=1e-12)
    step = THETA[1]
    speed = np.gradient(np.concatenate([space[-2:] - 2 * np.pi, space, space[:2] + 2 * np.pi]),
                        step)[2:-2]  # fmt: skip
    # Central differences err by h²/6 of the third derivative: 1e-6 of it, which is below 4.
    swing = speed.max() - speed.min()
    assert hooke_joint.irregularity(angle) == pytest.approx(swing, abs=1e-5)


@pytest.mark.parametrize("degrees", [4.5, 20.0, 44.0])
def test_equal_joints_are_uniform_in_phase_and_double_out_of_phase(degrees):
    beta = np.radians(degrees)
    at = {"phase": np.radians([0, 90, 0, 90]), "plane_angle": np.radians([0, 0, 180, 180])}
    angle = pair.equivalent_angle_of_phasor(pair.pair_phasor(beta, beta, **at))
    assert angle[[0, 2]] == pytest.approx(0, abs=1e-7)  # the root of rounding
    # tan φ = tan θ / cos² β: the output swings between cos² β and its inverse.
    assert np.cos(angle[[1, 3]]) == pytest.approx(np.cos(beta) ** 2, rel=1e-12)


def test_best_phase_leaves_least_of_all_phases():
    beta, beta2, plane = np.radians([12.0, 7.0, 115.0])
    phases = np.radians(np.arange(-90, 90, 0.1))
    angles = pair.equivalent_angle_of_phasor(
        pair.pair_phasor(beta, beta2, phase=phases, plane_angle=plane)
    )
    best = float(pair.phase_of_least_fluctuation(plane))
    assert phases[angles.argmin()] == pytest.approx(best, abs=np.radians(0.06))
    assert best == pytest.approx(np.radians(-65))
    assert angles.min() == pytest.approx(np.arccos(np.cos(beta) / np.cos(beta2)), rel=1e-6)


@pytest.mark.parametrize("limit_deg", [9.0, 15.0])
def test_phase_tolerance_reaches_its_limit_exactly(limit_deg):
    """Up to the largest angle of all phases, 15.6 deg, not only near the best phase."""
    beta, beta2, plane, limit = np.radians([12.0, 10.0, 30.0, limit_deg])
    tolerance = float(pair.phase_tolerance(beta, beta2, limit=limit))
    phasor = pair.pair_phasor(beta, beta2, phase=plane - tolerance, plane_angle=plane)
    assert pair.equivalent_angle_of_phasor(phasor) == pytest.approx(limit, rel=1e-12)


def test_phase_tolerance_of_limits_beyond_all_phases():
    beta, beta2 = np.radians([12.0, 10.0])
    assert np.isnan(pair.phase_tolerance(beta, beta2, limit=np.radians(6.0)))
    assert pair.phase_tolerance(beta, beta2, limit=np.radians(20.0)) == pytest.approx(np.pi / 2)
    assert pair.phase_tolerance(beta, 0.0, limit=beta) == pytest.approx(np.pi / 2)


def test_largest_angle_for_acceleration_inverts_the_peak_of_its_curve():
    wanted = np.array([1e-4, 7.036e-3, 0.5, 20.0])
    angles = hooke_joint.angle_for_max_acceleration(wanted)
    for a, beta in zip(wanted, angles, strict=True):
        theta = np.linspace(0, np.pi, 400_001)
        speed = np.cos(beta) / (1 - np.sin(beta) ** 2 * np.cos(theta) ** 2)
        # d speed / dθ by differences of second order: h²/6 of the third derivative.
        assert np.abs(np.gradient(speed, theta) * 1.0).max() == pytest.approx(a, rel=1e-5)
