"""The language of a command: as --lang says, else that of the locale."""

import os
import re
import sys
from pathlib import Path

import click

_LOCALES_FOLDER = Path(__file__).parents[1] / "render" / "locales"


class LanguageChoice(click.Choice[str]):
    """The languages there is a catalogue for."""

    def __init__(self) -> None:
        super().__init__(("en", *sorted(p.stem for p in _LOCALES_FOLDER.glob("*.po"))))


def locale_language() -> str:
    """Return the language of the locale if there is a catalogue for it, else English."""
    named = next(filter(None, map(os.environ.get, ("LC_ALL", "LC_MESSAGES", "LANG"))), "")
    if not named and sys.platform == "win32":
        from locale import getlocale

        named = (getlocale()[0] or "").replace("Portuguese", "pt").replace("Italian", "it")
    code = re.split("[-_.@]", named)[0].lower()
    return code if (_LOCALES_FOLDER / f"{code}.po").is_file() else "en"
