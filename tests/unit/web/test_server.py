"""The workbench's server: what it answers, what it refuses, how it ends. All on loopback."""

import asyncio
import errno
import hashlib
import http.client
import json
import os
import re
import selectors
import shutil
import signal
import socket
import sys
import time
from base64 import b64decode
from contextlib import suppress
from dataclasses import replace
from hashlib import sha256
from pathlib import Path
from threading import Thread

import numpy as np
import pytest
from case_selection import select
from click.testing import CliRunner
from repository import ROOT
from websockets.exceptions import ConnectionClosed, InvalidStatus
from workbench import BUILT, PATIENCE, command, page, reached, running

from cardan.application import reader
from cardan.approval.approval import approve_application
from cardan.checks.line_response import compute_line_response
from cardan.cli import cli
from cardan.core.errors import CardanError, InvalidFileError, MissingDependencyError
from cardan.core.verdict import worst_first_key
from cardan.documents.first_screen import count_criteria_not_evaluated, criteria_count_text
from cardan.physics.vehicle.state_demand import line_state_demand, resolve_line_references
from cardan.render.i18n import ENGLISH, LANGUAGE_CODES, Translator
from cardan.render.json_contract import check_json
from cardan.schema.yaml_tree import MAX_FILE_CHARACTERS
from cardan.topics.recording import campaign_schema as campaign
from cardan.web import library, revisions, server, session, workspace
from cardan.web import ui_texts as words
from cardan.web import upload as parcel
from cardan.web import worker_pool as lanes
from cardan.web.handlers import OPERATING_POINT_QUANTITIES, handle_request
from cardan.web.worker_pool import WorkerQueue
from cardan.web.workspace import EditConflictError, Workspace, error_text_without_path

TRUCK = ROOT / "examples" / "refuse-collector-6x2.yaml"
CHAIN = ROOT / "examples" / "three-joint-chain.yaml"
TEXT = CHAIN.read_text("utf-8")


@pytest.fixture(scope="module")
def house(tmp_path_factory):
    folder = tmp_path_factory.mktemp("desk")
    (folder / "chain.yaml").write_text(TEXT, "utf-8")
    with running(folder / "chain.yaml", folder / "drafts") as found:
        yield found


@pytest.fixture
def own(tmp_path):
    """A workbench of one test's own, with the file on its desk."""
    path = tmp_path / "chain.yaml"
    path.write_text(TEXT, "utf-8")
    with running(path, tmp_path / "drafts") as found:
        yield found, path


def asked(text, job="live", **what):
    question = {"job": job, "text": text, "name": "x.yaml", "folder": None, "lang": "en"}
    return handle_request(question | what)


# ------------------------------------------------------------------ what it answers


def test_torque_slider_distinguishes_overrun_from_braking():
    """The low end of the torque's slider was coasting alone; brakes turn the axle the most.

    By hand: the axle pitches by what holds it over its stiffness. Brakes hold what the tyres do,
    μ N r of its load, whatever the line's torque; coasting T i / η, as its wheels turn the line.
    """
    text = TRUCK.read_text("utf-8")
    app = reader.loads(text)
    r = compute_line_response(app, line_state_demand(resolve_line_references(app, app.lines[0])))
    line = r.demand.static_state.line
    stiffness = line.suspension.windup_stiffness

    def posed(torque, **how):
        pose = asked(
            text, "pose", pose={"travel_mm": 0.0, "torque_Nm": torque, **how}, want=["curves"]
        )["pose"]
        return pose["way"], pose["torque"], pose["at"]["pitch"], pose

    still = posed(0.0)[2]
    way, _, coasts, _ = posed(-1000.0)
    assert way == "coast"
    axle = line.axle
    turned = -1000.0 * axle.ratio / axle.efficiency
    assert coasts - still == pytest.approx(np.degrees(turned / stiffness), abs=2e-3)
    assert posed(-3000.0)[0] == "reverse"
    assert posed(2000.0)[0] == "drive"
    held = line.tyre.friction * line.tyre.static_radius * r.demand.static_state.loads.braked[2]
    for torque in (-1000.0, -3000.0, 2000.0):
        way, told, braked, pose = posed(torque, way="brake")
        assert (way, told) == ("brake", min(torque, 0.0))
        assert braked - still == pytest.approx(np.degrees(-held / stiffness), abs=2e-3)
        assert max(pose["over_torque"]["x"]) == 0.0
    assert r.demand.states[2] == "gvw"


@pytest.mark.slow
@pytest.mark.parametrize("path", [TRUCK, CHAIN, ROOT / "examples/tandem-6x4.yaml"],
                         ids=lambda p: p.stem)  # fmt: skip
def test_live_and_full_messages_contain_every_check(path):
    """Cell by cell the numbers, margins and grades of the contract: nothing is left out."""
    text = path.read_text("utf-8")
    found = approve_application(reader.loads(text))
    live, full = asked(text), asked(text, "full")
    assert full["verdict"] == found.verdict
    assert full["missed"] == count_criteria_not_evaluated(found)
    if full["missed"]:
        assert f"; {full['missed']} not evaluated" in criteria_count_text(found, ENGLISH)
    assert ", ".join(full["counted"].values()) in criteria_count_text(found, ENGLISH)
    cells = {}
    for row in (*live["limits"], *full["limits"]):
        for s, state in enumerate(live["states"]):
            for p, (kind, number, other) in enumerate(row["kinds"]):
                if row["grades"][s][p] is not None:
                    key = row["line"], row["quantity"], state["name"], kind, str(number), other
                    bounds = row["sense"], row["normal"], row["maximum"]
                    cells[(*key, *bounds)] = (
                        row["values"][s][p], row["margins"][s][p], row["grades"][s][p]
                    )  # fmt: skip
    checks = [c for c in found.checks if c.when.kind == "state"]
    own = [c for c in checks if c.quantity not in OPERATING_POINT_QUANTITIES]
    assert {r["quantity"] for r in full["limits"]} <= OPERATING_POINT_QUANTITIES
    assert own
    seen = set()
    for c in checks:
        told = check_json(c)
        matching = [
            (k, v) for k, v in cells.items()
            if k[:3] == (c.line, c.quantity, c.when.name)
            and k[3:6] == (c.part.kind, str(c.part.number), str(c.part.other))
            and v[0] == pytest.approx(told["value"], rel=6e-9)  # nine figures
            and v[1] == pytest.approx(c.margin, rel=6e-9, abs=1e-9)
            and ("pass", "warn", "fail")[v[2]] == c.grade
        ]  # fmt: skip
        assert matching, c
        seen |= {k for k, _ in matching}
    assert len(seen) == len(cells)


@pytest.mark.slow
@pytest.mark.parametrize("name", ["refuse-collector-6x2", "tandem-6x4", "van", "pick-up-4x4"])
def test_displayed_numbers_are_rounded_once(name):
    """59.44497 rad/s² was told as 59.4450 and shown as 59.45, where a report says 59.44."""
    text, say = (ROOT / f"examples/{name}.yaml").read_text("utf-8"), Translator()
    found, live = approve_application(reader.loads(text)), asked(text)
    shown = {
        (row["line"], row["quantity"], state["name"], row["parts"][p], say.number(value))
        for row in live["limits"]
        for state, values in zip(live["states"], row["values"], strict=True)
        for p, value in enumerate(values)
        if value is not None
    }
    for c in found.checks:
        if c.quantity not in OPERATING_POINT_QUANTITIES and c.when.kind == "state":
            part = "" if c.part.kind == "line" else say.part(c.part)
            value = say.number(check_json(c)["value"])
            assert (c.line, c.quantity, c.when.name, part, value) in shown


@pytest.mark.parametrize("name", ["refuse-collector-6x2", "tandem-6x4", "van", "pick-up-4x4"])
def test_initial_load_state_is_that_of_worst_limit(name):
    """It was the one that shakes most: an overload, where the beam is touched in jounce."""
    text = (ROOT / f"examples/{name}.yaml").read_text("utf-8")
    found = approve_application(reader.loads(text))
    line = found.application.lines[0].line.name
    own = [
        c for c in found.checks if c.line == line and c.quantity not in OPERATING_POINT_QUANTITIES
    ]
    # As the file has it: between what assumed inputs leave a value, the page does not look.
    own = [replace(c, within=None) for c in own if c.when.kind == "state"]
    worst = min(own, key=worst_first_key)
    told = asked(text, pose={"line": 0})
    assert told["states"][told["worst"]]["name"] == worst.when.name
    assert told["pose"]["state"] == told["worst"]


def test_initial_load_state_without_limits_has_largest_excitation():
    text = TRUCK.read_text("utf-8")
    for asks, no in (("limits: heavy-truck", "limits: []"), ('  joints: "2040"\n', "")):
        text = text.replace(asks, no)
    told = asked(text)
    assert told["grade"] is None
    joint = (
        approve_application(reader.loads(text)).line_responses[0].kinematics.excitation.torsional
    )
    assert told["worst"] == int(np.nanargmax(joint.acceleration))


@pytest.mark.slow
def test_server_texts_use_typographic_minus_sign():
    """-5969 N·m in words stood beside −63 % of the page's own."""
    helps = asked(TRUCK.read_text("utf-8"), "help", lang="it")["helps"]
    texts = [t for h in helps for t in (h["where"], *(b["said"] for b in h["bars"]))]
    assert any(re.search(r"−\d", t) for t in texts)
    assert [t for t in texts if re.search(r"(?<![\w.,])-\d", t)] == []


@pytest.mark.parametrize(("was", "now", "said"), [
    ("length_mm: 1250", "lenght_mm: 1250", "chave desconhecida"),
    ("title:", "titel: x\ntitle:", "chave desconhecida"),
])  # fmt: skip
def test_errors_use_page_language(was, now, said):
    """The page spoke Portuguese, and its errors English; the command line did not."""
    (problem,) = asked(TEXT.replace(was, now, 1), lang="pt")["problems"]
    assert said in problem["message"]
    (same,) = asked(TEXT.replace(was, now, 1))["problems"]
    assert (same["line"], same["column"]) == (problem["line"], problem["column"])
    assert same["message"] != problem["message"]


def test_warnings_use_page_language():
    text = TEXT.replace("length_mm: 1250", "length_mm: 12000")
    english, italian = (asked(text, lang=code)["warnings"] for code in ("en", "it"))
    assert english
    assert [w["line"] for w in english] == [w["line"] for w in italian]
    assert all(a["message"] != b["message"] for a, b in zip(english, italian, strict=True))


def test_missing_referenced_file_is_reported_by_name_only(tmp_path):
    """A campaign without its application was asked whether it meant itself, by its whole path."""
    text = "campaign: A day\nrecordings: [{file: a.csv}]\napplication: application.yaml\n"
    text += "gauges: [S1]\nstrength: {amplitude_MPa: 30, cycles: 2e6, slope: 5}\n"
    (tmp_path / "campaign.yaml").write_text(text, "utf-8")
    told = asked(text, folder=str(tmp_path), name="campaign.yaml")
    (row,) = library.file_statuses(None, {"folder": str(tmp_path), "texts": [
        {"text": text, "name": "campaign.yaml", "file": 0, "draft": False}
    ]}, Translator("pt"), lambda _: None)["rows"]  # fmt: skip
    for said in (told["problems"][0]["message"] + told["problems"][0]["hint"], row["why"]):
        assert "application.yaml" in said
        assert str(tmp_path) not in said
        assert "campaign.yaml?" not in said


def test_welcome_message_uses_page_language(house):
    for code in LANGUAGE_CODES:
        with page(house) as one:
            told = one.hello(code)
            assert told["lang"] == code
            assert told["files"] == ["chain.yaml"]
            assert told["texts"]["Save"] == Translator(code)("Save")
    with page(house) as one:
        assert one.hello("xx")["lang"] == "en"


def test_drag_returns_edits_of_file_text(house):
    with page(house) as one:
        one.hello()
        text = one.open()["saved"]
        drag = {"kind": "bearing", "number": 1, "line": "main", "by_mm": [0, 0, 10.0]}
        told = one.ask(text, drag=drag)
        assert told["edits"].keys() == {
            "driveline.joint_angles.side_deg[1]", "driveline.joint_angles.side_deg[2]",
            "driveline.joint_angles.side_deg[3]", "driveline.shafts[2].length_mm",
        }  # fmt: skip
        assert "# published: table 2" in told["text"]
        assert told["text"] != text
        full = one.full()
        assert full["verdict"] == approve_application(reader.loads(told["text"])).verdict
        assert full["id"] == told["id"]


def test_numbers_and_names_are_edited_by_key_path(house):
    with page(house) as one:
        one.hello()
        told = one.ask(TEXT, edits={"driveline.shafts[2].phase_deg": 90, "title": "Two: three"})
        assert told["title"] == "Two: three"
        assert told["lines"][0]["phases"] == [0, 90]
        told = one.ask(TEXT, edits={"driveline.shafts[2].nothing": 1})
        assert "nothing" in json.dumps(told["problems"])


def test_joint_and_tube_are_replaced_by_catalogue_name():
    text = TRUCK.read_text("utf-8")
    line = asked(text)["lines"][0]
    assert line["joint_at"] == ["driveline.joints"] * 4
    assert (line["joint_now"][0], line["tube_now"][2]) == ("2040", "120x4")
    sizes = {j["name"]: j for j in words.shipped_joints_and_tubes()["joints"]}
    tubes = {c["name"]: c for c in words.shipped_joints_and_tubes()["tubes"]}
    assert len(sizes) > 40
    assert len(tubes) > 20
    edits = {"driveline.joints": "2055", "driveline.shafts[3].tube": "100x3"}
    told = asked(text, edits=edits)
    app = reader.loads(told["text"])
    assert app.lines[0].line.joints[0].peak_torque == sizes["2055"]["peak_Nm"]
    assert app.lines[0].line.shafts[2].tube.outer * 1e3 == pytest.approx(tubes["100x3"]["outer_mm"])
    assert told["text"].count("#") == text.count("#")
    assert 'joints: "2055"' in told["text"]


def test_omitted_joints_and_tubes_can_be_chosen_from_catalogue():
    """Joints or a tube left out had no choice on the page; those given in place have none."""
    bare = re.sub(r"\n  joints:.*", "", TRUCK.read_text("utf-8"))
    line = asked(bare)["lines"][0]
    assert (line["joint_at"], line["joint_now"]) == (["driveline.joints"] * 4, [""] * 4)
    told = asked(bare, edits={"driveline.joints": "2055"})
    assert told["lines"][0]["joint_now"] == ["2055"] * 4
    bare = re.sub(r"- tube: 120x4\n +", "- ", bare, count=1)
    at = asked(bare)["lines"][0]["tube_at"]
    assert at[0] == "driveline.shafts[1].tube"
    assert asked(bare, edits={at[0]: "100x3"})["lines"][0]["tube_now"][0] == "100x3"
    placed = TRUCK.read_text("utf-8").replace("tube: 120x4", "tube: {outer_mm: 120, wall_mm: 4}", 1)
    assert "" in asked(placed)["lines"][0]["tube_at"]


def test_file_errors_are_returned_as_answer(house):
    with page(house) as one:
        one.hello()
        told = one.ask(TEXT.replace("speed_rpm: 2800", "speed_rpm: fast"))
        (problem,) = told["problems"]
        assert (problem["key"], problem["line"]) == ("speed_rpm", 11)
        told = one.ask("title: [")
        assert told["problems"]


def test_latest_request_replaces_earlier_ones(house):
    with page(house) as one:
        one.hello()
        for k in range(1, 41):
            drag = {"kind": "bearing", "number": 1, "line": "main", "by_mm": [0, 0, k / 10]}
            one.say("ask", id=k, text=TEXT, drag=drag, held=True)
        answered = [one.hear("graded")["id"]]
        while answered[-1] != 40:
            answered.append(one.hear("graded")["id"])
        assert answered == sorted(answered)
        assert len(answered) < 40


@pytest.mark.skipif(not hasattr(signal, "SIGSTOP"), reason="holds a process still")
def test_driveline_follows_drag_while_limits_are_evaluated(house, monkeypatch):
    monkeypatch.setattr(session, "VERDICT_DELAY_AFTER_EDIT_S", 0.0)

    def held(by):
        drag = {"kind": "bearing", "number": 1, "line": "main", "by_mm": [0, 0, by]}
        one.say("ask", id=by, text=TEXT, drag=drag, held=True)

    with page(house) as one:
        one.hello()
        held(1)
        told = [one.hear("moved", "graded") for _ in range(2)]
        assert {t["type"]: t.get("fault") for t in told} == {"moved": None, "graded": None}
        assert one.hear("full")["id"] == 1
        time.sleep(1)  # what makes ready for the next hand is done
        pid = house.workers.limits.pid
        os.kill(pid, signal.SIGSTOP)
        try:
            for by in (2, 3, 4):
                held(by)
                told = one.hear("moved", "graded")
                assert (told["type"], told["id"]) == ("moved", by)
            one.say("ask", id=5, text=TEXT)
            assert one.hear("full")["id"] == 5
        finally:
            os.kill(pid, signal.SIGCONT)
        # It was let go meanwhile: nobody asks for the verdict on where it was.
        time.sleep(0.5)
        one.say("ask", id=6, text=TEXT)
        told = [one.hear("graded", "live", "full")]
        while told[-1]["type"] != "full" or told[-1]["id"] != 6:
            told.append(one.hear("graded", "live", "full"))
        assert [t["id"] for t in told if t["type"] == "full"] == [6]


def test_limit_is_shown_at_its_worst_load_state():
    """Values of limits come from `study.driveline`; a page lays the line there by itself."""
    text = TRUCK.read_text("utf-8")
    seen = set()
    for row in asked(text)["limits"]:
        if row["quantity"] not in ("joint_angle", "clearance"):
            continue
        for state, spots in enumerate(row.get("spots", [])):
            for part, spot in enumerate(spots):
                value = row["values"][state][part]
                if spot is None or value is None:
                    continue
                told = asked(text, "pose", pose={"line": 0, "state": state, **spot}, want=[])
                at = told["pose"]["at"]
                angles = row["quantity"] == "joint_angle"
                got = at["angles"][part] if angles else min(at["clearance"][part])
                assert got == pytest.approx(value, abs=1e-3)
                low, high = told["pose"]["torque_reach"]
                assert low - 1 <= spot["torque_Nm"] <= high + 1
                seen.add(spot["way"])
    assert seen == {"drive", "reverse"}


def test_negative_torque_beyond_overrun_is_labelled_reverse():
    """Jounce of the refuse collector: 3.845 mm free, pulling away in reverse, as `check` says."""
    text = TRUCK.read_text("utf-8")
    (row,) = [r for r in asked(text)["limits"] if r["quantity"] == "clearance"]
    (spot,) = [s for s in row["spots"][4] if s]
    pose = {"travel_mm": 1e3, "torque_Nm": spot["torque_Nm"]}
    told = asked(text, "pose", pose=pose, want=[])["pose"]
    assert min(min(room) for room in told["at"]["clearance"]) == pytest.approx(3.845, abs=1e-3)
    assert told["torque"] == -7866


def test_load_state_slider_shows_its_torque():
    text = TRUCK.read_text("utf-8")
    kinds = [s["kind"] for s in asked(text)["states"]]
    for state, kind in enumerate(kinds):
        told = asked(text, "pose", pose={"line": 0, "state": state})["pose"]
        line = asked(text)["lines"][0]
        wound = kind.startswith("windup")
        assert told["torque"] == (round(line["torque"][state]) if wound else 0)


def test_slider_answer_contains_positions_and_curves():
    text = TRUCK.read_text("utf-8")
    told = asked(text, "pose", pose={"travel_mm": -50.0, "torque_Nm": 4000.0})["pose"]
    assert told["travel"] == -50
    assert told["travel_reach"] == pytest.approx([-158, 35], abs=5)
    curve = told["over_travel"]
    k = min(range(len(curve["x"])), key=lambda k: abs(curve["x"][k] + 50))
    near = abs(curve["x"][1] - curve["x"][0])
    slope = abs(curve["angles"][3][k + 1] - curve["angles"][3][k])
    assert curve["angles"][3][k] == pytest.approx(told["at"]["angles"][3], abs=slope + 1e-3)
    assert near < 5
    wound = asked(text, "pose", pose={"travel_mm": -50.0, "torque_Nm": 0.0})["pose"]
    # METHOD: the housing turns by i η T over its stiffness; the nose rises.
    turn = 4000 * 4.88 * 0.95 / 16000
    assert told["at"]["pitch"] - wound["at"]["pitch"] == pytest.approx(turn, rel=2e-3)


def test_single_correction_gives_its_predicted_value():
    told = asked(TEXT, "help")["helps"]
    assert told
    best = told[0]["bars"][0]
    after = asked(TEXT, edits=best["edits"])
    row = next(r for r in after["limits"] if r["quantity"] == told[0]["quantity"])
    assert row["values"][0][0] == pytest.approx(best["value"], rel=1e-4)


@pytest.mark.slow
def test_single_correction_lists_checks_it_worsens():
    told = asked((ROOT / "examples" / "vecto-4x2.yaml").read_text("utf-8"), "help")["helps"]
    resonance = next(h for h in told if h["quantity"] == "resonance_distance")
    first, then = resonance["bars"]
    assert first["spoilt"] == ""
    assert then["gain"] > first["gain"]  # softer rubber, and the spline's thrust bows the line
    assert then["spoilt"].startswith("but then exceeded: Thrust / critical compression")


# ------------------------------------------------------------------ what it says


def test_frontend_texts_match_translation_list():
    said = {"incomplete"}
    for source in (ROOT / "web" / "src").glob("*.ts*"):
        said |= set(re.findall(r'\bt\(\s*"((?:[^"\\]|\\.)*)"', source.read_text("utf-8")))
    assert sorted(said) == sorted(words.UI_TEXTS)
    for code in LANGUAGE_CODES:
        assert words.translated_texts(Translator(code)).keys() == said


def test_frontend_size_and_dependencies_are_limited():
    written = (ROOT / "web/src").glob("*.ts*")
    lines = sum(len(p.read_text("utf-8").splitlines()) for p in written)
    assert lines < 4260
    asked_for = json.loads((ROOT / "web/package.json").read_text("utf-8"))["dependencies"]
    assert set(asked_for) == {"preact", "three", "uplot"}
    lock = (ROOT / "web/package-lock.json").read_text("utf-8")
    assert '"resolved"' not in lock


# ------------------------------------------------------------------ what it refuses


def got(house, path="/", method="GET", headers=None, body=None, address="127.0.0.1"):
    """Return status, headers and body of a request that says of itself what it likes."""
    one = http.client.HTTPConnection(address, house.port, timeout=PATIENCE)
    try:
        one.putrequest(method, path, skip_host=True, skip_accept_encoding=True)
        for key, value in ({"Host": f"127.0.0.1:{house.port}"} | (headers or {})).items():
            if value is not None:
                one.putheader(key, value)
        one.endheaders()
        if body:
            one.send(body)
        answered = one.getresponse()
        return answered.status, dict(answered.getheaders()), answered.read()
    finally:
        one.close()


def test_page_has_all_security_headers(house):
    for path, (content, kind) in BUILT.items():
        status, headers, body = got(house, path, headers={"Sec-Fetch-Site": "none"})
        assert (status, body, headers["content-type"]) == (200, content, kind)
        policy = headers["content-security-policy"]
        assert "unsafe" not in policy
        assert "frame-ancestors 'none'" in policy
        assert "default-src 'none'" in policy
        assert headers["x-content-type-options"] == "nosniff"
        assert headers["referrer-policy"] == "no-referrer"
        assert "access-control-allow-origin" not in headers
        assert not {"server", "date"} & set(headers)


def test_ipv4_and_ipv6_loopback_addresses_are_served(house):
    for address, host in (("127.0.0.1", "127.0.0.1"), ("127.0.0.1", "localhost"), ("::1", "[::1]")):
        if address == "::1" and not server.has_ipv6():
            continue
        asked_for = f"{host}:{house.port}"
        headers = {"Host": asked_for, "Origin": f"http://{asked_for}"}
        assert got(house, "/", headers=headers, address=address)[0] == 200
        mixed = {"Host": asked_for, "Origin": "http://127.0.0.2:80"}
        assert got(house, "/", headers=mixed, address=address)[0] == 403


@pytest.mark.parametrize(
    "headers",
    [
        {"Host": "cardan.example"},
        {"Host": "127.0.0.1"},
        {"Host": "localhost.example:80"},
        {"Host": None},
        {"Origin": "https://cardan.example"},
        {"Origin": "null"},
        {"Origin": "http://127.0.0.1:1"},
        {"Sec-Fetch-Site": "cross-site"},
        {"Sec-Fetch-Site": "same-site"},
    ],
    ids=str,
)
def test_cross_origin_requests_are_rejected(house, headers):
    status, said, body = got(house, "/", headers=headers)
    assert status in ((400, 403) if headers.get("Host", "") is None else (403,))
    assert b"<!doctype" not in body
    del said


@pytest.mark.parametrize(
    ("path", "method", "headers", "body", "status"),
    [
        ("/", "POST", {"Content-Length": "0"}, None, 405),
        ("/", "PUT", {"Content-Length": "9"}, None, 405),
        ("/", "GET", {"Content-Length": "900000000"}, None, 413),
        ("/", "GET", {"Transfer-Encoding": "chunked"}, None, 413),
        ("/?file=/etc/passwd", "GET", {}, None, 404),
        ("/../pyproject.toml", "GET", {}, None, 404),
        ("/assets/../../guard.py", "GET", {}, None, 404),
        ("/assets/%2e%2e/%2e%2e/guard.py", "GET", {}, None, 404),
        ("/static/index.html", "GET", {}, None, 404),
        ("/" + "a" * 300, "GET", {}, None, 404),
        ("/ask", "GET", {}, None, 404),
    ],
    ids=str,
)
def test_uploads_and_unknown_paths_are_rejected(house, path, method, headers, body, status):
    found, said, _ = got(house, path, method, headers, body)
    assert found == status
    assert said["x-content-type-options"] == "nosniff"


def test_oversized_request_headers_are_rejected(house):
    """A request whose headers go on and on is ended, and the next one is answered."""
    with socket.create_connection(("127.0.0.1", house.port), timeout=PATIENCE) as one:
        try:
            for _ in range(200):
                one.sendall(b"GET / HTTP/1.1\r\nX: " + b"a" * 1000)
            left = one.recv(100)
        except OSError:
            left = b""
        assert b"200" not in left
    assert got(house)[0] == 200


@pytest.mark.parametrize(
    "how",
    [
        {"origin": None},
        {"origin": "https://cardan.example"},
        {"origin": "null"},
        {"token": "a" * 32},
        {"additional_headers": {"Sec-Fetch-Site": "cross-site"}},
    ],
    ids=str,
)
def test_cross_origin_websocket_is_rejected(house, how):
    with pytest.raises(InvalidStatus, match="403"), reached(house, **how):
        pass


def dragging(by):
    """Return a question that drags joint 1 by what stands there."""
    at = '"kind": "joint", "number": 1, "line": "main"'
    return f'{{"type": "ask", "id": 1, "text": "", "drag": {{{at}, "by_mm": {by}}}}}'


def asking(what):
    return f'{{"type": "ask", "id": 1, "text": "", {what}}}'


WRONG = [
    "", "[]", "1", "null", "{", "[" * 100_000, '{"type": []}', '{"type": "exec"}',
    '{"type": "__init__"}', '{"type": "open", "file": "../x"}', '{"type": "open", "file": 1}',
    '{"type": "open", "file": -1}', '{"type": "open", "file": true}', '{"type": "ask"}',
    '{"type": "ask", "id": 1}', '{"type": "ask", "id": 1, "text": 3}',
    '{"type": "ask", "id": "1", "text": ""}', asking('"drag": {}'), dragging("[0, 0]"),
    dragging("[0, 0, NaN]"), asking('"edits": {"a": {}}'), asking('"pose": []'),
    asking('"pose": {"travel_mm": Infinity}'), asking('"pose": {"state": 1.5}'),
    '{"type": "save", "file": 0, "text": "a"}',
    '{"type": "keep", "file": 7, "text": "a", "mark": ""}',
]  # fmt: skip


@pytest.mark.parametrize("said", WRONG, ids=lambda s: s[:60])
def test_malformed_message_closes_only_its_connection(house, said):
    with page(house) as other, page(house) as one:
        other.hello()
        one.hello()
        one.socket.send(said)
        with pytest.raises(ConnectionClosed) as ended:
            one.hear("nothing")
        assert ended.value.rcvd.code == 1003
        assert other.open()["type"] == "opened"


MUCH = "x" * (MAX_FILE_CHARACTERS + 2)
TOO_MUCH = [
    ("live", dragging("[0, 0, 1e9]"), "a number is beyond 100000"),
    ("live", asking('"edits": {"a": "x\\ny"}'), "a would hold an invisible character"),
    ("live", asking(f'"edits": {{"a": "{"x" * 301}"}}'), "a is longer than 300 characters"),
    ("live", asking(f'"edits": {json.dumps({f"a{k}": 1 for k in range(201)})}'), "more than 200"),
    ("live", asking('"pose": {"state": 1000}'), "state is beyond 999"),
    ("live", asking(f'"edits": {{"a": {10**400}}}'), "a number is beyond"),
    ("moved", dragging("[0, 0, 1e9]")[:-1] + ', "held": true}', "a number is beyond 100000"),
    ("posed", f'{{"type": "pose", "id": 1, "text": "{MUCH}"}}', "text is longer than"),
    ("helped", f'{{"type": "help", "id": 1, "text": "{MUCH}"}}', "text is longer than"),
    ("refused", f'{{"type": "keep", "file": 0, "mark": "", "text": "{MUCH}"}}', "longer than"),
    ("refused", f'{{"type": "save", "file": 0, "mark": "", "text": "{MUCH}"}}', "longer than"),
    ("refused", json.dumps({"type": "create", "title": "x" * 301, "text": ""}), "title is longer"),
    (
        "refused",
        json.dumps({"type": "freeze", "file": 0, "text": "", "by": "x" * 101, "note": ""}),
        "by is longer than 100",
    ),
    (
        "refused",
        json.dumps({"type": "pin", "file": 0, "variants": [{"name": "", "text": ""}] * 13}),
        "variants are more than 12",
    ),
    (
        "refused",
        json.dumps({"type": "bring", "id": 1, "name": "x" * 1001, "size": 1}),
        "name is longer than 1000",
    ),
    (
        "done",
        json.dumps(
            {"type": "job", "id": 1, "job": "life", "text": "", "args": {"hours": "1" * 41}}
        ),
        "hours is longer than 40 characters",
    ),
    (
        "done",
        json.dumps(
            {
                "type": "job",
                "id": 1,
                "job": "guided",
                "text": "",
                "args": {"points": "0 0 0\n" * 4000},
            }
        ),
        "points is longer than 20000",
    ),
    (
        "refused",
        json.dumps({"type": "piece", "at": 0, "data": "A" * (parcel.MAX_CHUNK_CHARACTERS + 8)}),
        "data is longer than 1500000",
    ),
    (
        "done",
        json.dumps({"type": "job", "id": 1, "job": "map", "file": 0, "bytes": 24e6}),
        "the request takes 24 MB, more than the 8 MB that are read",
    ),
]


@pytest.mark.parametrize(("kind", "said", "why"), TOO_MUCH, ids=lambda s: s[:60])
def test_oversized_value_is_rejected_and_connection_stays_open(house, kind, said, why):
    """A name of 101 letters hung up on everything the page held: recording, masks, hand."""
    with page(house) as one:
        one.hello()
        one.socket.send(said)
        told = one.hear("live", "moved", "posed", "helped", "refused", "done")
        assert told["type"] == kind
        assert why in told["why" if kind == "refused" else "fault"]
        assert told.get("id") == json.loads(said).get("id") or kind == "refused"
        assert one.open()["type"] == "opened"


def told_until_closed(one, said):
    one.socket.send(said)
    one.hear("nothing")


def test_binary_and_oversized_messages_close_connection(house):
    for said in (b"{}", "x" * (server.MAX_MESSAGE_BYTES + 1)):
        with page(house) as one:
            one.hello()
            with pytest.raises(ConnectionClosed):
                told_until_closed(one, said)
    assert got(house)[0] == 200


def test_referenced_file_outside_folder_is_rejected(house):
    with page(house) as one:
        one.hello()
        told = one.ask(TEXT.replace("limits: protractor", "limits: ../../../etc/hosts.yaml"))
        assert "outside the folder" in told["problems"][0]["message"]
        for name in ("/etc/passwd", "~/.ssh/id_rsa", "C:\\\\x.yaml"):
            told = one.ask(TEXT + f'catalogues: "{name}"\n')
            assert told["problems"]
            assert "root:" not in json.dumps(told)


HOSTILE = [
    "<img src=x onerror=alert(1)>", "</script><script>alert(1)</script>", "\"'`;--",
    "{{7*7}} ${7*7}",
    "カルダン軸 传动轴", "a" * 200, "é" * 200,
]  # fmt: skip


@pytest.mark.parametrize("name", HOSTILE, ids=lambda n: n[:20])
def test_hostile_title_is_returned_unchanged(name):
    told = asked(TEXT, edits={"title": name})
    assert told["title"] == name
    assert reader.loads(told["text"]).title == name


@pytest.mark.parametrize("name", ["\u202egnp", "a\x1b[31m", "a\x00b", "a" * 20_000])
def test_invisible_or_overlong_name_is_rejected(name):
    assert asked(TEXT.replace("Three-joint chain (Souza 2014, table 2)", name))["problems"]


# ------------------------------------------------------------------ the disk


def test_saving_writes_file_and_deletes_draft(own):
    house, path = own
    with page(house) as one:
        one.hello()
        opened = one.open()
        text = opened["saved"].replace("2800", "2900")
        one.say("keep", file=0, text=text, mark=opened["mark"])
        one.hear("kept")
        assert path.read_text("utf-8") == TEXT
        assert one.open()["draft"] == text
        one.say("save", file=0, text=text, mark=opened["mark"])
        assert one.hear("saved")["text"] == text
        assert path.read_text("utf-8") == text
        assert one.open()["draft"] is None


def test_externally_changed_file_is_not_overwritten(own, monkeypatch):
    monkeypatch.setattr(session, "DISK_POLL_INTERVAL_S", 0.05)
    house, path = own
    with page(house) as one:
        one.hello()
        opened = one.open()
        path.write_text(TEXT + "# somebody else\n", "utf-8")
        told = one.hear("disk")
        assert told["text"].endswith("# somebody else\n")
        one.say("save", file=0, text=TEXT + "# mine\n", mark=opened["mark"])
        assert one.hear("disk")["conflict"]
        assert path.read_text("utf-8").endswith("# somebody else\n")
        one.say("save", file=0, text=TEXT + "# mine\n", mark=told["mark"])
        one.hear("saved")
        assert path.read_text("utf-8").endswith("# mine\n")


def test_file_write_error_uses_page_language(own, monkeypatch):
    """Save, freeze and open said it in English: Permission denied."""
    house, path = own

    def denied(*_, **__):
        raise PermissionError(errno.EACCES, os.strerror(errno.EACCES), str(path))

    with page(house) as one:
        one.hello("pt")
        mark = one.open()["mark"]
        for name, what in (("save", {"mark": mark}), ("freeze", {"by": "A", "note": ""})):
            monkeypatch.setattr(house.workspace, name, denied)
            one.say(name, file=0, text=TEXT, **what)
            told = one.hear("refused")
            assert (told["what"], told["why"]) == (name, "permissão negada")
        path.unlink()
        one.say("open", file=0)
        assert one.hear("refused")["why"] == "chain.yaml: não está mais lá"


def test_two_tabs_are_notified_of_saves(own, monkeypatch):
    monkeypatch.setattr(session, "DISK_POLL_INTERVAL_S", 0.05)
    house, _ = own
    with page(house) as one, page(house) as two:
        marks = []
        for tab in (one, two):
            tab.hello()
            marks.append(tab.open()["mark"])
            assert tab.ask(TEXT)["title"]
        one.say("save", file=0, text=TEXT + "# one\n", mark=marks[0])
        one.hear("saved")
        assert two.hear("disk")["text"] == TEXT + "# one\n"
        two.say("save", file=0, text=TEXT + "# two\n", mark=marks[1])
        assert two.hear("disk")["conflict"]


@pytest.mark.parametrize("one_server", [True, False])
def test_simultaneous_saves_lose_no_text(tmp_path, monkeypatch, one_server):
    """Both compared before either wrote, and both were told that their text is saved."""
    if os.name == "nt" and not one_server:
        pytest.skip("locks no folders")
    path = tmp_path / "a.yaml"
    path.write_text(TEXT, "utf-8")
    desks = [Workspace(tmp_path, drafts=tmp_path / "drafts")]
    desks.append(desks[0] if one_server else Workspace(tmp_path, drafts=tmp_path / "drafts"))
    mark, write, results = desks[0].open(0)["mark"], workspace.write_atomically, list[str]()

    def slow_write(*args, **kwargs):
        time.sleep(0.1)
        return write(*args, **kwargs)

    def save(desk: Workspace, text: str) -> None:
        try:
            desk.save(0, text, mark)
        except EditConflictError:
            results.append("conflict")
        else:
            results.append(text)

    monkeypatch.setattr(workspace, "write_atomically", slow_write)
    tabs = [Thread(target=save, args=(d, f"{TEXT}# {k}\n")) for k, d in enumerate(desks)]
    for tab in tabs:
        tab.start()
    for tab in tabs:
        tab.join()
    assert sorted(results) == sorted([path.read_text("utf-8"), "conflict"])


def test_byte_order_mark_and_line_endings_are_preserved(tmp_path):
    path = tmp_path / "a.yaml"
    path.write_bytes(b"\xef\xbb\xbf" + TEXT.replace("\n", "\r\n").encode())
    desk = Workspace(path, drafts=tmp_path / "drafts")
    opened = desk.open(0)
    new = asked(opened["saved"], edits={"speed_rpm": 2500})["text"]
    desk.save(0, new, opened["mark"])
    written = path.read_bytes()
    assert written.startswith(b"\xef\xbb\xbf#")
    assert written.count(b"\r\n") == written.count(b"\n") == TEXT.count("\n")
    with pytest.raises(EditConflictError):
        desk.save(0, TEXT, opened["mark"])


def test_deleted_file_is_reported_and_can_be_saved_again(tmp_path):
    """It was refused, with the path of another file for advice: nothing could be saved any more."""
    for name in ("a.yaml", "ab.yaml"):
        (tmp_path / name).write_text(TEXT, "utf-8")
    desk = Workspace(tmp_path, drafts=tmp_path / "drafts")
    opened = desk.open(0)
    (tmp_path / "a.yaml").unlink()
    with pytest.raises(InvalidFileError) as gone:
        desk.open(0)
    assert error_text_without_path(gone.value) == "is no longer there"
    desk.save(0, TEXT + "# again\n", opened["mark"])
    assert (tmp_path / "a.yaml").read_text("utf-8") == TEXT + "# again\n"


def test_draft_of_other_file_or_corrupt_draft_is_ignored(tmp_path):
    for name in ("a.yaml", "b.yaml"):
        (tmp_path / name).write_text(TEXT, "utf-8")
    desk = Workspace(tmp_path, drafts=tmp_path / "drafts")
    assert [p.name for p in desk.files] == ["a.yaml", "b.yaml"]
    desk.keep_draft(0, "title: x", desk.open(0)["mark"])
    assert desk.open(1)["draft"] is None
    (kept,) = (tmp_path / "drafts").iterdir()
    assert kept.parent.stat().st_mode & 0o077 == 0 or os.name == "nt"
    desk.keep_draft(1, "title: y", desk.open(1)["mark"])
    (other,) = set((tmp_path / "drafts").iterdir()) - {kept}
    other.write_bytes(kept.read_bytes())  # of the first, in the place of the second
    assert desk.open(0)["draft"] == "title: x"
    assert desk.open(1)["draft"] is None
    kept.write_text("{", "utf-8")
    assert desk.open(0)["draft"] is None


@pytest.mark.skipif(os.name == "nt", reason="links need a right there")
def test_symbolic_link_out_of_folder_is_rejected(tmp_path):
    """A folder of somebody else's listed, opened and saved what its links led to, anywhere."""
    desk, other = tmp_path / "desk", tmp_path / "other"
    (desk / "revisions").mkdir(parents=True)
    other.mkdir()
    (other / "theirs.yaml").write_text("title: theirs\n", "utf-8")
    (desk / "mine.yaml").write_text(TEXT, "utf-8")
    (desk / "again.yaml").symlink_to("mine.yaml")
    (desk / "out.yaml").symlink_to(other / "theirs.yaml")
    (desk / "revisions" / "mine.1.yaml").symlink_to(other / "theirs.yaml")
    opened = Workspace(desk, drafts=tmp_path / "drafts")
    assert [p.name for p in opened.files] == ["again.yaml", "mine.yaml"]
    assert opened.revisions(1) == []
    (desk / "revisions" / "mine.1.yaml").unlink()
    (desk / "revisions").rmdir()
    (desk / "revisions").symlink_to(other)
    with pytest.raises(InvalidFileError, match="leads out of the folder"):
        opened.freeze(1, TEXT, by="A", note="")
    assert [p.name for p in other.iterdir()] == ["theirs.yaml"]


@pytest.mark.skipif(os.name == "nt", reason="links need a right there")
def test_link_made_while_workbench_runs_is_not_followed_out_of_folder(tmp_path):
    """A file swapped for a link was read and written wherever that led."""
    folder, other = tmp_path / "desk", tmp_path / "other"
    for where in (folder, other):
        where.mkdir()
        (where / "a.yaml").write_text(TEXT, "utf-8")
    desk = Workspace(folder, drafts=tmp_path / "drafts")
    mark = desk.open(0)["mark"]
    (folder / "a.yaml").unlink()
    (folder / "a.yaml").symlink_to(other / "a.yaml")
    (folder / "new.yaml").symlink_to(other / "new.yaml")
    (folder / "revisions").mkdir()
    (folder / "revisions" / "a.1.yaml").symlink_to(other / "a.1.yaml")
    for write in (
        lambda: desk.save(0, "title: mine\n", mark),
        lambda: desk.freeze(0, TEXT, by="A", note=""),
        lambda: desk.create("new", TEXT),
        lambda: desk.open(0),
    ):
        with pytest.raises(InvalidFileError, match="leads out of the folder"):
            write()
    (folder / "a.yaml").unlink()
    (folder / "a.yaml").symlink_to(other / "gone.yaml")
    with pytest.raises(InvalidFileError, match="leads out of the folder"):
        desk.save(0, "title: mine\n", mark)
    assert [p.name for p in other.iterdir()] == ["a.yaml"]
    assert (other / "a.yaml").read_text("utf-8") == TEXT


def test_lone_surrogate_is_reported_and_process_survives(house):
    with page(house) as one:
        one.hello()
        first = one.ask(TEXT)
        told = one.ask('title: "\ud800"')
        assert "fault" not in told
        assert told["problems"]
        pid = house.workers.quick.pid
        assert one.ask(TEXT)["title"] == first["title"]
        assert house.workers.quick.pid == pid


def test_unreadable_file_is_reported(tmp_path):
    for name in ("no.yaml", "."):
        found = CliRunner().invoke(cli, ["serve", str(tmp_path / name / "x")])
        assert found.exit_code == 2
    binary = tmp_path / "b.yaml"
    binary.write_bytes(b"\xff\xfe\x00")
    with pytest.raises(InvalidFileError, match="no UTF-8"):
        Workspace(binary, drafts=tmp_path)


def test_browser_is_opened_with_single_use_code(own, monkeypatch):
    """Whoever may list processes sees that code, and comes too late with it."""
    house, _ = own
    code = house.one_time_address.rpartition("#")[2]
    assert code != house.token
    with page(house, token=code) as one:
        assert one.hello()["token"] == house.token
    for late in (code, ""):
        with pytest.raises(InvalidStatus), reached(house, token=late or "x"):
            pass
    code = house.one_time_address.rpartition("#")[2]
    monkeypatch.setattr("cardan.web.security.monotonic", lambda: time.monotonic() + 61)
    with pytest.raises(InvalidStatus), reached(house, token=code):
        pass
    with page(house) as one:
        assert one.hello()


# ------------------------------------------------------------------ how it lives and ends


def test_server_listens_on_loopback_only():
    opened = server.listening_sockets(0)
    try:
        names = [one.getsockname() for one in opened]
        assert {n[0] for n in names} <= {"127.0.0.1", "::1"}
        assert len({n[1] for n in names}) == 1
        with pytest.raises(CardanError, match=f"port {names[0][1]} cannot be used"):
            server.listening_sockets(names[0][1])
    finally:
        for one in opened:
            one.close()


@pytest.mark.parametrize(
    ("lang", "words"),
    [
        ((), ("cannot be used", "in use")), (("--lang", "pt"), ("não pode ser usada", "em uso")),
        (("--lang=it",), ("non si può usare", "in uso")),
    ],
)  # fmt: skip
def test_occupied_port_is_reported_as_bad_input(lang, words):
    with socket.socket() as one:
        one.bind(("127.0.0.1", 0))
        one.listen()
        port = str(one.getsockname()[1])
        found = CliRunner().invoke(cli, ["serve", str(CHAIN), "--port", port, *lang])
    assert found.exit_code == 2
    for said in words:
        assert said in found.output
    assert bool(lang) != ("cannot be used" in found.output)


def test_missing_built_page_is_reported(tmp_path, monkeypatch):
    monkeypatch.setattr(server, "files", lambda _: tmp_path)
    with pytest.raises(MissingDependencyError, match="make serve") as missing:
        server.static_files()
    for code in ("pt", "it"):
        assert "is not built" not in Translator(code).error(str(missing.value))


@pytest.mark.parametrize(
    ("lang", "ends"), [("en", "Ends with"), ("pt", "Termina com"), ("it", "Termina con")]
)
def test_startup_message_uses_language_option(tmp_path, monkeypatch, lang, ends):
    page = tmp_path / "static" / "index.html"
    page.parent.mkdir()
    page.write_text("<html></html>", encoding="utf-8")
    monkeypatch.setattr(server, "files", lambda _: tmp_path)
    monkeypatch.setattr(server, "serve", lambda *_, ready: ready())
    found = CliRunner().invoke(cli, ["serve", str(CHAIN), "--no-browser", f"--lang={lang}"])
    assert (found.exit_code, f"{ends} Ctrl-C." in found.output) == (0, True), found.output


@pytest.mark.parametrize(("code", "got"), [("pt", "uma lista de 2"), ("it", "una lista di 2")])
def test_given_value_in_error_is_described_in_page_language(code, got):
    (problem,) = asked(TEXT.replace("speed_rpm: 2800", "speed_rpm: [1, 2]"), lang=code)["problems"]
    assert (problem["key"], problem["value"]) == ("speed_rpm", got)


def test_idle_connections_are_closed(tmp_path, monkeypatch):
    monkeypatch.setattr(server, "FIRST_REQUEST_TIMEOUT_S", 0.3)
    monkeypatch.setattr(server, "MAX_CONNECTIONS", 20)
    path = tmp_path / "chain.yaml"
    path.write_text(TEXT, "utf-8")
    with running(path, tmp_path / "drafts") as house:
        idle = [socket.create_connection(("127.0.0.1", house.port)) for _ in range(200)]
        try:
            end = time.monotonic() + PATIENCE
            for one in idle:
                one.settimeout(max(end - time.monotonic(), 0.1))
                with suppress(ConnectionError):
                    assert one.recv(1) == b""
            assert got(house)[0] == 200
        finally:
            for one in idle:
                one.close()


@pytest.mark.slow
def test_page_is_answered_during_ten_thousand_connections(own):
    """As many as a process may hold at a time: those past the bound are ended at once."""
    house, _ = own
    with page(house) as one:
        one.hello()
        held = []
        for k in range(10_000):
            held.append(socket.create_connection(("127.0.0.1", house.port), PATIENCE))
            if len(held) > 300:
                held.pop(0).close()
            if k % 2500 == 0:
                assert one.ask(TEXT)["title"]
        assert one.ask(TEXT)["title"]
        ended, end = 0, time.monotonic() + server.FIRST_REQUEST_TIMEOUT_S / 2
        with selectors.DefaultSelector() as ready:  # `select` knows no descriptor above 1023
            for other in held:
                ready.register(other, selectors.EVENT_READ)
            while len(held) - ended > server.MAX_CONNECTIONS and time.monotonic() < end:
                ended = len(ready.select(0.05))
        assert len(held) - ended <= server.MAX_CONNECTIONS
        for other in held:
            other.close()


def test_pages_beyond_limit_are_rejected(tmp_path, monkeypatch):
    monkeypatch.setattr(server, "MAX_OPEN_BROWSER_PAGES", 2)
    path = tmp_path / "chain.yaml"
    path.write_text(TEXT, "utf-8")
    with running(path, tmp_path / "drafts") as house:
        with page(house) as one, page(house) as two:
            assert one.hello()
            assert two.hello()
            with pytest.raises((InvalidStatus, ConnectionClosed)), page(house) as three:
                three.hello()
        end = time.monotonic() + PATIENCE
        while house.open_pages and time.monotonic() < end:
            time.sleep(0.01)
        with page(house) as again:
            assert again.hello()


async def _slow():
    lane = WorkerQueue(longest=0.001)
    try:
        question = {"job": "live", "text": TEXT, "name": "x", "folder": None, "lang": "en"}
        first = await lane.ask(question)
        lane.timeout = PATIENCE
        second = await lane.ask(question)
        pid = lane.pid
        os.kill(pid, signal.SIGTERM)
        third = await lane.ask(question)
        fourth = await lane.ask(question)
        return first, second, third, fourth, pid, lane.pid
    finally:
        lane.close()
        await lane.wait_closed()


@pytest.mark.slow
def test_slow_or_dead_worker_process_is_replaced():
    import asyncio

    first, second, third, fourth, was, now = asyncio.run(_slow())
    assert first == {"fault": "too slow"}
    assert second["title"] == fourth["title"]
    assert third in ({"fault": "ended"}, second)
    assert was != now


@pytest.mark.slow
def test_internal_error_is_reported_and_next_request_answered():
    import asyncio

    async def ask():
        lane = WorkerQueue()
        try:
            question = {"job": "nothing", "text": TEXT, "name": "x", "folder": None, "lang": "en"}
            return await lane.ask(question), await lane.ask({**question, "job": "live"})
        finally:
            lane.close()
            await lane.wait_closed()

    broken, whole = asyncio.run(ask())
    assert broken == {"fault": "KeyError"}
    assert whole["title"]


@pytest.mark.slow
@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="looks processes up in /proc")
@pytest.mark.parametrize(
    "how", select([signal.SIGINT, signal.SIGTERM, signal.SIGKILL], signal.SIGKILL)
)
def test_server_shutdown_leaves_no_child_processes(tmp_path, how):
    path = tmp_path / "truck.yaml"
    path.write_text(TRUCK.read_text("utf-8"), "utf-8")
    with command(path, state=tmp_path / "state") as (process, address):
        port, token = re.match(r"http://127.0.0.1:(\d+)/#(.*)", address).groups()
        children = Path(f"/proc/{process.pid}/task/{process.pid}/children").read_text().split()
        assert len(children) == 2

        class At:
            pass

        house = At()
        house.port, house.token = int(port), token
        with page(house) as one:
            one.hello()
            text = one.open()["saved"]
            one.say("ask", id=1, text=text)
            process.send_signal(how)
            code = process.wait(PATIENCE)
        out, err = process.communicate()
        assert code == {signal.SIGINT: 130, signal.SIGTERM: -15, signal.SIGKILL: -9}[how]
        assert token not in out + err
        assert "Traceback" not in err
        end = time.monotonic() + PATIENCE
        while time.monotonic() < end and any(_alive(pid) for pid in children):
            time.sleep(0.02)
        assert not any(_alive(pid) for pid in children)


def _alive(pid):
    try:
        return Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0] != "Z"
    except OSError:
        return False


def test_token_is_not_logged(own, caplog, capfd):
    house, _ = own
    caplog.set_level(0)
    with page(house) as one:
        one.hello()
        one.ask(TEXT)
    with pytest.raises(InvalidStatus), reached(house, token="b" * 32):
        pass
    got(house, "/", headers={"Host": "x.example"})
    said = capfd.readouterr()
    ours = [r for r in caplog.records if not r.name.startswith("websockets.client")]
    assert house.token not in said.out + said.err + "".join(r.getMessage() for r in ours)


def said_for_ever(one, said):
    end = time.monotonic() + PATIENCE
    while time.monotonic() < end:
        one.sendall(said)
        time.sleep(0.01)


@pytest.mark.slow
def test_page_that_does_not_read_is_disconnected(own, monkeypatch):
    """What it is told fills what the system keeps for it; then its socket ends, not the server."""
    monkeypatch.setattr(session, "SEND_TIMEOUT_S", 0.5)
    house, _ = own
    with socket.create_connection(("127.0.0.1", house.port), timeout=PATIENCE) as deaf:
        host = f"127.0.0.1:{house.port}"
        head = (
            f"GET /ask HTTP/1.1\r\nHost: {host}\r\nOrigin: http://{host}\r\nUpgrade: websocket\r\n"
            "Connection: Upgrade\r\nSec-WebSocket-Version: 13\r\n"
            "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n"
            f"Sec-WebSocket-Protocol: cardan.1, {house.token}\r\n\r\n"
        )
        deaf.sendall(head.encode())
        hello = b'{"type":"hello"}'
        masked = bytes([0x81, 0x80 | len(hello), 0, 0, 0, 0]) + hello  # masked with nothing
        with pytest.raises(OSError):
            said_for_ever(deaf, masked * 20)
        with page(house) as other:
            other.hello()
            assert other.ask(TEXT)["title"]


def test_request_queue_keeps_only_latest_request():
    import asyncio

    async def take():
        class Echo:
            async def ask(self, question):
                return question

        latest = lanes.LatestOnlyQueue(Echo())
        for k in range(5):
            latest.put({"k": k})
        first = await latest.get()
        latest.put({"k": 9})
        latest.clear()
        latest.put({"k": 10})
        return first, await latest.get()

    first, second = asyncio.run(take())
    assert (first[0], second[0]) == ({"k": 4}, {"k": 10})


# ------------------------------------------------------------------ what a file names, and losses

HOUSE = """profile: house
title: Of the house
limits:
  - {quantity: torsional_acceleration, normal: 100, maximum: 120, unit: rad/s², source: "house"}
"""
OURS = re.sub(r"(?m)^limits:.*$", "limits: mine.yaml", TEXT)


def checked(path):
    """What the command says of a file: its exit code, and the verdict."""
    told = CliRunner().invoke(cli, ["check", str(path), "--json", "-"])
    return json.loads(told.stdout)["verdict"]


@pytest.fixture
def ours(tmp_path, monkeypatch):
    """A workbench with a file whose limits are one's own, in a file beside it."""
    monkeypatch.setattr(session, "DISK_POLL_INTERVAL_S", 0.05)
    path, limits = tmp_path / "chain.yaml", tmp_path / "mine.yaml"
    path.write_text(OURS, "utf-8")
    limits.write_text(HOUSE, "utf-8")
    with running(path, tmp_path / "drafts") as found:
        yield found, path, limits


def loose(limits):
    limits.write_text(HOUSE.replace(" 100", " 900").replace(" 120", " 1000"), "utf-8")


def test_changed_limits_file_changes_verdict_of_same_text(ours):
    """The page said PASS, and its report too, where the command said FAIL: held by text alone."""
    house, path, limits = ours
    loose(limits)
    with page(house) as one:
        one.hello()
        one.open()
        for text in (HOUSE, HOUSE.replace(" 100", " 900").replace(" 120", " 1000"), HOUSE):
            limits.write_text(text, "utf-8")
            one.ask(OURS)
            assert one.full()["verdict"] == checked(path)
            one.id += 1
            one.say("job", id=one.id, job="library", text=OURS, args={})
            (row,) = one.hear("done")["rows"]
            assert row["verdict"] == checked(path)


def test_page_is_notified_of_changed_or_new_referenced_file(ours):
    """It was told of its own file alone, and showed what it had."""
    house, _, limits = ours
    with page(house) as one:
        one.hello()
        one.open()
        one.ask(OURS)
        one.full()
        loose(limits)
        assert one.hear("beside", "disk")["type"] == "beside"
        limits.unlink()
        assert one.ask(OURS)["problems"]
        limits.write_text(HOUSE, "utf-8")
        assert one.hear("beside", "disk")["type"] == "beside"
        one.ask(OURS)
        assert one.full()["verdict"] == "fail"


def test_released_revision_keeps_its_limits_and_verdict(ours):
    """`cardan check` found no limits beside it; changed since was nothing, and the verdict new."""
    house, path, limits = ours
    loose(limits)
    with page(house) as one:
        one.hello()
        one.open()
        one.say("freeze", file=0, text=OURS, by="A", note="")
        (kept,) = one.hear("frozen", "refused")["revisions"]
        revision = path.parent / "revisions" / "chain.1.yaml"

        def compared():
            one.id += 1
            variants = [{"name": "1", "text": kept["text"]}]
            one.say("job", id=one.id, job="compare", text=OURS, args={"variants": variants})
            return one.hear("done")

        assert checked(revision) == checked(path) == "pass"
        assert compared()["differences"] == []
        limits.write_text(HOUSE, "utf-8")
        assert checked(revision) == "pass"
        assert checked(path) == "fail"
        found = compared()
        assert [v["verdict"] for v in found["variants"]] == ["fail", "pass"]
        assert "900" in found["differences"][0]["values"][1]


def test_released_revision_keeps_its_catalogues(tmp_path):
    """Rewritten at the keys that name files, and nowhere else that says the same."""
    (tmp_path / "sub").mkdir()
    (tmp_path / "sub" / "ours.csv").write_text("name\n", "utf-8")
    title = 'title: "sub/ours.csv"\ncatalogues: [sub/ours.csv]'
    text = re.sub(r"(?m)^title:.*$", title, OURS)
    (tmp_path / "a.yaml").write_text(text, "utf-8")
    (tmp_path / "mine.yaml").write_text(HOUSE, "utf-8")
    desk = Workspace(tmp_path / "a.yaml", drafts=tmp_path / "drafts")
    (kept,) = desk.freeze(0, text, by="A", note="")
    held = (tmp_path / "revisions" / "a.1.yaml").read_text("utf-8")
    assert 'title: "sub/ours.csv"' in held
    assert "a.1.files/sub/ours.csv" in held
    copies = tmp_path / "revisions" / "a.1.files"
    assert (copies / "mine.yaml").read_text("utf-8") == HOUSE
    assert (copies / "sub" / "ours.csv").is_file()
    assert "revisions/a.1.files/mine.yaml" in kept["text"]
    assert len(desk.freeze(0, text, by="B", note="")) == 2


JOB = ROOT / "examples" / "refuse-collector"


@pytest.fixture
def job(tmp_path):
    """A campaign, a bracket from a STEP file, and all that they name."""
    return Path(shutil.copytree(JOB, tmp_path / "job"))


def since(desk, kept):
    """Return what is told to have changed since a revision."""
    paper = desk.files[0]
    args = {"variants": [{"name": "1", "text": kept["text"]}]}
    told = asked(
        paper.read(), job="compare", args=args, name=paper.name, folder=str(desk.folder)
    )  # fmt: skip
    return [(row["name"], *row["values"]) for row in told["differences"]]


def sums(revision):
    """Return what a revision keeps, as who knows nothing of us checks it."""
    own = revision.with_name(f"{revision.stem}.files")
    found = {}
    for row in (own / "SHA256SUMS").read_text("utf-8").splitlines():
        was, name = row.split("  ", 1)
        assert hashlib.sha256((own / name).read_bytes()).hexdigest() == was
        found[name] = own / name
    return found


@pytest.mark.slow
@pytest.mark.parametrize("most", [64_000_000, 10_000])
def test_released_campaign_keeps_recordings_and_detects_changes(job, monkeypatch, most):
    """It kept its text alone: another recording under that name was what had been approved."""
    monkeypatch.setattr(revisions, "MAX_COPIED_BYTES", most)
    desk = Workspace(job / "campaign.yaml", drafts=job / "drafts")
    (kept,) = desk.freeze(0, desk.open(0)["saved"], by="A", note="")
    revision = job / "revisions" / "campaign.1.yaml"
    copy = sums(revision)["joints.parquet"]
    assert {*sums(revision)} == {"joints.parquet", "application.yaml"}
    # What is heavy takes no room: it is a second name of the file.
    original = job / "joints.parquet"
    assert copy.samefile(original) == (most < 64_000_000)
    assert (
        campaign.read_campaign_file(revision).drives[0].file.read_bytes() == original.read_bytes()
    )
    assert since(desk, kept) == []
    was = original.read_bytes()
    row = ("recordings[1].file: other contents", "joints.parquet")
    named = "revisions/campaign.1.files/joints.parquet"
    # Another file in its place leaves what was approved as it was.
    original.unlink()
    original.write_bytes(was[:-1] + b"x")
    assert since(desk, kept) == [(*row, named)]
    assert copy.read_bytes() == was
    original.unlink()
    assert since(desk, kept) == [(row[0], "joints.parquet: is no longer there", named)]
    (os.link if most < 64_000_000 else shutil.copyfile)(copy, original)
    assert since(desk, kept) == []
    # Who writes into the file itself changes both of two names: there is no silence on that.
    original.write_bytes(was[:-1] + b"x")
    spoilt = f"{named}: overwritten since" if most < 64_000_000 else named
    assert since(desk, kept) == [(*row, spoilt)]
    original.write_bytes(was)
    assert since(desk, kept) == []
    # The application that it names counts too, and what that names.
    with (job / "application.yaml").open("a") as file:
        file.write("# another\n")
    assert [one[:2] for one in since(desk, kept)] == [
        ("application: other contents", "application.yaml")
    ]


@pytest.mark.parametrize(
    ("text", "by", "why"),
    [("title: [\n", "A", "a value is missing"), ("title: x\n", "A", "driveline"),
     (TEXT, "", "sign it"), (TEXT, "\u200b \u202e", "sign it")],
)  # fmt: skip
def test_invalid_or_unsigned_text_is_not_released(tmp_path, text, by, why):
    """A signature on a text that had not been shown, and one that nobody sees."""
    (tmp_path / "a.yaml").write_text(TEXT, "utf-8")
    desk = Workspace(tmp_path / "a.yaml", drafts=tmp_path / "drafts")
    with pytest.raises(InvalidFileError) as found:
        desk.freeze(0, text, by=by, note="")
    assert why in str(found.value)
    assert desk.revisions(0) == []


def test_recording_is_copied_if_hard_link_fails(job, monkeypatch):
    """A stick or a share may know no second names."""

    def never(*_):
        raise OSError(errno.EPERM, os.strerror(errno.EPERM))

    monkeypatch.setattr(revisions, "MAX_COPIED_BYTES", 0)
    monkeypatch.setattr(os, "link", never)
    desk = Workspace(job / "tracks.yaml", drafts=job / "drafts")
    desk.freeze(0, desk.open(0)["saved"], by="A", note="")
    copy = sums(job / "revisions" / "tracks.1.yaml")["road.parquet"]
    assert not copy.samefile(job / "road.parquet")


@pytest.mark.slow
def test_released_bracket_keeps_its_step_file(job):
    """`cardan bracket` on the revision reads the shape that was approved."""
    desk = Workspace(job / "from-step.yaml", drafts=job / "drafts")
    (kept,) = desk.freeze(0, desk.open(0)["saved"], by="A", note="")
    revision = job / "revisions" / "from-step.1.yaml"
    was = (job / "bracket.step").read_bytes()
    assert sums(revision)["bracket.step"].read_bytes() == was
    assert since(desk, kept) == []
    (job / "bracket.step").write_bytes(was + b"\n")
    ((name, *_),) = since(desk, kept)
    assert name == "bracket.step.file: other contents"
    assert Path(reader.read(revision).bracket.shape.path).read_bytes() == was


def test_released_file_keeps_indirectly_referenced_files(tmp_path):
    """An application of a campaign has limits and catalogues of its own: they were left out."""
    (tmp_path / "sub").mkdir()
    (tmp_path / "sub" / "app.yaml").write_text(OURS, "utf-8")
    (tmp_path / "sub" / "mine.yaml").write_text(HOUSE, "utf-8")
    (tmp_path / "a.csv").write_text("time_s,S1 [MPa]\n0,1\n1,2\n", "utf-8")
    text = "campaign: A day\nrecordings: [{file: a.csv}]\napplication: sub/app.yaml\n"
    text += "gauges: [S1]\nstrength: {amplitude_MPa: 30, cycles: 2e6, slope: 5}\n"
    (tmp_path / "c.yaml").write_text(text, "utf-8")
    desk = Workspace(tmp_path / "c.yaml", drafts=tmp_path / "drafts")
    (kept,) = desk.freeze(0, text, by="A", note="")
    revision = tmp_path / "revisions" / "c.1.yaml"
    assert {*sums(revision)} == {"a.csv", "sub/app.yaml", "sub/mine.yaml"}
    assert campaign.read_campaign_file(revision).options["application"].profile == "house"
    (tmp_path / "sub" / "mine.yaml").write_text(HOUSE + "# \n", "utf-8")
    assert [row[0] for row in since(desk, kept)] == ["application: other contents"]


@pytest.mark.parametrize("how", ["full", "half a letter"])
def test_failed_release_leaves_no_files(tmp_path, monkeypatch, how):
    """A full disk left an empty revision that was listed, and an empty file; half a letter too."""
    (tmp_path / "a.yaml").write_text(OURS, "utf-8")
    (tmp_path / "mine.yaml").write_text(HOUSE, "utf-8")
    desk = Workspace(tmp_path / "a.yaml", drafts=tmp_path / "drafts")
    text = OURS
    if how == "full":

        def full(_):
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

        monkeypatch.setattr(os, "fsync", full)
    else:
        text += "# \ud83d\n"
    for write in (
        lambda: desk.freeze(0, text, by="A", note=""),
        lambda: desk.create("Another", text),
        lambda: desk.save(0, text, desk.open(0)["mark"]),
    ):
        with pytest.raises(
            InvalidFileError, match="No space left" if how == "full" else "half a letter"
        ):
            write()
    left = {p.name for p in tmp_path.rglob("*")}
    assert left <= {"a.yaml", "mine.yaml", "revisions", "drafts"}
    assert desk.revisions(0) == []
    assert (tmp_path / "a.yaml").read_text("utf-8") == OURS


def test_each_page_keeps_its_own_draft(own):
    """Of two tabs with edits of one file a crash left the one that was typed in last."""
    house, _ = own
    with page(house) as one, page(house) as two:
        whos = [tab.hello()["who"] for tab in (one, two)]
        assert len(set(whos)) == 2
        mark, _ = (tab.open()["mark"] for tab in (one, two))
        for tab, said in ((one, "# one\n"), (two, "# two\n"), (one, "# one, later\n")):
            tab.say("keep", file=0, text=TEXT + said, mark=mark)
            tab.hear("kept")
        # A third is told of what others have, and throws none of it away.
        with page(house) as three:
            three.hello()
            told = three.open()
            assert (told["draft"], told["elsewhere"]) == (TEXT + "# one, later\n", True)
            three.say("drop", file=0)
    # All of them have crashed.
    with page(house) as four:
        four.hello("pt")
        told = four.open()
        assert (told["draft"], told["elsewhere"]) == (TEXT + "# one, later\n", False)
        (left,) = told["variants"]
        assert left["text"] == TEXT + "# two\n"
        assert left["name"].startswith("não salvo 20")
        assert told["left"] == 1
        # Kept among the variants it is still there for others; once it is taken out it is gone.
        four.say("pin", file=0, variants=[left])
        four.hear("kept")
        assert four.open()["variants"] == [left]
        four.say("pin", file=0, variants=[])
        four.hear("kept")
        told = four.open()
        assert (told["variants"], told["draft"]) == ([], TEXT + "# one, later\n")


def test_reconnected_page_does_not_take_draft_of_another_page(own):
    """It has a text of its own: what another left meanwhile is for who opens the file anew."""
    house, _ = own
    with page(house) as one:
        who = one.hello()["who"]
        mark = one.open()["mark"]
        one.say("keep", file=0, text=TEXT + "# one\n", mark=mark)
        one.hear("kept")
    with page(house) as two:  # which saw none of it
        was = two.hello()["who"]
    with page(house) as two:
        two.say("hello", lang="en", was=was)
        assert two.hear("welcome")["who"] == was
        two.open()
        two.say("drop", file=0)
        two.say("keep", file=0, text=TEXT + "# two\n", mark=mark)
        two.hear("kept")
        with page(house) as one, page(house) as another:
            for tab in (one, another):  # nobody is two
                tab.say("hello", lang="en", was=who)
            assert {tab.hear("welcome")["who"] == who for tab in (one, another)} == {True, False}
    with page(house) as three:
        three.hello()
        told = three.open()
        texts = {told["draft"], *(v["text"] for v in told["variants"])}
        assert texts == {TEXT + "# one\n", TEXT + "# two\n"}


def test_draft_of_changed_file_is_returned_with_its_base_text(own):
    """A page that is loaded again asks again: it must not save over a text nobody has looked at."""
    house, path = own
    with page(house) as one:
        one.hello()
        mark = one.open()["mark"]
        one.say("keep", file=0, text=TEXT + "# mine\n", mark=mark)
        one.hear("kept")
    path.write_text(TEXT + "# others\n", "utf-8")
    for _ in range(2):  # the page keeps it anew as it goes
        with page(house) as one:
            one.hello()
            told = one.open()
            assert told["stale"]
            assert told["base"] == mark != told["mark"]
            one.say("save", file=0, text=told["draft"], mark=told["base"])
            assert one.hear("saved", "disk")["conflict"]
            one.say("keep", file=0, text=told["draft"], mark=told["base"])
            one.hear("kept")
    assert path.read_text("utf-8") == TEXT + "# others\n"


def test_temporary_files_of_ended_process_are_deleted(tmp_path, monkeypatch):
    """Texts of applications lay in the folder for temporary files after each job that was ended."""
    monkeypatch.setattr(lanes.tempfile, "tempdir", str(tmp_path))

    async def ended():
        lane = WorkerQueue()
        await lane.start()
        (folder,) = tmp_path.iterdir()
        environment = Path(f"/proc/{lane.pid}/environ")
        if environment.exists():
            while not (held := environment.read_bytes()):  # it is being begun
                await asyncio.sleep(0.01)
            assert f"TMPDIR={folder}".encode() in held.split(b"\0")
        (folder / "question").write_text(TEXT, "utf-8")
        lane.close()
        await lane.wait_closed()

    asyncio.run(ended())
    assert list(tmp_path.iterdir()) == []


def test_text_with_lone_surrogate_is_not_saved_but_kept_as_draft(own):
    """The socket was dropped, and what was typed with it."""
    house, _ = own
    with page(house) as one:
        one.hello()
        mark = one.open()["mark"]
        for what in ({"type": "save", "mark": mark}, {"type": "freeze", "by": "A", "note": ""}):
            kind = what.pop("type")
            one.say(kind, file=0, text=TEXT + "# \ud83d\n", **what)
            assert f"line {TEXT.count(chr(10)) + 1} holds half a" in one.hear("refused")["why"]
        one.say("create", title="z", text="# \ud83d\n")
        assert "half a letter" in one.hear("refused")["why"]
        one.say("keep", file=0, text=TEXT + "# \ud83d\n", mark=mark)
        assert one.hear("kept", "refused")["type"] == "kept"


@pytest.mark.parametrize(
    ("before", "typed", "after"),
    [
        ("a\r\nb\r\nc\r\n", "aZ\nb\nc\n", "aZ\r\nb\r\nc\r\n"),
        ("a\r\nb\nc\r\nd\r\n", "a\nb\nnew\nc\nd\n", "a\r\nb\nnew\r\nc\r\nd\r\n"),
        ("a\nb\nc\r\n", "a\nB\nc\n", "a\nB\nc\r\n"),
        ("a\rb\r", "a\nb\nc", "a\rb\rc"),
        ("a\nb", "b\n", "b\n"),
        ("a\r\nb\r\n", "", ""),
        ("", "a\nb\n", "a\nb\n"),
        ("a\r\n", "a\na\na\n", "a\r\na\r\na\r\n"),
    ],
)  # fmt: skip
def test_line_endings_of_file_survive_browser_edit(tmp_path, before, typed, after):
    """By hand: one letter typed turned every end of the file, and its difference was all of it."""
    path = tmp_path / "a.yaml"
    path.write_bytes(before.encode())
    desk = Workspace(path, drafts=tmp_path / "drafts")
    opened = desk.open(0)
    assert "\r" not in opened["saved"]
    desk.save(0, opened["saved"], opened["mark"])
    assert path.read_bytes() == before.encode()
    desk.save(0, typed, opened["mark"])
    assert path.read_bytes() == after.encode()


@pytest.mark.slow
def test_report_contains_sha256_of_its_file(own):
    """As `sha256sum` tells it: of a file with a mark and `CRLF` it was that of the text."""
    house, path = own
    path.write_bytes(b"\xef\xbb\xbf" + TEXT.replace("\n", "\r\n").encode())
    with page(house) as one:
        one.hello()
        saved = one.open()["saved"]
        one.say("job", id=1, job="report", text=saved, args={"kind": "html", "lang": "en"})
        told = b64decode(one.hear("done")["data"]).decode()
    assert sha256(path.read_bytes()).hexdigest()[:16] in told


def test_draft_is_not_deleted_by_another_tab(own):
    """Undone in a second tab, the draft of the first was gone though its text was there still."""
    house, _ = own
    with page(house) as two:
        two.hello()
        with page(house) as one:
            one.hello()
            mark = one.open()["mark"]
            one.say("keep", file=0, text=TEXT + "# one\n", mark=mark)
            one.hear("kept")
            assert two.open()["draft"] == TEXT + "# one\n"
            two.say("drop", file=0)
            assert two.open()["draft"] == TEXT + "# one\n"
        end = time.monotonic() + 20
        while two.open()["draft"] and time.monotonic() < end:
            two.say("drop", file=0)  # whose it was has gone
        assert two.open()["draft"] is None


def test_unwritable_drafts_folder_is_reported(tmp_path):
    """Where their folder is a file: nothing was said, and a crash lost all."""
    path, drafts = tmp_path / "chain.yaml", tmp_path / "drafts"
    path.write_text(TEXT, "utf-8")
    drafts.write_text("a file", "utf-8")
    with running(path, drafts) as house, page(house) as one:
        one.hello()
        one.say("keep", file=0, text=TEXT + "# mine\n", mark=one.open()["mark"])
        told = one.hear("kept", "refused")
        assert (told["type"], told["what"]) == ("refused", "keep")
