"""`cardan life RECORDING` alone: what the recording holds, and the command to go on."""

import os
from pathlib import Path
from typing import Any

import click

from cardan.cli.common import (
    echo_lines,
    progress_line,
    terminal_width,
    validate_output_paths,
    write_json,
)

_OF_AN_OVERVIEW = {"rate", "time", "group", "dbc"}
"""Options that say how a recording is read, and nothing of what is evaluated."""
_OF_ANY = {"recording", "json_out", "lang", "every", "quiet", "allow_outside"}


def is_overview(context: click.Context) -> bool:
    """Return whether a command line names a recording, and nothing to evaluate of it."""
    given = click.core.ParameterSource.COMMANDLINE
    return all(
        name in _OF_AN_OVERVIEW | _OF_ANY
        for name in context.params
        if context.get_parameter_source(name) == given
    )


def print_overview(
    recording: Path, *, json_out: str | None, say: Any, quiet: bool, **options: Any
) -> None:
    """Print what a recording holds, and the command to go on."""
    from cardan.topics.recording import overview_presentation as shown
    from cardan.topics.recording.presentation import progress_text
    from cardan.topics.recording.recording_overview import next_command, survey_recording

    how = {name: options[name] for name in _OF_AN_OVERVIEW}
    validate_output_paths(recording, *how["dbc"], json_out=json_out)
    with progress_line(say("reading"), quiet=quiet) as line:
        found = survey_recording(
            recording, **how, tell=lambda doing, _, __: line.write(progress_text(doing, say))
        )
    given = how | {"dbc": None}
    reading = [w for file in how["dbc"] for w in ("--dbc", file)]
    reading += [w for name in sorted(given) if given[name] for w in (f"--{name}", f"{given[name]}")]
    command = next_command(found, os.fspath(recording), reading=tuple(reading))
    if json_out is not None:
        write_json(shown.overview_json(found, command), json_out)
    if json_out == "-":
        return
    echo_lines(shown.overview_lines(found, say, width=terminal_width()))
    echo_lines(["", *shown.next_step_lines(command, say)])
