"""When the damage came, second by second: to assign it to route, gear, speed and torque.

A cycle counts in the second in which it closes; what is left open at the end belongs to no
second. What seconds say is added up by what was driven in them, and sorted to see how short a test
can be; what they come to in the long run is in `damage_extrapolation`.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from cardan.core.arrays import ArrayLike, FloatArray, IntArray
from cardan.physics.fatigue.damage import cycle_damages, miner_damage
from cardan.physics.fatigue.mean_stress import MeanStressCorrection, uncorrected
from cardan.physics.fatigue.rainflow import (
    EMPTY_REVERSALS,
    Cycles,
    ResidueRule,
    four_point,
    half_cycles,
    significant_reversals,
)
from cardan.physics.fatigue.sn_curve import SNCurve
from cardan.physics.signals.recording import rechunk_to_block_size

INTERVAL_S = 1.0
"""Length of one interval of usage, s."""
MIN_REVERSAL_RANGE_SHARE = 0.01
"""Of the range that a stress had until then, by which it has to turn to be held."""
INTERVALS_PER_BLOCK = 4096
"""Seconds that are held, and counted, at once."""
STRESS_LEVEL_HALF_WINDOW_INTERVALS = 30
"""Seconds to either side of one, of which its stress rises or falls from their usual level."""


@dataclass(frozen=True)
class UsageHistory:
    """One gauge, second by second (m,).

    Attributes
    ----------
    damage : (m,) 1
        Of the cycles that closed in each second.
    open_damage : (m,) 1
        Of what is left open, by the rule for the residue and by the second a leg of it ends in.
    high, low : (m,) Pa
        Largest and smallest stress; nan where nothing was recorded.
    at_high, at_low : (m,) s
        When these were.
    live : (m,) s
        Time that was recorded.
    damage_by_cycle_start : (m,) 1
        As `damage`, by the second in which each cycle began.
    mean : (m,) Pa
        Mean stress; nan where nothing was recorded.
    reversals : m of (k,) Pa
        Where the stress turns in each second, but for what turns by less than
        `MIN_REVERSAL_RANGE_SHARE`.
    """

    damage: FloatArray
    open_damage: FloatArray
    high: FloatArray
    low: FloatArray
    at_high: FloatArray
    at_low: FloatArray
    live: FloatArray
    damage_by_cycle_start: FloatArray
    mean: FloatArray
    reversals: tuple[npt.NDArray[np.float32], ...]
    reversal_counts: IntArray

    @property
    def total_open_damage(self) -> float:
        """Damage of what is left open."""
        return float(self.open_damage.sum())

    @property
    def total_damage(self) -> float:
        """Damage of all cycles, closed and open."""
        return float(self.damage.sum()) + self.total_open_damage

    @property
    def time_of_max_deviation(self) -> FloatArray:
        """When (m,) s the stress was farthest from its level; nan where nothing was recorded.

        The level is the median of the seconds' means, half a minute to either side: of a pulse of
        some seconds it is still what was before and comes after, and a grade it follows.
        """
        from scipy.ndimage import median_filter

        heard = np.flatnonzero(~np.isnan(self.mean))
        found = np.full(self.mean.size, np.nan)
        if heard.size:
            level = median_filter(
                self.mean[heard], 2 * STRESS_LEVEL_HALF_WINDOW_INTERVALS + 1, mode="nearest"
            )
            up, down = self.high[heard] - level, level - self.low[heard]
            found[heard] = np.where(up >= down, self.at_high[heard], self.at_low[heard])
        return found

    def reversals_in(self, seconds: IntArray) -> npt.NDArray[np.float32]:
        """Return where the stress turns in some seconds (k,), one after the other."""
        until = np.append(0, self.reversal_counts)
        found: list[npt.NDArray[np.float32]] = []
        for k in seconds.tolist():
            block = k // INTERVALS_PER_BLOCK
            first, last = until[k : k + 2] - until[block * INTERVALS_PER_BLOCK]
            found.append(self.reversals[block][first:last])
        return np.concatenate(found)


def interval_count(samples: int, *, rate: float) -> int:
    """Return how many seconds `usage` has for so many samples."""
    return -(-samples // _interval_samples(rate))


def interval_length(rate: float) -> float:
    """Return the length of one interval of `usage`, s: a second, in whole samples."""
    return _interval_samples(rate) / rate


def _interval_samples(rate: float) -> int:
    return max(round(INTERVAL_S * rate), 2)


def usage_histories(
    pieces: Iterable[FloatArray], *, rate: float, curve: SNCurve, correction: MeanStressCorrection,
    rule: ResidueRule,
) -> list[UsageHistory]:  # fmt: skip
    """Return each gauge of a stress (gauges, n) Pa second by second."""
    size = _interval_samples(rate)
    found: list[_UsageCounter] = []
    for k, piece in enumerate(rechunk_to_block_size(pieces, size=size)):
        if not found:
            found = [_UsageCounter(curve, correction) for _ in piece]
        for one, x in zip(found, piece, strict=True):
            one.update(k, x, rate=rate, start=k * size / rate)
    return [one.result(rule) for one in found]


class _UsageCounter:
    """A gauge as its seconds pass."""

    def __init__(self, curve: SNCurve, correction: MeanStressCorrection) -> None:
        self.curve, self.correction, self.residue = curve, correction, EMPTY_REVERSALS
        self.rows = np.zeros((INTERVALS_PER_BLOCK, 8))  # grown as seconds come
        self.turns: list[npt.NDArray[np.float32]] = []
        self.blocks: list[npt.NDArray[np.float32]] = []
        self.until: list[int] = []
        self.reach = (np.inf, -np.inf)
        self.met = np.empty(0, np.int64)

    def update(self, k: int, x: FloatArray, *, rate: float, start: float) -> None:
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
        turns = significant_reversals(
            x, gate=MIN_REVERSAL_RANGE_SHARE * max(high - low, 0.0)
        ).astype(np.float32)
        self.turns.append(turns)
        self.until.append(turns.size + (self.until[-1] if k else 0))
        done = cycle_damages(cycles, curve=self.curve, correction=self.correction)
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
        if k % INTERVALS_PER_BLOCK == INTERVALS_PER_BLOCK - 1:
            self.blocks.append(np.concatenate(self.turns))
            self.turns = []

    def _equivalent(self, cycles: Cycles) -> FloatArray:
        return self.correction(cycles.amplitude, (cycles.start + cycles.end) / 2)

    def result(self, rule: ResidueRule) -> UsageHistory:
        legs = rule(self.residue)
        order = np.argsort(self.residue, kind="stable")
        ends = (order[np.searchsorted(self.residue[order], e)] for e in (legs.start, legs.end))
        when = np.maximum(*(self.met[end] for end in ends))
        left = np.zeros(len(self.until))
        np.add.at(left, when, legs.count * self.curve.damage(self._equivalent(legs)))
        damage, high, low, at_high, at_low, live, opened, mean = self.rows[: left.size].T
        return UsageHistory(
            damage, left, high, low, at_high, at_low, live, opened, mean,
            (*self.blocks, np.concatenate([np.empty(0, np.float32), *self.turns])),
            np.array(self.until),
        )  # fmt: skip


@dataclass(frozen=True)
class StressPeak:
    """A largest stress of either sign: Pa, and when, s."""

    stress: float
    time: float


def stress_peaks(of: UsageHistory, *, count: int = 8, apart: float = 5.0) -> list[StressPeak]:
    """Return the largest stresses by size, some seconds apart from each other."""
    stress = np.concatenate([of.high, of.low])
    time = np.concatenate([of.at_high, of.at_low])
    known = ~np.isnan(stress)
    stress, time = stress[known], time[known]
    found: list[StressPeak] = []
    for k in np.argsort(-np.abs(stress), kind="stable"):
        if all(abs(time[k] - p.time) >= apart for p in found):
            found.append(StressPeak(float(stress[k]), float(time[k])))
        if len(found) == count:
            break
    return found


@dataclass(frozen=True)
class UsageBin:
    """Seconds of one sort: what closed in them, their time s and way m.

    `share` is of the whole damage, with what is left open; `closed_damage_share` of what closed.
    """

    name: str
    damage: float
    share: float
    closed_damage_share: float
    time: float
    distance: float


def damage_by_bin(
    of: UsageHistory, names: Sequence[str], *, metres: FloatArray | None = None
) -> list[UsageBin]:
    """Return the damage by the sort of each second (m,); those of "" are of none.

    With what is left open, of no second, the groups are the whole damage. `metres` (m,) is the way
    of each second.
    """
    told = np.asarray(names)
    closed = float(of.damage.sum())
    found: list[UsageBin] = []
    for name in dict.fromkeys(names):
        here = told == name
        damage = float(of.damage[here].sum())
        way = np.nan if metres is None else float(metres[here].sum())
        share, of_closed = (damage / all_ if all_ else np.nan for all_ in (of.total_damage, closed))
        found.append(UsageBin(name, damage, share, of_closed, float(of.live[here].sum()), way))
    return found


def band_labels(values: ArrayLike, *, step: float) -> list[str]:
    """Name each value (m,) by its band of width `step`, "" where it is not known."""
    v = np.asarray(values, float)
    # On an edge is within: of a steady speed rounding makes two.
    low = np.floor(v / step + 1e-6) * step
    return ["" if np.isnan(a) else f"{a:g} .. {a + step:g}" for a in low]


def customer_damage_rate_percentile(rates: ArrayLike, *, quantile: float) -> tuple[float, float]:
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


def accelerated_test_time_share(
    of: UsageHistory,
    *,
    keep: float = 0.95,
    curve: SNCurve,
    correction: MeanStressCorrection = uncorrected,
    rule: ResidueRule = half_cycles,
) -> float:
    """Return the share of the time that a test takes which does a share of the damage.

    The seconds in which most cycles began and closed are joined, as many as it takes, and what is
    left of the stress is counted again: a cycle is lost with either of its ends.
    """

    def done(kept: IntArray) -> float:
        damage, left = 0.0, EMPTY_REVERSALS
        for some in np.split(
            np.sort(kept), range(INTERVALS_PER_BLOCK, kept.size, INTERVALS_PER_BLOCK)
        ):
            cycles, left = four_point(of.reversals_in(some), residue=left)
            damage += miner_damage(cycles, curve=curve, correction=correction)
        return damage + miner_damage(rule(left), curve=curve, correction=correction)

    order = np.argsort(-(of.damage + of.damage_by_cycle_start + of.open_damage), kind="stable")
    whole = done(order) if order.size else 0.0
    if not whole > 0:
        return 0.0
    few, many = 0, order.size
    while many - few > 1:
        middle = (few + many) // 2
        few, many = (few, middle) if done(order[:middle]) >= keep * whole else (middle, many)
    return float(of.live[order[:many]].sum() / of.live.sum())


def damage_equivalent_stress_amplitude(damage: float, *, cycles: float, curve: SNCurve) -> float:
    """Return the amplitude of a test of so many cycles that does the same damage, Pa."""
    low, high = 0.0, 10 * curve.amplitude
    for _ in range(80):
        middle = (low + high) / 2
        if float(cycles * curve.damage(np.array(middle))) < damage:
            low = middle
        else:
            high = middle
    return high
