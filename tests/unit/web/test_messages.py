"""Every answer of the workbench has the shape that its front's types are made of."""

import pytest
from message_schema import wrong
from repository import ROOT

from cardan.render.i18n import LANGUAGE_CODES, Translator
from cardan.web import ui_texts as words
from cardan.web.handlers import handle_request

EXAMPLES = sorted((ROOT / "examples").glob("*.yaml"))
TRUCK = next(p for p in EXAMPLES if p.stem.startswith("refuse")).read_text("utf-8")
CHAIN = next(p for p in EXAMPLES if p.stem.startswith("three")).read_text("utf-8")
FORM = {
    "title": "A", "speed": "2500", "limits": "protractor",
    "members": [{"side": "3"}, {"side": "1"}, {"side": "2"}], "shafts": [{"length": "1200"}],
}  # fmt: skip


def asked(job, text, lang="en", **what):
    question = {"job": job, "text": text, "name": "x.yaml", "folder": None, "lang": lang}
    return handle_request(question | what)


@pytest.mark.slow
@pytest.mark.parametrize("path", EXAMPLES, ids=lambda p: p.stem)
def test_live_and_full_messages_conform_to_schema(path):
    text = path.read_text("utf-8")
    assert wrong("Live", asked("live", text)) == []
    assert wrong("Full", asked("full", text)) == []


HELD = [
    ("refuse", "bearing", 2, (0, 3.3, 7.77)), ("refuse", "joint", 3, (0, -2, 5.01)),
    ("refuse", "pinion", 1, (0, 0, 12)), ("refuse", "obstacle", 1, (30, 0, -8)),
    ("three", "bearing", 1, (0, 0, -4.2)), ("refuse", "gearbox", 1, (0, 0, 9)),
]  # fmt: skip


@pytest.mark.slow
@pytest.mark.parametrize(("stem", "kind", "number", "by"), HELD)
def test_drag_message_matches_result_of_edited_file(stem, kind, number, by):
    """The numbers of both answers, put where they belong, are those of the text it is let go at."""
    text = next(p for p in EXAMPLES if p.stem.startswith(stem)).read_text("utf-8")
    line = asked("live", text)["lines"][0]["name"]
    drag = {"kind": kind, "number": number, "line": line, "by_mm": by}
    first = asked("held", text, drag=drag, want=[], pose={"line": 0})
    graded = asked("graded", text, drag=drag)
    assert graded["text"] == first["text"] != text
    now = asked("live", graded["text"])
    was = asked("live", text)
    lines = [{**was["lines"][0], **first["lines"][0]}, *was["lines"][1:]]
    assert lines == now["lines"]
    assert first["obstacles"] == now["obstacles"]
    told = {row["id"]: row for row in graded["limits"]}
    rows = [{**row, **told[row["id"]]} for row in was["limits"]]
    late = {"points", "spots"}
    plain = [{k: v for k, v in row.items() if k not in late} for row in now["limits"]]
    assert [{k: v for k, v in row.items() if k not in late} for row in rows] == plain
    assert graded["grade"] == now["grade"]
    assert wrong("Live", {**was, "lines": lines, "limits": rows}) == []


def test_edit_of_key_missing_from_text_is_answered():
    text = TRUCK.replace("      phase_deg: 0\n", "", 1)
    edits = {"driveline.shafts[1].phase_deg": 30.0}
    assert text != TRUCK
    told = asked("held", text, edits=edits, want=["turn"])
    assert told["lines"][0]["phases"][0] == 30
    assert told["pose"].keys() >= {"turn"}
    assert "over_travel" not in told["pose"]


def test_slider_position_is_independent_of_requested_curves():
    pose = {"travel_mm": -31.5, "torque_Nm": 2500.0}
    place = asked("pose", TRUCK, pose=pose, want=[])["pose"]
    whole = asked("pose", TRUCK, pose=pose)["pose"]
    assert place["at"] == whole["at"]
    assert set(whole) - set(place) == {"over_travel", "over_torque", "turn"}


def test_slider_and_single_correction_messages_conform_to_schema():
    told = asked("pose", TRUCK, pose={"travel_mm": 10, "torque_Nm": 500})
    assert wrong("Pose", told["pose"]) == []
    assert [w for h in asked("help", CHAIN)["helps"] for w in wrong("Help", h)] == []


def test_welcome_message_conforms_to_schema():
    assert wrong("Catalogue", words.shipped_joints_and_tubes()) == []
    for code in LANGUAGE_CODES:
        for explained in words.quantity_explanations(Translator(code)).values():
            assert wrong("Explained", explained) == []


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "job", "text", "args"),
    [
        ("Speeds", "speeds", TRUCK, {"state": 1}), ("Speeds", "speeds", CHAIN, {}),
        ("Guided", "guided", "", FORM), ("Ghost", "ghost", TRUCK, {}),
        ("Compared", "compare", CHAIN, {"variants": [{"name": "b", "text": TRUCK}]}),
        ("MapOf", "map", CHAIN, {"x": "bearing_height 1", "y": "shim 1"}),
        ("Yield", "yield", CHAIN, {"sigmas": [{"id": "shim 1", "amount": "0.2"}], "count": 128}),
        ("LimitsOf", "limits", TRUCK, {}),
    ],
)  # fmt: skip
def test_job_result_messages_conform_to_schema(name, job, text, args):
    assert wrong(name, asked(job, text, args=args)) == []


@pytest.mark.slow
def test_correction_message_conforms_to_schema():
    assert wrong("Corrections", asked("fix", CHAIN, args={})) == []


def test_schema_check_detects_malformed_message():
    told = asked("live", CHAIN)
    assert wrong("Live", {**told, "more": 1})
    assert wrong("Live", {**told, "worst": "one"})
    assert wrong("Live", {k: v for k, v in told.items() if k != "states"})
