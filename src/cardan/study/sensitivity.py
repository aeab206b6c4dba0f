"""What each thing that can be moved does to each check that does not pass."""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace

import numpy as np

from cardan.base.arrays import FloatArray, IntArray
from cardan.base.frozen import dataclass
from cardan.base.verdict import Check, badness
from cardan.model.application import Adjustable
from cardan.model.movable import MOVABLES
from cardan.quantity.quantities import ANSWERED
from cardan.quantity.response import Response
from cardan.study.approval import Approval
from cardan.study.driveline import Asked, asked, check
from cardan.study.moves import Move, adjustables, fitted, in_states, tried, turned

ON_RUBBER = {key for key, quantity in ANSWERED.items() if quantity.on_rubber}
"""What other mounts answer."""

WORTHWHILE = 0.05
"""Share of the gap to a limit that a move closes at least, or it is no help."""


@dataclass(frozen=True, kw_only=True)
class Effect:
    """What moving one thing back or forth does to the value of a check. SI.

    `low` and `high` are how far it is moved: by a step, or to the ends of its range where no
    step of anything helps; by half of that where the whole spoils something and the half does
    not. `back` and `forth` are values in the check's own state, and of a way that helps there the
    worst of all states. `spoilt` is the worst of what the way that helps makes warn or fail that
    did not before.
    """

    adjustable: Adjustable
    low: float
    high: float
    back: float
    forth: float
    spoilt: Check | None = None

    @property
    def ways(self) -> tuple[tuple[float, float], tuple[float, float]]:
        """Both amounts, each with the value it gives."""
        return (self.low, self.back), (self.high, self.forth)


@dataclass(frozen=True, kw_only=True)
class Sensitivity:
    """A check that does not pass, and what could be moved about it, most helpful first.

    What helps without harm elsewhere comes before what helps with it.
    `check` is that of the worst of `states`, in which it does not pass.
    """

    check: Check
    states: tuple[str, ...]
    effects: tuple[Effect, ...]

    def won(self, value: float) -> float:
        """Return the margin that a value wins, negative if it loses some."""
        to = "maximum" if self.check.grade == "fail" else "normal"
        return float(self.check.limit.margin(value, to=to)) - self.check.margin

    def helps(self, value: float) -> bool:
        """Return whether a value closes a part of the gap that is `WORTHWHILE`."""
        return self.won(value) > WORTHWHILE * max(-self.check.margin, 0.0)

    def gain(self, effect: Effect) -> float:
        """Return the margin that the better way of moving wins, negative if both lose."""
        return max(self.won(effect.back), self.won(effect.forth))

    def better(self, effect: Effect) -> tuple[Move, float]:
        """Return the way of moving that leaves more margin, and the value it gives."""
        limit = self.check.limit
        amount, value = max(effect.ways, key=lambda w: float(limit.margin(w[1], to="normal")))
        return Move(adjustable=effect.adjustable, amount=amount), value

    @property
    def helpful(self) -> tuple[Effect, ...]:
        """Those that close a part of the gap that is `WORTHWHILE`."""
        return tuple(e for e in self.effects if self.helps(e.back) or self.helps(e.forth))


def sensitivities(approval: Approval, *, line: str | None = None) -> tuple[Sensitivity, ...]:
    """Return for every limit and part that does not pass what moving things would do.

    Of every line, or of one. Worst margin first. What nothing can move shows no effects.
    """
    of = [r for r in approval.responses if line in (None, r.line.name)]
    found = [s for r in of for s in _weighed(r, list(_of_line(r, approval.checks)))]
    return tuple(sorted(found, key=lambda s: badness(s.check)))


@dataclass(frozen=True, kw_only=True)
class _Missed:
    """A limit's part that does not pass: its check in the worst state, and all such states.

    `question` is which of those about its quantity.
    """

    question: int
    part: int
    check: Check
    state: int
    states: tuple[str, ...]


def _of_line(response: Response, every: Iterable[Check]) -> Iterator[Sensitivity]:
    """Yield the sensitivities of one line.

    What is sought on rubber is dear, so it is asked by itself, in fewer states.
    """
    name = response.line.name
    bad = {c.quantity for c in every if c.line == name and c.grade != "pass"}
    movable = adjustables(response)
    yield from _moved(response, bad - ON_RUBBER, movable)
    yield from _moved(response, bad & ON_RUBBER, movable + fitted(response))


def _moved(
    response: Response, quantities: set[str], movable: tuple[Adjustable, ...]
) -> Iterator[Sensitivity]:
    """Yield those of some quantities, from one batch of things moved back and forth.

    What no step helps is asked again at the ends of the ranges: a speed between two modes has
    to pass one of them, and a step may be too short for that.
    """
    missed = list(_missed(response, quantities))
    ends = np.array([_range(response, a) for a in movable]).reshape(-1, 2).T
    of = [MOVABLES[a.what] for a in movable]
    steps = np.array([np.inf if m.choice else m.step for m in of])  # a choice has no between
    found = _asked(response, missed, movable, *np.clip(ends, -steps, steps))
    rest = [k for k, one in enumerate(found) if not one.helpful]
    farther = _asked(response, [missed[k] for k in rest], movable, *ends)
    better = {k: one for k, one in zip(rest, farther, strict=True) if one.helpful}
    yield from (better.get(k, one) for k, one in enumerate(found))


def _asked(
    response: Response,
    missed: list[_Missed],
    movable: tuple[Adjustable, ...],
    low: FloatArray,
    high: FloatArray,
) -> list[Sensitivity]:
    """Return what moving each thing by amounts (movable,) back and forth does to what is missed."""
    if not (missed and movable):
        return [Sensitivity(check=m.check, states=m.states, effects=()) for m in missed]
    within = _deciding(response, {m.state for m in missed})
    line = tried(
        in_states(response, within), movable, np.concatenate([np.diag(low), np.diag(high)])
    )
    questions = {
        key: list(asked(line, quantities={key})) for key in {m.check.quantity for m in missed}
    }
    found: list[Sensitivity] = []
    for m in missed:
        question = questions[m.check.quantity][m.question]
        values = question.values[..., within.index(m.state), m.part]
        back, forth = np.broadcast_to(values, (2 * len(movable),)).reshape(2, -1).tolist()
        effects = tuple(
            Effect(adjustable=a, low=down, high=up, back=lower, forth=upper)
            for a, down, up, lower, upper in zip(
                movable, low.tolist(), high.tolist(), back, forth, strict=True
            )
        )
        one = Sensitivity(check=m.check, states=m.states, effects=effects)
        moving = (e for e in one.effects if abs(e.back - e.forth) > 0 or one.gain(e) > 0)
        found.append(replace(one, effects=tuple(sorted(moving, key=one.gain, reverse=True))))
    return found


def _weighed(response: Response, found: list[Sensitivity]) -> Iterator[Sensitivity]:
    """Yield the sensitivities of a line with what each move that helps comes to in all states.

    And what it would spoil.
    """
    ways = [
        Move(adjustable=e.adjustable, amount=amount)
        for s in found for e in s.effects for amount, value in e.ways if s.helps(value)
    ]  # fmt: skip
    ways = [*dict.fromkeys(ways)]
    made = _made(response, ways) if ways else response
    found = [_everywhere(s, ways, made) for s in found]
    spoilt = _spoilt(response, ways, made) if ways else {}
    helps = dict.fromkeys(s.better(e)[0] for s in found for e in s.helpful)
    halves = {move: half for move in spoilt if move in helps and (half := _half(move))}
    if halves:
        found = _halved(response, found, halves)
    for s in found:
        helpful = [replace(e, spoilt=spoilt.get(s.better(e)[0])) for e in s.helpful]
        helpful.sort(key=lambda e: badness(e.spoilt)[0] if e.spoilt else 0, reverse=True)
        others = [e for e in s.effects if e not in s.helpful]
        yield replace(s, effects=(*helpful, *others))


def _everywhere(s: Sensitivity, ways: Sequence[Move], made: Response) -> Sensitivity:
    """Return a sensitivity with what helps in its own state as it is in the worst of all."""
    if not s.helpful:
        return s
    value = dict(zip(ways, _values(made, s.check, len(ways)), strict=True))

    def told(e: Effect, amount: float, own: float) -> float:
        move = Move(adjustable=e.adjustable, amount=amount)
        return value[move] if s.helps(own) else own

    effects = [
        replace(e, back=told(e, e.low, e.back), forth=told(e, e.high, e.forth)) for e in s.effects
    ]
    return replace(s, effects=tuple(sorted(effects, key=s.gain, reverse=True)))


def _half(move: Move) -> Move | None:
    """Return half a move, in the steps of a workshop; None where there is no such."""
    a = move.adjustable
    if MOVABLES[a.what].choice:
        return None
    half = move.amount / 2
    half = np.trunc(half / a.step + np.copysign(1e-9, half)) * a.step if a.step else half
    return Move(adjustable=a, amount=float(half)) if half else None


def _halved(
    response: Response, found: list[Sensitivity], halves: dict[Move, Move]
) -> list[Sensitivity]:
    """Return the sensitivities with half a move in place of a whole one that spoils something.

    Where the half helps as well, and spoils nothing.
    """
    amounts = [*halves.values()]
    made = _made(response, amounts)
    harm = _spoilt(response, amounts, made)
    place = {move: k for k, (move, half) in enumerate(halves.items()) if half not in harm}
    after: list[Sensitivity] = []
    for s in found:
        effects = list(s.effects)
        whole = {k: m for k, e in enumerate(effects) if (m := s.better(e)[0]) in place}
        values = _values(made, s.check, len(amounts)) if whole else []
        for k, m in whole.items():
            e, half, value = effects[k], halves[m], values[place[m]]
            less = replace(
                e, **({"low": half.amount, "back": value} if half.amount < 0
                      else {"high": half.amount, "forth": value})
            )  # fmt: skip
            if s.better(less)[0] == half and less in replace(s, effects=(less,)).helpful:
                effects[k] = less
        after.append(replace(s, effects=tuple(sorted(effects, key=s.gain, reverse=True))))
    return after


def _values(made: Response, of: Check, count: int) -> list[float]:
    """Return what each of so many moves makes of the value of a check, in the worst state."""
    then = next(
        q
        for q in asked(made, quantities={of.quantity})
        if q.limit == of.limit and of.part in q.parts
    )
    values = then.values[..., then.parts.index(of.part)]
    values = np.broadcast_to(values, (count, values.shape[-1]))
    margin = of.limit.margin(values, to="maximum" if of.grade == "fail" else "normal")
    worst = np.where(np.isnan(values), np.inf, margin).argmin(-1)
    return values[np.arange(count), worst].tolist()


def _made(response: Response, moves: Sequence[Move]) -> Response:
    """Return a line with each of some moves made by itself."""
    movable = tuple(dict.fromkeys(m.adjustable for m in moves))
    amounts = np.array([[m.amount * (m.adjustable == a) for a in movable] for m in moves])
    return tried(response, movable, amounts)


def _spoilt(response: Response, moves: Sequence[Move], made: Response) -> dict[Move, Check]:
    """Return the worst check of each move that spoils what a line keeps as it stands.

    Or what one keeps that leaves its axle, which a shim turns. A limit of a part is spoilt that
    warns or fails in some state, and was not as bad in any.
    """
    found: dict[Move, Check] = {}
    shims = [m for m in moves if m.adjustable.what == "shim"]
    _, *behind = turned(response, [m.adjustable for m in shims])
    others = [(r, _made(r, shims), shims) for r in behind]
    for line, after, of in [(response, made, moves), *others]:
        for now, then in zip(asked(line), asked(after), strict=True):
            values = np.broadcast_to(then.values, (len(of), *now.values.shape))
            worse = _worst_grades(then, values) > _worst_grades(now, now.values)
            for k, p in np.argwhere(worse).tolist():
                one, move = replace(then, values=values[k], spots=None), of[k]
                checks = (check(line, one, s, p) for s in range(values.shape[1]))
                found[move] = min((c for c in (found.get(move), *checks) if c), key=badness)
    return found


def _worst_grades(question: Asked, values: FloatArray) -> IntArray:
    """Return the worst grade of each part over the states, (..., parts)."""
    return np.where(np.isnan(values), 0, question.limit.grades(values)).max(axis=-2)


def _range(response: Response, a: Adjustable) -> tuple[float, float]:
    """Return how far something may be moved; where yokes may stand counts from the aligned."""
    stands = response.line.phases[a.part - 1] if MOVABLES[a.what].choice else 0.0
    return a.low - stands, a.high - stands


def _missed(response: Response, quantities: set[str]) -> Iterator[_Missed]:
    """Yield what of a line does not pass, limit by limit and part by part."""
    names = response.demand.states
    questions = [
        (k, question)
        for key in ANSWERED
        if key in quantities
        for k, question in enumerate(asked(response, quantities={key}))
    ]
    for k, question in questions:
        for p in range(len(question.parts)):
            checks = {s: check(response, question, s, p) for s in range(len(names))}
            bad = {s: c for s, c in checks.items() if c and c.grade != "pass"}
            if bad:
                worst = min(bad, key=lambda s, bad=bad: badness(bad[s]))
                yield _Missed(
                    question=k,
                    part=p,
                    check=bad[worst],
                    state=worst,
                    states=tuple(names[s] for s in bad),
                )


def _deciding(response: Response, asked_in: set[int]) -> list[int]:
    """Return the states to ask: these, and those that others are measured by.

    Shafts are balanced for the top speed of all states, a duty cycle scales with the largest
    torque and speed of the lasting ones.
    """
    found = set(asked_in)
    speed, torque = np.nan_to_num(response.demand.speed), np.abs(response.demand.torque)
    lasting = np.where(response.lasting, 1.0, 0.0)
    for size in (speed, speed * lasting, np.nan_to_num(torque) * lasting):
        if size[list(found)].max() < size.max():
            found.add(int(size.argmax()))
    return sorted(found)
