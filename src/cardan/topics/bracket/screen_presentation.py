"""First screen of `cardan bracket`: verdict, criteria, stress and life, open points, next."""

from collections.abc import Iterator

import numpy as np

from cardan.approval.approval import Approval
from cardan.approval.study import BRACKET_STUDY_NAME
from cardan.core.units import MPa
from cardan.render.check_screen import MAX_LIST_LINES, criteria_count_text, criteria_table_lines
from cardan.render.check_texts import limit_text
from cardan.render.i18n import ENGLISH, Translator
from cardan.render.phrases import citation, unevaluated_limit_lines
from cardan.render.screen_layout import capped_item_lines, capped_list_lines, title_lines
from cardan.render.terminal import bold
from cardan.render.text_layout import DEFAULT_WIDTH_COLUMNS, fold_lines
from cardan.topics.bracket.assessment import BracketResult
from cardan.topics.bracket.phrases import (
    contact_notes,
    contact_recommendation,
    finite_element_solution_remarks,
    first_failure_text,
    forced_response_sentences,
    joint_face_lift_off_notes,
    large_displacement_notes,
    resonance_sentences,
    uncertain_stress_notes,
    unknown_strength_notes,
    variant_comparison_sentence,
)
from cardan.topics.bracket.presentation_values import (
    any_known,
    feature_hours_to_failure,
    highest_stress,
    max_fatigue_utilisation,
)
from cardan.topics.bracket.shape_result import ShapeAssessment

MAX_LINES = 32
"""Lines of the screen at 80 columns; the blocks below keep to it together."""

MIN_TABLE_LINES, MAX_TABLE_LINES = 3, 9
MIN_OPEN_POINT_LINES = 7
"""Lines of what a signer should know, with their head: the gravest point may take five."""

_BRACKET_ALONE = "Of the bracket alone: cardan check holds the line against all its limits."
"""Or its approval would be taken for that of the truck."""


def screen_lines(
    of: Approval, say: Translator = ENGLISH, *, width: int = DEFAULT_WIDTH_COLUMNS
) -> Iterator[str]:
    """Yield verdict, criteria, numbers of each shape, what is assumed, next commands.

    At 80 columns at most `MAX_LINES` lines.
    """
    found: BracketResult = of.answer_of(BRACKET_STUDY_NAME)
    missing = unevaluated_limit_lines(of, say)
    head = [
        *title_lines(of, say, width),
        *fold_lines([_read_text(found, of, say), say(_BRACKET_ALONE)], width),
        *fold_lines([criteria_count_text(of.checks, say)], width),
    ]
    numbers = list(fold_lines(_number_texts(found, say), width))
    below = [
        *capped_list_lines(say("Not evaluated:"), missing, MAX_LIST_LINES, "--all", say, width),
        *fold_lines([f"{say('Next:')} cardan bracket FILE --all | --html OUT | --optimise | "
                     "cardan check FILE --with bracket"], width),
    ]  # fmt: skip
    room = MAX_LINES - len(head) - len(numbers) - len(below)
    most = max(min(MAX_TABLE_LINES, room - MAX_LIST_LINES - MIN_OPEN_POINT_LINES), MIN_TABLE_LINES)
    table = criteria_table_lines(of.checks, say, width, most=most)
    items = list(_open_points(found, of, say))
    yield from (*head, *table, *numbers, bold(say("Before you sign")))
    yield from capped_item_lines(items, max(room - len(table) - 1, 1), "--all", say, width)
    yield from below


def _read_text(found: BracketResult, of: Approval, say: Translator) -> str:
    """Return what was read: bearing, material, cases and profile of limits."""
    read = say.join(
        say("bracket of line {line}, bearing {bearing}",
            line=found.bracket.line, bearing=found.bracket.bearing),
        found.bracket.material.name,
        say.count("{count} load case", "{count} load cases", len(found.variants[0].case_results)),
    )  # fmt: skip
    profile = say("criteria: {profile}", profile=of.application.profile)
    return say("Read: {what}", what=f"{read}; {profile}")


def _number_texts(of: BracketResult, say: Translator) -> Iterator[str]:
    """Yield stress, fatigue and life of each shape, and whether the reinforced one is better."""
    for v in of.variants:
        mass = say("{mass} kg", mass=say.number(v.mass)) if len(of.variants) > 1 else ""
        yield f"{say(v.name)}: {say.join(mass, _shape_text(v, say))}"
    if len(of.variants) > 1:
        yield variant_comparison_sentence(of.variants[0], of.variants[1], say)


def _shape_text(v: ShapeAssessment, say: Translator) -> str:
    stress, cases = highest_stress(v)
    k = int(stress.argmax())
    f = v.features[k]
    texts = [
        say(
            "highest stress {stress} ± {error} MPa at {part} ({case})",
            stress=say.number(stress[k] / MPa), error=say.number(f.error * stress[k] / MPa),
            part=say.part(f.part), case=say.occasion(cases[k].case.when),
        )
    ]  # fmt: skip
    use = max_fatigue_utilisation(v)
    if any_known(use):
        k = int(np.nanargmax(use))
        texts.append(
            say(
                "{share} % of the fatigue limit at {part}",
                share=f"{100 * use[k]:.0f}", part=say.part(v.features[k].part),
            )
        )  # fmt: skip
    if any_known(feature_hours_to_failure(v)):
        texts.append(say("{hours} h to the first failure", hours=first_failure_text(v, say)))
    return "; ".join(texts)


def _open_points(of: BracketResult, approval: Approval, say: Translator) -> Iterator[str]:
    """Yield what a signer should know, the gravest first."""
    for v in of.variants:
        yield from large_displacement_notes(v, say)
        yield from contact_notes(v, say)
    yield from contact_recommendation(of, approval.checks, say)
    for v in of.variants:
        yield from unknown_strength_notes(of, v, say)
        yield from joint_face_lift_off_notes(v, say)
        yield from uncertain_stress_notes(v, say)
        if v.forced_response is None:
            yield from forced_response_sentences(v, say)
        if any(c.in_range for c in v.crossings):
            yield from resonance_sentences(v, say)
    if any(limit_text(c, say).endswith("*") for c in approval.checks):
        yield say("* limit of engineering judgement, no published limit")
    material = of.bracket.material
    yield say(
        "material {material}, {source}",
        material=material.name, source=citation(material.source, say),
    )  # fmt: skip
    for v in of.variants:
        if v.forced_response is not None:
            yield from forced_response_sentences(v, say)
        yield from finite_element_solution_remarks(of, v, say)
