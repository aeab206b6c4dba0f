"""Bearings of gearbox and pinion are held to the rating that a file gives, and to nothing else."""

from math import cos, radians, sin, tan
from pathlib import Path

import numpy as np
import pytest

from cardan.application import reader
from cardan.approval.approval import approve_driveline
from cardan.approval.driveline_study import evaluate_limits
from cardan.checks.line_response import compute_line_response
from cardan.physics.vehicle.state_demand import line_state_demand, resolve_line_references

ONE_SHAFT = """
title: One shaft
torque_Nm: 4000
speed_rpm: 300
driveline:
  slopes: {side_deg: [9, 2, 6]}
  shafts: [{length_mm: 1500, tube: 120x4}]
BEARINGS
states: [{name: straight}]
limits:
  - {quantity: joint_angle, maximum: 10, source: ours}
"""
COLLECTOR = Path(__file__).parents[3] / "examples" / "refuse-collector-6x2.yaml"
RATED = """
  gearbox_bearing_spacing_mm: 250
  gearbox_bearing_overhang_mm: 120
  gearbox_bearing_rating_N: [3000, 4000]
  pinion_bearing_spacing_mm: 120
  pinion_bearing_overhang_mm: 150
  pinion_bearing_rating_N: [6000, 7500]"""


def one_shaft(bearings: str):
    return approve_driveline(reader.loads(ONE_SHAFT.replace("BEARINGS", bearings)))


def utilisations(found, state: str) -> dict[str, float]:
    return {
        str(c.part.number): c.value
        for c in found.checks
        if c.quantity.endswith("_bearing_utilisation") and c.state == state
    }


def test_rated_bearings_are_held_to_the_larger_of_gwb_two_positions():
    """GWB catalogue p. 46, Z arrangement, on one planar shaft without spline: exact."""
    found = utilisations(one_shaft(RATED), "straight")
    torque, length, b1, b2 = 4000, 1.5, radians(7), radians(4)
    a, b, f, e = 0.250, 0.120, 0.120, 0.150
    couple = torque * cos(b1) / length * (tan(b1) - tan(b2))
    force = {
        "A": max(couple * b / a, torque * tan(b1) / a),
        "B": max(couple * (a + b) / a, torque * tan(b1) / a),
        "E": max(couple * (e + f) / f, torque * sin(b2) / cos(b1) / f),
        "F": max(couple * e / f, torque * sin(b2) / cos(b1) / f),
    }
    rating = {"A": 3000, "B": 4000, "F": 6000, "E": 7500}
    assert found == pytest.approx({k: force[k] / rating[k] for k in force}, rel=1e-3)


def test_rubber_adds_what_it_shakes_the_end_joints_with():
    """Levers 1.48, 0.48 and 2.25, 1.25: joint 4 is shaken with 389 N, rigid forces stand below."""
    text = COLLECTOR.read_text(encoding="utf-8")
    application = reader.loads(text.replace('joints: "2040"', f'joints: "2040"{RATED}'))
    demand = line_state_demand(resolve_line_references(application, application.lines[0]))
    response = compute_line_response(application, demand)
    wound_up = demand.states.index("windup")
    found = {
        str(part.number): float(value)
        for end in ("gearbox", "pinion")
        for q in evaluate_limits(response, quantities={f"{end}_bearing_utilisation"})
        for part, value in zip(q.parts, q.values[wound_up], strict=True)
        if np.isfinite(value)
    }
    joint_1, joint_4 = 362.3, 388.9
    assert found == pytest.approx(
        {
            "A": (1204.9 + 0.48 * joint_1) / 3000,
            "B": (2012.2 + 1.48 * joint_1) / 4000,
            "E": (6828.7 + 2.25 * joint_4) / 7500,
            "F": (5611.1 + 1.25 * joint_4) / 6000,
        },
        rel=1e-3,
    )


def test_unrated_bearings_are_shown_without_a_verdict():
    unrated = "\n".join(line for line in RATED.splitlines() if "rating" not in line)
    found = one_shaft(unrated)
    assert found.verdict == "pass"
    assert not utilisations(found, "straight")
    assert not found.coverage.unevaluated
    assert found.line_responses[0].rigid_loads.end_bearing_forces["A"] == pytest.approx(
        1964.6, rel=1e-3
    )


def test_rating_without_the_bearings_places_is_not_evaluated():
    found = one_shaft("  gearbox_bearing_rating_N: 3000")
    assert {u.missing_inputs for u in found.coverage.unevaluated} == {
        ("gearbox_bearing_spacing_mm and gearbox_bearing_overhang_mm",)
    }
    assert found.verdict == "pass"
