"""Statistics of variants, from shards of them that are seen once and forgotten.

A reduction makes a state of a shard and one of two states; states are tables of arrays, so
that they can be kept in a file. Joined in the order of the shards they come to the same to
the last bit, whichever worker computed them and whenever.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from itertools import pairwise
from typing import Any, Protocol, TypeAlias

import numpy as np

from cardan.application.variant_sampling import SamplingPlan
from cardan.approval.applied_adjustments import AppliedAdjustment
from cardan.core.arrays import BoolArray, FloatArray, IntArray
from cardan.core.verdict import CHECK_GRADES, VERDICTS
from cardan.model.adjustments import (
    ADJUSTMENTS,
    first_known_name_matching_pattern,
    permitted_adjustments_by_name,
)
from cardan.model.application import PermittedAdjustment
from cardan.model.variants import ParetoObjective, VariantOutputs, VariedNumber
from cardan.topics.variants.evaluation import (
    UNEVALUATED_GRADE_CODE,
    EvaluatedVariants,
    VariantEvaluator,
)

StatisticState: TypeAlias = Mapping[str, Any]
"""Arrays by name."""

QUANTILE_RELATIVE_ERROR = 2e-3
"""How far a quantile may be off, as a share of itself."""

YIELD_MAP_CELLS_PER_AXIS = 20
"""Of a map along each axis, where nothing else says how many."""

WORST_ACCEPTABLE_VERDICT_INDEX = VERDICTS.index("warn")
"""What is no worse than this may be built."""


class StreamingStatistic(Protocol):
    """A statistic of variants."""

    def shard_state(self, rows: EvaluatedVariants, start: int) -> StatisticState:
        """Return the state of a shard whose first variant has this place."""
        ...

    def merge(self, one: StatisticState, other: StatisticState) -> StatisticState:
        """Return the state of two shards, the earlier first."""
        ...


def requested_statistics(
    bench: VariantEvaluator, ask: VariantOutputs
) -> dict[str, StreamingStatistic]:
    """Return the statistics of a study, by name."""
    drawn = bench.sampling_plan
    found: dict[str, StreamingStatistic] = {
        "counts": VerdictCounts(),
        "worst": WorstVariants(max_count=0 if ask.yield_only else ask.worst),
    }
    if not ask.yield_only:
        found["values"] = QuantileSketch()
        found["first"] = FirstVariantSamples()
    if any(f.tolerance for f in drawn.factors):
        found["tighter"] = ToleranceTightening(sampling_plan=drawn, yield_only=ask.yield_only)
    if drawn.method == "saltelli":
        found["sobol"] = SobolSamplePairs(factors=len(drawn.factors))
    if ask.foretold:
        found["taught"] = SurrogateTraining()
    if ask.pareto:
        found["pareto"] = ParetoFront(
            goals=ask.pareto, costs=adjustable_of_each_input(bench), sampling_plan=drawn
        )
    for k, pair in enumerate(ask.maps, 1):
        found[f"map{k}"] = YieldMap.for_pair(pair, drawn)
    return found


def _added(one: StatisticState, other: StatisticState) -> dict[str, Any]:
    return {name: one[name] + other[name] for name in one}


# --------------------------------------------------------------------------- how many


@dataclass(frozen=True)
class VerdictCounts:
    """How many variants come to what; of those drawn by themselves.

    Of each limit besides: to which grade (pass, warn, fail, not evaluated), how often it is the
    only one to fail, how often its margin is the smallest, and how often its value is a lower
    bound. `stopped` are those that a cheap
    limit failed, of which other limits know nothing.
    """

    def shard_state(self, rows: EvaluatedVariants, start: int) -> StatisticState:
        """Return the counts of a shard."""
        del start
        own, a = rows.independent, rows.results
        grades = a.grades[:, own]
        fails = grades == CHECK_GRADES.index("fail")
        left = a.deciding_margins[:, own]
        least = np.bincount(left.argmin(axis=0), minlength=len(left))
        return {
            "count": np.array(own.sum()),
            "asked": np.array(rows.count),
            "verdicts": np.bincount(rows.grades[own], minlength=len(VERDICTS)),
            "grades": np.stack(
                [(grades == g).sum(-1) for g in (0, 1, 2, UNEVALUATED_GRADE_CODE)], axis=-1
            ),
            "alone": (fails & (fails.sum(axis=0) == 1)).sum(-1),
            "first": least,
            "refused": np.array(a.infeasible[own].sum()),
            "bounded": np.array(rows.shown_by_bounds_alone[own].sum()),
            "lower_bounds": a.bounded[:, own].sum(-1),
            "stopped": np.array(a.stopped[own].sum()),
        }

    def merge(self, one: StatisticState, other: StatisticState) -> StatisticState:
        """Return the sums."""
        return _added(one, other)


def wilson_interval(hits: int, count: int, *, confidence: float) -> tuple[float, float]:
    """Return Wilson's interval of a share, of which `hits` of `count` were seen.

    Source: Wilson (1927), without continuity correction.
    """
    from scipy.special import ndtri

    z = float(ndtri((1 + confidence) / 2))
    p, weight = hits / count, z * z / count
    middle = (p + weight / 2) / (1 + weight)
    half = z / (1 + weight) * ((p * (1 - p) + weight / 4) / count) ** 0.5
    return max(middle - half, 0.0), min(middle + half, 1.0)


def clopper_pearson_interval(hits: int, count: int, *, confidence: float) -> tuple[float, float]:
    """Return the exact interval of a share: it holds it at least as often as it says.

    Source: Clopper & Pearson (1934).
    """
    from scipy.special import betaincinv

    tail = (1 - confidence) / 2
    low = float(betaincinv(hits, count - hits + 1, tail)) if hits else 0.0
    high = float(betaincinv(hits + 1, count - hits, 1 - tail)) if hits < count else 1.0
    return low, high


# --------------------------------------------------------------------------- how they scatter


@dataclass(frozen=True)
class QuantileSketch:
    """How values scatter: counts in cells whose edges grow by a fixed share.

    Columns are each limit's values, each limit's margins and the smallest margin. A quantile
    is off by `QUANTILE_RELATIVE_ERROR` of itself at most, however many variants there are; extremes
    and means are exact. Source: Masson, Rim & Lee, DDSketch, VLDB 12 (2019).
    """

    def shard_state(self, rows: EvaluatedVariants, start: int) -> StatisticState:
        """Return the cells of a shard."""
        del start
        a, own = rows.results, rows.independent
        every = np.concatenate([a.values[:, own], a.margins[:, own], rows.margins[None, own]])
        known = np.isfinite(every)
        column = np.broadcast_to(np.arange(len(every))[:, None], every.shape)[known]
        code, count = np.unique((column << 32) + _cell(every[known]), return_counts=True)
        return {
            "code": code,
            "count": count,
            "known": known.sum(-1),
            "sum": np.where(known, every, 0.0).sum(-1),
            "least": np.where(known, every, np.inf).min(-1, initial=np.inf),
            "most": np.where(known, every, -np.inf).max(-1, initial=-np.inf),
        }

    def merge(self, one: StatisticState, other: StatisticState) -> StatisticState:
        """Return the cells of both."""
        code, place = np.unique(np.concatenate([one["code"], other["code"]]), return_inverse=True)
        count = np.zeros(len(code), dtype=np.int64)
        np.add.at(count, place, np.concatenate([one["count"], other["count"]]))
        return {
            "code": code,
            "count": count,
            "known": one["known"] + other["known"],
            "sum": one["sum"] + other["sum"],
            "least": np.minimum(one["least"], other["least"]),
            "most": np.maximum(one["most"], other["most"]),
        }


_GROWTH = np.log((1 + QUANTILE_RELATIVE_ERROR) / (1 - QUANTILE_RELATIVE_ERROR))
_TINY, _MIDDLE, _FAR = 1e-12, 1 << 31, 1 << 20


def _cell(values: FloatArray) -> IntArray:
    """Return the cells of values, in their order."""
    size = np.abs(values)
    steps = np.ceil(np.log(np.maximum(size, _TINY)) / _GROWTH).astype(np.int64) + _FAR
    return np.where(size <= _TINY, 0, np.where(values < 0, -steps, steps)) + _MIDDLE


def _inside(cell: IntArray) -> FloatArray:
    """Return a value of each cell, at most `QUANTILE_RELATIVE_ERROR` from any other."""
    signed = cell - _MIDDLE
    size = np.exp((np.abs(signed) - _FAR) * _GROWTH) * (1 - QUANTILE_RELATIVE_ERROR)
    return np.where(signed == 0, 0.0, np.sign(signed) * size)


def yield_map_cell_counts(state: StatisticState, column: int) -> tuple[FloatArray, IntArray]:
    """Return the values of a column's cells, smallest first, and how many lie in each."""
    mine = state["code"] >> 32 == column
    return _inside(state["code"][mine] & 0xFFFFFFFF), state["count"][mine]


def quantile(state: StatisticState, column: int, share: float) -> float:
    """Return the value that a share of a column is below; nan where nothing is known."""
    if not state["known"][column]:
        return float("nan")
    values, counts = yield_map_cell_counts(state, column)
    rank = share * (counts.sum() - 1)
    found = values[np.searchsorted(counts.cumsum(), rank, side="right").clip(max=len(values) - 1)]
    return float(np.clip(found, state["least"][column], state["most"][column]))


# --------------------------------------------------------------------------- the worst


@dataclass(frozen=True)
class WorstVariants:
    """The worst variants with all that varied in them, and the first that cannot exist.

    `limit` is the one that decides, `UNEVALUATED_GRADE_CODE` where none has an answer.
    """

    max_count: int

    def shard_state(self, rows: EvaluatedVariants, start: int) -> StatisticState:
        """Return the worst of a shard."""
        a = rows.results
        refused, there = np.flatnonzero(a.infeasible)[:1], np.flatnonzero(~a.infeasible)
        decides = np.where(
            np.isnan(rows.margins), UNEVALUATED_GRADE_CODE, a.deciding_margins.argmin(axis=0)
        )
        return self._least(
            {
                "place": start + there,
                "margin": rows.margins[there],
                "verdict": rows.grades[there],
                "limit": decides[there],
                "inputs": rows.inputs[there],
                "refused": rows.inputs[refused],
                "why": np.array([a.why] if refused.size else [], dtype=str),
            }
        )

    def merge(self, one: StatisticState, other: StatisticState) -> StatisticState:
        """Return the worst of both."""
        found = {name: np.concatenate([one[name], other[name]]) for name in one}
        return self._least(found | {k: found[k][:1] for k in ("refused", "why")})

    def _least(self, state: StatisticState) -> StatisticState:
        order = np.lexsort((state["place"], state["margin"], -state["verdict"]))[: self.max_count]
        return {name: v if name in ("refused", "why") else v[order] for name, v in state.items()}


@dataclass(frozen=True)
class FirstVariantSamples:
    """The first variants with all that varied in them: any hundreds show how they lie."""

    max_count: int = 300

    def shard_state(self, rows: EvaluatedVariants, start: int) -> StatisticState:
        """Return those of a shard that are among the first."""
        few = slice(0, max(self.max_count - start, 0))
        refused = rows.results.infeasible
        return {
            "margin": np.where(refused, np.nan, rows.margins)[few],
            "verdict": np.where(refused, -1, rows.grades)[few],
            "inputs": rows.inputs[few],
        }

    def merge(self, one: StatisticState, other: StatisticState) -> StatisticState:
        """Return the first of both."""
        return {name: np.concatenate([one[name], other[name]])[: self.max_count] for name in one}


# --------------------------------------------------------------------------- tolerances


@dataclass(frozen=True, kw_only=True)
class ToleranceTightening:
    """How many would pass were one tolerance half as wide.

    The same variants, each counted as often as it would then occur. Columns are the whole
    and each limit by itself; rows are the tolerances.
    """

    sampling_plan: SamplingPlan
    yield_only: bool = False
    """Whether limits have no column: not every variant was evaluated for them."""

    def shard_state(self, rows: EvaluatedVariants, start: int) -> StatisticState:
        """Return the sums of a shard."""
        del start
        own = rows.independent
        limits = 0 if self.yield_only else len(rows.limits)
        weight = halved_tolerance_weights(self.sampling_plan, rows.unit_points[own])
        passes = np.concatenate(
            [
                (rows.grades <= WORST_ACCEPTABLE_VERDICT_INDEX)[None],
                rows.results.grades[:limits] != CHECK_GRADES.index("fail"),
            ]
        )[:, own].astype(float)
        square = weight**2
        return {
            "weight": weight.sum(0),
            "square": square.sum(0),
            "passes": (passes @ weight).T,
            "squares": (passes @ square).T,
        }

    def merge(self, one: StatisticState, other: StatisticState) -> StatisticState:
        """Return the sums."""
        return _added(one, other)


def halved_tolerance_weights(drawing: SamplingPlan, unit: FloatArray) -> FloatArray:
    """Return how often variants would occur, over now, with each tolerance halved, (V, T)."""
    from scipy.special import ndtr, ndtri

    own = [k for k, f in enumerate(drawing.factors) if f.tolerance]
    normal = drawing.standard_normal(unit)[:, own]
    tie = None
    if drawing.correlation_factor is not None:
        lower = np.asarray(drawing.correlation_factor)
        tie = np.linalg.inv(lower @ lower.T) - np.eye(len(own))
    found = np.empty(normal.shape)
    for t, k in enumerate(own):
        now, wide = normal.copy(), normal[:, t]
        if drawing.factors[k].spread.kind == "normal":
            now[:, t] = 2 * wide
            found[:, t] = 2 * np.exp((wide**2 - now[:, t] ** 2) / 2)
        else:
            place = 2 * ndtr(wide) - 0.5  # of what is left of the width, from 0 to 1
            inside = (place > 0) & (place < 1)
            now[:, t] = ndtri(np.where(inside, place, 0.5))
            found[:, t] = 2 * inside
        if tie is not None:
            found[:, t] *= np.exp(_form(normal, tie) - _form(now, tie))
    return found


def _form(normal: FloatArray, tie: FloatArray) -> FloatArray:
    return np.einsum("vi,ij,vj->v", normal, tie, normal) / 2


def halved_tolerance_yields(state: StatisticState) -> tuple[FloatArray, FloatArray]:
    """Return the share that may be built with each tolerance halved, and its standard error.

    (T, 1 + limits) each.
    """
    whole, square = state["weight"][:, None], state["square"][:, None]
    share = state["passes"] / whole
    spread = state["squares"] * (1 - 2 * share) + share**2 * square
    return share, np.sqrt(np.maximum(spread, 0.0)) / whole


# --------------------------------------------------------------------------- variance


@dataclass(frozen=True, kw_only=True)
class SobolSamplePairs:
    """Where variance comes from: base points, each with one factor after the other changed.

    Columns are the smallest margin, whether it may be built, and each limit's margin.
    """

    factors: int

    def shard_state(self, rows: EvaluatedVariants, start: int) -> StatisticState:
        """Return the sums of a shard, which holds whole groups."""
        del start
        d = self.factors
        y = np.concatenate(
            [
                rows.margins[None],
                (rows.grades <= WORST_ACCEPTABLE_VERDICT_INDEX)[None].astype(float),
                rows.results.margins,
            ]
        )
        y = y.reshape(len(y), -1, d + 2)
        one, other, changed = y[..., :1], y[..., 1:2], y[..., 2:]
        known = np.asarray(np.isfinite(y).all(axis=-1))
        own = np.where(known, y[..., 0], 0.0), np.where(known, y[..., 1], 0.0)
        first = np.where(known[..., None], other * (changed - one), 0.0)
        left = np.where(known[..., None], (changed - one), 0.0)
        total = np.where(known[..., None], (changed - one) ** 2 / 2, 0.0)
        return {
            "count": known.sum(-1),
            "sum": (own[0] + own[1]).sum(-1),
            "square": (own[0] ** 2 + own[1] ** 2).sum(-1),
            "first": first.sum(1),
            "first_square": (first**2).sum(1),
            "left": left.sum(1),
            "left_square": (left**2).sum(1),
            "first_left": (first * left).sum(1),
            "total": total.sum(1),
            "total_square": (total**2).sum(1),
        }

    def merge(self, one: StatisticState, other: StatisticState) -> StatisticState:
        """Return the sums."""
        return _added(one, other)


@dataclass(frozen=True, kw_only=True)
class SobolIndices:
    """Sobol indices, (columns, factors): shares of the variance, and their standard errors.

    `first` of a factor alone, `total` with all it does together with others; nan where
    nothing scatters.
    """

    first: FloatArray
    total: FloatArray
    first_error: FloatArray
    total_error: FloatArray


def sobol_indices(state: StatisticState) -> SobolIndices:
    """Return the Sobol indices of what pairs came to.

    Source: Saltelli et al., Comput. Phys. Commun. 181 (2010), eq. (b) of table 2 about the
    mean; Jansen (1999) for the total.
    """
    n = np.maximum(state["count"], 1)[:, None].astype(float)
    mean = state["sum"][:, None] / (2 * n)
    variance = state["square"][:, None] / (2 * n) - mean**2
    # Of (f_B - mean)(f_AB - f_A), from the sums of f_B (f_AB - f_A) and f_AB - f_A.
    first = (state["first"] - mean * state["left"]) / n
    squares = (
        state["first_square"] - 2 * mean * state["first_left"] + mean**2 * state["left_square"]
    ) / n
    total = state["total"] / n
    quiet = variance <= 1e-24 + 1e-14 * mean**2
    by = np.where(quiet, np.nan, variance)

    def error(square: FloatArray, value: FloatArray) -> FloatArray:
        return np.sqrt(np.maximum(square - value**2, 0.0) / n) / by

    return SobolIndices(
        first=first / by,
        total=total / by,
        first_error=error(squares, first),
        total_error=error(state["total_square"] / n, total),
    )


# --------------------------------------------------------------------------- what others learn from

MAX_TRAINING_VARIANTS = 16384
"""Variants that others are predicted from, at most."""


@dataclass(frozen=True)
class SurrogateTraining:
    """The first variants of a study, the training set of a surrogate.

    See `cardan.topics.variants.yield_surrogate`.

    What varied in each, by how much it stays off each limit's failure, and whether it may be built.
    """

    def shard_state(self, rows: EvaluatedVariants, start: int) -> StatisticState:
        """Return the variants of a shard."""
        return self._first(
            {
                "place": start + np.arange(rows.count),
                "inputs": rows.inputs,
                "left": rows.results.left.T,
                "fit": rows.grades <= WORST_ACCEPTABLE_VERDICT_INDEX,
            }
        )

    def merge(self, one: StatisticState, other: StatisticState) -> StatisticState:
        """Return the first of both."""
        return self._first({k: np.concatenate([one[k], other[k]]) for k in one})

    def _first(self, state: StatisticState) -> StatisticState:
        early = state["place"] < MAX_TRAINING_VARIANTS
        return {name: v[early] for name, v in state.items()}


# --------------------------------------------------------------------------- fronts


@dataclass(frozen=True, kw_only=True)
class ParetoFront:
    """Variants that no other beats in all goals: margin the larger, cost and mass the smaller.

    Where one may be built, those that may not are beaten. `costs` is what each input moves,
    None of one that no workshop moves.
    """

    goals: tuple[ParetoObjective, ...]
    costs: tuple[PermittedAdjustment | None, ...]
    sampling_plan: SamplingPlan

    def shard_state(self, rows: EvaluatedVariants, start: int) -> StatisticState:
        """Return the front of a shard."""
        found = self.goal_values(rows, start)
        known = np.isfinite(found).all(-1)
        return self._unbeaten(
            {
                "place": (start + np.arange(rows.count))[known],
                "goals": found[known],
                "inputs": rows.inputs[known],
                "verdict": rows.grades[known],
            }
        )

    def goal_values(self, rows: EvaluatedVariants, start: int) -> FloatArray:
        """Return what is weighed, (V, goals), the smaller the better."""
        goals = {
            "margin": -rows.margins,
            "cost": self._cost(
                self.sampling_plan.inputs_at(rows.unit_points, start, scattered=False)
            ),
            "mass": rows.results.mass,
        }
        return np.stack([goals[name] for name in self.goals], axis=-1)

    def merge(self, one: StatisticState, other: StatisticState) -> StatisticState:
        """Return the front of both."""
        return self._unbeaten({k: np.concatenate([one[k], other[k]]) for k in one})

    def _unbeaten(self, state: StatisticState) -> StatisticState:
        fit = state["verdict"] <= WORST_ACCEPTABLE_VERDICT_INDEX
        if fit.any():  # what may be built beats whatever may not: their margins are to other bounds
            state = {name: v[fit] for name, v in state.items()}
        goals = state["goals"]
        order = np.lexsort((state["place"], *goals.T[::-1]))
        kept: list[int] = []
        for k in order.tolist():  # what beats another stands before it
            front = goals[kept]
            if not (front <= goals[k]).all(-1).any():
                kept.append(k)
        return {name: v[kept] for name, v in state.items()}

    def _cost(self, inputs: FloatArray) -> FloatArray:
        """Return what moves cost (V,), as `fix` counts it; that they scatter costs nothing."""
        found = np.zeros(len(inputs))
        for adjustable, column in zip(self.costs, inputs.T, strict=True):
            if adjustable is not None:
                worth = ADJUSTMENTS[adjustable.adjustment_key].unit_value
                found += [
                    AppliedAdjustment(adjustable=adjustable, amount=worth * x).cost if x else 0.0
                    for x in column.tolist()
                ]
        return found


def adjustable_of_each_input(bench: VariantEvaluator) -> tuple[PermittedAdjustment | None, ...]:
    """Return what each input moves, over the range of the file, or by engineering judgement."""
    application = bench.application
    every = permitted_adjustments_by_name(i.line for i in application.lines)
    ranged = {(a.line, a.adjustment_key, a.part): a for a in application.adjustables}

    def of(name: str) -> PermittedAdjustment | None:
        if name not in every:
            return None
        a = every[name]
        return ranged.get((a.line, a.adjustment_key, a.part), a)

    return tuple(map(of, bench.sampling_plan.names))


# --------------------------------------------------------------------------- maps


@dataclass(frozen=True, kw_only=True)
class YieldMap:
    """The yield over two inputs, cell by cell.

    `edges` between the cells of each axis; what lies outside is in the outer ones. `choices`
    that cells are about, where there are several; else none.
    """

    pair: tuple[str, str]
    columns: tuple[int, int]
    edges: tuple[tuple[float, ...], tuple[float, ...]]
    choices: tuple[tuple[float, ...], tuple[float, ...]] = ((), ())

    @classmethod
    def for_pair(cls, pair: tuple[str, str], drawing: SamplingPlan) -> "YieldMap":
        """Return the map of a pair of names; of several parts the first."""
        columns = tuple(
            drawing.names.index(first_known_name_matching_pattern(n, drawing.names)) for n in pair
        )
        one, other = (_edges(drawing, k) for k in columns)
        chosen = [_chosen(drawing, k) for k in columns]
        return cls(
            pair=pair, columns=(columns[0], columns[1]), edges=(one, other),
            choices=(chosen[0], chosen[1]),
        )  # fmt: skip

    @property
    def cell_centres(self) -> tuple[tuple[float, ...], tuple[float, ...]]:
        """What stands for each cell: the choice in it, or its middle."""
        one, other = (
            chosen or tuple((low + high) / 2 for low, high in pairwise(edges))
            for chosen, edges in zip(self.choices, self.edges, strict=True)
        )
        return one, other

    @property
    def shape(self) -> tuple[int, int]:
        """How many cells there are across and up."""
        return len(self.edges[0]) - 1, len(self.edges[1]) - 1

    def shard_state(self, rows: EvaluatedVariants, start: int) -> StatisticState:
        """Return the cells of a shard."""
        del start
        own = rows.independent
        places = [
            np.searchsorted(edges[1:-1], rows.inputs[own, k], side="right")
            for k, edges in zip(self.columns, self.edges, strict=True)
        ]
        flat = places[0] * self.shape[1] + places[1]
        size = self.shape[0] * self.shape[1]
        margin = rows.margins[own]
        known = np.isfinite(margin)
        least = np.full(size, np.inf)
        np.minimum.at(least, flat[known], margin[known])

        def summed(values: FloatArray | BoolArray) -> FloatArray:
            return (
                np.bincount(flat, weights=values, minlength=size).reshape(self.shape).astype(float)
            )

        return {
            "count": summed(np.ones(len(flat))),
            "passes": summed(rows.grades[own] <= WORST_ACCEPTABLE_VERDICT_INDEX),
            "known": summed(known),
            "sum": summed(np.where(known, margin, 0.0)),
            "least": least.reshape(self.shape),
        }

    def merge(self, one: StatisticState, other: StatisticState) -> StatisticState:
        """Return the cells of both."""
        return _added(one, other) | {"least": np.minimum(one["least"], other["least"])}


def _chosen(drawing: SamplingPlan, k: int) -> tuple[float, ...]:
    """Return the choices of an input, in order; none where it has but one, or a range."""
    spread = next(f.spread for f in (*drawing.grids, *drawing.factors) if f.input == k)
    places = np.unique(spread.values) if spread.kind in ("grid", "choice") else np.empty(0)
    return tuple(places.tolist()) if len(places) > 1 else ()


def _edges(drawing: SamplingPlan, k: int) -> tuple[float, ...]:
    """Return the edges of cells along an input: about its choices, or over its range."""
    mine = [f.spread for f in (*drawing.grids, *drawing.factors) if f.input == k]
    first: VariedNumber = mine[0]
    if first.kind in ("grid", "choice"):
        places = np.unique(first.values)
        if len(places) == 1:  # it is chosen, so only what scatters about it has a width
            wide = max(
                ((3 if s.kind == "normal" else 1) * s.values[0] for s in mine[1:]), default=0.5
            )
            return tuple(
                np.linspace(
                    places[0] - wide, places[0] + wide, YIELD_MAP_CELLS_PER_AXIS + 1
                ).tolist()
            )
        between = (places[1:] + places[:-1]) / 2
        ends = 2 * places[0] - between[0], 2 * places[-1] - between[-1]
        return ends[0], *between.tolist(), ends[1]
    at, wide = drawing.nominal[k], first.values[0]
    low, high = {
        "range": first.values, "normal": (at - 3 * wide, at + 3 * wide),
        "uniform": (at - wide, at + wide),
    }[first.kind]  # fmt: skip
    return tuple(np.linspace(low, high, YIELD_MAP_CELLS_PER_AXIS + 1).tolist())
