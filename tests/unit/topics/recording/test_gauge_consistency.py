"""Gauges and a torque that cannot be of one bearing: signs, scales and exchanges made by hand."""

import numpy as np
import pytest

from cardan.topics.recording.gauge_consistency import (
    DOUBT_ONE_INCONSISTENT_GAUGE,
    DOUBT_SEVERAL_INCONSISTENT_GAUGES,
    DOUBT_TORQUE_SIGN,
    DOUBT_WRONG_DRIVELINE_FILE,
    doubt_of_order2_unexplained_by_line,
    doubt_of_reversed_torque_sign,
    inconsistent_gauge,
)

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
    found = inconsistent_gauge(order2[of], noise[of], units=UNITS[of], gauges=GAUGES[of])
    return found and (found.text, dict(found.values))


@pytest.mark.parametrize("seed", range(20))
def test_usual_gauge_scale_scatter_is_consistent(seed):
    rng = np.random.default_rng(100 + seed)
    assert asked(*cuts(seed, units=UNITS * np.exp(rng.normal(0, 0.1, (4, 3))))) is None


@pytest.mark.parametrize("gauge", range(3))  # what goes up S4 alone feels: it contradicts nobody
@pytest.mark.parametrize("factor", [-1.0, 0.45, 2.5])
def test_inconsistent_gauge_is_named_with_its_ratio(gauge, factor):
    order2, noise = cuts(gauge)
    order2[gauge] *= factor
    text, values = asked(order2, noise)
    assert text == DOUBT_ONE_INCONSISTENT_GAUGE
    assert values["gauge"] == GAUGES[gauge]
    assert float(values["ratio"]) == pytest.approx(factor, rel=0.1)


def test_exchanged_gauges_are_inconsistent():
    """By mirror image S1 and S2 exchanged are S3 the other way round: which, nobody can tell."""
    order2, noise = cuts()
    text, values = asked(order2[[1, 0, 2, 3]], noise)
    assert text == DOUBT_ONE_INCONSISTENT_GAUGE
    assert (values["gauge"], float(values["ratio"])) == ("S3", pytest.approx(-1, abs=0.1))
    assert asked(order2[[0, 1, 3, 2]], noise) == (DOUBT_SEVERAL_INCONSISTENT_GAUGES, {})


def test_inconsistent_gauge_of_three_is_not_named():
    order2, noise = cuts()
    order2[2] *= -1
    assert asked(order2, noise, slice(3)) == (DOUBT_SEVERAL_INCONSISTENT_GAUGES, {})
    assert asked(order2, noise, slice(2)) is None


def test_noise_and_missing_samples_are_consistent():
    """An order that is half hiss, of gauges each of its own."""
    order2, noise = cuts(hiss=3e6)
    assert asked(order2, noise) is None
    order2[1, 5:] = np.nan
    assert asked(order2, noise) is None


def test_torque_opposing_shaft_acceleration_has_wrong_sign():
    """Newton's law of a truck on hills: d ω/dt goes with torque less drag and slope."""
    rng = np.random.default_rng(1)
    rate, n = 50.0, 20_000
    torque = 1000 * np.sin(2 * np.pi * np.arange(n) / n * 13) + 300
    slope = 400 * np.interp(np.arange(n), np.arange(0, n + 500, 500), rng.normal(size=n // 500 + 1))
    speed = np.maximum(20 + np.cumsum(torque - 300 - slope) / rate * 2e-3, 0.0)
    assert doubt_of_reversed_torque_sign(torque, speed, rate=rate) is None
    assert doubt_of_reversed_torque_sign(-torque, speed, rate=rate).text == DOUBT_TORQUE_SIGN
    assert doubt_of_reversed_torque_sign(-torque, np.full(n, 20.0), rate=rate) is None
    assert (
        doubt_of_reversed_torque_sign(-torque, 0.4 * speed / speed.max(), rate=rate) is None
    )  # it hardly turned


@pytest.mark.parametrize(("share", "found"), [(0.3, None), (0.7, DOUBT_WRONG_DRIVELINE_FILE)])
def test_driveline_leaving_most_of_order_unexplained_is_doubted(share, found):
    """Shares of energy, with as much noise as there is order; that is nobody's."""
    rng = np.random.default_rng(2)
    noise = rng.normal(size=(2, 3, 4000))
    hiss = (noise[0] + 1j * noise[1]) / np.sqrt(2)
    order2 = np.ones((3, 4000), complex)
    told = doubt_of_order2_unexplained_by_line(
        order2 + hiss, np.ones((3, 4000)), order2 * (1 - np.sqrt(share))
    )
    assert (told and told.text) == found
