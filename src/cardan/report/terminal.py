"""What a terminal shows: the verdict, each limit, what would help, the numbers by state.

Text is marked with colours; whoever prints it takes them out where there is no terminal.
"""

import re
from collections.abc import Iterable, Iterator, Sequence
from typing import TYPE_CHECKING

from cardan.base.verdict import GRADES, Check, Unanswered, Verdict
from cardan.quantity.declared import Quantity
from cardan.quantity.quantities import QUANTITIES
from cardan.quantity.response import Response
from cardan.report.language import CODES, EN, Language
from cardan.report.sheet import Row, line_title, sections
from cardan.report.wording import (
    badness,
    cited,
    left,
    move,
    moves_that_help,
    notes,
    place,
    problem,
    tally,
    unanswered,
    worst_of_each,
)
from cardan.study.approval import Approval, Coverage
from cardan.study.sensitivity import Sensitivity

if TYPE_CHECKING:  # one check of one design is not to wait for these
    from cardan.report.blocks import Table
    from cardan.report.compare import Variant
    from cardan.study.fix import Proposal
    from cardan.study.published import Published
    from cardan.study.sizing import Remedy

    Sizes = dict[tuple[str, str], Remedy]

LABEL = 48
"""Width of the names of rows."""

COLUMN = 13
"""Width of a state's column."""

COLOURS: dict[Verdict, str] = {
    "pass": "\x1b[32m", "warn": "\x1b[33m", "incomplete": "\x1b[35m", "fail": "\x1b[1;31m",
}  # fmt: skip
BOLD, PLAIN = "\x1b[1m", "\x1b[0m"


def summary(of: Approval, say: Language = EN) -> Iterator[str]:
    """Yield the verdict in a line."""
    yield headline(of.application.title, of.verdict, of.checks, of.coverage.unanswered, say)


def headline(
    title: str,
    verdict: Verdict,
    checks: Iterable[Check],
    unanswered: Sequence[Unanswered],
    say: Language = EN,
) -> str:
    """Return a verdict in a line: of what, and how many checks came to which grade."""
    said = _graded(verdict, say(verdict).upper())
    return f"{_bold(title)}: {said} ({tally(checks, say, unanswered)})"


def approval(
    of: Approval,
    *,
    helps: Iterable[Sensitivity],
    sizes: "Sizes | None" = None,
    every: bool = False,
    say: Language = EN,
) -> Iterator[str]:
    """Yield everything an approval has to say, line by line of text.

    With `every` each check has its row; without, each limit has one, the worst. `sizes` are
    other parts, for what nothing moved answers.
    """
    yield from verdict(of, say, every=every)
    yield from _helps(tuple(helps), sizes or {}, say, several=len(of.responses) > 1)
    for response in of.responses:
        yield from _line(response, say)


def verdict(of: Approval, say: Language = EN, *, every: bool = False) -> Iterator[str]:
    """Yield the verdict, each limit where it is worst, what has no answer, and notes."""
    yield from summary(of, say)
    yield say("limits: {profile}", profile=of.application.profile)
    yield from checks(of, say, every=every)
    yield from without_answer(unanswered(of, say), of.coverage, say)
    yield from notes(of, say)
    if of.data:
        from cardan.report import data

        yield ""
        yield _bold(
            say("Data it stands on, and how it was read (`cardan catalogue` has its sources)")
        )
        yield from (f"  {line}" for line in data.lines(of, say))


def block(of: "Table") -> Iterator[str]:
    """Yield a table of a story, columns as wide as they need to be."""
    rows = [of.head, *of.rows]
    wide = [max(len(row[k]) for row in rows) for k in range(len(of.head))]
    yield ""
    yield _bold(of.caption)
    for row in rows:
        cells = [
            f"{cell:<{w}}" if k < of.words else f"{cell:>{w}}"
            for k, (cell, w) in enumerate(zip(row, wide, strict=True))
        ]
        yield "  " + "  ".join(cells).rstrip()


def bare(lines: Iterable[str]) -> str:
    """Return lines as one text without colours, for where nobody prints to a terminal."""
    return re.sub(r"\x1b\[[0-9;]*m", "", "\n".join(lines))


def without_answer(found: Sequence[str], coverage: Coverage, say: Language) -> Iterator[str]:
    """Yield the limits that got no answer, and what would have to be given for one."""
    if found:
        yield ""
        yield _bold(
            say("Without an answer ({answered} of {asked} answered)",
                answered=coverage.answered, asked=coverage.asked)
        )  # fmt: skip
        yield from (f"  {line}" for line in found)


def comparison(of: "Sequence[Variant]", say: Language = EN) -> Iterator[str]:
    """Yield variants side by side: verdicts, what differs in the input, each limit."""
    from cardan.report.compare import differences, effects

    yield _bold(say("Variants side by side"))
    wide = 22
    head = "".join(_fit(f"{k}. {v.name}", wide) for k, v in enumerate(of, 1))
    yield f"{'':6}{'':40}{head}"
    verdicts = "".join(
        _graded(v.approval.verdict, _fit(say(v.approval.verdict).upper(), wide)) for v in of
    )
    yield f"{'':6}{_fit(say('verdict'), 40)}{verdicts}"
    yield ""
    yield _bold(say("What differs in the input"))
    rows = differences(of, say)
    for row in rows:
        yield f"{'':6}{_fit(row.name, 40)}" + "".join(_fit(v, wide) for v in row.values)
    if not rows:
        yield "      " + say("nothing")
    yield ""
    yield _bold(say("What it does to each limit, where it is worst"))
    for row in effects(of, say):
        shown = "".join(
            _graded(g, _fit(v, wide)) if g else _fit(v, wide)
            for v, g in zip(row.values, row.grades, strict=True)
        )
        yield f"{'*' if row.changed else ' ':6}{_fit(row.name, 40)}{shown}"
    yield say("* the verdict differs")


def proposals(of: "tuple[Proposal, ...]", say: Language = EN) -> Iterator[str]:
    """Yield corrections, best first, with what each moves, costs and wins."""
    if not of:
        yield say(
            "Nothing that may be moved changes any limit for the better: see `adjust` in the "
            "application file."
        )
        return
    before = say.percent(of[0].before)
    yield say("Line {line}, smallest margin as installed {margin}.", line=of[0].line, margin=before)
    yield say("Cost is the share of the given ranges in use; a turned yoke counts 0.5.")
    for k, p in enumerate(of, 1):
        yield ""
        margin, cost = say.percent(p.margin), say.short(round(p.cost, 2))
        won = say("smallest margin {margin}, cost {cost}", margin=margin, cost=cost)
        yield f"{k}. {_graded(p.verdict, say(p.verdict))}  {won}"
        yield from (f"     {move(m, say)}" for m in p.moves)
        yield from (f"     {one}" for one in left(p, say, grade=_graded))


def explanation(q: Quantity, say: Language = EN) -> Iterator[str]:
    """Yield what a quantity is: equation, symbols, source, limits of use."""
    yield f"{_bold(say.name(q.key))}  {q.symbol}" + (f" [{q.unit_name}]" if q.unit_name else "")
    yield f"    {say.given(q.stated)}"
    yield from (f"      {symbol}: {say.given(meaning)}" for symbol, meaning in q.where.items())
    if q.use:
        yield f"  {say('Limits of use')}: {say.given(q.use)}"
    yield f"  {say('Source')}: {q.source}"
    yield from _limits_on(q, say)
    others = "; ".join(f"{c}: {Language(c).name(q.key)}" for c in CODES if c != "en")
    yield f"  Key: {q.key}; {others}"


def _limits_on(q: Quantity, say: Language) -> Iterator[str]:
    """Yield what the default profile asks of a quantity, who says so and how that was read."""
    from cardan.files.limit import DEFAULT, limits

    for limit in limits(DEFAULT)[1]:
        if limit.quantity != q.key:
            continue
        low, high = limit.band or (None, None)
        bounds = (("normal", limit.normal), ("maximum", limit.maximum))
        said = [
            f"{say(name)} {limit.sense} {say.number(bound / q.factor)}"
            for name, bound in bounds
            if bound is not None
        ]
        if low is not None and high is not None:
            edges = (say.number(edge / q.factor) for edge in (low, high))
            said.append(f"{say('outside')} {' … '.join(edges)}")
        asks = " ".join((", ".join(said), q.unit_name)).rstrip()
        yield f"  {say('Limits')} ({DEFAULT}): {asks}"
        yield f"      {cited(limit.source, say)}"


KINDS = {
    "published": "Published where a reader can look",
    "untraced": "Printed somewhere that nobody found again",
    "derived": "Computed by other means, printed nowhere",
}
"""Heads of `cardan verify`."""


def published(cases: "Iterable[Published]") -> Iterator[str]:
    """Yield published cases with what was expected and what this machine computes."""
    yield f"{'':6}{'case':<66}{'published':>13}{'computed':>13}{'difference':>12}"
    kind = ""
    for c in cases:
        if c.kind != kind:
            kind = c.kind
            yield ""
            yield _bold(KINDS[kind])
        word = _graded("pass", "ok    ") if c.agrees else _graded("fail", "WRONG ")
        yield (
            f"{word}{_fit(c.title, 66)}{c.expected:>13.6g}{c.computed:>13.6g}{c.difference:>+11.2%}"
        )
        yield f"{'':6}{'':2}{c.source}"


def checks(of: Approval, say: Language, *, every: bool = False) -> Iterator[str]:
    """Yield a table of checks, those that do not pass first, and the sources of its limits."""
    rows = sorted(of.checks, key=badness) if every else worst_of_each(of.checks)
    yield from table(rows, say, several=len(of.responses) > 1)


def table(rows: Sequence[Check], say: Language, *, several: bool = False) -> Iterator[str]:
    """Yield a table of checks as they come, and the sources of their limits."""
    if not rows:
        return
    sources = list(dict.fromkeys(cited(c.limit.source, say) for c in rows))
    wide = 2 + max(len(say(g)) for g in GRADES)
    yield ""
    yield _bold(
        f"{'':{wide}}{_fit(say('limit'), 36)}{_fit(say('where it is worst'), 56)}"
        f"{say('value'):>9} {'':8}{_fit(say('limit'), 9)}"
        f"{_fit(say('unit'), 9)}{say('margin'):>7}  {say('source')}"
    )
    for c in rows:
        q = QUANTITIES[c.quantity]
        yield (
            f"{_graded(c.grade, f'{say(c.grade):<{wide}}')}{_fit(say.name(c.quantity), 36)}"
            f"{_fit(place(c, say, several=several), 56)}"
            f"{say.number(c.value / q.factor):>9} {_sense(c, say):<8}"
            f"{_fit(say.number(c.bound / q.factor), 9)}"
            f"{_fit(q.unit_name, 9)}{say.percent(c.margin):>7}"
            f"  [{sources.index(cited(c.limit.source, say)) + 1}]"
        )
    yield from (f"  [{k}] {source}" for k, source in enumerate(sources, 1))


def _sense(c: Check, say: Language) -> str:
    """Return how a value stands to its limit, in characters of any terminal."""
    return say("outside") if c.limit.band else c.limit.sense


def _helps(
    of: tuple[Sensitivity, ...], sizes: "Sizes", say: Language, *, several: bool
) -> Iterator[str]:
    """Yield what moving things would do to what does not pass."""
    if not of:
        return
    yield ""
    yield _bold(say("What would help (each alone; `cardan fix` looks for the best together)"))
    hopeless: set[tuple[str, str]] = set()
    for one in of:
        moves, what = moves_that_help(one, say), (one.check.line, one.check.quantity)
        if not moves and what in hopeless:
            continue  # said of the part that is worst
        hopeless |= set() if moves else {what}
        yield f"  {problem(one, say, several=several)}"
        yield f"      {'; '.join(moves) or instead(one.check, sizes.get(what), say)}"


def instead(check: Check, remedy: "Remedy | None", say: Language) -> str:
    """Return what there is where nothing can be moved: another part, or who looks for one."""
    if remedy is None:
        from cardan.study.sizing import WAYS

        if check.quantity in WAYS:
            return say("nothing that can be moved; `cardan size` tries other parts")
        return say("nothing that can be moved")
    from cardan.report.sizing import instead as other_part

    return other_part(remedy, say)


def _line(r: Response, say: Language) -> Iterator[str]:
    """Yield the numbers of one line, rows over states."""
    yield ""
    yield _bold(line_title(r, say))
    head = "".join(f"{_cut(say.state(s), COLUMN - 1):>{COLUMN}}" for s in r.demand.states)
    for section in sections(r):
        yield ""
        yield _bold(f"{_fit(say(section.title), LABEL)}{'':8}{head}")
        yield from (_row(row, say) for row in section.rows)


def _row(row: Row, say: Language) -> str:
    """Return a row of numbers."""
    values = "".join(f"{say.number(v):>{COLUMN}}" for v in row.values)
    return f"{_fit(row.label(say), LABEL)}{_fit(row.unit, 8)}{values}"


def _fit(text: str, width: int) -> str:
    """Return a text in a column of a width, with a space behind it, cut where it is longer."""
    return f"{_cut(text, width - 1):<{width}}"


def _cut(text: str, width: int) -> str:
    """Return a text, cut where it is longer than a width."""
    return text if len(text) <= width else f"{text[: width - 1]}…"


def _bold(text: str) -> str:
    return f"{BOLD}{text}{PLAIN}"


def _graded(grade: Verdict, text: str) -> str:
    return f"{COLOURS[grade]}{text}{PLAIN}"


def columns(rows: Sequence[tuple[str, ...]], *, words: Sequence[int] = (0,)) -> Iterator[str]:
    """Yield rows as lines of aligned cells: those of the places in `words` to the left."""
    width = [max(len(row[k]) for row in rows) for k in range(len(rows[0]))] if rows else []
    for row in rows:
        cells = (
            f"{cell:<{w}}" if k in words else f"{cell:>{w}}"
            for k, (cell, w) in enumerate(zip(row, width, strict=True))
        )
        yield "  ".join(cells).rstrip()
