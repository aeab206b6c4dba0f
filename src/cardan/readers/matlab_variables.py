"""A variable of a MATLAB file, whatever the level of the file."""

from collections.abc import Callable
from dataclasses import dataclass

from cardan.core.arrays import FloatArray

MAX_VARIABLES = 20_000
"""Variables of a file, those in structs and cells counted one by one."""
MAX_DEPTH = 8
"""Structs in structs."""
MAX_TEXT_LETTERS = 1 << 10
"""Letters of a text that are read: a name, a unit."""


@dataclass(frozen=True)
class Variable:
    """An array of numbers or texts, a part of a struct by its path: `run.signals(2).values`."""

    name: str
    shape: tuple[int, ...]
    """Rows, columns and further axes, as MATLAB has them."""
    kind: str
    """Class of MATLAB."""
    read: Callable[[int, int], FloatArray] | None = None
    """Takes a first place and a count, gives numbers (count,), column after column."""
    texts: tuple[str, ...] = ()

    def describe(self) -> str:
        """Return name, shape and class as MATLAB's `whos` has them."""
        return f"{self.name} {'x'.join(map(str, self.shape))} {self.kind}".replace("  ", " ")
