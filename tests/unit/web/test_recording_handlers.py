"""A recording brought to the workbench: how it comes, what it holds, what it did."""

import errno
import json
import os
import subprocess
import sys
from base64 import b64decode
from pathlib import Path

import numpy as np
import pytest
from message_schema import wrong
from recording_upload import bring
from repository import ROOT
from websockets.exceptions import ConnectionClosed
from workbench import PATIENCE, page, running

import cardan
from cardan.core.errors import CardanError
from cardan.core.units import MPa
from cardan.physics.signals.recording import Channel
from cardan.physics.signals.synthetic import GaugeStressPerCause, synthetic_recording
from cardan.render.i18n import Translator
from cardan.topics.recording import json_presentation as life
from cardan.topics.recording.campaign_study import analyse_campaign
from cardan.topics.recording.options import AnalysisOptions
from cardan.topics.recording.study import analyse_recording
from cardan.web import recording_handlers as heard
from cardan.web import upload as parcel
from cardan.web.handlers import handle_request

TRUCK = (ROOT / "examples" / "three-joint-chain.yaml").read_text("utf-8")
GUILTY = GaugeStressPerCause(joints=40 * MPa, events=25 * MPa, road=4 * MPa)
CAMPAIGN = {"gauges": ["S1", "S2"], "sn": "80,2e6,5", "speed": "shaft_speed", "torque": "torque"}
CURVE = {"amplitude": "80", "cycles": "2e6", "slope": "5"}
ASKED = {k: v for k, v in CAMPAIGN.items() if k != "sn"} | CURVE
"""The same, as it is typed in the page."""


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    """Return the path of a recording: S1 shaken by its joints, S2 not; two spikes in S2."""
    made = synthetic_recording(
        seconds=90, rate=400, seed=6,
        gains={"S1": GUILTY, "S2": GaugeStressPerCause(joints=0.2 * MPa)},
    ).recording  # fmt: skip
    data = made.read_all()
    data[1, 8000:8003] += 400
    data[1, 20000:20002] -= 300
    head = ",".join(("time_s", *(f"{c.name} [{c.unit}]" for c in made.channels)))
    path = tmp_path_factory.mktemp("run") / "run.csv"
    rows = np.vstack([np.arange(data.shape[1]) / made.rate, data]).T
    np.savetxt(path, rows, delimiter=",", header=head, comments="", fmt="%.6g")
    return path


@pytest.fixture(scope="module")
def house(tmp_path_factory):
    folder = tmp_path_factory.mktemp("desk")
    (folder / "truck.yaml").write_text(TRUCK, "utf-8")
    with running(folder / "truck.yaml", folder / "drafts") as found:
        yield found


def job(name, path, lang="en", **args):
    args |= {"recording": {"path": str(path), "name": path.name}}
    question = {"job": name, "text": "", "name": "x.yaml", "folder": None, "lang": lang}
    parts = []
    found = handle_request({**question, "args": args}, parts.append)
    assert "problems" not in found, found
    assert parts
    return found


def kept(folder):
    return [p for p in folder.rglob("*") if p.is_file()]


# ------------------------------------------------------------------ how it comes


@pytest.mark.slow
def test_uploaded_recording_is_surveyed_and_deleted_with_its_page(
    house, run, tmp_path, monkeypatch
):
    monkeypatch.setattr(parcel.tempfile, "tempdir", str(tmp_path))
    with page(house) as one:
        one.hello()
        one.open()
        told = bring(one, run, name="C:\\data\\..\\<b>run\u202e.csv")
        assert (told["id"], told["got"]) == (5, run.stat().st_size)
        (file,) = kept(tmp_path)
        assert file.read_bytes() == run.read_bytes()
        assert file.name == "recording.csv"
        assert os.name == "nt" or file.parent.stat().st_mode & 0o077 == 0
        one.say("job", id=6, job="recording", text="", args={})
        told = one.hear("done")
        assert [c["name"] for c in told["channels"]][:2] == ["S1", "S2"]
        assert told["name"].startswith("<b>run")
        assert "\u202e" not in told["name"]
        assert str(tmp_path) not in json.dumps(told)
        one.say("job", id=7, job="life", text="", args=ASKED)
        one.hear("part")
        one.say("cancel", id=7)
        assert one.hear("done")["fault"] == "cancelled"
        bring(one, run)  # in place of the first
        assert len(kept(tmp_path)) == 1
    with page(house) as one:  # the server has noticed that the other page went
        one.hello()
        one.say("job", id=1, job="recording", text="", args={})
        assert one.hear("done")["fault"] == "nothing brought"
    assert kept(tmp_path) == []


@pytest.mark.parametrize(
    ("name", "size", "why"),
    [
        ("run.exe", 10, "no reader for '.exe'"),
        ("/etc/passwd", 10, "no reader for ''"),
        ("run.csv", parcel.MAX_UPLOAD_BYTES + 1, "256 MB"),
        ("run.csv", 0, "run.csv is empty"),
    ],
)
def test_invalid_upload_is_rejected_with_reason(house, tmp_path, monkeypatch, name, size, why):
    monkeypatch.setattr(parcel.tempfile, "tempdir", str(tmp_path))
    with page(house) as one:
        one.hello()
        one.say("bring", id=1, name=name, size=size)
        assert why in one.hear("refused", "brought")["why"]
        assert kept(tmp_path) == []


def test_full_disk_is_reported_and_partial_upload_is_deleted(house, tmp_path, monkeypatch):
    """The socket was dropped, and everything the page held went with it, without a word."""

    def full(*_, **__):
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    monkeypatch.setattr(parcel.tempfile, "tempdir", str(tmp_path))
    with page(house) as one:
        one.hello()
        one.say("bring", id=1, name="run.csv", size=10)
        one.hear("brought")
        with monkeypatch.context() as crowded:
            crowded.setattr(Path, "open", full)
            one.say("piece", at=0, data="QUJD")
            assert "No space left" in one.hear("refused", "brought")["why"]
        assert kept(tmp_path) == []
        with monkeypatch.context() as crowded:
            crowded.setattr(parcel.tempfile, "mkdtemp", full)
            one.say("bring", id=2, name="run.csv", size=10)
            assert "No space left" in one.hear("refused", "brought")["why"]
        one.say("bring", id=3, name="run.csv", size=10)
        assert one.hear("refused", "brought")["got"] == 0


@pytest.mark.parametrize(
    "said",
    [
        {"at": 1, "data": "QUJD"},
        {"at": 0, "data": "QUJDREVGR0hJSktM"},  # more than was said
        {"at": 0, "data": "not base64!"},
        {"at": 0, "data": ""},
        {"at": 0},
        {"at": 0, "data": "QUJD", "before": None},  # nothing was begun
    ],
)
def test_malformed_upload_chunk_closes_connection(house, said):
    with page(house) as one:
        one.hello()
        if "before" not in said:
            one.say("bring", id=1, name="run.csv", size=10)
            one.hear("brought")
        one.say("piece", **said)
        with pytest.raises(ConnectionClosed):
            one.hear("brought")


@pytest.mark.parametrize(
    "args", [{"recording": {"path": "/etc/passwd"}}, {"path": "x"}, {"gauges": "S1"}, {"mask": [1]}]
)
def test_recording_path_from_page_is_rejected(house, args):
    with page(house) as one:
        one.hello()
        one.say("job", id=1, job="life", text="", args=args)
        with pytest.raises(ConnectionClosed):
            one.hear("done")


# ------------------------------------------------------------------ what it holds


@pytest.mark.slow
def test_channel_survey_lists_range_and_suspected_faults(run):
    told = job("recording", run, lang="it")
    assert wrong("Heard", told) == []
    assert told["seconds"] == pytest.approx(90)
    assert told["rate"] == 400
    roles = {c["name"]: c["role"] for c in told["channels"]}
    assert roles["S1"] == roles["S2"] == "gauge"
    assert (roles["shaft_speed"], roles["torque"], roles["tacho"]) == ("speed", "torque", "tacho")
    data = np.loadtxt(run, delimiter=",", skiprows=1)[:, 2]
    second = told["channels"][1]
    assert min(second["lowest"]) == pytest.approx(data.min(), rel=1e-4)
    assert max(second["highest"]) == pytest.approx(data.max(), rel=1e-4)
    # Each stretch of 90 samples has the smallest and largest of its own.
    each = data.reshape(len(second["highest"]), -1)
    assert second["highest"] == pytest.approx(each.max(axis=1), abs=1e-3)
    assert second["lowest"] == pytest.approx(each.min(axis=1), abs=1e-3)
    (spikes,) = [s for s in second["suspects"] if s["kind"] == "spike"]
    assert spikes["count"] == 2
    assert [round(a, 1) for a, _ in spikes["places"]] == [20.0, 50.0]
    assert spikes["mask"]
    assert spikes["said"].startswith("picco")


# ------------------------------------------------------------------ what it did


@pytest.mark.slow
def test_life_job_matches_life_command(run):
    told = job("life", run, **ASKED, hours="10")
    assert wrong("Lived", told) == []
    found = analyse_recording(
        run, AnalysisOptions.from_values(**CAMPAIGN, target_hours=10.0), draw=True
    )
    heard = found.answer
    assert [c["gauge"] for c in told["causes"]] == ["S1", "S2"]
    for mine, theirs in zip(told["causes"], heard.causes.joint_attributions, strict=True):
        assert (mine["low"], mine["high"]) == pytest.approx(theirs.interval, abs=1e-4)
        assert mine["removed"] == pytest.approx(theirs.damage_share, abs=1e-4)
        assert mine["finding"] == theirs.verdict
    assert sum(s["share"] for s in told["causes"][0]["shares"]) == pytest.approx(1, abs=1e-2)
    first = heard.figures.order_maps[0]
    drawn = np.array(told["orders"][0]["MPa"], dtype=float)
    assert drawn == pytest.approx(first.amplitude.T / MPa, abs=1e-3, nan_ok=True)
    assert drawn.shape == (len(told["orders"][0]["rpm"]) - 1, len(told["orders"][0]["order"]) - 1)
    # The joints' order stands out of its neighbours.
    order = np.array(told["orders"][0]["order"])
    k = int(np.searchsorted(order, 2.0, side="right")) - 1
    mean = np.nanmean(drawn, axis=0)
    assert k in np.argsort(mean)[-4:]
    tables = [b for c in told["chapters"] for b in c["blocks"] if b["kind"] == "table"]
    assert any(row[0] == "S1" for b in tables for row in b["rows"])
    # What the report's first page draws of the gauge that governs.
    first = told["chapters"][0]
    titles = [b["title"] for b in first["blocks"]]
    assert first["title"] == "Life and cause"
    assert [b["kind"] for b in first["blocks"]] == ["figure"] * 4
    for drawn, what in zip(
        titles,
        ("stress over time", "Rainflow matrix", "S-N curve", "share of the damage"),
        strict=True,
    ):
        assert what.lower() in drawn.lower()
    assert all(b["svg"].startswith("<svg") for b in first["blocks"])


@pytest.mark.slow
def test_masks_and_time_limits_change_damage(run):
    mine = {"gauges": ["S2"], **CURVE}

    def damage(**more):
        told = job("life", run, **mine, **more)
        rows = [b["rows"] for c in told["chapters"] for b in c["blocks"] if b["kind"] == "table"]
        return next(row for row in rows if row[0][0] == "S2")[0]

    as_is, masked = damage(), damage(mask=["S2=spike"])
    assert as_is[4] == "data rejected"
    assert masked[4] != "data rejected"
    assert float(masked[3]) < 0.5 * float(as_is[3])
    assert damage(accept=["S2=spike"])[3] == as_is[3]
    cut = damage(first="21", last="49,5")  # between the spikes
    assert cut[4] != "data rejected"
    for wrong_, why in (({"first": "x"}, "from [s]: is no number"), ({"gauges": ["S9"]}, "S9"),
                        ({"first": "800"}, "nothing behind 800 s: it ends at 90 s")):  # fmt: skip
        question = {"job": "life", "text": "", "name": "x", "folder": None, "lang": "en"}
        args = mine | wrong_ | {"recording": {"path": str(run), "name": "run.csv"}}
        told = handle_request({**question, "args": args})
        assert why in told["problems"][0]["message"]
        assert str(run.parent) not in told["problems"][0]["message"]


@pytest.mark.slow
@pytest.mark.parametrize(
    ("lang", "typed", "hours"),
    [("en", "10 000", 1e4), ("en", "1e4", 1e4), ("pt", "10 000", 1e4), ("en", "10.000", 10.0),
     ("it", "12,5", 12.5), ("en", "10,000", "decimals or thousands? write 10.000 or 10000"),
     ("pt", "10.000", "decimais ou milhares? escreva 10,000 ou 10000"),
     ("en", "10000 h", "hours to live: is no number"), ("en", "abc", "is no number"),
     ("en", "0", "above 0"), ("en", "1e13", "at most 1e+12")],
)  # fmt: skip
def test_localised_target_hours_are_parsed_or_rejected(run, lang, typed, hours):
    """`10 000` hours were not asked at all, `10.000` of a page in Portuguese were ten."""
    question = {"job": "life", "text": "", "name": "x", "folder": None, "lang": lang}
    args = {**ASKED, "hours": typed, "recording": {"path": str(run), "name": "run.csv"}}
    told = handle_request({**question, "args": args})
    if isinstance(hours, str):
        assert hours in told["problems"][0]["message"]
        return
    rows = told["chapters"][1]["blocks"][0]["rows"]
    (bound,) = {row[4].removeprefix("≥ ") for row in rows}
    assert bound == Translator(lang).number(hours)


@pytest.mark.slow
def test_drift_can_be_accepted_or_removed(tmp_path):
    """The answer said that a word on it is needed, and there was none to choose."""
    rng = np.random.default_rng(3)
    t = np.arange(20_000) / 200
    creeps = 20 * rng.standard_normal(t.size) + 400 * (t / t[-1]) ** 2
    path = tmp_path / "a.csv"
    np.savetxt(path, np.stack([t, creeps], -1), "%.7g", delimiter=",", header="time_s,S1 [MPa]",
               comments="")  # fmt: skip
    (channel,) = job("recording", path)["channels"]
    (drift,) = (s for s in channel["suspects"] if s["kind"] == "drift")
    assert not drift["mask"]

    def row(**more):
        told = job("life", path, gauges=["S1"], **CURVE, **more)
        tables = (b["rows"] for c in told["chapters"] for b in c["blocks"] if b["kind"] == "table")
        return next(row for rows in tables for row in rows if row[0] == "S1")

    assert row()[4] == "data rejected"
    (undecided,) = job("life", path, gauges=["S1"], **CURVE)["open"]
    assert undecided["rule"] == "S1=drift"
    assert job("life", path, gauges=["S1"], **CURVE, accept=["S1=drift"])["open"] == []
    assert row(accept=["S1=drift"])[4] != "data rejected"
    assert row(zero="drift")[4] != "data rejected"
    assert float(row(zero="drift")[3]) < float(row(accept=["S1=drift"])[3])


@pytest.mark.slow
def test_strain_is_converted_with_given_youngs_modulus(tmp_path):
    """206 GPa, unsaid: an aluminium part was off by thousands. Damage goes with E to the slope."""
    rng = np.random.default_rng(3)
    path = tmp_path / "a.csv"
    rows = np.stack([np.arange(20_000) / 200, 300 * rng.standard_normal(20_000)], -1)
    head = "time_s,S1 [um/m]"
    np.savetxt(path, rows, "%.7g", delimiter=",", header=head, comments="")

    def damage(**more):
        told = job("life", path, gauges=["S1"], **CURVE, accept=["S1=rate"], **more)
        tables = (b["rows"] for c in told["chapters"] for b in c["blocks"] if b["kind"] == "table")
        return float(next(row for rows in tables for row in rows if row[0] == "S1")[3])

    assert damage(modulus="206") == damage()
    assert damage() / damage(modulus="70") > (206 / 70) ** 5


@pytest.mark.parametrize(
    ("name", "unit", "role"),
    [("engine_mount_S1", "um/m", "gauge"), ("motor_torque", "Nm", ""), ("engine", "rpm", "engine"),
     ("motor", "", "engine"), ("tacho", "V", "tacho"), ("shaft", "rpm", "speed"),
     ("n", "", ""), ("S1", "mV/V", ""), ("axle", "g", "")],
)  # fmt: skip
def test_channel_role_is_guessed_by_unit_before_name(name, unit, role):
    """Strain on an engine's mount was an engine's speed, and no gauge."""
    assert heard._channel_role(Channel(name=name, unit=unit)) == role


def test_speed_channel_is_not_checked_for_drift_or_standstill(tmp_path):
    """A truck stands at a light, shifts and goes faster towards the end: that is driving."""
    rate, n = 100.0, 12_000
    t = np.arange(n) / rate
    speed = np.where(t < 60, 600.0, 600 + 15 * (t - 60))
    speed[2000:3500] = 0.0
    speed[7000:7050] = np.nan
    gauge = 20 * np.sin(2 * np.pi * 3 * t) + 5 * np.sin(2 * np.pi * 7.1 * t) + t
    gauge[2000:3500] = gauge[2000]
    head = "time_s,S1 [MPa],shaft [rpm],torque [kNm],mark"
    rows = np.stack([t, gauge, speed, speed / 500, gauge], -1)
    path = tmp_path / "a.csv"
    np.savetxt(path, rows, "%.7g", delimiter=",", header=head, comments="")
    path.write_text(path.read_text().replace("nan", ""))
    told = {c["name"]: c for c in job("recording", path)["channels"]}
    kinds = {name: {s["kind"] for s in c["suspects"]} for name, c in told.items()}
    assert (
        kinds["S1"] == kinds["mark"] == {"freeze", "drift"}
    )  # of what nobody knows it may be a gauge
    assert any("drifts" in s for s in told["S1"]["said"])
    for name in ("shaft", "torque"):
        assert kinds[name] == {"hole"}
        assert len(told[name]["said"]) == 1
        assert "missing" in told[name]["said"][0]


# ------------------------------------------------------------------ a campaign

CAMPAIGNED = """campaign: Two routes
recordings:
  - {file: run.csv, times: 3}
  - file: run.csv
    name: again
    segments: [{name: up, to_s: 30}, {name: down, from_s: 0.01, to_s: 0.03, times: 2}]
gauges: [S1, S2]  # both
strength: {amplitude_MPa: 80, cycles: 2e6, slope: 5}
speed: shaft_speed
torque: torque
axle_ratio: 3.5
tyre_radius_m: 0.5
target_hours: 10
"""


def of_campaign(name, text, folder, lang="en", **args):
    question = {"job": name, "text": text, "name": "c.yaml", "folder": str(folder), "lang": lang}
    return handle_request({**question, "args": args} | ({"edits": args} if name == "live" else {}))


def test_campaign_summary_lists_recordings_and_segments(run):
    found = of_campaign("live", CAMPAIGNED, run.parent, lang="it")["campaign"]
    assert wrong("Campaign", found) == []
    assert [d["name"] for d in found["drives"]] == ["run.csv", "again"]
    assert found["drives"][1]["more"] == ["up: 0 … 30 s × 1", "down: 0,01 … 0,03 s × 2"]
    assert ["ore da durare", "10"] in found["asked"]
    heard = of_campaign("drive", CAMPAIGNED, run.parent, drive=0)
    assert wrong("Heard", heard) == []
    roles = {c["name"]: c["role"] for c in heard["channels"]}
    assert roles == {"S1": "gauge", "S2": "gauge", "shaft_speed": "speed", "torque": "torque"}


def test_review_decision_is_written_into_campaign_file(run):
    """A rule joins the list of its own recording, which need not be there yet; all else stays."""
    told = of_campaign(
        "live", CAMPAIGNED, run.parent,
        **{"recordings[1].mask[+]": "S2=spike@49.9..50.1", "recordings[2].accept[+]": "S1=clip"},
    )  # fmt: skip
    text = told["text"]
    assert '{mask: ["S2=spike@49.9..50.1"], file: run.csv, times: 3}' in text
    assert '  - accept: ["S1=clip"]\n    file: run.csv\n' in text
    more = of_campaign("live", text, run.parent, **{"recordings[1].mask[+]": "S2=spike@19..21"})
    assert more["campaign"]["drives"][0]["mask"] == ["S2=spike@19..21", "S2=spike@49.9..50.1"]
    assert "gauges: [S1, S2]  # both" in more["text"]
    # Taken back, one by one: the list stays, if empty, and is no rule.
    at = "recordings[1].mask[-]"
    for rule in ("S2=spike@49.9..50.1", "S2=spike@19..21"):
        more = of_campaign("live", more["text"], run.parent, **{at: rule})
    assert more["campaign"]["drives"][0]["mask"] == []
    assert "{mask: [], file: run.csv, times: 3}" in more["text"]
    gone = of_campaign("live", more["text"], run.parent, **{at: "S2=spike"})
    assert gone["problems"][0]["key"] == "recordings[1].mask"


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["html", "json", "pdf"])
def test_campaign_report_matches_life_command(run, kind):
    text = CAMPAIGNED[: CAMPAIGNED.index("  - file")] + CAMPAIGNED[CAMPAIGNED.index("gauges") :]
    path = run.with_name("c.yaml")
    path.write_text(text, "utf-8")
    parts = []
    question = {"job": "report", "text": text, "name": "c.yaml", "folder": str(run.parent)}
    asked = {"args": {"kind": kind, "lang": "it"}, "lang": "en"}
    told = handle_request(question | asked, parts.append)
    data = b64decode(told["data"])
    assert told["name"] == f"c.it.{kind}"
    if kind == "json":
        theirs = json.loads(json.dumps(life.campaign_json_document(analyse_campaign(path))))
        assert json.loads(data)["gauges"] == theirs["gauges"]
    else:
        assert data.startswith(b"%PDF" if kind == "pdf" else b"<!doctype html>")
    # What is said meanwhile is what is done: nothing reads at 100 %.
    doing = [p["doing"] for p in parts]
    seen = [d.partition(":")[0] for d in doing]
    assert list(dict.fromkeys(seen))[:3] == [
        "lettura in corso", "conteggio dei cicli", "ricerca delle cause"
    ]  # fmt: skip
    assert not any("100" in d for d in doing)


@pytest.mark.slow
def test_campaigns_are_compared_and_reproduced_by_generated_script(run, monkeypatch):
    """What differs by its address, as it is written; the script asks as `cardan life` does."""
    text = CAMPAIGNED[: CAMPAIGNED.index("  - file")] + CAMPAIGNED[CAMPAIGNED.index("gauges") :]
    path = run.with_name("held.yaml")
    path.write_text(text, "utf-8")
    question = {"text": text, "name": path.name, "folder": str(run.parent), "lang": "pt"}
    edits = {"recordings[1].mask[+]": "S1=spike"}
    question["text"] = handle_request({**question, "job": "live", "edits": edits})["text"]
    args = {"variants": [{"name": "1", "text": text}]}
    told = handle_request({**question, "job": "compare", "args": args})
    assert [v["verdict"] for v in told["variants"]] == [None, None]
    assert told["differences"] == [{"name": "recordings[1].mask[1]", "values": ["S1=spike", "-"]}]
    told = handle_request({**question, "job": "script", "args": {"saved": text}})
    assert told["other"] == ["recordings[1].mask[1]"]
    assert told["commands"] == ["cardan life held.yaml --lang pt", "cardan serve held.yaml"]
    done = subprocess.run(
        [sys.executable, "-c", told["script"]], cwd=run.parent, capture_output=True, text=True,
        check=True, timeout=PATIENCE,
    )  # fmt: skip
    monkeypatch.chdir(run.parent)
    assert done.stdout.strip() == str(cardan.life(path.name)).strip()


@pytest.mark.slow
def test_campaign_variants_are_compared_with_their_computed_lives(run, tmp_path):
    """Of one that was not asked nothing is known; the other says what `cardan life` does."""
    text = CAMPAIGNED[: CAMPAIGNED.index("  - file")] + CAMPAIGNED[CAMPAIGNED.index("gauges") :]
    path = run.with_name("lives.yaml")
    path.write_text(text, "utf-8")
    other = text.replace("slope: 5", "slope: 4")
    with running(path, tmp_path / "drafts") as own, page(own) as one:
        one.hello()
        one.open()
        variants = {"variants": [{"name": "b", "text": other}]}
        one.say("job", id=2, job="compare", text=text, args=variants)
        assert one.hear("done")["effects"] == []
        one.say("job", id=3, job="campaign", text=text, args={})
        asked = one.hear("done")
        one.say("job", id=4, job="compare", text=text, args=variants)
        told = one.hear("done")
    assert wrong("Compared", {k: told[k] for k in ("variants", "differences", "effects")}) == []
    mix = analyse_campaign(path).answer
    for gauge in mix.lives:
        (row,) = [e for e in told["effects"] if e["name"] == f"{gauge.name}: hours to failure"]
        assert row["values"][1] == "-"
        if not gauge.vetoes:
            assert float(row["values"][0]) == pytest.approx(gauge.life.hours, rel=5e-4)
        assert row["values"][0] == asked["lives"][gauge.name]


def test_campaign_workbook_request_is_rejected(run):
    told = of_campaign("report", CAMPAIGNED, run.parent, kind="xlsx")
    assert told["problems"][0]["message"] == "a campaign has no workbook: take html, pdf or json"


@pytest.mark.slow
def test_campaign_life_matches_life_command(run):
    text = CAMPAIGNED.replace("from_s: 0.01, to_s: 0.03", "from_s: 30, to_s: 60")
    path = run.with_name("c.yaml")
    path.write_text(text, "utf-8")
    told, found = of_campaign("campaign", text, run.parent), analyse_campaign(path)
    assert wrong("Lived", told) == []
    mix = found.answer
    assert [c["gauge"] for c in told["causes"]] == ["S1", "S2"]
    for mine in told["causes"]:
        theirs = mix.evidence(mine["gauge"])
        assert mine["finding"] == theirs.verdict
        assert mine["removed"] == pytest.approx(theirs.damage_share, abs=1e-4)
        assert [mine["low"], mine["high"]] == pytest.approx(list(theirs.interval), abs=1e-4)
    titles = [c["title"] for c in told["chapters"]]
    assert titles == [
        "Life and cause", "Verdict", "The mix", "run.csv", "again, up", "again, down",
    ]  # fmt: skip
    table = told["chapters"][2]["blocks"][0]
    life = mix.lives[0].parts[0][0].life
    per_km = table["rows"][0][table["head"].index("per km")]
    assert float(per_km) == pytest.approx(life.damage / (life.distance / 1e3), rel=5e-3)
    assert [o["gauge"] for o in told["orders"]][:2] == ["run.csv: S1", "run.csv: S2"]


@pytest.mark.parametrize(
    ("was", "now"),
    [
        ("file: run.csv,", "file: ../run.csv,"),
        ("file: run.csv,", "file: /etc/passwd,"),
        ("times: 3}", "beside: [{file: ../x.csv}]}"),
        ("speed: shaft", "application: ../a.yaml\nspeed: shaft"),
        ("speed: shaft", "limits: ../mine.yaml\nspeed: shaft"),
    ],
)
def test_campaign_file_outside_folder_is_rejected(run, was, now):
    assert was in CAMPAIGNED
    text = CAMPAIGNED.replace(was, now)
    for job in ("live", "drive", "campaign"):
        told = of_campaign(job, text, run.parent)
        assert "lies outside the folder" in told["problems"][0]["message"], told
        assert told["problems"][0]["line"] > 1


def test_missing_campaign_file_is_reported_by_name(run):
    text = CAMPAIGNED.replace("file: run.csv,", "file: gone.csv,")
    assert "campaign" in of_campaign("live", text, run.parent)  # to be mended here
    told = of_campaign("drive", text, run.parent)
    assert told["problems"][0]["message"] == "gone.csv: no such file"
    told = of_campaign("drive", TRUCK, run.parent)
    assert told["problems"][0]["message"] == "c.yaml is no campaign of recordings"


BUS = """VERSION ""
BU_: ECU
BO_ 2364540158 EEC1: 8 ECU
 SG_ EngSpeed : 24|16@1+ (0.125,0) [0|8031.875] "rpm" ECU
"""


def bus_log(path):
    """Write a Vector ASC of an engine at 1000 to 1400 rpm, a frame each 10 ms."""
    head = "date Mon Nov 2 10:00:00.000 am 2026\nbase hex  timestamps absolute\n"
    codes = [8000 + 8 * k for k in range(400)]
    rows = [
        f"   {0.01 * k:.6f} 1  CF00400x       Rx   d 8 FF FF FF {code & 255:02X} {code >> 8:02X} "
        "FF FF FF"
        for k, code in enumerate(codes)
    ]
    path.write_text(head + "\n".join(rows) + "\n", encoding="ascii")
    return path


def test_can_database_brought_before_a_log_decodes_it(house, tmp_path, monkeypatch):
    """And goes with it: what is brought next has none."""
    server = tmp_path / "server"
    server.mkdir()
    monkeypatch.setattr(parcel.tempfile, "tempdir", str(server))
    log, database = bus_log(tmp_path / "bus.asc"), tmp_path / "bus.dbc"
    database.write_text(BUS, encoding="ascii")
    with page(house) as one:
        one.hello()
        one.open()
        assert bring(one, database)["got"] == database.stat().st_size
        one.say("job", id=1, job="recording", text="", args={})
        assert one.hear("done")["fault"] == "nothing brought"
        bring(one, log)
        assert sorted(p.name for p in kept(server)) == ["database-0.dbc", "recording.asc"]
        one.say("job", id=2, job="recording", text="", args={})
        told = one.hear("done")
        (speed,) = [c for c in told["channels"] if "EngSpeed" in c["name"]]
        assert (speed["role"], speed["unit"]) == ("engine", "rpm")
        assert (speed["low"], speed["high"]) == (1000, 1399)
        bring(one, log)
        assert [p.name for p in kept(server)] == ["recording.asc"]
        one.say("job", id=3, job="recording", text="", args={})
        assert "dbc" in json.dumps(one.hear("done")).lower()


def test_file_between_database_and_log_takes_the_database_away(tmp_path, monkeypatch):
    monkeypatch.setattr(parcel.tempfile, "tempdir", str(tmp_path))
    one = parcel.Upload()
    one.begin({"id": 1, "name": "a.dbc", "size": 3})
    one.append_chunk({"at": 0, "data": "YWJj"})
    assert one.complete_file is None
    with pytest.raises(CardanError, match="no reader"):
        one.begin({"id": 2, "name": "a.exe", "size": 3})
    one.close()
    one.begin({"id": 3, "name": "a.asc", "size": 3})
    one.append_chunk({"at": 0, "data": "YWJj"})
    assert one.complete_file is not None
    assert one.complete_file["databases"] == []
    for k in range(parcel.MAX_DATABASES):
        one.begin({"id": 4 + k, "name": "b.dbc", "size": 3})
        one.append_chunk({"at": 0, "data": "YWJj"})
    with pytest.raises(CardanError, match="at most"):
        one.begin({"id": 99, "name": "b.dbc", "size": 3})
    one.close()
    assert kept(tmp_path) == []
