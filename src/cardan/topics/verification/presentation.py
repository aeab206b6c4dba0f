"""Published cases next to what this machine computes, as lines and as JSON."""

from collections.abc import Iterable, Iterator
from typing import Any

from cardan.core.verdict import CheckGrade
from cardan.render.i18n import ENGLISH, Translator
from cardan.render.json_contract import to_json_types
from cardan.render.terminal import bold, coloured_by_grade
from cardan.render.text_layout import DEFAULT_WIDTH_COLUMNS, fold_lines, text_with_right_column
from cardan.topics.verification.published_cases import BenchmarkCase

BENCHMARK_CASE_KIND_TITLES = {
    "published": "Published where a reader can look",
    "untraced": "Printed in a book that is not traced",
    "derived": "Computed by other means, not printed",
}
"""Heads of `cardan verify`."""


def software_benchmark_case_lines(
    cases: "Iterable[BenchmarkCase]",
    say: Translator = ENGLISH,
    *,
    width: int = DEFAULT_WIDTH_COLUMNS,
) -> Iterator[str]:
    """Yield published cases with what was expected and what this machine computes."""
    words = {agrees: say(word) for agrees, word in ((True, "ok"), (False, "WRONG"))}
    mark = 1 + max(5, *map(len, words.values()))
    room = width - mark - 13 - 13 - 11
    heads = f"{say('published'):>13}{say('computed'):>13}{say('difference'):>11}"
    yield f"{'':{mark}}{say('case'):<{room}}{heads}"
    kind = ""
    for c in cases:
        if c.kind != kind:
            kind = c.kind
            yield ""
            yield bold(say(BENCHMARK_CASE_KIND_TITLES[kind]))
        grade: CheckGrade = "pass" if c.is_within_tolerance else "fail"
        word = coloured_by_grade(grade, f"{words[c.is_within_tolerance]:<{mark}}")
        numbers = f"{c.expected:>13.6g}{c.computed:>13.6g}{c.relative_difference:>+11.2%}"
        title, numbers = say.translate_message(c.title), say.localise_numbers(numbers)
        first, *others = text_with_right_column(title, numbers, room)
        yield f"{word}{first}"
        yield from (f"{'':{mark}}{line}" for line in others)
        yield from fold_lines([f"{'':{mark}}{'':2}{say.source(str(c.source))}"], width)


def software_benchmark_cases_json(of: tuple[BenchmarkCase, ...]) -> list[dict[str, Any]]:
    """Return published cases with what this machine computes."""
    return to_json_types(
        [
            {
                "case": str(c.title),
                "kind": c.kind,
                "source": str(c.source),
                "published": c.expected,
                "computed": c.computed,
                "within": c.tolerance,
                "agrees": c.is_within_tolerance,
            }
            for c in of
        ]
    )
