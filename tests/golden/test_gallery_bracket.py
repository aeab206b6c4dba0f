"""The gallery's page on the bracket asserts its own headline."""

import runpy
from pathlib import Path

import pytest

PAGE = Path(__file__).parents[2] / "docs" / "gallery" / "bracket_failure.py"


@pytest.mark.bracket
def test_the_page_holds(capsys):
    runpy.run_path(str(PAGE))
    assert "recording, crawling" in capsys.readouterr().out
