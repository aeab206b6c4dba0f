"""Figures of a vibration study: Campbell diagrams, mode shapes, torques, launches."""

from collections.abc import Iterator
from math import pi

import numpy as np

from cardan.core.labels import Part
from cardan.core.units import rpm
from cardan.render import svg
from cardan.render.chart import Chart, DataSeries, ReferenceLine, line_chart
from cardan.render.i18n import ENGLISH, Translator
from cardan.render.svg import (
    GRID_COLOUR,
    SECONDARY_COLOUR,
    SERIES_COLOURS,
    TEXT_COLOUR,
    VERDICT_COLOURS,
    Figure,
)
from cardan.topics.torsion.launch_study import LaunchResult
from cardan.topics.torsion.operating_grid import MAX_SHOWN_MODES
from cardan.topics.torsion.vibration_checks import condition_of_launch
from cardan.topics.torsion.vibration_result import (
    EXCITED_ORDERS,
    PowertrainVibration,
    VibrationResult,
    any_known,
    heaviest_driving_state_index,
    mode_shapes_referred_to_main_line,
)

# ----- figures -------------------------------------------------------------------------------


def campbell_svg(of: VibrationResult, gear: str | None = None) -> str:
    """Return the Campbell diagram of a gear as an SVG that stands alone."""
    g = shown_gears(of)[-1] if gear is None else of.drivetrain.gears.index(gear)
    return (
        campbell_figure(of, g, ENGLISH).svg.replace("<svg ", '<svg font-family="sans-serif" ', 1)
        + "\n"
    )


def shown_gears(of: VibrationResult) -> tuple[int, ...]:
    """Return the gears that are drawn: the lowest, and the one nearest to direct."""
    direct = int(np.abs(np.log(of.drivetrain.ratios)).argmin())
    return (0, direct) if direct else (0,)


def campbell_figure(of: VibrationResult, g: int, say: Translator) -> Figure:
    """Return the diagram of a gear's speeds against the vehicle's torsional frequencies.

    Slanted are the orders of the shaft and the engine's firing as the shaft sees it, level
    the frequencies; where they cross, and the gear has the speed, is resonance.
    """
    s = heaviest_driving_state_index(of)
    driven = of.closed
    low, high = (driven.ranges[g, s] / rpm).tolist()
    w = driven.frequencies[g, s]
    top = 1.12 * high
    hertz = 1.15 * max(EXCITED_ORDERS[0] * top / 60, float(w[min(1, len(w) - 1)]) / (2 * pi))
    frame = Chart(
        say=say, x=(0.0, top), y=(0.0, hertz), x_label=say("shaft speed [rpm]"),
        y_label=say("frequency [Hz]"),
    )  # fmt: skip
    x1, y1 = frame.point_to_pixels(low, 0.0)
    x2, y2 = frame.point_to_pixels(high, hertz)
    frame.add_elements(
        svg.rect(x1, y2, max(x2 - x1, 2.0), y1 - y2, fill=SERIES_COLOURS[3], fill_opacity=0.09)
    )
    orders = {1.0: say("order {order}", order=1), 2.0: say("order {order}", order=2),
              4.0: say("order {order}", order=4)}  # fmt: skip
    if of.drivetrain.cylinders:
        firing = of.drivetrain.cylinders / 2 * float(of.drivetrain.ratios[g])
        orders[firing] = say("engine firing, order {order}", order=say.number(firing))
    for k, (order, name) in enumerate(orders.items()):
        end = min(top, hertz * 60 / order)
        x = np.array([0.0, end])
        frame.add_series(DataSeries(name=name, x=x, y=order * x / 60), k)
    shown = [f for f in (w / (2 * pi)).tolist() if f <= hertz]
    for frequency in shown:
        frame.add_reference_line(ReferenceLine(value=frequency, name=""))
        for order in orders:
            at = 60 * frequency / order
            if low <= at <= high:
                frame.add_elements(
                    svg.circle(
                        *frame.point_to_pixels(at, frequency), 4, fill="none", stroke=TEXT_COLOUR
                    )
                )
    for near in _near(shown, hertz / 22):
        said = [say("mode {mode}, {frequency} Hz", mode=shown.index(f) + 1,
                    frequency=say.with_decimal_sign(f"{f:.1f}")) for f in near]  # fmt: skip
        x, y = frame.point_to_pixels(top, near[-1])
        frame.add_elements(svg.text(x - 4, y - 4, "; ".join(said), anchor="end", font_size=11))
    for zone in of.zones:
        at = float(zone.speed[g, s]) / rpm
        if at < top:
            x, y = frame.point_to_pixels(at, 0.0)
            open_here = float(np.nanmax(zone.growth[g])) > 0 if any_known(zone.growth[g]) else False
            fill = VERDICT_COLOURS["fail" if open_here else "pass"]
            frame.add_elements(
                svg.path([x - 5, x + 5, x], [y, y, y - 11], close=True, fill=fill, stroke="none")
            )
    title = say("Speeds against torsional frequencies, {gear}", gear=say.occasion(of.gears[g]))
    modes = say.join(*(f"{say.number(float(f) / (2 * pi))} Hz" for f in w[:MAX_SHOWN_MODES]))
    return frame.to_figure(
        title=title,
        alt=f"{title}: {modes}",
        note=say(
            "Shaded: speeds of the gear, clutch closed. Circles: resonances. Triangles: "
            "parametric zones, red where motions grow."
        ),
    )


def _near(values: list[float], within: float) -> Iterator[list[float]]:
    """Yield rising values in groups whose labels would lie on each other."""
    group: list[float] = []
    for value in values:
        if group and value - group[-1] > within:
            yield group
            group = []
        group.append(value)
    if group:
        yield group


def mode_shape_figure(of: VibrationResult, g: int, say: Translator, count: int = 5) -> Figure:
    """Return the shapes of a gear's lowest modes, each rotation as the main line turns."""
    s = heaviest_driving_state_index(of)
    driven = of.closed
    turned = mode_shapes_referred_to_main_line(driven, g, s)
    count = min(count, turned.shape[1])
    names = driven.powertrain.freedoms
    place = {name: k for k, name in enumerate(names)}
    left, step, high, foot = 118.0, 34.0, 62.0, 104.0
    width = left + step * (len(names) - 1) + 30
    height = high * count + foot
    out: list[str] = []
    for m in range(count):
        y0 = high * (m + 0.5) + 6
        colour = SERIES_COLOURS[m % len(SERIES_COLOURS)]
        out.append(svg.line(left, y0, left + step * (len(names) - 1), y0, stroke=GRID_COLOUR))
        frequency = say.with_decimal_sign(f"{float(driven.frequencies[g, s, m]) / (2 * pi):.2f}")
        out.append(svg.text(8, y0 - 2, say("mode {mode}", mode=m + 1), font_size=11))
        out.append(svg.text(8, y0 + 12, f"{frequency} Hz", font_size=11, fill=SECONDARY_COLOUR))
        xy = {f: (left + step * k, y0 - 24 * float(turned[k, m])) for f, k in place.items()}
        for a, b in _joined(driven):
            out.append(svg.line(*xy[names[a]], *xy[names[b]], stroke=colour, stroke_width=1.8))
        out += [svg.circle(x, y, 3, fill=colour) for x, y in xy.values()]
    several = len(of.lines) > 1
    for (line, part), k in place.items():
        x, y = left + step * k, high * count + 16
        said = say.part(part) + (f", {line}" if line and several else "")
        out.append(
            svg.text(
                x, y, said, anchor="end", font_size=10, transform=f"rotate(-42 {x:.1f} {y:.1f})"
            )
        )
    title = say("Mode shapes, {gear}", gear=say.occasion(of.gears[g]))
    each = driven.frequencies[g, s, :count] / (2 * pi)
    alt = f"{title}: {say.join(*(f'{say.number(f)} Hz' for f in each.tolist()))}"
    return Figure(
        title=title, svg=svg.svg_document(width, height, *out, alt=alt), alt=alt,
        note=say("Each rotation as the main line turns, the largest of a mode drawn as 1."),
    )  # fmt: skip


def _joined(of: PowertrainVibration) -> Iterator[tuple[int, int]]:
    """Yield pairs of freedoms that a spring is between."""
    line = of.powertrain.line
    reaches = np.abs(line.springs @ line.straight_transform) > 0
    for row in reaches:
        ends = np.flatnonzero(row).tolist()
        for b in ends[1:]:
            yield ends[0], b


def forced_torque_figure(of: VibrationResult, say: Translator) -> Figure:
    """Return the largest torque of order 2 in the lines against speed, gear by gear."""
    title = say("Torque of forced torsional vibration")
    series: list[DataSeries] = []
    for g, gear in enumerate(of.gears):
        values = of.amplitudes[g, :, 0]
        known = np.isfinite(values).any(0)
        if known.any():
            worst = np.nanmax(values[:, known], axis=0)
            series.append(DataSeries(name=say.occasion(gear), x=of.speeds[known] / rpm, y=worst))
    said = say.join(*(f"{s.name} {say.number(float(s.y.max()))} N·m" for s in series))
    return line_chart(
        say, title=title, alt=f"{title}: {said}", series=series, zero=True,
        x_label=say("shaft speed [rpm]"), y_label=say("torque, 0-to-peak [N·m]"),
        note=say("Order 2, largest of all states and shafts, at the full load of each speed."),
    )  # fmt: skip


def launch_figures(of: LaunchResult, say: Translator) -> Iterator[Figure]:
    """Yield a launch's torque, and the amplitude of order 2 in it, against time."""
    travel, k = of.history, of.first_shaft
    when = say.occasion(condition_of_launch(of.launch))
    title = say("Torque of a start from rest, {launch}", launch=when)
    peak = say.number(float(of.peak_torque[k]))
    yield line_chart(
        say, title=title, alt=f"{title}: {peak} N·m",
        series=[
            DataSeries(name=say("as it is"), x=travel.time, y=travel.torque[0, :, k]),
            DataSeries(name=say("joints straight"), x=travel.time, y=travel.torque[1, :, k]),
            DataSeries(name=say("tyres that stick"), x=travel.time, y=travel.torque[4, :, k]),
        ],
        levels=[ReferenceLine(value=of.torque, name="T i")], zero=True,
        x_label=say("time [s]"), y_label=say("torque [N·m]"),
        note=say("Of the first shaft of the main line."),
    )  # fmt: skip
    lines = [j for j, (_, p) in enumerate(of.springs) if p.kind in {"shaft", "pinion"}]
    title = say("Order 2 of a start from rest, {launch}", launch=when)
    yield line_chart(
        say, title=title, alt=title,
        series=[
            DataSeries(
                name=say.part(of.springs[j][1]) + f", {of.springs[j][0]}",
                x=travel.time, y=of.order2_amplitude[j],
            )
            for j in lines if any_known(of.order2_amplitude[j])
        ],
        zero=True, x_label=say("time [s]"), y_label=say("torque, 0-to-peak [N·m]"),
        note=say("What the joints alone add, over half a turn round each instant."),
    )  # fmt: skip
    if of.bearing_force.size:
        title = say("Force on the centre bearings along the ramp, {launch}", launch=when)
        yield line_chart(
            say, title=title, alt=title,
            series=[
                DataSeries(name=name.format(say.part(Part("centre bearing", b + 1))),
                       x=of.bearing_time, y=force[:, b])
                for name, force in (
                    ("{}", of.bearing_transient_force),
                    (say("{part}, if each instant lasted", part="{}"), of.bearing_force),
                )
                for b in range(force.shape[1]) if any_known(force[:, b])
            ],
            zero=True, x_label=say("time [s]"), y_label=say("force [N]"),
            note=say("On rubber, at the worst thrust: as the line passes through, and as each "
                     "instant's torque and speed would give it in the end."),
        )  # fmt: skip
