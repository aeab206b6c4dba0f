"""Every page of the gallery runs and keeps its headline."""

import runpy
import sys
from pathlib import Path

import pytest

PAGES = sorted((Path(__file__).parents[2] / "docs" / "gallery").glob("*.py"))


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.stem)
def test_page_keeps_its_headline(page, monkeypatch):
    monkeypatch.setattr(sys, "argv", [str(page)])
    runpy.run_path(str(page), run_name="__main__")


def test_there_are_pages():
    assert PAGES
