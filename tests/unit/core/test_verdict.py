"""What a verdict means, as the design has it (4a), by hand: pass, warn, incomplete, fail."""

import math
from dataclasses import replace
from itertools import permutations

import pytest

from cardan.approval.coverage import CheckCoverage, verdict_of
from cardan.core.labels import WHOLE_LINE, EvaluationCondition, Part
from cardan.core.provenance import Source
from cardan.core.verdict import Check, Limit, UnevaluatedCheck, worst_verdict
from cardan.render.phrases import worst_check_per_limit

HOUSE = Source("House rules")
UP = Limit(quantity="speed", normal=100.0, maximum=200.0, source=HOUSE)
DOWN = Limit(quantity="clearance", normal=20.0, maximum=10.0, sense=">=", source=HOUSE)
BAND = Limit(quantity="half_critical_band", band=(0.4, 0.8), source=HOUSE)
COLD = Limit(quantity="torsional_growth", normal=-2.0, maximum=-1.0, source=HOUSE)


def check(value, limit):
    when = EvaluationCondition("state", "gvw")
    return Check(
        quantity=limit.quantity, line="main", when=when, part=WHOLE_LINE, value=value, limit=limit
    )


def test_limit_row_names_worst_case_and_worst_uncertain_case():
    """99 of 100 that may be no more; 60 that may be 250: both are told, the first as the worst."""
    near = check(99.0, UP)
    rough = replace(
        check(60.0, UP), when=EvaluationCondition("state", "empty"), within=(50.0, 250.0)
    )
    assert worst_check_per_limit([rough, near]) == [rough, near]
    also = replace(near, within=(90.0, 250.0))
    assert worst_check_per_limit([rough, also]) == [also]
    assert worst_check_per_limit([check(98.0, UP), near, check(5.0, DOWN)]) == [
        check(5.0, DOWN),
        near,
    ]


def missed(*, required):
    limit = Limit(quantity="speed", maximum=1.0, source=HOUSE, required=required)
    return UnevaluatedCheck(
        limit=limit,
        line="main",
        when=EvaluationCondition("state", "gvw"),
        part=WHOLE_LINE,
        missing_inputs=("a speed",),
    )


def test_verdict_order_is_fail_incomplete_warn_pass():
    order = ("pass", "warn", "incomplete", "fail")
    for k in range(1, 5):
        for some in permutations(order, k):
            assert worst_verdict(some) == max(some, key=order.index)
    assert worst_verdict(()) == "pass"


@pytest.mark.parametrize(
    ("values", "required", "verdict"),
    [
        ((50.0,), (), "pass"),
        ((50.0,), (False,), "pass"),
        ((50.0, 150.0), (False,), "warn"),
        ((50.0,), (True,), "incomplete"),
        ((150.0,), (False, True), "incomplete"),
        ((250.0,), (True,), "fail"),
        ((), (), "incomplete"),
        ((), (False,), "incomplete"),
    ],
)
def test_required_check_not_evaluated_gives_incomplete(values, required, verdict):
    """An application that nothing was asked of is not approved either."""
    checks = [check(v, UP) for v in values]
    coverage = CheckCoverage(
        evaluated=len(checks), unevaluated=tuple(missed(required=r) for r in required)
    )
    assert len(coverage.missing_required) == sum(required)
    assert coverage.total == len(values) + len(required)
    assert verdict_of(checks, missed=bool(coverage.missing_required)) == verdict


@pytest.mark.parametrize(
    ("limit", "value", "grade", "bound", "margin"),
    [
        (UP, 80.0, "pass", 100, 0.2),
        (UP, 100.0 * (1 + 0.9e-9), "pass", 100, 0),
        (UP, 100.0 * (1 + 1.1e-9), "warn", 100, -1.1e-9),
        (UP, 200.0 * (1 + 0.9e-9), "warn", 100, -1),
        (UP, 200.0 * (1 + 1.1e-9), "fail", 200, -1.1e-9),
        (DOWN, 25.0, "pass", 20, 0.25),
        (DOWN, 20.0 * (1 - 0.9e-9), "pass", 20, 0),
        (DOWN, 15.0, "warn", 20, -0.25),
        (DOWN, 10.0 * (1 - 0.9e-9), "warn", 20, -0.5),
        (DOWN, 8.0, "fail", 10, -0.2),
        (BAND, 0.2, "pass", 0.4, 0.5),
        (BAND, 0.4, "pass", 0.4, 0),
        (BAND, 0.5, "warn", 0.4, -0.25),
        (BAND, 0.7, "warn", 0.8, -0.125),
        (BAND, 1.2, "pass", 0.8, 0.5),
        (COLD, -3.0, "pass", -2, 0.5),
        (COLD, -1.5, "warn", -2, -0.25),
        (COLD, -0.5, "fail", -1, -0.5),
    ],
)
def test_value_equal_to_limit_passes_and_margin_is_relative_to_bound(
    limit, value, grade, bound, margin
):
    """Compared with a tolerance of 1e-9 relative; below zero a bound's size counts."""
    found = check(value, limit)
    assert (found.grade, found.bound) == (grade, bound)
    assert found.margin == pytest.approx(margin, rel=1e-6, abs=1e-16)


@pytest.mark.parametrize(
    ("value", "grade", "margin"), [(60, "warn", -0.3), (150, "warn", -0.5), (220, "fail", -0.1)]
)
def test_lower_bound_never_passes(value, grade, margin):
    """Not bounded from above: within its limit it warns, by how far its range is passed."""
    least = replace(check(value, UP), validity_margin=-0.3)
    assert (least.grade, least.margin) == (grade, pytest.approx(margin))
    assert least.is_lower_bound
    assert replace(least, within=(10.0, 20.0)).best_possible_grade == "warn"
    assert least.grade_as_exceeded == "fail"
    assert check(value, UP).grade_as_exceeded == check(value, UP).grade


def test_nan_never_passes():
    for limit in (UP, DOWN, BAND, COLD):
        assert check(math.nan, limit).grade == "fail"


@pytest.mark.parametrize(
    ("kind", "name", "what", "said"),
    [
        ("state", "gvw", "", "gvw"),
        ("gear", "3", "", "gear 3"),
        ("case", "gvw", "order 2", "gvw: order 2"),
        ("duty", "gvw", "", "duty cycle, gvw"),
    ],
)
def test_occasion_text_states_its_kind(kind, name, what, said):
    """A duty cycle in a state is not the state: the contract tells them apart by these words."""
    assert str(EvaluationCondition(kind, name, what)) == said


def test_part_text_names_the_part():
    assert str(WHOLE_LINE) == "line"
    assert str(Part("clearance", 2, "beam")) == "shaft 2 to beam"
    assert str(Part("mode", 1, 4)) == "mode 1, order 4"
    assert str(Part("zone", 1, 1)) == "zone of mode 1"
    assert str(Part("zone", 1, 2)) == "zone of modes 1 + 2"


@pytest.mark.parametrize("value", [0.55, 0.66, 0.67, 0.75, 0.99, 1.0])
def test_bound_of_band_limit_is_edge_used_for_margin(value):
    """At 0.7 of a band from 0.5 to 1 the margin was that to 1, the bound shown was 0.5."""
    band = Limit(quantity="half_critical_band", band=(0.5, 1.0), source=HOUSE)
    check = Check(
        quantity=band.quantity,
        line="main",
        when=EvaluationCondition("state", "gvw"),
        part=WHOLE_LINE,
        value=value,
        limit=band,
    )
    assert check.margin == pytest.approx(-abs(value - check.bound) / check.bound, abs=1e-12)
