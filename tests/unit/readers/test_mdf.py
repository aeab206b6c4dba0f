"""MDF files made by asammdf and then made to lie: ASAM MDF 4.2, chapter 5, byte by byte."""

import struct
import zlib

import numpy as np
import pytest
from click.testing import CliRunner

from cardan.cli.life import life as command
from cardan.core.errors import InvalidFileError
from cardan.readers.dispatch import open_recording

asammdf = pytest.importorskip("asammdf")

N, RATE = 1000, 500.0
T = np.arange(N) / RATE
S1 = 40 * np.sin(30 * T)
HEAD = 24
"""Bytes of a block before its links."""


def written(path, *signals, version="4.10", packed=0):
    """Write a file of asammdf's and return its bytes."""
    file = asammdf.MDF(version=version)
    for group in signals or ([asammdf.Signal(S1, T, name="S1", unit="MPa")],):
        file.append(group)
    file.save(path, overwrite=True, compression=packed)
    return bytearray(path.read_bytes())


def place(data, name):
    """Return where a block stands, and where its values begin."""
    at = data.index(name)
    (links,) = struct.unpack_from("<Q", data, at + 16)
    return at, at + HEAD + 8 * links


def block(name, links, body):
    head = struct.pack("<4s4xQQ", name, HEAD + 8 * len(links) + len(body), len(links))
    whole = head + struct.pack(f"<{len(links)}Q", *links) + body
    return whole + bytes(-len(whole) % 8)


def to_data(data, new):
    """Put a block at the end of a file, and let the group's data be that; return what they were."""
    data += bytes(-len(data) % 8)
    at = place(data, b"##DG")[0] + HEAD + 16
    (old,) = struct.unpack_from("<Q", data, at)
    struct.pack_into("<Q", data, at, len(data))
    data += new(old, len(data))


def refused(path, data, match):
    path.write_bytes(data)
    with pytest.raises(InvalidFileError, match=match):
        open_recording(path).read_all()


@pytest.mark.slow
@pytest.mark.parametrize("name", [b"##DG", b"##CG", b"##CN", b"##FH"])
def test_mdf_with_circular_blocks_is_rejected(tmp_path, name):
    """It had never come back."""
    data = written(tmp_path / "a.mf4")
    at, _ = place(data, name)
    struct.pack_into("<Q", data, at + HEAD, at)
    refused(tmp_path / "a.mf4", data, "its blocks lead in a circle")


def test_mdf_data_list_linked_to_itself_is_rejected(tmp_path):
    data = written(tmp_path / "a.mf4")
    to_data(data, lambda old, own: block(b"##DL", [own, old], struct.pack("<B3xIQ", 1, 1, 16 * N)))
    refused(tmp_path / "a.mf4", data, "its blocks lead in a circle: ##DL")


def test_mdf_data_list_with_repeated_blocks_is_rejected(tmp_path):
    data = written(tmp_path / "a.mf4")
    to_data(
        data,
        lambda old, _: block(
            b"##DL", [0, *[old] * 20_000], struct.pack("<B3xIQ", 1, 20_000, 16 * N)
        ),
    )
    struct.pack_into("<Q", data, place(data, b"##CG")[1] + 8, 20_000 * N)
    refused(tmp_path / "a.mf4", data, "its blocks lead in a circle: ##DT")


def test_mdf3_with_circular_channel_groups_is_rejected(tmp_path):
    data = written(tmp_path / "a.mdf", version="3.30")
    np.testing.assert_allclose(open_recording(tmp_path / "a.mdf").read_all(), [S1])
    (at,) = struct.unpack_from("<I", data, 68)
    struct.pack_into("<I", data, at + 4, at)
    refused(tmp_path / "a.mdf", data, "its blocks lead in a circle: DG")


@pytest.fixture(scope="module")
def zeros():
    packer = zlib.compressobj(9)
    return b"".join(packer.compress(bytes(1 << 24)) for _ in range(32)) + packer.flush()


@pytest.mark.slow
@pytest.mark.parametrize(
    ("claimed", "why"),
    [(1 << 29, "claims 536870912 bytes at once"), (16 * N, "more than the 16000")],
)
def test_mdf_decompression_bomb_is_rejected(tmp_path, zeros, claimed, why):
    """Of a gigabyte and more it took all of that, what it claimed or not."""
    data = written(tmp_path / "a.mf4")
    packed = struct.pack("<2sBxIQQ", b"DT", 0, 0, claimed, len(zeros)) + zeros
    to_data(data, lambda *_: block(b"##DZ", [], packed))
    struct.pack_into("<Q", data, place(data, b"##CG")[1] + 8, claimed // 16)
    assert len(data) < 600_000
    refused(tmp_path / "a.mf4", data, why)


PACKS = {"zstd": 2, "lz4": 4}
"""Kinds of packed blocks in MDF 4.3, and one more each where rows were turned to columns."""


def packed_by(file, kind, data, *, claimed):
    """A file whose samples are a block that says it is packed so, and makes what is claimed."""
    zipped = struct.pack("<2sBxIQQ", b"DT", kind, 16, claimed, len(data)) + data
    to_data(file, lambda *_: block(b"##DZ", [], zipped))
    return file


@pytest.mark.parametrize("packed", range(1, 7))
def test_mdf_of_every_compression_is_read(tmp_path, packed):
    """Deflate, Zstandard, LZ4, and each with rows turned to columns."""
    t = np.arange(200_000) / RATE
    s1 = 40 * np.sin(30 * t)
    signal = asammdf.Signal(s1, t, name="S1", unit="MPa")
    data = written(tmp_path / "a.mf4", [signal], version="4.30", packed=packed)
    assert data[place(data, b"##DZ")[1] + 2] == packed - 1
    np.testing.assert_array_equal(open_recording(tmp_path / "a.mf4").read_all(), [s1])


@pytest.fixture(scope="module")
def gigabyte():
    """Half a gigabyte of zeros, by who packed it."""
    zstd, lz4 = pytest.importorskip("zstd"), pytest.importorskip("lz4.frame")
    zeros, piece = bytes(1 << 29), bytes(1 << 20)
    unsaid = lz4.compress(zeros, store_size=False)
    return {
        "zstd": zstd.compress(zeros), "zstd, many": zstd.compress(piece) * 512,
        "zstd, skipped": struct.pack("<II", 0x184D2A50, 9) + bytes(9) + zstd.compress(zeros),
        "lz4": lz4.compress(zeros), "lz4, unsaid": unsaid,
    }  # fmt: skip


@pytest.mark.slow
@pytest.mark.parametrize("who", ["zstd", "zstd, many", "zstd, skipped", "lz4", "lz4, unsaid"])
@pytest.mark.parametrize("turned", [0, 1])
def test_zstandard_decompression_bomb_in_mdf_is_rejected(tmp_path, gigabyte, who, turned):
    """17 kB of Zstandard made half a gigabyte, in memory, whatever the block claimed."""
    kind = PACKS[who.split(",")[0]] + turned
    data = packed_by(written(tmp_path / "a.mf4"), kind, gigabyte[who], claimed=16 * N)
    refused(tmp_path / "a.mf4", data, "makes more than the 16000 bytes that it claims")


def test_lz4_header_claiming_16_gigabytes_is_rejected(tmp_path):
    """Memory is asked for by it, though little comes."""
    lz4 = pytest.importorskip("lz4.frame")
    context = lz4.create_compression_context()
    head = lz4.compress_begin(context, source_size=1 << 34)
    small = head + lz4.compress_chunk(context, bytes(100))
    data = packed_by(written(tmp_path / "a.mf4"), 4, small, claimed=16 * N)
    refused(tmp_path / "a.mf4", data, "makes more than the 16000 bytes that it claims")


@pytest.mark.slow
@pytest.mark.parametrize("kind", [0, 1, 2, 3, 4, 5])
@pytest.mark.parametrize("whole", [False, True])
def test_mdf_block_that_does_not_decompress_is_reported_damaged(tmp_path, kind, whole):
    """Each packer has an error of its own, which went through as it was."""
    zstd, lz4 = pytest.importorskip("zstd"), pytest.importorskip("lz4.frame")
    pack = (zlib.compress, zstd.compress, lz4.compress)[kind // 2]
    data = pack(np.stack([T, S1], axis=1).tobytes())
    broken = data[:-40] + b"x" * 40 if whole else b"no frame of any packer " * 40
    data = packed_by(written(tmp_path / "a.mf4"), kind, broken, claimed=16 * N)
    refused(tmp_path / "a.mf4", data, "it is damaged|MDF cannot open it")


@pytest.mark.slow
@pytest.mark.parametrize(
    ("offset", "form", "value", "why"),
    [(8, "<Q", 10**12, "claims 1e\\+12 records of 16 bytes"),
     (8, "<Q", 1500, "of 1500 rows it holds 1000"),
     (24, "<I", 4_000_000_000, "a record of it claims 4000000000 bytes"),
     (8, "<Q", 10**6, "more samples than it can hold")],
)  # fmt: skip
def test_mdf_group_with_false_size_claim_is_rejected(tmp_path, offset, form, value, why):
    """A record of 4 GB had taken 3.8; of 10¹² samples a thousand came without a word."""
    data = written(tmp_path / "a.mf4")
    struct.pack_into(form, data, place(data, b"##CG")[1] + offset, value)
    refused(tmp_path / "a.mf4", data, why)


def test_mdf_channel_beyond_record_end_is_rejected(tmp_path):
    """It was read from the memory behind, or took the program down."""
    data = written(tmp_path / "a.mf4")
    at = max(k for k in range(len(data)) if data.startswith(b"##CN", k))
    (links,) = struct.unpack_from("<Q", data, at + 16)
    where = at + HEAD + 8 * links + 4
    assert struct.unpack_from("<I", data, where)[0] in (0, 8)
    struct.pack_into("<I", data, where, 12)
    refused(tmp_path / "a.mf4", data, "lies behind the end of its record .* byte 20 of 16")


@pytest.mark.slow
def test_truncated_mdf_is_reported(tmp_path):
    data = written(tmp_path / "a.mf4")
    refused(tmp_path / "a.mf4", data[: 2 * len(data) // 3], "damaged or cut off")
    said = CliRunner().invoke(
        command, [str(tmp_path / "a.mf4"), "--sn", "80,2e6,5", "--lang", "it"]
    )
    assert said.exit_code == 2
    assert "un suo blocco è danneggiato o troncato" in said.stderr


def test_unfinalised_mdf_is_read(tmp_path):
    data = written(tmp_path / "a.mf4")
    data[:8] = b"UnFinMF "
    struct.pack_into("<H", data, 60, 1)
    struct.pack_into("<Q", data, place(data, b"##CG")[1] + 8, 0)
    (tmp_path / "a.mf4").write_bytes(data)
    np.testing.assert_allclose(open_recording(tmp_path / "a.mf4").read_all(), [S1])


@pytest.mark.parametrize("packed", [0, 1, 2])
def test_mdf_text_and_array_channels_are_omitted_with_note(tmp_path, packed):
    """Of an array's elements asammdf makes channels behind their record: the heap broke."""
    words = np.array([b"gear %d" % (k % 5) for k in range(N)])
    array = np.rec.fromarrays([np.zeros((N, 3, 2))], names="A")
    pair = np.rec.fromarrays([S1, 2 * S1], names="x,y")
    written(
        tmp_path / "a.mf4",
        [asammdf.Signal(S1, T, name="S1", unit="MPa"),
         asammdf.Signal(words, T, name="gear", encoding="utf-8"),
         asammdf.Signal(array, T, name="A"), asammdf.Signal(pair, T, name="pair")],
        packed=packed,
    )  # fmt: skip
    recording = open_recording(tmp_path / "a.mf4")
    assert recording.names == ("S1", "x", "y")
    assert "not numbers, left out: gear" in recording.notes
    assert "more than one number a sample, left out: A, pair" in recording.notes
    np.testing.assert_allclose(recording.read_all(), [S1, S1, 2 * S1])


def test_slow_mdf_reading_prints_nothing_to_stdout(tmp_path, monkeypatch, capsys):
    """After ten seconds asammdf prints its speed, in the middle of what `--json` prints."""
    import time

    written(tmp_path / "a.mf4")
    recording = open_recording(tmp_path / "a.mf4")
    begun = iter(range(0, 10_000, 11))
    monkeypatch.setattr(time, "perf_counter", lambda: float(next(begun)))
    assert recording.read_all().shape == (1, N)
    assert capsys.readouterr().out == ""


def test_state_written_as_it_changes_is_not_reported_as_interpolated(tmp_path):
    t = np.arange(10_000) / 1000
    with asammdf.MDF(version="4.10") as file:
        file.append([asammdf.Signal(np.sin(t), t, name="S1", unit="MPa")])
        at = np.array([0.3, 2.11, 2.9, 5.02, 8.4])
        file.append([asammdf.Signal(np.array([1, 2, 3, 4, 3], "u1"), at, name="gear")])
        file.append([asammdf.Signal(np.cos(t[::100]), t[::100], name="torque", unit="Nm")])
        path = file.save(tmp_path / "a.mf4")
    notes = open_recording(path).notes
    assert "laid on one clock of 1000 Hz, straight between samples: torque (10 Hz)" in notes
    assert "gear: written as it changes, each value holds until the next" in notes
