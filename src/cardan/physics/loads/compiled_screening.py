"""Screening of bearing forces, point by point: compiled where numba is installed.

The same algebra as `BearingForceScreeningModel._some`, which stays the reference: that runs each
step over all points, this all steps over one point, whose few numbers stay in registers and the
first cache. Matrices are eliminated with exchanged rows, so no point needs LAPACK.
"""

from collections.abc import Callable
from math import sqrt
from typing import Any, TypeAlias

import numpy as np

from cardan.core.arrays import BoolArray, ComplexArray, FloatArray
from cardan.core.compiled import compiled
from cardan.physics.loads.compiled_algebra import (
    eliminate,
    eliminate_real,
    fill_dynamic_stiffness,
    half_axis,
)

ScreeningKernel: TypeAlias = Callable[..., bool]

STILL, LOST, GYROSCOPIC, MASS, TORSION = range(5)
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
                        K_T = line[c, STILL, i, j] + T * line[c, TORSION, i, j]
                        still[i, j] = K_T - 0.5 * loose
                    else:
                        still[i, N] = T * values[i] + 0.5 * loose
            solved = eliminate_real(still, N) and solved
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


def screening_kernel() -> ScreeningKernel | None:
    """Return the compiled `screened_sizes`; None without numba."""
    loop: Any = compiled(
        screened_sizes, eliminate, eliminate_real, fill_dynamic_stiffness, half_axis
    )
    return loop
