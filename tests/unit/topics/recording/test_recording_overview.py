"""`cardan life RECORDING` alone: the table is what NumPy says of the file."""

import json
import shlex

import numpy as np
import pytest
import recording_files as known
from click.testing import CliRunner

from cardan.cli.life import life
from cardan.physics.signals.recording import Channel
from cardan.topics.recording.channel_roles import guess_channel_role
from cardan.topics.recording.recording_overview import next_command, survey_recording

pytestmark = pytest.mark.filterwarnings("ignore")


def run(*arguments):
    done = CliRunner().invoke(life, [*map(str, arguments)])
    assert done.exit_code == 0, done.output
    return done.output


@pytest.mark.parametrize("write", known.TWO_CLOCKS, ids=lambda w: w.__name__)
def test_overview_of_two_clocks_is_that_of_numpy(tmp_path, write):
    path = tmp_path / "a.dat"
    write(path)
    of = survey_recording(path)
    assert of.duration == pytest.approx(known.T.size / known.RATE, rel=1e-9)
    found = {c.channel.name: c for c in of.channels}
    assert {n: c.channel.unit for n, c in found.items()} == known.UNITS
    assert [c.role for c in of.channels] == ["gauge", "speed", "torque"]
    share = np.mean(~np.isnan(known.GAUGE))
    slow = len(known.SLOW_T) / (of.duration * known.SLOW_RATE)
    first = known.SLOW_T[0]
    for name, x, rate, begins, length, valid in (
        ("S1", known.GAUGE, known.RATE, 0.0, of.duration, share),
        ("speed", known.SPEED, known.SLOW_RATE, first, 6.0, slow),
        ("torque", known.TORQUE, known.SLOW_RATE, first, 6.0, slow),
    ):
        one = found[name]
        assert (one.low, one.high) == pytest.approx((np.nanmin(x), np.nanmax(x)), rel=1e-12)
        assert one.rate == pytest.approx(rate, rel=1e-6)
        assert (one.first, one.length) == pytest.approx((begins, length), abs=1e-5)
        assert one.valid_share == pytest.approx(valid, abs=1e-9)
    report = found["S1"].report
    assert (report.missing, report.longest_hole) == (300, 300)
    ((a, b),) = report.faults_of("freeze").runs.tolist()
    assert (a, b) == pytest.approx((3500, 4000), abs=2)


@pytest.mark.parametrize("write", known.ONE_CLOCK, ids=lambda w: w.__name__)
def test_overview_of_one_clock_is_that_of_numpy(tmp_path, write):
    path = tmp_path / "a.dat"
    write(path)
    (one,) = survey_recording(path).channels
    scale = 10 / 2**15 if write is known.wav else 1.0
    expected = scale * known.WHOLE.min(), scale * known.WHOLE.max()
    # 16 bits of RPC III are 1/65504 of the largest value.
    assert (one.low, one.high) == pytest.approx(expected, abs=scale * 58 / 65504)
    assert (one.rate, one.first, one.length, one.valid_share) == (500, 0, 10, 1)
    assert one.channel.unit == ("" if write is known.wav else "MPa")
    assert one.report.faults_of("freeze").count == 1


def test_recording_alone_prints_table_and_command(tmp_path):
    path = tmp_path / "my drive.csv"
    known.csv(path)
    told = run(path)
    lines = told.splitlines()
    assert lines[0] == "my drive.csv: 10 s at 500 Hz"
    (row,) = (line.split() for line in lines if line.startswith("S1 "))
    low, high = np.nanmin(known.GAUGE), np.nanmax(known.GAUGE)
    assert row == ["S1", "MPa", "gauge", "500", "0", "10", f"{low:.6g}", f"{high:.6g}", "94.0", "%"]
    (row,) = (line.split() for line in lines if line.startswith("speed "))
    assert row[2:7] == ["shaft", "speed", "10", "2.0005", "6"]
    assert row[-2:] == ["60.0", "%"]
    assert any("S1: samples standing still: 500; places: 1, the first at 7 s" in s for s in lines)
    command = shlex.split(lines[-1])
    assert command == ["cardan", "life", str(path), "--gauge", "S1:MPa", "--speed", "speed:rpm",
                       "--torque", "torque:Nm", "--sn", "MPa,CYCLES,SLOPE"]  # fmt: skip


@pytest.mark.slow
def test_printed_command_runs_with_a_curve(tmp_path):
    path = tmp_path / "my drive.csv"
    known.csv(path)
    command = shlex.split(run(path).splitlines()[-1])
    done = CliRunner().invoke(life, [*command[2:-1], "30,2e6,5", "--json"])
    assert done.exit_code in (0, 1), done.output
    (gauge,) = json.loads(done.output)["gauges"]
    low, high = np.nanmin(known.GAUGE), np.nanmax(known.GAUGE)
    assert (gauge["low_MPa"], gauge["high_MPa"]) == pytest.approx((low, high))


def test_overview_as_json_keeps_the_keys_of_channels(tmp_path):
    path = tmp_path / "a.csv"
    known.csv(path)
    told = json.loads(run(path, "--json"))
    assert (told["rate_Hz"], told["duration_s"]) == (500, 10)
    one = told["channels"][1]
    assert one["role"] == "speed"
    assert one["rate_Hz"] == pytest.approx(10)
    assert {"missing", "suspects", "findings", "valid_share", "from_s", "low", "high"} <= {*one}
    assert told["next"].startswith("cardan life ")


def test_option_of_an_evaluation_still_needs_its_curve(tmp_path):
    path = tmp_path / "a.csv"
    known.csv(path)
    done = CliRunner().invoke(life, [str(path), "--speed", "speed"])
    assert done.exit_code == 2
    assert "--sn MPa,CYCLES,SLOPE" in done.output


def test_command_leaves_open_what_the_file_does_not_say(tmp_path):
    """A bridge in mV/V needs its calibration, a vehicle's speed its axle ratio and tyre."""
    path, t = tmp_path / "a.csv", np.arange(400) / 200
    x = np.random.default_rng(2).standard_normal((400, 3))
    np.savetxt(
        path, np.column_stack([t, x, 60 + t]), "%.9g", delimiter=",", comments="",
        header="time [s],bridge 1 [mV/V],left_strain_ue,oil pressure [kPa],vehicle [km/h]",
    )  # fmt: skip
    of = survey_recording(path)
    assert [c.role for c in of.channels] == ["gauge", "gauge", "", "vehicle speed"]
    command = next_command(of, "a.csv")
    assert command == (
        "cardan life a.csv --gauge 'bridge 1' --scale 'bridge 1=FACTOR,OFFSET:MPa' "
        "--gauge left_strain_ue:ue --speed vehicle:km/h --axle-ratio RATIO --tyre-radius-m "
        "RADIUS --sn MPa,CYCLES,SLOPE"
    )


def test_acceleration_that_stands_still_is_suspect_and_a_speed_is_not(tmp_path):
    path, x = tmp_path / "a.csv", np.random.default_rng(2).standard_normal(5000)
    x[2000:3000] = x[2000]
    speed = np.where(np.arange(5000) < 3000, 0.0, 900 + x)
    rows = np.column_stack([np.arange(5000) / 500, x, speed])
    head = "time [s],axle [g],shaft [rpm]"
    np.savetxt(path, rows, "%.9g", delimiter=",", header=head, comments="")
    axle, shaft = survey_recording(path).channels
    ((first, last),) = axle.report.faults_of("freeze").runs.tolist()
    assert (first, last) == pytest.approx((2000, 3000), abs=2)
    assert (shaft.role, dict(shaft.report.faults)) == ("speed", {})


@pytest.mark.parametrize(
    ("name", "unit", "role"),
    [
        ("acc z", "m/s2", "acceleration"), ("accel_x", "g", "acceleration"),
        ("oil temp", "°C", "temperature"), ("T_amb", "degC", "temperature"),
        ("TransCurrentGear", "", "gear"), ("Gang", "", "gear"), ("gearbox", "", ""),
        ("gear ratio", "", ""), ("EngSpeed", "rpm", "engine"), ("n_prop", "1/min", "speed"),
        ("throttle", "%", ""), ("strain_4", "%", "gauge"), ("Drehmoment", "", "torque"),
        ("tempo", "", ""), ("S1_MPa", "", "gauge"), ("bearing x", "mm", ""),
        ("n", "", "speed"), ("n_shaft", "", "speed"), ("pin", "", ""),
        ("Drehzahl Rad VL", "1/min", ""), ("Wheel speed RL", "rpm", ""), ("Turbo", "rpm", ""),
        ("Yaw rate", "rad/s", ""), ("Getriebeeingangsdrehzahl", "1/min", ""), ("Rad", "rpm", ""),
        ("n_mot", "1/min", "engine"), ("Drehzahl Verbrenner", "1/min", "engine"),
        ("Crankshaft speed", "rpm", "engine"), ("Lenkmoment", "Nm", ""), ("Bremsmoment", "Nm", ""),
        ("Input shaft torque", "Nm", ""), ("Bremsdruck", "MPa", ""),
        ("Drehzahl Kardan", "1/min", "speed"),
        ("Hydraulic pressure", "MPa", ""), ("Druckspannung", "MPa", "gauge"),
    ],
)  # fmt: skip
def test_role_is_guessed_by_unit_then_name(name, unit, role):
    assert guess_channel_role(Channel(name, unit)) == role


def table(path, rate=500.0, **channels):
    t = np.arange(2000) / rate
    rows = np.stack([t, *(f(t) for f in channels.values())], -1)
    heads = ",".join(["time", *channels])
    np.savetxt(path, rows, delimiter=",", header=heads, comments="", fmt="%.8g")
    return path


def stress(t):
    return 20 * np.sin(2 * np.pi * 5 * t)


def turning(t):
    return 900 + 50 * np.sin(t)


def test_command_leaves_open_which_of_several_speeds_is_the_shaft(tmp_path):
    """The first was taken: a speed of another shaft sets every order wrong, without a word."""
    names = {"S1 [MPa]": stress, "n1 [rpm]": turning, "n2 [rpm]": turning}
    several = table(tmp_path / "a.csv", **names)
    assert "--speed SPEED --sn" in run(several)
    named = table(tmp_path / "b.csv", **names, **{"n_cardan [rpm]": turning})
    assert "--speed n_cardan:rpm --sn" in run(named)


def test_recording_too_slow_for_stress_is_suspect(tmp_path):
    """Milliseconds that a column does not say: 20 s were 5.6 h, and nothing looked wrong."""
    said = " ".join(run(table(tmp_path / "a.csv", 0.5, **{"S1 [MPa]": stress})).split())
    assert "0.5 Hz is too slow for stress: is the time in another unit (--time NAME:ms)?" in said
    assert "No suspect data found" not in said


def test_bus_signal_in_steps_is_not_suspect(tmp_path):
    """A percent of an engine creeps and stands as it is driven: it is no gauge."""
    coarse = {"S1 [MPa]": stress, "Load [%]": lambda t: np.round(50 + 20 * np.sin(0.3 * t))}
    said = run(table(tmp_path / "a.csv", **coarse))
    assert "Load: " not in said
