"""What turns, and what it does to a mode: shortcuts that are to equal the long way."""

import numpy as np
import pytest
from scipy.signal import lfilter

from cardan.physics.signals import order_kernels as kernel
from cardan.physics.signals.order_kernels import running_mean, unit_phasor_of_turns
from cardan.physics.signals.order_tracking import ShaftRotation
from cardan.physics.signals.shaft_angle import ANGLE_LOOKUP_MARGIN_S, ShaftAngle
from cardan.physics.signals.speed_alignment import SampledShaftMotion, remove_running_mean
from cardan.physics.signals.synchronous_fit import fit_order


@pytest.mark.parametrize("compiled", [True, False])
def test_wave_matches_sine_and_cosine(compiled, monkeypatch):
    """Turns that double precision holds exactly, so that nothing but the wave itself is off."""
    if not compiled:
        monkeypatch.setattr(kernel, "compiled", lambda _: None)
    turns = np.arange(-(2**20), 2**20) / 2**15 + 2.0**20
    exact = np.exp(2j * np.pi * (turns % 1))
    assert np.abs(unit_phasor_of_turns(turns) - exact).max() < 1e-15
    rows = turns[: 2**20].reshape(4, -1)[:, ::2]
    np.testing.assert_array_equal(
        unit_phasor_of_turns(rows), unit_phasor_of_turns(rows.ravel()).reshape(rows.shape)
    )


@pytest.mark.parametrize(("first", "last"), [(200.013, 260.009), (-5.0, 30.0), (980.0, 1040.0)])
def test_stretch_of_rotation_equals_whole(first, last):
    """Bit for bit, as far beside it as a lag goes; a part of the whole and no copy of it."""
    speed = np.random.default_rng(3).uniform(0, 40, 50_000)
    whole = ShaftAngle(
        ShaftRotation(np.arange(50_001) * 0.02, np.append(0, np.cumsum(speed) * 0.02)), lag=0.5,
        lost_intervals=np.array([[100.0, 101.0], [230.0, 231.0], [990.0, 991.0]]),
    )  # fmt: skip
    part = whole.within(first, last)
    edge = whole.lag + ANGLE_LOOKUP_MARGIN_S
    for time in (np.linspace(first, last, 999), np.array([first - edge, last + edge])):
        np.testing.assert_array_equal(part.rotation.at(time), whole.rotation.at(time))
        np.testing.assert_array_equal(part.rotation.speed(time), whole.rotation.speed(time))
    assert np.shares_memory(part.rotation.turns, whole.rotation.turns)
    assert part.rotation.turns.size < 6000
    assert len(part.lost_intervals) == 1 - (first < 0)


@pytest.mark.parametrize("half", [1, 7, 60])
def test_running_mean_is_level_at_ends(half):
    x = np.random.default_rng(1).normal(size=50) + 1j
    padded = np.pad(x, half, mode="edge")
    plain = np.lib.stride_tricks.sliding_window_view(padded, 2 * half + 1).mean(-1)
    np.testing.assert_allclose(running_mean(x, half), plain, atol=1e-14)
    np.testing.assert_allclose(remove_running_mean(x, 2 * half), x - plain, atol=1e-14)


@pytest.mark.parametrize("compiled", [True, False])
def test_mode_response_to_steady_rotating_force_is_exact(compiled, monkeypatch):
    """A force that turns steadily meets the mode's response 1/(s - p) once what began is gone."""
    if not compiled:
        monkeypatch.setattr(kernel, "compiled", lambda _: None)
    rate, w, p = 50.0, 70.0, -6.0 + 80.0j
    forces = np.exp(1j * w * np.arange(600) / rate) * np.array([[1.0], [2.0j]])
    spin = np.full(600, 1j * w)
    one, share = np.array([p]), np.array([3.0])
    back = np.exp(-spin / rate)
    answer = kernel.modal_response(forces, spin, back, one, np.exp(one / rate), share)[0]
    ahead = (
        np.array([[1.0], [2.0j]]) * np.exp(-1j * w / rate) * np.exp(p / rate) ** np.arange(1, 601)
    )
    expected = 3.0 / (p - 1j * w) * (ahead - forces)
    np.testing.assert_allclose(answer, expected, rtol=1e-9)


def test_modal_state_matches_recursive_filter(monkeypatch):
    force = np.random.default_rng(2).normal(size=(2, 100)) + 0j
    compiled = kernel.first_order_filter(force, 0.9 - 0.2j)
    np.testing.assert_allclose(compiled, lfilter([1], [1, -0.9 + 0.2j], force), rtol=1e-9)
    monkeypatch.setattr(kernel, "compiled", lambda _: None)
    np.testing.assert_allclose(kernel.first_order_filter(force, 0.9 - 0.2j), compiled, rtol=1e-9)


@pytest.mark.parametrize("mode", [(37.3, 0.02), (24.6, 0.013), (52.9, 0.07)])
def test_mode_is_found_between_search_steps(mode):
    """To a thousandth of its frequency: steps of the search are 3 %, and a factor of 1.6."""
    rate = 400.0
    t = np.arange(int(120 * rate)) / rate
    speed = 5 + 28 * (0.5 - 0.5 * np.cos(2 * np.pi * t / 60))
    turns = np.cumsum(speed) / rate
    torque = 1 + 0.3 * np.sin(2 * np.pi * t / 17)
    still = np.zeros(t.size, np.int64)
    scene = SampledShaftMotion(turns, speed, torque, rate, still)
    y = (scene.columns(2, [mode])[2] * (3 + 1j)).real
    y = y + np.random.default_rng(0).normal(0, 0.05 * y.std(), t.size)
    ((frequency, damping),) = fit_order(scene, y, 2, most=1).modes
    assert frequency == pytest.approx(mode[0], rel=1e-3)
    assert damping == pytest.approx(mode[1], rel=0.03)
