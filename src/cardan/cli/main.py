"""The command line: read, ask, print."""

import json
import os
import sys
from collections.abc import Callable, Generator, Iterable
from contextlib import contextmanager
from dataclasses import replace
from functools import wraps
from io import BytesIO
from pathlib import Path
from typing import Any, NoReturn, TypeVar

import click

from cardan import __version__
from cardan.base.errors import CardanError, DesignError

# Matrices here are small and many: BLAS's own threads cost more than they bring. Before NumPy.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

Command = TypeVar("Command", bound=Callable[..., Any])
OUT = click.Path(dir_okay=False, path_type=Path)
FILE = click.argument("file", type=click.Path(dir_okay=False, path_type=Path))
LIMITS = click.option("--limits", metavar="PROFILE", help="Limit profile instead of the file's.")
POSITIVE = click.FloatRange(min=0, min_open=True)
JSON = click.option(
    "--json",
    "json_out",
    metavar="OUT",
    is_flag=False,
    flag_value="-",
    help="The JSON contract, into a file or (-, the default) on standard output.",
)
LANG = click.option(
    "--lang",
    type=click.Choice(["en", "pt", "it"]),
    default="en",
    show_default=True,
    help="Language of what is written.",
)


Tell = Callable[[int, int], None]
"""Takes how much of a run is done, and of how much."""
UNTOLD = click.option("--quiet", "-q", is_flag=True, help="No word on how far it has come.")


@contextmanager
def progress(doing: str, *, quiet: bool = False) -> Generator[Tell, None, None]:
    """Tell on one line of standard error how far a run is, where somebody looks; wipe it after."""
    looked_at = sys.stderr.isatty() and not quiet

    def write(line: str) -> None:
        if looked_at:
            sys.stderr.write(f"\r\033[K{line}")
            sys.stderr.flush()

    write(doing)
    try:
        yield lambda done, count: write(f"{doing}: {done}/{count}")
    finally:
        write("")


@contextmanager
def of(file: Path, application: Any) -> Generator[None, None, None]:
    """Name the place in its file that an impossible part stands at."""
    from cardan import files

    try:
        yield
    except DesignError as error:
        raise DesignError(files.located(error, application, file)) from error


def kindly(command: Command) -> Command:
    """Return a command that turns what it refuses into a message and exit code 2."""

    @wraps(command)
    def guarded(*args: Any, **kwargs: Any) -> Any:
        try:
            return command(*args, **kwargs)
        except (CardanError, OSError) as error:
            _refuse(str(error))

    return guarded  # type: ignore[return-value]


class Commands(click.Group):
    """Commands, of which those of other rooms are imported where they are called."""

    def list_commands(self, ctx: click.Context) -> list[str]:
        """Return the names of all commands."""
        return sorted([*super().list_commands(ctx), "life"])

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:
        """Return a command by its name."""
        if cmd_name == "life":
            from cardan.cli.life import life

            return life
        return super().get_command(ctx, cmd_name)


@click.group(cls=Commands, context_settings={"help_option_names": ["-h", "--help"]})
@click.version_option(__version__, "-V", "--version", prog_name="cardan")
def cli() -> None:
    """Cardan drivelines, from hardpoints to verdict."""


@cli.command()
@click.argument(
    "files",
    nargs=-1,
    required=True,
    metavar="FILE...",
    type=click.Path(dir_okay=False, path_type=Path),
)
@JSON
@click.option("--html", metavar="OUT", type=OUT, help="A page that needs nothing else.")
@click.option("--pdf", metavar="OUT", type=OUT, help="A document to sign.")
@click.option("--xlsx", metavar="OUT", type=OUT, help="A workbook with live formulas.")
@click.option(
    "--bracket", is_flag=True, help="A chapter on the bracket in page and document; takes a while."
)
@LIMITS
@LANG
@click.option("--all", "every", is_flag=True, help="A row for each check, not for each limit.")
@click.option("--quiet", "-q", is_flag=True, help="The verdict alone.")
@kindly
def check(
    files: tuple[Path, ...],
    *,
    json_out: str | None,
    html: Path | None,
    pdf: Path | None,
    xlsx: Path | None,
    bracket: bool,
    limits: str | None,
    lang: str,
    every: bool,
    quiet: bool,
) -> None:
    """Hold an application against every limit, in every state; several files side by side.

    Exit code 0 where everything passes or warns, 1 where something fails, 2 for a bad file.
    """
    from cardan.report import terminal
    from cardan.report.compare import Variant
    from cardan.report.language import Language
    from cardan.study.sensitivity import sensitivities

    say = Language(lang)
    found = [_assessed(file, limits) for file in files]
    variants = [Variant(name=f.stem, assessment=a) for f, a in zip(files, found, strict=True)]
    if xlsx and len(found) > 1:
        raise CardanError(say("a workbook holds one application: give one file with --xlsx"))
    if bracket and (len(found) > 1 or not (html or pdf)):
        raise CardanError(say("--bracket needs one file, and --html or --pdf to write to"))
    if json_out:
        from cardan.report import contract

        documents = [contract.assessment(a) for a in found]
        _write_json(
            documents[0] if len(found) == 1 else {"variants": documents},
            json_out,
        )
    if html or pdf:
        _report(files, variants, say=say, html=html, pdf=pdf, bracket=bracket, quiet=quiet)
    if xlsx:
        from cardan.report import workbook

        _write(xlsx, workbook.workbook(found[0], say=say), say)
    if quiet:
        for one in found:
            _print(terminal.summary(one, say))
    elif json_out != "-":
        if len(found) > 1:
            _print(terminal.comparison(variants, say))
        else:
            helps = sensitivities(found[0])
            _print(terminal.assessment(found[0], helps=helps, every=every, say=say))
    raise SystemExit(1 if any(a.verdict == "fail" for a in found) else 0)


@cli.command()
@FILE
@JSON
@LIMITS
@LANG
@click.option("--line", help="Which line; by default the one with the worst check.")
@click.option("--hold", multiple=True, metavar="WHAT", help="Leave in place, as in the file.")
@click.option(
    "--count", type=click.IntRange(1), default=5, show_default=True, help="Proposals at most."
)
@UNTOLD
@kindly
def fix(
    file: Path,
    *,
    json_out: str | None,
    limits: str | None,
    lang: str,
    line: str | None,
    hold: tuple[str, ...],
    count: int,
    quiet: bool,
) -> None:
    """Propose what to change, over all states at once.

    Moves centre bearings, the axle's shim and yoke phases within what the file's `adjust`
    allows; --hold bearing_height, or --hold "phase 2", leaves that where it is. Exit code
    0 where a proposal stops every failure, else 1.
    """
    from cardan.report import terminal
    from cardan.report.language import Language
    from cardan.study.fix import fix as search

    say = Language(lang)
    application = _read(file, limits)
    with of(file, application), progress(say("looking for corrections"), quiet=quiet) as tell:
        found = search(application, line=line, hold=hold, count=count, tell=tell)
    if json_out:
        from cardan.report import contract

        _write_json(contract.proposals(found), json_out)
    if json_out != "-":
        _print(terminal.proposals(found, say))
    raise SystemExit(0 if any(p.verdict != "fail" for p in found) else 1)


@cli.command()
@FILE
@JSON
@click.option("--chart", type=click.Path(dir_okay=False, path_type=Path), help="SVG, into a file.")
@click.option("--line", help="Which line the chart shows; by default the first.")
@click.option("--all", "every", is_flag=True, help="A row for each check, not for each part.")
@click.option("--axle-inertia", type=POSITIVE, help="Behind the pinion, kg m²; assumed 2.")
@click.option("--axle-stiffness", type=POSITIVE, help="Pinion to there, N m/rad; assumed rigid.")
@click.option("--gearbox-inertia", type=POSITIVE, help="Of the gearbox flange, kg m².")
@click.option("--gearbox-stiffness", type=POSITIVE, help="Engine to there, N m/rad.")
@click.option("--damping-ratio", type=POSITIVE, help="Of the first mode; assumed 0.02.")
@UNTOLD
@kindly
def stability(
    file: Path,
    *,
    json_out: str | None,
    chart: Path | None,
    line: str | None,
    every: bool,
    quiet: bool,
    **surroundings: float | None,
) -> None:
    """Hold each gear's speeds against torsional resonances, parametric zones and flutter.

    What turns at both ends is the file's `torsion`; options go before it, and what nobody
    gives is assumed: without the gearbox's values its flange turns uniformly. Exit code 0
    where everything passes or warns, 1 where something grows, 2 for a bad file.
    """
    from cardan.model.application import Surroundings
    from cardan.report import stability as report
    from cardan.study.stability import stability as ask

    given = {name: value for name, value in surroundings.items() if value is not None}
    application = _read(file, None)
    with of(file, application), progress("asking what vibrates", quiet=quiet) as tell:
        found = ask(application, surroundings=Surroundings(**given), tell=tell)
    if chart:
        from cardan import files

        shown = {v.line.name: v for v in found.lines}
        if line is not None and line not in shown:
            _refuse(f"there is no line {line}; the file has {', '.join(shown)}")
        files.write(chart, report.chart(shown[line] if line else found.lines[0]), replace=True)
    if json_out:
        _write_json(report.document(found), json_out)
    if json_out != "-":
        _print(report.text(found, every=every))
    raise SystemExit(1 if found.verdict == "fail" else 0)


@cli.command()
@FILE
@JSON
@click.option("--vtu", type=OUT, help="Mesh and fields, for ParaView.")
@click.option("--png", type=OUT, help="A picture of the worst case.")
@click.option("--html", type=OUT, help="A page to turn it about in.")
@UNTOLD
@kindly
def bracket(
    file: Path,
    *,
    json_out: str | None,
    vtu: Path | None,
    png: Path | None,
    html: Path | None,
    quiet: bool,
) -> None:
    """Stresses, hot spots, virtual gauges and modes of FILE's bracket.

    Under the driveline's own loads in every state and those given by hand; a reinforced
    variant stands beside the original. Needs the extra cardan[bracket].
    """
    from cardan import files
    from cardan.report import bracket as shown
    from cardan.study.bracket import study

    found = study(_assessed(file, None), tell=_teller(quiet=quiet))
    if json_out:
        _write_json(shown.contract(found), json_out)
    if vtu:
        for variant in found.variants:
            first = variant is found.variants[0]
            name = vtu if first else vtu.with_stem(f"{vtu.stem}-{variant.name}")
            files.write(name, shown.vtu(variant), replace=True)
    if png:
        drawn = BytesIO()
        shown.picture(found, drawn)
        files.write(png, drawn.getvalue(), replace=True)
    if html:
        from cardan.report import bracket_scene

        files.write(html, bracket_scene.page(found), replace=True)
    if json_out != "-":
        _print(shown.terminal(found))


@cli.command()
@click.argument("quantity", required=False)
@LANG
@kindly
def explain(quantity: str | None, *, lang: str) -> None:
    """Say what QUANTITY is: equation, symbols, source, limits of use.

    By its key or its name; without one, list them all.
    """
    from cardan.quantity.quantities import QUANTITIES
    from cardan.report import terminal
    from cardan.report.language import Language

    if quantity is None:
        _print(f"{key:<28} {q.named(lang)}" for key, q in QUANTITIES.items())
        return
    word = quantity.casefold()
    meant = [q for q in QUANTITIES.values() if word in _names(q)]
    if not meant:
        from difflib import get_close_matches

        near = [q.key for q in QUANTITIES.values() if any(word in n for n in _names(q))]
        near = near[:3] or get_close_matches(word, QUANTITIES)
        hint = f"; did you mean {' or '.join(near)}?" if near else ""
        _refuse(f"there is no quantity {quantity}{hint} (`cardan explain` lists them all)")
    for q in meant:
        _print(terminal.explanation(q, Language(lang)))


@cli.command()
@JSON
@kindly
def verify(*, json_out: str | None) -> None:
    """Recompute published cases on this machine and show both numbers.

    Exit code 1 where one does not agree to its printed digits.
    """
    from cardan.report import terminal
    from cardan.study.published import published

    cases = published()
    if json_out:
        from cardan.report import contract

        _write_json(contract.published(cases), json_out)
    if json_out != "-":
        _print(terminal.published(cases))
    raise SystemExit(0 if all(c.agrees for c in cases) else 1)


@cli.command()
@click.option("--out", type=click.Path(dir_okay=False, path_type=Path), help="Into a file.")
@click.option("--force", is_flag=True, help="Replace the file.")
@kindly
def schema(*, out: Path | None, force: bool) -> None:
    """Print the JSON Schema of the application file, for editors."""
    from cardan import files

    text = json.dumps(files.schema(), indent=2, ensure_ascii=False) + "\n"
    if out:
        files.write(out, text, replace=force)
    else:
        click.echo(text, nl=False)


@cli.command()
@FILE
@click.option("--kind", type=click.Choice(["small", "truck"]), default="truck", show_default=True)
@click.option("--force", is_flag=True, help="Replace the file.")
@kindly
def new(file: Path, *, kind: str, force: bool) -> None:
    """Write a commented FILE to start from.

    A small one holds what a protractor measures under the truck; the other kind a whole truck.
    """
    from cardan import files

    files.write(file, files.starter(kind), replace=force)
    click.echo(f"{file} is written; `cardan check {file}` assesses it.")


def _names(quantity: Any) -> tuple[str, ...]:
    """Return what a quantity may be called, in small letters: its key, its name in any language."""
    named = quantity.name, quantity.pt, quantity.it
    return quantity.key, *(name.casefold() for name in named)


def _read(file: Path, limits: str | None) -> Any:
    """Return the application of a file, with what looks odd in it told on the way."""
    from cardan import files

    application = files.read(file)
    if limits:
        name, found = files.limits(limits)
        application = replace(application, profile=name, limits=found)
    for warning in application.warnings:
        click.echo(f"warning: {warning.located(str(file))}", err=True)
    return application


def _assessed(file: Path, limits: str | None) -> Any:
    """Return the assessment of a file's application."""
    from cardan.study.assess import assess

    application = _read(file, limits)
    with of(file, application):
        return assess(application)


def _report(
    paths: tuple[Path, ...],
    variants: list[Any],
    *,
    say: Any,
    html: Path | None,
    pdf: Path | None,
    bracket: bool,
    quiet: bool,
) -> None:
    """Tell the story of one application, or of variants, on a page or in a document."""
    from datetime import date
    from hashlib import sha256

    from cardan.report import story
    from cardan.study.fix import fix as search
    from cardan.study.sensitivity import sensitivities
    from cardan.study.stability import stability

    contents = [p.read_bytes() for p in paths]
    issue = story.Issue(
        date=date.today().isoformat(),
        files=tuple(p.name for p in paths),
        prints=tuple(sha256(c).hexdigest()[:16] for c in contents),
        texts=tuple(c.decode("utf-8-sig") for c in contents),
    )
    if len(variants) > 1:
        told = story.comparison(variants, say=say, issue=issue)
    else:
        one = variants[0].assessment
        helps = sensitivities(one)
        with progress(say("looking for corrections"), quiet=quiet) as tell:
            fixes = search(one.application, count=3, tell=tell) if helps else ()
        try:
            vibration = stability(one.application)
        except DesignError:  # a line without tubes, or without a speed: the story says so
            vibration = None
        more: list[Any] = []
        if bracket:
            from cardan.report.bracket_chapter import chapter
            from cardan.study.bracket import study

            more = [chapter(study(one, tell=_teller(quiet=quiet)), say=say)]
        told = story.assessment(
            one, helps=helps, fixes=fixes, say=say, issue=issue, vibration=vibration, more=more
        )
    if html:
        from cardan.report.html import page

        with progress(say("writing {file}", file=html), quiet=quiet):
            content = page(told)
        _write(html, content, say)
    if pdf:
        from cardan.report.pdf import document

        with progress(say("writing {file}", file=pdf), quiet=quiet):
            printed = document(told)
        _write(pdf, printed, say)


def _teller(*, quiet: bool) -> Callable[[str], None]:
    """Return what tells how far something has come, unless that is not wanted."""

    def tell(what: str) -> None:
        if not quiet:
            click.echo(what, err=True)

    return tell


def _write(path: Path, content: str | bytes, say: Any) -> None:
    """Write a report, and say so where it is not in the way of what is printed."""
    from cardan import files

    files.write(path, content, replace=True)
    click.echo(say("{file} is written.", file=path), err=True)


def _write_json(document: Any, out: str) -> None:
    """Write a document to a file, or to standard output for `-`."""
    text = json.dumps(document, indent=1, ensure_ascii=False, allow_nan=False) + "\n"
    if out == "-":
        click.echo(text, nl=False)
    else:
        from cardan import files

        files.write(Path(out), text, replace=True)


def _print(lines: Iterable[str]) -> None:
    click.echo("\n".join(lines))


def _refuse(message: str) -> NoReturn:
    """Print why nothing was done, a line for each reason, and leave with exit code 2."""
    for line in message.splitlines():
        click.echo(f"error: {line}", err=True)
    raise SystemExit(2)
