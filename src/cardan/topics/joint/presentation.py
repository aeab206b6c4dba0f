"""One joint by itself as tables, figures and JSON: its numbers, its turn, its curves."""

from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np

from cardan.core.arrays import FloatArray
from cardan.core.units import N, Nm, deg, mm, rpm
from cardan.core.version import __version__
from cardan.physics.kinematics.hooke_joint import PIN_IN_PLANE
from cardan.render.blocks import Table
from cardan.render.chart import DataSeries, line_chart
from cardan.render.i18n import Translator
from cardan.render.svg import Figure
from cardan.topics.joint.single_joint import SingleJoint

CURVE_POINT_COUNT = 361
"""Points of a turn that a curve is drawn through."""

TABLE_STEP_DEG = 15
"""Degrees from row to row of the table round the turn; the second half repeats the first."""

RADIANS_PER_ARCMINUTE = deg / 60

ACCELERATION_APPROXIMATION_TITLES = {
    "omar_eq6": "ITIS Omar, eq. 6", "at_45_deg": "taken at 45 deg", "small_angle": "ω² β²",
}  # fmt: skip
"""How the field's approximations of the acceleration are called in print."""


def report_title(of: SingleJoint, say: Translator) -> str:
    """Return what joint it is."""
    return say(
        "Universal joint at {angle} deg, driven at {speed} rpm",
        angle=say.compact_number(of.angle / deg), speed=say.compact_number(of.speed / rpm),
    )  # fmt: skip


def zero_angle_sentence(of: SingleJoint, say: Translator) -> str:
    """Return where the turn is counted from."""
    if of.pin == PIN_IN_PLANE:
        return say("θ = 0 where the driving pin axis lies in the plane of both shafts.")
    return say("θ = 0 where the driving pin axis is normal to the plane of both shafts.")


def results_table(of: SingleJoint, say: Translator) -> Table:
    """Return the numbers of a joint as a table."""
    return Table(
        caption=say("Driven shaft, and the cross"),
        head=(say("quantity"), say("value"), say("unit"), say("at θ [deg]")),
        rows=tuple(_numbers(of, say)),
        words=1,
    )


def _numbers(of: SingleJoint, say: Translator) -> Iterator[tuple[str, ...]]:
    lead_at, peak_at = (
        half_turn_angles_text(at, say)
        for at in (of.max_lead_input_angles, of.max_acceleration_input_angles)
    )
    slowest, fastest = (rate / rpm for rate in of.driven_speed_range)
    yield (
        say("Angle ahead or behind, largest"),
        f"±{significant_digits_text(of.max_lead_angle / RADIANS_PER_ARCMINUTE, say)}",
        "min",
        lead_at,
    )
    yield say("Speed, least"), significant_digits_text(slowest, say, 5), "rpm", ""
    yield say("Speed, largest"), significant_digits_text(fastest, say, 5), "rpm", ""
    yield say("Irregularity"), significant_digits_text(100 * of.irregularity, say), "%", ""
    largest = f"±{significant_digits_text(of.max_acceleration, say)}"
    yield say("Acceleration, largest"), largest, "rad/s²", peak_at
    for name, known in ACCELERATION_APPROXIMATION_TITLES.items():
        value = of.max_acceleration_by_method[name]
        told = say("none") if value is None else significant_digits_text(value, say)
        yield f"  ({say.translate_if_known(known)})", told, "rad/s²", ""
    yield (
        say("Swing of the cross in each yoke"),
        f"±{significant_digits_text(of.angle / deg, say)}",
        "deg",
        "",
    )
    driving, driven = of.max_cross_rates
    yield (
        say("Rate of the cross in the driving yoke"),
        f"±{significant_digits_text(driving, say)}",
        "rad/s",
        "",
    )
    yield (
        say("Rate of the cross in the driven yoke"),
        f"±{significant_digits_text(driven, say)}",
        "rad/s",
        "",
    )
    if of.driven_torque_range and of.max_secondary_couples:
        low, high = of.driven_torque_range
        yield (
            say("Torque in the driven shaft, least"),
            significant_digits_text(low, say, 5),
            "N·m",
            "",
        )
        yield (
            say("Torque in the driven shaft, largest"),
            significant_digits_text(high, say, 5),
            "N·m",
            "",
        )
        first, second = of.max_secondary_couples
        yield (
            say("Secondary couple on the driving shaft"),
            significant_digits_text(first, say),
            "N·m",
            "",
        )
        yield (
            say("Secondary couple on the driven shaft"),
            significant_digits_text(second, say),
            "N·m",
            "",
        )
    if of.max_journal_force is not None:
        yield (
            say("Force on a journal and its fork arm"),
            significant_digits_text(of.max_journal_force, say),
            "N",
            "",
        )


def half_turn_table(of: SingleJoint, say: Translator) -> Table:
    """Return a joint over half a turn; the other half is the same."""
    c = of.curves_over_turn(half_turn_input_angles())
    columns: list[tuple[str, FloatArray]] = [
        (say("ahead [min]"), c.lead_angle / RADIANS_PER_ARCMINUTE),
        (say("speed [rpm]"), c.driven_speed / rpm),
        (say("acceleration [rad/s²]"), c.driven_acceleration),
        (say("cross in driving yoke [deg]"), c.cross_motion.driving_angle / deg),
        (say("cross in driven yoke [deg]"), c.cross_motion.driven_angle / deg),
    ]
    if c.driven_torque is not None:
        columns.append((say("torque [N·m]"), c.driven_torque))
    return half_turn_columns_table(columns, say)


def half_turn_input_angles() -> FloatArray:
    """Return the input angles of the rows of a table over half a turn, rad."""
    return np.asarray(np.arange(0, 181, TABLE_STEP_DEG) * deg, dtype=np.float64)


def half_turn_columns_table(columns: Sequence[tuple[str, FloatArray]], say: Translator) -> Table:
    """Return named columns over half a turn; the other half is the same."""
    at = np.arange(0, 181, TABLE_STEP_DEG)
    return Table(
        caption=say("Round half a turn; the other half repeats it"),
        head=("θ [deg]", *(name for name, _ in columns)),
        rows=tuple(
            (
                say.compact_number(int(a)),
                *(column_number_text(values[k], values, say) for _, values in columns),
            )
            for k, a in enumerate(at)
        ),
        words=0,
    )


def figures(of: SingleJoint, say: Translator) -> tuple[Figure, ...]:
    """Return the curves round a turn: angle, speed, acceleration, cross, couples."""
    theta = np.linspace(0, 360, CURVE_POINT_COUNT)
    c = of.curves_over_turn(theta * deg)
    drawn: list[tuple[str, str, tuple[tuple[str, FloatArray], ...]]] = [
        (
            say("Angle ahead of the driving shaft"),
            "min",
            (("", c.lead_angle / RADIANS_PER_ARCMINUTE),),
        ),
        (
            say("Speed of the driven shaft"),
            "rpm",
            (
                (say("driven"), c.driven_speed / rpm),
                (say("driving"), np.full(CURVE_POINT_COUNT, of.speed / rpm)),
            ),
        ),
        (say("Acceleration of the driven shaft"), "rad/s²", (("", c.driven_acceleration),)),
        (
            say("Angle of the cross in its yokes"),
            "deg",
            (
                (say("driving yoke"), c.cross_motion.driving_angle / deg),
                (say("driven yoke"), c.cross_motion.driven_angle / deg),
            ),
        ),
        (
            say("Rate of the cross in its yokes"),
            "rad/s",
            (
                (say("driving yoke"), c.cross_motion.driving_rate),
                (say("driven yoke"), c.cross_motion.driven_rate),
            ),
        ),
    ]
    if c.driven_torque is not None and c.secondary_couples is not None:
        drawn.append((say("Torque in the driven shaft"), "N·m", (("", c.driven_torque),)))
        drawn.append((say("Secondary couples"), "N·m", (
            (say("on the driving shaft"), c.secondary_couples[0]),
            (say("on the driven shaft"), c.secondary_couples[1]))))  # fmt: skip
    return curve_charts(theta, drawn, say)


def curve_charts(
    theta: FloatArray,
    drawn: Sequence[tuple[str, str, tuple[tuple[str, FloatArray], ...]]],
    say: Translator,
) -> tuple[Figure, ...]:
    """Return a chart for each title, unit and named curves, over input angles (n,) deg."""
    return tuple(
        line_chart(
            say,
            title=name,
            alt=say(
                "{title}: between {low} and {high} {unit} round a turn",
                title=name, unit=unit,
                low=say.number(min(float(v.min()) for _, v in rows)),
                high=say.number(max(float(v.max()) for _, v in rows)),
            ),
            series=[DataSeries(name=n, x=theta, y=v) for n, v in rows],
            x=(0.0, 360.0),
            x_label="θ [deg]",
            y_label=f"[{unit}]",
        )
        for name, unit, rows in drawn
    )  # fmt: skip


def json_document(of: SingleJoint) -> dict[str, Any]:
    """Return a joint for programs: numbers, and curves at every degree of a turn."""
    theta = np.arange(360.0)
    c = of.curves_over_turn(theta * deg)
    low, high = of.driven_speed_range
    found: dict[str, Any] = {
        "cardan": ".".join(__version__.split(".")[:2]),
        "angle_deg": of.angle / deg,
        "speed_rpm": of.speed / rpm,
        "pin": "plane" if of.pin == PIN_IN_PLANE else "normal",
        "position": {
            "largest_min": of.max_lead_angle / RADIANS_PER_ARCMINUTE,
            "at_deg": (of.max_lead_input_angles / deg).tolist(),
        },
        "speed": {
            "least_rpm": low / rpm,
            "largest_rpm": high / rpm,
            "irregularity": of.irregularity,
        },
        "acceleration": {
            "largest_rad_s2": of.max_acceleration,
            "at_deg": (of.max_acceleration_input_angles / deg).tolist(),
            "approximations_rad_s2": {
                name: of.max_acceleration_by_method[name]
                for name in ACCELERATION_APPROXIMATION_TITLES
            },
        },
        "cross": {
            "swing_deg": of.angle / deg,
            "driving_rate_rad_s": of.max_cross_rates[0],
            "driven_rate_rad_s": of.max_cross_rates[1],
        },
        "curves": {
            "theta_deg": theta.tolist(),
            "ahead_min": (c.lead_angle / RADIANS_PER_ARCMINUTE).tolist(),
            "speed_rpm": (c.driven_speed / rpm).tolist(),
            "acceleration_rad_s2": c.driven_acceleration.tolist(),
            "driving_yoke_deg": (c.cross_motion.driving_angle / deg).tolist(),
            "driven_yoke_deg": (c.cross_motion.driven_angle / deg).tolist(),
            "driving_yoke_rad_s": c.cross_motion.driving_rate.tolist(),
            "driven_yoke_rad_s": c.cross_motion.driven_rate.tolist(),
        },
    }
    if (
        of.torque is not None
        and of.driven_torque_range
        and of.max_secondary_couples
        and c.driven_torque is not None
    ):
        found["torque"] = {
            "driving_Nm": of.torque / Nm,
            "least_Nm": of.driven_torque_range[0] / Nm,
            "largest_Nm": of.driven_torque_range[1] / Nm,
            "driving_couple_Nm": of.max_secondary_couples[0] / Nm,
            "driven_couple_Nm": of.max_secondary_couples[1] / Nm,
        }
        found["curves"]["torque_Nm"] = c.driven_torque.tolist()
    if of.across is not None and of.max_journal_force is not None:
        found["cross"] |= {"across_mm": of.across / mm, "journal_force_N": of.max_journal_force / N}
    return found


def half_turn_angles_text(of: FloatArray, say: Translator) -> str:
    """Return the angles of half a turn; the other half repeats it."""
    return "; ".join(say.compact_number(round(float(a), 2)) for a in of[:2] / deg)


def significant_digits_text(value: float, say: Translator, digits: int = 4) -> str:
    """Return a number with some figures, those behind the point kept."""
    if value == 0:
        return "0"
    size = int(np.floor(np.log10(abs(value))))
    return say.with_decimal_sign(f"{value:.{max(0, digits - 1 - size)}f}")


def column_number_text(value: float, of: FloatArray, say: Translator) -> str:
    """Return a value of a column, all with the same decimals; what is left of nothing is 0."""
    span = float(np.ptp(of)) or abs(float(of[0])) or 1.0
    decimals = max(0, 3 - int(np.floor(np.log10(span))))
    return say.with_decimal_sign(f"{round(float(value), decimals) + 0.0:.{decimals}f}")
