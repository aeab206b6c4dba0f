"""Rare failures by the first order and by dice about them, against plain dice."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.special import ndtr
from scipy.stats import ncx2

from cardan import files
from cardan.base.errors import CardanError
from cardan.fatigue.reliability import Normal, monte_carlo, ways
from cardan.files.study import read as read_study
from cardan.model.variants import Ask
from cardan.report import study as report
from cardan.study.rare import rare
from cardan.study.shards import Progress, Stopped, study
from cardan.study.sweep import Bench, variants_of

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


def bench(limit: float, more=None) -> Bench:
    application = files.loads(LINE.replace("LIMIT", str(limit)))
    return Bench.of(application, variants_of({}, {**SIDE, **(more or {})}))


def test_a_plane_failure_is_known_in_closed_form():
    """The angle between two slopes of 0.1 deg each is normal with 0.1 √2: 1e-6 at 4.75."""
    beta = 4.753424
    found = rare(bench(3.5 + beta * 0.1 * 2**0.5), 0)
    assert ndtr(-beta) == pytest.approx(1e-6, rel=1e-4)
    assert found.first_order.beta == pytest.approx(beta, abs=1e-3)
    assert found.first_order.failure == pytest.approx(1e-6, rel=0.01)
    # Two slopes of four share it.
    np.testing.assert_allclose(found.first_order.importance, [0, 0.5, 0.5, 0], atol=1e-3)
    assert abs(found.sampled.failure - 1e-6) < 4 * found.sampled.error
    assert found.sampled.error < 0.2e-6
    assert found.inputs[2] - found.inputs[1] == pytest.approx(3.5 + beta * 0.1 * 2**0.5, abs=1e-3)


def test_a_round_failure_is_known_in_closed_form():
    """An angle of two views fails outside a circle: about it the nominal stands off the middle.

    Their changes scatter by 0.5 √2 deg each: non-central chi-squared, of which the first order
    tells three quarters.
    """
    both = {f"driveline.slopes.{view}_deg[*]": {"normal": 0.5} for view in ("side", "top")}
    sigma, reach = 0.5 * 2**0.5, 3.0
    found = rare(bench(3.5 + reach * sigma, both), 0, draws=4096)
    exact = ncx2(2, (3.5 / sigma) ** 2).sf((3.5 / sigma + reach) ** 2)
    first, second = found.first_order, found.second_order
    assert first.beta == pytest.approx(reach, rel=5e-3)
    assert second.curvatures.min() == pytest.approx(-1 / (3.5 / sigma + reach), rel=0.03)
    assert second.failure == pytest.approx(exact, rel=0.04)
    assert first.failure < 0.8 * exact
    assert abs(found.sampled.failure - second.failure) < 4 * found.sampled.error + 0.03 * exact


STRAIGHT, TWO = "[0.0, 0.0, 0.0, 0.0]", 0.1 * 2**0.5
ONE = {"driveline.slopes.side_deg[1]": {"normal": 0.1}}


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
def test_several_ways_to_fail_are_told_together(slopes, limit, scatter, exact, ways):
    """The nearest alone told a sixth, a third and five sixths; of a straight line nothing."""
    text = LINE.replace("LIMIT", str(limit)).replace("[3.0, 1.0, 4.5, 2.0]", slopes)
    found = rare(Bench.of(files.loads(text), variants_of({}, scatter)), 0, draws=4096)
    assert len(found.ways) == ways
    assert abs(found.sampled.failure - exact) < 4 * found.sampled.error
    assert found.sampled.error < 0.1 * exact


@pytest.mark.parametrize("chosen", [[1.8, 2.2], {"grid": [1.8, 2.2, 3]}, {"choice": [1.8, 2, 2.2]}])
def test_what_is_chosen_stays_in_the_middle_and_that_is_told(chosen):
    """A grid's stayed as it is, at 1.0 deg; and nobody said that an end fails more often."""
    sides = ("driveline.slopes.side_deg[2]", "driveline.slopes.side_deg[3]")
    text = LINE.replace("LIMIT", "2.9")
    asked = variants_of({sides[0]: chosen}, {sides[1]: {"normal": 0.1}}, ask=Ask(rare=True))
    found = study(files.loads(text), asked, count=30)
    (angle,) = (r for r in found.rare if r.limit.maximum == pytest.approx(np.radians(2.9)))
    assert angle.first_order.beta == pytest.approx(4, abs=1e-3)
    assert "about the middle of what is chosen" in "\n".join(report.terminal(found))


def test_what_cannot_exist_fails_no_limit():
    """A shaft shorter than its bearing's place, at 3.1 σ: it was told as this limit's failure."""
    short = {"driveline.shafts[1].length_mm": {"normal": 1060 / 3.1}}
    application = files.loads(LINE.replace("LIMIT", "4.1"))
    found = study(application, variants_of({}, {**SIDE, **short}, ask=Ask(rare=True)), count=4096)
    counts = found.states["counts"]
    assert counts["refused"] > 0
    assert counts["grades"][0, 2] == 0
    (one,) = found.rare
    # Of those that exist, 999 in 1000.
    assert one.first_order.beta == pytest.approx(0.6 / (0.1 * 2**0.5), abs=1e-3)
    assert abs(one.sampled.failure - ndtr(-0.6 / (0.1 * 2**0.5))) < 4 * one.sampled.error
    said = "\n".join(report.terminal(found))
    assert "they fail no limit" in said
    assert [r.limit.quantity for r in found.beyond] == ["joint_speed"]


def test_without_dice_all_ways_are_summed():
    text = LINE.replace("LIMIT", str(4 * TWO)).replace("[3.0, 1.0, 4.5, 2.0]", STRAIGHT)
    found = rare(Bench.of(files.loads(text), variants_of({}, SIDE)), 0, draws=0)
    # That two joints bend at once, far too much both, is rarer by far.
    assert found.failure == pytest.approx(6 * ndtr(-4), rel=1e-3)


def test_a_failure_all_around_is_known_in_closed_form():
    """A straight joint in two views: Rayleigh, exp(-r²/2)."""
    both = {f"driveline.slopes.{view}_deg[1]": {"normal": 0.1} for view in ("side", "top")}
    text = LINE.replace("LIMIT", "0.4").replace("[3.0, 1.0, 4.5, 2.0]", STRAIGHT)
    found = rare(Bench.of(files.loads(text), variants_of({}, both)), 0, draws=8192)
    assert abs(found.sampled.failure - np.exp(-8)) < 4 * found.sampled.error
    assert found.sampled.error < 0.1 * np.exp(-8)


def test_where_no_search_ends_what_dice_meet_is_sampled():
    """Stairs: they lead nowhere, but the share that lies beyond the last is known."""
    steps = [Normal(mean=0.0, deviation=1.0)] * 2

    def stairs(x):
        return np.where(x[..., 0] + x[..., 1] > 3.0 * 2**0.5, -1.0, 1.0)

    (one,) = ways(stairs, steps)
    assert one.met
    assert 3.0 <= one.beta < 4.0
    sampled = monte_carlo(stairs, steps, samples=4096, seed=1, around=[one])
    assert abs(sampled.failure - ndtr(-3)) < 4 * sampled.error < 0.5 * ndtr(-3)
    assert ways(lambda x: np.ones(x.shape[:-1]), steps) == ()


@pytest.mark.parametrize(("beyond", "exact"), [(0.0, 0.5), (-2.0, ndtr(2))])
def test_a_nominal_that_fails_or_just_does_is_sampled_plainly(beyond, exact):
    found = rare(bench(3.5 + beyond * TWO), 0)
    assert found.first_order.beta == pytest.approx(beyond, abs=1e-3)
    assert abs(found.sampled.failure - exact) < 4 * found.sampled.error < 0.07


def test_tolerances_that_go_together_count():
    """Slopes that go up together leave the angle between them narrower."""
    pair = ("driveline.slopes.side_deg[2]", "driveline.slopes.side_deg[3]")
    wide = 0.1 * (2 * (1 - 0.8)) ** 0.5
    variants = replace(variants_of({}, SIDE), correlated=((*pair, 0.8),))
    text = LINE.replace("LIMIT", str(3.5 + 4 * wide))
    found = rare(Bench.of(files.loads(text), variants), 0)
    assert found.first_order.beta == pytest.approx(4, abs=1e-3)
    assert abs(found.sampled.failure - ndtr(-4)) < 4 * found.sampled.error


def test_what_nothing_scatters_has_no_odds(tmp_path):
    application = files.loads(LINE.replace("LIMIT", "4.1"))
    for vary in ({"shim_deg": [-1, 1]}, {"shim_deg": {"normal": 0.1}}):
        with pytest.raises(ValueError, match="rare: needs tolerances"):
            study(application, variants_of(vary, ask=Ask(rare=True)), count=20)
    path = tmp_path / "study.yaml"
    path.write_text("vary: {shim_deg: [-1, 1]}\nask: {rare: true}\n")
    with pytest.raises(CardanError, match=r"study.yaml:2:1: ask: rare: needs tolerances"):
        read_study(path, application)


def test_without_dice_the_second_order_tells():
    found = rare(bench(4.1), 0, draws=0)
    assert found.sampled is None
    assert found.failure == found.second_order.failure
    # A plane has no bend.
    assert found.failure == pytest.approx(found.first_order.failure, rel=1e-4)


def test_where_plain_dice_reach_they_agree():
    of = bench(3.85, {"shim_deg": {"uniform": 0.3}, "bearing_height_mm[1]": {"normal": 2.0}})
    found = rare(of, 0, draws=4096)
    plain = of.rows(0, 8192)
    share = (plain.answers.grades[0] == 2).mean()
    error = (share * (1 - share) / 8192 + found.sampled.error**2) ** 0.5
    assert 0.005 < share < 0.1
    assert abs(found.sampled.failure - share) < 4 * error


def test_a_study_tells_what_it_hardly_ever_saw():
    application = files.loads(LINE.replace("LIMIT", "4.1"))
    asked = variants_of({}, SIDE, ask=Ask(rare=True))
    found = study(application, asked, count=200)
    assert found.fit == 200
    (one,) = found.rare
    exact = ndtr(-0.6 / (0.1 * 2**0.5))
    assert one.failure == pytest.approx(exact, rel=0.15)
    said = "\n".join(report.terminal(found))
    assert "1 in " in said
    (listed,) = report.document(found)["rare"]
    assert listed["failure"] == pytest.approx(one.failure)
    assert listed["second_order"] == pytest.approx(exact, rel=0.02)
    # The joint's own angle is far.
    assert "No failure was found nearer than 6 σ" in said
    assert report.document(found)["rare_beyond"] == ["joint_speed"]
    (told,) = (t for t in report.tables(found) if "second order" in t.head)
    assert told.rows[0][told.head.index("second order")].startswith("1 in ")


def test_what_is_rare_is_told_while_it_is_asked_and_stopped_without_loss():
    """Limits asked how often they fail took their time in silence, and lost the study to Ctrl-C."""
    told: list[Progress] = []

    def hear(progress: Progress) -> None:
        told.append(progress)
        if progress.rare == (1, 3):
            raise KeyboardInterrupt

    more = "  - {quantity: joint_angle, maximum: 4.3, source: ours}\n"
    line = files.loads(LINE.replace("LIMIT", "4.2") + more)
    with pytest.raises(Stopped) as stopped:
        study(line, variants_of({}, SIDE, ask=Ask(rare=True)), count=20, hear=hear)
    found = stopped.value.studied
    assert found.states["counts"]["count"] == 20
    assert len(found.rare) + len(found.beyond) == 1
    assert "1 of 3 limits" in report.progress(told[-1])
