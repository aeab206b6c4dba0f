"""The search for the lightest bracket, as a terminal's table and the JSON contract."""

from collections.abc import Iterator
from typing import Any

import numpy as np

from cardan.base.units import mm
from cardan.model.application import Application
from cardan.report.bracket import hours
from cardan.report.contract import CONTRACT, check, plain
from cardan.report.language import EN, Language
from cardan.report.screen import WIDTH, folded, table
from cardan.report.terminal import BOLD, PLAIN
from cardan.report.wording import place
from cardan.study.bracket_search import Searched, Tried, named


def terminal(
    of: Application, found: Searched, say: Language = EN, *, width: int = WIDTH
) -> Iterator[str]:
    """Yield what was chosen, and what was tried on the way, for a screen of a width."""
    title = say(
        "{title}: the lightest bracket that lives {hours} h",
        title=of.title, hours=say.number(found.target),
    )  # fmt: skip
    many = say(
        "{tried} of {count} sets of sizes were solved; a thicker sheet is taken to live no "
        "shorter.", tried=len({named(t.sizes) for t in found.tried}), count=found.count,
    )  # fmt: skip
    refused = (
        say("{sizes}: left out, {why}", sizes=said(sizes, say), why=why)
        for sizes, why in found.refused
    )
    yield from (f"{BOLD}{line}{PLAIN}" for line in folded([title], width))
    yield from folded([many, *refused], width)
    yield ""
    head = ("", say("sizes"), say("worst at"), say("mass, kg"), say("hours"), say("mesh"))
    rows = [
        (
            "*" if t is found.best else "", said(t.sizes, say),
            say.part(t.judged.features[0].part), say.number(t.mass),
            hours(t.life, say, t.judged.life_within),
            say("refined") if t.refined else say("first"),
        )
        for t in sorted(found.tried, key=lambda t: (t.mass, t.refined))
    ]  # fmt: skip
    yield from table(head, rows, width, right=(3, 4))
    yield ""
    pair = say(
        "Judged by the worse of a sliding and a clamped flange. With bolts, contact and friction "
        "the gallery's bracket used 11 % less of its fatigue limit, about what one more millimetre "
        "of sheet gives: what is chosen may be that much heavier than it need be."
    )
    bolted = say(
        "Meshes made finer are judged in contact, in their bolts; first ones by the worse of a "
        "sliding and a clamped flange."
    )
    careful = bolted if of.bracket is not None and of.bracket.bolts is not None else pair
    yield from folded([careful], width)
    short = [t for t in found.tried if t.refined and t.life >= found.target and not t.holds]
    for t in short:
        if t.slips is not None:
            loose = say(
                "{sizes}: lives long enough, but {case} asks {share} of what its bolts hold; that "
                "is too much.", sizes=said(t.sizes, say), case=say.occasion(t.slips.when),
                share=say.number(t.slips.share),
            )  # fmt: skip
            yield from folded([loose], width)
        if t.fails is not None:
            broken = say(
                "{sizes}: lives long enough, but fails: {limit}, {where}.",
                sizes=said(t.sizes, say), limit=say.name(t.fails.quantity),
                where=place(t.fails, say),
            )  # fmt: skip
            yield from folded([broken], width)
    if found.best is not None:
        chosen = say(
            "The lightest: {sizes}, {mass} kg, {hours} h.", sizes=said(found.best.sizes, say),
            mass=say.number(found.best.mass),
            hours=hours(found.best.life, say, found.best.judged.life_within),
        )  # fmt: skip
        yield from folded([chosen], width)
        if found.best.at_least < found.target:
            yield from folded(
                [say("By the error of its stress it may live shorter than that.")], width
            )
    elif short:
        yield say("None of them lives that long and holds.")
    else:
        yield say("None of them lives that long.")


def said(sizes: dict[str, float], say: Language) -> str:
    """Return sizes as people read them, by the keys of the file."""
    return say.pointed(", ".join(f"{name}_mm: {v / mm:.6g}" for name, v in sizes.items()))


def contract(of: Application, found: Searched) -> dict[str, Any]:
    """Return the search as the JSON contract's document."""
    return plain(
        {
            "cardan": CONTRACT,
            "application": of.title,
            "target_hours": found.target,
            "count": found.count,
            "best": None if found.best is None else _tried(found.best),
            "tried": [_tried(t) for t in found.tried],
            "refused": [
                {"sizes": {f"{n}_mm": v / mm for n, v in sizes.items()}, "reason": why}
                for sizes, why in found.refused
            ],
        }
    )


def _tried(t: Tried) -> dict[str, Any]:
    worst = t.judged.features[0]
    return {
        "sizes": {f"{name}_mm": v / mm for name, v in t.sizes.items()},
        "mass_kg": t.mass,
        "life_hours": t.life if np.isfinite(t.life) else None,
        "life_hours_within": [x if np.isfinite(x) else None for x in t.judged.life_within],
        "refined": t.refined,
        "slip_utilisation": _slips(t),
        "bolts_hold": None if _slips(t) is None else t.slips is None,
        "fails": None if t.fails is None else check(t.fails),
        "worst": {"zone": worst.zone, "number": worst.number},
    }


def _slips(t: Tried) -> float | None:
    """Return what share of what its bolts hold a case asks at most; None where none says."""
    return max((s.share for s in t.judged.slips), default=None)
