"""A gauge's zero that steps: found, counted both ways, taken off or accepted, like any fault."""

import json

import numpy as np
import pytest
from click.testing import CliRunner

from cardan.cli.life import life as command
from cardan.core.units import MPa
from cardan.physics.fatigue.damage import miner_damage
from cardan.physics.fatigue.rainflow import rainflow
from cardan.physics.fatigue.sn_curve import SNCurve
from cardan.physics.fatigue.strain_gauges import single_gauge
from cardan.physics.signals.assessment import AssessmentSettings, assess_gauges
from cardan.physics.signals.conditioning import running_median_baseline, survey_channel_signals
from cardan.physics.signals.data_quality import FaultRule
from cardan.physics.signals.faults.zero_step import FAULT_ZERO_SHIFT
from cardan.physics.signals.recording import recording_from_arrays
from cardan.physics.signals.synthetic import synthetic_recording

RATE = 200.0
CURVE = SNCurve(amplitude=30 * MPa, cycles=2e6, slope=5).elementary()
PLAN = AssessmentSettings(gauges=(single_gauge("S1", "S1", factor=MPa),), curve=CURVE)


def ridden(seed=1, seconds=200):
    """Vibration of 8 Hz about, MPa."""
    rng = np.random.default_rng(seed)
    x = np.convolve(rng.normal(size=int(seconds * RATE)), np.hanning(25), "same")
    return 8 * x / x.std()


STEPS = ((61.3, 150.0), (140.0, -90.0))


@pytest.fixture(scope="module")
def stepped():
    x = ridden()
    t = np.arange(x.size) / RATE
    for at, size in STEPS:
        x = x + size * (t >= at)
    return x


def recorded(x):
    return recording_from_arrays(x[None], rate=RATE, names=["S1"], units=["MPa"])


def counted(x, *rules, **how):
    return assess_gauges(
        recorded(x),
        plan=AssessmentSettings(gauges=PLAN.gauges, curve=CURVE, fault_rules=rules, **how),
    )[0]


def test_zero_steps_are_located(stepped):
    # In pieces, so that one of them falls beside a cut.
    (health,) = survey_channel_signals(
        (stepped[None, k : k + 2052] for k in range(0, stepped.size, 2052)), rate=RATE
    )
    where = health.faults_of(FAULT_ZERO_SHIFT)
    assert where.runs[:, 0].tolist() == [round(at * RATE) for at, _ in STEPS]
    # Within what the vibration moves in a sample.
    assert where.sizes == pytest.approx([size for _, size in STEPS], abs=8)
    assert not health.drifts
    # By a step alone the level is another at the end, and that is no creep.
    once = ridden() + 150.0 * (np.arange(stepped.size) > 15_000)
    (health,) = survey_channel_signals([once[None]], rate=RATE)
    assert health.faults_of(FAULT_ZERO_SHIFT).count == 1
    assert not health.drifts


def test_undecided_zero_step_rejects_life(stepped):
    one = counted(stepped)
    (effect,) = one.quality.effects
    assert (effect.kind, effect.count, effect.undecided) == (FAULT_ZERO_SHIFT, 2, 2)
    assert one.vetoes == (FAULT_ZERO_SHIFT,)
    assert one.life.damage == pytest.approx(
        miner_damage(rainflow(stepped * MPa), curve=CURVE), rel=1e-12
    )
    assert effect.damage_recorded == one.life.damage


def test_zero_step_is_removed_by_mask(stepped):
    clean = miner_damage(rainflow(ridden() * MPa), curve=CURVE)
    masked = counted(stepped, FaultRule(mask=True, kind=FAULT_ZERO_SHIFT))
    assert not masked.vetoed
    assert masked.life.damage == pytest.approx(clean, rel=0.15)
    assert masked.quality.live_share == 1  # no hole is made of it
    assert counted(stepped).quality.effects[0].damage_without == masked.life.damage
    accepted = counted(stepped, FaultRule(mask=False, kind=FAULT_ZERO_SHIFT))
    assert not accepted.vetoed
    assert accepted.life.damage == counted(stepped).life.damage
    first = counted(stepped, FaultRule(mask=True, kind=FAULT_ZERO_SHIFT, last=100.0))
    assert first.quality.effects[0].undecided == 1
    assert first.max_stress == pytest.approx(ridden().max() * MPa, abs=8 * MPa)


def test_baseline_removes_drift_after_zero_step(stepped):
    """The step goes once, and not again with the drift."""
    both = counted(
        stepped, FaultRule(mask=True, kind=FAULT_ZERO_SHIFT), baseline=running_median_baseline
    )
    assert both.max_stress - both.min_stress == pytest.approx(np.ptp(ridden()) * MPa, rel=0.1)


@pytest.mark.parametrize("name", ["route", "ramp", "load", "blow", "dropout", "short"])
def test_signal_without_zero_step_gives_none(name):
    t = np.arange(int(200 * RATE)) / RATE
    x = ridden()
    if name == "route":
        drive = synthetic_recording(seconds=200, rate=RATE, seed=4)
        x = drive.recording.read_all(["S1"])[0]
    elif name == "ramp":
        x = x + np.clip((t - 60) / 0.1, 0, 1) * 150
    elif name == "load":  # a load that comes and goes within the spans beside it
        x = x + 150 * ((t > 61.3) & (t < 63.0))
    elif name == "blow":
        x = x + 150 * np.where(t > 70, np.exp(-np.maximum(t - 70, 0) * 20), 0)
    elif name == "dropout":
        x[12_000:12_030] = -300
    else:
        x = x[:800] + 150 * (np.arange(800) > 400)
    (health,) = survey_channel_signals([x[None]], rate=RATE)
    assert health.faults_of(FAULT_ZERO_SHIFT).count == 0


def test_command_reports_zero_steps(stepped, tmp_path):
    path = tmp_path / "a.csv"
    t = np.arange(stepped.size) / RATE
    np.savetxt(
        path, np.stack([t, stepped], -1), delimiter=",", comments="", fmt="%.6g",
        header="time,S1 [MPa]",
    )  # fmt: skip
    options = [str(path), "--gauge", "S1", "--sn", "30,2e6,5", "--json", str(tmp_path / "a.json")]
    done = CliRunner().invoke(command, [*options, "--target-hours", "1", "--all"])
    assert done.exit_code == 1
    assert "steps of the zero: 2, the first at 61.3 s" in done.output
    assert "--mask or --accept zero-step" in done.output
    done = CliRunner().invoke(command, [*options, "--mask", "S1=zero-step"])
    assert done.exit_code == 0, done.output
    found = json.loads((tmp_path / "a.json").read_text())
    assert found["gauges"][0]["quality"]["verdict"] == "good"
