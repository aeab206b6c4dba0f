"""What is wrong with a channel is found, counted and mended, wherever the cuts fall."""

import numpy as np
import pytest

from cardan.base.errors import DesignError
from cardan.fatigue.conditioning import (
    band_pass,
    bridged,
    high_pass,
    low_pass,
    mended,
    no_zero,
    overlapping,
    slow_drift,
    survey,
    zero_at_median,
    zero_at_start,
)
from cardan.fatigue.recording import cut

RATE = 1000.0
RNG = np.random.default_rng(0)


def signal(n=60_000):
    t = np.arange(n) / RATE
    return 20 * np.sin(2 * np.pi * 11 * t) + RNG.normal(size=n)


def look(x, size=7000, **how):
    return survey(cut([np.atleast_2d(x)], size=size), rate=RATE, **how)[0]


def test_a_healthy_channel_has_nothing_to_say():
    health = look(signal())
    assert health.findings(rate=RATE) == []
    assert health.spikes == health.clipped == health.missing == 0


def test_its_numbers_are_those_of_the_whole():
    x = 1e6 + signal()
    health = look(x)
    assert health.mean == pytest.approx(x.mean(), rel=1e-12)
    assert health.deviation == pytest.approx(x.std(), rel=1e-9)
    assert (health.low, health.high) == (x.min(), x.max())


@pytest.mark.parametrize("size", [500, 7000, 100_000])
def test_faults_are_counted_whatever_the_cuts(size):
    x = signal()
    at = np.array([500, 6999, 7000, 20_000, 41_234])
    x[at] += 200
    x[30_000:30_003] = -300
    x[50_000:50_250] = np.nan
    x[13_990:14_010] = x[13_990]
    health = look(x, size=size)
    assert health.spikes == 8
    assert (health.missing, health.longest_hole) == (250, 250)
    assert health.longest_flat == 20
    assert [s for s in health.findings(rate=RATE) if "250 samples missing" in s]
    assert [s for s in health.findings(rate=RATE) if "8 samples are spikes" in s]


def test_holes_longer_than_pieces_are_one_hole():
    x = signal(20_000)
    x[3210:9876] = np.nan
    assert look(x, size=500).longest_hole == 6666


@pytest.mark.parametrize("size", [500, 7000, 100_000])
def test_clipping_is_found(size):
    x = np.clip(signal(), -18, 25)
    health = look(x, size=size)
    runs = np.flatnonzero(np.diff(np.concatenate([[0], x == -18, [0]])))
    long = runs[1::2] - runs[::2]
    assert health.clipped == long[long >= 4].sum() > 1000


def test_dead_channels_are_dead():
    assert look(np.full(5000, 3.0)).dead
    assert look(np.full(5000, np.nan)).dead
    assert look(np.full(5000, 3.0)).findings(rate=RATE) == ["dead: it never changes"]


def test_drift_is_seen_and_taken_off():
    n = 400_000
    creep = np.linspace(0, 100, n)
    x = (signal(n) + creep)[None]
    health = look(x, span=5.0)
    assert health.drift == pytest.approx(90, abs=1)  # medians of first and last tenth
    assert any("drifts" in s for s in health.findings(rate=RATE))
    base = [slow_drift(health, spans=5)]
    flat = np.concatenate(list(mended(cut([x], size=7000), healths=[health], baseline=base)), -1)
    steady = slice(20_000, -20_000)
    np.testing.assert_allclose(flat[0, steady], (x[0] - creep)[steady], atol=1.0)


def test_zeros():
    x = np.concatenate([np.full(20_000, 5.0), np.full(80_000, 9.0)]) + 1e-3 * signal(100_000)
    health = look(x)
    assert zero_at_start(health) == pytest.approx(np.full(10, 5.0), abs=1e-2)
    assert zero_at_median(health) == pytest.approx(np.full(10, 9.0), abs=1e-2)
    assert (no_zero(health) == 0).all()


def test_mending_bridges_spikes_and_leaves_the_rest():
    x = signal()
    good = x.copy()
    x[[500, 7000, 7001]] += 400
    x[90:95] = np.nan
    out = np.concatenate(list(mended(cut([x[None]], size=7000), healths=[look(x)])), axis=-1)[0]
    same = np.ones(x.size, bool)
    same[[500, 7000, 7001, *range(90, 95)]] = False
    np.testing.assert_array_equal(out[same], good[same])
    assert np.isnan(out[90:95]).all()
    assert abs(out[[500, 7000, 7001]] - good[[500, 7000, 7001]]).max() < 8


def test_a_sharp_event_is_not_a_spike():
    """Half a sine of 10 ms, ten times the rest: real, and left alone."""
    x = signal()
    x[30_000:30_010] += 200 * np.sin(np.pi * np.arange(10) / 10)
    assert look(x).spikes == 0


@pytest.mark.parametrize("sizes", [[50_000], [1, 3, 20_000, 2, 29_994], [25_000, 25_000]])
def test_filters_in_pieces_are_the_filter(sizes):
    """FFT rounding: a few 1e-16 of the largest sample."""
    x = signal(50_000)[None]
    filt = low_pass(40, rate=RATE)
    pieces = np.split(x, np.cumsum(sizes)[:-1], axis=1)
    out = np.concatenate(list(filt(pieces)), axis=-1)
    padded = np.pad(x[0], filt.reach, mode="edge")
    np.testing.assert_allclose(out[0], np.convolve(padded, filt.taps, "valid"), atol=1e-12)


def test_filters_do_not_shift_and_keep_their_band():
    """Kaiser's window for 80 dB: ripple 1e-4 passed, 1e-4 stopped."""
    t = np.arange(20_000) / RATE
    middle = slice(5000, -5000)
    for filt, kept, lost in (
        (low_pass(40, rate=RATE), 30, 50),
        (high_pass(40, rate=RATE), 50, 30),
        (band_pass(20, 60, rate=RATE), 40, 75),
        (band_pass(20, 60, rate=RATE), 40, 15),
    ):
        good, away = np.sin(2 * np.pi * kept * t), np.sin(2 * np.pi * lost * t)
        out = np.concatenate(list(filt([(good + away)[None]])), -1)[0]
        assert abs(out - good)[middle].max() < 3e-4


def test_holes_stay_holes_through_a_filter():
    x = signal(5000)
    x[1000:1010] = np.nan
    out = next(low_pass(100, rate=RATE)([x[None]]))[0]
    assert np.isnan(out).sum() == 10


def test_nonsense_filters_are_refused():
    with pytest.raises(DesignError, match="cutoff"):
        low_pass(600, rate=RATE)
    with pytest.raises(ValueError, match="rise"):
        band_pass(60, 20, rate=RATE)
    with pytest.raises(DesignError, match="finite"):
        look(np.array([1.0, np.inf] * 100))


def test_overlapping_lends_the_neighbours():
    x = np.arange(10.0)
    parts = list(overlapping(np.split(x, [4, 8]), reach=2))
    assert parts[0].tolist() == [0, 0, 0, 1, 2, 3, 4, 5]
    assert parts[1].tolist() == [2, 3, 4, 5, 6, 7, 8, 9]
    assert parts[2].tolist() == [6, 7, 8, 9, 9, 9]


def test_bridges_are_straight():
    x = np.array([np.nan, 1, np.nan, np.nan, 4, np.nan])
    assert bridged(x).tolist() == [1, 1, 2, 3, 4, 4]
