"""Corrections in words: what a move wins and spoils, what tolerances leave of it."""

from collections.abc import Callable, Iterable
from typing import TYPE_CHECKING

from cardan.checks.quantities.registry import QUANTITIES
from cardan.core.labels import WHOLE_LINE
from cardan.core.verdict import Check, CheckGrade, worsened_checks
from cardan.model.adjustments import ADJUSTMENTS
from cardan.model.adjustments import permitted_adjustments_by_name as names_of
from cardan.model.application import PermittedAdjustment
from cardan.render.i18n import Translator
from cardan.render.phrases import (
    adjustable_parameter_phrase,
    adjustment_phrase,
    check_sentence,
    grade_text,
    grouped_unevaluated_lines,
    verdict_text,
    worst_check_per_limit,
)
from cardan.render.screen_layout import percent_text
from cardan.topics.design.sensitivity import AdjustmentEffect, CheckSensitivity

if TYPE_CHECKING:  # one check of one design is not to wait for these
    from cardan.approval.approval import Approval
    from cardan.topics.design.corrections import Correction
    from cardan.topics.design.robustness import ToleranceModel, ToleranceYield

MAX_UNCHANGEABLE_NAMES = 4
"""Names of what no move corrects that a line holds; the rest is counted."""


def remaining_problem_sentences(
    of: "Correction",
    say: Translator,
    *,
    grade: Callable[[CheckGrade, str], str] = lambda _, word: word,
) -> list[str]:
    """Return what does not pass with a correction, and what is not evaluated.

    Of what was as bad before the worst three, of what it spoils as many. `grade` puts a grade's
    word as a medium shows it.
    """
    several = len(of.approval.line_responses) > 1
    new = worsened_checks(of.installed_approval.checks, of.checks)
    old = (c for c in of.checks if c.grade != "pass" and c not in new)

    def told(c: Check) -> dict[str, str]:
        check = f"{c.line}: {check_sentence(c, say)}" if several else check_sentence(c, say)
        return {"grade": grade(c.grade, grade_text(c.grade, say)), "check": check}

    return [
        *(say("but then {grade}: {check}", **told(c)) for c in worst_check_per_limit(new)[:3]),
        *(say("still {grade}: {check}", **told(c)) for c in worst_check_per_limit(old)[:3]),
        *grouped_unevaluated_lines(of.approval.coverage.missing_required, say, several=several),
    ]


def production_tolerance_sentence(trucks: "ToleranceModel | None", say: Translator) -> str:
    """Return how the trucks are taken to scatter about a setting; "" where nothing does."""
    if trucks is None:
        return ""
    every = _adjustables_by_name(trucks)
    parts: dict[tuple[str, str], list[str]] = {}
    for name, spread in trucks.tolerances:
        wide = say.compact_number(
            round(spread.values[0] * (3 if spread.kind == "normal" else 1), 4)
        )
        a = every.get(name)
        unit = ADJUSTMENTS[a.adjustment_key].unit.replace("percent", "%") if a else ""
        parts.setdefault((a.adjustment_key if a else name, f"± {wide} {unit}".rstrip()), []).append(
            str(a.part) if a else ""
        )
    what = say.join(*(
        f"{say(ADJUSTMENTS[of].label, part=' + '.join(each)) if of in ADJUSTMENTS else of} {wide}"
        for (of, wide), each in parts.items()
    ))  # fmt: skip
    if trucks.assumed:
        return say("Trucks are assumed to scatter by {what} (3 σ).", what=what)
    return say("Trucks scatter by {what} (normal ones 3 σ), as the file says.", what=what)


def correction_standing_sentence(p: "Correction", of: "Approval", say: Translator) -> str:
    """Say what an application comes to, and its smallest margin that moving can change."""
    check = p.worst_changeable_check(of)
    return say(
        "{verdict}, smallest margin that moving changes {margin}",
        verdict=verdict_text(of, say), margin=_margin_to_bound(check.margin, check.grade, say),
    )  # fmt: skip


def _margin_to_bound(margin: float, grade: CheckGrade, say: Translator) -> str:
    """Return a margin and, unless it is of what passes, to which bound it is.

    What no longer fails may lie further beyond what is recommended than it lay beyond its
    maximum, and is better all the same.
    """
    shown = say.margin_percent(margin)
    if grade == "fail":
        return say("{margin} to its maximum", margin=shown)
    return say("{margin} to what is recommended", margin=shown) if grade == "warn" else shown


def correction_margins_sentence(p: "Correction", say: Translator) -> str:
    """Say the smallest margin with a correction and without it, each to its bound, and cost."""
    margin, before = (
        _margin_to_bound(of.smallest_margin or 0.0, of.worst_grade, say)
        for of in (p.approval, p.installed_approval)
    )
    return say(
        "margin {margin} (before: {before}), cost {cost}",
        margin=margin, before=before, cost=say.compact_number(round(p.cost, 2)),
    )  # fmt: skip


def unchangeable_sentence(p: "Correction", say: Translator) -> str:
    """Return what does not pass and no move corrects, the worst first; "" if there is nothing."""
    several = len(p.approval.line_responses) > 1
    rows = worst_check_per_limit(p.unchangeable_checks)
    names = [
        say.join(
            c.line if several else "",
            say.name(c.quantity),
            "" if c.part == WHOLE_LINE else say.part(c.part),
        )
        + f" ({say.margin_percent(c.margin)})"
        for c in rows[:MAX_UNCHANGEABLE_NAMES]
    ]
    if rows[MAX_UNCHANGEABLE_NAMES:]:
        names.append(f"+{len(rows) - MAX_UNCHANGEABLE_NAMES}")
    return say("No move corrects: {checks}.", checks="; ".join(names)) if names else ""


def correction_improvement_sentence(p: "Correction", say: Translator) -> str:
    """Say what a correction wins among the limits that moving changes."""
    before, after = say.margin_percent(p.margin_before), say.margin_percent(p.margin)
    return say("nearest to its warning of what moving changes: {before}, then {after}",
               before=before, after=after)  # fmt: skip


def _adjustables_by_name(trucks: "ToleranceModel") -> dict[str, PermittedAdjustment]:
    """Return what a workshop moves of trucks, by the names that a study knows."""
    return names_of(i.line for i in trucks.application.lines)


def tolerance_yield_sentences(
    found: "ToleranceYield | None", trucks: "ToleranceModel | None", say: Translator
) -> list[str]:
    """Return how many trucks keep what a proposal promises, and what would win most."""
    if found is None or trucks is None:
        return []
    share, quiet = (
        percent_text(k, say, digits=0) for k in (found.share, found.share_without_warnings)
    )
    said = [
        say("{share} of trucks fail in nothing more; {quiet} do not warn more either",
            share=share, quiet=quiet)
    ]  # fmt: skip
    if found.most_failed_quantity:
        said.append(say("most others fail in: {limit}", limit=say.name(found.most_failed_quantity)))
    if found.best_tightening:
        name, more = found.best_tightening
        a = _adjustables_by_name(trucks).get(name)  # or a number of the file, by its address
        said.append(
            say("tighten first: {name}; half as wide, {share} fail in nothing more",
                name=adjustable_parameter_phrase(a, say) if a else name,
                share=percent_text(more, say, digits=0))
        )  # fmt: skip
    return said


def failed_check_sentence(one: CheckSensitivity, say: Translator, *, several: bool = False) -> str:
    """Return what does not pass, of which line where there are several, in how many states."""
    said = check_sentence(one.check, say)
    said = f"{one.check.line}: {said}" if several else said
    if len(one.states) < 2:
        return said
    return said + " (" + say.count("{count} state", "{count} states", len(one.states)) + ")"


def helpful_adjustment_phrases(one: CheckSensitivity, say: Translator) -> list[str]:
    """Return the three moves that win most, each with the value it gives."""
    return [_adjustment_effect_phrase(one, e, say) for e in one.helpful_effects[:3]]


def no_correction_sentence(say: Translator) -> str:
    """Say that no correction was found."""
    return say(
        "Nothing that may be moved, within `adjust` of the application file and in the steps of "
        "a workshop, leaves the line better than it stands."
    )


def checks_without_adjustment(of: Iterable[CheckSensitivity]) -> list[Check]:
    """Return the checks that no move helps."""
    return [one.check for one in of if not one.helpful_effects]


def _adjustment_effect_phrase(one: CheckSensitivity, e: AdjustmentEffect, say: Translator) -> str:
    """Return what one move does, the better way of the two, and what it spoils."""
    q = QUANTITIES[one.check.quantity]
    moved, value = one.best_adjustment(e)
    said = say(
        "{move} gives {value}",
        move=adjustment_phrase(moved, say),
        value=say.number(value / q.si_factor),
    )
    return ", ".join(filter(None, (said, worst_side_effect(e, say))))


def worst_side_effect(e: AdjustmentEffect, say: Translator) -> str:
    """Return the worst of what a move spoils; "" where that is nothing."""
    if (c := e.side_effect) is None:
        return ""
    told = (
        check_sentence(c, say)
        if c.line == e.adjustable.line
        else f"{c.line}: {check_sentence(c, say)}"
    )
    return say("but then {grade}: {check}", grade=grade_text(c.grade, say), check=told)
