"""Every page of the gallery runs, and its headline holds."""

import runpy

import pytest
from repository import ROOT

PAGES = sorted((ROOT / "docs" / "gallery").glob("*.py"))


LONG = (
    "run_up", "parametric_torsion", "composite_tube", "shimmy", "who_broke_the_bracket",
    "lateral_flutter", "misaligned_shaft", "truck_torsion", "bracket_failure",
)  # fmt: skip
"""Pages that take ten seconds and more: the build of the documentation runs them too."""


def needs(page):
    """Pages that solve a bracket need its extra; some are long, and asked by hand."""
    text = page.read_text(encoding="utf-8")
    marks = (
        [pytest.mark.bracket]
        if "cardan.physics.fem" in text or "cardan.topics.bracket" in text
        else []
    )
    return [*marks, *([pytest.mark.long] if page.stem in LONG else [])]


@pytest.mark.slow
@pytest.mark.parametrize("page", [pytest.param(p, marks=needs(p), id=p.stem) for p in PAGES])
def test_gallery_page_runs_and_draws_with_matplotlib_if_used(page, monkeypatch):
    pyplot = pytest.importorskip("matplotlib.pyplot", reason="the gallery draws with matplotlib")
    pyplot.switch_backend("agg")
    monkeypatch.setattr(pyplot, "show", lambda: None)
    try:
        runpy.run_path(str(page))
        assert bool(pyplot.get_fignums()) == ("matplotlib" in page.read_text(encoding="utf-8"))
    finally:
        pyplot.close("all")


def test_gallery_has_at_least_eleven_pages():
    assert len(PAGES) >= 11
