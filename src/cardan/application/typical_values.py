"""Values that stand in where a file says nothing, each with its range and its source."""

import csv
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from pathlib import Path

from cardan.core.units import UNITS
from cardan.schema.node_reader import nearest_name_hint

VEHICLE_CLASS_MAX_MASS_KG = {"van": 4e3, "medium truck": 16e3, "heavy truck": float("inf")}
"""Classes of vehicle, by the mass in kg that each goes up to."""


@dataclass(frozen=True, slots=True, kw_only=True)
class TypicalValue:
    """A value in SI with the range it may have, where it is from and how that was read."""

    quantity: str
    value: float
    low: float
    high: float
    unit: str
    source: str
    how_read: str


@cache
def shipped_csv_rows(file: str) -> tuple[Mapping[str, str], ...]:
    """Return the rows of a shipped CSV file."""
    path = Path(__file__).with_name("catalogues") / file
    with path.open(encoding="utf-8", newline="") as opened:
        return tuple(csv.DictReader(opened))


def find_csv_row_by_name(file: str, name: str) -> tuple[Mapping[str, str] | None, str]:
    """Return the row of a name, blanks and case aside, or None with advice on what there is."""
    every = {row["name"]: row for row in shipped_csv_rows(file)}
    bare = {known.replace(" ", "").casefold(): row for known, row in every.items()}
    return bare.get(name.replace(" ", "").casefold()), nearest_name_hint(name, every)


def vehicle_class_of(mass: float) -> str:
    """Return the class of a vehicle by its mass, kg."""
    return next(name for name, most in VEHICLE_CLASS_MAX_MASS_KG.items() if mass <= most)


def typical_value(quantity: str, vehicle_class: str) -> TypicalValue:
    """Return what a quantity typically is in a class of vehicle."""
    (row,) = (
        r for r in shipped_csv_rows("typical.csv")
        if (r["quantity"], r["vehicle_class"]) == (quantity, vehicle_class)
    )  # fmt: skip
    worth = UNITS[row["unit"]]
    value, low, high = (float(row[k]) * worth for k in ("value", "low", "high"))
    return TypicalValue(
        quantity=quantity, value=value, low=low, high=high, unit=row["unit"],
        source=row["source"], how_read=row["how_read"],
    )  # fmt: skip
