"""`cardan explain`: what a quantity is."""

from typing import Any

import click

from cardan.cli.common import LANG, put_lines, screen
from cardan.cli.ending import Once, kindly, refuse


@click.command(cls=Once)
@click.argument("quantity", required=False)
@LANG
@kindly
def explain(quantity: str | None, *, lang: str) -> None:
    """Say what QUANTITY is: equation, symbols, source, limits of use.

    By its key or its name; without one, list them all.
    """
    from cardan.quantity.quantities import QUANTITIES
    from cardan.report import terminal
    from cardan.report.language import Language
    from cardan.report.screen import folded

    if quantity is None:
        put_lines(f"{key:<28} {Language(lang).name(key)}" for key in QUANTITIES)
        return
    word = quantity.casefold()
    meant = [q for q in QUANTITIES.values() if word in _names(q)]
    if not meant:
        from difflib import get_close_matches

        near = [q.key for q in QUANTITIES.values() if any(word in n for n in _names(q))]
        near = near[:3] or get_close_matches(word, QUANTITIES)
        hint = f"; did you mean {' or '.join(near)}?" if near else ""
        refuse(f"there is no quantity {quantity}{hint} (`cardan explain` lists them all)")
    for q in meant:
        put_lines(folded(terminal.explanation(q, Language(lang)), screen()))


def _names(quantity: Any) -> tuple[str, ...]:
    """Return what a quantity may be called, in small letters: its key, its name in any language."""
    from cardan.report.language import CODES, Language

    named = (Language(code).name(quantity.key) for code in CODES)
    return quantity.key, *(name.casefold() for name in named)
