"""Rainflow counting, in pieces or whole, with the residue rule always in sight.

The four-point rule closes a cycle B-C as soon as A-B and C-D both span it. What never
closes is the residue. The rule is local, so counting is a fold: the residue of what came
before is all the memory the next piece needs,

    cycles, residue = four_point(piece, residue=residue)

and pieces counted apart are joined by counting their residues one after the other. The
closed cycles and the residue counted by halves together are ASTM's rainflow count.
Sources: ASTM E1049-85 (2017), section 5.4.4; Amzallag et al., Int. J. Fatigue 16 (1994).
"""

import math
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import TypeAlias

import numpy as np

from cardan.core.arrays import ArrayLike, FloatArray, IntArray
from cardan.physics.fatigue.rainflow_kernels import (
    RainflowKernel,
    compiled_cause_coalition_cycle_counter,
    compiled_signal_cycle_counter,
    compiled_small_reversal_filter,
    fastest_kernel,
    reversals,
)


@dataclass(frozen=True)
class Cycles:
    """Counted cycles: from where to where, and how many times.

    Attributes
    ----------
    start, end : (n,)
        Reversals that bound each cycle, in the order they happened.
    count : (n,) 1
        1 for a closed cycle, 0.5 for a half one, more where cycles were binned.
    """

    start: FloatArray
    end: FloatArray
    count: FloatArray

    @property
    def range(self) -> FloatArray:
        """Distance between the two reversals, (n,)."""
        return np.abs(self.end - self.start)

    @property
    def amplitude(self) -> FloatArray:
        """Half the range, (n,)."""
        return self.range / 2

    @property
    def mean(self) -> FloatArray:
        """Middle of the two reversals, (n,)."""
        return (self.start + self.end) / 2

    @property
    def top(self) -> FloatArray:
        """Upper of the two reversals, (n,)."""
        return np.maximum(self.start, self.end)

    def scaled(self, factor: float) -> "Cycles":
        """Return the same cycles of a signal `factor` times as large."""
        return Cycles(factor * self.start, factor * self.end, self.count)

    def repeated(self, times: float) -> "Cycles":
        """Return every cycle counted `times` as often."""
        return Cycles(self.start, self.end, times * self.count)


EMPTY_REVERSALS: FloatArray = np.empty(0)


def concatenate_cycles(parts: Iterable[Cycles]) -> Cycles:
    """Return all the cycles of some counts, in order."""
    parts = [Cycles(EMPTY_REVERSALS, EMPTY_REVERSALS, EMPTY_REVERSALS), *parts]
    return Cycles(
        np.concatenate([p.start for p in parts]),
        np.concatenate([p.end for p in parts]),
        np.concatenate([p.count for p in parts]),
    )


def four_point(
    samples: ArrayLike,
    *,
    residue: FloatArray = EMPTY_REVERSALS,
    kernel: RainflowKernel | None = None,
) -> tuple[Cycles, FloatArray]:
    """Cycles that close in a piece of a signal, and the residue it leaves.

    Parameters
    ----------
    samples : (n,)
        The piece; its reversals are found here. Missing samples (nan) are stepped over.
    residue : (k,)
        What the pieces before it left; nothing for the first.
    kernel
        Inner loop; the fastest installed unless given.

    Returns
    -------
    cycles : Cycles
        Closed cycles, each counted once, exactly as in one piece.
    residue : (k,)
        Reversals still open. The last one may yet grow. Ranges first widen, then narrow.

    Raises
    ------
    ValueError
        If the samples are not one row, or reach infinity.
    """
    x = np.asarray(samples)
    if x.ndim != 1:
        msg = f"samples must be one row of numbers, got shape {x.shape}"
        raise ValueError(msg)
    if x.dtype.str not in ("<f4", "<f8"):  # others would each be compiled for
        x = x.astype(float)
    # Whatever the piece holds, at most one reversal a sample opens and half of them close.
    stack = np.empty(residue.size + x.size + 1)
    start = np.empty((residue.size + x.size) // 2 + 1)
    end = np.empty_like(start)
    closed, n = (kernel or fastest_kernel())(x, residue, stack, start, end)
    open_now, start, end = stack[:n].copy(), start[:closed].copy(), end[:closed].copy()
    # A sum is as finite as all that is in it: of samples that are their sizes go nowhere near.
    if not math.isfinite(open_now.sum() + (start - end).sum()):
        msg = "samples must be finite or missing (nan), got infinity"
        raise ValueError(msg)
    return Cycles(start, end, np.ones(closed)), open_now


@dataclass(frozen=True)
class CyclesOfManySignals:
    """What closes in many signals, and what each leaves.

    Attributes
    ----------
    cycles
        Closed cycles of all of them.
    row : (cycles,)
        Of which signal each is.
    residues : list of (k,)
        Reversals still open in each.
    """

    cycles: Cycles
    row: IntArray
    residues: list[FloatArray]


def four_point_of_many_signals(
    rows: Sequence[FloatArray], *, residues: Sequence[FloatArray]
) -> CyclesOfManySignals:
    """Count as `four_point` many short signals (n,) at once, each after its residue."""
    loop = compiled_signal_cycle_counter()
    if loop is None:
        return _collected_rows(
            four_point(x, residue=r) for x, r in zip(rows, residues, strict=True)
        )
    flat, sizes = np.concatenate(rows), np.array([x.size for x in rows])
    left, had = np.concatenate(residues), np.array([r.size for r in residues])
    room = _work_arrays(flat.size + left.size, len(rows))
    loop(flat, sizes, left, had, *room)
    return _trimmed_work_arrays(*room)


CAUSE_COALITIONS_PER_BLOCK = 16
"""Choices that are counted at once."""


def rainflow_of_cause_coalitions(
    parts: FloatArray, *, gate: float, residues: Sequence[FloatArray]
) -> Iterator[tuple[IntArray, CyclesOfManySignals]]:
    """Count every choice of some parts of a signal, some choices at a time.

    Parameters
    ----------
    parts : (k, n)
        Of a piece of it.
    gate
        Cycles of a range below it may be passed over.
    residues : 2^k of (m,)
        What the pieces before left of each choice: bit j of its place says whether part j is in.

    Yields
    ------
    choices, rows
        Which, and what closed in each.
    """
    many, n = 1 << len(parts), parts.shape[1]
    # Gray's order: from one choice to the next a single part comes or goes.
    order = np.arange(many) ^ np.arange(many) >> 1
    loop, x = compiled_cause_coalition_cycle_counter(), np.zeros(n)
    for first in range(0, many, CAUSE_COALITIONS_PER_BLOCK):
        choices = order[first : first + CAUSE_COALITIONS_PER_BLOCK]
        before = [residues[c] for c in choices]
        if loop is None:
            bits = choices[:, None] >> np.arange(len(parts)) & 1
            yield (
                choices,
                _collected_rows(
                    four_point(omit_small_cycles(bit @ parts, gate=gate), residue=r)
                    for bit, r in zip(bits, before, strict=True)
                ),
            )
            continue
        had = np.array([r.size for r in before])
        room = _work_arrays(int(had.sum()) + (n + 2) * had.size, had.size)
        loop(parts, first, gate, x, np.concatenate(before), had, *room)
        yield choices, _trimmed_work_arrays(*room)


def _work_arrays(reversals: int, rows: int) -> tuple[FloatArray, FloatArray, FloatArray, IntArray]:
    """Room for what so many reversals in rows leave open, close from where to where, and counts."""
    half = reversals // 2 + rows
    return (
        np.empty(reversals + rows), np.empty(half), np.empty(half), np.empty((rows, 2), np.int64)
    )  # fmt: skip


def _trimmed_work_arrays(
    stack: FloatArray, start: FloatArray, end: FloatArray, many: IntArray
) -> CyclesOfManySignals:
    """Return what was written in a room."""
    closed, opened = many.T
    done = int(closed.sum())
    ends = np.cumsum(opened).tolist()
    left = [stack[a:b].copy() for a, b in pairwise([0, *ends])]
    cycles = Cycles(start[:done].copy(), end[:done].copy(), np.ones(done))
    return CyclesOfManySignals(cycles, np.repeat(np.arange(closed.size), closed), left)


def _collected_rows(counted: Iterable[tuple[Cycles, FloatArray]]) -> CyclesOfManySignals:
    """Return signals counted one by one."""
    closed, residues = zip(*counted, strict=True)
    sizes = [c.count.size for c in closed]
    return CyclesOfManySignals(
        concatenate_cycles(closed), np.repeat(np.arange(len(sizes)), sizes), list(residues)
    )


ResidueRule: TypeAlias = Callable[[FloatArray], Cycles]
"""Turns a residue into cycles: `half_cycles`, `repeating` or `discarded`."""


def half_cycles(residue: FloatArray) -> Cycles:
    """Count each leg of a residue as half a cycle: ASTM E1049's rule for one passage."""
    return Cycles(residue[:-1], residue[1:], np.full(max(residue.size - 1, 0), 0.5))


def repeating(residue: FloatArray) -> Cycles:
    """Close a residue as if the record repeats for ever: a route driven again and again.

    The largest cycle then closes once in every repeat. ASTM E1049, section 5.4.5.
    """
    return four_point(residue, residue=residue)[0]


def discarded(_: FloatArray) -> Cycles:
    """Count nothing of a residue, largest cycle included: for comparison only, unsafe."""
    return Cycles(EMPTY_REVERSALS, EMPTY_REVERSALS, EMPTY_REVERSALS)


def rainflow(samples: ArrayLike, *, rule: ResidueRule = half_cycles) -> Cycles:
    """Rainflow cycles of a whole signal.

    Parameters
    ----------
    samples : (n,)
        The signal; nan is stepped over.
    rule
        What becomes of the residue. It holds the largest cycle, often half the damage.

    Returns
    -------
    Cycles
        With `half_cycles`, the count of ASTM E1049-85 (2017), section 5.4.4.

    Examples
    --------
    >>> cycles = rainflow([-2, 1, -3, 5, -1, 3, -4, 4, -2])
    >>> cycles.range.tolist()
    [4.0, 3.0, 4.0, 8.0, 9.0, 8.0, 6.0]
    >>> cycles.count.tolist()
    [1.0, 0.5, 0.5, 0.5, 0.5, 0.5, 0.5]
    """
    closed, residue = four_point(samples)
    return concatenate_cycles([closed, rule(residue)])


def omit_small_cycles(samples: FloatArray, *, gate: float) -> FloatArray:
    """Return samples (k,) that close the cycles of all (n,), but for some of ranges below a gate.

    Source: the rainflow filter, Rychlik, Int. J. Fatigue 9 (1987); a peak stays where the signal
    falls by more than the gate before it rises above it.
    """
    filtered = compiled_small_reversal_filter()
    if filtered is None or not gate > 0:
        return samples
    out = np.empty(samples.size + 2)
    return out[: filtered(samples, gate, out)]


def significant_reversals(samples: FloatArray, *, gate: float) -> FloatArray:
    """Return the samples (k,) where a signal turns by more than a gate, with its first and last."""
    return reversals(omit_small_cycles(samples, gate=gate))


def turning_points(samples: ArrayLike, *, gate: float) -> IntArray:
    """Numbers of the samples (n,) at which a signal turns by more than a share of its range.

    With its first, last, highest and lowest. What lies between two turns goes one way, but for
    what turns by less: a hysteresis filter.
    """
    x = np.asarray(samples, dtype=float)
    step = gate * np.ptp(x)
    here = np.flatnonzero(np.diff(np.sign(np.diff(x))) != 0) + 1
    ends = np.array([0, len(x) - 1, x.argmax(), x.argmin()])
    here = np.unique(np.concatenate([ends, here]))
    kept, way = [0], 0
    for k in here.tolist():
        rise = x[k] - x[kept[-1]]
        if way * rise > 0:
            kept[-1] = k  # further the same way
        elif abs(rise) > step:
            way = 1 if rise > 0 else -1
            kept.append(k)
    return np.unique([0, *kept, len(x) - 1])


@dataclass(frozen=True)
class FromToMatrix:
    """A from-to matrix that finds its own range: the count of a signal of any length.

    `bins` square bins of one width, a power of two, lie about zero. A cycle out of range
    doubles the width by merging bins in pairs, which moves no edge that stays, so the
    result does not depend on how the signal was cut into pieces.

    Attributes
    ----------
    counts : (bins, bins)
        Cycles by the bins of their start (rows) and end (columns).
    width
        Bin width in the signal's unit.
    """

    counts: FloatArray
    width: float

    @classmethod
    def empty(cls, *, bins: int = 512, width: float = 2.0**-20) -> "FromToMatrix":
        """Return a matrix with nothing counted; `bins` even, `width` a power of two."""
        return cls(np.zeros((bins, bins)), width)

    @property
    def edges(self) -> FloatArray:
        """Bin edges, (bins + 1,)."""
        half = self.counts.shape[0] // 2
        return self.width * np.arange(-half, half + 1)

    def with_cycles(self, cycles: Cycles) -> "FromToMatrix":
        """Return the matrix with more cycles in it."""
        if not cycles.count.size:
            return self
        bins, counts, width = self.counts.shape[0], self.counts, self.width
        reach = max(np.abs(cycles.start).max(), np.abs(cycles.end).max())
        if not counts.any():
            while reach >= width * (bins // 2):
                width *= 2
        while reach >= width * (bins // 2):
            quarter = bins // 4
            merged = counts.reshape(bins // 2, 2, bins // 2, 2).sum((1, 3))
            counts = np.zeros_like(counts)
            counts[quarter : quarter + bins // 2, quarter : quarter + bins // 2] = merged
            width *= 2
        row = np.floor(cycles.start / width).astype(np.int64) + bins // 2
        column = np.floor(cycles.end / width).astype(np.int64) + bins // 2
        more = np.bincount(row * bins + column, cycles.count, minlength=bins * bins)
        return FromToMatrix(counts + more.reshape(bins, bins), width)

    def cycles(self) -> Cycles:
        """Return the cycles at the middles of their bins, bins with nothing left out."""
        row, column = np.nonzero(self.counts)
        middle = (self.edges[:-1] + self.edges[1:]) / 2
        return Cycles(middle[row], middle[column], self.counts[row, column])


def range_pairs(cycles: Cycles, *, ranges: ArrayLike) -> FloatArray:
    """Cycles of at least each range, (n,): the range-pair count, cumulated from above."""
    order = np.argsort(cycles.range)
    total = np.append(np.cumsum(cycles.count[order][::-1])[::-1], 0.0)
    return total[np.searchsorted(cycles.range[order], np.asarray(ranges), side="left")]
