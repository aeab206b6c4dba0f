"""Sheet as shells against sheet as solids: CalculiX's S8 on the middle surface of a U.

What a shell says of a bend is told in the documentation as the reason for solids: the bends of
a bracket are about as sharp as its sheet is thick, and a shell knows nothing of that
(Winkler's curved beam). CalculiX: Dhondt, calculix.de.
"""

import subprocess

import numpy as np
import pytest
from calculix import _blocks
from scipy.spatial import cKDTree

from cardan.core.units import MPa, mm
from cardan.model.bracket import UShape
from cardan.model.material import STEEL
from cardan.physics.fem.elasticity import assemble_elastic_solid
from cardan.physics.fem.geometry import build_solid
from cardan.physics.fem.meshing import mesh
from cardan.physics.fem.stress import von_mises
from cardan.physics.fem.surface import project_to_surface

pytestmark = [pytest.mark.oracle, pytest.mark.bracket]

U = UShape(
    seat_diameter=120 * mm, width=64 * mm, thickness=5 * mm, height=120 * mm, flange=50 * mm,
    bend_radius=8 * mm, bolt_diameter=11 * mm, bolt_pitch=36 * mm,
)  # fmt: skip
T, RADIUS, BEND = U.thickness, U.seat_diameter / 2, U.bend_radius
LEG, TOP = RADIUS + T + BEND, U.height - T - BEND  # where a bend's centre lies
SLANT = np.sqrt(0.5)
PLACES = {
    "leg": (0, RADIUS + T, 50 * mm),
    "inside": (0, LEG - BEND * SLANT, TOP + BEND * SLANT),
    "outside": (0, LEG - (BEND + T) * SLANT, TOP + (BEND + T) * SLANT),
    "below": (0, 0, -RADIUS - T),
}


def solids():
    """Motion (places, 3) m and stress (places,) Pa under 1 kN across, spread over the seat."""
    body = build_solid(U)
    held = assemble_elastic_solid(
        mesh(body.shape, size=4 * mm), STEEL, held=body.fixed_faces("clamped")
    )
    area = float(sum(face.mass for face in body.shape.faces if face.name == "seat"))
    u = held.solve(held.traction("seat", (0, 1e3 / area, 0))[None])
    at = project_to_surface(held.nodes, list(PLACES.values()))
    moved, stress = (at.interpolate(held.nodes, field)[:, 0] for field in held.at_nodes(u))
    return moved, von_mises(stress)


def middle():
    """The sheet's middle line from flange to flange (n, 2), and between which elements it is seat.

    Round, legs and bends; every second point is the middle of an element.
    """
    r, R = BEND + T / 2, RADIUS + T / 2
    turn, along, round_ = np.arange(20) / 20, np.arange(48) / 48, np.arange(120) / 120
    right = LEG - r * np.sin(np.pi / 2 * turn), TOP + r * np.cos(np.pi / 2 * turn)
    leg = np.full(48, R), TOP * (1 - along)
    below = R * np.cos(np.pi * round_), -R * np.sin(np.pi * round_)
    half = np.concatenate([np.stack(part, axis=1) for part in (right, leg)])
    end = half[::-1] * [-1, 1]
    return np.concatenate([half, np.stack(below, axis=1), [[-R, 0.0]], end]), (34, 94)


def shells(folder, kind):
    """The same by shells of eight nodes, S8 or S8R, held where the flange begins."""
    line, seat = middle()
    across = np.linspace(-U.width / 2, U.width / 2, 33)
    number, lines, k = {}, ["*NODE"], 0
    for i, (y, z) in enumerate(line):
        for j, x in enumerate(across):
            if i % 2 and j % 2:
                continue
            k += 1
            number[i, j] = k
            lines.append(f"{k},{x:.9e},{y:.9e},{z:.9e}")
    ring = [(0, 0), (2, 0), (2, 2), (0, 2), (1, 0), (2, 1), (1, 2), (0, 1)]
    lines.append(f"*ELEMENT,TYPE={kind},ELSET=EALL")
    loaded, k = [], 0
    for i in range(0, len(line) - 1, 2):
        for j in range(0, 32, 2):
            k += 1
            lines.append(f"{k}," + ",".join(str(number[i + a, j + b]) for a, b in ring))
            if seat[0] <= i // 2 < seat[1]:
                loaded.append(f"{k},")
    fixed = [f"{n}," for (i, _), n in number.items() if i in (0, len(line) - 1)]
    area = np.pi * (RADIUS + T / 2) * U.width
    lines += [
        "*ELSET,ELSET=SEAT", *loaded, "*NSET,NSET=FIX", *fixed,
        "*MATERIAL,NAME=S", "*ELASTIC", f"{STEEL.youngs_modulus},{STEEL.poisson}",
        "*DENSITY", "1.", "*SHELL SECTION,ELSET=EALL,MATERIAL=S", f"{T}",
        "*BOUNDARY", "FIX,1,6", "*STEP", "*STATIC", "*DLOAD",
        f"SEAT,GRAV,{1e3 / (T * area)},0.,1.,0.",  # a load on the seat's area, by its weight
        "*NODE FILE,OUTPUT=3D", "U", "*EL FILE,OUTPUT=3D", "S", "*END STEP",
    ]  # fmt: skip
    (folder / "job.inp").write_text("\n".join(lines) + "\n")
    subprocess.run(["ccx", "job"], cwd=folder, capture_output=True, check=True)
    rows = iter((folder / "job.frd").read_text().splitlines())
    next(row for row in rows if row.startswith("    2C"))
    points = []
    for row in rows:
        if not row.startswith(" -1"):
            break
        points.append([float(row[k : k + 12]) for k in (13, 25, 37)])
    fields = dict(_blocks(folder / "job.frd"))
    _, near = cKDTree(points).query(list(PLACES.values()))
    return fields["DISP"][near][:, :3], von_mises(fields["STRESS"][near])


@pytest.fixture(scope="module")
def solid_sheet():
    """Motion and stress of solids."""
    return solids()


# At the place of the crack an eighth is missing, more than any error that is told there; a fifth
# by elements that are integrated reduced.
@pytest.mark.parametrize(("kind", "inside_MPa"), [("S8", 136), ("S8R", 122)])
def test_shell_elements_underestimate_stress_inside_bend(tmp_path, solid_sheet, kind, inside_MPa):
    moved, stress = solid_sheet
    shell_moved, shell_stress = shells(tmp_path, kind)
    below, inside, leg = (list(PLACES).index(name) for name in ("below", "inside", "leg"))
    assert moved[below, 1] == pytest.approx(1.346 * mm, rel=2e-3)
    assert shell_moved[below, 1] == pytest.approx(moved[below, 1], rel=0.02)
    assert shell_stress[leg] == pytest.approx(stress[leg], rel=0.06)
    # 156.7 MPa by six elements to the radius; two, as here, leave it within a tenth.
    assert stress[inside] == pytest.approx(156.7 * MPa, rel=0.09)
    assert shell_stress[inside] == pytest.approx(inside_MPa * MPa, rel=0.02)
