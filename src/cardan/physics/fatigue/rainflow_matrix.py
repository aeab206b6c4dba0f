"""Rainflow matrices to keep: from-to and range-mean, in bins that any two matrices share.

All bins of a matrix have one width, a power of two, and an edge at zero. A wider bin is therefore
made of whole narrower ones, and matrices of any recordings are merged without moving a cycle.
"""

from collections.abc import Iterable
from dataclasses import dataclass, replace
from typing import Literal, Self, TypeAlias, TypeVar

import numpy as np

from cardan.core.arrays import FloatArray, IntArray
from cardan.physics.fatigue.rainflow import Cycles, FromToMatrix

RainflowKind: TypeAlias = Literal["from-to", "range-mean"]
"""What the two axes of a matrix are."""
TableT = TypeVar("TableT", bound="RainflowTable")


@dataclass(frozen=True, kw_only=True)
class RainflowTable:
    """Cycles of a rainflow count by bins: those n bins that hold any.

    Attributes
    ----------
    kind
        `from-to`: the two reversals of a cycle in the order they happened. `range-mean`: the
        distance between them, and their middle.
    width
        Of every bin, in the signal's unit: a power of two.
    row, column : (n,)
        Numbers of the bins along the two axes: bin k reaches from k width to below (k + 1) width.
    count : (n,) 1
        Cycles; a half cycle of the residue is 0.5.
    """

    kind: RainflowKind
    width: float
    row: IntArray
    column: IntArray
    count: FloatArray

    @property
    def total(self) -> float:
        """Number of cycles."""
        return float(self.count.sum())

    def coarsened(self, width: float) -> Self:
        """Return the matrix with bins of a width, a power of two and no narrower than its own."""
        parts = round(width / self.width)
        return self._gathered(width, self.row // parts, self.column // parts, self.count)

    def merged(self, other: "RainflowTable", *, times: float = 1.0) -> Self:
        """Return both matrices as one, the other `times` as often, in the wider bins of the two.

        Raises
        ------
        ValueError
            If their axes differ.
        """
        if other.kind != self.kind:
            msg = f"a {self.kind} and a {other.kind} matrix cannot be merged"
            raise ValueError(msg)
        width = max((t.width for t in (self, other) if t.count.size), default=self.width)
        own, more = self, other
        if own.count.size:
            own = own.coarsened(width)
        if more.count.size:
            more = more.coarsened(width)
        return self._gathered(
            width,
            np.concatenate([own.row, more.row]),
            np.concatenate([own.column, more.column]),
            np.concatenate([own.count, times * more.count]),
        )

    def cycles(self) -> Cycles:
        """Return the cycles at the middles of their bins."""
        one: FloatArray = np.asarray(self.width * (self.row + 0.5), float)
        other: FloatArray = np.asarray(self.width * (self.column + 0.5), float)
        if self.kind == "from-to":
            return Cycles(one, other, self.count)
        return Cycles(other - one / 2, other + one / 2, self.count)

    def _gathered(self, width: float, row: IntArray, column: IntArray, count: FloatArray) -> Self:
        """Return cycles by bins of which some may be alike."""
        places = np.stack([row, column]) if row.size else np.empty((2, 0), np.int64)
        bins, which = np.unique(places, axis=1, return_inverse=True)
        sums = np.bincount(which.ravel(), count, minlength=bins.shape[1])
        return replace(self, width=width, row=bins[0], column=bins[1], count=sums)


def merge_tables(parts: Iterable[tuple[TableT, float]]) -> TableT:
    """Return some matrices as one, each so many times: those of a campaign's recordings.

    Raises
    ------
    ValueError
        If there are none, or their axes differ.
    """
    (first, times), *others = parts
    whole = replace(first, count=times * first.count)
    for table, often in others:
        whole = whole.merged(table, times=often)
    return whole


def from_to_table(of: FromToMatrix) -> RainflowTable:
    """Return a from-to matrix by its bins that hold any cycle."""
    row, column = np.nonzero(of.counts)
    half = of.counts.shape[0] // 2
    return RainflowTable(
        kind="from-to", width=of.width, row=row - half, column=column - half,
        count=of.counts[row, column],
    )  # fmt: skip


@dataclass(frozen=True)
class RangeMeanMatrix:
    """A range-mean matrix that finds its own range, as `FromToMatrix` does.

    Attributes
    ----------
    counts : (bins, bins)
        Cycles by the bins of their range (rows, from zero) and mean (columns, about zero).
    width
        Bin width in the signal's unit, a power of two.
    """

    counts: FloatArray
    width: float

    @classmethod
    def empty(cls, *, bins: int = 512, width: float = 2.0**-20) -> "RangeMeanMatrix":
        """Return a matrix with nothing counted; `bins` a multiple of four."""
        return cls(np.zeros((bins, bins)), width)

    def with_cycles(self, cycles: Cycles) -> "RangeMeanMatrix":
        """Return the matrix with more cycles in it."""
        if not cycles.count.size:
            return self
        bins, counts, width = self.counts.shape[0], self.counts, self.width
        mean = cycles.mean
        reach = max(cycles.range.max() / 2, np.abs(mean).max())
        used = bool(counts.any())
        while reach >= width * (bins // 2):
            width *= 2
            if used:
                quarter = bins // 4
                merged = counts.reshape(bins // 2, 2, bins // 2, 2).sum((1, 3))
                counts = np.zeros_like(counts)
                counts[: bins // 2, quarter : quarter + bins // 2] = merged
        row = np.floor(cycles.range / width).astype(np.int64)
        column = np.floor(mean / width).astype(np.int64) + bins // 2
        more = np.bincount(row * bins + column, cycles.count, minlength=bins * bins)
        return RangeMeanMatrix(counts + more.reshape(bins, bins), width)

    def nonempty_bins(self) -> RainflowTable:
        """Return the matrix by its bins that hold any cycle."""
        row, column = np.nonzero(self.counts)
        return RainflowTable(
            kind="range-mean", width=self.width, row=row,
            column=column - self.counts.shape[1] // 2, count=self.counts[row, column],
        )  # fmt: skip
