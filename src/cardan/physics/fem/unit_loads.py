"""A bracket under unit loads: everything else follows by adding them up.

Three forces and three moments at the bearing's centre, spread over its seat, and three
accelerations of the frame, which the bracket's own mass feels.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from cardan.core.arrays import ArrayLike, FloatArray
from cardan.core.status import StatusCallback, ignore_status
from cardan.core.units import Metre
from cardan.model.bracket import FlangeBoundaryCondition
from cardan.model.bracket_compliance import (
    DEFAULT_BRACKET_LOSS_FACTOR,
    BracketCompliance,
    reduce_to_bracket_compliance,
)
from cardan.model.material import Material
from cardan.physics.fem.bracket_solid import HOLE_WALL_NAME_SUFFIX, SEAT_FACE_NAME, BracketSolid
from cardan.physics.fem.elasticity import ElasticSolid, assemble_elastic_solid
from cardan.physics.fem.meshing import mesh
from cardan.physics.fem.ngsolve_import import import_ngsolve

UNIT_LOAD_NAMES = ("Fx", "Fy", "Fz", "Mx", "My", "Mz", "ax", "ay", "az")
"""Forces in N and moments in N m on the bearing, accelerations of the frame in m/s²."""

_NEARLY = 1e-7
"""Share of itself that a motion may still move by where frequencies follow from its square."""
_ANEW = 1e-10
"""Share of its stiffness that a motion has of its own, below which others make it up."""


@dataclass(frozen=True)
class UnitSolutions:
    """The unit solutions of a held bracket; leading axis of loads as in `UNIT_LOAD_NAMES`.

    Attributes
    ----------
    solid : BracketSolid
    elastic : ElasticSolid
    loads, displacements : (9, unknowns)
    element_size : float
        Largest edge that the mesher may use, m.
    """

    solid: BracketSolid
    elastic: ElasticSolid
    loads: FloatArray
    displacements: FloatArray
    element_size: Metre

    @property
    def mass(self) -> float:
        """Mass of the bracket, kg."""
        return self.solid.volume * self.elastic.material.density

    @cached_property
    def compliance(self) -> FloatArray:
        """Mean motion of the seat under forces and moments, (6, 6) m/N, rad/(N m), symmetric.

        The motion is the one the load works on, so it is exact for the spread of the load.
        """
        return self.loads[:6] @ self.displacements[:6].T

    @property
    def reactions(self) -> FloatArray:
        """Force each bolt takes from the frame, (bolts, 9, 3) N."""
        return self.bolt_forces(self.displacements, self.loads)

    def bolt_forces(self, displacements: FloatArray, loads: FloatArray) -> FloatArray:
        """Return the force each bolt takes, (bolts, c, 3) N, where loads (c, unknowns) act."""
        left = np.stack([self.elastic.internal_forces(u) for u in displacements]) - loads
        rigid = self.elastic.rigid[:3]
        # A bolt's share is that of its ring and of its hole's wall.
        known = set(self.elastic.mesh.GetBoundaries())
        parts = [
            [n for n in (b, b + HOLE_WALL_NAME_SUFFIX) if n in known] for b in self.solid.bolts
        ]
        held = [np.any([self.elastic.dofs_on(n) for n in names], axis=0) for names in parts]
        each = [(left * on) @ rigid.T for on in held]
        return np.array(each).reshape(len(held), len(left), 3)  # a welded one has no bolts

    @cached_property
    def at_nodes(self) -> tuple[FloatArray, FloatArray]:
        """Displacement (n, 9, 3) m and stress (n, 9, 6) Pa at the nodes."""
        return self.elastic.at_nodes(self.displacements)

    def unknown_count(self, degree: int) -> int:
        """Return how many displacements elements of another degree have on the same mesh."""
        return 3 * int(import_ngsolve().ngs.H1(self.elastic.mesh, order=degree).ndof)

    def with_degree(self, degree: int, *, held: Mapping[str, str]) -> "UnitSolutions":
        """Return the same on the same mesh, held alike, by elements of another degree."""
        body = assemble_elastic_solid(
            self.elastic.mesh, self.elastic.material, held=held, degree=degree
        )
        return solve_unit_loads(self.solid, body, size=self.element_size)

    def bracket_compliance(
        self,
        frequencies: FloatArray,
        shapes: FloatArray,
        *,
        loss: float = DEFAULT_BRACKET_LOSS_FACTOR,
    ) -> BracketCompliance:
        """Return how the seat gives, by modes (k,) Hz, (k, unknowns) and what they leave.

        Its parts are unit forces along x, y, z, then those modes.
        """
        forced = self.displacements[:3]
        return reduce_to_bracket_compliance(
            self.compliance[:3, :3],
            frequencies=2 * np.pi * frequencies,
            motion=shapes @ self.loads[:3].T,
            inertia=np.stack([self.elastic.mass_times(u) for u in forced]) @ forced.T,
            loss=loss,
        )

    def modes(self, count: int = 6) -> tuple[FloatArray, FloatArray]:
        """Natural frequencies (count,) Hz and shapes (count, unknowns)."""
        return self.elastic.modes(count)

    def loaded_modes(
        self,
        frequencies: FloatArray,
        shapes: FloatArray,
        *,
        mass: float,
        rubber: ArrayLike | None = None,
    ) -> tuple[FloatArray, FloatArray]:
        """Natural frequencies (k,) Hz where a mass (kg) rides on the bearing, in three directions.

        And the share of each mode's energy (k,) that bends the bracket, and no rubber. On rubber of
        stiffness (3,) N/m, or rigidly. By Rayleigh and Ritz, from the modes (k,) Hz, (k, unknowns)
        without it, from what forces on the seat move, and from what the inertia of that does: what
        modes beyond k add falls with the fourth power of their frequency. On rubber right to
        rounding, else to 1e-5 where Lanczos from the start is right to 1e-10.
        """
        seat, static = self.loads[:3], self.displacements[:3]
        heavy = np.stack([self.elastic.mass_times(u) for u in (*shapes, *static)])
        forces = heavy[len(shapes) :]
        slow = self.elastic.solve(forces, still=_NEARLY)
        heavy = np.concatenate([heavy, [self.elastic.mass_times(u) for u in slow]])
        moved = np.concatenate([shapes, static, slow])
        own = (2 * np.pi * frequencies[:, None]) ** 2 * heavy[: len(shapes)]
        stiff = moved @ np.concatenate([own, seat, forces]).T
        # Whitened by the stiffness, each as large as the others: those near in direction go.
        size = 1 / np.sqrt(stiff.diagonal())
        much, ways = np.linalg.eigh((stiff + stiff.T) / 2 * size * size[:, None])
        kept = much > _ANEW
        white = size[:, None] * ways[:, kept] / np.sqrt(much[kept])
        at = white.T @ (moved @ seat.T)  # the seat's motion; rubber adds the rider's own to that
        soft = np.zeros((0, 3)) if rubber is None else np.diag(np.asarray(rubber, float) ** -0.5)
        ride = np.concatenate([at, soft])
        whole = mass * ride @ ride.T
        whole[: len(at), : len(at)] += white.T @ (moved @ heavy.T) @ white
        squares, shapes = np.linalg.eigh((whole + whole.T) / 2)
        bent = (shapes[: len(at)] ** 2).sum(axis=0)
        first = slice(-1, -1 - len(frequencies), -1)
        return 1 / np.sqrt(squares[first]) / (2 * np.pi), bent[first]


def seat_unit_load_vectors(solid: ElasticSolid, *, face: str = SEAT_FACE_NAME) -> FloatArray:
    """Load vectors (6, unknowns) of unit forces and moments about the origin on a face.

    The traction is linear over the face, t = a + b × r: a bearing bonded or pressed in,
    which pulls as it pushes. Its six numbers are such that resultant force and moment are
    exactly those required, wherever the face lies.
    """
    ngs = import_ngsolve().ngs
    x, y, z = ngs.x, ngs.y, ngs.z
    spreads = [(1, 0, 0), (0, 1, 0), (0, 0, 1), (0, -z, y), (z, 0, -x), (-y, x, 0)]
    spread = np.stack([solid.traction(face, ngs.CF(t)) for t in spreads])
    resultants = solid.rigid @ spread.T
    return np.asarray(np.linalg.solve(resultants.T, spread), dtype=float)


def unit_loads(held: ElasticSolid) -> FloatArray:
    """Return the nine unit loads of a bracket as load vectors (9, unknowns)."""
    return np.concatenate(
        [seat_unit_load_vectors(held), np.stack([held.inertia(a) for a in np.eye(3)])]
    )


def mesh_and_solve_unit_loads(
    solid: BracketSolid,
    material: Material,
    *,
    size: Metre | None = None,
    degree: int = 2,
    finer: Sequence[tuple[ArrayLike, Metre]] = (),
    hold: FlangeBoundaryCondition = "sliding",
    tell: StatusCallback = ignore_status,
) -> UnitSolutions:
    """Mesh, hold and solve a bracket under its nine unit loads, with one factorisation.

    `size` is the largest edge of an element, by default the wall's thickness; `finer` are
    points with the edge wanted there (`elastic.mesh`); `hold` is how the flange is held.

    Raises
    ------
    DesignError
        If the mesher fails.
    ConvergenceError
        If the bolts leave the bracket free to move.
    """
    tell("meshing")
    size = size or solid.thickness
    made = mesh(solid.shape, size=size, degree=degree, finer=finer)
    held = assemble_elastic_solid(
        made, material, held=solid.fixed_faces(hold), degree=degree, tell=tell
    )
    return solve_unit_loads(solid, held, size=size, tell=tell)


def solve_unit_loads(
    solid: BracketSolid, held: ElasticSolid, *, size: Metre, tell: StatusCallback = ignore_status
) -> UnitSolutions:
    """Solve a held bracket under its nine unit loads."""
    loads = unit_loads(held)
    tell("solving for nine unit loads")
    return UnitSolutions(
        solid=solid, elastic=held, loads=loads, displacements=held.solve(loads), element_size=size
    )
