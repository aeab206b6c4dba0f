"""Compiled loops against NumPy and SciPy doing the same, and what else is done by parts."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.signal import lfilter

from cardan.physics.signals import order_kernels as kernel
from cardan.physics.signals import order_tracking as orders
from cardan.physics.signals.conditioning import row_medians
from cardan.physics.signals.order_kernels import (
    best_predecessor_within_reach,
    bin_sums,
    modal_response,
)
from cardan.physics.signals.order_tracking import OrderComponent, OrderDecomposer, ShaftRotation


@pytest.fixture(params=["compiled", "plain"])
def loops(request, monkeypatch):
    if request.param == "plain":
        monkeypatch.setattr(kernel, "compiled", lambda _: None)


@pytest.mark.usefixtures("loops")
@pytest.mark.parametrize("seed", range(6))
def test_farthest_climb_is_maximum_of_all_options(seed):
    """Each place asked of all within reach; of equal ones the first."""
    rng = np.random.default_rng(seed)
    n, reach, slope = int(rng.integers(1, 60)), int(rng.integers(1, 20)), 0.25
    best = rng.integers(0, 8, n) * 0.5  # ties in plenty, and no rounding
    back, left = best_predecessor_within_reach(best, reach=reach, slope=slope)
    for j in range(n):
        there = np.arange(max(j - reach, 0), min(j + reach + 1, n))
        options = best[there] - slope * np.abs(there - j)
        assert left[j] == options.max()
        assert back[j] == there[options.argmax()]


@pytest.mark.usefixtures("loops")
def test_batched_modal_filters_equal_single_mode_filters():
    """A mode's memory is a filter of one pole (SciPy's)."""
    rng = np.random.default_rng(1)
    forces = rng.normal(size=(2, 400)) + 1j * rng.normal(size=(2, 400))
    spin = 1j * np.linspace(40, 90, 400)
    p = np.array([-2 + 50j, -0.5 + 80j, -9 + 20j])
    stays, share, back = np.exp(p / 100), np.array([1.0, 2.0, 0.5]), np.exp(-spin / 100)
    found = modal_response(forces, spin, back, p, stays, share)
    for one, q, kept, scale in zip(found, p, stays, share, strict=True):
        driven = forces * (kept * back - 1) * scale / (q - spin)
        np.testing.assert_allclose(one, lfilter([1], [1, -kept], driven, axis=-1), rtol=1e-9)


@pytest.mark.usefixtures("loops")
def test_scattered_values_are_summed_by_index():
    rng = np.random.default_rng(2)
    place, slot = rng.integers(-1, 7, 500), rng.integers(0, 3, 500)
    values, turn = (rng.normal(size=500) + 1j * rng.normal(size=500) for _ in range(2))
    square, speed = rng.random((2, 500))
    cells, sums = bin_sums(place, slot, values, turn, square, speed, cells=7, slots=3)
    wanted, beside = np.zeros(7, complex), np.zeros((3, 3))
    here = place >= 0
    np.add.at(wanted, place[here], (values * turn)[here])
    for row, x in zip(beside, (square, speed, np.ones(500)), strict=True):
        np.add.at(row, slot[here], x[here])
    np.testing.assert_allclose(cells, wanted, rtol=1e-12)
    np.testing.assert_allclose(sums, beside, rtol=1e-12)


@pytest.mark.parametrize("n", [1, 2, 7, 8, 1001])
@pytest.mark.parametrize("holes", [False, True])
def test_medians_equal_numpy(n, holes):
    x = np.random.default_rng(n).normal(size=(5, n)).round(1)
    if holes:
        x[0] = np.nan
        x[3, ::2] = np.nan
    some = ~np.isnan(x).all(-1)
    found = row_medians(x)
    np.testing.assert_array_equal(found[some], np.nanmedian(x[some], axis=-1))
    assert np.isnan(found[~some]).all()


def test_cached_spans_of_stretches_equal_fresh_computation(monkeypatch):
    """Spans that two stretches solve are summed once: the same as if each began anew."""
    rng = np.random.default_rng(3)
    rate, n = 200.0, 40_000
    t = np.arange(0, n / rate + 1, 0.05)
    speed = 12 + 8 * np.sin(0.1 * t)
    turning = ShaftRotation(t, np.cumsum(speed) * 0.05)
    x = rng.normal(size=(1, n)) + 5 * np.cos(2 * np.pi * turning.at(np.arange(n) / rate))
    x[0, [3000, 9590, 9700, 20_011]] += 300.0  # blows, some where two stretches meet
    x[0, 15_000:15_100] = np.nan
    splitter = OrderDecomposer(
        components=(OrderComponent(turning, 1.0), OrderComponent(turning, 2.0)), rate=rate
    )

    def parts():
        return [s.components for s in splitter.decompose([x[:, :17_000], x[:, 17_000:]])]

    kept = parts()
    none = orders._NormalEquations.none(5, splitter.span_samples)
    monkeypatch.setattr(orders._NormalEquations, "since", lambda *_: none)
    monkeypatch.setattr(
        orders._NormalEquations, "weighed",
        lambda of, weight: replace(of, weight=weight, gram=orders._gram(of.rows, weight)),
    )  # fmt: skip
    anew = parts()
    assert len(kept) == len(anew) > 3
    for one, other in zip(kept, anew, strict=True):
        np.testing.assert_allclose(one, other, rtol=0, atol=5e-6)  # of seven digits
