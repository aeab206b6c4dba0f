"""Results at operating points, and the points where they are largest."""

from collections.abc import Callable, Sequence
from dataclasses import fields
from typing import Any

import numpy as np

from cardan.checks.operating_envelope import PointRows
from cardan.core.arrays import IntArray, broadcastable_axis_indices
from cardan.core.lazy_dataclass import dataclass
from cardan.physics.vehicle.operating_points import (
    LineOperatingPoints,
)


@dataclass(frozen=True, kw_only=True, eq=False)
class OperatingPointResults(LineOperatingPoints):
    """Points of a line's curves, and what its bearings carry there.

    Attributes
    ----------
    results : (P, ..., S, n-2) or (..., S, n-2) N
        What the bearings carry; only sizes while the worst points are sought.
    """

    results: Any

    def for_bearings(self, which: Sequence[int]) -> "OperatingPointResults":
        """Return the worst points (..., S, n-2) of some bearings alone."""
        count = self.curve_index.shape[-1]
        if list(which) == list(range(count)):
            return self
        kept = np.asarray(which)
        # What bearings carry has the axis of the bearings where their points have it.
        axis = self.curve_index.ndim - 1

        def own(values: Any) -> Any:
            return np.take(values, kept, axis=axis)

        return map_results(own, self)


def map_results(change: Callable[..., Any], *of: OperatingPointResults) -> OperatingPointResults:
    """Return points whose arrays are changed alike from those of others."""
    first, kind = of[0], type(of[0].results)
    return OperatingPointResults(
        curves=first.curves,
        curve_index=change(*(p.curve_index for p in of)),
        speed=change(*(p.speed for p in of)),
        torque=change(*(p.torque for p in of)),
        results=kind(
            **{f.name: change(*(getattr(p.results, f.name) for p in of)) for f in fields(kind)}
        ),
    )


def largest_point(p: OperatingPointResults, force: str) -> OperatingPointResults:
    """Return the point where a force is largest, of each bearing by itself, (..., S, n-2)."""
    return largest_points(p, force, 1)[0]


def largest_points(p: OperatingPointResults, force: str, count: int) -> list[OperatingPointResults]:
    """Return the points where a force is largest, then the next larger ones, by `largest_point`."""
    value = np.nan_to_num(getattr(p.results, force), nan=np.finfo(float).min)
    found: list[OperatingPointResults] = []
    for rank in range(count):
        here = (value.argmax(axis=0), *broadcastable_axis_indices(value.shape[1:]))

        def taken(values: Any, here: tuple[IntArray, ...] = here) -> Any:
            return values[here[: values.ndim]]  # of points, or of their bearings

        found.append(map_results(taken, p))
        if rank + 1 < min(count, len(value)):
            value[here] = -np.inf
    return found


def point_rows(*found: OperatingPointResults) -> PointRows:
    """Return curves and speeds (P, ..., S) of points (..., S, n-2) of each bearing."""
    each = [(np.moveaxis(p.curve_index, -1, 0), np.moveaxis(p.speed, -1, 0)) for p in found]
    curve, speed = (np.concatenate(values) for values in zip(*each, strict=True))
    return curve, speed
