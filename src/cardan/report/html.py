"""A report as one page that needs nothing else: it works from disk, with the network off."""

from importlib.resources import files

from cardan.report.extra import needed
from cardan.report.language import Language
from cardan.report.story import Block, Story

MARKS = {"pass": "✓", "warn": "△", "fail": "✗"}
"""Signs of the verdicts, for whoever does not see their colours."""


def _kind(block: Block) -> str:
    """Return what a block is, for the template to choose by."""
    return type(block).__name__


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
        story=of,
        lang={"pt": "pt-BR"}.get(of.language, of.language),
        mark=MARKS,
        kind=_kind,
        contents=say("Contents"),
        made=say("Made with cardan {version}.", version=of.version),
    )
