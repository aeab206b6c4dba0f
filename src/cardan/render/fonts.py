"""What goes onto paper: letters that its fonts have, and names of a length that fits.

The typesetter's own fonts are all a document has, so that it is the same everywhere. What
they lack, Chinese or an emoji in a comment, is shown as an empty square and owned up to;
a title of a thousand words is cut visibly.
"""

import re
import unicodedata
from collections.abc import Callable, Iterable
from typing import Any

MISSING_GLYPH = "□"
"""Stands for what the fonts lack."""


def _characters_in_blocks(blocks: str) -> frozenset[str]:
    """Return the letters of blocks, without marks that need a letter and invisible characters."""
    ends = (block.split("-") for block in blocks.split())
    codes = (code for ends in ends for code in range(int(ends[0], 16), int(ends[-1], 16) + 1))
    return frozenset(
        c for c in map(chr, codes) if unicodedata.category(c) not in _EXCLUDED_CATEGORIES
    )


_EXCLUDED_CATEGORIES = {"Mn", "Mc", "Me", "Cf", "Cc", "Cn", "Zl", "Zp"}

DISPLAYABLE_TEXT_CHARACTERS = _characters_in_blocks(
    "0020-007E 00A0-04FF 0531-05F4 10D0-10FF 1E00-1FFF 2000-200A 2010-2027 202F-2040 2044-2052 "
    "2054-205E 2070-211E 2126-2151 2153-2184 2190-23FF 2460-2606 27B1-2BFF FB00-FB4F"
) | {"\n", "\t"}
"""What a text can show: blocks that the fonts have whole, each letter tried out in each font.

Marks are in it with their letter, é, not by themselves.
"""

DISPLAYABLE_DRAWING_CHARACTERS = _characters_in_blocks(
    "0020-007E 00A0-02E4 0384-03CE 0400-0477 05D0-05EA 1E00-1FFF 2000-200A 2010-2037 2070-209C "
    "20AC 2190-219B 2200-220D 220F-222E 2248 2260 2264-2265 25CB 25CF"
) | {"\n", "\t", MISSING_GLYPH}
"""What a drawing can show, whose lettering is of one font and seldom of a second."""

MAX_UNBROKEN_CHARACTERS = 40
"""Longer runs of letters may be broken anywhere."""

ZERO_WIDTH_SPACE = "\u200b"
"""Where a word may be broken; it is invisible."""


def truncate(text: str, most: int) -> str:
    """Return a text of a number of characters at most, its end cut off where it is longer.

    >>> truncate("centre bearing", 7)
    'centre…'
    """
    return text if len(text) <= most else text[: most - 1].rstrip() + "…"


def missing_characters(
    texts: Iterable[str], *, letters: frozenset[str] = DISPLAYABLE_TEXT_CHARACTERS
) -> set[str]:
    """Return the characters of texts that the fonts lack."""
    return {c for text in texts for c in _normalised(text)} - letters


def replace_missing_characters(
    text: str, *, letters: frozenset[str] = DISPLAYABLE_TEXT_CHARACTERS
) -> str:
    """Return a text in letters the fonts have.

    >>> replace_missing_characters("牵引车 tractor")
    '□□□ tractor'
    """
    return "".join(c if c in letters else MISSING_GLYPH for c in _normalised(text))


def insert_word_breaks(text: str, *, word: int = MAX_UNBROKEN_CHARACTERS) -> str:
    """Return a text whose long words may be broken, so that they stay on the page."""
    return re.sub(
        rf"([^\s{ZERO_WIDTH_SPACE}]{{{word}}})(?=[^\s{ZERO_WIDTH_SPACE}])",
        rf"\1{ZERO_WIDTH_SPACE}",
        text,
    )


def insert_address_breaks(text: str) -> str:
    """Return a text in which addresses of entries may be broken between their names.

    >>> insert_address_breaks("shafts[1].spline.mean_radius_mm").split(ZERO_WIDTH_SPACE)
    ['shafts[1].', 'spline.', 'mean_', 'radius_', 'mm']
    """
    return re.sub(r"(?<=[a-z\]][._])(?=[a-z])", ZERO_WIDTH_SPACE, text)


def apply_to_all_texts(value: Any, change: Callable[[str], str]) -> Any:
    """Return plain data with a change made to every text in it."""
    if isinstance(value, str):
        return change(value)
    if isinstance(value, dict):
        return {k: apply_to_all_texts(v, change) for k, v in value.items()}
    if isinstance(value, (list, tuple)):
        return [apply_to_all_texts(v, change) for v in value]
    return value


def collect_texts(value: Any) -> list[str]:
    """Return every text of plain data."""
    found: list[str] = []
    apply_to_all_texts(value, lambda text: found.append(text) or text)
    return found


def _normalised(text: str) -> str:
    """Return a text with its marks joined to their letters; line ends as one character."""
    return unicodedata.normalize("NFC", text).replace("\r\n", "\n").replace("\r", "\n")
