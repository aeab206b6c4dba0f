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
    screen,
    write,
    write_json,
)
from cardan.cli.ending import Once, kindly, leave, refuse


@click.command(cls=Once)
@FILE
@JSON
@click.option("--chart", type=OUT, help="SVG, into a file.")
@click.option("--gear", help="Which gear the chart shows; by default the one nearest to direct.")
@click.option("--all", "every", is_flag=True, help="A row for each check, not for each part.")
@click.option("--axle-inertia", type=POSITIVE, help="Behind the pinion, at its speed, kg m².")
@click.option("--axle-stiffness", type=POSITIVE, help="Half shafts at the pinion's speed, N m/rad.")
@click.option("--gearbox-inertia", type=POSITIVE, help="Of the gearbox output, kg m².")
@click.option("--gearbox-stiffness", type=POSITIVE, help="Of the gearbox, at its output, N m/rad.")
@click.option(
    "--damping-ratio",
    type=click.FloatRange(1e-5, 1, max_open=True),
    help="Of the springs of steel; half their loss factor.",
)
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
    torque at its true peak, parametric zones, launches. Parts are the file's; what nobody
    gives is a typical value, told with how the answer moves with it. Exit code 0 where
    everything passes or warns, 1 where something fails, 2 for a bad file.
    """
    from cardan.model.application import Surroundings
    from cardan.report import stability as report
    from cardan.report.language import Language
    from cardan.study.approval import approve
    from cardan.study.finding import VIBRATION
    from cardan.study.studies import VibrationStudy

    say = Language(lang)
    if chart is not None and chart.suffix.lower() in {".png", ".pdf", ".jpg", ".jpeg", ".gif"}:
        refuse(f"--chart draws SVG: {chart.with_suffix('.svg')} instead of {chart}")
    if gear is not None and chart is None:
        refuse("--gear says which gear a chart shows: give --chart OUT beside it")
    outputs = claim(file, limits, json_out=json_out, chart=chart)
    given = {name: value for name, value in surroundings.items() if value is not None}
    application = read(file, limits, allow_outside=allow_outside, outputs=outputs)
    study = VibrationStudy(Surroundings(**given))
    with of(file, application), progress(say("asking what vibrates"), quiet=quiet) as tell:
        found = approve(application, (study,), tell=tell.study)
    if chart:
        answer = found.of(VIBRATION)
        gears = answer.drivetrain.gears
        if gear is not None and gear not in gears:
            refuse(f"there is no gear {gear}; the file has {', '.join(gears)}")
        write(chart, report.chart(answer, gear))
    if json_out is not None:
        write_json(report.document(found), json_out)
    if json_out != "-":
        put_lines(report.text(found, every=every, say=say, width=screen()))
    leave(found.verdict)
