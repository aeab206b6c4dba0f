"""Torsion of the whole vehicle against METHOD's section 16, other methods and exact integration.

The modes' printed digits were confirmed by openTorsion to 1e-11 when they were printed;
`test_torsion_package.py` asks it again.
"""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from cardan.application import reader
from cardan.core.labels import Part
from cardan.physics.dynamics.floquet import growth_rate
from cardan.physics.dynamics.launch import (
    FrictionElements,
    instantaneous_order_amplitude,
    integrate_launch,
    spring_parallel_damping_matrix,
)
from cardan.physics.dynamics.torsional_line import (
    TorsionalLine,
    linearised_about_periodic_motion,
    natural_frequencies,
    output_angle_derivatives,
    periodic_motion,
)
from cardan.physics.dynamics.torsional_network import (
    TorsionalNetwork,
    TorsionalOperatingPoint,
    damped_modes,
    first_order_torques,
    forced_torsional_response,
    modal_coupling_by_joint_order_2,
    spring_torque_response,
    static_response,
    torsional_modes,
    zone_growth_rate,
)
from cardan.physics.vehicle.state_demand import line_state_demand
from cardan.topics.torsion.powertrain_model import vehicle_torsion_model

CHECK = Path(__file__).with_name("torsion_check.yaml")

PRINTED = {
    ("closed", "6.2"): ("0.89896", "22.01976", "30.04006", "75.45473", "126.444", "284.627"),
    ("closed", "direct"): ("3.46409", "21.92791", "29.8343", "42.76441", "202.290", "336.322"),
    ("slipping", "6.2"): ("3.54968", "22.04198", "30.05937", "114.692"),
}
"""Hz, with the tyres stuck: METHOD, section 16."""


@pytest.mark.parametrize("which", PRINTED)
def test_modes_match_method_16_to_printed_digits(which):
    clutch, gear = which
    parts = vehicle_torsion_model(reader.read(CHECK))
    found = torsional_modes(getattr(parts, clutch).line).frequency[0 if gear == "6.2" else 1, 0, 1:]
    for said, w in zip(PRINTED[which], found / (2 * np.pi), strict=False):
        digits = len(said.partition(".")[2])
        assert f"{w:.{digits}f}" == said


def test_check_assumes_no_inertia_or_stiffness():
    """So the digits are the file's alone: only losses and firing are typical."""
    assumed = {a.quantity for a in vehicle_torsion_model(reader.read(CHECK)).assumed}
    assert assumed == {
        "steel.loss", "clutch.loss", "suspension.windup_loss", "tyre.slip_over_load",
        "engine.firing_torque",
    }  # fmt: skip


def test_very_stiff_part_equals_rigid_part():
    """Half shafts of 1e9 N m/rad at the pinion: the other modes are those of a rigid one."""
    from cardan.model.application import GearboxAndAxleRotors

    app = reader.read(CHECK)
    stiff, stiffer = (
        torsional_modes(
            vehicle_torsion_model(
                app, surroundings=GearboxAndAxleRotors(axle_stiffness=k)
            ).closed.line
        ).frequency
        for k in (1e9, 1e12)
    )
    assert stiff[0, 0, 1:5] == pytest.approx(stiffer[0, 0, 1:5], rel=1e-5)
    assert (
        stiff[0, 0, 1]
        > 1.5 * torsional_modes(vehicle_torsion_model(app).closed.line).frequency[0, 0, 1]
    )


# ----- a small line, two ways ------------------------------------------------------------------

BETA = np.array([0.2, 0.15])
K = np.array([30e3, 90e3, 5e3])
DRIVING, DRIVEN = np.array([0.05, 0.03, 2.0]), np.array([0.02, 0.03, 0.01])
C = np.array([5.0, 8.0, 2.0])
TWIST = np.array([0.7, 0.2, 0.0])
LOAD = 300.0


def chain(damping=1.0, angles=1.0):
    """A line from a uniform input, and the same with a flywheel nobody can stop."""
    line = TorsionalLine(
        beta=np.append(BETA * angles, 0.0), stiffness=K, driving=DRIVING, driven=DRIVEN,
        damping=C * damping, twist=TWIST, torque=np.array(LOAD),
    )  # fmt: skip

    def row(**turns):
        out = np.zeros(6)
        for name, value in turns.items():
            out[int(name[1:])] = value
        return out

    none = np.zeros(3)
    same = TorsionalNetwork(
        joints=np.array([1, 2]),
        inertia=np.array([1e9, *DRIVING[:2], *DRIVEN[:2], DRIVING[2] + DRIVEN[2]]),
        rotors=np.array([row(i0=1), row(i1=1), row(i2=1), row(i4=1), row(i5=1), row(i3=1)]),
        stiffness=K, damping=C * damping, loss=none, relaxation=none + np.inf,
        springs=np.array([row(i0=1, i1=-1), row(i4=1, i2=-1), row(i5=1, i3=-1)]),
    )  # fmt: skip
    return line, same


def running(line, speed):
    """The branched line at a speed, its first pin where the exact motion has it on average."""
    exact = periodic_motion(line, np.array(speed))
    n = exact.rotation.shape[-2]
    lag = exact.rotation[..., 0].mean() - np.pi * (n - 1) / (2 * n)
    force = np.array([LOAD, 0, 0, -LOAD])
    place = np.array([lag, TWIST[0] + lag])
    return exact, TorsionalOperatingPoint(
        beta=np.asarray(line.beta)[:2], pin_angle=place, mean_torque=force, speed=np.array(speed)
    )


def test_modes_match_torsional_chain():
    line, same = chain()
    assert torsional_modes(same).frequency[1:] == pytest.approx(natural_frequencies(line), rel=1e-7)


@pytest.mark.parametrize("speed", [20.0, 35.0, 60.0, 150.0])
def test_forced_motion_matches_exact_chain(speed):
    """Harmonic balance of the chain, and rounds over straight joints: one motion, orders 2 and 4.

    1e-6: the flywheel is heavy, not infinite, and the pin's place is a mean of 33 instants.
    """
    line, same = chain()
    exact, turning = running(line, speed)
    found = forced_torsional_response(same, turning)
    for order in (2, 4):
        assert np.abs(found.order(order)) == pytest.approx(np.abs(exact.order(order))[:3], rel=1e-6)


def test_joint_leads_are_accurate_to_first_order():
    """Twice the angles, and 64 times what first order leaves out: only odd powers of tan²(β/2)."""
    left = []
    for angles in (0.5, 1.0):
        line, same = chain(angles=angles)
        _, turning = running(line, 60.0)
        twist, _ = static_response(same, torsional_modes(same), turning.mean_torque)
        turned = twist[same.joints]
        pins = turning.pin_angle + turned - turned[0]
        first = first_order_torques(same, turning, pins=pins, torque=np.array([LOAD, LOAD]))
        left.append(np.abs(first - forced_torsional_response(same, turning).order(2)).max())
        assert left[-1] < 4e-4 * angles**2 * np.abs(first).max()
    assert left[1] / left[0] == pytest.approx(64, rel=0.1)


def test_twist_under_load_moves_joint_pins():
    """Left out, a soft shaft's order 2 is 10 % and more off."""
    line, same = chain()
    exact, turning = running(line, 60.0)
    stays = first_order_torques(
        same, turning, pins=turning.pin_angle, torque=np.array([LOAD, LOAD])
    )
    soft = replace(same, stiffness=K / np.array([1, 60, 1]))
    found = torsional_modes(soft)
    twist, _ = static_response(soft, found, turning.mean_torque)
    pins = turning.pin_angle + twist[soft.joints] - twist[soft.joints][0]
    with_twist, without = (
        first_order_torques(soft, turning, pins=p, torque=np.array([LOAD, LOAD]))
        for p in (pins, turning.pin_angle)
    )
    whole = forced_torsional_response(soft, turning).order(2)
    assert np.abs(with_twist - whole).max() < 0.01 * np.abs(whole).max()
    assert np.abs(without - whole).max() > 0.1 * np.abs(whole).max()
    assert np.abs(stays).max() > 0
    assert exact.speed > 0


@pytest.mark.parametrize(("i", "j"), [(1, 1), (2, 2), (1, 2), (3, 3)])
def test_zone_growth_rate_matches_its_multiplier(i, j):
    """Averaging against the exact monodromy about the exact motion, small angles.

    What is left is of second order: a thousandth of the growth at these angles.
    """
    line, same = chain(damping=1e-3, angles=0.3)
    found = torsional_modes(same)
    w = found.frequency
    zeta = damped_modes(same, found)[1]
    speed = (w[i] + w[j]) / 2
    _, turning = running(line, speed)
    twist, _ = static_response(same, found, turning.mean_torque)
    pins = turning.pin_angle + twist[same.joints] - twist[same.joints][0]
    H = modal_coupling_by_joint_order_2(
        same, found, turning, pins=pins, torque=np.array([LOAD, LOAD])
    )
    rate, openness = zone_growth_rate(
        H, modes=(i, j), frequency=(w[i], w[j]), decay=(zeta[i] * w[i], zeta[j] * w[j]),
        speed=speed,
    )  # fmt: skip
    (exact,) = growth_rate(linearised_about_periodic_motion(line, np.array([speed])))
    assert rate == pytest.approx(exact, rel=1e-3)
    assert openness > 1


def test_zone_opens_at_predicted_angle_and_damping():
    """Undamped zones of mode 2, damped until the exact growth is nil."""
    line, same = chain(damping=1e-3, angles=0.3)
    found = torsional_modes(same)
    w, zeta = found.frequency[2], damped_modes(same, found)[1][2]
    _, turning = running(line, w)
    twist, _ = static_response(same, found, turning.mean_torque)
    pins = turning.pin_angle + twist[same.joints] - twist[same.joints][0]
    H = modal_coupling_by_joint_order_2(
        same, found, turning, pins=pins, torque=np.array([LOAD, LOAD])
    )
    _, openness = zone_growth_rate(
        H, modes=(2, 2), frequency=(w, w), decay=(zeta * w, zeta * w), speed=w
    )
    closed, opened = (
        growth_rate(
            linearised_about_periodic_motion(
                chain(damping=1e-3 * f * openness, angles=0.3)[0], np.array([w])
            )
        )[0]
        for f in (1.02, 0.98)
    )
    slowest = -damped_modes(*_damped_chain(1e-3 * openness))[1][1] * natural_frequencies(line)[0]
    assert closed < 0
    assert opened > slowest * 0.02  # above, or within a fiftieth of, nothing
    assert opened > 0


def _damped_chain(damping):
    _, same = chain(damping=damping)
    return same, torsional_modes(same)


def test_tyre_slip_damping_matches_model_with_own_state():
    """A spring that relaxes, against the eigenvalues of the same with a state of its own.

    x'' + k1 (x - s) = 0 with s' = k1 (x - s)/c... written out: m x'' = -T, T' = k (x' ) - T/τ.
    """
    m, M, k, tau = 30.0, 2100.0, 5.3e5, 0.02
    line = TorsionalNetwork(
        joints=np.zeros(0, dtype=int), inertia=np.array([m, M]), rotors=np.eye(2),
        stiffness=np.array([k]), springs=np.array([[1.0, -1.0]]), damping=np.zeros(1),
        loss=np.zeros(1), relaxation=np.array([tau]),
    )  # fmt: skip
    A = np.array([[0, 0, -1 / m], [0, 0, 1 / M], [k, -k, -1 / tau]])  # v1, v2, T
    exact = max(np.linalg.eigvals(A), key=lambda s: s.imag)
    size, ratio = damped_modes(line, torsional_modes(line))
    assert size[1] == pytest.approx(abs(exact), rel=1e-9)
    assert ratio[1] == pytest.approx(-exact.real / abs(exact), rel=1e-9)


def test_engine_torque_response_matches_two_rotor_closed_form():
    """Closed form: T = k F/J1 / (k/J1 + k/J2 - W²)."""
    J1, J2, k, F, W = 3.0, 7.0, 4e3, 50.0, 25.0
    line = TorsionalNetwork(
        joints=np.zeros(0, dtype=int), inertia=np.array([J1, J2]), rotors=np.eye(2),
        stiffness=np.array([k]), springs=np.array([[1.0, -1.0]]), damping=np.zeros(1),
        loss=np.zeros(1), relaxation=np.array([np.inf]),
    )  # fmt: skip
    found = spring_torque_response(line, W, np.array([F, 0.0]))
    assert found[0].real == pytest.approx(k * F / J1 / (k / J1 + k / J2 - W**2), rel=1e-12)


# ----- a launch --------------------------------------------------------------------------------

J = np.array([120.0, 0.8, 2400.0])
GRIP, SHAFT = 3e6, 2.4e3
P = np.array([0.03 * np.exp(0.6j)])
MOST, RAMP, PUSH, TURNS = 16000.0, 0.3, 3000.0, 8.0


def a_start(loss=0.0):
    """An engine that turns, a grip that ramps, a joint, a shaft, a vehicle."""
    rows = {"engine": [1, 0, 0, 0], "disc": [0, 1, 0, 0], "vehicle": [0, 0, 1, 0]}
    return TorsionalNetwork(
        joints=np.array([1]), inertia=J, rotors=np.array(list(rows.values()), float),
        stiffness=np.array([GRIP, SHAFT]),
        springs=np.array([[1, -1, 0, 0], [0, 0, -1, 1]], float),
        damping=np.zeros(2), loss=np.array([0.0, loss]), relaxation=np.full(2, np.inf),
    )  # fmt: skip


def exact_start(duration, damper):
    """The same by an adaptive method in two parts: slipping, then engine and disc as one.

    A damper beside the shaft turns with it: what slips passes on what it holds and no more.

    A rigid grip: what the elastic one adds at its stiffness is a thousandth of the shaft's.
    """

    def shaft(turned, after):
        X = P[0] * np.exp(2j * turned)
        slope = (1 - abs(X) ** 2) / abs(1 - X) ** 2
        return SHAFT * (turned - np.angle(1 - X) + np.angle(1 - P[0]) - after), slope

    def slips(t, y):
        T, slope = shaft(y[1], y[2])
        carries = MOST * min(t / RAMP, 1.0)
        lost = damper * (y[4] - y[5])
        driven = (carries - slope * T - lost) / J[1]
        return [*y[3:], (PUSH - carries) / J[0], driven, (T + lost) / J[2]]

    def locks(t, y):
        return y[3] - y[4] if t > 1e-3 else 1.0

    def sticks(_, y):
        T, slope = shaft(y[1], y[2])
        lost = damper * (y[4] - y[5])
        both = (PUSH - slope * T - lost) / (J[0] + J[1])
        return [*y[3:], both, both, (T + lost) / J[2]]

    locks.terminal = True
    exactly = {"method": "DOP853", "rtol": 1e-9, "atol": 1e-11, "dense_output": True}
    first = solve_ivp(slips, (0, duration), [0, 0, 0, TURNS, 0, 0], events=locks, **exactly)
    second = solve_ivp(sticks, (first.t[-1], duration), first.y[:, -1], **exactly)
    assert first.status == 1  # it locked, and holds: the grip passes on less than it may
    time = np.linspace(0, duration, 3201)
    y = np.where(time < first.t[-1], first.sol(time), second.sol(time))
    torque = np.array([shaft(a, b)[0] for a, b in zip(y[1], y[2], strict=True)])
    assert torque.max() < 0.9 * MOST
    return time, torque


@pytest.mark.slow
@pytest.mark.parametrize("loss", [0.0, 0.15])
def test_launch_matches_adaptive_integration(loss):
    """Slip, lock-up, ring, a joint of 20 deg: peak to a thousandth, by steps of half a millisecond.

    Newmark's error is (w h)²/12 of what matters, far below; the rest is the moment of lock-up.
    """
    duration = 1.6
    one = a_start(loss)
    damping = spring_parallel_damping_matrix(one, torsional_modes(one), slide=[0])
    assert not damping[0].any()  # nothing beside the clutch ties the engine to what it drives
    when, torque = exact_start(duration, damping[1, 1])
    found = integrate_launch(
        a_start(), damping, leads=lambda turned: np.repeat(P[None], len(turned), axis=0),
        follows=2,
        holding=FrictionElements(
            springs=(0,), max_torque=lambda t: np.array([[MOST * min(max(t / RAMP, 1e-6), 1.0)]]),
            relaxation_length=np.array([np.inf]),
        ),
        rolls=(2, 0.5), driving=lambda t, v: np.array([[PUSH, 0.0, 0.0]]) + 0 * t * v,
        rate=np.array([[TURNS, 0.0, 0.0]]), duration=duration, step=5e-4,
    )  # fmt: skip
    mine = found.torque[0, :, 1]
    assert mine.max() == pytest.approx(torque.max(), rel=2e-3)
    theirs = np.interp(found.time, when, torque)
    assert np.abs(mine - theirs).max() < 0.02 * torque.max()
    locked = np.abs(found.rate[0, -1, 0] - found.rate[0, -1, 1])
    assert locked < 0.05 * found.rate[0, -1, 0]


def test_launch_momentum_equals_engine_impulse():
    """Without a joint nothing turns but by the torques: sum J v grows by what was pushed in."""
    duration = 0.8
    found = integrate_launch(
        a_start(), np.zeros((3, 3)), leads=lambda turned: np.zeros((len(turned), 1), dtype=complex),
        follows=2,
        holding=FrictionElements(springs=(0,), max_torque=lambda t: np.array([[MOST + 0 * t]]),
                        relaxation_length=np.array([np.inf])),
        rolls=(2, 0.5), driving=lambda t, v: np.array([[PUSH, 0.0, 0.0]]) + 0 * t * v,
        rate=np.array([[TURNS, 0.0, 0.0]]), duration=duration,
    )  # fmt: skip
    momentum = found.rate[0] @ J
    assert momentum - J[0] * TURNS == pytest.approx(PUSH * found.time, abs=1e-5 * momentum.max())


def test_play_transmits_no_torque_until_closed():
    """Tip-in: a shaft with 2 deg of play waits, then strikes; energy is never made."""
    play = np.radians(2)
    line = replace(a_start(), stiffness=np.array([1e3, SHAFT]))
    found = integrate_launch(
        line, np.zeros((3, 3)), leads=lambda turned: np.zeros((len(turned), 1), dtype=complex),
        follows=2,
        holding=FrictionElements(springs=(0,), max_torque=lambda t: np.array([[1e9 + 0 * t]]),
                        relaxation_length=np.array([np.inf])),
        rolls=(2, 0.5), driving=lambda t, v: np.array([[300.0, 0.0, 0.0]]) + 0 * t * v,
        rate=np.zeros((1, 3)), play=(1, play), duration=2.0,
    )  # fmt: skip
    twist = found.rotation[0, :, 1] - found.rotation[0, :, 2]
    free = np.abs(twist) < play / 2
    assert free[1:60].all()
    assert not free.all()
    assert np.abs(found.torque[0, free, 1]).max() == 0
    expected = SHAFT * (twist - np.sign(twist) * play / 2)
    # A step ends once its last change is below 1e-9 rad.
    assert found.torque[0, ~free, 1] == pytest.approx(expected[~free], abs=2e-9 * SHAFT)


def test_order_amplitude_is_found_at_changing_speed():
    theta = np.linspace(0, 40, 8000) + 0.2 * np.linspace(0, 40, 8000) ** 2 / 40
    signal = 7.0 * np.cos(2 * theta + 0.3) + 3 * np.cos(4 * theta) + 11
    found = instantaneous_order_amplitude(signal, theta, 2)
    known = np.isfinite(found)
    assert known.mean() > 0.9
    assert found[known] == pytest.approx(7.0, rel=1e-3)


@pytest.mark.parametrize("gear", [0, -1])
def test_part_dampers_damp_launch_like_modal_damping(gear):
    parts = vehicle_torsion_model(reader.read(CHECK))
    line = parts.closed.line.select_case(gear, 0)
    line = replace(line, relaxation=np.full(line.relaxation.shape, np.inf))
    found = torsional_modes(line)
    names = [p.kind for _, p in parts.closed.springs]
    slide = [names.index("clutch disc"), names.index("tyres")]
    C = spring_parallel_damping_matrix(line, found, slide=slide)
    zeta, w = damped_modes(line, found)[1], found.frequency
    own = np.diagonal(found.shape.T @ C @ found.shape)
    assert own[1] == pytest.approx(2 * zeta[1] * w[1], rel=0.1)
    assert zeta[1] > 0.009
    # What turns as a whole on either side of what slides loses nothing.
    turns = line.springs @ line.straight_transform
    firm = np.delete(turns, slide, axis=0)
    free = np.linalg.svd(firm)[2][np.linalg.matrix_rank(firm) :]
    assert len(free) == 3
    assert np.abs(C @ free.T).max() < 1e-9 * np.abs(C).max()


def test_transmitted_lead_equals_lead_of_one_joint():
    """-arg(1 - X) is the joint's lead, its derivatives φ' and φ''."""
    from cardan.physics.dynamics.launch import _leads

    beta, u, place = 0.5, np.linspace(0, 7, 50), 0.4
    lead, slope, bend = _leads(np.tan(beta / 2) ** 2 * np.exp(2j * place), u)
    phi, first, second, _ = output_angle_derivatives(u + place, beta=beta)
    assert lead == pytest.approx(phi - u - place, abs=1e-14)
    assert slope == pytest.approx(first, rel=1e-12)
    assert bend == pytest.approx(second, abs=1e-12)


def test_straight_joints_transmit_full_torque_through_every_spring():
    """Straight joints carry the whole torque on: through joints, and through every spring."""
    app = reader.read(CHECK)
    parts = vehicle_torsion_model(app)
    line = parts.closed.line.select_case([0], [0])
    found = torsional_modes(line)
    force = parts.closed.balanced_torques(np.array([1000.0]), found.shape[..., 0])
    _, torque = static_response(line, found, force)
    each = dict(zip(parts.closed.springs, torque[0], strict=True))
    assert each["main", Part("shaft", 1)] == pytest.approx(1000, rel=1e-9)
    assert each["main", Part("half shafts")] == pytest.approx(4500, rel=1e-9)
    assert each["main", Part("wind-up")] == pytest.approx(4500, rel=1e-9)
    assert line_state_demand(parts.lines[0]).states == ("gvw",)


@pytest.mark.slow
def test_rotor_behind_single_joint_keeps_its_energy():
    """A rotor rigidly behind a joint that turns freely keeps its energy: J (φ')² q'² is constant.

    The rotor ahead is next to nothing, so q' swings as 1/φ' does.
    """
    X = np.array([0.08 * np.exp(0.3j)])
    line = TorsionalNetwork(
        joints=np.array([0]), inertia=np.array([1e-3, 1.0, 1.0]),
        rotors=np.array([[1, 0, 0], [0, 0, 1], [0, 1, 0]], float), stiffness=np.array([1e-6]),
        springs=np.array([[0, 1, -1]], float), damping=np.zeros(1), loss=np.zeros(1),
        relaxation=np.full(1, np.inf),
    )  # fmt: skip
    found = integrate_launch(
        line,
        np.zeros((2, 2)),
        leads=lambda turned: np.repeat(X[None], len(turned), axis=0),
        follows=1,
        holding=FrictionElements(
            springs=(), max_torque=lambda t: np.zeros((1, 0)) + t, relaxation_length=np.zeros(0)
        ),
        rolls=(1, 0.5),
        driving=lambda t, v: 0 * v + 0 * t,
        rate=np.array([[10.0, 0.0]]),
        duration=1.0,
        step=2e-4,
    )
    q, v = found.rotation[0, :, 0], found.rate[0, :, 0]
    turned = X[0] * np.exp(2j * q)
    slope = (1 - abs(X[0]) ** 2) / np.abs(1 - turned) ** 2
    energy = (slope**2 + 1e-3) * v**2
    assert energy == pytest.approx(energy[0], rel=2e-3)
    assert v.max() / v.min() > 1.2
