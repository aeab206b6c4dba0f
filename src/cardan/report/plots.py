"""Plots of a line: round the turn, over the suspension's travel, by gear, over speed.

Speeds are in rpm, amplitudes are 0-to-peak; every curve is computed where it is drawn, by
the same physics as the checks.
"""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from cardan.base.arrays import FloatArray
from cardan.base.errors import DesignError
from cardan.base.part import Part
from cardan.base.units import kN, mm, rpm
from cardan.base.verdict import Limit
from cardan.demand.states import demand, resolve
from cardan.demand.suspension import carried, spring_deflection, spring_load
from cardan.kinematics.chain import turn
from cardan.model.application import State
from cardan.quantity import points
from cardan.quantity.quantities import QUANTITIES
from cardan.quantity.response import Response, respond
from cardan.report import svg
from cardan.report.chart import Chart, Level, Series, bars, bounds, limit_bands, plot
from cardan.report.drawing import worst_state
from cardan.report.language import Language
from cardan.report.svg import FAINT, GRADED, INK, PALETTE, Figure
from cardan.report.wording import curve

ROUND = 181
"""Points of a turn that a curve is drawn through."""

RIDE = 41
"""Places of the axle that a curve over its travel is drawn through."""

ACCELERATIONS = (
    "torsional_acceleration",
    "inertia_drive_acceleration",
    "inertia_coast_acceleration",
)


def plots(response: Response, say: Language) -> tuple[Figure, ...]:
    """Return every plot that there is something to draw for."""
    return tuple(_plots(response, say))


def _plots(r: Response, say: Language) -> Iterator[Figure]:
    if np.isfinite(r.demand.speed).any():
        yield from round_the_turn(r, say)
        for quantity in ACCELERATIONS:
            yield over_travel(r, say, quantity=quantity)
    loaded = r.line.measured and np.isfinite(r.demand.torque).any()
    for k in range(r.line.joint_count - 2 if loaded else 0):
        yield bearing_ellipse(r, say, bearing=k)
        yield bearing_orders(r, say, bearing=k)
        if r.worst and r.held is not None:
            yield from bearing_over_speed(r, say, bearing=k)
    if r.demand.gears is not None:
        yield torque_by_gear(r, say)
    if np.isfinite(r.critical_speeds).any():
        yield critical_speeds(r, say)
    if r.application.suspension is not None and r.demand.installed.drives == "rear":
        yield spring_curve(r, say)


def round_the_turn(r: Response, say: Language) -> Iterator[Figure]:
    """Yield speed and acceleration of every member round the turn, in the worst state."""
    s = worst_state(r)
    one = turn(r.layout.directions[s], phases=r.phases, crosses=r.line.crosses, samples=ROUND - 1)
    theta = np.linspace(0, 360, ROUND)
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
            Series(name=name, x=theta, y=closed(v)) for name, v in zip(names, values, strict=True)
        ]
        most = say.list(
            *(f"{n} {say.number(float(np.ptp(v)))}" for n, v in zip(names, values, strict=True))
        )
        yield plot(
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


def over_travel(r: Response, say: Language, *, quantity: str) -> Figure:
    """Return an acceleration against suspension travel, with its limits as bands."""
    q = QUANTITIES[quantity]
    values = _acceleration(r, quantity)
    limits = _limits(r, quantity)
    travel = r.demand.travel / mm
    ride = _ride(r) if np.ptp(travel) >= 1 else None
    drawn = [values, _acceleration(ride[1], quantity)] if ride else [values]
    # A line that keeps its speed accelerates nothing: 1 rad/s² high, then.
    top = 1.15 * max(float(np.nanmax(v)) for v in drawn) or 1.0
    for limit in limits:
        for bound in (limit.normal, limit.maximum):
            if bound is not None and bound < 2.5 * top:
                top = max(top, bound * 1.12)
    bands = limit_bands(limits, factor=q.factor, top=10 * top)
    names = tuple(say.state(s) for s in r.demand.states)
    title = say("{quantity} by state", quantity=say.name(quantity))
    said = say.list(*(f"{n} {say.number(v)}" for n, v in zip(names, values, strict=True)))
    alt = f"{title}, {q.unit_name}: {said}"
    y_label = f"{q.symbol} [{q.unit_name}]"
    if np.ptp(travel) < 1:
        return bars(
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
                Series(
                    name=say("over the travel, axle not wound up"),
                    x=ride[0],
                    y=_acceleration(ride[1], quantity),
                )
            ]
            if ride
            else []
        ),
        Series(name=say("states"), x=travel, y=values, joined=False, points=True, labels=names),
    ]
    return plot(
        say,
        title=say("{quantity} over the travel", quantity=say.name(quantity)),
        alt=alt,
        series=series,
        bands=bands,
        y=(0.0, top),
        x=bounds(travel, room=0.08),
        x_label=say("axle travel, up is positive [mm]"),
        y_label=y_label,
        note=say(
            "0-to-peak; the curve at the line's top speed, states at their own. Bands: where the "
            "limit warns and fails."
        ),
    )


def bearing_ellipse(r: Response, say: Language, *, bearing: int) -> Figure:
    """Return the force on a bearing round the turn, across the vehicle, state by state."""
    values = r.loads.bearing_forces.values(ROUND - 1)[:, bearing]
    values = np.concatenate([values, values[:, :1]], axis=1)
    mean = r.loads.bearing_forces.static[:, bearing]
    names = [say.state(s) for s in r.demand.states]
    series = [
        Series(name=name, x=v[:, 1], y=v[:, 2]) for name, v in zip(names, values, strict=True)
    ]
    part = say.part(Part("centre bearing", bearing + 1))
    title = say("Force on {part} round the turn", part=part)
    peaks = r.bearing_peaks[:, bearing]
    alt = (
        title
        + ". "
        + say(
            "Peak in N: {values}",
            values=say.list(*(f"{n} {say.number(p)}" for n, p in zip(names, peaks, strict=True))),
        )
    )
    chart = Chart(
        say=say,
        equal=True,
        x=bounds(values[..., 1], 0.0),
        y=bounds(values[..., 2], 0.0),
        height=380,
        x_label=say("lateral force, to the right [N]"),
        y_label=say("vertical force, up [N]"),
    )
    for k, s in enumerate(series):
        chart.series(s, k)
        chart.put(chart.mark(*chart.spot(mean[k, 1], mean[k, 2]), k))
    note = say("Mean (mark) and ellipse twice a turn, exactly, at each state's torque.")
    return chart.figure(title=title, alt=alt, note=note)


def bearing_orders(r: Response, say: Language, *, bearing: int) -> Figure:
    """Return the force on a bearing by order, state by state."""
    cycle = r.loads.bearing_forces
    orders = [(say("mean"), np.linalg.norm(cycle.static[:, bearing], axis=-1))]
    for k in (1, 2, 4):
        force = cycle.amplitude(k)[:, bearing]
        if k == 1 and r.unbalance:
            force = force + r.unbalance.bearing_forces[:, bearing]
        if force.max() > 0.01:
            orders.append((say("order {order}", order=k), force))
    names = tuple(say.state(s) for s in r.demand.states)
    title = say("Force on {part} by order", part=say.part(Part("centre bearing", bearing + 1)))
    alt = (
        title
        + ". "
        + "; ".join(
            f"{name}: {say.list(*(say.number(v) for v in values))} N" for name, values in orders
        )
    )
    return bars(
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


def bearing_over_speed(r: Response, say: Language, *, bearing: int) -> Iterator[Figure]:
    """Yield what shakes a bearing on rubber against speed, in the state where most does.

    Gear by gear; nothing where the line stands still.
    """
    worst = r.worst["dynamic"]
    found, part = worst.curves, Part("centre bearing", bearing + 1)
    assert r.held is not None  # the caller asks
    s = int(np.nan_to_num(worst.running.dynamic[:, bearing]).argmax())
    drawn = found.shown(s)
    if not drawn:
        return
    top = float(np.nanmax(found.fastest[drawn, s]))
    modes = r.line.swings
    meets = r.held.modes().frequency[s, :modes] / 2
    meets = meets[meets < top]
    top = min(top, 3 * float(meets.max())) if len(meets) else top  # beyond it only falls
    near = meets[:, None] * np.linspace(0.8, 1.2, 33)
    speed = np.unique(np.concatenate([np.linspace(top / 60, top, 60), near.ravel()]))
    speed = speed[speed <= top]
    force = points.swept(r, speed, curves_=drawn).running.dynamic[:, :, s, bearing]
    series = [
        Series(
            name=curve(found, k, say),
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
    name, value = say.part(part), float(worst.running.dynamic[s, bearing])
    title = say("Dynamic force on {part} over speed", part=name)
    at = worst.named((s, bearing))
    yield plot(
        say,
        title=title,
        alt=title + ". " + say(
            "{state}: at most {force} N at {speed} rpm", state=say.state(r.demand.states[s]),
            force=say.number(value), speed=say.short(round(at.speed / rpm), 6) if at else "-",
        ),
        series=series,
        bands=limit_bands(limits, factor=1.0, top=10 * high),
        levels=[Level(
            value=float(r.loads.bearing_forces.dynamic[s, bearing]),
            name=say("rigid bearing, at its own torque"),
        )],
        x=(0.0, 1.03 * top / rpm),
        y=(0.0, high),
        x_label=say("shaft speed [rpm]"),
        y_label=say("force [N]"),
        note=say(
            "{state}, at full load on the rubber of the bearings; 0-to-peak of orders 2 and 4. "
            "Where an order meets a mode the force is many times that of a rigid bearing.",
            state=say.state(r.demand.states[s]),
        ),
    )  # fmt: skip


def torque_by_gear(r: Response, say: Language) -> Figure:
    """Return the line's torque over its speed in every gear, against what the tyres hold."""
    gears = r.demand.gears
    assert gears is not None  # the caller asks
    series = [
        Series(name=say("gear {gear}", gear=name), x=speed / rpm, y=torque, points=len(speed) == 1)
        for name, speed, torque in zip(gears.names, gears.speed, gears.torque, strict=True)
    ]
    slip = r.demand.slip_torque
    levels = [
        Level(value=float(value), name=say("tyres slip, {states}", states=say.list(*states)))
        for value, states in _alike(slip, [say.state(s) for s in r.demand.states])
    ]
    title = say("Torque by gear, engine against slip")
    peaks = say.list(
        *(f"{n} {say.number(p)}" for n, p in zip(gears.names, gears.peak, strict=True))
    )
    return plot(
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


def critical_speeds(r: Response, say: Language) -> Figure:
    """Return critical speeds of shafts and line, with what to keep out of, against the speed."""
    lowest = np.fmin.reduce(r.critical_speeds, axis=0) / rpm  # nan of a shaft without a tube
    rows = [(say.part(Part("shaft", k)), n) for k, n in enumerate(lowest, 1) if np.isfinite(n)]
    if np.isfinite(r.line_critical_speed):
        rows.append((say("line, as beams"), r.line_critical_speed / rpm))
    if np.isfinite(r.bearing_resonance):
        rows.append((say("line on its rubber"), r.bearing_resonance / rpm))
    top = float(np.nan_to_num(r.demand.speed).max()) / rpm
    ratio, band = _limits(r, "critical_speed_ratio"), _limits(r, "half_critical_band")
    x = (0.0, 1.08 * max(top, *(n for _, n in rows)))
    frame = Chart(
        say=say,
        x=x,
        y=(-0.6, len(rows) - 0.1),
        x_label=say("shaft speed [rpm]"),
        y_label="",
        height=110 + 44.0 * len(rows),
        values=False,
    )
    x1, y1 = frame.spot(0, frame.y[0])
    x2, y2 = frame.spot(top, frame.y[1])
    drawn = [svg.rect(x1, y2, x2 - x1, y1 - y2, fill=PALETTE[0], fill_opacity=0.12)]
    drawn.append(svg.line(x2, y1, x2, y2, stroke=PALETTE[0], stroke_width=2))
    drawn.append(svg.text(x2 + 5, y2 + 10, say("speed range"), font_size=11, fill=PALETTE[0]))
    bounce = say("line on its rubber")
    for k, (name, n) in enumerate(rows):
        y = len(rows) - 1 - k
        a, py = frame.spot(0, y)
        b, _ = frame.spot(n, y)
        drawn.append(svg.line(a, py, b, py, stroke=FAINT, stroke_width=1))
        if name != bounce:
            for grade, low, high in _forbidden(ratio, band):
                c, _ = frame.spot(low * n, y)
                d, _ = frame.spot(min(high * n, x[1]), y)
                drawn.append(svg.rect(c, py - 9, d - c, 18, fill=GRADED[grade], fill_opacity=0.28))
        drawn.append(svg.line(b, py - 12, b, py + 12, stroke=INK, stroke_width=3))
        drawn.append(
            svg.text(frame.spot(0, y)[0] + 5, py - 13, f"{name}: {say.number(n)} rpm", font_size=11)
        )
    title = say("Critical speeds and the speed range")
    said = say.list(*(f"{name} {say.number(n)} rpm" for name, n in rows))
    frame.put(*drawn)
    return frame.figure(
        title=title,
        alt=f"{title}: {said}",
        note=say(
            "Upright bars: critical speeds, the lowest over the states. Shaded: near half "
            "critical, where the joints excite twice a turn, and too near critical, by the "
            "profile's limits."
        ),
    )


def spring_curve(r: Response, say: Language) -> Figure:
    """Return the spring's table as a curve, with the states on it."""
    suspension = r.application.suspension
    assert suspension is not None  # the caller asks
    spring = suspension.spring
    deflection, load = np.array(spring.deflection) / mm, np.array(spring.load) / kN
    # States that rest on the spring say where the others are: travel is counted from one of them.
    rests = np.isfinite(r.demand.suspension_frequency)
    names = [say.state(s) for s in r.demand.states]
    loads = np.where(rests, carried(suspension, r.demand.axle_load), np.nan)
    x = spring_deflection(spring, loads)
    offset = np.nanmedian(x - r.demand.travel) if rests.any() else np.nan
    x = np.where(rests, x, r.demand.travel + offset) / mm
    y = spring_load(spring, x * mm) / kN
    title = say("Spring curve")
    alt = (
        title
        + ". "
        + "; ".join(
            f"{say.short(a, 4)} mm {say.short(b, 4)} kN"
            for a, b in zip(deflection, load, strict=True)
        )
    )
    return plot(
        say,
        title=title,
        alt=alt,
        series=[
            Series(name=say("table of the spring"), x=deflection, y=load, points=True),
            Series(name=say("states"), x=x, y=y, joined=False, points=True, labels=tuple(names)),
        ],
        x_label=say("deflection [mm]"),
        y_label=say("load of one spring [kN]"),
        x=bounds(deflection, x),
        y=bounds(load, y),
    )


def _members(r: Response, say: Language) -> list[str]:
    """Return the names of the members behind the joints."""
    shafts = [say.part(Part("shaft", k)) for k in range(1, r.line.joint_count)]
    return [*shafts, say("pinion")]


def _limits(r: Response, quantity: str) -> list[Limit]:
    return [m for m in r.application.limits if m.quantity == quantity]


def _acceleration(r: Response, quantity: str) -> FloatArray:
    """Return one of the excitation's accelerations by state."""
    e = r.excitation
    one = {"torsional_acceleration": e.torsional, "inertia_drive_acceleration": e.drive}
    return one.get(quantity, e.coast).acceleration


def _ride(r: Response) -> tuple[FloatArray, Response] | None:
    """Return the line at many places of its axle; None where states place it by themselves."""
    travel = r.demand.travel
    if any(s.layouts for s in r.application.states):
        return None
    places = np.linspace(travel.min(), travel.max(), RIDE)
    states = tuple(
        State(name=str(k), travel=float(z), torque=0.0, speed=_gearbox_speed(r))
        for k, z in enumerate(places)
    )
    try:
        application = replace(r.application, states=states)
        return places / mm, respond(application, demand(resolve(application, r.demand.installed)))
    except DesignError:
        return None


def _gearbox_speed(r: Response) -> float:
    """Return the top speed of the gearbox output, of which the line has its share."""
    return float(np.nan_to_num(r.demand.speed).max()) / r.demand.installed.speed_ratio


def _alike(values: FloatArray, names: list[str]) -> list[tuple[float, list[str]]]:
    """Return finite values with the names of those that share them."""
    found: dict[float, list[str]] = {}
    for value, name in zip(values, names, strict=True):
        if np.isfinite(value):
            found.setdefault(round(float(value), 3), []).append(name)
    return [(v, n if len(n) < 4 else [*n[:2], "…"]) for v, n in found.items()]


def _forbidden(ratio: list[Limit], band: list[Limit]) -> Iterator[tuple[str, float, float]]:
    """Yield the shares of a critical speed to keep out of, with what a check says there."""
    for limit in band:
        if limit.band:
            yield "warn", *limit.band
    for limit in ratio:
        if limit.normal is not None:
            yield "warn", limit.normal, limit.maximum or 1.0
        if limit.maximum is not None:
            yield "fail", limit.maximum, 1.0
