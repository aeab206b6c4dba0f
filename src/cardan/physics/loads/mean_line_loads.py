"""Mean loads of a line on rubber under torque, weight and thrust, wherever its axle is."""

from math import prod
from typing import Any

import numpy as np

from cardan.core.arrays import ArrayLike, FloatArray, stack_on_last_axis
from cardan.core.batched_linalg import case_table, matrix_axes_first
from cardan.core.compiled import is_compiled_batch
from cardan.core.lazy_dataclass import dataclass
from cardan.model.layout import Layout
from cardan.model.parts import Line
from cardan.physics.kinematics.joint_chain import yoke_phases_as_if_all_crosses
from cardan.physics.loads.centre_bearing import loads_of_turning_line
from cardan.physics.loads.compiled_line_loads import LineKernel, mean_loads_kernel
from cardan.physics.loads.rubber_mount import MountedLine
from cardan.physics.loads.statics import (
    bearing_forces_of_weight_and_thrust,
    bearing_overhangs,
    shaft_end_weights,
)


@dataclass(frozen=True, kw_only=True, eq=False)
class MeanLineLoads:
    """Mean loads of a line on rubber; cases on leading axes.

    Attributes
    ----------
    push : (..., N) N
        Mean moments of the crosses on its coordinates.
    spline_gradient : (..., N) 1
        How much the coordinates lengthen the spline.
    fixed_bearing_forces : (..., n-2, 3) N
        Of torque and weight, less what the coordinates take at rest.
    by_compression : (..., n-2, 3) 1
        The same of 1 N of compression in the spline.
    """

    push: FloatArray
    spline_gradient: FloatArray
    fixed_bearing_forces: FloatArray
    by_compression: FloatArray


def mean_line_loads(
    held: MountedLine,
    layout: Layout,
    line: Line,
    phases: ArrayLike,
    *,
    torque: FloatArray,
    gravity: float,
) -> MeanLineLoads:
    """Return the mean loads of a line where it lies, under torques (...) N m.

    Raises
    ------
    DesignError
        If a joint locks.
    """
    own = held.case_last_matrices.cases
    kernel = mean_loads_kernel() if is_compiled_batch(own) else None
    if kernel and line.axial_freedom == "last_shaft" and line.joint_bending_stiffnesses is None:
        lead = np.broadcast_shapes(torque.shape, layout.points.shape[:-2], own)
        cases = lead[len(lead) - len(own) :]
        found = _by_loop(kernel, held, layout, line, phases, torque, gravity, lead, cases)
        if found:
            return found
    _, carried = loads_of_turning_line(
        layout, line, phases, torque=torque, speed=np.zeros(torque.shape)
    )
    still = carried.bearing_forces.order(0).real
    push = held.forces_from_joint_moments(carried.joint_moments.order(0)).real
    gradient = held.spline_gradient(layout.directions[..., -2, :])
    weight, pulled = bearing_forces_of_weight_and_thrust(layout, line, gravity=gravity)
    taken, by_gradient = (
        held.static_bearing_forces(f.astype(complex)).real for f in (push, gradient)
    )
    return MeanLineLoads(
        push=push,
        spline_gradient=gradient,
        fixed_bearing_forces=still + weight - taken,
        by_compression=-pulled - by_gradient,
    )


def _by_loop(
    kernel: LineKernel,
    held: MountedLine,
    layout: Layout,
    line: Line,
    phases: ArrayLike,
    torque: FloatArray,
    gravity: float,
    lead: tuple[int, ...],
    cases: tuple[int, ...],
) -> MeanLineLoads | None:
    """Return `mean_line_loads` by the compiled loop over points (..., S); None if a joint locks."""
    C = prod(cases)
    shape = prod(lead) // max(C, 1), C
    n, N, bearings = line.joint_count, held.mass.shape[-1], held.loss.shape[-1]

    def points(values: Any, *own: int) -> FloatArray:
        wide = np.broadcast_to(values, (*lead, *own))
        return np.ascontiguousarray(wide).reshape(*shape, *own)

    def table(*parts: Any, of: int, own: tuple[int, ...]) -> FloatArray:
        each = [(matrix_axes_first(np.asarray(v, dtype=float), of=of), of) for v in parts]
        return case_table(each, cases).reshape(C, *own)

    weights = shaft_end_weights(line, gravity)
    downward = weights[..., 0, 2], weights[..., 1, 2]
    push, gradient = np.empty((*shape, N)), np.empty((*shape, N))
    fixed, by_compression = np.empty((*shape, bearings, 3)), np.empty((*shape, bearings, 3))
    runs = kernel(
        points(layout.directions, n + 1, 3),
        points(layout.points, n, 3),
        points(torque),
        yoke_table(line, phases, cases),
        table(bearing_overhangs(line), *downward, of=1, own=(3, n - 1)),
        np.array(line.is_cross, dtype=float),
        *held.tilt_tables(cases),
        table(held.static_bearing_share, of=2, own=(3 * bearings, N)),
        table(held.bearing_frame, of=3, own=(bearings, 9)),
        table(held.spline_motion, of=2, own=(3, N)),
        push,
        gradient,
        fixed,
        by_compression,
    )
    if not runs:
        return None
    return MeanLineLoads(
        push=push.reshape(*lead, N),
        spline_gradient=gradient.reshape(*lead, N),
        fixed_bearing_forces=fixed.reshape(*lead, bearings, 3),
        by_compression=by_compression.reshape(*lead, bearings, 3),
    )


def yoke_table(line: Line, phases: ArrayLike, cases: tuple[int, ...]) -> FloatArray:
    """Return `yokes` of `rotate_one_chain` of each of C cases, (C, 2, n-1) rad, rad/N m."""
    phases = yoke_phases_as_if_all_crosses(np.asarray(phases, dtype=float), line.is_cross)
    each = phases, stack_on_last_axis(line.torsional_flexibilities)
    parts = [(matrix_axes_first(v, of=1), 1) for v in each]
    return case_table(parts, cases).reshape(prod(cases), 2, -1)
