"""First screen of `cardan stability`: verdict, criteria, modes, starts, assumptions, next."""

from collections.abc import Iterator
from math import pi

import numpy as np

from cardan.approval.approval import Approval
from cardan.approval.study import VIBRATION_STUDY_NAME
from cardan.core.units import rpm
from cardan.render.check_screen import MAX_LIST_LINES, criteria_count_text, criteria_table_lines
from cardan.render.i18n import ENGLISH, Translator
from cardan.render.phrases import unevaluated_limit_lines
from cardan.render.screen_layout import capped_item_lines, capped_list_lines, title_lines
from cardan.render.terminal import bold
from cardan.render.text_layout import DEFAULT_WIDTH_COLUMNS, fold_lines
from cardan.topics.torsion.presentation import assumption_lines
from cardan.topics.torsion.vibration_checks import condition_of_launch
from cardan.topics.torsion.vibration_result import VibrationResult, heaviest_driving_state_index

MAX_LINES = 32
"""Lines of the screen at 80 columns; the blocks below keep to it together."""

SHOWN_MODES = 4

_VIBRATION_ALONE = "Of vibration alone: cardan check holds the line against all its limits."
"""Or its approval would be taken for that of the truck."""


def screen_lines(
    of: Approval, say: Translator = ENGLISH, *, width: int = DEFAULT_WIDTH_COLUMNS
) -> Iterator[str]:
    """Yield verdict, worst check of each part, modes, starts, what is assumed, next commands.

    At 80 columns at most `MAX_LINES` lines.
    """
    found: VibrationResult = of.answer_of(VIBRATION_STUDY_NAME)
    missing = [*found.doubts, *unevaluated_limit_lines(of, say)]
    above = [
        *title_lines(of, say, width),
        *fold_lines([_read_text(found, of, say), say(_VIBRATION_ALONE)], width),
        *fold_lines([criteria_count_text(of.checks, say)], width),
        *criteria_table_lines(of.checks, say, width),
        *fold_lines(_mode_texts(found, say), width),
        *fold_lines(_launch_texts(found, say), width),
    ]
    below = [
        *capped_list_lines(say("Not evaluated:"), missing, MAX_LIST_LINES, "--all", say, width),
        *fold_lines([f"{say('Next:')} cardan stability FILE --all | --chart OUT | "
                     "cardan check FILE --with vibration"], width),
    ]  # fmt: skip
    yield from above
    if items := list(assumption_lines(found, say)):
        room = MAX_LINES - len(above) - len(below) - 1
        yield bold(say("Before you sign"))
        yield from capped_item_lines(items, max(room, 1), "--all", say, width)
    yield from below


def _read_text(found: VibrationResult, of: Approval, say: Translator) -> str:
    """Return what was read: gears, states and profile of limits."""
    gears = say.join(
        say.count("{count} gear", "{count} gears", len(found.gears)),
        say.count("{count} state", "{count} states", len(found.states)),
        say.count("{count} start from rest", "{count} starts from rest", len(found.launches)),
    )
    profile = say("criteria: {profile}", profile=of.application.profile)
    return say("Read: {what}", what=f"{gears}; {profile}")


def _mode_texts(of: VibrationResult, say: Translator) -> Iterator[str]:
    """Yield the lowest modes of the first and the last gear, in the heaviest state."""
    s = heaviest_driving_state_index(of)
    known = [g for g in range(len(of.gears)) if np.isfinite(of.closed.ranges[g, s, 0])]
    items: list[str] = []
    for g in dict.fromkeys([known[0], known[-1]] if known else []):
        low, high = (say.compact_number(round(float(w) / rpm)) for w in of.closed.ranges[g, s])
        modes = " / ".join(
            say.compact_number(float(w) / (2 * pi), 3)
            for w in of.closed.frequencies[g, s, :SHOWN_MODES]
        )
        items.append(f"{say.occasion(of.gears[g])} {modes} ({low}-{high} rpm)")
    if items:
        yield say("Modes, Hz: {modes}", modes="; ".join(items))


def _launch_texts(of: VibrationResult, say: Translator) -> Iterator[str]:
    """Yield the largest peak torque of the starts from rest, in the main line's first shaft."""
    if not of.launches:
        return
    worst = max(of.launches, key=lambda one: float(one.peak_torque[one.first_shaft]))
    peak = float(f"{float(worst.peak_torque[worst.first_shaft]):.3g}")
    yield say(
        "Largest start: {launch}: {peak} N·m in shaft 1",
        launch=say.occasion(condition_of_launch(worst.launch)),
        peak=say.compact_number(peak),
    )
