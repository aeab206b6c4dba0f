"""Rare failures by the first order and by dice about them, against plain dice."""

import numpy as np
import pytest
from scipy.special import ndtr

from cardan import files
from cardan.model.variants import Ask
from cardan.report import study as report
from cardan.study.rare import rare
from cardan.study.shards import study
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
