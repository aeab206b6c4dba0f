"""Operating points at which a line may be worst, screened on its slowest modes."""

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np

from cardan.checks.line_inputs import LineInputs
from cardan.checks.line_on_mounts import LineOnMounts
from cardan.checks.operating_envelope import (
    PointRows,
    corner_points,
    curves_by_direction,
    gather_points,
    strongest_curves,
)
from cardan.checks.operating_point_results import (
    OperatingPointResults,
    largest_point,
    largest_points,
    map_results,
    point_rows,
)
from cardan.core.arrays import FloatArray, IntArray, broadcastable_axis_indices
from cardan.core.lazy_dataclass import dataclass
from cardan.model.layout import Layout
from cardan.physics.loads.rubber_mount import MountedLine
from cardan.physics.loads.screening import (
    AxleTravelByTorque,
    BearingForceScreeningModel,
    ObstacleCandidates,
    bearing_force_screening_model,
)
from cardan.physics.vehicle.axle_motion import AxleMotion
from cardan.physics.vehicle.clearance import shaft_obstacle_clearances
from cardan.physics.vehicle.operating_points import (
    LineOperatingPoints,
    TorqueCurves,
    axle_motion_at_points,
    housing_torque_at_points,
    operating_points_on_curves,
)
from cardan.physics.vehicle.state_demand import (
    LineStateDemand,
    demand_at_axle_motion,
)

AXLE_TRAVEL_ROUNDING_TOLERANCE_M = 1e-9
"""m, of travel that is rounding."""

SPEED_REFINEMENT_STEP_BANDWIDTHS = 0.25
"""How far from the worst speed it is sought again, in loss factors: a mode's width is one."""

RESONANCE_FLANK_OFFSETS_BANDWIDTHS = (-1.5, -0.5, 0.5, 1.5)
"""Where next to a crest order 2 may add most to the mean, in the same."""

REFINED_PEAK_COUNT = 3
"""How many crests are sought more closely: the next may prove the higher one."""


@dataclass(frozen=True, kw_only=True, eq=False)
class CandidatePoints:
    """Points (P, ..., S) at which bearings may be worst, and the model that screens them.

    The model is None of a line that is not on rubber.
    """

    curve_index: IntArray
    speed: FloatArray
    screening_model: BearingForceScreeningModel | None


def candidate_points(mounts: LineOnMounts) -> CandidatePoints | None:
    """Return where bearings may be worst; None where a line has no point, or no bearing."""
    found, quick = mounts.torque_curves, mounts.reduced_mounted_line
    if not found.gears or mounts.inputs.line.joint_count < 3:
        return None
    curve, speed = candidate_rows(mounts)
    at = operating_points_on_curves(found, curve=curve, speed=speed)
    return CandidatePoints(
        curve_index=curve,
        speed=speed,
        screening_model=None if quick is None else screening_model_of(mounts, at, quick),
    )


@dataclass(frozen=True, kw_only=True, eq=False)
class ScreenedForces:
    """What a line nearly does at its candidates.

    Attributes
    ----------
    forces, travel
        What its bearings carry, N; and how far their rubber gives, m.
    obstacle_reach
        How far its shafts reach into obstacles.
    """

    forces: OperatingPointResults
    travel: OperatingPointResults
    obstacle_reach: OperatingPointResults


def screen_candidates(mounts: LineOnMounts, of: CandidatePoints | None) -> ScreenedForces | None:
    """Return what a line nearly does at its candidates.

    None of a line that is not on rubber, or has no point.
    """
    if of is None or of.screening_model is None:
        return None
    at, asked = _screening_inputs(mounts, of.curve_index, of.speed)
    forces, travel, reach = (
        _at_points(mounts, at, sizes)
        for sizes in of.screening_model.bearing_forces_and_travel_at(**asked)
    )
    return ScreenedForces(forces=forces, travel=travel, obstacle_reach=reach)


def refined_candidates(
    mounts: LineOnMounts, of: CandidatePoints, tried: OperatingPointResults, *, gives: bool = False
) -> OperatingPointResults:
    """Return candidates tried, and points next to the worst of them; in m for N of what gives."""
    assert of.screening_model is not None  # on which they were tried
    # Only at the candidates it is needed how far shafts reach.
    return _closer(mounts, tried, of.screening_model.without_obstacles(), gives=gives)


def candidate_rows(mounts: LineOnMounts) -> PointRows:
    """Return points (P, ..., S) at which bearings may be worst.

    Of each way to be turned: the corners of the curve of most torque, the highest speed, and
    with most torque each speed at which an order of the joints meets a mode on rubber. Where
    unbalance counts, which knows no torque: with most torque of all, where its order meets a
    mode, and the end of each gear, as it grows with the speed while torque falls from gear to
    gear.
    """
    found, quick = mounts.torque_curves, mounts.reduced_mounted_line
    rows: list[PointRows] = []
    for of in curves_by_direction(found):
        rows += corner_points(found, of)
        if quick is not None:
            rows.append(_crossings(found, quick, of, orders=(2, 4)))
    if mounts.inputs.application.include_unbalance:
        every = np.arange(len(found.gears))
        ends = np.nan_to_num(found.max_speed[[d != "coast" for d in found.directions]], nan=-1.0)
        rows.append((strongest_curves(found, every, ends)[0], ends))
        if quick is not None:
            rows.append(_crossings(found, quick, every, orders=(1,)))
    return gather_points(found, rows)


def _crossings(
    found: TorqueCurves, quick: MountedLine, of: IntArray, *, orders: tuple[int, ...]
) -> PointRows:
    """Return where orders meet modes with most torque of curves `of` C, (Q, ..., S).

    Which curve that is, and the speed: a mode has the frequency that the torque leaves it.
    """
    cases, modes = found.max_speed.shape[1:], quick.mass.shape[-1]
    free = np.broadcast_to(quick.natural_frequencies(), (*cases, modes))
    meets = np.concatenate([np.moveaxis(free / k, -1, 0) for k in orders])
    _, torque = strongest_curves(found, of, meets)
    under = quick.natural_frequencies(torque=np.nan_to_num(torque))
    meets = np.stack([
        under[q, ..., q % modes] / orders[q // modes] for q in range(len(meets))
    ])  # fmt: skip
    return strongest_curves(found, of, meets)[0], meets


def screening_model_of(
    mounts: LineOnMounts, at: LineOperatingPoints, on: MountedLine
) -> BearingForceScreeningModel:
    """Return a line for all points between the least and the largest torque on its axle."""
    inputs = mounts.inputs
    # A state without a point has its own ride, and no force.
    some = np.where(np.isnan(at.torque), np.nan, housing_torque_at_points(inputs.demand, at))
    some = np.where(np.isnan(some).all(axis=0), 0.0, some)
    ridden = axle_motion_at_points(inputs.demand, at)
    rides = axle_positions(some, ridden, inputs.demand.axle_motion)
    each = [rides.torque_and_travel(*node) for node in rides.nodes]

    def named(case: tuple[int, ...]) -> str:
        """Name the point nearest to a ride."""
        away = np.abs(some[(slice(None), *case[1:])] - each[case[0]][0][case[1:]])
        return at.describe((int(np.nanargmin(away)), *case[1:]))

    asked = demand_at_nodes(inputs.demand, rides, named=named)
    laid = inputs.layout_for(asked)
    if laid.directions.ndim - 2 < asked.torque.ndim:  # however the axle rides, it lies as it lies
        laid = laid[None]
    return bearing_force_screening_model(
        on, laid, inputs.line, inputs.phases, rides=rides,
        most=np.abs(np.nan_to_num(at.torque)).max(axis=0), gravity=inputs.gravity,
        balanced_at=inputs.balancing_speed if inputs.application.include_unbalance else None,
        facing=_facing(inputs, laid, asked.travel),
        thrust=mounts.stroke_thrust and mounts.stroke_thrust.screened(),
    )  # fmt: skip


def axle_positions(on_axle: FloatArray, ride: AxleMotion, own: AxleMotion) -> AxleTravelByTorque:
    """Return the rides of an axle at points: torques on it (P, ..., S), nan where there is none.

    It moves where it rides otherwise than in its `own` state, if only in one way.
    """
    travel = np.broadcast_to(np.asarray(ride.shift, dtype=float)[..., 2], on_axle.shape)
    pitch = np.broadcast_to(np.asarray(ride.pitch, dtype=float), on_axle.shape)
    travel, pitch = (np.where(np.isnan(on_axle), np.nan, v) for v in (travel, pitch))
    ends = [of(on_axle, axis=0)[None] for of in (np.nanargmin, np.nanargmax)]
    (least, lowest), (largest, highest) = (
        [np.take_along_axis(v, end, axis=0)[0] for v in (on_axle, travel)] for end in ends
    )
    found = AxleTravelByTorque(
        least=least, largest=largest, lowest=lowest, highest=highest,
        away=np.zeros_like(least),
        has_motion=any(
            np.nanmax(np.abs(v - at), initial=0.0) > 0
            for v, at in ((travel, np.asarray(own.shift)[..., 2]), (pitch, own.pitch))
        ),
    )  # fmt: skip
    _, off = found.normalised_coordinates(on_axle, travel)
    away = np.nanmax(np.abs(off), axis=0)
    return replace(found, away=np.where(away > AXLE_TRAVEL_ROUNDING_TOLERANCE_M, away, 0.0))


def demand_at_nodes(
    demand: LineStateDemand,
    rides: AxleTravelByTorque,
    *,
    named: Callable[[tuple[int, ...]], str] = str,
) -> LineStateDemand:
    """Return a line at each of the nodes of its axle's rides, (rides, ..., S)."""
    torque, travel = (
        np.stack(v) for v in zip(*(rides.torque_and_travel(*n) for n in rides.nodes), strict=True)
    )
    if not rides.has_motion:  # it rides as in its state
        ride = replace(
            demand.axle_motion, pitch=np.broadcast_to(demand.axle_motion.pitch, torque.shape)
        )
    else:
        ride = demand.static_state.axle_motion_at(torque, travel)
    return demand_at_axle_motion(
        demand, ride, torque=demand.torque, speed=demand.speed, named=named
    )


def screened_forces_at(
    mounts: LineOnMounts,
    curve: IntArray,
    speed: FloatArray,
    drawn: BearingForceScreeningModel,
    *,
    gives: bool = False,
) -> tuple[OperatingPointResults, OperatingPointResults]:
    """Return nearly what bearings carry at points, curves and speeds (P, ..., S), and the reach."""
    at, asked = _screening_inputs(mounts, curve, speed)
    forces, reach = (
        _at_points(mounts, at, sizes) for sizes in drawn.bearing_forces_at(**asked, gives=gives)
    )
    return forces, reach


def _screening_inputs(
    mounts: LineOnMounts, curve: IntArray, speed: FloatArray
) -> tuple[LineOperatingPoints, dict[str, Any]]:
    """Return points (P, ..., S), and what a screening model is given at them."""
    inputs = mounts.inputs
    at = operating_points_on_curves(mounts.torque_curves, curve=curve, speed=speed)
    return at, {
        "torque": at.torque,
        "speed": at.sense * at.speed,
        "on_axle": housing_torque_at_points(inputs.demand, at),
        "travel": np.asarray(axle_motion_at_points(inputs.demand, at).shift)[..., 2],
        "slip": inputs.spline_force_at(at.torque),
    }


def _at_points(mounts: LineOnMounts, at: LineOperatingPoints, sizes: Any) -> OperatingPointResults:
    """Return sizes with the points that they are of."""
    return OperatingPointResults(
        curves=mounts.torque_curves,
        curve_index=at.curve_index,
        speed=at.speed,
        torque=at.torque,
        results=sizes,
    )


def _closer(
    mounts: LineOnMounts,
    tried: OperatingPointResults,
    drawn: BearingForceScreeningModel,
    *,
    gives: bool = False,
) -> OperatingPointResults:
    """Return points tried, and those next to the worst of them where they may be worse.

    The worst peak of each bearing, and the `REFINED_PEAK_COUNT` crests of what shakes it most.
    Where a mode alone shakes, 1/F² is a parabola over the square of the speed; what order 2 adds
    to the mean is largest half a mode's width from that crest, or farther where modes overlap
    (`RESONANCE_FLANK_OFFSETS_BANDWIDTHS`).
    """
    found = tried.curves
    shaken = largest_points(tried, "dynamic", REFINED_PEAK_COUNT)
    seeds = [("peak", largest_point(tried, "peak")), *(("dynamic", p) for p in shaken)]
    curve, speed = point_rows(*(p for _, p in seeds))
    fastest = found.max_speed[curve, *broadcastable_axis_indices(curve.shape)[1:]]
    wide = drawn.mounted_line.loss.min(axis=-1)  # as narrow as the narrowest mode
    low, high = (
        speed * (1 - SPEED_REFINEMENT_STEP_BANDWIDTHS * wide),
        np.fmin(speed * (1 + SPEED_REFINEMENT_STEP_BANDWIDTHS * wide), fastest),
    )
    flanks = point_rows(*shaken)
    sides, _ = screened_forces_at(
        mounts,
        np.concatenate([curve, curve, *(flanks[0] for _ in RESONANCE_FLANK_OFFSETS_BANDWIDTHS)]),
        np.concatenate(
            [low, high, *(flanks[1] * (1 + k * wide) for k in RESONANCE_FLANK_OFFSETS_BANDWIDTHS)]
        ),
        drawn,
        gives=gives,
    )
    middle = [np.moveaxis(getattr(p.results, name), -1, 0) for name, p in seeds]
    bearings = len(middle[0])
    ends = np.stack([
        getattr(sides.results, name)[half * len(curve) + k * bearings + b, ..., b]
        for half in (0, 1) for k, (name, _) in enumerate(seeds) for b in range(bearings)
    ])  # fmt: skip
    with np.errstate(divide="ignore", invalid="ignore"):
        x = np.stack([low, speed, high]) ** 2
        y = np.stack([ends[: len(curve)], np.concatenate(middle), ends[len(curve) :]]) ** -2.0
        slopes = np.diff(y, axis=0) / np.diff(x, axis=0)
        bend = (slopes[1] - slopes[0]) / (x[2] - x[0])
        crest = (x[0] + x[1]) / 2 - slopes[0] / (2 * bend)
    reach = x[2] - x[0]  # the crest of two modes that overlap lies outside
    crest = np.where(bend > 0, np.clip(crest, x[0] - reach / 2, x[2] + reach / 2), x[1])
    crest = np.fmin(np.sqrt(np.maximum(crest, 0.0)), fastest)
    there, _ = screened_forces_at(mounts, curve, crest, drawn, gives=gives)
    return map_results(lambda *v: np.concatenate(v), tried, sides, there)


def _facing(inputs: LineInputs, laid: Layout, travel: FloatArray) -> ObstacleCandidates | None:
    """Return where shafts come nearest to obstacles, of layouts (rides, ...) at nodes."""
    if not inputs.obstacles:
        return None
    if laid.points.ndim < 5:  # obstacles may be of variants that lie alike
        laid = laid[:, None]
    if travel.ndim < 3:
        travel = travel[:, None]
    there = shaft_obstacle_clearances(laid, inputs.line, inputs.obstacles, travel=travel)
    free = there.clearance.min(axis=-1)
    middle = 1 if len(free) > 1 else 0
    best = there.clearance[middle].argmin(axis=-1)[..., None]
    share = np.take_along_axis(there.shaft_fraction[middle], best, axis=-1)[..., 0]
    away = np.take_along_axis(there.direction[middle], best[..., None], axis=-2)[..., 0, :]
    shafts, obstacles = free.shape[-2:]
    nearer = -np.stack([1 - share, share], axis=-1)[..., None] * away[..., None, :]
    own = np.eye(shafts)[:, None, :, None, None]  # of all shafts' ends its own ones
    nearer = (nearer[..., None, :, :] * own).reshape(
        *nearer.shape[:-4], shafts * obstacles, shafts, 2, 3
    )
    return ObstacleCandidates(clearance=free.reshape(*free.shape[:-2], -1), approach_matrix=nearer)
