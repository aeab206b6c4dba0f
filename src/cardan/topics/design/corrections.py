"""What to change: bearing heights and sides, axle shim and yoke phases, over all states.

Every trial is one case on a leading axis of the same response that `approve_driveline` uses, so the
search evaluates hundreds of layouts at a time. What comes of it is held to the approval of the
application so corrected, by every study that a check runs.
"""

from collections.abc import Callable, Collection, Iterable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import product
from math import prod

import numpy as np

from cardan.approval.applied_adjustments import (
    AppliedAdjustment,
    affected_lines,
    allowed_adjustments,
    corrected_application,
)
from cardan.approval.approval import Approval, approve_application, default_studies
from cardan.approval.driveline_study import (
    DrivelineStudy,
    EvaluatedLimit,
    evaluate_limits,
    line_checks,
    unevaluated_line_checks,
)
from cardan.approval.margins import LIMIT_BOUND_NAMES, LimitBoundName, margins_of_limits
from cardan.approval.study import DRIVELINE_STUDY_NAME, StudyResult
from cardan.checks.line_response import LineResponse, compute_line_response
from cardan.core.arrays import BoolArray, FloatArray
from cardan.core.errors import DesignError
from cardan.core.status import ProgressCallback, ignore_status
from cardan.core.verdict import (
    Check,
    UnevaluatedCheck,
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
    Standing,
    exceeded_count,
    share_of_ranges_used,
    standing_of,
)
from cardan.topics.design.correction_search import (
    CorrectionSearch,
    SettingEvaluator,
    adjusted_lines,
    changed_margins,
    corrections,
    spread_positions,
)
from cardan.topics.design.robustness import ToleranceModel

MAX_YOKE_PHASE_COMBINATIONS = 8
"""Choices of yoke phases that are searched together at most: two of each of three shafts."""

MAX_EVALUATED_CORRECTIONS = 8
"""Corrections that are evaluated in full at most, unless more are to be proposed: best first."""

MIN_MARGIN_ADVANTAGE_OVER_CHEAPER = 0.01
"""Of a bound: a correction that leaves no more than that beyond a cheaper one is its copy."""

EXPECTED_MARGIN_ERROR = 0.15
"""Share by which an expected margin may be off: forces at stops vary from setting to setting."""

FIRST_ANSWER_TRIALS = 12
"""Spread trials that the first answer is the best of."""


@dataclass(frozen=True, kw_only=True)
class _EvaluatedLine:
    """A line, with its limits evaluated once for whatever reads them."""

    response: LineResponse

    @cached_property
    def limits(self) -> tuple[EvaluatedLimit, ...]:
        """Every limit that applies to it."""
        return tuple(evaluate_limits(self.response))

    @cached_property
    def checks(self) -> tuple[Check, ...]:
        """Its checks."""
        return tuple(line_checks(self.response, self.limits))

    @cached_property
    def unevaluated(self) -> tuple[UnevaluatedCheck, ...]:
        """What got no number."""
        return tuple(unevaluated_line_checks(self.response, self.limits))

    @cached_property
    def margins(self) -> dict[LimitBoundName, FloatArray]:
        """Every margin to either bound, (M,)."""
        return {
            to: margins_of_limits(self.response, self.limits, to=to) for to in LIMIT_BOUND_NAMES
        }


@dataclass(frozen=True, kw_only=True)
class _CorrectionCandidate:
    """A correction while it is searched for: what is expected of it, and its lines alone.

    Attributes
    ----------
    changed : (M,)
        Which margins of its lines moving can change.
    expected, expected_margin
        How many criteria it would exceed and warn of, and its least margin, from a batch.
    """

    movable: tuple[PermittedAdjustment, ...]
    amounts: tuple[float, ...]
    installed: tuple[_EvaluatedLine, ...]
    changed: BoolArray
    expected: tuple[int, int]
    expected_margin: float

    @property
    def moves(self) -> tuple[AppliedAdjustment, ...]:
        """What it moves."""
        pairs = zip(self.movable, self.amounts, strict=True)
        return tuple(AppliedAdjustment(adjustable=a, amount=x) for a, x in pairs if x != 0)

    @property
    def cost(self) -> float:
        """Sum of the shares of their ranges that the moves use."""
        return share_of_ranges_used(self.moves)

    @property
    def expected_rank(self) -> tuple[tuple[int, int], float, float]:
        """What trials are sorted by before they are evaluated in full."""
        return self.expected, self.cost, -self.expected_margin

    @property
    def rank(self) -> tuple[Standing, float, float]:
        """What trials are sorted by: how the line stands, then the cheapest."""
        return self.standing, self.cost, -self.margin

    @property
    def expected_gain(self) -> tuple[tuple[int, int], float]:
        """What it is evaluated in full by before the search has ended: the least is the best."""
        return self.expected, -self.expected_margin

    @property
    def gain(self) -> tuple[Standing, float]:
        """What it is shown by before the search has ended: the least is the best."""
        return self.standing, -self.margin

    @cached_property
    def lines(self) -> tuple[_EvaluatedLine, ...]:
        """Its line, and those that leave its axle, each as one design."""
        if not self.moves:
            return self.installed
        before = tuple(line.response for line in self.installed)
        after = adjusted_lines(before, self.movable, np.array(self.amounts))
        return tuple(_EvaluatedLine(response=r) for r in after)

    @cached_property
    def margin(self) -> float:
        """The least margin to a warning of what moving can change."""
        return float(self.margins["normal"][self.changed].min())

    @property
    def margins(self) -> dict[LimitBoundName, FloatArray]:
        """Every margin of its lines to either bound, (M,)."""
        return {
            to: np.concatenate([line.margins[to] for line in self.lines])
            for to in LIMIT_BOUND_NAMES
        }

    @cached_property
    def checks(self) -> tuple[Check, ...]:
        """Those of its line, and of those that leave its axle."""
        return tuple(c for line in self.lines for c in line.checks)

    @cached_property
    def verdict(self) -> Verdict:
        """What its line comes to, and those that leave its axle."""
        found: list[Verdict] = [
            worst_verdict([c.grade, "incomplete"]) if c.is_lower_bound else c.grade
            for c in self.checks
        ]
        missed = any(u.limit.required for line in self.lines for u in line.unevaluated)
        return worst_verdict([*found, "incomplete"] if missed else found)

    @cached_property
    def standing(self) -> Standing:
        """Verdict, criteria exceeded and warnings of its lines."""
        return standing_of(self.verdict, self.checks)


@dataclass(frozen=True)
class _CorrectedLineStudy(DrivelineStudy):
    """The driveline with one of its lines as a trial leaves it, the others as installed."""

    lines: tuple[_EvaluatedLine, ...] = field(default=(), kw_only=True)

    def run(
        self, application: Application, tell: ProgressCallback = ignore_status
    ) -> StudyResult[tuple[LineResponse, ...]]:
        """Return what every line comes to."""
        del application, tell
        return StudyResult(
            study=DRIVELINE_STUDY_NAME,
            answer=tuple(line.response for line in self.lines),
            checks=tuple(c for line in self.lines for c in line.checks),
            unevaluated=tuple(u for line in self.lines for u in line.unevaluated),
        )


@dataclass(frozen=True, kw_only=True)
class CorrectionResults:
    """The approval of an application as installed, and the corrections proposed, best first."""

    installed: Approval
    proposals: tuple[Correction, ...]


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
    """Propose corrections of a line, for all its states at once, as `evaluate_corrections`."""
    return evaluate_corrections(
        application, line=line, hold=hold, count=count, draws=draws, tell=tell, show=show
    ).proposals


def evaluate_corrections(
    application: Application,
    *,
    line: str | None = None,
    hold: Collection[str] = (),
    count: int = 6,
    draws: int = 0,
    tell: Callable[[int, int], None] | None = None,
    show: Callable[[Correction], None] | None = None,
) -> CorrectionResults:
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
    CorrectionResults
        Best verdict first, then fewest criteria exceeded, fewest warnings, what most trucks
        survive as they scatter, and the cheapest. None comes to a worse verdict than the line as
        installed, or to more criteria exceeded, nor is it beaten by another that stands as well,
        costs less and leaves more margin.

    Raises
    ------
    DesignError
        If the application has no such line, nothing of a name to hold, or placeholders.

    Notes
    -----
    It looks for the largest smallest margin, the least ways to where nothing warns and nothing
    fails, and where the fewest criteria are exceeded. If a workshop's settings are few all of them
    are evaluated. Of more, spread trials find the region and sequential quadratic programming the
    place in it. All that are tried are evaluated in batches, in which forces at a stop are taken
    to be as much above those of linear rubber as they are of the line as installed; the best are
    then evaluated in full. Other lines and studies evaluate the result, not while it goes on.
    """
    require_no_placeholders(application)
    lines = {
        i.line.name: _EvaluatedLine(
            response=compute_line_response(
                application, line_state_demand(resolve_line_references(application, i))
            )
        )
        for i in application.lines
    }
    response = _line(lines, line)
    movable = _unheld(allowed_adjustments(response), hold)
    trucks = ToleranceModel.from_application(application, response.line.name)
    trials = _Trials(lines, response, movable)
    showing = show and _ProgressReporter(lines, response, show)
    if showing:
        showing.all(trials.glance())
    found: dict[tuple[AppliedAdjustment, ...], _CorrectionCandidate] = {}
    for t in trials.all(trucks, tell):
        t = found.setdefault(t.moves, t)
        if showing:
            showing.all((t,))
    installed = found.pop((), None)
    if installed is None:  # nothing that may be moved changes anything
        return CorrectionResults(installed=_approval(lines, response), proposals=())
    standing = _approval(lines, response)
    proposals: dict[tuple[AppliedAdjustment, ...], Correction] = {}
    evaluated: list[_CorrectionCandidate] = []
    for t in _worth_evaluating(found.values(), installed):
        best = [
            one for one in _unbeaten(installed, evaluated) if proposals[one.moves].is_acceptable
        ]
        full = len(best) >= count and t.expected > max(one.expected for one in best)
        if full or len(evaluated) == max(count, MAX_EVALUATED_CORRECTIONS):
            break
        # What exceeds more would hide by its margin what exceeds less.
        if exceeded_count(t.checks) <= exceeded_count(installed.checks):
            evaluated.append(t)
            proposals[t.moves] = _proposal(lines, response, t, installed, standing)
    kept = [
        (proposals[t.moves], t)
        for t in _unbeaten(installed, evaluated)
        if proposals[t.moves].is_acceptable
    ]
    return CorrectionResults(
        installed=standing,
        proposals=_with_tolerance_yields(kept, trucks, count=count, draws=draws),
    )


def _worth_evaluating(
    trials: Iterable[_CorrectionCandidate], installed: _CorrectionCandidate
) -> list[_CorrectionCandidate]:
    """Return the trials that no other is expected to beat, best expected first."""
    waiting = sorted(trials, key=lambda t: t.expected_rank)
    others = [*waiting, installed]
    return [t for t in waiting if not any(_is_expected_to_beat(one, t) for one in others)]


def _is_expected_to_beat(one: _CorrectionCandidate, other: _CorrectionCandidate) -> bool:
    """Return whether a trial surely is no dearer, leaves more margin and exceeds no more.

    Sure is what is more than the error of what is expected.
    """
    needed = other.expected_margin + EXPECTED_MARGIN_ERROR * abs(other.expected_margin)
    return (
        one.expected <= other.expected
        and one.cost <= other.cost + 1e-9
        and one.expected_margin > needed
    )


def _unbeaten(
    installed: _CorrectionCandidate, evaluated: Iterable[_CorrectionCandidate]
) -> list[_CorrectionCandidate]:
    """Return the trials that no other beats, which stands as well, costs no more, leaves more.

    Nor the line as installed.
    """
    found: list[_CorrectionCandidate] = []
    for t in sorted([installed, *evaluated], key=lambda t: t.rank):
        if not any(
            one.cost <= t.cost + 1e-9 and t.margin <= one.margin + MIN_MARGIN_ADVANTAGE_OVER_CHEAPER
            for one in found  # which stand no worse
        ):
            found.append(t)
    return [t for t in found if t is not installed]


def _with_tolerance_yields(
    proposals: Iterable[tuple[Correction, _CorrectionCandidate]],
    trucks: ToleranceModel | None,
    *,
    count: int,
    draws: int,
) -> tuple[Correction, ...]:
    """Return the best proposals with how many trucks keep each.

    Computed of those alone that stand so well that it can decide whether they are among the best.
    """
    ranked = sorted(proposals, key=lambda pair: pair[0].sort_key)
    if len(ranked) > count:
        last = ranked[count - 1][0].standing
        ranked = [pair for pair in ranked if pair[0].standing <= last]
    if trucks and not draws and ranked:
        settings = np.array([t.amounts for _, t in ranked])
        trucks.evaluate_about(ranked[0][1].movable, settings)
    found = [
        replace(
            p,
            tolerance_yield=trucks
            and trucks.survival(t.movable, np.array(t.amounts), asked=draws, solved=t.margins),
            tolerance_model=trucks,
        )
        for p, t in ranked
    ]
    return tuple(sorted(found, key=lambda p: p.sort_key)[:count])


class _ProgressReporter:
    """Shows the corrections that are better than those before, of trials as they come."""

    def __init__(
        self,
        lines: Mapping[str, _EvaluatedLine],
        before: LineResponse,
        show: Callable[[Correction], None],
    ) -> None:
        self.lines, self.before, self.show = lines, before, show
        self.best: _CorrectionCandidate | None = None

    def all(self, trials: Iterable[_CorrectionCandidate]) -> None:
        """Take trials, the line as installed before any other."""
        for t in trials:
            if self.best is None:
                self.best, self.installed = t, t
                self.standing = _approval(self.lines, self.before)
            elif self._may_be_better(t) and t.gain < self.best.gain:
                one = _proposal(self.lines, self.before, t, self.installed, self.standing)
                if one.is_acceptable:
                    self.best = t
                    self.show(one)

    def _may_be_better(self, t: _CorrectionCandidate) -> bool:
        """Return whether a trial is expected to be better, before it is evaluated in full."""
        assert self.best is not None
        return bool(t.moves) and t.expected_gain < self.best.expected_gain


def _proposal(
    lines: Mapping[str, _EvaluatedLine],
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
        approval=_approval(lines, before, t),
        installed_approval=standing,
        changeable=_changeable_limits(installed),
    )


def _changeable_limits(installed: _CorrectionCandidate) -> frozenset[LimitOfPart]:
    """Return the limits of lines and parts that moving changes in at least one state."""
    every = [
        (line.response.line.name, question.limit, part)
        for line in installed.lines
        for question in line.limits
        for _ in range(question.values.shape[-2])
        for part in question.parts
    ]
    changed = installed.changed.tolist()
    return frozenset(one for one, moves in zip(every, changed, strict=True) if moves)


def _approval(
    lines: Mapping[str, _EvaluatedLine],
    before: LineResponse,
    trial: _CorrectionCandidate | None = None,
) -> Approval:
    """Return the approval of an application, as installed or with a line as a trial leaves it."""
    application, tried = before.application, dict[str, _EvaluatedLine]()
    if trial and trial.moves:
        application = corrected_application(before, trial.movable, np.array(trial.amounts))
        tried = {line.response.line.name: line for line in trial.lines}
    _, *others = default_studies(application)
    driveline = _CorrectedLineStudy(lines=tuple({**lines, **tried}.values()))
    return approve_application(application, (driveline, *others))


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


def _line(lines: Mapping[str, _EvaluatedLine], name: str | None) -> LineResponse:
    """Return the line of a name, or the one with the worst check."""
    if name is None and len(lines) == 1:
        (only,) = lines.values()
        return only.response
    if name is None:
        return min(
            lines.values(),
            key=lambda line: min(map(worst_first_key, line.checks), default=(0, 0)),
        ).response
    if name not in lines:
        msg = f"there is no line {name}; the application has {', '.join(lines)}"
        raise DesignError(msg)
    return lines[name].response


class _Trials:
    """The settings of one line that are worth comparing, each evaluated once in a batch."""

    def __init__(
        self,
        lines: Mapping[str, _EvaluatedLine],
        response: LineResponse,
        movable: tuple[PermittedAdjustment, ...],
    ) -> None:
        own = affected_lines(response, movable)
        self.response = response
        self.installed = tuple(lines[r.line.name] for r in own)
        self.evaluator = SettingEvaluator(tuple(e.response for e in self.installed), movable)

    def all(
        self, trucks: ToleranceModel | None, tell: Callable[[int, int], None] | None
    ) -> Iterator[_CorrectionCandidate]:
        """Yield every trial worth comparing: each way alone, all together, each yoke turned.

        The line as installed is the first; nothing where no move changes anything.
        """
        movable = self.evaluator.movable
        ways = _ways(movable)
        turnings = list(_turnings(self.response, movable))
        spread = _search(self.evaluator, turnings[0], ways).amounts(spread_positions(len(ways)))
        alone = [
            settings
            for k in (ways if len(ways) > 1 else ())
            if (settings := _search(self.evaluator, turnings[0], (k,)).settings) is not None
        ]
        # In one batch with what is evaluated of them later.
        self.evaluator.evaluate(np.concatenate([spread, np.stack(turnings), *alone]))
        asked = self.evaluator.evaluate(np.concatenate([spread, np.stack(turnings)])).margins
        changed = changed_margins(asked)
        if not changed.any():
            return
        installed = self._trial(turnings[0], changed)
        # Lower bounds among them, as of what is proposed in the end.
        most = max(installed.expected[0], exceeded_count(installed.checks))
        for k, turns in enumerate(turnings):
            if tell:
                tell(k, len(turnings))
            yield self._trial(turns, changed)
            single = [] if turns.any() or len(ways) < 2 else [(way,) for way in ways]
            for free in [*single, *([ways] if ways else [])]:
                search = CorrectionSearch(self.evaluator, turns, free, changed, most, trucks)
                for amounts in corrections(search):
                    yield self._trial(amounts, changed)

    def glance(self) -> Iterator[_CorrectionCandidate]:
        """Yield the line as installed, and the best of a few trials that a workshop can set.

        For a first result soon: nothing where no move changes anything.
        """
        movable = self.evaluator.movable
        turnings = np.stack(list(_turnings(self.response, movable)))
        search = _search(self.evaluator, turnings[0], _ways(movable))
        few = search.amounts(spread_positions(len(search.free))[:FIRST_ANSWER_TRIALS])
        steps = np.array([a.step for a in movable])
        whole = np.where(steps > 0, steps, 1.0)
        few = np.where(steps > 0, np.trunc(few / whole) * whole, few)  # towards 0: within the range
        trials = np.concatenate([few, turnings[1:]])
        changed = changed_margins(self.evaluator.evaluate(trials).margins)
        if changed.any():
            yield self._trial(turnings[0], changed)
            most = int(self.evaluator.evaluate(turnings[:1]).exceeded[0])
            best = replace(search, changed=changed, most=most).exhausted(trials)
            once = {tuple(amounts.tolist()): amounts for amounts in best}.values()
            tried = (self._trial(amounts, changed) for amounts in once)
            yield min(tried, key=lambda t: t.expected_gain)

    def _trial(self, amounts: FloatArray, changed: BoolArray) -> _CorrectionCandidate:
        """Return the trial that moves things by these amounts."""
        found = self.evaluator.evaluate(amounts[None])
        return _CorrectionCandidate(
            movable=self.evaluator.movable,
            amounts=tuple((amounts + 0.0).tolist()),  # no negative zeros
            installed=self.installed,
            changed=changed,
            expected=(int(found.exceeded[0]), int(found.warned[0])),
            expected_margin=float(found.expected_margin[0, changed].min()),
        )


def _search(
    evaluator: SettingEvaluator, turns: FloatArray, free: tuple[int, ...]
) -> CorrectionSearch:
    """Return a search of which it is not known yet what moving changes."""
    return CorrectionSearch(evaluator, turns, free, np.array([], dtype=bool))


def _ways(movable: tuple[PermittedAdjustment, ...]) -> tuple[int, ...]:
    """Return which things move steplessly, or in small steps; the others are choices."""
    return tuple(
        k for k, a in enumerate(movable) if not ADJUSTMENTS[a.adjustment_key].extremes_only
    )


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
