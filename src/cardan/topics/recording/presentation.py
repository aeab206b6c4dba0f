"""What a recording or a campaign did, as lines of text."""

import math
from collections.abc import Iterator, Sequence

import numpy as np

from cardan.approval.coverage import coverage_of
from cardan.approval.study import StudyResult
from cardan.core.message import TranslatableMessage
from cardan.core.units import MPa, hour
from cardan.physics.signals.assessment import GaugeAssessment
from cardan.physics.signals.attribution_result import (
    JOINTS_DOMINANT,
    JOINTS_NOT_DOMINANT,
    UNDETERMINED,
    VALIDATED_ERROR_RATES,
    JointAttribution,
)
from cardan.physics.signals.cause_assessment import DamageCausesByGauge
from cardan.physics.signals.conditioning import ChannelReport
from cardan.physics.signals.damage_attribution import (
    CAUSE_JOINTS,
    ShapleyAttribution,
)
from cardan.physics.signals.data_quality import (
    MAX_HIGH_FREQUENCY_POWER_SHARE,
    MAX_UNDECIDED_DAMAGE_CHANGE,
    FaultEffect,
)
from cardan.physics.signals.faults.waveform import FAULT_FREEZE, FAULT_MISSING_SAMPLES
from cardan.physics.signals.recording import Recording
from cardan.physics.signals.synchronous_fit import MIN_DETECTION_F_STATISTIC
from cardan.render.i18n import ENGLISH, Translator
from cardan.render.phrases import grouped_unevaluated_lines, worst_check_per_limit
from cardan.render.terminal import (
    aligned_column_lines,
    check_table_lines,
    unevaluated_lines,
    verdict_headline,
)
from cardan.topics.recording import alternative_life_presentation as otherwise
from cardan.topics.recording import identification_presentation as identified
from cardan.topics.recording import method_presentation as counting
from cardan.topics.recording import usage_presentation as used
from cardan.topics.recording.campaign_assessment import (
    MIN_CUSTOMERS,
    CampaignAssessment,
    MixGaugeResult,
)
from cardan.topics.recording.finding_phrases import finding_message, finding_messages
from cardan.topics.recording.life_verdict import assessment_verdict
from cardan.topics.recording.options import LIFE_OPTION_SOURCE
from cardan.topics.recording.recording_assessment import (
    AlternativeBusErrorInterpretation,
    RecordingAssessment,
)

_DOING = {"look": "reading", "count": "counting cycles", "usage": "counting cycles",
          "strain": "counting cycles", "draw": "drawing"}  # fmt: skip
"""What is done in a pass over a recording, by its name in a study; all others seek causes."""


MIN_REPORTED_FREEZE_DAMAGE_CHANGE = 0.01
"""Relative change of damage from which a freeze at rest is reported: it should change none."""
MAX_REPORTED_VALID_SHARE = 0.9999
"""Share of the time with valid data from which a gauge counts as wholly valid."""

MAX_REPORTED_LIFE_RATIO = 1000
"""1, of lives: a larger ratio says nothing that this number does not."""


def progress_text(doing: str, say: Translator) -> str:
    """Return what a study does, and how far its pass is; behind a whole one it is thought over."""
    name, far = doing.split(maxsplit=1)
    said = say(_DOING.get(name, "looking for causes"))
    return said if far == "100%" else f"{said}: {far}"


def campaign_answer(found: StudyResult[CampaignAssessment]) -> CampaignAssessment:
    """Return the answer of a campaign, which its study always has."""
    assert found.answer is not None
    return found.answer


def campaign_terminal_lines(
    found: StudyResult[CampaignAssessment], say: Translator = ENGLISH
) -> Iterator[str]:
    """Yield the verdict on a campaign, its mix, and each recording as lines of text."""
    of = campaign_answer(found)
    yield from _verdict(found, of.title, of.profile, say)
    yield from campaign_text_lines(of, say)


def study_text_lines(found: StudyResult[CampaignAssessment], say: Translator) -> Iterator[str]:
    """Yield recordings that were evaluated with an application, as lines of text."""
    assert found.answer is not None  # of a study that answered
    yield from campaign_text_lines(found.answer, say)


def campaign_text_lines(of: CampaignAssessment, say: Translator = ENGLISH) -> Iterator[str]:
    """Yield what recordings come to together and each of them as lines of text, ungraded."""
    for one in of.lives:
        yield ""
        yield from aligned_column_lines(recording_mix_gauge_rows(of, one, say))
        yield from recording_mix_gauge_sentences(of, one, say)
    for one in of.alternative_lives:
        yield from otherwise.text_lines(one, say)
    yield from customer_damage_lines(of, say)
    for _, _, heard in of.parts:
        yield ""
        yield from text_lines(heard, say)
        yield from _said_more(heard, say)


def customer_damage_lines(of: CampaignAssessment, say: Translator) -> Iterator[str]:
    """Yield what a share of customers does to each gauge, if the campaign requests one."""
    for gauge, (rate, bound) in of.customer_damage_rates.items():
        yield say(
            "{gauge}: {share} of customers do at most {rate} damage per hour (90 % bound {bound}), "
            "each recording taken for one of them: {hours} h, at the bound {least} h",
            gauge=gauge,
            share=say.percentage(of.customer_share),
            rate=say.significant_number(rate * hour, 3),
            bound=say.significant_number(bound * hour, 3),
            hours=_long(of.damage_at_failure / (rate * hour), say),
            least=_long(of.damage_at_failure / (bound * hour), say),
        )
    for one in of.lives if of.customer_share else ():
        if one.name not in of.customer_damage_rates:
            yield say(
                "{gauge}: customers not evaluated: at least {count} recordings with damage there "
                "are needed, none with rejected data",
                gauge=one.name, count=MIN_CUSTOMERS,
            )  # fmt: skip


def recording_mix_gauge_rows(
    of: CampaignAssessment, one: MixGaugeResult, say: Translator
) -> list[tuple[str, ...]]:
    """Return what each recording does to a gauge of a mix as rows, their heads first."""
    whole = one.life.damage or math.nan
    rows = [
        (one.name, say("times"), say("live h"), say("damage"), say("per h"), say("per km"),
         say("of the mix")),
    ]  # fmt: skip
    for (name, times, _), (part, _) in zip(of.parts, one.parts, strict=True):
        life = part.life
        per_km = life.damage / (life.distance / 1e3) if life.distance > 0 else math.nan
        per_hour = life.damage / life.duration * hour if life.duration > 0 else math.nan
        rows.append(
            (f"  {name}", say.compact_number(times), say.compact_number(life.duration / hour, 3),
             _known(life.damage, ".4g", say), _known(per_hour, ".3g", say),
             _known(per_km, ".3g", say), _known(times * life.damage / whole, ".1%", say))
        )  # fmt: skip
    rows.append(
        (f"  {say('the mix')}", "", say.compact_number(one.life.duration / hour, 3),
         _known(whole, ".4g", say), "", "", "")
    )  # fmt: skip
    return rows


def recording_mix_gauge_sentences(
    of: CampaignAssessment, one: MixGaugeResult, say: Translator
) -> Iterator[str]:
    """Yield how long a gauge lives of a mix, and what of its damage is the joints'."""
    if not one.vetoes:
        hours = recording_mix_life_text(one, say)
        yield say("{gauge}: lives {hours} h of the mix", gauge=one.name, hours=hours)
    yield from mix_caveat_lines(one, say)
    if evidence := of.evidence(one.name):
        yield say(
            "{gauge}: {share} of the mix's damage would go with the joints "
            "(90 % interval {low} to {high}): {finding}",
            gauge=one.name, finding=say(evidence.verdict).upper(),
            **_shares(evidence, say),
        )  # fmt: skip
        yield from verdict_error_rate_lines(evidence.verdict, say)


def mix_caveat_lines(one: MixGaugeResult, say: Translator) -> Iterator[str]:
    """Yield why a mix has no life at a gauge, and a shorter life with its parts in turn."""
    if one.vetoes:
        yield say(
            "{gauge}: DATA REJECTED (review needed): the damage depends on {kinds} of some "
            "recording",
            gauge=one.name, kinds=say.join(*map(say, one.vetoes)),
        )  # fmt: skip
    if one.undecided_faults:
        yield say(
            "{gauge}: segments of one recording are at levels so far apart that as one its data "
            "would be rejected, for {kinds}; with --accept they count as felt by the part",
            gauge=one.name, kinds=say.join(*map(say, one.undecided_faults)),
        )  # fmt: skip
    elif (turn := one.sequenced_life) and not one.vetoes:
        yield say(
            "{gauge}: that is of parts each by itself; driven in turn, cycles from one to the "
            "other bring it to {damage} damage: {hours} h",
            gauge=one.name, damage=_known(turn.damage, ".4g", say), hours=_long(turn.hours, say),
        )  # fmt: skip


def recording_mix_life_text(of: MixGaugeResult, say: Translator) -> str:
    """Return how many hours of a mix a gauge lives, or why that is unknown."""
    if of.vetoes:
        return say("data rejected")
    return _long(of.life.hours if of.has_signal else math.nan, say)


def _shares(of: JointAttribution, say: Translator) -> dict[str, str]:
    low, high = of.interval
    each = {"share": of.damage_share, "low": low, "high": high}
    return {name: say.percentage(value) for name, value in each.items()}


def recording_answer(found: StudyResult[RecordingAssessment]) -> RecordingAssessment:
    """Return the answer of a recording, which its study always has."""
    assert found.answer is not None  # of a recording that could be assessed
    return found.answer


def cause_places(causes: DamageCausesByGauge | None) -> dict[str, int]:
    """Return where causes have each gauge: they leave out those that said nothing."""
    return {name: k for k, name in enumerate(causes.gauges if causes else ())}


def _known(value: float, as_: str, say: Translator) -> str:
    return "-" if math.isnan(value) else say.with_decimal_sign(format(value, as_))


def _long(value: float, say: Translator) -> str:
    """Return hours or kilometres, which may have no end."""
    if math.isnan(value):
        return say("not known")
    return say.compact_number(value, 4) if math.isfinite(value) else say("no end")


def terminal_lines(
    found: StudyResult[RecordingAssessment], say: Translator = ENGLISH
) -> Iterator[str]:
    """Yield the verdict, the limits that were evaluated, and the report as lines of text."""
    of = recording_answer(found)
    yield from _verdict(found, of.recording.name, of.profile, say)
    yield ""
    yield from text_lines(of, say)
    yield from _said_more(of, say)


def _said_more(of: RecordingAssessment, say: Translator) -> Iterator[str]:
    """Yield results of a recording beyond damage and cause as lines of text."""
    for one in of.alternative_readings:
        yield from bus_error_lines(one, say)
    for one in of.usage:
        yield from used.text_lines(one, say)
    for one in of.alternative_lives:
        yield from otherwise.text_lines(one, say)
    if of.identification is not None:
        yield ""
        yield from identified.text_lines(of.identification, say)
    if of.predicted_lives:
        yield ""
        yield from identified.predicted_life_lines(of, say)
    elif of.lacks_prediction:
        yield f"  {identified.no_change_prediction_sentence(say)}"


def bus_error_lines(of: AlternativeBusErrorInterpretation, say: Translator) -> Iterator[str]:
    """Yield where a bus' number for no value stands, and what the other reading would do."""
    own = of.bus_error_values
    places = {
        "channel": own.channel,
        "seconds": say.compact_number(float(np.diff(own.intervals).sum()), 3),
        "count": len(own.intervals),
        "first": say.compact_number(float(own.intervals[0, 0]), 6),
        "speed": f"{say.compact_number(own.speed * 60, 7)} rpm",
        "turns": say.compact_number(abs(of.additional_turns), 3),
    }
    if not math.isnan(own.torque):
        torque = {"torque": f"{say.compact_number(own.torque, 7)} N m"}
        if own.accepted_count:
            yield say(
                "{channel}: accepted as a torque for {seconds} s in {count} places, the first at "
                "{first} s: {torque}, which a bus (SAE J1939) writes for an error or no value",
                **places | torque,
            )  # fmt: skip
        else:
            yield say(
                "{channel}: no torque for {seconds} s in {count} places, the first at {first} s: "
                "{torque}, which a bus (SAE J1939) writes for an error or no value, taken for "
                "holes (--accept {channel}=sentinel)",
                **places | torque,
            )  # fmt: skip
    elif own.accepted_count:
        yield say(
            "{channel}: accepted as a speed for {seconds} s in {count} places, the first at "
            "{first} s: {speed}, which a bus (SAE J1939) writes for an error or no value; as "
            "holes the shaft would make {turns} turns less",
            **places,
        )  # fmt: skip
    else:
        yield say(
            "{channel}: no speed for {seconds} s in {count} places, the first at {first} s: "
            "{speed}, which a bus (SAE J1939) writes for an error or no value, taken for holes; as "
            "speeds the shaft would make {turns} turns more (--accept {channel}=sentinel)",
            **places,
        )  # fmt: skip
    for gauge, evidence in of.evidence.items():
        yield say(
            "{gauge}: with that taken otherwise {share} of the damage would go with the joints "
            "(90 % interval {low} to {high}): {finding}",
            gauge=gauge, finding=say(evidence.verdict).upper(), **_shares(evidence, say),
        )  # fmt: skip


def _verdict(
    found: StudyResult[RecordingAssessment] | StudyResult[CampaignAssessment],
    title: str,
    profile: str,
    say: Translator,
) -> Iterator[str]:
    """Yield the verdict and each limit where it is worst, or that there is none."""
    verdict = assessment_verdict(found)
    if verdict is None:
        yield say(
            "No limit given: --target-hours or --limits compare the gauges' lives with a limit."
        )
    else:
        yield verdict_headline(title, verdict, found.checks, found.unevaluated, say)
    if any(x.limit.source != LIFE_OPTION_SOURCE for x in (*found.checks, *found.unevaluated)):
        yield say("limits: {profile}", profile=profile)
    elif profile:
        yield say("{profile} limits no fatigue_life and no fatigue_damage.", profile=profile)
    yield from check_table_lines(worst_check_per_limit(found.checks), say)
    yield from unevaluated_lines(
        grouped_unevaluated_lines(found.unevaluated, say), coverage_of(found), say
    )


def text_lines(of: RecordingAssessment, say: Translator = ENGLISH) -> Iterator[str]:
    """Yield the report as lines of text."""
    recording, lives, causes = of.recording, of.lives, of.causes
    duration = lives[0].quality.recorded_time
    yield say(
        "{recording}: {hours} h at {rate} Hz", recording=recording.name,
        hours=say.compact_number(duration / hour, 4), rate=say.compact_number(recording.rate),
    )  # fmt: skip
    for note in recording.notes:
        yield say("  note: {note}", note=recording_note_text(note, say))
    for line in channel_fault_lines(recording, lives, say):
        yield f"  {line}"
    yield ""
    yield from aligned_column_lines(gauge_rows(lives, say))
    yield ""
    yield from counting.text_lines(of, say)
    for one in lives:
        yield from data_quality_lines(one, rate=recording.rate, say=say)
    if causes is not None:
        yield from damage_cause_lines(lives, causes, say)


def damage_cause_lines(
    lives: Sequence[GaugeAssessment], causes: DamageCausesByGauge, say: Translator = ENGLISH
) -> Iterator[str]:
    """Yield the causes at each gauge as lines of text."""
    places = cause_places(causes)
    for one in lives:
        k = places.get(one.name)
        if k is None:
            continue
        yield ""
        yield from aligned_column_lines(damage_cause_rows(one.name, causes, k, say))
        yield from joint_damage_share_lines(one.name, causes, k, say)
    yield ""
    yield say(
        "Shares are Shapley values; without it and alone are damages over that of all together."
    )
    for doubt in finding_messages(causes.doubts):
        yield say("doubt: {doubt}", doubt=say.translate_message(doubt))


def channel_fault_lines(
    recording: Recording, lives: Sequence[GaugeAssessment], say: Translator
) -> Iterator[str]:
    """Yield what looks wrong in the channels of gauges, a line each."""
    healths = {name: health for one in lives for name, health in one.channel_reports.items()}
    for name, health in healths.items():
        for finding in fault_messages(recording, name, health):
            yield f"{name}: {say.translate_message(finding)}"


def fault_messages(
    recording: Recording, channel: str, health: ChannelReport
) -> list[TranslatableMessage]:
    """Return what is to say of a channel that looks wrong."""
    found = health.findings(rate=recording.rate, unit=recording.channel(channel).unit)
    return [finding_message(one) for one in found]


def gauge_rows(lives: Sequence[GaugeAssessment], say: Translator) -> list[tuple[str, ...]]:
    """Return the gauges as rows, their heads first."""
    rows = [
        (say("gauge"), say("low, MPa"), say("high, MPa"), say("damage"), say("hours"), "km",
         "d ln D/d ln S"),
    ]  # fmt: skip
    for one in lives:
        life, hours = one.life, one.life.hours if one.has_signal else math.nan
        km = "" if math.isnan(life.kilometres * hours) else _long(life.kilometres, say)
        rows.append(
            (
                one.name,
                _known(one.min_stress / MPa, ".1f", say),
                _known(one.max_stress / MPa, ".1f", say),
                _known(life.damage, ".4g", say),
                say("data rejected") if one.vetoed else _long(hours, say),
                "" if one.vetoed else km,
                _known(one.damage_exponent, ".2f", say),
            )
        )
    return rows


def damage_cause_rows(
    name: str, causes: DamageCausesByGauge, k: int, say: Translator
) -> list[tuple[str, ...]]:
    """Return the causes of damage at a gauge as rows, their heads first."""
    found = causes.attributions[k]
    whole = found.total_damage or math.nan
    head = (say("{gauge}: cause", gauge=name), say("share"), say("without it"), say("alone"))
    return [
        head,
        *(
            (f"  {say(cause)}", say.percentage(found.share(cause), 1),
             say.with_decimal_sign(f"{found.without(cause) / whole:.3f}"),
             say.with_decimal_sign(f"{found.alone(cause) / whole:.3f}"))
            for cause in found.causes
        ),
    ]  # fmt: skip


def joint_damage_share_lines(
    name: str, causes: DamageCausesByGauge, k: int, say: Translator
) -> Iterator[str]:
    """Yield what the joints had to do with a gauge's damage, in words."""
    if causes.comparisons:
        c = causes.comparisons[k]
        yield say(
            "  order 2 measured over predicted {ratio}, correlation with torque {correlation}",
            ratio=_known(c.ratio, ".2f", say), correlation=_known(c.correlation, ".2f", say),
        )  # fmt: skip
    yield joint_verdict_sentence(name, causes.attributions[k], causes.joint_attributions[k], say)


def joint_verdict_sentence(
    gauge: str,
    attribution: ShapleyAttribution,
    evidence: JointAttribution | None = None,
    say: Translator = ENGLISH,
) -> str:
    """Say in a sentence or three how much the joints had to do with it, whichever way it falls."""
    whole, without = attribution.total_damage, attribution.without(CAUSE_JOINTS)
    if not whole > 0:
        return say("{gauge}: no damage, hence no cause.", gauge=gauge)
    longer = whole / without if without > 0 else math.inf
    share = say.percentage(attribution.share(CAUSE_JOINTS), 1)
    times = (
        f"> {MAX_REPORTED_LIFE_RATIO}"
        if longer > MAX_REPORTED_LIFE_RATIO
        else say.compact_number(longer, 3)
    )
    own = (
        say(
            "the joints' orders account for {share} of the damage; without them it would live as "
            "long.", share=share,
        )
        if times == "1"
        else say(
            "the joints' orders account for {share} of the damage; without them it would live "
            "{longer} times as long.", share=share, longer=times,
        )
    )  # fmt: skip
    parts = [f"{gauge}: {own}"]
    if evidence is not None:
        shares = _shares(evidence, say)
        if evidence.f_statistic < MIN_DETECTION_F_STATISTIC and evidence.verdict == UNDETERMINED:
            # A share of zero next to "undetermined" would be read as "do not dominate".
            return say(
                "{gauge}: UNDETERMINED: no component is locked to the shaft; by phase and torque "
                "{share} of the damage would go with the joints (90 % interval {low} to {high}). "
                "With that share as the joints', {own}",
                gauge=gauge, own=own, **shares,
            )  # fmt: skip
        parts.append(
            say(
                "By phase and torque {share} of the damage would go with them (90 % interval {low} "
                "to {high}): {finding}.",
                finding=say(evidence.verdict).upper(), **shares,
            )
        )  # fmt: skip
        parts += verdict_error_rate_lines(evidence.verdict, say)
    chief, most = max(attribution.shares.items(), key=lambda kv: kv[1])
    if chief != CAUSE_JOINTS:
        parts.append(
            say("The largest share, {share}, is of {cause}.",
                share=say.percentage(most, 1), cause=say(chief))
        )  # fmt: skip
    return " ".join(parts)


VERDICT_ERROR_RATE_TEXTS = {
    JOINTS_NOT_DOMINANT: "Error rate of this finding: of {cases} gauges where joints dominate, "
    '{wrong} were found "joints do not dominate" ({most} at most); of '
    "{stops} of lines on a stop, {stopped} ({mostly} at most).",
    JOINTS_DOMINANT: "Error rate of this finding: of {cases} gauges where joints do not "
    'dominate, {wrong} were found "joints dominate" ({most} at most); of '
    "{stops} of lines on a stop, {stopped} ({mostly} at most).",
}
"""How often each finding was wrong."""


def verdict_error_rate_lines(finding: str, say: Translator) -> Iterator[str]:
    """Yield how often such a finding was wrong where the truth is known."""
    if finding in VALIDATED_ERROR_RATES:
        plain, stopped = VALIDATED_ERROR_RATES[finding]
        yield say(
            VERDICT_ERROR_RATE_TEXTS[finding],
            cases=plain.cases,
            wrong=plain.wrong,
            stops=stopped.cases,
            stopped=stopped.wrong,
            most=say.percentage(plain.upper_bound, 1),
            mostly=say.percentage(stopped.upper_bound, 1),
        )


def fault_effect_line(gauge: str, e: FaultEffect, say: Translator) -> str:
    """Return what a kind of fault changes at a gauge; "" of what only takes time away."""
    decided = say("undecided") if e.undecided else say("decided")
    if e.reason is not None:
        return say(
            "{gauge}: {kind} ({state}): {why}",
            gauge=gauge,
            kind=say(e.kind),
            state=decided,
            why=say.translate_message(finding_message(e.reason)),
        )
    if e.kind == FAULT_MISSING_SAMPLES:
        if e.change_if_worst <= MAX_UNDECIDED_DAMAGE_CHANGE:
            return ""
        return say(
            "{gauge}: {seconds} s missing: damage {recorded} as recorded, {worst} if they were "
            "like the worst recorded",
            gauge=gauge,
            seconds=say.compact_number(e.hidden_time, 3),
            recorded=_known(e.damage_recorded, ".4g", say),
            worst=_known(e.damage_if_worst, ".3g", say),
        )
    known = {
        "gauge": gauge,
        "kind": say(e.kind),
        "count": e.count,
        "state": decided,
        "recorded": _known(e.damage_recorded, ".4g", say),
        "without": _known(e.damage_without, ".4g", say),
    }
    if not math.isnan(e.damage_if_worst):
        return say(
            "{gauge}: {kind} ({count}, {state}): damage {recorded} as recorded, {without} without, "
            "{worst} if the {seconds} s that it hides were like the worst recorded",
            **known,
            worst=_known(e.damage_if_worst, ".3g", say),
            seconds=say.compact_number(e.hidden_time, 3),
        )
    if e.kind == FAULT_FREEZE and e.change < MIN_REPORTED_FREEZE_DAMAGE_CHANGE:
        return ""
    return say(
        "{gauge}: {kind} ({count}, {state}): damage {recorded} as recorded, {without} without",
        **known,
    )


def declaration_doubt_lines(one: GaugeAssessment, say: Translator) -> Iterator[str]:
    """Yield a unit that is assumed, and what looks as if it had been declared wrongly."""
    of, name = one.quality, one.name
    if of.assumed_unit is not None:
        yield say(
            "{gauge}: assumed to be in {unit}, as the recording does not say; were it in {other}, "
            "its stress would be {factor} times and its damage {damage}",
            gauge=name,
            unit=of.assumed_unit.unit,
            other=of.assumed_unit.other_unit,
            factor=say.compact_number(of.assumed_unit.factor, 3),
            damage=_known(of.assumed_unit.damage, ".3g", say),
        )
    for doubt in of.doubts:
        yield say(
            "{gauge}: doubt: {doubt}",
            gauge=name,
            doubt=say.translate_message(finding_message(doubt)),
        )


def recording_note_text(note: str, say: Translator) -> str:
    """Return a note on a recording, its numbers as the language writes them."""
    return say.localise_numbers(say.error(say.translate_if_known(note)))


def valid_share_text(share: float, say: Translator) -> str:
    """Return a share in tenths of a per cent, cut: what is not whole is not shown as whole."""
    return say.percentage(math.floor(round(share * 1e3, 6)) / 1e3, 1)


def valid_data_line(one: GaugeAssessment, say: Translator) -> str:
    """Return how much of the time a gauge has valid data; "" if all of it."""
    if one.quality.live_share >= MAX_REPORTED_VALID_SHARE:
        return ""
    return say(
        "{gauge}: {share} valid data; the life is of that time",
        gauge=one.name, share=valid_share_text(one.quality.live_share, say),
    )  # fmt: skip


def undersampling_line(one: GaugeAssessment, rate: float, say: Translator) -> str:
    """Return that a gauge looks undersampled; "" if it does not."""
    if one.quality.high_frequency_share <= MAX_HIGH_FREQUENCY_POWER_SHARE:
        return ""
    return say(
        "{gauge}: undersampled, or a contact chatters: {share} of its power, of all or where "
        "it is loudest, lies above {frequency} Hz, and what was faster still is folded in",
        gauge=one.name,
        share=say.percentage(one.quality.high_frequency_share),
        frequency=say.compact_number(0.4 * rate),
    )


def shear_line(one: GaugeAssessment, say: Translator) -> str:
    """Return that a rosette's measure decides, as its stress is mostly shear; "" if it is not."""
    of = one.quality
    if not of.shear_dominated:
        return ""
    each = (
        f"{say.translate_if_known(n)} {say.significant_number(damage, 4)}"
        for n, damage in of.damage_by_measure.items()
    )
    return say(
        "{gauge}: mostly shear (biaxiality {biaxiality}), so its measure decides: damage by "
        "{measures}",
        gauge=one.name, biaxiality=_known(of.biaxiality, ".2f", say), measures=say.join(*each),
    )  # fmt: skip


def rejection_line(one: GaugeAssessment, say: Translator) -> str:
    """Return that a gauge's data are rejected, and for what; "" if they are not."""
    if not one.quality.vetoes:
        return ""
    return say(
        "{gauge}: DATA REJECTED (review needed): the damage depends on {kinds}; use --mask or "
        "--accept",
        gauge=one.name, kinds=say.join(*map(say, one.quality.vetoes)),
    )  # fmt: skip


def no_signal_line(one: GaugeAssessment, say: Translator) -> str:
    """Return that a gauge has no signal."""
    return say("{gauge}: said nothing, so its life is not known", gauge=one.name)


def data_quality_lines(one: GaugeAssessment, *, rate: float, say: Translator) -> Iterator[str]:
    """Yield how far a gauge's answer may be trusted, why no farther, and when how many fail."""
    of, name = one.quality, one.name
    if not one.has_signal:
        yield no_signal_line(one, say)
        return
    yield from filter(None, (fault_effect_line(name, e, say) for e in of.effects))
    yield from declaration_doubt_lines(one, say)
    yield from filter(None, [valid_data_line(one, say)])
    if not math.isnan(of.damage_of_samples_only):
        yield say(
            "{gauge}: its crests fall between samples and were looked for there: damage {damage} "
            "by the samples alone",
            gauge=name, damage=_known(of.damage_of_samples_only, ".4g", say),
        )  # fmt: skip
    yield from filter(None, [undersampling_line(one, rate, say)])
    yield from filter(None, [shear_line(one, say)])
    if rejected := rejection_line(one, say):
        yield rejected
        return
    lasts = [
        say("{share} failed {hours} h", share=say.percentage(f),
            hours=_long(n * one.life.duration / hour, say))
        for f, n in one.repeats.items()
    ]  # fmt: skip
    if len(set(one.repeats.values())) > 1:  # one drive by one vehicle does not scatter
        yield f"{name}: {say.join(*lasts)}"
    if one.spectral_damage and one.life.damage > 0:
        beside = (
            f"{n.replace('_', '-').title()} {say.with_decimal_sign(f'{d / one.life.damage:.2f}')}"
            for n, d in one.spectral_damage.items()
        )
        yield say(
            "{gauge}: damage by spectrum over rainflow: {methods}",
            gauge=name, methods=say.join(*beside),
        )  # fmt: skip
