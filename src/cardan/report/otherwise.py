"""A gauge judged by strain, by a crack and by odds: terminal, JSON and a table."""

import math
from collections.abc import Iterator, Sequence
from typing import Any

from cardan.report.blocks import Block, Table, Text
from cardan.report.language import EN, Language
from cardan.study.otherwise import Otherwise


def _number(value: float) -> float | None:
    return float(value) if math.isfinite(value) else None


def document(of: Otherwise) -> dict[str, Any]:
    """Return it as the JSON contract has it; null is infinite or not known."""
    found: dict[str, Any] = {}
    if of.strain_damage is not None:
        found["strain_life"] = {
            "damage": _number(of.strain_damage),
            "hours": _number(of.strain_hours),
            "largest_strain_amplitude": _number(of.strain),
        }
    if of.growth is not None:
        found["crack"] = {"repeats": _number(of.growth), "hours": _number(of.crack_hours)}
    if (odds := of.odds) is not None:
        found["odds"] = {
            "hours": odds.hours,
            "beta": None if odds.first is None else _number(odds.first.beta),
            "first_order": None if odds.first is None else odds.first.failure,
            "second_order": None if odds.second is None else odds.second.failure,
            "sampled": None if odds.sampled is None else odds.sampled.failure,
            "sampled_error": None if odds.sampled is None else odds.sampled.error,
            "shares": {name: float(share) for name, share in odds.shares.items()},
        }
    if of.in_turn is not None:
        found["in_turn"] = document(of.in_turn)
    return found


def _by_itself(of: Otherwise, say: Language) -> Iterator[tuple[str, Otherwise]]:
    """Yield it and, of a mix, what it comes to with its parts driven in turn, by name."""
    yield of.gauge, of
    if of.in_turn is not None:
        yield say("{gauge}, parts driven in turn", gauge=of.gauge), of.in_turn


def lines(of: Otherwise, say: Language = EN) -> Iterator[str]:
    """Yield it as lines of text."""
    for name, one in _by_itself(of, say):
        yield from _lines(name, one, say)


def _lines(gauge: str, of: Otherwise, say: Language) -> Iterator[str]:
    def long(hours: float) -> str:
        if math.isnan(hours):
            return say("not known")
        return say.short(hours, 4) if math.isfinite(hours) else say("no end")

    if of.strain_damage is not None:
        yield say(
            "{gauge}: by its local strain, with memory, a crack is there after {hours} h: damage "
            "{damage} of the recording, strain amplitude up to {strain} %",
            gauge=gauge, hours=long(of.strain_hours), damage=say.small(of.strain_damage, 4),
            strain=say.short(100 * of.strain, 3),
        )  # fmt: skip
    if of.growth is not None:
        yield say(
            "{gauge}: the crack grows to its end in {hours} h", gauge=gauge,
            hours=long(of.crack_hours),
        )  # fmt: skip
    odds = of.odds
    if odds is None:
        return
    if odds.first is None or odds.sampled is None:
        yield say(
            "{gauge}: odds of failure in {hours} h: no likeliest failure was found",
            gauge=gauge, hours=say.short(odds.hours),
        )  # fmt: skip
        return
    yield say(
        "{gauge}: odds of failure in {hours} h: {first} by first order, {second} by second order, "
        "{sampled} ± {error} sampled (β {beta}); of the doubt, {shares}",
        gauge=gauge, hours=say.short(odds.hours), first=say.small(odds.first.failure, 3),
        second="-" if odds.second is None else say.small(odds.second.failure, 3),
        sampled=say.small(odds.sampled.failure, 3), error=say.small(odds.sampled.error, 2),
        beta=say.short(odds.first.beta, 3),
        shares=say.list(
            *(f"{say(n)} {say.share(share)}" for n, share in odds.shares.items())
        ),
    )  # fmt: skip


def blocks(of: Sequence[Otherwise], say: Language) -> Iterator[Block]:
    """Yield it as a report has it."""
    if not of:
        return
    rows = tuple(
        (
            name,
            *(
                "-" if math.isnan(v) else say.short(v, 4) if math.isfinite(v) else say("no end")
                for v in (one.strain_hours, one.crack_hours)
            ),
            "-" if one.odds is None or one.odds.first is None
            else say.small((one.odds.second or one.odds.first).failure, 3),
        )
        for each in of for name, one in _by_itself(each, say)
    )  # fmt: skip
    yield Table(
        caption=say("Judged otherwise: by strain, by a crack, by odds"),
        head=(say("gauge"), say("until a crack, h"), say("growth of the crack, h"),
              say("odds of failure")),
        rows=rows,
    )  # fmt: skip
    yield Text(paragraphs=tuple(line for one in of for line in lines(one, say)))
