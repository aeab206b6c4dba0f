"""Largest damage that a gauge may have had while it was frozen, missing or masked.

A gauge that stops in the middle of a drive hides what the part went on to feel. As damage goes by a
high power of stress, its mean over the rest says little of so short a time: the bound is that the
hidden seconds were the worst of those recorded. What no second recorded it does not hold.
"""

import math

import numpy as np

from cardan.core.arrays import FloatArray, IntArray
from cardan.physics.fatigue.damage import cycle_damages
from cardan.physics.fatigue.mean_stress import MeanStressCorrection
from cardan.physics.fatigue.rainflow import EMPTY_REVERSALS, ResidueRule, four_point
from cardan.physics.fatigue.sn_curve import SNCurve

INTERVAL_S = 1.0
"""Time whose damage is counted by itself, s; a gap hides as many as it is begun seconds long."""
MIN_COUNTED_GAP_S = 0.1
"""Shortest gap that is counted: a shorter one hides no whole cycle of what is slower than 10 Hz."""


class IntervalDamage:
    """Damage of one stress interval by interval, as pieces pass; a cycle is where it closes."""

    def __init__(
        self, *, rate: float, curve: SNCurve, correction: MeanStressCorrection, rule: ResidueRule
    ) -> None:
        self.curve, self.correction, self.rule = curve, correction, rule
        self.size = max(round(INTERVAL_S * rate), 2)
        self.tail, self.residue = EMPTY_REVERSALS, EMPTY_REVERSALS
        self.damages: list[float] = []

    def update(self, stress: FloatArray) -> None:
        """Take a piece of it (n,) Pa."""
        x = np.concatenate([self.tail, stress])
        full = x.size // self.size * self.size
        for interval in x[:full].reshape(-1, self.size):
            self._count(interval)
        self.tail = x[full:].copy()

    def _count(self, stress: FloatArray) -> None:
        cycles, self.residue = four_point(stress, residue=self.residue)
        done = cycle_damages(cycles, curve=self.curve, correction=self.correction)
        self.damages.append(float(done.sum()))

    def worst(self, count: int) -> float:
        """Return the damage of so many intervals, the worst ones; each leg left open is one."""
        if self.tail.size:
            self._count(self.tail)
            self.tail = EMPTY_REVERSALS
        left = cycle_damages(self.rule(self.residue), curve=self.curve, correction=self.correction)
        each = np.sort(np.concatenate([self.damages, left]))[::-1]
        if not each.size:
            return math.nan
        whole, rest = divmod(count, each.size)
        return float(whole * each.sum() + each[:rest].sum())


def hidden_interval_count(runs: IntArray, *, rate: float) -> int:
    """Return how many intervals runs of samples (k, 2) hide, the shortest runs left out."""
    length = (runs[:, 1] - runs[:, 0]) / rate
    return int(np.ceil(length[length >= MIN_COUNTED_GAP_S] / INTERVAL_S).sum())
