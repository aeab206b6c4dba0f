"""Torque of points on curves, point by point: a loop compiled where numba is installed.

The same as `cardan.physics.vehicle.operating_points`, which stays the reference: that goes segment
by segment over all points, and first collects each corner of the curves that these are on.
"""

from collections.abc import Callable
from typing import Any, TypeAlias

import numpy as np

from cardan.core.arrays import FloatArray, IntArray
from cardan.core.compiled import compiled

TorqueKernel: TypeAlias = Callable[..., None]


def torque_of_points(
    curve: IntArray,
    x: FloatArray,
    speed: FloatArray,
    torque: FloatArray,
    most: FloatArray,
    fastest: FloatArray,
    found: FloatArray,
) -> None:
    """Fill the torque N m at P points of V variants in S states; nan where a curve has none.

    Parameters
    ----------
    curve, x : (P, V, S) 1, rad/s
        Which of C curves each is on, and its speed.
    speed, torque : (C, V or 1, S or 1, E) rad/s, N m
        Corners of the curves; 1 where all variants, or states, have the same.
    most, fastest : (C, V or 1, S or 1) N m, rad/s
        Torque and speed at most.
    """
    P, V, S = x.shape
    corners = speed.shape[3]
    for p in range(P):
        for v in range(V):
            # Which row each table has of this variant: its own, or the only one.
            of_speed, of_torque = min(v, speed.shape[1] - 1), min(v, torque.shape[1] - 1)
            of_most, of_fastest = min(v, most.shape[1] - 1), min(v, fastest.shape[1] - 1)
            for s in range(S):
                c, at = curve[p, v, s], x[p, v, s]
                if not 0 <= at <= fastest[c, of_fastest, min(s, fastest.shape[2] - 1)]:
                    found[p, v, s] = np.nan
                    continue
                speeds = speed[c, of_speed, min(s, speed.shape[2] - 1)]
                torques = torque[c, of_torque, min(s, torque.shape[2] - 1)]
                there = torques[0]
                for k in range(corners - 1):
                    start, end, rise = speeds[k], speeds[k + 1], torques[k + 1] - torques[k]
                    if end > start:
                        gone = start if at < start else at
                        gone = end if gone > end else gone
                        there += rise / (end - start) * (gone - start)
                    elif at >= start:
                        there += rise
                limit, size = most[c, of_most, min(s, most.shape[2] - 1)], abs(there)
                size = size if size < limit else limit
                found[p, v, s] = -size if there < 0 else size


def torque_kernel() -> TorqueKernel | None:
    """Return the compiled `torque_of_points`; None without numba."""
    loop: Any = compiled(torque_of_points)
    return loop
