"""What a quantity is: its one declaration, which every table, page and file reads."""

from dataclasses import dataclass, field

from cardan.base.source import Source
from cardan.base.units import UNITS

WRITTEN = {
    "1": "", "Nm": "N·m", "rad_s2": "rad/s²", "deg_min": "deg/min", "kg_m3": "kg/m³",
    "N_mm": "N/mm", "percent": "%", "per_s": "1/s",
}  # fmt: skip
"""How people write the units whose names in keys cannot hold a slash or a dot."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Quantity:
    """A quantity of the field, declared once.

    `unit` is the unit it is shown in, a name of `cardan.base.units.UNITS`; inside the
    program its values are SI. `equation` is plain text that a terminal can print, and
    `where` says what its symbols mean.
    """

    key: str
    name: str
    pt: str
    it: str
    symbol: str
    unit: str
    equation: str
    source: Source
    where: dict[str, str] = field(default_factory=dict[str, str])
    use: str = ""
    """Limits of use: when the number can be trusted."""

    @property
    def factor(self) -> float:
        """SI value of one display unit."""
        return UNITS[self.unit]

    @property
    def unit_name(self) -> str:
        """The display unit as people write it: rad/s², N·m."""
        return WRITTEN.get(self.unit, self.unit)

    def named(self, language: str) -> str:
        """Return the name in `en`, `pt` or `it`."""
        return {"en": self.name, "pt": self.pt, "it": self.it}[language]
