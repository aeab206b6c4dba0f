"""A gain or a filter that changes part-way on a single gauge shows in the steps of its values."""

import numpy as np
import pytest
from scipy.signal import butter, lfilter, sosfilt

from cardan.core.units import MPa
from cardan.physics.fatigue.sn_curve import SNCurve
from cardan.physics.fatigue.strain_gauges import single_gauge
from cardan.physics.signals.assessment import AssessmentSettings, assess_gauges
from cardan.physics.signals.conditioning import survey_channel_signals
from cardan.physics.signals.faults.value_steps import step_of_values
from cardan.physics.signals.recording import recording_from_arrays

RATE, STEP = 500.0, 0.01
CHANGE = 15_000
CURVE = SNCurve(amplitude=30 * MPa, cycles=2e6, slope=5).modified()


def road(seed=1, *, size=15.0, samples=30_000):
    x = lfilter([1], [1, -0.95], np.random.default_rng(seed).normal(size=samples))
    return size * x / x.std()


def converted(x, step=STEP):
    return np.round(x / step) * step


def assess(x):
    plan = AssessmentSettings(gauges=(single_gauge("S", "S", factor=MPa),), curve=CURVE)
    recording = recording_from_arrays(x[None], rate=RATE, names=["S"], units=["MPa"])
    return assess_gauges(recording, plan=plan)[0]


def faults(x):
    (report,) = survey_channel_signals([np.asarray(x, float)[None]], rate=RATE)
    return report.faults


@pytest.mark.parametrize("factor", [0.6, 1.1, 2.0, 10.0])
@pytest.mark.parametrize("dtype", [np.float64, np.float32])
def test_gain_that_changes_is_found(factor, dtype):
    x = converted(road())
    x[CHANGE:] *= factor
    found = faults(x.astype(dtype))["gain"]
    assert found.sizes == pytest.approx([factor], rel=2e-3)
    assert found.runs[0, 0] == pytest.approx(CHANGE, abs=2 * RATE)


def test_single_gauge_whose_gain_changes_is_rejected():
    x = converted(road())
    x[CHANGE:] *= 1.3
    one = assess(x)
    assert one.vetoes == ("gain",)
    (effect,) = one.quality.effects
    # The second in which it changes is taken with what follows.
    assert effect.damage_without == pytest.approx(assess(converted(road())).life.damage, rel=0.1)


def test_filter_of_single_gauge_switched_on_is_rejected():
    x = converted(road())
    sos = butter(4, 15, fs=RATE, output="sos")
    x[CHANGE:] = (sosfilt(sos, x - x[0]) + x[0])[CHANGE:]
    one = assess(x)
    (run,) = one.channel_reports["S"].faults["response"].runs
    assert run[0] == pytest.approx(CHANGE, abs=2 * RATE)
    assert run[1] == x.size
    assert "response" in one.vetoes


CLEAN = {
    "no step": road(),
    "one step": converted(road()),
    "float32": converted(road()).astype(np.float32),
    "a level that changes": converted(road() * np.repeat([0.1, 1.0], CHANGE) + 40),
    "four digits": np.array([float(f"{v:.4g}") for v in road() + np.repeat([0.0, 500.0], CHANGE)]),
    "half precision": (road() + np.repeat([0.0, 300.0], CHANGE)).astype(np.float16).astype(float),
    "climbs three steps at a time": np.where(
        np.arange(30_000) < CHANGE, converted(road()), 0.03 * np.arange(30_000)
    ),
    "a hole of seconds": np.where(np.arange(30_000) // 5_000 == 3, np.nan, converted(road())),
    "stands for a while": converted(np.where(np.arange(30_000) // 5_000 == 3, 2.0, road())),
}


@pytest.mark.parametrize("name", CLEAN)
def test_steps_of_clean_gauge_show_nothing(name):
    assert not {"gain", "response"} & set(faults(CLEAN[name]))


def test_step_of_values():
    rng = np.random.default_rng(0)
    x = np.unique(converted(rng.normal(size=1000)))
    assert step_of_values(x) == pytest.approx(STEP, rel=1e-6)
    assert step_of_values(x * 1.3, expected=STEP) == pytest.approx(1.3 * STEP, rel=1e-6)
    assert step_of_values(np.sort(rng.normal(size=1000)), expected=STEP) == 0
    assert np.isnan(step_of_values(np.sort(rng.normal(size=1000))))
    assert np.isnan(step_of_values(x[:10]))
