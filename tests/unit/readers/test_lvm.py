"""LabVIEW text: times for each channel, and segments; one time column is in `test_time_axes.py`."""

import numpy as np
import pytest

from cardan.core.errors import InvalidFileError
from cardan.physics.signals.recording import Channel
from cardan.readers import lvm
from cardan.readers.dispatch import open_recording

N, RATE = 400, 200.0
T = np.arange(N) / RATE
X = np.round(50 * np.sin(2 * np.pi * 5 * T), 3)


def file_head(times="One", separator="Tab", decimal="."):
    return (
        f"LabVIEW Measurement\t\nWriter_Version\t2\nSeparator\t{separator}\nDecimal_Separator"
        f"\t{decimal}\nX_Columns\t{times}\nTime_Pref\tRelative\n***End_of_Header***\t\n\t\n"
    )


def segment(
    rows, *, names=("S1", "speed"), units=("MPa", "rpm"), steps=(1 / RATE,) * 2, x0=(0.0, 0.0),
    begun=("10:00:00.5",) * 2, samples=N, times="One", axis="Time",
):  # fmt: skip
    named = "\t".join(f"X_Value\t{n}" for n in names) if times == "Multi" else "\t".join(
        ("X_Value", *names))  # fmt: skip
    head = {
        "Channels": [len(names)], "Samples": [samples] * 2, "Date": ["2026/11/28"] * 2,
        "Time": begun, "Y_Unit_Label": units, "X_Dimension": [axis] * 2, "X0": x0, "Delta_X": steps,
    }  # fmt: skip
    apart = "\t\t" if times == "Multi" else "\t"
    text = "".join(f"{key}\t{apart.join(map(str, v))}\t\n" for key, v in head.items())
    return f"{text}***End_of_Header***\t\t\n{named}\tComment\n" + "".join(
        "\t".join("" if np.isnan(v) else f"{v:.6f}" for v in row) + "\n" for row in rows
    )


def columns(*x):
    return np.stack(np.broadcast_arrays(*x), axis=-1)


NONE = np.full(N, np.nan)


def test_channels_with_times_of_their_own_are_aligned(tmp_path):
    """The second runs at half the rate, begins half a second later and ends before."""
    slow = np.where(np.arange(N) < 100, np.arange(N), np.nan)
    rows = columns(T, X, slow / 100, 900 + slow)
    text = file_head("Multi") + segment(
        rows, times="Multi", steps=(1 / RATE, 0.01), begun=("10:00:00.5", "10:00:01.0")
    )
    (tmp_path / "a.dat").write_text(text)
    recording = open_recording(tmp_path / "a.dat")
    assert recording.rate == RATE
    assert recording.channels == (Channel("S1", "MPa"), Channel("speed", "rpm"))
    first, speed = recording.read_all()
    np.testing.assert_allclose(first[:N], X, atol=1e-9)
    known = np.flatnonzero(~np.isnan(speed))
    assert (known[0], known[-1]) == (100, 298)
    np.testing.assert_allclose(speed[known], 900 + (known - 100) / 2, atol=1e-6)


@pytest.mark.parametrize("times", ["One", "No"])
@pytest.mark.parametrize("at_once", [lvm.ROWS_AT_ONCE, 7])
def test_segments_follow_one_another_and_holes_are_missing(tmp_path, monkeypatch, times, at_once):
    monkeypatch.setattr("cardan.readers.lvm.ROWS_AT_ONCE", at_once)
    clock = T if times == "One" else NONE
    rows = columns(clock, X, 900 + T)
    text = file_head(times) + segment(rows[:100], samples=100)
    text += "\n" + segment(rows[:100], samples=100, begun=("10:00:01.0",) * 2)
    text += "\n" + segment(rows[:200], samples=200, begun=("10:00:01.75",) * 2, x0=(0.25, 0.25))
    text += "\n" + segment(rows[:50], samples=50, begun=("10:00:03.0",) * 2)
    (tmp_path / "a.lvm").write_text(text)
    recording = open_recording(tmp_path / "a.lvm")
    assert recording.rate == RATE
    first, speed = recording.read_all()
    assert np.flatnonzero(np.isnan(first)).tolist() == list(range(200, 300))
    parts = [X[:100], X[:100], NONE[:100], X[:200], X[:50]]
    np.testing.assert_allclose(first, np.concatenate(parts))
    np.testing.assert_allclose(speed[300:500], 900 + T[:200], atol=1e-6)


ROWS = columns(T, X, X)
REFUSED = {
    "its heads of LabVIEW do not end": file_head(),
    "the axis of its samples is no time: Frequency": file_head() + segment(ROWS, axis="Frequency"),
    "its Delta_X is not a number.*fast": file_head() + segment(ROWS, steps=("fast", 0.1)),
    "more than one step or start.*Delta_X 0.005, 0.01": file_head() + segment(
        ROWS, steps=(0.005, 0.01)),
    "no recording has such a sample rate.*1e.12 Hz": file_head("No") + segment(
        columns(NONE, X, X), steps=(1e-12,) * 2, times="No"),
    "its rows have fewer fields .*1 for 2 channels": file_head() + segment(ROWS[:, :1]),
    "do not follow one another in time.*begins -1 s": file_head() + 2 * segment(ROWS[:200]),
    "other channels or steps than the first.*S1, n": file_head() + segment(ROWS[:200]) + segment(
        ROWS, names=("S1", "n"), begun=("10:00:01.5",) * 2),
    "a row of a segment does not hold its numbers.*nonsense": file_head() + segment(
        ROWS[:200]) + "nonsense\n" + segment(ROWS, begun=("10:00:01.5",) * 2),
    "its segments have times for each channel": file_head("Multi") + 2 * segment(
        columns(T, X, T, X), times="Multi"),
}  # fmt: skip


@pytest.mark.parametrize("match", REFUSED)
def test_labview_text_that_contradicts_itself_is_rejected(tmp_path, match):
    (tmp_path / "a.lvm").write_text(REFUSED[match])
    with pytest.raises(InvalidFileError, match=match):
        open_recording(tmp_path / "a.lvm").read_all()


def test_channels_without_samples_are_left_out(tmp_path):
    """Their Delta_X is 1, whatever that of the others: with_empty_fields.lvm of lvm_read (MIT)."""
    head = file_head() + segment(columns(T, X, NONE), steps=("0.005000", "1.000000"))
    (tmp_path / "a.lvm").write_text(head.replace("Samples\t400\t400", "Samples\t400\t0"))
    recording = open_recording(tmp_path / "a.lvm")
    assert (recording.rate, recording.names) == (RATE, ("S1",))
    assert "no samples, left out: speed" in recording.notes


@pytest.mark.parametrize(("text", "rate"), [("0.000977", 1024), ("9.765625E-4", 1024),
                                            ("0.000250", 4000), ("1.000000E-2", 100)])  # fmt: skip
def test_step_of_few_digits_is_that_of_the_roundest_rate(tmp_path, text, rate):
    rows = columns(NONE, X, X)
    (tmp_path / "a.lvm").write_text(file_head("No") + segment(rows, steps=(text,) * 2))
    assert open_recording(tmp_path / "a.lvm").rate == pytest.approx(rate, rel=1e-12)


def test_uneven_times_are_rejected_whatever_the_step_says(tmp_path):
    """A log by the second states Delta_X 1: with_comments.lvm of lvm_read (MIT)."""
    uneven = np.cumsum(np.random.default_rng(1).uniform(0.3, 2, N))
    (tmp_path / "a.lvm").write_text(file_head() + segment(columns(uneven, X, X), steps=(1.0, 1.0)))
    with pytest.raises(InvalidFileError, match=r"time is not even|contradict each other"):
        open_recording(tmp_path / "a.lvm").read_all()


def test_truncated_labview_text_is_noted(tmp_path):
    (tmp_path / "a.lvm").write_text(file_head() + segment(ROWS[:300]))
    recording = open_recording(tmp_path / "a.lvm")
    assert recording.notes == ("the file is cut short: 300 of 400 samples are there",)
