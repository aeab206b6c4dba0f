"""What is wrong with a channel is found and counted, wherever the cuts fall, and kept."""

import tracemalloc

import numpy as np
import pytest
from scipy.signal import butter, lfilter

from cardan.core.errors import DesignError
from cardan.core.finding import Finding
from cardan.physics.signals.conditioning import (
    FINDING_DEAD,
    Conditioning,
    baseline_at_median,
    baseline_at_start,
    condition_pieces,
    interpolate_gaps,
    low_pass,
    no_baseline,
    overlapping_pieces,
    running_median_baseline,
    survey_channel_signals,
    upsample,
)
from cardan.physics.signals.faults.fault_kind import ChannelStatistics, SignalBlock
from cardan.physics.signals.faults.intermittent_contact import IntermittentContactDetector
from cardan.physics.signals.faults.intervals import NO_FAULTS, FaultIntervals, merge_runs
from cardan.physics.signals.faults.mains_hum import MainsHumDetector
from cardan.physics.signals.recording import rechunk_to_block_size, recording_from_arrays

STATISTICS = ChannelStatistics(
    alive=True, deviation=1.0, typical_swing=1.0, levels=np.empty(0), swings=np.empty(0), span=1
)
RATE = 1000.0
RNG = np.random.default_rng(0)


def signal(n=60_000):
    t = np.arange(n) / RATE
    return 20 * np.sin(2 * np.pi * 11 * t) + RNG.normal(size=n)


def look(x, size=7000, **how):
    return survey_channel_signals(
        rechunk_to_block_size([np.atleast_2d(x)], size=size), rate=RATE, **how
    )[0]


def test_sound_channel_has_no_findings():
    health = look(signal())
    assert health.findings(rate=RATE) == []
    assert health.spikes == health.clipped == health.missing == 0


def test_channel_statistics_match_whole_signal():
    x = 1e6 + signal()
    health = look(x)
    assert health.mean == pytest.approx(x.mean(), rel=1e-12)
    assert health.deviation == pytest.approx(x.std(), rel=1e-9)
    assert (health.low, health.high) == (x.min(), x.max())


@pytest.mark.parametrize("size", [500, 7000, 100_000])
def test_fault_counts_do_not_depend_on_chunk_size(size):
    x = signal()
    at = np.array([500, 6999, 7000, 20_000, 41_234])
    x[at] += 200
    x[30_000:30_003] = -300
    x[50_000:50_250] = np.nan
    x[13_900:14_050] = x[13_900]
    health = look(x, size=size)
    assert health.spikes == 8
    assert (health.missing, health.longest_hole) == (250, 250)
    assert health.longest_flat == 150
    found = {f.code: dict(f.values) for f in health.findings(rate=RATE)}
    assert found["hole"]["missing"] == 250
    assert (found["spike"]["samples"], found["spike"]["places"]) == (8, 5)


def test_gap_longer_than_chunk_is_one_gap():
    x = signal(20_000)
    x[3210:9876] = np.nan
    assert look(x, size=500).longest_hole == 6666


@pytest.mark.parametrize("size", [500, 7000, 100_000])
def test_clipping_is_detected(size):
    x = np.clip(signal(), -18, 25)
    health = look(x, size=size)
    runs = np.flatnonzero(np.diff(np.concatenate([[0], x == -18, [0]])))
    long = runs[1::2] - runs[::2]
    assert health.clipped == long[long >= 2].sum() > 1000


def test_clipping_of_fast_peaks_is_detected():
    """Twelve samples a swing: a cut leaves two or three of them level, which went unseen."""
    t = np.arange(20_000) / 500
    # In steps of 0.01, as a logger writes.
    x = np.round(np.sin(0.3 * t) ** 2 * 100 * np.sin(2 * np.pi * 40.3 * t), 2)
    assert not look(x).clipped
    cut = np.clip(x, -70, 70)
    edge = np.flatnonzero(np.diff(np.concatenate([[0], np.abs(cut) == 70, [0]])))
    level = edge[1::2] - edge[::2]
    assert look(cut).clipped == level[level >= 2].sum() > 100
    # One crest of all, three samples of it: what came so fast does not rest at once.
    x[9000:9007] = [-20.0, 61.5, 101.07, 101.07, 101.07, 52.3, -31.0]
    assert look(x).clipped == 3
    # In coarse steps it may.
    assert not look(np.round(x / 4) * 4).clipped
    # Level by chance: a steady swing in coarse steps, whose crests are sampled alike.
    steady = np.round(20 * np.sin(2 * np.pi * 41.6666 * t + 0.2618))
    assert not look(steady).clipped


def test_constant_or_empty_channel_is_dead():
    assert look(np.full(5000, 3.0)).dead
    assert look(np.full(5000, np.nan)).dead
    assert look(np.full(5000, 3.0)).findings(rate=RATE) == [FINDING_DEAD]


def test_drift_is_detected_and_removed():
    n = 400_000
    creep = np.linspace(0, 100, n)
    x = (signal(n) + creep)[None]
    health = look(x, span=5.0)
    assert health.drift == pytest.approx(90, abs=1)  # medians of first and last tenth
    drift = Finding("drift").with_values(drift=health.drift, unit="MPa")
    assert drift in health.findings(rate=RATE, unit="MPa")
    way = [Conditioning(baseline=running_median_baseline(health, spans=5), span=health.span)]
    flat = np.concatenate(
        [one for (one,) in condition_pieces(rechunk_to_block_size([x], size=7000), how=[way])], -1
    )
    steady = slice(20_000, -20_000)
    np.testing.assert_allclose(flat[0, steady], (x[0] - creep)[steady], atol=1.0)


def test_zero_level_is_taken_from_start_or_median():
    x = np.concatenate([np.full(20_000, 5.0), np.full(80_000, 9.0)]) + 1e-3 * signal(100_000)
    health = look(x)
    assert baseline_at_start(health) == pytest.approx(np.full(10, 5.0), abs=1e-2)
    assert baseline_at_median(health) == pytest.approx(np.full(10, 9.0), abs=1e-2)
    assert (no_baseline(health) == 0).all()


def test_masked_samples_become_gaps_and_others_are_unchanged():
    x = signal()
    x[90:95] = np.nan
    masked = np.array([[500, 501], [6998, 7002]], np.intp)
    ways = [[Conditioning()], [Conditioning(masked=masked)]]
    parts = [
        list(p) for p in condition_pieces(rechunk_to_block_size([x[None]], size=7000), how=ways)
    ]
    kept, out = (np.concatenate([p[k] for p in parts], axis=-1)[0] for k in (0, 1))
    np.testing.assert_array_equal(kept, x)
    holes = [*range(90, 95), 500, *range(6998, 7002)]
    assert np.flatnonzero(np.isnan(out)).tolist() == holes
    same = np.setdiff1d(np.arange(x.size), holes)
    np.testing.assert_array_equal(out[same], x[same])


def test_short_half_sine_is_not_a_spike():
    """Half a sine of 10 ms, ten times the rest: real, and left alone."""
    x = signal()
    x[30_000:30_010] += 200 * np.sin(np.pi * np.arange(10) / 10)
    assert look(x).faults == {}


def rings(n=60_000, hertz=200.0, decay=60.0):
    """Blows that ring 100 high every 0.7 s, in noise of 1."""
    x, s = RNG.normal(size=n), np.arange(200) / RATE
    for k in range(100, n - 200, 700):
        x[k : k + 200] += 100 * np.exp(-decay * s) * np.sin(2 * np.pi * hertz * s)
    return x


def blows(n=60_000, samples=4.0):
    """Half sines 170 high of 4 ms, wherever between samples they begin."""
    x = RNG.normal(size=n)
    for k in range(100, n - 200, 700):
        u = np.arange(6) + RNG.uniform()
        x[k : k + 6] += np.where(u < samples, 170 * np.sin(np.pi * u / samples), 0)
    return x


def coarse(n=200_000):
    """0.05 Hz written in steps of 0.05: crests stand still for a second."""
    return np.round(20 * 50 * np.sin(2 * np.pi * 0.05 * np.arange(n) / RATE)) / 20


@pytest.mark.parametrize("x", [rings(), blows(), coarse()], ids=["rings", "blows", "coarse"])
def test_real_fast_or_slow_signal_is_not_a_fault(x):
    """200 Hz rings and 4 ms blows had been mended away; slow crests had been shaved."""
    assert look(x).faults == {}


FAULTS = {
    "spike on the first sample": (lambda x: x.__setitem__(0, 400), "spike", 1),
    "spike on the last sample": (lambda x: x.__setitem__(-1, 400), "spike", 1),
    "dropouts of 8": (lambda x: x.__setitem__(slice(3000, 3008), 400), "dropout", 8),
    "sentinels": (lambda x: x.__setitem__(slice(3000, 3005), -9999.0), "sentinel", 5),
    "frozen": (lambda x: x.__setitem__(slice(3000, 4000), x[3000]), "freeze", 1000),
    "a hole": (lambda x: x.__setitem__(slice(3000, 4000), np.nan), "hole", 1000),
    "clipped": (lambda x: x.__setitem__(x > 15, 15.0), "clip", None),
}


@pytest.mark.parametrize("size", [700, 60_000])
@pytest.mark.parametrize("name", FAULTS)
def test_each_fault_is_classified_by_kind(name, size):
    spoil, kind, samples = FAULTS[name]
    x = signal(20_000)
    spoil(x)
    found = look(x, size=size).faults
    assert set(found) == {kind}
    wanted = samples
    if samples is None:
        edge = np.flatnonzero(np.diff(np.concatenate([[0], x == 15, [0]])))
        long = edge[1::2] - edge[::2]
        wanted = long[long >= 2].sum()
    assert found[kind].sample_count == wanted


def road(n=60_000, *, seed=1):
    """Up to 30 Hz, 10 in the mean."""
    x = lfilter(*butter(2, 0.06), np.random.default_rng(seed).normal(size=n))
    return 10 * x / x.std()


AFTERWARDS = {
    "noise of a thousandth": lambda x, rng: x + 0.01 * rng.normal(size=x.size),
    "noise of a hundredth": lambda x, rng: x + 0.1 * rng.normal(size=x.size),
    "a filter": lambda x, _: lfilter(*butter(2, 0.6), x),
}


@pytest.mark.parametrize("sign", [1, -1])
@pytest.mark.parametrize("share", [0.9, 0.97, 0.99])
@pytest.mark.parametrize("then", AFTERWARDS)
def test_clipping_is_detected_after_noise_and_filtering(then, share, sign):
    """Life came out three to four times too long, and nothing was suspected."""
    x = sign * road()
    cut_off = AFTERWARDS[then](np.minimum(x, np.quantile(x, share)), np.random.default_rng(7))
    found = look(cut_off).faults
    assert set(found) == {"clip"}
    # A fifth at least of what was beyond, where crests of four samples and more were.
    assert found["clip"].sample_count > 0.2 * (1 - share) * x.size
    back = Conditioning(crowned=found["clip"])(cut_off, 0)
    assert cut_off.max() * 1.05 < back.max() < 1.5 * x.max()


SOUND = {
    "a sine": lambda t, rng: 20 * np.sin(2 * np.pi * 11 * t) + 0.1 * rng.normal(size=t.size),
    "a rig of forty samples a turn": lambda t, _: 30 * np.sin(2 * np.pi * 25 * t),
    "a rig of twenty and some": lambda t, _: 30 * np.sin(2 * np.pi * 22.7 * t),
    "a rig's blocks": lambda t, rng: (
        10 * (2 + t // 4 % 3) * np.sin(2 * np.pi * 25 * t) + 0.1 * rng.normal(size=t.size)
    ),
    "a swelling sine": lambda t, _: 20 * np.sin(2 * np.pi * 11 * t) * (1 + 0.3 * np.sin(0.7 * t)),
    "steps of a sine": lambda t, _: np.round(20 * np.sin(2 * np.pi * 2 * t)),
    "pulses": lambda t, rng: (
        50 * np.sin(np.pi * np.clip(t % 0.997 / 0.06, 0, 1)) + 0.05 * rng.normal(size=t.size)
    ),
    "a road": lambda t, _: road(t.size, seed=8),
    "a road with a floor": lambda t, _: np.abs(road(t.size, seed=9)) - 1.0,
}


@pytest.mark.parametrize("name", SOUND)
def test_natural_peaks_are_not_clipped(name):
    t = np.arange(60_000) / RATE
    assert look(SOUND[name](t, np.random.default_rng(5))).faults == {}


def lost(x, n, *, noise):
    """Load and a lost contact from sample 5000 on, for so many."""
    x = x + 80
    x[5000 : 5000 + n] = noise * np.random.default_rng(4).normal(size=n)
    return x


@pytest.mark.slow
@pytest.mark.parametrize("size", [700, 60_000])
@pytest.mark.parametrize("noise", [0.0, 0.3])
@pytest.mark.parametrize("n", [260, 400, 5000, 9900])
def test_contact_lost_for_seconds_is_a_dropout(n, noise, size):
    """One of 0.4 s made the damage 46 times what it was, and nothing was suspected."""
    found = look(lost(signal(40_000), n, noise=noise), size=size).faults
    assert set(found) == {"dropout"}
    assert found["dropout"].runs.tolist() == [[5000, 5000 + n]]
    assert found["dropout"].sizes == pytest.approx([-80], abs=25)


@pytest.mark.parametrize("n", [400, 5000])
def test_filtered_dropout_is_found_with_its_flanks(n):
    """A low pass of 4th order at 200 Hz makes some samples of what stepped in one."""
    x = 20 * np.sin(2 * np.pi * 11 * np.arange(20_000) / RATE)
    x = lfilter(*butter(4, 0.4), lost(x + np.random.default_rng(6).normal(size=x.size), n, noise=0))
    ((first, last),) = look(x).faults["dropout"].runs.tolist()
    assert 5000 <= first <= 5003
    assert 5000 + n <= last <= 5000 + n + 6


def test_long_or_permanent_level_change_is_not_a_dropout():
    assert "dropout" not in look(lost(signal(40_000), 10_100, noise=0.3)).faults
    x = signal(20_000) + 80
    x[5000:6000] = 0
    x[6000:] -= 50
    assert "dropout" not in look(x).faults


@pytest.mark.parametrize("rate", [100.0, 200.0, 1000.0])
def test_torque_interruption_by_gear_change_is_not_a_dropout(rate):
    """Within 20 ms, for a second: no clutch opens within 5."""
    t = np.arange(0, 60, 1 / rate)
    rng = np.random.default_rng(2)
    x = 80 + np.sin(2 * np.pi * 9 * t) + 0.2 * rng.normal(size=t.size)
    for at in (13.0, 29.3, 47.1):
        x -= 80 * np.clip((t - at) / 0.02, 0, 1) * np.clip((at + 1 - t) / 0.02, 0, 1)
    assert survey_channel_signals([x[None]], rate=rate)[0].faults == {}


def test_plausible_sentinel_value_is_kept_as_sample():
    x = 9000 * np.sin(np.arange(20_000) * 0.03)
    x[7000] = 9999.0
    assert "sentinel" not in look(x).faults


def test_clipped_peaks_are_reconstructed_approximately():
    """A parabola through the flanks of a sine cut at half its height, met a bit below the cut."""
    x = 20 * np.sin(2 * np.pi * 3 * np.arange(20_000) / RATE) + 1e-6 * signal(20_000)
    cut_off = np.clip(x, -100, 10)
    clips = look(cut_off).faults["clip"]
    whole = Conditioning(crowned=clips)(cut_off, 0)
    assert whole.max() == pytest.approx(20, rel=0.1)
    parts = [
        Conditioning(crowned=clips)(p, k * 700)
        for k, p in enumerate(np.split(cut_off, range(700, 20_000, 700)))
    ]
    np.testing.assert_array_equal(np.concatenate(parts), whole)


def test_peaks_between_samples_are_reconstructed():
    """A tone at 0.3 of the rate has 3.3 samples a turn: its crests come back to 1e-4."""
    t = np.arange(20_000) / RATE
    x = np.sin(2 * np.pi * 300 * t + 0.1)
    assert look(x).crest_loss > 0.02
    assert look(np.sin(2 * np.pi * 30 * t)).crest_loss < 0.002
    for size in (300, 7000, 50_000):
        fine = np.concatenate(list(upsample(rechunk_to_block_size([x[None]], size=size))), -1)[0]
        there = np.sin(2 * np.pi * 300 * np.arange(fine.size) / (8 * RATE) + 0.1)
        np.testing.assert_allclose(fine[800:-800], there[800:-800], atol=1e-4)
    x[5000:5010] = np.nan
    fine = next(upsample([x[None]]))[0]
    assert np.isnan(fine).sum() == 80


def test_overlapping_runs_are_merged():
    rows = [np.array([[5, 9], [20, 30]], np.intp), np.array([[8, 12], [12, 13], [40, 41]], np.intp)]
    assert merge_runs(rows).tolist() == [[5, 13], [20, 30], [40, 41]]
    assert FaultIntervals(merge_runs(rows), np.zeros(3)).sample_count == 19


@pytest.mark.parametrize("sizes", [[50_000], [1, 3, 20_000, 2, 29_994], [25_000, 25_000]])
def test_filter_in_chunks_equals_whole_filter(sizes):
    """FFT rounding: a few 1e-16 of the largest sample."""
    x = signal(50_000)[None]
    filt = low_pass(40, rate=RATE)
    pieces = np.split(x, np.cumsum(sizes)[:-1], axis=1)
    out = np.concatenate(list(filt(pieces)), axis=-1)
    padded = np.pad(x[0], filt.reach, mode="edge")
    np.testing.assert_allclose(out[0], np.convolve(padded, filt.taps, "valid"), atol=1e-12)


def test_low_pass_has_zero_phase_and_keeps_its_band():
    """Kaiser's window for 80 dB: ripple 1e-4 passed, 1e-4 stopped."""
    t = np.arange(20_000) / RATE
    middle = slice(5000, -5000)
    good, away = np.sin(2 * np.pi * 30 * t), np.sin(2 * np.pi * 50 * t)
    out = np.concatenate(list(low_pass(40, rate=RATE)([(good + away)[None]])), -1)[0]
    assert abs(out - good)[middle].max() < 3e-4


def test_gaps_remain_after_filtering():
    x = signal(5000)
    x[1000:1010] = np.nan
    out = next(low_pass(100, rate=RATE)([x[None]]))[0]
    assert np.isnan(out).sum() == 10


def test_invalid_filter_is_rejected():
    with pytest.raises(DesignError, match="cutoff"):
        low_pass(600, rate=RATE)
    with pytest.raises(DesignError, match="finite"):
        look(np.array([1.0, np.inf] * 100))


def test_overlapping_chunks_include_neighbour_samples():
    x = np.arange(10.0)
    parts = list(overlapping_pieces(np.split(x, [4, 8]), reach=2))
    assert parts[0].tolist() == [0, 0, 0, 1, 2, 3, 4, 5]
    assert parts[1].tolist() == [2, 3, 4, 5, 6, 7, 8, 9]
    assert parts[2].tolist() == [6, 7, 8, 9, 9, 9]


def test_gaps_are_bridged_linearly():
    x = np.array([np.nan, 1, np.nan, np.nan, 4, np.nan])
    assert interpolate_gaps(x).tolist() == [1, 1, 2, 3, 4, 4]


def shaken(seed, step=0.01, mode=60.0):
    """Two minutes of a mode of 60 Hz shaken by noise, 500 samples a second, in steps of MPa."""
    rng = np.random.default_rng(seed)
    r = np.exp(-0.02 * 2 * np.pi * mode / 500)
    x = lfilter([1], [1, -2 * r * np.cos(2 * np.pi * mode / 500), r * r], rng.normal(size=60_000))
    return np.round(12 * x / x.std() / step) * step


@pytest.mark.slow
@pytest.mark.parametrize("part", [0.75, 0.85, 0.92])
def test_few_equal_fast_peaks_are_detected_as_clipping(part):
    """One or two samples each, so that nothing is level: but chance makes no five alike."""
    asked = 0
    for seed in range(10):
        x = shaken(seed)
        assert "clip" not in look(x).faults
        top = np.round(part * np.abs(x).max() / 0.01) * 0.01
        over = [np.flatnonzero(np.diff((s * x >= top).astype(int)) == 1) + 1 for s in (1, -1)]
        found = look(np.clip(x, -top, top)).faults.get("clip", NO_FAULTS).runs[:, 0]
        for crests in over:
            if crests.size > 4:
                asked += 1
                assert set(crests.tolist()) <= set(found.tolist())
    assert asked > 5


@pytest.mark.slow
def test_peaks_equal_by_chance_are_not_clipping():
    """In coarse steps; on a bench that repeats a minute; of one amplitude."""
    for seed in range(20):
        assert "clip" not in look(shaken(seed, step=2.0)).faults
    assert "clip" not in look(np.tile(shaken(3)[:10_000], 6)).faults
    t = np.arange(60_000) / 500
    assert "clip" not in look(np.round(40 * np.sin(2 * np.pi * 50 * t) / 0.01) * 0.01).faults


@pytest.mark.slow
def test_survey_memory_does_not_grow_with_recording_length():
    """A day of five gauges took 2.8 GB: one sample of a thousand, as a view, held its whole piece.

    What has to be remembered is a sixth of a byte a sample: fingerprints, levels, heights.
    """
    rng, held = np.random.default_rng(1), []

    def pieces():
        for k in range(48):
            if k == 1:
                tracemalloc.start()
            held.append(tracemalloc.get_traced_memory()[0])
            yield rng.normal(size=(1, 1 << 16))

    survey_channel_signals(pieces(), rate=RATE)
    tracemalloc.stop()
    assert held[-1] - held[16] < 0.3 * 31 * (1 << 16)


def test_rechunking_holds_each_chunk_once_in_memory():
    """Short pieces were held beside the long one that was made of them: twice its room."""
    one = np.zeros((1, 1 << 16)).nbytes

    def pieces():
        for _ in range(12):
            yield np.zeros((1, 1 << 16))

    tracemalloc.start()
    held = [
        tracemalloc.get_traced_memory()[0] for _ in rechunk_to_block_size(pieces(), size=4 << 16)
    ]
    tracemalloc.stop()
    assert max(held) < 6 * one  # the long piece, and the last short one


def test_hum_is_detected_across_batch_boundary():
    """Six seconds of it on either side of where a batch ends are no eight by themselves."""
    rate = 500
    t = np.arange(300 * rate) / rate
    on = (t >= 100) & (t < 120) | (t >= 250) & (t < 262)
    x = np.where(on, np.cos(2 * np.pi * 50 * t), 0.0)
    x += 0.1 * np.random.default_rng(4).normal(size=t.size)
    listener = MainsHumDetector(rate)
    for second in np.split(x, 300):
        listener.update(SignalBlock(second, second))
    hum = listener.hum(deviation=float(x.std()))
    assert hum is not None
    assert set(range(250, 262)) <= set(np.flatnonzero(hum.phasors[0]).tolist())


def test_intermittent_contact_is_detected_in_white_noise_channel(monkeypatch):
    """Of which nearly all blocks are let go meanwhile."""
    rng = np.random.default_rng(5)
    x = rng.normal(size=200_000)
    x[150_000:150_300] *= 12
    monkeypatch.setattr(
        "cardan.physics.signals.faults.intermittent_contact.MAX_HELD_CANDIDATE_BLOCKS", 64
    )
    chatter = IntermittentContactDetector()
    for start in range(0, x.size, 5000):
        piece = x[start : start + 5000]
        chatter.update(SignalBlock(piece, x[start:], start=start))
        assert chatter.held < 400
    (found,) = chatter.result(STATISTICS).values()
    [[first, last]] = found.runs
    assert 149_900 <= first <= 150_000
    assert 150_300 <= last <= 150_400


@pytest.mark.parametrize("kind", [np.int16, np.int32, np.uint16])
def test_integer_samples_are_surveyed_like_floats(kind):
    """They know no nan, and nothing that is beside their ends: their survey overflowed."""
    x = np.random.default_rng(0).integers(100, 3000, (1, 20_000)).astype(kind)
    (whole,), (codes,) = (
        survey_channel_signals([v], rate=1000.0, names=["a"]) for v in (x.astype(float), x)
    )
    assert repr(codes) == repr(whole)
    (one,) = recording_from_arrays(x, rate=1000.0, names=["a"]).pieces(["a"])
    np.testing.assert_array_equal(one, x)
    assert one.dtype == float
