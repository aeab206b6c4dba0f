"""Every page of the gallery runs, and its headline holds."""

import runpy
from pathlib import Path

import pytest

PAGES = sorted((Path(__file__).parents[2] / "docs" / "gallery").glob("*.py"))


LONG = (
    "run_up", "parametric_torsion", "composite_tube", "shimmy", "who_broke_the_bracket",
    "lateral_flutter", "misaligned_shaft", "truck_torsion",
)  # fmt: skip
"""Pages that take ten seconds and more: the build of the documentation runs them too."""


def needs(page):
    """Pages that solve a bracket need its extra; some are long, and asked by hand."""
    marks = [pytest.mark.bracket] if "study.bracket" in page.read_text(encoding="utf-8") else []
    return [*marks, *([pytest.mark.long] if page.stem in LONG else [])]


@pytest.mark.parametrize("page", [pytest.param(p, marks=needs(p), id=p.stem) for p in PAGES])
def test_page(page, monkeypatch):
    pyplot = pytest.importorskip("matplotlib.pyplot", reason="the gallery draws with matplotlib")
    pyplot.switch_backend("agg")
    monkeypatch.setattr(pyplot, "show", lambda: None)
    try:
        runpy.run_path(str(page))
        assert bool(pyplot.get_fignums()) == ("matplotlib" in page.read_text(encoding="utf-8"))
    finally:
        pyplot.close("all")


def test_there_are_pages():
    assert len(PAGES) >= 11
