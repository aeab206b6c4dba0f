"""Round faces of a solid: their cylinders, bores, and the element sizes on them.

Points and lengths are in mm, the unit of the CAD kernel.
"""

from collections.abc import Iterable
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from cardan.core.units import Metre
from cardan.physics.fem.meshing import ELEMENTS_PER_CURVATURE_RADIUS
from cardan.physics.fem.ngsolve_import import import_ngsolve

_SMALL = 0.4
"""Of its thickness, a round that breaks a corner of it; an estimate knows larger ones as bends."""
_WIDE = 3.0
"""Times its thickness, a round whose elements that thickness bounds, and not its radius alone."""


class Cylinder(NamedTuple):
    """A round face: a point of its axis, the axis' direction, its radius, in mm."""

    point: npt.NDArray[np.float64]
    axis: npt.NDArray[np.float64]
    radius: float


def max_element_size_on_face(face: Any, thickness: Metre) -> Metre:
    """Longest edge of an element on a face of a sheet: endless but on a wide round.

    An arc of L rises by L²/8r over its chord. Where that is much more than a tenth of the sheet,
    elements of its other side come through, turned inside out.
    """
    of = cylinder_of_face(face)
    if of is None or of.radius < _WIDE * thickness:
        return np.inf
    return float(np.sqrt(0.8 * of.radius * thickness))


def corner_round_element_size(face: Any, thickness: Metre) -> Metre:
    """Edge of the elements on a round that breaks a sheet's corner: endless on any other face."""
    of = cylinder_of_face(face)
    return (
        of.radius / ELEMENTS_PER_CURVATURE_RADIUS
        if of and of.radius < _SMALL * thickness
        else np.inf
    )


def cylinder_of_face(face: Any) -> Cylinder | None:
    """Return what cylinder a face is part of; None if of none.

    The kernel gives no kinds of surfaces, so a surface is a cylinder where its normals at
    four places meet in one line, at one distance from it. A spline may go round with its second
    parameter, from 0 to 1.
    """
    return _cylinder_at(face, [(u, v) for u in (0.3, 1.1, 2.3, 4.0) for v in (0.0, 1.0)]) or (
        _cylinder_at(face, [(u, v) for v in (0.1, 0.3, 0.6, 0.9) for u in (0.0, 1.0)])
    )


def _cylinder_at(face: Any, at: list[tuple[float, float]]) -> Cylinder | None:
    """Return the cylinder of a face by its normals at these parameters: pairs along its axis."""
    try:
        found = [face.surf.D1(u, v) for u, v in at]
    except Exception:  # noqa: BLE001  a surface that is not known so far out is no cylinder
        return None
    points, one, other = (np.array([[d[k].x, d[k].y, d[k].z] for d in found]) for k in range(3))
    normals = np.cross(one, other)
    size = np.linalg.norm(normals, axis=1, keepdims=True)
    if size.min() < 1e-9:
        return None
    normals /= size
    axis = np.cross(normals[0], normals[2])
    size = np.linalg.norm(axis)
    if size < 1e-9:
        return None
    axis = axis / size
    if np.abs(normals @ axis).max() > 1e-9:
        return None
    # Two normals in the plane across meet at the axis: p0 + s n0 = p2 + t n2.
    flat = points - (points @ axis)[:, None] * axis
    s, _ = np.linalg.lstsq(np.stack([normals[0], -normals[2]], 1), flat[2] - flat[0], rcond=None)[0]
    centre = flat[0] + s * normals[0]
    radii = np.linalg.norm(flat - centre, axis=1)
    if np.ptp(radii) > 1e-6 * radii.max() or radii.min() < 1e-6:
        return None
    edges = np.array([[e.start.x, e.start.y, e.start.z] for e in face.edges])
    off = edges - centre - ((edges - centre) @ axis)[:, None] * axis
    if np.abs(np.linalg.norm(off, axis=1) - radii[0]).max() > 1e-3 * radii[0]:
        return None
    return Cylinder(centre, axis, float(radii[0]))


def is_outside_of_round(body: Any, face: Any, of: Cylinder) -> bool:
    """Whether a body lies within a round face of it, on the side of the axis: no hole's does."""
    middle = np.array([face.center.x, face.center.y, face.center.z])
    foot = of.point + ((middle - of.point) @ of.axis) * of.axis
    out = middle - foot
    if np.linalg.norm(out) < 1e-3 * of.radius:  # a whole turn: any side will do
        out = np.cross(of.axis, np.eye(3)[np.abs(of.axis).argmin()])
    within = foot + (of.radius - 0.05) * out / np.linalg.norm(out)
    occ = import_ngsolve().occ
    return bool(body.Distance(occ.Vertex(occ.Pnt(*map(float, within)))) < 1e-6)


def bore_faces(faces: list[Any], picked: int) -> Iterable[int]:
    """Yield the faces that make one bore with a picked one: coaxial, as wide, and meeting."""
    first = cylinder_of_face(faces[picked])
    if first is None:
        return
    row = [picked]
    left = set(range(len(faces))) - {picked}
    while row:
        here = row.pop()
        yield here
        for k in sorted(left):
            other = cylinder_of_face(faces[k])
            if other is None or abs(other.radius - first.radius) > 1e-3:
                continue
            if abs(abs(other.axis @ first.axis) - 1) > 1e-6:
                continue
            apart = other.point - first.point
            apart = apart - (apart @ first.axis) * first.axis
            if np.linalg.norm(apart) < 1e-3 and faces[k].Distance(faces[here]) < 1e-3:
                left.discard(k)
                row.append(k)
