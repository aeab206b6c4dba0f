"""Tables of `cardan life`: rainflow matrices, damage and orders over time, and back."""

import csv
import json
from dataclasses import replace

import numpy as np
import pytest
from click.testing import CliRunner

import cardan
from cardan.cli.life import life
from cardan.core.errors import DesignError, InvalidFileError
from cardan.core.units import MPa
from cardan.physics.fatigue.rainflow import rainflow
from cardan.topics.recording.options import AnalysisOptions
from cardan.topics.recording.result_tables import order_track
from cardan.topics.recording.shaft_signals import measured_shaft_angle
from cardan.topics.recording.study import analyse_recording

pytest.importorskip("pyarrow")

RATE = 400.0
T = np.arange(8000) / RATE
HOW = ("--gauge", "S1:MPa", "--sn", "30,2e6,5", "--between-samples", "no")
SN = {"gauges": ("S1:MPa",), "sn": "30,2e6,5", "between_samples": "no"}


def stress(seed, scale=1.0):
    """A stress in MPa, never on the edge of a bin."""
    rough = np.random.default_rng(seed).standard_normal(T.size)
    return scale * (40 * np.sin(2 * np.pi * 3.1 * T) + 12 * rough) + 0.0314159


def write(path, x, speed=None):
    columns = [T, x] if speed is None else [T, x, speed]
    head = "time [s],S1 [MPa]" + (",n [rpm]" if speed is not None else "")
    np.savetxt(path, np.stack(columns, 1), "%.10g", delimiter=",", header=head, comments="")
    return path


def run(*arguments, code=0):
    done = CliRunner().invoke(life, [*map(str, arguments)])
    assert done.exit_code == code, done.output
    return done.output


def rows_of(path):
    with path.open() as file:
        return list(csv.DictReader(file))


@pytest.mark.parametrize("suffix", [".csv", ".parquet"])
def test_matrices_written_are_histograms_of_the_recorded_cycles(tmp_path, suffix):
    x = stress(1)
    x[3000:3200] = np.nan
    path = write(tmp_path / "a.csv", x)
    out = tmp_path / f"from{suffix}", tmp_path / f"range{suffix}"
    run(path, *HOW, "--from-to", out[0], "--range-mean", out[1])
    cycles = rainflow(np.round(x, 8))
    for file, along, across in (
        (out[0], cycles.start, cycles.end), (out[1], cycles.range, cycles.mean)
    ):  # fmt: skip
        found = cardan.read_rainflow(file)
        table = found.tables["S1"]
        assert found.grades == {"S1": "good"}
        width = table.width / MPa
        edges = [width * np.arange(k.min(), k.max() + 2) for k in (table.row, table.column)]
        expected, *_ = np.histogram2d(along, across, bins=edges, weights=cycles.count)
        assert table.total == cycles.count.sum() == expected.sum()
        got = np.zeros_like(expected)
        got[table.row - table.row.min(), table.column - table.column.min()] = table.count
        np.testing.assert_array_equal(got, expected)
        again = found.write(tmp_path / f"again{suffix}", replace=True)
        assert again.read_bytes() == file.read_bytes()
    pytest.importorskip("pandas")
    frame = cardan.read_rainflow(out[0]).to_frame()
    assert list(frame.columns[:3]) == ["gauge", "from_low_MPa", "from_high_MPa"]
    assert frame["count"].sum() == cycles.count.sum()


def test_campaign_has_the_merged_matrices_of_its_recordings(tmp_path):
    """One of twice the stress and so wider bins, driven three times."""
    for name, x in (("a", stress(1)), ("b", stress(2, 2.0))):
        run(write(tmp_path / f"{name}.csv", x), *HOW, "--from-to", tmp_path / f"{name}.parquet")
    (tmp_path / "c.yaml").write_text(
        "campaign: Two\nrecordings:\n  - {file: a.csv}\n  - {file: b.csv, times: 3}\n"
        "gauges: ['S1:MPa']\nstrength: {amplitude_MPa: 30, cycles: 2e6, slope: 5}\n"
        "between_samples: no\n"
    )
    run(tmp_path / "c.yaml", "--from-to", tmp_path / "mix.csv")
    one, other = (cardan.read_rainflow(tmp_path / f"{n}.parquet") for n in "ab")
    assert one.tables["S1"].width < other.tables["S1"].width
    merged = one.merged(other, times=3)
    assert merged.write(tmp_path / "merged.csv").read_text() == (tmp_path / "mix.csv").read_text()
    total = one.tables["S1"].total + 3 * other.tables["S1"].total
    assert merged.tables["S1"].total == pytest.approx(total)
    with pytest.raises(DesignError, match="times must be finite and above 0"):
        one.merged(other, times=0)


@pytest.mark.parametrize("sharp", ["yes", "no"])
def test_damage_track_adds_up_to_the_damage(tmp_path, sharp):
    path, out = write(tmp_path / "a.csv", stress(3)), tmp_path / "track.csv"
    told = run(path, *HOW[:4], "--between-samples", sharp, "--damage-track", out, "--json")
    (gauge,) = json.loads(told)["gauges"]
    rows = rows_of(out)
    assert [float(r["time_s"]) for r in rows] == list(range(20))
    damage = sum(float(r["damage"]) + float(r["open_damage"]) for r in rows)
    assert damage == pytest.approx(gauge["damage"], rel=1e-6)
    x = np.round(stress(3), 8).reshape(20, -1)
    if sharp == "no":
        np.testing.assert_allclose([float(r["high_MPa"]) for r in rows], x.max(1), rtol=1e-6)


def test_order_track_is_amplitude_and_phase_of_the_order(tmp_path):
    """20 MPa of order 2 at 40 degrees, on a shaft that runs up from 600 to 1000 rpm."""
    rpm = 600 + 20 * T
    angle = 2 * np.pi * np.concatenate([[0], np.cumsum((rpm[1:] + rpm[:-1]) / 120 / RATE)])
    x = 20 * np.cos(2 * angle + np.radians(40)) + 5 * np.cos(angle)
    path = write(tmp_path / "a.csv", x, rpm)
    answer = analyse_recording(path, AnalysisOptions(**SN)).answer
    turning = AnalysisOptions(**SN, speed="n")
    found = order_track(replace(answer, angle=measured_shaft_angle(turning, answer.recording)))
    rows = [dict(zip(found, row, strict=True)) for row in zip(*found.values(), strict=True)]
    second = [r for r in rows if r["order"] == 2]
    assert len(second) > 10
    assert {r["order"] for r in rows} == {1, 2, 4}
    for r in second[1:-1]:
        assert r["amplitude_MPa"] == pytest.approx(20, rel=0.02)
        assert r["phase_deg"] == pytest.approx(40, abs=3)
        assert r["speed_rpm"] == pytest.approx(600 + 20 * r["time_s"], rel=0.01)
    first = [r["amplitude_MPa"] for r in rows if r["order"] == 1]
    np.testing.assert_allclose(first, 5, rtol=0.03)


def test_tables_that_cannot_be_are_refused_before_reading(tmp_path):
    path = tmp_path / "a.csv"
    path.write_text("time [s],S1 [MPa]\n0,1\n")
    assert "a table ends in .csv or .parquet" in run(path, *HOW, "--from-to", "a.txt", code=2)
    told = run(path, *HOW, "--order-track", tmp_path / "o.csv", code=2)
    assert "--order-track needs the shaft's angle" in told
    told = run(path, *HOW, "--from-to", path, code=2)
    assert "would write over the file" in told


@pytest.mark.parametrize(
    ("row", "said"),
    [
        ("S1,0,0.25,1,1.25,2,good", "no edges of a bin"),
        ("S1,0,0.262144,0.1,0.362144,2,good", "no edges of a bin"),
        ("S1,0,0.262144,0.262144,0.524288,-2,good", "count finite and above 0"),
        ("S1,0,0.262144,0.262144,0.524288,x,good", "must be numbers"),
        ("S1,0,nan,0.262144,0.524288,1,good", "edges must be finite"),
        ("S1,0,0.262144,0.262144,0.524288,1,fine", "data must be good, doubtful"),
    ],
)
def test_rows_that_are_no_bins_are_refused_by_line(tmp_path, row, said):
    path = tmp_path / "a.csv"
    head = "gauge,from_low_MPa,from_high_MPa,to_low_MPa,to_high_MPa,count,data"
    path.write_text(f"{head}\nS1,0,0.262144,0.262144,0.524288,2,good\n{row}\n")
    with pytest.raises(InvalidFileError, match=rf"a\.csv:3: .*{said}"):
        cardan.read_rainflow(path)
    path.write_text("a,b\n1,2\n")
    with pytest.raises(InvalidFileError, match="holds no rainflow matrix"):
        cardan.read_rainflow(path)


def test_rejected_data_are_marked_in_every_table(tmp_path):
    """Spikes nobody decided on make most of the damage: counted as recorded, and marked."""
    x = stress(1)
    x[np.arange(1000, 7000, 997)] += 400
    run(write(tmp_path / "b.csv", stress(2)), *HOW, "--from-to", tmp_path / "good.csv")
    path, out = write(tmp_path / "a.csv", x), tmp_path / "matrix.csv"
    run(path, *HOW, "--from-to", out, "--damage-track", tmp_path / "track.csv", code=1)
    found = cardan.read_rainflow(out)
    assert found.grades == {"S1": "data rejected"}
    assert {r["data"] for r in rows_of(tmp_path / "track.csv")} == {"data rejected"}
    assert found.tables["S1"].cycles().range.max() > 400 * MPa
    good = cardan.read_rainflow(tmp_path / "good.csv")
    assert good.grades != found.grades
    assert good.merged(found).grades == {"S1": "data rejected"}
