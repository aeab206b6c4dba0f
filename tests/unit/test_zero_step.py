"""A gauge's zero that steps: found, counted both ways, taken off or accepted, like any fault."""

import json

import numpy as np
import pytest
from click.testing import CliRunner

from cardan.base.units import MPa
from cardan.cli.life import life as command
from cardan.fatigue.conditioning import slow_drift, survey
from cardan.fatigue.damage import miner
from cardan.fatigue.fault import ZERO_STEP
from cardan.fatigue.life import Plan, life
from cardan.fatigue.quality import Rule
from cardan.fatigue.rainflow import rainflow
from cardan.fatigue.recording import in_memory
from cardan.fatigue.strain import direct
from cardan.fatigue.strength import SNCurve
from cardan.fatigue.synthetic import synthetic

RATE = 200.0
CURVE = SNCurve(amplitude=30 * MPa, cycles=2e6, slope=5).elementary()
PLAN = Plan(gauges=(direct("S1", "S1", factor=MPa),), curve=CURVE)


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
    return in_memory(x[None], rate=RATE, names=["S1"], units=["MPa"])


def counted(x, *rules, **how):
    return life(recorded(x), plan=Plan(gauges=PLAN.gauges, curve=CURVE, rules=rules, **how))[0]


def test_steps_are_found_where_they_are(stepped):
    # In pieces, so that one of them falls beside a cut.
    (health,) = survey(
        (stepped[None, k : k + 2052] for k in range(0, stepped.size, 2052)), rate=RATE
    )
    where = health.at(ZERO_STEP)
    assert where.runs[:, 0].tolist() == [round(at * RATE) for at, _ in STEPS]
    # Within what the vibration moves in a sample.
    assert where.sizes == pytest.approx([size for _, size in STEPS], abs=8)
    assert not health.drifts
    # By a step alone the level is another at the end, and that is no creep.
    once = ridden() + 150.0 * (np.arange(stepped.size) > 15_000)
    (health,) = survey([once[None]], rate=RATE)
    assert health.at(ZERO_STEP).count == 1
    assert not health.drifts


def test_a_step_nobody_decided_on_leaves_no_answer(stepped):
    one = counted(stepped)
    (effect,) = one.quality.effects
    assert (effect.kind, effect.count, effect.undecided) == (ZERO_STEP, 2, 2)
    assert one.vetoes == (ZERO_STEP,)
    assert one.life.damage == pytest.approx(miner(rainflow(stepped * MPa), curve=CURVE), rel=1e-12)
    assert effect.recorded == one.life.damage


def test_it_is_taken_off_and_put_back(stepped):
    clean = miner(rainflow(ridden() * MPa), curve=CURVE)
    masked = counted(stepped, Rule(mask=True, kind=ZERO_STEP))
    assert not masked.vetoed
    assert masked.life.damage == pytest.approx(clean, rel=0.15)
    assert masked.quality.share == 1  # no hole is made of it
    assert counted(stepped).quality.effects[0].without == masked.life.damage
    accepted = counted(stepped, Rule(mask=False, kind=ZERO_STEP))
    assert not accepted.vetoed
    assert accepted.life.damage == counted(stepped).life.damage
    first = counted(stepped, Rule(mask=True, kind=ZERO_STEP, last=100.0))
    assert first.quality.effects[0].undecided == 1
    assert first.high == pytest.approx(ridden().max() * MPa, abs=8 * MPa)


def test_a_baseline_takes_off_what_is_left_of_it(stepped):
    """The step goes once, and not again with the drift."""
    both = counted(stepped, Rule(mask=True, kind=ZERO_STEP), baseline=slow_drift)
    assert both.high - both.low == pytest.approx(np.ptp(ridden()) * MPa, rel=0.1)


@pytest.mark.parametrize("name", ["route", "ramp", "load", "blow", "dropout", "short"])
def test_what_is_no_step_is_none(name):
    t = np.arange(int(200 * RATE)) / RATE
    x = ridden()
    if name == "route":
        drive = synthetic(seconds=200, rate=RATE, seed=4)
        x = drive.recording.whole(["S1"])[0]
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
    (health,) = survey([x[None]], rate=RATE)
    assert health.at(ZERO_STEP).count == 0


def test_the_command_tells_of_it(stepped, tmp_path):
    path = tmp_path / "a.csv"
    t = np.arange(stepped.size) / RATE
    np.savetxt(
        path, np.stack([t, stepped], -1), delimiter=",", comments="", fmt="%.6g",
        header="time,S1 [MPa]",
    )  # fmt: skip
    options = [str(path), "--gauge", "S1", "--sn", "30,2e6,5", "--json", str(tmp_path / "a.json")]
    done = CliRunner().invoke(command, [*options, "--target-hours", "1"])
    assert done.exit_code == 1
    assert "steps of the zero: 2, the first at 61.3 s" in done.output
    assert "--mask or --accept zero-step" in done.output
    done = CliRunner().invoke(command, [*options, "--mask", "S1=zero-step"])
    assert done.exit_code == 0, done.output
    found = json.loads((tmp_path / "a.json").read_text())
    assert found["gauges"][0]["quality"]["verdict"] == "good"
