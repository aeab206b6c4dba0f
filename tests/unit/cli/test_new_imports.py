"""`cardan new` from a VECTO job, its modal results and a table of hardpoints.

Jobs are written here, with invented numbers; keys and headings are those of VECTO.
"""

import json
import re
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner, Result

from cardan.application import reader
from cardan.application.bep_measures import read_measures
from cardan.application.duty_collective import duty_classes, text_with_duty
from cardan.application.hardpoint_table import read_hardpoints
from cardan.application.simulated_duty import read_simulated_duty
from cardan.application.templates import template_text
from cardan.approval.approval import approve_application
from cardan.cli import cli
from cardan.core.errors import DesignError, InvalidFileError
from cardan.core.units import deg, g, mm, rpm
from cardan.topics.design.corrections import find_corrections

FULL_LOAD = """\
engine speed [1/min],full load torque [Nm],motoring torque [Nm],PT1 [s]
# invented
600,400,-35,0.22
1200,900,-49,0.65
1600,900,-59,0.65
2000,790,-68,0.59
2300,600,-110,0.59
2400,0,-116,0.20
"""
LOSSES = """\
Input Speed [rpm],Input Torque [Nm],Torque Loss [Nm]
600,0,10
600,900,36
1200,900,27
1200,1400,50
"""
RESULTS = """\
# invented
time [s],dt [s],v_act [km/h],Gear [-],TC locked,P_axle_in [kW]
5,10,0,0,no,0
15,10,36,3,yes,20
25,10,36,3,yes,-10
65,70,72,5,yes,40
"""


def run(*arguments: object) -> Result:
    return CliRunner().invoke(cli, [str(a) for a in arguments], catch_exceptions=False)


def part(folder: Path, name: str, version: int, **body: object) -> None:
    text = json.dumps({"Header": {"FileVersion": version}, "Body": body}, indent=1)
    (folder / name).write_text(text, "utf-8")


@pytest.fixture
def job(tmp_path: Path) -> Path:
    folder = tmp_path / "job"
    (folder / "parts").mkdir(parents=True)
    part(folder, "a.vecto", 3, VehicleFile="a.vveh", EngineFile="parts\\E.veng",
         GearboxFile="a.vgbx")  # fmt: skip
    part(folder / "parts", "e.veng", 4, ModelName="6 l", Displacement="6010",
         RatedPower=166000.0, FullLoadCurve="e.vfld")  # fmt: skip
    (folder / "parts/e.vfld").write_text(FULL_LOAD, "utf-8")
    gears = [{"Ratio": r, "LossMap": "one.vtlm", "MaxTorque": ""} for r in (6.5, 3.7, 2.2, 1.4, 1)]
    part(folder, "a.vgbx", 6, Gears=[{"Ratio": 4.3, "LossMap": "0.96"}, *gears],
         TorqueConverter={"Enabled": False})  # fmt: skip
    (folder / "one.vtlm").write_text(LOSSES, "utf-8")
    axles = [{"Wheels": "265/70 R19.5", "AxleWeightShare": share, "TwinTyres": k == 1}
             for k, share in enumerate((0.4, 0.6))]  # fmt: skip
    part(folder, "a.vveh", 7, VehCat="RigidTruck", CurbWeight=4700.0, MassMax=11.99, rdyn=421.0,
         Retarder={"Type": "Secondary"}, AxleConfig={"Type": "4x2", "Axles": axles})  # fmt: skip
    return folder / "a.vecto"


def changed(file: Path, was: str, now: str) -> None:
    text = file.read_text("utf-8")
    assert was in text
    file.write_text(text.replace(was, now), "utf-8")


def test_vecto_job_gives_powertrain_of_application(job, tmp_path):
    out = tmp_path / "truck.yaml"
    made = run("new", out, "--vecto", job)
    assert made.exit_code == 0, made.stderr
    assert "enter the values of: vehicle.wheelbase_mm, driveline.points_mm" in made.stdout
    assert "Retarder is Secondary: not carried over" in made.stdout
    application = reader.read(out)
    engine, gearbox, vehicle = application.engine, application.gearbox, application.vehicle
    assert engine.speed == pytest.approx(np.array([600, 1200, 1600, 2000, 2300]) * rpm)
    assert engine.torque == pytest.approx([400, 900, 900, 790, 600])
    assert engine.power == pytest.approx(166e3)
    assert engine.brake_torque == pytest.approx(116)
    assert gearbox.ratios == (6.5, 3.7, 2.2, 1.4, 1.0)
    assert gearbox.efficiency == pytest.approx(1 - 27 / 900)  # the best at the largest torque
    axle = application.lines[0].axle
    assert (axle.ratio, axle.efficiency) == (4.3, 0.96)
    assert application.tyre.dynamic_radius == pytest.approx(421 * mm)
    assert vehicle.drive == "4x2"
    assert application.profile == "medium-truck"
    (gvw,) = vehicle.loads
    assert (gvw.front_load, gvw.rear_load) == pytest.approx((4796 * g, 7194 * g))


def test_remarks_on_a_job_and_its_duty_are_in_the_language(job, tmp_path):
    changed(job.parent / "a.vveh", '"VehCat"', '"TorqueLimits": {"2": 800}, "VehCat"')
    (tmp_path / "town.vmod").write_text(RESULTS, "utf-8")
    made = run("new", tmp_path / "t.yaml", "--vecto", job, "--vmod", tmp_path / "town.vmod",
               "--lang", "pt")  # fmt: skip
    assert made.exit_code == 0, made.stderr
    assert "Retarder é Secondary: não transferido." in made.stdout
    assert "limites de torque por marcha não são aplicados: marcha 2: 800 Nm." in made.stdout
    assert "simulado, não medido: VECTO, town.vmod, colunas P_axle_in, v_act" in made.stdout


def test_values_of_vecto_job_name_file_and_key(job, tmp_path):
    run("new", tmp_path / "truck.yaml", "--vecto", job)
    text = (tmp_path / "truck.yaml").read_text("utf-8")
    for said in ("# a.vgbx: Gears[0].Ratio", "# a.vgbx: Gears[1] to Gears[5].Ratio",
                 "# e.vfld: full load torque", "# e.veng: RatedPower", "# a.vveh: rdyn",
                 "# one.vtlm at 900 Nm", "# a.vgbx: Gears[0].LossMap"):  # fmt: skip
        assert said in text
    assert text.count("# placeholder") == 5


def test_application_with_placeholders_is_never_approved(job, tmp_path):
    out = tmp_path / "truck.yaml"
    run("new", out, "--vecto", job)
    checked = run("check", out)
    assert checked.exit_code == 1
    assert "INCOMPLETE" in checked.stdout
    assert "0 exceeded, 0 beyond recommended, 0 met" in checked.stdout
    assert "input missing: values in place of placeholders" in checked.stdout
    assert "driveline.points_mm" in " ".join(checked.stdout.split())
    assert approve_application(reader.read(out)).checks == ()
    for option in ("--states", "--all", "--phasings"):
        shown = run("check", out, option).stdout
        assert "Results by state: not evaluated; these keys hold placeholders" in shown
        assert "Joint angle, joint 1  " not in shown
        assert "as installed" not in shown
    for command in ("fix", "size"):
        refused = run(command, out)
        assert refused.exit_code == 2
        assert "still hold placeholders: vehicle.wheelbase_mm" in refused.stderr
    with pytest.raises(DesignError, match="still hold placeholders: vehicle"):
        find_corrections(reader.read(out))
    text = out.read_text("utf-8")
    start, end = text.index("placeholders:"), text.index("vehicle:")
    out.write_text(text[:start] + text[end:], "utf-8")
    assert approve_application(reader.read(out)).checks != ()


def test_placeholder_that_names_no_key_is_rejected(job, tmp_path):
    out = tmp_path / "truck.yaml"
    run("new", out, "--vecto", job)
    changed(out, "- vehicle.wheelbase_mm", "- vehicle.wheelbase")
    checked = run("check", out)
    assert checked.exit_code == 2
    assert "placeholders: no such key stands in this file" in checked.stderr
    assert "did you mean vehicle.wheelbase_mm?" in checked.stderr


def test_declaration_job_takes_radius_of_tyre_and_leaves_axle_loads_open(job, tmp_path):
    vehicle = job.with_name("a.vveh")
    for was, now in (("421.0", "0.0"), ("0.4", "0.0"), ("0.6", "0.0")):
        changed(vehicle, was, now)
    run("new", tmp_path / "truck.yaml", "--vecto", job)
    application = reader.read(tmp_path / "truck.yaml")
    assert application.tyre.dynamic_radius == pytest.approx(420.9 * mm)  # of 265/70 R19.5
    assert "vehicle.loads.gvw.cg_behind_front_mm" in application.placeholders
    assert application.vehicle.loads[0].mass == pytest.approx(11990)


@pytest.mark.parametrize("drive", ["4x4", "6x2", "6x4", "8x4"])
def test_every_wheel_configuration_of_a_job_is_read_and_left_incomplete(job, tmp_path, drive):
    axle = {"Wheels": "315/80 R22.5", "AxleWeightShare": 0.25, "TwinTyres": True}
    part(job.parent, "a.vveh", 8, MassMax=15.0, AxleConfig={"Type": drive, "Axles": [axle] * 5})
    made = run("new", tmp_path / "truck.yaml", "--vecto", job)
    assert made.exit_code == 0, made.stderr
    application = reader.read(tmp_path / "truck.yaml")
    assert [w for w in application.warnings if w.key != "placeholders"] == []
    assert len(application.lines) == (2 if drive in ("6x4", "8x4") else 1)
    assert approve_application(application).verdict == "incomplete"


@pytest.mark.parametrize(
    ("file", "was", "now", "said"),
    [
        ("a.vecto", '"a.vgbx"', '"b.vgbx"', "GearboxFile: names a file that does not exist"),
        ("a.vecto", "GearboxFile", "Gearbox", "GearboxFile: names no file; the keys of this file: "
         "EngineFile, Gearbox, VehicleFile"),
        ("a.vecto", "{", "<", "save the job as JSON: VECTO's XML is not read"),
        ("a.vgbx", "3.7", '"fast"', "Gears[2].Ratio: must be a number, 0 or above (got fast)"),
        ("a.vgbx", "3.7", "7.3", "Gears: ratios must fall from the lowest gear to the highest"),
        ("a.vveh", "11.99", "11990", "MassMax: must be tonnes, below 100 (got 11990)"),
        ("a.vveh", "421.0", "0.421", "rdyn: must be 200 to 1000 mm (got 0.421)"),
        ("a.vveh", "4x2", "four by two", "AxleConfig.Type: must be a configuration such as 4x2"),
        ("parts/e.vfld", "2000,790", "2000;790", "e.vfld:6: a row needs 4 numbers"),
        ("parts/e.vfld", "2000,790", "2000,inf", "e.vfld:6: a row needs 4 numbers (got inf)"),
        ("parts/e.vfld", "1600,", "1100,", "needs torques above 0 at speeds that rise"),
    ],
)  # fmt: skip
def test_wrong_vecto_job_is_rejected_with_file_key_and_value(job, tmp_path, file, was, now, said):
    changed(job.parent / file, was, now)
    made = run("new", tmp_path / "truck.yaml", "--vecto", job)
    assert made.exit_code == 2
    assert said in made.stderr
    assert not (tmp_path / "truck.yaml").exists()


@pytest.mark.parametrize(
    ("file", "changes"),
    [
        ("parts/e.vfld", {"speed [1/min]": "speed [rad/s]", "600,400": f"{600 * rpm},400",
                          "1200,900": f"{1200 * rpm},900", "1600,900": f"{1600 * rpm},900",
                          "2000,790": f"{2000 * rpm},790", "2300,600": f"{2300 * rpm},600",
                          "2400,0": f"{2400 * rpm},0"}),
        ("parts/e.vfld", {"load torque [Nm]": "load torque [kNm]", ",400,": ",0.4,",
                          ",900,": ",0.9,", ",790,": ",0.79,", ",600,": ",0.6,"}),
        ("parts/e.vfld", {"motoring torque [Nm]": "motoring torque [kN m]", "-35": "-0.035",
                          "-49": "-.049", "-59": "-.059", "-68": "-.068", "-110": "-.11",
                          "-116": "-0.116"}),
        ("parts/e.vfld", {"[1/min]": "[rpm]", "[Nm]": "(N*m)"}),
        ("parts/e.vfld", {"engine speed [1/min]": "n", "full load torque [Nm]": "Mfull"}),
        ("one.vtlm", {"Input Torque [Nm]": "Input Torque [kNm]", "900": "0.9", "1400": "1.4"}),
        ("one.vtlm", {"Torque Loss [Nm]": "Torque Loss [kNm]", "36": "0.036", "27": "0.027",
                      "50": "0.050"}),
        ("one.vtlm", {"Input Torque [Nm]": "into [kNm]", "900": "0.9", "1400": "1.4"}),
    ],
)  # fmt: skip
def test_tables_of_a_vecto_job_are_read_in_units_of_headings(job, tmp_path, file, changes):
    run("new", tmp_path / "usual.yaml", "--vecto", job)
    for was, now in changes.items():
        changed(job.parent / file, was, now)
    made = run("new", tmp_path / "other.yaml", "--vecto", job)
    assert made.exit_code == 0, made.stderr
    usual, other = ((tmp_path / f"{n}.yaml").read_text("utf-8") for n in ("usual", "other"))
    assert other == usual


@pytest.mark.parametrize(
    ("file", "was", "now", "said"),
    [
        ("parts/e.vfld", "load torque [Nm]", "load torque [lbft]", "e.vfld:1: full load torque: "
         "the heading names a unit that this column cannot have (got lbft); one of Nm"),
        ("parts/e.vfld", "load torque [Nm]", "load torque [kW]", "full load torque: "),
        ("parts/e.vfld", "speed [1/min]", "speed [km/h]", "engine speed: "),
        ("parts/e.vfld", "motoring torque [Nm]", "motoring torque [%]", "motoring torque: "),
        ("one.vtlm", "Input Torque [Nm]", "Input Torque [kW]", "input torque: "),
        ("one.vtlm", "Torque Loss [Nm]", "Torque Loss [kW]", "one.vtlm:1: torque loss: "),
        ("tc.vtcc", "Speed Ratio [-]", "Speed [1/min]", "tc.vtcc:2: Speed Ratio: "),
        ("tc.vtcc", "Torque Ratio [-]", "Torque Ratio [Nm]", "Torque Ratio: "),
    ],
)  # fmt: skip
def test_unit_that_a_column_of_a_vecto_job_cannot_have_is_rejected(
    job, tmp_path, file, was, now, said
):
    with_converter(job)
    changed(job.parent / file, was, now)
    made = run("new", tmp_path / "truck.yaml", "--vecto", job)
    assert made.exit_code == 2
    assert said in made.stderr
    assert not (tmp_path / "truck.yaml").exists()


def test_stall_ratio_of_a_converter_is_read_in_unit_of_its_heading(job, tmp_path):
    with_converter(job)
    run("new", tmp_path / "usual.yaml", "--vecto", job)
    changed(job.parent / "tc.vtcc", "Torque Ratio [-]", "Torque Ratio [%]")
    changed(job.parent / "tc.vtcc", ",1.93", ",193")
    changed(job.parent / "tc.vtcc", ",1.0,", ",100,")
    run("new", tmp_path / "other.yaml", "--vecto", job)
    for name in ("usual", "other"):
        application = reader.read(tmp_path / f"{name}.yaml")
        assert application.gearbox.converter_ratio == pytest.approx(1.93)


def with_converter(job: Path) -> None:
    changed(job.parent / "a.vgbx", '"Enabled": false', '"Enabled": true,\n"File": "tc.vtcc"')
    (job.parent / "tc.vtcc").write_text(
        "# invented\nSpeed Ratio [-],Torque Ratio [-],Input Torque [Nm]\n0,1.93,377\n1,1.0,0\n",
        "utf-8",
    )


def test_electric_vecto_job_is_rejected(job, tmp_path):
    changed(job, '"VehicleFile"', '"ElectricMotors": [{}],\n"VehicleFile"')
    made = run("new", tmp_path / "truck.yaml", "--vecto", job)
    assert (made.exit_code, "electric and hybrid" in made.stderr) == (2, True)


def test_text_of_job_cannot_add_keys_to_application(job, tmp_path):
    changed(job.parent / "parts/e.veng", '"6 l"', '"6 l\\nspeed_rpm: 9999"')
    assert run("new", tmp_path / "truck.yaml", "--vecto", job).exit_code == 0
    assert reader.read(tmp_path / "truck.yaml").speed is None


def test_import_writes_over_none_of_its_inputs(job):
    before = job.read_bytes()
    assert run("new", job, "--vecto", job, "--force").exit_code == 2
    assert job.read_bytes() == before


# --------------------------------------------------------------------------- duty cycle


def test_vmod_gives_duty_of_application(job, tmp_path):
    results = tmp_path / "town.vmod"
    results.write_text(RESULTS, "utf-8")
    made = run("new", tmp_path / "truck.yaml", "--vecto", job, "--vmod", results)
    assert made.exit_code == 0, made.stderr
    assert "3 classes of 100 s, 90 % of it in motion; simulated, not measured" in made.stdout
    text = (tmp_path / "truck.yaml").read_text("utf-8")
    assert "# simulated, not measured: VECTO, town.vmod" in text
    assert "11.1 % of that in overrun" in text
    duty = reader.read(tmp_path / "truck.yaml").duty
    slow = 10 / 0.421 * 4.3  # rad/s of the line at 36 km/h
    found = sorted((p.speed, p.torque, p.share) for p in duty)
    expected = [
        (slow, 10e3 / slow, 1 / 9),
        (slow, 20e3 / slow, 1 / 9),
        (2 * slow, 20e3 / slow, 7 / 9),
    ]
    assert np.array(found) == pytest.approx(np.array(expected), rel=1e-3)  # four digits are written


def test_power_close_to_rest_makes_no_more_torque_than_engine(job, tmp_path):
    results = tmp_path / "town.vmod"
    results.write_text(RESULTS + "101,1,0.3,1,yes,9\n", "utf-8")
    made = run("new", tmp_path / "truck.yaml", "--vecto", job, "--vmod", results)
    assert made.exit_code == 0, made.stderr
    duty = reader.read(tmp_path / "truck.yaml").duty
    assert max(p.torque for p in duty) == pytest.approx(900 * 6.5)


def test_vmod_replaces_duty_of_own_application_alone(tmp_path):
    results = tmp_path / "town.vmod"
    results.write_text(
        "dt [s],n_gbx_out_avg [1/min],T_gbx_out [Nm]\n1,100,800\n3,900,200\n", "utf-8"
    )
    own, out = tmp_path / "own.yaml", tmp_path / "out.yaml"
    run("new", own)
    assert run("new", out, "--of", own, "--vmod", results).exit_code == 0
    duty = reader.read(out).duty
    assert [(p.share, p.torque, p.speed / rpm) for p in duty] == [
        pytest.approx(v) for v in ((0.75, 200, 900), (0.25, 800, 100))
    ]
    before, after = (f.read_text("utf-8") for f in (own, out))
    assert after.split("\nduty:")[0] == before.split("\nduty:")[0]
    assert after.split("\nprime_mover:")[1] == before.split("\nprime_mover:")[1]


def test_vmod_without_torque_names_its_columns(job, tmp_path):
    results = tmp_path / "town.vmod"
    results.write_text("time [s],n [1/min]\n1,100\n2,100\n", "utf-8")
    made = run("new", tmp_path / "truck.yaml", "--vecto", job, "--vmod", results)
    assert made.exit_code == 2
    assert "needs a column T_gbx_out and n_gbx_out_avg or P_axle_in and v_act" in made.stderr
    assert "its columns: time [s], n [1/min]" in made.stderr


def test_duty_classes_keep_time_turns_and_bearing_wear():
    draw = np.random.default_rng(7)
    step, speed = draw.uniform(0.2, 1, 500), draw.uniform(5, 300, 500)
    torque = draw.normal(300, 400, 500)
    share, size, turns = duty_classes(step, torque, speed)
    assert share.sum() == pytest.approx(1)
    assert len(share) <= 48
    assert share @ turns == pytest.approx(step @ speed / step.sum())
    wear = step @ (speed * np.abs(torque) ** (10 / 3)) / step.sum()
    assert share @ (turns * size ** (10 / 3)) == pytest.approx(wear)


@pytest.mark.parametrize(
    ("torque", "speed", "values"),
    [
        ("[kNm]", "[rad/s]", "0.8,10"), ("[Nm]", "[1/min]", f"800,{300 / np.pi}"),
        ("", "", f"800,{300 / np.pi}"), ("[kN m]", "[rpm]", f"0.8,{300 / np.pi}"),
    ],
)  # fmt: skip
def test_vmod_is_read_in_units_of_its_headings(tmp_path, torque, speed, values):
    path = tmp_path / "t.vmod"
    path.write_text(f"dt [s],T_gbx_out {torque},n_gbx_out_avg {speed}\n1,{values}\n", "utf-8")
    found = read_simulated_duty(path)
    assert (found.torque, found.speed) == (pytest.approx([800]), pytest.approx([10]))


def test_power_and_road_speed_of_vmod_are_read_in_units_of_headings(tmp_path):
    path = tmp_path / "t.vmod"
    path.write_text("dt [min],v_act [m/s],P_axle_in [W]\n1,10,20000\n", "utf-8")
    found = read_simulated_duty(path, axle_ratio=4.0, dynamic_radius=0.5)
    assert (found.torque, found.speed) == (pytest.approx([250]), pytest.approx([80]))
    assert found.duration == 60


def test_unknown_unit_of_vmod_is_rejected_with_those_allowed(tmp_path):
    path = tmp_path / "t.vmod"
    path.write_text("dt [s],T_gbx_out [kW],n_gbx_out_avg [rpm]\n1,8,10\n", "utf-8")
    with pytest.raises(InvalidFileError, match=r"T_gbx_out: .* cannot have \(got kW\); one of Nm"):
        read_simulated_duty(path)


def test_comments_within_replaced_duty_go_with_it():
    text = "a: 1\nduty:   # published\n# a source\n  - {share_percent: 100}\n\nb: 2  # c\n"
    assert text_with_duty(text, "duty: []") == "a: 1\nduty: []\n\nb: 2  # c\n"


# --------------------------------------------------------------------------- hardpoints

POINTS = """\
point,x [mm],y [mm],z [mm]
Joint 1,0,0,0
gearbox,-500,0,35
joint_2,1250,0,-60.5
joint 3,2750,12,-165
center bearing 1,1100,0,-53
pinion,2950,12,-175
"""


def converted(text: str, sign: str, decimal: str) -> str:
    return text.replace(",", sign).replace(".", decimal)


@pytest.mark.parametrize(
    "table",
    [
        POINTS,
        converted(POINTS, ";", ","),
        converted(POINTS, "\t", ","),
        converted(POINTS, "\t", "."),
    ],
)
def test_hardpoints_of_csv_and_spreadsheet_move_line(tmp_path, table):
    (tmp_path / "points.csv").write_text(table, "utf-8")
    out = tmp_path / "truck.yaml"
    made = run("new", out, "--hardpoints", tmp_path / "points.csv")
    assert made.exit_code == 0, made.stderr
    (installed,) = reader.read(out).lines
    expected = np.array([[0, 0, 0], [1250, 0, -60.5], [2750, 12, -165]]) * mm
    assert installed.layout.points == pytest.approx(expected)
    side = np.arctan2([35, 10], [500, 200]) / deg
    text = out.read_text("utf-8")
    assert f"side_deg: {side[0]:.4f}" in text
    assert f"side_deg: {side[1]:.4f}" in text
    along = np.array([1250, -60.5]) / np.hypot(1250, 60.5)
    place = np.array([150, -7.5]) @ along
    assert installed.line.shafts[0].centre_bearing.from_rear_joint == pytest.approx(
        place * mm, abs=1e-6
    )


@pytest.mark.parametrize("encoding", ["utf-16-le", "utf-16-be"])
def test_table_in_utf_16_is_read_as_in_utf_8(tmp_path, encoding):
    """Excel's "Unicode text": a byte order mark, tabs, CRLF, decimal commas."""
    table = converted(POINTS, "\t", ",").replace("\n", "\r\n")
    data = f"\ufeff{table}".encode(encoding)
    (tmp_path / "p.txt").write_bytes(data)
    (tmp_path / "plain.csv").write_text(POINTS, "utf-8")
    assert read_hardpoints(tmp_path / "p.txt") == read_hardpoints(tmp_path / "plain.csv")
    (tmp_path / "p.txt").write_bytes(data[:-1])
    with pytest.raises(InvalidFileError, match="UTF-16 text is cut off or damaged"):
        read_hardpoints(tmp_path / "p.txt")


def test_catalogue_measures_and_vecto_table_may_be_utf_16(tmp_path):
    (tmp_path / "b.txt").write_bytes("code\tvalue [mm]\nBEP-L010\t4100,5\n".encode("utf-16"))
    assert read_measures(tmp_path / "b.txt").values == {"L010": pytest.approx(4.1005)}
    (tmp_path / "o.csv").write_bytes(
        "name,maker,peak_Nm,source,how_read\nÖ9,us,9000,ours,assumed\n".encode("utf-16")
    )
    file = tmp_path / "own.yaml"
    text = template_text("small").replace("driveline:", "catalogues: [o.csv]\ndriveline:", 1)
    file.write_text(re.sub(r"(?m)joints: \w+", "joints: Ö9", text), "utf-8")
    assert {j.peak_torque for j in reader.read(file).lines[0].line.joints} == {9000}
    results = tmp_path / "town.vmod"
    results.write_bytes("dt [s],T_gbx_out [Nm],n_gbx_out_avg [rpm]\n1,8,10\n".encode("utf-16"))
    assert read_simulated_duty(results).torque == pytest.approx([8])


@pytest.mark.parametrize("sign", [",", ";", "\t", "|"])
def test_sign_that_excel_names_above_a_table_divides_it(tmp_path, sign):
    table = converted(POINTS, sign, ".").replace("joint 3", "joint 5")
    (tmp_path / "plain.csv").write_text(POINTS, "utf-8")
    (tmp_path / "p.csv").write_text(f"SEP={sign}\r\n{table}", "utf-8")
    points, plain = (read_hardpoints(tmp_path / f"{n}.csv") for n in ("p", "plain"))
    assert [p.position for p in points] == [p.position for p in plain]
    made = run("new", tmp_path / "truck.yaml", "--hardpoints", tmp_path / "p.csv")
    assert "p.csv:6: names no point of this line (got joint 5)" in made.stderr
