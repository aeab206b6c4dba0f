"""The surface of a meshed bracket: the point nearest to another, its normal, its sharp edges."""

from dataclasses import dataclass

import numpy as np

from cardan.core.arrays import ArrayLike, BoolArray, FloatArray, IntArray
from cardan.core.units import deg
from cardan.physics.fem.meshing import SUBTRIANGLE_NODES_OF_SIX_NODE_TRIANGLE, MeshNodes

MIN_RE_ENTRANT_ANGLE_RAD = 20 * deg
"""Faces that turn towards each other by more meet in a notch without a radius."""

_CANDIDATES = 16
_AREA = np.array([(1, 0, 0), (0, 1, 0), (0, 0, 1), (0.5, 0.5, 0), (0, 0.5, 0.5), (0.5, 0, 0.5)])
"""Area coordinates of a six-node triangle's nodes."""


@dataclass(frozen=True)
class SurfaceProjection:
    """Points drawn to the surface: where they came to lie, outward normals, how far it was.

    `faces` (k,) are the triangles they lie on, `weights` (k, 6) those of their nodes.
    """

    points: FloatArray
    normals: FloatArray
    distances: FloatArray
    faces: IntArray
    weights: FloatArray

    def interpolate(self, nodes: MeshNodes, values: FloatArray) -> FloatArray:
        """Return what a field known at the nodes (n, ...) is at the points, (k, ...)."""
        return np.einsum("kq,kq...->k...", self.weights, values[nodes.faces[self.faces]])


def project_to_surface(nodes: MeshNodes, points: ArrayLike) -> SurfaceProjection:
    """Draw points (k, 3) m to the surface, flat between its nodes."""
    points = np.asarray(points, dtype=float).reshape(-1, 3)
    flat, tree = nodes.quarter_triangles
    _, close = tree.query(points, k=min(_CANDIDATES, len(flat)))
    close = np.reshape(close, (len(points), min(_CANDIDATES, len(flat))))
    feet = _feet(points[:, None], flat[close])
    away = np.linalg.norm(feet - points[:, None], axis=-1)
    best = away.argmin(axis=1)
    rows = np.arange(len(points))
    quarter = close[rows, best]
    corner, foot = flat[quarter], feet[rows, best]
    normal = np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0])
    square = (normal * normal).sum(-1)
    a, b, c = (corner[:, k] for k in range(3))
    second = (np.cross(foot - a, c - a) * normal).sum(-1) / square
    third = (np.cross(b - a, foot - a) * normal).sum(-1) / square
    inside = np.stack([1 - second - third, second, third], axis=-1)
    # The same point in the six-node triangle the quarter is of, and its shape functions there.
    L = np.einsum(
        "kq,kqc->kc", inside, _AREA[np.array(SUBTRIANGLE_NODES_OF_SIX_NODE_TRIANGLE)[quarter % 4]]
    )
    weights = np.concatenate([L * (2 * L - 1), 4 * L * np.roll(L, -1, axis=1)], axis=1)
    return SurfaceProjection(
        points=foot,
        normals=normal / np.linalg.norm(normal, axis=-1, keepdims=True),
        distances=away[rows, best],
        faces=quarter // 4,
        weights=weights,
    )


def _feet(p: FloatArray, triangles: FloatArray) -> FloatArray:
    """Points of triangles (..., 3, 3) nearest to points (..., 3): inside, on a side or corner."""
    a, b, c = (triangles[..., k, :] for k in range(3))

    def on_side(u: FloatArray, v: FloatArray) -> FloatArray:
        along = v - u
        s = ((p - u) * along).sum(-1) / (along * along).sum(-1)
        return u + np.clip(s, 0, 1)[..., None] * along

    normal = np.cross(b - a, c - a)
    square = (normal * normal).sum(-1)
    s = (np.cross(p - a, c - a) * normal).sum(-1) / square
    t = (np.cross(b - a, p - a) * normal).sum(-1) / square
    inside = (s >= 0) & (t >= 0) & (s + t <= 1)
    face = a + s[..., None] * (b - a) + t[..., None] * (c - a)
    sides = np.stack([on_side(a, b), on_side(b, c), on_side(c, a)])
    best = np.linalg.norm(sides - p, axis=-1).argmin(axis=0)
    side = np.take_along_axis(sides, best[None, ..., None], axis=0)[0]
    return np.where(inside[..., None], face, side)


@dataclass(frozen=True)
class SurfaceEdges:
    """Edges of the surface's triangles where faces of the drawing meet.

    Each stands twice, once from either of its faces, which `faces` numbers.

    Attributes
    ----------
    nodes : (k, 3)
        An end, the middle, the other end.
    faces, opposite_faces : (k,)
        Triangles: the one it is seen from, and the one across.
    turn_angle : (k,) rad
        How much the other face turns up, towards the normal of this one: above 0 in a notch, below
        at a corner that sticks out, 0 where they run into each other.
    normals, into, along : (k, 3)
        Of this face at the middle: outward normal; in the face, away from the edge; along it.
    """

    nodes: IntArray
    faces: IntArray
    opposite_faces: IntArray
    turn_angle: FloatArray
    normals: FloatArray
    into: FloatArray
    along: FloatArray

    def __getitem__(self, which: BoolArray) -> "SurfaceEdges":
        """Return some of them."""
        return SurfaceEdges(*(getattr(self, name)[which] for name in self.__dataclass_fields__))


def find_surface_edges(nodes: MeshNodes) -> SurfaceEdges:
    """Return where faces of the drawing meet; every edge of a closed surface has two triangles."""
    corners = nodes.points[nodes.faces]
    sides = [_side(corners, k) for k in range(3)]
    normal, inward = (np.concatenate([side[k] for side in sides]) for k in range(2))
    count = len(nodes.faces)
    middle = nodes.faces[:, 3:].T.ravel()
    order = np.argsort(middle, kind="stable")
    one, other = order[0::2], order[1::2]
    meet = nodes.face_numbers[one % count] != nodes.face_numbers[other % count]
    one, other = np.concatenate([one[meet], other[meet]]), np.concatenate([other[meet], one[meet]])
    k, f = np.divmod(one, count)
    up = (inward[other] * normal[one]).sum(-1)
    on = -(inward[other] * inward[one]).sum(-1)
    return SurfaceEdges(
        nodes=np.stack([nodes.faces[f, k], nodes.faces[f, 3 + k], nodes.faces[f, (k + 1) % 3]], 1),
        faces=f,
        opposite_faces=other % count,
        turn_angle=np.arctan2(up, on),
        normals=normal[one],
        into=inward[one],
        along=np.cross(normal[one], inward[one]),
    )


def _side(corners: FloatArray, k: int) -> tuple[FloatArray, FloatArray]:
    """Return unit normal, and unit inward direction square to it, at the middle of side k.

    From the derivatives of the quadratic shape functions of triangles (f, 6, 3).
    """
    L = np.array([0.5, 0.5, 0.0])[[(0 - k) % 3, (1 - k) % 3, (2 - k) % 3]]
    a, b, c = L
    by_r = np.array([1 - 4 * a, 4 * b - 1, 0, 4 * (a - b), 4 * c, -4 * c])
    by_s = np.array([1 - 4 * a, 0, 4 * c - 1, -4 * b, 4 * b, 4 * (a - c)])
    r, s = (np.einsum("k,fkx->fx", d, corners) for d in (by_r, by_s))
    normal = np.cross(r, s)
    normal /= np.linalg.norm(normal, axis=-1, keepdims=True)
    along = corners[:, (k + 1) % 3] - corners[:, k]
    inward = np.cross(normal, along)
    return normal, inward / np.linalg.norm(inward, axis=-1, keepdims=True)
