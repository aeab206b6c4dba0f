"""A line whose spline friction holds: two masses with one length, by closed form and in time."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.linalg import eigh, null_space
from test_spline_thrust import GVW, LINE, RESPONSE, STIFFNESS, TORQUE

from cardan.physics.kinematics.joint_chain import rotate_chain
from cardan.physics.loads.mounted_line_model import mounted_line
from cardan.physics.loads.statics import joint_loads
from cardan.physics.loads.stuck_spline import (
    COMPONENT_COUNT,
    StuckLine,
    followed_stuck_motion,
    stiffness_of_orders,
)
from cardan.physics.loads.stuck_spline_estimate import held_line_frequencies, held_line_wave

MASS, STIFF, DAMPED = np.array([20.0, 25.0]), np.array([200e3, 120e3]), np.array([600.0, 400.0])
SPEEDS = np.linspace(20.0, 60.0, 41)
"""rad/s: order 2 passes the modes of both masses, 15.9 and 11.0 Hz."""

GEOMETRIC = np.diag([2.0, 3.0])


def two_masses(
    gradient, force, *, geometric=GEOMETRIC, compression=0.0, speeds=SPEEDS
) -> StuckLine:
    """Return two masses on springs and dampers, pushed at order 2, with a spline between them."""
    M = COMPONENT_COUNT
    linear = np.zeros((len(speeds), 1, M, 2, M, 2))
    push = np.zeros((len(speeds), 1, M, 2))
    push[:, 0, 1] = force
    for k, speed in enumerate(speeds):
        for order in range(M // 2 + 1):
            W = 2 * order * speed
            D = np.diag(STIFF - W**2 * MASS + 1j * W * DAMPED)
            if not order:
                linear[k, 0, 0, :, 0, :] = D.real
                continue
            r, i = 2 * order - 1, 2 * order
            linear[k, 0, r, :, r, :] = linear[k, 0, i, :, i, :] = D.real
            linear[k, 0, r, :, i, :], linear[k, 0, i, :, r, :] = -D.imag, D.imag
    rest = np.linalg.solve(
        np.diag(STIFF) - compression * geometric, compression * np.asarray(gradient)
    )
    shape = (len(speeds), 1, 2)
    return StuckLine(
        linear=linear,
        push=push,
        spline=np.broadcast_to(np.asarray(gradient, dtype=float), shape),
        geometric=geometric[None],
        rest=np.broadcast_to(rest, shape),
        compression=np.full((len(speeds), 1), compression),
    )


def test_two_masses_of_one_length_move_as_closed_form():
    """g1 x1 + g2 x2 = 0 leaves one mode: x = z F z / (z K z - W² z M z + i W z C z), z across g."""
    g, force = np.array([0.6, -0.8]), np.array([300.0, 100.0])
    found = followed_stuck_motion(two_masses(g, force, geometric=np.zeros((2, 2))))
    z, W = np.array([0.8, 0.6]), 2 * SPEEDS
    one = (z @ force) / (z**2 @ STIFF - W**2 * (z**2 @ MASS) + 1j * W * (z**2 @ DAMPED))
    x = found.coordinates[:, 0, 1] + 1j * found.coordinates[:, 0, 2]
    assert found.is_found.all()
    assert x == pytest.approx(one[:, None] * z, rel=1e-9, abs=1e-12)
    # The thrust is what either mass is short of: D x = F + P g.
    left = (STIFF - W[:, None] ** 2 * MASS + 1j * W[:, None] * DAMPED) * x - force
    P = found.compression[:, 0, 1] + 1j * found.compression[:, 0, 2]
    assert pytest.approx(left @ g, rel=1e-9) == P
    assert found.largest_thrust[:, 0] == pytest.approx(np.abs(P), rel=0.05)


@pytest.mark.parametrize("compression", [0.0, 15e3, -15e3])
def test_motion_of_curved_length_matches_integration_in_time(compression):
    """g'x + x'G x/2 held: its second term draws the spline and stiffens the masses.

    In time the length is a spring of 5e10 N/m with a damper. Resonance, swings of 13 mm.
    """
    g, force, speed = np.array([0.05, 0.02]), np.array([0.0, 620.0]), 34.8
    line = two_masses(g, force, compression=compression, speeds=np.linspace(25.0, speed, 12))
    found = followed_stuck_motion(line)
    assert found.is_found.all()
    rest = line.rest[0, 0]

    def length(x):
        return g @ x + x @ GEOMETRIC @ x / 2

    held, firm, W = length(rest), 5e10, 2 * speed

    def motion(t, state):
        x, v = state[:2], state[2:]
        slope = g + GEOMETRIC @ x
        P = compression - firm * (length(x) - held) - 3e6 * (slope @ v)
        return np.concatenate([
            v, (force * np.cos(W * t) - STIFF * x - DAMPED * v + P * slope) / MASS
        ])  # fmt: skip

    end = 40 * 2 * np.pi / W
    times = end - 2 * np.pi / W * np.arange(64)[::-1] / 64
    done = solve_ivp(
        motion, (0, end), [*rest, 0, 0], t_eval=times, method="LSODA", rtol=1e-6, atol=1e-9
    )
    wave = 2 * (done.y[:2] * np.exp(-1j * W * done.t)).mean(axis=1)
    x = found.coordinates[-1, 0, 1] + 1j * found.coordinates[-1, 0, 2]
    assert np.abs(x[1]) == pytest.approx(np.abs(wave[1]), rel=0.01)
    assert found.coordinates[-1, 0, 0] == pytest.approx(done.y[:2].mean(axis=1), rel=0.02, abs=1e-4)
    by_slope_alone = followed_stuck_motion(
        two_masses(g + GEOMETRIC @ rest, force, geometric=np.zeros((2, 2)), speeds=[speed])
    )
    if not compression:  # what the second term makes
        assert np.abs(by_slope_alone.coordinates[0, 0, 1:3, 1]).max() > 1.08 * np.abs(wave[1])


@pytest.mark.parametrize("speed", [25.0, -25.0])
def test_line_whose_spline_slides_moves_as_harmonic_balance_has_it(speed):
    """Orders 0, 2 and 4 without thrust; here order 6 answers too."""
    held = mounted_line(GVW, LINE, stiffness=STIFFNESS, sines=0)
    turned = rotate_chain(GVW.directions, phases=RESPONSE.phases[2], samples=16)
    moments = joint_loads(GVW, turned, LINE, torque=TORQUE).joint_moments
    pushes = [held.forces_from_joint_moments(moments.order(k)) for k in (0, 2, 4)]
    coupling = held.order2_coupling(turned)
    both = np.array(speed), np.array(TORQUE)
    still, twice, fourth = held.harmonic_balance(pushes, coupling, speed=both[0], torque=both[1])
    N = len(held.mass)
    linear = stiffness_of_orders(held, coupling, speed=both[0], torque=both[1])
    push = np.zeros((COMPONENT_COUNT, N))
    push[0], push[1], push[2] = pushes[0].real, pushes[1].real, pushes[1].imag
    push[3], push[4] = pushes[2].real, pushes[2].imag
    flat = COMPONENT_COUNT * N
    x = np.linalg.solve(linear.reshape(flat, flat), push.reshape(flat)).reshape(push.shape)
    assert x[0] == pytest.approx(still.coordinates.real, rel=1e-3, abs=1e-6)
    assert x[1] + 1j * x[2] == pytest.approx(twice.coordinates, rel=1e-3, abs=1e-6)
    assert x[3] + 1j * x[4] == pytest.approx(fourth.coordinates, rel=0.02, abs=1e-6)


@pytest.mark.parametrize("size", [2, 4])
def test_modes_of_line_of_fixed_length_are_those_across_its_slope(size):
    """Independent: stiffness and mass on a basis of the motions that keep the length."""
    rng = np.random.default_rng(size)
    root, mass = rng.normal(size=(size, size)), np.diag(rng.uniform(5, 30, size))
    stiffness, slope = root @ root.T * 1e5, rng.normal(size=size)
    across = null_space(slope[None])
    each = eigh(across.T @ stiffness @ across, across.T @ mass @ across, eigvals_only=True)
    found = held_line_frequencies(stiffness, mass, slope)
    assert found == pytest.approx(np.sqrt(each), rel=1e-6)


def test_linear_wave_of_fixed_length_is_that_of_harmonic_balance_for_small_motions():
    """With a thousandth of the force the length's square makes no difference."""
    turned = rotate_chain(GVW.directions, phases=RESPONSE.phases[2], samples=16)
    held = mounted_line(GVW, LINE, stiffness=STIFFNESS, sines=0)
    moments = joint_loads(GVW, turned, LINE, torque=TORQUE).joint_moments
    push = 1e-3 * held.forces_from_joint_moments(moments.order(2))
    slope = held.spline_gradient(GVW.directions[-2])
    speed, torque, N = np.array([25.0]), np.array([0.0]), len(held.mass)
    wave = held_line_wave(
        held, push[None], slope[None], order=2, speed=speed, torque=torque, compression=np.zeros(1)
    )
    both = np.zeros((1, 1, COMPONENT_COUNT, N))
    both[0, 0, 1], both[0, 0, 2] = push.real, push.imag
    none = np.zeros((N, N), dtype=complex)
    linear = stiffness_of_orders(held, none, speed=speed, torque=torque)
    found = followed_stuck_motion(
        StuckLine(
            linear=linear[:, None], push=both, spline=slope[None, None],
            geometric=held.geometric[None], rest=np.zeros((1, 1, N)), compression=np.zeros((1, 1)),
        )
    )  # fmt: skip
    x = found.coordinates[0, 0, 1] + 1j * found.coordinates[0, 0, 2]
    assert x == pytest.approx(wave.coordinates[0], rel=1e-3, abs=1e-9)
    assert np.abs(slope @ wave.coordinates[0]) < 1e-12


def test_motions_that_are_not_needed_are_not_solved():
    line = two_masses(np.array([0.6, -0.8]), np.array([300.0, 100.0]))
    needed = np.arange(len(SPEEDS))[:, None] > 20
    some, every = followed_stuck_motion(line, needed), followed_stuck_motion(line)
    assert (some.is_found == needed).all()
    assert some.coordinates[21:] == pytest.approx(every.coordinates[21:], rel=1e-6, abs=1e-9)
