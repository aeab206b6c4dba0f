"""From a bracket's drawing, or a STEP file, to a solid whose seat and bolt faces have names.

The CAD kernel works in millimetres, the unit its tolerances and STEP files are made for;
what leaves this module is scaled to metres, with the bearing's centre at the origin.
"""

import itertools
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from cardan.base.errors import CardanError, DesignError
from cardan.base.units import Metre, mm
from cardan.bracket.engine import engine
from cardan.model.bracket import Hold, LShape, Pick, Shape, StepShape, UShape, Vector

SEAT = "seat"
FREE = "free"
MOUNT = "mount"
"""The plane that lies against the frame, without the washers' rings."""
WELD = "weld"
WALL = " wall"
"""Ends the name of a bolt hole's wall; the ring about it is called after the bolt alone."""
WASHER = 2.0
"""Diameter of the ring a bolt bears on, over its hole's."""

_NEAR = 1e-3  # mm: faces of a drawing meet far closer, and none is smaller


@dataclass(frozen=True, slots=True, kw_only=True)
class Picked:
    """Faces of a STEP file that a pick found: how many, their area m², a bore's radius m or 0."""

    name: str
    faces: int
    area: float
    radius: Metre = 0.0
    axis: Vector = (0.0, 0.0, 0.0)


@dataclass(frozen=True)
class Solid:
    """A solid in metres, the bearing's centre at its origin.

    `shape` is the kernel's; its faces are called "seat", "bolt 1", "bolt 1 wall", ..., "mount",
    "weld" or "free". `thickness` is that of its walls, `volume` in m³. `found` says what was
    found of the picks in a STEP file.
    """

    shape: Any
    bolts: tuple[str, ...]
    thickness: Metre
    volume: float
    found: tuple[Picked, ...] = ()

    def held(self, hold: Hold = "sliding") -> dict[str, str]:
        """Return the faces that are held, with the axes they may not move along.

        The bolts at least hold the washers' rings against the frame and the holes' walls along
        it; at most the whole plane is one with the frame. A real flange, which slides a
        little and lifts off a little, is as stiff as the first or stiffer, as the second or
        softer: each frees, or holds, all the other does and more.
        """
        names = {face.name for face in self.shape.faces}
        walls = [bolt + WALL for bolt in self.bolts if bolt + WALL in names]
        rings = [bolt for bolt in self.bolts if bolt in names]
        if hold == "clamped" or not (walls and rings):
            plane = [MOUNT] if hold == "clamped" and MOUNT in names else []
            return dict.fromkeys([*rings, *walls, *plane], "xyz")
        up = "xyz"[self.upright]
        return dict.fromkeys(rings, up) | dict.fromkeys(walls, "xyz".replace(up, ""))

    @property
    def upright(self) -> int:
        """Axis along which the bolts pull: of x, y, z the one the rings do not reach along."""
        boxes = [face.bounding_box for face in self.shape.faces if face.name in self.bolts]
        low = np.array([[a.x, a.y, a.z] for a, _ in boxes])
        high = np.array([[b.x, b.y, b.z] for _, b in boxes])
        return int((high - low).sum(axis=0).argmin())

    def write(self, path: Path) -> None:
        """Write a STEP file in millimetres; faces keep their names."""
        occ = engine().occ
        self.shape.Scale(occ.Pnt(0, 0, 0), 1 / mm).WriteStep(str(path))


def solid(part: Shape) -> Solid:
    """Build a bracket.

    Raises
    ------
    DesignError
        If the kernel cannot build the shape, or a STEP file or a face of it is not found.
    NotInstalled
        Without the extra `cardan[bracket]`.
    """
    if isinstance(part, StepShape):
        return _from_step(part)
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
    return _finished(raw, part.thickness, bolts=len(part.places))


def _u(part: UShape) -> Any:
    """Sheet, bends and holes of a U, in mm."""
    occ = engine().occ
    t, r, w, h = (v / mm for v in (part.thickness, part.bend_radius, part.width, part.height))
    inner, reach = part.seat_diameter / 2 / mm, part.flange / mm
    leg = inner + t
    end = leg + reach

    def at(y: float, z: float) -> Any:
        return occ.Pnt(-w / 2, y, z)

    def line(*points: tuple[float, float]) -> list[Any]:
        return [occ.Segment(at(*a), at(*b)) for a, b in itertools.pairwise(points)]

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
            face.name = WELD if face.name == "fillet" else FREE
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
    occ = engine().occ
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
            y = side * (part.brace / mm - thick / 2) - thick / 2
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
    occ = engine().occ
    t, r = part.thickness / mm, part.bolt_diameter / 2 / mm
    for place in part.places:
        x, y, z = (v / mm for v in place)
        body = body - occ.Cylinder(occ.Pnt(x, y, z - t - 1), occ.Z, r=r, h=t + 2)
    return body


def _with_washers(body: Any, part: UShape | LShape) -> Any:
    """Imprint the ring each bolt presses against the frame on the mounting plane."""
    occ = engine().occ
    r = part.bolt_diameter / 2 / mm
    rings: list[Any] = []
    for place in part.places:
        x, y, z = (v / mm for v in place)
        plane = occ.WorkPlane(occ.Axes((x, y, z), occ.Z, occ.X))
        disc = plane.Circle(WASHER * r).Face()
        rings.append(disc - occ.Cylinder(occ.Pnt(x, y, z - 1), occ.Z, r=r, h=2))
    return occ.Glue([body, *rings])


def _named(face: Any, part: UShape | LShape) -> str:
    """Name a face of a parametric bracket by where it lies."""
    low, high = face.bounding_box
    low, high = np.array([low.x, low.y, low.z]), np.array([high.x, high.y, high.z])
    for k, place in enumerate(part.places, 1):
        across = np.abs(np.stack([low, high])[:, :2] - np.asarray(place[:2]) / mm).max()
        if across < WASHER * part.bolt_diameter / 2 / mm + 0.1:
            return f"bolt {k}" if high[2] - low[2] < _NEAR * 100 else f"bolt {k}{WALL}"
    if face.name == WELD:
        return WELD
    if low[2] > part.height / mm - _NEAR * 100:
        return MOUNT
    bore = part.seat_diameter / 2 / mm
    half = (part.width if isinstance(part, UShape) else part.thickness) / 2 / mm
    reach = np.abs(np.stack([low, high])).max(axis=0)
    # The kernel's boxes are a little loose, so the seat is told by a tenth of a millimetre.
    if reach[0] < half + 0.1 and max(reach[1], reach[2]) < bore + 0.1:
        return SEAT
    return FREE


def _from_step(part: StepShape) -> Solid:
    """Read a STEP file and find the faces the user picked."""
    occ = engine().occ
    if not Path(part.path).is_file():
        msg = f"no STEP file at {part.path}"
        raise DesignError(msg, about="bracket.step")
    try:
        body = occ.OCCGeometry(part.path).shape
    except Exception as error:  # the kernel raises bare exceptions of its own
        msg = f"{part.path} is not a STEP file the CAD kernel can read ({error})"
        raise DesignError(msg, about="bracket.step") from error
    faces = list(body.faces)
    found = [(SEAT, part.seat), *((f"bolt {k}", (p,)) for k, p in enumerate(part.bolts, 1))]
    chosen: dict[int, str] = {}
    for name, picks in found:
        for k in (k for pick in picks for k in _picked(faces, pick, part.path)):
            if chosen.get(k, name) != name:
                msg = f"the same face of {part.path} is picked as {chosen[k]} and as {name}"
                raise DesignError(msg, about="bracket.step")
            chosen[k] = name
    for k, face in enumerate(faces):
        face.name = chosen.get(k, FREE)
    x, y, z = (-v / mm for v in part.centre)
    return _finished(body.Move(occ.Vec(x, y, z)), part.thickness, bolts=len(part.bolts))


def _picked(faces: list[Any], pick: Pick, path: str) -> Iterable[int]:
    """Places of the faces a pick means."""
    if pick.name:
        found = [k for k, face in enumerate(faces) if face.name == pick.name]
        if not found:
            names = sorted({face.name for face in faces if face.name})
            has = f"its faces are called {', '.join(names)}" if names else "none of its has a name"
            msg = f"no face of {path} is called {pick.name!r}: {has}; or pick by a point on it"
            raise DesignError(msg, about="bracket.step")
        return found
    assert pick.near is not None  # Pick refuses one without both
    occ = engine().occ
    point = [v / mm for v in pick.near]
    probe = occ.Vertex(occ.Pnt(*point))
    distances = [face.Distance(probe) for face in faces]
    best = int(np.argmin(distances))
    if distances[best] > 1.0:
        msg = (
            f"no face of {path} lies within 1 mm of {tuple(round(v, 3) for v in point)} mm: "
            f"the nearest is {distances[best]:.3g} mm away"
        )
        raise DesignError(msg, about="bracket.step")
    return [best]


def _finished(body: Any, thickness: Metre, *, bolts: int) -> Solid:
    """Scale to metres and make sure of one sound solid with all its faces."""
    occ = engine().occ
    solids = list(body.solids)
    if len(solids) != 1 or not solids[0].mass > 0:
        msg = f"a bracket must be one solid, this shape has {len(solids)}: its parts do not meet"
        raise DesignError(msg, about="bracket")
    shape = solids[0].Scale(occ.Pnt(0, 0, 0), mm)
    held = tuple(f"bolt {k}" for k in range(1, bolts + 1))
    names = {face.name for face in shape.faces}
    missing = [name for name in (SEAT, *held) if name not in names]
    if missing:
        msg = f"the shape has lost its {', '.join(missing)}: sizes overlap there"
        raise DesignError(msg, about="bracket")
    return Solid(shape=shape, bolts=held, thickness=thickness, volume=float(shape.mass))
