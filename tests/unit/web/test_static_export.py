"""A page by itself: what was computed beforehand, in one file that asks nobody."""

import json
import re
from base64 import b64encode
from hashlib import sha256

import pytest
from click.testing import CliRunner
from repository import ROOT

from cardan.application import reader
from cardan.approval.approval import approve_application
from cardan.cli import cli
from cardan.core.errors import InvalidFileError, MissingDependencyError
from cardan.render.i18n import LANGUAGE_CODES, Translator
from cardan.web import static_export as live

EXAMPLES = sorted((ROOT / "examples").glob("*.yaml"))
TRUCK = next(p for p in EXAMPLES if p.stem.startswith("refuse"))


@pytest.fixture
def built(monkeypatch):
    """The page in place of the built one: what is asked is what stands around it."""
    monkeypatch.setattr(
        live, "_style_and_script", lambda: ("p{color:red}", "let a = '<\\/script>'")
    )


def kept(page):
    found = re.search(r'<script type="application/json" id="live">(.*?)</script>', page, re.DOTALL)
    return json.loads(found[1])


@pytest.mark.slow
@pytest.mark.parametrize("path", EXAMPLES, ids=lambda p: p.stem)
@pytest.mark.usefixtures("built")
def test_exported_page_contains_verdict_and_every_load_state(path):
    text = path.read_text("utf-8")
    page = live.standalone_page(text, name=path.name, folder=str(path.parent), say=Translator("it"))
    told, found = kept(page), approve_application(reader.loads(text))
    assert told["full"]["verdict"] == found.verdict
    assert len(told["lines"]) == len(found.line_responses)
    for line in told["lines"]:
        assert [p["state"] for p in line["states"]] == list(range(len(told["live"]["states"])))
        heights = [p["travel"] for p in line["travel"]]
        assert heights == sorted(heights)
        assert len(heights) in (0, live.AXLE_TRAVEL_POSITION_COUNT)
        assert {tuple(p["torque_reach"]) for p in (*line["states"], *line["travel"])} == {(0, 0)}
        # Wherever a click on a limit leads there is a place to show.
        at = {(w["state"], w["torque_Nm"], w["way"]) for w in line["wound"]}
        name = told["live"]["lines"][told["lines"].index(line)]["name"]
        every = [m for m in told["live"]["limits"] if m["line"] == name]
        spots = [(s, spot) for m in every for s, of in enumerate(m.get("spots", [])) for spot in of]
        assert at == {(s, spot["torque_Nm"], spot["way"]) for s, spot in spots if spot}
        assert all("at" in w["pose"] for w in line["wound"])
    assert told["live"]["handles"] == []
    assert len(page.encode()) < 300_000  # what is left of 1.2 MB beside the page itself


@pytest.mark.slow
@pytest.mark.usefixtures("built")
def test_exported_page_policy_lists_its_scripts_and_names_are_escaped():
    name = '</script><script>alert(1)</script>" onload="x'
    text = TRUCK.read_text("utf-8").replace("Refuse collector 6x2, three shafts", json.dumps(name))
    page = live.standalone_page(text, name="x.yaml", folder=None, say=Translator("en"))
    assert kept(page)["live"]["title"] == name
    assert page.count("<script") == page.count("</script>") == 2
    policy = re.search(r'content="(default-src[^"]*)"', page)[1]
    for element in ("script", "style"):
        inside = re.search(rf"<{element}>(.*?)</{element}>", page, re.DOTALL)[1]
        digest = b64encode(sha256(inside.encode()).digest()).decode()
        assert f"{element}-src 'sha256-{digest}'" in policy
    assert "unsafe" not in policy
    assert not re.search(r"(src|href)=|https?:", page.split('id="live"')[0])


@pytest.mark.slow
@pytest.mark.usefixtures("built")
def test_check_command_writes_exported_page(tmp_path):
    out = tmp_path / "out.html"
    for code in LANGUAGE_CODES:
        done = CliRunner().invoke(
            cli, ["check", str(TRUCK), "-q", "--live", str(out), "--lang", code]
        )
        assert done.exit_code == 1
        assert kept(out.read_text("utf-8"))["welcome"]["lang"] == code
    many = CliRunner().invoke(cli, ["check", *map(str, EXAMPLES[:2]), "--live", str(out)])
    assert many.exit_code == 2
    mine = tmp_path / "mine.yaml"
    mine.write_text(TRUCK.read_text("utf-8"), "utf-8")
    over = CliRunner().invoke(cli, ["check", str(mine), "--live", str(mine)])
    assert over.exit_code == 2
    assert mine.read_text("utf-8") == TRUCK.read_text("utf-8")


def test_export_without_built_frontend_is_reported(monkeypatch, tmp_path):
    monkeypatch.setattr("cardan.web.static_export.resources.files", lambda _: tmp_path)
    with pytest.raises(MissingDependencyError, match="make serve"):
        live.standalone_page(TRUCK.read_text("utf-8"), name="x", folder=None, say=Translator("en"))


@pytest.mark.usefixtures("built")
def test_export_of_invalid_yaml_is_rejected():
    with pytest.raises(InvalidFileError):
        live.standalone_page("title: [", name="x", folder=None, say=Translator("en"))
