"""TDMS files written byte by byte: NI, TDMS file format internal structure (2024)."""

import re
import struct
import sys
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

from cardan.cli.life import life as command
from cardan.core.errors import InvalidFileError
from cardan.readers import tdms as recording_tdms
from cardan.readers.dispatch import open_recording

nptdms = pytest.importorskip("nptdms")

N, RATE = 1000, 500.0
S1 = 40 * np.sin(30 * np.arange(N) / RATE)
KINDS = {"i1": 1, "i2": 2, "i4": 3, "i8": 4, "u1": 5, "f4": 9, "f8": 10}
META, NEW, RAW, INTERLEAVED, BIG = 1 << 1, 1 << 2, 1 << 3, 1 << 5, 1 << 6
UNKNOWN = 2**64 - 1
"""Bytes of a segment that nobody finished."""


def segment(columns, *, by_rows=False, chunks=1, claimed=None, size=None, order="<", slope=None):
    """A segment of channels by their names, all of one length where a row follows the next."""

    def text(word):
        return struct.pack(order + "I", len(word)) + word.encode()

    def number(name, value):
        return text(name) + struct.pack(order + "Id", 10, value)

    meta = struct.pack(order + "I", len(columns))
    for name, x in columns.items():
        n = x.size // chunks if claimed is None else claimed
        meta += text(f"/'g'/'{name}'")
        meta += struct.pack(order + "IIIQ", 20, KINDS[x.dtype.str[1:]], 1, n)
        own = [number("wf_increment", 1 / RATE)]
        if slope is not None:
            own += [
                text("NI_Number_Of_Scales") + struct.pack(order + "II", 7, 1),
                text("NI_Scale[0]_Scale_Type") + struct.pack(order + "I", 32) + text("Linear"),
                number("NI_Scale[0]_Linear_Slope", slope),
                number("NI_Scale[0]_Linear_Y_Intercept", 3.0),
                text("NI_Scale[0]_Linear_Input_Source") + struct.pack(order + "II", 7, 0xFFFFFFFF),
            ]
        meta += struct.pack(order + "I", len(own)) + b"".join(own)
    written = [x.astype(x.dtype.newbyteorder(order)) for x in columns.values()]
    if by_rows:
        row = np.dtype([(f"f{k}", x.dtype) for k, x in enumerate(written)])
        raw = np.rec.fromarrays(written, dtype=row).tobytes()
    else:
        parts = [np.split(x, chunks) for x in written]
        raw = b"".join(p[c].tobytes() for c in range(chunks) for p in parts)
    flags = META | NEW | RAW | INTERLEAVED * by_rows | BIG * (order == ">")
    size = len(meta) + len(raw) if size is None else size
    head = b"TDSm" + struct.pack("<I", flags) + struct.pack(order + "IQQ", 4713, size, len(meta))
    return head + meta + raw


CARD, SCALER, BITS = 1 << 7, 0x1269, 0x126A
CARD_KINDS = {"u1": 0, "i1": 1, "u2": 2, "i2": 3, "u4": 4, "i4": 5}


def linear(source):
    """The scale of a card's channel: number 0 is what its scaler gives, 1 is made of that."""

    def text(word):
        return struct.pack("<I", len(word)) + word.encode()

    own = [
        text("wf_increment") + struct.pack("<Id", 10, 1 / RATE),
        text("NI_Number_Of_Scales") + struct.pack("<II", 7, 2),
        text("NI_Scale[1]_Scale_Type") + struct.pack("<I", 32) + text("Linear"),
        text("NI_Scale[1]_Linear_Slope") + struct.pack("<Id", 10, 2.5),
        text("NI_Scale[1]_Linear_Y_Intercept") + struct.pack("<Id", 10, 3.0),
        text("NI_Scale[1]_Linear_Input_Source") + struct.pack("<II", 7, source),
    ]
    return struct.pack("<I", len(own)) + b"".join(own)


def card(buffers, *, chunks=1, claimed=None, size=None, offset=None, scale=None):
    """A segment of data acquisition cards: a buffer each, of rows of their channels (n,)."""
    widths = [sum(x.itemsize for x in own.values()) for own in buffers]
    meta = struct.pack("<I", sum(map(len, buffers)))
    for which, own in enumerate(buffers):
        inside = 0
        for name, x in own.items():
            n = x.size // chunks if claimed is None else claimed
            path = f"/'g'/'{name}'".encode()
            meta += struct.pack("<I", len(path)) + path + struct.pack("<II", SCALER, 0xFFFFFFFF)
            meta += struct.pack("<IQI", 1, n, 1)
            at = inside if offset is None else offset
            meta += struct.pack("<IIIII", CARD_KINDS[x.dtype.str[1:]], which, at, 0, 0)
            meta += struct.pack(f"<I{len(widths)}I", len(widths), *widths)
            meta += linear(0) if scale is None else scale
            inside += x.itemsize
    raw = b""
    for c in range(chunks):
        for own in buffers:
            part = [np.split(x, chunks)[c] for x in own.values()]
            row = np.dtype([(f"f{k}", x.dtype) for k, x in enumerate(part)])
            raw += np.rec.fromarrays(part, dtype=row).tobytes()
    size = len(meta) + len(raw) if size is None else size
    head = b"TDSm" + struct.pack("<IIQQ", META | NEW | RAW | CARD, 4713, size, len(meta))
    return head + meta + raw


def refused(path, data, match):
    path.write_bytes(data)
    with pytest.raises(InvalidFileError, match=match):
        open_recording(path).read_all()


def held(path):
    """Return what npTDMS finds where it reads all of a file at once."""
    group = nptdms.TdmsFile.read(path)["g"]
    return {c.name: np.asarray(c[:], float) for c in group.channels() if len(c)}


def drawn(rng, names, n):
    """Draw a channel of a kind of its own for each name, the same for the same name."""
    kinds = dict(zip("abc", ("f8", "i2", "f4"), strict=True))
    return {k: (100 * rng.normal(size=n)).astype(kinds[k]) for k in names}


@pytest.mark.parametrize("seed", range(40))
def test_samples_match_nptdms(tmp_path, monkeypatch, seed):
    """Segments by rows and by channels, of both orders of bytes, scaled, cut off anywhere."""
    rng = np.random.default_rng(seed)
    monkeypatch.setattr(recording_tdms, "MAX_READ_BYTES", int(rng.integers(1, 400)))
    monkeypatch.setattr(recording_tdms, "SAMPLES_PER_BLOCK", int(rng.integers(1, 300)))
    order = "<>"[seed % 2]
    data = b""
    for _ in range(rng.integers(1, 5)):
        names = [k for k in "abc" if rng.random() < 0.7] or ["a"]
        chunks = int(rng.integers(1, 4))
        data += segment(
            drawn(rng, names, chunks * int(rng.integers(1, 200))), chunks=chunks, order=order,
            by_rows=bool(rng.random() < 0.5), slope=2.5 if rng.random() < 0.5 else None,
        )  # fmt: skip
    if rng.random() < 0.5:
        data = data[: len(data) - int(rng.integers(1, 300))]
    path = tmp_path / "a.tdms"
    path.write_bytes(data)
    expected = held(path)
    alike = {}
    for name, x in expected.items():
        alike.setdefault(x.size, []).append(name)
    # Of several lengths the others are laid on one clock: only one of each group is asked here.
    for size, names in alike.items():
        table = recording_tdms.open_tdms(path)
        own = next(t for t in (table, *table.other_tables) if t.samples == size)
        assert [c.name for c in own.columns] == names
        for places in (tuple(range(len(names))), (len(names) - 1,)):
            found = np.concatenate(list(own.read_rows(places)), axis=-1)
            np.testing.assert_array_equal(found, [expected[names[k]] for k in places])


@pytest.mark.parametrize("seed", range(20))
def test_daqmx_samples_match_nptdms(tmp_path, monkeypatch, seed):
    """Of one card or two, in chunks and segments, cut off anywhere; each of its own kind."""
    rng = np.random.default_rng(seed)
    monkeypatch.setattr(recording_tdms, "MAX_READ_BYTES", int(rng.integers(1, 400)))
    monkeypatch.setattr(recording_tdms, "SAMPLES_PER_BLOCK", int(rng.integers(1, 300)))
    kinds = {"a": "i2", "b": "i4", "c": "u1", "d": "u2"}
    homes = [["a", "b"], ["c", "d"]] if seed % 2 else [["a", "c", "b"]]
    data = b""
    for _ in range(rng.integers(1, 4)):
        chunks = int(rng.integers(1, 4))
        # Two cards need not be equally fast.
        buffers = [
            {k: rng.integers(0, 100, n).astype(kinds[k]) for k in names}
            for names in homes
            for n in [chunks * int(rng.integers(1, 200))]
        ]
        data += card(buffers, chunks=chunks)
    if rng.random() < 0.5:
        data = data[: len(data) - int(rng.integers(1, 300))]
    path = tmp_path / "a.tdms"
    path.write_bytes(data)
    expected = held(path)
    table = recording_tdms.open_tdms(path)
    for own in (table, *table.other_tables):
        found = np.concatenate(list(own.read_rows(tuple(range(len(own.columns))))), axis=-1)
        np.testing.assert_array_equal(found, [expected.pop(c.name) for c in own.columns])
    assert not expected


COUNTS = (100 * np.sin(30 * np.arange(N) / RATE)).astype("i2")
BOTH = [{"S1": COUNTS, "S2": COUNTS}]


@pytest.mark.parametrize("claimed", [10**9, 10**12, 2**59])
@pytest.mark.parametrize("size", [None, UNKNOWN])
def test_daqmx_with_false_row_count_is_reported(tmp_path, claimed, size):
    why = f"claims more samples than it can hold .*{re.escape(f'{claimed:.4g}')} samples of 2"
    refused(tmp_path / "a.tdms", card(BOTH, claimed=claimed, size=size), why)


@pytest.mark.parametrize("offset", [3, 4, 2**32 - 1])
def test_daqmx_channel_beyond_row_end_is_rejected(tmp_path, offset):
    """It had ended in a traceback of the library's."""
    refused(tmp_path / "a.tdms", card(BOTH, offset=offset), f"lies at {offset} in rows of 4 bytes")
    asked = [str(tmp_path / "a.tdms"), "--sn", "80,2e6,5", "--lang", "it"]
    said = CliRunner().invoke(command, asked)
    assert said.exit_code == 2
    assert f"sta a {offset} in righe di 4 byte" in said.stderr


@pytest.mark.parametrize(
    ("scale", "why"),
    [
        (linear(1), "it is damaged"), (linear(0xFFFFFFFF), "it is damaged"),
        (struct.pack("<I", 0), "no channel of numbers"),
    ],
)  # fmt: skip
def test_missing_or_circular_scale_is_rejected(tmp_path, scale, why):
    """A scale that is its own source had ended in the depth of the stack."""
    refused(tmp_path / "a.tdms", card(BOTH, scale=scale), why)


@pytest.mark.parametrize("order", "<>")
def test_segments_of_mixed_byte_order_are_read(tmp_path, order):
    other = "><"["<>".index(order)]
    data = segment({"S1": S1[:400]}, order=order) + segment({"S1": S1[400:]}, order=other)
    (tmp_path / "a.tdms").write_bytes(data)
    np.testing.assert_array_equal(open_recording(tmp_path / "a.tdms").read_all(), [S1])


def test_mismatched_index_file_is_ignored(tmp_path):
    """Its samples had come from where those of the other file lay, or not at all."""
    with nptdms.TdmsWriter(str(tmp_path / "a.tdms"), index_file=True) as writer:
        writer.write_segment([nptdms.ChannelObject("g", "other", np.arange(5.0))])
    assert (tmp_path / "a.tdms_index").is_file()
    (tmp_path / "a.tdms").write_bytes(segment({"S1": S1, "S2": 2 * S1}))
    np.testing.assert_array_equal(open_recording(tmp_path / "a.tdms").read_all(), [S1, 2 * S1])


@pytest.mark.parametrize("claimed", [10**9, 10**12, 2**59])
@pytest.mark.parametrize("size", [None, UNKNOWN])
def test_row_count_claiming_16_gigabytes_is_rejected(tmp_path, claimed, size):
    """Of 16 kB that much memory was asked for, and of a million million rows more."""
    both = {"S1": S1, "S2": 2 * S1}
    data = segment(both, by_rows=True, claimed=claimed, size=size)
    why = f"claims more samples than it can hold .*{re.escape(f'{claimed:.4g}')} samples of 2"
    refused(tmp_path / "a.tdms", data, why)
    # Nor where the next segment is in order, and holds more.
    if size is None:
        refused(tmp_path / "a.tdms", data + segment(both, by_rows=True), why)
    said = CliRunner().invoke(
        command, [str(tmp_path / "a.tdms"), "--sn", "80,2e6,5", "--lang", "it"]
    )
    assert said.exit_code == 2
    assert "dichiara più campioni di quanti ne possa contenere" in said.stderr


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="looks into /proc")
def test_false_row_count_allocates_no_memory(tmp_path):
    """400 MB of rows claimed, of 16 MB that are there: cut off, which may be."""
    import resource

    x = np.random.default_rng(1).normal(size=2_000_000)
    data = segment({"S1": x}, by_rows=True, claimed=50_000_000, size=UNKNOWN)
    (tmp_path / "a.tdms").write_bytes(data)
    recording = open_recording(tmp_path / "a.tdms")
    assert recording.notes == (
        "the file is cut short: 48000000 samples that it claims are not there",
    )
    pages = int(Path("/proc/self/statm").read_text().split()[0])
    limits = resource.getrlimit(resource.RLIMIT_AS)
    room = pages * resource.getpagesize() + 100_000_000
    resource.setrlimit(resource.RLIMIT_AS, (room, limits[1]))
    try:
        read = sum(piece.size for piece in recording.read((0,)))
    finally:
        resource.setrlimit(resource.RLIMIT_AS, limits)
    assert read == x.size


@pytest.mark.parametrize("claimed", [1500, 10**9, 10**12])
@pytest.mark.parametrize("size", [None, UNKNOWN])
def test_false_sample_count_of_channel_is_noted(tmp_path, claimed, size):
    """A thousand samples of a million million came without a word where its size was right."""
    path = tmp_path / "a.tdms"
    path.write_bytes(segment({"S1": S1}, claimed=claimed, size=size))
    recording = open_recording(path)
    np.testing.assert_array_equal(recording.read_all(), [S1])
    note = f"the file is cut short: {claimed - N} samples that it claims are not there"
    assert recording.notes == (note,)
    if size is None:  # not at its end alone
        path.write_bytes(segment({"S1": S1}, claimed=claimed) + segment({"S1": S1}))
        recording = open_recording(path)
        assert recording.notes == (note,)
        assert recording.read_all().shape == (1, 2 * N)


def test_nptdms_warnings_are_not_printed(tmp_path, capfd):
    """npTDMS had warned of the same beside, in English."""
    (tmp_path / "a.tdms").write_bytes(segment({"S1": S1}, claimed=1500, size=UNKNOWN))
    said = CliRunner().invoke(
        command, [str(tmp_path / "a.tdms"), "--gauge", "S1:MPa", "--sn", "80,2e6,5", "--lang", "pt"]
    )
    assert said.exit_code == 0, said.stderr
    assert "o arquivo está cortado: faltam 500 amostras que ele declara" in said.output
    assert capfd.readouterr().err == ""
