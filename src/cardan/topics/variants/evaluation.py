"""Variants of an application: some numbers vary, and every limit is evaluated for all at once.

What varies is a number of the file by its address, or something that a workshop can move by
its key in the file's `adjust`. The driveline in its states answers, by the same code and with
the same margins as one application.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import fields, replace
from functools import cached_property
from typing import Any, TypeAlias

import numpy as np

from cardan.application.overrides import application_with_input_values, nominal_variable_values
from cardan.application.variant_sampling import (
    VARIANTS_PER_CHUNK,
    SamplingMethod,
    SamplingPlan,
    sampling_plan,
)
from cardan.approval.applied_adjustments import adjustment_affects_line, response_with_adjustments
from cardan.approval.approval import Approval, approve_driveline
from cardan.approval.driveline_study import EvaluatedLimit, evaluate_limits
from cardan.approval.study import DRIVELINE_STUDY_NAME
from cardan.checks.line_response import LineResponse, compute_line_response
from cardan.checks.quantities.registry import LINE_QUANTITIES
from cardan.core.arrays import BoolArray, FloatArray, IntArray
from cardan.core.errors import DesignError, FileIssue, InvalidFileError
from cardan.core.lazy_dataclass import dataclass
from cardan.core.status import ProgressCallback, ignore_status
from cardan.core.verdict import CHECK_GRADES, MARGIN_TOLERANCE, VERDICTS, Limit, Verdict
from cardan.model import variants as model
from cardan.model.adjustments import (
    ADJUSTMENTS,
    known_names_matching_pattern,
    permitted_adjustments_by_name,
)
from cardan.model.application import Application, PermittedAdjustment
from cardan.model.variants import (
    MAX_VARIANTS,
    VariantOutputs,
    VariantStudy,
)
from cardan.physics.vehicle.state_demand import line_state_demand, resolve_line_references

InputVariationSpec: TypeAlias = Sequence[float] | Mapping[str, Any] | model.VariedNumber
"""How a number varies: [low, high], or a table of one of `INPUT_DISTRIBUTION_KINDS`."""

INPUT_DISTRIBUTION_KINDS = ("choice", "grid", "normal", "uniform")
"""One of some values; each of them; about its own value by a standard deviation or half width."""

UNEVALUATED_GRADE_CODE = -1
"""In place of a grade: no state or part of a variant got an answer."""


@dataclass(frozen=True, kw_only=True)
class InputColumn:
    """A number in each variant, (V,), in the unit its name ends in."""

    name: str
    values: FloatArray


@dataclass(frozen=True, kw_only=True)
class LimitColumn:
    """What one limit came to in each variant, where it is worst.

    Attributes
    ----------
    line, limit
        The limit, and the line that it applies to.
    values, margins : (V,) SI, 1
        Of the state and part that is worst; nan where nothing answered.
    grades : (V,)
        Places in `CHECK_GRADES`, `UNEVALUATED_GRADE_CODE` where nothing answered.
    missed : (V,)
        Whether something that the limit requires was not evaluated.
    """

    line: str
    limit: Limit
    values: FloatArray
    margins: FloatArray
    grades: IntArray
    missed: BoolArray


LIMIT_ARRAYS = ("values", "margins", "left", "grades", "missed", "bounded", "unproved")
"""Fields of `LimitResults` that have limits and variants, (L, V)."""


@dataclass(frozen=True, kw_only=True)
class LimitResults:
    """What L limits come to in V variants, each where it is worst.

    Attributes
    ----------
    values, margins : (L, V) SI, 1
    left : (L, V) 1
        Margin to the maximum, whatever grade it comes to; nan where there is none.
    grades : (L, V)
    missed : (L, V)
    bounded : (L, V)
        Whether the worst value is a lower bound: rubber is at its stop in some state, or a spline
        may stick there that is not solved.
    unproved : (L, V)
        Whether it may be exceeded with the spline stuck.
    mass : (V,) kg
        Of all shafts; nan where one has no tube.
    infeasible : (V,)
        Whether the driveline cannot exist so.
    stopped : (V,)
        Whether it failed a cheap limit and was evaluated no further (`yield_only`).
    why : str
        What the first of those refused says.
    """

    values: FloatArray
    margins: FloatArray
    left: FloatArray
    grades: IntArray
    missed: BoolArray
    bounded: BoolArray
    unproved: BoolArray
    mass: FloatArray
    infeasible: BoolArray
    stopped: BoolArray
    why: str = ""

    @property
    def deciding_margins(self) -> FloatArray:
        """The margins (L, V) of the worst grade a variant comes to; infinite for others."""
        known = ~np.isnan(self.margins)
        grades = np.where(known, self.grades, -1)
        return np.where(known & (grades == grades.max(axis=0)), self.margins, np.inf)

    @classmethod
    def without_answers(cls, limits: int, count: int) -> "LimitResults":
        """Return what `count` variants come to of which nothing is known."""
        shape = (limits, count)
        return cls(
            values=np.full(shape, np.nan),
            margins=np.full(shape, np.nan),
            left=np.full(shape, np.nan),
            grades=np.full(shape, UNEVALUATED_GRADE_CODE),
            missed=np.zeros(shape, dtype=bool),
            bounded=np.zeros(shape, dtype=bool),
            unproved=np.zeros(shape, dtype=bool),
            mass=np.full(count, np.nan),
            infeasible=np.zeros(count, dtype=bool),
            stopped=np.zeros(count, dtype=bool),
        )

    @classmethod
    def concatenate(cls, parts: Sequence["LimitResults"]) -> "LimitResults":
        """Return several one after the other."""
        return cls(
            **{
                f.name: np.concatenate([getattr(p, f.name) for p in parts], axis=-1)
                for f in fields(cls)
                if f.name != "why"
            },
            why=next((p.why for p in parts if p.why), ""),
        )


@dataclass(frozen=True, kw_only=True)
class EvaluatedVariants:
    """What variants of an application come to.

    `installed` is the approval of the application as it stands; what its limits miss of
    studies other than the driveline's, every variant misses too.

    Attributes
    ----------
    names, inputs : (V, names)
        What varies, in the unit its name ends in.
    limits
        Each limit, and the line that it applies to.
    results
        What each came to.
    independent : (V,)
        Which variants are drawn by themselves: shares count those.
    unit_points : (V, factors)
        The points of the unit cube they were made of.
    """

    installed: Approval
    names: tuple[str, ...]
    inputs: FloatArray
    limits: tuple[tuple[str, Limit], ...]
    results: LimitResults
    independent: BoolArray
    unit_points: FloatArray
    limits_restricted: bool = False
    """Whether some limits alone were evaluated: others then leave nothing incomplete."""

    @property
    def count(self) -> int:
        """How many variants there are."""
        return len(self.inputs)

    @property
    def input_columns(self) -> tuple[InputColumn, ...]:
        """Each number that varies."""
        return tuple(
            InputColumn(name=n, values=v) for n, v in zip(self.names, self.inputs.T, strict=True)
        )

    @property
    def limit_columns(self) -> tuple[LimitColumn, ...]:
        """What each limit came to."""
        a = self.results
        return tuple(
            LimitColumn(
                line=line, limit=limit, values=a.values[k], margins=a.margins[k],
                grades=a.grades[k], missed=a.missed[k],
            )
            for k, (line, limit) in enumerate(self.limits)
        )  # fmt: skip

    @cached_property
    def grades(self) -> IntArray:
        """What each variant comes to, (V,) places in `VERDICTS`, as an approval has it.

        Incomplete where nothing fails and a value is a lower bound, of which an approval warns.
        """
        elsewhere = not self.limits_restricted and is_required_limit_of_other_study_missing(
            self.installed
        )
        return variant_verdicts(self.results, elsewhere=elsewhere)

    @property
    def verdicts(self) -> tuple[Verdict, ...]:
        """What each variant comes to."""
        return tuple(VERDICTS[g] for g in self.grades.tolist())

    @cached_property
    def shown_by_bounds_alone(self) -> BoolArray:
        """Which variants do not fail, and have a value (V,) that is a lower bound."""
        return (self.grades != VERDICTS.index("fail")) & self.results.bounded.any(axis=0)

    @cached_property
    def margins(self) -> FloatArray:
        """The smallest margin of each variant (V,), as an approval has it; nan without any."""
        smallest = self.results.deciding_margins.min(axis=0, initial=np.inf)
        return np.where(np.isinf(smallest), np.nan, smallest)

    @property
    def shares(self) -> dict[Verdict, float]:
        """The share of variants that comes to each verdict."""
        of = self.grades[self.independent]
        counts = np.bincount(of, minlength=len(VERDICTS)) / of.size
        return dict(zip(VERDICTS, counts.tolist(), strict=True))

    @property
    def yield_(self) -> float:
        """The share of variants that may be built: they pass or only warn."""
        return self.shares["pass"] + self.shares["warn"]

    def named_limit_columns(self) -> Iterator[tuple[str, LimitColumn]]:
        """Yield each limit with a name of its own: its quantity, line and place among several."""
        yield from zip(limit_names(self.limits), self.limit_columns, strict=True)


def limit_names(limits: Sequence[tuple[str, Limit]]) -> tuple[str, ...]:
    """Return names of limits that distinguish them: quantity, line, place among several."""
    several = len({line for line, _ in limits}) > 1
    names = [f"{line}.{m.quantity}" if several else m.quantity for line, m in limits]
    return tuple(
        f"{name}[{names[: k + 1].count(name)}]" if names.count(name) > 1 else name
        for k, name in enumerate(names)
    )


def is_required_limit_of_other_study_missing(installed: Approval) -> bool:
    """Return whether a limit of another study is required and not evaluated."""
    found = (f for f in installed.study_results if f.study != DRIVELINE_STUDY_NAME)
    return any(u.limit.required for f in found for u in f.unevaluated)


def variant_verdicts(of: LimitResults, *, elsewhere: bool) -> IntArray:
    """Return what variants come to, (V,) places in `VERDICTS`; what cannot exist fails.

    A lower bound within its limit shows nothing: that limit counts as not evaluated.
    """
    places = np.array([VERDICTS.index(g) for g in CHECK_GRADES])
    known = np.where(of.grades == UNEVALUATED_GRADE_CODE, VERDICTS.index("pass"), places[of.grades])
    worst = known.max(axis=0, initial=0)
    missed = (of.missed | of.bounded).any(axis=0) | elsewhere
    missed = missed | (of.grades == UNEVALUATED_GRADE_CODE).all(axis=0)
    worst = np.where(missed, np.maximum(worst, VERDICTS.index("incomplete")), worst)
    return np.where(of.infeasible, VERDICTS.index("fail"), worst)


def evaluate_variants(
    application: Application,
    vary: Mapping[str, InputVariationSpec],
    *,
    tolerances: Mapping[str, InputVariationSpec] | None = None,
    count: int = 10_000,
    seed: int = 0,
    tell: ProgressCallback = ignore_status,
) -> EvaluatedVariants:
    """Return what variants of an application come to, each of them kept.

    Parameters
    ----------
    application
        As read from a file.
    vary
        By the address of a number (`driveline.shafts[2].tube.wall_mm`) or the key of a thing
        that can be moved (`bearing_height_mm[1]`, `shim_deg`, `phase_deg[2]`; with several
        lines `front.shim_deg`): `[low, high]`, `{"choice": [...]}`, `{"grid": [low, high,
        how many]}`, `{"normal": sigma}` or `{"uniform": half}`, in the unit of the key. The
        last two go about the number as it is; moves count from where a part is installed.
        `[*]` stands for every part, each with its own value.
    tolerances
        What scatters about that, `{"normal": sigma}` or `{"uniform": half}`.
    count
        How many variants. Without tolerances a power of 2 spreads most evenly.
    seed
        Of the points.
    tell
        Receives the progress.

    Raises
    ------
    ValueError
        If nothing goes by a name, or cannot vary as requested.

    Notes
    -----
    Sobol points, scrambled after Owen, without tolerances; else by Monte Carlo. Source: Sobol
    (1967); Owen (1998). What cannot exist in a variant, a file with such a number or a chain
    that locks, makes that variant fail, and is reported in `answers`.
    """
    bench = VariantEvaluator.from_application(
        application, build_variants(vary, tolerances), seed=seed
    )
    return bench.evaluate_range(0, bench.whole_count(count), tell=tell)


def build_variants(
    vary: Mapping[str, InputVariationSpec] | None = None,
    tolerances: Mapping[str, InputVariationSpec] | None = None,
    *,
    ask: VariantOutputs | None = None,
) -> VariantStudy:
    """Return a study as a file would say it.

    Raises
    ------
    ValueError
        If something cannot vary as requested.
    """
    return VariantStudy(
        vary={name: _spread(name, s) for name, s in (vary or {}).items()},
        tolerances={name: _spread(name, s) for name, s in (tolerances or {}).items()},
        ask=ask or VariantOutputs(),
    )


def _spread(name: str, spread: InputVariationSpec) -> model.VariedNumber:
    if isinstance(spread, model.VariedNumber):
        return spread
    if isinstance(spread, Mapping):
        kind, *others = spread or {"": None}
        if kind not in INPUT_DISTRIBUTION_KINDS or others:
            msg = (
                f"{name} varies by one of {', '.join(INPUT_DISTRIBUTION_KINDS)}, got {dict(spread)}"
            )
            raise ValueError(msg)
        amount = np.asarray(spread[kind], dtype=float)
        if kind == "choice" and amount.ndim == 1 and amount.size:
            return model.VariedNumber(kind=kind, values=tuple(amount.tolist()))
        if kind == "grid" and amount.shape == (3,) and amount[0] < amount[1] and amount[2] >= 2:
            places = np.linspace(amount[0], amount[1], int(amount[2]))
            return model.VariedNumber(kind=kind, values=tuple(places.tolist()))
        if kind in ("normal", "uniform") and amount.ndim == 0 and amount > 0:
            return model.VariedNumber(kind=kind, values=(float(amount),))
        needs = {"choice": "values", "grid": "[low, high, how many]"}
        msg = f"{name}: {kind} needs {needs.get(kind, 'a number above 0')}"
        raise ValueError(msg)
    ends = np.asarray(spread, dtype=float)
    if ends.shape != (2,) or not ends[0] < ends[1]:
        msg = f"{name} varies over [low, high], got {spread}"
        raise ValueError(msg)
    return model.VariedNumber(kind="range", values=tuple(ends.tolist()))


# --------------------------------------------------------------------------- evaluating


@dataclass(frozen=True, kw_only=True)
class VariantEvaluator:
    """An application with where its variants lie: any stretch of them can be evaluated.

    Attributes
    ----------
    installed
        The approval of the application as it stands.
    sampling_plan
        Where the variants lie.
    unvectorised_inputs
        Numbers that the arrays cannot hold: with these a file is read for each variant.
    """

    installed: Approval
    sampling_plan: SamplingPlan
    unvectorised_inputs: tuple[str, ...] = ()
    quantities: tuple[str, ...] = ()
    """Whose limits count; all where none is named."""
    yield_only: bool = False
    """Whether what fails a limit without rubber is not evaluated on rubber."""

    @classmethod
    def from_application(
        cls,
        application: Application,
        variants: VariantStudy,
        *,
        seed: int = 0,
        points: SamplingMethod | None = None,
    ) -> "VariantEvaluator":
        """Return the bench of a study.

        Raises
        ------
        ValueError
            If nothing goes by a name.
        InvalidFileError
            If a number cannot be what it may become at the ends of its range.
        """
        known = nominal_variable_values(application)
        drawn = sampling_plan(variants, known, seed=seed, points=points)
        bench = cls(
            installed=approve_driveline(application),
            sampling_plan=drawn,
            quantities=variants.ask.limits,
            yield_only=variants.ask.yield_only,
        )
        if not bench.limits:
            msg = f"`ask`: no limit is on {', '.join(variants.ask.limits) or 'this line'}"
            raise ValueError(msg)
        for k, name in enumerate(drawn.names):
            for end in _ends(drawn, k) if name not in bench._moves else ():
                try:
                    application_with_input_values(application, {name: end})
                except InvalidFileError as error:
                    raise _beyond(variants, name, end, error) from error
        single = tuple(n for n in drawn.names if n not in bench._moves and not bench._holds(n))
        return replace(bench, unvectorised_inputs=single)

    @property
    def application(self) -> Application:
        """The application as it stands."""
        return self.installed.application

    def whole_count(self, count: int) -> int:
        """Return how many variants there are if so many are requested: whole grids.

        One grid where nothing is drawn: a second would be the same.
        """
        if not 1 <= count <= MAX_VARIANTS:
            msg = f"a study has from 1 to {MAX_VARIANTS} variants (--n), got {count}"
            raise ValueError(msg)
        period = self.sampling_plan.group_size
        return -(-count // period) * period if self.sampling_plan.factors else period

    @cached_property
    def limits(self) -> tuple[tuple[str, Limit], ...]:
        """Each limit with the line that it applies to."""
        return tuple(
            (r.line.name, limit)
            for r in self.installed.line_responses
            for limit in dict.fromkeys(q.limit for q in self._questions(r))
        )

    @cached_property
    def _places(self) -> dict[str, tuple[int, ...]]:
        """By line, which of its limits each question is about: a bound that varies is the same."""
        found: dict[str, tuple[int, ...]] = {}
        for r in self.installed.line_responses:
            each = [q.limit for q in self._questions(r)]
            found[r.line.name] = tuple(map(list(dict.fromkeys(each)).index, each))
        return found

    @cached_property
    def chunk_size(self) -> int:
        """Variants at a time: twice `VARIANTS_PER_CHUNK` if no limit concerns rubber."""
        rubber = any(LINE_QUANTITIES[limit.quantity].depends_on_mounts for _, limit in self.limits)
        return VARIANTS_PER_CHUNK if rubber else 2 * VARIANTS_PER_CHUNK

    def _questions(self, response: LineResponse) -> tuple[EvaluatedLimit, ...]:
        """Return what is evaluated of a line."""
        among = self.quantities or LINE_QUANTITIES
        return tuple(q for q in evaluate_limits(response, quantities=among) if q.parts)

    def evaluate_range(
        self,
        start: int,
        stop: int,
        *,
        tell: ProgressCallback = ignore_status,
        go_on: Callable[[], bool] = lambda: True,
    ) -> EvaluatedVariants:
        """Return variants from a place to another, each of them kept.

        `go_on` is called between chunks; if it returns False a `KeyboardInterrupt` is raised.
        """
        unit = self.sampling_plan.unit_points(start, stop)
        inputs = self.sampling_plan.inputs_at(unit, start)

        def in_chunks(of: VariantEvaluator, rows: IntArray) -> LimitResults:
            parts: list[LimitResults] = []
            for first in range(0, len(rows), of.chunk_size):
                if not go_on():
                    raise KeyboardInterrupt
                tell("sweep", first, len(rows))
                parts.append(of.evaluate(inputs[rows[first : first + of.chunk_size]]))
            return LimitResults.concatenate(parts)

        found = (
            self._until_failed(len(inputs), in_chunks)
            if self.yield_only
            else in_chunks(self, np.arange(len(inputs)))
        )
        return self.collect(inputs, found, unit, self.sampling_plan.independent(start, stop))

    @cached_property
    def stages(self) -> "tuple[VariantEvaluator, ...]":
        """Evaluators of the limits without rubber, and of those on it, which cost far more."""
        every = dict.fromkeys(limit.quantity for _, limit in self.limits)
        each = (
            tuple(k for k in every if LINE_QUANTITIES[k].depends_on_mounts == on_rubber)
            for on_rubber in (False, True)
        )
        return tuple(replace(self, quantities=some, yield_only=False) for some in each if some)

    def _until_failed(
        self, count: int, evaluate: "Callable[[VariantEvaluator, IntArray], LimitResults]"
    ) -> LimitResults:
        """Return what limits come to, stage by stage, of what has not failed yet.

        Limits that were not evaluated for a variant hold no grade, and count as no miss.
        """
        found = LimitResults.without_answers(len(self.limits), count)
        rows = np.arange(count)
        for stage in self.stages:
            part = evaluate(stage, rows)
            at = np.array([self.limits.index(one) for one in stage.limits])[:, None], rows
            for name in LIMIT_ARRAYS:
                getattr(found, name)[at] = getattr(part, name)
            found.mass[rows], found.infeasible[rows] = part.mass, part.infeasible
            found = replace(found, why=found.why or part.why)
            failed = (part.grades == CHECK_GRADES.index("fail")).any(axis=0)
            found.stopped[rows[failed & (stage is not self.stages[-1])]] = True
            rows = rows[~(failed | part.infeasible)]
            if not rows.size:
                break
        return found

    def collect(
        self, inputs: FloatArray, answers: LimitResults, unit: FloatArray, own: BoolArray
    ) -> EvaluatedVariants:
        """Return variants with what they came to."""
        return EvaluatedVariants(
            installed=self.installed,
            names=self.sampling_plan.names,
            inputs=inputs,
            limits=self.limits,
            results=answers,
            independent=own,
            unit_points=unit,
            limits_restricted=bool(self.quantities),
        )

    def evaluate(self, inputs: FloatArray) -> LimitResults:
        """Return what limits come to where the inputs (V, names) are these."""
        try:
            if self.unvectorised_inputs and len(inputs) > 1:
                return LimitResults.concatenate([self.evaluate(row[None]) for row in inputs])
            return self._with_stuck_splines(inputs, self._asked(inputs))
        except (InvalidFileError, DesignError) as error:
            if len(inputs) == 1:
                return self._refused(str(error))
            middle = len(inputs) // 2
            return LimitResults.concatenate(
                [self.evaluate(inputs[:middle]), self.evaluate(inputs[middle:])]
            )

    def _with_stuck_splines(self, inputs: FloatArray, found: LimitResults) -> LimitResults:
        """Return results in which no limit counts as passed that a stuck spline may exceed.

        Variants that nothing else keeps from passing are solved by themselves. Others fail
        anyway, or remain lower bounds.
        """
        fails = (found.grades == CHECK_GRADES.index("fail")).any(axis=0)
        alone = found.unproved.any(axis=0) & ~fails & ~found.bounded.any(axis=0)
        asked = dict.fromkeys(
            self.limits[k][1].quantity for k in np.flatnonzero(found.unproved[:, alone].any(axis=1))
        )
        one = replace(self, quantities=tuple(asked), yield_only=False) if asked else self
        at = [self.limits.index(limit) for limit in one.limits]
        for v in np.flatnonzero(alone).tolist():
            own = one._asked(inputs[v : v + 1], alone=True)
            for name in LIMIT_ARRAYS:
                getattr(found, name)[at, v] = getattr(own, name)[:, 0]
        passes = found.unproved & (found.grades == CHECK_GRADES.index("pass"))
        return replace(
            found,
            grades=np.where(passes, CHECK_GRADES.index("warn"), found.grades),
            bounded=found.bounded | found.unproved,
        )

    def _asked(self, inputs: FloatArray, *, alone: bool = False) -> LimitResults:
        """Return what limits come to; all variants must be able to exist.

        Of one variant `alone`, without an axis of variants, the spline that sticks is solved.
        """
        count, moves = len(inputs), self._moves
        one = alone or bool(self.unvectorised_inputs)
        numbers: dict[str, Any] = {
            name: float(column[0]) if one else column
            for name, column in zip(self.sampling_plan.names, inputs.T, strict=True)
            if name not in moves
        }
        found: list[LimitResults] = []
        for response in self._responses(numbers):
            mine = [k for k, n in enumerate(self.sampling_plan.names) if n in moves
                    and adjustment_affects_line(response, moves[n])]  # fmt: skip
            if mine:
                parts = tuple(moves[self.sampling_plan.names[k]] for k in mine)
                worth = np.array([ADJUSTMENTS[p.adjustment_key].unit_value for p in parts])
                amounts = inputs[:, mine] * worth
                response = response_with_adjustments(
                    response, parts, amounts[0] if alone else amounts, shared=True
                )
            places = self._places[response.line.name]
            found.append(_answers(response, self._questions(response), places, count))
        return replace(
            found[0],
            **{
                f.name: np.concatenate([getattr(a, f.name) for a in found])
                for f in fields(LimitResults)
                if f.name in LIMIT_ARRAYS
            },
            mass=sum((a.mass for a in found), np.zeros(count)),
        )

    def _responses(self, numbers: Mapping[str, Any]) -> tuple[LineResponse, ...]:
        """Return what each line does with other numbers; without any, what it does already."""
        if not numbers:
            return self.installed.line_responses
        changed = application_with_input_values(self.application, numbers)
        return tuple(
            compute_line_response(
                changed, line_state_demand(resolve_line_references(changed, line))
            )
            for line in changed.lines
        )

    def _refused(self, why: str) -> LimitResults:
        """Return what a variant comes to that cannot exist."""
        nothing = LimitResults.without_answers(len(self.limits), 1)
        return replace(nothing, infeasible=np.array([True]), why=why)

    @cached_property
    def _moves(self) -> dict[str, PermittedAdjustment]:
        every = permitted_adjustments_by_name(i.line for i in self.application.lines)
        return {n: every[n] for n in self.sampling_plan.names if n in every}

    def _holds(self, name: str) -> bool:
        """Return whether the arrays can hold variants of a number."""
        at = self.sampling_plan.nominal[self.sampling_plan.names.index(name)]
        try:
            changed = application_with_input_values(self.application, {name: np.array([at, at])})
            for line in changed.lines:
                self._questions(
                    compute_line_response(
                        changed, line_state_demand(resolve_line_references(changed, line))
                    )
                )
        except (InvalidFileError, DesignError):
            return False
        return True


def _beyond(of: VariantStudy, name: str, end: float, error: InvalidFileError) -> InvalidFileError:
    """Return the error of a number at an end of what it varies over, where the study says so."""
    first = error.problems[0]
    why = first.message if first.key == name else f"{first.key}: {first.message}"
    written = next((w for w in of.places if name in known_names_matching_pattern(w, [name])), "")
    line, column = of.places.get(written, (0, 0))
    told = f"cannot be {end:g}, up to where the study has it vary: {why}"
    problem = FileIssue(message=told, key=f"vary.{name}", line=line, column=column)
    return InvalidFileError(of.file or error.file, (problem,))


def _ends(of: SamplingPlan, k: int) -> tuple[float, ...]:
    """Return the ends of what an input is chosen from; nan for what scatters."""
    decided = [f.spread for f in (*of.factors, *of.grids) if f.input == k and not f.tolerance]
    return tuple(
        end
        for s in decided
        for end in (
            (min(s.values), max(s.values))
            if s.kind in ("range", "grid", "choice")
            else (of.nominal[k] - s.values[0], of.nominal[k] + s.values[0])
            if s.kind == "uniform"
            else ()
        )
    )


def _answers(
    response: LineResponse, questions: Sequence[EvaluatedLimit], places: Sequence[int], count: int
) -> LimitResults:
    """Return what each limit of a line comes to; the same of several parts is one."""
    # What nothing varied changes has no axis of variants: evaluated once, for all of them.
    every: dict[int, list[EvaluatedLimit]] = {}
    for place, question in zip(places, questions, strict=True):
        every.setdefault(place, []).append(question)
    shape = (len(every), count)
    values, margins, left = (np.empty(shape) for _ in range(3))
    grades = np.empty(shape, dtype=int)
    missed, bounded, unproved = (np.empty(shape, dtype=bool) for _ in range(3))
    for k, alike in every.items():
        found, asks = (_side_by_side([getattr(q, n) for q in alike]) for n in ("values", "asks"))
        known = ~np.isnan(found)
        grades_of, free = map(
            _side_by_side,
            zip(
                *(
                    q.limit.grades_and_margins(q.values, validity_margin=q.validity_margin)
                    for q in alike
                ),
                strict=True,
            ),
        )
        graded = np.where(known, grades_of, UNEVALUATED_GRADE_CODE)
        worst = graded.max(axis=-1, initial=UNEVALUATED_GRADE_CODE)
        among = known & (graded == worst[:, None])
        at = np.where(among, free, np.inf).argmin(axis=-1)[:, None]
        values[k] = np.take_along_axis(found, at, axis=-1)[:, 0]
        margins[k] = np.take_along_axis(free, at, axis=-1)[:, 0]
        last = _side_by_side([_to_failure(q) for q in alike])
        least = np.where(np.isnan(last), np.inf, last).min(axis=-1)
        left[k] = np.where(np.isinf(least), np.nan, least)
        grades[k] = worst
        missed[k] = alike[0].limit.required & (asks & ~known).any(axis=-1)
        beyond = _side_by_side([q.validity_margin for q in alike]) < -MARGIN_TOLERANCE
        bounded[k] = (known & beyond).any(axis=-1)
        unproved[k] = (_side_by_side([q.unproved_margin for q in alike]) < 0).any(axis=-1)
    mass = sum((np.asarray(s.mass, dtype=float) for s in response.line.shafts), np.zeros(()))
    return LimitResults(
        values=values,
        margins=margins,
        left=left,
        grades=grades,
        missed=missed,
        bounded=bounded,
        unproved=unproved,
        mass=np.broadcast_to(mass.reshape(-1) if mass.ndim else mass, count).copy(),
        infeasible=np.zeros(count, dtype=bool),
        stopped=np.zeros(count, dtype=bool),
    )


def _to_failure(of: EvaluatedLimit) -> FloatArray:
    """Return the margin to the maximum of each state and part; nan where there is none."""
    if of.limit.maximum is None:
        return np.full_like(of.values, np.nan)
    return of.limit.margin(of.values, to="maximum")


def _side_by_side(of: Sequence[Any]) -> Any:
    """Return arrays (..., states, parts) of V variants, or of none, as (V, all together)."""
    flat = [v.reshape(-1, v.shape[-2] * v.shape[-1]) for v in of]
    rows = max(len(v) for v in flat)
    return np.concatenate([np.broadcast_to(v, (rows, v.shape[1])) for v in flat], axis=1)
