"""The same samples give the same damage from every format, and a damaged file ends in one line.

Formats that are read since they were added here: each is a function that writes a file.
"""

import time
import tracemalloc

import numpy as np
import pytest
from click.testing import CliRunner
from test_famos import HEAD, channel
from test_lvm import columns, file_head, segment
from test_matlab import CELL, UNITS, level_5, level_5_packed, level_7_3
from test_rpc import groups, header
from test_uff import dataset

from cardan.cli.life import life
from cardan.core.errors import CardanError
from cardan.readers.dispatch import open_recording

RATE = 1024.0
T = np.arange(4000) / RATE
STORED = np.stack([1000 * np.sin(2 * np.pi * 3 * T) + 300 * np.sin(50 * T**2), 2000 + 100 * T])
STORED = np.rint(STORED)
"""Whole numbers, so that each format holds them exactly: 0.1 MPa, and rpm."""
X = STORED * np.array([[0.1], [1.0]])


def csv(path):
    rows = "\n".join(
        f"{t!r},{a!r},{n!r}" for t, (a, n) in zip(T.tolist(), X.T.tolist(), strict=True)
    )
    path.write_text(f"time [s],S1 [MPa],speed [rpm]\n{rows}\n")


def rpc(path):
    head = header(
        CHANNELS="2", DELTA_T=f"{1 / RATE:.6E}", PTS_PER_FRAME="256", PTS_PER_GROUP="1024",
        FRAMES="16", SAMPLES="4000", DESC__CHAN_1="S1", UNITS__CHAN_1="MPa",
        SCALE__CHAN_1="1.000000E-01", DESC__CHAN_2="speed", UNITS__CHAN_2="rpm",
    )  # fmt: skip
    path.write_bytes(head + groups(STORED, points=1024))


def matlab_5(path):
    level_5(path, {"fs": RATE, "m": X.T, "names": CELL, "units": UNITS})


def matlab_5_packed(path):
    level_5_packed(path, {"run": {"time": T, "S1": X[0], "speed": X[1], "units": {
        "S1": "MPa", "speed": "rpm"}}})  # fmt: skip


def matlab_7_3(path):
    level_7_3(path, {"time": T, "data": X.T, "names": CELL, "units": UNITS})


def uff(path, **how):
    functions = zip(X, ("S1", "speed"), ("MPa", "rpm"), strict=True)
    each = [dataset(x, name=name, unit=unit, **how) for x, name, unit in functions]
    path.write_bytes(b"".join(each))


def uff_binary(path):
    uff(path, binary="<f8")


def labview(path):
    rows = segment(columns(T, *X), steps=(1 / RATE,) * 2, samples=X.shape[1])
    path.write_text(file_head() + rows.replace("0.000977", f"{1 / RATE!r}"))


def famos(path):
    pytest.importorskip("imctermite")
    made = (channel(k + 1, name, X[k], unit=unit, step=1 / RATE) for k, (name, unit) in enumerate(
        (("S1", "MPa"), ("speed", "rpm"))))  # fmt: skip
    path.write_bytes(HEAD + b"".join(made))


FORMATS = {
    one.__name__: one
    for one in (rpc, matlab_5, matlab_5_packed, matlab_7_3, uff, uff_binary, labview, famos)
}  # fmt: skip


def damage(path):
    done = CliRunner().invoke(life, [str(path), "--gauge", "S1:MPa", "--sn", "30,2e6,5", "--all"])
    assert done.exit_code == 0, done.output
    return next(line for line in done.output.splitlines() if line.startswith("S1 "))


@pytest.fixture(scope="module")
def damage_of_csv(tmp_path_factory):
    path = tmp_path_factory.mktemp("csv") / "a.csv"
    csv(path)
    return damage(path)


@pytest.mark.parametrize("name", FORMATS)
def test_damage_is_that_of_csv(tmp_path, damage_of_csv, name):
    FORMATS[name](tmp_path / "a.dat")
    recording = open_recording(tmp_path / "a.dat")
    assert [(c.name, c.unit) for c in recording.channels] == [("S1", "MPa"), ("speed", "rpm")]
    assert recording.rate == pytest.approx(RATE, rel=1e-9)
    np.testing.assert_allclose(recording.read_all(), X, rtol=1e-12)
    assert damage(tmp_path / "a.dat") == damage_of_csv


@pytest.mark.parametrize("name", FORMATS)
def test_samples_are_the_same_in_small_pieces(tmp_path, monkeypatch, name):
    for module in ("rpc", "matlab", "uff", "lvm", "famos"):
        monkeypatch.setattr(f"cardan.readers.{module}.SAMPLES_PER_BLOCK", 300)
    monkeypatch.setattr("cardan.readers.rpc.MAX_GROUP_BYTES_READ_AT_ONCE", 1)
    FORMATS[name](tmp_path / "a.dat")
    found = open_recording(tmp_path / "a.dat").read_all(["speed", "S1"])
    np.testing.assert_allclose(found, X[::-1], rtol=1e-12)


def rejections(path, contents, opened):
    """Return what is said of contents of a file that are rejected; none takes much memory."""
    said = []
    for content in contents:
        path.write_bytes(content)
        tracemalloc.start()
        try:
            for _ in opened().pieces():
                pass
        except CardanError as error:
            said.append(str(error))
        finally:
            peak = tracemalloc.get_traced_memory()[1]
            tracemalloc.stop()
        assert peak < 100e6
    return said


def mutants(data, count=40):
    """A file cut short, with huge and negative numbers, with other bytes, with parts gone."""
    random = np.random.default_rng(3)
    digits = np.flatnonzero(np.isin(np.frombuffer(data[:4096], np.uint8), list(b"0123456789")))
    for k in range(count):
        wrong = bytearray(data)
        at = int(random.integers(min(len(data), 4096)))
        match k % 5:
            case 0:
                wrong = wrong[: int(len(data) * random.random() ** 2)]
            case 1:
                wrong[at : at + 4] = (
                    random.choice([0x7FFFFFFF, -1, 1 << 30]).astype("<i4").tobytes()
                )
            case 2 if len(digits):
                at = int(random.choice(digits))
                wrong[at : at + 1] = random.choice([b"9" * 12, b"-1", b"e9", b""])
            case 3:
                wrong[at : at + 8] = random.bytes(8)
            case _:
                wrong[at:at] = b"" if k % 2 else wrong[at : at + 64]
                del wrong[at : at + 48 * (k % 2)]
        yield bytes(wrong)


@pytest.mark.parametrize(
    "name",
    [pytest.param(n, marks=pytest.mark.slow if n in ("famos", "labview") else ()) for n in FORMATS],
)
def test_mutated_file_is_read_or_rejected_within_bounds(tmp_path, name):
    FORMATS[name](tmp_path / "a.dat")
    begun = time.process_time()
    wrong = tmp_path / "b.dat"
    said = rejections(
        wrong, mutants((tmp_path / "a.dat").read_bytes()), lambda: open_recording(wrong)
    )
    assert len(said) >= 8
    assert not any("\n" in one for one in said)
    assert time.process_time() - begun < 30
