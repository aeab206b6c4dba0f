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
from pathlib import Path
from typing import Any

import openpyxl
import pytest
import typst

from cardan import files
from cardan.quantity.quantities import QUANTITIES
from cardan.report import story
from cardan.report.html import page
from cardan.report.language import CODES, Language, catalogue
from cardan.report.paper import DRAWN, LETTERS, broken, lacking, shortened, shown
from cardan.report.pdf import FONT, STANDARD, _told, document
from cardan.report.workbook import workbook
from cardan.study.approval import assess

EXAMPLE = Path(__file__).parents[2] / "examples" / "refuse-collector-6x2.yaml"
VAN = EXAMPLE.with_name("van.yaml")
SMALL = files.starter("small")
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


def told(text: str, code: str = "en", **changed: Any) -> story.Story:
    """The story of a text; a design made in a program may have names no file may have."""
    issue = story.Issue(date="2026-11-20", files=("a.yaml",), prints=("0" * 16,), texts=(text,))
    found = assess(replace(files.loads(text), **changed))
    return story.approval(found, helps=(), fixes=(), say=Language(code), issue=issue)


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


def test_every_letter_a_document_shows_is_in_its_fonts():
    """As text, bold, as a file's own text and in a drawing, in a document to be kept."""
    lines, drawn = shuffled(LETTERS), shuffled(DRAWN)
    assert len("".join(lines)) > 4000
    assert len("".join(drawn)) > 1500
    svg = "".join(f"<text>{escape(line)}</text>" for line in drawn)
    source = f"""
        #set document(title: "x", date: datetime(year: 2026, month: 1, day: 1))
        #set text(lang: "en", font: "{FONT}")
        #for line in json("lines.json") {{ par(line); strong(line); raw(line, block: true) }}
        #image("all.svg", alt: "all letters")
    """
    head = '<svg xmlns="http://www.w3.org/2000/svg" width="9" height="9"'
    sources = {
        "main.typ": source.encode(),
        "lines.json": json.dumps(lines).encode(),
        "all.svg": f'{head} font-family="{FONT}">{svg}</svg>'.encode(),
    }
    made = typst.compile(sources, ignore_system_fonts=True, format="pdf", pdf_standards=[STANDARD])
    assert made.startswith(b"%PDF-")


@pytest.mark.slow
@pytest.mark.parametrize("path", sorted(EXAMPLE.parent.glob("*.yaml")), ids=lambda p: p.stem)
def test_the_programs_own_letters_are_among_them(path):
    # Nobody sees what stands between the plural forms of a text; every form is shown.
    said = [
        t
        for c in CODES
        for (_, english), other in catalogue(c).items()
        for t in (english, *other.split("\0"))
    ]
    for q in QUANTITIES.values():
        said += [q.symbol, q.stated, q.unit_name, q.name, *q.where, str(q.source)]
    assert lacking(said) == set()
    whole = told(path.read_text(encoding="utf-8"))
    assert lacking([f.svg for f in story.figures(whole)], letters=DRAWN) == set()
    data = _told(whole)[0]
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
def test_what_is_lacking_is_an_empty_square(text, seen):
    assert shown(text) == seen
    assert bool(lacking([text])) == ("□" in seen)


def test_long_texts_are_cut_where_it_is_seen_and_long_words_are_broken():
    assert shortened("abc def", 7) == "abc def"
    assert shortened("abc defg", 7) == "abc de…"
    assert shortened("abc defg", 5) == "abc…"
    assert broken("n" * 40) == "n" * 40
    assert broken("n" * 100).split("\u200b") == ["n" * 40, "n" * 40, "n" * 20]
    assert broken("word " * 100) == "word " * 100
    assert broken(broken("n" * 24, word=12)) == "n" * 12 + "\u200b" + "n" * 12


@pytest.mark.parametrize("code", CODES)
def test_a_comment_in_chinese_is_printed_and_owned_up_to(code):
    """The file stands in the document as it is: any 中 in a comment ended `--pdf` in a fault."""
    plain = told(SMALL, code)
    assert "Letters" not in str(_told(plain)[0]["facts"])
    text = SMALL + "# 中文\n"
    whole = told(text, code)
    facts = _told(whole)[0]["facts"]
    assert facts[:-1] == _told(plain)[0]["facts"]
    name, said = facts[-1]
    assert name == Language(code)("Letters")
    assert said.startswith("□ ")
    assert said.endswith(" U+4E2D, U+6587.")
    (verbatim,) = [
        b for c in _told(whole)[0]["chapters"] for b in c["blocks"] if b["kind"] == "Verbatim"
    ]
    assert verbatim["text"].endswith("# □□\n")
    assert document(whole).startswith(b"%PDF-")


def test_of_many_letters_some_are_named():
    many = "".join(map(chr, range(0x4E00, 0x9F00)))
    whole = told(SMALL + f"# {many}\n")
    assert _told(whole)[0]["facts"][-1][1].endswith("U+4E0A, U+4E0B, ….")
    assert document(whole).startswith(b"%PDF-")


# --------------------------------------------------------------------------- names


@pytest.mark.slow
@pytest.mark.parametrize("kind", NAMES)
def test_any_title_goes_into_every_medium(kind):
    text = titled(NAMES[kind])
    whole = told(text)
    assert whole.title == NAMES[kind].strip() or whole.title == NAMES[kind]
    assert document(whole).startswith(b"%PDF-")
    assert Text(page(whole)).heading.strip() == shortened(whole.title, 200).strip()
    data = workbook(assess(files.loads(text)), say=Language("en"))
    assert openpyxl.load_workbook(BytesIO(data)).sheetnames


@pytest.mark.slow
@pytest.mark.parametrize("first", range(0, len(NAMES), 3))
def test_any_name_of_a_state_or_part_goes_into_every_medium(first):
    text = EXAMPLE.read_text(encoding="utf-8")
    kinds = [*NAMES.values(), *NAMES.values()][first : first + 3]
    for name, new in zip(("full rebound", "windup", "auxiliary beam"), kinds, strict=True):
        changed = titled(name[0] + new, text.replace(f"name: {name}", f"name: {TITLE}"))
        assert changed != text
        text = changed
    whole = told(text)
    assert document(whole).startswith(b"%PDF-")
    assert page(whole).encode()
    data = workbook(assess(files.loads(text)), say=Language("en"))
    assert openpyxl.load_workbook(BytesIO(data)).sheetnames


@pytest.mark.parametrize("title", ["x" * 20_000, "word " * 4000])
def test_a_title_without_end_is_cut_where_everybody_sees_it(title):
    """20,000 letters in one word: a string of a PDF has no room for them."""
    whole = told(SMALL, title=title)
    data = _told(whole)[0]
    for key, most in (("title", 200), ("running", 80)):
        assert data[key].endswith("…")
        assert len(data[key].replace("\u200b", "")) <= most
    assert document(whole).startswith(b"%PDF-")
    assert Text(page(whole)).heading.strip() == shortened(whole.title, 200)


def test_drawings_have_letters_of_their_own():
    """Lettering of three fonts in a drawing is refused where a text may mix them."""
    text = EXAMPLE.read_text(encoding="utf-8").replace("name: full rebound", 'name: "⊡⭧╪Ա⯲"')
    data, drawings = _told(told(text))
    assert lacking([d.decode() for d in drawings.values()], letters=DRAWN) == set()
    assert "U+0531" in data["facts"][-1][1]
    assert "⊡⭧╪Ա⯲" in str(data["chapters"])


def test_names_in_drawings_have_an_end_too():
    """40,000 letters at a point of a chart took the typesetter twenty seconds."""
    text = EXAMPLE.read_text(encoding="utf-8")
    (beam,) = files.loads(text).obstacles
    drawings = _told(told(text, obstacles=(replace(beam, name="k" * 40_000),)))[1]
    assert max(len(run) for svg in drawings.values() for run in re.findall(rb"k+", svg)) < 4001
    lettering = [t for svg in drawings.values() for t in re.findall(rb">([^<]*)<", svg)]
    assert max(len(t) for t in lettering) <= 300 + len("…".encode())


# --------------------------------------------------------------------------- the same bytes


@pytest.mark.slow
def test_the_same_file_gives_the_same_bytes_in_every_medium(tmp_path):
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
