"""What each thing that can be moved does to each check that does not pass."""

from collections.abc import Iterable, Iterator
from dataclasses import replace

import numpy as np

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


@dataclass(frozen=True, kw_only=True)
class Effect:
    """What moving one thing by a step, back or forth, does to the value of a check. SI."""

    adjustable: Adjustable
    step: float
    back: float
    forth: float


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


def sensitivities(approval: Approval) -> tuple[Sensitivity, ...]:
    """Return for every limit and part that does not pass what moving things would do.

    Worst margin first. What nothing can move shows no effects.
    """
    found = [s for r in approval.responses for s in _of_line(r, approval.checks)]
    return tuple(sorted(found, key=lambda s: (s.check.grade != "fail", s.check.margin)))


@dataclass(frozen=True, kw_only=True)
class _Missed:
    """A limit's part that does not pass: its check in the worst state, and all such states."""

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
    """Yield those of some quantities, from one batch of things moved back and forth."""
    missed = list(_missed(response, quantities))
    if not (missed and movable):
        yield from (Sensitivity(check=m.check, states=m.states, effects=()) for m in missed)
        return
    steps = np.array([_step(a) for a in movable])
    within = _deciding(response, {m.state for m in missed})
    amounts = np.concatenate([np.diag(-steps), np.diag(steps)])
    line = tried(in_states(response, within), movable, amounts)
    questions = list(asked(line, quantities=quantities))
    for m in missed:
        values = questions[m.question].values[..., within.index(m.state), m.part]
        back, forth = np.broadcast_to(values, (2 * len(movable),)).reshape(2, -1).tolist()
        one = Sensitivity(
            check=m.check,
            states=m.states,
            effects=tuple(
                Effect(adjustable=a, step=step, back=b, forth=f)
                for a, step, b, f in zip(movable, steps.tolist(), back, forth, strict=True)
            ),
        )
        helpful = (e for e in one.effects if abs(e.back - e.forth) > 0 or one.gain(e) > 0)
        yield replace(one, effects=tuple(sorted(helpful, key=one.gain, reverse=True)))


def _step(a: Adjustable) -> float:
    """Return how far something is moved to see what that does: other mounts as far as they go."""
    movable = MOVABLES[a.what]
    return min(movable.step, -a.low, a.high) if movable.fitted else movable.step


def _missed(response: Response, quantities: set[str]) -> Iterator[_Missed]:
    """Yield what of a line does not pass, limit by limit and part by part."""
    names = response.demand.states
    for k, question in enumerate(asked(response, quantities=quantities)):
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
