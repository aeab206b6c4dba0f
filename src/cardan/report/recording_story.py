"""The story that a report tells of a recording, or of a campaign of some."""

from collections.abc import Iterator, Sequence
from typing import Any

from cardan.base.verdict import Check
from cardan.quantity.quantities import QUANTITIES
from cardan.report.blocks import Block, Chapter, Issue, Points, Story, Table, Text
from cardan.report.language import Language
from cardan.report.recording_chapter import chapter
from cardan.report.recording_chapter import chapters as recorded
from cardan.report.story import signs
from cardan.report.wording import gaps, held, sense, worst_of_each
from cardan.study.approval import coverage_of
from cardan.study.finding import Finding
from cardan.study.recording import Heard, Mix, verdict_on


def recording(of: Finding[Heard], *, say: Language, issue: Issue) -> Story:
    """Return the story of a recording: the verdict, its gauges, who did the damage."""
    say, heard = say.typeset, of.answer
    assert heard is not None  # of a recording that could be asked
    chapters = [
        Chapter(title=say("Verdict"), blocks=tuple(_judged(of, say))),
        Chapter(title=heard.recording.name, blocks=tuple(chapter(heard, say))),
    ]
    return _recorded(of, heard.recording.name, heard.profile, chapters, say=say, issue=issue)


def campaign(of: Finding[Mix], *, say: Language, issue: Issue) -> Story:
    """Return the story of a campaign: the verdict, the mix, then each recording."""
    say, found = say.typeset, of.answer
    assert found is not None  # of a campaign that could be asked
    chapters = [
        Chapter(title=say("Verdict"), blocks=tuple(_judged(of, say))),
        *recorded(found, say),
    ]
    return _recorded(of, found.title, found.profile, chapters, say=say, issue=issue)


def _recorded(
    of: Finding[Any], title: str, profile: str, chapters: Sequence[Chapter], *, say: Language,
    issue: Issue,
) -> Story:  # fmt: skip
    """Return the story of recordings that chapters tell."""
    verdict = verdict_on(of)
    coverage = coverage_of(of)
    counted = say("{answered} of {asked} answered", answered=coverage.answered,
                  asked=coverage.asked)  # fmt: skip
    return Story(
        language=say.code,
        title=title,
        subtitle=say("Recording: damage, life and cause"),
        # Nothing asked is nothing approved.
        grade=verdict or "incomplete",
        verdict=say(verdict).upper() if verdict else say("Nothing was asked"),
        facts=(*(((say("Limits"), profile),) if profile else ()), *signs(issue, say)),
        chapters=tuple(chapters),
        summary=counted if coverage.asked else "",
        date=issue.date,
    )


def _judged(of: Finding[Any], say: Language) -> Iterator[Block]:
    """Yield each limit of a recording where it is worst, and what got no answer."""
    rows = worst_of_each(of.checks)
    if rows:
        yield Table(
            caption=say("Worst check of each limit"),
            head=(say("verdict"), say("limit"), say("where it is worst"), say("value"),
                  say("bound"), say("unit"), say("margin")),
            rows=tuple(_judgement(c, say) for c in rows),
            words=3,
            grades=tuple((c.grade, *[""] * 6) for c in rows),
        )  # fmt: skip
    missing = gaps(of.unanswered, say)
    if missing:
        yield Points(caption=say("Without an answer"), points=tuple((m, ()) for m in missing))
    if not rows and not missing:
        yield Text(
            paragraphs=(
                say(
                    "Nothing was asked: --target-hours or --limits hold the gauges' lives against "
                    "a limit."
                ),
            )
        )


def _judgement(c: Check, say: Language) -> tuple[str, ...]:
    """Return a check on a gauge as a row."""
    q, (value, bound) = QUANTITIES[c.quantity], held(c, say)
    return (
        say(c.grade), say.name(q.key), say.list(say.part(c.part), say.occasion(c.when)),
        value, f"{sense(c, say)} {bound}", q.unit_name, say.percent(c.margin),
    )  # fmt: skip
