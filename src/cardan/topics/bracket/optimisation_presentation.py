"""The search for the lightest bracket, as a terminal's table and the JSON contract."""

from collections.abc import Iterator
from typing import Any

import numpy as np

from cardan.core.units import mm
from cardan.model.application import Application
from cardan.render.i18n import ENGLISH, Translator
from cardan.render.json_contract import JSON_FORMAT_VERSION, check_json, to_json_types
from cardan.render.phrases import check_location
from cardan.render.terminal import BOLD_CODE, RESET_CODE
from cardan.render.text_layout import DEFAULT_WIDTH_COLUMNS, fold_lines, table_lines
from cardan.topics.bracket.optimisation import (
    EvaluatedBracketDimensions,
    OptimisationResult,
    sizes_label,
)
from cardan.topics.bracket.phrases import hours_text


def terminal_lines(
    of: Application,
    found: OptimisationResult,
    say: Translator = ENGLISH,
    *,
    width: int = DEFAULT_WIDTH_COLUMNS,
) -> Iterator[str]:
    """Yield what was chosen, and what was tried on the way, for a screen of a width."""
    title = say(
        "{title}: the lightest bracket that lives {hours} h",
        title=of.title, hours=say.number(found.target_hours),
    )  # fmt: skip
    many = say(
        "{tried} of {count} sets of sizes were solved; a thicker sheet is taken to live no "
        "shorter.",
        tried=len({sizes_label(t.sizes) for t in found.evaluated}),
        count=found.combination_count,
    )
    refused = (
        say("{sizes}: left out, {why}", sizes=bracket_sizes_text(sizes, say), why=why)
        for sizes, why in found.rejected
    )
    yield from (f"{BOLD_CODE}{line}{RESET_CODE}" for line in fold_lines([title], width))
    yield from fold_lines([many, *refused], width)
    yield ""
    head = ("", say("sizes"), say("worst at"), say("mass, kg"), say("hours"), say("mesh"))
    rows = [
        (
            "*" if t is found.best else "", bracket_sizes_text(t.sizes, say),
            say.part(t.assessment.features[0].part), say.number(t.mass),
            hours_text(t.life, say, t.assessment.life_hours_bounds),
            say("refined") if t.refined else say("first"),
        )
        for t in sorted(found.evaluated, key=lambda t: (t.mass, t.refined))
    ]  # fmt: skip
    yield from table_lines(head, rows, width, right=(3, 4))
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
    yield from fold_lines([careful], width)
    short = [
        t
        for t in found.evaluated
        if t.refined and t.life >= found.target_hours and not t.has_no_failure
    ]
    for t in short:
        if t.bolt_slip is not None:
            loose = say(
                "{sizes}: lives long enough, but {case} loads its bolts to {share} of what they "
                "hold; that is too much.",
                sizes=bracket_sizes_text(t.sizes, say), case=say.occasion(t.bolt_slip.when),
                share=say.number(t.bolt_slip.utilisation),
            )  # fmt: skip
            yield from fold_lines([loose], width)
        if t.failed_check is not None:
            broken = say(
                "{sizes}: lives long enough, but fails: {limit}, {where}.",
                sizes=bracket_sizes_text(t.sizes, say), limit=say.name(t.failed_check.quantity),
                where=check_location(t.failed_check, say),
            )  # fmt: skip
            yield from fold_lines([broken], width)
    if found.best is not None:
        chosen = say(
            "The lightest: {sizes}, {mass} kg, {hours} h.",
            sizes=bracket_sizes_text(found.best.sizes, say),
            mass=say.number(found.best.mass),
            hours=hours_text(found.best.life, say, found.best.assessment.life_hours_bounds),
        )  # fmt: skip
        yield from fold_lines([chosen], width)
        if found.best.min_life < found.target_hours:
            yield from fold_lines(
                [say("By the error of its stress it may live shorter than that.")], width
            )
    elif short:
        yield say("None of them lives that long and holds.")
    else:
        yield say("None of them lives that long.")


def bracket_sizes_text(sizes: dict[str, float], say: Translator) -> str:
    """Return sizes as people read them, by the keys of the file."""
    return say.with_decimal_sign(", ".join(f"{name}_mm: {v / mm:.6g}" for name, v in sizes.items()))


def json_document(of: Application, found: OptimisationResult) -> dict[str, Any]:
    """Return the search as the JSON contract's document."""
    return to_json_types(
        {
            "cardan": JSON_FORMAT_VERSION,
            "application": of.title,
            "target_hours": found.target_hours,
            "count": found.combination_count,
            "best": None if found.best is None else _tried(found.best),
            "tried": [_tried(t) for t in found.evaluated],
            "refused": [
                {"sizes": {f"{n}_mm": v / mm for n, v in sizes.items()}, "reason": why}
                for sizes, why in found.rejected
            ],
        }
    )


def _tried(t: EvaluatedBracketDimensions) -> dict[str, Any]:
    worst = t.assessment.features[0]
    return {
        "sizes": {f"{name}_mm": v / mm for name, v in t.sizes.items()},
        "mass_kg": t.mass,
        "life_hours": t.life if np.isfinite(t.life) else None,
        "life_hours_within": [
            x if np.isfinite(x) else None for x in t.assessment.life_hours_bounds
        ],
        "refined": t.refined,
        "slip_utilisation": _slips(t),
        "bolts_hold": None if _slips(t) is None else t.bolt_slip is None,
        "fails": None if t.failed_check is None else check_json(t.failed_check),
        "worst": {"zone": worst.zone, "number": worst.number},
    }


def _slips(t: EvaluatedBracketDimensions) -> float | None:
    """Return the largest share of the bolts' strength that a case uses; None if unknown."""
    return max((s.utilisation for s in t.assessment.bolt_slips), default=None)
