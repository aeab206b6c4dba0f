"""The chain against pin axes followed as plain vectors, joint by joint."""

import numpy as np
import pytest

from cardan.core.errors import DesignError
from cardan.core.units import deg
from cardan.model.layout import direction_from_slopes, unit_vector
from cardan.physics.kinematics import hooke_joint as joint
from cardan.physics.kinematics.joint_chain import (
    cross_product,
    dot_product,
    joint_angles,
    order_amplitudes,
    rotate_chain,
)

RNG = np.random.default_rng(20)


def chains(joints, spread, cases=7):
    """Return directions (cases, n+1, 3) within a cone, and any yoke phases."""
    way = np.array([1.0, 0, 0]) + spread * RNG.uniform(-1, 1, (cases, joints + 1, 3))
    return unit_vector(way), RNG.uniform(-np.pi, np.pi, (cases, joints - 1))


def followed(directions, phases, theta):
    """Pin axes and speeds by vectors: b = d x a, and the cross's normal a x b hands on speed."""
    d = directions[..., None, :]
    right = unit_vector(np.cross([0, 0, 1.0], d[..., 0, :, :]))
    up = np.cross(d[..., 0, :, :], right)
    a = np.cos(theta)[:, None] * right + np.sin(theta)[:, None] * up
    speed, pins, driven, speeds = 1.0, [], [], []
    for k in range(1, directions.shape[-2]):
        before, after = d[..., k - 1, :, :], d[..., k, :, :]
        b = unit_vector(np.cross(after, a))
        normal = np.cross(a, b)
        speed = speed * (normal * before).sum(-1) / (normal * after).sum(-1)
        pins.append(a)
        driven.append(b)
        speeds.append(speed)
        if k < directions.shape[-2] - 1:
            phase = phases[..., k - 1, None, None]
            a = b * np.cos(phase) + np.cross(after, b) * np.sin(phase)
    return (np.stack(x, axis=1) for x in (pins, driven, speeds))


@pytest.mark.parametrize(("joints", "spread"), [(1, 0.4), (2, 0.3), (3, 0.1), (4, 0.35), (6, 0.3)])
def test_pins_speeds_and_rotations_are_those_of_the_vectors(joints, spread):
    d, phases = chains(joints, spread)
    found = rotate_chain(d, phases=phases, samples=32)
    pins, driven, speeds = followed(d, phases, found.theta)
    assert abs(found.driving_pins - pins).max() < 1e-13
    assert abs(found.speed / speeds - 1).max() < 1e-12
    # Members rotate as their driven pins do: the angle from the first sample, about d.
    first, along = driven[..., :1, :], d[:, 1:, None, :]
    angle = np.arctan2((np.cross(first, driven) * along).sum(-1), (first * driven).sum(-1))
    turned = found.theta + found.lead - found.lead[..., :1]
    assert abs(np.exp(1j * angle) - np.exp(1j * turned)).max() < 1e-13


def slope(values):
    """Derivative by the angle of a whole turn's samples, spectrally."""
    n = values.shape[-1]
    return np.fft.ifft(np.fft.fft(values) * 1j * np.fft.fftfreq(n, 1 / n)).real


def test_acceleration_is_the_slope_of_speed():
    d, phases = chains(4, 0.3)
    found = rotate_chain(d, phases=phases, samples=256)
    assert found.acceleration == pytest.approx(slope(found.speed), abs=1e-11)


def test_in_coast_time_runs_with_the_pinion():
    d, phases = chains(3, 0.2)
    found = rotate_chain(d, phases=phases, samples=256)
    pinion = found.speed[:, -1:]
    by_pinion = slope(found.speed / pinion) / pinion
    assert found.coast_acceleration == pytest.approx(by_pinion, abs=1e-11)
    assert abs(found.coast_acceleration[:, -1]).max() < 1e-13


def test_one_joint_is_the_joint_of_the_book():
    side = 20 * deg
    found = rotate_chain(direction_from_slopes(side=[0, side], top=[0, 0]), phases=[])
    # Bent downwards, the plane is vertical and the horizontal pin is normal to it.
    theta = found.theta
    assert found.lead[0] == pytest.approx(
        joint.angle_lead(theta, beta=side, pin=joint.PIN_NORMAL_TO_PLANE), abs=1e-15
    )
    assert found.speed[0] == pytest.approx(
        joint.speed_ratio(theta, beta=side, pin=joint.PIN_NORMAL_TO_PLANE), abs=1e-14
    )
    assert found.acceleration[0] == pytest.approx(
        joint.output_acceleration(theta, beta=side, speed=1.0, pin=joint.PIN_NORMAL_TO_PLANE),
        abs=1e-14,
    )


def test_the_turn_starts_with_a_horizontal_pin_to_the_right():
    d, phases = chains(2, 0.4)
    pin = rotate_chain(d, phases=phases).driving_pins[:, 0, 0]
    assert abs(pin[:, 2]).max() < 1e-15
    assert pin[:, 1].min() > 0


def test_a_straight_chain_turns_uniformly():
    found = rotate_chain(
        direction_from_slopes(side=np.full(4, 0.02), top=np.full(4, -0.01)), phases=[0.3, 1.2]
    )
    assert abs(found.phasors).max() < 1e-30
    assert found.speed == pytest.approx(np.ones((3, 64)), abs=1e-15)


def test_cases_and_phases_broadcast():
    d, phases = chains(3, 0.2, cases=4)
    both = rotate_chain(d[:, None], phases=phases[None, :2])
    assert both.phasors.shape == (4, 2, 3)
    assert both.driving_pins.shape == (4, 2, 3, 64, 3)
    assert both.speed[3, 1] == pytest.approx(rotate_chain(d[3], phases=phases[1]).speed, rel=1e-15)


def test_a_locked_joint_says_which_and_by_how_much():
    d = unit_vector([[1, 0, 0], [1, 0.1, 0], [-0.2, 1, 0], [0, 1, 0]])
    with pytest.raises(DesignError, match=r"joint 2 locks: .* below 90 deg, got 95\.6 deg"):
        rotate_chain(d, phases=[0, 0])


def test_joint_angles_are_exact_at_every_size():
    angles = np.array([1e-9, 1e-3, 0.5, 1.5, 3.0])
    d = np.stack([np.cos(angles), np.sin(angles), 0 * angles], axis=-1)[:, None]
    d = np.concatenate([np.broadcast_to([1.0, 0, 0], d.shape), d], axis=1)
    assert joint_angles(d)[:, 0] == pytest.approx(angles, rel=1e-13)


def test_products_of_vectors():
    a, b = RNG.normal(size=(2, 5, 4, 3))
    assert cross_product(a, b) == pytest.approx(np.cross(a, b), abs=1e-15)
    assert dot_product(a, b) == pytest.approx((a * b).sum(-1), abs=1e-14)


def test_orders_take_a_turn_apart():
    theta = rotate_chain(direction_from_slopes(side=[0, 0.1], top=[0, 0]), phases=[]).theta
    values = 3 + 2 * np.cos(2 * theta - 0.5) + 0.25 * np.sin(4 * theta)
    found = order_amplitudes(np.stack([values, -values]))
    assert found.shape == (2, 5)
    assert found[0] == pytest.approx([3, 0, 2 * np.exp(-0.5j), 0, -0.25j], abs=1e-15)
    assert order_amplitudes(values[:, None], axis=0)[2, 0] == pytest.approx(found[0, 2], abs=1e-15)
