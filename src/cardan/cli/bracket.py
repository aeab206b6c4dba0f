"""`cardan bracket`: stresses, hot spots, gauges and modes of a bracket."""

from io import BytesIO
from pathlib import Path

import click

from cardan.cli.common import (
    FILE_ARGUMENT,
    JSON_OPTION,
    OUTPUT_PATH,
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
)

REINFORCED_VARIANT_NAME = "reinforced"
"""The variant that stands next to the original, in a file of its own."""


@click.command(cls=NoRepeatedOptionCommand)
@FILE_ARGUMENT
@JSON_OPTION
@click.option("--vtu", type=OUTPUT_PATH, help="Mesh and fields, for ParaView.")
@click.option("--png", type=OUTPUT_PATH, help="A picture of the worst case.")
@click.option("--html", type=OUTPUT_PATH, help="A page to turn it about in.")
@click.option("--step", type=OUTPUT_PATH, help="Its shape, for CAD; faces carry their names.")
@click.option("--inp", type=OUTPUT_PATH, help="Mesh, held faces and cases, for CalculiX or Abaqus.")
@click.option("--bdf", type=OUTPUT_PATH, help="The same for Nastran, as bulk data.")
@click.option("--all", "every", is_flag=True, help="A row for each check, and all tables.")
@click.option(
    "--optimise",
    is_flag=True,
    help="Search the lightest that lives as long as `optimise` requires.",
)
@limits_and_language_options
@QUIET_OPTION
@exit_with_code_2_on_known_errors
def bracket(
    file: Path,
    *,
    json_out: str | None,
    vtu: Path | None,
    png: Path | None,
    html: Path | None,
    step: Path | None,
    inp: Path | None,
    bdf: Path | None,
    every: bool,
    optimise: bool,
    limits: str | None,
    allow_outside: bool,
    lang: str,
    quiet: bool,
) -> None:
    """Stresses, hot spots, virtual gauges and modes of FILE's bracket.

    Under the driveline's own loads in every state and those given by hand; a reinforced
    variant is listed next to the original. Needs the extra cardan[bracket]. Exit code 0 if
    the original passes or warns, 1 if it fails a limit, 2 for a bad file.

    Prints one screen; --all prints the rest. With --optimise sizes are chosen instead: 0 where
    some live long enough, in bolts that hold, else 1.
    """
    from cardan.approval.approval import approve_application
    from cardan.approval.study import BRACKET_STUDY_NAME
    from cardan.core.errors import DesignError
    from cardan.render.i18n import Translator
    from cardan.render.terminal import summary_lines
    from cardan.render.text_layout import without_colours
    from cardan.topics.bracket import optimisation_presentation as chosen
    from cardan.topics.bracket import presentation_json
    from cardan.topics.bracket.assessment import BracketResult
    from cardan.topics.bracket.calculix_file import inp_text
    from cardan.topics.bracket.nastran_file import bdf_text
    from cardan.topics.bracket.optimisation import find_lightest_bracket
    from cardan.topics.bracket.presentation import terminal_lines
    from cardan.topics.bracket.registration import BracketStudy
    from cardan.topics.bracket.screen_presentation import screen_lines
    from cardan.topics.bracket.solver_deck import solver_deck
    from cardan.topics.bracket.vtk_file import vtu_text

    say = Translator(lang)
    if optimise:
        if vtu or png or html or step or inp or bdf:
            msg = "--optimise chooses sizes: it draws nothing; put them into the file and run again"
            raise DesignError(msg)
        outputs = validate_output_paths(file, limits, json_out=json_out)
        application = read_application(file, limits, allow_outside=allow_outside, outputs=outputs)
        with (
            add_file_position_to_errors(file, application),
            progress_line(say("The bracket"), quiet=quiet) as tell,
        ):
            searched = find_lightest_bracket(
                application, tell=lambda doing: tell.update_study(say.error(doing), 0, 0)
            )
        if json_out is not None:
            write_json(chosen.json_document(application, searched), json_out)
        if json_out != "-":
            echo_lines(chosen.terminal_lines(application, searched, say, width=terminal_width()))
        exit_with_verdicts("pass" if searched.best else "fail")
    beside = {
        f"{option}_beside": _variant_path(path, REINFORCED_VARIANT_NAME)
        for option, path in (("vtu", vtu), ("inp", inp), ("bdf", bdf))
        if path
    }
    outputs = validate_output_paths(
        file, limits, json_out=json_out, vtu=vtu, png=png, html=html, step=step, inp=inp, bdf=bdf,
        **beside,
    )  # fmt: skip
    application = read_application(file, limits, allow_outside=allow_outside, outputs=outputs)
    with (
        add_file_position_to_errors(file, application),
        progress_line(say("The bracket"), quiet=quiet) as tell,
    ):
        approval = approve_application(
            application, (BracketStudy(),),
            tell=lambda doing, done, count: tell.update_study(say.error(doing), done, count),
        )  # fmt: skip
    found: BracketResult = approval.answer_of(BRACKET_STUDY_NAME)
    if json_out is not None:
        write_json(presentation_json.json_document(approval), json_out)
    said = without_colours(summary_lines(approval, say))
    for variant in found.variants:
        first = variant is found.variants[0]
        verdict = said if first else ""
        if vtu:
            name = vtu if first else _variant_path(vtu, variant.name)
            write_output(name, vtu_text(variant, said=verdict))
        if inp or bdf:
            deck = solver_deck(found.bracket, variant, title=found.title, said=verdict)
            for path, text in ((inp, inp_text), (bdf, bdf_text)):
                if path:
                    write_output(path if first else _variant_path(path, variant.name), text(deck))
    if png:
        from cardan.topics.bracket.presentation_picture import write_picture

        drawn = BytesIO()
        write_picture(found, drawn, say=say, over=said)
        write_output(png, drawn.getvalue())
    if html:
        from cardan.topics.bracket import scene as bracket_scene

        write_output(html, bracket_scene.html_page(approval, say=say))
    if step:
        from cardan.physics.fem.solve import export_step_in_subprocess

        write_output(step, export_step_in_subprocess(found.bracket.shape))
    if json_out != "-":
        lines = terminal_lines if every else screen_lines
        echo_lines(lines(approval, say, width=terminal_width()))
    exit_with_verdicts(approval.verdict)


def _variant_path(file: Path, variant: str) -> Path:
    """Return the name of a variant's file, next to that of the original."""
    return file.with_stem(f"{file.stem}-{variant}")
