"""A mass on rubber with a stop: by its own integration in time, and by what must be."""

import numpy as np
import pytest
from one_mass_at_stop import (
    FREQUENCIES,
    LOSS,
    MASS,
    RESONANCE,
    STEADY,
    STIFFNESS,
    STOP,
    SWING,
    crests,
    elastic,
    one_mass,
)
from scipy.integrate import solve_ivp

from cardan.physics.loads.rubber_mount import MountedLine
from cardan.physics.loads.rubber_stop_contact import (
    SAMPLES,
    STOP_ORDERS,
    StopContact,
    components,
    forces_at_stop,
    largest_travel,
    round_the_half_turn,
)
from cardan.physics.loads.rubber_stop_receptance import (
    StoppedLine,
    StopReceptance,
    moved_by,
    receptance_alone,
    tied_receptance,
)
from cardan.physics.loads.rubber_stop_response import all_motions, followed_motion


def integrated(frequencies: list[float], ratio: float, *, steady: float = STEADY) -> list[float]:
    """Return the largest elastic force at frequencies in turn, the motion kept from one to next."""

    def motion(t, state, W):
        x, v = state
        slope = STIFFNESS * (ratio if abs(x) > STOP else 1.0)
        pushed = steady + SWING * np.cos(W * t)
        return [v, (pushed - elastic(x, ratio) - LOSS * slope / W * v) / MASS]

    state, found = np.array([steady / STIFFNESS, 0.0]), []
    for f in frequencies:
        times = np.linspace(23 / f, 25 / f, 300)
        done = solve_ivp(
            motion, (0, 25 / f), state, args=(2 * np.pi * f,), t_eval=times, rtol=1e-6, atol=1e-9,
            max_step=1 / f / 30,
        )  # fmt: skip
        state = done.y[:, -1]
        found.append(float(elastic(done.y[0], ratio).max()))
    return found


@pytest.mark.parametrize(("ratio", "tolerance"), [(5.0, 0.01), (20.0, 0.015)])
def test_force_at_stop_matches_integration_in_time(ratio, tolerance):
    """Below resonance, in it and up to 12 Hz, where linear rubber carries 3.2 kN."""
    line = one_mass(ratio)
    at, force = crests(line, followed_motion(line))
    frequencies = [10.0, 10.4, 11.0, 12.0]
    for f, expected in zip(frequencies, integrated(frequencies, ratio), strict=True):
        near = np.abs(at - f) < 0.06
        assert np.interp(f, at[near], force[near]) == pytest.approx(expected, rel=tolerance)


@pytest.mark.slow
@pytest.mark.parametrize(("ratio", "tolerance"), [(5.0, 0.01), (20.0, 0.02)])
def test_crest_at_stop_matches_integration_in_time(ratio, tolerance):
    line = one_mass(ratio)
    _, force = crests(line, followed_motion(line))
    frequencies = [10.4, 11.0, 11.6, *np.arange(12.3, 13.5, 0.15).tolist()]
    assert force.max() == pytest.approx(max(integrated(frequencies, ratio)), rel=tolerance)


def test_crest_at_stop_is_higher_and_faster_than_linear():
    """Linear: 6.0 kN at 10.4 Hz. A stiffer stop carries more, and goes up to a higher speed."""
    linear = STEADY + SWING / LOSS
    last = linear
    for ratio in (5.0, 20.0):
        line = one_mass(ratio)
        at, force = crests(line, followed_motion(line))
        assert 1.08 * linear < force.max() < 1.7 * linear
        assert force.max() > last
        assert 1.1 * RESONANCE < at[force.argmax()] < 1.35 * RESONANCE
        last = force.max()


def test_upper_branch_is_found_from_below_and_lower_one_from_above():
    """At 12.6 Hz there are two stable motions: one at the stop, one of linear rubber."""
    line = one_mass(5.0)
    up, down = (crests(line, followed_motion(line, backwards=way)) for way in (False, True))
    upper, lower = (float(force[np.abs(at - 12.6) < 0.03].max()) for at, force in (up, down))
    assert lower == pytest.approx(2852, rel=0.01)
    assert upper > 2 * lower


def test_line_that_rests_on_its_stop_has_the_large_motion_that_is_met_from_above():
    """It softens as it leaves its stop: at 14.4 Hz 8.6 kN coming from 15.2 Hz, 5.2 kN from rest."""
    steady = 1.3 * STIFFNESS * STOP
    line = one_mass(3.0, steady=steady)
    (at, every), (up_at, up) = (crests(line, f(line)) for f in (all_motions, followed_motion))
    largest = integrated([15.2, 14.8, 14.4], 3.0, steady=steady)[-1]
    assert every[np.abs(at - 14.4) < 0.04].max() == pytest.approx(largest, rel=0.01)
    assert up[np.abs(up_at - 14.4) < 0.04].max() < 0.7 * largest


def test_force_of_rubber_without_a_stop_is_stiffness_and_loss_times_travel():
    """What travel adds to linear rubber's counts with its loss, as linear rubber's own does."""
    rng = np.random.default_rng(8)
    travel, free = rng.normal(size=(2, 1, 1 + 2 * len(STOP_ORDERS), 2))
    k, eta = np.array([[[200e3, 120e3]]]), np.array([[0.3]])

    def linear(x):
        waves = k * (1 + 1j * eta[0, 0]) * (x[:, 1::2] + 1j * x[:, 2::2])
        return components(*(np.insert(v, 2, 0, axis=-1) for v in (k[0] * x[:, 0], waves)))

    given = {"stiffness": k, "loss": eta, "stop": np.array([[np.inf]]), "ratio": np.ones((1, 1))}
    moved = forces_at_stop(travel, free, linear(free), **given)
    known = forces_at_stop(travel, travel, linear(travel), **given)
    assert moved.dynamic == pytest.approx(known.dynamic, rel=1e-12)
    assert moved.static == pytest.approx(known.static, rel=1e-12)


def test_motion_within_stop_is_that_of_linear_rubber():
    line = one_mass(20.0, steady=0.0)
    free = StoppedLine(
        free=line.free, receptance=line.receptance, stiffness=line.stiffness,
        stop=np.array([[0.1]]), ratio=line.ratio,
    )  # fmt: skip
    motion = all_motions(free)
    assert motion.place[:, 0].tolist() == list(range(len(FREQUENCIES)))
    assert motion.travel == pytest.approx(line.free)
    count = len(FREQUENCIES)
    found = forces_at_stop(
        motion.travel[:, 0], line.free[:, 0], np.zeros((count, line.free.shape[2], 3)),
        stiffness=free.stiffness.repeat(count, axis=0), loss=np.full((count, 1), LOSS),
        stop=free.stop.repeat(count, axis=0), ratio=free.ratio.repeat(count, axis=0),
    )  # fmt: skip
    assert found.dynamic.max() == 0.0
    far = largest_travel(motion.travel[:, 0])
    assert far.max() == pytest.approx(SWING / LOSS / STIFFNESS, rel=0.01)


def test_stop_force_is_the_slope_of_its_energy():
    """(r - 1) k gap²/2 with k the rubber's stiffness that way; its own slope by differences."""
    rng = np.random.default_rng(3)
    x = rng.normal(size=(1, 2, 60)) * 0.02
    given = {
        "stiffness": np.array([[200e3, 120e3]]), "stop": np.array([STOP]),
        "ratio": np.array([7.0]),
    }  # fmt: skip
    at = StopContact.of(x, **given)

    def force(x):
        return StopContact.of(x, **given).force

    def energy(x):
        far = np.linalg.norm(x, axis=1)
        k = (given["stiffness"][..., None] * x**2).sum(1) / far**2
        return 6 * k * np.maximum(far - STOP, 0) ** 2 / 2

    h = 1e-7
    steps = [np.array([[h], [0.0]]), np.array([[0.0], [h]])]
    by_energy = np.stack([(energy(x + d) - energy(x - d)) / (2 * h) for d in steps], axis=1)
    by_force = [(force(x + d) - force(x - d)) / (2 * h) for d in steps]
    slope = np.stack([by_force[0][:, 0], by_force[1][:, 1], by_force[0][:, 1]], axis=1)
    assert at.force == pytest.approx(by_energy, rel=1e-5, abs=1e-2)
    assert at.slope == pytest.approx(slope, rel=1e-5, abs=10)
    assert by_force[1][:, 0] == pytest.approx(by_force[0][:, 1], rel=1e-5, abs=10)
    within = np.linalg.norm(x, axis=1) <= STOP
    assert (np.moveaxis(at.force, 1, -1)[within] == 0).all()
    assert (np.moveaxis(at.slope, 1, -1)[within] == 0).all()


def test_motions_of_several_lines_are_those_of_each_by_itself():
    """Cases are solved in one batch, each at its own speed: none changes another."""
    each = [one_mass(ratio, steady=s) for ratio, s in ((5.0, STEADY), (20.0, 3300.0), (9.0, 0.0))]
    together = StoppedLine(
        free=np.concatenate([line.free for line in each], axis=1),
        receptance=StopReceptance(
            tied=np.concatenate([line.receptance.tied for line in each], axis=1),
            alone=np.concatenate([line.receptance.alone for line in each], axis=1),
            tied_of=np.arange(len(each)),
            alone_of=np.arange(len(each)),
        ),
        stiffness=np.concatenate([line.stiffness for line in each]),
        stop=np.concatenate([line.stop for line in each]),
        ratio=np.concatenate([line.ratio for line in each]),
    )
    motion = all_motions(together)
    for k, line in enumerate(each):
        alone = all_motions(line)
        batch, own = (~np.isnan(m.place[:, c]) for m, c in ((motion, k), (alone, 0)))
        assert own.sum() >= len(FREQUENCIES) - 5
        assert motion.place[batch, k] == pytest.approx(alone.place[own, 0], abs=1e-9)
        assert motion.travel[batch, k] == pytest.approx(alone.travel[own, 0], abs=1e-6 * STOP)


def line_of_two_coordinates() -> MountedLine:
    """One bearing whose two directions follow both coordinates, gyroscope and torsion in it."""
    nothing = np.zeros((2, 3, 2))
    return MountedLine(
        mass=np.array([[30.0, 4.0], [4.0, 22.0]]),
        bending=np.array([[4e4, 1e4], [1e4, 7e4]]),
        gyroscopic=np.array([[0.0, 3.0], [-3.0, 0.0]]),
        torsion=np.array([[6.0, 2.0], [2.0, -4.0]]),
        geometric=np.array([[1.5, 0.4], [0.4, 2.5]]),
        bearing=np.array([[[1.0, 0.3], [-0.2, 1.1], [0.0, 0.0]]]),
        bearing_frame=np.eye(3)[None],
        stiffness=np.array([[2e5, 1.2e5, 0.0]]),
        loss=np.array([0.15]),
        front=nothing, rear=nothing, front_tilt=nothing, rear_tilt=nothing,
        shaft_directions=np.array([[1.0, 0, 0], [1.0, 0, 0]]),
    )  # fmt: skip


@pytest.mark.parametrize("speed", [35.0, -35.0])
def test_receptance_at_stop_satisfies_the_equation_of_motion(speed):
    """Put back into it round the half turn: torque's order 2 ties orders 0, 2 and 4.

    A stop loses as a damper with the rubber's loss factor at order 2: (1 + iηm/2) at order m.
    """
    on, torque, compression, eta = line_of_two_coordinates(), 900.0, 3000.0, 0.15 * np.sign(speed)
    coupling = np.array([[20 + 5j, 8 - 12j], [8 - 12j, -15 + 9j]])
    turning = {"speed": np.array(speed), "torque": np.array(torque)}
    first = tied_receptance(on, coupling, compression=np.array(compression), **turning)
    alone = receptance_alone(on, **turning)
    force = np.random.default_rng(2).normal(size=(1 + 2 * len(STOP_ORDERS), 2))
    across = on.bearing[0, :2]
    moved = moved_by(first[None], alone[None], force.reshape(1, -1, 1)).reshape(force.shape)
    moved = moved @ np.linalg.inv(across).T
    pushed = force @ across

    def order(values, m):
        """Return one order of components, complex."""
        k = m - 1 if m else 0
        return values[k] + 1j * values[k + 1] if m else values[0]

    tied = np.zeros_like(moved)
    tied[:5] = moved[:5]
    q, angle = round_the_half_turn(tied), np.pi / SAMPLES * np.arange(SAMPLES)
    swing = torque * (coupling * np.exp(2j * angle)[:, None, None]).real
    ties = np.fft.fft((swing @ q[..., None])[..., 0], axis=0) / SAMPLES
    still = on.stiffness_under_torque(torque) - compression * on.geometric
    assert still @ moved[0] - ties[0].real == pytest.approx(pushed[0], rel=1e-9)
    for m in STOP_ORDERS:
        D = on.dynamic_stiffness(np.array(m * speed), np.array(speed), np.array(torque))
        tie = 2 * ties[m // 2] if m <= 4 else 0.0
        expected = (1 + 1j * eta * m / 2) * order(pushed, m)
        assert D @ order(moved, m) - tie == pytest.approx(expected, rel=1e-9)
