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
from hashlib import sha256
from pathlib import Path

import numpy as np
import pytest
from chief import chief
from click.testing import CliRunner
from websockets.exceptions import ConnectionClosed, InvalidStatus
from workbench import BUILT, PATIENCE, command, page, reached, running

from cardan import files
from cardan.base.errors import BadFile, CardanError, NotInstalled
from cardan.base.verdict import badness
from cardan.border.document import LONGEST
from cardan.cli import cli
from cardan.demand.states import demand, resolve
from cardan.files import campaign
from cardan.quantity.response import respond
from cardan.report import contract
from cardan.report.language import CODES, Language
from cardan.study.approval import approve
from cardan.web import lanes, library, parcel, revisions, server, session, words
from cardan.web.answer import SOUGHT, answer
from cardan.web.desk import Conflict, Desk, readable
from cardan.web.lanes import Lane

ROOT = Path(__file__).parents[2]
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
    return answer(question | what)


# ------------------------------------------------------------------ what it answers


def test_sliders_know_coasting_from_braking():
    """The low end of the torque's slider was coasting alone; brakes turn the axle the most.

    By hand: the axle pitches by what holds it over its stiffness. Brakes hold what the tyres do,
    μ N r of its load, whatever the line's torque; coasting T i / η, as its wheels turn the line.
    """
    text = TRUCK.read_text("utf-8")
    app = files.loads(text)
    r = respond(app, demand(resolve(app, app.lines[0])))
    line = r.demand.standing.line
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
    held = line.tyre.friction * line.tyre.static_radius * r.demand.standing.loads.braked[2]
    for torque in (-1000.0, -3000.0, 2000.0):
        way, told, braked, pose = posed(torque, way="brake")
        assert (way, told) == ("brake", min(torque, 0.0))
        assert braked - still == pytest.approx(np.degrees(-held / stiffness), abs=2e-3)
        assert max(pose["over_torque"]["x"]) == 0.0
    assert r.demand.states[2] == "gvw"


@pytest.mark.parametrize("path", [TRUCK, CHAIN, ROOT / "examples/tandem-6x4.yaml"],
                         ids=lambda p: p.stem)  # fmt: skip
def test_the_two_answers_hold_every_check_there_is(path):
    """Cell by cell the numbers, margins and grades of the contract: nothing is left out."""
    text = path.read_text("utf-8")
    found = approve(files.loads(text))
    live, full = asked(text), asked(text, "full")
    assert full["verdict"] == found.verdict
    assert full["missed"] == len(found.coverage.unanswered)
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
    own = [c for c in checks if c.quantity not in SOUGHT]
    assert {r["quantity"] for r in full["limits"]} <= SOUGHT
    assert own
    seen = set()
    for c in checks:
        told = contract.check(c)
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


@pytest.mark.parametrize("name", ["refuse-collector-6x2", "tandem-6x4", "van", "pick-up-4x4"])
def test_numbers_are_not_rounded_twice(name):
    """59.44497 rad/s² was told as 59.4450 and shown as 59.45, where a report says 59.44."""
    text, say = (ROOT / f"examples/{name}.yaml").read_text("utf-8"), Language()
    found, live = approve(files.loads(text)), asked(text)
    shown = {
        (row["line"], row["quantity"], state["name"], row["parts"][p], say.number(value))
        for row in live["limits"]
        for state, values in zip(live["states"], row["values"], strict=True)
        for p, value in enumerate(values)
        if value is not None
    }
    for c in found.checks:
        if c.quantity not in SOUGHT and c.when.kind == "state":
            part = "" if c.part.kind == "line" else say.part(c.part)
            value = say.number(contract.check(c)["value"])
            assert (c.line, c.quantity, c.when.name, part, value) in shown


@pytest.mark.parametrize("name", ["refuse-collector-6x2", "tandem-6x4", "van", "pick-up-4x4"])
def test_the_state_that_is_shown_first_holds_the_worst_limit(name):
    """It was the one that shakes most: an overload, where the beam is touched in jounce."""
    text = (ROOT / f"examples/{name}.yaml").read_text("utf-8")
    found = approve(files.loads(text))
    line = found.application.lines[0].line.name
    own = [c for c in found.checks if c.line == line and c.quantity not in SOUGHT]
    worst = min((c for c in own if c.when.kind == "state"), key=badness)
    told = asked(text, pose={"line": 0})
    assert told["states"][told["worst"]]["name"] == worst.when.name
    assert told["pose"]["state"] == told["worst"]


def test_without_limits_the_state_that_shakes_most_is_shown_first():
    text = TRUCK.read_text("utf-8")
    for asks, no in (("limits: heavy-truck", "limits: []"), ('  joints: "2040"\n', "")):
        text = text.replace(asks, no)
    told = asked(text)
    assert told["grade"] is None
    joint = approve(files.loads(text)).responses[0].excitation.torsional
    assert told["worst"] == int(np.nanargmax(joint.acceleration))


def test_what_the_server_says_has_the_pages_minus_signs():
    """-5969 N·m in words stood beside −63 % of the page's own."""
    helps = asked(TRUCK.read_text("utf-8"), "help", lang="it")["helps"]
    texts = [t for h in helps for t in (h["where"], *(b["said"] for b in h["bars"]))]
    assert any(re.search(r"−\d", t) for t in texts)
    assert [t for t in texts if re.search(r"(?<![\w.,])-\d", t)] == []


@pytest.mark.parametrize(("was", "now", "said"), [
    ("length_mm: 1250", "lenght_mm: 1250", "chave desconhecida"),
    ("title:", "titel: x\ntitle:", "chave desconhecida"),
])  # fmt: skip
def test_what_is_wrong_is_said_in_the_pages_language(was, now, said):
    """The page spoke Portuguese, and its errors English; the command line did not."""
    (problem,) = asked(TEXT.replace(was, now, 1), lang="pt")["problems"]
    assert said in problem["message"]
    (same,) = asked(TEXT.replace(was, now, 1))["problems"]
    assert (same["line"], same["column"]) == (problem["line"], problem["column"])
    assert same["message"] != problem["message"]


def test_warnings_are_said_in_the_pages_language_too():
    text = TEXT.replace("length_mm: 1250", "length_mm: 12000")
    english, italian = (asked(text, lang=code)["warnings"] for code in ("en", "it"))
    assert english
    assert [w["line"] for w in english] == [w["line"] for w in italian]
    assert all(a["message"] != b["message"] for a, b in zip(english, italian, strict=True))


def test_a_file_beside_goes_by_its_name_and_none_is_taken_for_another(tmp_path):
    """A campaign without its application was asked whether it meant itself, by its whole path."""
    text = "campaign: A day\nrecordings: [{file: a.csv}]\napplication: application.yaml\n"
    text += "gauges: [S1]\nstrength: {amplitude_MPa: 30, cycles: 2e6, slope: 5}\n"
    (tmp_path / "campaign.yaml").write_text(text, "utf-8")
    told = asked(text, folder=str(tmp_path), name="campaign.yaml")
    (row,) = library.status(None, {"folder": str(tmp_path), "texts": [
        {"text": text, "name": "campaign.yaml", "file": 0, "draft": False}
    ]}, Language("pt"), lambda _: None)["rows"]  # fmt: skip
    for said in (told["problems"][0]["message"] + told["problems"][0]["hint"], row["why"]):
        assert "application.yaml" in said
        assert str(tmp_path) not in said
        assert "campaign.yaml?" not in said


def test_a_page_is_welcomed_in_its_language(house):
    for code in CODES:
        with page(house) as one:
            told = one.hello(code)
            assert told["lang"] == code
            assert told["files"] == ["chain.yaml"]
            assert told["texts"]["Save"] == Language(code)("Save")
    with page(house) as one:
        assert one.hello("xx")["lang"] == "en"


def test_a_drag_is_answered_with_the_file_that_says_it(house):
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
        assert full["verdict"] == approve(files.loads(told["text"])).verdict
        assert full["id"] == told["id"]


def test_numbers_and_names_are_edited_by_address(house):
    with page(house) as one:
        one.hello()
        told = one.ask(TEXT, edits={"driveline.shafts[2].phase_deg": 90, "title": "Two: three"})
        assert told["title"] == "Two: three"
        assert told["lines"][0]["phases"] == [0, 90]
        told = one.ask(TEXT, edits={"driveline.shafts[2].nothing": 1})
        assert "nothing" in json.dumps(told["problems"])


def test_a_joint_and_a_tube_are_swapped_by_name():
    text = TRUCK.read_text("utf-8")
    line = asked(text)["lines"][0]
    assert line["joint_at"] == ["driveline.joints"] * 4
    assert (line["joint_now"][0], line["tube_now"][2]) == ("2040", "120x4")
    sizes = {j["name"]: j for j in words.catalogue()["joints"]}
    tubes = {c["name"]: c for c in words.catalogue()["tubes"]}
    assert len(sizes) > 40
    assert len(tubes) > 20
    edits = {"driveline.joints": "2055", "driveline.shafts[3].tube": "100x3"}
    told = asked(text, edits=edits)
    app = files.loads(told["text"])
    assert app.lines[0].line.joints[0].peak_torque == sizes["2055"]["peak_Nm"]
    assert app.lines[0].line.shafts[2].tube.outer * 1e3 == pytest.approx(tubes["100x3"]["outer_mm"])
    assert told["text"].count("#") == text.count("#")
    assert 'joints: "2055"' in told["text"]


def test_sizes_that_a_file_does_not_give_are_taken_from_the_catalogue():
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


def test_what_is_wrong_with_a_file_is_an_answer(house):
    with page(house) as one:
        one.hello()
        told = one.ask(TEXT.replace("speed_rpm: 2800", "speed_rpm: fast"))
        (problem,) = told["problems"]
        assert (problem["key"], problem["line"]) == ("speed_rpm", 11)
        told = one.ask("title: [")
        assert told["problems"]


def test_the_latest_question_wins(house):
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
def test_a_line_follows_a_hand_while_its_limits_are_asked(house, monkeypatch):
    monkeypatch.setattr(session, "REST", 0.0)

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
        pid = house.lanes.limits.pid
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


def test_a_limit_is_shown_where_it_is_worst():
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


def test_what_holds_back_more_than_coasting_can_is_reverse():
    """Jounce of the refuse collector: 3.845 mm free, pulling away in reverse, as `check` says."""
    text = TRUCK.read_text("utf-8")
    (row,) = [r for r in asked(text)["limits"] if r["quantity"] == "clearance"]
    (spot,) = [s for s in row["spots"][4] if s]
    pose = {"travel_mm": 1e3, "torque_Nm": spot["torque_Nm"]}
    told = asked(text, "pose", pose=pose, want=[])["pose"]
    assert min(min(room) for room in told["at"]["clearance"]) == pytest.approx(3.845, abs=1e-3)
    assert told["torque"] == -7866


def test_a_state_stands_under_the_torque_that_it_is_drawn_with():
    text = TRUCK.read_text("utf-8")
    kinds = [s["kind"] for s in asked(text)["states"]]
    for state, kind in enumerate(kinds):
        told = asked(text, "pose", pose={"line": 0, "state": state})["pose"]
        line = asked(text)["lines"][0]
        wound = kind.startswith("windup")
        assert told["torque"] == (round(line["torque"][state]) if wound else 0)


def test_sliders_are_answered_with_places_and_curves():
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


def test_what_would_help_can_be_applied():
    told = asked(TEXT, "help")["helps"]
    assert told
    best = told[0]["bars"][0]
    after = asked(TEXT, edits=best["edits"])
    row = next(r for r in after["limits"] if r["quantity"] == told[0]["quantity"])
    assert row["values"][0][0] == pytest.approx(best["value"], rel=1e-4)


def test_what_a_move_spoils_stands_beside_it():
    told = asked((ROOT / "examples" / "vecto-4x2.yaml").read_text("utf-8"), "help")["helps"]
    static = next(h for h in told if h["quantity"] == "centre_bearing_static")
    first, then, _ = static["bars"]
    assert first["spoilt"] == ""
    assert then["gain"] > first["gain"]
    assert then["spoilt"].startswith("but then fail: Acceleration of a joint by itself")


# ------------------------------------------------------------------ what it says


def test_every_word_of_the_front_is_known_and_no_other():
    said = {"pass", "warn", "fail", "incomplete"}
    for source in (ROOT / "web" / "src").glob("*.ts*"):
        said |= set(re.findall(r'\bt\(\s*"((?:[^"\\]|\\.)*)"', source.read_text("utf-8")))
    assert sorted(said) == sorted(words.WORDS)
    for code in CODES:
        assert words.texts(Language(code)).keys() == said


def test_the_front_is_small_and_needs_three_packages():
    written = (ROOT / "web/src").glob("*.ts*")
    lines = sum(len(p.read_text("utf-8").splitlines()) for p in written)
    assert lines < 4000
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


def test_the_page_comes_with_every_guard(house):
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


def test_both_of_this_machines_own_addresses_are_served(house):
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
def test_what_comes_from_elsewhere_is_refused(house, headers):
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
def test_nothing_is_taken_and_nothing_else_is_served(house, path, method, headers, body, status):
    found, said, _ = got(house, path, method, headers, body)
    assert found == status
    assert said["x-content-type-options"] == "nosniff"


def test_heads_too_long_are_not_read(house):
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
def test_a_socket_from_elsewhere_is_refused(house, how):
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
def test_a_message_of_the_wrong_shape_ends_its_socket_alone(house, said):
    with page(house) as other, page(house) as one:
        other.hello()
        one.hello()
        one.socket.send(said)
        with pytest.raises(ConnectionClosed) as ended:
            one.hear("nothing")
        assert ended.value.rcvd.code == 1003
        assert other.open()["type"] == "opened"


MUCH = "x" * (LONGEST + 2)
TOO_MUCH = [
    ("live", dragging("[0, 0, 1e9]"), "a number is beyond 100000"),
    ("live", asking('"edits": {"a": "x\\ny"}'), "a would hold a character that nobody sees"),
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
    ("refused", json.dumps({"type": "freeze", "file": 0, "text": "", "by": "x" * 101, "note": ""}),
     "by is longer than 100"),
    ("refused", json.dumps({"type": "pin", "file": 0, "variants": [{"name": "", "text": ""}] * 13}),
     "variants are more than 12"),
    ("refused", json.dumps({"type": "bring", "id": 1, "name": "x" * 1001, "size": 1}),
     "name is longer than 1000"),
    ("done", json.dumps({"type": "job", "id": 1, "job": "life", "text": "",
                         "args": {"hours": "1" * 41}}), "hours is longer than 40 characters"),
    ("done", json.dumps({"type": "job", "id": 1, "job": "guided", "text": "",
                         "args": {"points": "0 0 0\n" * 4000}}), "points is longer than 20000"),
    ("refused", json.dumps({"type": "piece", "at": 0, "data": "A" * (parcel.PIECE + 8)}),
     "data is longer than 1500000"),
    ("done", json.dumps({"type": "job", "id": 1, "job": "map", "file": 0, "bytes": 24e6}),
     "what is asked takes 24 MB, more than the 8 MB that are read"),
]  # fmt: skip


@pytest.mark.parametrize(("kind", "said", "why"), TOO_MUCH, ids=lambda s: s[:60])
def test_what_is_more_than_is_taken_is_refused_in_words_and_the_socket_stays(
    house, kind, said, why
):
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


def test_bytes_and_messages_too_long_end_a_socket(house):
    for said in (b"{}", "x" * (server.MESSAGE + 1)):
        with page(house) as one:
            one.hello()
            with pytest.raises(ConnectionClosed):
                told_until_closed(one, said)
    assert got(house)[0] == 200


def test_a_text_names_no_file_outside_its_folder(house):
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
def test_a_hostile_name_is_told_as_it_is(name):
    told = asked(TEXT, edits={"title": name})
    assert told["title"] == name
    assert files.loads(told["text"]).title == name


@pytest.mark.parametrize("name", ["\u202egnp", "a\x1b[31m", "a\x00b", "a" * 20_000])
def test_a_name_that_hides_or_never_ends_is_refused(name):
    assert asked(TEXT.replace("Three-joint chain (Souza 2014, table 2)", name))["problems"]


# ------------------------------------------------------------------ the disk


def test_saving_writes_the_file_and_drops_the_draft(own):
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


def test_a_file_changed_meanwhile_is_not_written_over(own, monkeypatch):
    monkeypatch.setattr(session, "WATCH", 0.05)
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


def test_why_a_file_cannot_be_written_is_said_in_the_pages_language(own, monkeypatch):
    """Save, freeze and open said it in English: Permission denied."""
    house, path = own

    def denied(*_, **__):
        raise PermissionError(errno.EACCES, os.strerror(errno.EACCES), str(path))

    with page(house) as one:
        one.hello("pt")
        mark = one.open()["mark"]
        for name, what in (("save", {"mark": mark}), ("freeze", {"by": "A", "note": ""})):
            monkeypatch.setattr(house.desk, name, denied)
            one.say(name, file=0, text=TEXT, **what)
            told = one.hear("refused")
            assert (told["what"], told["why"]) == (name, "permissão negada")
        path.unlink()
        one.say("open", file=0)
        assert one.hear("refused")["why"] == "chain.yaml: não está mais lá"


def test_two_tabs_hear_of_each_other(own, monkeypatch):
    monkeypatch.setattr(session, "WATCH", 0.05)
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


def test_marks_and_line_ends_of_a_file_stay(tmp_path):
    path = tmp_path / "a.yaml"
    path.write_bytes(b"\xef\xbb\xbf" + TEXT.replace("\n", "\r\n").encode())
    desk = Desk(path, drafts=tmp_path / "drafts")
    opened = desk.open(0)
    new = asked(opened["saved"], edits={"speed_rpm": 2500})["text"]
    desk.save(0, new, opened["mark"])
    written = path.read_bytes()
    assert written.startswith(b"\xef\xbb\xbf#")
    assert written.count(b"\r\n") == written.count(b"\n") == TEXT.count("\n")
    with pytest.raises(Conflict):
        desk.save(0, TEXT, opened["mark"])


def test_what_is_gone_from_the_disk_is_said_and_saved_anew(tmp_path):
    """It was refused, with the path of another file for advice: nothing could be saved any more."""
    for name in ("a.yaml", "ab.yaml"):
        (tmp_path / name).write_text(TEXT, "utf-8")
    desk = Desk(tmp_path, drafts=tmp_path / "drafts")
    opened = desk.open(0)
    (tmp_path / "a.yaml").unlink()
    with pytest.raises(BadFile) as gone:
        desk.open(0)
    assert readable(gone.value) == "is no longer there"
    desk.save(0, TEXT + "# again\n", opened["mark"])
    assert (tmp_path / "a.yaml").read_text("utf-8") == TEXT + "# again\n"


def test_a_draft_of_another_file_or_a_broken_one_is_none(tmp_path):
    for name in ("a.yaml", "b.yaml"):
        (tmp_path / name).write_text(TEXT, "utf-8")
    desk = Desk(tmp_path, drafts=tmp_path / "drafts")
    assert [p.name for p in desk.papers] == ["a.yaml", "b.yaml"]
    desk.keep(0, "title: x", desk.open(0)["mark"])
    assert desk.open(1)["draft"] is None
    (kept,) = (tmp_path / "drafts").iterdir()
    assert kept.parent.stat().st_mode & 0o077 == 0 or os.name == "nt"
    desk.keep(1, "title: y", desk.open(1)["mark"])
    (other,) = set((tmp_path / "drafts").iterdir()) - {kept}
    other.write_bytes(kept.read_bytes())  # of the first, in the place of the second
    assert desk.open(0)["draft"] == "title: x"
    assert desk.open(1)["draft"] is None
    kept.write_text("{", "utf-8")
    assert desk.open(0)["draft"] is None


@pytest.mark.skipif(os.name == "nt", reason="links need a right there")
def test_no_link_leads_out_of_the_folder(tmp_path):
    """A folder of somebody else's listed, opened and saved what its links led to, anywhere."""
    desk, other = tmp_path / "desk", tmp_path / "other"
    (desk / "revisions").mkdir(parents=True)
    other.mkdir()
    (other / "theirs.yaml").write_text("title: theirs\n", "utf-8")
    (desk / "mine.yaml").write_text(TEXT, "utf-8")
    (desk / "again.yaml").symlink_to("mine.yaml")
    (desk / "out.yaml").symlink_to(other / "theirs.yaml")
    (desk / "revisions" / "mine.1.yaml").symlink_to(other / "theirs.yaml")
    opened = Desk(desk, drafts=tmp_path / "drafts")
    assert [p.name for p in opened.papers] == ["again.yaml", "mine.yaml"]
    assert opened.revisions(1) == []
    (desk / "revisions" / "mine.1.yaml").unlink()
    (desk / "revisions").rmdir()
    (desk / "revisions").symlink_to(other)
    with pytest.raises(BadFile, match="leads out of the folder"):
        opened.freeze(1, TEXT, by="A", note="")
    assert [p.name for p in other.iterdir()] == ["theirs.yaml"]


def test_half_a_letter_is_told_and_ends_nothing(house):
    with page(house) as one:
        one.hello()
        first = one.ask(TEXT)
        told = one.ask('title: "\ud800"')
        assert "fault" not in told
        assert told["problems"]
        pid = house.lanes.quick.pid
        assert one.ask(TEXT)["title"] == first["title"]
        assert house.lanes.quick.pid == pid


def test_what_cannot_be_opened_is_said(tmp_path):
    for name in ("no.yaml", "."):
        found = CliRunner().invoke(cli, ["serve", str(tmp_path / name / "x")])
        assert found.exit_code == 2
    binary = tmp_path / "b.yaml"
    binary.write_bytes(b"\xff\xfe\x00")
    with pytest.raises(BadFile, match="no UTF-8"):
        Desk(binary, drafts=tmp_path)


def test_a_browser_is_started_with_a_code_that_opens_once(own, monkeypatch):
    """Whoever may list processes sees that code, and comes too late with it."""
    house, _ = own
    code = house.opening.rpartition("#")[2]
    assert code != house.token
    with page(house, token=code) as one:
        assert one.hello()["token"] == house.token
    for late in (code, ""):
        with pytest.raises(InvalidStatus), reached(house, token=late or "x"):
            pass
    code = house.opening.rpartition("#")[2]
    monkeypatch.setattr("cardan.web.guard.monotonic", lambda: time.monotonic() + 61)
    with pytest.raises(InvalidStatus), reached(house, token=code):
        pass
    with page(house) as one:
        assert one.hello()


# ------------------------------------------------------------------ how it lives and ends


def test_it_listens_on_this_machine_alone():
    opened = server.sockets(0)
    try:
        names = [one.getsockname() for one in opened]
        assert {n[0] for n in names} <= {"127.0.0.1", "::1"}
        assert len({n[1] for n in names}) == 1
        with pytest.raises(CardanError, match=f"port {names[0][1]} cannot be used"):
            server.sockets(names[0][1])
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
def test_a_taken_port_is_bad_input(lang, words):
    with socket.socket() as one:
        one.bind(("127.0.0.1", 0))
        one.listen()
        port = str(one.getsockname()[1])
        found = CliRunner().invoke(cli, ["serve", str(CHAIN), "--port", port, *lang])
    assert found.exit_code == 2
    for said in words:
        assert said in found.output
    assert bool(lang) != ("cannot be used" in found.output)


def test_without_the_built_page_it_says_what_is_missing(tmp_path, monkeypatch):
    monkeypatch.setattr(server, "files", lambda _: tmp_path)
    with pytest.raises(NotInstalled, match="make serve") as missing:
        server.front()
    for code in ("pt", "it"):
        assert "is not built" not in Language(code).error(str(missing.value))


@pytest.mark.parametrize(
    ("lang", "ends"), [("en", "Ends with"), ("pt", "Termina com"), ("it", "Termina con")]
)
def test_what_it_says_as_it_starts_is_in_the_language(tmp_path, monkeypatch, lang, ends):
    page = tmp_path / "static" / "index.html"
    page.parent.mkdir()
    page.write_text("<html></html>", encoding="utf-8")
    monkeypatch.setattr(server, "files", lambda _: tmp_path)
    monkeypatch.setattr(server, "serve", lambda *_, ready: ready())
    found = CliRunner().invoke(cli, ["serve", str(CHAIN), "--no-browser", f"--lang={lang}"])
    assert (found.exit_code, f"{ends} Ctrl-C." in found.output) == (0, True), found.output


@pytest.mark.parametrize(("code", "got"), [("pt", "uma lista de 2"), ("it", "una lista di 2")])
def test_what_was_given_is_told_in_the_language_where_it_is_no_text_of_the_file(code, got):
    (problem,) = asked(TEXT.replace("speed_rpm: 2800", "speed_rpm: [1, 2]"), lang=code)["problems"]
    assert (problem["key"], problem["value"]) == ("speed_rpm", got)


def test_connections_that_ask_nothing_are_ended(tmp_path, monkeypatch):
    monkeypatch.setattr(server, "SILENT", 0.3)
    monkeypatch.setattr(server, "CONNECTIONS", 20)
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


def test_ten_thousand_sockets_leave_a_page_its_answers(own):
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
        ended, end = 0, time.monotonic() + server.SILENT / 2
        with selectors.DefaultSelector() as ready:  # `select` knows no descriptor above 1023
            for other in held:
                ready.register(other, selectors.EVENT_READ)
            while len(held) - ended > server.CONNECTIONS and time.monotonic() < end:
                ended = len(ready.select(0.05))
        assert len(held) - ended <= server.CONNECTIONS
        for other in held:
            other.close()


def test_more_pages_than_a_person_opens_are_not_let_in(tmp_path, monkeypatch):
    monkeypatch.setattr(server, "PAGES", 2)
    path = tmp_path / "chain.yaml"
    path.write_text(TEXT, "utf-8")
    with running(path, tmp_path / "drafts") as house:
        with page(house) as one, page(house) as two:
            assert one.hello()
            assert two.hello()
            with pytest.raises((InvalidStatus, ConnectionClosed)), page(house) as three:
                three.hello()
        end = time.monotonic() + PATIENCE
        while house.pages and time.monotonic() < end:
            time.sleep(0.01)
        with page(house) as again:
            assert again.hello()


async def _slow():
    lane = Lane(longest=0.001)
    try:
        question = {"job": "live", "text": TEXT, "name": "x", "folder": None, "lang": "en"}
        first = await lane.ask(question)
        lane.longest = PATIENCE
        second = await lane.ask(question)
        pid = lane.pid
        os.kill(pid, signal.SIGTERM)
        third = await lane.ask(question)
        fourth = await lane.ask(question)
        return first, second, third, fourth, pid, lane.pid
    finally:
        lane.close()
        await lane.closed()


def test_what_takes_too_long_or_dies_is_replaced():
    import asyncio

    first, second, third, fourth, was, now = asyncio.run(_slow())
    assert first == {"fault": "too slow"}
    assert second["title"] == fourth["title"]
    assert third in ({"fault": "ended"}, second)
    assert was != now


def test_a_fault_of_ours_is_told_and_the_next_question_answered():
    import asyncio

    async def ask():
        lane = Lane()
        try:
            question = {"job": "nothing", "text": TEXT, "name": "x", "folder": None, "lang": "en"}
            return await lane.ask(question), await lane.ask({**question, "job": "live"})
        finally:
            lane.close()
            await lane.closed()

    broken, whole = asyncio.run(ask())
    assert broken == {"fault": "KeyError"}
    assert whole["title"]


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="looks processes up in /proc")
@pytest.mark.parametrize(
    "how", chief([signal.SIGINT, signal.SIGTERM, signal.SIGKILL], signal.SIGKILL)
)
def test_it_ends_without_orphans_even_in_the_middle(tmp_path, how):
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


def test_no_log_holds_the_token(own, caplog, capfd):
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


def test_a_page_that_does_not_read_is_let_go(own, monkeypatch):
    """What it is told fills what the system keeps for it; then its socket ends, not the server."""
    monkeypatch.setattr(session, "SLOWEST", 0.5)
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


def test_lanes_take_only_the_latest():
    import asyncio

    async def take():
        class Echo:
            async def ask(self, question):
                return question

        latest = lanes.Latest(Echo())
        for k in range(5):
            latest.put({"k": k})
        first = await latest.take()
        latest.put({"k": 9})
        latest.drop()
        latest.put({"k": 10})
        return first, await latest.take()

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
    return json.loads(told.output)["verdict"]


@pytest.fixture
def ours(tmp_path, monkeypatch):
    """A workbench with a file whose limits are one's own, in a file beside it."""
    monkeypatch.setattr(session, "WATCH", 0.05)
    path, limits = tmp_path / "chain.yaml", tmp_path / "mine.yaml"
    path.write_text(OURS, "utf-8")
    limits.write_text(HOUSE, "utf-8")
    with running(path, tmp_path / "drafts") as found:
        yield found, path, limits


def loose(limits):
    limits.write_text(HOUSE.replace(" 100", " 900").replace(" 120", " 1000"), "utf-8")


def test_limits_that_change_on_disk_change_the_verdict_of_the_same_text(ours):
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


def test_a_page_hears_that_a_file_it_names_is_another_or_there_at_last(ours):
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


def test_a_frozen_revision_stays_what_was_approved_whatever_its_limits_become(ours):
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


def test_a_revision_keeps_its_catalogues_too_each_under_its_name(tmp_path):
    """Rewritten at the keys that name files, and nowhere else that says the same."""
    (tmp_path / "sub").mkdir()
    (tmp_path / "sub" / "ours.csv").write_text("name\n", "utf-8")
    title = 'title: "sub/ours.csv"\ncatalogues: [sub/ours.csv]'
    text = re.sub(r"(?m)^title:.*$", title, OURS)
    (tmp_path / "a.yaml").write_text(text, "utf-8")
    (tmp_path / "mine.yaml").write_text(HOUSE, "utf-8")
    desk = Desk(tmp_path / "a.yaml", drafts=tmp_path / "drafts")
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
    paper = desk.papers[0]
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


@pytest.mark.parametrize("most", [64_000_000, 10_000])
def test_a_frozen_campaign_keeps_its_recordings_and_who_writes_into_them_is_told_of(
    job, monkeypatch, most
):
    """It kept its text alone: another recording under that name was what had been approved."""
    monkeypatch.setattr(revisions, "HEAVIEST", most)
    desk = Desk(job / "campaign.yaml", drafts=job / "drafts")
    (kept,) = desk.freeze(0, desk.open(0)["saved"], by="A", note="")
    revision = job / "revisions" / "campaign.1.yaml"
    copy = sums(revision)["joints.parquet"]
    assert {*sums(revision)} == {"joints.parquet", "application.yaml"}
    # What is heavy takes no room: it is a second name of the file.
    original = job / "joints.parquet"
    assert copy.samefile(original) == (most < 64_000_000)
    assert campaign.read(revision).drives[0].file.read_bytes() == original.read_bytes()
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
def test_what_nobody_can_read_or_nobody_signs_is_not_frozen(tmp_path, text, by, why):
    """A signature on a text that had not been shown, and one that nobody sees."""
    (tmp_path / "a.yaml").write_text(TEXT, "utf-8")
    desk = Desk(tmp_path / "a.yaml", drafts=tmp_path / "drafts")
    with pytest.raises(BadFile) as found:
        desk.freeze(0, text, by=by, note="")
    assert why in str(found.value)
    assert desk.revisions(0) == []


def test_a_link_that_cannot_be_made_is_a_copy(job, monkeypatch):
    """A stick or a share may know no second names."""

    def never(*_):
        raise OSError(errno.EPERM, os.strerror(errno.EPERM))

    monkeypatch.setattr(revisions, "HEAVIEST", 0)
    monkeypatch.setattr(os, "link", never)
    desk = Desk(job / "tracks.yaml", drafts=job / "drafts")
    desk.freeze(0, desk.open(0)["saved"], by="A", note="")
    copy = sums(job / "revisions" / "tracks.1.yaml")["road.parquet"]
    assert not copy.samefile(job / "road.parquet")


def test_a_frozen_bracket_keeps_the_step_file_of_its_shape(job):
    """`cardan bracket` on the revision reads the shape that was approved."""
    desk = Desk(job / "from-step.yaml", drafts=job / "drafts")
    (kept,) = desk.freeze(0, desk.open(0)["saved"], by="A", note="")
    revision = job / "revisions" / "from-step.1.yaml"
    was = (job / "bracket.step").read_bytes()
    assert sums(revision)["bracket.step"].read_bytes() == was
    assert since(desk, kept) == []
    (job / "bracket.step").write_bytes(was + b"\n")
    ((name, *_),) = since(desk, kept)
    assert name == "bracket.step.file: other contents"
    assert Path(files.read(revision).bracket.shape.path).read_bytes() == was


def test_a_frozen_file_keeps_what_its_files_name(tmp_path):
    """An application of a campaign has limits and catalogues of its own: they were left out."""
    (tmp_path / "sub").mkdir()
    (tmp_path / "sub" / "app.yaml").write_text(OURS, "utf-8")
    (tmp_path / "sub" / "mine.yaml").write_text(HOUSE, "utf-8")
    (tmp_path / "a.csv").write_text("time_s,S1 [MPa]\n0,1\n1,2\n", "utf-8")
    text = "campaign: A day\nrecordings: [{file: a.csv}]\napplication: sub/app.yaml\n"
    text += "gauges: [S1]\nstrength: {amplitude_MPa: 30, cycles: 2e6, slope: 5}\n"
    (tmp_path / "c.yaml").write_text(text, "utf-8")
    desk = Desk(tmp_path / "c.yaml", drafts=tmp_path / "drafts")
    (kept,) = desk.freeze(0, text, by="A", note="")
    revision = tmp_path / "revisions" / "c.1.yaml"
    assert {*sums(revision)} == {"a.csv", "sub/app.yaml", "sub/mine.yaml"}
    assert campaign.read(revision).options["application"].profile == "house"
    (tmp_path / "sub" / "mine.yaml").write_text(HOUSE + "# \n", "utf-8")
    assert [row[0] for row in since(desk, kept)] == ["application: other contents"]


@pytest.mark.parametrize("how", ["full", "half a letter"])
def test_what_cannot_be_written_leaves_nothing_behind(tmp_path, monkeypatch, how):
    """A full disk left an empty revision that was listed, and an empty file; half a letter too."""
    (tmp_path / "a.yaml").write_text(OURS, "utf-8")
    (tmp_path / "mine.yaml").write_text(HOUSE, "utf-8")
    desk = Desk(tmp_path / "a.yaml", drafts=tmp_path / "drafts")
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
        with pytest.raises(BadFile, match="No space left" if how == "full" else "half a letter"):
            write()
    left = {p.name for p in tmp_path.rglob("*")}
    assert left <= {"a.yaml", "mine.yaml", "revisions", "drafts"}
    assert desk.revisions(0) == []
    assert (tmp_path / "a.yaml").read_text("utf-8") == OURS


def test_each_page_keeps_its_own_unsaved_text(own):
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


def test_who_comes_back_takes_nobody_elses_unsaved_text(own):
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


def test_a_draft_of_another_text_is_told_with_what_it_was_edited_from(own):
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


def test_what_a_process_leaves_half_done_goes_with_it(tmp_path, monkeypatch):
    """Texts of applications lay in the folder for temporary files after each job that was ended."""
    monkeypatch.setattr(lanes.tempfile, "tempdir", str(tmp_path))

    async def ended():
        lane = Lane()
        await lane.start()
        (folder,) = tmp_path.iterdir()
        environment = Path(f"/proc/{lane.pid}/environ")
        if environment.exists():
            while not (held := environment.read_bytes()):  # it is being begun
                await asyncio.sleep(0.01)
            assert f"TMPDIR={folder}".encode() in held.split(b"\0")
        (folder / "question").write_text(TEXT, "utf-8")
        lane.close()
        await lane.closed()

    asyncio.run(ended())
    assert list(tmp_path.iterdir()) == []


def test_half_a_letter_is_refused_and_kept_as_a_draft(own):
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
def test_lines_end_as_they_did_whatever_a_browser_makes_of_them(tmp_path, before, typed, after):
    """By hand: one letter typed turned every end of the file, and its difference was all of it."""
    path = tmp_path / "a.yaml"
    path.write_bytes(before.encode())
    desk = Desk(path, drafts=tmp_path / "drafts")
    opened = desk.open(0)
    assert "\r" not in opened["saved"]
    desk.save(0, opened["saved"], opened["mark"])
    assert path.read_bytes() == before.encode()
    desk.save(0, typed, opened["mark"])
    assert path.read_bytes() == after.encode()


@pytest.mark.slow
def test_a_report_has_the_fingerprint_of_its_file(own):
    """As `sha256sum` tells it: of a file with a mark and `CRLF` it was that of the text."""
    house, path = own
    path.write_bytes(b"\xef\xbb\xbf" + TEXT.replace("\n", "\r\n").encode())
    with page(house) as one:
        one.hello()
        saved = one.open()["saved"]
        one.say("job", id=1, job="report", text=saved, args={"kind": "html", "lang": "en"})
        told = b64decode(one.hear("done")["data"]).decode()
    assert sha256(path.read_bytes()).hexdigest()[:16] in told


def test_a_draft_is_no_other_tabs_to_throw_away(own):
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


def test_drafts_that_cannot_be_kept_are_told_of(tmp_path):
    """Where their folder is a file: nothing was said, and a crash lost all."""
    path, drafts = tmp_path / "chain.yaml", tmp_path / "drafts"
    path.write_text(TEXT, "utf-8")
    drafts.write_text("a file", "utf-8")
    with running(path, drafts) as house, page(house) as one:
        one.hello()
        one.say("keep", file=0, text=TEXT + "# mine\n", mark=one.open()["mark"])
        told = one.hear("kept", "refused")
        assert (told["type"], told["what"]) == ("refused", "keep")
