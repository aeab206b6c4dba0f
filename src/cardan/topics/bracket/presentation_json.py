"""A bracket study as the JSON contract's document."""

from typing import Any

import numpy as np

from cardan.approval.approval import Approval
from cardan.approval.study import BRACKET_STUDY_NAME
from cardan.core.arrays import FloatArray
from cardan.core.units import MPa, N, mm, rpm
from cardan.physics.fem.unit_loads import UNIT_LOAD_NAMES
from cardan.physics.loads.half_turn_fourier import semi_major_axis
from cardan.render.i18n import ENGLISH
from cardan.render.json_contract import (
    JSON_FORMAT_VERSION,
    check_json,
    coverage_json,
    operating_point_json,
    to_json_types,
)
from cardan.topics.bracket.assessment import BracketResult
from cardan.topics.bracket.forced_response import ForcedResponse
from cardan.topics.bracket.life import DamageResult, fatigue_strength_by_zone
from cardan.topics.bracket.presentation_values import (
    MAX_RELIABLE_ERROR_SHARE,
    STRAIN_PER_MICROSTRAIN,
    feature_hours_bounds,
    feature_hours_to_failure,
    highest_stress,
    max_fatigue_utilisation,
    recordings_read_from_gauges,
    root_mean_square,
)
from cardan.topics.bracket.shape_result import CaseResult, LocatedStress, ShapeAssessment
from cardan.topics.bracket.vtk_file import max_displacement_at_peak, peak_loads


def json_document(approval: Approval) -> dict[str, Any]:
    """Return a bracket study as the JSON contract's document."""
    of: BracketResult = approval.answer_of(BRACKET_STUDY_NAME)
    bracket = of.bracket
    return to_json_types(
        {
            "cardan": JSON_FORMAT_VERSION,
            "application": of.title,
            "verdict": approval.verdict,
            "profile": approval.application.profile,
            "checks": [check_json(c) for c in approval.checks],
            "coverage": coverage_json(approval.coverage),
            "line": bracket.line,
            "bearing": bracket.bearing,
            "material": bracket.material.name,
            "metal": bracket.material.metal,
            "bears": {
                zone: {
                    "detail": one.name or None,
                    "amplitude_MPa": one.curve.amplitude / MPa,
                    "cycles": one.curve.cycles,
                    "slope": one.curve.slope,
                }
                for zone, one in fatigue_strength_by_zone(bracket).items()
            },
            "carried_mass_kg": bracket.carried_mass,
            "top_speed_rpm": of.top_speed / rpm if np.isfinite(of.top_speed) else None,
            "variants": [_variant(of, v) for v in of.variants],
        }
    )


def _variant(of: BracketResult, v: ShapeAssessment) -> dict[str, Any]:
    stress, _ = highest_stress(v)
    share, lasts, within = (
        max_fatigue_utilisation(v),
        feature_hours_to_failure(v),
        feature_hours_bounds(v),
    )
    asks = {s.when: s.utilisation for s in v.duty_slips}
    return {
        "name": v.name,
        "mass_kg": v.mass,
        "elements": len(v.solved.nodes.elements),
        "unknowns": v.solved.unknowns,
        "meshes": v.solved.mesh_count,
        "fillet_mm": (
            {"drawn": v.solved.fillet[0] / mm, "solved": v.solved.fillet[1] / mm}
            if v.solved.fillet
            else None
        ),
        "stiffness_N_mm": [float(1 / v.compliance[k, k] / (N / mm)) for k in range(3)],
        "stiffness_clamped_N_mm": [
            float(1 / v.solved.clamped.compliance[k, k] / (N / mm)) for k in range(3)
        ],
        "read_back": [
            {
                "recording": one.name,
                "noise_N": found.noise.tolist(),
                "error_N": found.load_error.tolist(),
                "condition": found.condition,
                "flange": None if one.strain is None else found.flange_fixity,
                "unexplained_microstrain": (
                    None if one.strain is None else 1e6 * root_mean_square(found.residual)
                ),
            }
            for one, found in recordings_read_from_gauges(of, v)
        ],
        "stiffness_too_high": v.solved.sliding.stiffness_error.tolist(),
        "frequencies_Hz": v.frequencies.tolist(),
        "frequencies_too_high": v.solved.sliding.frequency_error.tolist(),
        "frequencies_loaded_Hz": v.loaded_frequencies.tolist(),
        "frequencies_loaded_clamped_Hz": v.solved.clamped.loaded_frequencies.tolist(),
        "crossings": [
            {
                "mode": c.mode,
                "frequency_Hz": c.frequency,
                "order": c.order,
                "speed_rpm": c.speed / rpm,
                "in_range": c.in_range,
            }
            for c in v.crossings
        ],
        "hot_spots": [
            {
                "name": f"H{k + 1}",
                "zone": f.zone,
                "number": f.number,
                "point_mm": [x / mm for x in f.point],
                "von_mises_MPa": stress[k] / MPa,
                "error_MPa": f.error * stress[k] / MPa,
                "fatigue_utilisation": None if np.isnan(share[k]) else share[k],
                "life_hours": lasts[k] if np.isfinite(lasts[k]) else None,
                "life_hours_within": [x if np.isfinite(x) else None for x in within[k].tolist()],
                "beside_weld": f.beside_weld,
            }
            for k, f in enumerate(v.features)
        ],
        "contact": None
        if v.contact_result is None
        else {
            "preload_N": v.contact_result.bolts.preload,
            "friction": v.contact_result.bolts.friction,
            "case": None
            if v.contact_result.when is None
            else ENGLISH.occasion(v.contact_result.when),
            "swing_over_held": [
                None if np.isnan(x) else x for x in v.contact_result.stress_factors.tolist()
            ],
            "fatigue_utilisation_held": [
                None if np.isnan(x) else x
                for x in v.contact_result.utilisation_without_contact.tolist()
            ],
            "life_hours_held": (
                v.contact_result.life_without_contact
                if np.isfinite(v.contact_result.life_without_contact)
                else None
            ),
        },
        "unit_loads": list(UNIT_LOAD_NAMES),
        "gauges": [
            {
                "name": gauge.name,
                "point_mm": [x / mm for x in gauge.point],
                "direction": list(gauge.direction),
                "length_mm": gauge.length / mm,
                "microstrain_per_unit": (row / STRAIN_PER_MICROSTRAIN).tolist(),
            }
            for gauge, row in zip(of.bracket.gauges, v.influence, strict=True)
        ],
        "response": None if v.forced_response is None else _response(v.forced_response),
        "cases": [_case(of, v, o) for o in v.case_results],
        "duty": [
            _life(of, e) | ({"slip_utilisation": asks[e.when]} if e.when in asks else {})
            for e in v.duty_damage
        ],
    }


def _response(of: ForcedResponse) -> dict[str, Any]:
    def known(values: FloatArray) -> list[float | None]:
        return [None if np.isnan(x) else x for x in values.tolist()]

    swept = of.sweep
    return {
        "state": swept.state,
        "modes": [
            {"name": name, "frequency_Hz": f, "damping_ratio": d}
            for name, f, d in zip(swept.mode_names, swept.frequencies, swept.damping, strict=True)
        ],
        "speed_rpm": (swept.speed / rpm).tolist(),
        "curves": [
            {
                "gear": swept.gears[c],
                "direction": swept.directions[c],
                "torque_Nm": known(swept.torque[c]),
                "force_N": known(semi_major_axis(swept.force_amplitudes[c]).sum(-1)),
                "force_rigid_N": known(semi_major_axis(swept.rigid_force_amplitudes[c]).sum(-1)),
                "stress_MPa": [known(x / MPa) for x in of.stress[c].T],
                "stress_rigid_MPa": [known(x / MPa) for x in of.rigid_stress[c].T],
            }
            for c in range(len(swept.gears))
        ],
    }


def _life(of: BracketResult, e: DamageResult) -> dict[str, Any]:
    def known(value: float) -> float | None:
        return value if np.isfinite(value) else None

    return {
        "name": str(e.when),
        "turns": known(e.turns),
        "duration_s": known(e.duration),
        "hot_spots": list(map(known, e.hot_spot_damage.tolist())),
        "gauges": dict(
            zip((g.name for g in of.bracket.gauges), e.gauge_damage.tolist(), strict=True)
        ),
        "per_turn": known(e.damage_per_turn),
        "per_hour": known(e.damage_per_hour),
        "life_hours": known(e.hours_to_failure),
        "life_hours_within": [known(x) for x in e.hours_bounds],
        "life_hours_kinder": known(e.favourable_hours),
        **({"damage_is_lower_bound": True} if e.stop_margin < 0 else {}),
    }


def _case(of: BracketResult, v: ShapeAssessment, o: CaseResult) -> dict[str, Any]:
    def found(f: LocatedStress) -> dict[str, Any]:
        return {"value_MPa": f.value / MPa, "point_mm": [x / mm for x in f.point]}

    farthest = max_displacement_at_peak(v, o)
    return {
        "name": str(o.case.when),
        **(
            {"point": operating_point_json(o.case.operating_point)}
            if o.case.operating_point
            else {}
        ),
        **({"is_lower_bound": True} if o.case.stop_margin < 0 else {}),
        "von_mises": found(o.von_mises),
        "max_principal": found(o.max_principal),
        "min_principal": found(o.min_principal),
        "pulls_off": o.pulls_off,
        **({} if np.isnan(o.slip_utilisation) else {"slip_utilisation": o.slip_utilisation}),
        **({} if o.stress_factors is None else {"swing_over_held": o.stress_factors.tolist()}),
        "von_mises_on_edge": found(o.max_nodal_von_mises),
        "hot_spots": [
            {
                "von_mises_MPa": h / MPa,
                "error_MPa": e / MPa,
                "settled": bool(e <= MAX_RELIABLE_ERROR_SHARE * h),
                "mean_MPa": m / MPa,
                "amplitude_MPa": a / MPa,
            }
            for h, e, m, a in zip(
                o.feature_stress.tolist(),
                o.feature_stress_error.tolist(),
                o.mean.tolist(),
                o.amplitude.tolist(),
                strict=True,
            )
        ],
        "gauges": {
            gauge.name: {
                "min_microstrain": low / STRAIN_PER_MICROSTRAIN,
                "max_microstrain": high / STRAIN_PER_MICROSTRAIN,
            }
            for gauge, (low, high) in zip(
                of.bracket.gauges, o.gauge_strain_range.tolist(), strict=True
            )
        },
        "bolts_N": o.bolt_forces.tolist(),
        "motion_mm": o.seat_displacement / mm,
        "at_peak": {
            "loads": peak_loads(v, o).tolist(),
            "max_displacement_mm": farthest.value / mm,
            "point_mm": [x / mm for x in farthest.point],
        },
        "damage": _life(of, o.damage_result) if o.damage_result is not None else None,
    }
