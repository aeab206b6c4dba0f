"""What a recording or a campaign did, as the JSON contract has it."""

import math
from collections.abc import Callable
from typing import Any

import numpy as np

from cardan.approval.coverage import coverage_of
from cardan.approval.study import StudyResult
from cardan.core.arrays import FloatArray
from cardan.core.units import MPa, hour
from cardan.core.version import __version__
from cardan.physics.fatigue import mean_stress
from cardan.physics.fatigue.rainflow import ResidueRule, discarded, half_cycles, repeating
from cardan.physics.signals.assessment import GaugeAssessment
from cardan.physics.signals.attribution_result import VALIDATED_ERROR_RATES, JointAttribution
from cardan.physics.signals.conditioning import ChannelReport
from cardan.physics.signals.damage_attribution import (
    CAUSE_DESCRIPTIONS,
    CAUSE_JOINTS,
    PredictionComparison,
)
from cardan.physics.signals.data_quality import AssumedUnit, FaultRule
from cardan.physics.signals.faults.waveform import FAULT_SENTINEL
from cardan.physics.signals.recording import Recording
from cardan.render.json_contract import check_json, coverage_json, to_json_types
from cardan.topics.recording import alternative_life_presentation as otherwise
from cardan.topics.recording import identification_presentation as identified
from cardan.topics.recording import method_presentation as counting
from cardan.topics.recording import usage_presentation as used
from cardan.topics.recording.campaign_assessment import CampaignAssessment, MixGaugeResult
from cardan.topics.recording.finding_phrases import finding_message, finding_messages
from cardan.topics.recording.life_verdict import assessment_verdict
from cardan.topics.recording.presentation import (
    campaign_answer,
    cause_places,
    fault_messages,
    joint_verdict_sentence,
    recording_answer,
)
from cardan.topics.recording.recording_assessment import (
    AlternativeBusErrorInterpretation,
    RecordingAssessment,
)

RESIDUE_RULE_CODES: dict[ResidueRule, str] = {
    half_cycles: "half_cycles",
    repeating: "repeating",
    discarded: "discarded",
}
"""Values of `rules.residue`, by how open cycles are counted."""

MEAN_STRESS_CODES: dict[Callable[..., FloatArray], str] = {
    mean_stress.uncorrected: "uncorrected",
    mean_stress.goodman: "goodman",
    mean_stress.gerber: "gerber",
    mean_stress.walker: "walker",
    mean_stress.swt: "swt",
    mean_stress.fkm: "fkm",
}
"""Values of `rules.mean_stress`, by how the mean stress of a cycle is counted."""


def _number(value: float) -> float | None:
    """JSON knows no infinity: a life without end, or an unknown, is null."""
    return float(value) if math.isfinite(value) else None


def _life(one: GaugeAssessment, value: float) -> float | None:
    """Return a number of a life; unknown if its data are rejected."""
    return None if one.vetoed else _number(value)


def _quality(one: GaugeAssessment) -> dict[str, Any]:
    of = one.quality
    return {
        "verdict": of.verdict if one.has_signal else "silent",
        "vetoes": list(of.vetoes) if one.has_signal else [],
        "live_s": of.live_time,
        "live_share": of.live_share,
        "suspects": [
            {
                "kind": e.kind,
                "count": e.count,
                "samples": e.samples,
                "undecided": e.undecided,
                "damage_recorded": _number(e.damage_recorded),
                "damage_without": _number(e.damage_without),
                **(
                    {}
                    if math.isnan(e.damage_if_worst)
                    else {"hidden_s": e.hidden_time, "damage_if_worst": _number(e.damage_if_worst)}
                ),
                **({"why": str(finding_message(e.reason))} if e.reason is not None else {}),
            }
            for e in of.effects
        ],
        "between_samples": not math.isnan(of.damage_of_samples_only),
        "damage_of_samples": _number(of.damage_of_samples_only),
        "power_above_0.4_rate": of.high_frequency_share,
        "biaxiality": _number(of.biaxiality),
        "damage_by_measure": dict(of.damage_by_measure),
        "doubts": [str(finding_message(d)) for d in of.doubts],
        **({"assumed": _assumed(of.assumed_unit)} if of.assumed_unit is not None else {}),
    }


def _assumed(of: AssumedUnit) -> dict[str, Any]:
    """Return a unit that only the command line says, and the damage in the other."""
    return {
        "unit": of.unit,
        "otherwise": of.other_unit,
        "factor": of.factor,
        "damage_otherwise": _number(of.damage),
    }


def _evidence(of: JointAttribution) -> dict[str, Any]:
    return {
        "removed": of.damage_share,
        "removed_interval": list(of.interval),
        "finding": of.verdict,
        "finding_wrong": _tried(of.verdict),
        "strength": _number(of.f_statistic),
        "modes": [{"frequency_Hz": f, "damping_ratio": d} for f, d in of.modes],
        "speed_ratio": of.ratio,
        "speed_lag_s": of.lag,
        "speed_lag_interval_s": [_number(late) for late in of.lag_interval],
    }


def _tried(finding: str) -> dict[str, Any] | None:
    """Return how often such a finding was wrong where the truth is known."""
    if finding not in VALIDATED_ERROR_RATES:
        return None
    plain, stopped = (
        {"wrong": t.wrong, "cases": t.cases, "at_most": t.upper_bound}
        for t in VALIDATED_ERROR_RATES[finding]
    )
    return {**plain, "on_a_stop": stopped}


MAX_LISTED_FAULTS = 100
"""Places of one kind of fault that the contract lists, those farthest off."""


def channel_json(recording: Recording, name: str, health: ChannelReport) -> dict[str, Any]:
    """Return what looks wrong in a channel of a recording."""
    return {
        "name": name, "missing": health.missing, "spikes": health.spikes,
        "clipped": health.clipped, "dead": health.dead, "drift": health.drift,
        "findings": [str(f) for f in fault_messages(recording, name, health)],
        "suspects": _suspects(health, recording.rate, recording.start_time),
    }  # fmt: skip


def _suspects(health: ChannelReport, rate: float, begins: float) -> list[dict[str, Any]]:
    """Return the places of each kind of fault, in s of its file and the channel's unit."""
    found: list[dict[str, Any]] = []
    for kind, where in health.faults.items():
        size = np.abs(where.sizes)
        weight = np.where(np.isnan(size), where.runs[:, 1] - where.runs[:, 0], size)
        far = np.sort(np.argsort(-weight, kind="stable")[:MAX_LISTED_FAULTS])
        found.append(
            {
                "kind": kind,
                "count": where.count,
                "samples": where.sample_count,
                "places": [
                    {
                        "from_s": begins + first / rate,
                        "to_s": begins + last / rate,
                        "size": _number(height),
                    }
                    for (first, last), height in zip(
                        where.runs[far].tolist(), where.sizes[far], strict=True
                    )
                ],
            }
        )
    return found


def _compared(answer: PredictionComparison) -> dict[str, Any]:
    return {
        "ratio": _number(answer.ratio),
        "correlation": _number(answer.correlation),
        "measured_MPa": _number(answer.measured / MPa),
        "predicted_MPa": _number(answer.predicted / MPa),
    }


def _cut(speed: FloatArray, amplitude: FloatArray, *, step: float = 100.0) -> list[dict[str, Any]]:
    """Rms amplitude, MPa, in bands of 100 rpm of shaft speed: an order cut."""
    turning = amplitude > 0
    band = np.floor(speed[turning] * 60 / step)
    return [
        {
            "rpm": float((b + 0.5) * step),
            "MPa": float(np.sqrt((amplitude[turning][band == b] ** 2).mean()) / MPa),
        }
        for b in np.unique(band)
    ]


def json_document(found: StudyResult[RecordingAssessment]) -> dict[str, Any]:
    """Return the JSON contract of `cardan life`: what is null is infinite or not known."""
    of = recording_answer(found)
    return {
        **recording_json(of),
        **_more(of),
        "verdict": assessment_verdict(found),
        "profile": of.profile or None,
        **to_json_types(
            {
                "checks": [check_json(c) for c in found.checks],
                "coverage": coverage_json(coverage_of(found)),
            }
        ),
    }


def _more(of: RecordingAssessment) -> dict[str, Any]:
    """Return results of a recording beyond damage and cause."""
    return {
        **(
            {"misread": [_misread(m) for m in of.alternative_readings]}
            if of.alternative_readings
            else {}
        ),
        **({"usage": {u.gauge: used.json_document(u) for u in of.usage}} if of.usage else {}),
        **(
            {"otherwise": {o.gauge: otherwise.json_document(o) for o in of.alternative_lives}}
            if of.alternative_lives
            else {}
        ),
        **(
            {"identification": identified.json_document(of.identification)}
            if of.identification
            else {}
        ),
        **(
            {"changed": identified.predicted_lives_json(of.predicted_lives)}
            if of.predicted_lives
            else {}
        ),
        **(
            {"departures": identified.parameter_changes_json(of.parameter_changes)}
            if of.predicted_lives
            else {}
        ),
    }


def _misread(of: AlternativeBusErrorInterpretation) -> dict[str, Any]:
    """Return where a bus wrote no value, and the answer with that taken otherwise."""
    own = of.bus_error_values
    torque = {} if math.isnan(own.torque) else {"torque_Nm": own.torque}
    return {
        "channel": own.channel,
        "kind": FAULT_SENTINEL,
        "rpm": None if torque else own.speed * 60,
        **torque,
        "count": len(own.intervals),
        "seconds": float((own.intervals[:, 1] - own.intervals[:, 0]).sum()),
        "places": [{"from_s": a, "to_s": b} for a, b in own.intervals[:MAX_LISTED_FAULTS].tolist()],
        "accepted": own.accepted_count,
        "turns_otherwise": _number(of.additional_turns),
        "gauges_otherwise": {name: _evidence(e) for name, e in of.evidence.items()},
    }


def study_json_entries(found: StudyResult[CampaignAssessment]) -> dict[str, Any]:
    """Return the entry of recordings in an application's JSON document."""
    return {"recording": campaign_json_document(found)}


def campaign_json_document(found: StudyResult[CampaignAssessment]) -> dict[str, Any]:
    """Return the JSON contract of `cardan life` of a campaign: as of one recording, for the mix."""
    of = campaign_answer(found)
    gauges: list[dict[str, Any]] = []
    for one in of.lives:
        life, told = one.life, of.evidence(one.name)
        known = not one.vetoes and one.has_signal
        gauges.append(
            {
                "name": one.name,
                "damage": _number(life.damage),
                "hours": _number(life.hours) if known else None,
                "km": _number(life.kilometres) if known else None,
                "vetoes": list(one.vetoes),
                **_in_turn(one),
                "recordings": [
                    {
                        "recording": name,
                        "times": times,
                        "damage": _number(part.life.damage),
                        "share": _number(times * part.life.damage / life.damage)
                        if life.damage
                        else None,
                        "live_s": part.quality.live_time,
                        "damage_per_km": _number(part.life.damage / (part.life.distance / 1e3))
                        if part.life.distance > 0
                        else None,
                        "damage_per_hour": _number(part.life.damage / part.life.duration * hour)
                        if part.life.duration > 0
                        else None,
                    }
                    for (name, times, _), (part, _) in zip(of.parts, one.parts, strict=True)
                ],
                **(_evidence(told) if told else {}),
            }
        )
    return {
        "cardan": __version__,
        "campaign": of.title,
        **(
            {
                "customer": {
                    "share": of.customer_share,
                    "gauges": [
                        {
                            "name": gauge,
                            "damage_per_hour": rate * hour,
                            "bound_per_hour": bound * hour,
                        }
                        for gauge, (rate, bound) in of.customer_damage_rates.items()
                    ],
                }
            }
            if of.customer_damage_rates
            else {}
        ),
        "verdict": assessment_verdict(found),
        "profile": of.profile or None,
        "gauges": gauges,
        **(
            {"otherwise": {o.gauge: otherwise.json_document(o) for o in of.alternative_lives}}
            if of.alternative_lives
            else {}
        ),
        "recordings": [
            {
                "times": times,
                **recording_json(h),
                **_more(h),
            }
            for _, times, h in of.parts
        ],
        **to_json_types(
            {
                "checks": [check_json(c) for c in found.checks],
                "coverage": coverage_json(coverage_of(found)),
            }
        ),
    }


def _in_turn(of: MixGaugeResult) -> dict[str, Any]:
    """Return what a gauge takes where a mix's parts are driven in turn, if that is more."""
    if of.sequenced_life is None:
        return {}
    known = not of.vetoes and of.has_signal
    return {
        "damage_in_turn": _number(of.sequenced_life.damage),
        "hours_in_turn": _number(of.sequenced_life.hours) if known else None,
    }


def recording_json(of: RecordingAssessment) -> dict[str, Any]:
    """Return what a recording did. Infinite or unknown numbers are null."""
    recording, plan, lives, causes = of.recording, of.plan, of.lives, of.causes
    gauges: list[dict[str, Any]] = []
    places = cause_places(causes)
    for one in lives:
        k = places.get(one.name)
        entry: dict[str, Any] = {
            "name": one.name,
            "low_MPa": _number(one.min_stress / MPa),
            "high_MPa": _number(one.max_stress / MPa),
            "damage": _number(one.life.damage),
            "repeats": _life(one, one.life.repeats),
            "hours": _life(one, one.life.hours),
            "km": _life(one, one.life.kilometres),
            "damage_exponent": _number(one.damage_exponent),
            "repeats_at_failure": {f"{f:g}": _life(one, n) for f, n in one.repeats.items()},
            "spectral_damage": one.spectral_damage,
            "quality": _quality(one),
        }
        if causes is not None and k is not None:
            found, evidence = causes.attributions[k], _evidence(causes.joint_attributions[k])
            entry |= evidence
            entry["causes"] = [
                {
                    "cause": cause,
                    "meaning": CAUSE_DESCRIPTIONS[cause],
                    "share": found.share(cause),
                    "damage_alone": found.alone(cause),
                    "damage_without": found.without(cause),
                    **(evidence if cause == CAUSE_JOINTS else {}),
                }
                for cause in found.causes
            ]
            entry["verdict"] = joint_verdict_sentence(one.name, found, causes.joint_attributions[k])
            entry["order2_by_speed"] = _cut(causes.speed, causes.order2[k])
            if causes.comparisons:
                entry["order2"] = _compared(causes.comparisons[k])
        gauges.append(entry)
    driven = next(
        (o.life.distance / o.quality.live_share for o in lives if o.quality.live_time), math.nan
    )
    channels = {name: h for one in lives for name, h in one.channel_reports.items()}
    return {
        "cardan": __version__,
        "recording": recording.name,
        "rate_Hz": recording.rate,
        "duration_s": lives[0].quality.recorded_time if lives else 0.0,
        "distance_km": _number(driven / 1e3) if lives else None,
        "notes": list(recording.notes),
        "rules": {
            "residue": RESIDUE_RULE_CODES[plan.residue_rule],
            "mean_stress": MEAN_STRESS_CODES[getattr(plan.correction, "func", plan.correction)],
            "allowed_damage": plan.allowed,
            "shares": "Shapley",
            "masked": [_ruled(r, recording.start_time) for r in plan.fault_rules if r.mask],
            "accepted": [_ruled(r, recording.start_time) for r in plan.fault_rules if not r.mask],
            "options": counting.json_document(of.options),
        },
        "channels": [channel_json(recording, name, h) for name, h in channels.items()],
        "gauges": gauges,
        "doubts": [] if causes is None else list(map(str, finding_messages(causes.doubts))),
    }  # fmt: skip


def _ruled(rule: FaultRule, begins: float) -> dict[str, Any]:
    begins = 0.0 if rule.covers_all_time else begins
    return {
        "channel": rule.channel or None, "kind": rule.kind or None, "from_s": begins + rule.first,
        "to_s": _number(begins + rule.last),
    }  # fmt: skip
