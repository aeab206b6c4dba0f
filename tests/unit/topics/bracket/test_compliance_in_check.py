"""A bracket's stiffness in the application file: in series with the rubber, as `check` has it."""

from dataclasses import replace

import numpy as np
import pytest

from cardan.application import reader
from cardan.checks.line_response import compute_line_response
from cardan.core.errors import InvalidFileError
from cardan.model.bracket_compliance import (
    DEFAULT_BRACKET_LOSS_FACTOR,
    bracket_compliance_from_stiffness,
)
from cardan.model.parts import CentreBearing
from cardan.physics.loads.centre_bearing import bearing_forces
from cardan.physics.loads.mounted_line_model import mounted_line
from cardan.physics.strength.beams import beam_model
from cardan.physics.vehicle.state_demand import line_state_demand, resolve_line_references
from cardan.topics.bracket.forced_response import line_response_on_bracket

LEVEL = """
title: A level line
torque_Nm: 1500
speed_rpm: 2400
driveline:
  slopes: {side_deg: [3, 0, 0, 2], top_deg: [0, 0, 0, 1]}
  shafts:
    - length_mm: 1200
      tube: 100x3
      centre_bearing:
        from_rear_joint_mm: 140
        stiffness_N_mm: 200
        axial_stiffness_N_mm: 200
        loss_factor: 0.1
        bracket: {stiffness_N_mm: [900, 900, 900]}
    - {length_mm: 1500, tube: 100x3}
"""


def read(text: str):
    application = reader.loads(text)
    return compute_line_response(
        application, line_state_demand(resolve_line_references(application, application.lines[0]))
    )


@pytest.mark.parametrize(
    ("told", "loss"), [("", DEFAULT_BRACKET_LOSS_FACTOR), (", loss_factor: 0.2", 0.2)]
)
def test_rubber_and_bracket_act_in_series(told, loss):
    """k = k_r k_b / (k_r + k_b), each with its own loss: by hand, where all ways are alike."""
    r = read(LEVEL.replace("[900, 900, 900]", f"[900, 900, 900]{told}"))
    both = 1 / (1 / (200e3 * (1 + 0.1j)) + 1 / (900e3 * (1 + 1j * loss)))
    alone = mounted_line(r.layout, r.line, stiffness=both.real, loss=both.imag / both.real)
    for speed in (20.0, 42.0, 60.0):
        ours, theirs = (
            bearing_forces(r.layout, r.line, r.phases, torque=1500.0, speed=speed, held=held).waves
            for held in (r.mounts.mounted_line, alone)
        )
        # The mean part of the loss moves a spring by η²: here 1e-3 at a resonance.
        assert np.abs(ours - theirs).max() < 2e-3 * np.abs(theirs).max()
    named = r.mounts.mounted_line.modes().frequency[..., :2]
    series = mounted_line(r.layout, r.line, stiffness=1 / (1 / 200e3 + 1 / 900e3), loss=0.1)
    assert named == pytest.approx(series.modes().frequency[..., :2], rel=1e-6)


def test_bracket_compliance_lowers_natural_frequencies():
    r, firm = (
        read(LEVEL),
        read(LEVEL.replace("        bracket: {stiffness_N_mm: [900, 900, 900]}\n", "")),
    )
    lower = (
        r.mounts.mounted_line.modes().frequency[0, :2]
        / firm.mounts.mounted_line.modes().frequency[0, :2]
    )
    assert lower == pytest.approx(np.sqrt(900 / 1100), rel=2e-3)
    whirl = beam_model(r.line).bearing_stiffness
    assert whirl == pytest.approx(np.full((1, 2), 1 / (1 / 200e3 + 1 / 900e3)))


def test_finite_element_bracket_replaces_given_stiffness():
    """`cardan bracket` knows more of it: it counts once, and the rubber stays the rubber."""
    r = read(LEVEL)
    bracket = type("Bracket", (), {"bearing": 1, "rubber": None})()
    own = line_response_on_bracket(
        r, bracket, bracket_compliance_from_stiffness((900e3, 900e3, 900e3))
    )
    bearing = own.line.shafts[0].centre_bearing
    assert bearing.stiffness == (200e3, 200e3)
    assert bearing.bracket_stiffness is None
    assert own.mounts.mounted_line.modes().frequency[0, :2] == pytest.approx(
        r.mounts.mounted_line.modes().frequency[0, :2], rel=1e-9
    )


def test_rigid_bearing_uses_bracket_stiffness():
    alone = replace(CentreBearing(), bracket_stiffness=(1e6, 2e6, 3e6))
    assert alone.transverse_stiffness == (3e6, 2e6)
    assert CentreBearing(stiffness=(1e5, 2e5)).transverse_stiffness == (1e5, 2e5)


def test_invalid_bracket_stiffness_is_rejected():
    for wrong in ("[900, 900]", "[0, 900, 900]", "900"):
        with pytest.raises(InvalidFileError, match="stiffness_N_mm"):
            reader.loads(LEVEL.replace("[900, 900, 900]", wrong))
    for wrong in ("0", "1", "-0.1"):
        with pytest.raises(InvalidFileError, match=r"bracket\.loss_factor"):
            reader.loads(LEVEL.replace("900]}", f"900], loss_factor: {wrong}}}"))
