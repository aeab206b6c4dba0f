"""Critical speed is evaluated at the largest speed that engine and gears turn the shaft."""

import numpy as np
import pytest
from repository import ROOT

from cardan.application.overrides import change
from cardan.application.reader import loads
from cardan.approval.approval import approve_driveline
from cardan.checks.line_response import compute_line_response
from cardan.checks.quantities.strength import half_critical_speed_ratio
from cardan.core.units import rpm
from cardan.physics.vehicle.state_demand import line_state_demand, resolve_line_references

VAN = (ROOT / "examples" / "van.yaml").read_text(encoding="utf-8")
LONG = VAN.replace("speed_rpm: 4400 ", "speed_rpm: 1180 ").replace(
    "[1430, 0, -105]", "[1830, 0, -134]"
).replace("wheelbase_mm: 3000", "wheelbase_mm: 3400")  # fmt: skip
"""A long van whose speed is that of its wheels; the engine turns the shaft at 5000 rpm."""


def test_reached_speed_is_engine_speed_over_smallest_ratio():
    (response,) = approve_driveline(loads(LONG)).line_responses
    reached = dict(zip(response.demand.states, response.inputs.reached_speed / rpm, strict=True))
    assert reached["gvw"] == pytest.approx(3900 / 0.78)
    assert reached["windup"] == pytest.approx(780)  # its own
    assert reached["full rebound"] == pytest.approx(1000)


def test_larger_speed_of_the_file_counts():
    (response,) = approve_driveline(loads(VAN.replace("4400 ", "5200 "))).line_responses
    gvw = response.demand.states.index("gvw")
    assert response.inputs.reached_speed[gvw] / rpm == pytest.approx(5200)


def test_shaft_beyond_critical_speed_fails_whatever_speed_the_file_gives():
    found = approve_driveline(loads(LONG))
    checks = [c for c in found.checks if c.quantity == "critical_speed_ratio"]
    by_state = {c.state: c for c in checks if c.part.kind == "shaft"}
    assert by_state["gvw"].grade == "fail"
    assert by_state["gvw"].value == pytest.approx(5000 / 1180 * _at_file_speed("gvw"), rel=1e-9)
    assert any("evaluated at 5000 rpm" in note and "1180 rpm" in note for note in found.notes)


def _at_file_speed(state: str) -> float:
    (response,) = approve_driveline(loads(LONG)).line_responses
    s = response.demand.states.index(state)
    return float(response.demand.speed[s] / response.strength.critical_speeds[s, 0])


def test_half_critical_band_is_evaluated_at_both_speeds():
    """Beyond the band at the engine's speed, within it at the file's: it stays a finding."""
    inside = int(1180 * 0.5 / _at_file_speed("gvw"))
    (response,) = approve_driveline(
        loads(LONG.replace("speed_rpm: 1180 ", f"speed_rpm: {inside} "))
    ).line_responses
    gvw = response.demand.states.index("gvw")
    critical = response.strength.critical_speeds[gvw, 0]
    assert response.inputs.reached_speed[gvw] / critical > 0.58
    assert half_critical_speed_ratio(response)[gvw, 0] == pytest.approx(0.5, abs=0.01)


def test_each_variant_reaches_its_own_speed():
    ratios = np.array([0.78, 0.70])
    varied = change(loads(VAN), {"gearbox.ratios[5]": ratios})
    asked = line_state_demand(resolve_line_references(varied, varied.lines[0]))
    reached = compute_line_response(varied, asked).inputs.reached_speed
    gvw = asked.states.index("gvw")
    np.testing.assert_allclose(reached[:, gvw] / rpm, 3900 / ratios)
