"""Forces of centre bearings by state, order and speed, with phase, as a table in CSV.

For models of frame, cab and noise: the excitation that the driveline hands on.
"""

import csv
import io
from collections.abc import Iterable, Iterator
from typing import Any

import numpy as np

from cardan.checks.line_response import LineResponse
from cardan.checks.operating_point_results import OperatingPointResults, point_rows
from cardan.core.arrays import BoolArray, ComplexArray, FloatArray
from cardan.core.errors import DesignError
from cardan.core.units import deg, rpm
from cardan.core.verdict import MARGIN_TOLERANCE
from cardan.physics.loads.centre_bearing import BEARING_FORCE_ORDERS, BearingForces
from cardan.physics.loads.half_turn_fourier import semi_major_axis

SPEED_COUNT = 40
"""Speeds up to the highest of a line; each curve's own end and each worst point come on top."""
COLUMNS = (
    "line", "state", "gear", "mode", "speed_rpm", "torque_Nm", "bearing", "order", "frequency_Hz",
    "Fx_N", "Fy_N", "Fz_N", "phase_x_deg", "phase_y_deg", "phase_z_deg", "F_N",
    "lower_bound", "stuck_spline",
)  # fmt: skip


def bearing_force_csv(responses: Iterable[LineResponse]) -> str:
    """Return the force of each centre bearing, order by order, along the line's torque curves.

    Along an axis it is F cos(k θ + phase), of order k, with θ the rotation of the gearbox's yoke, 0
    where its pin axis is horizontal, rising with time as the line turns (ahead: clockwise, seen
    from the gearbox). Order 0 is the mean, with its sign, under
    the spline thrust that makes it largest. F_N is 0-to-peak along the longer axis of the ellipse.
    Order 1 is of permissible unbalance, whose heavy spots are unknown: it has F_N alone.
    `lower_bound` is 1 where linear rubber would go beyond its stop: forces are at least these.
    Forces are those of a line whose spline slides: `stuck_spline` is 1 in a state in which the
    verdict has more of that bearing, with friction holding the spline.

    Raises
    ------
    DesignError
        If no line has a centre bearing, or none a torque.
    """
    text = io.StringIO()
    table = csv.writer(text, lineterminator="\n")
    table.writerow(COLUMNS)
    count = 0
    for r in responses:
        for row in _rows(r) if r.line.joint_count > 2 else ():
            table.writerow(row)
            count += 1
    if not count:
        msg = "no centre bearing with a torque: there are no bearing forces to write"
        raise DesignError(msg)
    return text.getvalue()


def _rows(r: LineResponse) -> Iterator[tuple[Any, ...]]:
    """Yield the rows of a line, states first, then curves by speed."""
    p = _points(r)
    beyond, stuck = _beyond_stop(r, p), _is_larger_with_spline_stuck(r)
    for s, state in enumerate(r.demand.states):
        seen: set[tuple[int, str]] = set()
        for k in np.lexsort((p.speed[:, s], p.curve_index[:, s])).tolist():
            curve, speed, torque = (
                int(p.curve_index[k, s]),
                float(p.speed[k, s]),
                float(p.torque[k, s]),
            )
            key = (curve, f"{speed:.6g}")
            if np.isnan(torque) or key in seen:
                continue
            seen.add(key)
            at = (
                r.line.name,
                state,
                p.curves.gears[curve],
                p.curves.directions[curve],
                _number(speed / rpm),
                _number(torque),
            )
            for b in range(r.line.joint_count - 2):
                for order, *forces in _orders(p.results, (k, s, b)):
                    frequency = _number(order * speed / (2 * np.pi))
                    yield *at, b + 1, order, frequency, *forces, int(beyond[k, s]), int(stuck[s, b])


def _beyond_stop(r: LineResponse, p: OperatingPointResults) -> BoolArray:
    """Return at which points (P, S) the rubber of a bearing would go beyond its stop.

    Then the forces of all its bearings are bounds: what a stop takes on others throw off.
    """
    if r.mounts.mounted_line is None:
        return np.zeros(p.speed.shape, dtype=bool)
    goes = r.mounts.bearing_forces_at_points(p.curve_index, p.speed, gives=True).results.peak
    return (goes > r.mount_loads.rubber_stop_travel * (1 + MARGIN_TOLERANCE)).any(axis=-1)


def _is_larger_with_spline_stuck(r: LineResponse) -> BoolArray:
    """Return of which bearings in which states (S, n-2) a stuck spline makes a force larger."""
    stuck = r.mount_loads.is_stuck("dynamic") | r.mount_loads.is_stuck("peak")
    return np.broadcast_to(stuck, (len(r.demand.states), r.line.joint_count - 2))


def _points(r: LineResponse) -> OperatingPointResults:
    """Return points of all curves (P, S), and what the bearings carry there."""
    curves = r.mounts.torque_curves
    end = curves.max_speed
    top = float(np.nanmax(end, initial=0.0))
    grid = np.linspace(top / SPEED_COUNT, top, SPEED_COUNT)[None, :, None]
    grid = np.where(grid <= end[:, None], grid, np.nan)
    speed = np.concatenate([grid, end[:, None]], axis=1)
    curve = np.broadcast_to(np.arange(len(curves.gears))[:, None, None], speed.shape)
    rows = [(curve.reshape(-1, end.shape[-1]), speed.reshape(-1, end.shape[-1]))]
    if worst := r.mount_loads.worst_bearing_forces:
        rows.append(point_rows(*worst.values()))
    which, every = (np.concatenate(values) for values in zip(*rows, strict=True))
    return r.mounts.bearing_forces_at_points(which, every)


def _orders(f: BearingForces, at: tuple[int, int, int]) -> Iterator[tuple[Any, ...]]:
    """Yield order, amplitudes (3) N, phases (3) deg and size N of each order of a bearing."""
    mean: FloatArray = f.mean[at]
    yield 0, *map(_number, mean.tolist()), 0, 0, 0, _number(np.linalg.norm(mean))
    if f.order1[at] > 0:
        yield 1, "", "", "", "", "", "", _number(f.order1[at])
    waves: ComplexArray = f.waves[at]
    for order, wave in zip(BEARING_FORCE_ORDERS, waves, strict=True):
        yield (
            order,
            *map(_number, np.abs(wave).tolist()),
            *map(_number, (np.angle(wave) / deg).tolist()),
            _number(semi_major_axis(wave)),
        )


def _number(value: Any) -> str:
    return f"{float(value):.6g}"
