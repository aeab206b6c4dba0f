"""What each thing that can be moved does to each check that does not pass."""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass

import numpy as np

from cardan.base.verdict import Check
from cardan.model.application import Adjustable
from cardan.model.movable import MOVABLES
from cardan.quantity.response import Response
from cardan.study.approval import Approval
from cardan.study.driveline import asked, check
from cardan.study.moves import adjustables, tried


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


def _of_line(response: Response, every: Iterable[Check]) -> Iterator[Sensitivity]:
    """Yield the sensitivities of one line, from one batch of things moved back and forth."""
    states = response.demand.states
    name = response.line.name
    bad = {c.quantity for c in every if c.line == name and c.grade != "pass"}
    if not bad:
        return
    movable = adjustables(response)
    steps = np.array([MOVABLES[a.what].step for a in movable])
    moved = tried(response, movable, np.concatenate([np.diag(-steps), np.diag(steps)]))
    pairs = zip(asked(response, quantities=bad), asked(moved, quantities=bad), strict=True)
    for now, then in pairs:
        values = np.broadcast_to(then.values, (2 * len(movable), *now.values.shape))
        back, forth = values[: len(movable)], values[len(movable) :]
        for p in range(len(now.parts)):
            checks = {s: c for s in range(len(states)) if (c := check(response, now, s, p))}
            missed = {s: c for s, c in checks.items() if c.grade != "pass"}
            if not missed:
                continue
            worst = min(
                missed, key=lambda s, missed=missed: (missed[s].grade != "fail", missed[s].margin)
            )
            one = Sensitivity(
                check=missed[worst],
                states=tuple(states[s] for s in missed),
                effects=tuple(
                    Effect(
                        adjustable=a,
                        step=float(step),
                        back=float(back[k, worst, p]),
                        forth=float(forth[k, worst, p]),
                    )
                    for k, (a, step) in enumerate(zip(movable, steps, strict=True))
                ),
            )
            helpful = (e for e in one.effects if abs(e.back - e.forth) > 0 or one.gain(e) > 0)
            yield Sensitivity(
                check=one.check,
                states=one.states,
                effects=tuple(sorted(helpful, key=one.gain, reverse=True)),
            )
