"""The chapter on vibration: distances from resonances and zones, growth, amplitudes."""

from collections.abc import Iterator
from math import isnan

from cardan.base.verdict import Check, badness
from cardan.quantity.quantities import QUANTITIES
from cardan.report.blocks import Block, Figures, Table, Text
from cardan.report.language import Language
from cardan.report.stability import (
    basis,
    campbell,
    distances,
    forced,
    shapes,
    shown_gears,
    started,
    tables,
    worst_of_parts,
)
from cardan.report.wording import held, sense, tally
from cardan.study.approval import verdict_of
from cardan.study.finding import Finding
from cardan.study.stability import Stability


def chapter(found: Finding[Stability], say: Language) -> Iterator[Block]:
    """Yield how far each range of speed stays from resonances, what grows, and the starts."""
    of = found.answer
    assert of is not None  # of a study that answered
    verdict = say("Vibration: {verdict} ({counts}).",
                  verdict=say(verdict_of(found.checks, missed=False)).upper(),
                  counts=tally(found.checks, say))  # fmt: skip
    hint = say("0 % runs through it; − stays below its speed, + above.")
    doubts = (say("Not asked: {what}.", what=doubt) for doubt in of.doubts)
    yield Text(paragraphs=(verdict, *basis(of, say), *doubts, hint))
    rows = tuple(distances(of, found.checks))
    yield Table(
        caption=say("How far each range of speed stays from resonances"),
        head=(say("resonance"), *(say.occasion(g) for g in of.gears)),
        rows=tuple(
            (
                say.part(row.part),
                *(
                    "" if isnan(share) else say.percent(share) if share else "0 %"
                    for share in row.shares
                ),
            )
            for row in rows
        ),
        grades=tuple(("", *("" if g == "pass" else g for g in row.grades)) for row in rows),
    )
    others = sorted(
        worst_of_parts(c for c in found.checks if c.quantity != "torsional_resonance"), key=badness
    )
    yield Table(
        caption=say("Limits of vibration, where each is worst"),
        head=(say("verdict"), say("limit"), say("where it is worst"), say("value"),
              say("bound"), say("unit")),
        rows=tuple(_row(c, say) for c in others),
        words=3,
        grades=tuple((c.grade, *[""] * 5) for c in others),
    )  # fmt: skip
    for caption, head, lines, words in tables(of, say):
        yield Table(caption=caption, head=head, rows=lines, words=words)
    yield Figures(
        figures=tuple(
            f for g in shown_gears(of) for f in (campbell(of, g, say), shapes(of, g, say))
        )
    )
    yield Figures(figures=(forced(of, say), *(f for s in of.launches for f in started(s, say))))


def _row(c: Check, say: Language) -> tuple[str, ...]:
    """Return a check as a row."""
    q = QUANTITIES[c.quantity]
    where = say.list(say.part(c.part), say.occasion(c.when))
    value, bound = held(c, say)
    return say(c.grade), say.name(q.key), where, value, f"{sense(c, say)} {bound}", q.unit_name
