"""Crack growth against closed forms of Paris' law (Anderson, Fracture Mechanics, ch. 10)."""

import math
from functools import partial

import numpy as np
import pytest

from cardan.core.errors import DesignError
from cardan.physics.fatigue.crack_growth import (
    constant_geometry_factor,
    crack_growth_per_sequence,
    paris,
    paris_cycles,
    sequences_between_crack_lengths,
    walker,
)
from cardan.physics.fatigue.rainflow import Cycles, rainflow

LAW = partial(paris, C=3e-13, m=3.0)
ONE = Cycles(np.array([0.0]), np.array([100.0]), np.array([1.0]))


def test_constant_range_life_matches_closed_form():
    """∫ da / C (100 √πa)³ from 0.5 to 10: 2 (0.5^-½ - 10^-½) / (C 10⁶ π^1.5) by hand."""
    by_hand = 2 * (0.5**-0.5 - 10**-0.5) / (3e-13 * 1e6 * math.pi**1.5)
    assert by_hand == pytest.approx(1_314_560.73, abs=5e-3)
    found = paris_cycles(start=0.5, end=10, stress=100, C=3e-13, m=3)
    assert found == pytest.approx(by_hand, rel=1e-12)


def test_life_at_exponent_two_is_logarithmic():
    found = paris_cycles(start=0.5, end=10, stress=100, C=3e-13, m=2)
    assert found == pytest.approx(math.log(20) / (3e-13 * 1e4 * math.pi), rel=1e-12)
    near = paris_cycles(start=0.5, end=10, stress=100, C=3e-13, m=2 + 1e-9)
    assert near == pytest.approx(found, rel=2e-8)  # d ln N/dm is ln(100 √(π a)), below 7


def test_repeats_of_history_match_integral():
    found = sequences_between_crack_lengths(start=0.5, end=10, cycles=ONE, law=LAW)
    assert found == pytest.approx(1_314_560.73, abs=5e-3)  # Gauss is exact to the print


def test_repeats_with_changing_shape_factor_match_quadrature():
    """Against the trapezoid rule with a hundred thousand panels, itself good to 1e-9."""

    def shape(a):  # a central crack in a width of 25: Feddersen, ASTM STP 410 (1966)
        return 1 / np.sqrt(np.cos(np.pi * np.asarray(a) / 25.0))

    a = np.exp(np.linspace(math.log(0.5), math.log(10), 100_001))
    slow = np.trapezoid(1 / crack_growth_per_sequence(a, cycles=ONE, law=LAW, shape=shape), a)
    assert sequences_between_crack_lengths(
        start=0.5, end=10, cycles=ONE, law=LAW, shape=shape
    ) == pytest.approx(slow, rel=1e-8)


def test_history_grows_by_its_equivalent_range():
    cycles = rainflow(np.abs(np.random.default_rng(0).normal(size=3000)) * 100)
    total = (cycles.count * cycles.range**3).sum()
    one = sequences_between_crack_lengths(start=0.5, end=10, cycles=ONE, law=LAW)
    found = sequences_between_crack_lengths(start=0.5, end=10, cycles=cycles, law=LAW)
    assert found == pytest.approx(one * 100**3 / total, rel=1e-9)


def test_compressive_cycles_do_not_grow_crack():
    assert (
        crack_growth_per_sequence(
            1.0, cycles=Cycles(np.array([-100.0]), np.zeros(1), np.ones(1)), law=LAW
        )
        == 0
    )
    half = Cycles(np.array([-100.0]), np.array([100.0]), np.ones(1))
    assert crack_growth_per_sequence(1.0, cycles=half, law=LAW) == crack_growth_per_sequence(
        1.0, cycles=ONE, law=LAW
    )


def test_range_below_threshold_gives_no_growth():
    law = partial(paris, C=3e-13, m=3.0, threshold=1e4)
    assert sequences_between_crack_lengths(start=0.5, end=10, cycles=ONE, law=law) == math.inf


def test_walker_equals_paris_at_zero_stress_ratio():
    law = partial(walker, C=3e-13, m=3.0, exponent=0.5)
    assert law(100.0, 0.0) == pytest.approx(LAW(100.0, 0.0), rel=1e-12)
    assert law(200.0, 100.0) == pytest.approx(LAW(100.0, 0.0) * 0.5**-1.5, rel=1e-12)


def test_invalid_crack_input_is_rejected():
    with pytest.raises(DesignError, match="grow"):
        sequences_between_crack_lengths(start=1.0, end=0.5, cycles=ONE, law=LAW)
    assert constant_geometry_factor([1.0, 2.0], Y=1.12).tolist() == [1.12, 1.12]
