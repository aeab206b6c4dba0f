"""Every margin of a line at once, as one array: what a search and a scatter look at."""

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


def margins(response: Response, *, to: Bound) -> FloatArray:
    """Return every margin of a line, (..., limits x states x parts), cut where it is plenty.

    To the maximum, what can only warn has plenty.
    """
    return _margins(response, tuple(asked(response)), to=to)


def both(response: Response) -> dict[Bound, FloatArray]:
    """Return every margin of a line to either bound, asked once."""
    questions = tuple(asked(response))
    return {bound: _margins(response, questions, to=bound) for bound in BOUNDS}


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


def limits(response: Response) -> tuple[Limit, ...]:
    """Return which limit each margin of a line is to."""
    return tuple(
        q.limit for q in asked(response) for _ in range(q.values.shape[-2] * q.values.shape[-1])
    )
