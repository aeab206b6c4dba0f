"""The driveline in its states: every quantity of every line against every limit."""

from collections.abc import Container, Iterator

import numpy as np

from cardan.base.arrays import BoolArray, FloatArray, steps
from cardan.base.frozen import dataclass
from cardan.base.part import Mode, Occasion, Part
from cardan.base.verdict import EQUAL, Check, Limit, Unanswered
from cardan.demand.states import demand, resolve
from cardan.model.application import STATE_KINDS, Application
from cardan.quantity.declared import Quantity
from cardan.quantity.points import Spots
from cardan.quantity.quantities import ANSWERED
from cardan.quantity.response import Response, respond
from cardan.study.finding import DRIVELINE, Finding, Tell, silent


@dataclass(frozen=True)
class DrivelineStudy:
    """The study every approval begins with."""

    name: str = DRIVELINE

    def concerns(self, application: Application) -> bool:
        """Whether the application is about this: always."""
        del application
        return True

    def missing(self, application: Application) -> tuple[str, ...]:
        """Return nothing: what is not given leaves limits unanswered, one by one."""
        del application
        return ()

    def run(self, application: Application, tell: Tell = silent) -> Finding[tuple[Response, ...]]:
        """Hold every line of an application, in every state, against every limit.

        Raises
        ------
        DesignError
            If the chain cannot exist in a state (a joint locks, a spring has no load).
        """
        tell(DRIVELINE, 0, len(application.lines))
        responses = tuple(
            respond(application, demand(resolve(application, installed)))
            for installed in application.lines
        )
        questions = [(r, q) for r in responses for q in asked(r)]
        return Finding(
            study=DRIVELINE,
            answer=responses,
            checks=tuple(c for r, q in questions for c in _answers(r, q)),
            unanswered=tuple(u for r, q in questions for u in _silence(r, q)),
        )


@dataclass(frozen=True, kw_only=True)
class Asked:
    """One limit asking about one quantity of a line.

    `asks` tells where it does, and `values` are its answers, both (..., states, parts): nan
    where it does not ask, or nothing answers. `may` (states, parts) tells where it would ask
    at other angles, speeds and torques: it looks at the kinds of states and joints alone.
    Values are the worst of all operating points where the limit asks at those, `spots` says
    at which, and `own` are those at the state's own torque and speed. One that is required of
    kinds of state that are not there asks the first, and has no answer.
    """

    limit: Limit
    parts: tuple[Part, ...]
    asks: BoolArray
    may: BoolArray
    values: FloatArray
    own: FloatArray
    spots: Spots | None = None


def asked(response: Response, *, quantities: Container[str] = ANSWERED) -> Iterator[Asked]:
    """Yield every limit of the application, and of the parts, that asks about a line."""
    limits = response.application.limits
    for key, quantity in ANSWERED.items():
        if key not in quantities:
            continue
        asking = [limit for limit in limits if limit.quantity == key]
        own = quantity.own(response)
        if not asking and not any(own):
            continue
        assert quantity.parts is not None  # of those that a line answers
        parts, known = quantity.parts(response), _known(quantity, response)
        rated = np.array([limit is not None for limit in own]) if own else np.array([False])
        # A profile's angles are those of crosses: another joint with a cap of its own has that.
        own_first = quantity.own_first | (np.array(response.line.crosses) == 0 if own else False)
        kinds = _of_kinds(quantity.states, response)
        turning = ~_idle(quantity, response)
        each: list[tuple[Limit, BoolArray, BoolArray]] = [
            (
                limit,
                kinds & _of_kinds(limit.states, response) & ~(own_first & rated),
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
            spots = quantity.sought(response) if quantity.sought else spots
            there = True
            if limit.required and not _of_kinds(limit.states, response).any():
                may, does, there = np.arange(len(kinds))[:, None] == 0, True, False
            may = np.broadcast_to(may, values.shape[-2:])
            asks = np.broadcast_to(may & does, values.shape)
            answers, at_own = (np.where(asks & there, v, np.nan) for v in (values, known))
            yield Asked(
                limit=limit, parts=parts, asks=asks, may=may, values=answers, own=at_own,
                spots=spots,
            )  # fmt: skip


def _spread(
    quantity: Quantity, response: Response, limits: list[Limit], *, like: FloatArray
) -> tuple[FloatArray, Spots] | None:
    """Return what limits ask about at operating points, (P, ..., states, parts), and those.

    With variants only where values `like` have them; None where no limit asks there, or
    there are none.
    """
    asking = quantity.at_points and any(limit.points == "all" for limit in limits)
    if not asking or response.spread is None:
        return None
    spots, values = response.spread.spots, quantity.values(response.spread.response)
    if like.ndim == 2:
        spots, values = spots.first_variant, values[:, 0]
    return np.abs(values) if quantity.signed else values, spots


def _worst(
    limit: Limit, own: FloatArray, spread: tuple[FloatArray, Spots] | None
) -> tuple[FloatArray, Spots | None]:
    """Return the worst values (..., states, parts) and where they are, if not the state's own."""
    if spread is None or limit.points == "own":
        return own, None
    values, spots = spread
    margin = limit.margin(values, to="normal")
    best = np.where(np.isnan(margin), np.inf, margin).argmin(axis=0)
    here = (best, *steps(best.shape))
    there, left = values[here], margin[here]
    worse = left < limit.margin(own, to="normal") - EQUAL
    if not worse.any():
        return own, None
    return np.where(worse, there, own), spots.of_parts(np.where(worse, best, -1))


def _known(quantity: Quantity, response: Response) -> FloatArray:
    """Return what limits ask about: sizes; of what stands idle in every state nobody knows."""
    values = quantity.values(response)
    values = np.abs(values) if quantity.signed else values
    for need in quantity.needs:
        if need.idle is not None:
            values = np.where(need.idle(response).all(axis=-2, keepdims=True), np.nan, values)
    return values


def _of_kinds(kinds: frozenset[str] | None, response: Response) -> BoolArray:
    """Return which states are of some kinds, None is all of them, (states, 1)."""
    return np.array([[kinds is None or kind in kinds] for kind in response.kinds])


def _idle(quantity: Quantity, response: Response) -> BoolArray:
    """Return where the application says that nothing turns or carries, (..., states, 1).

    Nowhere if that is so in every state: then nobody has answered.
    """
    found = np.zeros((1, 1), dtype=bool)
    for need in quantity.needs:
        if need.idle is not None:
            idle = need.idle(response)
            found = found | (idle & ~idle.all(axis=-2, keepdims=True))
    return found


def _bent(limit: Limit, response: Response) -> BoolArray:
    """Return where a joint angle is above that of a limit, (..., states, 1)."""
    if limit.above_angle is None:
        return np.ones((1, 1), dtype=bool)
    return response.angles.max(axis=-1, keepdims=True) > limit.above_angle


def check(
    response: Response, question: Asked, state: int, part: int, *, mode: Mode | None = None
) -> Check | None:
    """Return the check of one state and part; None where the limit has no answer there.

    `mode` is what a line's turning meets there, where somebody has looked.
    """
    value = question.values[state, part]
    if np.isnan(value):
        return None
    return Check(
        quantity=question.limit.quantity,
        line=response.line.name,
        when=Occasion("state", response.demand.states[state]),
        part=question.parts[part],
        value=float(value),
        limit=question.limit,
        point=question.spots.named((state, part)) if question.spots else None,
        mode=mode,
    )


def checks_of(response: Response) -> Iterator[Check]:
    """Yield a check for each limit, state and part of a line that has a number."""
    for question in asked(response):
        yield from _answers(response, question)


def unanswered_of(response: Response) -> Iterator[Unanswered]:
    """Yield each limit, state and part of a line that got no number, with what it needs."""
    for question in asked(response):
        yield from _silence(response, question)


def _answers(response: Response, question: Asked) -> Iterator[Check]:
    shaken = ANSWERED[question.limit.quantity].shaken
    modes = response.met(question.spots) if shaken and question.spots else None
    for state, part in np.argwhere(~np.isnan(question.values)).tolist():
        mode = modes[state][part] if modes else None
        found = check(response, question, state, part, mode=mode)
        if found:
            yield found


def _silence(response: Response, question: Asked) -> Iterator[Unanswered]:
    for state, part in np.argwhere(question.asks & np.isnan(question.values)).tolist():
        yield Unanswered(
            limit=question.limit,
            line=response.line.name,
            when=Occasion("state", response.demand.states[state]),
            part=question.parts[part],
            needs=tuple(needs_of(response, question, state, part)),
        )


def needs_of(response: Response, question: Asked, state: int, part: int) -> Iterator[str]:
    """Yield what an application would have to give for an answer."""
    wanted = question.limit.states
    if wanted is not None and not _of_kinds(wanted, response).any():
        yield f"states: {' / '.join(k for k in STATE_KINDS if k in wanted)}"
    shape = question.values.shape
    for need in ANSWERED[question.limit.quantity].needs:
        met = np.broadcast_to(need.met(response), shape)[state, part]
        if not met or (need.idle is not None and need.idle(response).all()):
            yield need.lacking(response, state)
