"""What the driveline hands on as tables: bearing forces by order, and parameters of the line."""

import csv
import io
import re
from collections import defaultdict
from math import pi

import numpy as np
import pytest
from brackets import LINE
from click.testing import CliRunner
from scipy.io import loadmat

from cardan.application.reader import read
from cardan.approval.approval import approve_application
from cardan.cli.main import cli
from cardan.documents.approval_json import json_document
from cardan.documents.bearing_force_table import bearing_force_csv
from cardan.documents.parameter_sheet import WRITERS, Parameter, parameter_sheet

RUBBER = LINE.replace(
    "from_rear_joint_mm: 140",
    "from_rear_joint_mm: 140, vertical_stiffness_N_mm: 250, lateral_stiffness_N_mm: 180",
)


@pytest.fixture(scope="module", params=["rigid", "rubber"])
def approved(request, tmp_path_factory):
    path = tmp_path_factory.mktemp("line") / "a.yaml"
    path.write_text({"rigid": LINE, "rubber": RUBBER}[request.param] + "include: [unbalance]\n")
    return request.param, approve_application(read(path))


def forces(approval):
    """Return rows of the table by state, gear, mode, speed and bearing."""
    points = defaultdict(list)
    for row in csv.DictReader(io.StringIO(bearing_force_csv(approval.line_responses))):
        key = ("state", "gear", "mode", "speed_rpm", "torque_Nm", "bearing")
        points[tuple(row[k] for k in key)].append(row)
    return points


def test_orders_add_up_to_the_peak_of_the_verdict(approved):
    """Mean, orders and unbalance at the worst point, which the table has."""
    _, approval = approved
    highest = max(sum(float(r["F_N"]) for r in rows) for rows in forces(approval).values())
    [state] = json_document(approval)["states"]
    worst = state["centre_bearings"][0]["on_rubber"]["worst"]
    assert highest == pytest.approx(worst["peak_N"], rel=1e-5)


@pytest.mark.parametrize("approved", ["rigid"], indirect=True)
def test_amplitudes_and_phases_give_the_force_round_the_turn(approved):
    """On rigid bearings that of statics, sampled: Σ F cos(k θ + phase), at the slowest speed."""
    _, approval = approved
    [response] = approval.line_responses
    expected = response.rigid_loads.joint_loads.bearing_forces.values(16)[0, 0]
    slowest = min(forces(approval).items(), key=lambda item: float(item[0][3]))[1]
    theta = 2 * pi * np.arange(16) / 16
    found = np.zeros((16, 3))
    for row in slowest:
        if row["order"] == "1":  # of unbalance, whose phase is unknown
            continue
        for c, axis in enumerate("xyz"):
            phase = np.radians(float(row[f"phase_{axis}_deg"]))
            found[:, c] += float(row[f"F{axis}_N"]) * np.cos(int(row["order"]) * theta + phase)
    assert np.abs(found - expected).max() < 1e-3 * np.abs(expected).max()


def test_parameters_are_the_lines_in_all_three_files(approved):
    kind, approval = approved
    sheet = parameter_sheet(approval)
    written = {ending: write(sheet) for ending, write in WRITERS.items()}
    table = {r["parameter"]: r for r in csv.DictReader(io.StringIO(written[".csv"].decode()))}
    script = dict(re.findall(r"^cardan\.(\S+) = (.*?);", written[".m"].decode(), re.M))
    data = loadmat(io.BytesIO(written[".mat"]), squeeze_me=True, struct_as_record=False)["cardan"]
    assert set(script) == {re.sub(r"(position|direction)\(\d\)$", r"\1", name) for name in table}

    def number(name):
        assert float(script[name]) == pytest.approx(float(table[name]["value"]), nan_ok=True)
        return float(script[name])

    # A thin ring by its middle radius, exact: polar inertia 2 π ρ r t (r² + t²/4) L.
    r, t, length = 0.058, 0.004, 1.2
    polar = 2 * pi * r * t * (r**2 + t**2 / 4)
    first = "line(1).shaft(1)."
    assert np.isnan(number(f"{first}polar_inertia"))  # no yoke's inertia is given
    assert number(f"{first}tube_polar_inertia") == pytest.approx(7850 * polar * length, rel=1e-3)
    shear = 210e9 / 2.6  # of a tube whose steel is not given
    assert number(f"{first}torsional_stiffness") == pytest.approx(shear * polar / length, rel=1e-3)
    assert table[f"{first}polar_inertia"]["unit"] == "kg m^2"
    [state] = json_document(approval)["states"]
    for k, joint in enumerate(state["joints"], 1):
        angle = number(f"line(1).state(1).joint({k}).angle")
        assert np.degrees(angle) == pytest.approx(joint["angle_deg"], rel=1e-6)
        assert data.line.state.joint[k - 1].angle == pytest.approx(angle, rel=1e-8)
    stiff = {"rigid": (np.inf, np.inf), "rubber": (250e3, 180e3)}[kind]
    bearing = "line(1).centre_bearing(1)."
    found = [number(f"{bearing}{way}_stiffness") for way in ("vertical", "lateral")]
    assert found == pytest.approx(stiff)
    assert [data.line.shaft[k].length for k in (0, 1)] == pytest.approx([1.2, 1.5])
    assert script["line(1).state(1).joint(1).position"].startswith("[")


def test_lines_with_and_without_bearings_stand_in_one_matlab_array():
    line = [{"bearing": [{"mass": Parameter(2.0)}]}, {"bearing": []}]
    written = WRITERS[".mat"]({"line": line})
    data = loadmat(io.BytesIO(written), squeeze_me=True, struct_as_record=False)["cardan"]
    assert (data.line[0].bearing.mass, data.line[1].bearing.size) == (2.0, 0)


@pytest.mark.parametrize(
    ("option", "name", "said"),
    [
        ("--bearing-forces", "a.parquet", "ends in .csv"),
        ("--parameters", "a.txt", ".csv or .m or .mat"),
        ("--parameters", "a.yaml", ".csv or .m or .mat"),
    ],
)
def test_table_by_another_ending_is_rejected(tmp_path, option, name, said):
    path = tmp_path / "a.yaml"
    path.write_text(LINE)
    done = CliRunner().invoke(cli, ["check", str(path), option, str(tmp_path / name)])
    assert done.exit_code == 2
    assert said in done.output
    assert path.read_text() == LINE


def test_tables_are_written_of_one_application_with_a_bearing(tmp_path):
    (tmp_path / "a.yaml").write_text(LINE)
    short = re.sub(r"    - \{length_mm: 1200.*\n", "", LINE)
    short = short.replace("[3.0, 1.0, 4.5, 2.0]", "[3.0, 4.5, 2.0]")
    (tmp_path / "b.yaml").write_text(short.replace("[0.0, 1.5, -0.8, 0.6]", "[0.0, 1.5, 0.6]"))
    out = tmp_path / "out.csv"

    def run(*names, option="--bearing-forces"):
        files = [str(tmp_path / name) for name in names]
        return CliRunner().invoke(cli, ["check", *files, "-q", option, str(out)])

    for option in ("--bearing-forces", "--parameters"):
        both = run("a.yaml", "b.yaml", option=option)
        assert (both.exit_code, out.exists()) == (2, False)
        assert f"give one file with {option}" in both.output
    none = run("b.yaml")
    assert (none.exit_code, out.exists()) == (2, False)
    assert "there are no bearing forces to write" in none.output
    assert run("a.yaml").exit_code in (0, 1)
    assert out.read_text().startswith("line,state,gear")
