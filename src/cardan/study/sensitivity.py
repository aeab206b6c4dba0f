"""What each thing that can be moved does to each check that does not pass."""

from collections.abc import Iterable, Iterator
from dataclasses import replace

import numpy as np

from cardan.base.arrays import FloatArray
from cardan.base.frozen import dataclass
from cardan.base.verdict import Check
from cardan.model.application import Adjustable
from cardan.model.movable import MOVABLES
from cardan.quantity.quantities import ANSWERED
from cardan.quantity.response import Response
from cardan.study.approval import Approval
from cardan.study.driveline import asked, check
from cardan.study.moves import adjustables, fitted, in_states, tried

ON_RUBBER = {key for key, quantity in ANSWERED.items() if quantity.on_rubber}
"""What other mounts answer."""

WORTHWHILE = 0.05
"""Share of the gap to a limit that a move closes at least, or it is no help."""


@dataclass(frozen=True, kw_only=True)
class Effect:
    """What moving one thing back or forth does to the value of a check. SI.

    `low` and `high` are how far it is moved: by a step, or to the ends of its range where no
    step of anything helps.
    """

    adjustable: Adjustable
    low: float
    high: float
    back: float
    forth: float

    @property
    def ways(self) -> tuple[tuple[float, float], tuple[float, float]]:
        """Both amounts, each with the value it gives."""
        return (self.low, self.back), (self.high, self.forth)


@dataclass(frozen=True, kw_only=True)
class Sensitivity:
    """A check that does not pass, and what could be moved about it, most helpful first.

    `effects` are those in its own state, the worst of `states` in which it does not pass.
    """

    check: Check
    states: tuple[str, ...]
    effects: tuple[Effect, ...]

    def gain(self, effect: Effect) -> float:
        """Return the margin that the better way of moving wins, negative if both lose."""
        now, limit = self.check, self.check.limit
        to = "maximum" if now.grade == "fail" else "normal"
        return max(float(limit.margin(v, to=to)) for v in (effect.back, effect.forth)) - now.margin

    @property
    def helpful(self) -> tuple[Effect, ...]:
        """Those that close a part of the gap that is `WORTHWHILE`."""
        gap = max(-self.check.margin, 0.0)
        return tuple(e for e in self.effects if self.gain(e) > WORTHWHILE * gap)


def sensitivities(approval: Approval) -> tuple[Sensitivity, ...]:
    """Return for every limit and part that does not pass what moving things would do.

    Worst margin first. What nothing can move shows no effects.
    """
    found = [s for r in approval.responses for s in _of_line(r, approval.checks)]
    return tuple(sorted(found, key=lambda s: (s.check.grade != "fail", s.check.margin)))


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
    steps = np.array([_step(a) for a in movable])
    ends = np.array([(a.low, a.high) for a in movable]).reshape(-1, 2).T
    found = _asked(response, missed, movable, -steps, steps)
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


def _step(a: Adjustable) -> float:
    """Return how far something is moved to see what that does: other mounts as far as they go."""
    movable = MOVABLES[a.what]
    return min(movable.step, -a.low, a.high) if movable.fitted else movable.step


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
                worst = min(bad, key=lambda s, bad=bad: (bad[s].grade != "fail", bad[s].margin))
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
