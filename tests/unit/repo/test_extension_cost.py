"""What an addition costs: the files named in docs/architecture.md, and no other.

A copy of the package gets a quantity, a thing to move and a language, in the files that the
page says and nowhere else. Every medium of the copy then has to know them.
"""

import filecmp
import json
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import jsonschema
import pytest
from repository import ROOT

TRUCK = ROOT / "examples" / "refuse-collector-6x2.yaml"

QUANTITY = """
    Quantity(
        key="joint_distance", name="Distance between joints", symbol="L", unit="mm",
        equation="L = distance of the joint centres of a shaft", source=SOURCE_DERIVED,
        compute=lambda r: r.layout.lengths, parts=all_shafts, section="Room",
        json_path="joint_distances_mm[]",
    ),
)
"""
ADJUSTMENT = """
    Adjustment(
        key="last_height", description="the last centre bearing alone, up positive",
        subject="axle", dimension="length", count=lambda line: int(len(line.shafts) > 1),
        apply=lambda moved, part, amount: _shift(2)(moved, 0, amount),
        default_range=(-5 * mm, 5 * mm), probe_step=5 * mm,
        label="height of the last bearing",
        increase_text="last bearing raised {amount} mm",
        decrease_text="last bearing lowered {amount} mm",
    ),
)
"""
WORDS = """
msgctxt "quantity"
msgid "Distance between joints"
msgstr "<Distance between joints>"

msgid "L = distance of the joint centres of a shaft"
msgstr "<L = distance of the joint centres of a shaft>"

msgid "height of the last bearing"
msgstr "<height of the last bearing>"

msgid "last bearing raised {amount} mm"
msgstr "<last bearing raised {amount} mm>"

msgid "last bearing lowered {amount} mm"
msgstr "<last bearing lowered {amount} mm>"
"""
APPLICATION = """
limits:
  - {quantity: joint_distance, maximum: 1300, required: true, source: a workshop's crane}
"""


def declare(file: Path, last: str, more: str, imports: tuple[str, str] = ("", "")) -> None:
    """Put a declaration in place of the end of a module's tuple of them."""
    before, found, after = file.read_text(encoding="utf-8").rpartition(last)
    assert found
    text = before + more.lstrip("\n") + after
    file.write_text(text.replace(*imports) if imports[0] else text, encoding="utf-8")


@pytest.fixture(scope="module")
def house(tmp_path_factory) -> Path:
    """A copy of the package with a quantity, a thing to move and a language more."""
    root = tmp_path_factory.mktemp("house")
    package = root / "cardan"
    shutil.copytree(ROOT / "src" / "cardan", package, ignore=shutil.ignore_patterns("__pycache__"))
    declare(
        package / "checks" / "quantities" / "clearance.py", ")\n", QUANTITY,
        ("    Quantity,\n", "    Quantity,\n    all_shafts,\n"),
    )  # fmt: skip
    declare(
        package / "model" / "adjustments.py",
        ")\n\nADJUSTMENTS",
        ADJUSTMENT.rstrip("\n") + "\n\nADJUSTMENTS",
    )
    texts = package / "render" / "locales"
    for code in ("pt", "it"):
        with (texts / f"{code}.po").open("a", encoding="utf-8") as file:
            file.write(WORDS)
    spoken = (
        (texts / "it.po").read_text(encoding="utf-8").replace('"Language: it', '"Language: tlh')
    )
    spoken = re.sub(r'^msgstr "(?=.+"$)', 'msgstr "¡', spoken, flags=re.MULTILINE)
    (texts / "tlh.po").write_text(spoken, encoding="utf-8")
    text = TRUCK.read_text(encoding="utf-8").replace(
        "  shim_deg: [-3, 3]", "  last_height_mm: [-10, 30]\n  shim_deg: [-3, 3]"
    )
    text = re.sub(r"^limits:.*\n", "", text, flags=re.MULTILINE)
    (root / "truck.yaml").write_text(text + APPLICATION, encoding="utf-8")
    return root


def differing(ours: Path, theirs: Path) -> set[str]:
    """The files that one package has otherwise than the other, or alone."""
    found = set()
    for file in theirs.rglob("*"):
        at = file.relative_to(theirs)
        if file.is_file() and "__pycache__" not in at.parts:
            same = (ours / at).exists() and filecmp.cmp(file, ours / at, shallow=False)
            found |= set() if same else {at.as_posix()}
    return found


def run(house: Path, *args: str) -> str:
    environment = {**os.environ, "PYTHONPATH": str(house), "PYTHONIOENCODING": "utf-8",
                   "COLUMNS": "160"}  # fmt: skip
    done = subprocess.run(
        [sys.executable, "-m", "cardan", *args], capture_output=True, text=True, cwd=house,
        env=environment, check=False, encoding="utf-8",
    )  # fmt: skip
    assert done.returncode in (0, 1), done.stderr
    return done.stdout


def test_additions_change_only_the_documented_files(house):
    assert differing(ROOT / "src" / "cardan", house / "cardan") == {
        "checks/quantities/clearance.py",  # a quantity
        "model/adjustments.py",  # a thing to move
        "render/locales/pt.po", "render/locales/it.po",  # their words
        "render/locales/tlh.po",  # a language
    }  # fmt: skip


@pytest.mark.slow
def test_added_quantity_appears_in_every_medium(house):
    said = run(house, "check", "truck.yaml", "--states")
    assert re.search(r"^X distance between joints\b.* max 1300 mm", said, re.MULTILINE)
    assert re.search(r"^Distance between joints, shaft 2 +mm( +[\d.]+){7}$", said, re.MULTILINE)
    document = json.loads(run(house, "check", "truck.yaml", "--json"))
    assert "joint_distance" in {c["quantity"] for c in document["checks"]}
    assert len(document["states"][0]["joint_distances_mm"]) == 3
    schema = json.loads(run(house, "schema", "--contract"))
    assert "joint_distances_mm" in schema["properties"]["states"]["items"].get(
        "properties", schema["$defs"]["state"]["properties"]
    )
    jsonschema.Draft202012Validator(schema).validate(document)
    assert "L = distance of the joint centres" in run(house, "explain", "joint_distance")
    assert "<Distance between joints>" in run(house, "check", "truck.yaml", "--lang", "pt")


@pytest.mark.slow
@pytest.mark.long
def test_added_adjustment_appears_in_every_medium(house):
    schema = run(house, "schema")
    assert "last_height_mm" in schema
    found = json.loads(run(house, "fix", "truck.yaml", "--json"))
    contract = json.loads(run(house, "schema", "--contract"))
    assert "last_height" in contract["$defs"]["move"]["properties"]["what"]["enum"]
    assert isinstance(found, list)
    adjusted = (house / "truck.yaml").read_text(encoding="utf-8")
    alone = re.sub(r"adjust:(.*\n)(  .*\n)+", "adjust: {last_height_mm: [-10, 30]}\n", adjusted)
    alone = alone.replace(APPLICATION, "\nlimits: heavy-truck\n")
    (house / "alone.yaml").write_text(alone, encoding="utf-8")
    assert re.search(
        r"last bearing (raised|lowered) [\d.]+ mm", run(house, "fix", "--all", "alone.yaml")
    )
    said = run(house, "fix", "--all", "alone.yaml", "--lang", "it")
    assert re.search(r"<last bearing (raised|lowered) [\d,]+ mm>", said)
    code = (
        "import cardan; app = cardan.read('alone.yaml'); "
        "print(cardan.study(app, {'last_height_mm': [-10, 30]}, n=8).sampling_plan.names[0])"
    )
    done = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, cwd=house, check=True,
        env={**os.environ, "PYTHONPATH": str(house)},
    )  # fmt: skip
    assert done.stdout.strip() == "last_height_mm"


@pytest.mark.slow
def test_added_language_needs_only_its_catalogue(house):
    said = run(house, "check", "truck.yaml", "--lang", "tlh")
    assert "¡" in said
    assert re.search(r"\d,\d", said)  # its head says which decimal sign
    assert "tlh: ¡" in run(house, "explain", "joint_angle")
    page = house / "truck.html"
    run(house, "check", "truck.yaml", "--lang", "tlh", "--html", str(page), "-q")
    assert 'lang="tlh"' in page.read_text(encoding="utf-8")


MEDIUM = '''
    ReportMedium(
        name="outline", media_type="text/plain", help="A report: its headings.",
        writer="cardan.render.outline:outline",
    ),
)
"""Media of reports'''
OUTLINE = '''"""A report as its headings."""

from cardan.render.blocks import ReportDocument


def outline(of: ReportDocument) -> str:
    """Return the headings of a report, a line each."""
    return "".join(f"{chapter.title}\\n" for chapter in of.chapters)
'''


@pytest.fixture(scope="module")
def copy_with_medium(tmp_path_factory) -> Path:
    """A copy of the package with a medium of reports more."""
    root = tmp_path_factory.mktemp("medium")
    package = root / "cardan"
    shutil.copytree(ROOT / "src" / "cardan", package, ignore=shutil.ignore_patterns("__pycache__"))
    declare(package / "render" / "media.py", ')\n"""Media of reports', MEDIUM)
    (package / "render" / "outline.py").write_text(OUTLINE, encoding="utf-8")
    shutil.copy(TRUCK, root / "truck.yaml")
    return root


def test_new_report_medium_takes_two_files(copy_with_medium):
    assert differing(ROOT / "src" / "cardan", copy_with_medium / "cardan") == {
        "render/outline.py",  # the medium
        "render/media.py",  # its place in the list
    }


@pytest.mark.slow
def test_added_report_medium_is_an_option_of_every_command_with_reports(copy_with_medium):
    for command in ("check", "joint", "life", "study"):
        assert "--outline" in run(copy_with_medium, command, "--help")
    run(copy_with_medium, "joint", "--angle", "10deg", "--speed", "1000rpm", "--outline", "one.txt")
    assert (copy_with_medium / "one.txt").read_text(encoding="utf-8").count("\n") >= 1


@pytest.mark.slow
def test_added_report_medium_is_written_by_check_interface_and_workbench(copy_with_medium):
    run(copy_with_medium, "check", "truck.yaml", "--outline", "a.txt", "--no-corrections", "-q")
    assert "Limits\n" in (copy_with_medium / "a.txt").read_text(encoding="utf-8")
    code = (
        "import cardan; from cardan.web.jobs import JOB_ARGUMENTS; "
        "from cardan.web.library import REPORT_MEDIA_TYPES; "
        "cardan.check(cardan.read('truck.yaml')).report('b.outline', corrections=False); "
        "print(JOB_ARGUMENTS['report']['kind']({'kind': 'outline'}, 'kind'), "
        "REPORT_MEDIA_TYPES['outline'])"
    )
    done = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, cwd=copy_with_medium,
        check=True, env={**os.environ, "PYTHONPATH": str(copy_with_medium)},
    )  # fmt: skip
    assert done.stdout.strip() == "outline text/plain"
    assert (copy_with_medium / "b.outline").exists()


def test_page_of_additions_names_files_that_exist():
    """Paths from the repository, the package or its `checks`, as the page has them."""
    page = (ROOT / "docs" / "architecture.md").read_text(encoding="utf-8")
    named = set(re.findall(r"`([\w./]+/[\w.]+\.(?:py|md|toml|json))`", page))
    assert len(named) > 25
    places = (ROOT, ROOT / "src" / "cardan")
    assert sorted(one for one in named if not any((at / one).exists() for at in places)) == []
