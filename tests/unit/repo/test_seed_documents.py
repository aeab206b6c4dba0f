"""What the list of the seed documents names can be run, and says what the list says."""

import contextlib
import io
import shlex

import pytest
import yaml
from click.testing import CliRunner
from repository import ROOT

from cardan.cli import cli

LISTED = yaml.safe_load((ROOT / "docs/seeds.yaml").read_text(encoding="utf-8"))
ENTRIES = [entry for document in LISTED.values() for entry in document]
RUN = {e["run"]: e for e in ENTRIES if "run" in e}


def printed(run):
    """What a command or a piece of Python prints."""
    if run.startswith("cardan "):
        wide = CliRunner(env={"COLUMNS": "200"})  # names are not broken over lines
        result = wide.invoke(cli, shlex.split(run)[1:], catch_exceptions=False)
        assert result.exit_code in (0, 1), result.output
        return result.output
    said = io.StringIO()
    with contextlib.redirect_stdout(said):
        exec(compile(run, "<seeds>", "exec"), {})
    return said.getvalue()


@pytest.fixture(scope="module")
def told():
    """What each quick command prints, each once."""
    with contextlib.chdir(ROOT):
        return {run: printed(run) for run, e in RUN.items() if not e.get("slow")}


@pytest.mark.parametrize("entry", [pytest.param(e, id=e["item"]) for e in ENTRIES if e.get("says")])
def test_listed_command_prints_listed_result(entry, told):
    assert entry["says"] in told[entry["run"]]


def test_slow_entry_names_file_and_command():
    for entry in (e for e in ENTRIES if e.get("slow")):
        words = shlex.split(entry["run"])
        files = [w for w in words if w.endswith((".yaml", ".py"))]
        assert files
        assert all((ROOT / f).is_file() for f in files)
        if words[0] == "cardan":
            command = cli.get_command(None, words[1])
            assert command
            options = {o for p in command.params for o in p.opts}
            assert {w for w in words if w.startswith("--")} <= options


def test_every_item_of_source_documents_is_listed():
    """The dissertation's text has tables 1 to 4 and equations 1 to 14; the notes number six."""
    everything = "\n".join(e["item"] for e in ENTRIES)
    for k in range(1, 5):
        assert f"Table {k}" in everything
    for k in ("1", "2, 3", "4", "5", "6, 9, 10", "7", "8"):
        assert any(e["item"] in (f"Equation {k}", f"Equations {k}") for e in ENTRIES)
    assert "equations 11 to 14" in everything
    assert all(f"[{k}]" in everything for k in range(1, 7))
    assert all("shows" in e for e in ENTRIES)
    assert all(e.get("says") or e.get("slow") for e in ENTRIES if "run" in e)
