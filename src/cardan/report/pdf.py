"""A report as a document to sign: PDF/A with its fonts and alternative texts inside."""

import json
import re
from base64 import b64encode
from dataclasses import asdict
from html import escape, unescape
from importlib.resources import files
from typing import Any

from cardan.report.blocks import Figures, Picture, Story
from cardan.report.extra import needed
from cardan.report.language import Language
from cardan.report.paper import (
    DRAWN,
    INSTEAD,
    broken,
    each,
    lacking,
    shortened,
    shown,
    texts,
)
from cardan.report.svg import Figure

FONT = "Libertinus Serif"
"""The typesetter brings it along; drawings are set in it too."""

STANDARD = "a-3a"
"""PDF/A-3, level A: to be kept, and tagged for whoever has it read to them."""

TITLE, RUNNING, HEAD, NARROW, CELL, PARAGRAPH = 200, 80, 48, 24, 300, 4000
"""Characters that have room: on the cover, at a page's foot, in tables (over words, over
numbers, in a cell), in a text."""

TALLEST = 1.1
"""Height of a picture over the width of the text, at most: a page cuts off what is taller."""

NAMED = 12
"""How many letters are named that the fonts lack."""

_NO_SUSPECTS = b"/Suspects false"
_BLANKS = b" " * len(_NO_SUSPECTS)

_LETTERING = re.compile(r">([^<]+)<")


def document(of: Story) -> bytes:
    """Return a story as a PDF document.

    Nothing is fetched and no font of this computer is used, so that the same story gives
    the same document everywhere.

    Raises
    ------
    MissingExtra
        If typst is not installed.
    """
    # Without the entry no suspects is meant too, and poppler, which takes a `false` for a
    # mistake, is content. Blanks keep every other object where the file says it is.
    return _set(of, format="pdf", pdf_standards=[STANDARD]).replace(_NO_SUSPECTS, _BLANKS)


def pages(of: Story, *, ppi: float) -> list[bytes]:
    """Return the pages of the same document as PNG pictures, to be looked at."""
    found = _set(of, format="png", ppi=ppi)
    return found if isinstance(found, list) else [found]


def pixels(figure: Figure, *, ppi: float = 144) -> bytes:
    """Return a figure as a PNG picture, in letters that every computer draws alike.

    Raises
    ------
    MissingExtra
        If typst is not installed.
    """
    typst = needed("typst")
    drawn = _drawn(figure.svg.replace("<svg ", f'<svg font-family="{FONT}" ', 1))
    page = '#set page(width: auto, height: auto, margin: 0pt)\n#image("figure.svg")\n'
    sources = {"main.typ": page.encode(), "figure.svg": drawn.encode()}
    found = typst.compile(sources, ignore_system_fonts=True, format="png", ppi=ppi)
    return found[0] if isinstance(found, list) else found


def _set(of: Story, **options: Any) -> Any:
    """Return a story set by typst."""
    typst = needed("typst")
    template = files("cardan.report").joinpath("templates/report.typ").read_bytes()
    told, drawings = _told(of)
    sources = {"main.typ": template, "story.json": json.dumps(told).encode(), **drawings}
    return typst.compile(sources, ignore_system_fonts=True, **options)


def _size(png: bytes) -> tuple[int, int]:
    """Return width and height of a picture, in pixels."""
    return int.from_bytes(png[16:20], "big"), int.from_bytes(png[20:24], "big")


def _wrapped(png: bytes) -> str:
    """Return a picture inside a drawing: the typesetter takes its sources as text alone."""
    width, height = _size(png)
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{width}" height="{height}">'
        f'<image width="{width}" height="{height}" '
        f'href="data:image/png;base64,{b64encode(png).decode()}"/></svg>'
    )


def _told(of: Story) -> tuple[dict[str, Any], dict[str, bytes]]:
    """Return a story as plain data, and its drawings as files that the data names."""
    drawings: dict[str, str] = {}
    chapters: list[dict[str, Any]] = []
    for chapter in of.chapters:
        blocks: list[dict[str, Any]] = []
        for block in chapter.blocks:
            told: dict[str, Any] = {"kind": type(block).__name__, **asdict(block)}
            if isinstance(block, Figures):
                for figure in told["figures"]:
                    figure["file"] = f"figure-{len(drawings) + 1}.svg"
                    svg = figure.pop("svg").replace("<svg ", f'<svg font-family="{FONT}" ', 1)
                    drawings[figure["file"]] = svg
            if isinstance(block, Picture):
                del told["scene"]
                told["file"] = f"figure-{len(drawings) + 1}.svg"
                png: bytes = told.pop("png")
                drawings[told["file"]] = _wrapped(png)
                width, height = _size(png)
                told["share"] = min(1.0, TALLEST * width / height)
            blocks.append(told)
        chapters.append({"title": chapter.title, "blocks": blocks})
    say = Language(of.language)
    story: dict[str, Any] = {
        "language": of.language,
        "title": of.title,
        "subtitle": of.subtitle,
        "grade": of.grade,
        "verdict": of.verdict,
        "summary": of.summary,
        "facts": [list(f) for f in of.facts],
        "chapters": chapters,
        "made": say("Made with cardan {version}.", version=of.version),
        "date": [int(part) for part in of.date.split("-")] if of.date else [],
    }
    if without := lacking(texts(story)) | lacking(drawings.values(), letters=DRAWN):
        story["facts"].append([say("Letters"), _owned(sorted(without), say)])
    return _fitted(story), {name: _drawn(svg).encode() for name, svg in drawings.items()}


def _drawn(svg: str) -> str:
    """Return a drawing in letters the fonts have, its lettering cut to what has room."""
    return _LETTERING.sub(lambda found: f">{_cut(found[1])}<", shown(svg, letters=DRAWN))


def _cut(lettering: str) -> str:
    """Return the lettering of a drawing, escaped as it is, cut to what has room."""
    return escape(shortened(unescape(lettering), CELL), quote=False)


def _owned(without: list[str], say: Language) -> str:
    """Return what says that letters are missing, and which."""
    named = [f"U+{ord(c):04X}" for c in without[:NAMED]] + ["…"] * (len(without) > NAMED)
    return say(
        "{sign} stands for letters that this document's fonts lack: {letters}.",
        sign=INSTEAD, letters=", ".join(named),
    )  # fmt: skip


def _headed(text: str, *, number: bool) -> str:
    """Return the head of a column; over numbers it takes no more width than they do."""
    return broken(shortened(text, NARROW), word=NARROW // 2) if number else shortened(text, HEAD)


def _fitted(story: dict[str, Any]) -> dict[str, Any]:
    """Return a story in letters the fonts have, its names cut to what has room."""
    story = each(story, shown)
    for chapter in story["chapters"]:
        for block in chapter["blocks"]:
            if block["kind"] == "Table":
                heads = enumerate(block["head"])
                block["head"] = [_headed(t, number=k >= block["words"]) for k, t in heads]
                block["rows"] = each(block["rows"], lambda t: shortened(t, CELL))
            elif block["kind"] != "Verbatim":
                block.update(each(block, lambda t: shortened(t, PARAGRAPH)))
        chapter["title"] = shortened(chapter["title"], TITLE)
    story["facts"] = each(story["facts"], lambda t: shortened(t, PARAGRAPH))
    story["running"] = shortened(story["title"], RUNNING)
    story |= {
        key: shortened(story[key], TITLE) for key in ("title", "subtitle", "verdict", "summary")
    }
    return each(story, broken)
