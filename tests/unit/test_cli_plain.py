"""What is printed where letters are missing: readable, and never the end of a run."""

import json
import os
import subprocess
import sys
import unicodedata
from pathlib import Path

import pytest
from chief import chief

from cardan.cli.plain import SIGNS, plain
from cardan.quantity.quantities import QUANTITIES
from cardan.report.language import CODES, catalogue

EXAMPLE = Path(__file__).parents[2] / "examples" / "refuse-collector-6x2.yaml"


def run(encoding: str, *arguments: object) -> subprocess.CompletedProcess:
    """Run the program on streams of an encoding; no encoding is a system without a language."""
    plainest = {"LANG": "C", "LC_ALL": "C", "PYTHONUTF8": "0", "PYTHONCOERCECLOCALE": "0"}
    env = {k: v for k, v in os.environ.items() if k != "PYTHONIOENCODING"}
    env |= {"PYTHONIOENCODING": encoding} if encoding else plainest
    command = [sys.executable, "-m", "cardan", *map(str, arguments)]
    return subprocess.run(command, capture_output=True, env=env, check=False)


@pytest.mark.parametrize("encoding", ["cp1252", "cp437", "ascii", "latin-1", "cp932", ""])
def test_an_equation_is_readable_on_any_code_page(encoding):
    """`cardan explain joint_angle` ended in a traceback at the β of a Western Windows."""
    result = run(encoding, "explain", "joint_angle")
    assert (result.returncode, result.stderr) == (0, b"")
    text = result.stdout.decode(encoding or "ascii")
    assert text.isprintable() or "\n" in text
    letter = "beta" if encoding not in ("cp932", "cp437") else "β"
    if encoding != "cp437":  # its ß is what it shows a β as
        assert f"{letter} = atan2(" in text


@pytest.mark.parametrize("encoding", ["cp1252", "ascii"])
@pytest.mark.parametrize("lang", chief(["en", "pt", "it"], "pt"))
def test_a_whole_check_is_printed_on_any_code_page(encoding, lang):
    result = run(encoding, "check", EXAMPLE, "--lang", lang)
    assert (result.returncode, result.stderr) == (1, b"")
    text = result.stdout.decode(encoding)
    assert "?" not in text
    assert len(text.splitlines()) > 60


@pytest.mark.parametrize("encoding", chief(["cp1252", "ascii", "utf-8"], "ascii"))
def test_a_document_for_programs_loses_nothing(encoding):
    """JSON has a way to write every letter in ASCII; plain letters would change it."""
    shown = {}
    for command in (("check", EXAMPLE, "--json", "-"), ("schema",), ("verify", "--json")):
        result = run(encoding, *command)
        assert result.stderr == b""
        shown[command[0]] = json.loads(result.stdout.decode(encoding))
    texts = json.dumps(shown, ensure_ascii=False)
    assert "²" in texts or "°" in texts or "é" in texts or "–" in texts


def test_errors_are_readable_too():
    result = run("ascii", "explain", "ângulo 中 β")
    assert result.returncode == 2
    assert result.stdout == b""
    assert result.stderr.startswith(b"error: there is no quantity angulo ? beta")


def test_a_name_that_is_not_text_is_no_fault():
    """A file name of bytes that are no UTF-8 stands in the message, its bytes written out."""
    for encoding in ("utf-8", "ascii"):
        result = run(encoding, "check", os.fsdecode(b"tr\xe9s.yaml"))
        assert result.returncode == 2
        assert result.stderr.startswith(rb"error: tr\xe9s.yaml: cannot be read")


@pytest.mark.parametrize(
    ("character", "written"),
    [
        ("β", "beta"), ("Δ", "Delta"), ("Ω", "Omega"), ("ώ", "omega"), ("≤", "<="), ("²", "^2"),
        ("₂", "2"),
        ("½", "1/2"), ("é", "e"), ("\u0301", ""), ("ﬁ", "fi"), ("…", "..."), ("°", "deg"),
        ("µ", "u"), ("中", "?"), ("😀", "?"), ("\udce9", r"\xe9"), ("\ud800", "?"),
    ],
)  # fmt: skip
def test_letters_in_plain_letters(character, written):
    assert plain(character) == written


def test_whatever_there_is_becomes_ascii():
    for code in range(0x80, sys.maxunicode + 1):
        assert plain(chr(code)).isascii()


def test_whatever_the_program_says_is_readable():
    told = " ".join(
        [t for code in CODES for (_, english), other in catalogue(code).items()
         for t in (english, other)]
        + [" ".join((q.name, q.symbol, q.stated, q.unit_name, *q.where, str(q.source)))
           for q in QUANTITIES.values()]
    )  # fmt: skip
    used = {c for c in told if not c.isascii()}
    assert len(used) > 40
    assert {c: unicodedata.name(c) for c in used if "?" in plain(c)} == {}
    assert all(not c.isascii() for c in SIGNS)
