"""Strength of tubes, by hand."""

from dataclasses import replace

import numpy as np
import pytest
from repository import EXAMPLES

from cardan.application import limit_profiles, reader
from cardan.approval.driveline_study import line_checks, unevaluated_line_checks
from cardan.checks.line_response import LineResponse, compute_line_response
from cardan.core.units import MPa, mm
from cardan.core.verdict import Limit
from cardan.physics.strength.torsional_strength import tube_buckling_torque
from cardan.physics.vehicle.resolved_line import resolve_line_references
from cardan.physics.vehicle.state_demand import line_state_demand

LIMIT = Limit(
    quantity="tube_fatigue_utilisation",
    maximum=1.0,
    source=limit_profiles.load_profile("heavy-truck")[1][0].source,
)


def response_with_material(**given) -> LineResponse:
    """Return the medium truck's response with other properties of its tubes' material."""
    truck = reader.read(EXAMPLES / "medium-truck-4x2.yaml")
    (installed,) = truck.lines
    shafts = tuple(
        replace(s, tube=replace(s.tube, material=replace(s.tube.material, **given)))
        for s in installed.line.shafts
    )
    installed = replace(installed, line=replace(installed.line, shafts=shafts))
    application = replace(truck, lines=(installed,), limits=(LIMIT,))
    return compute_line_response(
        application, line_state_demand(resolve_line_references(application, installed))
    )


@pytest.mark.parametrize("ultimate", [None, 600 * MPa])
def test_tube_fatigue_utilisation_is_checked_from_coast_to_drive_torque(ultimate):
    response = response_with_material(fatigue_shear=120 * MPa, ultimate_strength=ultimate)
    found = {
        (c.when.name, c.part.number): c.value for c in line_checks(response) if c.limit is LIMIT
    }
    state = response.demand.states.index("gvw")
    drive, coast = response.demand.torque[state], response.demand.coast_torque[state]
    assert drive > coast > 0
    for k, shaft in enumerate(response.line.shafts, 1):
        D, d = shaft.tube.outer, shaft.tube.inner
        section = np.pi * (D**4 - d**4) / (16 * D)
        used = (drive + coast) / 2 / section / 120e6
        if ultimate is not None:
            used += (drive - coast) / 2 / section / (0.67 * 600e6)
        assert found["gvw", k] == pytest.approx(used, rel=1e-12)
    assert not [u for u in unevaluated_line_checks(response) if u.limit is LIMIT]


def test_tube_fatigue_is_not_evaluated_without_endurance_of_material():
    response = response_with_material(fatigue_shear=None)
    assert not [c for c in line_checks(response) if c.limit is LIMIT]
    silent = [u for u in unevaluated_line_checks(response) if u.limit is LIMIT]
    missing = {m for u in silent for m in u.missing_inputs}
    assert missing == {"a tube material with its fatigue_shear_MPa"}


def test_torque_round_the_turn_keeps_the_power_that_the_shafts_inertia_takes():
    """At constant gearbox speed: T₀ ω = Tₙ ωₙ + Σ J α ω of the shafts, at every instant."""
    r = response_with_material()
    turned = r.inputs.turned(r.inputs.demand.torque, samples=64)
    torque = r.rigid_loads.joint_loads_with_inertia[0].torques.values(64)[:, -1, :, 0]
    w, given = (np.nan_to_num(v)[:, None] for v in (r.demand.speed, r.demand.torque))
    taken = w**2 * np.einsum(
        "k,skt->st", r.inputs.shaft_inertias, (turned.acceleration * turned.speed)[:, :-1]
    )
    assert torque * turned.speed[:, -1] == pytest.approx(given - taken, rel=1e-9)
    assert np.abs(taken).max() > 5


def test_sizing_torque_at_joint_1_is_the_larger_of_state_and_engine_with_shocks():
    r = response_with_material()
    demand = r.demand
    expected = np.fmax(demand.engine_torque, np.abs(demand.torque)) * r.application.shock_factor
    braked = [kind == "windup brake" for kind in r.inputs.state_kinds]
    assert r.strength.sizing_torque[~np.array(braked), 0] == pytest.approx(
        expected[~np.array(braked)], rel=1e-12
    )


def test_buckling_utilisation_is_torque_with_shocks_over_what_buckles_the_wall():
    r = response_with_material()
    lengths = r.demand.installed.layout.lengths
    for k, shaft in enumerate(r.line.shafts):
        tube = shaft.tube
        held = tube_buckling_torque(
            outer=tube.outer, inner=tube.inner, modulus=tube.material.youngs_modulus,
            poisson=tube.material.poisson, length=lengths[k],
        )  # fmt: skip
        expected = np.abs(r.demand.torque) * r.application.shock_factor / held
        assert r.strength.tube_buckling_utilisation[:, k] == pytest.approx(expected, rel=1e-12)


def test_spline_travel_left_is_to_its_stop_inward_or_outward():
    """Plunge 55 mm and draw 45 mm from the length as installed, whichever end is nearer."""
    r = response_with_material()
    longer = r.layout.lengths[:, -1] - r.demand.installed.layout.lengths[-1]
    assert longer.min() < -1e-3
    assert longer.max() > 1e-4
    inward, outward = 55 * mm + longer, 45 * mm - longer
    left = r.clearances.spline_travel_margin
    assert left == pytest.approx(np.minimum(inward, outward), rel=1e-12)
    assert {float(a < b) for a, b in zip(inward, outward, strict=True)} == {0.0, 1.0}
