"""Stress, ratings, sizes."""

import numpy as np
import pytest

from cardan.core.errors import DesignError
from cardan.core.units import MPa, deg, hour, mm, rpm
from cardan.model.layout import direction_from_slopes
from cardan.model.parts import JointSize
from cardan.physics.kinematics.joint_chain import rotate_chain
from cardan.physics.strength.bearing_life import (
    cross_joint_life_consumption_rate,
    joint_life,
    rated_torque_from_catalogue,
    speed_angle_product,
)
from cardan.physics.strength.torsional_strength import (
    JointTorqueAndDutyDemand,
    bearing_cup_pressure,
    cross_journal_force,
    joint_fatigue_utilisation,
    joint_size_utilisations,
    smallest_joint_size,
    tube_bending_stress,
    tube_fatigue_utilisation,
    tube_shear_stress,
    tube_utilisation,
    von_mises_stress,
)

SECTION = {"outer": 101.6 * mm, "inner": 95.2 * mm}


def test_shear_stress_of_thin_tube_matches_bredt():
    """τ = T/(2 A t) at the middle of the wall, and (r + t/2)/r of it outside."""
    outer, wall = 0.1, 1e-4
    r = (outer - wall) / 2
    bredt = 1000 / (2 * np.pi * r**2 * wall)
    found = tube_shear_stress(1000, outer=outer, inner=outer - 2 * wall)
    assert found == pytest.approx(bredt * (1 + wall / 2 / r), rel=1e-5)


def test_bending_stress_of_solid_bar_matches_textbook():
    """σ = 32 M/(π D³)."""
    assert tube_bending_stress(100, outer=0.05, inner=0) == pytest.approx(3200 / (np.pi * 0.05**3))


def test_tube_utilisation_is_one_at_yield_torque():
    """The torque at which τ = Re/√3 uses all of it; shocks count in full."""
    tau = 355 * MPa / np.sqrt(3)
    torque = tau / tube_shear_stress(1.0, **SECTION)
    used = tube_utilisation(
        [torque, -torque / 2], **SECTION, yield_strength=355 * MPa, shock_factor=[1, 1.5]
    )
    assert used == pytest.approx([1, 0.75])
    assert von_mises_stress(tau) == pytest.approx(355 * MPa)
    assert von_mises_stress(0, normal=-100) == 100


def test_tube_fatigue_utilisation_for_reversing_and_pulsating_torque():
    """Reversing uses all amplitude; pulsating half of it, and the mean where it counts."""
    endured = tube_shear_stress(4000, **SECTION)
    section = {**SECTION, "fatigue_shear": endured}
    assert tube_fatigue_utilisation(4000, lowest=-4000, **section) == pytest.approx(1)
    assert tube_fatigue_utilisation(4000, lowest=0, **section) == pytest.approx(0.5)
    counted = tube_fatigue_utilisation(4000, lowest=0, **section, ultimate_shear=4 * endured)
    assert counted == pytest.approx(0.5 + 0.125)
    assert tube_fatigue_utilisation(4000, lowest=4000, **section) == 0


def test_joint_fatigue_utilisation_is_one_at_each_rating():
    """At each rating, in its own kind of swing, all of it is used; steady torque in between."""
    ratings = {"reversing": 1000.0, "pulsating": 1400.0}
    assert joint_fatigue_utilisation(1000, lowest=-1000, **ratings) == pytest.approx(1)
    assert joint_fatigue_utilisation(1400, lowest=0, **ratings) == pytest.approx(1)
    assert joint_fatigue_utilisation(0, lowest=-1400, **ratings) == pytest.approx(1)
    assert joint_fatigue_utilisation([700, 500], lowest=[0, -500], **ratings) == pytest.approx(0.5)
    assert joint_fatigue_utilisation(800, lowest=0, reversing=1000) == pytest.approx(0.8)


@pytest.mark.parametrize("beta", [0, 5, 20, 35])
def test_cross_force_is_maximum_over_a_turn(beta):
    """The couple T [d₁ - a (a·d₁)]/(d₀·d₁) on the driven yoke, round a turn of the chain."""
    directions = direction_from_slopes(side=np.radians([0, beta]), top=np.zeros(2))
    pins = rotate_chain(directions, phases=np.zeros(0), samples=64).driving_pins[0]
    d0, d1 = directions
    couple = (d1 - pins * (pins @ d1)[:, None]) / (d0 @ d1)
    largest = np.linalg.norm(couple, axis=-1).max() * 1000 / 0.08
    assert cross_journal_force(1000, across=80 * mm, angle=beta * deg) == pytest.approx(largest)


def test_cup_pressure_is_force_over_projected_area():
    force = cross_journal_force([1000, 2000], across=0.1)
    assert bearing_cup_pressure(force, diameter=0.03, length=0.02) / 1e6 == pytest.approx(
        [50 / 3, 100 / 3]
    )


SIZES = (
    JointSize(
        name="large", peak_torque=17e3, bearing_torque=3500, speed_angle_max=19e3 * rpm * deg
    ),
    JointSize(name="small", peak_torque=5e3, bearing_torque=1000, angle_max=25 * deg),
    JointSize(name="medium", peak_torque=10e3, bearing_factor=1.5e-4 * 2 ** (10 / 3)),
    JointSize(name="unrated", peak_torque=1e6),
)


def demand(**given):
    """Return a demand on a joint: two points of a duty cycle."""
    return JointTorqueAndDutyDemand(
        **{
            "peak_torque": 4000.0,
            "torque": np.array([600.0, 200.0]),
            "speed": np.array([1000.0, 2000.0]) * rpm,
            "angle": np.array([5.0, 4.0]) * deg,
            "shares": np.array([0.3, 0.7]),
            "life": 2000 * hour,
            "prime_mover_factor": 1.25,
            **given,
        }
    )


def test_size_is_evaluated_only_against_published_ratings():
    """Each rating by itself; what is not published is not judged."""
    asked = demand()
    used = joint_size_utilisations(SIZES[1], asked)
    assert used.keys() == {"joint_torque_utilisation", "joint_angle", "joint_life"}
    assert used["joint_torque_utilisation"] == pytest.approx(0.8)
    assert used["joint_angle"] == pytest.approx(0.2)
    each = 1.5e6 * hour / (np.array([5000, 8000])) * (1000 / asked.torque) ** (10 / 3) / 1.25
    assert used["joint_life"] == pytest.approx(2000 * hour * (asked.shares / each).sum())
    assert joint_size_utilisations(SIZES[0], asked)["n_beta"] == pytest.approx(8000 / 19000)


def test_smallest_sufficient_joint_size_is_selected():
    """Small for a small demand; the next for more peak, or for more life, or for more angle."""
    assert rated_torque_from_catalogue(SIZES[2]) == pytest.approx(2000)
    assert smallest_joint_size(SIZES, demand()).name == "small"
    assert smallest_joint_size(SIZES, demand(peak_torque=6000.0)).name == "medium"
    assert smallest_joint_size(SIZES, demand(life=2e4 * hour)).name == "medium"
    assert smallest_joint_size(SIZES, demand(angle=np.array([26, 4]) * deg)).name == "medium"
    assert smallest_joint_size(SIZES, demand(peak_torque=16e3)).name == "large"


def test_no_sufficient_size_reports_missing_rating():
    with pytest.raises(DesignError, match=r"none of 3 joints.*large.*1\.18 times its joint torque"):
        smallest_joint_size(SIZES, demand(peak_torque=20e3))
    with pytest.raises(DesignError, match="no joint on offer publishes"):
        smallest_joint_size(SIZES[3:], demand())


def test_duty_cycle_wear_is_additive():
    """1/L = Σ p/L; rest wears nothing; more than all of the time is refused."""
    used = cross_joint_life_consumption_rate(
        [500.0, 0.0, 500.0], speed=[100.0, 100.0, 0.0], angle=0.1, rated_torque=2000.0,
        prime_mover_factor=1.0,
    )  # fmt: skip
    assert used[1:].tolist() == [0, 0]
    assert np.isinf(joint_life(used)[1])
    assert joint_life(used, shares=[0.25, 0.75, 0.0]) == pytest.approx(4 / used[0])
    assert joint_life(used, shares=[0.25, 0, 0]) == pytest.approx(4 / used[0])
    with pytest.raises(ValueError, match=r"at most 1, got 1\.2"):
        joint_life(used, shares=[0.5, 0.5, 0.2])


def test_n_beta_is_speed_times_angle():
    assert speed_angle_product([-1500 * rpm], angle=5 * deg) / (rpm * deg) == pytest.approx([7500])
