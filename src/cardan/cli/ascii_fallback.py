"""Text for screens that know few letters: what an encoding lacks, in letters it has.

A terminal in an old code page, or a pipe in ASCII, shows "beta" for β and "<=" for ≤, and
a question mark where nothing stands for a sign. No run ends over a letter.
"""

import codecs
import sys
import unicodedata

ERROR_HANDLER_NAME = "cardan-plain"
"""What Python's streams call the way of doing so."""

ASCII_REPLACEMENTS = {
    "≤": "<=", "≥": ">=", "≠": "!=", "≈": "~", "±": "+-", "−": "-", "–": "-", "—": "-",
    "×": "x", "·": ".", "⋅": ".", "÷": "/", "⁄": "/", "√": "sqrt", "∞": "inf", "∝": "~", "∂": "d",
    "∑": "sum", "∏": "prod", "∫": "int", "Δ": "Delta", "∇": "nabla", "∪": "or", "∩": "and",
    "∈": "in", "→": "->", "←": "<-", "↔": "<->", "⇒": "=>", "°": "deg", "µ": "u", "μ": "u",
    "‖": "||", "⟨": "<", "⟩": ">", "⌀": "dia", "∅": "dia", "Ø": "O", "ø": "o", "ß": "ss",
    "æ": "ae", "Æ": "AE", "ı": "i", "ł": "l", "Ł": "L", "“": '"', "”": '"', "„": '"',
    "‘": "'", "’": "'", "«": "<<", "»": ">>", "•": "*", "′": "'", "″": "''", "✓": "ok", "✗": "x",
    "△": "!",
}  # fmt: skip
"""What signs are written as where they are missing; Greek letters have their names."""


def to_ascii(character: str) -> str:
    """Return a character in ASCII, readable if that can be; else a question mark."""
    if character.isascii():
        return character
    if "\udc80" <= character <= "\udcff":  # a byte of a name that is no text
        return f"\\x{ord(character) - 0xDC00:02x}"
    if character in ASCII_REPLACEMENTS:
        return ASCII_REPLACEMENTS[character]
    if greek := _greek_letter_name(character):
        return greek
    if unicodedata.combining(character):
        return ""
    apart = unicodedata.normalize("NFKD", character)
    if apart != character:
        above = "^" if unicodedata.decomposition(character).startswith("<super>") else ""
        return above + "".join(map(to_ascii, apart))
    return "?"


def _greek_letter_name(character: str) -> str:
    """Return the name of a Greek letter, "beta" or "Delta"; else nothing."""
    name = unicodedata.name(character, "")
    for size, change in (("SMALL", str.lower), ("CAPITAL", str.capitalize)):
        if name.startswith(f"GREEK {size} LETTER "):
            return change(name.split(" ")[3])
    return ""


def _replace_unencodable(error: UnicodeError) -> tuple[str, int]:
    """Return what stands for characters an encoding lacks, and where to go on."""
    if not isinstance(error, UnicodeEncodeError):
        raise error
    lacking = error.object[error.start : error.end]
    return "".join(map(to_ascii, lacking)), error.end


def install_ascii_fallback() -> None:
    """Let what this process prints be written in plain letters where others are missing."""
    codecs.register_error(ERROR_HANDLER_NAME, _replace_unencodable)
    for stream in (sys.stdout, sys.stderr):
        reconfigure = getattr(stream, "reconfigure", None)
        if reconfigure is not None:
            reconfigure(errors=ERROR_HANDLER_NAME)
