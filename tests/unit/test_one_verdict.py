"""One application, one verdict: terminal, JSON, page, document, workbook and exit code.

The refuse collector with room and joint angle as its only limits failed on the screen and
passed in the workbook: of 29 quantities that limits may ask about, 12 never reached it. Here
every one fails once, by a millionth, and every medium has to say so. (`tests/office` has the
same workbooks recomputed by LibreOffice.)
"""

import json
import re
import shutil
import subprocess
from collections.abc import Callable
from functools import partial
from html import unescape
from pathlib import Path
from zipfile import ZipFile

import pytest
from click.testing import CliRunner
from one_verdict import (
    ASKED,
    Case,
    equal,
    failing,
    incomplete,
    limit,
    passing,
    put,
    read,
    unasked,
    warning,
)

from cardan import files
from cardan.cli import cli
from cardan.report import story
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
    monkeypatch.setattr("cardan.study.fix.fix", lambda *_, **__: ())
    for name in ("drawings", "plots"):
        monkeypatch.setattr(story, name, partial(once, name, getattr(story, name)))


def cached(book: Path) -> str:
    """The verdict that a workbook shows where nothing computes it anew."""
    with ZipFile(book) as file:
        names = file.read("xl/workbook.xml").decode()
        cell = re.search(r'name="verdict">[^<]*\$B\$(\d+)<', names)[1]
        sheet = file.read("xl/worksheets/sheet1.xml").decode()
    return re.search(rf'<c r="B{cell}"[^>]*t="str"><f>.*?</f><v>([^<]*)</v>', sheet)[1]


def of_story(told: story.Story) -> tuple[str, ...]:
    """The verdict as a story tells it: its headline, and the worst of its table."""
    table = told.chapters[0].blocks[0]
    return told.grade, told.verdict.lower(), table.rows[0][0] if table.rows else ""


def of_page(html: str) -> str:
    grade, word = re.search(r'class="banner (\w+)"><strong>\S+ (\w+)<', unescape(html)).groups()
    assert grade == word.lower()
    return grade


def said(case: Case, folder: Path) -> dict[str, object]:
    """What every medium says of an application."""
    path = put(folder, case.name, case.text)
    outs = {kind: folder / f"{case.name}.{kind}" for kind in ("json", "html", "xlsx")}
    options = [word for kind, out in outs.items() for word in (f"--{kind}", str(out))]
    run = CliRunner().invoke(cli, ["check", str(path), *options], catch_exceptions=False)
    contract = json.loads(outs["json"].read_text(encoding="utf-8"))
    graded = [c["verdict"] for c in contract["checks"]]
    html = outs["html"].read_text(encoding="utf-8")
    return {
        "exit": run.exit_code,
        "terminal": re.search(r"^[^\n]*: ([A-Z]+) \(", run.stdout, re.MULTILINE)[1].lower(),
        "json": contract["verdict"],
        "checks": {g: graded.count(g) for g in ("fail", "warn") if g in graded},
        "html": of_page(html),
        "xlsx": cached(outs["xlsx"]),
    }


def held(case: Case, folder: Path) -> None:
    found = said(case, folder)
    assert found.pop("exit") == (1 if case.verdict in ("fail", "incomplete") else 0)
    graded = found.pop("checks")
    assert set(graded) == {case.verdict} & {"fail", "warn"}
    assert found == dict.fromkeys(found, case.verdict)


@pytest.mark.parametrize("quantity", ASKED)
@pytest.mark.usefixtures("drawn_once")
def test_what_fails_by_a_millionth_fails_in_every_medium(quantity, tmp_path):
    held(failing(quantity), tmp_path)


OTHERS = {
    "a warning of the driveline": lambda: warning("torsional_acceleration"),
    "a warning of vibration": lambda: warning("torsional_resonance"),
    "a pass": lambda: passing("torsional_acceleration"),
    "equality": equal,
    "no answer": incomplete,
    "nothing asked": unasked,
}


@pytest.mark.parametrize("what", OTHERS)
@pytest.mark.usefixtures("drawn_once")
def test_other_verdicts_are_one_in_every_medium_too(what, tmp_path):
    held(OTHERS[what](), tmp_path)


def printed(pdf: bytes, folder: Path) -> str:
    """The text of a document."""
    (folder / "out.pdf").write_bytes(pdf)
    run = ["pdftotext", "-layout", "out.pdf", "-"]
    return subprocess.run(run, cwd=folder, capture_output=True, text=True, check=True).stdout


ON_PAPER = {"clearance": failing, "torsional_acceleration": warning, "joint_angle": passing,
            "joint_life": lambda _: incomplete(), "torsional_growth": failing}  # fmt: skip


@pytest.mark.parametrize("quantity", ON_PAPER)
@pytest.mark.usefixtures("drawn_once")
def test_the_document_says_it_in_print(quantity, tmp_path):
    case = ON_PAPER[quantity](quantity)
    found = read(put(tmp_path, case.name, case.text))
    told = story.approval(found, helps=(), fixes=(), say=Language("en"), issue=story.Issue())
    assert of_story(told)[:2] == (case.verdict, case.verdict)
    assert _told(told)[0]["verdict"] == case.verdict.upper()
    if shutil.which("pdftotext"):
        text = printed(document(told), tmp_path)
        assert case.verdict.upper() in text
        others = {"PASS", "WARN", "FAIL", "INCOMPLETE"} - {case.verdict.upper()}
        headline = text[: text.index(case.verdict.upper())]
        assert not [o for o in others if o in headline]


# --------------------------------------------------------------------------- a resonance


UNDAMPED = files.starter("truck") + "\ntorsion: {damping_ratio: 1.0e-5, axle_inertia_kgm2: 8}\n"
"""The truck starter with next to no damping, and an axle that puts a zone among its speeds."""


@pytest.fixture(scope="module")
def undamped() -> Approval:
    """The truck, shaken up where it meets a zone."""
    return approve(files.loads(UNDAMPED))


def test_a_line_that_shakes_itself_up_fails_in_headline_and_chapter(undamped, tmp_path):
    """The chapter once had limits of its own: it said WARN under a headline that said FAIL."""
    (vibration,) = [f for f in undamped.findings if f.study == VIBRATION]
    assert {c.quantity for c in vibration.checks if c.grade == "fail"} == {"torsional_growth"}
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
        if shutil.which("pdftotext") and code == "en":
            assert text.paragraphs[0] in " ".join(printed(document(told), tmp_path).split())


def test_the_resonance_fails_at_the_command_line(tmp_path):
    path = tmp_path / "undamped.yaml"
    path.write_text(UNDAMPED, encoding="utf-8")
    for command in (["check"], ["stability"]):
        run = CliRunner().invoke(cli, [*command, str(path), "--json", "-"])
        assert run.exit_code == 1
        assert json.loads(run.stdout)["verdict"] == "fail"


# --------------------------------------------------------------------------- a bracket

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
