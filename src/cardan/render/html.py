"""A report as one page that needs nothing else: it works from disk, with the network off."""

import re
from base64 import b64encode
from dataclasses import replace
from hashlib import sha256
from importlib.resources import files

from cardan.core.optional_import import import_optional
from cardan.render.blocks import Block, Picture, ReportDocument
from cardan.render.fonts import truncate
from cardan.render.i18n import Translator

VERDICT_SYMBOLS = {"pass": "✓", "warn": "△", "incomplete": "…", "fail": "✗"}
"""Signs of the verdicts, for readers who do not see their colours."""

MAX_TITLE_CHARACTERS = 200
"""Characters of a title that have room over a page."""


def _block_kind(block: Block) -> str:
    """Return what a block is, for the template to choose by."""
    return type(block).__name__


def _base64_text(data: bytes) -> str:
    """Return a picture as text."""
    return b64encode(data).decode()


def _script_hashes(of: ReportDocument) -> list[str]:
    """Return the scripts a page may run, by their hashes: those of its scenes, no other."""
    scenes = [b.scene for c in of.chapters for b in c.blocks if isinstance(b, Picture)]
    scripts = re.findall(r"<script>(.*?)</script>", "".join(scenes), flags=re.DOTALL)
    hashes = (b64encode(sha256(s.encode()).digest()).decode() for s in dict.fromkeys(scripts))
    return [f"'sha256-{h}'" for h in hashes]


def html_page(of: ReportDocument) -> str:
    """Return a story as an HTML document.

    Raises
    ------
    MissingDependencyError
        If Jinja2 is not installed.
    """
    jinja2 = import_optional("jinja2")
    say = Translator(of.language)
    text = files("cardan.render").joinpath("templates/report.html").read_text(encoding="utf-8")
    environment = jinja2.Environment(autoescape=True, undefined=jinja2.StrictUndefined)
    return environment.from_string(text).render(
        story=replace(
            of,
            title=truncate(of.title, MAX_TITLE_CHARACTERS),
            subtitle=truncate(of.subtitle, MAX_TITLE_CHARACTERS),
        ),
        lang={"pt": "pt-BR"}.get(of.language, of.language),
        mark=VERDICT_SYMBOLS,
        kind=_block_kind,
        packed=_base64_text,
        scripts=_script_hashes(of),
        contents=say("Contents"),
        made=say("Made with cardan {version}.", version=of.version),
    )
