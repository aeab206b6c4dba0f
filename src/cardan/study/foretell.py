r"""The yield of a million variants, from a few thousand that were asked.

How far a truck stays off a limit is smooth in what scatters, so a parabola through the variants
asked foretells others at a thousandth of the cost. It is wrong of some, and nobody has to trust it:
how often it is wrong is counted on variants that it has not learned from. With s what is foretold
and y what was asked,

$$p = \mathrm E[s] + \mathrm P[y > s] - \mathrm P[s > y]$$

holds whatever s is. The first is the mean of as many as one likes; the other two are rare where s
is good, so few variants tell them narrowly, and their intervals are those of the binomial.
"""

from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from cardan.base.arrays import BoolArray, FloatArray, IntArray, single_threaded
from cardan.base.verdict import EQUAL
from cardan.study.draw import Drawing
from cardan.study.reduce import State, clopper_pearson

FOLDS = 8
"""Each part of those asked is foretold by what the others teach."""

PIECE = 8192
"""Variants foretold at a time."""

ENOUGH = 2.0
"""Variants for each coefficient, at least."""

DICE = 0.02
"""Share of the doubt that is left to the dice of those foretold; the rest is for its errors."""


@dataclass(frozen=True, kw_only=True)
class Foretold:
    """The yield of many variants foretold, and how far that is to be trusted.

    Attributes
    ----------
    count, taught
        How many were foretold, and from how many.
    share, low, high
        That may be built, mended by what was foretold wrongly; and its interval.
    missed, praised
        Of those taught: foretold to fail and fit, foretold to fit and failing.
    plain
        Whether share and interval are those of the variants asked, foretold no more narrowly.
    """

    count: int
    taught: int
    share: float
    low: float
    high: float
    missed: int
    praised: int
    plain: bool = False


def foretold(
    drawing: Drawing,
    taught: State,
    *,
    count: int,
    start: int,
    confidence: float,
    asked: tuple[int, int] | None = None,
    workers: int = 1,
) -> Foretold | None:
    """Return the yield of `count` variants foretold; None where too few were asked to learn from.

    Parameters
    ----------
    drawing
        Where variants lie, by dice.
    taught
        Those asked (`cardan.study.reduce.Taught`).
    start
        The place of the first of those foretold, behind all that were asked.
    asked
        How many of those asked may be built, and of how many; where their own interval is no
        wider, it is told instead.
    confidence
        Of the interval, at least: the bounds of both errors and of the dice together.

    Raises
    ------
    ValueError
        If variants are not drawn by dice: then no interval holds.

    Notes
    -----
    A control variate with cross-fitting: each of `FOLDS` parts of those asked is foretold by least
    squares of the others, each margin by itself. Intervals of the errors after Clopper and Pearson
    (1934).
    """
    if drawing.points != "random" or drawing.grids:
        msg = "foretold: needs tolerances, drawn by dice: ask it without sobol and grids"
        raise ValueError(msg)
    inputs, fit = taught["inputs"], taught["fit"]
    number = len(fit)
    part = np.arange(number) % FOLDS
    if number < FOLDS or (seen := _Seen.of(inputs, taught["left"])) is None:
        return None
    each = [seen.learned(part != k) for k in range(FOLDS)]
    said = np.empty(number, dtype=bool)
    for k, one in enumerate(each):
        said[part == k] = one.fits(inputs[part == k])
    missed, praised = int((fit & ~said).sum()), int((said & ~fit).sum())

    def passed(piece: int) -> int:
        first = start + piece * PIECE
        stop = min(first + PIECE, start + count)
        return int(each[piece % FOLDS].fits(drawing.values(first, stop)).sum())

    with single_threaded(), ThreadPoolExecutor(max(workers, 1)) as threads:
        whole = sum(threads.map(passed, range(-(-count // PIECE))))
    share, doubt = whole / count, 1 - confidence
    errors = 1 - doubt * (1 - DICE) / 2
    less, more = (clopper_pearson(hits, number, confidence=errors) for hits in (praised, missed))
    low, high = clopper_pearson(whole, count, confidence=1 - doubt * DICE)
    found = Foretold(
        count=count,
        taught=number,
        share=min(max(share + (missed - praised) / number, 0.0), 1.0),
        low=max(low + more[0] - less[1], 0.0),
        high=min(high + more[1] - less[0], 1.0),
        missed=missed,
        praised=praised,
    )
    if asked is None:
        return found
    low, high = clopper_pearson(*asked, confidence=confidence)
    if high - low > found.high - found.low:
        return found
    return replace(found, share=asked[0] / asked[1], low=low, high=high, plain=True)


@dataclass(frozen=True, kw_only=True)
class _Seen:
    """Variants that were asked: inputs (V, inputs) and margins to failure (V, limits).

    Of limits that may decide alone; inputs by their mean and spread, those that vary.
    """

    inputs: FloatArray
    left: FloatArray

    @classmethod
    def of(cls, inputs: FloatArray, left: FloatArray) -> "_Seen | None":
        """Return them; None where they are too few for a plane."""
        known = np.isfinite(left)
        # What nothing varied moves, or what keeps far off, foretells nothing.
        some = [
            k for k in range(left.shape[1])
            if known[:, k].any() and np.ptp(m := left[known[:, k], k]) > max(0.0, m.min() / 2)
        ]  # fmt: skip
        seen = cls(inputs=inputs, left=left[:, some])
        return seen if len(inputs) * (1 - 1 / FOLDS) >= ENOUGH * (1 + seen.varies.size) else None

    @cached_property
    def varies(self) -> IntArray:
        """Which inputs vary."""
        return np.flatnonzero(np.ptp(self.inputs, axis=0) > 0)

    @cached_property
    def squares(self) -> bool:
        """Whether they are enough for a parabola."""
        p = self.varies.size
        return len(self.inputs) * (1 - 1 / FOLDS) >= ENOUGH * (1 + p + p * (p + 1) / 2)

    def learned(self, of: BoolArray) -> "_Learned":
        """Return what some of them teach."""
        x = self.inputs[of][:, self.varies]
        found = _Learned(
            varies=self.varies, middle=x.mean(axis=0), wide=x.std(axis=0), squares=self.squares,
            weights=np.empty((0, 0)),
        )  # fmt: skip
        terms = found.terms(self.inputs[of])
        columns: list[FloatArray] = []
        for m in self.left[of].T:
            known = np.isfinite(m)
            near = m / max(float(np.median(np.abs(m[known]))) if known.any() else 1.0, 1e-12)
            heed = np.where(known, 1 / (1 + np.nan_to_num(near) ** 2), 0.0)  # it matters near 0
            columns.append(
                np.linalg.lstsq(
                    terms * heed[:, None], np.nan_to_num(m) * heed, rcond=None
                )[0]
            )  # fmt: skip
        return _Learned(
            varies=found.varies, middle=found.middle, wide=found.wide, squares=found.squares,
            weights=np.stack(columns, axis=-1) if columns else np.zeros((terms.shape[1], 0)),
        )  # fmt: skip


@dataclass(frozen=True, kw_only=True)
class _Learned:
    """Parabolas (terms, limits) of margins over what varies."""

    varies: IntArray
    middle: FloatArray
    wide: FloatArray
    squares: bool
    weights: FloatArray

    def terms(self, inputs: FloatArray) -> FloatArray:
        """Return 1, x and x_i x_j of variants, (V, terms)."""
        x = (inputs[:, self.varies] - self.middle) / self.wide
        return np.concatenate([np.ones((len(x), 1)), x, *self._products(x)], axis=1)

    def _products(self, x: FloatArray) -> Iterator[FloatArray]:
        for k in range(x.shape[1] * self.squares):
            yield x[:, k:] * x[:, k, None]

    def fits(self, inputs: FloatArray) -> BoolArray:
        """Return which variants may be built, foretold."""
        return np.asarray((self.terms(inputs) @ self.weights >= -EQUAL).all(axis=1))
