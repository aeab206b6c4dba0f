"""Assess an application: every quantity, in every state, against every limit."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from cardan.base.arrays import FloatArray
from cardan.base.verdict import Check, Grade, Limit, worst
from cardan.demand.states import demand
from cardan.model.application import Application
from cardan.study.response import Held, Response, respond


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

    def unasked(self) -> tuple[str, ...]:
        """Limits of the profile that no number answered: what they ask about is not given."""
        asked = {c.quantity for c in self.checks}
        return tuple(
            dict.fromkeys(m.quantity for m in self.application.limits if m.quantity not in asked)
        )


def assess(application: Application) -> Assessment:
    """Hold every line of an application, in every state, against every limit.

    Raises
    ------
    DesignError
        If the chain cannot exist in a state (a joint locks, a spring has no load).
    """
    responses = tuple(
        respond(application, demand(application, installed)) for installed in application.lines
    )
    checks = tuple(c for r in responses for c in checks_of(r))
    return Assessment(application=application, responses=responses, checks=checks)


@dataclass(frozen=True, kw_only=True)
class Asked:
    """One limit asking about one quantity: values (..., parts), nan where it does not ask."""

    held: Held
    limit: Limit
    values: FloatArray


def asked(response: Response) -> Iterator[Asked]:
    """Yield every limit of the application, and of the parts, that a line has values for."""
    limits = response.application.limits
    largest = response.angles.max(axis=-1, keepdims=True)
    for held in response.held():
        for limit in limits:
            if limit.quantity == held.quantity:
                values = held.values
                if held.own_first:
                    values = np.where([own is not None for own in held.own], np.nan, values)
                if limit.above_angle is not None:
                    values = np.where(largest > limit.above_angle, values, np.nan)
                yield Asked(held=held, limit=limit, values=values)
        for k, own in enumerate(held.own):
            if own is not None:
                alone = np.arange(len(held.parts)) == k
                yield Asked(held=held, limit=own, values=np.where(alone, held.values, np.nan))


def check(response: Response, question: Asked, state: int, part: int) -> Check | None:
    """Return the check of one state and part; None where the limit does not ask."""
    value = question.values[state, part]
    if np.isnan(value):
        return None
    return Check(
        quantity=question.held.quantity,
        line=response.line.name,
        state=response.demand.states[state],
        part=question.held.parts[part],
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
