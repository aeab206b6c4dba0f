"""What an application says is all in its inputs: each entry changed alone changes a row."""

import re
from pathlib import Path

import pytest
from repository import ROOT

from cardan.application import overrides, reader
from cardan.application.entries import entered_values
from cardan.core.errors import CardanError
from cardan.documents.inputs_table import ENTRIES_WITH_OWN_ROW, input_rows
from cardan.render.i18n import Translator

EXAMPLES = sorted((ROOT / "examples").glob("*.yaml"))
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
            return overrides.change(app, {at: to}, warn=False)
        except CardanError:
            continue
    return None


def said(app, say):
    return [(i.group, i.name, i.value) for i in input_rows(app, say)]


@pytest.mark.slow
@pytest.mark.parametrize(
    "of", [*EXAMPLES, RARE, ODD], ids=[*(p.stem for p in EXAMPLES), "rare", "odd"]
)
def test_every_input_number_changes_inputs_table(of):
    """Of 223 kinds of numbers 121 were not: where a pinion sits, a joint's peak torque."""
    say = Translator("en").with_minus_sign
    app = reader.read(of) if isinstance(of, Path) else reader.loads(of)
    was, seen = said(app, say), set()
    for at in overrides.addresses(app):
        if (kind := paths(at)) in seen:
            continue
        changed = other(app, at)
        if changed is not None:
            seen.add(kind)
            assert said(changed, say) != was, at
    assert len(seen) > 12


def test_inputs_table_lists_named_rows_then_other_inputs_by_key():
    """A path that is no entry's would hide nothing, and so would one that nobody tries."""
    say, tried = Translator("it").with_minus_sign, set()
    for app in (*map(reader.loads, (RARE, ODD)), *map(reader.read, EXAMPLES)):
        rows = {i.name: i.value for i in input_rows(app, say)}
        groups = {i.name: i.group for i in input_rows(app, say)}
        for one in entered_values(app):
            tried.add(one.path)
            if one.path not in ENTRIES_WITH_OWN_ROW:
                assert rows[one.address].count(";") >= len(one.values) - 1
                if one.address.startswith("drivelines."):
                    assert groups[one.address] == f"Linea {one.address.split('.')[1]}"
            else:
                assert one.address not in rows
    assert ENTRIES_WITH_OWN_ROW - tried == set()


@pytest.mark.parametrize(
    ("was", "now"),
    [("[gravity, unbalance]", "[gravity]"), ("name: double 1310", "name: double 7"),
     ("prime_mover: diesel", "prime_mover: petrol"), ("limits: van", "limits: heavy-truck"),
     ("tube: 3.000x0.083in", "tube: 100x3")],
)  # fmt: skip
def test_text_inputs_change_inputs_table(was, now):
    text, say = PICK_UP.read_text("utf-8"), Translator("en").with_minus_sign
    assert was in text
    one, two = (reader.loads(t, folder=PICK_UP.parent) for t in (text, text.replace(was, now)))
    assert said(one, say) != said(two, say)


def test_inputs_table_lists_overrides_of_variants_and_catalogue_parts():
    app = reader.read(PICK_UP)
    at, spread = "drivelines.main.shafts[1].tube.material.yield_MPa", "tyre.dynamic_radius_mm"
    rows = {
        i.name: i.value
        for i in input_rows(overrides.change(app, {at: 310.5}), Translator("pt").with_minus_sign)
    }
    assert rows[at] == "310,5"
    assert at not in {i.name for i in input_rows(app, Translator("pt").with_minus_sign)}
    (one,) = (
        e
        for e in entered_values(overrides.change(app, {spread: [370, 380]}))
        if e.address == spread
    )
    assert one.values == ((spread, "370 … 380"),)
