"""Universal files: datasets 58 of time histories, as text and binary."""

import numpy as np
import pytest

from cardan.core.errors import InvalidFileError
from cardan.physics.signals.recording import Channel
from cardan.readers import uff
from cardan.readers.dispatch import open_recording

N, RATE = 1003, 1024.0
T = np.arange(N) / RATE
X = np.round(200 * np.sin(2 * np.pi * 9 * T), 1)


def rows_of(values, widths, digits):
    return "".join(
        "".join(f"{v:{w}.{d}E}" for v, w, d in zip(row, widths, digits, strict=False)) + "\n"
        for row in (values[k : k + len(widths)] for k in range(0, len(values), len(widths)))
    )


def dataset(
    x, *, name="S1", unit="MPa", kind=1, ordinate=4, time=None, start=0.0, step=1 / RATE, axis=17,
    axis_unit="s", node=3, direction=-3, binary="", form=2, stated=None, count=None,
):  # fmt: skip
    """A dataset 58: with times an uneven one; binary is the kind of its numbers, <f8 say."""
    values = x if time is None else np.stack([time, x], axis=-1).ravel()
    even = time is None
    head = "    -1\n    58"
    if binary:
        parts = [binary] if even else [binary[0] + k for k in binary[1:].split("+")]
        stored = np.rec.fromarrays([x] if even else [time, x], dtype=[
            (f"f{k}", part) for k, part in enumerate(parts)])  # fmt: skip
        data = stored.tobytes()
        size = len(data) if stated is None else stated
        order = 1 if binary[0] == "<" else 2
        head += f"b{order:6d}{form:6d}{11:12d}{size:12d}{0:6d}{0:6d}{0:12d}{0:12d}"
    else:
        single, uneven_double = ((13,) * 6, (5,) * 6), ((13, 20, 13, 20), (5, 11, 5, 11))
        even_double = ((20,) * 4, (11,) * 4)
        how = single if ordinate == 2 else even_double if even else uneven_double
        data = rows_of(values, *how).encode()
    lines = [
        head, name, "NONE", "28-Nov-26 10:00:00", "NONE", "NONE",
        f"{kind:5d}{0:10d}{0:5d}{0:10d} {'NONE':10s}{node:10d}{direction:4d} {'NONE':10s}"
        f"{0:10d}{0:4d}",
        f"{ordinate:10d}{len(x) if count is None else count:10d}{int(even):10d}"
        f"{start if even else 0:13.5E}{step if even else 0:13.5E}{0:13.5E}",
        f"{axis:10d}{0:5d}{0:5d}{0:5d} {'Time':20s} {axis_unit:20s}",
        f"{2:10d}{0:5d}{0:5d}{0:5d} {'Stress':20s} {unit:20s}",
        *[f"{0:10d}{0:5d}{0:5d}{0:5d} {'NONE':20s} {'NONE':20s}"] * 2,
    ]  # fmt: skip
    return "\n".join(lines).encode() + b"\n" + data + b"    -1\n"


UNITS = b"    -1\n   164\n         1Meter (newton)         2\n  1.0D+00  1.0D+00  1.0D+00\n    -1\n"


@pytest.mark.parametrize(
    ("ordinate", "binary"),
    [(2, ""), (4, ""), (2, "<f4"), (4, "<f8"), (4, ">f8")],
)
@pytest.mark.parametrize("at_once", [uff.TEXT_BYTES_READ_AT_ONCE, 1000])
def test_even_functions_are_read(tmp_path, monkeypatch, ordinate, binary, at_once):
    monkeypatch.setattr("cardan.readers.uff.TEXT_BYTES_READ_AT_ONCE", at_once)
    how = {"ordinate": ordinate, "binary": binary}
    data = UNITS + dataset(X, **how) + dataset(-2 * X, name="speed", unit="rpm", **how)
    (tmp_path / "a.dat").write_bytes(data)
    recording = open_recording(tmp_path / "a.dat")
    assert recording.rate == RATE
    assert recording.channels == (Channel("S1", "MPa"), Channel("speed", "rpm"))
    both = np.stack([X, -2 * X])
    np.testing.assert_allclose(recording.read_all(), both, rtol=1e-7 if ordinate == 2 else 1e-15)


def test_values_match_pyuff(tmp_path):
    """What pyuff 2.5.0 reads of these datasets, at places 0, 1, 17, 500 and 1002."""
    read_by_pyuff = {
        (4, ""): [0.0, 11.0, 161.4, 123.0, -187.5],
        (2, "<f4"): [0.0, 11.0, 161.39999389648438, 123.0, -187.5],
        (4, ">f8"): [0.0, 11.0, 161.4, 123.0, -187.5],
    }
    for (ordinate, binary), values in read_by_pyuff.items():
        (tmp_path / "a.uff").write_bytes(dataset(X, ordinate=ordinate, binary=binary))
        found = open_recording(tmp_path / "a.uff").read_all()[0]
        assert found[[0, 1, 17, 500, 1002]].tolist() == values


def test_doubles_behind_a_head_that_says_single_are_rejected(tmp_path):
    """pyuff 2.5.0 writes them so with force_double=False, and reads twice as many numbers back."""
    data = dataset(X, binary="<f8", stated=4 * N).replace(
        f"{4:10d}{N:10d}".encode(), f"{2:10d}{N:10d}".encode()
    )
    (tmp_path / "a.uff").write_bytes(data)
    refused(tmp_path / "a.uff", "claims what is not there.*1003 values, 4012 bytes stated, 8031 to")


@pytest.mark.parametrize(
    ("ordinate", "binary"),
    [(2, ""), (4, ""), (2, "<f4+f4"), (4, "<f4+f8"), (4, "<f8+f8")],
)
def test_uneven_function_has_its_own_clock(tmp_path, ordinate, binary):
    """Abscissae are single by the format; pyuff 2.5 writes double, and states half the bytes."""
    stated = 8 * N if binary == "<f8+f8" else None
    time = T + 2
    first = dataset(X, time=time, ordinate=ordinate, binary=binary, stated=stated)
    (tmp_path / "a.uff").write_bytes(first + dataset(3 * X, name="S2", start=2.0))
    recording = open_recording(tmp_path / "a.uff")
    assert recording.rate == pytest.approx(RATE, rel=1e-3)
    found = recording.read_all(["S1", "S2"])[:, 5:900]
    np.testing.assert_allclose(found[1], 3 * found[0], atol=8)


def test_functions_lie_where_their_abscissa_begins(tmp_path):
    first, later = dataset(X), dataset(X, name="S2", start=0.5)
    (tmp_path / "a.uff").write_bytes(first + later)
    both = open_recording(tmp_path / "a.uff").read_all()
    assert np.flatnonzero(~np.isnan(both[1]))[0] == 512
    in_ms = dataset(X, step=1e3 / RATE, axis_unit="ms")
    (tmp_path / "a.uff").write_bytes(in_ms)
    assert open_recording(tmp_path / "a.uff").rate == pytest.approx(RATE, rel=1e-6)


def test_what_is_no_time_history_is_left_out_with_note(tmp_path):
    spectrum = dataset(X, name="FRF", kind=4, axis=18, axis_unit="Hz", ordinate=4)
    same = dataset(X, name="S1", direction=1)
    (tmp_path / "a.uff").write_bytes(spectrum + dataset(X) + same)
    recording = open_recording(tmp_path / "a.uff")
    assert recording.names == ("S1 3-Z", "S1 3+X")
    assert "no time histories, left out: 1 frequency response" in recording.notes
    (tmp_path / "a.uff").write_bytes(spectrum + UNITS)
    refused(tmp_path / "a.uff", "no time history .dataset 58. in it; no time.*1 frequency response")
    (tmp_path / "a.uff").write_bytes(UNITS)
    refused(tmp_path / "a.uff", "no time history .dataset 58. in it; it has datasets 164")


def test_numbers_of_fortran_that_touch_are_read(tmp_path):
    x = np.array([-1.5e-100, -2.5e-101, 3.0, 4e9, -5.0, -6e-200, 7.0])
    data = dataset(x, ordinate=2)
    assert b"-1.50000E-100-2.50000E-101" in data
    (tmp_path / "a.uff").write_bytes(data.replace(b"4.00000E+09", b"4.00000D+09"))
    np.testing.assert_allclose(open_recording(tmp_path / "a.uff").read_all()[0], x, rtol=1e-9)


def refused(path, match):
    with pytest.raises(InvalidFileError, match=match):
        open_recording(path).read_all()


REFUSED = {
    "no recording has such a sample rate.*e.12 Hz": dataset(X, step=1e-12),
    "the step of S1 must be above 0": dataset(X, step=0.0),
    "the axis of its samples is no time: rpm": dataset(X, axis=19, axis_unit="rpm"),
    "unknown unit of the time of S1.*furlong": dataset(X, axis_unit="furlong"),
    "dataset 1 states values that cannot be true.*type 9, 1003": dataset(X, ordinate=9),
    "it is damaged: of 99999999 rows it holds|claims more samples": dataset(X, count=99999999),
    "of 1500 rows it holds 1003": dataset(X, count=1500),
    "dataset 1 holds more values than it states": dataset(X, count=900),
    "1500 values, 8024 bytes stated": dataset(X, count=1500, binary="<f8"),
    "900 values, 8024 bytes stated": dataset(X, count=900, binary="<f8"),
    "byte order 1, floating point 3": dataset(X, binary="<f8", form=3),
    "the file is cut short: a dataset has no end.*dataset 1": dataset(X)[:-4],
    "dataset 2, at 37584 bytes": dataset(X) + dataset(X)[:-4000],
    "dataset 1: 1003 values, 8024 bytes stated, 7": dataset(X, binary="<f8")[:-400],
    "holds no number where one is due.*nonsense": dataset(X).replace(b"1.1", b"nonsense", 1),
    "a field of its head is no number.*x1": dataset(X).replace(b"         1 ", b"        x1 ", 1),
}


@pytest.mark.parametrize("match", REFUSED)
def test_file_that_contradicts_itself_is_rejected(tmp_path, match):
    (tmp_path / "a.uff").write_bytes(REFUSED[match])
    refused(tmp_path / "a.uff", match)
