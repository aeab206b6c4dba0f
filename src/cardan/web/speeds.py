"""What a line does over its speed: forces gear by gear, its own modes, the vehicle's torsion."""

from collections.abc import Iterable, Iterator, Sequence
from math import pi
from typing import Any, TypeAlias

import numpy as np

from cardan.base.arrays import FloatArray
from cardan.base.part import Part
from cardan.base.units import rpm
from cardan.base.verdict import Limit
from cardan.demand.points import Curves
from cardan.quantity import points
from cardan.quantity.quantities import QUANTITIES
from cardan.quantity.response import Response
from cardan.report.language import Language
from cardan.report.stability import heaviest
from cardan.study.launching import Started
from cardan.study.moves import in_states
from cardan.study.stability import ORDERS, Stability, launch_occasion
from cardan.web.document import Document, Json, Tell, f, fs

SPEEDS = 72
"""Speeds from standing to the fastest at which bearings are asked what they carry."""

NEAR = np.linspace(0.85, 1.15, 11)
"""Beside each resonance, as shares of its speed, they are asked again."""

BEARING_ORDERS = (1, 2, 4, 6)
"""Orders of the shaft's speed that a bearing feels: unbalance, and the joints'."""

SHAKING = (1, 2, 4)
"""Orders that are held against its modes."""

Mode: TypeAlias = tuple[float, str]
"""A frequency, rad/s, and what it is called."""

FORCES = (("dynamic", "centre_bearing_dynamic"), ("peak", "centre_bearing_peak"))
"""Forces that are drawn, and the quantities whose limits count."""

INSTANTS = 400
"""Of a launch, that are drawn."""


def speeds(read: Document, args: Json, say: Language, _: Tell) -> Json:
    """Return what each bearing of a line carries over speed in one state, gear by gear.

    And what of the line itself can resonate there. Nothing where it has no operating points.
    """
    whole = read.responses[min(int(args.get("line", 0)), len(read.responses) - 1)]
    s = min(int(args.get("state", 0)), len(whole.demand.states) - 1)
    r = in_states(whole, (s,))
    found = r.own_curves
    drawn = [k for k, end in enumerate(found.fastest[:, 0]) if end > 0]
    told: Json = {"line": r.line.name, "state": s, "said": say.state(r.demand.states[0])}
    if not drawn:
        return {**told, "gears": [], "bearings": [], "diagrams": []}
    top = float(np.nanmax(found.fastest[drawn, 0]))
    on_rubber, bending = list(_on_rubber(r, say)), list(_bending(r, say))
    meets = [w / n for w, _ in on_rubber for n in SHAKING if w / n < top]
    beside = np.ravel(np.array(meets)[:, None] * NEAR)
    speed = np.unique(np.concatenate([np.linspace(top / SPEEDS, top, SPEEDS), beside]))
    speed = speed[speed <= top * (1 + 1e-9)]
    bearings = r.line.joint_count - 2
    running = points.swept(r, speed, curves_=drawn).running if bearings else None
    return {
        **told,
        "rpm": fs(speed / rpm, 1),
        "gears": [_gear(found, k, say) for k in drawn],
        "bearings": [
            {
                "said": say.part(Part("centre bearing", b + 1)),
                "dynamic": _kept(running.dynamic[:, :, 0, b]),
                "peak": _kept(running.peak[:, :, 0, b]),
                "orders": [_kept(v) for v in _orders(running, b)],
                "limits": {
                    name: [_bounds(m) for m in r.application.limits if m.quantity == key]
                    for name, key in FORCES
                },
                "grades": {
                    name: _grades(getattr(running, name)[:, :, 0, b], r, key)
                    for name, key in FORCES
                },
            }
            for b in range(bearings) if running is not None
        ],
        "orders": list(BEARING_ORDERS),
        "diagrams": [
            _diagram(
                modes, _named(SHAKING, say), say=say, title=title, low=0.0,
                high=min(top, 3 * max(w for w, _ in modes)) if modes is on_rubber else top,
            )
            for title, modes in (
                (say("The line on its bearings"), on_rubber), (say("Bending"), bending),
            ) if modes
        ],
    }  # fmt: skip


def _orders(running: Any, bearing: int) -> Iterator[FloatArray]:
    yield running.order1[:, :, 0, bearing]
    yield from np.moveaxis(running.orders[:, :, 0, bearing], -1, 0)


def _gear(found: Curves, k: int, say: Language) -> Json:
    gear, way = found.gears[k], found.directions[k]
    names = {"coast": say("coast"), "reverse": say("reverse"), "brake": say("braking")}
    said = say("gear {gear}", gear=gear) if gear and gear != "R" else ""
    return {
        "said": say.list(*filter(None, (said, names.get(way) or ("" if said else say("drive"))))),
        "way": way,
        "top": f(float(found.fastest[k, 0]) / rpm, 1),
    }


def _kept(values: FloatArray) -> Any:
    """Return forces (gears, speeds) in N, to a tenth."""
    return fs(values, 1)


def _grades(force: FloatArray, r: Response, key: str) -> Any:
    """Return what limits make of forces (gears, speeds): 0 pass, 1 warn, 2 fail; None unknown."""
    found = np.zeros(force.shape, dtype=int)
    for limit in (m for m in r.application.limits if m.quantity == key):
        found = np.maximum(found, limit.grades(np.nan_to_num(force)))
    return fs(np.where(np.isnan(force), np.nan, found), 0)


def _bounds(limit: Limit) -> Json:
    factor = QUANTITIES[limit.quantity].factor
    return {
        grade: None if bound is None else f(bound / factor, 2)
        for grade, bound in (("warn", limit.normal), ("fail", limit.maximum))
    }


def _on_rubber(r: Response, say: Language) -> Iterator[Mode]:
    """Yield the slowest modes of a line on its bearings, where it can move on them."""
    if r.held is not None and r.line.joint_count > 2:
        found = r.held.modes()
        names = found.names(0)
        for k in range(r.line.swings):
            yield float(found.frequency[0, k]), say(names[k])


def _bending(r: Response, say: Language) -> Iterator[Mode]:
    """Yield the lowest bending of each shaft by itself, and of the line."""
    for k, critical in enumerate(r.critical_speeds[0], 1):
        if np.isfinite(critical):
            yield float(critical), say.part(Part("shaft", k))
    if np.isfinite(r.line_critical_speed):
        yield float(r.line_critical_speed), say("line")


def _named(orders: Iterable[float], say: Language) -> list[tuple[float, str]]:
    return [(n, say("order {order}", order=say.short(n))) for n in orders]


def _diagram(
    modes: Sequence[Mode],
    orders: Sequence[tuple[float, str]],
    *,
    say: Language,
    title: str,
    low: float,
    high: float,
    shaded: tuple[float, float] | None = None,
) -> Json:
    """Return a Campbell diagram: frequencies rad/s, orders, speeds from `low` to `high` rad/s.

    Where an order meets a frequency within the speeds there are is a resonance.
    """
    ends = np.array([low, high])
    lowest = min((w for w, _ in modes), default=0.0)
    tall = 1.15 * max(*(w for w, _ in modes if w < 2.5 * max(2 * high, lowest)), 0.0, lowest)
    return {
        "title": title,
        "rpm": fs(ends / rpm, 1),
        "Hz_top": f(tall / (2 * pi), 1),
        "range": [f(v / rpm, 0) for v in shaded] if shaded else None,
        "orders": [{"said": name, "Hz": fs(n * ends / (2 * pi), 2)} for n, name in orders],
        "modes": [{"said": name, "Hz": f(w / (2 * pi), 2)} for w, name in modes if w <= tall],
        "meets": [
            {
                "rpm": f(w / n / rpm, 0), "Hz": f(w / (2 * pi), 2),
                "said": say.list(name, order),
            }
            for w, name in modes for n, order in orders
            if w <= tall and (shaded or (low, high))[0] <= w / n <= (shaded or (low, high))[1]
        ],
    }  # fmt: skip


def torsion(read: Document, _: Json, say: Language, tell: Tell) -> Json:
    """Return the vehicle's torsion in every gear, and its launches."""
    tell({"doing": say("asking what vibrates")})
    of = read.stability
    s = heaviest(of)
    return {
        "state": say.state(of.states[s]),
        "diagrams": [_campbell(of, k, s, say) for k in range(len(of.gears))],
        "launches": [_launch(one, say) for one in of.launches],
    }


def _campbell(of: Stability, k: int, s: int, say: Language) -> Json:
    """Return a gear's torsional frequencies, the orders that meet them, and where zones are."""
    low, high = of.closed.ranges[k, s].tolist()
    modes = [
        (w, say("mode {mode}", mode=m))
        for m, w in enumerate(of.closed.frequencies[k, s].tolist(), 1)
    ]
    orders = _named((1, *ORDERS), say)
    if of.drivetrain.cylinders:
        firing = of.drivetrain.cylinders / 2 * float(of.drivetrain.ratios[k])
        orders.append((firing, say("engine firing, order {order}", order=say.number(firing))))
    gear = say.occasion(of.gears[k])
    return {
        **_diagram(modes, orders, say=say, title=gear, low=0.0, high=high, shaded=(low, high)),
        "zones": [
            {"rpm": f(float(z.speed[k, s]) / rpm, 0), "open": bool(z.openness[k, s] > 1)}
            for z in of.zones
            if float(z.speed[k, s]) <= high
        ],
    }


def _launch(of: Started, say: Language) -> Json:
    """Return what a start from rest does to the first shaft and to the bearings."""
    travel, k = of.travel, of.first
    every = np.linspace(0, len(travel.time) - 1, INSTANTS).astype(int)
    return {
        "said": say.occasion(launch_occasion(of.launch)),
        "peak": f(float(of.peak[k]), 0),
        "target": f(of.torque, 0),
        "locked": f(of.locked, 2),
        "slid": of.slid,
        "time": fs(travel.time[every], 3),
        "torque": [
            {"said": say(name), "values": fs(travel.torque[case, every, k], 0)}
            for case, name in ((0, "as it is"), (1, "joints straight"), (4, "tyres that stick"))
        ],
        "bearing_time": fs(of.bearing_time[every], 3),
        "bearings": [
            {"said": say.part(Part("centre bearing", b + 1)), "values": fs(force, 0)}
            for b, force in enumerate(_passed(of)[every].T)
        ],
    }


def _passed(of: Started) -> FloatArray:
    """Return the force on the bearings as a launch passes through, where that is known."""
    known = np.isfinite(of.bearing_passed).all()
    return of.bearing_passed if known else of.bearing_force
