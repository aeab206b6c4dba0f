"""`cardan life`: from a recording to damage, life and cause, held against limits."""

import contextlib
from collections.abc import Callable
from io import BytesIO
from pathlib import Path
from typing import Any

import click

from cardan.cli.common import (
    ALLOW_FILES_OUTSIDE_FOLDER_OPTION,
    JSON_OPTION,
    LANG_OPTION,
    OUTPUT_PATH,
    QUIET_OPTION,
    ReportPaths,
    echo_application_warnings,
    echo_lines,
    progress_line,
    read_application,
    report_options,
    terminal_width,
    validate_output_paths,
    write_json,
    write_output,
    write_report,
)
from cardan.cli.exit_codes import exit_with_code_2_on_known_errors, exit_with_verdicts
from cardan.cli.life_overview import is_overview, print_overview
from cardan.cli.life_tables import (
    TABLE_NAMES,
    TablePaths,
    add_output_table_options,
    check_tables,
    write_tables,
)
from cardan.cli.option_groups import GroupedOptionsCommand
from cardan.core.errors import DesignError, MissingDependencyError
from cardan.render.media import REPORT_MEDIA
from cardan.topics.recording.option_table import LifeOption, options_in_help_order

OPTION_GROUPS = {
    "Gauges": "gauges",
    "Strength and damage": "sn",
    "Signals": "zero",
    "Shaft, engine and causes": "speed",
    "Prediction from the geometry": "predicted",
    "Other models of life": "strain_life",
    "Use, identification, another application": "usage",
    "Reading the file, suspect data": "rate",
    "Limits": "target_hours",
    "Output": "json_out",
    "General": "allow_outside",
}
"""Groups of the help by purpose, each with its first option in the order of the help."""


def _check_plot_suffix(_: click.Context, __: click.Parameter, out: Path | None) -> Path | None:
    """Refuse a figure whose ending names no kind, before anything is read."""
    if out is not None and out.suffix not in ("", ".svg", ".png", ".pdf"):
        msg = f"a figure ends in .svg, .png or .pdf, got {out.name!r}"
        raise click.BadParameter(msg)
    return out


def _click_option(of: LifeOption) -> Callable[[Any], Any]:
    """Return the command's option of an entry of the table."""
    how: dict[str, Any] = {"help": of.help, "metavar": of.metavar}
    if of.value_type is bool:
        return click.option(of.flag, of.name, is_flag=True, **how)
    if of.is_repeatable:
        return click.option(of.flag, of.name, multiple=True, **how)
    if of.is_application:
        how["type"] = click.Path(dir_okay=False, path_type=Path)
    elif of.choices:
        how["type"] = click.Choice(of.choices)
    else:
        how["type"] = of.number_type
    shown = of.default is not None and of.default != ""
    return click.option(of.flag, of.name, default=of.default, show_default=shown, **how)


_CORRECTED = click.option(
    "--corrected",
    type=OUTPUT_PATH,
    help="With --identify: the application's file with what was found otherwise; comments stay.",
)
_LOAD_HISTORY = click.option(
    "--load-history",
    "load_history",
    type=OUTPUT_PATH,
    help="With --identify: the force on the bearing over the recording, as CSV.",
)
_CHANGED_HISTORY = click.option(
    "--changed-history",
    "changed_history",
    type=OUTPUT_PATH,
    help="With --changed: the force on its bearing over the recording, as CSV.",
)
_OUTPUTS_AFTER = {"identify": (_CORRECTED, _LOAD_HISTORY), "changed": (_CHANGED_HISTORY,)}
"""Files that are written of what an option finds; the help has them behind it."""


def _analysis_options(command: Callable[..., None]) -> Callable[..., None]:
    """Give a command the options of the table, and what is written of them."""
    found: list[Callable[[Any], Any]] = []
    for one in options_in_help_order():
        found += (_click_option(one), *_OUTPUTS_AFTER.get(one.name, ()))
    for decorator in reversed(found):
        command = decorator(command)
    return command


class _LifeCommand(GroupedOptionsCommand):
    option_groups = OPTION_GROUPS


@click.command(cls=_LifeCommand)
@click.argument("recording", type=click.Path(dir_okay=False, path_type=Path))
@_analysis_options
@JSON_OPTION
@click.option("--plot", type=OUTPUT_PATH, callback=_check_plot_suffix, help="A figure: svg, png.")
@add_output_table_options
@report_options
@ALLOW_FILES_OUTSIDE_FOLDER_OPTION
@LANG_OPTION
@click.option("--all", "every", is_flag=True, help="All numbers and sentences, not one screen.")
@QUIET_OPTION
@exit_with_code_2_on_known_errors
def life(
    recording: Path,
    *,
    application: Path | None,
    json_out: str | None,
    plot: Path | None,
    tables: TablePaths,
    reports: ReportPaths,
    corrected: Path | None,
    load_history: Path | None,
    changed: Path | None,
    changed_history: Path | None,
    allow_outside: bool,
    lang: str,
    every: bool,
    quiet: bool,
    **options: Any,
) -> None:
    """Damage and life at the gauges of a RECORDING, and its causes.

    Without --gauge, --sn or another option of an evaluation: the channels of a RECORDING, with
    unit, rate, length, range, suspect data and a guess at what each is, and the command to go on.

    A RECORDING that ends in .yaml is a campaign: a file that names recordings and says of all
    what the options say of one. Of the options only the outputs
    --json, --html and --pdf, tables, --lang, --all and --quiet go with it, and of one that
    names a single recording --corrected, --load-history and --changed-history.

    Prints one screen; --all prints the rest. Compared with --target-hours and the rows of
    --limits, if given. Exit code 0 if every gauge passes or warns or no limit is given, 1 if one
    fails, its data are rejected or a life with a limit is unknown, 2 for a bad file or option.
    """
    from cardan.render.i18n import Translator
    from cardan.render.text_layout import fold_lines
    from cardan.topics.recording import json_presentation
    from cardan.topics.recording import presentation as report
    from cardan.topics.recording.life_verdict import assessment_verdict
    from cardan.topics.recording.options import AnalysisOptions
    from cardan.topics.recording.screen_presentation import screen_lines
    from cardan.topics.recording.study import analyse_recording

    _limit_malloc_arenas()
    say = Translator(lang)
    if recording.suffix.lower() in (".yaml", ".yml"):
        _run_campaign(
            recording, json_out=json_out, tables=tables, reports=reports, corrected=corrected,
            load_history=load_history, changed_history=changed_history,
            allow_outside=allow_outside, say=say, every=every, quiet=quiet,
        )  # fmt: skip
        return
    if is_overview(click.get_current_context()):
        print_overview(recording, json_out=json_out, say=say, quiet=quiet, **options)
        return
    if options["sn"] is None:
        msg = "a recording needs an S-N curve: --sn MPa,CYCLES,SLOPE"
        raise DesignError(msg)
    if (corrected or load_history) and not options["identify"]:
        name = "--corrected" if corrected else "--load-history"
        msg = f"{name} reports what --identify finds: add --identify"
        raise DesignError(msg)
    if changed_history and changed is None:
        msg = "--changed-history is the force on the bearing of a --changed application: name one"
        raise DesignError(msg)
    check_tables(tables, options)
    outputs = validate_output_paths(
        recording, application, changed, options["limits"], *options["dbc"], json_out=json_out,
        plot=plot, **reports, **tables, corrected=corrected, load_history=load_history,
        changed_history=changed_history,
    )  # fmt: skip
    predicting, instead = (
        read_application(path, None, allow_outside=allow_outside, outputs=outputs) if path else None
        for path in (application, changed)
    )
    campaign = AnalysisOptions(application=predicting, changed=instead, **options)
    with progress_line(say("reading"), quiet=quiet) as line:
        found = analyse_recording(
            recording, campaign, lambda doing, _, __: line.write(report.progress_text(doing, say)),
            draw=bool(reports),
        )  # fmt: skip
    if json_out is not None:
        write_json(json_presentation.json_document(found), json_out)
    if json_out != "-":
        if every:
            echo_lines(fold_lines(report.terminal_lines(found, say), terminal_width()))
        else:
            echo_lines(screen_lines(found, say, width=terminal_width()))
    if plot:
        _write_plot(plot, found)
    write_tables(found.answer, tables)
    if reports:
        from cardan.topics.recording import report as story

        issue = _report_stamp(recording, application, changed, *campaign.can_databases, text=False)
        told = story.recording_report(found, say=say, issue=issue)
        write_report(told, reports, say=say, quiet=quiet)
    if found.answer is not None:
        _write_identified(campaign, found.answer, corrected, load_history, changed_history)
    exit_with_verdicts(assessment_verdict(found) or "pass")


def _limit_malloc_arenas() -> None:
    """Let threads take their memory from one place: each else keeps what it has done with.

    It is worth 100 MB on a long recording, and nothing can be said where there is no glibc.
    """
    import ctypes

    with contextlib.suppress(OSError, AttributeError, TypeError):
        ctypes.CDLL(None).mallopt(-8, 1)  # M_ARENA_MAX


def _write_identified(
    campaign: Any, of: Any, corrected: Path | None, history: Path | None, changed: Path | None
) -> None:
    """Write what follows from an identification, where there is one.

    Raises
    ------
    DesignError
        If it determines nothing of the line: an earlier file would be taken for its result.
    """
    if of.identification is None:
        return
    asked = {"--corrected": corrected, "--load-history": history, "--changed-history": changed}
    named = [name for name, path in asked.items() if path is not None]
    if of.identification.doubts and named:
        msg = f"{named[0]} writes nothing: this recording identifies nothing of the line"
        raise DesignError(msg)
    if corrected is not None:
        write_output(corrected, of.identification.file_text())
    if history is not None:
        write_output(history, _load_history_csv(campaign, of))
    if changed is not None:
        write_output(changed, _load_history_csv(campaign, of, changed=True))


def _load_history_csv(campaign: Any, of: Any, *, changed: bool = False) -> str:
    """Return the force on the bearing over a recording as a table, by default as driven."""
    from cardan.topics.recording.study import recorded_bearing_force

    time, force = recorded_bearing_force(campaign, of, changed=changed)
    rows = (f"{t:.5f},{x:.4g},{y:.4g},{z:.4g}" for t, (x, y, z) in zip(time, force, strict=True))
    return "\n".join(("time_s,x_N,y_N,z_N", *rows)) + "\n"


def _run_campaign(
    path: Path, *, json_out: str | None, tables: TablePaths, reports: ReportPaths,
    corrected: Path | None, load_history: Path | None, changed_history: Path | None,
    allow_outside: bool, say: Any, every: bool, quiet: bool,
) -> None:  # fmt: skip
    """Assess all the recordings of a campaign's file."""
    from cardan.render.text_layout import fold_lines
    from cardan.topics.recording import json_presentation
    from cardan.topics.recording import presentation as report
    from cardan.topics.recording.campaign_schema import read_campaign_file as read_campaign
    from cardan.topics.recording.campaign_study import analyse_campaign
    from cardan.topics.recording.life_verdict import assessment_verdict
    from cardan.topics.recording.options import options_as_campaign_file_keys
    from cardan.topics.recording.screen_presentation import screen_lines

    context = click.get_current_context()
    given = click.core.ParameterSource.COMMANDLINE
    own = {"recording", "json_out", *(m.name for m in REPORT_MEDIA), *TABLE_NAMES, "lang", "every",
           "quiet", "allow_outside", "corrected", "load_history", "changed_history"}  # fmt: skip
    beside = [
        n for n in context.params if n not in own and context.get_parameter_source(n) == given
    ]
    if beside:
        option = beside[0].replace("_", "-")
        msg = f"--{option} belongs in the campaign's file, {path.name}, not on the command line"
        raise DesignError(msg)
    outputs = {
        "json_out": json_out, **reports, **tables, "corrected": corrected,
        "load_history": load_history, "changed_history": changed_history,
    }  # fmt: skip
    validate_output_paths(path, **outputs)
    written = read_campaign(path, allow_outside=allow_outside)
    validate_output_paths(*written.referenced_files, **outputs)
    check_tables(tables, written.options)
    for name in ("application", "changed"):
        if written.options[name] is not None:
            echo_application_warnings(written.options[name])
    with progress_line(say("reading"), quiet=quiet) as line:
        found = analyse_campaign(
            written, draw=bool(reports),
            tell=lambda doing, _, __: line.write(report.progress_text(doing, say)),
            identified=bool(corrected or load_history), changed=bool(changed_history),
        )  # fmt: skip
    if json_out is not None:
        write_json(json_presentation.campaign_json_document(found), json_out)
    if json_out != "-":
        wide = terminal_width()
        lines = (
            fold_lines(
                map(options_as_campaign_file_keys, report.campaign_terminal_lines(found, say)), wide
            )
            if every
            else map(options_as_campaign_file_keys, screen_lines(found, say, width=wide))
        )
        echo_lines(lines)
    write_tables(found.answer, tables)
    if reports:
        from cardan.topics.recording import report as story

        told = story.campaign_report(
            found, say=say, issue=_report_stamp(path, *written.referenced_files, text=True)
        )
        write_report(told, reports, say=say, quiet=quiet)
    if found.answer is not None and any((corrected, load_history, changed_history)):
        ((_, _, heard),) = found.answer.parts
        _write_identified(found.answer.options, heard, corrected, load_history, changed_history)
    exit_with_verdicts(assessment_verdict(found) or "pass")


def _report_stamp(first: Path, *others: Path | None, text: bool) -> Any:
    """Return what says which report this is: the day, the files it is of and what they held."""
    from datetime import date
    from hashlib import file_digest

    from cardan.render.blocks import ReportDateAndSourceStamp

    def print_(path: Path) -> str:
        with path.open("rb") as file:
            return file_digest(file, "sha256").hexdigest()[:16]

    paths = tuple(dict.fromkeys(p for p in (first, *others) if p is not None))
    return ReportDateAndSourceStamp(
        date=date.today().isoformat(),
        file_names=tuple(click.format_filename(p, shorten=True) for p in paths),
        fingerprints=tuple(map(print_, paths)),
        file_texts=(first.read_text(encoding="utf-8-sig"),) if text else (),
    )


def _write_plot(out: Path, found: Any) -> None:
    """Draw a figure to a file whose ending says of which kind."""
    from cardan.topics.recording.figure_presentation import draw_recording_figure

    try:
        from matplotlib.figure import Figure
    except ImportError as error:
        msg = "--plot needs matplotlib; pip install 'cardan[report]'"
        raise MissingDependencyError(msg) from error
    sheet = Figure(figsize=(11, 10), layout="constrained")
    of = found.answer
    draw_recording_figure(sheet, recording=of.recording, lives=of.lives, causes=of.causes)
    drawn = BytesIO()
    sheet.savefig(drawn, format=out.suffix.removeprefix(".") or "svg")
    write_output(out, drawn.getvalue())
