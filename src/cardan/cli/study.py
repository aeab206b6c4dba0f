"""`cardan study`: what many variants come to, from a laptop to a cluster."""

import os
import sys
from dataclasses import replace
from pathlib import Path
from time import perf_counter
from typing import Any

import click

from cardan.cli.common import (
    FILE_ARGUMENT,
    JSON_OPTION,
    QUIET_OPTION,
    ReportPaths,
    add_file_position_to_errors,
    echo_lines,
    echo_to_stderr,
    limits_and_language_options,
    progress_line,
    read_application,
    report_options,
    terminal_width,
    validate_output_paths,
    write_json,
    write_report,
)
from cardan.cli.exit_codes import (
    EXIT_INTERRUPTED,
    NoRepeatedOptionCommand,
    exit_with_code_2_on_known_errors,
)
from cardan.core.errors import DesignError, FileIssue, InvalidFileError


@click.command(cls=NoRepeatedOptionCommand)
@FILE_ARGUMENT
@click.option(
    "--study",
    "beside",
    type=click.Path(dir_okay=False, path_type=Path),
    help="A file with the study, in place of the application's own.",
)
@click.option(
    "--n", "count", type=click.IntRange(1), default=10_000, show_default=True, help="Variants."
)
@click.option("--seed", type=click.IntRange(0), default=0, show_default=True)
@click.option(
    "--out",
    "folder",
    metavar="FOLDER",
    type=click.Path(file_okay=False, path_type=Path),
    help="Keep what is done here, shard by shard; also each variant, where `ask` has rows.",
)
@click.option("--resume", is_flag=True, help="Go on with what the folder holds.")
@click.option(
    "--executor",
    metavar="threads|processes|ADDRESS",
    default="threads",
    show_default=True,
    help="What computes: threads or processes here, or a Dask cluster by its address, "
    "tcp://host:8786.",
)
@click.option(
    "--workers",
    type=click.IntRange(1),
    default=None,
    help="At a time; by default one a core, here or of the cluster.",
)
@click.option("--all", "every", is_flag=True, help="Print every table and remark.")
@JSON_OPTION
@report_options
@limits_and_language_options
@QUIET_OPTION
@exit_with_code_2_on_known_errors
def study(
    file: Path,
    *,
    beside: Path | None,
    count: int,
    seed: int,
    folder: Path | None,
    resume: bool,
    executor: str,
    workers: int | None,
    every: bool,
    json_out: str | None,
    reports: ReportPaths,
    limits: str | None,
    allow_outside: bool,
    lang: str,
    quiet: bool,
) -> None:
    """Evaluate every limit of many variants of an application, and the share that passes.

    The file's `study`, or a file of --study, says what varies, what scatters and what is
    evaluated. Stopped from the keyboard it reports what is done; with --out that is kept, and
    --resume goes on to the same result, to the last bit. Prints one screen; --all prints the rest.

    Exit code 0 if the study was computed to its end, whatever its result, 130 if it was
    stopped.
    """
    from cardan.render.i18n import Translator
    from cardan.topics.variants import presentation
    from cardan.topics.variants.executors import SCHEDULER_TIMEOUT_S, open_executor
    from cardan.topics.variants.presentation_json import json_document
    from cardan.topics.variants.presentation_report import report
    from cardan.topics.variants.runner import run_study as run
    from cardan.topics.variants.screen_presentation import screen_lines
    from cardan.topics.variants.study_result import StudyInterrupted

    say = Translator(lang)
    if resume and folder is None:
        msg = "--resume goes on with a folder: name it with --out"
        raise DesignError(msg)
    if executor not in ("threads", "processes") and ":" not in executor:
        msg = (
            f"--executor must be threads, processes or the address of a Dask cluster, as "
            f"tcp://host:8786 (got {executor})"
        )
        raise DesignError(msg)
    outputs = validate_output_paths(file, beside, limits, json_out=json_out, **reports)
    application = read_application(file, limits, allow_outside=allow_outside, outputs=outputs)
    variants = application.variants
    before = {file: application.written.text}
    stamp = _report_stamp(file) if reports else None
    if beside is not None:
        from cardan.schema.yaml_tree import read_text
        from cardan.topics.variants.schema import read_variant_study as read_study

        before[beside] = read_text(beside)
        variants = read_study(beside, application)
    if variants is None:
        msg = f"{file} has no study: say what varies in it, or in a file of --study"
        raise DesignError(msg)
    stopped = False
    here = workers or os.cpu_count() or 1
    number = here if executor in ("threads", "processes") else workers  # a cluster's own number
    last, idle, noted = 0.0, False, False
    with progress_line(say("calculating"), quiet=quiet) as line:

        def hear(told: Any) -> None:
            nonlocal last, idle, noted
            if told.damaged and not noted:
                noted = True
                line.write("")
                echo_to_stderr(presentation.damaged_shards_text(told.damaged, folder, say))
            if told.idle and not (idle or line.visible or quiet):
                echo_to_stderr(presentation.progress_text(told, say))
            idle = told.idle
            if perf_counter() - last > 0.2 or told.done == told.count:
                last = perf_counter()
                line.update(presentation.progress_text(told, say))

        if executor not in ("threads", "processes") and not quiet:
            wait = "waiting at most {count} s for the Dask scheduler at {address}"
            line.write("")
            echo_to_stderr(say(wait, count=SCHEDULER_TIMEOUT_S, address=executor))
        try:
            with (
                open_executor(executor, here) as pool,
                add_file_position_to_errors(file, application),
            ):
                found = run(
                    application, variants, count=count, seed=seed, folder=folder, resume=resume,
                    executor=pool, workers=number, hear=hear,
                )  # fmt: skip
        except StudyInterrupted as error:
            stopped, found = True, error.result
        except ValueError as error:  # a name, a range, a correlation
            at = variants.places.get(str(error).partition(":")[0], (0, 0))
            problem = FileIssue(message=str(error), line=at[0], column=at[1])
            raise InvalidFileError(str(beside or file), (problem,)) from error
    found = replace(found, changed_files=_changed_files(before))
    if json_out is not None:
        write_json(json_document(found), json_out)
    if stamp is not None:
        told = report(found, say=say, issue=stamp)
        write_report(told, reports, say=say, quiet=quiet)
    if json_out != "-":
        if every:
            echo_lines(presentation.terminal_lines(found, say))
        else:
            echo_lines(screen_lines(found, say, width=terminal_width()))
    if folder is not None:
        echo_to_stderr(say("{file} is written.", file=folder))
    if stopped:
        if folder is not None:
            echo_to_stderr(say("stopped; the same command with --resume goes on"))
        sys.exit(EXIT_INTERRUPTED)


def _changed_files(before: dict[Path, str]) -> Any:
    """Return the files whose text is another than the one that was read."""
    from hashlib import sha256

    from cardan.schema.yaml_tree import read_text
    from cardan.topics.variants.study_result import ChangedFile

    def digest(text: str) -> str:
        return sha256(text.encode()).hexdigest()

    found: list[ChangedFile] = []
    for path, text in before.items():
        try:
            now = read_text(path)
        except InvalidFileError:
            now = None
        if now != text:
            found.append(
                ChangedFile(
                    name=path.name,
                    digest_before=digest(text),
                    digest_after=None if now is None else digest(now),
                )
            )
    return tuple(found)


def _report_stamp(file: Path) -> Any:
    """Return what says which report this is."""
    from cardan.cli.check import make_document_stamp

    return make_document_stamp((file,))
