"""`cardan schema`: what an application file may hold, for editors."""

import json
from pathlib import Path

import click

from cardan.cli.common import OUT, put_json, write
from cardan.cli.ending import Once, kindly


@click.command(cls=Once)
@click.option("--out", type=OUT, help="Into a file.")
@click.option("--contract", is_flag=True, help="Of what --json writes, instead.")
@click.option("--campaign", is_flag=True, help="Of a campaign of recordings, instead.")
@click.option("--study", is_flag=True, help="Of a study of variants in a file of its own, instead.")
@click.option("--force", is_flag=True, help="Replace the file.")
@kindly
def schema(*, out: Path | None, contract: bool, campaign: bool, study: bool, force: bool) -> None:
    """Print the JSON Schema of the application file, for editors."""
    from cardan import files

    if contract:
        from cardan.report.contract_schema import schema as described

        document = described()
    elif campaign:
        from cardan.files.campaign import schema as described

        document = described()
    elif study:
        from cardan.files.study import schema as described

        document = described()
    else:
        document = files.schema()
    if out and out != Path("-"):
        text = json.dumps(document, indent=2, ensure_ascii=False) + "\n"
        write(out, text, replace=force)
    else:
        put_json(document, indent=2)
