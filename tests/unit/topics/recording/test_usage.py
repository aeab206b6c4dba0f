"""When and where damage came: seconds that add up, and what they come to in the long run."""

import json
import tracemalloc
import weakref

import jsonschema
import numpy as np
import pytest
from click.testing import CliRunner
from scipy.stats import norm

from cardan.cli.life import life as command
from cardan.core.units import MPa
from cardan.documents.approval_schema import schema
from cardan.physics.fatigue.damage import miner_damage
from cardan.physics.fatigue.mean_stress import uncorrected
from cardan.physics.fatigue.rainflow import half_cycles, rainflow
from cardan.physics.fatigue.sn_curve import SNCurve
from cardan.physics.fatigue.strain_gauges import single_gauge
from cardan.physics.signals.assessment import AssessmentSettings, assess_gauges
from cardan.physics.signals.damage_extrapolation import extrapolate_damage
from cardan.physics.signals.order_tracking import ShaftRotation
from cardan.physics.signals.recording import recording_from_arrays
from cardan.physics.signals.shaft_angle import ShaftAngle, estimate_gear_ratios, shaft_angle
from cardan.physics.signals.usage_profile import (
    accelerated_test_time_share,
    band_labels,
    customer_damage_rate_percentile,
    damage_by_bin,
    damage_equivalent_stress_amplitude,
    interval_count,
    interval_length,
    stress_peaks,
    usage_histories,
)
from cardan.render.i18n import ENGLISH
from cardan.topics.recording.usage import damage_by_usage
from cardan.topics.recording.usage_presentation import damage_rows, json_document

CURVE = SNCurve(amplitude=30 * MPa, cycles=2e6, slope=5).elementary()
RATE = 200.0
PLAN = AssessmentSettings(gauges=(single_gauge("S1", "S1", factor=MPa),), curve=CURVE)


def told(x):
    pieces = (x[None, k : k + 5000] for k in range(0, x.size, 5000))
    return usage_histories(
        pieces, rate=RATE, curve=CURVE, correction=uncorrected, rule=half_cycles
    )[0]


@pytest.fixture(scope="module")
def rough():
    """Ten minutes, loud in the fourth and the eighth."""
    rng = np.random.default_rng(3)
    t = np.arange(int(600 * RATE)) / RATE
    loud = np.where((t // 60 == 3) | (t // 60 == 7), 4.0, 1.0)
    return 10 * MPa * loud * rng.normal(size=t.size)


def test_level_of_a_few_seconds_is_their_own():
    """Of twenty seconds, fewer than the half minute to either side: the level that rises is
    followed, so of each second the larger of its two peaks is found, be it up or down. SciPy before
    1.16.1 left the level unwritten."""
    t = np.arange(int(20 * RATE)) / RATE
    x = 10 * MPa * np.floor(t)
    x[t % 1 == 0.25] += np.where(np.arange(20) < 10, 1.0, 2.0) * MPa
    x[t % 1 == 0.75] -= np.where(np.arange(20) < 10, 2.0, 1.0) * MPa
    found = told(x).time_of_max_deviation
    assert found == pytest.approx(np.arange(20) + np.where(np.arange(20) < 10, 0.75, 0.25))


def test_shortened_test_does_target_damage():
    """A load that comes and goes by ramps of 8 s: a cycle closes in one second and began in another
    that was cut away, and what was left did 0.17 of the damage that 0.95 had been told of. Counted
    anew of the samples themselves, all seconds that are kept joined."""
    t = np.arange(int(600 * RATE)) / RATE
    rng = np.random.default_rng(8)
    x = 100 * MPa * np.clip((t % 40) / 8, 0, 1) * np.clip((32 - t % 40) / 8, 0, 1)
    x += 2 * MPa * rng.normal(size=t.size)
    of = told(x)
    whole = miner_damage(rainflow(x), curve=CURVE)
    assert of.damage_by_cycle_start.sum() == pytest.approx(of.damage.sum())
    share = accelerated_test_time_share(of, keep=0.95, curve=CURVE)
    order = np.argsort(-(of.damage + of.damage_by_cycle_start + of.open_damage), kind="stable")
    seconds = np.sort(order[: round(share * 600)])
    cut = x.reshape(600, -1)[seconds].ravel()
    assert miner_damage(rainflow(cut), curve=CURVE) / whole == pytest.approx(0.95, abs=0.05)
    fewer = x.reshape(600, -1)[np.sort(order[: round(share * 600) - 2])].ravel()
    assert miner_damage(rainflow(fewer), curve=CURVE) / whole < 0.95


def test_damage_per_second_sums_to_total_damage(rough):
    of = told(rough)
    whole = miner_damage(rainflow(rough), curve=CURVE)
    assert of.damage.sum() + of.total_open_damage == pytest.approx(whole, rel=1e-9)
    assert of.damage.size == 600
    assert of.live.sum() == pytest.approx(600)
    minutes = damage_by_bin(of, [f"{k // 60}" for k in range(600)], metres=np.full(600, 10.0))
    assert sum(g.damage for g in minutes) == pytest.approx(of.damage.sum())
    assert {g.name for g in minutes if g.share > 0.1} == {"3", "7"}
    assert all(g.time == pytest.approx(60) and g.distance == pytest.approx(600) for g in minutes)
    assert of.high.max() == rough.max()
    # Four times the stress to the fifth power: two minutes of ten are all of it but a per mille.
    assert 0.05 < accelerated_test_time_share(of, keep=0.95, curve=CURVE) < 0.2
    assert accelerated_test_time_share(of, keep=0.5, curve=CURVE) < accelerated_test_time_share(
        of, keep=0.95, curve=CURVE
    )


def test_stress_peaks_are_largest_and_separated(rough):
    found = stress_peaks(told(rough), count=5, apart=5.0)
    assert abs(found[0].stress) == np.abs(rough).max()
    at = int(np.argmax(np.abs(rough))) / RATE
    assert found[0].time == pytest.approx(at)
    times = sorted(p.time for p in found)
    assert np.diff(times).min() >= 5
    assert [abs(p.stress) for p in found] == sorted((abs(p.stress) for p in found), reverse=True)


def test_single_open_cycle_leaves_long_term_damage_unknown(rough):
    """Its legs belong to no closed cycle, and are most of the damage: once is no rate."""
    x = rough[: int(180 * RATE)] / 4
    x[7000:7002] = 150 * MPa, -120 * MPa
    of = told(x)
    assert of.total_open_damage > 0.9 * (of.total_open_damage + of.damage.sum())
    assert of.open_damage.argmax() == int(7000 / RATE)
    one = extrapolate_damage(of, curve=CURVE)
    assert one.recorded_rate == pytest.approx((of.total_open_damage + of.damage.sum()) / 180)
    assert one.unknown_reason == "blows"
    assert np.isnan([one.long_term_rate, one.interval[1]]).all()
    # Without that blow, as it was.
    calm = extrapolate_damage(told(rough[: int(180 * RATE)] / 4), curve=CURVE)
    assert one.interval[0] == pytest.approx(calm.recorded_rate, rel=0.3)


@pytest.mark.parametrize("way", [np.sin, np.cos, lambda a: np.sign(np.sin(a + 0.1))])
def test_constant_amplitude_test_has_known_long_term_damage(way):
    """By rounding one second of it exceeded all others, a tail as heavy as one value may have."""
    one = extrapolate_damage(
        told(60 * MPa * way(2 * np.pi * 5 * np.arange(180 * RATE) / RATE)), curve=CURVE
    )
    assert one.unknown_reason is None
    assert one.long_term_rate == pytest.approx(one.recorded_rate, rel=0.01)
    low, high = one.interval
    assert 0.97 * one.recorded_rate < low < high < 1.03 * one.recorded_rate


@pytest.mark.slow
@pytest.mark.parametrize("hertz", [0.3, 1.0, 1.5, 10.0])
@pytest.mark.parametrize("noise", [0.0, 0.01])
def test_varying_cycle_count_per_second_keeps_long_term_damage_known(hertz, noise):
    """Counted, that was a blow: the long run was "wide" of a third of the rigs."""
    t = np.arange(180 * RATE) / RATE
    for seed in range(4):
        rng = np.random.default_rng(seed)
        x = np.sin(2 * np.pi * hertz * t + rng.uniform(0, 6)) + noise * rng.normal(size=t.size)
        one = extrapolate_damage(told(60 * MPa * x), curve=CURVE)
        assert one.unknown_reason is None
        assert one.long_term_rate == pytest.approx(one.recorded_rate, rel=0.01)
        assert one.recorded_rate / 1.4 < one.interval[0] < one.interval[1] < 1.4 * one.recorded_rate


@pytest.mark.parametrize("way", [-0.02, 0.02])
def test_slow_drift_of_rig_keeps_long_term_damage_known(way):
    t = np.arange(180 * RATE) / RATE
    one = extrapolate_damage(
        told(60 * MPa * (1 + way * t / 180) * np.sin(10 * np.pi * t)), curve=CURVE
    )
    assert one.unknown_reason is None
    assert one.interval[0] < one.recorded_rate < one.interval[1] < 1.5 * one.recorded_rate


def test_single_larger_cycle_widens_long_term_interval():
    """A quarter larger, once: what another hour brings is not what was recorded."""
    t = np.arange(180 * RATE) / RATE
    x = np.sin(10 * np.pi * t) * np.where((t > 90) & (t < 90.2), 1.25, 1.0)
    one = extrapolate_damage(told(60 * MPa * x), curve=CURVE)
    assert one.unknown_reason or one.interval[1] > 1.05 * one.recorded_rate


def test_rejected_gauge_has_no_long_term_damage(rough):
    """The long run stood next to "data rejected" as if nothing were wrong."""
    of = told(rough[: int(180 * RATE)])
    one, sound = (extrapolate_damage(of, curve=CURVE, spoiled=s) for s in (True, False))
    assert (one.recorded_rate, one.interval[0], one.unknown_reason) == (
        sound.recorded_rate,
        0.0,
        "data rejected",
    )
    assert np.isnan([one.long_term_rate, one.interval[1]]).all()
    # Clipped below all damage: what is spoiled did not do none.
    none = extrapolate_damage(told(np.zeros(int(100 * RATE))), curve=CURVE, spoiled=True)
    assert (none.recorded_rate, none.unknown_reason) == (0.0, "data rejected")


def test_settling_rig_has_unknown_long_term_damage():
    """By a tenth, within half of what was recorded: its long run is below all of it."""
    t = np.arange(300 * RATE) / RATE
    x = 30 * MPa * (0.9 + 0.1 * np.exp(-t / 300)) * np.sin(10 * np.pi * t)
    assert extrapolate_damage(told(x), curve=CURVE).unknown_reason == "road"


def test_open_cycle_damage_belongs_to_second_of_its_end():
    x = np.zeros(int(10 * RATE))
    at = (np.array([1.5, 3.5, 6.5]) * RATE).astype(int)
    x[at] = MPa * np.array([20.0, -40.0, 80.0])
    of = told(x)
    assert np.flatnonzero(of.open_damage).tolist() == [1, 3, 6]
    legs = 0.5 * CURVE.damage(np.array([10.0, 30.0, 60.0]) * MPa)
    np.testing.assert_allclose(of.open_damage[[1, 3]], legs[:2], rtol=1e-12)
    # Up to 80 and back to nought.
    back = 0.5 * CURVE.damage(np.array(40.0 * MPa))
    assert of.open_damage[6] == pytest.approx(legs[2] + back)


def test_gaussian_signal_long_term_damage_equals_recorded(rough):
    """Gaussian, so small cycles do most of the damage and no tail is to come."""
    one = extrapolate_damage(told(rough[: int(180 * RATE)]), curve=CURVE)
    assert one.unknown_reason is None
    assert one.long_term_rate == pytest.approx(one.recorded_rate, rel=0.05)
    assert one.recorded_rate / 1.25 < one.interval[0] < one.interval[1] < 1.25 * one.recorded_rate


def test_damage_in_two_short_periods_leaves_long_term_damage_unknown(rough):
    """Two minutes of ten did all the damage: of their share in another hour nothing is known."""
    assert extrapolate_damage(told(rough), curve=CURVE).unknown_reason == "road"
    # The same minutes in turns of a second: met often, and known.
    turns = rough.reshape(10, 60, -1).swapaxes(0, 1).ravel()
    known = extrapolate_damage(told(turns), curve=CURVE)
    assert known.unknown_reason is None
    assert known.interval[0] < known.recorded_rate < known.interval[1] < 2 * known.interval[0]


def test_standstill_keeps_long_term_damage_known():
    """Parked a third of the time, in turns of ten seconds: the damage came often all the same."""
    rng = np.random.default_rng(4)
    t = np.arange(int(1200 * RATE)) / RATE
    x = 10 * MPa * np.where(t // 10 % 3 == 0, 1e-3, 1.0) * rng.normal(size=t.size)
    one = extrapolate_damage(told(x), curve=CURVE)
    assert one.unknown_reason is None
    assert one.interval[0] < one.recorded_rate < one.interval[1] < 4 * one.interval[0]


def test_recording_under_one_minute_has_unknown_long_term_damage(rough):
    assert extrapolate_damage(told(rough[: int(59 * RATE)]), curve=CURVE).unknown_reason == "short"
    assert extrapolate_damage(told(rough[: int(61 * RATE)]), curve=CURVE).unknown_reason is None


def test_zero_damage_extrapolates_to_zero():
    one = extrapolate_damage(told(np.zeros(int(100 * RATE))), curve=CURVE)
    assert (one.recorded_rate, one.long_term_rate, one.interval, one.unknown_reason) == (
        0,
        0,
        (0, 0),
        None,
    )


def test_customer_percentile_follows_lognormal_quantile():
    """Of very many customers the quantile is the population's, its bound beside it."""
    rng = np.random.default_rng(0)
    rates = np.exp(-12 + 0.7 * rng.normal(size=20_000))
    rate, bound = customer_damage_rate_percentile(rates, quantile=0.95)
    true = np.exp(-12 + 0.7 * norm.ppf(0.95))
    assert rate == pytest.approx(true, rel=0.03)
    assert rate < bound < 1.05 * rate
    # Four customers: 3.957 standard deviations (Hahn & Meeker, table A.12b, 0.95 at 90 %).
    few = rates[:4]
    _, above = customer_damage_rate_percentile(few, quantile=0.95)
    logs = np.log(few)
    assert (np.log(above) - logs.mean()) / logs.std(ddof=1) == pytest.approx(3.957, abs=5e-4)


def test_equivalent_amplitude_does_equal_damage():
    amplitude = damage_equivalent_stress_amplitude(0.037, cycles=2e5, curve=CURVE)
    assert 2e5 * CURVE.damage(amplitude) == pytest.approx(0.037, rel=1e-9)


def test_band_labels_leave_unknown_values_empty():
    assert band_labels([120.0, np.nan, -10.0], step=100) == ["100 .. 200", "", "-100 .. 0"]
    # A steady speed, as differences of summed turns have it, is one band and not two.
    assert set(band_labels(250 * (1 - 1e-12) + np.array([0, 1e-9]), step=250)) == {"250 .. 500"}


def test_gear_ratio_is_engine_speed_over_shaft_speed():
    t = np.arange(0, 120, 0.01)
    ratio = np.where(t < 40, 3.6, np.where(t < 80, 2.1, 1.0))
    shaft = np.full(t.size, 12.0)
    own = ShaftRotation(t, np.cumsum(shaft) * 0.01)
    motor = ShaftRotation(t, np.cumsum(shaft * ratio) * 0.01)
    found = estimate_gear_ratios(own, motor, np.arange(120) + 0.5)
    for at, want in ((10, 3.6), (60, 2.1), (100, 1.0)):
        assert found[at] == pytest.approx(want, rel=1e-3)


@pytest.mark.slow
def test_life_command_reports_usage(tmp_path):
    """By speed and torque, with the largest stress where it was put."""
    rng = np.random.default_rng(1)
    n = int(120 * RATE)
    t = np.arange(n) / RATE
    speed = np.where(t < 60, 600.0, 1500.0) + 0.2 * rng.normal(size=n)
    x = np.where(t < 60, 5.0, 20.0) * rng.normal(size=n)
    x[int(30 * RATE)] = 150.0
    torque = np.where(t < 60, 0.4, 2.2)
    path = tmp_path / "a.csv"
    np.savetxt(
        path, np.stack([t, x, speed, torque], -1), delimiter=",", comments="", fmt="%.6g",
        header="time,S1 [MPa],n [rpm],T [kNm]",
    )  # fmt: skip
    options = [
        "--gauge", "S1", "--sn", "30,2e6,5", "--speed", "n", "--torque", "T", "--axle-ratio", "4",
        "--tyre-radius-m", "0.5", "--usage", "--accept", "spike",
    ]  # fmt: skip
    out = tmp_path / "a.json"
    done = CliRunner().invoke(
        command, ["--all", str(path), *options, "--json", str(out), "--lang", "pt"]
    )
    assert done.exit_code == 0, done.output
    assert "maiores tensões" in done.output
    whole = json.loads(out.read_text())
    contract = {"$defs": schema()["$defs"], "$ref": "#/$defs/life"}
    jsonschema.validate(whole, contract, jsonschema.Draft202012Validator)
    found = whole["usage"]["S1"]
    assert found["peaks"][0]["MPa"] == 150
    assert found["peaks"][0]["time_s"] == pytest.approx(30, abs=0.01)
    assert found["peaks"][0]["rpm"] == pytest.approx(600, rel=1e-3)
    assert found["peaks"][0]["km"] == pytest.approx(30 * 10 / 4 * 2 * np.pi * 0.5 / 1e3, rel=0.02)
    loud = next(g for g in found["damage_by"]["torque"] if g["band"] == "2000 .. 2500")
    assert loud["live_s"] == pytest.approx(60, abs=2)
    assert loud["share"] > 0.5
    # One blow, and a minute of each road.
    run = found["damage_per_hour"]
    assert run["unknown"] == "road"
    assert run["long_run"] is run["interval"][1] is None
    assert 0 < run["interval"][0] < run["recorded"]
    assert "não se pode saber: a estrada mudou" in " ".join(done.output.split())


@pytest.mark.slow
@pytest.mark.parametrize("accept", [False, True])
def test_rejected_gauge_has_no_extrapolation_and_no_test(tmp_path, accept):
    x = 20 * np.random.default_rng(3).normal(size=int(120 * RATE))
    x[[4000, 11000]] = 900.0
    path = tmp_path / "a.csv"
    np.savetxt(
        path, np.stack([np.arange(x.size) / RATE, x], -1), delimiter=",", comments="", fmt="%.6g",
        header="time,S1 [MPa]",
    )  # fmt: skip
    out = tmp_path / "a.json"
    options = ["--gauge", "S1", "--sn", "30,2e6,5", "--usage", "--json", str(out)]
    options += ["--accept", "spike"] if accept else []
    done = CliRunner().invoke(command, ["--all", str(path), *options])
    whole = json.loads(out.read_text())
    contract = {"$defs": schema()["$defs"], "$ref": "#/$defs/life"}
    jsonschema.validate(whole, contract, jsonschema.Draft202012Validator)
    assert (whole["gauges"][0]["quality"]["verdict"] == "data rejected") is not accept
    run = whole["usage"]["S1"]["damage_per_hour"]
    said = " ".join(done.output.split())
    assert (run["unknown"] == "data rejected") is not accept
    assert ("neither its value in the long run nor a test is known" in said) is not accept
    assert ("a test cut to" in said) is accept
    if not accept:
        assert (run["long_run"], run["interval"]) == (None, [0, None])


@pytest.mark.parametrize("frozen", [False, True])
def test_recorded_damage_rate_matches_life(tmp_path, frozen):
    """Crests between samples, and time that is frozen, were in the life's and not in the other."""
    rng = np.random.default_rng(5)
    t = np.arange(int(200 * RATE)) / RATE
    x = 40 * np.sin(2 * np.pi * 0.23 * RATE * t) * (1 + 0.1 * rng.normal(size=t.size))
    x = np.where(frozen & (t > 60), x[0], x)
    path, out = tmp_path / "a.csv", tmp_path / "a.json"
    np.savetxt(
        path, np.stack([t, x], -1), delimiter=",", comments="", fmt="%.6g", header="time,S1 [MPa]"
    )
    options = ["--gauge", "S1", "--sn", "30,2e6,5", "--usage", "--json", str(out)]
    decided = ["--mask", "freeze"] if frozen else []
    CliRunner().invoke(command, ["--all", str(path), *options, *decided])
    whole = json.loads(out.read_text())
    (gauge,), run = whole["gauges"], whole["usage"]["S1"]["damage_per_hour"]
    assert run["recorded"] == pytest.approx(1 / gauge["hours"], rel=1e-9)
    low, high = run["interval"]
    assert low <= run["recorded"]
    assert high is None or run["recorded"] <= high


def test_campaign_reports_customer_percentile(tmp_path):
    rng = np.random.default_rng(2)
    names = []
    for k, size in enumerate((10.0, 14.0, 20.0)):
        t = np.arange(4000) / RATE
        name = f"v{k}.csv"
        np.savetxt(
            tmp_path / name, np.stack([t, size * rng.normal(size=t.size)], -1), delimiter=",",
            comments="", header="time,S1 [MPa]",
        )  # fmt: skip
        names.append(name)
    plan = tmp_path / "plan.yaml"
    plan.write_text(
        f"campaign: Three vehicles\nrecordings: [{', '.join(f'{{file: {n}}}' for n in names)}]\n"
        "gauges: [S1]\nstrength: {amplitude_MPa: 30, cycles: 2e6, slope: 5, miner: elementary}\n"
        "customer: 0.95\nusage: true\n"
    )
    out = tmp_path / "out.json"
    done = CliRunner().invoke(command, ["--all", str(plan), "--json", str(out)])
    assert done.exit_code == 0, done.output
    assert "95 % of customers" in done.output
    found = json.loads(out.read_text())
    rates = [r["damage_per_hour"] for r in found["gauges"][0]["recordings"]]
    (one,) = found["customer"]["gauges"]
    want = customer_damage_rate_percentile(rates, quantile=0.95)
    assert (one["damage_per_hour"], one["bound_per_hour"]) == pytest.approx(want, rel=1e-6)
    assert all("usage" in r for r in found["recordings"])


@pytest.mark.slow
def test_target_life_is_checked_for_customers(tmp_path):
    """Of the mix it passed, four lines above a life of customers that is shorter."""
    rng = np.random.default_rng(2)
    for k, size in enumerate((10.0, 14.0, 20.0)):
        t = np.arange(4000) / RATE
        np.savetxt(
            tmp_path / f"v{k}.csv", np.stack([t, size * rng.normal(size=t.size)], -1),
            delimiter=",", comments="", header="time,S1 [MPa]",
        )  # fmt: skip

    def told(count, more=""):
        drives = ", ".join(f"{{file: v{k}.csv}}" for k in range(count))
        plan = tmp_path / "plan.yaml"
        plan.write_text(
            f"campaign: Vehicles\nrecordings: [{drives}]\ngauges: [S1]\ncustomer: 0.95\n"
            f"strength: {{amplitude_MPa: 30, cycles: 2e6, slope: 5, miner: elementary}}\n{more}"
        )
        out = tmp_path / "out.json"
        done = CliRunner().invoke(command, ["--all", str(plan), "--json", str(out)])
        return done, json.loads(out.read_text())

    _, found = told(3)
    mix, theirs = found["gauges"][0]["hours"], found["customer"]["gauges"][0]
    life = 1 / theirs["damage_per_hour"]
    done, found = told(3, f"target_hours: {(mix + life) / 2}\n")
    assert (done.exit_code, found["verdict"]) == (1, "fail")
    grades = {c["state"]: (c["value"], c["verdict"]) for c in found["checks"]}
    assert grades["Vehicles"] == (pytest.approx(mix), "pass")
    assert grades["Vehicles: the required share of customers"] == (pytest.approx(life), "fail")
    assert "the required share of customers" in done.output
    # What customers as few as these may do at most is the end of what it may be.
    _, found = told(3, f"target_hours: {life / 2}\n")
    assert found["verdict"] == "pass"
    (asked,) = [c for c in found["checks"] if "customers" in c["state"]]
    assert asked["may_be"] == "fail"
    assert asked["value_within"] == pytest.approx([1 / theirs["bound_per_hour"], life])
    done, found = told(2, f"target_hours: {life / 100}\n")
    assert (done.exit_code, found["verdict"]) == (1, "incomplete")
    assert "three recordings or more, of a customer each" in " ".join(done.output.split())


@pytest.mark.slow
def test_customers_are_counted_by_recording_not_segment(tmp_path):
    """Two vehicles in two segments each are two customers, of whom nothing is told."""
    rng = np.random.default_rng(2)
    t = np.arange(4000) / RATE
    for name in ("a", "b", "c"):
        np.savetxt(
            tmp_path / f"{name}.csv", np.stack([t, 14 * rng.normal(size=t.size)], -1),
            delimiter=",", comments="", header="time,S1 [MPa]",
        )  # fmt: skip
    half = t[-1] / 2

    def told(names):
        rows = "".join(
            f"  - {{file: {n}.csv, times: 5, segments: [{{name: up, to_s: {half}}}, "
            f"{{name: down, from_s: {half}, to_s: {t[-1]}, times: 3}}]}}\n"
            for n in names
        )
        plan = tmp_path / "plan.yaml"
        plan.write_text(
            f"campaign: Vehicles\nrecordings:\n{rows}gauges: [S1]\n"
            "strength: {amplitude_MPa: 30, cycles: 2e6, slope: 5}\ncustomer: 0.95\n"
        )
        out = tmp_path / "out.json"
        done = CliRunner().invoke(command, ["--all", str(plan), "--json", str(out)])
        assert done.exit_code == 0, done.output
        return done.output, json.loads(out.read_text())

    said, found = told("ab")
    assert "customer" not in found
    assert "S1: customers not evaluated: at least 3 recordings" in " ".join(said.split())
    _, found = told("abc")
    parts = found["gauges"][0]["recordings"]
    rates = [
        (up["damage"] + 3 * down["damage"]) / (up["live_s"] + 3 * down["live_s"]) * 3600
        for up, down in zip(parts[::2], parts[1::2], strict=True)
    ]
    (one,) = found["customer"]["gauges"]
    assert one["damage_per_hour"] == pytest.approx(
        customer_damage_rate_percentile(rates, quantile=0.95)[0], rel=1e-6
    )


def driven(tmp_path, *more, quiet=(0.0, 300.0), torque=(0.0, 300.0), holes=()):
    """Five minutes at 600 rpm, of which the speed and the torque are written within some."""
    rng = np.random.default_rng(6)
    t = np.arange(int(300 * RATE)) / RATE
    speed = 600 + 0.2 * rng.normal(size=t.size)
    load = np.full(t.size, 400.0)
    for x, (first, last) in ((speed, quiet), (load, torque)):
        x[(t < first) | (t >= last)] = np.nan
    for first, last in holes:
        speed[(t >= first) & (t < last)] = np.nan
    stress = 20 * rng.normal(size=t.size)
    stress[int(2 * RATE)], stress[int(150 * RATE)] = 200.0, 180.0
    path = tmp_path / "a.csv"
    np.savetxt(
        path, np.stack([t, stress, speed, load], -1), delimiter=",", comments="", fmt="%.6g",
        header="time,S1 [MPa],n [rpm],T [Nm]",
    )  # fmt: skip
    out = tmp_path / "a.json"
    options = [
        "--gauge", "S1", "--sn", "30,2e6,5", "--speed", "n", "--torque", "T", "--usage",
        "--accept", "spike", "--json", str(out), *more,
    ]  # fmt: skip
    done = CliRunner().invoke(command, ["--all", str(path), *options])
    assert done.exit_code == 0, done.output
    return json.loads(out.read_text()), done.output


WAY = 10 / 4 * 2 * np.pi * 0.5 / 1e3
"""km a second at 600 rpm."""
WHEELS = "--axle-ratio", "4", "--tyre-radius-m", "0.5"


@pytest.mark.slow
@pytest.mark.parametrize(
    ("quiet", "held"), [((0.0, 300.0), True), ((5.0, 285.0), True), ((20.0, 240.0), False)]
)
def test_damage_outside_speed_signal_has_no_speed_band(tmp_path, quiet, held):
    """Its first and last speed stood for all before and after, and nothing said so."""
    told, text = driven(tmp_path, *WHEELS, quiet=quiet)
    (gauge,), used = told["gauges"], told["usage"]["S1"]
    heard = quiet[1] - quiet[0]
    by_speed, by_torque = used["damage_by"]["speed"], used["damage_by"]["torque"]
    assert sum(g["live_s"] for g in by_speed) == pytest.approx(heard, abs=2)
    assert sum(g["km"] for g in by_speed) == pytest.approx(heard * WAY, abs=2 * WAY)
    assert sum(g["live_s"] for g in by_torque) == pytest.approx(300)
    first, second = used["peaks"][:2]
    assert (first["time_s"], second["time_s"]) == (2, 150)
    assert second["rpm"] == pytest.approx(600, rel=1e-3)
    assert (first["rpm"] is None) == (quiet[0] > 2)
    said = " ".join(text.split())
    noted = f"n: no speed in the first {quiet[0]:g} s and the last {300 - quiet[1]:g} s"
    assert (noted in said) == (heard < 300)
    if held:
        assert told["distance_km"] == pytest.approx(300 * WAY, rel=1e-3)
        assert gauge["km"] > 0
        assert second["km"] == pytest.approx(150 * WAY, rel=1e-2)
        assert ("km use the nearest speed" in said) == (heard < 300)
    else:
        assert told["distance_km"] is gauge["km"] is first["km"] is second["km"] is None
        assert by_torque[0]["km"] is None
        assert "and km are not known" in said


@pytest.mark.slow
@pytest.mark.parametrize(
    ("holes", "held"),
    [([(60.0, 60.7)], True), ([(60.0, 70.0), (145.0, 155.0)], True), ([(100.0, 190.0)], False)],
)
def test_speed_is_not_interpolated_across_gaps(tmp_path, holes, held):
    """A line went straight across, and bands, gears and peaks had their speed of it, unsaid."""
    told, text = driven(tmp_path, *WHEELS, holes=holes)
    used = told["usage"]["S1"]
    lost = sum(last - first for first, last in holes if last - first > 1)
    by_speed = used["damage_by"]["speed"]
    assert sum(g["live_s"] for g in by_speed) == pytest.approx(300 - lost, abs=2.1)
    first, second = used["peaks"][:2]
    assert first["rpm"] == pytest.approx(600, rel=1e-3)
    assert (second["rpm"] is None) == any(a < 150 < b for a, b in holes)
    said = " ".join(text.split())
    longest = max(last - first for first, last in holes)
    noted = (
        f"n: no speed for {lost:g} s, longest hole {longest:g} s, the first at {holes[0][0]:g} s"
    )
    assert (noted in said) == (lost > 0)
    assert (told["distance_km"] is not None) == held
    if held:
        assert told["distance_km"] == pytest.approx(300 * WAY, rel=1e-3)
        assert second["km"] == pytest.approx(150 * WAY, rel=1e-2)
    _, text = driven(tmp_path, "--lang", "pt", holes=holes)
    assert ("n: sem rotação por" in " ".join(text.split())) == (lost > 0)


@pytest.mark.slow
def test_speed_coverage_note_is_translated(tmp_path):
    _, text = driven(tmp_path, "--lang", "it", quiet=(5.0, 285.0))
    said = " ".join(text.split())
    assert "n: nessuna velocità nei primi 5 s e negli ultimi 15 s: il danno lì non è di" in said


@pytest.mark.slow
def test_torque_is_not_reported_in_its_gaps(tmp_path):
    """A hole had the torque beside it, however long it was."""
    told, _ = driven(tmp_path, torque=(60.0, 200.0))
    (band,) = told["usage"]["S1"]["damage_by"]["torque"]
    assert band["live_s"] == pytest.approx(140, abs=3)
    first, second = told["usage"]["S1"]["peaks"][:2]
    assert first["torque_Nm"] is None
    assert second["torque_Nm"] == pytest.approx(400)


@pytest.mark.slow
def test_usage_memory_is_limited_to_turning_points():
    """A day of five gauges took a gigabyte: some arrays of a few numbers for each second of it."""
    held = []

    def pieces():
        for k in range(16):
            if k == 1:
                tracemalloc.start()
            held.append(tracemalloc.get_traced_memory()[0])
            t = 1024 * k + np.arange(1024 * 20) / 20
            yield 50 * MPa * np.sin(2 * np.pi * 3.0 * t)[None]

    [of] = usage_histories(
        pieces(), rate=20.0, curve=CURVE, correction=uncorrected, rule=half_cycles
    )
    tracemalloc.stop()
    assert of.damage.size == 16 * 1024
    assert held[-1] - held[5] < 10 * 1024 * 200  # bytes a second, in which it turns six times


@pytest.mark.slow
def test_usage_holds_one_gauge_in_memory_at_a_time(rough):
    """Where five of a day turned took 600 MB at once."""
    made = []

    def one():
        made.append(weakref.ref(of := told(rough)))
        return of

    def found():
        for k in range(3):
            assert not any(of() for of in made), k
            yield one()

    lives = assess_gauges(
        recording_from_arrays(rough[None] / MPa, rate=RATE, names=["S1"], units=["MPa"]), plan=PLAN
    )
    answers = damage_by_usage(
        found(), lives * 3, count=interval_count(rough.size, rate=RATE), plan=PLAN, angle=None,
        engine=None, torque=None, per_turn=np.nan,
    )  # fmt: skip
    assert len(answers) == 3
    assert len({a.shortened_test_share for a in answers}) == 1


def asked(x, *, rate=RATE, angle=None, engine=None, torque=None):
    """What is told of a stress (n,) Pa, and its seconds."""
    of = usage_histories(
        [x[None]], rate=rate, curve=CURVE, correction=uncorrected, rule=half_cycles
    )[0]
    lives = assess_gauges(
        recording_from_arrays(x[None] / MPa, rate=rate, names=["S1"], units=["MPa"]), plan=PLAN
    )
    [one] = damage_by_usage(
        [of],
        lives,
        count=interval_count(x.size, rate=rate),
        plan=PLAN,
        angle=angle,
        engine=engine,
        torque=None if torque is None else (torque, rate),
        per_turn=1.0,
        second=interval_length(rate),
    )
    return one, of


def pulses(t, *, at, long=0.3):
    """One at each second's `at`, of that many s."""
    since = t % 1 - at
    return np.where((since > 0) & (since < long), np.sin(np.pi * since / long) ** 2, 0.0)


@pytest.mark.parametrize("rest", [0.0, 100.0])
def test_torque_band_uses_torque_at_time_of_stress(rest):
    """All damage came at 4000 N m, and was told to come at 200: the middle of seconds was at rest.

    With a mean stress too, of which rest is the larger in size.
    """
    t = np.arange(int(60 * RATE)) / RATE
    up = pulses(t, at=0.1)
    size = np.repeat(np.linspace(58, 62, 60), int(RATE))
    one, of = asked((rest - size * up) * MPa, torque=200 - 4200 * up)
    (loud,) = [g for g in one.bins["torque"] if g.damage > 1e-3 * of.total_damage]
    assert loud.name == "-4000 .. -3500"
    assert loud.damage == pytest.approx(of.total_damage - of.total_open_damage)
    if not rest:
        assert [p.torque for p in one.stress_peaks] == pytest.approx([-4000] * 8)
        assert all(p.time % 1 == pytest.approx(0.25) for p in one.stress_peaks)


def test_speed_and_gear_bands_use_time_of_stress():
    """A launch, and a change of gear a moment after the largest stress: its second's middle is in
    the next gear, 0.2 turns/s faster."""
    t = np.arange(0, 60, 0.01)
    speed, ratio = 5 + 0.5 * t, np.where(t < 30.3, 3.0, 1.5)
    own, motor = (ShaftRotation(t, np.cumsum(v) * 0.01) for v in (speed, speed * ratio))
    x = 20 * np.sin(2 * np.pi * 2 * np.arange(int(60 * RATE)) / RATE)
    x[int(30.1 * RATE)] = 150.0
    one, _ = asked(x * MPa, angle=ShaftAngle(own), engine=motor)
    top = one.stress_peaks[0]
    assert top.time == pytest.approx(30.1)
    assert top.speed == pytest.approx(5 + 0.5 * 30.1, abs=0.01)
    assert top.gear == "3"
    times = {g.name: g.time for g in one.bins["gear"]}
    assert (times["3"], times["1.5"]) == (pytest.approx(31, abs=1), pytest.approx(29, abs=1))


def test_seconds_keep_true_time_with_fractional_sampling_rate():
    """Twelve samples at 12.4 Hz are 0.968 s: of the last of ten minutes a speed was told that came
    twenty seconds later."""
    rate = 12.4
    clock = np.arange(0, 700, 0.01)
    own = ShaftRotation(clock, np.cumsum(np.where(clock < 595, 10.0, 30.0)) * 0.01)
    n = int(600 * rate)
    x = 20 * np.sin(np.arange(n))
    one, of = asked(x * MPa, rate=rate, angle=ShaftAngle(own))
    assert one.stress_peaks[0].speed in (pytest.approx(10), pytest.approx(30))
    fast = sum(g.time for g in one.bins["speed"] if g.name == "1750 .. 2000")
    assert fast == pytest.approx(5, abs=1)
    assert of.live.sum() == pytest.approx(600, abs=0.1)


def test_usage_table_rows_sum_to_total_damage():
    """What was open at the end was in no row, and a gear that did 44 % of the damage was told to
    have done 100 %; what was in no gear was in no row either."""
    t = np.arange(int(60 * RATE)) / RATE
    x = 20 * np.sin(2 * np.pi * 2 * t)
    x[int(20.3 * RATE)], x[int(40.3 * RATE)] = 90.0, -90.0
    clock = np.arange(0, 60, 0.01)
    turning = np.full(clock.size, 10.0)
    # Between gears for a fifth of the time, at no ratio that lasts.
    ratio = np.where(clock < 48, 1.5, 4 + 3 * np.sin(clock))
    own, motor = (ShaftRotation(clock, np.cumsum(v) * 0.01) for v in (turning, turning * ratio))
    torque = np.where(t < 30, 700.0, np.nan)
    one, of = asked(x * MPa, angle=ShaftAngle(own), engine=motor, torque=torque)
    whole = miner_damage(rainflow(x * MPa), curve=CURVE)
    assert one.residue_damage > 0.3 * whole
    for sort in ("gear", "speed", "torque"):
        every = [*one.bins[sort], one.unassigned[sort]]
        assert sum(g.damage for g in every) + one.residue_damage == pytest.approx(whole)
        assert sum(g.share for g in every) + one.residue_share == pytest.approx(1)
        assert sum(g.closed_damage_share for g in every) == pytest.approx(1)
        assert sum(g.time for g in every) == pytest.approx(60)
    assert one.unassigned["gear"].time == pytest.approx(12, abs=3)
    assert one.unassigned["torque"].time == pytest.approx(29, abs=1)
    assert one.unassigned["speed"].time == 0
    (head, *body) = damage_rows(one, "gear", ENGLISH)
    assert head[2] == "share"
    assert [row[0] for row in body[-2:]] == ["in no gear", "of no second, open at the end"]
    assert sum(float(row[2].removesuffix(" %")) for row in body) == pytest.approx(100, abs=0.2)
    told = json_document(one)
    parts = [*told["damage_by"]["torque"], told["damage_by_none"]["torque"]]
    assert sum(g["damage"] for g in parts) + told["open_damage"] == pytest.approx(whole)
    # What `share` was it is still.
    closed = float(of.damage.sum())
    assert all(g["share"] == g["damage"] / closed for g in told["damage_by"]["torque"])


def test_stepwise_engine_speed_gives_constant_gear_ratios():
    """1500 for six seconds and 3000 for four, exactly: joined straight they made seven gears from
    1.66 to 2.84 at a shaft of 1000 rpm."""
    t = np.arange(int(60 * RATE)) / RATE
    engine = shaft_angle(np.where(t % 10 < 6, 1500.0, 3000.0) / 60, rate=RATE).rotation
    shaft = ShaftAngle(ShaftRotation(t, t * 1000 / 60))
    x = 20 * np.sin(2 * np.pi * 4 * t)
    one, of = asked(x * MPa, angle=shaft, engine=engine)
    gears = {g.name: g.time for g in one.bins["gear"]}
    assert gears == {"1.5": pytest.approx(36), "3": pytest.approx(24)}
    assert one.unassigned["gear"].damage == pytest.approx(0, abs=1e-3 * of.total_damage)


@pytest.mark.parametrize("every", [2.0, 5.0])
def test_slowly_sampled_speed_is_interpolated(every):
    """It comes by a clock: between two readings it goes straight from one to the next."""
    t = np.arange(int(240 * RATE)) / RATE
    driven = (1500 + 500 * np.sin(t / 20)) / 60
    read = np.repeat(driven[:: int(every * RATE)], int(every * RATE))[: t.size]
    turned = shaft_angle(read, rate=RATE).rotation
    middle = np.arange(20, 200) + 0.5
    assert turned.speed(middle) == pytest.approx(
        np.interp(middle, t[:: int(every * RATE)], driven[:: int(every * RATE)]), rel=2e-3
    )


TURNS_A_KM = 1e3 / (2 * np.pi * 0.5) * 4.3


@pytest.mark.slow
@pytest.mark.parametrize(
    ("kmh", "noise", "km", "said"),
    [
        # Reverse: told as "no speed for 20 s", and km were not known.
        ((45, -18, 30), 0.05, 93 * 20 / 3600, "v:km/h: negative for 20 s: reverse, or its sign is"),
        # Its sign the other way round: told as 0 .. 250 rpm and nought km, of all damage.
        ((-30, -30, -30), 0.0, 0.5, "v:km/h: negative for 60 s: reverse, or its sign is"),
        # A number for none is no speed.
        ((45, -2, 30), 0.0, None, "v:km/h: negative for 20 s, one number throughout"),
    ],
)
def test_negative_speed_is_reported_and_counted_by_magnitude(tmp_path, kmh, noise, km, said):
    rng = np.random.default_rng(9)
    t = np.arange(int(60 * RATE)) / RATE
    speed = np.repeat(kmh, int(20 * RATE)) + noise * rng.normal(size=t.size)
    path, out = tmp_path / "a.csv", tmp_path / "a.json"
    np.savetxt(
        path, np.stack([t, 20 * rng.normal(size=t.size), speed], -1), delimiter=",", comments="",
        fmt="%.6g", header="time,S1 [MPa],v",
    )  # fmt: skip
    options = [
        "--gauge", "S1", "--sn", "30,2e6,5", "--speed", "v:km/h", "--axle-ratio", "4.3",
        "--tyre-radius-m", "0.5", "--usage", "--json", str(out),
    ]  # fmt: skip
    done = CliRunner().invoke(command, ["--all", str(path), *options])
    assert done.exit_code == 0, done.output
    told = json.loads(out.read_text())
    (note,) = told["notes"]
    assert note.startswith(said)
    bands = {b["band"]: b["live_s"] for b in told["usage"]["S1"]["damage_by"]["speed"]}
    if km is None:
        assert told["distance_km"] is None
        assert sum(bands.values()) == pytest.approx(40, abs=1)
        assert told["usage"]["S1"]["damage_by_none"]["speed"]["live_s"] == pytest.approx(20, abs=1)
        return
    assert told["distance_km"] == pytest.approx(km, rel=1e-3)
    by_hand = {
        f"{low:g} .. {low + 250:g}": 20.0 * len([v for v in kmh if rpm(v) // 250 * 250 == low])
        for low in {rpm(v) // 250 * 250 for v in kmh}
    }
    assert bands == {band: pytest.approx(time, abs=1) for band, time in by_hand.items()}


def rpm(kmh):
    return abs(kmh) / 60 * TURNS_A_KM


def test_reversing_shaft_loses_angle_but_sign_error_does_not():
    t = np.arange(int(60 * RATE)) / RATE
    driven = 20 * np.cos(2 * np.pi * t / 60)  # backwards from 15 s to 45 s
    turned = shaft_angle(driven, rate=RATE)
    assert turned.negative_speed_intervals == pytest.approx(np.array([[15.0, 45.0]]), abs=0.02)
    assert turned.rotation.speed(np.array([30.0])) == pytest.approx(20, rel=1e-3)
    assert not turned.trusted
    other = shaft_angle(-(20 + np.cos(t)), rate=RATE)
    plain = shaft_angle(20 + np.cos(t), rate=RATE)
    assert other.trusted
    assert other.is_negative(np.array([0.5, 59.5])).all()
    assert not plain.is_negative(t).any()
    assert not other.lost_intervals.size
    np.testing.assert_array_equal(other.rotation.turns, plain.rotation.turns)
    # A zero that is a little off, and what is short, is no reverse.
    still = np.where(t < 30, 20.0, -0.1) + 0.01 * np.sin(t)
    assert not shaft_angle(still, rate=RATE).negative_speed_intervals.size
    assert not shaft_angle(
        np.where(t % 10 < 0.5, -3.0, 20.0), rate=RATE
    ).negative_speed_intervals.size
