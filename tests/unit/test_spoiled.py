"""Faults that leave a mark are found where they are, and without them the truth comes back."""

import json
import tracemalloc
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.signal import butter, sosfiltfilt

from cardan.base.units import MPa
from cardan.fatigue.conditioning import survey
from cardan.fatigue.damage import miner
from cardan.fatigue.fault import BIT, GAIN, NOISE, REPEAT, SPIKE, ZERO_STEP
from cardan.fatigue.gain import Ratios, changes
from cardan.fatigue.life import Plan, life
from cardan.fatigue.quality import Effect, Quality, Rule
from cardan.fatigue.rainflow import rainflow
from cardan.fatigue.recording import in_memory
from cardan.fatigue.strain import direct
from cardan.fatigue.strength import SNCurve
from cardan.fatigue.twice import Twice
from cardan.files.campaign import loads

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
    plan = Plan(
        gauges=tuple(direct(n, n, factor=MPa) for n in names), curve=CURVE, rules=tuple(rules)
    )
    recording = in_memory(np.stack(gauges), rate=RATE, names=names, units=["MPa"] * len(names))
    return life(recording, plan=plan)


def damage(x):
    return miner(rainflow(x * MPa), curve=CURVE)


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


def test_a_road_has_nothing_to_say():
    (gauge,) = asked(road())
    assert gauge.quality.verdict == "good"
    assert not gauge.quality.effects


@pytest.mark.parametrize("spoil", [wrapped, stepped, pulsed])
def test_a_torn_signal_is_put_together(spoil):
    """Truth: the damage of what was spoiled, by rainflow of the whole signal at once."""
    (gauge,) = asked(spoil(road()))
    assert gauge.vetoed
    assert gauge.life.damage > 1.2 * damage(road())
    back = life(
        in_memory(spoil(road())[None], rate=RATE, names=["S0"], units=["MPa"]),
        plan=Plan(
            gauges=(direct("S0", "S0", factor=MPa),), curve=CURVE,
            rules=tuple(Rule(mask=True, kind=k) for k in ("zero-step", "spike", "dropout")),
        ),
    )[0]  # fmt: skip
    assert abs(back.life.damage - damage(road())) < 0.5 * abs(gauge.life.damage - damage(road()))


def test_steps_are_where_they_are():
    x = road()
    at = np.array([5000, 11_000, 11_500, 30_200, 52_001])
    y = x + sum(18 * (np.arange(N) >= a) for a in at)
    for size in (700, 7919, N):
        (health,) = survey((y[None, k : k + size] for k in range(0, N, size)), rate=RATE)
        where = health.at(ZERO_STEP)
        assert where.runs[:, 0].tolist() == at.tolist(), size
        assert where.sizes == pytest.approx(18, abs=1)


def test_what_hits_a_structure_does_not_tear_it():
    """A force that is there at once, and the ring of a mode of 30 Hz that answers."""
    t = np.arange(N) / RATE
    x = road()
    for at in np.arange(3, 117, 2.3):
        s = np.maximum(t - at, 0)
        x = x + 30 * np.exp(-3 * s) * (1 - np.exp(-6 * s) * np.cos(2 * np.pi * 30 * s)) * (t > at)
    (health,) = survey([x[None]], rate=RATE)
    assert ZERO_STEP not in health.faults
    assert GAIN not in health.faults


@pytest.mark.parametrize("factor", [2.0, 0.5, -1.0])
def test_a_gain_that_jumps_is_taken_back(factor):
    x = road(mean=15)
    at = 32_000 + int(np.argmax(np.abs(x[32_000:32_100])))
    y = np.where(np.arange(N) < at, x, factor * x)
    (gauge,) = asked(y)
    where = gauge.health["S0"].at(GAIN)
    assert where.runs[:, 0].tolist() == [at]
    assert where.sizes == pytest.approx(factor, rel=0.1)
    assert GAIN in gauge.vetoes
    assert effect(gauge, GAIN).without == pytest.approx(damage(x), rel=0.3)
    (back,) = asked(y, rules=[Rule(mask=True, kind=GAIN)])
    assert not back.vetoed
    assert back.life.damage == effect(gauge, GAIN).without
    assert back.quality.share == 1
    (so,) = asked(y, rules=[Rule(mask=False, kind=k) for k in (GAIN, "drift")])
    assert (so.vetoes, so.life.damage) == ((), gauge.life.damage)


def test_a_gain_that_fades_is_told_by_another_gauge():
    """Within four seconds, so nothing is torn; a third gauge says which of the two it was."""
    x = road()
    own = np.random.default_rng(5).normal(size=(3, N)) * 0.05
    fades = np.interp(np.arange(N), [28_000, 30_000], [1.0, 1.6])
    gauges = asked(x * fades + own[0], 0.6 * x + own[1], -0.4 * x + own[2])
    places = gauges[0].health["S0"].at(GAIN)
    assert places.count == 1
    assert abs(places.runs[0, 0] - 29_000) < 5000
    assert places.sizes == pytest.approx(1.6, rel=0.15)
    assert [GAIN in g.vetoes for g in gauges] == [True, False, False]
    # Of two, nobody knows which.
    assert [GAIN in g.vetoes for g in asked(x * fades + own[0], 0.6 * x + own[1])] == [True, True]


@pytest.mark.parametrize("count", [3, 5])
def test_of_many_gauges_the_one_that_stands_against_all_is_spoiled(count):
    """At half from midway: the others keep their answers."""
    x, rng = road(3), np.random.default_rng(8)
    shares = np.array([0.6, 1.0, -0.4, 0.9, -1.2])[:count, None]
    gauges = shares * x + 0.05 * rng.normal(size=(count, N))
    gauges[1] *= np.interp(np.arange(N), [29_000, 31_000], [1.0, 0.5])
    heard = asked(*gauges)
    assert [g.vetoes for g in heard] == [(GAIN,) if k == 1 else () for k in range(count)]
    assert heard[1].health["S1"].at(GAIN).sizes == pytest.approx(0.5, rel=0.1)


def test_a_gain_that_creeps_is_told():
    """By a third within two minutes, as of a battery that fades: nowhere does it step."""
    x, rng = road(4), np.random.default_rng(9)
    gauges = np.array([[1.0], [0.6], [-0.4]]) * x + 0.05 * rng.normal(size=(3, N))
    gauges[0] *= np.linspace(1, 1.35, N)
    assert [GAIN in g.vetoes for g in asked(*gauges)] == [True, False, False]


def test_what_is_held_at_once_changes_no_gain(monkeypatch):
    """Spans are met some at a time, and places asked for so: each by itself comes to the same."""
    x, rng = road(4), np.random.default_rng(9)
    gauges = np.array([[1.0], [0.6], [-0.4]]) * x + 0.05 * rng.normal(size=(3, N))
    gauges[0] *= np.interp(np.arange(N), [28_000, 30_000], [1.0, 1.6])

    def met():
        ratios = Ratios(RATE, 3)
        ratios.add(gauges)
        return np.concatenate(ratios.met), [(p.runs.tolist(), p.sizes) for p in ratios.found()]

    powers, found = met()
    assert any(len(runs) for runs, _ in found)
    for one in ("AT_ONCE", "BLOCK"):
        monkeypatch.setattr(f"cardan.fatigue.gain.{one}", 1)
    again, told = met()
    np.testing.assert_array_equal(again, powers)
    for (runs, sizes), (others, factors) in zip(found, told, strict=True):
        assert runs == others
        np.testing.assert_array_equal(sizes, factors)


def test_what_else_shakes_changes_some_bands_only():
    """From midway on both feel an order of 17 Hz three times as much: no gain did that."""
    t = np.arange(N) / RATE
    order = 8 * np.sin(2 * np.pi * 17 * t) * np.where(t < 60, 1, 3)
    gauges = asked(road() + order, 0.6 * road() + 0.2 * order)
    assert not any(GAIN in g.health[f"S{k}"].faults for k, g in enumerate(gauges))


def test_a_ratio_needs_many_bands():
    """Seven thirds of an octave from end to end, five of which say so and none otherwise."""

    def told(*bands):
        power = np.ones((40, len(bands)))
        power[20:] = bands
        return changes(power, np.ones_like(power), np.sqrt(power))

    assert told(4, 4, 4, 4, 4, 4) == []
    assert told(4, 4, 4, 4, 4, 4, 4) == [(20, pytest.approx(2))]
    assert told(4, 4, 4, 4, 4, 4, 1, 1) == []


def test_a_force_that_comes_and_goes_changes_no_gain():
    """In all bands at once, as blows that one gauge feels more: now and then before as well."""
    rng = np.random.default_rng(6)
    power = np.exp(0.02 * rng.normal(size=(60, 9)))
    often = rng.uniform(size=60) < np.where(np.arange(60) < 30, 0.2, 0.8)
    power[often] *= 2
    assert changes(power, np.ones_like(power), np.sqrt(power)) == []


def test_an_absolute_value_is_unfolded():
    x = road(mean=0)
    (gauge,) = asked(np.abs(x))
    assert gauge.vetoes == (GAIN,)
    assert gauge.life.damage < 0.2 * damage(x)
    assert effect(gauge, GAIN).without == pytest.approx(damage(x), rel=0.15)
    # What comes to rest at nought bounces off nothing, and neither does a sine that touches it.
    t = np.arange(N) / RATE
    for whole in (np.maximum(x, 0), 20 + 20 * np.sin(2 * np.pi * 3.1 * t)):
        (health,) = survey([whole[None]], rate=RATE)
        assert GAIN not in health.faults


def test_a_contact_that_chatters_is_noise():
    x, rng = road(), np.random.default_rng(6)
    at = [7000, 23_456, 48_000]
    for a in at:
        x[a : a + 150] += 50 * rng.normal(size=150)
    for size in (1711, N):
        (health,) = survey((x[None, k : k + size] for k in range(0, N, size)), rate=RATE)
        where = health.at(NOISE)
        assert where.count == 3, size
        assert (where.runs[:, 0] <= at).all()
        assert (where.runs[:, 1] >= np.array(at) + 150).all()
    (gauge,) = asked(x)
    assert NOISE in gauge.vetoes
    assert gauge.life.damage > 20 * damage(road())
    (back,) = asked(x, rules=[Rule(mask=True, kind=k) for k in (NOISE, SPIKE, "dropout")])
    assert back.life.damage == pytest.approx(damage(road()), rel=0.3)


def test_blows_are_no_noise():
    t = np.arange(N) / RATE
    x = road()
    for k, at in enumerate(np.arange(2, 118, 1.7)):
        s = np.maximum(t - at, 0)
        x = x + 60 * (t > at) * np.exp(-8 * s) * np.sin(2 * np.pi * (12 + k % 50) * s)
        x = x + 40 * np.sin(np.pi * np.clip((t - at - 1) / 0.01, 0, 1))
    # All frequencies alike, but at once: spikes, one a block.
    x[9000 + 32 * np.arange(12) + np.arange(12) * 7 % 20] += 90
    (health,) = survey([x[None]], rate=RATE)
    assert NOISE not in health.faults


def test_what_was_stored_twice_is_found_to_the_sample():
    x = road()
    x[20_000:21_500] = x[18_500:20_000]
    x[40_000:42_000] = x[5000:7000]
    for size in (1711, N):
        (health,) = survey((x[None, k : k + size] for k in range(0, N, size)), rate=RATE)
        runs = health.at(REPEAT).runs
        assert len(runs) == 2
        # A copy begins and ends within some chosen samples of where it does: one in 64.
        assert np.abs(runs - [[20_000, 21_500], [40_000, 42_000]]).max() < 500, size


def test_a_copy_is_found_whatever_its_fingerprints_begin_with():
    """Held against each other in parts, or all at once as here: the same pairs."""
    x = road()
    copies = range(2000, N - 2000, 2000)
    for k in copies:
        x[k : k + 300] = x[k - 900 : k - 600]
    twice = Twice(RATE)
    for start in range(0, N, 7000):
        twice.add(x[start : start + 7016], start=start, size=7000)
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
    assert len(twice.found()) == sum(fours) > 10  # which, goes by the last digit of a machine


def test_what_is_told_of_a_day_takes_less_than_what_it_is_told_of():
    """All fingerprints held against each other at once took five times their own room."""
    rng, twice = np.random.default_rng(2), Twice(RATE)
    for k in range(256):
        twice.starts.append(k << 18)
        chosen, told = (rng.integers(0, most, 4096, np.uint32) for most in (1 << 18, 1 << 32))
        twice.met.append(np.stack([chosen, told]))
    tracemalloc.start()
    twice.found()
    _, most = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert most < sum(met.nbytes for met in twice.met)


def test_a_bench_that_repeats_is_no_copy():
    t = np.arange(N) / RATE
    (health,) = survey([np.tile(road()[:6000], 10)[None]], rate=RATE)
    assert REPEAT not in health.faults
    (health,) = survey([np.round(20 * np.sin(2 * np.pi * 0.5 * t))[None]], rate=RATE)
    assert REPEAT not in health.faults


def test_a_bit_that_stands_still_has_no_answer_without():
    (gauge,) = asked(stuck(road()))
    assert BIT in gauge.vetoes
    assert gauge.health["S0"].stuck == pytest.approx(256 * 200 / 4096, rel=0.01)
    assert "12.5" in str(effect(gauge, BIT).why)
    coarse = np.round(road() / 3) * 3
    levels = np.repeat(np.random.default_rng(1).choice([-20.0, 0, 20], N // 100), 100)
    for whole in (road(), coarse, levels + np.random.default_rng(2).normal(size=N)):
        assert survey([whole[None]], rate=RATE)[0].stuck == 0


def test_kinds_that_hide_each_other_veto_together():
    """A fault that is half spikes, half steps: without either the other is left."""
    x = road()
    t = np.arange(N) / RATE
    y = x + 60 * ((t > 30) & (t < 100)) * (np.arange(N) % 2500 < 1250)
    y[np.arange(700, N, 2500)] += 90
    (gauge,) = asked(y)
    assert gauge.vetoed
    assert gauge.quality.without_all < 0.5 * gauge.life.damage
    some = [
        Effect(kind=k, count=1, samples=1, share=0.0, undecided=1, recorded=1.0, without=0.87)
        for k in (SPIKE, ZERO_STEP)
    ]
    of = Quality(live=1.0, recorded=1.0, effects=tuple(some), damage=1.0, without_all=0.72)
    assert of.vetoes == (SPIKE, ZERO_STEP)
    assert replace(of, without_all=0.9).vetoes == ()
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


def test_a_recording_has_its_own_calibration(tmp_path: Path):
    from click.testing import CliRunner

    from cardan.cli.life import life as command

    x = road()[:20_000]
    for name, factor, offset in (("a", 400, 5), ("b", 200, 10)):
        rows = np.stack([np.arange(x.size) / RATE, (x - offset) / factor], -1)
        np.savetxt(tmp_path / f"{name}.csv", rows, fmt="%.12g", delimiter=",", comments="",
                   header="time_s,B1 [V]")  # fmt: skip
    (tmp_path / "c.yaml").write_text(AMPLIFIERS)
    out = tmp_path / "c.json"
    done = CliRunner().invoke(command, [str(tmp_path / "c.yaml"), "-q", "--json", str(out)])
    assert done.exit_code == 0, done.output
    first, second = json.loads(out.read_text())["recordings"]
    assert second["gauges"][0]["damage"] == pytest.approx(first["gauges"][0]["damage"], rel=1e-6)
    assert second["notes"] == ["B1 is its value times 200 plus 10, in MPa"]
    said = CliRunner().invoke(command, [str(tmp_path / "c.yaml"), "--lang", "pt"]).output
    assert "B1 é o seu valor vezes 200 mais 10, em MPa" in " ".join(said.split())


@pytest.mark.parametrize(
    ("wrong", "said"),
    [
        ("unit: psi, factor: 200", "recordings[2].channels.B1.unit: is no unit of stress"),
        ("unit: MPa, factor: 0", "recordings[2].channels.B1.factor: must not be 0"),
    ],
)
def test_a_calibration_that_is_none_is_refused_where_it_stands(tmp_path, wrong, said):
    from cardan.base.errors import BadFile

    text = AMPLIFIERS.replace("unit: MPa, factor: 200", wrong)
    for name in "ab":
        (tmp_path / f"{name}.csv").write_text("")
    with pytest.raises(BadFile) as error:
        loads(text, name="c.yaml", folder=tmp_path)
    assert "c.yaml:7:" in str(error.value)
    assert said in str(error.value)
