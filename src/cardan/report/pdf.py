"""A report as a document to sign: PDF/A with its fonts and alternative texts inside."""

import json
from base64 import b64encode
from dataclasses import asdict
from importlib.resources import files
from typing import Any

from cardan.report.blocks import Figures, Picture, Story
from cardan.report.extra import needed
from cardan.report.language import Language

FONT = "Libertinus Serif"
"""The typesetter brings it along; drawings are set in it too."""

STANDARD = "a-3a"
"""PDF/A-3, level A: to be kept, and tagged for whoever has it read to them."""


def document(of: Story) -> bytes:
    """Return a story as a PDF document.

    Nothing is fetched and no font of this computer is used, so that the same story gives
    the same document everywhere.

    Raises
    ------
    MissingExtra
        If typst is not installed.
    """
    return _set(of, format="pdf", pdf_standards=[STANDARD])


def pages(of: Story, *, ppi: float) -> list[bytes]:
    """Return the pages of the same document as PNG pictures, to be looked at."""
    found = _set(of, format="png", ppi=ppi)
    return found if isinstance(found, list) else [found]


def _set(of: Story, **options: Any) -> Any:
    """Return a story set by typst."""
    typst = needed("typst")
    template = files("cardan.report").joinpath("templates/report.typ").read_bytes()
    told, drawings = _told(of)
    sources = {"main.typ": template, "story.json": json.dumps(told).encode(), **drawings}
    return typst.compile(sources, ignore_system_fonts=True, **options)


def _wrapped(png: bytes) -> bytes:
    """Return a picture inside a drawing: the typesetter takes its sources as text alone."""
    width, height = (int.from_bytes(png[at : at + 4], "big") for at in (16, 20))
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{width}" height="{height}">'
        f'<image width="{width}" height="{height}" '
        f'href="data:image/png;base64,{b64encode(png).decode()}"/></svg>'
    ).encode()


def _told(of: Story) -> tuple[dict[str, Any], dict[str, bytes]]:
    """Return a story as plain data, and its drawings as files that the data names."""
    drawings: dict[str, bytes] = {}
    chapters: list[dict[str, Any]] = []
    for chapter in of.chapters:
        blocks: list[dict[str, Any]] = []
        for block in chapter.blocks:
            told: dict[str, Any] = {"kind": type(block).__name__, **asdict(block)}
            if isinstance(block, Figures):
                for figure in told["figures"]:
                    figure["file"] = f"figure-{len(drawings) + 1}.svg"
                    svg = figure.pop("svg").replace("<svg ", f'<svg font-family="{FONT}" ', 1)
                    drawings[figure["file"]] = svg.encode()
            if isinstance(block, Picture):
                del told["scene"]
                told["file"] = f"figure-{len(drawings) + 1}.svg"
                drawings[told["file"]] = _wrapped(told.pop("png"))
            blocks.append(told)
        chapters.append({"title": chapter.title, "blocks": blocks})
    made = Language(of.language)("Made with cardan {version}.", version=of.version)
    story = {
        "language": of.language,
        "title": of.title,
        "subtitle": of.subtitle,
        "grade": of.grade,
        "verdict": of.verdict,
        "facts": [list(f) for f in of.facts],
        "chapters": chapters,
        "made": made,
        "date": [int(part) for part in of.date.split("-")] if of.date else [],
    }
    return story, drawings
