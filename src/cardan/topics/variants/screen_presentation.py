"""First screen of `cardan study`: yield, what varies, limits, what decides, open points, next."""

from collections.abc import Iterator

import numpy as np

from cardan.core.verdict import Verdict
from cardan.render.i18n import ENGLISH, Translator
from cardan.render.phrases import VERDICT_TEXTS, unevaluated_limit_lines
from cardan.render.screen_layout import (
    capped_item_lines,
    capped_list_lines,
    more_text,
    percent_text,
    share_text,
    title_and_verdict_lines,
)
from cardan.render.terminal import GRADE_MARKS, bold
from cardan.render.text_layout import DEFAULT_WIDTH_COLUMNS, fold_lines, table_lines
from cardan.topics.variants.presentation import (
    bound_mark,
    deciding_limit_name,
    doubt_sentences,
    factor_label,
    limit_label,
    limit_margins,
    limit_name,
    limits_by_failures,
    once_in_text,
    sobol_column_label,
    sobol_columns,
    spread_text,
    stopped_sentences,
    yield_sentences,
)
from cardan.topics.variants.statistics import halved_tolerance_yields, sobol_indices
from cardan.topics.variants.study_result import VariantStudyResult

MAX_LINES = 32
"""Lines of the screen at 80 columns; the blocks below keep to it together."""

MIN_TABLE_LINES, MAX_TABLE_LINES, MIN_ROWS = 3, 12, 5
MIN_DOUBT_LINES = 4
"""Lines of doubts with their head, where there are any."""
MAX_LIST_LINES = 2
MAX_NAMED = 2
"""Tolerances, inputs and limits that a line names."""


def screen_lines(
    of: VariantStudyResult, say: Translator = ENGLISH, *, width: int = DEFAULT_WIDTH_COLUMNS
) -> Iterator[str]:
    """Yield the share that may be built, what varies, limits, what decides, next commands.

    At 80 columns at most `MAX_LINES` lines, unless a warning alone is longer.
    """
    missing = unevaluated_limit_lines(of.installed, say)
    head = [
        *_title_lines(of, say, width),
        *fold_lines([*stopped_sentences(of, say), _shares_text(of, say)], width),
        *_varied_lines(of, say, width),
        *fold_lines(yield_sentences(of, say), width),
    ]
    deciding = list(fold_lines(_deciding_texts(of, say), width))
    below = [
        *capped_list_lines(say("Not evaluated:"), missing, MAX_LIST_LINES, "--all", say, width),
        *fold_lines([f"{say('Next:')} cardan study FILE --all | --html OUT | --json OUT | "
                     "cardan fix FILE"], width),
    ]  # fmt: skip
    doubts = list(doubt_sentences(of, say))
    room = MAX_LINES - len(head) - len(deciding) - len(below)
    most = min(MAX_TABLE_LINES, room - 1 - (MIN_DOUBT_LINES if doubts else 0))
    limits = not of.variants.ask.yield_only
    table = _limit_lines(of, say, width, max(most, MIN_TABLE_LINES)) if limits else []
    yield from (*head, *table, *deciding)
    if doubts:
        yield bold(say("Before you sign"))
        yield from capped_item_lines(doubts, max(room - len(table) - 1, 1), "--all", say, width)
    yield from below


def _title_lines(of: VariantStudyResult, say: Translator, width: int) -> list[str]:
    title = of.installed.application.title
    count = say.count("{count} variant", "{count} variants", of.count)
    if not of.variants.ask.yield_:
        return title_and_verdict_lines(title, count, "pass", width)
    grade: Verdict = "pass" if of.yield_ == 1 else "warn" if of.yield_ > 0 else "fail"
    said = say("{share} may be built", share=percent_text(of.yield_, say))
    return title_and_verdict_lines(title, said, grade, width)


def _shares_text(of: VariantStudyResult, say: Translator) -> str:
    """Return how many variants were evaluated, under which limits, and the shares of verdicts."""
    count = say.count("{count} variant", "{count} variants", of.count)
    profile = say("criteria: {profile}", profile=of.installed.application.profile)
    shares = [f"{percent_text(s, say)} {say(VERDICT_TEXTS[v])}" for v, s in of.shares.items() if s]
    return say("Evaluated: {what}", what=f"{count}; {profile}; {say.join(*shares)}")


def _varied_lines(of: VariantStudyResult, say: Translator, width: int) -> list[str]:
    drawn = of.sampling_plan
    items = [f"{drawn.name_of(f)} {spread_text(f, say)}" for f in (*drawn.grids, *drawn.factors)]
    return capped_list_lines(say("What varies:"), items, MAX_LIST_LINES, "--all", say, width)


def _limit_lines(of: VariantStudyResult, say: Translator, width: int, most: int) -> list[str]:
    """Return a row for each limit that some variants fail, and the others nearest to their limits.

    The table has at most `most` lines; the rest is counted below it.
    """
    order = limits_by_failures(of)
    grades = of.statistics["counts"]["grades"] / of.independent_count
    failing = sum(grades[k, 2] > 0 for k in order)
    head = (
        "", say("limit"), say("exceeded"), say("smallest margin"),
        say("median margin"),
    )  # fmt: skip
    cells = [
        (
            GRADE_MARKS["fail" if grades[k, 2] else "warn" if grades[k, 1] else "pass"],
            limit_label(of, k, say),
            percent_text(grades[k, 2], say),
            *(bound_mark(of, k) + _margin_text(m, say) for m in limit_margins(of, k)),
        )
        for k in order
    ]  # fmt: skip
    table: list[str] = []
    shown = min(len(cells), max(failing, MIN_ROWS))
    while shown:
        table = list(table_lines(head, cells[:shown], width, right=(2, 3, 4)))
        if len(table) <= most or shown == 1:
            break
        shown -= 1
    rest = len(cells) - shown
    more = [f"  {more_text(rest, '--all', say)}"] if rest else []
    return [*map(bold, table[:1]), *table[1:], *more]


def _margin_text(margin: float, say: Translator) -> str:
    return say.margin_percent(margin) if abs(margin) <= 1 else share_text(margin, say)


def _deciding_texts(of: VariantStudyResult, say: Translator) -> Iterator[str]:
    """Yield tolerances to tighten, sources of the variance, rare failures, the worst, the front."""
    state = of.statistics
    if "tighter" in state:
        yield _tighter_text(of, say)
    if "sobol" in state and (columns := sobol_columns(of)):
        found, column = sobol_indices(state["sobol"]), columns[0]
        order = np.argsort(-found.total[column], kind="stable")[:MAX_NAMED].tolist()
        names = [
            f"{factor_label(of, of.sampling_plan.factors[k], say)} "
            f"{say.with_decimal_sign(f'{found.total[column, k] + 0.0:.2f}')}"
            for k in order
        ]
        what = sobol_column_label(of, column, say)
        yield say("Variance of {what} (Sobol, total): {names}", what=what, names=say.join(*names))
    if of.rare_failures:
        rare = sorted(of.rare_failures, key=lambda r: -r.failure_probability)[:MAX_NAMED]
        names = [
            f"{limit_name(r.limit, say)} {once_in_text(r.failure_probability, say)}" for r in rare
        ]
        yield say("Rare failures: {names}", names=say.join(*names))
    if len(state["worst"]["place"]):
        worst = state["worst"]
        yield say(
            "Worst variant: {place}, smallest margin {margin} ({limit})",
            place=int(worst["place"][0]), margin=_margin_text(float(worst["margin"][0]), say),
            limit=deciding_limit_name(of, int(worst["limit"][0]), say),
        )  # fmt: skip
    if "pareto" in state:
        count = len(state["pareto"]["place"])
        yield say.count(
            "{count} variant that no other beats (--all)",
            "{count} variants that no other beats (--all)", count,
        )  # fmt: skip


def _tighter_text(of: VariantStudyResult, say: Translator) -> str:
    """Return which tolerances, each half as wide, raise the yield by more than two errors."""
    passes, error = halved_tolerance_yields(of.statistics["tighter"])
    gains = passes[:, 0] - of.yield_
    order = np.argsort(-gains, kind="stable").tolist()
    names = [
        f"{of.sampling_plan.name_of(of.tolerance_factors[t])} "
        f"{percent_text(float(passes[t, 0]), say)} "
        f"{say.with_decimal_sign(f'(± {200 * error[t, 0]:.1f} %)')}"
        for t in order
        if gains[t] > 2 * error[t, 0]
    ]
    if not names:
        return say("No tolerance half as wide raises the yield by more than its error.")
    return say("Yield with one tolerance half as wide: {names}", names="; ".join(names[:MAX_NAMED]))
