"""When the damage came: second by second, so that route, gear, speed and torque can be told.

A cycle counts in the second in which it closes; what is left open at the end belongs to no
second. What seconds say is added up by what was driven in them, taken again at random to see
how sure a damage rate is, and sorted to see how short a test can be.
Sources: Johannesson, Extrapolation of load histories and spectra, FFEMS 29 (2006); Efron &
Tibshirani, An Introduction to the Bootstrap (1993).
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from cardan.base.arrays import ArrayLike, FloatArray, IntArray
from cardan.fatigue.correction import Correction
from cardan.fatigue.damage import miner
from cardan.fatigue.rainflow import NONE, Cycles, ResidueRule, four_point
from cardan.fatigue.recording import cut
from cardan.fatigue.strength import SNCurve

SECOND = 1.0
"""Length of what is told apart, s."""

LARGEST = 400
"""Cycles that are kept with their second, the largest of each gauge."""

TOGETHER, BLOCKS = 30, 20
"""Seconds that are drawn together, at most, for a manoeuvre is not taken apart; of a short
recording fewer, so that there are as many blocks: of ten the draws say too little. Five minutes of
a road that changes every twenty seconds: 31 of 40 intervals of 90 % hold the truth, of twice as
many blocks 24."""

SURE = 1.645
"""Standard deviations to either side of a 90 % interval."""

DRAWS = 400
"""Of an interval."""


@dataclass(frozen=True)
class Usage:
    """One gauge, second by second (m,).

    Attributes
    ----------
    damage : (m,) 1
        Of the cycles that closed in each second.
    left : (m,) 1
        Of what is left open, by the rule for the residue and by the second a leg of it ends in.
    high, low : (m,) Pa
        Largest and smallest stress; nan where nothing was heard.
    at_high, at_low : (m,) s
        When these were.
    live : (m,) s
        Time that was heard.
    largest, when, count : (k,) Pa, s and 1
        Equivalent amplitudes of the largest cycles, the seconds they closed in, or a leg ended, and
        as how many each counts.
    """

    damage: FloatArray
    left: FloatArray
    high: FloatArray
    low: FloatArray
    at_high: FloatArray
    at_low: FloatArray
    live: FloatArray
    largest: FloatArray
    when: IntArray
    count: FloatArray

    @property
    def open(self) -> float:
        """Damage of what is left open."""
        return float(self.left.sum())


def usage(
    pieces: Iterable[FloatArray], *, rate: float, curve: SNCurve, correction: Correction,
    rule: ResidueRule,
) -> list[Usage]:  # fmt: skip
    """Return each gauge of a stress (gauges, n) Pa second by second."""
    size = max(round(SECOND * rate), 2)
    found: list[_Gauge] = []
    for k, piece in enumerate(cut(pieces, size=size)):
        if not found:
            found = [_Gauge(curve, correction) for _ in piece]
        for one, x in zip(found, piece, strict=True):
            one.add(k, x, rate=rate, start=k * size / rate)
    return [one.result(rule) for one in found]


class _Gauge:
    """A gauge as its seconds pass."""

    def __init__(self, curve: SNCurve, correction: Correction) -> None:
        self.curve, self.correction, self.residue = curve, correction, NONE
        self.rows: list[tuple[float, ...]] = []
        self.met = np.empty(0, np.int64)
        self.largest, self.when, self.count = NONE, np.empty(0, np.int64), NONE

    def add(self, k: int, x: FloatArray, *, rate: float, start: float) -> None:
        before = self.residue
        cycles, self.residue = four_point(x, residue=before)
        # What was open and still is stands in front; what came on top is of this second.
        n = min(before.size, self.residue.size)
        same = int(np.logical_and.accumulate(before[:n] == self.residue[:n]).sum())
        self.met = np.append(self.met[:same], np.full(self.residue.size - same, k))
        known = np.flatnonzero(~np.isnan(x))
        top = bottom = at_top = at_bottom = np.nan
        if known.size:
            i, j = known[np.argmax(x[known])], known[np.argmin(x[known])]
            top, bottom = float(x[i]), float(x[j])
            at_top, at_bottom = start + i / rate, start + j / rate
        damage = miner(cycles, curve=self.curve, correction=self.correction)
        self.rows.append((damage, top, bottom, at_top, at_bottom, known.size / rate))
        self._keep(cycles, np.full(cycles.count.size, k))

    def _keep(self, cycles: Cycles, when: IntArray) -> None:
        if not cycles.count.size:
            return
        size = np.concatenate([self.largest, self._equivalent(cycles)])
        when = np.concatenate([self.when, when])
        count = np.concatenate([self.count, cycles.count])
        keep = np.argsort(-size, kind="stable")[:LARGEST]
        self.largest, self.when, self.count = size[keep], when[keep], count[keep]

    def _equivalent(self, cycles: Cycles) -> FloatArray:
        return self.correction(cycles.amplitude, (cycles.start + cycles.end) / 2)

    def result(self, rule: ResidueRule) -> Usage:
        legs = rule(self.residue)
        order = np.argsort(self.residue, kind="stable")
        ends = (order[np.searchsorted(self.residue[order], e)] for e in (legs.start, legs.end))
        when = np.maximum(*(self.met[end] for end in ends))
        self._keep(legs, when)
        left = np.zeros(len(self.rows))
        np.add.at(left, when, legs.count * self.curve.damage(self._equivalent(legs)))
        damage, high, low, at_high, at_low, live = np.array(self.rows).reshape(-1, 6).T
        return Usage(
            damage, left, high, low, at_high, at_low, live, self.largest, self.when, self.count
        )  # fmt: skip


@dataclass(frozen=True)
class Peak:
    """A largest stress of either sign: Pa, and when, s."""

    stress: float
    time: float


def peaks(of: Usage, *, count: int = 8, apart: float = 5.0) -> list[Peak]:
    """Return the largest stresses by size, some seconds apart from each other."""
    stress = np.concatenate([of.high, of.low])
    time = np.concatenate([of.at_high, of.at_low])
    known = ~np.isnan(stress)
    stress, time = stress[known], time[known]
    found: list[Peak] = []
    for k in np.argsort(-np.abs(stress), kind="stable"):
        if all(abs(time[k] - p.time) >= apart for p in found):
            found.append(Peak(float(stress[k]), float(time[k])))
        if len(found) == count:
            break
    return found


@dataclass(frozen=True)
class Group:
    """Seconds of one sort: their share of damage and time, their time s and way m."""

    name: str
    damage: float
    share: float
    time: float
    distance: float


def grouped(of: Usage, names: Sequence[str], *, metres: FloatArray | None = None) -> list[Group]:
    """Return the damage by the sort of each second (m,); "" leaves one out.

    `metres` (m,) is the way of each second.
    """
    told = np.asarray(names)
    whole = float(of.damage.sum())
    found: list[Group] = []
    for name in dict.fromkeys(n for n in names if n):
        here = told == name
        damage = float(of.damage[here].sum())
        way = np.nan if metres is None else float(metres[here].sum())
        share = damage / whole if whole else np.nan
        found.append(Group(name, damage, share, float(of.live[here].sum()), way))
    return found


def bands(values: ArrayLike, *, step: float) -> list[str]:
    """Name each value (m,) by its band of width `step`, "" where it is not known."""
    v = np.asarray(values, float)
    low = np.floor(v / step) * step
    return ["" if np.isnan(a) else f"{a:g} .. {a + step:g}" for a in low]


@dataclass(frozen=True)
class Extrapolated:
    """A damage per hour of driving as recorded, and what it comes to in the long run.

    Attributes
    ----------
    rate : 1/s
        As recorded, of live time.
    long_run : 1/s
        With the tail of larger cycles that a longer recording would meet.
    interval : 1/s
        90 % of the long run's, by drawing the seconds again.
    """

    rate: float
    long_run: float
    interval: tuple[float, float]


def extrapolated(of: Usage, *, curve: SNCurve, seed: int = 0) -> Extrapolated:
    """Return a gauge's damage rate in the long run, with its interval.

    The largest cycles are those beyond a threshold; their excess is taken as exponential, so
    larger ones than any recorded count with their odds. Seconds are drawn again in blocks.
    """
    from scipy.stats import t as student

    live, done = float(of.live.sum()), of.damage + of.left
    if not live > 0 or not done.sum() > 0:
        return Extrapolated(0.0, 0.0, (0.0, 0.0))
    m = of.damage.size
    above = _tail(of)
    size, when, many = of.largest[:above], of.when[:above], of.count[:above]
    threshold = float(of.largest[above]) if of.largest.size > above else 0.0
    own = np.zeros(m)
    np.add.at(own, when, many * curve.damage(size))
    below = np.maximum(done - own, 0.0)
    together = max(min(TOGETHER, m // BLOCKS), 1)
    count = -(-m // together)
    block = np.minimum(np.arange(m) // together, count - 1)

    def summed(values: FloatArray, at: IntArray) -> FloatArray:
        return np.bincount(at, values, count).astype(float)

    by_block = {
        "below": summed(below, block), "live": summed(of.live, block),
        "many": summed(many, block[when]),
        "excess": summed(many * (size - threshold), block[when]),
    }  # fmt: skip

    def rate(weight: FloatArray, stretched: float = 1.0) -> float:
        drawn = {name: float(v @ weight) for name, v in by_block.items()}
        if not drawn["live"] > 0:
            return 0.0
        tail = 0.0
        if drawn["many"] > 0:
            tail = drawn["many"] * _mean_damage(
                curve, threshold, stretched * drawn["excess"] / drawn["many"]
            )
        return (drawn["below"] + tail) / drawn["live"]

    rng = np.random.default_rng(seed)
    # A mean excess is itself known to one part in the root of its number.
    draws = [
        rate(
            np.bincount(rng.integers(0, count, count), minlength=count).astype(float),
            float(rng.gamma(above)) / above,
        )
        for _ in range(DRAWS)
    ]
    whole, long_run = float(done.sum()) / live, rate(np.ones(count))
    # Few blocks hold the damage: draws of them scatter less than recordings do, as by Student.
    held = summed(done, block)
    few = max(float(held.sum() ** 2 / (held**2).sum()) - 1, 1.0)
    wider = float(student.ppf(0.95, few)) / SURE
    ends = np.maximum(np.quantile(draws, [0.05, 0.95]), 1e-300)
    low, high = (float(long_run * (end / long_run) ** wider) for end in ends)
    return Extrapolated(whole, long_run, (min(low, long_run), max(high, long_run)))


def _tail(of: Usage) -> int:
    """Return how many of the largest cycles are the tail: a tenth of those kept, ten at least."""
    return min(max(of.largest.size // 10, 10), of.largest.size)


def _mean_damage(curve: SNCurve, threshold: float, excess: float) -> float:
    """Return the mean damage of a cycle whose excess beyond a threshold is exponential."""
    # Gauss and Laguerre: 24 places are exact for a power of 47.
    places, weights = np.polynomial.laguerre.laggauss(24)
    return float(weights @ curve.damage(threshold + excess * places))


def customer(rates: ArrayLike, *, quantile: float) -> tuple[float, float]:
    """Return the damage rate that a share of customers stays below, and its upper 90 % bound.

    Rates (n,) of n vehicles are taken as lognormal; the bound is that of a tolerance interval.
    Source: Hahn & Meeker, Statistical Intervals (2017), section 4.6.
    """
    from scipy.stats import nct, norm

    logs = np.log(np.asarray(rates, float))
    n = logs.size
    mean, deviation = float(logs.mean()), float(logs.std(ddof=1))
    z = float(norm.ppf(quantile))
    k = float(nct.ppf(0.9, n - 1, z * np.sqrt(n))) / np.sqrt(n)
    return float(np.exp(mean + z * deviation)), float(np.exp(mean + k * deviation))


def shortened(of: Usage, *, keep: float = 0.95) -> float:
    """Return the share of the time in which a share of the damage came: a shorter test."""
    order = np.argsort(-of.damage, kind="stable")
    total = np.cumsum(of.damage[order])
    if not total.size or not total[-1] > 0:
        return 0.0
    needed = int(np.searchsorted(total, keep * total[-1])) + 1
    return float(of.live[order[:needed]].sum() / of.live.sum())


def equal_amplitude(damage: float, *, cycles: float, curve: SNCurve) -> float:
    """Return the amplitude of a test of so many cycles that does the same damage, Pa."""
    low, high = 0.0, 10 * curve.amplitude
    for _ in range(80):
        middle = (low + high) / 2
        if float(cycles * curve.damage(np.array(middle))) < damage:
            low = middle
        else:
            high = middle
    return high
