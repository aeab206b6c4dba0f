"""Whatever stands in an application file, every medium shows it, and always in the same bytes."""

import json
import os
import random
import re
import subprocess
import sys
from dataclasses import replace
from html import escape
from html.parser import HTMLParser
from io import BytesIO
from typing import Any

import openpyxl
import pytest
import typst
from repository import EXAMPLES

from cardan.application import reader, templates
from cardan.approval.approval import approve_driveline
from cardan.checks.quantities.registry import QUANTITIES
from cardan.documents import approval_report as story
from cardan.documents.workbook import workbook_bytes
from cardan.render.fonts import (
    DISPLAYABLE_DRAWING_CHARACTERS,
    DISPLAYABLE_TEXT_CHARACTERS,
    insert_word_breaks,
    missing_characters,
    replace_missing_characters,
    truncate,
)
from cardan.render.html import html_page
from cardan.render.i18n import LANGUAGE_CODES, Translator, message_catalogue
from cardan.render.pdf import FONT_NAME, PDF_STANDARD, _document_data, pdf_document

EXAMPLE = EXAMPLES / "refuse-collector-6x2.yaml"
VAN = EXAMPLE.with_name("van.yaml")
SMALL = templates.template_text("small")
TITLE = "Two-piece driveline"
NAMES = {
    "long word": "n" * 199,
    "many words": "state " * 33,
    "Chinese": "牵引车",
    "emoji": "🚛👩‍🔧",
    "right to left": "שלום عربي",
    "marks": "x\u0336 e\u0301 a\u0308\u0323",
    "a sheet's name": "a/b[c]:*?'",
    "markup": "<b>&amp;</b> #panic() $x$ *b* @c",
    "a formula": "=1+1",
    "signs nobody sees": "c d\ue000",
}


def told(text: str, code: str = "en", **changed: Any) -> story.ReportDocument:
    """The story of a text; a design made in a program may have names no file may have."""
    issue = story.ReportDateAndSourceStamp(
        date="2026-11-20", file_names=("a.yaml",), fingerprints=("0" * 16,), file_texts=(text,)
    )
    found = approve_driveline(replace(reader.loads(text), **changed))
    return story.approval_report_from_results(
        found, helps=(), fixes=(), say=Translator(code), issue=issue
    )


def titled(title: str, text: str = SMALL) -> str:
    escaped = title.replace("\\", "\\\\").replace('"', '\\"')
    escaped = "".join(c if c.isprintable() else f"\\U{ord(c):08x}" for c in escaped)
    return text.replace(TITLE, f'"{escaped}"')


class Text(HTMLParser):
    """The text of a page's first heading."""

    def __init__(self, page: str) -> None:
        super().__init__()
        self.inside, self.heading = False, ""
        self.feed(page)

    def handle_starttag(self, tag, _):
        self.inside |= tag == "h1" and not self.heading

    def handle_endtag(self, tag):
        self.inside &= tag != "h1"

    def handle_data(self, data):
        self.heading += data if self.inside else ""


# --------------------------------------------------------------------------- letters


def shuffled(letters: frozenset[str]) -> list[str]:
    """Lines of all letters in a random order: beside any other, a font must be found for each."""
    each = sorted(letters - {"\n", "\t"})
    random.Random(1).shuffle(each)
    return ["".join(each[k : k + 50]) for k in range(0, len(each), 50)]


def test_every_character_of_pdf_is_in_its_fonts():
    """As text, bold, as a file's own text and in a drawing, in a document to be kept."""
    lines, drawn = shuffled(DISPLAYABLE_TEXT_CHARACTERS), shuffled(DISPLAYABLE_DRAWING_CHARACTERS)
    assert len("".join(lines)) > 4000
    assert len("".join(drawn)) > 1500
    svg = "".join(f"<text>{escape(line)}</text>" for line in drawn)
    source = f"""
        #set document(title: "x", date: datetime(year: 2026, month: 1, day: 1))
        #set text(lang: "en", font: "{FONT_NAME}")
        #for line in json("lines.json") {{ par(line); strong(line); raw(line, block: true) }}
        #image("all.svg", alt: "all letters")
    """
    head = '<svg xmlns="http://www.w3.org/2000/svg" width="9" height="9"'
    sources = {
        "main.typ": source.encode(),
        "lines.json": json.dumps(lines).encode(),
        "all.svg": f'{head} font-family="{FONT_NAME}">{svg}</svg>'.encode(),
    }
    made = typst.compile(
        sources, ignore_system_fonts=True, format="pdf", pdf_standards=[PDF_STANDARD]
    )
    assert made.startswith(b"%PDF-")


@pytest.mark.slow
@pytest.mark.parametrize("path", sorted(EXAMPLE.parent.glob("*.yaml")), ids=lambda p: p.stem)
def test_program_texts_use_available_characters_only(path):
    # Nobody sees what stands between the plural forms of a text; every form is shown.
    said = [
        t
        for c in LANGUAGE_CODES
        for (_, english), other in message_catalogue(c).items()
        for t in (english, *other.split("\0"))
    ]
    for q in QUANTITIES.values():
        said += [
            q.symbol,
            q.equation_text,
            q.unit_symbol,
            q.name,
            *q.symbol_meanings,
            str(q.source),
        ]
    assert missing_characters(said) == set()
    whole = told(path.read_text(encoding="utf-8"))
    assert (
        missing_characters(
            [f.svg for f in story.all_figures(whole)], letters=DISPLAYABLE_DRAWING_CHARACTERS
        )
        == set()
    )
    data = _document_data(whole)[0]
    assert "□" not in str(data)
    tables = [b for c in data["chapters"] for b in c["blocks"] if b["kind"] == "Table"]
    assert [head for t in tables for head in t["head"] if "…" in head] == []


@pytest.mark.parametrize(
    ("text", "seen"),
    [
        ("β = 7° − ½", "β = 7° − ½"), ("e\u0301", "é"), ("x\u0336", "x□"), ("a中b😀", "a□b□"),
        ("a\r\nb\rc\td", "a\nb\nc\td"), ("שלום", "שלום"), ("\u202e", "□"), ("\ud800", "□"),
    ],
)  # fmt: skip
def test_missing_character_is_shown_as_empty_square(text, seen):
    assert replace_missing_characters(text) == seen
    assert bool(missing_characters([text])) == ("□" in seen)


def test_long_text_is_shortened_and_long_words_are_broken():
    assert truncate("abc def", 7) == "abc def"
    assert truncate("abc defg", 7) == "abc de…"
    assert truncate("abc defg", 5) == "abc…"
    assert insert_word_breaks("n" * 40) == "n" * 40
    assert insert_word_breaks("n" * 100).split("\u200b") == ["n" * 40, "n" * 40, "n" * 20]
    assert insert_word_breaks("word " * 100) == "word " * 100
    assert (
        insert_word_breaks(insert_word_breaks("n" * 24, word=12)) == "n" * 12 + "\u200b" + "n" * 12
    )


@pytest.mark.slow
@pytest.mark.parametrize("code", LANGUAGE_CODES)
def test_missing_chinese_characters_are_listed_in_pdf(code):
    """The file stands in the document as it is: any 中 in a comment ended `--pdf` in a fault."""
    plain = told(SMALL, code)
    assert "Letters" not in str(_document_data(plain)[0]["facts"])
    text = SMALL + "# 中文\n"
    whole = told(text, code)
    facts = _document_data(whole)[0]["facts"]
    assert facts[:-1] == _document_data(plain)[0]["facts"]
    name, said = facts[-1]
    assert name == Translator(code)("Letters")
    assert said.startswith("□ ")
    assert said.endswith(" U+4E2D, U+6587.")
    (verbatim,) = [
        b
        for c in _document_data(whole)[0]["chapters"]
        for b in c["blocks"]
        if b["kind"] == "CodeBlock"
    ]
    assert verbatim["text"].endswith("# □□\n")
    assert pdf_document(whole).startswith(b"%PDF-")


@pytest.mark.slow
def test_list_of_missing_characters_is_shortened():
    many = "".join(map(chr, range(0x4E00, 0x9F00)))
    whole = told(SMALL + f"# {many}\n")
    assert _document_data(whole)[0]["facts"][-1][1].endswith("U+4E0A, U+4E0B, ….")
    assert pdf_document(whole).startswith(b"%PDF-")


# --------------------------------------------------------------------------- names


@pytest.mark.slow
@pytest.mark.parametrize("kind", NAMES)
def test_any_title_is_accepted_in_every_medium(kind):
    text = titled(NAMES[kind])
    whole = told(text)
    assert whole.title == NAMES[kind].strip() or whole.title == NAMES[kind]
    assert pdf_document(whole).startswith(b"%PDF-")
    assert Text(html_page(whole)).heading.strip() == truncate(whole.title, 200).strip()
    data = workbook_bytes(approve_driveline(reader.loads(text)), say=Translator("en"))
    assert openpyxl.load_workbook(BytesIO(data)).sheetnames


@pytest.mark.slow
@pytest.mark.parametrize("first", range(0, len(NAMES), 3))
def test_any_state_or_part_name_is_accepted_in_every_medium(first):
    text = EXAMPLE.read_text(encoding="utf-8")
    kinds = [*NAMES.values(), *NAMES.values()][first : first + 3]
    for name, new in zip(("full rebound", "windup", "auxiliary beam"), kinds, strict=True):
        changed = titled(name[0] + new, text.replace(f"name: {name}", f"name: {TITLE}"))
        assert changed != text
        text = changed
    whole = told(text)
    assert pdf_document(whole).startswith(b"%PDF-")
    assert html_page(whole).encode()
    data = workbook_bytes(approve_driveline(reader.loads(text)), say=Translator("en"))
    assert openpyxl.load_workbook(BytesIO(data)).sheetnames


@pytest.mark.slow
@pytest.mark.parametrize("title", ["x" * 20_000, "word " * 4000])
def test_overlong_title_is_shortened_with_ellipsis(title):
    """20,000 letters in one word: a string of a PDF has no room for them."""
    whole = told(SMALL, title=title)
    data = _document_data(whole)[0]
    for key, most in (("title", 200), ("running", 80)):
        assert data[key].endswith("…")
        assert len(data[key].replace("\u200b", "")) <= most
    assert pdf_document(whole).startswith(b"%PDF-")
    assert Text(html_page(whole)).heading.strip() == truncate(whole.title, 200)


@pytest.mark.slow
def test_drawings_use_their_own_character_set():
    """Lettering of three fonts in a drawing is refused where a text may mix them."""
    text = EXAMPLE.read_text(encoding="utf-8").replace("name: full rebound", 'name: "⊡⭧╪Ա⯲"')
    data, drawings = _document_data(told(text))
    assert (
        missing_characters(
            [d.decode() for d in drawings.values()], letters=DISPLAYABLE_DRAWING_CHARACTERS
        )
        == set()
    )
    assert "U+0531" in data["facts"][-1][1]
    assert "⊡⭧╪Ա⯲" in str(data["chapters"])


@pytest.mark.slow
def test_overlong_names_in_drawings_are_shortened():
    """40,000 letters at a point of a chart took the typesetter twenty seconds."""
    text = EXAMPLE.read_text(encoding="utf-8")
    (beam,) = reader.loads(text).obstacles
    drawings = _document_data(told(text, obstacles=(replace(beam, name="k" * 40_000),)))[1]
    assert max(len(run) for svg in drawings.values() for run in re.findall(rb"k+", svg)) < 4001
    lettering = [t for svg in drawings.values() for t in re.findall(rb">([^<]*)<", svg)]
    assert max(len(t) for t in lettering) <= 300 + len("…".encode())


# --------------------------------------------------------------------------- the same bytes


@pytest.mark.slow
def test_reports_are_byte_reproducible_in_every_medium(tmp_path):
    """In two processes that hash differently, with a second between them."""
    made: list[dict[str, bytes]] = []
    for seed in ("1", "2"):
        folder = tmp_path / seed
        folder.mkdir()
        outputs = {kind: folder / f"out.{kind}" for kind in ("json", "html", "pdf", "xlsx")}
        named = [word for kind, out in outputs.items() for word in (f"--{kind}", str(out))]
        subprocess.run(
            [sys.executable, "-m", "cardan", "check", "-q", str(VAN), *named],
            env={**os.environ, "PYTHONHASHSEED": seed}, capture_output=True, check=False,
        )  # fmt: skip
        made.append({kind: out.read_bytes() for kind, out in outputs.items()})
    assert [k for k in made[0] if made[0][k] != made[1][k]] == []
