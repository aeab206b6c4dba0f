"""A recording that contradicts what was said of it is refused, doubted or vetoed, in numbers."""

import json

import numpy as np
import pytest
from click.testing import CliRunner

from cardan.cli.life import life as command
from cardan.physics.signals.faults.fault_kind import SignalBlock
from cardan.physics.signals.faults.mains_hum import MainsHumDetector
from cardan.physics.signals.shaft_angle import shaft_angle

RATE = 1000.0
T = np.arange(60_000) / RATE
SN = ("--sn", "30,2e6,5")


def stress(seed=0):
    """An order 2 that wanders about 11 Hz, and a road: MPa."""
    rng = np.random.default_rng(seed)
    wander = 11 * T + 0.4 * np.sin(0.5 * T)
    return 30 * np.sin(2 * np.pi * wander) + rng.normal(size=T.size)


def written(folder, columns, clock="time_s", time=None):
    time = T[: len(next(iter(columns.values())))] if time is None else time
    head = ",".join([clock, *columns])
    rows = np.stack([time, *columns.values()], -1)
    np.savetxt(folder / "a.csv", rows, "%.9g", delimiter=",", header=head, comments="")
    return folder / "a.csv"


def run(*arguments):
    return CliRunner(env={"COLUMNS": "400"}).invoke(command, ["--all", *map(str, arguments)])


def asked(path, *arguments, code=1):
    done = run(path, *arguments, "--json", "-q")
    assert done.exit_code == code, done.output
    (gauge,) = json.loads(done.output)["gauges"]
    return gauge


def vetoed(path, kind, *arguments, says=()):
    """The one gauge, and what is said of its veto."""
    gauge = asked(path, *arguments)
    assert gauge["quality"]["verdict"] == "data rejected"
    assert gauge["quality"]["vetoes"] == [kind]
    assert gauge["hours"] is None
    (suspect,) = (s for s in gauge["quality"]["suspects"] if s["kind"] == kind)
    told = run(path, *arguments).output
    for word in says:
        assert word in suspect["why"]
        assert word in told
    accepted = asked(path, *arguments, "--accept", kind, code=0)
    assert accepted["quality"]["vetoes"] == []
    assert (accepted["hours"] or np.inf) > 0
    return suspect


@pytest.mark.slow
@pytest.mark.parametrize(("factor", "size"), [(1e6, "3."), (1e3, "3.")])
def test_pascal_values_declared_as_megapascal_are_rejected(tmp_path, factor, size):
    path = written(tmp_path, {"S1": stress() * factor})
    suspect = vetoed(path, "unit", "--gauge", "S1:MPa", *SN, says=("any metal bears (3000 MPa)",))
    assert size in suspect["why"]


def test_strain_declared_without_micro_is_rejected_as_noise(tmp_path):
    path = written(tmp_path, {"S1": stress() / 206e3})
    vetoed(path, "unit", "--gauge", "S1:MPa", *SN, says=("less than a gauge's noise (0.1 MPa)",))
    # In its own unit it is what it was.
    assert asked(path, "--gauge", "S1:m/m", *SN, code=0)["high_MPa"] > 29


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "taken", "said"),
    [
        ("S1_Pa", "MPa", "S1_Pa: its name says Pa, and it is taken for MPa"),
        ("S1_um/m", "MPa", "its name says um/m, and it is taken for MPa"),
        ("S1_MPa", "um/m", "its name says MPa, and it is taken for um/m"),
        ("S1_mV/V", "MPa", "its name says mV/V, and it is taken for MPa"),
    ],
)
def test_unit_contradicting_channel_name_is_rejected(tmp_path, name, taken, said):
    path = written(tmp_path, {name: stress()})
    done = run(path, "--gauge", f"{name}:{taken}", *SN)
    assert done.exit_code == 2
    assert said in done.output.replace("\n", " ")
    # Who knows better says so.
    asked(path, "--scale", f"{name}=1:MPa", "--gauge", name, *SN, code=0)


@pytest.mark.slow
def test_unit_is_read_from_channel_name(tmp_path):
    """As the program's own keys do; a name that says none is asked for one."""
    path = written(tmp_path, {"S1_kPa": 1e3 * stress(), "S2": stress(), "v_rpm": 600 + T})
    told = asked(path, "--gauge", "S1_kPa", *SN, "--speed", "v_rpm", code=0)
    assert told["high_MPa"] == pytest.approx(33, abs=2)
    done = run(path, "--gauge", "S2", *SN)
    assert done.exit_code == 2
    assert "S2: no unit; write S2:UNIT" in done.output


def test_equivalent_units_do_not_contradict(tmp_path):
    path = written(tmp_path, {"S1_N/mm2": stress()})
    asked(path, "--gauge", "S1_N/mm2:MPa", *SN, code=0)


def test_unit_contradicting_file_metadata_is_rejected(tmp_path):
    import pyarrow as pa
    import pyarrow.parquet as pq

    field = pa.field("S1", pa.float64(), metadata={"unit": "Pa"})
    table = pa.table([stress() * 1e6], schema=pa.schema([field], metadata={"rate_Hz": "1000"}))
    path = tmp_path / "a.parquet"
    pq.write_table(table, path)
    done = run(path, "--gauge", "S1:MPa", *SN)
    assert done.exit_code == 2
    assert "S1: the file says Pa, and it is taken for MPa" in done.output
    assert asked(path, "--gauge", "S1", *SN, code=0)["high_MPa"] == pytest.approx(33, abs=2)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("option", "name", "unit"),
    [("--speed", "shaft_rpm", "Hz"), ("--torque", "torque_kNm", "Nm"), ("--engine", "n_rpm", "Hz")],
)
def test_unit_contradicting_speed_or_torque_name_is_rejected(tmp_path, option, name, unit):
    path = written(tmp_path, {"S1": stress(), "v": 600 + 0 * T, name: 600 + T})
    more = () if option == "--speed" else ("--speed", "v:rpm")
    done = run(path, "--gauge", "S1:MPa", *SN, *more, option, f"{name}:{unit}")
    assert done.exit_code == 2
    assert f"{name}: its name says" in done.output


def test_implausible_shaft_speed_is_rejected(tmp_path):
    path = written(tmp_path, {"S1": stress(), "v": 1500 + T})
    done = run(path, "--gauge", "S1:MPa", *SN, "--speed", "v:Hz")
    assert done.exit_code == 2
    assert "v: in Hz it turns at 9.18e+04 rpm, faster than any shaft" in done.output


@pytest.mark.parametrize(("name", "unit"), [("strain_front", "MPa"), ("Spannung", "um/m")])
def test_channel_name_of_another_quantity_makes_gauge_doubtful(tmp_path, name, unit):
    path = written(tmp_path, {name: 100 * stress() / 20})
    gauge = asked(path, "--gauge", f"{name}:{unit}", *SN, code=0)
    assert gauge["quality"]["verdict"] == "doubtful"
    (doubt,) = gauge["quality"]["doubts"][:1]
    assert f"in {unit}" in doubt
    assert doubt in run(path, "--gauge", f"{name}:{unit}", *SN).output


def test_channel_named_strain_gauge_is_not_doubtful(tmp_path):
    path = written(tmp_path, {"strain gauge 1": stress()})
    assert asked(path, "--gauge", "strain gauge 1:MPa", *SN, code=0)["quality"]["doubts"] == []


def test_stress_that_would_break_the_part_makes_gauge_doubtful(tmp_path):
    """Microstrain taken for MPa is five times the stress: some thousand times the damage."""
    path = written(tmp_path, {"S1": 20 * stress()})
    (doubt,) = asked(path, "--gauge", "S1:MPa", *SN, code=0)["quality"]["doubts"]
    assert "times what breaks the part" in doubt
    assert asked(path, "--gauge", "S1:um/m", *SN, code=0)["quality"]["doubts"] == []


def test_millisecond_clock_read_as_seconds_is_rejected(tmp_path):
    path = written(tmp_path, {"S1": stress()}, clock="time", time=1e3 * T)
    vetoed(path, "rate", "--gauge", "S1:MPa", *SN, says=("1 samples a second", "--time CLOCK:ms"))
    said = asked(path, "--gauge", "S1:MPa", *SN, "--time", "time:ms", code=0)
    assert said["quality"]["live_s"] == 60
    done = run(path, "--gauge", "S1:MPa", *SN, "--time", "time:weeks")
    assert done.exit_code == 2
    assert "unknown unit of time column 'time'" in done.output


def test_gauge_sampled_at_1_hz_is_rejected(tmp_path):
    path = written(tmp_path, {"S1": stress()[::500]}, time=np.arange(120.0))
    vetoed(path, "rate", "--gauge", "S1:MPa", *SN, says=("1 samples a second", "(50)"))


@pytest.mark.slow
def test_aliased_shaft_order_rejects_the_gauge(tmp_path):
    """At 100 Hz an order 2 of 60 Hz is folded; nothing in the gauge shows it."""
    t = np.arange(12_000) / 100
    other = 0.1 * np.random.default_rng(2).normal(size=t.size)  # not the same to the last digit
    few = {"S1": np.interp(t % 60, T, stress()) + other, "v": 1800 + 0 * t}
    path = written(tmp_path, few, time=t)
    says = ("order 2 reaches 60 Hz", "100 samples a second", "below 40 Hz")
    vetoed(path, "rate", "--gauge", "S1:MPa", *SN, "--speed", "v:rpm", says=says)


@pytest.mark.slow
@pytest.mark.parametrize("hertz", [50.02, 59.97])
def test_damage_is_computed_with_and_without_mains_hum(tmp_path, hertz):
    hum = 12 * np.sin(2 * np.pi * hertz * T + 1)
    path = written(tmp_path, {"S1": stress() / 3 + hum})
    gauge = asked(path, "--gauge", "S1:MPa", *SN)
    assert gauge["quality"]["vetoes"] == ["hum"]
    (suspect,) = gauge["quality"]["suspects"]
    written(tmp_path, {"S1": stress() / 3})
    clean = asked(path, "--gauge", "S1:MPa", *SN, code=0)["damage"]
    # Of what was there within a hertz of the mains hum takes it too: 0.1 % of the road.
    assert suspect["damage_without"] == pytest.approx(clean, rel=0.02)
    assert suspect["damage_recorded"] > 2 * clean
    written(tmp_path, {"S1": stress() / 3 + hum})
    off = asked(path, "--gauge", "S1:MPa", *SN, "--mask", "hum", code=0)
    assert off["damage"] == pytest.approx(suspect["damage_without"], rel=1e-12)
    kept = asked(path, "--gauge", "S1:MPa", *SN, "--accept", "hum", code=0)
    assert kept["damage"] == pytest.approx(suspect["damage_recorded"], rel=1e-12)
    told = run(path, "--gauge", "S1:MPa", *SN).output
    assert f"a steady tone of {round(hertz, -1):.0f} Hz, amplitude 12" in told


@pytest.mark.slow
@pytest.mark.parametrize(
    ("hum", "true"),
    [
        (lambda t: 8 * np.sin(2 * np.pi * 100 * t), "a rectifier's, at twice the mains"),
        (lambda t: 8 * np.sin(2 * np.pi * 50 * t) * (t > 40), "switched on part way"),
        (lambda t: 5 * np.sin(2 * np.pi * 50 * t) + 5 * np.sin(2 * np.pi * 150 * t), "both"),
    ],
    ids=lambda v: v if isinstance(v, str) else "",
)
def test_harmonic_or_intermittent_mains_hum_is_detected(tmp_path, hum, true):
    """Of these 3 to 6 times the damage was told, as good. What is taken off is what was put on."""
    path = written(tmp_path, {"S1": stress() / 3 + hum(T)})
    gauge = asked(path, "--gauge", "S1:MPa", *SN)
    assert gauge["quality"]["vetoes"] == ["hum"], true
    (suspect,) = gauge["quality"]["suspects"]
    written(tmp_path, {"S1": stress() / 3})
    clean = asked(path, "--gauge", "S1:MPa", *SN, code=0)["damage"]
    assert suspect["damage_recorded"] > 2 * clean
    assert suspect["damage_without"] == pytest.approx(clean, rel=0.05)


def test_short_cruise_at_50_hz_is_not_mains_hum():
    """An order holds still for ten seconds, and goes on elsewhere."""
    rng = np.random.default_rng(5)
    t = np.arange(round(90 * RATE)) / RATE
    speed = np.interp(t, [0, 30, 40, 41, 90], [35, 50, 50, 52, 60])
    listener = MainsHumDetector(RATE)
    x = np.sin(2 * np.pi * np.cumsum(speed) / RATE) + 0.1 * rng.normal(size=t.size)
    listener.update(SignalBlock(x, x))
    assert listener.hum(deviation=0.7) is None


@pytest.mark.slow
def test_interpolated_low_rate_samples_are_rejected(tmp_path):
    """25 samples a second laid on 500: a quarter of the damage was told, as good."""
    t = np.arange(0, T[-1], 1 / 25)
    path = written(tmp_path, {"S1": np.interp(T, t, np.interp(t, T, stress()))})
    vetoed(path, "rate", "--gauge", "S1:MPa", *SN, says=("25 samples a second", "fewer than 50"))
    asked(path, "--gauge", "S1:MPa", *SN, "--accept", "rate", code=0)
    # Those of which half are samples are no longer met than they say.
    fine = np.arange(0, T[-1], 2.2 / RATE)
    written(tmp_path, {"S1": np.interp(T, fine, np.interp(fine, T, stress()))})
    asked(path, "--gauge", "S1:MPa", *SN, code=0)


@pytest.mark.slow
def test_intermittent_contact_of_tenths_of_a_second_is_reported(tmp_path):
    """White, so what was faster still is folded in: 70 times the damage, in 2 % of the power."""
    rng, x = np.random.default_rng(4), stress() / 3
    for k in rng.integers(0, x.size - 100, 2):
        x[k : k + 100] += 40 * rng.normal(size=100)
    path = written(tmp_path, {"S1": x})
    told = run(path, "--gauge", "S1:MPa", *SN, "--accept", "spike", "--accept", "dropout").output
    assert "a contact chatters" in told
    written(tmp_path, {"S1": stress() / 3})
    assert "chatters" not in run(path, "--gauge", "S1:MPa", *SN).output


def _tones():
    rng = np.random.default_rng(3)
    t = np.arange(60_000) / RATE
    from scipy.signal import lfilter

    p = np.exp((-0.01 + 1j) * 2 * np.pi * 50 / RATE)
    yield "a mode of 1 %", lfilter([1], [1, -2 * p.real, abs(p) ** 2], rng.normal(size=t.size))
    yield "an order that wanders", np.sin(2 * np.pi * (50 * t + 0.6 * np.sin(0.4 * t)))
    yield "an order that comes and goes", np.sin(0.3 * t) * np.sin(2 * np.pi * 50 * t)
    yield "an engine idling beside", np.sin(2 * np.pi * 50.6 * t)
    yield "a tone a hertz off", np.sin(2 * np.pi * 51.05 * t)
    yield "noise", rng.normal(size=t.size)


@pytest.mark.parametrize(
    ("name", "x"), list(_tones()), ids=lambda v: v if isinstance(v, str) else ""
)
def test_driveline_vibration_is_not_mains_hum(name, x):
    listener = MainsHumDetector(RATE)
    for start in range(0, x.size, 7919):
        piece = x[start : start + 7919]
        listener.update(SignalBlock(piece, piece))
    assert listener.hum(deviation=float(x.std())) is None, name


def test_mains_hum_at_odd_sample_rate_is_tracked():
    t = np.arange(81_920) / 1024.4
    x = 5 * np.cos(2 * np.pi * 60.03 * t + 0.4)
    listener = MainsHumDetector(1024.4)
    listener.update(SignalBlock(x, x))
    found = listener.hum(deviation=float(x.std()))
    assert found.size == pytest.approx(5, rel=0.01)
    inner = slice(2048, -2048)
    assert np.abs(found.waveform(0, x.size) - x)[inner].max() < 0.05


@pytest.mark.slow
@pytest.mark.parametrize("law", ["goodman", "gerber"])
def test_stress_peaks_beyond_strength_are_rejected(tmp_path, law):
    path = written(tmp_path, {"S1": 10 * stress()})
    more = ("--gauge", "S1:MPa", *SN, "--mean-stress", law, "--ultimate-MPa", "300")
    vetoed(path, "strength", *more, says=("crests reach 3", "strength that was given is 300 MPa"))
    done = run(path, "--gauge", "S1:MPa", "--sn", "320,2e6,5", *more[4:])
    assert done.exit_code == 2
    assert "knee, 320 MPa, must lie below the tensile strength" in done.output


def test_repeated_option_is_rejected(tmp_path):
    path = written(tmp_path, {"S1": stress()})
    done = run(path, "--gauge", "S1:MPa", *SN, "--sn", "60,2e6,5")
    assert done.exit_code == 2
    assert "--sn is given 2 times" in done.output


@pytest.mark.slow
def test_mask_of_whole_recording_is_rejected(tmp_path):
    path = written(tmp_path, {"S1": stress(), "S2": 2 * stress()})
    for mask in ("0..1e9", "S2=0..60"):
        done = run(path, "--gauge", "S1:MPa", "--gauge", "S2:MPa", *SN, "--mask", mask)
        assert done.exit_code == 2
        name = "S1" if mask.startswith("0") else "S2"
        assert f"--mask leaves nothing of {name}: 0 s of the 60 s of a.csv" in done.output


def test_constant_gauges_only_give_incomplete_verdict(tmp_path):
    path = written(tmp_path, {"S1": 5 + 0 * T})
    done = run(path, "--gauge", "S1:MPa", *SN, "--json")
    assert (done.exit_code, json.loads(done.output)["verdict"]) == (1, "incomplete")


@pytest.mark.slow
def test_assumed_unit_is_reported_with_alternative_unit(tmp_path):
    """Numbers in µm/m read as MPa look like any stress: five times too large at a steel's E."""
    path = written(tmp_path, {"S1": stress()})
    gauge = asked(path, "--gauge", "S1:MPa", *SN, code=0)
    of = gauge["quality"]["assumed"]
    assert (of["unit"], of["otherwise"]) == ("MPa", "um/m")
    assert of["factor"] == pytest.approx(0.206)
    other = asked(path, "--gauge", "S1:um/m", *SN, code=0)
    # Bins of the count round a stress to half of one: 1e-3 in damage.
    assert of["damage_otherwise"] == pytest.approx(other["damage"], rel=2e-3)
    back = other["quality"]["assumed"]
    assert (back["unit"], back["otherwise"]) == ("um/m", "MPa")
    assert back["damage_otherwise"] == pytest.approx(gauge["damage"], rel=2e-3)
    told = run(path, "--gauge", "S1:MPa", *SN).output
    assert "S1: assumed to be in MPa, as the recording does not say; were it in um/m" in told


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "gauge", "more"),
    [
        ("S1 [MPa]", "S1", ()),
        ("S1_MPa", "S1_MPa:MPa", ()),
        ("S1", "S1", ("--scale", "S1=1:MPa")),
    ],
)
def test_unit_from_file_or_calibration_is_not_assumed(tmp_path, name, gauge, more):
    path = written(tmp_path, {name: stress()})
    assert "assumed" not in asked(path, "--gauge", gauge, *more, *SN, code=0)["quality"]


@pytest.fixture(scope="module")
def innocent():
    """A road's stress at a shaft whose speed and torque come and go: nothing is locked to it."""
    rng = np.random.default_rng(3)
    shaft = 1500 + 300 * np.sin(0.2 * T)
    return {
        "S1": 20 * rng.normal(size=T.size), "rpm": shaft, "eng": 1.5 * shaft,
        "tq": 2000 + 800 * np.sin(0.31 * T),
    }  # fmt: skip


def finding(path, *arguments, speed="rpm", engine="eng", code=0):
    gauge = asked(
        path, "--gauge", "S1:MPa", *SN, "--speed", f"{speed}:rpm", "--engine", f"{engine}:rpm",
        "--engine-orders", "3,6", "--torque", "tq:Nm", *arguments, code=code,
    )  # fmt: skip
    return gauge["finding"], " ".join(gauge.get("doubts", ())), gauge["removed_interval"]


@pytest.mark.slow
def test_implausible_speed_gives_undetermined_finding(tmp_path, innocent):
    """It was innocent from 0 to 0 %, whoever did it, without a doubt."""
    told, _, (_, high) = finding(written(tmp_path, innocent))
    assert told == "joints do not dominate"
    assert high < 0.25
    for speed in (-innocent["rpm"], np.zeros(T.size)):
        told, _, (low, high) = finding(written(tmp_path, {**innocent, "rpm": speed}))
        assert told == "undetermined"
        assert (low, high) == (min(low, 0), 1)
    # Shaft and engine taken for one another.
    told, _, interval = finding(written(tmp_path, innocent), speed="eng", engine="rpm")
    assert told == "joints do not dominate"  # as in an overdrive
    swapped = {**innocent, "eng": 3 * innocent["rpm"]}
    told, _, interval = finding(written(tmp_path, swapped), speed="eng", engine="rpm")
    assert told == "undetermined"
    assert interval[1] == 1


@pytest.mark.slow
def test_missing_or_zero_speed_gives_undetermined_finding(tmp_path, innocent):
    """From a tenth of a second of it the engine carried it on, through gears nobody knows."""
    still = np.full(T.size, innocent["rpm"][0])
    for speed in (
        np.where(T < 0.1, innocent["rpm"], 0),
        np.where(T < 10, innocent["rpm"], 0),
        still,
    ):
        told, _, (low, high) = finding(written(tmp_path, {**innocent, "rpm": speed}))
        assert told == "undetermined"
        assert (low, high) == (min(low, 0), 1)
    # Holes of seconds, gears known from beside them, cost nothing.
    holes = np.where(T % 15 < 3, 0, innocent["rpm"])
    assert finding(written(tmp_path, {**innocent, "rpm": holes}))[0] == "joints do not dominate"


@pytest.mark.slow
def test_damage_during_unknown_speed_gives_undetermined_finding(tmp_path, innocent):
    """A bus silent for a quarter of the drive, its worst: innocent to 3 %, where all was theirs."""
    dark = (T > 25) & (T < 40)
    silent = {**innocent, **{name: np.where(dark, 0, innocent[name]) for name in ("rpm", "eng")}}
    told, _, (_, high) = finding(written(tmp_path, silent))
    assert (told, high) == ("undetermined", pytest.approx(0.3, abs=0.05))  # a quarter of the damage
    rough = {**silent, "S1": silent["S1"] * np.where(dark, 3, 1)}
    told, _, (_, high) = finding(written(tmp_path, rough))
    assert (told, high) == ("undetermined", pytest.approx(1, abs=0.01))
    calm = {**silent, "S1": silent["S1"] * np.where(dark, 0.3, 1)}
    assert finding(written(tmp_path, calm))[0] == "joints do not dominate"
    # Nor while it went back, whose angle is another's.
    back = {**rough, "eng": innocent["eng"], "rpm": np.where(dark, -1, 1) * innocent["rpm"]}
    told, _, (_, high) = finding(written(tmp_path, back))
    assert (told, high) == ("undetermined", pytest.approx(1, abs=0.01))


def test_share_of_time_with_unknown_shaft_speed_is_computed(innocent):
    """Of a tenth of a second now and then the engine's steady speeds made gears between them."""
    speed = innocent["rpm"] / 60
    engine = np.repeat([25.0, 40.0, 31.0], T.size // 3) + 0.05 * np.sin(9 * T)
    now_and_then = shaft_angle(np.where(T % 15 < 0.1, 20.0, 0), rate=RATE, engine=engine)
    assert now_and_then.unknown_speed_share > 0.95
    assert not now_and_then.trusted
    carried = shaft_angle(np.where(T % 15 < 3, 0, speed), rate=RATE, engine=1.5 * speed)
    assert carried.unknown_speed_share == 0
    assert carried.trusted
    # A gap is carried through; what is missing longer than gears last is not.
    long = shaft_angle(np.where(T < 25, speed, np.nan), rate=RATE, engine=1.5 * speed)
    assert long.unknown_speed_share == pytest.approx((T[-1] - 25) / T[-1], abs=0.02)


@pytest.mark.slow
def test_rejected_gauge_gives_undetermined_finding(tmp_path, innocent):
    spoilt = innocent["S1"].copy()
    spoilt[30_000:30_002] = 400
    told, _, interval = finding(written(tmp_path, {**innocent, "S1": spoilt}), code=1)
    assert told == "undetermined"
    assert interval[1] == 1
    path = written(tmp_path, {**innocent, "S1": spoilt})
    assert finding(path, "--mask", "spike")[0] == "joints do not dominate"


@pytest.mark.slow
def test_speed_estimated_from_stress_gives_undetermined_finding(tmp_path, innocent):
    path = written(tmp_path, innocent)
    gauge = asked(path, "--gauge", "S1:MPa", *SN, "--estimate-speed", "S1", code=0)
    assert gauge["finding"] == "undetermined"


def test_sample_rate_contradicting_time_column_is_noted(tmp_path):
    path = written(tmp_path, {"S1": stress()})
    note = "by its time column it is 1000 Hz"
    assert note in run(path, "--gauge", "S1:MPa", *SN, "--rate", "2000").output
    assert note not in run(path, "--gauge", "S1:MPa", *SN, "--rate", "1000").output


def test_unknown_plot_format_is_rejected_before_reading(tmp_path):
    done = run(written(tmp_path, {"S1": stress()}), "--gauge", "S1:MPa", *SN, "--plot", "x.txt")
    assert done.exit_code == 2
    assert "'x.txt'" in done.output


@pytest.mark.slow
def test_distance_is_unknown_if_shaft_never_turns(tmp_path, innocent):
    how = ("--gauge", "S1:MPa", *SN, "--speed", "rpm:rpm", "--axle-ratio", "4",
           "--tyre-radius-m", "0.5")  # fmt: skip

    def driven(speed):
        done = run(written(tmp_path, {**innocent, "rpm": speed}), *how, "--json", "-q")
        return json.loads(done.output)["distance_km"]

    there = driven(innocent["rpm"])
    assert there > 0
    assert driven(np.zeros(T.size)) is None
    # With its sign the other way round, of which a note tells, it drove as far.
    assert driven(-innocent["rpm"]) == pytest.approx(there)


@pytest.mark.parametrize(
    ("value", "place"),
    [(1e300, "at sample 5001"), (-1e31, "at sample 5001"), (np.inf, "a.csv:5002: column 'S1'")],
)
def test_implausible_sample_is_rejected_with_position(tmp_path, value, place):
    x = stress()
    x[5000] = value
    done = run(written(tmp_path, {"S1": x}), "--gauge", "S1:MPa", *SN)
    assert done.exit_code == 2, done.output
    assert place in done.output
    assert f"{value:g}" in done.output


@pytest.mark.slow
@pytest.mark.parametrize(
    ("language", "said"),
    [
        ("en", 'where joints dominate, 0 were found "joints do not dominate" (0.8 % at most)'),
        ("pt", 'de 489 extensômetros em que as juntas dominam, 0 deram "juntas não dominam"'),
        ("it", 'di 489 estensimetri dove i giunti dominano, 0 hanno dato "i giunti non dominano"'),
    ],
)
def test_finding_reports_its_error_rate(tmp_path, innocent, language, said):
    """An acquittal at its word would be taken for a certainty."""
    out = tmp_path / "a.json"
    done = CliRunner().invoke(
        command,
        [str(written(tmp_path, innocent)), "--gauge", "S1:MPa", *SN, "--speed", "rpm:rpm",
         "--engine", "eng:rpm", "--engine-orders", "3,6", "--torque", "tq:Nm",
         "--json", str(out), "--lang", language, "--all"],
    )  # fmt: skip
    assert done.exit_code == 0, done.output
    assert said in " ".join(done.output.split())
    (gauge,) = json.loads(out.read_text())["gauges"]
    found = gauge["finding_wrong"]
    # Clopper and Pearson: none of 489, thirteen of 804.
    assert (found["wrong"], found["cases"]) == (0, 489)
    assert found["at_most"] == pytest.approx(1 - 0.025 ** (1 / 489))
    assert found["on_a_stop"]["at_most"] == pytest.approx(0.0275, abs=5e-5)


@pytest.mark.slow
def test_undetermined_finding_has_no_error_rate(tmp_path, innocent):
    path = written(tmp_path, innocent)
    gauge = asked(path, "--gauge", "S1:MPa", *SN, "--estimate-speed", "S1", code=0)
    assert gauge["finding_wrong"] is None
