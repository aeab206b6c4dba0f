"""Coverage and verdict of checks: how many limits got a number, and the worst of them."""

from collections.abc import Iterator, Sequence
from typing import Any, Literal, TypeAlias

from cardan.approval.study import StudyResult
from cardan.core.labels import WHOLE_LINE
from cardan.core.lazy_dataclass import dataclass
from cardan.core.verdict import Check, UnevaluatedCheck, Verdict, worst_verdict
from cardan.model.application import Application

ApprovalSubject: TypeAlias = Literal["speed", "strength", "rubber of the centre bearings"]
APPROVAL_SUBJECTS: dict[ApprovalSubject, str] = {
    "speed": "critical_speed_ratio",
    "strength": "tube_shear_utilisation",
}
"""What an approval is expected to cover besides angles, and the quantity that shows it."""


@dataclass(frozen=True, kw_only=True)
class CheckCoverage:
    """How many of the checks of a profile are evaluated."""

    evaluated: int
    unevaluated: tuple[UnevaluatedCheck, ...]

    @property
    def total(self) -> int:
        """Limits times the states and parts they apply to."""
        return self.evaluated + len(self.unevaluated)

    @property
    def missing_required(self) -> tuple[UnevaluatedCheck, ...]:
        """What leaves a verdict incomplete: required, and not evaluated."""
        return tuple(u for u in self.unevaluated if u.limit.required)


def coverage_of(*findings: StudyResult[Any]) -> CheckCoverage:
    """Return what studies were run, and what got an answer."""
    return CheckCoverage(
        evaluated=sum(len(f.checks) for f in findings),
        unevaluated=tuple(u for f in findings for u in f.unevaluated),
    )


def verdict_of(checks: Sequence[Check], *, missed: bool) -> Verdict:
    """Return what checks come to; `missed` if a required limit is not evaluated.

    Where nothing was requested nothing is approved either.
    """
    found: list[Verdict] = [c.grade for c in checks]
    return worst_verdict([*found, "incomplete"] if missed or not found else found)


def subjects_not_evaluated(
    application: Application, checks: Sequence[Check]
) -> Iterator[ApprovalSubject]:
    """Yield what no check evaluates of some shaft: its critical speed, the strength of its tube.

    A value counts in whatever state it is known.
    """
    known = {(c.line, c.quantity, c.part.number) for c in checks if c.part != WHOLE_LINE}
    for subject, quantity in APPROVAL_SUBJECTS.items():
        if any(
            (i.line.name, quantity, k) not in known
            for i in application.lines
            for k in range(1, len(i.line.shafts) + 1)
        ):
            yield subject
