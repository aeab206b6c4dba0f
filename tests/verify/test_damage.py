"""Marin factors against Shigley, 9th ed., chapter 6; FKM against pyLife; Gerber by hand."""

from functools import partial

import numpy as np
import pytest

from cardan.core.units import MPa, mm
from cardan.physics.fatigue import sn_curve as strength
from cardan.physics.fatigue.mean_stress import fkm, gerber, swt, walker
from cardan.physics.fatigue.sn_curve import SNCurve


def test_gerber_and_basquin_match_hand_calculation():
    """sf' 475.4, b -0.078, amplitude 180, mean 100, strength 700: 183.8 MPa, 98,104 cycles."""
    equivalent = gerber(180 * MPa, 100 * MPa, ultimate=700 * MPa)
    assert equivalent / MPa == pytest.approx(183.75, abs=1e-12)  # 180 / (48/49)
    curve = SNCurve.basquin(coefficient=475.4 * MPa, exponent=-0.078)
    assert curve.life(equivalent) == pytest.approx(98_104, abs=0.5)  # printed whole


def test_walker_and_swt_match_hand_calculation():
    """σmax^(1-γ) σa^γ: 200^0.35 80^0.65 = 110.25; and √(200 80) = 126.5 for SWT."""
    assert walker(80, 120, exponent=0.65) == pytest.approx(110.25, abs=5e-3)
    assert swt(80, 120) == pytest.approx(126.49, abs=5e-3)


def test_surface_factor_matches_shigley_example_6_3():
    assert strength.surface_factor("machined", ultimate=400 * MPa) == pytest.approx(0.922, abs=5e-4)


def test_size_factor_matches_shigley_example_6_4():
    assert strength.size_factor(32 * mm) == pytest.approx(0.858, abs=5e-4)


def test_notch_factor_matches_shigley_example_6_6():
    """Shigley: 690 MPa, 3 mm fillet, Kt 1.65 gives Kf 1.55 by Neuber's line."""
    q = strength.neuber_sensitivity(radius=3 * mm, ultimate=690 * MPa)
    assert strength.notch_factor(concentration=1.65, sensitivity=q) == pytest.approx(1.55, abs=5e-3)


def test_endurance_limit_matches_shigley_equation_6_8():
    """Half of 400 MPa and of 1200, 700 from 1400 on; times every factor, over the notch's."""
    for ultimate, limit in {400: 200, 1200: 600, 1400: 700, 1750: 700}.items():
        assert strength.endurance_limit(ultimate * MPa) == pytest.approx(limit * MPa)
    assert strength.endurance_limit(400 * MPa, 0.9, 0.8, notch=1.5) == pytest.approx(96 * MPa)
    bar = strength.equivalent_diameter(width=10 * mm, height=40 * mm)
    assert bar == pytest.approx(16.16 * mm)


def test_temperature_factor_matches_shigley_table_6_4():
    """Table 6-4: 1.010 at 50, 1.020 at 100, 1.025 at 150, 0.843 at 450 °C, to its digits."""
    for celsius, factor in {50: 1.010, 100: 1.020, 150: 1.025, 450: 0.843}.items():
        # The polynomial is a fit to the table, in °F; the book allows it half a per cent.
        assert strength.temperature_factor(celsius) == pytest.approx(factor, abs=5e-3)


def test_reliability_factor_matches_shigley_table_6_5():
    for failure, factor in {0.5: 1.0, 0.1: 0.897, 0.05: 0.868, 0.01: 0.814, 1e-3: 0.753}.items():
        assert strength.reliability_factor(failure) == pytest.approx(factor, abs=6e-4)


@pytest.mark.oracle
def test_fkm_mean_stress_correction_matches_pylife():
    from pylife.strength.meanstress import fkm_goodman

    rng = np.random.default_rng(0)
    a = rng.uniform(1, 100, 500)
    m = a * rng.uniform(-4, 3, 500)  # beyond R = 1/2 the guideline is level; pyLife goes on
    theirs = fkm_goodman(a, m, 0.3, 0.1, -1.0)
    np.testing.assert_allclose(fkm(a, m, sensitivity=0.3), theirs, rtol=1e-9)


def test_fkm_matches_hand_values_at_segment_ends():
    line = partial(fkm, sensitivity=0.3)
    assert line(100, -100) == pytest.approx(70)  # R = ∞: 1 - M
    assert line(100, 100) == pytest.approx(130)  # R = 0: 1 + M
    assert line(100, 300) == pytest.approx(130 * 1.3 / 1.1)  # R = 1/2
    assert line(100, 900) == line(100, 300)
