"""Criteria of an approval: one limit on one line with all its checks, and how a screen names it."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from math import pi

from cardan.application.limit_profiles import limits_to_evaluate
from cardan.core.labels import WHOLE_LINE, OperatingPoint
from cardan.core.units import rpm
from cardan.core.verdict import CHECK_GRADES, Check, CheckGrade, Limit, UnevaluatedCheck
from cardan.model.application import Application
from cardan.render.check_texts import uncapitalised
from cardan.render.i18n import Translator
from cardan.render.phrases import limit_grouping_key

CriterionKey = tuple[str, str, Limit]
"""Quantity, line and limit."""

NAMES_BY_PART = {
    "centre_bearing_dynamic": "{part}, dynamic force",
    "centre_bearing_peak": "{part}, peak force",
    "centre_bearing_static": "{part}, static force",
    "centre_bearing_travel": "{part}, travel",
    "centre_bearing_travel_utilisation": "{part}, travel / stop",
    "clearance": "{part}",
    "clearance_on_rubber": "{part}, dynamic",
}
"""Names of quantities whose part takes the place of its kind: centre bearing 1, peak force.

All others have the name of their declaration, on the screen as in every report.
"""


@dataclass(frozen=True, kw_only=True)
class Criterion:
    """One limit on one line, with its checks in every state and part, the worst first."""

    checks: tuple[Check, ...]

    @property
    def worst(self) -> Check:
        """The check that decides."""
        return self.checks[0]

    @property
    def grade(self) -> CheckGrade:
        """Verdict of the criterion: that of its worst check."""
        return self.worst.grade

    @property
    def key(self) -> CriterionKey:
        """Quantity, line and limit."""
        return limit_grouping_key(self.worst)

    @property
    def deciding_check(self) -> Check | None:
        """The check by which an assumed input may turn the verdict; None if none does."""
        worse = [c for c in self.checks if _place(c.worst_possible_grade) > _place(self.grade)]
        if worse:
            return max(worse, key=lambda c: _place(c.worst_possible_grade))
        best = max(_place(c.best_possible_grade) for c in self.checks)
        return self.worst if best < _place(self.grade) and self.worst.within else None


def _place(grade: CheckGrade) -> int:
    return CHECK_GRADES.index(grade)


def criteria_of(checks: Iterable[Check]) -> tuple[Criterion, ...]:
    """Return the criteria that checks are of, the worst first."""
    found: dict[CriterionKey, list[Check]] = {}
    for c in sorted(checks, key=_severity):
        found.setdefault(limit_grouping_key(c), []).append(c)
    return tuple(Criterion(checks=tuple(some)) for some in found.values())


def _severity(c: Check) -> tuple[int, float]:
    return -_place(c.grade), c.margin


def by_line(criteria: Sequence[Criterion]) -> tuple[Criterion, ...]:
    """Return criteria line by line, the line of the worst one first."""
    lines = dict.fromkeys(c.worst.line for c in criteria)
    return tuple(c for line in lines for c in criteria if c.worst.line == line)


# --------------------------------------------------------------------------- names


def limit_qualifiers(
    of: Iterable[Check | UnevaluatedCheck], application: Application
) -> Mapping[CriterionKey, str]:
    """Return what distinguishes limits of one quantity, in English; none where it has one limit."""
    held = set(limits_to_evaluate(application))
    found: dict[tuple[str, str], dict[Limit, None]] = {}
    for c in of:
        found.setdefault((c.quantity, c.line), {})[c.limit] = None
    return {
        (quantity, line, limit): _qualifier(limit, rated=limit not in held)
        for (quantity, line), limits in found.items()
        if len({limit.sense for limit in limits}) < len(limits)
        for limit in limits
    }


def _qualifier(limit: Limit, *, rated: bool) -> str:
    if rated:
        return "size rating"
    return "maximum" if limit.normal is None and limit.band is None else "recommended"


def short_name(
    c: Check | UnevaluatedCheck, say: Translator, qualifiers: Mapping[CriterionKey, str]
) -> str:
    """Return the name of a criterion without its part, and which of several limits it is."""
    text = None if c.part == WHOLE_LINE else NAMES_BY_PART.get(c.quantity)
    part = "" if c.part == WHOLE_LINE else say.part(c.part)
    named = part if text == "{part}" else say(text, part=part) if text else say.name(c.quantity)
    name = uncapitalised(named)
    qualifier = qualifiers.get((c.quantity, c.line, c.limit), "")
    return f"{name} ({say(qualifier)})" if qualifier else name


def names_its_part(quantity: str) -> bool:
    """Return whether the short name of a quantity says which part it is of."""
    return quantity in NAMES_BY_PART


def full_name(
    c: Check | UnevaluatedCheck, say: Translator, qualifiers: Mapping[CriterionKey, str]
) -> str:
    """Return the name of a criterion with the part that it is worst at."""
    part = "" if c.part == WHOLE_LINE or names_its_part(c.quantity) else say.part(c.part)
    return say.join(short_name(c, say, qualifiers), part)


# --------------------------------------------------------------------------- conditions


def condition_texts(c: Check, say: Translator) -> tuple[str, ...]:
    """Return when a check is worst, in ever fewer words: the whole first, the state alone last."""
    state = say.occasion(c.when)
    if c.point is None:
        return (state,)
    brief, operation = _operation_texts(c.point, say)
    brief, operation = say.join(state, brief), say.join(state, operation)
    if c.point.is_spline_stuck:
        return *(say.join(text, say("spline stuck")) for text in (operation, brief, state)), state
    if c.mode is None:
        return operation, brief, state
    mode = say("({mode} mode)", mode=say(c.mode.shape))
    return f"{operation} {mode}", operation, brief, state


def full_condition_text(c: Check, say: Translator) -> str:
    """Return when a check is worst: the state and the whole operating point."""
    return condition_texts(replace(c, mode=None), say)[0]


def _operation_texts(at: OperatingPoint, say: Translator) -> tuple[str, str]:
    """Return what a line does at a point, without its speed and with it."""
    if at.speed:
        means = {
            "drive": "gear {gear}" if at.gear else "",
            "coast": "overrun, gear {gear}" if at.gear else "overrun",
            "reverse": "reverse",
            "brake": "braking, gear {gear}" if at.gear else "braking",
        }[at.direction]
        brief = say(means, gear=at.gear) if means else ""
        speed = say("{speed} rpm", speed=say.compact_number(round(at.speed / rpm), 6))
        return brief, say.join(brief, speed)
    means = {
        "drive": "pulling away, gear {gear}" if at.gear else "pulling away",
        "coast": "overrun to a stop",
        "reverse": "pulling away in reverse",
        "brake": "braking to a stop",
    }[at.direction]
    said = say(means, gear=at.gear)
    return said, said


def mode_text(c: Check, say: Translator) -> str:
    """Return which resonance makes a check large: 2nd order, pitch mode, 10.4 Hz; "" if none."""
    if c.mode is None:
        return ""
    return say(
        "{order} in resonance with the {mode} mode, {frequency} Hz",
        order=say("1st order" if c.mode.order == 1 else "2nd order"), mode=say(c.mode.shape),
        frequency=say.compact_number(c.mode.frequency / (2 * pi), 3),
    )  # fmt: skip
