"""Fill the pages with what the program itself says, so that no page can be out of date.

On a page with [[executed]] every piece of Python is run, one after the other as in a notebook, and
what it prints or comes to stands below it.

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
    if "[[executed]]" in markdown:
        markdown = executed(markdown)
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
        f"| {q.name} | {_cell(q.symbol)} | {q.unit_name} | `{q.key}` | {_said(q)} | {q.source} |"
        for q in QUANTITIES.values()
    ]
    return "\n".join(rows)


def _said(quantity: Any) -> str:
    """Return a quantity's equation for a cell: a formula drawn as one, or its text."""
    from cardan.base.formula import symbols

    if isinstance(quantity.equation, str):
        return _cell(quantity.equation)
    formula, (symbol,) = quantity.formula, symbols(quantity.symbol)
    given = "" if quantity.stated == str(formula) else f"{symbol.latex} = "
    return f"${given}{formula.latex}$"


def floors() -> str:
    """Return the floors of the house, highest first, from the contract on imports."""
    import tomllib

    settings = tomllib.loads(Path("pyproject.toml").read_text(encoding="utf-8"))
    layers = settings["tool"]["importlinter"]["contracts"][0]["layers"]
    rows = ["| floor | rooms | what they know |", "|---|---|---|"]
    for floor, layer in zip(range(len(layers) - 1, -1, -1), layers, strict=True):
        rooms = [room.strip() for room in layer.split("|")]
        knows = "<br>".join(_cell(_knows(room)) for room in rooms)
        rows.append(f"| {floor} | {'<br>'.join(f'`{r}`' for r in rooms)} | {knows} |")
    return "\n".join(rows)


def _knows(room: str) -> str:
    """Return the first line of what a room says of itself."""
    import ast

    at = Path("src/cardan") / room
    file = at / "__init__.py" if at.is_dir() else at.with_suffix(".py")
    said = ast.get_docstring(ast.parse(file.read_text(encoding="utf-8"))) or ""
    return said.split("\n\n")[0].replace("\n", " ").split(". ")[0].rstrip(".")


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
            "| quantity | unit | warns past | fails past | in states | required | who says so |",
            "|---|---|---|---|---|---|---|",
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
                f"| {q.name} | {q.unit_name} | {bounds[0]} | {bounds[1]} | {_states(limit)} "
                f"| {'yes' if limit.required else ''} | {limit.source} |"
            )
        pages.append(f"### {name}\n\n" + "\n".join(rows))
    return "\n\n".join(pages)


def _states(limit: Any) -> str:
    """Return the kinds of state a limit asks in, by their group where they are one."""
    from cardan.model.application import KIND_GROUPS, STATE_KINDS

    if limit.states is None:
        return "all"
    groups = {kinds: name for name, kinds in KIND_GROUPS.items()}
    return groups.get(limit.states) or ", ".join(k for k in STATE_KINDS if k in limit.states)


def published() -> str:
    """Return the published cases with what this program computes."""
    from cardan.study.published import published as cases

    rows = ["| case | published | computed | source | |", "|---|---|---|---|---|"]
    rows += [
        f"| {c.title} | {c.expected:.6g} | {c.computed:.6g} | {c.source} "
        f"| {'' if c.kind == 'published' else c.kind} |"
        for c in cases()
    ]
    return "\n".join(rows)


def reports() -> str:
    """Return every example's report in every language, as pictures."""
    pictures = sorted(Path("docs/reports").glob("*.png"))
    languages = {"en": "English", **_languages()}
    parts: list[str] = []
    for picture in pictures:
        name, code, _ = picture.name.split(".")
        parts.append(f"![Report of {name}, {languages[code]}](reports/{picture.name})\n")
        parts.append(f"*`examples/{name}.yaml`, {languages[code]}*\n")
    return "\n".join(parts)


def _languages() -> dict[str, str]:
    """Return the name of each catalogue's language, from its first line."""
    texts = Path("src/cardan/report/text").glob("*.po")
    heads = {p.stem: p.read_text(encoding="utf-8").partition("\n")[0] for p in texts}
    return {code: head.partition(", in ")[2].partition(".")[0] for code, head in heads.items()}


def over_speed() -> str:
    """Return what shakes the medium truck's bearing over its speed, as a report draws it."""
    from cardan import check, read
    from cardan.report.language import EN
    from cardan.report.plots import bearing_over_speed

    (response,) = check(
        read(Path(__file__).parents[1] / "examples" / "medium-truck-4x2.yaml")
    ).responses
    (figure,) = bearing_over_speed(response, EN, bearing=0)
    return f"<figure>{figure.svg}<figcaption>{figure.alt}. {figure.note}</figcaption></figure>"


WRITERS = {
    "[[bearing over speed]]": over_speed,
    "[[floors]]": floors,
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


def executed(markdown: str) -> str:
    """Return a page with what its pieces of Python print and come to below each."""
    space: dict[str, Any] = {"__name__": "__main__"}

    def run(found: re.Match[str]) -> str:
        return f"{found[0]}\n\n{_come_to(found[1], space)}".rstrip()

    markdown = markdown.replace("[[executed]]", "")
    return re.sub(r"^```python\n(.*?)^```$", run, markdown, flags=re.DOTALL | re.MULTILINE)


def _come_to(code: str, space: dict[str, Any]) -> str:
    """Run a piece of Python; return what it prints, and the value of its last line."""
    import ast
    import io
    from contextlib import redirect_stdout

    from cardan.base.errors import NotInstalled

    tree, value = ast.parse(code), None
    last = tree.body.pop() if isinstance(tree.body[-1], ast.Expr) else None
    printed = io.StringIO()
    try:
        with redirect_stdout(printed):
            exec(compile(tree, "<page>", "exec"), space)
            if last is not None:
                value = eval(compile(ast.Expression(last.value), "<page>", "eval"), space)
    except NotInstalled as needed:
        return f"*Not run here: {needed}.*"
    if hasattr(value, "_repr_html_"):
        return f'<div class="shown">{value._repr_html_()}</div>'
    said = printed.getvalue().rstrip() + ("" if value is None else repr(value))
    return f"```text\n{said}\n```" if said else ""


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
