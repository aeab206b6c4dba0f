"""The JSON contract: an approval as numbers with units in their keys, versioned.

Keys are added, never renamed or removed. What could not be computed is null. What a
quantity declares as its place in a state is filled in from the declaration; vectors, orders
and approximations stand beside.
"""

from math import isfinite, pi
from typing import Any

import numpy as np

from cardan import __version__
from cardan.base.part import Mode, Occasion, Part, Point
from cardan.base.units import deg, mm, rpm
from cardan.base.verdict import Check, Unanswered
from cardan.kinematics.equivalent import EquivalentJoint, Excitation
from cardan.model.movable import MOVABLES
from cardan.quantity.quantities import ANSWERED, QUANTITIES
from cardan.quantity.response import Response
from cardan.report import phased
from cardan.study.approval import Approval, Coverage
from cardan.study.data import Datum
from cardan.study.finding import RECORDING, VIBRATION
from cardan.study.fix import Proposal
from cardan.study.published import Published
from cardan.study.robust import Survival, Trucks

CONTRACT = ".".join(__version__.split(".")[:2])

DIGITS = 12
"""Significant digits of a number: what is left of it on every machine."""


def approval(of: Approval) -> dict[str, Any]:
    """Return an approval as the contract's document."""
    main, *others = of.responses
    each = {r.line.name: _states(r) for r in of.responses}
    states: list[dict[str, Any]] = []
    for s, name in enumerate(main.demand.states):
        state = {"name": name, "line": main.line.name, **each[main.line.name][s]}
        if others:
            state["lines"] = {r.line.name: each[r.line.name][s] for r in others}
        states.append(state)
    document = {
        "cardan": CONTRACT,
        "application": of.application.title,
        "verdict": of.verdict,
        "profile": of.application.profile,
        "states": states,
        "phasings": {r.line.name: phased.document(r) for r in of.responses},
        "checks": [check(c) for c in of.checks],
        "coverage": coverage(of.coverage),
        "studies": list(of.studies),
        "not_asked": list(of.unasked()),
        "notes": list(of.notes),
        "data": [datum(d) for d in of.data],
        "warnings": [
            {"line": p.line, "column": p.column, "key": p.key, "message": p.message, "hint": p.hint}
            for p in of.application.warnings
        ],
    }
    if of.of(VIBRATION) is not None:
        from cardan.report.stability import vehicle  # few checks ask it

        document["vehicle"] = vehicle(of.of(VIBRATION))
    for finding in of.findings:
        if finding.study == RECORDING and finding.answer is not None:
            from cardan.report.life import mix_document

            document["recording"] = mix_document(finding)
    return plain(document)


def check(of: Check) -> dict[str, Any]:
    """Return one check, in the unit its quantity is shown in."""
    quantity = QUANTITIES[of.quantity]
    return {
        "quantity": of.quantity,
        "line": of.line,
        **_where(of.when, of.part),
        "value": of.value / quantity.factor,
        "limit": of.bound / quantity.factor,
        "sense": "outside" if of.limit.band else of.limit.sense,
        "unit": quantity.unit_name,
        "margin": of.margin,
        "verdict": of.grade,
        "source": str(of.limit.source),
        "how_read": of.how_read or None,
        **({"point": operating_point(of.point)} if of.point else {}),
        **({"mode": _met(of.mode)} if of.mode else {}),
        **(
            {"value_within": _within(of.within, quantity.factor), "may_be": of.may_be}
            if of.within
            else {}
        ),
        **({"settled_by": list(of.settled_by)} if of.settled_by else {}),
    }


def _within(ends: tuple[float, float], factor: float) -> list[float | None]:
    """Return between what a value may lie; None for no end."""
    return [end / factor if isfinite(end) else None for end in ends]


def _met(mode: Mode) -> dict[str, Any]:
    return {
        "shape": mode.shape, "frequency_Hz": mode.frequency / (2 * pi), "order": mode.order,
    }  # fmt: skip


def datum(of: Datum) -> dict[str, Any]:
    """Return a row of data that the numbers stand on, and how its values were read."""
    return {
        "line": of.line,
        "kind": of.kind,
        "name": of.name,
        "parts": list(of.parts),
        "source": str(of.source),
        "how_read": of.source.how_read or None,
        "apart": dict(of.source.apart),
        "note": of.note,
    }


def operating_point(of: Point) -> dict[str, Any]:
    """Return an operating point."""
    return {
        "gear": of.gear,
        "direction": of.direction,
        "speed_rpm": of.speed / rpm,
        "torque_Nm": of.torque,
    }


def coverage(of: Coverage) -> dict[str, Any]:
    """Return what was asked, and what got no answer, with what it needs."""
    return {
        "asked": of.asked,
        "answered": of.answered,
        "unanswered": [unanswered(u) for u in of.unanswered],
    }


def unanswered(of: Unanswered) -> dict[str, Any]:
    """Return one limit that asked and got no number."""
    return {
        "quantity": of.quantity,
        "line": of.line,
        **_where(of.when, of.part),
        "needs": list(of.needs),
        "required": of.limit.required,
    }


def _where(when: Occasion, part: Part) -> dict[str, Any]:
    """Return when and of what, in words and as what they are."""
    return {
        "state": str(when),
        "part": str(part),
        "when": {"kind": when.kind, "name": when.name, "what": when.what},
        "of": {"kind": part.kind, "number": part.number, "other": part.other},
    }


def proposals(of: tuple[Proposal, ...]) -> list[dict[str, Any]]:
    """Return corrections, with what they move in mm and deg and the verdict each gives."""
    return plain(
        [
            {
                "line": p.line,
                "verdict": p.verdict,
                "cost": p.cost,
                "margin": p.margin,
                "margin_before": p.before,
                "smallest_margin": p.approval.smallest_margin,
                "smallest_margin_before": p.installed.smallest_margin,
                "moves": [
                    {
                        "what": m.adjustable.what,
                        "part": m.adjustable.part,
                        f"amount_{movable.unit}": m.amount / movable.worth,
                    }
                    for m in p.moves
                    for movable in (MOVABLES[m.adjustable.what],)
                ],
                "survival": survival(p.survival, p.trucks),
                "checks": [check(c) for c in p.checks],
                "unanswered": [unanswered(u) for u in p.unanswered],
            }
            for p in of
        ]
    )


def survival(found: Survival | None, trucks: Trucks | None) -> dict[str, Any] | None:
    """Return how many trucks keep what is proposed; null where nothing scatters."""
    if found is None or trucks is None:
        return None
    return {
        "share": found.share,
        "share_without_warnings": found.quiet,
        "each_asked": found.asked,
        "lost": found.lost or None,
        "tighten_first": found.tighter and {"name": found.tighter[0], "share": found.tighter[1]},
        "assumed": trucks.assumed,
        "tolerances": [
            {"name": name, "kind": s.kind, "value": s.values[0]} for name, s in trucks.tolerances
        ],
    }


def published(of: tuple[Published, ...]) -> list[dict[str, Any]]:
    """Return published cases with what this machine computes."""
    return plain(
        [
            {
                "case": c.title,
                "kind": c.kind,
                "source": str(c.source),
                "published": c.expected,
                "computed": c.computed,
                "within": c.within,
                "agrees": c.agrees,
            }
            for c in of
        ]
    )


def _states(r: Response) -> list[dict[str, Any]]:
    """Return what a line does in each of its states."""
    found = [_beside(r, s) for s in range(len(r.demand.states))]
    for quantity in ANSWERED.values():
        if not quantity.contract or quantity.parts is None:
            continue
        values, parts = quantity.values(r) / quantity.factor, quantity.parts(r)
        for state, row in zip(found, values, strict=True):
            if not parts and quantity.contract.isidentifier():  # readers look for the key
                state[quantity.contract] = None
            for k, (part, value) in enumerate(zip(parts, row, strict=True)):
                _put(state, quantity.contract.split("."), part, k, value)
    return found


def _put(inside: Any, path: list[str], part: Part, place: int, value: float) -> None:
    """Put a value where a contract's path says: into tables, and lists of parts.

    A path's key of a list leads to the entry of the part; one that ends in [] is a list of
    the values themselves, and one that ends in {} a table of them by obstacle or letter, the
    smallest of each.
    """
    key, *rest = path
    if key.endswith("[]"):
        inside.setdefault(key.removesuffix("[]"), []).append(value)
    elif key.endswith("{}"):
        table = inside.setdefault(key.removesuffix("{}"), {})
        name = str(part.other or part.number)
        table[name] = min(value, table.get(name, value))
    elif not rest:
        inside[key] = value
    elif isinstance(inside.get(key), list):
        _put(inside[key][place], rest, part, place, value)
    else:
        _put(inside.setdefault(key, {}), rest, part, place, value)


def _beside(r: Response, s: int) -> dict[str, Any]:
    """Return what no single quantity holds: vectors, orders, the field's approximations."""
    bearings, forces = r.loads.bearing_forces, r.loads.joint_forces
    small_static, small_dynamic = (f[s] for f in r.small_angle_bearings)
    orders = {k: bearings.amplitude(k)[s] for k in (1, 2, 4)}
    if r.unbalance:
        orders[1] = orders[1] + r.unbalance.bearing_forces[s]
    peaks = forces.peak[s]
    return {
        "points": _points(r, s),
        "joints": [{"force_N": peak} for peak in peaks],
        "members": [{"member": str(part)} for part in QUANTITIES["side_slope"].of_parts(r)],
        "shafts": [{"shaft": k + 1} for k in range(r.line.joint_count - 1)],
        "axles": [{"axle": str(part)} for part in QUANTITIES["axle_load_rest"].of_parts(r)],
        **_angles(r.excitation, s),
        "approximations": {n: _excitation(e, s) for n, e in r.approximations.items()},
        "centre_bearings": [
            {
                "shaft": k + 1,
                "static_N": bearings.static[s, k].tolist(),
                "dynamic_N": bearings.dynamic[s, k],
                "peak_N": r.bearing_peaks[s, k],
                "on_rubber": _on_rubber(r, s, k),
                "orders": {str(o): f[k] for o, f in orders.items()},
                "approximations": {
                    "small_angle": {
                        "static_N": small_static[k].tolist(),
                        "dynamic_N": small_dynamic[k],
                    }
                },
            }
            for k in range(r.line.joint_count - 2)
        ],
        "joint_forces": [
            {"joint": k + 1, "mean_N": mean.tolist(), "peak_N": peaks[k]}
            for k, mean in enumerate(forces.static[s])
        ],
        "clearances_mm": {},
        "clearances_on_rubber_mm": {},
        "end_bearings_N": {k: f[s] for k, f in r.static_end_bearings.items()},
        "end_bearings_worst_N": {},
    }


def _points(r: Response, s: int) -> list[dict[str, Any]]:
    """Return the operating points of a state that limits ask at, those of bearings apart."""
    if r.spread is None:
        return []
    spots = r.spread.spots.first_variant
    named = (spots.named((p, s)) for p in range(len(spots.speed)))
    return [operating_point(of) for of in dict.fromkeys(named) if of is not None]


def _on_rubber(r: Response, s: int, k: int) -> dict[str, Any] | None:
    """Return what a bearing carries as it runs; None where the line has no operating point."""
    worst = r.worst.get("peak")
    at = worst.named((s, k)) if worst else None
    if worst is None or at is None:
        return None
    found, own = worst.running, r.running
    far = r.worst_travel
    goes = far.named((s, k)) if far and r.line.centre_bearings[k].stiffness else None
    modes = r.held.modes() if r.held else None
    return {
        "at_speed": {
            "dynamic_N": own.dynamic[s, k],
            "order2_N": own.orders[s, k, 0],
            "order1_N": own.order1[s, k],
            "static_N": own.static[s, k],
        },
        "worst": {
            "peak_N": found.peak[s, k],
            "dynamic_N": found.dynamic[s, k],
            "order2_N": found.orders[s, k, 0],
            "order1_N": found.order1[s, k],
            "static_N": found.static[s, k],
            "thrust_N": found.thrust[s, k],
            **operating_point(at),
        },
        "travel": None if far is None or goes is None else {
            "travel_mm": far.running.peak[s, k] / mm,
            "steady_mm": far.running.static[s, k] / mm,
            "stop_mm": r.stops[..., k].item() / mm,
            **operating_point(goes),
        },
        "modes": [] if modes is None else [
            {
                "frequency_Hz": frequency / (2 * pi),
                "shape": shape,
                "damping": damping,
                "speed_of_order_2_rpm": frequency / 2 / rpm,
            }
            for frequency, shape, damping in zip(
                modes.frequency[s], modes.names(s), modes.damping[s], strict=True
            )
        ],
    }  # fmt: skip


def _angles(e: Excitation, s: int) -> dict[str, Any]:
    """Return the equivalent angles of drive and coast, which no limit asks about."""
    return {
        "torsional": {},
        "drive": {"equivalent_angle_deg": e.drive.angle[s] / deg},
        "coast": {"equivalent_angle_deg": e.coast.angle[s] / deg},
    }


def _excitation(e: Excitation, s: int) -> dict[str, Any]:
    """Return torsional, drive and coast excitation of one state by an approximation."""

    def joint(of: EquivalentJoint) -> dict[str, Any]:
        return {
            "equivalent_angle_deg": of.angle[s] / deg,
            "acceleration_rad_s2": of.acceleration[s],
        }

    def inertia(of: EquivalentJoint, torque: Any) -> dict[str, Any]:
        return {**joint(of), "torque_Nm": None if torque is None else torque[s]}

    return {
        "torsional": {**joint(e.torsional), "irregularity": e.irregularity[s]},
        "drive": inertia(e.drive, e.drive_torque),
        "coast": inertia(e.coast, e.coast_torque),
    }


def plain(value: Any) -> Any:
    """Return a document of Python's own types, with null for what is not a number.

    Numbers keep as many digits as are the same on every machine.
    """
    if isinstance(value, dict):
        return {k: plain(v) for k, v in value.items()}
    if isinstance(value, list | tuple):
        return [plain(v) for v in value]
    if isinstance(value, float | np.floating):
        return float(f"{value:.{DIGITS}g}") if isfinite(value) else None
    return value.item() if isinstance(value, np.generic) else value
