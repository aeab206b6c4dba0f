"""`cardan verify`: published cases, recomputed on this machine."""

import click

from cardan.cli.common import (
    JSON_OPTION,
    LANG_OPTION,
    echo_lines,
    terminal_width,
    validate_output_paths,
    write_json,
)
from cardan.cli.exit_codes import NoRepeatedOptionCommand, exit_with_code_2_on_known_errors


@click.command(cls=NoRepeatedOptionCommand)
@JSON_OPTION
@LANG_OPTION
@exit_with_code_2_on_known_errors
def verify(*, json_out: str | None, lang: str) -> None:
    """Recompute published cases on this machine and show both numbers.

    Exit code 1 where one does not agree to its printed digits.
    """
    from cardan.render.i18n import Translator
    from cardan.topics.verification.presentation import (
        software_benchmark_case_lines,
        software_benchmark_cases_json,
    )
    from cardan.topics.verification.published_cases import benchmark_cases

    validate_output_paths(json_out=json_out)
    cases = benchmark_cases()
    if json_out is not None:
        write_json(software_benchmark_cases_json(cases), json_out)
    if json_out != "-":
        echo_lines(software_benchmark_case_lines(cases, Translator(lang), width=terminal_width()))
    raise SystemExit(0 if all(c.is_within_tolerance for c in cases) else 1)
