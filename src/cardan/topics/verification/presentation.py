"""Published cases next to what this machine computes, as lines and as JSON."""

from collections.abc import Iterable, Iterator
from typing import Any

from cardan.render.json_contract import to_json_types
from cardan.render.terminal import bold, coloured_by_grade
from cardan.render.text_layout import DEFAULT_WIDTH_COLUMNS, fold_lines, text_with_right_column
from cardan.topics.verification.published_cases import BenchmarkCase

BENCHMARK_CASE_KIND_TITLES = {
    "published": "Published where a reader can look",
    "untraced": "Printed somewhere that nobody found again",
    "derived": "Computed by other means, printed nowhere",
}
"""Heads of `cardan verify`."""


def software_benchmark_case_lines(
    cases: "Iterable[BenchmarkCase]", *, width: int = DEFAULT_WIDTH_COLUMNS
) -> Iterator[str]:
    """Yield published cases with what was expected and what this machine computes."""
    room = width - 6 - 13 - 13 - 11
    yield f"{'':6}{'case':<{room}}{'published':>13}{'computed':>13}{'difference':>11}"
    kind = ""
    for c in cases:
        if c.kind != kind:
            kind = c.kind
            yield ""
            yield bold(BENCHMARK_CASE_KIND_TITLES[kind])
        word = (
            coloured_by_grade("pass", "ok    ")
            if c.is_within_tolerance
            else coloured_by_grade("fail", "WRONG ")
        )
        numbers = f"{c.expected:>13.6g}{c.computed:>13.6g}{c.relative_difference:>+11.2%}"
        first, *others = text_with_right_column(c.title, numbers, room)
        yield f"{word}{first}"
        yield from (f"{'':6}{line}" for line in others)
        yield from fold_lines([f"{'':6}{'':2}{c.source}"], width)


def software_benchmark_cases_json(of: tuple[BenchmarkCase, ...]) -> list[dict[str, Any]]:
    """Return published cases with what this machine computes."""
    return to_json_types(
        [
            {
                "case": c.title,
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
