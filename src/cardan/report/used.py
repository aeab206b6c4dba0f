"""When and where a recording did its damage: terminal, JSON and tables."""

import math
from collections.abc import Iterator, Mapping
from typing import Any

from cardan.base.units import MPa, hour
from cardan.fatigue.long_run import Unknown
from cardan.fatigue.usage import Group
from cardan.report.blocks import Block, Table, Text
from cardan.report.language import EN, Language
from cardan.report.terminal import columns
from cardan.study.usage import KEPT, Used

SORTS = {
    "gear": "gear, engine turns a shaft turn",
    "speed": "shaft speed, rpm",
    "torque": "shaft torque, N m",
}
"""What damage is told by."""

NONE = {"gear": "in no gear", "speed": "speed not known", "torque": "torque not known"}
"""What is in none of these."""

OPEN = "of no second, open at the end"
"""What is left open."""

UNKNOWN: Mapping[Unknown, str] = {
    "short": "the recording is shorter than a minute",
    "blows": "a few blows did much of it; record for longer",
    "road": "the road changed, and its worst was met too seldom; record more of each road",
    "wide": "the interval spans more than a factor of thirty; record for longer",
    "vetoed": "what is wrong with the recording decides it",
}
"""Why nobody can know what it comes to in the long run."""


def _number(value: float) -> float | None:
    return float(value) if math.isfinite(value) else None


def document(of: Used) -> dict[str, Any]:
    """Return it as the JSON contract has it; null is not known."""
    run = of.long_run
    return {
        "damage_by": {
            sort: [
                {
                    "band": g.name,
                    "damage": g.damage,
                    "share": _number(g.of_closed),
                    "share_of_whole": _number(g.share),
                    "live_s": g.time,
                    "km": _number(g.distance / 1e3),
                    "damage_per_km": _number(g.damage / (g.distance / 1e3))
                    if g.distance > 0
                    else None,
                }
                for g in groups
            ]
            for sort, groups in of.groups.items()
        },
        "damage_by_none": {
            sort: {
                "damage": g.damage,
                "share_of_whole": _number(g.share),
                "live_s": g.time,
                "km": _number(g.distance / 1e3),
            }
            for sort, g in of.unknown.items()
        },
        "open_share": of.open,
        "open_damage": of.open_damage,
        "peaks": [
            {
                "MPa": p.stress / MPa,
                "time_s": p.time,
                "km": _number(p.way / 1e3),
                "rpm": _number(p.speed * 60),
                "torque_Nm": _number(p.torque),
                "gear": p.gear or None,
            }
            for p in of.places
        ],
        "damage_per_hour": {
            "recorded": run.rate * hour,
            "long_run": _number(run.long_run * hour),
            "interval": [_number(end * hour) for end in run.interval],
            "unknown": run.unknown,
        },
        "shortened": {"damage": KEPT, "time": of.shortened},
        "test_amplitude_MPa": of.amplitude / MPa,
    }


def rows(of: Used, sort: str, say: Language) -> list[tuple[str, ...]]:
    """Return the damage by a sort as rows that sum to the whole damage, their heads first."""
    known = any(g.distance > 0 for g in of.groups[sort])
    head = (say(SORTS[sort]), say("damage"), say("share"), say("time, min"))
    found = [(*head, say("km"), say("per km")) if known else head]

    def add(name: str, g: Group) -> None:
        row = (
            name, say.small(g.damage, 3), say.share(g.share, 1), say.short(g.time / 60, 3),
        )  # fmt: skip
        per = g.damage / (g.distance / 1e3) if g.distance > 0 else math.nan
        far = "-" if math.isnan(g.distance) else say.short(g.distance / 1e3, 3)
        way = (far, "-" if math.isnan(per) else say.small(per, 3))
        found.append((*row, *way) if known else row)

    for g in sorted(of.groups[sort], key=lambda g: -g.damage):
        add(say.pointed(g.name) if sort == "gear" else g.name, g)
    if of.unknown[sort].time > 0:
        add(say(NONE[sort]), of.unknown[sort])
    row = (say(OPEN), say.small(of.open_damage, 3), say.share(of.open, 1), "-")
    found.append((*row, "-", "-") if known else row)
    return found


def places(of: Used, say: Language) -> list[tuple[str, ...]]:
    """Return the largest stresses as rows, their heads first."""

    def told(value: float, digits: int = 4) -> str:
        return "-" if math.isnan(value) else say.short(value, digits)

    head = (say("largest stresses, MPa"), say("time, s"), say("km"), say("shaft speed, rpm"),
            say("shaft torque, N m"), say("gear ratio"))  # fmt: skip
    return [
        head,
        *(
            (told(p.stress / MPa), told(p.time, 6), told(p.way / 1e3), told(p.speed * 60),
             told(p.torque), say.pointed(p.gear) or "-")
            for p in of.places
        ),
    ]  # fmt: skip


def says(of: Used, say: Language) -> Iterator[str]:
    """Yield what it comes to in the long run, and how short a test can be."""
    run = of.long_run
    recorded = say.small(run.rate * hour, 3)
    low, high = (say.small(v * hour, 3) for v in run.interval)
    if run.unknown == "vetoed":
        yield say(
            "{gauge}: damage per hour {recorded} as recorded; neither what it is in the long run "
            "nor a test can be told: {why}",
            gauge=of.gauge, recorded=recorded, why=say(UNKNOWN[run.unknown]),
        )  # fmt: skip
        return
    if run.unknown:
        yield say(
            "{gauge}: damage per hour {recorded} as recorded; in the long run at least {low}, and "
            "how much cannot be known: {why}",
            gauge=of.gauge, recorded=recorded, low=low, why=say(UNKNOWN[run.unknown]),
        )  # fmt: skip
    else:
        yield say(
            "{gauge}: damage per hour {recorded} as recorded, {long_run} in the long run (90 % "
            "interval {low} to {high}), of roads as driven",
            gauge=of.gauge, recorded=recorded, long_run=say.small(run.long_run * hour, 3),
            low=low, high=high,
        )  # fmt: skip
    yield say(
        "{gauge}: a test cut to {time} of the time, whole seconds joined and counted again, does "
        "{damage} of the damage",
        gauge=of.gauge, damage=say.share(KEPT), time=say.share(of.shortened, 1),
    )  # fmt: skip
    yield say(
        "{gauge}: the recording's damage is that of the S-N knee's cycles at an amplitude of "
        "{amplitude} MPa; {open} of it is of the open residue, of no second",
        gauge=of.gauge, amplitude=say.short(of.amplitude / MPa, 4),
        open=say.share(of.open, 1),
    )  # fmt: skip


def lines(of: Used, say: Language = EN) -> Iterator[str]:
    """Yield it as lines of text."""
    for sort in of.groups:
        yield ""
        head, *body = rows(of, sort, say)
        yield f"{of.gauge}:"
        yield from (f"  {line}" for line in columns([head, *body]))
    yield ""
    yield from (f"  {line}" for line in columns(places(of, say), words=()))
    yield from says(of, say)


def blocks(of: Used, say: Language) -> Iterator[Block]:
    """Yield it as tables of a report."""
    for sort in of.groups:
        head, *body = rows(of, sort, say)
        yield Table(
            caption=say("{gauge}: damage by {sort}", gauge=of.gauge, sort=say(SORTS[sort])),
            head=head, rows=tuple(body),
        )  # fmt: skip
    head, *body = places(of, say)
    yield Table(
        caption=say("{gauge}: largest stresses", gauge=of.gauge), head=head, rows=tuple(body),
        words=0,
    )  # fmt: skip
    yield Text(paragraphs=tuple(says(of, say)))
