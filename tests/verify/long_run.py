"""Roads whose damage in the long run is known: what a short recording may say of it.

Each kind is stress (MPa scaled to Pa) at `RATE` of so many seconds. Noise goes through a mode of
12 Hz with 5 % of damping; a blow lets the same mode ring. Slope 5 without a limit: a level L does
L^5, so the truth of a road whose level changes is that of the level one times the mean of L^5.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.signal import lfilter

from cardan.core.units import MPa
from cardan.physics.fatigue.mean_stress import uncorrected
from cardan.physics.fatigue.rainflow import half_cycles
from cardan.physics.fatigue.sn_curve import SNCurve
from cardan.physics.signals.usage_profile import UsageHistory, usage_histories

CURVE = SNCurve(amplitude=30 * MPa, cycles=2e6, slope=5).elementary()
RATE = 200.0
MODE, DAMPING = 12.0, 0.05
QUIET = 5 * MPa
"""Standard deviation of the road at level 1."""


def ring():
    """Return the mode's answer to a blow, its first crest 1."""
    t = np.arange(0, 1.5, 1 / RATE)
    answer = np.exp(-DAMPING * 2 * np.pi * MODE * t) * np.sin(2 * np.pi * MODE * t)
    return answer / answer.max()


def noise(rng, seconds):
    """Return the mode shaken by noise, of standard deviation 1."""
    n = int(seconds * RATE)
    r = np.exp(-DAMPING * 2 * np.pi * MODE / RATE)
    poles = [1.0, -2 * r * np.cos(2 * np.pi * MODE / RATE), r * r]
    x = lfilter([1.0], poles, rng.normal(size=n + 400))[400:]
    # Of the filter, not of the draw: a draw's own deviation would take its luck off.
    h = lfilter([1.0], poles, np.eye(1, 4000)[0])
    return x / np.sqrt((h**2).sum())


def held(rng, seconds, every, level):
    """Return a level (n,) that `level(rng, count)` draws anew every so many seconds.

    The first stretch is met anywhere in its length. `every` below zero: of exponential lengths.
    """
    count = int(seconds / abs(every) * 3 + 30)
    if every > 0:
        length = np.full(count, every)
        length[0] *= rng.random()
    else:
        length = rng.exponential(-every, count)
    at = np.searchsorted(np.cumsum(length), np.arange(int(seconds * RATE)) / RATE)
    return level(rng, count)[np.minimum(at, count - 1)]


def wander(rng, seconds, memory, sigma):
    """Return a level that wanders: its logarithm forgets within `memory` s (Ornstein)."""
    n = int(seconds) + 2
    keep = np.exp(-1 / memory)
    step = rng.normal(size=n) * sigma * np.sqrt(1 - keep**2)
    step[0] = rng.normal() * sigma
    log = lfilter([1.0], [1.0, -keep], step)
    return np.exp(np.interp(np.arange(int(seconds * RATE)) / RATE, np.arange(n), log))


def blows(rng, seconds, often, size):
    """Return rings that come by chance, `often` a second, of `size(rng, count)`, in Pa."""
    n = int(seconds * RATE)
    kicks = np.zeros(n)
    count = rng.poisson(often * seconds)
    np.add.at(kicks, rng.integers(0, n, count), size(rng, count) * rng.choice([-1, 1], count))
    if not count:
        return kicks
    return np.convolve(kicks, ring())[:n]


@dataclass(frozen=True)
class Road:
    """A kind of road.

    Attributes
    ----------
    level : Callable
        Of the noise (n,), of a generator of chance and seconds; None is 1.
    blow : Callable
        What comes on top, Pa.
    mean : 1
        Of the level's fifth power.
    """

    level: Callable | None = None
    blow: Callable | None = None
    mean: float = 1.0

    def stress(self, seed, seconds):
        """Return the stress (n,) Pa of so many seconds."""
        rng = np.random.default_rng(seed)
        x = QUIET * noise(rng, seconds)
        if self.level is not None:
            x = x * self.level(rng, seconds)
        return x if self.blow is None else x + self.blow(rng, seconds)


def lognormal(sigma):
    return lambda rng, n: np.exp(sigma * rng.normal(size=n))


def shift(every, level, mean):
    """Return a road whose level is drawn anew, and the mean of that level's fifth power."""
    return Road(level=lambda rng, s: held(rng, s, every, level), mean=float(mean))


def drift(memory, sigma):
    return Road(level=lambda rng, s: wander(rng, s, memory, sigma), mean=np.exp(12.5 * sigma**2))


def blown(often, size):
    """Return an even road with blows of `size(rng, n)` MPa, `often` a second."""
    return Road(blow=lambda rng, s: blows(rng, s, often, lambda g, n: MPa * size(g, n)))


def kinds(every, levels, odds):
    """Return a road of so many levels, each as likely as its odds."""
    levels, odds = np.array(levels), np.array(odds)
    return shift(every, lambda rng, n: rng.choice(levels, n, p=odds), odds @ levels**5)


THREE = ((1.0, 1.6, 3.2), (4 / 7, 2 / 7, 1 / 7))

ROADS = {
    "same": Road(),
    "many blows": blown(0.4, lambda g, n: 20 + g.exponential(20, n)),
    "seven blows": blown(7 / 300, lambda g, n: 20 + g.exponential(20, n)),
    "potholes": blown(2 / 60, lambda g, n: g.exponential(30, n)),
    "level 0.3": shift(20, lognormal(0.3), np.exp(12.5 * 0.3**2)),
    "level 0.6": shift(20, lognormal(0.6), np.exp(12.5 * 0.6**2)),
    "three roads, 20 s": kinds(-20, *THREE),
    "three roads, 60 s": kinds(-60, *THREE),
    "wandering 0.2": drift(15, 0.2),
    "wandering 0.4": drift(40, 0.4),
    "stops and starts": kinds(-15, (0.02, 1.0, 1.2), (0.3, 0.4, 0.3)),
    "lognormal blows": blown(0.1, lambda g, n: 20 * np.exp(0.5 * g.normal(size=n))),
    "blows of one size": blown(0.05, lambda _, n: np.full(n, 60.0)),
}


def seconds_of(x) -> UsageHistory:
    """Return a stress (n,) second by second."""
    pieces = (x[None, k : k + 200_000] for k in range(0, x.size, 200_000))
    return usage_histories(
        pieces, rate=RATE, curve=CURVE, correction=uncorrected, rule=half_cycles
    )[0]


TRUTH = {
    name: 1.352e-8 * road.mean
    if road.blow is None
    else {
        "many blows": 8.60e-6, "seven blows": 4.61e-7, "potholes": 1.75e-6,
        "lognormal blows": 1.62e-7, "blows of one size": 7.63e-7,
    }[name]
    for name, road in ROADS.items()
}  # fmt: skip
"""Damage per second in the long run. The even road: of 40 hours. Blows: what one of each of twenty
sizes does to that road, from a hundred or more of it, averaged over all sizes; "many blows" run
into each other, and theirs is of 400 hours."""
