"""A verdict: one demand held against one limit, with the reason for the limit."""

from collections.abc import Iterable
from functools import cached_property
from math import isfinite, isnan
from typing import Literal, TypeAlias, TypeVar

import numpy as np

from cardan.base.arrays import FloatArray, IntArray
from cardan.base.errors import DesignError
from cardan.base.frozen import dataclass
from cardan.base.part import Mode, Occasion, Part, Point
from cardan.base.source import Source

Grade: TypeAlias = Literal["pass", "warn", "fail"]
"""What one check comes to."""
Verdict: TypeAlias = Literal["pass", "warn", "incomplete", "fail"]
"""What many come to: incomplete where nothing fails but something required has no answer."""
Sense: TypeAlias = Literal["<=", ">="]

Value = TypeVar("Value", float, FloatArray)

GRADES: tuple[Grade, ...] = ("pass", "warn", "fail")
"""Of a check, from best to worst; arrays of grades hold places in this tuple."""
VERDICTS: tuple[Verdict, ...] = ("pass", "warn", "incomplete", "fail")
"""From best to worst."""

EQUAL = 1e-9
"""Shares of a limit this close to 0 count as equal to it, and equality passes."""


def worst(grades: Iterable[Verdict]) -> Verdict:
    """Return the worst of some verdicts; nothing held against anything passes."""
    return VERDICTS[max(map(VERDICTS.index, grades), default=0)]


@dataclass(frozen=True, slots=True, kw_only=True)
class Limit:
    """What a quantity may reach: normally, at most, and who says so. SI values.

    Past `normal` a check warns, past `maximum` it fails; either may be absent, but not
    both. A `band` is the other kind of limit: a range to keep out of, where a check
    warns. A limit with `above_angle` asks only where a joint angle of the line exceeds it,
    one with `states` only in states of these kinds. One that is `required` leaves a verdict
    incomplete where it gets no answer.
    """

    quantity: str
    source: Source
    normal: float | None = None
    maximum: float | None = None
    sense: Sense = "<="
    band: tuple[float, float] | None = None
    above_angle: float | None = None
    states: frozenset[str] | None = None
    """Kinds of state it applies to; None is all of them."""
    required: bool = False
    points: Literal["all", "own"] = "all"
    """Whether it asks at every operating point of a state, or at the state's own alone."""

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
        """Return the share of a bound still free; of 1 SI unit where the bound is 0."""
        free = bound - value if self.sense == "<=" else value - bound
        return free / (abs(bound) or 1.0)

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

    def grade(self, value: float) -> Grade:
        """Return pass, warn or fail. A demand that is not a number never passes."""
        if isnan(value):
            return "fail"
        if self.maximum is not None and self.margin(value, to="maximum") < -EQUAL:
            return "fail"
        return "warn" if self.warns and self.margin(value, to="normal") < -EQUAL else "pass"

    def grades(self, values: FloatArray) -> IntArray:
        """Return the places in `GRADES` of many values at once, as `grade` has them one by one."""
        warned = self.warns & (self.margin(values, to="normal") < -EQUAL)
        failed = np.isnan(values)
        if self.maximum is not None:
            failed |= self.margin(values, to="maximum") < -EQUAL
        return np.where(failed, GRADES.index("fail"), np.where(warned, GRADES.index("warn"), 0))

    def margins(self, values: FloatArray) -> FloatArray:
        """Return the margins to the bounds that decide, as `Check.margin` has them one by one."""
        return self.judged(values)[1]

    def judged(self, values: FloatArray) -> tuple[IntArray, FloatArray]:
        """Return `grades` and `margins` of many values at once."""
        grades = self.grades(values)
        failed = grades == GRADES.index("fail")
        found = np.where(
            failed, self.margin(values, to="maximum"), self.margin(values, to="normal")
        )
        return grades, np.where(np.abs(found) <= EQUAL, 0.0, found)

    @property
    def warns(self) -> bool:
        """Whether there is a bound past which it warns."""
        return self.band is not None or self.normal is not None


@dataclass(frozen=True, kw_only=True)
class Check:
    """One demand held against one limit, for one part of one line on one occasion.

    Only the facts are stored, in SI. Everything else is derived from them, so a check
    cannot contradict itself.
    """

    quantity: str
    line: str
    when: Occasion
    part: Part
    value: float
    limit: Limit
    point: Point | None = None
    """Where in its state it is worst, if that was sought over the state's operating points."""
    mode: Mode | None = None
    """What makes it so large there: the mode that an order of the line's turning meets."""
    within: tuple[float, float] | None = None
    """Between what the value lies by the error of what it is computed from, where one is known."""
    settled_by: tuple[str, ...] = ()
    """What a file would have to give to say which of the answers left open holds."""

    @property
    def state(self) -> str:
        """The occasion as the JSON contract names it: a state, a gear, a load case."""
        return str(self.when)

    @cached_property
    def grade(self) -> Grade:
        """Whether the demand passes, warns or fails."""
        return self.limit.grade(self.value)

    @cached_property
    def may_be(self) -> Grade:
        """The worst grade that the error of its value leaves open."""
        ends = map(self.limit.grade, self.within or ())
        return GRADES[max(map(GRADES.index, (self.grade, *ends)))]

    @property
    def decided_by(self) -> Literal["normal", "maximum", "band"]:
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
        chosen = limit.normal if self.decided_by == "normal" else limit.maximum
        assert chosen is not None  # __post_init__ refuses a limit without bounds
        return chosen

    @property
    def how_read(self) -> str:
        """How that bound was read, a word of `HOW_READ`; empty where nobody said."""
        return self.limit.source.of(self.decided_by).how_read

    @cached_property
    def margin(self) -> float:
        """Share of the deciding bound still free; negative where it is passed."""
        to = "maximum" if self.grade == "fail" else "normal"
        margin = self.limit.margin(self.value, to=to)
        return 0.0 if abs(margin) <= EQUAL else margin


def badness(c: Check) -> tuple[int, int, float]:
    """Return what checks are sorted by: failures first, then what may be one, then by margin."""
    return -GRADES.index(c.grade), -GRADES.index(c.may_be), c.margin


def spoilt(before: Iterable[Check], after: Iterable[Check]) -> list[Check]:
    """Return what of a part warns or fails after a change and was nowhere as bad before it."""
    grades = dict[tuple[str, str, Part], int]()
    for c in before:
        key = c.line, c.quantity, c.part
        grades[key] = max(GRADES.index(c.grade), grades.get(key, 0))
    return [c for c in after if GRADES.index(c.grade) > grades.get((c.line, c.quantity, c.part), 0)]


@dataclass(frozen=True, slots=True, kw_only=True)
class Unanswered:
    """A limit that asked and got no number, and what the application would have to give."""

    limit: Limit
    line: str
    when: Occasion
    part: Part
    needs: tuple[str, ...]

    @property
    def quantity(self) -> str:
        """What was asked."""
        return self.limit.quantity
