"""What each thing that can be moved does to each check that does not pass."""

from collections.abc import Container, Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import cached_property

import numpy as np

from cardan.approval.applied_adjustments import (
    AppliedAdjustment,
    allowed_adjustments,
    alternative_mount_adjustments,
    line_response_in_states,
    response_with_adjustments,
)
from cardan.approval.approval import Approval
from cardan.approval.driveline_study import EvaluatedLimit, check_limit_at_part, evaluate_limits
from cardan.checks.line_response import LineResponse
from cardan.checks.quantities.registry import LINE_QUANTITIES
from cardan.checks.rubber_at_stop import FORCE_KINDS
from cardan.core.arrays import FloatArray, IntArray
from cardan.core.lazy_dataclass import dataclass
from cardan.core.verdict import Check, worst_first_key
from cardan.model.adjustments import ADJUSTMENTS
from cardan.model.application import PermittedAdjustment

MOUNT_DEPENDENT_QUANTITIES = {
    key for key, quantity in LINE_QUANTITIES.items() if quantity.depends_on_mounts
}
"""What other mounts answer."""

_SEARCHED = {k for k in MOUNT_DEPENDENT_QUANTITIES if LINE_QUANTITIES[k].find_worst_points}

QUANTITIES_BY_COST = (
    LINE_QUANTITIES.keys() - MOUNT_DEPENDENT_QUANTITIES,
    MOUNT_DEPENDENT_QUANTITIES - _SEARCHED,
    _SEARCHED,
)
"""Cheapest first: without rubber, on rubber, and sought over operating points on rubber."""

MIN_CLOSED_SHORTFALL_SHARE = 0.05
"""Share of the gap to a limit that a move closes at least, or it is no help."""


@dataclass(frozen=True, kw_only=True)
class AdjustmentEffect:
    """What moving one thing back or forth does to the value of a check. SI.

    `low` and `high` are how far it is moved: by a step, or to the ends of its range where no
    step of anything helps; by half of that where the whole spoils something and the half does
    not. `back` and `forth` are values in the check's own state, and of a way that helps there the
    worst of all states. `side_effect` is the worst of what the way that helps makes warn or fail
    that did not before.
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
    found = [s for r in of for s in _of_line(_turned_by_shims(r, approval), approval.checks)]
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


@dataclass(frozen=True, kw_only=True)
class _MovedLine:
    """A line with each of some moves made by itself: moves on the first axis, then states.

    A quantity is computed where it is first read.
    """

    moves: tuple[AppliedAdjustment, ...]
    response: LineResponse
    crests: Mapping[str, FloatArray]
    """What a bearing's force (states, parts) at its stop is over that of linear rubber, by
    quantity: solved of the line as it stands, and taken to be that of each move."""

    @cached_property
    def _limits(self) -> dict[str, tuple[EvaluatedLimit, ...]]:
        """Limits that were read, by quantity."""
        return {}

    def limits(self, quantity: str) -> tuple[EvaluatedLimit, ...]:
        """Return the limits of a quantity with their values."""
        if quantity not in self._limits:
            self._limits[quantity] = tuple(
                self._at_stop(q) for q in evaluate_limits(self.response, quantities={quantity})
            )
        return self._limits[quantity]

    def _at_stop(self, of: EvaluatedLimit) -> EvaluatedLimit:
        """Return a limit's values, lower bounds among them as large as they are as it stands."""
        if of.limit.quantity not in self.crests:
            return of
        crest = np.where(of.validity_margin < 0, self.crests[of.limit.quantity], 1.0)
        return replace(of, values=of.values * crest)

    def values(self, of: EvaluatedLimit, part: int) -> FloatArray:
        """Return what each move makes of the value of a limit's part in every state, (moves, S)."""
        values = of.values[..., part]
        return np.broadcast_to(values, (len(self.moves), values.shape[-1]))

    def own_values(self, of: _FailedLimit, state: int) -> FloatArray:
        """Return what each move makes of the value of a failed limit in one state, (moves,)."""
        limit = self.limits(of.check.quantity)[of.question]
        return self.values(limit, of.part)[:, state]

    def worst_values(self, of: Check) -> dict[AppliedAdjustment, float]:
        """Return what each move makes of the value of a check, in the worst state."""
        alike = [
            (q, q.parts.index(of.part))
            for q in self.limits(of.quantity)
            if q.limit == of.limit and of.part in q.parts
        ]  # parts may have equal ratings: then the one that applies to this part
        applies = (pair for pair in alike if pair[0].may_apply[:, pair[1]].any())
        values = self.values(*next(applies, alike[0]))
        margin = of.limit.margin(values, to="maximum" if of.grade == "fail" else "normal")
        worst = np.where(np.isnan(values), np.inf, margin).argmin(-1)
        found = values[np.arange(len(values)), worst].tolist()
        return dict(zip(self.moves, found, strict=True))


def _turned_by_shims(response: LineResponse, approval: Approval) -> tuple[LineResponse, ...]:
    """Return a line as it stands, then those that leave its axle."""
    installed = response.demand.installed
    return response, *(
        r for r in approval.line_responses if r.demand.installed.starts_at_axle_of(installed)
    )


def _of_line(lines: Sequence[LineResponse], every: Iterable[Check]) -> Iterator[CheckSensitivity]:
    """Yield the sensitivities of the first of some lines; others turn with its shim.

    One batch, in all states, holds a step of each thing back and forth. What is sought on rubber
    is dear: other mounts are in it only where something on rubber does not pass, and then its
    side effects need no second batch.
    """
    response = lines[0]
    name = response.line.name
    bad = {c.quantity for c in every if c.line == name and c.grade != "pass"}
    on_mounts = bad & MOUNT_DEPENDENT_QUANTITIES
    allowed = allowed_adjustments(response)
    movable = allowed + (alternative_mount_adjustments(response) if on_mounts else ())
    missed = list(_missed(response, bad - on_mounts))
    missed_on_mounts = list(_missed(response, on_mounts))
    if not (missed or missed_on_mounts):
        return
    if not movable:
        yield from (_without_effects(m) for m in (*missed, *missed_on_mounts))
        return
    ends = np.array([_range(response, a) for a in movable]).T
    of = [ADJUSTMENTS[a.adjustment_key] for a in movable]
    steps = np.array(
        [np.inf if m.extremes_only else m.probe_step for m in of]
    )  # a choice has no between
    steps = np.clip(ends, -steps, steps)
    stepped = _made(response, _both_ways(movable, steps))
    found = [
        s
        for some, those in ((missed, allowed), (missed_on_mounts, movable))
        for s in _effects_of_steps(response, stepped, some, those, steps, ends)
    ]
    yield from _weighed(lines, found, stepped if missed_on_mounts else None)


def _both_ways(
    movable: tuple[PermittedAdjustment, ...], amounts: FloatArray
) -> list[AppliedAdjustment]:
    """Return things moved back by amounts (2, movable), then all of them forth."""
    return [
        AppliedAdjustment(adjustable=a, amount=amount)
        for way in amounts.tolist()
        for a, amount in zip(movable, way, strict=True)
    ]


def _effects_of_steps(
    response: LineResponse,
    stepped: _MovedLine,
    missed: list[_FailedLimit],
    movable: tuple[PermittedAdjustment, ...],
    steps: FloatArray,
    ends: FloatArray,
) -> Iterator[CheckSensitivity]:
    """Yield what a step of each thing does to what is missed, in its own state.

    `steps` and `ends` (2, things) begin with those of the things that are `movable`. What no step
    helps is evaluated again at the ends of the ranges, in fewer states: a speed between two modes
    has to pass one of them, and a step may be too short for that.
    """
    if not movable:
        yield from (_without_effects(m) for m in missed)
        return
    moves = _both_ways(movable, steps[:, : len(movable)])
    rows = [stepped.moves.index(m) for m in moves]
    found = [_effects_in_own_state(m, moves, stepped.own_values(m, m.state)[rows]) for m in missed]
    rest = [m for m, one in zip(missed, found, strict=True) if not one.helpful_effects]
    farther = iter(_effects_of_ends(response, rest, movable, ends))
    for one in found:
        end = one if one.helpful_effects else next(farther)
        yield end if end.helpful_effects else one


def _effects_of_ends(
    response: LineResponse,
    missed: list[_FailedLimit],
    movable: tuple[PermittedAdjustment, ...],
    ends: FloatArray,
) -> list[CheckSensitivity]:
    """Return what moving each thing to the ends of its range does to what is missed."""
    if not missed:
        return []
    within = _deciding(response, {m.state for m in missed})
    moves = _both_ways(movable, ends[:, : len(movable)])
    crests = {q: values[within] for q, values in force_crests(response).items()}
    made = _made(line_response_in_states(response, within), moves, crests=crests)
    rows = [made.moves.index(m) for m in moves]
    return [
        _effects_in_own_state(m, moves, made.own_values(m, within.index(m.state))[rows])
        for m in missed
    ]


def _effects_in_own_state(
    missed: _FailedLimit, moves: Sequence[AppliedAdjustment], values: FloatArray
) -> CheckSensitivity:
    """Return what moves, back and then forth, with their values do, most helpful first."""
    count = len(moves) // 2
    back, forth = values.reshape(2, -1).tolist()
    one = CheckSensitivity(
        check=missed.check,
        states=missed.states,
        effects=tuple(
            AdjustmentEffect(
                adjustable=down.adjustable, low=down.amount, high=up.amount, back=lower, forth=upper
            )
            for down, up, lower, upper in zip(
                moves[:count], moves[count:], back, forth, strict=True
            )
        ),
    )
    moving = (e for e in one.effects if abs(e.back - e.forth) > 0 or one.best_margin_gain(e) > 0)
    return replace(one, effects=tuple(sorted(moving, key=one.best_margin_gain, reverse=True)))


def _without_effects(missed: _FailedLimit) -> CheckSensitivity:
    return CheckSensitivity(check=missed.check, states=missed.states, effects=())


def _weighed(
    lines: Sequence[LineResponse], found: list[CheckSensitivity], stepped: _MovedLine | None
) -> Iterator[CheckSensitivity]:
    """Yield the sensitivities of a line with what each move that helps comes to in all states.

    And what it would spoil. Moves that are `stepped` are evaluated already.
    """
    ways = dict.fromkeys(
        AppliedAdjustment(adjustable=e.adjustable, amount=amount)
        for s in found
        for e in s.effects
        for amount, value in e.amounts_and_values
        if s.closes_gap(value)
    )
    known = {} if stepped is None else dict.fromkeys(stepped.moves)
    more = [m for m in ways if m not in known]
    made = [*([stepped] if stepped else []), *([_made(lines[0], more)] if more else [])]
    found = [_everywhere(s, made) for s in found]
    helps = dict.fromkeys(s.best_adjustment(e)[0] for s in found for e in s.helpful_effects)
    spoilt: dict[AppliedAdjustment, Check] = {}
    for some in made:
        spoilt |= _spoilt(lines, some, [m for m in some.moves if m in helps])
    halves = {move: half for move in spoilt if (half := _half(move))}
    if halves:
        found = _halved(lines, found, halves)
    for s in found:
        helpful = [
            replace(e, side_effect=spoilt.get(s.best_adjustment(e)[0])) for e in s.helpful_effects
        ]
        helpful.sort(
            key=lambda e: worst_first_key(e.side_effect)[0] if e.side_effect else 0, reverse=True
        )
        others = [e for e in s.effects if e not in s.helpful_effects]
        yield replace(s, effects=(*helpful, *others))


def _everywhere(s: CheckSensitivity, lines: Sequence[_MovedLine]) -> CheckSensitivity:
    """Return a sensitivity with what helps in its own state as it is in the worst of all."""
    if not s.helpful_effects:
        return s
    value = {m: v for line in lines for m, v in line.worst_values(s.check).items()}

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
    lines: Sequence[LineResponse],
    found: list[CheckSensitivity],
    halves: dict[AppliedAdjustment, AppliedAdjustment],
) -> list[CheckSensitivity]:
    """Return the sensitivities with half a move in place of a whole one that spoils something.

    Where the half helps as well, and spoils nothing: first nothing that costs little to know.
    """
    made = _made(lines[0], [*halves.values()])
    left = list(made.moves)
    for quantities in QUANTITIES_BY_COST:
        if len(left) <= len(made.moves) // 2:  # what is left out costs more than to begin anew
            made = _made(lines[0], left)
        harm = _spoilt(lines, made, left, quantities)
        left = [m for m in left if m not in harm]
        if not left:
            return found
    halves = {m: half for m, half in halves.items() if half in left}
    after: list[CheckSensitivity] = []
    for s in found:
        effects = list(s.effects)
        whole = {k: m for k, e in enumerate(effects) if (m := s.best_adjustment(e)[0]) in halves}
        values = made.worst_values(s.check) if whole else {}
        for k, m in whole.items():
            e, half, value = effects[k], halves[m], values[halves[m]]
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


def _made(
    response: LineResponse,
    moves: Iterable[AppliedAdjustment],
    *,
    crests: Mapping[str, FloatArray] | None = None,
) -> _MovedLine:
    """Return a line with each of some moves made by itself; with `crests` if not its own."""
    moves = tuple(dict.fromkeys(moves))
    movable = tuple(dict.fromkeys(m.adjustable for m in moves))
    amounts = np.array([[m.amount * (m.adjustable == a) for a in movable] for m in moves])
    return _MovedLine(
        moves=moves,
        response=response_with_adjustments(response, movable, amounts),
        crests=force_crests(response) if crests is None else crests,
    )


def force_crests(response: LineResponse) -> dict[str, FloatArray]:
    """Return what forces at stops, or with the spline stuck, are over the others, by quantity."""
    loads = response.mount_loads
    held = any(loads.is_stuck(kind).any() for kind in FORCE_KINDS)
    if not loads.is_solved_at_stop.any() and not held:
        return {}
    return {f"centre_bearing_{kind}": loads.crest_over_linear(kind) for kind in FORCE_KINDS}


def _spoilt(
    lines: Sequence[LineResponse],
    made: _MovedLine,
    moves: Sequence[AppliedAdjustment],
    quantities: Container[str] = LINE_QUANTITIES,
) -> dict[AppliedAdjustment, Check]:
    """Return the worst check of each of some moves that spoils what a line keeps as it stands.

    Or what one keeps that leaves its axle, which a shim turns: `lines` after the first. A limit
    of a part is spoilt that warns or fails in some state, and was not as bad in any.
    """
    found: dict[AppliedAdjustment, Check] = {}
    pairs = [(lines[0], made, moves)] if moves else []
    if shims := [m for m in moves if m.adjustable.adjustment_key == "shim"]:
        pairs += [(line, _made(line, shims), shims) for line in lines[1:]]
    for line, after, of in pairs:
        rows = [after.moves.index(m) for m in of]
        for key in (k for k in LINE_QUANTITIES if k in quantities):
            was = evaluate_limits(line, quantities={key})
            for now, then in zip(was, after.limits(key), strict=True):
                shape = (len(after.moves), *now.values.shape)
                values, holds = (
                    np.broadcast_to(v, shape)[rows] for v in (then.values, then.bound_margin)
                )
                then = replace(
                    then, values=values, validity_margin=holds, prove=None, worst_points=None
                )
                for k, p in np.argwhere(_worst_grades(then) > _worst_grades(now)).tolist():
                    one = replace(then, values=values[k], validity_margin=holds[k])
                    checks = (check_limit_at_part(line, one, s, p) for s in range(shape[1]))
                    told = (c for c in (found.get(of[k]), *checks) if c)
                    found[of[k]] = min(told, key=worst_first_key)
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
    """Return the states to evaluate: these, and those that others are measured by.

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
