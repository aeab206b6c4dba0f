"""RPC III: layout and scale of the format, whoever wrote the file; and a drive file written."""

import re

import numpy as np
import pytest

import cardan
from cardan.core.errors import DesignError, InvalidFileError
from cardan.physics.signals.recording import Channel
from cardan.readers.dispatch import open_recording
from cardan.readers.rpc import MAX_GROUP_BYTES_READ_AT_ONCE

N = 300
T = np.arange(N) / 256
STORED = np.stack([np.rint(30000 * np.sin(T)), np.arange(N) - 20, np.rint(900 * np.cos(9 * T))])


def header(junk=b"", **keys):
    """A header, None taking a key out."""
    keys = {k.replace("__", "."): v for k, v in keys.items()}
    known = {
        "FORMAT": "BINARY_IEEE_LITTLE_END", "NUM_HEADER_BLOCKS": "", "NUM_PARAMS": "",
        "FILE_TYPE": "TIME_HISTORY", "DATA_TYPE": "SHORT_INTEGER", "DELTA_T": "3.906250E-03",
        "CHANNELS": "3", "PTS_PER_FRAME": "32", "PTS_PER_GROUP": "128", "FRAMES": "10",
        "INT_FULL_SCALE": "32752", "DESC.CHAN_1": '"bracket left"', "UNITS.CHAN_1": "MPa",
        "SCALE.CHAN_1": "5.000000E-03", "DESC.CHAN_3": "c", "UNITS.CHAN_3": "",
        "DESC.CHAN_2": "n", "UNITS.CHAN_2": "rpm",
        "SCALE.CHAN_2": "1.0", "SCALE.CHAN_3": "-2.5E-1",
        **{f"{side}_LIMIT.CHAN_{k}": "1.0" for side in ("UPPER", "LOWER") for k in (1, 2, 3)},
        **keys,
    }  # fmt: skip
    known = {k: v for k, v in known.items() if v is not None}
    blocks = -(-len(known) // 4)
    known["NUM_HEADER_BLOCKS"] = known["NUM_HEADER_BLOCKS"] or str(blocks)
    known["NUM_PARAMS"] = known["NUM_PARAMS"] or str(len(known))
    records = [
        k.encode() + b"\0" * (32 - len(k)) + (v.encode() + junk).ljust(96, b"\0")
        for k, v in known.items()
    ]
    return b"".join(records).ljust(512 * blocks, b"\0")


def groups(stored, points=128, kind="<i2", filling=0):
    stored = np.pad(stored, ((0, 0), (0, -stored.shape[1] % points)), constant_values=filling)
    each = stored.reshape(len(stored), -1, points).astype(kind)
    return np.ascontiguousarray(np.moveaxis(each, 1, 0)).tobytes()


def write(path, *, data=None, **keys):
    path.write_bytes(header(**keys) + (groups(STORED) if data is None else data))
    return path


@pytest.mark.parametrize(
    ("kind", "keys", "scale"),
    [
        ("<i2", {}, [5e-3, 1, -0.25]),
        ("<i2", {"FORMAT": "BINARY", "INT_FULL_SCALE": None, "DATA_TYPE": None}, [5e-3, 1, -0.25]),
        (">i2", {"FORMAT": "BINARY_IEEE_BIG_END"}, [5e-3, 1, -0.25]),
        ("<f4", {"DATA_TYPE": "FLOATING_POINT"}, [1, 1, 1]),
        ("<f8", {"DATA_TYPE": "DOUBLE_PRECISION", "SCALE__CHAN_1": "1.0"}, [1, 1, 1]),
    ],
)
@pytest.mark.parametrize("at_once", [MAX_GROUP_BYTES_READ_AT_ONCE, 1])
def test_groups_of_several_frames_are_read(tmp_path, monkeypatch, kind, keys, scale, at_once):
    """The third group is filled up with 84 zeros: 20 in its last frame and two frames more."""
    monkeypatch.setattr("cardan.readers.rpc.MAX_GROUP_BYTES_READ_AT_ONCE", at_once)
    # What stands behind the NUL of a C string is left over from another one.
    keys = {"DESC__CHAN_3": None, "junk": b"\0left over", **keys}
    path = write(tmp_path / "a.dat", data=groups(STORED, kind=kind), **keys)
    recording = open_recording(path)
    assert recording.rate == 256
    assert recording.channels == (
        Channel("bracket left", "MPa"), Channel("n", "rpm"), Channel("channel 3")
    )  # fmt: skip
    np.testing.assert_array_equal(recording.read_all(), STORED * np.array(scale)[:, None])
    np.testing.assert_array_equal(recording.read_all(["n"]), STORED[1:2])
    filled = "its last 20 samples stand still in all channels and are left out as filling"
    assert filled in recording.notes
    assert any("not applied" in n for n in recording.notes) == ("f" in kind)


def test_scale_alone_gives_the_value(tmp_path):
    """A file of nCode states the largest value of its first channel.

    SignalExample.rsp of RPC3.js (MIT): SCALE.CHAN_1 7.088956E-03, neither INT_FULL_SCALE nor
    DATA_TYPE, samples up to 32767; NCODE_STAT1_CHAN_1 says 232.29092, one step more. By
    32752/32768 of it, as rpc-reader 0.9 has it, it were 232.17.
    """
    stored = np.stack([np.append(np.arange(127), 32767)] * 3)
    path = write(
        tmp_path / "a.rsp", data=groups(stored), FRAMES="4", INT_FULL_SCALE=None, DATA_TYPE=None,
        SCALE__CHAN_1="7.088956E-03",
    )  # fmt: skip
    assert open_recording(path).read_all()[0, -1] == pytest.approx(232.29092, abs=7.1e-3)


def test_samples_match_rpc3_file(tmp_path):
    """What rpc3-file 1.0.0rc6 reads of this file at some places, as float32.

    It keeps one zero of the filling as sample 301. rpc-reader 0.9 reads 32752/32768 of each value,
    and from sample 256 on other channels': it takes the last group for shorter than the others.
    """
    found = open_recording(write(tmp_path / "a.rsp")).read_all()
    read_by_rpc3_file = [
        [0.0, 18.1200008392334, 18.700000762939453, 71.4000015258789, 71.91500091552734,
         125.90499877929688, 126.22000122070312, 137.9949951171875],
        [-20.0, 11.0, 12.0, 107.0, 108.0, 235.0, 236.0, 279.0],
        [-225.0, -104.0, -97.0, 55.25, 47.5, 201.5, 205.0, 104.75],
    ]  # fmt: skip
    places = [0, 31, 32, 127, 128, 255, 256, 299]
    np.testing.assert_allclose(found[:, places], read_by_rpc3_file, rtol=1e-7)


def test_filling_of_the_last_group(tmp_path):
    def read(data, **keys):
        return open_recording(write(tmp_path / "a.rsp", data=data, **keys))

    repeated = np.pad(STORED, ((0, 0), (0, 84)), mode="edge")
    whole = {"FRAMES": "12"}
    for data in (groups(repeated), groups(STORED)):
        recording = read(data, **whole)
        assert recording.samples == N
        assert "its last 84 samples" in recording.notes[0]
    assert read(groups(repeated), **whole, SAMPLES="310").samples == 310
    # What stands still for a group and longer, and what one channel alone does, is recorded so.
    still = np.pad(STORED, ((0, 0), (0, 212)), mode="edge")
    assert read(groups(still), FRAMES="16").samples == 512
    moving = repeated.copy()
    moving[1, -1] += 1
    recording = read(groups(moving), **whole)
    assert (recording.samples, recording.notes) == (384, ())


REFUSED = {
    "its FORMAT is not read.*ASCII": {"FORMAT": "ASCII"},
    "it holds no time history.*MATRIX": {"FILE_TYPE": "MATRIX"},
    "half a frame without data": {"HALF_FRAMES": "1"},
    "its DELTA_T must be above 0.*-1": {"DELTA_T": "-1"},
    "its DELTA_T is not a number.*fast": {"DELTA_T": "fast"},
    "no recording has such a sample rate.*1e.12 Hz": {"DELTA_T": "1E-12"},
    "its header has no DELTA_T": {"DELTA_T": None},
    "its header has no SCALE.CHAN_3": {"SCALE__CHAN_3": None},
    "its SCALE.CHAN_3 cannot be true.*nan": {"SCALE__CHAN_3": "nan"},
    "its CHANNELS cannot be true.*2.5.; 1 to": {"CHANNELS": "2.5"},
    "its CHANNELS cannot be true.*99999": {"CHANNELS": "99999"},
    "its NUM_HEADER_BLOCKS cannot be true.*-2": {"NUM_HEADER_BLOCKS": "-2"},
    "its header is cut short.*of 204800 bytes": {"NUM_HEADER_BLOCKS": "400"},
    "its NUM_PARAMS cannot be true.*100": {"NUM_PARAMS": "100"},
    "no whole number of frames.*128, PTS_PER_FRAME 48": {"PTS_PER_FRAME": "48"},
    "its DATA_TYPE is not read.*LONG": {"DATA_TYPE": "LONG"},
    "2304 of 4608 bytes of samples are there: 1 of 3 groups": {"DATA_TYPE": "FLOATING_POINT"},
    "of 768000000000 bytes .*: 3 of 1000000000 groups": {"FRAMES": "4000000000"},
    "more groups of samples than its header says.*3 and 2": {"FRAMES": "8"},
    "its SAMPLES cannot be true.*400.; 1 to 320": {"SAMPLES": "400"},
}


@pytest.mark.parametrize("match", REFUSED)
def test_header_that_cannot_be_true_is_rejected(tmp_path, match):
    write(tmp_path / "a.rsp", **REFUSED[match])
    with pytest.raises(InvalidFileError, match=match):
        open_recording(tmp_path / "a.rsp")


def test_truncated_file_is_rejected_with_what_is_there(tmp_path):
    whole = write(tmp_path / "a.rsp").read_bytes()
    for left, match in (
        (300, "its header is cut short.*300 of 512"),
        (len(whole) - 2, "2302 of 2304 bytes of samples are there: 2 of 3 groups"),
    ):
        (tmp_path / "a.rsp").write_bytes(whole[:left])
        with pytest.raises(InvalidFileError, match=match):
            open_recording(tmp_path / "a.rsp")


# --------------------------------------------------------------------------- drive files


def test_drive_file_is_read_back(tmp_path):
    time = np.arange(5000) / 204.8
    channels = {"force": 2e4 * np.sin(time) - 500, "µ strain": np.cos(7 * time), "zero": 0 * time}
    path = cardan.write_drive_file(
        tmp_path / "a.drv", channels, rate=204.8, units={"force": "N", "µ strain": "µε"}
    )
    recording = open_recording(path)
    assert (recording.rate, recording.samples, recording.notes) == (204.8, 5000, ())
    assert recording.channels == (
        Channel("force", "N"), Channel("µ strain", "ue"), Channel("zero", "")
    )  # fmt: skip
    for name, x in channels.items():
        step = np.abs(x).max() / 32752
        np.testing.assert_allclose(recording.read_all([name])[0], x, atol=0.5001 * step)
    # By the bytes: the largest number is 32752, and the scale says what it is worth.
    data = path.read_bytes()
    blocks = int(data[128 + 32 : 128 + 40].rstrip(b"\0"))
    records = re.findall(b"(?s)(.{32})(.{96})", data[: 512 * blocks])
    keys = {key.rstrip(b"\0"): value.rstrip(b"\0") for key, value in records}
    scale = float(keys[b"SCALE.CHAN_1"])
    assert scale == pytest.approx(20500 / 32752, rel=1e-4)
    stored = np.frombuffer(data[512 * blocks :], "<i2")
    assert stored.size == 3 * 3 * 2048
    assert (abs(stored).max(), stored[0]) == (32752, round(-500 / scale))


def test_drive_file_is_read_alike_by_rpc3_file(tmp_path):
    """What rpc3-file 1.0.0rc6 reads of this drive file at some places, as float32: 5000 samples."""
    t = np.arange(5000) / 204.8
    channels = {"S1": 100 * np.sin(2 * np.pi * 3 * t), "force": -5000 + 20 * np.cos(t)}
    path = cardan.write_drive_file(tmp_path / "a.rsp", channels, rate=204.8)
    read_by_rpc3_file = [
        [0.0, 9.19028, 18.304228, 99.996956, -9.19028, 0.0, 99.004654],
        [-4979.996, -4979.996, -4979.996, -4979.996, -5016.7817, -5016.7817, -4985.054],
    ]
    found = open_recording(path).read_all()
    assert found.shape == (2, 5000)
    places = [0, 1, 2, 17, 2047, 2048, 4999]
    np.testing.assert_allclose(found[:, places], read_by_rpc3_file, rtol=1e-7, atol=1e-6)


@pytest.mark.parametrize(
    ("channels", "match"),
    [
        ({"a": [1.0, np.nan]}, "a has no value at sample 2"),
        ({"a": [1.0], "b": [1.0, 2.0]}, "lists of one length"),
        ({"a": []}, "it holds no samples"),
        ({f"c{k}": [1.0] for k in range(129)}, "1 to 128 channels, got 129"),
        ({"力": [1.0]}, "has no letter '力'"),
        ({"x" * 96: [1.0]}, "up to 95 letters"),
    ],
)
def test_drive_file_that_the_format_cannot_hold_is_rejected(tmp_path, channels, match):
    with pytest.raises(DesignError, match=match):
        cardan.write_drive_file(tmp_path / "a.drv", channels, rate=100.0)
    assert not (tmp_path / "a.drv").exists()
