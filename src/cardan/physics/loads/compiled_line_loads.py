"""Mean loads, thrust and growth of a line, point by point: loops compiled where numba is installed.

The same algebra as `rotate_chain`, `joint_loads`, `spline_thrust` and `parametric_instability`,
which stay the reference. What loops call is in their own file: numba's cache looks at no other.
"""

from collections.abc import Callable
from typing import Any, TypeAlias

import numpy as np

from cardan.core.arrays import BoolArray, ComplexArray, FloatArray
from cardan.core.compiled import compiled

LineKernel: TypeAlias = Callable[..., bool]
"""A compiled loop; False if a line is none, as where a joint locks."""

JACOBI_SWEEPS = 30
"""Sweeps at most; a matrix of four rows takes four or five."""


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
                fill_shaft_frame(u, slopes[k], F)
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
        thrust = low if low > 0 else 0.0
        thrust = high if high < thrust else thrust
        for _ in range(iterations):
            off, gives = lengthening[c], 0.0
            for k in range(N):
                left = 1 - thrust * softening[c, k]
                moved = (load[c, k] + thrust * spline[c, k]) / left
                off -= moved * (spline[c, k] + softening[c, k] * moved / 2)
                slope = spline[c, k] + softening[c, k] * moved
                gives += slope * slope / left
            if off > 0:
                low = thrust
            if off < 0:
                high = thrust
            guess = thrust + off / gives
            if not low <= guess <= high:
                guess = (low + high) / 2
            step = abs(guess - thrust)
            thrust = guess
            if not step > 1e-13 * (1 + abs(thrust)):
                break
        found[c] = thrust


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
                    fill_shaft_frame(directions[c, k], slopes[k], pin)
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


def fill_shaft_frame(direction: FloatArray, slope: complex, frame: ComplexArray) -> None:
    """Fill the frame across a member, (3,) complex, as `ChainRotation.frames` has it."""
    frame[0] = -slope * (1 + direction[0])
    frame[1] = 1 - slope * direction[1]
    frame[2] = complex(0.0, -1.0) - slope * direction[2]


def cross(a: Any, b: Any, into: Any) -> None:
    """Fill the cross product a x b (3,), real or complex."""
    into[0] = a[1] * b[2] - a[2] * b[1]
    into[1] = a[2] * b[0] - a[0] * b[2]
    into[2] = a[0] * b[1] - a[1] * b[0]


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


def mean_loads_kernel() -> LineKernel | None:
    """Return the compiled `mean_loads`; None without numba."""
    loop: Any = compiled(mean_loads, cross, fill_shaft_frame, rotate_one_chain)
    return loop


def buckling_kernel() -> LineKernel | None:
    """Return the compiled `buckling_modes`; None without numba."""
    loop: Any = compiled(buckling_modes, congruent, diagonalise, factor)
    return loop


def compression_kernel() -> LineKernel | None:
    """Return the compiled `held_compressions`; None without numba."""
    loop: Any = compiled(held_compressions)
    return loop


def growth_kernel() -> LineKernel | None:
    """Return the compiled `pair_growths`; None without numba."""
    loop: Any = compiled(
        pair_growths, congruent, cross, diagonalise, factor, fill_shaft_frame, rotate_one_chain
    )
    return loop
