"""What an application says is all in its inputs: each entry changed alone changes a row."""

import re
from pathlib import Path

import pytest

from cardan import files
from cardan.base.errors import CardanError
from cardan.files.entered import entered
from cardan.report.inputs import SAID, inputs
from cardan.report.language import Language

EXAMPLES = sorted((Path(__file__).parents[2] / "examples").glob("*.yaml"))
PICK_UP = next(p for p in EXAMPLES if p.stem == "pick-up-4x4")
RARE = """\
title: what few files have
coast_torque_Nm: 300
vehicle:
  {drive: 6x2, wheelbase_mm: 4000, driven_share: 1, grade_percent: 10,
   loads: {gvw: {mass_kg: 18000, cg_behind_front_mm: 2500, cg_height_mm: 1400}},
   auxiliary: [{behind_front_mm: 5200, load_kN: 20}]}
engine: {speed_rpm: 2000, torque_Nm: 900}
gearbox: {ratios: [6, 1], transfer_ratio: 1.5, retarder_torque_Nm: 1000}
axle: {ratio: 4}
tyre: {static_radius_mm: 480, friction: 0.8}
suspension:
  {spring: {load_N: [0, 20000, 60000], deflection_mm: [0, 60, 150]}, unsprung_mass_kg: 700,
   linkage: {travel_mm: [-100, 0, 100], dx_mm: [1, 0, 2], pitch_deg: [1, 0, -1]}, squat: false}
torsion:
  {axle_inertia_kgm2: 5, axle_stiffness_Nm_rad: 20000, gearbox_inertia_kgm2: 0.1,
   gearbox_stiffness_Nm_rad: 30000, damping_ratio: 0.03}
duty: [{share_percent: 100, torque_Nm: 500, speed_rpm: 1500, angle_deg: 4}]
obstacles: [{name: ball, start_mm: [500, 0, 300], diameter_mm: 100}]
driveline:
  slopes: {side_deg: [3, 1, 4, 2], top_deg: [0, 1, 0, 0]}
  shafts:
    - length_mm: 1200
      tube:
        {outer_mm: 100, wall_mm: 4,
         material: {name: mild, youngs_modulus_GPa: 206, density_kg_m3: 7850}}
      centre_bearing:
        {from_rear_joint_mm: 140, stiffness_N_mm: 200, axial_stiffness_N_mm: 20, loss_factor: 0.1,
         travel_mm: 8, bracket: {stiffness_N_mm: [4000, 5000, 6000], loss_factor: 0.02}}
    - {length_mm: 1500, tube: 100x3, phase_deg: 0}
states:
  - {name: as given}
  - {name: low, travel_mm: -20, pitch_deg: 1, load: gvw}
  - {name: quick, torque_Nm: 800, speed_rpm: 1200}
limits:
  profile: protractor
  overrides:
    - {quantity: joint_angle, normal: 4, maximum: 6, sense: "<=", source: house}
    - {quantity: half_critical_band, band: [0.4, 0.6], source: house}
"""
ODD = """\
title: what fewer have
vehicle: {drive: 4x4, wheelbase_mm: 4000, grade_deg: 5}
torque_Nm: 500
speed_rpm: 2000
drivelines:
  front:
    runs: forward
    drives: front
    points_mm: [[0, 0, 0], [1200, 0, -50]]
    gearbox_slope: {side_deg: 1, top_deg: 0.5}
    pinion_slope: {side_deg: 2}
    shafts: [{tube: {outer_mm: 80, wall_mm: 3, material: steel}}]
limits:
  - {quantity: joint_angle, normal: 4, maximum: 6, sense: "<=", source: house}
  - {quantity: half_critical_band, band: [0.4, 0.6], source: house}
"""


def paths(at: str) -> str:
    return re.sub(r"\[\d+\]", "", at)


def other(app, at):
    """Return the application with one number changed alone; None where none can be."""
    was = app.written.numbers[at]
    for to in (was * 1.1 if was else 0.1, was * 0.9, was + 1, was - 1):
        try:
            return files.change(app, {at: to}, warn=False)
        except CardanError:
            continue
    return None


def said(app, say):
    return [(i.group, i.name, i.value) for i in inputs(app, say)]


@pytest.mark.slow
@pytest.mark.parametrize(
    "of", [*EXAMPLES, RARE, ODD], ids=[*(p.stem for p in EXAMPLES), "rare", "odd"]
)
def test_every_number_is_in_the_inputs(of):
    """Of 223 kinds of numbers 121 were not: where a pinion sits, a joint's peak torque."""
    say = Language("en").typeset
    app = files.read(of) if isinstance(of, Path) else files.loads(of)
    was, seen = said(app, say), set()
    for at in files.addresses(app):
        if (kind := paths(at)) in seen:
            continue
        changed = other(app, at)
        if changed is not None:
            seen.add(kind)
            assert said(changed, say) != was, at
    assert len(seen) > 12


def test_what_has_a_row_in_words_stands_in_a_file_above_and_all_else_by_its_address():
    """A path that is no entry's would hide nothing, and so would one that nobody tries."""
    say, tried = Language("it").typeset, set()
    for app in (*map(files.loads, (RARE, ODD)), *map(files.read, EXAMPLES)):
        rows = {i.name: i.value for i in inputs(app, say)}
        groups = {i.name: i.group for i in inputs(app, say)}
        for one in entered(app):
            tried.add(one.path)
            if one.path not in SAID:
                assert rows[one.at].count(";") >= len(one.values) - 1
                if one.at.startswith("drivelines."):
                    assert groups[one.at] == f"Linea {one.at.split('.')[1]}"
            else:
                assert one.at not in rows
    assert SAID - tried == set()


@pytest.mark.parametrize(
    ("was", "now"),
    [("[gravity, unbalance]", "[gravity]"), ("name: double 1310", "name: double 7"),
     ("prime_mover: diesel", "prime_mover: petrol"), ("limits: van", "limits: heavy-truck"),
     ("tube: 3.000x0.083in", "tube: 100x3")],
)  # fmt: skip
def test_words_are_inputs_too(was, now):
    text, say = PICK_UP.read_text("utf-8"), Language("en").typeset
    assert was in text
    one, two = (files.loads(t, folder=PICK_UP.parent) for t in (text, text.replace(was, now)))
    assert said(one, say) != said(two, say)


def test_variants_and_parts_of_a_catalogue_are_told_by_what_was_changed():
    app = files.read(PICK_UP)
    at, spread = "drivelines.main.shafts[1].tube.material.yield_MPa", "tyre.dynamic_radius_mm"
    rows = {i.name: i.value for i in inputs(files.change(app, {at: 310.5}), Language("pt").typeset)}
    assert rows[at] == "310,5"
    assert at not in {i.name for i in inputs(app, Language("pt").typeset)}
    (one,) = (e for e in entered(files.change(app, {spread: [370, 380]})) if e.at == spread)
    assert one.values == ((spread, "370 … 380"),)
