"""Every command as somebody runs it who has just installed the program."""

import hashlib
import json
import re
import subprocess
import sys
from contextlib import redirect_stderr
from dataclasses import replace
from io import StringIO
from pathlib import Path

import jsonschema
import numpy as np
import pytest
import yaml
from click.testing import CliRunner, Result
from repository import EXAMPLES

from cardan import __version__
from cardan.application import reader, templates
from cardan.approval.approval import approve_application
from cardan.checks.quantities.registry import QUANTITIES
from cardan.cli import cli
from cardan.cli.common import progress_line
from cardan.core.errors import DesignError
from cardan.core.message import TranslatableMessage
from cardan.core.provenance import SOURCE_DERIVED
from cardan.render.i18n import LANGUAGE_CODES, message_catalogue
from cardan.topics.design.corrections import find_corrections
from cardan.topics.torsion.study import analyse_vibration
from cardan.topics.verification.published_cases import BenchmarkCase, benchmark_cases

SMALL = """\
title: One shaft
speed_rpm: 2500
torque_Nm: 3000
driveline:
  slopes: {side_deg: [4.0, 2.0, 4.0]}
  shafts: [{length_mm: 1200, tube: 100x3}]
limits: protractor
"""


def run(*arguments: object) -> Result:
    return CliRunner().invoke(cli, [str(a) for a in arguments], catch_exceptions=False)


@pytest.fixture
def small(tmp_path: Path) -> Path:
    return written(tmp_path, SMALL)


def written(folder: Path, text: str, name: str = "application.yaml") -> Path:
    file = folder / name
    file.write_text(text, encoding="utf-8")
    return file


# --------------------------------------------------------------------------- check


def test_check_prints_verdict_before_values(small):
    result = run("check", "--states", small)
    first, second, third, *_ = result.stdout.splitlines()
    assert re.fullmatch(r"One shaft {3,}APPROVED", first)
    assert second.startswith("Read: 2 joints, 1 shaft; ")
    assert second.endswith("criteria: protractor")
    assert re.match(r"[1-9]\d* criteria: 0 exceeded, 0 beyond recommended, [1-9]\d* met", third)
    assert "Torsional equivalent angle" in result.stdout
    assert "(AE-7)" in result.stdout
    assert result.stderr == ""
    assert result.exit_code == 0


def test_check_lists_checks_not_evaluated_with_missing_input(tmp_path):
    """Held against a truck's profile the same file is no pass: half of it is not answered."""
    result = run("check", written(tmp_path, SMALL.replace("protractor", "heavy-truck")))
    assert result.exit_code == 1
    assert re.fullmatch(r"One shaft +INCOMPLETE", result.stdout.splitlines()[0])
    said = re.sub(r"\n {3,}", " ", result.stdout).splitlines()  # a line that goes on is one
    missing = [x for x in said if "not evaluated (input missing: " in x.lower()]
    assert any(x.startswith("Required, ") and "elastic limit" in x for x in missing)
    assert any("needle bearing life" in x and "(input missing: duty" in x for x in missing)
    assert not any("clearance" in x for x in missing)  # nothing is in the way
    assert not any("centre bearing" in x for x in missing)  # one shaft has none


def test_colour_is_printed_on_terminal_only(small):
    assert "\x1b" not in run("check", small).stdout
    coloured = CliRunner().invoke(cli, ["check", str(small)], color=True)
    assert "\x1b[32mAPPROVED\x1b[0m" in coloured.stdout


@pytest.mark.parametrize(
    ("speed", "slope", "word", "code"),
    [
        (2500, 3.5, "APPROVED", 0),
        (2500, 2.8, "APPROVED WITH WARNINGS", 0),  # its needles hardly roll
        (13000, 3.5, "NOT APPROVED", 1),
        (0, 3.5, "INCOMPLETE", 1),
    ],
)
def test_exit_code_matches_verdict(tmp_path, speed, slope, word, code):
    text = SMALL.replace("2500", str(speed)).replace("4.0", str(slope))
    file = written(tmp_path, text)
    result = run("check", "--quiet", file)
    assert result.stdout.startswith(f"One shaft: {word} (")
    assert result.exit_code == code


def test_exit_code_of_several_files_is_the_worst(tmp_path):
    good = written(tmp_path, SMALL, "good.yaml")
    bad = written(tmp_path, SMALL.replace("2500", "13000"), "bad.yaml")
    for files_, code in (((good, good), 0), ((good, bad), 1), ((bad, good), 1)):
        assert run("check", "-q", *files_).exit_code == code


def test_several_files_get_one_line_each_and_a_count(tmp_path):
    """Two hundred files printed 16 000 lines, side by side, and no line of a file."""
    good = written(tmp_path, SMALL, "good.yaml")
    bad = written(tmp_path, SMALL.replace("2500", "13000"), "bad.yaml")
    first, second, third, count, after = run("check", good, bad, good).stdout.splitlines()
    assert first == third
    assert first.startswith(f"{good}  APPROVED: ")
    assert second.startswith(f"{bad}   NOT APPROVED: ")
    assert " (max " in second
    assert count == "3 files: 2 approved, 1 not approved"
    assert after == "Next: cardan check FILE | cardan check FILE FILE --all | --pdf OUT"
    assert "Variants side by side" in run("check", "--all", good, bad).stdout


def test_line_of_incomplete_file_names_what_is_not_evaluated(tmp_path):
    """Its worst criterion would read like a verdict."""
    open_ = written(tmp_path, SMALL.replace("protractor", "heavy-truck"), "open.yaml")
    good = written(tmp_path, SMALL, "good.yaml")
    line, *_ = run("check", open_, good).stdout.splitlines()
    assert "INCOMPLETE: " in line
    assert "not evaluated" in line


@pytest.mark.slow
def test_additional_study_is_included_in_verdict(tmp_path):
    """Its checks stand among the others; what was asked is not among what was not."""
    file, out = written(tmp_path, templates.template_text("truck")), tmp_path / "out.json"
    told = [
        (json.loads(out.read_text(encoding="utf-8")), shown)
        for options in ((), ("--with", "vibration"))
        for shown in [run("check", file, "--json", out, *options).stdout]
    ]
    (plain, alone), (more, shown) = told
    assert plain["studies"] == ["driveline"]
    assert more["studies"] == ["driveline", "vibration"]
    asked = {c["quantity"] for c in more["checks"]} - {c["quantity"] for c in plain["checks"]}
    assert asked == {
        "torsional_resonance",
        "torsional_growth",
        "lateral_growth",
        "torsional_amplitude_utilisation",
        "torsional_peak_utilisation",
        "torsional_reversal",
        "torsional_pinion_acceleration",
        "launch_peak_utilisation",
        "launch_reversal",
        "launch_bearing_force",
    }
    for document in (plain, more):
        coverage = document["coverage"]
        assert coverage["answered"] == len(document["checks"])
        assert coverage["asked"] == coverage["answered"] + len(coverage["unanswered"])
    assert {"torsional_resonance", "torsional_growth"} <= set(plain["not_asked"])
    assert not asked & set(more["not_asked"])
    unanswered = {u["quantity"] for u in more["coverage"]["unanswered"]}
    assert not asked & unanswered
    assert "Not evaluated (--with vibration)" not in shown
    assert "Not evaluated (--with vibration)" in alone


def test_missing_bracket_is_reported_as_not_evaluated(small):
    for options in (("--bracket",), ("--with", "bracket")):
        shown = run("check", *options, small).stdout
        shown = " ".join(shown.split())
        assert "Not evaluated (input missing: the shape of the bracket): bracket stress" in shown


def test_html_report_contains_hash_of_input_file(small, tmp_path):
    out = tmp_path / "page.html"
    assert run("check", "-q", "--html", out, small).exit_code == 0
    assert hashlib.sha256(small.read_bytes()).hexdigest()[:16] in out.read_text("utf-8")


def test_quiet_option_prints_verdict_only(small):
    assert len(run("check", "-q", small).stdout.splitlines()) == 1
    # What is read by a program holds the verdict, and ends where it ends.
    assert json.loads(run("check", "-q", "--json", "-", small).stdout)["verdict"]


@pytest.mark.parametrize(
    ("example", "text", "slip", "count"),
    [
        ("van", "torque_Nm: [270, 270, 208]", "torque_Nm: [199, 199, 153]", "1 value"),
        ("three-joint-chain", "tube: 100x3", "tube: {outer_mm: 200, wall_mm: 2}", "3 values"),
    ],
)
def test_quiet_verdict_counts_values_that_look_wrong(tmp_path, example, text, slip, count):
    right = (EXAMPLES / f"{example}.yaml").read_text("utf-8")
    assert text in right
    file = written(tmp_path, right.replace(text, slip))
    (line,) = run("check", "-q", file).stdout.splitlines()
    assert re.search(rf"; {count} looks? wrong\)$", line), line
    assert "look" not in run("check", "-q", EXAMPLES / f"{example}.yaml").stdout


@pytest.mark.slow
def test_every_block_of_long_output_has_an_option():
    """`--all` prints each check; `--sources` each limit, `--moves` and `--states` their blocks."""
    file = EXAMPLES / "refuse-collector-6x2.yaml"
    checks = json.loads(run("check", "--json", "-", file).stdout)["checks"]

    def lines(*options: str) -> list[str]:
        return run("check", *options, file).stdout.splitlines()

    def rows(printed: list[str]) -> list[str]:
        return [x for x in printed if re.match(r"[X! ] \S.* (<=|>=|outside) .*\[\d+\]$", x)]

    every, first = lines("--all"), lines()
    assert len(rows(every)) == len(checks)
    marks = [row[0] for row in rows(every)]
    assert marks == sorted(marks, key="X! ".index)
    assert rows(first) == []
    limits = {(c["quantity"], c["source"], c["sense"]) for c in checks}
    assert len(rows(lines("--sources"))) == len(limits)
    blocks = {
        "--sources": "Note: ",
        "--moves": "Single corrections (`cardan fix`",
        "--states": "Speed and strength",
    }
    for option, text in blocks.items():
        assert not any(text in line for line in first)
        assert any(text in line for line in every)
        shown = lines(option)
        assert shown[: len(first)] == first
        below = shown[len(first) :]
        assert any(text in line for line in below)
        if option != "--sources":  # its table has one row for each limit
            assert set(below) <= set(every)


@pytest.mark.slow
@pytest.mark.parametrize("wide", [80, 120])
@pytest.mark.parametrize(
    "options", [(), ("--all",), ("--lang", "it"), ("--states",), ("--sources", "--moves")]
)
def test_check_output_fits_terminal_width_without_truncation(wide, options, monkeypatch):
    monkeypatch.setenv("COLUMNS", str(wide))
    shown = run("check", *options, EXAMPLES / "refuse-collector-6x2.yaml").stdout
    assert max(map(len, shown.splitlines())) <= wide
    assert "…" not in shown
    # A number stands in one line with what it counts.
    assert not re.search(r"(joint|shaft|bearing|giunto|albero|supporto)\n\s*\d", shown)


def test_no_color_and_force_color_variables_are_respected(small, monkeypatch):
    runner = CliRunner()
    for name, value, coloured in (("NO_COLOR", "1", False), ("FORCE_COLOR", "1", True)):
        monkeypatch.delenv("NO_COLOR", raising=False)
        monkeypatch.setenv("TERM", "xterm")
        monkeypatch.setenv(name, value)
        shown = runner.invoke(cli, ["check", "-q", str(small)], color=name == "NO_COLOR").output
        assert ("\x1b" in shown) == coloured


def test_json_option_prints_json_only(small):
    result = run("check", small, "--json")
    document = json.loads(result.stdout)
    assert document["application"] == "One shaft"
    assert document["verdict"] == "pass"
    assert document["cardan"] == ".".join(__version__.split(".")[:2])
    assert result.exit_code == 0


def test_json_file_is_written_in_addition_to_table(small, tmp_path):
    out = tmp_path / "out.json"
    result = run("check", "--json", out, small)
    assert re.match("One shaft +APPROVED", result.stdout)
    assert json.loads(out.read_text(encoding="utf-8")) == json.loads(
        run("check", "--json", "-", small).stdout
    )
    assert run("check", "--json", out, "-q", small).exit_code == 0  # and again, over the old one


def test_limits_option_selects_another_profile(small):
    document = json.loads(run("check", "--limits", "elbe", "--json", "-", small).stdout)
    assert document["profile"] == "elbe"
    assert {c["quantity"] for c in document["checks"]} >= {"irregularity"}


def test_limits_option_accepts_user_profile_file(small, tmp_path):
    own = written(
        tmp_path,
        "profile: ours\nlimits: [{quantity: joint_angle, unit: deg, maximum: 1.5, source: us}]\n",
        "ours.yaml",
    )
    result = run("check", "--limits", own, "--json", "-", small)
    document = json.loads(result.stdout)
    assert document["profile"] == "ours"
    own = [c for c in document["checks"] if c["source"] == "us"]
    assert [(c["part"], c["verdict"]) for c in own] == [("joint 1", "fail"), ("joint 2", "fail")]
    # What the file holds of speed and strength is evaluated all the same.
    others = {c["quantity"] for c in document["checks"]} - {"joint_angle"}
    assert others >= {"critical_speed_ratio", "tube_shear_utilisation", "tube_buckling_utilisation"}
    assert result.exit_code == 1


@pytest.mark.slow
def test_check_does_not_import_scipy_or_matplotlib():
    """They take longer to start than the whole check takes to run."""
    code = (
        "import sys; from cardan.cli import cli\n"
        "try: cli(['check', '--quiet', sys.argv[1]])\n"
        "except SystemExit as end: assert end.code == 1, end.code\n"
        "print(sorted({'scipy', 'matplotlib', 'jsonschema'} & set(sys.modules)))"
    )
    command = [sys.executable, "-c", code, str(EXAMPLES / "refuse-collector-6x2.yaml")]
    result = subprocess.run(command, capture_output=True, text=True, check=True)
    assert result.stdout.splitlines()[-1] == "[]"


@pytest.mark.slow
def test_installed_script_runs(small):
    script = Path(sys.executable).with_name("cardan")
    result = subprocess.run([script, "check", "-q", small], capture_output=True, check=True)
    assert result.stdout.startswith(b"One shaft: APPROVED (")


# --------------------------------------------------------------------------- wrong files

WRONG = {
    "a misspelt key": (
        SMALL.replace("torque_Nm", "torqe_Nm"),
        ":3:1: torqe_Nm: unknown key; did you mean torque_Nm?",
    ),
    "a key without its unit": (
        SMALL.replace("torque_Nm", "torque"),
        ":3:1: torque: unknown key; the key names its unit: write torque_Nm",
    ),
    "a decimal comma": (
        SMALL.replace("2500", "2500,5"),
        ":2:12: speed_rpm: must be a number of 0 or more (got 2500,5); write a decimal point: 25",
    ),
    "one unit twice": (
        SMALL.replace("speed_rpm", "torque_lbft: 2200\nspeed_rpm"),
        ":4:1: torque_Nm: torque_lbft gives this already; keep one of them",
    ),
    "a number that is none": (SMALL.replace("3000", ".nan"), ":3:12: torque_Nm: "),
    "a slope too few": (
        SMALL.replace("[4.0, 2.0, 4.0]", "[4.0, 2.0]"),
        "must hold 3 values, for gearbox, shaft 1, pinion (got 2 values)",
    ),
    "a tube nobody makes": (
        SMALL.replace("100x3", "100-33"),
        ":6:36: driveline.shafts[1].tube: no catalogue has a tube 100-33; write outside diameter x "
        "wall: 100x4 in mm, 4.000x0.134in in inches; nearest in size: 120x6, 142x6, 120x5",
    ),
    "a tab": (SMALL.replace("  slopes", "\tslopes"), ":5:1: a tab indents this line"),
    "nothing": ("", ":1:1: the file is empty; `cardan new` writes one to start from"),
}


@pytest.mark.parametrize("kind", WRONG)
def test_invalid_file_is_rejected_with_position_and_remedy(tmp_path, kind):
    text, message = WRONG[kind]
    file = written(tmp_path, text)
    result = run("check", file)
    assert result.exit_code == 2
    assert result.stdout == ""
    assert f"error: {file}:" in result.stderr
    assert message in result.stderr


def test_all_errors_of_file_are_reported_together(tmp_path):
    text = SMALL.replace("speed_rpm", "sped_rpm").replace("3000", "no").replace("100x3", "x")
    lines = run("check", written(tmp_path, text)).stderr.splitlines()
    assert len(lines) == 3
    assert all(line.startswith("error: ") for line in lines)


def test_implausible_value_warns_and_check_continues(tmp_path):
    file = written(tmp_path, SMALL.replace("[4.0, 2.0, 4.0]", "[0.07, 0.035, 0.07]"))
    result = run("check", "--json", "-", file)
    assert result.stderr.startswith(f"warning: {file}:5:")
    assert "slopes.side_rad" in result.stderr or "side_rad" in result.stderr
    assert json.loads(result.stdout)["application"] == "One shaft"


@pytest.mark.parametrize("command", ["check", "fix"])
def test_missing_file_is_rejected_with_nearest_file_name(command, small):
    result = run(command, small.with_name("aplication.yaml"))
    assert result.exit_code == 2
    assert "cannot be read" in result.stderr
    assert f"did you mean {small}?" in result.stderr


def test_unknown_profile_is_rejected_with_nearest_name(small):
    result = run("check", "--limits", "heavytruck", small)
    assert result.exit_code == 2
    assert "did you mean heavy-truck?" in result.stderr


def test_impossible_design_is_rejected_with_reason(tmp_path):
    """It takes the state's own arithmetic to see that the link is too short for the travel."""
    text = SMALL + (
        "suspension: {spring: {rates_N_mm: [200]}, linkage: {radius_mm: 400}}\n"
        "states: [{name: on the lift, travel_mm: -900}]\n"
    )
    file = written(tmp_path, text)
    result = run("check", file)
    assert result.exit_code == 2
    assert result.stderr.endswith(
        f"error: {file}:8:43: suspension.linkage: a link of radius 400 mm cannot follow an axle "
        "travel of -900 mm\n"
    )


# --------------------------------------------------------------------------- fix


def test_fix_proposal_is_confirmed_by_check_of_changed_file(tmp_path):
    """The axle's nose is 3 deg off: the proposal is a shim, and the changed file passes."""
    text = SMALL.replace("[4.0, 2.0, 4.0]", "[4.0, 2.0, 7.5]").replace("2500", "3600")
    text += "adjust: {shim_deg: [-4, 4]}\n"
    assert run("check", "-q", written(tmp_path, text)).exit_code == 1
    result = run("fix", "--json", "-", written(tmp_path, text))
    assert result.exit_code == 0
    best, *_ = json.loads(result.stdout)
    (move,) = best["moves"]
    assert (best["verdict"], move["what"], move["part"]) == ("pass", "shim", 1)
    changed = text.replace("7.5", f"{7.5 + move['amount_deg']}")
    assert run("check", "-q", written(tmp_path, changed)).stdout.startswith("One shaft: APPROVED")


def test_fix_writes_file_that_checks_as_proposed(tmp_path):
    """A body builder's file holds slopes: a shim in degrees had to be written into it by hand."""
    text = SMALL.replace("[4.0, 2.0, 4.0]", "[4.0, 2.0, 7.5]").replace("2500", "3600")
    file, out = written(tmp_path, text + "adjust: {shim_deg: [-4, 4]}\n"), tmp_path / "out.yaml"
    result = run("fix", "--write", str(out), file)
    assert result.exit_code == 0
    assert "driveline.slopes.side_deg[3]: 7.5 -> " in result.stdout
    assert f"Check of {out}: APPROVED" in " ".join(result.stdout.split())
    assert run("check", "-q", str(out)).stdout.startswith("One shaft: APPROVED (")
    kept = out.read_bytes()
    again = run("fix", "--write", str(out), file)
    assert (again.exit_code, again.stderr) == (
        2, f"error: {out} is there already: choose another name\n")  # fmt: skip
    other = tmp_path / "other.yaml"
    none = run("fix", "-q", "--write", str(other), "--proposal", "9", file)
    assert none.exit_code == 2
    assert "nothing is written: proposal 9 of " in none.stderr
    assert out.read_bytes() == kept
    assert not other.exists()


def test_fix_refuses_proposal_that_nothing_is_to_hold(small):
    result = run("fix", "--proposal", "2", small)
    assert (result.exit_code, result.stdout) == (2, "")
    assert result.stderr.startswith("error: --proposal 2 needs --write OUT")


def test_fix_prints_correction_in_workshop_terms(tmp_path):
    text = SMALL.replace("[4.0, 2.0, 4.0]", "[4.0, 2.0, 7.5]").replace("2500", "3600")
    result = run("fix", "--all", written(tmp_path, text + "adjust: {shim_deg: [-4, 4]}\n"))
    assert "pinion angle -" in result.stdout
    said = next(line for line in result.stdout.splitlines() if line.startswith("1. APPROVED, "))
    down = float(result.stdout.split("pinion angle -")[1].split("°")[0])
    changed = written(tmp_path, text.replace("7.5]", f"{7.5 - down}]"))
    margin = re.search(r"smallest margin that moving changes (\S+ %)", said)[1]
    assert f"smallest margin {margin}" in run("check", changed, "--all").stdout


def test_fix_respects_hold_option(tmp_path):
    text = SMALL.replace("[4.0, 2.0, 4.0]", "[4.0, 2.0, 7.5]").replace("2500", "3600")
    file = written(tmp_path, text + "adjust: {shim_deg: [-4, 4]}\n")
    result = run("fix", "--hold", "shim", file)
    assert "\nNothing that may be moved, within `adjust`" in result.stdout
    assert result.exit_code == 1


@pytest.mark.slow
def test_fix_exit_code_is_zero_only_if_all_required_checks_pass(tmp_path):
    """The shim mends what fails, but nobody can say whether the joints carry the torque."""
    text = SMALL.replace("[4.0, 2.0, 4.0]", "[4.0, 2.0, 7.5]").replace("2500", "3600")
    text += "adjust: {shim_deg: [-4, 4]}\n"
    limits = "limits: {profile: protractor, overrides: [{quantity: joint_torque_utilisation, "
    open_ = text.replace("limits: protractor", limits + "maximum: 1, required: true, source: us}]}")
    for file, verdict, code in ((text, "pass", 0), (open_, "incomplete", 1)):
        result = run("fix", "--json", "-", written(tmp_path, file))
        best, *_ = json.loads(result.stdout)
        assert (best["verdict"], result.exit_code) == (verdict, code)


@pytest.mark.slow
@pytest.mark.parametrize("steps", ["", ", steps: {shim_deg: 0.01}"])
def test_fix_respects_one_sided_adjustment_range(tmp_path, steps):
    """By half degrees, which are all asked, and by so small steps that it is searched."""
    text = SMALL.replace("[4.0, 2.0, 4.0]", "[4.0, 2.0, 7.5]").replace("2500", "3600")
    file = written(tmp_path, text + f"adjust: {{shim_deg: [-4, 0]{steps}}}\n")
    found = json.loads(run("fix", "--json", "-", file).stdout)
    assert found[0]["verdict"] == "pass"
    amounts = [m["amount_deg"] for p in found for m in p["moves"]]
    assert all(-4 <= a < 0 for a in amounts)


def test_fix_uses_end_of_range_between_steps(tmp_path):
    """Whoever allows 0.8 deg down has a wedge of 0.8 deg, whatever others are made in."""
    text = SMALL.replace("[4.0, 2.0, 4.0]", "[4.0, 2.0, 7.5]").replace("2500", "3600")
    file = written(tmp_path, text + "adjust: {shim_deg: [-0.8, 0.2]}\n")
    found = json.loads(run("fix", "--json", "-", file).stdout)
    assert max(m["amount_deg"] for p in found for m in p["moves"]) < 0
    assert min(m["amount_deg"] for p in found for m in p["moves"]) == pytest.approx(-0.8)


def test_fix_respects_hold_key_of_file(tmp_path):
    text = SMALL.replace("[4.0, 2.0, 4.0]", "[4.0, 2.0, 7.5]").replace("2500", "3600")
    file = written(tmp_path, text + "adjust: {shim_deg: [-4, 4], hold: [shim]}\n")
    result = run("fix", file)
    assert "\nNothing that may be moved, within `adjust`" in result.stdout
    assert result.exit_code == 1


@pytest.mark.slow
def test_fix_returns_requested_number_of_proposals():
    file = EXAMPLES / "three-joint-chain.yaml"
    assert len(json.loads(run("fix", "--count", 2, "--json", "-", file).stdout)) == 2


def test_fix_rejects_unknown_line(small):
    result = run("fix", "--line", "front", small)
    assert result.exit_code == 2
    assert result.stderr == f"error: {small}: there is no line front; the application has main\n"


# --------------------------------------------------------------------------- the others


def test_explain_lists_every_quantity():
    lines = run("explain").stdout.splitlines()
    assert [line.split()[0] for line in lines] == list(QUANTITIES)


@pytest.mark.parametrize("key", QUANTITIES)
def test_explain_prints_definition_and_source_of_quantity(key):
    q = QUANTITIES[key]
    result = run("explain", key)
    assert result.exit_code == 0
    shown = " ".join(result.stdout.split())  # wherever lines end
    for said in (
        q.name,
        q.symbol,
        q.equation_text,
        str(q.source),
        *q.symbol_meanings,
        *q.symbol_meanings.values(),
    ):
        assert " ".join(said.split()) in shown


@pytest.mark.parametrize("word", ["Torsional acceleration", "aceleração torcional"])
def test_explain_accepts_quantity_name_in_any_language(word):
    assert run("explain", word).stdout == run("explain", "torsional_acceleration").stdout


@pytest.mark.parametrize(
    ("word", "meant"),
    [
        ("clearence", "did you mean clearance?"),
        ("torsional", "equivalent_angle or torsional_acceleration or torsional_resonance?"),
        ("zzz", "there is no quantity zzz ("),
    ],
)
def test_explain_rejects_misspelt_quantity_with_nearest_name(word, meant):
    result = run("explain", word)
    assert result.exit_code == 2
    assert meant in result.stderr
    assert result.stdout == ""


def test_verify_reproduces_published_cases():
    result = run("verify")
    assert result.exit_code == 0
    assert "WRONG" not in result.stdout
    cases = json.loads(run("verify", "--json").stdout)
    shown = " ".join(result.stdout.split())  # wherever lines end
    assert result.stdout.count("\nok    ") == len(cases) >= 30
    for case in cases:
        assert abs(case["computed"] - case["published"]) <= case["within"]
        assert case["source"] in shown


def test_every_published_case_has_its_title_in_every_language():
    for code in LANGUAGE_CODES[1:]:
        known = message_catalogue(code)
        assert {c.title.text for c in benchmark_cases() if ("", c.title.text) not in known} == set()
    shown = run("verify", "--lang", "it").stdout
    assert "ok     Angolo vero del giunto 1, deg              2,7819" in shown
    assert "tabella 3" in shown
    assert not {"case", "published", "computed", "difference", "WRONG"} & set(shown.split())


def test_verify_uses_many_sources_and_marks_derived_cases():
    cases = benchmark_cases()
    citable = [c for c in cases if c.kind == "published"]
    assert len(citable) >= 60
    assert len({c.source.title for c in citable}) >= 15
    assert len({(c.title, c.source) for c in cases}) == len(cases)  # none twice
    kinds = [c.kind for c in cases]
    assert kinds == sorted(kinds, key=("published", "untraced", "derived").index)
    for case in cases:
        own = case.source.title.startswith(("Derived", "AISCO's life formula"))
        assert not own or case.kind == "derived"


def test_published_value_must_agree_to_last_digit():
    """Printed 12.3, so 12.25 to 12.35; what is no number is not met."""
    case = BenchmarkCase(
        title=TranslatableMessage(""),
        source=SOURCE_DERIVED,
        expected=12.3,
        computed=12.34,
        tolerance=0.05,
    )
    assert case.is_within_tolerance
    for computed in (12.36, 12.24, float("nan")):
        assert not replace(case, computed=computed).is_within_tolerance


@pytest.mark.slow
def test_schema_validates_examples_and_starter_files(tmp_path):
    document = json.loads(run("schema").stdout)
    jsonschema.Draft202012Validator.check_schema(document)
    validator = jsonschema.Draft202012Validator(document)
    starters = [tmp_path / f"{kind}.yaml" for kind in ("small", "truck")]
    for file in starters:
        run("new", "--kind", file.stem, file)
    for file in [*EXAMPLES.glob("*.yaml"), *starters]:
        application = yaml.safe_load(file.read_text(encoding="utf-8"))
        validator.validate(application)
    with pytest.raises(jsonschema.ValidationError):
        validator.validate({**application, "sped_rpm": 1})


def test_schema_is_not_overwritten_without_force(tmp_path):
    out = tmp_path / "cardan.schema.json"
    assert run("schema", "--out", out).exit_code == 0
    assert out.read_text(encoding="utf-8") == run("schema").stdout
    assert run("schema", "--out", out).exit_code == 2
    assert run("schema", "--out", out, "--force").exit_code == 0


@pytest.mark.parametrize("kind", ["small", "truck"])
def test_new_writes_file_that_passes_check_without_warning(tmp_path, kind):
    file = tmp_path / "mine.yaml"
    result = run("new", "--kind", kind, file)
    assert result.exit_code == 0
    assert "cardan check" in result.stdout
    checked = run("check", "--quiet", file)
    assert checked.exit_code == 0
    assert checked.stderr == ""


def test_new_writes_worked_example_or_folder_of_case(tmp_path):
    made = run("new", tmp_path / "a.yaml", "--example", "van")
    assert made.exit_code == 0, made.stderr
    assert (tmp_path / "a.yaml").read_bytes() == (EXAMPLES / "van.yaml").read_bytes()
    assert run("new", tmp_path / "case", "--example", "refuse-collector").exit_code == 0
    there = {p.name: p.read_bytes() for p in (EXAMPLES / "refuse-collector").iterdir()}
    assert {p.name: p.read_bytes() for p in (tmp_path / "case").iterdir()} == there
    (tmp_path / "case/campaign.yaml").write_text("mine", "utf-8")
    again = run("new", tmp_path / "case", "--example", "refuse-collector")
    assert (again.exit_code, "--force" in again.stderr) == (2, True)
    assert (tmp_path / "case/campaign.yaml").read_text("utf-8") == "mine"
    wrong = run("new", tmp_path / "b.yaml", "--example", "refuse-collecter")
    assert "did you mean refuse-collector?" in wrong.stderr


def test_new_does_not_overwrite_file_without_force(tmp_path):
    file = written(tmp_path, "my work\n")
    result = run("new", file)
    assert result.exit_code == 2
    assert f"error: {file}: is there already" in result.stderr
    assert file.read_text(encoding="utf-8") == "my work\n"
    assert run("new", "--force", file).exit_code == 0
    assert "title:" in file.read_text(encoding="utf-8")


def test_version_option_prints_package_version():
    assert run("--version").stdout == f"cardan, version {__version__}\n"


@pytest.mark.parametrize("command", [(), ("check",), ("fix",), ("explain",), ("verify",),
                                     ("schema",), ("new",)])  # fmt: skip
def test_every_command_has_help(command):
    result = run(*command, "--help")
    assert result.exit_code == 0
    assert "Usage:" in result.stdout


# --------------------------------------------------------------------------- what is refused late


@pytest.mark.parametrize("command", ["fix", "stability"])
def test_impossible_suspension_link_is_reported_with_file_and_line(tmp_path, command):
    """Only the check finds out that a link is too short for the travel."""
    text = templates.template_text("truck").replace(
        "front_half_length_mm: 760", "front_half_length_mm: 60"
    )
    file = written(tmp_path, text, "short.yaml")
    result = run(command, file)
    assert result.exit_code == 2
    assert f"error: {file}:47:3: suspension.linkage: a link of radius 45 mm" in result.stderr


def test_error_names_the_file_among_several(tmp_path, small):
    text = templates.template_text("truck").replace(
        "front_half_length_mm: 760", "front_half_length_mm: 60"
    )
    file = written(tmp_path, text, "short.yaml")
    assert f"error: {file}:47:3: suspension.linkage: a link" in run("check", small, file).stderr


# --------------------------------------------------------------------------- progress


class Terminal(StringIO):
    """Somebody looks at it."""

    def isatty(self) -> bool:
        return True


def test_progress_line_is_cleared_at_end():
    with redirect_stderr(Terminal()) as shown, progress_line("looking") as tell:
        tell(1, 3)
        tell(2, 3)
    wipe = "\r\033[K"
    assert shown.getvalue() == "".join(
        wipe + said for said in ("looking", "looking: 1/3", "looking: 2/3", "")
    )


def test_progress_line_is_cleared_before_error():
    with (
        redirect_stderr(Terminal()) as shown,
        pytest.raises(DesignError),
        progress_line("looking"),
    ):
        raise DesignError
    assert shown.getvalue().endswith("looking\r\033[K")


@pytest.mark.parametrize(("stream", "quiet"), [(Terminal, True), (StringIO, False)])
def test_progress_is_not_printed_if_quiet_or_soon_over(stream, quiet):
    with redirect_stderr(stream()) as shown, progress_line("looking", quiet=quiet) as tell:
        tell(1, 3)
    assert shown.getvalue() == ""


def test_progress_without_terminal_is_a_line_each_half_minute(monkeypatch):
    clock = [0.0]
    monkeypatch.setattr("cardan.cli.common.monotonic", lambda: clock[0])
    with redirect_stderr(StringIO()) as shown, progress_line("looking") as tell:
        for done, clock[0] in enumerate((10, 29, 31, 45, 62), 1):
            tell(done, 8)
    assert shown.getvalue() == "looking: 3/8, 0:31 / ~1:23\nlooking: 5/8, 1:02 / ~1:39\n"


def test_interrupted_run_says_how_far_it_came():
    def stop():
        with progress_line("looking") as tell:
            tell(2, 7)
            raise KeyboardInterrupt

    with redirect_stderr(Terminal()) as shown, pytest.raises(KeyboardInterrupt):
        stop()
    assert "looking: 2/7\n" in shown.getvalue()


@pytest.mark.slow
def test_searches_report_progress():
    application = reader.read(EXAMPLES / "tandem-6x4.yaml")
    told: list[tuple[int, int]] = []
    analyse_vibration(application, tell=lambda _, *at: told.append(at))
    assert told == [(k, 4) for k in range(4)]
    told.clear()
    find_corrections(
        reader.loads(templates.template_text("small")), count=1, tell=lambda *at: told.append(at)
    )
    count = told[0][1]
    assert count > 1
    assert told == [(k, count) for k in range(count)]


# --------------------------------------------------------------------------- fix, and all studies

SHAKEN = yaml.safe_load(templates.template_text("truck")) | {"torsion": {"axle_inertia_kgm2": 1.4}}
GROWS = {"quantity": "torsional_growth", "unit": "1/s", "maximum": -100, "source": "made up"}
FATIGUE = {"quantity": "fatigue_life", "unit": "h", "maximum": 5, "source": "made up"}
SHAKES = {"quantity": "torsional_acceleration", "unit": "rad/s2", "maximum": 150, "source": "us"}


@pytest.mark.parametrize(
    ("row", "verdict"),
    [
        pytest.param(GROWS, "fail", marks=pytest.mark.long),
        pytest.param(FATIGUE | {"required": True}, "incomplete", marks=pytest.mark.slow),
        pytest.param(FATIGUE, "warn", marks=pytest.mark.long),
    ],
)
def test_proposal_is_checked_against_every_study_of_check(row, verdict, tmp_path):
    """It promised "pass" where a check of the file so changed failed or was incomplete."""
    file = written(tmp_path, yaml.safe_dump(SHAKEN | {"limits": [SHAKES, row]}))
    document = tmp_path / "fix.json"
    result = run("fix", "--json", document, file)
    first, *_ = json.loads(document.read_text(encoding="utf-8"))
    assert (first["verdict"], result.exit_code) == (verdict, 0 if verdict == "warn" else 1)
    assert any(c["quantity"].startswith("torsional_r") for c in first["checks"]) == (row != GROWS)
    said = " ".join(result.stdout.split())
    assert ("still exceeded: Growth of torsional vibration" in said) == (verdict == "fail")
    assert ("required, input missing: a campaign" in said) == (verdict == "incomplete")


@pytest.mark.slow
def test_proposal_equals_check_of_file_changed_accordingly():
    """Points, slopes and phases as the correction leaves them, written into the file again."""
    text = SHAKEN | {"adjust": {"bearing_height_mm": {1: [-20, 30]}, "shim_deg": [-3, 3]}}
    text["limits"] = [SHAKES, GROWS]
    application = reader.loads(yaml.safe_dump(text))
    (proposal, *_) = [p for p in find_corrections(application) if len(p.adjustments) == 2]
    moved = proposal.approval.application.lines[0].layout
    line = text["driveline"] = dict(text["driveline"])
    line["points_mm"] = (moved.points * 1e3).tolist()
    line["pinion_slope"] = {
        "side_deg": float(np.degrees(moved.side[-1])), "top_deg": float(np.degrees(moved.top[-1])),
    }  # fmt: skip
    x, z = proposal.approval.application.lines[0].axle.pinion_joint
    text["axle"] = text["axle"] | {"pinion": {"ahead_mm": -1e3 * x, "above_mm": 1e3 * z}}
    found = approve_application(reader.loads(yaml.safe_dump(text)))
    told = {(c.quantity, c.when, c.part): c.value for c in proposal.checks}
    assert told == pytest.approx(
        {(c.quantity, c.when, c.part): c.value for c in found.checks}, rel=1e-6
    )


@pytest.mark.slow
def test_proposals_have_larger_margin_than_installed_state(tmp_path):
    """The first proposal for a truck that passed was a yoke turned, for less margin."""
    text = {k: v for k, v in SHAKEN.items() if k != "torsion"}
    limits = [SHAKES | {"maximum": 1500}]
    found = json.loads(
        run("fix", "--json", "-", written(tmp_path, yaml.safe_dump(text | {"limits": limits})))
        .stdout
    )  # fmt: skip
    assert found
    assert all(p["margin"] > p["margin_before"] for p in found)


def test_fix_exit_code_equals_check_if_nothing_is_adjustable(tmp_path):
    held = "adjust: {shim_deg: [-4, 4], hold: [shim]}\n"
    for text, code in ((SMALL, 0), (SMALL.replace("[4.0, 2.0, 4.0]", "[4.0, 2.0, 7.5]"), 1)):
        file = written(tmp_path, text.replace("2500", "3600") + held)
        assert run("check", "-q", file).exit_code == run("fix", file).exit_code == code


@pytest.mark.slow
def test_fix_explains_why_single_correction_is_not_proposed():
    """The van's shim answers its joint angle, and passes what another joint may accelerate by."""
    said = " ".join(run("fix", "--all", EXAMPLES / "van.yaml").stdout.split())
    assert said.startswith("Nothing that may be moved, within `adjust`")
    assert (
        "pinion angle +1° (shim) gives 2.518, but then exceeded: Single-joint acceleration" in said
    )
    told = " ".join(run("check", "--moves", EXAMPLES / "van.yaml").stdout.split())
    assert (
        "pinion angle +1° (shim) gives 2.518, but then exceeded: Single-joint acceleration" in told
    )


@pytest.mark.slow
@pytest.mark.long
def test_proposal_lists_checks_that_it_makes_fail():
    said = " ".join(
        run("fix", "--all", "--count", "2", EXAMPLES / "refuse-collector-6x2.yaml").stdout.split()
    )
    assert "but then exceeded: Single-joint acceleration, joint 4 in empty" in said
    assert "still exceeded: Inertia acceleration, overrun" in said
    assert "still exceeded: Single-joint acceleration" not in said


@pytest.mark.slow
def test_fix_proposes_nothing_that_exceeds_more_criteria_than_as_installed():
    """A shim of -1 deg was listed: it had 4 criteria exceeded where 3 are as installed."""
    said = " ".join(run("fix", "--all", EXAMPLES / "tandem-6x4.yaml").stdout.split())
    assert said.startswith("Nothing that may be moved, within `adjust`")


@pytest.mark.parametrize(
    ("code", "said"), [("pt_BR.UTF-8", "foi gravado"), ("it_IT", "è stato scritto")]
)
def test_new_says_that_it_wrote_in_language_of_locale(tmp_path, code, said):
    done = CliRunner().invoke(cli, ["new", str(tmp_path / "a.yaml")], env={"LC_ALL": code})
    assert done.exit_code == 0
    assert said in done.stdout
