"""Value and limit of a check as a screen shows them, in few figures and a unit that suits both."""

from collections.abc import Iterable, Iterator
from math import isfinite

from cardan.application.quantity_lookup import declared_quantity
from cardan.core.verdict import Check
from cardan.render.i18n import Translator

VALUE_FIGURES = 3
"""Significant figures of a value on the screen: assumed inputs deserve no more."""

MAX_VALUE_FIGURES = 9
"""Figures at most, where fewer show a value as equal to the bound that it misses."""


def uncapitalised(name: str) -> str:
    """Return a name as it stands inside a line; an acronym keeps its capitals."""
    return name if name[1:2].isupper() else name[:1].lower() + name[1:]


def value_text(c: Check, say: Translator, value: float | None = None) -> str:
    """Return a value of a check (by default its own) in the unit of its limit, without the unit.

    After ≥ where it is a lower bound, ≤ of what is the safer the larger. It has more than
    `VALUE_FIGURES` only where they would show it as equal to its bound.
    """
    if c.is_lower_bound and value is None:
        return f"{lower_bound_mark(c)}{value_text(c, say, c.value)}"
    scale, _ = _scale_and_unit(c)
    number, bound = (c.value if value is None else value) / scale, c.bound / scale
    if not isfinite(number):
        return say.number(number)
    for figures in range(VALUE_FIGURES, MAX_VALUE_FIGURES + 1):
        rounded = float(f"{number:.{figures}g}")
        if value is not None or rounded != bound or number == bound:
            return say.number(rounded, figures)
    return say.number(number, MAX_VALUE_FIGURES)


def lower_bound_mark(c: Check) -> str:
    """Return what stands before a lower bound: ≥ of a load, ≤ of a life; "" of other values."""
    return {"<=": "≥ ", ">=": "≤ "}[c.limit.sense] if c.is_lower_bound else ""


def lower_bound_explanation(shown: Iterable[str], say: Translator) -> Iterator[str]:
    """Yield what ≥ and ≤ mean, where one of the texts shown holds them."""
    every = tuple(shown)
    if any("≥" in text for text in every):
        yield say(
            "≥ lower bound: rubber goes beyond its stop there (assumed where travel_mm is not "
            "given), and the true value is larger"
        )
    if any("≤" in text for text in every):
        yield say(
            "≤ upper bound: rubber goes beyond its stop there (assumed where travel_mm is not "
            "given), and the true value may be smaller"
        )


def limit_text(c: Check, say: Translator) -> str:
    """Return the bound that decides with its sense and unit: min 15 mm, outside 0.42 to 0.58.

    A star marks a bound of engineering judgement.
    """
    scale, unit = _scale_and_unit(c)
    star = "*" if c.how_read == "assumed" else ""
    if c.limit.band:
        low, high = (say.compact_number(edge / scale) for edge in c.limit.band)
        said = say("outside {low} to {high}", low=low, high=high)
    else:
        bound = say.compact_number(c.bound / scale)
        said = say("max {bound}" if c.limit.sense == "<=" else "min {bound}", bound=bound)
    return f"{said} {unit}".rstrip() + star


def unit_text(c: Check) -> str:
    """Return the unit that a screen shows a check in."""
    return _scale_and_unit(c)[1]


def _scale_and_unit(c: Check) -> tuple[float, str]:
    """Return SI value and symbol of the unit for a check: kN where N would take four figures."""
    q = declared_quantity(c.quantity)
    if q.unit in ("N", "Nm") and c.bound >= 1000 * q.si_factor:
        return 1000 * q.si_factor, f"k{q.unit_symbol}"
    return q.si_factor, q.unit_symbol
