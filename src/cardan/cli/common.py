"""What commands share: their options, how files are read, how far a run is, what is printed."""

import os
import sys
from collections.abc import Generator, Iterable, Mapping
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeAlias

import click

from cardan.base.errors import DesignError

if TYPE_CHECKING:
    from cardan.study.finding import Study

_TEXTS = Path(__file__).parents[1] / "report" / "text"
_STARTERS = Path(__file__).parents[1] / "files" / "starters"


class Languages(click.Choice[str]):
    """The languages there is a catalogue for."""

    def __init__(self) -> None:
        super().__init__(("en", *sorted(p.stem for p in _TEXTS.glob("*.po"))))


class Kinds(click.Choice[str]):
    """The files there are to start from."""

    def __init__(self) -> None:
        super().__init__(tuple(sorted(p.stem for p in _STARTERS.glob("*.yaml"))))


OUT = click.Path(path_type=Path)
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
    type=Languages(),
    default="en",
    show_default=True,
    help="Language of what is written.",
)
ALSO = click.option(
    "--with",
    "also",
    multiple=True,
    type=click.Choice(["vibration", "bracket"]),
    help="Ask this study too, for the same verdict; may be repeated.",
)
UNTOLD = click.option("--quiet", "-q", is_flag=True, help="No word on how far it has come.")
OUTSIDE = click.option(
    "--allow-outside",
    is_flag=True,
    help="Let the file name profiles and catalogues outside its own folder.",
)


Outputs: TypeAlias = Mapping[str, str | Path | None]
"""What is to be written, by the option that says so."""


# --------------------------------------------------------------------------- reading


def read(file: Path, limits: str | None, *, allow_outside: bool, outputs: Outputs) -> Any:
    """Return the application of a file, with what looks odd in it told on the way.

    Refuse it where one of the claimed outputs is a file that it names.
    """
    from cardan import files
    from cardan.border import writer

    application = files.read(file, allow_outside=allow_outside)
    writer.claim(outputs, inputs=application.written.beside if application.written else ())
    if limits:
        name, found = files.limits(limits)
        application = replace(application, profile=name, limits=found)
    for warning in application.warnings:
        note(_doubt(warning, str(file)))
    return application


def _doubt(warning: Any, file: str) -> str:
    """Return what looks odd in a file, in the language that the command is asked for."""
    context = click.get_current_context(silent=True)
    lang = context.params.get("lang", "en") if context else "en"
    if lang == "en":
        return f"warning: {warning.located(file)}"
    from cardan.report.language import Language
    from cardan.report.wording import located

    say = Language(lang)
    return f"{say('warning')}: {located(warning, file, say)}"


def approved(
    file: Path,
    limits: str | None,
    *,
    allow_outside: bool,
    outputs: Outputs,
    also: "Iterable[str | Study[Any]]" = (),
    tell: "Progress | None" = None,
) -> Any:
    """Return the approval of a file's application, `also` by other studies than it asks for."""
    from cardan.study.approval import approve, default_studies
    from cardan.study.studies import STUDIES

    application = read(file, limits, allow_outside=allow_outside, outputs=outputs)
    chosen = {s.name: s for s in default_studies(application)}
    for study in (STUDIES[s] if isinstance(s, str) else s for s in also):
        chosen.setdefault(study.name, study)
    with of(file, application):
        return approve(application, tuple(chosen.values()), tell=tell.study if tell else silent)


def silent(doing: str, done: int, count: int) -> None:
    """Tell nobody."""


@contextmanager
def of(file: Path, application: Any) -> Generator[None, None, None]:
    """Name the place in its file that an impossible part stands at."""
    from cardan import files

    try:
        yield
    except DesignError as error:
        raise DesignError(files.located(error, application, file)) from error


# --------------------------------------------------------------------------- telling


class Progress:
    """One line on standard error that says how far a run is, where somebody looks."""

    def __init__(self, doing: str, *, quiet: bool) -> None:
        self.doing, self.seen = doing, sys.stderr.isatty() and not quiet

    def __call__(self, done: int, count: int) -> None:
        """Say how much is done, and of how much."""
        self.at(f"{done}/{count}")

    def study(self, doing: str, done: int, count: int) -> None:
        """Say what a study is doing, and how much of it is done."""
        self.at(f"{doing} {done}/{count}" if count else doing)

    def at(self, what: str) -> None:
        """Say where the run is, in words."""
        self.write(f"{self.doing}: {what}")

    def write(self, line: str) -> None:
        """Write the line over what stood there."""
        if self.seen:
            sys.stderr.write(f"\r\033[K{line}")
            sys.stderr.flush()


@contextmanager
def progress(doing: str, *, quiet: bool = False) -> Generator[Progress, None, None]:
    """Tell how far a run is while it lasts; wipe the line after."""
    line = Progress(doing, quiet=quiet)
    line.write(doing)
    try:
        yield line
    finally:
        line.write("")


# --------------------------------------------------------------------------- printing


def screen() -> int:
    """Return how many columns what is printed may take: the terminal's, or what COLUMNS says."""
    from cardan.report.screen import WIDTH

    # As `shutil` does it, whose import costs a check its hundredth part.
    said = os.environ.get("COLUMNS", "")
    try:
        wide = int(said) if said.isdecimal() else 0
        wide = wide or os.get_terminal_size().columns
    except OSError:  # no terminal
        wide = 0
    return max(wide or WIDTH, 60)


def put(text: str, *, nl: bool = True) -> None:
    """Print an answer on standard output, in colours where a terminal shows them.

    NO_COLOR and a dumb terminal take them away, FORCE_COLOR brings them into a pipe.
    """
    plain = os.environ.get("NO_COLOR") or os.environ.get("TERM") == "dumb"
    coloured = False if plain else True if os.environ.get("FORCE_COLOR") else None
    click.echo(text, nl=nl, file=sys.stdout, color=coloured)


def put_lines(lines: Iterable[str]) -> None:
    """Print lines of an answer on standard output."""
    put("\n".join(lines))


def put_json(document: Any, *, indent: int) -> None:
    """Print a document on standard output, for programs: no letter of it is lost there."""
    knows_all = "utf" in str(getattr(sys.stdout, "encoding", "utf-8")).lower()
    put(_json(document, indent=indent, ensure_ascii=not knows_all))


def _json(document: Any, *, indent: int, ensure_ascii: bool) -> str:
    from json import dumps

    return dumps(document, indent=indent, ensure_ascii=ensure_ascii, allow_nan=False)


def note(text: str) -> None:
    """Print a word beside the answer, on standard error."""
    click.echo(text, file=sys.stderr)


def claim(*inputs: str | Path | None, **outputs: str | Path | None) -> Outputs:
    """Return outputs by their options; refuse those that cannot be written or must not.

    Inputs that are no files, like the name of a profile of the package, are nobody's.
    """
    claimed = {
        f"--{option.removesuffix('_out').replace('_', ' ')}": name
        for option, name in outputs.items()
        if name is not None and not (option == "json_out" and name == "-")
    }
    if claimed:
        from cardan.border import writer

        writer.claim(claimed, inputs=[Path(i) for i in inputs if i is not None])
    return claimed


def write(path: Path, content: str | bytes, *, replace: bool = True) -> None:
    """Write an output into its file, over what stands there."""
    from cardan.border import writer

    writer.write(path, content, replace=replace)


def write_json(document: Any, out: str) -> None:
    """Write a document to a file, or to standard output for `-`."""
    if out == "-":
        put_json(document, indent=1)
    else:
        write(Path(out), _json(document, indent=1, ensure_ascii=False) + "\n")


def publish(told: Any, *, say: Any, html: Path | None, pdf: Path | None, quiet: bool) -> None:
    """Write a story as a page, as a document."""
    if html:
        from cardan.report.html import page

        with progress(say("writing {file}", file=html), quiet=quiet):
            content = page(told)
        written(html, content, say)
    if pdf:
        from cardan.report.pdf import document

        with progress(say("writing {file}", file=pdf), quiet=quiet):
            printed = document(told)
        written(pdf, printed, say)


def written(path: Path, content: str | bytes, say: Any) -> None:
    """Write a report, and say so where it is not in the way of what is printed."""
    write(path, content)
    note(say("{file} is written.", file=path))
