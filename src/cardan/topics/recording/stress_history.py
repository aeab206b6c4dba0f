"""Stress of a gauge over time as a picture shows it: an envelope, and damage by stretch.

Both are gathered while pieces pass, so that a recording of any length takes the same memory.
"""

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from math import ceil

import numpy as np

from cardan.core.arrays import FloatArray, IntArray
from cardan.physics.fatigue.damage import cycle_damages
from cardan.physics.fatigue.rainflow import EMPTY_REVERSALS, four_point
from cardan.physics.signals.assessment import AssessmentSettings
from cardan.physics.signals.conditioning import ChannelReport
from cardan.physics.signals.data_quality import (
    FaultRule,
    apply_rules,
    sample_intervals_masked_by_time,
)
from cardan.physics.signals.faults.intervals import merge_runs

MAX_ENVELOPE_COLUMNS = 600
"""Columns of an envelope, at most: a page shows no more."""
MAX_STRETCHES = 45
"""Stretches of a recording that damage is divided by, at most."""
STRETCH_LENGTHS_S = (
    0.1, 0.2, 0.5, 1.0, 2.0, 5.0, 10.0, 20.0, 30.0, 60.0, 120.0, 300.0, 600.0, 1200.0, 1800.0,
    3600.0, 7200.0, 14400.0, 28800.0, 86400.0,
)  # fmt: skip
"""Lengths of a stretch that read well on an axis of time, s."""


@dataclass(frozen=True, kw_only=True)
class StressHistory:
    """Stress of one gauge over a recording, treated as it was counted.

    Attributes
    ----------
    column_length : s
        Of each column of the envelope.
    low, high : (m,) Pa
        Smallest and largest stress of each column; nan where there is no valid sample.
    stretch_length : s
        Of each stretch.
    damage : (k,) 1
        Of each stretch: of the cycles that close in it, and of the residue's whose later reversal
        is in it. Their sum is the damage of the recording.
    """

    column_length: float
    low: FloatArray
    high: FloatArray
    stretch_length: float
    damage: FloatArray

    @property
    def damage_shares(self) -> FloatArray:
        """Share of the damage of each stretch, (k,) 1; zero where there is no damage."""
        total = float(self.damage.sum())
        return self.damage / total if total > 0 else np.zeros_like(self.damage)


def samples_per_stretch(samples: int, *, rate: float) -> int:
    """Return the samples of a stretch of a recording: the shortest that reads well."""
    seconds = samples / rate
    length = next(
        (s for s in STRETCH_LENGTHS_S if seconds <= MAX_STRETCHES * s), seconds / MAX_STRETCHES
    )
    return max(math.ceil(length * rate), 1)


class StressHistoryCounter:
    """Histories of some gauges, as pieces of their stress pass."""

    def __init__(
        self, plan: AssessmentSettings, *, samples: int, rate: float, interpolated: Sequence[bool]
    ) -> None:
        """Begin with a recording of so many samples.

        `interpolated` says of each gauge whether its damage is counted on crests between samples,
        by `count_interpolated`.
        """
        self.rate, self.interpolated = rate, tuple(interpolated)
        self.column = max(ceil(samples / MAX_ENVELOPE_COLUMNS), 1)
        self.stretch = samples_per_stretch(samples, rate=rate)
        columns, gauges = ceil(samples / self.column), len(self.interpolated)
        self.low = np.full((gauges, columns), np.nan)
        self.high = np.full((gauges, columns), np.nan)
        count = ceil(samples / self.stretch)
        self.damages = [_StretchDamage(plan, count) for _ in range(gauges)]

    def observed(self, pieces: Iterable[FloatArray]) -> Iterator[FloatArray]:
        """Yield pieces (gauges, n) Pa as they are, and take them."""
        start = 0
        for piece in pieces:
            self._take_envelope(piece, start)
            for x, damage, between in zip(piece, self.damages, self.interpolated, strict=True):
                if not between:
                    damage.update(x, start, self.stretch)
            start += piece.shape[-1]
            yield piece

    def count_interpolated(self, pieces: Iterable[FloatArray], *, times: int) -> None:
        """Take the stress of the interpolated gauges, of `times` as many samples."""
        own = [d for d, between in zip(self.damages, self.interpolated, strict=True) if between]
        start = 0
        for piece in pieces:
            for x, damage in zip(piece, own, strict=True):
                damage.update(x, start, times * self.stretch)
            start += piece.shape[-1]

    def histories(self) -> tuple[StressHistory, ...]:
        """Return what passed, gauge by gauge."""
        return tuple(
            StressHistory(
                column_length=self.column / self.rate, low=low, high=high,
                stretch_length=self.stretch / self.rate, damage=damage.result(),
            )
            for low, high, damage in zip(self.low, self.high, self.damages, strict=True)
        )  # fmt: skip

    def _take_envelope(self, piece: FloatArray, start: int) -> None:
        n = piece.shape[-1]
        if not n:
            return
        first = np.append(0, np.arange(-start % self.column or self.column, n, self.column))
        at = (start + first) // self.column
        self.low[:, at] = np.fmin(self.low[:, at], np.fmin.reduceat(piece, first, axis=1))
        self.high[:, at] = np.fmax(self.high[:, at], np.fmax.reduceat(piece, first, axis=1))


class _StretchDamage:
    """Damage of one gauge by stretches, as pieces pass."""

    def __init__(self, plan: AssessmentSettings, stretches: int) -> None:
        self.plan, self.residue = plan, EMPTY_REVERSALS
        self.damage = np.zeros(stretches)
        self.met: IntArray = np.empty(0, np.int64)
        """The stretch of each reversal of the residue."""

    def update(self, x: FloatArray, start: int, stretch: int) -> None:
        """Take a piece (n,) that begins at a sample, of stretches of so many samples."""
        first = np.append(0, np.arange(-start % stretch or stretch, x.size, stretch))
        for part, at in zip(np.split(x, first[1:]), (start + first) // stretch, strict=True):
            before = self.residue
            cycles, self.residue = four_point(part, residue=before)
            # What was open and still is stands in front; the others are of this stretch.
            n = min(before.size, self.residue.size)
            same = int(np.logical_and.accumulate(before[:n] == self.residue[:n]).sum())
            self.met = np.append(self.met[:same], np.full(self.residue.size - same, at))
            self.damage[at] += cycle_damages(
                cycles, curve=self.plan.curve, correction=self.plan.correction
            ).sum()

    def result(self) -> FloatArray:
        """Return the damage of each stretch, with that of the residue."""
        legs = self.plan.residue_rule(self.residue)
        order = np.argsort(self.residue, kind="stable")
        ends = [order[np.searchsorted(self.residue[order], e)] for e in (legs.start, legs.end)]
        found = self.damage.copy()
        np.add.at(
            found, np.maximum(self.met[ends[0]], self.met[ends[1]]),
            cycle_damages(legs, curve=self.plan.curve, correction=self.plan.correction),
        )  # fmt: skip
        return found


MASKED_BY_TIME_KIND = ""
"""Kind of what a rule masks by its time alone."""


@dataclass(frozen=True, kw_only=True)
class MarkedStretches:
    """Stretches of a gauge's channels that look wrong or are masked, of one kind of fault.

    Attributes
    ----------
    kind
        Code of the fault; `MASKED_BY_TIME_KIND` of what is masked by its time alone.
    masked, undecided, accepted : (k, 2) s
        Begin and end of the stretches that rules mask or correct, those without a rule, and those
        that rules accept, since the start of the recording.
    """

    kind: str
    masked: FloatArray
    undecided: FloatArray
    accepted: FloatArray


def marked_stretches(
    reports: Mapping[str, ChannelReport], *, rules: Sequence[FaultRule], rate: float
) -> tuple[MarkedStretches, ...]:
    """Return what looks wrong or is masked in the channels of a gauge, by kind of fault."""
    found: dict[str, list[tuple[IntArray, IntArray, IntArray]]] = {}
    for channel, report in reports.items():
        for kind, of in apply_rules(report, channel=channel, rules=rules, rate=rate).items():
            decided = (of.masked, of.undecided)
            rest = of.intervals.runs
            for some in decided:
                rest = rest[~np.isin(rest[:, 0], some[:, 0])]
            found.setdefault(kind, []).append((*decided, rest))
        by_time = sample_intervals_masked_by_time(
            channel=channel, rules=rules, rate=rate, samples=report.samples
        )
        if len(by_time):
            found.setdefault(MASKED_BY_TIME_KIND, []).append((by_time, by_time[:0], by_time[:0]))
    return tuple(
        MarkedStretches(
            kind=kind,
            **{
                name: merge_runs(part[k] for part in parts) / rate
                for k, name in enumerate(("masked", "undecided", "accepted"))
            },
        )
        for kind, parts in found.items()
        if any(len(runs) for part in parts for runs in part)
    )
