"""A U or L bracket from its sizes, or a bracket of a STEP file, as a solid with named faces.

The CAD kernel works in millimetres, the unit its tolerances and STEP files are made for;
what leaves this module is scaled to metres, with the bearing's centre at the origin.
"""

import itertools
from typing import Any

import numpy as np

from cardan.core.errors import CardanError, DesignError
from cardan.core.units import mm
from cardan.model.bracket import LShape, Shape, StepFileShape, UShape
from cardan.physics.fem.bracket_solid import (
    HOLE_WALL_NAME_SUFFIX,
    MOUNT_FACE_NAME,
    SEAT_FACE_NAME,
    UNASSIGNED_FACE_NAME,
    WASHER_DIAMETER_RATIO,
    WELD_FACE_NAME,
    BracketSolid,
    finish_solid,
)
from cardan.physics.fem.ngsolve_import import import_ngsolve
from cardan.physics.fem.step_file import solid_from_step

_NEAR = 1e-3  # mm: faces of a drawing meet far closer, and none is smaller


def build_solid(part: Shape) -> BracketSolid:
    """Build a bracket.

    Raises
    ------
    DesignError
        If the kernel cannot build the shape, or a STEP file or a face of it is not found.
    MissingDependencyError
        Without the extra `cardan[bracket]`.
    """
    if isinstance(part, StepFileShape):
        return solid_from_step(part)
    body, name = (_u, "U") if isinstance(part, UShape) else (_l, "L")
    try:
        raw = body(part)  # type: ignore[arg-type]
    except CardanError:
        raise
    except Exception as error:  # the kernel raises bare exceptions of its own
        msg = f"the CAD kernel cannot build this {name} bracket ({error}): try a smaller fillet"
        raise DesignError(msg, about="bracket") from error
    raw = _with_washers(raw, part)
    for face in raw.faces:
        face.name = _named(face, part)
    return finish_solid(raw, part.thickness, bolts=len(part.bolt_positions))


def _u(part: UShape) -> Any:
    """Sheet, bends and holes of a U, in mm."""
    occ = import_ngsolve().occ
    t, r, w, h = (v / mm for v in (part.thickness, part.bend_radius, part.width, part.height))
    inner, reach = part.seat_diameter / 2 / mm, part.flange / mm
    leg = inner + t
    end = leg + reach

    def at(y: float, z: float) -> Any:
        return occ.Pnt(-w / 2, y, z)

    def line(*points: tuple[float, float]) -> list[Any]:
        # Where the bend ends at the seat there is no leg, and a line of no length ends the kernel.
        pairs = [p for p in itertools.pairwise(points) if np.hypot(*np.subtract(*p)) > _NEAR]
        return [occ.Segment(at(*a), at(*b)) for a, b in pairs]

    def arc(centre: tuple[float, float], radius: float, start: float, end: float) -> Any:
        angles = np.radians([start, (start + end) / 2, end])
        return occ.ArcOfCircle(
            *(at(centre[0] + radius * np.cos(a), centre[1] + radius * np.sin(a)) for a in angles)
        )

    bend = h - t - r
    outline = [
        arc((0, 0), inner, 180, 360),
        *line((inner, 0), (inner, bend)),
        arc((leg + r, bend), r + t, 180, 90),
        *line((leg + r, h), (end, h), (end, h - t), (leg + r, h - t)),
        arc((leg + r, bend), r, 90, 180),
        *line((leg, bend), (leg, 0)),
        arc((0, 0), leg, 0, -180),
        *line((-leg, 0), (-leg, bend)),
        arc((-leg - r, bend), r, 0, 90),
        *line((-leg - r, h - t), (-end, h - t), (-end, h), (-leg - r, h)),
        arc((-leg - r, bend), r + t, 90, 0),
        *line((-inner, bend), (-inner, 0)),
    ]
    sheet = occ.Face(occ.Wire(outline)).Extrude(w * occ.X)
    if part.gusset:
        thick, down = part.gusset / mm, part.gusset_height / mm
        toe = thick / 2 + _NEAR
        mid, far = leg - t / 2, leg + 0.85 * reach  # ribs start inside the sheet, to fuse with it
        nose = 2 * part.fillet / mm  # a fillet as high as the end it runs round would swallow it
        for side in (-1, 1):
            corners = [(leg + r, h - t / 2), (far, h - t / 2), (far, h - t - nose),
                       (leg + nose, h - t - down), (mid, h - t - down), (mid, bend)]  # fmt: skip
            quarter = [(leg + r - (r + t / 2) * np.cos(a), bend + (r + t / 2) * np.sin(a))
                       for a in np.radians([0, 45, 90])]  # fmt: skip
            rim = [occ.Pnt(-thick / 2, side * y, z) for y, z in corners]
            inside = [occ.Pnt(-thick / 2, side * y, z) for y, z in quarter]
            edges = [occ.Segment(a, b) for a, b in itertools.pairwise(rim)]
            rib = occ.Face(occ.Wire([*edges, occ.ArcOfCircle(*inside)]))
            sheet = sheet + rib.Extrude(occ.Vec(thick, 0, 0))
        seams = [
            e for e in sheet.edges
            if max(abs(p.x) for p in (e.start, e.center, e.end)) < toe
            and _on_sheet(e, leg=leg, under=h - t, bend=(leg + r, bend, r))
        ]  # fmt: skip
        sheet = sheet.MakeFillet(seams, part.fillet / mm)
        for face in sheet.faces:
            # The kernel calls the faces it makes of a seam "fillet"; here each is a weld.
            face.name = WELD_FACE_NAME if face.name == "fillet" else UNASSIGNED_FACE_NAME
    return _drilled(sheet, part)


def _on_sheet(edge: Any, *, leg: float, under: float, bend: tuple[float, float, float]) -> bool:
    """Whether an edge lies where a rib meets the outside of a U's sheet."""
    y0, z0, r = bend
    for p in (edge.start, edge.center, edge.end):
        y, z = abs(p.y), p.z
        flat = abs(y - leg) < _NEAR or abs(z - under) < _NEAR
        # The centre of an arc's curve lies off the arc, on its inner side.
        curved = y <= y0 + _NEAR and z >= z0 - _NEAR and abs(np.hypot(y - y0, z - z0) - r) < 0.1 * r
        if not (flat or curved):
            return False
    return True


def _l(part: LShape) -> Any:
    """Plate, wall, root, bore and holes of an L, in mm."""
    occ = import_ngsolve().occ
    t, h, w = part.thickness / mm, part.height / mm, part.width / mm
    wall, bore = part.wall_width / mm, part.seat_diameter / 2 / mm
    front, foot = -t / 2, -bore - part.rim / mm
    rear = front + part.depth / mm
    plate = occ.Box(occ.Pnt(front, -w / 2, h - t), occ.Pnt(rear, w / 2, h))
    hung = occ.Box(occ.Pnt(front, -wall / 2, foot), occ.Pnt(-front, wall / 2, h))
    low = [e for e in hung.edges if abs(e.center.z - foot) < _NEAR and abs(e.center.x) < _NEAR]
    hung = hung.MakeFillet(low, 0.6 * min(wall / 2, part.rim / mm + bore))
    body = plate + hung
    if part.gusset:
        thick, down = part.gusset / mm, part.gusset_height / mm
        back = -front + 0.85 * (rear + front)
        for side in (-1, 1):
            y = side * (part.gusset_face_offset / mm - thick / 2) - thick / 2
            corners = [(0.0, h - t / 2), (back, h - t / 2), (back, h - 1.5 * t),
                       (-front + t / 2, h - t - down), (0.0, h - t - down)]  # fmt: skip
            points = [occ.Pnt(x, y, z) for x, z in corners]
            ring = [*points, points[0]]
            wire = occ.Wire([occ.Segment(a, b) for a, b in itertools.pairwise(ring)])
            body = body + occ.Face(wire).Extrude(occ.Vec(0, thick, 0))
    root = [
        e for e in body.edges
        if abs(e.center.x + front) < _NEAR and abs(e.center.z - h + t) < _NEAR
        and abs(e.start.z - e.end.z) < _NEAR
    ]  # fmt: skip
    body = body.MakeFillet(root, part.fillet / mm)
    x_axis = occ.Pnt(front - 1, 0, 0)
    body = body - occ.Cylinder(x_axis, occ.X, r=bore, h=t + 2)
    return _drilled(body, part)


def _drilled(body: Any, part: UShape | LShape) -> Any:
    """Drill the bolt holes."""
    occ = import_ngsolve().occ
    t, r = part.thickness / mm, part.bolt_diameter / 2 / mm
    for place in part.bolt_positions:
        x, y, z = (v / mm for v in place)
        body = body - occ.Cylinder(occ.Pnt(x, y, z - t - 1), occ.Z, r=r, h=t + 2)
    return body


def _with_washers(body: Any, part: UShape | LShape) -> Any:
    """Imprint the ring each bolt presses against the frame on the mounting plane."""
    occ = import_ngsolve().occ
    r = part.bolt_diameter / 2 / mm
    rings: list[Any] = []
    for place in part.bolt_positions:
        x, y, z = (v / mm for v in place)
        plane = occ.WorkPlane(occ.Axes((x, y, z), occ.Z, occ.X))
        disc = plane.Circle(WASHER_DIAMETER_RATIO * r).Face()
        rings.append(disc - occ.Cylinder(occ.Pnt(x, y, z - 1), occ.Z, r=r, h=2))
    return occ.Glue([body, *rings])


def _named(face: Any, part: UShape | LShape) -> str:
    """Name a face of a parametric bracket by where it lies."""
    low, high = face.bounding_box
    low, high = np.array([low.x, low.y, low.z]), np.array([high.x, high.y, high.z])
    for k, place in enumerate(part.bolt_positions, 1):
        across = np.abs(np.stack([low, high])[:, :2] - np.asarray(place[:2]) / mm).max()
        if across < WASHER_DIAMETER_RATIO * part.bolt_diameter / 2 / mm + 0.1:
            return (
                f"bolt {k}"
                if high[2] - low[2] < _NEAR * 100
                else f"bolt {k}{HOLE_WALL_NAME_SUFFIX}"
            )
    if face.name == WELD_FACE_NAME:
        return WELD_FACE_NAME
    if low[2] > part.height / mm - _NEAR * 100:
        return MOUNT_FACE_NAME
    bore = part.seat_diameter / 2 / mm
    u = isinstance(part, UShape)
    half, top = (part.width if u else part.thickness) / 2 / mm, 0.0 if u else bore
    reach = np.abs(np.stack([low, high])).max(axis=0)
    # The kernel's boxes are a little loose, so the seat is found to a tenth of a millimetre. A
    # U's ends at the axis: the legs of a low one reach no farther than its round.
    if reach[0] < half + 0.1 and max(reach[1], -low[2]) < bore + 0.1 and high[2] < top + 0.1:
        return SEAT_FACE_NAME
    return UNASSIGNED_FACE_NAME
