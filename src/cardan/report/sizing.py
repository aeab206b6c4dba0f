"""Other parts that would do, in words and as the JSON contract has them."""

from collections.abc import Iterator
from textwrap import wrap
from typing import Any

from cardan.base.part import Part
from cardan.base.units import mm
from cardan.base.verdict import Check
from cardan.quantity.quantities import QUANTITIES
from cardan.report import contract
from cardan.report.language import EN, Language
from cardan.report.wording import gaps, how_read, scattered, sentence, survives
from cardan.study.sizing import WAYS, Hopeless, Offer, Remedy, Sizing

WIDTH = 80


def offer(of: Offer, say: Language, *, several: bool = False) -> str:
    """Return an offer in a line: which part in place of which, and what it weighs more."""
    return say.list(place(of, say, several=several), _weight(of, say))


def place(of: Offer, say: Language, *, several: bool = False) -> str:
    """Return which part is offered in place of which."""
    number = say.short(abs(of.amount) / mm, 4)
    match of.kind:
        case "split" if of.amount > 0:
            means = "{parts} and its joint {amount} mm to the rear"
        case "split":
            means = "{parts} and its joint {amount} mm forward"
        case "bearing place" if of.amount > 0:
            means = "{parts} {amount} mm nearer to its rear joint"
        case "bearing place":
            means = "{parts} {amount} mm farther from its rear joint"
        case _ if of.before:
            means = "{parts}: {name} in place of {before}"
        case _:
            means = "{parts}: {name}"
    kinds = {"tube": "shaft", "joint": "joint"}
    where = say.list(*(say.part(Part(kinds.get(of.kind, "centre bearing"), k)) for k in of.parts))  # type: ignore[arg-type]
    name = f"{say(of.kind)} {of.part.name}" if of.part else ""
    said = say(means, parts=where, name=name, before=of.before, amount=number)
    return f"{of.line}: {said}" if several else said


def _weight(of: Offer, say: Language) -> str:
    """Return what a part weighs more or less; nothing of a place."""
    if of.part is None:
        return ""
    if of.mass is None:
        return say("its mass is not published")
    return weight(of.mass, say)


def weight(mass: float, say: Language) -> str:
    """Return how much heavier or lighter something gets."""
    means = "{mass} kg heavier" if mass >= 0 else "{mass} kg lighter"
    return say(means, mass=say.pointed(f"{abs(mass):.1f}"))


def gain(was: Check, now: Check, say: Language) -> str:
    """Return a check as it was and as it is with an offer in place."""
    value = say.number(now.value / QUANTITIES[now.quantity].factor)
    return say("{check}; then {value}, {grade}", check=sentence(was, say), value=value,
               grade=say(now.grade))  # fmt: skip


def instead(of: Remedy, say: Language) -> str:
    """Return what another part gives where nothing can be moved, in a line."""
    _, now = of.answered[0]
    value = say.number(now.value / QUANTITIES[now.quantity].factor)
    weighs = _weight(of.offer, say)
    return say("nothing that can be moved; {offer} gives {value} ({weight})",
               offer=place(of.offer, say), value=value, weight=weighs)  # fmt: skip


def lines(of: Sizing, say: Language = EN) -> Iterator[str]:
    """Yield a sizing as lines of at most 80 columns."""
    title, was, now = of.before.application.title, of.before.verdict, of.approval.verdict
    missed = [u for u in of.before.coverage.missed if u.quantity in WAYS]
    if not of.remedies and not of.hopeless and not missed:
        yield say("{title}: no limit that another part could answer is passed.", title=title)
        return
    several = len(of.before.application.lines) > 1
    yield from _wrapped(
        say("{title}: {was}, with the parts below {now}", title=title, was=say(was).upper(),
            now=say(now).upper())
    )  # fmt: skip
    for k, remedy in enumerate(of.remedies, 1):
        yield ""
        yield from _remedy(remedy, say, lead=f"{k}. ", several=several)
        for other in remedy.others:
            yield from _remedy(other, say, lead=f"   {say('or')} ", several=several)
    if of.remedies:
        yield ""
        known = of.mass is not None
        yield (
            say("All together: {weight}", weight=weight(of.mass or 0.0, say))
            if known
            else say("All together: the mass is not known of every part")
        )
        for one in {r.offer.line: r for r in of.remedies}.values():
            for text in (*survives(one.survival, one.trucks, say), scattered(one.trucks, say)):
                told = say("{line}: {text}", line=one.offer.line, text=text) if several else text
                yield from _wrapped(told if text else "")
    if of.hopeless:
        yield ""
        yield say("Nothing on offer answers")
        for one in of.hopeless:
            yield from _wrapped(hopeless(one, say, several=several), first="  ", then="    ")
    if of.beyond:
        yield ""
        yield say("No part is sought for what fails all the same")
        for one in of.beyond:
            text = f"{one.line}: {sentence(one, say)}" if several else sentence(one, say)
            yield from _wrapped(text, first="  ", then="    ")
    if missed:
        yield ""
        yield from _wrapped(
            say("No part, no size: `cardan catalogue joints --for TORQUE` lists what carries it")
        )
        for gap in gaps(missed, say, several=several):
            yield from _wrapped(gap, first="  ", then="    ")


def _remedy(of: Remedy, say: Language, *, lead: str, several: bool) -> Iterator[str]:
    yield from _wrapped(offer(of.offer, say, several=several), first=lead, then="   ")
    if of.offer.part and (read := how_read(of.offer.part.source, say)):
        yield from _wrapped(f"[{read}]", first="     ", then="     ")
    for was, now in of.answered:
        yield from _wrapped(gain(was, now, say), first="     ", then="       ")
    for one in of.worse:
        text = say("but then: {check}", check=sentence(one, say))
        yield from _wrapped(text, first="     ", then="       ")


def hopeless(of: Hopeless, say: Language, *, several: bool = False) -> str:
    """Return a check that nothing on offer answers, and what stands in the way."""
    said = sentence(of.problem, say)
    said = f"{of.problem.line}: {said}" if several else said
    if of.offer is None or of.fails is None:
        return said
    return say(
        "{check} ({offer} would, but fails: {fails})", check=said,
        offer=offer(of.offer, say), fails=sentence(of.fails, say),
    )  # fmt: skip


def _wrapped(text: str, *, first: str = "", then: str = "  ") -> list[str]:
    return wrap(
        text,
        WIDTH,
        initial_indent=first,
        subsequent_indent=then,
        break_long_words=False,
        break_on_hyphens=False,
    )


# --------------------------------------------------------------------------- the contract


def document(of: Sizing) -> dict[str, Any]:
    """Return a sizing as the JSON contract has it; null is not known."""
    return contract.plain(
        {
            "verdict_before": of.before.verdict,
            "verdict": of.approval.verdict,
            "mass_kg": of.mass,
            "remedies": [_document(r) for r in of.remedies],
            "hopeless": [
                {
                    "check": contract.check(h.problem),
                    "nearest": None if h.offer is None else _offer(h.offer),
                    "fails": None if h.fails is None else contract.check(h.fails),
                }
                for h in of.hopeless
            ],
            "checks": [contract.check(c) for c in of.approval.checks],
            "unanswered": [contract.unanswered(u) for u in of.approval.coverage.unanswered],
        }
    )


def _offer(of: Offer) -> dict[str, Any]:
    source = of.part.source if of.part else None
    return {
        "line": of.line,
        "kind": of.kind,
        "parts": list(of.parts),
        "name": of.part.name if of.part else None,
        "in_place_of": of.before or None,
        "rearward_mm": None if of.part else of.amount / mm,
        "mass_kg": of.mass,
        "source": str(source) if source else None,
        "how_read": source.how_read or None if source else None,
    }


def _document(of: Remedy) -> dict[str, Any]:
    return {
        **_offer(of.offer),
        "answers": [
            {"before": contract.check(was), "after": contract.check(now)}
            for was, now in of.answered
        ],
        "worse": [contract.check(c) for c in of.worse],
        "survival": contract.survival(of.survival, of.trucks),
        "others": [_document(o) for o in of.others],
    }
