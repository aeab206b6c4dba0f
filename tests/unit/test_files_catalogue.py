"""Catalogues: parts by name, from rows that each have a source."""

import pytest

from cardan.base.errors import BadFile, DesignError
from cardan.base.units import MPa, inch, mm
from cardan.border.table import Reading
from cardan.files.catalogue import TABLES, Catalogue, Sheet, find, shipped
from cardan.model.material import STEEL

TUBES = "name,outer_mm,wall_mm,material,source\nours,90,3,steel,drawing\n"


def problems(text):
    sheet, reading = Sheet(text, "ours.csv"), Reading()
    reading.catalogue = Catalogue((sheet,))
    sheet.check(reading)
    return [p.located("ours.csv") for p in reading.problems]


@pytest.mark.parametrize("kind", list(TABLES))
def test_every_shipped_row_is_a_part_with_a_source(kind):
    sheet, reading = shipped(kind), Reading(Catalogue())
    sheet.check(reading)
    assert (reading.problems, reading.warnings) == ([], [])
    assert sheet.kind == kind
    assert len(sheet.rows) > {"ply": 5, "detail": 7}.get(kind, 10)
    for name in sheet.rows:
        part = find(name, kind)
        if kind != "tube":  # a tube is its section; its row holds the source
            assert part.name == name
            assert "not given" not in str(part.source)


@pytest.mark.parametrize(
    "name", ["3.500x0.120in", "3.5x0.12in", "3.5 X 0.12 IN", "tube 3.5x0.12in"]
)
def test_names_are_found_however_they_are_spelt(name):
    tube = find(name, "tube")
    assert (tube.outer, tube.wall) == pytest.approx((3.5 * inch, 0.12 * inch))


def test_the_shipped_steel_is_the_programs_own():
    """The default of a tube without a material and the catalogue's steel must agree."""
    steel = find("steel", "material")
    assert (steel.youngs_modulus, steel.density, steel.poisson) == (
        STEEL.youngs_modulus, STEEL.density, STEEL.poisson,
    )  # fmt: skip


@pytest.mark.parametrize(
    ("name", "kind", "message"),
    [
        ("3.5x0.12", "tube", "no catalogue has a tube 3.5x0.12; did you mean 3.500x0.120in or "
         "3.500x0.125in-al?"),
        ("E35S-N", "material", "no catalogue has a material E35S-N; did you mean E355-N?"),
        ("spicer 1810", "joint", "no catalogue has a joint spicer 1810; did you mean 1810?"),
    ],
)  # fmt: skip
def test_an_unknown_name_hears_of_the_nearest(name, kind, message):
    with pytest.raises(DesignError) as error:
        find(name, kind)
    assert str(error.value) == message


def test_the_users_own_parts_go_before_those_shipped():
    own = Sheet(TUBES.replace("ours", "120x4"), "ours.csv")
    assert Catalogue((own,)).find("120x4", "tube").outer == pytest.approx(90 * mm)
    assert Catalogue().find("120x4", "tube").outer == pytest.approx(120 * mm)


@pytest.mark.parametrize(
    "text",
    [TUBES, "\ufeff" + TUBES, TUBES.replace("\n", "\r\n"), TUBES.replace(",", ";"),
     TUBES.replace("90,3,", "3.5,0.12,").replace("mm", "in"), TUBES + "\n , ,\n\n",
     TUBES.replace("drawing", '"drawing 4, sheet 1"')],
)  # fmt: skip
def test_sheets_as_spreadsheets_write_them(text):
    assert problems(text) == []
    assert Catalogue((Sheet(text, "ours.csv"),)).find("ours", "tube").outer > 85 * mm


def test_an_empty_cell_is_not_known():
    text = "name,peak_Nm,speed_max_rpm,mass_kg,source\nours,5000,,,data sheet\n"
    joint = Catalogue((Sheet(text, "ours.csv"),)).find("ours", "joint")
    assert (joint.peak_torque, joint.speed_max, joint.mass) == (5000, None, None)


def test_materials_in_their_units():
    text = "name,youngs_modulus_GPa,density_kg_m3,yield_MPa\nours,205,7800,355\n"
    material = Catalogue((Sheet(text, "ours.csv"),)).find("ours", "material")
    assert (material.youngs_modulus, material.yield_strength) == (205e9, 355 * MPa)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (TUBES.replace("90,", '"90,5",'), "ours.csv:2:2: ours.outer_mm: must be a number above 0 "
         "(got 90,5); write a decimal point: 90.5"),
        (TUBES.replace("90,", "90,5,"), "ours.csv:2:1: this row has 6 cells, the header 5; write a "
         "decimal point, and put text with a comma in quotes"),
        (TUBES.replace("90,", "-90,"), "ours.csv:2:2: ours.outer_mm: must be a number "
         "of at least 1 and at most 3000 mm (got -90)"),
        (TUBES.replace("90,", ","), "ours.csv:2:1: ours: outer_mm, outer_m or outer_in is missing: "
         "outside diameter"),
        (TUBES.replace("wall_mm", "wal_mm"), "ours.csv:1:3: wal_mm: unknown column; did you mean "
         "wall_mm?"),
        (TUBES.replace("ours", ""), "ours.csv:2:1: this row has no name"),
        (TUBES + "ours,80,3,steel,drawing\n", "ours.csv:3:1: ours: this name is in line 2 already"),
        (TUBES.replace("steel", "stel"), "ours.csv:2:4: ours.material: no catalogue has a material "
         "stel; did you mean steel?"),
        (TUBES.replace("material", "wall_mm"), "ours.csv:1:4: wall_mm: this column stands here "
         "twice"),
        ("a,b\n1,2\n", "ours.csv:1:1: the first line must name the columns, and one of them is "
         "name"),
        ("", "ours.csv:1:1: the first line must name the columns, and one of them is name"),
    ],
)  # fmt: skip
def test_a_wrong_sheet_is_told_where(text, message):
    assert message in problems(text)


def test_what_is_no_csv_is_no_sheet():
    with pytest.raises(BadFile, match=r"ours.csv:2:1: this is no CSV: field larger than"):
        Sheet("name\n" + "x" * 200_000, "ours.csv")


@pytest.mark.parametrize("hidden", ["\x1b", "\u202e", "\ufffe"])
def test_a_catalogue_hides_nothing(hidden):
    with pytest.raises(BadFile, match=rf"ours.csv:2:2: .*U\+{ord(hidden):04X}\) stands here"):
        Sheet(TUBES.replace("ours,", f"o{hidden}urs,"), "ours.csv")
