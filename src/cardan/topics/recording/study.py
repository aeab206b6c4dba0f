"""Life of the gauges of a recording, and what did the damage.

The study evaluates a recording with its options rather than an application: if
there is one it only predicts. What is limited are rows of a profile, and a target.
"""

import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from cardan.approval.study import StudyResult
from cardan.core.arrays import BoolArray, FloatArray
from cardan.core.errors import (
    DesignError,
    MissingDependencyError,
)
from cardan.core.labels import EvaluationCondition
from cardan.core.status import ProgressCallback, ignore_status
from cardan.physics.fatigue.damage import LifeEstimate
from cardan.physics.signals import assessment as room
from cardan.physics.signals.assessment import AssessmentSettings, GaugeAssessment
from cardan.physics.signals.attribution_result import (
    DOUBT_DATA_REJECTED,
    JointAttribution,
)
from cardan.physics.signals.cause_assessment import DamageCausesByGauge, attribute_damage
from cardan.physics.signals.channel_units import RADIANS_PER_TURN
from cardan.physics.signals.conditioning import UPSAMPLING_FACTOR, ChannelReport, upsample
from cardan.physics.signals.confounders import FOUR_CYLINDER_FIRING_ORDER
from cardan.physics.signals.damage_attribution import (
    SIX_CYLINDER_FIRING_ORDERS,
    source_separation,
    vibration_sources,
)
from cardan.physics.signals.data_quality import MAX_UNDECIDED_DAMAGE_CHANGE
from cardan.physics.signals.operational_modes import (
    OperationalMode,
    identify_operational_modes,
    order_free_spectra,
)
from cardan.physics.signals.order_cuts import order_cuts, order_windows
from cardan.physics.signals.order_tracking import ShaftRotation
from cardan.physics.signals.recording import (
    SAMPLES_PER_BLOCK,
    Recording,
    rechunk_to_block_size,
)
from cardan.physics.signals.shaft_angle import MAX_SPEED_GAP_S, ShaftAngle
from cardan.physics.signals.spectrograms import OrderMap, order_maps, spectrograms
from cardan.physics.signals.usage_profile import (
    UsageHistory,
    interval_count,
    interval_length,
    usage_histories,
)
from cardan.readers.dispatch import open_recording
from cardan.topics.recording.alternative_life_models import (
    AlternativeLives,
    crack_growth_passes_to_failure,
    failure_probability,
    strain_life_damage,
)
from cardan.topics.recording.identification_result import IdentificationResult
from cardan.topics.recording.life_verdict import limit_checks, unevaluated_limits
from cardan.topics.recording.options import (
    MIN_SAMPLES_FOR_CRESTS,
    STUDY_NAME,
    AnalysisOptions,
    parse_numbers,
)
from cardan.topics.recording.predicted_life import (
    PredictedLife,
    bearing_force_history,
    predict_life,
)
from cardan.topics.recording.recording_assessment import (
    AlternativeBusErrorInterpretation,
    RecordingAssessment,
    ReportFigures,
)
from cardan.topics.recording.shaft_signals import (
    MAX_TACHO_LAG_S,
    bus_error_values,
    engine_rotation,
    mask_missing_torque,
    max_tacho_speed,
    measured_shaft_angle,
    read_torque,
    torque_channel,
    with_alternative_reading,
)
from cardan.topics.recording.stress_history import StressHistoryCounter
from cardan.topics.recording.usage import UsageDamage, damage_by_usage


@dataclass(frozen=True)
class RecordingStudy:
    """How long the gauges of a recording live, held against a campaign's limits."""

    options: AnalysisOptions
    name: str = STUDY_NAME
    draw: bool = False
    """Whether the answer holds what a report draws: three more passes."""

    def run(
        self, recording: Recording, tell: ProgressCallback = ignore_status
    ) -> StudyResult[RecordingAssessment]:
        """Run the study.

        Raises
        ------
        DesignError
            If the recording lacks what the campaign names, or holds nothing at all.
        InvalidFileError
            If the recording or the profile cannot be read as meant.
        """
        campaign = self.options
        profile, limits = campaign.profile_and_limits()
        recording = campaign.scale_channels(recording)
        predicted, plan = campaign.order2_predictions(), campaign.assessment_settings(recording)
        progress = _progress(recording, tell)
        healths = room.survey_channel_quality(recording, channels=plan.channels, progress=progress)
        samples = max(h.samples for h in healths.values())
        seconds = samples / recording.rate
        campaign.check_recording(recording, samples=samples)
        if samples < MIN_SAMPLES_FOR_CRESTS and plan.interpolate_crests is None:
            plan = replace(plan, interpolate_crests=False)
        beyond = campaign.rules_after_end(seconds)
        angle = measured_shaft_angle(campaign, recording)
        ends = _unsaid(campaign, recording, angle, seconds)
        recording = replace(recording, notes=(*recording.notes, *beyond, *ends))
        plan = replace(plan, max_known_frequency=_fastest(angle))
        lives = room.assess_damage_at_gauges(
            recording, plan=plan, healths=healths, distance=_distance(campaign, angle, seconds),
            progress=progress,
        )  # fmt: skip
        _masked_out(recording, plan, lives)
        heard = [g for g, one in zip(plan.gauges, lives, strict=True) if one.has_signal]
        causes = None
        if angle is not None and heard:
            causes = _causes(
                campaign, recording, replace(plan, gauges=tuple(heard)), angle, healths=healths,
                predicted=predicted, progress=progress,
            )  # fmt: skip
            causes = _unspoilt(causes, lives)
        misread = tuple(
            _other_ways(
                campaign, recording, replace(plan, gauges=tuple(heard)), angle, healths=healths,
                predicted=predicted, progress=progress,
            )
        )  # fmt: skip
        when = EvaluationCondition("recording", recording.name)
        if angle is not None and causes is not None:
            angle = _told_angle(angle, causes)
        identified, kept = None, tuple[PredictedLife, ...]()
        if campaign.identify and angle is not None:
            identified = _identified(
                campaign, recording, plan, angle, healths=healths, lives=lives, progress=progress
            )
            if campaign.changed is not None and not identified.doubts:
                kept = _promised(
                    campaign, recording, plan, identified, angle.rotation, healths=healths,
                    lives=lives, progress=progress,
                )  # fmt: skip
        told = ()
        if campaign.usage and heard:
            told = _used(
                campaign, recording, replace(plan, gauges=tuple(heard)), angle, healths=healths,
                lives=[one for one in lives if one.has_signal], samples=samples, progress=progress,
            )  # fmt: skip
        others = _otherwise(
            campaign, recording, plan, healths=healths, lives=lives, progress=progress
        )
        pictures = None
        if self.draw and heard:
            pictures = _pictures(
                recording, replace(plan, gauges=tuple(heard)), angle, healths=healths,
                lives=[one for one in lives if one.has_signal], samples=samples, progress=progress,
            )  # fmt: skip
        return StudyResult(
            study=STUDY_NAME,
            answer=RecordingAssessment(
                recording=recording,
                options=campaign,
                plan=plan,
                lives=tuple(lives),
                causes=causes,
                profile=profile,
                angle=angle,
                identification=identified,
                figures=pictures,
                usage=told,
                predicted_lives=kept,
                alternative_lives=others,
                alternative_readings=misread,
            ),
            checks=tuple(
                limit_checks(lives, limits, when=when, line=campaign.line, ends=_if_worst(lives))
            ),
            unevaluated=tuple(unevaluated_limits(lives, limits, when=when, line=campaign.line)),
        )


def analyse_recording(
    path: Path,
    campaign: AnalysisOptions,
    tell: ProgressCallback = ignore_status,
    *,
    draw: bool = False,
) -> StudyResult[RecordingAssessment]:
    """Open a recording and assess it: what a command and the public interface call.

    Raises
    ------
    CardanError
        If the recording, the profile or an option of the campaign is not as it should be, or
        an optional library is absent. Whatever else is raised is the program's own fault.
    """
    try:
        recording = open_recording(
            path, rate=campaign.rate, time=campaign.time, group=campaign.group,
            dbc=campaign.can_databases,
        )  # fmt: skip
        return RecordingStudy(campaign, draw=draw).run(recording, tell)
    except ImportError as error:
        msg = f"this needs {error.name}; pip install 'cardan[fatigue,recordings]'"
        raise MissingDependencyError(msg) from error


def _progress(recording: Recording, tell: ProgressCallback) -> room.ProgressCallback:
    """Return the function that reports the seconds done, of how many where that is known."""
    total = recording.samples / recording.rate if recording.samples else 0.0

    def told(name: str, seconds: float) -> None:
        if total:
            tell(f"{name} {seconds / total:.0%}", 0, 0)
        else:
            tell(f"{name} {seconds:.0f} s", 0, 0)

    return told


def _if_worst(lives: Sequence[GaugeAssessment]) -> dict[str, LifeEstimate]:
    """Return lives of gauges of which a fifth of the damage may be hidden, were it the worst."""
    return {
        one.name: replace(
            one.life, damage=one.quality.damage_if_worst, duration=one.quality.recorded_time
        )
        for one in lives
        if one.quality.damage_if_worst > (1 + MAX_UNDECIDED_DAMAGE_CHANGE) * one.life.damage
    }


UNUSUALLY_HIGH_SHAFT_SPEED_REV_S = 60.0
"""Turns a second that few propshafts reach: 3600 rpm."""
MAX_SPEED_GAP_SHARE = 0.1
"""Share of a recording without a speed from which its distance is unknown."""


def _unheard(angle: ShaftAngle, seconds: float) -> tuple[float, float]:
    """Return for how long nothing says the speed at either end of a recording, s."""
    first, last = angle.known_time_span
    return max(first, 0.0), max(seconds - last, 0.0)


def _held(angle: ShaftAngle, seconds: float) -> bool:
    """Return whether so little of a speed is missing that the neighbouring speed may stand in."""
    return (
        sum(_unheard(angle, seconds)) + float(np.diff(angle.speed_gaps).sum())
        <= MAX_SPEED_GAP_SHARE * seconds
    )


def _unsaid(
    campaign: AnalysisOptions, recording: Recording, angle: ShaftAngle | None, seconds: float
) -> Iterator[str]:
    """Yield what to know of a speed that begins late, ends early or is not there between."""
    if angle is None:
        return
    if (
        campaign.tacho
        and (apart := max_tacho_speed(campaign, recording)) < UNUSUALLY_HIGH_SHAFT_SPEED_REV_S
    ):
        yield (
            f"{campaign.tacho}: {campaign.pulses} pulses a turn are held apart up to "
            f"{apart * 60:.0f} rpm; a shaft that turned much faster would be measured as slower"
        )
    channel, driven = campaign.speed, campaign.axle_ratio is not None
    found: list[str] = []
    back = float(np.diff(angle.negative_speed_intervals).sum())
    signless = (
        angle.negative_speed_intervals
        if not angle.negative_speed_counts
        else angle.negative_speed_intervals[:0]
    )
    if back and angle.negative_speed_counts:
        yield (
            f"{channel}: negative for {back:.3g} s: reverse, or its sign is the other way round; "
            "it counts by its size"
        )
    elif back:
        found.append(
            f"{channel}: negative for {back:.3g} s, one number throughout: reverse, its sign the "
            "other way round, or a number for none"
        )
    lost = _unheard(angle, seconds)
    ends = np.array([(0.0, lost[0]), (seconds - lost[1], seconds)])
    if any(lost) and not _within(ends[np.array(lost) > 0], signless).all():
        found.append(
            f"{channel}: no speed in the first {lost[0]:.3g} s and the last {lost[1]:.3g} s"
        )
    holes = angle.speed_gaps[~_within(angle.speed_gaps, signless)]
    if len(holes):
        long = np.diff(holes)[:, 0]
        found.append(
            f"{channel}: no speed for {long.sum():.3g} s, longest hole {long.max():.3g} s, the "
            f"first at {holes[0, 0]:.4g} s"
        )
    for said in found:
        if not driven or campaign.tyre_radius_m is None:
            yield f"{said}: damage there is of no band of speed"
        elif _held(angle, seconds):
            yield (f"{said}: damage there is of no band of speed, km use the nearest speed")
        else:
            yield f"{said}: damage there is of no band of speed, and km are not known"


def _within(runs: FloatArray, others: FloatArray) -> BoolArray:
    """Return which of some runs (k, 2) s are one of others (m, 2) but for a moment at its ends."""
    off = np.abs(runs[:, None] - others[None]).max(-1)
    return (off < MAX_SPEED_GAP_S).any(-1)


def _distance(campaign: AnalysisOptions, angle: ShaftAngle | None, seconds: float) -> float:
    """Return what was driven in a recording that lasts so long, m; nan where unknown."""
    ratio, radius = campaign.axle_ratio, campaign.tyre_radius_m
    if angle is None or ratio is None or radius is None or not _held(angle, seconds):
        return math.nan
    shaft = angle.rotation
    turned = float(shaft.turns[-1] - shaft.turns[0])
    # A shaft that never turned was not driven: the speed is not what it is taken for.
    return turned / ratio * RADIANS_PER_TURN * radius if turned > 0 else math.nan


def _unspoilt(causes: DamageCausesByGauge, lives: Sequence[GaugeAssessment]) -> DamageCausesByGauge:
    """Return undetermined causes for a gauge whose data are rejected."""
    vetoed = {one.name for one in lives if one.vetoed}
    return replace(
        causes,
        joint_attributions=[
            e.undetermined(DOUBT_DATA_REJECTED) if name in vetoed else e
            for name, e in zip(causes.gauges, causes.joint_attributions, strict=True)
        ],
    )


def _fastest(angle: ShaftAngle | None) -> float:
    """Return how fast a shaft's order 2 moves, Hz, but for a twentieth of its time under way."""
    if angle is None:
        return 0.0
    speed = angle.rotation.speed(angle.rotation.time)
    moving = speed[speed > 0.5]
    return 2 * float(np.quantile(moving, 0.95, overwrite_input=True)) if moving.size else 0.0


def _masked_out(
    recording: Recording, plan: AssessmentSettings, lives: Sequence[GaugeAssessment]
) -> None:
    """Refuse rules that leave nothing of a gauge that had something to say."""
    for one in lives:
        spoke = not any(h.dead for h in one.channel_reports.values())
        if spoke and not one.has_signal and any(r.mask for r in plan.fault_rules):
            msg = (
                f"--mask leaves nothing of {one.name}: {one.quality.live_time:.4g} s of the "
                f"{one.quality.recorded_time:.4g} s of {recording.name}; mask less, or leave it out"
            )
            raise DesignError(msg)


def _causes(
    campaign: AnalysisOptions, recording: Recording, plan: AssessmentSettings, angle: ShaftAngle, *,
    healths: dict[str, ChannelReport], predicted: dict[str, float], progress: room.ProgressCallback,
) -> DamageCausesByGauge:  # fmt: skip
    """Return the causes of damage at a plan's gauges."""
    ratio, shaft = campaign.axle_ratio, angle.rotation
    orders = parse_numbers(campaign.engine_orders) if campaign.engine_orders else ()
    named = vibration_sources(
        shaft,
        joint_orders=parse_numbers(campaign.joint_orders),
        engine=engine_rotation(campaign, recording),
        engine_orders=orders or SIX_CYLINDER_FIRING_ORDERS,
        wheel=None if ratio is None else shaft.geared(1 / ratio),
    )
    return attribute_damage(
        mask_missing_torque(campaign, recording), plan=plan, healths=healths,
        how=source_separation(named, rate=recording.rate),
        angle=angle, torque=torque_channel(campaign, recording), predicted=predicted,
        engine_orders=orders, progress=progress,
    )  # fmt: skip


def _other_ways(
    campaign: AnalysisOptions,
    recording: Recording,
    plan: AssessmentSettings,
    angle: ShaftAngle | None,
    *,
    healths: dict[str, ChannelReport],
    predicted: dict[str, float],
    progress: room.ProgressCallback,
) -> Iterator[AlternativeBusErrorInterpretation]:
    """Yield what it would come to if numbers of a bus that are no speeds were taken otherwise."""
    for one in bus_error_values(campaign, recording):
        other = with_alternative_reading(campaign, one)
        turned = measured_shaft_angle(other, recording)
        evidence: dict[str, JointAttribution] = {}
        if turned is not None and plan.gauges:
            found = _causes(
                other, recording, plan, turned, healths=healths, predicted=predicted,
                progress=progress,
            )  # fmt: skip
            evidence = dict(zip(found.gauges, found.joint_attributions, strict=True))
        turns = math.nan
        if turned is not None and angle is not None:
            turns = float(np.ptp(turned.rotation.turns) - np.ptp(angle.rotation.turns))
        yield AlternativeBusErrorInterpretation(
            bus_error_values=one, additional_turns=turns, evidence=evidence
        )


def _told_angle(angle: ShaftAngle, causes: DamageCausesByGauge) -> ShaftAngle:
    """Return an angle with the ratio and lag that the surest gauge has found.

    A tacho counts every turn as it comes, so nothing is found better than that.
    """
    if angle.lag <= MAX_TACHO_LAG_S:
        return angle
    surest = causes.best_synchronised
    if surest is None or (surest.ratio == 1 and surest.lag == 0):
        return angle
    of = angle.rotation
    return replace(angle, rotation=ShaftRotation(of.time + surest.lag, surest.ratio * of.turns))


def _identified(
    campaign: AnalysisOptions,
    recording: Recording,
    plan: AssessmentSettings,
    angle: ShaftAngle,
    *,
    healths: dict[str, ChannelReport],
    lives: Sequence[GaugeAssessment],
    progress: room.ProgressCallback,
) -> IdentificationResult:
    """Return what a recording says of the campaign's application."""
    from cardan.topics.recording.parameter_identification import identify_parameters

    units = campaign.unit_stresses()
    gauges = tuple(
        g for g, one in zip(plan.gauges, lives, strict=True) if g.name in units and one.has_signal
    )
    if not gauges:
        msg = "no gauge of --unit-stress says anything: nothing to identify the application from"
        raise DesignError(msg)
    assert campaign.application is not None  # `AnalysisOptions` refuses
    own, seconds = replace(plan, gauges=gauges), lives[0].quality.recorded_time
    stress = room.gauge_stresses(
        recording, plan=own, healths=healths, name="identify", progress=progress
    )
    found = identify_parameters(
        campaign.application, stress, rate=recording.rate, gauges=[g.name for g in gauges],
        units=np.stack([units[g.name] for g in gauges]), angle=angle,
        torque=read_torque(campaign, recording), seconds=seconds, state=campaign.state,
        bearing=campaign.bearing,
    )  # fmt: skip
    stress = room.gauge_stresses(
        recording, plan=own, healths=healths, name="modes", progress=progress
    )
    return replace(
        found, operational_modes=_shaken(campaign, recording, stress, angle, seconds=seconds)
    )


def _shaken(
    campaign: AnalysisOptions,
    recording: Recording,
    stress: Iterable[FloatArray],
    angle: ShaftAngle,
    *,
    seconds: float,
) -> tuple[OperationalMode, ...]:
    """Return the modes that gauges feel in addition to the orders of shaft and engine."""
    orders = parse_numbers(campaign.engine_orders) if campaign.engine_orders else ()
    return identify_operational_modes(
        order_free_spectra(
            stress,
            rate=recording.rate,
            seconds=seconds,
            angle=angle,
            engine=engine_rotation(campaign, recording),
            engine_orders=orders or (*SIX_CYLINDER_FIRING_ORDERS, FOUR_CYLINDER_FIRING_ORDER),
        )
    )


def _promised(
    campaign: AnalysisOptions,
    recording: Recording,
    plan: AssessmentSettings,
    of: IdentificationResult,
    rotation: ShaftRotation,
    *,
    healths: dict[str, ChannelReport],
    lives: Sequence[GaugeAssessment],
    progress: room.ProgressCallback,
) -> tuple[PredictedLife, ...]:
    """Return what the changed line promises at the gauges that the line was identified by.

    Nothing for a gauge whose data are rejected.
    """
    changed = campaign.changed
    assert changed is not None  # checked by the caller
    sound = {one.name: one for one in lives if not one.vetoed}
    own = _identifying(plan, of)
    own = replace(own, gauges=tuple(g for g in own.gauges if g.name in sound))
    if not own.gauges:
        return ()
    stress = room.gauge_stresses(
        recording, plan=own, healths=healths, name="changed", progress=progress
    )
    try:
        return predict_life(
            of,
            changed,
            stress,
            rate=recording.rate,
            rotation=rotation,
            torque=read_torque(campaign, recording),
            seconds=lives[0].quality.recorded_time,
            plan=own,
            lives=[sound[g.name] for g in own.gauges],
        )
    except DesignError as error:
        msg = f"the changed application: {error}"
        raise DesignError(msg) from None


def _identifying(plan: AssessmentSettings, of: IdentificationResult) -> AssessmentSettings:
    """Return the plan of the gauges that the line was identified by."""
    return replace(plan, gauges=tuple(g for g in plan.gauges if g.name in of.gauges))


def recorded_bearing_force(
    campaign: AnalysisOptions, of: RecordingAssessment, *, changed: bool = False
) -> tuple[FloatArray, FloatArray]:
    """Return `bearing_force_history` over a recording, (n,) s and (n, 3) N.

    Of the line as it was identified, or of the campaign's changed one.
    """
    assert of.identification is not None  # checked by the caller
    assert of.angle is not None
    healths = {name: one for life in of.lives for name, one in life.channel_reports.items()}
    stress = room.gauge_stresses(
        of.recording, plan=_identifying(of.plan, of.identification), healths=healths, name="force"
    )
    return bearing_force_history(
        of.identification, stress, rate=of.recording.rate, rotation=of.angle.rotation,
        torque=read_torque(campaign, of.recording), seconds=of.lives[0].quality.recorded_time,
        application=campaign.changed if changed else None,
    )  # fmt: skip


def _used(
    campaign: AnalysisOptions,
    recording: Recording,
    plan: AssessmentSettings,
    angle: ShaftAngle | None,
    *,
    healths: dict[str, ChannelReport],
    lives: Sequence[GaugeAssessment],
    samples: int,
    progress: room.ProgressCallback,
) -> tuple[UsageDamage, ...]:
    """Return when and where the damage of a plan's gauges came."""

    def one_by_one() -> Iterator[UsageHistory]:
        for gauge in plan.gauges:
            stress = room.gauge_stresses(
                recording, plan=replace(plan, gauges=(gauge,)), healths=healths, name="usage",
                progress=progress,
            )  # fmt: skip
            yield from usage_histories(
                stress, rate=recording.rate, curve=plan.curve, correction=plan.correction,
                rule=plan.residue_rule,
            )  # fmt: skip

    ratio, radius = campaign.axle_ratio, campaign.tyre_radius_m
    per_turn = math.nan if ratio is None or radius is None else RADIANS_PER_TURN * radius / ratio
    return damage_by_usage(
        one_by_one(),
        lives,
        count=interval_count(samples, rate=recording.rate),
        plan=plan,
        angle=angle,
        engine=engine_rotation(campaign, recording) if angle is not None else None,
        torque=read_torque(campaign, recording) if campaign.torque else None,
        per_turn=per_turn,
        begins=recording.start_time,
        held=angle is None or _held(angle, samples / recording.rate),
        second=interval_length(recording.rate),
    )


def _otherwise(
    campaign: AnalysisOptions,
    recording: Recording,
    plan: AssessmentSettings,
    *,
    healths: dict[str, ChannelReport],
    lives: Sequence[GaugeAssessment],
    progress: room.ProgressCallback,
) -> tuple[AlternativeLives, ...]:
    """Return a plan's gauges as their strain, a crack and odds have them, those with an answer."""
    by_strain, crack, hours = (
        campaign.strain_life_settings,
        campaign.crack_growth_settings,
        campaign.service_hours,
    )
    if by_strain is None and crack is None and hours is None:
        return ()
    told = [
        (g, one)
        for g, one in zip(plan.gauges, lives, strict=True)
        if one.has_signal and not one.vetoed
    ]
    if not told:
        return ()
    gauges, own = zip(*told, strict=True)
    strains: Sequence[tuple[float | None, float]] = [(None, math.nan)] * len(own)
    if by_strain is not None:
        sharp = any(not math.isnan(one.quality.damage_of_samples_only) for one in own)

        def pieces() -> Iterator[FloatArray]:
            stress = room.gauge_stresses(
                recording, plan=replace(plan, gauges=gauges), healths=healths, name="strain",
                progress=progress,
            )  # fmt: skip
            return upsample(stress) if sharp else stress

        largest = [max(abs(one.min_stress), abs(one.max_stress)) for one in own]
        strains = strain_life_damage(pieces, largest, by_strain, rule=plan.residue_rule)
    return tuple(
        AlternativeLives(
            gauge=one.name,
            duration=one.life.duration,
            damage_at_failure=plan.allowed,
            strain_damage=damage,
            strain_amplitude=strain,
            crack_passages=None if crack is None else crack_growth_passes_to_failure(one, crack),
            failure_probability=None
            if hours is None
            else failure_probability(one, plan, hours=hours, miner_scatter=campaign.miner_scatter),
        )
        for one, (damage, strain) in zip(own, strains, strict=True)
    )


def _pictures(
    recording: Recording,
    plan: AssessmentSettings,
    angle: ShaftAngle | None,
    *,
    healths: dict[str, ChannelReport],
    lives: Sequence[GaugeAssessment],
    samples: int,
    progress: room.ProgressCallback,
) -> ReportFigures:
    """Return what a report draws of a plan's gauges, whose lives are these."""

    def stress() -> Iterator[FloatArray]:
        return room.gauge_stresses(
            recording, plan=plan, healths=healths, name="draw", progress=progress
        )

    rate, maps, cuts = recording.rate, list[OrderMap](), None
    seconds = samples / rate
    # Damage is counted as a life is: where crests are lost between samples, with these.
    interpolated = np.array([not math.isnan(one.quality.damage_of_samples_only) for one in lives])
    over_time = StressHistoryCounter(
        plan, samples=samples, rate=rate, interpolated=interpolated.tolist()
    )
    if interpolated.any():
        own = rechunk_to_block_size(
            (x[interpolated] for x in stress()), size=SAMPLES_PER_BLOCK // UPSAMPLING_FACTOR
        )
        over_time.count_interpolated(upsample(own), times=UPSAMPLING_FACTOR)
    top = SPECTROGRAM_MAX_HZ
    if angle is not None:
        at = order_windows(angle.rotation, until=seconds)
        if at.time.size:
            top = max(SPECTROGRAM_MAX_HZ, 6 * float(at.speed.max()))
            maps = order_maps(stress(), rate=rate, rotation=angle.rotation, at=at)
            cuts = order_cuts(stress(), rate=rate, rotation=angle.rotation, at=at)
    return ReportFigures(
        gauges=tuple(g.name for g in plan.gauges),
        spectrograms=tuple(
            spectrograms(over_time.observed(stress()), rate=rate, seconds=seconds, top=top)
        ),
        order_maps=tuple(maps),
        cuts=cuts,
        histories=over_time.histories(),
    )


SPECTROGRAM_MAX_HZ = 60.0
"""Hz up to which a spectrogram shows a bracket's stress, unless its shaft's orders go higher."""
