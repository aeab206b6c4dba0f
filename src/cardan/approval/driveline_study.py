"""The driveline in its states: every quantity of every line against every limit."""

from collections.abc import Callable, Container, Iterable, Iterator
from functools import cached_property, partial

import numpy as np

from cardan.application.limit_profiles import limits_to_evaluate
from cardan.approval.study import DRIVELINE_STUDY_NAME, StudyRegistration, StudyResult
from cardan.checks.line_response import LineResponse, compute_line_response
from cardan.checks.quantities.declaration import (
    RATING_INPUTS,
    Quantity,
    joint_indices_of_kind,
)
from cardan.checks.quantities.registry import LINE_QUANTITIES
from cardan.core.arrays import (
    ArrayLike,
    BoolArray,
    FloatArray,
    IntArray,
    broadcastable_axis_indices,
)
from cardan.core.labels import EvaluationCondition, OrderCrossing, Part
from cardan.core.lazy_dataclass import dataclass
from cardan.core.status import ProgressCallback, ignore_status
from cardan.core.verdict import (
    CHECK_GRADES,
    MARGIN_TOLERANCE,
    Check,
    Limit,
    UnevaluatedCheck,
)
from cardan.model.application import STATE_KINDS, Application
from cardan.physics.vehicle.operating_points import LineOperatingPoints
from cardan.physics.vehicle.state_demand import line_state_demand, resolve_line_references


@dataclass(frozen=True)
class DrivelineStudy:
    """The study every approval begins with."""

    name: str = DRIVELINE_STUDY_NAME

    def applies_to(self, application: Application) -> bool:
        """Whether the application is about this: always."""
        del application
        return True

    def missing_inputs(self, application: Application) -> tuple[str, ...]:
        """Return nothing: what is not given leaves limits not evaluated, one by one."""
        del application
        return ()

    def run(
        self, application: Application, tell: ProgressCallback = ignore_status
    ) -> StudyResult[tuple[LineResponse, ...]]:
        """Hold every line of an application, in every state, against every limit.

        Raises
        ------
        DesignError
            If the chain cannot exist in a state (a joint locks, a spring has no load).
        """
        tell(DRIVELINE_STUDY_NAME, 0, len(application.lines))
        responses = tuple(
            compute_line_response(
                application, line_state_demand(resolve_line_references(application, installed))
            )
            for installed in application.lines
        )
        questions = [(r, q) for r in responses for q in evaluate_limits(r)]
        return StudyResult(
            study=DRIVELINE_STUDY_NAME,
            answer=responses,
            checks=tuple(c for r, q in questions for c in _answers(r, q)),
            unevaluated=tuple(u for r, q in questions for u in _silence(r, q)),
        )


@dataclass(frozen=True, kw_only=True)
class EvaluatedLimit:
    """One limit on one quantity of a line, with the values it applies to.

    `asks` is where it applies, and `values` are evaluated, both (..., states, parts): nan
    where it does not apply, or is not known. `may_apply` (states, parts) is where it would apply
    at other angles, speeds and torques: it looks at the kinds of states and joints alone.
    Values are the worst of all operating points where the limit applies at those, `worst_points`
    says at which, and `own_point_values` are those at the state's own torque and speed. One that is
    required of kinds of state that are not there applies to the first, and is not evaluated. Where
    `validity_margin` (..., states, parts) is negative values are lower bounds; elsewhere it is
    infinite. `prove` returns what is certainly free of a threshold where many designs are not
    solved in full (`Quantity.unproved_margin`).
    """

    limit: Limit
    parts: tuple[Part, ...]
    asks: BoolArray
    may_apply: BoolArray
    values: FloatArray
    own_point_values: FloatArray
    lacks_rating: BoolArray
    validity_margin: FloatArray
    worst_points: LineOperatingPoints | None = None
    prove: Callable[[ArrayLike], FloatArray | None] | None = None

    @cached_property
    def unproved_margin(self) -> FloatArray:
        """Negative where a value that is not solved may exceed all others and the limit.

        (..., states, parts), elsewhere infinite. A design that fails anyway, or whose values are
        lower bounds, needs no proof.
        """
        none = np.full((1,) * self.values.ndim, np.inf)
        bounds = [b for b in (self.limit.normal, self.limit.maximum) if b is not None]
        if self.prove is None or not bounds:
            return none
        decided = self.validity_margin < -MARGIN_TOLERANCE
        if self.limit.maximum is not None:
            decided = decided | (self.limit.margin(self.values, to="maximum") < -MARGIN_TOLERANCE)
        known = ~np.isnan(self.values)
        needed = known & ~decided.any(axis=(-2, -1), keepdims=True)
        if not needed.any():
            return none
        largest = np.where(known, self.values, 0.0).max(axis=(-2, -1), keepdims=True)
        margin = self.prove(np.maximum(largest, min(bounds)))
        if margin is None:
            return none
        return np.where(needed & (margin < -MARGIN_TOLERANCE), margin, np.inf)

    @property
    def bound_margin(self) -> FloatArray:
        """The smaller of both margins: negative where values are lower bounds."""
        return np.minimum(self.validity_margin, self.unproved_margin)

    def grades_and_margins(self) -> tuple[IntArray, FloatArray]:
        """Return `grades` and margins of its values, as their checks have them."""
        return self.limit.grades_and_margins(self.values, validity_margin=self.bound_margin)

    def grades(self) -> IntArray:
        """Return the places in `CHECK_GRADES` of its values, (..., states, parts)."""
        return self.limit.grades(self.values, validity_margin=self.bound_margin)


def evaluate_limits(
    response: LineResponse, *, quantities: Container[str] = LINE_QUANTITIES
) -> Iterator[EvaluatedLimit]:
    """Yield every limit of the application, of every profile and of the parts, that applies."""
    limits = limits_to_evaluate(response.application)
    for key, quantity in LINE_QUANTITIES.items():
        if key not in quantities:
            continue
        asking = [limit for limit in limits if limit.quantity == key]
        own = quantity.rated_limits(response)
        if not asking and not any(own):
            continue
        assert quantity.parts is not None  # of those that a line answers
        parts = quantity.parts(response)
        if not parts:
            continue
        known, validity_margin, is_only_bound = _known_with_lower_bounds(quantity, response)
        # A profile's angles and speeds are those of crosses: another joint has its own, or none.
        other_kind, rated = quantity.needs_own_rating(response), quantity.has_own_rating(response)
        own_first = rated & (quantity.rating_replaces_profile | other_kind)
        lacks_rating = np.broadcast_to(other_kind & ~rated, len(parts))
        kinds = _of_kinds(quantity.states, response) & quantity.means_something_of(response)
        turning = ~_idle(quantity, response)
        each: list[tuple[Limit, BoolArray, BoolArray]] = [
            (
                limit,
                kinds & _of_kinds(limit.states, response) & ~own_first,
                turning & _bent(limit, response),
            )
            for limit in asking
        ] + [
            (limit, kinds & (np.arange(len(parts)) == k), turning)
            for k, limit in enumerate(own)
            if limit is not None
        ]
        spread = _spread(quantity, response, [limit for limit, _, _ in each], like=known)
        for limit, may, does in each:
            values, spots = _worst(limit, known, spread)
            holds = validity_margin
            if quantity.worst_beyond is not None and (holds < -MARGIN_TOLERANCE).any():
                same = limit.grades(quantity.worst_beyond(response)) == limit.grades(values)
                holds = np.where(same, np.inf, holds)
            if limit.required and is_only_bound.any():  # a bound that does not fail proves nothing
                fails = limit.grades(values) == CHECK_GRADES.index("fail")
                values = np.where(is_only_bound & ~fails, np.nan, values)
            spots = quantity.find_worst_points(response) if quantity.find_worst_points else spots
            there = True
            if limit.required and not _of_kinds(limit.states, response).any():
                may, does, there = np.arange(len(kinds))[:, None] == 0, True, False
            may = np.broadcast_to(may, values.shape[-2:])
            asks = np.broadcast_to(may & does, values.shape)
            if limit.if_given:  # then what is not given needs no evaluation either
                given = ~np.isnan(values)
                asks = asks & given
                may = may & given.any(axis=tuple(range(given.ndim - 2)))
            answerable = asks & there & ~lacks_rating
            answers, at_own = (np.where(answerable, v, np.nan) for v in (values, known))
            yield EvaluatedLimit(
                limit=limit,
                parts=parts,
                asks=asks,
                may_apply=may,
                values=answers,
                own_point_values=at_own,
                lacks_rating=lacks_rating,
                validity_margin=np.broadcast_to(
                    np.where(np.isnan(answers), np.inf, holds), answers.shape
                ),
                prove=quantity.unproved_margin and partial(quantity.unproved_margin, response),
                worst_points=spots,
            )


def _spread(
    quantity: Quantity, response: LineResponse, limits: list[Limit], *, like: FloatArray
) -> tuple[FloatArray, LineOperatingPoints] | None:
    """Return values under limits at operating points, (P, ..., states, parts), and those.

    With variants only where values `like` have them; None if no limit applies there, or
    there are none.
    """
    asking = quantity.at_all_points and any(limit.points == "all" for limit in limits)
    if not asking or response.operating_envelope is None:
        return None
    spots, values = (
        response.operating_envelope.points,
        quantity.values(response.operating_envelope.response),
    )
    if like.ndim == 2:
        spots, values = spots.first_variant, values[:, 0]
    return np.abs(values) if quantity.signed else values, spots


def _worst(
    limit: Limit, own: FloatArray, spread: tuple[FloatArray, LineOperatingPoints] | None
) -> tuple[FloatArray, LineOperatingPoints | None]:
    """Return the worst values (..., states, parts) and where they are, if not the state's own."""
    if spread is None or limit.points == "own":
        return own, None
    values, spots = spread
    margin = limit.margin(values, to="normal")
    best = np.where(np.isnan(margin), np.inf, margin).argmin(axis=0)
    here = (best, *broadcastable_axis_indices(best.shape))
    there, left = values[here], margin[here]
    worse = left < limit.margin(own, to="normal") - MARGIN_TOLERANCE
    if not worse.any():
        return own, None
    return np.where(worse, there, own), spots.points_of_parts(np.where(worse, best, -1))


def _known_with_lower_bounds(
    quantity: Quantity, response: LineResponse
) -> tuple[FloatArray, FloatArray, BoolArray]:
    """Return the values under limits, their validity margin, and where it is a bound alone.

    Beyond the margin it is a lower bound, of a value that is known or not.
    """
    known = _known(quantity, response)
    margin = np.inf if quantity.validity_margin is None else quantity.validity_margin(response)
    beyond = np.asarray(margin) < -MARGIN_TOLERANCE
    if not beyond.any():
        return known, np.full((1, 1), np.inf), beyond
    least = _known(quantity, response, lower_bounds=True)
    is_only_bound = beyond & np.isnan(known) & ~np.isnan(least)
    return np.where(beyond, least, known), np.where(beyond, margin, np.inf), is_only_bound


def _known(quantity: Quantity, response: LineResponse, *, lower_bounds: bool = False) -> FloatArray:
    """Return the values under limits: sizes; nan for what stands idle in every state."""
    values = quantity.values(response, lower_bounds=lower_bounds)
    values = np.abs(values) if quantity.signed else values
    for need in quantity.requirements:
        if need.is_idle is not None:
            values = np.where(need.is_idle(response).all(axis=-2, keepdims=True), np.nan, values)
    return values


def _of_kinds(kinds: frozenset[str] | None, response: LineResponse) -> BoolArray:
    """Return which states are of some kinds, None is all of them, (states, 1)."""
    return np.array([[kinds is None or kind in kinds] for kind in response.state_kinds])


def _idle(quantity: Quantity, response: LineResponse) -> BoolArray:
    """Return where the application says that nothing turns or carries, (..., states, 1).

    Nowhere if that is so in every state: then nothing is known.
    """
    found = np.zeros((1, 1), dtype=bool)
    for need in quantity.requirements:
        if need.is_idle is not None:
            idle = need.is_idle(response)
            found = found | (idle & ~idle.all(axis=-2, keepdims=True))
    return found


def _bent(limit: Limit, response: LineResponse) -> BoolArray:
    """Return where the angle of a cross is above that of a limit, (..., states, 1).

    Other joints keep the speed and excite nothing, whatever their angle.
    """
    if limit.above_angle is None:
        return np.ones((1, 1), dtype=bool)
    crosses = response.joint_angles[..., joint_indices_of_kind(response, "cross")]
    return crosses.max(axis=-1, keepdims=True, initial=0.0) > limit.above_angle


def check_limit_at_part(
    response: LineResponse,
    question: EvaluatedLimit,
    state: int,
    part: int,
    *,
    mode: OrderCrossing | None = None,
) -> Check | None:
    """Return the check of one state and part; None if the limit is not evaluated there.

    `mode` is what a line's turning meets there, if evaluated.
    """
    value = question.values[state, part]
    if np.isnan(value):
        return None
    return Check(
        quantity=question.limit.quantity,
        line=response.line.name,
        when=EvaluationCondition("state", response.demand.states[state]),
        part=question.parts[part],
        value=float(value),
        limit=question.limit,
        validity_margin=float(question.bound_margin[state, part]),
        point=question.worst_points.operating_point((state, part))
        if question.worst_points
        else None,
        mode=mode,
    )


def line_checks(
    response: LineResponse, limits: Iterable[EvaluatedLimit] | None = None
) -> Iterator[Check]:
    """Yield a check for each limit, state and part of a line that has a number.

    Its `limits` may be evaluated already.
    """
    for question in evaluate_limits(response) if limits is None else limits:
        yield from _answers(response, question)


def unevaluated_line_checks(
    response: LineResponse, limits: Iterable[EvaluatedLimit] | None = None
) -> Iterator[UnevaluatedCheck]:
    """Yield each limit, state and part of a line that got no number, with what it needs.

    Its `limits` may be evaluated already.
    """
    for question in evaluate_limits(response) if limits is None else limits:
        yield from _silence(response, question)


def _answers(response: LineResponse, question: EvaluatedLimit) -> Iterator[Check]:
    shaken = LINE_QUANTITIES[question.limit.quantity].has_resonance
    modes = (
        response.mount_loads.order_crossings(question.worst_points)
        if shaken and question.worst_points
        else None
    )
    for state, part in np.argwhere(~np.isnan(question.values)).tolist():
        mode = modes[state][part] if modes else None
        found = check_limit_at_part(response, question, state, part, mode=mode)
        if found:
            yield found


def _silence(response: LineResponse, question: EvaluatedLimit) -> Iterator[UnevaluatedCheck]:
    for state, part in np.argwhere(question.asks & np.isnan(question.values)).tolist():
        yield UnevaluatedCheck(
            limit=question.limit,
            line=response.line.name,
            when=EvaluationCondition("state", response.demand.states[state]),
            part=question.parts[part],
            missing_inputs=tuple(missing_inputs_of(response, question, state, part)),
        )


def missing_inputs_of(
    response: LineResponse, question: EvaluatedLimit, state: int, part: int
) -> Iterator[str]:
    """Yield what an application would have to give for an answer."""
    wanted = question.limit.states
    if wanted is not None and not _of_kinds(wanted, response).any():
        yield f"states: {' / '.join(k for k in STATE_KINDS if k in wanted)}"
    if question.lacks_rating[part]:
        yield RATING_INPUTS[LINE_QUANTITIES[question.limit.quantity].rating_of_other_kinds]
    shape = question.values.shape
    for need in LINE_QUANTITIES[question.limit.quantity].requirements:
        met = np.broadcast_to(need.is_met(response), shape)[state, part]
        if not met or (need.is_idle is not None and need.is_idle(response).all()):
            yield need.missing_input(response, state)


REGISTRATION = StudyRegistration(
    name=DRIVELINE_STUDY_NAME, study=DrivelineStudy(), runs_by_default=lambda _: True
)
