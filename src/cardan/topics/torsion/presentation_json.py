"""The JSON document of a vibration study."""

from collections.abc import Sequence
from math import pi
from typing import Any

import numpy as np

from cardan.approval.approval import Approval
from cardan.approval.study import VIBRATION_STUDY_NAME, StudyResult
from cardan.core.units import UNITS, rpm
from cardan.render.json_contract import (
    JSON_FORMAT_VERSION,
    check_json,
    coverage_json,
    to_json_types,
)
from cardan.topics.torsion.launch_study import LaunchResult
from cardan.topics.torsion.operating_grid import MAX_SHOWN_MODES
from cardan.topics.torsion.study import DEFAULT_RUBBER_LOSS_FACTOR
from cardan.topics.torsion.vibration_result import (
    EXCITED_ORDERS,
    PowertrainVibration,
    VibrationResult,
    any_known,
    heaviest_driving_state_index,
    mode_shapes_referred_to_main_line,
)

STATED_DRIVETRAIN_VALUE_JSON_KEYS = {
    "axle_inertia": "axle_inertia_kgm2",
    "axle_stiffness": "axle_stiffness_Nm_rad",
    "gearbox_inertia": "gearbox_inertia_kgm2",
    "gearbox_stiffness": "gearbox_stiffness_Nm_rad",
    "damping_ratio": "damping_ratio",
    "rubber_loss": "rubber_loss",
}
"""What the document calls what stands in place of parts."""


# ----- JSON ----------------------------------------------------------------------------------


def json_document(of: Approval) -> dict[str, Any]:
    """Return the JSON document: verdict, checks and the vehicle's numbers, units in the keys."""
    found: VibrationResult = of.answer_of(VIBRATION_STUDY_NAME)
    around = found.surroundings
    ratio = around.damping_ratio
    assumed = {} if ratio is not None else {"damping_ratio": _steel(found) / 2}
    assumed |= {} if around.rubber_loss is not None else {"rubber_loss": DEFAULT_RUBBER_LOSS_FACTOR}
    return to_json_types(
        {
            "cardan": JSON_FORMAT_VERSION,
            "application": of.application.title,
            "verdict": of.verdict,
            "profile": of.application.profile,
            "given": {
                key: getattr(around, name)
                for name, key in STATED_DRIVETRAIN_VALUE_JSON_KEYS.items()
                if name in found.given
            },
            "assumed": assumed,
            "vehicle": vehicle_json(found),
            "lines": [_line(found, v.line.name) for v in found.lines],
            "checks": [check_json(c) for c in of.checks],
            "coverage": coverage_json(of.coverage),
        }
    )


def _steel(of: VibrationResult) -> float:
    """Loss factor of the springs of steel."""
    rows = [a.typical.value for a in of.drivetrain.assumed if a.quantity == "steel.loss"]
    return rows[0] if rows else 0.0


def vibration_json_entries(found: StudyResult[VibrationResult]) -> dict[str, Any]:
    """Return the entry of vibration in an application's JSON document."""
    assert found.answer is not None  # of a study that answered
    return {"vehicle": vehicle_json(found.answer)}


def vehicle_json(of: VibrationResult) -> dict[str, Any]:
    """Return the vehicle in torsion: its gears with modes, crossings and torques, its starts."""
    s = heaviest_driving_state_index(of)
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


def _gear(of: VibrationResult, g: int, s: int) -> dict[str, Any]:
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
            for order in EXCITED_ORDERS
            if driven.ranges[g, s, 0] <= w / order <= driven.ranges[g, s, 1]
        ],
        "amplitudes": _amplitude_list(closed, of.states, g),
        "amplitudes_slipping": _amplitude_list(of.slipping, of.states, g),
        "firing": [
            {"part": str(part), "line": line, "torque_Nm": of.firing_torque[g, k]}
            for k, (line, part) in enumerate(closed.powertrain.springs)
        ],
        "pinion_acceleration_rad_s2": {
            v.line.name: float(np.nanmax(closed.acceleration[g, :, k]))
            for k, v in enumerate(of.lines) if any_known(closed.acceleration[g, :, k])
        },
    }  # fmt: skip


def _amplitude_list(of: PowertrainVibration, states: Sequence[str], g: int) -> list[dict[str, Any]]:
    return [
        {
            "order": order, "part": str(part), "line": line,
            "torque_Nm": of.torque[g, worst, o, k],
            "speed_rpm": of.speed[g, worst, o, k] / rpm, "state": states[worst],
            "mean_Nm": of.mean_torque[g, worst, k],
        }
        for k, (line, part) in enumerate(of.powertrain.springs)
        for o, order in enumerate(EXCITED_ORDERS)
        if any_known(of.torque[g, :, o, k])
        for worst in (int(np.nanargmax(of.torque[g, :, o, k])),)
    ]  # fmt: skip


def _mode_list(of: PowertrainVibration, g: int, s: int) -> list[dict[str, Any]]:
    shapes = mode_shapes_referred_to_main_line(of, g, s)
    return [
        {
            "frequency_Hz": float(of.frequencies[g, s, k]) / (2 * pi),
            "damping_ratio": float(of.damping[g, s, k + 1]),
            "shape": {
                f"{line} {part}".strip(): float(x)
                for (line, part), x in zip(of.powertrain.freedoms, shapes[:, k], strict=True)
            },
        }
        for k in range(min(MAX_SHOWN_MODES, of.frequencies.shape[-1]))
    ]


def _launch(started: LaunchResult) -> dict[str, Any]:
    k = started.first_shaft
    rows = slice(None, None, max(1, len(started.history.time) // 400))
    return {
        "gear": started.launch.gear,
        "ramp_s": started.launch.ramp,
        "capacity": started.launch.capacity,
        "state": started.state,
        "clutch_torque_Nm": started.torque,
        "peak_torque_Nm": started.peak_torque[k],
        "lowest_torque_Nm": started.lowest_torque[k],
        "peak_range_Nm": started.peak_range[:, k].tolist(),
        "lowest_range_Nm": started.lowest_range[:, k].tolist(),
        "assumed_ranges": [
            {"input": a.name, "low": a.low, "high": a.high} for a in started.assumed
        ],
        "shares": started.shares,
        "tyres_slide": started.tyres_slid,
        "locked_s": started.lockup_time,
        "pinion_acceleration_rad_s2": started.acceleration,
        "parts": [
            {
                "part": str(part),
                "line": line,
                "peak_Nm": started.peak_torque[j],
                "lowest_Nm": started.lowest_torque[j],
                "order_2_Nm": np.nanmax(started.order2_amplitude[j])
                if any_known(started.order2_amplitude[j])
                else None,
            }
            for j, (line, part) in enumerate(started.springs)
            if part.kind != "vehicle"
        ],
        "time_s": started.history.time[rows].tolist(),
        "torque_Nm": started.history.torque[0, rows, k].tolist(),
        "order_2_Nm": started.order2_amplitude[k, rows].tolist(),
        "bearings": [
            {"steady_N": steady, "passing_N": passing}
            for steady, passing in zip(
                started.bearing_force.max(0).tolist(),
                started.bearing_transient_force.max(0).tolist(),
                strict=True,
            )
        ],
        "bearing_time_s": started.bearing_time[rows].tolist(),
        "bearing_force_N": started.bearing_force[rows].tolist(),
        "bearing_passed_N": started.bearing_transient_force[rows].tolist(),
    }


def _line(of: VibrationResult, name: str) -> dict[str, Any]:
    """Return what the document says of a line, as it did before it knew the vehicle."""
    s = heaviest_driving_state_index(of)
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
                    state: float(np.nanmax(z.growth[:, k])) if any_known(z.growth[:, k]) else None
                    for k, state in enumerate(of.states)
                },
                "opens_at_angle_factor": float(np.nanmin(z.opening_angle_factor)),
                "opens_at_damping_factor": float(np.nanmax(z.opening_damping_factor)),
            }
            for z in of.zones
        ],
        "forced": {
            "speed_rpm": (of.speeds / rpm).tolist(),
            "torque_Nm": {
                state: {f"order {o}": worst[k, j].tolist() for j, o in enumerate(EXCITED_ORDERS)}
                for k, state in enumerate(of.states)
            },
        },
    }
