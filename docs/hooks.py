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


def gallery() -> str:
    """Return every page of the gallery: its story, the figure it draws, its code."""
    import ast

    pages: list[str] = []
    for file in sorted((Path(__file__).parent / "gallery").glob("*.py")):
        text = file.read_text(encoding="utf-8")
        tree = ast.parse(text)
        headline, _, rest = (ast.get_docstring(tree) or "").partition("\n")
        code = "\n".join(text.splitlines()[tree.body[0].end_lineno :]).strip()
        pages += [f"## {headline}", rest.strip(), _figure(file), '??? example "The code"']
        pages.append(_indented(f"```python\n{code}\n```"))
    return "\n\n".join(pages)


def _figure(file: Path) -> str:
    """Return what a page draws, as an image inside the text."""
    import base64
    import io
    import runpy

    import matplotlib.pyplot as plt

    plt.switch_backend("agg")
    plt.show = lambda: None  # type: ignore[assignment]
    runpy.run_path(str(file))
    drawn = io.BytesIO()
    plt.gcf().savefig(drawn, format="png", dpi=100, bbox_inches="tight")
    plt.close("all")
    picture = base64.b64encode(drawn.getvalue()).decode()
    return f'<img alt="{file.stem.replace("_", " ")}" src="data:image/png;base64,{picture}">'


def _indented(text: str) -> str:
    return "\n".join(f"    {line}" if line else "" for line in text.splitlines())


def _cell(text: str) -> str:
    return text.replace("|", "\\|").replace("*", "\\*")


WRITERS = {
    "[[nomenclature]]": nomenclature,
    "[[changelog]]": changelog,
    "[[gallery]]": gallery,
}
