"""Rainflow matrices of gauges, as they are kept in a table, read back and merged."""

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, Self, TypeAlias

from cardan.core.errors import DesignError
from cardan.core.units import MPa
from cardan.physics.fatigue.rainflow_matrix import RainflowKind, RainflowTable

Columns: TypeAlias = Mapping[str, Sequence[Any]]
"""A table by its columns, of one length; units are in their names."""

BIN_COLUMNS: Mapping[RainflowKind, tuple[str, str, str, str]] = {
    "from-to": ("from_low_MPa", "from_high_MPa", "to_low_MPa", "to_high_MPa"),
    "range-mean": ("range_low_MPa", "range_high_MPa", "mean_low_MPa", "mean_high_MPa"),
}
"""Edges of a bin along the two axes of a matrix: lower edges belong to it."""
DATA_COLUMN = "data"
"""How far the data of a gauge are to be trusted: good, doubtful, data rejected."""
DATA_GRADES = ("good", "doubtful", "data rejected")
"""From best to worst."""


@dataclass(frozen=True, kw_only=True)
class RainflowMatrices:
    """Rainflow matrices of some gauges, and how far the data of each are to be trusted.

    Attributes
    ----------
    kind
        `from-to` or `range-mean`.
    tables : Pa
        By gauge; a half cycle of the residue counts 0.5.
    grades
        By gauge: good, doubtful, data rejected.
    """

    kind: RainflowKind
    tables: Mapping[str, RainflowTable]
    grades: Mapping[str, str]

    def merged(self, other: "RainflowMatrices", *, times: float = 1.0) -> Self:
        """Return both as one, the other `times` as often, as a campaign merges its recordings.

        Raises
        ------
        DesignError
            If their kinds or gauges differ, or `times` is not above 0.
        """
        if not 0 < times < math.inf:
            msg = f"times must be finite and above 0, got {times:g}"
            raise DesignError(msg)
        if self.kind != other.kind:
            msg = f"a {self.kind} and a {other.kind} matrix cannot be merged"
            raise DesignError(msg)
        for name in {*self.tables} ^ {*other.tables}:
            msg = f"gauge {name!r} is in one of two files of matrices only"
            raise DesignError(msg)
        return replace(
            self,
            tables={n: t.merged(other.tables[n], times=times) for n, t in self.tables.items()},
            grades={n: worst_grade((g, other.grades[n])) for n, g in self.grades.items()},
        )

    def columns(self) -> Columns:
        """Return a table with a row for each bin that holds any cycle."""
        names = BIN_COLUMNS[self.kind]
        found: dict[str, list[Any]] = {n: [] for n in ("gauge", *names, "count", DATA_COLUMN)}
        for gauge, of in self.tables.items():
            for at, (low, high) in ((of.row, names[:2]), (of.column, names[2:])):
                found[low] += (at * of.width / MPa).tolist()
                found[high] += ((at + 1) * of.width / MPa).tolist()
            found["gauge"] += [gauge] * of.count.size
            found["count"] += of.count.tolist()
            found[DATA_COLUMN] += [self.grades[gauge]] * of.count.size
        return found


def worst_grade(grades: Iterable[str]) -> str:
    """Return the worst of some grades of data."""
    return max(grades, key=DATA_GRADES.index)
