"""`cardan check --why`: a criterion with its equation, the numbers put in and its sources."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass

from cardan.approval.approval import Approval
from cardan.checks.quantities.declaration import Quantity
from cardan.checks.quantities.registry import QUANTITIES
from cardan.core.labels import WHOLE_LINE
from cardan.core.verdict import Check, UnevaluatedCheck
from cardan.documents.criteria import (
    Criterion,
    CriterionKey,
    criteria_of,
    full_condition_text,
    full_name,
    limit_qualifiers,
    mode_text,
    short_name,
)
from cardan.documents.criterion_inputs import input_rows, is_at_line_torque
from cardan.render.check_texts import limit_text, unit_text, value_text
from cardan.render.i18n import LANGUAGE_CODES, Translator
from cardan.render.phrases import (
    assumed_range_phrase,
    citation,
    grade_text,
    limit_grouping_key,
)
from cardan.render.screen_layout import title_lines
from cardan.render.terminal import aligned_column_lines, bold, coloured_by_grade
from cardan.render.text_layout import DEFAULT_WIDTH_COLUMNS, fold_lines
from cardan.topics.design.phrases import failed_check_sentence, helpful_adjustment_phrases
from cardan.topics.design.sensitivity import CheckSensitivity

MAX_EXPLAINED = 6
"""Criteria that one text may name, at most; of more it names too little."""


@dataclass(frozen=True, kw_only=True)
class ExplainedCriterion:
    """A criterion with its checks, or with those that could not be evaluated."""

    criterion: Criterion | None
    unevaluated: tuple[UnevaluatedCheck, ...] = ()

    @property
    def first(self) -> Check | UnevaluatedCheck:
        """Its worst check, or the first that was not evaluated."""
        return self.criterion.worst if self.criterion else self.unevaluated[0]


def explained_criteria(of: Approval) -> tuple[ExplainedCriterion, ...]:
    """Return every criterion of an approval, the worst first, those not evaluated last."""
    missed: dict[CriterionKey, list[UnevaluatedCheck]] = {}
    for u in of.coverage.unevaluated:
        missed.setdefault(limit_grouping_key(u), []).append(u)
    known = [
        ExplainedCriterion(criterion=c, unevaluated=tuple(missed.pop(c.key, ())))
        for c in criteria_of(of.checks)
    ]
    open_ = [ExplainedCriterion(criterion=None, unevaluated=tuple(u)) for u in missed.values()]
    return (*known, *open_)


def criteria_named(of: Approval, text: str) -> tuple[ExplainedCriterion, ...]:
    """Return the criteria that a text names: whole names first, else names that hold it.

    A name is the key of a quantity, or what a screen or table calls it in any language.
    """
    word, every = " ".join(text.casefold().split()), explained_criteria(of)
    qualifiers = _qualifiers(of)
    named = [(one, _names(one.first, qualifiers)) for one in every]
    whole = tuple(one for one, names in named if word in names)
    return whole or tuple(one for one, names in named if any(word in name for name in names))


def criterion_names(of: Approval, say: Translator) -> tuple[str, ...]:
    """Return the names of all criteria in a language, the worst first."""
    qualifiers = _qualifiers(of)
    every = explained_criteria(of)
    return tuple(dict.fromkeys(full_name(one.first, say, qualifiers) for one in every))


def _qualifiers(of: Approval) -> Mapping[CriterionKey, str]:
    return limit_qualifiers([*of.checks, *of.coverage.unevaluated], of.application)


def _names(c: Check | UnevaluatedCheck, qualifiers: Mapping[CriterionKey, str]) -> set[str]:
    """Return what a criterion may be called, in small letters."""
    found = {c.quantity}
    for code in LANGUAGE_CODES:
        say = Translator(code)
        name = full_name(c, say, qualifiers)
        found |= {say.name(c.quantity), short_name(c, say, qualifiers), name, f"{c.line}: {name}"}
    return {name.casefold() for name in found}


def explanation_lines(
    criteria: Sequence[ExplainedCriterion],
    of: Approval,
    *,
    helps: Iterable[CheckSensitivity],
    say: Translator,
    width: int = DEFAULT_WIDTH_COLUMNS,
) -> Iterator[str]:
    """Yield criteria with verdict, worst case, equation, numbers put in, limit and sources."""
    helps, qualifiers = tuple(helps), _qualifiers(of)
    several = len(of.line_responses) > 1
    yield from title_lines(of, say, width)
    for one in criteria:
        yield ""
        name = full_name(one.first, say, qualifiers)
        yield from fold_lines([bold(f"{one.first.line}: {name}" if several else name)], width)
        if one.criterion:
            yield from fold_lines(_worst_case_lines(one.criterion, say), width)
        if one.unevaluated:
            yield from fold_lines(_not_evaluated_lines(one.unevaluated, say), width)
        yield from fold_lines(_equation_lines(QUANTITIES[one.first.quantity], say), width)
        if one.criterion:
            yield from fold_lines(_number_lines(one.criterion.worst, of, say), width)
            yield from fold_lines(_state_lines(one.criterion, say), width)
        yield from fold_lines(_limit_lines(one.first, say), width)
        yield from fold_lines(_correction_lines(one, helps, say), width)


def _worst_case_lines(criterion: Criterion, say: Translator) -> Iterator[str]:
    """Yield verdict, value and limit, and the whole of where it is worst."""
    c = criterion.worst
    value = f"{value_text(c, say)} {unit_text(c)}".rstrip()
    said = say.join(value, limit_text(c, say), say.margin_text(c.margin))
    yield f"  {coloured_by_grade(c.grade, grade_text(c.grade, say))}: {said}"
    where = say.join(
        full_condition_text(c, say),
        f"{say.compact_number(c.point.torque, 4)} N·m" if c.point and is_at_line_torque(c) else "",
        "" if c.part == WHOLE_LINE else say.part(c.part),
    )
    yield f"  {say('worst case')}: {where}"
    if resonance := mode_text(c, say):
        yield f"    {resonance}"
    if (check := criterion.deciding_check) and check.within:
        low, high = (value_text(check, say, end) for end in check.within)
        inputs = say.join(*(assumed_range_phrase(a, say) for a in check.assumed))
        interval = f"{say('{low} to {high}', low=low, high=high)} {unit_text(check)}".rstrip()
        best, worst = (
            grade_text(g, say) for g in (check.best_possible_grade, check.worst_possible_grade)
        )
        verdicts = best if best == worst else f"{best} / {worst}"
        possible = say("{verdicts} possible", verdicts=verdicts)
        yield f"  {inputs or say('the error of the computation')}: {interval}, {possible}"


def _not_evaluated_lines(missed: Sequence[UnevaluatedCheck], say: Translator) -> Iterator[str]:
    """Yield the parts that were not evaluated, and the input that they need."""
    found: dict[tuple[str, ...], dict[str, None]] = {}
    for u in missed:
        part = "" if u.part == WHOLE_LINE else say.part(u.part)
        found.setdefault(u.missing_inputs, {})[part] = None
    for needs, parts in found.items():
        inputs = "; ".join(say.translate_if_known(need) for need in needs)
        reason = (
            say("(input missing: {inputs})", inputs=inputs)
            if inputs
            else say("(no value can be computed)")
        )
        yield f"  {say.join(*parts, say('not evaluated'))} {reason}"


def _equation_lines(q: Quantity, say: Translator) -> Iterator[str]:
    """Yield equation, symbols, limits of use and source of a quantity."""
    yield f"  {say('Equation')}: {say.translate_if_known(q.equation_text)}"
    for symbol, meaning in q.symbol_meanings.items():
        yield f"    {symbol}: {say.translate_if_known(meaning)}"
    if q.validity:
        yield f"  {say('Limits of use')}: {say.translate_if_known(q.validity)}"
    yield f"  {say('Source')}: {citation(q.source, say)}"


def _number_lines(c: Check, of: Approval, say: Translator) -> Iterator[str]:
    """Yield the numbers put into the equation where the criterion is worst."""
    response = next((r for r in of.line_responses if r.line.name == c.line), None)
    if response is None or c.when.kind != "state":
        return
    rows = list(input_rows(c, response, say))
    if rows:
        yield f"  {say('Numbers put in')}"
        yield from (f"    {line}" for line in aligned_column_lines(rows))


def _state_lines(criterion: Criterion, say: Translator) -> Iterator[str]:
    """Yield the worst value of each state."""
    worst: dict[str, Check] = {}
    for c in criterion.checks:
        worst.setdefault(say.occasion(c.when), c)
    if len(worst) > 1:
        yield f"  {say('Worst value of each state')}"
        rows = [
            (name, value_text(c, say), unit_text(c), grade_text(c.grade, say))
            for name, c in worst.items()
        ]
        yield from (f"    {line}" for line in aligned_column_lines(rows, words=(0, 2, 3)))


def _limit_lines(c: Check | UnevaluatedCheck, say: Translator) -> Iterator[str]:
    """Yield the bounds of a limit, their source and how that was read."""
    q, limit = QUANTITIES[c.quantity], c.limit
    sense = "max {bound}" if limit.sense == "<=" else "min {bound}"
    bounds: list[str] = []
    for bound, which in ((limit.normal, "recommended"), (limit.maximum, "")):
        if bound is not None:
            said = say(sense, bound=say.compact_number(bound / q.si_factor))
            bounds.append(" ".join(filter(None, (which and say(which), said, q.unit_symbol))))
    if limit.band:
        low, high = (say.compact_number(edge / q.si_factor) for edge in limit.band)
        bounds.append(say("outside {low} to {high}", low=low, high=high))
    yield f"  {say('Limit')}: {say.join(*bounds)}"
    yield f"    {citation(limit.source, say)}"


def _correction_lines(
    of: ExplainedCriterion, helps: Sequence[CheckSensitivity], say: Translator
) -> Iterator[str]:
    """Yield what single corrections do to a criterion that is not met, part by part."""
    if of.criterion is None or of.criterion.grade == "pass":
        return
    own = [one for one in helps if limit_grouping_key(one.check) == of.criterion.key]
    if own:
        yield f"  {say('Single corrections')}"
    for one in own:
        yield f"    {failed_check_sentence(one, say)}"
        phrases = helpful_adjustment_phrases(one, say) or [say("no geometric correction")]
        yield from (f"      {phrase}" for phrase in phrases)
