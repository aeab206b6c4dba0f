r"""The yield of a million variants, from a few thousand that were evaluated.

How far a truck stays off a limit is smooth in what scatters, so a parabola through the variants
evaluated predicts others at a thousandth of the cost. It is wrong for some, and trust is not
needed: how often it is wrong is counted on variants that it has not learned from. With s what is
predicted and y what was evaluated,

$$p = \mathrm E[s] + \mathrm P[y > s] - \mathrm P[s > y]$$

holds whatever s is. The first is the mean of as many as one likes; the other two are rare where s
is good, so few variants estimate them narrowly, and their intervals are those of the binomial.
"""

from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from cardan.application.variant_sampling import SamplingPlan
from cardan.core.arrays import BoolArray, FloatArray, IntArray, single_threaded_blas
from cardan.core.verdict import MARGIN_TOLERANCE
from cardan.topics.variants.statistics import StatisticState, clopper_pearson_interval

CROSS_VALIDATION_FOLDS = 8
"""Each part of those evaluated is predicted from the others."""

PREDICTION_BLOCK_VARIANTS = 8192
"""Variants predicted at a time."""

MIN_VARIANTS_PER_COEFFICIENT = 2.0
"""Variants for each coefficient, at least."""

DOUBT_SHARE_FOR_SAMPLING_ERROR = 0.02
"""Share of the error probability left to the sampling; the rest is for the prediction's errors."""


@dataclass(frozen=True, kw_only=True)
class SurrogateYield:
    """The predicted yield of many variants, and how far that is to be trusted.

    Attributes
    ----------
    count, training_count
        How many were predicted, and from how many.
    share, low, high
        That may be built, corrected by what was predicted wrongly; and its interval.
    false_failures, false_passes
        Of those taught: predicted to fail but passing, predicted to pass but failing.
    without_surrogate
        Whether share and interval are those of the variants evaluated, as the prediction is no
        narrower.
    """

    count: int
    training_count: int
    share: float
    low: float
    high: float
    false_failures: int
    false_passes: int
    without_surrogate: bool = False


def predict_yield(
    drawing: SamplingPlan,
    taught: StatisticState,
    *,
    count: int,
    start: int,
    confidence: float,
    asked: tuple[int, int] | None = None,
    workers: int = 1,
) -> SurrogateYield | None:
    """Return the predicted yield of `count` variants; None if too few were evaluated to learn from.

    Parameters
    ----------
    drawing
        Where variants lie, by Monte Carlo.
    taught
        Those evaluated (`cardan.topics.variants.statistics.SurrogateTraining`).
    start
        The place of the first of those predicted, behind all that were evaluated.
    asked
        How many of those evaluated may be built, and of how many; where their own interval is no
        wider, it is given instead.
    confidence
        Of the interval, at least: the bounds of both errors and of the sampling together.

    Raises
    ------
    ValueError
        If variants are not drawn by Monte Carlo sampling: then no interval holds.

    Notes
    -----
    A control variate with cross-fitting: each of `CROSS_VALIDATION_FOLDS` parts of those evaluated
    is predicted by least squares of the others, each margin by itself. Intervals of the errors
    after Clopper and Pearson (1934).
    """
    if drawing.method != "random" or drawing.grids:
        msg = "foretold needs tolerances and Monte Carlo sampling: remove sobol and grids"
        raise ValueError(msg)
    inputs, fit = taught["inputs"], taught["fit"]
    number = len(fit)
    part = np.arange(number) % CROSS_VALIDATION_FOLDS
    if number < CROSS_VALIDATION_FOLDS or (seen := _TrainingSet.of(inputs, taught["left"])) is None:
        return None
    each = [seen.learned(part != k) for k in range(CROSS_VALIDATION_FOLDS)]
    said = np.empty(number, dtype=bool)
    for k, one in enumerate(each):
        said[part == k] = one.fits(inputs[part == k])
    missed, praised = int((fit & ~said).sum()), int((said & ~fit).sum())

    def passed(piece: int) -> int:
        first = start + piece * PREDICTION_BLOCK_VARIANTS
        stop = min(first + PREDICTION_BLOCK_VARIANTS, start + count)
        return int(each[piece % CROSS_VALIDATION_FOLDS].fits(drawing.values(first, stop)).sum())

    with single_threaded_blas(), ThreadPoolExecutor(max(workers, 1)) as threads:
        whole = sum(threads.map(passed, range(-(-count // PREDICTION_BLOCK_VARIANTS))))
    share, doubt = whole / count, 1 - confidence
    errors = 1 - doubt * (1 - DOUBT_SHARE_FOR_SAMPLING_ERROR) / 2
    less, more = (
        clopper_pearson_interval(hits, number, confidence=errors) for hits in (praised, missed)
    )
    low, high = clopper_pearson_interval(
        whole, count, confidence=1 - doubt * DOUBT_SHARE_FOR_SAMPLING_ERROR
    )
    found = SurrogateYield(
        count=count,
        training_count=number,
        share=min(max(share + (missed - praised) / number, 0.0), 1.0),
        low=max(low + more[0] - less[1], 0.0),
        high=min(high + more[1] - less[0], 1.0),
        false_failures=missed,
        false_passes=praised,
    )
    if asked is None:
        return found
    low, high = clopper_pearson_interval(*asked, confidence=confidence)
    if high - low > found.high - found.low:
        return found
    return replace(found, share=asked[0] / asked[1], low=low, high=high, without_surrogate=True)


@dataclass(frozen=True, kw_only=True)
class _TrainingSet:
    """Variants that were evaluated: inputs (V, inputs) and margins to failure (V, limits).

    Of limits that may decide alone; inputs by their mean and spread, those that vary.
    """

    inputs: FloatArray
    left: FloatArray

    @classmethod
    def of(cls, inputs: FloatArray, left: FloatArray) -> "_TrainingSet | None":
        """Return them; None where they are too few for a plane."""
        known = np.isfinite(left)
        # What nothing varied moves, or what keeps far off, predicts nothing.
        some = [
            k for k in range(left.shape[1])
            if known[:, k].any() and np.ptp(m := left[known[:, k], k]) > max(0.0, m.min() / 2)
        ]  # fmt: skip
        seen = cls(inputs=inputs, left=left[:, some])
        return (
            seen
            if len(inputs) * (1 - 1 / CROSS_VALIDATION_FOLDS)
            >= MIN_VARIANTS_PER_COEFFICIENT * (1 + seen.varies.size)
            else None
        )

    @cached_property
    def varies(self) -> IntArray:
        """Which inputs vary."""
        return np.flatnonzero(np.ptp(self.inputs, axis=0) > 0)

    @cached_property
    def squares(self) -> bool:
        """Whether they are enough for a parabola."""
        p = self.varies.size
        return len(self.inputs) * (
            1 - 1 / CROSS_VALIDATION_FOLDS
        ) >= MIN_VARIANTS_PER_COEFFICIENT * (1 + p + p * (p + 1) / 2)

    def learned(self, of: BoolArray) -> "_QuadraticSurrogate":
        """Return what some of them teach."""
        x = self.inputs[of][:, self.varies]
        found = _QuadraticSurrogate(
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
        return _QuadraticSurrogate(
            varies=found.varies, middle=found.middle, wide=found.wide, squares=found.squares,
            weights=np.stack(columns, axis=-1) if columns else np.zeros((terms.shape[1], 0)),
        )  # fmt: skip


@dataclass(frozen=True, kw_only=True)
class _QuadraticSurrogate:
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
        """Return which variants are predicted to pass."""
        return np.asarray((self.terms(inputs) @ self.weights >= -MARGIN_TOLERANCE).all(axis=1))
