"""`cardan joint`: one universal joint by itself, or two with a shaft between them."""

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
from cardan.cli.exit_codes import (
    NoRepeatedOptionCommand,
    exit_with_code_2_on_known_errors,
    exit_with_verdicts,
)
from cardan.cli.quantity import QuantityParam
from cardan.topics.joint.argument_units import (
    ACCELERATION_UNITS,
    ANGLE_UNITS,
    LENGTH_UNITS,
    SHARE_UNITS,
    SPEED_UNITS,
    TORQUE_UNITS,
)


@click.command(cls=NoRepeatedOptionCommand)
@click.option(
    "--angle",
    type=QuantityParam(*ANGLE_UNITS),
    metavar="ANGLE",
    help="Between the shafts: 4.5deg, 4deg30min, 4°30', 0.08rad. Without it: the largest within "
    "the limits.",
)
@click.option(
    "--speed",
    required=True,
    type=QuantityParam(*SPEED_UNITS),
    metavar="SPEED",
    help="Of the driving shaft: 3600rpm, 377rad/s.",
)
@click.option(
    "--angle2",
    type=QuantityParam(*ANGLE_UNITS),
    metavar="ANGLE",
    help="Of a second joint behind the driven shaft. Adds the output of both.",
)
@click.option(
    "--phase",
    type=QuantityParam(*ANGLE_UNITS),
    metavar="ANGLE",
    help="Yoke phase of the shaft between the joints; 0deg by default.",
)
@click.option(
    "--plane-angle",
    type=QuantityParam(*ANGLE_UNITS),
    metavar="ANGLE",
    help="From the plane of joint 1 to that of joint 2: 0deg is W, the default, 180deg is Z.",
)
@click.option(
    "--acceleration-limit",
    type=QuantityParam(*ACCELERATION_UNITS),
    metavar="LIMIT",
    help="Largest acceleration of the output: 1000rad/s2. Adds the largest angle within it.",
)
@click.option(
    "--irregularity-limit",
    type=QuantityParam(*SHARE_UNITS),
    metavar="LIMIT",
    help="Largest irregularity of the output speed: 0.5%. Adds the largest angle within it.",
)
@click.option(
    "--torque",
    type=QuantityParam(*TORQUE_UNITS),
    metavar="TORQUE",
    help="In the driving shaft: 1000Nm, 1.2kNm. Adds secondary couples.",
)
@click.option(
    "--across",
    type=QuantityParam(*LENGTH_UNITS),
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
    pin: str,
    json_out: str | None,
    reports: ReportPaths,
    lang: str,
    **arguments: float,
) -> None:
    """Compute a universal joint, or two: position, speed, acceleration, cross, limits.

    No file is needed. Massless and rigid, the driving shaft turning uniformly. With a second
    joint also the output of both, the equivalent angle and the yoke phase that leaves least.
    Exit code 1 if the output is beyond a limit given.
    """
    from cardan.physics.kinematics.hooke_joint import PIN_IN_PLANE, PIN_NORMAL_TO_PLANE
    from cardan.render.i18n import Translator
    from cardan.topics.joint import result_presentation as presentation
    from cardan.topics.joint.joint_result import joint_result

    say = Translator(lang)
    validate_output_paths(json_out=json_out, **reports)
    found = joint_result(pin=PIN_IN_PLANE if pin == "plane" else PIN_NORMAL_TO_PLANE, **arguments)
    if json_out is not None:
        write_json(presentation.json_document(found), json_out)
    if reports:
        write_report(presentation.joint_report(found, say), reports, say=say, quiet=True)
    if json_out != "-":
        echo_lines(presentation.text_lines(found, say, width=terminal_width()))
    exit_with_verdicts("pass" if found.keeps_limits else "fail")
