"""Fill the pages with what the program itself says, so that no page can be out of date.

On a page with [[executed]] every piece of Python is run, one after the other as in a notebook, and
what it prints or comes to stands below it.

A marker [[name]] stands for something declared in the package, [[options life]] for the options
of that command with the keys of a campaign. [[cardan check FILE]] stands for
what that command prints; [[cardan check FILE :: this ... that]] for its lines from the first that
starts with "this" until one that starts with "that". Formulas become MathML, which browsers draw
without any script.

What takes time is kept in build/docs, by what it was made of: its own text and the package. When
either changes it is made anew, ahead of the pages and on all cores: `python docs/hooks.py FILE...`
makes what these files of the gallery and pages need.
"""

import hashlib
import json
import os
import re
import shlex
from collections.abc import Callable
from contextlib import suppress
from functools import cache, partial
from math import inf
from pathlib import Path
from typing import Any

KEPT = Path("build/docs")
"""What was made before, each in a file named after what it was made of."""


def on_pre_build(**_: object) -> None:
    """Make what takes time, each file in a process of its own."""
    import subprocess
    import sys
    from concurrent.futures import ThreadPoolExecutor

    def make(file: Path) -> None:
        subprocess.run([sys.executable, __file__, str(file)], check=True)

    slow = sorted(Path("docs/gallery").glob("*.py"), reverse=True)  # the longest are not the last
    slow += [p for p in sorted(Path("docs").glob("*.md")) if _slow(p.read_text(encoding="utf-8"))]
    with ThreadPoolExecutor(os.cpu_count()) as pool:
        list(pool.map(make, slow))


def _slow(page: str) -> bool:
    """Return whether a page runs something."""
    return any(marker in page for marker in ("[[executed]]", "[[cardan ", *EFFECTS))


def _made(file: Path) -> None:
    """Make and keep what a page of the gallery draws, or what a page runs."""
    text = file.read_text(encoding="utf-8")
    if file.suffix == ".py":
        _kept(text, lambda: _figure(file))
    else:
        on_page_markdown(text)


def on_page_markdown(markdown: str, **_: object) -> str:
    """Replace the markers of a page with what the package says."""
    if "\n::: cardan." in markdown:
        title, _, modules = markdown.partition("\n")
        markdown = f"{title}\n\n{stability(modules)}\n{modules}"
    for marker, write in WRITERS.items():
        if marker in markdown:
            markdown = markdown.replace(marker, write())
    markdown = re.sub(
        r"^\[\[options (\w+)\]\]$", lambda found: options(found[1]), markdown, flags=re.MULTILINE
    )
    if "[[executed]]" in markdown:
        page = markdown
        markdown = _kept(page, lambda: executed(page))
    return re.sub(
        r"^\[\[cardan ([^\]]*)\]\]$",
        lambda found: _kept(found[0], lambda: _printed(found)),
        markdown,
        flags=re.MULTILINE,
    )


def on_page_content(html: str, **_: object) -> str:
    """Draw the formulas of a page."""
    return re.sub(r'<(span|div) class="arithmatex">\\([(\[])(.*?)\\[)\]]</\1>', _drawn, html,
                  flags=re.DOTALL)  # fmt: skip


SAMPLE = Path("examples/van.yaml")
"""The example whose whole reports can be opened on the page about reports."""


def on_post_build(config: Any, **_: object) -> None:
    """Write the sample reports beside the pages."""
    import cardan

    found = cardan.check(cardan.read(SAMPLE))
    for code in {"en": "", **_languages()}:
        for ending in ("html", "pdf", "xlsx"):
            at = Path(config["site_dir"]) / "reports" / f"{SAMPLE.stem}.{code}.{ending}"
            at.parent.mkdir(parents=True, exist_ok=True)
            found.report(at, lang=code)


def samples() -> str:
    """Return links to the sample reports, a row for each language."""
    rows = ["| | page | document | workbook |", "|---|---|---|---|"]
    for code, name in {"en": "English", **_languages()}.items():
        links = [
            f'<a href="{SAMPLE.stem}.{code}.{ending}">{ending.upper()}</a>'
            for ending in ("html", "pdf", "xlsx")
        ]
        rows.append(f"| {name} | {' | '.join(links)} |")
    return "\n".join(rows)


def nomenclature() -> str:
    """Return the table of declared quantities."""
    from cardan.checks.quantities.registry import QUANTITIES

    rows = ["| name | symbol | unit | key | equation | source |", "|---|---|---|---|---|---|"]
    rows += [
        f"| {q.name} | {_cell(q.symbol)} | {q.unit_symbol} | `{q.key}` | {_said(q)} | {q.source} |"
        for q in QUANTITIES.values()
    ]
    return "\n".join(rows)


def _said(quantity: Any) -> str:
    """Return a quantity's equation for a cell: a formula drawn as one, or its text."""
    from cardan.core.symbolic import symbols

    if isinstance(quantity.equation, str):
        return _cell(quantity.equation)
    formula, (symbol,) = quantity.formula, symbols(quantity.symbol)
    given = "" if quantity.equation_text == str(formula) else f"{symbol.latex} = "
    return f"${given}{formula.latex}$"


def layers() -> str:
    """Return the table of layers, highest first, from the import contract."""
    import tomllib

    settings = tomllib.loads(Path("pyproject.toml").read_text(encoding="utf-8"))
    declared = settings["tool"]["importlinter"]["contracts"][0]["layers"]
    rows = ["| layer | packages | content |", "|---|---|---|"]
    for level, layer in zip(range(len(declared) - 1, -1, -1), declared, strict=True):
        packages = [package.strip() for package in layer.split("|")]
        content = "<br>".join(_cell(_summary(package)) for package in packages)
        rows.append(f"| {level} | {'<br>'.join(f'`{p}`' for p in packages)} | {content} |")
    return "\n".join(rows)


def _summary(package: str) -> str:
    """Return the first sentence of a package's docstring."""
    import ast

    at = Path("src/cardan") / package
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
        pages += [
            f"## {headline}",
            rest.strip(),
            _kept(text, lambda file=file: _figure(file)),
            '??? example "The code"',
        ]
        pages.append(_indented(f"```python\n{code}\n```"))
    return "\n\n".join(pages)


def _kept(text: str, make: Callable[[], str]) -> str:
    """Return what was made of a text by this package, from before where it is there."""
    made = KEPT / f"{hashlib.sha256((text + _package()).encode()).hexdigest()}.txt"
    if not made.exists():
        made.parent.mkdir(parents=True, exist_ok=True)
        part = made.with_suffix(f".{os.getpid()}")  # another process may make the same
        part.write_text(make(), encoding="utf-8")
        part.replace(made)
    return made.read_text(encoding="utf-8")


@cache
def _package() -> str:
    """Return a digest of all that a page is made with: package, examples, this file."""
    digest = hashlib.sha256(Path(__file__).read_bytes())
    for folder in ("src/cardan", "examples", "docs"):
        for file in sorted(Path(folder).rglob("*")):
            if file.suffix in (".py", ".yaml", ".csv", ".po", ".json"):
                digest.update(str(file).encode() + file.read_bytes())
    return digest.hexdigest()


def _figure(file: Path) -> str:
    """Return what a page draws, as an image inside the text, or what it prints.

    A page that solves a bracket and draws nothing takes minutes for a few lines of text: it says
    how to run it.
    """
    import base64
    import io
    import runpy
    from contextlib import redirect_stdout

    import matplotlib.pyplot as plt

    from cardan.core.errors import MissingDependencyError

    text = file.read_text(encoding="utf-8")
    draws = "matplotlib" in text
    if "cardan.topics.bracket" in text and not draws:
        return f"*Solved when it is run: `python docs/gallery/{file.name}`, a minute or two.*"
    plt.switch_backend("agg")
    printed = io.StringIO()
    plt.show = lambda: None  # type: ignore[assignment]
    try:
        with redirect_stdout(printed):
            runpy.run_path(str(file))
    except MissingDependencyError as needed:
        return f"*Not drawn here: {needed}.*"
    if not draws:
        return f"```text\n{printed.getvalue().rstrip()}\n```" if printed.getvalue() else ""
    drawn = io.BytesIO()
    plt.gcf().savefig(drawn, format="png", dpi=100, bbox_inches="tight")
    plt.close("all")
    picture = base64.b64encode(drawn.getvalue()).decode()
    return f'<img alt="{file.stem.replace("_", " ")}" src="data:image/png;base64,{picture}">'


def _indented(text: str) -> str:
    return "\n".join(f"    {line}" if line else "" for line in text.splitlines())


def keys() -> str:
    """Return every key of the application file, table by table, with an example of each."""
    from cardan.application import json_schema

    schema = json_schema.application_schema()
    tables = {name: table for name, table in schema["$defs"].items() if "properties" in table}
    first = schema["$ref"].rpartition("/")[2]
    examples = _examples(tables, first)
    return "\n\n".join(
        _keys_of(name, tables[name], examples.get(name, {}))
        for name in [first, *(t for t in tables if t != first)]
    )


def _keys_of(name: str, schema: dict[str, Any], examples: dict[str, str]) -> str:
    """Return the keys of a table: those that differ in their unit alone share a row."""
    rows = [f"### {name}", "", schema.get("description", ""), ""]
    rows += [
        "| key | required | range | default | example | what it is |",
        "|---|---|---|---|---|---|",
    ]
    groups: dict[str, list[tuple[str, str]]] = {}
    for key, entry in schema["properties"].items():
        said, _, unit = entry.get("description", "").rpartition(", ")
        measured = bool(unit) and key.endswith(f"_{unit}")
        base = key.removesuffix(f"_{unit}") if measured else key
        groups.setdefault(base, []).append(
            (key, said if measured else entry.get("description", ""))
        )
    for base, group in groups.items():
        (key, said), *others = group
        said, _, default = said.partition(" (default ")
        entry = schema["properties"][key]
        shown = [f"`{key}`", *(f"`{other.removeprefix(base)}`" for other, _ in others)]
        example = next((f"{k}: {examples[k]}" for k, _ in group if k in examples), "")
        if not example and "enum" in entry:
            example = f"{key}: {entry['enum'][-1]}"
        rows.append(
            f"| {', '.join(shown)} | {_required(schema, [k for k, _ in group], groups)} "
            f"| {_cell(_range(entry))} | {default.removesuffix(')')} "
            f"| {f'`{_cell(example)}`' if example else ''} | {_cell(said)}{_kind(entry)} |"
        )
    return "\n".join(rows)


def _required(
    schema: dict[str, Any], mine: list[str], groups: dict[str, list[tuple[str, str]]]
) -> str:
    """Return whether a table cannot do without a key, or which other keys may stand for it."""
    if mine[0] in schema.get("required", []):
        return "yes"
    bases = {key: base for base, group in groups.items() for key, _ in group}
    for one in schema.get("allOf", []):
        choices = [k for c in one.get("oneOf", []) for k in c.get("required", [])]
        if mine[0] not in choices or any("not" in c for c in one["oneOf"]):
            continue
        others = dict.fromkeys(bases[k] for k in choices if k not in mine)
        return f"or {', '.join(f'`{o}`' for o in others)}" if others else "yes"
    return ""


def _range(entry: dict[str, Any]) -> str:
    """Return what may stand at a key, as people write it."""
    if len(entry.get("enum", [])) > 16:
        return "a name of the catalogue"
    if "enum" in entry:
        return ", ".join(str(v) for v in entry["enum"])
    if "anyOf" in entry:
        kinds = dict.fromkeys(_range(e) for e in entry["anyOf"])
        return " or ".join(k for k in kinds if k)
    match entry.get("type"):
        case "boolean":
            return "true, false"
        case "array":
            few, many = entry.get("minItems", 0), entry.get("maxItems", 0)
            each = _range(entry.get("items", {}))
            size = f"{many}" if few == many else f"{few} to {many}" if few else f"up to {many}"
            return f"{size} × ({each})" if each else f"a list of {size}"
        case "number" | "integer":
            above, low = entry.get("exclusiveMinimum"), entry.get("minimum")
            below, high = entry.get("exclusiveMaximum"), entry.get("maximum")
            lower = f"> {above:g}" if above is not None else "" if low is None else f"≥ {low:g}"
            upper = f"< {below:g}" if below is not None else "" if high is None else f"≤ {high:g}"
            if low is not None and high is not None:
                return f"{low:g} … {high:g}"
            return ", ".join(filter(None, (lower, upper))) or "number"
        case "object":
            return "by name"
        case None:
            return "table" if "$ref" in entry else ""
        case _:
            return "text"


def _examples(tables: dict[str, Any], first: str) -> dict[str, dict[str, str]]:
    """Return how starters, examples and these pages write each key of each table."""
    import csv
    import io

    import yaml

    found: dict[str, dict[str, str]] = {}

    def take(node: Any, names: list[str]) -> None:
        if isinstance(node, list):
            for item in node:
                take(item, names)
        if not isinstance(node, dict):
            return
        fitting = [n for n in names if set(node) <= set(tables[n]["properties"])]
        if not fitting:  # a table of names: of loads, of lines
            for item in node.values():
                take(item, names)
        for name in fitting[:1]:
            for key, value in node.items():
                entry = tables[name]["properties"][key]
                inside = re.findall(r'"\$ref": "#/\$defs/(\w+)"', json.dumps(entry))
                take(value, [n for n in inside if n in tables])
                written = yaml.safe_dump(
                    value, default_flow_style=True, width=200, allow_unicode=True
                )
                text = written.removesuffix("...\n").strip()
                mine = found.setdefault(name, {})
                if len(text) <= 40 and "..." not in text and not isinstance(value, dict):
                    mine.setdefault(key, text)

    sources = ("src/cardan/application/starters", "examples", "docs/gallery", "tests/verify")
    for folder in sources:
        for file in sorted(Path(folder).glob("*.yaml")):
            read = yaml.safe_load(file.read_text(encoding="utf-8"))
            if isinstance(read, dict) and set(read) <= set(tables[first]["properties"]):
                take(read, [first])
    sheets = {"joints": "Joint", "materials": "Material", "plies": "Ply", "details": "DetailClass"}
    for stem, name in sheets.items():
        text = Path(f"src/cardan/application/catalogues/{stem}.csv").read_text(encoding="utf-8")
        for row in csv.DictReader(io.StringIO(text)):
            for key, value in row.items():
                if value and len(value) <= 40 and key in tables[name]["properties"]:
                    found.setdefault(name, {}).setdefault(key, value)
    for page in sorted(Path("docs").glob("*.md")):
        for block in re.findall(
            r"^```yaml\n(.*?)^```", page.read_text(encoding="utf-8"), re.DOTALL | re.MULTILINE
        ):
            with suppress(yaml.YAMLError):  # some show a part of a file, with dots
                take(yaml.safe_load(block), [first, *tables])
    return found


def contract() -> str:
    """Return every key of the JSON contract."""
    from cardan.documents.approval_schema import schema as described

    schema = described()
    tables = {"document": schema, **schema["$defs"]}
    tables["line_state"]["properties"] = {}
    tables["line_state"]["description"] += " The keys of a state but `name`, `line` and `lines`."
    return "\n\n".join(_table(name, table) for name, table in tables.items())


def relations() -> str:
    """Return what values of an application file are held against each other."""
    from cardan.application.plausibility import PLAUSIBILITY_RULES

    def shown(low: float, high: float, unit: str) -> str:
        return f"{low:.3g}{unit} {'or more' if high == inf else f'to {high:.3g}{unit}'}"

    rows = ["| name | what | usual | source of the range |", "|---|---|---|---|"]
    for r in PLAUSIBILITY_RULES:
        usual = r.usual_range
        text = (
            shown(*usual, r.unit)
            if isinstance(usual, tuple)
            else "; ".join(f"{kind}: {shown(*one, r.unit)}" for kind, one in usual.items())
        )
        rows.append(f"| `{r.name}` | {r.description.strip(',')} | {text} | {r.source} |")
    return "\n".join(rows)


def cycles() -> str:
    """Return the duty cycles that come with the package, point by point."""
    from cardan.application.duty_cycles import duty_cycle_names, load_duty_cycle

    pages: list[str] = []
    for name in duty_cycle_names():
        found = load_duty_cycle(name)
        rows = ["| of the time | of the largest torque | of top speed |", "|---|---|---|"]
        rows += [
            " | ".join(f"{100 * v:g} %" for v in (p.share, p.torque_share, p.speed_share)).join(
                "||"
            )
            for p in found.points
        ]
        pages.append(f"`{name}`: {found.description} {found.source}.\n\n" + "\n".join(rows))
    return "\n\n".join(pages)


def profiles() -> str:
    """Return the limit profiles that come with the package, limit by limit."""
    from cardan.application.limit_profiles import load_profile, profile_names
    from cardan.checks.quantities.registry import QUANTITIES

    pages: list[str] = []
    for name in profile_names():
        rows = [
            "| quantity | unit | recommended | maximum | in states | required | source |",
            "|---|---|---|---|---|---|---|",
        ]
        for limit in load_profile(name)[1]:
            q = QUANTITIES[limit.quantity]
            bounds = [
                ""
                if b is None
                else f"{limit.sense} {b / q.si_factor:.6g}".replace("<=", "≤").replace(">=", "≥")
                for b in (limit.normal, limit.maximum)
            ]
            if limit.band:
                low, high = (b / q.si_factor for b in limit.band)
                bounds[0] = f"inside {low:g} … {high:g}"
            rows.append(
                f"| {q.name} | {q.unit_symbol} | {bounds[0]} | {bounds[1]} | {_states(limit)} "
                f"| {'yes' if limit.required else ''} | {limit.source} |"
            )
        pages.append(f"### {name}\n\n" + "\n".join(rows))
    return "\n\n".join(pages)


def _states(limit: Any) -> str:
    """Return the kinds of state a limit asks in, by their group where they are one."""
    from cardan.model.application import STATE_KIND_GROUPS, STATE_KINDS

    if limit.states is None:
        return "all"
    groups = {kinds: name for name, kinds in STATE_KIND_GROUPS.items()}
    return groups.get(limit.states) or ", ".join(k for k in STATE_KINDS if k in limit.states)


def published() -> str:
    """Return the published cases with what this program computes."""
    from cardan.topics.verification.published_cases import benchmark_cases as cases

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
    texts = Path("src/cardan/render/locales").glob("*.po")
    heads = {p.stem: p.read_text(encoding="utf-8").partition("\n")[0] for p in texts}
    return {code: head.partition(", in ")[2].partition(".")[0] for code, head in heads.items()}


def over_speed() -> str:
    """Return what shakes the medium truck's bearing over its speed, as a report draws it."""
    from cardan import check, read
    from cardan.documents.line_plots import bearing_over_speed_plots
    from cardan.render.i18n import ENGLISH

    (response,) = check(
        read(Path(__file__).parents[1] / "examples" / "medium-truck-4x2.yaml")
    ).line_responses
    (figure,) = bearing_over_speed_plots(response, ENGLISH, bearing=0)
    return f"<figure>{figure.svg}<figcaption>{figure.alt}. {figure.note}</figcaption></figure>"


EFFECTS = {
    "[[bearing force by model]]": "parts_table",
    "[[effects left out]]": "effects_table",
}
"""Tables of docs/effects.py, by their markers."""


def effects(marker: str) -> str:
    """Return a table of docs/effects.py: checks of examples with one thing changed."""
    import runpy

    return _kept(marker, runpy.run_path("docs/effects.py")[EFFECTS[marker]])


def tolerance_that_decides() -> str:
    """Return what halving each tolerance wins, and how the limit scatters that trucks lose."""
    from cardan import read, study
    from cardan.topics.variants.presentation_figures import figures
    from cardan.topics.variants.schema import read_variant_study as read_study

    truck = read(Path(__file__).parents[1] / "examples" / "refuse-collector-6x2.yaml")
    asked = read_study(Path(__file__).parent / "gallery" / "tolerances.yaml", truck)
    ask = {name: getattr(asked.ask, name) for name in ("limits", "maps")}
    found = study(truck, asked.vary, tolerances=asked.tolerances, n=1024, rows=None, **ask)
    first, *_, gains, heat = figures(found)
    return "".join(
        f"<figure>{f.svg}<figcaption>{f.alt}</figcaption></figure>" for f in (gains, first, heat)
    )


def seeds() -> str:
    """Return what the first documents show, and what shows it here."""
    import yaml

    listed = yaml.safe_load(Path("docs/seeds.yaml").read_text(encoding="utf-8"))
    pages: list[str] = []
    for document, entries in listed.items():
        rows = ["| there | here | how |", "|---|---|---|"]
        for e in entries:
            run = e.get("run", "")
            if run and not run.startswith(("cardan ", "python ")):
                run = f'python -c "{run}"'.replace("\n", "\\n")
            how = f"`{run.replace('|', chr(92) + '|')}`" if run else "not reproduced"
            rows.append(f"| {_cell(e['item'])} | {_cell(e['shows'])} | {how} |")
        pages.append(f"## {document}\n\n" + "\n".join(rows))
    return "\n\n".join(pages)


def stability(modules: str) -> str:
    """Return what of a page's modules is public and stable, to stand before them."""
    import cardan

    listed = set(re.findall(r"^::: (\S+)", modules, re.MULTILINE))
    if "cardan.api" in listed:
        return ""
    public = [n for n in cardan.__all__ if getattr(getattr(cardan, n), "__module__", "") in listed]
    where = "[the public interface](public-interface.md)"
    if not public:
        return f"Nothing on this page is public: it may change with any version. Use {where}."
    names = ", ".join(f"`cardan.{name}`" for name in public)
    return f"Public and stable ({where}): {names}. All else here may change with any version."


def public_names() -> str:
    """Return the names that `import cardan` promises, with what each returns or does."""
    import inspect

    import cardan

    rows = ["| name | what it is |", "|---|---|"]
    for name in cardan.__all__:
        if name != "__version__":
            first = (inspect.getdoc(getattr(cardan, name)) or "").split("\n\n")[0]
            rows.append(f"| `cardan.{name}` | {_cell(first)} |")
    return "\n".join(rows)


def error_rates() -> str:
    """Return how often each finding on the joints was wrong, where the truth is known."""
    from cardan.physics.signals.attribution_result import VALIDATED_ERROR_RATES

    rows = ["| finding | drives | wrong, of gauges | at most |", "|---|---|---|---|"]
    for finding, rates in VALIDATED_ERROR_RATES.items():
        for drives, rate in zip(("as they come", "line on its stop"), rates, strict=True):
            rows.append(
                f"| {finding} | {drives} | {rate.wrong} of {rate.cases} "
                f"| {100 * rate.upper_bound:.1f} % |"
            )
    return "\n".join(rows)


def options(name: str) -> str:
    """Return the table of a command's options, in the order of its help."""
    import click

    from cardan.cli import cli
    from cardan.topics.recording.option_table import OPTIONS

    command = cli.get_command(click.Context(cli), name)
    assert command is not None, name
    declared = OPTIONS if name == "life" else {}
    rows = ["| option | default | what it is |", "|---|---|---|"]
    if declared:
        rows = ["| option | key in a campaign | default | what it is |", "|---|---|---|---|"]
    for option in command.params:
        if not isinstance(option, click.Option) or option.name == "help":
            continue
        value = "" if option.is_flag else option.metavar or _choices(option.type)
        cells = [_code(" ".join(filter(None, (max(option.opts, key=len), value))))]
        entry = declared.get(option.name or "")
        if declared:
            cells.append("<br>".join(_code(k) for k in _campaign_keys(entry)))
        shown = option.show_default is True and option.default not in (None, "", ())
        text = [option.help or "", _bounds(entry.bounds) if entry else ""]
        cells += [_code(option.default) if shown else "", _cell(" ".join(filter(None, text)))]
        rows.append(f"| {' | '.join(cells)} |")
    return "\n".join(rows)


def _choices(kind: Any) -> str:
    """Return the values that an option takes, or its kind in capitals."""
    return ",".join(kind.choices) if hasattr(kind, "choices") else kind.name.upper().split()[0]


def _campaign_keys(entry: Any) -> list[str]:
    """Return the keys of a campaign's file that hold an option."""
    if entry is None:
        return []
    places = {"campaign": "", "recording": "recordings: ", "strength": "strength: "}
    return [f"{places[k.table]}{k.name or entry.name}" for k in entry.keys]


def _bounds(bounds: Any) -> str:
    """Return the range of a number, as a sentence."""
    if bounds is None:
        return ""
    word, low = bounds.lower_bound
    high = f", at most {bounds.most:g}" if bounds.most < 1e9 else ""
    return f"Range: {word} {low:g}{high}."


def _code(text: object) -> str:
    """Return a text as inline code of a cell."""
    return f"`{text}`".replace("|", "\\|")


WRITERS = {
    "[[tolerance that decides]]": tolerance_that_decides,
    "[[seeds]]": seeds,
    "[[samples]]": samples,
    "[[bearing over speed]]": over_speed,
    "[[layers]]": layers,
    "[[error rates]]": error_rates, "[[public names]]": public_names,
    "[[reports]]": reports,
    "[[nomenclature]]": nomenclature, "[[changelog]]": changelog, "[[keys]]": keys,
    "[[contract]]": contract, "[[profiles]]": profiles, "[[published]]": published,
    "[[gallery]]": gallery, "[[relations]]": relations, "[[cycles]]": cycles,
    **{marker: partial(effects, marker) for marker in EFFECTS},
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
    names = dict.fromkeys(n for n in found if not n.endswith("_names"))
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

    from cardan.core.errors import MissingDependencyError

    tree, value = ast.parse(code), None
    last = tree.body.pop() if isinstance(tree.body[-1], ast.Expr) else None
    printed = io.StringIO()
    try:
        with redirect_stdout(printed):
            exec(compile(tree, "<page>", "exec"), space)
            if last is not None:
                value = eval(compile(ast.Expression(last.value), "<page>", "eval"), space)
    except MissingDependencyError as needed:
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


if __name__ == "__main__":
    import sys

    for name in sys.argv[1:]:
        _made(Path(name))
