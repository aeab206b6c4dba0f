"""Recordings of every kind come back as written, and hostile ones are refused in words."""

import gc
import struct
import subprocess
import sys
import wave
from decimal import Decimal
from pathlib import Path

import numpy as np
import pytest

from cardan.core.errors import DesignError, InvalidFileError
from cardan.physics.signals.recording import rechunk_to_block_size, recording_from_arrays
from cardan.readers.dispatch import open_recording

csv = pytest.importorskip("pyarrow.csv")

RATE = 500.0
N = 1200
T = np.arange(N) / RATE
S1, S2 = np.round(np.sin(T * 40), 6), np.round(np.cos(T * 25) * 3, 6)


def write(path, text, encoding="utf-8"):
    path.write_bytes(text.encode(encoding))
    return path


def rows(sep, point, order="{t}{sep}{a}{sep}{b}", end=""):
    def show(v):
        return f"{v:.6f}".replace(".", point)

    return "\n".join(
        order.format(t=show(t), a=show(a), b=show(b), sep=sep) + end
        for t, a, b in zip(T, S1, S2, strict=True)
    )


DIALECTS = {
    "english": ("time,S1,S2\n" + rows(",", "."), "utf-8", ("", "")),
    "german": ("Zeit;S1;S2\ns;MPa;µm/m\n" + rows(";", ","), "latin-1", ("MPa", "µm/m")),
    "tabs": ("time [s]\tS1 [MPa]\tS2 [µm/m]\n" + rows("\t", ","), "utf-8", ("MPa", "µm/m")),
    "bars": ("t|S1 (MPa)|S2 / V\n" + rows("|", "."), "utf-8", ("MPa", "V")),
    "excel": ("time;S1;S2\n" + rows(";", ",", end=";"), "utf-8-sig", ("", "")),
    "wide": ("time,S1,S2\n" + rows(",", "."), "utf-16", ("", "")),
    "preamble": ("logger 12\nroute: north\n\n# time,S1,S2\n" + rows(",", "."), "utf-8", ("", "")),
    "spaces": ("time S1 S2\n" + rows("   ", "."), "utf-8", ("", "")),
    "windows": (("time;S1;S2\n" + rows(";", ".")).replace("\n", "\r\n"), "utf-8", ("", "")),
}


@pytest.mark.parametrize("name", DIALECTS)
def test_csv_of_any_dialect_is_read(tmp_path, name):
    text, encoding, units = DIALECTS[name]
    if name == "excel":
        text = text.replace("time;S1;S2", "time;S1;S2;")
    recording = open_recording(write(tmp_path / "a.csv", text, encoding))
    assert recording.rate == RATE
    assert recording.names == ("S1", "S2")
    assert tuple(c.unit for c in recording.channels) == units
    np.testing.assert_allclose(recording.read_all(), [S1, S2], atol=1e-12)
    np.testing.assert_allclose(recording.read_all(["S2"]), [S2], atol=1e-12)


def refused(path, match, **how):
    with pytest.raises(InvalidFileError, match=match):
        open_recording(path, **how).read_all()


WHOLE = "".join(f"{k};5\n" for k in range(20000))
LONG = "".join(f"{k / 500},1,2\n" for k in range(9000))
HOSTILE = {
    "a word": ("time,S1\n0,1\n0.002,2\n0.004,three\n0.006,4\n", "then a row is not numbers"),
    "numbers above names": ("Lab\n2024,11\n\ntime,S1\ns,MPa\n0,1\n0.002,2\n0.004,3\n",
                            "a.csv:4: numbers begin at line 2 .*'time' in column 1"),
    "late word": ("time,S1,S2\n\n" + LONG + "18,x,1\n", "a.csv:9003: column .S1. .*x"),
    "late infinity": ("time,S1,S2\n" + LONG + "18,1,-inf\n", "a.csv:9002: column 'S2' .*'-inf'"),
    "short row": ("time,S1,S2\n" + LONG + "18,5\n" + LONG, "3 columns"),
    "thousands or not": ("time;S1\n1'234;1.234\n2'345;1,234\n", "sets its thousands apart"),
    "thousands late": ("time;S1\n" + WHOLE + "20000;1,234\n", "a.csv:20002: .* two ways.*'1,234'"),
    "holed": ("time,S1,S2\n" + LONG[:40000] + "\0" * 64 + LONG[40000:], "a.csv:.*: NUL bytes"),
    "holed late": ("time,S1,S2\n" + LONG + "\0" * 64 + LONG, "a.csv:9002: NUL bytes"),
    "backwards": ("time,S1\n0,1\n0.002,2\n0.004,2\n0.001,3\n", "not even at row 4"),
    "jitter": ("time,S1\n0,1\n0.002,2\n0.004,2\n0.0069,3\n0.009,1\n", "not even at row 4"),
    "no time": ("S1,S2\n1,2\n3,4\n5,6\n", "how fast"),
    "two ways": ("1,5\n2,5\n3,5\n", "more than one way"),
    "twins": ("time,S1,S1\n0,1,2\n1,1,2\n2,1,3\n", "one name"),
    "standing": ("time,S1\n0,1\n0,1\n0,1\n0,1\n", "stands still"),
    "years": ("time [a],S1\n0,1\n1,1\n2,1\n3,1\n", "unknown unit"),
    "only time": ("time\n0\n1\n2\n", "no channel"),
}  # fmt: skip


@pytest.mark.slow
@pytest.mark.parametrize("name", HOSTILE)
def test_malformed_csv_is_rejected(tmp_path, name):
    text, match = HOSTILE[name]
    refused(write(tmp_path / "a.csv", text), match)


def test_truncated_last_csv_row_is_ignored(tmp_path):
    text = "time,S1,S2\n" + rows(",", ".")
    recording = open_recording(write(tmp_path / "a.csv", text + "\n2.4,0."))
    np.testing.assert_allclose(recording.read_all(), [S1, S2], atol=1e-12)


def test_csv_reader_registers_no_python_callback_in_arrow(tmp_path, monkeypatch):
    """One in sixty processes that left a file half read ended in SIGABRT."""
    given = []

    def options(**how):
        given.append(how["invalid_row_handler"])
        return sound(**how)

    sound = csv.ParseOptions
    monkeypatch.setattr(csv, "ParseOptions", options)
    open_recording(write(tmp_path / "a.csv", "time,S1,S2\n" + rows(",", "."))).read_all()
    assert given
    assert not any(given)


def test_time_gap_becomes_missing_samples(tmp_path):
    lines = ("time,S1,S2\n" + rows(",", ".")).splitlines()
    del lines[301:311]  # samples 300 to 309
    recording = open_recording(write(tmp_path / "a.csv", "\n".join(lines)))
    x = recording.read_all(["S1"])[0]
    assert x.size == N
    assert np.isnan(x).sum() == np.isnan(x[300:310]).sum() == 10
    known = ~np.isnan(x)
    np.testing.assert_allclose(x[known], S1[known], atol=1e-12)


@pytest.mark.parametrize(("unit", "rate"), [("s", 1), ("ms", 1e3), ("min", 1 / 60), ("us", 1e6)])
def test_time_column_is_read_in_its_unit(tmp_path, unit, rate):
    """A step of one of the unit is so many samples a second."""
    file = tmp_path / "run.csv"
    file.write_text(f"time [{unit}],S1\n0,1\n1,2\n2,3\n3,4\n")
    assert open_recording(file).rate == pytest.approx(rate)


def test_empty_fields_are_missing_samples(tmp_path):
    text = "time;S1;S2\n0;1;2\n0,002;;3\n0,004;5;NaN\n0,006;7;8\n"
    x = open_recording(write(tmp_path / "a.csv", text)).read_all()
    assert np.isnan(x).tolist() == [[False, True, False, False], [False, False, True, False]]


def test_given_sample_rate_overrides_file(tmp_path):
    text = "S1,S2\n1,2\n3,4\n5,6\n"
    assert open_recording(write(tmp_path / "a.csv", text), rate=100.0).rate == 100
    refused(tmp_path / "a.csv", "above 0", rate=-1.0)


def test_missing_or_unknown_file_is_rejected_with_reason(tmp_path):
    refused(tmp_path / "a.csv", "no such file")
    refused(write(tmp_path / "a.xyz", "1"), "no reader")
    refused(write(tmp_path / "a.csv", ""), "empty")
    (tmp_path / "b.csv").write_bytes(bytes(range(256)) * 10)
    refused(tmp_path / "b.csv", "not text")
    refused(write(tmp_path / "c.csv", "time,S1\n0,1\n1,2\n2,3\n"), "no time column", time="tme")
    with pytest.raises(DesignError, match="did you mean 'S1'"):
        open_recording(tmp_path / "c.csv").index_of("S11")


def test_parquet_recording_is_read(tmp_path):
    import pyarrow as pa
    import pyarrow.parquet as pq

    schema = pa.schema(
        [
            pa.field("S1", pa.float32(), metadata={"unit": "MPa"}),
            pa.field("S2", pa.float64()),
            pa.field("note", pa.string()),
        ],
        metadata={"rate_Hz": "500", "note": "by hand"},
    )
    table = pa.table([S1.astype("f4"), S2, ["x"] * N], schema=schema)
    pq.write_table(table, tmp_path / "a.parquet", row_group_size=333)
    recording = open_recording(tmp_path / "a.parquet")
    assert (recording.rate, recording.samples) == (RATE, N)
    assert recording.channels[0].unit == "MPa"
    assert recording.notes == ("by hand", "not numbers, left out: note")
    np.testing.assert_allclose(recording.read_all(), [S1, S2], atol=2e-7)  # float32
    cut_short = (tmp_path / "a.parquet").read_bytes()[:-100]
    (tmp_path / "b.parquet").write_bytes(cut_short)
    refused(tmp_path / "b.parquet", "written to its end")


def test_hdf5_recording_is_read(tmp_path):
    h5py = pytest.importorskip("h5py")
    with h5py.File(tmp_path / "a.h5", "w") as file:
        group = file.create_group("strain")
        group.attrs["sample_rate"] = RATE
        group["S1"], group["S2"] = S1, S2
        group["S1"].attrs["unit"] = "MPa"
        file.create_group("slow")["temperature"] = np.ones(10)
    # A group without a rate that nobody named does not decide over the file.
    whole = open_recording(tmp_path / "a.h5")
    assert (whole.names, whole.rate) == (("S1", "S2"), RATE)
    assert any(n.startswith("slow: left out") for n in whole.notes)
    recording = open_recording(tmp_path / "a.h5", group="strain")
    assert recording.channels[0].unit == "MPa"
    np.testing.assert_array_equal(recording.read_all(), [S1, S2])
    (tmp_path / "b.h5").write_bytes((tmp_path / "a.h5").read_bytes()[:3000])
    refused(tmp_path / "b.h5", "HDF5 cannot open")
    refused(tmp_path / "a.h5", "no group", group="fast")


def test_quoted_decimal_commas_are_read(tmp_path):
    """A spreadsheet's way where the comma is the decimal sign: nothing said how fast it was."""
    rows = [(f"{k / RATE:.4f}", f"{x:.3f}") for k, x in enumerate(S1)]
    plain = "time [s],S1 [MPa]\n" + "".join(f"{t},{x}\n" for t, x in rows)
    quoted = "time [s],S1 [MPa]\n" + "".join(f'"{t}","{x}"\n'.replace(".", ",") for t, x in rows)
    found, want = (
        open_recording(write(tmp_path / name, text)) for name, text in
        (("q.csv", quoted), ("p.csv", plain))
    )  # fmt: skip
    assert found.channels[0].unit == "MPa"
    np.testing.assert_array_equal(found.read_all(), want.read_all())


def test_utf_32_file_is_rejected_by_name(tmp_path):
    refused(write(tmp_path / "a.csv", "time,S1\n0,1\n0.1,2\n", "utf-32"), "letters are UTF-32")


def test_hdf5_whose_parts_are_damaged_is_rejected(tmp_path, monkeypatch):
    """h5py raises RuntimeError of a broken tree, and KeyError, ValueError or TypeError beside."""
    h5py = pytest.importorskip("h5py")
    with h5py.File(tmp_path / "a.h5", "w") as file:
        file["S1"] = np.arange(100.0)
    for kind in (RuntimeError, KeyError, ValueError, TypeError):
        error = kind("broken tree")

        def broken(*_, error=error):
            raise error

        monkeypatch.setattr(h5py.Group, "visititems", broken)
        refused(tmp_path / "a.h5", "damaged: .*broken tree")


def test_hdf5_names_multicolumn_datasets_left_out(tmp_path):
    """It said that there is no channel, and not that it left one out."""
    h5py = pytest.importorskip("h5py")
    with h5py.File(tmp_path / "a.h5", "w") as file:
        file["time"], file["S1"] = np.arange(200) / RATE, np.ones((200, 2))
        file["version"] = 3
    said = "it holds no channel but time; more than one number a sample, left out: S1"
    refused(tmp_path / "a.h5", said)
    with h5py.File(tmp_path / "a.h5", "a") as file:
        file["S2"] = np.arange(200.0) % 7
    notes = open_recording(tmp_path / "a.h5").notes
    assert "more than one number a sample, left out: S1" in notes


def test_hdf5_packed_integers_are_scaled(tmp_path):
    """CF Metadata Conventions 1.11, section 8.1: 1.5e-3 of damage was told for 3.4e-5."""
    h5py = pytest.importorskip("h5py")
    with h5py.File(tmp_path / "a.h5", "w") as file:
        file.attrs["sample_rate"] = RATE
        file["S1"] = np.array([100, 250, -32768, 7] * 10, np.int16)
        packed = {"scale_factor": [0.5], "add_offset": 3.0, "_FillValue": np.int16(-32768)}
        file["S1"].attrs.update(packed)
    kept = open_recording(tmp_path / "a.h5").read_all()[0]
    np.testing.assert_array_equal(kept[:4], [53, 128, np.nan, 6.5])


@pytest.mark.parametrize("factor", ["2.0", b"2.0", np.array(["2.0"], object), np.array([2.0])])
def test_hdf5_scale_factor_given_as_text_is_applied(tmp_path, factor):
    """A factor written as a text was passed over: 684 h were told for 14."""
    h5py = pytest.importorskip("h5py")
    with h5py.File(tmp_path / "a.h5", "w") as file:
        file.attrs["sample_rate"] = RATE
        file["S1"] = np.array([100, 250, 7] * 10, np.int16)
        file["S1"].attrs.update({"scale_factor": factor, "unit": np.array(["MPa"], object)})
    recording = open_recording(tmp_path / "a.h5")
    assert recording.channels[0].unit == "MPa"
    np.testing.assert_array_equal(recording.read_all()[0][:3], [200, 500, 14])
    with h5py.File(tmp_path / "b.h5", "w") as file:
        file.attrs["sample_rate"] = RATE
        file["S1"] = np.ones(30)
        file["S1"].attrs["scale_factor"] = "two"
    refused(tmp_path / "b.h5", "its scale_factor is not a number .*two")


def test_parquet_decimals_are_read_as_numbers(tmp_path):
    """It said that the file holds no channel beside time."""
    pa = pytest.importorskip("pyarrow")
    import pyarrow.parquet as pq

    values = pa.array([Decimal("12.25"), None, Decimal("-3.50")] * 10, pa.decimal128(7, 2))
    table = pa.table({"S1": values}).replace_schema_metadata({"rate_Hz": "500"})
    pq.write_table(table, tmp_path / "a.parquet")
    kept = open_recording(tmp_path / "a.parquet").read_all()[0]
    np.testing.assert_array_equal(kept[:3], [12.25, np.nan, -3.5])


def test_tdms_recording_is_read(tmp_path):
    nptdms = pytest.importorskip("nptdms")
    step = {"wf_increment": 1 / RATE, "unit_string": "MPa"}
    with nptdms.TdmsWriter(tmp_path / "a.tdms") as writer:
        for part in (slice(0, 700), slice(700, N)):
            writer.write_segment(
                [
                    nptdms.ChannelObject("strain", "S1", S1[part], properties=step),
                    nptdms.ChannelObject("strain", "S2", S2[part], properties=step),
                ]
            )
    recording = open_recording(tmp_path / "a.tdms")
    assert recording.rate == pytest.approx(RATE)
    assert recording.channels[1].unit == "MPa"
    np.testing.assert_array_equal(recording.read_all(), [S1, S2])
    write(tmp_path / "b.tdms", "not a tdms file at all")
    refused(tmp_path / "b.tdms", "TDMS cannot open it")


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore")
def test_mdf_recording_is_read(tmp_path, monkeypatch):
    asammdf = pytest.importorskip("asammdf")
    file = asammdf.MDF(version="4.10")
    file.append(
        [
            asammdf.Signal(S1, T, name="S1", unit="MPa"),
            asammdf.Signal(S2, T, name="S2", unit="MPa"),
        ]
    )
    file.save(tmp_path / "a.mf4")
    recording = open_recording(tmp_path / "a.mf4")
    assert recording.rate == RATE
    assert recording.names == ("S1", "S2")
    np.testing.assert_array_equal(recording.read_all(), [S1, S2])
    write(tmp_path / "b.mf4", "not an mdf file at all")
    refused(tmp_path / "b.mf4", "MDF cannot open")
    # What was half made of one that was cut off goes without a word.
    (tmp_path / "c.mf4").write_bytes((tmp_path / "a.mf4").read_bytes()[:1000])
    said = []
    with monkeypatch.context() as patch:
        patch.setattr(sys, "unraisablehook", said.append)
        refused(tmp_path / "c.mf4", "MDF cannot open")
        gc.collect()
    assert not said


@pytest.mark.slow
def test_mdf_is_read_in_blocks_with_limited_memory(tmp_path):
    """Pages of a mapped file are the process' own as long as nobody else asks for them."""
    asammdf = pytest.importorskip("asammdf")
    file, many = asammdf.MDF(version="4.10"), np.arange(4_000_000) / 1000
    names = tuple(f"S{k}" for k in range(7))
    file.append([asammdf.Signal(np.sin(many), many, name=n, unit="MPa") for n in names])
    file.save(tmp_path / "a.mf4")
    assert (tmp_path / "a.mf4").stat().st_size > 250e6
    assert grown(tmp_path / "a.mf4", "mf4") < 150


@pytest.mark.slow
def test_csv_is_read_with_memory_of_few_blocks(tmp_path):
    """By blocks of 8 MB its reader held 390 MB more than by those of one."""
    row = "".join(f"{k / 1000:.3f},{k % 977 / 7:.6f},{k % 773 / 3:.6f}\n" for k in range(100_000))
    write(tmp_path / "a.csv", "n [rpm],S1 [MPa],S2 [MPa]\n" + row * 40)
    assert (tmp_path / "a.csv").stat().st_size > 80e6
    assert grown(tmp_path / "a.csv", "csv") < 150


def grown(path, ending):
    """MB of memory that walking through a recording takes, in a process of its own."""
    if not Path("/proc/self/status").exists():
        pytest.skip("nothing says here how much memory a process took")
    code = (
        "import sys; from pathlib import Path\n"
        "from cardan.readers.dispatch import open_recording\n"
        "if sys.argv[2] == 'mf4': import asammdf\n"
        "else: import pyarrow.csv\n"
        "def peak(): return int(Path('/proc/self/status').read_text()"
        ".split('VmHWM:')[1].split()[0])\n"
        "was, run = peak(), open_recording(Path(sys.argv[1]), rate=1000.0)\n"
        "for _ in run.read((0, 1)): pass\n"
        "print(peak() - was)"
    )
    done = subprocess.run(
        [sys.executable, "-c", code, str(path), ending], capture_output=True, text=True, check=True
    )
    return int(done.stdout) / 1e3


@pytest.mark.parametrize(("width", "digits"), [(1, 7), (2, 15), (3, 23), (4, 31)])
def test_wav_of_any_sample_width_is_read(tmp_path, width, digits):
    data = np.stack([S1, S2 / 4])
    whole = np.round(data * 2.0**digits * 0.9).astype(np.int64)
    raw = (whole.T + (128 if width == 1 else 0)).astype("<i8").tobytes()
    frames = np.frombuffer(raw, np.uint8).reshape(-1, 8)[:, :width].tobytes()
    with wave.open(str(tmp_path / "a.wav"), "wb") as file:
        file.setnchannels(2)
        file.setsampwidth(width)
        file.setframerate(int(RATE))
        file.writeframes(frames)
    recording = open_recording(tmp_path / "a.wav")
    assert recording.rate == RATE
    np.testing.assert_allclose(recording.read_all(), whole / 2.0**digits, atol=1e-15)


def test_float_and_truncated_wav_are_read(tmp_path):
    from scipy.io import wavfile

    wavfile.write(tmp_path / "a.wav", int(RATE), np.stack([S1, S2], -1).astype("f4"))
    recording = open_recording(tmp_path / "a.wav")
    np.testing.assert_allclose(recording.read_all(), [S1, S2], atol=2e-7)
    (tmp_path / "b.wav").write_bytes((tmp_path / "a.wav").read_bytes()[:-800])
    short = open_recording(tmp_path / "b.wav")
    assert short.samples == N - 100
    assert "cut short" in short.notes[0]
    (tmp_path / "c.wav").write_bytes(struct.pack("<4sI4s", b"RIFF", 99, b"WAVE"))
    refused(tmp_path / "c.wav", "ends before")
    assert not recording.notes


def test_wav_with_inconsistent_header_is_noted_or_rejected(tmp_path):
    """A logger that was cut off, or never wrote how much it had: nothing is left out unsaid."""
    with wave.open(str(tmp_path / "a.wav"), "wb") as file:
        file.setparams((1, 2, int(RATE), 0, "NONE", ""))
        file.writeframes(np.arange(-500, 500, dtype="<i2").tobytes())
    raw = bytearray((tmp_path / "a.wav").read_bytes())
    at = raw.index(b"data") + 4

    def opened(length, *, pace=2 * int(RATE), after=b""):
        head = raw.copy()
        head[at : at + 4] = struct.pack("<I", length)
        head[28:32] = struct.pack("<I", pace)
        (tmp_path / "b.wav").write_bytes(head + after)
        return open_recording(tmp_path / "b.wav")

    half = opened(1000)
    assert (half.samples, len(half.notes)) == (500, 1)
    assert "1000 bytes behind the 1000 that its header claims" in half.notes[0]
    for length in (0, 0xFFFFFFFF):
        whole = opened(length)
        np.testing.assert_array_equal(whole.read_all()[0] * 2**15, np.arange(-500, 500))
        assert "says nothing of how long it is" in whole.notes[0]
    assert not opened(2000, after=b"LIST" + struct.pack("<I", 4) + b"INFO").notes
    (note,) = opened(2000, pace=4 * int(RATE)).notes
    assert f"says {RATE:g} Hz and, by bytes a second, {2 * RATE:g} Hz" in note


def test_file_that_is_not_wav_is_rejected(tmp_path):
    write(tmp_path / "d.wav", "hello")
    refused(tmp_path / "d.wav", "not a WAV")


def test_chunks_have_equal_size():
    x = np.arange(20.0).reshape(2, 10)
    parts = list(rechunk_to_block_size([x[:, :1], x[:, 1:8], x[:, 8:]], size=4))
    assert [p.shape[1] for p in parts] == [4, 4, 2]
    np.testing.assert_array_equal(np.concatenate(parts, -1), x)
    recording = recording_from_arrays(x, rate=1.0, names=["a", "b"], units=["m", "N"])
    np.testing.assert_array_equal(recording.read_all(["b"]), x[1:])


@pytest.mark.parametrize(
    ("point", "apart"),
    [(".", ","), (",", "."), (".", "'"), (",", " "), (".", "\N{NO-BREAK SPACE}")],
)
@pytest.mark.parametrize("late", [False, True])
def test_thousands_separators_are_read(tmp_path, point, apart, late):
    """In the first lines, or only where the fast way has already gone on for 64 kB."""
    many = 8000

    def show(x):
        return f"{x:,.2f}".replace(",", "_").replace(".", point).replace("_", apart)

    big = np.where(np.arange(many) >= (7000 if late else 0), 1234567.25, 7.5)
    text = "time;S1\n" + "".join(
        f"{k / 500:.3f}".replace(".", point) + f";{show(x)}\n" for k, x in enumerate(big)
    )
    recording = open_recording(write(tmp_path / "a.csv", text))
    assert recording.rate == pytest.approx(RATE)
    np.testing.assert_array_equal(recording.read_all(["S1"])[0], big)


def test_value_above_one_million_reveals_thousands_separator(tmp_path):
    text = "time [ms];S1\n" + "".join(f"{k};{1234567 + k:,d}\n" for k in range(100))
    recording = open_recording(write(tmp_path / "a.csv", text))
    np.testing.assert_array_equal(recording.read_all(["S1"])[0], 1234567 + np.arange(100))


def test_three_decimals_are_not_thousands_separators(tmp_path):
    text = "time;S1\n1,001;1,234\n1,002;2,345\n1,003;3,456\n"
    np.testing.assert_array_equal(
        open_recording(write(tmp_path / "a.csv", text)).read_all(["S1"])[0], [1.234, 2.345, 3.456]
    )


def test_utf_16_without_byte_order_mark_is_read(tmp_path):
    text = "time,S1,S2\n" + rows(",", ".")
    recording = open_recording(write(tmp_path / "a.csv", text, "utf-16-le"))
    np.testing.assert_allclose(recording.read_all(), [S1, S2], atol=1e-12)


def test_space_separated_text_reports_non_numeric_value(tmp_path):
    text = "time S1 S2\n" + LONG.replace(",", " ") + "18 1 inf\n"
    refused(write(tmp_path / "a.txt", text), "a.txt:9002: column 'S2' holds no number.*'inf'")


def ticks(kind, *, start=0):
    """S1 with a clock of one of Arrow's types, past midnight and longer than a batch."""
    import pyarrow as pa

    many = (1 << 18) + 5000
    each = {"s": 1, "ms": 2, "us": 2000, "ns": 2_000_000}[kind.unit]
    count = start + each * np.arange(many)
    if pa.types.is_time(kind):
        count %= DAYS_TICKS[kind.unit]
    return pa.array(count.astype(f"int{kind.bit_width}")).cast(kind), np.arange(many) % 977.0


DAYS_TICKS = {"ms": 86_400_000, "us": 86_400_000_000, "ns": 86_400_000_000_000}


@pytest.mark.parametrize("name", ["time", "recorded_at"])
@pytest.mark.parametrize(
    "kind",
    ["timestamp[ms]", "timestamp[us, tz=Europe/Berlin]", "timestamp[ns, tz=UTC]", "duration[ns]",
     "duration[us]", "time32[ms]", "time64[us]", "time64[ns]"],
)  # fmt: skip
def test_parquet_time_column_of_any_type_is_read(tmp_path, kind, name):
    """Instants since 1970, times passed from nought, and times of day past midnight."""
    import pyarrow as pa
    import pyarrow.parquet as pq

    head, _, zone = kind.partition(", tz=")
    what, unit = head.rstrip("]").split("[")
    of = pa.timestamp(unit, tz=zone.rstrip("]")) if zone else getattr(pa, what)(unit)
    day = DAYS_TICKS[unit]
    start = {"timestamp": 20_000 * day, "duration": 0}.get(what, day - day // 864)
    clock, x = ticks(of, start=start)
    pq.write_table(pa.table({name: clock, "S1": x}), tmp_path / "a.parquet")
    recording = open_recording(tmp_path / "a.parquet")
    assert (recording.rate, recording.names) == (RATE, ("S1",))
    np.testing.assert_array_equal(recording.read_all()[0], x)


def test_parquet_time_running_backwards_is_rejected(tmp_path):
    import pyarrow as pa
    import pyarrow.parquet as pq

    count = 2 * np.arange(4000)
    count[2000:] -= 50_000_000
    table = pa.table({"time": pa.array(count).cast(pa.timestamp("ms")), "S1": count / 1.0})
    pq.write_table(table, tmp_path / "a.parquet")
    refused(tmp_path / "a.parquet", "not even at row 2001")


@pytest.mark.slow
@pytest.mark.parametrize("hole", [0, 300])
def test_clock_time_past_midnight_is_continuous(tmp_path, hole):
    many = 12000
    k = np.arange(many) + np.where(np.arange(many) >= 5000, hole, 0)
    seconds = (86400 - 10 + k / 500) % 86400
    lines = (
        f"{int(t // 3600):02d}:{int(t % 3600 // 60):02d}:{t % 60:06.3f};{x}"
        for t, x in zip(seconds, k, strict=True)
    )
    recording = open_recording(write(tmp_path / "a.csv", "clock;S1\n" + "\n".join(lines)))
    x = recording.read_all()[0]
    np.testing.assert_array_equal(x[~np.isnan(x)], k)
    assert np.isnan(x).sum() == hole


def test_implausible_sample_is_reported_with_position(tmp_path):
    from cardan.physics.signals.assessment import survey_channel_quality

    text = "time,S1,S2\n" + LONG.replace("0.01,1,2\n", "0.01,1,1e300\n", 1)
    recording = open_recording(write(tmp_path / "a.csv", text))
    with pytest.raises(DesignError, match=r"S2: samples must be .* 1e\+300 at sample 6, 0.01 s"):
        survey_channel_quality(recording, channels=["S1", "S2"])


def test_silent_bus_leaves_speed_missing(tmp_path):
    """From its last message on to the next; one that comes late by three is no hole."""
    asammdf = pytest.importorskip("asammdf")
    fast, slow = np.arange(0, 30, 0.002), np.arange(0, 30, 0.01)
    silent, late = (slow > 12.0) & (slow < 18.0), (slow > 5.0) & (slow < 5.035)
    said = slow[~(silent | late)]
    file = asammdf.MDF(version="4.10")
    file.append([asammdf.Signal(np.sin(fast), fast, name="S1", unit="MPa")])
    file.append([asammdf.Signal(60 * said, said, name="n", unit="rpm")])
    file.save(tmp_path / "a.mf4")
    file.close()
    recording = open_recording(tmp_path / "a.mf4")
    n = recording.read_all(["n"])[0]
    unknown = (fast > 12.001) & (fast < 17.999)
    np.testing.assert_array_equal(np.isnan(n[fast < 29.9]), unknown[fast < 29.9])
    np.testing.assert_allclose(n[~np.isnan(n)], 60 * fast[~np.isnan(n)], rtol=1e-9)
    assert "n: no value for 6 s, longest hole 6 s, the first at 12 s" in recording.notes


@pytest.mark.slow
def test_mdf_is_opened_without_reading_samples(tmp_path):
    """What was asked of one record read all of them, twice over in memory."""
    asammdf = pytest.importorskip("asammdf")
    if not Path("/proc/self/status").exists():
        pytest.skip("nothing says here how much memory a process took")
    file, many = asammdf.MDF(version="4.10"), np.arange(6_000_000) / 1000
    x, names = np.sin(many).astype("f4"), tuple(f"S{k}" for k in range(7))
    file.append([asammdf.Signal(x, many, name=n, unit="MPa") for n in names])
    file.save(tmp_path / "a.mf4")
    code = (
        "import asammdf, sys; from pathlib import Path\n"
        "from cardan.readers.dispatch import open_recording\n"
        "def peak(): return int(Path('/proc/self/status').read_text()"
        ".split('VmHWM:')[1].split()[0])\n"
        "was = peak(); open_recording(Path(sys.argv[1])); print(peak() - was)"
    )
    done = subprocess.run(
        [sys.executable, "-c", code, str(tmp_path / "a.mf4")],
        capture_output=True, text=True, check=True,
    )  # fmt: skip
    # Its records are 216 MB, of which all took 386; of a clock one stretch of 16 MB is looked at.
    assert (tmp_path / "a.mf4").stat().st_size > 216e6
    assert int(done.stdout) < 100e3
