"""Where a crack may start, and the stress that decides it there.

On the sheet and on its cut edges that is the stress of the surface. At a weld toe, in a
notch without a radius and along the border of a clamp the stress of the model grows as
elements shrink; there the structural stress counts, carried on from 0.4 and 1.0 wall
thicknesses away, sigma = 1.67 sigma(0.4 t) - 0.67 sigma(1.0 t). Source: Hobbacher, IIW
Recommendations for Fatigue Design of Welded Joints and Components (2016), section 2.2.3.
"""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from cardan.core.arrays import ArrayLike, BoolArray, FloatArray, IntArray
from cardan.core.units import Metre, deg
from cardan.model.bracket import FATIGUE_ZONES
from cardan.physics.fem.bracket_solid import (
    HOLE_WALL_NAME_SUFFIX,
    MOUNT_FACE_NAME,
    SEAT_FACE_NAME,
    WELD_FACE_NAME,
    WELDED_END_NAME_PREFIX,
)
from cardan.physics.fem.meshing import MeshNodes
from cardan.physics.fem.stress import stress_tensor, voigt_vector
from cardan.physics.fem.surface import (
    MIN_RE_ENTRANT_ANGLE_RAD,
    SurfaceEdges,
    SurfaceProjection,
    find_surface_edges,
    project_to_surface,
)

ZONE_SHEET, ZONE_CUT_EDGE, ZONE_WELD_TOE, ZONE_BOLT_BORDER = range(len(FATIGUE_ZONES))

NEAR_REFERENCE_POINT_RATIO, _FAR_REFERENCE_POINT_RATIO = 0.4, 1.0
"""Where the structural stress is read, in thicknesses from the toe."""
_LOOKS = 6
"""Places between the two readings where another toe may be as near."""
_CORNER = -30 * deg
"""Faces that turn away from each other by more meet in a corner of the sheet, or in half of one
that is broken: a chamfer's edges turn by 45 degrees each, to a drawing's last digits."""
_BROKEN, _BENT = 0.25, np.cos(22.5 * deg)
"""Half the width of a face that rounds a corner off, in thicknesses; how far it bends at least."""
_NARROW = 0.6
"""A face is a cut edge where no point of it lies farther from a corner, in thicknesses."""


@dataclass(frozen=True)
class WeldAndClampLines:
    """Points along weld toes and borders of clamps, and where their stress is read.

    Attributes
    ----------
    points, normals : (k, 3) m, 1
        On the toe, on its plate's side; outward normal of the plate.
    frames, near_frames, far_frames : (k, 3, 3)
        Rows: away from the toe in the surface, along it, and the normal; at the toe, and
        carried along to where stress is read.
    near, far : SurfaceProjection
        0.4 and 1.0 thicknesses from the toe.
    can_extrapolate : (k,)
        Whether the plate reaches that far, and no other toe or border lies within 0.4 thicknesses
        of the way; if not the stress at the first point counts, as it is.
    """

    points: FloatArray
    normals: FloatArray
    frames: FloatArray
    near_frames: FloatArray
    far_frames: FloatArray
    near: SurfaceProjection
    far: SurfaceProjection
    can_extrapolate: BoolArray

    def structural_stress(self, nodes: MeshNodes, stress: FloatArray) -> FloatArray:
        """Structural stress (k, c, 6) Pa at the toe from stress at the nodes (n, c, 6)."""

        def read(at: SurfaceProjection, frames: FloatArray) -> FloatArray:
            """Return the stress in the frame that was carried along, (k, c, 3, 3)."""
            return np.einsum(
                "kia,kcab,kjb->kcij", frames, stress_tensor(at.interpolate(nodes, stress)), frames
            )

        near, far = read(self.near, self.near_frames), read(self.far, self.far_frames)
        slope = self._slope[:, None, None, None]
        local = near + slope * (near - far)
        # The surface bears no load of its own: what extrapolation leaves across it is error.
        local[..., 2, :] = local[..., :, 2] = 0.0
        turned = np.einsum("kia,kcij,kjb->kcab", self.frames, local, self.frames)
        return voigt_vector(turned)

    def structural_stress_error(self, nodes: MeshNodes, doubt: FloatArray) -> FloatArray:
        """Doubt (k, c) Pa of the structural stress, from that of the stress at nodes (n, c).

        What carries two readings on to the toe carries their errors on too, 1.67 and 0.67 times.
        """
        near, far = (np.abs(at.interpolate(nodes, doubt)) for at in (self.near, self.far))
        slope = self._slope[:, None]
        return near + slope * (near + far)

    @property
    def _slope(self) -> FloatArray:
        """How much of the step from far to near (k,) is carried on to the toe."""
        return np.where(
            self.can_extrapolate,
            NEAR_REFERENCE_POINT_RATIO / (_FAR_REFERENCE_POINT_RATIO - NEAR_REFERENCE_POINT_RATIO),
            0.0,
        )


@dataclass(frozen=True)
class FatigueZones:
    """Places of a surface where fatigue is evaluated: nodes by themselves, then points of lines.

    Attributes
    ----------
    surface_stress_nodes : (m,)
        Numbers of the nodes whose own stress counts: on the sheet, and on its cut edges.
    lines : WeldAndClampLines
        The k other places, along toes and borders.
    kind : (m + k,)
        Index into `FATIGUE_ZONES`.
    feature : (m + k,)
        Number of the bend, edge, hole or toe each belongs to, the same on every mesh.
    features : ((kind, number), ...)
        Kind, and number from 1 within the kind, of each feature.
    normals : (m + k, 3)
    nearest_place : (surface,)
        For each node of the surface the place that speaks for it: itself, or the nearest.
    """

    surface_stress_nodes: IntArray
    lines: WeldAndClampLines
    kind: IntArray
    feature: IntArray
    features: tuple[tuple[int, int], ...]
    normals: FloatArray
    nearest_place: IntArray

    def points(self, nodes: MeshNodes) -> FloatArray:
        """Places (m + k, 3) m."""
        return np.concatenate([nodes.points[self.surface_stress_nodes], self.lines.points])

    def source_nodes(self, nodes: MeshNodes, at: IntArray) -> IntArray:
        """Return the nodes that the stress of places `at` is read from."""
        own, line = (
            at[at < len(self.surface_stress_nodes)],
            at[at >= len(self.surface_stress_nodes)] - len(self.surface_stress_nodes),
        )
        faces = [of.faces[line] for of in (self.lines.near, self.lines.far)]
        return np.unique(
            np.concatenate([self.surface_stress_nodes[own], nodes.faces[faces].ravel()])
        )

    def stress(self, nodes: MeshNodes, stress: FloatArray) -> FloatArray:
        """Return the stress (m + k, c, 6) Pa that counts at each place, from that at the nodes."""
        return np.concatenate(
            [stress[self.surface_stress_nodes], self.lines.structural_stress(nodes, stress)]
        )


def find_fatigue_zones(
    nodes: MeshNodes, *, held: tuple[str, ...], thickness: Metre
) -> FatigueZones:
    """Return the places of a surface where fatigue is evaluated.

    Parameters
    ----------
    nodes
        Of the mesh; faces called "weld" are welds, re-entrant edges elsewhere toes.
    held
        Names of the faces that are held.
    thickness
        Of the walls; where it differs, at a rib, it is measured.
    """
    from scipy.spatial import cKDTree

    edges, narrow = _drawn(nodes, thickness)
    names = nodes.face_names
    on_held = np.isin(names, held)
    weld = np.char.startswith(names.astype(str), WELD_FACE_NAME)
    here, there = edges.faces, edges.opposite_faces
    border = ~on_held[here] & on_held[there]
    toe = ~on_held[here] & ~on_held[there] & ~weld[here]
    toe &= weld[there] | (edges.turn_angle > MIN_RE_ENTRANT_ANGLE_RAD)
    cut = narrow[nodes.face_numbers] & ~weld & (names != SEAT_FACE_NAME)
    at = edges[border | toe]
    lines = _lines(nodes, at, thickness=thickness)
    welded = np.char.startswith(names[at.opposite_faces].astype(str), WELDED_END_NAME_PREFIX)
    line_kind = np.where(border[border | toe] & ~welded, ZONE_BOLT_BORDER, ZONE_WELD_TOE)
    # Where the frame's plane ends the sheet is plain: no washer bears on it, no hole is there.
    plane = names[at.opposite_faces] == MOUNT_FACE_NAME
    line_kind[plane] = np.where(cut[at.faces[plane]], ZONE_CUT_EDGE, ZONE_SHEET)
    line_key = np.empty(len(line_kind), dtype=object)
    chains = _chains(nodes, at)
    for k, kind in enumerate(line_kind.tolist()):
        which = {
            ZONE_BOLT_BORDER: _bolt(str(names[at.opposite_faces[k]])),
            ZONE_WELD_TOE: int(chains[k]),
        }.get(kind, int(nodes.face_numbers[at.faces[k]]))
        line_key[k] = (kind, which)

    surface = nodes.surface_nodes
    face_of = _face_of(nodes, cut=cut, left_out=on_held | weld)
    clear = np.ones(len(surface), dtype=bool)
    if len(lines.points):
        # What lies nearer a toe than its stress is read is the toe's own business. No farther:
        # between there and the second reading a fillet may stand higher than both.
        away, _ = cKDTree(nodes.points[np.unique(at.nodes)]).query(nodes.points[surface])
        clear = away > 0.99 * NEAR_REFERENCE_POINT_RATIO * thickness
    asked = clear & (face_of[surface] >= 0)
    own = surface[asked]
    own_kind = np.where(cut[face_of[own]], ZONE_CUT_EDGE, ZONE_SHEET)
    number = nodes.face_numbers[face_of[own]]
    own_key = np.empty(len(own), dtype=object)
    own_key[:] = list(zip(own_kind.tolist(), number.tolist(), strict=True))

    keys = [*own_key.tolist(), *line_key.tolist()]
    # Numbered over all the drawing has, so that a face keeps its number however it is held
    # and meshed.
    every_face = np.unique(nodes.face_numbers).tolist()
    # However it is held: a clamped plane and a welded end need no border of a bolt.
    held_names = {str(n) for n in names[on_held]} - {MOUNT_FACE_NAME}
    bolts = sorted(
        {_bolt(n) for n in held_names if not n.startswith(WELDED_END_NAME_PREFIX)}, key=_counted
    )
    ranks = {ZONE_SHEET: every_face, ZONE_CUT_EDGE: every_face, ZONE_BOLT_BORDER: bolts,
             ZONE_WELD_TOE: np.unique(chains[line_kind == ZONE_WELD_TOE]).tolist()}  # fmt: skip
    known = sorted(set(keys), key=lambda key: (key[0], ranks[key[0]].index(key[1])))
    place = {key: k for k, key in enumerate(known)}
    features = [(kind, 1 + ranks[kind].index(which)) for kind, which in known]
    told_by = np.full(len(surface), -1, dtype=np.int64)
    told_by[asked] = np.arange(len(own))
    every = np.concatenate([nodes.points[own], lines.points])
    silent = ~asked
    if silent.any() and len(every):
        among = np.arange(len(own), len(every)) if len(lines.points) else np.arange(len(every))
        _, close = cKDTree(every[among]).query(nodes.points[surface[silent]])
        told_by[silent] = among[close]
    return FatigueZones(
        surface_stress_nodes=own,
        lines=lines,
        kind=np.concatenate([own_kind, line_kind]).astype(np.int64),
        feature=np.array([place[key] for key in keys], dtype=np.int64),
        features=tuple(features),
        normals=np.concatenate([_normals(nodes)[own], lines.normals]),
        nearest_place=told_by,
    )


@lru_cache(maxsize=1)
def _drawn(nodes: MeshNodes, thickness: Metre) -> tuple[SurfaceEdges, BoolArray]:
    """Return where faces of the drawing meet, and which are cut edges, however it is held."""
    edges = find_surface_edges(nodes)
    return edges, _cut(nodes, edges, thickness)


def _counted(name: str) -> tuple[int, str]:
    """Return what sorts names that end in a number as they count: bolt 2 before bolt 10."""
    return len(name), name


def _bolt(name: str) -> str:
    """Return the bolt a held face belongs to."""
    return name.removesuffix(HOLE_WALL_NAME_SUFFIX)


def _along(nodes: MeshNodes, edges: SurfaceEdges) -> FloatArray:
    """Return points (k, 3) m close together along edges."""
    a, m, b = (nodes.points[edges.nodes[:, k]] for k in range(3))
    s = np.linspace(0, 1, 9)[:, None, None]
    along = (1 - s) * (1 - 2 * s) * a + 4 * s * (1 - s) * m + s * (2 * s - 1) * b
    return along.reshape(-1, 3)


def _cut(nodes: MeshNodes, edges: SurfaceEdges, thickness: Metre) -> BoolArray:
    """Whether each face of the drawing is a cut edge of the sheet, (faces,).

    That is a face no point of which is far from a corner; and with it what breaks its corners,
    which by itself is none: so are the edges of a thick block.
    """
    breaks, rounds = _breaking(nodes, edges, _BROKEN * thickness)
    round_ = nodes.points[np.unique(nodes.faces[rounds[nodes.face_numbers]])]
    corner = np.concatenate([_along(nodes, edges[edges.turn_angle < _CORNER]), round_])
    cut = (_farthest(nodes, corner) <= _NARROW * thickness) & ~breaks
    face, other = (nodes.face_numbers[of] for of in (edges.faces, edges.opposite_faces))
    beside = np.zeros_like(cut)
    beside[face[cut[other]]] = True
    cut |= breaks & beside
    # Where three broken edges meet a patch lies among them, and is what they are.
    among, beside = breaks.copy(), np.zeros_like(cut)
    among[face[~breaks[other]]] = False
    beside[face[cut[other]]] = True
    return cut | (among & beside)


def _breaking(nodes: MeshNodes, edges: SurfaceEdges, width: Metre) -> tuple[BoolArray, BoolArray]:
    """Return which faces (faces,) break a corner of the sheet, and which of them by a round.

    Such a face is narrow. A round bends from one of its edges to the other, and outwards; a
    chamfer turns half of a corner at each.
    """
    face, count = nodes.face_numbers[edges.faces], int(nodes.face_numbers.max()) + 1
    mean = np.zeros((count, 3))
    np.add.at(mean, face, edges.normals)
    mean /= np.maximum(np.linalg.norm(mean, axis=1, keepdims=True), 1e-300)
    bent, outwards = np.ones(count), np.zeros(count)
    np.minimum.at(bent, face, (mean[face] * edges.normals).sum(-1))
    np.add.at(outwards, face, ((mean[face] - edges.normals) * edges.into).sum(-1))
    turn = np.bincount(face, edges.turn_angle, count) / np.maximum(
        np.bincount(face, minlength=count), 1
    )
    narrow = _farthest(nodes, _along(nodes, edges)) <= width
    rounds = narrow & (bent < _BENT) & (outwards > 0)
    return rounds | (narrow & (turn < _CORNER) & (turn > 2 * _CORNER)), rounds


def _farthest(nodes: MeshNodes, points: FloatArray) -> FloatArray:
    """Return how far from points (k, 3) m the farthest of each face of the drawing is, (faces,)."""
    from scipy.spatial import cKDTree

    farthest = np.zeros(int(nodes.face_numbers.max()) + 1)
    if not len(points):
        return farthest + np.inf
    away = np.zeros(len(nodes.points))
    away[nodes.surface_nodes] = cKDTree(points).query(nodes.points[nodes.surface_nodes])[0]
    np.maximum.at(farthest, nodes.face_numbers, away[nodes.faces].max(axis=1))
    return farthest


def _face_of(nodes: MeshNodes, *, cut: BoolArray, left_out: BoolArray) -> IntArray:
    """Return a triangle for each node that says whose it is, a cut edge's first; -1 for none."""
    found = np.full(len(nodes.points), -1, dtype=np.int64)
    for which in (~cut & ~left_out, cut & ~left_out):
        rows = np.flatnonzero(which)
        # Where faces meet the one with the lowest number has the node, whatever the mesh.
        rows = rows[np.argsort(-nodes.face_numbers[rows], kind="stable")]
        found[nodes.faces[rows]] = rows[:, None]
    return found


def _chains(nodes: MeshNodes, edges: SurfaceEdges) -> IntArray:
    """Return the number of the connected chain that each edge (k,) belongs to.

    Numbered by the lowest face the chain touches, so it is the same on every mesh.
    """
    from scipy.sparse import coo_matrix
    from scipy.sparse.csgraph import connected_components

    ends = edges.nodes[:, [0, 2]]
    if not len(ends):
        return np.zeros(0, dtype=np.int64)
    count = len(nodes.points)
    links = coo_matrix((np.ones(len(ends)), (ends[:, 0], ends[:, 1])), shape=(count, count))
    _, chain = connected_components(links, directed=False)
    mine = chain[ends[:, 0]]
    pairs = nodes.face_numbers[edges.faces] * 10_000 + nodes.face_numbers[edges.opposite_faces]
    first = np.full(int(mine.max()) + 1, np.iinfo(np.int64).max)
    np.minimum.at(first, mine, pairs)
    return first[mine]


def _normals(nodes: MeshNodes) -> FloatArray:
    """Outward normals (n, 3) at the nodes, the mean of the faces that meet; 0 inside."""
    corners = nodes.points[nodes.faces[:, :3]]
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    found = np.zeros_like(nodes.points)
    for k in range(6):
        np.add.at(found, nodes.faces[:, k], normal)
    size = np.linalg.norm(found, axis=-1, keepdims=True)
    return found / np.where(size > 0, size, 1.0)


def _lines(nodes: MeshNodes, edges: SurfaceEdges, *, thickness: Metre) -> WeldAndClampLines:
    """Walk from the middles of edges into their faces, and read what lies there."""
    start = nodes.points[edges.nodes[:, 1]]
    frame = np.stack([edges.into, edges.along, edges.normals], axis=1)
    if not len(start):
        none = project_to_surface(nodes, np.zeros((0, 3)))
        empty = np.zeros((0, 3, 3))
        return WeldAndClampLines(
            start, start, empty, empty, empty, none, none, np.zeros(0, dtype=bool)
        )
    t = wall_thickness(nodes, start + 0.3 * thickness * edges.into, edges.normals, usual=thickness)
    near, near_frame, ok = _step(nodes, start, frame, NEAR_REFERENCE_POINT_RATIO * t)
    far, far_frame, ok_too = _step(
        nodes,
        near.points,
        near_frame,
        (_FAR_REFERENCE_POINT_RATIO - NEAR_REFERENCE_POINT_RATIO) * t,
    )
    room = (
        ok & ok_too & _clear(nodes, edges, near.points, far.points, NEAR_REFERENCE_POINT_RATIO * t)
    )
    return WeldAndClampLines(
        points=start, normals=edges.normals, frames=frame,
        near_frames=near_frame, far_frames=far_frame, near=near, far=far, can_extrapolate=room,
    )  # fmt: skip


def _clear(
    nodes: MeshNodes, edges: SurfaceEdges, near: FloatArray, far: FloatArray, apart: FloatArray
) -> BoolArray:
    """Whether lines from near to far points (k, 3) m stay so far `apart` (k,) m from all edges.

    What is read nearer another toe is that one's notch, and beyond it no stress of this toe's.
    """
    from scipy.spatial import cKDTree

    part = np.arange(1, _LOOKS + 1)[:, None, None] / _LOOKS
    away, _ = cKDTree(_along(nodes, edges)).query(near + part * (far - near))
    return np.asarray((away > 0.99 * apart).all(axis=0), dtype=bool)


def _step(
    nodes: MeshNodes, start: FloatArray, frame: FloatArray, length: FloatArray
) -> tuple[SurfaceProjection, FloatArray, BoolArray]:
    """Go a length (k,) along the surface: where that leads, the frame there, and if it does."""
    found = project_to_surface(nodes, start + length[:, None] * frame[:, 0])
    normal = found.normals
    into: FloatArray = frame[:, 0] - (frame[:, 0] * normal).sum(-1, keepdims=True) * normal
    size = np.linalg.norm(into, axis=-1, keepdims=True)
    into = np.asarray(into / np.where(size > 0, size, 1.0), dtype=float)
    turned = (normal * frame[:, 2]).sum(-1)
    ok = (found.distances <= 0.35 * length) & (turned > 0.5)
    return found, np.stack([into, np.cross(normal, into), normal], axis=1), ok


def wall_thickness(
    nodes: MeshNodes, points: ArrayLike, normals: ArrayLike, *, usual: Metre
) -> FloatArray:
    """Thickness (k,) m of the wall under points of its surface (k, 3) m, at most 1.5 times usual.

    From a point three quarters of the usual thickness below, the nearest surface is that of
    the wall's other side; where it is not, at an edge, the usual thickness is taken.
    """
    points, normals = np.asarray(points, dtype=float), np.asarray(normals, dtype=float)
    below = 0.75 * usual
    found = project_to_surface(nodes, points - below * normals)
    across = (found.normals * normals).sum(-1) < -0.7
    inside = ((points - below * normals - found.points) * found.normals).sum(-1) < 0
    other = below + np.where(inside, 1, -1) * found.distances
    return np.where(across, np.clip(other, 0.25 * usual, 1.5 * usual), usual)
