"""`cardan verify`: published cases, recomputed on this machine."""

import click

from cardan.cli.common import JSON, claim, put_lines, screen, write_json
from cardan.cli.ending import Once, kindly


@click.command(cls=Once)
@JSON
@kindly
def verify(*, json_out: str | None) -> None:
    """Recompute published cases on this machine and show both numbers.

    Exit code 1 where one does not agree to its printed digits.
    """
    from cardan.report import terminal
    from cardan.study.published import published

    claim(json_out=json_out)
    cases = published()
    if json_out is not None:
        from cardan.report import contract

        write_json(contract.published(cases), json_out)
    if json_out != "-":
        put_lines(terminal.published(cases, width=screen()))
    raise SystemExit(0 if all(c.agrees for c in cases) else 1)
