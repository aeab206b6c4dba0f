"""A correction of a line: what it moves, and what the application comes to with it."""

from collections.abc import Collection, Iterable
from dataclasses import dataclass
from functools import cached_property
from typing import TypeAlias

from cardan.approval.applied_adjustments import AppliedAdjustment
from cardan.approval.approval import Approval
from cardan.checks.quantities.registry import LINE_QUANTITIES
from cardan.core.labels import Part
from cardan.core.verdict import (
    CHECK_GRADES,
    MARGIN_TOLERANCE,
    VERDICTS,
    Check,
    Limit,
    UnevaluatedCheck,
    Verdict,
    worst_verdict,
)
from cardan.topics.design.robustness import (
    PRODUCTION_YIELD_CLASS_COUNT,
    ToleranceModel,
    ToleranceYield,
)

LimitOfPart: TypeAlias = tuple[str, Limit, Part]
"""Name of a line, limit, and part that it applies to."""

Standing: TypeAlias = tuple[int, int, int, int]
"""Place of a verdict in `VERDICTS`, criteria exceeded with lower bounds, without them, and criteria
that warn: the least is best."""


@dataclass(frozen=True, kw_only=True)
class Correction:
    """A correction of one line, and what the application comes to with it.

    `margin` is the least to a warning among the limits that moving can change, which the search
    goes by, and `margin_before` the same as installed. `approval` is that of the whole application
    so corrected, `installed_approval` as it stands; `tolerance_yield` how many trucks keep what it
    promises as they scatter, None where nothing does. `changeable` are the limits, by line and
    part, that moving can change and correct.
    """

    line: str
    adjustments: tuple[AppliedAdjustment, ...]
    margin_before: float
    margin: float
    approval: Approval
    installed_approval: Approval
    changeable: frozenset[LimitOfPart]
    tolerance_yield: ToleranceYield | None = None
    tolerance_model: ToleranceModel | None = None

    @cached_property
    def standing(self) -> Standing:
        """How the application so corrected stands: verdict, criteria exceeded, warnings."""
        return standing_of(self.verdict, self.checks)

    @property
    def sort_key(self) -> tuple[Standing, int, float, float]:
        """What proposals are sorted by: how it stands, how many trucks keep it, cost, margin."""
        sure = (
            self.tolerance_yield.yield_class
            if self.tolerance_yield
            else PRODUCTION_YIELD_CLASS_COUNT - 1
        )
        return self.standing, -sure, round(self.cost, 2), -self.margin

    def worst_changeable_check(self, of: Approval) -> Check:
        """Return the check of an approval that decides among what moving can change.

        The smallest margin of the worst grade there, as the smallest margin of all is.
        """
        found = [c for c in of.checks if _limit_of_part(c) in self.changeable]
        return min(found, key=lambda c: (-CHECK_GRADES.index(c.grade), c.margin))

    @property
    def unchangeable_checks(self) -> list[Check]:
        """Checks of lines, as installed, that do not pass and that no move corrects."""
        return [
            c
            for c in self.installed_approval.checks
            if c.grade != "pass"
            and c.quantity in LINE_QUANTITIES
            and _limit_of_part(c) not in self.changeable
        ]

    @property
    def is_acceptable(self) -> bool:
        """Whether it comes to no worse a verdict than the application as it stands.

        What does corrects nothing, whatever margin it wins elsewhere. Nor does what leaves less
        margin at the same verdict, unless less fails or warns; nor what exceeds more criteria.
        """
        exceeded, before = map(exceeded_count, (self.checks, self.installed_approval.checks))
        if exceeded > before:
            return False
        installed = verdict_beyond_bounds(self.installed_approval.verdict, self.installed_approval)
        if self.verdict != installed:
            return worst_verdict([self.verdict, installed]) == installed
        if exceeded < before:
            return True
        now, was = (a.smallest_margin or 0.0 for a in (self.approval, self.installed_approval))
        return now >= was - MARGIN_TOLERANCE or _wrong(self.approval) < _wrong(
            self.installed_approval
        )

    @property
    def cost(self) -> float:
        """Sum of the shares of their ranges that the moves use."""
        return share_of_ranges_used(self.adjustments)

    @property
    def verdict(self) -> Verdict:
        """What a check of the corrected application comes to, by `verdict_beyond_bounds`."""
        return verdict_beyond_bounds(self.approval.verdict, self.approval)

    @property
    def checks(self) -> tuple[Check, ...]:
        """All checks of the corrected application."""
        return self.approval.checks

    @property
    def unevaluated(self) -> tuple[UnevaluatedCheck, ...]:
        """What nothing moved can answer."""
        return self.approval.coverage.unevaluated


def verdict_beyond_bounds(verdict: Verdict, of: Approval) -> Verdict:
    """Return a verdict, incomplete for a warning if a check of a line holds a lower bound alone.

    A check warns of such a value, which may be anything above: no correction rests on it.
    """
    bounded = any(c.is_lower_bound and c.quantity in LINE_QUANTITIES for c in of.checks)
    return worst_verdict([verdict, "incomplete"]) if bounded else verdict


def exceeded_count(checks: Iterable[Check]) -> int:
    """Return how many limits of lines fail, each counted once for its states and parts.

    A lower bound counts as failing: nothing shows that its maximum holds.
    """
    return len({(c.quantity, c.line, c.limit) for c in checks if c.grade_as_exceeded == "fail"})


def standing_of(verdict: Verdict, checks: Iterable[Check]) -> Standing:
    """Return how checks stand, whose verdict is known."""
    checks = tuple(checks)
    failed, warned = (
        {(c.quantity, c.line, c.limit) for c in checks if c.grade == grade}
        for grade in ("fail", "warn")
    )
    return VERDICTS.index(verdict), exceeded_count(checks), len(failed), len(warned - failed)


def _limit_of_part(c: Check) -> LimitOfPart:
    return c.line, c.limit, c.part


def _wrong(of: Approval) -> tuple[int, int]:
    """Return how many checks fail, lower bounds among them, and how many warn."""
    grades = [c.grade_as_exceeded for c in of.checks]
    return grades.count("fail"), grades.count("warn")


def share_of_ranges_used(moves: Collection[AppliedAdjustment]) -> float:
    """Return the sum of the shares of their ranges that moves use."""
    return sum(m.cost for m in moves)
