"""The story of a report on a recording, or on a campaign of some."""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import Any

from cardan.application.quantity_lookup import declared_quantity
from cardan.approval.coverage import coverage_of
from cardan.approval.study import StudyResult
from cardan.core.verdict import Check
from cardan.render.blocks import (
    Block,
    BulletList,
    Chapter,
    ReportDateAndSourceStamp,
    ReportDocument,
    Table,
    Text,
)
from cardan.render.i18n import Translator
from cardan.render.phrases import (
    grade_text,
    grouped_unevaluated_lines,
    limit_sense_symbol,
    source_date_and_version_facts,
    value_and_bound,
    verdict_word,
    worst_check_per_limit,
)
from cardan.topics.recording.campaign_assessment import CampaignAssessment
from cardan.topics.recording.chapter import campaign_chapters as recorded
from cardan.topics.recording.chapter import recording_blocks
from cardan.topics.recording.first_page_report import first_page_chapter, governing_gauge
from cardan.topics.recording.life_verdict import assessment_verdict
from cardan.topics.recording.recording_assessment import RecordingAssessment
from cardan.topics.recording.screen_presentation import gauge_results

MAX_NAMED_FILES = 2
"""Files that the first page names; if there are more, the annex has them."""


def recording_report(
    of: StudyResult[RecordingAssessment], *, say: Translator, issue: ReportDateAndSourceStamp
) -> ReportDocument:
    """Return the story of a recording: the verdict, its gauges, the causes of damage."""
    say, heard = say.with_minus_sign, of.answer
    assert heard is not None  # of a recording that could be assessed
    governing = governing_gauge(of, gauge_results(of))
    shown = governing.name if governing is not None else ""
    chapters = [
        first_page_chapter(of, say),
        Chapter(title=say("Verdict"), blocks=tuple(_judged(of, say))),
        Chapter(
            title=heard.recording.name, blocks=tuple(recording_blocks(heard, say, shown=shown))
        ),
    ]
    return _recorded(of, heard.recording.name, heard.profile, chapters, say=say, issue=issue)


def campaign_report(
    of: StudyResult[CampaignAssessment], *, say: Translator, issue: ReportDateAndSourceStamp
) -> ReportDocument:
    """Return the story of a campaign: the verdict, the mix, then each recording."""
    say, found = say.with_minus_sign, of.answer
    assert found is not None  # of a campaign that could be assessed
    chapters = [
        first_page_chapter(of, say),
        Chapter(title=say("Verdict"), blocks=tuple(_judged(of, say))),
        *recorded(found, say),
    ]
    return _recorded(of, found.title, found.profile, chapters, say=say, issue=issue)


def _recorded(
    of: StudyResult[Any], title: str, profile: str, chapters: Sequence[Chapter], *, say: Translator,
    issue: ReportDateAndSourceStamp,
) -> ReportDocument:  # fmt: skip
    """Return the story of recordings that the chapters make up."""
    verdict = assessment_verdict(of)
    coverage = coverage_of(of)
    more = ""
    files = tuple(zip(issue.file_names, issue.fingerprints, strict=True))
    if len(files) > MAX_NAMED_FILES:
        chapters = [*chapters, _files_chapter(files, say)]
        issue = replace(issue, file_names=issue.file_names[:1], fingerprints=issue.fingerprints[:1])
        count = len(files) - 1
        more = say.count("{count} more in the annex", "{count} more in the annex", count)
    counted = say("{answered} of {asked} checks evaluated", answered=coverage.evaluated,
                  asked=coverage.total)  # fmt: skip
    return ReportDocument(
        language=say.code,
        title=title,
        subtitle=say("Recording: damage, life and cause"),
        # Nothing evaluated is nothing approved.
        grade=verdict or "incomplete",
        verdict=verdict_word(verdict, say) if verdict else say("no limit given").upper(),
        facts=(
            *(((say("Limits"), profile),) if profile else ()),
            *_stamp_facts(issue, more, say),
        ),
        chapters=tuple(chapters),
        summary=counted if coverage.total else "",
        is_sheet=True,
        date=issue.date,
    )


def _stamp_facts(
    issue: ReportDateAndSourceStamp, more: str, say: Translator
) -> Iterator[tuple[str, str]]:
    """Yield the facts of a stamp; `more`, if any, stands behind the first file."""
    for k, (name, value) in enumerate(source_date_and_version_facts(issue, say)):
        yield name, f"{value}; {more}" if more and not k else value


def _files_chapter(files: Sequence[tuple[str, str]], say: Translator) -> Chapter:
    """Return the files that a report is of, and what they held."""
    table = Table(
        caption=say("Files of this report"), head=(say("File"), "SHA-256"), rows=tuple(files),
        words=2,
    )  # fmt: skip
    return Chapter(title=say("Files"), blocks=(table,))


def _judged(of: StudyResult[Any], say: Translator) -> Iterator[Block]:
    """Yield each limit of a recording where it is worst, and what is not evaluated."""
    rows = worst_check_per_limit(of.checks)
    if rows:
        yield Table(
            caption=say("Worst check of each limit"),
            head=(say("verdict"), say("limit"), say("where it is worst"), say("value"),
                  say("bound"), say("unit"), say("margin")),
            rows=tuple(_judgement(c, say) for c in rows),
            words=3,
            grades=tuple((c.grade, *[""] * 6) for c in rows),
        )  # fmt: skip
    missing = grouped_unevaluated_lines(of.unevaluated, say)
    if missing:
        yield BulletList(caption=say("Not evaluated"), points=tuple((m, ()) for m in missing))
    if not rows and not missing:
        yield Text(
            paragraphs=(
                say(
                    "No limit given: --target-hours or --limits compare the gauges' lives with a "
                    "limit."
                ),
            )
        )


def _judgement(c: Check, say: Translator) -> tuple[str, ...]:
    """Return a check on a gauge as a row."""
    q, (value, bound) = declared_quantity(c.quantity), value_and_bound(c, say)
    return (
        grade_text(c.grade, say), say.name(q.key), say.join(say.part(c.part), say.occasion(c.when)),
        value, f"{limit_sense_symbol(c, say)} {bound}", q.unit_symbol, say.margin_percent(c.margin),
    )  # fmt: skip
