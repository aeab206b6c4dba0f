"""The notebook page runs, piece by piece, and shows what it came to."""

import re
import runpy
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
PAGE = (ROOT / "docs" / "notebook.md").read_text(encoding="utf-8")


@pytest.fixture(scope="module")
def page():
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(ROOT)
        return runpy.run_path(str(ROOT / "docs" / "hooks.py"))["executed"](PAGE)


@pytest.mark.slow
def test_every_piece_runs_and_shows_what_it_came_to(page):
    pieces = re.findall(r"^```python$", page, flags=re.MULTILINE)
    assert len(pieces) >= 12
    shown = re.findall(
        r"^```text$|^<div class=\"shown\">|^\*Not run here", page, flags=re.MULTILINE
    )
    assert len(shown) == len(pieces)
    assert "'fail'" in page
    assert "200 variants" in page


@pytest.mark.slow
def test_a_frame_is_shown_where_pandas_is(page):
    pytest.importorskip("pandas")
    assert "Not run here" not in page
    assert re.search(r"^verdict +count", page, flags=re.MULTILINE) or "verdict" in page
