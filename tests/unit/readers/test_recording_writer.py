"""A converted recording is read back as the recording it was."""

import tracemalloc

import numpy as np
import pytest
import recording_files as known
import scipy.io
from click.testing import CliRunner

from cardan.cli import cli
from cardan.core.errors import DesignError
from cardan.physics.signals.recording import Channel, Recording, recording_from_arrays
from cardan.readers import recording_writer
from cardan.readers.dispatch import open_recording
from cardan.readers.recording_writer import csv_chunks, parquet_chunks

pytest.importorskip("pyarrow")
pytestmark = pytest.mark.filterwarnings("ignore")


def run(*arguments, code=0):
    done = CliRunner().invoke(cli, ["convert", *map(str, arguments)])
    assert done.exit_code == code, done.output
    return done.output


@pytest.mark.parametrize("suffix", [".parquet", ".csv"])
@pytest.mark.parametrize("write", known.ALL, ids=lambda w: w.__name__)
def test_converted_recording_is_the_same(tmp_path, write, suffix):
    source, out = tmp_path / "a.dat", tmp_path / f"b{suffix}"
    write(source)
    run(source, out)
    was, now = open_recording(source), open_recording(out)
    assert now.channels == was.channels
    assert now.rate == pytest.approx(was.rate, rel=1e-9)
    assert now.clock_start == pytest.approx(was.clock_start, abs=1e-9)
    np.testing.assert_array_equal(now.read_all(), was.read_all())
    gauge, *bus = now.read_all()
    if bus:  # each begins when it began, and misses what it missed
        assert np.flatnonzero(np.isnan(gauge)).tolist() == list(range(1000, 1300))
        (begins,) = {int(np.flatnonzero(~np.isnan(x))[0]) for x in bus}
        assert begins == 1001  # the first sample at or behind 2.0005 s


def test_clock_and_units_that_csv_can_misread_are_kept(tmp_path):
    """A clock that began at 12.5 s; a name that ends like a unit; a comma in a name."""
    rng = np.random.default_rng(4)
    made = recording_from_arrays(
        rng.standard_normal((3, 900)), rate=204.8, names=["S1 [MPa]", "a, b", "torque / Nm"],
        units=["", "µm/m", ""],
    )  # fmt: skip
    object.__setattr__(made, "clock_start", 12.5)
    for chunks, name in ((csv_chunks, "a.csv"), (parquet_chunks, "a.parquet")):
        (tmp_path / name).write_bytes(b"".join(chunks(made)))
        found = open_recording(tmp_path / name)
        assert [(c.name, c.unit) for c in found.channels] == [
            ("S1 [MPa]", ""), ("a, b", "µm/m"), ("torque / Nm", "")
        ]  # fmt: skip
        assert found.clock_start == 12.5
        assert found.rate == pytest.approx(204.8, rel=1e-9)
        np.testing.assert_array_equal(found.read_all(), made.read_all())


def test_rpc_keeps_units_and_rate_within_16_bits(tmp_path):
    known.hdf5(tmp_path / "a.h5")
    told = run(tmp_path / "a.h5", tmp_path / "a.rsp", code=2)
    assert "S1 has no value at sample 1001: a test rig cannot follow it" in told
    assert not (tmp_path / "a.rsp").exists()
    run(tmp_path / "a.h5", tmp_path / "a.rsp", "--group", "can", "--channel", "torque")
    found = open_recording(tmp_path / "a.rsp")
    assert [(c.name, c.unit) for c in found.channels] == [("torque", "Nm")]
    assert found.rate == pytest.approx(10, rel=1e-6)
    np.testing.assert_allclose(found.read_all()[0], known.TORQUE, atol=400 / 65504)
    assert b"RESPONSE" in (tmp_path / "a.rsp").read_bytes()[:2048]


def test_output_is_never_half_written_nor_written_over(tmp_path, monkeypatch):
    source, out = tmp_path / "a.csv", tmp_path / "b.parquet"
    known.csv(source)
    out.write_text("mine")
    assert "is there already" in run(source, out, code=2)
    assert out.read_text() == "mine"
    late = known.WHOLE.copy()
    late[4000] = np.inf
    scipy.io.savemat(tmp_path / "a.mat", {"Fs": 500.0, "S1": late})
    monkeypatch.setattr(recording_writer, "PARQUET_VALUES_PER_CHUNK", 2000)
    assert "S1 has an infinite value" in run(tmp_path / "a.mat", out, "--force", code=2)
    assert out.read_text() == "mine"
    assert sorted(p.name for p in tmp_path.iterdir()) == ["a.csv", "a.mat", "b.parquet"]
    run(source, out, "--force")
    assert open_recording(out).names == ("S1", "speed", "torque")
    assert "OUT would write over the file that is read" in run(source, source, "--force", code=2)
    assert "a recording is written as .parquet, .csv" in run(source, tmp_path / "b.mf4", code=2)
    assert "did you mean 'speed'" in run(source, out, "--channel", "sped", code=2)


@pytest.mark.parametrize("chunks", [csv_chunks, parquet_chunks])
def test_conversion_holds_few_chunks(monkeypatch, chunks):
    """A megabyte of samples, two of text, pass in chunks of a thousand values."""
    monkeypatch.setattr(recording_writer, "CSV_VALUES_PER_CHUNK", 1 << 10)
    monkeypatch.setattr(recording_writer, "PARQUET_VALUES_PER_CHUNK", 1 << 10)
    whole = np.random.default_rng(1).standard_normal((4, 1 << 10))

    channels = tuple(Channel(f"S{k}", "MPa") for k in range(4))

    def written(blocks):
        def read(places):
            yield from (whole[list(places)] for _ in range(blocks))

        made = Recording(name="long", channels=channels, rate=1000.0, read=read)
        return sum(map(len, chunks(made)))

    written(1)  # what it imports is not counted
    tracemalloc.start()
    count = written(30)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert count > 500e3
    assert peak < 400e3


@pytest.mark.parametrize("chunks", [csv_chunks, parquet_chunks])
def test_what_no_table_holds_is_refused(chunks):
    def made(name, value=1.0):
        return recording_from_arrays(np.full((1, 8), value), rate=10.0, names=[name])

    with pytest.raises(DesignError, match="'Time_ms' would be taken for the time"):
        list(chunks(made("Time_ms")))
    with pytest.raises(DesignError, match="S1 has an infinite value"):
        list(chunks(made("S1", np.inf)))
