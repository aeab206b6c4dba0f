"""Thrust of the spline, line by line: compiled where numba is installed.

The same algebra as `cardan.physics.loads.spline_thrust`, which stays the reference.
"""

from collections.abc import Callable
from typing import Any, TypeAlias

import numpy as np

from cardan.core.arrays import BoolArray, FloatArray
from cardan.core.compiled import compiled
from cardan.physics.loads.compiled_algebra import congruent, diagonalise, factor

LineKernel: TypeAlias = Callable[..., None]


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

    By Cholesky's factors and cyclic Jacobi rotations, once for each torque of a line. A line that
    the torque leaves without a stiffness is marked and not filled.

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
            same = p
            for k in range(p):
                if torque[k, c] == T:
                    same = k
                    break
            if same < p:
                stable[p, c] = stable[same, c]
                shapes[p, c], softening[p, c] = shapes[same, c], softening[same, c]
                continue
            for i in range(N):
                for j in range(i + 1):
                    root[i, j] = still[c, i, j] + T * torsion[c, i, j]
            stable[p, c] = factor(root, inverse)
            if not stable[p, c]:
                continue
            congruent(inverse, geometric[c], y, a)
            diagonalise(a, y)
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
    loop: Any = compiled(buckling_modes, congruent, diagonalise, factor)
    return loop


def compression_kernel() -> LineKernel | None:
    """Return the compiled `held_compressions`; None without numba."""
    loop: Any = compiled(held_compressions)
    return loop
