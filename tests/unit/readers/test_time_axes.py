"""Channels lie where their file says that they begin, and nothing that is no time is taken for it.

Each kind in every container that can state it; the files are written here with the containers' own
libraries.
"""

import struct
import tempfile
import wave
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

from cardan.cli.life import life
from cardan.core.errors import DesignError, InvalidFileError
from cardan.physics.signals.recording import Channel
from cardan.readers.dispatch import open_recording
from cardan.readers.time_units import instant, seconds_per_time_unit
from cardan.topics.recording.channel_reading import check_unit_agrees

pytest.importorskip("pyarrow.csv")

RATE, N = 1000.0, 2000
T = np.arange(N) / RATE
X = 100 * np.sin(2 * np.pi * 20 * T)
T0 = np.datetime64("2026-01-01T00:00:00", "us")


def refused(path, match, **how):
    with pytest.raises(InvalidFileError, match=match):
        open_recording(path, **how).read_all()


def ms(count):
    return np.timedelta64(count, "ms")


def check_half_a_second_apart(recording):
    first, second = recording.read_all(["S1", "S2"])
    assert np.flatnonzero(~np.isnan(second))[0] - np.flatnonzero(~np.isnan(first))[0] == 500
    np.testing.assert_allclose(first[~np.isnan(first)], X, atol=1e-9)
    np.testing.assert_allclose(second[~np.isnan(second)], X, atol=1e-9)
    assert any("S2: known from 0.5 to 2.5 s" in n for n in recording.notes)


# --------------------------------------------------------------------------- TDMS


def tdms(path, *channels, groups=()):
    nptdms = pytest.importorskip("nptdms")
    objects = [nptdms.GroupObject(name, properties) for name, properties in groups]
    objects += [nptdms.ChannelObject(g, c, x, properties) for g, c, x, properties in channels]
    with nptdms.TdmsWriter(path) as writer:
        writer.write_segment(objects)
    return path


def waveform(start=T0, step=1 / RATE, offset=0.0, **more):
    return {
        "wf_start_time": start, "wf_start_offset": offset, "wf_increment": step,
        "unit_string": "MPa", **more,
    }  # fmt: skip


@pytest.mark.parametrize("later", [{"start": T0 + ms(500)}, {"offset": 0.5}])
def test_late_tdms_channel_is_aligned(tmp_path, later):
    path = tdms(tmp_path / "a.tdms", ("g", "S1", X, waveform()), ("g", "S2", X, waveform(**later)))
    check_half_a_second_apart(open_recording(path))


def test_late_tdms_group_is_aligned(tmp_path):
    groups = [("a", {"wf_start_time": T0}), ("b", {"wf_start_time": T0 + ms(500)})]
    step = {"wf_increment": 1 / RATE}
    path = tdms(tmp_path / "a.tdms", ("a", "S1", X, step), ("b", "S2", X, step), groups=groups)
    check_half_a_second_apart(open_recording(path))


def test_slow_tdms_bus_that_begins_late_is_unknown_before(tmp_path):
    slow = np.arange(0, 1, 0.01)
    path = tdms(
        tmp_path / "a.tdms", ("g", "S1", X, waveform()),
        ("bus", "n", 600 + 60 * slow, waveform(T0 + ms(500), 0.01)),
    )  # fmt: skip
    n = open_recording(path).read_all(["n"])[0]
    assert np.isnan(n[T < 0.4999]).all()
    assert np.isnan(n[T > 1.4901]).all()
    inside = (T > 0.5) & (T < 1.49)
    np.testing.assert_allclose(n[inside], 600 + 60 * (T[inside] - 0.5), rtol=1e-9)


def test_tdms_group_of_another_day_is_left_out_with_note(tmp_path):
    later = T0 + np.timedelta64(1, "D")
    path = tdms(tmp_path / "a.tdms", ("g", "S1", X, waveform()), ("h", "S2", X, waveform(later)))
    recording = open_recording(path)
    assert (recording.names, recording.samples) == (("S1",), N)
    assert any(
        "h: left out, it was recorded at another time, 86400 s" in n for n in recording.notes
    )


@pytest.mark.parametrize(("unit", "step"), [("ms", 1.0), ("s", 1e-3), ("", 1e-3), ("us", 1000.0)])
def test_tdms_step_is_in_unit_of_its_axis(tmp_path, unit, step):
    path = tdms(tmp_path / "a.tdms", ("g", "S1", X, waveform(step=step, wf_xunit_string=unit)))
    assert open_recording(path).rate == RATE


@pytest.mark.parametrize("axis", [{"wf_xunit_string": "Hz"}, {"wf_xname": "Frequency"}])
def test_tdms_axis_that_is_no_time_is_rejected(tmp_path, axis):
    path = tdms(tmp_path / "a.tdms", ("g", "S1", X, waveform(**axis)))
    refused(path, "the axis of its samples is no time: .*(Hz|Frequency)")
    assert open_recording(path, rate=50.0).rate == 50
    path = tdms(tmp_path / "b.tdms", ("g", "S1", X, waveform()), ("h", "P", X, waveform(**axis)))
    assert open_recording(path).names == ("S1",)


def test_tdms_channel_of_instants_is_clock(tmp_path):
    stamps = T0 + (np.arange(N) * 1000).astype("timedelta64[us]")
    path = tdms(tmp_path / "a.tdms", ("g", "Wann", stamps, {}), ("g", "S1", X, {}))
    recording = open_recording(path)
    assert (recording.names, recording.rate) == (("S1",), RATE)
    np.testing.assert_array_equal(recording.read_all(), [X])


def test_tdms_segments_of_two_steps_are_rejected(tmp_path):
    nptdms = pytest.importorskip("nptdms")
    with nptdms.TdmsWriter(tmp_path / "a.tdms") as writer:
        for step in (0.001, 0.002):
            writer.write_segment([nptdms.ChannelObject("g", "S1", X, waveform(step=step))])
    refused(tmp_path / "a.tdms", "changes its step between segments .*0.001, then 0.002")


def test_tdms_start_stated_anew_is_noted(tmp_path):
    nptdms = pytest.importorskip("nptdms")
    with nptdms.TdmsWriter(tmp_path / "a.tdms") as writer:
        for start in (T0, T0 + ms(9000)):
            writer.write_segment([nptdms.ChannelObject("g", "S1", X, waveform(start))])
    assert any(
        "begun anew in a later segment" in n for n in open_recording(tmp_path / "a.tdms").notes
    )


@pytest.mark.parametrize(("step", "why"), [("0.001", ""), ("0,001", ""), ("fast", "not a number")])
def test_tdms_step_written_as_text_is_a_number_or_rejected(tmp_path, step, why):
    path = tdms(tmp_path / "a.tdms", ("g", "S1", X, {"wf_increment": step}))
    if why:
        refused(path, f"wf_increment is {why} .*fast")
    else:
        assert open_recording(path).rate == RATE


# --------------------------------------------------------------------------- MDF


def mdf(path, *groups, **how):
    asammdf = pytest.importorskip("asammdf")
    file = asammdf.MDF(version="4.10")
    for name, t, channels in groups:
        signals = [asammdf.Signal(x, t, name=c, unit="MPa", **how) for c, x in channels.items()]
        file.append(signals, acq_name=name)
    file.save(path, overwrite=True)
    file.close()
    return path


def test_late_mdf_group_is_aligned(tmp_path):
    path = mdf(tmp_path / "a.mf4", ("a", T, {"S1": X}), ("b", T + 0.5, {"S2": X}))
    check_half_a_second_apart(open_recording(path))


@pytest.mark.parametrize(("kind", "name"), [(2, "angle"), (3, "distance"), (4, "index")])
def test_mdf_master_that_is_no_time_is_rejected(tmp_path, kind, name):
    path = mdf(tmp_path / "a.mf4", ("g", T * 314, {"S1": X}), master_metadata=("m", kind))
    refused(path, f"the axis of its samples is no time: {name}")
    recording = open_recording(path, rate=500.0)
    assert (recording.names, recording.rate) == (("m", "S1"), 500)


@pytest.mark.parametrize("rows", [1, 2])
def test_mdf_log_of_few_rows_does_not_decide_over_file(tmp_path, rows):
    log = ("log", np.linspace(0, T[-1], rows), {"page": np.zeros(rows, "u1")})
    path = mdf(tmp_path / "a.mf4", ("gauges", T, {"S1": X}), log)
    recording = open_recording(path)
    assert (recording.names, recording.rate) == (("S1",), RATE)
    np.testing.assert_array_equal(recording.read_all(), [X])
    assert any(n.startswith("log: left out") for n in recording.notes)
    assert open_recording(path, rate=500.0).names == ("S1",)


def test_gear_written_on_change_holds_between(tmp_path):
    at, gears = np.array([0.1, 0.3, 0.4, 1.2, 1.9]), np.array([1, 2, 3, 4, 3], "u1")
    path = mdf(tmp_path / "a.mf4", ("gauges", T, {"S1": X}), ("can", at, {"gear": gears}))
    recording = open_recording(path)
    gear = recording.read_all(["gear"])[0]
    assert set(gear[~np.isnan(gear)]) == {1, 2, 3, 4}
    assert gear[1000] == 3
    assert np.isnan(gear[:99]).all()


def test_mdf_claiming_fewer_records_than_its_data_is_rejected(tmp_path):
    data = bytearray(mdf(tmp_path / "a.mf4", ("g", T, {"S1": X})).read_bytes())
    at = data.index(b"##CG")
    (links,) = struct.unpack_from("<Q", data, at + 16)
    struct.pack_into("<Q", data, at + 24 + 8 * links + 8, N // 2)
    (tmp_path / "a.mf4").write_bytes(data)
    refused(tmp_path / "a.mf4", "claims 1000 records of 16 bytes, and its data hold 2000")


def test_unfinished_mdf_leaves_no_copy(tmp_path, monkeypatch):
    data = bytearray(mdf(tmp_path / "a.mf4", ("g", T, {"S1": X})).read_bytes())
    data[:8] = b"UnFinMF "
    struct.pack_into("<H", data, 60, 1)
    (tmp_path / "a.mf4").write_bytes(data)
    (tmp_path / "here").mkdir()
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path / "here"))
    recording = open_recording(tmp_path / "a.mf4")
    np.testing.assert_array_equal(recording.read_all(), [X])
    assert not any(p.name.endswith("_a.mf4") for p in (tmp_path / "here").iterdir())


# --------------------------------------------------------------------------- HDF5


def hdf5(path, sets, **attributes):
    h5py = pytest.importorskip("h5py")
    with h5py.File(path, "w") as file:
        for name, (x, own) in sets.items():
            file.create_dataset(name, data=x).attrs.update(own)
        file.attrs.update(attributes)
    return path


@pytest.mark.parametrize("start", [(0.0, 0.5), ("2026-01-01T00:00:00", "2026-01-01 00:00:00.5")])
def test_late_hdf5_channel_is_aligned(tmp_path, start):
    sets = {f"S{k + 1}": (X, {"start_time": s}) for k, s in enumerate(start)}
    check_half_a_second_apart(open_recording(hdf5(tmp_path / "a.h5", sets, rate_Hz=RATE)))


@pytest.mark.parametrize(
    ("unit", "second"),
    [("seconds", 1), ("milliseconds", 1e-3), ("microseconds since 2026-01-01", 1e-6),
     ("milliseconds since 2026-01-01T00:00:00.000000", 1e-3), ("minutes", 60), ("ms", 1e-3)],
)  # fmt: skip
def test_udunits_times_of_hdf5_are_read(tmp_path, unit, second):
    sets = {"time": (T / second, {"units": unit}), "S1": (X, {"units": "MPa"})}
    recording = open_recording(hdf5(tmp_path / "a.nc", sets))
    assert (recording.rate, recording.names) == (RATE, ("S1",))


def test_hdf5_clocks_since_two_instants_are_aligned(tmp_path):
    h5py = pytest.importorskip("h5py")
    with h5py.File(tmp_path / "a.h5", "w") as file:
        for group, name, since in (("a", "S1", "00:00:00"), ("b", "S2", "00:00:00.5")):
            own = file.create_group(group)
            own["time"], own[name] = T, X
            own["time"].attrs["units"] = f"seconds since 2026-01-01 {since}"
        file["c"] = np.arange(10.0)  # without it both groups are of one length, and one table
    check_half_a_second_apart(open_recording(tmp_path / "a.h5"))


def test_unsigned_and_out_of_range_values_of_hdf5_follow_cf(tmp_path):
    byte = (100 + X / 2).astype("u1")
    sets = {
        "S1": (byte.view("i1"), {"_Unsigned": "true"}),
        "S2": (np.arange(N, dtype="i2"), {"valid_range": np.array([10, 1000], "i2"),
                                          "scale_factor": 2.0}),
        "S3": (byte.view("i1"), {"_Unsigned": "true", "_FillValue": np.int8(-106)}),
    }  # fmt: skip
    x = open_recording(hdf5(tmp_path / "a.h5", sets, rate_Hz=RATE)).read_all()
    np.testing.assert_array_equal(x[0], byte)
    np.testing.assert_array_equal(np.isnan(x[1]), (np.arange(N) < 10) | (np.arange(N) > 1000))
    assert x[1, 20] == 40
    np.testing.assert_array_equal(np.isnan(x[2]), byte == 150)


@pytest.mark.parametrize("shape", [(1, N), (N, 1), (N,)])
def test_hdf5_of_matlab_is_read(tmp_path, shape):
    sets = {"S1": (X.reshape(shape), {}), "fs": (np.array([[RATE]]), {})}
    recording = open_recording(hdf5(tmp_path / "a.hdf", sets))
    assert (recording.rate, recording.names) == (RATE, ("S1",))
    np.testing.assert_array_equal(recording.read_all(), [X])


def test_hdf5_rate_of_two_values_is_rejected(tmp_path):
    path = hdf5(tmp_path / "a.h5", {"S1": (X, {})}, rate_Hz=np.array([1000.0, 500.0]))
    refused(path, "rate_Hz is more than one number .*500.0, 1000.0")


def test_seconds_labelled_milliseconds_are_rejected(tmp_path):
    sets = {"time": (T, {"units": "ms"}), "S1": (X, {})}
    refused(hdf5(tmp_path / "a.h5", sets), "too fast for one in ms .*1e.06 Hz, and 1000 Hz in sec")
    assert open_recording(tmp_path / "a.h5", time="time:s").rate == RATE
    sets = {"time": (T / 2, {"units": "s"}), "S1": (X, {})}
    refused(hdf5(tmp_path / "b.h5", sets, rate_Hz=RATE), "contradict .*2000 Hz .*stated 1000 Hz")


# --------------------------------------------------------------------------- WAV


def wav(path, *parts, align=4, rate=1000):
    body = struct.pack("<4sIHHIIHH", b"fmt ", 16, 1, 2, rate, rate * align, align, 16)
    for part in parts:
        raw = np.asarray(part, "<i2").tobytes()
        body += struct.pack("<4sI", b"data", len(raw)) + raw
        body += struct.pack("<4sI4s", b"LIST", 4, b"INFO")
    path.write_bytes(struct.pack("<4sI4s", b"RIFF", 4 + len(body), b"WAVE") + body)
    return path


def test_every_data_part_of_wav_is_read(tmp_path):
    parts = np.arange(400).reshape(2, 100, 2)
    recording = open_recording(wav(tmp_path / "a.wav", *parts))
    expected = np.arange(400).reshape(-1, 2).T / 2.0**15
    np.testing.assert_array_equal(recording.read_all(), expected)
    assert any("2 parts of data" in n for n in recording.notes)


def test_wav_of_other_block_alignment_or_rate_is_rejected(tmp_path):
    refused(wav(tmp_path / "a.wav", X, align=6), "6 bytes for 2 channels of 16 bits")
    data = bytearray(wav(tmp_path / "b.wav", X).read_bytes())
    struct.pack_into("<I", data, 24, 2**32 - 1)
    (tmp_path / "b.wav").write_bytes(data)
    refused(tmp_path / "b.wav", "no recording has such a sample rate .*4.29497e.09 Hz")


# --------------------------------------------------------------------------- clocks of tables


def table(path, names, *columns, point=6, head=""):
    rows = ("," .join(v if isinstance(v, str) else f"{v:.{point}f}" for v in row)
            for row in zip(*columns, strict=True))  # fmt: skip
    path.write_text(head + names + "\n" + "\n".join(rows) + "\n")
    return path


@pytest.mark.parametrize(
    "name",
    ["timestamps", "t_rel", "Time_abs", "time_axis", "test_time", "testTime", "Zeit_Messung",
     "X_Value", "elapsed", "Time (s)", "t_s"],
)  # fmt: skip
def test_column_that_says_time_and_rises_evenly_is_clock(tmp_path, name):
    recording = open_recording(table(tmp_path / "a.csv", f"{name},S1", T, X))
    assert (recording.rate, recording.names) == (RATE, ("S1",))
    assert open_recording(tmp_path / "a.csv", time=open_name(tmp_path / "a.csv")).rate == RATE


def open_name(path):
    """Return the clock's name as the file shows it: its unit stands apart."""
    return path.read_text().split(",")[0].removesuffix(" (s)")


def test_name_of_clock_is_not_cut_apart(tmp_path):
    path = table(tmp_path / "a.csv", "timestamps,time_hold,S1", T, X, X)
    assert open_recording(path).names == ("time_hold", "S1")
    assert open_recording(path, time="timestamps").rate == RATE
    refused(path, "stands still or runs backwards|not even", time="time_hold")


@pytest.mark.parametrize("count", [1.0, 1e3, 1e6])
@pytest.mark.parametrize("rate", [800.0, 1000.0])
def test_counts_since_1970_are_a_clock_by_their_size(tmp_path, count, rate):
    at = np.rint((1.7092872e9 + np.arange(N) / rate) * max(count, 1e3)) / max(count, 1e3) * count
    recording = open_recording(table(tmp_path / "a.csv", "timestamp,S1", at, X, point=3))
    assert (recording.rate, recording.names) == (rate, ("S1",))
    assert recording.read_all().shape == (1, N)


@pytest.mark.parametrize("rate", [600.0, 800.0, 1200.0, 3000.0])
@pytest.mark.parametrize("hole", [0, 700])
def test_stamps_of_few_digits_are_counted(tmp_path, rate, hole):
    """Whole milliseconds: they say when a sample was taken to a digit, and how fast exactly."""
    k = np.arange(N)
    k = k + np.where(k >= 1000, hole, 0)
    recording = open_recording(
        table(tmp_path / "a.csv", "Time_s,S1", np.round(k / rate, 3), X, point=3)
    )
    assert recording.rate == rate
    assert any("each sample within 0.0005 s" in n for n in recording.notes)
    x = recording.read_all()[0]
    assert abs(x.size - N - hole) <= 2
    assert abs(np.isnan(x).sum() - hole) <= 2
    np.testing.assert_allclose(x[:1000], X[:1000], atol=1e-3)
    np.testing.assert_allclose(x[-900:], X[-900:], atol=1e-3)


def test_uneven_times_are_rejected(tmp_path):
    at = np.cumsum(np.tile([0.01, 0.05], 21))
    refused(table(tmp_path / "a.csv", "Time_s,S1", at, at), "time is not even")


def test_rows_of_two_clocks_in_one_column_are_taken_apart(tmp_path):
    """pandas joins tables by their times: the cells of the other are empty."""
    slow = np.arange(0.0003, T[-1], 0.1)
    rows = sorted([(t, f"{x:.6f}", "") for t, x in zip(T, X, strict=True)]
                  + [(t, "", f"{600 + 10 * t:.6f}") for t in slow])  # fmt: skip
    recording = open_recording(
        table(tmp_path / "a.csv", "timestamps,S1,n", *zip(*rows, strict=True))
    )
    assert recording.rate == RATE
    x, n = recording.read_all(["S1", "n"])
    np.testing.assert_allclose(x, X, atol=1e-6)
    known = ~np.isnan(n)
    np.testing.assert_allclose(n[known], 600 + 10 * T[known], atol=1e-5)
    assert known.mean() > 0.94


def test_two_clocks_of_different_rates_are_rejected(tmp_path):
    path = table(tmp_path / "a.csv", "time_car,time_rig,S1", T, 2 * T, X)
    refused(path, "several clocks .*time_car 1000 Hz, time_rig 500 Hz")
    assert open_recording(path, time="time_car").rate == RATE


@pytest.mark.parametrize("rate", [0.0, -5.0, 1e12, 4294967295.0, 1e-9])
def test_implausible_rate_is_rejected_with_number(tmp_path, rate):
    import pyarrow as pa
    import pyarrow.parquet as pq

    written = pa.table({"S1": X}).replace_schema_metadata({"rate_Hz": str(rate)})
    pq.write_table(written, tmp_path / "a.parquet")
    refused(tmp_path / "a.parquet", "sample rate")
    refused(tmp_path / "a.parquet", "sample rate", rate=rate)
    assert open_recording(tmp_path / "a.parquet", rate=500.0).rate == 500


def test_parquet_without_rows_is_rejected_as_such(tmp_path):
    import pyarrow as pa
    import pyarrow.parquet as pq

    pq.write_table(pa.table({"S1": pa.array([], pa.float64())}), tmp_path / "a.parquet")
    refused(tmp_path / "a.parquet", "it holds no rows .*1 columns of 0 rows")


# --------------------------------------------------------------------------- heads of tables


def lvm(point, columns):
    def shown(v):
        return f"{v:.6f}".replace(".", point)

    text = (
        f"LabVIEW Measurement\t\nWriter_Version\t2\nSeparator\tTab\nDecimal_Separator\t{point}\n"
        f"Multi_Headings\tNo\nX_Columns\t{columns}\nTime_Pref\tAbsolute\n***End_of_Header***\t\n\t\n"
        "Channels\t2\t\t\nSamples\t2000\t2000\t\nY_Unit_Label\tMPa\tum/m\t\n"
        f"X_Dimension\tTime\tTime\t\nX0\t0{point}0E+0\t0{point}0E+0\t\n"
        f"Delta_X\t1{point}0E-3\t1{point}0E-3\t\n***End_of_Header***\t\t\t\n"
        "X_Value\tS1\tS2\tComment\n"
    )
    first = [shown(t) if columns == "One" else "" for t in T]
    rows = (f"{t}\t{shown(x)}\t{shown(-x)}" for t, x in zip(first, X, strict=True))
    return text + "\n".join(rows) + "\n"


@pytest.mark.parametrize("columns", ["One", "No"])
@pytest.mark.parametrize("point", [".", ","])
@pytest.mark.parametrize("name", ["a.lvm", "a.txt", "a.dat"])
def test_labview_text_is_read(tmp_path, name, point, columns):
    (tmp_path / name).write_text(lvm(point, columns))
    recording = open_recording(tmp_path / name)
    assert recording.rate == RATE
    assert recording.channels == (Channel("S1", "MPa"), Channel("S2", "um/m"))
    np.testing.assert_allclose(recording.read_all(), [X, -X], atol=1e-6)


@pytest.mark.parametrize("empty", [False, True])
def test_header_with_one_name_more_keeps_its_names(tmp_path, empty):
    first = ["" if empty else f"{t:.4f}" for t in T]
    rows = (f"{t}\t{x:.6f}\t{-x:.6f}" for t, x in zip(first, X, strict=True))
    (tmp_path / "a.txt").write_text("X_Value\tS1\tS2\tComment\n" + "\n".join(rows))
    recording = open_recording(tmp_path / "a.txt", rate=RATE if empty else None)
    assert (recording.rate, recording.names) == (RATE, ("S1", "S2"))
    np.testing.assert_allclose(recording.read_all(), [X, -X], atol=1e-6)


def test_rows_of_labels_above_the_numbers_are_names_and_units(tmp_path):
    head = '"TIME", "15:26:55"\n"NUM_SIGS", 3\n"INTERVAL", 1.0E-03\n"VERT_UNITS", "S", "MPa", "V"\n'
    rows = (f"{t:.4E}, {x:+.5E}, {-x:+.5E}" for t, x in zip(T, X, strict=True))
    text = head + '"SIGNAL", "TIME", "ACH1", "ACH2"\n"DATA"\n' + "\n".join(rows)
    (tmp_path / "a.csv").write_text(text)
    recording = open_recording(tmp_path / "a.csv")
    assert recording.rate == RATE
    assert recording.channels == (Channel("ACH1", "MPa"), Channel("ACH2", "V"))


def test_clock_of_two_hundred_rows_that_jitters_is_read(tmp_path):
    """Neither half has the rows by which a change of rate is told: it ended in an IndexError."""
    t = np.arange(200) / 50
    t[50:150] += 0.004
    path = table(tmp_path / "a.csv", "time,S1", [f"{v:.4f}" for v in t], X[:200])
    np.testing.assert_allclose(open_recording(path).read_all()[0], X[:200], atol=1e-6)


@pytest.mark.parametrize("index", ["2026-01-01 00:00:{:06.3f}", "0 days 00:00:{:09.6f}"])
def test_index_of_times_without_name_is_clock(tmp_path, index):
    path = table(tmp_path / "a.csv", ",S1", [index.format(t) for t in T], X)
    recording = open_recording(path)
    assert (recording.rate, recording.names) == (RATE, ("S1",))


# --------------------------------------------------------------------------- units


@pytest.mark.parametrize("unit", ["kN", "g", "degC", "bar", "mm", "m/s2", "lbf", "dB", "furlong"])
def test_unit_of_file_contradicts_the_one_it_is_taken_for(tmp_path, unit):
    path = table(tmp_path / "a.csv", f"time [s],S1 [{unit}]", T, X)
    channel = open_recording(path).channel("S1")
    with pytest.raises(DesignError, match=f"the file says {unit}, and it is taken for MPa"):
        check_unit_agrees(channel, "MPa")


@pytest.mark.parametrize(
    ("unit", "usual"),
    [("N/mm^2", "N/mm2"), ("MPA", "MPa"), ("mPa", "mPa"), ("RPM", "rpm"), ("-", ""), ("n/a", ""),
     ("µm/m", "µm/m"), ("uStrain", "ustrain")],
)  # fmt: skip
def test_spellings_of_a_unit_are_one_unit(tmp_path, unit, usual):
    path = table(tmp_path / "a.csv", f"time [s],S1 [{unit}]", T, X)
    channel = open_recording(path).channel("S1")
    assert channel.unit == usual
    if usual in ("", "MPa", "N/mm2"):
        check_unit_agrees(channel, "MPa")


def test_names_of_time_units():
    assert seconds_per_time_unit("Milliseconds") == 1e-3
    assert seconds_per_time_unit("days since 1970-01-01") == 86400
    assert seconds_per_time_unit("stamps") is None
    assert instant("2026-1-2 3:04:05.25 UTC") == instant("2026-01-02T04:04:05.25+01:00")
    assert instant("yesterday") is None


# --------------------------------------------------------------------------- short series


def test_nine_points_of_astm_e1049_are_counted(tmp_path):
    """ASTM E1049-85, 5.4.4: ranges 3, 4, 6, 8, 9 with 0.5, 1.5, 0.5, 1 and 0.5 cycles."""
    points = [-2.0, 1.0, -3.0, 5.0, -1.0, 3.0, -4.0, 4.0, -2.0]
    path = table(tmp_path / "a.csv", "time,S1", T[:9], points)
    done = CliRunner().invoke(life, [str(path), "--gauge", "S1:MPa", "--sn", "30,2e6,5", "--all"])
    assert done.exit_code == 0, done.output
    row = next(line for line in done.output.splitlines() if line.startswith("S1 ")).split()
    counted = {3: 0.5, 4: 1.5, 6: 0.5, 8: 1.0, 9: 0.5}
    # Below the knee the slope is 2 * 5 - 1 (modified Miner after Haibach).
    damage = sum(n * (r / 2 / 30) ** 9 / 2e6 for r, n in counted.items())
    assert float(row[3]) == pytest.approx(damage, rel=5e-4)


# --------------------------------------------------------------------------- content


@pytest.mark.parametrize("name", ["a.dat", "a", "a.csv", "a.mf4"])
def test_content_chooses_the_reader(tmp_path, name):
    path = hdf5(tmp_path / name, {"S1": (X, {})}, rate_Hz=RATE)
    np.testing.assert_array_equal(open_recording(path).read_all(), [X])
    tdms(path, ("g", "S1", X, waveform()))
    np.testing.assert_array_equal(open_recording(path).read_all(), [X])
    with wave.open(str(path), "wb") as file:
        file.setparams((1, 2, 1000, 0, "NONE", ""))
        file.writeframes(np.arange(100, dtype="<i2").tobytes())
    assert open_recording(path).rate == RATE
    assert open_recording(table(path, "time,S1", T, X)).rate == RATE


FOREIGN = {
    "DIAdem TDM": b'<?xml version="1.0"?>\n<usi:tdm version="1.0" xmlns:usi="http://www.ni.com/">\n',
    "Somat SIE": b'<?xml version="1.0"?>\n<sie version="1.0" xmlns="http://www.somat.com/SIE">\n',
    "catman BIN": struct.pack("<hi", 5012, 512) + bytes(2000),
    "nCode DAC": struct.pack("<2f", 256.0, 500.0) + bytes(504) + bytes(1024),
}


@pytest.mark.parametrize("system", FOREIGN)
def test_file_of_another_system_is_told_by_name(tmp_path, system):
    (tmp_path / "a.dat").write_bytes(FOREIGN[system])
    refused(tmp_path / "a.dat", f"{system}.*which is not read; \\w+")


@pytest.mark.parametrize("ending", ["", ".sie", ".dxd", ".rsp"])
def test_wide_text_is_read_whatever_its_ending(tmp_path, ending):
    """UTF-16 was a Somat SIE by the ending .sie, and of no reader without one."""
    text = "time;S1\n" + "\n".join(f"{t:.3f};{x:.6f}" for t, x in zip(T, X, strict=True))
    (tmp_path / f"a{ending}").write_text(text, encoding="utf-16")
    assert open_recording(tmp_path / f"a{ending}").names == ("S1",)


@pytest.mark.parametrize(
    ("ending", "system"),
    [("s3t", "nCode S3T"), ("ldsf", "Testlab"), ("dxd", "DEWESoft"), ("d7d", "DEWESoft")],
)
def test_unpublished_format_is_told_by_its_ending(tmp_path, ending, system):
    path = Path(tmp_path / f"a.{ending}")
    path.write_bytes(bytes(range(256)) * 9)
    refused(path, f"{system}.*which is not read; export it")
