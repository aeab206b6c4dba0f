"""Pages, changelog, messages and help keep to the glossary: textbook terms, no court language.

Program text that a page must show as printed stands in a code fence or in inline code.
"""

import ast
import inspect
import io
import re
import tokenize

import click
import pytest
from repository import ROOT

from cardan.cli import cli
from cardan.render.i18n import message_catalogue

INSTEAD = {
    r"nought": "zero, negative",
    r"nobody|whoever": "name the subject, or: unknown, not given",
    r"told|tells?|telling|foretold|foretells?": "reports, computes, predicts",
    r"ask|asks|asked|asking": "evaluates, applies, needs",
    r"unanswered|without an answer|no answer": "not evaluated",
    r"acquit\w*|innocen\w*|inocente\w*": "joints do not dominate",
    r"convict\w*|guilt\w*|culpad\w*|colpevol\w*": "joints dominate",
    r"veto\w*": "data rejected",
    r"mend|mends|mended|mending": "correct",
    r"beside": "next to, with, in addition",
    r"coast|coasts|coasting": "overrun",
    r"jounce": "bump",
    r"house practice": "engineering judgement, no published limit",
    r"re-read|second hand|from memory": "checked, quoted, unverified",
}
"""Old words, and what the glossary has in their place."""

FORBIDDEN = re.compile("|".join(rf"\b({old})\b" for old in INSTEAD), re.IGNORECASE)

NOT_PROSE = re.compile(
    r"^ *```.*?^ *```$"
    r"|(?:(?<=\n\n)|\A)(?:    [^\n]*\n+)+"
    r"|<code>.*?</code>|`[^`]*`|\]\([^)]*\)",
    re.DOTALL | re.MULTILINE,
)
"""Fences, indented code, inline code and targets of links."""

PAGES = [
    *(ROOT / name for name in ("README.md", "CHANGELOG.md", "CONTRIBUTING.md")),
    *sorted((ROOT / "docs").rglob("*.md")),
    *sorted((ROOT / "benchmarks").glob("*.md")),
    *sorted((ROOT / "src").rglob("*.md")),
]
SCRIPTS = sorted((ROOT / "docs/gallery").glob("*.py"))

FILE_WORDS = {"coast", "jounce", "tolerances or ask"}
"""Names of states and keys, as application files write them."""

COURT_WORDS = re.compile(r"\b(culpad|colpevol|inocent|innocent|vetad|veto\b)", re.IGNORECASE)


def prose(text):
    """Return a page's text with code and links blank, its lines in place."""
    if "\n=== " in text:  # tabs indent their prose
        text = re.sub(r"^ {4}", "", text, flags=re.MULTILINE)
    return NOT_PROSE.sub(lambda code: re.sub(r"[^\n]", " ", code[0]), text)


def old_words(text):
    """Return line, word and what stands in its place, of each old word of a prose."""
    terms = list(INSTEAD.values())
    return [
        (text.count("\n", 0, found.start()) + 1, found[0], terms[found.lastindex - 1])
        for found in FORBIDDEN.finditer(text)
    ]


def test_pages_and_gallery_texts_have_no_old_words():
    texts = {page: prose(page.read_text(encoding="utf-8")) for page in PAGES}
    texts |= {s: ast.get_docstring(ast.parse(s.read_text(encoding="utf-8"))) for s in SCRIPTS}
    found = {str(p.relative_to(ROOT)): old_words(text) for p, text in texts.items()}
    assert {page: words for page, words in found.items() if words} == {}


def test_code_is_no_prose():
    page = "Given.\n\n    told\n\n```\nasked\n```\n`vetoed` [limits](asked.md) is *told* here\n"
    assert [(line, word) for line, word, _ in old_words(prose(page))] == [(8, "told")]


def test_changelog_is_one_line_a_change():
    lines = (ROOT / "CHANGELOG.md").read_text(encoding="utf-8").splitlines()
    assert len(lines) < 200
    assert [line for line in lines if line.startswith("  ")] == []
    assert [line for line in lines if line.startswith("- ") and len(line.split()) > 21] == []


NAMES_OF_A_SECTION = re.compile(r"^\w+(?:, \w+)*,?(?: : .*)?$(?=\n +\S)", re.MULTILINE)
"""Lines of a docstring that head a description: names of parameters, fields and results."""


def comments_and_docstrings(module):
    """Yield line and text of each; strings that stand below a constant are docstrings too."""
    text = module.read_text(encoding="utf-8")
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant):
            said = inspect.cleandoc(str(node.value.value))
            yield node.lineno, NAMES_OF_A_SECTION.sub("", said)
    for token in tokenize.generate_tokens(io.StringIO(text).readline):
        if token.type == tokenize.COMMENT:
            yield token.start[0], token.string


def test_docstrings_and_comments_have_no_old_words():
    found = [
        (str(module.relative_to(ROOT)), line, *word[1:])
        for module in sorted((ROOT / "src").rglob("*.py"))
        for line, said in comments_and_docstrings(module)
        for word in old_words(" ".join(prose(said).split()))
    ]
    assert found == []


def test_messages_have_no_old_words():
    texts = [text for _, text in message_catalogue("pt") if text not in FILE_WORDS]
    assert len(texts) > 2500
    found = {text: old_words(re.sub(r"{\w+}", "", prose(text))) for text in texts}
    assert {text: words for text, words in found.items() if words} == {}


@pytest.mark.parametrize("code", ["pt", "it"])
def test_translations_have_no_court_words(code):
    assert [text for text in message_catalogue(code).values() if COURT_WORDS.search(text)] == []


def test_descriptions_of_json_keys_have_no_old_words():
    contract = (ROOT / "src/cardan/documents/contract.schema.json").read_text(encoding="utf-8")
    described = re.findall(r'"description": "(.*)"', contract)
    assert len(described) > 300
    assert [text for text in described if old_words(prose(text))] == []


def helps(command, name):
    """Yield a command's help and that of its options, by name; of those below it too."""
    yield name, command.help or ""
    for option in command.params:
        if isinstance(option, click.Option):
            yield f"{name} {option.opts[0]}", option.help or ""
    if isinstance(command, click.Group):
        context = click.Context(command)
        for below in command.list_commands(context):
            yield from helps(command.get_command(context, below), f"{name} {below}")


def test_command_help_has_no_old_words():
    texts = dict(helps(cli, "cardan"))
    assert len(texts) > 100
    found = {name: old_words(re.sub("`[^`]*`", "", text)) for name, text in texts.items()}
    assert {name: words for name, words in found.items() if words} == {}
