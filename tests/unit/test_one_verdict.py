"""One application, one verdict: terminal, JSON, page, document, workbook and exit code.

The refuse collector with room and joint angle as its only limits failed on the screen and
passed in the workbook: of 29 quantities that limits may ask about, 12 never reached it. Here
every one fails once, by a millionth, and every medium has to say so. (`tests/office` has the
same workbooks recomputed by LibreOffice.) What a recording tells fails in the media of
`cardan life`, and a bracket, made up here, in a solver's stresses where there is a solver.
"""

import json
import re
import shutil
import subprocess
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from html import unescape
from pathlib import Path
from unittest.mock import patch
from zipfile import ZipFile

import jsonschema
import numpy as np
import pytest
import yaml
from chief import chief
from click.testing import CliRunner
from one_verdict import (
    ASKED,
    BRACKET,
    GIVEN,
    LITTLE,
    RECORDING,
    Case,
    cases,
    endless,
    equal,
    failing,
    incomplete,
    limit,
    made,
    made_up_bracket,
    passing,
    past,
    put,
    read,
    truck,
    unasked,
    unheard,
    warning,
    worst_of,
)

import cardan
from cardan import files
from cardan.base.errors import DesignError
from cardan.cli import cli
from cardan.quantity.quantities import LIMITABLE, QUANTITIES
from cardan.report import story
from cardan.report.contract_schema import schema as described
from cardan.report.html import page
from cardan.report.language import CODES, Language
from cardan.report.pdf import _told, document
from cardan.report.vibration_chapter import chapter
from cardan.report.workbook import workbook
from cardan.study.approval import Approval, approve
from cardan.study.finding import VIBRATION

EXAMPLES = Path(__file__).parents[2] / "examples"
DRAWN: dict[str, tuple] = {}


def once(name: str, of: Callable[..., tuple], *asked: object) -> tuple:
    if name not in DRAWN:
        DRAWN[name] = of(*asked)
    return DRAWN[name]


@pytest.fixture
def drawn_once(monkeypatch):
    """What takes most of the time says no verdict: pictures of one line stand in for all, and
    nobody looks for corrections."""
    monkeypatch.setattr(story, "fix", lambda *_, **__: ())
    for name in ("drawings", "plots"):
        monkeypatch.setattr(story, name, partial(once, name, getattr(story, name)))


def cached(book: Path) -> str:
    """The verdict that a workbook shows where nothing computes it anew."""
    with ZipFile(book) as file:
        names = file.read("xl/workbook.xml").decode()
        place, cell = re.search(r"""name="verdict">'([^']+)'!\$B\$(\d+)<""", names).groups()
        nth = re.findall(r'<sheet name="([^"]*)"', names).index(place) + 1
        front, inputs = (file.read(f"xl/worksheets/sheet{k}.xml").decode() for k in (1, nth))
    shown = r'<c r="B{}"[^>]*t="str"><f>.*?</f><v>([^<]*)</v>'
    verdict = re.search(shown.format(cell), inputs)[1]
    assert re.search(shown.format(r"\d+"), front)[1] == verdict
    return verdict


def of_story(told: story.Story) -> tuple[str, ...]:
    """The verdict as a story tells it: its headline, and the worst of its table."""
    table = told.chapters[0].blocks[0]
    return told.grade, told.verdict.lower(), table.rows[0][0] if table.rows else ""


def of_page(html: str) -> str:
    grade, word = re.search(r'class="banner (\w+)"><strong>\S+ (\w+)<', unescape(html)).groups()
    assert grade == word.lower()
    return grade


def of_document(pdf: Path) -> str:
    """The verdict as a document has it in print: its headline, and the rows of its table."""
    text = printed(pdf)
    table, _, _ = text.partition("Where the limits come from")
    (word,) = re.findall(r"^ +([A-Z]{4,10})(?: {3,}\S.*)?$", table, re.MULTILINE)
    graded = set(re.findall(r"^ ?(fail|warn) ", table, re.MULTILINE))
    assert graded == {word.lower()} & {"fail", "warn"}
    return word.lower()


def printed(pdf: Path) -> str:
    """The text of a document."""
    run = ["pdftotext", "-layout", pdf.name, "-"]
    return subprocess.run(run, cwd=pdf.parent, capture_output=True, text=True, check=True).stdout


READS_PAPER = bool(shutil.which("pdftotext"))
KINDS = ("json", "html", "xlsx", *["pdf"][:READS_PAPER])


@pytest.mark.skipif(not READS_PAPER, reason="pdftotext of poppler is not installed")
def test_documents_are_read_back(tmp_path):
    """Skipped it says that no document was looked at; and its reader sees what is wrong."""
    path = put(tmp_path, "truck", failing("joint_angle").text)
    told = story.approval(read(path), helps=(), fixes=(), say=Language("en"), issue=story.Issue())
    for verdict, seen in (("FAIL", "fail"), ("PASS", None), ("", None)):
        (tmp_path / "out.pdf").write_bytes(document(replace(told, verdict=verdict)))
        if seen:
            assert of_document(tmp_path / "out.pdf") == seen
        else:
            with pytest.raises((AssertionError, ValueError)):
                of_document(tmp_path / "out.pdf")


def said(case: Case, folder: Path, *asked: str) -> dict[str, object]:
    """What every medium of `cardan check` says of an application."""
    path = put(folder, case.name, case.text)
    outs = {kind: folder / f"{case.name}.{kind}" for kind in KINDS}
    options = [word for kind, out in outs.items() for word in (f"--{kind}", str(out))]
    options += ["--with", "bracket"] if case.hangs else asked
    run = CliRunner().invoke(cli, ["check", str(path), *options], catch_exceptions=False)
    contract = json.loads(outs["json"].read_text(encoding="utf-8"))
    html = outs["html"].read_text(encoding="utf-8")
    return {
        "exit": run.exit_code,
        "terminal": of_terminal(run.stdout),
        "json": contract["verdict"],
        "checks": graded(contract),
        "html": of_page(html),
        "xlsx": cached(outs["xlsx"]),
        **({"pdf": of_document(outs["pdf"])} if READS_PAPER else {}),
    }


def of_terminal(text: str) -> str:
    return re.search(r"^[^\n]*: ([A-Z]+) \(", text, re.MULTILINE)[1].lower()


def graded(contract: dict) -> set[str]:
    """What checks come to that do not pass."""
    return {c["verdict"] for c in contract["checks"]} - {"pass"}


def held(found: dict[str, object], verdict: str) -> None:
    """Hold what media say to one verdict, and the exit code with it."""
    assert found.pop("exit") == (1 if verdict in ("fail", "incomplete") else 0)
    assert found.pop("checks") == {verdict} & {"fail", "warn"}
    assert found == dict.fromkeys(found, verdict)


def test_every_quantity_that_can_be_limited_fails_somewhere_here():
    """A quantity of a further study has no medium yet that is asked about it."""
    assert sorted([*ASKED, *RECORDING]) == sorted(LIMITABLE)
    assert {case.quantity for case in cases() if case.verdict == "fail"} == set(ASKED)


OF_EACH_KIND = (
    "torque", "axle_load", "joint_angle_min", "clearance", "centre_bearing_dynamic",
    "critical_speed_ratio", "half_critical_band", "resonance_distance", "joint_life",
    "spline_travel_margin", "torsional_resonance", "launch_reversal",
    "bracket_stress_utilisation",
)  # fmt: skip


@pytest.mark.slow
@pytest.mark.parametrize("quantity", chief(ASKED, *OF_EACH_KIND))
@pytest.mark.usefixtures("drawn_once")
def test_what_fails_by_a_millionth_fails_in_every_medium(quantity, tmp_path, monkeypatch):
    monkeypatch.setattr(story.bracket_chapter, "chapter", lambda *_: iter(()))
    with made_up_bracket():
        held(said(failing(quantity), tmp_path), "fail")


OTHERS = {
    "a warning of the driveline": lambda: warning("torsional_acceleration"),
    "a warning of vibration": lambda: warning("torsional_resonance"),
    "a pass": lambda: passing("torsional_acceleration"),
    "equality": equal,
    "no answer": incomplete,
    "nothing asked": unasked,
    "no end": endless,
    **{f"{q} required of nobody": partial(unheard, q) for q in (*BRACKET, *RECORDING)},
}
FEW = ("a warning of the driveline", "a pass", "no answer", "nothing asked", "no end",
       "bracket_life required of nobody", "fatigue_damage required of nobody")  # fmt: skip


@pytest.mark.parametrize("what", chief(OTHERS, *FEW))
@pytest.mark.usefixtures("drawn_once")
def test_other_verdicts_are_one_in_every_medium_too(what, tmp_path):
    case = OTHERS[what]()
    held(said(case, tmp_path), case.verdict)


TOLD = {"clearance": failing, "torsional_acceleration": warning, "joint_angle": passing,
        "joint_life": lambda _: incomplete(), "torsional_growth": failing}  # fmt: skip


@pytest.mark.parametrize("quantity", TOLD)
@pytest.mark.usefixtures("drawn_once")
def test_the_typesetter_is_told_what_the_story_says(quantity, tmp_path):
    """Where nothing reads documents back this much is known of them."""
    case = TOLD[quantity](quantity)
    found = read(put(tmp_path, case.name, case.text))
    told = story.approval(found, helps=(), fixes=(), say=Language("en"), issue=story.Issue())
    assert of_story(told)[:2] == (case.verdict, case.verdict)
    assert _told(told)[0]["verdict"] == case.verdict.upper()


def test_a_study_that_nobody_asked_has_no_chapter():
    """The medium truck could be asked about vibration, and was not: its report is silent on it."""
    found = approve(files.read(EXAMPLES / "medium-truck-4x2.yaml"))
    assert [(f.study, f.asked) for f in found.findings] == [
        ("driveline", True),
        ("vibration", False),
    ]
    told = story.approval(found, helps=(), fixes=(), say=Language("en"), issue=story.Issue())
    assert "Vibration" not in "".join(c.title for c in told.chapters)


# --------------------------------------------------------------------------- a recording


@pytest.fixture(scope="module")
def recording(tmp_path_factory) -> Path:
    """One gauge, pulled to and fro 7 times a second."""
    path = tmp_path_factory.mktemp("recording") / "drive.csv"
    t = np.arange(4000) / 1000
    rows = [f"{s:.3f},{x:.6f}" for s, x in zip(t, 40 * np.sin(2 * np.pi * 7 * t), strict=True)]
    path.write_text("\n".join(["time,S1 [MPa]", *rows]) + "\n", encoding="utf-8")
    return path


VERDICTS = [("fail", "maximum", LITTLE), ("warn", "normal", LITTLE), ("pass", "maximum", -LITTLE)]
"""What a limit comes to by the bound that lies a little this or that side of a value."""

GAUGE = ("--gauge", "S1", "--sn", "30,2e6,5")
TOLD_OF_A_GAUGE = {"fatigue_life": "hours", "fatigue_damage": "damage"}


def heard(recording: Path, *options: str) -> dict[str, object]:
    """What every medium of `cardan life` says of a recording."""
    out = recording.with_suffix(".json")
    asked = ["life", str(recording), *GAUGE, *options, "--json", str(out)]
    run = CliRunner().invoke(cli, asked, catch_exceptions=False)
    contract = json.loads(out.read_text(encoding="utf-8"))
    named = dict(zip(options[::2], options[1::2], strict=True))
    python = cardan.life(
        recording, gauges=["S1"], sn="30,2e6,5", limits=named.get("--limits"),
        target_hours=float(named["--target-hours"]) if "--target-hours" in named else None,
    )  # fmt: skip
    return {
        "exit": run.exit_code,
        "terminal": of_terminal(run.stdout),
        "json": contract["verdict"],
        "checks": graded(contract),
        "python": python.verdict,
        "notebook": of_terminal(unescape(python._repr_html_())),
    }


def heard_value(recording: Path, quantity: str) -> float:
    run = CliRunner().invoke(cli, ["life", str(recording), *GAUGE, "--json", "-"])
    (gauge,) = json.loads(run.stdout)["gauges"]
    return gauge[TOLD_OF_A_GAUGE[quantity]]


@pytest.mark.parametrize(("verdict", "held_by", "share"), VERDICTS)
@pytest.mark.parametrize("quantity", RECORDING)
def test_what_a_recording_tells_is_one_verdict_in_every_medium(
    recording, tmp_path, quantity, verdict, held_by, share
):
    bound = past(quantity, heard_value(recording, quantity), share)
    rows = {"profile": "ours", "limits": [limit(quantity, **{held_by: bound})]}
    profile = tmp_path / "ours.yaml"
    profile.write_text(yaml.safe_dump(rows), encoding="utf-8")
    held(heard(recording, "--limits", str(profile)), verdict)


@pytest.fixture
def campaign(recording, tmp_path) -> Path:
    """The recording as a campaign that limits nothing of its own."""
    (tmp_path / recording.name).write_bytes(recording.read_bytes())
    path = tmp_path / "campaign.yaml"
    path.write_text(
        f"campaign: One drive\nrecordings: [{{file: {recording.name}}}]\ngauges: [S1]\n"
        "strength: {amplitude_MPa: 30, cycles: 2e6, slope: 5}\n", encoding="utf-8",
    )  # fmt: skip
    return path


@pytest.mark.slow
@pytest.mark.parametrize(("verdict", "held_by", "share"), chief(VERDICTS, VERDICTS[0]))
@pytest.mark.parametrize("quantity", chief(RECORDING, "fatigue_life"))
@pytest.mark.usefixtures("drawn_once")
def test_a_recording_beside_an_application_is_in_its_one_verdict(
    recording, campaign, tmp_path, quantity, verdict, held_by, share
):
    """Its limits are rows of the application like any other."""
    bound = past(quantity, heard_value(recording, quantity), share)
    case = passing("joint_angle")
    text = yaml.safe_load(case.text)
    text["limits"].append(limit(quantity, **{held_by: bound}))
    case = replace(case, text=yaml.safe_dump(text))
    held(said(case, tmp_path, "--recording", str(campaign)), verdict)
    contract = json.loads((tmp_path / f"{case.name}.json").read_text(encoding="utf-8"))
    jsonschema.validate(contract, described())
    assert contract["recording"]["campaign"] == "One drive"
    assert contract["studies"] == ["driveline", "recording"]
    page = (tmp_path / f"{case.name}.html").read_text(encoding="utf-8")
    assert "drive.csv" in page
    found = cardan.check(cardan.read(tmp_path / f"{case.name}.yaml"), recording=campaign)
    assert found.verdict == verdict


def test_a_recording_of_another_design_is_in_no_verdict(campaign, tmp_path):
    """A cured line had passed by what its predecessor's gauges felt."""
    path = put(tmp_path, "truck", passing("joint_angle").text)
    driven = cardan.read(path)
    address, value = next((k, v) for k, v in driven.written.numbers.items() if "wall_mm" in k)
    other = cardan.change(driven, {address: value + 1.0})
    own = f"application: {path.name}\n"
    campaign.write_text(campaign.read_text(encoding="utf-8") + own, encoding="utf-8")
    assert cardan.check(driven, recording=campaign).verdict == "pass"
    with pytest.raises(DesignError, match=r"campaign\.yaml: the recordings are of") as no:
        cardan.check(other, recording=campaign)
    for named in (path.name, address, f"{value:g}", f"{value + 1:g}"):
        assert named in str(no.value)


def test_what_is_wrong_with_a_campaign_is_told_and_nothing_passes(campaign, tmp_path):
    """It passed in silence; and so did a recording that says nothing of its life."""
    path = put(tmp_path, "truck", passing("joint_angle").text)
    good = campaign.read_text(encoding="utf-8")
    campaign.write_text(good.replace("gauges: [S1]", "gauges: [S2]"), encoding="utf-8")
    asked = ["check", str(path), "-q", "--recording", str(campaign)]
    run = CliRunner().invoke(cli, asked)
    assert run.exit_code == 2
    assert "campaign.yaml: drive.csv has no channel 'S2'" in run.output
    campaign.write_text(good, encoding="utf-8")
    assert CliRunner().invoke(cli, asked).exit_code == 0
    file = campaign.parent / "drive.csv"
    rows = file.read_text(encoding="utf-8").splitlines()
    rows[2000] = f"{1.999:.3f},900"  # decides the damage, and nobody said what it was
    file.write_text("\n".join(rows) + "\n", encoding="utf-8")
    run = CliRunner().invoke(cli, asked)
    assert run.exit_code == 1
    assert "INCOMPLETE" in run.output


def test_a_recording_is_of_one_application(campaign):
    two = [str(EXAMPLES / "medium-truck-4x2.yaml")] * 2
    run = CliRunner().invoke(cli, ["check", *two, "--recording", str(campaign)])
    assert run.exit_code == 2
    assert "give one file with --recording" in run.output


def test_a_short_report_has_no_numbers_that_nobody_decides_by(tmp_path):
    path, out = put(tmp_path, "truck", passing("joint_angle").text), tmp_path / "out.html"
    said = {}
    for how in ("--short", "--all"):
        CliRunner().invoke(cli, ["check", str(path), how, "--html", str(out)])
        said[how] = re.findall(r"<h2[^>]*>(.*?)</h2>", out.read_text(encoding="utf-8"))
    assert [t.split()[-1] for t in said["--short"]] == ["Verdict", "Limits", "change", "Approval"]
    assert len(said["--all"]) > len(said["--short"])


def test_a_short_report_has_every_limit_that_does_not_pass():
    found = cardan.check(cardan.read(EXAMPLES / "medium-truck-4x2.yaml"), studies=())
    told = {}
    for short in (True, False):
        table, *_ = story.verdict(found, Language("en"), short=short)
        told[short] = [row[0] for row in table.rows]
    bad = [grade for grade in told[False] if grade != "pass"]
    assert bad
    assert told[True] == [*bad, "pass", "pass", "pass"]


def test_a_target_missed_by_a_millionth_fails_in_every_medium(recording):
    target = past("fatigue_life", heard_value(recording, "fatigue_life"), LITTLE)
    held(heard(recording, "--target-hours", repr(target)), "fail")


# --------------------------------------------------------------------------- a resonance


UNDAMPED = (
    files.starter("truck").replace(
        "  friction: 0.8 ", "  slip_stiffness_kN: 900000\n  friction: 0.8 ", 1
    )
    + "\ntorsion: {damping_ratio: 1.0e-4, axle_inertia_kgm2: 8}\n"
)
"""The truck starter with next to no damping, not even its tyres', and zones among its speeds."""


@pytest.fixture(scope="module")
def undamped() -> Approval:
    """The truck, shaken up where it meets a zone."""
    return approve(files.loads(UNDAMPED))


@pytest.mark.slow
def test_a_line_that_shakes_itself_up_fails_in_headline_and_chapter(undamped, tmp_path):
    """The chapter once had limits of its own: it said WARN under a headline that said FAIL."""
    (vibration,) = [f for f in undamped.findings if f.study == VIBRATION]
    assert "torsional_growth" in {c.quantity for c in vibration.checks if c.grade == "fail"}
    assert undamped.verdict == "fail"
    for code in CODES:
        say = Language(code)
        told = story.approval(undamped, helps=(), fixes=(), say=say, issue=story.Issue())
        (text,) = [b for b in chapter(vibration, say) if hasattr(b, "paragraphs")]
        assert say("fail").upper() in text.paragraphs[0]
        html = unescape(page(told))
        assert told.verdict == say("fail").upper()
        assert text.paragraphs[0] in html
        book = tmp_path / f"{code}.xlsx"
        book.write_bytes(workbook(undamped, say=say))
        assert cached(book) == say("fail")
        if READS_PAPER and code == "en":
            (tmp_path / "out.pdf").write_bytes(document(told))
            assert text.paragraphs[0] in " ".join(printed(tmp_path / "out.pdf").split())


@pytest.mark.slow
def test_the_resonance_fails_at_the_command_line(tmp_path):
    path = tmp_path / "undamped.yaml"
    path.write_text(UNDAMPED, encoding="utf-8")
    for command in (["check"], ["stability"]):
        run = CliRunner().invoke(cli, [*command, str(path), "--json", "-"])
        assert run.exit_code == 1
        assert json.loads(run.stdout)["verdict"] == "fail"


# --------------------------------------------------------------------------- a bracket


@pytest.fixture(scope="module")
def solved() -> Callable[..., object]:
    """Judges a bracket as the solver does, once: limits do not change its stresses."""
    from cardan.study.bracket import Judged, judge

    found: list[Judged] = []

    def once_judged(*given: object, name: str = "original", **more: object) -> Judged:
        if not found:
            found.append(judge(*given, name=name, **more))
        return replace(found[0], name=name)

    return once_judged


def hung(case: Case, folder: Path) -> dict[str, object]:
    """What every medium of `cardan bracket` says of an application."""
    path, out = put(folder, case.name, case.text), folder / "bracket.json"
    asked = ["bracket", str(path), "--json", str(out)]
    run = CliRunner().invoke(cli, asked, catch_exceptions=False)
    contract = json.loads(out.read_text(encoding="utf-8"))
    return {
        "exit": run.exit_code,
        "terminal": of_terminal(run.stdout),
        "json": contract["verdict"],
        "checks": graded(contract),
    }


@pytest.mark.bracket
@pytest.mark.parametrize(("verdict", "held_by", "share"), VERDICTS)
@pytest.mark.parametrize("quantity", BRACKET)
@pytest.mark.usefixtures("drawn_once")
def test_a_solved_bracket_is_one_verdict_in_every_medium(
    solved, tmp_path, quantity, verdict, held_by, share
):
    limits = [limit(q, maximum=1.0) for q in BRACKET]
    path = put(tmp_path, "all", truck(limits, **GIVEN["bracket"]))
    with patch("cardan.study.bracket.judge", solved):
        value = worst_of(read(path, hangs=True))[quantity]
        case = made(quantity, verdict, **{held_by: past(quantity, value, share)})
        held(hung(case, tmp_path), verdict)
        held(said(case, tmp_path), verdict)


BENT = """
bracket:
  line: main
  u_shape: {seat_diameter_mm: 100, width_mm: 70, thickness_mm: 3, height_mm: 90, flange_mm: 55,
            bend_radius_mm: 10, bolt_diameter_mm: 11, bolt_pitch_mm: 40}
  material: S355MC
  element_mm: 16
  carried_mass_kg: 25
  cases: [{name: pothole, acceleration_g: [0, 0, 40]}]
"""


@pytest.mark.bracket
def test_a_bracket_of_thin_sheet_fails_wherever_it_is_asked(tmp_path):
    """40 g on 3 mm of sheet: the bracket's own command printed it without a verdict."""
    from test_bracket_chapter import FILE

    head, _, _ = FILE.partition("bracket:")
    path = tmp_path / "bent.yaml"
    path.write_text(head + BENT.replace("  line: main\n", "").lstrip("\n"), encoding="utf-8")
    run = CliRunner().invoke(cli, ["bracket", str(path)], catch_exceptions=False)
    assert run.exit_code == 1, run.output
    assert ": FAIL (" in run.stdout
    book = tmp_path / "bent.xlsx"
    run = CliRunner().invoke(
        cli, ["check", str(path), "--with", "bracket", "--json", "-", "--xlsx", str(book)]
    )
    assert run.exit_code == 1
    assert json.loads(run.stdout)["verdict"] == "fail"
    assert cached(book) == "fail"


# --------------------------------------------------------------------------- as it was found


def test_room_alone_fails_in_the_workbook_too(tmp_path):
    """The refuse collector has 11 mm of room where 15 are asked, and every angle below 45 deg."""
    text = (EXAMPLES / "refuse-collector-6x2.yaml").read_text(encoding="utf-8")
    limits = [limit("clearance", maximum=15), limit("joint_angle", maximum=45)]
    found = approve(
        files.loads(text.replace("limits: heavy-truck", f"limits: {json.dumps(limits)}"))
    )
    assert found.verdict == "fail"
    book = tmp_path / "book.xlsx"
    book.write_bytes(workbook(found, say=Language("en")))
    assert cached(book) == "fail"


# --------------------------------------------------------------------------- whose limits


@pytest.mark.slow
@pytest.mark.parametrize("asked", [("--with", "vibration"), ()])
def test_a_profile_without_a_study_s_limits_does_not_pass_what_the_study_finds(asked, tmp_path):
    """Under `protractor` this truck passed its check, and failed `cardan stability`."""
    path = tmp_path / "undamped.yaml"
    path.write_text(
        yaml.safe_dump(yaml.safe_load(UNDAMPED) | {"limits": "protractor"}), encoding="utf-8"
    )
    run = CliRunner().invoke(cli, ["check", str(path), *asked, "--json", "-"])
    document = json.loads(run.stdout)
    assert (run.exit_code, document["verdict"]) == (1, "fail")
    assert document["profile"] == "protractor; vibration: heavy-truck"
    alone = cardan.stability(cardan.read(path))
    mine = [c for c in document["checks"] if QUANTITIES[c["quantity"]].study == VIBRATION]
    assert mine == alone.to_dict()["checks"]
    assert alone.verdict == "fail"


@pytest.mark.slow
def test_a_chapter_that_nothing_was_held_against_does_not_pass(undamped):
    (vibration,) = [f for f in undamped.findings if f.study == VIBRATION]
    text = next(chapter(replace(vibration, checks=()), Language("en")))
    assert text.paragraphs[0] == "Vibration: INCOMPLETE (0 fail, 0 warn, 0 pass)."


def test_a_bracket_s_own_limits_are_asked_beside_the_driveline_too(tmp_path):
    path = put(tmp_path, "truck", truck([limit("joint_angle", maximum=45)], **GIVEN["bracket"]))
    with made_up_bracket():
        beside, alone = read(path, hangs=True), cardan.bracket(cardan.read(path))
    assert alone.checks
    assert [c for c in beside.checks if QUANTITIES[c.quantity].study == "bracket"] == list(
        alone.checks
    )
    assert beside.application.profile == "limits of the application; bracket: heavy-truck"


# --------------------------------------------------------------------------- no life at all


@pytest.mark.parametrize(
    ("rows", "options", "said"),
    [
        (None, ("--allowed", "inf"), "must be finite"),
        (None, ("--low-pass-Hz", "0.001"), "keeps not one period"),
        (3, (), "holds 3 samples"),
    ],
)
def test_a_life_that_nothing_is_known_of_is_refused(recording, tmp_path, rows, options, said):
    """Damage that nothing allows, a filter slower than the recording, one of three samples."""
    short = tmp_path / "short.csv"
    lines = recording.read_text(encoding="utf-8").splitlines()
    short.write_text("\n".join(lines[: rows and rows + 1]) + "\n", encoding="utf-8")
    run = CliRunner().invoke(cli, ["life", str(short), *GAUGE, *options])
    assert (run.exit_code, run.stdout) == (2, "")
    assert said in run.stderr
