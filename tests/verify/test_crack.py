"""Crack growth against closed forms of Paris' law (Anderson, Fracture Mechanics, ch. 10)."""

import math
from functools import partial

import numpy as np
import pytest

from cardan.base.errors import DesignError
from cardan.fatigue.crack import (
    constant_shape,
    finite_width,
    grown,
    growth,
    nasgro,
    paris,
    paris_cycles,
    repeats,
    walker,
)
from cardan.fatigue.rainflow import Cycles, rainflow

LAW = partial(paris, C=3e-13, m=3.0)
ONE = Cycles(np.array([0.0]), np.array([100.0]), np.array([1.0]))


def test_constant_range_in_closed_form():
    """∫ da / C (100 √πa)³ from 0.5 to 10: 2 (0.5^-½ - 10^-½) / (C 10⁶ π^1.5) by hand."""
    by_hand = 2 * (0.5**-0.5 - 10**-0.5) / (3e-13 * 1e6 * math.pi**1.5)
    assert by_hand == pytest.approx(1_314_560.73, abs=5e-3)
    found = paris_cycles(start=0.5, end=10, stress=100, C=3e-13, m=3)
    assert found == pytest.approx(by_hand, rel=1e-12)


def test_exponent_two_is_a_logarithm():
    found = paris_cycles(start=0.5, end=10, stress=100, C=3e-13, m=2)
    assert found == pytest.approx(math.log(20) / (3e-13 * 1e4 * math.pi), rel=1e-12)
    near = paris_cycles(start=0.5, end=10, stress=100, C=3e-13, m=2 + 1e-9)
    assert near == pytest.approx(found, rel=2e-8)  # d ln N/dm is ln(100 √(π a)), below 7


def test_passages_of_a_history_are_the_integral():
    found = repeats(start=0.5, end=10, cycles=ONE, law=LAW)
    assert found == pytest.approx(1_314_560.73, abs=5e-3)  # Gauss is exact to the print


def test_passages_with_a_changing_shape():
    """Against the trapezoid rule with a hundred thousand panels, itself good to 1e-9."""
    shape = partial(finite_width, width=25.0)
    a = np.exp(np.linspace(math.log(0.5), math.log(10), 100_001))
    slow = np.trapezoid(1 / growth(a, cycles=ONE, law=LAW, shape=shape), a)
    assert repeats(start=0.5, end=10, cycles=ONE, law=LAW, shape=shape) == pytest.approx(
        slow, rel=1e-8
    )


def test_cycle_by_cycle_joins_the_integral():
    """A step of 1e-4 in a lags K by half of it, and K³ √a... by 1.5: below 1e-4 in life."""
    many = Cycles(np.zeros(200_000), np.full(200_000, 100.0), np.ones(200_000))
    length, done = grown(0.5, cycles=many, law=LAW, step=1e-4)
    assert done == 200_000
    exact = (0.5**-0.5 - 3e-13 * 1e6 * math.pi**1.5 * 200_000 / 2) ** -2
    assert length == pytest.approx(exact, rel=1e-4)


def test_growth_stops_at_the_length_asked():
    many = Cycles(np.zeros(2_000_000), np.full(2_000_000, 100.0), np.ones(2_000_000))
    length, done = grown(0.5, cycles=many, law=LAW, end=10, step=1e-4)
    assert length >= 10
    assert done == pytest.approx(1_314_561, rel=1e-3)


def test_a_counted_history_grows_by_its_equivalent_range():
    cycles = rainflow(np.abs(np.random.default_rng(0).normal(size=3000)) * 100)
    total = (cycles.count * cycles.range**3).sum()
    one = repeats(start=0.5, end=10, cycles=ONE, law=LAW)
    found = repeats(start=0.5, end=10, cycles=cycles, law=LAW)
    assert found == pytest.approx(one * 100**3 / total, rel=1e-9)


def test_compression_closes_a_crack():
    assert growth(1.0, cycles=Cycles(np.array([-100.0]), np.zeros(1), np.ones(1)), law=LAW) == 0
    half = Cycles(np.array([-100.0]), np.array([100.0]), np.ones(1))
    assert growth(1.0, cycles=half, law=LAW) == growth(1.0, cycles=ONE, law=LAW)


def test_no_growth_below_the_threshold():
    law = partial(paris, C=3e-13, m=3.0, threshold=1e4)
    assert repeats(start=0.5, end=10, cycles=ONE, law=law) == math.inf


def test_walker_is_paris_at_zero_ratio_and_faster_above():
    law = partial(walker, C=3e-13, m=3.0, exponent=0.5)
    assert law(100.0, 0.0) == pytest.approx(LAW(100.0, 0.0), rel=1e-12)
    assert law(200.0, 100.0) == pytest.approx(LAW(100.0, 0.0) * 0.5**-1.5, rel=1e-12)


NASGRO = partial(nasgro, C=1e-11, n=3.0, p=0.5, q=0.5, threshold=5.0, toughness=120.0)


def test_nasgro_has_its_three_regions():
    assert NASGRO(4.9, 0.0) == 0
    assert NASGRO(120.0, 0.0) == np.inf
    rates = NASGRO(np.linspace(5.5, 119, 50), 0.0)
    assert (np.diff(rates) > 0).all()


def test_nasgro_at_high_ratio_is_open():
    """At R = 0.8 Newman's f is R, so ΔK counts in full; threshold and toughness by hand."""
    top, bottom = 60.0, 48.0
    by_hand = 1e-11 * 12**3 * (1 - 5 / 12) ** 0.5 / (1 - 60 / 120) ** 0.5
    assert NASGRO(top, bottom) == pytest.approx(by_hand, rel=1e-9)


def test_newmans_opening_at_zero_ratio():
    """f(0) = A0 = (0.825 - 0.34α + 0.05α²) cos(π/2 · 0.3)^(1/α) = 0.2745 for α = 2.5."""
    f = 1 - (float(nasgro(20.0, 0.0, C=1, n=1, p=0, q=0, threshold=0, toughness=1e9)) / 20)
    assert f == pytest.approx(0.2875 * 0.8910065**0.4, rel=1e-6)


def test_newmans_opening_at_half_ratio():
    """0.27451 + 0.07125 R + 1.03397 R² - 0.37973 R³ = 0.52116 at R = 1/2, α = 2.5."""
    growth_rate = float(nasgro(20.0, 10.0, C=1, n=1, p=0, q=0, threshold=0, toughness=1e9))
    assert 1 - growth_rate / 10 * 0.5 == pytest.approx(0.52116, abs=2e-5)


def test_impossible_cracks_are_refused():
    with pytest.raises(DesignError, match="grow"):
        repeats(start=1.0, end=0.5, cycles=ONE, law=LAW)
    assert constant_shape([1.0, 2.0], Y=1.12).tolist() == [1.12, 1.12]
