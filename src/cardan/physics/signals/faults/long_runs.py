"""Runs of True in a signal that passes in pieces, whole over the cuts."""

import numpy as np

from cardan.core.arrays import BoolArray, FloatArray


class LongRuns:
    """Runs of True, their places and what stands there, those over the cuts whole."""

    def __init__(self, least: int) -> None:
        self.least, self.kept = least, list[tuple[int, int, float]]()

    def update(self, flags: BoolArray, start: int, values: FloatArray) -> None:
        """Take the flags (n,) of a piece, and the values there."""
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
