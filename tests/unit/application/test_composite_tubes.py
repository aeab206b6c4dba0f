"""A tube of plies in the application file: its layup, and what a check makes of it."""

from dataclasses import replace

import numpy as np
import pytest
from repository import EXAMPLES

import cardan
from cardan.core.errors import InvalidFileError
from cardan.core.units import MPa, deg, mm, rpm
from cardan.documents.workbook import workbook_bytes
from cardan.model.laminate import CARBON_EPOXY, CompositeTube
from cardan.model.material import STEEL
from cardan.model.parts import Tube
from cardan.physics.strength.composite_tube import buckling_torques, timoshenko_critical_speed
from cardan.render.i18n import Translator

EXAMPLE = EXAMPLES / "composite-van.yaml"

TEXT = """\
title: Carbon shaft
speed_rpm: 4000
torque_Nm: 2500
limits: van
driveline:
  slopes: {side_deg: [0.0, 3.0, 0.2]}
  joints: 1350
  shafts:
    - length_mm: 1200
      tube:
        outer_mm: 90
        layup:
          - {ply: T300/5208, angle_deg: [15, -15]}
          - {ply: T300/5208, angle_deg: [45, -45], times: 5}
          - {ply: T300/5208, angle_deg: [90, -90], times: 3}
"""


@pytest.fixture
def read(tmp_path):
    def of(text):
        file = tmp_path / "shaft.yaml"
        file.write_text(text, encoding="utf-8")
        return cardan.read(file)

    return of


def tube(application):
    return application.lines[0].line.shafts[0].tube


def test_layup_in_file_lists_plies_from_inside_out(read):
    found = tube(read(TEXT))
    assert isinstance(found, CompositeTube)
    wanted = np.array([15, -15, *[45, -45] * 5, *[90, -90] * 3]) * deg
    np.testing.assert_allclose(found.angles, wanted, rtol=1e-15)
    assert found.layup == "15/-15/(45/-45)5/(90/-90)3"
    for name in ("along", "across", "shear", "poisson", "tension_across", "shear_strength"):
        assert getattr(found.plies[0], name) == pytest.approx(getattr(CARBON_EPOXY, name))
    assert found.wall == pytest.approx(2.25 * mm)


def test_check_computes_buckling_utilisation_of_composite_tube(read):
    """5 kN m would be 1.5 times what the wall holds; half of it 0.758, above NASA's 0.67."""
    application = read(TEXT)
    found = cardan.check(application)
    checks = {(c.quantity, c.limit.maximum): c for c in found.checks}
    buckling = checks["tube_buckling_utilisation", 0.67]
    least = min(buckling_torques(tube(application), 1.2))
    assert (
        buckling.value == pytest.approx(2500 / least, rel=1e-12) == pytest.approx(0.758, abs=1e-3)
    )
    assert buckling.grade == "fail"
    of = {c.quantity: c.value for c in found.checks}
    speed = timoshenko_critical_speed(tube(application), 1.2)
    assert of["critical_speed_ratio"] == pytest.approx(4000 * rpm / speed, rel=1e-3)
    assert found.verdict == "fail"
    # The plies carry it: ±45 with a fifth of 90 and a ninth of 15, at two fifths of failure.
    assert of["tube_shear_utilisation"] == pytest.approx(0.41, abs=0.01)


THIN = """\
title: A tube of thin aluminium
torque_Nm: 5000
speed_rpm: 1000
driveline:
  slopes: {{side_deg: [2, 0, 2]}}
  shafts: [{{length_mm: {length}, tube: {tube}}}]
limits: van
"""


@pytest.mark.parametrize("length", [1500, 8000])
def test_thin_metal_wall_and_metal_layup_have_equal_buckling(read, length):
    """A wall of 2 mm on 127 passed its shear, at 0.65 of yield, and buckles at 0.77 of this."""
    asked = []
    for wall in ("wall_mm: 2, material: 6061-T6", "layup: [{material: 6061-T6, thickness_mm: 2}]"):
        text = THIN.format(length=length, tube=f"{{outer_mm: 127, {wall}}}")
        found = cardan.check(read(text)).checks
        asked += [c for c in found if c.quantity == "tube_buckling_utilisation"]
    assert 0.997 < asked[0].value / asked[1].value < 1.06
    assert [c.grade for c in asked] == ["fail", "fail"]
    # Flügge's long tube, which ends stiffen: by 3 % at 8 m, by 31 % at 1.5 m.
    r, t = 62.5 * mm, 2 * mm
    stress = 68.9e9 * (t / r) ** 1.5 / (3 * np.sqrt(2) * (1 - 0.33**2) ** 0.75)
    held = 5000 / asked[0].value / (2 * np.pi * r**2 * t * stress)
    assert held == pytest.approx({1500: 1.31, 8000: 1.03}[length], abs=0.02)


def test_study_varies_wall_thickness_as_single_checks_do(read):
    at = "driveline.shafts[1].tube.wall_mm"
    text = THIN.format(length=1500, tube="{outer_mm: 127, wall_mm: 3, material: 6061-T6}")
    application = read(text)
    many = cardan.study(application, vary={at: [2, 4]}, n=4, seed=1).to_frame()
    for wall, value in zip(many[at], many["tube_buckling_utilisation"], strict=True):
        found = cardan.check(cardan.change(application, {at: wall})).checks
        (one,) = (c for c in found if c.quantity == "tube_buckling_utilisation")
        assert value == pytest.approx(one.value, rel=1e-9)


def test_reversed_layup_passes_buckling_limit(read):
    lines = TEXT.splitlines()
    turned = "\n".join(lines[:-3] + lines[:-4:-1]) + "\n"
    buckling = [c for c in cardan.check(read(turned)).checks
                if c.quantity == "tube_buckling_utilisation"]  # fmt: skip
    assert [c.grade for c in buckling] == ["pass"]
    assert buckling[0].value == pytest.approx(2500 / 7154, rel=0.02)


def test_shock_factor_multiplies_composite_tube_utilisation(read):
    """A shock factor of 2 is twice the torque, for the plies and for the wall."""
    plain, shaken = (
        {c.quantity: c.value for c in cardan.check(read(text)).checks}
        for text in (TEXT, TEXT.replace("limits: van", "limits: van\nshock_factor: 2"))
    )
    for quantity in ("tube_shear_utilisation", "tube_buckling_utilisation"):
        assert shaken[quantity] == pytest.approx(2 * plain[quantity], rel=1e-9)


def test_hybrid_layup_combines_metal_and_plies(read):
    """Aluminium inside carries with its shear modulus, carbon along it stiffens the bending."""
    layup = """\
          - {material: 6061-T6, thickness_mm: 3}
          - {ply: AS4/3501-6, angle_deg: 0, times: 4, thickness_mm: 0.2}
"""
    hybrid = tube(read(TEXT[: TEXT.index("          - {ply")] + layup))
    assert hybrid.layup == "6061-T6 3 mm/(0)4"
    assert hybrid.wall == pytest.approx(3.8 * mm)
    metal = hybrid.plies[0]
    assert metal.shear_strength == pytest.approx(276 * MPa / np.sqrt(3))
    inside = np.pi / 2 * (44.2**4 - 41.2**4) * mm**4
    outside = np.pi / 2 * (45**4 - 44.2**4) * mm**4
    assert hybrid.torsional_stiffness == pytest.approx(
        68.9e9 / 2.66 * inside + 6.6e9 * outside, rel=1e-9
    )
    # Poisson's ratios differ, 0.33 and 0.28: bending a little above the sum of both.
    both = (68.9e9 * inside + 126e9 * outside) / 2
    assert 1 <= hybrid.bending_stiffness / both < 1.001


@pytest.mark.slow
def test_study_varies_ply_angle_as_single_checks_do(read):
    at = "driveline.shafts[1].tube.layup[2].angle_deg[1]"
    application = read(TEXT)
    assert cardan.addresses(application)[at] == 45
    angles = np.array([30.0, 45.0, 60.0])
    many = cardan.study(application, vary={at: [30, 60]}, n=3, seed=1)
    values = many.to_frame()
    for angle, value in zip(values[at], values["tube_buckling_utilisation"], strict=True):
        one = cardan.check(cardan.change(application, {at: angle}))
        alone = [c.value for c in one.checks if c.quantity == "tube_buckling_utilisation"]
        assert value == pytest.approx(alone[0], rel=1e-9)
    changed = cardan.change(application, {at: angles})
    assert tube(changed).bending_stiffness.shape == (3, 1)


@pytest.mark.parametrize(
    ("old", "new", "says"),
    [
        ("T300/5208, angle_deg: [15", "T300-5208, angle_deg: [15",
         "13:19: driveline.shafts[1].tube.layup[1].ply: no catalogue has a ply T300-5208; "
         "did you mean T300/5208?"),
        ("angle_deg: [15, -15]", "angle_deg: [15, -115]",
         "layup[1].angle_deg[2]: must be a number of at least -90"),
        ("times: 5", "times: 0", "layup[2].times: must be a whole number from 1 to 400"),
        ("outer_mm: 90\n", "outer_mm: 90\n        wall_mm: 3\n",
         "wall_mm and layup exclude each other"),
        ("times: 3", "times: 40", "must be at most an eighth of that"),
        ("{ply: T300/5208, angle_deg: [15, -15]}", "{material: 6061-T6}",
         "thickness_mm of a layer of metal is missing"),
        ("{ply: T300/5208, angle_deg: [15, -15]}", "{material: steel, thickness_mm: 1}",
         "a layer of steel needs a material with its yield strength"),
    ],
)  # fmt: skip
def test_invalid_layup_is_rejected(read, old, new, says):
    assert old in TEXT
    with pytest.raises(InvalidFileError) as found:
        read(TEXT.replace(old, new))
    assert says in str(found.value)


@pytest.mark.slow
def test_workbook_contains_buckling_check_as_value(read, tmp_path):
    """The buckling check stands in it as computed; nothing pretends to be live."""
    import openpyxl

    found = cardan.check(read(TEXT))
    file = tmp_path / "shaft.xlsx"
    file.write_bytes(workbook_bytes(found, say=Translator("en")))
    cells = [
        cell
        for sheet in openpyxl.load_workbook(file)
        for row in sheet.iter_rows(values_only=True)
        for cell in row
    ]
    assert "Torque / buckling torque, shaft 1" in cells
    assert any(isinstance(c, float) and abs(c - 0.7578) < 1e-4 for c in cells)


def test_ply_material_is_listed_once_per_tube():
    found = cardan.check(cardan.read(EXAMPLE))
    (plies,) = (d for d in found.catalogue_data if d.kind == "material")
    assert (plies.name, plies.part_numbers) == ("T300/5208", (1,))


def test_composite_propshaft_has_higher_critical_speed_than_steel():
    """Below 0.7 of its critical speed, where one of steel of its size turns above it."""
    app = cardan.read(EXAMPLE)
    (plies,) = cardan.check(app).line_responses
    shaft = app.lines[0].line.shafts[0]
    steel = Tube(outer=0.127, wall=3.4e-3, material=STEEL)
    line = replace(app.lines[0].line, shafts=(replace(shaft, tube=steel),))
    (other,) = cardan.check(replace(app, lines=(replace(app.lines[0], line=line),))).line_responses
    top = app.speed
    assert (top / plies.strength.critical_speeds).max() < 0.70
    assert (top / other.strength.critical_speeds).min() > 0.95
    assert shaft.tube.mass_per_length < 0.25 * steel.mass_per_length
    assert 6 < 1 / plies.strength.tube_buckling_utilisation.max() < 10
