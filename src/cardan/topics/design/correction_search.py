"""Where to move what: a search over the settings of a line, many of them evaluated at a time.

Each setting is evaluated once, in a batch, on a leading axis of the response that a check uses.
"""

from collections.abc import Callable, Iterator, Mapping
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import product
from math import prod
from typing import Any, TypeAlias

import numpy as np

from cardan.approval.applied_adjustments import response_with_adjustments
from cardan.approval.driveline_study import EvaluatedLimit, evaluate_limits
from cardan.approval.margins import LIMIT_BOUND_NAMES, LimitBoundName, margins_of_limits
from cardan.checks.line_response import LineResponse
from cardan.checks.rubber_at_stop import FORCE_KINDS
from cardan.core.arrays import BoolArray, FloatArray, IntArray
from cardan.core.verdict import CHECK_GRADES, Limit
from cardan.model.application import PermittedAdjustment
from cardan.topics.design.robustness import ToleranceModel
from cardan.topics.design.sensitivity import force_crests

MIN_MARGIN_AFTER_CORRECTION = 0.02
"""Margin the least correction keeps, so that rounding it does not undo it."""

GOLDEN_RATIO_STEPS = 40
"""Steps of a fixed point that each halve its error at least: to rounding."""

SPREAD_TRIALS_PER_ADJUSTMENT = 24
"""Trials spread over each way that is free before the search follows the best of them."""

MIN_MARGIN_CHANGE = 1e-9
"""A margin that changes by less than this in every trial is not for moving to answer."""

MIN_SHORTFALL_CHANGE_SHARE = 0.05
"""Nor is one below 0 in all of them that differs by less than this share of what it lacks."""

MAX_EXHAUSTIVE_SEARCH_SETTINGS = 256
"""Settings of a workshop that are all evaluated, where there are no more; else it is searched
as if there were no steps."""

MAX_ROUNDING_VARIANTS = 64
"""Ways to round a correction that are tried at most; of more things each goes to its nearest."""

MOVE_COST_SMOOTHING_RANGE_SHARE = 0.02
"""Share of a range below which the search takes a move to cost as its square."""

MIN_MARGIN_AFTER_CORRECTION_TOLERANCE = 1e-3
"""How far into the reserve the search may end: rounding to steps is held to the bounds anyway."""

ROBUST_MARGIN_STANDARD_DEVIATIONS = 2.5
"""Standard deviations of its scatter that a robust correction keeps each margin away from 0."""

LOCAL_SEARCH_RADIUS_RANGE_SHARES, LOCAL_SEARCH_TRIALS = (0.1, 0.03, 0.01), 8
"""Shares of the ranges about the best trial that are looked through by so many trials each way,
where slopes lead nowhere better."""

BACKTRACKING_FRACTIONS = np.linspace(0.0, 1.0, 17)[:, None]
"""Places that are tried on the way back from a correction to the least one."""

ROUNDED_TRIALS = 3
"""Spread trials with the fewest criteria exceeded that are rounded to what a workshop can set."""

MIN_SOLVER_GAIN, MAX_STALLED_STEPS = 1e-3, 4
"""Gain, as a share, and steps in a row with less of it, after which a search by slopes ends."""

SETTING_DECIMALS = 12
"""Decimals, of m or rad, to which two settings are one."""

FunctionWithGradient: TypeAlias = Callable[[FloatArray], tuple[Any, FloatArray]]

BoundMargins: TypeAlias = dict[LimitBoundName, FloatArray]
"""Margins (V, M) to either bound."""


@dataclass(frozen=True, kw_only=True)
class SettingResults:
    """What settings of a line come to: V settings, M of limits x states x parts.

    Attributes
    ----------
    margins : (V, M) to either bound
        Forces where rubber goes beyond its stop are lower bounds.
    expected_margin : (V, M)
        To a warning, forces at a stop or with the spline stuck taken as much larger as they are
        of the line as installed.
    exceeded, warned : (V,)
        Criteria, one limit of one line each, that so fail or warn.
    """

    margins: BoundMargins
    expected_margin: FloatArray
    exceeded: IntArray
    warned: IntArray

    def rows(self, at: Any) -> "SettingResults":
        """Return those of some settings."""
        return SettingResults(
            margins={bound: m[at] for bound, m in self.margins.items()},
            expected_margin=self.expected_margin[at],
            exceeded=self.exceeded[at],
            warned=self.warned[at],
        )


class SettingEvaluator:
    """Evaluates settings of what may be moved of lines, each once."""

    def __init__(
        self, lines: tuple[LineResponse, ...], movable: tuple[PermittedAdjustment, ...]
    ) -> None:
        self.lines, self.movable = lines, movable
        self._rows: dict[bytes, int] = {}
        self._known: list[SettingResults] = []
        self._places: list[tuple[int, int]] = []

    def evaluate(self, amounts: FloatArray) -> SettingResults:
        """Return what settings (V, movable) come to; those not known yet in one batch."""
        keys = [row.tobytes() for row in np.round(amounts, SETTING_DECIMALS) + 0.0]
        new = {key: k for k, key in enumerate(keys) if key not in self._rows}
        if new:
            found = self._computed(amounts[list(new.values())])
            for k, key in enumerate(new):
                self._rows[key] = len(self._places)
                self._places.append((len(self._known), k))
            self._known.append(found)
        places = [self._places[self._rows[key]] for key in keys]
        batches = [b for b, _ in places]
        if len(set(batches)) == 1:
            return self._known[batches[0]].rows([k for _, k in places])
        each = [self._known[b].rows([k]) for b, k in places]
        return SettingResults(
            margins={
                bound: np.concatenate([e.margins[bound] for e in each])
                for bound in LIMIT_BOUND_NAMES
            },
            expected_margin=np.concatenate([e.expected_margin for e in each]),
            exceeded=np.concatenate([e.exceeded for e in each]),
            warned=np.concatenate([e.warned for e in each]),
        )

    def _computed(self, amounts: FloatArray) -> SettingResults:
        """Return what settings (V, movable) come to."""
        tried = adjusted_lines(self.lines, self.movable, amounts)
        limits = [tuple(evaluate_limits(r)) for r in tried]
        margins: BoundMargins = {
            bound: np.concatenate(
                [margins_of_limits(r, q, to=bound) for r, q in zip(tried, limits, strict=True)],
                axis=-1,
            )
            for bound in LIMIT_BOUND_NAMES
        }
        expected, grades = margins["normal"].copy(), dict[tuple[str, Limit], IntArray]()
        first = 0
        for line, of, crests in zip(tried, limits, self._crests, strict=True):
            for q in of:
                likely = _expected_limit(q, crests) if q.limit.quantity in crests else q
                size = q.values.shape[-2] * q.values.shape[-1]
                if likely is not q:
                    expected[:, first : first + size] = margins_of_limits(
                        line, (likely,), to="normal"
                    )
                first += size
                worst = np.where(np.isnan(likely.values), 0, likely.grades()).max(axis=(-2, -1))
                key = line.line.name, q.limit
                grades[key] = np.maximum(grades.get(key, 0), worst)
        shape = (len(grades), len(amounts))
        every = np.stack([np.broadcast_to(g, shape[1:]) for g in grades.values()])
        return SettingResults(
            margins=margins,
            expected_margin=expected,
            exceeded=(every == CHECK_GRADES.index("fail")).sum(axis=0),
            warned=(every == CHECK_GRADES.index("warn")).sum(axis=0),
        )

    @cached_property
    def _crests(self) -> list[Mapping[str, tuple[FloatArray, BoolArray]]]:
        """What forces are over those of linear rubber that slides, as installed, line by line.

        And where that is by a stop, which a setting may keep clear of; by quantity (S, parts).
        """
        found: list[Mapping[str, tuple[FloatArray, BoolArray]]] = []
        for r in self.lines:
            crests, at_stop = force_crests(r), r.mount_loads.is_solved_at_stop
            keys = (f"centre_bearing_{kind}" for kind in FORCE_KINDS)
            found.append({k: (crests.get(k, np.ones((1, 1))), at_stop) for k in keys})
        return found


def _expected_limit(
    of: EvaluatedLimit, crests: Mapping[str, tuple[FloatArray, BoolArray]]
) -> EvaluatedLimit:
    """Return a limit's values with forces at stops as much larger as they are as installed."""
    crest, at_stop = crests[of.limit.quantity]
    clear = at_stop & (of.validity_margin >= 0)
    return replace(
        of,
        values=of.values * np.where(clear, 1.0, crest),
        validity_margin=np.full_like(of.validity_margin, np.inf),
    )


@dataclass(frozen=True)
class CorrectionSearch:
    """The margins of a line, and of those that leave its axle, over where its ways stand, -1 to 1.

    Yokes are turned by fixed amounts `turns` (movable); of the stepless ways those named in
    `free` move in proportion, the others stay at 0. `changed` separates the margins that moving
    can change at all from those that it cannot.
    """

    evaluator: SettingEvaluator
    turns: FloatArray
    free: tuple[int, ...]
    changed: BoolArray
    most: int = 0
    """Criteria exceeded at most, as installed: what exceeds more is not proposed."""
    trucks: ToleranceModel | None = None

    @property
    def movable(self) -> tuple[PermittedAdjustment, ...]:
        """What may be moved."""
        return self.evaluator.movable

    @cached_property
    def settings(self) -> FloatArray | None:
        """The amounts (V, movable) of all that a workshop can set.

        None of more than `MAX_EXHAUSTIVE_SEARCH_SETTINGS`.
        """
        of = [self.movable[k] for k in self.free]
        if not of or any(
            not a.step > 0 or (a.high - a.low) / a.step > MAX_EXHAUSTIVE_SEARCH_SETTINGS for a in of
        ):
            return None
        ways = [_set(a) for a in of]
        if prod(map(len, ways)) > MAX_EXHAUSTIVE_SEARCH_SETTINGS:
            return None
        found = np.tile(self.turns, (prod(map(len, ways)), 1))
        found[:, list(self.free)] = np.array(list(product(*ways)))
        return found

    def reserve(self, amounts: FloatArray, *, to: LimitBoundName) -> FloatArray | None:
        """Return what each margin needs in reserve as trucks scatter; None where none does."""
        if self.trucks is None:
            return None
        scatter = self.trucks.margin_standard_deviations(self.movable, amounts, to=to)[self.changed]
        return MIN_MARGIN_AFTER_CORRECTION + ROBUST_MARGIN_STANDARD_DEVIATIONS * scatter

    def amounts(self, positions: FloatArray) -> FloatArray:
        """Return the amounts (V, movable) at positions (V, free)."""
        found = np.tile(self.turns, (len(positions), 1))
        for at, k in zip(positions.T, self.free, strict=True):
            adjustable = self.movable[k]
            found[:, k] = np.where(at > 0, adjustable.high, -adjustable.low) * at
        return found

    def margins(self, positions: FloatArray, *, to: LimitBoundName) -> FloatArray:
        """Return the margins (V, ...) that moving changes."""
        return self.asked(self.amounts(positions))[to]

    def asked(self, amounts: FloatArray) -> BoundMargins:
        """Return the margins (V, ...) that moving changes, to either bound."""
        found = self.evaluator.evaluate(amounts).margins
        return {bound: values[:, self.changed] for bound, values in found.items()}

    def least_margins(self, amounts: FloatArray, *, to: LimitBoundName) -> FloatArray:
        """Return the least margin (V,) to a bound of settings (V, movable) that may be proposed.

        Of others, which fail or exceed more criteria than as installed, none while one is left
        that may: no margin elsewhere makes up for that.
        """
        asked = self.asked(amounts)
        stands = (asked["maximum"] >= 0).all(-1)
        allowed = self.evaluator.evaluate(amounts).exceeded <= self.most
        kept = stands if stands.any() else allowed if allowed.any() else ~allowed
        return np.where(kept, asked[to].min(-1), -np.inf)

    def is_hopeless(self) -> bool:
        """Return whether all trials exceed more criteria than the line as installed.

        A part of them says so where they exceed many more.
        """
        spread = self.amounts(spread_positions(len(self.free)))
        few = self.evaluator.evaluate(spread[: 1 + len(spread) // 4]).exceeded.min()
        if few > self.most + 1:
            return True
        return bool(self.evaluator.evaluate(spread).exceeded.min() > self.most)

    def fewest_exceeded(self, amounts: FloatArray, *, count: int = 1) -> FloatArray:
        """Return of settings (V, movable) those expected to exceed fewest criteria, best first.

        Of those the ones with the fewest warnings, then the cheapest.
        """
        found = self.evaluator.evaluate(amounts)
        costs = np.round(self.shares(amounts), 6)
        return amounts[np.lexsort((costs, found.warned, found.exceeded))[:count]]

    def settable_with_fewest_exceeded(self) -> FloatArray:
        """Return the `fewest_exceeded` (movable) about spread trials, or on the way back to 0."""
        spread = self.amounts(spread_positions(len(self.free)))
        best = self.fewest_exceeded(spread, count=ROUNDED_TRIALS)
        around = np.concatenate([self._beside(one) for one in best])
        (one,) = self.fewest_exceeded(around)
        steps = np.array([a.step for a in self.movable])
        whole = np.where(steps > 0, steps, 1.0)
        back = self.turns + BACKTRACKING_FRACTIONS * (one - self.turns)
        back = np.where(steps > 0, np.trunc(back / whole + np.copysign(1e-9, back)) * whole, back)
        back[:, self._fixed] = self.turns[self._fixed]
        return self.fewest_exceeded(np.concatenate([one[None], np.unique(back, axis=0)]))[0]

    @cached_property
    def _fixed(self) -> list[int]:
        return [k for k in range(len(self.movable)) if k not in self.free]

    def settable(
        self, position: FloatArray, *, to: LimitBoundName, cheap: bool = False
    ) -> FloatArray:
        """Return the amounts (movable) next to a position that a workshop can set.

        A step of a workshop may be more than the room that is left: of those around the
        position it is the one of most margin, or the `cheap`est that keeps every margin.
        """
        every = self._beside(self.amounts(position[None])[0])
        least = self.least_margins(every, to=to)
        if cheap and (least >= 0).any():
            every = every[least >= 0]
            return every[self.shares(every).argmin()]
        return every[least.argmax()]

    def _beside(self, amounts: FloatArray) -> FloatArray:
        """Return the settings (V, movable) of a workshop around amounts (movable)."""
        steps = np.array([a.step for a in self.movable])
        whole = np.where(steps > 0, steps, 1.0)
        down = np.where(steps > 0, np.floor(amounts / whole + 1e-9) * whole, amounts)
        up = np.where(steps > 0, np.ceil(amounts / whole - 1e-9) * whole, amounts)
        beside = [sorted({a, b}) for a, b in zip(down.tolist(), up.tolist(), strict=True)]
        if prod(map(len, beside)) > MAX_ROUNDING_VARIANTS:
            beside = [[float(np.round(a / w) * w)] for a, w in zip(amounts, whole, strict=True)]
        every = np.array(list(product(*beside)))
        low, high = (np.array([getattr(a, n) for a in self.movable]) for n in ("low", "high"))
        free = list(self.free)
        every[:, free] = np.clip(every, low, high)[:, free]
        return every

    def shares(self, amounts: FloatArray) -> FloatArray:
        """Return the sums (V,) of the shares of their ranges that amounts (V, movable) use."""
        of = [self.movable[k] for k in self.free]
        amounts = amounts[:, list(self.free)]
        bounds = np.where(amounts > 0, [a.high for a in of], [a.low for a in of])
        return (amounts / np.where(amounts == 0, 1.0, bounds)).sum(-1)

    def exhausted(self, settings: FloatArray) -> Iterator[FloatArray]:
        """Yield of all settings (V, movable) the one of most margin, and the cheapest that do.

        And the one with the fewest criteria exceeded.
        """
        settings = settings[np.argsort(self.shares(settings), kind="stable")]
        asked = self.asked(settings)
        yield self.fewest_exceeded(settings)[0]
        for bound in LIMIT_BOUND_NAMES:
            margin, least = asked[bound], self.least_margins(settings, to=bound)
            top = settings[(least >= least.max() - MIN_MARGIN_CHANGE).argmax()]
            yield top
            most = margin.min(-1).max()
            reserve = (
                self.reserve(top, to=bound) if most >= MIN_MARGIN_AFTER_CORRECTION else None
            )  # which needs a batch, and is no less than that
            for needed in (0.0, reserve):
                if needed is not None and (keeps := (margin >= needed).all(-1)).any():
                    yield settings[keeps.argmax()]

    def best(self, *, to: LimitBoundName) -> tuple[FloatArray, float, FloatArray]:
        """Return the position of the largest smallest margin, and that margin.

        And the trial nearest to 0 that keeps every margin in reserve, or that position again.
        """
        spread = spread_positions(len(self.free))
        found = self.least_margins(self.amounts(spread), to=to)
        start = spread[np.argmax(found)]

        def room(z: FloatArray) -> tuple[float, FloatArray]:
            return -z[-1], np.append(np.zeros(len(z) - 1), -1.0)

        def beyond(z: FloatArray) -> tuple[FloatArray, FloatArray]:
            margin, slope = self._smooth(z[:-1], to=to)
            return margin - z[-1], np.column_stack([slope, -np.ones(len(margin))])

        def lost(z: FloatArray, left: FloatArray) -> float:
            more = self.evaluator.evaluate(self.amounts(z[None, :-1])).exceeded[0] > self.most
            return np.inf if more else -float(left.min() + z[-1])

        top = self._solve(np.append(start, found.max()), cost=room, needed=beyond, merit=lost)[:-1]
        about = np.stack([start, top])
        reached = self.least_margins(self.amounts(about), to=to)
        top, margin = about[reached.argmax()], float(reached.max())
        if margin <= found.max():
            top, margin = self._nearby(start, to=to)
        kept = spread[found > MIN_MARGIN_AFTER_CORRECTION]
        return top, margin, min(kept, key=lambda x: float(x @ x), default=top)

    def _nearby(self, start: FloatArray, *, to: LimitBoundName) -> tuple[FloatArray, float]:
        """Return the position of the largest smallest margin about another, and that margin.

        For where slopes lead astray: over a crest into another valley.
        """
        top, reached = start, -np.inf
        spread = spread_positions(len(self.free), trials=LOCAL_SEARCH_TRIALS)
        for share in LOCAL_SEARCH_RADIUS_RANGE_SHARES:
            about = np.clip(top + share * spread, -1, 1)
            found = self.least_margins(self.amounts(about), to=to)
            top, reached = about[found.argmax()], float(found.max())
        return top, reached

    def least(
        self,
        start: FloatArray,
        *,
        to: LimitBoundName,
        reserve: FloatArray | float = MIN_MARGIN_AFTER_CORRECTION,
    ) -> FloatArray:
        """Return the cheapest position found that keeps every margin in reserve.

        `start` keeps them. Where the search goes astray, as which point is worst changes from
        place to place, it is the cheapest on the straight ways there and to 0.
        """

        def cost(x: FloatArray) -> tuple[float, FloatArray]:
            size = np.sqrt(
                x**2 + MOVE_COST_SMOOTHING_RANGE_SHARE**2
            )  # without the edge that a share has at 0
            return float(size.sum()), x / size

        def kept(x: FloatArray) -> tuple[FloatArray, FloatArray]:
            margin, slope = self._smooth(x, to=to)
            return margin - reserve, slope

        def spent(x: FloatArray, left: FloatArray) -> float:
            return cost(x)[0] if left.min() >= -MIN_MARGIN_AFTER_CORRECTION_TOLERANCE else np.inf

        end = self._solve(start, cost=cost, needed=kept, merit=spent)
        ways = np.concatenate(
            [start + BACKTRACKING_FRACTIONS * (goal - start) for goal in (end, 0 * start)]
        )
        keeps = (self.margins(ways, to=to) - reserve).min(
            -1
        ) >= -MIN_MARGIN_AFTER_CORRECTION_TOLERANCE
        keeps[0] = True
        return ways[keeps][np.abs(ways[keeps]).sum(-1).argmin()]

    def _smooth(self, at: FloatArray, *, to: LimitBoundName) -> tuple[FloatArray, FloatArray]:
        """Return margins and their slopes at a position, from one batch of neighbours."""
        step = 1e-5
        found = self.margins(np.vstack([at, at + step * np.eye(len(at))]), to=to)
        return found[0], (found[1:] - found[0]).T / step

    def _solve(
        self,
        start: FloatArray,
        *,
        cost: FunctionWithGradient,
        needed: FunctionWithGradient,
        merit: Callable[[FloatArray, FloatArray], float],
    ) -> FloatArray:
        """Follow a cost downhill while what is needed stays above 0, and return the best place.

        That of least `merit` of a place and what is needed there. It ends where that gets no
        less: which limit is worst changes from place to place, and slopes lead to and fro.
        """
        from scipy.optimize import minimize  # slow to import: only `fix` waits for it

        ways, known = len(self.free), dict[bytes, tuple[FloatArray, FloatArray]]()
        bounds = [(-1.0, 1.0)] * ways + [(-np.inf, np.inf)] * (len(start) - ways)
        best, least, stalled = start, np.inf, 0

        def once(z: FloatArray) -> tuple[FloatArray, FloatArray]:
            """Return what is needed; SLSQP requests value and slope of a place one by one."""
            nonlocal best, least, stalled
            if z.tobytes() not in known:
                known[z.tobytes()] = needed(z)
                found = merit(z, known[z.tobytes()][0])
                gains = found < least - MIN_SOLVER_GAIN * max(abs(found), 1.0)
                stalled = 0 if gains else stalled + 1
                if found < least:
                    best, least = z.copy(), found
                if stalled > MAX_STALLED_STEPS:
                    raise _SolverStalledError
            return known[z.tobytes()]

        def room(z: FloatArray) -> Any:
            return once(z)[0]

        def slope(z: FloatArray) -> FloatArray:
            return once(z)[1]

        with suppress(_SolverStalledError):
            minimize(
                cost,
                start,
                jac=True,
                bounds=bounds,
                method="SLSQP",
                constraints={"type": "ineq", "fun": room, "jac": slope},
                # Steps are rounded to what a workshop can set: a margin to 0.01 % is enough.
                options={"maxiter": 40, "ftol": 1e-4},
            )
        return np.clip(best, *np.transpose(bounds))


class _SolverStalledError(Exception):
    """Raised out of a solver that gets no further."""


def _set(way: PermittedAdjustment) -> FloatArray:
    """Return what a workshop can set of a way: whole steps, and the ends of its range."""
    low, high = way.low / way.step, way.high / way.step
    whole = np.arange(np.ceil(low - 1e-9), np.floor(high + 1e-9) + 1)
    ends = [end for end in (low, high) if abs(end - round(end)) > 1e-9]
    return np.append(whole, ends) * way.step


def spread_positions(ways: int, *, trials: int = SPREAD_TRIALS_PER_ADJUSTMENT) -> FloatArray:
    """Return positions (V, ways) spread evenly over all ways, the middle first.

    Source: Roberts (2018), an additive recurrence by powers of the generalised golden ratio.
    """
    ratio = 2.0
    for _ in range(GOLDEN_RATIO_STEPS):  # the root above 1 of x^(ways + 1) = x + 1
        ratio = (1.0 + ratio) ** (1.0 / (ways + 1))
    step = ratio ** -np.arange(1.0, ways + 1)
    return 2 * ((0.5 + np.arange(1 + trials * ways)[:, None] * step) % 1) - 1


def changed_margins(asked: BoundMargins) -> BoolArray:
    """Return which margins moving can change, and correct, from those of trials (V, ...)."""
    every = np.stack(list(asked.values()))
    low, high = every.min(axis=1), every.max(axis=1)
    hopeless = (high < 0) & (high - low < MIN_SHORTFALL_CHANGE_SHARE * -low)
    return ((high - low > MIN_MARGIN_CHANGE) & ~hopeless).any(axis=0)


def corrections(search: CorrectionSearch) -> Iterator[FloatArray]:
    """Yield settings worth comparing.

    Where the smallest margin is largest, the least ways to no warning and to no fail, and where
    the fewest criteria are exceeded.
    """
    if search.settings is not None:
        yield from search.exhausted(search.settings)
        return
    yield search.settable_with_fewest_exceeded()
    if search.turns.any() and search.is_hopeless():
        return
    for bound in LIMIT_BOUND_NAMES:
        top, margin, near = search.best(to=bound)
        yield search.settable(top, to=bound)
        if margin > MIN_MARGIN_AFTER_CORRECTION:
            for start in (top, near):
                yield search.settable(search.least(start, to=bound), to=bound, cheap=True)
            reserve = search.reserve(search.amounts(top[None])[0], to=bound)
            if reserve is not None and (search.margins(top[None], to=bound) >= reserve).all():
                sure = search.least(top, to=bound, reserve=reserve)
                yield search.settable(sure, to=bound)


def adjusted_lines(
    lines: tuple[LineResponse, ...], movable: tuple[PermittedAdjustment, ...], amounts: FloatArray
) -> tuple[LineResponse, ...]:
    """Return lines with things moved by amounts (V, movable), or (movable,)."""
    return tuple(response_with_adjustments(line, movable, amounts) for line in lines)
