"""A line that passes through its resonances: against mechanics of another hand, step by step.

`shaken.py` knows two pins at right angles, virtual work and springs, and steps through time; the
line is the one of its application file, with the rubber that is so. Its torque and speed come as
a clutch brings them.
"""

from dataclasses import replace

import numpy as np
import pytest
from shaken import LINE, Truth, shaken

from cardan.application import reader
from cardan.checks.drive_forces import TorqueSpeedTimeHistory, bearing_forces_over_time_history
from cardan.checks.line_response import compute_line_response
from cardan.physics.vehicle.state_demand import line_state_demand, resolve_line_references

TRUTH = Truth(noise=0.0, unbalance=0.0, offset=0.0)
TEXT = (
    LINE.replace("vertical_stiffness_N_mm: 150", "vertical_stiffness_N_mm: 172.5")
    .replace("lateral_stiffness_N_mm: 100", "lateral_stiffness_N_mm: 85")
    .replace("loss_factor: 0.1", "loss_factor: 0.085")
    .replace("mean_radius_mm: 27, friction: 0.08, ", "")
)


def ramp(seconds: float, *, most: float = 2600.0, top: float = 12.0, ripple: float = 0.15):
    """A clutch's torque in a second, swinging as it holds; speed that rises after it."""

    def drive(_, rate, rng):
        del rng
        t = np.arange(int((seconds + 0.5) * rate)) / rate
        s = np.minimum(t / 1.0, 1.0)
        torque = most * s * s * (3 - 2 * s) * (1 + ripple * np.sin(2 * np.pi * 3 * t) * s)
        go = np.clip(t / seconds, 0, 1)
        return t, 1e-3 + top * go * go * (3 - 2 * go), torque

    return drive


def line(text=TEXT):
    application = reader.loads(text)
    return compute_line_response(
        application, line_state_demand(resolve_line_references(application, application.lines[0]))
    )


def both(seconds, *, truth=TRUTH, text=TEXT, **asked):
    """Force on the bearing as another hand has it, and ours: passing, and steadily."""
    rate, inner = 1000.0, 4
    told = shaken(truth, seconds=0.0, rate=rate, inner=inner, drive=ramp(seconds, **asked))
    turns = told.turns - TRUTH.offset / (2 * np.pi)
    steady, passed = bearing_forces_over_time_history(
        line(text).mounts,
        TorqueSpeedTimeHistory(
            time=np.arange(turns.size) / rate,
            input_angle=2 * np.pi * turns,
            torque=told.torque,
            speed=2 * np.pi * told.speed,
        ),
        state=0,
    )
    return np.linalg.norm(told.force, axis=-1), passed[:, 0], steady[:, 0]


@pytest.mark.slow
@pytest.mark.parametrize("seconds", [1.2, 3.0, 8.0])
def test_force_while_passing_resonance_matches_integration(seconds):
    theirs, ours, steady = both(seconds)
    # Small motions, and steps of a millisecond against order 2 at 24 Hz: (0.15)²/12 each.
    assert np.abs(ours - theirs).max() < 0.02 * theirs.max()
    assert theirs.max() == pytest.approx(ours.max(), rel=0.01)
    assert ours.max() < 0.9 * steady.max()


@pytest.mark.slow
def test_slow_passage_reaches_steady_state_force():
    """The steady peak is a bound: mean and ellipse where they add up."""
    _, quick, steady = both(3.0, ripple=0.0)
    _, slow, same = both(60.0, ripple=0.0)
    assert same.max() == pytest.approx(steady.max(), rel=0.01)
    assert 0.9 * same.max() < slow.max() <= 1.001 * same.max()
    assert quick.max() < 0.9 * slow.max()


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore:.*longer than its shaft")
def test_line_passing_resonance_is_twisted_by_torque():
    """As far as by 20 m of tube, 4 deg of each shaft: G J / L of a ring by hand."""
    rigidity = 900e9 / 2.6 * np.pi / 32 * (0.1**4 - 0.094**4)
    soft = TEXT.replace("      phase_deg: 0", "      tube_length_mm: 20000\n      phase_deg: 0")
    assert soft.count("tube_length_mm") == 2
    theirs, ours, _ = both(3.0, truth=replace(TRUTH, torsion=(20 / rigidity,) * 2), text=soft)
    welded, *_ = both(3.0)
    assert np.abs(ours - theirs).max() < 0.02 * theirs.max()
    assert np.abs(welded - theirs).max() > 0.05 * theirs.max()
