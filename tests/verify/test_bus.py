"""Numbers by which a bus says that it has none: SAE J1939-71, transmitted signal ranges.

Two bytes of 0.125 rpm: values to 0xFAFF (8031.875), an error from 0xFE00 (8128), nothing from
0xFF00 to 0xFFFF (8191.875). Of a vehicle's speed, 1/256 km/h: 250.996, 254 and 255.996.
"""

import json

import jsonschema
import numpy as np
import pytest
from adversarial import made
from click.testing import CliRunner

from cardan.cli.life import life as command
from cardan.documents.approval_schema import schema
from cardan.physics.signals.attribution_result import JOINTS_DOMINANT
from cardan.physics.signals.recording import SAMPLES_PER_BLOCK, recording_from_arrays
from cardan.physics.signals.shaft_angle import (
    J1939_SHAFT_SPEED_SCALING,
    J1939_VEHICLE_SPEED_SCALING,
    bus_error_runs,
    torque_error_runs,
)
from cardan.topics.recording import channel_reading as module
from cardan.topics.recording.options import AnalysisOptions
from cardan.topics.recording.shaft_signals import measured_shaft_angle
from cardan.topics.recording.study import RecordingStudy

RATE = 200.0


def drive(seconds=60.0):
    t = np.arange(0, seconds, 1 / RATE)
    return 1500 + 600 * np.sin(t / 4)


def test_not_available_values_match_sae_j1939():
    assert (J1939_SHAFT_SPEED_SCALING.first, J1939_SHAFT_SPEED_SCALING.last) == (8032.0, 8191.875)
    assert (J1939_VEHICLE_SPEED_SCALING.first, J1939_VEHICLE_SPEED_SCALING.last) == (
        251.0,
        255.99609375,
    )


@pytest.mark.parametrize("number", [0xFFFF, 0xFF00, 0xFE00, 0xFE13, 0xFB00])
@pytest.mark.parametrize("kind", [np.float64, np.float32])
def test_not_available_values_are_located(number, kind):
    x = drive()
    x[2000:2300] = number * 0.125
    x[7000:7004] = number * 0.125
    found = bus_error_runs(x.astype(kind).astype(float), rate=RATE, of=J1939_SHAFT_SPEED_SCALING)
    assert found.tolist() == [[2000, 2300], [7000, 7004]]


@pytest.mark.parametrize("written", [8191.88, 8191.9, 8128.1])
def test_rounded_not_available_value_is_recognised(written):
    x = drive()
    x[2000:2300] = written
    assert bus_error_runs(x, rate=RATE, of=J1939_SHAFT_SPEED_SCALING).tolist() == [[2000, 2300]]


def test_not_available_values_at_ends_and_gaps_are_found():
    x = drive()
    x[:40] = x[-25:] = x[3000:3100] = 8191.875
    x[2990:3000] = x[3100:3110] = np.nan
    found = bus_error_runs(x, rate=RATE, of=J1939_SHAFT_SPEED_SCALING)
    assert found.tolist() == [[0, 40], [3000, 3100], [x.size - 25, x.size]]


def test_interpolation_flanks_of_not_available_value_are_included():
    """Read ten times a second and laid on 200 Hz, it is reached by twenty steps of 330 rpm."""
    t = np.arange(0, 60, 0.1)
    read = 1500 + 600 * np.sin(t / 4)
    read[100:115] = 8191.875
    x = np.interp(np.arange(0, 59.8, 1 / RATE), t, read)
    ((first, last),) = bus_error_runs(x, rate=RATE, of=J1939_SHAFT_SPEED_SCALING).tolist()
    # From behind the reading at 9.9 s up to that at 11.5 s.
    assert (first, last) == (1981, 2300)


def test_true_speed_in_that_range_is_no_fault():
    t = np.arange(0, 60, 1 / RATE)
    fast = np.rint((6000 + 2150 * np.sin(t / 4)) / 0.125) * 0.125
    assert fast.max() > 8100
    assert not bus_error_runs(fast, rate=RATE, of=J1939_SHAFT_SPEED_SCALING).size
    odd = drive()
    odd[2000:2300] = 8191.83  # of no bus, and no rounded one
    assert not bus_error_runs(odd, rate=RATE, of=J1939_SHAFT_SPEED_SCALING).size


@pytest.fixture(scope="module")
def spoiled(tmp_path_factory):
    """A guilty line whose shaft's channel says 8191.875 rpm for 1.5 s, and its truth beside."""
    case = made(
        5, fault="none", ratio_off=0.0, engine_known=True, contact=False, engine_order=3.0,
        kind="mixed", modes=[{"hertz": 55, "damping": 0.02, "share": 1.0}], seconds=75.0,
        guilt=1.5, road=3.0,
    )  # fmt: skip
    t = np.arange(case.stress.size) / case.rate
    rpm = case.speed * 60
    lost = rpm.copy()
    lost[round(12 * case.rate) : round(13.5 * case.rate)] = 8191.875
    gone = case.torque / 1e3
    gone[round(30 * case.rate) : round(32 * case.rate)] = 65535 * 5e-4
    rows = np.stack([t, case.stress, rpm, lost, case.torque / 1e3, gone], -1)
    path = tmp_path_factory.mktemp("bus") / "a.csv"
    head = "time [s],S1 [MPa],n [rpm],lost [rpm],torque [kNm],gone [kNm]"
    np.savetxt(path, rows, "%.9g", delimiter=",", header=head, comments="")
    return path


def asked(path, speed, *more, torque="torque"):
    asks = [str(path), "--gauge", "S1", "--sn", "30,2e6,5", "--speed", speed, "--torque", torque,
            "--engine-orders", "3,6", "-q", *more]  # fmt: skip
    done = CliRunner().invoke(command, ["--all", *asks, "--json"])
    assert done.exit_code == 0, done.output
    return json.loads(done.output), CliRunner().invoke(command, ["--all", *asks]).output


@pytest.mark.slow
def test_not_available_value_is_reported_with_its_effect(spoiled):
    sound, _ = asked(spoiled, "n")
    assert "misread" not in sound
    found, text = asked(spoiled, "lost")
    contract = {"$defs": schema()["$defs"], "$ref": "#/$defs/life"}
    jsonschema.validate(found, contract, jsonschema.Draft202012Validator)
    (of,) = found["misread"]
    assert (of["channel"], of["kind"], of["count"], of["accepted"]) == ("lost", "sentinel", 1, 0)
    assert of["rpm"] == 8191.875
    assert of["places"][0]["from_s"] == pytest.approx(12, abs=0.01)
    assert of["seconds"] == pytest.approx(1.5, abs=0.02)
    # 136.5 turns/s in place of some 20, for 1.5 s.
    assert 130 < of["turns_otherwise"] < 205
    (gauge,), (true,) = found["gauges"], sound["gauges"]
    assert gauge["removed"] == pytest.approx(true["removed"], abs=0.05)
    assert true["finding"] == JOINTS_DOMINANT
    assert gauge["strength"] > 0.5 * true["strength"]
    # As a speed it loses the angle behind it: nearly nothing is locked any more. What follows the
    # shaft convicts all the same.
    other = of["gauges_otherwise"]["S1"]
    assert other["strength"] < 0.1 * true["strength"]
    assert "8192 rpm" in text or "8191.875 rpm" in text
    assert "writes for an error or no value, taken for holes" in text
    assert "S1: with that taken otherwise" in text


@pytest.mark.slow
def test_not_available_value_can_be_accepted(spoiled):
    found, text = asked(spoiled, "lost", "--accept", "lost=sentinel@11..14")
    (of,) = found["misread"]
    assert of["accepted"] == 1
    assert of["turns_otherwise"] < -130
    first, _ = asked(spoiled, "lost")
    other = first["misread"][0]["gauges_otherwise"]["S1"]
    assert found["gauges"][0]["removed"] == pytest.approx(other["removed"], abs=1e-6)
    assert "accepted as a speed" in text


@pytest.mark.parametrize("code", [0xFFFF, 0xFE00, 0xFF00, 0x7FFF, 0x7FFE, -0x8000, -0x7FFF])
@pytest.mark.parametrize("bit", [1.0, 0.5, 0.125, 0.1, 2.0, 1e-3])
@pytest.mark.parametrize("kind", [np.float64, np.float32])
def test_torque_not_available_value_is_found_at_any_resolution(code, bit, kind):
    usual = np.rint(1500 + 900 * np.sin(np.arange(6000) / 300)) * bit
    usual[2000:2300] = code * bit
    assert torque_error_runs(usual.astype(kind).astype(float), rate=RATE).tolist() == [[2000, 2300]]


@pytest.mark.parametrize("code", [0xFFFF, 0x7FFF, -0x8000])
def test_torque_not_available_value_is_found_on_faster_clock(code):
    """Read ten times a second and laid on 200 Hz: from behind the reading at 9.9 s to 11.5 s."""
    t = np.arange(0, 60, 0.1)
    read = np.rint(1500 + 900 * np.sin(t / 3)) * 0.5
    read[100:115] = code * 0.5
    x = np.interp(np.arange(0, 59.8, 1 / RATE), t, read)
    assert torque_error_runs(x, rate=RATE).tolist() == [[1981, 2300]]


def test_true_torque_peak_is_no_fault():
    """A clunk, one that a transducer cut off, and a channel that reaches as far all the time."""
    t = np.arange(6000) / RATE
    usual = 400 + 200 * np.sin(t)
    clunk = usual + 8000 * np.exp(-(((t - 15) / 0.02) ** 2))
    cut = np.minimum(usual + 9000 * np.exp(-((t - 15) ** 2)), 6553.5)
    strong = np.where(np.sin(t) > 0, 65535 * 0.1, 2500.0)
    narrow = np.clip(usual + 9000 * np.exp(-((t - 15) ** 2)), None, 3276.7)
    brake = np.where(np.sin(t) > 0, -3276.8, 2500.0)
    for x in (usual, clunk, cut, strong, narrow, brake):
        assert not torque_error_runs(x, rate=RATE).size


@pytest.mark.slow
def test_torque_not_available_value_is_reported(spoiled):
    found, text = asked(spoiled, "n", torque="gone")
    contract = {"$defs": schema()["$defs"], "$ref": "#/$defs/life"}
    jsonschema.validate(found, contract, jsonschema.Draft202012Validator)
    (of,) = found["misread"]
    assert (of["channel"], of["kind"], of["count"], of["accepted"]) == ("gone", "sentinel", 1, 0)
    assert (of["rpm"], of["torque_Nm"]) == (None, pytest.approx(32767.5))
    assert of["seconds"] == pytest.approx(2.0, abs=0.02)
    assert of["places"][0]["from_s"] == pytest.approx(30, abs=0.01)
    sound, _ = asked(spoiled, "n")
    (gauge,), (true,) = found["gauges"], sound["gauges"]
    assert gauge["removed"] == pytest.approx(true["removed"], abs=0.05)
    assert true["finding"] == gauge["finding"] == JOINTS_DOMINANT
    other = of["gauges_otherwise"]["S1"]
    # What is locked follows the torque: as one of 32767 N m it hides nearly all of that.
    assert other["strength"] < 0.1 * true["strength"]
    assert gauge["strength"] > 0.9 * true["strength"]
    assert "no torque for" in text
    accepted, text = asked(spoiled, "n", "--accept", "gone=sentinel", torque="gone")
    assert accepted["misread"][0]["accepted"] == 1
    assert accepted["gauges"][0]["removed"] == pytest.approx(other["removed"], abs=1e-6)
    assert "accepted as a torque" in text


def test_thinned_sampling_of_a_day_gives_equal_lag(monkeypatch):
    """Held in no more memory than some hours: the channel's straight lines stay what they are."""
    rate = 400.0
    t = np.arange(0, 120, 1 / rate)
    speed = 1200 + 300 * np.sin(2 * np.pi * t / 10)
    of = recording_from_arrays(
        np.stack([speed, speed]), rate=rate, names=["S1", "n"], units=["MPa", "rpm"]
    )
    asks = AnalysisOptions(sn="30,2e6,5", gauges=("S1",), speed="n")
    whole = measured_shaft_angle(asks, of).rotation
    monkeypatch.setattr(module, "MAX_ROTATION_TIME_POINTS", 5000)
    values, often = module.sampled_channel(of, "n")
    assert often == 25.0
    np.testing.assert_array_equal(values, speed[::16])
    # Steady for most of the time, which is no staircase however seldom it is looked at.
    held = np.clip(speed, 1150, 1250)
    calm = recording_from_arrays(
        np.stack([held, held]), rate=rate, names=["S1", "n"], units=["MPa", "rpm"]
    )
    found = measured_shaft_angle(asks, calm)
    assert (found.trusted, found.lag) == (True, 0.15)
    less = measured_shaft_angle(asks, of).rotation
    at = np.arange(1, 119, 0.37)
    # Straight lines over 40 ms of 5 turns/s at 0.1 Hz: (0.2π)² 5 (0.04)²/12 = 2.6e-4 turns/s.
    np.testing.assert_allclose(less.at(at), whole.at(at), atol=1e-3)
    np.testing.assert_allclose(less.speed(at), whole.speed(at), atol=5e-3)


def test_a_day_is_thinned_in_one_piece(monkeypatch):
    """Each piece by itself, where its first reading lies among all: none is met beside its time."""
    n = 3 * SAMPLES_PER_BLOCK + 1000
    x = np.arange(n, dtype=float)
    of = recording_from_arrays(x[None], rate=600.0, names=["n"], units=["rpm"])
    monkeypatch.setattr(module, "MAX_ROTATION_TIME_POINTS", 100_000)
    values, often = module.sampled_channel(of, "n")
    assert often == 600 / 12
    np.testing.assert_array_equal(values, x[::12])


@pytest.mark.slow
@pytest.mark.parametrize("where", ["first", "last"])
@pytest.mark.parametrize("of", ["speed", "S1"])
def test_missing_data_at_ends_keeps_cause_finding(of, where):
    """A bus that wakes up late, a logger that is switched off: the rest is as good as ever."""
    case = made(5, guilt=1.5, road=3.0, fault="none", kind="mixed", modes=[], contact=False)
    rows = {"S1": case.stress, "speed": 60 * case.speed, "torque": case.torque}
    spoiled = rows[of] = rows[of].copy()
    seconds = slice(None, int(1.5 * case.rate))
    (spoiled if where == "first" else spoiled[::-1])[seconds] = -9999 if of == "S1" else 8191.875
    recording = recording_from_arrays(
        np.stack(list(rows.values())), rate=case.rate, names=rows, units=["MPa", "rpm", "Nm"]
    )
    campaign = AnalysisOptions(
        sn="30,2e6,5", gauges=("S1",), speed="speed", torque="torque", mask=("sentinel",),
        engine_orders="3,6",
    )  # fmt: skip
    (found,) = RecordingStudy(campaign).run(recording).answer.causes.joint_attributions
    assert found.verdict == JOINTS_DOMINANT
    assert found.interval[0] > 0.8
