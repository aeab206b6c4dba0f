"""Run-up through resonance after Lewis (1932) and Mazzei (2011): peaks to their printed digits."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from cardan.core.errors import ConvergenceError
from cardan.physics.dynamics.run_up import (
    MotorDrivenShaft,
    limited_power_run_up,
    resonance_passage,
    run_up_outcomes,
    swept_response,
)


def test_peaks_match_lewis_and_mazzei():
    found = resonance_passage(rate=np.array([0.001, 0.01]), damping_ratio=np.array([0.0, 0.01]))
    assert found.peak[0] == pytest.approx(46.156, abs=5e-4)
    assert found.frequency[0] == pytest.approx(1.068, abs=5e-4)
    assert found.peak[1] == pytest.approx(12.142, abs=5e-4)


@pytest.mark.parametrize(
    ("start", "rate", "zeta"), [(0, 0.01, 0.01), (2, -0.01, 0.02), (0.3, 0.05, 0)]
)
def test_closed_form_satisfies_differential_equation(start, rate, zeta):
    t = np.linspace(0, 1.9 / abs(rate), 60)
    steady = 1 / (1 - start**2 + 2j * zeta * start)
    done = solve_ivp(
        lambda t, y: [y[1], np.cos(start * t + rate * t**2 / 2) - 2 * zeta * y[1] - y[0]],
        (0, t[-1]), [steady.real, (1j * start * steady).real],
        t_eval=t, method="DOP853", rtol=1e-11, atol=1e-11,
    )  # fmt: skip
    exact = swept_response(t, rate=rate, damping_ratio=zeta, start=start).real
    np.testing.assert_allclose(exact, done.y[0], atol=2e-9)


@pytest.mark.slow
def test_slow_sweep_approaches_steady_response():
    """It falls short by rate / 2 zeta: the response lags its steady curve by that."""
    zeta, rate = 0.05, 1e-5
    exact = 1 / (2 * zeta * np.sqrt(1 - zeta**2))
    short = 1 - resonance_passage(rate=rate, damping_ratio=zeta).peak / exact
    assert short == pytest.approx(rate / (2 * zeta), rel=0.15)


def test_faster_run_up_has_lower_later_and_shorter_peak():
    up = resonance_passage(rate=np.array([0.0005, 0.002, 0.008]), damping_ratio=0.01)
    assert np.all(np.diff(up.peak) < 0)
    assert np.all(np.diff(up.frequency) > 0)
    assert np.all(np.diff(up.dwell) < 0)
    down = resonance_passage(rate=np.array([0.0005, 0.002, 0.008]), damping_ratio=0.01, start=2.0)
    assert np.all(down.frequency < 1)
    assert np.all(np.diff(down.frequency) < 0)


def line(power, beta=20):
    return MotorDrivenShaft(
        power=power, stall_torque=100, motor=0.2, wheel=1, stiffness=2000, damping=0.05,
        drag=0.01, beta=np.radians(beta),
    )  # fmt: skip


@pytest.mark.slow
def test_weak_motor_is_captured_at_half_torsional_frequency():
    """120 W would carry the drag to 110 rad/s; the joint holds it at 54.8, half of 109.5."""
    weak = line(120)
    stuck = limited_power_run_up(weak, duration=40)
    assert weak.top_speed == pytest.approx(109.5, abs=0.1)
    assert stuck.mean_speed == pytest.approx(weak.frequency / 2, rel=0.02)
    assert (
        limited_power_run_up(line(120, beta=2), duration=40).mean_speed > 1.2 * weak.frequency / 2
    )


@pytest.mark.slow
@pytest.mark.long
def test_capture_of_motor_depends_on_start_angle():
    """120 W: caught at half, from everywhere; 400 W: at the frequency itself, from 7 of 8.

    The eighth gets past. 1500 W gets through from everywhere.
    """
    weak, middling = run_up_outcomes(line(120), phases=4), run_up_outcomes(line(400))
    assert str(weak) == "caught at half, 4 of 4"
    np.testing.assert_allclose(weak.mean_speed, line(120).frequency / 2, rtol=0.02)
    assert str(middling) == "caught, 7 of 8"
    caught = [
        v for v, f in zip(middling.mean_speed, middling.outcomes, strict=True) if f == "caught"
    ]
    np.testing.assert_allclose(caught, 109.0, atol=0.6)
    assert str(run_up_outcomes(line(1500))) == "through, 8 of 8"


@pytest.mark.slow
def test_batched_start_angles_equal_single_runs():
    """Steps of equal length against an adaptive integrator of eighth order, while it is caught.

    After 18 s and some 130 turns both have come as far to a few parts in ten thousand.
    """
    many = run_up_outcomes(line(120), duration=18, phases=2)
    for angle, speed in zip(many.angle, many.mean_speed, strict=True):
        one = limited_power_run_up(line(120), duration=18, start_angle=float(angle), samples=12001)
        assert speed == pytest.approx(one.mean_speed, rel=5e-4)
    assert abs(many.mean_speed[0] / many.mean_speed[1] - 1) > 1e-3  # the start is not forgotten


def test_incomplete_run_up_is_rejected():
    with pytest.raises(ConvergenceError, match="give it a longer duration"):
        run_up_outcomes(line(120), duration=3, phases=2)
