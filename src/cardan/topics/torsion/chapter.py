"""The chapter on vibration: distances from resonances and zones, growth, amplitudes."""

from collections.abc import Iterator
from math import isnan

from cardan.approval.coverage import verdict_of
from cardan.approval.study import StudyResult
from cardan.checks.quantities.registry import QUANTITIES
from cardan.core.verdict import Check, worst_first_key
from cardan.render.blocks import Block, Chapter, Figures, Table, Text
from cardan.render.check_screen import worst_check_of_each_part
from cardan.render.i18n import Translator
from cardan.render.phrases import (
    check_counts_text,
    grade_text,
    limit_sense_symbol,
    value_and_bound,
    verdict_word,
)
from cardan.topics.torsion.presentation import (
    assumption_lines,
    resonance_margins,
    result_tables,
)
from cardan.topics.torsion.presentation_figures import (
    campbell_figure,
    forced_torque_figure,
    launch_figures,
    mode_shape_figure,
    shown_gears,
)
from cardan.topics.torsion.registration import REGISTRATION
from cardan.topics.torsion.vibration_result import VibrationResult


def vibration_chapters(
    found: StudyResult[VibrationResult], say: Translator, *, short: bool = False
) -> Iterator[Chapter]:
    """Yield the chapter on vibration, the same in a short report."""
    del short
    yield Chapter(title=say(REGISTRATION.title), blocks=tuple(vibration_blocks(found, say)))


def vibration_blocks(found: StudyResult[VibrationResult], say: Translator) -> Iterator[Block]:
    """Yield how far each range of speed stays from resonances, what grows, and the starts."""
    of = found.answer
    assert of is not None  # of a study that answered
    verdict = say("Vibration: {verdict} ({counts}).",
                  verdict=verdict_word(verdict_of(found.checks, missed=False), say),
                  counts=check_counts_text(found.checks, say))  # fmt: skip
    hint = say("0 % runs through it; − stays below its speed, + above.")
    doubts = (say("Not evaluated: {what}.", what=doubt) for doubt in of.doubts)
    yield Text(paragraphs=(verdict, *assumption_lines(of, say), *doubts, hint))
    rows = tuple(resonance_margins(of, found.checks))
    yield Table(
        caption=say("How far each range of speed stays from resonances"),
        head=(say("resonance"), *(say.occasion(g) for g in of.gears)),
        rows=tuple(
            (
                say.part(row.part),
                *(
                    "" if isnan(share) else say.margin_percent(share) if share else "0 %"
                    for share in row.shares
                ),
            )
            for row in rows
        ),
        grades=tuple(("", *("" if g == "pass" else g for g in row.grades)) for row in rows),
    )
    others = sorted(
        worst_check_of_each_part(c for c in found.checks if c.quantity != "torsional_resonance"),
        key=worst_first_key,
    )
    yield Table(
        caption=say("Limits of vibration, where each is worst"),
        head=(say("verdict"), say("limit"), say("where it is worst"), say("value"),
              say("bound"), say("unit")),
        rows=tuple(_row(c, say) for c in others),
        words=3,
        grades=tuple((c.grade, *[""] * 5) for c in others),
    )  # fmt: skip
    for caption, head, lines, words in result_tables(of, say):
        yield Table(caption=caption, head=head, rows=lines, words=words)
    yield Figures(
        figures=tuple(
            f
            for g in shown_gears(of)
            for f in (campbell_figure(of, g, say), mode_shape_figure(of, g, say))
        )
    )
    yield Figures(
        figures=(
            forced_torque_figure(of, say),
            *(f for s in of.launches for f in launch_figures(s, say)),
        )
    )


def _row(c: Check, say: Translator) -> tuple[str, ...]:
    """Return a check as a row."""
    q = QUANTITIES[c.quantity]
    where = say.join(say.part(c.part), say.occasion(c.when))
    value, bound = value_and_bound(c, say)
    return (
        grade_text(c.grade, say),
        say.name(q.key),
        where,
        value,
        f"{limit_sense_symbol(c, say)} {bound}",
        q.unit_symbol,
    )
