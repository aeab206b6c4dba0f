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


def rotate_one_chain(
    directions: FloatArray,
    yokes: FloatArray,
    torque: float,
    crosses: FloatArray,
    slopes: ComplexArray,
    settings: ComplexArray,
    phasors: ComplexArray,
) -> bool:
    """Fill how one chain turns, as `rotate_chain` does; False if a joint locks.

    Parameters
    ----------
    directions : (n+1, 3)
    yokes : (2, n-1) rad, rad/N m
        Phases as if all joints were crosses, and what each N m of `torque` takes from them.
    crosses : (n,)
        1 of a cross, 0 of a joint of constant velocity.
    slopes, settings, phasors : (n+1,), (n,), (n+1,)
        Filled: the members' complex slopes, `ChainRotation.initial_pins`, and the phasors of all
        members, the gearbox's 0 among them.
    """
    n = settings.shape[0]
    for k in range(n + 1):
        d = directions[k]
        slopes[k] = complex(d[1], -d[2]) / (1 + d[0])
    level = (1 + slopes[0] * slopes[0]).conjugate()
    setting = level / abs(level)
    phasors[0] = 0j
    for k in range(n):
        apart = 1 + slopes[k].conjugate() * slopes[k + 1]
        bend = (slopes[k + 1] - slopes[k]) / apart
        if not abs(bend) < 1:
            return False
        step = bend * setting
        step = crosses[k] * step * step
        turned = 1 + phasors[k] * step.conjugate()
        settings[k] = setting
        phasors[k + 1] = (phasors[k] + step) / turned.conjugate()
        if k < n - 1:
            phase = yokes[0, k] - torque * yokes[1, k]
            ahead = apart.conjugate() / apart * complex(-np.sin(phase), np.cos(phase))
            setting = setting * ahead * turned / abs(turned)
    return True


def fill_frame(direction: FloatArray, slope: complex, frame: ComplexArray) -> None:
    """Fill the frame across a member, (3,) complex, as `ChainRotation.frames` has it."""
    frame[0] = -slope * (1 + direction[0])
    frame[1] = 1 - slope * direction[1]
    frame[2] = complex(0.0, -1.0) - slope * direction[2]


JACOBI_SWEEPS = 30
"""Sweeps at most; a matrix of four rows takes four or five."""


def diagonalise(a: FloatArray, vectors: FloatArray) -> None:
    """Leave the eigenvalues of a symmetric matrix (N, N) on its diagonal, by Jacobi's rotations.

    Fills the eigenvectors, in columns, in no order.
    """
    N = a.shape[0]
    for i in range(N):
        for j in range(N):
            vectors[i, j] = 1.0 if i == j else 0.0
    for _ in range(JACOBI_SWEEPS):
        off, on = 0.0, 0.0
        for i in range(N):
            on += a[i, i] * a[i, i]
            for j in range(i):
                off += a[i, j] * a[i, j]
        if not off > 1e-31 * on:
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
                    one, other = vectors[k, i], vectors[k, j]
                    vectors[k, i], vectors[k, j] = cos * one - sin * other, sin * one + cos * other
                a[i, j] = a[j, i] = 0.0


def factor(a: FloatArray, inverse: FloatArray) -> bool:
    """Fill the inverse of the lower Cholesky factor of a symmetric matrix (N, N).

    False if it is not positive definite. The lower half of `a` is overwritten by the factor.
    """
    N = a.shape[0]
    for j in range(N):
        for i in range(j, N):
            value = a[i, j]
            for k in range(j):
                value -= a[i, k] * a[j, k]
            if i == j:
                if not value > 0:
                    return False
                a[j, j] = np.sqrt(value)
            else:
                a[i, j] = value / a[j, j]
    for j in range(N):
        for i in range(j):
            inverse[i, j] = 0.0
        inverse[j, j] = 1 / a[j, j]
        for i in range(j + 1, N):
            value = 0.0
            for k in range(j, i):
                value -= a[i, k] * inverse[k, j]
            inverse[i, j] = value / a[i, i]
    return True


def congruent(left: FloatArray, a: FloatArray, work: FloatArray, into: FloatArray) -> None:
    """Fill L A L' of a lower triangular L and a symmetric A, (N, N)."""
    N = a.shape[0]
    for i in range(N):
        for j in range(N):
            value = 0.0
            for k in range(j + 1):
                value += a[i, k] * left[j, k]
            work[i, j] = value
    for i in range(N):
        for j in range(i + 1):
            value = 0.0
            for k in range(i + 1):
                value += left[i, k] * work[k, j]
            into[i, j] = into[j, i] = value
