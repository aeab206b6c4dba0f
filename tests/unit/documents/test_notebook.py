"""The notebook page runs, piece by piece, and shows what it came to."""

import re
import runpy

import pytest
from repository import ROOT

PAGE = (ROOT / "docs" / "notebook.md").read_text(encoding="utf-8")


@pytest.fixture(scope="module")
def page():
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(ROOT)
        return runpy.run_path(str(ROOT / "docs" / "hooks.py"))["executed"](PAGE)


@pytest.mark.slow
def test_every_code_block_of_notebook_page_shows_its_output(page):
    pieces = re.findall(r"^```python$", page, flags=re.MULTILINE)
    assert len(pieces) >= 12
    shown = re.findall(
        r"^```text$|^<div class=\"shown\">|^\*Not run here", page, flags=re.MULTILINE
    )
    assert len(shown) == len(pieces)
    assert "'fail'" in page
    assert "200 variants" in page


@pytest.mark.slow
def test_data_frame_is_shown_if_pandas_is_installed(page):
    pytest.importorskip("pandas")
    assert "Not run here" not in page
    assert re.search(r"^verdict +count", page, flags=re.MULTILINE) or "verdict" in page
