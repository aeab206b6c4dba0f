"""What takes long on the workbench: asked, told part by part, stopped; and what it answers."""

import json
import os
import re
import shlex
import signal
import subprocess
import sys
from base64 import b64decode
from pathlib import Path

import numpy as np
import pytest
from case_selection import select
from click.testing import CliRunner
from repository import ROOT
from websockets.exceptions import ConnectionClosed
from workbench import PATIENCE, page, running

import cardan
from cardan.application import reader
from cardan.approval.approval import approve_application, approve_driveline
from cardan.checks.mount_loads import MountLoads
from cardan.checks.quantities.registry import LINE_QUANTITIES
from cardan.cli import cli
from cardan.core.verdict import VERDICTS, worst_verdict
from cardan.render.i18n import ENGLISH, Translator
from cardan.topics.design.phrases import (
    correction_improvement_sentence,
    production_tolerance_sentence,
    tolerance_yield_sentences,
)
from cardan.web.correction_handlers import IMMEDIATE_QUANTITIES
from cardan.web.handlers import handle_request
from cardan.web.limit_messages import limit_rows

TRUCK = (ROOT / "examples" / "refuse-collector-6x2.yaml").read_text("utf-8")
CHAIN = (ROOT / "examples" / "three-joint-chain.yaml").read_text("utf-8")


@pytest.fixture(scope="module")
def house(tmp_path_factory):
    folder = tmp_path_factory.mktemp("desk")
    (folder / "truck.yaml").write_text(TRUCK, "utf-8")
    with running(folder / "truck.yaml", folder / "drafts") as found:
        yield found


def job(name, text=TRUCK, parts=None, lang="en", **args):
    question = {"job": name, "text": text, "name": "x.yaml", "folder": None, "lang": lang}
    found = handle_request({**question, "args": args}, (parts if parts is not None else []).append)
    assert "problems" not in found, found
    return found


# ------------------------------------------------------------------ how they run


@pytest.mark.slow
@pytest.mark.skipif(not hasattr(signal, "SIGSTOP"), reason="holds a process still")
def test_quick_answers_do_not_wait_for_long_jobs(house):
    """The limits had come 17 s after they were asked for, behind a bracket.

    Nor do hands wait behind what a view shows by itself: corrections had, behind its map.
    """
    with page(house) as one:
        one.hello()
        text = one.open()["saved"]
        one.say("ask", id=1, text=text)
        one.hear("full")
        one.say("job", id=2, job="torsion", text=text, args={})
        one.hear("part")
        pid = house.workers.jobs.pid
        os.kill(pid, signal.SIGSTOP)
        try:
            for number in (3, 4):
                one.say("job", id=number, job="limits", text=text, args={})
            one.say("cancel", id=3)
            assert {one.hear("done")["id"] for _ in range(2)} == {3, 4}
            one.say("job", id=5, job="library", text="", args={})
            assert [row["name"] for row in one.hear("done")["rows"]] == ["truck.yaml"]
            for number, sought in ((6, False), (7, True)):
                args = {"x": "bearing_height 2", "y": "shim 1", "sought": sought}
                one.say("job", id=number, job="map", text=text, args=args)
            assert one.hear("done")["id"] == 6
            one.say("job", id=8, job="speeds", text=text, args={"state": 1})
            assert one.hear("done")["id"] == 8
            one.say("cancel", id=7)
            assert one.hear("done")["id"] == 7
        finally:
            os.kill(pid, signal.SIGCONT)
        one.say("cancel", id=2)
        assert one.hear("done")["fault"] == "cancelled"
        assert house.workers.jobs.pid not in (None, pid)  # who asks next finds a process


@pytest.mark.slow
def test_job_sends_partial_results_before_its_result(house):
    with page(house) as one:
        one.hello()
        text = one.open()["saved"]
        one.say("job", id=7, job="speeds", text=text, args={"state": 1})
        done = one.hear("done")
        assert (done["id"], done["job"]) == (7, "speeds")
        assert done["said"].startswith("empty")  # the state; what follows is of its rubber
        one.say("job", id=8, job="torsion", text=text, args={})
        part = one.hear("part")
        assert part["id"] == 8
        assert part["part"]["doing"]
        one.say("cancel", id=8)
        assert one.hear("done") == {"type": "done", "id": 8, "job": "torsion",
                                    "fault": "cancelled"}  # fmt: skip
        one.say("job", id=9, job="speeds", text=text, args={})
        assert one.hear("done")["bearings"]


@pytest.mark.slow
def test_drag_is_answered_while_job_runs(house):
    with page(house) as one:
        one.hello()
        text = one.open()["saved"]
        one.say("job", id=3, job="torsion", text=text, args={})
        one.hear("part")
        told = one.ask(text, edits={"driveline.shafts[1].phase_deg": 10})
        assert told["lines"][0]["phases"][0] == 10
        one.say("cancel", id=3)
        assert one.hear("done")["fault"] == "cancelled"


@pytest.mark.parametrize(
    "said",
    [
        {"job": "nothing", "args": {}},
        {"job": "speeds", "args": {"state": -1}},
        {"job": "speeds", "args": {"path": "/etc/passwd"}},
        {"job": "speeds", "args": []},
        {"job": ["speeds"], "args": {}},
        {"job": "speeds", "args": {}, "id": "7"},
    ],
)
def test_malformed_job_message_closes_connection(house, said):
    with page(house) as one:
        one.hello()
        one.say("job", **{"id": 1, "text": TRUCK, **said})
        with pytest.raises(ConnectionClosed):
            one.hear("done")


def test_job_reports_errors_of_file_text(house):
    with page(house) as one:
        one.hello()
        one.say("job", id=1, job="speeds", text="title: [", args={})
        assert one.hear("done")["problems"][0]["line"] > 0


# ------------------------------------------------------------------ over speed


def test_waterfall_maximum_matches_worst_bearing_force_of_check(monkeypatch):
    """The check seeks the worst speed; a waterfall has many: none is worse, one is as bad.

    Of linear rubber, which a waterfall has beyond its stop too.
    """
    monkeypatch.setattr(MountLoads, "stop_response_on", lambda *_: None)
    monkeypatch.setattr(MountLoads, "stuck_forces", None)
    found = approve_driveline(reader.loads(TRUCK))
    for quantity, key in (("centre_bearing_dynamic", "dynamic"), ("centre_bearing_peak", "peak")):
        checks = [c for c in found.checks if c.quantity == quantity]
        states = [s.name for s in found.application.states]
        for c in sorted(checks, key=lambda c: c.value)[-2:]:
            told = job("speeds", state=states.index(c.when.name))
            bearing = told["bearings"][int(c.part.number) - 1]
            every = np.array(bearing[key], dtype=float)
            assert np.nanmax(every) == pytest.approx(c.value, rel=0.015)
            assert np.nanmax(every) <= c.value * (1 + 1e-4)
            graded = np.array(bearing["grades"][key], dtype=float)
            assert ("pass", "warn", "fail")[int(np.nanmax(graded))] == c.grade


def test_order_contributions_sum_to_dynamic_bearing_force():
    told = job("speeds", state=1)
    for b in told["bearings"]:
        _, *joints = (np.array(o, dtype=float) for o in b["orders"])
        whole = np.array(b["dynamic"], dtype=float)
        # Each is told to a tenth of a newton.
        assert np.nanmax(np.abs(sum(joints) - whole)) <= 0.21


def test_campbell_resonances_lie_on_order_lines():
    told = job("speeds", state=1)
    assert [d["title"] for d in told["diagrams"]] == ["The line on its bearings", "Bending"]
    rubber = told["diagrams"][0]
    assert len(rubber["modes"]) == 4
    for meet in rubber["meets"]:
        order = float(meet["said"].rpartition(" ")[2])
        assert meet["rpm"] * order / 60 == pytest.approx(meet["Hz"], abs=0.5 * order / 60 + 0.01)
    for order in rubber["orders"]:
        n = float(order["said"].rpartition(" ")[2])
        assert order["Hz"][1] == pytest.approx(n * rubber["rpm"][1] / 60, abs=0.02)


@pytest.mark.slow
def test_torsion_job_matches_vibration_study():
    from cardan.topics.torsion.study import analyse_vibration

    of = analyse_vibration(reader.loads(TRUCK))
    parts: list[dict[str, object]] = []
    told = job("torsion", parts=parts)
    assert parts
    assert len(told["diagrams"]) == len(of.gears)
    assert told["diagrams"][0]["range"][1] == pytest.approx(
        np.nanmax(of.closed.ranges[0, :, 1]) * 30 / np.pi, abs=1
    )
    assert [round(one.peak_torque[one.first_shaft]) for one in of.launches] == [
        round(one["peak"]) for one in told["launches"]
    ]


# ------------------------------------------------------------------ from a form

FORM = {
    "title": "A", "speed": "2500", "limits": "protractor",
    "members": [{"side": "3"}, {"side": "1"}, {"side": "2"}], "shafts": [{"length": "1200"}],
}  # fmt: skip


def test_guided_form_reports_warnings_and_reads_localised_numbers():
    def wrong(lang, **changed):
        question = {"job": "guided", "text": "", "name": "x", "folder": None, "lang": lang}
        return handle_request({**question, "args": {**FORM, **changed}}).get("problems", [])

    for lang, sign in (("en", "."), ("pt", ","), ("it", ",")):
        told = job("guided", text="", lang=lang, **{**FORM, "speed": "2,5"})
        assert any(w.startswith(f"2{sign}5 rpm ") for w in told["warnings"])
        (short,) = wrong(lang, shafts=[{"length": "1,5"}])
        assert short["value"] == f"1{sign}5"
        assert len(wrong(lang, torque="8.000")) == (lang != "en")
    (either,) = wrong("it", torque="8.000")
    assert either["message"] == "decimali o migliaia? scrivere 8,000 o 8000"
    assert either["value"] == "8.000"


def test_guided_form_result_matches_check_of_its_file():
    told = job("guided", text="", **FORM)
    found = approve_driveline(reader.loads(told["draft"]))
    assert told["verdict"] == found.verdict
    assert told["angles"] == pytest.approx([2, 1])
    assert len(told["checks"]) == min(8, len(found.checks))


def test_guided_form_with_two_wheelbases_gives_both_files():
    form = {**FORM, "wheelbase_from": "3600", "wheelbase_to": "4500"}
    told = job("guided", text="", **form)
    found = approve_driveline(reader.loads(told["after"]["draft"]))
    assert told["after"]["verdict"] == found.verdict
    assert "# Wheelbase 3600" in told["draft"]
    question = {"job": "guided", "text": "", "name": "x", "folder": None, "lang": "pt"}
    short = handle_request({**question, "args": {**form, "wheelbase_to": "2000"}})
    assert "entre-eixos" in short["problems"][0]["message"]


def test_lower_bounds_are_marked_in_messages_of_limits():
    """Rubber on its stop: the true force of the bearing is larger than that shown."""
    app = reader.loads(TRUCK)
    response = approve_driveline(app).line_responses[0]
    rows = {r["quantity"]: r for r in limit_rows(response, Translator("en"), LINE_QUANTITIES)}
    marked = {(k, s, p) for k, r in rows.items() for s, of in enumerate(r.get("bounds", []))
              for p, least in enumerate(of) if least}  # fmt: skip
    wanted = {(c.quantity, [s.name for s in app.states].index(c.state))
              for c in approve_driveline(app).checks if c.is_lower_bound}  # fmt: skip
    assert {m[:2] for m in marked} == wanted
    assert "torsional_acceleration" in rows
    assert "bounds" not in rows["torsional_acceleration"]


def test_pasted_points_edit_every_driveline_format():
    for text, rows in ((TRUCK, "0 0 0\n1000 0 -35\n2000 0 -90\n3350 -40 -146"),
                       (CHAIN, "0 0 0\n1300 0 -60\n2810 0 -160")):  # fmt: skip
        told = job("pasted", text=text, points=rows)
        after = reader.loads(live(text, told["edits"])["text"])
        wanted = np.array([[float(v) for v in row.split()] for row in rows.split("\n")]) / 1000
        got = after.lines[0].layout.points
        # Joint 1 of a line by angles is its own origin; its numbers are to 0.001 deg.
        assert got - got[0] == pytest.approx(wanted - wanted[0], abs=2e-4)


def live(text, edits):
    question = {"job": "live", "text": text, "name": "x.yaml", "folder": None, "lang": "en"}
    return handle_request({**question, "edits": edits})


def test_new_file_does_not_overwrite_existing_file(tmp_path):
    (tmp_path / "tipper.yaml").write_text("mine", "utf-8")
    with running(tmp_path, tmp_path / "drafts") as house, page(house) as one:
        assert one.hello()["files"] == ["tipper.yaml"]
        for name, title in (("tipper-1.yaml", "Tipper"), ("etc-passwd.yaml", "../../etc/passwd"),
                            ("driveline.yaml", "カルダン")):  # fmt: skip
            one.say("create", title=title, text="title: new\n")
            assert one.hear("files", "refused")["files"][-1] == name
            assert one.hear("opened")["saved"] == "title: new\n"
            assert (tmp_path / name).read_text("utf-8") == "title: new\n"
        assert (tmp_path / "tipper.yaml").read_text("utf-8") == "mine"
        assert len([p for p in tmp_path.iterdir() if p.suffix == ".yaml"]) == 4


# ------------------------------------------------------------------ variants


def test_variant_comparison_matches_report():
    other = CHAIN.replace("2800", "1400")
    parts = []
    told = job("compare", text=CHAIN, parts=parts, variants=[{"name": "slow", "text": other}])
    assert [v["name"] for v in told["variants"]] == ["", "slow"]
    assert [v["verdict"] for v in told["variants"]] == [
        approve_application(reader.loads(t)).verdict for t in (CHAIN, other)
    ]
    assert any("2800" in d["values"][0] and "1400" in d["values"][1] for d in told["differences"])
    row = next(e for e in told["effects"] if "Torsional acceleration" in e["name"])
    first, second = (float(v.split(" (")[0]) for v in row["values"])
    assert first / second == pytest.approx(4, rel=1e-3)  # with the speed squared
    assert [p["done"] for p in parts] == [0, 1]


@pytest.mark.parametrize(
    ("name", "old", "new"),
    [
        ("Application: title", "title: Three-joint chain (Souza 2014, table 2)", "title: カルダン"),
        ("Limits: limits.overrides[1].source", "source: test", "source: signed Q. Engineer"),
        ("Vehicle: tyre.dynamic_radius_mm", "dynamic_radius_mm: 490", "dynamic_radius_mm: 480"),
        ("Line main: shaft 1, yoke phase", "phase_deg: 0 ", "phase_deg: 90 "),
        ("tyre.static_radius_mm", "static_radius_mm: 480", "static_radius_mm: 480.00001"),
    ],
)
def test_each_difference_between_variants_is_listed_once(name, old, new):
    """A yoke phase stood there in words and by its address; by that what words round away does."""
    more = """
tyre: {static_radius_mm: 480, dynamic_radius_mm: 490}
limits:
  profile: heavy-truck
  overrides: [{quantity: joint_angle, maximum: 20, source: test}]
"""
    text = re.sub(r"(?m)^limits:.*$", "", CHAIN) + more
    assert old in text
    other = {"name": "now", "text": text.replace(old, new)}
    (found,) = job("compare", text=text, variants=[other])["differences"]
    assert found["name"] == name
    for value, line in zip(found["values"], (old, new), strict=True):
        assert value.removesuffix(" deg") == line.partition(": ")[2].strip()
    # Of other files only what shows.
    rows = job("compare", text=text, variants=[other], same=False)["differences"]
    assert rows == ([] if name.startswith("tyre") else [found])


@pytest.mark.slow
def test_kept_variants_are_restored_with_their_file(tmp_path):
    (tmp_path / "a.yaml").write_text(CHAIN, "utf-8")
    kept = [{"name": "\u202ex<script>", "text": CHAIN + "# 2\n"}]
    for start in range(2):  # and after a start of another server
        with running(tmp_path, tmp_path / "drafts") as house, page(house) as one:
            one.hello()
            if start == 0:
                assert one.open()["variants"] == []
                one.say("pin", file=0, variants=kept)
                one.hear("kept")
            assert one.open()["variants"] == kept
    with running(tmp_path, tmp_path / "drafts") as house, page(house) as one:
        one.hello()
        one.say("pin", file=0, variants=[{"name": "x" * 101, "text": ""}])
        assert "longer than 100" in one.hear("refused")["why"]


# ------------------------------------------------------------------ what to change


@pytest.mark.slow
def test_corrections_match_fix_command_and_their_edits_apply_them():
    from cardan.topics.design.corrections import find_corrections

    told = job("fix", text=CHAIN, hold=["bearing_height 1", "no such thing"])
    found = find_corrections(reader.loads(CHAIN), hold=["bearing_height 1"], count=6)
    assert [p["verdict"] for p in told["proposals"]] == [p.verdict for p in found]
    assert [p["margin"] for p in told["proposals"]] == pytest.approx(
        [p.approval.smallest_margin for p in found], rel=1e-5
    )
    assert told["scatter"] == production_tolerance_sentence(found[0].tolerance_model, ENGLISH)
    assert [p["survives"] for p in told["proposals"]] == [
        [
            correction_improvement_sentence(p, ENGLISH.with_minus_sign),
            *tolerance_yield_sentences(
                p.tolerance_yield, p.tolerance_model, ENGLISH.with_minus_sign
            ),
        ]
        for p in found
    ]
    for p in told["proposals"]:
        after = approve_application(reader.loads(live(CHAIN, p["edits"])["text"]))
        assert after.verdict == p["verdict"]
        assert after.smallest_margin == pytest.approx(p["margin"], rel=1e-3)  # edits are rounded


@pytest.mark.slow
def test_first_correction_is_sent_early_and_its_edits_give_its_result():
    parts = []
    last = job("fix", text=CHAIN, parts=parts)["proposals"]
    told = [bool(part.get("proposals")) for part in parts if part.keys() & {"proposals", "done"}]
    assert told[0]
    (first,) = next(part["proposals"] for part in parts if "proposals" in part)
    after = approve_application(reader.loads(live(CHAIN, first["edits"])["text"]))
    assert (after.verdict, first["verdict"]) == ("pass", "pass")
    assert after.smallest_margin == pytest.approx(first["margin"], rel=1e-3)  # edits are rounded
    # Equal, where the smallest margin is one that nothing moves.
    assert first["margin"] <= max(p["margin"] for p in last)


@pytest.mark.parametrize("line", [0, 1])
def test_adjustable_names_match_hold_option(line):
    text = (ROOT / "examples" / "tandem-6x4.yaml").read_text("utf-8")
    rows = live(text, {})["lines"][line]["movable"]
    assert len({r["id"] for r in rows}) == len(rows) > 1
    assert all(r["low"] <= 0 <= r["high"] for r in rows)
    free = [r["id"] for r in rows if r["free"]]
    assert free


def moved(text, moves):
    """Return the application of a file whose text moves were written into."""
    return reader.loads(live(text, job("moved", text=text, moves=moves)["edits"])["text"])


def at(told, r, c):
    """Return the moves of a cell."""
    return [{"id": told[k]["id"], "amount": told[k]["values"][i]} for k, i in (("x", c), ("y", r))]


def shown(told, r, c):
    return VERDICTS[told["verdicts"][r][c]], told["names"][told["decides"][r][c]]


@pytest.mark.slow
def test_every_map_cell_matches_its_own_check():
    parts = []
    told = job("map", text=TRUCK, parts=parts, x="bearing_height 2", y="shim 1")
    assert [len(p["map"]["verdicts"]) for p in parts if "map" in p] == [9, 17]
    done = [p["done"] for p in parts if "done" in p]
    assert done == sorted(done)
    assert len(done) > 8  # a bar that moves
    assert len(told["verdicts"]) == len(told["x"]["values"]) == 33
    for r, c in ((0, 0), (16, 8), (5, 27), (32, 32)):
        found = approve_driveline(moved(TRUCK, at(told, r, c)))
        mine = [k for k in found.checks if k.quantity in IMMEDIATE_QUANTITIES]
        verdict, name = shown(told, r, c)
        assert verdict == worst_verdict([k.grade for k in mine])
        least = min(k.margin for k in mine if k.grade == verdict)
        # Edits are written to 0.01 mm and 0.001 deg.
        assert told["margins"][r][c] == pytest.approx(least, abs=2e-3)
        assert name == Translator("en").name(next(k.quantity for k in mine if k.margin == least))


@pytest.mark.parametrize("name", ["held", "graded"])
def test_drag_does_not_solve_rubber_at_its_stop(monkeypatch, name):
    """It takes longer than all that follows a hand; values on rubber come when the hand rests."""

    def solve(*_: object) -> None:
        message = "solved"
        raise AssertionError(message)

    monkeypatch.setattr(MountLoads, "stop_response_on", solve)
    assert job(name)
    with pytest.raises(AssertionError, match="solved"):
        job("full")


@pytest.mark.slow
def test_map_cell_with_bearing_force_search_has_full_verdict(monkeypatch):
    """On linear rubber: a map is a batch, of which a stop is not solved."""
    monkeypatch.setattr(MountLoads, "stop_response", None)
    monkeypatch.setattr(MountLoads, "stuck_forces", None)
    text = (ROOT / "examples" / "tandem-6x4.yaml").read_text("utf-8")
    parts = []
    told = job("map", text=text, parts=parts, x="bearing_height 1", y="shim 1", sought=True)
    assert [len(p["map"]["verdicts"]) for p in parts if "map" in p] == [4, 7]
    for r, c in ((0, 12), (6, 6)):
        found = approve_driveline(moved(text, at(told, r, c)))
        assert VERDICTS[told["verdicts"][r][c]] == found.verdict
        bad = [k.margin for k in found.checks if k.grade == found.verdict]
        assert told["margins"][r][c] == pytest.approx(min(bad), abs=5e-3)


def test_missing_required_quantity_makes_map_and_yield_incomplete():
    """Required of the bracket, which nobody gave; and of a joint without a rating."""
    bracket = "{quantity: bracket_stress_utilisation, maximum: 1, required: true, source: us}"
    life = "{quantity: joint_life, unit: h, maximum: 9, sense: '>=', required: true, source: us}"
    for row, says in ((bracket, "Bracket"), (life, "life")):
        limits = f"limits: {{profile: protractor, overrides: [{row}]}}"
        text = CHAIN.replace("limits: protractor", limits)
        assert approve_application(reader.loads(text)).verdict == "incomplete"
        told = job("map", text=text, x="bearing_height 1", y="shim 1")
        assert shown(told, 16, 16)[0] == "incomplete"
        assert says.lower() in shown(told, 16, 16)[1].lower()
        sigmas = [{"id": "shim 1", "amount": "0.01"}]
        told = job("yield", text=text, sigmas=sigmas, count=128)
        assert told["shares"]["incomplete"][0] == 1
        assert told["yield"][0] == 0
        assert says.lower() in told["lost"][0]["name"].lower()


@pytest.mark.slow
def test_failed_second_driveline_fails_map_and_yield():
    """The moves are of the main line alone."""
    text = (ROOT / "examples" / "tandem-6x4.yaml").read_text("utf-8")
    _, second = (i.line.name for i in reader.loads(text).lines)
    sigmas = [{"id": "shim 1", "amount": "0.01"}]
    told = job("yield", text=text, sigmas=sigmas, count=64)
    assert told["shares"]["warn"][0] == 1
    bad = live(text, {f"drivelines.{second}.gearbox_slope.side_deg": 30})["text"]
    told = job("map", text=bad, x="bearing_height 1", y="shim 1")
    assert np.unique(told["verdicts"]).tolist() == [VERDICTS.index("fail")]
    assert shown(told, 16, 16)[1].startswith(f"{second}, ")
    told = job("yield", text=bad, sigmas=sigmas, count=64)
    assert told["yield"][0] == 0
    assert told["lost"][0]["name"].startswith(f"{second}, ")


@pytest.mark.slow
def test_infeasible_map_cell_shows_reason():
    reach = "adjust: {bearing_height_mm: [-1000, 1000], shim_deg: [-80, 80]}"
    text = CHAIN.replace("limits:", f"{reach}\nlimits:")
    told = job("map", text=text, x="bearing_height 1", y="shim 1", lang="it")
    for r, c in ((0, 32), (32, 0)):
        verdict, why = shown(told, r, c)
        assert verdict == "fail"
        assert why.startswith("non si può costruire: ")
        assert told["margins"][r][c] is None
    assert shown(told, 0, 32)[1] != shown(told, 32, 0)[1]  # each its own angle
    assert not shown(told, 16, 16)[1].startswith("non si")
    sigmas = [{"id": "bearing_height 1", "amount": "500"}, {"id": "shim 1", "amount": "40"}]
    told = job("yield", text=text, sigmas=sigmas, count=256)
    none = next(row["share"] for row in told["lost"] if row["name"] == "cannot be built")
    assert 0 < none < told["shares"]["fail"][0]
    assert np.sum(told["cases"]) == 256


def test_coarse_map_cells_match_fine_map():
    parts = []
    told = job("map", text=CHAIN, parts=parts, x="bearing_height 1", y="shim 1")
    coarse = next(p["map"] for p in parts if "map" in p)
    assert coarse["x"]["values"] == told["x"]["values"][::4]
    for key in ("margins", "verdicts", "decides"):
        assert coarse[key] == [row[::4] for row in told[key][::4]]


@pytest.mark.long
def test_map_axes_use_adjustment_range_and_unit():
    told = job("map", text=TRUCK, x="bearing_height 2", y="phase 3")
    assert (told["x"]["values"][0], told["x"]["values"][-1]) == (-10, 30)
    assert (told["y"]["values"][0], told["y"]["values"][-1], told["y"]["unit"]) == (0, 90, "deg")
    assert np.ptp(told["verdicts"]) or np.ptp(np.array(told["margins"], dtype=float)) > 0


@pytest.mark.slow
def test_yield_interval_narrows_as_variants_are_evaluated():
    parts = []
    sigmas = [{"id": "bearing_height 1", "amount": "3.0"}, {"id": "shim 1", "amount": "0.5"}]
    told = job("yield", text=CHAIN, parts=parts, sigmas=sigmas, count=1024)
    wide = [p["yield"]["yield"][2] - p["yield"]["yield"][1] for p in parts]
    assert told["count"] == 1024 == parts[-1]["done"]
    assert wide[-1] < wide[0]
    assert np.sum(told["cases"]) == 1024
    assert sum(v[0] for v in told["shares"].values()) == pytest.approx(1, abs=2e-4)
    # The same by single checks of cases drawn by another generator.
    rng = np.random.default_rng(5)
    good, count = 0, 60
    for high, turn in rng.normal(0, (3.0, 0.5), (count, 2)):
        moves = [{"id": "bearing_height 1", "amount": high}, {"id": "shim 1", "amount": turn}]
        good += approve_application(moved(CHAIN, moves)).verdict in ("pass", "warn")
    expected = told["yield"][0]
    spread = 4 * np.sqrt(max(expected * (1 - expected), 0.25 / count) / count)  # four sigma
    assert good / count == pytest.approx(expected, abs=spread)


def test_yield_of_0_or_100_percent_has_clopper_pearson_interval():
    """Clopper and Pearson's interval by hand: 1 - (α/2)^(1/n) where none of n was seen."""
    sigmas = [{"id": "shim 1", "amount": "1e-6"}]
    told = job("yield", text=CHAIN, sigmas=sigmas, count=100)
    assert told["count"] == 100
    assert told["yield"] == pytest.approx([1, 0.025**0.01, 1], abs=1e-4)
    assert told["shares"]["fail"] == pytest.approx([0, 0, 1 - 0.025**0.01], abs=1e-4)


def test_yield_and_interval_match_variant_study():
    """One of 256 trucks had two intervals: Wilson's here, Clopper and Pearson's there."""
    sigmas = [{"id": "bearing_height 1", "amount": "8.0"}, {"id": "shim 1", "amount": "1.0"}]
    told = job("yield", text=CHAIN, sigmas=sigmas, count=256, sought=True)
    spread = {"bearing_height_mm[1]": {"normal": 8.0}, "shim_deg": {"normal": 1.0}}
    found = cardan.study(reader.loads(CHAIN), tolerances=spread, n=256)
    assert 0 < found.yield_ < 1
    assert told["yield"] == pytest.approx([found.yield_, *found.interval()], abs=6e-5)


# ------------------------------------------------------------------ the library


@pytest.mark.slow
def test_library_status_matches_check_of_each_file(tmp_path):
    day = 'campaign: "A day"  # of two\nrecordings: [{file: a.csv}]\n'
    strong = f"{day}gauges: [S1]\nstrength: {{amplitude_MPa: 30, cycles: 2e6, slope: 5}}\n"
    texts = (("a.yaml", CHAIN), ("b.yaml", "title: ["), ("c.yaml", TRUCK), ("d.yaml", day),
             ("e.yaml", strong))  # fmt: skip
    for name, text in texts:
        (tmp_path / name).write_text(text, "utf-8")
    with running(tmp_path, tmp_path / "drafts") as house, page(house) as one:
        one.hello()
        one.say("keep", file=0, text=CHAIN.replace("2800", "1400"), mark="x")
        one.hear("kept")
        one.say("job", id=1, job="library", text="", args={})
        first, second, third, fourth, fifth = one.hear("done")["rows"]
        # A campaign is no application that broke; what is wrong in one is said.
        assert [(r["title"], r["verdict"]) for r in (fourth, fifth)] == [("A day", None)] * 2
        assert fourth["why"].startswith("d.yaml:1:1: strength is missing")
        assert fifth["why"] == "1 recording"
        assert (first["verdict"], first["draft"]) == ("pass", True)  # what is not saved counts
        assert (second["title"], second["verdict"]) == ("", None)
        assert second["why"]
        assert third["verdict"] == approve_application(reader.loads(TRUCK)).verdict
        assert third["worst"]["name"]
        one.say("job", id=2, job="compare", text="", file=0, args={"files": [2]})
        told = one.hear("done")
        assert [v["name"] for v in told["variants"]] == ["a.yaml", "c.yaml"]
        one.say("job", id=3, job="library", text="", args={"texts": []})
        with pytest.raises(ConnectionClosed):
            one.hear("done")


@pytest.mark.parametrize("lang", select(["en", "pt", "it"], "pt"))
@pytest.mark.parametrize("kind", select(["html", "json", "xlsx"], "json", "xlsx"))
def test_report_job_matches_command_line_report(kind, lang):
    question = {"job": "report", "text": CHAIN, "name": "x.yaml", "folder": None, "lang": "en"}
    told = handle_request({**question, "args": {"kind": kind, "lang": lang}})
    data = b64decode(told["data"])
    assert told["name"] == f"x.{lang}.{kind}"
    if kind == "json":
        assert json.loads(data)["verdict"] == approve_application(reader.loads(CHAIN)).verdict
    elif kind == "html":
        assert b"Three-joint chain" in data
        assert f'lang="{ {"pt": "pt-BR"}.get(lang, lang) }"'.encode() in data
    else:
        assert data.startswith(b"PK")


def test_released_revision_is_not_overwritten(tmp_path):
    (tmp_path / "a.yaml").write_text(CHAIN, "utf-8")
    (tmp_path / "revisions").mkdir()
    (tmp_path / "revisions" / "a.1.yaml").write_text("# frozen 2020-01-01: Z\nold\n", "utf-8")
    with running(tmp_path, tmp_path / "drafts") as house, page(house) as one:
        one.hello()
        assert [r["text"] for r in one.open()["revisions"]] == ["old\n"]
        one.say("freeze", file=0, text=CHAIN, by="Q\n# x: y", note="")
        told = one.hear("frozen")["revisions"]
        assert [r["name"] for r in told] == ["2", "1"]
        assert told[0]["text"] == CHAIN
        assert "\n" not in told[0]["said"]
        # Signed with a mark that turns what follows it: nobody could read that revision.
        one.say("freeze", file=0, text=CHAIN, by="A. Silva \u202e", note="\u200b")
        assert one.hear("frozen")["revisions"][0]["said"].endswith(": A. Silva")
        assert reader.read(tmp_path / "revisions" / "a.3.yaml").title
        assert (tmp_path / "revisions" / "a.1.yaml").read_text("utf-8").endswith("old\n")
        assert one.hello()["files"] == ["a.yaml"]


COUNTS = "({} exceeded, {} beyond recommended, {} met"


@pytest.mark.slow
def test_generated_script_reproduces_edits(tmp_path):
    """Run as anybody would: it comes to what the page shows."""
    (tmp_path / "truck.yaml").write_text(TRUCK, "utf-8")
    now = live(TRUCK, {"driveline.points_mm[3][3]": -90.5, "driveline.shafts[2].phase_deg": 15})
    question = {"job": "script", "text": now["text"], "name": "truck.yaml", "folder": None}
    told = handle_request({**question, "lang": "en", "args": {"saved": TRUCK}})
    assert told["other"] == []
    done = subprocess.run(
        [sys.executable, "-c", told["script"]], cwd=tmp_path, capture_output=True, text=True,
        check=True, timeout=PATIENCE,
    )  # fmt: skip
    after = reader.loads(now["text"])
    counts = [
        sum(c.grade == g for c in approve_driveline(after).checks) for g in ("fail", "warn", "pass")
    ]
    assert COUNTS.format(*counts) in " ".join(done.stdout.split())
    swapped = live(TRUCK, {"driveline.shafts[2].tube": "100x3"})["text"]
    told = handle_request({**question, "text": swapped, "lang": "en", "args": {"saved": TRUCK}})
    assert told["other"] == ["driveline.shafts[2].tube"]
    assert "change" not in told["script"]
    for command in told["commands"]:
        assert command.startswith("cardan ")


@pytest.mark.slow
def test_generated_command_includes_unsaved_edits(tmp_path):
    """A shell says what the script says, of numbers the file has not got."""
    (tmp_path / "truck.yaml").write_text(TRUCK, "utf-8")
    now = live(TRUCK, {"driveline.points_mm[3][3]": -90.5, "driveline.shafts[2].phase_deg": 15})
    question = {"job": "script", "text": now["text"], "name": "truck.yaml", "folder": None}
    told = handle_request({**question, "lang": "en", "args": {"saved": TRUCK}})
    first, *rest = (shlex.split(c) for c in told["commands"])
    assert first == ["python", "-c", told["script"]]
    assert [r[:2] for r in rest] == [["cardan", "check"], ["cardan", "fix"], ["cardan", "serve"]]
    shell = subprocess.run(
        ["sh", "-c", told["commands"][0].replace("python", shlex.quote(sys.executable), 1)],
        cwd=tmp_path, capture_output=True, text=True, check=True, timeout=PATIENCE,
    ).stdout  # fmt: skip
    checks = approve_driveline(reader.loads(now["text"])).checks
    counts = [sum(c.grade == g for c in checks) for g in ("fail", "warn", "pass")]
    assert COUNTS.format(*counts) in " ".join(shell.split())


@pytest.mark.slow
@pytest.mark.long
def test_corrections_match_their_generated_command(tmp_path, monkeypatch):
    """With what is held: `cardan fix` alone had moved the bearing that was to stay."""
    (tmp_path / "a truck.yaml").write_text(TRUCK, "utf-8")
    question = {"text": TRUCK, "name": "a truck.yaml", "folder": None, "lang": "it"}
    held = {"line": 0, "hold": ["bearing_height 1"]}
    told = handle_request({**question, "job": "fix", "args": held})
    monkeypatch.chdir(tmp_path)
    _, *asked = shlex.split(told["command"])
    document = json.loads(CliRunner().invoke(cli, [*asked, "--quiet", "--json"]).stdout)
    assert len(document) == len(told["proposals"]) > 0
    for mine, theirs in zip(told["proposals"], document, strict=True):
        assert mine["verdict"] == theirs["verdict"]
        assert mine["cost"] == pytest.approx(theirs["cost"], abs=1e-4)
        assert mine["margin"] == pytest.approx(theirs["smallest_margin"], rel=1e-5)
        assert len(mine["moves"]) == len(theirs["moves"])
        assert ("bearing_height", 1) not in {(m["what"], m["part"]) for m in theirs["moves"]}


@pytest.mark.slow
@pytest.mark.parametrize("sought", [False, True])
def test_yield_matches_generated_command_and_script(tmp_path, sought):
    sigmas = [{"id": "bearing_height 1", "amount": "8.0"}, {"id": "shim 1", "amount": "1.0"}]
    told = job("yield", CHAIN, sigmas=sigmas, count=256, sought=sought)
    (tmp_path / "x.yaml").write_text(CHAIN, "utf-8")
    low, high = (f"{100 * share:.2f} %" for share in told["yield"][1:])
    assert 0 < told["yield"][0] < 1
    command, script = told["commands"]
    for told_by in (
        ["sh", "-c", f'cardan() {{ {shlex.quote(sys.executable)} -m cardan "$@"; }}\n{command}'],
        [sys.executable, "-c", script],
    ):
        done = subprocess.run(
            told_by, cwd=tmp_path, capture_output=True, text=True, check=True, timeout=PATIENCE
        )
        assert f"{low} to {high}" in done.stdout


@pytest.mark.slow
def test_map_matches_generated_command_and_script(tmp_path, monkeypatch):
    text = (ROOT / "examples/vecto-4x2.yaml").read_text("utf-8")
    told = job("map", text=text, x="bearing_height 1", y="shim 1")
    monkeypatch.chdir(tmp_path)
    Path("x.yaml").write_text(text, "utf-8")
    counts = np.bincount(np.ravel(told["verdicts"]), minlength=4)
    command, script = told["commands"]
    put, asked, _, called = command.split("\n")
    Path(shlex.split(put)[2]).write_text(asked, "utf-8")
    _, *options = shlex.split(called)
    document = json.loads(CliRunner().invoke(cli, [*options, "--quiet", "--json"]).stdout)
    shares = [document["shares"][v] for v in ("pass", "warn", "incomplete", "fail")]
    assert 0 < counts[1] < counts.sum() == 33 * 33
    assert shares == pytest.approx(counts / counts.sum(), abs=1e-9)
    found = {}
    exec(script.replace("print(", "found['study'] = ("), {"found": found})
    assert found["study"].count == 33 * 33


@pytest.mark.slow
@pytest.mark.parametrize("line", ["x'$(touch pwned)`touch pwned`", "a\\nEND\\ntouch pwned", "-rf"])
def test_hostile_names_are_quoted_in_generated_study_command(tmp_path, line):
    name = "a'$(touch pwned) b.yaml"
    text = (ROOT / "examples/mtv-6x6.yaml").read_text("utf-8")
    (tmp_path / name).write_text(text := text.replace("\n  main: ", f'\n  "{line}": ', 1), "utf-8")
    question = {"job": "yield", "text": text, "name": name, "folder": None, "lang": "en"}
    args = {"line": 0, "sigmas": [{"id": "shim 1", "amount": "1.0"}], "count": 16}
    command, script = handle_request({**question, "args": args})["commands"]
    run = f'cardan() {{ {shlex.quote(sys.executable)} -m cardan "$@"; }}\n{command}'
    for told_by in (["sh", "-c", run], [sys.executable, "-c", script]):
        done = subprocess.run(
            told_by, cwd=tmp_path, capture_output=True, text=True, check=True, timeout=PATIENCE
        )
        assert "16 variants" in done.stdout
    beside = "a'$(touch pwned) b.yield.json"
    assert sorted(p.name for p in tmp_path.iterdir()) == sorted((name, beside))


def test_generated_command_evaluates_all_limits_if_one_is_incomplete():
    """Of named limits alone a study leaves nothing incomplete, and the page did."""
    bare = CHAIN.replace("tube: 100x3", "").replace("limits: protractor", "limits: heavy-truck")
    rubber = "_mm: 150, vertical_stiffness_N_mm: 150, lateral_stiffness_N_mm: 100}"
    bare = bare.replace("_mm: 150}", rubber)  # without tubes its peak, a search, is not evaluated
    assert rubber in bare
    told = job("yield", bare, sigmas=[{"id": "shim 1", "amount": "1.0"}], count=64)
    assert told["shares"]["incomplete"][0] + told["shares"]["fail"][0] == 1
    assert '"limits"' not in told["commands"][0]


def test_generated_fix_command_contains_hold_options():
    question = {"job": "script", "text": TRUCK, "name": "x.yaml", "folder": None, "lang": "pt"}
    held = {"saved": TRUCK, "line": 0, "hold": ["bearing_height 1", "phase 2"]}
    (fix,) = (c for c in handle_request({**question, "args": held})["commands"] if " fix " in c)
    assert shlex.split(fix) == [
        "cardan", "fix", "x.yaml", "--line=main", "--hold=bearing_height 1", "--hold=phase 2",
        "--lang=pt",
    ]  # fmt: skip


@pytest.mark.parametrize("name", ["a'$(touch x)`touch x`.yaml", "it's.yaml", "two words.yaml"])
def test_file_name_is_shell_quoted_in_generated_commands(name, tmp_path):
    """No name of a file is a command, and none an option."""
    question = {"job": "script", "text": TRUCK, "name": name, "folder": None, "lang": "en"}
    for command in handle_request({**question, "args": {"saved": TRUCK}})["commands"]:
        shell = subprocess.run(
            ["sh", "-c", f"cardan() {{ printf %s \"$2\"; }}\n{command}"],
            cwd=tmp_path, capture_output=True, text=True, check=True, timeout=PATIENCE,
        )  # fmt: skip
        assert shell.stdout == name
    assert not list(tmp_path.iterdir())
    for command in handle_request({**question, "name": "-h.yaml", "args": {"saved": TRUCK}})[
        "commands"
    ]:
        assert shlex.split(command)[2] == "./-h.yaml"


@pytest.mark.bracket
def test_bracket_job_reports_why_it_is_not_evaluated():
    """The page said AttributeError: a gauge beside the part, a STEP file cut short."""
    folder = ROOT / "examples" / "refuse-collector"
    text = (folder / "application.yaml").read_text("utf-8")
    question = {"job": "bracket", "name": "a.yaml", "folder": str(folder), "lang": "pt", "args": {}}
    off = text.replace("point_mm: [14, 65, 60]", "point_mm: [500, 65, 60]")
    assert off != text
    (problem,) = handle_request({**question, "text": off})["problems"]
    assert "o extensômetro S1 está a 468 mm da superfície" in problem["message"]
    assert problem["line"] == 1 + text[: text.index("\nbracket:") + 1].count("\n")


def test_invisible_characters_are_removed_from_deviation_signature():
    """A reason with a mark that turns writing round made a file that nobody could read."""
    args = {"which": 0, "normal": "900", "maximum": "1200"}
    signed = {"reason": "agreed \u202e here", "by": "A. Silva\u200b"}
    draft = job("deviate", CHAIN, **args, **signed)["draft"]
    assert any("agreed   here" in str(one.source) for one in reader.loads(draft).limits)
    question = {"job": "deviate", "text": CHAIN, "name": "x", "folder": None, "lang": "en"}
    told = handle_request({**question, "args": {**args, "reason": "\u200b", "by": "\u202e"}})
    assert {p["key"] for p in told["problems"]} == {"reason", "by"}
    told = handle_request({**question, "args": {**args, **signed, "normal": "1,200"}})
    assert "decimals or thousands?" in told["problems"][0]["message"]
