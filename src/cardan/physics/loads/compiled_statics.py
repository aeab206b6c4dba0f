"""Mean loads of a turning line, point by point: compiled where numba is installed.

The same algebra as `rotate_chain`, `joint_loads` and `MountedLine`, of order 0 alone.
"""

from collections.abc import Callable
from typing import Any, TypeAlias

import numpy as np

from cardan.core.arrays import FloatArray
from cardan.core.compiled import compiled
from cardan.physics.loads.compiled_algebra import cross, fill_frame, rotate_one_chain

LoadsKernel: TypeAlias = Callable[..., bool]


def mean_loads(
    directions: FloatArray,
    points: FloatArray,
    torque: FloatArray,
    yokes: FloatArray,
    shafts: FloatArray,
    crosses: FloatArray,
    tilts: FloatArray,
    along: FloatArray,
    share: FloatArray,
    frame: FloatArray,
    last: FloatArray,
    push: FloatArray,
    gradient: FloatArray,
    fixed: FloatArray,
    by_thrust: FloatArray,
) -> bool:
    """Fill what P torques do to each of C lines on rubber, False if a joint locks.

    Parameters
    ----------
    directions, points : (P, C, n+1, 3) 1, (P, C, n, 3) m
        Where the line runs.
    torque : (P, C) N m
    yokes : (C, 2, n-1) rad, rad/N m
        Phases as if all joints were crosses, and what each N m takes from them.
    shafts : (C, 3, n-1) m, N, N
        Rear joint behind the bearing; upward force on the front and the rear end of each shaft.
    crosses : (n,)
        1 of a cross, 0 of a joint of constant velocity.
    tilts, along : (C, 6 (n-1), N) 1/m, (C, n-1, 3)
        Of `MountedLine`.
    share, frame : (C, B, N), (C, B/3, 9)
        Forces of bearings for 1 N on each coordinate, and the bearings' directions.
    last : (C, 3, N)
        Motion of the spline's two halves against each other.
    push, gradient : (P, C, N) N, 1
        Filled: mean moments on the coordinates; how much these lengthen the spline.
    fixed, by_thrust : (P, C, B/3, 3) N, 1
        Filled: forces on the bearings without what the coordinates take, and of 1 N of compression.
    """
    P, C, n, _ = points.shape
    N, bearings = tilts.shape[2], frame.shape[1]
    slopes, settings = np.empty(n + 1, np.complex128), np.empty(n, np.complex128)
    phasors = np.empty(n + 1, np.complex128)
    moments, couples, lengths = np.empty((n, 3)), np.empty((n - 1, 3)), np.empty(n - 1)
    F, one, other = np.empty(3, np.complex128), np.empty(3), np.empty(3)
    joint, pull = np.empty(3), np.empty(3)
    for c in range(C):
        for p in range(P):
            T = torque[p, c]
            d = directions[p, c]
            if not rotate_one_chain(d, yokes[c], T, crosses, slopes, settings, phasors):
                return False
            for k in range(n):
                u, v, e = d[k], d[k + 1], phasors[k]
                e2 = e.real * e.real + e.imag * e.imag
                uv = u[0] * v[0] + u[1] * v[1] + u[2] * v[2]
                if crosses[k] == 0:
                    even = T * (1 + e2) / ((1 - e2) * (1 + uv))
                    for x in range(3):
                        moments[k, x] = even * (u[x] + v[x])
                    continue
                fill_frame(u, slopes[k], F)
                carried = v[0] * F[0] + v[1] * F[1] + v[2] * F[2]
                swing = settings[k] * settings[k] * carried * e.conjugate()
                scale = T / (uv * (1 - e2))
                for x in range(3):
                    h = v[x] - (carried.conjugate() * F[x]).real / 2
                    moments[k, x] = scale * ((1 + e2) * h + (swing * F[x]).real)
            for k in range(n - 1):
                square = 0.0
                for x in range(3):
                    step_ = points[p, c, k + 1, x] - points[p, c, k, x]
                    square += step_ * step_
                    one[x] = moments[k, x] - moments[k + 1, x]
                lengths[k] = np.sqrt(square)
                cross(d[k + 1], one, couples[k])
            # Forces of the joints from the last shaft forward: of torque and weight, and of
            # 1 N of tension in the spline.
            for x in range(3):
                joint[x] = -couples[n - 2, x] / lengths[n - 2]
                pull[x] = -d[n - 1, x]
            joint[2] -= shafts[c, 1, n - 2]
            for k in range(n - 3, -1, -1):
                a, arm = d[k + 1], lengths[k] - shafts[c, 0, k]
                joint[2] -= shafts[c, 2, k]
                along_joint = joint[0] * a[0] + joint[1] * a[1] + joint[2] * a[2]
                along_pull = pull[0] * a[0] + pull[1] * a[1] + pull[2] * a[2]
                for x in range(3):
                    across = joint[x] - along_joint * a[x]
                    held = (couples[k, x] + lengths[k] * across) / arm
                    fixed[p, c, k, x] = -held
                    joint[x] -= held
                    held = lengths[k] * (pull[x] - along_pull * a[x]) / arm
                    by_thrust[p, c, k, x] = held  # compression: the reverse of a tension
                    pull[x] -= held
                joint[2] -= shafts[c, 1, k]
            for i in range(N):
                push[p, c, i] = 0.0
                lengthens = 0.0
                for x in range(3):
                    lengthens += d[n - 1, x] * last[c, x, i]
                gradient[p, c, i] = lengthens
            for k in range(n - 1):
                cross(moments[k], along[c, k], one)
                cross(moments[k + 1], along[c, k], other)
                for x in range(3):
                    front, rear = 3 * k + x, 3 * (n - 1 + k) + x
                    for i in range(N):
                        push[p, c, i] += one[x] * tilts[c, front, i] - other[x] * tilts[c, rear, i]
            for b in range(bearings):
                for k in range(3):
                    by_push, by_gradient = 0.0, 0.0
                    for i in range(N):
                        by_push += share[c, 3 * b + k, i] * push[p, c, i]
                        by_gradient += share[c, 3 * b + k, i] * gradient[p, c, i]
                    for x in range(3):
                        fixed[p, c, b, x] -= by_push * frame[c, b, 3 * k + x]
                        by_thrust[p, c, b, x] -= by_gradient * frame[c, b, 3 * k + x]
    return True


def mean_loads_kernel() -> LoadsKernel | None:
    """Return the compiled `mean_loads`; None without numba."""
    loop: Any = compiled(mean_loads, cross, fill_frame, rotate_one_chain)
    return loop
