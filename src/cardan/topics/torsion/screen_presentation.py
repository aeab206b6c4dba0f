"""First screen of `cardan stability`: verdict, criteria, modes, starts, assumptions, next."""

from collections import Counter
from collections.abc import Iterator, Sequence
from math import pi

import numpy as np

from cardan.approval.approval import Approval
from cardan.approval.study import VIBRATION_STUDY_NAME
from cardan.core.labels import WHOLE_LINE
from cardan.core.units import rpm
from cardan.core.verdict import CHECK_GRADES, Check, worst_first_key
from cardan.render.check_texts import limit_text, uncapitalised, value_text
from cardan.render.i18n import ENGLISH, Translator
from cardan.render.phrases import limit_grouping_key, unevaluated_limit_lines
from cardan.render.screen_layout import (
    GRADE_MARKS,
    capped_item_lines,
    capped_list_lines,
    title_lines,
)
from cardan.render.terminal import bold
from cardan.render.text_layout import DEFAULT_WIDTH_COLUMNS, fold_lines, table_lines
from cardan.topics.torsion.presentation import assumption_lines, worst_check_of_each_part
from cardan.topics.torsion.vibration_checks import condition_of_launch
from cardan.topics.torsion.vibration_result import VibrationResult, heaviest_driving_state_index

MAX_LINES = 32
"""Lines of the screen at 80 columns; the blocks below keep to it together."""

MAX_TABLE_LINES = 14
MIN_ROWS = 5
MAX_LIST_LINES = 3
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
        *fold_lines([_count_text(of.checks, say)], width),
        *_table_lines(of.checks, say, width),
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


def _count_text(checks: Sequence[Check], say: Translator) -> str:
    """Return how many criteria have each grade."""
    worst = dict.fromkeys(map(limit_grouping_key, checks), 0)
    for c in checks:
        key = limit_grouping_key(c)
        worst[key] = max(worst[key], CHECK_GRADES.index(c.grade))
    number = Counter(CHECK_GRADES[k] for k in worst.values())
    grades = say.join(
        say.count("{count} exceeded", "{count} exceeded", number["fail"]),
        say.count("{count} beyond recommended", "{count} beyond recommended", number["warn"]),
        say.count("{count} met", "{count} met", number["pass"]),
    )
    return f"{say.count('{count} criterion', '{count} criteria', len(worst))}: {grades}"


def _table_lines(checks: Sequence[Check], say: Translator, width: int) -> list[str]:
    """Return a row for each criterion that is not met, and some of those nearest to their limits.

    Further parts that do not meet a criterion stand below the table.
    """
    by_part = sorted(worst_check_of_each_part(checks), key=worst_first_key)
    rows = list({limit_grouping_key(c): c for c in reversed(by_part)}.values())
    rows.sort(key=worst_first_key)
    count = max(sum(c.grade != "pass" for c in rows), MIN_ROWS)
    head = ("", *map(say, ("criterion", "value", "limit", "worst case")))
    cells = [
        (GRADE_MARKS[c.grade], _name(c, say), value_text(c, say), limit_text(c, say),
         say.occasion(c.when))
        for c in rows
    ]  # fmt: skip
    table: list[str] = []
    for shown in range(min(len(rows), count), 0, -1):
        table = list(table_lines(head, cells[:shown], width, right=(2,)))
        if len(table) <= MAX_TABLE_LINES or shown == 1:
            count = shown
            break
    others = [
        f"{_name(c, say)}: {value_text(c, say)} ({say.occasion(c.when)})"
        for c in by_part
        if c.grade != "pass" and c not in rows[:count]
    ]
    also = capped_list_lines(say("Not met too:"), others, MAX_LIST_LINES, "--all", say, width)
    return [*map(bold, table[:1]), *table[1:], *also]


def _name(c: Check, say: Translator) -> str:
    """Return the name of a criterion with its part."""
    part = "" if c.part == WHOLE_LINE else say.part(c.part)
    return say.join(uncapitalised(say.name(c.quantity)), part)


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
