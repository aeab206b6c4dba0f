"""What of a correction survives in trucks as they are built: settings and parts scatter.

A truck keeps what a setting promises where nothing fails in it that does not fail at the
setting itself.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import cached_property
from typing import Any

import numpy as np

from cardan.application.overrides import application_with_input_values, nominal_variable_values
from cardan.application.variant_sampling import VARIANTS_PER_CHUNK, SamplingPlan, sampling_plan
from cardan.approval.applied_adjustments import (
    ADJUSTMENTS_OF_LINE_WITHOUT_LENGTHS,
    affected_lines,
    response_with_adjustments,
)
from cardan.approval.margins import (
    MARGIN_CAP,
    LimitBoundName,
    limit_of_each_margin,
    margins_to_both_bounds,
)
from cardan.checks.line_response import LineResponse, compute_line_response
from cardan.core.arrays import BoolArray, FloatArray
from cardan.core.errors import DesignError, InvalidFileError
from cardan.core.lazy_dataclass import dataclass
from cardan.core.verdict import MARGIN_TOLERANCE, Limit
from cardan.model.adjustments import ADJUSTMENTS, permitted_adjustments_by_name
from cardan.model.application import Application, PermittedAdjustment
from cardan.model.variants import VariantStudy, VariedNumber
from cardan.physics.vehicle.state_demand import line_state_demand, resolve_line_references

ASSUMED_TOLERANCES = {
    "bearing_height_mm": 3.0,
    "bearing_side_mm": 3.0,
    "shim_deg": 0.5,
    "phase_deg": 2.0,
}
"""How far settings are off at three standard deviations where no file says. Engineering judgement,
assumed."""

SAMPLE_COUNT = 4096
"""Trucks that a share is of: it is off by 0.8 % at most, at one standard error."""

FINITE_DIFFERENCE_STEP_SD = 1.5
"""Standard deviations (of a uniform one, quarters of its half width, times 2) to each side at
which margins are evaluated: between them and a little beyond they go like parabolas."""


PRODUCTION_YIELD_CLASS_COUNT = 20
"""Settings that as many trucks survive, to a twentieth, are ranked by what they cost."""


@dataclass(frozen=True, kw_only=True)
class ToleranceYield:
    """How many trucks keep what a setting promises.

    Attributes
    ----------
    share : 1
        Of all trucks: what nothing fails in that does not fail at the setting.
    share_without_warnings : 1
        Of all trucks: what nothing warns in either that does not at the setting.
    individually_evaluated
        Whether every truck was evaluated; otherwise their margins follow from slopes and bends
        at the setting.
    best_tightening
        The tolerance that wins most, the share with it half as wide; None where none does.
    most_failed_quantity
        The quantity whose limit fails most often; "" where none does.
    """

    share: float
    share_without_warnings: float
    individually_evaluated: bool
    best_tightening: tuple[str, float] | None = None
    most_failed_quantity: str = ""

    @property
    def yield_class(self) -> int:
        """Which class of settings it is in: those that as many trucks keep, to a twentieth."""
        return min(
            int(self.share * PRODUCTION_YIELD_CLASS_COUNT + 1e-9), PRODUCTION_YIELD_CLASS_COUNT - 1
        )


@dataclass(frozen=True, kw_only=True)
class ToleranceModel:
    """How trucks of an application scatter about a setting of one of its lines.

    `assumed` is whether it is not given.
    """

    application: Application
    line: str
    sampling_plan: SamplingPlan
    assumed: bool

    @classmethod
    def from_application(cls, application: Application, line: str) -> "ToleranceModel | None":
        """Return how the trucks scatter: as the file's study says, or as assumed.

        None where nothing does that would move this line.
        """
        said = application.variants.tolerances if application.variants else {}
        own = _own(application, line, said)
        spread = own or dict(_assumed(application, line))
        if not spread:
            return None
        correlated = application.variants.correlated if own and application.variants else ()
        known = nominal_variable_values(application) if own else dict.fromkeys(spread, 0.0)
        return cls(
            application=application,
            line=line,
            sampling_plan=sampling_plan(
                VariantStudy(tolerances=spread, correlated=correlated),
                known,
                seed=1,
                points="random",
            ),
            assumed=not own,
        )

    @property
    def only_adjustments_vary(self) -> bool:
        """Whether all that scatters are things a workshop moves, and no number of the file."""
        every = permitted_adjustments_by_name(i.line for i in self.application.lines)
        return all(name in every for name, _ in self.tolerances)

    @property
    def tolerances(self) -> tuple[tuple[str, VariedNumber], ...]:
        """What scatters, and how."""
        return tuple((self.sampling_plan.name_of(f), f.spread) for f in self.sampling_plan.factors)

    def responses(
        self, ways: tuple[PermittedAdjustment, ...], amounts: FloatArray, off: FloatArray
    ) -> tuple[LineResponse, ...]:
        """Return the line at a setting in trucks that are `off` (V, tolerances), or in one (T,).

        Amounts are (ways), or those of each truck (V, ways). And the lines that they turn with it.
        """
        rows = np.atleast_2d(off)
        every = permitted_adjustments_by_name(i.line for i in self.application.lines)
        called = self.sampling_plan.names
        alone = rows[0] if len(rows) == 1 else rows.T  # numbers that arrays cannot hold, alone
        numbers: dict[str, Any] = {
            n: self.sampling_plan.nominal[k] + alone[k]
            for k, n in enumerate(called)
            if n not in every
        }
        changed = application_with_input_values(self.application, numbers)
        installed = next(i for i in changed.lines if i.line.name == self.line)
        moves = [k for k, n in enumerate(called) if n in every]
        parts = (*ways, *(every[called[k]] for k in moves))
        worth = np.array([ADJUSTMENTS[every[called[k]].adjustment_key].unit_value for k in moves])
        set_ = np.broadcast_to(amounts, (len(rows), len(ways)))
        merged, sums = _merged(parts, np.concatenate([set_, rows[:, moves] * worth], axis=1))
        sums = sums if off.ndim > 1 else sums[0]
        lines = affected_lines(
            compute_line_response(
                changed, line_state_demand(resolve_line_references(changed, installed))
            ),
            ways,
        )
        return tuple(response_with_adjustments(line, merged, sums) for line in lines)

    def margins(
        self, ways: tuple[PermittedAdjustment, ...], amounts: FloatArray, off: FloatArray
    ) -> dict[LimitBoundName, FloatArray]:
        """Return the margins (V, M) to either bound of trucks (V, tolerances) at a setting.

        One by one where arrays cannot hold what scatters, as a joint's rating. A truck that
        cannot exist has none. Rubber meets no stop in them, and splines slide.
        """
        try:
            found = margins_to_both_bounds(*self.responses(ways, amounts, off))
        except (InvalidFileError, DesignError):
            if len(off) == 1:
                raise
        else:
            return {to: np.broadcast_to(m, (len(off), m.shape[-1])) for to, m in found.items()}
        lost: dict[LimitBoundName, FloatArray] = {
            to: np.full_like(m, -MARGIN_CAP)
            for to, m in self.margins(ways, amounts, np.zeros_like(off[:1])).items()
        }
        some: list[dict[LimitBoundName, FloatArray]] = []
        for row in off:
            try:
                some.append(self.margins(ways, amounts, row[None]))
            except (InvalidFileError, DesignError):
                some.append(lost)
        return {to: np.concatenate([m[to] for m in some]) for to in lost}

    def survival(
        self,
        ways: tuple[PermittedAdjustment, ...],
        amounts: FloatArray,
        *,
        asked: int = 0,
        solved: Mapping[LimitBoundName, FloatArray] | None = None,
    ) -> ToleranceYield:
        """Return how many trucks keep what a setting promises.

        What rubber at its stop and a spline that sticks take from its margins they take from
        those of each truck.

        Parameters
        ----------
        ways, amounts
            The setting: what is moved, and by how much (ways) SI.
        asked
            How many trucks are evaluated each by itself; 0 takes margins as parabolas of what
            scatters, and 4096 of them.
        solved
            Margins (M,) of the setting as one design, with both; evaluated if not given.
        """
        still = np.zeros((1, len(self.sampling_plan.names)))
        each = self._limits(ways)
        promised = solved or margins_to_both_bounds(*self.responses(ways, amounts, still[0]))
        held = (promised["maximum"] >= -MARGIN_TOLERANCE) & [m.maximum is not None for m in each]
        calm = (promised["normal"] >= -MARGIN_TOLERANCE) & [m.has_warning_bound for m in each]
        about = self.margins(ways, amounts, still) if asked else self._margins_about(ways, amounts)
        less = {
            to: np.where(m[0] < MARGIN_CAP, np.minimum(promised[to] - m[0], 0.0), 0.0)
            for to, m in about.items()
        }
        if asked:
            off = self.sampling_plan.values(0, asked) - np.array(self.sampling_plan.nominal)
            some = [
                self.margins(ways, amounts, off[k : k + VARIANTS_PER_CHUNK])
                for k in range(0, asked, VARIANTS_PER_CHUNK)
            ]
            left, near = (
                np.concatenate([m[to] for m in some]) + less[to] for to in ("maximum", "normal")
            )
            kept = _kept(left, held)
            return ToleranceYield(
                share=float(kept.mean()),
                share_without_warnings=float((kept & _kept(near, calm)).mean()),
                individually_evaluated=True,
                most_failed_quantity=_lost(each, left, held),
            )
        off = self._normal(self.sampling_plan.unit_points(0, SAMPLE_COUNT))
        about = {to: m + less[to] for to, m in about.items()}
        some = np.flatnonzero(held & _may_fail(about["maximum"], off))
        left = _parabola(about["maximum"][:, some])
        near = _parabola(about["normal"][:, calm & _may_fail(about["normal"], off)])
        kept, quiet = ((margins(off) >= -MARGIN_TOLERANCE).all(-1) for margins in (left, near))
        halved = {}
        for k, factor in enumerate(self.sampling_plan.factors):
            half = off.copy()
            half[:, k] /= 2
            halved[self.sampling_plan.name_of(factor)] = float(
                (left(half) >= -MARGIN_TOLERANCE).all(-1).mean()
            )
        best = max(halved, key=halved.__getitem__)
        share = float(kept.mean())
        return ToleranceYield(
            share=share,
            share_without_warnings=float((kept & quiet).mean()),
            individually_evaluated=False,
            best_tightening=(best, halved[best]) if halved[best] > share + 0.005 else None,
            most_failed_quantity=_lost(
                [each[k] for k in some], left(off), np.ones(len(some), dtype=bool)
            ),
        )

    def margin_standard_deviations(
        self, ways: tuple[PermittedAdjustment, ...], amounts: FloatArray, *, to: Any
    ) -> FloatArray:
        """Return the standard deviation of each margin at a setting, from its slopes."""
        forth, back = np.split(self._margins_about(ways, amounts)[to][1:], 2)
        return np.sqrt((((forth - back) / (2 * FINITE_DIFFERENCE_STEP_SD)) ** 2).sum(0))

    def _margins_about(
        self, ways: tuple[PermittedAdjustment, ...], amounts: FloatArray
    ) -> dict[LimitBoundName, FloatArray]:
        """Return margins (1 + 2 T, M) to either bound: at a setting, then to each side of it.

        By `FINITE_DIFFERENCE_STEP_SD` of each of T tolerances; evaluated once for each setting.
        """
        key = ways, tuple(amounts.tolist())
        if key not in self._known_margins:
            self._known_margins[key] = self.margins(ways, amounts, self._about)
        return self._known_margins[key]

    def evaluate_about(self, ways: tuple[PermittedAdjustment, ...], settings: FloatArray) -> None:
        """Evaluate margins about settings (N, ways) in one batch, for what needs them later.

        Where arrays cannot hold what scatters each setting is evaluated when it is needed.
        """
        new = [s for s in settings if (ways, tuple(s.tolist())) not in self._known_margins]
        if not new:
            return
        count = len(self._about)
        trucks = np.repeat(np.array(new), count, axis=0), np.tile(self._about, (len(new), 1))
        try:
            found = margins_to_both_bounds(*self.responses(ways, *trucks))
        except (InvalidFileError, DesignError):
            return
        rows = len(trucks[1])
        for k, setting in enumerate(new):
            self._known_margins[ways, tuple(setting.tolist())] = {
                to: np.broadcast_to(m, (rows, m.shape[-1]))[k * count : (k + 1) * count]
                for to, m in found.items()
            }

    @cached_property
    def _about(self) -> FloatArray:
        """How far trucks are off (1 + 2 T, T): not, and by each tolerance to each side."""
        step = np.diag(self._wide) * FINITE_DIFFERENCE_STEP_SD
        return np.concatenate([np.zeros((1, len(step))), step, -step])

    @cached_property
    def _known_margins(
        self,
    ) -> dict[
        tuple[tuple[PermittedAdjustment, ...], tuple[float, ...]], dict[LimitBoundName, FloatArray]
    ]:
        """Those that were evaluated: a search needs their slopes, a proposal its trucks."""
        return {}

    def _limits(self, ways: tuple[PermittedAdjustment, ...]) -> tuple[Limit, ...]:
        """Return which limit each margin is to, at any setting."""
        if ways not in self._known_limits:
            still = np.zeros((1, len(self.sampling_plan.names)))
            lines = self.responses(ways, np.zeros(len(ways)), still)
            self._known_limits[ways] = limit_of_each_margin(*lines)
        return self._known_limits[ways]

    @cached_property
    def _known_limits(self) -> dict[tuple[PermittedAdjustment, ...], tuple[Limit, ...]]:
        return {}

    def _normal(self, unit: FloatArray) -> FloatArray:
        """Return how far trucks are off in each tolerance, in its standard deviations."""
        return (
            self.sampling_plan.inputs_at(unit) - np.array(self.sampling_plan.nominal)
        ) / self._wide

    @property
    def _wide(self) -> FloatArray:
        """Standard deviation of each tolerance, in the unit of its name."""
        return np.array([
            s.values[0] / (np.sqrt(3.0) if s.kind == "uniform" else 1.0) for _, s in self.tolerances
        ])  # fmt: skip


def _own(
    application: Application, line: str, said: Mapping[str, VariedNumber]
) -> dict[str, VariedNumber]:
    """Return the tolerances of a file that are of this line: its moves, and any number."""
    from cardan.model.adjustments import known_names_matching_pattern

    if not said:
        return {}
    every, known = (
        permitted_adjustments_by_name(i.line for i in application.lines),
        nominal_variable_values(application),
    )
    each = {n: s for name, s in said.items() for n in known_names_matching_pattern(name, known)}
    return {n: s for n, s in each.items() if n not in every or every[n].line == line}


def _assumed(application: Application, line: str) -> Iterator[tuple[str, VariedNumber]]:
    measured = {i.line.name: i.line.has_lengths for i in application.lines}
    for name, a in permitted_adjustments_by_name(i.line for i in application.lines).items():
        if not measured[a.line] and a.adjustment_key not in ADJUSTMENTS_OF_LINE_WITHOUT_LENGTHS:
            continue
        kind = f"{a.adjustment_key}_{ADJUSTMENTS[a.adjustment_key].unit}"
        if a.line == line and kind in ASSUMED_TOLERANCES:
            yield name, VariedNumber(kind="normal", values=(ASSUMED_TOLERANCES[kind] / 3,))


def _merged(
    parts: tuple[PermittedAdjustment, ...], amounts: FloatArray
) -> tuple[tuple[PermittedAdjustment, ...], FloatArray]:
    """Return things that are moved, each once, with what they are moved by in all."""
    if not parts:  # numbers of the file scatter alone, and nothing is moved
        return parts, amounts
    keys = [(a.adjustment_key, a.part) for a in parts]
    first = {key: keys.index(key) for key in keys}
    sums = np.stack(
        [amounts[:, [k for k, other in enumerate(keys) if other == key]].sum(-1) for key in first],
        axis=-1,
    )
    return tuple(replace(parts[k]) for k in first.values()), sums


def _coefficients(found: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return middle (1, M), slopes and bends (T, M) of margins (1 + 2 T, M) about a setting."""
    # A limit that applies in some of these trucks alone has no slope: it counts where worst.
    jumps = (found == MARGIN_CAP).any(0) & (found < MARGIN_CAP).any(0)
    found = np.where(jumps, found.min(0), found)
    middle, forth, back = found[:1], *np.split(found[1:], 2)
    slope = (forth - back) / (2 * FINITE_DIFFERENCE_STEP_SD)
    bend = (forth + back - 2 * middle) / (2 * FINITE_DIFFERENCE_STEP_SD**2)
    return middle, slope, bend


def _parabola(found: FloatArray) -> Callable[[FloatArray], FloatArray]:
    """Return margins (V, M) as a function of (V, T), from those in the middle and next to it."""
    middle, slope, bend = _coefficients(found)

    def left(off: FloatArray) -> FloatArray:
        return middle + off @ slope + off**2 @ bend

    return left


def _may_fail(found: FloatArray, off: FloatArray) -> BoolArray:
    """Return which margins (V, M) about a setting may fall below 0 in trucks (V, T), (M,)."""
    middle, slope, bend = _coefficients(found)
    far = np.abs(off).max(axis=0)
    least = middle[0] - far @ np.abs(slope) + far**2 @ np.minimum(bend, 0.0)
    return np.asarray(least < 0, bool)


def _kept(left: FloatArray, held: BoolArray) -> BoolArray:
    """Return in which trucks (V,) every margin that is held stays."""
    return np.asarray((left[:, held] >= -MARGIN_TOLERANCE).all(-1), bool)


def _lost(of: Sequence[Limit], left: FloatArray, held: BoolArray) -> str:
    """Return the quantity that most trucks fail of what was held."""
    bad = ((left < -MARGIN_TOLERANCE) & held).mean(0)
    return of[int(bad.argmax())].quantity if bad.any() else ""
