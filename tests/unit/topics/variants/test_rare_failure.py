"""Rare failures by the first order and by dice about them, against plain dice."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.special import ndtr
from scipy.stats import ncx2

from cardan.application import reader
from cardan.core.errors import CardanError
from cardan.model.variants import VariantOutputs
from cardan.physics.fatigue.reliability import Normal, find_failure_mode_design_points, monte_carlo
from cardan.topics.variants.evaluation import VariantEvaluator, build_variants
from cardan.topics.variants.presentation import progress_text, result_tables, terminal_lines
from cardan.topics.variants.presentation_json import json_document
from cardan.topics.variants.rare_failure import estimate_rare_failure
from cardan.topics.variants.runner import run_study
from cardan.topics.variants.schema import read_variant_study as read_study
from cardan.topics.variants.study_result import StudyInterrupted, StudyProgress

LINE = """
title: Two-piece driveline
speed_rpm: 2500
torque_Nm: 3000
driveline:
  slopes:
    side_deg: [3.0, 1.0, 4.5, 2.0]
    top_deg: [0.0, 0.0, 0.0, 0.0]
  joints: "1810"
  shafts:
    - length_mm: 1200
      tube: {outer_mm: 101.6, wall_mm: 3.2}
      centre_bearing: {from_rear_joint_mm: 140}
    - {length_mm: 1500, tube: {outer_mm: 101.6, wall_mm: 3.2}, phase_deg: 0}
limits:
  - {quantity: joint_angle, maximum: LIMIT, source: ours}
"""
SIDE = {"driveline.slopes.side_deg[*]": {"normal": 0.1}}


def bench(limit: float, more=None) -> VariantEvaluator:
    application = reader.loads(LINE.replace("LIMIT", str(limit)))
    return VariantEvaluator.from_application(
        application, build_variants({}, {**SIDE, **(more or {})})
    )


def test_linear_limit_state_matches_closed_form():
    """The angle between two slopes of 0.1 deg each is normal with 0.1 √2: 1e-6 at 4.75."""
    beta = 4.753424
    found = estimate_rare_failure(bench(3.5 + beta * 0.1 * 2**0.5), 0)
    assert ndtr(-beta) == pytest.approx(1e-6, rel=1e-4)
    assert found.first_order.beta == pytest.approx(beta, abs=1e-3)
    assert found.first_order.failure_probability == pytest.approx(1e-6, rel=0.01)
    # Two slopes of four share it.
    np.testing.assert_allclose(found.first_order.importance, [0, 0.5, 0.5, 0], atol=1e-3)
    assert abs(found.sampled.failure_probability - 1e-6) < 4 * found.sampled.standard_error
    assert found.sampled.standard_error < 0.2e-6
    assert found.inputs[2] - found.inputs[1] == pytest.approx(3.5 + beta * 0.1 * 2**0.5, abs=1e-3)


@pytest.mark.slow
def test_circular_limit_state_matches_noncentral_chi_squared():
    """An angle of two views fails outside a circle: about it the nominal stands off the middle.

    Their changes scatter by 0.5 √2 deg each: non-central chi-squared, of which the first order
    tells three quarters.
    """
    both = {f"driveline.slopes.{view}_deg[*]": {"normal": 0.5} for view in ("side", "top")}
    sigma, reach = 0.5 * 2**0.5, 3.0
    found = estimate_rare_failure(bench(3.5 + reach * sigma, both), 0, draws=4096)
    exact = ncx2(2, (3.5 / sigma) ** 2).sf((3.5 / sigma + reach) ** 2)
    first, second = found.first_order, found.second_order
    assert first.beta == pytest.approx(reach, rel=5e-3)
    assert second.curvatures.min() == pytest.approx(-1 / (3.5 / sigma + reach), rel=0.03)
    assert second.failure_probability == pytest.approx(exact, rel=0.04)
    assert first.failure_probability < 0.8 * exact
    assert (
        abs(found.sampled.failure_probability - second.failure_probability)
        < 4 * found.sampled.standard_error + 0.03 * exact
    )


STRAIGHT, TWO = "[0.0, 0.0, 0.0, 0.0]", 0.1 * 2**0.5
ONE = {"driveline.slopes.side_deg[1]": {"normal": 0.1}}


@pytest.mark.slow
@pytest.mark.parametrize(
    ("slopes", "limit", "scatter", "exact", "ways"),
    [
        # A straight line bends either way, at each of its three joints.
        (STRAIGHT, 4 * TWO, SIDE, 6 * ndtr(-4), 6),
        # Three joints with the same angle.
        ("[3.0, 0.0, 3.0, 0.0]", 3 + 4 * TWO, SIDE, 3 * ndtr(-4), 3),
        # One joint, nearly straight: either way, one a little farther.
        ("[0.02, 0.0, 0.0, 0.0]", 0.4, ONE, ndtr(-3.8) + ndtr(-4.2), 2),
        # Only one joint is near.
        ("[3.0, 1.0, 4.5, 2.0]", 3.5 + 4 * TWO, SIDE, ndtr(-4), 1),
    ],
)
def test_failure_probability_combines_several_failure_modes(slopes, limit, scatter, exact, ways):
    """The nearest alone told a sixth, a third and five sixths; of a straight line nothing."""
    text = LINE.replace("LIMIT", str(limit)).replace("[3.0, 1.0, 4.5, 2.0]", slopes)
    found = estimate_rare_failure(
        VariantEvaluator.from_application(reader.loads(text), build_variants({}, scatter)),
        0,
        draws=4096,
    )
    assert len(found.failure_modes) == ways
    assert abs(found.sampled.failure_probability - exact) < 4 * found.sampled.standard_error
    assert found.sampled.standard_error < 0.1 * exact


@pytest.mark.slow
@pytest.mark.parametrize("chosen", [[1.8, 2.2], {"grid": [1.8, 2.2, 3]}, {"choice": [1.8, 2, 2.2]}])
def test_design_variables_stay_at_nominal_and_are_reported(chosen):
    """A grid's stayed as it is, at 1.0 deg; and nobody said that an end fails more often."""
    sides = ("driveline.slopes.side_deg[2]", "driveline.slopes.side_deg[3]")
    text = LINE.replace("LIMIT", "2.9")
    asked = build_variants(
        {sides[0]: chosen}, {sides[1]: {"normal": 0.1}}, ask=VariantOutputs(rare=True)
    )
    found = run_study(reader.loads(text), asked, count=30)
    (angle,) = (r for r in found.rare_failures if r.limit.maximum == pytest.approx(np.radians(2.9)))
    assert angle.first_order.beta == pytest.approx(4, abs=1e-3)
    assert "about the middle of what is chosen" in "\n".join(terminal_lines(found))


@pytest.mark.slow
def test_infeasible_variant_is_not_counted_as_limit_failure():
    """A shaft shorter than its bearing's place, at 3.1 σ: it was told as this limit's failure."""
    short = {"driveline.shafts[1].length_mm": {"normal": 1060 / 3.1}}
    application = reader.loads(LINE.replace("LIMIT", "4.1"))
    found = run_study(
        application,
        build_variants({}, {**SIDE, **short}, ask=VariantOutputs(rare=True)),
        count=4096,
    )
    counts = found.statistics["counts"]
    assert counts["refused"] > 0
    assert counts["grades"][0, 2] == 0
    (one,) = found.rare_failures
    # Of those that exist, 999 in 1000.
    assert one.first_order.beta == pytest.approx(0.6 / (0.1 * 2**0.5), abs=1e-3)
    assert (
        abs(one.sampled.failure_probability - ndtr(-0.6 / (0.1 * 2**0.5)))
        < 4 * one.sampled.standard_error
    )
    said = "\n".join(terminal_lines(found))
    assert "they fail no limit" in said
    assert [r.limit.quantity for r in found.negligible_failures] == ["joint_speed"]


def test_failure_modes_are_summed_without_sampling():
    text = LINE.replace("LIMIT", str(4 * TWO)).replace("[3.0, 1.0, 4.5, 2.0]", STRAIGHT)
    found = estimate_rare_failure(
        VariantEvaluator.from_application(reader.loads(text), build_variants({}, SIDE)), 0, draws=0
    )
    # That two joints bend at once, far too much both, is rarer by far.
    assert found.failure_probability == pytest.approx(6 * ndtr(-4), rel=1e-3)


@pytest.mark.slow
def test_axisymmetric_failure_matches_rayleigh_closed_form():
    """A straight joint in two views: Rayleigh, exp(-r²/2)."""
    both = {f"driveline.slopes.{view}_deg[1]": {"normal": 0.1} for view in ("side", "top")}
    text = LINE.replace("LIMIT", "0.4").replace("[3.0, 1.0, 4.5, 2.0]", STRAIGHT)
    found = estimate_rare_failure(
        VariantEvaluator.from_application(reader.loads(text), build_variants({}, both)),
        0,
        draws=8192,
    )
    assert abs(found.sampled.failure_probability - np.exp(-8)) < 4 * found.sampled.standard_error
    assert found.sampled.standard_error < 0.1 * np.exp(-8)


def test_stepwise_limit_state_falls_back_to_sampling():
    """Stairs: they lead nowhere, but the share that lies beyond the last is known."""
    steps = [Normal(mean=0.0, deviation=1.0)] * 2

    def stairs(x):
        return np.where(x[..., 0] + x[..., 1] > 3.0 * 2**0.5, -1.0, 1.0)

    (one,) = find_failure_mode_design_points(stairs, steps)
    assert one.sampled
    assert 3.0 <= one.beta < 4.0
    sampled = monte_carlo(stairs, steps, samples=4096, seed=1, around=[one])
    assert abs(sampled.failure_probability - ndtr(-3)) < 4 * sampled.standard_error < 0.5 * ndtr(-3)
    assert find_failure_mode_design_points(lambda x: np.ones(x.shape[:-1]), steps) == ()


@pytest.mark.parametrize(("beyond", "exact"), [(0.0, 0.5), (-2.0, ndtr(2))])
def test_failing_nominal_is_estimated_by_plain_sampling(beyond, exact):
    found = estimate_rare_failure(bench(3.5 + beyond * TWO), 0)
    assert found.first_order.beta == pytest.approx(beyond, abs=1e-3)
    assert abs(found.sampled.failure_probability - exact) < 4 * found.sampled.standard_error < 0.07


def test_correlated_tolerances_change_failure_probability():
    """Slopes that go up together leave the angle between them narrower."""
    pair = ("driveline.slopes.side_deg[2]", "driveline.slopes.side_deg[3]")
    wide = 0.1 * (2 * (1 - 0.8)) ** 0.5
    variants = replace(build_variants({}, SIDE), correlated=((*pair, 0.8),))
    text = LINE.replace("LIMIT", str(3.5 + 4 * wide))
    found = estimate_rare_failure(
        VariantEvaluator.from_application(reader.loads(text), variants), 0
    )
    assert found.first_order.beta == pytest.approx(4, abs=1e-3)
    assert abs(found.sampled.failure_probability - ndtr(-4)) < 4 * found.sampled.standard_error


def test_rare_failure_without_tolerances_is_rejected(tmp_path):
    application = reader.loads(LINE.replace("LIMIT", "4.1"))
    for vary in ({"shim_deg": [-1, 1]}, {"shim_deg": {"normal": 0.1}}):
        with pytest.raises(ValueError, match="rare: needs tolerances"):
            run_study(application, build_variants(vary, ask=VariantOutputs(rare=True)), count=20)
    path = tmp_path / "study.yaml"
    path.write_text("vary: {shim_deg: [-1, 1]}\nask: {rare: true}\n")
    with pytest.raises(CardanError, match=r"study.yaml:2:1: ask: rare: needs tolerances"):
        read_study(path, application)


def test_second_order_estimate_is_used_without_sampling():
    found = estimate_rare_failure(bench(4.1), 0, draws=0)
    assert found.sampled is None
    assert found.failure_probability == found.second_order.failure_probability
    # A plane has no bend.
    assert found.failure_probability == pytest.approx(
        found.first_order.failure_probability, rel=1e-4
    )


@pytest.mark.slow
def test_rare_failure_estimate_agrees_with_monte_carlo():
    of = bench(3.85, {"shim_deg": {"uniform": 0.3}, "bearing_height_mm[1]": {"normal": 2.0}})
    found = estimate_rare_failure(of, 0, draws=4096)
    plain = of.evaluate_range(0, 8192)
    share = (plain.results.grades[0] == 2).mean()
    error = (share * (1 - share) / 8192 + found.sampled.standard_error**2) ** 0.5
    assert 0.005 < share < 0.1
    assert abs(found.sampled.failure_probability - share) < 4 * error


def test_study_reports_rare_failure_probability():
    application = reader.loads(LINE.replace("LIMIT", "4.1"))
    asked = build_variants({}, SIDE, ask=VariantOutputs(rare=True))
    found = run_study(application, asked, count=200)
    assert found.acceptable_count == 200
    (one,) = found.rare_failures
    exact = ndtr(-0.6 / (0.1 * 2**0.5))
    assert one.failure_probability == pytest.approx(exact, rel=0.15)
    said = "\n".join(terminal_lines(found))
    assert "1 in " in said
    (listed,) = json_document(found)["rare"]
    assert listed["failure"] == pytest.approx(one.failure_probability)
    assert listed["second_order"] == pytest.approx(exact, rel=0.02)
    # The joint's own angle is far.
    assert "No failure was found nearer than 6 σ" in said
    assert json_document(found)["rare_beyond"] == ["joint_speed"]
    (told,) = (t for t in result_tables(found) if "second order" in t.head)
    assert told.rows[0][told.head.index("second order")].startswith("1 in ")


def test_rare_failure_progress_is_reported_and_interrupt_keeps_study():
    """Limits asked how often they fail took their time in silence, and lost the study to Ctrl-C."""
    told: list[StudyProgress] = []

    def hear(progress: StudyProgress) -> None:
        told.append(progress)
        if progress.rare == (1, 3):
            raise KeyboardInterrupt

    more = "  - {quantity: joint_angle, maximum: 4.3, source: ours}\n"
    line = reader.loads(LINE.replace("LIMIT", "4.2") + more)
    with pytest.raises(StudyInterrupted) as stopped:
        run_study(
            line, build_variants({}, SIDE, ask=VariantOutputs(rare=True)), count=20, hear=hear
        )
    found = stopped.value.result
    assert found.statistics["counts"]["count"] == 20
    assert len(found.rare_failures) + len(found.negligible_failures) == 1
    assert "1 of 3 limits" in progress_text(told[-1])
