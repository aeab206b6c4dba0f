"""Response of a line on its mounts, point by point: loops compiled where numba is installed.

The same algebra as `cardan.physics.loads.frequency_response` and `BearingForceScreeningModel`,
which stay the reference: these run each step over all points, this all steps over one point,
whose few numbers stay in registers and the first cache. Matrices are eliminated with exchanged
rows, so no point needs LAPACK. What loops call is in their own file: numba's cache reads no other.
"""

from collections.abc import Callable, Sequence
from math import sqrt
from typing import Any, TypeAlias

import numpy as np

from cardan.core.arrays import BoolArray, ComplexArray, FloatArray
from cardan.core.compiled import compiled

ResponseKernel: TypeAlias = Callable[..., bool]
"""A compiled loop; False if a matrix is singular."""

STIFFNESS, LOSS, GYROSCOPIC, MASS, TORSION = range(5)
"""Places of the matrices of `DynamicStiffness` in `line`."""


def screened_sizes(
    line: FloatArray,
    ride: FloatArray,
    bearing: FloatArray,
    springs: FloatArray,
    unbalance: ComplexArray,
    approach: FloatArray,
    thrust: FloatArray,
    points: FloatArray,
    there: BoolArray,
    kinds: BoolArray,
    sizes: FloatArray,
) -> bool:
    """Fill the sizes of P points in each of C cases, False if a matrix is singular.

    Parameters
    ----------
    line : (C, 5, N, N)
        Matrices of `DynamicStiffness`.
    ride : (C, K, M)
        Coefficients of 1, x, x², y, y² and xy of what follows a ride (x, y), one after the other:
        order 0 on the coordinates (N); order 2 there, real and imaginary, and what each N m adds
        to both (4 N); its coupling likewise (4 N²); orders 0 and 2 on the bearings (5 B); weight
        (B); distance to obstacles (R).
    bearing : (C, B, N)
    springs : (C, 3, B) N/m, 1, m/N
        Stiffness, loss factor and compliance of the rubber.
    unbalance : (C, N, E)
        E is 0 where unbalance does not count.
    approach : (C, R, N)
    thrust : (C, 2, 2, B + B/3 + 1 + N)
        Of the torque ahead and astern, pushed in and drawn out: force, compression, that of the
        state's own place, and what it moves. (C, 0, 0, 0) where thrust does not count.
    points : (5, P, C) N m, rad/s, 1, 1, N
        Torque, speed, ride and slip force.
    there : (P, C)
        Which points exist; others are nan.
    kinds : (kinds,)
        Forces where False, travel of the rubber where True.
    sizes : (X, P, C)
        Filled: mean, orders and peak on each bearing of each kind, then the reach.
    """
    N, B, R, E = line.shape[2], bearing.shape[1], approach.shape[1], unbalance.shape[2]
    K, M, ways = ride.shape[1], ride.shape[2], thrust.shape[2]
    P, C = there.shape
    bearings = B // 3
    at_order2, at_coupling = N, 5 * N
    at_borne = at_coupling + 4 * N * N
    at_weight, at_clearance = at_borne + 5 * B, at_borne + 6 * B
    values = np.empty(M)
    coupling, back = np.empty((N, N), np.complex128), np.empty((N, N), np.complex128)
    above, second = np.empty((N, 2 * N), np.complex128), np.empty((N, 2 * N + 1), np.complex128)
    first, still = np.empty((N, N + E), np.complex128), np.empty((N, N + 1))
    q0, q2, q4 = np.empty(N), np.empty(N, np.complex128), np.empty(N, np.complex128)
    twice, fourth = np.empty(B, np.complex128), np.empty(B, np.complex128)
    off, mean, force = np.empty((B, E), np.complex128), np.empty(B), np.empty(B, np.complex128)
    rest, drawn = np.empty(B), np.zeros((max(ways, 1), B))
    for c in range(C):
        for p in range(P):
            if not there[p, c]:
                for k in range(sizes.shape[0]):
                    sizes[k, p, c] = np.nan
                continue
            T, omega = points[0, p, c], points[1, p, c]
            x, y, slip = points[2, p, c], points[3, p, c], points[4, p, c]
            same = -1
            for k in range(p):
                if (
                    points[0, k, c] == T
                    and points[1, k, c] == omega
                    and points[2, k, c] == x
                    and points[3, k, c] == y
                    and points[4, k, c] == slip
                    and there[k, c]
                ):
                    same = k
                    break
            if same >= 0:
                for k in range(sizes.shape[0]):
                    sizes[k, p, c] = sizes[k, same, c]
                continue
            for m in range(M):
                values[m] = ride[c, 0, m]
            if K >= 3:
                xx = x * x
                for m in range(M):
                    values[m] += x * ride[c, 1, m] + xx * ride[c, 2, m]
            if K >= 6:
                xy, yy = x * y, y * y
                for m in range(M):
                    values[m] += y * ride[c, 3, m] + yy * ride[c, 4, m] + xy * ride[c, 5, m]
            for i in range(N):
                for j in range(N):
                    k = at_coupling + i * N + j
                    real = T * (values[k] + T * values[k + 2 * N * N])
                    imag = T * (values[k + N * N] + T * values[k + 3 * N * N])
                    coupling[i, j] = complex(real, imag)
                    back[i, j] = complex(real, -imag)
            # Order 4 follows order 2, which both follow where the line lies.
            fill_dynamic_stiffness(above, line[c], 4 * omega, omega, T)
            for i in range(N):
                for j in range(N):
                    above[i, N + j] = coupling[i, j]
            solved = eliminate(above, N)
            fill_dynamic_stiffness(second, line[c], 2 * omega, omega, T)
            for i in range(N):
                for j in range(N):
                    found = 0j
                    for k in range(N):
                        found += back[i, k] * above[k, N + j]
                    second[i, j] -= 0.25 * found
                    second[i, N + j] = coupling[i, j]
                k = at_order2 + i
                second[i, 2 * N] = complex(
                    T * (values[k] + T * values[k + 2 * N]),
                    T * (values[k + N] + T * values[k + 3 * N]),
                )
            solved = eliminate(second, N) and solved
            for i in range(N):
                for j in range(N + 1):
                    loose = 0.0
                    for k in range(N):
                        tied = second[k, N + j]
                        loose += back[i, k].real * tied.real - back[i, k].imag * tied.imag
                    if j < N:
                        K_T = line[c, STIFFNESS, i, j] + T * line[c, TORSION, i, j]
                        still[i, j] = K_T - 0.5 * loose
                    else:
                        still[i, N] = T * values[i] + 0.5 * loose
            solved = eliminate(still, N) and solved
            for i in range(N):
                q0[i] = still[i, N]
            for i in range(N):
                moved = second[i, 2 * N]
                for j in range(N):
                    moved += second[i, N + j] * q0[j]
                q2[i] = moved
            for i in range(N):
                moved = 0j
                for j in range(N):
                    moved += above[i, N + j] * q2[j]
                q4[i] = 0.5 * moved
            if E:
                fill_dynamic_stiffness(first, line[c], omega, omega, T)
                for i in range(N):
                    for j in range(E):
                        first[i, N + j] = omega * omega * unbalance[c, i, j]
                solved = eliminate(first, N) and solved
            if not solved:
                return False
            for b in range(B):
                lies, moves, goes = 0.0, 0j, 0j
                for i in range(N):
                    lies += bearing[c, b, i] * q0[i]
                    moves += bearing[c, b, i] * q2[i]
                    goes += bearing[c, b, i] * q4[i]
                rest[b], twice[b], fourth[b] = lies, moves, goes
                for j in range(E):
                    moved = 0j
                    for i in range(N):
                        moved += bearing[c, b, i] * first[i, N + j]
                    off[b, j] = moved
            ahead = 0 if T >= 0 else 1
            for way in range(ways):
                for b in range(B):
                    size = abs(thrust[c, ahead, way, B + b // 3])
                    share = slip / (size if size > 0 else 1.0)
                    share = 1.0 if share > 1 else share
                    drawn[way, b] = thrust[c, ahead, way, b] * share
            at = 0
            sign = 1.0 if omega > 0 else (-1.0 if omega < 0 else 0.0)
            for travel in kinds:
                for b in range(B):
                    soft = springs[c, 2, b] if travel else 1.0
                    weight = 0.0 if travel else values[at_weight + b]
                    mean[b] = (
                        soft * T * values[at_borne + b] + weight + soft * springs[c, 0, b] * rest[b]
                    )
                for n in range(bearings):
                    static = 0.0
                    for way in range(-1, ways):
                        square = 0.0
                        for b in range(3 * n, 3 * n + 3):
                            soft = springs[c, 2, b] if travel else 1.0
                            all_ = mean[b] + (soft * drawn[way, b] if way >= 0 else 0.0)
                            square += all_ * all_
                        size = sqrt(square)
                        static = size if size > static or size != size else static
                    for b in range(3 * n, 3 * n + 3):
                        soft = springs[c, 2, b] if travel else 1.0
                        k = at_borne + B + b
                        real = T * (values[k] + T * values[k + 2 * B])
                        imag = T * (values[k + B] + T * values[k + 3 * B])
                        stiff = soft * springs[c, 0, b]
                        firm = complex(stiff, 0.0 if travel else stiff * sign * springs[c, 1, b])
                        force[b] = soft * complex(real, imag) + firm * twice[b]
                    dynamic = half_axis(force[3 * n], force[3 * n + 1], force[3 * n + 2])
                    for b in range(3 * n, 3 * n + 3):
                        stiff = springs[c, 0, b] * (springs[c, 2, b] if travel else 1.0)
                        firm = complex(stiff, 0.0 if travel else stiff * sign * springs[c, 1, b])
                        force[b] = firm * fourth[b]
                    dynamic += half_axis(force[3 * n], force[3 * n + 1], force[3 * n + 2])
                    peak = static + dynamic
                    for j in range(E):
                        for b in range(3 * n, 3 * n + 3):
                            stiff = springs[c, 0, b] * (springs[c, 2, b] if travel else 1.0)
                            firm = complex(
                                stiff, 0.0 if travel else stiff * sign * springs[c, 1, b]
                            )
                            force[b] = firm * off[b, j]
                        peak += half_axis(force[3 * n], force[3 * n + 1], force[3 * n + 2])
                    sizes[at + n, p, c] = static
                    sizes[at + bearings + n, p, c] = dynamic
                    sizes[at + 2 * bearings + n, p, c] = peak
                at += 3 * bearings
            own = B + bearings
            for r in range(R):
                lies, moves, goes = -values[at_clearance + r], 0j, 0j
                for i in range(N):
                    lies += approach[c, r, i] * q0[i]
                    moves += approach[c, r, i] * q2[i]
                    goes += approach[c, r, i] * q4[i]
                further = 0.0
                for way in range(ways):
                    size = abs(thrust[c, ahead, way, own])
                    share = slip / (size if size > 0 else 1.0)
                    share = 1.0 if share > 1 else share
                    gone = 0.0
                    for i in range(N):
                        gone += approach[c, r, i] * thrust[c, ahead, way, own + 1 + i] * share
                    further = gone if gone > further or gone != gone else further
                lies += further + abs(moves) + abs(goes)
                for j in range(E):
                    moved = 0j
                    for i in range(N):
                        moved += approach[c, r, i] * first[i, N + j]
                    lies += abs(moved)
                sizes[at + r, p, c] = lies
    return True


def balanced_motions(
    line: FloatArray,
    bearing: FloatArray,
    springs: FloatArray,
    frame: FloatArray,
    forces: ComplexArray,
    pushed: ComplexArray,
    felt: ComplexArray,
    points: FloatArray,
    moved: ComplexArray,
    carried: ComplexArray,
) -> bool:
    """Fill motions of orders 0, 2 and 4 of P points in C cases, False if a matrix is singular.

    As `MountedLine.harmonic_balance` with two factors of the coupling.

    Parameters
    ----------
    line : (C, 5, N, N)
        Matrices of `DynamicStiffness`.
    bearing, springs, frame : (C, B, N), (C, 2, B) N/m and 1, (C, B/3, 9)
        Motion of the bearings, stiffness and loss factor of their rubber, their directions.
    forces : (3, P, C, N) N
        Of orders 0, 2 and 4 where nothing has moved.
    pushed, felt : (P, C, n, N)
        `MountedLine.order2_coupling_factors`, of 1 N m.
    points : (2, P, C) rad/s, N m
        Speed and torque, signed.
    moved : (3, P, C, N) m
        Filled: coordinates at each order.
    carried : (3, P, C, B/3, 3) N
        Filled: forces of the shafts on their bearings.
    """
    N, n = line.shape[2], pushed.shape[2]
    _, P, C = points.shape
    left, right = np.empty((N, n), np.complex128), np.empty((n, N), np.complex128)
    above = np.empty((N, N + n + 1), np.complex128)
    second = np.empty((N, N + n + 1), np.complex128)
    own = np.empty((n, n + 1), np.complex128)
    still = np.empty((N, N + 1))
    bends = np.empty(n, np.complex128)
    for c in range(C):
        for p in range(P):
            omega, T = points[0, p, c], points[1, p, c]
            for k in range(n):
                for i in range(N):
                    left[i, k] = T * pushed[p, c, k, i]
                    right[k, i] = felt[p, c, k, i]
            fill_dynamic_stiffness(above, line[c], 4 * omega, omega, T)
            for i in range(N):
                for k in range(n):
                    above[i, N + k] = left[i, k]
                above[i, N + n] = forces[2, p, c, i]
            solved = eliminate(above, N)
            # What a motion at order 4 does at order 2, by way of `left`.
            for k in range(n):
                for m in range(n + 1):
                    found = 0j
                    for i in range(N):
                        found += right[k, i].conjugate() * above[i, N + m]
                    own[k, m] = found / 2
            fill_dynamic_stiffness(second, line[c], 2 * omega, omega, T)
            for i in range(N):
                pull = forces[1, p, c, i]
                for k in range(n):
                    second[i, N + k] = left[i, k]
                    pull += left[i, k].conjugate() * own[k, n]
                second[i, N + n] = pull
                for m in range(n):
                    found = 0j
                    for k in range(n):
                        found += left[i, k].conjugate() * own[k, m]
                    found = found / 2
                    for j in range(N):
                        second[i, j] -= found * right[m, j]
            solved = eliminate(second, N) and solved
            for k in range(n):
                for m in range(n + 1):
                    found = 0j
                    for i in range(N):
                        found += right[k, i].conjugate() * second[i, N + m]
                    own[k, m] = found / 2
            for i in range(N):
                for j in range(N):
                    still[i, j] = line[c, STIFFNESS, i, j] + T * line[c, TORSION, i, j]
                pull = forces[0, p, c, i]
                for k in range(n):
                    pull += left[i, k].conjugate() * own[k, n]
                still[i, N] = pull.real
                for m in range(n):
                    found = 0j
                    for k in range(n):
                        found += left[i, k].conjugate() * own[k, m]
                    for j in range(N):
                        still[i, j] -= found.real * right[m, j].real - found.imag * right[m, j].imag
            solved = eliminate(still, N) and solved
            if not solved:
                return False
            for k in range(n):
                found = 0j
                for i in range(N):
                    found += right[k, i] * still[i, N]
                bends[k] = found
            for i in range(N):
                found = second[i, N + n]
                for k in range(n):
                    found += second[i, N + k] * bends[k]
                moved[0, p, c, i], moved[1, p, c, i] = still[i, N], found
            for k in range(n):
                found = 0j
                for i in range(N):
                    found += right[k, i] * moved[1, p, c, i]
                bends[k] = found
            for i in range(N):
                found = above[i, N + n]
                for k in range(n):
                    found += above[i, N + k] * bends[k] / 2
                moved[2, p, c, i] = found
            sign = 1.0 if omega > 0 else (-1.0 if omega < 0 else 0.0)
            for order in range(3):
                fill_bearing_forces(
                    carried[order, p, c],
                    moved[order, p, c],
                    bearing[c],
                    springs[c],
                    frame[c],
                    sign if order else 0.0,
                )
    return True


def responses(
    line: FloatArray,
    bearing: FloatArray,
    springs: FloatArray,
    frame: FloatArray,
    forces: ComplexArray,
    points: FloatArray,
    moved: ComplexArray,
    carried: ComplexArray,
) -> bool:
    """Fill how R forces by themselves move P points in C cases, False if a matrix is singular.

    As `MountedLine.response_to_each`: forces (P, C, R, N), points (3, P, C) of frequency, speed and
    torque, motions (P, C, R, N), bearing forces (P, C, R, B/3, 3). Others as `balanced_motions`.
    """
    N, R = line.shape[2], forces.shape[2]
    _, P, C = points.shape
    whole = np.empty((N, N + R), np.complex128)
    for c in range(C):
        for p in range(P):
            W = points[0, p, c]
            fill_dynamic_stiffness(whole, line[c], W, points[1, p, c], points[2, p, c])
            for r in range(R):
                for i in range(N):
                    whole[i, N + r] = forces[p, c, r, i]
            if not eliminate(whole, N):
                return False
            sign = 1.0 if W > 0 else (-1.0 if W < 0 else 0.0)
            for r in range(R):
                for i in range(N):
                    moved[p, c, r, i] = whole[i, N + r]
                fill_bearing_forces(
                    carried[p, c, r], moved[p, c, r], bearing[c], springs[c], frame[c], sign
                )
    return True


def eliminate(a: ComplexArray | FloatArray, n: int) -> bool:
    """Solve a (n, n + m) system in place by Gauss with exchanged rows.

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
            real = line[STIFFNESS, i, j] + torque * line[TORSION, i, j] - square * line[MASS, i, j]
            imag = sign * line[LOSS, i, j] + turning * line[GYROSCOPIC, i, j]
            into[i, j] = complex(real, imag)


def half_axis(x: complex, y: complex, z: complex) -> float:
    """Return the longer half axis of the ellipse Re c e^{iφ} of c = (x, y, z)."""
    size2 = (
        x.real * x.real + x.imag * x.imag
        + y.real * y.real + y.imag * y.imag
        + z.real * z.real + z.imag * z.imag
    )  # fmt: skip
    skew = x * x + y * y + z * z
    return sqrt((size2 + sqrt(skew.real * skew.real + skew.imag * skew.imag)) / 2)


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


def screening_kernel() -> ResponseKernel | None:
    """Return the compiled `screened_sizes`; None without numba."""
    loop: Any = compiled(screened_sizes, eliminate, fill_dynamic_stiffness, half_axis)
    return loop


def balance_kernel() -> ResponseKernel | None:
    """Return the compiled `balanced_motions`; None without numba."""
    loop: Any = compiled(balanced_motions, eliminate, fill_bearing_forces, fill_dynamic_stiffness)
    return loop


def response_kernel() -> ResponseKernel | None:
    """Return the compiled `responses`; None without numba."""
    loop: Any = compiled(responses, eliminate, fill_bearing_forces, fill_dynamic_stiffness)
    return loop


def balanced_motions_by_loop(
    kernel: ResponseKernel,
    tables: Sequence[FloatArray],
    lead: tuple[int, ...],
    forces: Sequence[ComplexArray | FloatArray],
    coupling: tuple[ComplexArray, ComplexArray],
    speed_and_torque: tuple[FloatArray, FloatArray],
    *,
    points: int,
) -> tuple[ComplexArray, ComplexArray]:
    """Return coordinates (3, ..., N) m and bearing forces (3, ..., B/3, 3) N of a kernel.

    Parameters
    ----------
    tables
        `line`, `bearing`, `springs` and `frame` of `balanced_motions`.
    lead, points
        Shape (...) of points and cases, and how many points of each case that has.
    forces, coupling, speed_and_torque
        As `MountedLine.harmonic_balance` has them; they broadcast to (...).

    Raises
    ------
    LinAlgError
        If a matrix is singular.
    """
    N, shape = tables[0].shape[-1], (points, len(tables[0]))
    bearings = tables[1].shape[1] // 3
    given = np.empty((3, *lead, N), dtype=complex)
    for into, f in zip(given, forces, strict=True):
        into[...] = f
    ties = [np.broadcast_to(t, (*lead, *t.shape[-2:])) for t in coupling]
    moved = np.empty((3, *shape, N), dtype=complex)
    carried = np.empty((3, *shape, bearings, 3), dtype=complex)
    solved = kernel(
        *tables,
        given.reshape(moved.shape),
        *(np.ascontiguousarray(t).reshape(*shape, *t.shape[-2:]) for t in ties),
        np.stack([np.broadcast_to(v, lead) for v in speed_and_torque]).reshape(2, *shape),
        moved,
        carried,
    )
    raise_if_singular(solved)
    return moved.reshape(3, *lead, N), carried.reshape(3, *lead, bearings, 3)


def responses_by_loop(
    kernel: ResponseKernel,
    tables: Sequence[FloatArray],
    lead: tuple[int, ...],
    forces: ComplexArray,
    frequency_speed_torque: tuple[FloatArray, FloatArray, FloatArray],
    *,
    points: int,
) -> tuple[ComplexArray, ComplexArray]:
    """Return coordinates (..., R, N) m and bearing forces (..., R, B/3, 3) N of a kernel.

    As `balanced_motions_by_loop`, of `responses`.
    """
    each, shape = forces.shape[-2:], (points, len(tables[0]))
    bearings = tables[1].shape[1] // 3
    right = np.ascontiguousarray(np.broadcast_to(forces, (*lead, *each)))
    moved = np.empty((*shape, *each), dtype=complex)
    carried = np.empty((*shape, each[0], bearings, 3), dtype=complex)
    solved = kernel(
        *tables,
        right.reshape(moved.shape),
        np.stack([np.broadcast_to(v, lead) for v in frequency_speed_torque]).reshape(3, *shape),
        moved,
        carried,
    )
    raise_if_singular(solved)
    return moved.reshape(*lead, *each), carried.reshape(*lead, each[0], bearings, 3)


def raise_if_singular(solved: bool) -> None:  # noqa: FBT001  what a kernel returns
    """Raise `LinAlgError` where a kernel met a singular matrix, as LAPACK does."""
    if not solved:
        msg = "Singular matrix"
        raise np.linalg.LinAlgError(msg)
