"""What centre bearings carry as their rubber is stiffer or softer, as heat and cold make it.

The points at which they carry most are those of the file's rubber, moved along their curve of
torque over speed with the mode that is met there: its frequency goes with the root of the
stiffness. So nothing is sought again, and each value is one that the line has at a point.
"""

from collections.abc import Container, Sequence
from dataclasses import replace

import numpy as np

from cardan.checks.line_response import LineResponse
from cardan.checks.operating_envelope import (
    PointRows,
    curves_by_direction,
    curves_for_cases,
    gather_points,
    strongest_curves,
    without_repeated_points,
)
from cardan.checks.operating_point_results import OperatingPointResults, point_rows
from cardan.checks.worst_points import obstacle_reach_at_points
from cardan.core.arrays import FloatArray, broadcastable_axis_indices
from cardan.model.parts import CentreBearing


def with_rubber_stiffness(r: LineResponse, shares: Sequence[FloatArray | float]) -> LineResponse:
    """Return a line whose rubber has `shares` (V, 1) of its stiffness, bearing by bearing.

    Of one variant, numbers.
    """
    installed, each = r.demand.installed, iter(shares)

    def tempered(of: CentreBearing) -> CentreBearing:
        share, k = next(each), of.stiffness
        along = of.axial_stiffness
        return replace(
            of,
            stiffness=k and (k[0] * share, k[1] * share),
            axial_stiffness=None if along is None else along * share,
        )

    shafts = tuple(
        replace(s, centre_bearing=s.centre_bearing and tempered(s.centre_bearing))
        for s in installed.line.shafts
    )
    line = replace(installed.line, shafts=shafts)
    return r.with_inputs(demand=replace(r.demand, installed=replace(installed, line=line)))


def rows_moved_with_modes(
    r: LineResponse, other: LineResponse, *worst: OperatingPointResults
) -> PointRows:
    """Return the points (P, V, S) of `worst` (S, n-2), and those where `other` meets their mode."""
    own, its = r.mounts.mounted_line, other.mounts.mounted_line
    assert own is not None  # or nothing is sought on it
    assert its is not None
    curve, speed = point_rows(*worst)
    torque = np.nan_to_num(np.concatenate([np.moveaxis(p.torque, -1, 0) for p in worst]))
    was, will = (
        own.natural_frequencies(torque=torque),
        its.natural_frequencies(torque=torque[:, None]),
    )
    met = np.abs(was - 2 * speed[..., None]).argmin(axis=-1)[..., None]
    was = np.take_along_axis(was, met, axis=-1)[..., 0]
    will = np.take_along_axis(will, np.broadcast_to(met[:, None], (*will.shape[:-1], 1)), axis=-1)
    moved = speed[:, None] * will[..., 0] / np.where(was > 0, was, np.inf)[:, None]
    curve = np.broadcast_to(curve[:, None], moved.shape)
    curves = curves_for_cases(r.mounts.torque_curves, moved.shape[1:])
    there = curve
    for of in curves_by_direction(curves):  # another gear may have most torque there
        there = np.where(np.isin(curve, of), strongest_curves(curves, of, moved)[0], there)
    moved = np.minimum(moved, curves.max_speed[there, *broadcastable_axis_indices(moved.shape)[1:]])
    speeds = np.concatenate([np.broadcast_to(speed[:, None], moved.shape), moved])
    return gather_points(curves, [without_repeated_points(np.concatenate([curve, there]), speeds)])


def results_with_rubber_stiffness(
    r: LineResponse, shares: Sequence[FloatArray], *, quantities: Container[str]
) -> dict[str, FloatArray]:
    """Return what hangs on rubber of `shares` (V, 1) of its stiffness, by quantity, SI.

    (V, S, parts): the forces on each bearing, the compression of the line over its critical one,
    how far a duty cycle stays off resonance, and, among `quantities`, how far each bearing goes on
    its rubber and what that leaves between shafts and obstacles. nan where the spline's thrust has
    no equilibrium.
    """
    other = with_rubber_stiffness(r, shares)
    loads, thrust = r.mount_loads, other.mounts.stroke_thrust
    rows = rows_moved_with_modes(r, other, *loads.worst_bearing_forces.values())
    found = {f"centre_bearing_{k}": v for k, v in _largest(other, rows, gives=False).items()}
    if "centre_bearing_travel" in quantities and loads.worst_bearing_travel is not None:
        rows = rows_moved_with_modes(r, other, loads.worst_bearing_travel)
        found["centre_bearing_travel"] = _largest(other, rows, gives=True)["peak"]
    if "clearance_on_rubber" in quantities and loads.worst_obstacle_clearance is not None:
        rows = rows_moved_with_modes(r, other, loads.worst_obstacle_clearance)
        reach = obstacle_reach_at_points(other.mounts, *rows).results.reach
        found["clearance_on_rubber"] = -np.fmax.reduce(reach, axis=0)
    if thrust is not None:
        held = thrust.is_evaluated[..., None]
        for name in found.keys() - {"centre_bearing_dynamic"}:
            found[name] = np.where(held, found[name], np.nan)
        found["spline_compression_utilisation"] = thrust.utilisation[..., None]
    if "resonance_distance" in quantities:
        found["resonance_distance"] = other.mount_loads.resonance_distance[..., None]
    return found


def _largest(other: LineResponse, rows: PointRows, *, gives: bool) -> dict[str, FloatArray]:
    """Return the largest forces on each bearing over points, (V, S, n-2) N; or its travel, m."""
    found = other.mounts.bearing_forces_at_points(*rows, gives=gives).results
    names = ("static", "dynamic", "peak")
    return {name: np.fmax.reduce(getattr(found, name), axis=0) for name in names}
