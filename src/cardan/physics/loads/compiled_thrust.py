"""Thrust of the spline, line by line: compiled where numba is installed.

The same algebra as `cardan.physics.loads.spline_thrust`, which stays the reference.
"""

from collections.abc import Callable
from typing import Any, TypeAlias

import numpy as np

from cardan.core.arrays import BoolArray, FloatArray
from cardan.core.compiled import compiled

LineKernel: TypeAlias = Callable[..., None]

JACOBI_SWEEPS = 30
"""Sweeps at most; a matrix of four rows takes four or five."""


def buckling_modes(
    still: FloatArray,
    torsion: FloatArray,
    geometric: FloatArray,
    torque: FloatArray,
    shapes: FloatArray,
    softening: FloatArray,
    stable: BoolArray,
) -> None:
    """Fill the modes of G in K + T K_T of P torques in each of C lines.

    By Cholesky's factors and cyclic Jacobi rotations. A line that the torque leaves without a
    stiffness is marked and not filled.

    Parameters
    ----------
    still, torsion, geometric : (C, N, N)
        K N/m, K_T 1/m, G 1/m.
    torque : (P, C) N m
    shapes, softening : (P, C, N, N), (P, C, N) 1/N
        Filled, in no order.
    stable : (P, C)
        Filled.
    """
    P, C = torque.shape
    N = still.shape[1]
    root, inverse = np.empty((N, N)), np.empty((N, N))
    a, y = np.empty((N, N)), np.empty((N, N))
    for c in range(C):
        for p in range(P):
            T = torque[p, c]
            stable[p, c] = True
            for j in range(N):
                for i in range(j, N):
                    value = still[c, i, j] + T * torsion[c, i, j]
                    for k in range(j):
                        value -= root[i, k] * root[j, k]
                    if i == j:
                        if not value > 0:
                            stable[p, c] = False
                            break
                        root[j, j] = np.sqrt(value)
                    else:
                        root[i, j] = value / root[j, j]
                if not stable[p, c]:
                    break
            if not stable[p, c]:
                continue
            for j in range(N):
                for i in range(N):
                    inverse[i, j] = 0.0
                inverse[j, j] = 1 / root[j, j]
                for i in range(j + 1, N):
                    value = 0.0
                    for k in range(j, i):
                        value -= root[i, k] * inverse[k, j]
                    inverse[i, j] = value / root[i, i]
            for i in range(N):
                for j in range(N):
                    value = 0.0
                    for k in range(j + 1):
                        value += geometric[c, i, k] * inverse[j, k]
                    y[i, j] = value
            for i in range(N):
                for j in range(i + 1):
                    value = 0.0
                    for k in range(i + 1):
                        value += inverse[i, k] * y[k, j]
                    a[i, j] = a[j, i] = value
            for i in range(N):
                for j in range(N):
                    y[i, j] = 1.0 if i == j else 0.0
            for _ in range(JACOBI_SWEEPS):
                off, on = 0.0, 0.0
                for i in range(N):
                    on += a[i, i] * a[i, i]
                    for j in range(i):
                        off += a[i, j] * a[i, j]
                if off <= 1e-31 * on:
                    break
                for i in range(N - 1):
                    for j in range(i + 1, N):
                        if a[i, j] == 0:
                            continue
                        half = (a[j, j] - a[i, i]) / (2 * a[i, j])
                        t = 1 / (abs(half) + np.sqrt(half * half + 1))
                        t = -t if half < 0 else t
                        cos = 1 / np.sqrt(t * t + 1)
                        sin = t * cos
                        for k in range(N):
                            one, other = a[k, i], a[k, j]
                            a[k, i], a[k, j] = cos * one - sin * other, sin * one + cos * other
                        for k in range(N):
                            one, other = a[i, k], a[j, k]
                            a[i, k], a[j, k] = cos * one - sin * other, sin * one + cos * other
                            one, other = y[k, i], y[k, j]
                            y[k, i], y[k, j] = cos * one - sin * other, sin * one + cos * other
                        a[i, j] = a[j, i] = 0.0
            for j in range(N):
                softening[p, c, j] = a[j, j]
                for i in range(N):
                    value = 0.0
                    for k in range(i, N):
                        value += inverse[k, i] * y[k, j]
                    shapes[p, c, i, j] = value


def held_compressions(
    softening: FloatArray,
    load: FloatArray,
    spline: FloatArray,
    lengthening: FloatArray,
    least: FloatArray,
    most: FloatArray,
    iterations: int,
    found: FloatArray,
) -> None:
    """Fill the compression (C,) N at which each line lengthens its spline so much.

    As `CompressedLine.compression_at_lengthening`: softening, load and spline (C, N), the
    others (C,). Each line stops by itself, where Newton's step is rounding.
    """
    C, N = softening.shape
    for c in range(C):
        low, high = least[c], most[c]
        first, last = lengthening[c], lengthening[c]
        for k in range(N):
            one = (load[c, k] + low * spline[c, k]) / (1 - low * softening[c, k])
            first -= one * (spline[c, k] + softening[c, k] * one / 2)
            one = (load[c, k] + high * spline[c, k]) / (1 - high * softening[c, k])
            last -= one * (spline[c, k] + softening[c, k] * one / 2)
        # Where friction gives way first, that is the answer.
        low, high = (high if last >= 0 else low), (low if first <= 0 else high)
        P = low if low > 0 else 0.0
        P = high if P > high else P
        for _ in range(iterations):
            off, gives = lengthening[c], 0.0
            for k in range(N):
                left = 1 - P * softening[c, k]
                moved = (load[c, k] + P * spline[c, k]) / left
                off -= moved * (spline[c, k] + softening[c, k] * moved / 2)
                slope = spline[c, k] + softening[c, k] * moved
                gives += slope * slope / left
            if off > 0:
                low = P
            if off < 0:
                high = P
            guess = P + off / gives
            if not low <= guess <= high:
                guess = (low + high) / 2
            step = abs(guess - P)
            P = guess
            if not step > 1e-13 * (1 + abs(P)):
                break
        found[c] = P


def buckling_kernel() -> LineKernel | None:
    """Return the compiled `buckling_modes`; None without numba."""
    loop: Any = compiled(buckling_modes)
    return loop


def compression_kernel() -> LineKernel | None:
    """Return the compiled `held_compressions`; None without numba."""
    loop: Any = compiled(held_compressions)
    return loop
