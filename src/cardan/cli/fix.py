"""`cardan fix`: what to change, over all states at once."""

from pathlib import Path

import click

from cardan.cli.common import (
    FILE,
    JSON,
    LANG,
    LIMITS,
    OUTSIDE,
    UNTOLD,
    claim,
    of,
    progress,
    put_lines,
    read,
    screen,
    write_json,
)
from cardan.cli.ending import Once, kindly, leave


@click.command(cls=Once)
@FILE
@JSON
@LIMITS
@OUTSIDE
@LANG
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
    help="Ask N trucks of each proposal, each by itself; by default their margins are taken "
    "from slopes at the setting.",
)
@UNTOLD
@kindly
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
    quiet: bool,
) -> None:
    """Propose what to change, over all states at once.

    Moves centre bearings, the axle's shim and yoke phases within what the file's `adjust`
    allows, in the steps of a workshop, and ranks by the verdict, by how many trucks keep it as
    they scatter, and by cost. --hold bearing_height, or --hold "phase 2", leaves that where it
    is. Exit code 0 where a check of the file changed as the first proposal says would end so,
    else 1; where there is no proposal, as a check of the file.
    """
    from cardan.report import terminal
    from cardan.report.language import Language
    from cardan.report.screen import folded
    from cardan.study.approval import approve
    from cardan.study.fix import fix as search
    from cardan.study.sensitivity import sensitivities

    say = Language(lang)
    outputs = claim(file, limits, json_out=json_out)
    application = read(file, limits, allow_outside=allow_outside, outputs=outputs)
    with of(file, application), progress(say("looking for corrections"), quiet=quiet) as tell:
        found = search(application, line=line, hold=hold, count=count, draws=draws, tell=tell)
    if json_out is not None:
        from cardan.report import contract

        write_json(contract.proposals(found), json_out)
    installed = found[0].installed if found else approve(application)
    if json_out != "-":
        helps = () if found or hold else sensitivities(installed, line=line)
        several = len(installed.responses) > 1
        shown = terminal.proposals(found, say, helps=helps, several=several)
        put_lines(folded(shown, screen()))
    leave((found[0].approval if found else installed).verdict)
