"""A bracket as an input deck of CalculiX, which Abaqus reads too.

Source: Dhondt, CalculiX CrunchiX User's Manual 2.20: *COUPLING, *DISTRIBUTING, *DLOAD.
"""

from collections.abc import Iterable, Iterator

from cardan.core.arrays import BoolArray, FloatArray, IntArray
from cardan.core.units import Metre, mm
from cardan.model.material import Material
from cardan.physics.fem.bracket_solid import SEAT_FACE_NAME
from cardan.physics.fem.meshing import MeshNodes
from cardan.topics.bracket.solver_deck import SolverDeck, deck_loads, element_faces, set_name

_NAMES_PER_LINE = 16
"""Numbers in a line of a set, at most, in both programs."""


def inp_text(deck: SolverDeck) -> str:
    """Return an input deck: mesh, sets, material, seat coupling, held faces, one step a case."""
    nodes, reference = deck.nodes, deck.reference_node
    seat = set_name(SEAT_FACE_NAME)
    lines = [
        *(f"** {line}" for line in deck.comments),
        *node_lines(nodes.points / mm),
        f"{reference},0.,0.,0.",  # in one block: readers of meshes keep the last one alone
        *node_set_lines("REFERENCE", (reference,)),
        *element_lines(nodes.elements),
    ]
    for face, name in deck.face_sets.items():
        lines += node_set_lines(name, deck.face_nodes(face))
    lines += [
        *surface_lines(f"{seat}_FACES", nodes, nodes.face_names == SEAT_FACE_NAME),
        *material_lines(deck.material, length=mm),
        f"*COUPLING,CONSTRAINT NAME=BEARING,REF NODE={reference},SURFACE={seat}_FACES",
        "*DISTRIBUTING",
        "1,6",
        "** Held: the flange slides in its plane.",
        "*BOUNDARY",
        *_boundary_lines(deck.held),
        "** The clamped flange instead:",
        *(f"** {line}" for line in _boundary_lines(deck.held_clamped)),
        f"** {deck.frequency_text}",
        "** This step, in place of the others, computes them:",
        *(f"** {line}" for line in _frequency_step(len(deck.frequencies))),
    ]
    for k, step in enumerate(deck.steps, 1):
        *forces, ax, ay, az = deck_loads(step.loads).tolist()
        lines += [
            f"** Step {k}: {step.title}",
            f"** largest displacement {step.max_displacement / mm:.6g} mm",
            "*STEP",
            "*STATIC",
            "*CLOAD,OP=NEW",
            *(f"{reference},{dof},{f:.9e}" for dof, f in enumerate(forces, 1) if f),
            "*DLOAD,OP=NEW",
            *(
                f"EALL,GRAV,{abs(a):.9e},{_against(axis, a)}"
                for axis, a in enumerate((ax, ay, az))
                if a
            ),
            "*NODE FILE",
            "U",
            "*EL FILE",
            "S",
            "*END STEP",
        ]
    return "\n".join(lines) + "\n"


def node_lines(points: FloatArray) -> Iterator[str]:
    """Yield the nodes (n, 3), counted from 1, as the set NALL; 20 characters a number at most."""
    yield "*NODE,NSET=NALL"
    for k, (x, y, z) in enumerate(points.tolist(), 1):
        yield f"{k},{x:.12e},{y:.12e},{z:.12e}"


def element_lines(elements: IntArray) -> Iterator[str]:
    """Yield ten-node tetrahedra (e, 10) of nodes counted from 0, as the set EALL."""
    yield "*ELEMENT,TYPE=C3D10,ELSET=EALL"
    for k, nodes in enumerate((elements + 1).tolist(), 1):
        yield f"{k}," + ",".join(map(str, nodes))


def node_set_lines(name: str, nodes: Iterable[int]) -> Iterator[str]:
    """Yield a set of nodes, counted from 1."""
    yield f"*NSET,NSET={name}"
    every = [str(n) for n in nodes]
    for k in range(0, len(every), _NAMES_PER_LINE):
        yield ",".join(every[k : k + _NAMES_PER_LINE]) + ","


def surface_lines(
    name: str, nodes: MeshNodes, which: BoolArray, *, after: int = 0
) -> Iterator[str]:
    """Yield a surface of elements' faces: some triangles (f,) of a mesh."""
    yield f"*SURFACE,NAME={name},TYPE=ELEMENT"
    for element, face in element_faces(nodes, which, after=after):
        yield f"{element},S{face}"


def material_lines(material: Material, *, length: Metre = 1.0) -> list[str]:
    """Return material and section of all elements, in N, s and a unit of length in m."""
    return [
        "*MATERIAL,NAME=METAL",
        "*ELASTIC",
        f"{material.youngs_modulus * length**2:.12e},{material.poisson:.9g}",
        "*DENSITY",
        f"{material.density * length**4:.12e}",
        "*SOLID SECTION,ELSET=EALL,MATERIAL=METAL",
    ]


def _boundary_lines(held: dict[str, str]) -> Iterator[str]:
    """Yield the directions in which faces, by their sets, are held."""
    for face, axes in held.items():
        for axis in axes:
            dof = "xyz".index(axis) + 1
            yield f"{set_name(face)},{dof},{dof}"


def _frequency_step(count: int) -> tuple[str, ...]:
    """Return a step that computes the lowest natural frequencies."""
    return "*STEP", "*FREQUENCY", str(count), "*END STEP"


def _against(axis: int, size: float) -> str:
    """Return the direction against a component along an axis, as three numbers."""
    return ",".join("0." if k != axis else "-1." if size > 0 else "1." for k in range(3))
