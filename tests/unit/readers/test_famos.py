"""imc FAMOS files: by imctermite in a child process, once their keys hold what they claim."""

import sys

import numpy as np
import pytest

from cardan.core.errors import InvalidFileError
from cardan.physics.signals.recording import Channel
from cardan.readers.dispatch import open_recording

N, RATE = 500, 200.0
X = np.round(50 * np.sin(np.arange(N) / 9), 3)


def key(name, *fields, version=1):
    body = b",".join(f if isinstance(f, bytes) else str(f).encode() for f in fields)
    return f"|{name},{version},{len(body)},".encode() + body + b";"


def channel(
    number, name, x, *, unit="MPa", step=1 / RATE, step_unit="s", offset=0.0, x0="0.0",
    factor=None, claimed=None, trigger=0.0,
):  # fmt: skip
    """The keys of a channel: doubles, or 16-bit numbers by a factor."""
    kind, bits, dtype = (8, 64, "<f8") if factor is None else (4, 16, "<i2")
    raw = np.asarray(x if factor is None else np.rint(x / factor)).astype(dtype).tobytes()
    size = len(raw) if claimed is None else claimed
    return b"".join([
        key("CG", 1, 1, 1),
        key("CD", f"{step:.16E}", 1, len(step_unit), step_unit, 0, 0, 0, x0, 1, version=2),
        key("NT", 1, 1, 2020, 0, 0, trigger), key("CC", 1, 1),
        key("CP", number, bits // 8, kind, bits, 0, 0, 1, 0),
        key("CR", int(factor is not None), factor or 1.0, 0.0, 1, len(unit), unit),
        key("CN", 0, 0, 0, len(name), name, 0, ""),
        key("Cb", 1, 0, number, number, 0, size, 0, size, 1, offset, 0.0, ""),
        key("CS", number, raw),
    ])  # fmt: skip


HEAD = b"|CF,2,1,1;|CK,1,3,1,1;"


def refused(path, data, match):
    path.write_bytes(data)
    with pytest.raises(InvalidFileError, match=match):
        open_recording(path).read_all()


def test_channels_are_read_with_unit_step_and_start(tmp_path):
    pytest.importorskip("imctermite")
    data = HEAD + channel(1, "S1", X) + channel(2, "speed", 900 + X, unit="rpm", offset=0.5)
    (tmp_path / "a.dat").write_bytes(data + channel(3, "T", X[:50] * 0 + 25, unit="V", step=0.05,
                                                    factor=0.5))  # fmt: skip
    recording = open_recording(tmp_path / "a.dat")
    assert recording.rate == RATE
    assert recording.channels == (
        Channel("S1", "MPa"), Channel("speed", "rpm"), Channel("T", "V")
    )  # fmt: skip
    first, speed, slow = recording.read_all()
    np.testing.assert_array_equal(first[:N], X)
    assert np.flatnonzero(~np.isnan(speed))[0] == 100
    np.testing.assert_array_equal(speed[100:], 900 + X)
    np.testing.assert_array_equal(slow[:400], 25)


def test_axis_of_famos_that_is_no_time_is_rejected(tmp_path):
    pytest.importorskip("imctermite")
    (tmp_path / "a.raw").write_bytes(HEAD + channel(1, "S1", X, step_unit="deg"))
    with pytest.raises(InvalidFileError, match="the axis of its samples is no time: deg"):
        open_recording(tmp_path / "a.raw")
    refused(tmp_path / "a.raw", HEAD + channel(1, "S1", X, step=0.0), "the step of S1 must be abov")
    refused(
        tmp_path / "a.raw", HEAD + channel(1, "S1", X, step=1e-12), "no recording has such a sample"
    )


def test_keys_of_famos_that_claim_what_is_not_there_are_rejected(tmp_path, monkeypatch):
    """imctermite 3.0.0 returns as many samples as are claimed, and reads behind the end for them.

    So it is not asked: a file that is cut off is refused by its keys alone.
    """
    monkeypatch.setattr("cardan.readers.famos.find_spec", lambda _: sys)
    monkeypatch.setattr("cardan.readers.famos.call_in_subprocess", lambda *_, **__: 1 / 0)
    whole, path = HEAD + channel(1, "S1", X), tmp_path / "a.raw"
    refused(path, whole[:-2000], "key CS claims 4002 bytes, 2003 are there")
    refused(path, whole[:190], "key C. claims|no key of FAMOS where one is due")
    refused(path, HEAD + channel(1, "S1", X, claimed=10**9), "buffer of 1000000000 bytes.* in 4000")
    refused(path, whole.replace(b"|CC", b"?CC"), "no key of FAMOS where one is due")
    both = whole + channel(2, "S2", X, x0="0.5")
    refused(path, both, "its channels begin at several x0.*0.0, 0.5")


def test_missing_library_is_named_with_its_extra(tmp_path, monkeypatch):
    monkeypatch.setattr("cardan.readers.famos.find_spec", lambda _: None)
    match = r"reading it needs imctermite3; pip install 'cardan\[famos\]'"
    refused(tmp_path / "a.raw", HEAD + channel(1, "S1", X), match)
