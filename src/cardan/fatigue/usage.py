"""When the damage came: second by second, so that route, gear, speed and torque can be told.

A cycle counts in the second in which it closes; what is left open at the end belongs to no
second. What seconds say is added up by what was driven in them, and sorted to see how short a test
can be; what they come to in the long run is told in `long_run`.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from cardan.base.arrays import ArrayLike, FloatArray, IntArray
from cardan.fatigue.correction import Correction, uncorrected
from cardan.fatigue.damage import damages, miner
from cardan.fatigue.rainflow import (
    NONE,
    Cycles,
    ResidueRule,
    four_point,
    half_cycles,
    reversals_of,
)
from cardan.fatigue.recording import cut
from cardan.fatigue.strength import SNCurve

SECOND = 1.0
"""Length of what is told apart, s."""
FINE = 0.01
"""Of the range that a stress had until then, by which it has to turn to be held."""
TOGETHER = 4096
"""Seconds that are held, and counted, at once."""
BESIDE = 30
"""Seconds to either side of one, of which its stress rises or falls from their usual level."""


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
    opened : (m,) 1
        As `damage`, by the second in which each cycle began.
    mean : (m,) Pa
        Mean stress; nan where nothing was heard.
    turns : m of (k,) Pa
        Where the stress turns in each second, but for what turns by less than `FINE`.
    """

    damage: FloatArray
    left: FloatArray
    high: FloatArray
    low: FloatArray
    at_high: FloatArray
    at_low: FloatArray
    live: FloatArray
    opened: FloatArray
    mean: FloatArray
    turns: tuple[npt.NDArray[np.float32], ...]
    until: IntArray

    @property
    def open(self) -> float:
        """Damage of what is left open."""
        return float(self.left.sum())

    @property
    def whole(self) -> float:
        """Damage of all cycles, closed and open."""
        return float(self.damage.sum()) + self.open

    @property
    def farthest(self) -> FloatArray:
        """When (m,) s the stress was farthest from its level; nan where nothing was heard.

        The level is the median of the seconds' means, half a minute to either side: of a pulse of
        some seconds it is still what was before and comes after, and a grade it follows.
        """
        from scipy.ndimage import median_filter

        heard = np.flatnonzero(~np.isnan(self.mean))
        found = np.full(self.mean.size, np.nan)
        if heard.size:
            level = median_filter(self.mean[heard], 2 * BESIDE + 1, mode="nearest")
            up, down = self.high[heard] - level, level - self.low[heard]
            found[heard] = np.where(up >= down, self.at_high[heard], self.at_low[heard])
        return found

    def turned(self, seconds: IntArray) -> npt.NDArray[np.float32]:
        """Return where the stress turns in some seconds (k,), one after the other."""
        until = np.append(0, self.until)
        found: list[npt.NDArray[np.float32]] = []
        for k in seconds.tolist():
            block = k // TOGETHER
            first, last = until[k : k + 2] - until[block * TOGETHER]
            found.append(self.turns[block][first:last])
        return np.concatenate(found)


def seconds_in(samples: int, *, rate: float) -> int:
    """Return how many seconds `usage` tells apart in so many samples."""
    return -(-samples // _size(rate))


def second_at(rate: float) -> float:
    """Return how long what `usage` tells apart lasts, s: a second, in whole samples."""
    return _size(rate) / rate


def _size(rate: float) -> int:
    return max(round(SECOND * rate), 2)


def usage(
    pieces: Iterable[FloatArray], *, rate: float, curve: SNCurve, correction: Correction,
    rule: ResidueRule,
) -> list[Usage]:  # fmt: skip
    """Return each gauge of a stress (gauges, n) Pa second by second."""
    size = _size(rate)
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
        self.rows = np.zeros((TOGETHER, 8))  # grown as seconds come
        self.turns: list[npt.NDArray[np.float32]] = []
        self.blocks: list[npt.NDArray[np.float32]] = []
        self.until: list[int] = []
        self.reach = (np.inf, -np.inf)
        self.met = np.empty(0, np.int64)

    def add(self, k: int, x: FloatArray, *, rate: float, start: float) -> None:
        before, met = self.residue, self.met
        cycles, self.residue = four_point(x, residue=before)
        # What was open and still is stands in front; what came on top is of this second.
        n = min(before.size, self.residue.size)
        same = int(np.logical_and.accumulate(before[:n] == self.residue[:n]).sum())
        self.met = np.append(self.met[:same], np.full(self.residue.size - same, k))
        known = np.flatnonzero(~np.isnan(x))
        top = bottom = at_top = at_bottom = mean = np.nan
        if known.size:
            i, j = known[np.argmax(x[known])], known[np.argmin(x[known])]
            top, bottom, mean = float(x[i]), float(x[j]), float(x[known].mean())
            at_top, at_bottom = start + i / rate, start + j / rate
            self.reach = min(self.reach[0], bottom), max(self.reach[1], top)
        low, high = self.reach
        turns = reversals_of(x, gate=FINE * max(high - low, 0.0)).astype(np.float32)
        self.turns.append(turns)
        self.until.append(turns.size + (self.until[-1] if k else 0))
        done = damages(cycles, curve=self.curve, correction=self.correction)
        began = np.full(done.size, k)
        if before.size:
            # At the last of what was open that is its start, else here.
            order = np.argsort(before, kind="stable")
            place = order[np.maximum(np.searchsorted(before[order], cycles.start, "right") - 1, 0)]
            began = np.where(before[place] == cycles.start, met[place], began)
        if k == len(self.rows):
            self.rows = np.concatenate([self.rows, np.zeros_like(self.rows)])
        self.rows[k, :6] = done.sum(), top, bottom, at_top, at_bottom, known.size / rate
        np.add.at(self.rows[:, 6], began, done)
        self.rows[k, 7] = mean
        if k % TOGETHER == TOGETHER - 1:
            self.blocks.append(np.concatenate(self.turns))
            self.turns = []

    def _equivalent(self, cycles: Cycles) -> FloatArray:
        return self.correction(cycles.amplitude, (cycles.start + cycles.end) / 2)

    def result(self, rule: ResidueRule) -> Usage:
        legs = rule(self.residue)
        order = np.argsort(self.residue, kind="stable")
        ends = (order[np.searchsorted(self.residue[order], e)] for e in (legs.start, legs.end))
        when = np.maximum(*(self.met[end] for end in ends))
        left = np.zeros(len(self.until))
        np.add.at(left, when, legs.count * self.curve.damage(self._equivalent(legs)))
        damage, high, low, at_high, at_low, live, opened, mean = self.rows[: left.size].T
        return Usage(
            damage, left, high, low, at_high, at_low, live, opened, mean,
            (*self.blocks, np.concatenate([np.empty(0, np.float32), *self.turns])),
            np.array(self.until),
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
    """Seconds of one sort: what closed in them, their time s and way m.

    `share` is of the whole damage, with what is left open; `of_closed` of what closed.
    """

    name: str
    damage: float
    share: float
    of_closed: float
    time: float
    distance: float


def grouped(of: Usage, names: Sequence[str], *, metres: FloatArray | None = None) -> list[Group]:
    """Return the damage by the sort of each second (m,); those of "" are of none.

    With what is left open, of no second, the groups are the whole damage. `metres` (m,) is the way
    of each second.
    """
    told = np.asarray(names)
    closed = float(of.damage.sum())
    found: list[Group] = []
    for name in dict.fromkeys(names):
        here = told == name
        damage = float(of.damage[here].sum())
        way = np.nan if metres is None else float(metres[here].sum())
        share, of_closed = (damage / all_ if all_ else np.nan for all_ in (of.whole, closed))
        found.append(Group(name, damage, share, of_closed, float(of.live[here].sum()), way))
    return found


def bands(values: ArrayLike, *, step: float) -> list[str]:
    """Name each value (m,) by its band of width `step`, "" where it is not known."""
    v = np.asarray(values, float)
    # On an edge is within: of a steady speed rounding makes two.
    low = np.floor(v / step + 1e-6) * step
    return ["" if np.isnan(a) else f"{a:g} .. {a + step:g}" for a in low]


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


def shortened(
    of: Usage, *, keep: float = 0.95, curve: SNCurve, correction: Correction = uncorrected,
    rule: ResidueRule = half_cycles,
) -> float:  # fmt: skip
    """Return the share of the time that a test takes which does a share of the damage.

    The seconds in which most cycles began and closed are joined, as many as it takes, and what is
    left of the stress is counted again: a cycle is lost with either of its ends.
    """

    def done(kept: IntArray) -> float:
        damage, left = 0.0, NONE
        for some in np.split(np.sort(kept), range(TOGETHER, kept.size, TOGETHER)):
            cycles, left = four_point(of.turned(some), residue=left)
            damage += miner(cycles, curve=curve, correction=correction)
        return damage + miner(rule(left), curve=curve, correction=correction)

    order = np.argsort(-(of.damage + of.opened + of.left), kind="stable")
    whole = done(order) if order.size else 0.0
    if not whole > 0:
        return 0.0
    few, many = 0, order.size
    while many - few > 1:
        middle = (few + many) // 2
        few, many = (few, middle) if done(order[:middle]) >= keep * whole else (middle, many)
    return float(of.live[order[:many]].sum() / of.live.sum())


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
