"""What in a channel looks wrong, by kind and place. Nothing is taken out here.

A blow of a pothole and a bad contact look alike to a filter that mends both. So what is
suspicious is only found and listed, and whoever measured says what it was: `masked` makes a
hole of it, which is unknown and not zero, and what is kept is exactly what was recorded.

| kind | what it is |
|---|---|
| hole | missing samples |
| sentinel | a number that loggers write for "no value", far outside all others |
| spike | up to three samples that jump off and back, quiet on both sides |
| dropout | the same, longer and level; or a contact lost for some seconds between two steps |
| clip | crests cut off at one level |
| freeze | one value for longer than the channel ever keeps one |
| zero-step | the signal is torn: it steps from one sample to the next, and goes on as before |
| gain | from some place on it answers so many times as much, or the other way round |
| noise | white for some tenths of a second, as a contact that chatters: no structure answers so |
| repeat | what was written before, to the last digit: a buffer that was stored twice |
| drift | the level creeps by more than the channel swings |
| hum | a tone of the mains, 50 or 60 Hz, that neither speed nor load moves |
| unit | a stress that no metal bears, or less than a gauge's noise: numbers of another unit |
| rate | samples too seldom for what moves a driveline, or at a rate no gauge has |
| strength | crests beyond the tensile strength that was said |
| bit | half of all values never come: a bit of the converter stands still |
"""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass

import numpy as np

from cardan.base.arrays import BoolArray, FloatArray, IntArray

HOLE, SENTINEL, SPIKE, DROPOUT = "hole", "sentinel", "spike", "dropout"
CLIP, FREEZE, ZERO_STEP, DRIFT = "clip", "freeze", "zero-step", "drift"
GAIN, NOISE, REPEAT = "gain", "noise", "repeat"
HUM, UNIT, RATE, STRENGTH, BIT = "hum", "unit", "rate", "strength", "bit"
ANYWHERE = (HOLE, SENTINEL)
"""What is no value in any channel; all else is of a gauge, that swings about a zero of its own."""
IMPOSSIBLE = (UNIT, RATE, STRENGTH, BIT)
"""What a gauge's stress cannot be, if all was said as it is: of it there is no damage without."""
KINDS = (
    HOLE, SENTINEL, SPIKE, DROPOUT, CLIP, FREEZE, ZERO_STEP, GAIN, NOISE, REPEAT, DRIFT, HUM,
    *IMPOSSIBLE,
)  # fmt: skip
MASKABLE = (SENTINEL, SPIKE, DROPOUT, FREEZE, NOISE, REPEAT)
"""What a hole can be made of: what a clip cut off, and where a drift began, nobody knows."""
TAKEN_OFF = (ZERO_STEP, GAIN, HUM)
"""What makes no hole: it is taken off, and the rest is what was measured."""
REMOVABLE = (*MASKABLE, *TAKEN_OFF)
"""What a rule can take out."""

SENTINELS = (
    -32768.0, 32767.0, 65535.0, -999.25, 9.96921e36, 1e30, -1e30, 1e20, -1e20,
    *(sign * value for sign in (-1.0, 1.0) for value in (999.0, 9999.0, 99999.0, 999999.0)),
)  # fmt: skip
"""Numbers that loggers write where they have none."""
LEAST_SENTINEL = min(map(abs, SENTINELS))
"""Of their sizes."""

CLIPPED_RUN = 4
"""Samples in a row at one level that make a crest look cut off."""
CUT_OF_THREE = 4.5
"""Steps of the channel into a level of three samples that make it one cut off.

A parabola's middle stands above them by a third of what they stand above the next.
"""
CUT_ALONE = 50.0
"""Of such steps, from which a single one is no chance: what came so fast does not rest at once."""
NEARLY = 0.03
"""Of all that a channel spans, how far below its end crests are looked at that noise or a filter
left next to level."""
BLUNT = 6.0
"""Times the range of its middle (`MIDDLE`) from which what a parabola through a crest's flanks
puts on top was cut off: of a crest of many samples that turns by itself it is 2.8 times that."""
ONE_SWING, SURELY = 0.2, 1.2
"""How far apart quartiles of the flanks' slopes are, of their median, where one swing comes again
and again, as on a rig; there it is so many times what it is of as few samples that turn alone."""
MIDDLE = 0.2
"""Share of a crest's samples that lies to either side of its middle."""
CRESTS, BELOW = 256, 8
"""Highest crests of a channel that are kept, and the fewest below a level that say how likely it
is by chance."""
NO_CHANCE = 4.0
"""Powers of ten against the highest crests being alike by chance from which they were cut off."""
SPIKE_WIDTH = 3
"""Longest spike, samples; what is longer and level is a dropout."""
DROPOUT_SECONDS = 0.25
"""Longest dropout that is looked at as a whole, and has to be level."""
LOST_SECONDS = 10.0
"""Longest of all: a contact that was lost between two steps. What stays longer is another zero."""
FREEZE_SECONDS = 0.1
"""Shortest freeze, of 20 samples at least, and of 20 times as long as the channel's own steps."""
STEP_WIDTH, STEP_SECONDS = 4, 0.005
"""Samples, and time, in which a level becomes another behind a filter: a load takes longer."""
QUIET = 32
"""Samples before a jump, or behind, that say how the channel moves there."""
OUTSTANDING = 5.0
"""Times their 90 % quantile that a jump stands out by; noise alone reaches some three."""
FORETOLD = 10.0
"""The same of a sample that its neighbours do not foretell."""
ALONE = 0.1
"""Of how far a sample is off, how much its neighbours may be off otherwise than by it."""
TORN_ALONE, TORN = 0.25, 10.0
"""The same of a jump between two samples; and how many times the median about it."""
TORN_MOVES = 2.0
"""Times what x moves in the sample before and in the one behind."""
TORN_LEAST, TORN_CODES = 0.5, 4
"""Times the channel's usual swing, and steps of its own, that a jump has at least."""
BESIDE, GREW, FITS = 3, 0.1, 0.5
"""Spans beside a tear that say whether the gain changed there; the logarithm of the least change,
and how far from it the swing's may be."""
TEARS, MANY = 4, 12
"""Of which the levels know nothing, and that are suspects all the same; and from how many on two of
them are no contact that was lost."""
STAIRS = 2.0
"""Samples that a channel keeps a value for on average, from which it moves by jumps alone."""
BLOCK = 1024
"""Samples whose highest and lowest are kept."""
RARE = 0.1
"""Share of blocks that may reach beyond a level that crests are cut off at."""


@dataclass(frozen=True)
class Places:
    """Where a channel shows one kind of fault.

    Attributes
    ----------
    runs : (k, 2) samples
        First, and one behind the last; in order, none overlapping.
    sizes : (k,)
        How far each stands off what is about it, in the channel's unit: a jump's height, for a
        clip what a parabola through its flanks puts on top, signed.
    """

    runs: IntArray
    sizes: FloatArray

    @property
    def count(self) -> int:
        """How many there are."""
        return len(self.runs)

    def only(self, kept: BoolArray) -> "Places":
        """Return some of them."""
        return Places(self.runs[kept], self.sizes[kept])

    @property
    def samples(self) -> int:
        """How many samples they are together."""
        return int((self.runs[:, 1] - self.runs[:, 0]).sum())


NOWHERE = Places(np.empty((0, 2), np.intp), np.empty(0))


def places(runs: Iterable[tuple[int, int]], sizes: Iterable[float] = ()) -> Places:
    """Return places of runs of samples, in order; sizes are unknown (nan) unless given."""
    rows = np.array(list(runs), np.intp).reshape(-1, 2)
    heights = np.array(list(sizes), float)
    if heights.size != len(rows):
        heights = np.full(len(rows), np.nan)
    order = np.argsort(rows[:, 0], kind="stable")
    return Places(rows[order], heights[order])


def union(parts: Iterable[IntArray]) -> IntArray:
    """Return runs (k, 2) that cover what any of some runs cover, in order and apart."""
    rows = np.concatenate([np.empty((0, 2), np.intp), *parts])
    if not len(rows):
        return rows
    rows = rows[np.argsort(rows[:, 0], kind="stable")]
    reach = np.maximum.accumulate(rows[:, 1])
    fresh = np.append(True, rows[1:, 0] > reach[:-1])
    last = np.append(np.flatnonzero(fresh)[1:] - 1, len(rows) - 1)
    return np.stack([rows[fresh, 0], reach[last]], -1)


def within(runs: IntArray, start: int, n: int) -> BoolArray:
    """Return which of the samples `start` to `start + n` lie in runs (k, 2) that are apart."""
    low, high = np.searchsorted(runs[:, 1], start, "right"), np.searchsorted(runs[:, 0], start + n)
    step = np.zeros(n + 1, np.int8)
    for first, last in runs[low:high]:
        step[max(first - start, 0)] += 1
        step[min(last - start, n)] -= 1
    return np.cumsum(step[:-1]) > 0


def crowned(x: FloatArray, clips: Places, start: int) -> FloatArray:
    """Return samples (n,) from `start` on with clipped crests put back, as parabolas."""
    low = np.searchsorted(clips.runs[:, 1], start, "right")
    high = np.searchsorted(clips.runs[:, 0], start + x.size)
    out = x.copy()
    for (first, last), size in zip(clips.runs[low:high], clips.sizes[low:high], strict=True):
        place = np.arange(max(first, start), min(last, start + x.size))
        u = (place - first + 1) / (last - first + 1)
        out[place - start] += 4 * size * u * (1 - u)
    return out


def reach(rate: float) -> int:
    """Return the samples to either side of a piece that `Finder` needs."""
    return max(round(DROPOUT_SECONDS * rate), SPIKE_WIDTH) + QUIET + 4


class Finder:
    """One channel's faults, as its pieces pass: `add` each, then ask `found`."""

    def __init__(self, rate: float) -> None:
        self.rate, self.reach = rate, reach(rate)
        self.widths = tuple(sorted({1, min(STEP_WIDTH, max(round(STEP_SECONDS * rate), 1))}))
        self.start = 0
        self.jumps: list[tuple[IntArray, FloatArray]] = []
        self.steps: list[tuple[IntArray, FloatArray]] = []
        self.tears: list[tuple[IntArray, FloatArray, FloatArray]] = []
        self.sentinels: list[tuple[IntArray, FloatArray]] = []
        self.top, self.bottom = _Plateaus(), _Plateaus()
        self.crests = {1: _Crests(), -1: _Crests()}
        self.blunt: dict[int, FloatArray] = {1: np.empty((0, 6)), -1: np.empty((0, 6))}
        self.hole, self.still = _Long(1), _Long(max(round(FREEZE_SECONDS * rate), 20))
        self.beside: dict[int, int] = {}
        self.last, self.changes, self.step = np.nan, 0, np.inf
        self.low, self.high = np.inf, -np.inf
        self.reached: list[FloatArray] = []

    def add(self, padded: FloatArray, filled: FloatArray) -> None:
        """Take a piece with `reach` neighbours on both sides, as it is and with holes bridged."""
        margin = self.reach
        x = padded[margin : padded.size - margin]
        missing = np.isnan(x)
        self.hole.add(missing, self.start, x)
        self._still(x)
        written = np.zeros(x.size, bool)
        if (np.abs(x) >= LEAST_SENTINEL).any():
            written = np.isin(x, SENTINELS)
        if written.any():
            at = np.flatnonzero(written)
            self.sentinels.append((at + self.start, x[at]))
        spoiled = written | missing
        plain = x[~spoiled] if spoiled.any() else x
        if plain.size:
            self.low, self.high = min(self.low, plain.min()), max(self.high, plain.max())
            edge = np.arange(0, plain.size, BLOCK)
            highest, lowest = np.maximum.reduceat(plain, edge), np.minimum.reduceat(plain, edge)
            self.reached.append(np.stack([highest, -lowest]))
        offset = self.start - margin
        moves = {lag: _moves(filled, lag) for lag in self.widths}
        jumps = _jumps(filled, *moves[1], longest=margin - QUIET - 4)
        pricks, heights = _pricks(filled)
        apart = ~_touching(pricks, union([jumps[0]]))
        for runs, sizes in (jumps, (pricks[apart], heights[apart])):
            mine = (runs[:, 0] >= margin) & (runs[:, 0] < margin + x.size)
            self.jumps.append((runs[mine] + offset, sizes[mine]))
        runs, sizes = _steps(moves)
        mine = (runs[:, 0] >= margin) & (runs[:, 0] < margin + x.size)
        self.steps.append((runs[mine] + offset, sizes[mine]))
        runs, sizes, heights = torn(filled)
        mine = (runs[:, 0] >= margin) & (runs[:, 0] < margin + x.size)
        self.tears.append((runs[mine] + offset, sizes[mine], heights[mine]))
        self._plateaus(filled, offset, x.size)
        self._crests(filled, offset, x.size)
        self.start += x.size

    def _still(self, x: FloatArray) -> None:
        move = np.abs(np.diff(x, prepend=self.last))
        self.still.add(move == 0, self.start, x)
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
        self._neighbours(first, last, offset, size, end=x.size)
        for sign, book in self.crests.items():
            book.add(sign * x, first, last, reach=self.reach, start=offset, size=size)
        mine = last - first < self.reach - 4
        mine &= (first >= self.reach) & (first < self.reach + size)
        first, last = first[mine], last[mine]
        inside = (first > 1) & (last < x.size - 1)
        first, last = first[inside], last[inside]
        rise, fall = x[first] - x[first - 1], x[last - 1] - x[last]
        for book, sign, end in ((self.top, 1, self.high), (self.bottom, -1, -self.low)):
            k = (sign * rise > 0) & (sign * fall > 0)
            # Of fast crests a cut leaves little that is level: it counts at the very end.
            k &= (last - first >= CLIPPED_RUN) | (sign * x[first] >= end)
            entry = np.minimum(np.abs(rise), np.abs(fall))[k]
            crown = _crowns(sign * x, first[k], last[k])
            book.add(sign * x[first[k]], first[k] + offset, last[k] + offset, entry, crown)

    def _crests(self, x: FloatArray, offset: int, size: int) -> None:
        """Enter the crests next to the ends of what was seen so far.

        From when, to when, how high, how far their middle ranges, what a parabola through their
        flanks puts on top, and what it would where each turned by itself.
        """
        span = self.high - self.low
        if not span > 0:
            return
        for sign, end in ((1, self.high), (-1, -self.low)):
            level = end - NEARLY * span
            high = sign * x >= level
            edge = np.flatnonzero(high[1:] != high[:-1]) + 1
            first, last = edge[high[edge]], edge[~high[edge]]
            last = last[np.searchsorted(last, first[:1], "right")[0] if first.size else 0 :]
            first = first[: last.size]
            mine = (first >= self.reach) & (first < self.reach + size)
            mine &= (last - first >= CLIPPED_RUN) & (last - first < self.reach - 4)
            first, last = first[mine], last[mine]
            old = self.blunt[sign]
            kept = old[old[:, 2] >= level]
            if first.size:
                y = np.minimum(sign * x, end)
                top, _ = _range(y, first, last)
                side = ((last - first) * MIDDLE).astype(np.intp)
                most, least = _range(y, first + side, last - side)
                middle = most - least
                crown = _both_crowns(np.minimum(y, level), first, last).min(axis=-1)
                alone = _alone(last - first, side) * middle
                columns = (first + offset, last + offset, top, middle, crown, alone)
                fresh = np.stack([np.asarray(c, float) for c in columns], -1)
                kept = np.concatenate([kept, fresh])
            self.blunt[sign] = kept

    def _neighbours(
        self, first: IntArray, last: IntArray, offset: int, size: int, *, end: int
    ) -> None:
        """Enter, by its edges, how long the values beside a value that stands long stood."""
        for k in np.flatnonzero(last - first >= self.still.least):
            before = first[k] - first[k - 1] if k and last[k - 1] == first[k] else 1
            behind = last[k + 1] - last[k] if last[k] in first[k + 1 : k + 2] else 1
            if before < first[k] and last[k] + behind < end:
                for at, beside in ((first[k], before), (last[k], behind)):
                    if 0 <= at - self.reach < size:
                        self.beside[int(at + offset)] = int(beside)

    def found(self, *, typical: float) -> Mapping[str, Places]:
        """Return the places of each kind that is there.

        `typical` is how far the channel usually swings: what jumps less than twice as far is
        nobody's fault.
        """
        out = {HOLE: places(run[:2] for run in self.hole.runs), SENTINEL: self._sentinels()}
        spoiled = out[SENTINEL].runs
        runs = np.concatenate([np.empty((0, 2), np.intp), *(r for r, _ in self.jumps)])
        sizes = np.concatenate([np.empty(0), *(s for _, s in self.jumps)])
        known = (np.abs(sizes) > 2 * typical) & ~_touching(runs, spoiled)
        runs, sizes = runs[known], sizes[known]
        # Torn by the dozen it is not one contact that was lost and found again.
        torn, _ = self._torn(union([spoiled, runs]), typical=typical)
        many = torn.count >= MANY
        lost = NOWHERE if many else self._lost(union([spoiled, runs]), typical=typical)
        short = runs[:, 1] - runs[:, 0] <= SPIKE_WIDTH
        out[SPIKE] = Places(runs[short], sizes[short])
        out[DROPOUT] = places(
            np.concatenate([runs[~short], lost.runs]), np.concatenate([sizes[~short], lost.sizes])
        )
        runs = union([runs, lost.runs])
        long = self._long(union([spoiled, runs]))
        out[CLIP] = self._clips(long, union([spoiled, runs]))
        out[FREEZE] = places(run[:2] for run in long if not self._cut(run, out[CLIP]))
        return {kind: where for kind, where in out.items() if where.count}

    def _lost(self, taken: IntArray, *, typical: float) -> Places:
        """Return what lies between two steps that undo each other, and no jump has `taken`."""
        runs, sizes = self._steps_of(taken, typical=typical)
        both = np.abs(sizes)
        pairs = (np.diff(runs[:, 0]) <= LOST_SECONDS * self.rate) & (sizes[:-1] * sizes[1:] < 0)
        pairs &= np.minimum(both[:-1], both[1:]) >= 0.6 * np.maximum(both[:-1], both[1:])
        first = np.flatnonzero(pairs)
        first = first[np.diff(first, prepend=-2) > 1]  # what one pair ends with begins no other
        ends = np.stack([runs[first, 0], runs[first + 1, 1] - 1], -1)
        return Places(ends, sizes[first])

    def _steps_of(self, taken: IntArray, *, typical: float) -> tuple[IntArray, FloatArray]:
        """Return the steps that are more than the channel swings, apart from what is `taken`."""
        runs = np.concatenate([np.empty((0, 2), np.intp), *(r for r, _ in self.steps)])
        sizes = np.concatenate([np.empty(0), *(s for _, s in self.steps)])
        about = np.stack([runs[:, 0] - 1, runs[:, 1]], -1)
        free = (np.abs(sizes) > 2 * typical) & ~_touching(about, taken)
        return runs[free], sizes[free]

    def stepped(
        self, levels: FloatArray, *, swings: FloatArray, span: int, typical: float, jumps: Places
    ) -> tuple[Places, Places]:
        """Return the steps of the zero: tears, and what takes some samples and stays.

        Of that the levels (spans,) on both sides have to know. A load that comes within a sample
        looks the same, so they are suspects. What jumps off and back (`jumps`) is none. Beside
        them, what changed the gain: from there on level and swing (`swings`) are as many times.
        """
        torn, heights = self._torn(jumps.runs, typical=typical)
        by = _factors(torn, heights, levels=levels, swings=swings, span=span)
        torn, gains = torn.only(by == 1.0), Places(torn.runs, by).only(by != 1.0)
        runs, sizes = self._steps_of(union([jumps.runs, gains.runs]), typical=typical)
        at = runs.mean(axis=-1).astype(np.intp)
        before, behind = at // span - 1, -(-at // span)
        within = (before >= 0) & (behind < levels.size)
        at, sizes = at[within], sizes[within]
        moved = levels[behind[within]] - levels[before[within]]
        stays = np.abs(moved - sizes) < 0.4 * np.abs(sizes)
        steps = Places(np.stack([at, at + 1], -1)[stays], sizes[stays])
        # One tear alone may be a blow; of several those that stay are told once.
        if torn.count < TEARS:
            return steps, gains
        about = steps.runs + np.array([-STEP_WIDTH, STEP_WIDTH])
        apart = steps.only(~_touching(about, torn.runs))
        return places(
            np.concatenate([torn.runs, apart.runs]), np.concatenate([torn.sizes, apart.sizes])
        ), gains

    def _torn(self, taken: IntArray, *, typical: float) -> tuple[Places, FloatArray]:
        """Return the tears that are large enough, apart from what is `taken`; where each leads."""
        runs, sizes, heights = (np.concatenate(part) for part in zip(*self.tears, strict=True))
        kept = np.abs(sizes) > max(TORN_LEAST * typical, TORN_CODES * self._code())
        if self.start > STAIRS * max(self.changes, 1):
            kept[:] = False
        kept &= ~_touching(np.stack([runs[:, 0] - 1, runs[:, 1] + 1], -1), taken)
        return Places(runs[kept], sizes[kept]), heights[kept]

    def _code(self) -> float:
        """Return the smallest step of the channel."""
        return self.step if self.step < np.inf else 0.0

    def _sentinels(self) -> Places:
        """Numbers of `SENTINELS` that stand farther out of all others than those span."""
        if not self.sentinels or not self.high > self.low:
            return NOWHERE
        at, value = (np.concatenate(part) for part in zip(*self.sentinels, strict=True))
        span = self.high - self.low
        far = (value < self.low - span) | (value > self.high + span)
        at, value = at[far], value[far]
        if not at.size:
            return NOWHERE
        first = np.append(True, np.diff(at) > 1)
        last = np.append(first[1:], True)
        middle = (self.low + self.high) / 2
        return Places(np.stack([at[first], at[last] + 1], -1), value[first] - middle)

    def _long(self, taken: IntArray) -> list[tuple[int, int, float]]:
        """Return runs of one value for longer than the channel keeps one, and the value.

        A crest of slow data in coarse steps stands long too, and the steps beside it nearly so.
        """
        # The value they keep is that of the sample before, too.
        runs = [(a - 1, b, v) for a, b, v in self.still.runs]
        kept = sum(b - a for a, b, _ in runs)
        usual = (self.start - kept) / max(self.changes, 1)
        rows = np.array([run[:2] for run in runs], np.intp).reshape(-1, 2)
        free = ~_touching(rows, taken)
        found: list[tuple[int, int, float]] = []
        for (a, b, v), unspoiled in zip(runs, free, strict=True):
            beside = max(self.beside.get(a, 0), self.beside.get(b, 0))
            if unspoiled and b - a >= 20 * usual and b - a >= 5 * beside:
                found.append((a, b, v))
        return found

    def _clips(self, long: list[tuple[int, int, float]], taken: IntArray) -> Places:
        """Crests cut off at the top or the bottom, those that were cut for long among them."""
        rows: list[tuple[int, int]] = []
        sizes: list[float] = []
        for book, sign, end in ((self.top, 1, self.high), (self.bottom, -1, self.low)):
            reached = np.concatenate(
                [np.empty(0), *(r[0 if sign > 0 else 1] for r in self.reached)]
            )
            level, found = book.clips(self.step, taken, end=sign * end, reached=reached)
            held = [r for r in long if r[2] == sign * level]
            # What stood cut off for long hides more than what was for a moment: a guess, large.
            crown = (self.high - self.low) / 4
            if not len(found):
                held = [r for r in long if r[2] == end]
                held = held if len(held) > 2 else []
                found = found if held else self._blunt(sign, taken)
                found = found if held or len(found) else self.crests[sign].cut(self.step, taken)
            rows += [(int(first), int(last)) for first, last, _ in found]
            sizes += [sign * float(height) for _, _, height in found]
            known = {int(first) for first, _, _ in found}
            held = [r for r in held if r[0] not in known]
            rows += [r[:2] for r in held]
            sizes += [sign * crown] * len(held)
        return places(rows, sizes)

    def _blunt(self, sign: int, taken: IntArray) -> FloatArray:
        """Return (k, 3) first, last and crown of crests cut off at a level that noise is on."""
        rows = self.blunt[sign]
        rows = rows[~_touching(rows[:, :2].astype(np.intp), taken)]
        cut = rows[:, 4] > BLUNT * np.maximum(rows[:, 3], self.step)
        steep = rows[:, 4] / (rows[:, 1] - rows[:, 0] + 1)
        low, usual, high = np.quantile(steep, [0.25, 0.5, 0.75]) if len(rows) else np.zeros(3)
        if high - low < ONE_SWING * usual:
            cut &= rows[:, 4] > SURELY * rows[:, 5]
        if np.count_nonzero(cut) < CLIPPED_RUN or np.mean(cut) < 0.5:
            return rows[:0, :3]
        return rows[cut][:, [0, 1, 4]]

    @staticmethod
    def _cut(run: tuple[int, int, float], clips: Places) -> bool:
        return bool(_touching(np.array([run[:2]], np.intp), clips.runs)[0])


def _touching(rows: IntArray, others: IntArray) -> BoolArray:
    """Which runs (k, 2) share a sample with others (m, 2), apart and in order."""
    if not len(others):
        return np.zeros(len(rows), bool)
    near = np.searchsorted(others[:, 1], rows[:, 0], "right")
    return (near < len(others)) & (others[np.minimum(near, len(others) - 1), 0] < rows[:, 1])


def _range(x: FloatArray, first: IntArray, last: IntArray) -> tuple[FloatArray, FloatArray]:
    """Return the highest and lowest (k,) of runs of samples, none of them at the end of x."""
    ends = np.stack([first, last], -1).ravel()
    return np.maximum.reduceat(x, ends)[::2], np.minimum.reduceat(x, ends)[::2]


def _crowns(x: FloatArray, first: IntArray, last: IntArray) -> FloatArray:
    """Return what stands on top (k,) of level crests of x: a parabola through their flanks.

    Noise breaks a crest that was cut off into several; those close together are one.
    """
    if not first.size:
        return np.empty(0)
    near = first[1:] - last[:-1] <= np.maximum(last[:-1] - first[:-1], CLIPPED_RUN)
    near &= x[first[1:]] == x[first[:-1]]
    group = np.concatenate([[0], np.cumsum(~near)])
    begin = first[np.searchsorted(group, np.arange(group[-1] + 1))]
    end = last[np.searchsorted(group, np.arange(group[-1] + 1), "right") - 1]
    # Each part carries the crest's whole height: together they are one.
    return _both_crowns(x, begin, end).mean(axis=-1)[group]


def _both_crowns(x: FloatArray, first: IntArray, last: IntArray) -> FloatArray:
    """Return the same of whole crests by each flank, (k, 2), met some samples off the crest."""
    width = last - first
    away = _away(width)
    level = x[first]
    left = (level - x[np.maximum(first - away, 0)]) / away
    right = (level - x[np.minimum(last - 1 + away, x.size - 1)]) / away
    slopes = np.stack([left, right], -1)
    slopes = np.where((left + right < 0)[:, None], 0.0, slopes)
    return slopes * (width[:, None] + 1) / 4


def _away(width: IntArray) -> IntArray:
    """Return how many samples off crests of some widths their flanks are met."""
    return np.clip(width // 8, 2, 32)


def _alone(width: IntArray, side: IntArray) -> FloatArray:
    """Return `_both_crowns` over the range of the middle (k,) of parabolas that nothing cut off.

    Of few samples a middle ranges over fewer yet: of five, three, and it is nine.
    """
    middle = (width - 1) / 2 - side
    return (width - 1 + _away(width)) * (width + 1) / (4 * middle**2)


def _moves(x: FloatArray, lag: int) -> tuple[FloatArray, FloatArray, BoolArray]:
    """Return how x moves within so many samples, the size of it, and where it is `_loud`."""
    d = x[lag:] - x[:-lag]
    size = np.abs(d)
    return d, size, _loud(size, gap=lag)


def _jumps(
    x: FloatArray, d: FloatArray, size: FloatArray, loud: BoolArray, *, longest: int
) -> tuple[IntArray, FloatArray]:
    """Return runs (k, 2) of samples that jump off and back, level between and quiet on both sides.

    Of x and its `_moves` by a sample. A ring is not quiet behind, a blow is not level: neither is
    one.
    """
    none = np.empty((0, 2), np.intp), np.empty(0)
    off, back = map(np.flatnonzero, loud)
    off = off[size[off] > 5 * np.maximum(size[off - 1], size[off - 2])]
    back = back[size[back] > 5 * np.maximum(size[back + 1], size[back + 2])]
    off, back = _outstanding(size, off, -1), _outstanding(size, back, 1)
    if not (off.size and back.size):
        return none
    near = np.searchsorted(back, off, "right")
    there = near < back.size
    off, back = off[there], back[near[there]]
    width = back - off
    low, high = np.minimum(size[off], size[back]), np.maximum(size[off], size[back])
    fits = (width <= longest) & (d[off] * d[back] < 0) & (low >= 0.6 * high)
    fits &= np.abs(x[off] - x[back + 1]) <= 0.5 * low
    off, back, low = off[fits], back[fits], low[fits]
    flat = np.array(
        [np.ptp(x[a + 1 : b + 1]) <= 0.25 * s for a, b, s in zip(off, back, low, strict=True)], bool
    )
    if not flat.any():
        return none
    off, back, low = off[flat], back[flat], low[flat]
    return np.stack([off + 1, back + 1], -1), low * np.sign(d[off])


def _pricks(x: FloatArray) -> tuple[IntArray, FloatArray]:
    """Return single samples, runs (k, 2), that a cubic through their neighbours does not foretell.

    Within a ring steps are large, but each sample is foretold by those beside it. One that is off
    by itself spoils the foretelling of these as well, by two thirds and with the other sign; a
    blow, however short, has flanks.
    """
    off = np.zeros_like(x)
    off[2:-2] = x[2:-2] - (4 * (x[1:-3] + x[3:-1]) - x[:-4] - x[4:]) / 6
    size = np.abs(off)
    at = np.flatnonzero(_loud(size, gap=2, least=FORETOLD).all(0))
    beside = np.maximum(
        np.abs(off[at - 1] + 2 / 3 * off[at]), np.abs(off[at + 1] + 2 / 3 * off[at])
    )
    at = at[beside < ALONE * size[at]]
    for way in (-1, 1):
        at = _outstanding(size, at, way, gap=2, least=FORETOLD)
    return np.stack([at, at + 1], -1), off[at]


def torn(x: FloatArray) -> tuple[IntArray, FloatArray, FloatArray]:
    """Return where x is torn: runs (k, 2) of one sample each, how far it jumps to it, and where to.

    Lines through two samples on either side do not meet half way, and do so at the places before
    and behind but for that jump. Whatever bends and swings about it, a structure that was hit goes
    on to move; a wire that was touched, a bit that stands still or a code that ran over does not.
    """
    step = np.diff(x)
    apart = np.zeros_like(x)
    apart[1:-2] = step[1:-1] - (step[:-2] + step[2:]) / 2
    size, near = np.abs(apart), np.abs(step)
    may = np.logical_and(*_loud(size, gap=2, least=TORN, share=0.5))
    # What was hit goes on about as fast.
    may[1:-2] &= size[1:-2] > TORN_MOVES * np.maximum(near[:-2], near[2:])
    at = np.flatnonzero(may)
    half = apart[at] / 2
    beside = np.maximum(np.abs(apart[at - 1] + half), np.abs(apart[at + 1] + half))
    at = at[beside < TORN_ALONE * size[at]]
    at = at[size[at] > 2 * np.maximum(size[at - 3], size[at + 3])]
    for way in (-1, 1):
        at = _outstanding(size, at, way, gap=2, least=TORN, share=0.5)
    return np.stack([at + 1, at + 2], -1), apart[at], 1.5 * x[at + 1] - x[at + 2] / 2


def _factors(
    torn: Places, behind: FloatArray, *, levels: FloatArray, swings: FloatArray, span: int
) -> FloatArray:
    """Return by what a gain changed at tears (k,), 1 where only the zero stepped.

    `behind` (k,) is where each leads to. Level and swing of some spans on both sides, as far as
    the next tear, have to say the same, and better than of a step.
    """
    factors = np.ones(torn.count)
    ends = np.concatenate([[0], torn.runs[:, 0], [levels.size * span]])
    for k, (jump, to) in enumerate(zip(torn.sizes.tolist(), behind.tolist(), strict=True)):
        first, at, last = ends[k : k + 3].tolist()
        before = slice(max(-(-first // span), at // span - BESIDE), at // span)
        after = slice(-(-at // span), min(last // span, -(-at // span) + BESIDE))
        told = [np.nanmedian(x[s]) for x in (levels, swings) for s in (before, after) if x[s].size]
        if len(told) < 4 or not min(told[2:]) > 0 or to in (0.0, jump):
            continue
        level, new, swing, wide = told
        by = to / (to - jump)
        if abs(new - by * level) > abs(new - level - jump) + swing:
            continue  # the level knows of a step
        grown, off = abs(np.log(wide / swing)), abs(np.log(wide / swing / abs(by)))
        larger = by > 0 and abs(np.log(by)) > GREW and off < grown / 2
        turned = by < 0 and abs(new - by * level) < abs(new - level - jump)
        if off < FITS and (larger or turned):
            factors[k] = by
    return factors


def _steps(
    moves: Mapping[int, tuple[FloatArray, FloatArray, BoolArray]],
) -> tuple[IntArray, FloatArray]:
    """Return runs (k, 2) in which the level becomes another, calm on both sides, by how much.

    Within so many samples: at once, or in the few that a filter makes of it.
    """
    found = [_stepped(*of, lag) for lag, of in moves.items()]
    runs, sizes = (np.concatenate(part) for part in zip(*found, strict=True))
    first = ~_touching(runs, union([found[0][0]])) | (np.arange(len(runs)) < len(found[0][0]))
    order = np.argsort(runs[first, 0], kind="stable")
    return runs[first][order], sizes[first][order]


def _stepped(
    d: FloatArray, size: FloatArray, loud: BoolArray, lag: int
) -> tuple[IntArray, FloatArray]:
    """Return the same of those that take so many samples."""
    calm = 5 if lag == 1 else 3  # a filter overshoots
    at = np.flatnonzero(loud.all(0))
    at = at[size[at] > calm * np.maximum(size[at - lag], size[at + lag])]
    for k in range(1, lag):  # the middle of the way
        at = at[size[at] >= np.maximum(size[at - k], size[at + k])]
    at = _outstanding(size, _outstanding(size, at, -1, gap=lag), 1, gap=lag)
    return np.stack([at + 1, at + 1 + lag], -1), d[at]


def _loud(
    size: FloatArray, *, gap: int = 1, least: float = OUTSTANDING, share: float = 0.9
) -> BoolArray:
    """Return which jumps may be `_outstanding`, (2, n): before them, and behind. No others are."""
    loud = np.zeros((2, size.size), bool)
    if size.size <= 2 * QUIET + 8 * gap:
        return loud
    # In as many sets as steps are usual or larger: what is largest in each is the least of these
    # at least, and so is what is usual.
    low, count = size, QUIET - int(share * QUIET)
    for k in (1, 2, 4, 8, 16):
        low = (np.maximum if 2 * k * count <= QUIET else np.minimum)(low[:-k], low[k:])
    low *= least
    first = gap + QUIET
    jumps = size[first:-first]
    np.greater(jumps, low[: jumps.size], out=loud[0, first:-first])
    np.greater(jumps, low[-jumps.size :], out=loud[1, first:-first])
    return loud


def _outstanding(
    size: FloatArray, at: IntArray, way: int, *, gap: int = 1, least: float = OUTSTANDING,
    share: float = 0.9,
) -> IntArray:  # fmt: skip
    """Those jumps that stand out of a share of the steps before them (way -1) or behind (1)."""
    if not at.size:
        return at
    first = at + 1 + gap if way > 0 else at - gap - QUIET
    near = size[first[:, None] + np.arange(QUIET)]
    usual = np.partition(near, int(share * QUIET), axis=-1)[:, int(share * QUIET)]
    return at[size[at] > least * usual]


class _Long:
    """Runs of True, their places and what stands there, those over the cuts whole."""

    def __init__(self, least: int) -> None:
        self.least, self.kept = least, list[tuple[int, int, float]]()

    def add(self, flags: BoolArray, start: int, values: FloatArray) -> None:
        edge = np.flatnonzero(np.diff(np.concatenate([[False], flags, [False]])))
        first, last = edge[::2], edge[1::2]
        runs = list(
            zip(
                (first + start).tolist(), (last + start).tolist(), values[first].tolist(),
                strict=True,
            )
        )  # fmt: skip
        if runs and self.kept and self.kept[-1][1] == runs[0][0]:
            runs[0] = (self.kept.pop()[0], *runs[0][1:])
        else:
            self.kept = self.runs
        # Those before the last one are over.
        self.kept += [r for r in runs[:-1] if r[1] - r[0] >= self.least] + runs[-1:]

    @property
    def runs(self) -> list[tuple[int, int, float]]:
        """Runs of a length at least; the short are let go."""
        last = self.kept[-1:]
        return self.kept[:-1] + [r for r in last if r[1] - r[0] >= self.least]


class _Crests:
    """The highest crests of any width, of which fast ones that were cut off are alike to the step.

    Columns: level, first and last sample, drop to the nearer neighbour, crown.
    """

    def __init__(self) -> None:
        self.rows: FloatArray = np.empty((0, 5))

    def add(
        self, x: FloatArray, begin: IntArray, end: IntArray, *, reach: int, start: int, size: int
    ) -> None:
        """Enter the crests that begin within a piece, level or not: what is level is known (k,)."""
        bar = self.rows[:, 0].min() if len(self.rows) >= CRESTS else -np.inf
        least = max(reach, 3)
        mine = x[least : reach + size]
        first = np.flatnonzero((mine >= bar) & (mine > x[least - 1 : reach + size - 1])) + least
        last = first + 1
        _, here, level = np.intersect1d(first, begin, assume_unique=True, return_indices=True)
        last[here] = end[level]
        first, last = first[last < x.size - 3], last[last < x.size - 3]
        first, last = first[x[last - 1] > x[last]], last[x[last - 1] > x[last]]
        if first.size > CRESTS:
            high = x[first] >= np.partition(x[first], -CRESTS)[-CRESTS]
            first, last = first[high], last[high]
        drop = np.minimum(x[first] - x[first - 1], x[last - 1] - x[last])
        crown = _both_crowns(x, first, last).mean(axis=-1)
        columns = (x[first], first + start, last + start, drop, crown)
        fresh = np.stack([np.asarray(c, float) for c in columns], -1)
        rows = np.concatenate([self.rows, fresh])
        self.rows = rows[np.argsort(-rows[:, 0], kind="stable")[:CRESTS]]

    def cut(self, step: float, taken: IntArray) -> FloatArray:
        """Return (k, 3) first, last and crown of the highest, where chance makes none so alike.

        By chance a crest falls on the highest one's step as often as crests lie as close below
        it, or as they are alike there, as of slow data in coarse steps or of a test that repeats;
        and a sample next to it as often as the drop beside it has steps.
        """
        none: FloatArray = np.empty((0, 3))
        order = np.argsort(self.rows[:, 1], kind="stable")
        spoiled = np.empty(len(order), bool)
        spoiled[order] = _touching(self.rows[order, 1:3].astype(np.intp), taken)
        rows = self.rows[~spoiled]
        if not (len(rows) and step < np.inf):
            return none
        step = max(step, float(np.spacing(np.abs(rows[:, [0, 3]]).max())))
        alike = rows[0, 0] - rows[:, 0] <= step / 2
        top, below = rows[alike], rows[~alike][: max(BELOW, 4 * np.count_nonzero(alike))]
        width = top[:, 2] - top[:, 1]
        if len(below) < BELOW or width.max() >= CLIPPED_RUN:
            return none
        gaps = -np.diff(below[:, 0])
        often = max(len(below) * step / (top[0, 0] - below[-1, 0]), float(np.mean(gaps < step / 2)))
        beside = np.maximum(top[:, 3] / step, 1.0)
        against = (len(top) - 1) * -np.log10(min(often, 1.0))
        against += float(((width - 1) * np.log10(beside)).sum())
        return top[:, [1, 2, 4]] if len(top) > 1 and against >= NO_CHANCE else none


class _Plateaus:
    """Level crests of the highest few levels; what is low is entered upside down."""

    LEVELS = 3

    def __init__(self) -> None:
        self.rows: FloatArray = np.empty((0, 5))

    def add(self, level: FloatArray, *columns: FloatArray | IntArray) -> None:
        """Enter levels (k,), first and last samples, steps into the level, crowns."""
        fresh = np.stack([np.asarray(c, float) for c in (level, *columns)], -1)
        self.rows = np.concatenate([self.rows, fresh])
        if len(self.rows):
            known = np.unique(self.rows[:, 0])
            self.rows = self.rows[self.rows[:, 0] >= known[-self.LEVELS :][0]]

    def clips(
        self, step: float, taken: IntArray, *, end: float, reached: FloatArray
    ) -> tuple[float, FloatArray]:
        """Return the level that crests are cut off at, and (k, 3) first, last and crown of each.

        A crest of slow data in coarse steps is level too; it is reached by one step. A single
        one below the channel's `end` stood still by chance, and what many blocks reach beyond
        (m,) cuts nothing off.
        """
        rows = self.rows[~_touching(self.rows[:, 1:3].astype(np.intp), taken)]
        for level in np.unique(rows[:, 0])[::-1]:
            there = rows[rows[:, 0] == level]
            width, entry = there[:, 2] - there[:, 1], there[:, 3]
            long = width >= CLIPPED_RUN
            cut = np.count_nonzero(long) > 1 or (level >= end and bool(long.any()))
            cut &= bool(long.any() and np.median(entry[long]) > 1.5 * step)
            steps = entry[width == 3] / step
            alone = bool((steps > CUT_ALONE).any())
            cut |= level >= end and (np.count_nonzero(steps > CUT_OF_THREE) > 1 or alone)
            if cut and bool(np.mean(reached > level) < RARE):
                return float(level), there[:, [1, 2, 4]]
        return np.nan, np.empty((0, 3))
