"""What somebody meets who does not know the program: help, slips of the pen, versions, language."""

import os
import re
import subprocess
import sys
from importlib.metadata import PackageNotFoundError
from pathlib import Path

import click
import numpy as np
import pytest
from click.testing import CliRunner
from repository import EXAMPLES, ROOT

import cardan
from cardan.cli import cli, versions
from cardan.cli.life import OPTION_GROUPS, life
from cardan.cli.main import COMMAND_NAMES

VAN = str(EXAMPLES / "van.yaml")


def run(*line: str, **environment: str):
    return CliRunner().invoke(cli, line, env=environment)


def test_numpy_is_imported_after_its_threads_are_set():
    """Set later, OpenBLAS starts threads of its own: a check took a quarter more of a processor."""
    code = (
        "import os, sys; import cardan.cli; "
        "assert 'numpy' not in sys.modules; print(os.environ['OPENBLAS_NUM_THREADS'])"
    )
    environment = {k: v for k, v in os.environ.items() if k != "OPENBLAS_NUM_THREADS"}
    said = subprocess.run(
        [sys.executable, "-c", code], env=environment, capture_output=True, text=True, check=False
    )
    assert (said.returncode, said.stdout) == (0, "1\n"), said.stderr


def test_help_lists_every_command_once_with_its_whole_summary():
    said = run("--help").stdout
    rows = [row.split()[0] for row in said.splitlines() if row.startswith("  ") and row[2] != " "]
    assert sorted(r for r in rows if r in COMMAND_NAMES) == list(COMMAND_NAMES)
    for name in COMMAND_NAMES:
        whole = cli.get_command(click.Context(cli), name).get_short_help_str(limit=1000)
        assert whole in " ".join(said.split())


@pytest.mark.parametrize(
    ("line", "said"),
    [
        (("chek",), "error: there is no command chek; did you mean check?"),
        (("qqq",), "error: there is no command qqq; there are: bracket, catalogue, "),
        (("check", VAN, "--with", "vibrations"), "; did you mean vibration?; see cli check --help"),
        (("chek", "--lang", "pt"), "erro: não há comando chek; quis dizer check?"),
        (("joint", "--angel", "4deg"), "error: No such option '--angel'"),
        (("--colour",), "error: No such option '--colour'; see cli --help"),
    ],
)
def test_slip_in_command_line_names_what_was_meant(line, said):
    found = run(*line)
    assert (found.exit_code, found.stdout) == (2, "")
    assert said in found.stderr
    assert "Usage" not in found.stderr


@pytest.mark.parametrize(
    ("option", "name", "ending"),
    [("--xlsx", "a.pdf", ".xlsx"), ("--pdf", "a.HTML", ".pdf"), ("--json", "a.xlsx", ".json")],
)
def test_ending_of_another_medium_is_rejected_before_anything_is_written(
    option, name, ending, tmp_path
):
    found = run("check", VAN, option, str(tmp_path / name))
    assert found.exit_code == 2
    assert f"{option} writes no {name[1:].lower()} file; end its name in {ending}" in found.stderr
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    ("environment", "said"),
    [
        ({"LC_ALL": "pt_BR.UTF-8"}, "erro: falta a opção"),
        ({"LC_ALL": "", "LC_MESSAGES": "", "LANG": "it_IT"}, "errore: manca l'opzione"),
        ({"LC_ALL": "fr_FR.UTF-8"}, "error: Missing option"),
        ({"LC_ALL": "C", "LANG": "pt_PT"}, "error: Missing option"),
    ],
)
def test_language_is_that_of_the_locale(environment, said):
    assert said in run("joint", "--angle", "4.5deg", **environment).stderr
    english = run("joint", "--angle", "4.5deg", "--lang", "en", **environment).stderr
    assert "error: Missing option" in english


def test_answer_is_in_the_language_of_the_locale():
    line = ("joint", "--angle", "4.5deg", "--speed", "1000rpm")
    assert run(*line, LC_ALL="pt_BR.UTF-8").stdout == run(*line, "--lang", "pt").stdout


def test_versions_of_all_parts_are_printed():
    first, python, *parts = run("--version", "--all").stdout.splitlines()
    git = ["git", "-C", str(ROOT), "rev-parse", "HEAD"]
    commit = subprocess.run(git, capture_output=True, text=True, check=False).stdout
    assert first.startswith("cardan 0.")
    if commit and (ROOT / ".git").exists() and ROOT in Path(cardan.__file__).parents:
        assert commit.startswith(first.partition("commit ")[2] or "-")
    assert python.startswith("Python 3.")
    assert f"numpy {np.__version__}" in parts


def test_versions_say_what_missing_numba_costs(monkeypatch):
    def without_numba(name):
        if name == "numba":
            raise PackageNotFoundError
        return "1.0"

    monkeypatch.setattr(versions, "version", without_numba)
    (line,) = (v for v in versions.version_lines() if v.startswith("numba"))
    assert line.startswith("numba not installed: studies of many variants take 1.5 to 1.7 times")


def test_completion_script_completes_commands():
    script = run("completion", "bash").stdout
    assert "_CARDAN_COMPLETE=bash_complete" in script
    words = {"COMP_WORDS": "cardan st", "COMP_CWORD": "1", "_CARDAN_COMPLETE": "bash_complete"}
    code = "from cardan.cli import cli; cli(prog_name='cardan')"
    done = subprocess.run(
        [sys.executable, "-c", code], env=os.environ | words, capture_output=True, text=True,
        check=False,
    )  # fmt: skip
    assert [row.split(",")[1] for row in done.stdout.split()] == ["stability", "study"]


def test_help_of_life_lists_each_option_once_in_a_group_by_purpose():
    shown = CliRunner().invoke(cli, ["life", "--help"]).stdout
    titles = re.findall(r"^([A-Z][^:\n]*):$", shown, re.MULTILINE)
    assert titles == list(OPTION_GROUPS)
    names = {p.name for p in life.params}
    assert set(OPTION_GROUPS.values()) <= names
    listed_options = shown.partition("\nGauges:\n")[2]
    flags = [max(p.opts, key=len) for p in life.params if p.name != "recording"]
    for flag in (*flags, "--help"):
        listed = re.findall(rf"^  (?:-\w, )?{flag}\b(?!-)", listed_options, re.MULTILINE)
        assert len(listed) == 1, flag
