"""Fill the pages with what the program itself says, so that no page can be out of date.

A marker [[name]] stands for something declared in the package. [[cardan check FILE]] stands for
what that command prints; [[cardan check FILE :: this ... that]] for its lines from the first that
starts with "this" until one that starts with "that". Formulas become MathML, which browsers draw
without any script.
"""

import json
import re
import shlex
from pathlib import Path
from typing import Any


def on_page_markdown(markdown: str, **_: object) -> str:
    """Replace the markers of a page with what the package says."""
    for marker, write in WRITERS.items():
        if marker in markdown:
            markdown = markdown.replace(marker, write())
    return re.sub(r"^\[\[cardan ([^\]]*)\]\]$", _printed, markdown, flags=re.MULTILINE)


def on_page_content(html: str, **_: object) -> str:
    """Draw the formulas of a page."""
    return re.sub(r'<(span|div) class="arithmatex">\\([(\[])(.*?)\\[)\]]</\1>', _drawn, html,
                  flags=re.DOTALL)  # fmt: skip


def nomenclature() -> str:
    """Return the table of declared quantities."""
    from cardan.quantity.quantities import QUANTITIES

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

    from cardan.base.errors import NotInstalled

    plt.switch_backend("agg")
    plt.show = lambda: None  # type: ignore[assignment]
    try:
        runpy.run_path(str(file))
    except NotInstalled as needed:
        return f"*Not drawn here: {needed}.*"
    if not plt.get_fignums():
        return ""
    drawn = io.BytesIO()
    plt.gcf().savefig(drawn, format="png", dpi=100, bbox_inches="tight")
    plt.close("all")
    picture = base64.b64encode(drawn.getvalue()).decode()
    return f'<img alt="{file.stem.replace("_", " ")}" src="data:image/png;base64,{picture}">'


def _indented(text: str) -> str:
    return "\n".join(f"    {line}" if line else "" for line in text.splitlines())


def keys() -> str:
    """Return every key of the application file, table by table."""
    from cardan import files

    schema = files.schema()
    tables = schema["$defs"]
    first = schema["$ref"].rpartition("/")[2]
    return "\n\n".join(
        _table(name, tables[name]) for name in [first, *(t for t in tables if t != first)]
    )


def contract() -> str:
    """Return every key of the JSON contract."""
    from cardan.report.contract_schema import schema as described

    schema = described()
    tables = {"document": schema, **schema["$defs"]}
    tables["line_state"]["properties"] = {}
    tables["line_state"]["description"] += " The keys of a state but `name`, `line` and `lines`."
    return "\n\n".join(_table(name, table) for name, table in tables.items())


def relations() -> str:
    """Return what values of an application file are held against each other."""
    from cardan.files.plausible import RELATIONS

    rows = ["| what | usual |", "|---|---|"]
    for r in RELATIONS:
        low, high = (f"{bound:.3g}{r.unit}" for bound in r.usual)
        rows.append(
            f"| {r.says.strip(',')} | {low} {'or more' if high == 'inf' else f'to {high}'} |"
        )
    return "\n".join(rows)


def cycles() -> str:
    """Return the duty cycles that come with the package, point by point."""
    from cardan.files.cycle import cycle, names

    pages: list[str] = []
    for name in names():
        found = cycle(name)
        rows = ["| of the time | of the largest torque | of top speed |", "|---|---|---|"]
        rows += [
            " | ".join(f"{100 * v:g} %" for v in (p.share, p.torque_share, p.speed_share)).join(
                "||"
            )
            for p in found.points
        ]
        pages.append(f"`{name}`: {found.says} {found.source}.\n\n" + "\n".join(rows))
    return "\n\n".join(pages)


def profiles() -> str:
    """Return the limit profiles that come with the package, limit by limit."""
    from cardan.files.limit import limits, names
    from cardan.quantity.quantities import QUANTITIES

    pages: list[str] = []
    for name in names():
        rows = [
            "| quantity | unit | warns past | fails past | who says so |",
            "|---|---|---|---|---|",
        ]
        for limit in limits(name)[1]:
            q = QUANTITIES[limit.quantity]
            bounds = [
                ""
                if b is None
                else f"{limit.sense} {b / q.factor:.6g}".replace("<=", "≤").replace(">=", "≥")
                for b in (limit.normal, limit.maximum)
            ]
            if limit.band:
                low, high = (b / q.factor for b in limit.band)
                bounds[0] = f"inside {low:g} … {high:g}"
            rows.append(
                f"| {q.name} | {q.unit_name} | {bounds[0]} | {bounds[1]} | {limit.source} |"
            )
        pages.append(f"### {name}\n\n" + "\n".join(rows))
    return "\n\n".join(pages)


def published() -> str:
    """Return the published cases with what this program computes."""
    from cardan.study.published import published as cases

    rows = ["| case | published | computed | source |", "|---|---|---|---|"]
    rows += [f"| {c.title} | {c.expected:.6g} | {c.computed:.6g} | {c.source} |" for c in cases()]
    return "\n".join(rows)


def reports() -> str:
    """Return every example's report in every language, as pictures."""
    pictures = sorted(Path("docs/reports").glob("*.png"))
    languages = {"en": "English", "pt": "português", "it": "italiano"}
    parts: list[str] = []
    for picture in pictures:
        name, code, _ = picture.name.split(".")
        parts.append(f"![Report of {name}, {languages[code]}](reports/{picture.name})\n")
        parts.append(f"*`examples/{name}.yaml`, {languages[code]}*\n")
    return "\n".join(parts)


WRITERS = {
    "[[reports]]": reports,
    "[[nomenclature]]": nomenclature, "[[changelog]]": changelog, "[[keys]]": keys,
    "[[contract]]": contract, "[[profiles]]": profiles, "[[published]]": published,
    "[[gallery]]": gallery, "[[relations]]": relations, "[[cycles]]": cycles,
}  # fmt: skip


def _cell(text: str) -> str:
    return text.replace("|", "\\|").replace("*", "\\*").replace("\n", " ")


def _table(name: str, schema: dict[str, Any]) -> str:
    """Return an object of a JSON Schema as a heading, what it is, and its keys."""
    rows = [f"### {name}", "", schema.get("description", ""), ""]
    rows += ["| key | what it is |", "|---|---|"] if schema["properties"] else []
    rows += [
        f"| `{key}` | {_cell(entry.get('description', ''))}{_kind(entry)} |"
        for key, entry in schema["properties"].items()
    ]
    return "\n".join(rows)


def _kind(entry: dict[str, Any]) -> str:
    """Return which object an entry holds, if it holds one."""
    found = re.findall(r'"\$ref": "#/\$defs/(\w+)"', json.dumps(entry))
    names = dict.fromkeys(found)
    return "".join(f" → [{name}](#{name.lower()})" for name in names)


def _printed(found: re.Match[str]) -> str:
    """Return what a command prints, as a block of text."""
    from click.testing import CliRunner

    from cardan.cli import cli

    command, _, part = (text.strip() for text in found[1].partition("::"))
    result = CliRunner().invoke(cli, shlex.split(command), catch_exceptions=False)
    output = result.output.splitlines()
    first, _, last = (text.strip() for text in part.partition("..."))
    start = next(k for k, line in enumerate(output) if line.startswith(first))
    ends = (k for k, line in enumerate(output) if k > start and last and line.startswith(last))
    end = next(ends, len(output))
    before, after = ["…"] * (start > 0), ["…"] * (end < len(output))
    while not output[end - 1]:
        end -= 1
    output = [*before, *output[start:end], *after]
    return "\n".join(["```text", f"$ cardan {command}", *output, "```"])


def _drawn(found: re.Match[str]) -> str:
    """Return a formula as MathML."""
    from html import unescape

    from latex2mathml.converter import convert

    display = "block" if found[2] == "[" else "inline"
    return convert(unescape(found[3]), display=display)
