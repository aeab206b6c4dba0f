"""What a terminal shows: the verdict, each limit, what would help, the numbers by state.

Text is marked with colours; whoever prints it takes them out where there is no terminal.
"""

import math
from collections.abc import Iterable, Iterator

from cardan.base.quantities import QUANTITIES
from cardan.base.quantity import Quantity
from cardan.base.units import deg, mm
from cardan.base.verdict import GRADES, Check, Grade
from cardan.model.application import Adjustable
from cardan.report.sheet import Row, sections
from cardan.study.assess import Assessment
from cardan.study.fix import Move, Proposal
from cardan.study.published import Published
from cardan.study.response import Response
from cardan.study.sensitivity import Effect, Sensitivity

LABEL = 44
"""Width of the names of rows."""

COLUMN = 13
"""Width of a state's column."""

COLOURS: dict[Grade, str] = {"pass": "\x1b[32m", "warn": "\x1b[33m", "fail": "\x1b[1;31m"}
BOLD, PLAIN = "\x1b[1m", "\x1b[0m"


def number(value: float) -> str:
    """Return a number as an engineer writes it down: four figures."""
    if math.isnan(value):
        return "-"
    if math.isinf(value):
        return "∞" if value > 0 else "-∞"
    if abs(value) < 5e-7:
        return "0"
    size = math.floor(math.log10(abs(value)))
    return f"{value:.{max(0, 3 - size)}f}" if -3 <= size < 7 else f"{value:.3e}"


def summary(of: Assessment) -> Iterator[str]:
    """Yield the verdict in a line."""
    checks = of.checks
    counts = ", ".join(f"{sum(c.grade == g for c in checks)} {g}" for g in reversed(GRADES))
    yield f"{_bold(of.application.title)}: {_graded(of.verdict, of.verdict.upper())} ({counts})"


def assessment(
    of: Assessment, *, helps: Iterable[Sensitivity], every: bool = False
) -> Iterator[str]:
    """Yield everything a check has to say, line by line of text.

    With `every` each check has its row; without, each limit has one, the worst.
    """
    yield from summary(of)
    yield f"limits: {of.application.profile}"
    yield from _checks(of, every=every)
    if of.unasked():
        names = ", ".join(QUANTITIES[q].name.lower() for q in of.unasked())
        yield f"Not asked, for want of data: {names}."
    yield from (f"Note: {note}." for note in of.notes)
    yield from _helps(tuple(helps))
    for response in of.responses:
        yield from _line(response)


def proposals(of: tuple[Proposal, ...]) -> Iterator[str]:
    """Yield corrections, best first, with what each moves, costs and wins."""
    if not of:
        yield "Nothing that may be moved changes any limit: see `adjust` in the application file."
        return
    yield f"Line {of[0].line}, smallest margin as installed {_percent(of[0].before)}."
    yield "Cost is the share of the given ranges in use; a turned yoke counts 0.5."
    for k, p in enumerate(of, 1):
        yield ""
        verdict = _graded(p.verdict, f"{p.verdict:<4}")
        yield f"{k}. {verdict}  smallest margin {_percent(p.margin)}, cost {p.cost:.2f}"
        yield from (f"     {_move(m)}" for m in p.moves)
        bad = [c for c in p.checks if c.grade != "pass"]
        for c in _worst_of_each(bad)[:3]:
            yield f"     still {_graded(c.grade, c.grade)}: {_sentence(c)}"


def explanation(q: Quantity) -> Iterator[str]:
    """Yield what a quantity is: equation, symbols, source, limits of use."""
    yield f"{_bold(q.name)}  {q.symbol}" + (f" [{q.unit_name}]" if q.unit_name else "")
    yield f"    {q.equation}"
    yield from (f"      {symbol}: {meaning}" for symbol, meaning in q.where.items())
    if q.use:
        yield f"  Limits of use: {q.use}"
    yield f"  Source: {q.source}"
    yield f"  Key: {q.key}; pt: {q.pt}; it: {q.it}"


def published(cases: Iterable[Published]) -> Iterator[str]:
    """Yield published cases with what was expected and what this machine computes."""
    yield f"{'':6}{'case':<66}{'published':>13}{'computed':>13}{'difference':>12}"
    for c in cases:
        word = _graded("pass", "ok    ") if c.agrees else _graded("fail", "WRONG ")
        yield (
            f"{word}{_fit(c.title, 66)}{number(c.expected):>13}{number(c.computed):>13}"
            f"{c.difference:>+11.2%}"
        )
        yield f"{'':6}{'':2}{c.source}"


def _checks(of: Assessment, *, every: bool) -> Iterator[str]:
    """Yield a table of checks, those that do not pass first, and the sources of its limits."""
    rows = sorted(of.checks, key=_badness) if every else _worst_of_each(of.checks)
    sources = list(dict.fromkeys(str(c.limit.source) for c in rows))
    several = len(of.responses) > 1
    yield ""
    yield _bold(
        f"{'':6}{'limit':<36}{'where it is worst':<36}{'value':>9} {'':8}{'limit':<9}"
        f"{'unit':<9}{'margin':>7}  source"
    )
    for c in rows:
        q = QUANTITIES[c.quantity]
        where = c.state if c.part == "line" else f"{c.state}, {c.part}"
        where = f"{c.line}: {where}" if several else where
        sense = "outside" if c.limit.band else c.limit.sense
        yield (
            f"{_graded(c.grade, f'{c.grade:<6}')}{_fit(q.name, 36)}{_fit(where, 36)}"
            f"{number(c.value / q.factor):>9} {sense:<8}{_fit(number(c.bound / q.factor), 9)}"
            f"{_fit(q.unit_name, 9)}{_percent(c.margin):>7}"
            f"  [{sources.index(str(c.limit.source)) + 1}]"
        )
    yield from (f"  [{k}] {source}" for k, source in enumerate(sources, 1))


def _helps(of: tuple[Sensitivity, ...]) -> Iterator[str]:
    """Yield what moving things would do to what does not pass."""
    if not of:
        return
    yield ""
    yield _bold("What would help (each alone; `cardan fix` looks for the best together)")
    for one in of:
        useful = [e for e in one.effects if one.gain(e) > 0][:3]
        tried = "; ".join(_effect(one, e) for e in useful) or "nothing that can be moved"
        states = f" ({len(one.states)} states)" if len(one.states) > 1 else ""
        yield f"  {_sentence(one.check)}{states}"
        yield f"      {tried}"


def _effect(one: Sensitivity, e: Effect) -> str:
    """Return what one move does, the better way of the two."""
    q = QUANTITIES[one.check.quantity]
    limit = one.check.limit
    better = max((e.back, -e.step), (e.forth, e.step), key=lambda t: float(
        limit.margin(t[0], to="normal")))  # fmt: skip
    value, step = better
    moved = _move(Move(adjustable=e.adjustable, amount=step))
    return f"{moved} gives {number(value / q.factor)}"


def _line(r: Response) -> Iterator[str]:
    """Yield the numbers of one line, rows over states."""
    states = r.demand.states
    shafts = len(r.line.shafts)
    yield ""
    yield _bold(f"Line {r.line.name}: {shafts} shaft{'s' * (shafts > 1)}, {shafts + 1} joints")
    head = "".join(f"{_fit(s, COLUMN - 1):>{COLUMN}}" for s in states)
    for section in sections(r):
        yield ""
        yield _bold(f"{_fit(section.title, LABEL)}{'':8}{head}")
        yield from (_row(row) for row in section.rows)


def _row(row: Row) -> str:
    """Return a row of numbers."""
    values = "".join(f"{number(v):>{COLUMN}}" for v in row.values)
    return f"{_fit(row.label(), LABEL)}{_fit(row.unit, 8)}{values}"


def _worst_of_each(checks: Iterable[Check]) -> list[Check]:
    """Return the worst check of each limit, those that do not pass first."""
    worst: dict[tuple[str, str, int], Check] = {}
    for c in sorted(checks, key=_badness):
        worst.setdefault((c.quantity, c.line, id(c.limit)), c)
    return sorted(worst.values(), key=_badness)


def _badness(c: Check) -> tuple[int, float]:
    return -GRADES.index(c.grade), c.margin


def _sentence(c: Check) -> str:
    """Return a check as a sentence: what, where, how much, against what."""
    q = QUANTITIES[c.quantity]
    part = "" if c.part == "line" else f", {c.part}"
    return (
        f"{q.name}{part} in {c.state}: {number(c.value / q.factor)} against "
        f"{number(c.bound / q.factor)} {q.unit_name}"
    )


def _move(m: Move) -> str:
    """Return a move in a workshop's words."""
    a, amount = m.adjustable, m.amount
    match a.what:
        case "bearing_height":
            way = "up" if amount > 0 else "down"
            return f"bearing {a.part} {way} {abs(amount) / mm:g} mm"
        case "bearing_side":
            way = "to the right" if amount > 0 else "to the left"
            return f"bearing {a.part} {way} {abs(amount) / mm:g} mm"
        case "shim":
            return f"pinion nose {'up' if amount > 0 else 'down'} {abs(amount) / deg:.3g} deg"
        case "phase":
            return f"rear yoke of shaft {a.part} turned {amount / deg:+.4g} deg"


def movable(a: Adjustable) -> str:
    """Return a thing that may be moved and how far, in a workshop's words."""
    low = _move(Move(adjustable=a, amount=a.low))
    return f"{low} to {_move(Move(adjustable=a, amount=a.high))}"


def _fit(text: str, width: int) -> str:
    """Return a text in a column of a width, cut where it is longer."""
    return f"{text if len(text) < width else text[: width - 2] + '…':<{width}}"


def _percent(margin: float) -> str:
    """Return a margin as a share in per cent, cut where it says nothing more."""
    return "< -999 %" if margin < -9.99 else f"{margin:+.0%}".replace("%", " %")


def _bold(text: str) -> str:
    return f"{BOLD}{text}{PLAIN}"


def _graded(grade: Grade, text: str) -> str:
    return f"{COLOURS[grade]}{text}{PLAIN}"
