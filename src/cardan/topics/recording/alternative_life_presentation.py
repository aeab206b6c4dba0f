"""A gauge judged by strain, by a crack and by odds: terminal, JSON and a table."""

import math
from collections.abc import Iterator, Sequence
from typing import Any

from cardan.render.blocks import Block, Table, Text
from cardan.render.i18n import ENGLISH, Translator
from cardan.topics.recording.alternative_life_models import AlternativeLives


def _number(value: float) -> float | None:
    return float(value) if math.isfinite(value) else None


def json_document(of: AlternativeLives) -> dict[str, Any]:
    """Return it as the JSON contract has it; null is infinite or not known."""
    found: dict[str, Any] = {}
    if of.strain_damage is not None:
        found["strain_life"] = {
            "damage": _number(of.strain_damage),
            "hours": _number(of.strain_hours),
            "largest_strain_amplitude": _number(of.strain_amplitude),
        }
    if of.crack_passages is not None:
        found["crack"] = {"repeats": _number(of.crack_passages), "hours": _number(of.crack_hours)}
    if (odds := of.failure_probability) is not None:
        found["odds"] = {
            "hours": odds.service_hours,
            "beta": None if odds.first_order is None else _number(odds.first_order.beta),
            "first_order": None
            if odds.first_order is None
            else odds.first_order.failure_probability,
            "second_order": None
            if odds.second_order is None
            else odds.second_order.failure_probability,
            "sampled": None if odds.sampled is None else odds.sampled.failure_probability,
            "sampled_error": None if odds.sampled is None else odds.sampled.standard_error,
            "shares": {name: float(share) for name, share in odds.shares.items()},
        }
    if of.sequenced is not None:
        found["in_turn"] = json_document(of.sequenced)
    return found


def _by_itself(of: AlternativeLives, say: Translator) -> Iterator[tuple[str, AlternativeLives]]:
    """Yield it and, of a mix, what it comes to with its parts driven in turn, by name."""
    yield of.gauge, of
    if of.sequenced is not None:
        yield say("{gauge}, parts driven in turn", gauge=of.gauge), of.sequenced


def text_lines(of: AlternativeLives, say: Translator = ENGLISH) -> Iterator[str]:
    """Yield it as lines of text."""
    for name, one in _by_itself(of, say):
        yield from _lines(name, one, say)


def _lines(gauge: str, of: AlternativeLives, say: Translator) -> Iterator[str]:
    def long(hours: float) -> str:
        if math.isnan(hours):
            return say("not known")
        return say.compact_number(hours, 4) if math.isfinite(hours) else say("no end")

    if of.strain_damage is not None:
        yield say(
            "{gauge}: by its local strain, with memory, a crack is there after {hours} h: damage "
            "{damage} of the recording, strain amplitude up to {strain} %",
            gauge=gauge,
            hours=long(of.strain_hours),
            damage=say.significant_number(of.strain_damage, 4),
            strain=say.compact_number(100 * of.strain_amplitude, 3),
        )
    if of.crack_passages is not None:
        yield say(
            "{gauge}: the crack grows to its end in {hours} h", gauge=gauge,
            hours=long(of.crack_hours),
        )  # fmt: skip
    odds = of.failure_probability
    if odds is None:
        return
    if odds.first_order is None or odds.sampled is None:
        yield say(
            "{gauge}: odds of failure in {hours} h: no likeliest failure was found",
            gauge=gauge, hours=say.compact_number(odds.service_hours),
        )  # fmt: skip
        return
    yield say(
        "{gauge}: odds of failure in {hours} h: {first} by first order, {second} by second order, "
        "{sampled} ± {error} sampled (β {beta}); of the doubt, {shares}",
        gauge=gauge,
        hours=say.compact_number(odds.service_hours),
        first=say.significant_number(odds.first_order.failure_probability, 3),
        second="-"
        if odds.second_order is None
        else say.significant_number(odds.second_order.failure_probability, 3),
        sampled=say.significant_number(odds.sampled.failure_probability, 3),
        error=say.significant_number(odds.sampled.standard_error, 2),
        beta=say.compact_number(odds.first_order.beta, 3),
        shares=say.join(*(f"{say(n)} {say.percentage(share)}" for n, share in odds.shares.items())),
    )


def report_blocks(of: Sequence[AlternativeLives], say: Translator) -> Iterator[Block]:
    """Yield it as a report has it."""
    if not of:
        return
    rows = tuple(
        (
            name,
            *(
                "-"
                if math.isnan(v)
                else say.compact_number(v, 4)
                if math.isfinite(v)
                else say("no end")
                for v in (one.strain_hours, one.crack_hours)
            ),
            "-"
            if one.failure_probability is None or one.failure_probability.first_order is None
            else say.significant_number(
                (
                    one.failure_probability.second_order or one.failure_probability.first_order
                ).failure_probability,
                3,
            ),
        )
        for each in of
        for name, one in _by_itself(each, say)
    )
    yield Table(
        caption=say("Judged otherwise: by strain, by a crack, by odds"),
        head=(say("gauge"), say("until a crack, h"), say("growth of the crack, h"),
              say("odds of failure")),
        rows=rows,
    )  # fmt: skip
    yield Text(paragraphs=tuple(line for one in of for line in text_lines(one, say)))
