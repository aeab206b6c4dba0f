"""What is printed where letters are missing: readable, and never the end of a run."""

import json
import os
import subprocess
import sys
import unicodedata

import pytest
from case_selection import select
from repository import EXAMPLES

from cardan.checks.quantities.registry import QUANTITIES
from cardan.cli.ascii_fallback import ASCII_REPLACEMENTS, to_ascii
from cardan.render.i18n import LANGUAGE_CODES, message_catalogue

EXAMPLE = EXAMPLES / "refuse-collector-6x2.yaml"


def run(encoding: str, *arguments: object) -> subprocess.CompletedProcess:
    """Run the program on streams of an encoding; no encoding is a system without a language."""
    plainest = {"LANG": "C", "LC_ALL": "C", "PYTHONUTF8": "0", "PYTHONCOERCECLOCALE": "0"}
    env = {k: v for k, v in os.environ.items() if k != "PYTHONIOENCODING"}
    env |= {"PYTHONIOENCODING": encoding} if encoding else plainest
    command = [sys.executable, "-m", "cardan", *map(str, arguments)]
    return subprocess.run(command, capture_output=True, env=env, check=False)


@pytest.mark.slow
@pytest.mark.parametrize("encoding", ["cp1252", "cp437", "ascii", "latin-1", "cp932", ""])
def test_equation_prints_on_any_code_page(encoding):
    """`cardan explain joint_angle` ended in a traceback at the β of a Western Windows."""
    result = run(encoding, "explain", "joint_angle")
    assert (result.returncode, result.stderr) == (0, b"")
    text = result.stdout.decode(encoding or "ascii")
    assert text.isprintable() or "\n" in text
    letter = "beta" if encoding not in ("cp932", "cp437") else "β"
    if encoding != "cp437":  # its ß is what it shows a β as
        assert f"{letter} = atan2(" in text


@pytest.mark.slow
@pytest.mark.parametrize("encoding", ["cp1252", "ascii"])
@pytest.mark.parametrize("lang", select(["en", "pt", "it"], "pt"))
def test_check_prints_on_any_code_page(encoding, lang):
    result = run(encoding, "check", EXAMPLE, "--sources", "--states", "--lang", lang)
    assert (result.returncode, result.stderr) == (1, b"")
    text = result.stdout.decode(encoding)
    assert "?" not in text
    assert len(text.splitlines()) > 60


@pytest.mark.slow
@pytest.mark.parametrize("encoding", select(["cp1252", "ascii", "utf-8"], "ascii"))
def test_json_keeps_every_character_on_any_code_page(encoding):
    """JSON has a way to write every letter in ASCII; plain letters would change it."""
    shown = {}
    for command in (("check", EXAMPLE, "--json", "-"), ("schema",), ("verify", "--json")):
        result = run(encoding, *command)
        assert result.stderr == b""
        shown[command[0]] = json.loads(result.stdout.decode(encoding))
    texts = json.dumps(shown, ensure_ascii=False)
    assert "²" in texts or "°" in texts or "é" in texts or "–" in texts


def test_error_message_prints_in_ascii():
    result = run("ascii", "explain", "ângulo 中 β")
    assert result.returncode == 2
    assert result.stdout == b""
    assert result.stderr.startswith(b"error: there is no quantity angulo ? beta")


@pytest.mark.slow
def test_undecodable_file_name_is_reported_with_escaped_bytes():
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
def test_character_is_transliterated_to_ascii(character, written):
    assert to_ascii(character) == written


@pytest.mark.slow
def test_every_unicode_character_maps_to_ascii():
    for code in range(0x80, sys.maxunicode + 1):
        assert to_ascii(chr(code)).isascii()


def test_every_program_text_has_ascii_fallback():
    told = " ".join(
        [
            t
            for code in LANGUAGE_CODES
            for (_, english), other in message_catalogue(code).items()
            for t in (english, other)
        ]
        + [
            " ".join(
                (
                    q.name,
                    q.symbol,
                    q.equation_text,
                    q.unit_symbol,
                    *q.symbol_meanings,
                    str(q.source),
                )
            )
            for q in QUANTITIES.values()
        ]
    )
    used = {c for c in told if not c.isascii()}
    assert len(used) > 40
    assert {c: unicodedata.name(c) for c in used if "?" in to_ascii(c)} == {}
    assert all(not c.isascii() for c in ASCII_REPLACEMENTS)
