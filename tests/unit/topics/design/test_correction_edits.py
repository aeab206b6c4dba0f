"""A correction written into the file: a check of the file gives what was proposed."""

from dataclasses import replace

import numpy as np
import pytest
from repository import EXAMPLES

from cardan.application import reader, templates
from cardan.application.yaml_edit import YamlEditor
from cardan.approval.applied_adjustments import (
    AppliedAdjustment,
    allowed_adjustments,
    response_with_adjustments,
)
from cardan.approval.driveline_study import line_checks
from cardan.checks.line_response import LineResponse, compute_line_response
from cardan.checks.quantities.registry import QUANTITIES
from cardan.model.adjustments import ADJUSTMENTS
from cardan.model.application import Application
from cardan.physics.vehicle.state_demand import line_state_demand, resolve_line_references
from cardan.topics.design.correction_edits import correction_changes

STARTERS = {name: templates.template_text(name) for name in ("small", "truck", "bus", "industrial")}
BOGIES = {"6x4": templates.template_text("6x4")}
SHIPPED = {
    path.stem: path.read_text(encoding="utf-8")
    for path in sorted(EXAMPLES.glob("*.yaml"))
    # Those of VECTO name files of their folder; tandem and composite van are built as others are.
    if not path.stem.startswith(("vecto", "tandem", "composite"))
}

ROUNDING_SHARE_OF_LIMIT = 0.005
"""What 0.01 mm and 0.001 deg, to which a file is written, make of a margin: 0.003 at most, where a
joint bends by a degree and the limit is a third of one."""


def without_point_search(application: Application) -> Application:
    """Limits of forces that are sought over all operating points left out: they take seconds."""
    kept = (m for m in application.limits if not QUANTITIES[m.quantity].find_worst_points)
    return replace(application, limits=tuple(kept))


def line_of(application: Application, name: str) -> LineResponse:
    installed = next(i for i in application.lines if i.line.name == name)
    return compute_line_response(
        application, line_state_demand(resolve_line_references(application, installed))
    )


def margins(of: LineResponse) -> dict:
    return {
        (c.quantity, c.limit.normal, c.limit.maximum, str(c.part), str(c.when)): c.margin
        for c in line_checks(of)
    }


def moved(r: LineResponse) -> tuple[AppliedAdjustment, ...]:
    """Everything that may move, part of its way; bearings and axles by a workshop's steps."""
    found = []
    for a in allowed_adjustments(r):
        kind = ADJUSTMENTS[a.adjustment_key]
        step = kind.resolution or 1.0
        amount = a.high if kind.extremes_only else max(step, step * round(0.3 * a.high / step))
        found.append(AppliedAdjustment(adjustable=a, amount=min(amount, a.high)))
    return tuple(found)


def allowed(quantity: str) -> float:
    """Return by how much of its limit a margin may be off; forces at a stop move with the grid."""
    return 0.05 if quantity.startswith("centre_bearing_") else ROUNDING_SHARE_OF_LIMIT


def assert_file_gives_what_was_proposed(text: str, *, forces: bool) -> None:
    limited = without_point_search if not forces else lambda application: application
    application = limited(reader.loads(text))
    assert any(moved(line_of(application, i.line.name)) for i in application.lines)
    for installed in application.lines:
        before = line_of(application, installed.line.name)
        moves = moved(before)
        if not moves:
            continue  # held by the file
        proposed = response_with_adjustments(
            before, tuple(m.adjustable for m in moves), np.array([m.amount for m in moves])
        )
        editor = YamlEditor(text)
        written = editor.with_changes(correction_changes(before, moves, editor))
        found = margins(line_of(limited(reader.loads(written)), installed.line.name))
        expected = margins(proposed)
        assert found.keys() == expected.keys()
        off = {k: (found[k], m) for k, m in expected.items()
               if not abs(found[k] - m) <= allowed(k[0]) and found[k] != m}  # fmt: skip
        assert not off, (installed.line.name, off)


@pytest.mark.parametrize("name", STARTERS)
def test_starter_with_a_correction_written_in_checks_as_proposed(name):
    """By slopes, by points, and with a geometry of its own in each state."""
    assert_file_gives_what_was_proposed(STARTERS[name], forces=name == "truck")


@pytest.mark.slow
@pytest.mark.parametrize("name", [*SHIPPED, *BOGIES])
def test_example_with_a_correction_written_in_checks_as_proposed(name):
    assert_file_gives_what_was_proposed((SHIPPED | BOGIES)[name], forces=False)


def test_file_by_slopes_changes_slopes_and_lengths_alone():
    application = reader.loads(STARTERS["small"])
    r = line_of(application, "main")
    bearing = [a for a in allowed_adjustments(r) if a.adjustment_key == "bearing_height"]
    editor = YamlEditor(STARTERS["small"])
    changes = correction_changes(
        r, [AppliedAdjustment(adjustable=bearing[0], amount=-0.010)], editor
    )
    assert set(changes) == {
        "driveline.slopes.side_deg[2]",
        "driveline.slopes.side_deg[3]",
        "driveline.shafts[2].length_mm",
    }
    # A bearing 1060 mm behind joint 1 goes down 10 mm: its shaft falls 0.54 deg more.
    fall = np.degrees(np.arctan(np.tan(np.radians(1.0)) + 10 / (1060 * np.cos(np.radians(1.0)))))
    assert changes["driveline.slopes.side_deg[2]"] == pytest.approx(fall, abs=1e-3)


def test_ranges_of_adjust_count_from_the_new_place():
    text = STARTERS["truck"]
    r = line_of(reader.loads(text), "main")
    high = next(a for a in allowed_adjustments(r) if a.adjustment_key == "bearing_height")
    changes = correction_changes(
        r, [AppliedAdjustment(adjustable=high, amount=0.010)], YamlEditor(text)
    )
    assert changes["adjust.bearing_height_mm.1[1]"] == -30
    assert changes["adjust.bearing_height_mm.1[2]"] == 20
