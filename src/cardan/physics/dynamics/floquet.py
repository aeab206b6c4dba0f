r"""Linear mechanical systems whose coefficients repeat: their stability.

$$M(t)\,\ddot q + C(t)\,\dot q + K(t)\,q = f(t),\qquad\text{period } T$$

is the equation of everything a universal joint shakes. What this module knows of it:

    monodromy           one period on a state; `floquet_multipliers`, `growth_rate`
    hill_determinant    the same stability without integrating in time: `hill_multipliers`
    in chunks           a function of parameters over many points, on all cores

Cases stand on leading axes. Coefficients are given as functions of the *phase* t/T, so one
function serves every speed.
Sources: Floquet (1883); Hill, Acta Math. 8 (1886); the steps in time are Gauss's implicit
Runge-Kutta method of order 20, Hairer, Norsett & Wanner, Solving ODEs I (1993), II.7.
"""

from collections.abc import Callable
from concurrent.futures import Executor
from dataclasses import dataclass
from functools import cache
from itertools import pairwise
from typing import Any, TypeAlias

import numpy as np

from cardan.core.arrays import ArrayLike, ComplexArray, FloatArray, in_chunks, single_threaded_blas
from cardan.core.errors import ConvergenceError

PeriodicMatrices: TypeAlias = Callable[[FloatArray], tuple[FloatArray, FloatArray, FloatArray]]
"""A function of phases t/T (s,) that returns M, C and K, each broadcasting to (..., s, m, m)."""


@dataclass(frozen=True, slots=True, kw_only=True)
class PeriodicSystem:
    """M(t) q'' + C(t) q' + K(t) q = f(t) with m coordinates and period T.

    Attributes
    ----------
    period : (...) s
        T, of each case.
    matrices
        M, C and K at given phases; SI units of whatever the coordinates are. One that is
        constant may come as (m, m).
    """

    period: FloatArray
    matrices: PeriodicMatrices

    def scaled_matrices(self, phase: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return T M⁻¹C and T² M⁻¹K, each (..., s or 1, m, m): a period counts as 1."""
        M, C, K = self.matrices(phase)
        inverse = _inverse(M)
        T = np.asarray(self.period, dtype=float)[..., None, None, None]
        return T * (inverse @ C), T**2 * (inverse @ K)


def _inverse(M: FloatArray) -> FloatArray:
    """Invert mass matrices; one or two coordinates by hand, which is ten times quicker."""
    if M.shape[-1] == 1:
        return np.reciprocal(M)
    if M.shape[-1] == 2:
        a, b, c, d = M[..., 0, 0], M[..., 0, 1], M[..., 1, 0], M[..., 1, 1]
        adjugate = np.stack([d, -b, -c, a], axis=-1).reshape(M.shape)
        return adjugate / (a * d - b * c)[..., None, None]
    return np.asarray(np.linalg.inv(M), np.float64)


# ----- in time: the monodromy matrix ----------------------------------------------------

_STAGES = (7, 10)
"""Gauss nodes a step: a trial and the answer, whose difference is the trial's error."""

_MOST_STEPS = 1 << 13


def eigenvalues(matrix: FloatArray | ComplexArray) -> ComplexArray:
    """Return the eigenvalues (..., n) of matrices (..., n, n), complex even where all are real.

    They are nan for a matrix that is not finite, of an unsolved case.
    """
    known = np.asarray(np.isfinite(matrix).all((-1, -2)))
    found = np.linalg.eigvals(np.where(known[..., None, None], matrix, 0.0))
    return np.where(known[..., None], found, np.nan).astype(np.complex128)


def _size(matrix: FloatArray) -> FloatArray:
    """Return the largest absolute row sum, over rows and instants."""
    return np.abs(matrix).sum(-1).max((-1, -2))


@cache
def _gauss(stages: int) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Nodes, weights and matrix of Gauss's implicit Runge-Kutta method on [0, 1]."""
    legendre = np.polynomial.legendre
    x, weight = legendre.leggauss(stages)
    value = legendre.legvander(x, stages)
    j = np.arange(1, stages)
    # The integral of P_j from -1 is (P_j+1 - P_j-1) / (2j + 1).
    integral = np.empty((stages, stages))
    integral[:, 0] = x + 1
    integral[:, 1:] = (value[:, 2:] - value[:, :-2]) / (2 * j + 1)
    return (x + 1) / 2, weight / 2, integral @ np.linalg.inv(value[:, :-1]) / 2


def _steps(system: PeriodicSystem, scale: FloatArray, count: int, stages: int) -> FloatArray:
    """Return the propagators (..., count, 2m, 2m) of equal steps through one period.

    States are (q, q' / scale) with a period as unit of time. The unknowns are the
    accelerations at the nodes, so a step costs one solve of size stages times m.
    """
    x, weight, A = _gauss(stages)
    given = system.scaled_matrices(((np.arange(count)[:, None] + x) / count).ravel())
    m = given[1].shape[-1]
    shape = np.broadcast_shapes(*(part.shape[:-3] for part in given), scale.shape)
    C, K = (
        np.broadcast_to(part, (*shape, count * stages, m, m)).reshape(*shape, count, stages, m, m)
        for part in (given[0] / count, given[1] / count**2)
    )
    # Row (node, coordinate), column (node, coordinate).
    left = K[..., None, :] * (A @ A)[:, None, :, None]
    left += C[..., None, :] * A[:, None, :, None]
    left = left.reshape(*shape, count, stages * m, stages * m)
    left += np.eye(stages * m)
    right = np.concatenate([-K, -C - x[:, None, None] * K], axis=-1)
    acceleration = np.linalg.solve(left, right.reshape(*shape, count, stages * m, 2 * m))
    acceleration = acceleration.reshape(*shape, count, stages, m * 2 * m)
    gained = np.stack([weight @ A, weight]) @ acceleration
    P = gained.reshape(*shape, count, 2 * m, 2 * m)
    speed = np.broadcast_to(scale, shape)[..., None, None, None] / count
    one = np.eye(m)
    P[..., :m, :m] += one
    P[..., :m, m:] = speed * (P[..., :m, m:] + one)
    P[..., m:, :m] /= speed
    P[..., m:, m:] += one
    return P


def _product(steps: FloatArray) -> FloatArray:
    """Multiply a power of two of steps, later ones from the left, pair by pair."""
    while steps.shape[-3] > 1:
        steps = steps[..., 1::2, :, :] @ steps[..., 0::2, :, :]
    return steps[..., 0, :, :]


@single_threaded_blas()
def _settled(system: PeriodicSystem, tolerance: float) -> tuple[FloatArray, FloatArray, int]:
    """Return the monodromy in scaled states, the scale, and the steps it took."""
    C, K = system.scaled_matrices(np.arange(8) / 8)
    scale = np.maximum(np.sqrt(_size(K)), 1.0)
    cases = np.broadcast_shapes(scale.shape, np.shape(system.period))
    scale, rates = np.broadcast_to(scale, cases), np.broadcast_to(_size(C), cases)
    known = np.isfinite(scale) & np.isfinite(rates)
    fastest = float(np.maximum(scale, rates).max(where=known, initial=1.0))
    if not known.any():
        msg = "the coefficients are not finite (a massless coordinate, or a speed of 0?)"
        raise ValueError(msg)
    count = 1 << max(0, int(np.ceil(np.log2(fastest / 4))))
    while count <= _MOST_STEPS:
        trial, found = (_product(_steps(system, scale, count, stages)) for stages in _STAGES)
        off = np.abs(found - trial).max((-1, -2))
        # Three nodes more gain at least three digits; two are counted on.
        settled = off <= 100 * tolerance * np.maximum(np.abs(found).max((-1, -2)), 1.0)
        if np.all(settled | ~known):
            return found, scale, count
        count *= 2
    msg = f"the monodromy matrix has not settled to {tolerance:g} in {_MOST_STEPS} steps a period"
    raise ConvergenceError(msg)


def monodromy_matrix(system: PeriodicSystem, *, tolerance: float = 1e-10) -> FloatArray:
    """Return what one period makes of a state (q, q').

    Parameters
    ----------
    system
        Its matrices, cases on leading axes.
    tolerance : 1
        Largest error of an entry, over the largest entry of its matrix (entries made
        comparable by a speed scale). Steps are halved until all cases reach it, but not
        below what rounding allows.

    Returns
    -------
    (..., 2m, 2m)
        State after a period over state before; nan in cases whose coefficients are, next to
        others: one without a solution ends nothing.

    Raises
    ------
    ConvergenceError
        If 8192 steps a period are not enough.
    """
    found, scale, _ = _settled(system, tolerance)
    m = found.shape[-1] // 2
    # From (q, q' T / scale) back to (q, q').
    factor = (scale / np.asarray(system.period))[..., None, None]
    P = found.copy()
    P[..., :m, m:] /= factor
    P[..., m:, :m] *= factor
    return P


def floquet_multipliers(system: PeriodicSystem, *, tolerance: float = 1e-10) -> ComplexArray:
    """Floquet multipliers, (..., 2m): eigenvalues of the monodromy matrix."""
    return eigenvalues(_settled(system, tolerance)[0])


def growth_rate(system: PeriodicSystem, *, tolerance: float = 1e-10) -> FloatArray:
    """Fastest growth rate of a free motion, (...) 1/s: above 0 the system is unstable.

    Without damping a stable system returns 0 to within the rounding of a double
    multiplier, about the square root of `tolerance`.
    """
    largest = np.abs(floquet_multipliers(system, tolerance=tolerance)).max(-1)
    return np.log(largest) / np.asarray(system.period)


# ----- in frequency: Hill's infinite determinant ----------------------------------------


def _harmonics(system: PeriodicSystem, samples: int = 256) -> tuple[ComplexArray, ComplexArray]:
    """Fourier coefficients of the scaled C and K, (..., samples, m, m), in FFT order."""
    C, K = system.scaled_matrices(np.arange(samples) / samples)
    shape = np.broadcast_shapes(C.shape, K.shape, (samples, 1, 1))

    def spectrum(part: FloatArray) -> ComplexArray:
        whole = np.broadcast_to(part, shape)
        return np.asarray(np.fft.fft(whole, axis=-3) / samples, np.complex128)

    return spectrum(C), spectrum(K)


def _hill(C: ComplexArray, K: ComplexArray, s: ComplexArray, N: int) -> ComplexArray:
    """Return the determinant of the Hill matrix of harmonics -N..N over that of its mean system."""
    k = np.arange(-N, N + 1)
    shift = k[:, None] - k
    rate = s[..., None] + 2j * np.pi * k
    one = np.eye(C.shape[-1])
    # Block (k, l) acts on harmonic l and answers in harmonic k.
    H = C[..., shift, :, :] * rate[..., None, :, None, None] + K[..., shift, :, :]
    H[..., np.arange(k.size), np.arange(k.size), :, :] += rate[..., None, None] ** 2 * one
    mean = H[..., np.arange(k.size), np.arange(k.size), :, :]
    even = np.linalg.inv(mean)[..., :, None, :, :] @ H
    m, n = C.shape[-1], k.size
    even = np.moveaxis(even, -2, -3).reshape(*even.shape[:-4], n * m, n * m)
    return np.linalg.det(even)


def hill_determinant(system: PeriodicSystem, exponent: ArrayLike) -> ComplexArray:
    r"""Hill's infinite determinant, in the form that converges.

    $$\Delta(\lambda) = \lim_{N\to\infty}
      \frac{\det\,[(\lambda+ik\omega)^2\delta_{kl} + (\lambda+il\omega)\,\hat C_{k-l}
      + \hat K_{k-l}]_{-N}^{N}}{\prod_k \det[(\lambda+ik\omega)^2 + (\lambda+ik\omega)\hat C_0
      + \hat K_0]}
      = \frac{\det(e^{\lambda T} - P)}{\det(e^{\lambda T} - e^{A_0 T})}$$

    with the harmonics of M⁻¹C and M⁻¹K. Dividing by the mean system (A₀) makes it converge;
    both sides have the same zeros, poles and period, and tend to 1, so they are equal: P
    is the monodromy matrix, found here without a step in time.

    Parameters
    ----------
    system
        Cases on leading axes.
    exponent : (...) 1/s, complex
        λ; broadcasts against the cases. Must not be an exponent of the mean system.

    Returns
    -------
    (...) 1
        Δ(λ), zero where λ is a Floquet exponent. The finite determinants of harmonics up
        to 12 ... 60 are extrapolated: the tail is a power series in 1/N.
    """
    C, K = _harmonics(system)
    s: ComplexArray = (np.asarray(exponent) * system.period).astype(complex)
    sizes = (12, 16, 20, 26, 34, 44, 60)
    values = [_hill(C, K, s, N) for N in sizes]
    h = [1 / (N + 0.5) for N in sizes]
    for level in range(1, len(sizes)):  # Neville's scheme, towards h = 0
        values = [
            b + (b - a) * h[i + level] / (h[i] - h[i + level])
            for i, (a, b) in enumerate(pairwise(values))
        ]
    return values[0]


def hill_multipliers(system: PeriodicSystem) -> ComplexArray:
    """Floquet multipliers, (..., 2m), from Hill's determinant alone.

    det(ρ - P) is a polynomial in ρ of degree 2m: its coefficients follow from Δ at 2m
    values of ρ on a circle, and its roots are the multipliers.
    """
    C, K = _harmonics(system)
    m = C.shape[-1]
    d = 2 * m
    mean = np.zeros((*C.shape[:-3], d, d), dtype=complex)
    mean[..., :m, m:] = np.eye(m)
    mean[..., m:, :m] = -K[..., 0, :, :]
    mean[..., m:, m:] = -C[..., 0, :, :]
    still = np.exp(eigenvalues(mean))
    # Well outside the mean system's multipliers: far from every pole of Δ.
    radius = 1.5 * np.abs(still).max(-1)[..., None]
    rho = radius * np.exp(2j * np.pi * (np.arange(d) + 0.5) / d)
    period = np.asarray(system.period)
    value = np.stack(
        [
            hill_determinant(system, np.log(rho[..., j]) / period)
            * np.prod(rho[..., j, None] - still, axis=-1)
            for j in range(d)
        ],
        axis=-1,
    )
    value = value - rho**d  # monic: what is left has degree 2m - 1
    j = np.arange(d)
    basis = np.exp(-2j * np.pi * np.outer(j, j + 0.5) / d) / d
    lower = np.einsum("ij,...j->...i", basis, value) / radius**j
    companion = np.zeros((*lower.shape, d), dtype=complex)
    companion[..., np.arange(1, d), np.arange(d - 1)] = 1
    companion[..., :, -1] = -lower
    return eigenvalues(companion)


# ----- by collocation -------------------------------------------------------------------


def differentiation_matrix(samples: int) -> FloatArray:
    """Matrix (N, N) that differentiates N equal samples of a period with respect to phase.

    Spectrally accurate. N must be odd: then constants are the only periodic functions of
    the grid with no derivative. Source: Trefethen, Spectral Methods in MATLAB (2000), ch. 3.
    """
    if samples % 2 == 0:
        msg = f"samples must be odd, got {samples}"
        raise ValueError(msg)
    j = np.arange(samples)
    apart = j[:, None] - j
    with np.errstate(divide="ignore"):
        D = np.pi * (-1.0) ** apart / np.sin(np.pi * apart / samples)
    D[j, j] = 0.0
    return D


def collocation_operator(
    M: FloatArray, C: FloatArray, K: FloatArray, period: FloatArray, samples: int
) -> FloatArray:
    """Matrix (..., N m, N m) of M q'' + C q' + K q on N samples of a period."""
    D = differentiation_matrix(samples)
    T = np.asarray(period, dtype=float)[..., None, None, None, None]
    # (..., i, a, j, b): sample i and coordinate a from sample j and coordinate b.
    D1, D2 = D[:, None, :, None] / T, (D @ D)[:, None, :, None] / T**2
    one = np.eye(samples)[:, None, :, None]
    M_, C_, K_ = (part[..., :, :, None, :] for part in (M, C, K))
    full = M_ * D2 + C_ * D1 + K_ * one
    m = full.shape[-1]
    return full.reshape(*full.shape[:-4], samples * m, samples * m)


# ----- many points ----------------------------------------------------------------------


@single_threaded_blas()
def evaluate_in_chunks(
    function: Callable[..., Any],
    *parameters: ArrayLike,
    chunk: int = 1024,
    executor: Executor | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> FloatArray:
    """Evaluate a function of parameters at many points, in chunks on all cores.

    Parameters
    ----------
    function
        Takes arrays of shape (points,) and returns one of the same shape, or with more
        axes behind; `lambda speed, beta: growth_rate(hill_equation(speed=speed, beta=beta))`.
    parameters : (...)
        Broadcast against each other.
    chunk
        Points per call: enough to share NumPy's overhead, few enough to stay in the cache.
    executor
        Where the chunks run, in this process; by default threads, one for each core.
    progress
        Called with chunks done and chunks in all, after each.

    Returns
    -------
    (...)
        The values, with the function's further axes behind.
    """
    arrays = np.broadcast_arrays(*(np.asarray(p, dtype=float) for p in parameters))
    flat = [a.ravel() for a in arrays]
    pieces = -(-flat[0].size // chunk)
    done: list[int] = []

    def told(*points: FloatArray) -> FloatArray:
        values = np.asarray(function(*points))
        done.append(points[0].size)
        if progress:
            progress(len(done), pieces)
        return values

    values: FloatArray = in_chunks(told, *flat, size=chunk, executor=executor)
    return values.reshape(*arrays[0].shape, *values.shape[1:])
