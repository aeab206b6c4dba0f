"""A gauge that stops responding while another goes on is found; a vehicle that changes is not."""

import numpy as np
import pytest
from scipy.signal import butter, lfilter, sosfilt

from cardan.core.units import MPa
from cardan.physics.fatigue.sn_curve import SNCurve
from cardan.physics.fatigue.strain_gauges import single_gauge
from cardan.physics.signals.assessment import AssessmentSettings, assess_gauges
from cardan.physics.signals.conditioning import survey_channel_signals
from cardan.physics.signals.data_quality import FaultRule
from cardan.physics.signals.recording import recording_from_arrays

RATE = 500.0
T = np.arange(45_000) / RATE
CURVE = SNCurve(amplitude=30 * MPa, cycles=2e6, slope=5).modified()
LOST = slice(15_000, 30_000)


def road(seed, size=1.0):
    """A force of all frequencies that falls off with them, with a deviation of `size`."""
    x = lfilter([1], [1, -0.95], np.random.default_rng(seed).normal(size=T.size))
    return size * x / x.std()


def envelope(*knots):
    """A level by (second, level), straight in its logarithm."""
    second, level = zip(*knots, strict=True)
    return np.exp(np.interp(T, second, np.log(level)))


def felt(force, *, share=0.7, noise=0.03, seed=20, engine=0.0):
    """Two gauges that feel a force through a mode, an idling engine by another ratio, noise."""
    sos = butter(1, [18, 40], btype="bandpass", fs=RATE, output="sos")
    rng = np.random.default_rng(seed)
    a = 15 * (force + 0.8 * sosfilt(sos, force)) + engine
    b = -15 * share * (force + 0.3 * sosfilt(sos, force)) + 1.6 * share * engine
    return np.stack([x + noise * rng.normal(size=T.size) for x in (a, b)])


def assess(gauges, *rules):
    names = [f"S{k}" for k in range(len(gauges))]
    plan = AssessmentSettings(
        gauges=tuple(single_gauge(n, n, factor=MPa) for n in names), curve=CURVE,
        fault_rules=rules,
    )  # fmt: skip
    recording = recording_from_arrays(
        np.stack(gauges), rate=RATE, names=names, units=["MPa"] * len(names)
    )
    return assess_gauges(recording, plan=plan)


def frozen(x, *, noise, bleeds_s=0.0):
    """A gauge that stays where it was, with an amplifier's noise in shares of its deviation."""
    y, n = x.copy(), LOST.stop - LOST.start
    y[LOST] = x[LOST.start] + noise * x.std() * np.random.default_rng(5).normal(size=n)
    if bleeds_s:
        y[LOST] += (x[LOST] - x[LOST.start]) * np.exp(-np.arange(n) / RATE / bleeds_s)
    return y


def filtered(x, cutoff, order=4):
    """A gauge whose low-pass filter is switched on in the middle, and stays on."""
    slow = sosfilt(butter(order, cutoff, fs=RATE, output="sos"), x - x[0]) + x[0]
    return np.concatenate([x[: T.size // 2], slow[T.size // 2 :]])


def test_clean_gauges_have_no_fault():
    assert [one.quality.verdict for one in assess(felt(road(1)))] == ["good", "good"]


@pytest.mark.parametrize("noise", [0.006, 0.04])
@pytest.mark.parametrize("count", [1, 2])
def test_freeze_under_noise_is_rejected(noise, count):
    whole = felt(road(1))
    spoiled = np.stack([frozen(whole[0], noise=noise), whole[1]])[:count]
    one, *others = assess(spoiled)
    assert one.vetoes == ("freeze",)
    assert one.quality.damage_if_worst > assess(whole[:1])[0].life.damage
    assert not any(other.vetoes for other in others)


def test_gauge_that_falls_silent_slowly_is_rejected():
    whole = felt(road(1))
    one, other = assess([frozen(whole[0], noise=0.01, bleeds_s=0.4), whole[1]])
    assert one.vetoes == ("response",)
    assert other.vetoes == ()
    (effect,) = one.quality.effects
    assert effect.hidden_time == pytest.approx(30, abs=2)
    assert effect.damage_if_worst > assess(whole)[0].life.damage
    masked = assess(
        [frozen(whole[0], noise=0.01, bleeds_s=0.4), whole[1]],
        FaultRule(mask=True, kind="response"),
    )[0]
    assert masked.vetoes == ()
    assert masked.quality.live_time == pytest.approx(60, abs=2)


def test_gauge_silent_from_the_start_is_rejected():
    whole = felt(road(1))
    y = whole[0].copy()
    y[:20_000] = 3 + 0.05 * np.random.default_rng(5).normal(size=20_000)
    one, other = assess([y, whole[1]])
    assert one.vetoes == ("response",)
    assert other.vetoes == ()


@pytest.mark.parametrize(("cutoff", "order"), [(12.0, 4), (25.0, 4), (8.0, 1)])
def test_low_pass_switched_on_midway_is_rejected(cutoff, order):
    whole = felt(road(1))
    one, other = assess([filtered(whole[0], cutoff, order), whole[1]])
    assert one.vetoes == ("response",)
    assert other.vetoes == ()
    (where,) = one.channel_reports["S0"].faults["response"].runs
    assert where / RATE == pytest.approx([45, 90], abs=3)


def test_of_three_gauges_the_one_that_is_lost_is_named():
    whole = np.concatenate([felt(road(1)), felt(road(1), share=0.4, seed=9)[1:]])
    whole[1] = filtered(whole[1], 12.0)
    assert [one.vetoes for one in assess(whole)] == [(), ("response",), ()]


def test_change_of_gain_is_no_lost_response():
    whole = felt(road(1))
    whole[0, 14_000:] *= 0.3
    one = assess(whole)[0]
    assert one.vetoes == ("gain",)
    assert "response" not in one.channel_reports["S0"].faults


CHANGES = {
    "stops and stands": (
        envelope((0, 1), (30, 1), (34, 1e-4), (55, 1e-4), (60, 1), (90, 1)), 0.0
    ),
    "coasts on a smooth road": (envelope((0, 1), (40, 1), (40.5, 0.1), (90, 0.1)), 0.0),
    "engine off": (envelope((0, 0.1), (40, 0.1), (42, 1e-4), (90, 1e-4)), 0.0),
    "idles": (envelope((0, 1), (20, 1), (23, 1e-3), (70, 1e-3), (73, 1), (90, 1)), 1.0),
    "idles to the end": (envelope((0, 1), (45, 1), (48, 1e-3), (90, 1e-3)), 1.0),
}  # fmt: skip


@pytest.mark.parametrize("kind", CHANGES)
def test_vehicle_that_changes_is_no_fault(kind):
    level, engine = CHANGES[kind]
    idle = engine * (0.3 * np.sin(2 * np.pi * 21 * T) + road(4, 0.5)) * (level < 0.5)
    x = felt(road(1) * level, engine=idle)
    assert [one.vetoes for one in assess(x)] == [(), ()]
    for report in survey_channel_signals([x], rate=RATE):
        assert "response" not in report.faults


def test_gauges_of_other_parts_are_not_compared():
    """One lies on a part that stops, the other on one that goes on: nothing is in common."""
    stops = felt(road(1) * envelope((0, 1), (40, 1), (40.3, 0.01), (90, 0.01)))[0]
    for report in survey_channel_signals([np.stack([stops, 15 * road(2)])], rate=RATE):
        assert "response" not in report.faults
