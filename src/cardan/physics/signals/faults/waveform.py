"""Faults that the course of samples shows: holes, numbers for no value, jumps, clips, freezes.

One detector finds them all, because one hides another: a dropout's edges are jumps, a clip held for
long stands still, and what jumps off and back is no step of the zero.
"""

import numpy as np

from cardan.core.arrays import FloatArray, IntArray
from cardan.physics.signals.faults import gain_change, zero_step
from cardan.physics.signals.faults.clipped_peaks import (
    MIN_CLIPPED_SAMPLES,
    ClippedPeaks,
    PeakTracker,
    clipped_heights,
    clipped_heights_by_flank,
    extremes_of_runs,
    parabola_height_ratio,
)
from cardan.physics.signals.faults.discontinuities import find_discontinuities, gain_factors
from cardan.physics.signals.faults.fault_kind import (
    ChannelStatistics,
    FaultKind,
    FaultSource,
    SignalBlock,
)
from cardan.physics.signals.faults.gain_breaks import PREDICTION_ORDER, GainBreakDetector
from cardan.physics.signals.faults.gain_change import FAULT_GAIN
from cardan.physics.signals.faults.intervals import (
    NO_FAULTS,
    FaultIntervals,
    fault_intervals,
    merge_runs,
    overlaps,
)
from cardan.physics.signals.faults.jumps import (
    JUMP_NEIGHBOURHOOD_SAMPLES,
    MAX_STEP_S,
    MAX_STEP_SAMPLES,
    find_jumps,
    find_level_steps,
    find_single_spikes,
    lagged_differences,
)
from cardan.physics.signals.faults.long_runs import LongRuns
from cardan.physics.signals.faults.quiet_stretches import QuietStretches
from cardan.physics.signals.faults.zero_step import FAULT_ZERO_SHIFT

FAULT_MISSING_SAMPLES, FAULT_SENTINEL, FAULT_SPIKE, FAULT_DROPOUT = (
    "hole",
    "sentinel",
    "spike",
    "dropout",
)
FAULT_CLIP, FAULT_FREEZE = "clip", "freeze"

SENTINEL_VALUES = (
    -32768.0, 32767.0, 65535.0, -999.25, 9.96921e36, 1e30, -1e30, 1e20, -1e20,
    *(sign * value for sign in (-1.0, 1.0) for value in (999.0, 9999.0, 99999.0, 999999.0)),
)  # fmt: skip
"""Numbers that loggers write where they have none."""
MIN_SENTINEL_MAGNITUDE = min(map(abs, SENTINEL_VALUES))
"""Of their sizes."""

BLUNT_CREST_BAND_SHARE_OF_RANGE = 0.03
"""Of all that a channel spans, how far below its end crests are looked at that noise or a filter
left next to level."""
MIN_CLIPPED_HEIGHT_TO_CREST_RANGE_RATIO = 6.0
"""Times the range of its middle (`FLANK_SHARE_OF_CREST_SAMPLES`) from which what a parabola through
a crest's flanks puts on top was cut off: of a crest of many samples that turns by itself it is 2.8
times that."""
MAX_REPEATED_CREST_SLOPE_SPREAD_SHARE, MIN_REPEATED_CREST_HEIGHT_RATIO = 0.2, 1.2
"""How far apart quartiles of the flanks' slopes are, of their median, where one swing comes again
and again, as on a rig; there it is so many times what it is of as few samples that turn alone."""
FLANK_SHARE_OF_CREST_SAMPLES = 0.2
"""Share of a crest's samples that lies to either side of its middle."""
MAX_SPIKE_SAMPLES = 3
"""Longest spike, samples; what is longer and level is a dropout."""
MAX_CONSTANT_VALUE_DROPOUT_S = 0.25
"""Longest dropout that is looked at as a whole, and has to be level."""
MAX_CONTACT_LOSS_S = 10.0
"""Longest of all: a contact that was lost between two steps. What stays longer is another zero."""
MIN_FREEZE_S = 0.1
"""Shortest freeze, of 20 samples at least, and of 20 times as long as the channel's own steps."""
STANDSTILL_WINDOW_S, MAX_STANDSTILL_SWING_SHARE = 0.1, 0.1
"""Time to either side of a freeze's ends, and of the channel's usual swing how far it moves there
where it comes to rest by itself: a vehicle that stops rings down, a channel that fails does not."""
MIN_DISCONTINUITY_TO_USUAL_SWING_RATIO, MIN_DISCONTINUITY_SIZE_RESOLUTION_STEPS = 0.5, 4
"""Times the channel's usual swing, and steps of its own, that a jump has at least."""
MIN_DISCONTINUITIES, MIN_DISCONTINUITIES_RULING_OUT_CONTACT_LOSS = 4, 12
"""Of which the levels know nothing, and that are suspects all the same; and from how many on two of
them are no contact that was lost."""
MAX_MEAN_SAMPLES_PER_UNCHANGED_VALUE = 2.0
"""Samples that a channel keeps a value for on average, from which it moves by jumps alone."""
EXTREMES_BLOCK_SAMPLES = 1024
"""Samples whose highest and lowest are kept."""


def detector_overlap_samples(rate: float) -> int:
    """Return the samples to either side of a piece that `FaultDetector` needs."""
    return (
        max(round(MAX_CONSTANT_VALUE_DROPOUT_S * rate), MAX_SPIKE_SAMPLES)
        + JUMP_NEIGHBOURHOOD_SAMPLES
        + 4
    )


class WaveformFaultDetector:
    """Finds one channel's faults of these kinds, as its pieces pass."""

    def __init__(self, rate: float) -> None:
        self.rate, self.reach = rate, detector_overlap_samples(rate)
        self.widths = tuple(sorted({1, min(MAX_STEP_SAMPLES, max(round(MAX_STEP_S * rate), 1))}))
        self.start = 0
        self.jumps: list[tuple[IntArray, FloatArray]] = []
        self.steps: list[tuple[IntArray, FloatArray]] = []
        self.tears: list[tuple[IntArray, FloatArray, FloatArray]] = []
        self.sentinels: list[tuple[IntArray, FloatArray]] = []
        self.top, self.bottom = ClippedPeaks(), ClippedPeaks()
        self.crests = {1: PeakTracker(), -1: PeakTracker()}
        self.blunt: dict[int, FloatArray] = {1: np.empty((0, 6)), -1: np.empty((0, 6))}
        self.hole, self.still = LongRuns(1), LongRuns(max(round(MIN_FREEZE_S * rate), 20))
        self.quiet = QuietStretches(rate)
        self.breaks = GainBreakDetector()
        self.beside: dict[int, int] = {}
        self.moved_at: dict[int, float] = {}
        self.last, self.changes, self.step = np.nan, 0, np.inf
        self.low, self.high = np.inf, -np.inf
        self.reached: list[FloatArray] = []

    def update(self, block: SignalBlock) -> None:
        """Take a piece with `reach` neighbours on both sides."""
        margin, x, filled = self.reach, block.samples, block.filled
        missing = np.isnan(x)
        self.hole.update(missing, self.start, x)
        self._still(x)
        self.quiet.update(x)
        self.breaks.update(block)
        written = np.zeros(x.size, bool)
        if (np.abs(x) >= MIN_SENTINEL_MAGNITUDE).any():
            written = np.isin(x, SENTINEL_VALUES)
        if written.any():
            at = np.flatnonzero(written)
            self.sentinels.append((at + self.start, x[at]))
        spoiled = written | missing
        plain = x[~spoiled] if spoiled.any() else x
        if plain.size:
            self.low, self.high = min(self.low, plain.min()), max(self.high, plain.max())
            edge = np.arange(0, plain.size, EXTREMES_BLOCK_SAMPLES)
            highest, lowest = np.maximum.reduceat(plain, edge), np.minimum.reduceat(plain, edge)
            self.reached.append(np.stack([highest, -lowest]))
        offset = self.start - margin
        moves = {lag: lagged_differences(filled, lag) for lag in self.widths}
        jumps = find_jumps(filled, *moves[1], longest=margin - JUMP_NEIGHBOURHOOD_SAMPLES - 4)
        pricks, heights = find_single_spikes(filled)
        apart = ~overlaps(pricks, merge_runs([jumps[0]]))
        for runs, sizes in (jumps, (pricks[apart], heights[apart])):
            mine = (runs[:, 0] >= margin) & (runs[:, 0] < margin + x.size)
            self.jumps.append((runs[mine] + offset, sizes[mine]))
        runs, sizes = find_level_steps(moves)
        mine = (runs[:, 0] >= margin) & (runs[:, 0] < margin + x.size)
        self.steps.append((runs[mine] + offset, sizes[mine]))
        runs, sizes, heights = find_discontinuities(filled)
        mine = (runs[:, 0] >= margin) & (runs[:, 0] < margin + x.size)
        self.tears.append((runs[mine] + offset, sizes[mine], heights[mine]))
        self._plateaus(filled, offset, x.size)
        self._crests(filled, offset, x.size)
        self.start += x.size

    def _still(self, x: FloatArray) -> None:
        move = np.abs(np.diff(x, prepend=self.last))
        self.still.update(move == 0, self.start, x)
        moved = move > 0
        self.changes += np.count_nonzero(moved)
        least = np.fmin.reduce(move, initial=np.inf)
        least = least if least > 0 else move[moved].min(initial=np.inf)
        self.step = min(self.step, float(least))
        self.last = float(x[-1])

    def _plateaus(self, x: FloatArray, offset: int, size: int) -> None:
        same = np.flatnonzero(x[1:] == x[:-1])
        begin = np.flatnonzero(np.diff(same, prepend=-2) > 1)
        first, last = same[begin], same[np.append(begin[1:], same.size)[: begin.size] - 1] + 2
        self._neighbours(x, first, last, offset, size)
        for sign, book in self.crests.items():
            book.update(sign * x, first, last, reach=self.reach, start=offset, size=size)
        mine = last - first < self.reach - 4
        mine &= (first >= self.reach) & (first < self.reach + size)
        first, last = first[mine], last[mine]
        inside = (first > 1) & (last < x.size - 1)
        first, last = first[inside], last[inside]
        rise, fall = x[first] - x[first - 1], x[last - 1] - x[last]
        for book, sign, end in ((self.top, 1, self.high), (self.bottom, -1, -self.low)):
            k = (sign * rise > 0) & (sign * fall > 0)
            # Of fast crests a cut leaves little that is level: it counts at the very end.
            k &= (last - first >= MIN_CLIPPED_SAMPLES) | (sign * x[first] >= end)
            entry = np.minimum(np.abs(rise), np.abs(fall))[k]
            crown = clipped_heights(sign * x, first[k], last[k])
            book.update(sign * x[first[k]], first[k] + offset, last[k] + offset, entry, crown)

    def _crests(self, x: FloatArray, offset: int, size: int) -> None:
        """Enter the crests next to the ends of what was seen so far.

        From when, to when, how high, how far their middle ranges, what a parabola through their
        flanks puts on top, and what it would where each turned by itself.
        """
        span = self.high - self.low
        if not span > 0:
            return
        for sign, end in ((1, self.high), (-1, -self.low)):
            level = end - BLUNT_CREST_BAND_SHARE_OF_RANGE * span
            high = sign * x >= level
            edge = np.flatnonzero(high[1:] != high[:-1]) + 1
            first, last = edge[high[edge]], edge[~high[edge]]
            last = last[np.searchsorted(last, first[:1], "right")[0] if first.size else 0 :]
            first = first[: last.size]
            mine = (first >= self.reach) & (first < self.reach + size)
            mine &= (last - first >= MIN_CLIPPED_SAMPLES) & (last - first < self.reach - 4)
            first, last = first[mine], last[mine]
            old = self.blunt[sign]
            kept = old[old[:, 2] >= level]
            if first.size:
                y = np.minimum(sign * x, end)
                top, _ = extremes_of_runs(y, first, last)
                side = ((last - first) * FLANK_SHARE_OF_CREST_SAMPLES).astype(np.intp)
                most, least = extremes_of_runs(y, first + side, last - side)
                middle = most - least
                crown = clipped_heights_by_flank(np.minimum(y, level), first, last).min(axis=-1)
                alone = parabola_height_ratio(last - first, side) * middle
                columns = (first + offset, last + offset, top, middle, crown, alone)
                fresh = np.stack([np.asarray(c, float) for c in columns], -1)
                kept = np.concatenate([kept, fresh])
            self.blunt[sign] = kept

    def _neighbours(
        self, x: FloatArray, first: IntArray, last: IntArray, offset: int, size: int
    ) -> None:
        """Enter, by its edges, how long the values next to a long-standing value stood.

        And how far the samples about each edge range.
        """
        near = min(max(round(STANDSTILL_WINDOW_S * self.rate), 4), self.reach)
        for k in np.flatnonzero(last - first >= self.still.least):
            for at in (first[k], last[k]):
                if 0 <= at - self.reach < size:
                    about = x[max(at - near, 0) : at + near]
                    self.moved_at[int(at + offset)] = float(np.ptp(about))
            before = first[k] - first[k - 1] if k and last[k - 1] == first[k] else 1
            behind = last[k + 1] - last[k] if last[k] in first[k + 1 : k + 2] else 1
            if before < first[k] and last[k] + behind < x.size:
                for at, beside in ((first[k], before), (last[k], behind)):
                    if 0 <= at - self.reach < size:
                        self.beside[int(at + offset)] = int(beside)

    def result(self, of: ChannelStatistics) -> dict[str, FaultIntervals]:
        """Return the places of each kind that is there.

        What jumps less than twice as far as the channel usually swings is no fault.
        """
        if not of.alive:
            return {}
        typical = of.typical_swing
        out = {
            FAULT_MISSING_SAMPLES: fault_intervals(run[:2] for run in self.hole.runs),
            FAULT_SENTINEL: self._sentinels(),
        }
        spoiled = out[FAULT_SENTINEL].runs
        runs = np.concatenate([np.empty((0, 2), np.intp), *(r for r, _ in self.jumps)])
        sizes = np.concatenate([np.empty(0), *(s for _, s in self.jumps)])
        known = (np.abs(sizes) > 2 * typical) & ~overlaps(runs, spoiled)
        runs, sizes = runs[known], sizes[known]
        # Torn by the dozen it is not one contact that was lost and found again.
        torn, _ = self._torn(merge_runs([spoiled, runs]), typical=typical)
        many = torn.count >= MIN_DISCONTINUITIES_RULING_OUT_CONTACT_LOSS
        lost = NO_FAULTS if many else self._lost(merge_runs([spoiled, runs]), typical=typical)
        short = runs[:, 1] - runs[:, 0] <= MAX_SPIKE_SAMPLES
        out[FAULT_SPIKE] = FaultIntervals(runs[short], sizes[short])
        out[FAULT_DROPOUT] = fault_intervals(
            np.concatenate([runs[~short], lost.runs]), np.concatenate([sizes[~short], lost.sizes])
        )
        runs = merge_runs([runs, lost.runs])
        long = self._long(merge_runs([spoiled, runs]))
        out[FAULT_CLIP] = self._clips(long, merge_runs([spoiled, runs]))
        frozen = [run[:2] for run in long if not self._cut(run, out[FAULT_CLIP])]
        moved = [self._moved(*run, typical) for run in frozen]
        quiet = self.quiet.result()
        known = [spoiled, runs, out[FAULT_CLIP].runs, np.array(frozen, np.intp).reshape(-1, 2)]
        quiet = quiet.select(~overlaps(quiet.runs, merge_runs(known)))
        out[FAULT_FREEZE] = fault_intervals(
            [*frozen, *((a, b) for a, b in quiet.runs.tolist())], [*moved, *quiet.sizes.tolist()]
        )
        taken = merge_runs(out[k].runs for k in (FAULT_SPIKE, FAULT_DROPOUT, FAULT_SENTINEL))
        jumps = FaultIntervals(taken, np.zeros(len(taken)))
        level = merge_runs(out[k].runs for k in (FAULT_CLIP, FAULT_FREEZE))
        breaks = self.breaks.result()
        near = breaks.runs + np.array([-PREDICTION_ORDER, PREDICTION_ORDER])
        out[FAULT_ZERO_SHIFT], out[FAULT_GAIN] = self._zero_steps_and_gain_changes(
            of, jumps, breaks.select(~overlaps(near, level))
        )
        return out

    def _lost(self, taken: IntArray, *, typical: float) -> FaultIntervals:
        """Return what lies between two steps that undo each other, and no jump has `taken`."""
        runs, sizes = self._steps_of(taken, typical=typical)
        both = np.abs(sizes)
        pairs = (np.diff(runs[:, 0]) <= MAX_CONTACT_LOSS_S * self.rate) & (
            sizes[:-1] * sizes[1:] < 0
        )
        pairs &= np.minimum(both[:-1], both[1:]) >= 0.6 * np.maximum(both[:-1], both[1:])
        first = np.flatnonzero(pairs)
        first = first[np.diff(first, prepend=-2) > 1]  # what one pair ends with begins no other
        ends = np.stack([runs[first, 0], runs[first + 1, 1] - 1], -1)
        return FaultIntervals(ends, sizes[first])

    def _steps_of(self, taken: IntArray, *, typical: float) -> tuple[IntArray, FloatArray]:
        """Return the steps that are more than the channel swings, apart from what is `taken`."""
        runs = np.concatenate([np.empty((0, 2), np.intp), *(r for r, _ in self.steps)])
        sizes = np.concatenate([np.empty(0), *(s for _, s in self.steps)])
        about = np.stack([runs[:, 0] - 1, runs[:, 1]], -1)
        free = (np.abs(sizes) > 2 * typical) & ~overlaps(about, taken)
        return runs[free], sizes[free]

    def _zero_steps_and_gain_changes(
        self, of: ChannelStatistics, jumps: FaultIntervals, breaks: FaultIntervals
    ) -> tuple[FaultIntervals, FaultIntervals]:
        """Return the steps of the zero: tears, and what takes some samples and stays.

        Of that the levels (spans,) on both sides have to know. A load that comes within a sample
        looks the same, so they are suspects. What jumps off and back (`jumps`) is none. In addition
        to them, what changed the gain: from there on level and swing (`swings`) are as many times.
        """
        levels, span, typical = of.levels, of.span, of.typical_swing
        torn, heights = self._torn(jumps.runs, typical=typical)
        by = gain_factors(torn, heights, levels=levels, swings=of.swings, span=span)
        torn, gains = torn.select(by == 1.0), FaultIntervals(torn.runs, by).select(by != 1.0)
        breaks = breaks.select(~overlaps(breaks.runs, jumps.runs))
        about = breaks.runs + np.array([-MAX_STEP_SAMPLES, MAX_STEP_SAMPLES])
        torn, gains = (of.select(~overlaps(of.runs, about)) for of in (torn, gains))
        gains = fault_intervals(
            np.concatenate([gains.runs, breaks.runs]), np.concatenate([gains.sizes, breaks.sizes])
        )
        runs, sizes = self._steps_of(merge_runs([jumps.runs, gains.runs]), typical=typical)
        at = runs.mean(axis=-1).astype(np.intp)
        before, behind = at // span - 1, -(-at // span)
        within = (before >= 0) & (behind < levels.size)
        at, sizes = at[within], sizes[within]
        moved = levels[behind[within]] - levels[before[within]]
        stays = np.abs(moved - sizes) < 0.4 * np.abs(sizes)
        steps = FaultIntervals(np.stack([at, at + 1], -1)[stays], sizes[stays])
        # One tear alone may be a blow; of several, those that stay are reported once.
        if torn.count < MIN_DISCONTINUITIES:
            return steps, gains
        about = steps.runs + np.array([-MAX_STEP_SAMPLES, MAX_STEP_SAMPLES])
        apart = steps.select(~overlaps(about, torn.runs))
        return fault_intervals(
            np.concatenate([torn.runs, apart.runs]), np.concatenate([torn.sizes, apart.sizes])
        ), gains

    def _torn(self, taken: IntArray, *, typical: float) -> tuple[FaultIntervals, FloatArray]:
        """Return the tears that are large enough, apart from what is `taken`; where each leads."""
        runs, sizes, heights = (np.concatenate(part) for part in zip(*self.tears, strict=True))
        kept = np.abs(sizes) > max(
            MIN_DISCONTINUITY_TO_USUAL_SWING_RATIO * typical,
            MIN_DISCONTINUITY_SIZE_RESOLUTION_STEPS * self._code(),
        )
        if self.start > MAX_MEAN_SAMPLES_PER_UNCHANGED_VALUE * max(self.changes, 1):
            kept[:] = False
        kept &= ~overlaps(np.stack([runs[:, 0] - 1, runs[:, 1] + 1], -1), taken)
        return FaultIntervals(runs[kept], sizes[kept]), heights[kept]

    def _code(self) -> float:
        """Return the smallest step of the channel."""
        return self.step if self.step < np.inf else 0.0

    def _sentinels(self) -> FaultIntervals:
        """Numbers of `SENTINEL_VALUES` that stand farther out of all others than those span."""
        if not self.sentinels or not self.high > self.low:
            return NO_FAULTS
        at, value = (np.concatenate(part) for part in zip(*self.sentinels, strict=True))
        span = self.high - self.low
        far = (value < self.low - span) | (value > self.high + span)
        at, value = at[far], value[far]
        if not at.size:
            return NO_FAULTS
        first = np.append(True, np.diff(at) > 1)
        last = np.append(first[1:], True)
        middle = (self.low + self.high) / 2
        return FaultIntervals(np.stack([at[first], at[last] + 1], -1), value[first] - middle)

    def _long(self, taken: IntArray) -> list[tuple[int, int, float]]:
        """Return runs of one value for longer than the channel keeps one, and the value.

        A crest of slow data in coarse steps stands long too, and the steps next to it nearly so.
        """
        # The value they keep is that of the sample before, too.
        runs = [(a - 1, b, v) for a, b, v in self.still.runs]
        kept = sum(b - a for a, b, _ in runs)
        usual = (self.start - kept) / max(self.changes, 1)
        rows = np.array([run[:2] for run in runs], np.intp).reshape(-1, 2)
        free = ~overlaps(rows, taken)
        found: list[tuple[int, int, float]] = []
        for (a, b, v), unspoiled in zip(runs, free, strict=True):
            beside = max(self.beside.get(a, 0), self.beside.get(b, 0))
            if unspoiled and b - a >= 20 * usual and b - a >= 5 * beside:
                found.append((a, b, v))
        return found

    def _moved(self, first: int, last: int, typical: float) -> float:
        """Return how far the channel moves about the ends of a freeze; 0 of a standstill."""
        unknown = self.high - self.low
        ends = [self.moved_at.get(at, unknown) for at in (first, last) if 0 < at < self.start]
        moved = max(ends, default=0.0)
        rest = max(MAX_STANDSTILL_SWING_SHARE * typical, 2 * self.step)
        return moved if moved > rest else 0.0

    def _clips(self, long: list[tuple[int, int, float]], taken: IntArray) -> FaultIntervals:
        """Crests cut off at the top or the bottom, those that were cut for long among them."""
        rows: list[tuple[int, int]] = []
        sizes: list[float] = []
        for book, sign, end in ((self.top, 1, self.high), (self.bottom, -1, self.low)):
            reached = np.concatenate(
                [np.empty(0), *(r[0 if sign > 0 else 1] for r in self.reached)]
            )
            level, found = book.clipped_level(self.step, taken, end=sign * end, reached=reached)
            held = [r for r in long if r[2] == sign * level]
            # What stood cut off for long hides more than what was for a moment: a guess, large.
            crown = (self.high - self.low) / 4
            if not len(found):
                held = [r for r in long if r[2] == end]
                held = held if len(held) > 2 else []
                found = found if held else self._blunt(sign, taken)
                found = (
                    found
                    if held or len(found)
                    else self.crests[sign].clipped_peaks(self.step, taken)
                )
            rows += [(int(first), int(last)) for first, last, _ in found]
            sizes += [sign * float(height) for _, _, height in found]
            known = {int(first) for first, _, _ in found}
            held = [r for r in held if r[0] not in known]
            rows += [r[:2] for r in held]
            sizes += [sign * crown] * len(held)
        return fault_intervals(rows, sizes)

    def _blunt(self, sign: int, taken: IntArray) -> FloatArray:
        """Return (k, 3) first, last and crown of crests cut off at a level that noise is on."""
        rows = self.blunt[sign]
        rows = rows[~overlaps(rows[:, :2].astype(np.intp), taken)]
        cut = rows[:, 4] > MIN_CLIPPED_HEIGHT_TO_CREST_RANGE_RATIO * np.maximum(
            rows[:, 3], self.step
        )
        steep = rows[:, 4] / (rows[:, 1] - rows[:, 0] + 1)
        low, usual, high = np.quantile(steep, [0.25, 0.5, 0.75]) if len(rows) else np.zeros(3)
        if high - low < MAX_REPEATED_CREST_SLOPE_SPREAD_SHARE * usual:
            cut &= rows[:, 4] > MIN_REPEATED_CREST_HEIGHT_RATIO * rows[:, 5]
        if np.count_nonzero(cut) < MIN_CLIPPED_SAMPLES or np.mean(cut) < 0.5:
            return rows[:0, :3]
        return rows[cut][:, [0, 1, 4]]

    @staticmethod
    def _cut(run: tuple[int, int, float], clips: FaultIntervals) -> bool:
        return bool(overlaps(np.array([run[:2]], np.intp), clips.runs)[0])


FAULT_SOURCE = FaultSource(
    kinds=(
        FaultKind(code=FAULT_MISSING_SAMPLES, of_any_channel=True),
        FaultKind(code=FAULT_SENTINEL, of_any_channel=True, maskable=True),
        FaultKind(code=FAULT_SPIKE, maskable=True),
        FaultKind(code=FAULT_DROPOUT, maskable=True),
        FaultKind(code=FAULT_CLIP),
        FaultKind(code=FAULT_FREEZE, maskable=True),
        zero_step.KIND,
        gain_change.KIND,
    ),
    detector=WaveformFaultDetector,
    roughly_sized=(FAULT_GAIN,),
)
