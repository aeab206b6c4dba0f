"""Strength of tubes, by hand."""

from dataclasses import replace

import numpy as np
import pytest
from repository import EXAMPLES

from cardan.application import limit_profiles, reader
from cardan.approval.driveline_study import line_checks, unevaluated_line_checks
from cardan.checks.line_response import LineResponse, compute_line_response
from cardan.core.units import MPa
from cardan.core.verdict import Limit
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
