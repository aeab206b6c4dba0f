"""Catalogues: parts by name, from rows that each have a source."""

import pytest

from cardan.application.catalogue import (
    TABLE_CLASS_BY_PART_KIND,
    Catalogue,
    CatalogueCsvFile,
    find_shipped_part,
    read_shipped_catalogue,
)
from cardan.core.errors import DesignError, InvalidFileError
from cardan.core.units import MPa, inch, mm
from cardan.model.material import STEEL
from cardan.schema.node_reader import TableReadContext

TUBES = "name,outer_mm,wall_mm,material,source\nours,90,3,steel,drawing\n"


def problems(text):
    sheet, reading = CatalogueCsvFile(text, "ours.csv"), TableReadContext()
    reading.catalogue = Catalogue((sheet,))
    sheet.check(reading)
    return [p.format_with_location("ours.csv") for p in reading.problems]


@pytest.mark.parametrize("kind", list(TABLE_CLASS_BY_PART_KIND))
def test_every_shipped_catalogue_row_is_a_part_with_source(kind):
    sheet, reading = read_shipped_catalogue(kind), TableReadContext(Catalogue())
    sheet.check(reading)
    assert (reading.problems, reading.warnings) == ([], [])
    assert sheet.kind == kind
    assert len(sheet.rows) > {"ply": 5, "detail": 7}.get(kind, 10)
    for name in sheet.rows:
        part = find_shipped_part(name, kind)
        if kind != "tube":  # a tube is its section; its row holds the source
            assert part.name == name
            assert "not given" not in str(part.source)


@pytest.mark.parametrize(
    "name", ["3.500x0.120in", "3.5x0.12in", "3.5 X 0.12 IN", "tube 3.5x0.12in"]
)
def test_part_is_found_by_any_spelling_of_its_name(name):
    tube = find_shipped_part(name, "tube")
    assert (tube.outer, tube.wall) == pytest.approx((3.5 * inch, 0.12 * inch))


def test_catalogue_steel_equals_default_tube_material():
    """The default of a tube without a material and the catalogue's steel must agree."""
    steel = find_shipped_part("steel", "material")
    assert (steel.youngs_modulus, steel.density, steel.poisson) == (
        STEEL.youngs_modulus, STEEL.density, STEEL.poisson,
    )  # fmt: skip


@pytest.mark.parametrize(
    ("name", "kind", "message"),
    [
        ("3.5x0.12", "tube", "the outside diameter of a tube must be within 15 to 400 mm, got 3.5 "
         "mm; write the unit behind the sizes, mm or in"),
        ("98-4", "tube", "no catalogue has a tube 98-4; write outside diameter x wall: 100x4 in mm,"
         " 4.000x0.134in in inches; nearest in size: 110x4, 4.000x0.134in, 120x4"),
        ("1715", "joint", "no catalogue has a joint 1715; neighbours in size: 1710 (peak 10847 "
         "N·m), 1760 (peak 13829 N·m)"),
        ("710", "joint", "no catalogue has a joint 710; there are: 1310, 1330, 1350, 1410, 1480, "
         "1550, 1610, 1710, 1760, 1810, 1880, SPL55, SPL70, SPL90, SPL100, SPL140, SPL170, SPL250, "
         "2015, 2020 and 111 more"),
        ("E35S-N", "material", "no catalogue has a material E35S-N; did you mean E355-N?"),
        ("spicer 1810", "joint", "no catalogue has a joint spicer 1810; did you mean 1810?"),
    ],
)  # fmt: skip
def test_unknown_part_name_is_rejected_with_nearest_name(name, kind, message):
    with pytest.raises(DesignError) as error:
        find_shipped_part(name, kind)
    assert str(error.value) == message


@pytest.mark.parametrize(
    ("text", "outer", "wall", "material"),
    [
        ("100x4", 100, 4, "E355-N"),
        ("100 x 4", 100, 4, "E355-N"),
        ("100X4", 100, 4, "E355-N"),
        ("100×4 mm", 100, 4, "E355-N"),
        ("Ø 88,9x2,4", 88.9, 2.4, "E355-N"),
        ("4.000x0.134in", 101.6, 3.4036, "DOM-1020"),
        ('4" x .134"', 101.6, 3.4036, "DOM-1020"),  # the catalogue's tube of these sizes
        ("4.25 in x 0.134 in", 107.95, 3.4036, "E355-N"),
        ("120 x 6", 120, 6, "E355-SR"),
    ],
)
def test_tube_is_read_as_people_write_it(text, outer, wall, material):
    tube = find_shipped_part(text, "tube")
    assert (tube.outer, tube.wall) == pytest.approx((outer * mm, wall * mm), rel=1e-12)
    assert tube.material.name == material
    assert tube.material.yield_strength is not None


@pytest.mark.parametrize("text", ["100x60", "100x0", "4x0.134", "4x100", "900x10"])
def test_tube_that_cannot_be_is_rejected(text):
    with pytest.raises(DesignError, match="must be"):
        find_shipped_part(text, "tube")


def test_user_catalogue_takes_precedence_over_shipped_catalogue():
    own = CatalogueCsvFile(TUBES.replace("ours", "120x4"), "ours.csv")
    assert Catalogue((own,)).find("120x4", "tube").outer == pytest.approx(90 * mm)
    assert Catalogue().find("120x4", "tube").outer == pytest.approx(120 * mm)


@pytest.mark.parametrize(
    "text",
    [TUBES, "\ufeff" + TUBES, TUBES.replace("\n", "\r\n"), TUBES.replace(",", ";"),
     TUBES.replace("90,3,", "3.5,0.12,").replace("mm", "in"), TUBES + "\n , ,\n\n",
     TUBES.replace("drawing", '"drawing 4, sheet 1"')],
)  # fmt: skip
def test_csv_dialects_of_spreadsheets_are_read(text):
    assert problems(text) == []
    assert Catalogue((CatalogueCsvFile(text, "ours.csv"),)).find("ours", "tube").outer > 85 * mm


def test_empty_catalogue_cell_is_unknown():
    text = "name,peak_Nm,speed_max_rpm,mass_kg,source\nours,5000,,,data sheet\n"
    joint = Catalogue((CatalogueCsvFile(text, "ours.csv"),)).find("ours", "joint")
    assert (joint.peak_torque, joint.speed_max, joint.mass) == (5000, None, None)


def test_material_row_is_converted_from_its_units():
    text = "name,youngs_modulus_GPa,density_kg_m3,yield_MPa\nours,205,7800,355\n"
    material = Catalogue((CatalogueCsvFile(text, "ours.csv"),)).find("ours", "material")
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
def test_invalid_catalogue_is_rejected_with_row_and_column(text, message):
    assert message in problems(text)


def test_oversized_csv_field_is_rejected():
    with pytest.raises(InvalidFileError, match=r"ours.csv:2:1: this is no CSV: field larger than"):
        CatalogueCsvFile("name\n" + "x" * 200_000, "ours.csv")


@pytest.mark.parametrize("hidden", ["\x1b", "\u202e", "\ufffe"])
def test_invisible_character_in_catalogue_is_rejected(hidden):
    with pytest.raises(
        InvalidFileError, match=rf"ours.csv:2:2: .*U\+{ord(hidden):04X}\) stands here"
    ):
        CatalogueCsvFile(TUBES.replace("ours,", f"o{hidden}urs,"), "ours.csv")
