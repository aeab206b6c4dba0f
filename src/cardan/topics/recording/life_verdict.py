"""Limits of life and damage against gauges, of a recording or of a mix, and the verdict."""

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Protocol

from cardan.approval.coverage import coverage_of, verdict_of
from cardan.approval.study import StudyResult
from cardan.core.labels import EvaluationCondition, Part
from cardan.core.units import hour
from cardan.core.verdict import Check, Limit, UnevaluatedCheck, Verdict
from cardan.physics.fatigue.damage import LifeEstimate
from cardan.topics.recording.campaign_assessment import CampaignAssessment
from cardan.topics.recording.options import LIFE_OPTION_SOURCE
from cardan.topics.recording.recording_assessment import RecordingAssessment

NEED_TEXT_VARYING_SIGNAL = "a recording in which all its channels move"
"""What a gauge needs that said nothing: no samples, or one value throughout."""

NEED_TEXTS_BY_UNDECIDED_FAULT: Mapping[str, str] = {
    "sentinel": "a word on its sentinels, which decide the damage: --mask or --accept sentinel",
    "spike": "a word on its spikes, which decide the damage: --mask or --accept spike",
    "dropout": "a word on its dropouts, which decide the damage: --mask or --accept dropout",
    "clip": "a recording that is not clipped, or --accept clip",
    "zero-step": "a word on the steps of its zero, which decide the damage: --mask or --accept "
    "zero-step",
    "gain": "a word on its gain, whose changes decide the damage: --mask or --accept gain",
    "response": "a word on where it stops responding, which may hide damage: --mask or --accept "
    "response",
    "noise": "a word on its noise, which decides the damage: --mask or --accept noise",
    "repeat": "a word on what was stored twice, which decides the damage: --mask or --accept "
    "repeat",
    "freeze": "a word on its frozen stretches, which may hide damage: --mask or --accept freeze",
    "drift": "a word on its drift, which decides the damage: --zero drift or --accept drift",
    "hole": "a recording in which it is alive for a quarter of the time",
    "hum": "a word on its hum, which decides the damage: --mask or --accept hum",
    "unit": "the unit its numbers are in, or --accept unit",
    "rate": "a recording sampled as its stress moves, or --accept rate",
    "bit": "a recording whose converter moves all its bits, or --accept bit",
    "strength": "the tensile strength of its part, or --accept strength",
}
"""What a gauge needs whose data are rejected, by the kind of fault that spoils them."""


def _needed_fault_decision(kind: str) -> str:
    other = f"a word on its {kind} faults, which decide the damage: --mask or --accept {kind}"
    return NEED_TEXTS_BY_UNDECIDED_FAULT.get(kind, other)


def assessment_verdict(
    found: StudyResult[RecordingAssessment] | StudyResult[CampaignAssessment],
) -> Verdict | None:
    """Return what the gauges come to; None where nothing was requested of them.

    If the data of a life are rejected, or no gauge has a result, the recording is not evaluated,
    limit or not.
    """
    coverage = coverage_of(found)
    if not coverage.total:
        lives = found.answer.lives if found.answer is not None else ()
        spoiled = any(one.vetoes for one in lives) or not any(one.has_signal for one in lives)
        return "incomplete" if spoiled else None
    return verdict_of(found.checks, missed=bool(coverage.missing_required))


LIMIT_REQUIRING_ANY_KNOWN_LIFE = Limit(
    quantity="fatigue_life", sense=">=", maximum=0.0, required=True, source=LIFE_OPTION_SOURCE
)
"""That anything be known of a life: the check of a recording without limits."""


def unevaluated_checks_of_unknown_lives(
    found: StudyResult[CampaignAssessment],
) -> Iterator[UnevaluatedCheck]:
    """Yield the gauges of a campaign whose life is not known, if no limit applies to it."""
    of = found.answer
    if of is not None and of.options is not None and not coverage_of(found).total:
        when = EvaluationCondition("recording", of.title)
        yield from unevaluated_limits(
            of.lives, (LIMIT_REQUIRING_ANY_KNOWN_LIFE,), when=when, line=of.options.line
        )


class AssessedGauge(Protocol):
    """What limits apply to: a gauge in a recording, or in a mix of some."""

    @property
    def name(self) -> str:
        """Of the gauge."""
        ...

    @property
    def life(self) -> LifeEstimate:
        """Damage and what follows from it."""
        ...

    @property
    def has_signal(self) -> bool:
        """Whether it said anything."""
        ...

    @property
    def vetoes(self) -> tuple[str, ...]:
        """Kinds of fault that spoil what it said."""
        ...


_VALUES: dict[str, Callable[[LifeEstimate], float]] = {
    "fatigue_life": lambda life: life.hours * hour,
    "fatigue_damage": lambda life: life.damage,
}
"""The value of a gauge that a limit applies to, SI."""

NO_LIFE_ESTIMATES: Mapping[str, LifeEstimate] = {}


def limit_checks(
    lives: Sequence[AssessedGauge], limits: Sequence[Limit], *, when: EvaluationCondition,
    line: str,
    ends: Mapping[str, LifeEstimate] = NO_LIFE_ESTIMATES,
) -> Iterator[Check]:  # fmt: skip
    """Yield a check for each limit and gauge that said something.

    `ends` are lives of gauges that may be as well, by what was not recorded.
    """
    for limit in limits:
        asked = _VALUES[limit.quantity]
        for one in lives:
            if _known(one, limit):
                value, within = asked(one.life), None
                if one.name in ends:
                    low, high = sorted((value, asked(ends[one.name])))
                    within = (low, high)
                yield Check(
                    quantity=limit.quantity,
                    line=line,
                    when=when,
                    part=_part(one),
                    value=value,
                    limit=limit,
                    within=within,
                )


def unevaluated_limits(
    lives: Sequence[AssessedGauge],
    limits: Sequence[Limit],
    *,
    when: EvaluationCondition,
    line: str,
    needs: tuple[str, ...] = (),
) -> Iterator[UnevaluatedCheck]:
    """Yield each limit and gauge that got no number, or one that cannot be trusted.

    A broken wire lives for ever. Where `needs` are said no number of them can be.
    """
    for limit in limits:
        for one in lives:
            if needs or not _known(one, limit):
                lacks = (
                    needs
                    or tuple(_needed_fault_decision(k) for k in one.vetoes)
                    or (NEED_TEXT_VARYING_SIGNAL,)
                )
                yield UnevaluatedCheck(
                    limit=limit, line=line, when=when, part=_part(one), missing_inputs=lacks
                )


def _known(one: AssessedGauge, limit: Limit) -> bool:
    told = one.has_signal and not one.vetoes
    return told and not math.isnan(_VALUES[limit.quantity](one.life))


def _part(one: AssessedGauge) -> Part:
    return Part("gauge", 0, one.name)
