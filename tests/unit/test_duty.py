"""Named duty cycles: shares of what a line carries at most, made into hours of its needles."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from cardan import files
from cardan.model.application import cycle_points
from cardan.study.approval import assess

EXAMPLE = Path(__file__).parents[2] / "examples" / "refuse-collector-6x2.yaml"


def test_a_named_cycle_is_of_the_largest_torque_and_the_top_speed():
    """The same points written out give the same life: at gvw the line carries most."""
    application = files.read(EXAMPLE)
    refuse = files.cycle("refuse")
    named = replace(application, duty=(), duty_cycle=refuse)
    (plain,) = assess(application).responses
    gvw = plain.demand.states.index("gvw")
    assert plain.demand.torque[gvw] == np.abs(plain.demand.torque).max()
    points = cycle_points(refuse, torque=float(plain.demand.torque[gvw]), speed=2400 * np.pi / 30)
    written = replace(application, duty=points)
    (ours,), (theirs,) = assess(named).responses, assess(written).responses
    assert np.isfinite(ours.life[gvw]).all()
    assert ours.life == pytest.approx(theirs.life, rel=1e-12, nan_ok=True)


def test_what_happens_on_the_bump_stop_is_no_part_of_a_named_cycle():
    """Nobody drives there for hours: ten times the torque at jounce takes no hour off a life."""
    application = replace(files.read(EXAMPLE), duty=(), duty_cycle=files.cycle("refuse"))
    states = tuple(
        replace(s, torque=100e3) if s.kind == "jounce" else s for s in application.states
    )
    assert states != application.states
    (plain,), (struck,) = (
        assess(a).responses for a in (application, replace(application, states=states))
    )
    gvw = plain.demand.states.index("gvw")
    assert np.abs(struck.demand.torque).max() > 2 * np.abs(plain.demand.torque).max()
    assert struck.life[gvw] == pytest.approx(plain.life[gvw], rel=1e-12)


def test_without_a_cycle_there_is_no_life_and_it_is_said_what_it_needs():
    """Worst torque and top speed never meet: 93 h where a cycle gives thousands."""
    found = assess(replace(files.read(EXAMPLE), duty=()))
    assert not [c for c in found.checks if c.quantity == "joint_life"]
    missed = [u for u in found.coverage.unanswered if u.quantity == "joint_life"]
    assert {u.needs for u in missed} == {("duty, or the name of a duty cycle",)}
    assert {str(u.when) for u in missed} == {"empty", "gvw", "overload"}  # where one drives
