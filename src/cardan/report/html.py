"""A report as one page that needs nothing else: it works from disk, with the network off."""

import re
from base64 import b64encode
from dataclasses import replace
from hashlib import sha256
from importlib.resources import files

from cardan.report.blocks import Block, Picture, Story
from cardan.report.extra import needed
from cardan.report.language import Language
from cardan.report.paper import shortened

MARKS = {"pass": "✓", "warn": "△", "incomplete": "…", "fail": "✗"}
"""Signs of the verdicts, for whoever does not see their colours."""

TITLE = 200
"""Characters of a title that have room over a page."""


def _kind(block: Block) -> str:
    """Return what a block is, for the template to choose by."""
    return type(block).__name__


def _packed(data: bytes) -> str:
    """Return a picture as text."""
    return b64encode(data).decode()


def _scripts(of: Story) -> list[str]:
    """Return the scripts a page may run, by their hashes: those of its scenes, no other."""
    scenes = [b.scene for c in of.chapters for b in c.blocks if isinstance(b, Picture)]
    scripts = re.findall(r"<script>(.*?)</script>", "".join(scenes), flags=re.DOTALL)
    hashes = (b64encode(sha256(s.encode()).digest()).decode() for s in dict.fromkeys(scripts))
    return [f"'sha256-{h}'" for h in hashes]


def page(of: Story) -> str:
    """Return a story as an HTML document.

    Raises
    ------
    MissingExtra
        If Jinja2 is not installed.
    """
    jinja2 = needed("jinja2")
    say = Language(of.language)
    text = files("cardan.report").joinpath("templates/report.html").read_text(encoding="utf-8")
    environment = jinja2.Environment(autoescape=True, undefined=jinja2.StrictUndefined)
    return environment.from_string(text).render(
        story=replace(of, title=shortened(of.title, TITLE), subtitle=shortened(of.subtitle, TITLE)),
        lang={"pt": "pt-BR"}.get(of.language, of.language),
        mark=MARKS,
        kind=_kind,
        packed=_packed,
        scripts=_scripts(of),
        contents=say("Contents"),
        made=say("Made with cardan {version}.", version=of.version),
    )
