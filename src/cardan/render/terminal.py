"""Lines for a terminal: verdicts, tables of checks, tables of a report, marked with colours."""

import sys
from collections.abc import Iterable, Iterator, Sequence
from itertools import zip_longest
from typing import TYPE_CHECKING

from cardan.application.quantity_lookup import declared_quantity
from cardan.approval.coverage import CheckCoverage
from cardan.core.verdict import Check, CheckGrade, UnevaluatedCheck, Verdict, worst_first_key
from cardan.render.blocks import Table
from cardan.render.i18n import ENGLISH, Translator
from cardan.render.phrases import (
    check_counts_text,
    check_location,
    citation,
    doubtful_value_count_text,
    grade_text,
    is_partial_approval,
    note_sentences,
    unevaluated_limit_lines,
    value_and_bound,
    verdict_text,
    verdict_word,
    worst_check_per_limit,
)
from cardan.render.text_layout import DEFAULT_WIDTH_COLUMNS, fold_lines, wrap_text

if TYPE_CHECKING:  # a recording does not wait for the physics of a driveline
    from cardan.approval.approval import Approval

VERDICT_COLOUR_CODES: dict[Verdict, str] = {
    "pass": "\x1b[32m", "warn": "\x1b[33m", "incomplete": "\x1b[35m", "fail": "\x1b[1;31m",
}  # fmt: skip


GRADE_MARKS: dict[CheckGrade, str] = {"fail": "X", "warn": "!", "pass": " "}
"""What a row of a check begins with: X is exceeded, ! is beyond recommended."""

BOLD_CODE, RESET_CODE = "\x1b[1m", "\x1b[0m"


def summary_lines(of: "Approval", say: Translator = ENGLISH) -> Iterator[str]:
    """Yield the verdict in a line, with how many values look wrong."""
    said = coloured_by_grade(
        "warn" if is_partial_approval(of) and of.verdict == "pass" else of.verdict,
        verdict_text(of, say),
    )
    counts = check_counts_text(of.checks, say, of.coverage.unevaluated)
    told = "; ".join(filter(None, (counts, doubtful_value_count_text(of, say))))
    yield f"{bold(of.application.title)}: {said} ({told})"


def verdict_headline(
    title: str,
    verdict: Verdict,
    checks: Iterable[Check],
    unanswered: Sequence[UnevaluatedCheck],
    say: Translator = ENGLISH,
) -> str:
    """Return a verdict in a line: of what, and how many checks came to which grade."""
    said = coloured_by_grade(verdict, verdict_word(verdict, say))
    return f"{bold(title)}: {said} ({check_counts_text(checks, say, unanswered)})"


def verdict_lines(
    of: "Approval",
    say: Translator = ENGLISH,
    *,
    every: bool = False,
    width: int = DEFAULT_WIDTH_COLUMNS,
) -> Iterator[str]:
    """Yield the verdict, each limit where it is worst, what is not evaluated, and notes."""
    yield from fold_lines(summary_lines(of, say), width)
    yield from fold_lines(profile_and_margin_lines(of, say), width)
    yield from check_lines(of, say, every=every, width=width)
    yield from fold_lines(
        unevaluated_lines(unevaluated_limit_lines(of, say), of.coverage, say), width
    )
    yield from fold_lines(note_sentences(of, say), width)
    yield from provenance_lines(of, say, width)


def provenance_lines(of: "Approval", say: Translator, width: int) -> Iterator[str]:
    """Yield the catalogue data that an approval stands on, and how it was read."""
    if of.catalogue_data:
        from cardan.render import provenance_table as data

        title = say("Data it stands on, and how it was read (`cardan catalogue` has its sources)")
        yield ""
        yield from fold_lines(
            [bold(title), *(f"  {line}" for line in data.text_lines(of, say))], width
        )


def profile_and_margin_lines(of: "Approval", say: Translator) -> Iterator[str]:
    """Yield the profile that a verdict is by, and how near the nearest limit is."""
    said = say("limits: {profile}", profile=of.application.profile)
    if of.smallest_margin is None:
        yield said
        return
    yield say("{limits}; smallest margin {margin}", limits=said,
              margin=say.margin_text(of.smallest_margin))  # fmt: skip


def report_table_lines(of: "Table", width: int | None = None) -> Iterator[str]:
    """Yield a table of a story, columns as wide as they need to be, heads in several lines.

    On a screen of a width, columns that have no room stand below, next to the first again.
    """
    cells = [max([0, *(len(row[k]) for row in of.rows)]) for k in range(len(of.head))]
    wide = [max(c, *map(len, h.split() or [""])) for c, h in zip(cells, of.head, strict=True)]
    heads = [wrap_text(h, w) for h, w in zip(of.head, wide, strict=True)]
    wide = [max(w, *map(len, h)) for w, h in zip(wide, heads, strict=True)]
    yield ""
    yield bold(of.caption)
    lead = max(of.words, 1)
    for some in _column_groups(wide, lead, width):
        high = max(len(heads[k]) for k in some)
        rows = [tuple(([""] * (high - len(h)) + h)[-high:][k] for h in heads) for k in range(high)]
        for row in (*rows, *of.rows):
            line = (
                f"{row[k]:<{wide[k]}}" if k < of.words else f"{row[k]:>{wide[k]}}" for k in some
            )
            yield "  " + "  ".join(line).rstrip()


def _column_groups(wide: Sequence[int], lead: int, width: int | None) -> Iterator[list[int]]:
    """Yield places of columns that fit next to the first ones."""
    rest = list(range(lead, len(wide)))
    while rest or lead == len(wide):
        some, room = list(range(lead)), (width or sys.maxsize) - sum(2 + w for w in wide[:lead])
        while rest and (len(some) == lead or 2 + wide[rest[0]] <= room):
            room -= 2 + wide[rest[0]]
            some.append(rest.pop(0))
        yield some
        if not rest:
            return


def unevaluated_lines(
    found: Sequence[str], coverage: CheckCoverage, say: Translator
) -> Iterator[str]:
    """Yield the limits not evaluated, and the missing input."""
    if found:
        yield ""
        yield bold(
            say("Not evaluated ({answered} of {asked} checks evaluated)",
                answered=coverage.evaluated, asked=coverage.total)
        )  # fmt: skip
        yield from (f"  {line}" for line in found)


def check_lines(
    of: "Approval",
    say: Translator,
    *,
    every: bool = False,
    width: int = DEFAULT_WIDTH_COLUMNS,
) -> Iterator[str]:
    """Yield a table of checks, those that do not pass first, and the sources of its limits.

    With `every` each check has its row, else each limit where it is worst.
    """
    rows = sorted(of.checks, key=worst_first_key) if every else worst_check_per_limit(of.checks)
    yield from check_table_lines(rows, say, several=len(of.line_responses) > 1, width=width)


def check_table_lines(
    rows: Sequence[Check],
    say: Translator,
    *,
    several: bool = False,
    width: int = DEFAULT_WIDTH_COLUMNS,
) -> Iterator[str]:
    """Yield a table of checks as they come, and the sources of their limits.

    Where a check is worst stands next to its name if the screen is wide, else below it.
    """
    if not rows:
        return
    sources = list(dict.fromkeys(citation(c.limit.source, say) for c in rows))
    grade = 2
    numbers = _aligned_lines(
        [(say("value"), "", say("limit"), say("unit"), say("margin"), "")]
        + [_check_cells(c, say, sources.index(citation(c.limit.source, say)) + 1) for c in rows],
        right=(0, 4),
    )
    places = [(say.name(c.quantity), check_location(c, say, several=several)) for c in rows]
    room = width - grade - 2 - len(numbers[0])
    name, where = (max(map(len, column)) for column in zip(*places, strict=True))
    split = min(name, room * 4 // 9)
    apart = split >= min(name, 30) and room - split - 2 >= min(where, 40)
    yield ""
    head = say("limit"), say("where it is worst")
    if apart:
        left = f"{head[0]:<{split + 2}}{head[1]}"
    else:
        left = say.join(*head) if len(say.join(*head)) <= room else head[0]
    yield bold(f"{'':{grade}}{left:<{room + 2}}{numbers[0]}".rstrip())
    for c, (what, at), row in zip(rows, places, numbers[1:], strict=True):
        if apart:
            lines = _side_by_side(what, at, split, room)
        else:
            lines = [*wrap_text(what, room), *(f"  {x}" for x in wrap_text(at, width - grade - 2))]
        first, *others = lines
        yield (
            f"{coloured_by_grade(c.grade, f'{GRADE_MARKS[c.grade]:<{grade}}')}"
            f"{first:<{room + 2}}{row}"
        ).rstrip()
        yield from (f"{'':{grade}}{line}" for line in others)
    yield from grade_mark_lines(rows, say, width)
    yield from fold_lines((f"  [{k}] {source}" for k, source in enumerate(sources, 1)), width)


def grade_mark_lines(rows: Iterable[Check], say: Translator, width: int) -> Iterator[str]:
    """Yield what X and ! before rows of checks mean, where one stands there."""
    grades = {c.grade for c in rows}
    marks = [f"{GRADE_MARKS[g]} {grade_text(g, say)}" for g in ("fail", "warn") if g in grades]
    yield from fold_lines([f"  {', '.join(marks)}"] if marks else [], width)


def _check_cells(c: Check, say: Translator, source: int) -> tuple[str, ...]:
    """Return the cells of a check: value, sense, limit, unit, margin, number of its source."""
    value, bound = value_and_bound(c, say)
    unit = declared_quantity(c.quantity).unit_symbol
    return value, _ascii_sense(c, say), bound, unit, say.margin_text(c.margin), f"[{source}]"


def _aligned_lines(rows: Sequence[tuple[str, ...]], *, right: Sequence[int]) -> list[str]:
    """Return rows as lines as long as each other: columns a space apart, some to the right."""
    wide = [max(map(len, column)) for column in zip(*rows, strict=True)]
    return [
        " ".join(
            f"{cell:>{w}}" if k in right else f"{cell:<{w}}"
            for k, (cell, w) in enumerate(zip(row, wide, strict=True))
        )
        for row in rows
    ]


def _side_by_side(first: str, second: str, split: int, room: int) -> list[str]:
    """Return lines of two texts next to each other."""
    left, right = wrap_text(first, split), wrap_text(second, room - split - 2)
    return [f"{a:<{split + 2}}{b}".rstrip() for a, b in zip_longest(left, right, fillvalue="")]


def _ascii_sense(c: Check, say: Translator) -> str:
    """Return how a value stands to its limit, in characters of any terminal."""
    return say("outside") if c.limit.band else c.limit.sense


def bold(text: str) -> str:
    """Return a text in bold."""
    return f"{BOLD_CODE}{text}{RESET_CODE}"


def coloured_by_grade(grade: Verdict, text: str) -> str:
    """Return a text in the colour of a grade."""
    return f"{VERDICT_COLOUR_CODES[grade]}{text}{RESET_CODE}"


def aligned_column_lines(
    rows: Sequence[tuple[str, ...]], *, words: Sequence[int] = (0,)
) -> Iterator[str]:
    """Yield rows as lines of aligned cells: those of the places in `words` to the left."""
    width = [max(len(row[k]) for row in rows) for k in range(len(rows[0]))] if rows else []
    for row in rows:
        cells = (
            f"{cell:<{w}}" if k in words else f"{cell:>{w}}"
            for k, (cell, w) in enumerate(zip(row, width, strict=True))
        )
        yield "  ".join(cells).rstrip()
