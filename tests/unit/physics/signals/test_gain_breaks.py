"""Breaks of a single gauge's gain, by linear prediction: signals of known gain, and none."""

import numpy as np
import pytest
from scipy.signal import butter, sosfiltfilt

from cardan.core.units import MPa
from cardan.physics.fatigue.sn_curve import SNCurve
from cardan.physics.fatigue.strain_gauges import single_gauge
from cardan.physics.signals.assessment import AssessmentSettings, assess_damage_at_gauges
from cardan.physics.signals.faults.fault_kind import SignalBlock
from cardan.physics.signals.faults.gain_breaks import GainBreakDetector
from cardan.physics.signals.recording import recording_from_arrays

RATE, N, AT = 500.0, 30_000, 17_297
"""Hz, samples of a minute, and where something happens."""


def gauge(seed=1):
    """Return a stress in MPa about 20, behind an anti-alias filter, with an amplifier's noise."""
    rng = np.random.default_rng(seed)
    whole = np.zeros(N + 2000)
    for low, high, size in ((0.5, 5, 25), (10, 60, 12)):
        band = butter(2, [low, high], "band", fs=RATE, output="sos")
        part = sosfiltfilt(band, rng.normal(size=whole.size))
        whole += size * part / part.std()
    whole = sosfiltfilt(butter(6, 90, fs=RATE, output="sos"), whole)[1000:-1000]
    return 20 + whole + 0.3 * rng.normal(size=N)


def breaks(x, *, piece=7000):
    detector = GainBreakDetector()
    for start in range(0, x.size, piece):
        part = x[start : start + piece]
        filled = np.where(np.isnan(part), 0.0, part)
        detector.update(SignalBlock(recorded=part, filled=filled, start=start))
    found = detector.result()
    return dict(zip(found.runs[:, 0].tolist(), found.sizes.tolist(), strict=True))


def changed(gain, zero=0.0, seed=1):
    x = gauge(seed)
    x[AT:] = gain * x[AT:] + zero
    return x


@pytest.mark.parametrize("gain", [-2.0, -0.5, 0.5, 1.4, 3.0])
def test_break_of_gain_is_found_to_the_sample(gain):
    found = breaks(changed(gain))
    assert list(found) == [AT]
    assert found[AT] == pytest.approx(gain, rel=0.05)


def test_break_of_gain_and_zero_is_found():
    found = breaks(changed(-2.0, zero=30.0))
    assert list(found) == [AT]
    assert found[AT] == pytest.approx(-2.0, rel=0.05)


def test_reversed_gauge_has_a_gain_of_minus_1():
    assert breaks(changed(-1.0)) == {AT: -1.0}


def test_breaks_do_not_depend_on_the_pieces():
    x = changed(1.4)
    assert breaks(x, piece=N) == breaks(x, piece=911) == breaks(x)


def test_gain_there_and_back_is_two_breaks():
    x = gauge()
    x[AT : AT + 3000] *= 1.8
    found = breaks(x)
    assert list(found) == [AT, AT + 3000]
    assert found[AT] * found[AT + 3000] == pytest.approx(1, rel=0.05)


def kerb(x):
    t = np.arange(N - AT) / RATE
    ring = 80 * np.exp(-12 * t) * np.sin(2 * np.pi * 31 * t)
    return x + np.append(np.zeros(AT), ring)


def hole(x):
    x = 3 * (np.arange(N) >= AT) * x + x
    x[AT - 5 : AT + 5] = np.nan
    return x


@pytest.mark.parametrize(
    "spoil",
    [
        lambda x: x,
        lambda x: np.sin(np.arange(x.size) / 9),
        lambda x: x + 60 * (np.arange(x.size) >= AT),
        kerb,
        hole,
        lambda x: 0 * x,
    ],
    ids=["whole", "tone", "step of the zero", "kerb", "change within a hole", "nothing"],
)
@pytest.mark.parametrize("seed", [1, 2, 3])
def test_what_is_no_gain_is_none(spoil, seed):
    assert breaks(spoil(gauge(seed))) == {}


@pytest.mark.parametrize("scale", [1e-310, 1e200, 1e308])
def test_numbers_near_the_smallest_and_largest_are_no_break(scale):
    breaks(scale * np.clip(changed(-2.0), -1, 1))


def test_short_recording_has_no_break():
    assert breaks(gauge()[:900]) == {}


def test_single_gauge_reversed_and_doubled_midway_is_rejected():
    settings = AssessmentSettings(
        gauges=(single_gauge("S1", "S1", factor=MPa),),
        curve=SNCurve(amplitude=30 * MPa, cycles=2e6, slope=5).modified(),
    )

    def assessed(x):
        recording = recording_from_arrays(x[None], rate=RATE, names=["S1"], units=["MPa"])
        return assess_damage_at_gauges(recording, plan=settings)[0]

    whole, spoiled = assessed(gauge()), assessed(changed(-2.0))
    assert whole.vetoes == ()
    assert spoiled.vetoes == ("gain",)
    (effect,) = (e for e in spoiled.quality.effects if e.kind == "gain")
    assert effect.damage_recorded > 5 * whole.life.damage
    assert effect.damage_without == pytest.approx(whole.life.damage, rel=0.2)
