"""How checks, moves and effects are put into words, the same in every medium."""

from collections.abc import Iterable

from cardan.base.source import Source
from cardan.base.units import deg, mm
from cardan.base.verdict import GRADES, Check, Limit
from cardan.model.application import Adjustable
from cardan.quantity.quantities import QUANTITIES
from cardan.report.language import Language
from cardan.study.assess import Assessment
from cardan.study.fix import Move
from cardan.study.sensitivity import Effect, Sensitivity


def counts(checks: Iterable[Check], say: Language) -> str:
    """Return how many checks have each grade, the worst first."""
    grades = [c.grade for c in checks]
    return ", ".join(f"{grades.count(g)} {say(g)}" for g in reversed(GRADES))


def worst_of_each(checks: Iterable[Check]) -> list[Check]:
    """Return the worst check of each limit, those that do not pass first."""
    worst: dict[tuple[str, str, Limit], Check] = {}
    for c in sorted(checks, key=badness):
        worst.setdefault((c.quantity, c.line, c.limit), c)
    return sorted(worst.values(), key=badness)


def badness(c: Check) -> tuple[int, float]:
    """Return what checks are sorted by: failures first, then by margin."""
    return -GRADES.index(c.grade), c.margin


def place(c: Check, say: Language, *, several: bool = False) -> str:
    """Return where a check is: state, part and, with several lines, which line."""
    state = say.given(c.state)
    where = state if c.part == "line" else f"{state}, {say.part(c.part)}"
    return f"{c.line}: {where}" if several else where


def sense(c: Check, say: Language) -> str:
    """Return how a value stands to its limit."""
    return say("outside") if c.limit.band else {"<=": "≤", ">=": "≥"}[c.limit.sense]


def sentence(c: Check, say: Language) -> str:
    """Return a check as a sentence: what, where, how much, against what."""
    q = QUANTITIES[c.quantity]
    what = q.named(say.code) if c.part == "line" else f"{q.named(say.code)}, {say.part(c.part)}"
    return say(
        "{what} in {state}: {value} against {limit} {unit}",
        what=what,
        state=say.given(c.state),
        value=say.number(c.value / q.factor),
        limit=say.number(c.bound / q.factor),
        unit=q.unit_name,
    ).rstrip()


def move(m: Move, say: Language) -> str:
    """Return a move in a workshop's words."""
    a, amount = m.adjustable, m.amount
    up = amount > 0
    match a.what:
        case "bearing_height":
            said = "bearing {part} up {amount} mm" if up else "bearing {part} down {amount} mm"
            return say(said, part=a.part, amount=say.short(abs(amount) / mm))
        case "bearing_side":
            said = (
                "bearing {part} to the right {amount} mm"
                if up
                else "bearing {part} to the left {amount} mm"
            )
            return say(said, part=a.part, amount=say.short(abs(amount) / mm))
        case "shim":
            said = "pinion nose up {amount} deg" if up else "pinion nose down {amount} deg"
            return say(said, amount=say.short(abs(amount) / deg, 3))
        case "phase":
            said = "rear yoke of shaft {part} turned {amount} deg"
            return say(said, part=a.part, amount=("+" if up else "") + say.short(amount / deg, 4))


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
    return said + " (" + say("{count} states", count=len(one.states)) + ")"


def moves_that_help(one: Sensitivity, say: Language) -> list[str]:
    """Return the three moves that win most, each with the value it gives."""
    return [_effect(one, e, say) for e in one.effects if one.gain(e) > 0][:3]


def _effect(one: Sensitivity, e: Effect, say: Language) -> str:
    """Return what one move does, the better way of the two."""
    q = QUANTITIES[one.check.quantity]
    limit = one.check.limit
    value, step = max(
        (e.back, -e.step), (e.forth, e.step), key=lambda t: float(limit.margin(t[0], to="normal"))
    )
    moved = move(Move(adjustable=e.adjustable, amount=step), say)
    return say("{move} gives {value}", move=moved, value=say.number(value / q.factor))


def unasked(of: Assessment, say: Language) -> str:
    """Return what limits could not ask about; empty where they all could."""
    if not of.unasked():
        return ""
    names = ", ".join(say.name(q).lower() for q in of.unasked())
    return say("Not asked, for want of data: {names}.", names=names)


def notes(of: Assessment, say: Language) -> list[str]:
    """Return what a reader should know: what could not be asked, what contradicts itself."""
    found = [unasked(of, say)] if of.unasked() else []
    for m in of.mismatches:
        note = say(
            "a spring's stated rate of {stated} N/mm is {apart} from the {table} N/mm of its own "
            "table, which counts",
            stated=say.short(m.stated * mm, 4),
            apart=say.pointed(f"{100 * m.apart:+.1f} %"),
            table=say.short(m.of_table * mm, 4),
        )
        found.append(say("Note: {note}.", note=note))
    return found


def cited(source: Source, say: Language) -> str:
    """Return a source, in the language where it is no publication."""
    title = say.given(source.title)
    return f"{title}, {source.place}" if source.place else title
