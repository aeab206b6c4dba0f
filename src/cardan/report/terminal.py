"""What a terminal shows: the verdict, each limit, what would help, the numbers by state.

Text is marked with colours; whoever prints it takes them out where there is no terminal.
"""

import sys
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace
from itertools import zip_longest
from typing import TYPE_CHECKING

from cardan.base.verdict import GRADES, Check, Unanswered, Verdict, badness
from cardan.quantity.declared import Quantity
from cardan.quantity.quantities import QUANTITIES
from cardan.quantity.response import Response
from cardan.report import phased
from cardan.report.language import CODES, EN, Language
from cardan.report.screen import WIDTH, beside, folded, headings, wrapped
from cardan.report.screen import bare as bare  # for whoever prints
from cardan.report.sheet import line_title, sections
from cardan.report.wording import (
    cited,
    held,
    left,
    limit_of,
    move,
    moves_that_help,
    notes,
    nothing_better,
    place,
    problem,
    scattered,
    standing,
    survives,
    tally,
    unanswered,
    won,
    worst_of_each,
)
from cardan.study.approval import Approval, Coverage
from cardan.study.finding import RECORDING
from cardan.study.sensitivity import Sensitivity

if TYPE_CHECKING:  # one check of one design is not to wait for these
    from cardan.report.blocks import Table
    from cardan.report.compare import Variant
    from cardan.study.fix import Proposal
    from cardan.study.published import Published
    from cardan.study.sizing import Remedy

    Sizes = dict[tuple[str, str], Remedy]

LONG = 14
"""Letters of a word over a column, at most, for whose sake it is wider than its numbers."""

FEW = 5
"""Limits that are shown at least, though they pass."""

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
    states: bool = False,
    phasings: bool = False,
    say: Language = EN,
    width: int = WIDTH,
) -> Iterator[str]:
    """Yield what an approval has to say, line by line of text, the worst first.

    Without `every` each limit that does not pass has one row, where it is worst, and where
    they are few the nearest of the others; with it each check has its row. `states` adds the
    numbers of every state; `sizes` are other parts, for what nothing moved answers.
    """
    yield from verdict(of, say, every=every, brief=not every, width=width)
    several = len(of.responses) > 1
    yield from folded(_helps(tuple(helps), sizes or {}, say, several=several), width)
    heard = of.of(RECORDING)
    if heard is not None:
        from cardan.report.life import mix_lines  # few checks ask it

        yield from mix_lines(heard, say)
    if every or phasings:
        for response in of.responses:
            yield from _phased(response, say, width, several=several)
    if every or states:
        for response in of.responses:
            yield from _line(response, say, width)
    elif not phasings:
        yield ""
        yield from folded([say("--states shows the numbers of every state, --all every check.")],
                          width)  # fmt: skip


def verdict(
    of: Approval,
    say: Language = EN,
    *,
    every: bool = False,
    brief: bool = False,
    width: int = WIDTH,
) -> Iterator[str]:
    """Yield the verdict, each limit where it is worst, what has no answer, and notes.

    `brief` leaves out the limits that pass, but the few nearest.
    """
    yield from folded(summary(of, say), width)
    yield from folded(facts(of, say), width)
    yield from checks(of, say, every=every, brief=brief, width=width)
    yield from folded(without_answer(unanswered(of, say), of.coverage, say), width)
    yield from folded(notes(of, say), width)
    if of.data:
        from cardan.report import data

        title = say("Data it stands on, and how it was read (`cardan catalogue` has its sources)")
        yield ""
        yield from folded([_bold(title), *(f"  {line}" for line in data.lines(of, say))], width)


def facts(of: Approval, say: Language) -> Iterator[str]:
    """Yield the profile that a verdict is by, and how near the nearest limit is."""
    said = say("limits: {profile}", profile=of.application.profile)
    if of.smallest_margin is None:
        yield said
        return
    yield say("{limits}; smallest margin {margin}", limits=said,
              margin=say.percent(of.smallest_margin))  # fmt: skip


def block(of: "Table", width: int | None = None) -> Iterator[str]:
    """Yield a table of a story, columns as wide as they need to be, heads in several lines.

    On a screen of a width, columns that have no room stand below, beside the first again.
    """
    cells = [max([0, *(len(row[k]) for row in of.rows)]) for k in range(len(of.head))]
    wide = [max(c, *map(len, h.split() or [""])) for c, h in zip(cells, of.head, strict=True)]
    heads = [wrapped(h, w) for h, w in zip(of.head, wide, strict=True)]
    wide = [max(w, *map(len, h)) for w, h in zip(wide, heads, strict=True)]
    yield ""
    yield _bold(of.caption)
    lead = max(of.words, 1)
    for some in _fitting(wide, lead, width):
        high = max(len(heads[k]) for k in some)
        rows = [tuple(([""] * (high - len(h)) + h)[-high:][k] for h in heads) for k in range(high)]
        for row in (*rows, *of.rows):
            line = (
                f"{row[k]:<{wide[k]}}" if k < of.words else f"{row[k]:>{wide[k]}}" for k in some
            )
            yield "  " + "  ".join(line).rstrip()


def _fitting(wide: Sequence[int], lead: int, width: int | None) -> Iterator[list[int]]:
    """Yield places of columns that fit beside the first ones."""
    rest = list(range(lead, len(wide)))
    while rest or lead == len(wide):
        some, room = list(range(lead)), (width or sys.maxsize) - sum(2 + w for w in wide[:lead])
        while rest and (len(some) == lead or 2 + wide[rest[0]] <= room):
            room -= 2 + wide[rest[0]]
            some.append(rest.pop(0))
        yield some
        if not rest:
            return


def without_answer(found: Sequence[str], coverage: Coverage, say: Language) -> Iterator[str]:
    """Yield the limits that got no answer, and what would have to be given for one."""
    if found:
        yield ""
        yield _bold(
            say("Without an answer ({answered} of {asked} answered)",
                answered=coverage.answered, asked=coverage.asked)
        )  # fmt: skip
        yield from (f"  {line}" for line in found)


def comparison(of: "Sequence[Variant]", say: Language = EN, *, width: int = WIDTH) -> Iterator[str]:
    """Yield variants side by side: verdicts, what differs in the input, each limit."""
    from cardan.report.compare import differences, effects

    wide = 20
    most = max(1, (width - 2 - 24) // wide)
    room = max(width - 2 - wide * min(len(of), most), 24)
    changes, results = differences(of, say), effects(of, say)

    def row(
        name: str, values: Sequence[str], grades: Sequence[Verdict | None], mark: str = " "
    ) -> Iterator[str]:
        cells = [wrapped(v, wide - 1) for v in values]
        for k, (title, *line) in enumerate(zip_longest(wrapped(name, room - 1), *cells)):
            shown = (
                _graded(g, text) if g else text
                for g, text in zip(grades, (f"{t or '':>{wide}}" for t in line), strict=True)
            )
            yield f"{mark if k == 0 else ' '} {title or '':<{room}}{''.join(shown)}".rstrip()

    for start in range(0, len(of), most):
        some = slice(start, start + most)
        none = (None,) * len(of[some])
        yield _bold(say("Variants side by side"))
        names = [f"{k}. {v.name}" for k, v in enumerate(of, 1)][some]
        yield from (f"  {'':{room}}{line}" for line in headings(names, wide))
        found: list[Verdict] = [v.approval.verdict for v in of[some]]
        yield from row(say("verdict"), [say(v).upper() for v in found], found)
        yield ""
        yield _bold(say("What differs in the input"))
        for one in changes:
            yield from row(one.name, one.values[some], none)
        if not changes:
            yield "  " + say("nothing")
        yield ""
        yield _bold(say("What it does to each limit, where it is worst"))
        for one in results:
            mark = "*" if one.changed else " "
            yield from row(one.name, one.values[some], one.grades[some], mark)
        yield say("* the verdict differs")
        if start + most < len(of):
            yield ""


def proposals(
    of: "tuple[Proposal, ...]",
    say: Language = EN,
    *,
    helps: Sequence[Sensitivity] = (),
    several: bool = False,
) -> Iterator[str]:
    """Yield corrections, best first, with what each moves, costs and wins.

    Where there is none, what each move `helps` and spoils says why.
    """
    if not of:
        yield nothing_better(say)
        if helps := [one for one in helps if one.helpful]:
            yield say("Each move alone:")
            yield from _moved(helps, {}, say, several=several)
        return
    yield say(
        "Line {line}; as installed: {standing}.",
        line=of[0].line, standing=standing(of[0].installed, say),
    )  # fmt: skip
    yield say("Cost is the share of the given ranges in use; a turned yoke counts 0.5.")
    if scatter := scattered(of[0].trucks, say):
        yield scatter
    for k, p in enumerate(of, 1):
        yield ""
        cost = say.short(round(p.cost, 2))
        to = say("{standing}, cost {cost}", standing=standing(p.approval, say), cost=cost)
        yield _graded(p.verdict, f"{k}. {to}")
        yield from (f"     {move(m, say)}" for m in p.moves)
        yield f"     {won(p, say)}"
        yield from (f"     {one}" for one in survives(p.survival, p.trucks, say))
        yield from (f"     {one}" for one in left(p, say, grade=_graded))


def explanation(q: Quantity, say: Language = EN) -> Iterator[str]:
    """Yield what a quantity is: equation, symbols, source, limits of use."""
    yield f"{_bold(say.name(q.key))}  {q.symbol}" + (f" [{q.unit_name}]" if q.unit_name else "")
    yield f"    {say.given(q.stated)}"
    yield from (f"      {symbol}: {say.given(meaning)}" for symbol, meaning in q.where.items())
    if q.use:
        yield f"  {say('Limits of use')}: {say.given(q.use)}"
    yield f"  {say('Source')}: {cited(q.source, say)}"
    yield from _limits_on(q, say)
    others = "; ".join(f"{c}: {Language(c).name(q.key)}" for c in CODES if c != "en")
    yield f"  {say('Key')}: {q.key}; {others}"


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


def published(cases: "Iterable[Published]", *, width: int = WIDTH) -> Iterator[str]:
    """Yield published cases with what was expected and what this machine computes."""
    room = width - 6 - 13 - 13 - 11
    yield f"{'':6}{'case':<{room}}{'published':>13}{'computed':>13}{'difference':>11}"
    kind = ""
    for c in cases:
        if c.kind != kind:
            kind = c.kind
            yield ""
            yield _bold(KINDS[kind])
        word = _graded("pass", "ok    ") if c.agrees else _graded("fail", "WRONG ")
        numbers = f"{c.expected:>13.6g}{c.computed:>13.6g}{c.difference:>+11.2%}"
        first, *others = beside(c.title, numbers, room)
        yield f"{word}{first}"
        yield from (f"{'':6}{line}" for line in others)
        yield from folded([f"{'':6}{'':2}{c.source}"], width)


def checks(
    of: Approval, say: Language, *, every: bool = False, brief: bool = False, width: int = WIDTH
) -> Iterator[str]:
    """Yield a table of checks, those that do not pass first, and the sources of its limits."""
    rows = sorted(of.checks, key=badness) if every else worst_of_each(of.checks)
    shown = rows
    if brief:
        bad = sum(c.grade != "pass" for c in rows)
        shown = rows[: max(bad, FEW)]
    yield from table(shown, say, several=len(of.responses) > 1, width=width)
    told = set(map(limit_of, shown))
    if rest := [c for c in rows[len(shown) :] if limit_of(c) not in told]:
        count = len(set(map(limit_of, rest)))
        means = (
            "One more limit passes, by {margin}; --all shows it."
            if count == 1
            else "{count} more limits pass, the nearest by {margin}; --all shows them."
        )
        said = say(means, count=count, margin=say.percent(min(c.margin for c in rest)))
        yield from folded([said], width)


def table(
    rows: Sequence[Check], say: Language, *, several: bool = False, width: int = WIDTH
) -> Iterator[str]:
    """Yield a table of checks as they come, and the sources of their limits.

    Where a check is worst stands beside its name if the screen is wide, else below it.
    """
    if not rows:
        return
    sources = list(dict.fromkeys(cited(c.limit.source, say) for c in rows))
    grade = 2 + max(len(say(g)) for g in GRADES)
    numbers = _aligned(
        [(say("value"), "", say("limit"), say("unit"), say("margin"), "")]
        + [_numbers(c, say, sources.index(cited(c.limit.source, say)) + 1) for c in rows],
        right=(0, 4),
    )
    places = [(say.name(c.quantity), place(c, say, several=several)) for c in rows]
    room = width - grade - 2 - len(numbers[0])
    name, where = (max(map(len, column)) for column in zip(*places, strict=True))
    split = min(name, room * 4 // 9)
    apart = split >= min(name, 30) and room - split - 2 >= min(where, 40)
    yield ""
    head = say("limit"), say("where it is worst")
    if apart:
        left = f"{head[0]:<{split + 2}}{head[1]}"
    else:
        left = say.list(*head) if len(say.list(*head)) <= room else head[0]
    yield _bold(f"{'':{grade}}{left:<{room + 2}}{numbers[0]}".rstrip())
    for c, (what, at), row in zip(rows, places, numbers[1:], strict=True):
        if apart:
            lines = _two(what, at, split, room)
        else:
            lines = [*wrapped(what, room), *(f"  {x}" for x in wrapped(at, width - grade - 2))]
        first, *others = lines
        yield (f"{_graded(c.grade, f'{say(c.grade):<{grade}}')}{first:<{room + 2}}{row}").rstrip()
        yield from (f"{'':{grade}}{line}" for line in others)
    yield from folded((f"  [{k}] {source}" for k, source in enumerate(sources, 1)), width)


def _numbers(c: Check, say: Language, source: int) -> tuple[str, ...]:
    """Return the cells of a check: value, sense, limit, unit, margin, number of its source."""
    value, bound = held(c, say)
    unit = QUANTITIES[c.quantity].unit_name
    return value, _sense(c, say), bound, unit, say.percent(c.margin), f"[{source}]"


def _aligned(rows: Sequence[tuple[str, ...]], *, right: Sequence[int]) -> list[str]:
    """Return rows as lines as long as each other: columns a space apart, some to the right."""
    wide = [max(map(len, column)) for column in zip(*rows, strict=True)]
    return [
        " ".join(
            f"{cell:>{w}}" if k in right else f"{cell:<{w}}"
            for k, (cell, w) in enumerate(zip(row, wide, strict=True))
        )
        for row in rows
    ]


def _two(first: str, second: str, split: int, room: int) -> list[str]:
    """Return lines of two texts beside each other."""
    left, right = wrapped(first, split), wrapped(second, room - split - 2)
    return [f"{a:<{split + 2}}{b}".rstrip() for a, b in zip_longest(left, right, fillvalue="")]


def _sense(c: Check, say: Language) -> str:
    """Return how a value stands to its limit, in characters of any terminal."""
    return say("outside") if c.limit.band else c.limit.sense


def _phased(r: Response, say: Language, width: int, *, several: bool) -> Iterator[str]:
    """Yield a line with its yokes in every way."""
    for one in phased.table(r, say):
        caption = f"{r.line.name}: {one.caption}" if several else one.caption
        yield from block(replace(one, caption=caption), width)


def _helps(
    of: tuple[Sensitivity, ...], sizes: "Sizes", say: Language, *, several: bool
) -> Iterator[str]:
    """Yield what moving things would do to what does not pass."""
    if not of:
        return
    yield ""
    yield _bold(say("What would help (each alone; `cardan fix` looks for the best together)"))
    yield from _moved(of, sizes, say, several=several)


def _moved(
    of: Iterable[Sensitivity], sizes: "Sizes", say: Language, *, several: bool
) -> Iterator[str]:
    """Yield what does not pass, each with the moves that help or what there is instead."""
    hopeless: set[tuple[str, str]] = set()
    for one in of:
        moves, what = moves_that_help(one, say), (one.check.line, one.check.quantity)
        if not moves and what in hopeless:
            continue  # said of the part that is worst
        hopeless |= set() if moves else {what}
        yield f"  {problem(one, say, several=several)}"
        yield from (f"      {m}" for m in moves or [instead(one.check, sizes.get(what), say)])


def instead(check: Check, remedy: "Remedy | None", say: Language) -> str:
    """Return what there is where nothing can be moved: another part, or who looks for one."""
    if remedy is None:
        from cardan.study.sizing import WAYS

        if check.quantity in WAYS:
            return say("nothing that can be moved; `cardan size` tries other parts")
        return say("nothing that can be moved")
    from cardan.report.sizing import instead as other_part

    return other_part(remedy, say)


def _line(r: Response, say: Language, width: int) -> Iterator[str]:
    """Yield the numbers of one line, rows over states, as many states beside each other as fit."""
    yield ""
    yield _bold(line_title(r, say))
    for section in sections(r):
        labels = [row.label(say) for row in section.rows]
        unit = 2 + max(len(row.unit) for row in section.rows)
        room = min(max(map(len, labels)) + 3, max(32, width * 3 // 8))
        cells = [[say.number(v) for v in row.values] for row in section.rows]
        states = [say.state(s) for s in r.demand.states]
        words = [1 + min(len(word), LONG) for name in states for word in name.split()]
        column = max(9, *words, *(2 + len(cell) for row in cells for cell in row))
        most = max(1, (width - room - unit) // column)
        for start in range(0, len(states), most):
            some = slice(start, start + most)
            yield ""
            head = headings(states[some], column)
            title = wrapped(say(section.title), room + unit - 1)
            names = [""] * (len(head) - len(title)) + title
            heads = [""] * (len(title) - len(head)) + head
            for name, over in zip(names, heads, strict=True):
                yield _bold(f"{name:<{room + unit}}{over}".rstrip())
            for row, label, values in zip(section.rows, labels, cells, strict=True):
                numbers = f"{row.unit:<{unit}}" + "".join(f"{v:>{column}}" for v in values[some])
                yield from _hanging(label, numbers, room)


def _hanging(label: str, numbers: str, room: int) -> Iterator[str]:
    """Yield a row of numbers; of a long name the last line stands beside them."""
    indent = len(label) - len(label.lstrip())
    first, *others = wrapped(label.strip(), room - 3 - indent)
    *above, last = [" " * indent + first, *(" " * (indent + 2) + line for line in others)]
    yield from above
    yield f"{last:<{room}}{numbers}".rstrip()


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
