"""Constant-velocity arrangements against the exact chain and Seherr-Thoss et al. (2006), ch. 1."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.optimize import fsolve

from cardan.core.errors import DesignError
from cardan.core.units import deg, mm
from cardan.physics.kinematics.constant_velocity import (
    double_cardan_irregularity,
    front_cross_to_centring_point_distance,
    irregularity_by_centring_distances,
    rotate_double_cardan,
    rotate_persian_joint,
    rzeppa_angle_lead,
    split_joint_angle,
    tripod_orbit_radius,
)

angles = st.floats(1 * deg, 50 * deg)


@given(beta=angles)
def test_centred_double_cardan_is_constant_velocity(beta):
    run = rotate_double_cardan(beta, front=40 * mm, rear=40 * mm)
    np.testing.assert_allclose(run.speed[-1], 1.0, atol=1e-13)
    assert irregularity_by_centring_distances(beta, front=40 * mm, rear=40 * mm) < 1e-15


@given(beta=angles, error=st.floats(0.1 * mm, 10 * mm))
def test_closed_form_matches_exact_chain(beta, error):
    run = rotate_double_cardan(beta, front=40 * mm + error, rear=40 * mm, samples=256)
    swing = run.speed[-1].max() - run.speed[-1].min()
    closed = irregularity_by_centring_distances(beta, front=40 * mm + error, rear=40 * mm)
    # Extremes of an even function of the turn lie on the samples.
    assert swing == pytest.approx(closed, rel=1e-9, abs=1e-14)


def test_half_angles_satisfy_sine_rule():
    shared = split_joint_angle(0.6, front=0.05, rear=0.03)
    # Law of sines, and the projections on the line of the joints.
    assert np.sin(shared.front_angle) / 0.03 == pytest.approx(np.sin(0.6) / shared.joint_spacing)
    assert np.sin(shared.rear_angle) / 0.05 == pytest.approx(np.sin(0.6) / shared.joint_spacing)
    with pytest.raises(DesignError, match="between the joints"):
        split_joint_angle(0.6, front=0.0, rear=0.03)


def test_angle_error_gives_first_order_irregularity():
    """β₁ - β₂ = δ: the ratio is off by β δ / 2 to both sides, the swing is their sum."""
    beta = 10 * deg
    shared = split_joint_angle(beta, front=41 * mm, rear=40 * mm)
    apart = abs(float(shared.front_angle - shared.rear_angle))
    swing = irregularity_by_centring_distances(beta, front=41 * mm, rear=40 * mm)
    assert swing == pytest.approx(beta * apart, rel=beta**2)


def test_persian_joint_is_uniform_at_135_degrees():
    assert np.ptp(rotate_persian_joint(135 * deg).speed[-1]) < 1e-12
    assert np.ptp(rotate_persian_joint(135 * deg, error=1 * deg, samples=1024).speed[-1]) > 0.05


def lead_of_one_ball(theta, beta, error):
    """tan φ = tan θ cos(β/2 + ε) / cos(β/2 - ε), unwrapped."""
    c = np.cos(beta / 2 + error) / np.cos(beta / 2 - error)
    return np.arctan2(c * np.sin(theta), np.cos(theta)) - theta


def test_rzeppa_cage_averages_its_balls():
    """Six leads a sixth of a turn apart, one after the other, and their mean."""
    theta = np.linspace(-np.pi / 2.1, np.pi / 2.1, 90)
    beta, error = 0.7, 0.2
    one = rzeppa_angle_lead(theta, beta=beta, error=error, balls=2)
    np.testing.assert_allclose(one, lead_of_one_ball(theta, beta, error), atol=1e-15)
    every = theta[:, None] + np.pi / 3 * np.arange(6)
    each = np.angle(np.exp(1j * lead_of_one_ball(every, beta, error)))
    six = rzeppa_angle_lead(theta, beta=beta, error=error)
    np.testing.assert_allclose(six, each.mean(-1), atol=1e-15)
    np.testing.assert_array_equal(rzeppa_angle_lead(theta, beta=beta), 0.0)
    with pytest.raises(ValueError, match="give 2, 4, 6, not 5"):
        rzeppa_angle_lead(theta, beta=beta, balls=5)


def test_rzeppa_irregularity_at_one_degree_error():
    """At 30 deg: 4.7e-3 rad twice a turn from one ball, 3.4e-8 six times from six."""
    theta = 2 * np.pi * np.arange(64) / 64
    orders = {
        n: 2 * np.abs(np.fft.rfft(rzeppa_angle_lead(theta, beta=30 * deg, error=deg, balls=n))) / 64
        for n in (2, 6)
    }
    q = np.tan(15 * deg) * np.tan(deg)
    assert orders[2][2] == pytest.approx(q, rel=1e-9) == pytest.approx(4.68e-3, rel=1e-2)
    assert orders[6][6] == pytest.approx(q**3 / 3, rel=1e-6) == pytest.approx(3.4e-8, rel=1e-2)
    assert orders[6][[2, 4]].max() < 1e-17
    # One ball does what a Persian joint does that is off by as much.
    run = rotate_persian_joint(30 * deg, error=deg, samples=64)
    np.testing.assert_allclose(
        np.ptp(run.lead[-1]), np.ptp(rzeppa_angle_lead(theta, beta=30 * deg, error=deg, balls=2)),
        rtol=1e-6,
    )  # fmt: skip


def test_double_cardan_centring_error_grows_with_angle():
    """The ball half way: 0.1889 % at 20 deg, 0.9774 % at 30; by the exact chain too."""
    length, ball = 80 * mm, 40 * mm
    for beta, swing in ((20 * deg, 0.001889), (30 * deg, 0.009774)):
        assert double_cardan_irregularity(beta, length=length, ball=ball) == pytest.approx(
            swing, abs=5e-7
        )
        front = front_cross_to_centring_point_distance(beta, length=length, ball=ball)
        run = rotate_double_cardan(beta, front=front, rear=ball, samples=256)
        assert np.ptp(run.speed[-1]) == pytest.approx(swing, rel=1e-3)
        # The centre piece keeps its length: a triangle of f, r and L.
        assert split_joint_angle(beta, front=front, rear=ball).joint_spacing == pytest.approx(
            length, rel=1e-14
        )
    assert front_cross_to_centring_point_distance(0.0, length=length, ball=ball) == pytest.approx(
        ball, rel=1e-15
    )
    with pytest.raises(DesignError, match="between its crosses"):
        front_cross_to_centring_point_distance(0.1, length=40 * mm, ball=40 * mm)


def test_tripod_centre_orbits_three_times_per_turn():
    """Three legs in tracks along the housing's axis, by where they stand; 0.15427 mm of 20 mm.

    The tilted spider's plane cuts the three tracks at radius r round the housing: a leg runs
    from the spider's centre to each cut, 120 deg apart in its own plane. Whose centre does
    that is sought, and goes round in a circle of e, back three times a turn.
    """
    r, beta = 20 * mm, 10 * deg
    assert tripod_orbit_radius(beta, radius=r) == pytest.approx(0.15427 * mm, abs=5e-9)

    def centre(turn):
        """Of the three cuts seen in the spider's plane, from which they stand 120 deg apart."""
        p = turn + 2 * np.pi / 3 * np.arange(3)
        cuts = np.stack([np.cos(p) / np.cos(beta), np.sin(p)], -1)

        def apart(at):
            legs = cuts - at
            angle = np.arctan2(legs[:, 1], legs[:, 0])
            return np.angle(np.exp(1j * (np.diff(angle) - 2 * np.pi / 3)))

        return r * fsolve(apart, [1e-3, 1e-3], xtol=1e-10)

    at = np.array([centre(t) for t in np.linspace(0, 2 * np.pi, 25)])
    np.testing.assert_allclose(np.hypot(*at.T), tripod_orbit_radius(beta, radius=r), rtol=1e-8)
    round_ = np.unwrap(np.arctan2(at[:, 1], at[:, 0]))
    assert (round_[-1] - round_[0]) / (2 * np.pi) == pytest.approx(3)
