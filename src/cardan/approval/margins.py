"""Every margin of lines at once, as one array: what a search and a scatter look at."""

from typing import Literal, TypeAlias

import numpy as np

from cardan.approval.driveline_study import EvaluatedLimit, evaluate_limits
from cardan.checks.line_response import LineResponse
from cardan.core.arrays import FloatArray
from cardan.core.verdict import Limit

LimitBoundName: TypeAlias = Literal["normal", "maximum"]
LIMIT_BOUND_NAMES: tuple[LimitBoundName, ...] = ("normal", "maximum")

MARGIN_CAP = 10.0
"""Margins are cut here."""


def margins(*responses: LineResponse, to: LimitBoundName) -> FloatArray:
    """Return every margin of lines, (..., limits x states x parts), cut where it is plenty.

    To the maximum, what can only warn has plenty.
    """
    each = [margins_of_limits(r, tuple(evaluate_limits(r)), to=to) for r in responses]
    return np.concatenate(each, axis=-1)


def margins_to_both_bounds(*responses: LineResponse) -> dict[LimitBoundName, FloatArray]:
    """Return every margin of lines to either bound, evaluated once."""
    questions = [(r, tuple(evaluate_limits(r))) for r in responses]
    return {
        bound: np.concatenate([margins_of_limits(r, q, to=bound) for r, q in questions], axis=-1)
        for bound in LIMIT_BOUND_NAMES
    }


def margins_of_limits(
    response: LineResponse, questions: tuple[EvaluatedLimit, ...], *, to: LimitBoundName
) -> FloatArray:
    """Return every margin of a line from its evaluated limits, as `margins`."""
    cases = response.layout.points.shape[:-3]
    each = [
        np.full_like(q.values, MARGIN_CAP)
        if to == "maximum" and q.limit.maximum is None
        else q.limit.margin(q.values, to=to)
        if to == "maximum"
        else np.minimum(q.limit.margin(q.values, to=to), q.validity_margin)
        for q in questions
    ]
    full = [np.broadcast_to(m, (*cases, *m.shape[-2:])).reshape(*cases, -1) for m in each]
    # A limit that does not apply is as good as one satisfied many times over.
    return np.nan_to_num(np.minimum(np.concatenate(full, axis=-1), MARGIN_CAP), nan=MARGIN_CAP)


def limit_of_each_margin(*responses: LineResponse) -> tuple[Limit, ...]:
    """Return which limit each margin of lines is to."""
    return tuple(
        q.limit
        for response in responses
        for q in evaluate_limits(response)
        for _ in range(q.values.shape[-2] * q.values.shape[-1])
    )
