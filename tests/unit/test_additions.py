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

ROOT = Path(__file__).parents[2]
TRUCK = ROOT / "examples" / "refuse-collector-6x2.yaml"

QUANTITY = """
    Quantity(
        key="joint_distance", name="Distance between joints", symbol="L", unit="mm",
        equation="L = distance of the joint centres of a shaft", source=DERIVED,
        of=lambda r: r.layout.lengths, parts=shafts, section="Room",
        contract="joint_distances_mm[]",
    ),
)
"""
MOVABLE = """
    Movable(
        key="last_height", says="the last centre bearing alone, up positive",
        of="axle", measure="length", count=lambda line: int(len(line.shafts) > 1),
        move=lambda moved, part, amount: _shift(2)(moved, 0, amount),
        reach=(-5 * mm, 5 * mm), step=5 * mm,
        called="height of the last bearing",
        forth="last bearing raised {amount} mm", back="last bearing lowered {amount} mm",
    ),
)  # fmt: skip
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
        package / "quantity" / "room.py", ")\n", QUANTITY,
        ("    of_line,\n)\n", "    of_line,\n    shafts,\n)\n"),
    )  # fmt: skip
    declare(package / "model" / "movable.py", ")  # fmt: skip\n", MOVABLE)
    texts = package / "report" / "text"
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


def test_what_is_added_touches_the_files_the_page_names(house):
    assert differing(ROOT / "src" / "cardan", house / "cardan") == {
        "quantity/room.py",  # a quantity
        "model/movable.py",  # a thing to move
        "report/text/pt.po", "report/text/it.po",  # their words
        "report/text/tlh.po",  # a language
    }  # fmt: skip


@pytest.mark.slow
def test_a_quantity_is_in_every_medium(house):
    said = run(house, "check", "truck.yaml", "--states")
    assert re.search(r"^fail  Distance between joints +\S.* <= +1300 +mm", said, re.MULTILINE)
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
def test_a_thing_to_move_is_in_every_medium(house):
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
    assert re.search(r"last bearing (raised|lowered) [\d.]+ mm", run(house, "fix", "alone.yaml"))
    said = run(house, "fix", "alone.yaml", "--lang", "it")
    assert re.search(r"<last bearing (raised|lowered) [\d,]+ mm>", said)
    code = (
        "import cardan; app = cardan.read('alone.yaml'); "
        "print(cardan.study(app, {'last_height_mm': [-10, 30]}, n=8).varied[0].name)"
    )
    done = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, cwd=house, check=True,
        env={**os.environ, "PYTHONPATH": str(house)},
    )  # fmt: skip
    assert done.stdout.strip() == "last_height_mm"


@pytest.mark.slow
def test_a_language_is_its_catalogue(house):
    said = run(house, "check", "truck.yaml", "--lang", "tlh")
    assert "¡" in said
    assert re.search(r"\d,\d", said)  # its head says which decimal sign
    assert "tlh: ¡" in run(house, "explain", "joint_angle")
    page = house / "truck.html"
    run(house, "check", "truck.yaml", "--lang", "tlh", "--html", str(page), "-q")
    assert 'lang="tlh"' in page.read_text(encoding="utf-8")
