"""Fill the pages that the program itself can write: nomenclature, limits, published cases."""

from pathlib import Path


def on_page_markdown(markdown: str, **_: object) -> str:
    """Replace the markers of a page with what the package declares."""
    for marker, write in WRITERS.items():
        if marker in markdown:
            markdown = markdown.replace(marker, write())
    return markdown


def nomenclature() -> str:
    """Return the table of declared quantities."""
    from cardan.base.quantities import QUANTITIES

    rows = ["| name | symbol | unit | key | equation | source |", "|---|---|---|---|---|---|"]
    rows += [
        f"| {q.name} | {_cell(q.symbol)} | {q.unit_name} | `{q.key}` | {_cell(q.equation)} "
        f"| {q.source} |"
        for q in QUANTITIES.values()
    ]
    return "\n".join(rows)


def changelog() -> str:
    """Return the changelog of the repository."""
    return Path("CHANGELOG.md").read_text(encoding="utf-8")


def _cell(text: str) -> str:
    return text.replace("|", "\\|").replace("*", "\\*")


WRITERS = {"[[nomenclature]]": nomenclature, "[[changelog]]": changelog}
