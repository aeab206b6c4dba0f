"""What a verdict means, as the design has it (4a), by hand: pass, warn, incomplete, fail."""

import math
from dataclasses import replace
from itertools import permutations
from types import SimpleNamespace

import pytest

from cardan.base.part import LINE, Occasion, Part
from cardan.base.source import Source
from cardan.base.verdict import Check, Limit, Unanswered, worst
from cardan.report.language import Language
from cardan.report.terminal import checks as rows_of
from cardan.report.wording import worst_of_each
from cardan.study.approval import Coverage, verdict_of

HOUSE = Source("House rules")
UP = Limit(quantity="speed", normal=100.0, maximum=200.0, source=HOUSE)
DOWN = Limit(quantity="clearance", normal=20.0, maximum=10.0, sense=">=", source=HOUSE)
BAND = Limit(quantity="half_critical_band", band=(0.4, 0.8), source=HOUSE)
COLD = Limit(quantity="torsional_growth", normal=-2.0, maximum=-1.0, source=HOUSE)


def check(value, limit):
    when = Occasion("state", "gvw")
    return Check(
        quantity=limit.quantity, line="main", when=when, part=LINE, value=value, limit=limit
    )


def test_the_row_of_a_limit_names_where_it_is_worst_and_where_it_may_be_worse():
    """99 of 100 that may be no more; 60 that may be 250: both are told, the first as the worst."""
    near = check(99.0, UP)
    rough = replace(check(60.0, UP), when=Occasion("state", "empty"), within=(50.0, 250.0))
    assert worst_of_each([rough, near]) == [rough, near]
    also = replace(near, within=(90.0, 250.0))
    assert worst_of_each([rough, also]) == [also]
    assert worst_of_each([check(98.0, UP), near, check(5.0, DOWN)]) == [check(5.0, DOWN), near]
    # One limit all the same: of six, five have a row.
    others = [check(90.0, replace(UP, maximum=200.0 + k)) for k in range(5)]
    found = SimpleNamespace(checks=[rough, check(61.0, UP), *others], responses=[None])
    said = list(rows_of(found, Language("en"), brief=True))
    assert said[-1] == "One more limit passes, by +10 %; --all shows it."


def missed(*, required):
    limit = Limit(quantity="speed", maximum=1.0, source=HOUSE, required=required)
    return Unanswered(
        limit=limit, line="main", when=Occasion("state", "gvw"), part=LINE, needs=("a speed",)
    )


def test_fail_outweighs_incomplete_outweighs_warn_outweighs_pass():
    order = ("pass", "warn", "incomplete", "fail")
    for k in range(1, 5):
        for some in permutations(order, k):
            assert worst(some) == max(some, key=order.index)
    assert worst(()) == "pass"


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
def test_what_is_required_and_has_no_answer_leaves_a_verdict_incomplete(values, required, verdict):
    """An application that nothing was asked of is not approved either."""
    checks = [check(v, UP) for v in values]
    coverage = Coverage(
        answered=len(checks), unanswered=tuple(missed(required=r) for r in required)
    )
    assert len(coverage.missed) == sum(required)
    assert coverage.asked == len(values) + len(required)
    assert verdict_of(checks, missed=bool(coverage.missed)) == verdict


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
def test_equality_passes_and_a_margin_is_a_share_of_its_bound(limit, value, grade, bound, margin):
    """Compared with a tolerance of 1e-9 relative; below zero a bound's size counts."""
    found = check(value, limit)
    assert (found.grade, found.bound) == (grade, bound)
    assert found.margin == pytest.approx(margin, rel=1e-6, abs=1e-16)


def test_what_is_no_number_never_passes():
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
def test_an_occasion_says_what_kind_it_is(kind, name, what, said):
    """A duty cycle in a state is not the state: the contract tells them apart by these words."""
    assert str(Occasion(kind, name, what)) == said


def test_a_part_says_what_it_is():
    assert str(LINE) == "line"
    assert str(Part("clearance", 2, "beam")) == "shaft 2 to beam"
    assert str(Part("mode", 1, 4)) == "mode 1, order 4"
    assert str(Part("zone", 1, 1)) == "zone of mode 1"
    assert str(Part("zone", 1, 2)) == "zone of modes 1 + 2"


@pytest.mark.parametrize("value", [0.55, 0.66, 0.67, 0.75, 0.99, 1.0])
def test_the_bound_of_a_band_is_the_edge_that_the_margin_counts_to(value):
    """At 0.7 of a band from 0.5 to 1 the margin was that to 1, the bound shown was 0.5."""
    band = Limit(quantity="half_critical_band", band=(0.5, 1.0), source=HOUSE)
    check = Check(
        quantity=band.quantity, line="main", when=Occasion("state", "gvw"), part=LINE,
        value=value, limit=band,
    )  # fmt: skip
    assert check.margin == pytest.approx(-abs(value - check.bound) / check.bound, abs=1e-12)
