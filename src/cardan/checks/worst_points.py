"""Where a line is worst on its rubber: a search over its operating points.

Bearings on rubber are evaluated where an order crosses a mode of the line, and around the worst
of these the speed is sought more closely.
"""

from collections.abc import Callable, Mapping
from dataclasses import fields
from typing import Any

import numpy as np

from cardan.checks.candidate_points import (
    REFINED_PEAK_COUNT,
    CandidatePoints,
    ScreenedForces,
    candidate_rows,
    refined_candidates,
)
from cardan.checks.line_on_mounts import LineOnMounts, mounted_line_of, nan_where_no_point
from cardan.checks.operating_envelope import (
    PointRows,
    corner_points,
    curves_by_direction,
    curves_for_cases,
    gather_points,
    strongest_curves,
    without_repeated_points,
)
from cardan.checks.operating_point_results import (
    OperatingPointResults,
    largest_point,
    largest_points,
    point_rows,
)
from cardan.core.arrays import FloatArray, IntArray
from cardan.core.lazy_dataclass import dataclass
from cardan.model.layout import Layout
from cardan.physics.kinematics.joint_chain import rotate_chain
from cardan.physics.loads.centre_bearing import (
    BearingForces,
    joint_forces,
    shaft_end_displacements,
)
from cardan.physics.loads.parametric_instability import (
    line_swing_growth_rate,
    two_mode_growth,
    two_mode_growth_of_line,
)
from cardan.physics.loads.rubber_mount import MountedLine
from cardan.physics.loads.screening import (
    ShaftReachIntoObstacles,
)
from cardan.physics.vehicle.clearance import shaft_obstacle_clearances
from cardan.physics.vehicle.operating_points import (
    LineOperatingPoints,
    TorqueCurves,
    demand_at_operating_points,
    operating_points_on_curves,
)

FORCE_KINDS = ("static", "dynamic", "peak")
"""The forces that are sought where they are largest."""


def worst_bearing_forces(
    mounts: LineOnMounts,
    candidates: CandidatePoints | None,
    screened: OperatingPointResults | None,
) -> dict[str, OperatingPointResults]:
    """Return the point where each of `FORCE_KINDS` is largest on each bearing, (..., S, n-2).

    Nothing where the line has no point, or no bearing. It is sought on the slowest modes of
    the line alone, and without the shafts' inertia, whose share is small where resonance is;
    what is found has all of it.
    """
    if candidates is None:
        return {}
    tried = (
        screened
        if screened
        else mounts.bearing_forces_at_points(candidates.curve_index, candidates.speed)
    )
    # Two means are often alike, and which is larger is for the whole line to say.
    still, next_ = largest_points(tried, "static", 2)
    seeds = still, *(largest_point(tried, name) for name in FORCE_KINDS[1:]), next_
    rows = without_repeated_points(*point_rows(*seeds))
    last = mounts.bearing_forces_at_points(*gather_points(mounts.torque_curves, [rows]))
    return {name: largest_point(last, name) for name in FORCE_KINDS}


def all_bearing_operating_points(
    mounts: LineOnMounts,
    candidates: CandidatePoints | None,
    screened: OperatingPointResults | None,
    worst: Mapping[str, OperatingPointResults],
) -> OperatingPointResults | None:
    """Return all points (P, ..., S) evaluated for the worst on bearings; None without one.

    What is best for one load may be worst with another on top of it.
    """
    if candidates is None or not worst:
        return None
    tried = screened or candidates
    rows = [(tried.curve_index, tried.speed), point_rows(*worst.values())]
    found = mounts.torque_curves
    return mounts.bearing_forces_at_points(
        *gather_points(found, [without_repeated_points(*gather_points(found, rows))])
    )


def bearing_forces_at_loss_factors(
    mounts: LineOnMounts, p: OperatingPointResults, *, assumed: FloatArray
) -> BearingForces:
    """Return what the bearings carry at their points with other loss factors.

    For `assumed` (F, 1), next to the states: (F, S, n-2).
    """
    inputs = mounts.inputs
    curve, speed = (v[:, None] for v in point_rows(p))
    curves_ = curves_for_cases(p.curves, curve.shape[1:])
    asked = demand_at_operating_points(inputs.demand, curves_, curve=curve, speed=speed)
    found = mounts.bearing_forces_at(
        asked, inputs.layout_for(asked), on=mounted_line_of(inputs, assumed=assumed)
    )

    def own(values: Any) -> Any:
        """Return of each bearing what it carries at its own point: (P, F, S, n-2, ...)."""
        return np.stack([values[b, :, :, b] for b in range(len(curve))], axis=2)

    return BearingForces(**{f.name: own(getattr(found, f.name)) for f in fields(BearingForces)})


def worst_bearing_travel(
    mounts: LineOnMounts, candidates: CandidatePoints | None, screened: ScreenedForces | None
) -> OperatingPointResults | None:
    """Return the point where each bearing goes farthest across its rubber, (..., S, n-2) m.

    Another one than that of its `worst` peak where rubber gives one way more than the other.
    None where the line is not on rubber, or has no point.
    """
    if candidates is None or screened is None:
        return None
    found = refined_candidates(mounts, candidates, screened.travel, gives=True)
    seeds = largest_points(found, "peak", 2)
    curve, speed = gather_points(
        mounts.torque_curves, [without_repeated_points(*point_rows(*seeds))]
    )
    return largest_point(mounts.bearing_forces_at_points(curve, speed, gives=True), "peak")


def worst_obstacle_clearance(
    mounts: LineOnMounts, screened: ScreenedForces | None
) -> OperatingPointResults | None:
    """Return the point where each shaft comes nearest to each obstacle as rubber lets it.

    (..., S, parts), the obstacles of the first shaft before those of the second. None where the
    line is not on rubber, or has no point, or nothing is in its way. Of the points tried: none
    next to them has 0.1 mm more.
    """
    if screened is None or not mounts.inputs.obstacles:
        return None
    nearest = largest_points(screened.obstacle_reach, "reach", 2)
    rows = gather_points(mounts.torque_curves, [without_repeated_points(*point_rows(*nearest))])
    return largest_point(obstacle_reach_at_points(mounts, *rows), "reach")


def obstacle_reach_at_points(
    mounts: LineOnMounts, curve: IntArray, speed: FloatArray
) -> OperatingPointResults:
    """Return how far each shaft reaches into each obstacle at points (P, ..., S), m.

    The distance of a place on a shaft is convex in where it goes: along the way to the obstacle,
    what is left of it is never more than what there is.
    """
    inputs = mounts.inputs
    asked = demand_at_operating_points(
        inputs.demand, mounts.torque_curves, curve=curve, speed=speed
    )
    assert mounts.mounted_line is not None  # or nothing is tried on it
    laid, how = inputs.layout_for(asked), mounts.force_inputs(asked, inertia=True)
    del how["gravity"]  # a layout is one of a line that already hangs
    thrust = mounts.thrust_effect(asked)
    gone = shaft_end_displacements(
        laid, inputs.line, inputs.phases, held=mounts.mounted_line, thrust=thrust, **how
    )
    there = shaft_obstacle_clearances(laid, inputs.line, inputs.obstacles, travel=asked.travel)
    share = np.stack([1 - there.shaft_fraction, there.shaft_fraction], axis=-1)

    def along(ends: Any) -> Any:
        """Return how far that takes each shaft from each obstacle, where they may be nearest."""
        return ((there.direction @ ends[..., None, :, :].mT) * share).sum(-1)

    waves = sum(np.abs(along(wave)) for wave in np.moveaxis(gone.waves, -4, 0))
    free = there.clearance + along(gone.mean) - waves
    if gone.thrust is not None:
        free += np.minimum(0.0, np.minimum(*(along(ends) for ends in gone.thrust)))
    free = np.where(np.isnan(asked.torque)[..., None, None], np.nan, free.min(axis=-1))
    return OperatingPointResults(
        curves=mounts.torque_curves,
        curve_index=np.broadcast_to(curve, asked.speed.shape),
        speed=asked.speed,
        torque=asked.torque,
        results=ShaftReachIntoObstacles(reach=-free.reshape(*free.shape[:-2], -1)),
    )


def worst_joint_forces(mounts: LineOnMounts) -> OperatingPointResults | None:
    """Return the point where what shakes each joint is largest, (..., S, n).

    Of a line on its rubber, at the corners of its curves and where orders meet modes; None
    where it is not on rubber, or has no point. The first joint and the last are those of the
    flanges.
    """
    inputs = mounts.inputs
    found, cut = mounts.torque_curves, mounted_line_of(inputs, cut=True)
    if not found.gears or mounts.mounted_line is None or cut is None or inputs.line.joint_count < 3:
        return None
    curve, speed = candidate_rows(mounts)
    asked = demand_at_operating_points(inputs.demand, found, curve=curve, speed=speed)
    carried = joint_forces(
        inputs.layout_for(asked),
        inputs.line,
        inputs.phases,
        held=mounts.mounted_line,
        cut=cut,
        **mounts.force_inputs(asked, inertia=True),
    )
    every = OperatingPointResults(
        curves=found,
        curve_index=np.broadcast_to(curve, asked.speed.shape),
        speed=asked.speed,
        torque=asked.torque,
        results=nan_where_no_point(carried, asked),
    )
    return largest_point(every, "dynamic")


@dataclass(frozen=True, kw_only=True, eq=False)
class ParametricGrowth:
    """How a line's swinging goes on, (..., 1) 1/s: above 0 it grows by itself."""

    growth: FloatArray


def worst_growth_rate(mounts: LineOnMounts) -> OperatingPointResults | None:
    """Return the point where a line's swinging grows most, or decays least, (..., S, 1).

    At the corners of its curves, and with most torque where twice the speed meets the sum of
    two modes; None where the line is not on rubber, or has no point.
    """
    inputs = mounts.inputs
    found, quick = mounts.torque_curves, mounts.reduced_mounted_line
    if not found.gears or quick is None or inputs.line.joint_count < 3:
        return None
    rows: list[PointRows] = []
    for of in curves_by_direction(found):
        rows += [*corner_points(found, of), _sums(found, quick, of)]
    curve, speed = gather_points(found, rows)
    asked = operating_points_on_curves(found, curve=curve, speed=speed)
    # Where the axle rides changes a shaft's length, and so this, by next to nothing.
    tried = growth_rates_at(mounts, asked, quick, inputs.layout, how=two_mode_growth)
    # Zones lie close, and more than two modes feed each other.
    most = largest_points(tried, "growth", REFINED_PEAK_COUNT)
    curve, speed = gather_points(found, [without_repeated_points(*point_rows(*most))])
    asked = operating_points_on_curves(found, curve=curve, speed=speed)
    lies = inputs.layout_for(
        demand_at_operating_points(inputs.demand, found, curve=curve, speed=speed)
    )
    return largest_point(
        growth_rates_at(mounts, asked, quick, lies, how=line_swing_growth_rate), "growth"
    )


def growth_rates_at(
    mounts: LineOnMounts,
    at: LineOperatingPoints,
    quick: MountedLine,
    lies: Layout,
    *,
    how: Callable[..., FloatArray],
) -> OperatingPointResults:
    """Return how a line's swinging goes on at points (P, ..., S), where it lies."""
    inputs = mounts.inputs
    torque, pace = np.nan_to_num(at.torque), at.sense * np.nan_to_num(at.speed)
    rate = None
    if how is two_mode_growth and lies is inputs.layout:
        rate = two_mode_growth_of_line(
            quick, inputs.line, lies.directions, inputs.phases, speed=pace, torque=torque
        )
    if rate is None:
        under = inputs.line.phases_under_torque(inputs.phases, torque)
        turned = rotate_chain(
            lies.directions, phases=under, crosses=inputs.line.is_cross, samples=16
        )
        rate = how(quick, quick.order2_coupling(turned), speed=pace, torque=torque)
    return OperatingPointResults(
        curves=at.curves,
        curve_index=at.curve_index,
        speed=at.speed,
        torque=at.torque,
        results=ParametricGrowth(growth=np.where(np.isnan(at.torque), np.nan, rate)[..., None]),
    )


def _sums(found: TorqueCurves, quick: MountedLine, of: IntArray) -> PointRows:
    """Return where order 2 meets the sum of two modes with most torque of curves `of` C."""
    cases, modes = found.max_speed.shape[1:], quick.mass.shape[-1]
    one, other = np.triu_indices(modes)
    free = np.broadcast_to(quick.natural_frequencies(), (*cases, modes))
    meets = np.moveaxis(free[..., one] + free[..., other], -1, 0) / 2
    _, torque = strongest_curves(found, of, meets)
    under = quick.natural_frequencies(torque=np.nan_to_num(torque))
    meets = np.stack([(under[q, ..., i] + under[q, ..., j]) / 2
                      for q, (i, j) in enumerate(zip(one, other, strict=True))])  # fmt: skip
    return strongest_curves(found, of, meets)[0], meets
