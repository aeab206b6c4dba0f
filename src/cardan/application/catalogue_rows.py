"""What catalogues hold, row by row as it is written: to look things up."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any, cast

from cardan.application.catalogue import Catalogue, CatalogueCsvFile, CataloguePartKind
from cardan.application.typical_values import shipped_csv_rows as written_rows
from cardan.core.provenance import PROVENANCE_CODES, Source

PART_KIND_OR_FILE_BY_CATALOGUE_NAME: Mapping[str, str] = {
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
class CatalogueRow:
    """One row: its name, its cells by their keys as they are written, and where they are from.

    `part` is what a file that calls it by name gets, in SI; None of what no file calls.
    """

    catalogue: str
    name: str
    cells: Mapping[str, str]
    source: Source
    note: str = ""
    part: Any = field(default=None, compare=False)


def rows_of_catalogue(name: str, catalogue: Catalogue | None = None) -> tuple[CatalogueRow, ...]:
    """Return the rows of a kind of part, the user's own first."""
    of = catalogue or Catalogue()
    what = PART_KIND_OR_FILE_BY_CATALOGUE_NAME[name]
    if what.endswith(".csv"):
        return tuple(_fact(name, what, dict(row)) for row in written_rows(what))
    return tuple(_part(name, cast("CataloguePartKind", what), of))


def _fact(name: str, file: str, row: dict[str, str]) -> CatalogueRow:
    head = _HEAD.get(file, ("name",))
    said = [part.strip() for part in row["how_read"].split(",")]
    words = sorted((w for w in said if w in PROVENANCE_CODES), key=PROVENANCE_CODES.index)
    beside = ", ".join(w for w in said if w not in PROVENANCE_CODES)  # weak; a rule; slope computed
    return CatalogueRow(
        catalogue=name,
        name=", ".join(row[k] for k in head if row[k]),
        cells={k: v for k, v in row.items() if v and k not in _APART and k not in head},
        source=Source(row["source"], row.get("page", ""), words[-1] if words else "assumed"),
        note="; ".join(filter(None, (beside, row.get("note", "")))),
    )


def _part(name: str, kind: CataloguePartKind, of: Catalogue) -> Iterator[CatalogueRow]:
    seen: set[str] = set()
    for sheet in of.sheets(kind):
        for called in sheet.rows:
            if called not in seen:
                seen.add(called)
                cells = _cells(sheet, called)
                part = of.find(called, kind)
                yield CatalogueRow(
                    catalogue=name, name=called,
                    cells={k: v for k, v in cells.items() if v and k not in _APART},
                    source=part.source, note=cells.get("note", ""), part=part,
                )  # fmt: skip


def _cells(sheet: CatalogueCsvFile, name: str) -> dict[str, str]:
    _, cells = sheet.rows[name]
    return {k: c.strip() for k, c in zip(sheet.header, cells, strict=False)}
