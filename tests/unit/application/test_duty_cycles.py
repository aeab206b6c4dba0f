"""Named duty cycles: shares of what a line carries at most, made into hours of its needles."""

from dataclasses import replace

import numpy as np
import pytest
from repository import EXAMPLES

from cardan.application import duty_cycles, reader
from cardan.approval.approval import approve_driveline
from cardan.model.application import duty_cycle_points

EXAMPLE = EXAMPLES / "refuse-collector-6x2.yaml"


@pytest.mark.slow
def test_named_duty_cycle_scales_with_peak_torque_and_top_speed():
    """The same points written out give the same life: at gvw the line carries most."""
    application = reader.read(EXAMPLE)
    refuse = duty_cycles.load_duty_cycle("refuse")
    named = replace(application, duty=(), duty_cycle=refuse)
    (plain,) = approve_driveline(application).line_responses
    gvw = plain.demand.states.index("gvw")
    assert plain.demand.torque[gvw] == np.abs(plain.demand.torque).max()
    points = duty_cycle_points(
        refuse, torque=float(plain.demand.torque[gvw]), speed=2400 * np.pi / 30
    )
    written = replace(application, duty=points)
    (ours,), (theirs,) = (
        approve_driveline(named).line_responses,
        approve_driveline(written).line_responses,
    )
    assert np.isfinite(ours.strength.needle_bearing_life[gvw]).all()
    assert ours.strength.needle_bearing_life == pytest.approx(
        theirs.strength.needle_bearing_life, rel=1e-12, nan_ok=True
    )


def test_named_duty_cycle_excludes_bump_states():
    """Nobody drives there for hours: ten times the torque at jounce takes no hour off a life."""
    application = replace(
        reader.read(EXAMPLE), duty=(), duty_cycle=duty_cycles.load_duty_cycle("refuse")
    )
    states = tuple(
        replace(s, torque=100e3) if s.kind == "jounce" else s for s in application.states
    )
    assert states != application.states
    (plain,), (struck,) = (
        approve_driveline(a).line_responses
        for a in (application, replace(application, states=states))
    )
    gvw = plain.demand.states.index("gvw")
    assert np.abs(struck.demand.torque).max() > 2 * np.abs(plain.demand.torque).max()
    assert struck.strength.needle_bearing_life[gvw] == pytest.approx(
        plain.strength.needle_bearing_life[gvw], rel=1e-12
    )


def test_joint_life_without_duty_cycle_is_not_evaluated():
    """Worst torque and top speed never meet: 93 h where a cycle gives thousands."""
    found = approve_driveline(replace(reader.read(EXAMPLE), duty=()))
    assert not [c for c in found.checks if c.quantity == "joint_life"]
    missed = [u for u in found.coverage.unevaluated if u.quantity == "joint_life"]
    assert {u.missing_inputs for u in missed} == {("duty, or the name of a duty cycle",)}
    assert {str(u.when) for u in missed} == {"empty", "gvw", "overload"}  # where one drives
