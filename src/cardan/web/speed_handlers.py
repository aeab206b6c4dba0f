"""What a line does over its speed: forces gear by gear, its own modes, the vehicle's torsion."""

from collections.abc import Iterable, Iterator, Sequence
from math import pi
from typing import Any, TypeAlias

import numpy as np

from cardan.approval.applied_adjustments import line_response_in_states
from cardan.checks.line_response import LineResponse
from cardan.checks.quantities.registry import QUANTITIES
from cardan.core.arrays import FloatArray
from cardan.core.labels import Part
from cardan.core.units import rpm
from cardan.core.verdict import Limit
from cardan.physics.vehicle.operating_points import TorqueCurves
from cardan.render.i18n import Translator
from cardan.topics.torsion.launch_study import LaunchResult
from cardan.topics.torsion.vibration_checks import condition_of_launch
from cardan.topics.torsion.vibration_result import (
    EXCITED_ORDERS,
    VibrationResult,
    heaviest_driving_state_index,
)
from cardan.web.parsed_document import (
    Json,
    ParsedDocument,
    PartialResultCallback,
    round_decimals,
    round_decimals_list,
)

FORCE_CURVE_SPEED_COUNT = 72
"""Speeds from standing to the fastest at which the forces on bearings are computed."""

SPEED_TO_RESONANCE_RATIOS_SAMPLED = np.linspace(0.85, 1.15, 11)
"""Speeds next to each resonance, as shares of its speed, that are added."""

PLOTTED_BEARING_FORCE_ORDERS = (1, 2, 4, 6)
"""Orders of the shaft's speed that a bearing feels: unbalance, and the joints'."""

RESONANCE_ORDERS = (1, 2, 4)
"""Orders that are held against its modes."""

NamedFrequency: TypeAlias = tuple[float, str]
"""A frequency, rad/s, and what it is called."""

FORCE_QUANTITIES = (("dynamic", "centre_bearing_dynamic"), ("peak", "centre_bearing_peak"))
"""Forces that are drawn, and the quantities whose limits count."""

LAUNCH_CURVE_POINTS = 400
"""Of a launch, that are drawn."""


def forces_over_speed(
    read: ParsedDocument, args: Json, say: Translator, _: PartialResultCallback
) -> Json:
    """Return what each bearing of a line carries over speed in one state, gear by gear.

    And what of the line itself can resonate there. Nothing where it has no operating points.
    """
    whole = read.responses[min(int(args.get("line", 0)), len(read.responses) - 1)]
    s = min(int(args.get("state", 0)), len(whole.demand.states) - 1)
    r = line_response_in_states(whole, (s,))
    found = r.mounts.demand_torque_curves
    drawn = [k for k, end in enumerate(found.max_speed[:, 0]) if end > 0]
    said = say.state(r.demand.states[0])
    if _meets_stop(whole, s):
        said = say(
            "{state}: forces of linear rubber; it meets its stop, see the limits", state=said
        )
    told: Json = {"line": r.line.name, "state": s, "said": said}
    if not drawn:
        return {**told, "gears": [], "bearings": [], "diagrams": []}
    top = float(np.nanmax(found.max_speed[drawn, 0]))
    on_rubber, bending = list(_mounted_modes(r, say)), list(_bending_modes(r, say))
    meets = [w / n for w, _ in on_rubber for n in RESONANCE_ORDERS if w / n < top]
    beside = np.ravel(np.array(meets)[:, None] * SPEED_TO_RESONANCE_RATIOS_SAMPLED)
    speed = np.unique(
        np.concatenate(
            [np.linspace(top / FORCE_CURVE_SPEED_COUNT, top, FORCE_CURVE_SPEED_COUNT), beside]
        )
    )
    speed = speed[speed <= top * (1 + 1e-9)]
    bearings = r.line.joint_count - 2
    running = r.mounts.forces_over_speed(speed, curves=drawn).results if bearings else None
    return {
        **told,
        "rpm": round_decimals_list(speed / rpm, 1),
        "gears": [_gear_message(found, k, say) for k in drawn],
        "bearings": [
            {
                "said": say.part(Part("centre bearing", b + 1)),
                "dynamic": _force_list(running.dynamic[:, :, 0, b]),
                "peak": _force_list(running.peak[:, :, 0, b]),
                "orders": [_force_list(v) for v in _order_amplitudes(running, b)],
                "limits": {
                    name: [_limit_bounds(m) for m in r.application.limits if m.quantity == key]
                    for name, key in FORCE_QUANTITIES
                },
                "grades": {
                    name: _force_grades(getattr(running, name)[:, :, 0, b], r, key)
                    for name, key in FORCE_QUANTITIES
                },
            }
            for b in range(bearings) if running is not None
        ],
        "orders": list(PLOTTED_BEARING_FORCE_ORDERS),
        "diagrams": [
            _campbell_diagram(
                modes, _named_orders(RESONANCE_ORDERS, say), say=say, title=title, low=0.0,
                high=min(top, 3 * max(w for w, _ in modes)) if modes is on_rubber else top,
            )
            for title, modes in (
                (say("The line on its bearings"), on_rubber), (say("Bending"), bending),
            ) if modes
        ],
    }  # fmt: skip


def _meets_stop(r: LineResponse, state: int) -> bool:
    """Return whether linear rubber of some bearing goes beyond its stop in a state."""
    margins = r.mount_loads.stop_margin("peak")
    states = len(r.demand.states)
    return bool((np.broadcast_to(margins, (states, margins.shape[-1]))[state] < 0).any())


def _order_amplitudes(running: Any, bearing: int) -> Iterator[FloatArray]:
    yield running.order1[:, :, 0, bearing]
    yield from np.moveaxis(running.order_amplitudes[:, :, 0, bearing], -1, 0)


def _gear_message(found: TorqueCurves, k: int, say: Translator) -> Json:
    gear, way = found.gears[k], found.directions[k]
    names = {"coast": say("overrun"), "reverse": say("reverse"), "brake": say("braking")}
    said = say("gear {gear}", gear=gear) if gear and gear != "R" else ""
    return {
        "said": say.join(*filter(None, (said, names.get(way) or ("" if said else say("drive"))))),
        "way": way,
        "top": round_decimals(float(found.max_speed[k, 0]) / rpm, 1),
    }


def _force_list(values: FloatArray) -> Any:
    """Return forces (gears, speeds) in N, to a tenth."""
    return round_decimals_list(values, 1)


def _force_grades(force: FloatArray, r: LineResponse, key: str) -> Any:
    """Return what limits make of forces (gears, speeds): 0 pass, 1 warn, 2 fail; None unknown."""
    found = np.zeros(force.shape, dtype=int)
    for limit in (m for m in r.application.limits if m.quantity == key):
        found = np.maximum(found, limit.grades(np.nan_to_num(force)))
    return round_decimals_list(np.where(np.isnan(force), np.nan, found), 0)


def _limit_bounds(limit: Limit) -> Json:
    factor = QUANTITIES[limit.quantity].si_factor
    return {
        grade: None if bound is None else round_decimals(bound / factor, 2)
        for grade, bound in (("warn", limit.normal), ("fail", limit.maximum))
    }


def _mounted_modes(r: LineResponse, say: Translator) -> Iterator[NamedFrequency]:
    """Yield the slowest modes of a line on its bearings, where it can move on them."""
    if r.mounts.mounted_line is not None and r.line.joint_count > 2:
        found = r.mounts.mounted_line.modes()
        names = found.mode_names(0)
        for k in range(r.line.rigid_body_mode_count):
            yield float(found.frequency[0, k]), say(names[k])


def _bending_modes(r: LineResponse, say: Translator) -> Iterator[NamedFrequency]:
    """Yield the lowest bending of each shaft by itself, and of the line."""
    for k, critical in enumerate(r.strength.critical_speeds[0], 1):
        if np.isfinite(critical):
            yield float(critical), say.part(Part("shaft", k))
    if np.isfinite(r.strength.line_critical_speed):
        yield float(r.strength.line_critical_speed), say("line")


def _named_orders(orders: Iterable[float], say: Translator) -> list[tuple[float, str]]:
    return [(n, say("order {order}", order=say.compact_number(n))) for n in orders]


def _campbell_diagram(
    modes: Sequence[NamedFrequency],
    orders: Sequence[tuple[float, str]],
    *,
    say: Translator,
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
        "rpm": round_decimals_list(ends / rpm, 1),
        "Hz_top": round_decimals(tall / (2 * pi), 1),
        "range": [round_decimals(v / rpm, 0) for v in shaded] if shaded else None,
        "orders": [
            {"said": name, "Hz": round_decimals_list(n * ends / (2 * pi), 2)} for n, name in orders
        ],
        "modes": [
            {"said": name, "Hz": round_decimals(w / (2 * pi), 2)} for w, name in modes if w <= tall
        ],
        "meets": [
            {
                "rpm": round_decimals(w / n / rpm, 0),
                "Hz": round_decimals(w / (2 * pi), 2),
                "said": say.join(name, order),
            }
            for w, name in modes
            for n, order in orders
            if w <= tall and (shaded or (low, high))[0] <= w / n <= (shaded or (low, high))[1]
        ],
    }


def vehicle_torsion(
    read: ParsedDocument, _: Json, say: Translator, tell: PartialResultCallback
) -> Json:
    """Return the vehicle's torsion in every gear, and its launches."""
    tell({"doing": say("calculating vibration")})
    of = read.stability
    s = heaviest_driving_state_index(of)
    return {
        "state": say.state(of.states[s]),
        "diagrams": [_torsional_diagram(of, k, s, say) for k in range(len(of.gears))],
        "launches": [_launch_curves(one, say) for one in of.launches],
    }


def _torsional_diagram(of: VibrationResult, k: int, s: int, say: Translator) -> Json:
    """Return a gear's torsional frequencies, the orders that meet them, and where zones are."""
    low, high = of.closed.ranges[k, s].tolist()
    modes = [
        (w, say("mode {mode}", mode=m))
        for m, w in enumerate(of.closed.frequencies[k, s].tolist(), 1)
    ]
    orders = _named_orders((1, *EXCITED_ORDERS), say)
    if of.drivetrain.cylinders:
        firing = of.drivetrain.cylinders / 2 * float(of.drivetrain.ratios[k])
        orders.append((firing, say("engine firing, order {order}", order=say.number(firing))))
    gear = say.occasion(of.gears[k])
    return {
        **_campbell_diagram(
            modes, orders, say=say, title=gear, low=0.0, high=high, shaded=(low, high)
        ),
        "zones": [
            {
                "rpm": round_decimals(float(z.speed[k, s]) / rpm, 0),
                "open": bool(z.openness[k, s] > 1),
            }
            for z in of.zones
            if float(z.speed[k, s]) <= high
        ],
    }


def _launch_curves(of: LaunchResult, say: Translator) -> Json:
    """Return what a start from rest does to the first shaft and to the bearings."""
    travel, k = of.history, of.first_shaft
    every = np.linspace(0, len(travel.time) - 1, LAUNCH_CURVE_POINTS).astype(int)
    return {
        "said": say.occasion(condition_of_launch(of.launch)),
        "peak": round_decimals(float(of.peak_torque[k]), 0),
        "target": round_decimals(of.torque, 0),
        "locked": round_decimals(of.lockup_time, 2),
        "slid": of.tyres_slid,
        "time": round_decimals_list(travel.time[every], 3),
        "torque": [
            {"said": say(name), "values": round_decimals_list(travel.torque[case, every, k], 0)}
            for case, name in ((0, "as it is"), (1, "joints straight"), (4, "tyres that stick"))
        ],
        "bearing_time": round_decimals_list(of.bearing_time[every], 3),
        "bearings": [
            {
                "said": say.part(Part("centre bearing", b + 1)),
                "values": round_decimals_list(force, 0),
            }
            for b, force in enumerate(_bearing_launch_force(of)[every].T)
        ],
    }


def _bearing_launch_force(of: LaunchResult) -> FloatArray:
    """Return the force on the bearings as a launch passes through, where that is known."""
    known = np.isfinite(of.bearing_transient_force).all()
    return of.bearing_transient_force if known else of.bearing_force
