"""`cardan check`: an application held against every limit, in words and on paper."""

from pathlib import Path
from typing import Any

import click

from cardan.base.errors import CardanError
from cardan.cli.common import (
    ALSO,
    JSON,
    LANG,
    LIMITS,
    OUT,
    OUTSIDE,
    approved,
    claim,
    progress,
    publish,
    put_lines,
    screen,
    write_json,
    written,
)
from cardan.cli.ending import Once, kindly, leave


@click.command(cls=Once)
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
@click.option("--live", metavar="OUT", type=OUT, help="The workbench's page, by itself.")
@ALSO
@click.option(
    "--recording",
    metavar="CAMPAIGN",
    type=click.Path(dir_okay=False, path_type=Path),
    help="Ask a campaign's recordings too, as cardan life does, for the same verdict.",
)
@click.option("--bracket", is_flag=True, help="The same as --with bracket; takes a while.")
@LIMITS
@OUTSIDE
@LANG
@click.option("--all", "every", is_flag=True, help="Every check and the numbers of every state.")
@click.option("--states", is_flag=True, help="The numbers of every state.")
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
@click.option("--quiet", "-q", is_flag=True, help="The verdict alone.")
@kindly
def check(
    files: tuple[Path, ...],
    *,
    json_out: str | None,
    html: Path | None,
    pdf: Path | None,
    xlsx: Path | None,
    live: Path | None,
    also: tuple[str, ...],
    recording: Path | None,
    bracket: bool,
    limits: str | None,
    allow_outside: bool,
    lang: str,
    every: bool,
    states: bool,
    phasings: bool,
    state: str | None,
    corrections: bool,
    short: bool,
    quiet: bool,
) -> None:
    """Hold an application against every limit, in every state; several files side by side.

    Exit code 0 where everything passes or warns, 1 where something fails or a required
    limit has no answer, 2 for a bad file.
    """
    from cardan.report import terminal
    from cardan.report.language import Language
    from cardan.study.sensitivity import sensitivities

    say = Language(lang)
    named: tuple[Path, ...] = ()
    if recording:
        from cardan.files.campaign import read as read_campaign

        named = read_campaign(recording, allow_outside=allow_outside).named
    outputs = claim(
        *files, limits, recording, *named,
        json_out=json_out, html=html, pdf=pdf, xlsx=xlsx, live=live,
    )  # fmt: skip
    if xlsx and len(files) > 1:
        raise CardanError(say("a workbook holds one application: give one file with --xlsx"))
    if recording and len(files) > 1:
        raise CardanError(say("a recording is of one application: give one file with --recording"))
    if live and (len(files) > 1 or limits or recording):
        raise CardanError(say("a page by itself holds one application, with its own limits"))
    studies: list[Any] = [*also, *(["bracket"] if bracket else [])]
    if recording:
        from cardan.study.studies import CampaignStudy

        studies.append(CampaignStudy(recording, bool(html or pdf), allow_outside))
    with progress(say("asking"), quiet=quiet) as tell:
        found = [
            approved(
                file, limits, allow_outside=allow_outside, outputs=outputs, also=studies, tell=tell
            )
            for file in files
        ]
    if json_out is not None:
        from cardan.report import contract

        documents = [contract.approval(a) for a in found]
        write_json(documents[0] if len(found) == 1 else {"variants": documents}, json_out)
    if html or pdf:
        with progress(say("looking for corrections"), quiet=quiet or not corrections) as tell:
            told = _story(
                files,
                found,
                say=say,
                state=state,
                corrections=corrections,
                short=short,
                tell=tell,
                beside=(recording,) if recording else (),
            )
        publish(told, say=say, html=html, pdf=pdf, quiet=quiet)
    if xlsx:
        from cardan.report import workbook

        written(xlsx, workbook.workbook(found[0], say=say), say)
    if live:
        from cardan.web.live import page

        for file, one in zip(files, found, strict=True):
            text = one.application.written.text if one.application.written else ""
            written(live, page(text, name=file.name, folder=str(file.parent), say=say), say)
    if quiet and json_out != "-":
        for one in found:
            put_lines(terminal.summary(one, say))
    elif json_out != "-":
        if len(found) > 1:
            put_lines(terminal.comparison(_variants(files, found), say, width=screen()))
        else:
            helps = sensitivities(found[0])
            sizes = _sizes(found[0], helps)
            shown = terminal.approval(
                found[0],
                helps=helps,
                sizes=sizes,
                every=every,
                states=states,
                phasings=phasings,
                say=say,
                width=screen(),
            )
            put_lines(shown)
    leave(*(a.verdict for a in found))


def _sizes(of: Any, helps: Any) -> Any:
    """Return other parts for what nothing moved answers."""
    from cardan.report.wording import out_of_reach

    stuck = out_of_reach(helps)
    if not stuck:
        return None
    from cardan.study.sizing import next_sizes

    return next_sizes(of.application, stuck)


def _variants(paths: tuple[Path, ...], found: list[Any]) -> list[Any]:
    """Return approvals by the names of their files, to stand side by side."""
    from cardan.report.compare import Variant

    return [Variant(name=p.stem, approval=a) for p, a in zip(paths, found, strict=True)]


def _story(paths: tuple[Path, ...], found: list[Any], *, say: Any, state: str | None,
           corrections: bool, short: bool, tell: Any, beside: tuple[Path, ...]) -> Any:  # fmt: skip
    """Return the story of one application, with all that belongs to it, or of variants."""
    from cardan.report import story

    of_this = issue(paths, *beside)
    if len(found) > 1:
        return story.comparison(_variants(paths, found), say=say, issue=of_this)
    return story.whole(
        found[0], say=say, issue=of_this, state=state, corrections=corrections, short=short,
        tell=tell,
    )  # fmt: skip


def issue(paths: tuple[Path, ...], *beside: Path) -> Any:
    """Return what says which report this is: the day, the files and what they held.

    Of files `beside` the applications only which they were.
    """
    from datetime import date
    from hashlib import sha256

    from cardan.report import story

    contents = [p.read_bytes() for p in (*paths, *beside)]
    return story.Issue(
        date=date.today().isoformat(),
        files=tuple(click.format_filename(p, shorten=True) for p in (*paths, *beside)),
        prints=tuple(sha256(c).hexdigest()[:16] for c in contents),
        texts=tuple(c.decode("utf-8-sig") for c in contents[: len(paths)]),
    )
