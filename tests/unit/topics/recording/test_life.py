"""From a recording to life and cause: the whole way, on synthetic recordings with known truth."""

import json
import tracemalloc
from dataclasses import replace

import jsonschema
import numpy as np
import pytest
from click.testing import CliRunner
from repository import ROOT

from cardan.cli.life import life as command
from cardan.core.errors import DesignError
from cardan.core.units import MPa
from cardan.documents.approval_schema import schema
from cardan.physics.fatigue.damage import miner_damage
from cardan.physics.fatigue.rainflow import rainflow, repeating
from cardan.physics.fatigue.sn_curve import SNCurve
from cardan.physics.fatigue.spectral import welch_spectrum
from cardan.physics.fatigue.strain_gauges import rosette_gauge, single_gauge
from cardan.physics.signals.assessment import (
    AssessmentSettings,
    assess_gauges,
    survey_channel_quality,
)
from cardan.physics.signals.cause_assessment import attribute_damage
from cardan.physics.signals.conditioning import baseline_at_median
from cardan.physics.signals.damage_attribution import (
    CAUSE_JOINTS,
    CAUSE_SUDDEN_EVENTS,
    ShapleyAttribution,
    source_separation,
    vibration_sources,
)
from cardan.physics.signals.data_quality import FaultRule
from cardan.physics.signals.order_tracking import ShaftRotation
from cardan.physics.signals.recording import SAMPLES_PER_BLOCK, recording_from_arrays
from cardan.physics.signals.synthetic import GaugeStressPerCause, synthetic_recording
from cardan.topics.recording.presentation import joint_verdict_sentence as verdict

RATE = 1000.0
CURVE = SNCurve(amplitude=30 * MPa, cycles=2e6, slope=5, scatter=0.05).modified()
GUILTY = GaugeStressPerCause(joints=40 * MPa, events=25 * MPa, road=4 * MPa)
INNOCENT = GaugeStressPerCause(joints=3 * MPa, events=70 * MPa)
PLAN = AssessmentSettings(
    gauges=(single_gauge("S1", "S1", factor=MPa), single_gauge("S2", "S2", factor=MPa)), curve=CURVE
)


@pytest.fixture(scope="module")
def drive():
    return synthetic_recording(seconds=150, rate=RATE, gains={"S1": GUILTY, "S2": INNOCENT}, seed=5)


def test_streamed_life_matches_count_of_whole_signal(drive):
    """290 pieces' worth of bookkeeping against one call on the whole array."""
    found = assess_gauges(drive.recording, plan=PLAN, distance=5e3)
    for one, x in zip(found, drive.recording.read_all(["S1", "S2"]) * MPa, strict=True):
        assert one.life.damage == pytest.approx(miner_damage(rainflow(x), curve=CURVE), rel=1e-9)
        assert (one.min_stress, one.max_stress) == (x.min(), x.max())
        assert one.life.hours == pytest.approx(150 / 3600 / one.life.damage)
        assert one.life.kilometres == pytest.approx(5 / one.life.damage)
        assert one.repeats[0.5] == pytest.approx(one.life.repeats, rel=1e-9)
        assert one.repeats[0.1] < one.repeats[0.5] < one.repeats[0.9]
        assert 5 <= one.damage_exponent <= 9
        assert one.spectrum.moment(0) == pytest.approx(
            welch_spectrum([x], rate=RATE).moment(0), rel=1e-9
        )


@pytest.mark.slow
def test_gauge_result_is_independent_of_other_gauges():
    """Of many gauges pieces are shorter; spectra knew the cuts by a thousandth, and chatter too."""
    x = np.random.default_rng(3).normal(0, 20, SAMPLES_PER_BLOCK + SAMPLES_PER_BLOCK // 3)
    x[: SAMPLES_PER_BLOCK // 2] *= 0.2
    names = [f"S{k}" for k in range(8)]
    recording = recording_from_arrays(np.tile(x, (8, 1)), rate=RATE, names=names)
    gauges = tuple(single_gauge(n, n, factor=MPa) for n in names)
    plan = AssessmentSettings(gauges=gauges, curve=CURVE, interpolate_crests=False)
    alone, *_ = assess_gauges(recording, plan=replace(plan, gauges=gauges[:1]))
    beside, *_ = assess_gauges(recording, plan=plan)
    whole = welch_spectrum([x * MPa], rate=RATE, segment=plan.segment_samples)
    assert alone.spectrum is not None
    assert beside.spectrum is not None
    for order in (0, 2, 4):
        moment = pytest.approx(whole.moment(order), rel=1e-12)
        assert moment == alone.spectrum.moment(order)
        assert moment == beside.spectrum.moment(order)
    assert beside.quality.high_frequency_share == pytest.approx(
        alone.quality.high_frequency_share, rel=1e-12
    )
    assert beside.life.damage == pytest.approx(alone.life.damage, rel=1e-12)


@pytest.mark.slow
def test_peak_reconstruction_memory_is_limited_to_one_block():
    """All at once they took 251 MB here, and 154 now."""
    rate, n = 500.0, SAMPLES_PER_BLOCK + SAMPLES_PER_BLOCK // 4
    t = np.arange(n) / rate
    data = np.stack([20 * np.sin(2 * np.pi * 60 * t + k) for k in range(3)])
    names = [f"S{k}" for k in range(3)]
    recording = recording_from_arrays(data, rate=rate, names=names)
    plan = AssessmentSettings(
        gauges=tuple(single_gauge(n, n, factor=MPa) for n in names), curve=CURVE,
        interpolate_crests=True,
    )  # fmt: skip
    healths = survey_channel_quality(recording, channels=names)
    tracemalloc.start()
    found = assess_gauges(recording, plan=plan, healths=healths)
    _, most = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert not np.isnan(found[0].quality.damage_of_samples_only)
    assert most < 190e6


def test_zero_offset_spikes_and_residue_are_handled(drive):
    """Two spikes of 900 MPa: counted both ways, kept unless a rule masks them."""
    x = drive.recording.read_all(["S1"]).copy()
    dirty = x + 500
    dirty[0, [5000, 90_000]] += 900
    recording = recording_from_arrays(dirty, rate=RATE, names=["S1"], units=["MPa"])
    plan = AssessmentSettings(
        gauges=PLAN.gauges[:1],
        curve=CURVE,
        baseline=baseline_at_median,
        residue_rule=repeating,
        allowed=0.5,
    )
    kept = assess_gauges(recording, plan=plan)[0]
    one = assess_gauges(
        recording, plan=replace(plan, fault_rules=(FaultRule(mask=True, kind="spike"),))
    )[0]
    assert one.channel_reports["S1"].spikes == 2
    clean = miner_damage(rainflow(x[0] * MPa, rule=repeating), curve=CURVE)
    # No mean-stress correction: the zero shifts nothing; two samples less change little.
    assert one.life.damage == pytest.approx(clean, rel=1e-3)
    assert one.life.repeats == pytest.approx(0.5 / one.life.damage)
    assert one.repeats[0.5] == pytest.approx(one.life.repeats, rel=1e-9)
    assert abs(one.max_stress + one.min_stress) < abs(dirty.max() * MPa)
    spiked = miner_damage(rainflow(dirty[0] * MPa, rule=repeating), curve=CURVE)
    assert kept.life.damage == pytest.approx(spiked, rel=1e-9)
    assert kept.vetoed
    assert not one.vetoed
    accepted = assess_gauges(
        recording, plan=replace(plan, fault_rules=(FaultRule(mask=False, kind="spike"),))
    )[0]
    assert not accepted.vetoed
    assert accepted.life.damage == kept.life.damage
    for told in (kept, one, accepted):
        (effect,) = told.quality.effects
        assert (effect.kind, effect.samples) == ("spike", 2)
        assert effect.damage_recorded == pytest.approx(spiked, rel=1e-9)
        assert effect.damage_without == pytest.approx(clean, rel=1e-3)


def test_low_pass_filter_removes_fast_stress(drive):
    slow = assess_gauges(
        drive.recording, plan=AssessmentSettings(gauges=PLAN.gauges, curve=CURVE, low_pass=5.0)
    )
    fast = assess_gauges(drive.recording, plan=PLAN)
    assert slow[0].life.damage < 0.01 * fast[0].life.damage


def test_rosette_gives_one_equivalent_stress():
    """Uniaxial tension along grid a: von Mises is the tension itself."""
    t = np.arange(20_000) / RATE
    pull = 300 * np.sin(2 * np.pi * 7 * t)  # µm/m
    recording = recording_from_arrays(
        np.stack([pull, 0.35 * pull, -0.3 * pull]), rate=RATE, names=["a", "b", "c"]
    )
    plan = AssessmentSettings(gauges=(rosette_gauge("R1", ("a", "b", "c")),), curve=CURVE)
    one = assess_gauges(recording, plan=plan)[0]
    assert one.max_stress == pytest.approx(206e9 * 300e-6, rel=1e-3)
    assert set(one.channel_reports) == {"a", "b", "c"}


def test_rosette_grids_with_different_units_are_converted(tmp_path):
    """One logger writes m/m, the others µm/m: the stress is that of all in one unit."""
    pytest.importorskip("pyarrow")
    t = np.arange(2000) / 200.0
    grids = np.stack([300 * np.sin(9 * t), 200 * np.sin(11 * t + 1), 400 * np.sin(7 * t + 2)])

    def damage(units, *more):
        scaled = grids / np.array([1e6 if u == "m/m" else 1.0 for u in units])[:, None]
        path = tmp_path / "r.csv"
        head = ",".join(("time", *(f"{n} [{u}]" for n, u in zip("abc", units, strict=True))))
        np.savetxt(path, np.vstack([t, scaled]).T, delimiter=",", header=head, comments="")
        done = CliRunner().invoke(
            command, [str(path), "--rosette", "R=a,b,c", "--sn", "30,2e6,5", "--json", *more]
        )
        assert done.exit_code == 0, done.output
        return json.loads(done.stdout)["gauges"][0]["damage"]

    alike = damage(["um/m"] * 3)
    assert damage(["um/m", "um/m", "m/m"]) == pytest.approx(alike, rel=1e-9)
    with pytest.raises(AssertionError, match="'V'; write c:UNIT"):
        damage(["um/m", "um/m", "V"])


def test_rosette_planes_are_evaluated_as_separate_gauges(tmp_path):
    """Tension along grid a is felt most on the plane across it, not at all on the one along."""
    t = np.arange(6000) / RATE
    pull = 300 * np.sin(2 * np.pi * 7 * t)
    rows = np.stack([t, pull, 0.35 * pull, -0.3 * pull], -1)
    head = "time,a [um/m],b [um/m],c [um/m]"
    np.savetxt(tmp_path / "r.csv", rows, delimiter=",", header=head, comments="")
    done = run(
        tmp_path / "r.csv", "--rosette", "R1=a,b,c", "--rosette-measure", "planes",
        "--sn", "30,2e6,5", "--json",
    )  # fmt: skip
    assert done.exit_code == 0, done.output
    gauges = {g["name"]: g for g in json.loads(done.output)["gauges"]}
    assert len(gauges) == 20
    worst = max(gauges.values(), key=lambda g: g["damage"])
    assert worst["name"] == "R1@0"
    assert worst["high_MPa"] == pytest.approx(61.8, rel=1e-3)
    assert abs(gauges["R1@90"]["high_MPa"]) < 1e-6


def test_dead_and_empty_recordings_are_rejected():
    dead = recording_from_arrays(np.full((2, 5000), np.nan), rate=RATE, names=["S1", "S2"])
    with pytest.raises(DesignError, match="no samples to count"):
        assess_gauges(dead, plan=PLAN)
    with pytest.raises(DesignError, match="holds no samples"):
        survey_channel_quality(
            recording_from_arrays(np.empty((2, 0)), rate=RATE, names=["S1", "S2"]), channels=["S1"]
        )


def test_verdict_text_names_dominating_cause():
    guilty = ShapleyAttribution((CAUSE_JOINTS, CAUSE_SUDDEN_EVENTS), np.array([0, 0.8, 0.1, 1.0]))
    assert verdict("S1", guilty) == (
        "S1: the joints' orders account for 85.0 % of the damage; "
        "without them it would live 10 times as long."
    )
    innocent = ShapleyAttribution((CAUSE_JOINTS, CAUSE_SUDDEN_EVENTS), np.array([0, 0.0, 1.0, 1.0]))
    assert "0.0 % of the damage" in verdict("S1", innocent)
    assert "The largest share, 100.0 %, is of events." in verdict("S1", innocent)
    assert "no cause" in verdict("S1", ShapleyAttribution((CAUSE_JOINTS,), np.zeros(2)))


@pytest.fixture(scope="module")
def parquet(drive, tmp_path_factory):
    pa = pytest.importorskip("pyarrow")
    from pyarrow import parquet as pq

    path = tmp_path_factory.mktemp("life") / "drive.parquet"
    schema = pa.schema(
        [
            pa.field(c.name, pa.float32(), metadata={"unit": c.unit})
            for c in drive.recording.channels
        ],
        metadata={"rate_Hz": "1000", "note": drive.recording.notes[0]},
    )
    columns = [x.astype(np.float32) for x in drive.recording.read_all()]
    pq.write_table(pa.table(columns, schema=schema), path)
    return path


def run(*arguments):
    return CliRunner(env={"COLUMNS": "400"}).invoke(command, [str(a) for a in arguments])


ALL = (
    "--gauge", "S1", "--gauge", "S2", "--sn", "30,2e6,5", "--scatter", "0.05",
    "--speed", "shaft_speed", "--engine", "engine_speed", "--axle-ratio", "4.3",
    "--tyre-radius-m", "0.5", "--torque", "torque", "--predicted", "S1=4",
    "--predicted", "S2=0.3",
)  # fmt: skip


@pytest.mark.slow
def test_life_command_prints_life_and_causes(parquet):
    done = run(parquet, *ALL, "--all")
    assert done.exit_code == 0, done.output
    assert "synthetic: made by a generator, not measured" in done.output
    assert "S1: the joints' orders account for" in done.output
    assert "Shares are Shapley values" in done.output
    assert "residue: half cycles" in done.output


@pytest.mark.slow
def test_life_json_conforms_to_schema(parquet, drive, tmp_path):
    done = run(parquet, *ALL, "--json", tmp_path / "out.json")
    assert done.exit_code == 0, done.output
    document = json.loads((tmp_path / "out.json").read_text())
    contract = {"$defs": schema()["$defs"], "$ref": "#/$defs/life"}
    jsonschema.validate(document, contract, jsonschema.Draft202012Validator)
    first, second = document["gauges"]
    shares = {c["cause"]: c["share"] for c in first["causes"]}
    assert sum(shares.values()) == pytest.approx(1)
    assert shares[CAUSE_JOINTS] > 0.5
    assert {c["cause"]: c["share"] for c in second["causes"]}[CAUSE_JOINTS] < 0.1
    cut = first["order2_by_speed"]
    assert [c["rpm"] for c in cut] == sorted(c["rpm"] for c in cut)
    # Bands of 100 rpm by their middles; a span of a second or two cuts no more off the top.
    fastest = 60 * drive.shaft.speed(np.arange(0, 150, 0.1)).max()
    assert fastest - 250 < cut[-1]["rpm"] < fastest + 50
    assert 0 < max(c["MPa"] for c in cut) < 40
    assert first["order2"]["ratio"] == pytest.approx(1, abs=0.05)  # truth: 4 MPa per kN m
    x = drive.recording.read_all(["S1"])[0].astype(np.float32) * MPa
    assert first["damage"] == pytest.approx(miner_damage(rainflow(x), curve=CURVE), rel=1e-6)
    driven = drive.shaft.turns[-1] / 4.3 * 2 * np.pi * 0.5
    assert document["distance_km"] == pytest.approx(driven / 1e3, rel=1e-3)
    assert document["rules"]["shares"] == "Shapley"
    assert json.loads(run(parquet, *ALL[:6], "--json").output)["gauges"][0]["name"] == "S1"


@pytest.mark.slow
def test_damage_causes_are_attributed_per_gauge(drive):
    """Blows that one of them felt had been left out of the other's orders too."""
    recording, plan = drive.recording, AssessmentSettings(
        gauges=tuple(single_gauge(g, g, factor=MPa) for g in ("S1", "S2")), curve=CURVE
    )  # fmt: skip
    health = survey_channel_quality(recording, channels=plan.channels)
    how = source_separation(vibration_sources(drive.shaft), rate=recording.rate)

    def asked(of):
        return attribute_damage(recording, plan=of, healths=health, how=how, torque=("torque", 1e3))

    both = asked(plan)
    assert both.gauges == ("S1", "S2")
    for k, gauge in enumerate(plan.gauges):
        alone = asked(replace(plan, gauges=(gauge,)))
        assert alone.joint_attributions[0] == both.joint_attributions[k]
        np.testing.assert_array_equal(
            alone.attributions[0].damage_by_coalition, both.attributions[k].damage_by_coalition
        )
        np.testing.assert_array_equal(alone.order2[0], both.order2[k])
        np.testing.assert_array_equal(
            alone.cycles_without_joints[0].start, both.cycles_without_joints[k].start
        )
        assert set(alone.doubts) <= set(both.doubts)


@pytest.mark.slow
def test_tacho_or_estimated_speed_replaces_speed_channel(parquet):
    by_tacho = run(parquet, "--gauge", "S1", "--sn", "30,2e6,5", "--tacho", "tacho", "--all")
    assert "the joints' orders account for" in by_tacho.output
    guessed = run(parquet, "--gauge", "S1", "--sn", "30,2e6,5", "--estimate-speed", "S1", "--all")
    assert "the joints' orders account for" in guessed.output


@pytest.mark.slow
def test_target_hours_decide_exit_code(parquet):
    few, many = (run(parquet, *ALL[:6], "--target-hours", h).exit_code for h in ("1", "1e9"))
    assert (few, many) == (0, 1)


@pytest.mark.slow
def test_life_figure_is_written(parquet, tmp_path):
    pytest.importorskip("matplotlib")
    done = run(parquet, *ALL, "--plot", tmp_path / "life.svg")
    assert done.exit_code == 0, done.output
    drawn = (tmp_path / "life.svg").read_text()
    assert drawn.startswith("<?xml")


TRUCK = ROOT / "tests" / "truck.yaml"


@pytest.mark.slow
def test_application_file_predicts_second_order(parquet):
    """By the command, and by hand from the response's bearing force."""
    from cardan.application import reader
    from cardan.checks.line_response import compute_line_response
    from cardan.physics.vehicle.state_demand import line_state_demand, resolve_line_references
    from cardan.topics.recording.order2_prediction import order2_bearing_force_per_torque

    application = reader.read(TRUCK)
    asked = line_state_demand(resolve_line_references(application, application.lines[0]))
    row = asked.states.index("gvw")
    force = compute_line_response(application, asked).rigid_loads.joint_loads.bearing_forces.order(
        2
    )[row, 0]
    by_hand = abs(force[2]) * 35e-3 / asked.torque[row] * 1e3  # MPa per kN m, along z alone
    assert by_hand > 0
    np.testing.assert_allclose(
        np.abs(order2_bearing_force_per_torque(application, state="gvw")[2]) * 35,
        by_hand,
        rtol=1e-12,
    )
    done = run(
        parquet, *ALL[:18], "--application", TRUCK, "--unit-stress", "S1=0,0,35", "--json"
    )  # fmt: skip
    assert done.exit_code == 0, done.output
    order2 = json.loads(done.output)["gauges"][0]["order2"]
    assert order2["ratio"] == pytest.approx(4 / by_hand, rel=0.05)  # the truth is 4
    for more, said in (
        (("--state", "parked"), "no state 'parked'"), (("--bearing", "7"), "centre bearings")
    ):  # fmt: skip
        done = run(parquet, *ALL[:18], "--application", TRUCK, "--unit-stress", "S1=0,0,35", *more)
        assert done.exit_code == 2
        assert said in done.output


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (("--sn", "30,2e6,5"), "name the gauges with --gauge; drive.parquet has S1"),
        (("--gauge", "shaft_sped", "--sn", "30,2e6,5"), "did you mean 'shaft_speed'"),
        (("--gauge", "torque", "--sn", "30,2e6,5"), "write torque:UNIT"),
        (("--gauge", "S1", "--sn", "30"), "AMPLITUDE_MPa,CYCLES,SLOPE"),
        (("--gauge", "S1", "--sn", "30,2e6,-5"), "must be above 0 and at most 100, got -5"),
        (("--gauge", "S1", "--sn", "5,90,2e6"), "SLOPE of the S-N curve 5,90,2e6 must be above 0"),
        (("--gauge", "S1", "--sn", "2e6,30,5"), "AMPLITUDE_MPa of the S-N curve 2e6,30,5"),
        (("--gauge", "S1", "--sn", "30,2e6,5", "--mean-stress", "goodman"), "--ultimate-MPa"),
        (("--rosette", "R=S1,S2", "--sn", "30,2e6,5"), "three channels"),
        (("--rosette", "R=S1,S2,S1:um/m", "--sn", "30,2e6,5"), "rosette R: S1 stands in it twice"),
        (("--gauge", "S1", "--sn", "30,2e6,5", "--low-pass-Hz", "900"), "cutoff"),
        (("--gauge", "S1"), "--sn MPa,CYCLES,SLOPE"),
        ((*ALL, "--group", "fast"), "only files of MATLAB, HDF5, TDMS and MDF4 have groups"),
        ((*ALL, "--joint-orders", "a"), "--joint-orders: expected numbers with commas between"),
        ((*ALL, "--joint-orders", ""), "--joint-orders: expected numbers with commas between"),
        ((*ALL, "--engine-orders", "3;6"), "--engine-orders: expected numbers with commas between"),
        ((*ALL, "--strain-life", ""), "--strain-life: expected numbers with commas between"),
        ((*ALL, "--crack", "1,b"), "--crack: expected numbers with commas between"),
        ((*ALL, "--predicted", "S1:4"), "GAUGE=MPa_per_kNm"),
        ((*ALL, "--unit-stress", "S1=1,2,3"), "--application"),
    ],
)
def test_bad_options_are_rejected_with_message(parquet, arguments, said):
    done = run(parquet, *arguments)
    assert done.exit_code == 2
    assert said in done.output


def test_mean_stress_options_change_damage(parquet):
    def damage(*more):
        done = run(parquet, "--gauge", "S1", "--sn", "30,2e6,5", "--json", "-", *more)
        return json.loads(done.output)["gauges"][0]["damage"]

    plain = damage()
    assert damage("--mean-stress", "gerber", "--ultimate-MPa", "500") > plain
    assert damage("--mean-stress", "fkm", "--ultimate-MPa", "700") != plain
    assert damage("--mean-stress", "swt") != plain
    assert damage("--miner", "elementary") > plain > damage("--miner", "original")
    assert damage("--residue", "discard") < plain
    assert damage("--gauge", "S2:MPa") == plain


@pytest.mark.parametrize("n", [1, 2, 7, 100, 5000])
def test_recording_of_any_length_is_evaluated(n):
    """One sample does no harm; all causes together always do what the count says."""
    x = 50 * np.sin(np.arange(n) * 0.3)[None]
    recording = recording_from_arrays(x, rate=RATE, names=["S1"])
    plan = AssessmentSettings(gauges=PLAN.gauges[:1], curve=CURVE)
    healths = survey_channel_quality(recording, channels=["S1"])
    counted = assess_gauges(recording, plan=plan, healths=healths)[0].life.damage
    shaft = ShaftRotation(np.array([0.0, 10.0]), np.array([0.0, 200.0]))
    how = source_separation(vibration_sources(shaft), rate=RATE)
    found = attribute_damage(recording, plan=plan, healths=healths, how=how)
    assert found.attributions[0].total_damage == pytest.approx(counted, rel=1e-9)
    assert (counted > 0) == (n > 1)


# --------------------------------------------------------------------------- verdict

ONE = ("--gauge", "S1", "--sn", "30,2e6,5")

PROFILE = """
profile: ours
limits:
  - {quantity: fatigue_life, normal: NORMAL, maximum: 1, source: our rule 1}
  - {quantity: fatigue_damage, maximum: 1, source: our rule 2}
  - {quantity: joint_angle, maximum: 1, source: no business of a recording}
"""


@pytest.fixture(scope="module")
def broken(tmp_path_factory):
    """One gauge that moves, one whose wire is off, one without a sample."""
    path = tmp_path_factory.mktemp("broken") / "broken.csv"
    t = np.arange(4000) / RATE
    rows = [f"{s:.3f},{40 * np.sin(2 * np.pi * 7 * s):.6f},0.0," for s in t]
    path.write_text("\n".join(["time,S1 [MPa],S2 [MPa],S3 [MPa]", *rows]) + "\n")
    return path


def hours_of(path, *arguments):
    document = json.loads(run(path, *ONE, "--json", *arguments).output)
    return document["gauges"][0]["hours"]


def profile(folder, normal):
    (folder / "ours.yaml").write_text(PROFILE.replace("NORMAL", f"{normal!r}"))
    return folder / "ours.yaml"


def test_missed_target_life_fails(broken):
    done = run(broken, *ONE, "--target-hours", "1e9", "--all")
    assert done.exit_code == 1, done.output
    assert "broken.csv: NOT APPROVED (1 exceeded, 0 beyond recommended, 0 met)" in done.output
    assert "given with the recording" in done.output
    assert "-100 %" in done.output


def test_life_equal_to_target_passes(broken):
    """As printed, to the twelve digits of the contract; a thousandth more is missed."""
    hours = hours_of(broken)
    assert run(broken, *ONE, "--target-hours", repr(hours)).exit_code == 0
    assert run(broken, *ONE, "--target-hours", repr(1.001 * hours)).exit_code == 1
    done = run(broken, *ONE, "--target-hours", repr(hours), "--all")
    assert "broken.csv: APPROVED (0 exceeded, 0 beyond recommended, 1 met)" in done.output


def test_life_between_normal_and_maximum_limit_warns(broken, tmp_path):
    """Past `normal` and not past `maximum`; the other row passes, joints are not asked."""
    rows = profile(tmp_path, 2 * hours_of(broken))
    done = run(broken, *ONE, "--limits", rows, "--all")
    assert done.exit_code == 0, done.output
    assert (
        "broken.csv: APPROVED WITH WARNINGS (0 exceeded, 1 beyond recommended, 1 met)"
        in done.output
    )
    assert "limits: ours" in done.output
    assert "our rule 1" in done.output
    assert "no business" not in done.output
    both = run(broken, *ONE, "--limits", rows, "--target-hours", "1e9", "--all")
    assert both.exit_code == 1
    assert "NOT APPROVED (1 exceeded, 1 beyond recommended, 1 met)" in both.output


@pytest.mark.parametrize("gauge", ["S2", "S3"])
def test_dead_gauge_leaves_verdict_incomplete(broken, gauge):
    """A wire that is off would live for ever: no damage in any hour."""
    done = run(broken, *ONE, "--gauge", gauge, "--target-hours", "0.001", "--all")
    assert done.exit_code == 1, done.output
    assert (
        "broken.csv: INCOMPLETE (0 exceeded, 0 beyond recommended, 1 met, 1 not evaluated)"
        in done.output
    )
    needs = "required, input missing: a recording in which all its channels move"
    assert f"Fatigue life, {gauge}: {needs}" in done.output
    assert f"{gauge}: said nothing, so its life is not known" in done.output
    alone = run(broken, "--gauge", gauge, *ONE[2:], "--target-hours", "0.001", "--all")
    assert alone.exit_code == 1
    assert "INCOMPLETE (0 exceeded, 0 beyond recommended, 0 met, 1 not evaluated)" in alone.output
    # Failing goes before missing.
    both = run(broken, *ONE, "--gauge", gauge, "--target-hours", "1e9")
    assert both.output.splitlines()[0].endswith(" NOT APPROVED")


@pytest.mark.slow
def test_dead_gauge_is_left_out_of_damage_causes(parquet, tmp_path):
    """The gauges behind it keep their own causes."""
    import pyarrow as pa
    from pyarrow import parquet as pq

    table = pq.read_table(parquet)
    off = pa.array(np.full(table.num_rows, np.nan, np.float32))
    field = pa.field("S0", pa.float32(), metadata={"unit": "MPa"})
    pq.write_table(table.append_column(field, off), tmp_path / "off.parquet")
    more = ("--sn", "30,2e6,5", "--speed", "shaft_speed", "--json")
    told = run(tmp_path / "off.parquet", "--gauge", "S0", "--gauge", "S1", *more)
    assert told.exit_code == 0, told.output
    off_, on = json.loads(told.output)["gauges"]
    (alone,) = json.loads(run(parquet, "--gauge", "S1", *more).output)["gauges"]
    assert on == alone
    assert "causes" not in off_
    assert off_["damage"] is None


def test_life_without_limits_has_no_verdict(broken):
    screen = run(broken, *ONE)
    assert screen.output.splitlines()[0].endswith("  NO LIMIT GIVEN")
    assert "Not evaluated: a limit of the life (--target-hours or --limits);" in screen.output
    done = run(broken, *ONE, "--all")
    assert (done.exit_code, screen.exit_code) == (0, 0)
    said = "No limit given: --target-hours or --limits compare the gauges' lives with a limit."
    assert done.output.splitlines()[0] == said
    assert not {"APPROVED", "INCOMPLETE"} & set(done.output.split())
    document = json.loads(run(broken, *ONE, "--json").output)
    assert document["verdict"] is None
    assert document["checks"] == []
    assert document["coverage"] == {"asked": 0, "answered": 0, "unanswered": []}
    joints = run(broken, *ONE, "--limits", "heavy-truck", "--all")
    assert joints.exit_code == 0
    assert joints.output.splitlines()[0] == said
    assert "heavy-truck limits no fatigue_life" in joints.output


@pytest.mark.parametrize(
    ("more", "verdict", "code"),
    [
        ((), None, 0),
        (("--target-hours", "1e-3"), "pass", 0),
        (("--target-hours", "1e9"), "fail", 1),
        (("--target-hours", "1e-3", "--gauge", "S2"), "incomplete", 1),
        (("--target-hours", "1e9", "--gauge", "S3"), "fail", 1),
    ],
)
def test_json_verdict_matches_exit_code(broken, more, verdict, code):
    done = run(broken, *ONE, *more, "--json")
    document = json.loads(done.output)
    assert (document["verdict"], done.exit_code) == (verdict, code)
    for check in document["checks"]:
        assert check["of"] == {"kind": "gauge", "number": 0, "other": check["part"]}
        assert check["when"] == {"kind": "recording", "name": "broken.csv", "what": ""}
        assert check["line"] == ""
        assert (check["quantity"], check["unit"], check["sense"]) == ("fatigue_life", "h", ">=")
        gauge = next(g for g in document["gauges"] if g["name"] == check["part"])
        assert check["value"] == pytest.approx(gauge["hours"], rel=1e-9)
    coverage = document["coverage"]
    assert coverage["answered"] == len(document["checks"])
    assert coverage["asked"] == coverage["answered"] + len(coverage["unanswered"])


def test_infinite_life_passes(broken):
    """Below the knee the original Miner counts nothing: no number, and no missing answer."""
    done = run(broken, "--gauge", "S1", "--sn", "300,2e6,5", "--miner", "original",
               "--target-hours", "1e9", "--all")  # fmt: skip
    assert done.exit_code == 0, done.output
    assert "APPROVED" in done.output
    assert "∞" in done.output


def test_json_names_driveline_of_application(broken):
    more = ("--application", TRUCK, "--target-hours", "1", "--json")
    document = json.loads(run(broken, *ONE, *more).output)
    from cardan.application import reader

    assert document["checks"][0]["line"] == reader.read(TRUCK).lines[0].line.name


@pytest.mark.parametrize(
    ("code", "said"),
    [
        ("pt", ("REPROVADO (1 excedido", "Vida em fadiga", "uma medição em que todos",
                "dado com o registro")),
        ("it", ("NON CONFORME (1 superato", "una registrazione in cui tutti i suoi canali",
                "dato con la registrazione")),
    ],
)  # fmt: skip
def test_verdict_is_translated(broken, code, said):
    done = run(broken, *ONE, "--gauge", "S2", "--target-hours", "1e9", "--lang", code, "--all")
    assert done.exit_code == 1
    for words in said:
        assert words in done.output


@pytest.mark.parametrize(
    ("more", "said"),
    [
        (("--target-hours", "0"), "--target-hours must be above 0"),
        (("--target-hours", "nan"), "--target-hours must be above 0"),
        (("--limits", "heavy-trucks"), "no limit profile of this name"),
        (("--gauge", "S1"), "two gauges are called S1"),
        (("--gauge", "S2:kPa"), "S2: the file says MPa, and it is taken for kPa"),
        (("--axle-ratio", "-4"), "--axle-ratio must be above 0"),
    ],
)
def test_invalid_limit_options_are_rejected(broken, more, said):
    done = run(broken, *ONE, *more)
    assert done.exit_code == 2
    assert said in done.output


def test_internal_error_is_not_reported_as_bad_input(broken, monkeypatch):
    """A ValueError that nobody meant for a user was told as bad input, exit code 2."""
    from cardan.physics.signals import assessment as room

    def faulty(*_, **__):
        msg = "operands could not be broadcast"
        raise ValueError(msg)

    monkeypatch.setattr(room, "assess_damage_at_gauges", faulty)
    done = run(broken, *ONE)
    assert isinstance(done.exception, ValueError)


def test_option_choice_is_checked():
    from cardan.topics.recording.options import AnalysisOptions

    with pytest.raises(DesignError, match="miner must be one of original"):
        AnalysisOptions(sn="1,1,1", miner="palmgren")


def test_every_recording_quantity_of_profile_is_evaluated(broken, tmp_path):
    from cardan.checks.quantities.registry import QUANTITIES

    asked = [k for k, q in QUANTITIES.items() if q.study == "recording"]
    rows = "".join(f"  - {{quantity: {k}, maximum: 1, source: ours}}\n" for k in asked)
    (tmp_path / "all.yaml").write_text(f"profile: all\nlimits:\n{rows}")
    document = json.loads(run(broken, *ONE, "--limits", tmp_path / "all.yaml", "--json").output)
    assert [c["quantity"] for c in document["checks"]] == asked
    assert document["profile"] == "all"


def test_changed_driveline_requires_identification():
    from cardan.topics.recording.options import AnalysisOptions

    with pytest.raises(DesignError, match="--identify"):
        AnalysisOptions(sn="1,1,1", changed=object())


@pytest.mark.slow
def test_life_output_fits_terminal_width(parquet):
    """What it says of a gauge had been 195 wide."""
    told = CliRunner().invoke(command, [str(parquet), *ALL, "-q", "--all"]).output.splitlines()
    assert len(told) > 40
    assert [line for line in told if len(line) > 80] == []
