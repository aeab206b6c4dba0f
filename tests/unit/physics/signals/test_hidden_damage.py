"""What a gauge does not record is counted as the worst it recorded; a standstill hides nothing."""

import numpy as np
import pytest

from cardan.core.units import MPa
from cardan.physics.fatigue.damage import miner_damage
from cardan.physics.fatigue.mean_stress import uncorrected
from cardan.physics.fatigue.rainflow import half_cycles, rainflow
from cardan.physics.fatigue.sn_curve import SNCurve
from cardan.physics.fatigue.strain_gauges import single_gauge
from cardan.physics.signals.assessment import AssessmentSettings, assess_gauges
from cardan.physics.signals.data_quality import FaultRule
from cardan.physics.signals.faults.quiet_stretches import QuietStretches
from cardan.physics.signals.hidden_damage import IntervalDamage, hidden_interval_count
from cardan.physics.signals.recording import recording_from_arrays

RATE = 500.0
T = np.arange(30_000) / RATE
CURVE = SNCurve(amplitude=30 * MPa, cycles=2e6, slope=5).modified()


def rough():
    """A stress that swells and fades twenty times a minute, with noise, MPa: a minute."""
    swells = 1 + 0.5 * np.sin(2 * np.pi * 0.31 * T)
    return 20 * swells * np.sin(2 * np.pi * 9 * T) + np.random.default_rng(3).normal(size=T.size)


def of(x, *rules):
    recording = recording_from_arrays(np.atleast_2d(x), rate=RATE, names=["S1"], units=["MPa"])
    plan = AssessmentSettings(
        gauges=(single_gauge("S1", "S1", factor=MPa),), curve=CURVE, fault_rules=rules
    )
    return assess_gauges(recording, plan=plan)[0]


def frozen(x, first=20.0, last=32.0, noise=0.0):
    y, at = x.copy(), slice(int(first * RATE), int(last * RATE))
    y[at] = y[at.start] + noise * np.random.default_rng(1).normal(size=y[at].size)
    return y


def test_interval_damages_add_up_to_the_whole():
    stress = rough() * MPa
    each = IntervalDamage(rate=RATE, curve=CURVE, correction=uncorrected, rule=half_cycles)
    for piece in np.array_split(stress, [700, 701, 9000]):
        each.update(piece)
    whole = miner_damage(rainflow(stress), curve=CURVE)
    many = len(each.damages) + each.residue.size - 1
    assert each.worst(many) == pytest.approx(whole, rel=1e-9)
    assert each.worst(2 * many) == pytest.approx(2 * whole, rel=1e-9)
    assert whole / 60 < each.worst(1) < whole


def test_hidden_intervals_are_begun_seconds():
    runs = np.array([[0, 40], [1000, 1060], [2000, 2501], [4000, 6000]], np.intp)
    assert hidden_interval_count(runs, rate=RATE) == 0 + 1 + 2 + 4


@pytest.mark.parametrize("noise", [0.0, 0.05])
def test_freeze_in_moving_signal_is_rejected_with_what_it_may_hide(noise):
    x = rough()
    true, one = of(x).life.damage, of(frozen(x, noise=noise))
    assert one.life.damage < 0.95 * true
    assert one.quality.vetoes == ("freeze",)
    (effect,) = (e for e in one.quality.effects if e.kind == "freeze")
    assert effect.hidden_time == pytest.approx(12, abs=0.3)
    assert one.quality.damage_if_worst > true
    assert one.quality.damage_if_worst == effect.damage_if_worst > 1.2 * one.life.damage
    masked = of(frozen(x, noise=noise), FaultRule(mask=True, kind="freeze"))
    assert masked.vetoes == ()
    assert masked.quality.damage_if_worst > true
    accepted = of(frozen(x, noise=noise), FaultRule(mask=False, kind="freeze"))
    assert accepted.vetoes == ()
    assert np.isnan(accepted.quality.damage_if_worst)


def test_frozen_value_that_was_never_felt_adds_damage():
    x = rough()
    x[18_000:] = x.max() + 160
    one = of(x)
    (effect,) = (e for e in one.quality.effects if e.kind == "freeze")
    assert effect.damage_without < effect.damage_recorded / 1.2
    assert "freeze" in one.vetoes


def rests(noise):
    """The same with twelve seconds at rest, into which it rings down, and which it grows out of."""
    envelope = np.interp(T, [0, 18, 20, 32, 34, 60], [1, 1, 0, 0, 1, 1])
    x = 12 * np.sin(2 * np.pi * 9 * T) * envelope**2
    return np.round((x + noise * np.random.default_rng(1).normal(size=T.size)) / 0.05) * 0.05


@pytest.mark.parametrize("noise", [0.0, 0.1])
def test_vehicle_at_rest_hides_nothing(noise):
    one = of(rests(noise))
    assert one.vetoes == ()
    assert np.isnan(one.quality.damage_if_worst)


def test_blows_on_a_parked_vehicle_are_no_freeze():
    quiet = QuietStretches(RATE)
    x = 0.01 * np.random.default_rng(1).normal(size=T.size)
    x[:15_000] += rough()[:15_000]
    x[14_000:15_000] *= np.linspace(1, 0, 1000) ** 2
    for at in (17_000, 20_000, 24_000):
        x[at : at + 25] += 30 * np.sin(np.pi * np.arange(25) / 25)
    quiet.update(x)
    assert quiet.result().count == 0


def test_missing_time_is_told_and_rejects_nothing():
    x = rough()
    x[10_000:16_000] = np.nan
    one = of(x)
    assert one.vetoes == ()
    assert one.quality.damage_if_worst > of(rough()).life.damage
