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
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np

from cardan.base.arrays import ArrayLike, FloatArray, IntArray
from cardan.fatigue.kernel import Kernel, fastest, gate_of_all, reversals


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


NONE: FloatArray = np.empty(0)


def join(parts: Iterable[Cycles]) -> Cycles:
    """Return all the cycles of some counts, in order."""
    parts = [Cycles(NONE, NONE, NONE), *parts]
    return Cycles(
        np.concatenate([p.start for p in parts]),
        np.concatenate([p.end for p in parts]),
        np.concatenate([p.count for p in parts]),
    )


def four_point(
    samples: ArrayLike, *, residue: FloatArray = NONE, kernel: Kernel | None = None
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
    n, last, way = 0, np.nan, 0
    if residue.size:
        n, last = residue.size - 1, float(residue[-1])
        stack[:n] = residue[:-1]
        step = last - float(residue[-2]) if n else 0.0
        way = (step > 0) - (step < 0)
    closed, n, last, way = (kernel or fastest())(x, stack, n, last, way, start, end)
    # Close against the running extreme too: it can only move farther out.
    while n >= 3 and abs(stack[n - 1] - stack[n - 2]) <= min(
        abs(stack[n - 2] - stack[n - 3]), abs(last - stack[n - 1])
    ):
        start[closed], end[closed] = stack[n - 2], stack[n - 1]
        closed, n = closed + 1, n - 2
    if not math.isnan(last):
        stack[n], n = last, n + 1
    open_now, start, end = stack[:n].copy(), start[:closed].copy(), end[:closed].copy()
    # A sum is as finite as all that is in it: of samples that are their sizes go nowhere near.
    if not math.isfinite(open_now.sum() + (start - end).sum()):
        msg = "samples must be finite or missing (nan), got infinity"
        raise ValueError(msg)
    return Cycles(start, end, np.ones(closed)), open_now


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
    return Cycles(NONE, NONE, NONE)


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
    return join([closed, rule(residue)])


def without_small(samples: FloatArray, *, gate: float) -> FloatArray:
    """Return samples (k,) that close the cycles of all (n,), but for some of ranges below a gate.

    Source: the rainflow filter, Rychlik, Int. J. Fatigue 9 (1987); a peak stays where the signal
    falls by more than the gate before it rises above it.
    """
    filtered = gate_of_all()
    if filtered is None or not gate > 0:
        return samples
    out = np.empty(samples.size + 2)
    return out[: filtered(samples, gate, out)]


def reversals_of(samples: FloatArray, *, gate: float) -> FloatArray:
    """Return the samples (k,) where a signal turns by more than a gate, with its first and last."""
    return reversals(without_small(samples, gate=gate))


def turns(samples: ArrayLike, *, gate: float) -> IntArray:
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
class FromTo:
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
    def empty(cls, *, bins: int = 512, width: float = 2.0**-20) -> "FromTo":
        """Return a matrix with nothing counted; `bins` even, `width` a power of two."""
        return cls(np.zeros((bins, bins)), width)

    @property
    def edges(self) -> FloatArray:
        """Bin edges, (bins + 1,)."""
        half = self.counts.shape[0] // 2
        return self.width * np.arange(-half, half + 1)

    def added(self, cycles: Cycles) -> "FromTo":
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
        return FromTo(counts + more.reshape(bins, bins), width)

    def cycles(self) -> Cycles:
        """Return the cycles at the middles of their bins, bins with nothing left out."""
        row, column = np.nonzero(self.counts)
        middle = (self.edges[:-1] + self.edges[1:]) / 2
        return Cycles(middle[row], middle[column], self.counts[row, column])


def range_mean(cycles: Cycles, *, ranges: ArrayLike, means: ArrayLike) -> FloatArray:
    """Cycles by range and mean, (ranges - 1, means - 1), between the edges given."""
    counted, _, _ = np.histogram2d(
        cycles.range,
        cycles.mean,
        bins=(np.asarray(ranges), np.asarray(means)),
        weights=cycles.count,
    )
    return counted


def range_pairs(cycles: Cycles, *, ranges: ArrayLike) -> FloatArray:
    """Cycles of at least each range, (n,): the range-pair count, cumulated from above."""
    order = np.argsort(cycles.range)
    total = np.append(np.cumsum(cycles.count[order][::-1])[::-1], 0.0)
    return total[np.searchsorted(cycles.range[order], np.asarray(ranges), side="left")]


def level_crossings(cycles: Cycles, residue: FloatArray, *, levels: ArrayLike) -> FloatArray:
    """Upward crossings of each level, (n,), from the closed cycles and their residue.

    A closed cycle crosses each level it spans once upward; so does each rising leg of the
    residue. The same numbers as counted on the signal itself, levels not touching reversals.
    """
    levels = np.asarray(levels, dtype=float)
    legs = np.diff(residue) > 0
    bottom = np.concatenate([np.minimum(cycles.start, cycles.end), residue[:-1][legs]])
    top = np.concatenate([cycles.top, residue[1:][legs]])
    count = np.concatenate([cycles.count, np.ones(int(legs.sum()))])

    def below(points: FloatArray) -> FloatArray:
        order = np.argsort(points)
        total = np.append(0.0, np.cumsum(count[order]))
        return total[np.searchsorted(points[order], levels, side="left")]

    return below(bottom) - below(top)
