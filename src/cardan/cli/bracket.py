"""`cardan bracket`: stresses, hot spots, gauges and modes of a bracket."""

from io import BytesIO
from pathlib import Path

import click

from cardan.cli.common import (
    FILE,
    JSON,
    LANG,
    LIMITS,
    OUT,
    OUTSIDE,
    UNTOLD,
    claim,
    of,
    progress,
    put_lines,
    read,
    screen,
    write,
    write_json,
)
from cardan.cli.ending import Once, kindly, leave

REINFORCED = "reinforced"
"""The variant that stands beside the original, in a file of its own."""


@click.command(cls=Once)
@FILE
@JSON
@click.option("--vtu", type=OUT, help="Mesh and fields, for ParaView.")
@click.option("--png", type=OUT, help="A picture of the worst case.")
@click.option("--html", type=OUT, help="A page to turn it about in.")
@click.option("--step", type=OUT, help="Its shape, for CAD; faces carry their names.")
@click.option(
    "--optimise", is_flag=True, help="Search the lightest that lives as long as `optimise` asks."
)
@LIMITS
@OUTSIDE
@LANG
@UNTOLD
@kindly
def bracket(
    file: Path,
    *,
    json_out: str | None,
    vtu: Path | None,
    png: Path | None,
    html: Path | None,
    step: Path | None,
    optimise: bool,
    limits: str | None,
    allow_outside: bool,
    lang: str,
    quiet: bool,
) -> None:
    """Stresses, hot spots, virtual gauges and modes of FILE's bracket.

    Under the driveline's own loads in every state and those given by hand; a reinforced
    variant stands beside the original. Needs the extra cardan[bracket]. Exit code 0 where
    the original passes or warns, 1 where it fails a limit, 2 for a bad file.

    With --optimise sizes are chosen instead: 0 where some live long enough, in bolts that hold,
    else 1.
    """
    from cardan.base.errors import DesignError
    from cardan.report import bracket as shown
    from cardan.report import bracket_search as chosen
    from cardan.report.language import Language
    from cardan.report.terminal import bare, summary
    from cardan.study.approval import approve
    from cardan.study.bracket import BracketAnswer
    from cardan.study.bracket_search import search
    from cardan.study.finding import BRACKET
    from cardan.study.studies import BracketStudy

    say = Language(lang)
    if optimise:
        if vtu or png or html or step:
            msg = "--optimise chooses sizes: it draws nothing; put them into the file and ask again"
            raise DesignError(msg)
        outputs = claim(file, limits, json_out=json_out)
        application = read(file, limits, allow_outside=allow_outside, outputs=outputs)
        with of(file, application), progress(say("The bracket"), quiet=quiet) as tell:
            searched = search(application, tell=lambda doing: tell.study(say.error(doing), 0, 0))
        if json_out is not None:
            write_json(chosen.contract(application, searched), json_out)
        if json_out != "-":
            put_lines(chosen.terminal(application, searched, say, width=screen()))
        leave("pass" if searched.best else "fail")
    beside = _beside(vtu, REINFORCED) if vtu else None
    outputs = claim(
        file, limits, json_out=json_out, vtu=vtu, vtu_beside=beside, png=png, html=html, step=step
    )  # fmt: skip
    application = read(file, limits, allow_outside=allow_outside, outputs=outputs)
    with of(file, application), progress(say("The bracket"), quiet=quiet) as tell:
        approval = approve(
            application, (BracketStudy(),),
            tell=lambda doing, done, count: tell.study(say.error(doing), done, count),
        )  # fmt: skip
    found: BracketAnswer = approval.of(BRACKET)
    if json_out is not None:
        write_json(shown.contract(approval), json_out)
    if vtu:
        for variant in found.variants:
            first = variant is found.variants[0]
            name = vtu if first else _beside(vtu, variant.name)
            write(name, shown.vtu(variant, said=bare(summary(approval, say)) if first else ""))
    if png:
        drawn = BytesIO()
        said = bare(summary(approval, say))
        shown.picture(found, drawn, say=say, over=said)
        write(png, drawn.getvalue())
    if html:
        from cardan.report import bracket_scene

        write(html, bracket_scene.page(approval, say=say))
    if step:
        from cardan.bracket.solve import drawn_apart

        write(step, drawn_apart(found.bracket.shape))
    if json_out != "-":
        put_lines(shown.terminal(approval, say, width=screen()))
    leave(approval.verdict)


def _beside(file: Path, variant: str) -> Path:
    """Return the name of a variant's file, beside that of the original."""
    return file.with_stem(f"{file.stem}-{variant}")
