"""Joints of other kinds in a chain: against vectors alone, by hand, and another program's table.

The bearing forces of the table were found by virtual work through bare kinematics too, to 2e-7
of 50 N.
"""

from itertools import product

import numpy as np
import pytest

from cardan.core.units import deg, hour, rpm
from cardan.model.layout import layout_from_slopes
from cardan.model.parts import CentreBearing, JointSize, Line, Shaft, Tube
from cardan.physics.kinematics.equivalent_angle import ae7_excitation, excitation_of_rotating_chain
from cardan.physics.kinematics.joint_chain import rotate_chain
from cardan.physics.loads.centre_bearing import bearing_forces
from cardan.physics.loads.mounted_line_model import mounted_line
from cardan.physics.loads.small_angle import small_angle_bearing_forces
from cardan.physics.loads.statics import joint_loads
from cardan.physics.strength.bearing_life import (
    cross_joint_life_consumption_rate,
    joint_life,
    life_consumption_rate,
)

LAYOUT = layout_from_slopes(
    side=np.array([3.0, 1.0, 4.5, 2.0]) * deg, top=np.array([0.0, 1.5, -0.8, 0.6]) * deg,
    lengths=[1.2, 1.5],
)  # fmt: skip
SIZES = {"C": JointSize(name="c", kind="rzeppa"), "H": JointSize(name="h")}


def line(kinds, phases=(0.0, 0.0), **bearing):
    tube = Tube(outer=0.1016, wall=0.0034)
    return Line(
        shafts=(
            Shaft(length=1.2, centre_bearing=CentreBearing(**bearing), phase=phases[0], tube=tube),
            Shaft(length=1.5, phase=phases[1], tube=tube),
        ),
        joints=tuple(SIZES[k] for k in kinds),
    )  # fmt: skip


def shortest(u, v, w):
    """Vector w carried from u to v by the shortest turn."""
    axis = np.cross(u, v)
    return w + np.cross(axis, w) + np.cross(axis, np.cross(axis, w)) / (1 + u @ v)


def by_vectors(kinds, phases, samples=64):
    """Speeds of the members, and moments of the joints for 1 N m, (samples, n) and (.., n, 3)."""
    d = LAYOUT.directions
    level = np.array([0.0, 1.0, 0.0]) - d[0] * d[0, 1]
    level /= np.linalg.norm(level)
    speeds, moments = [], []
    for theta in 2 * np.pi * np.arange(samples) / samples:
        a = np.cos(theta) * level + np.sin(theta) * np.cross(d[0], level)
        speed, ratios, made = 1.0, [], []
        for k, kind in enumerate(kinds):
            u, v = d[k], d[k + 1]
            torque = 1 / speed
            if kind == "H":
                b = np.cross(v, a) / np.linalg.norm(np.cross(v, a))
                normal = np.cross(a, b)
                speed *= (normal @ u) / (normal @ v)
                made.append(torque * (v - a * (a @ v)) / (u @ v))
            else:
                b = shortest(u, v, a)
                made.append(torque * (u + v) / (1 + u @ v))
            ratios.append(speed)
            if k < len(phases):
                a = np.cos(phases[k]) * b + np.sin(phases[k]) * np.cross(v, b)
        speeds.append(ratios)
        moments.append(made)
    return np.array(speeds), np.array(moments)


@pytest.mark.parametrize("kinds", ["".join(k) for k in product("CH", repeat=3)])
@pytest.mark.parametrize("phases", [(0.0, 0.0), (0.4, -1.1)])
def test_rotation_and_forces_match_vector_calculation(kinds, phases):
    of = line(kinds, phases)
    found = rotate_chain(LAYOUT.directions, phases=of.phases, crosses=of.is_cross, samples=64)
    speeds, moments = by_vectors(kinds, phases)
    # Both start with a level pin.
    np.testing.assert_allclose(found.speed.T, speeds, atol=1e-13)
    carried = joint_loads(LAYOUT, found, of, torque=1.0)
    spectrum = np.fft.rfft(moments, axis=0) / 64
    np.testing.assert_allclose(carried.joint_moments.order(0), spectrum[0].real, atol=1e-13)
    np.testing.assert_allclose(carried.joint_moments.order(2), 2 * spectrum[2], atol=1e-13)
    # Every other order is 0: the moments are these two alone.
    assert np.abs(spectrum[[1, 3, 4, 5, 6]]).max() < 1e-14


@pytest.mark.parametrize(
    ("kinds", "static", "dynamic", "angle"),
    [
        ("HHH", 5.1391, 20.0899, 1.80014),
        ("CHH", 5.1624, 38.2619, 3.08007),
        ("HCH", 5.1302, 2.8143, 1.65393),
        ("HHC", 5.1552, 36.7355, 3.37048),
        ("CCC", 5.1256, 0.0, 0.0),
    ],
)
def test_bearing_force_and_pinion_motion_match_table(kinds, static, dynamic, angle):
    of = line(kinds)
    found = rotate_chain(LAYOUT.directions, phases=of.phases, crosses=of.is_cross)
    force = joint_loads(LAYOUT, found, of, torque=1000.0).bearing_forces
    assert np.linalg.norm(force.static) == pytest.approx(static, abs=5e-5)
    assert float(force.dynamic[0]) == pytest.approx(dynamic, abs=5e-5)
    exact = excitation_of_rotating_chain(found, speed=1.0).torsional.angle / deg
    assert exact == pytest.approx(angle, abs=5e-6)
    # The small angle's formulas, without what keeps the speed: short by β², here 2e-3 of a force
    # and of an angle; where two nearly cancel, of either.
    small = small_angle_bearing_forces(LAYOUT, of, torque=1000.0)
    assert np.linalg.norm(small.static) == pytest.approx(static, rel=1e-2)
    assert float(small.dynamic[0]) == pytest.approx(dynamic, abs=0.06)
    kind = np.array(of.is_cross)
    side, top = np.diff(LAYOUT.side) * kind, np.diff(LAYOUT.top) * kind
    quarter = np.array(of.phases) - (1 - kind[:-1]) * np.pi / 2
    approximate = ae7_excitation(side, top, phases=quarter, speed=1.0).torsional.angle / deg
    assert approximate == pytest.approx(angle, abs=0.004)


def test_only_phase_sum_across_constant_velocity_joint_counts():
    """Of a joint between two shafts that keeps the speed."""
    found = [
        rotate_chain(LAYOUT.directions, phases=phases, crosses=(1, 0, 1)).phasors[-1]
        for phases in ((0.3, 0.5), (0.8, 0.0), (-0.2, 1.0))
    ]
    np.testing.assert_allclose(found, found[0], atol=1e-15)
    crossed = rotate_chain(LAYOUT.directions, phases=(0.3, 0.6), crosses=(1, 0, 1)).phasors[-1]
    assert abs(crossed - found[0]) > 1e-4


def test_constant_velocity_line_on_rubber_has_no_order_2():
    """Slowly it is statics; with no cross no order 2 is left at any speed."""
    stiff = {"stiffness": (200e3, 120e3), "loss_factor": 0.1}
    for kinds in ("HCH", "CCC"):
        of = line(kinds, **stiff)
        held = mounted_line(LAYOUT, of, stiffness=np.array([[200e3, 120e3, 0.0]]))
        slow, fast = (
            bearing_forces(LAYOUT, of, of.phases, torque=10.0, speed=w, held=held)
            for w in (1e-3, 55.0)
        )
        turned = rotate_chain(
            LAYOUT.directions, phases=of.phases_under_torque(of.phases, 10.0), crosses=of.is_cross
        )
        still = joint_loads(LAYOUT, turned, of, torque=10.0).bearing_forces
        np.testing.assert_allclose(
            slow.order_amplitudes[0, 0], still.dynamic[0], rtol=1e-3, atol=1e-12
        )
        if kinds == "CCC":
            assert np.abs(fast.waves).max() < 1e-12
        else:
            assert fast.order_amplitudes[0, 0] > 2 * slow.order_amplitudes[0, 0]


def test_life_of_other_joint_kinds_matches_hand_calculation():
    """B10 of each kind at 1000 rpm, 6 deg and half the rated torque."""
    at = {"torque": 500.0, "speed": 1000 * rpm, "angle": 6 * deg}
    rated = {"bearing_torque": 1000.0, "rated_life": 1500 * hour, "rated_speed": 500 * rpm,
             "rated_angle": 3 * deg}  # fmt: skip

    def hours(size):
        return float(joint_life(life_consumption_rate(size, **at))) / hour

    # The rated hours, half for twice the speed, 2³ for half the torque, (A(6)/A(3))³.
    share = (1 - np.sin(6 * deg)) * np.cos(6 * deg) ** 2 / (1 - np.sin(3 * deg))
    share /= np.cos(3 * deg) ** 2
    rzeppa = JointSize(name="r", kind="rzeppa", **rated)
    assert hours(rzeppa) == pytest.approx(1500 / 2 * 8 * share**3, rel=1e-12)
    # Rollers: 2^(10/3), and half for twice the angle.
    tripod = JointSize(name="t", kind="tripod", **rated)
    assert hours(tripod) == pytest.approx(1500 / 2 * 2 ** (10 / 3) / 2, rel=1e-12)
    # Two crosses of half the angle, which is the least that counts: twice one cross's life.
    double = JointSize(name="d", kind="double cardan", bearing_torque=1000.0)
    cross = cross_joint_life_consumption_rate(**at, rated_torque=1000.0, prime_mover_factor=1.0)
    assert hours(double) == pytest.approx(2 * float(joint_life(cross)) / hour, rel=1e-12)
    assert np.isnan(
        life_consumption_rate(JointSize(name="n", kind="rzeppa", bearing_torque=1e3), **at)
    )
