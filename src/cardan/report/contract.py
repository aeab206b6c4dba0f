"""The JSON contract: an assessment as numbers with units in their keys, versioned.

Keys are added, never renamed or removed. What could not be computed is null.
"""

from math import isfinite
from typing import Any

import numpy as np

from cardan import __version__
from cardan.base.units import deg, hour, mm, rpm
from cardan.base.verdict import Check
from cardan.kinematics.equivalent import EquivalentJoint, Excitation
from cardan.quantity.quantities import QUANTITIES
from cardan.quantity.response import Response
from cardan.study.assess import Assessment
from cardan.study.fix import Proposal
from cardan.study.published import Published

CONTRACT = ".".join(__version__.split(".")[:2])


def assessment(of: Assessment) -> dict[str, Any]:
    """Return an assessment as the contract's document."""
    main, *others = of.responses
    states: list[dict[str, Any]] = []
    for s, name in enumerate(main.demand.states):
        state = {"name": name, "line": main.line.name, **_state(main, s)}
        if others:
            state["lines"] = {r.line.name: _state(r, s) for r in others}
        states.append(state)
    document = {
        "cardan": CONTRACT,
        "application": of.application.title,
        "verdict": of.verdict,
        "profile": of.application.profile,
        "states": states,
        "checks": [check(c) for c in of.checks],
        "not_asked": list(of.unasked()),
        "notes": list(of.notes),
    }
    return _plain(document)


def check(of: Check) -> dict[str, Any]:
    """Return one check, in the unit its quantity is shown in."""
    quantity = QUANTITIES[of.quantity]
    return {
        "quantity": of.quantity,
        "line": of.line,
        "state": of.state,
        "part": of.part,
        "value": of.value / quantity.factor,
        "limit": of.bound / quantity.factor,
        "sense": "outside" if of.limit.band else of.limit.sense,
        "unit": quantity.unit_name,
        "margin": of.margin,
        "verdict": of.grade,
        "source": str(of.limit.source),
    }


def proposals(of: tuple[Proposal, ...]) -> list[dict[str, Any]]:
    """Return corrections, with what they move in mm and deg and the verdict each gives."""
    return _plain(
        [
            {
                "line": p.line,
                "verdict": p.verdict,
                "cost": p.cost,
                "margin": p.margin,
                "margin_before": p.before,
                "moves": [
                    {
                        "what": m.adjustable.what,
                        "part": m.adjustable.part,
                        **(
                            {"amount_mm": m.amount / mm}
                            if m.adjustable.what.startswith("bearing")
                            else {"amount_deg": m.amount / deg}
                        ),
                    }
                    for m in p.moves
                ],
                "checks": [check(c) for c in p.checks],
            }
            for p in of
        ]
    )


def published(of: tuple[Published, ...]) -> list[dict[str, Any]]:
    """Return published cases with what this machine computes."""
    return _plain(
        [
            {
                "case": c.title,
                "source": str(c.source),
                "published": c.expected,
                "computed": c.computed,
                "within": c.within,
                "agrees": c.agrees,
            }
            for c in of
        ]
    )


def _state(r: Response, s: int) -> dict[str, Any]:
    """Return what a line does in its state number s."""
    demand, forces = r.demand, r.loads
    bearings = forces.bearing_forces
    static, dynamic = bearings.static[s], bearings.dynamic[s]
    small_static, small_dynamic = (f[s] for f in r.small_angle_bearings)
    orders = {k: bearings.amplitude(k)[s] for k in (1, 2, 4)}
    if r.unbalance:
        orders[1] = orders[1] + r.unbalance.bearing_forces[s]
    return {
        "torque_Nm": demand.torque[s],
        "engine_torque_Nm": demand.engine_torque[s],
        "slip_torque_Nm": demand.slip_torque[s],
        "coast_torque_Nm": demand.coast_torque[s],
        "speed_rpm": demand.speed[s] / rpm,
        "axle_travel_mm": demand.travel[s] / mm,
        "joints": [
            {
                "angle_deg": r.angles[s, k] / deg,
                "position_deg": r.positions[s, k] / deg,
                "side_deg": r.side_angles[s, k] / deg,
                "top_deg": r.top_angles[s, k] / deg,
                "force_N": forces.joint_forces.peak[s, k],
                "life_h": r.life[s, k] / hour,
            }
            for k in range(r.line.joint_count)
        ],
        **_excitation(r.excitation, s),
        "approximations": {n: _excitation(e, s) for n, e in r.approximations.items()},
        "centre_bearings": [
            {
                "shaft": k + 1,
                "static_N": static[k].tolist(),
                "dynamic_N": dynamic[k],
                "peak_N": r.bearing_peaks[s, k],
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
            {"joint": k + 1, "mean_N": mean.tolist(), "peak_N": peak}
            for k, (mean, peak) in enumerate(
                zip(forces.joint_forces.static[s], forces.joint_forces.peak[s], strict=True)
            )
        ],
        "critical_speeds_rpm": (r.critical_speeds[s] / rpm).tolist(),
        "line_critical_speed_rpm": r.line_critical_speed / rpm,
        "spline_travel_mm": r.spline_travel[s] / mm,
        "end_bearings_N": {letter: force[s] for letter, force in r.end_bearings.items()},
        "spline_force_N": r.spline_force[s],
        "clearances_mm": {
            o.name: r.clearances[s, :, k].min() / mm for k, o in enumerate(r.obstacles)
        },
    }


def _excitation(e: Excitation, s: int) -> dict[str, Any]:
    """Return torsional, drive and coast excitation of one state."""

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


def _plain(value: Any) -> Any:
    """Return a document of Python's own types, with null for what is not a number."""
    if isinstance(value, dict):
        return {k: _plain(v) for k, v in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(v) for v in value]
    if isinstance(value, float | np.floating):
        return float(value) if isfinite(value) else None
    return value.item() if isinstance(value, np.generic) else value
