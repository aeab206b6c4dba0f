"""Response of a line on its mounts, point by point: compiled where numba is installed.

The same algebra as `cardan.physics.loads.frequency_response`, which stays the reference.
"""

from collections.abc import Callable, Sequence
from typing import Any, TypeAlias

import numpy as np

from cardan.core.arrays import ComplexArray, FloatArray
from cardan.core.compiled import compiled
from cardan.physics.loads.compiled_algebra import (
    eliminate,
    eliminate_real,
    fill_bearing_forces,
    fill_dynamic_stiffness,
)

ResponseKernel: TypeAlias = Callable[..., bool]


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
                    still[i, j] = line[c, 0, i, j] + T * line[c, 4, i, j]
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
            solved = eliminate_real(still, N) and solved
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


def balance_kernel() -> ResponseKernel | None:
    """Return the compiled `balanced_motions`; None without numba."""
    loop: Any = compiled(
        balanced_motions, eliminate, eliminate_real, fill_bearing_forces, fill_dynamic_stiffness
    )
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
