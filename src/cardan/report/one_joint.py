"""What is told of one joint by itself: its numbers, its turn, its curves."""

from collections.abc import Iterator
from typing import Any

import numpy as np

from cardan import __version__
from cardan.base.arrays import FloatArray
from cardan.base.units import N, Nm, deg, mm, rpm
from cardan.kinematics.joint import IN_PLANE
from cardan.report.blocks import Chapter, Figures, Story, Table, Text
from cardan.report.chart import Series, plot
from cardan.report.language import EN, Language
from cardan.report.screen import WIDTH, folded
from cardan.report.svg import Figure
from cardan.report.terminal import block
from cardan.study.one_joint import OneJoint

ROUND = 361
"""Points of a turn that a curve is drawn through."""

STEP = 15
"""Degrees from row to row of the table round the turn; the second half repeats the first."""

arcmin = deg / 60

APPROXIMATIONS = {
    "omar_eq6": "ITIS Omar, eq. 6", "at_45_deg": "taken at 45 deg", "small_angle": "ω² β²",
}  # fmt: skip
"""How the field's approximations of the acceleration are called in print."""


def terminal(of: OneJoint, say: Language = EN, *, width: int = WIDTH) -> Iterator[str]:
    """Yield a joint line by line of text."""
    yield from folded([title(of, say), origin(of, say)], width)
    yield from block(numbers(of, say), width)
    yield from block(round_the_turn(of, say), width)


def story(of: OneJoint, say: Language) -> Story:
    """Return a joint as a report."""
    say = say.typeset
    return Story(
        language=say.code,
        title=title(of, say),
        subtitle=say("One universal joint by itself"),
        grade="",
        verdict="",
        facts=((say("Made with"), f"cardan {__version__}"),),
        chapters=(
            Chapter(
                title=say("What it does"),
                blocks=(numbers(of, say), Text(paragraphs=(origin(of, say),))),
            ),
            Chapter(title=say("Round the turn"), blocks=(Figures(figures=figures(of, say)),
                                                         round_the_turn(of, say))),
        ),
    )  # fmt: skip


def title(of: OneJoint, say: Language) -> str:
    """Return what joint it is."""
    return say(
        "Universal joint at {angle} deg, driven at {speed} rpm",
        angle=say.short(of.angle / deg), speed=say.short(of.speed / rpm),
    )  # fmt: skip


def origin(of: OneJoint, say: Language) -> str:
    """Return where the turn is counted from."""
    if of.pin == IN_PLANE:
        return say("θ = 0 where the driving pin axis lies in the plane of both shafts.")
    return say("θ = 0 where the driving pin axis is normal to the plane of both shafts.")


def numbers(of: OneJoint, say: Language) -> Table:
    """Return the numbers of a joint as a table."""
    return Table(
        caption=say("Driven shaft, and the cross"),
        head=(say("quantity"), say("value"), say("unit"), say("at θ [deg]")),
        rows=tuple(_numbers(of, say)),
        words=1,
    )


def _numbers(of: OneJoint, say: Language) -> Iterator[tuple[str, ...]]:
    lead_at, peak_at = (_angles(at, say) for at in (of.lead_at, of.acceleration_at))
    slowest, fastest = (rate / rpm for rate in of.speeds)
    yield (
        say("Angle ahead or behind, largest"),
        f"±{_figures(of.lead / arcmin, say)}",
        "min",
        lead_at,
    )
    yield say("Speed, least"), _figures(slowest, say, 5), "rpm", ""
    yield say("Speed, largest"), _figures(fastest, say, 5), "rpm", ""
    yield say("Irregularity"), _figures(100 * of.irregularity, say), "%", ""
    largest = f"±{_figures(of.acceleration, say)}"
    yield say("Acceleration, largest"), largest, "rad/s²", peak_at
    for name, known in APPROXIMATIONS.items():
        value = of.accelerations[name]
        told = say("none") if value is None else _figures(value, say)
        yield f"  ({say.given(known)})", told, "rad/s²", ""
    yield say("Swing of the cross in each yoke"), f"±{_figures(of.angle / deg, say)}", "deg", ""
    driving, driven = of.cross_rates
    yield say("Rate of the cross in the driving yoke"), f"±{_figures(driving, say)}", "rad/s", ""
    yield say("Rate of the cross in the driven yoke"), f"±{_figures(driven, say)}", "rad/s", ""
    if of.torques and of.couples:
        low, high = of.torques
        yield say("Torque in the driven shaft, least"), _figures(low, say, 5), "N·m", ""
        yield say("Torque in the driven shaft, largest"), _figures(high, say, 5), "N·m", ""
        first, second = of.couples
        yield say("Secondary couple on the driving shaft"), _figures(first, say), "N·m", ""
        yield say("Secondary couple on the driven shaft"), _figures(second, say), "N·m", ""
    if of.journal_force is not None:
        yield say("Force on a journal and its fork arm"), _figures(of.journal_force, say), "N", ""


def round_the_turn(of: OneJoint, say: Language) -> Table:
    """Return a joint over half a turn; the other half is the same."""
    at = np.arange(0, 181, STEP)
    c = of.round(np.asarray(at * deg, dtype=np.float64))
    columns: list[tuple[str, FloatArray]] = [
        (say("ahead [min]"), c.lead / arcmin),
        (say("speed [rpm]"), c.speed / rpm),
        (say("acceleration [rad/s²]"), c.acceleration),
        (say("cross in driving yoke [deg]"), c.cross.driving_angle / deg),
        (say("cross in driven yoke [deg]"), c.cross.driven_angle / deg),
    ]
    if c.torque is not None:
        columns.append((say("torque [N·m]"), c.torque))
    return Table(
        caption=say("Round half a turn; the other half repeats it"),
        head=("θ [deg]", *(name for name, _ in columns)),
        rows=tuple(
            (say.short(int(a)), *(_digits(values[k], values, say) for _, values in columns))
            for k, a in enumerate(at)
        ),
        words=0,
    )


def figures(of: OneJoint, say: Language) -> tuple[Figure, ...]:
    """Return the curves round a turn: angle, speed, acceleration, cross, couples."""
    theta = np.linspace(0, 360, ROUND)
    c = of.round(theta * deg)
    drawn: list[tuple[str, str, tuple[tuple[str, FloatArray], ...]]] = [
        (say("Angle ahead of the driving shaft"), "min", (("", c.lead / arcmin),)),
        (say("Speed of the driven shaft"), "rpm", (
            (say("driven"), c.speed / rpm), (say("driving"), np.full(ROUND, of.speed / rpm)))),
        (say("Acceleration of the driven shaft"), "rad/s²", (("", c.acceleration),)),
        (say("Angle of the cross in its yokes"), "deg", (
            (say("driving yoke"), c.cross.driving_angle / deg),
            (say("driven yoke"), c.cross.driven_angle / deg))),
        (say("Rate of the cross in its yokes"), "rad/s", (
            (say("driving yoke"), c.cross.driving_rate),
            (say("driven yoke"), c.cross.driven_rate))),
    ]  # fmt: skip
    if c.torque is not None and c.couples is not None:
        drawn.append((say("Torque in the driven shaft"), "N·m", (("", c.torque),)))
        drawn.append((say("Secondary couples"), "N·m", (
            (say("on the driving shaft"), c.couples[0]),
            (say("on the driven shaft"), c.couples[1]))))  # fmt: skip
    return tuple(
        plot(
            say,
            title=name,
            alt=say(
                "{title}: between {low} and {high} {unit} round a turn",
                title=name, unit=unit,
                low=say.number(min(float(v.min()) for _, v in rows)),
                high=say.number(max(float(v.max()) for _, v in rows)),
            ),
            series=[Series(name=n, x=theta, y=v) for n, v in rows],
            x=(0.0, 360.0),
            x_label="θ [deg]",
            y_label=f"[{unit}]",
        )
        for name, unit, rows in drawn
    )  # fmt: skip


def document(of: OneJoint) -> dict[str, Any]:
    """Return a joint for programs: numbers, and curves at every degree of a turn."""
    theta = np.arange(360.0)
    c = of.round(theta * deg)
    low, high = of.speeds
    found: dict[str, Any] = {
        "cardan": ".".join(__version__.split(".")[:2]),
        "angle_deg": of.angle / deg,
        "speed_rpm": of.speed / rpm,
        "pin": "plane" if of.pin == IN_PLANE else "normal",
        "position": {"largest_min": of.lead / arcmin, "at_deg": (of.lead_at / deg).tolist()},
        "speed": {"least_rpm": low / rpm, "largest_rpm": high / rpm,
                  "irregularity": of.irregularity},
        "acceleration": {
            "largest_rad_s2": of.acceleration,
            "at_deg": (of.acceleration_at / deg).tolist(),
            "approximations_rad_s2": {name: of.accelerations[name] for name in APPROXIMATIONS},
        },
        "cross": {
            "swing_deg": of.angle / deg,
            "driving_rate_rad_s": of.cross_rates[0],
            "driven_rate_rad_s": of.cross_rates[1],
        },
        "curves": {
            "theta_deg": theta.tolist(),
            "ahead_min": (c.lead / arcmin).tolist(),
            "speed_rpm": (c.speed / rpm).tolist(),
            "acceleration_rad_s2": c.acceleration.tolist(),
            "driving_yoke_deg": (c.cross.driving_angle / deg).tolist(),
            "driven_yoke_deg": (c.cross.driven_angle / deg).tolist(),
            "driving_yoke_rad_s": c.cross.driving_rate.tolist(),
            "driven_yoke_rad_s": c.cross.driven_rate.tolist(),
        },
    }  # fmt: skip
    if of.torque is not None and of.torques and of.couples and c.torque is not None:
        found["torque"] = {
            "driving_Nm": of.torque / Nm,
            "least_Nm": of.torques[0] / Nm,
            "largest_Nm": of.torques[1] / Nm,
            "driving_couple_Nm": of.couples[0] / Nm,
            "driven_couple_Nm": of.couples[1] / Nm,
        }
        found["curves"]["torque_Nm"] = c.torque.tolist()
    if of.across is not None and of.journal_force is not None:
        found["cross"] |= {"across_mm": of.across / mm, "journal_force_N": of.journal_force / N}
    return found


def _angles(of: FloatArray, say: Language) -> str:
    """Return the angles of half a turn; the other half repeats it."""
    return "; ".join(say.short(round(float(a), 2)) for a in of[:2] / deg)


def _figures(value: float, say: Language, digits: int = 4) -> str:
    """Return a number with some figures, those behind the point kept."""
    if value == 0:
        return "0"
    size = int(np.floor(np.log10(abs(value))))
    return say.pointed(f"{value:.{max(0, digits - 1 - size)}f}")


def _digits(value: float, of: FloatArray, say: Language) -> str:
    """Return a value of a column, all with the same decimals; what is left of nothing is 0."""
    span = float(np.ptp(of)) or abs(float(of[0])) or 1.0
    decimals = max(0, 3 - int(np.floor(np.log10(span))))
    return say.pointed(f"{round(float(value), decimals) + 0.0:.{decimals}f}")
