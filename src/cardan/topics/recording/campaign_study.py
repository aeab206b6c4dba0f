"""Every recording of a campaign, and the mix that they make: its gauges, customers and limits."""

import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from cardan.approval.study import StudyResult
from cardan.core.errors import (
    CardanError,
    DesignError,
    InvalidFileError,
    MissingDependencyError,
    OptionError,
)
from cardan.core.labels import EvaluationCondition
from cardan.core.status import ProgressCallback, ignore_status
from cardan.core.verdict import Limit
from cardan.model.application import Application
from cardan.physics.fatigue.damage import (
    RepeatedSequence,
    miner_damage,
    order_blocks_for_high_damage,
)
from cardan.physics.fatigue.rainflow import ResidueRule, discarded, repeating
from cardan.physics.signals import assessment as room
from cardan.physics.signals.assessment import AssessmentSettings, GaugeAssessment
from cardan.physics.signals.attribution_result import JOINTS_DOMINANT, JOINTS_NOT_DOMINANT
from cardan.physics.signals.channel_units import RADIANS_PER_TURN
from cardan.physics.signals.conditioning import running_median_baseline
from cardan.physics.signals.data_quality import MAX_UNDECIDED_DAMAGE_CHANGE, apply_rules
from cardan.physics.signals.faults.whole_channel import FAULT_DRIFT
from cardan.physics.signals.faults.zero_step import FAULT_ZERO_SHIFT
from cardan.physics.signals.recording import Recording, merge_recordings, time_slice
from cardan.readers.dispatch import open_recording
from cardan.topics.recording.alternative_life_models import (
    AlternativeLives,
    alternative_lives_of_recording_mix,
)
from cardan.topics.recording.campaign_assessment import (
    CampaignAssessment,
    CustomerPercentile,
    MixGaugeResult,
)
from cardan.topics.recording.campaign_schema import CampaignSpec, RecordingSegment, RecordingSpec
from cardan.topics.recording.campaign_schema import read_campaign_file as campaigned
from cardan.topics.recording.life_verdict import limit_checks, unevaluated_limits
from cardan.topics.recording.options import (
    STUDY_NAME,
    AnalysisOptions,
    options_as_campaign_file_keys,
)
from cardan.topics.recording.recording_assessment import RecordingAssessment
from cardan.topics.recording.shaft_signals import measured_shaft_angle
from cardan.topics.recording.study import RecordingStudy

NEED_TEXT_THREE_CUSTOMERS = (
    "three recordings or more, of a customer each, that all did damage there"
)
"""Missing input of a gauge whose shares of customers are not reported."""

CUSTOMER_PERCENTILE_LABEL = "the required share of customers"
"""Of whom a life is, where it is not of the mix."""

SEGMENT_EDGE_MARGIN_S = 1.0
"""How near the end of a segment a step of the zero is that it cannot show, s."""


@dataclass(frozen=True)
class _SegmentedRecording:
    """A recording whole, and from when to when its segments are, s."""

    campaign: AnalysisOptions
    whole: Recording
    segments: Sequence[tuple[float, float]]

    def hides(self, channels: Sequence[str]) -> Iterator[str]:
        """Yield what is wrong with the level of channels that no segment can show: a look more."""
        whole = self.campaign.scale_channels(self.whole)
        plan = self.campaign.assessment_settings(whole)
        if plan.baseline is running_median_baseline:
            return
        for channel, health in room.survey_channel_quality(whole, channels=channels).items():
            book = apply_rules(health, channel=channel, rules=plan.fault_rules, rate=whole.rate)
            if FAULT_DRIFT in book and book[FAULT_DRIFT].undecided.size:
                yield FAULT_DRIFT
            steps = (
                book[FAULT_ZERO_SHIFT].undecided[:, 0] / whole.rate
                if FAULT_ZERO_SHIFT in book
                else ()
            )
            if any(
                not any(
                    a + SEGMENT_EDGE_MARGIN_S < t < b - SEGMENT_EDGE_MARGIN_S
                    for a, b in self.segments
                )
                for t in steps
            ):
                yield FAULT_ZERO_SHIFT


def analyse_campaign(
    of: Path | CampaignSpec,
    *,
    limits: Sequence[Limit] = (),
    allow_outside: bool = False,
    tell: ProgressCallback = ignore_status,
    draw: bool = False,
    identified: bool = False,
    changed: bool = False,
    checked: Application | None = None,
) -> StudyResult[CampaignAssessment]:
    """Assess every recording of a campaign, and compare the mix with its limits and others.

    It is a file, or was read already.

    `checked` is the application whose verdict they will be part of: the campaign's own, if it names
    one.
    `identified` where what is wanted follows from the identification of its only recording, and
    `changed` where it is of the changed line: refused before anything is read if there is none.

    Raises
    ------
    CardanError
        As `analyse_recording`, of the file and of each recording.
    """
    written = campaigned(of, allow_outside=allow_outside) if isinstance(of, Path) else of
    try:
        return _listened(
            written, limits=limits, tell=tell, draw=draw, identified=identified, changed=changed,
            checked=checked,
        )  # fmt: skip
    except (InvalidFileError, MissingDependencyError):
        raise
    except CardanError as error:
        raise OptionError(error, file=written.name, worded=options_as_campaign_file_keys) from error


def _listened(
    written: CampaignSpec,
    *,
    limits: Sequence[Limit],
    tell: ProgressCallback,
    draw: bool,
    identified: bool,
    changed: bool,
    checked: Application | None,
) -> StudyResult[CampaignAssessment]:
    """Assess every recording of a campaign that was read."""
    asked = AnalysisOptions(**written.options)
    if asked.application is not None and checked is not None:
        _same_design(asked.application, checked)
    count = sum(len(drive.segments or (None,)) for drive in written.drives)
    if (identified or changed) and not (count == 1 and asked.identify):
        msg = (
            f"--corrected and the histories are of one recording with identify: {written.name} has "
            f"{count}" + ("" if count != 1 else " without it")
        )
        raise DesignError(msg)
    if changed and asked.changed is None:
        msg = f"--changed-history needs an application to be driven: `changed` in {written.name}"
        raise DesignError(msg)
    profile, own = asked.profile_and_limits()
    limits = (*own, *limits)
    parts: list[tuple[str, float, RecordingAssessment]] = []
    whose: list[int] = []
    drives: list[_SegmentedRecording] = []
    for k, drive in enumerate(written.drives):
        campaign, whole = recording_and_options(asked, drive)
        segments, before = drive.segments or (None,), list[tuple[str, float, float]]()
        for segment in segments:
            name, times, recording, seconds = drive.name, drive.times, whole, 0.0
            heard = campaign
            if segment is not None:
                name, times = f"{drive.name}, {segment.name}", times * segment.times
                first, last = _times(campaign, whole, segment)
                seconds, recording = last - first, time_slice(whole, first, last)
                heard = campaign.for_segment(first, last)
                twice = tuple(_twice(segment.name, first, last, before))
                recording = replace(recording, notes=(*recording.notes, *twice))
                before.append((segment.name, first, last))
            answer = (
                RecordingStudy(heard, draw=draw).run(replace(recording, name=name), tell).answer
            )
            assert answer is not None
            answer = _ended(answer, seconds)
            parts.append((name, times, answer))
            whose.append(k)
        spans = [(first, last) for _, first, last in before] or [(0.0, math.inf)]
        drives.append(_SegmentedRecording(campaign, whole, spans))
    names = [one.name for one in parts[0][2].lives]
    lives = tuple(
        _mixed(
            MixGaugeResult(name, tuple((heard.lives[k], times) for _, times, heard in parts)),
            drives,
            parts[0][2].plan,
        )
        for k, name in enumerate(names)
    )
    when = EvaluationCondition("recording", written.title)
    mix = CampaignAssessment(
        title=written.title,
        parts=tuple(_crossed(parts)),
        lives=lives,
        profile=profile,
        customer_share=written.customer_share,
        recording_indices=tuple(whose),
        damage_at_failure=asked.allowed,
        options=asked,
        alternative_lives=tuple(_mixed_otherwise(asked, parts, lives)),
    )
    theirs, unknown = _customers(mix)
    whom, line = replace(when, what=CUSTOMER_PERCENTILE_LABEL), asked.line
    ends = {one.name: end for one in lives if (end := one.sequenced_life) is not None}
    most = {one.name: one.upper_bound for one in theirs}
    return StudyResult(
        study=STUDY_NAME,
        answer=mix,
        checks=(
            *limit_checks(lives, limits, when=when, line=line, ends=ends),
            *limit_checks(theirs, limits, when=whom, line=line, ends=most),
        ),
        unevaluated=(
            *unevaluated_limits(lives, limits, when=when, line=line),
            *unevaluated_limits(
                unknown, limits, when=whom, line=line, needs=(NEED_TEXT_THREE_CUSTOMERS,)
            ),
        ),
    )


def _mixed(
    one: MixGaugeResult, drives: Sequence[_SegmentedRecording], plan: AssessmentSettings
) -> MixGaugeResult:
    """Return a gauge of a mix with what happens between its parts."""
    if not one.has_signal:
        return one
    # What is left out of the count by choice is not put back here.
    rule = repeating if plan.residue_rule is discarded else plan.residue_rule

    def gained(
        parts: Sequence[tuple[GaugeAssessment, float]], rule: ResidueRule
    ) -> tuple[RepeatedSequence, float]:
        order = order_blocks_for_high_damage(
            [life.residue for life, _ in parts], times=[times for _, times in parts],
            curve=plan.curve, correction=plan.correction, rule=rule,
        )  # fmt: skip
        return order, miner_damage(
            order.additional_cycles, curve=plan.curve, correction=plan.correction
        )

    hidden, place = list[str](), 0
    for drive in drives:
        own = one.parts[place : (place := place + len(drive.segments))]
        _, more = gained(own, repeating)
        if more > MAX_UNDECIDED_DAMAGE_CHANGE * sum(
            times * life.life.damage for life, times in own
        ):
            hidden += drive.hides(tuple(own[0][0].channel_reports))
    order, between = gained(one.parts, rule)
    return replace(
        one,
        transition_damage=between,
        sequence=order,
        undecided_faults=tuple(dict.fromkeys(hidden)),
    )


def _customers(of: CampaignAssessment) -> tuple[list[CustomerPercentile], list[MixGaugeResult]]:
    """Return gauges as a share of customers has them, and those for which that is unknown."""
    told, known, unknown = (
        of.customer_damage_rates,
        list[CustomerPercentile](),
        list[MixGaugeResult](),
    )
    for one in of.lives if of.customer_share else ():
        if one.name in told:
            life = one.life
            own, most = (replace(life, damage=r * life.duration) for r in told[one.name])
            known.append(CustomerPercentile(one.name, own, most))
        elif one.has_signal and not one.vetoes:
            unknown.append(one)
    return known, unknown


def recording_and_options(
    asked: AnalysisOptions, drive: RecordingSpec
) -> tuple[AnalysisOptions, Recording]:
    """Return the settings of one recording of a campaign, and that recording."""
    own = {
        k: (*getattr(asked, k), *v) if k in ("mask", "accept", "scale") else v
        for k, v in drive.options.items()
    }
    campaign = replace(asked, limits=None, target_hours=None, **own)
    whole = _opened(drive.file, campaign)
    for file, late, dbc in drive.second_files:
        beside = AnalysisOptions(sn=asked.sn, dbc=dbc)
        whole = merge_recordings(whole, _opened(file, beside), late=late)
    return campaign, whole


def _twice(
    name: str, first: float, last: float, before: Iterable[tuple[str, float, float]]
) -> Iterator[str]:
    """Yield what of a segment, s, is of those before it too."""
    for other, begins, ends in before:
        both = min(last, ends) - max(first, begins)
        if both > 0:
            yield f"{name} and {other} have {both:.4g} s in common, which count in both"


def _ended(answer: RecordingAssessment, asked: float) -> RecordingAssessment:
    """Return an answer that says where its recording ended before its segment did, s."""
    there = max(one.quality.recorded_time for one in answer.lives)
    if there > asked - 1:
        return answer
    of = answer.recording
    note = f"{of.name} is of {asked:g} s, and the recording ends after {there:g} s of them"
    return replace(answer, recording=replace(of, notes=(*of.notes, note)))


def _crossed(
    parts: Sequence[tuple[str, float, RecordingAssessment]],
) -> Iterator[tuple[str, float, RecordingAssessment]]:
    """Yield parts, with a note where the findings of two gauges change places from one to another.

    The joints may dominate at one gauge on one road and not on the next; that two gauges swap is
    how exchanged plugs look.
    """
    before: list[tuple[str, dict[str, str]]] = []
    for name, times, heard in parts:
        found = {} if heard.causes is None else {
            gauge: e.verdict
            for gauge, e in zip(heard.causes.gauges, heard.causes.joint_attributions, strict=True)
        }  # fmt: skip
        guilty, innocent = (
            [g for g, finding in found.items() if finding == of]
            for of in (JOINTS_DOMINANT, JOINTS_NOT_DOMINANT)
        )
        notes = [
            f"joints dominate at {one} here and not at {other}, and in {earlier} it was the other "
            "way round: are their channels exchanged?"
            for earlier, then in before
            for one in guilty
            for other in innocent
            if then.get(one) == JOINTS_NOT_DOMINANT and then.get(other) == JOINTS_DOMINANT
        ]
        before.append((name, found))
        if notes:
            of = heard.recording
            heard = replace(heard, recording=replace(of, notes=(*of.notes, *notes[:1])))
        yield name, times, heard


def _same_design(driven: Application, checked: Application) -> None:
    """Refuse recordings of one design in the verdict of another: its gauges never felt that."""
    if driven.written is None or checked.written is None:
        return
    was, now = driven.written.numbers, checked.written.numbers
    both = was.keys() & now.keys()
    other = [k for k in {**was, **now} if k not in both or not np.array_equal(was[k], now[k])]
    if other:
        first = other[0]
        msg = (
            f"the recordings are of {driven.written.name}, where {first} is "
            f"{was.get(first, 'not given')}; in {checked.written.name}, which is checked, it is "
            f"{now.get(first, 'not given')}: check the one that was driven, or name in "
            "`application` the one that was"
        )
        raise DesignError(msg)


def _mixed_otherwise(
    campaign: AnalysisOptions,
    parts: Sequence[tuple[str, float, RecordingAssessment]],
    lives: Sequence[MixGaugeResult],
) -> Iterator[AlternativeLives]:
    """Yield what a mix comes to otherwise, at each gauge that every recording has an answer of."""
    told = [{o.gauge: o for o in heard.alternative_lives} for _, _, heard in parts]
    for one in lives:
        if all(one.name in of for of in told):
            yield alternative_lives_of_recording_mix(
                one,
                [(of[one.name], times) for of, (_, times, _) in zip(told, parts, strict=True)],
                parts[0][2].plan,
                gauge=one.name,
                turned=one.sequenced_cycles,
                strained=campaign.strain_life_settings,
                crack=campaign.crack_growth_settings,
                hours=campaign.service_hours,
                miner_scatter=campaign.miner_scatter,
            )


def _times(
    campaign: AnalysisOptions, recording: Recording, segment: RecordingSegment
) -> tuple[float, float]:
    """Return from when to when a segment is, s.

    Raises
    ------
    DesignError
        If it is by place and the distance is unknown, or the way ends before it.
    """
    if not segment.by_distance:
        return segment.first, segment.last
    angle = measured_shaft_angle(campaign, campaign.scale_channels(recording))
    ratio, radius = campaign.axle_ratio, campaign.tyre_radius_m
    if angle is None or ratio is None or radius is None:
        msg = (
            f"segment {segment.name} is by place: that needs the shaft's speed or tacho, "
            "axle_ratio and tyre_radius_m"
        )
        raise DesignError(msg)
    of = angle.rotation
    way = (of.turns - of.turns[0]) / ratio * RADIANS_PER_TURN * radius
    if segment.first >= way[-1]:
        msg = (
            f"segment {segment.name} begins at {segment.first / 1e3:g} km, the way ends at "
            f"{way[-1] / 1e3:.4g} km"
        )
        raise DesignError(msg)
    first, last = (float(np.interp(v, way, of.time)) for v in (segment.first, segment.last))
    return max(first, 0.0), last


def _opened(path: Path, campaign: AnalysisOptions) -> Recording:
    try:
        return open_recording(
            path, rate=campaign.rate, time=campaign.time, group=campaign.group,
            dbc=campaign.can_databases,
        )  # fmt: skip
    except ImportError as error:
        msg = f"this needs {error.name}; pip install 'cardan[fatigue,recordings]'"
        raise MissingDependencyError(msg) from error
