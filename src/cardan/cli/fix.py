"""`cardan fix`: what to change, over all states at once."""

from pathlib import Path
from typing import TYPE_CHECKING

import click

from cardan.cli.common import (
    FILE_ARGUMENT,
    JSON_OPTION,
    OUTPUT_PATH,
    QUIET_OPTION,
    add_file_position_to_errors,
    echo_lines,
    limits_and_language_options,
    progress_line,
    read_application,
    terminal_width,
    validate_output_paths,
    write_json,
    write_output,
)
from cardan.cli.exit_codes import (
    NoRepeatedOptionCommand,
    exit_with_code_2_on_known_errors,
    exit_with_verdicts,
)
from cardan.core.errors import DesignError

if TYPE_CHECKING:  # a command is imported before it is known what it computes
    from cardan.render.i18n import Translator
    from cardan.topics.design.corrections import Correction


@click.command(cls=NoRepeatedOptionCommand)
@FILE_ARGUMENT
@JSON_OPTION
@limits_and_language_options
@click.option("--line", help="Which line; by default the one with the worst check.")
@click.option("--hold", multiple=True, metavar="WHAT", help="Leave in place, as in the file.")
@click.option(
    "--count", type=click.IntRange(1), default=5, show_default=True, help="Proposals at most."
)
@click.option(
    "--draws",
    type=click.IntRange(0),
    default=0,
    metavar="N",
    help="Compute N trucks of each proposal, each by itself; by default their margins are taken "
    "from slopes at the setting.",
)
@click.option(
    "--write",
    metavar="OUT",
    type=OUTPUT_PATH,
    help="Write FILE with a proposal in it as OUT, a new file, and check that.",
)
@click.option(
    "--proposal",
    type=click.IntRange(1),
    default=1,
    show_default=True,
    metavar="N",
    help="Which proposal --write takes.",
)
@click.option("--all", "every", is_flag=True, help="All numbers of each proposal.")
@QUIET_OPTION
@exit_with_code_2_on_known_errors
def fix(
    file: Path,
    *,
    json_out: str | None,
    limits: str | None,
    allow_outside: bool,
    lang: str,
    line: str | None,
    hold: tuple[str, ...],
    count: int,
    draws: int,
    write: Path | None,
    proposal: int,
    every: bool,
    quiet: bool,
) -> None:
    """Propose what to change, over all states at once.

    Prints one screen; --all prints all of each proposal. Moves centre bearings, the axle's shim
    and yoke phases within what the file's `adjust` allows, in the steps of a workshop, and ranks
    by the verdict, by criteria exceeded, by warnings, by how many trucks keep it as they scatter,
    and by cost. --hold
    bearing_height, or --hold "phase 2", leaves that where it is. --write OUT writes the file as
    the first proposal changes it, in its own slopes, lengths or points. Exit code 0 where a check
    of the file changed as the first proposal says would end so, else 1; where there is no
    proposal, as a check of the file.
    """
    from cardan.documents.corrections_screen import correction_screen_lines
    from cardan.render.i18n import Translator
    from cardan.render.text_layout import fold_lines
    from cardan.topics.design.corrections import evaluate_corrections
    from cardan.topics.design.presentation import correction_lines
    from cardan.topics.design.sensitivity import check_sensitivities

    if write is None and proposal != 1:
        msg = f"--proposal {proposal} needs --write OUT: it is the proposal that is written"
        raise DesignError(msg)
    say = Translator(lang)
    outputs = validate_output_paths(file, limits, json_out=json_out, write=write)
    if write is not None and write.exists():
        msg = f"{write} is there already: choose another name"
        raise DesignError(msg)
    application = read_application(file, limits, allow_outside=allow_outside, outputs=outputs)
    with (
        add_file_position_to_errors(file, application),
        progress_line(say("looking for corrections"), quiet=quiet) as tell,
    ):
        results = evaluate_corrections(
            application, line=line, hold=hold, count=count, draws=draws, tell=tell
        )
    found, installed = results.proposals, results.installed
    if json_out is not None:
        from cardan.topics.design.corrections_json_presentation import corrections_json

        write_json(corrections_json(found), json_out)
    if json_out != "-":
        helps = () if found or hold else check_sensitivities(installed, line=line)
        wide = terminal_width()
        if every:
            several = len(installed.line_responses) > 1
            shown = correction_lines(found, say, helps=helps, several=several)
            echo_lines(fold_lines(shown, wide))
        else:
            echo_lines(correction_screen_lines(found, installed, helps=helps, say=say, width=wide))
    if write is not None:
        _write_proposal(found, proposal, write, limits=limits, say=say, quiet=json_out == "-")
    exit_with_verdicts(found[0].verdict if found else installed.verdict)


def _write_proposal(
    found: "tuple[Correction, ...]",
    number: int,
    out: Path,
    *,
    limits: str | None,
    say: "Translator",
    quiet: bool,
) -> None:
    """Write the file as a proposal changes it, once that can be read and checked."""
    from cardan.application import reader
    from cardan.application.plausibility import with_limit_profile
    from cardan.approval.approval import approve_application
    from cardan.documents.corrections_screen import written_correction_lines
    from cardan.topics.design.correction_edits import corrected_text

    if number > len(found):
        msg = f"nothing is written: proposal {number} of {len(found)}"
        raise DesignError(msg)
    of = found[number - 1]
    new, written = corrected_text(of), of.installed_approval.application.written
    changed = reader.loads(
        new.text,
        name=str(out),
        folder=out.absolute().parent,
        allow_outside=written is not None and written.allow_outside,
        warn=False,
    )
    checked = approve_application(with_limit_profile(changed, limits) if limits else changed)
    write_output(out, new.text, replace=False)
    if not quiet:
        echo_lines(written_correction_lines(new, number, checked, str(out), say, terminal_width()))
