"""Tendencies of damage: more stress, mean, roughness or scatter never does less harm."""

import math
from functools import partial

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cardan.core.errors import DesignError
from cardan.core.units import MPa
from cardan.physics.fatigue import sn_curve as strength
from cardan.physics.fatigue.damage import (
    MAX_OMITTED_DAMAGE_SHARE,
    LifeEstimate,
    damage_to_stress_exponent,
    damage_with_omission,
    miner_damage,
    repeats_at_failure_probabilities,
)
from cardan.physics.fatigue.mean_stress import fkm, gerber, goodman, swt, uncorrected, walker
from cardan.physics.fatigue.rainflow import FromToMatrix, half_cycles, rainflow
from cardan.physics.fatigue.sn_curve import SNCurve

CURVE = SNCurve(amplitude=100 * MPa, cycles=2e6, slope=5, scatter=0.05)
CORRECTIONS = {
    "goodman": partial(goodman, ultimate=700 * MPa),
    "gerber": partial(gerber, ultimate=700 * MPa),
    "swt": swt,
    "walker": partial(walker, exponent=0.65),
    "fkm": partial(fkm, sensitivity=0.2),
}
stress = st.floats(1, 600).map(lambda s: s * MPa)
modest = settings(max_examples=60)


def history(seed=0, scale=80):
    return scale * MPa * np.random.default_rng(seed).normal(size=4000)


@pytest.mark.parametrize("name", CORRECTIONS)
@modest
@given(amplitude=stress, mean=st.floats(-600, 600), more=st.floats(0, 100))
def test_larger_mean_stress_never_reduces_damage(name, amplitude, mean, more):
    correct = CORRECTIONS[name]
    low, high = correct(amplitude, mean * MPa), correct(amplitude, (mean + more) * MPa)
    assert high >= low * (1 - 1e-12)


@pytest.mark.parametrize("name", CORRECTIONS)
def test_zero_mean_stress_needs_no_correction(name):
    assert CORRECTIONS[name](np.array([5.0]), np.zeros(1)) == pytest.approx(5.0, rel=1e-14)


def test_mean_stress_at_strength_gives_immediate_failure():
    assert CORRECTIONS["goodman"](1.0, 700 * MPa) == math.inf
    assert CORRECTIONS["gerber"](1.0, 800 * MPa) == math.inf


@modest
@given(amplitude=stress)
def test_damage_increases_from_original_to_modified_to_elementary(amplitude):
    harm = [c.damage(amplitude) for c in (CURVE.original(), CURVE.modified(), CURVE.elementary())]
    assert harm == sorted(harm)


@modest
@given(amplitude=stress, factor=st.floats(1, 2))
def test_sn_curve_damage_follows_its_slopes(amplitude, factor):
    if amplitude > CURVE.amplitude:
        growth = CURVE.damage(factor * amplitude) / CURVE.damage(amplitude)
        assert growth == pytest.approx(factor**5, rel=1e-9)
    if factor * amplitude < CURVE.amplitude:
        curve = CURVE.modified()
        assert curve.damage(factor * amplitude) / curve.damage(amplitude) == pytest.approx(
            factor**9, rel=1e-9
        )


def test_half_repeats_give_half_damage():
    x = history()
    cycles = rainflow(x)
    whole = miner_damage(cycles, curve=CURVE)
    assert miner_damage(cycles.repeated(0.5), curve=CURVE) == pytest.approx(whole / 2, rel=1e-12)


def test_rainflow_matrix_damage_matches_cycle_damage():
    """Ends fall uniformly in their bins: E ΔS² = w²/6, so the bias is k(k-1)/2 · w²/6R²."""
    cycles = rainflow(history())
    matrix = FromToMatrix.empty().with_cycles(cycles)
    curve = CURVE.elementary()
    binned, exact = miner_damage(matrix.cycles(), curve=curve), miner_damage(cycles, curve=curve)
    typical = np.average(cycles.range**5, weights=cycles.count) ** (1 / 5)
    assert abs(binned / exact - 1) < 10 * 10 * (matrix.width / typical) ** 2 / 6
    assert abs(binned / exact - 1) < 1e-3


def test_damage_exponent_of_single_slope_curve_is_its_slope():
    assert damage_to_stress_exponent(
        rainflow(history()), curve=CURVE.elementary()
    ) == pytest.approx(5, rel=1e-6)
    bent = damage_to_stress_exponent(rainflow(history()), curve=CURVE.modified())
    assert 5 < bent < 9


def test_larger_scatter_shortens_life_at_ten_percent_failure():
    cycles = rainflow(history())
    sure = repeats_at_failure_probabilities(cycles, curve=CURVE)
    unsure = repeats_at_failure_probabilities(cycles, curve=CURVE, gauge_error=0.1)
    assert unsure[0.1] < sure[0.1] < sure[0.5] < sure[0.9] < unsure[0.9]
    assert unsure[0.5] == sure[0.5]


def test_strength_and_gauge_scatter_add_as_squares():
    """Of independent lognormals; 10 % of the scale is √ln 1.01 / ln 10 = 0.04332 in log10."""
    z, gauge = 1.2815515655446004, math.sqrt(math.log(1.01)) / math.log(10)
    assert gauge == pytest.approx(0.04332, abs=5e-6)
    straight = SNCurve(amplitude=100 * MPa, cycles=2e6, slope=5, slope_beyond_knee=5, scatter=0.05)
    found = repeats_at_failure_probabilities(rainflow(history()), curve=straight, gauge_error=0.1)
    both = math.sqrt(0.05**2 + gauge**2)
    assert found[0.1] / found[0.5] == pytest.approx(10 ** (-5 * z * both), rel=1e-9)


def test_probability_curves_are_separated_by_scatter():
    z = 1.2815515655446004  # the normal deviate of 90 %
    assert CURVE.at_failure_share(0.1).amplitude == pytest.approx(
        100 * MPa * 10 ** (-0.05 * z), rel=1e-12
    )
    assert CURVE.at_failure_share(0.1).at_failure_share(0.5).amplitude == pytest.approx(
        100 * MPa, rel=1e-12
    )


def test_life_scales_with_duration_of_use():
    life = LifeEstimate(damage=1e-4, duration=7200, distance=90e3, allowed=0.5)
    assert life.repeats == pytest.approx(5000)
    assert life.hours == pytest.approx(10_000)
    assert life.kilometres == pytest.approx(450_000)
    assert LifeEstimate(damage=0.0, duration=1.0).hours == math.inf


def test_rougher_and_larger_parts_have_lower_strength():
    finishes = ["ground", "machined", "hot-rolled", "as-forged"]
    factors = [strength.surface_factor(f, ultimate=700 * MPa) for f in finishes]
    assert factors == sorted(factors, reverse=True)
    sizes = [strength.size_factor(d) for d in (0.003, 0.02, 0.05, 0.0511, 0.2)]
    assert sizes == sorted(sizes, reverse=True)


def test_steel_sn_curve_passes_through_its_two_points():
    curve = strength.steel_sn_curve(700 * MPa, endurance=200 * MPa)
    assert curve.life(630 * MPa) == pytest.approx(1e3, rel=1e-9)
    assert curve.life(200 * MPa) == pytest.approx(1e6, rel=1e-9)
    assert curve.life(199 * MPa) == math.inf
    assert curve.damage(700 * MPa) == 1


@pytest.mark.parametrize(
    "change",
    [
        {"slope": 0},
        {"cycles": -1},
        {"amplitude": math.nan},
        {"slope_beyond_knee": 3},
        {"failure": 1.0},
    ],
)
def test_invalid_sn_curve_is_rejected(change):
    with pytest.raises(DesignError, match="must"):
        SNCurve(**{"amplitude": 1e8, "cycles": 1e6, "slope": 5.0} | change)


def test_amplitude_is_unchanged_without_mean_stress_correction():
    assert uncorrected([3.0], [9.0]) == [3.0]


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("slope", [2, 3, 5, 9])
@pytest.mark.parametrize("name", [None, "goodman", "fkm"])
def test_omitted_small_cycles_stay_within_stated_damage_share(seed, slope, name):
    """Against every cycle of it counted: steep curves leave most out, flat ones hardly any."""
    rng = np.random.default_rng(seed)
    x = 30 * MPa + 20 * MPa * rng.normal(size=4000) * rng.lognormal(0, 1, 4000)
    x[rng.integers(0, 4000, 50)] = np.nan
    correct = uncorrected if name is None else CORRECTIONS[name]
    for curve in (SNCurve(amplitude=100 * MPa, cycles=2e6, slope=slope).modified(),
                  SNCurve(amplitude=100 * MPa, cycles=2e6, slope=slope).elementary()):  # fmt: skip
        every = miner_damage(rainflow(x), curve=curve, correction=correct)
        told = damage_with_omission(x, rule=half_cycles, curve=curve, correction=correct)
        assert every * (1 - MAX_OMITTED_DAMAGE_SHARE) <= told <= every * (1 + 1e-12)
    assert damage_with_omission(np.full(9, 5.0), rule=half_cycles, curve=CURVE) == 0
