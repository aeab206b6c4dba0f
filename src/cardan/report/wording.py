"""How checks, moves and effects are put into words, the same in every medium."""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace
from math import isinf, pi
from typing import TYPE_CHECKING

from cardan.base.errors import BadFile, Problem, RefusedInFile
from cardan.base.part import LINE
from cardan.base.source import Source
from cardan.base.units import rpm
from cardan.base.verdict import Check, Grade, Limit, Unanswered, badness, spoilt
from cardan.model.application import Adjustable
from cardan.model.movable import MOVABLES
from cardan.model.movable import movable as names_of
from cardan.quantity.quantities import QUANTITIES
from cardan.report.language import Language
from cardan.study.approval import Approval
from cardan.study.moves import Move
from cardan.study.sensitivity import Effect, Sensitivity

if TYPE_CHECKING:
    from cardan.demand.points import Curves
    from cardan.study.bracket_forced import Swept
    from cardan.study.fix import Proposal
    from cardan.study.robust import Survival, Trucks

STUDY_TITLES = {
    "vibration": "Vibration and stability",
    "bracket": "Bracket",
    "recording": "Recording",
}
"""What the chapters and sheets of studies are called beside the driveline's."""


def counts(of: Approval, say: Language) -> str:
    """Return how many checks have each grade, the worst first, and what has no answer."""
    return tally(of.checks, say, of.coverage.unanswered)


def counted(checks: Iterable[Check], say: Language) -> dict[Grade, str]:
    """Return how many checks have each grade in words, the worst first."""
    grades = [c.grade for c in checks]
    return {
        "fail": say.count("{count} fail", "{count} fail", grades.count("fail")),
        "warn": say.count("{count} warn", "{count} warn", grades.count("warn")),
        "pass": say.count("{count} pass", "{count} pass", grades.count("pass")),
    }


def tally(checks: Iterable[Check], say: Language, missed: Sequence[Unanswered] = ()) -> str:
    """Return how many checks have each grade, the worst first, and what has no answer."""
    said = list(counted(checks, say).values())
    if missed:
        said.append(say.count("{count} unanswered", "{count} unanswered", len(missed)))
    return ", ".join(said)


def worst_of_each(checks: Iterable[Check]) -> list[Check]:
    """Return the worst check of each limit, those that do not pass first.

    And that which its error may make worse than the error of the worst does it, if one may.
    """
    every = list(checks)
    worst, doubted = (_first(sorted(every, key=key)) for key in (_as_told, badness))
    also = (c for k, c in doubted.items() if badness(c)[:2] < badness(worst[k])[:2])
    return sorted([*worst.values(), *also], key=badness)


def _first(checks: Iterable[Check]) -> dict[tuple[str, str, Limit], Check]:
    """Return the first check of each limit."""
    found: dict[tuple[str, str, Limit], Check] = {}
    for c in checks:
        found.setdefault(limit_of(c), c)
    return found


def limit_of(c: Check) -> tuple[str, str, Limit]:
    """Return what checks of one limit have in common."""
    return c.quantity, c.line, c.limit


def _as_told(c: Check) -> tuple[int, float]:
    """Return what checks are sorted by where nobody asks what their error may make of them."""
    grade, _, margin = badness(c)
    return grade, margin


_HELD = (
    "between {low} and {high} {unit} by what elements, flange and gauges leave open",
    "between {low} and {high} by what elements, flange and gauges leave open",
)
_BETWEEN = {
    "gauge": (
        "between {low} and {high} {unit} by what was not recorded",
        "between {low} and {high} by what was not recorded",
    ),
    "mode": (
        "between {low} and {high} {unit} by the estimated error of the elements",
        "between {low} and {high} by the estimated error of the elements",
    ),
}


def place(c: Check | Unanswered, say: Language, *, several: bool = False) -> str:
    """Return where a check is: state, torque, mode, part and, with several lines, which line."""
    told = [occasion(c, say)]
    # The engine's torque, where that is asked, is not what the tyres leave of it.
    slips = QUANTITIES[c.quantity].sizes
    if isinstance(c, Check) and c.point and not (slips and c.point.direction == "drive"):
        told.append(f"{say.short(c.point.torque, 4)} N·m")
    if isinstance(c, Check) and c.mode:
        told.append(say(
            "order {order} meets {mode} at {frequency} Hz", order=c.mode.order,
            mode=say(c.mode.shape), frequency=say.short(c.mode.frequency / (2 * pi), 3),
        ))  # fmt: skip
    if isinstance(c, Check) and c.within:
        quantity = QUANTITIES[c.quantity]
        low, high = ("∞" if isinf(end) else say.short(end / quantity.factor, 4) for end in c.within)
        with_unit, alone = _BETWEEN.get(c.part.kind, _HELD)
        means = with_unit if quantity.unit_name else alone
        told.append(say(means, low=low, high=high, unit=quantity.unit_name))
        if c.may_be != c.grade:
            told.append(
                say({"warn": "by that it may warn", "fail": "by that it may fail"}[c.may_be])
            )
        if c.settled_by:
            told.append(say("`{key}` has one answer for the two", key="; ".join(c.settled_by)))
    where = say.list(*told) if c.part == LINE else say.list(*told, say.part(c.part))
    return f"{c.line}: {where}" if several else where


def occasion(c: Check | Unanswered, say: Language) -> str:
    """Return when a check was asked: the state, and where in it a worst point was found."""
    at = c.point if isinstance(c, Check) else None
    if at is None:
        return say.occasion(c.when)
    moving = {
        "drive": "gear {gear} at {speed} rpm" if at.gear else "drive at {speed} rpm",
        "coast": "coast in gear {gear} at {speed} rpm" if at.gear else "coast at {speed} rpm",
        "reverse": "reverse at {speed} rpm",
        "brake": "braking in gear {gear} at {speed} rpm" if at.gear else "braking at {speed} rpm",
    }
    still = {
        "drive": "pulling away in gear {gear}" if at.gear else "pulling away",
        "coast": "coasting to a stop in gear {gear}" if at.gear else "coasting to a stop",
        "reverse": "pulling away in reverse",
        "brake": "braking to a stop in gear {gear}" if at.gear else "braking to a stop",
    }
    means = (moving if at.speed else still)[at.direction]
    said = say(means, gear=at.gear, speed=say.short(round(at.speed / rpm), 6))
    return say.list(say.occasion(c.when), said)


def curve(of: "Curves | Swept", k: int, say: Language) -> str:
    """Return the name of a curve of torque over speed: reverse, gear 3, braking, gear 3."""
    way, gear = of.directions[k], of.gears[k]
    if way == "reverse":
        return say("reverse")
    geared = say("gear {gear}", gear=gear) if gear else ""
    if way == "brake":
        return say.list(*filter(None, (say("braking"), geared)))
    return geared or say("drive")


def sense(c: Check, say: Language) -> str:
    """Return how a value stands to its limit."""
    return say("outside") if c.limit.band else {"<=": "≤", ">=": "≥"}[c.limit.sense]


def held(c: Check, say: Language) -> tuple[str, str]:
    """Return value and bound of a check, in as many figures as tell apart what is not equal."""
    factor = QUANTITIES[c.quantity].factor
    for figures in range(4, 10):
        value, bound = (say.number(v / factor, figures) for v in (c.value, c.bound))
        if value != bound:
            return value, bound
    return say.number(c.value / factor), say.number(c.bound / factor)


def sentence(c: Check, say: Language) -> str:
    """Return a check as a sentence: what, where, how much, against what."""
    q, name = QUANTITIES[c.quantity], say.name(c.quantity)
    value, bound = held(c, say)
    return say(
        "{what} in {state}: {value} against {limit} {unit}",
        what=name if c.part == LINE else f"{name}, {say.part(c.part)}",
        state=occasion(c, say),
        value=value,
        limit=bound,
        unit=q.unit_name,
    ).rstrip()


def move(m: Move, say: Language) -> str:
    """Return a move in a workshop's words."""
    movable, part, amount = MOVABLES[m.adjustable.what], m.adjustable.part, m.amount
    shown = amount / movable.worth
    said = say.short(shown if movable.signed else abs(shown), 4)
    sign = "+" if movable.signed and amount > 0 else ""
    return say(movable.forth if amount > 0 else movable.back, part=part, amount=sign + said)


def moves(a: Adjustable, say: Language) -> str:
    """Return what may be moved, in few words."""
    return say(MOVABLES[a.what].called, part=a.part)


def left(
    of: "Proposal",
    say: Language,
    *,
    grade: Callable[[Grade, str], str] = lambda _, word: word,
) -> list[str]:
    """Return what does not pass with a correction, and what is unanswered.

    Of what was as bad before the worst three, of what it spoils as many. `grade` puts a grade's
    word as a medium shows it.
    """
    several = len(of.approval.responses) > 1
    new = spoilt(of.installed.checks, of.checks)
    old = (c for c in of.checks if c.grade != "pass" and c not in new)

    def told(c: Check) -> dict[str, str]:
        check = f"{c.line}: {sentence(c, say)}" if several else sentence(c, say)
        return {"grade": grade(c.grade, say(c.grade)), "check": check}

    return [
        *(say("but then {grade}: {check}", **told(c)) for c in worst_of_each(new)[:3]),
        *(say("still {grade}: {check}", **told(c)) for c in worst_of_each(old)[:3]),
        *gaps(of.approval.coverage.missed, say, several=several),
    ]


def scattered(trucks: "Trucks | None", say: Language) -> str:
    """Return how the trucks are taken to scatter about a setting; "" where nothing does."""
    if trucks is None:
        return ""
    every = _every(trucks)
    parts: dict[tuple[str, str], list[str]] = {}
    for name, spread in trucks.tolerances:
        wide = say.short(round(spread.values[0] * (3 if spread.kind == "normal" else 1), 4))
        a = every.get(name)
        unit = MOVABLES[a.what].unit.replace("percent", "%") if a else ""
        parts.setdefault((a.what if a else name, f"± {wide} {unit}".rstrip()), []).append(
            str(a.part) if a else ""
        )
    what = say.list(*(
        f"{say(MOVABLES[of].called, part=' + '.join(each)) if of in MOVABLES else of} {wide}"
        for (of, wide), each in parts.items()
    ))  # fmt: skip
    if trucks.assumed:
        return say("Trucks are assumed to scatter by {what} (3 σ).", what=what)
    return say("Trucks scatter by {what} (normal ones 3 σ), as the file says.", what=what)


def standing(of: "Approval", say: Language) -> str:
    """Say what an application comes to, as a check of it begins: the verdict and its margin."""
    if of.smallest_margin is None:
        return say(of.verdict).upper()
    return say(
        "{verdict}, smallest margin {margin}", verdict=say(of.verdict).upper(),
        margin=say.percent(of.smallest_margin),
    )  # fmt: skip


def won(p: "Proposal", say: Language) -> str:
    """Say what a correction wins among the limits that moving changes."""
    before, after = say.percent(p.before), say.percent(p.margin)
    return say("nearest to its warning of what moving changes: {before}, then {after}",
               before=before, after=after)  # fmt: skip


def _every(trucks: "Trucks") -> dict[str, Adjustable]:
    """Return what a workshop moves of trucks, by the names that a study knows."""
    return names_of(i.line for i in trucks.application.lines)


def survives(found: "Survival | None", trucks: "Trucks | None", say: Language) -> list[str]:
    """Return how many trucks keep what a proposal promises, and what would win most."""
    if found is None or trucks is None:
        return []
    share, quiet = (say.pointed(f"{100 * k:.0f} %") for k in (found.share, found.quiet))
    said = [
        say("{share} of trucks fail in nothing more; {quiet} do not warn more either",
            share=share, quiet=quiet)
    ]  # fmt: skip
    if found.lost:
        said.append(say("most others fail in: {limit}", limit=say.name(found.lost)))
    if found.tighter:
        name, more = found.tighter
        a = _every(trucks).get(name)  # or a number of the file, by its address
        said.append(
            say("tighten first: {name}; half as wide, {share} fail in nothing more",
                name=moves(a, say) if a else name,
                share=say.pointed(f"{100 * more:.0f} %"))
        )  # fmt: skip
    return said


def movable(a: Adjustable, say: Language) -> str:
    """Return a thing that may be moved and how far, in a workshop's words."""
    low = move(Move(adjustable=a, amount=a.low), say)
    return say("{low} to {high}", low=low, high=move(Move(adjustable=a, amount=a.high), say))


def problem(one: Sensitivity, say: Language, *, several: bool = False) -> str:
    """Return what does not pass, of which line where there are several, in how many states."""
    said = sentence(one.check, say)
    said = f"{one.check.line}: {said}" if several else said
    if len(one.states) < 2:
        return said
    return said + " (" + say.count("{count} state", "{count} states", len(one.states)) + ")"


def moves_that_help(one: Sensitivity, say: Language) -> list[str]:
    """Return the three moves that win most, each with the value it gives."""
    return [_effect(one, e, say) for e in one.helpful[:3]]


def nothing_better(say: Language) -> str:
    """Say that no correction was found."""
    return say(
        "Nothing that may be moved, within `adjust` of the application file and in the steps of "
        "a workshop, leaves the line better than it stands."
    )


def out_of_reach(of: Iterable[Sensitivity]) -> list[Check]:
    """Return the checks that no move helps."""
    return [one.check for one in of if not one.helpful]


def _effect(one: Sensitivity, e: Effect, say: Language) -> str:
    """Return what one move does, the better way of the two, and what it spoils."""
    q = QUANTITIES[one.check.quantity]
    moved, value = one.better(e)
    said = say("{move} gives {value}", move=move(moved, say), value=say.number(value / q.factor))
    return ", ".join(filter(None, (said, spoils(e, say))))


def spoils(e: Effect, say: Language) -> str:
    """Return the worst of what a move spoils; "" where that is nothing."""
    if (c := e.spoilt) is None:
        return ""
    told = sentence(c, say) if c.line == e.adjustable.line else f"{c.line}: {sentence(c, say)}"
    return say("but then {grade}: {check}", grade=say(c.grade), check=told)


def unanswered(of: Approval, say: Language, *, required: bool = False) -> list[str]:
    """Return what limits got no answer, with what each needs; the `required` first, or alone.

    Studies that nobody asked are told by `notes`.
    """
    missed = [u for f in of.findings if f.asked for u in f.unanswered]
    missed = [u for u in missed if u.limit.required] if required else missed
    return gaps(missed, say, several=len(of.responses) > 1)


def gaps(missed: Iterable[Unanswered], say: Language, *, several: bool = False) -> list[str]:
    """Return limits that got no answer, with what each needs; the required ones first."""
    found: dict[tuple[bool, str, tuple[str, ...]], list[Unanswered]] = {}
    for u in sorted(missed, key=lambda u: not u.limit.required):
        found.setdefault((u.limit.required, u.quantity, u.needs), []).append(u)
    return [
        _unanswered(same, say, required=required, several=several)
        for (required, _, _), same in found.items()
    ]


def _unanswered(same: list[Unanswered], say: Language, *, required: bool, several: bool) -> str:
    """Return limits of one quantity that miss the same, where they are a few with their places."""
    first = same[0]
    needs = "; ".join(say.given(n) for n in first.needs) or say("a number nobody could compute")
    parts = dict.fromkeys(
        say.list(u.line if several else "", "" if u.part == LINE else say.part(u.part))
        for u in same
    )
    name = say.list(say.name(first.quantity), *(parts if len(parts) <= 3 else ()))
    if required:
        return say("{name}: required, and needs {needs}", name=name, needs=needs)
    return say("{name}: needs {needs}", name=name, needs=needs)


def notes(of: Approval, say: Language) -> list[str]:
    """Return what a reader should know: studies not asked, what contradicts itself."""
    found: list[str] = []
    if of.not_asked:
        names = ", ".join(say(name) for name in of.not_asked)
        options = " ".join(f"--with {name}" for name in of.not_asked)
        found.append(say("Not part of this verdict: {names} ({options}).", names=names,
                         options=options))  # fmt: skip
    for f in of.findings:
        if f.asked:
            found += [
                say("{study} could not be asked: {why}.", study=say(f.study), why=why.rstrip("."))
                for why in f.doubts
            ]
    found += [say("Note: {note}.", note=say.said(one)) for one in of.noted]
    return found


def located(of: Problem, file: str, say: Language) -> str:
    """Return what is wrong in a file as one line, in the language."""
    told = replace(of, message=say.error(of.message), hint=say.error(of.hint))
    if of.value:
        told = replace(told, message=f"{told.message} ({say.error(f'got {of.value}')})", value="")
    return told.located(file)


def refused(error: Exception, say: Language) -> str:
    """Return why something was refused, in the language; a bad file problem by problem."""
    if isinstance(error, BadFile):
        return "\n".join(located(p, error.file, say) for p in error.problems)
    if isinstance(error, RefusedInFile):
        return f"{error.file}: {error.worded(refused(error.why, say))}"
    return say.error(str(error))


def cited(source: Source, say: Language) -> str:
    """Return a source and how it was read, in the language where it is no publication."""
    said = say.source(f"{source.title}, {source.place}" if source.place else source.title)
    read = how_read(source, say)
    return f"{said} ({read})" if read else said


def how_read(source: Source, say: Language) -> str:
    """Return how the values of a source were read, those that differ behind; empty if nobody said.

    Values are called what files call them.
    """
    if not source.how_read:
        return ""
    words = dict.fromkeys(word for _, word in source.apart)
    differ = (
        f"{', '.join(name for name, w in source.apart if w == word)}: {say(word)}" for word in words
    )
    return "; ".join((say(source.how_read), *differ))
