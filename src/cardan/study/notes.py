"""Where an application contradicts itself."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from cardan.base.units import Metre, mm
from cardan.demand.suspension import spring_load, table_rates
from cardan.model.application import Application
from cardan.model.vehicle import Spring, Suspension

MISMATCH = 0.005
"""Share by which stated rates may miss the loads of their table before it is worth a word."""


@dataclass(frozen=True, kw_only=True)
class SpringMismatch:
    """A spring whose drawing states rates that do not give the loads of its own table.

    `apart` is the largest difference of load, as a share of the table's, at `deflection`;
    `stated` and `table` are the rates of both, N/m.
    """

    stated: tuple[float, ...]
    table: tuple[float, ...]
    apart: float
    deflection: Metre

    def __str__(self) -> str:
        """Return the mismatch as a sentence without its end."""
        stated, table = (
            " and ".join(f"{rate * mm:.4g}" for rate in rates)
            for rates in (self.stated, self.table)
        )
        return (
            f"a spring's stated {stated} N/mm are {100 * self.apart:+.1f} % off the load of its "
            f"own table at {self.deflection / mm:.4g} mm, which rises by {table} N/mm and counts"
        )


def spring_mismatch(spring: Spring) -> SpringMismatch | None:
    """Return how far stated rates are from a spring's table as a whole; None where they agree.

    Where fewer rates are stated than the table has slopes, a second one starts where the
    table's first slope ends.
    """
    stated, rates = spring.stated_rates, table_rates(spring)
    if not stated:
        return None
    at = np.asarray(spring.deflection, dtype=float)
    starts = at[: len(stated)]
    slope = np.asarray(stated, dtype=float)[: len(starts)]
    ends = np.append(starts[1:], np.inf)
    reach = np.clip(at[:, None], starts, ends) - starts
    carried = float(spring.load[0]) + reach @ slope
    table = spring_load(spring, at)
    apart = np.divide(carried, table, out=np.ones_like(table), where=table > 0) - 1
    worst = int(np.argmax(np.abs(apart)))
    if abs(apart[worst]) <= MISMATCH:
        return None
    return SpringMismatch(
        stated=tuple(stated),
        table=tuple(rates.tolist()),
        apart=float(apart[worst]),
        deflection=float(at[worst]),
    )


def mismatches(application: Application) -> Iterator[SpringMismatch]:
    """Yield the springs of an application that contradict themselves, each once."""
    seen: list[Suspension] = []
    for s in (application.suspension, *(i.suspension for i in application.lines)):
        if s is not None and not any(s is other for other in seen):
            seen.append(s)
            if found := spring_mismatch(s.spring):
                yield found
