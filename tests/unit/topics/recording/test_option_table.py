"""One declaration of each option: help, campaign file, method statement and workbench follow it."""

import json
import os
import shutil
import subprocess
import sys

import numpy as np
import pytest
from repository import ROOT

from cardan.cli.life import life as command
from cardan.physics.fatigue import mean_stress
from cardan.topics.recording import options
from cardan.topics.recording.json_presentation import MEAN_STRESS_CODES, RESIDUE_RULE_CODES
from cardan.topics.recording.option_table import OPTIONS, in_order, statement_rows
from cardan.topics.recording.options import AnalysisOptions

ADDED = """
    humidity: float | None = option(
        None,
        help="Relative humidity of the air.",
        bounds=NumberRange(least=0, most=1),
        keys=(FileKey(description="relative humidity of the air"),),
        row=StatementRow(label="humidity", unit=" of 1"),
        workbench=WorkbenchField(),
    )
"""


@pytest.mark.parametrize(
    ("residue", "code"),
    [("half", "half_cycles"), ("repeat", "repeating"), ("discard", "discarded")],
)
def test_residue_rule_has_its_code_in_json(residue, code):
    assert RESIDUE_RULE_CODES[options._RESIDUES[residue]] == code


def test_every_mean_stress_correction_has_its_code_in_json():
    choices = {"none", "goodman", "gerber", "swt", "walker", "fkm"}
    assert set(MEAN_STRESS_CODES.values()) == choices - {"none"} | {"uncorrected"}
    assert all(getattr(mean_stress, code) is f for f, code in MEAN_STRESS_CODES.items())


@pytest.mark.slow
def test_option_added_in_one_file_reaches_help_schema_and_method_statement(tmp_path):
    package = tmp_path / "cardan"
    shutil.copytree(ROOT / "src" / "cardan", package, ignore=shutil.ignore_patterns("static"))
    table = package / "topics" / "recording" / "option_table.py"
    first = "    sn: str = option(\n"
    table.write_text(table.read_text().replace(first, f"{ADDED.lstrip(chr(10))}{first}"))
    time = np.arange(4000) / 1000
    rows = (f"{t:.4f},{60 * np.sin(40 * t + t * t):.4f}" for t in time)
    (tmp_path / "r.csv").write_text("\n".join(("time [s],S1 [MPa]", *rows)) + "\n")

    def run(*args):
        done = subprocess.run(
            [sys.executable, "-m", "cardan", *args],
            cwd=tmp_path, env=os.environ | {"PYTHONPATH": str(tmp_path)}, capture_output=True,
            text=True, check=False,
        )  # fmt: skip
        return done.stdout + done.stderr

    assert "--humidity FLOAT" in run("life", "--help")
    keys = json.loads(run("schema", "--campaign"))["$defs"]["Campaign"]["properties"]
    assert keys["humidity"] == {
        "description": "relative humidity of the air", "type": "number", "minimum": 0.0,
        "maximum": 1.0,
    }  # fmt: skip
    asked = ("life", "r.csv", "--gauge", "S1", "--sn", "50,2e6,5", "-q", "--all", "--humidity")
    assert "humidity: 0.7 of 1" in " ".join(run(*asked, "0.7").split())
    assert "--humidity must be at least 0 and at most 1, got 7" in run(*asked, "7")


def test_command_defaults_are_those_of_options():
    given = command.make_context("life", ["x", "--sn", "1,1,1"]).params
    blank = AnalysisOptions(sn="1,1,1")
    assert {name: given[name] for name in OPTIONS} == {n: getattr(blank, n) for n in OPTIONS}


def test_campaign_key_exists_for_every_option_but_predictions_by_hand():
    left = {name for name, one in OPTIONS.items() if not one.keys}
    assert left == {"scale", "estimate_speed", "joint_orders", "predicted"}


def test_statement_rows_name_declared_options_once():
    names = [option.name for option, _ in statement_rows()]
    assert len(names) == len(set(names)) == sum(one.row is not None for one in OPTIONS.values())
    for option, row in statement_rows():
        assert not option.choices or set(row.texts) >= set(option.choices)


@pytest.mark.parametrize(
    ("after", "expected"),
    [
        ({}, "abcd"),
        ({"a": "c"}, "bcad"),
        ({"b": "d", "a": "b"}, "cdba"),
        ({"a": "d", "b": "d"}, "cdab"),
    ],
)
def test_entry_is_listed_behind_named_one(after, expected):
    found = in_order("abcd", name=str, after=lambda one: after.get(one, ""))
    assert "".join(found) == expected
