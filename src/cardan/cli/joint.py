"""`cardan joint`: one universal joint by itself."""

from pathlib import Path
from typing import Any

import click

from cardan.base.errors import DesignError
from cardan.base.units import UNITS
from cardan.cli.common import JSON, LANG, OUT, claim, publish, put_lines, screen, write_json
from cardan.cli.ending import Once, kindly


class Measure(click.ParamType[float]):
    """A number with its unit, the first of these where none is written."""

    name = "number"

    def __init__(self, *units: str) -> None:
        self.units = {unit: UNITS[unit] for unit in units}

    def convert(self, value: Any, param: Any, ctx: Any) -> float:
        """Return the number, SI."""
        from cardan.border.byhand import measure

        try:
            return measure(str(value), self.units)
        except DesignError as error:
            self.fail(str(error), param, ctx)


@click.command(cls=Once)
@click.option(
    "--angle",
    required=True,
    type=Measure("deg", "rad"),
    metavar="ANGLE",
    help="Between the shafts: 4.5deg, 4deg30min, 4°30', 0.08rad.",
)
@click.option(
    "--speed",
    required=True,
    type=Measure("rpm", "rad_s"),
    metavar="SPEED",
    help="Of the driving shaft: 3600rpm, 377rad/s.",
)
@click.option(
    "--torque",
    type=Measure("Nm", "kNm", "lbft"),
    metavar="TORQUE",
    help="In the driving shaft: 1000Nm, 1.2kNm. Adds secondary couples.",
)
@click.option(
    "--across",
    type=Measure("mm", "m", "in"),
    metavar="LENGTH",
    help="Between opposite needle rows: 80mm, 3 1/8in. Adds the journals' force.",
)
@click.option(
    "--pin",
    type=click.Choice(["plane", "normal"]),
    default="plane",
    show_default=True,
    help="Where the driving pin axis stands at θ = 0, to the plane of the shafts.",
)
@JSON
@click.option("--html", metavar="OUT", type=OUT, help="A page with the curves.")
@click.option("--pdf", metavar="OUT", type=OUT, help="A document with the curves.")
@LANG
@kindly
def joint(
    *,
    angle: float,
    speed: float,
    torque: float | None,
    across: float | None,
    pin: str,
    json_out: str | None,
    html: Path | None,
    pdf: Path | None,
    lang: str,
) -> None:
    """Say what one universal joint does: position, speed, acceleration, motion of its cross.

    No file is needed. Massless and rigid, its driving shaft turning uniformly.
    """
    from cardan.kinematics.joint import IN_PLANE, NORMAL
    from cardan.report import one_joint
    from cardan.report.language import Language
    from cardan.study.one_joint import OneJoint

    say = Language(lang)
    claim(json_out=json_out, html=html, pdf=pdf)
    found = OneJoint(
        angle=angle, speed=speed, torque=torque, across=across,
        pin=IN_PLANE if pin == "plane" else NORMAL,
    )  # fmt: skip
    if json_out is not None:
        write_json(one_joint.document(found), json_out)
    if html or pdf:
        publish(one_joint.story(found, say), say=say, html=html, pdf=pdf, quiet=True)
    if json_out != "-":
        put_lines(one_joint.terminal(found, say, width=screen()))
