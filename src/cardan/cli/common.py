"""What commands share: their options, how files are read, how far a run is, what is printed."""

import os
import sys
from collections.abc import Callable, Generator, Iterable, Mapping
from contextlib import contextmanager
from functools import wraps
from pathlib import Path
from time import monotonic
from typing import TYPE_CHECKING, Any, TypeAlias

import click

from cardan.cli.language import LanguageChoice, locale_language
from cardan.core.errors import DesignError
from cardan.core.status import ignore_status
from cardan.render.media import REPORT_MEDIA

if TYPE_CHECKING:
    from cardan.approval.study import Study

_TEMPLATES_FOLDER = Path(__file__).parents[1] / "application" / "starters"


CAMPAIGN_KIND = "campaign"
"""What starts a campaign of a recording."""


class TemplateChoice(click.Choice[str]):
    """The files there are to start from."""

    def __init__(self) -> None:
        starters = (p.stem for p in _TEMPLATES_FOLDER.glob("*.yaml"))
        super().__init__(tuple(sorted([*starters, CAMPAIGN_KIND])))


class ExampleChoice(click.Choice[str]):
    """The worked examples there are."""

    def __init__(self) -> None:
        from cardan.application.templates import example_names

        super().__init__(example_names())


OUTPUT_PATH = click.Path(path_type=Path)
FILE_ARGUMENT = click.argument("file", type=click.Path(dir_okay=False, path_type=Path))
LIMITS_OPTION = click.option(
    "--limits", metavar="PROFILE", help="Limit profile instead of the file's."
)
POSITIVE_FLOAT = click.FloatRange(min=0, min_open=True)
JSON_OPTION = click.option(
    "--json",
    "json_out",
    metavar="OUT",
    is_flag=False,
    flag_value="-",
    help="The JSON contract, into a file or (-, the default) on standard output.",
)
LANG_OPTION = click.option(
    "--lang",
    type=LanguageChoice(),
    default=locale_language,
    show_default="the locale's",
    help="Language of what is written.",
)
EXTRA_STUDY_OPTION = click.option(
    "--with",
    "also",
    multiple=True,
    type=click.Choice(["vibration", "bracket"]),
    help="Evaluate this study too, for the same verdict; may be repeated.",
)
QUIET_OPTION = click.option("--quiet", "-q", is_flag=True, help="No progress lines.")
ALLOW_FILES_OUTSIDE_FOLDER_OPTION = click.option(
    "--allow-outside",
    is_flag=True,
    help="Let the file name profiles and catalogues outside its own folder.",
)


def limits_and_language_options(command: Callable[..., Any]) -> Callable[..., Any]:
    """Add the options of every command that reads an application."""
    for option in (LANG_OPTION, ALLOW_FILES_OUTSIDE_FOLDER_OPTION, LIMITS_OPTION):
        command = option(command)
    return command


OutputPaths: TypeAlias = Mapping[str, str | Path | None]
"""What is to be written, by the option that says so."""

ReportPaths: TypeAlias = Mapping[str, Path]
"""Files of reports, by the name of their medium."""


# --------------------------------------------------------------------------- reading


def read_application(
    file: Path,
    limits: str | None,
    *,
    allow_outside: bool,
    outputs: OutputPaths,
    with_placeholders: bool = False,
) -> Any:
    """Return the application of a file, with what looks odd in it reported on the way.

    Refuse it where one of the claimed outputs is a file that it names, and one that still holds
    placeholders, except `with_placeholders`.
    """
    from cardan.application import reader
    from cardan.application.plausibility import with_limit_profile
    from cardan.model.application import require_no_placeholders
    from cardan.schema import atomic_write as writer

    application = reader.read(file, allow_outside=allow_outside)
    writer.check_output_paths(
        outputs, inputs=application.written.referenced_files if application.written else ()
    )
    if not with_placeholders:
        try:
            require_no_placeholders(application)
        except DesignError as error:
            msg = f"{file}: {error}"
            raise DesignError(msg) from None
    if limits:
        application = with_limit_profile(application, limits)
    echo_application_warnings(application, file)
    return application


def echo_application_warnings(application: Any, file: Path | None = None) -> None:
    """Print what looks wrong in an application to standard error, by its file's name."""
    name = str(file or (application.written.name if application.written else "application"))
    for warning in application.warnings:
        echo_to_stderr(_warning_text(warning, name))


def _warning_text(warning: Any, file: str) -> str:
    """Return what looks odd in a file, in the language of the command."""
    context = click.get_current_context(silent=True)
    lang = context.params.get("lang", "en") if context else "en"
    if lang == "en":
        return f"warning: {warning.format_with_location(file)}"
    from cardan.render.i18n import Translator
    from cardan.render.phrases import file_problem_line

    say = Translator(lang)
    return f"{say('warning')}: {file_problem_line(warning, file, say, is_warning=True)}"


def approve_file(
    file: Path,
    limits: str | None,
    *,
    allow_outside: bool,
    outputs: OutputPaths,
    also: "Iterable[str | Study[Any]]" = (),
    tell: "ProgressLine | None" = None,
) -> Any:
    """Return the approval of a file's application, `also` by other studies than its own."""
    from cardan.approval.approval import approve_application, default_studies
    from cardan.approval.registry import studies_of_application

    application = read_application(
        file, limits, allow_outside=allow_outside, outputs=outputs, with_placeholders=True
    )
    chosen = {s.name: s for s in default_studies(application)}
    for study in (studies_of_application()[s] if isinstance(s, str) else s for s in also):
        chosen.setdefault(study.name, study)
    with add_file_position_to_errors(file, application):
        return approve_application(
            application, tuple(chosen.values()), tell=tell.update_study if tell else ignore_status
        )


@contextmanager
def add_file_position_to_errors(file: Path, application: Any) -> Generator[None, None, None]:
    """Name the place in its file that an impossible part stands at."""
    from cardan.application import source_location

    try:
        yield
    except DesignError as error:
        raise DesignError(source_location.error_with_location(error, application, file)) from error


# --------------------------------------------------------------------------- reporting


PROGRESS_LINE_INTERVAL_S = 30.0
"""s between lines on how far a run is, where standard error is no terminal."""


class ProgressLine:
    """How far a run is: one line that is written over, with the time passed and, ~, of the whole.

    Where standard error is no terminal it is a line of its own, each half a minute.
    """

    def __init__(self, doing: str, *, quiet: bool) -> None:
        self.task, self.shown, self.quiet = doing, "", quiet
        self.visible = sys.stderr.isatty() and not quiet
        self.begun = self.printed = self.now

    def __call__(self, done: int, count: int) -> None:
        """Say how much is done, and of how much."""
        self._update("", done, count)

    def update_study(self, doing: str, done: int, count: int) -> None:
        """Say what a study is doing, and how much of it is done."""
        self._update(doing, done, count)

    def update(self, what: str) -> None:
        """Say where the run is, in words."""
        self._update(what, 0, 0)

    def _update(self, what: str, done: int, count: int) -> None:
        passed = self.now - self.begun
        parts = [what, f"{done}/{count}" if count else ""]
        self.shown = f"{self.task}: {' '.join(filter(None, parts))}"
        if passed >= 1:
            whole = f" / ~{_clock(passed * count / done)}" if 0 < done < count else ""
            self.shown += f", {_clock(passed)}{whole}"
        self.write(self.shown)

    def write(self, line: str) -> None:
        """Write the line over what stood there."""
        if self.visible:
            sys.stderr.write(f"\r\033[K{line}")
            sys.stderr.flush()
        elif line and not self.quiet and self.now - self.printed >= PROGRESS_LINE_INTERVAL_S:
            self.printed = self.now
            echo_to_stderr(line)

    @property
    def now(self) -> float:
        """Return the time, s."""
        return monotonic()


def _clock(seconds: float) -> str:
    minutes, rest = divmod(round(seconds), 60)
    return f"{minutes}:{rest:02d}"


@contextmanager
def progress_line(doing: str, *, quiet: bool = False) -> Generator[ProgressLine, None, None]:
    """Report how far a run is while it lasts; wipe the line after.

    One that is stopped from the keyboard leaves the line, for it says how far it came.
    """
    line = ProgressLine(doing, quiet=quiet)
    line.write(doing)
    try:
        yield line
    except KeyboardInterrupt:
        line.write("")
        if line.shown and not quiet:
            echo_to_stderr(line.shown)
        raise
    finally:
        line.write("")


# --------------------------------------------------------------------------- printing


def terminal_width() -> int:
    """Return how many columns what is printed may take: the terminal's, or what COLUMNS says."""
    from cardan.render.text_layout import DEFAULT_WIDTH_COLUMNS

    # As `shutil` does it, whose import costs a check its hundredth part.
    said = os.environ.get("COLUMNS", "")
    try:
        wide = int(said) if said.isdecimal() else 0
        wide = wide or os.get_terminal_size().columns
    except OSError:  # no terminal
        wide = 0
    return max(wide or DEFAULT_WIDTH_COLUMNS, 60)


def echo(text: str, *, nl: bool = True) -> None:
    """Print an answer on standard output, in colours where a terminal shows them.

    NO_COLOR and a dumb terminal take them away, FORCE_COLOR brings them into a pipe.
    """
    plain = os.environ.get("NO_COLOR") or os.environ.get("TERM") == "dumb"
    coloured = False if plain else True if os.environ.get("FORCE_COLOR") else None
    click.echo(text, nl=nl, file=sys.stdout, color=coloured)


def echo_lines(lines: Iterable[str]) -> None:
    """Print lines of an answer on standard output."""
    echo("\n".join(lines))


def echo_json(document: Any, *, indent: int) -> None:
    """Print a document on standard output, for programs: no letter of it is lost there."""
    knows_all = "utf" in str(getattr(sys.stdout, "encoding", "utf-8")).lower()
    echo(_json(document, indent=indent, ensure_ascii=not knows_all))


def _json(document: Any, *, indent: int, ensure_ascii: bool) -> str:
    from json import dumps

    return dumps(document, indent=indent, ensure_ascii=ensure_ascii, allow_nan=False)


def echo_to_stderr(text: str) -> None:
    """Print a word in addition to the result, on standard error."""
    click.echo(text, file=sys.stderr)


def validate_output_paths(*inputs: str | Path | None, **outputs: str | Path | None) -> OutputPaths:
    """Return outputs by their options; refuse those that cannot be written or must not.

    Inputs that are no files, like the name of a profile of the package, are left out.
    """
    claimed = {
        f"--{option.removesuffix('_out').replace('_', ' ')}": name
        for option, name in outputs.items()
        if name is not None and not (option == "json_out" and name == "-")
    }
    if claimed:
        from cardan.schema import atomic_write as writer

        writer.check_output_paths(claimed, inputs=[Path(i) for i in inputs if i is not None])
    return claimed


def write_output(
    path: Path, content: str | bytes | Iterable[bytes], *, replace: bool = True
) -> None:
    """Write an output into its file, over what stands there."""
    from cardan.schema import atomic_write as writer

    writer.write_atomically(path, content, replace=replace)


def write_json(document: Any, out: str) -> None:
    """Write a document to a file, or to standard output for `-`."""
    if out == "-":
        echo_json(document, indent=1)
    else:
        write_output(Path(out), _json(document, indent=1, ensure_ascii=False) + "\n")


def report_options(command: Callable[..., None]) -> Callable[..., None]:
    """Add an option for each medium of reports; the command gets them as `reports`."""

    @wraps(command)
    def with_reports(**options: Any) -> None:
        paths = {medium.name: options.pop(medium.name) for medium in REPORT_MEDIA}
        command(reports={name: path for name, path in paths.items() if path}, **options)

    for medium in reversed(REPORT_MEDIA):
        option = click.option(f"--{medium.name}", metavar="OUT", type=OUTPUT_PATH, help=medium.help)
        option(with_reports)
    return with_reports


def write_report(told: Any, reports: ReportPaths, *, say: Any, quiet: bool) -> None:
    """Write a report in the media that have a path."""
    for medium in REPORT_MEDIA:
        if path := reports.get(medium.name):
            with progress_line(say("writing {file}", file=path), quiet=quiet):
                content = medium.write(told)
            write_and_announce(path, content, say)


def announce_application(file: Path, say: Any) -> None:
    """Print that an application is written, and what assesses it."""
    echo(say("{file} is written; `cardan check {file}` assesses it.", file=file))


def write_and_announce(path: Path, content: str | bytes, say: Any) -> None:
    """Write a report, and say so where it is not in the way of what is printed."""
    write_output(path, content)
    echo_to_stderr(say("{file} is written.", file=path))
