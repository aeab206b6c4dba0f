"""STEP files as CAD writes them: names of products and placed parts, several roots, splines."""

import math
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from cardan.core.errors import DesignError
from cardan.core.units import mm
from cardan.model.bracket import FaceSelector, StepFileShape

pytest.importorskip("netgen.occ")

from cardan.physics.fem.geometry import build_solid
from cardan.physics.fem.ngsolve_import import import_ngsolve
from cardan.physics.fem.round_faces import cylinder_of_face
from cardan.physics.fem.step_file import solid_from_step
from cardan.physics.fem.step_structure import StepStructure, names_of_solids

pytestmark = pytest.mark.bracket

PLACEMENT = """
#9001 = APPLICATION_CONTEXT('x');
#9002 = PRODUCT_CONTEXT('',#9001,'mechanical');
#9003 = PRODUCT_DEFINITION_CONTEXT('part definition',#9001,'design');
#9004 = PRODUCT('whole','whole','',(#9002));
#9005 = PRODUCT_DEFINITION_FORMATION('','',#9004);
#9006 = PRODUCT_DEFINITION('design','',#9005,#9003);
#9007 = PRODUCT_DEFINITION_SHAPE('','',#9006);
#9008 = SHAPE_DEFINITION_REPRESENTATION(#9007,#9009);
#9009 = SHAPE_REPRESENTATION('',(#11,#9010),#{context});
#9010 = AXIS2_PLACEMENT_3D('',#9011,#9012,#9013);
#9011 = CARTESIAN_POINT('',(10.,20.,30.));
#9012 = DIRECTION('',(0.,0.6,0.8));
#9013 = DIRECTION('',(1.,0.,0.));
#9014 = CONTEXT_DEPENDENT_SHAPE_REPRESENTATION(#9015,#9017);
#9015 = ( REPRESENTATION_RELATIONSHIP('','',#10,#9009)
REPRESENTATION_RELATIONSHIP_WITH_TRANSFORMATION(#9016) SHAPE_REPRESENTATION_RELATIONSHIP() );
#9016 = ITEM_DEFINED_TRANSFORMATION('','',#11,#9010);
#9017 = PRODUCT_DEFINITION_SHAPE('','',#9018);
#9018 = NEXT_ASSEMBLY_USAGE_OCCURRENCE('1','1','',#9006,#5,$);
"""


def part_text(folder: Path, shape: object, product: str, *, shift: int = 0) -> str:
    """Return the STEP text of a shape whose product has this name; numbers begin above `shift`."""
    path = folder / "part.step"
    shape.WriteStep(str(path))
    text = path.read_text("utf-8")
    text = re.sub(r"PRODUCT\('[^']*',\s*'[^']*'", lambda _: f"PRODUCT('','{product}'", text)
    return re.sub(r"#(\d+)", lambda m: f"#{int(m[1]) + shift}", text)


def data_of(text: str) -> str:
    return text.partition("DATA;")[2].partition("ENDSEC;")[0]


def with_data(text: str, more: str) -> str:
    head, _, data = text.partition("DATA;")
    return head + "DATA;" + data.replace("ENDSEC;", more + "ENDSEC;", 1)


def plate():
    """Return a plate of 8 mm with two holes of 11 mm, of which one has a name, and the top."""
    occ = import_ngsolve().occ
    body = occ.Box((0, 0, 0), (100, 60, 8))
    for x, y in ((20, 15), (70, 40)):
        hole = occ.Cylinder(occ.Pnt(x, y, -1), occ.Z, r=5.5, h=10)
        hole.faces.name = "bolt 1" if x == 20 else "bolt 2"
        body = body - hole
    body.faces.Max(occ.Z).name = "top"
    body.faces.Min(occ.X).name = "seat"
    return body


def read(path: Path, text: str):
    """Return solids as the kernel reads them, and their names."""
    path.write_text(text, "utf-8")
    solids = list(import_ngsolve().occ.OCCGeometry(str(path)).shape.solids)
    return solids, names_of_solids(StepStructure(text), solids)


@pytest.mark.parametrize("unit", [".MILLI.", ".CENTI.", "$"])
def test_names_of_part_placed_by_assembly_are_found_in_every_unit(tmp_path, unit):
    text = part_text(tmp_path, plate(), "bracket arm")
    context = re.search(r"ADVANCED_BREP_SHAPE_REPRESENTATION\('',\(#11,#15\),#(\d+)\)", text)[1]
    text = with_data(text, PLACEMENT.format(context=context)).replace(".MILLI.", unit)
    (solid,), ((_, product, faces),) = read(tmp_path / "whole.step", text)
    assert product == "bracket arm"
    assert not any(face.name for face in solid.faces)  # what the kernel says
    named = dict(zip(faces, solid.faces, strict=True))
    scale = {".MILLI.": 1, ".CENTI.": 10, "$": 1000}[unit]
    for name, (x, y) in (("bolt 1", (20, 15)), ("bolt 2", (70, 40))):
        at = np.array([10, 20, 30]) + x * np.array([1, 0, 0]) + y * np.array([0, 0.8, -0.6])
        off = cylinder_of_face(named[name]).point - scale * at
        assert np.linalg.norm(np.cross(off, [0, 0.6, 0.8])) < 1e-6 * scale
    assert named["top"].mass == pytest.approx((6000 - 2 * math.pi * 5.5**2) * scale**2)


def test_two_roots_are_both_read_and_told_apart_by_product(tmp_path):
    occ = import_ngsolve().occ
    first = part_text(tmp_path, occ.Box((0, 0, 0), (10, 10, 10)), "spacer")
    second = part_text(tmp_path, plate(), "bracket", shift=5000)
    path = tmp_path / "two.step"
    path.write_text(with_data(first, data_of(second)), "utf-8")
    assert len(list(occ.OCCGeometry(str(path)).shape.solids)) == 1  # the kernel reads one
    assert len(StepStructure(path.read_text("utf-8")).root_texts()) == 2
    part = StepFileShape(
        path=str(path), centre=(0, 0.03, 0), thickness=8 * mm, solid="bracket",
        seat=(FaceSelector(name="seat"),), bolts=(FaceSelector(name="bolt 1"),),
    )  # fmt: skip
    made = build_solid(part)
    assert made.volume == pytest.approx((6000 - 2 * math.pi * 5.5**2) * 8 * mm**3)
    with pytest.raises(DesignError, match=r"called 'arm': it has spacer of 1 cm3, bracket of "):
        build_solid(replace(part, solid="arm"))
    lost = replace(part, seat=(FaceSelector(name="saet"),))
    with pytest.raises(DesignError, match="its faces are called bolt 1, bolt 2, seat, top"):
        build_solid(lost)


def test_file_of_one_root_is_left_as_it_is(tmp_path):
    assert StepStructure(part_text(tmp_path, plate(), "bracket")).root_texts() == ()


def test_text_that_is_no_step_has_neither_roots_nor_solids():
    structure = StepStructure("no STEP 'at all; #1 = X(#1")
    assert (structure.root_texts(), structure.solids) == ((), ())


def test_letters_beyond_ascii_in_names_are_decoded(tmp_path):
    text = part_text(tmp_path, plate(), r"tr\X2\00E4\X0\ger ''x''")
    (solid,) = StepStructure(text).solids
    assert solid.product == "träger 'x'"


@pytest.mark.parametrize("end", [1.0, 2 * math.pi])
@pytest.mark.parametrize("swapped", [False, True])
def test_bore_written_as_rational_spline_is_a_bore(tmp_path, end, swapped):
    """A turn by four quarters of second degree; the edges stay circles."""
    text = part_text(tmp_path, plate(), "bracket")
    surface, axes, radius = re.search(
        r"#(\d+) = CYLINDRICAL_SURFACE\('',#(\d+),([\d.]+)\);", text
    ).groups()
    point = re.search(rf"#{axes} = AXIS2_PLACEMENT_3D\('',#(\d+)", text)[1]
    x, y, _ = map(
        float, re.search(rf"#{point} = CARTESIAN_POINT\('',\(([^)]*)\)", text)[1].split(",")
    )
    r, half = float(radius), math.sqrt(0.5)
    around = [(1, 0), (1, 1), (0, 1), (-1, 1), (-1, 0), (-1, -1), (0, -1), (1, -1), (1, 0)]
    points = [
        f"#{9100 + 2 * k + j} = CARTESIAN_POINT('',({x + r * a},{y + r * b},{z}));"
        for k, (a, b) in enumerate(around)
        for j, z in enumerate((-1.0, 9.0))
    ]
    net = [[(f"#{9100 + 2 * k + j}", half if k % 2 else 1.0) for j in (0, 1)] for k in range(9)]
    turn = "2", "(3,2,2,2,3)", "(" + ",".join(f"{end * q / 4}" for q in range(5)) + ")"
    axis = "1", "(2,2)", "(0.,10.)"
    if swapped:
        net, (turn, axis) = list(zip(*net, strict=True)), (axis, turn)
    poles, weights = (
        ",".join("(" + ",".join(str(one[k]) for one in row) + ")" for row in net) for k in (0, 1)
    )
    degrees, counts, knots = (",".join(pair) for pair in zip(turn, axis, strict=True))
    spline = (
        f"#{surface} = ( BOUNDED_SURFACE() B_SPLINE_SURFACE({degrees},({poles}),"
        f".UNSPECIFIED.,.F.,.F.,.F.) B_SPLINE_SURFACE_WITH_KNOTS({counts},{knots},.UNSPECIFIED.) "
        f"GEOMETRIC_REPRESENTATION_ITEM() RATIONAL_B_SPLINE_SURFACE(({weights})) "
        "REPRESENTATION_ITEM('') SURFACE() );"
    )
    text = re.sub(rf"#{surface} = CYLINDRICAL_SURFACE[^;]*;", spline, text)
    curves = dict(re.findall(r"#(\d+) = (?:SURFACE|SEAM)_CURVE\('',#(\d+)", text))
    text = re.sub(  # edges without a curve in the parameters of a surface that is replaced
        r"(EDGE_CURVE\('',#\d+,#\d+,)#(\d+)",
        lambda m: f"{m[1]}#{curves.get(m[2], m[2])}",
        text,
    )
    (solid,), _ = read(tmp_path / "spline.step", with_data(text, "\n".join(points) + "\n"))
    found = [c for c in map(cylinder_of_face, solid.faces) if c]
    assert [c.radius for c in found] == pytest.approx([5.5, 5.5])


# --------------------------------------------------------------------------- files of CAD programs

FILES = Path(__file__).with_name("step_files")


def shape(file: str, solid: str, *, at=(0.0, 0.0, 0.0), **picks) -> StepFileShape:
    """Return a plate 100 x 60 x 8 mm with a hole of 11 mm, its lower side in the middle at `at`."""
    x, y, z = at
    centre = ((x - 50) * mm, y * mm, (z + 4) * mm)
    return StepFileShape(
        path=str(FILES / file), solid=solid, centre=centre, thickness=8 * mm,
        **({"welded": ()} | picks),
    )  # fmt: skip


@pytest.mark.parametrize(
    "written",
    ["tr\u00e4ger".encode().decode("latin-1"), r"tr\X2\00E4\X0\ger", r"tr\X\E4ger", r"tr\S\dger",
     r"tr\X4\000000E4\X0\ger", "tr\u00e4ger", "tr\u00e4ger".encode().decode("latin-1").encode()
     .decode("latin-1")],
)  # fmt: skip
def test_letters_of_every_encoding_in_names_are_decoded(tmp_path, written):
    text = part_text(tmp_path, plate(), "NAME").replace("NAME", written)
    (solid,) = StepStructure(text).solids
    assert solid.product == "träger"


def test_cadquery_assembly_in_inch_has_its_names_and_millimetres():
    """CadQuery 2.8 writes the letter twice encoded; names of faces stand in a placed part."""
    names = {"seat": (FaceSelector(name="seat"),), "bolts": (FaceSelector(name="bolt 1"),)}
    made = solid_from_step(shape("cadquery-2.8-inch.step", "Träger", at=(10, 20, 26), **names))
    found = {f.name: f for f in made.face_selections}
    assert found["seat"].area == pytest.approx(60 * 8 * mm**2)
    assert found["bolt 1"].radius == pytest.approx(5.5 * mm)


@pytest.mark.parametrize(("number", "across"), [("1", 0), ("2", 400)])
def test_part_that_freecad_places_twice_is_chosen_by_number(number, across):
    picks = {
        "seat": (FaceSelector(near=(-50 * mm, across * mm, 4 * mm)),),
        "bolts": (FaceSelector(near=(5.5 * mm, across * mm, 4 * mm)),),
    }
    file = "freecad-0.20-twice.step"
    made = solid_from_step(shape(file, number, at=(0, across, 0), **picks))
    assert len(made.face_selections) == 2
    for solid in ("", "Träger", "none"):
        with pytest.raises(DesignError, match=r"1 \(one of Träger\) of 47\.24 cm3, 2 \(one of"):
            solid_from_step(shape(file, solid, **picks))


def test_point_beside_every_face_names_size_of_solid():
    """A file of another unit shows by its size."""
    near = (FaceSelector(near=(-1.27, 0, 0.1)),)
    picks = {"seat": near, "bolts": near}
    with pytest.raises(DesignError, match=r"and all of them measure 100 x 60 x 8 mm"):
        solid_from_step(shape("freecad-0.20-twice.step", "1", **picks))
