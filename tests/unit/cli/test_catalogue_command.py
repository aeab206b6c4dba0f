"""`cardan catalogue`: what fits first, with its source and how that was read."""

import csv
import json
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner
from repository import EXAMPLES

from cardan.application.catalogue import Catalogue, find_shipped_part
from cardan.application.catalogue_rows import PART_KIND_OR_FILE_BY_CATALOGUE_NAME, rows_of_catalogue
from cardan.application.limit_profiles import load_profile, profile_names
from cardan.cli import cli
from cardan.core.provenance import PROVENANCE_CODES, Source
from cardan.core.units import deg, hour, lbft, rpm
from cardan.model.parts import JointSize
from cardan.physics.strength.bearing_life import (
    cross_joint_life_consumption_rate,
    joint_life,
    rated_torque_from_catalogue,
)
from cardan.topics.design.part_selection import (
    PartRequirement,
    rank_candidates,
    smallest_joint_name,
)

CATALOGUES = Path(rows_of_catalogue.__code__.co_filename).with_name("catalogues")
WIDE = {"COLUMNS": "200"}
"""Of a terminal that breaks no line."""


def run(*arguments):
    return CliRunner().invoke(cli, ["catalogue", *arguments])


@pytest.mark.parametrize("name", list(PART_KIND_OR_FILE_BY_CATALOGUE_NAME))
def test_every_catalogue_row_has_source_and_reading(name):
    for row in rows_of_catalogue(name):
        assert row.source.title
        assert row.source.how_read in PROVENANCE_CODES


@pytest.mark.parametrize("name", profile_names())
def test_every_limit_has_reading_status(name):
    for limit in load_profile(name)[1]:
        assert limit.source.how_read in PROVENANCE_CODES
        assert {n for n, _ in limit.source.apart} <= {"normal", "maximum", "band"}


def test_nominal_torque_is_not_used_as_peak_torque():
    """What somebody calls nominal is held against nothing, so such joints have no peak."""
    with (CATALOGUES / "joints.csv").open(encoding="utf-8", newline="") as opened:
        rows = list(csv.DictReader(opened))
    assert len(rows) > 120
    nominal = [r for r in rows if r["nominal_Nm"]]
    assert len(nominal) > 60
    for row in nominal:
        assert row["peak_Nm"] != row["nominal_Nm"]
        if row["series"].startswith(("SW", "agri")):
            assert find_shipped_part(row["name"], "joint").peak_torque is None


def test_reading_status_is_kept_per_value():
    joint = find_shipped_part("2040", "joint")
    assert joint.source.how_read == "from memory"
    assert joint.source_of("speed_angle_max").how_read == "re-read"
    assert joint.source_of("angle_max").how_read == "assumed"
    assert Source("x", how_read="re-read").source_of_value("anything").how_read == "re-read"


def test_fitting_parts_are_sorted_smallest_first():
    found = rank_candidates(rows_of_catalogue("joints"), PartRequirement(torque=1200.0))
    kept = [f for f in found if f.is_sufficient]
    peaks = [f.row.part.peak_torque for f in kept]
    assert peaks == sorted(peaks)
    every = [j for j in Catalogue().parts("joint") if j.peak_torque and j.peak_torque >= 1200]
    assert len(kept) == len(every)
    assert all(f.max_utilisation > 1 for f in found[len(kept) :])


def test_joint_life_selection_follows_life_formula():
    """20319 h is AISCO's law by hand for 500 N·m of 2000, at 1500 rpm and 5 deg."""
    asked = PartRequirement(torque=500.0, speed=1500 * rpm, angle=5 * deg, life=15000 * hour)
    found = rank_candidates(rows_of_catalogue("joints"), asked)
    for fit in found[:5]:
        worn = cross_joint_life_consumption_rate(
            500.0,
            speed=1500 * rpm,
            angle=5 * deg,
            rated_torque=rated_torque_from_catalogue(fit.row.part),
            prime_mover_factor=1.0,
        )
        share = 15000 * hour / float(np.asarray(joint_life(worn)))
        assert fit.utilisations["joint_life"] == pytest.approx(share)
        assert fit.is_sufficient
    best = smallest_joint_name(rows_of_catalogue("joints"), asked)
    kept = [f.row.part for f in found if f.is_sufficient]
    assert isinstance(kept[0], JointSize)
    assert best == min(kept, key=rated_torque_from_catalogue).name


def test_tube_selection_checks_shear_and_critical_speed():
    found = rank_candidates(
        rows_of_catalogue("tubes"), PartRequirement(torque=4000.0, speed=3000 * rpm, length=2.0)
    )
    kept = [f for f in found if f.is_sufficient]
    assert [f.sort_size for f in kept] == sorted(f.sort_size for f in kept)
    slender = next(f for f in found if f.row.name == "63.5x2.4")
    assert slender.utilisations["critical_speed_ratio"] > 1  # and 4 kN·m would shear it as well
    assert not slender.is_sufficient


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["joints", "--for", "1200Nm"], ["2C", "checked", "fit"]),
        (["joints", "--for", "885 lb-ft"], ["2C", "fit"]),
        (["tubes", "--for", "1,2kNm"], ["kg/m", "shear"]),
        (["joint", "1810"], ["bearing_Td_Nm", "how it was read: quoted"]),
        (["tyres", "R22.5"], ["315/80 R22.5"]),
        (["limits", "torsional_acceleration"], ["500", "quoted"]),
        (["limits"], ["balance_grade"]),
        (["bearings"], ["Toyota", "NO rating"]),
        (["torsion"], ["clutch"]),
        (["typical"], ["engine.inertia_base"]),
        (["joints"], ["SWP 160"]),
        ([], ["joints", "limits"]),
        (["joints", "--for", "2MNm"], []),
        (["joints", "--for", "99999kNm"], ["comes nearest"]),
    ],
)
def test_catalogue_output_fits_80_columns(arguments, words):
    result = run(*arguments)
    if arguments[-1:] == ["2MNm"]:
        assert result.exit_code == 2
        assert "12Nm or 12kNm" in result.output
        return
    assert result.exit_code == 0
    assert max(map(len, result.output.splitlines())) <= 80
    for word in words:
        assert word in result.output


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["joins"], "there is no catalogue of joins; did you mean joints?"),
        (["joints", "1811"], "no row of joints is called or says 1811; did you mean 1810?"),
        (["tyres", "--for", "100Nm"], "tyres carry no torque"),
        (["joints", "--speed", "100"], "go with --for"),
        (["joints", "--for", "100", "--hours", "5"], "--hours needs --speed and --angle"),
    ],
)
def test_invalid_catalogue_option_is_rejected(arguments, message):
    result = run(*arguments)
    assert result.exit_code == 2
    assert message in result.output


def test_catalogue_json_has_values_source_and_reading():
    (row,) = json.loads(run("joints", "1810", "--json", "-").stdout)
    assert row["values"]["peak_Nm"] == pytest.approx(12000 * lbft, abs=1)
    assert (row["how_read"], row["apart"]["cup_diameter"]) == ("second hand", "from memory")
    found = json.loads(run("joints", "--for", "1200", "--json", "-").stdout)
    assert found[0]["fits"]
    assert found[0]["used"]["joint_torque_utilisation"] == pytest.approx(0.8)


def test_catalogue_of_application_file_is_searched(tmp_path):
    row = "name,peak_Nm,source,how_read\nours,1250,drawing 4,re-read\n"
    (tmp_path / "ours.csv").write_text(row, encoding="utf-8")
    (tmp_path / "truck.yaml").write_text(
        "title: x\ncatalogues: ours.csv\nspeed_rpm: 1000\ntorque_Nm: 100\ndriveline:\n"
        "  slopes: {side_deg: [1, 2, 1]}\n  shafts: [{length_mm: 900}]\n",
        encoding="utf-8",
    )
    result = run("joints", "--for", "1200Nm", "--file", str(tmp_path / "truck.yaml"))
    assert result.output.splitlines()[1].startswith("ours")
    assert "drawing 4 (checked)" in result.output


def test_explain_lists_limits_of_quantity_with_reading():
    told = CliRunner(env=WIDE).invoke(cli, ["explain", "tube_shear_utilisation"]).output
    assert "Limits (heavy-truck): normal <= 0.6700, maximum <= 1.000" in told
    assert "Engineering judgement (by definition; normal: assumed)" in told
    band = CliRunner().invoke(cli, ["explain", "half_critical_band"]).output
    assert "outside 0.4200 … 0.5800" in band


@pytest.mark.slow
def test_check_json_has_reading_of_bound_and_data():
    file = EXAMPLES / "refuse-collector-6x2.yaml"
    document = json.loads(CliRunner().invoke(cli, ["check", "--json", "-", str(file)]).stdout)
    shear = [c for c in document["checks"] if c["quantity"] == "tube_shear_utilisation"]
    assert {(c["verdict"], c["how_read"]) for c in shear} == {("pass", "assumed")}  # its normal
    speed = [c for c in document["checks"] if c["quantity"] == "joint_speed"]
    assert {c["how_read"] for c in speed} == {"re-read"}  # the joint's own, read apart
    rows = {(d["kind"], d["name"]): d for d in document["data"]}
    assert rows["joint", "2040"]["how_read"] == "from memory"
    assert rows["joint", "2040"]["apart"]["speed_max"] == "re-read"
    assert rows["tube", "120x4"]["parts"] == [1, 2, 3]
    printed = (
        CliRunner(env=WIDE).invoke(cli, ["check", str(file), "--lang", "pt", "--sources"]).output
    )
    assert "tubo 120x4 (cardan 1, cardan 2, cardan 3): conferido; material: adotado" in printed


@pytest.mark.parametrize(
    ("said", "message"),
    [("remembered", "must be re-read"), ("re-read; assumed", "behind a semicolon")],
)
def test_unknown_reading_status_is_rejected(tmp_path, said, message):
    (tmp_path / "ours.csv").write_text(f"name,peak_Nm,how_read\nours,900,{said}\n", "utf-8")
    file = tmp_path / "truck.yaml"
    file.write_text(
        "title: x\ncatalogues: ours.csv\nspeed_rpm: 1000\ntorque_Nm: 100\ndriveline:\n"
        "  slopes: {side_deg: [1, 2, 1]}\n  joints: ours\n  shafts: [{length_mm: 900}]\n",
        encoding="utf-8",
    )
    result = CliRunner().invoke(cli, ["check", str(file)])
    assert result.exit_code == 2
    assert message in result.output
