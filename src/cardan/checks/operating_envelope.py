"""Points on a line's curves of torque over speed, and the envelope of its operation.

Each state is evaluated along its curves of torque over speed, in every gear and direction: where
a curve starts, bends and ends. What follows torque, speed and angles alone is worst there.
"""

from dataclasses import replace
from typing import TypeAlias, get_args

import numpy as np

from cardan.core.arrays import FloatArray, IntArray, broadcastable_axis_indices
from cardan.physics.vehicle.operating_points import (
    DriveMode,
    LineOperatingPoints,
    TorqueCurves,
    demand_at_operating_points,
    operating_points_on_curves,
)
from cardan.physics.vehicle.state_demand import (
    LineStateDemand,
)

PointRows: TypeAlias = tuple[IntArray, FloatArray]
"""Which curves points (P, ..., S) are on, and their speeds."""

CHECKED_SHARES_OF_MAX_GEAR_SPEED = (0.7, 0.85, 1.0)
"""Of a gear's highest speed: there its torque falls, and an axle's springs stiffen somewhere."""


def envelope_points(
    demand: LineStateDemand, found: TorqueCurves
) -> tuple[LineOperatingPoints, LineStateDemand] | None:
    """Return the corners of a line's curves, and its demand there; None where it has none.

    Those of most torque each way it is turned, the highest speed of each gear and two
    `CHECKED_SHARES_OF_MAX_GEAR_SPEED` of it: between them torque and speed go straight, and so does
    an axle, but where springs stiffen. Points on the first axis, then variants (one where there are
    none), the states last.
    """
    if not found.gears:
        return None
    # Curves that no variant changes have one axis of one: what follows from them alone is
    # evaluated once, and what a tube's wall makes of it, which no force shows, for each.
    if found.max_speed.ndim == 2:
        found = curves_for_cases(found, (1, *found.max_speed.shape[1:]))
    rows = [row for of in curves_by_direction(found) for row in corner_points(found, of)]
    every = np.arange(len(found.gears)).reshape(-1, *(1,) * (found.max_speed.ndim - 1))
    every = np.broadcast_to(every, found.max_speed.shape)
    shares = (
        CHECKED_SHARES_OF_MAX_GEAR_SPEED
        if demand.static_state.squats.any()
        else CHECKED_SHARES_OF_MAX_GEAR_SPEED[-1:]
    )
    rows += [(every, share * found.max_speed) for share in shares]
    # Many a gear ends where its way does.
    curve, speed = gather_points(found, [without_repeated_points(*gather_points(found, rows))])
    asked = demand_at_operating_points(demand, found, curve=curve, speed=speed)
    # What the engine gives ahead in the gear of the point, wherever the tyres slip.
    free = operating_points_on_curves(
        replace(found, torque_limit=np.full_like(found.torque_limit, np.inf)),
        curve=curve,
        speed=speed,
    )
    asked = replace(asked, engine_torque=np.where(free.is_mode("drive"), free.torque, np.nan))
    points = LineOperatingPoints(
        curves=found, curve_index=curve, speed=asked.speed, torque=asked.torque
    )
    return points, asked


def curves_for_cases(found: TorqueCurves, cases: tuple[int, ...]) -> TorqueCurves:
    """Return curves (C, S) or (C, ..., S) for all cases (..., S) of a line."""

    def wide(values: FloatArray, *corners: int) -> FloatArray:
        lead = values.shape[1 : values.ndim - len(corners)]
        values = values.reshape(len(values), *(1,) * (len(cases) - len(lead)), *values.shape[1:])
        return np.broadcast_to(values, (len(values), *cases, *corners))

    corners = found.speed.shape[-1]
    return TorqueCurves(
        gears=found.gears,
        directions=found.directions,
        speed=wide(found.speed, corners),
        torque=wide(found.torque, corners),
        torque_limit=wide(found.torque_limit),
        max_speed=wide(found.max_speed),
    )


def curves_by_direction(found: TorqueCurves) -> list[IntArray]:
    """Return which curves turn the line each way.

    Overrun and reverse push alike and turn against each other: what shakes first up, then
    sideways shakes the other way round, and rubber that damps both distinguishes these.
    """
    each = [np.flatnonzero([d == way for d in found.directions]) for way in get_args(DriveMode)]
    return [of for of in each if len(of)]


def corner_points(found: TorqueCurves, of: IntArray) -> list[PointRows]:
    """Return the corners of the strongest of curves `of` C, and the end of the quickest."""
    standing = np.where(np.isnan(found.max_speed), -1.0, np.abs(found.torque[..., 0]))
    standing = np.minimum(standing, found.torque_limit)
    reach = np.nan_to_num(found.max_speed, nan=-1.0)
    strong, quick = (of[values[of].argmax(axis=0)] for values in (standing, reach))
    cases = broadcastable_axis_indices(strong.shape)
    bends = found.corner_speeds[:, strong, *cases]
    return [
        (np.broadcast_to(strong, bends.shape), bends),
        (quick[None], reach[quick, *cases][None]),
    ]


def gather_points(found: TorqueCurves, rows: list[PointRows]) -> PointRows:
    """Return points (P, ..., S) with those that a state has first, in no more rows than needed."""
    curve, speed = (np.concatenate(values) for values in zip(*rows, strict=True))
    cases = broadcastable_axis_indices(speed.shape)[1:]
    there = (speed >= 0) & (speed <= found.max_speed[curve, *cases])
    first = np.argsort(~there, axis=0, kind="stable")[: there.sum(axis=0).max(initial=1)]
    return curve[first, *cases], np.where(there, speed, np.nan)[first, *cases]


def without_repeated_points(curve: IntArray, speed: FloatArray) -> PointRows:
    """Return points without those of a case that come again: their speed is nan."""
    same = (curve[:, None] == curve) & (speed[:, None] == speed)
    before = np.tri(len(curve), k=-1, dtype=bool)
    again = (same & before.reshape(*before.shape, *(1,) * (curve.ndim - 1))).any(axis=1)
    return curve, np.where(again, np.nan, speed)


def strongest_curves(
    found: TorqueCurves, of: IntArray, speed: FloatArray
) -> tuple[IntArray, FloatArray]:
    """Return which curves `of` C have most torque at speeds (Q, ..., S), and how much."""
    size = found.select(of).torque_at(speed[:, None])
    strong = np.abs(np.nan_to_num(size)).argmax(axis=1)
    here, *cases = broadcastable_axis_indices(strong.shape)
    return of[strong], size[here, strong, *cases]
