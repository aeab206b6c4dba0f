"""`cardan explain`: what a quantity is."""

from typing import Any

import click

from cardan.cli.common import LANG_OPTION, echo_lines, terminal_width
from cardan.cli.exit_codes import (
    NoRepeatedOptionCommand,
    exit_with_code_2_on_known_errors,
    raise_command_error,
)


@click.command(cls=NoRepeatedOptionCommand)
@click.argument("quantity", required=False)
@LANG_OPTION
@exit_with_code_2_on_known_errors
def explain(quantity: str | None, *, lang: str) -> None:
    """Say what QUANTITY is: equation, symbols, source, limits of use.

    By its key or its name; without one, list them all.
    """
    from cardan.checks.quantities.registry import QUANTITIES
    from cardan.documents import terminal
    from cardan.render.i18n import Translator
    from cardan.render.text_layout import fold_lines

    if quantity is None:
        echo_lines(f"{key:<28} {Translator(lang).name(key)}" for key in QUANTITIES)
        return
    word = quantity.casefold()
    meant = [q for q in QUANTITIES.values() if word in _search_names(q)]
    if not meant:
        from difflib import get_close_matches

        near = [q.key for q in QUANTITIES.values() if any(word in n for n in _search_names(q))]
        near = near[:3] or get_close_matches(word, QUANTITIES)
        hint = f"; did you mean {' or '.join(near)}?" if near else ""
        raise_command_error(
            f"there is no quantity {quantity}{hint} (`cardan explain` lists them all)"
        )
    for q in meant:
        echo_lines(
            fold_lines(terminal.quantity_explanation_lines(q, Translator(lang)), terminal_width())
        )


def _search_names(quantity: Any) -> tuple[str, ...]:
    """Return what a quantity may be called, in small letters: its key, its name in any language."""
    from cardan.render.i18n import LANGUAGE_CODES, Translator

    named = (Translator(code).name(quantity.key) for code in LANGUAGE_CODES)
    return quantity.key, *(name.casefold() for name in named)
