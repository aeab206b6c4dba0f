"""The JSON contract: an approval as numbers with units in their keys, versioned.

Keys are added, never renamed or removed. What could not be computed is null. What a
quantity declares as its place in a state is filled in from the declaration; vectors, orders
and approximations are added.
"""

from math import pi
from typing import Any

import numpy as np

from cardan.approval.approval import Approval
from cardan.approval.registry import study_registrations
from cardan.approval.study import load_function
from cardan.checks.line_response import LineResponse
from cardan.checks.quantities.registry import LINE_QUANTITIES, QUANTITIES
from cardan.checks.rubber_at_stop import FORCE_KINDS
from cardan.checks.stuck_spline import STUCK_FORCE_KINDS
from cardan.core.errors import FileIssue
from cardan.core.labels import Part
from cardan.core.units import deg, mm, rpm
from cardan.physics.kinematics.equivalent_angle import EquivalentSingleJoint, KinematicExcitation
from cardan.render.i18n import ENGLISH
from cardan.render.json_contract import (
    JSON_FORMAT_VERSION,
    catalogue_datum_json,
    check_json,
    coverage_json,
    operating_point_json,
    to_json_types,
)
from cardan.render.phrases import verdict_text
from cardan.topics.design import phasing_table as phased


def json_document(of: Approval) -> dict[str, Any]:
    """Return an approval as the contract's document."""
    main, *others = of.line_responses
    each = {r.line.name: _line_states_json(r) for r in of.line_responses}
    states: list[dict[str, Any]] = []
    for s, name in enumerate(main.demand.states):
        state = {"name": name, "line": main.line.name, **each[main.line.name][s]}
        if others:
            state["lines"] = {r.line.name: each[r.line.name][s] for r in others}
        states.append(state)
    document = {
        "cardan": JSON_FORMAT_VERSION,
        "application": of.application.title,
        "verdict": of.verdict,
        "headline": verdict_text(of, ENGLISH),
        "not_evaluated": list(of.not_evaluated),
        "states_not_given": list(of.state_kinds_not_given),
        "profile": of.application.profile,
        "states": states,
        "phasings": {r.line.name: phased.json_document(r) for r in of.line_responses},
        "checks": [check_json(c) for c in of.checks],
        "coverage": coverage_json(of.coverage),
        "studies": list(of.studies),
        "not_asked": list(of.unevaluated_quantities()),
        "notes": list(of.notes),
        "data": [catalogue_datum_json(d) for d in of.catalogue_data],
        "warnings": [_warning_json(p) for p in of.application.warnings],
    }
    for found in of.study_results:
        entries = study_registrations()[found.study].json_entries
        if entries and found.answer is not None:
            document.update(load_function(entries)(found))
    return to_json_types(document)


def _warning_json(p: FileIssue) -> dict[str, Any]:
    """Return what looks wrong in a file; of a contradiction, the relation and the other values."""
    found: dict[str, Any] = {
        "line": p.line, "column": p.column, "key": p.key, "message": p.message, "hint": p.hint,
    }  # fmt: skip
    if p.relation:
        found |= {
            "value": p.value,
            "relation": p.relation,
            "source": p.source,
            "against": [
                {"key": at.key, "line": at.line, "value": value} for at, value in p.against
            ],
        }
    return found


def _line_states_json(r: LineResponse) -> list[dict[str, Any]]:
    """Return what a line does in each of its states."""
    found = [_undeclared_values_json(r, s) for s in range(len(r.demand.states))]
    for quantity in LINE_QUANTITIES.values():
        if not quantity.json_path or quantity.parts is None:
            continue
        values, parts = quantity.values(r) / quantity.si_factor, quantity.parts(r)
        for state, row in zip(found, values, strict=True):
            if not parts and quantity.json_path.isidentifier():  # readers look for the key
                state[quantity.json_path] = None
            for k, (part, value) in enumerate(zip(parts, row, strict=True)):
                _insert_value(state, quantity.json_path.split("."), part, k, value)
    return found


def _insert_value(inside: Any, path: list[str], part: Part, place: int, value: float) -> None:
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
        _insert_value(inside[key][place], rest, part, place, value)
    else:
        _insert_value(inside.setdefault(key, {}), rest, part, place, value)


def _undeclared_values_json(r: LineResponse, s: int) -> dict[str, Any]:
    """Return what no single quantity holds: vectors, orders, the field's approximations."""
    bearings, forces = (
        r.rigid_loads.joint_loads.bearing_forces,
        r.rigid_loads.joint_loads.joint_forces,
    )
    small_static, small_dynamic = (f[s] for f in r.rigid_loads.small_angle_bearing_forces)
    orders = {k: bearings.amplitude(k)[s] for k in (1, 2, 4)}
    if r.rigid_loads.unbalance_forces:
        orders[1] = orders[1] + r.rigid_loads.unbalance_forces.bearing_forces[s]
    peaks = forces.peak[s]
    return {
        "points": _operating_points_json(r, s),
        "joints": [{"force_N": peak} for peak in peaks],
        "members": [{"member": str(part)} for part in QUANTITIES["side_slope"].parts_of(r)],
        "shafts": [{"shaft": k + 1} for k in range(r.line.joint_count - 1)],
        "axles": [{"axle": str(part)} for part in QUANTITIES["axle_load_rest"].parts_of(r)],
        **_equivalent_angles_json(r.kinematics.excitation, s),
        "approximations": {
            n: _excitation_json(e, s) for n, e in r.kinematics.approximate_excitations.items()
        },
        "centre_bearings": [
            {
                "shaft": k + 1,
                "static_N": bearings.static[s, k].tolist(),
                "dynamic_N": bearings.dynamic[s, k],
                "peak_N": r.rigid_loads.rigid_bearing_peaks[s, k],
                "on_rubber": _mounted_bearing_json(r, s, k),
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
        "end_bearings_N": {k: f[s] for k, f in r.rigid_loads.static_end_bearing_forces.items()},
        "end_bearings_worst_N": {},
    }


def _operating_points_json(r: LineResponse, s: int) -> list[dict[str, Any]]:
    """Return the operating points of a state that limits apply at, those of bearings apart."""
    if r.operating_envelope is None:
        return []
    spots = r.operating_envelope.points.first_variant
    named = (spots.operating_point((p, s)) for p in range(len(spots.speed)))
    return [operating_point_json(of) for of in dict.fromkeys(named) if of is not None]


def _mounted_bearing_json(r: LineResponse, s: int, k: int) -> dict[str, Any] | None:
    """Return what a bearing carries as it runs; None where the line has no operating point."""
    worst = r.mount_loads.worst_bearing_forces.get("peak")
    at = worst.operating_point((s, k)) if worst else None
    if worst is None or at is None:
        return None
    found, own = worst.results, r.mount_loads.mounted_bearing_forces
    far = r.mount_loads.worst_bearing_travel
    goes = far.operating_point((s, k)) if far and r.line.centre_bearings[k].stiffness else None
    modes = r.mounts.mounted_line.modes() if r.mounts.mounted_line else None
    return {
        "at_speed": {
            "dynamic_N": own.dynamic[s, k],
            "order2_N": own.order_amplitudes[s, k, 0],
            "order1_N": own.order1[s, k],
            "static_N": own.static[s, k],
        },
        "worst": {
            "peak_N": found.peak[s, k],
            "dynamic_N": found.dynamic[s, k],
            "order2_N": found.order_amplitudes[s, k, 0],
            "order1_N": found.order1[s, k],
            "static_N": found.static[s, k],
            "thrust_N": found.thrust[s, k],
            **operating_point_json(at),
        },
        "travel": None if far is None or goes is None else {
            "travel_mm": far.results.peak[s, k] / mm,
            "steady_mm": far.results.static[s, k] / mm,
            "stop_mm": r.mount_loads.mount_stop_travel[..., k].item() / mm,
            **operating_point_json(goes),
        },
        **_at_stop_json(r, s, k),
        **_spline_stuck_json(r, s, k),
        "modes": [] if modes is None else [
            {
                "frequency_Hz": frequency / (2 * pi),
                "shape": shape,
                "damping": damping,
                "speed_of_order_2_rpm": frequency / 2 / rpm,
            }
            for frequency, shape, damping in zip(
                modes.frequency[s], modes.mode_names(s), modes.damping_ratio[s], strict=True
            )
        ],
    }  # fmt: skip


def _at_stop_json(r: LineResponse, s: int, k: int) -> dict[str, Any]:
    """Return what a bearing carries in a state in which rubber meets its stop, where solved."""
    of = r.mount_loads.stop_response
    if of is None or not of.is_solved[s]:
        return {}
    at = of.points["peak"].operating_point((s, k))
    known = ~np.isnan(of.travel[:, s, k])
    return {
        "at_stop": {
            "stop_mm": r.mount_loads.rubber_stop_travel.reshape(-1)[k] / mm,
            "stiffness_ratio": of.ratios[known, k].tolist(),
            **{f"{kind}_N": of.forces[kind][known, s, k].tolist() for kind in FORCE_KINDS},
            "travel_mm": (of.travel[known, s, k] / mm).tolist(),
            **({} if at is None else operating_point_json(at)),
        }
    }


def _spline_stuck_json(r: LineResponse, s: int, k: int) -> dict[str, Any]:
    """Return what a bearing carries with the spline stuck in a state, where that is most."""
    loads, found = r.mount_loads, {}
    for kind in STUCK_FORCE_KINDS:
        own = loads.stuck_forces_of(kind, s, k)
        if own and loads.stuck_forces is not None:
            at = loads.stuck_forces.points[kind].operating_point((s, k))
            found[kind] = {
                "force_N": float(loads.stuck_forces.forces[kind][s, k]),
                **({} if at is None else operating_point_json(at)),
            }
    return {"spline_stuck": found} if found else {}


def _equivalent_angles_json(e: KinematicExcitation, s: int) -> dict[str, Any]:
    """Return the equivalent angles of drive and overrun, which no limit applies to."""
    return {
        "torsional": {},
        "drive": {"equivalent_angle_deg": e.drive.angle[s] / deg},
        "coast": {"equivalent_angle_deg": e.coast.angle[s] / deg},
    }


def _excitation_json(e: KinematicExcitation, s: int) -> dict[str, Any]:
    """Return torsional, drive and overrun excitation of one state by an approximation."""

    def joint(of: EquivalentSingleJoint) -> dict[str, Any]:
        return {
            "equivalent_angle_deg": of.angle[s] / deg,
            "acceleration_rad_s2": of.acceleration[s],
        }

    def inertia(of: EquivalentSingleJoint, torque: Any) -> dict[str, Any]:
        return {**joint(of), "torque_Nm": None if torque is None else torque[s]}

    return {
        "torsional": {**joint(e.torsional), "irregularity": e.irregularity[s]},
        "drive": inertia(e.drive, e.drive_torque),
        "coast": inertia(e.coast, e.coast_torque),
    }
