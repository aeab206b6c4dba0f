"""Options that take a number with its unit."""

from typing import Any

import click

from cardan.core.errors import DesignError
from cardan.core.units import UNITS


class QuantityParam(click.ParamType[float]):
    """A number with its unit, the first of these where none is written."""

    name = "number"

    def __init__(self, *units: str) -> None:
        self.units = {unit: UNITS[unit] for unit in units}

    def convert(self, value: Any, param: Any, ctx: Any) -> float:
        """Return the number, SI."""
        from cardan.schema.quantity_parser import parse_quantity

        try:
            return parse_quantity(str(value), self.units)
        except DesignError as error:
            self.fail(str(error), param, ctx)
