"""First screen of `cardan fix`: proposals, what the first one changes, what stays, next."""

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

from cardan.approval.approval import Approval
from cardan.core.labels import WHOLE_LINE
from cardan.core.verdict import CHECK_GRADES, Check, CheckGrade
from cardan.documents.criteria import (
    Criterion,
    CriterionKey,
    criteria_of,
    full_name,
    limit_qualifiers,
    short_name,
)
from cardan.documents.first_screen import correction_text, criteria_count_text
from cardan.render.check_texts import limit_text, lower_bound_explanation, value_text
from cardan.render.i18n import ENGLISH, Translator
from cardan.render.phrases import (
    VERDICT_TEXTS,
    grade_text,
    grouped_unevaluated_lines,
    verdict_text,
    worst_check_per_limit,
)
from cardan.render.screen_layout import (
    capped_item_lines,
    capped_list_lines,
    more_text,
    percent_text,
    title_lines,
)
from cardan.render.terminal import GRADE_MARKS, bold
from cardan.render.text_layout import DEFAULT_WIDTH_COLUMNS, fold_lines, table_lines
from cardan.topics.design.correction import Correction
from cardan.topics.design.correction_edits import CorrectedText
from cardan.topics.design.phrases import (
    helpful_adjustment_phrases,
    no_correction_sentence,
    production_tolerance_sentence,
    tolerance_yield_sentences,
)
from cardan.topics.design.sensitivity import CheckSensitivity

SHORT_VERDICT_TEXTS = {**VERDICT_TEXTS, "warn": "with warnings"}
"""Verdicts for a narrow column."""

MAX_LINES = 32
"""Lines of the screen at 80 columns; the blocks below keep to it together."""

MAX_PROPOSAL_LINES = 9
MAX_CHANGE_LINES = 12
MIN_SIGNATURE_LINES = 3
MAX_CHANGE_LIST_LINES = 3
MAX_LIST_LINES = 2
MAX_HELP_LINES = 18


@dataclass(frozen=True, kw_only=True)
class _Change:
    """A criterion as installed and with a correction; None where it is not evaluated."""

    before: Criterion | None
    after: Criterion | None

    @property
    def grades(self) -> tuple[CheckGrade | None, CheckGrade | None]:
        """Verdicts as installed and corrected."""
        return _grade(self.before), _grade(self.after)

    @property
    def order(self) -> tuple[int, int]:
        """Place in the table: what is worse after the correction stands first."""
        was, now = (-1 if g is None else CHECK_GRADES.index(g) for g in self.grades)
        return -now, was - now if now >= 0 else -1


def _grade(of: Criterion | None) -> CheckGrade | None:
    return None if of is None else of.grade


def correction_screen_lines(
    of: Sequence[Correction],
    installed: Approval,
    *,
    helps: Sequence[CheckSensitivity] = (),
    say: Translator = ENGLISH,
    width: int = DEFAULT_WIDTH_COLUMNS,
) -> Iterator[str]:
    """Yield the verdict as installed, the proposals, what the first changes, next commands.

    At 80 columns at most `MAX_LINES` lines. Without proposals what each move `helps` and
    spoils says why.
    """
    title = title_lines(installed, say, width)
    if not of:
        yield from title
        yield from fold_lines([no_correction_sentence(say)], width)
        yield from _single_move_lines(helps, say, width)
        yield from _next_lines(of, say, width)
        return
    best = of[0]
    several = len(installed.line_responses) > 1
    read = say.join(
        say("line {line}", line=best.line),
        say.count("{count} state", "{count} states", len(installed.application.states)),
    )
    profile = say("criteria: {profile}", profile=installed.application.profile)
    exceeded, others = _changes_in_words(best, several=several, say=say)
    above = [
        *title,
        *fold_lines([say("Read: {what}", what=f"{read}; {profile}")], width),
        *_proposal_lines(of, installed, say, width),
    ]
    below = [
        *(line for lead, items in others for line in capped_list_lines(
            lead, items, MAX_CHANGE_LIST_LINES, "--all", say, width)),
        *_unchangeable_lines(best, several=several, say=say, width=width),
    ]  # fmt: skip
    end = [
        *_not_evaluated_lines(best, several=several, say=say, width=width),
        *_next_lines(of, say, width),
    ]
    items = [
        *tolerance_yield_sentences(best.tolerance_yield, best.tolerance_model, say),
        *filter(None, [production_tolerance_sentence(best.tolerance_model, say)]),
        say("Cost is the share of the given ranges in use; a turned yoke counts 0.5."),
    ]
    room = MAX_LINES - len(above) - len(below) - len(end) - 1
    table = _exceeded_lines(exceeded, min(room - MIN_SIGNATURE_LINES, MAX_CHANGE_LINES), say, width)
    yield from (*above, *table, *below)
    yield from fold_lines(lower_bound_explanation((*above, *table, *below), say), width)
    yield bold(say("Before you sign"))
    yield from capped_item_lines(items, max(room - len(table), 1), "--all", say, width)
    yield from end


# --------------------------------------------------------------------------- proposals


def _proposal_lines(
    of: Sequence[Correction], installed: Approval, say: Translator, width: int
) -> Iterator[str]:
    """Yield a row for each proposal: moves, verdict, criteria of each grade, trucks, cost."""
    head = ("", *map(say, ("proposal", "verdict", "exceeded", "warnings", "trucks", "cost")))
    rows = [
        (
            "",
            say("as installed"),
            say(SHORT_VERDICT_TEXTS[installed.verdict]),
            *_counts(installed),
            "-",
            "-",
        )
    ]
    for k, p in enumerate(of, 1):
        moves = "; ".join(correction_text(m, say) for m in p.adjustments)
        trucks = percent_text(p.tolerance_yield.share, say, digits=0) if p.tolerance_yield else "-"
        cost = say.compact_number(round(p.cost, 2))
        exceeded, warnings = _counts(p.approval)
        if new := _newly_exceeded_count(p):
            exceeded = say("{count} ({new} new)", count=exceeded, new=new)
        verdict = say(SHORT_VERDICT_TEXTS[p.verdict])
        rows.append((str(k), moves, verdict, exceeded, warnings, trucks, cost))
    for shown in range(len(rows), 1, -1):
        first, *lines = table_lines(head, rows[:shown], width, right=(3, 4, 5, 6))
        rest = len(rows) - shown
        if len(lines) <= MAX_PROPOSAL_LINES - bool(rest) or shown == 2:
            yield bold(first)
            yield from lines
            if rest:
                yield f"  {more_text(rest, '--all', say)}"
            return


def _counts(of: Approval) -> tuple[str, str]:
    """Return how many criteria are exceeded, and beyond recommended."""
    number = Counter(c.grade for c in criteria_of(of.checks))
    return str(number["fail"]), str(number["warn"])


def _newly_exceeded_count(p: Correction) -> int:
    """Return how many criteria a correction exceeds that are not exceeded as installed."""
    before, after = (
        {c.key for c in criteria_of(a.checks) if c.grade == "fail"}
        for a in (p.installed_approval, p.approval)
    )
    return len(after - before)


# --------------------------------------------------------------------------- what changes


def _changes_in_words(
    p: Correction, *, several: bool, say: Translator
) -> tuple[list[tuple[str, ...]], list[tuple[str, list[str]]]]:
    """Return rows of what a correction leaves exceeded, and lists of what else it changes.

    Each value stands against the limit that decides its verdict.
    """
    checks = [*p.installed_approval.checks, *p.checks]
    qualifiers = limit_qualifiers(checks, p.approval.application)
    rows: list[tuple[str, ...]] = []
    improved: list[str] = []
    worsened: list[str] = []
    gone: list[str] = []
    for one in sorted(_changes(p), key=lambda one: one.order):
        was, now = one.grades
        arrow = " -> ".join(grade_text(g, say) if g else "-" for g in dict.fromkeys((was, now)))
        name = _name(one, qualifiers, say, several=several)
        before, after = (_against_limit(c, say) for c in (one.before, one.after))
        if now is None:
            gone.append(name)
        elif now == "fail":
            rows.append((GRADE_MARKS[now], name, before, after, arrow))
        else:
            better = one.order[1] > 0
            (improved if better else worsened).append(f"{name} {before} -> {after}, {arrow}")
    return rows, [
        (say("Improved:"), improved),
        (say("Worsened:"), worsened),
        (say("Does not apply any more:"), gone),
    ]


def _exceeded_lines(
    rows: Sequence[Sequence[str]], count: int, say: Translator, width: int
) -> list[str]:
    """Return a table of what stays exceeded in so many lines, the rest counted."""
    head = ("", *map(say, ("criterion, proposal 1", "as installed", "corrected", "verdict")))
    for shown in range(len(rows), 0, -1):
        table = list(table_lines(head, rows[:shown], width))
        rest = len(rows) - shown
        if len(table) <= count - bool(rest) or shown == 1:
            more = [f"   {more_text(rest, '--all', say)}"] if rest else []
            return [bold(table[0]), *table[1:], *more]
    return []


def _changes(p: Correction) -> Iterator[_Change]:
    """Yield the criteria with another verdict after a correction, and those still exceeded."""
    before = {c.key: c for c in criteria_of(p.installed_approval.checks)}
    after = {c.key: c for c in criteria_of(p.checks)}
    for key in dict.fromkeys([*before, *after]):
        one = _Change(before=before.get(key), after=after.get(key))
        was, now = one.grades
        if was != now or now == "fail":
            yield one


def _name(
    one: _Change, qualifiers: Mapping[CriterionKey, str], say: Translator, *, several: bool
) -> str:
    """Return the name of a criterion, with its part if that is the same before and after."""
    checks = [c.worst for c in (one.before, one.after) if c is not None]
    if len({c.part for c in checks}) == 1:
        name = full_name(checks[0], say, qualifiers)
    else:
        name = short_name(replace(checks[0], part=WHOLE_LINE), say, qualifiers)
    return f"{checks[0].line}: {name}" if several else name


def _against_limit(c: Criterion | None, say: Translator) -> str:
    """Return the worst value with the limit that decides its verdict."""
    return "-" if c is None else f"{value_text(c.worst, say)} ({limit_text(c.worst, say)})"


def _unchangeable_lines(p: Correction, *, several: bool, say: Translator, width: int) -> list[str]:
    """Return what does not pass and no move corrects."""

    def named(c: Check) -> str:
        name = full_name(c, say, {})
        return f"{c.line}: {name}" if several else name

    items = [named(c) for c in worst_check_per_limit(p.unchangeable_checks)]
    return capped_list_lines(say("No move corrects:"), items, MAX_LIST_LINES, "--all", say, width)


# --------------------------------------------------------------------------- the rest


def _single_move_lines(
    helps: Sequence[CheckSensitivity], say: Translator, width: int
) -> Iterator[str]:
    """Yield what each move alone would do to what does not pass."""
    helps = [one for one in helps if one.helpful_effects]
    if not helps:
        return
    yield bold(say("Each move alone:"))
    items = [
        f"{full_name(one.check, say, {})} {value_text(one.check, say)} "
        f"({limit_text(one.check, say)}): {move}"
        for one in helps
        for move in helpful_adjustment_phrases(one, say)
    ]
    yield from capped_item_lines(items, MAX_HELP_LINES, "--all", say, width)


def _not_evaluated_lines(p: Correction, *, several: bool, say: Translator, width: int) -> list[str]:
    """Return the required limits that a correction leaves without a value."""
    missing = p.approval.coverage.missing_required
    items = grouped_unevaluated_lines(missing, say, several=several)
    return capped_list_lines(say("Not evaluated:"), items, MAX_LIST_LINES, "--all", say, width)


def written_correction_lines(
    of: CorrectedText, k: int, checked: Approval, path: str, say: Translator, width: int
) -> Iterator[str]:
    """Yield the numbers that proposal `k` changed in a file, and what a check of it finds."""
    lead = say("Proposal {k} is written as {file}:", k=k, file=path)
    yield from fold_lines([lead], width)
    for at, was, now in of.changes:
        yield f"  {at}: {was or '-'} -> {now}"
    said = f"{verdict_text(checked, say)} ({criteria_count_text(checked, say)})"
    yield from fold_lines([say("Check of {file}: {verdict}", file=path, verdict=said)], width)


def _next_lines(of: Sequence[Correction], say: Translator, width: int) -> Iterator[str]:
    """Yield the commands that follow."""
    size = "cardan size FILE | " if not of or of[0].unchangeable_checks else ""
    write = "--write OUT | " if of else ""
    yield from fold_lines(
        [f"{say('Next:')} {size}cardan check FILE --moves | cardan fix FILE {write}--hold WHAT | "
         "--draws N | --all"], width,
    )  # fmt: skip
