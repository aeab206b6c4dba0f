"""`cardan study`: what many variants come to, from a laptop to a cluster."""

import os
import sys
from pathlib import Path
from time import perf_counter
from typing import Any

import click

from cardan.base.errors import BadFile, DesignError, Problem
from cardan.cli.common import (
    FILE,
    JSON,
    LANG,
    LIMITS,
    OUT,
    OUTSIDE,
    UNTOLD,
    claim,
    note,
    of,
    progress,
    publish,
    put_lines,
    read,
    write_json,
)
from cardan.cli.ending import STOPPED, Once, kindly


@click.command(cls=Once)
@FILE
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
    help="Who computes; an address is that of a Dask cluster, tcp://host:8786.",
)
@click.option(
    "--workers",
    type=click.IntRange(1),
    default=None,
    help="At a time; by default one a core, here or of the cluster.",
)
@JSON
@click.option("--html", metavar="OUT", type=OUT, help="A page with histograms, bars and maps.")
@click.option("--pdf", metavar="OUT", type=OUT, help="A document of the same.")
@LIMITS
@OUTSIDE
@LANG
@UNTOLD
@kindly
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
    json_out: str | None,
    html: Path | None,
    pdf: Path | None,
    limits: str | None,
    allow_outside: bool,
    lang: str,
    quiet: bool,
) -> None:
    """Ask every limit of many variants of an application, and tell how many may be built.

    What varies, what scatters and what is asked stands in the file's `study`, or in a file of
    --study. Stopped from the keyboard it tells of what is done; with --out that is kept, and
    --resume goes on to the same answer, to the last bit, as if nothing had stopped it.

    Exit code 0 where the study was asked to its end, whatever it came to, 130 where it was
    stopped.
    """
    from cardan.report import study as report
    from cardan.report.language import Language
    from cardan.study.shards import Stopped, workers_of
    from cardan.study.shards import study as run

    say = Language(lang)
    if resume and folder is None:
        msg = "--resume goes on with a folder: name it with --out"
        raise DesignError(msg)
    if executor not in ("threads", "processes") and ":" not in executor:
        msg = (
            f"--executor must be threads, processes or the address of a Dask cluster, as "
            f"tcp://host:8786 (got {executor})"
        )
        raise DesignError(msg)
    outputs = claim(file, beside, limits, json_out=json_out, html=html, pdf=pdf)
    application = read(file, limits, allow_outside=allow_outside, outputs=outputs)
    variants = application.variants
    if beside is not None:
        from cardan.files.study import read as read_study

        variants = read_study(beside, application)
    if variants is None:
        msg = f"{file} has no study: say what varies in it, or in a file of --study"
        raise DesignError(msg)
    stopped = False
    here = workers or os.cpu_count() or 1
    number = here if executor in ("threads", "processes") else workers  # a cluster's own number
    last, idle = 0.0, False
    with of(file, application), progress(say("asking"), quiet=quiet) as line:

        def hear(told: Any) -> None:
            nonlocal last, idle
            if told.idle and not (idle or line.seen or quiet):
                note(report.progress(told, say))
            idle = told.idle
            if line.seen and (perf_counter() - last > 0.2 or told.done == told.count):
                last = perf_counter()
                line.at(report.progress(told, say))

        try:
            with workers_of(executor, here) as pool:
                found = run(
                    application, variants, count=count, seed=seed, folder=folder, resume=resume,
                    executor=pool, workers=number, hear=hear,
                )  # fmt: skip
        except Stopped as error:
            stopped, found = True, error.studied
        except ValueError as error:  # a name, a range, a correlation
            at = variants.places.get(str(error).partition(":")[0], (0, 0))
            problem = Problem(message=str(error), line=at[0], column=at[1])
            raise BadFile(str(beside or file), (problem,)) from error
    if json_out is not None:
        write_json(report.document(found), json_out)
    if html or pdf:
        told = report.story(found, say=say, issue=_issue(file))
        publish(told, say=say, html=html, pdf=pdf, quiet=quiet)
    if json_out != "-":
        put_lines(report.terminal(found, say))
    if folder is not None:
        note(say("{file} is written.", file=folder))
    if stopped:
        if folder is not None:
            note(say("stopped; the same command with --resume goes on"))
        sys.exit(STOPPED)


def _issue(file: Path) -> Any:
    """Return what says which report this is."""
    from cardan.cli.check import issue

    return issue((file,))
