"""Plots of a line: round the turn, over the suspension's travel, by gear, over speed.

Speeds are in rpm, amplitudes are 0-to-peak; every curve is computed where it is drawn, by
the same physics as the checks.
"""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from cardan.checks.line_response import LineResponse, compute_line_response
from cardan.checks.quantities.registry import QUANTITIES
from cardan.core.arrays import FloatArray
from cardan.core.errors import DesignError
from cardan.core.labels import Part
from cardan.core.units import kN, mm, rpm
from cardan.core.verdict import Limit
from cardan.documents.line_drawing import worst_state_index
from cardan.model.application import VehicleState
from cardan.physics.kinematics.joint_chain import rotate_chain
from cardan.physics.vehicle.state_demand import line_state_demand, resolve_line_references
from cardan.physics.vehicle.suspension import load_per_spring, spring_deflection, spring_load
from cardan.render import svg
from cardan.render.chart import (
    Chart,
    DataSeries,
    ReferenceLine,
    axis_range,
    bar_chart,
    limit_bands,
    line_chart,
)
from cardan.render.i18n import Translator
from cardan.render.phrases import torque_curve_name
from cardan.render.svg import (
    HALO,
    SECONDARY_COLOUR,
    SERIES_COLOURS,
    TEXT_COLOUR,
    VERDICT_COLOURS,
    Figure,
)

CURVE_POINTS_PER_TURN = 181
"""Points of a turn that a curve is drawn through."""

TRAVEL_CURVE_POINTS = 41
"""Places of the axle that a curve over its travel is drawn through."""

ACCELERATION_QUANTITIES = (
    "torsional_acceleration",
    "inertia_drive_acceleration",
    "inertia_coast_acceleration",
)


def all_line_plots(response: LineResponse, say: Translator) -> tuple[Figure, ...]:
    """Return every plot that there is something to draw for."""
    return tuple(_iter_plots(response, say))


def _iter_plots(r: LineResponse, say: Translator) -> Iterator[Figure]:
    if np.isfinite(r.demand.speed).any():
        yield from motion_over_turn_plots(r, say)
        for quantity in ACCELERATION_QUANTITIES if len(r.demand.states) > 1 else ():
            yield acceleration_over_travel_plot(r, say, quantity=quantity)
    loaded = r.line.has_lengths and np.isfinite(r.demand.torque).any()
    for k in range(r.line.joint_count - 2 if loaded else 0):
        yield bearing_force_ellipse_plot(r, say, bearing=k)
        if len(r.demand.states) > 1:
            yield bearing_force_order_plot(r, say, bearing=k)
        if r.mount_loads.worst_bearing_forces and r.mounts.mounted_line is not None:
            yield from bearing_over_speed_plots(r, say, bearing=k)
    if r.demand.gears is not None:
        yield torque_by_gear_plot(r, say)
    if np.isfinite(r.strength.critical_speeds).any():
        yield critical_speed_plot(r, say)
    if r.application.suspension is not None and r.demand.installed.drives == "rear":
        yield suspension_spring_curve_plot(r, say)


def motion_over_turn_plots(r: LineResponse, say: Translator) -> Iterator[Figure]:
    """Yield speed and acceleration of every member round the turn, in the worst state."""
    s = worst_state_index(r)
    one = rotate_chain(
        r.layout.directions[s],
        phases=r.phases,
        crosses=r.line.is_cross,
        samples=CURVE_POINTS_PER_TURN - 1,
    )
    theta = np.linspace(0, 360, CURVE_POINTS_PER_TURN)
    state, w = say.state(r.demand.states[s]), float(r.demand.speed[s])
    names = _members(r, say)

    def closed(values: FloatArray) -> FloatArray:
        return np.append(values, values[:1])

    for title, values, unit in (
        (say("Speed round the turn, {state}", state=state), one.speed * (w / rpm), "rpm"),
        (
            say("Acceleration round the turn, {state}", state=state),
            one.acceleration * w**2,
            "rad/s²",
        ),
    ):
        what = say("speed") if unit == "rpm" else say("acceleration")
        rows = [
            DataSeries(name=name, x=theta, y=closed(v))
            for name, v in zip(names, values, strict=True)
        ]
        most = say.join(
            *(f"{n} {say.number(float(np.ptp(v)))}" for n, v in zip(names, values, strict=True))
        )
        yield line_chart(
            say,
            title=title,
            alt=title + ". " + say("Peak to peak in {unit}: {values}", unit=unit, values=most),
            series=rows,
            x=(0.0, 360.0),
            x_label=say("gearbox angle θ [deg]"),
            y_label=f"{what} [{unit}]",
            note=say(
                "Gearbox turning uniformly at {speed} rpm. Peak to peak in {unit}: {values}.",
                speed=say.number(w / rpm),
                unit=unit,
                values=most,
            ),
        )


def acceleration_over_travel_plot(r: LineResponse, say: Translator, *, quantity: str) -> Figure:
    """Return an acceleration against suspension travel, with its limits as bands."""
    q = QUANTITIES[quantity]
    values = _acceleration(r, quantity)
    limits = _limits(r, quantity)
    travel = r.demand.travel / mm
    ride = _line_over_travel(r) if np.ptp(travel) >= 1 else None
    drawn = [values, _acceleration(ride[1], quantity)] if ride else [values]
    # A line that keeps its speed accelerates nothing: 1 rad/s² high, then.
    top = 1.15 * max(float(np.nanmax(v)) for v in drawn) or 1.0
    for limit in limits:
        for bound in (limit.normal, limit.maximum):
            if bound is not None and bound < 2.5 * top:
                top = max(top, bound * 1.12)
    bands = limit_bands(limits, factor=q.si_factor, top=10 * top)
    names = tuple(say.state(s) for s in r.demand.states)
    title = say("{quantity} by state", quantity=say.name(quantity))
    said = say.join(*(f"{n} {say.number(v)}" for n, v in zip(names, values, strict=True)))
    alt = f"{title}, {q.unit_symbol}: {said}"
    y_label = f"{q.symbol} [{q.unit_symbol}]"
    if np.ptp(travel) < 1:
        return bar_chart(
            say,
            title=title,
            alt=alt,
            categories=names,
            groups=[(say.name(quantity), values)],
            y_label=y_label,
            bands=bands,
            top=top / 1.06,
        )
    series = [
        *(
            [
                DataSeries(
                    name=say("over the travel, axle not wound up"),
                    x=ride[0],
                    y=_acceleration(ride[1], quantity),
                )
            ]
            if ride
            else []
        ),
        DataSeries(
            name=say("states"), x=travel, y=values, draw_line=False, draw_markers=True, labels=names
        ),
    ]
    return line_chart(
        say,
        title=say("{quantity} over the travel", quantity=say.name(quantity)),
        alt=alt,
        series=series,
        bands=bands,
        y=(0.0, top),
        x=axis_range(travel, room=0.08),
        x_label=say("axle travel, up is positive [mm]"),
        y_label=y_label,
        note=say(
            "0-to-peak; the curve at the line's top speed, states at their own. Bands: where the "
            "limit warns and fails."
        ),
    )


def bearing_force_ellipse_plot(r: LineResponse, say: Translator, *, bearing: int) -> Figure:
    """Return the force on a bearing round the turn, across the vehicle, state by state."""
    values = r.rigid_loads.joint_loads.bearing_forces.values(CURVE_POINTS_PER_TURN - 1)[:, bearing]
    values = np.concatenate([values, values[:, :1]], axis=1)
    mean = r.rigid_loads.joint_loads.bearing_forces.static[:, bearing]
    names = [say.state(s) for s in r.demand.states]
    series = [
        DataSeries(name=name, x=v[:, 1], y=v[:, 2]) for name, v in zip(names, values, strict=True)
    ]
    part = say.part(Part("centre bearing", bearing + 1))
    title = say("Force on {part} round the turn", part=part)
    peaks = r.rigid_loads.rigid_bearing_peaks[:, bearing]
    alt = (
        title
        + ". "
        + say(
            "Peak in N: {values}",
            values=say.join(*(f"{n} {say.number(p)}" for n, p in zip(names, peaks, strict=True))),
        )
    )
    chart = Chart(
        say=say,
        equal_aspect=True,
        x=axis_range(values[..., 1], 0.0),
        y=axis_range(values[..., 2], 0.0),
        height=380,
        x_label=say("lateral force, to the right [N]"),
        y_label=say("vertical force, up [N]"),
    )
    for k, s in enumerate(series):
        chart.add_series(s, k)
        chart.add_elements(chart.marker(*chart.point_to_pixels(mean[k, 1], mean[k, 2]), k))
    note = say("Mean (mark) and ellipse twice a turn, exactly, at each state's torque.")
    return chart.to_figure(title=title, alt=alt, note=note)


def bearing_force_order_plot(r: LineResponse, say: Translator, *, bearing: int) -> Figure:
    """Return the force on a bearing by order, state by state."""
    cycle = r.rigid_loads.joint_loads.bearing_forces
    orders = [(say("mean"), np.linalg.norm(cycle.static[:, bearing], axis=-1))]
    for k in (1, 2, 4):
        force = cycle.amplitude(k)[:, bearing]
        if k == 1 and r.rigid_loads.unbalance_forces:
            force = force + r.rigid_loads.unbalance_forces.bearing_forces[:, bearing]
        if force.max() > 0.01:
            orders.append((say("order {order}", order=k), force))
    names = tuple(say.state(s) for s in r.demand.states)
    title = say("Force on {part} by order", part=say.part(Part("centre bearing", bearing + 1)))
    alt = (
        title
        + ". "
        + "; ".join(
            f"{name}: {say.join(*(say.number(v) for v in values))} N" for name, values in orders
        )
    )
    return bar_chart(
        say,
        title=title,
        alt=alt,
        categories=names,
        groups=orders,
        y_label=say("force [N]"),
        note=say(
            "0-to-peak along the major axis of each order's ellipse; orders of the shaft's speed."
        ),
    )


def bearing_over_speed_plots(r: LineResponse, say: Translator, *, bearing: int) -> Iterator[Figure]:
    """Yield what shakes a bearing on rubber against speed, in the state where most does.

    Gear by gear; nothing where the line stands still.
    """
    worst = r.mount_loads.worst_bearing_forces["dynamic"]
    found, part = worst.curves, Part("centre bearing", bearing + 1)
    assert r.mounts.mounted_line is not None  # checked by the caller
    s = int(np.nan_to_num(worst.results.dynamic[:, bearing]).argmax())
    drawn = found.curves_to_draw(s)
    if not drawn:
        return
    top = float(np.nanmax(found.max_speed[drawn, s]))
    modes = r.line.rigid_body_mode_count
    meets = r.mounts.mounted_line.modes().frequency[s, :modes] / 2
    meets = meets[meets < top]
    top = min(top, 3 * float(meets.max())) if len(meets) else top  # beyond it only falls
    near = meets[:, None] * np.linspace(0.8, 1.2, 33)
    speed = np.unique(np.concatenate([np.linspace(top / 60, top, 60), near.ravel()]))
    speed = speed[speed <= top]
    force = r.mounts.forces_over_speed(speed, curves=drawn).results.dynamic[:, :, s, bearing]
    series = [
        DataSeries(
            name=torque_curve_name(found, k, say),
            x=speed[~np.isnan(of)] / rpm,
            y=of[~np.isnan(of)],
        )
        for k, of in zip(drawn, force, strict=True)
        if not np.isnan(of).all()
    ]  # fmt: skip
    limits = _limits(r, "centre_bearing_dynamic")
    high = 1.1 * max(
        float(np.nanmax(force)),
        *(b for m in limits for b in (m.normal, m.maximum) if b is not None),
        0.0,
    )
    name, value = say.part(part), float(worst.results.dynamic[s, bearing])
    title = say("Dynamic force on {part} over speed", part=name)
    at = worst.operating_point((s, bearing))
    yield line_chart(
        say,
        title=title,
        alt=title
        + ". "
        + say(
            "{state}: at most {force} N at {speed} rpm",
            state=say.state(r.demand.states[s]),
            force=say.number(value),
            speed=say.compact_number(round(at.speed / rpm), 6) if at else "-",
        ),
        series=series,
        bands=limit_bands(limits, factor=1.0, top=10 * high),
        levels=[
            ReferenceLine(
                value=float(r.rigid_loads.joint_loads.bearing_forces.dynamic[s, bearing]),
                name=say("rigid bearing, at its own torque"),
            )
        ],
        x=(0.0, 1.03 * top / rpm),
        y=(0.0, high),
        x_label=say("shaft speed [rpm]"),
        y_label=say("force [N]"),
        note=say(
            "{state}, at full load on the rubber of the bearings; 0-to-peak of orders 2 and 4. "
            "Where an order meets a mode the force is many times that of a rigid bearing.",
            state=say.state(r.demand.states[s]),
        ),
    )


def torque_by_gear_plot(r: LineResponse, say: Translator) -> Figure:
    """Return the line's torque over its speed in every gear, against what the tyres hold."""
    gears = r.demand.gears
    assert gears is not None  # checked by the caller
    series = [
        DataSeries(
            name=say("gear {gear}", gear=name),
            x=speed / rpm,
            y=torque,
            draw_markers=len(speed) == 1,
        )
        for name, speed, torque in zip(gears.names, gears.speed, gears.torque, strict=True)
    ]
    slip = r.demand.slip_torque
    levels = [
        ReferenceLine(
            value=float(value), name=say("tyres slip, {states}", states=say.join(*states))
        )
        for value, states in _names_by_value(slip, [say.state(s) for s in r.demand.states])
    ]
    title = say("Torque by gear, engine against slip")
    peaks = say.join(
        *(f"{n} {say.number(p)}" for n, p in zip(gears.names, gears.peak_torque, strict=True))
    )
    return line_chart(
        say,
        title=title,
        alt=title + ". " + say("Largest torque in N·m by gear: {values}", values=peaks),
        series=series,
        levels=levels,
        zero=True,
        x=(0.0, float(gears.speed.max() / rpm) * 1.03),
        x_label=say("shaft speed [rpm]"),
        y_label=say("shaft torque [N·m]"),
        note=say("Full load. Loads are computed with the smaller of engine and slip torque."),
    )


def critical_speed_plot(r: LineResponse, say: Translator) -> Figure:
    """Return critical speeds of shafts and line, with what to keep out of, against the speed."""
    lowest = (
        np.fmin.reduce(r.strength.critical_speeds, axis=0) / rpm
    )  # nan of a shaft without a tube
    rows = [(say.part(Part("shaft", k)), n) for k, n in enumerate(lowest, 1) if np.isfinite(n)]
    if np.isfinite(r.strength.line_critical_speed):
        rows.append((say("line, as beams"), r.strength.line_critical_speed / rpm))
    if np.isfinite(r.strength.mount_resonance_speed):
        rows.append((say("line on its rubber"), r.strength.mount_resonance_speed / rpm))
    top = float(np.nan_to_num(r.inputs.reached_speed).max()) / rpm
    ratio, band = _limits(r, "critical_speed_ratio"), _limits(r, "half_critical_band")
    x = (0.0, 1.08 * max(top, *(n for _, n in rows)))
    frame = Chart(
        say=say,
        x=x,
        y=(-0.6, len(rows) - 0.1),
        x_label=say("shaft speed [rpm]"),
        y_label="",
        height=110 + 44.0 * len(rows),
        show_y_values=False,
    )
    x1, y1 = frame.point_to_pixels(0, frame.y[0])
    x2, y2 = frame.point_to_pixels(top, frame.y[1])
    drawn = [svg.rect(x1, y2, x2 - x1, y1 - y2, fill=SERIES_COLOURS[0], fill_opacity=0.12)]
    drawn.append(svg.line(x2, y1, x2, y2, stroke=SERIES_COLOURS[0], stroke_width=2))
    drawn.append(
        svg.text(x2 + 5, y2 + 10, say("speed range"), font_size=11, fill=SERIES_COLOURS[0])
    )
    bounce = say("line on its rubber")
    for k, (name, n) in enumerate(rows):
        y = len(rows) - 1 - k
        a, py = frame.point_to_pixels(0, y)
        b, _ = frame.point_to_pixels(n, y)
        drawn.append(svg.line(a, py, b, py, stroke=SECONDARY_COLOUR, stroke_width=1))
        if name != bounce:
            for grade, low, high in _forbidden_speed_ratios(ratio, band):
                c, _ = frame.point_to_pixels(low * n, y)
                d, _ = frame.point_to_pixels(min(high * n, x[1]), y)
                drawn.append(
                    svg.rect(c, py - 9, d - c, 18, fill=VERDICT_COLOURS[grade], fill_opacity=0.28)
                )
        drawn.append(svg.line(b, py - 12, b, py + 12, stroke=TEXT_COLOUR, stroke_width=3))
        drawn.append(
            svg.text(
                frame.point_to_pixels(0, y)[0] + 5,
                py - 13,
                f"{name}: {say.number(n)} rpm",
                font_size=11,
                **HALO,
            )
        )
    title = say("Critical speeds and the speed range")
    said = say.join(*(f"{name} {say.number(n)} rpm" for name, n in rows))
    frame.add_elements(*drawn)
    return frame.to_figure(
        title=title,
        alt=f"{title}: {said}",
        note=say(
            "Upright bars: critical speeds, the lowest over the states. Shaded: near half "
            "critical, where the joints excite twice a turn, and too near critical, by the "
            "profile's limits."
        ),
    )


def suspension_spring_curve_plot(r: LineResponse, say: Translator) -> Figure:
    """Return the spring's table as a curve, with the states on it."""
    suspension = r.application.suspension
    assert suspension is not None  # checked by the caller
    spring = suspension.spring
    deflection, load = np.array(spring.deflection) / mm, np.array(spring.load) / kN
    # States that rest on the spring say where the others are: travel is counted from one of them.
    rests = np.isfinite(r.demand.suspension_frequency)
    names = [say.state(s) for s in r.demand.states]
    loads = np.where(rests, load_per_spring(suspension, r.demand.axle_load), np.nan)
    x = spring_deflection(spring, loads)
    offset = np.nanmedian(x - r.demand.travel) if rests.any() else np.nan
    x = np.where(rests, x, r.demand.travel + offset) / mm
    y = spring_load(spring, x * mm) / kN
    title = say("Spring curve")
    alt = (
        title
        + ". "
        + "; ".join(
            f"{say.compact_number(a, 4)} mm {say.compact_number(b, 4)} kN"
            for a, b in zip(deflection, load, strict=True)
        )
    )
    return line_chart(
        say,
        title=title,
        alt=alt,
        series=[
            DataSeries(name=say("table of the spring"), x=deflection, y=load, draw_markers=True),
            DataSeries(
                name=say("states"),
                x=x,
                y=y,
                draw_line=False,
                draw_markers=True,
                labels=tuple(names),
            ),
        ],
        x_label=say("deflection [mm]"),
        y_label=say("load of one spring [kN]"),
        x=axis_range(deflection, x),
        y=axis_range(load, y),
    )


def _members(r: LineResponse, say: Translator) -> list[str]:
    """Return the names of the members behind the joints."""
    shafts = [say.part(Part("shaft", k)) for k in range(1, r.line.joint_count)]
    return [*shafts, say("pinion")]


def _limits(r: LineResponse, quantity: str) -> list[Limit]:
    return [m for m in r.application.limits if m.quantity == quantity]


def _acceleration(r: LineResponse, quantity: str) -> FloatArray:
    """Return one of the excitation's accelerations by state."""
    e = r.kinematics.excitation
    one = {"torsional_acceleration": e.torsional, "inertia_drive_acceleration": e.drive}
    return one.get(quantity, e.coast).acceleration


def _line_over_travel(r: LineResponse) -> tuple[FloatArray, LineResponse] | None:
    """Return the line at many places of its axle; None where states place it by themselves."""
    travel = r.demand.travel
    if any(s.layouts for s in r.application.states):
        return None
    places = np.linspace(travel.min(), travel.max(), TRAVEL_CURVE_POINTS)
    states = tuple(
        VehicleState(name=str(k), travel=float(z), torque=0.0, speed=_gearbox_speed(r))
        for k, z in enumerate(places)
    )
    try:
        application = replace(r.application, states=states)
        return places / mm, compute_line_response(
            application, line_state_demand(resolve_line_references(application, r.demand.installed))
        )
    except DesignError:
        return None


def _gearbox_speed(r: LineResponse) -> float:
    """Return the top speed of the gearbox output, of which the line has its share."""
    return float(np.nan_to_num(r.demand.speed).max()) / r.demand.installed.speed_ratio


def _names_by_value(values: FloatArray, names: list[str]) -> list[tuple[float, list[str]]]:
    """Return finite values with the names of those that share them."""
    found: dict[float, list[str]] = {}
    for value, name in zip(values, names, strict=True):
        if np.isfinite(value):
            found.setdefault(round(float(value), 3), []).append(name)
    return [(v, n if len(n) < 4 else [*n[:2], "…"]) for v, n in found.items()]


def _forbidden_speed_ratios(
    ratio: list[Limit], band: list[Limit]
) -> Iterator[tuple[str, float, float]]:
    """Yield the shares of a critical speed to keep out of, with what a check says there."""
    for limit in band:
        if limit.band:
            yield "warn", *limit.band
    for limit in ratio:
        if limit.normal is not None:
            yield "warn", limit.normal, limit.maximum or 1.0
        if limit.maximum is not None:
            yield "fail", limit.maximum, 1.0
