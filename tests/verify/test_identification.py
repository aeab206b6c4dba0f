"""An application found again in a recording that mechanics of another hand made (`shaken.py`).

The file's rubber is 13 % too soft one way and 18 % too firm the other. Whatever the recording
says of it has to hold the truth inside its interval.
"""

import json
import re
from dataclasses import replace
from functools import partial

import jsonschema
import numpy as np
import pytest
from case_selection import select
from click.testing import CliRunner
from shaken import LINE, Truth, run_up, shaken

from cardan.application import reader
from cardan.cli.life import life as command
from cardan.core.errors import DesignError
from cardan.documents.approval_schema import schema
from cardan.physics.fatigue.damage import miner_damage
from cardan.physics.fatigue.rainflow import rainflow
from cardan.physics.fatigue.sn_curve import SNCurve
from cardan.physics.fatigue.strain_gauges import single_gauge
from cardan.physics.signals.assessment import AssessmentSettings, assess_gauges
from cardan.physics.signals.order_cuts import order_cuts, order_windows
from cardan.physics.signals.order_tracking import ShaftRotation
from cardan.physics.signals.recording import recording_from_arrays
from cardan.physics.signals.shaft_angle import ShaftAngle
from cardan.topics.recording import parameter_identification as identification
from cardan.topics.recording.bearing_model import _pole
from cardan.topics.recording.identification_result import (
    application_with_changes,
    parameter_changes,
)
from cardan.topics.recording.identified_force import joint_force_history
from cardan.topics.recording.parameter_identification import identify_parameters
from cardan.topics.recording.predicted_life import bearing_force_history, predict_life

TRUE = Truth()
CASES = {
    "rubber": (TRUE, 1),
    "a mode of the bracket": (replace(TRUE, mode=(24.0, 0.02)), 2),
    "put together wrongly": (replace(TRUE, phases=(0.0, np.pi / 2)), 3),
    "a weld 4 degrees off": (replace(TRUE, phases=(0.0, np.radians(4))), 9),
    "unbalanced": (replace(TRUE, unbalance=4e-3, noise=0.6e6), 4),
    "a gauge that reads 8 % more": (replace(TRUE, gain=1.08, noise=0.6e6), 5),
}


@pytest.fixture(scope="module")
def application(tmp_path_factory):
    path = tmp_path_factory.mktemp("line") / "line.yaml"
    path.write_text(LINE)
    return reader.read(path)


def asked(application, truth, seed, *, seconds=100.0, bus=None):
    """What the recording of a truth says; `bus` spoils the angle: ratio, lag s, as from a bus."""
    one = shaken(truth, seconds=seconds, seed=seed)
    time = np.arange(one.turns.size) / one.rate
    angle = ShaftAngle(ShaftRotation(time[::5], one.turns[::5]), lag=0.02)
    if bus is not None:
        ratio, lag = bus
        angle = ShaftAngle(ShaftRotation(time[::5] + lag, ratio * one.turns[::5]), lag=0.15)
    return identify_parameters(
        application, iter([one.stress[None] * 1e6]), rate=one.rate, gauges=["S1"],
        units=np.array([truth.unit]), angle=angle, torque=(one.torque, one.rate),
        seconds=time[-1], state="as given",
    )  # fmt: skip


def true(truth):
    """What is so, by the names of what is found."""
    found = {
        "vertical": truth.vertical, "lateral": truth.lateral, "loss": truth.loss,
        "gain": truth.gain, "unbalance": truth.unbalance,
    }  # fmt: skip
    if truth.mode:
        found |= {"mode": truth.mode[0], "mode damping": truth.mode[1]}
    return found | {"phase": truth.phases[1]}


@pytest.mark.slow
@pytest.mark.parametrize("name", select(CASES, "a mode of the bracket"))
def test_true_values_lie_within_every_interval(application, name):
    truth, seed = CASES[name]
    found = asked(application, truth, seed)
    numbers = {p.name: p for p in found.parameters}
    assert set(numbers) == set(true(truth)) | {"unbalance", "phase"}
    for key, value in true(truth).items():
        p = numbers[key]
        assert p.low <= value <= p.high, f"{key}: {value:g} not in {p.low:g} .. {p.high:g}"
    # An interval that holds everything says nothing.
    assert numbers["vertical"].high < 1.07 * numbers["vertical"].low
    assert numbers["lateral"].high < 1.07 * numbers["lateral"].low
    assert numbers["vertical"].contradicts_file
    assert numbers["lateral"].contradicts_file
    assert numbers["unbalance"].identifiable == (truth.unbalance > 0)
    # Most of what the file leaves open is explained.
    assert found.misfit[1] < 0.02 < 0.1 < found.misfit[0]


@pytest.mark.slow
@pytest.mark.long
def test_angle_from_bus_gives_equal_identification(application):
    """A quarter of a per mille off, and 4 ms late: what identification of speed leaves."""
    found = asked(application, TRUE, 6, bus=(1.00025, 0.004))
    for p in found.parameters:
        if p.name in ("vertical", "lateral", "loss"):
            assert p.low <= getattr(TRUE, p.name) <= p.high, p.name
    # Taken to be on time it leaves 6 % of order 2 unexplained.
    assert found.misfit[1] < 0.01


@pytest.mark.slow
@pytest.mark.long
def test_correct_file_is_not_changed(application):
    truth = replace(TRUE, vertical=150e3, lateral=100e3, loss=0.1)
    found = asked(application, truth, 7)
    assert not any(p.contradicts_file for p in found.parameters)
    assert found.file_changes() == {}
    assert found.file_text() == LINE


def test_values_missing_in_file_are_identified_and_added(tmp_path):
    path = tmp_path / "line.yaml"
    path.write_text(LINE.replace("        loss_factor: 0.1\n", ""))
    bearing = "driveline.shafts[1].centre_bearing"
    found = application_with_changes(
        reader.read(path),
        {f"{bearing}.loss_factor": 0.085, f"{bearing}.vertical_stiffness_N_mm": 172.5},
    )
    mount = found.lines[0].line.shafts[0].centre_bearing
    assert mount.loss_factor == 0.085
    assert mount.stiffness[0] == pytest.approx(172.5e3)


@pytest.mark.long
def test_fast_run_up_does_not_bias_stiffness(application):
    """At a hundred rpm a second modes peak late and low: without their memory k is 6 % off."""
    found = asked(application, TRUE, 8, seconds=40.0)
    for p in found.parameters:
        if p.name in ("vertical", "lateral"):
            assert p.low <= getattr(TRUE, p.name) <= p.high, p.name


@pytest.mark.slow
def test_coarse_time_step_is_accurate_enough_for_selection(application, monkeypatch):
    """Of a quick run-up as well: by less than one standard deviation in all, of 300 numbers."""
    asked_of = []

    def best(fit, coarse, **_):
        asked_of.extend((fit, coarse))
        raise StopIteration

    monkeypatch.setattr(identification, "_best", best)
    with pytest.raises(StopIteration):
        asked(application, TRUE, 8, seconds=40.0)
    fit, coarse = asked_of
    free = fit.free(turned=None, mode=None)
    rng = np.random.default_rng(1)
    for _ in range(5):
        x = rng.normal(0, 0.2, len(free))
        off = coarse.residuals(free, x) - fit.residuals(free, x)
        assert off.size > 300
        assert np.abs(off).max() < 0.3 < 1.0 > np.linalg.norm(off)
        left = fit.residuals(free, x)
        assert coarse.residuals(free, x) @ coarse.residuals(free, x) == pytest.approx(
            left @ left, rel=0.02
        )


@pytest.mark.long
def test_drive_away_from_resonance_is_identified(application):
    """All modes lay above four times its speed, and the mean of none of them was no number."""
    bearing = "driveline.shafts[1].centre_bearing"
    stiff = application_with_changes(
        application,
        {f"{bearing}.vertical_stiffness_N_mm": 2000, f"{bearing}.lateral_stiffness_N_mm": 1500},
    )
    truth = replace(TRUE, mode=None, vertical=2.3e6, lateral=1.7e6)
    one = shaken(truth, seconds=60.0, seed=13, drive=partial(run_up, low=2.0, high=5.0))
    time = np.arange(one.turns.size) / one.rate
    found = identify_parameters(
        stiff,
        iter([one.stress[None] * 1e6]),
        rate=one.rate,
        gauges=["S1"],
        units=np.array([truth.unit]),
        angle=ShaftAngle(ShaftRotation(time[::5], one.turns[::5]), lag=0.02),
        torque=(one.torque, one.rate),
        seconds=time[-1],
        state="as given",
    )
    assert np.isfinite(found.misfit).all()
    for p in found.parameters:
        if p.name in ("vertical", "lateral") and p.identifiable:
            assert p.low <= getattr(truth, p.name) <= p.high, p.name


@pytest.mark.long
def test_model_error_does_not_average_out_with_duration(application):
    """Four times the recording: of what is not only noise the interval is no narrower, by a fifth.

    By noise alone, and by blocks of windows, it is half to two thirds as wide.
    """

    def width(seconds):
        found = asked(application, TRUE, 1, seconds=seconds).parameters
        first = next(p for p in found if (p.name, p.part.number) == ("phase", 1))
        return first.high - first.low

    assert width(400.0) > 0.8 * width(100.0)


def test_order_extraction_is_accurate_to_rounding():
    """Of a steady shaft whole orders do not see each other, nor a level."""
    rate, n = 1000.0, 20_000
    t = np.arange(n) / rate
    rotation = ShaftRotation(np.array([0.0, 20.0]), np.array([0.25, 160.25]))
    theta = 2 * np.pi * rotation.at(t)
    x = 7 + 3 * np.cos(theta + 0.4) + 5 * np.cos(2 * theta - 1.1) + 2 * np.sin(4 * theta)
    at = order_windows(rotation, until=t[-1])
    found = order_cuts([x[None, :700], x[None, 700:]], rate=rate, rotation=rotation, at=at)
    want = np.array([3 * np.exp(0.4j), 5 * np.exp(-1.1j), -2j])
    # 125 samples a turn: the sum is a trapezium's over whole turns, exact but for its ends.
    assert np.abs(found.amplitude[0] - want[:, None]).max() < 1e-4
    assert found.noise.max() < 1e-4
    # What is no order leaks as far as Hann's window lets it: 1e-4 of it ten cells away.
    other = 10 * np.cos(5.3 * theta)
    (leaked,) = order_cuts([other[None]], rate=rate, rotation=rotation, at=at).amplitude
    assert np.abs(leaked).max() < 0.01


def written(path, rows):
    np.savetxt(
        path, rows, delimiter=",", comments="", fmt="%.6g",
        header="time,S1 [MPa],torque [kNm],tacho [V],speed [rpm]",
    )  # fmt: skip


def identified(folder, run, *more):
    """What the command says of a recording, told beside it, of the folder's line and a stiffer."""
    return CliRunner().invoke(
        command,
        [
            str(run), "--all", "--gauge", "S1", "--sn", "30,2e6,5", "--tacho", "tacho", "--torque",
            "torque", "--application", str(folder / "line.yaml"), "--state", "as given",
            "--unit-stress", "S1=0,9,30", "--identify", "--json",
            str(run.parent / "told.json"), "--changed", str(folder / "stiff.yaml"), *more,
        ],
    )  # fmt: skip


@pytest.fixture(scope="module")
def told(tmp_path_factory):
    """A recording as a file, its application, and what the command says of them."""
    folder = tmp_path_factory.mktemp("told")
    truth = replace(TRUE, mode=None)
    one = shaken(truth, seconds=100.0, rate=400.0, seed=9)
    time = np.arange(one.turns.size) / one.rate
    rows = np.stack(
        [time, one.stress, one.torque / 1e3, 5.0 * (one.turns % 1 < 0.25), one.speed * 60], axis=-1
    )
    written(folder / "run.csv", rows)
    (folder / "line.yaml").write_text(LINE)
    stiff = re.sub(r"(vertical_stiffness_N_mm: )[\d.]+", r"\g<1>400", LINE)
    (folder / "stiff.yaml").write_text(stiff)
    done = identified(
        folder,
        folder / "run.csv",
        "--corrected",
        str(folder / "new.yaml"),
        "--load-history",
        str(folder / "load.csv"),
    )
    assert done.exit_code == 0, done.output
    return folder, one, done.output


@pytest.mark.slow
def test_command_writes_corrected_file_and_keeps_comments(told):
    """Numbers that are otherwise, and nothing else; comments stay, and the file is read again."""
    folder, _, _ = told
    old, new = LINE.splitlines(), (folder / "new.yaml").read_text().splitlines()
    assert len(old) == len(new)
    changed = [(a, b) for a, b in zip(old, new, strict=True) if a != b]
    keys = ("vertical_stiffness_N_mm", "lateral_stiffness_N_mm", "loss_factor")
    told_of = [old.split(":")[0].strip() for old, _ in changed]
    assert told_of == [k for k in keys if k in told_of]
    assert {"vertical_stiffness_N_mm", "lateral_stiffness_N_mm"} <= set(told_of)
    new = {k: float(re.search(rf"{k}: ([\d.]+)", "\n".join(new))[1]) for k in keys}
    assert list(new.values()) == pytest.approx([172.5, 85, 0.085], rel=0.06)
    application = reader.read(folder / "new.yaml")
    bearing = application.lines[0].line.shafts[0].centre_bearing
    assert bearing.stiffness == pytest.approx([172.5e3, 85e3], rel=0.02)
    assert (folder / "line.yaml").read_text() == LINE


@pytest.mark.slow
def test_command_reports_parameters_and_order_amplitudes(told):
    folder, _, output = told
    found = json.loads((folder / "told.json").read_text())["identification"]
    numbers = {p["name"]: p for p in found["parameters"]}
    low, high = numbers["vertical stiffness"]["interval"]
    assert low <= 172.5 <= high
    assert numbers["vertical stiffness"]["written"] == 150
    assert numbers["unbalance at the rear end"]["found"] is None
    second = next(o for o in found["orders"] if o["order"] == 2)["windows"]
    off = [abs(w["measured_MPa"] - w["found_MPa"]) for w in second]
    was = [abs(w["measured_MPa"] - w["written_MPa"]) for w in second]
    assert np.mean(off) < 0.2 * np.mean(was)
    assert "otherwise than written" in output


@pytest.mark.slow
def test_json_matches_contract_schema(told):
    """With a changed line as well: `changed` had not been in the schema."""
    folder, _, _ = told
    found = json.loads((folder / "told.json").read_text())
    (promise,) = found["changed"]
    assert promise["gauge"] == "S1"
    assert promise["damage_recorded"] == pytest.approx(found["gauges"][0]["damage"], rel=0.05)
    of = {"$defs": schema()["$defs"], "$ref": "#/$defs/life"}
    check = jsonschema.Draft202012Validator(of)
    assert [e.message for e in check.iter_errors(found)] == []
    assert list(check.iter_errors(found | {"changed": [promise | {"hour": 1}]}))


@pytest.mark.slow
def test_changed_line_deviating_from_identified_values_is_noted(told):
    """Its file was not written upon the corrected one: rubber of neither, and nobody said so."""
    folder, _, output = told
    found = json.loads((folder / "told.json").read_text())
    numbers = {p["name"]: p for p in found["identification"]["parameters"]}
    departed = {d["name"]: d for d in found["departures"]}
    assert {"vertical stiffness", "lateral stiffness"} <= set(departed)
    own = departed["vertical stiffness"]
    # The change that was asked for, and what the file had wrong.
    assert own["changed"] == 400
    assert departed["lateral stiffness"]["changed"] == numbers["lateral stiffness"]["written"]
    for name, one in departed.items():
        assert [one[k] for k in ("found", "interval", "address")] == [
            numbers[name][k] for k in ("found", "interval", "address")
        ]
        assert (
            one["changed"] is None or not one["interval"][0] <= one["changed"] <= one["interval"][1]
        )
    said = " ".join(output.split())
    assert "vertical stiffness of centre bearing 1: in the changed application 400 N/mm" in said
    assert "unless these are the change that is meant, the promise is of another line" in said


@pytest.mark.slow
@pytest.mark.long
def test_change_of_corrected_file_deviates_only_by_that_change(told, application):
    folder, *_ = told
    found = asked(application, replace(TRUE, mode=None), 9)
    corrected = reader.read(folder / "new.yaml")
    assert parameter_changes(found, found.identified) == ()
    stiff = application_with_changes(
        corrected, {"driveline.shafts[1].centre_bearing.vertical_stiffness_N_mm": 400}
    )
    (only,) = parameter_changes(found, stiff)
    assert (only.identified.name, only.value) == ("vertical", pytest.approx(400e3))
    # What was found, and the changed line does not have at all.
    rigid = re.sub(
        r"\n +(vertical|lateral)_stiffness_N_mm: [\d.]+", "", (folder / "new.yaml").read_text()
    )
    (folder / "rigid.yaml").write_text(rigid)
    gone = parameter_changes(found, reader.read(folder / "rigid.yaml"))
    assert {d.identified.name for d in gone} >= {"vertical", "lateral"}
    assert np.isnan([d.value for d in gone if d.identified.name in ("vertical", "lateral")]).all()


@pytest.mark.slow
def test_rubber_key_that_cannot_be_written_is_rejected_at_once(tmp_path):
    """After a minute it had said that two keys exclude each other, of which the file has one."""
    path = tmp_path / "line.yaml"
    path.write_text(
        re.sub(r"vertical_stiffness_N_mm: [\d.]+\n +lateral_stiffness_N_mm", "stiffness_N_mm", LINE)
    )
    with pytest.raises(DesignError, match="give both in place of what says it otherwise"):
        asked(reader.read(path), TRUE, 1, seconds=40.0)


@pytest.mark.slow
def test_unidentified_line_gives_no_prediction(told, tmp_path):
    """Its order 2 was taken for road, and stayed through any cure: 1.504 h became 1.505."""
    folder, _, _ = told
    time, _, torque, tacho, speed = np.loadtxt(folder / "run.csv", delimiter=",", skiprows=1).T
    angle = 2 * np.pi * np.cumsum(speed) / 60 * (time[1] - time[0])
    rng = np.random.default_rng(3)
    gauge = 25 * rng.normal(size=time.size).cumsum() / np.sqrt(time.size) + 20 * np.cos(2 * angle)
    rows = np.stack([time, gauge, torque, tacho, speed], axis=-1)
    written(tmp_path / "other.csv", rows)
    done = identified(
        folder,
        tmp_path / "other.csv",
        "--accept",
        "drift",
        "--load-history",
        str(tmp_path / "load.csv"),
    )
    # What was heard is told; a force of a line that nothing is known of is not.
    assert done.exit_code == 2, done.output
    assert (
        "--load-history writes nothing: this recording identifies nothing of the line"
        in done.output
    )
    assert not (tmp_path / "load.csv").exists()
    found = json.loads((tmp_path / "told.json").read_text())
    assert found["identification"]["doubts"]
    assert "changed" not in found
    assert "nothing is promised of the changed line" in done.output


@pytest.mark.slow
def test_rejected_gauge_gets_no_life_prediction(told, tmp_path):
    """Its hours stood under the changed line, and "data rejected" in the table above."""
    folder, *_ = told
    rows = np.loadtxt(folder / "run.csv", delimiter=",", skiprows=1)
    rows[[9000, 21000], 1] = 900.0
    written(tmp_path / "spiked.csv", rows)
    done = identified(folder, tmp_path / "spiked.csv")
    found = json.loads((tmp_path / "told.json").read_text())
    assert found["gauges"][0]["quality"]["verdict"] == "data rejected", done.output
    assert not found["identification"]["doubts"]
    assert "changed" not in found
    assert "nothing is promised of the changed line" in done.output


@pytest.mark.slow
def test_load_history_matches_bearing_force(application):
    """Against the force that the generator's springs had: 8 % rms, the passing of a mode too."""
    truth = replace(TRUE, mode=None)
    one, found = shaken(truth, seconds=100.0, seed=9), asked(application, truth, 9)
    clock = np.arange(one.turns.size) / one.rate
    time, force = joint_force_history(
        found, ShaftRotation(clock[::5], one.turns[::5]), (one.torque, one.rate), seconds=clock[-1]
    )
    force = force.T
    want = np.stack([np.interp(time, np.arange(len(one.force)) / one.rate, f) for f in one.force.T])
    inside = (time > 3) & (time < 95)
    for k in (1, 2):
        swing = want[k, inside] - want[k, inside].mean()
        off = force[k, inside] - want[k, inside]
        assert np.std(off) < 0.08 * np.std(swing)
        assert abs(np.mean(off)) < 0.05 * np.abs(want[k, inside]).max()


@pytest.mark.slow
def test_command_writes_load_history_of_gauge(told):
    """Of one gauge the least force that does what it read, but for what is slower than 10 s."""
    folder, one, _ = told
    time, *force = np.loadtxt(folder / "load.csv", delimiter=",", skiprows=1).T
    read = np.interp(time, np.arange(one.stress.size) / one.rate, one.stress)
    felt = np.array([0.0, 9e-3, 30e-3]) @ force
    inside = (time > 3) & (time < 95)
    assert np.std((felt - read)[inside]) < 0.1 * np.std(read[inside])


@pytest.mark.slow
def test_load_history_keeps_road_force_if_line_changes(application):
    """Three gauges, the generator's springs, a road of known force: 15 % rms of what it pushes."""
    truth = replace(TRUE, mode=None, noise=0.0)
    one = shaken(truth, seconds=60.0, rate=500.0, seed=11)
    units = np.array([[0.5e3, 20e3, 4e3], [0.5e3, -20e3, 4e3], [0.1e3, 1e3, 25e3]])
    time = np.arange(one.turns.size) / one.rate
    rng = np.random.default_rng(4)
    blows = np.exp(-9 * (time % 6)) * np.sin(2 * np.pi * 14 * (time % 6))
    road = np.stack([0 * time, 700 * blows, 1500 * blows + rng.normal(0, 30, time.size)], axis=-1)
    stress = units @ (one.force + road).T + 40e6 * (1 - np.exp(-time / 30))  # and a zero creeps
    stress[2, 5000:5100] = np.nan
    angle = ShaftAngle(ShaftRotation(time[::5], one.turns[::5]), lag=0.02)
    drive = {"torque": (one.torque, one.rate), "seconds": time[-1]}
    found = identify_parameters(
        application, iter([stress]), rate=one.rate, gauges=["A", "B", "C"], units=units,
        angle=angle, state="as given", **drive,
    )  # fmt: skip
    how = {"rate": one.rate, "rotation": angle.rotation, **drive}
    pieces = np.split(stress, [700, 7777], axis=1)
    clock, force = bearing_force_history(found, pieces, **how)
    inside = (clock > 3) & (clock < 55) & ~((clock > 9.9) & (clock < 10.3))
    want = (one.force + road)[: len(clock)]
    alone = joint_force_history(
        found, angle.rotation, drive["torque"], seconds=time[-1], rate=one.rate
    )[1]
    for k in (1, 2):
        push = np.std(road[: len(clock)][inside, k])
        off = np.std((force - want)[inside, k])
        assert off < 0.15 * push
        assert off < 0.2 * np.std((alone - want)[inside, k])
    # Another line: its own joints' force, and the same road.
    stiff = application_with_changes(
        application, {"driveline.shafts[1].centre_bearing.vertical_stiffness_N_mm": 400}
    )
    _, other = bearing_force_history(found, pieces, **how, application=stiff)
    _, joints = joint_force_history(
        found, angle.rotation, drive["torque"], seconds=time[-1], rate=one.rate, application=stiff
    )  # fmt: skip
    assert other - force == pytest.approx(joints - alone, abs=1e-6)


@pytest.mark.slow
def test_prediction_is_counted_like_recording(application):
    """The changed line's own force in place of the old one's, at every sample, not at some.

    Straight lines between 250 samples a second lost 5 % of order 2 at 30 Hz and 30 % at 80: what
    was left of the old line spoiled a cure, and a worse one was promised too long a life.
    """
    truth = replace(TRUE, mode=None, noise=0.0)
    one = shaken(truth, seconds=60.0, rate=1000.0, seed=12)
    time = np.arange(one.turns.size) / one.rate
    units = np.array([[0.5e3, 9e3, 30e3]])
    angle = ShaftAngle(ShaftRotation(time[::5], one.turns[::5]), lag=0.02)
    drive = {"torque": (one.torque, one.rate), "seconds": float(time.size / one.rate)}
    found = identify_parameters(
        application, iter([units @ one.force.T]), rate=one.rate, gauges=["A"], units=units,
        angle=angle, state="as given", **drive,
    )  # fmt: skip

    def felt(of):
        how = {"seconds": drive["seconds"], "rate": one.rate, "application": of}
        return (
            found.unit_stress
            @ joint_force_history(found, angle.rotation, drive["torque"], **how)[1].T
        )

    curve = SNCurve(amplitude=30e6, cycles=2e6, slope=5).elementary()
    plan = AssessmentSettings(gauges=(single_gauge("A", "A", factor=1.0),), curve=curve)
    old = felt(None)
    (told,) = assess_gauges(recording_from_arrays(old, rate=one.rate, names=["A"]), plan=plan)
    # As if more had been counted between samples than at them.
    told = replace(told, life=replace(told.life, damage=1.5 * told.life.damage))
    stiff = application_with_changes(
        application, {"driveline.shafts[1].centre_bearing.vertical_stiffness_N_mm": 400}
    )
    for of in (None, stiff):
        (promise,) = predict_life(
            found, of or found.identified, np.split(old, [7000, 7001], axis=1), rate=one.rate,
            rotation=angle.rotation, **drive, plan=plan, lives=[told],
        )  # fmt: skip
        was, would = (miner_damage(rainflow(x[0]), curve=curve) for x in (old, felt(of)))
        want = told.life.damage * would / was
        assert promise.changed.damage == pytest.approx(want, rel=1e-6)
        assert (promise.changed.damage == promise.recorded.damage) == (of is None)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("options", "said"),
    [
        (["--identify"], "--identify needs the --application"),
        (["--corrected", "out.yaml"], "--corrected reports what --identify finds"),
    ],
)
def test_identification_options_without_application_are_rejected(told, options, said):
    folder, _, _ = told
    done = CliRunner().invoke(
        command, [str(folder / "run.csv"), "--gauge", "S1", "--sn", "30,2e6,5", *options]
    )
    assert done.exit_code == 2
    assert said in done.output


@pytest.mark.parametrize("z", [0.05, 1.0, 1.28])
def test_mode_pole_solves_characteristic_equation(z):
    """s² + 2 z w s + w² = 0, damped beyond 1 too, which a search may try: it was no number."""
    pole = _pole(30.0, z)
    assert pole**2 + 2 * z * 30.0 * pole + 30.0**2 == pytest.approx(0.0, abs=1e-9)
