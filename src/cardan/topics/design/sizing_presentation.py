"""Other parts that would do, in words and as the JSON contract has them."""

from collections.abc import Iterator
from textwrap import wrap
from typing import Any

from cardan.checks.quantities.registry import QUANTITIES
from cardan.core.labels import Part
from cardan.core.units import deg, mm
from cardan.core.verdict import Check
from cardan.render.i18n import ENGLISH, Translator
from cardan.render.json_contract import check_json, to_json_types, unevaluated_json
from cardan.render.phrases import (
    check_sentence,
    grade_text,
    grouped_unevaluated_lines,
    limit_sense_symbol,
    source_digitisation_phrase,
    verdict_text,
    worst_check_per_limit,
)
from cardan.render.terminal import aligned_column_lines
from cardan.topics.design.corrections_json_presentation import production_yield_json
from cardan.topics.design.phrases import production_tolerance_sentence, tolerance_yield_sentences
from cardan.topics.design.sizing import (
    PROPOSAL_KINDS_BY_QUANTITY,
    FurtherShaft,
    PartProposal,
    Remedy,
    SizingResult,
    UnresolvedCheck,
)

LINE_WIDTH_COLUMNS = 80


def offer_phrase(of: PartProposal, say: Translator, *, several: bool = False) -> str:
    """Return an offer in a line: which part in place of which, and what it weighs more."""
    return say.join(offer_description(of, say, several=several), _weight(of, say))


def offer_description(of: PartProposal, say: Translator, *, several: bool = False) -> str:
    """Return which part is offered in place of which."""
    number = say.compact_number(abs(of.rearward_shift) / mm, 4)
    if of.further_shaft is not None:
        said = _further_shaft_phrase(of, say)
        return f"{of.line}: {said}" if several else said
    match of.kind:
        case "split" if of.rearward_shift > 0:
            means = "{parts} and its joint {amount} mm to the rear"
        case "split":
            means = "{parts} and its joint {amount} mm forward"
        case "bearing place" if of.rearward_shift > 0:
            means = "{parts} {amount} mm nearer to its rear joint"
        case "bearing place":
            means = "{parts} {amount} mm farther from its rear joint"
        case _ if of.replaced_part_name:
            means = "{parts}: {name} in place of {before}"
        case _:
            means = "{parts}: {name}"
    kinds = {"tube": "shaft", "joint": "joint"}
    where = say.join(
        *(
            say.part(Part(kinds.get(of.kind, "centre bearing"), k))  # type: ignore[arg-type]
            for k in of.part_numbers
        )
    )
    name = f"{say(of.kind)} {of.part.name}" if of.part else ""
    said = say(means, parts=where, name=name, before=of.replaced_part_name, amount=number)
    return f"{of.line}: {said}" if several else said


def _further_shaft_phrase(of: PartProposal, say: Translator) -> str:
    """Return how a shaft is made two: lengths, joint, yoke phase and centre bearing."""
    further = of.further_shaft
    assert further is not None
    front, rear, height, ahead = (
        say.compact_number(abs(v) / mm, 4)
        for v in (*further.lengths, further.height, further.bearing.from_rear_joint)
    )
    means = (
        "{part}: two shafts of {front} and {rear} mm in its place; the joint between them {height} "
        "mm above the straight line, the front shaft's yokes at {phase} deg, its centre bearing "
        "{ahead} mm ahead of the joint"
        if further.height > 0
        else "{part}: two shafts of {front} and {rear} mm in its place; the joint between them "
        "{height} mm below the straight line, the front shaft's yokes at {phase} deg, its centre "
        "bearing {ahead} mm ahead of the joint"
    )
    return say(
        means, part=say.part(Part("shaft", of.part_numbers[0])), front=front, rear=rear,
        height=height, phase=say.compact_number(further.phase / deg, 4), ahead=ahead,
    )  # fmt: skip


def _further_shaft_table(of: SizingResult, say: Translator) -> Iterator[str]:
    """Yield the limits of lines with a further shaft, today next to the proposal."""
    for line, approval in of.further_shafts.items():
        today, proposed = (
            {
                (c.quantity, c.limit): c
                for c in worst_check_per_limit(c for c in a.checks if c.line == line)
            }
            for a in (of.approval_before, approval)
        )
        rows = [("", say("today"), say("proposed"), say("limit"))]
        for key, now in proposed.items():
            was, unit = today.get(key), QUANTITIES[now.quantity].unit_symbol
            factor, limit = QUANTITIES[now.quantity].si_factor, now.limit
            before, after = (
                "-"
                if c is None
                else f"{say.number(c.value / factor, 3)} {grade_text(c.grade, say)}"
                for c in (was, now)
            )
            both = [b for b in (limit.normal, limit.maximum) if b is not None] or [now.bound]
            bounds = " | ".join(say.number(b / factor, 3) for b in both)
            bound = f"{limit_sense_symbol(now, say)} {bounds} {unit}"
            name = say.name(now.quantity)
            if sum(quantity == now.quantity for quantity, _ in proposed) > 1:
                is_maximum = limit.normal is None and limit.band is None
                name += f" ({say('maximum' if is_maximum else 'recommended')})"
            rows.append((name, before, after, bound.rstrip()))
        yield ""
        yield say("Line {line}, today and with the further shaft", line=line)
        yield from (f"  {line}" for line in aligned_column_lines(rows, words=(0, 3)))


def _weight(of: PartProposal, say: Translator) -> str:
    """Return what a part weighs more or less; nothing of a place."""
    if of.part is None:
        return ""
    if of.mass_change is None:
        return say("its mass is not published")
    return mass_change_phrase(of.mass_change, say)


def mass_change_phrase(mass: float, say: Translator) -> str:
    """Return how much heavier or lighter something gets."""
    means = "{mass} kg heavier" if mass >= 0 else "{mass} kg lighter"
    return say(means, mass=say.with_decimal_sign(f"{abs(mass):.1f}"))


def check_change_sentence(was: Check, now: Check, say: Translator) -> str:
    """Return a check as it was and as it is with an offer in place."""
    value = say.number(now.value / QUANTITIES[now.quantity].si_factor)
    return say("{check}; then {value}, {grade}", check=check_sentence(was, say), value=value,
               grade=grade_text(now.grade, say))  # fmt: skip


def next_size_advice(of: Remedy, say: Translator) -> str:
    """Return what another part gives where nothing can be moved, in a line."""
    _, now = of.resolved_checks[0]
    value = say.number(now.value / QUANTITIES[now.quantity].si_factor)
    weighs = _weight(of.offer, say)
    return say("nothing that can be moved; {offer} gives {value} ({weight})",
               offer=offer_description(of.offer, say), value=value, weight=weighs)  # fmt: skip


def text_lines(of: SizingResult, say: Translator = ENGLISH) -> Iterator[str]:
    """Yield a sizing as lines of at most 80 columns."""
    title = of.approval_before.application.title
    missed = [
        u
        for u in of.approval_before.coverage.missing_required
        if u.quantity in PROPOSAL_KINDS_BY_QUANTITY
    ]
    if not of.remedies and not of.unresolved and not missed:
        yield say("{title}: no limit that another part could answer is passed.", title=title)
        return
    several = len(of.approval_before.application.lines) > 1
    yield from _wrapped(
        say("{title}: {was}, with the parts below {now}", title=title,
            was=verdict_text(of.approval_before, say), now=verdict_text(of.approval, say))
    )  # fmt: skip
    for k, remedy in enumerate(of.remedies, 1):
        yield ""
        yield from _remedy(remedy, say, lead=f"{k}. ", several=several)
        for other in remedy.alternatives:
            yield from _remedy(other, say, lead=f"   {say('or')} ", several=several)
    if of.remedies:
        yield ""
        known = of.mass_change is not None
        yield (
            say("All together: {weight}", weight=mass_change_phrase(of.mass_change or 0.0, say))
            if known
            else say("All together: the mass is not known of every part")
        )
        for one in {r.offer.line: r for r in of.remedies}.values():
            for text in (
                *tolerance_yield_sentences(one.tolerance_yield, one.tolerance_model, say),
                production_tolerance_sentence(one.tolerance_model, say),
            ):
                told = say("{line}: {text}", line=one.offer.line, text=text) if several else text
                yield from _wrapped(told if text else "")
    yield from _further_shaft_table(of, say)
    if of.unresolved:
        yield ""
        yield say("Nothing on offer answers")
        for one in of.unresolved:
            yield from _wrapped(
                unresolved_check_sentence(one, say, several=several), first="  ", then="    "
            )
    if of.failures_without_remedy:
        yield ""
        yield say("No part is sought for what fails all the same")
        for one in of.failures_without_remedy:
            text = (
                f"{one.line}: {check_sentence(one, say)}" if several else check_sentence(one, say)
            )
            yield from _wrapped(text, first="  ", then="    ")
    if missed:
        yield ""
        yield from _wrapped(
            say("No part, no size: `cardan catalogue joints --for TORQUE` lists what carries it")
        )
        for gap in grouped_unevaluated_lines(missed, say, several=several):
            yield from _wrapped(gap, first="  ", then="    ")


def _remedy(of: Remedy, say: Translator, *, lead: str, several: bool) -> Iterator[str]:
    yield from _wrapped(offer_phrase(of.offer, say, several=several), first=lead, then="   ")
    if of.offer.part and (read := source_digitisation_phrase(of.offer.part.source, say)):
        yield from _wrapped(f"[{read}]", first="     ", then="     ")
    for was, now in of.resolved_checks:
        yield from _wrapped(check_change_sentence(was, now, say), first="     ", then="       ")
    for one in of.worsened_checks:
        text = say("but then: {check}", check=check_sentence(one, say))
        yield from _wrapped(text, first="     ", then="       ")


def unresolved_check_sentence(
    of: UnresolvedCheck, say: Translator, *, several: bool = False
) -> str:
    """Return a check that nothing on offer answers, and what stands in the way."""
    said = check_sentence(of.check, say)
    said = f"{of.check.line}: {said}" if several else said
    if of.offer is None or of.newly_failing_check is None:
        return said
    return say(
        "{check} ({offer} would, but fails: {fails})", check=said,
        offer=offer_phrase(of.offer, say), fails=check_sentence(of.newly_failing_check, say),
    )  # fmt: skip


def _wrapped(text: str, *, first: str = "", then: str = "  ") -> list[str]:
    return wrap(
        text,
        LINE_WIDTH_COLUMNS,
        initial_indent=first,
        subsequent_indent=then,
        break_long_words=False,
        break_on_hyphens=False,
    )


# --------------------------------------------------------------------------- the contract


def json_document(of: SizingResult) -> dict[str, Any]:
    """Return a sizing as the JSON contract has it; null is not known."""
    return to_json_types(
        {
            "verdict_before": of.approval_before.verdict,
            "verdict": of.approval.verdict,
            "mass_kg": of.mass_change,
            "remedies": [_document(r) for r in of.remedies],
            "hopeless": [
                {
                    "check": check_json(h.check),
                    "nearest": None if h.offer is None else _offer(h.offer),
                    "fails": None
                    if h.newly_failing_check is None
                    else check_json(h.newly_failing_check),
                }
                for h in of.unresolved
            ],
            "checks": [check_json(c) for c in of.approval.checks],
            "unanswered": [unevaluated_json(u) for u in of.approval.coverage.unevaluated],
        }
    )


def _offer(of: PartProposal) -> dict[str, Any]:
    source = of.part.source if of.part else None
    return {
        "line": of.line,
        "kind": of.kind,
        "parts": list(of.part_numbers),
        "name": of.part.name if of.part else None,
        "in_place_of": of.replaced_part_name or None,
        "rearward_mm": None if of.part else of.rearward_shift / mm,
        "mass_kg": of.mass_change,
        **({} if of.further_shaft is None else {"further_shaft": _further_shaft(of.further_shaft)}),
        "source": str(source) if source else None,
        "how_read": source.how_read or None if source else None,
    }


def _further_shaft(of: FurtherShaft) -> dict[str, Any]:
    return {
        "lengths_mm": [length / mm for length in of.lengths],
        "joint_height_mm": of.height / mm,
        "joint_angle_deg": of.joint_angle / deg,
        "front_phase_deg": of.phase / deg,
        "bearing_from_rear_joint_mm": of.bearing.from_rear_joint / mm,
    }


def _document(of: Remedy) -> dict[str, Any]:
    return {
        **_offer(of.offer),
        "answers": [
            {"before": check_json(was), "after": check_json(now)} for was, now in of.resolved_checks
        ],
        "worse": [check_json(c) for c in of.worsened_checks],
        "survival": production_yield_json(of.tolerance_yield, of.tolerance_model),
        "others": [_document(o) for o in of.alternatives],
    }
