"""Forces of rubber at its stop, and components of what repeats every half turn.

The law of a stop and its source: `cardan.physics.loads.rubber_stop_response`.
"""

import numpy as np

from cardan.core.arrays import ComplexArray, FloatArray, IntArray
from cardan.core.lazy_dataclass import dataclass

STOP_ORDERS = (2, 4, 6, 8, 10, 12, 14, 16, 18, 20)
"""Orders of the motion apart from its mean: a stop's push has more of them than its motion."""

SAMPLES = 64
"""Of the half turn, at which a stop's force is evaluated."""

FINE_SAMPLES = 192
"""The same of a motion that is found."""

_BLOCK_MOTIONS = 128
"""Evaluated at once: more of them leave the cache."""
_LEAST_TRAVEL_M = 1e-300
"""Which has a direction."""

PLACES_OF_ORDERS = tuple(zip(range(1, 2 * len(STOP_ORDERS), 2), STOP_ORDERS, strict=True))
COMPONENTS = 1 + 2 * len(STOP_ORDERS)


def _basis(samples: int) -> FloatArray:
    """Return what components are at angles of a half turn, (M, samples)."""
    angles = np.pi / samples * np.outer(np.array(STOP_ORDERS), np.arange(samples))
    found = np.ones((COMPONENTS, samples))
    found[1::2], found[2::2] = np.cos(angles), -np.sin(angles)
    return found


BASIS, _FINE_BASIS = _basis(SAMPLES), _basis(FINE_SAMPLES)
PROJECTION = np.ascontiguousarray(2 * BASIS.T / SAMPLES)
PROJECTION[:, 0] /= 2


def _pair_projections() -> tuple[FloatArray, IntArray]:
    """Return what a slope at `SAMPLES` makes of pairs of components, (SAMPLES, K), each once.

    Then which of K is the force's component i of a travel's component j, (M, 2, M, 2), of slopes
    along the axes and across between, of 3 K. Products of two are the same both ways, but for
    the mean's half share.
    """
    i, j = np.indices((COMPONENTS, COMPONENTS))
    own = np.argwhere((i <= j) | (j == 0))
    place = np.zeros((COMPONENTS, COMPONENTS), dtype=int)
    place[tuple(own.T)] = np.arange(len(own))
    place = np.where((i > j) & (j > 0), place.T, place)
    found = PROJECTION[:, own[:, 0]] * BASIS.T[:, own[:, 1]]
    kinds = np.array([[0, 2], [2, 1]])
    each = len(own) * kinds[None, :, None, :] + place[:, None, :, None]
    return np.ascontiguousarray(found), each


PAIRS, PLACES_OF_PAIRS = _pair_projections()


@dataclass(frozen=True, kw_only=True, eq=False)
class StopContact:
    """Bearings P at J instants, and how far each is beyond its stop.

    Attributes
    ----------
    K1, K2, k : (P, 1), (P, 1), (P, J) N/m
        Stiffness of the rubber along its axes, and in the direction of the travel.
    x, y, n1, n2 : (P, J) m, 1
        Travel across the shaft, and its direction.
    beyond, within : (P, J)
        Shares of the travel beyond the stop, and up to it.
    more : (P, 1)
        Stiffness that the stop adds, over that of the rubber.
    """

    K1: FloatArray
    K2: FloatArray
    k: FloatArray
    x: FloatArray
    y: FloatArray
    n1: FloatArray
    n2: FloatArray
    beyond: FloatArray
    within: FloatArray
    more: FloatArray

    @classmethod
    def of(
        cls, travel: FloatArray, *, stiffness: FloatArray, stop: FloatArray, ratio: FloatArray
    ) -> "StopContact":
        """Return it of `travel` (P, 2, J) m, stiffness (P, 2) N/m, stop and ratio (P,)."""
        x, y = travel[:, 0], travel[:, 1]
        u = np.maximum(np.sqrt(x * x + y * y), _LEAST_TRAVEL_M)
        beyond = np.maximum(1 - stop[:, None] / u, 0.0)
        n1, n2 = x / u, y / u
        K1, K2 = stiffness[:, :1], stiffness[:, 1:]
        return cls(
            K1=K1, K2=K2, k=K1 * (n1 * n1) + K2 * (n2 * n2),
            x=x, y=y, n1=n1, n2=n2,
            beyond=beyond, within=1 - beyond, more=ratio[:, None] - 1,
        )  # fmt: skip

    @property
    def force(self) -> FloatArray:
        """What stops add to the rubber's force, (P, 2, J) N: the gradient of V."""
        found = np.empty((len(self.x), 2, self.x.shape[-1]))
        size, same = self.more * self.beyond, self.within * self.k
        found[:, 0] = size * self.x * (self.beyond * self.K1 + same)
        found[:, 1] = size * self.y * (self.beyond * self.K2 + same)
        return found

    @property
    def slope(self) -> FloatArray:
        """Its derivatives by the travel, (P, 3, J) N/m: along the axes, and across between."""
        n1, n2, s = self.n1, self.n2, self.beyond
        # With s = beyond, a = within: s² K + s a k + (a² - 3 s a) k n n' + 2 s a (K n n' + n n' K)
        both, same = s * self.within, self.within * self.k
        along = np.where(s > 0, self.within * same, 0.0) - 3 * both * self.k
        K1, K2 = self.K1, self.K2
        found = np.empty((len(s), 3, s.shape[-1]))
        found[:, 0] = s * (s * K1 + same) + n1 * n1 * (along + 4 * K1 * both)
        found[:, 1] = s * (s * K2 + same) + n2 * n2 * (along + 4 * K2 * both)
        found[:, 2] = n1 * n2 * (along + 2 * (K1 + K2) * both)
        found *= self.more[:, None]
        return found


@dataclass(frozen=True, kw_only=True, eq=False)
class ForcesAtStop:
    """Forces on bearings whose rubber meets its stop, (P, B) N.

    Attributes
    ----------
    static, dynamic
        Size of the mean; largest size of the rest round the half turn.
    """

    static: FloatArray
    dynamic: FloatArray


def forces_at_stop(
    travel: FloatArray,
    free: FloatArray,
    linear: FloatArray,
    *,
    stiffness: FloatArray,
    loss: FloatArray,
    stop: FloatArray,
    ratio: FloatArray,
) -> ForcesAtStop:
    """Return what bearings carry in P motions with stops: of a stop its elastic force.

    What it loses is in the motion. A damper's force jumps where a stop is met, rubber's does not.

    Parameters
    ----------
    travel, free : (P, M, 2 B) m
        With stops, and on linear rubber.
    linear : (P, M, 3 B) N
        Force on linear rubber, across the shaft, then along it, bearing by bearing.
    stiffness, loss, stop, ratio : (P, B, 2) N/m, (P, B) signed as the speed, (P, B) m, 1
    """
    count, _, size = travel.shape
    more = stiffness.reshape(count, 1, size) * (travel - free)
    eta = np.repeat(loss, 2, axis=-1)
    for at, _ in PLACES_OF_ORDERS:
        real, imaginary = more[:, at].copy(), more[:, at + 1].copy()
        more[:, at] = real - eta * imaginary
        more[:, at + 1] = imaginary + eta * real
    rubber = linear.reshape(count, COMPONENTS, size // 2, 3).copy()
    rubber[..., :2] += more.reshape(count, COMPONENTS, size // 2, 2)
    static, dynamic = np.empty(stop.shape), np.empty(stop.shape)
    for b in range(size // 2):
        for start in range(0, count, _BLOCK_MOTIONS):
            some = slice(start, start + _BLOCK_MOTIONS)
            force = _round_the_half_turn_finely(rubber[some, :, b])
            force[:, :2] += StopContact.of(
                _round_the_half_turn_finely(travel[some, :, 2 * b : 2 * b + 2]),
                stiffness=stiffness[some, b], stop=stop[some, b], ratio=ratio[some, b],
            ).force  # fmt: skip
            mean = force.mean(axis=-1)
            force -= mean[..., None]
            static[some, b] = np.linalg.norm(mean, axis=-1)
            dynamic[some, b] = np.sqrt((force * force).sum(axis=1).max(axis=-1))
    return ForcesAtStop(static=static, dynamic=dynamic)


def largest_travel(travel: FloatArray) -> FloatArray:
    """Return the largest way across the shaft round the half turn of P motions, (P, B) m.

    `travel` (P, M, 2 B) m are components as `StoppedLine.free` has them.
    """
    found = np.empty((len(travel), travel.shape[-1] // 2))
    for b in range(found.shape[1]):
        for start in range(0, len(travel), _BLOCK_MOTIONS):
            some = slice(start, start + _BLOCK_MOTIONS)
            x = _round_the_half_turn_finely(travel[some, :, 2 * b : 2 * b + 2])
            found[some, b] = np.sqrt((x[:, 0] ** 2 + x[:, 1] ** 2).max(axis=-1))
    return found


def _round_the_half_turn_finely(of: FloatArray) -> FloatArray:
    """Return components (P, M, D) at `FINE_SAMPLES` angles of a half turn, (P, D, FINE_SAMPLES)."""
    found = np.ascontiguousarray(of.mT).reshape(-1, COMPONENTS) @ _FINE_BASIS
    return found.reshape(len(of), -1, FINE_SAMPLES)


def components(mean: FloatArray, waves: ComplexArray) -> FloatArray:
    """Return a mean (..., D) and orders 2, 4, ... (..., K, D) as components (..., M, D)."""
    found = np.zeros((*mean.shape[:-1], COMPONENTS, mean.shape[-1]))
    found[..., 0, :] = mean
    count = 2 * waves.shape[-2]
    found[..., 1 : 1 + count : 2, :] = waves.real
    found[..., 2 : 2 + count : 2, :] = waves.imag
    return found


def round_the_half_turn(of: FloatArray) -> FloatArray:
    """Return components (..., M, D) at `SAMPLES` angles of a half turn, (..., SAMPLES, D)."""
    return BASIS.T @ of
