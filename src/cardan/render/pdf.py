"""A report as a document to sign: PDF/A with its fonts and alternative texts inside."""

import json
import re
from base64 import b64encode
from dataclasses import asdict
from html import escape, unescape
from importlib.resources import files
from typing import Any

from cardan.core.optional_import import import_optional
from cardan.render.blocks import Figures, Picture, ReportDocument
from cardan.render.fonts import (
    DISPLAYABLE_DRAWING_CHARACTERS,
    MISSING_GLYPH,
    apply_to_all_texts,
    collect_texts,
    insert_address_breaks,
    insert_word_breaks,
    missing_characters,
    replace_missing_characters,
    truncate,
)
from cardan.render.i18n import Translator
from cardan.render.svg import Figure

FONT_NAME = "Libertinus Serif"
"""The typesetter brings it along; drawings are set in it too."""

PDF_STANDARD = "a-3a"
"""PDF/A-3, level A: to be kept, and tagged for screen readers."""

(
    MAX_TITLE_CHARACTERS,
    MAX_FOOTER_TITLE_CHARACTERS,
    MAX_TEXT_COLUMN_HEAD_CHARACTERS,
    MAX_NUMBER_COLUMN_HEAD_CHARACTERS,
    MAX_CELL_CHARACTERS,
    MAX_PARAGRAPH_CHARACTERS,
) = 200, 80, 48, 24, 300, 4000
"""Characters that have room: on the cover, at a page's foot, in tables (over words, over
numbers, in a cell), in a text."""

MAX_PICTURE_HEIGHT_TO_TEXT_WIDTH_RATIO = 1.1
"""Height of a picture over the width of the text, at most: a page cuts off what is taller."""

TEXT_WIDTH_MM = 178.0
"""Of a page of the template: A4 less its margins."""

MAX_LISTED_MISSING_CHARACTERS = 12
"""How many letters are named that the fonts lack."""

_SUSPECTS_ENTRY = b"/Suspects false"
_SUSPECTS_PADDING = b" " * len(_SUSPECTS_ENTRY)

_SVG_TEXT = re.compile(r">([^<]+)<")


def pdf_document(of: ReportDocument) -> bytes:
    """Return a story as a PDF document.

    Nothing is fetched and no font of this computer is used, so that the same story gives
    the same document everywhere.

    Raises
    ------
    MissingDependencyError
        If typst is not installed.
    """
    # Without the entry no suspects is meant too, and poppler, which takes a `false` for a
    # mistake, is content. Blanks keep every other object where the file says it is.
    return _compile_document(of, format="pdf", pdf_standards=[PDF_STANDARD]).replace(
        _SUSPECTS_ENTRY, _SUSPECTS_PADDING
    )


def page_images(of: ReportDocument, *, ppi: float) -> list[bytes]:
    """Return the pages of the same document as PNG pictures, to be looked at."""
    found = _compile_document(of, format="png", ppi=ppi)
    return found if isinstance(found, list) else [found]


def figure_png(figure: Figure, *, ppi: float = 144) -> bytes:
    """Return a figure as a PNG picture, in letters that every computer draws alike.

    Raises
    ------
    MissingDependencyError
        If typst is not installed.
    """
    typst = import_optional("typst")
    drawn = _printable_svg(figure.svg.replace("<svg ", f'<svg font-family="{FONT_NAME}" ', 1))
    page = '#set page(width: auto, height: auto, margin: 0pt)\n#image("figure.svg")\n'
    sources = {"main.typ": page.encode(), "figure.svg": drawn.encode()}
    found = typst.compile(sources, ignore_system_fonts=True, format="png", ppi=ppi)
    return found[0] if isinstance(found, list) else found


def _compile_document(of: ReportDocument, **options: Any) -> Any:
    """Return a story set by typst."""
    typst = import_optional("typst")
    template = files("cardan.render").joinpath("templates/report.typ").read_bytes()
    told, drawings = _document_data(of)
    sources = {"main.typ": template, "story.json": json.dumps(told).encode(), **drawings}
    return typst.compile(sources, ignore_system_fonts=True, **options)


def _png_size(png: bytes) -> tuple[int, int]:
    """Return width and height of a picture, in pixels."""
    return int.from_bytes(png[16:20], "big"), int.from_bytes(png[20:24], "big")


def _png_in_svg(png: bytes) -> str:
    """Return a picture inside a drawing: the typesetter takes its sources as text alone."""
    width, height = _png_size(png)
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{width}" height="{height}">'
        f'<image width="{width}" height="{height}" '
        f'href="data:image/png;base64,{b64encode(png).decode()}"/></svg>'
    )


def _document_data(of: ReportDocument) -> tuple[dict[str, Any], dict[str, bytes]]:
    """Return a story as plain data, and its drawings as files that the data names."""
    drawings: dict[str, str] = {}
    chapters: list[dict[str, Any]] = []
    for chapter in of.chapters:
        blocks: list[dict[str, Any]] = []
        for block in chapter.blocks:
            told: dict[str, Any] = {"kind": type(block).__name__, **asdict(block)}
            if isinstance(block, Figures):
                for figure in told["figures"]:
                    figure["width"] = _width_share(figure["svg"], block.max_height_mm)
                    figure["file"] = f"figure-{len(drawings) + 1}.svg"
                    svg = figure.pop("svg").replace("<svg ", f'<svg font-family="{FONT_NAME}" ', 1)
                    drawings[figure["file"]] = svg
            if isinstance(block, Picture):
                del told["scene"]
                told["file"] = f"figure-{len(drawings) + 1}.svg"
                png: bytes = told.pop("png")
                drawings[told["file"]] = _png_in_svg(png)
                width, height = _png_size(png)
                told["share"] = min(1.0, MAX_PICTURE_HEIGHT_TO_TEXT_WIDTH_RATIO * width / height)
            blocks.append(told)
        chapters.append({"title": chapter.title, "blocks": blocks})
    say = Translator(of.language)
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
        "is_sheet": of.is_sheet,
        "date": [int(part) for part in of.date.split("-")] if of.date else [],
    }
    if without := missing_characters(collect_texts(story)) | missing_characters(
        drawings.values(), letters=DISPLAYABLE_DRAWING_CHARACTERS
    ):
        story["facts"].append([say("Letters"), _missing_characters_note(sorted(without), say)])
    return _fitted_texts(story), {
        name: _printable_svg(svg).encode() for name, svg in drawings.items()
    }


def _width_share(svg: str, max_height_mm: float | None) -> float:
    """Return the share of the text's width that a drawing takes, so as not to be too tall."""
    box = re.search(r'viewBox="([^"]+)"', svg)
    if max_height_mm is None or box is None:
        return 1.0
    *_, width, height = map(float, box[1].split())
    return min(1.0, max_height_mm * width / (height * TEXT_WIDTH_MM))


def _printable_svg(svg: str) -> str:
    """Return a drawing in letters the fonts have, its lettering cut to what has room."""
    return _SVG_TEXT.sub(
        lambda found: f">{_printable_label(found[1])}<",
        replace_missing_characters(svg, letters=DISPLAYABLE_DRAWING_CHARACTERS),
    )


def _printable_label(lettering: str) -> str:
    """Return the lettering of a drawing, escaped as it is, cut to what has room."""
    return escape(truncate(unescape(lettering), MAX_CELL_CHARACTERS), quote=False)


def _missing_characters_note(without: list[str], say: Translator) -> str:
    """Return what says that letters are missing, and which."""
    named = [f"U+{ord(c):04X}" for c in without[:MAX_LISTED_MISSING_CHARACTERS]] + ["…"] * (
        len(without) > MAX_LISTED_MISSING_CHARACTERS
    )
    return say(
        "{sign} stands for letters that this document's fonts lack: {letters}.",
        sign=MISSING_GLYPH, letters=", ".join(named),
    )  # fmt: skip


def column_head(text: str, *, number: bool) -> str:
    """Return the head of a column; over numbers it takes no more width than they do.

    Of a long name with its unit in brackets the unit stays.
    """
    if not number:
        return truncate(text, MAX_TEXT_COLUMN_HEAD_CHARACTERS)
    name, bracket, unit = text.rpartition(" [")
    if not bracket or not unit.endswith("]"):
        name, bracket, unit = text, "", ""
    short = truncate(name, MAX_NUMBER_COLUMN_HEAD_CHARACTERS) + bracket + unit
    return insert_word_breaks(short, word=MAX_NUMBER_COLUMN_HEAD_CHARACTERS // 2)


def _fitted_texts(story: dict[str, Any]) -> dict[str, Any]:
    """Return a story in letters the fonts have, its names cut to what has room."""
    story = apply_to_all_texts(story, replace_missing_characters)
    for chapter in story["chapters"]:
        for block in chapter["blocks"]:
            if block["kind"] == "Table":
                heads = enumerate(block["head"])
                block["head"] = [column_head(t, number=k >= block["words"]) for k, t in heads]
                block["rows"] = apply_to_all_texts(
                    block["rows"], lambda t: insert_address_breaks(truncate(t, MAX_CELL_CHARACTERS))
                )
            elif block["kind"] != "CodeBlock":
                block.update(
                    apply_to_all_texts(block, lambda t: truncate(t, MAX_PARAGRAPH_CHARACTERS))
                )
        chapter["title"] = truncate(chapter["title"], MAX_TITLE_CHARACTERS)
    story["facts"] = apply_to_all_texts(
        story["facts"], lambda t: truncate(t, MAX_PARAGRAPH_CHARACTERS)
    )
    story["running"] = truncate(story["title"], MAX_FOOTER_TITLE_CHARACTERS)
    story |= {
        key: truncate(story[key], MAX_TITLE_CHARACTERS)
        for key in ("title", "subtitle", "verdict", "summary")
    }
    return apply_to_all_texts(story, insert_word_breaks)
