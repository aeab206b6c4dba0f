"""What catalogues hold, as a terminal of 80 columns and the JSON contract show it."""

from collections.abc import Iterable, Iterator, Sequence
from functools import partial
from textwrap import wrap as wrapped
from typing import Any

from cardan.application.catalogue_rows import CatalogueRow
from cardan.core.provenance import provenance_text
from cardan.render.i18n import ENGLISH, Translator
from cardan.render.json_contract import to_json_types
from cardan.render.phrases import citation
from cardan.render.terminal import aligned_column_lines
from cardan.topics.design.part_selection import PartCandidate, PartRequirement, smallest_joint_name

LINE_WIDTH_COLUMNS = 80

wrap_line = partial(wrapped, break_on_hyphens=False)

LISTED_COLUMNS: dict[str, tuple[str, ...]] = {
    "joints": ("series", "peak_Nm", "nominal_Nm", "bearing_Td_Nm", "reversing_Nm"),
    "tubes": ("outer_mm", "wall_mm", "material"),
    "materials": ("youngs_modulus_GPa", "density_kg_m3", "yield_MPa", "ultimate_MPa"),
    "plies": ("along_GPa", "across_GPa", "shear_GPa", "thickness_mm", "density_kg_m3"),
    "details": ("range_MPa", "cycles", "slope", "mean", "metal"),
    "metals": ("fatigue_ratio", "cut_edge", "weld_toe", "bolt_border"),
    "tyres": ("outer_diameter_mm", "dynamic_radius_mm_computed", "wheel_inertia_kg_m2"),
    "bearings": ("maker", "offset_mm"),
    "limits": ("sense", "value", "unit", "maker"),
    "torsion": ("value", "unit", "vehicle_class"),
    "typical": ("value", "low", "high", "unit"),
}
"""Columns of each list; a row by itself shows all of its cells."""

MIN_CELL_CHARACTERS, MAX_CELL_CHARACTERS = 12, 22
"""Of a cell in a list; the row by itself has the rest."""


def catalogue_overview_lines(counts: dict[str, int], say: Translator = ENGLISH) -> Iterator[str]:
    """Yield what can be looked up, and how many rows there are."""
    says = {
        "joints": "universal joints, by name in `joints`",
        "tubes": "tubes, by name in `tube`",
        "materials": "metals, by name in `material`",
        "plies": "plies of composite tubes",
        "details": "fatigue details of brackets",
        "metals": "fatigue strength of kinds of metal, by `metal` of a material",
        "tyres": "wheels and tyres, by name in `wheels: tyre`",
        "bearings": "centre bearings",
        "limits": "limits as makers, standards and shops print them",
        "torsion": "inertias and stiffnesses of torsion, as printed",
        "typical": "typical values of torsion parts that a file does not give",
    }
    for name, count in counts.items():
        yield f"{name:<10}{count:>5}  {say(says[name])}"
    yield ""
    yield say("`cardan catalogue joints --for 1200Nm` lists what carries that, smallest first.")


def catalogue_row_lines(rows: Sequence[CatalogueRow], say: Translator = ENGLISH) -> Iterator[str]:
    """Yield rows as a list, and their sources with how each was read."""
    keys = LISTED_COLUMNS[rows[0].catalogue]
    keys = tuple(k for k in keys if any(k in r.cells for r in rows))
    yield from _listed(rows, [(key, [_cell(r, key) for r in rows]) for key in keys], say)


def part_candidate_lines(
    found: Sequence[PartCandidate], asked: PartRequirement, count: int, say: Translator = ENGLISH
) -> Iterator[str]:
    """Yield what fits, the smallest first, with what each uses of its ratings."""
    fit = [f for f in found if f.is_sufficient]
    small = [f for f in found if not f.is_sufficient and not f.unknown_ratings]
    unknown = len(found) - len(fit) - len(small)
    shown = fit[:count]
    if shown:
        tube = shown[0].row.catalogue == "tubes"
        first = ("kg/m", [say.compact_number(f.sort_size, 4) for f in shown]) if tube else (
            "peak_Nm", [say.compact_number(f.sort_size) for f in shown]
        )  # fmt: skip
        keys = dict.fromkeys(k for f in shown for k in f.utilisations)
        used = [
            (
                say(UTILISATION_TITLES[key]),
                [
                    say.with_decimal_sign(f"{100 * f.utilisations[key]:.0f} %")
                    if key in f.utilisations
                    else "-"
                    for f in shown
                ],
            )
            for key in keys
        ]
        own = "material" if tube else "series"
        of = (own, [_cell(f.row, own) for f in shown])
        yield from _listed([f.row for f in shown], [of, first, *used], say)
        yield ""
    more = len(fit) - len(shown)
    said = [say("{count} fit", count=len(fit))]
    if more:
        said.append(say("{count} of them not shown (--count)", count=more))
    said.append(say("{count} are too small", count=len(small)))
    if unknown:
        said.append(say("{count} without a required rating", count=unknown))
    yield from wrap_line("; ".join(said), LINE_WIDTH_COLUMNS)
    if small and not fit:
        best = small[0]
        key, most = max(best.utilisations.items(), key=lambda item: item[1])
        yield say(
            "{name} comes nearest: {share} % of what is allowed in {what}", name=best.row.name,
            share=say.compact_number(round(100 * most)), what=say(UTILISATION_TITLES[key]),
        )  # fmt: skip
    if asked.has_life_data and found[0].row.catalogue == "joints":
        name = smallest_joint_name((f.row for f in found), asked) or say("none")
        yield say("Least life rating that does: {name}", name=name)


UTILISATION_TITLES = {
    "joint_torque_utilisation": "torque",
    "joint_angle": "angle",
    "n_beta": "n x beta",
    "joint_speed": "speed",
    "joint_life": "life",
    "tube_shear_utilisation": "shear",
    "critical_speed_ratio": "whirl",
}
"""What is used of a rating, as heads of columns."""


def row_detail_lines(row: CatalogueRow, say: Translator = ENGLISH) -> Iterator[str]:
    """Yield everything of one row."""
    yield row.name
    apart = dict(row.source.apart)
    wide = max(map(len, row.cells), default=0)
    for key, cell in row.cells.items():
        word = next((w for k, w in apart.items() if key == k or key.startswith(f"{k}_")), "")
        said = f"{cell} ({say(provenance_text(word))})" if word else cell
        yield from wrap_line(
            said,
            LINE_WIDTH_COLUMNS,
            initial_indent=f"  {key:<{wide}}  ",
            subsequent_indent=" " * (wide + 4),
        )
    read = row.source.how_read
    facts = (
        (
            say("how it was read"),
            say(provenance_text(read)) if read else say("how it was read is not stated"),
        ),
        (say("source"), str(row.source)),
        (say("note"), row.note),
    )
    for head, text in facts:
        if text:
            yield from wrap_line(
                f"{head}: {text}", LINE_WIDTH_COLUMNS, initial_indent="  ", subsequent_indent="    "
            )


def _listed(
    rows: Sequence[CatalogueRow], cells: Sequence[tuple[str, list[str]]], say: Translator
) -> Iterator[str]:
    """Yield rows with their cells and the number of their source; then the sources."""
    sources = list(dict.fromkeys(citation(r.source, say) for r in rows))
    read = [say(provenance_text(r.source.how_read)) + ("*" if r.source.apart else "") for r in rows]
    number = [f"[{sources.index(citation(r.source, say)) + 1}]" for r in rows]
    head, tail = [("", [_cut(r.name, 32) for r in rows])], [(say("read"), read), ("", number)]
    kept = list(cells)
    while True:
        every = [*head, *kept, *tail]
        table = [tuple(h for h, _ in every), *zip(*(c for _, c in every), strict=True)]
        words = [0, *(k for k, (_, c) in enumerate(every) if k and not any(map(_numeric, c)))]
        table = _narrowed_table(table, words)
        if _table_width(table) <= LINE_WIDTH_COLUMNS or not kept:
            break
        kept.pop()  # the row by itself shows it
    yield from aligned_column_lines(table, words=words)
    yield ""
    for k, source in enumerate(sources, 1):
        yield from wrap_line(f"[{k}] {source}", LINE_WIDTH_COLUMNS, subsequent_indent="    ")


def _table_width(table: Sequence[tuple[str, ...]]) -> int:
    return sum(max(len(row[k]) for row in table) + 2 for k in range(len(table[0]))) - 2


def _narrowed_table(table: list[tuple[str, ...]], words: Sequence[int]) -> list[tuple[str, ...]]:
    """Return a table whose words are cut until its lines fit."""
    wide = [max(len(row[k]) for row in table) for k in range(len(table[0]))]
    while sum(wide) + 2 * (len(wide) - 1) > LINE_WIDTH_COLUMNS:
        may = [k for k in words if wide[k] > (MIN_CELL_CHARACTERS if k else MAX_CELL_CHARACTERS)]
        if not may:
            break
        widest = max(may, key=lambda k: wide[k])
        wide[widest] -= 1
    return [
        tuple(c if len(c) <= w else f"{c[: w - 1]}…" for c, w in zip(row, wide, strict=True))
        for row in table
    ]


def _cell(row: CatalogueRow, key: str) -> str:
    return _cut(row.cells.get(key, "-"))


def _cut(text: str, widest: int = MAX_CELL_CHARACTERS) -> str:
    return text if len(text) <= widest else f"{text[: widest - 1]}…"


def _numeric(text: str) -> bool:
    try:
        float(text.rstrip(" %"))
    except ValueError:
        return False
    return True


def json_document(found: Iterable[CatalogueRow | PartCandidate]) -> list[dict[str, Any]]:
    """Return rows as the JSON contract has them, what fits with what it uses."""
    return to_json_types([_entry(one) for one in found])


def _entry(one: CatalogueRow | PartCandidate) -> dict[str, Any]:
    row = one.row if isinstance(one, PartCandidate) else one
    entry: dict[str, Any] = {
        "catalogue": row.catalogue,
        "name": row.name,
        "values": {k: float(v) if _numeric(v) else v for k, v in row.cells.items()},
        "source": str(row.source),
        "how_read": row.source.how_read or None,
        "apart": dict(row.source.apart),
        "note": row.note,
    }
    if isinstance(one, PartCandidate):
        entry |= {
            "fits": one.is_sufficient,
            "used": one.utilisations,
            "unknown": list(one.unknown_ratings),
        }
    return entry
