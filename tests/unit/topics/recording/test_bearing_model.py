"""Modes of a line step through a drive; what a search met once is kept, and changes nothing."""

import numpy as np
import pytest

from cardan.physics.signals.order_tracking import ShaftRotation
from cardan.physics.signals.shaft_angle import ShaftAngle
from cardan.topics.recording import bearing_model
from cardan.topics.recording.bearing_model import (
    discard_oldest,
    measurement_windows,
    remembered_response,
    stepped_pole,
)

POLES = np.array([-3 + 90j, -8 + 200j])


def drive(speed):
    """Return windows of a minute at a speed (n,) turns/s of ten samples a second."""
    time = np.arange(600) / 10
    turns = np.concatenate([[0.0], np.cumsum((speed[1:] + speed[:-1]) / 20)])
    angle = ShaftAngle(ShaftRotation(time, turns), lag=0.0)
    return measurement_windows(angle, (np.full(600, 1500.0), 10.0), 60.0)


@pytest.mark.parametrize("order", [1.0, 2.0, 4.0])
def test_steady_load_is_followed_exactly(order):
    scene = drive(np.full(600, 14.0))
    W = 2j * np.pi * order * 14.0
    load = 14.0**2 if order == 1 else 1500.0
    turning = np.exp(2j * np.pi * order * scene.fine_angle)
    middle = slice(2000, 12_000)
    for pole in POLES:
        z = stepped_pole(scene, pole, order)
        steady = load / (W - pole) * turning
        assert z[middle] == pytest.approx(steady[middle], rel=1e-6)


def test_kept_poles_are_as_computed_alone(monkeypatch):
    scene = drive(np.linspace(5.0, 25.0, 600))
    both = scene.met_by_poles(POLES, 2.0)
    for order in (1.0, 2.0):
        again = scene.met_by_poles(POLES[::-1], order)
        alone = [scene.met(stepped_pole(scene, p, order), order) for p in POLES[::-1]]
        assert np.array_equal(again, alone)
    assert np.array_equal(both, scene.met_by_poles(POLES, 2.0))
    monkeypatch.setattr(bearing_model, "MAX_KEPT_POLE_COUNT", 1)
    assert np.array_equal(both, scene.met_by_poles(POLES, 2.0))


def test_what_was_kept_first_goes_first():
    kept = dict.fromkeys("abcd", 0)
    discard_oldest(kept, 2)
    assert list(kept) == ["c", "d"]


@pytest.mark.parametrize("order", [2.0, 4.0])
def test_modes_add_nothing_where_speed_and_load_are_steady(order):
    """What was begun at the start has died away: only a changing speed is remembered."""
    scene = drive(np.full(600, 14.0))
    W = 2j * np.pi * order * scene.at.speed
    steady = (1e6 / (W - POLES[0]) * scene.load(order))[None]
    added = remembered_response(scene, steady, POLES, order)
    inside = slice(2, -2)
    assert np.abs(added[:, inside]).max() < 1e-3 * np.abs(steady).max()
