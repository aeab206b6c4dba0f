"""Parts that the first screens of all commands share: title with verdict, lists that are capped."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

from cardan.core.verdict import Verdict
from cardan.render.i18n import Translator
from cardan.render.phrases import is_partial_approval, verdict_text
from cardan.render.terminal import bold, coloured_by_grade
from cardan.render.text_layout import display_width, fold_lines, wrap_text

if TYPE_CHECKING:  # a recording does not wait for the physics of a driveline
    from cardan.approval.approval import Approval


def title_and_verdict_lines(title: str, said: str, grade: Verdict, width: int) -> list[str]:
    """Return a title and its verdict, in one line if it has room for both."""
    shown = coloured_by_grade(grade, said)
    room = width - display_width(title) - display_width(said)
    if room >= 2:
        return [bold(title) + " " * room + shown]
    return [*(bold(line) for line in wrap_text(title, width)), *fold_lines([f"  {shown}"], width)]


def title_lines(of: "Approval", say: Translator, width: int) -> list[str]:
    """Return title and verdict, in one line if it has room for both."""
    partial = is_partial_approval(of) and of.verdict in ("pass", "warn")
    grade = "warn" if partial else of.verdict
    return title_and_verdict_lines(of.application.title, verdict_text(of, say), grade, width)


def more_text(count: int, option: str, say: Translator) -> str:
    """Return how much an option shows beyond this."""
    return say("+{count} more ({option})", count=count, option=option)


def capped_list_lines(
    lead: str, items: Sequence[str], lines: int, option: str, say: Translator, width: int
) -> list[str]:
    """Return a list after its lead in so many lines at most, the rest counted."""
    for shown in range(len(items), 0, -1):
        rest = len(items) - shown
        more = [more_text(rest, option, say)] if rest else []
        found = list(fold_lines([f"{lead} {'; '.join([*items[:shown], *more])}"], width))
        if len(found) <= lines or shown == 1:
            return found
    return []


def capped_item_lines(
    items: Sequence[str], count: int, option: str, say: Translator, width: int
) -> list[str]:
    """Return items below each other in `count` lines, the rest counted; the first is whole."""
    found: list[str] = []
    for k, item in enumerate(items):
        lines = list(fold_lines([f"  {item}"], width))
        last = k == len(items) - 1
        if found and len(found) + len(lines) > count - (not last):
            return [*found, f"  {more_text(len(items) - k, option, say)}"]
        found += lines
    return found


def percent_text(value: float, say: Translator, digits: int = 1) -> str:
    """Return a share in per cent; what is not none or all of them never reads so."""
    while 0 < value < 1 and digits < 9 and float(f"{100 * value:.{digits}f}") in (0, 100):
        digits += 1
    return say.with_decimal_sign(f"{100 * value:.{digits}f} %")


def share_text(share: float, say: Translator) -> str:
    """Return a share in per cent; beyond 100 % as beyond, where a number says no more."""
    if abs(share) > 1.005:
        return say("over {share}" if share > 0 else "under {share}", share=say.percentage(
            1.0 if share > 0 else -1.0
        ))  # fmt: skip
    return say.percentage(share)
