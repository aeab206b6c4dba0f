"""The story of a report, before any medium shapes it: chapters of tables and figures.

The page, the printed document and any later medium contain the same story, in the
same order and the same words, because this is all they are made from.
"""

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence

import numpy as np

from cardan.approval.approval import Approval
from cardan.approval.registry import study_registrations
from cardan.approval.study import DRIVELINE_STUDY_NAME, load_function
from cardan.checks.line_response import LineResponse
from cardan.checks.quantities.registry import QUANTITIES
from cardan.core.labels import Part
from cardan.core.verdict import Check, CheckGrade, Verdict, worst_first_key, worst_verdict
from cardan.documents.approval_sheet import (
    approval_sheet,
    comparison_sheet,
    identification_facts,
    revision_table,
)
from cardan.documents.comparison import ComparisonRow, Variant, input_differences, limit_differences
from cardan.documents.criteria import CriterionKey, limit_qualifiers
from cardan.documents.first_screen import criteria_count_text, points_before_signing
from cardan.documents.inputs_table import input_rows
from cardan.documents.line_drawing import (
    has_known_geometry,
    line_drawings,
)
from cardan.documents.line_plots import all_line_plots
from cardan.render.blocks import (
    Block,
    BulletList,
    Chapter,
    CodeBlock,
    Figures,
    ReportDateAndSourceStamp,
    ReportDocument,
    Table,
    Text,
    all_figures,
)
from cardan.render.i18n import Translator
from cardan.render.phrases import (
    adjustment_phrase,
    check_location,
    check_sentence,
    citation,
    failure_sentences,
    file_warning_lines,
    grade_text,
    grouped_unevaluated_lines,
    limit_sense_symbol,
    note_sentences,
    placeholder_sentence,
    source_date_and_version_facts,
    unevaluated_limit_lines,
    value_and_bound,
    verdict_text,
    worst_check_per_limit,
)
from cardan.render.provenance_table import report_blocks as data_used
from cardan.render.state_table import (
    StateTableRow,
    driveline_title,
    part_whose_row_is_shown,
    state_table_sections,
)
from cardan.topics.design import phasing_table as phased
from cardan.topics.design.corrections import Correction, find_corrections
from cardan.topics.design.phrases import (
    checks_without_adjustment,
    correction_improvement_sentence,
    correction_standing_sentence,
    failed_check_sentence,
    helpful_adjustment_phrases,
    no_correction_sentence,
    production_tolerance_sentence,
    remaining_problem_sentences,
    tolerance_yield_sentences,
    unchangeable_sentence,
)
from cardan.topics.design.presentation import part_replacement_advice
from cardan.topics.design.sensitivity import CheckSensitivity, check_sensitivities
from cardan.topics.design.sizing import next_part_sizes

__all__ = [
    "ReportDateAndSourceStamp",
    "ReportDocument",
    "all_figures",
    "approval_report",
    "approval_report_from_results",
    "comparison_report",
    "verdict_report_blocks",
]


def approval_report(
    of: Approval,
    *,
    say: Translator,
    issue: ReportDateAndSourceStamp,
    state: str | None = None,
    corrections: bool = True,
    short: bool = False,
    tell: Callable[[int, int], None] | None = None,
) -> ReportDocument:
    """Return the story of one application, with what would help and the best corrections.

    The line is drawn in a `state`; by default in the one that decides. Corrections of a line
    of three shafts take half a minute to find, of four minutes: without them the story says that
    none were looked for. `short` leaves out what decides nothing: numbers of every state, inputs,
    equations.
    """
    helps = check_sensitivities(of)
    fixes = None if helps and not corrections else ()
    if helps and corrections:
        fixes = find_corrections(of.application, count=3, tell=tell)
    return approval_report_from_results(
        of, helps=helps, fixes=fixes, say=say, issue=issue, state=state, short=short
    )


def approval_report_from_results(
    of: Approval,
    *,
    helps: Sequence[CheckSensitivity],
    fixes: Sequence[Correction] | None,
    say: Translator,
    issue: ReportDateAndSourceStamp,
    more: Sequence[Chapter] = (),
    state: str | None = None,
    short: bool = False,
) -> ReportDocument:
    """Return the story of one application: first the sheet to sign, then what it rests on.

    The line is drawn in a `state`, by default the one that decides. A chapter for each study
    that was run; `more` follow them, and what was given stands at the end.
    """
    say, several = say.with_minus_sign, len(of.line_responses) > 1
    chapters = [
        approval_sheet(of, helps=helps, fixes=fixes, say=say, state=state),
        Chapter(title=say("Limits"), blocks=tuple(verdict_report_blocks(of, say, short=short))),
        Chapter(title=say("What to change"), blocks=tuple(_change_blocks(of, helps, fixes, say))),
    ]
    if of.application.placeholders and not short:
        why = Text(paragraphs=(placeholder_sentence(of, say),))
        chapters.append(Chapter(title=say("Results by state"), blocks=(why,)))
    for response in () if short or of.application.placeholders else of.line_responses:
        chapters += _line_chapters(response, of.checks, say, several=several)
    chapters += [
        *_study_chapters(of, say, short=short),
        *more,
        Chapter(title=say("Revisions"), blocks=(revision_table(of.application, say, issue),)),
    ]
    if not short:
        chapters += [
            Chapter(
                title=say("Inputs"), blocks=(*_input_blocks(of, say), *_file_blocks(say, issue))
            ),
            Chapter(title=say("Equations and sources"), blocks=tuple(_equation_blocks(of, say))),
        ]
    return ReportDocument(
        language=say.code,
        is_sheet=True,
        title=of.application.title,
        subtitle=say("Driveline approval report"),
        grade=of.verdict,
        verdict=verdict_text(of, say),
        facts=(
            *identification_facts(of.application, say),
            (say("Coverage"), _coverage_text(of, say)),
            (say("Limits"), of.application.profile),
            (say("States"), say.join(*(say.state(s.name) for s in of.application.states))),
            *source_date_and_version_facts(issue, say),
        ),
        chapters=tuple(chapters),
        summary=criteria_count_text(of, say),
        date=issue.date,
    )


def comparison_report(
    of: Sequence[Variant], *, say: Translator, issue: ReportDateAndSourceStamp
) -> ReportDocument:
    """Return the story of variants side by side."""
    say = say.with_minus_sign
    names = tuple(f"{k}. {v.name}" for k, v in enumerate(of, 1))
    verdicts = Table(
        caption=say("Verdicts"),
        head=(say("variant"), say("verdict"), say("criteria"), say("limits")),
        rows=tuple(
            (
                n,
                verdict_text(v.approval, say),
                criteria_count_text(v.approval, say),
                v.approval.application.profile,
            )
            for n, v in zip(names, of, strict=True)
        ),
        words=4,
        grades=tuple(("", v.approval.verdict, "", "") for v in of),
    )
    what = input_differences(of, say)
    chapters = [
        comparison_sheet(of, names, say),
        Chapter(title=say("Verdict"), blocks=(verdicts,)),
        Chapter(
            title=say("What differs in the input"),
            blocks=(
                (_comparison_table(say("Inputs that differ"), names, what),)
                if what
                else (Text(paragraphs=(say("nothing"),)),)
            ),
        ),
        Chapter(
            title=say("What it does to each limit, where it is worst"),
            blocks=(_comparison_table(say("Value and margin"), names, limit_differences(of, say)),),
        ),
    ]
    for name, v in zip(names, of, strict=True):
        several = len(v.approval.line_responses) > 1
        for r in v.approval.line_responses:
            title = f"{name}: {r.line.name}" if several else name
            chapters.append(
                Chapter(
                    title=title,
                    blocks=(
                        *_state_tables(r, v.approval.checks, say),
                        Figures(
                            figures=line_drawings(r, say)[: 2 if has_known_geometry(r) else 1],
                            wide=True,
                        ),
                    ),
                )
            )
    last = of[-1].approval.application
    revisions = (revision_table(last, say, issue), *_file_blocks(say, issue))
    chapters.append(Chapter(title=say("Revisions"), blocks=revisions))
    grades: list[Verdict] = [v.approval.verdict for v in of]
    said = (verdict_text(v.approval, say) for v in of)
    return ReportDocument(
        language=say.code,
        is_sheet=True,
        title=say("Variants side by side"),
        subtitle=say.join(*(v.approval.application.title for v in of)),
        grade=worst_verdict(grades),
        verdict="; ".join(f"{n} {text}" for n, text in zip(names, said, strict=True)),
        facts=(*identification_facts(last, say), *source_date_and_version_facts(issue, say)),
        chapters=tuple(chapters),
        date=issue.date,
    )


MAX_NEAREST_ROWS = 3
"""Limits that pass, in a short report: the nearest few."""


def _coverage_text(of: Approval, say: Translator) -> str:
    """Return how many of the checks are evaluated."""
    return say(
        "{answered} of {asked} checks evaluated", answered=of.coverage.evaluated,
        asked=of.coverage.total,
    )  # fmt: skip


def verdict_report_blocks(of: Approval, say: Translator, *, short: bool = False) -> Iterator[Block]:
    """Yield the worst check of each limit and where the limits come from.

    `short` leaves out the limits that pass, but the nearest few.
    """
    every = worst_check_per_limit(of.checks)
    bad = sum(c.grade != "pass" for c in every)
    rows = every[: bad + MAX_NEAREST_ROWS] if short else every
    several = len(of.line_responses) > 1
    sources = list(dict.fromkeys(citation(c.limit.source, say) for c in rows))
    qualifiers = limit_qualifiers([*of.checks, *of.coverage.unevaluated], of.application)
    yield _check_table(rows, say, qualifiers, several=several, sources=sources)
    if len(rows) < len(every):
        yield Text(paragraphs=(say("{count} more limits pass.", count=len(every) - len(rows)),))
    yield BulletList(
        caption=say("Where the limits come from"),
        points=tuple((f"[{k}] {source}", ()) for k, source in enumerate(sources, 1)),
    )
    if found := unevaluated_limit_lines(of, say):
        yield BulletList(
            caption=say(
                "Not evaluated ({answered} of {asked} checks evaluated)",
                answered=of.coverage.evaluated,
                asked=of.coverage.total,
            ),
            points=tuple((line, ()) for line in found),
        )
    if odd := file_warning_lines(of, say):
        yield BulletList(
            caption=say("What looks wrong in the file"), points=tuple((one, ()) for one in odd)
        )
    points = points_before_signing(of, say)
    if points:
        yield BulletList(caption=say("Open points"), points=tuple((one, ()) for one in points))
    # A note that is an open point stands there.
    if found := [n for n in note_sentences(of, say) if not any(one in n for one in points)]:
        yield Text(paragraphs=tuple(found))


def _check_table(
    rows: Sequence[Check],
    say: Translator,
    qualifiers: Mapping[CriterionKey, str],
    *,
    several: bool,
    sources: Sequence[str],
) -> Table:
    """Return checks as a table, with the numbers of their sources at the end.

    `qualifiers` distinguish limits of one quantity.
    """

    def name(c: Check) -> str:
        said, qualifier = say.name(c.quantity), qualifiers.get((c.quantity, c.line, c.limit))
        return f"{said} ({say(qualifier)})" if qualifier else said

    def row(c: Check) -> tuple[str, ...]:
        q, (value, bound) = QUANTITIES[c.quantity], value_and_bound(c, say)
        return (
            grade_text(c.grade, say),
            name(c),
            check_location(c, say, several=several),
            value,
            f"{limit_sense_symbol(c, say)} {bound}",
            q.unit_symbol,
            say.margin_text(c.margin),
            f"[{sources.index(citation(c.limit.source, say)) + 1}]",
        )

    head = (
        say("verdict"),
        say("limit"),
        say("where it is worst"),
        say("value"),
        say("bound"),
        say("unit"),
        say("margin"),
        say("source"),
    )
    return Table(
        caption=say("Every limit, where it is worst"),
        head=head,
        rows=tuple(row(c) for c in rows),
        words=3,
        grades=tuple((c.grade, *[""] * (len(head) - 1)) for c in rows),
    )


def _change_blocks(
    of: Approval,
    helps: Sequence[CheckSensitivity],
    fixes: Sequence[Correction] | None,
    say: Translator,
) -> Iterator[Block]:
    """Yield corrections, what each move would do, and what no move of a line answers."""
    several = len(of.line_responses) > 1
    sizes = next_part_sizes(of.application, checks_without_adjustment(helps))
    if of.verdict == "pass":
        yield Text(
            paragraphs=(
                say("What has an answer passes; nothing needs to change.")
                if of.coverage.unevaluated
                else say("Everything passes; nothing needs to change."),
            )
        )
    elif not of.checks:
        yield Text(paragraphs=(say("Nothing was held against a limit, so nothing is approved."),))
    if fixes is None:
        nobody = say("Corrections over all states were not looked for: cardan fix does.")
        yield Text(paragraphs=(nobody,))
    elif fixes:
        yield BulletList(
            caption=say("Corrections over all states at once, best first"),
            points=tuple(_correction_item(k, p, say) for k, p in enumerate(fixes, 1)),
        )
        about = (
            unchangeable_sentence(fixes[0], say),
            production_tolerance_sentence(fixes[0].tolerance_model, say),
        )
        if said := tuple(filter(None, about)):
            yield Text(paragraphs=said)
    elif helps:
        yield Text(paragraphs=(no_correction_sentence(say),))
    if helps:
        yield BulletList(
            caption=say("Single corrections"),
            points=tuple(
                (
                    failed_check_sentence(one, say, several=several),
                    phrases
                    or (
                        part_replacement_advice(
                            one.check, sizes.get((one.check.line, one.check.quantity)), say
                        ),
                    ),
                )
                for one, phrases in _sensitivities_to_list(helps, say)
            ),
        )
    yield from _other_study_blocks(of.checks, say, several=several)
    if of.coverage.missing_required:
        yield BulletList(
            caption=say("What no move answers"),
            points=tuple(
                (gap, ())
                for gap in grouped_unevaluated_lines(
                    of.coverage.missing_required, say, several=several
                )
            ),
        )


def _sensitivities_to_list(
    helps: Sequence[CheckSensitivity], say: Translator
) -> Iterator[tuple[CheckSensitivity, tuple[str, ...]]]:
    """Yield what helps each check; where nothing helps several parts, the worst of them alone."""
    without: set[tuple[str, str]] = set()
    for one in helps:
        phrases, of = (
            tuple(helpful_adjustment_phrases(one, say)), (one.check.line, one.check.quantity)
        )  # fmt: skip
        if phrases or of not in without:
            yield one, phrases
        if not phrases:
            without.add(of)


def _other_study_blocks(
    checks: Sequence[Check], say: Translator, *, several: bool
) -> Iterator[Block]:
    """Yield what other studies found: moves are tried on what the driveline answers."""
    beyond = [
        c for c in checks
        if c.grade != "pass" and QUANTITIES[c.quantity].study not in ("", DRIVELINE_STUDY_NAME)
    ]  # fmt: skip
    if beyond:
        yield BulletList(
            caption=say("What other studies found: no move was tried against it"),
            points=tuple(
                (_failed_check_title(c, say, several=several), ())
                for c in worst_check_per_limit(beyond)
            ),
        )


def _failed_check_title(c: Check, say: Translator, *, several: bool) -> str:
    """Return a check that does not pass: how bad it is, of which study and line, and how much."""
    study = say(QUANTITIES[c.quantity].study)
    of = say.join(study, c.line) if several else study
    return say(
        "{grade} ({study}): {check}",
        grade=grade_text(c.grade, say),
        study=of,
        check=check_sentence(c, say),
    )


def _correction_item(k: int, p: Correction, say: Translator) -> tuple[str, tuple[str, ...]]:
    """Return one correction: its verdict, what it moves, what still does not pass."""
    cost = say.compact_number(round(p.cost, 2))
    to = say(
        "{standing}, cost {cost}",
        standing=correction_standing_sentence(p, p.approval, say),
        cost=cost,
    )
    moves = tuple(adjustment_phrase(m, say) for m in p.adjustments)
    return f"{k}. {to} ({p.line})", (
        *moves,
        correction_improvement_sentence(p, say),
        *tolerance_yield_sentences(p.tolerance_yield, p.tolerance_model, say),
        *remaining_problem_sentences(p, say),
    )


def _input_blocks(of: Approval, say: Translator) -> Iterator[Block]:
    """Yield what was given, group by group."""
    every = input_rows(of.application, say)
    for group in dict.fromkeys(i.group for i in every):
        yield Table(
            caption=group,
            head=(say("input"), say("value")),
            rows=tuple((i.name, i.value) for i in every if i.group == group),
            words=2,
        )
    yield from data_used(of, say)


def _line_chapters(
    r: LineResponse, checks: tuple[Check, ...], say: Translator, *, several: bool
) -> Iterator[Chapter]:
    """Yield results, drawings and plots of one line."""
    end = f": {r.line.name}" if several else ""
    *views, phases, planes, sums = line_drawings(r, say)
    yield Chapter(
        title=say("Results by state") + end,
        blocks=(
            Text(paragraphs=(driveline_title(r, say) + ".",)),
            *_state_tables(r, checks, say),
        ),
    )
    yield Chapter(
        title=say("Drawings") + end,
        blocks=(
            Figures(figures=(*views, phases), wide=True),
            *phased.yoke_phasing_table(r, say),
            Figures(figures=(planes, sums)),
        ),
    )
    yield Chapter(title=say("Plots") + end, blocks=(Figures(figures=all_line_plots(r, say)),))


def _state_tables(r: LineResponse, checks: tuple[Check, ...], say: Translator) -> Iterator[Table]:
    """Yield the numbers of a line, rows over states."""
    states = tuple(say.state(s) for s in r.demand.states)
    graded = _worst_grades(c for c in checks if c.line == r.line.name)
    for section in state_table_sections(r):
        rows = list(_rows_that_state_something(section.rows, say))
        yield Table(
            caption=say(section.title),
            head=(say("quantity"), say("unit"), *states),
            rows=tuple((name, row.unit, *row.value_texts(say)) for name, row in rows),
            words=2,
            grades=tuple(("", "", *_row_grades(row, graded, r)) for _, row in rows),
        )


def _rows_that_state_something(
    rows: Iterable[StateTableRow], say: Translator
) -> Iterator[tuple[str, StateTableRow]]:
    """Yield rows with their labels; an approximation of an unknown value is named in full."""
    head = ""
    for row in rows:
        label = row.label(say)
        if row.method:
            yield (f"{head} {label.strip()}" if head else label.replace("  ", "\u2003")), row
            head = ""
        elif np.isnan(row.values).all():
            head = label
        else:
            yield label, row
            head = ""


def _worst_grades(checks: Iterable[Check]) -> dict[tuple[str, Part, str], CheckGrade]:
    """Return the worst grade of each quantity, part and state that does not pass."""
    found: dict[tuple[str, Part, str], CheckGrade] = {}
    for c in sorted(checks, key=worst_first_key, reverse=True):
        if c.grade != "pass":
            found[c.quantity, part_whose_row_is_shown(c.part), str(c.when)] = c.grade
    return found


def _row_grades(
    row: StateTableRow, graded: dict[tuple[str, Part, str], CheckGrade], r: LineResponse
) -> tuple[str, ...]:
    """Return the grade of each value of a row; approximations are not what is checked."""
    if row.method:
        return ("",) * len(row.values)
    shown: list[str] = []
    for state in r.demand.states:
        grade = worst_verdict(
            [graded.get((q, row.part, state), "pass") for q in row.limit_quantities]
        )
        shown.append("" if grade == "pass" else grade)
    return tuple(shown)


def _study_chapters(of: Approval, say: Translator, *, short: bool) -> Iterator[Chapter]:
    """Yield a chapter for each study that was run with the driveline."""
    for found in of.study_results:
        registered = study_registrations()[found.study]
        if not registered.chapters or not found.was_run:
            continue
        if found.answer:
            yield from load_function(registered.chapters)(found, say, short=short)
        elif found.failure_reasons:
            failed = Text(paragraphs=tuple(failure_sentences(found, say)))
            yield Chapter(title=say(registered.title), blocks=(failed,))


def _equation_blocks(of: Approval, say: Translator) -> Iterator[Block]:
    """Yield the declaration of every quantity that has a limit in this report."""
    shown = {c.quantity for c in of.checks} | {u.quantity for u in of.coverage.unevaluated}
    used = [q for key, q in QUANTITIES.items() if key in shown]
    yield Table(
        caption=say("Quantities with a limit; `cardan explain` lists all others"),
        head=(say("quantity"), say("symbol"), say("equation"), say("limits of use"), say("source")),
        rows=tuple(
            (
                say.name(q.key),
                f"{q.symbol} [{q.unit_symbol}]" if q.unit_symbol else q.symbol,
                "; ".join(
                    [
                        say.translate_if_known(q.equation_text),
                        *(
                            f"{s}: {say.translate_if_known(w)}"
                            for s, w in q.symbol_meanings.items()
                        ),
                    ]
                ),
                say.translate_if_known(q.validity) if q.validity else "",
                citation(q.source, say),
            )
            for q in used
        ),
        words=5,
    )


def _file_blocks(say: Translator, issue: ReportDateAndSourceStamp) -> Iterator[Block]:
    """Yield what the files said."""
    for file, text in zip(issue.file_names, issue.file_texts, strict=False):
        yield CodeBlock(caption=say("Application file {file}", file=file), text=text)


def _comparison_table(caption: str, names: tuple[str, ...], rows: Iterable[ComparisonRow]) -> Table:
    """Return rows of variants as a table; a star marks where verdicts differ."""
    rows = tuple(rows)
    return Table(
        caption=caption,
        head=("", *names),
        rows=tuple((f"{r.name} *" if r.grades_differ else r.name, *r.values) for r in rows),
        words=1 if any(g for r in rows for g in r.grades) else len(names) + 1,
        grades=tuple(("", *(g or "" for g in r.grades)) for r in rows),
    )
