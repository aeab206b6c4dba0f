"""Show how a vehicle vibrates: terminal, JSON, and the charts of its speeds, modes and starts."""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from itertools import groupby
from math import pi
from typing import Any, TypeAlias

import numpy as np

from cardan.base.part import Occasion, Part
from cardan.base.units import UNITS, rpm
from cardan.base.verdict import GRADES, Check, badness
from cardan.quantity.declared import WRITTEN
from cardan.quantity.quantities import QUANTITIES
from cardan.report import svg
from cardan.report.chart import Chart, Level, Series, plot
from cardan.report.contract import CONTRACT, check, coverage, plain
from cardan.report.language import EN, Language
from cardan.report.screen import WIDTH, folded, table
from cardan.report.svg import FAINT, GRADED, GRID, INK, PALETTE, Figure
from cardan.report.terminal import BOLD, COLOURS, PLAIN, summary
from cardan.report.wording import held
from cardan.study.approval import Approval
from cardan.study.finding import VIBRATION
from cardan.study.launching import Started
from cardan.study.powertrain import Freedom
from cardan.study.stability import (
    ORDERS,
    RUBBER_LOSS,
    SHOWN,
    Driven,
    Shift,
    Stability,
    clutched,
    launch_occasion,
)

KEYS = {
    "axle_inertia": "axle_inertia_kgm2",
    "axle_stiffness": "axle_stiffness_Nm_rad",
    "gearbox_inertia": "gearbox_inertia_kgm2",
    "gearbox_stiffness": "gearbox_stiffness_Nm_rad",
    "damping_ratio": "damping_ratio",
    "rubber_loss": "rubber_loss",
}
"""What the document calls what stands in place of parts."""


def text(
    of: Approval, *, every: bool = False, say: Language = EN, width: int = WIDTH
) -> Iterator[str]:
    """Yield the verdict, the worst check of each part and the vehicle's numbers, gear by gear.

    With `every` each check has its row.
    """
    found: Stability = of.of(VIBRATION)
    doubts = (say("Not asked: {what}.", what=doubt) for doubt in found.doubts)
    limits = say("limits: {profile}", profile=of.application.profile)
    yield from folded([*summary(of, say), limits, *basis(found, say), *doubts], width)
    rows = list(of.checks) if every else list(worst_of_parts(of.checks))
    yield ""
    rows.sort(key=lambda c: (-GRADES.index(c.grade), c.quantity, c.margin))
    head = "", *map(say, ("quantity", "part", "where it is worst", "value", "limit"))
    yield from table(head, [_row(c, say) for c in rows], width)
    for caption, head, lines, _ in tables(found, say):
        yield ""
        yield from (f"{BOLD}{line}{PLAIN}" for line in folded([caption], width))
        yield from (f"  {line}" for line in table(head, lines, width - 2))


def _row(c: Check, say: Language) -> tuple[str, ...]:
    """Return a check as a row of the screen."""
    q, (value, bound) = QUANTITIES[c.quantity], held(c, say)
    sense = say("outside") if c.limit.band else c.limit.sense
    return (
        f"{COLOURS[c.grade]}{say(c.grade)}{PLAIN}", say.name(c.quantity), say.part(c.part),
        say.occasion(c.when), value, f"{sense} {bound} {q.unit_name}".rstrip(),
    )  # fmt: skip


TableOf: TypeAlias = tuple[str, tuple[str, ...], tuple[tuple[str, ...], ...], int]
"""Caption, head, rows, and how many of its first columns are words."""


def tables(of: Stability, say: Language) -> Iterator[TableOf]:
    """Yield the vehicle's numbers as tables that every medium shows alike."""
    yield _modes(of, say)
    yield _amplitudes(of, say)
    if of.zones:
        yield _zones(of, say)
    if of.launches:
        yield _launches(of, say)
    yield _assumed(of, say)


def _modes(of: Stability, say: Language) -> TableOf:
    """Modes of each gear with where order 2 meets them, in the heaviest state."""
    rows: list[tuple[str, ...]] = []
    s = heaviest(of)
    for driven, clutch in ((of.closed, say("closed")), (of.slipping, say("slipping"))):
        for g, gear in enumerate(of.gears):
            low, high = (driven.ranges[g, s] / rpm).tolist()
            if not np.isfinite(low):
                continue
            found = [
                f"{say.number(float(w) / (2 * pi))} ({say.number(float(w) / 2 / rpm)})"
                for w in driven.frequencies[g, s, :4]
            ]
            rows.append(
                (say.occasion(gear), clutch, f"{say.number(low)}-{say.number(high)}", *found)
            )
    count = max((len(r) for r in rows), default=3) - 3
    head = (say("gear"), say("clutch"), say("speeds [rpm]"),
            *(say("mode {mode}", mode=k) for k in range(1, count + 1)))  # fmt: skip
    caption = say("Torsional modes of the whole vehicle in Hz, and where order 2 meets them in rpm")
    return caption, head, tuple(rows), 2


def _amplitudes(of: Stability, say: Language) -> TableOf:
    """Largest vibratory torque of each gear, its place, speed and state."""
    rows: list[tuple[str, ...]] = []
    for driven, g, when in clutched(of):
        names, lines = driven.powertrain.springs, line_springs(driven)
        for o, order in enumerate(ORDERS):
            values = driven.torque[g, :, o][:, lines]
            s, k = np.unravel_index(int(np.nanargmax(values)), values.shape)
            spring = lines[int(k)]
            rows.append(
                (
                    say.occasion(when), str(order), say.number(float(values[s, k])),
                    _spring(names[spring], of, say), say.state(of.states[int(s)]),
                    say.number(float(driven.speed[g, s, o, spring]) / rpm),
                    say.number(float(driven.mean[g, s, spring])),
                )
            )  # fmt: skip
        if of.drivetrain.firing_torque and driven is of.closed:
            spring = lines[int(of.firing[g, lines].argmax())]
            rows.append(
                (say.occasion(when), say("firing"), say.number(float(of.firing[g, spring])),
                 _spring(names[spring], of, say), "", "", "")
            )  # fmt: skip
    head = (say("gear"), say("order"), say("torque, 0-to-peak [N·m]"), say("part"), say("state"),
            say("at [rpm]"), say("mean [N·m]"))  # fmt: skip
    return (
        say("Largest vibratory torque of the lines at full load"),
        head,
        tuple(rows),
        1,
    )


def _zones(of: Stability, say: Language) -> TableOf:
    """Each zone where it is nearest to opening."""
    rows: list[tuple[str, ...]] = []
    for z in of.zones:
        if not np.isfinite(z.growth).any():
            continue
        g, s = np.unravel_index(int(np.nanargmax(z.growth)), z.growth.shape)
        opens = np.nanmin(z.opens_at_angle)
        rows.append(
            (
                say.part(z.part), say.occasion(of.gears[int(g)]),
                say.number(float(z.speed[g, s]) / rpm), say.number(float(z.nearest[g, s]) / rpm),
                say.number(float(z.growth[g, s])), say.number(float(opens)),
                say.number(float(np.nanmax(z.opens_at_damping))),
            )
        )  # fmt: skip
    head = (say("zone"), say("gear"), say("middle [rpm]"), say("nearest speed [rpm]"),
            say("growth [1/s]"), say("opens at angles ×"), say("opens at damping ×"))  # fmt: skip
    return say("Parametric zones, each by its own multiplier"), head, tuple(rows), 2


def _launches(of: Stability, say: Language) -> TableOf:
    """Each start from rest: its peak, what makes it, and what follows."""
    rows: list[tuple[str, ...]] = []
    for started in of.launches:
        shares, k = started.shares, started.first
        rows.append(
            (
                say.occasion(launch_occasion(started.launch)), say.number(started.torque),
                say.number(float(started.peak[k])), say.number(float(started.lowest[k])),
                say.number(shares["ramp"]), say.percent(shares["joints"]),
                say.percent(shares["firing"]), say.number(shares["if tyres could not slide"]),
                say("yes") if started.slid else say("no"),
                _largest(started.order_2[k], say), _largest(started.bearing_passed, say),
                _largest(started.bearing_force, say),
            )
        )  # fmt: skip
    head = (say("launch"), say("T i [N·m]"), say("peak [N·m]"), say("lowest [N·m]"),
            say("ramp's peak over T i"), say("joints add"), say("firing adds"),
            say("over T i if tyres stick"), say("tyres slide"), say("order 2 [N·m]"),
            say("bearing force [N]"), say("if each instant lasted [N]"))  # fmt: skip
    return say("Starts from rest: the first shaft of the main line"), head, tuple(rows), 1


def _any(values: Any) -> bool:
    return bool(np.isfinite(values).any())


def _largest(values: Any, say: Language) -> str:
    return say.number(float(np.nanmax(values))) if _any(values) else ""


def _assumed(of: Stability, say: Language) -> TableOf:
    """Values that nobody gave: each with its range, and the modes that move with it."""
    moved = {s.assumption.quantity: s for s in of.shifts}
    rows: list[tuple[str, ...]] = []
    seen: set[str] = set()
    for a in of.drivetrain.assumed:
        if a.quantity in seen:
            continue
        seen.add(a.quantity)
        unit = UNITS[a.typical.unit]
        name = WRITTEN.get(a.typical.unit, a.typical.unit)
        rows.append(
            (
                a.quantity,
                f"{say.number(a.typical.value / unit)} {name}".strip(),
                f"{say.number(a.typical.low / unit)}-{say.number(a.typical.high / unit)}",
                _moved(moved.get(a.quantity), of, say),
                say.source(a.typical.how_read),
            )
        )
    head = (say("value"), say("assumed"), say("range"), say("modes that move by 2 % or more"),
            say("how read"))  # fmt: skip
    caption = say("Assumed, for nobody gave it: typical of a {vehicle}",
                  vehicle=say(of.drivetrain.vehicle_class))  # fmt: skip
    return caption, head, tuple(rows), 5


def _moved(shift: Shift | None, of: Stability, say: Language) -> str:
    """Say which modes an assumption moves over its range."""
    if shift is None:
        return "-"
    base = of.closed.frequencies[of.drivetrain.gears.index(shift.gear), -1]
    said = [
        say("mode {mode}: {low}-{high} Hz", mode=k, low=say.number(low / (2 * pi)),
            high=say.number(high / (2 * pi)))
        for k, (low, high) in enumerate(np.sort(shift.frequencies, axis=0).T.tolist(), 1)
        if max(abs(low / base[k - 1] - 1), abs(high / base[k - 1] - 1)) > 0.02
    ]  # fmt: skip
    where = say.occasion(Occasion("gear", shift.gear)) + ", " if shift.gear else ""
    return where + "; ".join(said)


def heaviest(of: Stability) -> int:
    """Return the place of the heaviest state in which the vehicle drives."""
    drives = np.isfinite(of.closed.ranges).all((0, 2))
    return int(np.where(drives, of.drivetrain.mass, -1.0).argmax())


def line_springs(of: Driven) -> list[int]:
    """Return the places of the springs that are shafts or pinions of a line."""
    return [k for k, (_, p) in enumerate(of.powertrain.springs) if p.kind in {"shaft", "pinion"}]


def _spring(name: Freedom, of: Stability, say: Language) -> str:
    line, part = name
    return say.part(part) + (f", {line}" if line and len(of.lines) > 1 else "")


# ----- JSON ----------------------------------------------------------------------------------


def document(of: Approval) -> dict[str, Any]:
    """Return the JSON document: verdict, checks and the vehicle's numbers, units in the keys."""
    found: Stability = of.of(VIBRATION)
    around = found.surroundings
    ratio = around.damping_ratio
    assumed = {} if ratio is not None else {"damping_ratio": _steel(found) / 2}
    assumed |= {} if around.rubber_loss is not None else {"rubber_loss": RUBBER_LOSS}
    return plain(
        {
            "cardan": CONTRACT,
            "application": of.application.title,
            "verdict": of.verdict,
            "profile": of.application.profile,
            "given": {
                key: getattr(around, name) for name, key in KEYS.items() if name in found.given
            },
            "assumed": assumed,
            "vehicle": vehicle(found),
            "lines": [_line(found, v.line.name) for v in found.lines],
            "checks": [check(c) for c in of.checks],
            "coverage": coverage(of.coverage),
        }
    )


def _steel(of: Stability) -> float:
    """Loss factor of the springs of steel."""
    rows = [a.typical.value for a in of.drivetrain.assumed if a.quantity == "steel.loss"]
    return rows[0] if rows else 0.0


def vehicle(of: Stability) -> dict[str, Any]:
    """Return the vehicle in torsion: its gears with modes, crossings and torques, its starts."""
    s = heaviest(of)
    return {
        "class": of.drivetrain.vehicle_class,
        "state": of.states[s],
        "assumed": [
            {
                "quantity": a.quantity, "line": a.line,
                "value": a.typical.value / UNITS[a.typical.unit],
                "low": a.typical.low / UNITS[a.typical.unit],
                "high": a.typical.high / UNITS[a.typical.unit], "unit": a.typical.unit,
                "source": a.typical.source, "how_read": a.typical.how_read,
            }
            for a in of.drivetrain.assumed
        ],
        "sensitivity": [
            {
                "quantity": shift.assumption.quantity, "gear": shift.gear,
                "low_Hz": (shift.frequencies[0] / (2 * pi)).tolist(),
                "high_Hz": (shift.frequencies[1] / (2 * pi)).tolist(),
            }
            for shift in of.shifts
        ],
        "gears": [_gear(of, g, s) for g in range(len(of.gears))],
        "launches": [_launch(started) for started in of.launches],
        "doubts": list(of.doubts),
    }  # fmt: skip


def _gear(of: Stability, g: int, s: int) -> dict[str, Any]:
    closed = of.closed
    low, high = closed.ranges[g, s].tolist()
    return {
        "gear": of.drivetrain.gears[g],
        "ratio": float(of.drivetrain.ratios[g]),
        "speed_rpm": [low / rpm, high / rpm],
        "closed": {"modes": _mode_list(closed, g, s)},
        "slipping": {"modes": _mode_list(of.slipping, g, s)},
        "crossings": [
            {"order": order, "mode": k, "speed_rpm": w / order / rpm, "clutch": clutch}
            for driven, clutch in ((closed, "closed"), (of.slipping, "slipping"))
            for k, w in enumerate(driven.frequencies[g, s].tolist(), 1)
            for order in ORDERS
            if driven.ranges[g, s, 0] <= w / order <= driven.ranges[g, s, 1]
        ],
        "amplitudes": _amplitude_list(closed, of.states, g),
        "amplitudes_slipping": _amplitude_list(of.slipping, of.states, g),
        "firing": [
            {"part": str(part), "line": line, "torque_Nm": of.firing[g, k]}
            for k, (line, part) in enumerate(closed.powertrain.springs)
        ],
        "pinion_acceleration_rad_s2": {
            v.line.name: float(np.nanmax(closed.acceleration[g, :, k]))
            for k, v in enumerate(of.lines) if _any(closed.acceleration[g, :, k])
        },
    }  # fmt: skip


def _amplitude_list(of: Driven, states: Sequence[str], g: int) -> list[dict[str, Any]]:
    return [
        {
            "order": order, "part": str(part), "line": line,
            "torque_Nm": of.torque[g, worst, o, k],
            "speed_rpm": of.speed[g, worst, o, k] / rpm, "state": states[worst],
            "mean_Nm": of.mean[g, worst, k],
        }
        for k, (line, part) in enumerate(of.powertrain.springs)
        for o, order in enumerate(ORDERS)
        if _any(of.torque[g, :, o, k])
        for worst in (int(np.nanargmax(of.torque[g, :, o, k])),)
    ]  # fmt: skip


def _mode_list(of: Driven, g: int, s: int) -> list[dict[str, Any]]:
    shapes = referred(of, g, s)
    return [
        {
            "frequency_Hz": float(of.frequencies[g, s, k]) / (2 * pi),
            "damping_ratio": float(of.damping[g, s, k + 1]),
            "shape": {
                f"{line} {part}".strip(): float(x)
                for (line, part), x in zip(of.powertrain.freedoms, shapes[:, k], strict=True)
            },
        }
        for k in range(min(SHOWN, of.frequencies.shape[-1]))
    ]


def referred(of: Driven, g: int, s: int) -> np.ndarray:
    """Return shapes (n, modes) of a gear, turned as the main line turns, at most 1."""
    shape = of.modes.shape[g, s]
    rigid = np.abs(shape[:, 0])
    wheels = [k for k, (_, p) in enumerate(of.powertrain.freedoms) if p.kind == "wheels"]
    scale = np.where(rigid > 1e-6 * rigid.max(), rigid, rigid[wheels[0]])
    turned = shape[:, 1:] / scale[:, None]
    return turned / np.abs(turned).max(0)


def _launch(started: Started) -> dict[str, Any]:
    k = started.first
    rows = slice(None, None, max(1, len(started.travel.time) // 400))
    return {
        "gear": started.launch.gear,
        "ramp_s": started.launch.ramp,
        "capacity": started.launch.capacity,
        "state": started.state,
        "clutch_torque_Nm": started.torque,
        "peak_torque_Nm": started.peak[k],
        "lowest_torque_Nm": started.lowest[k],
        "shares": started.shares,
        "tyres_slide": started.slid,
        "locked_s": started.locked,
        "pinion_acceleration_rad_s2": started.acceleration,
        "parts": [
            {
                "part": str(part), "line": line, "peak_Nm": started.peak[j],
                "lowest_Nm": started.lowest[j],
                "order_2_Nm": np.nanmax(started.order_2[j]) if _any(started.order_2[j]) else None,
            }
            for j, (line, part) in enumerate(started.springs) if part.kind != "vehicle"
        ],
        "time_s": started.travel.time[rows].tolist(),
        "torque_Nm": started.travel.torque[0, rows, k].tolist(),
        "order_2_Nm": started.order_2[k, rows].tolist(),
        "bearings": [
            {"steady_N": steady, "passing_N": passing}
            for steady, passing in zip(
                started.bearing_force.max(0).tolist(), started.bearing_passed.max(0).tolist(),
                strict=True,
            )
        ],
        "bearing_time_s": started.bearing_time[rows].tolist(),
        "bearing_force_N": started.bearing_force[rows].tolist(),
        "bearing_passed_N": started.bearing_passed[rows].tolist(),
    }  # fmt: skip


def _line(of: Stability, name: str) -> dict[str, Any]:
    """Return what the document says of a line, as it did before it knew the vehicle."""
    s = heaviest(of)
    with np.errstate(all="ignore"):
        worst = np.nan_to_num(of.amplitudes, nan=-1.0).max(0)
    worst = np.where(worst < 0, np.nan, worst)
    return {
        "name": name,
        "torsional_frequencies_Hz": (of.closed.frequencies[-1, s] / (2 * pi)).tolist(),
        "gears": [
            {"name": str(gear), "speed_rpm": (between / rpm).tolist()}
            for gear, between in zip(of.gears, of.closed.ranges[:, s], strict=True)
        ],
        "zones": [
            {
                "modes": list(z.modes),
                "speed_rpm": float(z.speed[-1, s]) / rpm,
                "growth_per_s": {
                    state: float(np.nanmax(z.growth[:, k])) if _any(z.growth[:, k]) else None
                    for k, state in enumerate(of.states)
                },
                "opens_at_angle_factor": float(np.nanmin(z.opens_at_angle)),
                "opens_at_damping_factor": float(np.nanmax(z.opens_at_damping)),
            }
            for z in of.zones
        ],
        "forced": {
            "speed_rpm": (of.speeds / rpm).tolist(),
            "torque_Nm": {
                state: {f"order {o}": worst[k, j].tolist() for j, o in enumerate(ORDERS)}
                for k, state in enumerate(of.states)
            },
        },
    }


# ----- figures -------------------------------------------------------------------------------


def chart(of: Stability, gear: str | None = None) -> str:
    """Return the Campbell diagram of a gear as an SVG that stands alone."""
    g = shown_gears(of)[-1] if gear is None else of.drivetrain.gears.index(gear)
    return campbell(of, g, EN).svg.replace("<svg ", '<svg font-family="sans-serif" ', 1) + "\n"


def shown_gears(of: Stability) -> tuple[int, ...]:
    """Return the gears that are drawn: the lowest, and the one nearest to direct."""
    direct = int(np.abs(np.log(of.drivetrain.ratios)).argmin())
    return (0, direct) if direct else (0,)


def campbell(of: Stability, g: int, say: Language) -> Figure:
    """Return the diagram of a gear's speeds against the vehicle's torsional frequencies.

    Slanted are the orders of the shaft and the engine's firing as the shaft sees it, level
    the frequencies; where they cross, and the gear has the speed, is resonance.
    """
    s = heaviest(of)
    driven = of.closed
    low, high = (driven.ranges[g, s] / rpm).tolist()
    w = driven.frequencies[g, s]
    top = 1.12 * high
    hertz = 1.15 * max(ORDERS[0] * top / 60, float(w[min(1, len(w) - 1)]) / (2 * pi))
    frame = Chart(
        say=say, x=(0.0, top), y=(0.0, hertz), x_label=say("shaft speed [rpm]"),
        y_label=say("frequency [Hz]"),
    )  # fmt: skip
    x1, y1 = frame.spot(low, 0.0)
    x2, y2 = frame.spot(high, hertz)
    frame.put(svg.rect(x1, y2, max(x2 - x1, 2.0), y1 - y2, fill=PALETTE[3], fill_opacity=0.09))
    orders = {1.0: say("order {order}", order=1), 2.0: say("order {order}", order=2),
              4.0: say("order {order}", order=4)}  # fmt: skip
    if of.drivetrain.cylinders:
        firing = of.drivetrain.cylinders / 2 * float(of.drivetrain.ratios[g])
        orders[firing] = say("engine firing, order {order}", order=say.number(firing))
    for k, (order, name) in enumerate(orders.items()):
        end = min(top, hertz * 60 / order)
        x = np.array([0.0, end])
        frame.series(Series(name=name, x=x, y=order * x / 60), k)
    shown = [f for f in (w / (2 * pi)).tolist() if f <= hertz]
    for frequency in shown:
        frame.level(Level(value=frequency, name=""))
        for order in orders:
            at = 60 * frequency / order
            if low <= at <= high:
                frame.put(svg.circle(*frame.spot(at, frequency), 4, fill="none", stroke=INK))
    for near in _near(shown, hertz / 22):
        said = [say("mode {mode}, {frequency} Hz", mode=shown.index(f) + 1,
                    frequency=say.pointed(f"{f:.1f}")) for f in near]  # fmt: skip
        x, y = frame.spot(top, near[-1])
        frame.put(svg.text(x - 4, y - 4, "; ".join(said), anchor="end", font_size=11))
    for zone in of.zones:
        at = float(zone.speed[g, s]) / rpm
        if at < top:
            x, y = frame.spot(at, 0.0)
            open_here = float(np.nanmax(zone.growth[g])) > 0 if _any(zone.growth[g]) else False
            fill = GRADED["fail" if open_here else "pass"]
            frame.put(
                svg.path([x - 5, x + 5, x], [y, y, y - 11], close=True, fill=fill, stroke="none")
            )
    title = say("Speeds against torsional frequencies, {gear}", gear=say.occasion(of.gears[g]))
    modes = say.list(*(f"{say.number(float(f) / (2 * pi))} Hz" for f in w[:SHOWN]))
    return frame.figure(
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


def shapes(of: Stability, g: int, say: Language, count: int = 5) -> Figure:
    """Return the shapes of a gear's lowest modes, each rotation as the main line turns."""
    s = heaviest(of)
    driven = of.closed
    turned = referred(driven, g, s)
    count = min(count, turned.shape[1])
    names = driven.powertrain.freedoms
    place = {name: k for k, name in enumerate(names)}
    left, step, high, foot = 118.0, 34.0, 62.0, 104.0
    width = left + step * (len(names) - 1) + 30
    height = high * count + foot
    out: list[str] = []
    for m in range(count):
        y0 = high * (m + 0.5) + 6
        colour = PALETTE[m % len(PALETTE)]
        out.append(svg.line(left, y0, left + step * (len(names) - 1), y0, stroke=GRID))
        frequency = say.pointed(f"{float(driven.frequencies[g, s, m]) / (2 * pi):.2f}")
        out.append(svg.text(8, y0 - 2, say("mode {mode}", mode=m + 1), font_size=11))
        out.append(svg.text(8, y0 + 12, f"{frequency} Hz", font_size=11, fill=FAINT))
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
    alt = f"{title}: {say.list(*(f'{say.number(f)} Hz' for f in each.tolist()))}"
    return Figure(
        title=title, svg=svg.drawing(width, height, *out, alt=alt), alt=alt,
        note=say("Each rotation as the main line turns, the largest of a mode drawn as 1."),
    )  # fmt: skip


def _joined(of: Driven) -> Iterator[tuple[int, int]]:
    """Yield pairs of freedoms that a spring is between."""
    line = of.powertrain.line
    reaches = np.abs(line.springs @ line.straight) > 0
    for row in reaches:
        ends = np.flatnonzero(row).tolist()
        for b in ends[1:]:
            yield ends[0], b


def forced(of: Stability, say: Language) -> Figure:
    """Return the largest torque of order 2 in the lines against speed, gear by gear."""
    title = say("Torque of forced torsional vibration")
    series: list[Series] = []
    for g, gear in enumerate(of.gears):
        values = of.amplitudes[g, :, 0]
        known = np.isfinite(values).any(0)
        if known.any():
            worst = np.nanmax(values[:, known], axis=0)
            series.append(Series(name=say.occasion(gear), x=of.speeds[known] / rpm, y=worst))
    said = say.list(*(f"{s.name} {say.number(float(s.y.max()))} N·m" for s in series))
    return plot(
        say, title=title, alt=f"{title}: {said}", series=series, zero=True,
        x_label=say("shaft speed [rpm]"), y_label=say("torque, 0-to-peak [N·m]"),
        note=say("Order 2, largest of all states and shafts, at the full load of each speed."),
    )  # fmt: skip


def started(of: Started, say: Language) -> Iterator[Figure]:
    """Yield a launch's torque, and the amplitude of order 2 in it, against time."""
    travel, k = of.travel, of.first
    when = say.occasion(launch_occasion(of.launch))
    title = say("Torque of a start from rest, {launch}", launch=when)
    peak = say.number(float(of.peak[k]))
    yield plot(
        say, title=title, alt=f"{title}: {peak} N·m",
        series=[
            Series(name=say("as it is"), x=travel.time, y=travel.torque[0, :, k]),
            Series(name=say("joints straight"), x=travel.time, y=travel.torque[1, :, k]),
            Series(name=say("tyres that stick"), x=travel.time, y=travel.torque[4, :, k]),
        ],
        levels=[Level(value=of.torque, name="T i")], zero=True,
        x_label=say("time [s]"), y_label=say("torque [N·m]"),
        note=say("Of the first shaft of the main line."),
    )  # fmt: skip
    lines = [j for j, (_, p) in enumerate(of.springs) if p.kind in {"shaft", "pinion"}]
    title = say("Order 2 of a start from rest, {launch}", launch=when)
    yield plot(
        say, title=title, alt=title,
        series=[
            Series(
                name=say.part(of.springs[j][1]) + f", {of.springs[j][0]}",
                x=travel.time, y=of.order_2[j],
            )
            for j in lines if _any(of.order_2[j])
        ],
        zero=True, x_label=say("time [s]"), y_label=say("torque, 0-to-peak [N·m]"),
        note=say("What the joints alone add, over half a turn round each instant."),
    )  # fmt: skip
    if of.bearing_force.size:
        title = say("Force on the centre bearings along the ramp, {launch}", launch=when)
        yield plot(
            say, title=title, alt=title,
            series=[
                Series(name=name.format(say.part(Part("centre bearing", b + 1))),
                       x=of.bearing_time, y=force[:, b])
                for name, force in (
                    ("{}", of.bearing_passed),
                    (say("{part}, if each instant lasted", part="{}"), of.bearing_force),
                )
                for b in range(force.shape[1]) if _any(force[:, b])
            ],
            zero=True, x_label=say("time [s]"), y_label=say("force [N]"),
            note=say("On rubber, at the worst thrust: as the line passes through, and as each "
                     "instant's torque and speed would give it in the end."),
        )  # fmt: skip


@dataclass(frozen=True, kw_only=True)
class Distance:
    """How far the ranges of speed stay from a resonance or zone, as shares of its speed.

    `speed` is in rad/s, of each gear; `shares` (gears,) are 0 where a gear runs through it.
    """

    part: Part
    speed: tuple[float, ...]
    shares: tuple[float, ...]
    grades: tuple[str, ...]


def distances(of: Stability, checks: Iterable[Check]) -> Iterator[Distance]:
    """Yield the distance of each resonance from every range of speed."""
    mine = [c for c in checks if c.quantity == "torsional_resonance"]
    graded = {(c.part, c.when): c for c in mine}
    w = of.closed.frequencies[:, heaviest(of)]
    for part in dict.fromkeys(c.part for c in mine):
        order, mode = part.other, part.number
        assert isinstance(order, int) and isinstance(mode, int)  # noqa: PT018
        each = [graded.get((part, gear)) for gear in of.gears]
        yield Distance(
            part=part, speed=tuple((w[:, mode - 1] / order).tolist()),
            shares=tuple(np.nan if c is None else c.value - 1 for c in each),
            grades=tuple("" if c is None else c.grade for c in each),
        )  # fmt: skip


def basis(of: Stability, say: Language) -> Iterator[str]:
    """Yield what the answer stands on: what was given in place of parts, what is assumed."""
    around = of.surroundings
    said = {
        "gearbox_inertia": "gearbox {value} kg m²",
        "gearbox_stiffness": "gearbox on {value} N m/rad",
        "axle_inertia": "axle {value} kg m²",
        "axle_stiffness": "axle on {value} N m/rad",
        "damping_ratio": "damping ratio {value}",
        "rubber_loss": "loss factor of the rubber {value}",
    }  # fmt: skip
    given = [say(text, value=say.number(getattr(around, name)))
             for name, text in said.items() if name in of.given]  # fmt: skip
    if given:
        yield say("Given in place of parts: {values}.", values="; ".join(given))
    names = list(dict.fromkeys(a.quantity for a in of.drivetrain.assumed))
    most = [s.assumption.quantity for s in _most(of.shifts, of)][:3]
    if names:
        yield say(
            "Assumed: {count} values of a {vehicle}; the modes lean most on {names}.",
            count=len(names), vehicle=say(of.drivetrain.vehicle_class),
            names=say.list(*most) or "-",
        )  # fmt: skip
    if "rubber_loss" not in of.given:
        yield say(
            "Assumed: {values}.", values=say(said["rubber_loss"], value=say.number(RUBBER_LOSS))
        )


def _most(shifts: Sequence[Shift], of: Stability) -> list[Shift]:
    """Return the assumptions by how far they move the lowest two modes."""

    def far(shift: Shift) -> float:
        base = of.closed.frequencies[of.drivetrain.gears.index(shift.gear), -1, :2]
        return float(np.abs(shift.frequencies[:, :2] / base - 1).max())

    return sorted(shifts, key=far, reverse=True)


def worst_of_parts(checks: Iterable[Check]) -> Iterator[Check]:
    """Yield the worst check of each part."""
    for _, same in groupby(sorted(checks, key=_part), key=_part):
        yield min(same, key=badness)


def _part(c: Check) -> tuple[str, str, str]:
    return c.quantity, c.line, str(c.part)
