"""`cardan stability`: the line's speeds held against what vibrates."""

from pathlib import Path

import click

from cardan.cli.common import (
    FILE,
    JSON,
    LANG,
    LIMITS,
    OUT,
    OUTSIDE,
    POSITIVE,
    UNTOLD,
    claim,
    of,
    progress,
    put_lines,
    read,
    write,
    write_json,
)
from cardan.cli.ending import kindly, leave, refuse


@click.command()
@FILE
@JSON
@click.option("--chart", type=OUT, help="SVG, into a file.")
@click.option("--line", help="Which line the chart shows; by default the first.")
@click.option("--all", "every", is_flag=True, help="A row for each check, not for each part.")
@click.option("--axle-inertia", type=POSITIVE, help="Behind the pinion, kg m²; assumed 2.")
@click.option("--axle-stiffness", type=POSITIVE, help="Pinion to there, N m/rad; assumed rigid.")
@click.option("--gearbox-inertia", type=POSITIVE, help="Of the gearbox flange, kg m².")
@click.option("--gearbox-stiffness", type=POSITIVE, help="Engine to there, N m/rad.")
@click.option("--damping-ratio", type=POSITIVE, help="Of the first mode; assumed 0.02.")
@LIMITS
@OUTSIDE
@LANG
@UNTOLD
@kindly
def stability(
    file: Path,
    *,
    json_out: str | None,
    chart: Path | None,
    line: str | None,
    every: bool,
    limits: str | None,
    allow_outside: bool,
    lang: str,
    quiet: bool,
    **surroundings: float | None,
) -> None:
    """Hold each gear's speeds against torsional resonances, parametric zones and flutter.

    What turns at both ends is the file's `torsion`; options go before it, and what nobody
    gives is assumed: without the gearbox's values its flange turns uniformly. Exit code 0
    where everything passes or warns, 1 where something fails, 2 for a bad file.
    """
    from cardan.model.application import Surroundings
    from cardan.report import stability as report
    from cardan.report.language import Language
    from cardan.study.approval import approve
    from cardan.study.finding import VIBRATION
    from cardan.study.studies import VibrationStudy

    say = Language(lang)
    outputs = claim(file, limits, json_out=json_out, chart=chart)
    given = {name: value for name, value in surroundings.items() if value is not None}
    application = read(file, limits, allow_outside=allow_outside, outputs=outputs)
    study = VibrationStudy(Surroundings(**given))
    with of(file, application), progress(say("asking what vibrates"), quiet=quiet) as tell:
        found = approve(application, (study,), tell=tell.study)
    if chart:
        shown = {v.line.name: v for v in found.of(VIBRATION).lines}
        if line is not None and line not in shown:
            refuse(f"there is no line {line}; the file has {', '.join(shown)}")
        write(chart, report.chart(shown[line] if line else next(iter(shown.values()))))
    if json_out is not None:
        write_json(report.document(found), json_out)
    if json_out != "-":
        put_lines(report.text(found, every=every, say=say))
    leave(found.verdict)
