"""Corrections as lines of a terminal and as the JSON contract has them."""

from collections.abc import Iterable, Iterator, Sequence
from typing import TYPE_CHECKING

from cardan.core.verdict import Check
from cardan.render.i18n import ENGLISH, Translator
from cardan.render.phrases import adjustment_phrase
from cardan.render.terminal import bold, coloured_by_grade
from cardan.topics.design.phrases import (
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
from cardan.topics.design.sensitivity import CheckSensitivity

if TYPE_CHECKING:  # one check of one design is not to wait for these
    from cardan.topics.design.corrections import Correction
    from cardan.topics.design.sizing import Remedy

    RemedyByCheck = dict[tuple[str, str], Remedy]


def correction_lines(
    of: "tuple[Correction, ...]",
    say: Translator = ENGLISH,
    *,
    helps: Sequence[CheckSensitivity] = (),
    several: bool = False,
) -> Iterator[str]:
    """Yield corrections, best first, with what each moves, costs and wins.

    Where there is none, what each move `helps` and spoils says why.
    """
    if not of:
        yield no_correction_sentence(say)
        if helps := [one for one in helps if one.helpful_effects]:
            yield say("Each move alone:")
            yield from _failed_check_lines(helps, {}, say, several=several)
        return
    yield say(
        "Line {line}; as installed: {standing}.",
        line=of[0].line,
        standing=correction_standing_sentence(of[0], of[0].installed_approval, say),
    )  # fmt: skip
    if fixed := unchangeable_sentence(of[0], say):
        yield fixed
    yield say("Cost is the share of the given ranges in use; a turned yoke counts 0.5.")
    if scatter := production_tolerance_sentence(of[0].tolerance_model, say):
        yield scatter
    for k, p in enumerate(of, 1):
        yield ""
        cost = say.compact_number(round(p.cost, 2))
        to = say(
            "{standing}, cost {cost}",
            standing=correction_standing_sentence(p, p.approval, say),
            cost=cost,
        )
        yield coloured_by_grade(p.verdict, f"{k}. {to}")
        yield from (f"     {adjustment_phrase(m, say)}" for m in p.adjustments)
        yield f"     {correction_improvement_sentence(p, say)}"
        yield from (
            f"     {one}"
            for one in tolerance_yield_sentences(p.tolerance_yield, p.tolerance_model, say)
        )
        yield from (
            f"     {one}" for one in remaining_problem_sentences(p, say, grade=coloured_by_grade)
        )


def adjustment_effect_lines(
    of: tuple[CheckSensitivity, ...], sizes: "RemedyByCheck", say: Translator, *, several: bool
) -> Iterator[str]:
    """Yield what moving things would do to what does not pass."""
    if not of:
        return
    yield ""
    yield bold(say("Single corrections (`cardan fix` looks for the best combination)"))
    yield from _failed_check_lines(of, sizes, say, several=several)


def _failed_check_lines(
    of: Iterable[CheckSensitivity], sizes: "RemedyByCheck", say: Translator, *, several: bool
) -> Iterator[str]:
    """Yield what does not pass, each with the moves that help or what there is instead."""
    hopeless: set[tuple[str, str]] = set()
    for one in of:
        moves, what = helpful_adjustment_phrases(one, say), (one.check.line, one.check.quantity)
        if not moves and what in hopeless:
            continue  # said of the part that is worst
        hopeless |= set() if moves else {what}
        yield f"  {failed_check_sentence(one, say, several=several)}"
        yield from (
            f"      {m}"
            for m in moves or [part_replacement_advice(one.check, sizes.get(what), say)]
        )


def part_replacement_advice(check: Check, remedy: "Remedy | None", say: Translator) -> str:
    """Return what there is where nothing can be moved: another part, or the search for one."""
    if remedy is None:
        from cardan.topics.design.sizing import PROPOSAL_KINDS_BY_QUANTITY

        if check.quantity in PROPOSAL_KINDS_BY_QUANTITY:
            return say("nothing that can be moved; `cardan size` tries other parts")
        return say("nothing that can be moved")
    from cardan.topics.design.sizing_presentation import next_size_advice as other_part

    return other_part(remedy, say)
