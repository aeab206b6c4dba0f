"""Sentences and labels that say what a bracket study found."""

from collections.abc import Iterable, Iterator

import numpy as np

from cardan.core.labels import EvaluationCondition, Part
from cardan.core.units import MPa, N, kN, mm, rpm
from cardan.core.verdict import Check
from cardan.model.bracket import Bolts, StepFileShape, default_bolt_preload
from cardan.physics.fem.adaptive_refinement import ASSUMED_STRESS_ERROR_SHARE_UNREFINED
from cardan.render.i18n import ENGLISH, Translator
from cardan.render.phrases import torque_curve_name
from cardan.topics.bracket.assessment import BOLT_CONTACT_SETTLED_BY_KEY, BracketResult
from cardan.topics.bracket.contact_assessment import (
    MAX_CONTACT_STRESS_ERROR_SHARE,
    MIN_CONTACT_TO_COMPUTED_STRESS_RATIO,
    ContactResult,
)
from cardan.topics.bracket.forced_response import RIGID_MOUNT_STIFFNESS_RATIO
from cardan.topics.bracket.life import fatigue_strength_by_zone
from cardan.topics.bracket.metal_fatigue_data import zone_curve_key
from cardan.topics.bracket.presentation_values import (
    any_known,
    feature_hours_to_failure,
    highest_stress,
    max_fatigue_utilisation,
    most_stressed_cases,
    recordings_read_from_gauges,
    root_mean_square,
)
from cardan.topics.bracket.shape_result import ShapeAssessment

_MAX_SEAT_MOTION_SHARE = 0.1
"""Share of a bracket's size its seat may move by before small strains mean nothing."""
_STEP_BOLT_HOLE_DIAMETER = 11 * mm
"""Of an M10, where a file draws the holes itself."""
MAX_PRINTED_HOURS = 1e6
"""Hours beyond which a life is not given in figures."""


def bracket_heading(of: BracketResult, say: Translator = ENGLISH) -> str:
    """Return which bracket it is about."""
    return say(
        "{title}: bracket of line {line}, bearing {bearing}",
        title=of.title, line=of.bracket.line, bearing=of.bracket.bearing,
    )  # fmt: skip


def bracket_stiffness_entry(v: ShapeAssessment, say: Translator = ENGLISH) -> str:
    """Return how a centre bearing of an application file says a bracket, as a line feels it."""
    stiff = ", ".join(f"{1 / v.compliance[k, k] / (N / mm):.4g}" for k in range(3))
    told = say(
        "{name}: for cardan check the centre bearing may say  {key}",
        name=say(v.name), key=f"bracket: {{stiffness_N_mm: [{stiff}]}}",
    )  # fmt: skip
    share = say.compact_number(100 * float(v.solved.sliding.stiffness_error.max()), 2)
    return f"{told}  ({say('its elements are too stiff, by {share} % at most', share=share)})"


def resonance_sentences(v: ShapeAssessment, say: Translator) -> Iterator[str]:
    """Yield for each order where it meets natural frequencies."""
    met = [c for c in v.crossings if c.in_range]
    if not met:
        yield say(
            "{name}: loaded, without the line, no order 1, 2 or 4 meets a natural frequency within "
            "the speed range.",
            name=say(v.name),
        )
    for order in dict.fromkeys(c.order for c in met):
        mine = [c for c in met if c.order == order]
        yield say(
            "{name}: loaded, without the line, order {order} meets {frequencies} Hz at {speeds} "
            "rpm.",
            name=say(v.name), order=order,
            frequencies=say.join(*(say.number(c.frequency) for c in mine)),
            speeds=say.join(*(say.number(c.speed / rpm) for c in mine)),
        )  # fmt: skip


def forced_response_sentences(v: ShapeAssessment, say: Translator = ENGLISH) -> Iterator[str]:
    """Yield how the line swings on rubber and bracket, and where that stresses most."""
    if v.forced_response is None:
        yield say(
            "{name}: loads are quasi-static. The response over speed needs the rubber of the "
            "bearing (rubber_N_mm of the bracket, or the bearing's stiffness) and a tube of each "
            "shaft.", name=say(v.name),
        )  # fmt: skip
        return
    of = v.forced_response.sweep
    low = [
        f"{say(name)} {say.number(float(f))} Hz"
        for name, f in zip(of.mode_names, of.frequencies, strict=True)
    ]
    told = low[: 1 + next((k for k, n in enumerate(of.mode_names) if n == "bracket"), len(low))]
    yield say(
        "{name}: on rubber and bracket the line swings at {list}.",
        name=say(v.name), list=say.join(*told),
    )  # fmt: skip
    c, q, k = v.forced_response.worst
    yield say(
        "{name}: order 2 and up stress {part} by ± {stress} MPa at {speed} rpm, {state}, {gear}; "
        "in a rigid bracket by at most {rigid}.",
        name=say(v.name),
        part=say.part(v.features[k].part),
        stress=say.number(float(v.forced_response.stress[c, q, k]) / MPa),
        speed=say.compact_number(round(float(of.speed[q]) / rpm)),
        state=say.state(of.state),
        gear=torque_curve_name(of, c, say),
        rigid=say.number(float(np.nanmax(v.forced_response.rigid_stress[..., k])) / MPa),
    )


def finite_element_solution_remarks(
    of: BracketResult, v: ShapeAssessment, say: Translator = ENGLISH
) -> Iterator[str]:
    """Yield what a reader must know of how a variant was solved, and what was read from it."""
    if v.solved.fillet:
        drawn, taken = (say.number(r / mm) for r in v.solved.fillet)
        yield say(
            "{name}: solved with a fillet of {taken} mm; the CAD kernel breaks on the {drawn} mm "
            "drawn.", name=say(v.name), taken=taken, drawn=drawn,
        )  # fmt: skip
    for p in v.solved.face_selections:
        area = say.number(p.area / mm**2)
        faces = say.count("{count} face", "{count} faces", p.face_count)
        if p.radius:
            yield say(
                "{name}: {pick} is a bore of {radius} mm radius, {faces}, {area} mm².",
                name=say(v.name), pick=p.name, radius=say.number(p.radius / mm), faces=faces,
                area=area,
            )  # fmt: skip
        else:
            yield say(
                "{name}: {pick} is {faces}, {area} mm².",
                name=say(v.name), pick=p.name, faces=faces, area=area,
            )  # fmt: skip
    for axis, k, given in zip("zy", (2, 1), of.series_stiffness or (), strict=False):
        own = 1 / v.compliance[k, k]
        if given > own * RIGID_MOUNT_STIFFNESS_RATIO / (1 + RIGID_MOUNT_STIFFNESS_RATIO):
            yield say(
                "{name}: the bearing's stiffness_N_mm, of rubber and bracket in series, is {given} "
                "N/mm along {axis}, and the bracket alone gives {own}: its rubber is taken as "
                "rigid that way.",
                name=say(v.name), axis=axis, given=say.number(given / (N / mm)),
                own=say.number(own / (N / mm)),
            )  # fmt: skip
    for one, found in recordings_read_from_gauges(of, v):
        x, y, z = (say.number(n) for n in found.noise)
        means = (
            "{name}: the forces of {recording} were read from gauges; a microstrain of noise is "
            "{x} N along x, {y} along y and {z} along z, and how much of what they read no force "
            "explains is not known here (condition {condition})."
            if one.strain is None
            else "{name}: the forces of {recording} are read from gauges; a microstrain of noise "
            "is {x} N along x, {y} along y and {z} along z, and {left} microstrain of what they "
            "read no force explains (condition {condition})."
        )
        yield say(
            means, name=say(v.name), recording=one.name, x=x, y=y, z=z,
            condition=say.number(found.condition),
            left=say.number(1e6 * root_mean_square(found.residual)),
        )  # fmt: skip
        x, y, z = (say.number(n) for n in found.load_error)
        yield say(
            "{name}: where they are largest, those forces may be off by {x} N along x, {y} along y "
            "and {z} along z: by the mesh, by where and how gauges are glued and 1 % of what they "
            "read, or by what no force explains where that is more.",
            name=say(v.name), x=x, y=y, z=z,
        )  # fmt: skip


def life_bounds_note(say: Translator) -> str:
    """Return by what a life lies between the hours in brackets, and by what it may not."""
    return say(
        "Hours in brackets: by the error of stresses, by the flange held the more favourable "
        "way, and by what gauges read wrong where forces are read from them. Curve, rubber and "
        "other loads are taken to be right."
    )


def hours_text(value: float, say: Translator, within: Iterable[float] = (np.nan, np.nan)) -> str:
    """Return hours to failure; beyond a million they mean nothing, and no vehicle runs them.

    In brackets between what they lie, where that is known.
    """
    if np.isnan(value):
        return "-"
    told = (
        f"> {say.number(MAX_PRINTED_HOURS)}"
        if value > MAX_PRINTED_HOURS
        else _three_digits(value, say)
    )
    low, high = within
    if np.isnan(low) or low > MAX_PRINTED_HOURS:
        return told
    ends = _three_digits(low, say), "∞" if high > MAX_PRINTED_HOURS else _three_digits(high, say)
    return f"{told}\N{NO-BREAK SPACE}({ends[0]}…{ends[1]})"


def _three_digits(value: float, say: Translator) -> str:
    """Return hours to three digits, thousands of them written out."""
    told = f"{value:.3g}"
    return f"{float(told):.0f}" if "e+" in told else say.with_decimal_sign(told)


def uncertain_stress_notes(v: ShapeAssessment, say: Translator) -> Iterator[str]:
    """Yield which places shown are known to more than a quarter only, and what would show more."""
    if parts := [
        say.part(f.part)
        for f in v.listed_features
        if f.error > ASSUMED_STRESS_ERROR_SHARE_UNREFINED
    ]:
        yield say(
            "{parts}: error above a quarter; two thirds of the present `element_mm` (default: "
            "one and a half thicknesses) reduce it.", parts=", ".join(parts),
        )  # fmt: skip


def contact_recommendation(
    of: BracketResult, found: Iterable[Check], say: Translator
) -> Iterator[str]:
    """Yield how to request contact, if the two ways of holding give two verdicts or lives."""
    if not any(BOLT_CONTACT_SETTLED_BY_KEY in c.deciding_inputs for c in found):
        return
    shape = of.bracket.shape
    hole = _STEP_BOLT_HOLE_DIAMETER if isinstance(shape, StepFileShape) else shape.bolt_diameter
    usual = Bolts(preload=default_bolt_preload(hole))
    yield say(
        "Held in the more favourable way, sliding or clamped, the flange has another verdict, or "
        "a life several times as long. In contact with the frame it has one answer, whose stress "
        "may be {share} % lower at most: write `{key}` in `bracket`, with what your bolts have.",
        share=f"{100 * (1 - MIN_CONTACT_TO_COMPUTED_STRESS_RATIO):.0f}",
        key=f"bolts: {{preload_kN: {usual.preload / kN:.2g}, friction: {usual.friction}}}",
    )  # fmt: skip


def contact_notes(v: ShapeAssessment, say: Translator) -> Iterator[str]:
    """Yield what contact made of fatigue and life, if requested."""
    if v.contact_result is not None and v.contact_result.when is not None:
        yield _in_bolts(v, v.contact_result, v.contact_result.when, say)
    yield from bolt_slip_notes(v, say)


def bolt_slip_notes(v: ShapeAssessment, say: Translator) -> Iterator[str]:
    """Yield under which cases, and over which duty cycle, the bolts slip or open."""
    if slip := [say.occasion(s.when) for s in v.bolt_slips if s.utilisation > 1]:
        yield say(
            "{cases}: the bolts slip or open. The results are those of a flange that holds.",
            cases=say.join(*slip),
        )  # fmt: skip


def _in_bolts(
    v: ShapeAssessment, of: ContactResult, when: EvaluationCondition, say: Translator
) -> str:
    """Return what contact made of fatigue and life, next to the two ways the flange is held."""
    use = next(o.utilisation for o in v.case_results if o.case.when == when)
    k, f = int(np.nanargmax(of.utilisation_without_contact)), int(np.nanargmax(use))
    told = say(
        "In bolts of {preload} kN, with contact and a friction of {friction}, {case} uses "
        "{share} % of the fatigue limit, at {part}; by the worse of a sliding and a clamped flange "
        "{more} %, at {other}. Fatigue and life are those in contact, with the worse of a hard "
        "frame and one that gives as thick steel does, and {added} % more, as far as it may be "
        "wrong; "
        "stresses are not.",
        preload=say.number(of.bolts.preload / kN), friction=say.number(of.bolts.friction),
        added=f"{100 * MAX_CONTACT_STRESS_ERROR_SHARE:.0f}",
        case=say.occasion(when), share=f"{100 * use[f]:.0f}",
        part=say.part(v.features[f].part), more=f"{100 * of.utilisation_without_contact[k]:.0f}",
        other=say.part(v.features[k].part),
    )  # fmt: skip
    if np.isnan(of.life_without_contact):
        return told
    return (
        told
        + " "
        + say("Life by those: {hours} h.", hours=hours_text(of.life_without_contact, say))
    )


def joint_face_lift_off_notes(v: ShapeAssessment, say: Translator) -> Iterator[str]:
    """Yield of which cases shown the two ways to be held have the truth not between them."""
    cases = [say.occasion(o.case.when) for o in most_stressed_cases(v) if o.pulls_off]
    if cases:
        yield say(
            "Pulled straight off the frame: {cases}. Flexible bolts make the flange softer than "
            "the softer of its two supports: by 11 % on a U of 6 mm compared with contact, with "
            "a seventh more stress in a cut edge next to the washers.",
            cases=say.join(*cases),
        )
        if v.contact_result is None:
            yield say("With `bolts` what swings is judged in contact.")


def stop_notes(v: ShapeAssessment, say: Translator) -> Iterator[str]:
    """Yield under which loads the rubber is beyond its stop: what follows is a lower bound."""
    cases = [o.case.when for o in v.case_results if o.case.stop_margin < 0]
    cases += [e.when for e in v.duty_damage if e.stop_margin < 0]
    if cases:
        yield say(
            "{cases}: rubber goes beyond its stop. Forces are lower bounds (≥), so stresses are at "
            "least, and lives at most, those of linear rubber: no check of them passes.",
            cases=say.join(*dict.fromkeys(map(say.occasion, cases))),
        )


def large_displacement_notes(v: ShapeAssessment, say: Translator) -> Iterator[str]:
    """Yield which cases move the seat by more than small strains can mean."""
    size = float(np.ptp(v.solved.nodes.points, axis=0).max())
    if far := [o for o in v.case_results if o.seat_displacement > _MAX_SEAT_MOTION_SHARE * size]:
        worst = max(far, key=lambda o: o.seat_displacement)
        yield say(
            "{case} moves the bearing's seat by {motion} mm, of a bracket {size} mm large: linear "
            "elasticity means nothing there. Look at its loads.",
            case=say.occasion(worst.case.when), motion=say.number(worst.seat_displacement / mm),
            size=f"{size / mm:.0f}",
        )  # fmt: skip


def damage_method_sentence(of: BracketResult, say: Translator) -> str:
    """Return how damage is counted."""
    material = of.bracket.material
    if not material.ultimate_strength:
        return say("Damage: rainflow and Miner, 2k - 1 beyond the knee, mean stress not counted.")
    if material.metal == "steel":
        return say("Damage: rainflow and Miner, 2k - 1 beyond the knee, mean stress by Goodman.")
    return say(
        "Damage: rainflow and Miner, 2k - 1 beyond the knee, mean stress by Goodman, or by the "
        "FKM guideline where that makes more of it."
    )


def unknown_strength_notes(of: BracketResult, v: ShapeAssessment, say: Translator) -> Iterator[str]:
    """Yield zones of unknown strength, and those that a weld's heat makes softer."""
    material, found = of.bracket.material, fatigue_strength_by_zone(of.bracket)
    for zone in dict.fromkeys(f.zone for f in v.features if found and f.zone not in found):
        yield say(
            "{zone}: not evaluated: no code gives the strength of {metal}; give {key}.",
            zone=say(zone),
            metal=say(material.metal),
            key=f"bracket.fatigue.{zone_curve_key(zone)}",
        )
    if any(f.beside_weld for f in v.features):
        beside = material.yield_strength_at_weld
        yield (
            say("Next to a weld {material} yields at {stress} MPa: its heat reaches 20 to 40 mm.",
                material=material.name, stress=say.number(beside / MPa))
            if beside
            else say("The heat of a weld makes {material} softer, 20 to 40 mm around it, by an "
                     "unknown amount: give its welded_yield_MPa.", material=material.name)
        )  # fmt: skip


def number_range_text(low: float, high: float) -> str:
    """Return a smallest and a largest number as a span, or one number where they are one."""
    same = abs(high - low) <= 1e-6 * max(abs(low), abs(high))
    return f"{high:.1f}" if same else f"{low:.1f} … {high:.1f}"


def utilisation_label(of: BracketResult, say: Translator) -> str:
    """Return what the largest use of the fatigue limit is called: of all zones, or those known."""
    if any(np.isnan(max_fatigue_utilisation(v)).any() for v in of.variants):
        return say("use of the fatigue limit, worst zone known, %")
    return say("use of the fatigue limit, worst zone, %")


def variant_comparison_sentence(
    before: ShapeAssessment, after: ShapeAssessment, say: Translator = ENGLISH
) -> str:
    """Return whether a variant is better, which it is only where its worst zone is.

    By life over the duty cycle or under what was recorded, else by the use of the fatigue limit,
    else by stress. Unknown if a zone without a known curve is stressed no less.
    """
    lasts, uses = (
        [f(v) for v in (before, after)] for f in (feature_hours_to_failure, max_fatigue_utilisation)
    )
    if all(any_known(x) for x in lasts):
        was, now = (float(np.nanmin(x)) for x in lasts)
        gain, worst = now > was, int(np.nanargmin(lasts[1]))
        ends = {"was": first_failure_text(before, say), "now": first_failure_text(after, say)}
        what = say("{was} h before, {now} h after", **ends)
    elif all(any_known(x) for x in uses):
        was, now = (float(np.nanmax(x)) for x in uses)
        gain, worst = now < was, int(np.nanargmax(uses[1]))
        what = say(
            "{was} % of the fatigue limit before, {now} % after",
            was=say.number(100 * was), now=say.number(100 * now),
        )  # fmt: skip
    else:
        stress = highest_stress(after)[0]
        was, now = (float(v.worst_case.feature_stress.max()) / MPa for v in (before, after))
        gain, worst = now < was, int(stress.argmax())
        what = say("{was} MPa before, {now} MPa after", was=say.number(was), now=say.number(now))
    told = {"what": what, "part": say.part(after.features[worst].part)}
    if not gain:
        found = say("At its worst zone the variant is not better: {what} ({part}).", **told)
    elif (part := _unknown_part_stressed_no_less(before, after)) is not None:
        found = say(
            "Comparison undetermined: the strength of {other}, stressed no less than before, is "
            "unknown. At the worst zone of known strength: {what} ({part}).",
            other=say.part(part), **told,
        )  # fmt: skip
    else:
        found = say("At its worst zone the variant is better: {what} ({part}).", **told)
    return found + " " + say("Limits apply to the original: the variant has no verdict.")


def first_failure_text(v: ShapeAssessment, say: Translator) -> str:
    """Return the hours to the first failure of what is known, and between what they lie."""
    within = np.min([e.hours_bounds for e in v.life_results], axis=0)
    return hours_text(float(np.nanmin(feature_hours_to_failure(v))), say, within)


def _unknown_part_stressed_no_less(before: ShapeAssessment, after: ShapeAssessment) -> Part | None:
    """Return what is stressed no less than its zone was, and is of unknown strength; else None."""
    use = max_fatigue_utilisation(after)
    if not any_known(use):
        return None
    stress, old = highest_stress(after)[0], highest_stress(before)[0]
    for k in np.argsort(-stress).tolist():
        zone = after.features[k].zone
        was = max(
            (s for s, f in zip(old, before.features, strict=True) if f.zone == zone), default=0
        )
        if np.isnan(use[k]) and stress[k] > 0 and stress[k] >= was:
            return after.features[k].part
    return None
