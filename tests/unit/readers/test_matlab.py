"""MATLAB files of level 5 and 7.3: vectors, matrices, structs; SciPy and h5py write them here."""

import struct

import h5py
import numpy as np
import pytest
import scipy.io

from cardan.core.errors import InvalidFileError
from cardan.physics.signals.recording import Channel
from cardan.readers.dispatch import open_recording

N, RATE = 500, 200.0
T = np.arange(N) / RATE
X = 50 * np.sin(2 * np.pi * 5 * T)


def level_5(path, variables):
    scipy.io.savemat(path, variables)


def level_5_packed(path, variables):
    scipy.io.savemat(path, variables, do_compression=True, oned_as="column")


def level_7_3(path, variables):
    with h5py.File(path, "w", userblock_size=512) as file:
        refs = file.create_group("#refs#")

        def put(home, name, value):
            if isinstance(value, dict):
                group = home.create_group(name)
                group.attrs["MATLAB_class"] = np.bytes_("struct")
                for key, field in value.items():
                    put(group, key, field)
            elif isinstance(value, np.ndarray) and value.dtype == object:
                data = np.empty((value.size, 1), h5py.ref_dtype)
                for k, part in enumerate(value.ravel()):
                    data[k, 0] = put(refs, f"r{len(refs)}", part).ref
                item = home.create_dataset(name, data=data, dtype=h5py.ref_dtype)
                item.attrs["MATLAB_class"] = np.bytes_("cell")
            elif isinstance(value, str):
                item = home.create_dataset(name, data=np.array([[ord(c)] for c in value], "u2"))
                item.attrs["MATLAB_class"] = np.bytes_("char")
            else:
                value = np.atleast_2d(value)
                item = home.create_dataset(name, data=value.T)
                item.attrs["MATLAB_class"] = np.bytes_("double")
            return home[name]

        for key, value in variables.items():
            put(file, key, value)
    head = b"MATLAB 7.3 MAT-file, Platform: GLNXA64".ljust(124) + b"\x00\x02IM"
    with path.open("r+b") as file:
        file.write(head.ljust(512, b"\0"))


LEVELS = pytest.mark.parametrize("write", [level_5, level_5_packed, level_7_3])
CELL = np.empty(2, object)
CELL[:] = ["S1", "speed"]
UNITS = np.empty(2, object)
UNITS[:] = ["MPa", "rpm"]
BOTH = np.stack([X, 900 + T], axis=1)

WAYS = {
    "vectors and a time vector": {"time": T, "S1": X, "speed": BOTH[:, 1]},
    "vectors and a rate": {"Fs": RATE, "S1": X, "speed": BOTH[:, 1:]},
    "vectors and a step": {"dt": 1 / RATE, "S1": X, "speed": BOTH[:, 1]},
    "matrix and names": {"t": T, "data": BOTH, "names": CELL, "units": UNITS},
    "matrix of rows": {"time": T[None], "data": BOTH.T, "labels": CELL},
    "struct": {"run": {"Time": T, "S1": X, "speed": BOTH[:, 1],
                       "units": {"S1": "MPa", "speed": "rpm"}}},
    "structs of a rate each": {"run": {"S1": X, "speed": BOTH[:, 1], "SampleRate": RATE,
                                       "S1_unit": "MPa"}, "other": {"SampleRate": 7.0}},
    "Simulink": {"out": {"time": T, "signals": np.array([
        {"values": X, "label": "S1", "unit": "MPa"}, {"values": BOTH[:, 1], "label": "speed"}])}},
}  # fmt: skip


@pytest.mark.parametrize("way", WAYS)
@LEVELS
def test_usual_layouts_are_read(tmp_path, write, way):
    if write is level_7_3 and way == "Simulink":
        # Of an array of structs each field is a dataset of references.
        values, labels = np.empty(2, object), np.empty(2, object)
        values[:], labels[:] = [X, BOTH[:, 1]], ["S1", "speed"]
        signals = {"values": values, "label": labels, "unit": UNITS}
        level_7_3(tmp_path / "a.dat", {"out": {"time": T, "signals": signals}})
        with h5py.File(tmp_path / "a.dat", "r+") as file:
            for item in file["out/signals"].values():
                del item.attrs["MATLAB_class"]
    else:
        write(tmp_path / "a.dat", WAYS[way])
    recording = open_recording(tmp_path / "a.dat")
    assert recording.names == ("S1", "speed")
    assert recording.rate == RATE
    assert recording.channel("S1").unit == ("MPa" if "unit" in repr(WAYS[way]) else "")
    np.testing.assert_allclose(recording.read_all(), BOTH.T, rtol=1e-12)


@LEVELS
def test_structs_of_two_rates_lie_where_they_begin(tmp_path, write):
    slow = {"speed": 900 + np.arange(100.0), "fs": 50.0, "t0": 10.5}
    write(tmp_path / "a.mat", {"fast": {"S1": X, "fs": RATE, "t0": 10.0}, "bus": slow})
    recording = open_recording(tmp_path / "a.mat")
    assert recording.rate == RATE
    first, speed = recording.read_all(["S1", "speed"])
    np.testing.assert_allclose(first[:N], X, rtol=1e-12)
    assert np.flatnonzero(~np.isnan(speed))[0] == 100
    assert speed[100] == 900
    bus = open_recording(tmp_path / "a.mat", group="bus")
    assert (bus.rate, bus.names) == (50.0, ("speed",))


def test_time_in_days_is_known_by_its_size(tmp_path):
    """datenum(2026, 11, 28) is 740314: one second is 1/86400 of it."""
    level_5(tmp_path / "a.mat", {"time": 740314.25 + np.arange(N) / 86400, "S1": X})
    recording = open_recording(tmp_path / "a.mat")
    assert recording.rate == pytest.approx(1, rel=1e-4)
    np.testing.assert_array_equal(recording.read_all()[0], X)
    assert "time counts days as MATLAB does (datenum), by its size" in recording.notes


@LEVELS
def test_what_cannot_be_read_is_listed(tmp_path, write):
    write(tmp_path / "a.mat", {"note": "hello", "c": {"k": 3.0}})
    with pytest.raises(InvalidFileError, match=r"no series of numbers in it; it has .*c\.k 1x1"):
        open_recording(tmp_path / "a.mat")
    write(tmp_path / "b.mat", {"time": T, "S1": X, "cube": np.ones((3, 4, 5)), "z": 1j * X})
    recording = open_recording(tmp_path / "b.mat")
    assert recording.channels == (Channel("S1"),)
    said = "; ".join(recording.notes)
    assert "not numbers, left out: z 1x500" in said or "not numbers, left out: z 500x1" in said
    assert "more than one number a sample, left out: cube 3x4x5 double" in said


@LEVELS
def test_rate_that_is_missing_or_absurd_is_rejected(tmp_path, write):
    write(tmp_path / "a.mat", {"S1": X})
    with pytest.raises(InvalidFileError, match="nothing says how fast"):
        open_recording(tmp_path / "a.mat")
    assert open_recording(tmp_path / "a.mat", rate=9.0).rate == 9
    for rate, why in ((0.0, "must be above 0"), (1e12, "no recording has such a sample rate")):
        write(tmp_path / f"{rate}.mat", {"S1": X, "fs": rate})
        with pytest.raises(InvalidFileError, match=why):
            open_recording(tmp_path / f"{rate}.mat")


def test_timetable_object_is_listed_by_its_name_and_class(tmp_path):
    """What only MATLAB can read: class 17, then name, type system and class as texts."""

    def element(kind, data):
        return struct.pack("<2I", kind, len(data)) + data + bytes(-len(data) % 8)

    inner = [element(6, struct.pack("<2I", 17, 0)), element(1, b"tt"), element(1, b"MCOS"),
             element(1, b"timetable"), element(14, b"")]  # fmt: skip
    head = b"MATLAB 5.0 MAT-file".ljust(124) + b"\x00\x01IM"
    (tmp_path / "a.mat").write_bytes(head + element(14, b"".join(inner)))
    with pytest.raises(InvalidFileError, match="no series of numbers in it; it has tt timetable"):
        open_recording(tmp_path / "a.mat")


@pytest.mark.parametrize("kind", ["int8", "uint16", "int32", "float32", "int64", "bool"])
def test_level_5_numbers_are_those_of_scipy(tmp_path, kind):
    """MATLAB stores numbers in the smallest kind that holds them, SciPy reads them back."""
    x = (np.arange(N) % 100).astype(kind)
    level_5_packed(tmp_path / "a.mat", {"time": T, "x": x})
    by_scipy = scipy.io.loadmat(tmp_path / "a.mat")["x"].ravel()
    np.testing.assert_array_equal(open_recording(tmp_path / "a.mat").read_all()[0], by_scipy)


def test_variable_that_unpacks_to_far_more_is_rejected(tmp_path):
    level_5_packed(tmp_path / "a.mat", {"time": np.zeros(9_000_000), "x": X})
    with pytest.raises(InvalidFileError, match="unpacks to more than a recording does"):
        open_recording(tmp_path / "a.mat")
