"""Faults that leave a mark are found where they are, and without them the truth comes back."""

import json
import tracemalloc
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.signal import butter, sosfiltfilt

from cardan.core.units import MPa
from cardan.physics.fatigue.damage import miner_damage
from cardan.physics.fatigue.rainflow import rainflow
from cardan.physics.fatigue.sn_curve import SNCurve
from cardan.physics.fatigue.strain_gauges import single_gauge
from cardan.physics.signals.assessment import AssessmentSettings, assess_gauges
from cardan.physics.signals.conditioning import survey_channel_signals
from cardan.physics.signals.data_quality import DataQuality, FaultEffect, FaultRule
from cardan.physics.signals.faults.duplicate_blocks import FAULT_REPEAT, DuplicateBlockDetector
from cardan.physics.signals.faults.fault_kind import SignalBlock
from cardan.physics.signals.faults.gain_change import FAULT_GAIN, GainChangeDetector, gain_changes
from cardan.physics.signals.faults.intermittent_contact import FAULT_NOISE
from cardan.physics.signals.faults.intervals import FaultIntervals, with_sizes_of
from cardan.physics.signals.faults.stuck_bit import FAULT_BIT
from cardan.physics.signals.faults.waveform import FAULT_SPIKE
from cardan.physics.signals.faults.zero_step import FAULT_ZERO_SHIFT
from cardan.physics.signals.recording import recording_from_arrays
from cardan.topics.recording.campaign_schema import read_campaign_text

RATE = 500.0
CURVE = SNCurve(amplitude=30 * MPa, cycles=2e6, slope=5).elementary()
N = 60_000


def road(seed=0, *, mean=10.0):
    """Up to 25 Hz with a floor of noise, MPa."""
    rng = np.random.default_rng(seed)
    x = sosfiltfilt(butter(3, [1, 25], btype="band", fs=RATE, output="sos"), rng.normal(size=N))
    return mean + 12 * x / x.std() + 0.05 * rng.normal(size=N)


def asked(*gauges, rules=()):
    names = [f"S{k}" for k in range(len(gauges))]
    plan = AssessmentSettings(
        gauges=tuple(single_gauge(n, n, factor=MPa) for n in names),
        curve=CURVE,
        fault_rules=tuple(rules),
    )
    recording = recording_from_arrays(
        np.stack(gauges), rate=RATE, names=names, units=["MPa"] * len(names)
    )
    return assess_gauges(recording, plan=plan)


def damage(x):
    return miner_damage(rainflow(x * MPa), curve=CURVE)


def effect(gauge, kind):
    (one,) = (e for e in gauge.quality.effects if e.kind == kind)
    return one


def wrapped(x):
    return (x - 10 + 24) % 48 - 24 + 10


def stuck(x):
    step = 200 / 4096
    code = np.round((x + 100) / step).astype(int)
    return (code | 256) * step - 100


def pulsed(x):
    t = np.arange(N) / RATE
    return x + 40 * (t % 0.7 < 0.3)


def stepped(x):
    rng = np.random.default_rng(4)
    at, by = rng.integers(0, N, 30), rng.choice([-20, 20], 30)
    return x + sum(b * (np.arange(N) >= a) for a, b in zip(at, by, strict=True))


def test_sound_road_signal_has_no_findings():
    (gauge,) = asked(road())
    assert gauge.quality.verdict == "good"
    assert not gauge.quality.effects


@pytest.mark.parametrize("spoil", [wrapped, stepped, pulsed])
def test_masking_faults_restores_damage_of_sound_signal(spoil):
    """Truth: the damage of what was spoiled, by rainflow of the whole signal at once."""
    (gauge,) = asked(spoil(road()))
    assert gauge.vetoed
    assert gauge.life.damage > 1.2 * damage(road())
    back = assess_gauges(
        recording_from_arrays(spoil(road())[None], rate=RATE, names=["S0"], units=["MPa"]),
        plan=AssessmentSettings(
            gauges=(single_gauge("S0", "S0", factor=MPa),),
            curve=CURVE,
            fault_rules=tuple(
                FaultRule(mask=True, kind=k) for k in ("zero-step", "spike", "dropout")
            ),
        ),
    )[0]
    assert abs(back.life.damage - damage(road())) < 0.5 * abs(gauge.life.damage - damage(road()))


def test_zero_steps_are_located_to_the_sample():
    x = road()
    at = np.array([5000, 11_000, 11_500, 30_200, 52_001])
    y = x + sum(18 * (np.arange(N) >= a) for a in at)
    for size in (700, 7919, N):
        (health,) = survey_channel_signals(
            (y[None, k : k + size] for k in range(0, N, size)), rate=RATE
        )
        where = health.faults_of(FAULT_ZERO_SHIFT)
        assert where.runs[:, 0].tolist() == at.tolist(), size
        assert where.sizes == pytest.approx(18, abs=1)


def test_impact_and_ringing_are_not_zero_steps():
    """A force that is there at once, and the ring of a mode of 30 Hz that answers."""
    t = np.arange(N) / RATE
    x = road()
    for at in np.arange(3, 117, 2.3):
        s = np.maximum(t - at, 0)
        x = x + 30 * np.exp(-3 * s) * (1 - np.exp(-6 * s) * np.cos(2 * np.pi * 30 * s)) * (t > at)
    (health,) = survey_channel_signals([x[None]], rate=RATE)
    assert FAULT_ZERO_SHIFT not in health.faults
    assert FAULT_GAIN not in health.faults


@pytest.mark.parametrize("factor", [2.0, 0.5, -1.0])
def test_gain_step_is_detected_and_corrected(factor):
    x = road(mean=15)
    at = 32_000 + int(np.argmax(np.abs(x[32_000:32_100])))
    y = np.where(np.arange(N) < at, x, factor * x)
    (gauge,) = asked(y)
    where = gauge.channel_reports["S0"].faults_of(FAULT_GAIN)
    assert where.runs[:, 0].tolist() == [at]
    assert where.sizes == pytest.approx(factor, rel=0.1)
    assert FAULT_GAIN in gauge.vetoes
    assert effect(gauge, FAULT_GAIN).damage_without == pytest.approx(damage(x), rel=0.3)
    (back,) = asked(y, rules=[FaultRule(mask=True, kind=FAULT_GAIN)])
    assert not back.vetoed
    assert back.life.damage == effect(gauge, FAULT_GAIN).damage_without
    assert back.quality.live_share == 1
    (so,) = asked(y, rules=[FaultRule(mask=False, kind=k) for k in (FAULT_GAIN, "drift")])
    assert (so.vetoes, so.life.damage) == ((), gauge.life.damage)


@pytest.mark.parametrize(
    ("factor", "offset", "count"), [(-1.0, 0, 3), (-1.0, 20, 3), (-2.0, 0, 3), (-1.0, 0, 1)]
)
def test_reversed_gain_is_sized_better_than_its_tear_shows(factor, offset, count):
    """Where the signal bends, the samples at the tear show it 6 % off.

    2 % of a gain are 10 % of the damage at slope 5; the crests where it turns over are the rest.
    """
    rng = np.random.default_rng(8)
    band = butter(3, [5, 50], btype="band", fs=RATE, output="sos")
    x = sosfiltfilt(band, np.random.default_rng(0).normal(size=N))
    x *= 12 / x.std()
    own = 0.05 * rng.normal(size=(3, N))
    part = x[30_000:32_000]
    bend = np.abs(np.gradient(np.gradient(part))) / np.abs(part)
    at = 30_000 + int(np.argmax(np.where(np.abs(part) > 18, bend, 0)))
    y = np.where(np.arange(N) < at, x + own[0], factor * (x + own[0]) + offset)
    (gauge, *others) = asked(*[y, 0.6 * x + own[1], -0.4 * x + own[2]][:count])
    where = gauge.channel_reports["S0"].faults_of(FAULT_GAIN)
    assert where.count == 1
    assert where.sizes == pytest.approx(factor, rel=0.02)
    assert effect(gauge, FAULT_GAIN).damage_without == pytest.approx(damage(x), rel=0.12)
    assert all(
        FAULT_GAIN not in g.channel_reports["S" + str(k)].faults for k, g in enumerate(others, 1)
    )


def test_sizes_of_another_finding_count_only_where_it_tells_one_change():
    places = FaultIntervals(np.array([[100, 101], [500, 501], [900, 901], [905, 906]]),
                            np.array([-0.8, -1.2, 2.2, 2.1]))  # fmt: skip
    other = FaultIntervals(np.array([[90, 91], [505, 506], [902, 903]]), np.array([-1.0, 1.1, 2.0]))
    sized = with_sizes_of(places, other, within=20)
    assert sized.runs is places.runs
    assert sized.sizes.tolist() == [-1.0, -1.2, 2.2, 2.1]


def test_gain_drift_is_located_by_comparison_with_other_gauges():
    """Within four seconds, so nothing is torn; a third gauge says which of the two it was."""
    x = road()
    own = np.random.default_rng(5).normal(size=(3, N)) * 0.05
    fades = np.interp(np.arange(N), [28_000, 30_000], [1.0, 1.6])
    gauges = asked(x * fades + own[0], 0.6 * x + own[1], -0.4 * x + own[2])
    places = gauges[0].channel_reports["S0"].faults_of(FAULT_GAIN)
    assert places.count == 1
    assert abs(places.runs[0, 0] - 29_000) < 5000
    assert places.sizes == pytest.approx(1.6, rel=0.15)
    assert [FAULT_GAIN in g.vetoes for g in gauges] == [True, False, False]
    # Of two, nobody knows which.
    assert [FAULT_GAIN in g.vetoes for g in asked(x * fades + own[0], 0.6 * x + own[1])] == [
        True,
        True,
    ]


@pytest.mark.parametrize("count", [3, 5])
def test_gain_fault_is_assigned_to_the_deviating_gauge(count):
    """At half from midway: the others keep their answers."""
    x, rng = road(3), np.random.default_rng(8)
    shares = np.array([0.6, 1.0, -0.4, 0.9, -1.2])[:count, None]
    gauges = shares * x + 0.05 * rng.normal(size=(count, N))
    gauges[1] *= np.interp(np.arange(N), [29_000, 31_000], [1.0, 0.5])
    heard = asked(*gauges)
    assert [g.vetoes for g in heard] == [(FAULT_GAIN,) if k == 1 else () for k in range(count)]
    assert heard[1].channel_reports["S1"].faults_of(FAULT_GAIN).sizes == pytest.approx(0.5, rel=0.1)


def test_slow_gain_drift_rejects_the_gauge():
    """By a third within two minutes, as of a battery that fades: nowhere does it step."""
    x, rng = road(4), np.random.default_rng(9)
    gauges = np.array([[1.0], [0.6], [-0.4]]) * x + 0.05 * rng.normal(size=(3, N))
    gauges[0] *= np.linspace(1, 1.35, N)
    assert [FAULT_GAIN in g.vetoes for g in asked(*gauges)] == [True, False, False]


def test_gain_detection_does_not_depend_on_batch_size(monkeypatch):
    """Spans are met some at a time, and places asked for so: each by itself comes to the same."""
    x, rng = road(4), np.random.default_rng(9)
    gauges = np.array([[1.0], [0.6], [-0.4]]) * x + 0.05 * rng.normal(size=(3, N))
    gauges[0] *= np.interp(np.arange(N), [28_000, 30_000], [1.0, 1.6])

    def met():
        ratios = GainChangeDetector(RATE, 3)
        ratios.update(gauges)
        return np.concatenate(ratios.met), [(p.runs.tolist(), p.sizes) for p in ratios.result()]

    powers, found = met()
    assert any(len(runs) for runs, _ in found)
    for one in ("SPANS_PER_BLOCK", "SEARCH_WINDOWS_PER_BLOCK"):
        monkeypatch.setattr(f"cardan.physics.signals.faults.gain_change.{one}", 1)
    again, told = met()
    np.testing.assert_array_equal(again, powers)
    for (runs, sizes), (others, factors) in zip(found, told, strict=True):
        assert runs == others
        np.testing.assert_array_equal(sizes, factors)


def test_level_change_in_few_bands_is_not_a_gain_change():
    """From midway on both feel an order of 17 Hz three times as much: no gain did that."""
    t = np.arange(N) / RATE
    order = 8 * np.sin(2 * np.pi * 17 * t) * np.where(t < 60, 1, 3)
    gauges = asked(road() + order, 0.6 * road() + 0.2 * order)
    assert not any(FAULT_GAIN in g.channel_reports[f"S{k}"].faults for k, g in enumerate(gauges))


def test_gain_change_needs_agreement_of_many_bands():
    """Seven thirds of an octave from end to end, five of which say so and none otherwise."""

    def told(*bands):
        power = np.ones((40, len(bands)))
        power[20:] = bands
        return gain_changes(power, np.ones_like(power), np.sqrt(power))

    assert told(4, 4, 4, 4, 4, 4) == []
    assert told(4, 4, 4, 4, 4, 4, 4) == [(20, pytest.approx(2))]
    assert told(4, 4, 4, 4, 4, 4, 1, 1) == []


def test_intermittent_force_is_not_a_gain_change():
    """In all bands at once, as blows that one gauge feels more: now and then before as well."""
    rng = np.random.default_rng(6)
    power = np.exp(0.02 * rng.normal(size=(60, 9)))
    often = rng.uniform(size=60) < np.where(np.arange(60) < 30, 0.2, 0.8)
    power[often] *= 2
    assert gain_changes(power, np.ones_like(power), np.sqrt(power)) == []


def test_rectified_signal_is_detected_and_unfolded():
    x = road(mean=0)
    (gauge,) = asked(np.abs(x))
    assert gauge.vetoes == (FAULT_GAIN,)
    assert gauge.life.damage < 0.2 * damage(x)
    assert effect(gauge, FAULT_GAIN).damage_without == pytest.approx(damage(x), rel=0.15)
    # What comes to rest at nought bounces off nothing, and neither does a sine that touches it.
    t = np.arange(N) / RATE
    for whole in (np.maximum(x, 0), 20 + 20 * np.sin(2 * np.pi * 3.1 * t)):
        (health,) = survey_channel_signals([whole[None]], rate=RATE)
        assert FAULT_GAIN not in health.faults


def test_intermittent_contact_is_detected_as_noise():
    x, rng = road(), np.random.default_rng(6)
    at = [7000, 23_456, 48_000]
    for a in at:
        x[a : a + 150] += 50 * rng.normal(size=150)
    for size in (1711, N):
        (health,) = survey_channel_signals(
            (x[None, k : k + size] for k in range(0, N, size)), rate=RATE
        )
        where = health.faults_of(FAULT_NOISE)
        assert where.count == 3, size
        assert (where.runs[:, 0] <= at).all()
        assert (where.runs[:, 1] >= np.array(at) + 150).all()
    (gauge,) = asked(x)
    assert FAULT_NOISE in gauge.vetoes
    assert gauge.life.damage > 20 * damage(road())
    (back,) = asked(
        x, rules=[FaultRule(mask=True, kind=k) for k in (FAULT_NOISE, FAULT_SPIKE, "dropout")]
    )
    assert back.life.damage == pytest.approx(damage(road()), rel=0.3)


def test_impacts_are_not_noise():
    t = np.arange(N) / RATE
    x = road()
    for k, at in enumerate(np.arange(2, 118, 1.7)):
        s = np.maximum(t - at, 0)
        x = x + 60 * (t > at) * np.exp(-8 * s) * np.sin(2 * np.pi * (12 + k % 50) * s)
        x = x + 40 * np.sin(np.pi * np.clip((t - at - 1) / 0.01, 0, 1))
    # All frequencies alike, but at once: spikes, one a block.
    x[9000 + 32 * np.arange(12) + np.arange(12) * 7 % 20] += 90
    (health,) = survey_channel_signals([x[None]], rate=RATE)
    assert FAULT_NOISE not in health.faults


def test_duplicated_samples_are_located():
    x = road()
    x[20_000:21_500] = x[18_500:20_000]
    x[40_000:42_000] = x[5000:7000]
    for size in (1711, N):
        (health,) = survey_channel_signals(
            (x[None, k : k + size] for k in range(0, N, size)), rate=RATE
        )
        runs = health.faults_of(FAULT_REPEAT).runs
        assert len(runs) == 2
        # A copy begins and ends within some chosen samples of where it does: one in 64.
        assert np.abs(runs - [[20_000, 21_500], [40_000, 42_000]]).max() < 500, size


def test_duplicate_detection_does_not_depend_on_fingerprint_parts():
    """Held against each other in parts, or all at once as here: the same pairs."""
    x = road()
    copies = range(2000, N - 2000, 2000)
    for k in copies:
        x[k : k + 300] = x[k - 900 : k - 600]
    twice = DuplicateBlockDetector(RATE)
    for start in range(0, N, 7000):
        twice.update(SignalBlock(x[start : start + 7000], x[start : start + 7016], start=start))
    at = np.concatenate(
        [s + m[0].astype(int) for s, m in zip(twice.starts, twice.met, strict=True)]
    )
    told = np.concatenate([m[1] for m in twice.met])
    order = np.argsort(told, kind="stable")
    same = np.flatnonzero(told[order][1:] == told[order][:-1])
    pairs = {(int(at[order[k]]), int(at[order[k + 1]])) for k in same}
    again = np.array([second for first, second in pairs if second - first == 900])
    fours = [np.count_nonzero((again >= k) & (again < k + 300)) >= 4 for k in copies]
    found = [twice._pairs(part) for part in range(8)]
    assert {(int(a), int(b)) for one in found for a, b in zip(*one, strict=True)} == pairs
    assert (
        len(twice._repeated_runs()) == sum(fours) > 10
    )  # which, goes by the last digit of a machine


def test_duplicate_search_memory_stays_below_fingerprint_size():
    """All fingerprints held against each other at once took five times their own room."""
    rng, twice = np.random.default_rng(2), DuplicateBlockDetector(RATE)
    for k in range(256):
        twice.starts.append(k << 18)
        chosen, told = (rng.integers(0, most, 4096, np.uint32) for most in (1 << 18, 1 << 32))
        twice.met.append(np.stack([chosen, told]))
    tracemalloc.start()
    twice._repeated_runs()
    _, most = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert most < sum(met.nbytes for met in twice.met)


def test_periodic_bench_signal_is_not_a_duplicate():
    t = np.arange(N) / RATE
    (health,) = survey_channel_signals([np.tile(road()[:6000], 10)[None]], rate=RATE)
    assert FAULT_REPEAT not in health.faults
    (health,) = survey_channel_signals(
        [np.round(20 * np.sin(2 * np.pi * 0.5 * t))[None]], rate=RATE
    )
    assert FAULT_REPEAT not in health.faults


def test_stuck_bit_rejects_the_gauge():
    (gauge,) = asked(stuck(road()))
    assert FAULT_BIT in gauge.vetoes
    assert gauge.channel_reports["S0"].whole_channel_size(FAULT_BIT) == pytest.approx(
        256 * 200 / 4096, rel=0.01
    )
    assert effect(gauge, FAULT_BIT).reason.values == (("width", pytest.approx(12.5, rel=0.01)),)
    coarse = np.round(road() / 3) * 3
    levels = np.repeat(np.random.default_rng(1).choice([-20.0, 0, 20], N // 100), 100)
    for whole in (road(), coarse, levels + np.random.default_rng(2).normal(size=N)):
        assert (
            survey_channel_signals([whole[None]], rate=RATE)[0].whole_channel_size(FAULT_BIT) == 0
        )


def test_faults_that_conceal_each_other_reject_the_gauge_jointly():
    """A fault that is half spikes, half steps: without either the other is left."""
    x = road()
    t = np.arange(N) / RATE
    y = x + 60 * ((t > 30) & (t < 100)) * (np.arange(N) % 2500 < 1250)
    y[np.arange(700, N, 2500)] += 90
    (gauge,) = asked(y)
    assert gauge.vetoed
    assert gauge.quality.damage_without_undecided < 0.5 * gauge.life.damage
    some = [
        FaultEffect(
            kind=k,
            count=1,
            samples=1,
            share=0.0,
            undecided=1,
            damage_recorded=1.0,
            damage_without=0.87,
        )
        for k in (FAULT_SPIKE, FAULT_ZERO_SHIFT)
    ]
    of = DataQuality(
        live_time=1.0,
        recorded_time=1.0,
        effects=tuple(some),
        damage=1.0,
        damage_without_undecided=0.72,
    )
    assert of.vetoes == (FAULT_SPIKE, FAULT_ZERO_SHIFT)
    assert replace(of, damage_without_undecided=0.9).vetoes == ()
    decided = tuple(replace(e, undecided=0) for e in some)
    assert replace(of, effects=decided).vetoes == ()


AMPLIFIERS = """
campaign: two amplifiers
recordings:
  - {file: a.csv, name: first}
  - file: b.csv
    name: second
    channels: {B1: {unit: MPa, factor: 200, offset: 10}}
strength: {amplitude_MPa: 30, cycles: 2000000.0, slope: 5}
channels: {B1: {unit: MPa, factor: 400, offset: 5}}
gauges: [B1]
"""


def test_calibration_is_applied_per_recording(tmp_path: Path):
    from click.testing import CliRunner

    from cardan.cli.life import life as command

    x = road()[:20_000]
    for name, factor, offset in (("a", 400, 5), ("b", 200, 10)):
        rows = np.stack([np.arange(x.size) / RATE, (x - offset) / factor], -1)
        np.savetxt(tmp_path / f"{name}.csv", rows, fmt="%.12g", delimiter=",", comments="",
                   header="time_s,B1 [V]")  # fmt: skip
    (tmp_path / "c.yaml").write_text(AMPLIFIERS)
    out = tmp_path / "c.json"
    done = CliRunner().invoke(
        command, ["--all", str(tmp_path / "c.yaml"), "-q", "--json", str(out)]
    )
    assert done.exit_code == 0, done.output
    first, second = json.loads(out.read_text())["recordings"]
    assert second["gauges"][0]["damage"] == pytest.approx(first["gauges"][0]["damage"], rel=1e-6)
    assert second["notes"] == ["B1 is its value times 200 plus 10, in MPa"]
    said = CliRunner().invoke(command, ["--all", str(tmp_path / "c.yaml"), "--lang", "pt"]).output
    assert "B1 é o seu valor vezes 200 mais 10, em MPa" in " ".join(said.split())


@pytest.mark.parametrize(
    ("wrong", "said"),
    [
        ("unit: psi, factor: 200", "recordings[2].channels.B1.unit: is no unit of stress"),
        ("unit: MPa, factor: 0", "recordings[2].channels.B1.factor: must not be 0"),
    ],
)
def test_invalid_calibration_is_rejected_with_file_and_line(tmp_path, wrong, said):
    from cardan.core.errors import InvalidFileError

    text = AMPLIFIERS.replace("unit: MPa, factor: 200", wrong)
    for name in "ab":
        (tmp_path / f"{name}.csv").write_text("")
    with pytest.raises(InvalidFileError) as error:
        read_campaign_text(text, name="c.yaml", folder=tmp_path)
    assert "c.yaml:7:" in str(error.value)
    assert said in str(error.value)
