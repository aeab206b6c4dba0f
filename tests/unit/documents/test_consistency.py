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
from brackets import LINE
from case_selection import select
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
    verdict_of_headline,
    warning,
    worst_of,
)
from repository import EXAMPLES

import cardan
from cardan.application import reader, templates
from cardan.approval.approval import Approval, approve_application
from cardan.approval.study import VIBRATION_STUDY_NAME
from cardan.checks.quantities.registry import LIMITABLE_QUANTITIES, QUANTITIES
from cardan.cli import cli
from cardan.core.errors import DesignError
from cardan.documents import approval_report as story
from cardan.documents.approval_schema import schema as described
from cardan.documents.workbook import workbook_bytes
from cardan.render.html import html_page
from cardan.render.i18n import LANGUAGE_CODES, Translator
from cardan.render.pdf import _document_data, pdf_document
from cardan.topics.torsion.chapter import vibration_blocks

DRAWN: dict[str, tuple] = {}


def once(name: str, of: Callable[..., tuple], *asked: object) -> tuple:
    if name not in DRAWN:
        DRAWN[name] = of(*asked)
    return DRAWN[name]


@pytest.fixture
def drawn_once(monkeypatch):
    """What takes most of the time says no verdict: pictures of one line stand in for all, and
    nobody looks for corrections."""
    monkeypatch.setattr(story, "find_corrections", lambda *_, **__: ())
    for name in ("line_drawings", "all_line_plots"):
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
    return verdict_of_headline(verdict)


def of_story(told: story.ReportDocument) -> tuple[str, ...]:
    """The verdict as a story tells it: its headline, and the worst of its table."""
    table = told.chapters[0].blocks[0]
    return told.grade, verdict_of_headline(told.verdict), table.rows[0][0] if table.rows else ""


def of_page(html: str) -> str:
    grade, said = re.search(r'class="banner (\w+)"><strong>\S+ ([^<]+)<', unescape(html)).groups()
    assert verdict_of_headline(said) == grade
    return grade


def of_document(pdf: Path) -> str:
    """The verdict as a document has it in print: its headline, and the rows of its table."""
    text = printed(pdf)
    table, _, _ = text.partition("Where the limits come from")
    (said,) = re.findall(
        r"^ +([A-Z]{3,10}(?: [A-Z]{4,10}){0,2}(?: {3,}\S.*)?|approved.*|angles approved.*)$",
        table,
        re.MULTILINE,
    )
    verdict = verdict_of_headline(re.split(r" {3,}", said)[0])
    words = {"exceeded": "fail", "beyond": "warn"}
    graded = {words[w] for w in re.findall(r"^ ?(exceeded|beyond) ", table, re.MULTILINE)}
    assert graded == {verdict} & {"fail", "warn"}
    return verdict


def printed(pdf: Path) -> str:
    """The text of a document."""
    run = ["pdftotext", "-layout", pdf.name, "-"]
    return subprocess.run(run, cwd=pdf.parent, capture_output=True, text=True, check=True).stdout


READS_PAPER = bool(shutil.which("pdftotext"))
KINDS = ("json", "html", "xlsx", *["pdf"][:READS_PAPER])


@pytest.mark.slow
@pytest.mark.skipif(not READS_PAPER, reason="pdftotext of poppler is not installed")
def test_verdict_is_read_back_from_pdf(tmp_path):
    """Skipped it says that no document was looked at; and its reader sees what is wrong."""
    path = put(tmp_path, "truck", failing("joint_angle").text)
    told = story.approval_report_from_results(
        read(path), helps=(), fixes=(), say=Translator("en"), issue=story.ReportDateAndSourceStamp()
    )
    for verdict, seen in (("NOT APPROVED", "fail"), ("APPROVED", None), ("", None)):
        (tmp_path / "out.pdf").write_bytes(pdf_document(replace(told, verdict=verdict)))
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
        "terminal": of_screen(run.stdout),
        "json": contract["verdict"],
        "checks": graded(contract),
        "html": of_page(html),
        "xlsx": cached(outs["xlsx"]),
        **({"pdf": of_document(outs["pdf"])} if READS_PAPER else {}),
    }


def of_screen(text: str) -> str:
    """The verdict at the end of the first line, or on the lines below it."""
    return verdict_of_headline(re.split(r"  +", text.partition("\nRead:")[0], maxsplit=1)[1])


def of_terminal(text: str) -> str:
    return verdict_of_headline(re.search(r"^[^\n]*: ([A-Z ]+) \(", text, re.MULTILINE)[1])


def graded(contract: dict) -> set[str]:
    """What checks come to that do not pass."""
    return {c["verdict"] for c in contract["checks"]} - {"pass"}


def held(found: dict[str, object], verdict: str) -> None:
    """Hold what media say to one verdict, and the exit code with it."""
    assert found.pop("exit") == (1 if verdict in ("fail", "incomplete") else 0)
    assert found.pop("checks") == {verdict} & {"fail", "warn"}
    assert found == dict.fromkeys(found, verdict)


@pytest.mark.slow
def test_every_limitable_quantity_has_a_failing_case():
    """A quantity of a further study has no medium yet that is asked about it."""
    assert sorted([*ASKED, *RECORDING]) == sorted(LIMITABLE_QUANTITIES)
    assert {case.quantity for case in cases() if case.verdict == "fail"} == set(ASKED)


OF_EACH_KIND = (
    "torque", "axle_load", "joint_angle_min", "clearance", "centre_bearing_dynamic",
    "critical_speed_ratio", "half_critical_band", "resonance_distance", "joint_life",
    "spline_travel_margin", "torsional_resonance", "launch_reversal",
    "bracket_stress_utilisation",
)  # fmt: skip


@pytest.mark.slow
@pytest.mark.parametrize("quantity", select(ASKED, *OF_EACH_KIND))
@pytest.mark.usefixtures("drawn_once")
def test_limit_exceeded_by_one_millionth_fails_in_every_medium(quantity, tmp_path, monkeypatch):
    monkeypatch.setattr("cardan.topics.bracket.chapter.bracket_chapters", lambda *_, **__: iter(()))
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


@pytest.mark.slow
@pytest.mark.parametrize("what", select(OTHERS, *FEW))
@pytest.mark.usefixtures("drawn_once")
def test_other_verdicts_agree_in_every_medium(what, tmp_path):
    case = OTHERS[what]()
    held(said(case, tmp_path), case.verdict)


TOLD = {"clearance": failing, "torsional_acceleration": warning, "joint_angle": passing,
        "joint_life": lambda _: incomplete(), "torsional_growth": failing}  # fmt: skip


@pytest.mark.slow
@pytest.mark.parametrize("quantity", TOLD)
@pytest.mark.usefixtures("drawn_once")
def test_pdf_data_has_verdict_of_report(quantity, tmp_path):
    """Where nothing reads documents back this much is known of them."""
    case = TOLD[quantity](quantity)
    found = read(put(tmp_path, case.name, case.text))
    told = story.approval_report_from_results(
        found, helps=(), fixes=(), say=Translator("en"), issue=story.ReportDateAndSourceStamp()
    )
    assert of_story(told)[:2] == (case.verdict, case.verdict)
    assert verdict_of_headline(_document_data(told)[0]["verdict"]) == case.verdict


def test_study_not_requested_has_no_chapter():
    """The medium truck could be asked about vibration, and was not: its report is silent on it."""
    found = approve_application(reader.read(EXAMPLES / "medium-truck-4x2.yaml"))
    assert [(f.study, f.was_run) for f in found.study_results] == [
        ("driveline", True),
        ("vibration", False),
    ]
    told = story.approval_report_from_results(
        found, helps=(), fixes=(), say=Translator("en"), issue=story.ReportDateAndSourceStamp()
    )
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
    asked = ["life", str(recording), *GAUGE, *options, "--all", "--json", str(out)]
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


@pytest.mark.slow
@pytest.mark.parametrize(("verdict", "held_by", "share"), VERDICTS)
@pytest.mark.parametrize("quantity", RECORDING)
def test_recording_verdict_agrees_in_every_medium(
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
@pytest.mark.parametrize(("verdict", "held_by", "share"), select(VERDICTS, VERDICTS[0]))
@pytest.mark.parametrize("quantity", select(RECORDING, "fatigue_life"))
@pytest.mark.usefixtures("drawn_once")
def test_recording_limit_of_application_is_in_its_verdict(
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


def test_recording_of_another_design_is_excluded_from_verdict(campaign, tmp_path):
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


def test_invalid_campaign_is_reported_and_does_not_pass(campaign, tmp_path):
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


def test_recording_option_accepts_one_application_only(campaign):
    two = [str(EXAMPLES / "medium-truck-4x2.yaml")] * 2
    run = CliRunner().invoke(cli, ["check", *two, "--recording", str(campaign)])
    assert run.exit_code == 2
    assert "give one file with --recording" in run.output


@pytest.mark.slow
def test_short_report_omits_detail_chapters(tmp_path):
    path, out = put(tmp_path, "truck", passing("joint_angle").text), tmp_path / "out.html"
    said = {}
    for how in ("--short", "--all"):
        CliRunner().invoke(cli, ["check", str(path), how, "--html", str(out)])
        said[how] = re.findall(r"<h2[^>]*>(.*?)</h2>", out.read_text(encoding="utf-8"))
    assert [t.split()[-1] for t in said["--short"]] == [
        "sheet",
        "Limits",
        "change",
        "Revisions",
    ]
    assert len(said["--all"]) > len(said["--short"])


def test_short_report_lists_every_limit_that_does_not_pass():
    found = cardan.check(cardan.read(EXAMPLES / "medium-truck-4x2.yaml"), studies=())
    told = {}
    for short in (True, False):
        table, *_ = story.verdict_report_blocks(found, Translator("en"), short=short)
        told[short] = [row[0] for row in table.rows]
    bad = [grade for grade in told[False] if grade != "met"]
    assert bad
    assert told[True] == [*bad, "met", "met", "met"]


def test_target_missed_by_one_millionth_fails_in_every_medium(recording):
    target = past("fatigue_life", heard_value(recording, "fatigue_life"), LITTLE)
    held(heard(recording, "--target-hours", repr(target)), "fail")


# --------------------------------------------------------------------------- a resonance


UNDAMPED = (
    templates.template_text("truck").replace(
        "  friction: 0.8 ", "  slip_stiffness_kN: 900000\n  friction: 0.8 ", 1
    )
    + "\ntorsion: {damping_ratio: 1.0e-4, axle_inertia_kgm2: 8}\n"
)
"""The truck starter with next to no damping, not even its tyres', and zones among its speeds."""


@pytest.fixture(scope="module")
def undamped() -> Approval:
    """The truck, shaken up where it meets a zone."""
    return approve_application(reader.loads(UNDAMPED))


@pytest.mark.slow
def test_unstable_line_fails_in_headline_and_chapter(undamped, tmp_path):
    """The chapter once had limits of its own: it said WARN under a headline that said FAIL."""
    (vibration,) = [f for f in undamped.study_results if f.study == VIBRATION_STUDY_NAME]
    assert "torsional_growth" in {c.quantity for c in vibration.checks if c.grade == "fail"}
    assert undamped.verdict == "fail"
    for code in LANGUAGE_CODES:
        say = Translator(code)
        told = story.approval_report_from_results(
            undamped, helps=(), fixes=(), say=say, issue=story.ReportDateAndSourceStamp()
        )
        (text,) = [b for b in vibration_blocks(vibration, say) if hasattr(b, "paragraphs")]
        assert say("not approved").upper() in text.paragraphs[0]
        html = unescape(html_page(told))
        assert told.verdict == say("not approved").upper()
        assert text.paragraphs[0] in html
        book = tmp_path / f"{code}.xlsx"
        book.write_bytes(workbook_bytes(undamped, say=say))
        assert cached(book) == ("fail" if code == "en" else say("not approved"))
        if READS_PAPER and code == "en":
            (tmp_path / "out.pdf").write_bytes(pdf_document(told))
            assert text.paragraphs[0] in " ".join(printed(tmp_path / "out.pdf").split())


@pytest.mark.slow
def test_undamped_resonance_fails_in_check_and_stability(tmp_path):
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
    from cardan.topics.bracket.assessment import ShapeAssessment, assess_shape

    found: list[ShapeAssessment] = []

    def once_judged(*given: object, name: str = "original", **more: object) -> ShapeAssessment:
        if not found:
            found.append(assess_shape(*given, name=name, **more))
        return replace(found[0], name=name)

    return once_judged


def hung(case: Case, folder: Path) -> dict[str, object]:
    """What every medium of `cardan bracket` says of an application."""
    path, out = put(folder, case.name, case.text), folder / "bracket.json"
    asked = ["bracket", str(path), "--all", "--json", str(out)]
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
def test_bracket_verdict_agrees_in_every_medium(
    solved, tmp_path, quantity, verdict, held_by, share
):
    limits = [limit(q, maximum=1.0) for q in BRACKET]
    path = put(tmp_path, "all", truck(limits, **GIVEN["bracket"]))
    with patch("cardan.topics.bracket.assessment.assess_shape", solved):
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
def test_thin_sheet_bracket_fails_in_every_command(tmp_path):
    """40 g on 3 mm of sheet: the bracket's own command printed it without a verdict."""
    head = LINE + "duty: [{share_percent: 100, torque_Nm: 8000, speed_rpm: 2500}]\n"
    path = tmp_path / "bent.yaml"
    path.write_text(head + BENT.replace("  line: main\n", "").lstrip("\n"), encoding="utf-8")
    run = CliRunner().invoke(cli, ["bracket", str(path)], catch_exceptions=False)
    assert run.exit_code == 1, run.output
    assert run.stdout.splitlines()[0].endswith("NOT APPROVED")
    assert len(run.stdout.splitlines()) <= 32
    book = tmp_path / "bent.xlsx"
    run = CliRunner().invoke(
        cli, ["check", str(path), "--with", "bracket", "--json", "-", "--xlsx", str(book)]
    )
    assert run.exit_code == 1
    assert json.loads(run.stdout)["verdict"] == "fail"
    assert cached(book) == "fail"


# --------------------------------------------------------------------------- as it was found


@pytest.mark.slow
def test_clearance_failure_alone_fails_in_workbook(tmp_path):
    """The refuse collector has 11 mm of room where 15 are asked, and every angle below 45 deg."""
    text = (EXAMPLES / "refuse-collector-6x2.yaml").read_text(encoding="utf-8")
    limits = [limit("clearance", maximum=15), limit("joint_angle", maximum=45)]
    found = approve_application(
        reader.loads(text.replace("limits: heavy-truck", f"limits: {json.dumps(limits)}"))
    )
    assert found.verdict == "fail"
    book = tmp_path / "book.xlsx"
    book.write_bytes(workbook_bytes(found, say=Translator("en")))
    assert cached(book) == "fail"


# --------------------------------------------------------------------------- whose limits


@pytest.mark.slow
@pytest.mark.parametrize("asked", [("--with", "vibration"), ()])
def test_profile_without_study_limits_does_not_pass_the_study(asked, tmp_path):
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
    mine = [
        c for c in document["checks"] if QUANTITIES[c["quantity"]].study == VIBRATION_STUDY_NAME
    ]
    assert mine == alone.to_dict()["checks"]
    assert alone.verdict == "fail"


@pytest.mark.slow
def test_chapter_without_checks_is_incomplete(undamped):
    (vibration,) = [f for f in undamped.study_results if f.study == VIBRATION_STUDY_NAME]
    text = next(vibration_blocks(replace(vibration, checks=()), Translator("en")))
    assert text.paragraphs[0] == "Vibration: INCOMPLETE (0 exceeded, 0 beyond recommended, 0 met)."


def test_bracket_default_limits_apply_in_driveline_check(tmp_path):
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
def test_life_without_valid_result_is_rejected(recording, tmp_path, rows, options, said):
    """Damage that nothing allows, a filter slower than the recording, one of three samples."""
    short = tmp_path / "short.csv"
    lines = recording.read_text(encoding="utf-8").splitlines()
    short.write_text("\n".join(lines[: rows and rows + 1]) + "\n", encoding="utf-8")
    run = CliRunner().invoke(cli, ["life", str(short), *GAUGE, *options])
    assert (run.exit_code, run.stdout) == (2, "")
    assert said in run.stderr
