"""Growth of two modes of a line under torque, point by point: compiled where numba is installed.

The same algebra as `MountedLine.order2_coupling` and `two_mode_growth`, the reference.
"""

from collections.abc import Callable
from typing import Any, TypeAlias

import numpy as np

from cardan.core.arrays import FloatArray
from cardan.core.compiled import compiled
from cardan.physics.loads.compiled_algebra import (
    congruent,
    cross,
    diagonalise,
    factor,
    fill_frame,
    rotate_one_chain,
)

GrowthKernel: TypeAlias = Callable[..., bool]


def pair_growths(
    line: FloatArray,
    directions: FloatArray,
    yokes: FloatArray,
    crosses: FloatArray,
    tilts: FloatArray,
    along: FloatArray,
    points: FloatArray,
    growth: FloatArray,
) -> bool:
    """Fill the largest growth (P, C) 1/s of two modes at P points of C lines; False if one locks.

    Points of one torque have the same modes and the same coupling: these are computed once.

    Parameters
    ----------
    line : (C, 5, N, N)
        Matrices of `DynamicStiffness`.
    directions : (C, n+1, 3)
        Of the members; a line lies alike at all points.
    yokes, crosses : (C, 2, n-1), (n,)
        As `rotate_one_chain` has them.
    tilts, along : (C, 6 (n-1), N) 1/m, (C, n-1, 3)
        Of `MountedLine`.
    points : (2, P, C) rad/s, N m
        Speed and torque.
    """
    N, n = line.shape[2], directions.shape[1] - 1
    _, P, C = points.shape
    slopes, settings = np.empty(n + 1, np.complex128), np.empty(n, np.complex128)
    phasors, pin = np.empty(n + 1, np.complex128), np.empty(3, np.complex128)
    front, rear = np.empty(3, np.complex128), np.empty(3, np.complex128)
    pushed, bent = np.empty((n, N), np.complex128), np.empty((n, N), np.complex128)
    push, bend = np.empty(N, np.complex128), np.empty(N, np.complex128)
    root, inverse, work = np.empty((N, N)), np.empty((N, N)), np.empty((N, N))
    still, wound, lost = np.empty((N, N)), np.empty((N, N)), np.empty((N, N))
    a, vectors, shapes = np.empty((N, N)), np.empty((N, N)), np.empty((N, N))
    omegas, decays, fed = np.empty((P, N)), np.empty((P, N)), np.empty((P, N, N))
    for c in range(C):
        for i in range(N):
            for j in range(N):
                root[i, j] = line[c, 3, i, j]
        if not factor(root, inverse):
            return False
        congruent(inverse, line[c, 0], work, still)
        congruent(inverse, line[c, 4], work, wound)
        congruent(inverse, line[c, 1], work, lost)
        for p in range(P):
            speed, T = points[0, p, c], points[1, p, c]
            at = p
            for k in range(p):
                if points[1, k, c] == T:
                    at = k
                    break
            if at == p:
                for i in range(N):
                    for j in range(N):
                        a[i, j] = still[i, j] + T * wound[i, j]
                diagonalise(a, vectors)
                for m in range(N):
                    omegas[p, m] = np.sqrt(max(a[m, m], 1e-9))
                    taken = 0.0
                    for i in range(N):
                        shape = 0.0
                        for k in range(i, N):
                            shape += inverse[k, i] * vectors[k, m]
                        shapes[i, m] = shape
                        row = 0.0
                        for j in range(N):
                            row += lost[i, j] * vectors[j, m]
                        taken += vectors[i, m] * row
                    decays[p, m] = taken / (2 * omegas[p, m])
                if not rotate_one_chain(
                    directions[c], yokes[c], T, crosses, slopes, settings, phasors
                ):
                    return False
                for k in range(n):
                    fill_frame(directions[c, k], slopes[k], pin)
                    for x in range(3):
                        pin[x] *= settings[k] * crosses[k]
                    cross(pin, along[c, min(k, n - 2)], front)
                    cross(pin, along[c, max(k - 1, 0)], rear)
                    for i in range(N):
                        push[i], bend[i] = 0j, 0j
                        for x in range(3):
                            if k < n - 1:
                                tilt = tilts[c, 3 * k + x, i]
                                bend[i] += pin[x] * tilt
                                push[i] += front[x] * tilt
                            if k > 0:
                                tilt = tilts[c, 3 * (n - 1) + 3 * (k - 1) + x, i]
                                bend[i] -= pin[x] * tilt
                                push[i] -= rear[x] * tilt
                    for m in range(N):
                        pushed[k, m], bent[k, m] = 0j, 0j
                        for i in range(N):
                            pushed[k, m] -= push[i] * shapes[i, m] / 2
                            bent[k, m] += bend[i] * shapes[i, m]
                # Of two modes in either order the reference takes the slower one first.
                for i in range(N):
                    for j in range(N):
                        tie = 0j
                        for k in range(n):
                            tie += pushed[k, i] * bent[k, j]
                        size2 = (tie.real * tie.real + tie.imag * tie.imag) * T * T
                        fed[p, i, j] = size2 / (16 * omegas[p, i] * omegas[p, j])
            most = -np.inf
            for i in range(N):
                for j in range(N):
                    if i != j and omegas[at, i] > omegas[at, j]:
                        continue
                    d, e = decays[at, i], decays[at, j]
                    off = 2 * abs(speed) - omegas[at, i] - omegas[at, j]
                    real, imag = (d - e) / 2, off / 2
                    square = complex(real * real - imag * imag + fed[at, i, j], 2 * real * imag)
                    most = max(most, np.sqrt(square).real - (d + e) / 2)
            growth[p, c] = most
    return True


def growth_kernel() -> GrowthKernel | None:
    """Return the compiled `pair_growths`; None without numba."""
    loop: Any = compiled(
        pair_growths, congruent, cross, diagonalise, factor, fill_frame, rotate_one_chain
    )
    return loop
