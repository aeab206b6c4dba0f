"""`cardan stability`: the line's speeds held against what vibrates."""

from pathlib import Path

import click

from cardan.cli.common import (
    FILE_ARGUMENT,
    JSON_OPTION,
    OUTPUT_PATH,
    POSITIVE_FLOAT,
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
    raise_command_error,
)


@click.command(cls=NoRepeatedOptionCommand)
@FILE_ARGUMENT
@JSON_OPTION
@click.option("--chart", type=OUTPUT_PATH, help="SVG, into a file.")
@click.option("--gear", help="Which gear the chart shows; by default the one nearest to direct.")
@click.option("--all", "every", is_flag=True, help="A row for each check, and all tables.")
@click.option("--axle-inertia", type=POSITIVE_FLOAT, help="Behind the pinion, at its speed, kg m².")
@click.option(
    "--axle-stiffness", type=POSITIVE_FLOAT, help="Half shafts at the pinion's speed, N m/rad."
)
@click.option("--gearbox-inertia", type=POSITIVE_FLOAT, help="Of the gearbox output, kg m².")
@click.option(
    "--gearbox-stiffness", type=POSITIVE_FLOAT, help="Of the gearbox, at its output, N m/rad."
)
@click.option(
    "--damping-ratio",
    type=click.FloatRange(1e-5, 1, max_open=True),
    help="Of the springs of steel; half their loss factor.",
)
@limits_and_language_options
@QUIET_OPTION
@exit_with_code_2_on_known_errors
def stability(
    file: Path,
    *,
    json_out: str | None,
    chart: Path | None,
    gear: str | None,
    every: bool,
    limits: str | None,
    allow_outside: bool,
    lang: str,
    quiet: bool,
    **surroundings: float | None,
) -> None:
    """Hold the whole vehicle's torsion, its starts from rest and hung shafts against limits.

    Engine to road in every gear and state: modes, resonances at speeds that exist, vibratory
    torque at its true peak, parametric zones, launches. Parts are the file's; a part not given
    has a typical value, reported with its effect on the result. Exit code 0 if everything
    passes or warns, 1 if something fails, 2 for a bad file. Prints one screen; --all prints the
    rest.
    """
    from cardan.approval.approval import approve_application
    from cardan.approval.study import VIBRATION_STUDY_NAME
    from cardan.model.application import GearboxAndAxleRotors
    from cardan.render.i18n import Translator
    from cardan.topics.torsion.presentation import text_lines
    from cardan.topics.torsion.presentation_figures import campbell_svg
    from cardan.topics.torsion.presentation_json import json_document
    from cardan.topics.torsion.registration import VibrationStudy
    from cardan.topics.torsion.screen_presentation import screen_lines

    say = Translator(lang)
    if chart is not None and chart.suffix.lower() in {".png", ".pdf", ".jpg", ".jpeg", ".gif"}:
        raise_command_error(f"--chart draws SVG: {chart.with_suffix('.svg')} instead of {chart}")
    if gear is not None and chart is None:
        raise_command_error("--gear chooses the gear of a chart: add --chart OUT")
    outputs = validate_output_paths(file, limits, json_out=json_out, chart=chart)
    given = {name: value for name, value in surroundings.items() if value is not None}
    application = read_application(file, limits, allow_outside=allow_outside, outputs=outputs)
    study = VibrationStudy(GearboxAndAxleRotors(**given))
    with (
        add_file_position_to_errors(file, application),
        progress_line(say("calculating vibration"), quiet=quiet) as tell,
    ):
        found = approve_application(application, (study,), tell=tell.update_study)
    if chart:
        answer = found.answer_of(VIBRATION_STUDY_NAME)
        gears = answer.drivetrain.gears
        if gear is not None and gear not in gears:
            raise_command_error(f"there is no gear {gear}; the file has {', '.join(gears)}")
        write_output(chart, campbell_svg(answer, gear))
    if json_out is not None:
        write_json(json_document(found), json_out)
    if json_out != "-":
        wide = terminal_width()
        if every:
            echo_lines(text_lines(found, say=say, width=wide))
        else:
            echo_lines(screen_lines(found, say, width=wide))
    exit_with_verdicts(found.verdict)
