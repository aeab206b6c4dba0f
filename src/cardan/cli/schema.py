"""`cardan schema`: what an application file may hold, for editors."""

import json
from pathlib import Path

import click

from cardan.cli.common import OUTPUT_PATH, echo_json, write_output
from cardan.cli.exit_codes import NoRepeatedOptionCommand, exit_with_code_2_on_known_errors


@click.command(cls=NoRepeatedOptionCommand)
@click.option("--out", type=OUTPUT_PATH, help="Into a file.")
@click.option("--contract", is_flag=True, help="Of what --json writes, instead.")
@click.option("--campaign", is_flag=True, help="Of a campaign of recordings, instead.")
@click.option("--study", is_flag=True, help="Of a study of variants in a file of its own, instead.")
@click.option("--force", is_flag=True, help="Replace the file.")
@exit_with_code_2_on_known_errors
def schema(*, out: Path | None, contract: bool, campaign: bool, study: bool, force: bool) -> None:
    """Print the JSON Schema of the application file, for editors."""
    from cardan.application import json_schema

    if contract:
        from cardan.documents.approval_schema import schema as described

        document = described()
    elif campaign:
        from cardan.topics.recording.campaign_schema import campaign_json_schema as described

        document = described()
    elif study:
        from cardan.topics.variants.schema import variant_study_json_schema as described

        document = described()
    else:
        document = json_schema.application_schema()
    if out and out != Path("-"):
        text = json.dumps(document, indent=2, ensure_ascii=False) + "\n"
        write_output(out, text, replace=force)
    else:
        echo_json(document, indent=2)
