"""`cardan new` from measures by the codes of ISO 21308, and a duty cycle from a recording."""

import re
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner, Result

from cardan.application import reader
from cardan.application.bep_measures import KNOWN_CODES, read_measures
from cardan.application.simulated_duty import read_simulated_duty
from cardan.cli import cli
from cardan.core.units import mm, rpm

TWO_AXLES = """\
Code\tMeasure\tValue [mm]
BEP-L001\tOverall length\t8125,5
BEP-L011\tWheelbase\t4250,0
BEP-L012.1\tSpacing of axles\t4250
BEP-H034\tHeight of the frame\t975
"""
BOGIE = "code;value [mm]\nBEP-L011;4500\nBEP-L012.2;1350\nBEP-L014;540\nBEP-L010;5850\n"


def run(*arguments: object) -> Result:
    return CliRunner().invoke(cli, [str(a) for a in arguments], catch_exceptions=False)


def written(folder: Path, table: str, *options: object) -> tuple[Result, Path]:
    source, out = folder / "chassis.txt", folder / "out.yaml"
    source.write_text(table, "utf-8")
    return run("new", out, "--bep", source, *options), out


# --------------------------------------------------------------------------- ISO 21308


def test_wheelbase_by_code_moves_vehicle_and_last_joint(tmp_path):
    run("new", tmp_path / "own.yaml", "--example", "van")
    made, out = written(tmp_path, TWO_AXLES, "--of", tmp_path / "own.yaml")
    assert made.exit_code == 0, made.stderr
    before, after = (reader.read(p) for p in (tmp_path / "own.yaml", out))
    assert after.vehicle.wheelbase == pytest.approx(4250 * mm)
    longer = float(after.vehicle.wheelbase - before.vehicle.wheelbase)
    was, now = (a.lines[0].layout.points for a in (before, after))
    assert now[-1, 0] - was[-1, 0] == pytest.approx(longer)
    assert np.array_equal(now[:-1], was[:-1])
    said = " ".join(made.stdout.split())
    assert "wheelbase 4250 mm, BEP-L011" in said
    assert "not used: BEP-L001 overall length" in said
    assert "not public, not read: BEP-H034" in said


def test_points_given_beside_codes_stay_where_they_are(tmp_path):
    run("new", tmp_path / "own.yaml")
    points = "name\tL [mm]\tW [mm]\tH [mm]\njoint 1\t900\t0\t-300,5\njoint 2\t2150\t0\t-361\n"
    points += "joint 3\t3650\t12\t-465,5\n"
    (tmp_path / "points.txt").write_text(points, "utf-8")
    made, out = written(
        tmp_path, BOGIE, "--of", tmp_path / "own.yaml", "--hardpoints", tmp_path / "points.txt"
    )
    assert made.exit_code == 0, made.stderr
    application = reader.read(out)
    expected = np.array([[900, 0, -300.5], [2150, 0, -361], [3650, 12, -465.5]]) * mm
    assert application.lines[0].layout.points == pytest.approx(expected)
    assert application.vehicle.wheelbase == pytest.approx(5040 * mm)


@pytest.mark.parametrize(
    ("spacing", "behind"), [("BEP-L010;5850", "540"), ("L012.2;1350", "540"),
                            ("bep L012.2;1350", "-540")]
)  # fmt: skip
def test_load_point_of_bogie_gives_wheelbase_and_share_of_driven_axle(tmp_path, spacing, behind):
    table = f"code;value [mm]\nBEP-L011;4500\nBEP-L014;{behind}\n{spacing}\n"
    made, out = written(tmp_path, table)
    assert made.exit_code == 0, made.stderr
    vehicle = reader.read(out).vehicle
    assert vehicle.drive == "6x2"
    assert vehicle.wheelbase == pytest.approx((4500 + float(behind)) * mm)
    assert vehicle.driven_share == pytest.approx(1 - 540 / 1350)


def test_wheelbase_of_two_front_axles_is_from_their_load_point(tmp_path):
    own = tmp_path / "own.yaml"
    run("new", own)
    text = re.sub(r"  driven_share:.*\n", "", own.read_text("utf-8"))
    own.write_text(text.replace("drive: 6x2", "drive: 8x4"), "utf-8")
    table = "code;value [mm]\nBEP-L011;4500\nBEP-L013;850\nBEP-L014;675\n"
    made, out = written(tmp_path, table, "--of", own)
    assert made.exit_code == 0, made.stderr
    assert reader.read(out).vehicle.wheelbase == pytest.approx((4500 + 675 - 850) * mm)


def test_unit_of_heading_counts_and_theoretical_wheelbase_needs_nothing_else(tmp_path):
    made, out = written(tmp_path, "code,value [m]\nBEP-L015,5.04\n")
    assert made.exit_code == 0, made.stderr
    assert reader.read(out).vehicle.wheelbase == pytest.approx(5.04)


@pytest.mark.parametrize(
    "table",
    [
        'code,value [m]\nBEP-L015,"4,5"\n',
        'code,"measure, in short",value [cm]\nBEP-L015,"a, b",450\n',
        "code,axles,value [mm]\nBEP-L015,2,4500\n",
        "value [mm],code\n4500,BEP-L015\n",
        f"code,value [in]\nBEP-L015,{4.5 / 0.0254}\n",
        f"code,value_ft\nBEP-L015,{4.5 / 0.3048}\n",
        "All lengths in [MM]\ncode,value [mm]\nBEP-L015,4500\n",
    ],
)
def test_value_of_code_is_column_with_unit_and_quotes_keep_decimal_comma(tmp_path, table):
    (tmp_path / "t.csv").write_text(table, "utf-8")
    assert read_measures(tmp_path / "t.csv").values == pytest.approx({"L015": 4.5})


def test_new_wheelbase_names_table_in_place_of_old_source(tmp_path):
    own = tmp_path / "own.yaml"
    run("new", own, "--example", "van")
    text = own.read_text("utf-8")
    points = "points_mm: [[0, 0, 0], [1430, 0, -105]]"
    assert "wheelbase_mm: 3000              # published\n" in text
    own.write_text(text.replace(points, f"{points}   # published: sheet 3"), "utf-8")
    made, out = written(tmp_path, "BEP-L015,3100\n", "--of", own)
    assert made.exit_code == 0, made.stderr
    now = out.read_text("utf-8")
    assert "wheelbase_mm: 3100              # chassis.txt\n" in now
    assert "[1530, 0, -105]]   # points_mm[2][1] chassis.txt; others published: sheet 3\n" in now


@pytest.mark.parametrize(
    ("table", "said"),
    [
        ("name,x\njoint 1,0\n", "no row has a code of ISO 21308 and a value"),
        ("BEP-L011,4100\n", "gives no wheelbase between the load points of the axles; BEP-L015, "
         "or BEP-L011 + BEP-L014; it has BEP-L011"),
        ("BEP-L015;5040\nBEP-L011;4500\nBEP-L014;500\n", "BEP-L015 and BEP-L011, BEP-L014 "
         "contradict each other: wheelbases of 5040 mm and 5000 mm"),
        ("BEP-L015,5.04\n", "BEP-L015: the wheelbase must be 500 to 20000 mm (got 5.04 mm)"),
        ("BEP-L015,abc\n", "chassis.txt:1: BEP-L015: is no number"),
        ("BEP-L015,5040\nL015,5040\n", "chassis.txt:2: BEP-L015: stands there twice"),
        ("a;v\nBEP-L011;4500\nBEP-L014;1400\nBEP-L012.2;1350\n", "the load point lies outside"),
        ("a [mm];b [m]\nBEP-L015;5040\n", "the heading must name one unit"),
        ("code,min [mm],max [mm]\nBEP-L015,4500,4800\n", "chassis.txt:1: the heading must name the "
         "unit of one column, the value (got min [mm] and max [mm])"),
        ("code,axles,value\nBEP-L015,2,4500\n", "chassis.txt:2: BEP-L015: has several numbers"),
        ("code,value [m]\nBEP-L015,4,5\n", "chassis.txt:2: BEP-L015: has more cells than the "
         "heading (got BEP-L015 4 5); write a number with a decimal comma in quotes"),
        ('code,value [m]\nBEP-L015,"4,5\n', "chassis.txt:2: the quotes of this row do not match"),
    ],
)  # fmt: skip
def test_wrong_table_of_codes_is_rejected(tmp_path, table, said):
    made, out = written(tmp_path, table)
    assert made.exit_code == 2
    assert said in " ".join(made.stderr.split())
    assert not out.exists()


def test_every_code_without_use_is_listed(tmp_path):
    codes = [c for c in KNOWN_CODES if c not in ("L010", "L011", "L012", "L013", "L014", "L015")]
    lines = [f"BEP-{c}.1,{k}" for k, c in enumerate(codes, 1)]
    (tmp_path / "t.csv").write_text("\n".join(["BEP-L015,5040", *lines, "BEP-W030.4R,1"]), "utf-8")
    found = read_measures(tmp_path / "t.csv")
    assert found.unused == (*(f"{c}.1" for c in codes), "W030.4R")
    assert found.unknown == ()


@pytest.mark.parametrize(
    ("code", "said"),
    [
        ("pt", ("entre-eixos 4100 mm, BEP-L015.", "não usados: BEP-L001 comprimento total.")),
        ("it", ("passo 4100 mm, BEP-L015.", "non usati: BEP-L001 lunghezza totale.")),
    ],
)
def test_notes_on_measures_are_in_the_language(tmp_path, code, said):
    table = "code,value [mm]\nBEP-L015,4100\nBEP-L001,7000\nBEP-Z999,1\n"
    made, _ = written(tmp_path, table, "--lang", code)
    assert made.exit_code == 0, made.stderr
    shown = " ".join(made.stdout.split())
    assert all(one in shown for one in said)
    assert not {"wheelbase", "used", "not", "public", "axle", "line"} & set(shown.split())


# --------------------------------------------------------------------------- recordings, VECTO 2


def recording(folder: Path, *, speed: str = "Propshaft speed [rpm]", sign: int = 1) -> Path:
    """Twenty seconds at rest, sixty at 800 N m and 1000 rpm, twenty in overrun, at 10 Hz."""
    rows = [(0, 0)] * 200 + [(800, 1000)] * 600 + [(-200, 2000)] * 200
    lines = [f"{k / 10},{sign * t},{sign * n}" for k, (t, n) in enumerate(rows)]
    path = folder / "drive.csv"
    path.write_text("\n".join([f"time [s],Shaft torque [Nm],{speed}", *lines]) + "\n", "utf-8")
    return path


@pytest.mark.parametrize(
    ("options", "sign"),
    [
        ((), 1),
        ((), -1),  # in reverse
        (("--torque", "Shaft torque:Nm", "--speed", "Propshaft speed:rpm"), 1),
    ],
)
def test_duty_of_recording_is_measured_time_at_torque_and_speed(tmp_path, options, sign):
    own, out = tmp_path / "own.yaml", tmp_path / "out.yaml"
    run("new", own)
    source = recording(tmp_path, sign=sign)
    made = run("new", out, "--of", own, "--duty-from", source, *options)
    assert made.exit_code == 0, made.stderr
    assert "2 classes of 100 s, 80 % of it in motion; measured: drive.csv" in made.stdout
    text = out.read_text("utf-8")
    assert "duty:                             # measured: drive.csv, channels Shaft torque" in text
    assert "25.0 % of that in overrun" in text
    found = sorted((p.torque, p.speed / rpm, p.share) for p in reader.read(out).duty)
    assert np.array(found) == pytest.approx(np.array([[200, 2000, 0.25], [800, 1000, 0.75]]))


def test_speed_of_vehicle_turns_shaft_by_axle_and_tyre(tmp_path):
    own, out = tmp_path / "own.yaml", tmp_path / "out.yaml"
    run("new", own)
    source = recording(tmp_path, speed="Vehicle speed [km/h]")
    text = source.read_text("utf-8").replace(",1000\n", ",36\n").replace(",2000\n", ",72\n")
    source.write_text(text, "utf-8")
    made = run("new", out, "--of", own, "--duty-from", source)
    assert made.exit_code == 0, made.stderr
    application = reader.read(own)
    tyre = application.tyre
    turns = 10 / (tyre.dynamic_radius or tyre.static_radius) * application.lines[0].axle.ratio
    assert min(p.speed for p in reader.read(out).duty) == pytest.approx(turns, rel=1e-3)


@pytest.mark.parametrize(
    ("was", "now", "said"),
    [
        ("Shaft torque [Nm]", "Shaft torque 2 [rpm]", "one channel must be the shaft speed; "),
        ("Shaft torque [Nm]", "something", "one channel must be the shaft torque; none could be"),
        (",800,", ",,", "torque and speed are known in 40 % of it; a duty cycle needs 50 %"),
        (",2000\n", ",0\n", None),
        ("1000\n", "0\n", None),
    ],
)
def test_recording_without_torque_or_speed_is_no_duty(tmp_path, was, now, said):
    own, out = tmp_path / "own.yaml", tmp_path / "out.yaml"
    run("new", own)
    source = recording(tmp_path)
    text = source.read_text("utf-8")
    assert was in text
    source.write_text(text.replace(was, now), "utf-8")
    made = run("new", out, "--of", own, "--duty-from", source)
    assert made.exit_code == (0 if said is None else 2), made.output
    assert said is None or said in " ".join(made.stderr.split())
    assert out.exists() == (said is None)


def test_recording_at_rest_is_no_duty(tmp_path):
    own, source = tmp_path / "own.yaml", tmp_path / "rest.csv"
    run("new", own)
    rows = "".join(f"{k / 10},{k % 7},0\n" for k in range(200))
    source.write_text(f"time [s],Shaft torque [Nm],Shaft speed [rpm]\n{rows}", "utf-8")
    made = run("new", tmp_path / "out.yaml", "--of", own, "--duty-from", source)
    assert (made.exit_code, "the vehicle never moves" in made.stderr) == (2, True), made.stderr


@pytest.mark.parametrize(
    ("options", "said"),
    [
        (("--torque", "T:Nm"), "--torque and --speed name channels of --duty-from"),
        (("--duty-from", "drive.csv"), "--duty-from is the duty of a vehicle"),
        (("--duty-from", "drive.csv", "--vmod", "drive.csv"), "are two duty cycles"),
    ],
)
def test_options_of_duty_that_say_two_things_are_rejected(tmp_path, monkeypatch, options, said):
    recording(tmp_path)
    monkeypatch.chdir(tmp_path)
    made = run("new", "out.yaml", *options)
    assert (made.exit_code, said in made.stderr) == (2, True), made.stderr


def test_results_of_vecto_2_give_power_into_axle(tmp_path):
    """Rows of its kind: at the wheels, less the brakes', and what the axle loses."""
    rows = [(0, 36, 76, 0, 4), (1, 36, -60, -45, 3), (2, 36, 76, 0, 4), (3, 36, 76, 0, 4)]
    head = "time [s],v_act [km/h],Pwheel [kW],Pbrake [kW],Ploss Diff [kW],Gear [-],FC-AUXc [g/h]\n"
    lines = "".join(f"{t},{v},{w},{b},{d},3,-\n" for t, v, w, b, d in rows)
    path = tmp_path / "two.vmod"
    path.write_text("\ufeff" + head + lines, "utf-8")
    found = read_simulated_duty(path, axle_ratio=4.0, dynamic_radius=0.5)
    assert found.speed == pytest.approx([80, 80])  # 10 m/s over 0.5 m, times 4
    assert sorted(found.torque) == pytest.approx([12e3 / 80, 80e3 / 80])
    assert found.overrun_share == pytest.approx(1 / 3)  # the last row lasts no time
    assert "columns Pwheel, Pbrake, Ploss Diff, v_act" in str(found.origin)
