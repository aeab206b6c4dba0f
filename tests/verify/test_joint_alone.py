"""One joint: ITIS Omar, eq. 1-6; PME 2540, exercise E2; Souza (2014), eq. 6-10 (Wagner 1979).

Digits without a publication of their own were computed by high-precision evaluation of
these equations.
"""

import numpy as np
import pytest

from cardan.core.units import deg, rpm
from cardan.physics.kinematics import hooke_joint as joint
from cardan.physics.kinematics.hooke_joint import PIN_IN_PLANE, PIN_NORMAL_TO_PLANE

TURN = np.radians(np.arange(0.0, 360.0, 0.25))


def printed(text):
    """The number, with half a unit of its last printed digit as the tolerance."""
    decimals = len(text.partition(".")[2])
    return pytest.approx(float(text), abs=0.5 * 10**-decimals)


@pytest.mark.parametrize("delta", [5, 15, 30])
def test_position_speed_and_acceleration_match_omar(delta):
    """Eq. 1, 2 and 4: tan α = tan β cos δ, pin in the plane at α = 0."""
    d = delta * deg
    beta = joint.output_angle(TURN, beta=d, pin=PIN_IN_PLANE)
    assert np.sin(TURN) * np.cos(beta) == pytest.approx(
        np.cos(TURN) * np.sin(beta) * np.cos(d), abs=1e-14
    )
    slope = 1 - np.sin(d) ** 2 * np.cos(TURN) ** 2
    assert joint.speed_ratio(TURN, beta=d) == pytest.approx(np.cos(d) / slope, rel=1e-14)
    assert joint.output_acceleration(TURN, beta=d, speed=9.0) == pytest.approx(
        -(9**2) * np.sin(d) ** 2 * np.cos(d) * np.sin(2 * TURN) / slope**2, abs=1e-12
    )


def test_acceleration_symmetries_match_omar():
    quarters = np.arange(8) * np.pi / 2
    assert abs(joint.output_acceleration(quarters, beta=0.5, speed=1.0)).max() < 1e-14
    there = joint.output_acceleration(np.pi - TURN, beta=0.5, speed=1.0)
    assert there == pytest.approx(-joint.output_acceleration(TURN, beta=0.5, speed=1.0), abs=1e-14)


def test_equal_speed_angles_match_omar():
    """Eq. 3: tan α = ±√cos δ, four times a turn."""
    angles = joint.equal_speed_angles(25 * deg)
    assert np.abs(np.tan(angles)) == pytest.approx(np.full(4, np.sqrt(np.cos(25 * deg))), rel=1e-13)


@pytest.mark.parametrize("delta", [1, 10, 20, 30, 45])
def test_maximum_acceleration_matches_omar(delta):
    """Eq. 5 is met by the exact maximum, eq. 6 and 45 deg are what is printed."""
    s2, cos = np.sin(delta * deg) ** 2, np.cos(delta * deg)
    angles = joint.max_acceleration_angles(delta * deg)
    c = np.cos(2 * angles)
    assert c == pytest.approx(s2 * (2 - c**2) / (2 - s2), abs=1e-14)
    named = {name: of(delta * deg) for name, of in joint.MAX_ACCELERATION_FORMULAS.items()}
    c = 2 * s2 / (2 - s2)
    theta = np.arccos(c) / 2
    eq_6 = abs(joint.output_acceleration(theta, beta=delta * deg, speed=1.0))
    assert named["omar_eq6"] == pytest.approx(eq_6, rel=1e-12)
    assert named["at_45_deg"] == pytest.approx(s2 * cos / (1 - s2 / 2) ** 2, rel=1e-14)


@pytest.mark.parametrize(
    ("beta", "largest"), [(10, "0.03062603"), (20, "0.12496558"), (30, "0.29457110")]
)
def test_maximum_acceleration_over_speed_squared_matches_search(beta, largest):
    """And by a search of eq. 4 that knows nothing of eq. 5."""
    from scipy.optimize import minimize_scalar

    found = joint.max_acceleration(beta * deg)
    assert found == printed(largest)
    s2, cos = np.sin(beta * deg) ** 2, np.cos(beta * deg)
    searched = minimize_scalar(
        lambda t: -s2 * cos * np.sin(2 * t) / (1 - s2 * np.cos(t) ** 2) ** 2,
        bounds=(0, np.pi / 2),
        method="bounded",
        options={"xatol": 1e-10},
    )
    assert found == pytest.approx(-searched.fun, rel=1e-14)


def test_speed_and_cross_motion_match_exercise_e2():
    """Ω = ω cos α/(1 - sin²α sin²θ), tan γ = tan α cos θ, and the three component equations."""
    alpha, w = 22 * deg, 100.0
    speed = w * joint.speed_ratio(TURN, beta=alpha, pin=PIN_NORMAL_TO_PLANE)
    cross = joint.cross_motion(TURN, beta=alpha, speed=w, pin=PIN_NORMAL_TO_PLANE)
    gamma, r1, r2 = cross.driving_angle, cross.driven_rate, cross.driving_rate
    sin, cos = np.sin(TURN), np.cos(TURN)
    assert speed == pytest.approx(w * np.cos(alpha) / (1 - np.sin(alpha) ** 2 * sin**2), rel=1e-14)
    assert np.tan(gamma) == pytest.approx(np.tan(alpha) * cos, abs=1e-15)
    assert gamma.max() == pytest.approx(alpha, rel=1e-14)
    assert gamma.min() == pytest.approx(-alpha, rel=1e-14)
    assert r2 * cos == pytest.approx(-r1 * np.cos(gamma) * sin, abs=1e-12)
    assert r1 * np.sin(gamma) + speed * np.cos(alpha) == pytest.approx(np.full(1440, w), rel=1e-14)
    assert r2 * sin == pytest.approx(r1 * np.cos(gamma) * cos - speed * np.sin(alpha), abs=1e-12)


def test_equal_speed_angles_match_souza_equations_9_and_10():
    """Where speeds are equal, pin normal, tan θ = 1/√cos β and tan φ = √cos β."""
    beta = 4.5 * deg
    theta = joint.equal_speed_angles(beta, pin=PIN_NORMAL_TO_PLANE)[0]
    assert np.tan(theta) == pytest.approx(1 / np.sqrt(np.cos(beta)), rel=1e-13)
    phi = joint.output_angle(theta, beta=beta, pin=PIN_NORMAL_TO_PLANE)
    assert np.tan(phi) == pytest.approx(np.sqrt(np.cos(beta)), rel=1e-13)


def test_curves_at_4_5_deg_and_3600_rpm_match_wagner():
    """Souza (2014), figures 26-28: his eq. 6, 7, 8, as drawn with the pin normal.

    The extremes by hand: cos β = 0.996917, so 3600 rpm swings between 3588.90 and 3611.13,
    the lead is asin tan² 2.25 deg = 0.08845 deg, and near 45 deg the acceleration
    ω² sin²β cos β/(1 - sin²β/2)² = 142122 x 0.0061748 = 877.6 rad/s².
    """
    beta, w = 4.5 * deg, 3600 * rpm
    lag = np.arctan(np.tan(TURN) * np.cos(beta)) - np.arctan(np.tan(TURN))
    lead = joint.angle_lead(TURN, beta=beta, pin=PIN_NORMAL_TO_PLANE)
    assert lead == pytest.approx(lag, abs=1e-14)
    assert np.degrees(lead.max()) == printed("0.08845")
    speed = w * joint.speed_ratio(TURN, beta=beta, pin=PIN_NORMAL_TO_PLANE)
    slope = 1 - np.sin(TURN) ** 2 * np.sin(beta) ** 2
    assert speed == pytest.approx(w * np.cos(beta) / slope, rel=1e-14)
    assert [speed.min() / rpm, speed.max() / rpm] == [printed("3588.90"), printed("3611.13")]
    found = joint.output_acceleration(TURN, beta=beta, speed=w, pin=PIN_NORMAL_TO_PLANE)
    eq_8 = w**2 * np.cos(beta) * np.sin(beta) ** 2 * np.sin(2 * TURN) / slope**2
    assert found == pytest.approx(eq_8, abs=1e-9)
    largest = w**2 * joint.max_acceleration(beta)
    assert largest == printed("877.6")
    assert found.max() == pytest.approx(largest, rel=1e-5)  # a quarter degree off the peak


def test_speed_range_matches_textbook_problems():
    """25 deg at 100 rad/s; irregularity of 10 and 15 deg; the angle of 12.5 % in all."""
    low, high = joint.speed_range(25 * deg)
    assert 100 * high == printed("110.34")
    assert 100 * low == printed("90.63")
    assert 100 * joint.irregularity(10 * deg) == printed("3.062")
    assert 100 * joint.irregularity(15 * deg) == printed("6.935")
    assert joint.angle_for_irregularity(0.125) / deg == printed("20.04")
