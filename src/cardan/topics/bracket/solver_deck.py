"""A bracket as an input deck for other finite element programs: what each format is written from.

Decks are in mm, N, MPa, t and s. The mesh is that of the result, of ten-node tetrahedra, and the
loads of a case are those at the moment of its highest stress, which `peak_loads` says.
"""

import re
import unicodedata
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from cardan.core.arrays import BoolArray, FloatArray, IntArray
from cardan.core.units import mm
from cardan.core.version import __version__
from cardan.model.bracket import Bracket
from cardan.model.material import Material
from cardan.physics.fem.bracket_solid import SEAT_FACE_NAME
from cardan.physics.fem.meshing import MeshNodes
from cardan.topics.bracket.shape_result import ShapeAssessment
from cardan.topics.bracket.vtk_file import max_displacement_at_peak, peak_loads

_FACES_OF_ELEMENT = np.array([(0, 1, 2), (0, 3, 1), (1, 3, 2), (2, 3, 0)])
"""Corners of the faces S1 to S4 of a tetrahedron, as Abaqus and CalculiX count them."""


@dataclass(frozen=True, kw_only=True)
class DeckStep:
    """One load step: what it is, and its loads (9,) as `UNIT_LOAD_NAMES`, SI.

    `max_displacement` is the largest displacement cardan computes in it, m.
    """

    title: str
    loads: FloatArray
    max_displacement: float


@dataclass(frozen=True, kw_only=True)
class SolverDeck:
    """A bracket's mesh, material, held faces and load steps.

    `held`, and `held_clamped` for the other way to hold the flange, are faces by name with the
    axes along which they are held. `comments` are lines of plain text for the head of the file.
    `frequencies` (m,) are those of the bracket alone, held sliding, Hz.
    """

    comments: tuple[str, ...]
    nodes: MeshNodes
    material: Material
    held: dict[str, str]
    held_clamped: dict[str, str]
    frequencies: FloatArray
    steps: tuple[DeckStep, ...]

    @property
    def reference_node(self) -> int:
        """Number of the node at the bearing's centre, which loads act on; beyond the mesh's."""
        return len(self.nodes.points) + 1

    def face_nodes(self, name: str) -> IntArray:
        """Return the numbers (k,) of the nodes on a face, counted from 1."""
        return np.unique(self.nodes.faces[self.nodes.face_names == name]) + 1

    @property
    def frequency_text(self) -> str:
        """The natural frequencies as a line for the deck, which it has by its density."""
        values = ", ".join(f"{f:.6g}" for f in self.frequencies.tolist())
        return f"Natural frequencies of the bracket alone, the flange sliding: {values} Hz"

    @property
    def face_sets(self) -> dict[str, str]:
        """Names of sets by the faces they are of: seat and all held, either way."""
        faces = dict.fromkeys((SEAT_FACE_NAME, *self.held, *self.held_clamped))
        return {face: set_name(face) for face in faces if len(self.face_nodes(face))}


def solver_deck(bracket: Bracket, v: ShapeAssessment, *, title: str, said: str = "") -> SolverDeck:
    """Return the deck of one shape of a bracket, the flange held sliding.

    `said` is the verdict: the file may be all that is passed on.
    """
    head = f"cardan {__version__}: bracket of {title}, {v.name}"
    return SolverDeck(
        comments=tuple(map(plain_text, (head, *said.splitlines(), *_comments(bracket, v)))),
        nodes=v.solved.nodes,
        material=bracket.material,
        held=v.solved.sliding.fixed_faces,
        held_clamped=v.solved.clamped.fixed_faces,
        frequencies=v.frequencies,
        steps=tuple(
            DeckStep(
                title=plain_text(str(o.case.when)),
                loads=peak_loads(v, o),
                max_displacement=max_displacement_at_peak(v, o).value,
            )
            for o in v.case_results
        ),
    )


def _comments(bracket: Bracket, v: ShapeAssessment) -> Iterator[str]:
    """Yield what a reader of the deck should know: units, loads, and what is not in it."""
    yield "Units: mm, N, MPa, t, s; moments in N mm, accelerations in mm/s2."
    yield "Axes: the vehicle's (x rearward, y to the right, z up); origin: bearing centre."
    yield "Loads act on the node at the origin, spread linearly over the seat."
    yield "An acceleration is the frame's: the bracket's own mass is loaded against it."
    yield "One step a case, static, at the moment of its highest stress."
    yield "Held: flange sliding. Sets for the clamped flange are there as well."
    if bracket.carried_mass > 0:
        loaded = ", ".join(f"{f:.4g}" for f in v.loaded_frequencies.tolist())
        yield (
            f"Not in the deck: {bracket.carried_mass:g} kg carried on its rubber; with it the "
            f"natural frequencies are {loaded} Hz."
        )
    if any(o.case.is_dynamic for o in v.case_results):
        yield "The bracket's own vibration is not in the steps."
    if bracket.bolts is not None:
        yield "Contact with the frame is not in the deck: the flange slides in its plane."
    if bracket.order != 2:
        yield f"cardan solved with elements of degree {bracket.order}, here of 2: results differ."


def plain_text(text: str) -> str:
    """Return a text in ASCII, without accents, in one line: solvers read no other letters."""
    letters = (c for c in unicodedata.normalize("NFKD", text) if not unicodedata.combining(c))
    return " ".join("".join(letters).encode("ascii", "replace").decode().split())


def set_name(face: str) -> str:
    """Return the name of a face's set: letters, digits and underscores, in capitals."""
    return re.sub(r"[^A-Z0-9_]", "_", face.upper())


def deck_loads(loads: FloatArray) -> FloatArray:
    """Return loads (9,) of SI units in N, N mm and mm/s²."""
    return loads / np.repeat([1.0, mm, mm], 3)


def element_faces(nodes: MeshNodes, which: BoolArray, *, after: int = 0) -> list[tuple[int, int]]:
    """Return element (from 1 + `after`) and number of its face, 1 to 4, of surface triangles."""
    table = {
        tuple(sorted(corners)): (e + 1 + after, s + 1)
        for s, face in enumerate(_FACES_OF_ELEMENT)
        for e, corners in enumerate(nodes.elements[:, face].tolist())
    }
    return [table[tuple(sorted(c))] for c in nodes.faces[which][:, :3].tolist()]
