"""Changes of a channel's gain or filter by the steps of its values, without another gauge.

A converter writes multiples of one step. Who multiplies the values from some time on multiplies
the step as well, and who filters them leaves none; no vehicle does either. Nothing is found where
values have no step, or where the amplifier changes in front of the converter.
"""

from itertools import pairwise

import numpy as np

from cardan.core.arrays import FloatArray
from cardan.physics.signals.faults.fault_kind import (
    ChannelStatistics,
    DetectedFaults,
    FaultSource,
    SignalBlock,
)
from cardan.physics.signals.faults.gain_change import FAULT_GAIN
from cardan.physics.signals.faults.intervals import fault_intervals
from cardan.physics.signals.faults.lost_response import FAULT_RESPONSE

SPAN_S, MIN_SPAN_SAMPLES, MAX_VALUES_PER_SPAN = 1.0, 500, 1000
"""Time whose values are looked at together, the fewest samples of it, and the most looked at."""
MIN_UNEQUAL_VALUES = 50
"""Values of a span that differ, from which it says something."""
MAX_GAPS_IN_STEPS = 50.0
"""Gaps between neighbouring values by which a step is found, in steps."""
MAX_DISTANCE_FROM_MULTIPLE = 0.1
"""Steps that a gap may be off a whole number of them: float32 rounds, and chance hits a fifth."""
MIN_SHARE_ON_STEPS, MAX_SHARE_ON_STEPS_BY_CHANCE = 0.95, 0.4
"""Share of the gaps that are whole numbers of a step, where there is one, and where none."""
MIN_TURNING_SHARE, MIN_DISTINCT_MOVE_SIZES = 0.02, 4
"""Share of the samples at which what shakes turns, and numbers of steps that it goes by."""
MIN_SPANS_OF_A_STEP = 5
"""Spans that have a step, or none, in a row: fewer are a blow that was written otherwise."""
MAX_SAME_STEP_DIFFERENCE_LN = 0.02
"""Difference of the logarithms of two steps that are one."""
FORMAT_FACTORS = (2.0, 10.0)
"""Numbers of few digits have steps that grow with their size, by powers of these."""
MAX_SWING_TO_STEP_DEVIATION = 0.5
"""How far, as logarithms, the swing may go otherwise than the step does, in changes of that step:
only so a step that grows by a power of those is of a gain."""


class ValueStepDetector:
    """Finds the step of a channel's values, span by span."""

    def __init__(self, rate: float) -> None:
        self.size = max(round(SPAN_S * rate), MIN_SPAN_SAMPLES)
        self.tail: FloatArray = np.empty(0)
        self.steps: list[float] = []
        self.swings: list[float] = []
        self.latest = np.nan

    def update(self, block: SignalBlock) -> None:
        """Take the next piece."""
        whole = np.concatenate([self.tail, block.samples])
        full = whole.size // self.size * self.size
        for span in whole[:full].reshape(-1, self.size):
            some = span[:MAX_VALUES_PER_SPAN]
            known = np.unique(some[~np.isnan(some)])
            step = step_of_values(known, expected=self.latest)
            step = np.nan if step > 0 and not _shakes(some, step) else step
            self.latest = step if step > 0 else self.latest
            self.steps.append(step)
            tenth = known.size // 10
            self.swings.append(float(known[-1 - tenth] - known[tenth]) if known.size else np.nan)
        self.tail = whole[full:].copy()

    def result(self, of: ChannelStatistics) -> DetectedFaults:
        """Return where the step changes, as a gain, and where there is none, as lost response."""
        if not of.alive:
            return {}
        runs = _runs_of_one_step(np.array(self.steps))
        swings = np.array(self.swings)
        gains: list[tuple[int, float]] = []
        stepped = [run for run in runs if run[2] > 0]
        for (a, b, one), (c, d, other) in pairwise(stepped):
            change = np.log(other / one)
            with np.errstate(divide="ignore", invalid="ignore"):
                swung = np.log(np.nanmedian(swings[c:d]) / np.nanmedian(swings[a:b]))
            if not _is_of_format(change) or (
                abs(swung - change) < MAX_SWING_TO_STEP_DEVIATION * abs(change)
            ):
                gains.append((c * self.size, other / one))
        lost = [(a, b) for a, b, step in runs if step == 0]
        found = {
            FAULT_GAIN: fault_intervals([(k, k + 1) for k, _ in gains], [f for _, f in gains]),
            FAULT_RESPONSE: fault_intervals([(a * self.size, b * self.size) for a, b in lost]),
        }
        return {kind: where for kind, where in found.items() if where.count}


def _shakes(x: FloatArray, step: float) -> bool:
    """Return whether samples (n,) go to and fro by several numbers of steps.

    What climbs evenly, as a speed does, may go three steps at a time, and shows no smaller one.
    """
    moves = np.diff(x[~np.isnan(x)])
    turns = float(np.mean(moves[1:] * moves[:-1] < 0))
    return (
        turns >= MIN_TURNING_SHARE
        and np.unique(np.rint(np.abs(moves) / step)).size > MIN_DISTINCT_MOVE_SIZES
    )


def _is_of_format(change: float) -> bool:
    """Return whether a change of a step, as a logarithm, is a power of a format's factor."""
    each = np.log(FORMAT_FACTORS)
    off = np.abs(change - np.rint(change / each) * each)
    return bool((off < MAX_SAME_STEP_DIFFERENCE_LN).any())


def step_of_values(values: FloatArray, *, expected: float = np.nan) -> float:
    """Return the step that values (n,), rising, are apart by whole numbers of.

    Returns
    -------
    float
        0 where they have none though they were `expected` to have that one; nan if unknown.
    """
    if values.size < MIN_UNEQUAL_VALUES:
        return np.nan
    gaps = np.diff(values)
    rounding = 4 * np.finfo(float).eps * float(np.abs(values).max())
    step = float(gaps.min())
    if not step > rounding / MAX_DISTANCE_FROM_MULTIPLE:
        step = np.nan
    # Of longer and longer gaps its last digits.
    for most in (1.5, 5.0, 15.0, MAX_GAPS_IN_STEPS):
        near = gaps[gaps < most * step]
        if near.size:
            step = float(near.sum() / np.rint(near / step).sum())
    near = gaps[gaps < MAX_GAPS_IN_STEPS * step]
    if near.size >= MIN_UNEQUAL_VALUES / 2 and _share_on_steps(near, step) >= MIN_SHARE_ON_STEPS:
        return step
    if not rounding < MAX_DISTANCE_FROM_MULTIPLE * expected:
        return np.nan
    share = _share_on_steps(gaps, expected)
    if share >= MIN_SHARE_ON_STEPS:
        return expected
    return 0.0 if share < MAX_SHARE_ON_STEPS_BY_CHANCE else np.nan


def _share_on_steps(gaps: FloatArray, step: float) -> float:
    many = gaps / step
    return float(np.mean(np.abs(many - np.rint(many)) < MAX_DISTANCE_FROM_MULTIPLE))


def _runs_of_one_step(steps: FloatArray) -> list[tuple[int, int, float]]:
    """Return spans, first and one behind the last, that have one step, or none (0)."""
    runs: list[tuple[int, int, float]] = []
    counts: list[int] = []
    for k in np.flatnonzero(~np.isnan(steps)):
        step = float(steps[k])
        if runs and _same(runs[-1][2], step):
            runs[-1] = (runs[-1][0], int(k) + 1, runs[-1][2])
            counts[-1] += 1
        else:
            runs.append((int(k), int(k) + 1, step))
            counts.append(1)
    kept: list[tuple[int, int, float]] = []
    for run, count in zip(runs, counts, strict=True):
        if count < MIN_SPANS_OF_A_STEP:
            continue
        if kept and _same(kept[-1][2], run[2]):
            kept[-1] = (kept[-1][0], run[1], run[2])
        else:
            kept.append(run)
    return kept


def _same(one: float, other: float) -> bool:
    if not (one > 0 and other > 0):
        return one == other
    return bool(abs(np.log(one / other)) < MAX_SAME_STEP_DIFFERENCE_LN)


FAULT_SOURCE = FaultSource(kinds=(), detector=ValueStepDetector)
