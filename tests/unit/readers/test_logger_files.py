"""Files as loggers write them, and files that were made to hurt."""

import json
import struct
from io import BytesIO
from types import SimpleNamespace

import numpy as np
import pytest
from click.testing import CliRunner
from compression_bombs import dictionary_bomb, thrift

from cardan.cli.life import life as command
from cardan.core.errors import InvalidFileError
from cardan.readers.base import max_page_bytes
from cardan.readers.dispatch import open_recording
from cardan.readers.parquet_validation import page_sizes

pytest.importorskip("pyarrow")

RATE = 500.0
N = 1500
T = np.arange(N) / RATE
S1, S2 = np.round(40 * np.sin(T * 40), 4), np.round(np.cos(T * 25) * 3, 4)
SLOW = np.arange(0, N, 50) / RATE
"""Ten times a second."""


def write(path, text):
    path.write_text(text, encoding="utf-8")
    return path


def refused(path, match, **how):
    with pytest.raises(InvalidFileError, match=match):
        open_recording(path, **how).read_all()


def rows(*columns, sep=","):
    return "".join(sep.join(row) + "\n" for row in zip(*columns, strict=True))


def shown(x):
    return [f"{v:.6f}" for v in x]


# --------------------------------------------------------------------------- tables of text


def stamps(date="2026-11-20 "):
    return [
        f"{date}23:59:{58 + s:06.3f}" if s < 2 else f"{date[:8]}21 00:00:{s - 2:06.3f}" for s in T
    ]


def test_text_column_is_omitted_with_note(tmp_path):
    gears = [f"G{k // 500}" for k in range(N)]
    text = "time,S1,gear,S2\n" + rows(shown(T), shown(S1), gears, shown(S2))
    recording = open_recording(write(tmp_path / "a.csv", text))
    assert (recording.names, recording.rate) == (("S1", "S2"), RATE)
    assert recording.notes == ("not numbers, left out: gear",)
    np.testing.assert_allclose(recording.read_all(), [S1, S2], atol=1e-9)


def test_date_and_time_columns_are_read_as_clock(tmp_path):
    """Over midnight, too; whatever the column is called."""
    text = "when,S1,S2\n" + rows(stamps(), shown(S1), shown(S2))
    recording = open_recording(write(tmp_path / "a.csv", text))
    assert (recording.names, recording.rate) == (("S1", "S2"), pytest.approx(RATE))
    np.testing.assert_allclose(recording.read_all(), [S1, S2], atol=1e-9)
    clock, signal = (
        [text.replace(".", ",") for text in column[:900]] for column in (stamps(""), shown(S1))
    )
    german = "Zeit;S1\n" + rows(clock, signal, sep=";")
    found = open_recording(write(tmp_path / "b.csv", german))
    assert found.rate == pytest.approx(RATE)
    np.testing.assert_allclose(found.read_all(), [S1[:900]], atol=1e-9)


@pytest.mark.parametrize(
    "head",
    [
        "time,S1,S2\ns,MPa,um/m\n",
        "time,S1,S2\ns,MPa,um/m\nclock,left bracket,right bracket\n",
        "time,S1,S2\nclock,left bracket,right bracket\ns,MPa,um/m\n",
        "logger 7\n\ntime,S1,S2\n[s],[MPa],[um/m]\nCH0,CH1,CH2\n",
        "run of the 5th,,\ntime,S1,S2\ns,MPa,um/m\n",
    ],
)
def test_channel_names_units_and_descriptions_are_read(tmp_path, head):
    text = head + rows(shown(T), shown(S1), shown(S2))
    recording = open_recording(write(tmp_path / "a.csv", text))
    assert recording.names == ("S1", "S2")
    assert tuple(c.unit for c in recording.channels) == ("MPa", "um/m")


def test_channel_named_t_is_not_taken_as_time(tmp_path):
    text = "time,T,S1\n" + rows(shown(T), shown(S2), shown(S1))
    recording = open_recording(write(tmp_path / "a.csv", text))
    assert recording.names == ("T", "S1")
    text = "t,T\n" + rows(shown(T), shown(S2))
    assert open_recording(write(tmp_path / "b.csv", text)).names == ("T",)


@pytest.mark.parametrize("later", [2.0, 1.05])
def test_changing_sample_rate_is_rejected(tmp_path, later):
    steps = np.concatenate([np.full(70_000, 1.0), np.full(70_000, later)]) / RATE
    time = np.cumsum(steps)
    text = "time,S1\n" + rows(shown(time), ["1.5"] * time.size)
    refused(write(tmp_path / "a.csv", text), "clock changes its rate")


def test_sample_rate_change_reports_sample_interval(tmp_path):
    """Most rows of the piece in which it slows are still those of the rate it began with."""
    steps = np.concatenate([np.full(6000, 1.0), np.full(2000, 2.0)]) / RATE
    text = "time,S1\n" + rows(shown(np.cumsum(steps)), ["1.5"] * steps.size)
    refused(
        write(tmp_path / "a.csv", text),
        "changes its rate at row 600[0-2] .*500 Hz before, 250 Hz from there on",
    )


# --------------------------------------------------------------------------- several rates


def speed_at(t):
    return 1000 + 100 * t


def check_two_rates(recording):
    assert recording.rate == RATE
    assert set(recording.names) == {"S1", "speed"}
    x, speed = recording.read_all(["S1", "speed"])
    np.testing.assert_allclose(x, S1, atol=1e-9)
    last = SLOW[-1]
    known = SLOW[0] <= T
    known &= last >= T
    np.testing.assert_allclose(speed[known], speed_at(T[known]), rtol=1e-9)
    assert np.isnan(speed[~known]).all()
    assert any("one clock of 500 Hz" in n and "speed (10 Hz)" in n for n in recording.notes)
    assert recording.read_all(["speed"]).shape == (1, N)


def test_hdf5_groups_of_two_rates_are_merged(tmp_path):
    h5py = pytest.importorskip("h5py")
    with h5py.File(tmp_path / "a.h5", "w") as file:
        gauges, bus = file.create_group("gauges"), file.create_group("can")
        gauges["S1"], bus["speed"] = S1, speed_at(SLOW)
        gauges.attrs["rate_Hz"], bus.attrs["rate_Hz"] = RATE, 10.0
    check_two_rates(open_recording(tmp_path / "a.h5"))
    assert open_recording(tmp_path / "a.h5", group="can").names == ("speed",)


def test_hdf5_groups_with_different_clocks_are_aligned(tmp_path):
    """Each group has its own time, and they need not begin at nought."""
    h5py = pytest.importorskip("h5py")
    with h5py.File(tmp_path / "a.h5", "w") as file:
        gauges, bus = file.create_group("gauges"), file.create_group("can")
        gauges["S1"], bus["speed"] = S1, speed_at(SLOW)
        gauges["time"], bus["time"] = 7 + T, 7 + SLOW
    check_two_rates(open_recording(tmp_path / "a.h5"))


def test_tdms_groups_of_two_rates_are_merged(tmp_path):
    nptdms = pytest.importorskip("nptdms")
    with nptdms.TdmsWriter(tmp_path / "a.tdms") as writer:
        writer.write_segment(
            [
                nptdms.ChannelObject("gauges", "S1", S1, properties={"wf_increment": 1 / RATE}),
                nptdms.ChannelObject(
                    "can", "speed", speed_at(SLOW), properties={"wf_increment": 0.1}
                ),
            ]
        )
    check_two_rates(open_recording(tmp_path / "a.tdms"))
    assert open_recording(tmp_path / "a.tdms", group="can").names == ("speed",)


@pytest.mark.filterwarnings("ignore")
def test_mdf_groups_of_two_rates_are_merged(tmp_path):
    asammdf = pytest.importorskip("asammdf")
    file = asammdf.MDF(version="4.10")
    file.append([asammdf.Signal(S1, T, name="S1", unit="MPa")])
    file.append([asammdf.Signal(speed_at(SLOW), SLOW, name="speed", unit="rpm")])
    file.save(tmp_path / "a.mf4")
    check_two_rates(open_recording(tmp_path / "a.mf4"))


@pytest.mark.parametrize("clock", ["time", "Time_s", "t"])
def test_seconds_column_is_clock_if_time_of_day_is_present(tmp_path, clock):
    """A logger writes seconds and when they were: it had been told that two had one name."""
    rows = (f"{k / RATE:.4f},{v:.6f},2024-05-01 10:00:{k / RATE:06.3f}" for k, v in enumerate(S1))
    (tmp_path / "a.csv").write_text(f"{clock},S1,stamp\n" + "\n".join(rows))
    recording = open_recording(tmp_path / "a.csv")
    assert recording.rate == RATE
    np.testing.assert_allclose(recording.read_all()[recording.names.index("S1")], S1, atol=1e-6)


# --------------------------------------------------------------------------- cut short, and bombs


@pytest.mark.parametrize("left", [1 / 3, 0.9])
def test_truncated_tdms_is_reported(tmp_path, left):
    nptdms = pytest.importorskip("nptdms")
    with nptdms.TdmsWriter(tmp_path / "a.tdms") as writer:
        for part in (slice(0, 700), slice(700, N)):
            writer.write_segment(
                [nptdms.ChannelObject("g", "S1", S1[part], properties={"wf_increment": 1 / RATE})]
            )
    whole = (tmp_path / "a.tdms").read_bytes()
    assert open_recording(tmp_path / "a.tdms").notes == ()
    (tmp_path / "b.tdms").write_bytes(whole[: int(left * len(whole))])
    recording = open_recording(tmp_path / "b.tdms")
    assert any("cut short" in n for n in recording.notes)
    assert recording.read_all().shape[1] < N


def test_hdf5_with_false_size_claim_is_rejected(tmp_path):
    h5py = pytest.importorskip("h5py")
    with h5py.File(tmp_path / "a.h5", "w") as file:
        file.create_dataset("S1", (10**12,), "f8", chunks=(1 << 20,))
        file.attrs["rate_Hz"] = RATE
    assert (tmp_path / "a.h5").stat().st_size < 10_000
    refused(tmp_path / "a.h5", "claims more samples than are stored")


def test_hdf5_external_file_link_is_rejected(tmp_path):
    h5py = pytest.importorskip("h5py")
    secret = tmp_path / "secret.bin"
    secret.write_bytes(np.arange(100.0).tobytes())
    with h5py.File(tmp_path / "other.h5", "w") as file:
        file.create_group("g")["S1"] = S1
    with h5py.File(tmp_path / "a.h5", "w") as file:
        file.attrs["rate_Hz"] = RATE
        file.create_dataset("S1", (100,), "f8", external=[(str(secret), 0, 800)])
    refused(tmp_path / "a.h5", "in another file, which is not opened")
    with h5py.File(tmp_path / "b.h5", "w") as file:
        file.attrs["rate_Hz"] = RATE
        file["S2"] = S2
        file["g"] = h5py.ExternalLink("other.h5", "/g")
        file["S1"] = h5py.ExternalLink("other.h5", "/g/S1")
    assert open_recording(tmp_path / "b.h5").names == ("S2",)
    refused(tmp_path / "b.h5", "in another file, which is not opened", group="g")
    layout = h5py.VirtualLayout((N,), "f8")
    layout[:] = h5py.VirtualSource(tmp_path / "other.h5", "g/S1", (N,))
    with h5py.File(tmp_path / "c.h5", "w") as file:
        file.attrs["rate_Hz"] = RATE
        file.create_virtual_dataset("S1", layout)
    refused(tmp_path / "c.h5", "in another file, which is not opened")


def test_parquet_constant_value_bomb_is_rejected(tmp_path):
    import pyarrow as pa
    import pyarrow.parquet as pq

    table = pa.table({"S1": pa.array(np.zeros(3_000_000))}).replace_schema_metadata(
        {"rate_Hz": "500"}
    )
    pq.write_table(table, tmp_path / "a.parquet", compression="zstd")
    assert (tmp_path / "a.parquet").stat().st_size < 60_000
    refused(tmp_path / "a.parquet", "claims more samples than it can hold")


@pytest.mark.parametrize("claimed", [17_000, 1_000_000])
def test_parquet_with_false_row_count_is_rejected(tmp_path, claimed):
    """Fewer rows than it said came without a word, as if the rest had never been."""
    import pyarrow as pa
    import pyarrow.parquet as pq

    path = tmp_path / "a.parquet"
    table = pa.table({"S1": np.arange(20_000.0)}).replace_schema_metadata({"rate_Hz": "500"})
    pq.write_table(table, path)
    assert open_recording(path).read_all().shape == (1, 20_000)
    data, said, lie = bytearray(path.read_bytes()), thrift(20_000), thrift(claimed)
    footer = len(data) - 8 - int.from_bytes(data[-8:-4], "little")
    at = data.index(said, footer)  # the first number of the footer that is so large
    data[at : at + len(said)] = lie
    path.write_bytes(data)
    recording = open_recording(path)
    assert recording.samples == claimed
    with pytest.raises(InvalidFileError, match=f"of {claimed} rows it holds 20000"):
        recording.read_all()


def test_parquet_dictionary_bomb_is_rejected(tmp_path):
    """190 kB of which one page took 1.15 GB, for numbers nobody uses."""
    honest, bomb = tmp_path / "honest.parquet", tmp_path / "bomb.parquet"
    dictionary_bomb(honest, bomb, values=1 << 26)
    assert open_recording(honest).read_all().shape == (1, 20_000)
    refused(bomb, "S1 claims more bytes than its samples take .* 536870912 bytes at once")
    said = CliRunner().invoke(command, [str(bomb), "--sn", "80,2e6,5", "--lang", "pt"])
    assert said.exit_code == 2
    assert "S1 declara mais bytes do que as suas amostras ocupam" in said.stderr


@pytest.mark.slow
def test_hdf5_chunk_bomb_is_rejected(tmp_path):
    """A megabyte of which one chunk took 1.07 GB, for a thousand samples."""
    h5py = pytest.importorskip("h5py")
    with h5py.File(tmp_path / "a.h5", "w") as file:
        file.attrs["rate_Hz"] = RATE
        grows = {"maxshape": (None,), "compression": "gzip", "dtype": "f8"}
        file.create_dataset("S1", (1000,), chunks=(1 << 24,), **grows)[:] = np.arange(1000)
        file.create_dataset("S2", (1000,), chunks=(1 << 20,), **grows)[:] = np.arange(1000)
    refused(tmp_path / "a.h5", "S1 claims more bytes than its samples take")


def head_of_a_page(size, stored, statistics=b""):
    """A data page's: bytes, bytes stored, a checksum, and of its values how many and statistics."""
    told = b"\x15" + b"\x15".join(map(thrift, (0, size, stored, 77)))  # fields 1 to 4
    binary = b"\x18" + bytes([len(statistics) & 127 | 128, len(statistics) >> 7]) + statistics
    return told + b"\x1c\x15\x02\x15\x00\x15\x06\x15\x06\x1c" + binary + b"\x11\x00\x00\x00"


@pytest.mark.parametrize(("first", "second"), [(0, 0), (100, 9_000)])
def test_parquet_page_sizes_are_read_from_headers(first, second):
    one = head_of_a_page(10, 7, bytes(first)) + b"x" * 7
    two = head_of_a_page(1 << 33, 3, bytes(second)) + b"yyy"
    column = SimpleNamespace(
        data_page_offset=4, dictionary_page_offset=None, has_dictionary_page=False,
        total_compressed_size=len(one + two),
    )  # fmt: skip
    assert list(page_sizes(BytesIO(b"PAR1" + one + two + b"footer"), column)) == [10, 1 << 33]
    for broken in (one[:9], b"\x15" * 40, b"\x19\x00" + one, b"\x15" + b"\xff" * 80, b"\x1c" * 80):
        with pytest.raises(ValueError, match="has no header"):
            list(page_sizes(BytesIO(b"PAR1" + broken), column))


def test_parquet_page_size_limit_depends_on_sample_count():
    assert [max_page_bytes(n) for n in (1, 1 << 22, 1 << 23, 1 << 40)] == [
        1 << 26,
        1 << 26,
        1 << 27,
        1 << 30,
    ]


@pytest.mark.parametrize(
    ("channels", "bits", "said"),
    [
        (65281, 16, "more than 1024 channels"), (0, 16, "it has no channels"),
        (1, 12, r"unknown kind of samples.*12 bits"),
    ],
)  # fmt: skip
def test_wav_with_invalid_channel_count_is_rejected(tmp_path, channels, bits, said):
    head = struct.pack(
        "<4sI4s4sIHHIIHH", b"RIFF", 99, b"WAVE", b"fmt ", 16, 1, channels, 500, 0, 0, bits
    )
    (tmp_path / "a.wav").write_bytes(head + struct.pack("<4sI", b"data", 1 << 20) + bytes(1 << 20))
    refused(tmp_path / "a.wav", said)


@pytest.mark.parametrize("name", ["a.csv", "a.txt"])
def test_endless_line_is_rejected_without_memory_growth(tmp_path, name):
    """Four gigabytes of it had taken as much memory; here some megabytes do."""
    (tmp_path / name).write_bytes(b"1 2 3 " * 2_000_000)
    refused(tmp_path / name, "does not end within 64 kB")
    good = rows(shown(T), shown(S1), sep=" ") * 4
    (tmp_path / name).write_bytes(f"time S1\n{good}".encode() + b"1 2 " * 2_000_000)
    refused(tmp_path / name, "a line does not end within 4 MB", rate=RATE)


# --------------------------------------------------------------------------- units


def run(*arguments):
    return CliRunner().invoke(command, [str(a) for a in arguments])


def test_voltage_channel_requires_scale(tmp_path):
    text = "time [s],S1 [MPa],B1 [mV/V],spd [km/h]\n" + rows(
        shown(T), shown(S1), shown((S1 - 5) / 400), ["36.0"] * N
    )
    path = write(tmp_path / "a.csv", text)
    plain = json.loads(run(path, "--gauge", "S1", "--sn", "30,2e6,5", "--json").output)
    more = ("--gauge", "B1", "--sn", "30,2e6,5")
    refusal = run(path, *more)
    assert refusal.exit_code == 2
    assert "--scale B1=FACTOR" in refusal.output
    scaled = json.loads(run(path, *more, "--scale", "B1=400,5:MPa", "--json").output)
    # Written to six decimals of a four-hundredth: 2e-4 MPa of 40.
    assert scaled["gauges"][0]["damage"] == pytest.approx(plain["gauges"][0]["damage"], rel=1e-4)
    assert scaled["gauges"][0]["high_MPa"] == pytest.approx(
        plain["gauges"][0]["high_MPa"], abs=1e-3
    )
    for wrong in ("B1=0:MPa", "B1=4", "B1=4:V", "B1=nan:MPa", "4:MPa", "B1=1,2,3:MPa"):
        assert run(path, *more, "--scale", wrong).exit_code == 2
    assert run(path, *more, "--scale", "B3=4:MPa").exit_code == 2


def test_scaled_channel_takes_unit_of_scale(tmp_path):
    """`--gauge B1:MPa --scale B1=2:kPa` took kPa for MPa: a thousand times the stress."""
    text = "time [s],B1 [mV/V]\n" + rows(shown(T), shown(S1))
    path = write(tmp_path / "a.csv", text)
    more = ("--sn", "30,2e6,5", "--scale", "B1=2000:kPa", "--json")
    alike = [json.loads(run(path, "--gauge", g, *more).output)["gauges"][0]["high_MPa"]
             for g in ("B1", "B1:kPa")]  # fmt: skip
    assert alike == pytest.approx([2 * S1.max()] * 2, rel=1e-5)
    refusal = run(path, "--gauge", "B1:MPa", *more)
    assert refusal.exit_code == 2
    assert "--scale turns it into kPa, and it is taken for MPa" in " ".join(refusal.output.split())


@pytest.mark.slow
def test_shaft_speed_is_computed_from_vehicle_speed(tmp_path):
    """36 km/h on tyres of 0.5 m and an axle of 4: 10/(2π 0.5) · 4 = 12.7 turns/s, for 3 s."""
    text = "time [s],S1 [MPa],spd [km/h]\n" + rows(shown(T), shown(S1), ["36.0"] * N)
    path = write(tmp_path / "a.csv", text)
    one = ("--gauge", "S1", "--sn", "30,2e6,5", "--speed", "spd")
    refusal = run(path, *one)
    assert refusal.exit_code == 2
    assert "--axle-ratio and --tyre-radius-m" in refusal.output
    done = run(path, *one, "--axle-ratio", "4", "--tyre-radius-m", "0.5", "--json")
    assert done.exit_code == 0, done.output
    document = json.loads(done.output)
    assert document["distance_km"] == pytest.approx(0.03, rel=0.01)
    assert document["gauges"][0]["order2_by_speed"][0]["rpm"] == pytest.approx(764, abs=60)


@pytest.mark.filterwarnings("ignore")
def test_mdf_channel_is_read_once_sequentially(tmp_path, monkeypatch):
    """Each stretch had been read from the channel's beginning: 29 times the cost."""
    asammdf = pytest.importorskip("asammdf")
    from cardan.readers import mdf as recording_tables

    monkeypatch.setattr(recording_tables, "MDF_READ_BLOCK_BYTES", 4096)
    t = np.arange(20_000) / RATE
    file = asammdf.MDF(version="4.10")
    file.append([asammdf.Signal(np.sin(k * t), t, name=f"S{k}", unit="MPa") for k in (1, 2)])
    file.save(tmp_path / "a.mf4")
    recording = open_recording(tmp_path / "a.mf4")
    begun = []
    from asammdf.blocks.mdf_v4 import MDF4

    monkeypatch.setattr(MDF4, "_load_data", _counted(MDF4._load_data, begun))
    monkeypatch.setattr(asammdf.MDF, "get", _counted(asammdf.MDF.get, stretches := []))
    pieces = list(recording.read((1, 0)))
    np.testing.assert_array_equal(np.concatenate(pieces, -1), [np.sin(2 * t), np.sin(t)])
    assert len(begun) == 1  # for all its channels
    assert not any("record_offset" in how for how in stretches)
    assert len(stretches) > 20  # stretch by stretch, and not whole


def _counted(call, seen):
    def counting(self, *args, **how):
        seen.append(how)
        return call(self, *args, **how)

    return counting


def test_row_with_missing_columns_is_reported_with_line(tmp_path):
    """It was no answer at all: every row of the file holds numbers."""
    (tmp_path / "a.csv").write_text("1,1,1\n1\n1,1,1\n\n", encoding="utf-8")
    with pytest.raises(InvalidFileError, match=r"a\.csv:2:.*numbers begin at line 1 and then.*'1'"):
        open_recording(tmp_path / "a.csv", rate=100.0)
