"""First page of a life report: verdict, life and cause of each gauge, four figures."""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from cardan.approval.study import StudyResult
from cardan.core.arrays import FloatArray
from cardan.core.verdict import worst_first_key
from cardan.physics.fatigue.damage import LifeEstimate
from cardan.physics.fatigue.rainflow import Cycles
from cardan.physics.fatigue.rainflow_matrix import RainflowTable, merge_tables
from cardan.physics.signals.assessment import GaugeAssessment
from cardan.render.blocks import Block, BulletList, Chapter, Figures, Table, Text
from cardan.render.i18n import Translator
from cardan.topics.recording.campaign_assessment import CampaignAssessment
from cardan.topics.recording.life_figures_report import (
    collective_figure,
    matrix_figure,
    recording_damage_figure,
    recording_history_figures,
)
from cardan.topics.recording.options import options_as_campaign_file_keys
from cardan.topics.recording.recording_assessment import RecordingAssessment
from cardan.topics.recording.screen_presentation import (
    GaugeResult,
    gauge_result_rows,
    gauge_results,
    limit_sentences,
    open_points,
)

MAX_GAUGES, MAX_POINTS = 4, 2
"""Gauges and open points that have room on the page; the others stand in the annex."""
HISTORY_HEIGHT_MM, DAMAGE_HEIGHT_MM = 52.0, 33.0
"""Height on paper of the figures over time, at most."""

Found = StudyResult[RecordingAssessment] | StudyResult[CampaignAssessment]


@dataclass(frozen=True, kw_only=True)
class GoverningGauge:
    """The gauge that decides, as the figures show it.

    Attributes
    ----------
    name
        Its name.
    life, cycles, matrix
        Of one passage of the recording or the mix; the matrix is from-to.
    known
        Whether its life is known.
    recording, part
        The recording of most damage there, and the gauge in it.
    part_names, part_damages
        Of a mix of several recordings: damage of each, as often as it is driven.
    """

    name: str
    life: LifeEstimate
    cycles: Cycles
    matrix: RainflowTable | None
    known: bool
    recording: RecordingAssessment
    part: GaugeAssessment
    part_names: tuple[str, ...] = ()
    part_damages: FloatArray


def governing_gauge(found: Found, gauges: Sequence[GaugeResult]) -> GoverningGauge | None:
    """Return the gauge that decides; None where none has a signal.

    It is the first of the page's table with a signal, whether its life is known or not.
    """
    of = found.answer
    assert of is not None  # of a study that answered
    by_name = {one.name: one for one in of.lives if one.has_signal}
    if not by_name:
        return None
    name = next(g.name for g in gauges if g.name in by_name)
    one = by_name[name]
    if isinstance(of, RecordingAssessment):
        assert isinstance(one, GaugeAssessment)
        tables, drives = [(one.matrices, 1.0)], [("", of, one, one.life.damage)]
    else:
        assert not isinstance(one, GaugeAssessment)
        tables = [(gauge.matrices, times) for gauge, times in one.parts]
        drives = [
            (label, heard, gauge, times * gauge.life.damage)
            for (label, times, heard), (gauge, _) in zip(of.parts, one.parts, strict=True)
        ]
    several = len(drives) > 1
    _, recording, part, _ = max(drives, key=lambda drive: np.nan_to_num(drive[3]))
    return GoverningGauge(
        name=name, life=one.life, cycles=one.cycles, known=not one.vetoes,
        matrix=merge_tables((own[0], times) for own, times in tables if own)
        if any(own for own, _ in tables) else None,
        recording=recording, part=part,
        part_names=tuple(label for label, *_ in drives) if several else (),
        part_damages=np.array([damage for *_, damage in drives] if several else []),
    )  # fmt: skip


def first_page_chapter(found: Found, say: Translator) -> Chapter:
    """Return life, cause, open points and four figures of the gauge that governs."""
    return Chapter(title=say("Life and cause"), blocks=tuple(_blocks(found, say)))


def _blocks(found: Found, say: Translator) -> Iterator[Block]:
    gauges = gauge_results(found)
    head, *rows = gauge_result_rows(gauges[:MAX_GAUGES], say)
    more = len(gauges) - MAX_GAUGES
    if more > 0:
        text = say.count("{count} more in the annex", "{count} more in the annex", more)
        rows.append([text, *[""] * (len(head) - 1)])
    limited = bool(found.checks)
    yield Table(
        caption=say("Gauges, the one that governs first"),
        head=tuple(head),
        rows=tuple(tuple(row) for row in rows),
        grades=tuple(
            (_grade(g, limited=limited), *[""] * (len(head) - 1)) for g in gauges[:MAX_GAUGES]
        )
        + ((("",) * len(head),) if more > 0 else ()),
    )
    if limits := tuple(limit_sentences(found, say)):
        yield Text(paragraphs=limits)
    points = open_points(found, say)
    if isinstance(found.answer, CampaignAssessment):
        points = [options_as_campaign_file_keys(point) for point in points]
    if points:
        shown = points[:MAX_POINTS]
        more = len(points) - len(shown)
        if more:
            shown.append(say.count("{count} more in the annex", "{count} more in the annex", more))
        yield BulletList(caption=say("Before you sign"), points=tuple((p, ()) for p in shown))
    one = governing_gauge(found, gauges)
    if one is not None:
        yield from _figures(one, found, say)


def _grade(of: GaugeResult, *, limited: bool) -> str:
    if math.isnan(of.hours):
        return "incomplete"
    return of.grade if limited else ""


def _required(found: Found, gauge: str) -> float | None:
    """Return the longest life that a limit requires of a gauge, s."""
    checks = [c for c in found.checks if c.quantity == "fatigue_life" and c.part.other == gauge]
    return min(checks, key=worst_first_key).bound if checks else None


def _figures(of: GoverningGauge, found: Found, say: Translator) -> Iterator[Block]:
    over_time = recording_history_figures(of.recording, of.part, say)
    if over_time:
        yield Figures(figures=over_time[:1], wide=True, max_height_mm=HISTORY_HEIGHT_MM)
    pair = [
        None if of.matrix is None else matrix_figure(of.matrix, say, gauge=of.name),
        collective_figure(
            of.cycles, of.life, of.recording.plan, say, gauge=of.name, known=of.known,
            required=_required(found, of.name),
        ),
    ]  # fmt: skip
    yield Figures(figures=tuple(one for one in pair if one is not None))
    damage = over_time[1:]
    if of.part_names:
        damage = (recording_damage_figure(of.part_names, of.part_damages, say, gauge=of.name),)
    if damage:
        yield Figures(figures=damage, wide=True, max_height_mm=DAMAGE_HEIGHT_MM)
