"""A bracket study as text for a terminal: verdict, stiffness, features, stresses, life."""

from collections.abc import Iterator, Sequence

import numpy as np

from cardan.approval.approval import Approval
from cardan.approval.study import BRACKET_STUDY_NAME
from cardan.core.units import MPa, N, kN, mm
from cardan.physics.fem.unit_loads import UNIT_LOAD_NAMES
from cardan.render.i18n import ENGLISH, Translator
from cardan.render.phrases import citation, unevaluated_limit_lines
from cardan.render.terminal import (
    BOLD_CODE,
    RESET_CODE,
    check_lines,
    summary_lines,
    unevaluated_lines,
)
from cardan.render.text_layout import DEFAULT_WIDTH_COLUMNS, fold_lines, table_lines
from cardan.topics.bracket.assessment import BracketResult
from cardan.topics.bracket.phrases import (
    bracket_heading,
    bracket_stiffness_entry,
    contact_notes,
    contact_recommendation,
    damage_method_sentence,
    finite_element_solution_remarks,
    first_failure_text,
    forced_response_sentences,
    hours_text,
    joint_face_lift_off_notes,
    large_displacement_notes,
    life_bounds_note,
    number_range_text,
    resonance_sentences,
    stop_notes,
    uncertain_stress_notes,
    unknown_strength_notes,
    utilisation_label,
    variant_comparison_sentence,
)
from cardan.topics.bracket.presentation_values import (
    MAX_LISTED_CASES,
    MAX_RELIABLE_ERROR_SHARE,
    STRAIN_PER_MICROSTRAIN,
    any_known,
    damage_results,
    feature_hours_bounds,
    feature_hours_to_failure,
    highest_stress,
    max_fatigue_utilisation,
    most_damaging_results,
    most_stressed_cases,
)
from cardan.topics.bracket.shape_result import ShapeAssessment


def terminal_lines(
    approval: Approval, say: Translator = ENGLISH, *, width: int = DEFAULT_WIDTH_COLUMNS
) -> Iterator[str]:
    """Yield the verdict and a bracket's numbers, for a screen of a width."""
    of: BracketResult = approval.answer_of(BRACKET_STUDY_NAME)
    bracket = of.bracket
    yield from fold_lines(verdict_lines(approval, say, width=width), width)
    yield ""
    yield from _bold(bracket_heading(of, say), width)
    material, source = bracket.material.name, citation(bracket.material.source, say)
    yield from fold_lines(
        [say("material {material}, {source}", material=material, source=source)], width
    )
    yield ""
    yield from _numbers(
        ("", *(say(v.name) for v in of.variants)),
        [(label, *map(say.number, values)) for label, values in _rows(of, say)],
        width,
    )
    yield from fold_lines((bracket_stiffness_entry(v, say) for v in of.variants), width)
    for v in of.variants:
        yield from fold_lines(
            [
                *resonance_sentences(v, say),
                *forced_response_sentences(v, say),
                *finite_element_solution_remarks(of, v, say),
            ],
            width,
        )
    for v in of.variants:
        yield from _features(of, v, say, width)
        yield from _stresses(v, say, width)
        yield from _readings(v, [gauge.name for gauge in of.bracket.gauges], say, width)
        yield from _lives(of, v, say, width)
    if len(of.variants) > 1:
        yield from _compared(of, say, width)


def _bold(line: str, width: int) -> Iterator[str]:
    return (f"{BOLD_CODE}{part}{RESET_CODE}" for part in fold_lines([line], width))


def _numbers(
    head: tuple[str, ...], rows: Sequence[tuple[str, ...]], width: int, *, words: int = 1
) -> Iterator[str]:
    """Yield a table whose columns beyond the first `words` are numbers."""
    return table_lines(head, rows, width, right=range(words, len(head)))


def verdict_lines(
    approval: Approval, say: Translator = ENGLISH, *, width: int = DEFAULT_WIDTH_COLUMNS
) -> Iterator[str]:
    """Yield the verdict, each limit where it is worst, and what is not evaluated."""
    yield from summary_lines(approval, say)
    yield say("limits: {profile}", profile=approval.application.profile)
    yield from check_lines(approval, say, width=width)
    yield from fold_lines(
        contact_recommendation(approval.answer_of(BRACKET_STUDY_NAME), approval.checks, say), width
    )
    yield from unevaluated_lines(unevaluated_limit_lines(approval, say), approval.coverage, say)


def _rows(of: BracketResult, say: Translator) -> Iterator[tuple[str, list[float]]]:
    """Yield what is known of the variants themselves, under no load case."""
    yield say("mass, kg"), [v.mass for v in of.variants]
    yield say("unknowns"), [float(v.solved.unknowns) for v in of.variants]
    for k, axis in enumerate("xyz"):
        stiff = [float(1 / v.compliance[k, k]) / (N / mm) for v in of.variants]
        yield say("stiffness at the bearing along {axis}, N/mm", axis=axis), stiff
        firm = [float(1 / v.solved.clamped.compliance[k, k]) / (N / mm) for v in of.variants]
        yield say("   with the flange clamped, N/mm"), firm
    for k in range(len(of.variants[0].loaded_frequencies)):
        loaded = [float(v.loaded_frequencies[k]) for v in of.variants]
        yield say("frequency {mode}, loaded, Hz", mode=k + 1), loaded
    alone = [float(v.frequencies[0]) for v in of.variants]
    yield say("first frequency by itself, Hz"), alone


def _features(of: BracketResult, v: ShapeAssessment, say: Translator, width: int) -> Iterator[str]:
    """Yield where a crack may start: each feature's stress, use of its limit, life."""
    yield ""
    yield from _bold(say("{name}, where a crack may start", name=say(v.name)), width)
    head = ("", say("at x, y, z [mm]"), "MPa ", say("fatigue use"), say("hours"))
    stress, _ = highest_stress(v)
    share, lasts, within = (
        max_fatigue_utilisation(v),
        feature_hours_to_failure(v),
        feature_hours_bounds(v),
    )
    rows: list[tuple[str, ...]] = []
    for k, f in enumerate(v.listed_features):
        at = "  ".join(f"{round(p / mm)}" for p in f.point)
        error = f"{f.error * stress[k] / MPa:.1f}"
        told = (
            f"{stress[k] / MPa:.1f} "
            f"±{error:>5}{' ' if f.error <= MAX_RELIABLE_ERROR_SHARE else '!'}"
        )
        use = "-" if np.isnan(share[k]) else f"{100 * share[k]:.0f} %"
        life = hours_text(float(lasts[k]), say, within[k])
        rows.append((say.part(f.part), at, say.with_decimal_sign(told), use, life))
    yield from _numbers(head, rows, width)
    left = len(v.features) - v.listed_count
    if left:
        more = say("and {count} more, each less worn and less stressed: --json", count=left)
        yield from fold_lines([f"  {more}"], width)
    means = say(
        "± is the estimated error (! above 5 %). Toes and borders: structural stress, carried on "
        "from 0.4 and 1.0 thicknesses away; the worse of a sliding and a clamped flange."
    )
    if v.life_results and not v.duty_damage:
        means += " " + say("Hours: of the recording that wears it most, driven on and on.")
    yield from fold_lines([f"  {means}"], width)
    for what in (
        *contact_notes(v, say),
        *uncertain_stress_notes(v, say),
        *unknown_strength_notes(of, v, say),
    ):
        yield from fold_lines([f"  {what}"], width)


def _stresses(v: ShapeAssessment, say: Translator, width: int) -> Iterator[str]:
    """Yield the highest stresses of one variant, case by case."""

    def one(value: float) -> str:
        return say.with_decimal_sign(f"{value / MPa:.1f}")

    yield ""
    yield from _bold(say("{name}, {unit}", name=say(v.name), unit="MPa"), width)
    head = ("", say("worst at"), "von Mises", say("tension"), say("compression"))
    rows = [
        (
            say.occasion(o.case.when), say.part(v.features[int(o.feature_stress.argmax())].part),
            *(one(f.value) for f in (o.von_mises, o.max_principal, o.min_principal)),
        )
        for o in most_stressed_cases(v)
    ]  # fmt: skip
    yield from _numbers(head, rows, width, words=2)
    left = len(v.case_results) - MAX_LISTED_CASES
    if left > 0:
        milder = say.count("and {count} milder case", "and {count} milder cases", left)
        yield f"  {milder}: --json"
    for told in (
        *stop_notes(v, say),
        *joint_face_lift_off_notes(v, say),
        *large_displacement_notes(v, say),
    ):
        yield from fold_lines([f"  {told}"], width)


def _readings(v: ShapeAssessment, names: list[str], say: Translator, width: int) -> Iterator[str]:
    """Yield what the gauges read."""
    if not names:
        return
    yield ""
    yield from _bold(say("{name}, {unit}", name=say(v.name), unit=say("microstrain")), width)
    rows = [
        (
            say("per kN of {load}", load=unit),
            *(say.number(b * kN / STRAIN_PER_MICROSTRAIN) for b in column),
        )
        for unit, column in zip(UNIT_LOAD_NAMES[:3], v.influence.T, strict=False)
    ]
    for o in most_stressed_cases(v):
        spans = (
            say.with_decimal_sign(
                number_range_text(low / STRAIN_PER_MICROSTRAIN, high / STRAIN_PER_MICROSTRAIN)
            )
            for low, high in o.gauge_strain_range.tolist()
        )
        rows.append((say.occasion(o.case.when), *spans))
    yield from _numbers(("", *names), rows, width)
    change = v.solved.influence_change
    floor = change * float(np.abs(v.influence[:, :3]).max()) * kN / STRAIN_PER_MICROSTRAIN
    said = say(
        "Refining changes the gauges' influence by {change} % of the largest at most, {floor} "
        "microstrain per kN: what reads less than that may be nothing.",
        change=say.with_decimal_sign(f"{100 * change:.1f}"),
        floor=say.with_decimal_sign(f"{floor:.2g}"),
    )
    yield from fold_lines([f"  {said}"], width)


def _lives(of: BracketResult, v: ShapeAssessment, say: Translator, width: int) -> Iterator[str]:
    """Yield damage and life of one variant; nothing without an S-N curve."""
    if not damage_results(v):
        return
    yield ""
    yield from _bold(say("{name}, {unit}", name=say(v.name), unit=say("damage")), width)
    rows: list[tuple[str, ...]] = []
    for e in most_damaging_results(v):
        where = (
            say.part(v.features[int(np.nanargmax(e.hot_spot_damage))].part)
            if e.worst_damage > 0
            else ""
        )
        told = (
            _small(e.damage_per_turn, say),
            _small(e.damage_per_hour, say),
            hours_text(e.hours_to_failure, say, e.hours_bounds),
        )
        rows.append((say.occasion(e.when), where, *told))
    yield from _numbers(
        (
            "", say("worst at"), say("damage per turn"), say("damage per hour"),
            say("hours to the first failure"),
        ), rows, width, words=2,
    )  # fmt: skip
    yield from fold_lines([f"  {damage_method_sentence(of, say)} {life_bounds_note(say)}"], width)


def _small(value: float, say: Translator) -> str:
    """Return a damage or a life: both range over many powers of ten."""
    if np.isnan(value) or value > 1e9:
        return say.number(value)
    return say.with_decimal_sign(f"{value:.3g}")


def _compared(of: BracketResult, say: Translator, width: int) -> Iterator[str]:
    """Yield what the reinforcement changes."""
    before, after = of.variants[0], of.variants[1]
    yield ""
    yield from _bold(say("What the reinforcement changes"), width)
    old, new = (
        float(before.worst_case.feature_stress.max()),
        float(after.worst_case.feature_stress.max()),
    )
    changed = [
        (say("highest stress, MPa"), old / MPa, new / MPa),
        (say("mass, kg"), before.mass, after.mass),
        (
            say("frequency {mode}, loaded, Hz", mode=1),
            before.loaded_frequencies[0],
            after.loaded_frequencies[0],
        ),
    ]
    uses = [float(np.nanmax(max_fatigue_utilisation(v), initial=0.0)) for v in (before, after)]
    if min(uses) > 0:
        changed.insert(1, (utilisation_label(of, say), 100 * uses[0], 100 * uses[1]))
    rows = [
        (
            label,
            say.number(float(was)),
            say.number(float(now)),
            say.margin_percent(float(now / was) - 1),
        )
        for label, was, now in changed
    ]
    if all(any_known(feature_hours_to_failure(v)) for v in (before, after)):
        was, now = (first_failure_text(v, say) for v in (before, after))
        rows.insert(1, (say("hours to the first failure"), was, now, ""))
    yield from _numbers(("", say(before.name), say(after.name), ""), rows, width)
    yield from fold_lines([variant_comparison_sentence(before, after, say)], width)
