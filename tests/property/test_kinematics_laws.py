"""Laws of joints and lines that hold whatever their layout."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from cardan.core.units import deg
from cardan.model.layout import (
    direction_from_slopes,
    layout_from_joint_angles,
    layout_from_points,
    layout_from_slopes,
    unit_vector,
)
from cardan.physics.kinematics import hooke_joint as joint
from cardan.physics.kinematics.equivalent_angle import ae7_excitation, excitation_of_rotating_chain
from cardan.physics.kinematics.joint_chain import dot_product, rotate_chain

modest = settings(max_examples=40)

betas = st.floats(0, 80 * deg)
pins = st.sampled_from([joint.PIN_IN_PLANE, joint.PIN_NORMAL_TO_PLANE])
angles = st.floats(-15 * deg, 15 * deg)
phases = st.floats(-np.pi, np.pi)


@st.composite
def lines(draw):
    """Side and top slopes of the members, yoke phases and lengths of the shafts."""
    n = draw(st.integers(2, 5))
    views = arrays(float, n + 1, elements=angles)
    shafts = arrays(float, n - 1, elements=st.floats(0.3, 2.5))
    return draw(views), draw(views), draw(arrays(float, n - 1, elements=phases)), draw(shafts)


def excitations(line, **kwargs):
    side, top, yokes, _ = line
    return excitation_of_rotating_chain(
        rotate_chain(direction_from_slopes(side=side, top=top), phases=yokes), speed=1.0, **kwargs
    )


def numbers(found):
    return np.array(
        [
            found.torsional.acceleration,
            found.drive.acceleration,
            found.coast.acceleration,
            found.irregularity,
        ]
    )


@modest
@given(beta=betas, pin=pins)
def test_joint_output_completes_one_turn_per_input_turn(beta, pin):
    theta = np.linspace(0, 2 * np.pi, 256, endpoint=False)
    assert abs(joint.speed_ratio(theta, beta=beta, pin=pin).mean() - 1) < 1e-12
    once = joint.output_angle(theta + 2 * np.pi, beta=beta, pin=pin)
    assert abs(once - 2 * np.pi - joint.output_angle(theta, beta=beta, pin=pin)).max() < 1e-13


@modest
@given(beta=betas, pin=pins, start=st.floats(-1e4, 1e4))
def test_joint_output_is_continuous(beta, pin, start):
    """Over a step h it gains at most h/cos β and at least h cos β, turn after turn."""
    h = 1e-3
    theta = start + h * np.arange(20_000)
    gained = np.diff(joint.output_angle(theta, beta=beta, pin=pin))
    slack = 1e-11 + 4e-16 * abs(start)
    assert gained.max() < h / np.cos(beta) + slack
    assert gained.min() > h * np.cos(beta) - slack


@modest
@given(beta=st.floats(0, 79 * deg), more=st.floats(1e-3, 0.01))
def test_larger_angle_increases_irregularity(beta, more):
    assert joint.irregularity(beta + more) > joint.irregularity(beta)
    assert joint.max_acceleration(beta + more) > joint.max_acceleration(beta)
    assert joint.angle_lead_amplitude(beta + more) > joint.angle_lead_amplitude(beta)


@modest
@given(beta=betas, theta=st.floats(-100, 100))
def test_reversed_joint_inverts_output_angle(beta, theta):
    """What comes out, sent back through the same cross, comes out as it went in."""
    out = joint.output_angle(theta, beta=beta, pin=joint.PIN_IN_PLANE)
    back = joint.output_angle(out, beta=beta, pin=joint.PIN_NORMAL_TO_PLANE)
    assert back == pytest.approx(theta, abs=1e-11)


@modest
@given(line=lines())
def test_line_output_completes_one_turn_per_input_turn(line):
    side, top, yokes, _ = line
    found = rotate_chain(direction_from_slopes(side=side, top=top), phases=yokes)
    assert abs(found.speed.mean(-1) - 1).max() < 1e-12
    assert abs(found.lead.mean(-1)).max() < 1e-12
    assert abs(found.lead).max() < np.pi / 2


@modest
@given(line=lines())
def test_input_power_equals_output_power(line):
    """Torque from the moments on the crosses, which know nothing of speed."""
    side, top, yokes, _ = line
    d = direction_from_slopes(side=side, top=top)
    found = rotate_chain(d, phases=yokes)
    u, v = d[:-1, None], d[1:, None]
    across = dot_product(found.driving_pins, v)
    torque = np.cumprod((1 - across**2) / dot_product(u, v), axis=0)
    assert abs(torque * found.speed - 1).max() < 1e-12


@modest
@given(beta=angles, skew=st.floats(-np.pi, np.pi), roll=st.floats(0, np.pi))
def test_two_matched_joints_cancel_irregularity(beta, skew, roll):
    """Equal angles in planes `skew` apart, and yokes turned by as much, leave no swing."""
    before = np.array([[1.0, 0, 0], [np.cos(beta), np.sin(beta), 0]])
    along = before[1]
    c, s = np.cos(skew), np.sin(skew)
    # Bent back, member 2 is member 0 again; turned about the shaft, its plane is `skew` on.
    first = before[0]
    last = c * first + s * np.cross(along, first) + (1 - c) * (along @ first) * along
    d = np.vstack([before, last])
    c, s = np.cos(roll), np.sin(roll)
    d = d @ np.array([[1, 0, 0], [0, c, s], [0, -s, c]])
    found = rotate_chain(d, phases=[skew])
    assert abs(found.lead[-1]).max() < 1e-14
    assert abs(found.phasors[-1]) < 1e-15


@modest
@given(line=lines())
def test_mirrored_line_has_equal_excitation(line):
    side, top, yokes, lengths = line
    mirrored = side, -top, -yokes, lengths
    assert numbers(excitations(mirrored)) == pytest.approx(
        numbers(excitations(line)), rel=1e-9, abs=1e-13
    )


@modest
@given(line=lines(), roll=st.floats(-np.pi, np.pi), yaw=st.floats(-1, 1))
def test_orientation_of_line_does_not_change_excitation(line, roll, yaw):
    side, top, yokes, _ = line
    d = direction_from_slopes(side=side, top=top)
    c, s = np.cos(roll), np.sin(roll)
    turned = d @ np.array([[1, 0, 0], [0, c, s], [0, -s, c]])
    c, s = np.cos(yaw), np.sin(yaw)
    turned = turned @ np.array([[c, s, 0], [-s, c, 0], [0, 0, 1]])
    here = excitation_of_rotating_chain(rotate_chain(d, phases=yokes), speed=1.0)
    there = excitation_of_rotating_chain(rotate_chain(turned, phases=yokes), speed=1.0)
    assert numbers(there) == pytest.approx(numbers(here), rel=1e-9, abs=1e-13)


@modest
@given(line=lines(), k=st.integers(0, 3), half=st.sampled_from([-np.pi, np.pi]))
def test_yoke_turned_by_180_deg_gives_equal_excitation(line, k, half):
    """Half a turn of one yoke on its shaft changes nothing."""
    side, top, yokes, lengths = line
    other = yokes.copy()
    other[k % len(yokes)] += half
    assert numbers(excitations((side, top, other, lengths))) == pytest.approx(
        numbers(excitations(line)), rel=1e-9, abs=1e-13
    )


@modest
@given(line=lines())
def test_slopes_points_and_joint_angles_give_equal_kinematics(line):
    side, top, yokes, lengths = line
    side, top = side - side[0], top - top[0]  # joint angles start from a level gearbox
    slopes = layout_from_slopes(side=side, top=top, lengths=lengths)
    views = layout_from_joint_angles(side=np.diff(side), top=np.diff(top), lengths=lengths)
    gearbox, pinion = slopes.directions[0], slopes.directions[-1]
    points = layout_from_points(slopes.points, gearbox=3 * gearbox, pinion=0.2 * pinion)
    first, *others = (rotate_chain(way.directions, phases=yokes) for way in (slopes, views, points))
    for other in others:
        assert abs(other.lead - first.lead).max() < 1e-13
        assert abs(other.driving_pins - first.driving_pins).max() < 1e-13


@modest
@given(line=lines(), scale=st.floats(0.01, 0.05))
def test_ae7_is_small_angle_limit(line, scale):
    """It leaves out terms β² times β²: here at most (n joints x 30 deg x scale)⁴."""
    side, top, yokes, _ = line
    side, top = scale * side, scale * top
    exact = excitation_of_rotating_chain(
        rotate_chain(direction_from_slopes(side=side, top=top), phases=yokes), speed=1.0
    )
    near = ae7_excitation(np.diff(side), np.diff(top), phases=yokes, speed=1.0)
    bound = 2 * (len(yokes) + 1) * (len(side) * 42 * deg * scale) ** 4
    for kind in ("torsional", "drive", "coast"):
        gap = getattr(exact, kind).acceleration - getattr(near, kind).acceleration
        assert abs(gap) < bound


@modest
@given(line=lines(), factor=st.floats(0.1, 10))
def test_inertia_torque_is_linear_in_the_inertias(line, factor):
    inertias = np.linspace(0.05, 0.2, len(line[2]))
    one = excitations(line, inertias=inertias)
    more = excitations(line, inertias=factor * inertias)
    assert more.drive_torque == pytest.approx(factor * one.drive_torque, rel=1e-9, abs=1e-15)
    even = excitations(line, inertias=np.full(len(inertias), factor))
    assert even.coast_torque == pytest.approx(factor * even.coast.acceleration, rel=1e-9, abs=1e-15)


@modest
@given(way=arrays(float, (4, 3), elements=st.floats(-0.5, 0.5)))
def test_joints_are_straight_if_all_shafts_are_parallel(way):
    d = unit_vector(np.array([1.0, 0, 0]) + way[:1].repeat(4, axis=0))
    assert abs(rotate_chain(d, phases=[0.1, 0.2]).speed - 1).max() < 1e-14
