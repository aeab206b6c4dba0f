"""First screen of `cardan life`: verdict, life and cause of each gauge, data quality, next."""

import math
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from cardan.approval.study import StudyResult
from cardan.core.finding import Finding
from cardan.core.units import MPa, hour
from cardan.core.verdict import CHECK_GRADES, Check, CheckGrade, worst_first_key
from cardan.physics.signals.assessment import GaugeAssessment
from cardan.physics.signals.attribution_result import (
    DOUBT_RESPONSE_STEP,
    JOINTS_DOMINANT,
    UNDETERMINED,
    JointAttribution,
)
from cardan.physics.signals.damage_attribution import CAUSE_JOINTS, ShapleyAttribution
from cardan.render.check_texts import limit_text, uncapitalised, unit_text, value_text
from cardan.render.i18n import ENGLISH, Translator
from cardan.render.phrases import grouped_unevaluated_lines, verdict_word
from cardan.render.screen_layout import (
    capped_item_lines,
    capped_list_lines,
    more_text,
    share_text,
    title_and_verdict_lines,
)
from cardan.render.terminal import GRADE_MARKS, bold
from cardan.render.text_layout import DEFAULT_WIDTH_COLUMNS, fold_lines, table_lines
from cardan.topics.recording import alternative_life_presentation as otherwise
from cardan.topics.recording import presentation as report
from cardan.topics.recording.campaign_assessment import CampaignAssessment, MixGaugeResult
from cardan.topics.recording.finding_phrases import finding_message, finding_messages
from cardan.topics.recording.identification_presentation import doubt_sentences
from cardan.topics.recording.life_verdict import assessment_verdict
from cardan.topics.recording.options import LIFE_OPTION_SOURCE
from cardan.topics.recording.predicted_life import PredictedLife
from cardan.topics.recording.recording_assessment import RecordingAssessment

MAX_LINES = 32
"""Lines of the screen at 80 columns; the blocks below keep to it together."""

MAX_TABLE_LINES = 10
MAX_LIST_LINES = 2
MAX_EXTRA_LINES = 5
MIN_BLOCK_LINES, MAX_BLOCK_LINES = 2, 8
"""Lines of data quality and of what a signer should know, below their heads."""

LIFE_INTERVAL_FAILED_SHARES = 0.1, 0.9
"""Shares of parts that have failed at the ends of a life's interval."""

UNKNOWN_MARK = "?"
"""Mark of a gauge whose life is not known."""

MIN_CHANGE_NAMED_FIRST = 0.01
"""Relative change of damage from which a fault stands ahead of others."""

NOTE_RANK = 4
"""Rank of a note of the reader among what limits the trust in data."""

Found = StudyResult[RecordingAssessment] | StudyResult[CampaignAssessment]


@dataclass(frozen=True, kw_only=True)
class GaugeResult:
    """What decides at one gauge, of a recording or of a mix.

    `hours` is nan where the life is not known; `interval` is of 10 and 90 % of parts failed, h;
    `causes` are the damage shares of the recording that does most damage there.
    """

    name: str
    hours: float
    rejected: bool
    interval: tuple[float, float] | None
    evidence: JointAttribution | None
    causes: ShapleyAttribution | None
    checks: tuple[Check, ...]

    @property
    def grade(self) -> CheckGrade:
        """Its worst verdict; "pass" where no limit is given."""
        grades: list[CheckGrade] = [c.grade for c in self.checks]
        return max(["pass", *grades], key=CHECK_GRADES.index)

    @property
    def order(self) -> tuple[int, float]:
        """Place on the screen: exceeded, unknown, beyond recommended, then the shortest life."""
        unknown = math.isnan(self.hours)
        place = {"fail": 0, "warn": 2, "pass": 3}[self.grade]
        return (1, 0.0) if unknown and place else (place, self.hours)


def screen_lines(
    found: Found, say: Translator = ENGLISH, *, width: int = DEFAULT_WIDTH_COLUMNS
) -> Iterator[str]:
    """Yield verdict, life and cause of each gauge, data quality, open points, next commands.

    At 80 columns at most `MAX_LINES` lines, unless a title or a message alone is longer.
    """
    of = found.answer
    assert of is not None  # of a study that answered
    parts = _parts(of)
    gauges = gauge_results(found)
    above = [
        *_title_lines(found, of, say, width),
        *fold_lines([_read_text(found, of, say)], width),
        *fold_lines(limit_sentences(found, say), width),
        *_table_lines(gauges, say, width),
        *_largest_cause_lines(gauges, say, width),
    ]
    extra = capped_item_lines(_extra_items(of, say), MAX_EXTRA_LINES, "--all", say, width)
    if extra:
        extra = [bold(say("Also evaluated")), *extra]
    below = [*_not_evaluated_lines(found, gauges, say, width), *_next_lines(found, say, width)]
    blocks = [
        (say("Data quality"), _data_items(of, parts, say)),
        (say("Before you sign"), _signature_items(found, parts, gauges, say)),
    ]
    blocks = [(head, items) for head, items in blocks if items]
    yield from above
    room = MAX_LINES - len(above) - len(extra) - len(below) - len(blocks)
    for k, (head, items) in enumerate(blocks, 1):
        others = MIN_BLOCK_LINES * (len(blocks) - k)
        count = min(max(room - others, MIN_BLOCK_LINES), MAX_BLOCK_LINES)
        lines = capped_item_lines(items, count, "--all", say, width)
        room -= len(lines)
        yield bold(head)
        yield from lines
    yield from extra
    yield from below


def _parts(
    of: RecordingAssessment | CampaignAssessment,
) -> list[tuple[str, RecordingAssessment]]:
    """Return the recordings by names that are shown; "" of a single one."""
    if isinstance(of, RecordingAssessment):
        return [("", of)]
    several = len(of.parts) > 1
    return [(name if several else "", one) for name, _, one in of.parts]


# --------------------------------------------------------------------------- what was read


def _title_lines(
    found: Found, of: RecordingAssessment | CampaignAssessment, say: Translator, width: int
) -> list[str]:
    title = of.recording.name if isinstance(of, RecordingAssessment) else of.title
    verdict = assessment_verdict(found)
    said = say("no limit given").upper() if verdict is None else verdict_word(verdict, say)
    return title_and_verdict_lines(title, said, verdict or "incomplete", width)


def _limits_are_of_profile(found: Found) -> bool:
    """Return whether a profile limits lives or damages."""
    every = (*found.checks, *found.unevaluated)
    return any(one.limit.source != LIFE_OPTION_SOURCE for one in every)


def _read_text(found: Found, of: RecordingAssessment | CampaignAssessment, say: Translator) -> str:
    """Return what was read: recordings, hours, rates, gauges, S-N curve and profile of limits."""
    several = [of] if isinstance(of, RecordingAssessment) else [one for _, _, one in of.parts]
    rates = dict.fromkeys(say.compact_number(one.recording.rate) for one in several)
    duration = sum(one.lives[0].quality.recorded_time for one in several)
    curve = several[0].plan.curve
    read = [
        say.count("{count} recording", "{count} recordings", len(several)),
        say("{hours} h at {rate} Hz", hours=_hours(duration / hour, say), rate=say.join(*rates)),
        say.count("{count} gauge", "{count} gauges", len(of.lives)),
        say(
            "S-N curve {amplitude} MPa at {cycles} cycles, slope {slope}",
            amplitude=say.compact_number(curve.amplitude / MPa),
            cycles=say.compact_number(curve.cycles),
            slope=say.compact_number(curve.slope),
        ),
    ]
    if _limits_are_of_profile(found):
        read.append(say("criteria: {profile}", profile=of.profile))
    return say("Read: {what}", what="; ".join(read))


def limit_sentences(found: Found, say: Translator) -> Iterator[str]:
    """Yield each limit, how many gauges have which grade, and the worst value."""
    checks: dict[object, list[Check]] = {}
    for c in found.checks:
        checks.setdefault((c.quantity, c.limit, c.bound), []).append(c)
    for some in checks.values():
        worst = min(some, key=worst_first_key)
        number = Counter(c.grade for c in some)
        counts = say.join(
            say.count("{count} exceeded", "{count} exceeded", number["fail"]),
            say.count(
                "{count} beyond recommended", "{count} beyond recommended", number["warn"]
            ) if number["warn"] else "",
            say.count("{count} met", "{count} met", number["pass"]),
        )  # fmt: skip
        name = uncapitalised(say.name(worst.quantity))
        value = f"{value_text(worst, say)} {unit_text(worst)}".rstrip()
        yield say(
            "Limit: {limit}: {counts}; worst {worst}",
            limit=f"{name} {limit_text(worst, say)}",
            counts=counts,
            worst=f"{say.part(worst.part)}: {value}",
        )


# --------------------------------------------------------------------------- gauges


def gauge_results(found: Found) -> list[GaugeResult]:
    """Return what decides at each gauge, the one that governs first."""
    assert found.answer is not None  # of a study that answered
    return sorted(_gauges(found.answer, found.checks), key=lambda g: g.order)


def _gauges(
    of: RecordingAssessment | CampaignAssessment, checks: Sequence[Check]
) -> Iterator[GaugeResult]:
    """Yield what decides at each gauge."""
    for one in of.lives:
        alone, part = _chief_part(of, one)
        known = one.has_signal and not one.vetoes
        place = report.cause_places(part.causes).get(one.name)
        causes = None if place is None or part.causes is None else part.causes.attributions[place]
        evidence = (
            of.evidence(one.name)
            if isinstance(of, CampaignAssessment)
            else None
            if place is None or part.causes is None
            else part.causes.joint_attributions[place]
        )
        yield GaugeResult(
            name=one.name,
            hours=one.life.hours if known else math.nan,
            rejected=bool(one.vetoes),
            interval=_interval(alone) if alone is not None and known else None,
            evidence=evidence,
            causes=causes,
            checks=tuple(c for c in checks if c.part.other == one.name),
        )


def _chief_part(
    of: RecordingAssessment | CampaignAssessment, one: GaugeAssessment | MixGaugeResult
) -> tuple[GaugeAssessment | None, RecordingAssessment]:
    """Return a gauge in its only recording, else None; and the recording of most damage there."""
    if isinstance(of, RecordingAssessment):
        assert isinstance(one, GaugeAssessment)
        return one, of
    assert isinstance(one, MixGaugeResult)
    damage = [times * gauge.life.damage for gauge, times in one.parts]
    chief = max(range(len(damage)), key=lambda k: -1.0 if math.isnan(damage[k]) else damage[k])
    return one.parts[0][0] if len(one.parts) == 1 else None, of.parts[chief][2]


def _interval(one: GaugeAssessment) -> tuple[float, float] | None:
    """Return hours after which 10 and 90 % of parts have failed; None without scatter."""
    ends = [
        one.repeats.get(share, math.nan) * one.life.duration / hour
        for share in LIFE_INTERVAL_FAILED_SHARES
    ]
    low, high = ends
    return (low, high) if low < high else None


def gauge_result_rows(gauges: Sequence[GaugeResult], say: Translator) -> list[list[str]]:
    """Return gauges as rows, heads first: life with interval, joints' share with interval, finding.

    Columns of which nothing is known at any gauge are left out.
    """
    intervals, found = any(g.interval for g in gauges), any(g.evidence for g in gauges)
    head = [say("gauge"), say("life, h")]
    head += [say("10-90 % failed")] if intervals else []
    head += [say("joints (90 % interval)"), say("cause")] if found else []
    rows = [head]
    for g in gauges:
        row = [g.name, _life_text(g, say)]
        if intervals:
            ends = [_hours(h, say) for h in g.interval or ()]
            row.append(" … ".join(ends) or "-")
        if found:
            row += _evidence_cells(g.evidence, say)
        rows.append(row)
    return rows


def _table_lines(gauges: Sequence[GaugeResult], say: Translator, width: int) -> list[str]:
    """Return a table of gauges, as many as have room."""
    intervals = any(g.interval for g in gauges)
    head, *rows = gauge_result_rows(gauges, say)
    head[0] = f"  {head[0]}"
    for g, row in zip(gauges, rows, strict=True):
        mark = UNKNOWN_MARK if math.isnan(g.hours) else GRADE_MARKS[g.grade]
        row[0] = f"{mark} {row[0]}"
    for shown in range(len(rows), 0, -1):
        first, *lines = table_lines(head, rows[:shown], width, right=(1, 2) if intervals else (1,))
        rest = len(rows) - shown
        if len(lines) < MAX_TABLE_LINES - bool(rest) or shown == 1:
            more = [f"  {more_text(rest, '--all', say)}"] if rest else []
            return [bold(first), *lines, *more]
    return []


def _life_text(g: GaugeResult, say: Translator) -> str:
    """Return a life, h; its figures show on which side of its limit it is."""
    if math.isnan(g.hours):
        return say("data rejected") if g.rejected else say("not known")
    limited = [c for c in g.checks if c.quantity == "fatigue_life"]
    return (
        value_text(limited[0], say) if limited and math.isfinite(g.hours) else _hours(g.hours, say)
    )


def _hours(value: float, say: Translator) -> str:
    """Return hours in three figures, which may have no end."""
    if math.isnan(value):
        return say("not known")
    return say.number(float(f"{value:.3g}"), 3) if math.isfinite(value) else say("no end")


def _evidence_cells(of: JointAttribution | None, say: Translator) -> list[str]:
    if of is None:
        return ["-", "-"]
    between = " … ".join(say.compact_number(round(100 * end)) for end in of.interval)
    return [f"{share_text(of.damage_share, say)} ({between})", say(of.verdict)]


def _largest_cause_lines(gauges: Sequence[GaugeResult], say: Translator, width: int) -> list[str]:
    """Return the largest cause apart from the joints where these are not found to dominate.

    As the joints' in the table it is the share of the damage that goes without it; Shapley shares
    are other numbers, and only in the full result.
    """
    items: list[str] = []
    for g in gauges:
        if g.evidence is None or g.evidence.verdict == JOINTS_DOMINANT or g.causes is None:
            continue
        whole = g.causes.total_damage
        others = [name for name in g.causes.causes if name != CAUSE_JOINTS]
        if others and whole > 0:
            chief = min(others, key=g.causes.without)
            gone = 1 - g.causes.without(chief) / whole
            items.append(f"{g.name} {say(chief)} {share_text(gone, say)}")
    return capped_list_lines(
        say("Largest damage that goes without one cause, apart from the joints:"), items,
        MAX_LIST_LINES, "--all", say, width,
    )  # fmt: skip


# --------------------------------------------------------------------------- data, open points


def _data_items(
    of: RecordingAssessment | CampaignAssessment,
    parts: Sequence[tuple[str, RecordingAssessment]],
    say: Translator,
) -> list[str]:
    """Return what limits the trust in the data, what decides first."""
    ranked: list[tuple[int, str]] = []
    if isinstance(of, CampaignAssessment):
        ranked += [(0, line) for one in of.lives for line in report.mix_caveat_lines(one, say)]
    for name, part in parts:
        for note in part.recording.notes:
            text = say("  note: {note}", note=report.recording_note_text(note, say))
            ranked.append((NOTE_RANK, say.join(name, text.strip())))
        for reading in part.alternative_readings:
            ranked += [(3, line) for line in report.bus_error_lines(reading, say)]
        for one in part.lives:
            for rank, line in _gauge_items(one, part.recording.rate, say):
                ranked.append((rank, say.join(name, line)))
    ranked = [(rank, line) for rank, line in ranked if line]
    if all(rank == NOTE_RANK for rank, _ in ranked):
        ranked.append((0, say("no suspect data found")))
    return list(dict.fromkeys(line for _, line in sorted(ranked, key=lambda one: one[0])))


def _gauge_items(one: GaugeAssessment, rate: float, say: Translator) -> Iterator[tuple[int, str]]:
    """Yield the sentences on a gauge's data with their rank; 0 is the gravest."""
    if not one.has_signal:
        yield 0, report.no_signal_line(one, say)
        return
    yield 0, report.rejection_line(one, say)
    for e in one.quality.effects:
        rank = 5 if e.change < MIN_CHANGE_NAMED_FIRST else 1 if e.undecided else 2
        yield rank, report.fault_effect_line(one.name, e, say)
    yield 1, report.shear_line(one, say)
    yield 2, report.undersampling_line(one, rate, say)
    yield from ((2, line) for line in report.declaration_doubt_lines(one, say))
    yield 3, report.valid_data_line(one, say)


def _signature_items(
    found: Found,
    parts: Sequence[tuple[str, RecordingAssessment]],
    gauges: Sequence[GaugeResult],
    say: Translator,
) -> list[str]:
    """Return sentences for a signer: what turns a verdict, why a cause is open, what is assumed."""
    items = [
        _worse_verdict_text(
            c,
            c.within,
            say("missing or frozen time like the worst recorded")
            if isinstance(found.answer, RecordingAssessment)
            else say("parts driven in turn"),
            say,
        )
        for c in found.checks
        if c.within and _may_turn(c)
    ]
    for name, part in parts:
        doubts = part.causes.doubts if part.causes is not None else ()
        # More than why a cause is open.
        items += [
            say.join(name, say.translate_message(finding_message(doubt)))
            for doubt in doubts
            if _is_of_damage(doubt)
        ]
        if part.identification is not None:
            items += doubt_sentences(part.identification, say)
        # The last one says that the promise may be of another line.
        items += list(report.identified.parameter_change_sentences(part.parameter_changes, say))[
            -1:
        ]
    for g in gauges:
        if g.evidence is not None and g.evidence.verdict == UNDETERMINED:
            reasons = "; ".join(
                map(say.translate_message, finding_messages(g.evidence.doubts[:1]))
            ) or say("the interval holds both")
            items.append(say("cause at {gauge} undetermined: {why}", gauge=g.name, why=reasons))
    seconds = sum(one.lives[0].quality.recorded_time for _, one in parts)
    if any(math.isfinite(g.hours) for g in gauges):
        items.append(
            say(
                "a life assumes that what was recorded, {hours} h in all, repeats",
                hours=_hours(seconds / hour, say),
            )
        )
    for name, part in parts:
        if part.causes is not None:
            doubts = finding_messages(sorted(part.causes.doubts, key=_share_of_time, reverse=True))
            said = [say.translate_message(doubt) for doubt in doubts]
            items += [
                say.join(name, say("doubt: {doubt}", doubt=doubt))
                for doubt in said
                if not any(doubt in item for item in items)  # as the reason of an open cause
            ]
    return list(dict.fromkeys(items))


def _is_of_damage(doubt: Finding) -> bool:
    """Return whether a doubt, of a gauge, says that the damage itself may be another."""
    of = dict(doubt.values).get("doubt", doubt)
    return isinstance(of, Finding) and of.code == DOUBT_RESPONSE_STEP.code


def _may_turn(c: Check) -> bool:
    """Return whether a check may come to a worse verdict."""
    return CHECK_GRADES.index(c.worst_possible_grade) > CHECK_GRADES.index(c.grade)


def _worse_verdict_text(c: Check, within: tuple[float, float], inputs: str, say: Translator) -> str:
    low, high = (value_text(c, say, end) for end in within)
    interval = say("{low} to {high}", low=low, high=high)
    return say(
        "{criteria}: a worse verdict is possible with {inputs}",
        criteria=f"{say.part(c.part)} {interval} {unit_text(c)}",
        inputs=inputs,
    )


def _share_of_time(doubt: Finding) -> float:
    """Return the share of the time that a doubt holds for; infinite where it holds for all."""
    share = dict(doubt.values).get("share")
    return share if isinstance(share, float) else math.inf


def open_points(found: Found, say: Translator) -> list[str]:
    """Return sentences for a signer, what decides first: data quality, causes, assumptions."""
    of = found.answer
    assert of is not None  # of a study that answered
    parts = _parts(of)
    sound = say("no suspect data found")
    data = [item for item in _data_items(of, parts, say) if item != sound]
    return [*data, *_signature_items(found, parts, gauge_results(found), say)]


# --------------------------------------------------------------------------- further results


def _extra_items(of: RecordingAssessment | CampaignAssessment, say: Translator) -> list[str]:
    """Return what was evaluated beyond damage and cause, a sentence each."""
    several = [of] if isinstance(of, RecordingAssessment) else [one for _, _, one in of.parts]
    items: list[str] = []
    for part in several:
        items += [_predicted_text(one, say) for one in part.predicted_lives]
        if part.lacks_prediction:
            items.append(report.identified.no_change_prediction_sentence(say))
    if isinstance(of, CampaignAssessment):
        items += report.customer_damage_lines(of, say)
    items += [line for one in of.alternative_lives for line in otherwise.text_lines(one, say)]
    for part in several:
        found = part.identification
        if found is None:
            continue
        other = [
            say.join(say(report.identified.PARAMETER_TITLES[p.name]), say.part(p.part))
            for p in found.parameters
            if p.identifiable and p.differs
        ]
        if other:
            items.append(say("otherwise than written: {what}", what="; ".join(other)))
    if any(part.usage for part in several):
        items.append(say("damage by gear, speed and torque (--all)"))
    return items


def _predicted_text(of: PredictedLife, say: Translator) -> str:
    return say(
        "{gauge}: {changed} h with the changed line, {recorded} h as recorded", gauge=of.gauge,
        changed=_hours(of.changed.hours, say), recorded=_hours(of.recorded.hours, say),
    )  # fmt: skip


# --------------------------------------------------------------------------- not evaluated, next


def _not_evaluated_lines(
    found: Found, gauges: Sequence[GaugeResult], say: Translator, width: int
) -> list[str]:
    """Return what was not evaluated and the input it needs."""
    items = grouped_unevaluated_lines(found.unevaluated, say)
    if not found.checks and not found.unevaluated:
        items.append(say("a limit of the life (--target-hours or --limits)"))
    profile = found.answer.profile if found.answer is not None else ""
    if profile and not _limits_are_of_profile(found):
        text = say("{profile} limits no fatigue_life and no fatigue_damage.", profile=profile)
        items.append(text.rstrip("."))
    if not any(g.interval for g in gauges) and any(math.isfinite(g.hours) for g in gauges):
        several = isinstance(found.answer, CampaignAssessment) and len(found.answer.parts) > 1
        items.append(
            say("an interval of the life of several recordings")
            if several
            else say("an interval of the life (--scatter and --gauge-error)")
        )
    if not any(g.evidence for g in gauges):
        items.append(say("the cause (--speed or --tacho, with --torque and --engine)"))
    return capped_list_lines(say("Not evaluated:"), items, MAX_LIST_LINES + 1, "--all", say, width)


def _next_lines(found: Found, say: Translator, width: int) -> Iterator[str]:
    """Yield the commands that follow."""
    of = found.answer
    options = ["--all", "--pdf OUT"]
    if isinstance(of, RecordingAssessment):
        options.insert(1, "--plot OUT")
        if any(one.vetoes for one in of.lives):
            options.insert(0, "--mask KIND | --accept KIND")
        name = "RECORDING ..."
    else:
        name = "CAMPAIGN.yaml"
    yield from fold_lines([f"{say('Next:')} cardan life {name} {' | '.join(options)}"], width)
