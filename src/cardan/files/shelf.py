"""What catalogues hold, row by row as it is written: to look things up."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any, cast

from cardan.base.source import HOW_READ, Source
from cardan.files.catalogue import Catalogue, Kind, Sheet
from cardan.files.typical import rows as written_rows

SHELVES: Mapping[str, str] = {
    "joints": "joint",
    "tubes": "tube",
    "materials": "material",
    "plies": "ply",
    "details": "detail",
    "metals": "metals.csv",
    "tyres": "tyres.csv",
    "bearings": "bearings.csv",
    "limits": "limits.csv",
    "torsion": "torsion_parts.csv",
    "typical": "typical.csv",
}
"""What can be looked up: kinds of part that files call by name, and files of other facts."""

_HEAD = {
    "limits.csv": ("quantity",),
    "torsion_parts.csv": ("part", "quantity"),
    "typical.csv": ("quantity", "vehicle_class"),
}
"""What stands for a name where there is none."""

_APART = {"name", "source", "how_read", "note", "page"}


@dataclass(frozen=True, kw_only=True)
class Row:
    """One row: its name, its cells by their keys as they are written, and where they are from.

    `part` is what a file that calls it by name gets, in SI; None of what no file calls.
    """

    shelf: str
    name: str
    cells: Mapping[str, str]
    source: Source
    note: str = ""
    part: Any = field(default=None, compare=False)


def shelf(name: str, catalogue: Catalogue | None = None) -> tuple[Row, ...]:
    """Return the rows of a shelf, the user's own first."""
    of = catalogue or Catalogue()
    what = SHELVES[name]
    if what.endswith(".csv"):
        return tuple(_fact(name, what, dict(row)) for row in written_rows(what))
    return tuple(_part(name, cast("Kind", what), of))


def _fact(name: str, file: str, row: dict[str, str]) -> Row:
    head = _HEAD.get(file, ("name",))
    said = [part.strip() for part in row["how_read"].split(",")]
    words = sorted((w for w in said if w in HOW_READ), key=HOW_READ.index)
    beside = ", ".join(w for w in said if w not in HOW_READ)  # weak; a rule; slope computed
    return Row(
        shelf=name,
        name=", ".join(row[k] for k in head if row[k]),
        cells={k: v for k, v in row.items() if v and k not in _APART and k not in head},
        source=Source(row["source"], row.get("page", ""), words[-1] if words else "assumed"),
        note="; ".join(filter(None, (beside, row.get("note", "")))),
    )


def _part(name: str, kind: Kind, of: Catalogue) -> Iterator[Row]:
    seen: set[str] = set()
    for sheet in of.sheets(kind):
        for called in sheet.rows:
            if called not in seen:
                seen.add(called)
                cells = _cells(sheet, called)
                part = of.find(called, kind)
                yield Row(
                    shelf=name, name=called,
                    cells={k: v for k, v in cells.items() if v and k not in _APART},
                    source=part.source, note=cells.get("note", ""), part=part,
                )  # fmt: skip


def _cells(sheet: Sheet, name: str) -> dict[str, str]:
    _, cells = sheet.rows[name]
    return {k: c.strip() for k, c in zip(sheet.header, cells, strict=False)}
