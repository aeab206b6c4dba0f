"""Languages: what a report says, and how it writes a number, in English, Portuguese, Italian.

Names of quantities stand with their declaration; every other sentence is looked up by its
English wording, so the code that prints it can be read.
"""

import math
import re
from dataclasses import dataclass

from cardan.quantity.quantities import QUANTITIES
from cardan.report.words import WORDS

CODES = ("en", "pt", "it")
"""The languages: English, Portuguese of Brazil, Italian."""

_PART = re.compile(r"(joint|shaft|bearing|centre bearing) (\d+|[ABEF])(?: to (.+))?")


@dataclass(frozen=True)
class Language:
    """Says in its language what it is given in English."""

    code: str = "en"

    def __post_init__(self) -> None:
        if self.code not in CODES:
            msg = f"there is no language {self.code}; there are: {', '.join(CODES)}"
            raise ValueError(msg)

    def __call__(self, said: str, /, **values: object) -> str:
        """Return a text of the catalogue with its values filled in.

        Raises
        ------
        KeyError
            If the catalogue has no translation.
        """
        if self.code != "en":
            said = WORDS[said][CODES.index(self.code) - 1]
        return said.format(**values) if values else said

    def given(self, said: str) -> str:
        """Return a text that may be the user's own: translated where the catalogue has it."""
        return self(said) if said in WORDS else said

    def name(self, quantity: str) -> str:
        """Return the name of a quantity."""
        return QUANTITIES[quantity].named(self.code)

    def part(self, part: str) -> str:
        """Return a part of a line, "joint 2", in the language."""
        found = _PART.fullmatch(part)
        if not found:
            return self.given(part)
        kind, number, other = found.groups()
        said = f"{self(kind)} {number}"
        return self("{part} to {other}", part=said, other=other) if other else said

    def number(self, value: float) -> str:
        """Return a number as an engineer writes it down: four figures."""
        if math.isnan(value):
            return "-"
        if math.isinf(value):
            return "∞" if value > 0 else "-∞"
        if abs(value) < 5e-7:
            return "0"
        size = math.floor(math.log10(abs(value)))
        return self.pointed(f"{value:.{max(0, 3 - size)}f}" if -3 <= size < 7 else f"{value:.3e}")

    def short(self, value: float, digits: int = 6) -> str:
        """Return a number without the zeros that say nothing."""
        return self.pointed(f"{value:.{digits}g}")

    def percent(self, margin: float) -> str:
        """Return a margin as a share in per cent, cut where it says nothing more."""
        return "< -999 %" if margin < -9.99 else f"{round(100 * margin) + 0:+d} %"

    def list(self, *parts: str) -> str:
        """Return parts as a list in a line."""
        return ", ".join(p for p in parts if p)

    def pointed(self, number: str) -> str:
        """Return a number with the language's decimal sign."""
        return number if self.code == "en" else number.replace(".", ",")


EN = Language("en")
