"""What stress does: equivalent, principal, along a direction; and its extremes over a history.

Stresses are (..., 6) Pa: xx, yy, zz, xy, yz, zx.
"""

from dataclasses import dataclass, replace

import numpy as np

from cardan.core.arrays import ArrayLike, FloatArray, IntArray

_CHUNK = 50_000
"""Stress states held at once while a history is searched: few enough to stay near a processor."""


def von_mises(stress: ArrayLike) -> FloatArray:
    """Von Mises stress (...) Pa of stresses (..., 6)."""
    xx, yy, zz, xy, yz, zx = np.moveaxis(np.asarray(stress, dtype=float), -1, 0)
    return np.sqrt(
        ((xx - yy) ** 2 + (yy - zz) ** 2 + (zz - xx) ** 2) / 2 + 3 * (xy**2 + yz**2 + zx**2)
    )


def stress_tensor(stress: ArrayLike) -> FloatArray:
    """Stress (..., 6) as symmetric matrices (..., 3, 3)."""
    stress = np.asarray(stress, dtype=float)
    return stress[..., [[0, 3, 5], [3, 1, 4], [5, 4, 2]]]


def voigt_vector(matrix: ArrayLike) -> FloatArray:
    """Symmetric matrices (..., 3, 3) as stress (..., 6)."""
    m = np.asarray(matrix, dtype=float)
    return np.stack([m[..., i, j] for i, j in ((0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (2, 0))], -1)


def principal_stresses(stress: ArrayLike) -> FloatArray:
    r"""Principal stresses (..., 3) Pa of stresses (..., 6), smallest first.

    In closed form: $\sigma_k = p + 2 q \cos(\varphi + 2 \pi k / 3)$, with p the mean, q from
    the second and φ from the third invariant of the deviator. Source: Smith, Comm. ACM 4
    (1961) 168. Exact to rounding of the largest stress.
    """
    xx, yy, zz, xy, yz, zx = np.moveaxis(np.asarray(stress, dtype=float), -1, 0)
    p = (xx + yy + zz) / 3
    a, b, c = xx - p, yy - p, zz - p
    q = np.sqrt((a**2 + b**2 + c**2 + 2 * (xy**2 + yz**2 + zx**2)) / 6)
    third = a * b * c + 2 * xy * yz * zx - a * yz**2 - b * zx**2 - c * xy**2
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        cosine = np.where(q**3 > 1e-280, third / (2 * q**3), 0.0)  # not where it underflows
    phi = np.arccos(np.clip(cosine, -1, 1)) / 3
    high, low = p + 2 * q * np.cos(phi), p + 2 * q * np.cos(phi + 2 * np.pi / 3)
    return np.stack([low, 3 * p - high - low, high], axis=-1)


def normal_stress(stress: ArrayLike, direction: ArrayLike) -> FloatArray:
    """Return the normal stress (...) Pa on the planes square to directions (..., 3)."""
    n = np.asarray(direction, dtype=float)
    n = n / np.linalg.norm(n, axis=-1, keepdims=True)
    return np.einsum("...i,...ij,...j->...", n, stress_tensor(stress), n)


def superpose(unit: ArrayLike, loads: ArrayLike) -> FloatArray:
    """Results (..., t, k) of load histories (t, u) from unit results (..., u, k).

    One product of matrices, whatever the leading axes; times lie together in memory.
    """
    unit, loads = np.asarray(unit, dtype=float), np.asarray(loads, dtype=float)
    return np.moveaxis(np.tensordot(unit, loads, axes=(-2, -1)), -1, -2)


_DIRECTIONS = 2000


def max_normal_stress_swing_direction(stress: ArrayLike) -> FloatArray:
    """Return the direction (3,) along which the normal stress of a history (t, 6) swings most.

    Of a history in proportion this is a principal direction, found as such. Else the best
    of 2000 directions spread over half a ball, at most 2.5 degrees apart: 0.2 % at worst.
    """
    history = np.asarray(stress, dtype=float)
    swing = np.ptp(history, axis=0)
    at = history[np.linalg.norm(history - history.mean(axis=0), axis=-1).argmax()]
    step = at - history[np.linalg.norm(history - at, axis=-1).argmax()]
    step = step if np.any(step) else at
    values, vectors = np.linalg.eigh(stress_tensor(step))
    k = np.arange(_DIRECTIONS) + 0.5
    z, turn = k / _DIRECTIONS, k * np.pi * (3 - np.sqrt(5))
    r = np.sqrt(1 - z**2)
    spread = np.stack([r * np.cos(turn), r * np.sin(turn), z], axis=-1)
    tried = np.concatenate([vectors[:, [np.abs(values).argmax()]].T, spread])
    if not np.any(swing):
        return tried[0]
    return tried[np.ptp(normal_stress(history[:, None], tried), axis=0).argmax()]


def subsample_load_history(loads: ArrayLike, count: int) -> FloatArray:
    """Return as many moments of a history (t, u) as requested, spread over it without a rhythm."""
    loads = np.asarray(loads, dtype=float)
    if len(loads) <= count:
        return loads
    golden = (np.sqrt(5) - 1) / 2
    return loads[np.unique((np.arange(count) * golden % 1 * len(loads)).astype(np.int64))]


@dataclass(frozen=True, slots=True)
class StressExtreme:
    """An extreme stress: its value, at which point of those searched, at which time."""

    value: float
    point: int
    time: int


@dataclass(frozen=True, slots=True)
class StressExtremes:
    """The extremes of one load case over points and times."""

    von_mises: StressExtreme
    max_principal: StressExtreme
    """Maximum principal stress: tension, which opens cracks."""
    min_principal: StressExtreme
    """Minimum principal stress."""

    def with_point_numbers(self, points: IntArray) -> "StressExtremes":
        """Return the same where the points searched were those of more (points,)."""
        each = (self.von_mises, self.max_principal, self.min_principal)
        return StressExtremes(*(replace(e, point=int(points[e.point])) for e in each))


def stress_extremes(unit: ArrayLike, loads: ArrayLike) -> StressExtremes:
    """Extremes over points and times of a load history.

    Parameters
    ----------
    unit : (n, u, 6) Pa
        Stresses of the unit loads at the points to search.
    loads : (t, u)
        Load history; a static case has one time.
    """
    unit, loads = np.asarray(unit, dtype=float), np.asarray(loads, dtype=float)
    found: list[list[StressExtreme]] = [[], [], []]
    step = max(1, _CHUNK // len(loads))
    for start in range(0, len(unit), step):
        stress = superpose(unit[start : start + step], loads)
        ends = principal_stresses(stress)
        for kept, values in zip(
            found, (von_mises(stress), ends[..., 2], -ends[..., 0]), strict=True
        ):
            point, time = np.unravel_index(int(values.argmax()), values.shape)
            kept.append(StressExtreme(float(values[point, time]), int(point) + start, int(time)))
    mises, high, low = (max(kept, key=lambda e: e.value) for kept in found)
    return StressExtremes(mises, high, StressExtreme(-low.value, low.point, low.time))


def von_mises_envelope(unit: ArrayLike, loads: ArrayLike) -> FloatArray:
    """Largest von Mises stress (n,) at each point over load histories (t, u)."""
    unit, loads = np.asarray(unit, dtype=float), np.asarray(loads, dtype=float)
    step = max(1, _CHUNK // len(loads))
    return np.concatenate([
        von_mises(superpose(unit[k : k + step], loads)).max(axis=-1)
        for k in range(0, len(unit), step)
    ])  # fmt: skip
