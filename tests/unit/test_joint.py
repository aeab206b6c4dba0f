"""One joint: what follows from its definition, without outside reference."""

import doctest

import numpy as np
import pytest

from cardan.base.units import deg
from cardan.kinematics import joint
from cardan.kinematics.joint import IN_PLANE, NORMAL

THETA = np.linspace(-7.0, 20.0, 1001)
ANGLES = np.array([0.0, 1e-6, 3.0, 15.0, 45.0, 85.0]) * deg
TURN = np.linspace(0.0, 2 * np.pi, 3601)


@pytest.mark.parametrize("beta", ANGLES)
def test_the_output_obeys_the_tangent_law_of_its_convention(beta):
    flat = joint.output_angle(THETA, beta=beta, pin=IN_PLANE)
    assert np.sin(flat) * np.cos(beta) * np.cos(THETA) == pytest.approx(
        np.cos(flat) * np.sin(THETA), abs=1e-14
    )
    upright = joint.output_angle(THETA, beta=beta, pin=NORMAL)
    assert np.sin(upright) * np.cos(THETA) == pytest.approx(
        np.cos(upright) * np.sin(THETA) * np.cos(beta), abs=1e-14
    )


@pytest.mark.parametrize("of", [joint.lead, joint.speed_ratio])
def test_the_conventions_differ_by_a_quarter_turn(of):
    shifted = of(THETA + np.pi / 2, beta=0.4)
    assert of(THETA, beta=0.4, pin=NORMAL) == pytest.approx(shifted, abs=1e-14)
    assert abs(of(THETA, beta=0.4) - shifted).max() > 0.05  # and it matters


@pytest.mark.parametrize("pin", [IN_PLANE, NORMAL, 0.3])
def test_speed_is_the_slope_of_position_and_acceleration_that_of_speed(pin):
    """Central differences err by h² f'''/6: 1e-8 at h = 1e-4 and this angle."""
    h, beta = 1e-4, 25 * deg
    ahead, behind = THETA + h, THETA - h
    position = [joint.output_angle(t, beta=beta, pin=pin) for t in (ahead, behind)]
    speed = [joint.speed_ratio(t, beta=beta, pin=pin) for t in (ahead, behind)]
    assert joint.speed_ratio(THETA, beta=beta, pin=pin) == pytest.approx(
        (position[0] - position[1]) / (2 * h), abs=2e-8
    )
    assert joint.acceleration(THETA, beta=beta, speed=3.0, pin=pin) == pytest.approx(
        9 * (speed[0] - speed[1]) / (2 * h), abs=2e-7
    )


def test_an_accelerating_input_adds_its_share():
    """θ = θ₀ + w t + a t²/2, differenced twice in time."""
    w, a, h, beta = 5.0, 40.0, 1e-4, 20 * deg
    t = np.linspace(0, 1, 50)
    out = [
        joint.output_angle(w * s + a * s**2 / 2, beta=beta, pin=NORMAL) for s in (t - h, t, t + h)
    ]
    theta, speed = w * t + a * t**2 / 2, w + a * t
    exact = joint.acceleration(theta, beta=beta, speed=speed, input_acceleration=a, pin=NORMAL)
    assert exact == pytest.approx((out[0] - 2 * out[1] + out[2]) / h**2, rel=2e-4, abs=1e-2)


def test_the_lead_is_its_fourier_series():
    beta = 40 * deg
    n = np.arange(1, 21)
    series = (joint.lead_orders(beta, highest=40) * np.sin(2 * n * TURN[:, None])).sum(-1)
    assert joint.lead(TURN, beta=beta) == pytest.approx(series, abs=1e-15)


@pytest.mark.parametrize("pin", [IN_PLANE, NORMAL])
@pytest.mark.parametrize("beta", ANGLES[2:])
def test_at_equal_speeds_the_lead_is_at_its_largest(beta, pin):
    angles = joint.equal_speed_angles(beta, pin=pin)
    assert angles.shape == (4,)
    assert np.all(np.diff(angles) > 0)
    assert joint.speed_ratio(angles, beta=beta, pin=pin) == pytest.approx(np.ones(4), rel=1e-13)
    largest = joint.lead_amplitude(beta)
    assert abs(joint.lead(angles, beta=beta, pin=pin)) == pytest.approx(largest, rel=1e-13)
    assert abs(joint.lead(TURN, beta=beta, pin=pin)).max() <= largest * (1 + 1e-12)


@pytest.mark.parametrize("pin", [IN_PLANE, NORMAL])
@pytest.mark.parametrize("beta", ANGLES[2:])
def test_nowhere_is_the_acceleration_larger_than_at_its_maximum(beta, pin):
    angles = joint.max_acceleration_angles(beta, pin=pin)
    largest = joint.max_acceleration(beta)
    at = joint.acceleration(angles, beta=beta, speed=1.0, pin=pin)
    assert abs(at) == pytest.approx(largest, rel=1e-12)
    around = joint.acceleration(TURN, beta=beta, speed=1.0, pin=pin)
    assert abs(around).max() <= largest * (1 + 1e-12)
    slope = joint.acceleration(angles + 1e-6, beta=beta, speed=1.0, pin=pin) - joint.acceleration(
        angles - 1e-6, beta=beta, speed=1.0, pin=pin
    )
    assert abs(slope).max() < 1e-8 * largest


def test_approximations_of_the_maximum_fall_short_of_it_in_order():
    beta = np.array([10.0, 20.0, 30.0]) * deg
    exact, omar, flat, small = (joint.MAX_ACCELERATION[k](beta) for k in joint.MAX_ACCELERATION)
    assert list(joint.MAX_ACCELERATION) == ["exact", "omar_eq6", "at_45_deg", "small_angle"]
    assert np.all((flat < omar) & (omar < exact) & (small < flat))
    assert small == pytest.approx(exact, rel=0.07)


def test_a_straight_joint_changes_nothing():
    assert joint.max_acceleration(0.0) == joint.lead_amplitude(0.0) == joint.irregularity(0.0) == 0
    assert joint.output_angle(THETA, beta=0.0) == pytest.approx(THETA, abs=0)


@pytest.mark.parametrize("beta", ANGLES[1:])
def test_the_angle_of_an_irregularity_is_found_again(beta):
    assert joint.angle_for_irregularity(joint.irregularity(beta)) == pytest.approx(beta, rel=1e-12)


def test_the_range_of_speeds_is_where_the_pin_lies_in_the_plane_and_a_quarter_on():
    low, high = joint.speed_range(0.5)
    assert joint.speed_ratio([0, np.pi / 2], beta=0.5) == pytest.approx([high, low], rel=1e-15)
    assert high - low == pytest.approx(joint.irregularity(0.5), rel=1e-14)


def test_power_in_is_power_out():
    out = joint.output_torque(THETA, beta=0.7, torque=250.0, pin=NORMAL)
    speed = joint.speed_ratio(THETA, beta=0.7, pin=NORMAL)
    assert out * speed == pytest.approx(np.full_like(THETA, 250.0), rel=1e-15)


@pytest.mark.parametrize("pin", [IN_PLANE, NORMAL])
def test_the_cross_turns_in_both_yokes_as_one_body(pin):
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


def test_needles_swing_through_the_joint_angle_at_the_rates_given():
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
def test_a_locked_joint_is_refused(beta):
    with pytest.raises(ValueError, match="90 deg"):
        joint.speed_ratio(THETA, beta=beta)


def test_numbers_and_arrays_are_served_alike():
    grid = joint.speed_ratio(THETA[:, None], beta=ANGLES)
    assert grid.shape == (1001, 6)
    assert joint.speed_ratio(THETA[7], beta=ANGLES[3]) == grid[7, 3]
    assert joint.lead_orders(ANGLES, highest=4).shape == (6, 2)


def test_examples_in_the_docstrings_hold():
    found = doctest.testmod(joint)
    assert found.attempted >= 4
    assert found.failed == 0
