"""Gauges and a torque that cannot be of one bearing: signs, scales and exchanges made by hand."""

import numpy as np
import pytest

from cardan.study.agreement import ALL, BACKWARDS, ONE, OTHER, backwards, disagreeing, unlike

GAUGES = "S1", "S2", "S3", "S4"
UNITS = 1e3 * np.array(
    [(-5.3, -29.3, -3.8), (-5.3, 29.7, -3.9), (-2.5, 45.1, 6.7), (0.0, 0.1, -13.9)]
)


def cuts(seed=0, *, units=UNITS, hiss=0.02e6, windows=80):
    """What gauges read of a force that turns, 100 N sideways and 60 up, and of their own hiss."""
    rng = np.random.default_rng(seed)

    def drawn(*shape):
        return (rng.normal(size=shape) + 1j * rng.normal(size=shape)) / np.sqrt(2)

    force = np.array([[0.0], [100.0], [60.0]]) * drawn(3, windows)
    shape = (len(units), windows)
    return units @ force + hiss * drawn(*shape), np.full(shape, hiss)


def asked(order2, noise, of=slice(None)):
    found = disagreeing(order2[of], noise[of], units=UNITS[of], gauges=GAUGES[of])
    return found and (found.text, dict(found.values))


@pytest.mark.parametrize("seed", range(20))
def test_scales_and_places_as_they_are_glued_contradict_nobody(seed):
    rng = np.random.default_rng(100 + seed)
    assert asked(*cuts(seed, units=UNITS * np.exp(rng.normal(0, 0.1, (4, 3))))) is None


@pytest.mark.parametrize("gauge", range(3))  # what goes up S4 alone feels: it contradicts nobody
@pytest.mark.parametrize("factor", [-1.0, 0.45, 2.5])
def test_one_that_is_wrong_is_named_with_what_it_reads(gauge, factor):
    order2, noise = cuts(gauge)
    order2[gauge] *= factor
    text, values = asked(order2, noise)
    assert text == ONE
    assert values["gauge"] == GAUGES[gauge]
    assert float(values["ratio"]) == pytest.approx(factor, rel=0.1)


def test_two_exchanged_contradict_the_rest():
    """By mirror image S1 and S2 exchanged are S3 the other way round: which, nobody can tell."""
    order2, noise = cuts()
    text, values = asked(order2[[1, 0, 2, 3]], noise)
    assert text == ONE
    assert (values["gauge"], float(values["ratio"])) == ("S3", pytest.approx(-1, abs=0.1))
    assert asked(order2[[0, 1, 3, 2]], noise) == (ALL, {})


def test_one_of_three_is_not_named_and_two_agree_with_any_force():
    order2, noise = cuts()
    order2[2] *= -1
    assert asked(order2, noise, slice(3)) == (ALL, {})
    assert asked(order2, noise, slice(2)) is None


def test_noise_and_holes_contradict_nobody():
    """An order that is half hiss, of gauges each of its own."""
    order2, noise = cuts(hiss=3e6)
    assert asked(order2, noise) is None
    order2[1, 5:] = np.nan
    assert asked(order2, noise) is None


def test_a_torque_that_brakes_while_the_shaft_gains_speed_has_the_wrong_sign():
    """Newton's law of a truck on hills: d ω/dt goes with torque less drag and slope."""
    rng = np.random.default_rng(1)
    rate, n = 50.0, 20_000
    torque = 1000 * np.sin(2 * np.pi * np.arange(n) / n * 13) + 300
    slope = 400 * np.interp(np.arange(n), np.arange(0, n + 500, 500), rng.normal(size=n // 500 + 1))
    speed = np.maximum(20 + np.cumsum(torque - 300 - slope) / rate * 2e-3, 0.0)
    assert backwards(torque, speed, rate=rate) is None
    assert backwards(-torque, speed, rate=rate).text == BACKWARDS
    assert backwards(-torque, np.full(n, 20.0), rate=rate) is None
    assert backwards(-torque, 0.4 * speed / speed.max(), rate=rate) is None  # it hardly turned


@pytest.mark.parametrize(("share", "found"), [(0.3, None), (0.7, OTHER)])
def test_a_line_that_leaves_most_of_an_order_is_another(share, found):
    """Shares of energy, with as much noise as there is order; that is nobody's."""
    rng = np.random.default_rng(2)
    noise = rng.normal(size=(2, 3, 4000))
    hiss = (noise[0] + 1j * noise[1]) / np.sqrt(2)
    order2 = np.ones((3, 4000), complex)
    told = unlike(order2 + hiss, np.ones((3, 4000)), order2 * (1 - np.sqrt(share)))
    assert (told and told.text) == found
