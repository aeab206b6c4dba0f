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

from cardan import __version__, files
from cardan.base.errors import DesignError
from cardan.base.source import DERIVED
from cardan.cli import cli
from cardan.cli.common import progress
from cardan.quantity.quantities import QUANTITIES
from cardan.study.approval import approve
from cardan.study.fix import fix
from cardan.study.published import Published, published
from cardan.study.stability import stability

EXAMPLES = Path(__file__).parents[2] / "examples"
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


def test_check_says_the_verdict_first_and_every_number_after(small):
    result = run("check", "--states", small)
    first, *_ = result.stdout.splitlines()
    assert re.fullmatch(r"One shaft: PASS \(0 fail, 0 warn, [1-9]\d+ pass\)", first)
    assert "limits: protractor" in result.stdout
    assert "Torsional equivalent angle" in result.stdout
    assert "(AE-7)" in result.stdout
    assert result.stderr == ""
    assert result.exit_code == 0


def test_check_names_what_has_no_answer_for_want_of_data(tmp_path):
    """Held against a truck's profile the same file is no pass: half of it is not answered."""
    result = run("check", written(tmp_path, SMALL.replace("protractor", "heavy-truck")))
    assert result.exit_code == 1
    assert result.stdout.startswith("One shaft: INCOMPLETE")
    open_ends = result.stdout[result.stdout.index("Without an answer") :]
    said = re.sub(r"\n {3,}", " ", open_ends).splitlines()  # a line that goes on is one
    assert any("elastic limit" in x and "required, and needs a joint size" in x for x in said)
    assert any("Needle bearing life" in x and "needs duty" in x for x in said)
    assert not any("Clearance" in x for x in said)  # nothing is in the way
    assert not any("Centre bearing" in x for x in said)  # one shaft has none


def test_colours_are_for_terminals_alone(small):
    assert "\x1b" not in run("check", small).stdout
    coloured = CliRunner().invoke(cli, ["check", str(small)], color=True)
    assert "\x1b[32mPASS\x1b[0m" in coloured.stdout


@pytest.mark.parametrize(
    ("speed", "slope", "word", "code"),
    [
        (2500, 3.5, "PASS", 0),
        (2500, 2.8, "WARN", 0),  # its needles hardly roll
        (13000, 3.5, "FAIL", 1),
        (0, 3.5, "INCOMPLETE", 1),
    ],
)
def test_the_exit_code_is_the_verdict(tmp_path, speed, slope, word, code):
    text = SMALL.replace("2500", str(speed)).replace("4.0", str(slope))
    file = written(tmp_path, text)
    result = run("check", "--quiet", file)
    assert result.stdout.startswith(f"One shaft: {word} (")
    assert result.exit_code == code


def test_several_files_end_as_the_worst_of_them(tmp_path):
    good = written(tmp_path, SMALL, "good.yaml")
    bad = written(tmp_path, SMALL.replace("2500", "13000"), "bad.yaml")
    for files_, code in (((good, good), 0), ((good, bad), 1), ((bad, good), 1)):
        assert run("check", "-q", *files_).exit_code == code


@pytest.mark.slow
def test_another_study_counts_in_the_same_verdict(tmp_path):
    """Its checks stand among the others; what was asked is not among what was not."""
    file, out = written(tmp_path, files.starter("truck")), tmp_path / "out.json"
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
    assert "Not part of this verdict" not in shown
    assert "Not part of this verdict" in alone


def test_a_bracket_that_is_not_there_is_asked_for_all_the_same(small):
    for options in (("--bracket",), ("--with", "bracket")):
        shown = run("check", *options, small).stdout
        assert "bracket could not be asked: bracket, with a shape" in shown


def test_a_page_bears_the_print_of_its_file(small, tmp_path):
    out = tmp_path / "page.html"
    assert run("check", "-q", "--html", out, small).exit_code == 0
    assert hashlib.sha256(small.read_bytes()).hexdigest()[:16] in out.read_text("utf-8")


def test_quiet_says_the_verdict_alone(small):
    assert len(run("check", "-q", small).stdout.splitlines()) == 1
    # What is read by a program holds the verdict, and ends where it ends.
    assert json.loads(run("check", "-q", "--json", "-", small).stdout)["verdict"]


@pytest.mark.slow
def test_all_has_a_row_for_each_check_and_without_it_each_limit_has_one():
    file = EXAMPLES / "refuse-collector-6x2.yaml"
    checks = json.loads(run("check", "--json", "-", file).stdout)["checks"]

    def rows(*options: str) -> list[str]:
        lines = run("check", *options, file).stdout.splitlines()
        return [x for x in lines if x.startswith(("pass  ", "warn  ", "fail  "))]

    assert len(rows("--all")) == len(checks)
    limits = {(c["quantity"], c["source"], c["sense"]) for c in checks}
    bad = {(c["quantity"], c["source"], c["sense"]) for c in checks if c["verdict"] != "pass"}
    assert len(rows()) == len(bad)
    said = run("check", file).stdout
    assert f"{len(limits) - len(bad)} more limits pass" in said
    assert "Speed and strength" not in said
    assert "Speed and strength" in run("check", "--states", file).stdout
    grades = [row[:4] for row in rows("--all")]
    assert grades == sorted(grades, key=["fail", "warn", "pass"].index)


@pytest.mark.slow
@pytest.mark.parametrize("wide", [80, 120])
@pytest.mark.parametrize("options", [(), ("--all",), ("--lang", "it"), ("--states",)])
def test_a_check_fits_the_terminal_and_cuts_nothing(wide, options, monkeypatch):
    monkeypatch.setenv("COLUMNS", str(wide))
    shown = run("check", *options, EXAMPLES / "refuse-collector-6x2.yaml").stdout
    assert max(map(len, shown.splitlines())) <= wide
    assert "…" not in shown
    # A number stands in one line with what it counts.
    assert not re.search(r"(joint|shaft|bearing|giunto|albero|supporto)\n\s*\d", shown)


def test_nobody_s_colours_are_forced_on_them(small, monkeypatch):
    runner = CliRunner()
    for name, value, coloured in (("NO_COLOR", "1", False), ("FORCE_COLOR", "1", True)):
        monkeypatch.delenv("NO_COLOR", raising=False)
        monkeypatch.setenv("TERM", "xterm")
        monkeypatch.setenv(name, value)
        shown = runner.invoke(cli, ["check", "-q", str(small)], color=name == "NO_COLOR").output
        assert ("\x1b" in shown) == coloured


def test_json_goes_to_standard_output_and_nothing_else_with_it(small):
    result = run("check", small, "--json")
    document = json.loads(result.stdout)
    assert document["application"] == "One shaft"
    assert document["verdict"] == "pass"
    assert document["cardan"] == ".".join(__version__.split(".")[:2])
    assert result.exit_code == 0


def test_json_goes_into_a_file_beside_the_table(small, tmp_path):
    out = tmp_path / "out.json"
    result = run("check", "--json", out, small)
    assert result.stdout.startswith("One shaft: PASS")
    assert json.loads(out.read_text(encoding="utf-8")) == json.loads(
        run("check", "--json", "-", small).stdout
    )
    assert run("check", "--json", out, "-q", small).exit_code == 0  # and again, over the old one


def test_limits_takes_another_profile_for_once(small):
    document = json.loads(run("check", "--limits", "elbe", "--json", "-", small).stdout)
    assert document["profile"] == "elbe"
    assert {c["quantity"] for c in document["checks"]} >= {"irregularity"}


def test_limits_takes_a_profile_of_ones_own(small, tmp_path):
    own = written(
        tmp_path,
        "profile: ours\nlimits: [{quantity: joint_angle, unit: deg, maximum: 1.5, source: us}]\n",
        "ours.yaml",
    )
    result = run("check", "--limits", own, "--json", "-", small)
    document = json.loads(result.stdout)
    assert document["profile"] == "ours"
    assert [(c["part"], c["verdict"], c["source"]) for c in document["checks"]] == [
        ("joint 1", "fail", "us"),
        ("joint 2", "fail", "us"),
    ]
    assert result.exit_code == 1


def test_check_asks_neither_scipy_nor_matplotlib_to_come():
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


def test_the_program_runs_as_it_is_installed(small):
    script = Path(sys.executable).with_name("cardan")
    result = subprocess.run([script, "check", "-q", small], capture_output=True, check=True)
    assert result.stdout.startswith(b"One shaft: PASS (")


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
        SMALL.replace("100x3", "100x33"),
        ":6:36: driveline.shafts[1].tube: no catalogue has a tube 100x33; did you mean 100x3?",
    ),
    "a tab": (SMALL.replace("  slopes", "\tslopes"), ":5:1: a tab indents this line"),
    "nothing": ("", ":1:1: the file is empty; `cardan new` writes one to start from"),
}


@pytest.mark.parametrize("kind", WRONG)
def test_a_wrong_file_is_refused_with_its_place_and_what_to_do(tmp_path, kind):
    text, message = WRONG[kind]
    file = written(tmp_path, text)
    result = run("check", file)
    assert result.exit_code == 2
    assert result.stdout == ""
    assert f"error: {file}:" in result.stderr
    assert message in result.stderr


def test_everything_wrong_in_a_file_is_said_at_once(tmp_path):
    text = SMALL.replace("speed_rpm", "sped_rpm").replace("3000", "no").replace("100x3", "x")
    lines = run("check", written(tmp_path, text)).stderr.splitlines()
    assert len(lines) == 3
    assert all(line.startswith("error: ") for line in lines)


def test_what_only_looks_wrong_is_a_warning_and_the_check_goes_on(tmp_path):
    file = written(tmp_path, SMALL.replace("[4.0, 2.0, 4.0]", "[0.07, 0.035, 0.07]"))
    result = run("check", "--json", "-", file)
    assert result.stderr.startswith(f"warning: {file}:5:")
    assert "slopes.side_rad" in result.stderr or "side_rad" in result.stderr
    assert json.loads(result.stdout)["application"] == "One shaft"


@pytest.mark.parametrize("command", ["check", "fix"])
def test_a_file_that_is_not_there_is_refused_with_those_that_are(command, small):
    result = run(command, small.with_name("aplication.yaml"))
    assert result.exit_code == 2
    assert "cannot be read" in result.stderr
    assert f"did you mean {small}?" in result.stderr


def test_a_profile_nobody_knows_is_refused_with_the_nearest(small):
    result = run("check", "--limits", "heavytruck", small)
    assert result.exit_code == 2
    assert "did you mean heavy-truck?" in result.stderr


def test_a_design_that_cannot_be_is_refused_with_the_reason(tmp_path):
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


def test_fix_proposes_what_a_check_of_the_file_so_changed_confirms(tmp_path):
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
    assert run("check", "-q", written(tmp_path, changed)).stdout.startswith("One shaft: PASS")


def test_fix_says_what_to_move_in_a_workshops_words(tmp_path):
    text = SMALL.replace("[4.0, 2.0, 4.0]", "[4.0, 2.0, 7.5]").replace("2500", "3600")
    result = run("fix", written(tmp_path, text + "adjust: {shim_deg: [-4, 4]}\n"))
    assert "pinion nose down" in result.stdout
    said = next(line for line in result.stdout.splitlines() if line.startswith("1. PASS, "))
    down = float(result.stdout.split("pinion nose down ")[1].split(" deg")[0])
    changed = written(tmp_path, text.replace("7.5]", f"{7.5 - down}]"))
    assert said.removeprefix("1. PASS, ").partition(",")[0] in run("check", changed).stdout


def test_fix_leaves_in_place_what_is_held(tmp_path):
    text = SMALL.replace("[4.0, 2.0, 4.0]", "[4.0, 2.0, 7.5]").replace("2500", "3600")
    file = written(tmp_path, text + "adjust: {shim_deg: [-4, 4]}\n")
    result = run("fix", "--hold", "shim", file)
    assert result.stdout.startswith("Nothing that may be moved, within `adjust`")
    assert result.exit_code == 1


def test_fix_ends_well_only_where_a_proposal_leaves_no_question(tmp_path):
    """The shim mends what fails, but nobody can say whether the joints carry the torque."""
    text = SMALL.replace("[4.0, 2.0, 4.0]", "[4.0, 2.0, 7.5]").replace("2500", "3600")
    text += "adjust: {shim_deg: [-4, 4]}\n"
    limits = "limits: {profile: protractor, overrides: [{quantity: joint_torque_utilisation, "
    open_ = text.replace("limits: protractor", limits + "maximum: 1, required: true, source: us}]}")
    for file, verdict, code in ((text, "pass", 0), (open_, "incomplete", 1)):
        result = run("fix", "--json", "-", written(tmp_path, file))
        best, *_ = json.loads(result.stdout)
        assert (best["verdict"], result.exit_code) == (verdict, code)


@pytest.mark.parametrize("steps", ["", ", steps: {shim_deg: 0.01}"])
def test_fix_moves_down_where_only_down_is_allowed(tmp_path, steps):
    """By half degrees, which are all asked, and by so small steps that it is searched."""
    text = SMALL.replace("[4.0, 2.0, 4.0]", "[4.0, 2.0, 7.5]").replace("2500", "3600")
    file = written(tmp_path, text + f"adjust: {{shim_deg: [-4, 0]{steps}}}\n")
    found = json.loads(run("fix", "--json", "-", file).stdout)
    assert found[0]["verdict"] == "pass"
    amounts = [m["amount_deg"] for p in found for m in p["moves"]]
    assert all(-4 <= a < 0 for a in amounts)


def test_fix_goes_to_the_end_of_a_range_that_is_no_whole_step(tmp_path):
    """Whoever allows 0.8 deg down has a wedge of 0.8 deg, whatever others are made in."""
    text = SMALL.replace("[4.0, 2.0, 4.0]", "[4.0, 2.0, 7.5]").replace("2500", "3600")
    file = written(tmp_path, text + "adjust: {shim_deg: [-0.8, 0.2]}\n")
    found = json.loads(run("fix", "--json", "-", file).stdout)
    assert max(m["amount_deg"] for p in found for m in p["moves"]) < 0
    assert min(m["amount_deg"] for p in found for m in p["moves"]) == pytest.approx(-0.8)


def test_fix_leaves_in_place_what_the_file_holds(tmp_path):
    text = SMALL.replace("[4.0, 2.0, 4.0]", "[4.0, 2.0, 7.5]").replace("2500", "3600")
    file = written(tmp_path, text + "adjust: {shim_deg: [-4, 4], hold: [shim]}\n")
    result = run("fix", file)
    assert result.stdout.startswith("Nothing that may be moved, within `adjust`")
    assert result.exit_code == 1


@pytest.mark.slow
def test_fix_gives_as_many_proposals_as_are_wanted():
    file = EXAMPLES / "three-joint-chain.yaml"
    assert len(json.loads(run("fix", "--count", 2, "--json", "-", file).stdout)) == 2


def test_fix_refuses_a_line_that_is_not_there(small):
    result = run("fix", "--line", "front", small)
    assert result.exit_code == 2
    assert result.stderr == f"error: {small}: there is no line front; the application has main\n"


# --------------------------------------------------------------------------- the others


def test_explain_lists_every_quantity():
    lines = run("explain").stdout.splitlines()
    assert [line.split()[0] for line in lines] == list(QUANTITIES)


@pytest.mark.parametrize("key", QUANTITIES)
def test_explain_says_of_a_quantity_what_it_is_and_who_says_so(key):
    q = QUANTITIES[key]
    result = run("explain", key)
    assert result.exit_code == 0
    shown = " ".join(result.stdout.split())  # wherever lines end
    for said in (q.name, q.symbol, q.stated, str(q.source), *q.where, *q.where.values()):
        assert " ".join(said.split()) in shown


@pytest.mark.parametrize("word", ["Torsional acceleration", "aceleração torcional"])
def test_explain_knows_a_quantity_by_its_name_in_any_language(word):
    assert run("explain", word).stdout == run("explain", "torsional_acceleration").stdout


@pytest.mark.parametrize(
    ("word", "meant"),
    [
        ("clearence", "did you mean clearance?"),
        ("torsional", "equivalent_angle or torsional_acceleration or torsional_resonance?"),
        ("zzz", "there is no quantity zzz ("),
    ],
)
def test_explain_refuses_a_misspelt_quantity_with_the_nearest(word, meant):
    result = run("explain", word)
    assert result.exit_code == 2
    assert meant in result.stderr
    assert result.stdout == ""


def test_verify_recomputes_published_cases_and_they_agree():
    result = run("verify")
    assert result.exit_code == 0
    assert "WRONG" not in result.stdout
    cases = json.loads(run("verify", "--json").stdout)
    shown = " ".join(result.stdout.split())  # wherever lines end
    assert result.stdout.count("\nok    ") == len(cases) >= 30
    for case in cases:
        assert abs(case["computed"] - case["published"]) <= case["within"]
        assert case["source"] in shown


def test_verify_stands_on_many_sources_and_tells_what_is_derived():
    cases = published()
    citable = [c for c in cases if c.kind == "published"]
    assert len(citable) >= 60
    assert len({c.source.title for c in citable}) >= 15
    assert len({(c.title, c.source) for c in cases}) == len(cases)  # none twice
    kinds = [c.kind for c in cases]
    assert kinds == sorted(kinds, key=("published", "untraced", "derived").index)
    for case in cases:
        own = case.source.title.startswith(("Derived", "AISCO's life formula"))
        assert not own or case.kind == "derived"


def test_a_published_number_is_met_to_its_last_digit_or_not_at_all():
    """Printed 12.3, so 12.25 to 12.35; what is no number is not met."""
    case = Published(title="", source=DERIVED, expected=12.3, computed=12.34, within=0.05)
    assert case.agrees
    for computed in (12.36, 12.24, float("nan")):
        assert not replace(case, computed=computed).agrees


def test_schema_is_a_json_schema_that_the_examples_and_starters_fit(tmp_path):
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


def test_schema_goes_into_a_file_and_never_over_one_unasked(tmp_path):
    out = tmp_path / "cardan.schema.json"
    assert run("schema", "--out", out).exit_code == 0
    assert out.read_text(encoding="utf-8") == run("schema").stdout
    assert run("schema", "--out", out).exit_code == 2
    assert run("schema", "--out", out, "--force").exit_code == 0


@pytest.mark.parametrize("kind", ["small", "truck"])
def test_new_writes_a_file_that_checks_without_complaint(tmp_path, kind):
    file = tmp_path / "mine.yaml"
    result = run("new", "--kind", kind, file)
    assert result.exit_code == 0
    assert "cardan check" in result.stdout
    checked = run("check", "--quiet", file)
    assert checked.exit_code == 0
    assert checked.stderr == ""


def test_new_never_replaces_a_file_unasked(tmp_path):
    file = written(tmp_path, "my work\n")
    result = run("new", file)
    assert result.exit_code == 2
    assert f"error: {file}: is there already" in result.stderr
    assert file.read_text(encoding="utf-8") == "my work\n"
    assert run("new", "--force", file).exit_code == 0
    assert "title:" in file.read_text(encoding="utf-8")


def test_version_is_that_of_the_package():
    assert run("--version").stdout == f"cardan, version {__version__}\n"


@pytest.mark.parametrize("command", [(), ("check",), ("fix",), ("explain",), ("verify",),
                                     ("schema",), ("new",)])  # fmt: skip
def test_help_is_there_for_every_command(command):
    result = run(*command, "--help")
    assert result.exit_code == 0
    assert "Usage:" in result.stdout


# --------------------------------------------------------------------------- what is refused late


@pytest.mark.parametrize("command", ["fix", "stability"])
def test_a_part_that_cannot_follow_is_named_with_its_file(tmp_path, command):
    """Only the check finds out that a link is too short for the travel."""
    text = files.starter("truck").replace("front_half_length_mm: 760", "front_half_length_mm: 60")
    file = written(tmp_path, text, "short.yaml")
    result = run(command, file)
    assert result.exit_code == 2
    assert f"error: {file}:46:3: suspension.linkage: a link of radius 45 mm" in result.stderr


def test_which_of_several_files_is_named(tmp_path, small):
    text = files.starter("truck").replace("front_half_length_mm: 760", "front_half_length_mm: 60")
    file = written(tmp_path, text, "short.yaml")
    assert f"error: {file}:46:3: suspension.linkage: a link" in run("check", small, file).stderr


# --------------------------------------------------------------------------- progress


class Terminal(StringIO):
    """Somebody looks at it."""

    def isatty(self) -> bool:
        return True


def test_progress_is_one_line_that_is_wiped():
    with redirect_stderr(Terminal()) as shown, progress("looking") as tell:
        tell(1, 3)
        tell(2, 3)
    wipe = "\r\033[K"
    assert shown.getvalue() == "".join(
        wipe + said for said in ("looking", "looking: 1/3", "looking: 2/3", "")
    )


def test_progress_is_wiped_before_an_error_is_said():
    with (
        redirect_stderr(Terminal()) as shown,
        pytest.raises(DesignError),
        progress("looking"),
    ):
        raise DesignError
    assert shown.getvalue().endswith("looking\r\033[K")


@pytest.mark.parametrize(("stream", "quiet"), [(Terminal, True), (StringIO, False)])
def test_no_progress_where_nobody_wants_it_or_looks(stream, quiet):
    with redirect_stderr(stream()) as shown, progress("looking", quiet=quiet) as tell:
        tell(1, 3)
    assert shown.getvalue() == ""


@pytest.mark.slow
def test_searches_tell_how_far_they_are():
    application = files.read(EXAMPLES / "tandem-6x4.yaml")
    told: list[tuple[int, int]] = []
    stability(application, tell=lambda _, *at: told.append(at))
    assert told == [(k, 4) for k in range(4)]
    told.clear()
    fix(files.loads(files.starter("small")), count=1, tell=lambda *at: told.append(at))
    count = told[0][1]
    assert count > 1
    assert told == [(k, count) for k in range(count)]


# --------------------------------------------------------------------------- fix, and all studies

SHAKEN = yaml.safe_load(files.starter("truck")) | {"torsion": {"axle_inertia_kgm2": 1.4}}
GROWS = {"quantity": "torsional_growth", "unit": "1/s", "maximum": -100, "source": "made up"}
FATIGUE = {"quantity": "fatigue_life", "unit": "h", "maximum": 5, "source": "made up"}
SHAKES = {"quantity": "torsional_acceleration", "unit": "rad/s2", "maximum": 150, "source": "us"}


@pytest.mark.slow
@pytest.mark.parametrize(
    ("row", "verdict"),
    [(GROWS, "fail"), (FATIGUE | {"required": True}, "incomplete"), (FATIGUE, "warn")],
)
def test_a_proposal_is_held_to_every_study_that_a_check_asks(row, verdict, tmp_path):
    """It promised "pass" where a check of the file so changed failed or was incomplete."""
    file = written(tmp_path, yaml.safe_dump(SHAKEN | {"limits": [SHAKES, row]}))
    document = tmp_path / "fix.json"
    result = run("fix", "--json", document, file)
    first, *_ = json.loads(document.read_text(encoding="utf-8"))
    assert (first["verdict"], result.exit_code) == (verdict, 0 if verdict == "warn" else 1)
    assert any(c["quantity"].startswith("torsional_r") for c in first["checks"]) == (row != GROWS)
    said = " ".join(result.stdout.split())
    assert ("still fail: Growth of torsional vibration" in said) == (verdict == "fail")
    assert ("required, and needs a campaign" in said) == (verdict == "incomplete")


@pytest.mark.slow
def test_the_file_changed_as_proposed_gives_what_is_proposed():
    """Points, slopes and phases as the correction leaves them, written into the file again."""
    text = SHAKEN | {"adjust": {"bearing_height_mm": {1: [-20, 30]}, "shim_deg": [-3, 3]}}
    text["limits"] = [SHAKES, GROWS]
    application = files.loads(yaml.safe_dump(text))
    (proposal, *_) = [p for p in fix(application) if len(p.moves) == 2]
    moved = proposal.approval.application.lines[0].layout
    line = text["driveline"] = dict(text["driveline"])
    line["points_mm"] = (moved.points * 1e3).tolist()
    line["pinion_slope"] = {
        "side_deg": float(np.degrees(moved.side[-1])), "top_deg": float(np.degrees(moved.top[-1])),
    }  # fmt: skip
    x, z = proposal.approval.application.lines[0].axle.pinion_joint
    text["axle"] = text["axle"] | {"pinion": {"ahead_mm": -1e3 * x, "above_mm": 1e3 * z}}
    found = approve(files.loads(yaml.safe_dump(text)))
    told = {(c.quantity, c.when, c.part): c.value for c in proposal.checks}
    assert told == pytest.approx(
        {(c.quantity, c.when, c.part): c.value for c in found.checks}, rel=1e-6
    )


@pytest.mark.slow
def test_nothing_worse_than_what_is_installed_is_proposed(tmp_path):
    """The first proposal for a truck that passed was a yoke turned, for less margin."""
    text = {k: v for k, v in SHAKEN.items() if k != "torsion"}
    limits = [SHAKES | {"maximum": 1500}]
    found = json.loads(
        run("fix", "--json", "-", written(tmp_path, yaml.safe_dump(text | {"limits": limits})))
        .stdout
    )  # fmt: skip
    assert found
    assert all(p["margin"] > p["margin_before"] for p in found)


def test_fix_ends_as_a_check_does_where_nothing_is_to_be_moved(tmp_path):
    held = "adjust: {shim_deg: [-4, 4], hold: [shim]}\n"
    for text, code in ((SMALL, 0), (SMALL.replace("[4.0, 2.0, 4.0]", "[4.0, 2.0, 7.5]"), 1)):
        file = written(tmp_path, text.replace("2500", "3600") + held)
        assert run("check", "-q", file).exit_code == run("fix", file).exit_code == code


def test_fix_says_why_nothing_is_proposed_where_a_move_would_help():
    """The van's shim answers its joint angle, and passes what another joint may accelerate by."""
    said = " ".join(run("fix", EXAMPLES / "van.yaml").stdout.split())
    assert said.startswith("Nothing that may be moved, within `adjust`")
    assert "pinion nose up 1 deg gives 2.518, but then fail: Acceleration of a joint" in said
    told = " ".join(run("check", EXAMPLES / "van.yaml").stdout.split())
    assert "pinion nose up 1 deg gives 2.518, but then fail: Acceleration of a joint" in told


@pytest.mark.slow
def test_a_proposal_tells_what_it_spoils():
    said = " ".join(
        run("fix", "--count", "2", EXAMPLES / "refuse-collector-6x2.yaml").stdout.split()
    )
    assert "but then fail: Acceleration of a joint by itself, joint 4 in empty" in said
    assert "still fail: Inertia acceleration, coast" in said
    assert "still fail: Acceleration of a joint by itself" not in said


@pytest.mark.slow
def test_a_proposal_names_the_line_of_what_is_left():
    """In a vehicle of several lines what still warns may be of another one."""
    said = run("fix", EXAMPLES / "tandem-6x4.yaml").stdout
    assert re.search(r"still (?:warn|fail): (main|inter-axle|[a-z-]+): ", said)
