"""Algebra of one small matrix at a time, for loops that numba compiles (`core.compiled`).

The reference for many matrices at once is `cardan.core.batched_linalg`.
"""

import numpy as np

from cardan.core.arrays import ComplexArray, FloatArray


def eliminate(a: ComplexArray, n: int) -> bool:
    """Solve a (n, n + m) complex system in place by Gauss with exchanged rows.

    The first n columns are the matrix and are overwritten; the others are right-hand sides and
    become the solutions. False if the matrix is singular.
    """
    columns = a.shape[1]
    for k in range(n):
        best, most = k, abs(a[k, k].real) + abs(a[k, k].imag)
        for i in range(k + 1, n):
            size = abs(a[i, k].real) + abs(a[i, k].imag)
            if size > most:
                best, most = i, size
        if most == 0:
            return False
        if best != k:
            for j in range(k, columns):
                a[k, j], a[best, j] = a[best, j], a[k, j]
        pivot = 1.0 / a[k, k]
        a[k, k] = pivot
        for i in range(k + 1, n):
            share = a[i, k] * pivot
            for j in range(k + 1, columns):
                a[i, j] -= share * a[k, j]
    for k in range(n - 1, -1, -1):
        pivot = a[k, k]
        for j in range(n, columns):
            a[k, j] *= pivot
        for i in range(k):
            share = a[i, k]
            for j in range(n, columns):
                a[i, j] -= share * a[k, j]
    return True


def eliminate_real(a: FloatArray, n: int) -> bool:
    """Solve a real system as `eliminate` does."""
    columns = a.shape[1]
    for k in range(n):
        best, most = k, abs(a[k, k])
        for i in range(k + 1, n):
            if abs(a[i, k]) > most:
                best, most = i, abs(a[i, k])
        if most == 0:
            return False
        if best != k:
            for j in range(k, columns):
                a[k, j], a[best, j] = a[best, j], a[k, j]
        pivot = 1.0 / a[k, k]
        a[k, k] = pivot
        for i in range(k + 1, n):
            share = a[i, k] * pivot
            for j in range(k + 1, columns):
                a[i, j] -= share * a[k, j]
    for k in range(n - 1, -1, -1):
        pivot = a[k, k]
        for j in range(n, columns):
            a[k, j] *= pivot
        for i in range(k):
            share = a[i, k]
            for j in range(n, columns):
                a[i, j] -= share * a[k, j]
    return True


def fill_dynamic_stiffness(
    into: ComplexArray, line: FloatArray, frequency: float, speed: float, torque: float
) -> None:
    """Fill the first N columns of `into` with `DynamicStiffness.dynamic_stiffness`, N/m.

    `line` (5, N, N) has its matrices: still, lost, gyroscopic, mass, torsion.
    """
    N = line.shape[1]
    sign = 1.0 if frequency > 0 else (-1.0 if frequency < 0 else 0.0)
    square, turning = frequency * frequency, frequency * speed
    for i in range(N):
        for j in range(N):
            real = line[0, i, j] + torque * line[4, i, j] - square * line[3, i, j]
            imag = sign * line[1, i, j] + turning * line[2, i, j]
            into[i, j] = complex(real, imag)


def half_axis(x: complex, y: complex, z: complex) -> float:
    """Return the longer half axis of the ellipse Re c e^{iφ} of c = (x, y, z)."""
    size2 = (
        x.real * x.real + x.imag * x.imag
        + y.real * y.real + y.imag * y.imag
        + z.real * z.real + z.imag * z.imag
    )  # fmt: skip
    skew = x * x + y * y + z * z
    return np.sqrt((size2 + np.sqrt(skew.real * skew.real + skew.imag * skew.imag)) / 2)


def fill_bearing_forces(
    into: ComplexArray,
    moved: ComplexArray,
    bearing: FloatArray,
    springs: FloatArray,
    frame: FloatArray,
    lossy: float,
) -> None:
    """Fill what the shafts put on their bearings, (B/3, 3) N, by a motion (N,) of the line.

    As `MountedLine.motion`: `lossy` is the sign of the frequency, 0 where nothing shakes.
    """
    for b in range(bearing.shape[0] // 3):
        for x in range(3):
            into[b, x] = 0j
        for k in range(3):
            row = 3 * b + k
            goes = 0j
            for i in range(bearing.shape[1]):
                goes += bearing[row, i] * moved[i]
            pull = goes * complex(springs[0, row], springs[0, row] * lossy * springs[1, row])
            for x in range(3):
                into[b, x] += pull * frame[b, 3 * k + x]


def cross(a: FloatArray, b: FloatArray, into: FloatArray) -> None:
    """Fill the cross product a x b (3,)."""
    into[0] = a[1] * b[2] - a[2] * b[1]
    into[1] = a[2] * b[0] - a[0] * b[2]
    into[2] = a[0] * b[1] - a[1] * b[0]
