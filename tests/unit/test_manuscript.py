"""A file written in: only what was meant changes, and stands in the file as it is asked for."""

from pathlib import Path

import numpy as np
import pytest

from cardan import files
from cardan.base.errors import BadFile, DesignError
from cardan.base.units import deg, mm
from cardan.demand.motion import moved
from cardan.demand.states import demand, resolve
from cardan.files.manuscript import Manuscript, Raw
from cardan.files.placing import phased, placed
from cardan.model.layout import unit
from cardan.quantity.response import respond
from cardan.study.drag import STUB, Handle, dragged, handles
from cardan.study.ride import reach, ride

EXAMPLES = sorted((Path(__file__).parents[2] / "examples").glob("*.yaml"))

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


@pytest.mark.parametrize("path", EXAMPLES, ids=lambda p: p.stem)
def test_every_number_of_a_file_can_be_written_anew_by_itself(path):
    text = path.read_text("utf-8")
    numbers, script = files.addresses(files.loads(text)), Manuscript(text)
    there = [at for at in numbers if at in script]
    assert len(there) > 10
    was = {a: script.written(a) for a in script.addresses}
    for at in there:
        new = script.with_({at: numbers[at] * 1.0001 + 1e-5})
        read = Manuscript(new)
        assert [a for a in was if read.written(a) != was[a]] == [at]
        assert float(read.written(at)) == pytest.approx(numbers[at] * 1.0001 + 1e-5)
        assert new.count("#") == text.count("#")
        assert len(new.splitlines()) == len(text.splitlines())


def test_comments_order_quotes_and_line_ends_stay():
    text = 'a: 1.50  # one\r\nb: "two"\r\nc: {d: 3, e: [4, 5]} # six\r\n'
    new = Manuscript(text).with_({"a": 2.0, "b": "20: 4", "c.e[2]": -7.25})
    assert new == 'a: 2.00  # one\r\nb: "20: 4"\r\nc: {d: 3, e: [4, -7.25]} # six\r\n'


def test_quoted_text_is_replaced_whole_however_it_is_written():
    text = """a: "\\x31 \\"x\\": y" # one\nb: 'it''s'\nc: "two\n  lines"\nd: 4\n"""
    new = Manuscript(text).with_({"a": 2.0, "b": "3: 4", "c": "one"})
    assert new == 'a: 2 # one\nb: "3: 4"\nc: one\nd: 4\n'


def test_a_value_is_written_in_place_of_a_name_for_it_there_alone():
    text = "a: &n 1.50\nb: *n  # as a\nc: {d: *n, e: 2}\n"
    assert Manuscript(text).with_({"b": 3}) == "a: &n 1.50\nb: 3  # as a\nc: {d: *n, e: 2}\n"
    new = Manuscript(text).with_({"c.d": 4, "b": 3})
    assert new == "a: &n 1.50\nb: 3  # as a\nc: {d: 4, e: 2}\n"
    assert Manuscript(new).written("a") == "1.50"


def test_items_are_put_before_a_lists_others():
    rows = [Raw("{x: 0}"), Raw("{x: 1}")]
    text = "a:\n  - {x: 2}  # two\n  - {x: 3}\nb: [{x: 2}]\n"
    assert Manuscript(text).with_({"a[+]": rows, "b[+]": rows}) == (
        "a:\n  - {x: 0}\n  - {x: 1}\n  - {x: 2}  # two\n  - {x: 3}\nb: [{x: 0}, {x: 1}, {x: 2}]\n"
    )
    assert Manuscript("c: []\n").with_({"c[+]": rows}) == "c: [{x: 0}, {x: 1}]\n"
    # A list that is not there yet is made; its table has to be there.
    assert Manuscript(text).with_({"c[+]": rows}) == f"c: [{{x: 0}}, {{x: 1}}]\n{text}"
    with pytest.raises(BadFile, match="no list"):
        Manuscript(text).with_({"a[1][+]": rows})
    with pytest.raises(BadFile, match="nor does the table"):
        Manuscript(text).with_({"d.c[+]": rows})


def test_an_item_is_taken_out_of_a_list_and_all_else_stays():
    text = 'a:\n  - x=1  # one\n  # before two\n  - "y=2"\n  - z\nb: [p, "q, r", s] # b\n'
    script = Manuscript(text)
    assert script.with_({"a[-]": "x=1"}) == text.replace("  - x=1  # one\n", "")
    assert script.with_({"a[-]": "y=2"}) == text.replace('  - "y=2"\n', "")
    assert script.with_({"b[-]": "p"}) == text.replace("[p, ", "[")
    assert script.with_({"b[-]": "q, r"}) == text.replace('"q, r", ', "")
    assert script.with_({"b[-]": "s", "a[-]": "z"}) == (
        text.replace(", s]", "]").replace("  - z\n", "")
    )
    assert Manuscript("a:\n- x  # one\nb: [y]\n").with_({"a[-]": "x", "b[-]": "y"}) == (
        "a:\n[]  # one\nb: []\n"
    )
    # What a name stands for, or is not there, is not guessed at.
    for other in ("c: &n [x]\nd: *n\n", "c: [y]\n", "c: {x: 1}\n", "d: 1\n"):
        with pytest.raises(BadFile, match="has no 'x' of its own"):
            Manuscript(other).with_({"c[-]": "x"})


def test_a_key_that_is_not_there_is_put_into_its_table():
    text = "a:\n  - x: 1\n    y: 2\n  - {x: 1}\n"
    script = Manuscript(text)
    assert script.with_({"a[1].z": 3}) == "a:\n  - z: 3\n    x: 1\n    y: 2\n  - {x: 1}\n"
    assert script.with_({"a[2].z": [1.5, 2]}) == "a:\n  - x: 1\n    y: 2\n  - {z: [1.5, 2], x: 1}\n"


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
def test_what_cannot_be_written_in_place_is_refused(text, at, says):
    with pytest.raises(BadFile, match=says):
        Manuscript(text).with_({at: 2})


def installed(text):
    application = files.loads(text)
    return application, application.lines[0], Manuscript(text)


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
def test_a_dragged_bearing_stands_where_it_was_dragged(text, by):
    """The chain hung anew by demand.motion is what the file says after: to 0.1 mm, rounding."""
    application, line, script = installed(text)
    shift = np.zeros((line.line.joint_count - 2, 3))
    shift[0] = np.array(by) * mm
    meant = moved(line.layout, line.line, bearing_shift=shift)
    handle = Handle(kind="bearing", number=1, line=line.line.name, ways="")
    new = files.loads(script.with_(dragged(application, handle, shift[0], script))).lines[0]
    assert abs(new.layout.points - meant.points).max() < 0.1 * mm
    assert abs(new.layout.directions - meant.directions).max() < 1e-4
    k = line.line.shafts[0].centre_bearing.from_rear_joint
    centre = [o.points[1] - k * o.directions[1] for o in (line.layout, new.layout)]
    assert abs(centre[1] - centre[0] - shift[0])[1:].max() < 0.1 * mm  # it slides along its shaft


@pytest.mark.parametrize("text", TEXTS.values(), ids=TEXTS)
def test_a_dragged_joint_moves_alone(text):
    application, line, script = installed(text)
    handle = Handle(kind="joint", number=2, line=line.line.name, ways="")
    by = np.array([5.0, 2.0, -6.0]) * mm
    new = files.loads(script.with_(dragged(application, handle, by, script))).lines[0]
    step = (new.layout.points - line.layout.points) / mm
    assert step[1, 1:] == pytest.approx([2.0, -6.0], abs=0.05)
    others = [0, *range(2, len(step))]
    assert abs(step[others, 1:]).max() < 0.1
    assert abs(step[:, 0]).max() < 0.5  # along the line only what the lengths ask for


@pytest.mark.parametrize("kind", ["gearbox", "pinion"])
@pytest.mark.parametrize("text", TEXTS.values(), ids=TEXTS)
def test_a_stub_turns_about_its_joint(text, kind):
    application, line, script = installed(text)
    by = np.array([0, 0, 10.0]) * mm
    handle = Handle(kind=kind, number=1, line=line.line.name, ways="")
    new = files.loads(script.with_(dragged(application, handle, by, script))).lines[0]
    assert abs(new.layout.points - line.layout.points).max() < 0.1 * mm
    span = np.linalg.norm(line.layout.points[-1] - line.layout.points[0])
    end, sign = (0, -1) if kind == "gearbox" else (-1, 1)
    meant = unit(STUB * span * line.layout.directions[end] + sign * by)
    assert new.layout.directions[end] == pytest.approx(meant, abs=2e-5)


def test_an_obstacle_moves_along_all_axes():
    application, _, script = installed(TEXTS["points"])
    handle = Handle(kind="obstacle", number=1, line="main", ways="")
    edits = dragged(application, handle, np.array([10.0, 1.0, -3.5]) * mm, script)
    new = files.loads(script.with_(edits)).obstacles[0]
    assert new.start == pytest.approx((2.56, -0.499, -0.2805))
    assert new.end == pytest.approx((2.56, 0.501, -0.2805))


def test_what_is_not_there_cannot_be_dragged():
    application, _, script = installed(SLOPES)
    known = {(h.kind, h.number) for h in handles(application, script)}
    assert known == {
        ("joint", 2), ("joint", 3), ("bearing", 1), ("gearbox", 1), ("pinion", 1)
    }  # fmt: skip
    for kind, number in (("joint", 1), ("bearing", 2), ("obstacle", 1), ("joint", 0)):
        with pytest.raises(DesignError, match="there is no"):
            dragged(application, Handle(kind=kind, number=number, line="main", ways=""),
                    (0, 0, 0.01), script)  # fmt: skip


def test_a_yoke_phase_is_written_where_there_was_none():
    application, line, script = installed(SLOPES)
    new = files.loads(script.with_(phased(line, (0.0, 90 * deg), script)))
    assert new.lines[0].line.phases == pytest.approx([0, 90 * deg])
    del application


def test_a_layout_that_stays_changes_nothing():
    for text in TEXTS.values():
        _, line, script = installed(text)
        assert placed(line, line.layout, script) == {}


@pytest.mark.parametrize("path", EXAMPLES[:3], ids=lambda p: p.stem)
def test_a_slider_leads_to_the_states_themselves(path):
    """At a state's own height and wind-up torque the line runs as the state says."""
    application = files.read(path)
    for line in application.lines:
        asked = demand(resolve(application, line))
        response = respond(application, asked)
        ends = reach(response)
        assert ends.travel[0] <= asked.travel.min()
        assert asked.travel.max() <= ends.travel[1]
        if ends.travel[0] == ends.travel[1]:
            continue
        kinds = np.array([s.kind for s in application.states])
        free = np.array([s.layouts is None for s in application.states])
        still = free & (kinds != "windup") & (kinds != "windup brake")
        one = ride(application, line, travel=asked.travel[still], torque=0.0)
        assert one.layout.points == pytest.approx(asked.layout.points[still], abs=1e-12)
        assert one.clearances == pytest.approx(response.clearances[still], abs=1e-12)
        for k in np.flatnonzero(kinds == "windup"):
            one = ride(application, line, travel=asked.travel[[k]], torque=asked.torque[k])
            assert one.layout.points[0] == pytest.approx(asked.layout.points[k], abs=1e-12)
            assert ends.torque[0] <= 0 <= asked.torque[k] <= ends.torque[1]
