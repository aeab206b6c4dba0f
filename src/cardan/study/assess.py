"""Assess an application: every quantity, in every state, against every limit."""

from collections.abc import Container, Iterator
from dataclasses import dataclass

import numpy as np

from cardan.base.arrays import BoolArray, FloatArray
from cardan.base.units import mm
from cardan.base.verdict import Check, Grade, Limit, worst
from cardan.demand.states import demand, resolve
from cardan.demand.suspension import rate_mismatch
from cardan.model.application import Application
from cardan.model.vehicle import Spring, Suspension
from cardan.quantity.held import HELD
from cardan.quantity.response import Response, respond

MISMATCH = 0.005
"""Share by which a stated rate may differ from its table before it is worth a word."""


@dataclass(frozen=True, kw_only=True)
class Assessment:
    """The answer to an application: what each line does, and what the limits say of it."""

    application: Application
    responses: tuple[Response, ...]
    checks: tuple[Check, ...]

    @property
    def verdict(self) -> Grade:
        """The worst of all checks."""
        return worst([c.grade for c in self.checks])

    @property
    def mismatches(self) -> tuple["RateMismatch", ...]:
        """Springs whose drawing states a rate that is not that of its own table."""
        return tuple(m for s in _suspensions(self.application) for m in _mismatches(s.spring))

    @property
    def notes(self) -> tuple[str, ...]:
        """What a reader of the application should know: where it contradicts itself."""
        return tuple(str(m) for m in self.mismatches)

    def unasked(self) -> tuple[str, ...]:
        """Limits on what some line has, but that no number answered: something is not given."""
        answered = {c.quantity for c in self.checks}
        asking = dict.fromkeys(m.quantity for m in self.application.limits)
        return tuple(
            q for q in asking if q not in answered and any(HELD[q].parts(r) for r in self.responses)
        )


def assess(application: Application) -> Assessment:
    """Hold every line of an application, in every state, against every limit.

    Raises
    ------
    DesignError
        If the chain cannot exist in a state (a joint locks, a spring has no load).
    """
    responses = tuple(
        respond(application, demand(resolve(application, installed)))
        for installed in application.lines
    )
    checks = tuple(c for r in responses for c in checks_of(r))
    return Assessment(application=application, responses=responses, checks=checks)


def _suspensions(application: Application) -> tuple[Suspension, ...]:
    """Return the suspensions of all lines, each once."""
    every = (application.suspension, *(i.suspension for i in application.lines))
    return tuple(dict.fromkeys(s for s in every if s))


@dataclass(frozen=True, kw_only=True)
class RateMismatch:
    """A spring's stated rate, N/m, and how far it is from its table's, as a share of that."""

    stated: float
    apart: float

    @property
    def of_table(self) -> float:
        """The table's own rate, N/m."""
        return self.stated / (1 + self.apart)

    def __str__(self) -> str:
        """Return the mismatch as a sentence without its end."""
        return (
            f"a spring's stated rate of {self.stated * mm:.4g} N/mm is {100 * self.apart:+.1f} % "
            f"from the {self.of_table * mm:.4g} N/mm of its own table, which counts"
        )


def _mismatches(spring: Spring) -> Iterator[RateMismatch]:
    """Yield where a drawing's stated rate is not that of its own table."""
    for stated, apart in zip(spring.stated_rates, rate_mismatch(spring), strict=True):
        if abs(apart) > MISMATCH:
            yield RateMismatch(stated=stated, apart=float(apart))


@dataclass(frozen=True, kw_only=True)
class Asked:
    """One limit asking about one quantity of a line.

    Values are (..., states, parts), nan where the limit does not ask.
    """

    limit: Limit
    parts: tuple[str, ...]
    values: FloatArray


def asked(response: Response, *, quantities: Container[str] = HELD) -> Iterator[Asked]:
    """Yield every limit of the application, and of the parts, that asks about a line."""
    limits = response.application.limits
    for quantity, held in HELD.items():
        if quantity not in quantities:
            continue
        asking = [limit for limit in limits if limit.quantity == quantity]
        own = held.own(response, quantity) if held.rating else ()
        if not asking and not any(own):
            continue
        parts, values = held.parts(response), held.of(response)
        rated = np.array([limit is not None for limit in own]) if own else False
        for limit in asking:
            asks = _asks(limit, response) & ~(held.own_first & np.asarray(rated))
            yield Asked(limit=limit, parts=parts, values=np.where(asks, values, np.nan))
        for k, limit in enumerate(own):
            if limit is not None:
                alone = np.arange(len(parts)) == k
                yield Asked(limit=limit, parts=parts, values=np.where(alone, values, np.nan))


def _asks(limit: Limit, response: Response) -> BoolArray:
    """Return where a limit that only asks above some joint angle does so, (..., states, 1)."""
    if limit.above_angle is None:
        return np.array([[True]])
    return response.angles.max(axis=-1, keepdims=True) > limit.above_angle


def check(response: Response, question: Asked, state: int, part: int) -> Check | None:
    """Return the check of one state and part; None where the limit does not ask."""
    value = question.values[state, part]
    if np.isnan(value):
        return None
    return Check(
        quantity=question.limit.quantity,
        line=response.line.name,
        state=response.demand.states[state],
        part=question.parts[part],
        value=float(value),
        limit=question.limit,
    )


def checks_of(response: Response) -> Iterator[Check]:
    """Yield a check for each limit, state and part of a line that has a number."""
    for question in asked(response):
        for state, part in np.ndindex(*question.values.shape):
            found = check(response, question, state, part)
            if found:
                yield found
