r"""Order 2 of a line whose spline friction holds: harmonic balance with its length fixed.

A spline that slides leaves the line all its modes. One that sticks holds the length
l(q) = g' q + q' G q/2 that it has at rest, so its thrust P(θ) swings with the line:

$$[K + T K_T + \ldots]\, q = f + P\, (g + G q), \qquad g' q + q' G q / 2 = l$$

The second term of the length counts. A line that swings sideways by x is shorter by x' G x/2, in
the mean and at order 4: that draws the spline, and a tension stiffens the line. With the length's
slope at rest alone, order 2 at a resonance is up to 1.6 times too large.

Newton's method solves for orders 0 to 6 of motion and thrust, with their product sampled round
the half turn. Speeds are followed one after the other, upwards. Where the thrust passes ±μ T/r_m,
friction does not hold it.

Source: derived from first principles; forces confirmed by a multibody engine.
"""

import numpy as np

from cardan.core.arrays import BoolArray, ComplexArray, FloatArray, IntArray
from cardan.core.lazy_dataclass import dataclass
from cardan.physics.loads.rubber_mount import MountedLine

HIGHEST_ORDER = 6
"""Of motion and thrust: with 4 a force at resonance is 3 % larger, with 8 the same to 0.1 %."""

HARMONIC_COUNT = HIGHEST_ORDER // 2
COMPONENT_COUNT = 1 + 2 * HARMONIC_COUNT
"""Mean, then real and imaginary part of each order."""

SAMPLES = 8 * HARMONIC_COUNT
"""Of the half turn, at which thrust and length are evaluated."""

_ITERATIONS = 30
"""Of Newton's method: with 16, swings of 80 mm have 10 % less force."""
_LEAST_CHANGE_M = 1e-6
"""m, of any coordinate: Newton's method ends below it."""


def _basis() -> FloatArray:
    """Return what mean, real and imaginary parts are round the half turn, (samples, M)."""
    angles = 2 * np.pi / SAMPLES * np.outer(np.arange(SAMPLES), 1 + np.arange(HARMONIC_COUNT))
    found = np.ones((SAMPLES, COMPONENT_COUNT))
    found[:, 1::2], found[:, 2::2] = np.cos(angles), -np.sin(angles)
    return found


_BASIS = _basis()
_PROJECTION = 2 * _BASIS.T / SAMPLES
_PROJECTION[0] /= 2
_PAIRS = (_PROJECTION[:, None, :] * _BASIS.T).reshape(-1, SAMPLES)


@dataclass(frozen=True, kw_only=True, eq=False)
class StuckLine:
    """Lines whose spline is held, at speeds Q of cases C.

    Attributes
    ----------
    linear : (Q, C, M, N, M, N) N/m
        Stiffness of the line without thrust, of components: mean, then real and imaginary part of
        orders 2, 4 and 6.
    push : (Q, C, M, N) N
        Of the crosses' moments.
    spline : (Q, C, N) 1
        How much the coordinates lengthen the spline.
    geometric : (C, N, N) 1/m
    rest : (Q, C, N) m, compression : (Q, C) N
        Where the spline was caught: the line under its mean loads and this compression.
    """

    linear: FloatArray
    push: FloatArray
    spline: FloatArray
    geometric: FloatArray
    rest: FloatArray
    compression: FloatArray


@dataclass(frozen=True, kw_only=True, eq=False)
class StuckMotion:
    """Motions of lines whose spline is held, cases on leading axes.

    Attributes
    ----------
    coordinates : (..., M, N) m
        Components as `StuckLine` has them.
    compression : (..., M) N
    largest_thrust : (...) N
        Largest compression or tension round the turn.
    is_found : (...)
    """

    coordinates: FloatArray
    compression: FloatArray
    largest_thrust: FloatArray
    is_found: BoolArray


def stiffness_of_orders(
    on: MountedLine, coupling: ComplexArray, *, speed: FloatArray, torque: FloatArray
) -> FloatArray:
    """Return `StuckLine.linear` of a line at a speed rad/s under a torque N m, signed, (...).

    Its order 2 (`coupling` (..., N, N) of 1 N m) ties neighbouring orders.
    """
    N = on.mass.shape[-1]
    S = torque[..., None, None] * coupling / 2
    cases = np.broadcast_shapes(S.shape[:-2], speed.shape)
    Sr, Si = S.real, S.imag
    found = np.zeros((*cases, COMPONENT_COUNT, N, COMPONENT_COUNT, N))
    found[..., 0, :, 0, :] = on.stiffness_under_torque(torque)
    found[..., 0, :, 1, :], found[..., 0, :, 2, :] = -Sr, -Si
    found[..., 1, :, 0, :], found[..., 2, :, 0, :] = -2 * Sr, -2 * Si
    for k in range(1, HARMONIC_COUNT + 1):
        r, i = 2 * k - 1, 2 * k
        D = on.dynamic_stiffness(2 * k * speed, speed, torque)
        found[..., r, :, r, :], found[..., i, :, i, :] = D.real, D.real
        found[..., r, :, i, :], found[..., i, :, r, :] = -D.imag, D.imag
        if k < HARMONIC_COUNT:  # order by order: D q - S q_below - conj(S) q_above
            real, imag = r + 2, i + 2
            found[..., real, :, r, :], found[..., real, :, i, :] = -Sr, Si
            found[..., imag, :, r, :], found[..., imag, :, i, :] = -Si, -Sr
            found[..., r, :, real, :], found[..., r, :, imag, :] = -Sr, -Si
            found[..., i, :, real, :], found[..., i, :, imag, :] = Si, -Sr
    return found


def followed_stuck_motion(line: StuckLine, needed: BoolArray | None = None) -> StuckMotion:
    """Return how lines move whose spline is held, (Q, C), followed up the speeds.

    A tension stiffens the line, so the branch of the larger motion is met from below. Where
    `needed` (Q, C) is False nothing is solved, and nothing is found.
    """
    unit = np.trace(line.linear[0, :, 0, :, 0], axis1=-2, axis2=-1) / line.push.shape[-1]
    unit = np.abs(unit)
    Q, C, M, N = line.push.shape
    X = np.zeros((Q, C, M, N + 1))
    is_found = np.zeros((Q, C), dtype=bool)
    for k in range(Q):
        tried = _starts(X[:k], is_found[:k], _at_rest(line, k, unit))
        some = np.arange(C) if needed is None else np.flatnonzero(needed[k])
        for attempt, start in enumerate(tried):
            if attempt:  # what went before has come to its end
                some = some[(start[some] != tried[attempt - 1][some]).any((1, 2))]
            if len(some):
                X[k, some], is_found[k, some] = _solved(line, k, start[some], unit, some)
                some = some[~is_found[k, some]]
    P = X[..., -1] * unit[:, None]
    return StuckMotion(
        coordinates=X[..., :-1],
        compression=P,
        largest_thrust=np.abs(P @ _BASIS.T).max(-1),
        is_found=is_found,
    )


def _at_rest(line: StuckLine, k: int, unit: FloatArray) -> FloatArray:
    """Return components (C, M, N + 1) of lines at rest: coordinates, and thrust over `unit`."""
    found = np.zeros((len(unit), COMPONENT_COUNT, line.rest.shape[-1] + 1))
    found[:, 0, :-1], found[:, 0, -1] = line.rest[k], line.compression[k] / unit
    return found


def _starts(before: FloatArray, are_found: BoolArray, rest: FloatArray) -> list[FloatArray]:
    """Return where Newton's method begins, components (C, M, N + 1), the best first.

    On from the last two speeds, at the last one, and from lines at rest; `before` (k, C, M, N + 1).
    """
    tried = [rest]
    if len(before):
        tried.insert(0, np.where(are_found[-1][:, None, None], before[-1], rest))
    if len(before) > 1:
        both = (are_found[-1] & are_found[-2])[:, None, None]
        tried.insert(0, np.where(both, 2 * before[-1] - before[-2], tried[0]))
    return tried


def _solved(
    line: StuckLine, k: int, start: FloatArray, unit: FloatArray, cases: IntArray
) -> tuple[FloatArray, BoolArray]:
    """Return components (c, M, N + 1) of `cases` (c,) at speed k by Newton's method.

    And whether they are found.
    """
    X, ok = start.copy(), np.zeros(len(start), dtype=bool)
    some = np.arange(len(start))
    for _ in range(_ITERATIONS):
        own = cases[some]
        with np.errstate(over="ignore", invalid="ignore"):  # where it diverges
            step = _newton_step(line, k, X[some], own, unit[own])
        step = np.nan_to_num(step, nan=1.0, posinf=1.0, neginf=1.0)
        X[some] -= step
        change = np.abs(step).max((1, 2))
        ok[some[change < _LEAST_CHANGE_M]] = True
        some = some[change >= _LEAST_CHANGE_M]
        if not len(some):
            break
    return X, ok


def _newton_step(
    line: StuckLine, k: int, X: FloatArray, some: IntArray, unit: FloatArray
) -> FloatArray:
    """Return what Newton's method takes from components (C, M, N + 1) of `some` cases."""
    cases, M, size = X.shape
    N, G, g, rest = size - 1, line.geometric[some], line.spline[k, some], line.rest[k, some]
    length = (rest * (g + (G @ rest[..., None])[..., 0] / 2)).sum(-1)
    x = _BASIS @ X
    q, P = x[..., :N], x[..., N:] * unit[:, None, None]
    slope = g[:, None] + q @ G
    round_the_turn = np.empty(x.shape)
    round_the_turn[..., :N] = P * slope
    round_the_turn[..., N] = (q * (g[:, None] + slope)).sum(-1) / 2 - length[:, None]
    round_the_turn[..., N] *= unit[:, None]
    linear = line.linear[k, some].reshape(cases, M * N, M * N)
    left = -_PROJECTION @ round_the_turn
    left[..., :N] += (linear @ X[..., :N].reshape(cases, M * N, 1)).reshape(cases, M, N)
    left[..., :N] -= line.push[k, some]
    tangent = np.zeros((cases, SAMPLES, size, size))
    tangent[..., :N, :N] = P[..., None] * G[:, None]
    tangent[..., :N, N] = tangent[..., N, :N] = unit[:, None, None] * slope
    slopes = (_PAIRS @ tangent.reshape(cases, SAMPLES, -1)).reshape(cases, M, M, size, size)
    matrix = -slopes.transpose(0, 1, 3, 2, 4)
    matrix[:, :, :N, :, :N] += line.linear[k, some]
    flat = M * size
    step = np.linalg.solve(matrix.reshape(cases, flat, flat), left.reshape(cases, flat, 1))
    return step.reshape(X.shape).astype(float)
