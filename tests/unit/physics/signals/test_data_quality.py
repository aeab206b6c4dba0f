"""What is spoiled is listed, counted both ways, and never told as if it were known."""

import json

import numpy as np
import pytest
from click.testing import CliRunner

from cardan.cli.life import life as command
from cardan.core.errors import DesignError
from cardan.core.units import MPa
from cardan.physics.fatigue.damage import miner_damage
from cardan.physics.fatigue.rainflow import rainflow
from cardan.physics.fatigue.sn_curve import SNCurve
from cardan.physics.fatigue.strain_gauges import single_gauge
from cardan.physics.signals.assessment import AssessmentSettings, assess_gauges
from cardan.physics.signals.data_quality import FaultRule, apply_rules
from cardan.physics.signals.recording import recording_from_arrays
from cardan.topics.recording.options import AnalysisOptions

RATE = 1000.0
CURVE = SNCurve(amplitude=30 * MPa, cycles=2e6, slope=5).modified()
PLAN = AssessmentSettings(gauges=(single_gauge("S1", "S1", factor=MPa),), curve=CURVE)
T = np.arange(60_000) / RATE


def clean(seed=0):
    return 30 * np.sin(2 * np.pi * 11 * T) + np.random.default_rng(seed).normal(size=T.size)


def of(x, *rules, rate=RATE, **more):
    recording = recording_from_arrays(np.atleast_2d(x), rate=rate, names=["S1"], units=["MPa"])
    plan = AssessmentSettings(gauges=PLAN.gauges, curve=CURVE, fault_rules=rules, **more)
    return assess_gauges(recording, plan=plan)[0]


def mask(kind):
    return FaultRule(mask=True, kind=kind)


def accept(kind):
    return FaultRule(mask=False, kind=kind)


TRUE = of(clean())


def spoiled(kind):
    x = clean()
    if kind == "sentinel":
        x[[9000, 30_000, 30_001]] = -9999.0
    if kind == "spike":
        x[0] = x[44_000] = 400.0
    if kind == "dropout":
        x[7000:7008] = 400.0
    return x


def test_spike_within_ringing_is_detected():
    """Among steps as large it stood out of nothing: the damage stood a third too high.

    Rings of 60 Hz at 1 kHz, and half-sines of 4 ms, are none; of 80 spikes put into the largest
    blows of drives 80 are found, where it was 75, and none of 300 clean gauges shows one.
    """
    x = clean()
    s = T[:400]
    for at in (10_000, 30_000):
        x[at : at + 400] += 160 * np.exp(-15 * s) * np.sin(2 * np.pi * 60 * s)
        x[at + 9000 : at + 9004] += 160 * np.sin(np.pi * np.arange(1, 5) / 5)
    assert "spike" not in of(x).channel_reports["S1"].faults
    x[10_018] -= 220.0
    np.testing.assert_array_equal(
        of(x).channel_reports["S1"].faults["spike"].runs, [[10_018, 10_019]]
    )


@pytest.mark.parametrize("kind", ["sentinel", "spike", "dropout"])
def test_fault_that_dominates_damage_rejects_the_life(kind):
    """Kept as recorded, counted without, and no answer until somebody decides."""
    x = spoiled(kind)
    kept, masked, accepted = of(x), of(x, mask(kind)), of(x, accept(kind))
    assert TRUE.quality.verdict == "good"
    assert kept.quality.vetoes == (kind,)
    raw = miner_damage(rainflow(x * MPa), curve=CURVE)
    assert kept.life.damage == accepted.life.damage == pytest.approx(raw, rel=1e-12)
    (effect,) = kept.quality.effects
    assert effect.damage_recorded == kept.life.damage > 2 * TRUE.life.damage
    # A dozen samples of 60,000 are not there.
    assert effect.damage_without == masked.life.damage == pytest.approx(TRUE.life.damage, rel=1e-3)
    assert not masked.vetoed
    assert not accepted.vetoed


def test_quality_rules_apply_by_channel_and_time():
    x = spoiled("spike")
    half = of(x, FaultRule(mask=True, kind="spike", first=40.0))
    (effect,) = half.quality.effects
    assert (effect.count, effect.undecided) == (2, 1)
    assert half.vetoed
    assert effect.damage_without < half.life.damage < effect.damage_recorded
    other = of(x, FaultRule(mask=True, kind="spike", channel="S2"))
    assert other.life.damage == effect.damage_recorded
    late = of(x, mask("spike"), FaultRule(mask=False, kind="spike", first=40.0))
    assert late.life.damage == of(x, FaultRule(mask=True, kind="spike", last=40.0)).life.damage
    window = of(
        x, FaultRule(mask=True, first=44.0, last=44.0), FaultRule(mask=True, first=0.0, last=0.0)
    )
    assert window.life.damage == of(x, mask("spike")).life.damage


@pytest.mark.parametrize("way", ["frozen", "missing", "masked"])
def test_missing_half_of_recording_does_not_extend_life(way):
    """Half of it gone had been twice the life. Edges cost a cycle of 660."""
    x, rules = clean(), ()
    if way == "frozen":
        x[30_000:] = x[30_000]
    elif way == "missing":
        x[30_000:] = np.nan
    else:
        rules = (FaultRule(mask=True, first=30.0),)
    one = of(x, *rules)
    assert one.life.duration == pytest.approx(30, abs=0.01)
    assert one.life.hours == pytest.approx(TRUE.life.hours, rel=0.02)
    assert one.life.damage == pytest.approx(TRUE.life.damage / 2, rel=0.02)
    # What a freeze hides nobody decided on; what is missing, or masked, is known to be.
    assert one.quality.verdict == ("data rejected" if way == "frozen" else "doubtful")
    if way == "frozen":
        assert one.quality.vetoes == ("freeze",)
        assert of(x, mask("freeze")).quality.verdict == "doubtful"
        assert of(x, accept("freeze")).life.hours == pytest.approx(2 * one.life.hours, rel=1e-3)
        assert of(x, mask("freeze")).life.hours == pytest.approx(one.life.hours, rel=1e-3)


def test_gauge_with_little_valid_data_is_rejected():
    x = clean()
    x[12_000:] = np.nan
    assert of(x).quality.vetoes == ("hole",)


def test_clipping_rejects_the_life():
    """Half of the samples cut off: the damage left is far too small, and says nothing."""
    x = np.clip(clean(), -21, 21)
    one = of(x)
    assert 0.4 < one.channel_reports["S1"].clipped / x.size < 0.6
    assert one.quality.vetoes == ("clip",)
    (effect,) = one.quality.effects
    assert effect.damage_recorded < 0.05 * TRUE.life.damage
    # An estimate, on the low side: noise cuts a crest in parts.
    assert 5 * effect.damage_recorded < effect.damage_without < TRUE.life.damage
    assert not of(x, accept("clip")).vetoed


@pytest.mark.parametrize("hertz", [11.0, 1.0, 0.2])
@pytest.mark.parametrize("cut", [0.25, 0.05])  # of the samples, at either end
def test_clipping_rejects_the_life_at_any_frequency(hertz, cut):
    """Wherever it costs more than a fifth of the damage, the life is vetoed."""
    x = 35 * np.sin(2 * np.pi * hertz * T) + 0.5 * np.random.default_rng(3).normal(size=T.size)
    x = np.round(x * 20) / 20
    truth = of(x).life.damage
    one = of(np.clip(x, *np.quantile(x, [cut, 1 - cut])))
    assert one.life.damage < 0.95 * truth
    assert one.vetoes == ("clip",)


def test_signal_that_drops_to_zero_is_not_clipped():
    x = clean()
    for k in range(500, 60_000, 6000):
        x[k : k + 100] = 0.0
    assert "clip" not in of(x).channel_reports["S1"].faults


def test_damage_is_computed_with_and_without_drift():
    x = clean() + 300 * T / 60
    one = of(x)
    (effect,) = one.quality.effects
    assert effect.kind == "drift"
    assert one.quality.vetoes == ("drift",)
    assert effect.damage_recorded > 1.2 * effect.damage_without
    assert not of(x, accept("drift")).vetoed


@pytest.mark.parametrize("hertz", [97.0, 41.0])
def test_damage_includes_peaks_between_samples(hertz):
    """A 97 Hz tone met 3.1 times a turn had lost half its damage; of one met often, nothing moves.

    Its true damage: 97 cycles a second at its amplitude.
    """
    rate = 300.0 if hertz == 97 else 1000.0
    t = np.arange(round(60 * rate)) / rate
    x = 40 * np.sin(2 * np.pi * hertz * t + 0.2)
    one = of(x, rate=rate)
    truth = 60 * hertz * float(CURVE.damage(40 * MPa))
    raw = miner_damage(rainflow(x * MPa), curve=CURVE)
    if hertz == 97:
        # Eight times finer, crests still lose (π 97/2400)²/6 of their height.
        assert one.life.damage == pytest.approx(truth * (1 - 5 * 0.00269), rel=2e-3)
        assert one.quality.damage_of_samples_only == pytest.approx(raw, rel=1e-12)
        assert raw < 0.7 * truth
        assert of(x, rate=rate, interpolate_crests=False).life.damage == pytest.approx(
            raw, rel=1e-12
        )
    else:
        assert np.isnan(one.quality.damage_of_samples_only)
        assert one.life.damage == pytest.approx(raw, rel=1e-12)
        assert of(x, rate=rate, interpolate_crests=True).life.damage == pytest.approx(
            truth, rel=0.002
        )


def test_aliased_power_share_is_reported():
    noise = 20 * np.random.default_rng(1).normal(size=60_000)
    assert of(noise).quality.high_frequency_share == pytest.approx(0.2, abs=0.02)
    assert of(clean()).quality.high_frequency_share < 1e-3


# --------------------------------------------------------------------------- by the command

ONE = ("--gauge", "S1:MPa", "--sn", "30,2e6,5")


def run(*arguments):
    return CliRunner().invoke(command, [str(a) for a in arguments])


def written(tmp_path, columns, name="a.csv", clock="time"):
    scale = 1e3 if "ms" in clock else 1e9 if "ns" in clock else 1.0
    rows = np.stack([T[: len(next(iter(columns.values())))] * scale, *columns.values()], -1)
    head = ",".join([clock, *columns])
    np.savetxt(tmp_path / name, rows, "%.9g", delimiter=",", header=head, comments="")
    return tmp_path / name


@pytest.mark.slow
def test_damage_that_a_freeze_may_hide_is_on_the_first_screen_and_in_json(tmp_path):
    x = clean() * (1 + 0.5 * np.sin(2 * np.pi * 0.31 * T))
    x[20_000:32_000] = x[20_000]
    path = written(tmp_path, {"S1": x})
    screen = " ".join(run(path, *ONE, "--target-hours", "1e-9").output.split())
    assert "if the 12 s that it hides were like the worst recorded" in screen
    assert "--mask or --accept freeze" in screen
    document = json.loads(run(path, *ONE, "--json").output)
    (gauge,) = document["gauges"]
    (suspect,) = gauge["quality"]["suspects"]
    assert gauge["quality"]["vetoes"] == ["freeze"]
    assert suspect["hidden_s"] == pytest.approx(12, abs=0.01)
    assert suspect["damage_if_worst"] > 1.2 * suspect["damage_recorded"]
    masked = (*ONE, "--mask", "freeze")
    (gauge,) = json.loads(run(path, *masked, "--json").output)["gauges"]
    screen = run(path, *masked, "--target-hours", str(0.95 * gauge["hours"])).output
    assert "missing or frozen time like the worst recorded" in " ".join(screen.split())


@pytest.mark.slow
def test_rejected_life_passes_no_target(tmp_path):
    path = written(tmp_path, {"S1": spoiled("sentinel")})
    for more in ((), ("--target-hours", "1e-9")):
        done = run(path, *ONE, *more, "--json")
        assert done.exit_code == 1, done.output
        document = json.loads(done.output)
        assert document["verdict"] == "incomplete"
        (gauge,) = document["gauges"]
        assert gauge["quality"]["verdict"] == "data rejected"
        assert gauge["quality"]["vetoes"] == ["sentinel"]
        assert gauge["hours"] is None
        (suspect,) = gauge["quality"]["suspects"]
        assert suspect["damage_recorded"] == gauge["damage"] > 100 * suspect["damage_without"]
        (listed,) = document["channels"][0]["suspects"]
        assert [p["from_s"] for p in listed["places"]] == [9.0, 30.0]
    told = run(path, *ONE, "--target-hours", "1e-9").output
    assert "S1: DATA REJECTED (review needed): the damage depends on sentinel" in told
    assert "--mask or --accept sentinel" in told
    ruled = run(path, *ONE, "--target-hours", "1e-9", "--mask", "S1=sentinel@0..60", "--json")
    assert ruled.exit_code == 0, ruled.output
    document = json.loads(ruled.output)
    assert document["rules"]["masked"] == [
        {"channel": "S1", "kind": "sentinel", "from_s": 0.0, "to_s": 60.0}
    ]
    assert document["gauges"][0]["hours"] == pytest.approx(TRUE.life.hours, rel=1e-3)
    assert run(path, *ONE, "--mask", "8.9..9.1", "--mask", "29..31").exit_code == 0


def test_rosette_biaxiality_in_torsion_is_reported(tmp_path):
    """A shaft's rosette in torsion: grids at 0, 45 and 90 degrees feel 0, g/2 and 0."""
    shear = 600 * np.sin(2 * np.pi * 7 * T[:6000])
    grids = {"a": 0.004 * shear, "b": shear / 2, "c": -0.004 * shear}
    path = written(tmp_path, grids)
    done = run(path, "--rosette", "R=a,b,c:um/m", "--sn", "30,2e6,5", "--json")
    quality = json.loads(done.output)["gauges"][0]["quality"]
    assert quality["biaxiality"] == pytest.approx(-1, abs=0.02)
    assert quality["verdict"] == "doubtful"
    by = quality["damage_by_measure"]
    # Across the plane at 45 degrees: the shear stress itself, G 79.2 GPa.
    tau = 206e9 / 2.6 * 600e-6 * np.sin(2 * np.pi * 7 * T[:6000])
    assert by["planes"] == pytest.approx(miner_damage(rainflow(tau), curve=CURVE), rel=0.03)
    assert by["mises"] > 5 * by["planes"]
    said = run(path, "--rosette", "R=a,b,c:um/m", "--sn", "30,2e6,5").output
    assert "R: mostly shear (biaxiality -1" in " ".join(said.split())
    assert "no suspect data found" not in said
    pull = {"a": shear, "b": 0.35 * shear, "c": -0.3 * shear}
    path = written(tmp_path, pull)
    done = run(path, "--rosette", "R=a,b,c:um/m", "--sn", "30,2e6,5", "--json")
    quality = json.loads(done.output)["gauges"][0]["quality"]
    assert quality["biaxiality"] == pytest.approx(0, abs=0.01)
    assert quality["verdict"] == "good"


@pytest.mark.slow
@pytest.mark.parametrize("name", ["Time_ms", "time_ms", "Time (ms)", "t ms", "Zeit[ms]", "time_ns"])
def test_time_unit_is_read_from_column_name(tmp_path, name):
    path = written(tmp_path, {"S1": clean()}, clock=name)
    for more in ((), ("--time", name.partition("[")[0].partition(" (")[0])):
        done = run(path, *ONE, "--json", *more)
        assert done.exit_code == 0, done.output
        assert json.loads(done.output)["rate_Hz"] == pytest.approx(RATE)


@pytest.mark.parametrize(
    ("more", "said"),
    [
        (("--ultimate-MPa", "0", "--mean-stress", "goodman"), "--ultimate-MPa"),
        (("--ultimate-MPa", "nan", "--mean-stress", "goodman"), "--ultimate-MPa"),
        (("--allowed", "-1"), "--allowed must be above 0"),
        (("--scatter", "-0.1"), "--scatter must be at least 0"),
        (("--scatter", "inf"), "--scatter must be at least 0 and at most 1"),
        (("--gauge-error", "2"), "--gauge-error"),
        (("--mean-sensitivity", "-1", "--mean-stress", "fkm"), "--mean-sensitivity"),
        (("--mean-sensitivity", "nan", "--mean-stress", "walker"), "--mean-sensitivity"),
        (("--modulus-GPa", "inf"), "--modulus-GPa"),
        (("--low-pass-Hz", "0"), "--low-pass-Hz must be above 0"),
        (("--pulses", "0"), "--pulses must be at least 1"),
        (("--bearing", "0"), "--bearing must be at least 1"),
        (("--joint-orders", "2,-4"), "--joint-orders"),
        (("--engine-orders", "nan"), "--engine-orders"),
        (("--predicted", "S11=4", "--torque", "S1:Nm"), "no gauge 'S11'; did you mean S1?"),
        (("--predicted", "S1=4"), "name it with --torque"),
        (("--predicted", "S1=nan", "--torque", "S1:Nm"), "GAUGE=MPa_per_kNm"),
        (("--mask", "spikes"), "no kind of fault 'spikes'"),
        (("--mask", "clip"), "a clip cannot be masked"),
        (("--mask", "S3=spike"), "no gauge's channel 'S3'"),
        (("--mask", "9..3"), "a time is FROM..TO"),
        (("--mask", "spike@x..y"), "a time is FROM..TO"),
        (("--accept", ""), "a rule is"),
        (("--mask", "S1=spike", "--accept", "S1=spike"), "say two things of the same"),
        (("--mask", "spike@2..6", "--accept", "spike@5..9"), "--mask spike@2..6 and --accept"),
        (("--joint-orders", "3,4"), "--joint-orders are of 2, 4 and 6, got 3"),
        (("--crack-threshold", "2"), "--crack-threshold does nothing by itself: it needs --crack"),
        (("--crack-shape", "1"), "it needs --crack"),
        (("--strain-life", "900,-0.09,60,-0.6"), "EPSILON_F of a strain-life curve is a strain"),
        (("--strain-mean", "morrow"), "it needs --strain-life"),
        (("--miner-scatter", "0.2"), "it needs --service-hours"),
        (("--mean-sensitivity", "0.2"), "it needs --mean-stress fkm or walker"),
        (("--mean-sensitivity", "0.2", "--mean-stress", "swt"), "it needs --mean-stress fkm"),
        (("--state", "empty"), "it needs --application"),
        (("--bearing", "2"), "it needs --application"),
        (("--rosette-measure", "planes"), "it needs --rosette"),
        (("--rosette-kind", "delta"), "it needs --rosette"),
        (("--pulses", "60"), "--pulses does nothing by itself: it needs --tacho"),
        (("--speed", "S1:rpm", "--tacho", "S1"), "turned by --speed or by --tacho: say one"),
        (("--tacho", "S1", "--estimate-speed", "S1"), "turned by --tacho or by --estimate-speed"),
    ],
)
def test_option_out_of_range_is_rejected(tmp_path, more, said):
    path = written(tmp_path, {"S1": clean()[:3000]})
    done = run(path, *ONE, *more)
    assert done.exit_code == 2, done.output
    assert said in done.output


@pytest.mark.parametrize(
    "sn", ["0,2e6,5", "30,0,5", "30,2e6,0", "nan,2e6,5", "30,inf,5", "30,2e6,nan"]
)
def test_sn_curve_out_of_range_is_rejected(tmp_path, sn):
    path = written(tmp_path, {"S1": clean()[:3000]})
    done = run(path, "--gauge", "S1:MPa", "--sn", sn)
    assert done.exit_code == 2, done.output


@pytest.mark.parametrize(
    ("masks", "accepts", "places"),
    [("S1=spike", "spike", [0, 44]), ("spike", "S1=spike", []),
     ("S1=spike", "spike@0..3", [44]), ("spike@0..3", "S1=spike", [0]),
     ("S1=spike@0..3", "spike@0..60", [0])],
)  # fmt: skip
def test_rule_for_channel_takes_precedence_over_general_rule(masks, accepts, places):
    """An accept of all had beaten a mask of one: 36 h of life were told as 2.8."""
    campaign = AnalysisOptions(sn="30,2e6,5", mask=(masks,), accept=(accepts,))
    health = of(spoiled("spike")).channel_reports["S1"]
    told = apply_rules(health, channel="S1", rules=campaign.rules, rate=RATE)["spike"]
    assert (told.masked[:, 0] / RATE).tolist() == places
    assert not len(told.undecided)


def test_rules_are_ordered_by_precedence():
    campaign = AnalysisOptions(sn="30,2e6,5", mask=("spike",), accept=("S1=spike@2..",))
    first, last = campaign.rules
    assert (first.mask, last.mask) == (True, False)
    assert (last.channel, last.first, last.last) == ("S1", 2.0, np.inf)
    # What names a time says more, whichever it is.
    campaign = AnalysisOptions(sn="30,2e6,5", mask=("S1=spike@2..3",), accept=("spike", "drift"))
    assert [(rule.mask, rule.kind) for rule in campaign.rules] == [
        (False, "spike"), (False, "drift"), (True, "spike"),
    ]  # fmt: skip
    with pytest.raises(DesignError, match="no kind"):
        AnalysisOptions(sn="30,2e6,5", accept=("everything",))
