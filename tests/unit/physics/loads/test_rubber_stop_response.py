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

from cardan.physics.loads.rubber_stop_response import (
    StoppedLine,
    all_motions,
    followed_motion,
    forces_at_stop,
    stop_forces,
)


def integrated(frequencies: list[float], ratio: float) -> list[float]:
    """Return the largest elastic force at rising frequencies, the motion kept from one to next."""

    def motion(t, state, W):
        x, v = state
        slope = STIFFNESS * (ratio if abs(x) > STOP else 1.0)
        pushed = STEADY + SWING * np.cos(W * t)
        return [v, (pushed - elastic(x, ratio) - LOSS * slope / W * v) / MASS]

    state, found = np.array([STEADY / STIFFNESS, 0.0]), []
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


def test_motion_within_stop_is_that_of_linear_rubber():
    line = one_mass(20.0, steady=0.0)
    free = StoppedLine(
        free=line.free, receptance=line.receptance, stiffness=line.stiffness,
        stop=np.array([[0.1]]), ratio=line.ratio,
    )  # fmt: skip
    motion = all_motions(free)
    assert motion.place[:, 0].tolist() == list(range(len(FREQUENCIES)))
    assert motion.travel == pytest.approx(line.free)
    linear = np.zeros((*line.free.shape[:-1], 3))
    found = forces_at_stop(
        motion.travel[:, 0], line.free[:, 0], linear[:, 0], stiffness=free.stiffness,
        loss=np.array([[LOSS]]), stop=free.stop, ratio=free.ratio,
    )  # fmt: skip
    assert found.dynamic.max() == 0.0
    assert found.travel.max() == pytest.approx(SWING / LOSS / STIFFNESS, rel=0.01)


def test_stop_force_is_the_slope_of_its_energy():
    """(r - 1) k gap²/2 with k the rubber's stiffness that way; its own slope by differences."""
    rng = np.random.default_rng(3)
    x = rng.normal(size=(1, 60, 1, 2)) * 0.02
    given = {
        "stiffness": np.array([[[200e3, 120e3]]]), "stop": np.array([[STOP]]),
        "ratio": np.array([[7.0]]),
    }  # fmt: skip
    force, slope = stop_forces(x, **given)

    def energy(x):
        far = np.linalg.norm(x, axis=-1)
        k = (given["stiffness"] * x**2).sum(-1) / far**2
        return 6 * k * np.maximum(far - STOP, 0) ** 2 / 2

    h = 1e-7
    steps = [np.array([h, 0.0]), np.array([0.0, h])]
    by_energy = np.stack([(energy(x + d) - energy(x - d)) / (2 * h) for d in steps], axis=-1)
    by_force = np.stack([
        (stop_forces(x + d, **given)[0] - stop_forces(x - d, **given)[0]) / (2 * h) for d in steps
    ], axis=-1)  # fmt: skip
    assert force == pytest.approx(by_energy, rel=1e-5, abs=1e-2)
    assert slope == pytest.approx(by_force, rel=1e-5, abs=10)
    assert (force[np.linalg.norm(x, axis=-1) <= STOP] == 0).all()
