"""Every margin of lines at once, as one array: what a search and a scatter look at."""

from typing import Literal, TypeAlias

import numpy as np

from cardan.base.arrays import FloatArray
from cardan.base.verdict import Limit
from cardan.quantity.response import Response
from cardan.study.driveline import Asked, asked

Bound: TypeAlias = Literal["normal", "maximum"]
BOUNDS: tuple[Bound, ...] = ("normal", "maximum")

PLENTY = 10.0
"""Margins are cut here."""


def margins(*responses: Response, to: Bound) -> FloatArray:
    """Return every margin of lines, (..., limits x states x parts), cut where it is plenty.

    To the maximum, what can only warn has plenty.
    """
    each = [_margins(r, tuple(asked(r)), to=to) for r in responses]
    return np.concatenate(each, axis=-1)


def both(*responses: Response) -> dict[Bound, FloatArray]:
    """Return every margin of lines to either bound, asked once."""
    questions = [(r, tuple(asked(r))) for r in responses]
    return {
        bound: np.concatenate([_margins(r, q, to=bound) for r, q in questions], axis=-1)
        for bound in BOUNDS
    }


def _margins(response: Response, questions: tuple[Asked, ...], *, to: Bound) -> FloatArray:
    cases = response.layout.points.shape[:-3]
    each = [
        np.full_like(q.values, PLENTY)
        if to == "maximum" and q.limit.maximum is None
        else q.limit.margin(q.values, to=to)
        for q in questions
    ]
    full = [np.broadcast_to(m, (*cases, *m.shape[-2:])).reshape(*cases, -1) for m in each]
    # A limit that does not ask is as good as one satisfied many times over.
    return np.nan_to_num(np.minimum(np.concatenate(full, axis=-1), PLENTY), nan=PLENTY)


def limits(*responses: Response) -> tuple[Limit, ...]:
    """Return which limit each margin of lines is to."""
    return tuple(
        q.limit
        for response in responses
        for q in asked(response)
        for _ in range(q.values.shape[-2] * q.values.shape[-1])
    )
