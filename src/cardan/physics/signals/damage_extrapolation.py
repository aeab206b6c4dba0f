"""What a recording's damage comes to in the long run, or that it is unknown.

A recording's own damage rate is a draw of chance. It misses in two ways: the few blows that did
most of it are not those of another hour, and a road that changes was met in so many stretches only.
So the largest seconds are taken as peaks over a threshold, as many as an exponential law holds for
(by Anderson and Darling's test, and by the largest one), and the interval goes up to what a heavier
tail would do that these may have as well; how the road changes is seen by shuffling the seconds;
and whole stretches, as long as the road remembers, are drawn again. Where what did the damage came
too seldom for that, no interval is given: it would be of the recording, not of the road.
Sources: Johannesson, Extrapolation of load histories and spectra, FFEMS 29 (2006); Bader, Yan &
Zhang, Automated threshold selection for extreme value analysis via ordered goodness-of-fit tests,
Ann. Appl. Stat. 12 (2018); D'Agostino & Stephens, Goodness-of-fit techniques (1986), table 4.14;
Efron & Tibshirani, An Introduction to the Bootstrap (1993), ch. 8; Zhou & Gao, Confidence intervals
for the log-normal mean, Stat. Med. 16 (1997); Hosking & Wallis, Parameter and quantile estimation
for the generalized Pareto distribution, Technometrics 29 (1987).
"""

import math
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from cardan.core.arrays import FloatArray
from cardan.physics.fatigue.sn_curve import SNCurve
from cardan.physics.signals.usage_profile import UsageHistory

UnknownReason = Literal["short", "blows", "road", "wide", "data rejected"]
"""Why the rate is unknown: a recording of less than `MIN_VALID_TIME_S`, a few blows that did much
of the damage, a road that changed too seldom, an interval beyond `MAX_CONFIDENCE_INTERVAL_RATIO`,
or a recording that is spoiled."""

MIN_VALID_TIME_S = 60.0
"""Recorded time in which no change of the road can be seen, s."""

ROAD_LEVEL_BLOCK_S, MIN_ROAD_LEVEL_BLOCKS = 10, 20
"""Seconds of which the road's level is the median one's, and the fewest such blocks."""

ROAD_LEVEL_PERMUTATION_COUNT, ROAD_LEVEL_PERMUTATION_QUANTILE = 200, 0.99
"""Orders of the seconds that the levels' spread is held against, and the share it exceeds where the
road changes."""

MAX_ROAD_LEVEL_DROP_BELOW_MEAN_LN = math.log(30.0)
"""Levels that much below the mean do no damage to speak of, and count as that: standing still."""

MIN_INDEPENDENT_ROAD_STRETCHES = 8.0
"""Independent stretches that the damage came in, as if all did alike; below it no interval is
given. Of roads as rough as chance has it (level lognormal, σ 0.6, whose mean fifty stretches do not
show) 25 % of the intervals were false with 5, 7 % with 8."""

MAX_STEADY_ROAD_LEVEL_SCATTER_LN = 0.05
"""Scatter of the levels' logarithm within which a road that changes is met all the same: 1 % of
stress at a slope of 5, as of a rig that warms. Of one that goes on by a tenth none knows where to.
"""

RECORDED_SECONDS_PER_INITIAL_TAIL_SECOND = 4
"""The largest seconds begin as one of so many."""

MAX_ANDERSON_DARLING_STATISTIC, MIN_PROBABILITY_OF_LARGEST_TAIL_EXCESS = 1.062, 0.02
"""Anderson and Darling's statistic that an exponential law exceeds once in ten, and odds of the
largest excess, within which the law is taken to hold."""

MIN_TAIL_SECONDS, MAX_SHORT_TAIL_DAMAGE_SHARE = 20, 0.25
"""Seconds to which an exponential law had to be cut back that are too few, where they did more than
this share of the damage."""

PARETO_SHAPE_SCATTER_MARGIN_FACTOR = 0.5
"""Of a tail's shape, over the root of how many seconds it has: half of what its moments scatter by.
Of 60 roads with lognormal blows 25 % had a false interval with none of it, 10 % so."""

MAX_CONSTANT_AMPLITUDE_PEAK_EXCESS_SHARE = 0.1
"""Share by which the farthest second reaches beyond the median one of a rig that swings by one
amplitude: it rounds, and its amplifier hums. Of its seconds some hold a cycle more."""

MAX_CONFIDENCE_INTERVAL_RATIO = 30.0
"""High end over low end beyond which a number would say more than is known."""

INTERVAL_CONFIDENCE = 0.9
"""Odds of an interval."""

BOOTSTRAP_DRAWS = 400
"""Of an interval."""


@dataclass(frozen=True)
class LongTermDamage:
    """A damage per hour of driving as recorded, and what it comes to in the long run.

    Attributes
    ----------
    recorded_rate : 1/s
        As recorded, of live time.
    long_term_rate : 1/s
        With the larger blows that a longer recording would meet; nan if unknown.
    interval : 1/s
        90 % of the long run's; its high end is nan if unknown, and its low end then
        what 95 % of roads exceed, zero where the recording is spoiled.
    unknown_reason
        Why the rate is unknown; None if known.
    """

    recorded_rate: float
    long_term_rate: float
    interval: tuple[float, float]
    unknown_reason: UnknownReason | None = None

    def scaled_to_recorded_rate(self, rate: float) -> "LongTermDamage":
        """Return the same for another rate of damage as recorded, 1/s."""
        if not self.recorded_rate > 0:
            return replace(self, rate=rate) if self.unknown_reason else self
        more, (low, high) = rate / self.recorded_rate, self.interval
        return LongTermDamage(
            rate, more * self.long_term_rate, (more * low, more * high), self.unknown_reason
        )


@dataclass(frozen=True)
class _RoadVariability:
    """How the road changed: blocks a stretch lasts, variance of log level, mean less that seen."""

    stretch: float = 1.0
    variance: float = 0.0
    shift: float = 0.0
    meetings: float = math.inf
    stretches: float = math.inf


def extrapolate_damage(
    of: UsageHistory, *, curve: SNCurve, spoiled: bool = False, seed: int = 0
) -> LongTermDamage:
    """Return a gauge's damage rate in the long run, with its interval, or why it is unknown.

    What was not driven is not in it: a recording of one kind of road says nothing of others. One
    that is spoiled says nothing at all.
    """
    from scipy.stats import t as student

    live, done = float(of.live.sum()), of.damage + of.open_damage
    if spoiled:
        return LongTermDamage(
            float(done.sum()) / max(live, 1e-9), math.nan, (0.0, math.nan), "data rejected"
        )
    if not live > 0 or not done.sum() > 0:
        return LongTermDamage(0.0, 0.0, (0.0, 0.0))
    rng = np.random.default_rng(seed)
    m, whole = done.size, float(done.sum()) / live
    size = max(min(ROAD_LEVEL_BLOCK_S, m // MIN_ROAD_LEVEL_BLOCKS), 1)
    road = _road_variability(done, size=size, rng=rng)
    amplitude = _equivalent_amplitudes(done, curve)
    most = max(m // RECORDED_SECONDS_PER_INITIAL_TAIL_SECOND, 10)
    above = _exponential_tail_size(amplitude, most)
    threshold = float(np.sort(amplitude)[::-1][above]) if above < m else 0.0
    over = (amplitude > threshold) & (not _is_constant_amplitude(of))
    above = max(int(over.sum()), 1)

    # A stretch is drawn as a whole, of a road that does not change a manoeuvre.
    together = (
        math.ceil(road.stretch) * size
        if road.variance
        else min(30, max(m // MIN_ROAD_LEVEL_BLOCKS, 1))
    )
    count = -(-m // together)
    stretch = np.arange(m) // together
    beyond = np.where(over, amplitude - threshold, 0.0)
    each_second = np.stack([np.where(over, 0.0, done), of.live, over.astype(float), beyond])
    sums = np.stack([np.bincount(stretch, values, count) for values in each_second]).astype(float)

    def rate(drawn: FloatArray, stretched: FloatArray) -> FloatArray:
        below, heard, many, excess = drawn
        mean = stretched * excess / np.maximum(many, 1)
        tail = many * _mean_damage(curve, threshold, mean)
        return (below + tail) / np.maximum(heard, 1e-9)

    often = rng.multinomial(count, np.full(count, 1 / count), BOOTSTRAP_DRAWS).T.astype(float)
    drawn = sums @ often
    # A mean excess is itself known to one part in the root of its number.
    draws = rate(drawn, rng.gamma(above, size=BOOTSTRAP_DRAWS) / above)
    total = sums.sum(-1)
    found = float(rate(total[:, None], np.ones(1))[0])
    if not found > 0:
        return LongTermDamage(whole, whole, (0.0, math.nan), "blows")
    # Few stretches hold the damage: draws of them scatter less than recordings do, as by Student.
    each = _mean_damage(curve, threshold, total[3:] / max(total[2], 1))
    held = sums[0] + sums[2] * each
    few = max(float(held.sum() ** 2 / (held**2).sum()) - 1, 1.0)
    edge = (1 + INTERVAL_CONFIDENCE) / 2
    wider = float(student.ppf(edge, few) / student.ppf(edge, np.inf))
    ends = np.log(np.maximum(np.quantile(draws, [1 - edge, edge]), 1e-300) / found)
    low, high = min(wider * float(ends[0]), 0.0), max(wider * float(ends[1]), 0.0)
    if road.variance:
        # The mean of lognormal levels of which so many were met: Cox's.
        freedom, v = max(road.stretches - 1, 1.0), road.variance
        half = float(student.ppf(edge, freedom)) * math.sqrt(v / (freedom + 1) + v**2 / 2 / freedom)
        # About it, and about the mean that was met: stops make no lognormal of a road.
        low, high = min(low, min(road.shift, 0) - half), max(high, max(road.shift, 0) + half)
    # A tail that is a little heavier than exponential shows in few blows less than it does.
    shape = _pareto_shape(beyond[over]) if over.any() else 0.0
    more = _mean_damage(curve, threshold, total[3:] / max(total[2], 1), shape)
    heavier = float(total[0] + total[2] * more[0]) / max(float(total[1]), 1e-9) / found
    high = max(high, math.log(max(heavier, 1.0)))
    unknown: UnknownReason | None = None
    if live < MIN_VALID_TIME_S:
        unknown = "short"
    elif (
        road.meetings < MIN_INDEPENDENT_ROAD_STRETCHES
        and road.variance > MAX_STEADY_ROAD_LEVEL_SCATTER_LN**2
    ):
        unknown = "road"
    elif (
        above < min(MIN_TAIL_SECONDS, most)
        and done[over].sum() > MAX_SHORT_TAIL_DAMAGE_SHARE * done.sum()
    ):
        unknown = "blows"
    elif high - low > math.log(MAX_CONFIDENCE_INTERVAL_RATIO):
        unknown = "wide"
    # What the seconds below the threshold do comes whatever the blows.
    steady = float(np.quantile(drawn[0] / np.maximum(drawn[1], 1e-9), 1 - edge))
    least = min(max(found * math.exp(low), steady), found)
    if unknown:
        return LongTermDamage(whole, math.nan, (least, math.nan), unknown)
    return LongTermDamage(whole, found, (least, found * math.exp(high)))


def _is_constant_amplitude(of: UsageHistory) -> bool:
    """Return whether all seconds reach as far: no law of blows can be fitted to them."""
    centre = float(np.nanmedian(of.mean))
    reach = np.fmax(of.high - centre, centre - of.low)
    return bool(
        np.nanmax(reach) <= (1 + MAX_CONSTANT_AMPLITUDE_PEAK_EXCESS_SHARE) * np.nanmedian(reach)
    )


def _road_variability(done: FloatArray, *, size: int, rng: np.random.Generator) -> _RoadVariability:
    """Return how a road changed, by the median second's damage of each block of so many.

    A blow is of few seconds, and moves no median. Seconds in another order say how much the
    medians of a road that never changes would scatter.
    """
    n = done.size // size
    if n < 3:
        return _RoadVariability()
    logs = np.log(np.maximum(done[: n * size], 1e-300))
    logs = np.maximum(logs, np.log(np.mean(done)) - 2 * MAX_ROAD_LEVEL_DROP_BELOW_MEAN_LN)

    def levels(of: FloatArray) -> FloatArray:
        level = np.median(of.reshape(n, size), axis=1)
        return np.maximum(level, np.log(np.exp(level).mean()) - MAX_ROAD_LEVEL_DROP_BELOW_MEAN_LN)

    met = levels(logs)
    spread = float(met.var(ddof=1))
    shuffled = np.array(
        [levels(rng.permutation(logs)).var(ddof=1) for _ in range(ROAD_LEVEL_PERMUTATION_COUNT)]
    )
    if spread <= float(np.quantile(shuffled, ROAD_LEVEL_PERMUTATION_QUANTILE)):
        return _RoadVariability()
    variance, c = spread - float(shuffled.mean()), met - met.mean()
    # A stretch lasts as long as levels are alike: the integral of their correlation.
    stretch, lags = 1.0, 0
    for lag in range(1, n // 2):
        alike = float(c[lag:] @ c[:-lag]) / n / variance
        if alike < 0.1:
            break
        stretch, lags = stretch + 2 * min(alike, 1.0), lag
    # It may last longer than it seems to: by a standard deviation of such a sum, Bartlett's.
    seen, stretch = stretch, stretch * (1 + math.sqrt(2 * (2 * lags + 1) / n))
    damage = np.exp(met)
    meetings = float(damage.sum() ** 2 / (damage**2).sum()) / seen
    return _RoadVariability(
        stretch=stretch, variance=variance,
        shift=float(met.mean() + spread / 2 - np.log(damage.mean())),
        meetings=meetings, stretches=n / stretch,
    )  # fmt: skip


def _equivalent_amplitudes(damage: FloatArray, curve: SNCurve) -> FloatArray:
    """Return the amplitude of one cycle that does the damage of each second (m,), Pa."""
    low, high = np.zeros(damage.shape), np.full(damage.shape, curve.amplitude)
    while (short := (curve.damage(high) < damage)).any():
        high = np.where(short, 2 * high, high)
    for _ in range(60):
        middle = (low + high) / 2
        less = curve.damage(middle) < damage
        low, high = np.where(less, middle, low), np.where(less, high, middle)
    return np.where(damage > 0, high, 0.0)


def _exponential_tail_size(amplitude: FloatArray, most: int) -> int:
    """Return how many of the largest (m,) exceed a threshold by what may be exponential."""
    ordered: FloatArray = np.sort(amplitude)[::-1]
    k = min(most, ordered.size - 1)
    while k > 5:
        excess = np.sort(ordered[:k] - ordered[k])
        if not excess[0] >= 0 or not excess.sum() > 0:
            break
        rank = np.arange(1.0, k + 1)
        z = excess / excess.mean()
        # ln F of the sorted, and ln (1 - F) = -z of the same from above.
        terms = np.log(-np.expm1(-np.maximum(z, 1e-12))) - z[::-1]
        apart = -k - float((2 * rank - 1) @ terms) / k
        # The median says how large they are without the one in question.
        scale = float(np.median(excess)) / math.log(2)
        odds = -math.expm1(k * math.log1p(-math.exp(-excess[-1] / scale))) if scale > 0 else 0.0
        if (
            apart * (1 + 0.6 / k) < MAX_ANDERSON_DARLING_STATISTIC
            and odds > MIN_PROBABILITY_OF_LARGEST_TAIL_EXCESS
        ):
            break
        k = int(k / 1.25)
    return max(k, 1)


def _pareto_shape(excess: FloatArray) -> float:
    """Return how much heavier than exponential a tail of excesses (k,) may be: Pareto's shape.

    Of its first two moments (Hosking & Wallis), and `PARETO_SHAPE_SCATTER_MARGIN_FACTOR` more.
    """
    squares = float((excess**2).mean()) / max(float(excess.mean()) ** 2, 1e-300) - 1
    return max(
        (1 - 1 / max(squares, 1e-3)) / 2, 0.0
    ) + PARETO_SHAPE_SCATTER_MARGIN_FACTOR / math.sqrt(excess.size)


def _mean_damage(
    curve: SNCurve, threshold: float, excess: FloatArray, shape: float = 0.0
) -> FloatArray:
    """Return the mean damage of cycles (n,) by their mean excess beyond a threshold, exponential.

    Or as Pareto's generalised law has it, of a shape above 0.
    """
    # Gauss and Laguerre: 24 places are exact for a power of 47.
    places, weights = np.polynomial.laguerre.laggauss(24)
    if shape > 0:
        places = (1 - shape) * np.expm1(shape * places) / shape
    return curve.damage(threshold + excess[:, None] * places) @ weights
