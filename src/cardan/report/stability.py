"""Show a line's vibration: terminal, JSON, and the chart of speeds against frequencies."""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from itertools import groupby
from math import pi
from typing import Any

import numpy as np

from cardan.base.part import Part
from cardan.base.units import rpm
from cardan.base.verdict import GRADES, Check, Grade
from cardan.quantity.quantities import QUANTITIES
from cardan.report import svg
from cardan.report.chart import Chart, Level, Series, plot
from cardan.report.contract import CONTRACT, check, coverage, plain
from cardan.report.language import EN, Language
from cardan.report.svg import GRADED, INK, PALETTE, Figure
from cardan.report.terminal import BOLD, COLOURS, PLAIN, summary
from cardan.study.approval import Approval
from cardan.study.finding import VIBRATION
from cardan.study.stability import ORDERS, LineVibration, Stability

KEYS = {
    "axle_inertia": "axle_inertia_kgm2",
    "axle_stiffness": "axle_stiffness_Nm_rad",
    "gearbox_inertia": "gearbox_inertia_kgm2",
    "gearbox_stiffness": "gearbox_stiffness_Nm_rad",
    "damping_ratio": "damping_ratio",
    "rubber_loss": "rubber_loss",
}
"""What the document calls what turns with the lines."""


def text(of: Approval, *, every: bool = False, say: Language = EN) -> Iterator[str]:
    """Yield the verdict, the worst check of each part and each line's numbers.

    With `every` each check has its row.
    """
    found: Stability = of.of(VIBRATION)
    yield from summary(of, say)
    yield say("limits: {profile}", profile=of.application.profile)
    yield from basis(found, say)
    rows = list(of.checks) if every else list(worst_of_parts(of.checks))
    yield ""
    yield (
        f"{BOLD}{'':6}{say('quantity'):<34}{say('part'):<24}{say('where it is worst'):<24}"
        f"{say('value'):>9}  {say('limit'):<12}{PLAIN}"
    )
    for c in sorted(rows, key=lambda c: (-GRADES.index(c.grade), c.quantity, c.margin)):
        q = QUANTITIES[c.quantity]
        sense = say("outside") if c.limit.band else c.limit.sense
        yield (
            f"{_coloured(c.grade, say, 6)}{say.name(c.quantity):<34.33}"
            f"{say.part(c.part):<24.23}{say.occasion(c.when):<24.23}"
            f"{say.number(c.value / q.factor):>9}  {sense} {say.number(c.bound / q.factor)} "
            f"{q.unit_name}"
        )
    for line in found.lines:
        yield from _line(line, say)


def document(of: Approval) -> dict[str, Any]:
    """Return the JSON document: verdict, checks and each line's numbers, units in the keys."""
    found: Stability = of.of(VIBRATION)
    s = found.surroundings
    return plain(
        {
            "cardan": CONTRACT,
            "application": of.application.title,
            "verdict": of.verdict,
            "profile": of.application.profile,
            "given": {key: getattr(s, name) for name, key in KEYS.items() if name in found.given},
            "assumed": {
                key: getattr(s, name) for name, key in KEYS.items() if name not in found.given
            },
            "lines": [
                {
                    "name": v.line.name,
                    "torsional_frequencies_Hz": (v.frequencies / (2 * pi)).tolist(),
                    "gears": [
                        {"name": str(gear), "speed_rpm": (between / rpm).tolist()}
                        for gear, between in zip(v.gears, v.ranges, strict=True)
                    ],
                    "zones": [
                        {
                            "modes": list(z.modes),
                            "speed_rpm": z.speed / rpm,
                            "growth_per_s": dict(zip(v.states, z.growth.tolist(), strict=True)),
                        }
                        for z in v.zones
                    ],
                    "forced": {
                        "speed_rpm": (v.speeds / rpm).tolist(),
                        "torque_Nm": {
                            state: {
                                f"order {o}": v.amplitudes[s, k].tolist()
                                for k, o in enumerate(ORDERS)
                            }
                            for s, state in enumerate(v.states)
                        },
                    },
                }
                for v in found.lines
            ],
            "checks": [check(c) for c in of.checks],
            "coverage": coverage(of.coverage),
        }
    )


def chart(of: LineVibration) -> str:
    """Return the Campbell diagram of a line's torsion as an SVG that stands alone."""
    return campbell(of, EN).svg.replace("<svg ", '<svg font-family="sans-serif" ', 1) + "\n"


def campbell(of: LineVibration, say: Language) -> Figure:
    """Return the diagram of a line's speeds against its torsional frequencies.

    Slanted are the orders the joints excite, level the frequencies; where they cross is
    resonance. Bars at the foot are the gears' speeds, triangles the parametric zones.
    """
    top = 1.1 * float(of.ranges.max()) / rpm
    hertz = 1.1 * max(ORDERS) * top / 60
    frame = Chart(
        say=say, x=(0.0, top), y=(0.0, hertz), x_label=say("shaft speed [rpm]"),
        y_label=say("frequency [Hz]"),
    )  # fmt: skip
    for k, order in enumerate(ORDERS):
        x = np.array([0.0, top])
        frame.series(Series(name=say("order {order}", order=order), x=x, y=order * x / 60), k)
    for k, (gear, (low, high)) in enumerate(zip(of.gears, of.ranges / rpm, strict=True)):
        x1, y = frame.spot(float(low), 0.0)
        x2, _ = frame.spot(float(high), 0.0)
        y -= 13 + 8 * k
        frame.put(
            svg.rect(x1, y, max(x2 - x1, 3.0), 4, fill=PALETTE[3], fill_opacity=0.55),
            svg.text(
                x1 - 4, y + 5, say.occasion(gear), anchor="end", font_size=8.5, fill=PALETTE[3]
            ),
        )
    for k, frequency in enumerate(of.frequencies / (2 * pi), 1):
        said = say("mode {mode}, {frequency} Hz", mode=k, frequency=say.pointed(f"{frequency:.1f}"))
        frame.level(Level(value=float(frequency), name=said))
        for order in ORDERS:
            at = 60 * float(frequency) / order
            if at < top:
                frame.put(svg.circle(*frame.spot(at, float(frequency)), 4, fill="none", stroke=INK))
    for zone in of.zones:
        at = zone.speed / rpm
        if at < top:
            x, y = frame.spot(at, 0.0)
            fill = GRADED["fail" if np.any(zone.growth > 0) else "pass"]
            frame.put(
                svg.path([x - 5, x + 5, x], [y, y, y - 11], close=True, fill=fill, stroke="none")
            )
    title = say("Speeds against torsional frequencies")
    modes = say.list(*(f"{say.number(float(w) / (2 * pi))} Hz" for w in of.frequencies))
    return frame.figure(
        title=title,
        alt=f"{title}: {modes}",
        note=say(
            "Bars: speeds of each gear. Circles: resonances. Triangles: parametric zones, red "
            "where motions grow."
        ),
    )


def forced(of: LineVibration, say: Language) -> Figure:
    """Return the largest torque of each order in the line against speed, in the worst state."""
    title = say("Torque of forced torsional vibration")
    worst = of.amplitudes.max(0)
    said = say.list(
        *(
            f"{say('order {order}', order=o)} {say.number(float(y.max()))} N·m"
            for o, y in zip(ORDERS, worst, strict=True)
        )
    )
    return plot(
        say,
        title=title,
        alt=f"{title}: {said}",
        series=[
            Series(name=say("order {order}", order=o), x=of.speeds / rpm, y=y)
            for o, y in zip(ORDERS, worst, strict=True)
        ],
        zero=True,
        x_label=say("shaft speed [rpm]"),
        y_label=say("torque, 0-to-peak [N·m]"),
        note=say("Largest of all states and places in the line."),
    )


@dataclass(frozen=True, kw_only=True)
class Distance:
    """How far the ranges of speed stay from a resonance or zone, as shares of its speed.

    `speed` is in rad/s; `shares` (gears,) are 0 where a gear runs through it.
    """

    part: Part
    speed: float
    shares: tuple[float, ...]
    grades: tuple[str, ...]


def distances(of: LineVibration, checks: Iterable[Check]) -> Iterator[Distance]:
    """Yield the distance of each resonance and zone of a line from every range of speed."""
    mine = [c for c in checks if c.line == of.line.name]
    graded = {(c.part, c.when): c.grade for c in mine if c.quantity == "torsional_resonance"}
    grown = {c.part for c in mine if c.quantity == "torsional_growth" and c.grade != "pass"}
    met = [
        *(
            (Part("mode", i, o), float(w) / o)
            for i, w in enumerate(of.frequencies, 1)
            for o in ORDERS
        ),
        *((z.part, z.speed) for z in of.zones),
    ]
    for part, speed in met:
        shares = np.clip(speed, of.ranges[:, 0], of.ranges[:, 1]) / speed - 1
        nearest = np.abs(shares) == np.abs(shares).min()
        yield Distance(
            part=part, speed=speed, shares=tuple(shares.tolist()),
            grades=tuple(
                graded.get((part, gear), "fail" if part in grown and near else "pass")
                for gear, near in zip(of.gears, nearest, strict=True)
            ),
        )  # fmt: skip


def basis(of: Stability, say: Language) -> Iterator[str]:
    """Yield what the answer stands on: what was given, then what was assumed."""
    s = of.surroundings
    gearbox = say("gearbox turning uniformly")
    if s.gearbox_inertia is not None and s.gearbox_stiffness is not None:
        gearbox = say(
            "gearbox {inertia} kg m² on {stiffness} N m/rad",
            inertia=say.number(s.gearbox_inertia),
            stiffness=say.number(s.gearbox_stiffness),
        )
    spring = say("pinion rigid to the axle")
    if s.axle_stiffness is not None:
        spring = say("axle on {stiffness} N m/rad", stiffness=say.number(s.axle_stiffness))
    said = {
        "gearbox_inertia": gearbox,
        "axle_inertia": say("axle {inertia} kg m²", inertia=say.number(s.axle_inertia)),
        "axle_stiffness": spring,
        "damping_ratio": say("damping ratio {ratio}", ratio=say.number(s.damping_ratio)),
        "rubber_loss": say("loss factor of the rubber {factor}", factor=say.number(s.rubber_loss)),
    }
    given = "; ".join(text for name, text in said.items() if name in of.given)
    assumed = "; ".join(text for name, text in said.items() if name not in of.given)
    if given:
        yield say("Given: {values}.", values=given)
    if assumed:
        yield say("Assumed: {values}.", values=assumed)


def _line(of: LineVibration, say: Language) -> Iterator[str]:
    """Yield a line's frequencies, resonances and largest torques."""
    yield ""
    yield f"{BOLD}{say('Line {line}', line=of.line.name)}{PLAIN}"
    for k, w in enumerate(of.frequencies, 1):
        at = ", ".join(
            say("order {order} at {speed} rpm", order=o, speed=say.number(float(w) / o / rpm))
            for o in ORDERS
        )
        frequency = say.number(float(w) / (2 * pi))
        yield "  " + say("mode {mode}: {frequency} Hz; {at}", mode=k, frequency=frequency, at=at)
    for z in of.zones:
        yield "  " + say(
            "{zone}: at {speed} rpm, largest growth {rate} 1/s",
            zone=say.part(z.part),
            speed=say.number(z.speed / rpm),
            rate=say.number(float(z.growth.max())),
        )
    for k, order in enumerate(ORDERS):
        at = np.unravel_index(of.amplitudes[:, k].argmax(), of.amplitudes[:, k].shape)
        yield "  " + say(
            "order {order}: up to {torque} N m, {state} at {speed} rpm",
            order=order,
            torque=say.number(float(of.amplitudes[at[0], k, at[1]])),
            state=say.state(of.states[int(at[0])]),
            speed=say.number(float(of.speeds[at[1]]) / rpm),
        )


def worst_of_parts(checks: Iterable[Check]) -> Iterator[Check]:
    """Yield the worst check of each part."""
    for _, same in groupby(sorted(checks, key=_part), key=_part):
        yield min(same, key=lambda c: (-GRADES.index(c.grade), c.margin))


def _part(c: Check) -> tuple[str, str, str]:
    return c.quantity, c.line, str(c.part)


def _coloured(grade: Grade, say: Language, width: int) -> str:
    return f"{COLOURS[grade]}{say(grade):<{width}}{PLAIN}"
