"""One joint: what follows from its definition, without outside reference."""

import doctest

import numpy as np
import pytest

from cardan.core.units import deg
from cardan.physics.kinematics import hooke_joint as joint
from cardan.physics.kinematics.hooke_joint import PIN_IN_PLANE, PIN_NORMAL_TO_PLANE

THETA = np.linspace(-7.0, 20.0, 1001)
ANGLES = np.array([0.0, 1e-6, 3.0, 15.0, 45.0, 85.0]) * deg
TURN = np.linspace(0.0, 2 * np.pi, 3601)


@pytest.mark.parametrize("beta", ANGLES)
def test_output_angle_obeys_tangent_law_of_pin_convention(beta):
    flat = joint.output_angle(THETA, beta=beta, pin=PIN_IN_PLANE)
    assert np.sin(flat) * np.cos(beta) * np.cos(THETA) == pytest.approx(
        np.cos(flat) * np.sin(THETA), abs=1e-14
    )
    upright = joint.output_angle(THETA, beta=beta, pin=PIN_NORMAL_TO_PLANE)
    assert np.sin(upright) * np.cos(THETA) == pytest.approx(
        np.cos(upright) * np.sin(THETA) * np.cos(beta), abs=1e-14
    )


@pytest.mark.parametrize("of", [joint.angle_lead, joint.speed_ratio])
def test_pin_conventions_differ_by_quarter_turn(of):
    shifted = of(THETA + np.pi / 2, beta=0.4)
    assert of(THETA, beta=0.4, pin=PIN_NORMAL_TO_PLANE) == pytest.approx(shifted, abs=1e-14)
    assert abs(of(THETA, beta=0.4) - shifted).max() > 0.05  # and it matters


@pytest.mark.parametrize("pin", [PIN_IN_PLANE, PIN_NORMAL_TO_PLANE, 0.3])
def test_speed_and_acceleration_are_derivatives_of_position(pin):
    """Central differences err by h² f'''/6: 1e-8 at h = 1e-4 and this angle."""
    h, beta = 1e-4, 25 * deg
    ahead, behind = THETA + h, THETA - h
    position = [joint.output_angle(t, beta=beta, pin=pin) for t in (ahead, behind)]
    speed = [joint.speed_ratio(t, beta=beta, pin=pin) for t in (ahead, behind)]
    assert joint.speed_ratio(THETA, beta=beta, pin=pin) == pytest.approx(
        (position[0] - position[1]) / (2 * h), abs=2e-8
    )
    assert joint.output_acceleration(THETA, beta=beta, speed=3.0, pin=pin) == pytest.approx(
        9 * (speed[0] - speed[1]) / (2 * h), abs=2e-7
    )


def test_input_acceleration_adds_to_output_acceleration():
    """θ = θ₀ + w t + a t²/2, differenced twice in time."""
    w, a, h, beta = 5.0, 40.0, 1e-4, 20 * deg
    t = np.linspace(0, 1, 50)
    out = [
        joint.output_angle(w * s + a * s**2 / 2, beta=beta, pin=PIN_NORMAL_TO_PLANE)
        for s in (t - h, t, t + h)
    ]
    theta, speed = w * t + a * t**2 / 2, w + a * t
    exact = joint.output_acceleration(
        theta, beta=beta, speed=speed, input_acceleration=a, pin=PIN_NORMAL_TO_PLANE
    )
    assert exact == pytest.approx((out[0] - 2 * out[1] + out[2]) / h**2, rel=2e-4, abs=1e-2)


def test_lead_equals_its_fourier_series():
    beta = 40 * deg
    n = np.arange(1, 21)
    series = (np.tan(beta / 2) ** (2 * n) / n * np.sin(2 * n * TURN[:, None])).sum(-1)
    assert joint.angle_lead(TURN, beta=beta) == pytest.approx(series, abs=1e-15)


@pytest.mark.parametrize("pin", [PIN_IN_PLANE, PIN_NORMAL_TO_PLANE])
@pytest.mark.parametrize("beta", ANGLES[2:])
def test_lead_is_largest_at_equal_speed_angles(beta, pin):
    angles = joint.equal_speed_angles(beta, pin=pin)
    assert angles.shape == (4,)
    assert np.all(np.diff(angles) > 0)
    assert joint.speed_ratio(angles, beta=beta, pin=pin) == pytest.approx(np.ones(4), rel=1e-13)
    largest = joint.angle_lead_amplitude(beta)
    assert abs(joint.angle_lead(angles, beta=beta, pin=pin)) == pytest.approx(largest, rel=1e-13)
    assert abs(joint.angle_lead(TURN, beta=beta, pin=pin)).max() <= largest * (1 + 1e-12)


@pytest.mark.parametrize("pin", [PIN_IN_PLANE, PIN_NORMAL_TO_PLANE])
@pytest.mark.parametrize("beta", ANGLES[2:])
def test_acceleration_never_exceeds_its_maximum(beta, pin):
    angles = joint.max_acceleration_angles(beta, pin=pin)
    largest = joint.max_acceleration(beta)
    at = joint.output_acceleration(angles, beta=beta, speed=1.0, pin=pin)
    assert abs(at) == pytest.approx(largest, rel=1e-12)
    around = joint.output_acceleration(TURN, beta=beta, speed=1.0, pin=pin)
    assert abs(around).max() <= largest * (1 + 1e-12)
    slope = joint.output_acceleration(
        angles + 1e-6, beta=beta, speed=1.0, pin=pin
    ) - joint.output_acceleration(angles - 1e-6, beta=beta, speed=1.0, pin=pin)
    assert abs(slope).max() < 1e-8 * largest


def test_approximations_of_max_acceleration_are_below_exact_value():
    beta = np.array([10.0, 20.0, 30.0]) * deg
    exact, omar, flat, small = (
        joint.MAX_ACCELERATION_FORMULAS[k](beta) for k in joint.MAX_ACCELERATION_FORMULAS
    )
    assert list(joint.MAX_ACCELERATION_FORMULAS) == [
        "exact",
        "omar_eq6",
        "at_45_deg",
        "small_angle",
    ]
    assert np.all((flat < omar) & (omar < exact) & (small < flat))
    assert small == pytest.approx(exact, rel=0.07)


def test_straight_joint_transmits_uniform_motion():
    assert (
        joint.max_acceleration(0.0)
        == joint.angle_lead_amplitude(0.0)
        == joint.irregularity(0.0)
        == 0
    )
    assert joint.output_angle(THETA, beta=0.0) == pytest.approx(THETA, abs=0)


@pytest.mark.parametrize("beta", ANGLES[1:])
def test_angle_for_irregularity_inverts_irregularity(beta):
    assert joint.angle_for_irregularity(joint.irregularity(beta)) == pytest.approx(beta, rel=1e-12)


def test_speed_extremes_are_at_pin_in_plane_and_quarter_turn_later():
    low, high = joint.speed_range(0.5)
    assert joint.speed_ratio([0, np.pi / 2], beta=0.5) == pytest.approx([high, low], rel=1e-15)
    assert high - low == pytest.approx(joint.irregularity(0.5), rel=1e-14)


@pytest.mark.parametrize("pin", [PIN_IN_PLANE, PIN_NORMAL_TO_PLANE])
def test_cross_motion_is_consistent_in_both_yokes(pin):
    """Its absolute angular velocity must come out the same by either yoke."""
    beta, w = 35 * deg, 2.0
    front, normal, along = np.eye(3)
    behind = np.cos(beta) * along + np.sin(beta) * front
    theta = THETA[:, None] + pin
    a = np.cos(theta) * front + np.sin(theta) * normal
    b = np.cross(behind, a)
    b /= np.linalg.norm(b, axis=-1, keepdims=True)
    motion = joint.cross_motion(THETA, beta=beta, speed=w, pin=pin)
    by_driving = motion.driving_rate[:, None] * a + w * along
    driven = w * joint.speed_ratio(THETA, beta=beta, pin=pin)[:, None] * behind
    assert by_driving == pytest.approx(motion.driven_rate[:, None] * b + driven, abs=1e-13)
    assert motion.driving_angle == pytest.approx(np.arcsin(b @ along), abs=1e-14)
    assert motion.driven_angle == pytest.approx(-np.arcsin(a @ behind), abs=1e-14)


def test_needle_oscillation_amplitude_equals_joint_angle():
    beta, h = 12 * deg, 1e-4

    def swing(theta):
        return joint.cross_motion(theta, beta=beta, speed=1.0)

    now, ahead, behind = swing(TURN), swing(TURN + h), swing(TURN - h)
    for yoke in ("driving", "driven"):
        angle, rate = f"{yoke}_angle", f"{yoke}_rate"
        assert abs(getattr(now, angle)).max() == pytest.approx(beta, rel=1e-12)
        slope = (getattr(ahead, angle) - getattr(behind, angle)) / (2 * h)
        assert getattr(now, rate) == pytest.approx(slope, abs=1e-8)


@pytest.mark.parametrize("beta", [90 * deg, -2.0, np.nan])
def test_joint_at_90_deg_is_rejected(beta):
    with pytest.raises(ValueError, match="90 deg"):
        joint.speed_ratio(THETA, beta=beta)


def test_scalars_and_arrays_give_equal_results():
    grid = joint.speed_ratio(THETA[:, None], beta=ANGLES)
    assert grid.shape == (1001, 6)
    assert joint.speed_ratio(THETA[7], beta=ANGLES[3]) == grid[7, 3]


def test_docstring_examples_pass():
    found = doctest.testmod(joint)
    assert found.attempted >= 4
    assert found.failed == 0
