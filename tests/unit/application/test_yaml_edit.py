"""A file written in: only what was meant changes, and stands in the file as it is asked for."""

import numpy as np
import pytest
from repository import ROOT

from cardan.application import overrides, reader
from cardan.application.layout_writer import layout_changes, phase_changes
from cardan.application.yaml_edit import RawYaml, YamlEditor
from cardan.checks.line_response import compute_line_response
from cardan.core.errors import DesignError, InvalidFileError
from cardan.core.units import deg, mm
from cardan.model.layout import unit_vector
from cardan.physics.vehicle.axle_motion import layout_after_axle_motion
from cardan.physics.vehicle.state_demand import line_state_demand, resolve_line_references
from cardan.topics.design.drag_handles import (
    STUB_SHAFT_TO_LINE_LENGTH_RATIO,
    DragHandle,
    drag_handles_of,
    input_changes_for_drag,
)
from cardan.topics.design.suspension_travel import line_at_axle_position, travel_range

EXAMPLES = sorted((ROOT / "examples").glob("*.yaml"))

SLOPES = """title: t
speed_rpm: 2000
torque_Nm: 3000
driveline:
  slopes: {side_deg: [3.0, 1.0, 4.5, 2.0]}  # gearbox first
  shafts:
    - length_mm: 1200
      tube: {outer_mm: 101.6, wall_mm: 3.2}
      centre_bearing: {from_rear_joint_mm: 140}
    - {length_mm: 1500, tube: {outer_mm: 101.6, wall_mm: 3.2}}
"""


@pytest.mark.slow
@pytest.mark.parametrize("path", EXAMPLES, ids=lambda p: p.stem)
def test_every_number_of_file_can_be_edited_alone(path):
    text = path.read_text("utf-8")
    numbers, script = overrides.addresses(reader.loads(text)), YamlEditor(text)
    there = [at for at in numbers if at in script]
    assert len(there) > 10
    was = {a: script.scalar_text(a) for a in script.addresses}
    for at in there:
        new = script.with_changes({at: numbers[at] * 1.0001 + 1e-5})
        read = YamlEditor(new)
        assert [a for a in was if read.scalar_text(a) != was[a]] == [at]
        assert float(read.scalar_text(at)) == pytest.approx(numbers[at] * 1.0001 + 1e-5)
        assert new.count("#") == text.count("#")
        assert len(new.splitlines()) == len(text.splitlines())


def test_edit_preserves_comments_order_quotes_and_line_ends():
    text = 'a: 1.50  # one\r\nb: "two"\r\nc: {d: 3, e: [4, 5]} # six\r\n'
    new = YamlEditor(text).with_changes({"a": 2.0, "b": "20: 4", "c.e[2]": -7.25})
    assert new == 'a: 2.00  # one\r\nb: "20: 4"\r\nc: {d: 3, e: [4, -7.25]} # six\r\n'


def test_quoted_value_is_replaced_whole():
    text = """a: "\\x31 \\"x\\": y" # one\nb: 'it''s'\nc: "two\n  lines"\nd: 4\n"""
    new = YamlEditor(text).with_changes({"a": 2.0, "b": "3: 4", "c": "one"})
    assert new == 'a: 2 # one\nb: "3: 4"\nc: one\nd: 4\n'


def test_edit_of_yaml_alias_changes_only_that_key():
    text = "a: &n 1.50\nb: *n  # as a\nc: {d: *n, e: 2}\n"
    assert YamlEditor(text).with_changes({"b": 3}) == "a: &n 1.50\nb: 3  # as a\nc: {d: *n, e: 2}\n"
    new = YamlEditor(text).with_changes({"c.d": 4, "b": 3})
    assert new == "a: &n 1.50\nb: 3  # as a\nc: {d: 4, e: 2}\n"
    assert YamlEditor(new).scalar_text("a") == "1.50"


def test_list_items_are_inserted_before_existing_items():
    rows = [RawYaml("{x: 0}"), RawYaml("{x: 1}")]
    text = "a:\n  - {x: 2}  # two\n  - {x: 3}\nb: [{x: 2}]\n"
    assert YamlEditor(text).with_changes({"a[+]": rows, "b[+]": rows}) == (
        "a:\n  - {x: 0}\n  - {x: 1}\n  - {x: 2}  # two\n  - {x: 3}\nb: [{x: 0}, {x: 1}, {x: 2}]\n"
    )
    assert YamlEditor("c: []\n").with_changes({"c[+]": rows}) == "c: [{x: 0}, {x: 1}]\n"
    # A list that is not there yet is made; its table has to be there.
    assert YamlEditor(text).with_changes({"c[+]": rows}) == f"c: [{{x: 0}}, {{x: 1}}]\n{text}"
    with pytest.raises(InvalidFileError, match="no list"):
        YamlEditor(text).with_changes({"a[1][+]": rows})
    with pytest.raises(InvalidFileError, match="nor does the table"):
        YamlEditor(text).with_changes({"d.c[+]": rows})


def test_list_item_is_removed_without_other_changes():
    text = 'a:\n  - x=1  # one\n  # before two\n  - "y=2"\n  - z\nb: [p, "q, r", s] # b\n'
    script = YamlEditor(text)
    assert script.with_changes({"a[-]": "x=1"}) == text.replace("  - x=1  # one\n", "")
    assert script.with_changes({"a[-]": "y=2"}) == text.replace('  - "y=2"\n', "")
    assert script.with_changes({"b[-]": "p"}) == text.replace("[p, ", "[")
    assert script.with_changes({"b[-]": "q, r"}) == text.replace('"q, r", ', "")
    assert script.with_changes({"b[-]": "s", "a[-]": "z"}) == (
        text.replace(", s]", "]").replace("  - z\n", "")
    )
    assert YamlEditor("a:\n- x  # one\nb: [y]\n").with_changes({"a[-]": "x", "b[-]": "y"}) == (
        "a:\n[]  # one\nb: []\n"
    )
    # What a name stands for, or is not there, is not guessed at.
    for other in ("c: &n [x]\nd: *n\n", "c: [y]\n", "c: {x: 1}\n", "d: 1\n"):
        with pytest.raises(InvalidFileError, match="has no 'x' of its own"):
            YamlEditor(other).with_changes({"c[-]": "x"})


def test_missing_key_is_added_to_its_table():
    text = "a:\n  - x: 1\n    y: 2\n  - {x: 1}\n"
    script = YamlEditor(text)
    assert script.with_changes({"a[1].z": 3}) == "a:\n  - z: 3\n    x: 1\n    y: 2\n  - {x: 1}\n"
    assert (
        script.with_changes({"a[2].z": [1.5, 2]})
        == "a:\n  - x: 1\n    y: 2\n  - {z: [1.5, 2], x: 1}\n"
    )


@pytest.mark.parametrize(
    ("text", "at", "says"),
    [
        ("a: &n [1, 2]\nb: *n\n", "b[1]", "names stand for it"),
        ("a: &n {c: 1}\nb: *n\n", "b.c", "names stand for it"),
        ("a: [&n 1, *n]\n", "a[2]", "names stand for it"),
        ("a: &n 1\nb: *n\n", "a", "names stand for it"),
        ("a: 1\n", "b.c", "nor does the table"),
        ("a: [1, 2]\n", "a", "a table or a list"),
        ("? {a: 1}\n: 2\n", "a", "a key must be a word"),
    ],
)
def test_edit_impossible_in_place_is_rejected(text, at, says):
    with pytest.raises(InvalidFileError, match=says):
        YamlEditor(text).with_changes({at: 2})


def installed(text):
    application = reader.loads(text)
    return application, application.lines[0], YamlEditor(text)


ANGLES = SLOPES.replace(
    "slopes: {side_deg: [3.0, 1.0, 4.5, 2.0]}",
    "gearbox_slope: {side_deg: 1.0}\n"
    "  joint_angles: {side_deg: [-2.0, 3.5, -2.5], top_deg: [0.5, 0.1, -0.6]}",
)
NAMED = {p.stem: p for p in EXAMPLES}
TEXTS = {
    "points": NAMED["refuse-collector-6x2"].read_text("utf-8"),
    "slopes": SLOPES,
    "angles": ANGLES,
    "lines": NAMED["tandem-6x4"].read_text("utf-8"),
}


@pytest.mark.parametrize("text", TEXTS.values(), ids=TEXTS)
@pytest.mark.parametrize("by", [(0, 0, 8.0), (0, -5.0, 0), (0, 3.0, -12.0)])
def test_dragged_bearing_is_written_at_new_position(text, by):
    """The chain hung anew by demand.motion is what the file says after: to 0.1 mm, rounding."""
    application, line, script = installed(text)
    shift = np.zeros((line.line.joint_count - 2, 3))
    shift[0] = np.array(by) * mm
    meant = layout_after_axle_motion(line.layout, line.line, bearing_shift=shift)
    handle = DragHandle(kind="bearing", number=1, line=line.line.name, axes="")
    new = reader.loads(
        script.with_changes(input_changes_for_drag(application, handle, shift[0], script))
    ).lines[0]
    assert abs(new.layout.points - meant.points).max() < 0.1 * mm
    assert abs(new.layout.directions - meant.directions).max() < 1e-4
    k = line.line.shafts[0].centre_bearing.from_rear_joint
    centre = [o.points[1] - k * o.directions[1] for o in (line.layout, new.layout)]
    assert abs(centre[1] - centre[0] - shift[0])[1:].max() < 0.1 * mm  # it slides along its shaft


@pytest.mark.parametrize("text", TEXTS.values(), ids=TEXTS)
def test_dragged_joint_moves_alone(text):
    application, line, script = installed(text)
    handle = DragHandle(kind="joint", number=2, line=line.line.name, axes="")
    by = np.array([5.0, 2.0, -6.0]) * mm
    new = reader.loads(
        script.with_changes(input_changes_for_drag(application, handle, by, script))
    ).lines[0]
    step = (new.layout.points - line.layout.points) / mm
    assert step[1, 1:] == pytest.approx([2.0, -6.0], abs=0.05)
    others = [0, *range(2, len(step))]
    assert abs(step[others, 1:]).max() < 0.1
    assert abs(step[:, 0]).max() < 0.5  # along the line only what the lengths ask for


@pytest.mark.parametrize("kind", ["gearbox", "pinion"])
@pytest.mark.parametrize("text", TEXTS.values(), ids=TEXTS)
def test_dragged_stub_shaft_rotates_about_its_joint(text, kind):
    application, line, script = installed(text)
    by = np.array([0, 0, 10.0]) * mm
    handle = DragHandle(kind=kind, number=1, line=line.line.name, axes="")
    new = reader.loads(
        script.with_changes(input_changes_for_drag(application, handle, by, script))
    ).lines[0]
    assert abs(new.layout.points - line.layout.points).max() < 0.1 * mm
    span = np.linalg.norm(line.layout.points[-1] - line.layout.points[0])
    end, sign = (0, -1) if kind == "gearbox" else (-1, 1)
    meant = unit_vector(
        STUB_SHAFT_TO_LINE_LENGTH_RATIO * span * line.layout.directions[end] + sign * by
    )
    assert new.layout.directions[end] == pytest.approx(meant, abs=2e-5)


def test_dragged_obstacle_moves_along_all_axes():
    application, _, script = installed(TEXTS["points"])
    handle = DragHandle(kind="obstacle", number=1, line="main", axes="")
    edits = input_changes_for_drag(application, handle, np.array([10.0, 1.0, -3.5]) * mm, script)
    new = reader.loads(script.with_changes(edits)).obstacles[0]
    assert new.start == pytest.approx((2.56, -0.499, -0.2805))
    assert new.end == pytest.approx((2.56, 0.501, -0.2805))


def test_drag_of_unknown_part_is_rejected():
    application, _, script = installed(SLOPES)
    known = {(h.kind, h.number) for h in drag_handles_of(application, script)}
    assert known == {
        ("joint", 2), ("joint", 3), ("bearing", 1), ("gearbox", 1), ("pinion", 1)
    }  # fmt: skip
    for kind, number in (("joint", 1), ("bearing", 2), ("obstacle", 1), ("joint", 0)):
        with pytest.raises(DesignError, match="there is no"):
            input_changes_for_drag(
                application,
                DragHandle(kind=kind, number=number, line="main", axes=""),
                (0, 0, 0.01),
                script,
            )


def test_missing_yoke_phase_is_added_to_file():
    application, line, script = installed(SLOPES)
    new = reader.loads(script.with_changes(phase_changes(line, (0.0, 90 * deg), script)))
    assert new.lines[0].line.phases == pytest.approx([0, 90 * deg])
    del application


def test_unchanged_layout_writes_no_edit():
    for text in TEXTS.values():
        _, line, script = installed(text)
        assert layout_changes(line, line.layout, script) == {}


@pytest.mark.parametrize("path", EXAMPLES[:3], ids=lambda p: p.stem)
def test_height_slider_range_covers_all_states(path):
    """At a state's own height and wind-up torque the line runs as the state says."""
    application = reader.read(path)
    for line in application.lines:
        asked = line_state_demand(resolve_line_references(application, line))
        response = compute_line_response(application, asked)
        ends = travel_range(response)
        assert ends.travel[0] <= asked.travel.min()
        assert asked.travel.max() <= ends.travel[1]
        if ends.travel[0] == ends.travel[1]:
            continue
        kinds = np.array([s.kind for s in application.states])
        free = np.array([s.layouts is None for s in application.states])
        still = free & (kinds != "windup") & (kinds != "windup brake")
        one = line_at_axle_position(application, line, travel=asked.travel[still], torque=0.0)
        assert one.layout.points == pytest.approx(asked.layout.points[still], abs=1e-12)
        assert one.clearances.obstacle_clearances == pytest.approx(
            response.clearances.obstacle_clearances[still], abs=1e-12
        )
        for k in np.flatnonzero(kinds == "windup"):
            one = line_at_axle_position(
                application, line, travel=asked.travel[[k]], torque=asked.torque[k]
            )
            assert one.layout.points[0] == pytest.approx(asked.layout.points[k], abs=1e-12)
            assert ends.torque[0] <= 0 <= asked.torque[k] <= ends.torque[1]
