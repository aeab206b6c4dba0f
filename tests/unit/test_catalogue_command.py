"""`cardan catalogue`: what fits first, with its source and how that was read."""

import csv
import json
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

from cardan.base.source import HOW_READ, Source
from cardan.base.units import deg, hour, lbft, rpm
from cardan.cli import cli
from cardan.files.catalogue import Catalogue, find
from cardan.files.limit import limits, names
from cardan.files.shelf import SHELVES, shelf
from cardan.model.parts import JointSize
from cardan.shaft.life import joint_life, life_rating, wear
from cardan.study.selection import Asked, fits, smallest

CATALOGUES = Path(shelf.__code__.co_filename).with_name("catalogues")
WIDE = {"COLUMNS": "200"}
"""Of a terminal that breaks no line."""


def run(*arguments):
    return CliRunner().invoke(cli, ["catalogue", *arguments])


@pytest.mark.parametrize("name", list(SHELVES))
def test_every_row_has_a_source_and_says_how_it_was_read(name):
    for row in shelf(name):
        assert row.source.title
        assert row.source.how_read in HOW_READ


@pytest.mark.parametrize("name", names())
def test_every_limit_says_how_it_was_read(name):
    for limit in limits(name)[1]:
        assert limit.source.how_read in HOW_READ
        assert {n for n, _ in limit.source.apart} <= {"normal", "maximum", "band"}


def test_no_nominal_torque_is_a_peak():
    """What somebody calls nominal is held against nothing, so such joints have no peak."""
    with (CATALOGUES / "joints.csv").open(encoding="utf-8", newline="") as opened:
        rows = list(csv.DictReader(opened))
    assert len(rows) > 120
    nominal = [r for r in rows if r["nominal_Nm"]]
    assert len(nominal) > 60
    for row in nominal:
        assert row["peak_Nm"] != row["nominal_Nm"]
        if row["series"].startswith(("SW", "agri")):
            assert find(row["name"], "joint").peak_torque is None


def test_values_are_read_one_by_one():
    joint = find("2040", "joint")
    assert joint.source.how_read == "from memory"
    assert joint.source_of("speed_angle_max").how_read == "re-read"
    assert joint.source_of("angle_max").how_read == "assumed"
    assert Source("x", how_read="re-read").of("anything").how_read == "re-read"


def test_what_fits_comes_smallest_first():
    found = fits(shelf("joints"), Asked(torque=1200.0))
    kept = [f for f in found if f.fits]
    peaks = [f.row.part.peak_torque for f in kept]
    assert peaks == sorted(peaks)
    every = [j for j in Catalogue().every("joint") if j.peak_torque and j.peak_torque >= 1200]
    assert len(kept) == len(every)
    assert all(f.most > 1 for f in found[len(kept) :])


def test_a_life_is_asked_by_the_formula():
    """20319 h is AISCO's law by hand for 500 N·m of 2000, at 1500 rpm and 5 deg."""
    asked = Asked(torque=500.0, speed=1500 * rpm, angle=5 * deg, life=15000 * hour)
    found = fits(shelf("joints"), asked)
    for fit in found[:5]:
        worn = wear(500.0, speed=1500 * rpm, angle=5 * deg,
                    rated_torque=life_rating(fit.row.part), prime_mover_factor=1.0)  # fmt: skip
        share = 15000 * hour / float(np.asarray(joint_life(worn)))
        assert fit.used["joint_life"] == pytest.approx(share)
        assert fit.fits
    best = smallest(shelf("joints"), asked)
    kept = [f.row.part for f in found if f.fits]
    assert isinstance(kept[0], JointSize)
    assert best == min(kept, key=life_rating).name


def test_tubes_are_asked_for_shear_and_whirl():
    found = fits(shelf("tubes"), Asked(torque=4000.0, speed=3000 * rpm, length=2.0))
    kept = [f for f in found if f.fits]
    assert [f.size for f in kept] == sorted(f.size for f in kept)
    slender = next(f for f in found if f.row.name == "63.5x2.4")
    assert slender.used["critical_speed_ratio"] > 1  # and 4 kN·m would shear it as well
    assert not slender.fits


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["joints", "--for", "1200Nm"], ["2C", "re-read", "fit"]),
        (["joints", "--for", "885 lb-ft"], ["2C", "fit"]),
        (["tubes", "--for", "1,2kNm"], ["kg/m", "shear"]),
        (["joint", "1810"], ["bearing_Td_Nm", "how it was read: second hand"]),
        (["tyres", "R22.5"], ["315/80 R22.5"]),
        (["limits", "torsional_acceleration"], ["500", "second hand"]),
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
def test_what_is_printed_fits_a_terminal(arguments, words):
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
def test_what_is_asked_wrong_is_told(arguments, message):
    result = run(*arguments)
    assert result.exit_code == 2
    assert message in result.output


def test_its_json_has_numbers_source_and_reading():
    (row,) = json.loads(run("joints", "1810", "--json", "-").stdout)
    assert row["values"]["peak_Nm"] == pytest.approx(12000 * lbft, abs=1)
    assert (row["how_read"], row["apart"]["cup_diameter"]) == ("second hand", "from memory")
    found = json.loads(run("joints", "--for", "1200", "--json", "-").stdout)
    assert found[0]["fits"]
    assert found[0]["used"]["joint_torque_utilisation"] == pytest.approx(0.8)


def test_a_files_own_catalogues_are_on_the_shelf(tmp_path):
    row = "name,peak_Nm,source,how_read\nours,1250,drawing 4,re-read\n"
    (tmp_path / "ours.csv").write_text(row, encoding="utf-8")
    (tmp_path / "truck.yaml").write_text(
        "title: x\ncatalogues: ours.csv\nspeed_rpm: 1000\ntorque_Nm: 100\ndriveline:\n"
        "  slopes: {side_deg: [1, 2, 1]}\n  shafts: [{length_mm: 900}]\n",
        encoding="utf-8",
    )
    result = run("joints", "--for", "1200Nm", "--file", str(tmp_path / "truck.yaml"))
    assert result.output.splitlines()[1].startswith("ours")
    assert "drawing 4 (re-read)" in result.output


def test_explain_says_what_limits_a_quantity_and_how_that_was_read():
    told = CliRunner(env=WIDE).invoke(cli, ["explain", "tube_shear_utilisation"]).output
    assert "Limits (heavy-truck): normal <= 0.6700, maximum <= 1.000" in told
    assert "House practice (by definition; normal: assumed)" in told
    band = CliRunner().invoke(cli, ["explain", "half_critical_band"]).output
    assert "outside 0.4200 … 0.5800" in band


def test_a_check_says_how_its_bound_was_read_and_what_it_stands_on():
    file = Path(__file__).parents[2] / "examples/refuse-collector-6x2.yaml"
    document = json.loads(CliRunner().invoke(cli, ["check", "--json", "-", str(file)]).stdout)
    shear = [c for c in document["checks"] if c["quantity"] == "tube_shear_utilisation"]
    assert {(c["verdict"], c["how_read"]) for c in shear} == {("pass", "assumed")}  # its normal
    speed = [c for c in document["checks"] if c["quantity"] == "joint_speed"]
    assert {c["how_read"] for c in speed} == {"re-read"}  # the joint's own, read apart
    rows = {(d["kind"], d["name"]): d for d in document["data"]}
    assert rows["joint", "2040"]["how_read"] == "from memory"
    assert rows["joint", "2040"]["apart"]["speed_max"] == "re-read"
    assert rows["tube", "120x4"]["parts"] == [1, 2, 3]
    printed = CliRunner(env=WIDE).invoke(cli, ["check", str(file), "--lang", "pt"]).output
    assert "tubo 120x4 (árvore 1, árvore 2, árvore 3): relido; material: suposto" in printed


@pytest.mark.parametrize(
    ("said", "message"),
    [("remembered", "must be re-read"), ("re-read; assumed", "behind a semicolon")],
)
def test_a_word_nobody_knows_is_refused(tmp_path, said, message):
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
