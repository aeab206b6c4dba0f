"""Tetrahedra that follow the curved faces of a solid, and their corners and edge middles."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
import numpy.typing as npt

from cardan.core.arrays import ArrayLike, FloatArray, IntArray
from cardan.core.errors import DesignError
from cardan.core.units import Metre, mm
from cardan.physics.fem.ngsolve_import import import_ngsolve

# The engine's corners with the first two swapped: VTK's and Abaqus's sense of rotation.
_SWAP = [1, 0, 2, 3]
REFERENCE_CORNERS = np.array([(0, 1, 0), (1, 0, 0), (0, 0, 1), (0, 0, 0)], dtype=float)
_EDGES = ((0, 1), (1, 2), (0, 2), (0, 3), (1, 3), (2, 3))  # the order of VTK and Abaqus
SUBTRIANGLE_NODES_OF_SIX_NODE_TRIANGLE = ((0, 3, 5), (3, 1, 4), (5, 4, 2), (3, 4, 5))
"""Of a six-node triangle its nodes."""
ELEMENTS_PER_CURVATURE_RADIUS = 1.5
"""Elements to a radius of curvature."""


def mesh(
    shape: Any,
    *,
    size: Metre,
    degree: int = 2,
    finer: Sequence[tuple[ArrayLike, Metre]] = (),
    grading: float = 0.5,
    per_radius: float = ELEMENTS_PER_CURVATURE_RADIUS,
) -> Any:
    """Mesh a solid of the CAD kernel with tetrahedra that follow its curved faces.

    Parameters
    ----------
    shape
        OpenCASCADE solid, in metres.
    size
        Largest edge of an element.
    degree
        Degree of the curves that follow the faces.
    finer : [((3,) m, m), ...]
        Points to refine at, each with the edge wanted there.
    grading
        How fast elements grow away from small ones, 0 to 1.
    per_radius
        Elements to a radius of curvature.

    Raises
    ------
    DesignError
        If the mesher fails.
    """
    ngs, occ, mesher = import_ngsolve()
    if not size > 0:
        msg = f"elements need a size above 0, got {size:g} m"
        raise ValueError(msg)
    # Netgen's own floor for edges, 1e-3, is meant for millimetres.
    wanted = mesher.MeshingParameters(
        maxh=size, grading=grading, curvaturesafety=per_radius, minedgelen=1e-7,
        parallel_meshing=False,  # its threads spin while they wait: up to three times the work
    )  # fmt: skip
    for point, edge in finer:
        x, y, z = np.asarray(point, dtype=float)
        wanted.RestrictH(x=x, y=y, z=z, h=edge)
    msg = (
        f"the mesher failed on this shape with elements of {size / mm:.3g} mm: try smaller "
        "elements; slivers and gaps in a STEP file are the usual cause"
    )
    try:
        made = ngs.Mesh(occ.OCCGeometry(shape).GenerateMesh(mp=wanted))
    except Exception as error:  # the mesher raises bare exceptions of its own
        raise DesignError(msg, about="bracket") from error
    if made.ne == 0:
        raise DesignError(msg, about="bracket")
    made.Curve(degree)
    return made


@dataclass(frozen=True, eq=False)
class MeshNodes:
    """Corners and edge middles of a mesh: where fields are drawn and searched.

    Attributes
    ----------
    points : (n, 3) m
    elements : (e, 10)
        Node numbers of each tetrahedron, four corners and six edge middles in the order of
        VTK's quadratic tetrahedron.
    faces : (f, 6)
        Node numbers of each surface triangle: three corners, then the middles of edges 01,
        12, 20; seen from outside they run anticlockwise.
    face_names : (f,)
        Name of the face each triangle lies on.
    face_numbers : (f,)
        Number of that face in the drawing: names are shared, numbers are not.
    """

    points: FloatArray
    elements: IntArray
    faces: IntArray
    face_names: npt.NDArray[np.str_]
    face_numbers: IntArray

    @cached_property
    def surface_nodes(self) -> IntArray:
        """Numbers of the nodes on the surface."""
        return np.unique(self.faces)

    @cached_property
    def quarter_triangles(self) -> tuple[FloatArray, Any]:
        """Corners (4 f, 3, 3) m of flat quarters of its triangles, and a tree of their middles."""
        from scipy.spatial import cKDTree

        flat = self.points[self.faces[:, SUBTRIANGLE_NODES_OF_SIX_NODE_TRIANGLE].reshape(-1, 3)]
        return flat, cKDTree(flat.mean(axis=1))


def shape_functions(reference: FloatArray) -> FloatArray:
    """Return the weights (k, 10) of an element's nodes at reference coordinates (k, 3)."""
    xi = np.column_stack([reference, 1 - reference.sum(axis=1)])
    L = xi[
        :,
        np.argmax(np.column_stack([REFERENCE_CORNERS, REFERENCE_CORNERS.sum(axis=1) == 0]), axis=1),
    ]
    return np.column_stack([L * (2 * L - 1), *(4 * L[:, a] * L[:, b] for a, b in _EDGES)])


def nodal_rule() -> Any:
    """Corners and edge middles of the reference tetrahedron, as the engine samples them."""
    middles = [tuple((REFERENCE_CORNERS[a] + REFERENCE_CORNERS[b]) / 2) for a, b in _EDGES]
    return import_ngsolve().ngs.IntegrationRule(
        [*map(tuple, REFERENCE_CORNERS), *middles], [0.0] * 10
    )


def mesh_nodes(made: Any) -> MeshNodes:
    """Count corners and edge middles of a mesh of the engine."""
    ngs = import_ngsolve().ngs
    raw = made.ngmesh
    corners = raw.Elements3D().NumPy()["nodes"][:, _SWAP].astype(np.int64) - 1
    faces = raw.Elements2D().NumPy()
    triangles = faces["nodes"][:, :3].astype(np.int64) - 1
    count = len(raw.Coordinates())
    pairs = np.sort(np.stack([corners[:, list(e)] for e in _EDGES], axis=1), axis=-1)
    keys = pairs[..., 0] * count + pairs[..., 1]
    edges, numbers = np.unique(keys, return_inverse=True)
    elements = np.concatenate([corners, count + numbers.reshape(keys.shape)], axis=1)
    points = np.empty((count + len(edges), 3))
    where = made.MapToAllElements(nodal_rule(), ngs.VOL)
    points[elements.ravel()] = ngs.CF((ngs.x, ngs.y, ngs.z))(where)
    # A face inside, where solids are glued, is no surface: two elements share it.
    four = np.sort(corners[:, [[1, 2, 3], [0, 2, 3], [0, 1, 3], [0, 1, 2]]].reshape(-1, 3), -1)
    shared = (four[:, 0] * count + four[:, 1]) * count + four[:, 2]
    known, times = np.unique(shared, return_counts=True)
    mine = np.sort(triangles, -1)
    mine = (mine[:, 0] * count + mine[:, 1]) * count + mine[:, 2]
    outer = times[np.searchsorted(known, mine)] == 1
    triangles, faces = triangles[outer], faces[outer]
    sides = np.sort(
        np.stack([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]], 1), -1
    )
    middles = count + np.searchsorted(edges, sides[..., 0] * count + sides[..., 1])
    names = np.array([str(n) for n in made.GetBoundaries()])
    return MeshNodes(
        points=points,
        elements=elements,
        faces=np.concatenate([triangles, middles], axis=1),
        face_names=names[faces["index"].astype(int) - 1],
        face_numbers=faces["index"].astype(np.int64),
    )
