"""What each thing that can be moved does to each check that does not pass."""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace

import numpy as np

from cardan.approval.applied_adjustments import (
    AppliedAdjustment,
    affected_lines,
    allowed_adjustments,
    alternative_mount_adjustments,
    evaluate_adjustments,
    line_response_in_states,
)
from cardan.approval.approval import Approval
from cardan.approval.driveline_study import EvaluatedLimit, check_limit_at_part, evaluate_limits
from cardan.checks.line_response import LineResponse
from cardan.checks.quantities.registry import LINE_QUANTITIES
from cardan.core.arrays import FloatArray, IntArray
from cardan.core.lazy_dataclass import dataclass
from cardan.core.verdict import Check, worst_first_key
from cardan.model.adjustments import ADJUSTMENTS
from cardan.model.application import PermittedAdjustment

MOUNT_DEPENDENT_QUANTITIES = {
    key for key, quantity in LINE_QUANTITIES.items() if quantity.depends_on_mounts
}
"""What other mounts answer."""

MIN_CLOSED_SHORTFALL_SHARE = 0.05
"""Share of the gap to a limit that a move closes at least, or it is no help."""


@dataclass(frozen=True, kw_only=True)
class AdjustmentEffect:
    """What moving one thing back or forth does to the value of a check. SI.

    `low` and `high` are how far it is moved: by a step, or to the ends of its range where no
    step of anything helps; by half of that where the whole spoils something and the half does
    not. `back` and `forth` are values in the check's own state, and of a way that helps there the
    worst of all states. `spoilt` is the worst of what the way that helps makes warn or fail that
    did not before.
    """

    adjustable: PermittedAdjustment
    low: float
    high: float
    back: float
    forth: float
    side_effect: Check | None = None

    @property
    def amounts_and_values(self) -> tuple[tuple[float, float], tuple[float, float]]:
        """Both amounts, each with the value it gives."""
        return (self.low, self.back), (self.high, self.forth)


@dataclass(frozen=True, kw_only=True)
class CheckSensitivity:
    """A check that does not pass, and what could be moved about it, most helpful first.

    What helps without harm elsewhere comes before what helps with it.
    `check` is that of the worst of `states`, in which it does not pass.
    """

    check: Check
    states: tuple[str, ...]
    effects: tuple[AdjustmentEffect, ...]

    def margin_gain(self, value: float) -> float:
        """Return the margin that a value wins, negative if it loses some."""
        return self._margin(value) - self._margin(self.check.value)

    def _margin(self, value: float) -> float:
        to = "maximum" if self.check.grade == "fail" else "normal"
        return float(self.check.limit.margin(value, to=to))

    def closes_gap(self, value: float) -> bool:
        """Return whether a value closes a part of the gap that is `MIN_CLOSED_SHORTFALL_SHARE`."""
        gap = max(-self._margin(self.check.value), 0.0)
        return self.margin_gain(value) > MIN_CLOSED_SHORTFALL_SHARE * gap

    def best_margin_gain(self, effect: AdjustmentEffect) -> float:
        """Return the margin that the better way of moving wins, negative if both lose."""
        return max(self.margin_gain(effect.back), self.margin_gain(effect.forth))

    def best_adjustment(self, effect: AdjustmentEffect) -> tuple[AppliedAdjustment, float]:
        """Return the way of moving that leaves more margin, and the value it gives."""
        limit = self.check.limit
        amount, value = max(
            effect.amounts_and_values, key=lambda w: float(limit.margin(w[1], to="normal"))
        )
        return AppliedAdjustment(adjustable=effect.adjustable, amount=amount), value

    @property
    def helpful_effects(self) -> tuple[AdjustmentEffect, ...]:
        """Those that close a part of the gap that is `MIN_CLOSED_SHORTFALL_SHARE`."""
        return tuple(e for e in self.effects if self.closes_gap(e.back) or self.closes_gap(e.forth))


def check_sensitivities(
    approval: Approval, *, line: str | None = None
) -> tuple[CheckSensitivity, ...]:
    """Return for every limit and part that does not pass what moving things would do.

    Of every line, or of one. Worst margin first. What nothing can move shows no effects.
    """
    of = [r for r in approval.line_responses if line in (None, r.line.name)]
    found = [s for r in of for s in _weighed(r, list(_of_line(r, approval.checks)))]
    return tuple(sorted(found, key=lambda s: worst_first_key(s.check)))


@dataclass(frozen=True, kw_only=True)
class _FailedLimit:
    """A limit's part that does not pass: its check in the worst state, and all such states.

    `question` is which of those about its quantity.
    """

    question: int
    part: int
    check: Check
    state: int
    states: tuple[str, ...]


def _of_line(response: LineResponse, every: Iterable[Check]) -> Iterator[CheckSensitivity]:
    """Yield the sensitivities of one line.

    What is sought on rubber is dear, so it is asked by itself, in fewer states.
    """
    name = response.line.name
    bad = {c.quantity for c in every if c.line == name and c.grade != "pass"}
    movable = allowed_adjustments(response)
    yield from _moved(response, bad - MOUNT_DEPENDENT_QUANTITIES, movable)
    yield from _moved(
        response,
        bad & MOUNT_DEPENDENT_QUANTITIES,
        movable + alternative_mount_adjustments(response),
    )


def _moved(
    response: LineResponse, quantities: set[str], movable: tuple[PermittedAdjustment, ...]
) -> Iterator[CheckSensitivity]:
    """Yield those of some quantities, from one batch of things moved back and forth.

    What no step helps is asked again at the ends of the ranges: a speed between two modes has
    to pass one of them, and a step may be too short for that.
    """
    missed = list(_missed(response, quantities))
    ends = np.array([_range(response, a) for a in movable]).reshape(-1, 2).T
    of = [ADJUSTMENTS[a.adjustment_key] for a in movable]
    steps = np.array(
        [np.inf if m.extremes_only else m.probe_step for m in of]
    )  # a choice has no between
    found = _asked(response, missed, movable, *np.clip(ends, -steps, steps))
    rest = [k for k, one in enumerate(found) if not one.helpful_effects]
    farther = _asked(response, [missed[k] for k in rest], movable, *ends)
    better = {k: one for k, one in zip(rest, farther, strict=True) if one.helpful_effects}
    yield from (better.get(k, one) for k, one in enumerate(found))


def _asked(
    response: LineResponse,
    missed: list[_FailedLimit],
    movable: tuple[PermittedAdjustment, ...],
    low: FloatArray,
    high: FloatArray,
) -> list[CheckSensitivity]:
    """Return what moving each thing by amounts (movable,) back and forth does to what is missed."""
    if not (missed and movable):
        return [CheckSensitivity(check=m.check, states=m.states, effects=()) for m in missed]
    within = _deciding(response, {m.state for m in missed})
    line = evaluate_adjustments(
        line_response_in_states(response, within),
        movable,
        np.concatenate([np.diag(low), np.diag(high)]),
    )
    questions = {
        key: list(evaluate_limits(line, quantities={key}))
        for key in {m.check.quantity for m in missed}
    }
    found: list[CheckSensitivity] = []
    for m in missed:
        question = questions[m.check.quantity][m.question]
        values = question.values[..., within.index(m.state), m.part]
        back, forth = np.broadcast_to(values, (2 * len(movable),)).reshape(2, -1).tolist()
        effects = tuple(
            AdjustmentEffect(adjustable=a, low=down, high=up, back=lower, forth=upper)
            for a, down, up, lower, upper in zip(
                movable, low.tolist(), high.tolist(), back, forth, strict=True
            )
        )
        one = CheckSensitivity(check=m.check, states=m.states, effects=effects)
        moving = (
            e for e in one.effects if abs(e.back - e.forth) > 0 or one.best_margin_gain(e) > 0
        )
        found.append(
            replace(one, effects=tuple(sorted(moving, key=one.best_margin_gain, reverse=True)))
        )
    return found


def _weighed(response: LineResponse, found: list[CheckSensitivity]) -> Iterator[CheckSensitivity]:
    """Yield the sensitivities of a line with what each move that helps comes to in all states.

    And what it would spoil.
    """
    ways = [
        AppliedAdjustment(adjustable=e.adjustable, amount=amount)
        for s in found
        for e in s.effects
        for amount, value in e.amounts_and_values
        if s.closes_gap(value)
    ]
    ways = [*dict.fromkeys(ways)]
    made = _made(response, ways) if ways else response
    found = [_everywhere(s, ways, made) for s in found]
    spoilt = _spoilt(response, ways, made) if ways else {}
    helps = dict.fromkeys(s.best_adjustment(e)[0] for s in found for e in s.helpful_effects)
    halves = {move: half for move in spoilt if move in helps and (half := _half(move))}
    if halves:
        found = _halved(response, found, halves)
    for s in found:
        helpful = [
            replace(e, side_effect=spoilt.get(s.best_adjustment(e)[0])) for e in s.helpful_effects
        ]
        helpful.sort(
            key=lambda e: worst_first_key(e.side_effect)[0] if e.side_effect else 0, reverse=True
        )
        others = [e for e in s.effects if e not in s.helpful_effects]
        yield replace(s, effects=(*helpful, *others))


def _everywhere(
    s: CheckSensitivity, ways: Sequence[AppliedAdjustment], made: LineResponse
) -> CheckSensitivity:
    """Return a sensitivity with what helps in its own state as it is in the worst of all."""
    if not s.helpful_effects:
        return s
    value = dict(zip(ways, _values(made, s.check, len(ways)), strict=True))

    def told(e: AdjustmentEffect, amount: float, own: float) -> float:
        move = AppliedAdjustment(adjustable=e.adjustable, amount=amount)
        return value[move] if s.closes_gap(own) else own

    effects = [
        replace(e, back=told(e, e.low, e.back), forth=told(e, e.high, e.forth)) for e in s.effects
    ]
    return replace(s, effects=tuple(sorted(effects, key=s.best_margin_gain, reverse=True)))


def _half(move: AppliedAdjustment) -> AppliedAdjustment | None:
    """Return half a move, in the steps of a workshop; None where there is no such."""
    a = move.adjustable
    if ADJUSTMENTS[a.adjustment_key].extremes_only:
        return None
    half = move.amount / 2
    half = np.trunc(half / a.step + np.copysign(1e-9, half)) * a.step if a.step else half
    return AppliedAdjustment(adjustable=a, amount=float(half)) if half else None


def _halved(
    response: LineResponse,
    found: list[CheckSensitivity],
    halves: dict[AppliedAdjustment, AppliedAdjustment],
) -> list[CheckSensitivity]:
    """Return the sensitivities with half a move in place of a whole one that spoils something.

    Where the half helps as well, and spoils nothing.
    """
    amounts = [*halves.values()]
    made = _made(response, amounts)
    harm = _spoilt(response, amounts, made)
    place = {move: k for k, (move, half) in enumerate(halves.items()) if half not in harm}
    after: list[CheckSensitivity] = []
    for s in found:
        effects = list(s.effects)
        whole = {k: m for k, e in enumerate(effects) if (m := s.best_adjustment(e)[0]) in place}
        values = _values(made, s.check, len(amounts)) if whole else []
        for k, m in whole.items():
            e, half, value = effects[k], halves[m], values[place[m]]
            less = replace(
                e, **({"low": half.amount, "back": value} if half.amount < 0
                      else {"high": half.amount, "forth": value})
            )  # fmt: skip
            if (
                s.best_adjustment(less)[0] == half
                and less in replace(s, effects=(less,)).helpful_effects
            ):
                effects[k] = less
        after.append(
            replace(s, effects=tuple(sorted(effects, key=s.best_margin_gain, reverse=True)))
        )
    return after


def _values(made: LineResponse, of: Check, count: int) -> list[float]:
    """Return what each of so many moves makes of the value of a check, in the worst state."""
    then = next(
        q
        for q in evaluate_limits(made, quantities={of.quantity})
        if q.limit == of.limit and of.part in q.parts
    )
    values = then.values[..., then.parts.index(of.part)]
    values = np.broadcast_to(values, (count, values.shape[-1]))
    margin = of.limit.margin(values, to="maximum" if of.grade == "fail" else "normal")
    worst = np.where(np.isnan(values), np.inf, margin).argmin(-1)
    return values[np.arange(count), worst].tolist()


def _made(response: LineResponse, moves: Sequence[AppliedAdjustment]) -> LineResponse:
    """Return a line with each of some moves made by itself."""
    movable = tuple(dict.fromkeys(m.adjustable for m in moves))
    amounts = np.array([[m.amount * (m.adjustable == a) for a in movable] for m in moves])
    return evaluate_adjustments(response, movable, amounts)


def _spoilt(
    response: LineResponse, moves: Sequence[AppliedAdjustment], made: LineResponse
) -> dict[AppliedAdjustment, Check]:
    """Return the worst check of each move that spoils what a line keeps as it stands.

    Or what one keeps that leaves its axle, which a shim turns. A limit of a part is spoilt that
    warns or fails in some state, and was not as bad in any.
    """
    found: dict[AppliedAdjustment, Check] = {}
    shims = [m for m in moves if m.adjustable.adjustment_key == "shim"]
    _, *behind = affected_lines(response, [m.adjustable for m in shims])
    others = [(r, _made(r, shims), shims) for r in behind]
    for line, after, of in [(response, made, moves), *others]:
        for now, then in zip(evaluate_limits(line), evaluate_limits(after), strict=True):
            values, holds = (
                np.broadcast_to(v, (len(of), *now.values.shape))
                for v in (then.values, then.validity_margin)
            )
            then = replace(then, values=values, validity_margin=holds, worst_points=None)
            for k, p in np.argwhere(_worst_grades(then) > _worst_grades(now)).tolist():
                one, move = replace(then, values=values[k], validity_margin=holds[k]), of[k]
                checks = (check_limit_at_part(line, one, s, p) for s in range(values.shape[1]))
                found[move] = min((c for c in (found.get(move), *checks) if c), key=worst_first_key)
    return found


def _worst_grades(question: EvaluatedLimit) -> IntArray:
    """Return the worst grade of each part over the states, (..., parts)."""
    return np.where(np.isnan(question.values), 0, question.grades()).max(axis=-2)


def _range(response: LineResponse, a: PermittedAdjustment) -> tuple[float, float]:
    """Return how far something may be moved; where yokes may stand counts from the aligned."""
    stands = (
        response.line.phases[a.part - 1] if ADJUSTMENTS[a.adjustment_key].extremes_only else 0.0
    )
    return a.low - stands, a.high - stands


def _missed(response: LineResponse, quantities: set[str]) -> Iterator[_FailedLimit]:
    """Yield what of a line does not pass, limit by limit and part by part."""
    names = response.demand.states
    questions = [
        (k, question)
        for key in LINE_QUANTITIES
        if key in quantities
        for k, question in enumerate(evaluate_limits(response, quantities={key}))
    ]
    for k, question in questions:
        for p in range(len(question.parts)):
            checks = {s: check_limit_at_part(response, question, s, p) for s in range(len(names))}
            # What only a stop leaves open no value says: other rubber is an answer, no move.
            bad = {s: c for s, c in checks.items() if c and c.limit.grade(c.value) != "pass"}
            if bad:
                worst = min(bad, key=lambda s, bad=bad: worst_first_key(bad[s]))
                yield _FailedLimit(
                    question=k,
                    part=p,
                    check=bad[worst],
                    state=worst,
                    states=tuple(names[s] for s in bad),
                )


def _deciding(response: LineResponse, asked_in: set[int]) -> list[int]:
    """Return the states to ask: these, and those that others are measured by.

    Shafts are balanced for the top speed of all states, a duty cycle scales with the largest
    torque and speed of the lasting ones.
    """
    found = set(asked_in)
    speed, torque = np.nan_to_num(response.demand.speed), np.abs(response.demand.torque)
    lasting = np.where(response.inputs.sustained_states, 1.0, 0.0)
    for size in (speed, speed * lasting, np.nan_to_num(torque) * lasting):
        if size[list(found)].max() < size.max():
            found.add(int(size.argmax()))
    return sorted(found)
