"""First screen of `cardan fix`: proposals, and what the first changes against its own limits."""

import re
from collections import Counter
from dataclasses import replace
from types import SimpleNamespace

import pytest
from one_shaft import ONE_SHAFT

from cardan.application import reader
from cardan.core.labels import EvaluationCondition, Part
from cardan.core.provenance import Source
from cardan.core.verdict import Check, Limit
from cardan.documents.corrections_screen import MAX_LINES, correction_screen_lines
from cardan.documents.criteria import criteria_of
from cardan.render.i18n import LANGUAGE_CODES, Translator
from cardan.render.phrases import VERDICT_TEXTS
from cardan.render.text_layout import without_colours
from cardan.topics.design.correction import Correction
from cardan.topics.design.corrections import find_corrections
from cardan.topics.design.phrases import tolerance_yield_sentences
from cardan.topics.design.robustness import ToleranceYield

FORCE = Limit(quantity="centre_bearing_peak", normal=3000.0, maximum=5000.0, source=Source("us"))


@pytest.fixture(scope="module")
def proposals() -> tuple[Correction, ...]:
    return find_corrections(reader.loads(ONE_SHAFT))


def screen(of: tuple[Correction, ...], code: str = "en") -> list[str]:
    lines = correction_screen_lines(of, of[0].installed_approval, say=Translator(code))
    return without_colours(lines).splitlines()


def peak(value: float, limit: Limit = FORCE) -> Check:
    return Check(
        quantity=limit.quantity,
        line="main",
        when=EvaluationCondition("state", "jounce"),
        part=Part("centre bearing", 2),
        value=value,
        limit=limit,
    )


def with_checks(of: Correction, before: list[Check], after: list[Check]) -> Correction:
    """The correction with these checks in place of its own."""

    def approval(at, checks):
        (first, *others) = at.study_results
        return replace(at, study_results=(replace(first, checks=tuple(checks)), *others))

    return replace(
        of,
        approval=approval(of.approval, after),
        installed_approval=approval(of.installed_approval, before),
    )


def test_proposal_from_fail_to_warn_is_compared_with_its_own_limit(proposals):
    """5600 N of 5000 is a margin of -12 %, 4600 of 3000 one of -53 %: and yet it is better."""
    of = with_checks(proposals[0], [peak(5600.0)], [peak(4600.0)])
    said = " ".join(" ".join(screen((of,))).split())
    assert (
        "Improved: centre bearing 2, peak force 5.60 (max 5 kN) -> 4.60 (max 3 kN), "
        "exceeded -> beyond recommended" in said
    )
    assert not re.search(r"-\d+ %", said)
    # What the proposal leaves exceeded stands above, and what it makes so with both verdicts.
    worse = with_checks(proposals[0], [peak(2900.0)], [peak(6000.0)])
    (row,) = (line for line in screen((worse,)) if line.startswith("X"))
    assert re.search(r"2\.90 \(max 3 kN\) +6\.00 \(max 5 kN\) +met -> exceeded$", row)


def test_proposal_row_counts_criteria_and_names_moves(proposals):
    lines = screen(proposals)
    assert lines[0].endswith("  NOT APPROVED")
    installed = next(line for line in lines if "as installed" in line and "not approved" in line)
    first = next(line for line in lines if line.startswith("1  pinion angle -"))
    for row, of in ((installed, proposals[0].installed_approval), (first, proposals[0].approval)):
        number = Counter(c.grade for c in criteria_of(of.checks))
        assert re.search(rf" {VERDICT_TEXTS[of.verdict]} +{number['fail']} +{number['warn']} ", row)
    assert proposals[0].verdict == "pass"


def test_proposal_row_counts_criteria_newly_exceeded(proposals):
    """It said 1 exceeded before and after, where another one was."""
    other = replace(FORCE, maximum=4000.0)
    before, after = [peak(5600.0), peak(3500.0, other)], [peak(4900.0), peak(4100.0, other)]
    new = with_checks(proposals[0], before, after)
    kept = with_checks(proposals[0], before, [peak(5500.0), peak(3500.0, other)])
    for of, said in ((new, r"1 \(1 new\)"), (kept, "1")):
        (row,) = (line for line in screen((of,)) if line.startswith("1  pinion"))
        assert re.search(rf" not approved +{said} +1 ", row)
    (row,) = (line for line in screen((new,), "pt") if line.startswith("1  "))
    assert "1 (novos: 1)" in row


@pytest.mark.parametrize("code", LANGUAGE_CODES)
def test_screen_of_many_changes_stays_one_screen(proposals, code):
    limits = [replace(FORCE, maximum=5000.0 + k) for k in range(40)]
    before = [peak(2900.0, one) for one in limits]
    after = [peak(6000.0 if k % 2 else 4000.0, one) for k, one in enumerate(limits)]
    of = with_checks(proposals[0], before, after)
    lines = screen((of,) * 12, code)
    assert len(lines) <= MAX_LINES == 32
    assert max(map(len, lines)) <= 80


def test_share_of_trucks_that_is_not_all_does_not_read_as_all():
    """It said "100 % of trucks fail in nothing more", and below it what most others fail in."""
    trucks = ToleranceYield(
        share=0.99976,
        share_without_warnings=1.0,
        individually_evaluated=False,
        most_failed_quantity="centre_bearing_dynamic",
    )
    scatter = SimpleNamespace()  # its names are not needed
    said, others = tolerance_yield_sentences(trucks, scatter, Translator("en"))
    assert said == "99.98 % of trucks fail in nothing more; 100 % do not warn more either"
    assert others.startswith("most others fail in")
