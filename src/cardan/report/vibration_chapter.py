"""The chapter on vibration: distances from resonances and zones, growth, amplitudes."""

from collections.abc import Iterator

from cardan.base.units import rpm
from cardan.base.verdict import Check
from cardan.quantity.quantities import QUANTITIES
from cardan.report.blocks import Block, Figures, Table, Text
from cardan.report.language import Language
from cardan.report.stability import basis, campbell, distances, forced, worst_of_parts
from cardan.report.wording import badness, sense, tally
from cardan.study.approval import verdict_of
from cardan.study.finding import Finding
from cardan.study.stability import Stability


def chapter(found: Finding[Stability], say: Language) -> Iterator[Block]:
    """Yield how far each range of speed stays from resonances and zones, and what grows."""
    of = found.answer
    assert of is not None  # of a study that answered
    verdict = say("Vibration: {verdict} ({counts}).",
                  verdict=say(verdict_of(found.checks, missed=False)).upper(),
                  counts=tally(found.checks, say))  # fmt: skip
    hint = say("0 % runs through it; − stays below its speed, + above.")
    yield Text(paragraphs=(verdict, *basis(of, say), hint))
    for v in of.lines:
        end = f": {v.line.name}" if len(of.lines) > 1 else ""
        rows = tuple(distances(v, found.checks))
        yield Table(
            caption=say("How far each range of speed stays from resonances and zones") + end,
            head=(say("resonance or zone"), say("at [rpm]"), *(say.occasion(g) for g in v.gears)),
            rows=tuple(
                (
                    say.part(row.part),
                    say.number(row.speed / rpm),
                    *(say.percent(share) if share else "0 %" for share in row.shares),
                )
                for row in rows
            ),
            grades=tuple(("", "", *("" if g == "pass" else g for g in row.grades)) for row in rows),
        )
        growing = sorted(
            worst_of_parts(
                c for c in found.checks if c.line == v.line.name and c.quantity.endswith("growth")
            ),
            key=badness,
        )
        yield Table(
            caption=say("Growth of vibrations, where it is worst") + end,
            head=(say("verdict"), say("limit"), say("where it is worst"), say("value"),
                  say("bound"), say("unit")),
            rows=tuple(_growth(c, say) for c in growing),
            words=3,
            grades=tuple((c.grade, *[""] * 5) for c in growing),
        )  # fmt: skip
        yield Figures(figures=(campbell(v, say), forced(v, say)))


def _growth(c: Check, say: Language) -> tuple[str, ...]:
    """Return a check on growth as a row."""
    q = QUANTITIES[c.quantity]
    where = say.list(say.part(c.part), say.occasion(c.when))
    value, bound = say.number(c.value / q.factor), say.number(c.bound / q.factor)
    return say(c.grade), say.name(q.key), where, value, f"{sense(c, say)} {bound}", q.unit_name
