"""CAN logs by a database: against python-can, asammdf and cantools; J1939; uneven clocks."""

import re
import struct
import zlib
from pathlib import Path

import can_logs as logs
import numpy as np
import pytest
from click.testing import CliRunner
from test_every_format import mutants, rejections

from cardan.cli.convert import convert
from cardan.cli.life import life
from cardan.core.errors import CardanError, InvalidFileError
from cardan.readers.can_database import EXTENDED_BIT, J1939_PARAMETERS, read_can_database
from cardan.readers.can_log import open_can_log
from cardan.readers.dispatch import open_recording
from cardan.readers.mdf import open_mdf
from cardan.topics.recording.campaign_schema import read_campaign_file
from cardan.topics.recording.campaign_study import recording_and_options
from cardan.topics.recording.options import AnalysisOptions
from cardan.topics.recording.shaft_signals import measured_shaft_angle

EEC1 = logs.EEC1


def tables(path, dbc):
    """Values and instants by signal, before they are laid on any clock."""
    opened = open_mdf if path.read_bytes()[:3] == b"MDF" else open_can_log
    first = opened(path, "", (dbc,))
    found = {}
    for table in (first, *first.other_tables):
        if table.frames:
            whole = np.concatenate(list(table.read_rows(tuple(range(len(table.columns))))), axis=1)
            found |= {c.name: (whole[0], whole[k]) for k, c in enumerate(table.columns) if k}
    return found


def by_cantools(dbc, log):
    """The same by cantools of the frames as python-can, or asammdf, reads them."""
    cantools = pytest.importorskip("cantools")
    database = cantools.database.load_file(dbc)
    messages = {(m.frame_id, m.is_extended_frame): m for m in database.messages}
    for key, m in [*messages.items()]:
        if m.is_extended_frame:
            messages |= {(key[0] & 0x1FFFFF00 | sa, True): m for sa in (0, 3)}
    found = {}
    for t, identifier, extended, data in log:
        decoded = messages[identifier, extended].decode(data, decode_choices=False)
        for name, value in decoded.items():
            found.setdefault(name, []).append((t, value))
    return {name: np.array(of).T for name, of in found.items()}


def frames_by_another_reader(path, kind):
    if kind == "mf4":
        from asammdf import MDF

        with MDF(path) as file:
            of = file.get("CAN_DataFrame")
        part = {n.split(".")[-1]: of.samples[n] for n in of.samples.dtype.names}
        each = zip(of.timestamps, part["ID"], part["IDE"], part["DataLength"], part["DataBytes"],
                   strict=True)  # fmt: skip
        return [(t, int(i), bool(e), bytes(d[:n])) for t, i, e, n, d in each]
    can = pytest.importorskip("can")
    with (can.BLFReader if kind == "blf" else can.ASCReader)(path) as log:
        return [(m.timestamp, m.arbitration_id, m.is_extended_id, bytes(m.data)) for m in log]


@pytest.mark.parametrize("kind", logs.WRITERS)
def test_values_and_instants_are_those_of_cantools(tmp_path, kind):
    pytest.importorskip("asammdf" if kind == "mf4" else "can")
    path, dbc = tmp_path / "a.dat", logs.dbc(tmp_path / "a.dbc")
    logs.WRITERS[kind](path, logs.frames_of_every_kind())
    expected = by_cantools(dbc, frames_by_another_reader(path, kind))
    found = tables(path, dbc)
    assert set(found) == set(expected)
    assert len(found) == 12
    for name, (time, values) in expected.items():
        if name == "EngTorqueMode":  # of four bits in J1939, 14 is an error, 15 not available
            values = np.where(values < 14, values, np.nan)
        np.testing.assert_allclose(found[name][0], time, rtol=0, atol=1e-9, err_msg=name)
        np.testing.assert_array_equal(found[name][1], values, err_msg=name)


# ------------------------------------------------------------------------------------------ J1939


def asc_text(*frames, head="date Mon Nov 30 10:00:00.000 2026\nbase hex  timestamps absolute\n"):
    """Frames (time s, identifier as ASC writes it, data) of a Vector ASC log."""
    lines = (f" {t:.6f} 1  {name}  Rx  d {len(d)} {d.hex(' ')}\n" for t, name, d in frames)
    return head + "no internal events logged\n" + "".join(lines)


def opened(tmp_path, *frames, dbc=logs.DBC, head=None, **how):
    path = tmp_path / "a.asc"
    path.write_text(asc_text(*frames, **({} if head is None else {"head": head})))
    return open_recording(path, dbc=logs.dbc(tmp_path / "a.dbc", dbc), **how)


def eec1(speed_rpm, torque=225):
    return bytes([0xF0, 0xFF, torque]) + struct.pack("<H", round(8 * speed_rpm)) + bytes(3)


def test_message_is_known_by_its_parameter_group_whoever_sends_it(tmp_path):
    """Priority and source address are another than the DBC's; SPN 190 and its name say the same."""
    recording = opened(tmp_path, *((0.1 * k, "18F00421x", eec1(1000 + k)) for k in range(40)))
    speed = 1000.0 + np.arange(40)
    for name in ("EngSpeed", "EngineSpeed", "SPN190"):
        np.testing.assert_array_equal(recording.read_all([name])[0], speed)
    assert recording.channel("ActualEnginePercentTorque").unit == "%"
    assert recording.read_all(["ActualEnginePercentTorque"])[0, 0] == 100
    assert recording.rate == 10


def test_two_senders_of_a_message_are_two_channels(tmp_path):
    frames = []
    for k in range(40):
        frames += [(0.1 * k, "CF00400x", eec1(900)), (0.1 * k + 0.05, "CF00401x", eec1(700))]
    recording = opened(tmp_path, *frames)
    first, second = recording.read_all(["EngSpeed@0CF00400", "EngineSpeed@0CF00401"])
    assert set(first[1:-1]) | set(second[1:-1]) == {900, 700}
    with pytest.raises(CardanError, match="no channel 'EngineSpeed'"):
        recording.index_of("EngineSpeed")


def test_error_and_not_available_are_missing(tmp_path):
    frames = [(0.1 * k, "CF00400x", eec1(1000)) for k in range(40)]
    frames[10] = (1.0, "CF00400x", b"\xff" * 8)
    frames[20] = (2.0, "CF00400x", bytes([0, 0, 0xFE, 0xFF, 0xFE, 0, 0, 0]))
    speed, torque = opened(tmp_path, *frames).read_all(["EngineSpeed", "SPN513"])
    np.testing.assert_array_equal(np.flatnonzero(np.isnan(speed)), [10, 20])
    np.testing.assert_array_equal(np.flatnonzero(np.isnan(torque)), [10, 20])


def test_short_frame_and_named_missing_value_are_missing(tmp_path):
    text = logs.DBC + 'VAL_ 291 Page 2 "Signal not available" 0 "No error" 1 "inner" ;\n'
    page = bytes([0, 0, 0, 0, 8, 0, 0, 0])
    frames = [(0.1 * k, "123", page) for k in range(40)]
    frames[10], frames[20] = (1.0, "123", page[:4]), (2.0, "123", b"\2" + page[1:])
    page, torque = opened(tmp_path, *frames, dbc=text).read_all(["Page", "Torque"])
    np.testing.assert_array_equal(np.flatnonzero(np.isnan(torque)), [10])
    np.testing.assert_array_equal(np.flatnonzero(np.isnan(page)), [20])


def test_29_bit_identifier_that_is_not_of_j1939_is_matched_whole(tmp_path):
    text = logs.DBC + 'BA_ "VFrameFormat" BO_ 2364539646 1;\n'
    frames = [(0.1 * k, "CF00203x", bytes([255] * 8)) for k in range(40)]
    with pytest.raises(InvalidFileError, match="none of its frames is in "):
        opened(tmp_path, *frames, dbc=text)
    own = [(t, "CF002FEx", d) for t, _, d in frames]
    recording = opened(tmp_path, *own, dbc=text)
    assert recording.channels[0].aliases == ()
    assert recording.read_all(["ShaftSpeed"])[0, 0] == 8191.875


# ---------------------------------------------------------------------------------------- clocks


def uneven(count, step=0.1):
    """Instants of frames that come late by up to a step, s."""
    return step * np.arange(count) + np.random.default_rng(2).uniform(0, step, count)


def test_uneven_frames_lie_straight_between_and_states_hold(tmp_path):
    t = uneven(80)
    gear = 126 + np.arange(80) // 10
    frames = [(at, "CF00400x", eec1(1000 + 50 * at)) for at in t]
    frames += [(at + 0.01, "CF00503x", bytes([0, 0, 0, g]) + bytes(4))
               for at, g in zip(t, gear.tolist(), strict=True)]  # fmt: skip
    recording = opened(tmp_path, *frames)
    speed, engaged = recording.read_all(["EngineSpeed", "TransmissionCurrentGear"])
    at = round(t[0], 6) + np.arange(speed.size) / recording.rate
    np.testing.assert_allclose(speed, 1000 + 50 * at, atol=0.07)  # a bit of 0.125 rpm
    last = np.searchsorted(t + 0.01, at, side="right") - 1
    np.testing.assert_array_equal(engaged[last >= 0], (gear - 125)[last[last >= 0]])
    assert np.isnan(engaged[last < 0]).all()
    assert any("frames came unevenly, laid on a clock of" in n for n in recording.notes)
    assert any(n.startswith("CurrentGear: written as it changes") for n in recording.notes)


def test_gauge_by_uneven_frames_is_rejected(tmp_path):
    (tmp_path / "a.asc").write_text(
        asc_text(*((at, "124", struct.pack("<f", 1.0) + bytes(4)) for at in uneven(80)))
    )
    logs.dbc(tmp_path / "a.dbc")
    done = CliRunner().invoke(
        life, [str(tmp_path / "a.asc"), "--dbc", str(tmp_path / "a.dbc"), "--gauge", "Little",
               "--sn", "30,2e6,5"],
    )  # fmt: skip
    assert (done.exit_code, "a gauge needs an even clock" in done.output) == (2, True)


def test_frames_of_an_mdf_lie_on_the_clock_of_its_gauges(tmp_path):
    """At their own instants; what the gauges' own group holds is as it was."""
    asammdf = pytest.importorskip("asammdf")
    t = np.arange(4000) / 500
    gauge = asammdf.Signal(np.sin(40 * t), t, name="S1", unit="MPa")
    frames = [(at, 1, EEC1, True, eec1(1000 + 50 * at)) for at in uneven(70)]
    logs.mf4(tmp_path / "a.mf4", frames, [gauge])
    dbc = logs.dbc(tmp_path / "a.dbc")
    recording = open_recording(tmp_path / "a.mf4", dbc=dbc)
    assert recording.rate == 500
    s1, speed = recording.read_all(["S1", "EngineSpeed"])
    np.testing.assert_array_equal(s1, gauge.samples)
    known = (t >= frames[0][0]) & (t <= frames[-1][0])
    np.testing.assert_allclose(speed[known], 1000 + 50 * t[known], atol=0.07)
    assert np.isnan(speed[~known]).all()
    without = open_recording(tmp_path / "a.mf4")
    assert without.names == ("S1",)
    assert any("give its DBC with --dbc" in n for n in without.notes)


def test_life_and_shaft_angle_of_a_log(tmp_path):
    frames = []
    for k in range(300):
        t = 0.01 * k
        stress = struct.pack("<f", 30 * np.sin(2 * np.pi * 40 * t / 3)) + bytes(4)
        frames.append((t, "124", stress))
        if k % 10 == 0:
            speed = struct.pack("<H", 8 * 400)
            frames.append((t + 0.001, "CF00203x", b"\0" + speed + bytes(5)))
    (tmp_path / "a.log").write_text(asc_text(*frames))
    logs.dbc(tmp_path / "a.dbc")
    done = CliRunner().invoke(
        life, [str(tmp_path / "a.log"), "--dbc", str(tmp_path / "a.dbc"), "--gauge", "Little",
               "--sn", "30,2e6,5", "--all"],
    )  # fmt: skip
    assert done.exit_code == 0, done.output
    assert re.search(r"Little +-30\.\d +30\.\d", done.output), done.output
    assert "note: CAN frames by a.dbc: 330 of 330 decoded" in done.output
    asked = AnalysisOptions.from_values(
        sn=(30, 2e6, 5), dbc=(str(tmp_path / "a.dbc"),), speed="TransmissionOutputShaftSpeed"
    )
    recording = open_recording(tmp_path / "a.log", dbc=asked.can_databases)
    turns = measured_shaft_angle(asked, recording).rotation.turns
    assert turns[-1] - turns[0] == pytest.approx(400 / 60 * 3, rel=0.01)


def test_campaign_names_the_database_of_each_log(tmp_path):
    """Of a recording, and of a file beside it, which lie in the campaign's folder."""
    t = np.arange(2000) / 200
    rows = "\n".join(f"{a:.4f},{20 * np.sin(50 * a):.4f}" for a in t)
    (tmp_path / "gauges.csv").write_text(f"time,S1\n{rows}\n")
    frames = ((at, "CF00400x", eec1(1000 + 50 * at)) for at in uneven(70))
    (tmp_path / "bus").write_text(asc_text(*frames))
    logs.dbc(tmp_path / "truck.dbc")
    text = """
campaign: beside
recordings:
  - {file: gauges.csv, beside: [{file: bus, late_s: 1, dbc: truck.dbc}]}
  - {file: bus, dbc: truck.dbc}
gauges: ["S1:MPa"]
strength: {amplitude_MPa: 30, cycles: 2e6, slope: 5}
"""
    (tmp_path / "a.yaml").write_text(text)
    written = read_campaign_file(tmp_path / "a.yaml")
    assert [p.name for p in written.referenced_files].count("truck.dbc") == 1
    asked = AnalysisOptions(**written.options)
    _, merged = recording_and_options(asked, written.drives[0])
    speed = merged.read_all(["EngineSpeed"])[0]
    known = np.isfinite(speed)
    begun = 1 - round(uneven(70)[0], 6)  # the log's clock began before its first frame
    np.testing.assert_allclose(speed[known], 1000 + 50 * (t[known] - begun), atol=0.5)
    assert np.isnan(speed[t < 1]).all()
    _, alone = recording_and_options(asked, written.drives[1])
    assert "EngSpeed" in alone.names
    (tmp_path / "a.yaml").write_text(
        text.replace("{file: bus, dbc: truck", "{file: bus, dbc: ../x")
    )
    with pytest.raises(InvalidFileError, match=r"recordings\[2\].dbc: lies outside"):
        read_campaign_file(tmp_path / "a.yaml")


# ----------------------------------------------------------------------------- several databases

ENGINE = """BO_ 2364540158 EEC1: 8 ECU
 SG_ EngSpeed : 24|16@1+ (0.125,0) [0|8031.875] "rpm" TCU
"""
BODY = """BO_ 512 Body: 8 ECU
 SG_ Load : 0|16@1- (0.5,0) [0|0] "MPa" TCU
"""


def log_of_two_databases(folder):
    frames = [(at, "CF00400x", eec1(1000 + 50 * at)) for at in uneven(70)]
    frames += [
        (at + 0.003, "200", struct.pack("<h6x", round(90 * np.sin(at)))) for at, *_ in frames
    ]
    (folder / "bus.asc").write_text(asc_text(*sorted(frames)))
    return logs.dbc(folder / "engine.dbc", ENGINE), logs.dbc(folder / "body.dbc", BODY + ENGINE)


def test_log_is_decoded_by_several_databases(tmp_path):
    """The same message in both counts once; alone, each decodes what it has."""
    databases = log_of_two_databases(tmp_path)
    recording = open_recording(tmp_path / "bus.asc", dbc=databases)
    assert {"EngSpeed", "Load"} <= set(recording.names)
    assert any("CAN frames by engine.dbc, body.dbc: 140 of 140" in n for n in recording.notes)
    alone = open_recording(tmp_path / "bus.asc", dbc=databases[0])
    assert "Load" not in alone.names
    named = [word for path in databases for word in ("--dbc", str(path))]
    log, table = str(tmp_path / "bus.asc"), tmp_path / "a.csv"
    done = CliRunner().invoke(convert, [log, str(table), *named])
    assert done.exit_code == 0, done.output
    assert "Load" in table.read_text().splitlines()[0]
    shown = CliRunner().invoke(life, [log, *named])
    assert shown.exit_code == 0, shown.output
    assert shown.output.count("--dbc") == 2
    assert "Load" in shown.output


def test_campaign_names_several_databases(tmp_path):
    log_of_two_databases(tmp_path)
    (tmp_path / "a.yaml").write_text("""
campaign: two
recordings:
  - {file: bus.asc, dbc: [engine.dbc, body.dbc]}
gauges: ["Load:MPa"]
strength: {amplitude_MPa: 30, cycles: 2e6, slope: 5}
""")
    written = read_campaign_file(tmp_path / "a.yaml")
    assert {p.name for p in written.referenced_files} == {"bus.asc", "engine.dbc", "body.dbc"}
    _, recording = recording_and_options(AnalysisOptions(**written.options), written.drives[0])
    assert {"EngSpeed", "Load"} <= set(recording.names)


def test_databases_that_contradict_each_other_are_refused(tmp_path):
    databases = log_of_two_databases(tmp_path)
    logs.dbc(databases[1], ENGINE.replace("0.125", "0.25"))
    expected = r"body.dbc: .*another way than engine.dbc.*EEC1, 0CF004FE"
    with pytest.raises(InvalidFileError, match=expected):
        open_recording(tmp_path / "bus.asc", dbc=databases)


# ------------------------------------------------------------------------- what a file may hold


@pytest.mark.parametrize("kind", logs.WRITERS)
def test_log_without_a_database_asks_for_it(tmp_path, kind):
    pytest.importorskip("asammdf" if kind == "mf4" else "can")
    logs.WRITERS[kind](tmp_path / "a.dat", logs.frames_of_every_kind(20))
    with pytest.raises(InvalidFileError, match="a log of CAN frames: give its DBC with --dbc"):
        open_recording(tmp_path / "a.dat")


def test_relative_times_of_asc_are_counted_from_the_event_before(tmp_path):
    """Whatever that was; python-can 4.6.1 takes them for times from the beginning."""
    head = "// 7.1\ndate Mon Nov 30 10:00:00.000 2026\nbase dec  timestamps relative\n"
    lines = ["0.000000 Start of measurement\n"]
    for k in range(40):
        data = " ".join(map(str, eec1(1000 + k)))
        lines += [" 0.060000 1  Statistic: D 0 R 1\n", f" 0.040000 1  217056256x  Rx  d 8 {data}\n"]
    (tmp_path / "a.txt").write_text(head + "".join(lines))
    recording = open_recording(tmp_path / "a.txt", dbc=logs.dbc(tmp_path / "a.dbc"))
    assert recording.rate == pytest.approx(10)
    np.testing.assert_array_equal(recording.read_all(["EngineSpeed"])[0], 1000.0 + np.arange(40))


def test_log_cut_short_is_read_and_says_so(tmp_path):
    pytest.importorskip("can")
    logs.blf(tmp_path / "a.blf", logs.frames_of_every_kind())
    dbc = logs.dbc(tmp_path / "a.dbc")
    whole = open_recording(tmp_path / "a.blf", dbc=dbc).read_all(["EngineSpeed"])[0]
    data = (tmp_path / "a.blf").read_bytes()
    (tmp_path / "b.blf").write_bytes(data[: len(data) * 3 // 4])
    recording = open_recording(tmp_path / "b.blf", dbc=dbc)
    cut = recording.read_all(["EngineSpeed"])[0]
    assert 100 < cut.size < whole.size
    np.testing.assert_array_equal(cut, whole[: cut.size])
    assert any("cut short" in n for n in recording.notes)


def test_container_of_zeros_is_rejected(tmp_path):
    body = zlib.compress(bytes(1 << 20), 1)
    container = struct.pack("<H6xL4x", 2, 1 << 27) + body
    head = struct.pack("<4sL8xQQLL", b"LOGG", 144, 0, 0, 1, 0).ljust(144, b"\0")
    base = struct.pack("<4sHHLL", b"LOBJ", 16, 1, 16 + len(container), 10)
    (tmp_path / "a.blf").write_bytes(head + base + container)
    with pytest.raises(InvalidFileError, match="a container claims 134217728 bytes"):
        open_recording(tmp_path / "a.blf", dbc=logs.dbc(tmp_path / "a.dbc"))


@pytest.mark.parametrize(
    "kind", ["blf", *(pytest.param(k, marks=pytest.mark.slow) for k in ("asc", "mf4", "dbc"))]
)
def test_mutated_log_is_read_or_rejected_within_bounds(tmp_path, kind):
    pytest.importorskip("asammdf" if kind == "mf4" else "can")
    log, dbc = tmp_path / "a.dat", logs.dbc(tmp_path / "a.dbc")
    how = {"compression_level": 0} if kind in ("blf", "dbc") else {}
    logs.WRITERS.get(kind, logs.blf)(log, logs.frames_of_every_kind(30), **how)
    wrong_file = dbc if kind == "dbc" else log
    said = rejections(
        wrong_file, mutants(wrong_file.read_bytes()), lambda: open_recording(log, dbc=dbc)
    )
    assert len(said) >= 4
    assert not any("\n" in one for one in said)


# ---------------------------------------------------------------------------------------- database


def test_database_of_j1939_is_read_as_by_canmatrix():
    """2000 signals of canmatrix's own J1939 database (BSD); it places the parameters we name."""
    formats = pytest.importorskip("canmatrix.formats")
    import canmatrix

    path = Path(next(iter(canmatrix.__path__)), "j1939.dbc")
    with path.open("rb") as file:
        matrix = formats.load(file, "dbc", key="")[""]
    own = read_can_database(path).messages
    compared = 0
    for frame in matrix.frames:
        name = frame.arbitration_id.id | (EXTENDED_BIT if frame.arbitration_id.extended else 0)
        theirs = sorted(
            (s.start_bit, s.size, s.is_signed, float(s.factor), float(s.offset), s.unit)
            for s in frame.signals
            if s.size <= 64  # longer ones are texts
        )
        if theirs:
            mine = sorted(
                (s.start, s.length, s.signed, s.factor, s.offset, s.unit) for s in own[name].signals
            )
            assert mine == theirs
            compared += len(mine)
    assert compared > 2000
    places = {
        int(alias[3:]): (m.pgn, s.start, s.length)
        for m in own.values() for s in m.signals for alias in s.aliases if alias[:3] == "SPN"
    }  # fmt: skip
    for spn, (_, *place) in J1939_PARAMETERS.items():
        assert places[spn] == tuple(place)


def test_multiplexor_that_is_missing_is_told(tmp_path):
    text = logs.DBC.replace(" Page M ", " Page ").replace("SG_MUL_VAL_ 291 Pressure", "VAL_OF 291")
    with pytest.raises(InvalidFileError, match="says when Pressure of Pages is sent"):
        read_can_database(logs.dbc(tmp_path / "a.dbc", text))
