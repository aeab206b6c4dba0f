"""The report of a study of variants: what it came to, as chapters of a document."""

from cardan.render.blocks import (
    Block,
    Chapter,
    Figures,
    ReportDateAndSourceStamp,
    ReportDocument,
    Text,
)
from cardan.render.i18n import ENGLISH, Translator
from cardan.render.phrases import source_date_and_version_facts, verdict_word
from cardan.render.screen_layout import percent_text
from cardan.topics.variants.presentation import (
    remark_lines,
    result_tables,
    summary_line,
)
from cardan.topics.variants.presentation_figures import figures
from cardan.topics.variants.study_result import VariantStudyResult

# --------------------------------------------------------------------------- a report


def chapters(of: VariantStudyResult, say: Translator = ENGLISH) -> tuple[Chapter, ...]:
    """Return the chapters of a study: what it came to, and its figures."""
    first: list[Block] = [Text(paragraphs=(summary_line(of, say), *remark_lines(of, say)))]
    drawn = tuple(figures(of, say))
    return (
        Chapter(title=say("What the variants come to"), blocks=(*first, *result_tables(of, say))),
        *(
            (Chapter(title=say("How they scatter"), blocks=(Figures(figures=drawn),)),)
            * bool(drawn)
        ),
    )


def report(
    of: VariantStudyResult, *, say: Translator, issue: ReportDateAndSourceStamp
) -> ReportDocument:
    """Return a report of a study."""
    say = say.with_minus_sign
    low, high = of.interval()
    fit = percent_text(of.yield_, say)
    return ReportDocument(
        language=say.code,
        title=of.installed.application.title,
        subtitle=say("Study of {count} variants", count=of.count),
        grade=of.installed.verdict,
        verdict=say("yield {share}", share=fit),
        facts=(
            (say("As it is"), verdict_word(of.installed.verdict, say)),
            (
                say("May be built"),
                f"{fit} ({percent_text(low, say, 2)} … {percent_text(high, say, 2)})",
            ),
            (say("Limits"), of.installed.application.profile),
            *source_date_and_version_facts(issue, say),
        ),
        chapters=chapters(of, say),
        summary=summary_line(of, say),
        date=issue.date,
    )
