"""When and where a recording did its damage: terminal, JSON and tables."""

import math
from collections.abc import Iterator, Mapping
from typing import Any

from cardan.core.units import MPa, hour
from cardan.physics.signals.damage_extrapolation import UnknownReason
from cardan.physics.signals.usage_profile import UsageBin
from cardan.render.blocks import Block, Table, Text
from cardan.render.i18n import ENGLISH, Translator
from cardan.render.terminal import aligned_column_lines
from cardan.topics.recording.usage import SHORTENED_TEST_DAMAGE_SHARE, UsageDamage

GROUPING_TITLES = {
    "gear": "gear, engine turns a shaft turn",
    "speed": "shaft speed, rpm",
    "torque": "shaft torque, N m",
}
"""What damage is divided by."""

UNASSIGNED_TITLES = {"gear": "in no gear", "speed": "speed not known", "torque": "torque not known"}
"""What is in none of these."""

OPEN_RESIDUE_TITLE = "of no second, open at the end"
"""What is left open."""

UNKNOWN_DAMAGE_RATE_REASON_TEXTS: Mapping[UnknownReason, str] = {
    "short": "the recording is shorter than a minute",
    "blows": "a few blows did much of it; record for longer",
    "road": "the road changed, and its worst was met too seldom; record more of each road",
    "wide": "the interval spans more than a factor of thirty; record for longer",
    "data rejected": "what is wrong with the recording decides it",
}
"""Why its long-run value is unknown."""


def _number(value: float) -> float | None:
    return float(value) if math.isfinite(value) else None


def json_document(of: UsageDamage) -> dict[str, Any]:
    """Return it as the JSON contract has it; null is not known."""
    run = of.long_run
    return {
        "damage_by": {
            sort: [
                {
                    "band": g.name,
                    "damage": g.damage,
                    "share": _number(g.closed_damage_share),
                    "share_of_whole": _number(g.share),
                    "live_s": g.time,
                    "km": _number(g.distance / 1e3),
                    "damage_per_km": _number(g.damage / (g.distance / 1e3))
                    if g.distance > 0
                    else None,
                }
                for g in groups
            ]
            for sort, groups in of.bins.items()
        },
        "damage_by_none": {
            sort: {
                "damage": g.damage,
                "share_of_whole": _number(g.share),
                "live_s": g.time,
                "km": _number(g.distance / 1e3),
            }
            for sort, g in of.unassigned.items()
        },
        "open_share": of.residue_share,
        "open_damage": of.residue_damage,
        "peaks": [
            {
                "MPa": p.stress / MPa,
                "time_s": p.time,
                "km": _number(p.distance / 1e3),
                "rpm": _number(p.speed * 60),
                "torque_Nm": _number(p.torque),
                "gear": p.gear or None,
            }
            for p in of.stress_peaks
        ],
        "damage_per_hour": {
            "recorded": run.recorded_rate * hour,
            "long_run": _number(run.long_term_rate * hour),
            "interval": [_number(end * hour) for end in run.interval],
            "unknown": run.unknown_reason,
        },
        "shortened": {"damage": SHORTENED_TEST_DAMAGE_SHARE, "time": of.shortened_test_share},
        "test_amplitude_MPa": of.equivalent_amplitude / MPa,
    }


def damage_rows(of: UsageDamage, sort: str, say: Translator) -> list[tuple[str, ...]]:
    """Return the damage by a sort as rows that sum to the whole damage, their heads first."""
    known = any(g.distance > 0 for g in of.bins[sort])
    head = (say(GROUPING_TITLES[sort]), say("damage"), say("share"), say("time, min"))
    found = [(*head, say("km"), say("per km")) if known else head]

    def add(name: str, g: UsageBin) -> None:
        row = (
            name,
            say.significant_number(g.damage, 3),
            say.percentage(g.share, 1),
            say.compact_number(g.time / 60, 3),
        )
        per = g.damage / (g.distance / 1e3) if g.distance > 0 else math.nan
        far = "-" if math.isnan(g.distance) else say.compact_number(g.distance / 1e3, 3)
        way = (far, "-" if math.isnan(per) else say.significant_number(per, 3))
        found.append((*row, *way) if known else row)

    for g in sorted(of.bins[sort], key=lambda g: -g.damage):
        add(say.with_decimal_sign(g.name) if sort == "gear" else g.name, g)
    if of.unassigned[sort].time > 0:
        add(say(UNASSIGNED_TITLES[sort]), of.unassigned[sort])
    row = (
        say(OPEN_RESIDUE_TITLE),
        say.significant_number(of.residue_damage, 3),
        say.percentage(of.residue_share, 1),
        "-",
    )
    found.append((*row, "-", "-") if known else row)
    return found


def stress_peak_rows(of: UsageDamage, say: Translator) -> list[tuple[str, ...]]:
    """Return the largest stresses as rows, their heads first."""

    def told(value: float, digits: int = 4) -> str:
        return "-" if math.isnan(value) else say.compact_number(value, digits)

    head = (say("largest stresses, MPa"), say("time, s"), say("km"), say("shaft speed, rpm"),
            say("shaft torque, N m"), say("gear ratio"))  # fmt: skip
    return [
        head,
        *(
            (told(p.stress / MPa), told(p.time, 6), told(p.distance / 1e3), told(p.speed * 60),
             told(p.torque), say.with_decimal_sign(p.gear) or "-")
            for p in of.stress_peaks
        ),
    ]  # fmt: skip


def long_term_sentences(of: UsageDamage, say: Translator) -> Iterator[str]:
    """Yield what it comes to in the long run, and how short a test can be."""
    run = of.long_run
    recorded = say.significant_number(run.recorded_rate * hour, 3)
    low, high = (say.significant_number(v * hour, 3) for v in run.interval)
    if run.unknown_reason == "data rejected":
        yield say(
            "{gauge}: damage per hour {recorded} as recorded; neither its value in the long run "
            "nor a test is known: {why}",
            gauge=of.gauge,
            recorded=recorded,
            why=say(UNKNOWN_DAMAGE_RATE_REASON_TEXTS[run.unknown_reason]),
        )
        return
    if run.unknown_reason:
        yield say(
            "{gauge}: damage per hour {recorded} as recorded; in the long run at least {low}, and "
            "how much cannot be known: {why}",
            gauge=of.gauge,
            recorded=recorded,
            low=low,
            why=say(UNKNOWN_DAMAGE_RATE_REASON_TEXTS[run.unknown_reason]),
        )
    else:
        yield say(
            "{gauge}: damage per hour {recorded} as recorded, {long_run} in the long run (90 % "
            "interval {low} to {high}), of roads as driven",
            gauge=of.gauge,
            recorded=recorded,
            long_run=say.significant_number(run.long_term_rate * hour, 3),
            low=low,
            high=high,
        )
    yield say(
        "{gauge}: a test cut to {time} of the time, whole seconds joined and counted again, does "
        "{damage} of the damage",
        gauge=of.gauge,
        damage=say.percentage(SHORTENED_TEST_DAMAGE_SHARE),
        time=say.percentage(of.shortened_test_share, 1),
    )
    yield say(
        "{gauge}: the recording's damage is that of the S-N knee's cycles at an amplitude of "
        "{amplitude} MPa; {open} of it is of the open residue, of no second",
        gauge=of.gauge, amplitude=say.compact_number(of.equivalent_amplitude / MPa, 4),
        open=say.percentage(of.residue_share, 1),
    )  # fmt: skip


def text_lines(of: UsageDamage, say: Translator = ENGLISH) -> Iterator[str]:
    """Yield it as lines of text."""
    for sort in of.bins:
        yield ""
        head, *body = damage_rows(of, sort, say)
        yield f"{of.gauge}:"
        yield from (f"  {line}" for line in aligned_column_lines([head, *body]))
    yield ""
    yield from (f"  {line}" for line in aligned_column_lines(stress_peak_rows(of, say), words=()))
    yield from long_term_sentences(of, say)


def report_blocks(of: UsageDamage, say: Translator) -> Iterator[Block]:
    """Yield it as tables of a report."""
    for sort in of.bins:
        head, *body = damage_rows(of, sort, say)
        yield Table(
            caption=say(
                "{gauge}: damage by {sort}", gauge=of.gauge, sort=say(GROUPING_TITLES[sort])
            ),
            head=head,
            rows=tuple(body),
        )
    head, *body = stress_peak_rows(of, say)
    yield Table(
        caption=say("{gauge}: largest stresses", gauge=of.gauge), head=head, rows=tuple(body),
        words=0,
    )  # fmt: skip
    yield Text(paragraphs=tuple(long_term_sentences(of, say)))
