"""Criteria of one study on a first screen: how many have each grade, and a row for each."""

from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from itertools import groupby

from cardan.core.labels import WHOLE_LINE
from cardan.core.verdict import CHECK_GRADES, Check, worst_first_key
from cardan.render.check_texts import limit_text, uncapitalised, value_text
from cardan.render.i18n import Translator
from cardan.render.phrases import limit_grouping_key
from cardan.render.screen_layout import capped_list_lines
from cardan.render.terminal import GRADE_MARKS, bold
from cardan.render.text_layout import table_lines

MAX_TABLE_LINES = 14
MIN_ROWS = 5
MAX_LIST_LINES = 3


def criteria_count_text(checks: Sequence[Check], say: Translator) -> str:
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


def criteria_table_lines(
    checks: Sequence[Check], say: Translator, width: int, *, most: int = MAX_TABLE_LINES
) -> list[str]:
    """Return a row for each criterion that is not met, and some of those nearest to their limits.

    The table has at most `most` lines. Further parts that do not meet a criterion stand below it.
    """
    by_part = sorted(worst_check_of_each_part(checks), key=worst_first_key)
    rows = list({limit_grouping_key(c): c for c in reversed(by_part)}.values())
    rows.sort(key=worst_first_key)
    count = max(sum(c.grade != "pass" for c in rows), MIN_ROWS)
    head = ("", *map(say, ("criterion", "value", "limit", "worst case")))
    cells = [
        (GRADE_MARKS[c.grade], criterion_name(c, say), value_text(c, say), limit_text(c, say),
         say.occasion(c.when))
        for c in rows
    ]  # fmt: skip
    table: list[str] = []
    for shown in range(min(len(rows), count), 0, -1):
        table = list(table_lines(head, cells[:shown], width, right=(2,)))
        if len(table) <= most or shown == 1:
            count = shown
            break
    others = [
        f"{criterion_name(c, say)}: {value_text(c, say)} ({say.occasion(c.when)})"
        for c in by_part
        if c.grade != "pass" and c not in rows[:count]
    ]
    also = capped_list_lines(say("Not met too:"), others, MAX_LIST_LINES, "--all", say, width)
    return [*map(bold, table[:1]), *table[1:], *also]


def criterion_name(c: Check, say: Translator) -> str:
    """Return the name of a criterion with its part."""
    part = "" if c.part == WHOLE_LINE else say.part(c.part)
    return say.join(uncapitalised(say.name(c.quantity)), part)


def worst_check_of_each_part(checks: Iterable[Check]) -> Iterator[Check]:
    """Yield the worst check of each part."""
    for _, same in groupby(sorted(checks, key=_part), key=_part):
        yield min(same, key=worst_first_key)


def _part(c: Check) -> tuple[str, str, str]:
    return c.quantity, c.line, str(c.part)
