"""A verdict: one demand held against one limit, with the reason for the limit."""

from collections.abc import Iterable
from functools import cached_property
from math import inf, isfinite, isnan
from typing import Literal, TypeAlias, TypeVar

import numpy as np

from cardan.core.arrays import ArrayLike, FloatArray, IntArray
from cardan.core.errors import DesignError
from cardan.core.labels import EvaluationCondition, OperatingPoint, OrderCrossing, Part
from cardan.core.lazy_dataclass import dataclass
from cardan.core.provenance import Source

CheckGrade: TypeAlias = Literal["pass", "warn", "fail"]
"""What one check comes to."""
Verdict: TypeAlias = Literal["pass", "warn", "incomplete", "fail"]
"""What many come to: incomplete where nothing fails but something required is not evaluated."""
LimitSense: TypeAlias = Literal["<=", ">="]

Value = TypeVar("Value", float, FloatArray)

CHECK_GRADES: tuple[CheckGrade, ...] = ("pass", "warn", "fail")
"""Of a check, from best to worst; arrays of grades hold places in this tuple."""

VERDICTS: tuple[Verdict, ...] = ("pass", "warn", "incomplete", "fail")
"""From best to worst."""

GRADE_TEXTS: dict[Verdict, str] = {
    "fail": "exceeded",
    "warn": "beyond recommended",
    "incomplete": "incomplete",
    "pass": "met",
}
"""What the grade of a criterion or of a check is called; JSON and files keep the codes."""

MARGIN_TOLERANCE = 1e-9
"""Shares of a limit this close to 0 count as equal to it, and equality passes."""


def worst_verdict(grades: Iterable[Verdict]) -> Verdict:
    """Return the worst of some verdicts; nothing held against anything passes."""
    return VERDICTS[max(map(VERDICTS.index, grades), default=0)]


@dataclass(frozen=True, slots=True, kw_only=True)
class Limit:
    """What a quantity may reach: normally, at most, and its source. SI values.

    Past `normal` a check warns, past `maximum` it fails; either may be absent, but not
    both. A `band` is the other kind of limit: a range to keep out of, where a check
    warns. A limit with `above_angle` applies only where the angle of a cross exceeds it,
    one with `states` only in states of these kinds. One that is `required` leaves a verdict
    incomplete if it is not evaluated.
    """

    quantity: str
    source: Source
    normal: float | None = None
    maximum: float | None = None
    sense: LimitSense = "<="
    band: tuple[float, float] | None = None
    above_angle: float | None = None
    states: frozenset[str] | None = None
    """Kinds of state it applies to; None is all of them."""
    required: bool = False
    points: Literal["all", "own"] = "all"
    """Whether it applies at every operating point of a state, or at the state's own alone."""
    if_given: bool = False
    """Whether it applies only if a file gives the input that it needs."""
    margin_scale: float = 1.0
    """What margins are shares of where the bound is 0."""

    def __post_init__(self) -> None:
        bounds = [b for b in (self.normal, self.maximum, *(self.band or ())) if b is not None]
        if not bounds or not all(map(isfinite, bounds)):
            msg = f"a limit of {self.quantity} needs a finite normal, maximum or band"
            raise DesignError(msg)
        if self.band and not (self.normal is None and self.maximum is None):
            msg = f"a limit of {self.quantity} has a band, or a normal and a maximum, not both"
            raise DesignError(msg)
        if self.band and not 0 < self.band[0] < self.band[1]:
            msg = f"the band of {self.quantity} must rise from above 0, got {self.band}"
            raise DesignError(msg)
        first, last = self.normal, self.maximum
        if first is not None and last is not None and self._margin(first, last) < 0:
            msg = (
                f"normal of {self.quantity} must lie on the safe side of its maximum "
                f"{last:g}, got {first:g}"
            )
            raise DesignError(msg)

    def _margin(self, value: Value, bound: float) -> Value:
        """Return the share of a bound still free; of `margin_scale` where the bound is 0."""
        free = bound - value if self.sense == "<=" else value - bound
        return free / (abs(bound) or self.margin_scale)

    def margin(self, value: Value, *, to: Literal["normal", "maximum"]) -> Value:
        """Return the share of the limit still free, negative where it is passed.

        Of a number or of an array of them. Where the limit has no bound of that name the
        other one serves. Inside a band the margin is the way to its nearer edge, as a share
        of that edge.
        """
        if self.band:
            low, high = self.band
            below, above = (low - value) / low, (value - high) / high
            return below + (above - below) * (above > below)
        bounds = (self.normal, self.maximum) if to == "normal" else (self.maximum, self.normal)
        bound = next(b for b in bounds if b is not None)
        return self._margin(value, bound)

    def grade(self, value: float, *, validity_margin: float = inf) -> CheckGrade:
        """Return pass, warn or fail. A demand that is not a number never passes.

        Where `validity_margin` is negative the value is a lower bound, which never passes.
        """
        if isnan(value):
            return "fail"
        if self.maximum is not None and self.margin(value, to="maximum") < -MARGIN_TOLERANCE:
            return "fail"
        if validity_margin < -MARGIN_TOLERANCE:
            return "warn"
        return (
            "warn"
            if self.has_warning_bound and self.margin(value, to="normal") < -MARGIN_TOLERANCE
            else "pass"
        )

    def grades(self, values: FloatArray, *, validity_margin: ArrayLike = inf) -> IntArray:
        """Return the places in `CHECK_GRADES` of many values at once, by `grade`'s rule."""
        warned = self.has_warning_bound & (self.margin(values, to="normal") < -MARGIN_TOLERANCE)
        warned = warned | (np.asarray(validity_margin) < -MARGIN_TOLERANCE)
        failed = np.isnan(values)
        if self.maximum is not None:
            failed |= self.margin(values, to="maximum") < -MARGIN_TOLERANCE
        return np.where(
            failed, CHECK_GRADES.index("fail"), np.where(warned, CHECK_GRADES.index("warn"), 0)
        )

    def grades_and_margins(
        self, values: FloatArray, *, validity_margin: ArrayLike = inf
    ) -> tuple[IntArray, FloatArray]:
        """Return `grades` of many values at once, and margins as `Check.margin` has them."""
        grades = self.grades(values, validity_margin=validity_margin)
        failed = grades == CHECK_GRADES.index("fail")
        normal = np.minimum(self.margin(values, to="normal"), validity_margin)
        found = np.where(failed, self.margin(values, to="maximum"), normal)
        return grades, np.where(np.abs(found) <= MARGIN_TOLERANCE, 0.0, found)

    @property
    def has_warning_bound(self) -> bool:
        """Whether there is a bound past which it warns."""
        return self.band is not None or self.normal is not None


@dataclass(frozen=True, slots=True)
class AssumedRange:
    """The range of an input that a file leaves out or cannot know closer, in its unit."""

    name: str
    """Its key, as an application would give it."""
    low: float
    high: float
    unit: str = ""
    is_given: bool = False
    """Whether the file gives the range."""


@dataclass(frozen=True, kw_only=True)
class Check:
    """One demand held against one limit, for one part of one line on one occasion.

    Only the facts are stored, in SI. Everything else is derived from them, so a check
    cannot contradict itself.
    """

    quantity: str
    line: str
    when: EvaluationCondition
    part: Part
    value: float
    limit: Limit
    point: OperatingPoint | None = None
    """Where in its state it is worst, if that was sought over the state's operating points."""
    mode: OrderCrossing | None = None
    """What makes it so large there: the mode that an order of the line's turning meets."""
    within: tuple[float, float] | None = None
    """Between what the value lies by the error of what it is computed from, where one is known."""
    deciding_inputs: tuple[str, ...] = ()
    """What a file would have to give to say which of the answers left open holds."""
    assumed: tuple[AssumedRange, ...] = ()
    """Assumed inputs that move the value `within` its ends."""
    validity_margin: float = inf
    """Negative where the value is a lower bound: the share by which the range in which it would
    hold is passed, as the travel of rubber to its stop."""

    @property
    def is_lower_bound(self) -> bool:
        """Whether the demand is at least the value, and not bounded from above."""
        return self.validity_margin < -MARGIN_TOLERANCE

    @property
    def state(self) -> str:
        """The occasion as the JSON contract names it: a state, a gear, a load case."""
        return str(self.when)

    @property
    def grade_as_exceeded(self) -> CheckGrade:
        """Its grade; fail where the value is a lower bound alone, which no maximum surely holds.

        By it designs are compared: one is no better for a force that is known as "at least".
        """
        return "fail" if self.is_lower_bound and self.limit.maximum is not None else self.grade

    @cached_property
    def grade(self) -> CheckGrade:
        """Whether the demand passes, warns or fails."""
        return self._grade_of(self.value)

    def _grade_of(self, value: float) -> CheckGrade:
        return self.limit.grade(value, validity_margin=self.validity_margin)

    @cached_property
    def worst_possible_grade(self) -> CheckGrade:
        """The worst grade that the error of its value leaves open."""
        return CHECK_GRADES[max(map(CHECK_GRADES.index, self._possible_grades))]

    @property
    def best_possible_grade(self) -> CheckGrade:
        """The best grade that the error of its value leaves open."""
        return CHECK_GRADES[min(map(CHECK_GRADES.index, self._possible_grades))]

    @property
    def _possible_grades(self) -> tuple[CheckGrade, ...]:
        """Its grades at both ends of its interval, and within a band that lies between them."""
        if self.within is None:
            return (self.grade,)
        values = [self.value, *self.within]
        if self.limit.band and self.within[0] < sum(self.limit.band) / 2 < self.within[1]:
            values.append(sum(self.limit.band) / 2)
        return tuple(self._grade_of(value) for value in values)

    @property
    def deciding_bound(self) -> Literal["normal", "maximum", "band"]:
        """Which bound decided: the one passed, or the first one ahead."""
        limit = self.limit
        if limit.band:
            return "band"
        if limit.normal is None or (self.grade == "fail" and limit.maximum is not None):
            return "maximum"
        return "normal"

    @property
    def bound(self) -> float:
        """The bound that decided."""
        limit = self.limit
        if limit.band:
            low, high = limit.band
            # The edge that is nearer as a share of itself, as the margin counts.
            return low if self.value / low + self.value / high < 2 else high
        chosen = limit.normal if self.deciding_bound == "normal" else limit.maximum
        assert chosen is not None  # __post_init__ refuses a limit without bounds
        return chosen

    @property
    def how_read(self) -> str:
        """How that bound was read, a word of `PROVENANCE_CODES`; empty if not given."""
        return self.limit.source.source_of_value(self.deciding_bound).how_read

    @cached_property
    def margin(self) -> float:
        """Share of the deciding bound still free; negative where it is passed."""
        to = "maximum" if self.grade == "fail" else "normal"
        margin = self.limit.margin(self.value, to=to)
        if self.grade != "fail":
            margin = min(margin, self.validity_margin)
        return 0.0 if abs(margin) <= MARGIN_TOLERANCE else margin


def worst_first_key(c: Check) -> tuple[int, int, float]:
    """Return what checks are sorted by: failures first, then what may be one, then by margin."""
    return -CHECK_GRADES.index(c.grade), -CHECK_GRADES.index(c.worst_possible_grade), c.margin


def worsened_checks(before: Iterable[Check], after: Iterable[Check]) -> list[Check]:
    """Return what of a part warns or fails after a change and was nowhere as bad before it."""
    grades = dict[tuple[str, str, Part], int]()
    for c in before:
        key = c.line, c.quantity, c.part
        grades[key] = max(CHECK_GRADES.index(c.grade), grades.get(key, 0))
    return [
        c
        for c in after
        if CHECK_GRADES.index(c.grade) > grades.get((c.line, c.quantity, c.part), 0)
    ]


@dataclass(frozen=True, slots=True, kw_only=True)
class UnevaluatedCheck:
    """A limit that applies and got no number, and what the application would have to give."""

    limit: Limit
    line: str
    when: EvaluationCondition
    part: Part
    missing_inputs: tuple[str, ...]

    @property
    def quantity(self) -> str:
        """What was to be evaluated."""
        return self.limit.quantity
