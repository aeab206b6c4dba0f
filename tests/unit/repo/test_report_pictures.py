"""The pictures in the documentation can be made again, and show numbers of today."""

import json
import runpy
from fnmatch import fnmatch
from io import BytesIO

import pytest
from repository import ROOT

from cardan.application import reader
from cardan.approval.approval import approve_driveline
from cardan.documents import approval_report as story
from cardan.render.i18n import LANGUAGE_CODES, Translator


@pytest.mark.slow
def test_sample_report_is_rendered_as_picture():
    image = pytest.importorskip("PIL.Image", reason="pictures are made with Pillow")
    pytest.importorskip("typst", reason="documents are set by typst")
    make = runpy.run_path(str(ROOT / "docs/reports/make.py"))
    found = approve_driveline(reader.read(ROOT / "examples/three-joint-chain.yaml"))
    issue = story.ReportDateAndSourceStamp(
        date="2026-11-20", file_names=("a.yaml",), fingerprints=("",)
    )
    told = story.approval_report_from_results(
        found, helps=(), fixes=(), say=Translator("pt"), issue=issue
    )
    kept = BytesIO()
    make["picture"](told).save(kept, "png")
    read = image.open(BytesIO(kept.getvalue()))
    assert read.width > 1.5 * read.height > 0  # pages side by side
    assert len(read.getcolors(make["COLOURS"] + 1)) > 8  # something is drawn on them


def test_driveline_check_is_not_repeated_under_other_studies():
    """Its rows stood a second time under what other studies found, as `warn ()`."""
    found = approve_driveline(reader.read(ROOT / "examples/three-joint-chain.yaml"))
    assert found.verdict == "warn"
    for code in LANGUAGE_CODES:
        issue = story.ReportDateAndSourceStamp(
            date="2026-11-20", file_names=("a.yaml",), fingerprints=("",)
        )
        told = story.approval_report_from_results(
            found, helps=(), fixes=(), say=Translator(code), issue=issue
        )
        assert "(): " not in str(told)
        assert "MIME-Version" not in str(told)


def test_report_pictures_are_of_examples_in_every_language():
    examples = {p.stem for p in (ROOT / "examples").glob("*.yaml")}
    shown: dict[str, set[str]] = {}
    for picture in (ROOT / "docs/reports").glob("*.png"):
        stem, code, _ = picture.name.split(".")
        shown.setdefault(stem, set()).add(code)
    assert len(shown) >= 5
    assert set(shown) <= examples
    assert all(codes == set(LANGUAGE_CODES) for codes in shown.values())


DRAWN_ELSEWHERE = {"case.png"}
"""Of recordings: its numbers are those of docs/case.md (tests/verify/test_collector.py)."""
NUMBERS = json.loads((ROOT / "docs/pictures.json").read_text(encoding="utf-8"))
value_ranges = runpy.run_path(str(ROOT / "docs/picture_numbers.py"))["value_ranges"]


def test_every_picture_has_its_numbers_on_record():
    docs = ROOT / "docs"
    files = [docs / "live.html", *docs.glob("*.png"), *docs.glob("reports/*.png")]
    names = {str(f.relative_to(docs)) for f in files} - DRAWN_ELSEWHERE
    assert len(names) > 30
    assert {n for n in names if not any(fnmatch(n, pattern) for pattern in NUMBERS)} == set()


@pytest.mark.parametrize("pictures", NUMBERS)
def test_pictures_show_numbers_of_today(pictures):
    """Four digits are printed; those that moved need `make pictures`, or its scripts by name."""
    example = NUMBERS[pictures]["example"]
    golden = json.loads((ROOT / f"tests/golden/{example}.json").read_text(encoding="utf-8"))
    now = value_ranges((quantity, value) for quantity, _, _, _, value, *_ in golden["checks"])
    assert NUMBERS[pictures]["verdict"] == golden["verdict"]
    assert set(NUMBERS[pictures]["values"]) == set(now)
    moved = {
        quantity: (shown, now[quantity])
        for quantity, shown in NUMBERS[pictures]["values"].items()
        if shown != pytest.approx(now[quantity], rel=2e-3, abs=1e-6)
    }
    assert moved == {}
