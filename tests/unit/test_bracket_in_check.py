"""A bracket's stiffness in the application file: in series with the rubber, as `check` has it."""

from dataclasses import replace

import numpy as np
import pytest

from cardan import files
from cardan.base.errors import BadFile
from cardan.demand.states import demand, resolve
from cardan.loads.rubber import suspended
from cardan.loads.running import running
from cardan.model.parts import CentreBearing
from cardan.model.seat import LOSS, soft
from cardan.quantity.response import respond
from cardan.shaft.beams import line_beams
from cardan.study.bracket_forced import hung

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
    application = files.loads(text)
    return respond(application, demand(resolve(application, application.lines[0])))


@pytest.mark.parametrize(("told", "loss"), [("", LOSS), (", loss_factor: 0.2", 0.2)])
def test_rubber_and_bracket_are_two_springs_in_series(told, loss):
    """k = k_r k_b / (k_r + k_b), each with its own loss: by hand, where all ways are alike."""
    r = read(LEVEL.replace("[900, 900, 900]", f"[900, 900, 900]{told}"))
    both = 1 / (1 / (200e3 * (1 + 0.1j)) + 1 / (900e3 * (1 + 1j * loss)))
    alone = suspended(r.layout, r.line, stiffness=both.real, loss=both.imag / both.real)
    for speed in (20.0, 42.0, 60.0):
        ours, theirs = (
            running(r.layout, r.line, r.phases, torque=1500.0, speed=speed, held=held).waves
            for held in (r.held, alone)
        )
        # The mean part of the loss moves a spring by η²: here 1e-3 at a resonance.
        assert np.abs(ours - theirs).max() < 2e-3 * np.abs(theirs).max()
    named = r.held.modes().frequency[..., :2]
    series = suspended(r.layout, r.line, stiffness=1 / (1 / 200e3 + 1 / 900e3), loss=0.1)
    assert named == pytest.approx(series.modes().frequency[..., :2], rel=1e-6)


def test_a_bracket_lowers_what_the_rubber_alone_makes():
    r, firm = (
        read(LEVEL),
        read(LEVEL.replace("        bracket: {stiffness_N_mm: [900, 900, 900]}\n", "")),
    )
    lower = r.held.modes().frequency[0, :2] / firm.held.modes().frequency[0, :2]
    assert lower == pytest.approx(np.sqrt(900 / 1100), rel=2e-3)
    whirl = line_beams(r.line).bearing_stiffness
    assert whirl == pytest.approx(np.full((1, 2), 1 / (1 / 200e3 + 1 / 900e3)))


def test_the_elements_of_a_bracket_take_its_place():
    """`cardan bracket` knows more of it: it counts once, and the rubber stays the rubber."""
    r = read(LEVEL)
    bracket = type("Bracket", (), {"bearing": 1, "rubber": None})()
    own = hung(r, bracket, soft((900e3, 900e3, 900e3)))
    bearing = own.line.shafts[0].centre_bearing
    assert bearing.stiffness == (200e3, 200e3)
    assert bearing.bracket_stiffness is None
    assert own.held.modes().frequency[0, :2] == pytest.approx(
        r.held.modes().frequency[0, :2], rel=1e-9
    )


def test_a_rigid_bearing_in_a_bracket_that_gives():
    alone = replace(CentreBearing(), bracket_stiffness=(1e6, 2e6, 3e6))
    assert alone.across == (3e6, 2e6)
    assert CentreBearing(stiffness=(1e5, 2e5)).across == (1e5, 2e5)


def test_a_bracket_that_cannot_be():
    for wrong in ("[900, 900]", "[0, 900, 900]", "900"):
        with pytest.raises(BadFile, match="stiffness_N_mm"):
            files.loads(LEVEL.replace("[900, 900, 900]", wrong))
    for wrong in ("0", "1", "-0.1"):
        with pytest.raises(BadFile, match=r"bracket\.loss_factor"):
            files.loads(LEVEL.replace("900]}", f"900], loss_factor: {wrong}}}"))
