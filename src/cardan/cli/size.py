"""`cardan size`: which other tube, joint, split or bearing place would do."""

from pathlib import Path

import click

from cardan.cli.common import (
    FILE_ARGUMENT,
    JSON_OPTION,
    QUIET_OPTION,
    add_file_position_to_errors,
    echo_lines,
    limits_and_language_options,
    progress_line,
    read_application,
    validate_output_paths,
    write_json,
)
from cardan.cli.exit_codes import (
    NoRepeatedOptionCommand,
    exit_with_code_2_on_known_errors,
    exit_with_verdicts,
)


@click.command(cls=NoRepeatedOptionCommand)
@FILE_ARGUMENT
@JSON_OPTION
@limits_and_language_options
@click.option("--line", help="Only this line.")
@QUIET_OPTION
@exit_with_code_2_on_known_errors
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
    bearing that corrects what does not pass and makes nothing else worse; parts are of the
    file's own catalogues and those shipped. Exit code as a check with all of them in place.
    """
    from cardan.render.i18n import Translator
    from cardan.topics.design import sizing_presentation as told
    from cardan.topics.design.sizing import propose_parts

    say = Translator(lang)
    outputs = validate_output_paths(file, limits, json_out=json_out)
    application = read_application(file, limits, allow_outside=allow_outside, outputs=outputs)
    with (
        add_file_position_to_errors(file, application),
        progress_line(say("trying other parts"), quiet=quiet) as tell,
    ):
        found = propose_parts(application, line=line, tell=tell)
    if json_out is not None:
        write_json(told.json_document(found), json_out)
    if json_out != "-":
        echo_lines(told.text_lines(found, say))
    exit_with_verdicts(found.approval.verdict)
