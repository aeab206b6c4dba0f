"""`cardan check`: an application held against every limit, in words and on paper."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import click

from cardan.cli.common import (
    EXTRA_STUDY_OPTION,
    JSON_OPTION,
    OUTPUT_PATH,
    ReportPaths,
    approve_file,
    echo_lines,
    limits_and_language_options,
    progress_line,
    report_options,
    terminal_width,
    validate_output_paths,
    write_and_announce,
    write_json,
    write_report,
)
from cardan.cli.exit_codes import (
    NoRepeatedOptionCommand,
    exit_with_code_2_on_known_errors,
    exit_with_verdicts,
)
from cardan.core.errors import CardanError


def _ending_of(*endings: str) -> Callable[..., Path | None]:
    """Return a check that a file's name ends in what is written, before anything is read."""

    def check_ending(_: click.Context, __: click.Parameter, out: Path | None) -> Path | None:
        if out is not None and out.suffix.lower() not in endings:
            msg = f"its name ends in {' or '.join(endings)}, got {out.name!r}"
            raise click.BadParameter(msg)
        return out

    return check_ending


@click.command(cls=NoRepeatedOptionCommand)
@click.argument(
    "files",
    nargs=-1,
    required=True,
    metavar="FILE...",
    type=click.Path(dir_okay=False, path_type=Path),
)
@JSON_OPTION
@report_options
@click.option("--xlsx", metavar="OUT", type=OUTPUT_PATH, help="A workbook with live formulas.")
@click.option("--junit", metavar="OUT", type=OUTPUT_PATH,
              help="A test report in JUnit's format, for continuous integration.")  # fmt: skip
@click.option("--sarif", metavar="OUT", type=OUTPUT_PATH,
              help="Criteria not met, as SARIF: code hosts show them at their lines.")  # fmt: skip
@click.option("--live", metavar="OUT", type=OUTPUT_PATH, help="The workbench's page, by itself.")
@click.option(
    "--bearing-forces",
    metavar="OUT",
    type=OUTPUT_PATH,
    callback=_ending_of(".csv"),
    help="Bearing forces by state, order and speed: .csv.",
)
@click.option(
    "--parameters",
    metavar="OUT",
    type=OUTPUT_PATH,
    callback=_ending_of(".csv", ".m", ".mat"),
    help="Inertias, stiffness, angles and phases of the lines, for other models: .csv, .m, .mat.",
)
@EXTRA_STUDY_OPTION
@click.option(
    "--recording",
    metavar="CAMPAIGN",
    type=click.Path(dir_okay=False, path_type=Path),
    help="Evaluate a campaign's recordings too, as cardan life does, for the same verdict.",
)
@click.option("--bracket", is_flag=True, help="The same as --with bracket; takes a while.")
@limits_and_language_options
@click.option(
    "--all",
    "every",
    is_flag=True,
    help="Every check and the numbers of every state; of several files, side by side.",
)
@click.option("--states", is_flag=True, help="The numbers of every state.")
@click.option("--moves", is_flag=True, help="All single corrections of what is not met.")
@click.option(
    "--sources", is_flag=True, help="Each limit and the data with their sources; all notes."
)
@click.option(
    "--why",
    metavar="CRITERION",
    help="Equation, numbers put in and sources of a criterion, by its name on the screen.",
)
@click.option("--phasings", is_flag=True, help="The line with its yokes in every way.")
@click.option("--state", metavar="NAME", help="The state that reports draw; by default the worst.")
@click.option(
    "--corrections/--no-corrections",
    default=True,
    help="Look for corrections for a report: half a minute for three shafts, minutes for four.",
)
@click.option(
    "--short", is_flag=True, help="Reports without numbers of every state, inputs and equations."
)
@click.option(
    "--quiet", "-q", is_flag=True, help="The verdict alone, and how many values look wrong."
)
@exit_with_code_2_on_known_errors
def check(
    files: tuple[Path, ...],
    *,
    json_out: str | None,
    reports: ReportPaths,
    xlsx: Path | None,
    junit: Path | None,
    sarif: Path | None,
    live: Path | None,
    bearing_forces: Path | None,
    parameters: Path | None,
    also: tuple[str, ...],
    recording: Path | None,
    bracket: bool,
    limits: str | None,
    allow_outside: bool,
    lang: str,
    every: bool,
    states: bool,
    moves: bool,
    sources: bool,
    why: str | None,
    phasings: bool,
    state: str | None,
    corrections: bool,
    short: bool,
    quiet: bool,
) -> None:
    """Hold an application against every limit, in every state; several files in a line each.

    Prints one screen of one file; --why, --moves, --sources, --states and --all print the rest.

    Exit code 0 if everything passes or warns, 1 if something fails or a required limit is
    not evaluated, 2 for a bad file.
    """
    from cardan.documents import terminal
    from cardan.render.i18n import Translator
    from cardan.render.terminal import summary_lines
    from cardan.topics.design.sensitivity import check_sensitivities

    say = Translator(lang)
    named: tuple[Path, ...] = ()
    if recording:
        from cardan.topics.recording.campaign_schema import read_campaign_file as read_campaign

        named = read_campaign(recording, allow_outside=allow_outside).referenced_files
    outputs = validate_output_paths(
        *files, limits, recording, *named,
        json_out=json_out, **reports, xlsx=xlsx, junit=junit, sarif=sarif, live=live,
        **{"bearing-forces": bearing_forces, "parameters": parameters},
    )  # fmt: skip
    if xlsx and len(files) > 1:
        raise CardanError(say("a workbook holds one application: give one file with --xlsx"))
    for option, path in (("--bearing-forces", bearing_forces), ("--parameters", parameters)):
        if path and len(files) > 1:
            one = "a table holds one application: give one file with {option}"
            raise CardanError(say(one, option=option))
    if recording and len(files) > 1:
        raise CardanError(say("a recording is of one application: give one file with --recording"))
    if live and (len(files) > 1 or limits or recording):
        raise CardanError(say("a page by itself holds one application, with its own limits"))
    if why is not None and len(files) > 1:
        raise CardanError(say("a criterion is of one application: give one file with --why"))
    studies: list[Any] = [*also, *(["bracket"] if bracket else [])]
    if recording:
        from cardan.topics.recording.registration import RecordingCampaignStudy

        studies.append(RecordingCampaignStudy(recording, bool(reports), allow_outside))
    with progress_line(say("calculating"), quiet=quiet) as tell:
        found = [
            approve_file(
                file, limits, allow_outside=allow_outside, outputs=outputs, also=studies, tell=tell
            )
            for file in files
        ]
    if json_out is not None:
        from cardan.documents import approval_json as contract

        documents = [contract.json_document(a) for a in found]
        write_json(documents[0] if len(found) == 1 else {"variants": documents}, json_out)
    if reports:
        with progress_line(say("looking for corrections"), quiet=quiet or not corrections) as tell:
            told = _report(
                files,
                found,
                say=say,
                state=state,
                corrections=corrections,
                short=short,
                tell=tell,
                beside=(recording,) if recording else (),
            )
        write_report(told, reports, say=say, quiet=quiet)
    if xlsx:
        from cardan.documents import workbook

        write_and_announce(xlsx, workbook.workbook_bytes(found[0], say=say), say)
    by_name = [(str(file), one) for file, one in zip(files, found, strict=True)]
    if junit:
        from cardan.documents.approval_junit import junit_xml

        write_and_announce(junit, junit_xml(by_name), say)
    if sarif:
        from cardan.documents.approval_sarif import sarif_text

        write_and_announce(sarif, sarif_text(by_name, say), say)
    if bearing_forces:
        from cardan.documents.bearing_force_table import bearing_force_csv

        write_and_announce(bearing_forces, bearing_force_csv(found[0].line_responses), say)
    if parameters:
        from cardan.documents.parameter_sheet import WRITERS, parameter_sheet

        sheet = parameter_sheet(found[0])
        write_and_announce(parameters, WRITERS[parameters.suffix.lower()](sheet), say)
    if live:
        from cardan.web.static_export import standalone_page

        for file, one in zip(files, found, strict=True):
            text = one.application.written.text if one.application.written else ""
            write_and_announce(
                live, standalone_page(text, name=file.name, folder=str(file.parent), say=say), say
            )
    if quiet and json_out != "-":
        for one in found:
            echo_lines(summary_lines(one, say))
    elif json_out != "-":
        if len(found) > 1:
            compared = _variants(files, found)
            echo_lines(
                terminal.comparison_lines(compared, say, width=terminal_width())
                if every
                else terminal.file_lines(
                    [replace(v, name=str(p)) for v, p in zip(compared, files, strict=True)], say
                )
            )
        else:
            helps = check_sensitivities(found[0])
            if why is not None:
                shown = _explanation(found[0], why, helps=helps, say=say)
            else:
                shown = terminal.approval_lines(
                    found[0],
                    helps=helps,
                    sizes=_other_parts(found[0], helps) if every or moves else None,
                    every=every,
                    states=states,
                    phasings=phasings,
                    moves=moves,
                    sources=sources,
                    say=say,
                    width=terminal_width(),
                )
            echo_lines(shown)
    exit_with_verdicts(*(a.verdict for a in found))


def _explanation(of: Any, text: str, *, helps: Any, say: Any) -> Any:
    """Return the lines on the criteria that `--why` names; refuse a text that names none."""
    from cardan.documents import criterion_explanation as explanation
    from cardan.schema.node_reader import nearest_name

    named = explanation.criteria_named(of, text)
    if not named:
        names = explanation.criterion_names(of, say)
        near, hint = nearest_name(text, names)
        hint = hint if near else f"there are: {'; '.join(names)}"  # names hold commas
        raise CardanError(
            say("no criterion of this file is called {text}", text=text) + f"; {say.error(hint)}"
        )
    if len(named) > explanation.MAX_EXPLAINED:
        many = "{count} criteria are called {text}: give a whole name"
        raise CardanError(say(many, count=len(named), text=text))
    return explanation.explanation_lines(named, of, helps=helps, say=say, width=terminal_width())


def _other_parts(of: Any, helps: Any) -> Any:
    """Return other parts for what nothing moved answers."""
    from cardan.topics.design.phrases import checks_without_adjustment

    stuck = checks_without_adjustment(helps)
    if not stuck:
        return None
    from cardan.topics.design.sizing import next_part_sizes

    return next_part_sizes(of.application, stuck)


def _variants(paths: tuple[Path, ...], found: list[Any]) -> list[Any]:
    """Return approvals by the names of their files, to stand side by side."""
    from cardan.documents.comparison import Variant

    return [Variant(name=p.stem, approval=a) for p, a in zip(paths, found, strict=True)]


def _report(paths: tuple[Path, ...], found: list[Any], *, say: Any, state: str | None,
           corrections: bool, short: bool, tell: Any, beside: tuple[Path, ...]) -> Any:  # fmt: skip
    """Return the story of one application, with all that belongs to it, or of variants."""
    from cardan.documents import approval_report as story

    of_this = make_document_stamp(paths, *beside)
    if len(found) > 1:
        return story.comparison_report(_variants(paths, found), say=say, issue=of_this)
    return story.approval_report(
        found[0], say=say, issue=of_this, state=state, corrections=corrections, short=short,
        tell=tell,
    )  # fmt: skip


def make_document_stamp(paths: tuple[Path, ...], *beside: Path) -> Any:
    """Return what says which report this is: the day, the files and what they held.

    Of files `beside` the applications only which they were.
    """
    from datetime import date
    from hashlib import sha256

    from cardan.documents import approval_report as story

    contents = [p.read_bytes() for p in (*paths, *beside)]
    return story.ReportDateAndSourceStamp(
        date=date.today().isoformat(),
        file_names=tuple(click.format_filename(p, shorten=True) for p in (*paths, *beside)),
        fingerprints=tuple(sha256(c).hexdigest()[:16] for c in contents),
        file_texts=tuple(c.decode("utf-8-sig") for c in contents[: len(paths)]),
    )
