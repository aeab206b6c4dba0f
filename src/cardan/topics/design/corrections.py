"""What to change: bearing heights and sides, axle shim and yoke phases, over all states.

Every trial is one case on a leading axis of the same response that `approve_driveline` uses, so the
search evaluates hundreds of layouts at a time. What comes of it is held to the approval of the
application so corrected, by every study that a check runs.
"""

from collections.abc import Callable, Collection, Iterable, Iterator
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import product
from math import prod
from typing import Any, TypeAlias

import numpy as np

from cardan.approval.applied_adjustments import (
    AppliedAdjustment,
    affected_lines,
    allowed_adjustments,
    corrected_application,
    response_with_adjustments,
)
from cardan.approval.approval import Approval, approve_application, default_studies
from cardan.approval.driveline_study import (
    DrivelineStudy,
    evaluate_limits,
    line_checks,
    unevaluated_line_checks,
)
from cardan.approval.margins import (
    LIMIT_BOUND_NAMES,
    LimitBoundName,
    margins,
    margins_to_both_bounds,
)
from cardan.approval.study import DRIVELINE_STUDY_NAME, StudyResult
from cardan.checks.line_response import LineResponse, compute_line_response
from cardan.core.arrays import BoolArray, FloatArray
from cardan.core.errors import DesignError
from cardan.core.status import ProgressCallback, ignore_status
from cardan.core.verdict import (
    VERDICTS,
    Check,
    Verdict,
    worst_first_key,
    worst_verdict,
)
from cardan.model.adjustments import ADJUSTMENTS
from cardan.model.application import (
    Application,
    PermittedAdjustment,
    require_no_placeholders,
)
from cardan.physics.vehicle.state_demand import line_state_demand, resolve_line_references
from cardan.topics.design.correction import (
    Correction,
    LimitOfPart,
    exceeded_count,
    share_of_ranges_used,
)
from cardan.topics.design.robustness import (
    ToleranceModel,
)

MIN_MARGIN_AFTER_CORRECTION = 0.02
"""Margin the least correction keeps, so that rounding it does not undo it."""

SPREAD_TRIALS_PER_ADJUSTMENT = 48
"""Trials spread over each way that is free before the search follows the best of them."""

MAX_YOKE_PHASE_COMBINATIONS = 8
"""Choices of yoke phases that are searched together at most: two of each of three shafts."""

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

MIN_CORRECTIONS_WITH_TOLERANCE_YIELD = 8
"""Corrections of which the surviving share of trucks is computed, at least."""

MIN_MARGIN_ADVANTAGE_OVER_CHEAPER = 0.01
"""Of a bound: a correction that leaves no more than that beyond a cheaper one is its copy."""

LOCAL_SEARCH_RADIUS_RANGE_SHARES, LOCAL_SEARCH_TRIALS = (0.1, 0.03, 0.01), 8
"""Shares of the ranges about the best trial that are looked through by so many trials each way,
where slopes lead nowhere better."""

FIRST_ANSWER_TRIALS = 12
"""Spread trials that the first answer is the best of."""

BACKTRACKING_FRACTIONS = np.linspace(0.0, 1.0, 17)[:, None]
"""Places that are tried on the way back from a correction to the least one."""

FunctionWithGradient: TypeAlias = Callable[[FloatArray], tuple[Any, FloatArray]]


@dataclass(frozen=True, kw_only=True)
class _CorrectionCandidate:
    """A correction while it is searched for, with the verdict of its line alone."""

    movable: tuple[PermittedAdjustment, ...]
    amounts: tuple[float, ...]
    responses: tuple[LineResponse, ...]
    margin: float
    changed: BoolArray
    """Which margins of its lines moving can change."""

    @property
    def moves(self) -> tuple[AppliedAdjustment, ...]:
        """What it moves."""
        pairs = zip(self.movable, self.amounts, strict=True)
        return tuple(AppliedAdjustment(adjustable=a, amount=x) for a, x in pairs if x != 0)

    @property
    def rank(self) -> tuple[int, float, float]:
        """What trials are sorted by: the best verdict first, then the cheapest."""
        return VERDICTS.index(self.verdict), share_of_ranges_used(self.moves), -self.margin

    @property
    def gain(self) -> tuple[int, float]:
        """What it is shown by before the search has ended: the least is the best."""
        return VERDICTS.index(self.verdict), -self.margin

    @cached_property
    def checks(self) -> tuple[Check, ...]:
        """Those of its line, and of those that leave its axle."""
        return tuple(c for r in self.responses for c in line_checks(r))

    @cached_property
    def verdict(self) -> Verdict:
        """What its line comes to, and those that leave its axle."""
        found: list[Verdict] = [
            worst_verdict([c.grade, "incomplete"]) if c.is_lower_bound else c.grade
            for c in self.checks
        ]
        missed = any(u.limit.required for r in self.responses for u in unevaluated_line_checks(r))
        return worst_verdict([*found, "incomplete"] if missed else found)


@dataclass(frozen=True)
class _CorrectedLineStudy(DrivelineStudy):
    """The driveline with one of its lines as a trial leaves it."""

    trial: _CorrectionCandidate | None = field(default=None, kw_only=True)

    def run(
        self, application: Application, tell: ProgressCallback = ignore_status
    ) -> StudyResult[tuple[LineResponse, ...]]:
        """Run the search on every line."""
        del tell
        assert self.trial is not None
        tried = {r.line.name: r for r in self.trial.responses}
        responses = tuple(
            tried.get(i.line.name)
            or compute_line_response(
                application, line_state_demand(resolve_line_references(application, i))
            )
            for i in application.lines
        )
        return StudyResult(
            study=DRIVELINE_STUDY_NAME,
            answer=responses,
            checks=tuple(c for r in responses for c in line_checks(r)),
            unevaluated=tuple(u for r in responses for u in unevaluated_line_checks(r)),
        )


@dataclass(frozen=True)
class _CorrectionSearch:
    """The margins of a line, and of those that leave its axle, over where its ways stand, -1 to 1.

    Yokes are turned by fixed amounts `turns` (movable); of the stepless ways those named in
    `free` move in proportion, the others stay at 0. `changed` separates the margins that moving
    can change at all from those that it cannot.
    """

    lines: tuple[LineResponse, ...]
    movable: tuple[PermittedAdjustment, ...]
    turns: FloatArray
    free: tuple[int, ...]
    changed: BoolArray
    trucks: ToleranceModel | None = None
    known: dict[LimitBoundName, FloatArray] | None = None
    """The margins of the spread trials, if they were computed."""

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

    @cached_property
    def spread(self) -> dict[LimitBoundName, FloatArray]:
        """The margins (V, ...) of trials spread over all ways, to either bound."""
        if self.known is not None:
            return self.known
        return self.asked(self.amounts(_spread(len(self.free))))

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
        responses = _tried(self.lines, self.movable, self.amounts(positions))
        return margins(*responses, to=to)[:, self.changed]

    def asked(self, amounts: FloatArray) -> dict[LimitBoundName, FloatArray]:
        """Return the margins (V, ...) that moving changes, to either bound."""
        found = margins_to_both_bounds(*_tried(self.lines, self.movable, amounts))
        return {bound: values[:, self.changed] for bound, values in found.items()}

    def settable(
        self, position: FloatArray, *, to: LimitBoundName, cheap: bool = False
    ) -> FloatArray:
        """Return the amounts (movable) next to a position that a workshop can set.

        A step of a workshop may be more than the room that is left: of those around the
        position it is the one of most margin, or the `cheap`est that keeps every margin.
        """
        amounts = self.amounts(position[None])[0]
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
        least = _least(self.asked(every), to=to)
        if cheap and (least >= 0).any():
            every = every[least >= 0]
            return every[self.shares(every).argmin()]
        return every[least.argmax()]

    def shares(self, amounts: FloatArray) -> FloatArray:
        """Return the sums (V,) of the shares of their ranges that amounts (V, movable) use."""
        of = [self.movable[k] for k in self.free]
        amounts = amounts[:, list(self.free)]
        bounds = np.where(amounts > 0, [a.high for a in of], [a.low for a in of])
        return (amounts / np.where(amounts == 0, 1.0, bounds)).sum(-1)

    def exhausted(
        self, settings: FloatArray, asked: dict[LimitBoundName, FloatArray] | None = None
    ) -> Iterator[FloatArray]:
        """Yield of all settings (V, movable) the one of most margin, and the cheapest that do.

        Their margins `asked` may be known.
        """
        cheapest = np.argsort(self.shares(settings), kind="stable")
        settings = settings[cheapest]
        asked = self.asked(settings) if asked is None else _some(asked, cheapest)
        for bound in LIMIT_BOUND_NAMES:
            margin, least = asked[bound], _least(asked, to=bound)
            top = settings[(least >= least.max() - MIN_MARGIN_CHANGE).argmax()]
            yield top
            for needed in (0.0, self.reserve(top, to=bound)):
                if needed is not None and (keeps := (margin >= needed).all(-1)).any():
                    yield settings[keeps.argmax()]

    def best(self, *, to: LimitBoundName) -> tuple[FloatArray, float, FloatArray]:
        """Return the position of the largest smallest margin, and that margin.

        And the trial nearest to 0 that keeps every margin in reserve, or that position again.
        """
        spread, found = _spread(len(self.free)), _least(self.spread, to=to)
        start = spread[np.argmax(found)]

        def room(z: FloatArray) -> tuple[float, FloatArray]:
            return -z[-1], np.append(np.zeros(len(z) - 1), -1.0)

        def beyond(z: FloatArray) -> tuple[FloatArray, FloatArray]:
            margin, slope = self._smooth(z[:-1], to=to)
            return margin - z[-1], np.column_stack([slope, -np.ones(len(margin))])

        top = self._solve(np.append(start, found.max()), cost=room, needed=beyond)[:-1]
        about = np.stack([start, top])
        reached = _least(self.asked(self.amounts(about)), to=to)
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
        spread = _spread(len(self.free), trials=LOCAL_SEARCH_TRIALS)
        for share in LOCAL_SEARCH_RADIUS_RANGE_SHARES:
            about = np.clip(top + share * spread, -1, 1)
            found = _least(self.asked(self.amounts(about)), to=to)
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

        end = self._solve(start, cost=cost, needed=kept)
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
        self, start: FloatArray, *, cost: FunctionWithGradient, needed: FunctionWithGradient
    ) -> FloatArray:
        """Follow a cost downhill while what is needed stays above 0."""
        from scipy.optimize import minimize  # slow to import: only `fix` waits for it

        ways, known = len(self.free), dict[bytes, tuple[FloatArray, FloatArray]]()

        def once(z: FloatArray) -> tuple[FloatArray, FloatArray]:
            """Return what is needed; SLSQP requests value and slope of a place one by one."""
            if z.tobytes() not in known:
                known[z.tobytes()] = needed(z)
            return known[z.tobytes()]

        def room(z: FloatArray) -> Any:
            return once(z)[0]

        def slope(z: FloatArray) -> FloatArray:
            return once(z)[1]

        bounds = [(-1.0, 1.0)] * ways + [(-np.inf, np.inf)] * (len(start) - ways)
        found = minimize(
            cost,
            start,
            jac=True,
            bounds=bounds,
            method="SLSQP",
            constraints={"type": "ineq", "fun": room, "jac": slope},
            # Steps are rounded to what a workshop can set: a margin to 0.01 % is enough.
            options={"maxiter": 40, "ftol": 1e-4},
        )
        return np.clip(found.x, *np.transpose(bounds))


def _least(asked: dict[LimitBoundName, FloatArray], *, to: LimitBoundName) -> FloatArray:
    """Return the least margin (V,) to a bound; of what fails none while anything else is left.

    What fails is no cure for a warning, whatever margin it wins elsewhere.
    """
    stands = (asked["maximum"] >= 0).all(-1)
    return np.where(stands | ~stands.any(), asked[to].min(-1), -np.inf)


def _set(way: PermittedAdjustment) -> FloatArray:
    """Return what a workshop can set of a way: whole steps, and the ends of its range."""
    low, high = way.low / way.step, way.high / way.step
    whole = np.arange(np.ceil(low - 1e-9), np.floor(high + 1e-9) + 1)
    ends = [end for end in (low, high) if abs(end - round(end)) > 1e-9]
    return np.append(whole, ends) * way.step


def _spread(ways: int, *, trials: int = SPREAD_TRIALS_PER_ADJUSTMENT) -> FloatArray:
    """Return positions (V, ways) spread over all ways, the middle first."""
    positions = np.random.default_rng(1).uniform(-1, 1, (1 + trials * ways, ways))
    positions[0] = 0.0
    return positions


def find_corrections(
    application: Application,
    *,
    line: str | None = None,
    hold: Collection[str] = (),
    count: int = 6,
    draws: int = 0,
    tell: Callable[[int, int], None] | None = None,
    show: Callable[[Correction], None] | None = None,
) -> tuple[Correction, ...]:
    """Propose corrections of a line, for all its states at once.

    Parameters
    ----------
    application
        Its permitted adjustments say what may move and how far; without any, centre bearings by
        30 mm, the axle by 3 deg of shim, and every shaft aligned or crossed.
    line
        Which line; by default the one with the worst check.
    hold
        What stays where it is, by name: "bearing_height", or "phase 2" for one part.
    count
        How many proposals at most.
    draws
        How many trucks are evaluated for each proposal, each by itself; 0 takes their margins from
        slopes and bends at the setting.
    tell
        Called with how many choices of yoke phases are searched, and of how many.
    show
        Called with the best of a few trials before the search begins, and with each that the
        search finds better: of a better verdict, or more margin. How many trucks survive is not
        known of these.

    Returns
    -------
    tuple of Correction
        Best verdict first, then what most trucks survive as they scatter, then the cheapest.
        None comes to a worse verdict than the line as installed, or to more criteria exceeded,
        nor is it beaten by that or by another that costs less and leaves more margin.

    Raises
    ------
    DesignError
        If the application has no such line, nothing of a name to hold, or placeholders.

    Notes
    -----
    It looks for the largest smallest margin, and the least ways to where nothing warns and
    nothing fails. If a workshop's settings are few all of them are evaluated. Of more, spread
    trials find the region and sequential quadratic programming the place in it. Other lines and
    studies evaluate the result, not while it goes on.
    """
    require_no_placeholders(application)
    response = _line(application, line)
    movable = _unheld(allowed_adjustments(response), hold)
    before = compute_line_response(application, response.demand)
    trucks = ToleranceModel.from_application(application, response.line.name)
    showing = show and _ProgressReporter(before, show)
    if showing:
        showing.all(_glance(before, movable))
    found: dict[tuple[AppliedAdjustment, ...], _CorrectionCandidate] = {}
    for t in _trials(before, movable, trucks, tell):
        found[t.moves] = t
        if showing:
            showing.all((t,))
    installed = found.get(())
    if installed is None:  # nothing that may be moved changes anything
        return ()
    # Before they are compared: what exceeds more hides by its margin what exceeds less.
    most = exceeded_count(installed.checks)
    ranked = sorted(
        (t for t in found.values() if exceeded_count(t.checks) <= most), key=lambda t: t.rank
    )
    unbeaten = [t for t in _unbeaten(ranked) if t.moves][
        : max(count, MIN_CORRECTIONS_WITH_TOLERANCE_YIELD)
    ]
    standing = _approval(before, installed)
    proposals: list[Correction] = []
    for t in unbeaten:
        survival = trucks and trucks.survival(t.movable, np.array(t.amounts), asked=draws)
        one = _proposal(before, t, installed, standing)
        proposals.append(replace(one, tolerance_yield=survival, tolerance_model=trucks))
    kept = (p for p in proposals if p.is_acceptable)
    return tuple(sorted(kept, key=lambda p: p.sort_key)[:count])


class _ProgressReporter:
    """Shows the corrections that are better than those before, of trials as they come."""

    def __init__(self, before: LineResponse, show: Callable[[Correction], None]) -> None:
        self.before, self.show = before, show
        self.best: _CorrectionCandidate | None = None

    def all(self, trials: Iterable[_CorrectionCandidate]) -> None:
        """Take trials, the line as installed before any other."""
        for t in trials:
            if self.best is None:
                self.best, self.installed = t, t
                self.standing = _approval(self.before, t)
            elif t.moves and t.gain < self.best.gain:
                one = _proposal(self.before, t, self.installed, self.standing)
                if one.is_acceptable:
                    self.best = t
                    self.show(one)


def _proposal(
    before: LineResponse,
    t: _CorrectionCandidate,
    installed: _CorrectionCandidate,
    standing: Approval,
) -> Correction:
    """Return what a trial comes to next to the line as installed."""
    return Correction(
        line=before.line.name,
        adjustments=t.moves,
        margin_before=installed.margin,
        margin=t.margin,
        approval=_approval(before, t),
        installed_approval=standing,
        changeable=_changeable_limits(installed),
    )


def _changeable_limits(installed: _CorrectionCandidate) -> frozenset[LimitOfPart]:
    """Return the limits of lines and parts that moving changes in at least one state."""
    every = [
        (r.line.name, question.limit, part)
        for r in installed.responses
        for question in evaluate_limits(r)
        for _ in range(question.values.shape[-2])
        for part in question.parts
    ]
    changed = installed.changed.tolist()
    return frozenset(one for one, moves in zip(every, changed, strict=True) if moves)


def _approval(before: LineResponse, trial: _CorrectionCandidate) -> Approval:
    """Return the approval of an application with one line as a trial leaves it."""
    application = corrected_application(before, trial.movable, np.array(trial.amounts))
    _, *others = default_studies(application)
    return approve_application(application, (_CorrectedLineStudy(trial=trial), *others))


def _unheld(
    movable: tuple[PermittedAdjustment, ...], hold: Collection[str]
) -> tuple[PermittedAdjustment, ...]:
    """Return what may move after all; a name nothing goes by is refused."""
    names = {a: (a.adjustment_key, f"{a.adjustment_key} {a.part}") for a in movable}
    known = {name for both in names.values() for name in both}
    for name in hold:
        if name not in known:
            msg = f"nothing that may move is called {name}; there are: {', '.join(sorted(known))}"
            raise DesignError(msg)
    return tuple(a for a, both in names.items() if not set(both) & set(hold))


def _line(application: Application, name: str | None) -> LineResponse:
    """Return the line of a name, or the one with the worst check."""
    responses = {
        i.line.name: compute_line_response(
            application, line_state_demand(resolve_line_references(application, i))
        )
        for i in application.lines
    }
    if name is None:
        return min(
            responses.values(),
            key=lambda r: min(map(worst_first_key, line_checks(r)), default=(0, 0)),
        )
    if name not in responses:
        msg = f"there is no line {name}; the application has {', '.join(responses)}"
        raise DesignError(msg)
    return responses[name]


def _trials(
    response: LineResponse,
    movable: tuple[PermittedAdjustment, ...],
    trucks: ToleranceModel | None,
    tell: Callable[[int, int], None] | None,
) -> Iterator[_CorrectionCandidate]:
    """Yield every trial worth comparing: each way alone, all together, each yoke turned.

    The line as installed is the first; nothing where no move changes anything.
    """
    ways = _ways(movable)
    lines = affected_lines(response, movable)
    turnings = list(_turnings(response, movable))
    everything = _CorrectionSearch(lines, movable, turnings[0], ways, np.array([], dtype=bool))
    spread = everything.amounts(_spread(len(ways)))
    trials = np.concatenate([spread, np.stack(turnings)])
    asked = margins_to_both_bounds(*_tried(lines, movable, trials))
    changed = _changed(asked)
    if not changed.any():
        return
    for k, turns in enumerate(turnings):
        if tell:
            tell(k, len(turnings))
        yield _trial(lines, movable, turns, changed)
        alone = [] if turns.any() or len(ways) < 2 else [(k,) for k in ways]
        for free in [*alone, *([ways] if ways else [])]:
            known: dict[LimitBoundName, FloatArray] | None = None
            if k == 0 and free == ways:
                known = {b: v[: len(spread), changed] for b, v in asked.items()}
            search = _CorrectionSearch(lines, movable, turns, free, changed, trucks, known)
            for amounts in _corrections(search):
                yield _trial(lines, movable, amounts, changed)


def _glance(
    response: LineResponse, movable: tuple[PermittedAdjustment, ...]
) -> Iterator[_CorrectionCandidate]:
    """Yield the line as installed, and the best of a few trials that a workshop can set.

    For a first result soon: nothing where no move changes anything.
    """
    lines = affected_lines(response, movable)
    turnings = np.stack(list(_turnings(response, movable)))
    search = _CorrectionSearch(
        lines, movable, turnings[0], _ways(movable), np.array([], dtype=bool)
    )
    few = search.amounts(_spread(len(search.free))[:FIRST_ANSWER_TRIALS])
    steps = np.array([a.step for a in movable])
    whole = np.where(steps > 0, steps, 1.0)
    few = np.where(steps > 0, np.trunc(few / whole) * whole, few)  # towards 0: within the range
    trials = np.concatenate([few, turnings[1:]])
    asked = margins_to_both_bounds(*_tried(lines, movable, trials))
    changed = _changed(asked)
    if changed.any():
        yield _trial(lines, movable, turnings[0], changed)
        best = replace(search, changed=changed).exhausted(trials, _some(asked, np.s_[:, changed]))
        once = {tuple(amounts.tolist()): amounts for amounts in best}.values()
        yield min((_trial(lines, movable, a, changed) for a in once), key=lambda t: t.gain)


def _ways(movable: tuple[PermittedAdjustment, ...]) -> tuple[int, ...]:
    """Return which things move steplessly, or in small steps; the others are choices."""
    return tuple(
        k for k, a in enumerate(movable) if not ADJUSTMENTS[a.adjustment_key].extremes_only
    )


def _changed(asked: dict[LimitBoundName, FloatArray]) -> BoolArray:
    """Return which margins moving can change, and correct, from those of trials (V, ...)."""
    every = np.stack(list(asked.values()))
    low, high = every.min(axis=1), every.max(axis=1)
    hopeless = (high < 0) & (high - low < MIN_SHORTFALL_CHANGE_SHARE * -low)
    return ((high - low > MIN_MARGIN_CHANGE) & ~hopeless).any(axis=0)


def _some(asked: dict[LimitBoundName, FloatArray], at: Any) -> dict[LimitBoundName, FloatArray]:
    """Return some of margins (V, ...) to either bound."""
    return {to: margins[at] for to, margins in asked.items()}


def _corrections(search: _CorrectionSearch) -> Iterator[FloatArray]:
    """Yield where the smallest margin is largest, and the least ways to no warning, no fail."""
    if search.settings is not None:
        yield from search.exhausted(search.settings)
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


def _turnings(
    response: LineResponse, movable: tuple[PermittedAdjustment, ...]
) -> Iterator[FloatArray]:
    """Yield the amounts (movable) of choices of yoke phases, as installed first.

    Every combination while they are few; each yoke turned by itself where they are not: each
    choice is a search of its own, and they double with every shaft.
    """
    choices = []
    for adjustable in movable:
        turns = [0.0]
        if ADJUSTMENTS[adjustable.adjustment_key].extremes_only:
            turns += _ends(response, adjustable)
        choices.append(list(dict.fromkeys(t for t in turns if t == 0 or abs(t) > 1e-9)))
    if prod(map(len, choices)) <= MAX_YOKE_PHASE_COMBINATIONS:
        yield from (np.array(choice) for choice in product(*choices))
        return
    still = np.zeros(len(movable))
    yield still
    for k, turns in enumerate(choices):
        for turn in turns[1:]:
            turned = still.copy()
            turned[k] = turn
            yield turned


def _ends(response: LineResponse, adjustable: PermittedAdjustment) -> list[float]:
    """Return how far yokes turn to the ends of their range, which count from the aligned."""
    installed = response.line.phases[adjustable.part - 1]
    return [bound - installed for bound in (adjustable.low, adjustable.high)]


def _tried(
    lines: tuple[LineResponse, ...], movable: tuple[PermittedAdjustment, ...], amounts: FloatArray
) -> tuple[LineResponse, ...]:
    """Return lines with things moved by amounts (V, movable), or (movable,)."""
    return tuple(response_with_adjustments(line, movable, amounts) for line in lines)


def _trial(
    lines: tuple[LineResponse, ...],
    movable: tuple[PermittedAdjustment, ...],
    amounts: FloatArray,
    changed: BoolArray,
) -> _CorrectionCandidate:
    """Return the trial that moves things by these amounts."""
    responses = _tried(lines, movable, amounts)
    return _CorrectionCandidate(
        movable=movable,
        amounts=tuple((amounts + 0.0).tolist()),  # no negative zeros
        responses=responses,
        margin=float(margins(*responses, to="normal")[..., changed].min()),
        changed=changed,
    )


def _unbeaten(ranked: list[_CorrectionCandidate]) -> Iterator[_CorrectionCandidate]:
    """Yield the trials that leave more margin than all that come before, and not a hair more."""
    best = -np.inf
    for trial in ranked:
        if trial.margin > best + MIN_MARGIN_ADVANTAGE_OVER_CHEAPER:
            best = trial.margin
            yield trial
