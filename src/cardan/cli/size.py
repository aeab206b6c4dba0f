"""`cardan size`: which other tube, joint, split or bearing place would do."""

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
    write_json,
)
from cardan.cli.ending import Once, kindly, leave


@click.command(cls=Once)
@FILE
@JSON
@LIMITS
@OUTSIDE
@LANG
@click.option("--line", help="Only this line.")
@UNTOLD
@kindly
def size(
    file: Path,
    *,
    json_out: str | None,
    limits: str | None,
    allow_outside: bool,
    lang: str,
    line: str | None,
    quiet: bool,
) -> None:
    """Propose other parts where moving cannot help.

    The lightest tube, the smallest joint, the nearest split of the length or place of a
    bearing that answers what does not pass, and makes nothing else worse; parts are of the
    file's own catalogues and those shipped. Exit code as a check with all of them in place.
    """
    from cardan.report import sizing as told
    from cardan.report.language import Language
    from cardan.study.sizing import sizing

    say = Language(lang)
    outputs = claim(file, limits, json_out=json_out)
    application = read(file, limits, allow_outside=allow_outside, outputs=outputs)
    with of(file, application), progress(say("trying other parts"), quiet=quiet) as tell:
        found = sizing(application, line=line, tell=tell)
    if json_out is not None:
        write_json(told.document(found), json_out)
    if json_out != "-":
        put_lines(told.lines(found, say))
    leave(found.approval.verdict)
