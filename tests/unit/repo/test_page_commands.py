"""Commands on the pages are commands of this program; those of "How do I ..." run as written."""

import ast
import importlib
import re
import runpy
import shlex

import click
import numpy as np
import pytest
import yaml
from click.testing import CliRunner
from repository import ROOT

from cardan.application.templates import template_text
from cardan.cli import cli

PAGES = [ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md"))]
TASKS = (ROOT / "docs/how-do-i.md").read_text(encoding="utf-8").split("\n## ")
FENCE = re.compile(r"^```(\w+)(?: title=\"(.*?)\")?\n(.*?)^```$", re.DOTALL | re.MULTILINE)


def written_commands(text):
    """Yield each command of a page: a line of code that begins with cardan, or inline code."""
    joined = re.sub(r"\\\n\s*", " ", text)
    yield from re.findall(r"^(?: {4,}|\$ |\[\[)?(cardan [^\n\]]*)", joined, re.MULTILINE)
    yield from (" ".join(found.split()) for found in re.findall(r"`(cardan [^`]+)`", joined))


def command_of(words):
    """Return the command that words call, below the program itself, and None if there is none."""
    context, found = click.Context(cli), None
    for word in words[1:]:
        if not word.startswith("-"):
            found = cli.get_command(context, word)
            break
    return found


def unknown_options(text):
    """Return each command of a page with an option that the program does not have."""
    unknown = []
    for line in written_commands(text):
        words = re.split(r"[\s,;()]+", line.partition(" # ")[0])
        command = command_of(words) or cli
        options = [p for of in (cli, command) for p in of.params]
        known = {"--help", "--all"}.union(*(p.opts + p.secondary_opts for p in options))
        unknown += [(line, w) for w in words if re.match("--[a-z]", w) and w not in known]
    return unknown


@pytest.mark.parametrize("page", PAGES, ids=lambda p: p.name)
def test_options_on_pages_exist(page):
    assert unknown_options(page.read_text(encoding="utf-8")) == []


def test_option_that_does_not_exist_is_found():
    text = (
        "Run `cardan check FILE --mvoes`.\n\n    cardan life a.csv --gauge S1 \\\n      --son 3\n"
    )
    assert [option for _, option in unknown_options(text)] == ["--son", "--mvoes"]


def test_reference_of_options_has_each_with_key_and_default():
    table = runpy.run_path(str(ROOT / "docs/hooks.py"))["options"]
    life = table("life").splitlines()
    named = {re.match(r"\| `(--[\w-]+)", row)[1] for row in life[2:]}
    declared = cli.get_command(click.Context(cli), "life").params
    assert named == {max(p.opts, key=len) for p in declared if isinstance(p, click.Option)}
    (scatter,) = (row for row in life if "--scatter " in row)
    assert scatter.startswith("| `--scatter FLOAT` | `strength: scatter` | `0.0` | Standard")
    assert not re.search("<function|Sentinel", table("bracket"))


def merged(base, change):
    """Return a mapping with the keys of another in place of its own, table by table."""
    both = isinstance(base, dict) and isinstance(change, dict)
    return base | {k: merged(base.get(k), v) for k, v in change.items()} if both else change


@pytest.fixture(scope="module")
def recording():
    """Return a minute at 200 Hz with a hole of 1.5 s and a logger's number for no value."""
    t = np.arange(0, 60, 1 / 200)
    stress = 40 * np.sin(2 * np.pi * 9 * t) + np.random.default_rng(1).normal(0, 8, t.size)
    cells = [f"{value:.2f}" for value in stress]
    cells[4000:4300] = [""] * 300
    cells[8000:8030] = ["-9999"] * 30
    rows = (f"{at:.3f},{cell}" for at, cell in zip(t, cells, strict=True))
    return "\n".join(["time_s,S1 [MPa]", *rows, ""])


@pytest.mark.slow
@pytest.mark.parametrize("task", TASKS[1:], ids=lambda t: t.partition("\n")[0])
def test_task_runs_as_written(task, tmp_path, monkeypatch, recording):
    """Its files are written, its commands run in order, none is refused (exit code 2 or 3)."""
    pytest.importorskip("typst", reason="reports are set by typst")
    monkeypatch.chdir(tmp_path)
    files = {
        "mine.yaml": template_text("small"),
        "truck.yaml": template_text("truck"),
        "run.csv": recording,
    }
    if "--of" not in task:
        for name in ("chassis-4800.yaml", "chassis-5400.yaml"):
            files[name] = template_text("truck")
    commands = []
    for kind, title, body in FENCE.findall(task):
        if title.startswith("in "):
            name = title.removeprefix("in ")
            own = merged(yaml.safe_load(files[name]), yaml.safe_load(body))
            if "slopes" in yaml.safe_load(body).get("driveline", {}):
                own["driveline"] = yaml.safe_load(body)["driveline"]
            files[name] = yaml.safe_dump(own, allow_unicode=True)
        elif title:
            files[title] = body
        elif kind == "sh":
            quick = body.replace("10000", "64").replace("--pdf", "--no-corrections --pdf")
            commands += quick.splitlines()
        elif kind == "python":
            commands.append(compile(body, "<page>", "exec"))
    for name, text in files.items():
        (tmp_path / name).write_text(text, encoding="utf-8")
    assert commands
    for command in commands:
        if isinstance(command, str):
            done = CliRunner().invoke(cli, shlex.split(command)[1:])
            assert done.exit_code in (0, 1), f"{command}: {done.output}"
            assert done.output
        else:
            exec(command, {})


@pytest.mark.parametrize("page", PAGES, ids=lambda p: p.name)
def test_names_imported_on_pages_exist(page):
    for kind, _, body in FENCE.findall(page.read_text(encoding="utf-8")):
        for node in ast.walk(ast.parse(body)) if kind == "python" else ():
            if isinstance(node, ast.ImportFrom) and str(node.module).startswith("cardan"):
                module = importlib.import_module(str(node.module))
                assert [a.name for a in node.names if not hasattr(module, a.name)] == []
