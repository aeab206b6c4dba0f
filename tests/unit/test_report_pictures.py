"""The pictures of sample reports in the documentation can be made again."""

import runpy
from io import BytesIO
from pathlib import Path

import pytest

from cardan import files
from cardan.report import story
from cardan.report.language import CODES, Language
from cardan.study.approval import assess

ROOT = Path(__file__).parents[2]


def test_a_sample_report_becomes_a_picture():
    image = pytest.importorskip("PIL.Image", reason="pictures are made with Pillow")
    pytest.importorskip("typst", reason="documents are set by typst")
    make = runpy.run_path(str(ROOT / "docs/reports/make.py"))
    found = assess(files.read(ROOT / "examples/three-joint-chain.yaml"))
    issue = story.Issue(date="2026-11-20", files=("a.yaml",), prints=("",))
    told = story.approval(found, helps=(), fixes=(), say=Language("pt"), issue=issue)
    kept = BytesIO()
    make["picture"](told).save(kept, "png")
    read = image.open(BytesIO(kept.getvalue()))
    assert read.width > 1.5 * read.height > 0  # pages side by side
    assert len(read.getcolors(make["COLOURS"] + 1)) > 8  # something is drawn on them


def test_a_check_of_the_driveline_is_no_other_studys():
    """Its rows stood a second time under what other studies found, as `warn ()`."""
    found = assess(files.read(ROOT / "examples/three-joint-chain.yaml"))
    assert found.verdict == "warn"
    for code in CODES:
        issue = story.Issue(date="2026-11-20", files=("a.yaml",), prints=("",))
        told = story.approval(found, helps=(), fixes=(), say=Language(code), issue=issue)
        assert "(): " not in str(told)
        assert "MIME-Version" not in str(told)


def test_pictures_are_of_examples_in_every_language():
    examples = {p.stem for p in (ROOT / "examples").glob("*.yaml")}
    shown: dict[str, set[str]] = {}
    for picture in (ROOT / "docs/reports").glob("*.png"):
        stem, code, _ = picture.name.split(".")
        shown.setdefault(stem, set()).add(code)
    assert len(shown) >= 5
    assert set(shown) <= examples
    assert all(codes == set(CODES) for codes in shown.values())
