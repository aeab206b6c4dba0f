"""`cardan joint`: one universal joint by itself."""

import click

from cardan.cli.common import (
    JSON_OPTION,
    LANG_OPTION,
    ReportPaths,
    echo_lines,
    report_options,
    terminal_width,
    validate_output_paths,
    write_json,
    write_report,
)
from cardan.cli.exit_codes import NoRepeatedOptionCommand, exit_with_code_2_on_known_errors
from cardan.cli.quantity import QuantityParam


@click.command(cls=NoRepeatedOptionCommand)
@click.option(
    "--angle",
    required=True,
    type=QuantityParam("deg", "rad"),
    metavar="ANGLE",
    help="Between the shafts: 4.5deg, 4deg30min, 4°30', 0.08rad.",
)
@click.option(
    "--speed",
    required=True,
    type=QuantityParam("rpm", "rad_s"),
    metavar="SPEED",
    help="Of the driving shaft: 3600rpm, 377rad/s.",
)
@click.option(
    "--torque",
    type=QuantityParam("Nm", "kNm", "lbft"),
    metavar="TORQUE",
    help="In the driving shaft: 1000Nm, 1.2kNm. Adds secondary couples.",
)
@click.option(
    "--across",
    type=QuantityParam("mm", "m", "in"),
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
@JSON_OPTION
@report_options
@LANG_OPTION
@exit_with_code_2_on_known_errors
def joint(
    *,
    angle: float,
    speed: float,
    torque: float | None,
    across: float | None,
    pin: str,
    json_out: str | None,
    reports: ReportPaths,
    lang: str,
) -> None:
    """Say what one universal joint does: position, speed, acceleration, motion of its cross.

    No file is needed. Massless and rigid, its driving shaft turning uniformly.
    """
    from cardan.physics.kinematics.hooke_joint import PIN_IN_PLANE, PIN_NORMAL_TO_PLANE
    from cardan.render.i18n import Translator
    from cardan.topics.joint import presentation as one_joint
    from cardan.topics.joint.single_joint import SingleJoint

    say = Translator(lang)
    validate_output_paths(json_out=json_out, **reports)
    found = SingleJoint(
        angle=angle, speed=speed, torque=torque, across=across,
        pin=PIN_IN_PLANE if pin == "plane" else PIN_NORMAL_TO_PLANE,
    )  # fmt: skip
    if json_out is not None:
        write_json(one_joint.json_document(found), json_out)
    if reports:
        write_report(one_joint.joint_report(found, say), reports, say=say, quiet=True)
    if json_out != "-":
        echo_lines(one_joint.text_lines(found, say, width=terminal_width()))
